"""The internal motion at given phases, from the series of the theta functions.

Straight-line arithmetic on doubles without calls or branches, so that LLVM vectorises the loops
over epochs.  The attitude of internal axes to the frame whose z axis is the angular
momentum is the pair alpha = w + i z, beta = x + i y of the Cayley-Klein form of van Zon &
Schofield's solution; the pair is not normalised here.  Coefficients are tuples, lowest power
first.
"""

from __future__ import annotations

from typing import Final

from attitude._compilation.decorators import force_inlined
from attitude._compilation.instructions import (
    as_bits,
    chosen_if,
    descending_fma,
    from_bits,
    loop_fma,
    rint,
)
from attitude._solver.twofloat import two_sum

# ---- Phases in turns: linear in time without loss, and their sine and cosine
# Everything that grows with time is a phase f t + x0.  In turns, its whole part is removed exactly;
# in two doubles, its fraction has an error of 1e-16 of a turn up to 1e15 turns, and 1e-14 at
# LONGEST.

# In turns.  Later epochs are refused: two doubles leave too few digits of the fraction.
LONGEST: Final = 5e16

# Least-maximum polynomials on an eighth of a turn: sin 2 pi r = r (2 pi + z S(z)) and
# cos 2 pi r = 1 + z C(z), z = r^2; largest errors with these coefficients 7e-18 and 1.7e-17.
_SIN_1 = 6.283185307179586
# What the first coefficient rounds off.
_SIN_1_LOW = 2.4492935982947064e-16
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
    x = chosen_if(odd, cosine, sine)
    y = chosen_if(odd, sine, cosine)
    x = from_bits(as_bits(x) ^ ((count & 2) << 62))
    y = from_bits(as_bits(y) ^ (((count + 1) & 2) << 62))
    return x, y


@force_inlined
def sincos_at(rate, start, t, t_low):
    """Sine and cosine of rate (t + t_low) + start, pairs in turns and turns per second."""
    s, lo, _ = phase(rate[0], rate[1], start[0], start[1], t, t_low, 1.0)
    return sincos(s, lo)


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
    a = chosen_if(a > 1000.0, 1000.0, a)
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


_SIGN = -0x8000000000000000
_TINY = 1e-300


@force_inlined
def triple(row):
    """The first three entries of an array as a tuple."""
    return row[0], row[1], row[2]


@force_inlined
def four(row):
    """The first four entries of an array as a tuple."""
    return row[0], row[1], row[2], row[3]


@force_inlined
def five(row):
    """The first five entries of an array as a tuple."""
    return row[0], row[1], row[2], row[3], row[4]


@force_inlined
def quadratic(c, x):
    """c0 + c1 x + c2 x^2."""
    return loop_fma(loop_fma(c[2], x, c[1]), x, c[0])


@force_inlined
def cubic(c, x):
    """c0 + ... + c3 x^3."""
    return loop_fma(loop_fma(loop_fma(c[3], x, c[2]), x, c[1]), x, c[0])


@force_inlined
def quartic(c, x):
    """c0 + ... + c4 x^4."""
    return loop_fma(loop_fma(loop_fma(loop_fma(c[4], x, c[3]), x, c[2]), x, c[1]), x, c[0])


@force_inlined
def turned(pair, sine, cosine):
    """Both members of a pair (4) times cosine + i sine: a turn about the angular momentum."""
    ar, ai, br, bi = pair
    return (
        loop_fma(ar, cosine, -ai * sine),
        loop_fma(ai, cosine, ar * sine),
        loop_fma(br, cosine, -bi * sine),
        loop_fma(bi, cosine, br * sine),
    )


@force_inlined
def trigonometric_pair(alpha, beta, sine, cosine):
    """The pair (4), theta4 and theta1 of v + i delta, nome Q, from sine and cosine of v."""
    double_cosine = loop_fma(-2.0 * sine, sine, 1.0)
    double_sine = 2.0 * sine * cosine
    return (
        cubic(alpha[0], double_cosine),
        double_sine * cubic(alpha[1], double_cosine),
        sine * cubic(beta[0], double_cosine),
        cosine * cubic(beta[1], double_cosine),
    )


@force_inlined
def trigonometric_rates(rates, sine, cosine):
    """Angular velocity (3), rad/s over the internal axes: theta quotients of v, nome q."""
    double_cosine = loop_fma(-2.0 * sine, sine, 1.0)
    over = 1.0 / quartic(rates[3], double_cosine)
    return (
        over * (cosine * quartic(rates[0], double_cosine)),
        over * (sine * quartic(rates[1], double_cosine)),
        over * quartic(rates[2], double_cosine),
    )


@force_inlined
def hyperbolic_arguments(dx, decay, nome):
    """E = exp(-2|y|), F = Q'/E and G = Q' E, each at most 1."""
    e = exp2_of_minus(decay * abs(dx))
    return e, nome / chosen_if(e > _TINY, e, _TINY), nome * e


@force_inlined
def hyperbolic_pair(alpha, ratio, dx, half_turns, arguments):
    """The pair (4) alpha, beta times 2 exp(-|y|).

    The two series of alpha are Q'^(n^2) times cos and sin of (2n + 1) d; those of beta alternate
    in sign, which is F -> -F and G -> -G.
    """
    cosines, sines = alpha
    e, f, g = arguments
    ar = loop_fma(e, cubic(cosines, g), cubic(cosines, f))
    ai = _with_sign_of(loop_fma(-e, cubic(sines, g), cubic(sines, f)), dx)
    factor = negated_if_odd(-ratio, half_turns)
    br = factor * _with_sign_of(loop_fma(-e, cubic(cosines, -g), cubic(cosines, -f)), dx)
    bi = factor * loop_fma(e, cubic(sines, -g), cubic(sines, -f))
    return ar, ai, br, bi


@force_inlined
def hyperbolic_rates(rates, dx, half_turns, arguments):
    """Angular velocity (3), rad/s over the internal axes: theta quotients of 2 i y, nome Q'^2."""
    e, f, g = arguments
    f2, g2, e2 = f * f, g * g, e * e
    over = 1.0 / loop_fma(e2, quadratic(rates[3], g2), quadratic(rates[3], f2))
    difference = loop_fma(-e2, quadratic(rates[1], g2), quadratic(rates[1], f2))
    # 1 + sum over n of both F^2n and G^2n: the constant term is counted once
    w1 = over * e * (quadratic(rates[0], f2) + (quadratic(rates[0], g2) - rates[0][0]))
    w3 = over * e * (quadratic(rates[2], f2) + (quadratic(rates[2], g2) - rates[2][0]))
    return (
        negated_if_odd(w1, half_turns),
        negated_if_odd(_with_sign_of(over * difference, dx), half_turns),
        w3,
    )


@force_inlined
def _with_sign_of(x, y):
    """x, with its sign changed if y is negative."""
    return from_bits(as_bits(x) ^ (as_bits(y) & _SIGN))
