"""The compiled loops of a scene: lengths and directions of vectors, epochs of emission."""

import math

from attitude.compilation.decorators import sized_entry_point
from attitude.solution.twofloat import two_sum


@sized_entry_point
def normalised(vectors, sign, begin, unit, length):
    """Unit vectors times a sign, and lengths, of vectors (3, N), into columns from `begin` on."""
    for k in range(vectors.shape[1]):
        x, y, z = vectors[0, k], vectors[1, k], vectors[2, k]
        size = math.sqrt(x * x + y * y + z * z)
        length[begin + k] = size
        unit[0, begin + k] = sign * x / size
        unit[1, begin + k] = sign * y / size
        unit[2, begin + k] = sign * z / size


@sized_entry_point
def earlier(hi, lo, distance, light, out_hi, out_lo):
    """The epochs hi + lo - distance / light as pairs (N,); lo (N,) or (1,), `light` in m/s."""
    step = 0 if lo.size == 1 else 1
    for k in range(hi.size):
        s, e = two_sum(hi[k], -(distance[k] / light))
        out_hi[k], out_lo[k] = two_sum(s, e + lo[k * step])
