"""Attitudes and moments of inertia from the five elements of a free rotation, compiled.

The series of docs/derivation.md (section 15) with four terms, eight epochs at a time.  Elements
here are per unit of time of the epochs: precession and nutation in turns (lambda / 2 pi, f), the
phase in turns, ln rho, X.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Literal, NamedTuple

import numpy as np

from attitude._compilation.decorators import (
    entry_point,
    reduction,
    reduction_subroutine,
    reduction_within,
    subroutine,
)
from attitude._compilation.elementary import cosine_and_sine
from attitude._compilation.simd import eight, put_eight, root

if TYPE_CHECKING:
    from attitude._support.annotations import BoolArray, FloatArray


# Epochs of one vector: arrays of epochs are as long as a multiple of this.
LANES = 8


class SeriesAttitudes(NamedTuple):
    """Attitudes and tangents at N epochs.

    Rotation matrices from body axes to axes with z along the momentum, by rows, matrix (9, N);
    rotation vectors over those axes by phase (rad), ln rho and X, tangents (9, N).
    """

    matrix: FloatArray
    tangents: FloatArray


def padded(values: FloatArray, mode: Literal["edge", "constant"] = "edge") -> FloatArray:
    """An array (..., N) with its last entry, or zero, repeated until `LANES` divides N."""
    last = values[..., -1:] if mode == "edge" else np.zeros((*values.shape[:-1], 1))
    more = np.repeat(last, -values.shape[-1] % LANES, axis=-1)
    return np.concatenate([values, more], axis=-1)


def at_epochs(state: FloatArray, t: FloatArray) -> SeriesAttitudes:
    """The attitudes of one state, elements first, at epochs (N,)."""
    epochs = padded(t)
    r, g = np.empty((9, epochs.size)), np.empty((9, epochs.size))
    attitudes(state, epochs, r.reshape(-1), g.reshape(-1))
    return SeriesAttitudes(r[:, : t.size], g[:, : t.size])


@reduction_within
def _powers(x):
    """x^(j (j + 1)/2) for j from 0 to 7, and their derivatives."""
    x2 = x * x
    x3, x5 = x2 * x, x2 * x2 * x
    x6, x9, x10 = x3 * x3, x5 * x2 * x2, x5 * x5
    x14, x15, x20 = x9 * x5, x10 * x5, x10 * x10
    x21 = x20 * x
    x27 = x21 * x6
    return (
        (1.0, x, x3, x6, x10, x15, x21, x27 * x),
        (0.0, 1.0, 3.0 * x2, 6.0 * x5, 10.0 * x9, 15.0 * x14, 21.0 * x20, 28.0 * x27),
    )


@reduction_within
def _sums_and_differences(c, d, p):
    """The coefficients of the series of an attitude from factors by ln rho and powers of X.

    Those of E^n and E^-n: A's sums and differences, without the first, b's sums and differences
    (b without its factor -i).
    """
    a = c[0] * (p[2] + p[1]), c[1] * (p[4] + p[3]), c[2] * (p[6] + p[5])
    a_less = c[0] * (p[2] - p[1]), c[1] * (p[4] - p[3]), c[2] * (p[6] - p[5])
    b0, b1 = d[0] * (p[0] - p[1]), d[1] * (p[2] - p[3])
    b2, b3 = d[2] * (p[4] - p[5]), d[3] * (p[6] - p[7])
    e0, e1 = -d[0] * (p[0] + p[1]), -d[1] * (p[2] + p[3])
    e2, e3 = -d[2] * (p[4] + p[5]), -d[3] * (p[6] + p[7])
    return a, a_less, (b0, b1, b2, b3), (e0, e1, e2, e3)


@reduction_within
def _turning(ax, ay, bx, by, px, py, qx, qy, cy, sy, over):
    """The rotation vector of a change (p, q) of the two numbers (a, b) of an attitude."""
    re = ax * qx - ay * qy - bx * px + by * py
    im = ax * qy + ay * qx - bx * py - by * px
    third = py * ax - px * ay + qy * bx - qx * by
    return over * (cy * re - sy * im), over * (cy * im + sy * re), over * third


@reduction_within
def _multiples(c1, s1):
    """Cosine and sine of two to seven times an angle."""
    c2, s2 = c1 * c1 - s1 * s1, 2.0 * c1 * s1
    c3, s3 = c1 * c2 - s1 * s2, s1 * c2 + c1 * s2
    c4, s4 = c2 * c2 - s2 * s2, 2.0 * c2 * s2
    c5, s5 = c1 * c4 - s1 * s4, s1 * c4 + c1 * s4
    c6, s6 = c2 * c4 - s2 * s4, s2 * c4 + c2 * s4
    c7, s7 = c1 * c6 - s1 * s6, s1 * c6 + c1 * s6
    return c2, s2, c3, s3, c4, s4, c5, s5, c6, s6, c7, s7


@reduction_within
def matrix_rows(w, x, y, z):
    """The rows of the matrix of a unit quaternion."""
    return (
        (1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)),
        (2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)),
        (2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)),
    )


@reduction_within
def put_three(array, at, n, x, y, z):
    """Store three vectors in rows of n numbers."""
    put_eight(array, at, x)
    put_eight(array, at + n, y)
    put_eight(array, at + 2 * n, z)


@reduction_within
def three(array, at, n):
    """The vectors that `put_three` stores."""
    return eight(array, at), eight(array, at + n), eight(array, at + 2 * n)


@reduction_subroutine
def fill_attitudes(state, t, r, g):
    """Matrices as in `SeriesAttitudes`, into r (9 N,), and tangents, into g (9 N,) or ().

    state (5 or more,): precession, nutation, phase, ln rho, X; t (N,), where `LANES` divides N.
    """
    n = t.size
    precession, nutation, phase = state[0], state[1], state[2]
    rho = math.exp(state[3])
    rho4, rho9 = rho**4, rho**9
    of_a = -rho4, rho4**4, -(rho9**4)
    of_b = rho, -rho9, rho9 * rho4**4, -(rho9**5) * rho4
    powers, slopes = _powers(state[4])
    (a1, a2, a3), (d1, d2, d3), (b0, b1, b2, b3), (e0, e1, e2, e3) = _sums_and_differences(
        of_a, of_b, powers
    )
    (x1, x2, x3), (y1, y2, y3), (u0, u1, u2, u3), (v0, v1, v2, v3) = _sums_and_differences(
        of_a, of_b, slopes
    )
    for i in range(0, n, 8):
        at = eight(t, i)
        c1, s1 = cosine_and_sine(nutation * at + phase)
        cy, sy = cosine_and_sine(precession * at)
        c2, s2, c3, s3, c4, s4, c5, s5, c6, s6, c7, s7 = _multiples(c1, s1)
        ax = 1.0 + a1 * c2 + a2 * c4 + a3 * c6
        ay = d1 * s2 + d2 * s4 + d3 * s6
        bx = e0 * s1 + e1 * s3 + e2 * s5 + e3 * s7
        by = 0.0 - (b0 * c1 + b1 * c3 + b2 * c5 + b3 * c7)
        over = 1.0 / (ax * ax + ay * ay + bx * bx + by * by)
        size = root(over)
        w, z = (ax * cy - ay * sy) * size, (ax * sy + ay * cy) * size
        p, q = (bx * cy - by * sy) * size, (bx * sy + by * cy) * size
        x, y, z = matrix_rows(w, p, q, z)
        put_three(r, i, n, *x)
        put_three(r, i + 3 * n, n, *y)
        put_three(r, i + 6 * n, n, *z)
        if g.size == 0:
            continue
        # twice the angle of the precession
        cy, sy = cy * cy - sy * sy, 2.0 * cy * sy
        over = over + over
        px = 0.0 - (2.0 * a1 * s2 + 4.0 * a2 * s4 + 6.0 * a3 * s6)
        py = 2.0 * d1 * c2 + 4.0 * d2 * c4 + 6.0 * d3 * c6
        qx = e0 * c1 + 3.0 * e1 * c3 + 5.0 * e2 * c5 + 7.0 * e3 * c7
        qy = b0 * s1 + 3.0 * b1 * s3 + 5.0 * b2 * s5 + 7.0 * b3 * s7
        turned = _turning(ax, ay, bx, by, px, py, qx, qy, cy, sy, over)
        put_three(g, i, n, *turned)
        # by ln rho
        px = 4.0 * a1 * c2 + 16.0 * a2 * c4 + 36.0 * a3 * c6
        py = 4.0 * d1 * s2 + 16.0 * d2 * s4 + 36.0 * d3 * s6
        qx = e0 * s1 + 9.0 * e1 * s3 + 25.0 * e2 * s5 + 49.0 * e3 * s7
        qy = 0.0 - (b0 * c1 + 9.0 * b1 * c3 + 25.0 * b2 * c5 + 49.0 * b3 * c7)
        turned = _turning(ax, ay, bx, by, px, py, qx, qy, cy, sy, over)
        put_three(g, i + 3 * n, n, *turned)
        # by X
        px = x1 * c2 + x2 * c4 + x3 * c6
        py = y1 * s2 + y2 * s4 + y3 * s6
        qx = v0 * s1 + v1 * s3 + v2 * s5 + v3 * s7
        qy = 0.0 - (u0 * c1 + u1 * c3 + u2 * c5 + u3 * c7)
        turned = _turning(ax, ay, bx, by, px, py, qx, qy, cy, sy, over)
        put_three(g, i + 6 * n, n, *turned)


@reduction
def attitudes(state, t, r, g):
    """As `fill_attitudes`, for calls from Python.

    In loops it is not called: which machine code of it these ran, with other last digits, would
    depend on whether they were compiled in this process.
    """
    fill_attitudes(state, t, r, g)


# ---- Ratios of the moments of inertia of a body from the elements of its motion, in closed form
# With the tilts of the third axis from rho and X (`elements`) follow l, m, n of the solution, and
# nu = -n.  In units of I1, with r = I3/I1 and the rate w = 4 K f,
#
#     I2 = r (1 + nu)/(r + nu),        L = w r sqrt(1 + nu)/(|1 - r| l),
#     lambda = L/(2 r) (1 - (1 - r) c),        c = Pi(n|m)/K - l (pi/2)/(K sqrt(1 + nu)),
#
# so that 1/|1 - r| = 2 l lambda/(w sqrt(1 + nu)) + c in long-axis, - c in short-axis mode.

# Steps of the arithmetic-geometric mean: from kc = 1e-4 on its error is below 1e-15.
_STEPS = 7
# 1/|1 - r| nearer than this to where no positive moments exist is continued by a straight line, so
# that an iteration is led back.
_EDGE = 0.05
# Step of derivatives by ln rho and X.
_STEP = 1e-6


class ElementMoments(NamedTuple):
    """What follows from elements of shape (...)."""

    log_ratios: FloatArray  # (2, ...), ln I1/I3 and ln I2/I3
    exists: BoolArray  # (...), whether a body has such moments
    momentum: FloatArray  # (...), L/I3, rad per unit of time


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
    """ln I1/I3, ln I2/I3, whether the body exists (1, else 0), and L/I3.

    Then the slopes of the first two by ln(precession / nutation).
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
    of_rates = 2.0 * cosine * 2.0 * math.pi * precession / (rate * root)
    q = of_rates
    if nutation > 0.0:
        q += c
        beyond_one = max(q, 1.0 + _EDGE)
        log_r = math.log((beyond_one - 1.0) / beyond_one) + (q - beyond_one) / (
            beyond_one * (beyond_one - 1.0)
        )
        by_rates = of_rates / (beyond_one * (beyond_one - 1.0))
    else:
        q -= c
        beyond_one = max(q, _EDGE)
        log_r = math.log((beyond_one + 1.0) / beyond_one) - (q - beyond_one) / (
            beyond_one * (beyond_one + 1.0)
        )
        by_rates = -of_rates / (beyond_one * (beyond_one + 1.0))
    if abs(log_r) > 30.0:
        log_r, by_rates = math.copysign(30.0, log_r), 0.0
    r = math.exp(log_r)
    first, second = -log_r, math.log((1.0 + nu) / (r + nu))
    one, two = math.exp(first), math.exp(second)
    exists = q > (1.0 if nutation > 0.0 else 0.0) and 2.0 * max(one, two, 1.0) <= one + two + 1.0
    exists = 1.0 if exists else 0.0
    momentum = rate * root / (abs(1.0 - r) * cosine)
    by_second = -by_rates * r / (r + nu)
    # X < 0 exchanges the first two axes
    if x < 0.0:
        return second, first, exists, momentum, by_second, -by_rates
    return first, second, exists, momentum, -by_rates, by_second


