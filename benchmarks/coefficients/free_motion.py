"""The free motion over one piece in high precision: truncation errors of series and quadrature.

Notation and formulas are those of the docstring of attitude/_solver/step.py; moments ascending,
time from the state at 0.
"""

from fractions import Fraction
from random import Random

from mpmath import mp, mpf

from benchmarks.coefficients import rules
from benchmarks.coefficients.minimax import horner

# Terms of the series and points of Gauss-Legendre for the reference motion: their truncation error
# on the longest pieces is 1e-41.
_TERMS = 22
_POINTS = 14
# Sets of moments and states that are tried; a fixed seed, so that runs print the same numbers.
_STATES = 60
_SEED = 2007


def sine_rows(degree):
    """S(h)/h - 1 in powers of s = a + b and p = a b, by power of p: exact fractions.

    S'' = -s S + 2 p S^3 with S(0) = 0, S'(0) = 1, in units in which h is 1; a and b have degree 1,
    p degree 2.  A row holds the powers of s from 0 on (in the first from 1 on), up to `degree`.
    """
    series = [{(0, 0): Fraction(1)}]
    for n in range(degree):
        squares = [_convolved(series, series, m) for m in range(n)]
        total = {}
        _add(total, series[n], (1, 0), Fraction(-1))
        for m in range(n):
            _add(total, _times(squares[m], series[n - 1 - m]), (0, 1), Fraction(2))
        divisor = (2 * n + 3) * (2 * n + 2)
        series.append({key: value / divisor for key, value in total.items()})
    terms = {key: value for each in series[1:] for key, value in each.items()}
    rows = [[terms[k, m] for k in range(degree - 2 * m + 1)] for m in range(1, degree // 2 + 1)]
    return [[terms[k, 0] for k in range(1, degree + 1)], *rows]


def _convolved(one, other, n):
    total = {}
    for k in range(n + 1):
        _add(total, _times(one[k], other[n - k]), (0, 0), Fraction(1))
    return total


def _times(one, other):
    total = {}
    for (i, j), x in one.items():
        _add(total, other, (i, j), x)
    return total


def _add(total, terms, shift, factor):
    for (i, j), x in terms.items():
        key = i + shift[0], j + shift[1]
        total[key] = total.get(key, 0) + factor * x


def sine_coefficients(e1, e3, count=_TERMS):
    """S(t) = sum of a_n t^(2n + 1): numbers a_n."""
    a, squares = [mpf(1)], []
    for n in range(count - 1):
        total = -(e1 + e3) * a[n]
        if n:
            squares.append(sum(a[i] * a[n - 1 - i] for i in range(n)))
            total += 2 * e1 * e3 * sum(squares[i] * a[n - 1 - i] for i in range(n))
        a.append(total / ((2 * n + 3) * (2 * n + 2)))
    return a


class ExactPiece:
    """A state of a body, with the exact motion from it."""

    def __init__(self, moments, rates):
        i1, i2, i3 = self.moments = moments
        w1, w2, w3 = self.rates = rates
        k1, k2, k3 = (i2 - i3) / i1, (i3 - i1) / i2, (i1 - i2) / i3
        self.kappa = k1 * k3 * w2**2
        self.e1, self.e3 = self.kappa - k2 * k3 * w1**2, self.kappa - k1 * k2 * w3**2
        self.change = k1 * w2 * w3, k2 * w3 * w1, k3 * w1 * w2
        momentum = [i * w for i, w in zip(moments, rates, strict=True)]
        size = mp.norm(momentum)
        self.axis = [m / size for m in momentum]
        self.momentum = size
        self.mean = _dot(momentum, rates) / size
        # how fast the state changes, as an angle over time: what limits a piece
        squares = _dot(self.change, self.change) / _dot(rates, rates)
        self.pace = mp.sqrt(self.e1 + self.e3 + squares)
        self.series = sine_coefficients(self.e1, self.e3)

    def sine(self, t, terms=_TERMS):
        """S(t)."""
        return t * horner(self.series[:terms], t * t)

    def area_rate(self, s):
        """chi' - 2 T/L at S = s, and dS/dt there."""
        ss = s * s
        c1, c3, d = mp.sqrt(1 - self.e1 * ss), mp.sqrt(1 - self.e3 * ss), 1 - self.kappa * ss
        (w1, w2, w3), (r1, r2, r3) = self.rates, self.change
        w = [(w1 * c3 + r1 * s * c1) / d, (w2 * c1 * c3 + r2 * s) / d, (w3 * c1 + r3 * s * c3) / d]
        now = [i * x / self.momentum for i, x in zip(self.moments, w, strict=True)]
        cosine = _dot(now, self.axis)
        return (_dot(w, self.axis) - self.mean * cosine) / (1 + cosine), c1 * c3


def _dot(a, b):
    return sum(x * y for x, y in zip(a, b, strict=True))


def states():
    """Pieces of bodies from needles to near a sphere, one rate small in every fourth."""
    random = Random(_SEED)
    for n in range(_STATES):
        if n % 3 == 0:
            parts = [mpf(10) ** -random.uniform(0, 4) for _ in range(3)]
        elif n % 3 == 1:
            thin = mpf(10) ** -random.uniform(0, 6)
            parts = [thin, thin * random.uniform(0, 1), mpf(1)]
        else:
            parts = [1 + mpf(random.uniform(0, 0.2)) for _ in range(3)]
        moments = sorted((parts[0] + parts[1], parts[1] + parts[2], parts[2] + parts[0]))
        rates = [mpf(random.gauss(0, 1)) for _ in range(3)]
        # in the mean of one size, of one energy or of one momentum about each axis
        power = mpf(n // 3 % 3) / 2
        rates = [w / i**power for w, i in zip(rates, moments, strict=True)]
        if n % 4 == 3:
            rates[random.randrange(3)] *= mpf(10) ** -random.uniform(1, 6)
        yield ExactPiece([i / moments[2] for i in moments], rates)


def error_of_step(points, weights, piece):
    """The largest error of chi/2 by a rule on (0, 1) in S, over pieces this long, of the angle."""
    worst = mpf(0)
    exact = rules.gauss(_POINTS)
    for motion in states():
        s = motion.sine(piece / motion.pace)

        def part(x, s=s, motion=motion):
            value, slope = motion.area_rate(s * x)
            return value / slope

        found = sum(mpf(w) * part(mpf(x)) for x, w in zip(points, weights, strict=True))
        area = sum(w * part(x) for x, w in zip(*exact, strict=True))
        worst = max(worst, abs(s * (found - area)) / (2 * piece))
    return worst


def error_of_flow(points, weights, terms, piece):
    """The largest error of chi by a rule on (0, 1) in time and so many terms of S.

    It is a part of the piece and the angle turned, together.
    """
    worst = mpf(0)
    exact = rules.gauss(_POINTS)
    for motion in states():
        h = piece / motion.pace

        def rate(x, count, h=h, motion=motion):
            return motion.mean + motion.area_rate(motion.sine(h * x, count))[0]

        found = sum(w * rate(x, terms) for x, w in zip(points, weights, strict=True))
        chi = sum(w * rate(x, _TERMS) for x, w in zip(*exact, strict=True))
        turned = h * mp.norm(motion.rates)
        worst = max(worst, abs(h * (found - chi)) / (piece + turned))
    return worst


def error_of_sine(value, piece):
    """The largest error of S(h)/h - 1 by a function of a and b, over pieces this long.

    a + b is at most the square of the piece, and the error grows with it.
    """
    worst = mpf(0)
    for k in range(21):
        a = mpf(k) / 40 * mpf(piece) ** 2
        b = mpf(piece) ** 2 - a
        worst = max(worst, abs(value(a, b) - (sum(sine_coefficients(a, b)) - 1)))
    return worst
