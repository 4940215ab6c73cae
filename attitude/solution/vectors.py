"""Vectors turned by attitudes, and angles between vectors, compiled.

All arrays are component-major, (4, N) for attitudes and (3, N) for vectors, so that LLVM vectorises
the loops; a vector (3, 1) is the same for all epochs.  `attitude.quaternion.rotate` does the same
in numpy, at some 60 ns an epoch where `to_body` takes 3 to 5.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from attitude.compilation.decorators import sized_entry_point, subroutine

if TYPE_CHECKING:
    from attitude.annotations import FloatArray

# Angles that are computed together: temporary arrays stay in the second-level cache.
_BLOCK = 1 << 14


@subroutine
def quaternion_of(r, wxyz):
    """Fill the quaternion, w >= 0, of a rotation matrix (3, 3).

    By Shepperd's method (J. Guidance and Control 1, 223, 1978), with the bits of scipy's Rotation.
    """
    trace = r[0, 0] + r[1, 1] + r[2, 2]
    i = 0
    if r[1, 1] > r[0, 0]:
        i = 1
    if r[2, 2] > r[i, i]:
        i = 2
    if trace > r[i, i]:
        w = 1.0 + trace
        x, y, z = r[2, 1] - r[1, 2], r[0, 2] - r[2, 0], r[1, 0] - r[0, 1]
    else:
        j, k = (i + 1) % 3, (i + 2) % 3
        w = r[k, j] - r[j, k]
        t, u, v = 1.0 - trace + 2.0 * r[i, i], r[j, i] + r[i, j], r[k, i] + r[i, k]
        x, y, z = (t, u, v) if i == 0 else ((v, t, u) if i == 1 else (u, v, t))
    size = math.sqrt(x * x + y * y + z * z + w * w)
    first = x if x != 0.0 else (y if y != 0.0 else z)
    if w < 0.0 or (w == 0.0 and first < 0.0):
        size = -size
    wxyz[0], wxyz[1], wxyz[2], wxyz[3] = w / size, x / size, y / size, z / size


@sized_entry_point
def to_body(wxyz, vectors, out):
    """Fill components over the body axes (3, N) of inertial vectors (3, 1 or N): out = q* v q."""
    if vectors.shape[1] == 1:
        a, b, c = vectors[0, 0], vectors[1, 0], vectors[2, 0]
        for k in range(wxyz.shape[1]):
            w, x, y, z = wxyz[0, k], wxyz[1, k], wxyz[2, k], wxyz[3, k]
            # v - 2 w (u x v) + 2 u x (u x v), u being the vector part of q
            d = 2.0 * (y * c - z * b)
            e = 2.0 * (z * a - x * c)
            f = 2.0 * (x * b - y * a)
            out[0, k] = a - w * d + (y * f - z * e)
            out[1, k] = b - w * e + (z * d - x * f)
            out[2, k] = c - w * f + (x * e - y * d)
    else:
        for k in range(wxyz.shape[1]):
            w, x, y, z = wxyz[0, k], wxyz[1, k], wxyz[2, k], wxyz[3, k]
            a, b, c = vectors[0, k], vectors[1, k], vectors[2, k]
            d = 2.0 * (y * c - z * b)
            e = 2.0 * (z * a - x * c)
            f = 2.0 * (x * b - y * a)
            out[0, k] = a - w * d + (y * f - z * e)
            out[1, k] = b - w * e + (z * d - x * f)
            out[2, k] = c - w * f + (x * e - y * d)


def separation(
    ax: FloatArray,
    ay: FloatArray,
    az: FloatArray,
    bx: FloatArray,
    by: FloatArray,
    bz: FloatArray,
) -> FloatArray:
    """Angles (N,) in rad between unit vectors a and b; components are (N,), or (1,) for all epochs.

    2 atan2(|a - b|, |a + b|): exact at 0 and pi, where an arc cosine loses half of its digits.
    """
    angle = np.empty(max(ax.size, bx.size))
    far = np.empty(min(angle.size, _BLOCK))
    for begin in range(0, angle.size, _BLOCK):
        near = angle[begin : begin + _BLOCK]
        part = slice(begin, begin + near.size)
        given = (each if each.size == 1 else each[part] for each in (ax, ay, az, bx, by, bz))
        _halves(*given, near, far)
        np.arctan2(near, far[: near.size], out=near)
        near *= 2.0
    return angle


@sized_entry_point
def _halves(ax, ay, az, bx, by, bz, near, far):
    """Fill |a - b| and |a + b|."""
    step_a = 0 if ax.size == 1 else 1
    step_b = 0 if bx.size == 1 else 1
    for k in range(near.size):
        i, j = k * step_a, k * step_b
        x, y, z = ax[i] - bx[j], ay[i] - by[j], az[i] - bz[j]
        near[k] = math.sqrt(x * x + y * y + z * z)
        x, y, z = ax[i] + bx[j], ay[i] + by[j], az[i] + bz[j]
        far[k] = math.sqrt(x * x + y * y + z * z)
