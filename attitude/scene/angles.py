"""Angles between directions, and their longitudes and latitudes; arrays (3, N), component first."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from attitude import frames

if TYPE_CHECKING:
    from attitude.annotations import FloatArray

# A full turn, rad.
TURN: Final = 2.0 * np.pi


def between(a: FloatArray, b: FloatArray) -> FloatArray:
    """The angle (N,) between directions of any length, 0 to pi rad, exact at both ends."""
    across = np.cross(a, b, axis=0)
    return np.arctan2(np.sqrt(np.sum(across * across, axis=0)), np.sum(a * b, axis=0))


def turned_positive(angle: FloatArray) -> FloatArray:
    """An angle from -pi to pi as one from 0 to 2 pi, less than 2 pi."""
    # The sum of 2 pi and a negative rounding error such as -1e-20 rounds to 2 pi itself.
    positive = np.where(angle < 0.0, angle + TURN, angle)
    return np.where(positive >= TURN, 0.0, positive)


def longitude_and_latitude(vectors: FloatArray) -> FloatArray:
    """East longitude, 0 to 2 pi, and latitude (2, N) of directions of any length, rad."""
    x, y, z = vectors
    return np.stack([turned_positive(np.arctan2(y, x)), np.arctan2(z, np.hypot(x, y))])


def bisector(sun: FloatArray, observer: FloatArray) -> FloatArray:
    """Ecliptic (J2000) longitude and latitude (2, N) of the phase-angle bisector -(s + o), rad.

    s and o are the unit vectors from the body to the Sun and to the observer, ICRF.
    """
    return longitude_and_latitude(frames.matrix_to_icrf("ecliptic").T @ -(sun + observer))


def position_angle(axis: FloatArray, line_of_sight: FloatArray) -> FloatArray:
    """The angle (N,) on the sky from north through east to an axis, 0 to 2 pi rad.

    Both arguments are directions (3, N), ICRF; the line of sight points from the observer to the
    body.
    """
    x, y, _ = line_of_sight
    # East is pole x line of sight, north the part of the pole across the line of sight; the length
    # of both is cos(declination).
    east = axis[1] * x - axis[0] * y
    north = axis[2] - line_of_sight[2] * np.sum(axis * line_of_sight, axis=0)
    return turned_positive(np.arctan2(east, north))


def aberrated(direction: FloatArray, velocity: FloatArray, light: float) -> FloatArray:
    """Unit vectors (3, N) of the directions in which a moving observer sees given directions.

    Parameters
    ----------
    direction : (3, N) array
        Unit vectors from the observer, for an observer at rest in the barycentric frame.
    velocity : (3, N) array
        Barycentric velocity of the observer, m/s.
    light : float
        Speed of light, m/s.

    Notes
    -----
    Exact special relativity: Explanatory Supplement (2013), eq. 7.40; ERFA's ``ab`` without the
    term of the Sun's potential, which is 1e-8 of the aberration.
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
