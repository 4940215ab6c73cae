"""The exact free rotation over a short time, for integrators that split torques off.

The constants of `constants` take a microsecond, and differ between regimes.  A splitting
scheme needs one epoch from every state: this form of the exact solution has no constants, no
regimes and no elliptic integrals, and is the same arithmetic from a sphere to a needle and across
the separatrix.

Angular velocity.  For moments in ascending order I1 <= I2 <= I3 and w1' = k1 w2 w3 and so on, with
k1 = (I2 - I3)/I1, the addition theorems of the Jacobi functions (DLMF 22.8) read

    w1(t) = (w1 c3 + w1' S c1) / d        d = 1 - k1 k3 w2^2 S^2
    w2(t) = (w2 c1 c3 + w2' S) / d        c1^2 = 1 - e1 S^2,  e1 = -k2 k3 w1^2 + k1 k3 w2^2
    w3(t) = (w3 c1 + w3' S c3) / d        c3^2 = 1 - e3 S^2,  e3 = -k1 k2 w3^2 + k1 k3 w2^2

where S(t) = sn(r t)/r, r^2 = max(e1, e3), solves S' = c1 c3, S(0) = 0.  Every coefficient is a sum
of terms of one sign (-k2 k3, k1 k3, -k1 k2 >= 0), no divisor can vanish, and S is a short power
series for short times.

Attitude.  The momentum is fixed in space, so the turn from the body axes at t to those at 0 is
the least turn p from its direction l(t) to l(0) = l0, followed by a turn about l0 by chi.
Together they are the quaternion

    (cos(chi/2) (1 + l0 . l),  sin(chi/2) (l0 + l) + cos(chi/2) (l - l0) x l0) / |l0 + l|

and chi follows from the part of w that is not in the least turn, at right angles to l0 + l:

    chi' = (w . l + w(t) . l0) / (1 + l . l0) = 2 T/L + (w(t) . l0 - (2 T/L) l . l0) / (1 + l . l0)

The integral of the second term is the area on the unit sphere between the path of l and the arc
that closes it (Montgomery 1991, Am. J. Phys. 59, 394).  It grows as t^3, so four points of Gauss's
rule with weight S^2 give it to rounding, over S by dt = dS/(c1 c3): then only square roots are
needed at the points.  It is the third elliptic integral of van Zon & Schofield (2006), eq. 3.43,
without its poles.

All results are increments, whose error is that of rounding times the angle turned: summed with
compensation (`advance`), a thousand short steps are as accurate as one.

The time of a step is that of its longest chain of operations, so polynomials are evaluated in
powers that double, and corrections of rounding are added to the lower halves of the sums.
"""

from __future__ import annotations

import math
from typing import Final

from attitude._compilation.decorators import force_inlined, subroutine
from attitude._compilation.instructions import fma
from attitude._compilation.simd import (
    chosen,
    doubles_of,
    for_each,
    lanes,
    positive_bits,
    root,
    summed_for_each,
)
from attitude._solver.kernel import product
from attitude._solver.series import sincos, sincos_of_eighth
from attitude._solver.twofloat import quick_two_sum, two_prod, two_sum

# ---- The state of an integration: attitude and angular velocity as compensated sums
# A state is a tuple of wxyz (4), the angular velocity (3), and the lower halves of both (4), (3),
# which the rounded sums leave out.  Its numbers are doubles, or SIMD vectors of a lane for each
# body.


@subroutine
def loaded(row):
    """A state from a row of 14: wxyz and angular velocity, then their lower halves."""
    return (
        (row[0], row[1], row[2], row[3]),
        (row[4], row[5], row[6]),
        (row[7], row[8], row[9], row[10]),
        (row[11], row[12], row[13]),
    )


@subroutine
def stored(state, row):
    """A state into a row of 14: the inverse of `loaded`."""
    q, w, q_low, w_low = state
    for n in range(4):
        row[n], row[7 + n] = q[n], q_low[n]
    for n in range(3):
        row[4 + n], row[11 + n] = w[n], w_low[n]


