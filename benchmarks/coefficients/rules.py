"""Nodes and weights of Gauss's quadrature, and weights of differences, with mpmath."""

from fractions import Fraction
from math import factorial

from mpmath import mp, mpf

# Digits beside those asked for: zeros and moments of a rule of ten points lose 15.
_MORE = 40


def gauss(count, power=0):
    """Nodes and weights on (0, 1) for the weight x^power, ascending.

    The nodes are the eigenvalues of the matrix of the three-term recurrence of Jacobi's polynomials
    P^(0, power) of 2 x - 1 (Golub & Welsch 1969; DLMF 18.9.2); the weights give the first moments.
    """
    with mp.extradps(_MORE):
        recurrence = mp.zeros(count)
        for n in range(count):
            twice = 2 * n + power
            shift = mpf(power**2) / (twice * (twice + 2)) if twice else mpf(0)
            recurrence[n, n] = (1 + shift) / 2
            if n:
                square = mpf((n * (n + power)) ** 2) / (twice**2 * (twice + 1) * (twice - 1))
                recurrence[n, n - 1] = recurrence[n - 1, n] = mp.sqrt(square)
        nodes = sorted(mp.eigsy(recurrence, eigvals_only=True))
        powers = mp.matrix([[x**i for x in nodes] for i in range(count)])
        moments = mp.matrix([mpf(1) / (power + 1 + i) for i in range(count)])
        return nodes, list(mp.lu_solve(powers, moments))


def difference_weights(places, derivative):
    """Weights of values at whole places for a derivative at 0, exact for polynomials.

    A weight is that derivative of the polynomial that is 1 at its place and 0 at the others.
    """
    weights = []
    for place in places:
        polynomial = [Fraction(1)]
        for other in places:
            if other != place:
                raised = [Fraction(0), *polynomial]
                lowered = [*(other * x for x in polynomial), Fraction(0)]
                polynomial = [
                    (a - b) / (place - other) for a, b in zip(raised, lowered, strict=True)
                ]
        weight = polynomial[derivative] * factorial(derivative)
        weights.append(mpf(weight.numerator) / weight.denominator)
    return weights


def of_kind(first, second, count, width):
    """Rows p_0, p_1, ... of p_(n+1) = 2 c p_n - p_(n-1): `width` coefficients, lowest first."""
    rows = [_padded(first, width), _padded(second, width)]
    while len(rows) < count:
        doubled = [0, *(2 * x for x in rows[-1][:-1])]
        rows.append([a - b for a, b in zip(doubled, rows[-2], strict=True)])
    return rows[:count]


def _padded(row, width):
    return [*row, *[0] * (width - len(row))]
