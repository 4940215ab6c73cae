"""Elliptic integrals by the arithmetic-geometric mean, in pairs where time multiplies the result.

Bulirsch, Numer. Math. 13, 305 (1969) for cel; DLMF 19.8(ii) for the descending Landen
transformation.
"""

from __future__ import annotations

import math

import numpy as np

from attitude._compilation.decorators import subroutine
from attitude._solver.twofloat import (
    HALF_PI,
    ONE,
    add,
    div,
    mul,
    neg,
    quick_two_sum,
    scale,
    sqrt,
    square,
    sub,
)

# The AGM error is squared by each step: from 1e-8 apart to 1e-16 (double), 1e-16 to 1e-32 (pairs).
_CLOSE = 1e-8
_CLOSE_PAIR = 1e-16
# Where rounding keeps the means apart; of 1 and 1e-154, mc = 1e-308, they meet within 14 steps.
_MOST_STEPS = 40


@subroutine
def complete_and_phase(kc, p, a, cosine, sine):
    """The complete integrals and the phase of one modulus, in one iteration, all in pairs.

    Given
        kc     complementary modulus, 0 < kc <= 1
        p      characteristic 1 - n >= 1
        a      first weight, 0 or 1 (the second is 1)
        cosine, sine   of an amplitude in the first quadrant, up to a common factor
    Returned
        cel(kc, p, a, 1) / K    (a = 1: Pi(n|m)/K; a = 0: its part without the constant term)
        K(m)
        F(amplitude | m) / (4 K), in turns: each step doubles the amplitude, and the last division
        makes the error of the arctangent small
    """
    e = kc
    em = ONE
    root = sqrt(p)
    p = root
    b = div(ONE, root)
    quadrant = np.int64(0)  # numba gives a literal its own type, and compiles callees for it too
    halvings = 1.0
    c, s = cosine, sine
    for _ in range(_MOST_STEPS):
        f = a
        a = add(a, div(b, p))
        g = div(e, p)
        b = add(b, mul(f, g))
        b = (2.0 * b[0], 2.0 * b[1])
        p = add(p, g)
        quadrant, c, s = _doubled(quadrant, div(kc, em), c, s)
        halvings *= 2.0
        g = em
        em = add(em, kc)
        if abs(g[0] - kc[0]) <= _CLOSE_PAIR * g[0]:
            break
        kc = sqrt(e)
        kc = (2.0 * kc[0], 2.0 * kc[1])
        e = mul(kc, em)
    # cel = (pi/2) (a em + b) / (em (em + p)), K = (pi/2) 2^steps / em: em doubled at each step
    quotient = div(add(mul(a, em), b), scale(add(em, p), halvings))
    complete = div(scale(HALF_PI, halvings), em)
    return quotient, complete, _turns(quadrant, c, s, halvings)


@subroutine
def _doubled(quadrant, ratio, c, s):
    """One descending Landen step of an amplitude, represented by cosine, sine and quadrant.

    tan(phi' - phi) = (b/a) tan phi on the same branch: both angles lie in one quadrant, so the
    sum lies in the half plane that starts at twice that quadrant.
    """
    product = mul(s, c)
    c = sub(square(c), mul(ratio, square(s)))
    s = add(product, mul(ratio, product))
    size = 1.0 / (abs(c[0]) + abs(s[0]))
    c, s = scale(c, size), scale(s, size)
    beyond = c[0] > 0.0 if quadrant & 1 else c[0] < 0.0
    return 2 * quadrant + (1 if beyond else 0), c, s


@subroutine
def _turns(quadrant, c, s, halvings):
    """The amplitude over 2 pi halvings, as a pair."""
    c, s = _turned_back(quadrant, c, s)
    correction = (c[0] * s[1] - s[0] * c[1]) / (c[0] * c[0] + s[0] * s[0])
    angle = (math.atan2(s[0], c[0]) + correction) / 6.283185307179586
    hi, lo = quick_two_sum(0.25 * quadrant, angle) if quadrant > 0 else (angle, 0.0)
    return hi / halvings, lo / halvings


@subroutine
def _turned_back(quadrant, c, s):
    """Cosine and sine of an angle less its whole quadrants."""
    side = quadrant & 3
    if side == 0:
        return c, s
    if side == 1:
        return s, neg(c)
    if side == 2:
        return neg(c), neg(s)
    return neg(s), c


