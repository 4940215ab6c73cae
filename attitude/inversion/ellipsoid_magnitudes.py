"""Magnitudes of a rotating ellipsoid in closed form, with all derivatives, compiled.

The brightness of `attitude.light_curve.closed_form` as a function of the three products of the
directions of Sun and observer with the matrix of the ellipsoid, P^2, Q^2 and p.q.
"""

from __future__ import annotations

import math

from attitude.compilation.decorators import reduction, reduction_inlined
from attitude.inversion import normal_form_series as series
from attitude.light_curve.closed_form import logarithm

# Columns of the Jacobian: rotation vector (3), precession, nutation, phase (turns), ln rho, X, and
# two logarithms of squared ratios of axes.
PARAMETERS = 10
_MAGNITUDE = -2.5 / math.log(10.0)
_TURN = 2.0 * math.pi


@reduction_inlined
def _turned(x, y, z, m0, m1, m2, m3, m4, m5, m6, m7, m8):
    """The components of a vector along the columns of a matrix, which is given by rows."""
    return m0 * x + m3 * y + m6 * z, m1 * x + m4 * y + m7 * z, m2 * x + m5 * y + m8 * z


@reduction_inlined
def _over_body(v, r, i, c0, c1, c2, c3, c4, c5, c6, c7, c8):
    """Direction i of v (3, N) over the axes of the body: turned by c, then by r (9, N)."""
    x, y, z = _turned(v[0, i], v[1, i], v[2, i], c0, c1, c2, c3, c4, c5, c6, c7, c8)
    r0, r1, r2, r3, r4, r5 = r[0, i], r[1, i], r[2, i], r[3, i], r[4, i], r[5, i]
    return _turned(x, y, z, r0, r1, r2, r3, r4, r5, r[6, i], r[7, i], r[8, i])


@reduction_inlined
def _products(sa, sb, sc, oa, ob, oc, fa, fb, fc):
    """P^2, Q^2 and p.q of two directions over the axes of the body, with 1/axes^2."""
    pp = fa * sa * sa + fb * sb * sb + fc * sc * sc
    qq = fa * oa * oa + fb * ob * ob + fc * oc * oc
    return pp, qq, fa * sa * oa + fb * sb * ob + fc * sc * oc


@reduction
def magnitudes(e, c, k, flat, t, sun, observer, r, out):
    """Magnitudes (N,) of elements e (5,), orientation c (9,) and 1/axes^2 flat (3,).

    k (4, 4, 2) and r (9, N) are memory for the series and for the attitudes; sun and observer are
    unit vectors by components (3, N).
    """
    series.coefficients(math.exp(e[3]), e[4], k)
    series.attitudes(e[0], e[1], e[2], k, t, r)
    c0, c1, c2, c3, c4, c5, c6, c7, c8 = c[0], c[1], c[2], c[3], c[4], c[5], c[6], c[7], c[8]
    fa, fb, fc = flat[0], flat[1], flat[2]
    for i in range(t.size):
        sa, sb, sc = _over_body(sun, r, i, c0, c1, c2, c3, c4, c5, c6, c7, c8)
        oa, ob, oc = _over_body(observer, r, i, c0, c1, c2, c3, c4, c5, c6, c7, c8)
        pp, qq, pq = _products(sa, sb, sc, oa, ob, oc, fa, fb, fc)
        p, q = math.sqrt(pp), math.sqrt(qq)
        m = max(p * q + pq, 1e-12)
        total = p + q
        u = (pp + qq + 2.0 * pq) / (total * total)
        y = max(1.0 - u, 1e-15)
        out[i] = _MAGNITUDE * logarithm(m / total * _dimming(u, y)[0])


@reduction_inlined
def _dimming(u, y):
    """G and its derivative by u, y = 1 - u; see `light_curve.closed_form`."""
    near = u if u < 0.0625 else 0.0625
    x = math.sqrt(u if u > 0.0625 else 0.0625)
    atanh = 0.5 * logarithm((1.0 + x) * (1.0 + x) / y)
    closed = (x - y * atanh) / (x * x * x)
    slope = atanh / (x * x * x) - 1.5 * closed / (x * x)
    s = near
    g = 0.6666666666666666 + s * (
        0.13333333333333333
        + s
        * (
            0.05714285714285714
            + s
            * (
                0.031746031746031744
                + s * (0.020202020202020204 + s * (0.013986013986013986 + s * 0.010256410256410256))
            )
        )
    )
    d = 0.13333333333333333 + s * (
        0.11428571428571428
        + s
        * (
            0.09523809523809523
            + s * (0.08080808080808081 + s * (0.06993006993006994 + s * 0.06153846153846154))
        )
    )
    return (g, d) if u < 0.0625 else (closed, slope)


