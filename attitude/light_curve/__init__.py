"""Brightness of a body from the directions of the Sun and the observer in its own axes.

A `Scene` with a shape and a law calls it: ``Scene(..., shape=..., law=...).at(times).magnitude``.

Functions take and return arrays; motion, ephemerides and time belong to `scene`.  Brightness is in
m2/sr, the intensity that the body sends to the observer over the Sun's irradiance on it; a flat
white Lambert disc of radius R, face on, has R^2.

_brightness   `brightness`, `stream`: checks of directions, the choice of the loop, threads
_magnitudes   reduced and apparent magnitudes; the mean over all orientations
_visibility   `Visibility`: the table of shadows that a body casts on itself
_sums         the compiled sums over facets, and the closed form of an ellipsoid
"""

from typing import TYPE_CHECKING

from attitude._support.synonyms import of_module
from attitude.light_curve._brightness import brightness, stream
from attitude.light_curve._magnitudes import (
    apparent_magnitude,
    mean_brightness,
    phased_magnitude,
    reduced_magnitude,
)
from attitude.light_curve._visibility import Visibility

__all__ = [
    "Visibility",
    "apparent_magnitude",
    "brightness",
    "mean_brightness",
    "phased_magnitude",
    "reduced_magnitude",
    "stream",
]

if not TYPE_CHECKING:
    # Hidden from type checkers: a module with __getattr__ has every name, misspelt ones too.
    __getattr__ = of_module(__name__)
