"""Elliptic integrals by the arithmetic-geometric mean, in pairs where time multiplies the result.

Bulirsch, Numer. Math. 13, 305 (1969) for cel; DLMF 19.8(ii) for the descending Landen
transformation.
"""

import math

import numpy as np

from attitude.compilation.decorators import subroutine
from attitude.solution.twofloat import (
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
    rest = (math.atan2(s[0], c[0]) + correction) / 6.283185307179586
    hi, lo = quick_two_sum(0.25 * quadrant, rest) if quadrant > 0 else (rest, 0.0)
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
    """K of complementary modulus b > 0, and F/K of the amplitude in the first quadrant; doubles.

    The amplitude is given by its cosine and sine up to a common factor.
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
