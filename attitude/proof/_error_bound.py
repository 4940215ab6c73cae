"""One bound of the errors of a motion at all epochs: enclosed constants, theorem of the loops.

The constants that the loops read are compared with their exact values in balls; what remains is the
rounding of the loops themselves, which tests/proof/test_theorem.py bounds for all bodies.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np

from attitude._solver import codes
from attitude.errors import AttitudeError
from attitude.proof import _exact
from attitude.proof._certificate import ASSUMED, precision, upper
from attitude.proof._exact import Number, Solution, ball, conjugate, product
from attitude.proof._intervals import UNIT_ROUNDOFF, Intervals, Turn, of

# Bounds of the roundings of each loop, rad: for all bodies and epochs up to 1e15 turns.
LOOPS: dict[int, float] = {
    codes.UNIFORM: 0.90e-15,
    codes.TRIGONOMETRIC: 2.70e-15,
    codes.HYPERBOLIC: 2.99e-15,
}
# Up to so many turns of its phases.
TURNS: float = 1e15
# The theorem holds for coefficients of the series within this of those of some body.
SLACK: float = 4e-15
# The next three are proved over all bodies by tests/proof/test_theorem.py.
# Largest rotation angle, rad, of the internal pair per rad of v (trigonometric form).
PER_RADIAN = 2.41
# The same per unit of y (hyperbolic form); 2 on the exact separatrix.
PER_Y = 2.65
# Largest turn of the internal pair on S3 through Q'/E and Q' E per unit of the nome Q'.
PER_NOME = 1.07
_TWO_PI = 2.0 * math.pi
_BITS = 256
_ASSUMED = (*ASSUMED, "fused multiply-adds round once, and the compiler keeps what is written")

# Powers of cos 2 v in cos 2 n v, sin 2 n v / sin 2 v, sin (2 n + 1) v / sin v and
# cos (2 n + 1) v / cos v, n = 0 to 3.
COS_EVEN: Any = np.array([[1, 0, 0, 0], [0, 1, 0, 0], [-1, 0, 2, 0], [0, -3, 0, 4]], float)
SIN_EVEN: Any = np.array([[0, 0, 0, 0], [1, 0, 0, 0], [0, 2, 0, 0], [-1, 0, 4, 0]], float)
SIN_ODD: Any = np.array([[1, 0, 0, 0], [1, 2, 0, 0], [-1, 2, 4, 0], [-1, -4, 4, 8]], float)
COS_ODD: Any = np.array([[1, 0, 0, 0], [-1, 2, 0, 0], [-1, -2, 4, 0], [1, -4, -4, 8]], float)


@dataclass(frozen=True)
class ErrorBound:
    """A proved bound of the error of every attitude of a motion: constant + rate |t|.

    Attributes
    ----------
    constant : float
        rad.
    rate : float
        rad per second since the epoch.
    span : float
        s; the bound holds for |t| up to this, 1e15 turns.
    assumed : tuple of str
        What the proof rests on.

    >>> constant, rate = ErrorBound(3e-15, 1e-31, 1e15)
    """

    constant: float
    rate: float
    span: float
    assumed: tuple[str, ...] = _ASSUMED

    def __iter__(self) -> Iterator[float]:
        return iter((self.constant, self.rate))


def error_bound_of(record: Any, solution_of: Any) -> ErrorBound:
    """The bound of one motion, whose loops read a record of `records.CONSTANTS`.

    solution_of: returns the `Solution` of the same doubles, with axes in the order of the record.
    AttitudeError if the constants are not near enough to the exact ones for the theorem to hold.
    """
    with precision(_BITS):
        try:
            solution: Solution = solution_of()
            parts, rate = _of_form(record, solution)
        except _exact.Undecided:
            raise _refused(f"a branch of the solution is not decided at {_BITS} bits") from None
    constant = sum(parts.values()) * (1.0 + 1e-12)
    if not constant < 1e-12 or not math.isfinite(rate):
        raise _refused(f"its constants are {constant:.2g} rad from the exact ones")
    fastest = max(abs(float(record["precession"][0])), abs(float(record["nutation"][0])))
    return ErrorBound(constant, rate * (1.0 + 1e-12), TURNS / fastest if fastest else math.inf)


def _refused(why):
    return AttitudeError(
        f"no bound for all epochs is proved for this motion: {why}. A certificate bounds the error "
        "at single epochs."
    )


def _of_form(record, solution):
    """Parts of the bound at the epoch, rad, and its growth, rad/s."""
    form = int(record["form"])
    if (form == codes.UNIFORM) != (solution.form == "uniform"):
        raise _refused("the record is that of another form than the exact motion")
    if form == codes.UNIFORM:
        return _uniform(record, solution)
    two_pi = 2 * _exact.flint().arb.pi()
    precession = _pair(record["precession"])
    parts = {"loop": LOOPS[form], "frame": _frame_part(record, solution)}
    drift = 2 * upper(two_pi * precession - solution.precession)
    of_form = _trigonometric if form == codes.TRIGONOMETRIC else _hyperbolic
    more, slope, turns = of_form(record, solution)
    parts |= more | {"phase": 2 * _TWO_PI * 2 * 4 * UNIT_ROUNDOFF**2}
    ramp = 7 * UNIT_ROUNDOFF**2 * (2 * _TWO_PI * upper(precession) + turns)
    return parts, drift + slope + ramp


def _uniform(record, solution):
    arb = _exact.flint().arb
    turns = solution.speed / (4 * arb.pi())  # half of the angle, in turns
    rows = [[arb(float(x)) for x in record["frame"][k]] for k in (0, 1)]
    axis = solution.axis
    at_rest = not any(x != 0 for x in solution.given_rates)
    exact = solution.start, (rows[1] if at_rest else product(solution.start, [arb(0), *axis]))
    off = [rows[j][k] - exact[j][k] for j in (0, 1) for k in range(4)]
    squares = sum((x * x for x in off), arb(0))
    precession = _pair(record["precession"])
    parts = {
        "loop": LOOPS[codes.UNIFORM],
        "frame": 2 * upper(squares.nonnegative_part().sqrt()),
        "phase": 2 * _TWO_PI * 4 * UNIT_ROUNDOFF**2,
    }
    drift = 2 * upper(2 * arb.pi() * (precession - turns))
    return parts, drift + 7 * UNIT_ROUNDOFF**2 * 2 * _TWO_PI * upper(precession)


def _pair(row):
    return _exact.rational(float(row[0]), float(row[1])) + _exact.flint().arb(0)


def _modulo(x, whole=1):
    """A ball less the nearest multiple of `whole`."""
    return x - whole * round(float((x / whole).mid()))


def _frame_part(record, solution):
    """The turn by the errors of the matrix from internal pair to attitude.

    A common factor does not turn.  The 2-norm of the rest is below ||(D^T D)^4||_F^(1/8).
    """
    arb = _exact.flint().arb
    left, right = solution.left, conjugate(solution.body)
    units = [[arb(int(j == k)) for j in range(4)] for k in range(4)]
    columns = [product(product(left, e), right) for e in units]
    off = [[arb(float(record["frame"][j][k])) - columns[k][j] for k in range(4)] for j in range(4)]
    common = sum((off[j][k] * columns[k][j] for j in range(4) for k in range(4)), arb(0)) / 4
    off = [[off[j][k] - common * columns[k][j] for k in range(4)] for j in range(4)]
    power = _exact.flint().arb_mat(off)
    power = power.transpose() * power
    for _ in range(2):
        power = power * power
    squares = sum((x * x for x in power.entries()), arb(0))
    root = arb(squares.upper()).nonnegative_part().root(16)
    return 2 * upper(root) * (1.0 + 1e-12)


# ---- Trigonometric form


def _trigonometric(record, solution):
    """Parts of the bound, its growth in rad/s, and rad per second of the nutation phase."""
    arb = _exact.flint().arb
    two_pi = 2 * arb.pi()
    if solution.form == "separatrix":
        raise _refused("the record is that of another form than the exact motion")
    frequency = _pair(record["nutation"])
    drift = PER_RADIAN * upper(two_pi * (frequency - solution.rate / 2))
    start = PER_RADIAN * upper(two_pi * _modulo(_pair(record["nutation0"]) - solution.x / 2))
    exact, outer, nome = _exact_series(solution)
    series = dict(zip("abcd", (*record["alpha"], *record["beta"]), strict=True))
    if any(
        upper(arb(float(series[row][k])) - exact[row][k]) > SLACK
        for row in "abcd"
        for k in range(4)
    ):
        raise _refused("a coefficient of its series is off by more than 4e-15")
    tail = 8 * upper(outer) ** 4 * upper(nome) ** 12 + 1e-25  # of the terms that are left out
    parts = {"start": start, "series": _series_part(series, exact) + 4 * tail}
    return parts, drift, PER_RADIAN * _TWO_PI * upper(frequency)


def _exact_series(solution):
    """Coefficients of the four series, P = Q e^(2 delta) and Q (docs/derivation.md)."""
    arb = _exact.flint().arb
    if solution.form == "symmetric":
        shrunk, outer, nome, rho = arb(0), arb(0), arb(0), solution.rho
    else:
        shift = solution.shift.imag * arb.pi()
        shrunk = (-2 * shift).exp()
        nome = (-arb.pi() * solution.tau.imag).exp()
        outer = nome / shrunk
        rho = solution.r * (shift - arb.pi() * solution.tau.imag / 4).exp()
    exact: dict[str, list[Number]] = {row: [arb(0)] * 4 for row in "abcd"}
    for n in range(4):
        sign = (-1) ** n
        first = sign * outer**n * nome ** (n * (n - 1)) if n else arb(1)
        second = sign * outer**n * nome ** (n * n) if n else arb(1)
        even = first * (1 + shrunk ** (2 * n)) if n else arb(1)
        odd = -first * (1 - shrunk ** (2 * n)) if n else arb(0)
        total, gap = (second * (1 + s * shrunk ** (2 * n + 1)) for s in (1, -1))
        for k in range(4):
            exact["a"][k] += even * COS_EVEN[n, k]
            exact["b"][k] += odd * SIN_EVEN[n, k]
            exact["c"][k] -= rho * total * SIN_ODD[n, k]
            exact["d"][k] -= rho * gap * COS_ODD[n, k]
    return exact, outer, nome


def _interval(x):
    x = ball(x)
    lower = math.nextafter(float(x.lower()), -math.inf)
    return Intervals(lower, math.nextafter(float(x.upper()), math.inf))


@cache
def _angles(count=64):
    """Sine and cosine of v and of 2 v over boxes of [0, pi]; beyond, only signs change."""
    arb, fmpq = _exact.flint().arb, _exact.flint().fmpq
    functions = (arb.sin, arb.cos, lambda v: (2 * v).cos(), lambda v: (2 * v).sin())
    boxes = []
    for function in functions:
        # The radius of a box covers more than half of the distance to the next.
        values = [
            function(arb.pi() * arb(fmpq(2 * k + 1, 2 * count), 0.5000001 / count))
            for k in range(count)
        ]
        lower = [math.nextafter(float(x.lower()), -2.0) for x in values]
        boxes.append(Intervals(lower, [math.nextafter(float(x.upper()), 2.0) for x in values]))
    return boxes


def _series_part(series, exact):
    """The turn between the pairs of two sets of coefficients over all v."""
    arb = _exact.flint().arb
    sine, cosine, double_cosine, double_sine = _angles()
    # A common factor does not turn: any number near the quotient will do.
    common = arb(float(series["a"][0]) / float(exact["a"][0].mid()))
    whole = {row: [_interval(x * common) for x in exact[row]] for row in "abcd"}
    off = {
        row: [_interval(arb(float(series[row][k])) - exact[row][k] * common) for k in range(4)]
        for row in "abcd"
    }

    def pair(rows):
        a, b, c, d = (_cubic(rows[row], double_cosine) for row in "abcd")
        return [a, double_sine * b, sine * c, cosine * d]

    turn = Turn(pair(whole))
    turn.add(1.0, pair(off))
    return 2.0 * float(np.max(turn.total())) * (1.0 + 1e-9)


def _cubic(c, x):
    return c[0] + x * (c[1] + x * (c[2] + x * c[3]))


# ---- Hyperbolic form


def _hyperbolic(record, solution):
    """As `_trigonometric`."""
    arb = _exact.flint().arb
    frequency, start = _pair(record["nutation"]), _pair(record["nutation0"])
    if solution.form == "separatrix":
        nome, d = arb(0), solution.d
        off_rate, off_start = frequency - solution.rate, start - solution.y
        decay, tilt = 2 / arb(2).log(), arb(0)
        per_phase = 2.0
    elif solution.form == "theta":
        stretch = solution.tau.imag
        nome, d = (-arb.pi() / stretch).exp(), solution.shift.imag * arb.pi() / stretch
        off_rate, off_start = frequency - solution.rate, _modulo(start - solution.x, 2)
        decay, tilt = 2 * arb.pi() / (stretch * arb(2).log()), d / arb.pi()
        # of the pair, and of the tilt of the precession; y is pi / T times half turns
        per_phase = PER_Y * upper(arb.pi() / stretch) + 2.0 * _TWO_PI * upper(tilt)
    else:
        raise _refused("the record is that of another form than the exact motion")
    if bool(record["winds"]) != (solution.form == "theta"):
        raise _refused("the record is that of another form than the exact motion")
    angles = [(2 * n + 1) * d for n in range(4)]
    exact = [
        [nome ** (n * n) * x.cos() for n, x in enumerate(angles)],
        [nome ** (n * n) * x.sin() for n, x in enumerate(angles)],
    ]
    relative = upper((arb(float(record["decay"])) - decay) / decay)
    parts = {
        "start": per_phase * upper(off_start),
        "series": _hyperbolic_part(record, exact, solution.r, nome, relative),
        "tilt": _TWO_PI * 2 * upper(arb(float(record["tilt"])) - tilt) * 0.5,
    }
    return parts, per_phase * upper(off_rate), per_phase * upper(frequency)


def _hyperbolic_part(record, exact, ratio, nome, relative):
    """The turn between the pairs of two sets of coefficients over all e = exp(-2|y|).

    `relative` is the relative error of the decay.
    """
    arb = _exact.flint().arb
    rows, computed_ratio = record["alpha"], float(record["beta"][0][0])
    off_slack = any(
        upper(arb(float(rows[r][k])) - exact[r][k]) > SLACK for r in range(2) for k in range(4)
    )
    if off_slack or upper(arb(computed_ratio) - 1) >= 1e-13:
        raise _refused("a coefficient of its series is off by more than 4e-15")
    e, f, g = _hyperbolic_boxes(nome)
    common = arb(float(rows[0][0]) / float(exact[0][0].mid()))
    whole = [[_interval(x * common) for x in row] for row in exact]
    off = [
        [_interval(arb(float(rows[r][k])) - exact[r][k] * common) for k in range(4)]
        for r in range(2)
    ]

    def pair(c, s, factor):
        return [
            _cubic(c, f) + e * _cubic(c, g),
            _cubic(s, f) - e * _cubic(s, g),
            -(factor * (_cubic(c, -f) - e * _cubic(c, -g))),
            -(factor * (_cubic(s, -f) + e * _cubic(s, -g))),
        ]

    exact_ratio = _interval(ratio)
    vector = pair(*whole, exact_ratio)
    turn = Turn(vector)
    turn.add(1.0, pair(*off, of(computed_ratio)))
    zero = of(0.0)
    turn.add(upper(arb(computed_ratio) / ratio - 1) * (1 + 1e-12), [zero, zero, *vector[2:]])
    c, s = whole
    # e ln(1/e) over the upper end of e, at most 1/e in all
    small = e.hi < math.exp(-1.0)
    logs = np.where(small, np.log(1.0 / e.hi) * (1.0 + 1e-12), math.exp(-1.0) / e.hi)
    by_e = [
        e * _cubic(c, g),
        -(e * _cubic(s, g)),
        exact_ratio * e * _cubic(c, -g),
        -(exact_ratio * e * _cubic(s, -g)),
    ]
    turn.add(relative * logs, by_e)
    through_nome = 0.0  # through f and g, whose coefficients contain the nome
    if nome > 0:
        off_nome = upper(arb(float(record["nome"])) - nome)
        # E is not below the nome, so that ln(1/E) is at most ln(1/Q')
        through_nome = PER_NOME * (off_nome + relative * upper(nome * nome.log()))
    return 2.0 * float(np.max(turn.total() + through_nome)) * (1.0 + 1e-9)


def _hyperbolic_boxes(nome):
    """Boxes of E, and F = Q'/E, G = Q' E over them."""
    low = max(upper(nome), 1e-12)
    ends = (
        np.concatenate([[0.0], np.geomspace(low, 1.0, 97)]) if low < 1.0 else np.array([0.0, 1.0])
    )
    e = Intervals(ends[:-1], ends[1:])
    q = _interval(nome)
    q = Intervals(np.full(len(e.lo), q.lo), np.full(len(e.lo), q.hi))
    inner = e.lo > 0.0
    quotient = q / Intervals(np.where(inner, e.lo, 1.0), e.hi)
    lower = np.where(inner, quotient.lo, 0.0)
    f = Intervals(lower, np.where(inner, np.minimum(quotient.hi, 1.0), 1.0))
    return e, f, q * e
