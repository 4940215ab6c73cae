"""Bounds of the roundings of the loops over epochs, for all bodies: the parts of docs/proof.md.

Each function traces the package's own source (`traced`) and bounds it over boxes
(`rounding_bounds`).  Angles are rotation angles, rad.
"""

import math

import numpy as np

from attitude._solver import kernel, series
from attitude.proof._error_bound import COS_EVEN, COS_ODD, SIN_EVEN, SIN_ODD, SLACK
from attitude.proof._intervals import UNIT_ROUNDOFF, Intervals, of
from tests.support import rounding_bounds, traced

U = UNIT_ROUNDOFF
# Largest errors of the polynomials of sine, cosine and 2**-f, absolute; the test encloses them.
SINE, COSINE, EXP2 = 7.1e-18, 1.71e-17, 1.6e-17
# Nomes Q and Q' of the series, and P = rho^4 X.
_LARGEST_NOME = math.exp(-math.pi) * (1 + 1e-9)
_LARGEST_OUTER = 0.2079
# The second double of a phase, turns, up to 1e15 turns.
_LOW = 2.0**-53 * 1.001


def _rows(trace, names):
    return tuple(trace.inputs(*(f"{name}{k}" for k in range(4))) for name in names)


def _polynomials_and_turn(r, lo, quarter):
    """Sine and cosine of 2 pi (r + lo) as `sincos` computes them, and before `lo` enters."""
    polynomials = []
    names = traced.replacements(quarter)
    eighth = traced.rebound(series.sincos_of_eighth, names)

    def kept(x):
        polynomials.append(eighth(x))
        return polynomials[-1]

    # The count of quarter turns and the reduced phase are exact: r itself stands for both.
    names |= {"sincos_of_eighth": kept, "rint": lambda x: 0.0, "_TO_LOW_BITS": 0}
    names["as_bits"] = lambda x: traced._Bits(x) if isinstance(x, traced.Node) else quarter
    sine, cosine = traced.rebound(series.sincos, names)(_Reduced(r), lo)
    return (sine, cosine), polynomials[0]


class _Reduced:
    """A phase whose distance from the nearest quarter turn is a traced number."""

    def __init__(self, r):
        self._r = r

    def __rmul__(self, factor):
        return 0.0

    def __sub__(self, quarters):
        return self._r


# ---- Sine and cosine of the precession


def turn_of_sine_cosine(count=512, omitted=()):
    """The turn of what is multiplied by cosine + i sine, by the errors of both."""
    trace = traced.Trace()
    outputs, polynomials = _polynomials_and_turn(*trace.inputs("r", "lo"), 0)
    ends = np.linspace(0.0, 0.125, count + 1)
    inputs = {
        "r": Intervals(ends[:-1], ends[1:]),
        "lo": Intervals(np.full(count, -_LOW), np.full(count, _LOW)),
    }
    more = {polynomials[0].place: SINE, polynomials[1].place: COSINE}
    places = traced.flat(outputs)
    turns = rounding_bounds.turn(trace.nodes, places, inputs, more, omitted)
    # sine and cosine are of first order in lo
    return float(np.max(turns)) + 2.0 * (2.0 * math.pi * _LOW) ** 2


# ---- The pair of the trigonometric form


def _coefficients(rho, shrunk):
    """The sixteen coefficients over boxes of rho and X = exp(-2 delta) (docs/derivation.md)."""
    nome = (rho.square().square() * shrunk.square()).within(0.0, _LARGEST_NOME)
    outer = (rho.square().square() * shrunk).within(0.0, _LARGEST_OUTER)
    rows = {row: [of(0.0)] * 4 for row in "abcd"}
    for n in range(4):
        sign = (-1.0) ** n
        first = outer.power(n) * nome.power(n * (n - 1)) * sign if n else of(1.0)
        second = outer.power(n) * nome.power(n * n) * sign if n else of(1.0)
        even = first * (shrunk.power(2 * n) + 1.0) if n else of(1.0)
        odd = -(first * (1.0 - shrunk.power(2 * n))) if n else of(0.0)
        total = second * (shrunk.power(2 * n + 1) + 1.0)
        gap = second * (1.0 - shrunk.power(2 * n + 1))
        for k in range(4):
            rows["a"][k] = rows["a"][k] + even * COS_EVEN[n, k]
            rows["b"][k] = rows["b"][k] + odd * SIN_EVEN[n, k]
            rows["c"][k] = rows["c"][k] - rho * total * SIN_ODD[n, k]
            rows["d"][k] = rows["d"][k] - rho * gap * COS_ODD[n, k]
    # those of a record may differ by so much
    return {
        f"{row}{k}": Intervals(x.lo - SLACK, x.hi + SLACK)
        for row, columns in rows.items()
        for k, x in enumerate(columns)
    }


