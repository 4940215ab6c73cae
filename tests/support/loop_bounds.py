"""Bounds of the roundings of the loops over epochs, for all bodies: the parts of docs/proof.md.

Each function traces the package's own source (`traced`) and bounds it over boxes
(`rounding_bounds`).  Angles are rotation angles, rad.
"""

import math

import numpy as np

from attitude._solver import kernel, series
from attitude.proof._error_bound import COS_EVEN, COS_ODD, SIN_EVEN, SIN_ODD, SLACK
from attitude.proof._intervals import UNIT_ROUNDOFF, Intervals, Turn, of
from tests.support import rounding_bounds, traced

U = UNIT_ROUNDOFF
# Largest errors of the polynomials of sine, cosine and 2**-f, absolute; the test encloses them.
SINE = 7.1e-18
COSINE = 1.71e-17
EXP2 = 1.6e-17
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


def coefficients_of(rho, shrunk):
    """Those of bodies (N,), each a pair: two rows of alpha, two rows of beta."""
    found = {key: x.lo + SLACK + 0.0 * rho for key, x in _coefficients(of(rho), of(shrunk)).items()}
    for k in range(len(rho)):
        rows = [[float(found[f"{row}{n}"][k]) for n in range(4)] for row in "abcd"]
        yield rows[:2], rows[2:]


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


def _of_angle(function, low, high, quarters=3):
    """A sine or cosine over intervals of angles, widened by `SLACK` and libm's error.

    The angles are from 0 to somewhat above so many quarters of a turn.
    """
    first, last = function(low), function(high)
    least, most = np.minimum(first, last), np.maximum(first, last)
    for m in range(quarters + 2):  # extrema at multiples of pi/2
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


# ---- How fast the pairs turn with their phases, and with the nome: constants of `error_bound`


def _grid(*counts):
    """Indices of all boxes of a grid, flat arrays."""
    return [x.ravel() for x in np.meshgrid(*(np.arange(n) for n in counts), indexing="ij")]


def turn_per_radian(rho=40, shrunk=40, phases=120):
    """The largest rotation angle of the trigonometric pair per rad of v.

    v in [0, pi/2]; beyond, only signs change.  Terms from n = 4 on are below 1e-15.
    """
    ends = [np.linspace(0.0, 1.0, n + 1) for n in (rho, shrunk)]
    v_ends = np.linspace(0.0, math.pi / 2 * (1 + 1e-15), phases + 1)
    a, b, c = _grid(rho, shrunk, phases)
    inside = ends[0][a] ** 4 * ends[1][b] ** 2 <= _LARGEST_NOME * 1.0001
    a, b, c = a[inside], b[inside], c[inside]
    rho, shrunk = (Intervals(x[k], x[k + 1]) for x, k in zip(ends, (a, b), strict=True))
    nome = (rho.square().square() * shrunk.square()).within(0.0, _LARGEST_NOME)
    outer = (rho.square().square() * shrunk).within(0.0, _LARGEST_OUTER)
    value, slope = [of(0.0)] * 4, [of(0.0)] * 4
    for n in range(4):
        sign = (-1.0) ** n
        first = outer.power(n) * nome.power(n * (n - 1)) * sign if n else of(1.0)
        second = rho * (outer.power(n) * nome.power(n * n) * sign if n else of(1.0))
        sizes = (
            first * (shrunk.power(2 * n) + 1.0) if n else of(1.0),
            -(first * (1.0 - shrunk.power(2 * n))) if n else of(0.0),
            -(second * (shrunk.power(2 * n + 1) + 1.0)),
            -(second * (1.0 - shrunk.power(2 * n + 1))),
        )
        for k, (size, times, wave) in enumerate(
            zip(sizes, (2 * n, 2 * n, 2 * n + 1, 2 * n + 1), "cssc", strict=True)
        ):
            sine, cosine = (
                _of_angle(f, times * v_ends[c], times * v_ends[c + 1], 2 * n + 1)
                for f in (np.sin, np.cos)
            )
            value[k] = value[k] + size * (cosine if wave == "c" else sine)
            slope[k] = slope[k] + size * float(times) * (-sine if wave == "c" else cosine)
    turn = Turn(value)
    turn.add(1.0, slope)
    return 2.0 * float(np.max(turn.total())) + 1e-12


