"""Attitudes of a free rotation from its five elements, and their derivatives, for many epochs.

The series of docs/derivation.md (section 15) with four terms, over epochs as the inner loop so that
it is vectorised.  Elements here are per unit of time of the epochs: precession and nutation in
turns (lambda / 2 pi, f), the phase in turns, ln rho, X.
"""

from __future__ import annotations

import math

from attitude.compilation.decorators import reduction, reduction_inlined
from attitude.compilation.instructions import rint
from attitude.solution.phases import sincos

# Terms of each series beside the first of A; the coefficients of one are (function, by X).
TERMS = 4


@reduction
def coefficients(rho, x, k):
    """Sums and differences of the coefficients of E^n and E^-n, into k (4, 4, 2).

    Rows of k: A's sums and differences, b's sums and differences (b without its factor -i); the
    last axis holds the coefficient and its derivative by X.
    """
    s = rho**4
    sign = 1.0
    for n in range(TERMS):
        k1, k2, k3 = 2 * n * n + n, 2 * n * n - n, 2 * n * n + 3 * n + 1
        c, d = sign * s ** (n * n), sign * rho * s ** (n * n + n)
        if n > 0:
            up, down = c * x**k1, c * x**k2
            by_up, by_down = c * k1 * x ** (k1 - 1), c * k2 * x ** (k2 - 1)
            k[0, n, 0], k[1, n, 0] = up + down, up - down
            k[0, n, 1], k[1, n, 1] = by_up + by_down, by_up - by_down
            by_down = d * k1 * x ** (k1 - 1)
        else:
            k[0, 0, 0], k[1, 0, 0], k[0, 0, 1], k[1, 0, 1] = 1.0, 0.0, 0.0, 0.0
            by_down = 0.0
        down, up, by_up = d * x**k1, -d * x**k3, -d * k3 * x ** (k3 - 1)
        k[2, n, 0], k[3, n, 0] = down + up, up - down
        k[2, n, 1], k[3, n, 1] = by_down + by_up, by_up - by_down
        sign = -sign


@reduction_inlined
def _multiples(v):
    """Cosine and sine of one to seven times an angle in turns."""
    s1, c1 = sincos(v - rint(v), 0.0)
    c2, s2 = c1 * c1 - s1 * s1, 2.0 * c1 * s1
    c3, s3 = c1 * c2 - s1 * s2, s1 * c2 + c1 * s2
    c4, s4 = c2 * c2 - s2 * s2, 2.0 * c2 * s2
    c5, s5 = c1 * c4 - s1 * s4, s1 * c4 + c1 * s4
    c6, s6 = c2 * c4 - s2 * s4, s2 * c4 + c2 * s4
    c7, s7 = c1 * c6 - s1 * s6, s1 * c6 + c1 * s6
    return c1, s1, c2, s2, c3, s3, c4, s4, c5, s5, c6, s6, c7, s7


@reduction
def attitudes(precession, nutation, phase, k, t, r):
    """Rotation matrices from body axes to axes with z along the momentum, into r (9, N)."""
    a1, a2, a3 = k[0, 1, 0], k[0, 2, 0], k[0, 3, 0]
    d1, d2, d3 = k[1, 1, 0], k[1, 2, 0], k[1, 3, 0]
    b0, b1, b2, b3 = k[2, 0, 0], k[2, 1, 0], k[2, 2, 0], k[2, 3, 0]
    e0, e1, e2, e3 = k[3, 0, 0], k[3, 1, 0], k[3, 2, 0], k[3, 3, 0]
    for i in range(t.size):
        v = nutation * t[i] + phase
        y = precession * t[i]
        sy, cy = sincos(y - rint(y), 0.0)
        c1, s1, c2, s2, c3, s3, c4, s4, c5, s5, c6, s6, c7, s7 = _multiples(v)
        ax = 1.0 + a1 * c2 + a2 * c4 + a3 * c6
        ay = d1 * s2 + d2 * s4 + d3 * s6
        bx = e0 * s1 + e1 * s3 + e2 * s5 + e3 * s7
        by = -(b0 * c1 + b1 * c3 + b2 * c5 + b3 * c7)
        size = 1.0 / math.sqrt(ax * ax + ay * ay + bx * bx + by * by)
        w, z = (ax * cy - ay * sy) * size, (ax * sy + ay * cy) * size
        p, q = (bx * cy - by * sy) * size, (bx * sy + by * cy) * size
        r[0, i], r[1, i], r[2, i] = (
            1.0 - 2.0 * (q * q + z * z),
            2.0 * (p * q - w * z),
            2.0 * (p * z + w * q),
        )
        r[3, i], r[4, i], r[5, i] = (
            2.0 * (p * q + w * z),
            1.0 - 2.0 * (p * p + z * z),
            2.0 * (q * z - w * p),
        )
        r[6, i], r[7, i], r[8, i] = (
            2.0 * (p * z - w * q),
            2.0 * (q * z + w * p),
            1.0 - 2.0 * (p * p + q * q),
        )