def turn_of_trigonometric_pair(rho=32, shrunk=32, phases=64, omitted=()):
    """The turn of the internal pair by all roundings from the reduced phase on."""
    ends = [np.linspace(0.0, top, n + 1) for top, n in ((1.0, rho), (1.0, shrunk), (0.125, phases))]
    counts = [np.arange(n) for n in (rho, shrunk, phases)]
    a, b, c = (grid.ravel() for grid in np.meshgrid(*counts, indexing="ij"))
    inside = ends[0][a] ** 4 * ends[1][b] ** 2 <= _LARGEST_NOME * 1.0001
    a, b, c = a[inside], b[inside], c[inside]
    inputs = _coefficients(
        Intervals(ends[0][a], ends[0][a + 1]), Intervals(ends[1][b], ends[1][b + 1])
    )
    inputs["r"] = Intervals(ends[2][c], ends[2][c + 1])
    inputs["lo"] = Intervals(np.full(len(a), -_LOW), np.full(len(a), _LOW))
    worst = 0.0
    for quarter in (0, 1):
        trace = traced.Trace()
        alpha, beta = _rows(trace, "ab"), _rows(trace, "cd")
        r, lo = trace.inputs("r", "lo")
        (sine, cosine), polynomials = _polynomials_and_turn(r, lo, quarter)
        pair = traced.rebound(series.trigonometric_pair, traced.replacements())
        places = traced.flat(pair(alpha, beta, sine, cosine))
        more = {polynomials[0].place: SINE, polynomials[1].place: COSINE}
        turns = rounding_bounds.turn(trace.nodes, places, inputs, more, omitted)
        worst = max(worst, float(np.max(turns)))
    return worst


# ---- The pair of the hyperbolic form


def relative_error_of_exp2(count=512):
    """The largest relative error of `exp2_of_minus` for the argument that it has."""
    trace = traced.Trace()
    f = trace.input("f")
    names = traced.replacements() | {"as_bits": lambda x: 0, "from_bits": lambda n: 1.0}
    names["rint"] = lambda x: _Whole(f)
    result = traced.rebound(series.exp2_of_minus, names)(_Argument(f))
    ends = np.linspace(-0.5, 0.5, count + 1)
    inputs = {"f": Intervals(ends[:-1], ends[1:])}
    return rounding_bounds.relative_error(trace.nodes, result.place, inputs, EXP2)


class _Argument:
    """An argument whose distance from the nearest whole number is a traced number."""

    def __init__(self, f):
        self.f = f

    def __gt__(self, other):
        return False

    def __sub__(self, whole):
        return self.f


class _Whole:
    """The whole number nearest to such an argument."""

    def __init__(self, f):
        self.f = f

    def __add__(self, other):
        return 0


def turn_of_hyperbolic_pair(shifts=48, decays=97, quotients=48, omitted=()):
    """The turn of the internal pair by all roundings from the reduced phase on.

    Boxes of d in [0, pi/4], E = exp(-2|y|) and F = Q'/E.
    """
    exp2 = relative_error_of_exp2()
    d = np.linspace(0.0, math.pi / 4 * (1 + 1e-15), shifts + 1)
    e_ends = np.concatenate([[0.0], 10.0 ** np.linspace(-6.0, 0.0, decays)])
    e_ends[-1] = 1.0
    f_ends = np.linspace(0.0, 1.0, quotients + 1)
    counts = [np.arange(n) for n in (shifts, decays, quotients)]
    a, b, c = (grid.ravel() for grid in np.meshgrid(*counts, indexing="ij"))
    inside = e_ends[b] * f_ends[c] <= _LARGEST_NOME * 1.0001
    a, b, c = a[inside], b[inside], c[inside]
    e = Intervals(e_ends[b], e_ends[b + 1])
    f = Intervals(f_ends[c], f_ends[c + 1])
    nome = (e * f).within(0.0, _LARGEST_NOME)
    g = nome * e
    trace = traced.Trace()
    alpha = _rows(trace, "ab")
    ratio, e_in, f_in, g_in = trace.inputs("ratio", "e", "f", "g")
    pair = traced.rebound(series.hyperbolic_pair, traced.replacements())
    places = traced.flat(pair(alpha, ratio, 1.0, 0.0, (e_in, f_in, g_in)))
    inputs = {"e": e, "f": f, "g": g, "ratio": Intervals(1.0 - 1e-13, 1.0 + 1e-13)}
    for n, factor in enumerate((of(1.0), nome, nome.power(4), nome.power(9))):
        low, high = (2 * n + 1) * d[a], (2 * n + 1) * d[a + 1]
        inputs[f"a{n}"] = factor * _of_angle(np.cos, low, high)
        inputs[f"b{n}"] = factor * _of_angle(np.sin, low, high)
    # E errs by that of exp2, and by 2 u ln(1/E) through the roundings of dx and of its product with
    # the decay; E ln(1/E) is at most 1/e.  F has a division more; its derivative contains
    # Q' = E F, so that ln(1/E) may be taken with it.  G is a product.
    logs = np.where(
        e.hi < math.exp(-1.0), e.hi * np.log(1.0 / np.maximum(e.hi, 1e-300)), math.exp(-1.0)
    )
    more = {
        e_in.place: e.hi * exp2 + 2.0 * U * logs,
        f_in.place: f.hi * (exp2 + U + 2.0 * U * logs / e.hi),
        g_in.place: g.hi * (exp2 + U) + nome.hi * 2.0 * U * logs,
    }
    more = {place: size * (1.0 + 1e-6) for place, size in more.items()}
    return float(np.max(rounding_bounds.turn(trace.nodes, places, inputs, more, omitted)))