def _hyperbolic_terms(shifts, decays, quotients):
    """Boxes of d, E, F and the nome, and sums over n of Q'^(n^2) cos or sin (2 n + 1) d times
    weights: a function of (weight of F^n, weight of G^n).
    """
    d = np.linspace(0.0, math.pi / 4 * (1 + 1e-15), shifts + 1)
    e_ends = np.concatenate([[0.0], 10.0 ** np.linspace(-6.0, 0.0, decays)])
    e_ends[-1] = 1.0
    f_ends = np.linspace(0.0, 1.0, quotients + 1)
    a, b, c = _grid(shifts, decays, quotients)
    inside = e_ends[b] * f_ends[c] <= _LARGEST_NOME * 1.0001
    a, b, c = a[inside], b[inside], c[inside]
    e, f = Intervals(e_ends[b], e_ends[b + 1]), Intervals(f_ends[c], f_ends[c + 1])
    nome = (e * f).within(0.0, _LARGEST_NOME)
    angles = [((2 * n + 1) * d[a], (2 * n + 1) * d[a + 1]) for n in range(4)]
    waves = [[_of_angle(function, *x) for x in angles] for function in (np.cos, np.sin)]
    return e, f, nome, waves


def _hyperbolic_sums(weights, waves):
    """The four components for weights (n, sign) -> what multiplies cos or sin of (2 n + 1) d.

    The pair is sum over n of Q'^(n^2) times (F^n + E G^n) cos, (F^n - E G^n) sin, and with
    alternating signs of F^n and G^n -(F^n - E G^n) cos, -(F^n + E G^n) sin.
    """
    rows = []
    for alternates, sign, wave in ((1, 1, 0), (1, -1, 1), (-1, -1, 0), (-1, 1, 1)):
        total = of(0.0)
        for n in range(4):
            total = total + weights(n, sign) * waves[wave][n] * float(alternates ** (n + 1))
        rows.append(total)
    return rows


def turn_per_y(shifts=32, decays=97, quotients=48):
    """The largest rotation angle of the hyperbolic pair per unit of y.

    d/dy of E, F = Q'/E and G = Q' E is -2 E, 2 F and -2 G.
    """
    e, f, nome, waves = _hyperbolic_terms(shifts, decays, quotients)

    def value(n, sign):
        return nome.power(n * n) * (f.power(n) + e * (nome * e).power(n) * float(sign))

    def slope(n, sign):
        falling = e * (nome * e).power(n) * float(-sign * (2 * n + 2))
        return nome.power(n * n) * (f.power(n) * float(2 * n) + falling)

    turn = Turn(_hyperbolic_sums(value, waves))
    turn.add(1.0, _hyperbolic_sums(slope, waves))
    return 2.0 * float(np.max(turn.total())) + 1e-12


def turn_per_nome(shifts=32, decays=97, quotients=48):
    """The largest turn on S3 by errors of F and G alone, per unit of the nome.

    An error of the nome changes both alike, one of E in opposite senses; F^n Q'^(n^2) has the
    derivative n F^n Q'^(n^2 - 1) by the nome, and G^n likewise.
    """
    e, f, nome, waves = _hyperbolic_terms(shifts, decays, quotients)

    def value(n, sign):
        return nome.power(n * n) * (f.power(n) + e * (nome * e).power(n) * float(sign))

    worst = 0.0
    for sense in (1, -1):

        def slope(n, sign, sense=sense):
            if n == 0:
                return of(0.0)
            both = f.power(n) + e * (nome * e).power(n) * float(sign * sense)
            return nome.power(n * n - 1) * both * float(n)

        turn = Turn(_hyperbolic_sums(value, waves))
        turn.add(1.0, _hyperbolic_sums(slope, waves))
        worst = max(worst, float(np.max(turn.total())) + 1e-12)
    return worst
