"""Levenberg and Marquardt's iteration from many starts, for the ellipsoid; compiled.

A start is a row of 16 numbers: five elements, the orientation (9) of the axes along the momentum,
and two logarithms of squared ratios of axes, ln (c/a)^2 and ln (c/b)^2.  Terms in which the
magnitude is linear are projected out of each residual and derivative.
"""

from __future__ import annotations

import math

import numpy as np

from attitude.compilation.decorators import entry_point, subroutine
from attitude.inversion import ellipsoid_magnitudes as ellipsoid
from attitude.inversion.moments_of_elements import with_slopes

# Entries of a start, and the numbers of the layout.
WIDTH = 16
# Bounds of ln rho, X and of the logarithms of the shape.
LEAST_RHO, MOST_RHO, LEAST_X, MOST_X, MOST_RATIO = -8.0, -0.01, -0.3, 0.95, 6.0
# Longest step: rad of orientation, turns of phase, ln rho, X, logarithms of the shape.
_LONGEST = 0.6
# Damping at which no step lowers the sum of squares.
_STUCK = 1e8


@subroutine
def _copy(x, new):
    """By a loop: an assignment of slices compiles the sentence about unequal shapes, for 3 s."""
    for i in range(WIDTH):
        new[i] = x[i]


@subroutine
def _is_allowed(x, fixed):
    if not (abs(x[14]) < MOST_RATIO and abs(x[15]) < MOST_RATIO):
        return False
    if fixed[6]:
        return True
    return LEAST_X < x[4] < MOST_X and LEAST_RHO < x[3] < MOST_RHO


@subroutine
def _residuals(y, root, u, out):
    """Weighted residuals in place of magnitudes out; their squares without the linear terms."""
    for i in range(y.size):
        out[i] = (y[i] - out[i]) * root[i]
    along = np.dot(u, out)
    return np.dot(out, out) - np.dot(along, along), along


@subroutine
def moved(x, step, new):
    """x after a step: the orientation is turned about its own axes."""
    a, b, c = step[0], step[1], step[2]
    angle = math.sqrt(a * a + b * b + c * c)
    half = 0.5 * angle
    w = math.cos(half)
    s = math.sin(half) / angle if angle > 1e-12 else 0.5
    p, q, r = a * s, b * s, c * s
    m0, m1, m2 = 1.0 - 2.0 * (q * q + r * r), 2.0 * (p * q - w * r), 2.0 * (p * r + w * q)
    m3, m4, m5 = 2.0 * (p * q + w * r), 1.0 - 2.0 * (p * p + r * r), 2.0 * (q * r - w * p)
    m6, m7, m8 = 2.0 * (p * r - w * q), 2.0 * (q * r + w * p), 1.0 - 2.0 * (p * p + q * q)
    for row in range(3):
        x0, x1, x2 = x[5 + 3 * row], x[6 + 3 * row], x[7 + 3 * row]
        new[5 + 3 * row] = x0 * m0 + x1 * m3 + x2 * m6
        new[6 + 3 * row] = x0 * m1 + x1 * m4 + x2 * m7
        new[7 + 3 * row] = x0 * m2 + x1 * m5 + x2 * m8
    for k in range(5):
        new[k] = x[k] + step[3 + k]
    new[14], new[15] = x[14] + step[8], x[15] + step[9]


@subroutine
def _solved(normal, gradient, fixed, damping, step):
    """The damped step, scaled by the diagonal, of limited length; False if it does not exist."""
    n = gradient.size
    a = np.empty((n, n))
    scale = np.empty(n)
    for i in range(n):
        scale[i] = math.sqrt(normal[i, i]) + 1e-12
    for i in range(n):
        for j in range(i + 1):
            a[i, j] = normal[i, j] / (scale[i] * scale[j])
            if fixed[i] or fixed[j]:
                a[i, j] = 0.0
        a[i, i] = 1.0 if fixed[i] else a[i, i] + damping + 1e-13
    for i in range(n):
        total = 0.0 if fixed[i] else gradient[i] / scale[i]
        for j in range(i):
            s = a[i, j]
            for k in range(j):
                s -= a[i, k] * a[j, k]
            a[i, j] = s / a[j, j]
            total -= a[i, j] * step[j]
        s = a[i, i]
        for k in range(i):
            s -= a[i, k] * a[i, k]
        if not s > 0.0:
            return False
        a[i, i] = math.sqrt(s)
        step[i] = total / a[i, i]
    for i in range(n - 1, -1, -1):
        s = step[i]
        for k in range(i + 1, n):
            s -= a[k, i] * step[k]
        step[i] = s / a[i, i]
    for i in range(n):
        step[i] /= scale[i]
    longest = math.sqrt(step[0] ** 2 + step[1] ** 2 + step[2] ** 2)
    longest = max(longest, 6.0 * abs(step[5]), 2.0 * abs(step[6]), 4.0 * abs(step[7]))
    longest = max(longest, abs(step[8]), abs(step[9]))
    if longest > _LONGEST:
        for i in range(n):
            step[i] *= _LONGEST / longest
    return True