@subroutine
def put_motion(state, row):
    """Attitude and angular velocity of a state into a row of 7."""
    q, w, _, _ = state
    for k in range(4):
        row[k] = q[k]
    for k in range(3):
        row[4 + k] = w[k]


@force_inlined
def moved_by(state, by):
    """A state plus an increment."""
    q, _, low, _ = state
    turn, change, n, error = by
    # n is nearly the same from step to step: it goes into the lower half, which turns with q.
    return kicked(turned(state, product(q, turn), n, product(low, turn)), change, error)


@subroutine
def turned(state, change, n, remainder):
    """A state whose quaternion is changed by (change + remainder), then multiplied by 1 + n."""
    q, w, low, w_low = state
    a, e = _add(q[0], low[0], change[0])
    b, f = _add(q[1], low[1], change[1])
    c, g = _add(q[2], low[2], change[2])
    d, h = _add(q[3], low[3], change[3])
    low = (
        fma(n, a, e + remainder[0]),
        fma(n, b, f + remainder[1]),
        fma(n, c, g + remainder[2]),
        fma(n, d, h + remainder[3]),
    )
    return (a, b, c, d), w, low, w_low


@subroutine
def kicked(state, change, remainder):
    """A state whose angular velocity is changed by (change + remainder)."""
    q, w, q_low, low = state
    a, d = _add(w[0], low[0], change[0])
    b, e = _add(w[1], low[1], change[1])
    c, f = _add(w[2], low[2], change[2])
    return q, (a, b, c), q_low, (d + remainder[0], e + remainder[1], f + remainder[2])


@subroutine
def _add(x, low, change):
    """x + low + change as a sum and its error, exact if |change| >= |low|, else rounded."""
    change, lost = quick_two_sum(change, low)
    x, left = two_sum(x, change)
    return x, left + lost


# The largest change of the state over one increment, as an angle (see `pieces`).
# Truncation there is below 5e-17 of the angle; tests/torques/test_splitting.py walks across the
# limit.
LONGEST_PIECE: Final = 0.1
# Momenta below the square root of this (moments at most 1) turn a body so little in any time that
# the square of the angle is below a rounding.
NO_MOMENTUM: Final = 1e-150
# Gauss-Jacobi on (0, 1) with weight x^2, four points; their squares; weights over the squares.
_POINTS = 0.20414858210322714, 0.4829527048956325, 0.7613992624481377, 0.9514994505530027
_SQUARES = 0.041676643574758074, 0.23324331516600788, 0.5797288368565681, 0.9053512044026659
_WEIGHTS = 0.24839430102735088, 0.2942587534569803, 0.24745843345844748, 0.12248110464981389
# S(h)/h - 1 in powers of the sum and the product of a = e1 h^2 and b = e3 h^2, from
# S'' = -(a + b) S + 2 a b S^3; at a = 1, b = m it is DLMF 22.10.  Rows: powers of the product.
_SINE_0 = -1.0 / 6.0, 1.0 / 120.0, -1.0 / 5040.0, 1.0 / 362880.0, -1.0 / 39916800.0
_SINE_1 = 1.0 / 10.0, -132.0 / 5040.0, 1224.0 / 362880.0, -11064.0 / 39916800.0
_SINE_2 = 3024.0 / 362880.0, -132624.0 / 39916800.0, 4095792.0 / 6227020800.0
_SINE_3 = 4390848.0 / 6227020800.0
# sqrt(1 - a) - 1 = a (...), to 2e-19 of it for a up to the square of the longest piece.
_ROOT = (
    -0.5,
    -0.12499999999999983,
    -0.0625000000002579,
    -0.039062499845395435,
    -0.027343794105263115,
    -0.02050136159519226,
    -0.01657973412625723,
)
# 1/(2 sqrt(1 - a)) = 1/2 + a (...), to 1.1e-19 for a up to a quarter of that.
_INVERSE = (
    0.25,
    0.18749999999956724,
    0.1562500013844867,
    0.1367172002104618,
    0.12375449878992466,
)
_OVER_4_PI = 0.07957747154594767


