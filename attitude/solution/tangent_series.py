"""Series of the derivatives of the pair by nutation phase, amplitude and ellipticity.

The pair of docs/derivation.md, with s = rho^4 and E = exp(i v),

    A = 1 + sum (-1)^n s^(n^2) (X^(2n^2+n) E^(2n) + X^(2n^2-n) E^-(2n)),                    n >= 1
    b = -i rho sum (-1)^n s^(n^2+n) (X^(2n^2+n) E^-(2n+1) - X^(2n^2+3n+1) E^(2n+1)),        n >= 0

is a polynomial in rho and X, every derivative a series in the same sine and cosine.  After the
modular transformation, with W = y + i d,

    A = sum Q'^(n^2+n) cosh (2n+1) W,      b = - sum (-1)^n Q'^(n^2+n) sinh (2n+1) W
"""

import math

from attitude.compilation.decorators import subroutine
from attitude.solution.coefficients import COS_EVEN, COS_ODD, SIN_EVEN, SIN_ODD
from attitude.solution.derivatives import ellipticity, powers


@subroutine
def fill_trigonometric(c, series):
    """Fill the derivatives of the pair by v, ln rho and X: three times four rows.

    Coefficients in cos 2v, as `solution.series.trigonometric_pair` takes them; those by v multiply
    sin 2v, 1, cos v and sin v in place of 1, sin 2v, sin v and cos v.
    """
    x, one_minus_x, rho, s = ellipticity(c)
    outer, inner, powers_of_x = powers(x, s)
    by_v, by_rho, by_x = series[0], series[1], series[2]
    sign, even_loss, odd_loss = 1.0, 0.0, one_minus_x
    for n in range(4):
        r, y, even = (0.0, 0.0, 1.0) if n == 0 else (outer[n - 1], inner[n - 1], powers_of_x[n - 1])
        whole = 1.0 if n == 0 else y * x
        # terms of A: cosine and sine of 2nv
        cosine, sine = sign * r * x * (1.0 + even), -sign * r * x * even_loss
        one, two = r * n * (2.0 * n - 1.0), r * n * (2.0 * n + 1.0) * even
        for j in range(4):
            by_v[0, j] -= 2.0 * n * cosine * SIN_EVEN[n, j]
            by_v[1, j] += 2.0 * n * sine * COS_EVEN[n, j]
            by_rho[0, j] += 4.0 * n * n * cosine * COS_EVEN[n, j]
            by_rho[1, j] += 4.0 * n * n * sine * SIN_EVEN[n, j]
            by_x[0, j] += sign * (two + one) * COS_EVEN[n, j]
            by_x[1, j] += sign * (two - one) * SIN_EVEN[n, j]
        # terms of b: sine and cosine of (2n+1)v
        k, weight = 2.0 * n + 1.0, 1.0 + 4.0 * n * (n + 1.0)
        sine, cosine = -rho * sign * whole * (1.0 + even * x), -rho * sign * whole * odd_loss
        one, two = y * n * k, k * (n + 1.0) * whole * even
        for j in range(4):
            by_v[2, j] += k * sine * COS_ODD[n, j]
            by_v[3, j] -= k * cosine * SIN_ODD[n, j]
            by_rho[2, j] += weight * sine * SIN_ODD[n, j]
            by_rho[3, j] += weight * cosine * COS_ODD[n, j]
            by_x[2, j] -= rho * sign * (one + two) * SIN_ODD[n, j]
            by_x[3, j] -= rho * sign * (one - two) * COS_ODD[n, j]
        even_loss += even * (1.0 + x) * one_minus_x
        odd_loss += even * x * (1.0 + x) * one_minus_x
        sign = -sign


@subroutine
def fill_hyperbolic(c, series):
    """Fill cosines and sines of the derivatives of the pair by y, and by Q': two times two rows."""
    for n in range(4):
        over = 0.0
        if n > 0:  # Q'^(n^2 - 1) for Q'^(n^2)
            over = n * (n + 1.0) * c.nome ** (n * n - 1)
            if c.winds == 0.0:  # by Q'^2 at Q' = 0
                over = 1.0 if n == 1 else 0.0
        angle = (2 * n + 1) * 0.25 * math.pi * c.fraction
        for row in range(2):
            series[0, row, n] = (2.0 * n + 1.0) * c.alpha[row, n]
        series[1, 0, n] = over * math.cos(angle)
        series[1, 1, n] = over * math.sin(angle)