@reduction
def tangents(precession, nutation, phase, k, t, g):
    """Rotation vectors, axes along the momentum, by phase (rad), ln rho and X, into g (9, N)."""
    a1, a2, a3 = k[0, 1, 0], k[0, 2, 0], k[0, 3, 0]
    d1, d2, d3 = k[1, 1, 0], k[1, 2, 0], k[1, 3, 0]
    b0, b1, b2, b3 = k[2, 0, 0], k[2, 1, 0], k[2, 2, 0], k[2, 3, 0]
    e0, e1, e2, e3 = k[3, 0, 0], k[3, 1, 0], k[3, 2, 0], k[3, 3, 0]
    x1, x2, x3 = k[0, 1, 1], k[0, 2, 1], k[0, 3, 1]
    y1, y2, y3 = k[1, 1, 1], k[1, 2, 1], k[1, 3, 1]
    u0, u1, u2, u3 = k[2, 0, 1], k[2, 1, 1], k[2, 2, 1], k[2, 3, 1]
    v0, v1, v2, v3 = k[3, 0, 1], k[3, 1, 1], k[3, 2, 1], k[3, 3, 1]
    for i in range(t.size):
        v = nutation * t[i] + phase
        y = 2.0 * precession * t[i]
        sy, cy = sincos(y - rint(y), 0.0)
        c1, s1, c2, s2, c3, s3, c4, s4, c5, s5, c6, s6, c7, s7 = _multiples(v)
        ax = 1.0 + a1 * c2 + a2 * c4 + a3 * c6
        ay = d1 * s2 + d2 * s4 + d3 * s6
        bx = e0 * s1 + e1 * s3 + e2 * s5 + e3 * s7
        by = -(b0 * c1 + b1 * c3 + b2 * c5 + b3 * c7)
        over = 2.0 / (ax * ax + ay * ay + bx * bx + by * by)
        # by the phase
        px = -(2.0 * a1 * s2 + 4.0 * a2 * s4 + 6.0 * a3 * s6)
        py = 2.0 * d1 * c2 + 4.0 * d2 * c4 + 6.0 * d3 * c6
        qx = e0 * c1 + 3.0 * e1 * c3 + 5.0 * e2 * c5 + 7.0 * e3 * c7
        qy = b0 * s1 + 3.0 * b1 * s3 + 5.0 * b2 * s5 + 7.0 * b3 * s7
        re = ax * qx - ay * qy - bx * px + by * py
        im = ax * qy + ay * qx - bx * py - by * px
        g[0, i], g[1, i] = over * (cy * re - sy * im), over * (cy * im + sy * re)
        g[2, i] = over * (py * ax - px * ay + qy * bx - qx * by)
        # by ln rho
        px = 4.0 * a1 * c2 + 16.0 * a2 * c4 + 36.0 * a3 * c6
        py = 4.0 * d1 * s2 + 16.0 * d2 * s4 + 36.0 * d3 * s6
        qx = e0 * s1 + 9.0 * e1 * s3 + 25.0 * e2 * s5 + 49.0 * e3 * s7
        qy = -(b0 * c1 + 9.0 * b1 * c3 + 25.0 * b2 * c5 + 49.0 * b3 * c7)
        re = ax * qx - ay * qy - bx * px + by * py
        im = ax * qy + ay * qx - bx * py - by * px
        g[3, i], g[4, i] = over * (cy * re - sy * im), over * (cy * im + sy * re)
        g[5, i] = over * (py * ax - px * ay + qy * bx - qx * by)
        # by X
        px = x1 * c2 + x2 * c4 + x3 * c6
        py = y1 * s2 + y2 * s4 + y3 * s6
        qx = v0 * s1 + v1 * s3 + v2 * s5 + v3 * s7
        qy = -(u0 * c1 + u1 * c3 + u2 * c5 + u3 * c7)
        re = ax * qx - ay * qy - bx * px + by * py
        im = ax * qy + ay * qx - bx * py - by * px
        g[6, i], g[7, i] = over * (cy * re - sy * im), over * (cy * im + sy * re)
        g[8, i] = over * (py * ax - px * ay + qy * bx - qx * by)
