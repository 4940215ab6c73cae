"""Attitudes on a chain of free arcs: each epoch with the constants of its arc."""

import math

import numpy as np

from attitude.compilation.decorators import sized_entry_point, subroutine
from attitude.solution import codes
from attitude.solution.kernel import hyperbolic, reach, trigonometric, uniform
from attitude.solution.twofloat import two_sum


@sized_entry_point
def evaluate_arcs(constants, starts, t, t_low, wxyz, rates, column):
    """Attitudes, and angular velocities unless rates is None, at epochs in any order.

    Given
        constants  (N,) records (solution.record), one of each arc
        starts     (N, 2) starts of the arcs, pairs of seconds, ascending; the first arc also holds
                   all epochs before its start
        t, t_low   (T,) pairs of seconds
        column     the results go to the columns from here on
    Filled
        wxyz       (1, 4, N)
        rates      (1, 3, N) rad/s over the given body axes, or None
    Returned
        -1, or the first epoch beyond the reach of its arc; it and those after it are not filled
    """
    count, arc = len(t), 0
    local, local_low = np.empty((1, count)), np.empty((1, count))
    begin = 0
    while begin < count:
        arc = _arc_of(starts, t[begin], t_low[begin], arc)
        first, first_low = starts[arc, 0], starts[arc, 1]
        # all epochs that follow on the same arc: the kernels are fast on long rows
        end = begin
        while end < count and (end == begin or _is_on(starts, arc, t[end], t_low[end])):
            high, low = two_sum(t[end], -first)
            if abs(high) < math.inf:
                high, low = two_sum(high, low + (t_low[end] - first_low))
            else:  # NaN stays NaN; an infinite epoch is beyond reach for any low part
                low = 0.0
            local[0, end], local_low[0, end] = high, low
            end += 1
        to = column + begin
        failed = evaluate_part(
            constants[arc : arc + 1], local, local_low, wxyz, rates, begin, end, to
        )
        if failed:
            while not abs(local[0, begin]) > reach(constants[arc]):  # false for NaN
                begin += 1
            return begin
        begin = end
    return -1


@subroutine
def evaluate_part(c, t, t_low, wxyz, rates, first, end, column):
    """Fill some epochs of one motion (1,); whether any of them is beyond its reach."""
    form = c[0].form
    if form == codes.TRIGONOMETRIC:
        return trigonometric(c, t, t_low, wxyz, rates, first, end, column) >= 0
    if form == codes.HYPERBOLIC:
        return hyperbolic(c, t, t_low, wxyz, rates, first, end, column) >= 0
    return uniform(c, t, t_low, wxyz, rates, first, end, column) >= 0


@subroutine
def _arc_of(starts, t, low, guess):
    """The number of the arc of an epoch, by bisection; the first for NaN."""
    if _is_on(starts, guess, t, low):
        return guess
    least, most = 0, len(starts)
    while most - least > 1:
        middle = (least + most) // 2
        if _has_started(starts, middle, t, low):
            least = middle
        else:
            most = middle
    return least


@subroutine
def _is_on(starts, arc, t, low):
    """Whether an epoch is on an arc."""
    return (arc == 0 or _has_started(starts, arc, t, low)) and not (
        arc + 1 < len(starts) and _has_started(starts, arc + 1, t, low)
    )


@subroutine
def _has_started(starts, arc, t, low):
    """Whether an arc starts at or before an epoch."""
    return t > starts[arc, 0] or (t == starts[arc, 0] and low >= starts[arc, 1])
