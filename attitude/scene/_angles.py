"""Angles between directions, their longitudes and latitudes, on arrays (3, N); compiled loops."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

import numpy as np

from attitude import frames
from attitude._compilation.decorators import quickly_compiled
from attitude._solver.twofloat import two_sum
from attitude._support.arrays import new_array, read_only

if TYPE_CHECKING:
    from collections.abc import Iterator

    from attitude._support.annotations import FloatArray


# A full turn, rad.
TURN: Final = 2.0 * np.pi
# Epochs that are computed together.
_BLOCK = 1 << 13


def between_units(a: FloatArray, b: FloatArray) -> FloatArray:
    """The angle (N,) between unit vectors (3, N) or (3, 1), as `between`, in half of the time."""
    from attitude._solver.vectors import separation

    pair = (read_only(np.ascontiguousarray(array)) for array in (a, b))
    return separation(*(row for vectors in pair for row in vectors))


def turned_positive(angle: FloatArray) -> FloatArray:
    """An angle from -pi to pi as one from 0 to 2 pi, less than 2 pi; filled in place."""
    np.add(angle, TURN, out=angle, where=angle < 0.0)
    # The sum of 2 pi and a negative rounding error such as -1e-20 rounds to 2 pi itself.
    np.copyto(angle, 0.0, where=angle >= TURN)
    return angle


def longitude_and_latitude(vectors: FloatArray) -> FloatArray:
    """East longitude, 0 to 2 pi, and latitude (2, N) of directions, rad."""
    out = new_array(2, vectors.shape[1])
    for block in parts(out.shape[1]):
        x, y, z = vectors[:, block]
        turned_positive(np.arctan2(y, x, out=out[0, block]))
        np.arctan2(z, np.sqrt(x * x + y * y), out=out[1, block])
    return out


def parts(count: int) -> Iterator[slice]:
    """Slices of epochs: temporary arrays of one stay in the second-level cache."""
    return (slice(begin, begin + _BLOCK) for begin in range(0, count, _BLOCK))


def bisector(sun: FloatArray, observer: FloatArray) -> FloatArray:
    """Ecliptic (J2000) longitude, latitude (2, N), rad, of -(s + o), unit vectors (3, N), ICRF."""
    turn = -frames.matrix_to_icrf("ecliptic").T
    out = new_array(2, max(sun.shape[1], observer.shape[1]))
    for block in parts(out.shape[1]):
        pair = (array if array.shape[1] == 1 else array[:, block] for array in (sun, observer))
        out[:, block] = longitude_and_latitude(turn @ sum(pair))
    return out


def position_angle(axis: FloatArray, line_of_sight: FloatArray) -> FloatArray:
    """The angle (N,), 0 to 2 pi, from north through east to an axis; directions (3, N), ICRF."""
    out = new_array(line_of_sight.shape[1])
    for block in parts(out.size):
        (a, b, c), (x, y, z) = axis[:, block], line_of_sight[:, block]
        # East is pole x line of sight, north the part of the pole across the line of sight; the
        # length of both is cos(declination).
        north = c - z * (a * x + b * y + c * z)
        turned_positive(np.arctan2(b * x - a * y, north, out=out[block]))
    return out


def aberrated(direction: FloatArray, velocity: FloatArray, light: float) -> FloatArray:
    """Unit vectors (3, N) in which an observer moving at velocities (3, N), m/s, sees directions.

    Explanatory Supplement (2013), eq. 7.40; ERFA's ``ab`` without the Sun's potential, 1e-8 of it.
    """
    beta = velocity / light
    along = np.sum(beta * direction, axis=0)
    inverse_gamma = np.sqrt(1.0 - np.sum(beta * beta, axis=0))
    seen = inverse_gamma * direction + (1.0 + along / (1.0 + inverse_gamma)) * beta
    return seen / np.sqrt(np.sum(seen * seen, axis=0))


def air_mass(elevation: FloatArray) -> FloatArray:
    """Relative air mass (N,) at true (unrefracted) elevations (N,) in rad; NaN below 0.

    Young (1994), Applied Optics 33, 1108: 1 at the zenith, 31.7 at the horizon, where its error of
    0.0037 is greatest.
    """
    z = np.sin(elevation)
    with np.errstate(invalid="ignore"):
        above = ((1.002432 * z + 0.148386) * z + 0.0096467) / (
            ((z + 0.149864) * z + 0.0102963) * z + 0.000303978
        )
        return np.where(z >= 0.0, above, np.nan)


# ---- The compiled loops of a scene: lengths and directions of vectors, light times, emission


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
def secant_step(hi, lo, times, slope, light, before, out_hi, out_lo):
    """Light times by the secant through the last two, and the epochs of emission.

    light (N,) is replaced, and kept in `before`; `times` are those that positions at `light` give,
    and `slope` their derivatives.
    """
    step = 0 if lo.size == 1 else 1
    for k in range(hi.size):
        before[k] = light[k]
        light[k] += (times[k] - light[k]) / (1.0 - slope[k])
        s, e = two_sum(hi[k], -light[k])
        out_hi[k], out_lo[k] = two_sum(s, e + lo[k * step])


@quickly_compiled
def secant_slopes(vectors, old, light, before, least, limit, times, speed, slope):
    """Update `times`, slope and speeds of the target (N,) by vectors (3, N); `old` those before.

    Where the light time changed by less than `least`, s, slope and speed are kept. Returns the
    largest error of the vectors in m; `limit` is the speed of light.
    """
    worst = 0.0
    for k in range(light.size):
        x, y, z = vectors[0, k], vectors[1, k], vectors[2, k]
        now = math.sqrt(x * x + y * y + z * z) / limit
        change = light[k] - before[k]
        if abs(change) > least:
            x, y, z = x - old[0, k], y - old[1, k], z - old[2, k]
            speed[k] = math.sqrt(x * x + y * y + z * z) / abs(change)
            slope[k] = (now - times[k]) / change
        times[k] = now
        worst = max(worst, speed[k] * abs(now - light[k]))
    return worst
