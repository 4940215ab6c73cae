"""Polynomials of one variable: least-maximum ones, interpolating ones and power series."""

from functools import partial

from mpmath import mp, mpf

from benchmarks.coefficients import sources
from benchmarks.coefficients.minimax import PolynomialFit, power_series
from benchmarks.coefficients.table import Claim, CoefficientTable

_PHASES = "_solver/series.py"
_STEP = "_solver/step.py"
_REGIME_LOOPS = "_solver/regime_loops.py"
_ELEMENTARY = "_compilation/elementary.py"
_CLOSED_FORM = "light_curve/_sums.py"
_DIMMING = "inversion/_ellipsoid.py"


def tables():
    return [*_least_maximum(), *_of_lanes(), *_interpolating(), *_series()]


def _least_maximum():
    sine = PolynomialFit(
        power_series(
            lambda n: (-1) ** (n + 1) * (2 * mp.pi) ** (2 * n + 3) / mp.factorial(2 * n + 3)
        ),
        lambda z: z * mp.sqrt(z),
        6,
        "0",
        "1/64",
    )
    cosine = PolynomialFit(
        power_series(
            lambda n: (-1) ** (n + 1) * (2 * mp.pi) ** (2 * n + 2) / mp.factorial(2 * n + 2)
        ),
        lambda z: z,
        7,
        "0",
        "1/64",
    )
    power = PolynomialFit(
        power_series(lambda n: (-mp.ln2) ** (n + 1) / mp.factorial(n + 1)), abs, 11, "-1/2", "1/2"
    )
    cubes = PolynomialFit(power_series(lambda n: mpf(1) / (2 * n + 3)), lambda u: 1, 11, "0", "1/9")
    stated = "largest errors with these coefficients 7e-18 and 1.7e-17."
    return [
        _fitted(
            _PHASES,
            [f"_SIN_{n}" for n in range(3, 14, 2)],
            "S of degree 5 in sin 2 pi r = r (2 pi + z S(z)), z = r^2, |r| <= 1/8: least maximum "
            "of the absolute error of the sine",
            sine,
            Claim(7e-18, stated),
        ),
        _fitted(
            _PHASES,
            [f"_COS_{n}" for n in range(2, 15, 2)],
            "C of degree 6 in cos 2 pi r = 1 + z C(z), z = r^2, |r| <= 1/8: least maximum of the "
            "absolute error of the cosine",
            cosine,
            Claim(1.7e-17, stated),
        ),
        _fitted(
            _PHASES,
            [f"_EXP_{n}" for n in range(1, 12)],
            "E of degree 10 in 2^-f = 1 + f E(f), |f| <= 1/2: least maximum of the absolute error",
            power,
            Claim(1.5e-17, "2**-f on |f| <= 1/2, in the same way; largest error 1.5e-17."),
        ),
        _fitted(
            _CLOSED_FORM,
            [f"_R{n}" for n in range(11)],
            "R of degree 10 in atanh f = f + f^3 R(u), u = f^2 <= 1/9: least maximum of the "
            "absolute error of R",
            cubes,
            Claim(2.1e-17, "Polynomial of least maximum error; with these coefficients 2e-17."),
        ),
    ]


def _of_lanes():
    power = PolynomialFit(
        power_series(lambda n: (-mp.ln2) ** (n + 1) / mp.factorial(n + 1)),
        lambda f: 1, 6, "-1/16", "1/16",
    )  # fmt: skip
    angle = PolynomialFit(_angle_over_tangent, lambda z: 1, 17, "0", "1")
    logarithm = PolynomialFit(
        power_series(lambda n: 2 / mp.ln2 / (2 * n + 3)), lambda u: 1, 8, "0", "1/25"
    )
    return [
        _fitted(
            _ELEMENTARY,
            [f"_POWER_{n}" for n in range(1, 7)],
            "E of degree 5 in 2^-f = 1 + f E(f), |f| <= 1/16: least maximum of the error of E",
            power,
            Claim(2.9e-14, "least maximum of the error of E, 2.9e-14."),
        ),
        _fitted(
            _ELEMENTARY,
            [f"_ANGLE_{n}" for n in range(17)],
            "A of degree 16 in (2/pi) atan x = x A(z), 0 <= z = x^2 <= 1: least maximum of the "
            "absolute error of A",
            angle,
            Claim(3.7e-15, "least maximum of the error, 3.7e-15."),
        ),
        _fitted(
            _ELEMENTARY,
            [f"_LOG_{n}" for n in range(1, 9)],
            "L of degree 7 in log2((1 + s)/(1 - s)) = s (2/ln 2 + u L(u)), u = s^2 <= 1/25: least "
            "maximum of the error of L",
            logarithm,
            Claim(5.1e-17, "L, 5.1e-17."),
        ),
    ]


