"""Coefficients of the series: what the kernels evaluate at each phase, made once a motion."""

import math

import numpy as np

from attitude.solution.machine import inlined

# Coefficients in c = cos 2v, by row n: T_n of cos 2nv; the second kind of sin 2nv / sin 2v;
# the fourth and third kinds of sin (2n+1)v / sin v and cos (2n+1)v / cos v.
COS_EVEN = np.array(
    [[1, 0, 0, 0, 0], [0, 1, 0, 0, 0], [-1, 0, 2, 0, 0], [0, -3, 0, 4, 0], [1, 0, -8, 0, 8]], float
)
SIN_EVEN = np.array([[0, 0, 0, 0], [1, 0, 0, 0], [0, 2, 0, 0], [-1, 0, 4, 0]], float)
SIN_ODD = np.array(
    [[1, 0, 0, 0, 0], [1, 2, 0, 0, 0], [-1, 2, 4, 0, 0], [-1, -4, 4, 8, 0], [1, -4, -12, 8, 16]],
    float,
)
COS_ODD = np.array(
    [[1, 0, 0, 0, 0], [-1, 2, 0, 0, 0], [-1, -2, 4, 0, 0], [1, -4, -4, 8, 0], [1, 4, -12, -8, 16]],
    float,
)


@inlined
def trigonometric_series(stretch, fraction, root, wobble, c):
    """Series of alpha and beta, nome Q.

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
            c.alpha[0, k] += even * COS_EVEN[n, k]
            c.alpha[1, k] += odd * SIN_EVEN[n, k]
            c.beta[0, k] -= odd_sum * SIN_ODD[n, k]
            c.beta[1, k] -= odd_difference * COS_ODD[n, k]
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


@inlined
def hyperbolic_series(nome, fraction, wobble, c):
    """Series of alpha and beta after the modular transformation: nome Q'."""
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