@subroutine
def gains(moments):
    """k1, k2, k3 of Euler's equations w_i' = k_i w_j w_k, for moments above zero."""
    i1, i2, i3 = moments
    return (i2 - i3) / i1, (i3 - i1) / i2, (i1 - i2) / i3


@force_inlined
def rates(k, w):
    """Coefficients of the free motion from w: w', then e1, e3 and kappa = k1 k3 w2^2 in pairs.

    Rounding errors with a nonzero mean make energy and momentum drift: those even in h do not
    average out.  The product of a constant and a double has a mean (0.8 n has only five fractions),
    and so has a sum that loses the same small term each time.  So products with the k stay pairs
    until a rate is in them twice, and h enters through S alone: every S is on the exact motion.
    """
    k1, k2, k3 = k
    w1, w2, w3 = w
    kappa = _times(two_prod(k1, k3), w2 * w2)
    e1 = _sum(_times(two_prod(-k2, k3), w1 * w1), kappa)
    e3 = _sum(_times(two_prod(-k1, k2), w3 * w3), kappa)
    return (_three(k1, w2, w3), _three(k2, w3, w1), _three(k3, w1, w2)), e1, e3, kappa


@subroutine
def speed_of(w, rate):
    """|w|^2, and |w|^2 times the square of the rate of change of the state, an angle over time.

    A piece is limited by the motion of the angular velocity over the body, not by the turn of the
    body: a sphere, or any body that spins about an axis, takes one piece at any h.
    """
    (r1, r2, r3), e1, e3, _ = rate
    size = fma(w[0], w[0], fma(w[1], w[1], w[2] * w[2]))
    return size, fma(e1[0] + e3[0], size, fma(r1, r1, fma(r2, r2, r3 * r3)))


@subroutine
def pieces(k, w, h):
    """The number of equal pieces, at least one, of a free motion of h seconds."""
    size, speed = speed_of(w, rates(k, w))
    if not speed > 0.0:
        return 1
    return max(1, math.ceil(abs(h) * math.sqrt(speed / size) / LONGEST_PIECE))


@force_inlined
def increment(moments, w, rate, h):
    """The change of state over h seconds of free rotation, h not longer than one of `pieces`.

    Given
        moments   (3) in ascending order, any unit in which the largest is about 1; above zero
        w         (3) rad/s over the principal axes
        rate      `rates` of w
    Returned
        turn      (4) s, x, y, z: q(t) = q(0) (1 + s; x, y, z), a unit quaternion but for rounding
        change    (3) w(t) - w
        n, rest   rounding errors: 1 + n is the factor that makes q(t) of unit length; (3) to be
                  added to w(t) - w
    """
    momentum, square = momentum_of(moments, w)
    if not square > NO_MOMENTUM:
        none, half = 0.0 * square, 0.5 * h  # NaN stays NaN
        turn = none, half * w[0], half * w[1], half * w[2]
        return turn, (none, none, none), none, (none, none, none)
    over = 1.0 / root(square)
    energy, turns = linear_turns(momentum, w, h, over)
    linear = over, energy, sincos(turns, 0.0)
    return turn_and_change(moments, w, rate, h, momentum, square, linear)


@subroutine
def momentum_of(moments, w):
    """The momentum over the body, and its square."""
    m1, m2, m3 = moments[0] * w[0], moments[1] * w[1], moments[2] * w[2]
    return (m1, m2, m3), fma(m1, m1, fma(m2, m2, m3 * m3))