@entry_point
def _of_many(elements, out):
    """What `_of_one` gives for elements (4, N), into out (4, N)."""
    for i in range(elements.shape[1]):
        one, two, exists, momentum, _, _ = _of_one(
            elements[0, i], elements[1, i], elements[2, i], elements[3, i]
        )
        out[0, i], out[1, i], out[2, i], out[3, i] = one, two, exists, momentum


def moments(elements: FloatArray) -> ElementMoments:
    """Moments of elements (4, ...): precession, nutation (turns per unit of time), ln rho, X."""
    all_moments = np.empty(elements.shape)
    _of_many(np.ascontiguousarray(elements.reshape(4, -1)), all_moments.reshape(4, -1))
    return ElementMoments(all_moments[:2], all_moments[2] > 0.0, all_moments[3])


@entry_point
def with_slopes(states, ratios, slopes):
    """ln I1/I3 and ln I2/I3 of states (S, 5 or more) as in `attitudes`, into ratios (S, 2).

    Into slopes (S, 2, 4) their derivatives by precession, nutation, ln rho and X.
    """
    for i in range(states.shape[0]):
        p, f, log_rho, x = states[i, 0], states[i, 1], states[i, 3], states[i, 4]
        one, two, _, _, by_first, by_second = _of_one(p, f, log_rho, x)
        ratios[i, 0], ratios[i, 1] = one, two
        slopes[i, 0, 0], slopes[i, 1, 0] = by_first / p, by_second / p
        slopes[i, 0, 1], slopes[i, 1, 1] = -by_first / f, -by_second / f
        for k in range(2):
            dr, dx = (0.0, _STEP) if k else (_STEP, 0.0)
            one, two, _, _, _, _ = _of_one(p, f, log_rho + dr, x + dx)
            first, second, _, _, _, _ = _of_one(p, f, log_rho - dr, x - dx)
            slopes[i, 0, 2 + k] = 0.5 * (one - first) / _STEP
            slopes[i, 1, 2 + k] = 0.5 * (two - second) / _STEP
