"""Chains of free arcs: states in pairs of doubles from arc to arc, and attitudes on them.

On a chain of arcs the end of each is the start of the next, and the rounding of its angular
velocity to one double would grow with the time on all later arcs (2e-11 rad after a thousand).

Over whole nutation periods the body rates return and the body has turned about its momentum by a
known phase (docs/derivation.md: both rates are pairs).  The rest, half a period at most, is covered
by the pieces of `step`, here in pairs and with more terms, so that the cost is bounded for any
time.
"""

from __future__ import annotations

import math

import numpy as np

from attitude._compilation.decorators import entry_point, sized_entry_point, subroutine
from attitude._compilation.instructions import rint
from attitude._solver import codes
from attitude._solver.kernel import hyperbolic, reach, trigonometric, uniform
from attitude._solver.twofloat import (
    ONE,
    TWO_PI,
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
    two_sum,
)

# Ten points and sixteen terms leave less than 1e-26 of a piece this long.
_LONGEST_PIECE = 0.25
_TERMS = 16
_LONGEST_APPROACH = 40.0
# rad/s: below it squares of pairs underflow, and 1e113 s turn the body by less than 1e-17 rad.
_AT_REST = 1e-130
# Gauss-Legendre on (0, 1): lower half of the points and their weights, pairs.
_GAUSS = np.array(
    [
        [
            [0.01304673574141414, -4.665784635698963e-19],
            [0.03333567215434407, -1.9909486392185484e-19],
        ],
        [
            [0.06746831665550775, -1.0709933105035516e-18],
            [0.0747256745752903, 3.128569690796331e-18],
        ],
        [
            [0.1602952158504878, -1.3078130638726142e-17],
            [0.10954318125799102, 1.2038936517497318e-18],
        ],
        [
            [0.2833023029353764, 1.1300107349763433e-17],
            [0.13463335965499817, 2.730891682182046e-18],
        ],
        [
            [0.4255628305091844, -2.5345037086372335e-17],
            [0.14776211235737644, 7.463374310097437e-20],
        ],
    ]
)


@sized_entry_point
def flow(c, t, q, w):
    """Move a state q (4, 2), principal axes to inertial, and w (3, 2), rad/s over these, to time t.

    All are pairs; c is the record (records.CONSTANTS) of the motion that starts with the state.
    """
    if max(abs(w[0, 0]), abs(w[1, 0]), abs(w[2, 0])) < _AT_REST:
        return
    precession = pair(c.precession)
    if c.form == codes.UNIFORM:
        _turn(q, pair(w[0]), pair(w[1]), pair(w[2]), mul(precession, t))
        return
    # axes by ascending moment, all of them reversed if that order is left-handed
    order = c.order
    sign = 1.0 if (order[1] - order[0]) % 3 == 1 else -1.0
    p, o, i = np.zeros((4, 2)), np.zeros((3, 2)), np.zeros((3, 2))
    p[0, 0] = 1.0
    for k in range(3):
        # Not row to row: numba would compile the message of a shape error, for more than a second.
        put(i[k], pair(c.moments[order[k]]))
        put(o[k], scale(pair(w[order[k]]), sign))
    if c.winds != 0.0:
        rate = pair(c.nutation)
        if c.form == codes.HYPERBOLIC:
            rate = 0.5 * rate[0], 0.5 * rate[1]
        turns = mul(rate, t)
        whole = rint(turns[0])
        if whole != 0.0:
            m1, m2, m3 = _momentum(i, o)
            _turn(p, m1, m2, m3, mul(precession, div((whole, 0.0), rate)))
        _pieces(i, div(sub(turns, (whole, 0.0)), rate), p, o)
    else:
        # On the exact separatrix the momentum approaches the middle axis: after this time the
        # angle between them is below 1e-17 of that at the start.
        most = _LONGEST_APPROACH / (2.0 * abs(c.nutation[0]))
        time = (math.copysign(most, t[0]), 0.0) if abs(t[0]) > most else t
        _pieces(i, time, p, o)
        sense = math.copysign(1.0, o[1, 0])
        _turn(p, ZERO, (sense, 0.0), ZERO, mul(precession, sub(t, time)))
    back = np.zeros((4, 2))
    put(back[0], pair(p[0]))
    for k in range(3):
        put(back[1 + order[k]], scale(pair(p[1 + k]), sign))
        put(w[order[k]], scale(pair(o[k]), sign))
    multiply(q, pair(back[0]), pair(back[1]), pair(back[2]), pair(back[3]))


