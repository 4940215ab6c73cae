"""Ratios of the moments of inertia of a body from the elements of its motion, in closed form.

With the tilts of the third axis from rho and X (`sensitivities.elements`) follow l, m, n of the
solution, and nu = -n.  In units of I1, with r = I3/I1 and the rate w = 4 K f,

    I2 = r (1 + nu)/(r + nu),        L = w r sqrt(1 + nu)/(|1 - r| l),
    lambda = L/(2 r) (1 - (1 - r) c),        c = Pi(n|m)/K - l (pi/2)/(K sqrt(1 + nu)),

so that 1/|1 - r| = 2 l lambda/(w sqrt(1 + nu)) + c in long-axis, - c in short-axis mode.
"""

from __future__ import annotations

import math

from attitude.compilation.decorators import entry_point, subroutine

# Steps of the arithmetic-geometric mean: from kc = 1e-4 on its error is below 1e-15.
_STEPS = 7
# 1/|1 - r| nearer than this to where no positive moments exist is continued by a straight line, so
# that an iteration is led back.
_EDGE = 0.05


@subroutine
def _tilts(rho, x):
    """Tangents of half the least and the greatest tilt."""
    s = rho**4
    top0 = low1 = top1 = 0.0
    low0 = 1.0
    for n in range(5):
        y = s ** (n * n + n) * x ** (2 * n * n + n)
        z = s ** (n * n) * x ** (2 * n * n - n) * (1.0 + x ** (2 * n)) if n > 0 else 0.0
        if n % 2 == 0:
            top0, top1, low0 = top0 + y, top1 + y * x ** (2 * n + 1), low0 + z
        else:
            top1, top0, low1 = top1 + y, top0 + y * x ** (2 * n + 1), low1 + z
    return rho * (top0 - top1) / (low0 - low1), rho * (top0 + top1) / (low0 + low1)


@subroutine
def _integrals(mc, p):
    """K(m) and Pi(1 - p | m), mc = 1 - m: Bulirsch's iteration."""
    kc = math.sqrt(mc)
    root = math.sqrt(p)
    a, b, qc, e, em = 1.0, 1.0 / root, kc, kc, 1.0
    for _ in range(_STEPS):
        f = a
        a += b / root
        g = e / root
        b = 2.0 * (b + f * g)
        root += g
        em += qc
        qc = 2.0 * math.sqrt(e)
        e = qc * em
    mean = 0.5 * math.pi * 2.0**_STEPS / em
    return mean, 0.5 * math.pi * (b + a * em) / (em * (em + root))


@entry_point
def log_ratios(precession, nutation, log_rho, x, found):
    """ln I1/I3, ln I2/I3, whether the body exists (1, else 0), and L/I3, into found (4,).

    precession and nutation are in turns per unit of time (lambda / 2 pi, f); L/I3 in rad.
    """
    size = abs(x)
    low, high = _tilts(math.exp(log_rho), size)
    cosine = (1.0 - low * low) / (1.0 + low * low)
    drop = 2.0 * (high - low) * (high + low) / ((1.0 + low * low) * (1.0 + high * high))
    m = drop * (2.0 * cosine - drop) / (cosine * cosine)
    m = min(max(m, 0.0), 1.0 - 1e-9)
    sine = 2.0 * low / (1.0 + low * low)
    nu = m * cosine * cosine / (sine * sine)
    quarter, third = _integrals(1.0 - m, 1.0 + nu)
    root = math.sqrt(1.0 + nu)
    c = third / quarter - 0.5 * math.pi * cosine / (quarter * root)
    rate = 4.0 * quarter * abs(nutation)
    q = 2.0 * cosine * 2.0 * math.pi * precession / (rate * root)
    if nutation > 0.0:
        q += c
        near = max(q, 1.0 + _EDGE)
        log_r = math.log((near - 1.0) / near) + (q - near) / (near * (near - 1.0))
    else:
        q -= c
        near = max(q, _EDGE)
        log_r = math.log((near + 1.0) / near) - (q - near) / (near * (near + 1.0))
    log_r = min(max(log_r, -30.0), 30.0)
    r = math.exp(log_r)
    first, second = -log_r, math.log((1.0 + nu) / (r + nu))
    one, two = math.exp(first), math.exp(second)
    exists = q > (1.0 if nutation > 0.0 else 0.0) and 2.0 * max(one, two, 1.0) <= one + two + 1.0
    # X < 0 exchanges the first two axes
    found[0], found[1] = (first, second) if x >= 0.0 else (second, first)
    found[2] = 1.0 if exists else 0.0
    found[3] = rate * root / (abs(1.0 - r) * cosine)


@subroutine
def with_slopes(precession, nutation, log_rho, x, found, slopes):
    """As `log_ratios`, with derivatives by precession, nutation, ln rho and X, slopes (2, 4)."""
    for p in range(4):
        h = 1e-6 * (abs(precession) if p == 0 else abs(nutation) if p == 1 else 1.0)
        d = (h if p == 0 else 0.0, h if p == 1 else 0.0, h if p == 2 else 0.0, h if p == 3 else 0.0)
        log_ratios(precession + d[0], nutation + d[1], log_rho + d[2], x + d[3], found)
        one, two = found[0], found[1]
        log_ratios(precession - d[0], nutation - d[1], log_rho - d[2], x - d[3], found)
        slopes[0, p], slopes[1, p] = 0.5 * (one - found[0]) / h, 0.5 * (two - found[1]) / h
    log_ratios(precession, nutation, log_rho, x, found)
