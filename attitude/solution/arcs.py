"""Attitudes on a chain of free arcs: each epoch with the constants of the arc that it falls on."""

import math

import numpy as np

from attitude.solution.kernel import evaluate
from attitude.solution.machine import compiled, inlined
from attitude.solution.turns import LONGEST
from attitude.solution.twofloat import two_sum


@compiled
def evaluate_arcs(constants, starts, t, t_low, wxyz, rates):
    """Attitudes, and angular velocities unless rates is None, at epochs in any order.

    Given
        constants  (N,) records (solution.layout), one of each arc
        starts     (N, 2) when the arcs start, pairs of seconds, ascending; the first reaches back
        t, t_low   (T,) pairs of seconds
    Filled
        wxyz       (4, T)
        rates      (3, T) rad/s over the given body axes, or None
    Returned
        -1, or the first epoch beyond the reach of its arc, where nothing is filled any more
    """
    count, arc = len(t), 0
    local, local_low = np.empty(count), np.empty(count)
    begin = 0
    while begin < count:
        arc = _arc(starts, t[begin], t_low[begin], arc)
        first, first_low = starts[arc, 0], starts[arc, 1]
        c = constants[arc]
        reach = LONGEST / max(abs(c.precession[0]), abs(c.nutation[0]))
        # as many as follow on the same arc: there the kernel runs at its full speed
        end = begin
        while end < count and (end == begin or _within(starts, arc, t[end], t_low[end])):
            if abs(t[end] - first) > reach or abs(t[end]) == math.inf:
                return end
            high, low = two_sum(t[end], -first)
            local[end], local_low[end] = two_sum(high, low + (t_low[end] - first_low))
            end += 1
        evaluate(
            c,
            local[begin:end],
            local_low[begin:end],
            wxyz[:, begin:end],
            None if rates is None else rates[:, begin:end],
        )
        begin = end
    return -1


@inlined
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


@inlined
def _within(starts, arc, t, low):
    return (arc == 0 or _from(starts, arc, t, low)) and not (
        arc + 1 < len(starts) and _from(starts, arc + 1, t, low)
    )


@inlined
def _from(starts, arc, t, low):
    """Whether an epoch is not before the start of an arc."""
    return t > starts[arc, 0] or (t == starts[arc, 0] and low >= starts[arc, 1])