@reduction
def with_derivatives(e, c, k, flat, t, sun, observer, r, g, out, jacobian):
    """As `magnitudes`, with the Jacobian (10, N); g (9, N) is memory for the tangents."""
    series.coefficients(math.exp(e[3]), e[4], k)
    series.attitudes(e[0], e[1], e[2], k, t, r)
    series.tangents(e[0], e[1], e[2], k, t, g)
    c0, c1, c2, c3, c4, c5, c6, c7, c8 = c[0], c[1], c[2], c[3], c[4], c[5], c[6], c[7], c[8]
    fa, fb, fc = flat[0], flat[1], flat[2]
    for i in range(t.size):
        sa, sb, sc = _over_body(sun, r, i, c0, c1, c2, c3, c4, c5, c6, c7, c8)
        oa, ob, oc = _over_body(observer, r, i, c0, c1, c2, c3, c4, c5, c6, c7, c8)
        pp, qq, pq = _products(sa, sb, sc, oa, ob, oc, fa, fb, fc)
        p, q = math.sqrt(pp), math.sqrt(qq)
        m = max(p * q + pq, 1e-12)
        total = p + q
        over = 1.0 / total
        u = (pp + qq + 2.0 * pq) * over * over
        y = max(1.0 - u, 1e-15)
        value, slope = _dimming(u, y)
        out[i] = _MAGNITUDE * logarithm(m * over * value)
        slope = _MAGNITUDE * slope / value * over * over
        in_m, in_total = _MAGNITUDE / m, -_MAGNITUDE * over - 2.0 * slope * u * total
        by_p, by_q = in_m * q + in_total, in_m * p + in_total
        by_pp, by_qq = 0.5 * by_p / p + slope, 0.5 * by_q / q + slope
        by_pq = in_m + 2.0 * slope
        # by the vectors s and o over body axes
        va, wa = 2.0 * by_pp * sa + by_pq * oa, 2.0 * by_qq * oa + by_pq * sa
        vb, wb = 2.0 * by_pp * sb + by_pq * ob, 2.0 * by_qq * ob + by_pq * sb
        vc, wc = 2.0 * by_pp * sc + by_pq * oc, 2.0 * by_qq * oc + by_pq * sc
        jacobian[8, i] = 0.5 * fa * (va * sa + wa * oa)
        jacobian[9, i] = 0.5 * fb * (vb * sb + wb * ob)
        va, vb, vc, wa, wb, wc = va * fa, vb * fb, vc * fc, wa * fa, wb * fb, wc * fc
        # their cross products with s and o over body axes, summed
        jacobian[0, i] = vb * sc - vc * sb + wb * oc - wc * ob
        jacobian[1, i] = vc * sa - va * sc + wc * oa - wa * oc
        jacobian[2, i] = va * sb - vb * sa + wa * ob - wb * oa
    for i in range(t.size):
        x, y, z = jacobian[0, i], jacobian[1, i], jacobian[2, i]
        jacobian[0, i] = r[0, i] * x + r[1, i] * y + r[2, i] * z
        jacobian[1, i] = r[3, i] * x + r[4, i] * y + r[5, i] * z
        jacobian[2, i] = r[6, i] * x + r[7, i] * y + r[8, i] * z
    for i in range(t.size):
        h0, h1, h2 = jacobian[0, i], jacobian[1, i], jacobian[2, i]
        jacobian[3, i] = 2.0 * _TURN * t[i] * h2
        v = _TURN * (h0 * g[0, i] + h1 * g[1, i] + h2 * g[2, i])
        jacobian[4, i], jacobian[5, i] = t[i] * v, v
        jacobian[6, i] = h0 * g[3, i] + h1 * g[4, i] + h2 * g[5, i]
        jacobian[7, i] = h0 * g[6, i] + h1 * g[7, i] + h2 * g[8, i]
