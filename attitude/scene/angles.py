"""Angles between directions and the places they point to; arrays (3, N), component first."""

import numpy as np

from attitude import frames

TURN = 2.0 * np.pi


def between(a, b):
    """The angle of two directions of any length, 0 to pi, exact at both ends."""
    across = np.cross(a, b, axis=0)
    return np.arctan2(np.sqrt(np.sum(across * across, axis=0)), np.sum(a * b, axis=0))


def turned_positive(angle):
    """An angle from -pi to pi as one from 0 to 2 pi, less than 2 pi."""
    # A negative angle of rounding, -1e-20, would become 2 pi itself.
    positive = np.where(angle < 0.0, angle + TURN, angle)
    return np.where(positive >= TURN, 0.0, positive)


def longitude_and_latitude(vectors):
    """East longitude, 0 to 2 pi, and latitude (2, N) of directions of any length."""
    x, y, z = vectors
    return np.stack([turned_positive(np.arctan2(y, x)), np.arctan2(z, np.hypot(x, y))])


def bisector(sun, observer):
    """Ecliptic longitude and latitude (2, N) of -(s + o): the phase-angle bisector."""
    return longitude_and_latitude(frames.matrix_to_icrf("ecliptic").T @ -(sun + observer))


def position_angle(axis, line_of_sight):
    """The angle (N,), 0 to 2 pi, from north through east, of an axis as it is seen on the sky.

    Both are directions in ICRF; the line of sight goes from the observer to the body.
    """
    x, y, _ = line_of_sight
    # East is pole x line of sight, north the rest of the pole; both are cos(declination) long.
    east = axis[1] * x - axis[0] * y
    north = axis[2] - line_of_sight[2] * np.sum(axis * line_of_sight, axis=0)
    return turned_positive(np.arctan2(east, north))


def aberrated(direction, velocity, light):
    """Directions (3, N) in which a moving observer sees what lies in the directions given.

    Parameters
    ----------
    direction : (3, N) array
        Unit vectors from the observer, for one at rest in the barycentric frame.
    velocity : (3, N) array
        Of the observer, m/s.

    Notes
    -----
    Exact special relativity: Explanatory Supplement (2013), eq. 7.40; ERFA's ``ab`` without the
    Sun's potential, which enters by 1e-8 of the aberration.
    """
    beta = velocity / light
    along = np.sum(beta * direction, axis=0)
    inverse_gamma = np.sqrt(1.0 - np.sum(beta * beta, axis=0))
    seen = inverse_gamma * direction + (1.0 + along / (1.0 + inverse_gamma)) * beta
    return seen / np.sqrt(np.sum(seen * seen, axis=0))