@subroutine
def linear_turns(m, w, h, over):
    """Twice the energy, and the part of chi/2 that is linear in time in turns; `over`: 1/L."""
    energy = fma(m[0], w[0], fma(m[1], w[1], m[2] * w[2]))
    return energy, energy * h * over * _OVER_4_PI


@force_inlined
def turn_and_change(moments, w, rate, h, momentum, square, linear):
    """What `increment` returns; its arguments are doubles or SIMD vectors.

    linear   1/L, twice the energy, and sine and cosine of the part of chi/2 that is linear in time
    """
    i1, i2, i3 = moments
    _, e1, e3, _ = rate
    m1, m2, m3 = momentum
    over, energy, (sine, cosine) = linear
    hh = h * h
    s = fma(h, _sine(hh * e1[0], hh * e3[0]), h)
    inverse = 1.0 / square
    # the rest of chi/2, in radians
    area = 0.5 * s * over * _area(moments, (m1, m2, m3), w, rate, s, inverse, energy * inverse)
    second, third = -0.5 * (area * area), fma(area * area, area * (-1.0 / 6.0), area)
    sine, cosine = (
        fma(cosine, third, fma(sine, second, sine)),
        fma(-sine, third, fma(cosine, second, cosine)),
    )

    change, error = _change(w, rate, s)
    d1, d2, d3 = i1 * change[0], i2 * change[1], i3 * change[2]
    # (l - l0) x l0 and (1 - l . l0)/2 times L^2
    p1, p2, p3 = fma(d2, m3, -d3 * m2), fma(d3, m1, -d1 * m3), fma(d1, m2, -d2 * m1)
    half = -0.5 * inverse
    a = fma(half * m1, d1, fma(half * m2, d2, half * m3 * d3))
    size = _over_root(a)
    s = fma(cosine * size, fma(-2.0, a, 2.0), -1.0)
    sine, cosine = sine * (over * size), cosine * (inverse * size)
    x = fma(sine, fma(2.0, m1, d1), cosine * p1)
    y = fma(sine, fma(2.0, m2, d2), cosine * p2)
    z = fma(sine, fma(2.0, m3, d3), cosine * p3)
    # To unit length: over a million steps a bias in s would accumulate.
    n = -0.5 * (fma(s, s, 2.0 * s) + fma(x, x, fma(y, y, z * z)))
    return (s, x, y, z), change, n, error


@force_inlined
def _area(moments, m, w, rate, s, inverse, ratio):
    """L / S(h) times the area of the path of l, from w and the momenta m over the body.

    At each point, times d: with u = c - 1,
        w(t) . l0 - (2 T/L) l . l0 = u1 (S b1 + u3 a2 - a1) + u3 (S b3 - a3)
        1 + l . l0 = 2 - kappa S^2 + u1 (S f1 + u3 g2 + g2 + g3) + u3 (S f3 + g1 + g2)
    where a = v w, b = v w', f = j w', g = j w, v = m (1 - ratio I), j = m I/L^2, ratio = 2 T/L^2.
    The sums of m w', of a and of I m w', which vanish, are left out.
    """
    i1, i2, i3 = moments
    m1, m2, m3 = m
    w1, w2, w3 = w
    (r1, _, r3), e1, e3, kappa = rate
    v1, v2, v3 = m1 * fma(-ratio, i1, 1.0), m2 * fma(-ratio, i2, 1.0), m3 * fma(-ratio, i3, 1.0)
    j1, j2, j3 = i1 * inverse * m1, i2 * inverse * m2, i3 * inverse * m3
    g1, g2, g3 = j1 * w1, j2 * w2, j3 * w3
    squares, points = for_each(_SQUARES, s), for_each(_POINTS, s) * s
    ss = s * s
    c1 = root(fma(squares, -ss * e1[0], 1.0))
    c3 = root(fma(squares, -ss * e3[0], 1.0))
    u1, u3 = c1 - 1.0, c3 - 1.0
    top = u1 * fma(points, v1 * r1, fma(u3, v2 * w2, -v1 * w1))
    top = fma(u3, fma(points, v3 * r3, -v3 * w3), top)
    low = fma(squares, -ss * kappa[0], 2.0)
    low = fma(u1, fma(points, j1 * r1, fma(u3, g2, g2 + g3)), low)
    low = fma(u3, fma(points, j3 * r3, g1 + g2), low)
    return summed_for_each(top * for_each(_WEIGHTS, s) / (low * (c1 * c3)), s)


