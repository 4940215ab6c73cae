"""Magnitudes of a rotating ellipsoid in closed form, with all derivatives, compiled.

The brightness of `attitude.light_curve.closed_form` as a function of the three products of the
directions of Sun and observer with the matrix of the ellipsoid, P^2, Q^2 and p.q.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from attitude.compilation.decorators import reduction, reduction_within
from attitude.compilation.elementary import binary_logarithm
from attitude.compilation.simd import at_least, at_most, chosen, eight, put_eight, root, summed_up
from attitude.inversion import normal_form_series as series
from attitude.inversion.normal_form_series import put_three, three

if TYPE_CHECKING:
    from collections.abc import Iterator

    from attitude.annotations import FloatArray
    from attitude.inversion.problem import CurveProblem

# Rows of the Jacobian: rotation vector (3), precession, nutation, phase (turns), ln rho, X, and
# two logarithms of squared ratios of axes.
PARAMETERS = 10
# Magnitudes of a factor 2, and of a small relative change.
_OF_TWO, _OF_CHANGE = -2.5 * math.log10(2.0), -2.5 / math.log(10.0)
_TURN = 2.0 * math.pi
# Rows of a state: its residuals, its Jacobian, and an empty one, for rows are multiplied by fours.
_FOUR, _ROWS = 4, 12
# States times epochs whose rows fill half a megabyte, which a processor's second cache holds.
_AT_ONCE = 3000


def _aligned(shape: tuple[int, ...]) -> FloatArray:
    """An array of zeros that begins with a cache line: twice as fast to read by vectors."""
    count = math.prod(shape)
    memory = np.zeros(count + 7)
    skipped = -(memory.ctypes.data // 8) % 8
    return memory[skipped : skipped + count].reshape(shape)


class EllipsoidCurve:
    """Magnitudes of ellipsoids against those of a problem, for many states (S, 16) at a time.

    Parameters
    ----------
    problem : CurveProblem
    """

    def __init__(self, problem: CurveProblem) -> None:
        self._t, self._y = series.padded(problem.t), series.padded(problem.y)
        self._sun = series.padded(problem.sun).reshape(-1)
        self._observer = series.padded(problem.observer).reshape(-1)
        # epochs that fill up the last vector have no weight
        self._weight = series.padded(problem.root, "constant")
        count, n = len(problem.u), self._t.size
        self._size = max(1, _AT_ONCE // n)
        # filling new memory takes as long as computing what goes into it
        self._turns, self._tangents = _aligned((2, 9 * n * self._size))
        wide = count + -count % _FOUR
        self._memory = _aligned((self._size * _ROWS + wide, n))
        self._rows = self._memory[:-wide].reshape(self._size, _ROWS, n)
        self._u = self._memory[-wide:]
        self._u[:count, : len(problem)] = problem.u

    def rows(self, states: FloatArray, with_slopes: bool) -> Iterator[tuple[slice, FloatArray]]:
        """Some of the states (S, 16), and their rows (S, 12, N) or (S, 1, N), as of `residuals`.

        The rows are overwritten by those of the next states.
        """
        size, turns = self._size, self._turns
        tangents = self._tangents if with_slopes else self._tangents[:0]
        rows = self._rows if with_slopes else self._rows.reshape(-1, 1, self._t.size)[:size]
        elements, k = np.ascontiguousarray(states[:, :3]), series.coefficients(states)
        epochs = self._t, self._sun, self._observer, self._y, self._weight
        for start in range(0, len(states), size):
            part = slice(start, start + size)
            some = rows[: len(states) - start]
            series.attitudes(elements[part], k[part], self._t, turns, tangents)
            residuals(states[part], *epochs, turns, tangents, some.reshape(-1))
            yield part, some

    def costs(self, states: FloatArray) -> FloatArray:
        """The sums of squares (S,) of weighted residuals, least over the linear terms."""
        found = np.empty(len(states))
        for part, rows in self.rows(states, False):
            along = rows[:, 0] @ self._u.T
            found[part] = np.sum(rows[:, 0] ** 2, axis=1) - np.sum(along**2, axis=1)
        return found

    def products(self, states: FloatArray) -> FloatArray:
        """Products (S, 11, 11) of the weighted residuals and the rows of their Jacobian.

        The residual is y - magnitude, the Jacobian that of the magnitude.
        """
        found = np.empty((len(states), _ROWS, _ROWS + len(self._u)))
        for part, _ in self.rows(states, True):
            _products(self._memory.reshape(-1), found[part], self._size)
        own, along = found[:, :-1, : _ROWS - 1], found[:, :-1, _ROWS:]
        own -= along @ along.swapaxes(1, 2)
        return own


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
    """G and its derivative by u, y = 1 - u; see `light_curve.closed_form`."""
    s = at_most(u, 0.0625)
    x = root(at_least(u, 0.0625))
    atanh = (0.5 * math.log(2.0)) * binary_logarithm((1.0 + x) * (1.0 + x) / y)
    cube = x * x * x
    closed = (x - y * atanh) / cube
    slope = atanh / cube - 1.5 * closed / (x * x)
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


@reduction
def residuals(states, t, sun, observer, y, weight, r, g, rows):
    """Residuals y - magnitude of S states (S, 16), times weight, and derivatives of magnitudes.

    Into rows (S 12 N,): residuals, then the Jacobian, times weight; or into rows (S N,) residuals
    alone, if g is empty.  r and g are as of `normal_form_series.attitudes`; sun and observer (3 N,)
    are unit vectors by components, t, y, weight (N,); N is a multiple of eight.
    """
    n = t.size
    for each in range(states.shape[0]):
        c0, c1, c2 = states[each, 5], states[each, 6], states[each, 7]
        c3, c4, c5 = states[each, 8], states[each, 9], states[each, 10]
        c6, c7, c8 = states[each, 11], states[each, 12], states[each, 13]
        fa, fb = math.exp(states[each, 14]), math.exp(states[each, 15])
        turn, here = each * 9 * n, each * n
        if g.size > 0:
            here = each * 12 * n
        for i in range(0, n, 8):
            j = turn + i
            r0, r1, r2 = three(r, j, n)
            r3, r4, r5 = three(r, j + 3 * n, n)
            r6, r7, r8 = three(r, j + 6 * n, n)
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
            k = here + i
            put_eight(rows, k, (eight(y, i) - _OF_TWO * binary_logarithm(m * over * value)) * w)
            if g.size == 0:
                continue
            w = _OF_CHANGE * w
            slope = w * slope / value * over * over
            in_m, in_total = w / m, 0.0 - w * over - 2.0 * slope * u * total
            by_p, by_q = in_m * q + in_total, in_m * p + in_total
            by_pp, by_qq = by_p / p + 2.0 * slope, by_q / q + 2.0 * slope
            by_pq = in_m + 2.0 * slope
            # by the vectors s and o over body axes
            va, wa = fa * (by_pp * sa + by_pq * oa), fa * (by_qq * oa + by_pq * sa)
            vb, wb = fb * (by_pp * sb + by_pq * ob), fb * (by_qq * ob + by_pq * sb)
            vc, wc = by_pp * sc + by_pq * oc, by_qq * oc + by_pq * sc
            put_eight(rows, k + 9 * n, 0.5 * (va * sa + wa * oa))
            put_eight(rows, k + 10 * n, 0.5 * (vb * sb + wb * ob))
            # their cross products with s and o over body axes, summed, over the axes of r
            a = vb * sc - vc * sb + wb * oc - wc * ob
            b = vc * sa - va * sc + wc * oa - wa * oc
            c = va * sb - vb * sa + wa * ob - wb * oa
            a, b, c = _turned(a, b, c, r0, r3, r6, r1, r4, r7, r2, r5, r8)
            put_three(rows, k + n, n, a, b, c)
            at = eight(t, i)
            v = _TURN * _along(a, b, c, g, j, n)
            put_three(rows, k + 4 * n, n, (2.0 * _TURN) * at * c, at * v, v)
            put_eight(rows, k + 7 * n, _along(a, b, c, g, j + 3 * n, n))
            put_eight(rows, k + 8 * n, _along(a, b, c, g, j + 6 * n, n))


@reduction_within
def _two_by_four(rows, a, b, n):
    """Products of two rows of n numbers, from a on, with four, from b on."""
    x, y = eight(rows, a), eight(rows, a + n)
    z = eight(rows, b)
    p0, q0 = x * z, y * z
    z = eight(rows, b + n)
    p1, q1 = x * z, y * z
    z = eight(rows, b + 2 * n)
    p2, q2 = x * z, y * z
    z = eight(rows, b + 3 * n)
    p3, q3 = x * z, y * z
    for i in range(8, n, 8):
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
        *(summed_up(p0), summed_up(p1), summed_up(p2), summed_up(p3)),
        *(summed_up(q0), summed_up(q1), summed_up(q2), summed_up(q3)),
    )


@reduction
def _products(rows, found, size):
    """Products of the 12 rows of each of S states with each other and with L rows of all.

    rows (12 size N + L N,): those of `size` >= S states, then those of all; into found
    (S, 12, 12 + L); L is a multiple of four, N of eight.
    """
    states, own, columns = found.shape
    n = rows.size // (size * own + columns - own)
    for each in range(states):
        first = each * own * n
        for row in range(0, own, 2):
            for column in range(0, columns, 4):
                is_own = column < own
                if is_own and column > row + 1:
                    continue
                b = first + column * n if is_own else ((size - 1) * own + column) * n
                made = _two_by_four(rows, first + row * n, b, n)
                for k in range(4):
                    found[each, row, column + k] = made[k]
                    found[each, row + 1, column + k] = made[4 + k]
                    if is_own:
                        found[each, column + k, row] = made[k]
                        found[each, column + k, row + 1] = made[4 + k]
