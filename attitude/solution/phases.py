"""Phases in turns: linear in time without loss, and their sine and cosine.

Everything that grows with time is a phase f t + x0.  In turns, its whole part is removed exactly;
in two doubles, its fraction has an error of 1e-16 of a turn up to 1e15 turns, and 1e-14 at LONGEST.
"""

from typing import Final

from attitude.compilation.decorators import force_inlined
from attitude.compilation.instructions import as_bits, descending_fma, from_bits, loop_fma, rint
from attitude.solution.twofloat import two_sum

# In turns.  Later epochs are refused: two doubles leave too few digits of the fraction.
LONGEST: Final = 5e16

# Least-maximum polynomials on an eighth of a turn: sin 2 pi r = r (2 pi + z S(z)) and
# cos 2 pi r = 1 + z C(z), z = r^2; largest errors with these coefficients 7e-18 and 1.7e-17.
_SIN_1, _SIN_1_LOW = 6.283185307179586, 2.4492935982947064e-16
_SIN_3 = -41.3417022403996
_SIN_5 = 81.60524927591003
_SIN_7 = -76.70585969377402
_SIN_9 = 42.0586837509293
_SIN_11 = -15.093733874254289
_SIN_13 = 3.779405910810269
_COS_2 = -19.739208802178716
_COS_4 = 64.93939402266801
_COS_6 = -85.45681720654012
_COS_8 = 60.24464133162384
_COS_10 = -26.426251141509123
_COS_12 = 7.903101685941981
_COS_14 = -1.697020922663057

# 2**-f on |f| <= 1/2, in the same way; largest error 1.5e-17.
_EXP_1 = -0.6931471805599453
_EXP_2 = 0.24022650695910133
_EXP_3 = -0.05550410866482174
_EXP_4 = 0.009618129107593333
_EXP_5 = -0.001333355814637906
_EXP_6 = 0.00015403530458078232
_EXP_7 = -1.5252733867512895e-05
_EXP_8 = 1.3215434817540366e-06
_EXP_9 = -1.0178046474491422e-07
_EXP_10 = 7.07386007869764e-09
_EXP_11 = -4.457385122408378e-10

# Adding this leaves a whole number (|n| < 2**51) in the low bits of the sum, two's complement.
_TO_LOW_BITS = 6755399441055744.0


@force_inlined
def phase(rate_hi, rate_lo, start_hi, start_lo, t, t_low, winds):
    """rate (t + t_low) + start less its whole turns, as (hi, lo), and a number of their parity.

    With winds = 0 no turns are removed: the phase of the exact separatrix does not return.
    """
    p = rate_hi * t
    e = loop_fma(rate_hi, t, -p)
    turns = winds * rint(p)
    s, se = two_sum(p - turns, start_hi)
    more = winds * rint(s)
    # e reaches half an ulp of p, so it is renormalised before lo is treated as small.
    s, lo = two_sum(s - more, e + loop_fma(rate_lo, t, rate_hi * t_low))
    last = winds * rint(s)
    # The count can be too large for a double; its difference from an even number is not.
    parity = (turns - 2.0 * rint(0.5 * turns)) + (more + last)
    return s - last, lo + (se + start_lo), parity


@force_inlined
def sincos(s, lo):
    """Sine and cosine of 2 pi (s + lo), |lo| small, s a few turns at the most."""
    quarters = rint(4.0 * s)
    sine, cosine = sincos_of_eighth(s - 0.25 * quarters)
    # first order in lo
    small = _SIN_1 * lo
    sine, cosine = loop_fma(cosine, small, sine), loop_fma(-sine, small, cosine)
    # Odd quarter turns swap the two, and bit 1 of the count is the sign.  Without branches a loop
    # over epochs is vectorised.
    count = as_bits(quarters + _TO_LOW_BITS)
    odd = (count & 1) == 1
    x = cosine if odd else sine
    y = sine if odd else cosine
    x = from_bits(as_bits(x) ^ ((count & 2) << 62))
    y = from_bits(as_bits(y) ^ (((count + 1) & 2) << 62))
    return x, y


@force_inlined
def sincos_of_eighth(r):
    """Sine and cosine of 2 pi r for |r| <= 1/8, a double or a SIMD vector."""
    z = r * r
    a = descending_fma(_SIN_13, z, _SIN_11)
    a = descending_fma(a, z, _SIN_9)
    a = descending_fma(a, z, _SIN_7)
    a = descending_fma(a, z, _SIN_5)
    a = descending_fma(a, z, _SIN_3)
    b = descending_fma(_COS_14, z, _COS_12)
    b = descending_fma(b, z, _COS_10)
    b = descending_fma(b, z, _COS_8)
    b = descending_fma(b, z, _COS_6)
    b = descending_fma(b, z, _COS_4)
    b = descending_fma(b, z, _COS_2)
    return loop_fma(r, _SIN_1, r * loop_fma(a, z, _SIN_1_LOW)), descending_fma(b, z, 1.0)


@force_inlined
def negated_if_odd(x, n):
    """x for an even whole number n, -x for an odd one (n is a float, less than 2**51)."""
    return from_bits(as_bits(x) ^ (as_bits(n + _TO_LOW_BITS) << 63))


@force_inlined
def exp2_of_minus(a):
    """2**-a for a >= 0, to 1e-16 relative; NaN for NaN."""
    a = 1000.0 if a > 1000.0 else a
    n = rint(a)
    f = a - n
    p = descending_fma(_EXP_11, f, _EXP_10)
    p = descending_fma(p, f, _EXP_9)
    p = descending_fma(p, f, _EXP_8)
    p = descending_fma(p, f, _EXP_7)
    p = descending_fma(p, f, _EXP_6)
    p = descending_fma(p, f, _EXP_5)
    p = descending_fma(p, f, _EXP_4)
    p = descending_fma(p, f, _EXP_3)
    p = descending_fma(p, f, _EXP_2)
    p = descending_fma(p, f, _EXP_1)
    p = descending_fma(p, f, 1.0)
    return p * from_bits((1023 - as_bits(n + _TO_LOW_BITS)) << 52)
