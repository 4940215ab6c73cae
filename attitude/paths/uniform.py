"""The simplest paths: a point at rest or in uniform motion; and directions without a distance."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from attitude import epochs, frames, validation
from attitude.epochs.inputs import Instant
from attitude.immutable import Immutable, frozen
from attitude.paths.bodies import SSB, body_name
from attitude.paths.path import Path, since
from attitude.paths.place import Place
from attitude.validation import unit_vector

if TYPE_CHECKING:
    from attitude.annotations import Epoch, FloatArray, Reals

_J2000 = Instant(0.0)


@dataclass(frozen=True, eq=False, repr=False)
class Uniform(Immutable, Path):
    """Uniform motion r(t) = start + speed (t - epoch).  Made by `uniform` and `fixed`.

    Attributes
    ----------
    start, speed : (3,) float64 arrays, read-only
        m at the epoch and m/s, ICRF axes.
    epoch : Instant
    name, center, source
        As for all paths.
    """

    start: FloatArray
    speed: FloatArray
    epoch: Instant
    center: str | Path
    name: str
    source: str = "uniform motion"

    def __post_init__(self) -> None:
        frozen(self.start)
        frozen(self.speed)

    @property
    def is_fixed(self) -> bool:
        """Whether the point rests relative to its center."""
        return not self.speed.any()

    def _position(self, instant, hi, lo):
        if self.is_fixed:
            return np.repeat(self.start[:, None], hi.size, axis=1)
        base = since(instant, self.epoch)
        seconds = (base[0] + hi) + (base[1] + lo)
        # The rounding error of that sum: at 1e9 s, 1e-7 s at a velocity of 30 km/s are 3 mm.
        whole = base[0] + hi
        part = whole - hi
        rest = (base[0] - part) + (hi - (whole - part))
        rest += (whole - seconds) + (base[1] + lo)
        return self.start[:, None] + (self.speed[:, None] * seconds + self.speed[:, None] * rest)

    def _state(self, instant, hi, lo):
        return self._position(instant, hi, lo), np.repeat(self.speed[:, None], hi.size, axis=1)


def uniform(
    position: Reals,
    velocity: Reals,
    epoch: Epoch,
    *,
    center: Path | str | int = SSB,
    frame: str = "icrf",
    name: str = "uniform motion",
) -> Uniform:
    """The path of uniform motion: r(t) = position + velocity (t - epoch).

    Parameters
    ----------
    position, velocity : (3,) array_like or Quantity
        m and m/s relative to the center, at the epoch.
    epoch : anything that `epochs.instant` takes
    center : Path, str or int
        A path, or a body by name or NAIF number.
    frame : str
        Axes of position and velocity, one of `frames.FRAMES`.
    name : str
        For messages.

    Raises
    ------
    AttitudeError
        For other shapes, units, names, and numbers that are not finite.
    """
    matrix = frames.matrix_to_icrf(frame)
    position = validation.real(position, "position", shape=(3,), unit="m")
    velocity = validation.real(velocity, "velocity", shape=(3,), unit="m/s")
    start = epochs.instant(epoch)
    return Uniform(matrix @ position, matrix @ velocity, start, known_center(center), name)


def fixed(
    position: Reals,
    *,
    center: Path | str | int = SSB,
    frame: str = "icrf",
    name: str = "fixed point",
) -> Uniform:
    """The path of a point that rests relative to its center.

    Parameters
    ----------
    position : (3,) array_like or Quantity
        m relative to the center.
    center, frame, name
        See `uniform`.

    Raises
    ------
    AttitudeError
        For other shapes, units, names, and numbers that are not finite.
    """
    position = validation.real(position, "position", shape=(3,), unit="m")
    turned = frames.matrix_to_icrf(frame) @ position
    return Uniform(turned, np.zeros(3), _J2000, known_center(center), name, "fixed point")


@dataclass(frozen=True, eq=False, repr=False)
class Direction(Immutable, Place):
    """Something infinitely far away: a Sun or an observer in a constant direction.

    A direction has no position; `is_direction` distinguishes it from a path, so that a scene opens
    no ephemeris for it.  Made by `direction`.

    Attributes
    ----------
    unit : (3,) float64 array, read-only
        Unit vector towards it from any place, ICRF axes.
    name : str
    """

    unit: FloatArray
    name: str = "direction"

    is_direction = True

    def __post_init__(self) -> None:
        frozen(self.unit)

    def __repr__(self) -> str:
        x, y, z = self.unit.tolist()
        return f"<{self.name}, infinitely far towards ({x:.6g}, {y:.6g}, {z:.6g})>"


def direction(vector: Reals, *, frame: str = "icrf", name: str = "direction") -> Direction:
    """A place infinitely far away in the direction of a vector.

    Parameters
    ----------
    vector : (3,) array_like
        Of any length but zero.
    frame : str
        Axes of the vector, one of `frames.FRAMES`.
    name : str
        For messages.

    Raises
    ------
    AttitudeError
        For a zero vector, another shape, a frame that is not known.

    >>> direction((0, 0, 2), name="Sun")
    <Sun, infinitely far towards (0, 0, 1)>
    """
    return Direction(frames.matrix_to_icrf(frame) @ unit_vector(vector, "vector"), name)


def known_center(center: Path | str | int) -> Path | str:
    """A center as paths hold it: a path, or the name of a body as `bodies.body_name` spells it."""
    return center if isinstance(center, Path) else body_name(center, "center")
