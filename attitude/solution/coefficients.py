"""Third stage: coefficients of the series that the kernels evaluate at each phase.

One entry point for each form of the solution, so that a first propagation compiles only the form
it needs.
"""

import math

import numpy as np

from attitude.compilation.decorators import sized_entry_point, subroutine
from attitude.solution import codes
from attitude.solution.phases import phase, sincos
from attitude.solution.series import (
    four,
    hyperbolic_arguments,
    hyperbolic_pair,
    trigonometric_pair,
    turned,
)

# Coefficients in c = cos 2v, by row n: T_n of cos 2nv; the second kind of sin 2nv / sin 2v;
# the fourth and third kinds of sin (2n+1)v / sin v and cos (2n+1)v / cos v.
COS_EVEN = np.array(
    [[1, 0, 0, 0, 0], [0, 1, 0, 0, 0], [-1, 0, 2, 0, 0], [0, -3, 0, 4, 0], [1, 0, -8, 0, 8]], float
)
SIN_EVEN = np.array(
    [[0, 0, 0, 0, 0], [1, 0, 0, 0, 0], [0, 2, 0, 0, 0], [-1, 0, 4, 0, 0], [0, -4, 0, 8, 0]], float
)
SIN_ODD = np.array(
    [[1, 0, 0, 0, 0], [1, 2, 0, 0, 0], [-1, 2, 4, 0, 0], [-1, -4, 4, 8, 0], [1, -4, -12, 8, 16]],
    float,
)
COS_ODD = np.array(
    [[1, 0, 0, 0, 0], [-1, 2, 0, 0, 0], [-1, -2, 4, 0, 0], [1, -4, -4, 8, 0], [1, 4, -12, -8, 16]],
    float,
)


@sized_entry_point
def trigonometric_all(constants):
    """Fill the series of alpha and beta, and q_int(0), of the trigonometric ones of B motions."""
    for b in range(len(constants)):
        c = constants[b]
        if c.fault == codes.FINE and c.form == codes.TRIGONOMETRIC:
            _trigonometric_series(c, c.alpha, c.beta)
            _trigonometric_start(c)


@sized_entry_point
def hyperbolic_all(constants):
    """Fill the series of alpha and beta, and q_int(0), of the hyperbolic ones of B motions."""
    for b in range(len(constants)):
        c = constants[b]
        if c.fault == codes.FINE and c.form == codes.HYPERBOLIC:
            _hyperbolic_series(c, c.alpha)
            _hyperbolic_start(c)


@subroutine
def _trigonometric_series(c, alpha, beta):
    """Theta functions of nome Q, written with X = exp(-2 delta) and P = Q exp(2 delta).

    Every term is then a product of numbers of at most 1, and nothing overflows for a symmetric
    body, whose delta is infinite and whose Q is 0.
    """
    if c.stretch < math.inf:
        double_delta = 0.5 * math.pi * c.stretch * c.fraction
        x = math.exp(-double_delta)
        one_minus_x = -math.expm1(-double_delta)
        nome = math.exp(-math.pi * c.stretch)
        p = math.exp(double_delta - math.pi * c.stretch)
    else:  # m = 0: tanh delta = 1 / sqrt(1 - n)
        one_minus_x = 2.0 / (c.root + 1.0)
        x = (c.root - 1.0) / (c.root + 1.0)
        nome = p = 0.0
    c.nome = nome
    # Term by term: P^n Q^(n(n-1)), P^n Q^(n^2), X^(2n), and 1 - X^(2n), 1 - X^(2n+1) without the
    # cancellation at small delta (a needle's).
    outer = inner = even_x = sign = 1.0
    even_loss, odd_loss = 0.0, one_minus_x
    at_zero = theta4 = 0.0
    nome_n = 1.0
    for n in range(4):
        # theta4: Q^(n^2) exp(+-2n delta)
        even = sign * outer * (1.0 + even_x) if n > 0 else 1.0
        odd = -sign * outer * even_loss
        theta4 += even
        # theta1 exp(-delta): Q^(n(n+1)) exp(2n delta)
        odd_sum, odd_difference = sign * inner * (1.0 + even_x * x), sign * inner * odd_loss
        at_zero += odd_difference
        for k in range(4):
            alpha[0, k] += even * COS_EVEN[n, k]
            alpha[1, k] += odd * SIN_EVEN[n, k]
            beta[0, k] -= odd_sum * SIN_ODD[n, k]
            beta[1, k] -= odd_difference * COS_ODD[n, k]
        outer = inner * p * nome_n
        inner = outer * nome_n * nome
        nome_n *= nome
        even_loss += even_x * (1.0 + x) * one_minus_x
        odd_loss += even_x * x * (1.0 + x) * one_minus_x
        even_x *= x * x
        sign = -sign
    ratio = c.wobble * theta4 / at_zero
    for k in range(4):
        beta[0, k] *= ratio
        beta[1, k] *= ratio