@subroutine
def quarter_and_fraction(b, c, s):
    """K of complementary modulus b > 0, and F/K of an amplitude of the first quadrant with a cosine
    and a sine up to a common factor; doubles.
    """
    a = 1.0
    quadrant = 0
    halvings = 1.0
    for _ in range(_MOST_STEPS):
        ratio = b / a
        product = s * c
        c, s = c * c - ratio * s * s, product + ratio * product
        size = 1.0 / (abs(c) + abs(s))
        c, s = c * size, s * size
        beyond = c > 0.0 if quadrant & 1 else c < 0.0
        quadrant = 2 * quadrant + (1 if beyond else 0)
        halvings *= 2.0
        close = abs(a - b) <= _CLOSE * a
        a, b = 0.5 * (a + b), math.sqrt(a * b)
        if close:
            break
    side = quadrant & 3
    if side == 1:
        c, s = s, -c
    elif side == 2:
        c, s = -c, -s
    elif side == 3:
        c, s = -s, c
    # phi / (2^steps a) over pi / (2 a)
    fraction = (quadrant + math.atan2(s, c) / 1.5707963267948966) / halvings
    return 1.5707963267948966 / a, fraction


# ---- Integrals of the second kind, which the derivatives of the solution need

# Duplication of R_D ends where the arguments agree to this: the remainder is below 3e-17.
_CLOSE_SECOND_KIND = 0.0025


@subroutine
def integrals(m, mc):
    """K and D = (K - E)/m of a parameter 0 <= m < 1; B = K - D and E = B + mc D follow.

    K = (pi/2)/M and D = K (1/2 + sum 2^(n-1) c_n^2 / m) with the c_n of the AGM of 1 and sqrt(mc),
    the first two so that nothing is 0/0 for m = 0.
    """
    root = math.sqrt(mc)
    a, b = 0.5 * (1.0 + root), math.sqrt(root)
    # c_1 = m / (2 (1 + root)), c_2 = (a - b)/2 = c_1^2 / (4 a_2)
    over = 0.5 / (1.0 + root)
    total = 0.5 + m * over * over
    c = m * over
    weight = 1.0
    for _ in range(_MOST_STEPS):
        a, b = 0.5 * (a + b), math.sqrt(a * b)
        weight *= 2.0
        share = weight * c * c * over / (16.0 * a * a) * c
        c = c * c / (4.0 * a)
        total += share if weight == 2.0 else weight * c * c / m
        if weight * c < 1e-20:
            break
    k = 0.5 * math.pi / a
    return k, k * total


@subroutine
def third_kind_degenerate(x, y, z):
    """Carlson's R_D(x, y, z) for x, y >= 0, z > 0, at most one of x, y zero; to 5e-16.

    Source: Carlson, Numer. Algorithms 10, 13 (1995), with the series of DLMF 19.36.2.
    """
    total, weight = 0.0, 1.0
    a = 0.2 * (x + y + 3.0 * z)
    x0, y0 = a - x, a - y
    for _ in range(12):
        if weight * max(abs(x0), abs(y0)) < _CLOSE_SECOND_KIND * a:
            break
        rx, ry, rz = math.sqrt(x), math.sqrt(y), math.sqrt(z)
        shift = rx * (ry + rz) + ry * rz
        total += weight / (rz * (z + shift))
        weight *= 0.25
        x, y, z = 0.25 * (x + shift), 0.25 * (y + shift), 0.25 * (z + shift)
        a = 0.25 * (a + shift)
    x, y = weight * x0 / a, weight * y0 / a
    z = -(x + y) / 3.0
    xy, zz = x * y, z * z
    e2, e3, e4, e5 = xy - 6.0 * zz, (3.0 * xy - 8.0 * zz) * z, 3.0 * (xy - zz) * zz, xy * zz * z
    series = 1.0 - 3.0 * e2 / 14.0 + e3 / 6.0 + 9.0 * e2 * e2 / 88.0 - 3.0 * e4 / 22.0
    series += -9.0 * e2 * e3 / 52.0 + 3.0 * e5 / 26.0
    return weight * series / (a * math.sqrt(a)) + 3.0 * total


@subroutine
def by_parameter(cosine, sine, square):
    """dF/dm of the amplitude with this cosine and sine, 1 - m sine^2 being given: s^3 R_D / 6."""
    return sine * sine * sine / 6.0 * third_kind_degenerate(cosine * cosine, 1.0, square)
