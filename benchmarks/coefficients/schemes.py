"""Splitting schemes: their coefficients from closed forms or conditions, and their order."""

from functools import partial

from mpmath import mp, mpf

from attitude.torques._schemes import SCHEMES
from benchmarks.coefficients import composition
from benchmarks.coefficients.table import CoefficientTable

_FILE = "torques/_schemes.py"


def tables():
    # Last: by how many ulps doubles may differ.  Suzuki's differences are formed in doubles; what
    # Blanes and Moan print ends before the last digit of a double.
    given = (
        ("kick-rotate-kick", ("SCHEMES",), "half a kick on either side", _kick_rotate_kick, 0),
        ("rotate-kick-rotate", ("SCHEMES",), "half a flight on either side", _rotate_kick, 0),
        (
            "hoa",
            ("_XI", "SCHEMES"),
            "the first and last kick that make the sum of the squares of both third-order errors "
            "least",
            _hoa,
            0,
        ),
        ("suzuki", ("_suzuki",), "five steps, four of 1/(4 - 4^(1/3))", _suzuki, 5),
        (
            "blanes-moan",
            ("_blanes_moan",),
            "published digits; remade: the nearest numbers that meet both third-order conditions",
            _blanes_moan,
            25,
        ),
        ("force-gradient", ("SCHEMES",), "Simpson's kicks, and [B, [A, B]]/72", _gradient, 0),
    )
    return [
        CoefficientTable(
            _FILE,
            owners,
            f"{name}: {definition}; largest residual of the conditions up to order "
            f"{SCHEMES[name].order}",
            partial(_stored, name),
            remake,
            apart=apart,
            error=partial(_residual, name),
        )
        for name, owners, definition, remake, apart in given
    ]


def order_of_error(name):
    """The least word length at which a scheme differs from the exact step by more than rounding."""
    parts = _parts(name, [mpf(x) for x in _stored(name)])
    return next(n for n in range(1, 8) if composition.residual(parts, n) > 1e-12)


def _stored(name):
    each = SCHEMES[name]
    return [*each.kicks.tolist(), *each.flights.tolist(), *each.gradients.tolist()]


def _parts(name, numbers):
    n = SCHEMES[name].flights.size
    return numbers[: n + 1], numbers[n + 1 : 2 * n + 1], numbers[2 * n + 1 :]


def _residual(name, numbers):
    parts = _parts(name, numbers)
    return max(composition.residual(parts, n) for n in range(1, SCHEMES[name].order + 1))


def _kick_rotate_kick():
    half = mpf(1) / 2
    return [half, half, 1, 0, 0]


def _rotate_kick():
    half = mpf(1) / 2
    return [0, 1, 0, half, half, 0, 0, 0]


def _hoa():
    half = mpf(1) / 2

    def size(kick):
        return sum(x * x for x in composition.third_order([kick, 1 - 2 * kick, kick], [half, half]))

    kick = mp.findroot(lambda x: mp.diff(size, x), mpf("0.19"))
    return [kick, 1 - 2 * kick, kick, half, half, 0, 0, 0]


def _suzuki():
    p = 1 / (4 - mp.cbrt(4))
    middle = (1 - 3 * p) / 2
    return [p / 2, p, middle, middle, p, p / 2, p, p, 1 - 4 * p, p, p, *[0] * 6]


def _gradient():
    sixth = mpf(1) / 6
    return [sixth, 4 * sixth, sixth, 3 * sixth, 3 * sixth, 0, sixth / 12, 0]


def _blanes_moan():
    """From the first three kicks and two flights, by Newton steps of least length."""
    stored = [mpf(x) for x in _stored("blanes-moan")]
    free = mp.matrix([*stored[:3], *stored[7:9]])
    for _ in range(4):
        here = mp.matrix(composition.third_order(*_both_ways(free)))
        slopes = mp.matrix(2, 5)
        for k in range(5):
            # the conditions are cubic, so that this is their derivative to all digits kept
            moved, tiny = free.copy(), mpf(10) ** (-mp.dps // 2)
            moved[k] += tiny
            there = mp.matrix(composition.third_order(*_both_ways(moved)))
            slopes[0, k], slopes[1, k] = (there[0] - here[0]) / tiny, (there[1] - here[1]) / tiny
        free -= slopes.T * mp.lu_solve(slopes * slopes.T, here)
    kicks, flights = _both_ways(free)
    return [*kicks, *flights, *[0] * 7]


def _both_ways(free):
    kicks, flights = list(free[:3]), list(free[3:])
    flights.append(mpf(1) / 2 - sum(flights))
    return [*kicks, 1 - 2 * sum(kicks), *reversed(kicks)], [*flights, *reversed(flights)]