@subroutine
def _momentum(i, w):
    """The three components of the angular momentum, pairs."""
    return (
        mul(pair(i[0]), pair(w[0])),
        mul(pair(i[1]), pair(w[1])),
        mul(pair(i[2]), pair(w[2])),
    )


@subroutine
def _pieces(i, t, q, w):
    """Move a state, over axes of ascending moment, for t seconds in pieces."""
    i1, i2, i3 = pair(i[0]), pair(i[1]), pair(i[2])
    # A rod has no rate about itself, and k1 is the factor of that rate alone.
    k1 = div(sub(i2, i3), i1) if i1[0] > 0.0 else ZERO
    k2, k3 = div(sub(i3, i1), i2), div(sub(i1, i2), i3)
    g1, g2, g3 = neg(mul(k2, k3)), mul(k1, k3), neg(mul(k1, k2))
    a = np.zeros((_TERMS, 2))
    remaining = t
    while remaining[0] != 0.0:
        w1, w2, w3 = pair(w[0]), pair(w[1]), pair(w[2])
        kappa = mul(g2, square(w2))
        e1, e3 = add(mul(g1, square(w1)), kappa), add(mul(g3, square(w3)), kappa)
        r1, r2, r3 = mul(k1, mul(w2, w3)), mul(k2, mul(w3, w1)), mul(k3, mul(w1, w2))
        size = w1[0] * w1[0] + w2[0] * w2[0] + w3[0] * w3[0]
        change = (r1[0] * r1[0] + r2[0] * r2[0] + r3[0] * r3[0]) / size
        limit = _LONGEST_PIECE / math.sqrt(e1[0] + e3[0] + change)
        h = remaining
        if abs(h[0]) > limit:
            h = (math.copysign(limit, h[0]), 0.0)
        remaining = sub(remaining, h)
        m1, m2, m3 = _momentum(i, w)
        over = div(ONE, sqrt(add(add(square(m1), square(m2)), square(m3))))
        l1, l2, l3 = mul(m1, over), mul(m2, over), mul(m3, over)
        f1, f2, f3 = mul(i1, over), mul(i2, over), mul(i3, over)
        dot = add(add(mul(w1, l1), mul(w2, l2)), mul(w3, l3))
        _series(e1, e3, a)
        state = w1, w2, w3, r1, r2, r3, e1, e3, kappa
        weights = l1, l2, l3, f1, f2, f3, dot
        chi = (0.0, 0.0)
        n1 = n2 = n3 = d = ONE
        # the points from both ends, and last the end itself, whose values are used after the loop
        for point in range(2 * len(_GAUSS) + 1):
            x, weight = ONE, ZERO
            if point < 2 * len(_GAUSS):
                x, weight = pair(_GAUSS[point >> 1, 0]), pair(_GAUSS[point >> 1, 1])
                if point & 1:
                    x = sub(ONE, x)
            n1, n2, n3, d = _numerators(mul(h, x), a, state)
            chi = add(chi, mul(weight, _turning((n1, n2, n3, d), weights)))
        chi = mul(chi, h)
        d1, d2, d3 = div(n1, d), div(n2, d), div(n3, d)
        f1, f2, f3 = mul(f1, d1), mul(f2, d2), mul(f3, d3)
        one = add((2.0, 0.0), add(add(mul(f1, l1), mul(f2, l2)), mul(f3, l3)))
        size = div(ONE, sqrt(scale(one, 2.0)))
        _turn(q, l1, l2, l3, div(scale(chi, 0.5), TWO_PI))
        multiply(
            q,
            mul(one, size),
            mul(sub(mul(f2, l3), mul(f3, l2)), size),
            mul(sub(mul(f3, l1), mul(f1, l3)), size),
            mul(sub(mul(f1, l2), mul(f2, l1)), size),
        )
        put(w[0], add(w1, d1))
        put(w[1], add(w2, d2))
        put(w[2], add(w3, d3))


