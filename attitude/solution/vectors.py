"""Vectors turned by attitudes, and angles between vectors, compiled.

All arrays are component-major, (4, N) for attitudes and (3, N) for vectors, so that LLVM vectorises
the loops; a vector (3, 1) is the same for all epochs.  `attitude.quaternion.rotate` does the same
in numpy, at some 60 ns an epoch where `to_body` takes 3 to 5.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from attitude.compilation.decorators import entry_point

if TYPE_CHECKING:
    from attitude.annotations import FloatArray


@entry_point
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
    near, far = np.empty((2, max(ax.size, bx.size)))
    _halves(ax, ay, az, bx, by, bz, near, far)
    np.arctan2(near, far, out=near)
    near *= 2.0
    return near


@entry_point
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
