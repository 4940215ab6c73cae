"""Where two free arcs meet: momentum added to a state, a body exchanged for another; in pairs."""

import math

import numpy as np

from attitude.solution.flow import multiply
from attitude.solution.machine import compiled, inlined
from attitude.solution.twofloat import ONE, ZERO, add, div, mul, neg, pair, put, sqrt, square, sub


@compiled
def change_axes(q, turn, sense):
    """q becomes q times the unit quaternion (4,) that `turn` (any length) is near to, or, for a
    sense of -1, times its inverse; q (4, 2) in pairs, left at unit length.
    """
    s = _unit(turn)
    for k in range(1, 4):
        s[k] = sense * s[k]
    multiply(q, pair(s[0]), pair(s[1]), pair(s[2]), pair(s[3]))
    size = ZERO
    for k in range(4):
        size = add(size, square(pair(q[k])))
    size = div(ONE, sqrt(size))
    for k in range(4):
        put(q[k], mul(pair(q[k]), size))


@compiled
def strike(moments, axes, q, w, in_body, in_space):
    """Add angular momentum to a state.

    Given
        moments   (3, 2) principal moments, pairs
        axes      (3, 3, 2) columns: the principal axes in body axes, pairs
        q         (4, 2) body axes to inertial, pairs
        in_body   (3,) kg m2/s over the body axes
        in_space  (3,) kg m2/s over the inertial axes
    Changed
        w         (3, 2) rad/s over the principal axes; infinite where there is no inertia
    """
    total = _to_body(q, in_space)
    for k in range(3):
        put(total[k], add(pair(total[k]), (in_body[k], 0.0)))
    for j in range(3):
        change = ZERO
        for k in range(3):
            change = add(change, mul(pair(axes[k, j]), pair(total[k])))
        if change[0] != 0.0:
            if moments[j, 0] > 0.0:
                put(w[j], add(pair(w[j]), div(change, pair(moments[j]))))
            else:
                put(w[j], (math.inf, 0.0))


@compiled
def exchange(moments, axes, new_moments, new_axes, w):
    """The same angular momentum in a body with other moments and axes: w over the new ones."""
    momentum = np.zeros((3, 2))
    for k in range(3):
        total = ZERO
        for j in range(3):
            total = add(total, mul(pair(axes[k, j]), mul(pair(moments[j]), pair(w[j]))))
        put(momentum[k], total)
    for j in range(3):
        total = ZERO
        for k in range(3):
            total = add(total, mul(pair(new_axes[k, j]), pair(momentum[k])))
        if new_moments[j, 0] > 0.0:
            total = div(total, pair(new_moments[j]))
        elif total[0] != 0.0:
            total = math.inf, 0.0
        put(w[j], total)


@inlined
def _unit(q):
    out = np.zeros((4, 2))
    size = ZERO
    for k in range(4):
        size = add(size, square((q[k], 0.0)))
    size = div(ONE, sqrt(size))
    for k in range(4):
        put(out[k], mul((q[k], 0.0), size))
    return out


@inlined
def _to_body(q, v):
    """q* v q for doubles v, as pairs (3, 2)."""
    s, x, y, z = pair(q[0]), neg(pair(q[1])), neg(pair(q[2])), neg(pair(q[3]))
    a, b, c = (v[0], 0.0), (v[1], 0.0), (v[2], 0.0)
    d, e, f = (
        sub(mul(y, c), mul(z, b)),
        sub(mul(z, a), mul(x, c)),
        sub(mul(x, b), mul(y, a)),
    )
    out = np.zeros((3, 2))
    one = add(mul(s, d), sub(mul(y, f), mul(z, e)))
    two = add(mul(s, e), sub(mul(z, d), mul(x, f)))
    three = add(mul(s, f), sub(mul(x, e), mul(y, d)))
    put(out[0], add(a, (2.0 * one[0], 2.0 * one[1])))
    put(out[1], add(b, (2.0 * two[0], 2.0 * two[1])))
    put(out[2], add(c, (2.0 * three[0], 2.0 * three[1])))
    return out
