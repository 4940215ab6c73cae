"""Magnitudes of a rotating ellipsoid with all derivatives, and its fit from many starts.

The brightness of `attitude.light_curve._sums` as a function of the three products of the
directions of Sun and observer with the matrix of the ellipsoid, P^2, Q^2 and p.q.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from attitude._compilation.decorators import reduction, reduction_subroutine, reduction_within
from attitude._compilation.elementary import binary_logarithm
from attitude._compilation.simd import at_least, at_most, chosen, eight, put_eight, root, summed_up
from attitude._support import least_squares
from attitude._support.arrays import distinct, units
from attitude._support.constants import MAGNITUDES_PER_E
from attitude._support.least_squares import Near
from attitude.inversion import _motions
from attitude.inversion._lattices import Candidate
from attitude.inversion._motions import (
    LANES,
    fill_attitudes,
    matrix_rows,
    moments,
    put_three,
    three,
    with_slopes,
)

if TYPE_CHECKING:
    from attitude._support.annotations import BoolArray, FloatArray, IntArray
    from attitude.inversion._problem import CurveProblem


# Rows of the Jacobian: rotation vector (3), precession, nutation, phase (turns), ln rho, X, and
# two logarithms of squared ratios of axes.
PARAMETERS = 10
# Magnitudes of a factor 2.
_OF_TWO = -2.5 * math.log10(2.0)
_TURN = 2.0 * math.pi
# Rows are multiplied by fours.
_FOUR = 4
# Rows of a state: its residuals, its Jacobian, and an empty one.
_ROWS = 12


def _aligned(shape: tuple[int, ...]) -> FloatArray:
    """An array of zeros that begins with a cache line: twice as fast to read by vectors."""
    count = math.prod(shape)
    memory = np.zeros(count + 7)
    skipped = -(memory.ctypes.data // 8) % 8
    return memory[skipped : skipped + count].reshape(shape)


def _span(rows: FloatArray) -> tuple[int, int]:
    """First and end of vectors of epochs where rows (4, N) are not all 0; all of empty rows."""
    on = np.flatnonzero(rows.any(axis=0))
    if not on.size:
        return 0, rows.shape[1]
    return int(on[0]) // LANES * LANES, (int(on[-1]) // LANES + 1) * LANES


class EllipsoidCurve:
    """Magnitudes of ellipsoids against those of a problem, for many states (S, 16) at a time."""

    def __init__(self, problem: CurveProblem) -> None:
        t = _motions.padded(problem.t)
        sun, observer = _motions.padded(problem.sun), _motions.padded(problem.observer)
        # epochs that fill up the last vector have no weight
        weight = _motions.padded(problem.root, "constant")
        y = _motions.padded(problem.y)
        self._epochs = t, sun.reshape(-1), observer.reshape(-1), y, weight
        self._tally, self._settings = problem.tally, problem.settings
        count = len(problem.u)
        self._turns, self._tangents = _aligned((2, 9 * t.size))
        self._memory = _aligned((_ROWS + count + -count % _FOUR, t.size))
        self._memory[_ROWS : _ROWS + count, : len(problem)] = problem.u
        self._spans = np.array([_span(rows) for rows in self._memory.reshape(-1, _FOUR, t.size)])
        # (12, N), residuals of the last state, and their Jacobian, as in `residuals`
        self.rows = self._memory[:_ROWS]

    def _products(self, states: FloatArray, size: int, tangents: FloatArray) -> FloatArray:
        """Products (S, size, size) of the first rows."""
        products = np.empty((len(states), size, size))
        of_rows = np.empty((size + 1, len(self._memory)))
        rows = self._memory.reshape(-1)
        of_fours = rows, self._spans, of_rows
        _products(states, *self._epochs, self._turns, tangents, *of_fours, products)
        return products

    def costs(self, states: FloatArray) -> FloatArray:
        """The sums of squares (S,) of weighted residuals, least over the linear terms."""
        self._tally.add(len(states) * self.rows.shape[1], self._settings.screen_cost)
        return self._products(states, 1, self._tangents[:0])[:, 0, 0]

    def products(self, states: FloatArray) -> FloatArray:
        """Products (S, 11, 11) of the weighted residuals and the rows of their Jacobian.

        The residual is y - magnitude, the Jacobian that of the magnitude.
        """
        points = len(states) * self.rows.shape[1]
        self._tally.add(points, self._settings.ellipsoid_cost)
        self._tally.add(points * (len(self._memory) - _ROWS), self._settings.term_cost)
        self._tally.add(len(states), self._settings.start_cost)
        return self._products(states, 1 + PARAMETERS, self._tangents)


@reduction_within
def _turned(x, y, z, m0, m1, m2, m3, m4, m5, m6, m7, m8):
    """The components of a vector along the columns of a matrix, which is given by rows."""
    return m0 * x + m3 * y + m6 * z, m1 * x + m4 * y + m7 * z, m2 * x + m5 * y + m8 * z


@reduction_within
def _along(x, y, z, array, at, n):
    """The product of a vector with one stored in rows of n numbers."""
    u, v, w = three(array, at, n)
    return x * u + y * v + z * w


@reduction_within
def _dimming(u, y):
    """G and its derivative by u, y = 1 - u; see `light_curve._sums`."""
    s = at_most(u, 0.0625)
    x = root(at_least(u, 0.0625))
    atanh = (0.5 * math.log(2.0)) * binary_logarithm((1.0 + x) * (1.0 + x) / y)
    over = 1.0 / x
    square = over * over
    closed = (x - y * atanh) * square * over
    slope = square * (atanh * over - 1.5 * closed)
    g = s * 0.010256410256410256 + 0.013986013986013986
    g = s * g + 0.020202020202020204
    g = s * g + 0.031746031746031744
    g = s * g + 0.05714285714285714
    g = s * g + 0.13333333333333333
    g = s * g + 0.6666666666666666
    d = s * 0.06153846153846154 + 0.06993006993006994
    d = s * d + 0.08080808080808081
    d = s * d + 0.09523809523809523
    d = s * d + 0.11428571428571428
    d = s * d + 0.13333333333333333
    by = u - 0.0625
    return chosen(by, closed, g), chosen(by, slope, d)


@reduction_subroutine
def residuals(state, t, sun, observer, y, weight, r, g, rows):
    """Residuals y - magnitude of a state (16,), times weight, and derivatives of the magnitude.

    Into rows (12 N,): residuals, then the Jacobian, times weight; or residuals alone, if g is
    empty.  r and g are as in `_motions.fill_attitudes`; sun and observer (3 N,) are unit vectors by
    components, t, y, weight (N,); N is a multiple of eight.
    """
    n = t.size
    c0, c1, c2 = state[5], state[6], state[7]
    c3, c4, c5 = state[8], state[9], state[10]
    c6, c7, c8 = state[11], state[12], state[13]
    fa, fb = math.exp(state[14]), math.exp(state[15])
    for i in range(0, n, 8):
        r0, r1, r2 = three(r, i, n)
        r3, r4, r5 = three(r, i + 3 * n, n)
        r6, r7, r8 = three(r, i + 6 * n, n)
        a, b, c = three(sun, i, n)
        a, b, c = _turned(a, b, c, c0, c1, c2, c3, c4, c5, c6, c7, c8)
        sa, sb, sc = _turned(a, b, c, r0, r1, r2, r3, r4, r5, r6, r7, r8)
        a, b, c = three(observer, i, n)
        a, b, c = _turned(a, b, c, c0, c1, c2, c3, c4, c5, c6, c7, c8)
        oa, ob, oc = _turned(a, b, c, r0, r1, r2, r3, r4, r5, r6, r7, r8)
        pp = fa * sa * sa + fb * sb * sb + sc * sc
        qq = fa * oa * oa + fb * ob * ob + oc * oc
        pq = fa * sa * oa + fb * sb * ob + sc * oc
        p, q = root(pp), root(qq)
        m = at_least(p * q + pq, 1e-12)
        total = p + q
        over = 1.0 / total
        u = (pp + qq + 2.0 * pq) * over * over
        value, slope = _dimming(u, at_least(1.0 - u, 1e-15))
        w = eight(weight, i)
        put_eight(rows, i, (eight(y, i) - _OF_TWO * binary_logarithm(m * over * value)) * w)
        if g.size == 0:
            continue
        w = -MAGNITUDES_PER_E * w
        slope = w * slope / value * over * over
        in_m, in_total = w / m, 0.0 - w * over - 2.0 * slope * u * total
        by_p, by_q = in_m * q + in_total, in_m * p + in_total
        by_pp, by_qq = by_p / p + 2.0 * slope, by_q / q + 2.0 * slope
        by_pq = in_m + 2.0 * slope
        # by the vectors s and o over body axes
        va, wa = fa * (by_pp * sa + by_pq * oa), fa * (by_qq * oa + by_pq * sa)
        vb, wb = fb * (by_pp * sb + by_pq * ob), fb * (by_qq * ob + by_pq * sb)
        vc, wc = by_pp * sc + by_pq * oc, by_qq * oc + by_pq * sc
        put_eight(rows, i + 9 * n, 0.5 * (va * sa + wa * oa))
        put_eight(rows, i + 10 * n, 0.5 * (vb * sb + wb * ob))
        # their cross products with s and o over body axes, summed, over the axes of r
        a = vb * sc - vc * sb + wb * oc - wc * ob
        b = vc * sa - va * sc + wc * oa - wa * oc
        c = va * sb - vb * sa + wa * ob - wb * oa
        a, b, c = _turned(a, b, c, r0, r3, r6, r1, r4, r7, r2, r5, r8)
        put_three(rows, i + n, n, a, b, c)
        at = eight(t, i)
        v = _TURN * _along(a, b, c, g, i, n)
        put_three(rows, i + 4 * n, n, (2.0 * _TURN) * at * c, at * v, v)
        put_eight(rows, i + 7 * n, _along(a, b, c, g, i + 3 * n, n))
        put_eight(rows, i + 8 * n, _along(a, b, c, g, i + 6 * n, n))


@reduction_within
def _two_by_four(rows, a, b, n, first, end):
    """Products of two rows of n numbers, from a on, with four, from b on: numbers first to end."""
    a, b, last = a + first, b + first, end - first
    x, y = eight(rows, a), eight(rows, a + n)
    z = eight(rows, b)
    p0, q0 = x * z, y * z
    z = eight(rows, b + n)
    p1, q1 = x * z, y * z
    z = eight(rows, b + 2 * n)
    p2, q2 = x * z, y * z
    z = eight(rows, b + 3 * n)
    p3, q3 = x * z, y * z
    for i in range(8, last, 8):
        x, y = eight(rows, a + i), eight(rows, a + n + i)
        z = eight(rows, b + i)
        p0, q0 = p0 + x * z, q0 + y * z
        z = eight(rows, b + n + i)
        p1, q1 = p1 + x * z, q1 + y * z
        z = eight(rows, b + 2 * n + i)
        p2, q2 = p2 + x * z, q2 + y * z
        z = eight(rows, b + 3 * n + i)
        p3, q3 = p3 + x * z, q3 + y * z
    return (
        summed_up(p0),
        summed_up(p1),
        summed_up(p2),
        summed_up(p3),
        summed_up(q0),
        summed_up(q1),
        summed_up(q2),
        summed_up(q3),
    )


@reduction
def _products(states, t, sun, observer, y, weight, r, g, rows, spans, of_rows, out):
    """Products of the residuals and derivatives of states (S, 16), into out (S, R, R).

    R is 11, or 1 for residuals alone, where g is empty.  rows ((12 + L) N,): those of a state as in
    `residuals`, which are overwritten, then L that are projected out, every four of which are zero
    outside of a span (3 + L / 4, 2); of_rows (R + 1, 12 + L) is working memory; L is a multiple of
    four.  The others are as in `residuals`.
    """
    n, count, columns = t.size, out.shape[1], of_rows.shape[1]
    for number in range(states.shape[0]):
        fill_attitudes(states[number], t, r, g)
        residuals(states[number], t, sun, observer, y, weight, r, g, rows)
        for row in range(0, count, 2):
            for column in range(0, columns, 4):
                if row + 1 < column < _ROWS:
                    continue
                first, end = spans[column // 4, 0], spans[column // 4, 1]
                sums = _two_by_four(rows, row * n, column * n, n, first, end)
                for k in range(4):
                    of_rows[row, column + k] = sums[k]
                    of_rows[row + 1, column + k] = sums[4 + k]
        for row in range(count):
            for column in range(row + 1):
                product = of_rows[row, column]
                for k in range(_ROWS, columns):
                    product -= of_rows[row, k] * of_rows[column, k]
                out[number, row, column] = out[number, column, row] = product


# ---- Least squares of the ellipsoid, linearised
# A start is a row of 16 numbers: five elements, the orientation (9) of the axes along the momentum,
# and two logarithms of squared ratios of axes, ln (c/a)^2 and ln (c/b)^2.  Terms in which the
# magnitude is linear are projected out of each residual and derivative.
#
# Magnitudes and derivatives are compiled; the steps of all starts are arrays of numpy, of which
# nothing has to be compiled.

# Entries of a start.
WIDTH = 16
# Where the entries of `SearchState` stand in a state, for batches and for changes in place.
OF_PRECESSION = 0
OF_NUTATION = 1
OF_PHASE = 2
OF_LOG_RHO = 3
OF_X = 4
OF_FRAME = slice(5, 14)
OF_FLAT = slice(14, 16)
OF_MODES = slice(16, None)
# Precession and nutation.
OF_RATES = slice(0, 2)
# All five elements.
OF_ELEMENTS = slice(0, 5)
# The ellipsoid and the modes.
OF_SHAPE = slice(14, None)
# The direction of the angular momentum, the third column of the orientation.
OF_POLE = [7, 10, 13]
# The elements that the moments follow from.
OF_MOMENTS = [OF_PRECESSION, OF_NUTATION, OF_LOG_RHO, OF_X]
# Bounds of ln rho.
LEAST_RHO = -8.0
MOST_RHO = -0.01
# Bounds of X.
LEAST_X = -0.3
MOST_X = 0.95
# The largest size of the logarithms of the shape.
MOST_RATIO = 6.0
# Longest step: rad of orientation, turns of phase, ln rho, X, logarithms of the shape.
_LONGEST = 0.6
_RULE = least_squares.Rule(
    start=3e-3, least=1e-9, stuck=1e8, larger=4.0, gain=1e-4, settled=4, ridge=1e-13
)
# Standard deviation of the logarithms of squared ratios of axes before the curve is seen.
_RATIOS = 1.5


class SearchState(NamedTuple):
    """The entries of a state by name."""

    precession: float  # lambda / 2 pi, turns per span
    nutation: float  # f, signed by the mode, turns per span
    phase: float  # turns, at the middle of the span
    log_rho: float  # of the normal form, as x
    x: float
    frame: FloatArray  # (3, 3), axes along the momentum, columns, ICRF
    flat: FloatArray  # (2,), logarithms of squared ratios of axes
    modes: FloatArray  # (M,) of the areas, none for an ellipsoid; and a drift of the rates, if any

    @classmethod
    def of(cls, state: FloatArray) -> SearchState:
        """Those of a vector (16 or more,)."""
        precession, nutation, phase, log_rho, x = state[OF_ELEMENTS].tolist()
        frame = state[OF_FRAME].reshape(3, 3)
        return cls(precession, nutation, phase, log_rho, x, frame, state[OF_FLAT], state[OF_MODES])

    @property
    def vector(self) -> FloatArray:
        """The state as a vector (16 + M,)."""
        return np.concatenate([self[:5], self.frame.ravel(), self.flat, self.modes])

    @property
    def pole(self) -> FloatArray:
        """The direction (3,) of the angular momentum, ICRF."""
        return self.frame[:, 2]

    @property
    def is_axial(self) -> bool:
        """Whether this is rotation about one axis."""
        return self.log_rho == AXIAL

    @property
    def rates(self) -> tuple[float, float]:
        """Frequencies of phi of the long axis and of psi, turns per span; psi 0 for one axis."""
        twice = 2.0 * self.precession
        if self.is_axial:
            return twice, 0.0
        return twice - max(self.nutation, 0.0), abs(self.nutation)


def is_axial(state: FloatArray) -> bool:
    """Whether a state (16 or more,) is rotation about one axis."""
    return bool(state[OF_LOG_RHO] == AXIAL)


def is_admissible(state: FloatArray) -> bool:
    """Whether a body has the moments of a state (16 or more,)."""
    return is_axial(state) or bool(moments(state[OF_MOMENTS]).exists)


def without_nutation(state: FloatArray) -> FloatArray:
    """Rotation about one axis with attitude at t = 0, rate, shape of a state (16 or more,)."""
    rotation = state.copy()
    rotation[OF_ELEMENTS] = state[OF_PRECESSION], 0.0, 0.0, AXIAL, 0.0
    zero = np.zeros(1)
    body, turned = (_motions.at_epochs(one, zero).matrix.reshape(3, 3) for one in (state, rotation))
    rotation[OF_FRAME] = (state[OF_FRAME].reshape(3, 3) @ body @ turned.T).ravel()
    return rotation


def have_rates(states: FloatArray, state: FloatArray, width: float) -> BoolArray:
    """Which states (..., 16 or more) have mode and rates of one, to a width in turns per span."""
    alike = 2.0 * np.abs(states[..., OF_PRECESSION] - state[OF_PRECESSION]) < width
    axial = states[..., OF_LOG_RHO] == AXIAL
    if is_axial(state):
        return np.asarray(alike & axial)
    has_nutation = np.abs(states[..., OF_NUTATION] - state[OF_NUTATION]) < width
    return np.asarray(alike & ~axial & has_nutation)


def have_pole(a: FloatArray, b: FloatArray, width: float) -> bool:
    """Whether the poles of two states lie within an angle, rad."""
    return bool(a[OF_POLE] @ b[OF_POLE] > math.cos(width))


class Held(NamedTuple):
    """What is known of the moments of the motion beside the curve."""

    width: float = math.inf  # standard deviation of logarithms from the ellipsoid's, or given ones
    # the logarithms of these, ascending
    moments: tuple[float, float, float] = (math.nan, math.nan, math.nan)


def are_allowed(states: FloatArray) -> BoolArray:
    """Which of the states (..., 16 or more) are within the bounds."""
    log_rho, x = states[..., OF_LOG_RHO], states[..., OF_X]
    inside = (x > LEAST_X) & (x < MOST_X) & (log_rho > LEAST_RHO) & (log_rho < MOST_RHO)
    is_body = np.all(np.abs(states[..., OF_FLAT]) < MOST_RATIO, axis=-1)
    return np.asarray(is_body & (inside | (log_rho == AXIAL)))


def moved(states: FloatArray, steps: FloatArray) -> FloatArray:
    """States (..., W) after steps (..., 10 or more): orientations are turned about their own axes.

    What a state has beyond the 16 numbers stays.
    """
    new = states.copy()
    _move(new.reshape(-1, states.shape[-1]), steps.reshape(-1, steps.shape[-1]))
    return new


@reduction
def _move(states, steps):
    """Take steps as in `moved`."""
    for i in range(states.shape[0]):
        half = 0.5 * math.sqrt(steps[i, 0] ** 2 + steps[i, 1] ** 2 + steps[i, 2] ** 2)
        w, s = math.cos(half), 0.5 * (math.sin(half) / half if half > 0.0 else 1.0)
        turn = matrix_rows(w, s * steps[i, 0], s * steps[i, 1], s * steps[i, 2])
        for k in range(5, 14, 3):
            a, b, c = states[i, k], states[i, k + 1], states[i, k + 2]
            for j in range(3):
                states[i, k + j] = a * turn[0][j] + b * turn[1][j] + c * turn[2][j]
        for k in range(5):
            states[i, k] += steps[i, 3 + k]
        states[i, 14] += steps[i, 8]
        states[i, 15] += steps[i, 9]


def _wanted(states: FloatArray, tie: Held) -> FloatArray:
    """Logarithms (2, S) of I1/I3 and I2/I3 of the ellipsoids, or of the moments given."""
    if math.isnan(tie.moments[0]):
        a, b = np.exp(-states[:, OF_FLAT]).T
        return np.log([(b + 1.0) / (a + b), (a + 1.0) / (a + b)])
    # the third axis is the long one in long-axis mode; X < 0 exchanges the first two
    low, middle, high = tie.moments
    is_long = states[:, OF_NUTATION] > 0.0
    third, first = np.where(is_long, low, high), np.where(is_long, high, low)
    both = np.array([first, np.full(len(states), middle)]) - third
    return np.where(states[:, OF_X] >= 0.0, both, both[::-1])


def log_ratios(states: FloatArray) -> tuple[FloatArray, FloatArray]:
    """ln I1/I3 and ln I2/I3 (S, 2) of the motions of states, and slopes (S, 2, 10)."""
    ratios, by_elements = np.empty((len(states), 2)), np.empty((len(states), 2, 4))
    with_slopes(states, ratios, by_elements)
    slopes = np.zeros((len(states), 2, PARAMETERS))
    slopes[:, :, 3:5], slopes[:, :, 6:8] = by_elements[:, :, :2], by_elements[:, :, 2:]
    return ratios, slopes


def _tied(states: FloatArray, tie: Held) -> tuple[FloatArray, FloatArray]:
    """Differences of the logarithms of the moments of the motions from those wanted, over the tie.

    An array (S, 2), and its derivatives (S, 2, 10) by the parameters.
    """
    ratios, rows = log_ratios(states)
    if math.isnan(tie.moments[0]):
        a, b = np.exp(-states[:, OF_FLAT]).T
        rows[:, 0, 8], rows[:, 0, 9] = -a / (a + b), b / (b + 1.0) - b / (a + b)
        rows[:, 1, 8], rows[:, 1, 9] = a / (a + 1.0) - a / (a + b), -b / (a + b)
    return (ratios - _wanted(states, tie).T) / tie.width, rows / tie.width


def _cost(curve: EllipsoidCurve, states: FloatArray, tie: Held) -> FloatArray:
    """The sums of squares (S,) of states, with those of the priors."""
    values = curve.costs(states) + 1.0 / _RATIOS**2 * np.sum(states[:, OF_FLAT] ** 2, axis=1)
    if tie.width < math.inf:
        ratios = moments(states[:, OF_MOMENTS].T).log_ratios
        values += np.sum((ratios - _wanted(states, tie)) ** 2, axis=0) / tie.width**2
    return values


def _linearised(curve: EllipsoidCurve, states: FloatArray, fixed: BoolArray, tie: Held) -> Near:
    """The sums of squares near states, with those of the priors."""
    products = curve.products(states)
    if tie.width < math.inf:
        _add_rows(*_tied(states, tie), products)
    cost, normal, gradient = products[:, 0, 0], products[:, 1:, 1:], products[:, 1:, 0]
    shape, weight = states[:, OF_FLAT], 1.0 / _RATIOS**2
    cost += weight * np.sum(shape**2, axis=1)
    normal[:, [8, 9], [8, 9]] += weight
    gradient[:, 8:] -= weight * shape
    if fixed.any():
        gradient[:, fixed] = normal[:, fixed] = normal[:, :, fixed] = 0.0
        normal[:, fixed, fixed] = 1.0
    return Near(states, cost, normal, gradient)


@reduction
def _add_rows(values, slopes, products):
    """Add those of residuals (S, R), and slopes (S, R, P), to products (S, 1 + P, 1 + P)."""
    for i in range(values.shape[0]):
        for row in range(values.shape[1]):
            value = values[i, row]
            products[i, 0, 0] += value * value
            for k in range(slopes.shape[2]):
                slope = slopes[i, row, k]
                products[i, 1 + k, 0] -= value * slope
                for j in range(slopes.shape[2]):
                    products[i, 1 + k, 1 + j] += slope * slopes[i, row, j]


def _steps(linearised: Near, damping: FloatArray) -> FloatArray:
    """As `least_squares.damped_steps`."""
    steps = linearised.gradient.copy()
    _solve(linearised.normal, damping, np.empty(linearised.normal.shape[1:]), steps)
    return steps


@reduction
def _solve(normal, damping, lower, steps):
    """Replace gradients (S, P) by damped steps: Cholesky's factors, whose memory is lower (P, P).

    A pivot that rounding makes smaller than the damping counts as this.
    """
    size = lower.shape[0]
    for i in range(steps.shape[0]):
        step, more = steps[i], damping[i]
        for j in range(size):
            scale = math.sqrt(max(normal[i, j, j], 0.0)) + 1e-12
            for k in range(j + 1):
                lower[j, k] = normal[i, j, k]
            lower[j, j] += more * scale * scale
            for k in range(j):
                total = lower[j, k]
                for m in range(k):
                    total -= lower[j, m] * lower[k, m]
                lower[j, k] = total * lower[k, k]
            pivot, total = lower[j, j], step[j]
            for m in range(j):
                pivot -= lower[j, m] * lower[j, m]
                total -= lower[j, m] * step[m]
            # the diagonal of the factor is kept as its inverse
            lower[j, j] = 1.0 / math.sqrt(max(pivot, more * scale * scale))
            step[j] = total * lower[j, j]
        for j in range(size - 1, -1, -1):
            total = step[j]
            for m in range(j + 1, size):
                total -= lower[m, j] * step[m]
            step[j] = total * lower[j, j]


def costs(problem: CurveProblem, starts: FloatArray) -> FloatArray:
    """The sum of squares (S,) of each start (S, 16)."""
    return EllipsoidCurve(problem).costs(starts)


# ---- Ellipsoids from many starts: for given rates, random orientations, phases and shapes

# ln rho of rotation about an axis, which is then fixed with f, the phase and X.
AXIAL = -20.0
AXIAL_FIXED = np.array([False, False, False, False, True, True, True, True, False, False])
_FREE = np.zeros(10, bool)
# Ratios of axes of the starts, from and to.
_AXES = (1.1, 3.0)
# rho of the starts, from and to.
_RHO = (0.08, 0.9)
# The largest X of the starts, in long- and in short-axis mode.
_X = (0.3, 0.65)
_FREELY = Held()
# Starts about a pole.
_AROUND = 8
# Random states of which a start is the best.
_SCREENS = 8
# Relative difference of costs of two minima.
_DISTINCT = 1e-3


class Pool(NamedTuple):
    """States (S, 16) of `_ellipsoid`, the best first, and their costs (S,)."""

    cost: FloatArray
    states: FloatArray

    def rows(self, chosen: IntArray) -> Pool:
        """Some of them."""
        return Pool(self.cost[chosen], self.states[chosen])


def rotations(generator: np.random.Generator, count: int) -> FloatArray:
    """Uniformly random rotation matrices (count, 9)."""
    w, x, y, z = units(generator.standard_normal((count, 4))).T
    entries = (
        1 - 2 * (y * y + z * z),
        2 * (x * y - w * z),
        2 * (x * z + w * y),
        2 * (x * y + w * z),
        1 - 2 * (x * x + z * z),
        2 * (y * z - w * x),
        2 * (x * z - w * y),
        2 * (y * z + w * x),
        1 - 2 * (x * x + y * y),
    )
    return np.stack(entries, axis=-1)


def frames_of(generator: np.random.Generator, poles: FloatArray) -> FloatArray:
    """Matrices (P, 9) whose third columns are directions (P, 3), turned about them at random."""
    first = np.cross(poles, generator.standard_normal(poles.shape))
    first /= np.linalg.norm(first, axis=1)[:, None]
    return np.stack([first, np.cross(poles, first), poles], axis=-1).reshape(-1, 9)


def starts(
    generator: np.random.Generator, precession: FloatArray, nutation: FloatArray
) -> FloatArray:
    """A random start (S, 16) for each pair of rates (S,), turns per span."""
    count = len(precession)
    states = np.empty((count, WIDTH))
    long_axis = nutation > 0.0
    states[:, OF_PRECESSION] = precession
    states[:, OF_NUTATION] = nutation
    states[:, OF_PHASE] = generator.random(count)
    states[:, OF_LOG_RHO] = np.log(generator.uniform(*_RHO, count))
    states[:, OF_X] = any_x(generator, nutation)
    states[:, OF_FRAME] = rotations(generator, count)
    ratios = np.sort(generator.uniform(*_AXES, (count, 2)), axis=1)
    ratios = np.concatenate([np.ones((count, 1)), ratios], axis=1)
    axes = np.where(long_axis[:, None], ratios, ratios[:, ::-1])
    flat = -2.0 * np.log(axes)
    states[:, OF_FLAT] = flat[:, :2] - flat[:, 2:]
    return states


def any_x(generator: np.random.Generator, nutation: FloatArray) -> FloatArray:
    """A random X of a start for each nutation (S,), turns per span."""
    return generator.random(len(nutation)) * np.where(nutation > 0.0, *_X)


def minimised(
    problem: CurveProblem,
    starts: FloatArray,
    iterations: int,
    *,
    tie: Held = _FREELY,
    fixed: BoolArray = _FREE,
) -> Pool:
    """The least sums of squares near starts (S, 16), and where they lie, in their order.

    Infinite for starts outside of the bounds.  fixed: (10,), the parameters that stay.
    """
    curve = EllipsoidCurve(problem)

    def stepped(states: FloatArray, steps: FloatArray) -> tuple[FloatArray, BoolArray]:
        size = np.abs(steps[:, 5:]) * (6.0, 2.0, 4.0, 1.0, 1.0)
        longest = np.maximum(np.sqrt(np.sum(steps[:, :3] ** 2, axis=1)), size.max(axis=1))
        new = moved(states, steps * (_LONGEST / np.maximum(longest, _LONGEST))[:, None])
        return new, are_allowed(new)

    fitted = least_squares.Problem(
        lambda states: _linearised(curve, states, fixed, tie),
        stepped,
        lambda states: _cost(curve, states, tie),
        steps=_steps,
    )
    on = are_allowed(starts)
    pool = Pool(np.full(len(starts), np.inf), starts.copy())
    best = least_squares.minimum(fitted, starts[on], _RULE, iterations)
    pool.cost[on], pool.states[on] = best.cost, best.states
    return pool


def screened(problem: CurveProblem, states: FloatArray, groups: int) -> FloatArray:
    """The best state (groups, 16) of each of so many equal groups."""
    return best_of_each(Pool(costs(problem, states), states), groups).states


def around(
    problem: CurveProblem,
    generator: np.random.Generator,
    rates: list[Candidate],
    count: int,
    *,
    iterations: int,
    screens: int = _SCREENS,
    tie: Held = _FREELY,
    poles: FloatArray | None = None,
) -> Pool:
    """Minima from `count` random starts for each pair of rates, in the order of the rates.

    Each start is the best of `screens` random ones; of every two starts one has one of the poles
    (R, P, 3) of its rates in turn, if there are any.
    """
    pairs_of_rates = np.repeat(np.array(rates), count * screens, axis=0)
    first_states = starts(generator, pairs_of_rates[:, 0], pairs_of_rates[:, 1])
    if poles is not None:
        frames = first_states[:, OF_FRAME].reshape(len(rates), count, screens, 9)
        number = np.arange(count // 2) % poles.shape[1]
        known = np.repeat(poles[:, number, None], screens, axis=2)
        directions = frames_of(generator, known.reshape(-1, 3))
        frames[:, 1::2] = directions.reshape(len(rates), -1, screens, 9)
        first_states[:, OF_FRAME] = frames.reshape(-1, 9)
    chosen = screened(problem, first_states, len(rates) * count)
    return minimised(problem, chosen, iterations, tie=tie)


def deep(
    problem: CurveProblem,
    generator: np.random.Generator,
    rate: Candidate,
    count: int,
    *,
    tie: Held,
) -> Pool:
    """The best minima from `count` random starts for a pair of rates.

    All take twelve steps, the best two fifths 28 more: in two curves one best minimum in sixty was
    not among these.
    """
    pool = in_order(around(problem, generator, [rate], count, iterations=12, tie=tie))
    return minimised(problem, pool.states[: max(2 * count // 5, 1)], 28, tie=tie)


def narrowed(
    problem: CurveProblem,
    generator: np.random.Generator,
    rates: list[Candidate],
    count: int,
    *,
    tie: Held,
    poles: FloatArray | None,
) -> Pool:
    """The best minimum of each pair of rates: of many starts a few steps, of the best more.

    `count` starts, each the best of some random ones, take four steps; of the better half of the
    rates half of them take six more, and a third ten more: after four steps the best start alone
    often is not the one of a needle.  The first steps are fitted to every second point: true rates
    have the same rank.  poles (R, P, 3) as in `around`.
    """
    half = problem.part(np.arange(len(problem)) % 2 == 0)
    pool = around(half, generator, rates, count, screens=4, iterations=4, tie=tie, poles=poles)
    pool.cost[:] *= len(problem) / len(half)
    for kept, steps in ((max(count // 2, 1), 6), (max(count // 3, 1), 10)):
        cost = pool.cost.reshape(len(rates), -1)
        order = np.argsort(cost, axis=1, kind="stable")[:, :kept]
        least = cost.min(axis=1)
        pool = pool.rows((order + cost.shape[1] * np.arange(len(rates))[:, None]).ravel())
        on = np.flatnonzero(np.repeat(least <= np.median(least), kept))
        more = minimised(problem, pool.states[on], steps, tie=tie)
        # those of the better half are costs of all points from here on
        pool.cost[on], pool.states[on] = more
    return best_of_each(pool, len(rates))


def best_of_each(pool: Pool, groups: int) -> Pool:
    """The best state of each of so many equal groups."""
    cost = np.where(np.isfinite(pool.cost), pool.cost, np.inf).reshape(groups, -1)
    return pool.rows(np.argmin(cost, axis=1) + cost.shape[1] * np.arange(groups))


def in_order(*pools: Pool) -> Pool:
    """All states of pools, the best first."""
    pool = Pool(*(np.concatenate(columns) for columns in zip(*pools, strict=True)))
    order = np.argsort(pool.cost, kind="stable")
    return pool.rows(order[np.isfinite(pool.cost[order])])


def axial(
    problem: CurveProblem, generator: np.random.Generator, rates: FloatArray, count: int
) -> Pool:
    """Rotations about one axis at rates (turns per span), from `count` starts for each."""
    first_states = _axial_starts(generator, 0.5 * np.repeat(rates, count * _SCREENS))
    chosen = screened(problem, first_states, len(rates) * count)
    return minimised(problem, chosen, 30, fixed=AXIAL_FIXED)


def _axial_starts(generator: np.random.Generator, precession: FloatArray) -> FloatArray:
    """A random start (S, 16) about one axis for each rate (S,)."""
    states = starts(generator, precession, np.full(len(precession), -1.0))
    states[:, OF_PHASE] = 0.0
    states[:, OF_LOG_RHO] = AXIAL
    states[:, OF_X] = 0.0
    return states


def axial_at_poles(
    problem: CurveProblem,
    generator: np.random.Generator,
    rates: FloatArray,
    poles: FloatArray,
    keep: int,
) -> Pool:
    """Rotations at rates (P,), turns per span, about directions (P, 3), which stay.

    `keep` for each, the best of some starts, in the order of the poles.
    """
    count, size = len(poles), _AROUND * _SCREENS
    first_states = _axial_starts(generator, np.repeat(0.5 * rates, size))
    first_states[:, OF_FRAME] = frames_of(generator, np.repeat(poles, size, axis=0))
    chosen = screened(problem, first_states, count * _AROUND)
    fixed = AXIAL_FIXED.copy()
    fixed[:2] = True
    pool = minimised(problem, chosen, 20, fixed=fixed)
    costs = pool.cost.reshape(count, _AROUND)
    at = np.argsort(costs, axis=1, kind="stable")
    ordered = np.take_along_axis(costs, at, axis=1)
    # starts that end at one minimum count once
    new = np.diff(ordered, axis=1, prepend=-np.inf) > _DISTINCT * np.abs(ordered)
    rank = np.where(new & np.isfinite(ordered), np.cumsum(new, axis=1), keep + 1)
    row, column = np.nonzero(rank <= keep)
    return pool.rows(row * _AROUND + at[row, column])


def rates_of(pool: Pool, keep: int) -> list[Candidate]:
    """The rates of the best states, without repetition."""

    def are_one(one: Candidate, other: Candidate) -> bool:
        is_close = 2.0 * abs(one.precession - other.precession) < 0.4
        return is_close and abs(one.nutation - other.nutation) < 0.4

    rates = (Candidate(*state[OF_RATES].tolist()) for state in pool.states)
    return distinct(rates, are_one, keep)