def _of_angle(function, low, high):
    """A sine or cosine over intervals of angles in [0, 6], widened by `SLACK` and libm's error."""
    first, last = function(low), function(high)
    least, most = np.minimum(first, last), np.maximum(first, last)
    for m in range(4):  # extrema at multiples of pi/2
        extremum = m * math.pi / 2
        inside = (low <= extremum) & (high >= extremum)
        value = round(float(function(extremum)))
        least = np.where(inside, np.minimum(value, least), least)
        most = np.where(inside, np.maximum(value, most), most)
    return Intervals(least - SLACK - 1e-15, most + SLACK + 1e-15)


# ---- Parts that are bounded by hand (docs/proof.md)

# Multiplication by cosine + i sine: (1 + |sine|) u on S3, whatever the pair.
TURNED = 4.0 * U * (1.0 + 1e-10)
# Four products with one scale, whose own error does not turn.
SCALED = 2.0 * U * (1.0 + 1e-10)
# The matrix of orthonormal columns: u (|x| + |z| + |(w, x)| + |(y, z)| + 1) on S3.
FRAME = 2.0 * (2.0 * math.sqrt(2.0) + 1.0) * U * (1.0 + 1e-10)
# tilt dx: half a unit in the last place of 1/4 of a turn, twice.
TILT = 2.0 * 2.0 * math.pi * 2.0 * 2.0**-57
# Uniform: two products and a sum of orthogonal unit quaternions.
COMBINED = 4.0 * U


def uniform(**keywords):
    """The whole loop of uniform rotation."""
    return turn_of_sine_cosine(**keywords) + COMBINED


def trigonometric(*boxes, **keywords):
    """The whole loop of the trigonometric form."""
    common = turn_of_sine_cosine() + TURNED + SCALED + FRAME
    return turn_of_trigonometric_pair(*boxes, **keywords) + common


def hyperbolic(*boxes, **keywords):
    """The whole loop of the hyperbolic form."""
    common = turn_of_sine_cosine() + TILT + TURNED + SCALED + FRAME
    return turn_of_hyperbolic_pair(*boxes, **keywords) + common


# ---- The whole loops, to be compared with what is compiled


class _Row:
    """A row of an array whose entry at any index is one input."""

    def __init__(self, node):
        self._node = node

    def __getitem__(self, index):
        return self if isinstance(index, (tuple, slice)) else self._node

    def __len__(self):
        return 1


def operations_of_loop(name, *, low, rates):
    """How often one epoch of a loop has each operation."""
    trace = traced.Trace()
    record = _record(trace, name)
    t = _Row(trace.input("t"))
    t_low = _Row(trace.input("t_low")) if low else None
    rows = []

    def stored(count):
        rows.extend({} for _ in range(count))
        return rows[-count:]

    names = traced.replacements() | {
        "any_beyond": lambda *arguments: False,
        "reach": lambda c: 0.0,
        "_four_rows": lambda *arguments: stored(4),
        "_three_rows": lambda *arguments: stored(3),
    }
    loop = traced.rebound(getattr(kernel, name), names)
    loop([record], t, t_low, None, True if rates else None, 0, 1, 0)
    return trace.counts([row[0].place for row in rows], ("t", "t_low"))


def _record(trace, name):
    """A record whose fields are inputs."""

    def pair(field):
        return trace.inputs(f"{field}0", f"{field}1")

    class Matrix:
        def __init__(self, field):
            self._field = field

        def __getitem__(self, index):
            if isinstance(index, tuple):
                return trace.input(f"{self._field}{index[0]}{index[1]}")
            return [trace.input(f"{self._field}{index}{k}") for k in range(5)]

    class Record:
        form = {"uniform": 0, "trigonometric": 1, "hyperbolic": 2}[name]
        precession, nutation, nutation0 = pair("g"), pair("f"), pair("x")
        winds, decay, nome, tilt = trace.inputs("winds", "decay", "nome", "tilt")
        alpha, beta, frame = Matrix("alpha"), Matrix("beta"), Matrix("frame")
        rates, axes = Matrix("rates"), Matrix("axes")

    return Record
