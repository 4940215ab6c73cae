"""Vectors turned by attitudes, and angles between vectors, compiled.

All arrays are component-major, (4, N) for attitudes and (3, N) for vectors, so that LLVM vectorises
the loops; a vector (3, 1) is the same for all epochs.  `attitude.quaternion.rotate` does the same
in numpy, at some 60 ns an epoch where `to_body` takes 3 to 5.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from attitude.compilation.decorators import quickly_compiled, subroutine

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


def to_body(wxyz: FloatArray, vectors: FloatArray, out: FloatArray) -> None:
    """Fill components over the body axes (3, N) of inertial vectors (3, 1 or N): out = q* v q."""
    # Two loops, of which a scene mostly compiles one.
    if vectors.shape[1] == 1:
        _one_to_body(wxyz, vectors[0, 0], vectors[1, 0], vectors[2, 0], out)
    else:
        _each_to_body(wxyz, vectors, out)


@quickly_compiled
def _one_to_body(wxyz, a, b, c, out):
    for k in range(wxyz.shape[1]):
        w, x, y, z = wxyz[0, k], wxyz[1, k], wxyz[2, k], wxyz[3, k]
        # v - 2 w (u x v) + 2 u x (u x v), u being the vector part of q
        d = 2.0 * (y * c - z * b)
        e = 2.0 * (z * a - x * c)
        f = 2.0 * (x * b - y * a)
        out[0, k] = a - w * d + (y * f - z * e)
        out[1, k] = b - w * e + (z * d - x * f)
        out[2, k] = c - w * f + (x * e - y * d)


@quickly_compiled
def _each_to_body(wxyz, vectors, out):
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
    if ax.size == 1:
        ax, ay, az, bx, by, bz = bx, by, bz, ax, ay, az
    angle, far = np.empty(ax.size), np.empty(min(ax.size, _BLOCK))
    for begin in range(0, angle.size, _BLOCK):
        near = angle[begin : begin + _BLOCK]
        part = slice(begin, begin + near.size)
        first = ax[part], ay[part], az[part]
        if bx.size == 1:
            _from_one(*first, bx[0], by[0], bz[0], near, far)
        else:
            _from_each(*first, bx[part], by[part], bz[part], near, far)
        np.arctan2(near, far[: near.size], out=near)
        near *= 2.0
    return angle


@quickly_compiled
def _from_one(ax, ay, az, bx, by, bz, near, far):
    """Fill |a - b| and |a + b| for one vector b."""
    for k in range(near.size):
        x, y, z = ax[k] - bx, ay[k] - by, az[k] - bz
        near[k] = math.sqrt(x * x + y * y + z * z)
        x, y, z = ax[k] + bx, ay[k] + by, az[k] + bz
        far[k] = math.sqrt(x * x + y * y + z * z)


@quickly_compiled
def _from_each(ax, ay, az, bx, by, bz, near, far):
    """Fill |a - b| and |a + b|."""
    for k in range(near.size):
        x, y, z = ax[k] - bx[k], ay[k] - by[k], az[k] - bz[k]
        near[k] = math.sqrt(x * x + y * y + z * z)
        x, y, z = ax[k] + bx[k], ay[k] + by[k], az[k] + bz[k]
        far[k] = math.sqrt(x * x + y * y + z * z)
