"""The internal motion at given phases, from the series of the theta functions.

Straight-line arithmetic on doubles without calls or branches, so that LLVM vectorises the loops
over epochs.  The attitude of internal axes to the frame whose z axis is the angular
momentum is the pair alpha = w + i z, beta = x + i y of the Cayley-Klein form of van Zon &
Schofield's solution; the pair is not normalised here.  Coefficients are tuples, lowest power
first.
"""

from attitude.compilation.decorators import force_inlined
from attitude.compilation.instructions import as_bits, from_bits, loop_fma
from attitude.solution.phases import exp2_of_minus, negated_if_odd

_SIGN = -0x8000000000000000
_TINY = 1e-300


@force_inlined
def four(row):
    """The first four entries of an array as a tuple."""
    return row[0], row[1], row[2], row[3]


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
    return e, nome / (e if e > _TINY else _TINY), nome * e


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
