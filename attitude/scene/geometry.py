"""The quantities of a view that need no attitude: lines of sight, distances, angles, shadows."""

from __future__ import annotations

from functools import cached_property, partial
from typing import TYPE_CHECKING

import numpy as np

from attitude import epochs, paths
from attitude.errors import AttitudeError
from attitude.immutable import Immutable, frozen, read_only
from attitude.memory import components_first, components_last, new_array
from attitude.paths.path import Path
from attitude.physical_constants import SPEED_OF_LIGHT_M_S
from attitude.scene import angles, lines_of_sight, shadow
from attitude.scene.lazy import kept, quantity
from attitude.scene.light_time import Sightline

if TYPE_CHECKING:
    from astropy.time import Time

    from attitude.annotations import BoolArray, FloatArray
    from attitude.paths.place import Place
    from attitude.scene.lines_of_sight import LineOfSight
    from attitude.scene.scene import Scene
    from attitude.shape import Ellipsoid, Mesh

_XYZ = ("x", "y", "z")
_NO_LOW = frozen(np.zeros(1))


class Geometry(Immutable):
    """Base of `View`: lines of sight, and the quantities that follow from them alone.

    Attributes
    ----------
    scene : Scene
    epoch : Instant
    seconds, low : S arrays (low may be None)
        TDB seconds from `epoch` at which light is received: seconds + low.
    """

    scene: Scene
    epoch: epochs.Instant
    seconds: FloatArray
    low: FloatArray | None

    @property
    def shape(self) -> tuple[int, ...]:
        """S, the shape of the times."""
        return self.seconds.shape

    @kept
    def time(self) -> Time:
        """The epochs of reception as an astropy Time (S) in TDB."""
        return epochs.times(self.epoch, self.seconds, self.low)

    @kept
    def emission_time(self) -> Time:
        """The epochs at which the light left the body as an astropy Time (S) in TDB."""
        hi, lo = self.emission
        rest = None if lo is None else lo.reshape(self.shape)
        return epochs.times(self.epoch, hi.reshape(self.shape), rest)

    # Lines of sight -------------------------------------------------------------------------------

    @kept
    def observer_line(self) -> LineOfSight:
        """The `LineOfSight` from the body at emission to the observer at reception; m."""
        scene = self.scene
        if scene.observer.is_direction:
            return lines_of_sight.fixed(scene.observer)
        found = self._sight(scene.center, scene.observer, sign=-1.0)
        self._refuse_inside(found, scene.observer)
        return found

    @kept
    def emission(self) -> tuple[FloatArray, FloatArray | None]:
        """TDB seconds from `epoch` at which the light leaves the body, hi + lo: flat arrays (N,).

        lo is None for zero.
        """
        hi, lo = self._reception()
        distance = self.observer_line.distance if self.scene.light_time else None
        if distance is None:
            return hi, None if self.low is None else lo
        from attitude.scene import loops

        out = new_array(hi.size), new_array(hi.size)
        loops.earlier(read_only(hi), read_only(lo), read_only(distance), SPEED_OF_LIGHT_M_S, *out)
        return frozen(out[0]), frozen(out[1])

    @kept
    def sun_line(self) -> LineOfSight:
        """The line from the body at emission to the Sun when its light left towards it; m."""
        scene = self.scene
        if scene.sun.is_direction:
            return lines_of_sight.fixed(scene.sun)
        found = self._sight(scene.sun, scene.center, emitted=True)
        self._refuse_inside(found, scene.sun)
        return found

    @kept
    def observer_sun_line(self) -> LineOfSight:
        """The `LineOfSight` from the observer at reception to the Sun when its light left; m."""
        scene = self.scene
        if scene.observer.is_direction:
            raise AttitudeError(
                "the observer is a direction, infinitely far away, where the direction to the Sun "
                "is undefined; give a path as the observer, or use phase_angle."
            )
        if scene.sun.is_direction:
            return lines_of_sight.fixed(scene.sun)
        return self._sight(scene.sun, scene.observer)

    def _reception(self) -> tuple[FloatArray, FloatArray]:
        lo = _NO_LOW if self.low is None else self.low.reshape(-1)
        return self.seconds.reshape(-1), lo

    @cached_property
    def _reception_sample(self) -> lines_of_sight.Sample:
        """The `lines_of_sight.sample` of the epochs of reception."""
        return lines_of_sight.sample(self.epoch, *self._reception())

    @cached_property
    def _emission_sample(self) -> lines_of_sight.Sample:
        """The `lines_of_sight.sample` of the epochs of emission."""
        return lines_of_sight.sample(self.epoch, *self._emission())

    def _emission(self) -> tuple[FloatArray, FloatArray]:
        hi, lo = self.emission
        return hi, _NO_LOW if lo is None else lo

    def _sight(
        self,
        target: Place | str | None,
        viewer: Place | None,
        *,
        emitted: bool = False,
        geometric: bool = False,
        sign: float = 1.0,
    ) -> LineOfSight:
        """The line from a viewer, at reception or emission, to a target; opposite for -1.0."""
        # A Scene without a center has directions only, which have lines of their own.
        assert isinstance(target, (Path, str)) and isinstance(viewer, Path)
        scene, (hi, lo) = self.scene, self._emission() if emitted else self._reception()
        some = self._emission_sample if emitted else self._reception_sample
        path: Path
        if scene.light_time and not geometric:
            path = Sightline(scene.steps(target, viewer), some)
        else:
            path = paths.relative(target, viewer, scene.ephemeris)
        return lines_of_sight.seen(path, self.epoch, hi, lo, some, scene.tolerance, sign)

    def _refuse_inside(self, found: LineOfSight, place: Place) -> None:
        """Raise an AttitudeError if a place comes nearer than the farthest point of the shape."""
        assert found.distance is not None
        radius = _radius(self.scene.shape)
        least = np.nanmin(found.distance, initial=np.inf)
        if least < radius:
            raise AttitudeError(
                f"{place.name} comes to {least:.6g} m from the center, into the "
                f"shape, whose farthest point is {radius:.6g} m from it; check the paths and the "
                "unit of the shape (m)."
            )

    def _rows(self, array: FloatArray) -> FloatArray:
        """A flat array (k, N) or (k, 1) as (S, k)."""
        if array.shape[1] != self.seconds.size:
            array = np.broadcast_to(array, (len(array), self.seconds.size))
        return components_last(array.reshape(len(array), *self.shape))

    def _flat(self, vectors: FloatArray) -> FloatArray:
        """A quantity (S, k) as (k, N)."""
        return components_first(vectors).reshape(vectors.shape[-1], -1)

    def _numbers(self, array: FloatArray) -> FloatArray:
        """A flat array (N,) or (1,) as S."""
        if array.size == self.seconds.size:
            return read_only(array).reshape(self.shape)
        return np.broadcast_to(array, (self.seconds.size,)).reshape(self.shape)

    def _flags(self, array: BoolArray) -> BoolArray:
        """A flat array (N,) as S."""
        return array.reshape(self.shape)

    # Distances and directions ---------------------------------------------------------------------

    @quantity("m")
    def observer_distance(self) -> FloatArray:
        """Distance from the body at emission to the observer at reception; inf for a direction.

        ``light_time`` times the speed of light.
        """
        return self._distance(self.observer_line)

    @quantity("m")
    def sun_distance(self) -> FloatArray:
        """Distance from the body at emission to the Sun as its light left; inf for a direction."""
        return self._distance(self.sun_line)

    @quantity("s")
    def light_time(self) -> FloatArray:
        """observer_distance over the speed of light; 0 if the scene ignores light time."""
        if not self.scene.light_time or self.observer_line.distance is None:
            return np.zeros(self.shape)
        return self.observer_distance / SPEED_OF_LIGHT_M_S

    def _distance(self, found: LineOfSight) -> FloatArray:
        if found.distance is None:
            return self._numbers(np.full(1, np.inf))
        return self._numbers(found.distance)

    @quantity("", _XYZ)
    def observer_direction_icrf(self) -> FloatArray:
        """Unit vector from the body to the observer, ICRF."""
        return self._rows(self.observer_line.unit)

    @quantity("", _XYZ)
    def sun_direction_icrf(self) -> FloatArray:
        """Unit vector from the body to the Sun, ICRF."""
        return self._rows(self.sun_line.unit)

    @quantity("rad")
    def phase_angle(self) -> FloatArray:
        """Angle at the body between Sun and observer, 0 to pi."""
        from attitude.solution.vectors import separation

        sun, observer = read_only(self.sun_line.unit), read_only(self.observer_line.unit)
        return self._numbers(separation(*sun, *observer))

    @quantity("rad", ("longitude", "latitude"))
    def phase_angle_bisector(self) -> FloatArray:
        """Ecliptic (J2000) longitude and latitude of -(s + o), s and o the two unit vectors."""
        return self._rows(angles.bisector(self.sun_line.unit, self.observer_line.unit))

    # Shadow of other bodies -----------------------------------------------------------------------

    @quantity()
    def lit_fraction(self) -> FloatArray:
        """Fraction of the Sun's disc that the bodies of `scene.shadow_of` leave free, 0 to 1."""
        # In parts, whose temporary arrays need no new memory.
        scene, lit = self.scene, np.ones(self.seconds.size)
        for body, radius in scene.shadow_of.items():
            far = scene.sun.is_direction
            found = self._sight(body, scene.center, emitted=True, geometric=far)
            flattening = shadow.flattening_of(body, radius)
            moves = scene.light_time and not far
            for part in angles.parts(lit.size):
                velocity = partial(self._velocity_of, body, part) if moves else None
                occulter, sun = found.some(part), self.sun_line.some(part)
                assert occulter.distance is not None
                lit[part] -= 1.0 - shadow.lit_fraction(
                    occulter.unit * occulter.distance,
                    radius,
                    sun.unit,
                    sun.distance,
                    flattening=flattening,
                    velocity=velocity,
                )
        return self._numbers(np.maximum(lit, 0.0, out=lit))

    def _velocity_of(self, body: str, part: slice, where: BoolArray) -> FloatArray:
        """Barycentric velocities (3, K) of a body at the marked epochs of a part, m/s, ICRF.

        The epochs are those of emission.
        """
        hi, lo = (np.broadcast_to(each, self.seconds.size)[part] for each in self._emission())
        path = paths.relative(body, "ssb", self.scene.ephemeris)
        return np.moveaxis(path.velocity(self.epoch, hi[where], lo[where]), -1, 0)

    @quantity()
    def in_umbra(self) -> BoolArray:
        """Whether no part of the Sun's disc is seen from the body's centre."""
        return self._flags(np.asarray(self.lit_fraction == 0.0).reshape(-1))

    @quantity()
    def in_penumbra(self) -> BoolArray:
        """Whether a part of the Sun's disc is seen from the body's centre, but not all of it."""
        lit = np.asarray(self.lit_fraction)
        return self._flags(((lit > 0.0) & (lit < 1.0)).reshape(-1))


def _radius(shape: Ellipsoid | Mesh | None) -> float:
    """Largest distance of a point of the shape from the centre of mass, m; 0 without a shape."""
    if shape is None:
        return 0.0
    from attitude.shape import Ellipsoid

    if isinstance(shape, Ellipsoid):
        return float(np.max(shape.semi_axes))
    return float(np.max(np.linalg.norm(shape.vertices, axis=-1)))
