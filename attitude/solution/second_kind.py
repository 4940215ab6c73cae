"""Integrals of the second kind, which the derivatives of the solution need."""

import math

from attitude.compilation.decorators import subroutine

# Duplication of R_D ends where the arguments agree to this: the remainder is below 3e-17.
_CLOSE = 0.0025


@subroutine
def integrals(m, mc):
    """K and D = (K - E)/m of a parameter 0 <= m < 1; B = K - D and E = B + mc D follow.

    K = (pi/2)/M and D = K (1/2 + sum 2^(n-1) c_n^2 / m) with the c_n of the AGM of 1 and sqrt(mc),
    the first two so that nothing is 0/0 for m = 0.
    """
    root = math.sqrt(mc)
    a, b = 0.5 * (1.0 + root), math.sqrt(root)
    # c_1 = m / (2 (1 + root)), c_2 = (a - b)/2 = c_1^2 / (4 a_2)
    over = 0.5 / (1.0 + root)
    total = 0.5 + m * over * over
    c = m * over
    weight = 1.0
    for _ in range(8):
        a, b = 0.5 * (a + b), math.sqrt(a * b)
        weight *= 2.0
        share = weight * c * c * over / (16.0 * a * a) * c
        c = c * c / (4.0 * a)
        total += share if weight == 2.0 else weight * c * c / m
        if weight * c < 1e-20:
            break
    k = 0.5 * math.pi / a
    return k, k * total


@subroutine
def third_kind_degenerate(x, y, z):
    """Carlson's R_D(x, y, z) for x, y >= 0, z > 0, at most one of x, y zero; to 5e-16.

    Source: Carlson, Numer. Algorithms 10, 13 (1995), with the series of DLMF 19.36.2.
    """
    total, weight = 0.0, 1.0
    a = 0.2 * (x + y + 3.0 * z)
    x0, y0 = a - x, a - y
    for _ in range(12):
        if weight * max(abs(x0), abs(y0)) < _CLOSE * a:
            break
        rx, ry, rz = math.sqrt(x), math.sqrt(y), math.sqrt(z)
        shift = rx * (ry + rz) + ry * rz
        total += weight / (rz * (z + shift))
        weight *= 0.25
        x, y, z = 0.25 * (x + shift), 0.25 * (y + shift), 0.25 * (z + shift)
        a = 0.25 * (a + shift)
    x, y = weight * x0 / a, weight * y0 / a
    z = -(x + y) / 3.0
    xy, zz = x * y, z * z
    e2, e3, e4, e5 = xy - 6.0 * zz, (3.0 * xy - 8.0 * zz) * z, 3.0 * (xy - zz) * zz, xy * zz * z
    series = 1.0 - 3.0 * e2 / 14.0 + e3 / 6.0 + 9.0 * e2 * e2 / 88.0 - 3.0 * e4 / 22.0
    series += -9.0 * e2 * e3 / 52.0 + 3.0 * e5 / 26.0
    return weight * series / (a * math.sqrt(a)) + 3.0 * total


@subroutine
def by_parameter(cosine, sine, square):
    """dF/dm of the amplitude with this cosine and sine, 1 - m sine^2 being given: s^3 R_D / 6."""
    return sine * sine * sine / 6.0 * third_kind_degenerate(cosine * cosine, 1.0, square)
