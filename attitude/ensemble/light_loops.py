"""The compiled loop from states to the brightness of ellipsoids, without an array of attitudes."""

import math

from attitude.compilation.decorators import entry_point, force_inlined, reduction_inlined
from attitude.light_curve.closed_form import intensity
from attitude.solution.chain import evaluate_part

# Rows that are evaluated at a time: their attitudes and directions stay in the first-level cache.
PIECE = 248


@entry_point
def ellipsoid_runs(
    constants, starts, t, t_low, sun, sun_steps, observer, observer_steps, axes, factor, work, out
):
    """Brightness, over the solar irradiance, of B runs of rows of ellipsoids.

    Given
        constants  (B,) records (solution.record), one of each run
        starts     (B + 1,) the rows of run b are starts[b] to starts[b + 1]
        t, t_low   (1, R) seconds since the epoch of the state; t_low may be None
        sun, observer  flat memory of vectors from the body, ICRF, of any length above zero:
                   component k of row r is at r times the first step and k times the second
        axes       (1 or B, 3) semi-axes, m
        factor     weight of the law of Lommel and Seeliger, 1/sr
        work       (1, 10, PIECE) memory
    Filled
        out        (R,) m2/sr
    Returned
        -1, or the first run with an epoch beyond its reach; it and those after it are not filled
    """
    for b in range(len(constants)):
        k = b if len(axes) > 1 else 0
        a, c, d = axes[k, 0], axes[k, 1], axes[k, 2]
        scale = 0.25 * math.pi * a * c * d * factor
        first, end = starts[b], starts[b + 1]
        while first < end:
            stop = min(first + PIECE, end)
            if evaluate_part(constants[b : b + 1], t, t_low, work, None, first, stop, 0):
                return b
            _take(sun, sun_steps, first, stop, 4, work[0])
            _take(observer, observer_steps, first, stop, 7, work[0])
            _shine(work[0], 1.0 / a, 1.0 / c, 1.0 / d, scale, stop - first)
            for k in range(stop - first):
                out[first + k] = work[0, 0, k]
            first = stop
    return -1


@force_inlined
def _take(memory, steps, first, end, to, work):
    """Vectors of the rows from `first` to `end`, as unit vectors, into three rows of `work`."""
    row, part = steps
    if row == 3 and part == 1:
        # LLVM vectorises a loop only with steps that are constant.
        near = memory[3 * first : 3 * end]
        for k in range(end - first):
            _put(near[3 * k], near[3 * k + 1], near[3 * k + 2], to, k, work)
    elif row == 1:
        one = memory[first:end]
        two = memory[part + first : part + end]
        three = memory[2 * part + first : 2 * part + end]
        for k in range(end - first):
            _put(one[k], two[k], three[k], to, k, work)
    else:
        for k in range(end - first):
            i = (first + k) * row
            _put(memory[i], memory[i + part], memory[i + 2 * part], to, k, work)


@reduction_inlined
def _put(x, y, z, to, k, work):
    """A vector as a unit vector in place k of three rows of `work`."""
    inverse = 1.0 / math.sqrt(x * x + y * y + z * z)
    work[to, k], work[to + 1, k], work[to + 2, k] = x * inverse, y * inverse, z * inverse


@force_inlined
def _shine(work, ia, ib, ic, scale, count):
    """The brightness in place of the first component of each attitude.

    Attitudes and the unit vectors of Sun and observer, over inertial axes, are the rows of one
    array: with several arrays LLVM does not vectorise the loop.
    """
    for k in range(count):
        w, x, y, z = work[0, k], work[1, k], work[2, k], work[3, k]
        a, b, c = _in_body(w, x, y, z, work[4, k], work[5, k], work[6, k])
        d, e, f = _in_body(w, x, y, z, work[7, k], work[8, k], work[9, k])
        work[0, k] = intensity(ia, ib, ic, scale, a, b, c, d, e, f)


@reduction_inlined
def _in_body(w, x, y, z, a, b, c):
    """The vector q* v q, as `solution.vectors.to_body` has it."""
    d = 2.0 * (y * c - z * b)
    e = 2.0 * (z * a - x * c)
    f = 2.0 * (x * b - y * a)
    return a - w * d + (y * f - z * e), b - w * e + (z * d - x * f), c - w * f + (x * e - y * d)
