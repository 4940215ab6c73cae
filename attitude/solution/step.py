"""The exact free rotation over a short time, for integrators that split torques off.

The closed form of `solution.constants` costs a microsecond to set up, pays for itself after a few
epochs, and treats each regime apart.  A splitting scheme needs one epoch from every state; here is
the same exact solution for that: no set-up, no regimes, no elliptic integral, the same arithmetic
from a sphere to a needle and across the separatrix.

Angular velocity.  For moments in ascending order I1 <= I2 <= I3 and w1' = k1 w2 w3 and so on, with
k1 = (I2 - I3)/I1, the addition theorems of the Jacobi functions (DLMF 22.8) read

    w1(t) = (w1 c3 + w1' S c1) / d        d = 1 - k1 k3 w2^2 S^2
    w2(t) = (w2 c1 c3 + w2' S) / d        c1^2 = 1 - e1 S^2,  e1 = -k2 k3 w1^2 + k1 k3 w2^2
    w3(t) = (w3 c1 + w3' S c3) / d        c3^2 = 1 - e3 S^2,  e3 = -k1 k2 w3^2 + k1 k3 w2^2

where S(t) = sn(r t)/r, r^2 = max(e1, e3), solves S' = c1 c3, S(0) = 0.  Every coefficient is a sum
of terms of one sign (-k2 k3, k1 k3, -k1 k2 >= 0), nothing is divided by a number that can vanish,
and S is a short power series for short times.

Attitude.  The momentum is fixed in space, so the turn from the body axes at t to those at 0 is
the least turn p that carries the direction l(t) to l(0) = l0, followed by a turn about l0 by chi:

    chi' = (w . l + w(t) . l0) / (1 + l(t) . l0)

(the part of w that the least turn leaves: it moves at right angles to l0 + l(t)).  This is the
third elliptic integral of van Zon & Schofield (2006), eq. 3.43, without its poles; over a short
time the integrand is all but constant, and Gauss's rule reaches rounding with six points.

All of it is formed as increments, whose error is that of rounding times the angle turned: summed
with compensation (`advance`), a thousand short steps are as good as one.
"""

import math

from attitude.solution.machine import fma, inlined
from attitude.solution.turns import sincos
from attitude.solution.twofloat import two_prod, two_sum

# What one increment may cover: the change of the state over it, as an angle (see `pieces`).
# Truncation there is below 2e-17 of the angle; tests/test_splitting.py walks across the limit.
LONGEST_PIECE = 0.3
# Gauss-Legendre on (0, 1), six points.
_X1, _X2, _X3 = 0.033765242898423975, 0.1693953067668678, 0.3806904069584016
_G1, _G2, _G3 = 0.08566224618958518, 0.18038078652406930, 0.23395696728634552
# sqrt(1 - a) - 1 = a P(a), for a up to the square of the longest piece: two square roots and two
# divisions cost more than all else in an evaluation.  Relative error 1e-18 before rounding.
_ROOT = (
    -0.5,
    -0.1250000000000018,
    -0.062499999999337294,
    -0.03906250009368675,
    -0.027343743289102194,
    -0.02050808777106462,
    -0.016106438662666676,
    -0.013196505547857866,
    -0.00996072180492057,
    -0.013871415022959518,
)
_OVER_4_PI = 0.07957747154594767


@inlined
def gains(moments):
    """k1, k2, k3 of Euler's equations w_i' = k_i w_j w_k, for moments above zero."""
    i1, i2, i3 = moments
    return (i2 - i3) / i1, (i3 - i1) / i2, (i1 - i2) / i3


