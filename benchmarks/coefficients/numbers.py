"""Single numbers, quadrature rules and tables of whole numbers: those with an exact definition."""

from functools import partial

from mpmath import mp, mpf

from benchmarks.coefficients import rules, sources
from benchmarks.coefficients.table import Claim, CoefficientTable

_ELLIPTIC = "_solver/elliptic.py"
_REGIME_LOOPS = "_solver/regime_loops.py"
_INTEGRATORS = "referee/_referee.py"


def tables():
    return [*_circle(), *_of_doubles(), *_others(), *_kinds(), *_differences(), *_means()]


def _exact(file, owners, definition, remake, **more):
    return CoefficientTable(
        file, owners, definition, partial(sources.named, file, *owners), remake, **more
    )


def _inside(file, function, definition, remake, **more):
    def read():
        return [x for x in sources.literals(file, function) if sources.is_long(x)]

    return CoefficientTable(file, (function,), definition, read, remake, **more)


def _circle():
    return [
        _exact("_solver/twofloat.py", ("HALF_PI",), "pi/2", lambda: [mp.pi / 2], pairs=True),
        _exact("_solver/twofloat.py", ("TWO_PI",), "2 pi", lambda: [2 * mp.pi], pairs=True),
        _exact(
            "_solver/series.py",
            ("_SIN_1", "_SIN_1_LOW"),
            "2 pi, the first coefficient of sin 2 pi r",
            lambda: [2 * mp.pi],
            pairs=True,
        ),
        _exact("_solver/step.py", ("_OVER_4_PI",), "1/(4 pi)", lambda: [1 / (4 * mp.pi)]),
        _exact(
            "_solver/derivatives.py",
            ("TWO_OVER_LOG_2",),
            "2 / ln 2",
            lambda: [2 / mp.log(2)],
            pairs=True,
        ),
        _inside(_ELLIPTIC, "_turns", "2 pi", lambda: [2 * mp.pi]),
        _inside(_ELLIPTIC, "quarter_and_fraction", "pi/2, twice", lambda: [mp.pi / 2] * 2),
    ]


def _of_doubles():
    return [
        _exact(
            "_solver/derivatives.py",
            ("_NODES", "_WEIGHTS"),
            "Gauss-Legendre on (0, 1), six points: nodes, weights",
            lambda: [x for numbers in rules.gauss(6) for x in numbers],
        ),
        _exact(
            "_solver/series.py",
            ("_TO_LOW_BITS",),
            "3 2^51: sums with whole numbers below 2^51 have an ulp of 1",
            lambda: [3 * mpf(2) ** 51],
        ),
        _exact(
            "_compilation/simd_lowering.py",
            ("_WHOLE", "_EIGHTHS"),
            "3 2^51, and 3 2^48: sums with eighths below 2^48 have an ulp of 1/8",
            lambda: [3 * mpf(2) ** 51, 3 * mpf(2) ** 48],
        ),
        _inside(
            "_compilation/instructions.py",
            "rint",
            "2^52, from which on every double is a whole number",
            lambda: [mpf(2) ** 52],
        ),
        _exact(
            "_solver/kernel.py",
            ("_FARTHEST",),
            "the largest double",
            lambda: [(2 - mpf(2) ** -52) * mpf(2) ** 1023],
        ),
    ]


def _others():
    return [
        _exact("light_curve/_sums.py", ("_LN2",), "log 2", lambda: [mp.ln2]),
        _inside(
            "light_curve/_visibility.py",
            "plane_filling",
            "the plastic number, x^3 = x + 1",
            lambda: [mp.findroot(lambda x: x**3 - x - 1, mpf("1.3247"))],
        ),
        _inside(
            _INTEGRATORS,
            "celledoni_safstrom",
            "Gauss-Legendre on (0, 1), two points; sqrt(3)/12 of the Magnus series",
            lambda: [*rules.gauss(2)[0], mp.sqrt(3) / 12],
            apart=1,  # the second point is 1 less the double of the first
        ),
    ]


def _kinds():
    """Chebyshev polynomials; the rows of each table are their coefficients, lowest first."""
    kinds = (
        ("COS_EVEN", "first kind, T_n", ([1], [0, 1], 5, 5)),
        ("SIN_EVEN", "second kind, U_(n-1)", ([0], [1], 5, 5)),
        ("SIN_ODD", "fourth kind, W_n", ([1], [1, 2], 5, 5)),
        ("COS_ODD", "third kind, V_n", ([1], [-1, 2], 5, 5)),
    )

    def flat(arguments):
        return [x for row in rules.of_kind(*arguments) for x in row]

    return [
        _exact(
            "_solver/constants.py",
            (name,),
            f"Chebyshev polynomials of the {kind}, by their recurrence",
            partial(flat, given),
        )
        for name, kind, given in kinds
    ]


def _differences():
    return [
        _exact(
            "events/_extrema.py",
            ("_WEIGHTS_OF_PEAKS",),
            "first derivative by seven values, exact to degree 6",
            partial(rules.difference_weights, range(-3, 4), 1),
        ),
        _exact(
            "events/_extrema.py",
            ("_SIXTH",),
            "sixth difference",
            partial(rules.difference_weights, range(-3, 4), 6),
        ),
    ]


def _means():
    stated = "from 1e-8 apart to 1e-16 (double), 1e-16 to 1e-32 (pairs)"
    agreement = (
        "numbers this near, relatively, of which the mean is taken as the arithmetic-geometric"
    )
    return [
        _exact(
            _ELLIPTIC,
            (name,),
            f"{agreement} mean; relative error",
            partial(lambda value: [mpf(value)], near),
            error=_error_of_mean,
            claims=(Claim(bound, stated),),
        )
        for name, near, bound in (("_CLOSE", "1e-8", 1e-16), ("_CLOSE_PAIR", "1e-16", 1e-32))
    ] + [
        _exact(
            _REGIME_LOOPS,
            ("_STEP", "_TAIL"),
            "step and end of the trapezoidal sum in ln tan(am) for the mean speed; relative error",
            lambda: [mpf(1) / 4, 42],
            error=_error_of_sum,
            claims=(Claim(2.0**-53, "its error, 14 exp(-pi^2 / h) at most, is below 2^-53"),),
        ),
    ]


def _error_of_mean(numbers):
    (near,) = numbers
    return abs((2 - near) / 2 / mp.agm(1, 1 - near) - 1)


def _error_of_sum(numbers):
    step, tail = numbers
    worst = mpf(0)
    # The first is the worst of 7 moduli by 7 ratios of the speeds, and a bound: its body would come
    # to rest twice a period.
    for mc, p, q in (("1", "1", "0"), ("1e-3", "1", "0.5"), ("1e-30", "0.01", "1")):
        found = _mean_speed(step, tail, mpf(mc), mpf(p), mpf(q))
        exact = _mean_speed(step / 2, 2 * tail, mpf(mc), mpf(p), mpf(q))
        worst = max(worst, abs(found / exact - 1))
    return worst


def _mean_speed(step, tail, mc, p, q):
    """The time average of sqrt(p cn^2 + q sn^2), as attitude/_solver/regime_loops.py sums it."""
    total = weights = mpf(0)
    for k in range(int((2 * tail - mp.log(mc) / 2) / step) + 1):
        square = mp.exp(2 * (k * step - tail))
        weight = mp.sqrt(square / ((1 + square) * (1 + mc * square)))
        total += weight * mp.sqrt((p + q * square) / (1 + square))
        weights += weight
    return total / weights