@subroutine
def _series(e1, e3, a):
    """Coefficients of S = sum a_n t^(2n+1), from S'' = -(e1 + e3) S + 2 e1 e3 S^3."""
    s, p = neg(add(e1, e3)), scale(mul(e1, e3), 2.0)
    squares = np.zeros((_TERMS, 2))
    put(a[0], ONE)
    for n in range(_TERMS - 1):
        total = mul(s, pair(a[n]))
        if n > 0:
            coefficient = (0.0, 0.0)
            for i in range(n):
                coefficient = add(coefficient, mul(pair(a[i]), pair(a[n - 1 - i])))
            put(squares[n - 1], coefficient)
            cube = (0.0, 0.0)
            for i in range(n):
                cube = add(cube, mul(pair(squares[i]), pair(a[n - 1 - i])))
            total = add(total, mul(p, cube))
        put(a[n + 1], div(total, ((2.0 * n + 3.0) * (2.0 * n + 2.0), 0.0)))


@subroutine
def _numerators(x, a, state):
    """d (w(x) - w) and d at x seconds from the start of a piece; see step."""
    w1, w2, w3, r1, r2, r3, e1, e3, kappa = state
    xx = square(x)
    s = pair(a[_TERMS - 1])
    for n in range(_TERMS - 2, -1, -1):
        s = add(mul(s, xx), pair(a[n]))
    s = mul(s, x)
    ss = square(s)
    b1, b3, g = mul(e1, ss), mul(e3, ss), mul(kappa, ss)
    c1, c3 = sqrt(sub(ONE, b1)), sqrt(sub(ONE, b3))
    u1, u3 = neg(div(b1, add(ONE, c1))), neg(div(b3, add(ONE, c3)))
    return (
        add(mul(w1, add(u3, g)), mul(mul(r1, s), c1)),
        add(mul(w2, add(add(mul(u1, u3), add(u1, u3)), g)), mul(r2, s)),
        add(mul(w3, add(u1, g)), mul(mul(r3, s), c3)),
        sub(ONE, g),
    )


@subroutine
def _turning(numerators, weights):
    """chi' of step, from the numerators at one time."""
    l1, l2, l3, f1, f2, f3, dot = weights
    n1, n2, n3, d = numerators
    n1, n2, n3 = mul(l1, n1), mul(l2, n2), mul(l3, n3)
    top = add(scale(mul(dot, d), 2.0), add(add(n1, n2), n3))
    bottom = add(scale(d, 2.0), add(add(mul(f1, n1), mul(f2, n2)), mul(f3, n3)))
    return div(top, bottom)


@subroutine
def _turn(q, x, y, z, turns):
    """q becomes q times (cosine; sine along a vector of any length) of 2 pi turns."""
    size = sqrt(add(add(square(x), square(y)), square(z)))
    if size[0] == 0.0:
        return
    cosine, sine = _cosine_and_sine(turns)
    sine = div(sine, size)
    multiply(q, cosine, mul(sine, x), mul(sine, y), mul(sine, z))


@subroutine
def multiply(q, s, x, y, z):
    """q (4, 2) becomes q times the quaternion of four pairs."""
    a, b, c, d = pair(q[0]), pair(q[1]), pair(q[2]), pair(q[3])
    put(q[0], sub(mul(a, s), add(add(mul(b, x), mul(c, y)), mul(d, z))))
    put(q[1], add(add(mul(a, x), mul(b, s)), sub(mul(c, z), mul(d, y))))
    put(q[2], add(add(mul(a, y), mul(c, s)), sub(mul(d, x), mul(b, z))))
    put(q[3], add(add(mul(a, z), mul(d, s)), sub(mul(b, y), mul(c, x))))


