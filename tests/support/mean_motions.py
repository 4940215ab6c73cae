"""Bodies, states and orbits that tests of mean rotations share."""

import math

import numpy as np

from attitude import Body, Spin, paths

EPOCH = "2026-01-01"
AU, GM, DAY = 149597870700.0, 3.986004418e14, 86400.0
ENVISAT = Body(moments=(17023.0, 124826.0, 129112.0))


def spinning(omega=(0.039, 0.0052, 0.026), wxyz=(0.8, 0.2, 0.4, 0.4)):
    """A state of the epoch; the default rates are those of a short-axis mode of `ENVISAT`."""
    return Spin(epoch=EPOCH, wxyz=wxyz, angular_velocity=omega)


def circle(radius, first=-1e9, last=1e9, slope=0.0):
    """A circular orbit that is known for a span, inclined by an angle in rad."""

    class Circle(paths.Path):
        name, center, source = "satellite", "earth", "a circle"
        span = tuple(spinning().epoch.after(t) for t in (first, last))

        def position(self, instant, seconds, low=None):
            t = np.asarray(seconds) + (instant.seconds - spinning().epoch.seconds)
            angle = math.sqrt(GM / radius**3) * t
            across = math.cos(slope) * np.sin(angle), math.sin(slope) * np.sin(angle)
            return radius * np.stack([np.cos(angle), *across], axis=-1)

    return Circle()
