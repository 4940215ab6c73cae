"""The compiled loops of a scene: lengths and directions of vectors, light times, emission."""

import math

from attitude.compilation.decorators import quickly_compiled
from attitude.solution.twofloat import two_sum


@quickly_compiled
def normalised(vectors, sign, begin, unit, length):
    """Unit vectors times a sign, and lengths, of vectors (3, N), into columns from `begin` on."""
    for k in range(vectors.shape[1]):
        x, y, z = vectors[0, k], vectors[1, k], vectors[2, k]
        size = math.sqrt(x * x + y * y + z * z)
        length[begin + k] = size
        unit[0, begin + k] = sign * x / size
        unit[1, begin + k] = sign * y / size
        unit[2, begin + k] = sign * z / size


@quickly_compiled
def earlier(hi, lo, distance, light, out_hi, out_lo):
    """The epochs hi + lo - distance / light as pairs (N,); lo (N,) or (1,), `light` in m/s."""
    step = 0 if lo.size == 1 else 1
    for k in range(hi.size):
        s, e = two_sum(hi[k], -(distance[k] / light))
        out_hi[k], out_lo[k] = two_sum(s, e + lo[k * step])


@quickly_compiled
def light_times(vectors, speed, out):
    """Fill out (N,) with the lengths of vectors (3, N) over a speed; returns the largest entry."""
    largest = 0.0
    for k in range(out.size):
        x, y, z = vectors[0, k], vectors[1, k], vectors[2, k]
        out[k] = math.sqrt(x * x + y * y + z * z) / speed
        largest = max(largest, abs(x), abs(y), abs(z))
    return largest


@quickly_compiled
def secant_step(hi, lo, found, slope, light, before, out_hi, out_lo):
    """Light times by the secant through the last two, and the epochs of emission.

    light (N,) is replaced, and kept in `before`; found (N,) are the light times that the positions
    at `light` give, and slope (N,) their derivatives by `light`.
    """
    step = 0 if lo.size == 1 else 1
    for k in range(hi.size):
        before[k] = light[k]
        light[k] += (found[k] - light[k]) / (1.0 - slope[k])
        s, e = two_sum(hi[k], -light[k])
        out_hi[k], out_lo[k] = two_sum(s, e + lo[k * step])


@quickly_compiled
def secant_slopes(vectors, old, light, before, least, limit, found, speed, slope):
    """Update `found`, slope (N,) and the speeds of the target (N,) by the vectors (3, N).

    `old` are the vectors of the step before.  Where the light time changed by less than `least`,
    in s, the differences are rounding: slope and speed are kept.  Returns the largest error of the
    vectors in m: the way of the target in the error of the light time.  `limit` is the speed of
    light in m/s.
    """
    worst = 0.0
    for k in range(light.size):
        x, y, z = vectors[0, k], vectors[1, k], vectors[2, k]
        now = math.sqrt(x * x + y * y + z * z) / limit
        change = light[k] - before[k]
        if abs(change) > least:
            x, y, z = x - old[0, k], y - old[1, k], z - old[2, k]
            speed[k] = math.sqrt(x * x + y * y + z * z) / abs(change)
            slope[k] = (now - found[k]) / change
        found[k] = now
        worst = max(worst, speed[k] * abs(now - light[k]))
    return worst