@force_inlined
def _change(w, rate, s):
    """w(t) - w at S = s, and its rounding error."""
    w1, w2, w3 = w
    (r1, r2, r3), e1, e3, kappa = rate
    ss, less = two_prod(s, s)
    a1, a3, g = e1[0] * ss, e3[0] * ss, kappa[0] * ss
    u1, u3 = _root_less_one(a1), _root_less_one(a3)
    # u1 and u3 are the same at each step of a free motion: their rounding errors would have a mean,
    # so no product or sum of u1 and u3 alone is rounded
    r1, r2, r3 = r1 * s, r2 * s, r3 * s
    n1 = fma(r1, u1, fma(w1, u3, fma(w1, g, r1)))
    n2 = fma(w2, u3, fma(w2, u1, fma(w2 * u1, u3, fma(w2, g, r2))))
    n3 = fma(r3, u3, fma(w3, u1, fma(w3, g, r3)))
    more = g / (1.0 - g)  # over d = 1 - g, rounded once
    change = fma(n1, more, n1), fma(n2, more, n2), fma(n3, more, n3)
    v1, v3 = _left_out(e1, ss, less, a1, u1), _left_out(e3, ss, less, a3, u3)
    v = fma(kappa[0], ss, -g) + fma(kappa[0], less, kappa[1] * ss)
    error = (
        fma(w1, v3 + v, fma(r1, v1, n1 * v)),
        fma(w2, (v1 + v3) + v, n2 * v),
        fma(w3, v1 + v, fma(r3, v3, n3 * v)),
    )
    return change, error


@subroutine
def _left_out(e, ss, less, a, u):
    """The error of u as sqrt(1 - e (ss + less)) - 1; a is e ss rounded."""
    # u^2 + 2 u + a = 0; 2 u + a is exact
    residual = fma(u, u, fma(2.0, u, a)) + (fma(e[0], ss, -a) + fma(e[0], less, e[1] * ss))
    # over 2 (1 + u)
    return residual * fma(u, fma(-0.5, u, 0.5), -0.5)


@subroutine
def _three(a, b, c):
    """a b c rounded once."""
    p, low = two_prod(a, b)
    return fma(p, c, low * c)


@subroutine
def _times(a, x):
    """A pair times a double."""
    p, low = two_prod(a[0], x)
    return p, fma(a[1], x, low)


@subroutine
def _sum(a, b):
    """The sum of two pairs of one sign."""
    s, low = two_sum(a[0], b[0])
    return s, low + (a[1] + b[1])


@subroutine
def _sine(a, b):
    """S(h)/h - 1."""
    s, p = a + b, a * b
    ss = s * s
    row = fma(ss, _SINE_0[4], fma(s, _SINE_0[3], _SINE_0[2]))
    row = s * fma(ss, row, fma(s, _SINE_0[1], _SINE_0[0]))
    row_1 = fma(ss, fma(s, _SINE_1[3], _SINE_1[2]), fma(s, _SINE_1[1], _SINE_1[0]))
    row_2 = fma(ss, _SINE_2[2], fma(s, _SINE_2[1], _SINE_2[0]))
    return fma(p, fma(p, fma(p, _SINE_3, row_2), row_1), row)


@subroutine
def _root_less_one(a):
    """sqrt(1 - a) - 1 without cancellation."""
    aa = a * a
    high = fma(aa, _ROOT[6], fma(a, _ROOT[5], _ROOT[4]))
    return a * fma(aa, fma(aa, high, fma(a, _ROOT[3], _ROOT[2])), fma(a, _ROOT[1], _ROOT[0]))


