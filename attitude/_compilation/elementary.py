"""Elementary functions of SIMD vectors, which have no instruction: powers, angles, logarithms.

Polynomials of least maximum error; the numbers are remade by benchmarks/make_coefficients.py.
They stand in the code one by one, since a loop over a table is not unrolled before it is inlined.
"""

from __future__ import annotations

import math

from attitude._compilation.decorators import reduction_within
from attitude._compilation.simd import at_most, exponent, halved, inverse_power, nearest_eighth

# 2**-f = 1 + f E(f) on |f| <= 1/16: least maximum of the error of E, 2.9e-14.
_POWER_1 = -0.6931471805599737
_POWER_2 = 0.2402265069591155
_POWER_3 = -0.05550410853390105
_POWER_4 = 0.009618129083681301
_POWER_5 = -0.0013334451888357354
_POWER_6 = 0.0001540456288429988

# (2/pi) atan(x) / x on 0 <= x^2 <= 1: least maximum of the error, 3.7e-15.
_ANGLE_0 = 0.6366197723675777
_ANGLE_1 = -0.21220659078703188
_ANGLE_2 = 0.12732395425624587
_ANGLE_3 = -0.09094567310637301
_ANGLE_4 = 0.07073534794616572
_ANGLE_5 = -0.05787218407473211
_ANGLE_6 = 0.04895078785723625
_ANGLE_7 = -0.042321701083695464
_ANGLE_8 = 0.03692481176433205
_ANGLE_9 = -0.03178544537094802
_ANGLE_10 = 0.025967849987901227
_ANGLE_11 = -0.01907030381877682
_ANGLE_12 = 0.011813063789231268
_ANGLE_13 = -0.005753737333594336
_ANGLE_14 = 0.0020236103174555266
_ANGLE_15 = -0.0004509888678315502
_ANGLE_16 = 4.742615684110002e-05

# log2((1 + s)/(1 - s)) = s (2/ln 2 + u L(u)) with u = s^2 <= 1/25: least maximum of the error of
# L, 5.1e-17.
_LOG_0 = 2.0 / math.log(2.0)
_LOG_1 = 0.9617966939259756
_LOG_2 = 0.5770780163556996
_LOG_3 = 0.4121985830514884
_LOG_4 = 0.3205989098388086
_LOG_5 = 0.26230703209546946
_LOG_6 = 0.22201420926957832
_LOG_7 = 0.19058058608906725
_LOG_8 = 0.19629753902736757

# Taylor's series of sine and cosine of 2 pi r on |r| <= 1/8, to 2e-14 and 1e-15.
_SINES = tuple((-1) ** n * math.tau ** (2 * n + 1) / math.factorial(2 * n + 1) for n in range(7))
_COSINES = tuple((-1) ** n * math.tau ** (2 * n) / math.factorial(2 * n) for n in range(8))
_SIN_1, _SIN_3, _SIN_5, _SIN_7, _SIN_9, _SIN_11, _SIN_13 = _SINES
_, _COS_2, _COS_4, _COS_6, _COS_8, _COS_10, _COS_12, _COS_14 = _COSINES


@reduction_within
def power_of_half(a):
    """2^-a for a >= 0, relative to (3e-15 + 1e-16 a); of numbers above 1000 that of 1000."""
    return power_of_half_to_1000(at_most(a, 1000.0))


@reduction_within
def power_of_half_to_1000(a):
    """`power_of_half` of numbers up to 1000."""
    f = a - nearest_eighth(a)
    p = f * _POWER_6 + _POWER_5
    p = f * p + _POWER_4
    p = f * p + _POWER_3
    p = f * p + _POWER_2
    p = f * p + _POWER_1
    return inverse_power(a) * (f * p + 1.0)


@reduction_within
def share_of_half_turn(x):
    """(2/pi) atan(x) for 0 <= x <= 1, to 8e-15 of it."""
    z = x * x
    p = z * _ANGLE_16 + _ANGLE_15
    p = z * p + _ANGLE_14
    p = z * p + _ANGLE_13
    p = z * p + _ANGLE_12
    p = z * p + _ANGLE_11
    p = z * p + _ANGLE_10
    p = z * p + _ANGLE_9
    p = z * p + _ANGLE_8
    p = z * p + _ANGLE_7
    p = z * p + _ANGLE_6
    p = z * p + _ANGLE_5
    p = z * p + _ANGLE_4
    p = z * p + _ANGLE_3
    p = z * p + _ANGLE_2
    p = z * p + _ANGLE_1
    return x * (z * p + _ANGLE_0)


@reduction_within
def binary_logarithm(a):
    """log2(a) for normal a > 0, to 4e-16 of it."""
    n = exponent(a)
    f = halved(a, n) - 1.0
    s = f / (f + 2.0)
    u = s * s
    p = u * _LOG_8 + _LOG_7
    p = u * p + _LOG_6
    p = u * p + _LOG_5
    p = u * p + _LOG_4
    p = u * p + _LOG_3
    p = u * p + _LOG_2
    p = u * p + _LOG_1
    return n + s * (u * p + _LOG_0)


@reduction_within
def cosine_and_sine(v):
    """Cosine and sine of v turns, |v| below 2^48, to 1e-13."""
    # of a quarter of the angle, which is doubled twice
    r = 0.25 * v - 2.0 * nearest_eighth(0.125 * v)
    z = r * r
    s = z * _SIN_13 + _SIN_11
    s = z * s + _SIN_9
    s = z * s + _SIN_7
    s = z * s + _SIN_5
    s = z * s + _SIN_3
    s = r * (z * s + _SIN_1)
    c = z * _COS_14 + _COS_12
    c = z * c + _COS_10
    c = z * c + _COS_8
    c = z * c + _COS_6
    c = z * c + _COS_4
    c = z * c + _COS_2
    c = z * c + 1.0
    c, s = 1.0 - 2.0 * s * s, 2.0 * c * s
    return 1.0 - 2.0 * s * s, 2.0 * c * s