@inlined
def pieces(k, w, h):
    """In how many equal pieces a free motion of h seconds is to be taken.

    What limits a piece is how far the angular velocity moves over the body, not how far the body
    turns: a sphere, or any body that spins about an axis, takes one piece at any h.
    """
    k1, k2, k3 = k
    w1, w2, w3 = w
    a, b, c = w1 * w1, w2 * w2, w3 * w3
    rate = -k2 * k3 * a + 2.0 * k1 * k3 * b - k1 * k2 * c
    x, y, z = k1 * w2 * w3, k2 * w3 * w1, k3 * w1 * w2
    size = a + b + c
    if size > 0.0:
        rate += (x * x + y * y + z * z) / size
    return math.ceil(abs(h) * math.sqrt(rate) / LONGEST_PIECE)


@inlined
def increment(moments, k, w, h):
    """The change of state over h seconds of free rotation, h not longer than one of `pieces`.

    Given
        moments   (3) in ascending order, any unit; above zero
        k         their `gains`
        w         (3) rad/s over the principal axes
    Returned
        s, x, y, z    q(t) = q(0) (1 + s; x, y, z), a unit quaternion
        d1, d2, d3    w(t) = w(0) + d
    """
    i1, i2, i3 = moments
    k1, k2, k3 = k
    w1, w2, w3 = w
    m1, m2, m3 = i1 * w1, i2 * w2, i3 * w3
    largest = max(abs(m1), abs(m2), abs(m3))
    if not largest > 0.0:
        nothing = 0.0 * (w1 + w2 + w3)  # NaN stays NaN
        return nothing, nothing, nothing, nothing, nothing, nothing, nothing
    m1, m2, m3 = m1 / largest, m2 / largest, m3 / largest
    over = 1.0 / math.sqrt(m1 * m1 + m2 * m2 + m3 * m3)
    l1, l2, l3 = m1 * over, m2 * over, m3 * over
    over /= largest
    dot = w1 * l1 + w2 * l2 + w3 * l3

    # Rounding with a mean drives energy and momentum: what is even in h does not average out.  The
    # product of a constant and a double has one (0.8 n has five fractions only), and so has a sum
    # that loses the same small term each time.  So products with the k are kept in pairs until a
    # rate is in them twice, and h enters by S alone: any S whatever is on the exact motion.
    r1, r2, r3 = _three(k1, w2, w3), _three(k2, w3, w1), _three(k3, w1, w2)
    s1, s2, s3 = w1 * w1, w2 * w2, w3 * w3
    kappa = _times(two_prod(k1, k3), s2)
    e1 = _sum(_times(two_prod(-k2, k3), s1), kappa)
    e3 = _sum(_times(two_prod(-k1, k2), s3), kappa)
    # in units of the step, so that time runs from 0 to 1
    hh = h * h
    state = w1, w2, w3, h * r1, h * r2, h * r3, hh * e1[0], hh * e3[0], hh * kappa[0]
    series = _series(state[6], state[7])
    weights = l1, l2, l3, i1 * over, i2 * over, i3 * over, dot
    chi = _G1 * (
        _turning(_X1, series, state, weights) + _turning(1.0 - _X1, series, state, weights)
    )
    chi += _G2 * (
        _turning(_X2, series, state, weights) + _turning(1.0 - _X2, series, state, weights)
    )
    chi += _G3 * (
        _turning(_X3, series, state, weights) + _turning(1.0 - _X3, series, state, weights)
    )
    chi *= h

    d1, d2, d3 = _at_end(h * _sine(1.0, series), (w1, w2, w3, r1, r2, r3, e1, e3, kappa))
    # least turn from l to l0: (1 + l . l0; l x l0) / sqrt(2 (1 + l . l0))
    f1, f2, f3 = i1 * over * d1, i2 * over * d2, i3 * over * d3
    one = 2.0 + (f1 * l1 + f2 * l2 + f3 * l3)
    size = 1.0 / math.sqrt(2.0 * one)
    p1, p2, p3 = (f2 * l3 - f3 * l2) * size, (f3 * l1 - f1 * l3) * size, (f1 * l2 - f2 * l1) * size
    square = p1 * p1 + p2 * p2 + p3 * p3
    p0 = one * size
    less = -square / (1.0 + p0)  # p0 - 1
    sine, cosine = sincos(chi * _OVER_4_PI, 0.0)
    drop = -sine * sine / (1.0 + cosine) if cosine > 0.0 else cosine - 1.0
    # (cosine; sine l0) (p0; p), p at right angles to l0
    s = drop + cosine * less
    a = sine * p0
    x = fma(a, l1, fma(cosine, p1, sine * (l2 * p3 - l3 * p2)))
    y = fma(a, l2, fma(cosine, p2, sine * (l3 * p1 - l1 * p3)))
    z = fma(a, l3, fma(cosine, p3, sine * (l1 * p2 - l2 * p1)))
    # Unit length again, to rounding of the squares: a million steps would drift by a bias in s.
    s -= 0.5 * (fma(s, s, 2.0 * s) + fma(x, x, fma(y, y, z * z)))
    return s, x, y, z, d1, d2, d3


