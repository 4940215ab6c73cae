"""Brightness of a Lommel-Seeliger ellipsoid in closed form, compiled.

Muinonen & Lumme, A&A 584, A23, 2015, eq. 12, rewritten without cancellation.  With p = s/a and
q = o/a by components, P = |p|, Q = |q|, S = P + Q, x = |p + q|/S and y = 1 - x^2,

    integral of mu0 mu / (mu0 + mu) dA = (pi a b c / 4) (m / S) G(x),
    m = 2 (P Q + p.q),    y = 2 (P Q - p.q) / S^2,    G = (x - y atanh x) / x^3,

where G falls from 1 (opposition of a sphere) to 2/3 (backlit), and m falls to 0.  Backlit, p and q
are nearly opposite: p + q is then computed as (s + o)/a, where s + o is exact, and m as
2 |p x (p + q)|^2 / (P Q - p.q).  Below x = 1/3 the closed form of G loses digits; there
G = 1 - y R, atanh x = x + x^3 R.

Measured against 60 digits: 6.8e-15 at worst, for axes up to 10 : 2 : 1 and phase angles from 0 to
pi - 1e-8.  Compiled without fastmath, which would reorder sums.
"""

import math

from attitude.compilation.decorators import quickly_compiled, reduction_inlined
from attitude.compilation.instructions import as_bits, from_bits

_LN2 = 0.6931471805599453
# The difference of the bits of two doubles, over 2^52, is the binary logarithm of their ratio
# within 0.086.  With this added, its whole part is at least 1 for ratios from 2 (x = 1/3) on, and
# leaves a ratio from 0.88 to 2, |f| <= 1/3.
_ROUNDING = 0x1620000000000
_R0, _R1, _R2 = 0.3333333333333333, 0.1999999999999975, 0.14285714285803394
_R3, _R4, _R5 = 0.11111111098732392, 0.09090909971595426, 0.07692271221627803
_R6, _R7, _R8 = 0.06667604894870639, 0.05866942116729435, 0.054241007161985766
_R9, _R10 = 0.037396652525503456, 0.07826828806597469
# The bits of sqrt(1/2), and the mask of sign and exponent.
_ROOT = 0x3FE6A09E667F3BCD
_EXPONENT = -0x10000000000000


@quickly_compiled
def ellipsoid(a, b, c, factor, sx, sy, sz, ox, oy, oz, out):
    """factor times the integral (m2) for each epoch, into out (N,).

    a, b, c are the semi-axes (m); the unit vectors s and o come as components (N,).  A branch or a
    call in the loop would keep it from being vectorised: `intensity` is copied into it.
    """
    ia, ib, ic = 1.0 / a, 1.0 / b, 1.0 / c
    scale = 0.25 * math.pi * a * b * c * factor
    for t in range(out.size):
        out[t] = intensity(ia, ib, ic, scale, sx[t], sy[t], sz[t], ox[t], oy[t], oz[t])


@reduction_inlined
def intensity(ia, ib, ic, scale, sx, sy, sz, ox, oy, oz):
    """The integral for one pair of unit vectors, times a factor.

    ia, ib, ic are the reciprocals of the semi-axes; scale is pi a b c / 4 times the factor.
    The result is scale (m / S) G with x = d / S and y = `shade` / S^2, as one fraction.
    """
    px, py, pz = sx * ia, sy * ib, sz * ic
    qx, qy, qz = ox * ia, oy * ib, oz * ic
    dx, dy, dz = (sx + ox) * ia, (sy + oy) * ib, (sz + oz) * ic
    p = math.sqrt(px * px + py * py + pz * pz)
    q = math.sqrt(qx * qx + qy * qy + qz * qz)
    square = dx * dx + dy * dy + dz * dz
    d, s = math.sqrt(square), p + q
    both, dot = p * q, px * qx + py * qy + pz * qz
    apart = both - dot
    vx, vy, vz = py * dz - pz * dy, pz * dx - px * dz, px * dy - py * dx
    cross = vx * vx + vy * vy + vz * vz
    m, below = (both + dot if dot > 0.0 else cross), (1.0 if dot > 0.0 else apart)
    whole = s * s
    shade = max(2.0 * apart, 1e-250 * whole)
    near = 9.0 * square < whole
    # atanh x = k log(2) / 2 + atanh f, since exp(2 atanh x) = (S + d)^2 / (S^2 - d^2).
    top = (s + d) * (s + d)
    k = (as_bits(top) - as_bits(shade) + _ROUNDING) >> 52
    top = from_bits(as_bits(top) - (k << 52))
    f = (d if near else top - shade) / (s if near else top + shade)
    u = f * f
    r = _cubes(u)
    atanh = (0.5 * _LN2) * float(k) + (f + f * u * r)
    # Near, f is x, and G is 1 - y R without the cancellation of the closed form.
    a = whole - shade * r if near else d * s - shade * atanh
    b = whole * s if near else d * square
    return scale * 2.0 * m * a / (below * b)


@reduction_inlined
def _cubes(u):
    """R with atanh f = f + f^3 R(f^2), for u = f^2 up to 1/9.

    Polynomial of least maximum error; with these coefficients 2e-17.  Two chains of half the
    length take half the time of one.
    """
    v = u * u
    even = ((((_R10 * v + _R8) * v + _R6) * v + _R4) * v + _R2) * v + _R0
    odd = (((_R9 * v + _R7) * v + _R5) * v + _R3) * v + _R1
    return even + u * odd


@reduction_inlined
def logarithm(r):
    """Natural logarithm of a positive normal number, with an absolute or relative error of 2e-16.

    A call of math.log would keep the loop from being vectorised.  r = 2^k z with z from 1/sqrt(2)
    to sqrt(2), and log z = 2 atanh((z - 1)/(z + 1)) by 11 terms.
    """
    bits = as_bits(r)
    k = (bits - _ROOT) >> 52
    z = from_bits(bits - ((bits - _ROOT) & _EXPONENT))
    f = (z - 1.0) / (z + 1.0)
    u = f * f
    s = 1.0 / 21.0
    s = s * u + 1.0 / 19.0
    s = s * u + 1.0 / 17.0
    s = s * u + 1.0 / 15.0
    s = s * u + 1.0 / 13.0
    s = s * u + 1.0 / 11.0
    s = s * u + 1.0 / 9.0
    s = s * u + 1.0 / 7.0
    s = s * u + 1.0 / 5.0
    s = s * u + 1.0 / 3.0
    return float(k) * _LN2 + (2.0 * f + 2.0 * f * u * s)