@subroutine
def _hyperbolic_series(c, alpha):
    """Theta functions after the modular transformation: nome Q', 0 on the exact separatrix."""
    d = 0.25 * math.pi * c.fraction
    c.nome = nome = math.exp(-math.pi / c.stretch)
    sign = weight = step = 1.0
    cosines = sines = 0.0
    for n in range(4):
        # weight = Q'^(n^2), step = Q'^n
        alpha[0, n] = weight * math.cos((2 * n + 1) * d)
        alpha[1, n] = weight * math.sin((2 * n + 1) * d)
        cosines += step * alpha[0, n]
        sines += sign * step * alpha[1, n]
        weight *= step * step * nome
        step *= nome
        sign = -sign
    c.beta[0, 0] = c.wobble * cosines / sines


@subroutine
def _trigonometric_start(c):
    """q_int(0), from the series that give q_int(t), so that both round alike."""
    s, lo, _ = phase(0.0, 0.0, c.nutation0[0], c.nutation0[1], 0.0, 0.0, 1.0)
    sine, cosine = sincos(s, lo)
    alpha, beta = (four(c.alpha[0]), four(c.alpha[1])), (four(c.beta[0]), four(c.beta[1]))
    _store(trigonometric_pair(alpha, beta, sine, cosine), c.internal)


@subroutine
def _hyperbolic_start(c):
    """q_int(0), as in `_trigonometric_start`."""
    s, lo, half_turns = phase(0.0, 0.0, c.nutation0[0], c.nutation0[1], 0.0, 0.0, c.winds)
    dx = s + lo
    arguments = hyperbolic_arguments(dx, c.decay, c.nome)
    alpha = four(c.alpha[0]), four(c.alpha[1])
    pair = hyperbolic_pair(alpha, c.beta[0, 0], dx, half_turns, arguments)
    sine, cosine = sincos(-c.tilt * dx, 0.0)
    _store(turned(pair, sine, cosine), c.internal)


@subroutine
def _store(pair, internal):
    """The pair (alpha, beta) as a quaternion w, x, y, z."""
    internal[0], internal[3], internal[1], internal[2] = pair


@sized_entry_point
def trigonometric_rates_all(constants):
    """Fill the series of the angular velocity of the trigonometric ones of B motions."""
    for b in range(len(constants)):
        c = constants[b]
        if c.fault == codes.FINE and c.form == codes.TRIGONOMETRIC:
            _trigonometric_rates(math.sqrt(c.nome), c, c.rates)


@sized_entry_point
def hyperbolic_rates_all(constants):
    """Fill the series of the angular velocity of the hyperbolic ones of B motions."""
    for b in range(len(constants)):
        c = constants[b]
        if c.fault == codes.FINE and c.form == codes.HYPERBOLIC:
            _hyperbolic_rates(c.nome, c)


@subroutine
def _trigonometric_rates(q, c, rates):
    """Amplitudes times cn, sn, dn as theta quotients, nome q.

    theta1 and theta2 are without their factor 2 q^(1/4).
    """
    theta2 = theta3 = theta4 = 0.0
    sign = even = odd = step = 1.0
    for n in range(5):
        # even = 2 q^(n^2) (1 at n = 0), odd = q^(n(n+1)), step = q^n
        theta2 += odd
        theta3 += even
        theta4 += sign * even
        for k in range(5):
            rates[0, k] += odd * COS_ODD[n, k]
            rates[1, k] += sign * odd * SIN_ODD[n, k]
            rates[2, k] += even * COS_EVEN[n, k]
            rates[3, k] += sign * even * COS_EVEN[n, k]
        even = 2.0 * q if n == 0 else even * step * step * q
        odd *= step * step * q * q
        step *= q
        sign = -sign
    for k in range(5):
        rates[0, k] *= c.amplitudes[0] * theta4 / theta2
        rates[1, k] *= -c.amplitudes[1] * theta3 / theta2
        rates[2, k] *= c.amplitudes[2] * theta4 / theta3


@subroutine
def _hyperbolic_rates(nome, c):
    """Amplitudes times cn, sn, dn after the modular transformation, nome Q'^2."""
    q = nome * nome
    qq = q * q
    theta2 = 1.0 + qq + qq * qq * qq
    theta3 = 1.0 + 2.0 * (q + qq * qq)
    theta4 = 1.0 - 2.0 * (q - qq * qq)
    cn = 2.0 * c.amplitudes[0] * theta2 / theta4
    sn = -c.amplitudes[1] * theta3 / theta4
    dn = 2.0 * c.amplitudes[2] * theta2 / theta3
    for n in range(3):
        sign = -1.0 if n == 1 else 1.0
        even = qq if n == 2 else 1.0  # q^(n(n-1))
        odd = 1.0 if n == 0 else (q if n == 1 else qq * qq)  # q^(n^2)
        c.rates[0, n] = cn * sign * even
        c.rates[1, n] = sn * sign * odd
        c.rates[2, n] = dn * even
        c.rates[3, n] = odd
