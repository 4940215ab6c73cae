"""Brightness of a body from the directions of the Sun and the observer in its own axes.

Arrays in, arrays out: nothing here knows of motion, ephemerides or time.  Brightness is in m2/sr,
the intensity that the body sends to the observer over the Sun's irradiance on it; a flat white
Lambert disc of radius R, face on, has R^2.
"""

from attitude.light_curve.brightness import brightness, stream
from attitude.light_curve.magnitudes import apparent_magnitude, reduced_magnitude
from attitude.light_curve.orientations import mean_brightness, phased_magnitude
from attitude.light_curve.raycast import brightness_by_rays
from attitude.light_curve.visibility import Visibility

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