@subroutine
def _over_root(a):
    """1/(2 sqrt(1 - a))."""
    aa = a * a
    high = fma(aa, _INVERSE[4], fma(a, _INVERSE[3], _INVERSE[2]))
    return fma(a, fma(aa, high, fma(a, _INVERSE[1], _INVERSE[0])), 0.5)


@force_inlined
def advance(moments, k, h, state):
    """The state after h s of free rotation: wxyz (4), w (3) over principal axes, and low halves."""
    rate = rates(k, state[1])
    size, speed = speed_of(state[1], rate)
    count, piece = 1, h
    if not speed * (h * h) <= (LONGEST_PIECE * LONGEST_PIECE) * size:
        count = pieces(k, state[1], h)
        piece = h / count
    while True:
        state = moved_by(state, increment(moments, state[1], rate, piece))
        count -= 1
        if not count > 0:
            return state
        rate = rates(k, state[1])


# ---- The exact free rotation of two bodies over short times, computed together
# The formulas above in SIMD vectors of two lanes: two bodies in the time of one.

# The square of an eighth of a turn, and the bits of two lanes.
_EIGHTH: Final = 0.015625
BOTH: Final = 3
# More pieces than a right angle has for any body.
_MOST: Final = 1e6


@force_inlined
def advance_two(moments, k, h, state, squares):
    """Free motions of two bodies of the same moments: states, and whether they are right.

    They are not for bodies at rest, and turns by more than a right angle.  h, state: as in
    `advance`, SIMD vectors with a lane for each body; squares: of the longest pieces
    (`step.LONGEST_PIECE`).
    """
    rate = rates(k, state[1])
    size, speed = speed_of(state[1], rate)
    piece, left, count, uneven = h, h, 1.0, False
    if positive_bits(squares * size - speed * (h * h)) != BOTH:
        one, two = doubles_of(root(h * h * speed / (squares * size)))
        one, two = _pieces(one), _pieces(two)
        left, count, uneven = lanes((one, two)), max(one, two), one != two
        piece = h / left
    while True:
        momentum, square = momentum_of(moments, state[1])
        over = 1.0 / root(square)
        energy, turns = linear_turns(momentum, state[1], piece, over)
        linear = over, energy, sincos_of_eighth(turns)
        by = turn_and_change(moments, state[1], rate, piece, momentum, square, linear)
        moved = moved_by(state, by)
        fine = positive_bits(square - NO_MOMENTUM) & positive_bits(_EIGHTH - turns * turns)
        if uneven:  # the body of fewer pieces keeps its state
            moved, left = _where(left, moved, state), left - 1.0
        count -= 1.0
        if fine != BOTH or not count > 0.0:
            return moved, fine == BOTH
        state, rate = moved, rates(k, moved[1])


@subroutine
def _pieces(length):
    """The number of pieces of a flight, by its length in longest pieces; one for NaN."""
    return max(1.0, 1.0 * math.ceil(length)) if length < _MOST else 1.0


@subroutine
def _where(left, one, two):
    """The lanes of a state where those of `left` are above zero, else those of another."""
    q, w, q_low, w_low = one
    p, v, p_low, v_low = two
    return (
        _four_where(left, q, p),
        _three_where(left, w, v),
        _four_where(left, q_low, p_low),
        _three_where(left, w_low, v_low),
    )


@subroutine
def _three_where(left, a, b):
    """`chosen` of vectors."""
    return chosen(left, a[0], b[0]), chosen(left, a[1], b[1]), chosen(left, a[2], b[2])


@subroutine
def _four_where(left, a, b):
    """`chosen` of quaternions."""
    one, two = chosen(left, a[0], b[0]), chosen(left, a[1], b[1])
    return one, two, chosen(left, a[2], b[2]), chosen(left, a[3], b[3])