@inlined
def _series(a, b):
    """Coefficients of S(x)/(h x) in x^2: sn's, with the modulus kept as two parameters.

    From S'' = -(a + b) S + 2 a b S^3, coefficient by coefficient; at a = 1, b = m it is DLMF 22.10.
    """
    s, p = a + b, a * b
    ss, pp = s * s, p * p
    return (
        s * (-1.0 / 6.0),
        fma(12.0, p, ss) * (1.0 / 120.0),
        s * fma(132.0, p, ss) * (-1.0 / 5040.0),
        fma(fma(1224.0, p, ss), ss, 3024.0 * pp) * (1.0 / 362880.0),
        s * fma(fma(11064.0, p, ss), ss, 132624.0 * pp) * (-1.0 / 39916800.0),
        fma(fma(fma(99636.0, p, ss), ss, 4095792.0 * pp), ss, 4390848.0 * pp * p)
        * (1.0 / 6227020800.0),
        s
        * fma(fma(fma(896796.0, p, ss), ss, 111810672.0 * pp), ss, 490287168.0 * pp * p)
        * (-1.0 / 1307674368000.0),
        fma(
            fma(fma(fma(8071248.0, p, ss), ss, 2901537504.0 * pp), ss, 35424905472.0 * pp * p),
            ss,
            21224560896.0 * pp * pp,
        )
        * (1.0 / 355687428096000.0),
    )


@inlined
def _within(x, series, state):
    """d (w(x) - w) and d, at the fraction x of the step."""
    w1, w2, w3, r1, r2, r3, e1, e3, kappa = state
    s = _sine(x, series)
    ss = s * s
    u1, u3, g = _root_less_one(e1 * ss), _root_less_one(e3 * ss), kappa * ss
    return (
        fma(w1, u3 + g, r1 * s * (1.0 + u1)),
        fma(w2, fma(u1, u3, u1 + u3) + g, r2 * s),
        fma(w3, u1 + g, r3 * s * (1.0 + u3)),
        1.0 - g,
    )


@inlined
def _at_end(s, state):
    """w(h) - w, where rounding must not go one way.

    Given
        s      S(h), s
        state  as in `increment`, in units of seconds; e1, e3 and kappa in pairs

    What the roots leave out is added to a product of kappa, which changes from step to step where
    e1 and e3 hardly do, before that is rounded; added to a rounded number it would be lost.
    """
    w1, w2, w3, r1, r2, r3, e1, e3, kappa = state
    ss, less = two_prod(s, s)
    u1, low1 = _root_less_one_in_pairs(e1, ss, less)
    u3, low3 = _root_less_one_in_pairs(e3, ss, less)
    kappa, low = kappa
    g = fma(kappa, less, low * ss)
    g1, g2, g3 = g + low3, g + (low1 + low3), g + low1
    g, g1 = fma(kappa, ss, g), fma(kappa, ss, g1)
    g2, g3 = fma(kappa, ss, g2), fma(kappa, ss, g3)
    r1, r2, r3 = r1 * s, r2 * s, r3 * s
    n1 = fma(w1, u3 + g1, fma(r1, u1, r1))
    n2 = fma(w2, fma(u1, u3, (u3 + g2) + u1), r2)
    n3 = fma(w3, u1 + g3, fma(r3, u3, r3))
    more = g / (1.0 - g)  # over d = 1 - g, rounded once
    return fma(n1, more, n1), fma(n2, more, n2), fma(n3, more, n3)


