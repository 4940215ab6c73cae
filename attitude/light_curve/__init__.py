"""Brightness of a body from the directions of the Sun and the observer in its own axes.

Functions take and return arrays; motion, ephemerides and time belong to `scene`.  Brightness is in
m2/sr, the intensity that the body sends to the observer over the Sun's irradiance on it; a flat
white Lambert disc of radius R, face on, has R^2.

_brightness  the sum over facets, or the closed form of an ellipsoid, for many directions
_sums        the compiled sums, and the layout of facets for them
_magnitudes  reduced and apparent magnitudes; the mean over all orientations
_visibility  the table of shadows that a body casts on itself, kept on disk
_raycast     the same shadows by casting rays
"""

from attitude.light_curve._brightness import brightness, stream
from attitude.light_curve._magnitudes import (
    apparent_magnitude,
    mean_brightness,
    phased_magnitude,
    reduced_magnitude,
)
from attitude.light_curve._raycast import brightness_by_rays
from attitude.light_curve._visibility import Visibility

__all__ = [
    "Visibility",
    "apparent_magnitude",
    "brightness",
    "brightness_by_rays",
    "mean_brightness",
    "phased_magnitude",
    "reduced_magnitude",
    "stream",
]