@subroutine
def _cosine_and_sine(turns):
    """Cosine and sine, pairs, of 2 pi turns: quarters removed, then the power series."""
    turns = sub(turns, (rint(turns[0]), 0.0))
    quarters = rint(4.0 * turns[0])
    angle = mul(TWO_PI, sub(turns, (0.25 * quarters, 0.0)))
    minus = neg(square(angle))
    cosine = sine = (0.0, 0.0)
    for n in range(14, 0, -1):
        cosine = div(mul(minus, add(ONE, cosine)), ((2.0 * n) * (2.0 * n - 1.0), 0.0))
        sine = div(mul(minus, add(ONE, sine)), ((2.0 * n + 1.0) * (2.0 * n), 0.0))
    cosine, sine = add(ONE, cosine), mul(angle, add(ONE, sine))
    side = int(quarters) & 3
    if side == 1:
        return neg(sine), cosine
    if side == 2:
        return neg(cosine), neg(sine)
    if side == 3:
        return sine, neg(cosine)
    return cosine, sine


# ---- Changes of state between two free arcs, in pairs of doubles: other axes, momentum added


@subroutine
def _change_axes(q, axes, rounded, sense):
    """q (4, 2) becomes q times the quaternion of a turn or, for a sense of -1, times its inverse.

    axes (3, 3, 2) is the rotation matrix, pairs; rounded (4,) its quaternion.  q is left of unit
    length.
    """
    s = _quaternion(axes, rounded)
    for k in range(1, 4):
        put(s[k], scale(pair(s[k]), sense))
    multiply(q, pair(s[0]), pair(s[1]), pair(s[2]), pair(s[3]))
    _to_unit_length(q)


@subroutine
def _strike(moments, axes, q, w, in_body, in_space):
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


@subroutine
def _quaternion(m, rounded):
    """The quaternion (4, 2) of a rotation matrix (3, 3, 2), pairs, near a rounded one (4,).

    4 s s^T, s being the unit quaternion, is linear in the matrix (see kernel); times a
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
            total = add(total, scale(rows[j][k], rounded[k]))
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
    d = sub(mul(y, c), mul(z, b))
    e = sub(mul(z, a), mul(x, c))
    f = sub(mul(x, b), mul(y, a))
    out = np.zeros((3, 2))
    one = add(mul(s, d), sub(mul(y, f), mul(z, e)))
    two = add(mul(s, e), sub(mul(z, d), mul(x, f)))
    three = add(mul(s, f), sub(mul(x, e), mul(y, d)))
    put(out[0], add(a, (2.0 * one[0], 2.0 * one[1])))
    put(out[1], add(b, (2.0 * two[0], 2.0 * two[1])))
    put(out[2], add(c, (2.0 * three[0], 2.0 * three[1])))
    return out


# ---- Attitudes on a chain of free arcs: each epoch with the constants of its arc


@sized_entry_point
def evaluate_arcs(constants, starts, t, t_low, wxyz, rates, column):
    """Attitudes, and angular velocities unless rates is None, at epochs in any order.

    Given
        constants  (N,) records (records.CONSTANTS), one of each arc
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


# ---- Chains of free arcs of many members, which change at the same epochs


@sized_entry_point
def join_members(records, moments, axes, principal, length, q, w, in_body, in_space):
    """Carry the states of members over one arc, and add angular momentum at its end.

    Given
        records    (N,) constants of the arc (records.CONSTANTS)
        moments    (1 or N, 3, 2) principal moments, pairs
        axes       (1 or N, 3, 3, 2) columns: the principal axes in body axes, pairs
        principal  (1 or N, 4) their quaternions, rounded
        length     (2,) seconds, a pair
        in_body    (3,) momentum over the body axes
        in_space   (3, 2) momentum over the inertial axes, pairs
    Changed
        q          (N, 4, 2) body axes to inertial, pairs
        w          (N, 3, 2) rad/s over the principal axes, pairs
    """
    t = length[0], length[1]
    for b in range(len(records)):
        i, j = b if len(moments) > 1 else 0, b if len(axes) > 1 else 0
        rounded_axes = principal[b if len(principal) > 1 else 0]
        _change_axes(q[b], axes[j], rounded_axes, 1.0)
        flow(records[b], t, q[b], w[b])
        _change_axes(q[b], axes[j], rounded_axes, -1.0)
        _strike(moments[i], axes[j], q[b], w[b], in_body, in_space)


