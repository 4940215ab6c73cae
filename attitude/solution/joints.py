"""Where two free arcs meet: momentum added to a state, a body exchanged for another; in pairs."""

import math

import numpy as np

from attitude.solution.machine import compiled, inlined
from attitude.solution.twofloat import ONE, ZERO, add, div, mul, neg, pair, sqrt, square, sub


@compiled
def change_axes(q, turn, sense):
    """q becomes q times the unit quaternion (4,) that `turn` (any length) is near to, or, for a
    sense of -1, times its inverse; q (4, 2) in pairs, left at unit length.
    """
    s = _unit(turn)
    for k in range(1, 4):
        s[k] = sense * s[k]
    _multiply(q, s)
    size = ZERO
    for k in range(4):
        size = add(size, square(pair(q[k])))
    size = div(ONE, sqrt(size))
    for k in range(4):
        q[k, 0], q[k, 1] = mul(pair(q[k]), size)


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
        total[k, 0], total[k, 1] = add(pair(total[k]), (in_body[k], 0.0))
    for j in range(3):
        change = ZERO
        for k in range(3):
            change = add(change, mul(pair(axes[k, j]), pair(total[k])))
        if change[0] != 0.0:
            if moments[j, 0] > 0.0:
                w[j, 0], w[j, 1] = add(pair(w[j]), div(change, pair(moments[j])))
            else:
                w[j, 0], w[j, 1] = math.inf, 0.0


@compiled
def exchange(moments, axes, new_moments, new_axes, w):
    """The same angular momentum in a body with other moments and axes: w over the new ones."""
    momentum = np.zeros((3, 2))
    for k in range(3):
        total = ZERO
        for j in range(3):
            total = add(total, mul(pair(axes[k, j]), mul(pair(moments[j]), pair(w[j]))))
        momentum[k, 0], momentum[k, 1] = total
    for j in range(3):
        total = ZERO
        for k in range(3):
            total = add(total, mul(pair(new_axes[k, j]), pair(momentum[k])))
        if new_moments[j, 0] > 0.0:
            total = div(total, pair(new_moments[j]))
        elif total[0] != 0.0:
            total = math.inf, 0.0
        w[j, 0], w[j, 1] = total


@inlined
def _unit(q):
    out = np.zeros((4, 2))
    size = ZERO
    for k in range(4):
        size = add(size, square((q[k], 0.0)))
    size = div(ONE, sqrt(size))
    for k in range(4):
        out[k, 0], out[k, 1] = mul((q[k], 0.0), size)
    return out


@inlined
def _multiply(q, p):
    """q becomes q p."""
    a, b, c, d = pair(q[0]), pair(q[1]), pair(q[2]), pair(q[3])
    s, x, y, z = pair(p[0]), pair(p[1]), pair(p[2]), pair(p[3])
    q[0, 0], q[0, 1] = sub(mul(a, s), add(add(mul(b, x), mul(c, y)), mul(d, z)))
    q[1, 0], q[1, 1] = add(add(mul(a, x), mul(b, s)), sub(mul(c, z), mul(d, y)))
    q[2, 0], q[2, 1] = add(add(mul(a, y), mul(c, s)), sub(mul(d, x), mul(b, z)))
    q[3, 0], q[3, 1] = add(add(mul(a, z), mul(d, s)), sub(mul(b, y), mul(c, x)))


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
    out[0, 0], out[0, 1] = add(a, (2.0 * one[0], 2.0 * one[1]))
    out[1, 0], out[1, 1] = add(b, (2.0 * two[0], 2.0 * two[1]))
    out[2, 0], out[2, 1] = add(c, (2.0 * three[0], 2.0 * three[1]))
    return out