def _angle_over_tangent(z):
    """(2/pi) atan(x)/x of z = x^2."""
    return 2 / mp.pi * (mp.atan(mp.sqrt(z)) / mp.sqrt(z) if z > 0 else 1)


def _fitted(file, names, definition, fit, claim):
    return CoefficientTable(
        file,
        tuple(names),
        definition,
        partial(sources.named, file, *names),
        lambda: fit.best[0],
        difference=fit.difference,
        error=fit.error,
        ideal=lambda: fit.best[1],
        claims=(claim,),
    )


def _interpolating():
    # Both are written so that nothing cancels at 0.
    root = PolynomialFit(
        lambda a: -1 / (1 + mp.sqrt(1 - a)), lambda a: 1 + mp.sqrt(1 - a), 7, "0", "1/100"
    )
    inverse = PolynomialFit(
        lambda a: 1 / (2 * mp.sqrt(1 - a) * (1 + mp.sqrt(1 - a))), lambda a: a, 5, "0", "1/400"
    )
    return [
        CoefficientTable(
            _STEP,
            ("_ROOT",),
            "P of degree 6 in sqrt(1 - a) - 1 = a P(a), 0 <= a <= 0.1^2, through P at the zeros of "
            "Chebyshev's T_7; relative error",
            partial(sources.named, _STEP, "_ROOT"),
            root.through_chebyshev_points,
            error=root.error,
            ideal=lambda: root.best[1],
            claims=(Claim(2e-19, "sqrt(1 - a) - 1 = a (...), to 2e-19 of it"),),
        ),
        CoefficientTable(
            _STEP,
            ("_INVERSE",),
            "P of degree 4 in 1/(2 sqrt(1 - a)) = 1/2 + a P(a), 0 <= a <= 0.05^2, through P at the "
            "zeros of Chebyshev's T_5; absolute error",
            partial(sources.named, _STEP, "_INVERSE"),
            inverse.through_chebyshev_points,
            error=inverse.error,
            ideal=lambda: inverse.best[1],
            claims=(Claim(1.1e-19, "1/(2 sqrt(1 - a)) = 1/2 + a (...), to 1.1e-19"),),
        ),
    ]


def _series():
    return [
        CoefficientTable(
            _DIMMING,
            ("_dimming",),
            "(x - (1 - u) atanh x)/x^3, u = x^2, in seven terms of u, and its derivative in six",
            lambda: [x for x in sources.literals(_DIMMING, "_dimming") if 0 < x < 1 and 16 * x % 1],
            lambda: (
                [mpf(2) / (4 * k * k - 1) for k in range(7, 0, -1)]
                + [mpf(2 * k) / (4 * (k + 1) ** 2 - 1) for k in range(6, 0, -1)]
            ),
        ),
        CoefficientTable(
            "paths/_two_body.py",
            ("_stumpff",),
            "the number of terms of Stumpff's c2 and c3, |z| <= 1; relative error",
            lambda: [sources.literals("paths/_two_body.py", "_stumpff")[1] + 1],
            lambda: [10],
            error=_error_of_stumpff,
            claims=(Claim(2e-21, "ten terms leave 2e-21 at |z| = 1"),),
        ),
        CoefficientTable(
            _REGIME_LOOPS,
            ("_tumbling",),
            "2 K(m) - pi = (pi/4) m (1 + 9/16 m) below m = _SMALL_M; relative error",
            lambda: [x for x in sources.literals(_REGIME_LOOPS, "_tumbling") if 4 * x % 1],
            lambda: [mpf(9) / 16],
            error=_error_of_quarter,
            claims=(Claim(1e-20, "its series to two terms, good to 1e-20"),),
        ),
    ]


def _error_of_stumpff(numbers):
    (terms,) = numbers
    worst = mpf(0)
    for z in (mpf(-1), mpf(1)):
        root = mp.sqrt(z)
        for first, exact in ((2, (1 - mp.cos(root)) / z), (3, (root - mp.sin(root)) / (root * z))):
            found = sum((-z) ** n / mp.factorial(2 * n + first) for n in range(int(terms)))
            worst = max(worst, abs(found / exact - 1))
    return worst


def _error_of_quarter(numbers):
    (second,) = numbers
    m = mpf(sources.named(_REGIME_LOOPS, "_SMALL_M")[0])
    return abs(mp.pi / 4 * m * (1 + second * m) / (2 * mp.ellipk(m) - mp.pi) - 1)
