"""Coefficients of the series: what the kernels evaluate at each phase, made once a motion."""

import math

import numpy as np

from attitude.solution.machine import inlined

# Coefficients in c = cos 2v, by row n: T_n of cos 2nv; the second kind of sin 2nv / sin 2v;
# the fourth and third kinds of sin (2n+1)v / sin v and cos (2n+1)v / cos v.
_COS_EVEN = np.array(
    [[1, 0, 0, 0, 0], [0, 1, 0, 0, 0], [-1, 0, 2, 0, 0], [0, -3, 0, 4, 0], [1, 0, -8, 0, 8]], float
)
_SIN_EVEN = np.array([[0, 0, 0, 0], [1, 0, 0, 0], [0, 2, 0, 0], [-1, 0, 4, 0]], float)
_SIN_ODD = np.array(
    [[1, 0, 0, 0, 0], [1, 2, 0, 0, 0], [-1, 2, 4, 0, 0], [-1, -4, 4, 8, 0], [1, -4, -12, 8, 16]],
    float,
)
_COS_ODD = np.array(
    [[1, 0, 0, 0, 0], [-1, 2, 0, 0, 0], [-1, -2, 4, 0, 0], [1, -4, -4, 8, 0], [1, 4, -12, -8, 16]],
    float,
)


@inlined
def trigonometric_series(stretch, fraction, root, wobble, amplitudes, c):
    """Series of alpha, beta (nome Q) and of the angular velocity (nome q = sqrt Q).

    With X = exp(-2 delta), P = Q exp(2 delta): every term is a product of numbers at most 1,
    so that nothing overflows for a symmetric body, where delta is infinite and Q is 0.
    """
    if stretch < math.inf:
        double_delta = 0.5 * math.pi * stretch * fraction
        x = math.exp(-double_delta)
        one_minus_x = -math.expm1(-double_delta)
        nome = math.exp(-math.pi * stretch)
        p = math.exp(double_delta - math.pi * stretch)
    else:  # m = 0: tanh delta = 1 / sqrt(1 - n)
        one_minus_x = 2.0 / (root + 1.0)
        x = (root - 1.0) / (root + 1.0)
        nome = p = 0.0
    c.nome = nome

    for k in range(4):
        c.alpha[0, k] = c.alpha[1, k] = c.beta[0, k] = c.beta[1, k] = 0.0
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
            c.alpha[0, k] += even * _COS_EVEN[n, k]
            c.alpha[1, k] += odd * _SIN_EVEN[n, k]
            c.beta[0, k] -= odd_sum * _SIN_ODD[n, k]
            c.beta[1, k] -= odd_difference * _COS_ODD[n, k]
        outer, inner = inner * p * nome_n, inner * p * nome_n * nome_n * nome
        nome_n *= nome
        even_loss += even_x * (1.0 + x) * one_minus_x
        odd_loss += even_x * x * (1.0 + x) * one_minus_x
        even_x *= x * x
        sign = -sign
    ratio = wobble * theta4 / at_zero
    for k in range(4):
        c.beta[0, k] *= ratio
        c.beta[1, k] *= ratio
    _trigonometric_rate_series(math.exp(-0.5 * math.pi * stretch), amplitudes, c)


@inlined
def _trigonometric_rate_series(q, amplitudes, c):
    """cn, sn, dn as theta quotients; theta1 and theta2 without their factor 2 q^(1/4)."""
    for k in range(5):
        for row in range(4):
            c.rates[row, k] = 0.0
    theta2 = theta3 = theta4 = 0.0
    sign = even = odd = step = 1.0
    for n in range(5):
        # even = 2 q^(n^2) (1 at n = 0), odd = q^(n(n+1)), step = q^n
        theta2 += odd
        theta3 += even
        theta4 += sign * even
        for k in range(5):
            c.rates[0, k] += odd * _COS_ODD[n, k]
            c.rates[1, k] += sign * odd * _SIN_ODD[n, k]
            c.rates[2, k] += even * _COS_EVEN[n, k]
            c.rates[3, k] += sign * even * _COS_EVEN[n, k]
        even = 2.0 * q if n == 0 else even * step * step * q
        odd *= step * step * q * q
        step *= q
        sign = -sign
    for k in range(5):
        c.rates[0, k] *= math.ldexp(amplitudes[0], c.tempo) * theta4 / theta2
        c.rates[1, k] *= -math.ldexp(amplitudes[1], c.tempo) * theta3 / theta2
        c.rates[2, k] *= math.ldexp(amplitudes[2], c.tempo) * theta4 / theta3


@inlined
def hyperbolic_series(nome, fraction, wobble, amplitudes, c):
    """The same after the modular transformation: nome Q', and Q'^2 for the angular velocity."""
    d = 0.25 * math.pi * fraction
    c.nome = nome
    sign = weight = step = 1.0
    cosines = sines = 0.0
    for n in range(4):
        # weight = Q'^(n^2), step = Q'^n
        c.alpha[0, n] = weight * math.cos((2 * n + 1) * d)
        c.alpha[1, n] = weight * math.sin((2 * n + 1) * d)
        cosines += step * c.alpha[0, n]
        sines += sign * step * c.alpha[1, n]
        weight *= step * step * nome
        step *= nome
        sign = -sign
    c.beta[0, 0] = wobble * cosines / sines
    q = nome * nome
    qq = q * q
    theta2 = 1.0 + qq + qq * qq * qq
    theta3 = 1.0 + 2.0 * (q + qq * qq)
    theta4 = 1.0 - 2.0 * (q - qq * qq)
    a1, a2, a3 = amplitudes
    cn = 2.0 * math.ldexp(a1, c.tempo) * theta2 / theta4
    sn = -math.ldexp(a2, c.tempo) * theta3 / theta4
    dn = 2.0 * math.ldexp(a3, c.tempo) * theta2 / theta3
    for n in range(3):
        sign = -1.0 if n == 1 else 1.0
        even = qq if n == 2 else 1.0  # q^(n(n-1))
        odd = 1.0 if n == 0 else (q if n == 1 else qq * qq)  # q^(n^2)
        c.rates[0, n] = cn * sign * even
        c.rates[1, n] = sn * sign * odd
        c.rates[2, n] = dn * even
        c.rates[3, n] = odd
