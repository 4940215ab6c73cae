"""The angle between two directions."""

import math

import numpy as np

from attitude.solution.machine import compiled


def separation(ax, ay, az, bx, by, bz):
    """Angles (N,) in rad between unit vectors by component; components (1,) serve all epochs.

    2 atan2(|a - b|, |a + b|): exact at 0 and pi, where an arc cosine loses half of its digits.
    """
    near, far = np.empty((2, max(ax.size, bx.size)))
    _halves(ax, ay, az, bx, by, bz, near, far)
    np.arctan2(near, far, out=near)
    near *= 2.0
    return near


@compiled
def _halves(ax, ay, az, bx, by, bz, near, far):
    step_a = 0 if ax.size == 1 else 1
    step_b = 0 if bx.size == 1 else 1
    for k in range(near.size):
        i, j = k * step_a, k * step_b
        x, y, z = ax[i] - bx[j], ay[i] - by[j], az[i] - bz[j]
        near[k] = math.sqrt(x * x + y * y + z * z)
        x, y, z = ax[i] + bx[j], ay[i] + by[j], az[i] + bz[j]
        far[k] = math.sqrt(x * x + y * y + z * z)
