"""Polynomials of least maximum error, and largest errors of given polynomials, with mpmath.

The exchange algorithm of Remez (1934): on n + 1 points the polynomial of n coefficients whose
weighted error has one size there and alternating signs; then the points move to the extrema of its
error, until that size is the largest error.  By de la Vallee Poussin's theorem that polynomial is
the best one.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

from mpmath import mp, mpf

# Samples of the error for each coefficient; the extrema lie further apart.
_SAMPLES = 40
_MOST_EXCHANGES = 20
# How far the largest error may stand above the levelled one at the end, relatively.
_LEVEL = 1e-8
# Parabolas through three values refine an extremum, each over a hundredth of the width before.
_PARABOLAS = 3


@dataclass(frozen=True)
class PolynomialFit:
    """Polynomials in x of `count` coefficients for a function, lowest power first.

    The error counts as weight(x) (function(x) - polynomial(x)) on start <= x <= stop; the weight is
    zero at isolated points only.  `start` and `stop` are text or fractions that mpmath takes.
    """

    function: Callable
    weight: Callable
    count: int
    start: str
    stop: str

    def error(self, coefficients):
        """The largest error of a polynomial."""
        return max(abs(e) for _, e in self._extrema(coefficients))

    def difference(self, one, other):
        """The largest weighted difference of two polynomials."""
        rest = [mpf(a) - mpf(b) for a, b in zip(one, other, strict=True)]
        nothing = PolynomialFit(lambda x: 0, self.weight, self.count, self.start, self.stop)
        return nothing.error(rest)

    @cached_property
    def best(self):
        """The coefficients of least maximum error, and that error."""
        points = self._chebyshev_points(self.count + 1)
        for _ in range(_MOST_EXCHANGES):
            coefficients, level = self._levelled(points)
            extrema = self._extrema(coefficients)
            largest = max(abs(e) for _, e in extrema)
            if largest <= level * (1 + _LEVEL):
                return coefficients, largest
            points = _alternating(extrema, self.count + 1)
        raise ArithmeticError(
            f"the exchange has not converged after {_MOST_EXCHANGES} rounds; give more digits."
        )

    def through_chebyshev_points(self):
        """The coefficients of the polynomial through the function at the zeros of T_count."""
        points = self._chebyshev_points(self.count)
        powers = mp.matrix([[x**k for k in range(self.count)] for x in points])
        return list(mp.lu_solve(powers, mp.matrix([self.function(x) for x in points])))

    def _ends(self):
        return mp.mpmathify(self.start), mp.mpmathify(self.stop)

    def _chebyshev_points(self, count):
        start, stop = self._ends()
        angles = [mpf(2 * k + 1) / (2 * count) for k in range(count)]
        return [(start + stop - (stop - start) * mp.cospi(a)) / 2 for a in angles]

    def _levelled(self, points):
        """The polynomial whose errors at n + 1 points have one size and alternating signs."""
        rows = [
            [x**k for k in range(self.count)] + [(-1) ** i / self.weight(x)]
            for i, x in enumerate(points)
        ]
        values = mp.matrix([self.function(x) for x in points])
        *coefficients, level = mp.lu_solve(mp.matrix(rows), values)
        return coefficients, abs(level)

    def _extrema(self, coefficients):
        """Points and values of the local extrema of the error, ends included, in order."""
        kept = [mpf(c) for c in coefficients]

        def error(x):
            return self.weight(x) * (self.function(x) - horner(kept, x))

        x = [sample[0] for sample in self._samples]
        e = [weight * (value - horner(kept, each)) for each, value, weight in self._samples]
        found = [(x[0], e[0])]
        for k in range(1, len(x) - 1):
            side = 1 if e[k] > 0 else -1
            if side * e[k - 1] <= side * e[k] > side * e[k + 1]:
                found.append(_refined(error, x[k - 1 : k + 2], e[k - 1 : k + 2]))
        return [*found, (x[-1], e[-1])]

    @cached_property
    def _samples(self):
        """Points at which every error is taken, with the function and the weight there."""
        start, stop = self._ends()
        count = _SAMPLES * (self.count + 1)
        angles = [mpf(k) / count for k in range(count + 1)]
        x = [(start + stop - (stop - start) * mp.cospi(a)) / 2 for a in angles]
        return [(each, self.function(each), self.weight(each)) for each in x]


def power_series(coefficient, terms=45):
    """The sum of coefficient(n) x^n as a function of x; `terms` of them, for x well below 1."""
    kept = []

    def value(x):
        if not kept:
            kept.extend(coefficient(n) for n in range(terms))
        return horner(kept, x)

    return value


def horner(coefficients, x):
    """The sum of coefficients[k] x^k."""
    total = mpf(0)
    for c in reversed(coefficients):
        total = total * x + c
    return total


def _refined(error, x, errors):
    """The extremum near the middle one of three points, and the error there, from the errors."""
    (low, middle, high), (left, here, right) = x, errors
    for _ in range(_PARABOLAS):
        p, q = (middle - low) * (here - right), (middle - high) * (here - left)
        if p == q:
            break
        middle -= ((middle - low) * p - (middle - high) * q) / (2 * (p - q))
        width = (high - low) / 200
        low, high = middle - width, middle + width
        left, here, right = error(low), error(middle), error(high)
    if x[0] < middle < x[2] and abs(here) >= abs(errors[1]):
        return middle, here
    return x[1], errors[1]


def _alternating(extrema, count):
    """`count` neighbouring extrema of alternating signs, the largest of each run of one sign."""
    kept = []
    for x, e in extrema:
        if e == 0:
            continue
        if kept and (e > 0) == (kept[-1][1] > 0):
            if abs(e) > abs(kept[-1][1]):
                kept[-1] = x, e
        else:
            kept.append((x, e))
    while len(kept) > count:
        kept.pop(0 if abs(kept[0][1]) < abs(kept[-1][1]) else -1)
    if len(kept) < count:
        raise ArithmeticError(f"{len(kept)} extrema for {count} points; give more samples.")
    return [x for x, _ in kept]
