"""Attitudes on a chain of free arcs: each epoch with the constants of the arc that it falls on."""

import math

import numpy as np

from attitude.compilation.decorators import entry_point, subroutine
from attitude.solution import codes
from attitude.solution.kernel import hyperbolic, reach, trigonometric, uniform
from attitude.solution.twofloat import two_sum


@entry_point
def evaluate_arcs(constants, starts, t, t_low, wxyz, rates):
    """Attitudes, and angular velocities unless rates is None, at epochs in any order.

    Given
        constants  (N,) records (solution.record), one of each arc
        starts     (N, 2) when the arcs start, pairs of seconds, ascending; the first reaches back
        t, t_low   (T,) pairs of seconds
    Filled
        wxyz       (1, 4, T)
        rates      (1, 3, T) rad/s over the given body axes, or None
    Returned
        -1, or the first epoch beyond the reach of its arc; it and those after it are not filled
    """
    count, arc = len(t), 0
    local, local_low = np.empty((1, count)), np.empty((1, count))
    begin = 0
    while begin < count:
        arc = _arc(starts, t[begin], t_low[begin], arc)
        first, first_low = starts[arc, 0], starts[arc, 1]
        # as many as follow on the same arc: there the kernels run at their full speed
        end = begin
        while end < count and (end == begin or _within(starts, arc, t[end], t_low[end])):
            high, low = two_sum(t[end], -first)
            if abs(high) < math.inf:
                high, low = two_sum(high, low + (t_low[end] - first_low))
            else:  # NaN stays NaN, and what is infinite is beyond reach whatever its low part
                low = 0.0
            local[0, end], local_low[0, end] = high, low
            end += 1
        failed = _on_one(
            constants[arc : arc + 1],
            local[:, begin:end],
            local_low[:, begin:end],
            wxyz[:, :, begin:end],
            None if rates is None else rates[:, :, begin:end],
        )
        if failed:
            while not abs(local[0, begin]) > reach(constants[arc]):  # NaN is not
                begin += 1
            return begin
        begin = end
    return -1


@subroutine
def _on_one(c, t, t_low, wxyz, rates):
    """Fill what one arc has; whether any epoch is beyond its reach."""
    form = c[0].form
    if form == codes.TRIGONOMETRIC:
        return trigonometric(c, t, t_low, wxyz, rates) >= 0
    if form == codes.HYPERBOLIC:
        return hyperbolic(c, t, t_low, wxyz, rates) >= 0
    return uniform(c, t, t_low, wxyz, rates) >= 0


@subroutine
def _arc(starts, t, low, guess):
    """The number of the arc of an epoch; NaN falls on the first."""
    if _within(starts, guess, t, low):
        return guess
    least, most = 0, len(starts)
    while most - least > 1:
        middle = (least + most) // 2
        if _from(starts, middle, t, low):
            least = middle
        else:
            most = middle
    return least


@subroutine
def _within(starts, arc, t, low):
    return (arc == 0 or _from(starts, arc, t, low)) and not (
        arc + 1 < len(starts) and _from(starts, arc + 1, t, low)
    )


@subroutine
def _from(starts, arc, t, low):
    """Whether an epoch is not before the start of an arc."""
    return t > starts[arc, 0] or (t == starts[arc, 0] and low >= starts[arc, 1])