@subroutine
def _tie(x, tie, given, row, found, slopes):
    """Differences of the logarithms of the moments of the motion from those wanted, over tie.

    Those of the ellipsoid, or the logarithms given (3,), ascending, unless they are NaN.  Into
    found (2,), with their derivatives by the ten parameters, row (2, 10).
    """
    with_slopes(x[0], x[1], x[3], x[4], found, slopes)
    for q in range(2):
        row[q, 3], row[q, 4] = slopes[q, 0] / tie, slopes[q, 1] / tie
        row[q, 6], row[q, 7] = slopes[q, 2] / tie, slopes[q, 3] / tie
    if given[0] == given[0]:
        # the third axis is the long one in long-axis mode; X < 0 exchanges the first two
        third, first = (given[0], given[2]) if x[1] > 0.0 else (given[2], given[0])
        one, two = (first, given[1]) if x[4] >= 0.0 else (given[1], first)
        found[0], found[1] = (found[0] - one + third) / tie, (found[1] - two + third) / tie
        return
    a, b = math.exp(-x[14]), math.exp(-x[15])
    found[0] = (found[0] - math.log((b + 1.0) / (a + b))) / tie
    found[1] = (found[1] - math.log((a + 1.0) / (a + b))) / tie
    row[0, 8], row[0, 9] = -a / (a + b) / tie, (b / (b + 1.0) - b / (a + b)) / tie
    row[1, 8], row[1, 9] = (a / (a + 1.0) - a / (a + b)) / tie, -b / (a + b) / tie


@entry_point
def minimise(starts, t, sun, observer, y, root, u, fixed, widths, iterations, tolerance, cost):
    """Move each start (S, 16) to the least sum of squares, which goes to cost (S,).

    t (N,); sun, observer (3, N); y (N,) magnitudes; root (N,) square roots of the weights; u (L, N)
    linear terms times root, orthonormal; fixed (10,) parameters that stay; widths (5,): standard
    deviations of the logarithms of the shape, and of those of the moments of the motion from the
    moments of the ellipsoid or from those whose logarithms, ascending, follow (else NaN).
    tolerance: relative gain that ends an iteration.
    """
    n = t.size
    k, r, g = np.zeros((4, 4, 2)), np.empty((9, n)), np.empty((9, n))
    out, jacobian = np.empty(n), np.empty((ellipsoid.PARAMETERS, n))
    flat, step, new = np.ones(3), np.zeros(10), np.empty(WIDTH)
    normal, gradient = np.zeros((10, 10)), np.zeros(10)
    bend, tie = 1.0 / (widths[0] * widths[0]), widths[1]
    tied, row, slopes = np.zeros(4), np.zeros((2, 10)), np.zeros((2, 4))
    for each in range(starts.shape[0]):
        x = starts[each]
        _copy(x, new)
        best, damping = np.inf, 1e-2
        for iteration in range(iterations):
            chi = np.inf
            if _is_allowed(new, fixed):
                flat[0], flat[1] = math.exp(new[14]), math.exp(new[15])
                ellipsoid.with_derivatives(
                    new, new[5:14], k, flat, t, sun, observer, r, g, out, jacobian
                )
                chi, along = _residuals(y, root, u, out)
                chi += bend * (new[14] ** 2 + new[15] ** 2)
                if tie < np.inf:
                    _tie(new, tie, widths[2:], row, tied, slopes)
                    chi += tied[0] ** 2 + tied[1] ** 2
            if chi < best:
                gain = best - chi
                best = chi
                _copy(new, x)
                damping = max(0.3 * damping, 1e-9)
                if iteration > 3 and gain < tolerance * best:
                    break
                for p in range(10):
                    for i in range(n):
                        jacobian[p, i] *= root[i]
                across = np.dot(jacobian, u.T)
                normal = np.dot(jacobian, jacobian.T) - np.dot(across, across.T)
                gradient = np.dot(jacobian, out) - np.dot(across, along)
                for p in (8, 9):
                    normal[p, p] += bend
                    gradient[p] -= bend * x[6 + p]
                if tie < np.inf:
                    for p in range(10):
                        gradient[p] -= row[0, p] * tied[0] + row[1, p] * tied[1]
                        for q in range(10):
                            normal[p, q] += row[0, p] * row[0, q] + row[1, p] * row[1, q]
            else:
                damping *= 4.0
                if damping > _STUCK:
                    break
            if iteration == iterations - 1 or not _solved(normal, gradient, fixed, damping, step):
                break
            moved(x, step, new)
        cost[each] = best


@entry_point
def costs(starts, t, sun, observer, y, root, u, cost):
    """The sum of squares of each start (S, 16), into cost (S,)."""
    n = t.size
    k, r, out, flat = np.zeros((4, 4, 2)), np.empty((9, n)), np.empty(n), np.ones(3)
    for each in range(starts.shape[0]):
        x = starts[each]
        flat[0], flat[1] = math.exp(x[14]), math.exp(x[15])
        ellipsoid.magnitudes(x, x[5:14], k, flat, t, sun, observer, r, out)
        cost[each] = _residuals(y, root, u, out)[0]
