"""Changes of state between two free arcs: momentum added, body exchanged; in pairs of doubles."""

import math

import numpy as np

from attitude.compilation.decorators import sized_entry_point, subroutine
from attitude.solution.flow import multiply
from attitude.solution.twofloat import (
    ONE,
    ZERO,
    add,
    div,
    mul,
    neg,
    pair,
    put,
    scale,
    sqrt,
    square,
    sub,
)


@sized_entry_point
def change_axes(q, axes, near, sense):
    """q becomes q times the quaternion of a rotation or, for a sense of -1, times its inverse.

    Given
        axes   (3, 3, 2) the rotation matrix, pairs
        near   (4,) its quaternion, rounded
    Changed
        q      (4, 2) pairs, left at unit length
    """
    s = _quaternion(axes, near)
    for k in range(1, 4):
        put(s[k], scale(pair(s[k]), sense))
    multiply(q, pair(s[0]), pair(s[1]), pair(s[2]), pair(s[3]))
    _to_unit_length(q)


@sized_entry_point
def strike(moments, axes, q, w, in_body, in_space):
    """Add angular momentum to a state.

    Given
        moments   (3, 2) principal moments, pairs
        axes      (3, 3, 2) columns: the principal axes in body axes, pairs
        q         (4, 2) body axes to inertial, pairs
        in_body   (3,) kg m2/s over the body axes
        in_space  (3, 2) kg m2/s over the inertial axes, pairs
    Changed
        w         (3, 2) rad/s over the principal axes; infinite about an axis without inertia
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


@sized_entry_point
def exchange(moments, axes, new_moments, new_axes, w):
    """Give a body other moments and axes at the same angular momentum.

    Given
        moments, axes          as in `strike`
        new_moments, new_axes  of the body afterwards
    Changed
        w    (3, 2) rad/s over the principal axes, afterwards the new ones; infinite about an axis
             without inertia
    """
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


@subroutine
def _quaternion(m, near):
    """The quaternion (4, 2) of a rotation matrix (3, 3, 2), pairs, near a rounded one (4,).

    4 s s^T, s being the unit quaternion, is linear in the matrix (see solution.given_axes); times a
    quaternion near s it is along s, so that no largest entry has to be chosen.
    """
    xx, yy, zz = pair(m[0, 0]), pair(m[1, 1]), pair(m[2, 2])
    a = sub(pair(m[2, 1]), pair(m[1, 2]))
    b = sub(pair(m[0, 2]), pair(m[2, 0]))
    c = sub(pair(m[1, 0]), pair(m[0, 1]))
    d = add(pair(m[1, 0]), pair(m[0, 1]))
    e = add(pair(m[0, 2]), pair(m[2, 0]))
    f = add(pair(m[2, 1]), pair(m[1, 2]))
    plus, minus = add(ONE, xx), sub(ONE, xx)
    rows = (
        (add(plus, add(yy, zz)), a, b, c),
        (a, sub(plus, add(yy, zz)), d, e),
        (b, d, add(minus, sub(yy, zz)), f),
        (c, e, f, add(minus, sub(zz, yy))),
    )
    out = np.zeros((4, 2))
    for j in range(4):
        total = ZERO
        for k in range(4):
            total = add(total, scale(rows[j][k], near[k]))
        put(out[j], total)
    _to_unit_length(out)
    return out


@subroutine
def _to_unit_length(q):
    """q (4, 2) becomes q over its length."""
    size = ZERO
    for k in range(4):
        size = add(size, square(pair(q[k])))
    size = div(ONE, sqrt(size))
    for k in range(4):
        put(q[k], mul(pair(q[k]), size))


@subroutine
def _to_body(q, v):
    """The vector q* v q (3, 2), all in pairs."""
    s, x, y, z = pair(q[0]), neg(pair(q[1])), neg(pair(q[2])), neg(pair(q[3]))
    a, b, c = pair(v[0]), pair(v[1]), pair(v[2])
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
