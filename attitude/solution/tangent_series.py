"""Series of the changes of attitude with nutation phase, amplitude and ellipticity.

The pair of docs/derivation.md is A = theta4(w | Q), b = -theta1(w | Q) with exp(2 i w) = X E^2,
E = exp(i v) and Q = s X^2 = q^2, s = rho^4.  By the heat equation its derivatives at constant v are
those by w,

    d/dv = D,      d/d ln rho = -D^2,      d/dX = -(D^2 + i D) / (2X),

so A b' - b A' takes the three forms V, -V' and -(V' + i V) / (2X) of the Wronskian

    V = -theta4(0 | Q)^2 theta2(w | Q) theta3(w | Q)
      = -theta4(0 | Q)^2 theta2(0 | q) theta2(w | q) / 2

and, with N = |A|^2 + |b|^2 = theta4(v | q) theta3(i delta | q) and X = exp(-2 delta), the part
2 Im(A' conj A + b' conj b) / N along the momentum is

    u,      -u X T,      -(u + 1) T / 2,      X T = theta4'(v | q) / theta4(v | q),

u the constant Im theta3'(i delta | q) / theta3(i delta | q).  Every term is a product of numbers of
at most 1, as q^(n^2 + n) X^-n = s^(n (n+1) / 2) X^(n^2).

After the modular transformation, with W = y + i d and nome Q', the pair is

    A = sum Q'^(n^2+n) cosh (2n+1) W,      b = - sum (-1)^n Q'^(n^2+n) sinh (2n+1) W

but for a real factor, and with D by W,  d/dy = D,  d/dd = i D,  Q' d/dQ' = D^2 / 4:

    V = -(sum Q'^(n^2+n))^2 theta4(0 | Q'^2) theta4(2 i W | Q'^2)
    N = theta3(2 d | Q'^2) sum Q'^(2n^2+2n) cosh (4n+2) y

and along the momentum u, 2 R and u R / 2, with u = -2 theta3'(2 d | Q'^2) / theta3(2 d | Q'^2) and
R the quotient of sum (2n+1) Q'^(2n^2+2n) sinh (4n+2) y and the sum in N.
"""

import math

from attitude.compilation.decorators import subroutine
from attitude.solution import codes
from attitude.solution.coefficients import COS_EVEN, COS_ODD, SIN_EVEN, SIN_ODD
from attitude.solution.derivatives import ellipticity, state_of
from attitude.solution.second_kind import integrals
from attitude.solution.tangent_record import COLUMNS, NOME


@subroutine
def fill_trigonometric(c, series, upright):
    """Fill eight series in cos 2v and three factors along the momentum.

    Filled
        series   over theta4(v | q), which is the first: T without its factor sin 2v; then x and y
                 of the vectors by v, ln rho and X, without their factors cos v, sin v of the first
                 and sin v, cos v of the others
        upright  z of the first vector, and what T is multiplied by in the others
    """
    x, one_minus_x, rho, s = ellipticity(c)
    nome, square = s * x * x, rho * rho
    at_zero = 1.0 - 2.0 * nome * (1.0 - nome**3 * (1.0 - nome**5))
    product = 1.0 + nome * (1.0 + nome * nome * (1.0 + nome**3 * (1.0 + nome**4)))
    # theta3(i delta | q), its derivative, and their sum: term = rho^(2k^2) X^(k^2-k)
    norm, slope, both = 1.0, 0.0, 1.0
    term, step, even, loss = square, s * square, x * x, one_minus_x * (1.0 + x)
    for k in range(1, 7):
        norm += term * (1.0 + even)
        slope += k * term * loss
        both += term * (1.0 + even - 2.0 * k * loss)
        term *= step * even
        step *= s
        loss += even * (1.0 + x) * one_minus_x
        even *= x * x
    upright[0], upright[1], upright[2] = (
        -2.0 * slope / norm,
        2.0 * x * slope / norm,
        -0.5 * both / norm,
    )
    # theta4(v | q) and T: term = (-1)^k rho^(2k^2) X^(k^2-1)
    series[0, 0] = 1.0
    term, step, odd = -square, s * square, x
    for k in range(1, 5):
        for j in range(5):
            series[0, j] += 2.0 * term * x * COS_EVEN[k, j]
            series[1, j] -= 4.0 * k * term * SIN_EVEN[k, j]
        odd *= x * x
        term *= -step * odd
        step *= s
    # term = s^(n (n+1) / 2) X^(n^2), lower = term / X
    term, lower, step = 2.0 * rho * at_zero * at_zero * product / norm, 0.0, s
    even, loss = 1.0, one_minus_x
    for n in range(5):
        k, odd = 2.0 * n + 1.0, even * x
        less, more = n * lower, (n + 1.0) * term * even
        for j in range(5):
            cosine, sine = COS_ODD[n, j], SIN_ODD[n, j]
            series[2, j] -= term * (1.0 + odd) * cosine
            series[3, j] += term * loss * sine
            series[4, j] -= k * term * (1.0 + odd) * sine
            series[5, j] -= k * term * loss * cosine
            series[6, j] -= (more + less) * sine
            series[7, j] += (more - less) * cosine
        lower = term * step * even
        term = lower * x
        step *= s
        loss += odd * (1.0 + x) * one_minus_x
        even *= x * x


