"""Series and quadrature rules of the free motion over one piece."""

from functools import partial

from mpmath import mpf

from benchmarks.coefficients import free_motion, rules, sources
from benchmarks.coefficients.table import Claim, CoefficientTable

_STEP = "_solver/step.py"
_FLOW = "_solver/chains.py"
_SINES = "_SINE_0", "_SINE_1", "_SINE_2", "_SINE_3"
# How many powers of s each of them holds.
_LENGTHS = 5, 4, 3, 1
_GAUSS_JACOBI = "_POINTS", "_SQUARES", "_WEIGHTS"


def tables():
    return [
        CoefficientTable(
            _STEP,
            _SINES,
            "S(h)/h - 1 in powers of s = a + b and p = a b, from S'' = -s S + 2 p S^3; absolute "
            "error over the longest piece, s <= LONGEST_PIECE^2",
            partial(sources.named, _STEP, *_SINES),
            _sines,
            error=_error_of_sines,
            claims=(Claim(5e-17, "Truncation there is below 5e-17 of the angle"),),
        ),
        CoefficientTable(
            _STEP,
            _GAUSS_JACOBI,
            "Gauss-Jacobi on (0, 1) with weight x^2, four points; their squares; weights over the "
            "squares; error of chi/2 over the longest piece, of the angle",
            partial(sources.named, _STEP, *_GAUSS_JACOBI),
            _gauss_jacobi,
            error=_error_of_step,
            claims=(Claim(5e-17, "Truncation there is below 5e-17 of the angle"),),
        ),
        CoefficientTable(
            _FLOW,
            ("_GAUSS",),
            "Gauss-Legendre on (0, 1), ten points: the lower half, point and weight; error over "
            "the longest piece with _TERMS of S: of chi, as a part of the piece and the angle "
            "turned, and relatively of S",
            partial(sources.named, _FLOW, "_GAUSS"),
            _gauss_legendre,
            pairs=True,
            error=_error_of_flow,
            claims=(Claim(1e-26, "leave less than 1e-26 of a piece this long"),),
        ),
    ]


def _longest(file, name):
    return mpf(sources.named(file, name)[0])


def _sines():
    degree = 6
    rows = free_motion.sine_rows(degree)
    kept = [x for row, length in zip(rows, _LENGTHS, strict=True) for x in row[:length]]
    return [mpf(x.numerator) / x.denominator for x in kept]


def _error_of_sines(numbers):
    rows, start = [], 0
    for length in _LENGTHS:
        rows.append(numbers[start : start + length])
        start += length

    def value(a, b):
        s, p = a + b, a * b
        sums = [sum(x * s**k for k, x in enumerate(row)) for row in rows]
        return s * sums[0] + p * sums[1] + p**2 * sums[2] + p**3 * sums[3]

    return free_motion.error_of_sine(value, _longest(_STEP, "LONGEST_PIECE"))


def _gauss_jacobi():
    points, weights = rules.gauss(4, power=2)
    over = [w / x**2 for x, w in zip(points, weights, strict=True)]
    return [*points, *(x**2 for x in points), *over]


def _error_of_step(numbers):
    points, weights = numbers[:4], numbers[8:]
    return free_motion.error_of_step(points, weights, _longest(_STEP, "LONGEST_PIECE"))


def _gauss_legendre():
    points, weights = rules.gauss(10)
    return [x for pair in zip(points[:5], weights[:5], strict=True) for x in pair]


def _error_of_flow(numbers):
    lower, weights = numbers[::2], numbers[1::2]
    points = [*lower, *(1 - x for x in lower)]
    terms = int(_longest(_FLOW, "_TERMS"))
    piece = _longest(_FLOW, "_LONGEST_PIECE")

    def sine(a, b):
        return sum(free_motion.sine_coefficients(a, b, terms)) - 1

    chi = free_motion.error_of_flow(points, [*weights, *weights], terms, piece)
    return max(chi, free_motion.error_of_sine(sine, piece))
