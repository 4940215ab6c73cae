"""The simplest paths: a point that rests or moves uniformly, and what is infinitely far away."""

from dataclasses import dataclass

import numpy as np

from attitude import epochs, frames, validation
from attitude.epochs.inputs import Instant
from attitude.immutable import Immutable, frozen
from attitude.paths.bodies import SSB, body_name
from attitude.paths.path import Path, since
from attitude.paths.place import Place
from attitude.validation import unit_vector

_J2000 = Instant(0.0)


@dataclass(frozen=True, eq=False, repr=False)
class Uniform(Immutable, Path):
    """r(t) = position + velocity (t - epoch): uniform motion.  Made by `uniform` and `fixed`."""

    start: np.ndarray
    speed: np.ndarray
    epoch: Instant
    center: str | Path
    name: str
    source: str = "uniform motion"

    def __post_init__(self):
        frozen(self.start)
        frozen(self.speed)

    @property
    def is_fixed(self):
        """Whether it rests relative to its center."""
        return not self.speed.any()

    def _position(self, instant, hi, lo):
        if self.is_fixed:
            return np.repeat(self.start[:, None], hi.size, axis=1)
        base = since(instant, self.epoch)
        seconds = (base[0] + hi) + (base[1] + lo)
        # What that sum rounded off: at 1e9 s, 1e-7 s of a velocity of 30 km/s are 3 mm.
        whole = base[0] + hi
        part = whole - hi
        rest = (base[0] - part) + (hi - (whole - part))
        rest += (whole - seconds) + (base[1] + lo)
        return self.start[:, None] + (self.speed[:, None] * seconds + self.speed[:, None] * rest)

    def _state(self, instant, hi, lo):
        return self._position(instant, hi, lo), np.repeat(self.speed[:, None], hi.size, axis=1)


def uniform(position, velocity, epoch, *, center=SSB, frame="icrf", name="uniform motion"):
    """The path of uniform motion: r(t) = position + velocity (t - epoch).

    Parameters
    ----------
    position, velocity : (3,) array_like or Quantity
        m and m/s relative to the center, at the epoch.
    epoch : anything that `epochs.instant` takes
    center : Path, str or int
    frame : str
        Axes of position and velocity, one of `frames.FRAMES`.

    Raises
    ------
    AttitudeError
        For other shapes, units, names, and numbers that are not finite.
    """
    matrix = frames.matrix_to_icrf(frame)
    position = validation.real(position, "position", shape=(3,), unit="m")
    velocity = validation.real(velocity, "velocity", shape=(3,), unit="m/s")
    epoch = epochs.instant(epoch)
    return Uniform(matrix @ position, matrix @ velocity, epoch, known_center(center), name)


def fixed(position, *, center=SSB, frame="icrf", name="fixed point"):
    """The path of a point that rests relative to its center; see `uniform`."""
    position = validation.real(position, "position", shape=(3,), unit="m")
    turned = frames.matrix_to_icrf(frame) @ position
    return Uniform(turned, np.zeros(3), _J2000, known_center(center), name, "fixed point")


@dataclass(frozen=True, eq=False, repr=False)
class Direction(Immutable, Place):
    """Something infinitely far away: a Sun or an observer that is always seen the same way.

    It has no position; `is_direction` tells it from a path, so that nothing is asked of an
    ephemeris.  Made by `direction`.

    Attributes
    ----------
    unit : (3,) float64 array, read-only
        From whatever looks towards it, ICRF axes.
    name : str
    """

    unit: np.ndarray
    name: str = "direction"

    is_direction = True

    def __post_init__(self):
        frozen(self.unit)

    def __repr__(self):
        x, y, z = self.unit.tolist()
        return f"<{self.name}, infinitely far towards ({x:.6g}, {y:.6g}, {z:.6g})>"


def direction(vector, *, frame="icrf", name="direction"):
    """What is infinitely far away in the direction of a vector.

    Parameters
    ----------
    vector : (3,) array_like
        Of any length but zero.
    frame : str
        Its axes, one of `frames.FRAMES`.

    >>> direction((0, 0, 2), name="Sun")
    <Sun, infinitely far towards (0, 0, 1)>
    """
    return Direction(frames.matrix_to_icrf(frame) @ unit_vector(vector, "vector"), name)


def known_center(center):
    """A center as paths carry it: a path, or the one name of a body."""
    return center if isinstance(center, Path) else body_name(center, "center")
