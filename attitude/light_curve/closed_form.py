"""Brightness of a Lommel-Seeliger ellipsoid in closed form, compiled.

Muinonen & Lumme, A&A 584, A23, 2015, eq. 12, rewritten without cancellation.  With p = s/a and
q = o/a by components, P = |p|, Q = |q|, S = P + Q, x = |p + q|/S and y = 1 - x^2,

    integral of mu0 mu / (mu0 + mu) dA = (pi a b c / 4) (m / S) G(x),
    m = 2 (P Q + p.q),    y = 2 (P Q - p.q) / S^2,    G = (x - y atanh x) / x^3,

where G falls from 1 (opposition of a sphere) to 2/3 (backlit), and m falls to 0.  Backlit, p and q
are nearly opposite: p + q is then computed as (s + o)/a, where s + o is exact, and m as
2 |p x (p + q)|^2 / (P Q - p.q).

Measured against 60 digits: 1.2e-14 at worst, for axes up to 10 : 2 : 1 and phase angles from 0 to
pi - 1e-8.  Compiled without fastmath, which would reorder sums.
"""

import math

from attitude.compilation.decorators import reduction_inlined, sized_entry_point
from attitude.compilation.instructions import as_bits, from_bits

_LN2 = 0.6931471805599453
# The bits of sqrt(1/2), and the mask of sign and exponent.
_ROOT = 0x3FE6A09E667F3BCD
_EXPONENT = -0x10000000000000


@sized_entry_point
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
    """
    px, py, pz = sx * ia, sy * ib, sz * ic
    qx, qy, qz = ox * ia, oy * ib, oz * ic
    dx, dy, dz = (sx + ox) * ia, (sy + oy) * ib, (sz + oz) * ic
    p = math.sqrt(px * px + py * py + pz * pz)
    q = math.sqrt(qx * qx + qy * qy + qz * qz)
    both = p * q
    dot = px * qx + py * qy + pz * qz
    vx, vy, vz = py * dz - pz * dy, pz * dx - px * dz, px * dy - py * dx
    apart = both - dot
    cross = vx * vx + vy * vy + vz * vz
    # The second form applies where apart >= P Q; the bound avoids a division by 0 elsewhere.
    m = both + dot if dot > 0.0 else cross / max(apart, both)
    inverse = 1.0 / (p + q)
    square = (dx * dx + dy * dy + dz * dz) * inverse * inverse
    y = max(2.0 * apart * inverse * inverse, 1e-290)
    return scale * 2.0 * m * inverse * _dimming(square, y)


@reduction_inlined
def _dimming(square, y):
    """G from x^2 and 1 - x^2: a series below x = 1/4, where the closed form loses digits.

    At x = 1/4 both have errors below 1e-14, so the step of G is as small.
    """
    x = math.sqrt(square)
    near = square if square < 0.0625 else 0.0625
    far = x if x > 0.25 else 0.25
    atanh = 0.5 * logarithm((1.0 + far) * (1.0 + far) / y)
    closed = (far - y * atanh) / (far * far * far)
    return _series(near) if square < 0.0625 else closed


@reduction_inlined
def _series(u):
    """Sum of 2 u^(k-1) / (4 k^2 - 1) from k = 1: 12 terms leave 2e-17 at u = 1/16."""
    s = 2.0 / 575.0
    s = s * u + 2.0 / 483.0
    s = s * u + 2.0 / 399.0
    s = s * u + 2.0 / 323.0
    s = s * u + 2.0 / 255.0
    s = s * u + 2.0 / 195.0
    s = s * u + 2.0 / 143.0
    s = s * u + 2.0 / 99.0
    s = s * u + 2.0 / 63.0
    s = s * u + 2.0 / 35.0
    s = s * u + 2.0 / 15.0
    return s * u + 2.0 / 3.0


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
