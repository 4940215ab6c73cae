"""The compiled loops of a scene: lengths and directions, angles, emission epochs.

All arrays are component-major; a direction (3, 1) is the same for all epochs.
"""

import math

from attitude.solution.machine import compiled
from attitude.solution.twofloat import two_sum


@compiled
def normalised(vectors, sign, begin, unit, length):
    """Unit vectors, times a sign, and lengths of vectors (3, N), into columns `begin` and on."""
    for k in range(vectors.shape[1]):
        x, y, z = vectors[0, k], vectors[1, k], vectors[2, k]
        size = math.sqrt(x * x + y * y + z * z)
        length[begin + k] = size
        unit[0, begin + k] = sign * x / size
        unit[1, begin + k] = sign * y / size
        unit[2, begin + k] = sign * z / size


@compiled
def halves(a, b, near, far):
    """|a - b| and |a + b| of unit vectors, of which the angle is 2 atan2(near, far).

    Exact at 0 and pi, where an arc cosine loses half of its digits.
    """
    step_a = 0 if a.shape[1] == 1 else 1
    step_b = 0 if b.shape[1] == 1 else 1
    for k in range(near.size):
        i, j = k * step_a, k * step_b
        x, y, z = a[0, i] - b[0, j], a[1, i] - b[1, j], a[2, i] - b[2, j]
        near[k] = math.sqrt(x * x + y * y + z * z)
        x, y, z = a[0, i] + b[0, j], a[1, i] + b[1, j], a[2, i] + b[2, j]
        far[k] = math.sqrt(x * x + y * y + z * z)


@compiled
def earlier(hi, lo, distance, light, out_hi, out_lo):
    """The epochs hi + lo minus distance over the speed of light, as pairs; lo (N,) or (1,)."""
    step = 0 if lo.size == 1 else 1
    for k in range(hi.size):
        s, e = two_sum(hi[k], -(distance[k] / light))
        out_hi[k], out_lo[k] = two_sum(s, e + lo[k * step])
