"""Ratios of the moments of inertia of a body from the elements of its motion, in closed form.

With the tilts of the third axis from rho and X (`sensitivities.elements`) follow l, m, n of the
solution, and nu = -n.  In units of I1, with r = I3/I1 and the rate w = 4 K f,

    I2 = r (1 + nu)/(r + nu),        L = w r sqrt(1 + nu)/(|1 - r| l),
    lambda = L/(2 r) (1 - (1 - r) c),        c = Pi(n|m)/K - l (pi/2)/(K sqrt(1 + nu)),

so that 1/|1 - r| = 2 l lambda/(w sqrt(1 + nu)) + c in long-axis, - c in short-axis mode.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from attitude.compilation.decorators import entry_point, subroutine

if TYPE_CHECKING:
    from attitude.annotations import BoolArray, FloatArray

# Steps of the arithmetic-geometric mean: from kc = 1e-4 on its error is below 1e-15.
_STEPS = 7
# 1/|1 - r| nearer than this to where no positive moments exist is continued by a straight line, so
# that an iteration is led back.
_EDGE = 0.05
# Steps of derivatives by precession and nutation, relative, and by ln rho and X.
_STEP = 1e-6


class ElementMoments(NamedTuple):
    """What follows from elements of shape (...).

    ln I1/I3 and ln I2/I3, log_ratios (2, ...); whether a body has such moments, exists (...); and
    L/I3, momentum (...), rad per unit of time.
    """

    log_ratios: FloatArray
    exists: BoolArray
    momentum: FloatArray


@subroutine
def _tilts(rho, x):
    """Tangents of half the least and the greatest tilt."""
    square = x * x
    fourth, s = square * square, rho * rho * rho * rho
    top0 = low1 = top1 = 0.0
    low0 = 1.0
    # s^(n n + n) x^(2 n n + n), s^(n n) x^(2 n n - n), and the factors of the next ones
    y, z, next_y, next_z, even = 1.0, 1.0, s * s * square * x, s * x, 1.0
    for n in range(5):
        other, both = y * even * x, z * (1.0 + even) if n > 0 else 0.0
        if n % 2 == 0:
            top0, top1, low0 = top0 + y, top1 + other, low0 + both
        else:
            top1, top0, low1 = top1 + y, top0 + other, low1 + both
        y, z, even = y * next_y, z * next_z, even * square
        next_y, next_z = next_y * (s * s * fourth), next_z * (s * s * fourth)
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


@subroutine
def _of_one(precession, nutation, log_rho, x):
    """ln I1/I3, ln I2/I3, whether the body exists (1, else 0), and L/I3."""
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
    exists = 1.0 if exists else 0.0
    momentum = rate * root / (abs(1.0 - r) * cosine)
    # X < 0 exchanges the first two axes
    if x < 0.0:
        return second, first, exists, momentum
    return first, second, exists, momentum


@entry_point
def _of_many(elements, found):
    """What `_of_one` gives for elements (4, N), into found (4, N)."""
    for i in range(elements.shape[1]):
        one, two, exists, momentum = _of_one(
            elements[0, i], elements[1, i], elements[2, i], elements[3, i]
        )
        found[0, i], found[1, i], found[2, i], found[3, i] = one, two, exists, momentum


def moments(elements: FloatArray) -> ElementMoments:
    """The moments that give elements (4, ...): precession, nutation, ln rho, X.

    Precession and nutation are in turns per unit of time (lambda / 2 pi, f).
    """
    found = np.empty(elements.shape)
    _of_many(np.ascontiguousarray(elements.reshape(4, -1)), found.reshape(4, -1))
    return ElementMoments(found[:2], found[2] > 0.0, found[3])


def with_slopes(elements: FloatArray) -> tuple[FloatArray, FloatArray]:
    """ln I1/I3 and ln I2/I3 (2, ...) of elements (4, ...), and derivatives (4, 2, ...) by these."""
    h = np.full(elements.shape, _STEP)
    h[:2] *= np.abs(elements[:2])
    shifted = np.repeat(elements[:, None], 9, axis=1)
    which = range(4)
    shifted[which, [1, 2, 3, 4]] += h
    shifted[which, [5, 6, 7, 8]] -= h
    found = moments(shifted).log_ratios
    slopes = 0.5 * np.swapaxes(found[:, 1:5] - found[:, 5:], 0, 1) / h[:, None]
    return found[:, 0], slopes