@inlined
def _root_less_one_in_pairs(e, ss, less):
    """u = sqrt(1 - a) - 1 for a = e (ss + less), and what its double leaves out."""
    e, low = e
    a = e * ss
    u = -a / (1.0 + math.sqrt(1.0 - a))
    # u^2 + 2 u + a = 0; 2 u + a is exact
    rest = fma(u, u, 2.0 * u + a) + (fma(e, ss, -a) + fma(e, less, low * ss))
    # over 2 (1 + u)
    return u, rest * fma(u, fma(-0.5, u, 0.5), -0.5)


@inlined
def _three(a, b, c):
    """a b c rounded once."""
    p, low = two_prod(a, b)
    return fma(p, c, low * c)


@inlined
def _times(a, x):
    """A pair times a double."""
    p, low = two_prod(a[0], x)
    return p, fma(a[1], x, low)


@inlined
def _sum(a, b):
    """Of pairs of one sign."""
    s, low = two_sum(a[0], b[0])
    return s, low + (a[1] + b[1])


@inlined
def _sine(x, series):
    """S/h at the fraction x of the step."""
    xx = x * x
    return fma(x * xx, _horner(series[7], xx, series), x)


@inlined
def _root_less_one(a):
    """sqrt(1 - a) - 1 without cancellation."""
    return a * _horner(fma(fma(_ROOT[9], a, _ROOT[8]), a, _ROOT[7]), a, _ROOT)


@inlined
def _horner(last, x, c):
    """c[0] + c[1] x + ... + c[6] x^6 + last x^7."""
    p = fma(last, x, c[6])
    p = fma(p, x, c[5])
    p = fma(p, x, c[4])
    p = fma(p, x, c[3])
    p = fma(p, x, c[2])
    p = fma(p, x, c[1])
    return fma(p, x, c[0])


@inlined
def _turning(x, series, state, weights):
    """chi' at the fraction x of the step."""
    l1, l2, l3, f1, f2, f3, dot = weights
    n1, n2, n3, d = _within(x, series, state)
    n1, n2, n3 = l1 * n1, l2 * n2, l3 * n3
    top = fma(2.0 * dot, d, n1 + n2 + n3)
    return top / fma(2.0, d, fma(f1, n1, fma(f2, n2, f3 * n3)))


@inlined
def advance(moments, k, h, state):
    """Move a state by h seconds of free rotation.

    Given
        state   (14,) wxyz and angular velocity over the principal axes, then the same seven
                again: what their doubles leave out
    """
    count = pieces(k, (state[4], state[5], state[6]), h)
    if not count > 0:
        count = 1
    part = h / count
    for _ in range(count):
        w = state[4], state[5], state[6]
        s, x, y, z, d1, d2, d3 = increment(moments, k, w, part)
        q0, q1, q2, q3 = state[0], state[1], state[2], state[3]
        add(state, 0, q0 * s - q1 * x - q2 * y - q3 * z)
        add(state, 1, q1 * s + q0 * x + q2 * z - q3 * y)
        add(state, 2, q2 * s + q0 * y + q3 * x - q1 * z)
        add(state, 3, q3 * s + q0 * z + q1 * y - q2 * x)
        add(state, 4, d1)
        add(state, 5, d2)
        add(state, 6, d3)


@inlined
def add(state, n, change):
    """Compensated: what rounding leaves out of entry n is kept in entry n + 7."""
    hi, lo = two_sum(state[n], state[n + 7] + change)
    state[n], state[n + 7] = hi, lo