@sized_entry_point
def exchange_members(moments, axes, new_moments, new_axes, w):
    """Give all members, as in `join_members`, one other body at the same angular momentum.

    new_moments (3, 2) and new_axes (3, 3, 2) are those of the body afterwards; w (N, 3, 2), rad/s
    over the principal axes, afterwards the new ones, is changed; it is infinite about an axis
    without inertia.
    """
    momentum = np.zeros((3, 2))
    for b in range(len(w)):
        i, j = b if len(moments) > 1 else 0, b if len(axes) > 1 else 0
        for k in range(3):
            total = ZERO
            for m in range(3):
                along = mul(pair(moments[i, m]), pair(w[b, m]))
                total = add(total, mul(pair(axes[j, k, m]), along))
            put(momentum[k], total)
        for m in range(3):
            total = ZERO
            for k in range(3):
                total = add(total, mul(pair(new_axes[k, m]), pair(momentum[k])))
            if new_moments[m, 0] > 0.0:
                total = div(total, pair(new_moments[m]))
            elif total[0] != 0.0:
                total = math.inf, 0.0
            put(w[b, m], total)


@entry_point
def evaluate_members(constants, starts, t, t_low, wxyz, rates, column):
    """`evaluate_arcs` of N members: constants (N, K), starts (K, 2); wxyz, rates (N, 4 or 3, T).

    Returns -1, or the first member with an epoch beyond its reach.
    """
    for b in range(len(constants)):
        to = wxyz[b : b + 1], rates[b : b + 1]
        if evaluate_arcs(constants[b], starts, t, t_low, to[0], to[1], column) >= 0:
            return b
    return -1


# ---- Attitudes at rows of epochs, each of one of many bodies: runs of rows of the same body
# Rows in which the members stand in any order are brought into runs by a counting sort.


@sized_entry_point
def evaluate_runs(constants, starts, t, t_low, wxyz, rates):
    """Attitudes, and angular velocities unless rates is None, of B runs of rows.

    Given
        constants  (B,) records (records.CONSTANTS), one of each run
        starts     (B + 1,) the rows of run b are starts[b] to starts[b + 1]
        t, t_low   (1, R) seconds since the epoch of the state; t_low may be None
    Filled
        wxyz       (1, 4, R) body to inertial
        rates      (1, 3, R) rad/s over the given body axes, or None
    Returned
        -1, or the first run with an epoch beyond its reach; it and those after it are not filled
    """
    for b in range(len(constants)):
        first, end = starts[b], starts[b + 1]
        if evaluate_part(constants[b : b + 1], t, t_low, wxyz, rates, first, end, first):
            return b
    return -1


@sized_entry_point
def surveyed(member):
    """The least and the greatest of N >= 1 whole numbers, how many runs of equals, of descents."""
    least = greatest = before = member[0]
    runs, descents = 1, 0
    for k in range(1, len(member)):
        number = member[k]
        least, greatest = min(least, number), max(greatest, number)
        runs += number != before
        descents += number < before
        before = number
    return least, greatest, runs, descents


@sized_entry_point
def runs_of(member, first, end, who, starts):
    """Fill the member and the first row of each run of the rows first to end; returns the count."""
    count = 0
    for k in range(first, end):
        if k == first or member[k] != member[k - 1]:
            who[count], starts[count] = member[k], k
            count += 1
    starts[count] = end
    return count


@sized_entry_point
def counted(member, counts):
    """Add the number of rows of each member to counts."""
    for k in range(len(member)):
        counts[member[k]] += 1


@sized_entry_point
def placed(member, first, places, order):
    """Fill the order in which rows stand by member (K,), each member's as given, by `places`."""
    for k in range(len(member)):
        place = places[member[k]]
        order[place] = first + k
        places[member[k]] = place + 1


@sized_entry_point
def scattered(rows, order, out):
    """Fill the columns (W, R) of given numbers (K,) with those of rows (W, K)."""
    for k in range(len(order)):
        place = order[k]
        for i in range(len(rows)):
            out[i, place] = rows[i, k]


@scattered.for_python
def _scattered_at_once(rows, order, out):
    """As `scattered`."""
    out[:, order] = rows