@subroutine
def fill_hyperbolic(c, d, series, upright):
    """Fill seven series in F^2 and G^2 and two factors along the momentum.

    Filled
        series   the sum in N and, first and last, that over it in 2 R -+ 2; real and imaginary
                 parts of V by N E, and of V' / 4 by N and by F/E or G E^3.  F and G as in
                 `solution.series`
        upright  z of the first vector, and what 2 R is multiplied by in the third
    """
    nome, square = d.nome, d.nome * d.nome
    series[0, 0], series[0, 1], series[0, 2] = 1.0, square, square**4
    series[1, 1], series[1, 2] = 4.0 * square, 8.0 * square**4
    series[6, 0], series[6, 1], series[6, 2] = 4.0, 8.0 * square, 12.0 * square**4
    # theta3(2 d | Q'^2), and the sum of its derivative over Q'^2
    angle = math.pi * c.fraction
    norm, slope, power = 1.0, 0.0, 1.0
    for k in range(1, 4):
        norm += 2.0 * square * power * math.cos(k * angle)
        slope += k * power * math.sin(k * angle)
        power *= square ** (2 * k + 1)
    winds = c.winds != 0.0  # on the exact separatrix Q'^2 is the element
    upright[0] = 8.0 * square * slope / norm
    upright[2] = (2.0 * nome if winds else 1.0) * slope / norm
    whole = 1.0 + square * (1.0 + square * square)
    size = -4.0 * whole * whole * (1.0 - 2.0 * square * (1.0 - square**3)) / norm
    series[2, 0] = size
    for k in range(1, 4):
        size *= -(square ** (2 * (k - 1)))
        cosine, sine = size * math.cos(k * angle), size * math.sin(k * angle)
        series[2, k], series[3, k - 1] = cosine, sine
        share = k if winds else 0.5 * k
        series[4, k - 1], series[5, k - 1] = share * cosine, share * sine


@subroutine
def fill_rates(c, d):
    """Fill what the derivatives of the angular velocity need (solution.tangent_record).

    The factors of the series of cn, sn and dn depend on their nome as the amplitudes do: their
    changes are added to those of the amplitudes.
    """
    (i1, i2, i3), _w, (d12, d23, d13), _a, _side, _size, speed, (m, mc) = state_of(c)
    near = c.form == codes.HYPERBOLIC
    # v' or y', the phase by time, without its sense
    if near:
        by_time = speed * 0.25 * math.pi / integrals(mc, m)[0]
    else:
        by_time = speed * 0.5 * math.pi / integrals(m, mc)[0]
    over = math.ldexp(1.0 / by_time, -c.tempo)
    d.by_phase[0], d.by_phase[1] = over * d23 / i1, -over * d13 / i2
    d.by_phase[2] = over * d12 / i3
    q = d.nome * d.nome if near else math.sqrt(c.nome)
    # theta2 / (2 q^(1/4)), theta3, theta4 and their derivatives
    two = 1.0 + q**2 + q**6 + q**12 + q**20
    two_slope = q * (2.0 + 6.0 * q**4 + 12.0 * q**10 + 20.0 * q**18)
    odd, even = q * (1.0 + q**8), q**4 * (1.0 + q**12)
    odd_slope, even_slope = 1.0 + 9.0 * q**8, q**3 * (4.0 + 16.0 * q**12)
    three, fourth = 1.0 + 2.0 * (even + odd), 1.0 + 2.0 * (even - odd)
    low2, low3 = two_slope / two, 2.0 * (even_slope + odd_slope) / three
    low4 = 2.0 * (even_slope - odd_slope) / fourth
    for j in range(COLUMNS):
        change = d.weights[NOME, j]
        d.amplitudes[0, j] += (low4 - low2 if not near else low2 - low4) * change
        d.amplitudes[1, j] += (low3 - low2 if not near else low3 - low4) * change
        d.amplitudes[2, j] += (low4 - low3 if not near else low2 - low3) * change
    if near:
        return
    factors = (
        c.amplitudes[0] * fourth / two,
        -c.amplitudes[1] * three / two,
        c.amplitudes[2] * fourth / three,
    )
    sign = -1.0
    for n in range(1, 5):
        # 2 n^2 q^(n^2-1) and n (n+1) q^(n^2+n-1)
        even, odd = 2.0 * n * n * q ** (n * n - 1), n * (n + 1.0) * q ** (n * n + n - 1)
        for k in range(5):
            d.by_nome[0, k] += factors[0] * odd * COS_ODD[n, k]
            d.by_nome[1, k] += factors[1] * sign * odd * SIN_ODD[n, k]
            d.by_nome[2, k] += factors[2] * even * COS_EVEN[n, k]
            d.by_nome[3, k] += sign * even * COS_EVEN[n, k]
        sign = -sign
