"""`View`: a scene at some epochs; each quantity is computed once, at its first use."""

from __future__ import annotations

import inspect
import math
from functools import cached_property, partial
from typing import TYPE_CHECKING, Any, Generic, TypeVar, cast, overload

import numpy as np

from attitude._support import markup
from attitude._support.arrays import (
    Immutable,
    components_first,
    components_last,
    frozen,
    new_array,
    read_only,
)
from attitude._support.constants import MAGNITUDES_PER_E, SPEED_OF_LIGHT_M_S
from attitude._support.pairs import Seconds
from attitude.epochs import _instants
from attitude.errors import AttitudeError
from attitude.frames import quaternion
from attitude.frames import representations as forms
from attitude.motions._history import turned_deviations
from attitude.paths import _composed
from attitude.paths._path import Path
from attitude.scene import _angles, _light_time, _shadow
from attitude.scene._light_time import Sightline

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

    from astropy.time import Time

    from attitude._support.annotations import BoolArray, FloatArray
    from attitude._support.tables import FlatTable
    from attitude.epochs._instants import Instant
    from attitude.motions._body import Body
    from attitude.motions._history import AttitudeHistory
    from attitude.motions._motion import Motion
    from attitude.paths import _path
    from attitude.paths._path import Place
    from attitude.scene._light_time import LineOfSight
    from attitude.scene._scene import Scene
    from attitude.shape._ellipsoid import Ellipsoid
    from attitude.shape._mesh import Mesh


# ---- Properties of a view that are computed at their first use, kept, and listed as evaluated

Value = TypeVar("Value")


class LazyProperty(Generic[Value]):
    """A property of a view, computed once per view; made by `quantity` and `kept`.

    With the unit, the names of the parts of its last axis, whether a table can hold it, one line
    about it.
    """

    name: str

    def __init__(
        self, function: Callable[[Any], Value], unit: str, parts: tuple[str, ...], is_column: bool
    ) -> None:
        self.function = function
        self.unit = unit
        self.parts = parts
        self.is_column = is_column
        self.about = " ".join((function.__doc__ or "").split("\n\n")[0].split())
        self.__doc__ = inspect.cleandoc(function.__doc__ or "")
        if is_column:
            shape = f"(S, {len(parts)}): {', '.join(parts)}" if parts else "S"
            self.__doc__ += f"\n\nShape {shape}; {unit or 'pure number'}."

    def __set_name__(self, owner: type, name: str) -> None:
        self.name = name

    @overload
    def __get__(self, view: None, owner: type) -> LazyProperty[Value]: ...

    @overload
    def __get__(self, view: object, owner: type | None = None) -> Value: ...

    def __get__(self, view: Any, owner: type | None = None) -> Any:
        # Called only until the value is in the __dict__ of the view, which Python looks up first.
        if view is None:
            return self
        value: Any = self.function(view)
        if isinstance(value, np.ndarray):
            value = frozen(value) if value.ndim else value[()]
        view.__dict__[self.name] = value
        view.__dict__["_evaluated"].append(self.name)
        return value

    def __repr__(self) -> str:
        return f"<LazyProperty {self.name}>"


def quantity(
    unit: str = "", parts: Iterable[str] = ()
) -> Callable[[Callable[[Any], Value]], LazyProperty[Value]]:
    """Decorator of a method of a view that returns a number, or a row of `parts`, at each epoch."""
    return lambda function: LazyProperty(function, unit, tuple(parts), True)


def kept(function: Callable[[Any], Value]) -> LazyProperty[Value]:
    """Decorator of a method of a view whose result a table cannot hold as a column."""
    return LazyProperty(function, "", (), False)


# ---- The view

_XYZ = ("x", "y", "z")
_AXES = ("least", "middle", "greatest")
_PLACE = ("longitude", "latitude")
_INVERSE = np.array([[-1.0], [1.0], [1.0], [1.0]])
# Largest error of a fitted zenith, rad: of the sum of some hundred roundings.
_LEAST_TURN = 1e-13
# Least turn over which brightness is differenced, rad: balances rounding and curvature.
_LEAST_STEP = 1e-5
# Cells of the sky along a right angle in the table of shadows of a mesh by default.
_CELLS = 64


def _radius(shape: Ellipsoid | Mesh | None) -> float:
    """Largest distance of a point of the shape from the centre of mass, m; 0 without a shape."""
    if shape is None:
        return 0.0
    from attitude.shape._ellipsoid import Ellipsoid

    if isinstance(shape, Ellipsoid):
        return float(np.max(shape.semi_axes))
    return float(np.max(np.linalg.norm(shape.vertices, axis=-1)))


def _axis_of(axis: FloatArray, direction: FloatArray) -> FloatArray:
    """The unit vectors (N, 3) about which turns bring the axes to the directions, or NaN."""
    across = np.cross(axis, direction)
    size = np.sqrt(np.sum(across * across, axis=-1, keepdims=True))
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.asarray(across / size)


class View(Immutable):
    """What is seen at some epochs of reception.  Made by ``scene.at(times)``.

    S is the shape of the times.  Vectors are (S, 3), views of component-major memory; all arrays
    are read-only; scalar times give scalars.  Radians, metres, seconds.

    Attributes
    ----------
    scene : Scene
    epoch : Instant
    seconds, low : S arrays (low may be None)
        TDB seconds from `epoch` at which light is received: seconds + low.
    """

    scene: Scene
    epoch: _instants.Instant
    seconds: FloatArray
    low: FloatArray | None
    _evaluated: list[str]

    def __init__(
        self, scene: Scene, epoch: Instant, seconds: FloatArray, low: FloatArray | None
    ) -> None:
        seconds, low = Seconds(seconds, low).mapped(frozen)
        self._set_all(scene=scene, epoch=epoch, seconds=seconds, low=low, _evaluated=[])

    def __len__(self) -> int:
        if not self.shape:
            raise TypeError("a view of one scalar epoch has no length")
        return self.shape[0]

    def __repr__(self) -> str:
        return f"<View of {self.seconds.size} epochs; evaluated: {', '.join(self.evaluated)}>"

    def _repr_html_(self) -> str:
        """A table for notebooks: ranges of the quantities that were computed, the light curve."""
        known = self.columns()
        rows = [("epochs", str(self.seconds.size)), ("scene", repr(self.scene))]
        for name in self.evaluated:
            values = np.asarray(getattr(self, name)) if name in known else np.zeros((0, 2))
            finite = values[np.isfinite(values)] if values.dtype.kind == "f" else values[:0]
            if values.shape == self.shape and finite.size:
                ends = f"{finite.min():.6g} to {finite.max():.6g} {known[name].unit}"
                rows.append((name, ends.strip()))
        return markup.table("View", rows, *self._pictures())

    def _pictures(self) -> list[str]:
        """The magnitudes against time, if they were computed."""
        for name in ("magnitude", "reduced_magnitude", "magnitude_everywhere"):
            if name in self.evaluated and self.seconds.ndim == 1 and self.seconds.size > 2:
                line = [(self.seconds - self.seconds[0], np.asarray(getattr(self, name)))]
                caption = f"{name.replace('_', ' ')} over {np.ptp(self.seconds):.4g} s"
                return [markup.line_plot(line, caption, is_downward=True)]
        return []

    # ---- Quantities by name

    @property
    def shape(self) -> tuple[int, ...]:
        """S, the shape of the times."""
        return self.seconds.shape

    @property
    def evaluated(self) -> tuple[str, ...]:
        """Names of the quantities that were computed, in the order of their computation."""
        return tuple(self._evaluated)

    @classmethod
    def columns(cls) -> dict[str, LazyProperty[Any]]:
        """The quantities that a table can hold, by name, with their units, parts, descriptions."""
        return {
            name: value
            for owner in reversed(cls.__mro__)
            for name, value in vars(owner).items()
            if isinstance(value, LazyProperty) and value.is_column
        }

    def table(self, *names: str) -> FlatTable:
        """Some quantities as an astropy QTable, after a column of the times (TDB) of reception.

        Raises
        ------
        AttitudeError
            For a name that is not in `columns`, and for times that are not one-dimensional.
        """
        from astropy.units import Unit

        from attitude._support.tables import FlatTable

        known = self.columns()
        for name in names:
            if not isinstance(name, str) or name not in known:
                raise AttitudeError(
                    f"{name!r} is not a quantity of a view; give some of {', '.join(known)}."
                )
        if len(self.shape) != 1:
            raise AttitudeError(
                f"the times have shape {self.shape}; a table needs times of shape (N,)."
            )
        columns = {"time": self.time}
        for name in names:
            value = np.array(getattr(self, name))
            columns[name] = value * Unit(known[name].unit) if known[name].unit else value
        table = FlatTable(columns, meta={"scene": repr(self.scene), **self.sources})
        for name in names:
            table[name].info.description = known[name].about
            if known[name].parts:
                flat = tuple(f"{name}_{component}" for component in known[name].parts)
                FlatTable.flat_names[name] = flat
        return table

    @property
    def sources(self) -> dict[str, str]:
        """Sources of the positions, by the name of each line of sight that was computed."""
        lines = ("observer_line", "sun_line", "observer_sun_line")
        return {name: self.__dict__[name].source for name in lines if name in self.__dict__}

    # ---- Times of reception and emission

    @kept
    def time(self) -> Time:
        """The epochs of reception as an astropy Time (S) in TDB."""
        return _instants.times(self.epoch, self.seconds, self.low)

    @kept
    def emission_time(self) -> Time:
        """The epochs at which the light left the body as an astropy Time (S) in TDB."""
        return _instants.times(self.epoch, *self.emission.mapped(self._shaped))

    # ---- Lines of sight

    @kept
    def observer_line(self) -> LineOfSight:
        """The `LineOfSight` from the body at emission to the observer at reception; m."""
        scene = self.scene
        if scene.observer.is_direction:
            return _light_time.fixed(scene.observer)
        sight = self._sight(scene.center, scene.observer, sign=-1.0)
        self._refuse_inside(sight, scene.observer)
        return sight

    @kept
    def emission(self) -> Seconds:
        """TDB seconds from `epoch` at which the light leaves the body, hi + lo: flat arrays (N,).

        lo is None for zero.
        """
        left = Seconds.of(self).mapped(np.ravel)
        distance = self.observer_line.distance if self.scene.light_time else None
        if distance is not None:
            hi, lo = map(read_only, left.compact)
            left = Seconds(new_array(hi.size), new_array(hi.size))
            _angles.earlier(hi, lo, read_only(distance), SPEED_OF_LIGHT_M_S, *left)
        return left.mapped(frozen)

    @kept
    def sun_line(self) -> LineOfSight:
        """The line from the body at emission to the Sun when its light left towards it; m."""
        scene = self.scene
        if scene.sun.is_direction:
            return _light_time.fixed(scene.sun)
        sight = self._sight(scene.sun, scene.center, emitted=True)
        self._refuse_inside(sight, scene.sun)
        return sight

    @kept
    def observer_sun_line(self) -> LineOfSight:
        """The `LineOfSight` from the observer at reception to the Sun when its light left; m."""
        scene = self.scene
        self._require_place("Sun", ", or use phase_angle")
        if scene.sun.is_direction:
            return _light_time.fixed(scene.sun)
        return self._sight(scene.sun, scene.observer)

    def _shaped(self, flat: FloatArray) -> FloatArray:
        """Numbers (N,) in the shape S of the epochs."""
        return flat.reshape(self.shape)

    @cached_property
    def _reception_sample(self) -> _light_time.Sample:
        """The `_light_time.sample` of the epochs of reception."""
        return _light_time.sample(self.epoch, *Seconds.of(self).compact)

    @cached_property
    def _emission_sample(self) -> _light_time.Sample:
        """The `_light_time.sample` of the epochs of emission."""
        return _light_time.sample(self.epoch, *self.emission.compact)

    def _sight(self, target, viewer, *, emitted=False, geometric=False, sign=1.0):
        """The line from a viewer, at reception or emission, to a target; opposite for -1.0."""
        # A Scene without a center has directions only, which have lines of their own.
        assert isinstance(target, (Path, str)) and isinstance(viewer, Path)
        scene, (hi, lo) = self.scene, (self.emission if emitted else Seconds.of(self)).compact
        some = self._emission_sample if emitted else self._reception_sample
        if scene.light_time and not geometric:
            path = Sightline(scene.steps(target, viewer), some)
        else:
            path = _composed.relative(target, viewer, scene.ephemeris)
        return _light_time.seen(path, self.epoch, hi, lo, some, scene.tolerance, sign)

    def _refuse_inside(self, line: LineOfSight, place: Place) -> None:
        """Raise an AttitudeError if a place comes nearer than the farthest point of the shape."""
        assert line.distance is not None
        radius = _radius(self.scene.shape)
        least = np.nanmin(line.distance, initial=np.inf)
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

    # ---- Distances and directions

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

    def _distance(self, line: LineOfSight) -> FloatArray:
        if line.distance is None:
            return self._numbers(np.full(1, np.inf))
        return self._numbers(line.distance)

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
        return self._numbers(_angles.between_units(self.sun_line.unit, self.observer_line.unit))

    @quantity("rad", _PLACE)
    def phase_angle_bisector(self) -> FloatArray:
        """Ecliptic (J2000) longitude and latitude of -(s + o), s and o the two unit vectors."""
        return self._rows(_angles.bisector(self.sun_line.unit, self.observer_line.unit))

    # ---- Shadow of other bodies

    @quantity()
    def lit_fraction(self) -> FloatArray:
        """Fraction of the Sun's disc that the bodies of `scene.shadow_of` leave free, 0 to 1."""
        # In parts, whose temporary arrays need no new memory.
        scene, lit = self.scene, 1.0 + 0.0 * self.seconds.ravel()  # NaN at epochs that are NaN
        for body, radius in scene.shadow_of.items():
            far = scene.sun.is_direction
            shares = self._sight(body, scene.center, emitted=True, geometric=far)
            flattening = _shadow.flattening_of(body, radius)
            moves = scene.light_time and not far
            for block in _angles.parts(lit.size):
                velocity = partial(self._velocity_of, body, block) if moves else None
                occulter, sun = shares.some(block), self.sun_line.some(block)
                assert occulter.distance is not None
                lit[block] -= 1.0 - _shadow.lit_fraction(
                    occulter.unit * occulter.distance,
                    radius,
                    sun.unit,
                    sun.distance,
                    flattening=flattening,
                    velocity=velocity,
                )
        return self._numbers(np.maximum(lit, 0.0, out=lit))

    def _velocity_of(self, body: str, block: slice, where: BoolArray) -> FloatArray:
        """Barycentric velocities (3, K), m/s, ICRF, of a body at marked epochs of emission."""
        hi, lo = self.emission.taken(block).flat
        return self._velocity(body, hi[where], lo[where])

    def _velocity(self, body: str | Path, hi: FloatArray, lo: FloatArray) -> FloatArray:
        """Barycentric velocities (3, N) at epochs hi + lo (N,), m/s, ICRF."""
        path = _composed.relative(body, "ssb", self.scene.ephemeris)
        return np.moveaxis(path.velocity(self.epoch, hi, lo), -1, 0)

    @quantity()
    def in_umbra(self) -> BoolArray:
        """Whether no part of the Sun's disc is seen from the body's centre."""
        return np.asarray(self.lit_fraction == 0.0)

    @quantity()
    def in_penumbra(self) -> BoolArray:
        """Whether a part of the Sun's disc is seen from the body's centre, but not all of it."""
        lit = np.asarray(self.lit_fraction)
        return (lit > 0.0) & (lit < 1.0)

    # ---- Attitude, and directions in body axes

    @kept
    def attitude(self) -> AttitudeHistory:
        """The AttitudeHistory (S) of the body at the epochs of emission."""
        return self._motion().at_seconds(*self.emission.mapped(self._shaped))

    def _motion(self) -> Motion:
        if self.scene.motion is None:
            raise AttitudeError(
                "the attitude of the body is needed, but the scene was made with motion=None; "
                "give a motion, or use quantities that need none, such as sun_direction_icrf or "
                "phase_angle."
            )
        return self.scene.motion

    def _wxyz(self) -> FloatArray:
        return read_only(np.ascontiguousarray(self._flat(self.attitude.wxyz)))

    def _in_body(self, unit: FloatArray) -> FloatArray:
        """ICRF vectors (3, N) or (3, 1) as (3, N) in body axes."""
        from attitude._solver import vectors as solver_vectors

        out = new_array(3, self.seconds.size)
        solver_vectors.to_body(self._wxyz(), read_only(np.ascontiguousarray(unit)), out)
        return out

    def _in_icrf(self, vector: FloatArray) -> FloatArray:
        """A body vector (3,) as (3, N) in ICRF."""
        from attitude._solver import vectors as solver_vectors

        wxyz, column = self._wxyz(), read_only(vector.reshape(3, 1).copy())
        out = new_array(3, self.seconds.size)
        for block in _angles.parts(out.shape[1]):
            # with -w the inverse rotation
            inverse, turned = wxyz[:, block] * _INVERSE, np.empty((3, out[0, block].size))
            solver_vectors.to_body(frozen(inverse), column, turned)
            out[:, block] = turned
        return out

    @quantity("", _XYZ)
    def observer_direction(self) -> FloatArray:
        """Unit vector from the body to the observer, body axes."""
        return self._rows(self._in_body(self.observer_line.unit))

    @quantity("", _XYZ)
    def sun_direction(self) -> FloatArray:
        """Unit vector from the body to the Sun, body axes."""
        return self._rows(self._in_body(self.sun_line.unit))

    @quantity("rad", _PLACE)
    def sub_observer(self) -> FloatArray:
        """East longitude (0 to 2 pi, x towards y) and latitude (to z) of observer_direction."""
        return self._rows(_angles.longitude_and_latitude(self._flat(self.observer_direction)))

    @quantity("rad", _PLACE)
    def sub_solar(self) -> FloatArray:
        """East longitude (0 to 2 pi, x towards y) and latitude (to z) of sun_direction."""
        return self._rows(_angles.longitude_and_latitude(self._flat(self.sun_direction)))

    @kept
    def momentum_direction_icrf(self) -> FloatArray:
        """Unit vector (3, N) or (3, 1) of the angular momentum, ICRF; (3, 1) if it is constant."""
        momentum = self._momentum()
        size = np.sqrt(np.sum(momentum * momentum, axis=0))
        if np.any(size == 0.0):
            raise AttitudeError(
                "the body is at rest, so that its angular momentum has no direction; use angles to "
                "its axes instead."
            )
        return momentum / size

    def _momentum(self) -> FloatArray:
        """Angular momentum (3, N), ICRF; (3, 1) if it is constant."""
        motion = self._motion()
        if motion.momentum is not None:
            return np.asarray(motion.momentum, dtype=np.float64)[:, None]
        in_body = motion.momentum_in_body(self.attitude)
        return self._flat(self.attitude.body_to_inertial(in_body))

    @quantity("rad")
    def aspect_angle(self) -> FloatArray:
        """Angle between the direction to the observer and the angular momentum, 0 to pi."""
        return self._angle_to_momentum(self.observer_line.unit)

    @quantity("rad")
    def sun_aspect_angle(self) -> FloatArray:
        """Angle between the direction to the Sun and the angular momentum, 0 to pi."""
        return self._angle_to_momentum(self.sun_line.unit)

    def _angle_to_momentum(self, unit: FloatArray) -> FloatArray:
        return self._numbers(_angles.between_units(unit, self.momentum_direction_icrf))

    @quantity("rad")
    def obliquity(self) -> FloatArray:
        """Angle from the angular momentum to that of the orbit about its center, 0 to pi.

        A path about the barycentre of the solar system is taken about the Sun.
        """
        from attitude.motions._axes import obliquity

        scene, pole = self.scene, self.momentum_direction_icrf
        if scene.center is None:
            raise AttitudeError(
                "the scene has no center, whose orbit the obliquity needs; give center=, a path."
            )
        hi, lo = self.emission.flat
        return self._numbers(obliquity(pole.T, scene.center, self.epoch, hi, lo))

    @quantity("rad", _AXES)
    def observer_axis_angles(self) -> FloatArray:
        """Angles from the direction to the observer to the principal axes, 0 to pi.

        The axes are in ascending order of their moments of inertia, in the senses of the columns of
        ``body.principal_axes``.
        """
        return self._axis_angles(self.observer_direction)

    @quantity("rad", _AXES)
    def sun_axis_angles(self) -> FloatArray:
        """Angles from the direction to the Sun to the principal axes, 0 to pi.

        The axes are in ascending order of their moments of inertia, in the senses of the columns of
        ``body.principal_axes``.
        """
        return self._axis_angles(self.sun_direction)

    def _axis_angles(self, direction: FloatArray) -> FloatArray:
        body = self._body("a principal axis")
        order = np.argsort(body.moments, kind="stable")
        flat, rows = self._flat(direction), new_array(3, self.seconds.size)
        for row, k in zip(rows, order, strict=True):
            row[:] = _angles.between_units(body.principal_axes[:, [k]], flat)
        return self._rows(rows)

    def _body(self, what: str) -> Body:
        return self._motion().constant_body(what)

    def _long_axis(self) -> FloatArray:
        """Unit vector (3,) in body axes of the axis of least moment of inertia."""
        body = self._body("the long axis")
        least = body.moments == body.moments.min()
        if np.sum(least) > 1:
            raise AttitudeError(
                f"the body has no long axis: {np.sum(least)} of its moments of inertia are the "
                "least one; use the angles to other axes."
            )
        return body.principal_axes[:, int(np.argmax(least))]

    # ---- What the observer measures on the sky

    @kept
    def observer_velocity(self) -> FloatArray:
        """Barycentric velocity (3, N) of the observer at the epochs of reception, m/s, ICRF."""
        # An observer that is a direction is refused by `relative`.
        return self._velocity(cast("Path", self.scene.observer), *Seconds.of(self).compact)

    def _seen(self, unit: FloatArray) -> FloatArray:
        """Directions (3, N) from the observer, aberrated if the scene has aberration=True."""
        if not self.scene.aberration or self.scene.observer.is_direction:
            return unit
        return _angles.aberrated(unit, self.observer_velocity, SPEED_OF_LIGHT_M_S)

    @quantity("", _XYZ)
    def apparent_direction(self) -> FloatArray:
        """Unit vector from the observer to the body, ICRF; aberrated if aberration=True."""
        return self._rows(self._seen(-self.observer_line.unit))

    @quantity("rad", ("right_ascension", "declination"))
    def apparent_position(self) -> FloatArray:
        """Right ascension (0 to 2 pi) and declination of apparent_direction, ICRF."""
        return self._rows(_angles.longitude_and_latitude(self._flat(self.apparent_direction)))

    @quantity("rad")
    def solar_elongation(self) -> FloatArray:
        """Angle at the observer between the Sun and the body, 0 to pi."""
        body = self._flat(self.apparent_direction)
        sun = self._seen(self.observer_sun_line.unit)
        return self._numbers(_angles.between_units(body, sun))

    @quantity("rad")
    def long_axis_position_angle(self) -> FloatArray:
        """Angle on the sky from north (ICRF) through east to the positive long axis, 0 to 2 pi."""
        axis = self._in_icrf(self._long_axis())
        return self._numbers(_angles.position_angle(axis, self._flat(self.apparent_direction)))

    @quantity("rad")
    def elevation(self) -> FloatArray:
        """Elevation of the body above the horizon of a ground site, -pi/2 to pi/2, unrefracted."""
        return self._elevation_of(self._flat(self.apparent_direction))

    @kept
    def zenith(self) -> FloatArray:
        """Unit vectors (3, N) to the zenith of a ground site at the epochs of reception, ICRF."""
        return self._axis_of_earth(self.scene.observer.zenith_path)

    def _axis_of_earth(self, path: _path.Path) -> FloatArray:
        """Unit vectors (3, N) of a direction that rests on the Earth, at reception, ICRF."""
        hi, lo = Seconds.of(self).compact
        scene, some = self.scene, self._reception_sample
        tolerance = None if scene.tolerance is None else _LEAST_TURN
        return _light_time.seen(path, self.epoch, hi, lo, some, tolerance).unit

    def _elevation_of(self, direction: FloatArray) -> FloatArray:
        return self._numbers(0.5 * np.pi - _angles.between_units(self.zenith, direction))

    @quantity("rad")
    def azimuth(self) -> FloatArray:
        """Azimuth of the body at a ground site, from north through east, 0 to 2 pi."""
        direction = self._flat(self.apparent_direction)
        north = self._axis_of_earth(self.scene.observer.pole_path)
        east = np.cross(north, self.zenith, axis=0)
        along = (np.sum(axis * direction, axis=0) for axis in (east, north))
        return self._numbers(_angles.turned_positive(np.arctan2(*along)))

    # ---- The sky of a ground site

    @quantity("rad")
    def sun_elevation(self) -> FloatArray:
        """Elevation of the Sun's centre above the horizon of a ground site, unrefracted."""
        zenith = self.zenith  # an observer without a horizon is refused first
        sun = np.broadcast_to(self.observer_sun_line.unit, zenith.shape)
        return self._elevation_of(self._seen(sun))

    @kept
    def moon_line(self) -> LineOfSight:
        """The `LineOfSight` from the observer at reception to the Moon when its light left; m."""
        self._require_place("Moon")
        return self._sight("moon", self.scene.observer)

    def _require_place(self, body: str, more: str = "") -> None:
        """AttitudeError for an observer that is a direction, from which no body is seen."""
        if self.scene.observer.is_direction:
            raise AttitudeError(
                f"the observer is a direction, infinitely far away, where the direction to the "
                f"{body} is undefined; give a path as the observer{more}."
            )

    @quantity("rad")
    def moon_elevation(self) -> FloatArray:
        """Elevation of the Moon's centre above the horizon of a ground site, unrefracted."""
        zenith = self.zenith
        return self._elevation_of(self._seen(np.broadcast_to(self.moon_line.unit, zenith.shape)))

    @quantity("rad")
    def moon_separation(self) -> FloatArray:
        """Angle at the observer between the Moon's centre and the body, 0 to pi."""
        body = self._flat(self.apparent_direction)
        moon = self._seen(self.moon_line.unit)
        return self._numbers(_angles.between_units(body, moon))

    @quantity()
    def airmass(self) -> FloatArray:
        """Relative air mass towards the body by Young (1994), 1 at the zenith; NaN below 0 deg."""
        return _angles.air_mass(self.elevation)

    @quantity()
    def sky_dark(self) -> BoolArray:
        """Whether the Sun at a ground site is lower than ``scene.night``."""
        return np.asarray(self.sun_elevation < self.scene.night)

    @quantity()
    def is_observable(self) -> BoolArray:
        """Whether a ground site has the body above its horizon, and a dark sky; True elsewhere."""
        if not self.scene.observer.has_horizon:
            return ~np.isnan(self.seconds)
        return np.asarray((self.elevation > 0.0) & self.sky_dark)

    # ---- Brightness and magnitudes

    @quantity("m2 / sr")
    def brightness(self) -> FloatArray:
        """Intensity towards the observer over the Sun's irradiance on the body, in sunlight."""
        scene = self.scene
        if scene.shape is None:
            raise AttitudeError(
                "brightness needs a shape, and the scene has none; give it shape=, an Ellipsoid or "
                "Mesh of attitude.shape."
            )
        sun, observer = (self._flat(v) for v in (self.sun_direction, self.observer_direction))
        known = np.flatnonzero(np.isfinite(sun[0]))
        if known.size == self.seconds.size:
            return self._numbers(self._brightness_of(sun.T, observer.T))
        sun, observer = np.ascontiguousarray(sun[:, known]), observer[:, known]
        brightness = np.full(self.seconds.size, np.nan)
        brightness[known] = self._brightness_of(sun.T, observer.T)
        return self._numbers(brightness)

    def _brightness_of(self, sun: FloatArray, observer: FloatArray) -> FloatArray:
        """The brightness (K,) of the shape for directions (K, 3) in body axes."""
        from attitude.light_curve import _brightness

        scene = self.scene
        assert scene.shape is not None  # `brightness` refuses a scene without one
        return _brightness.brightness(
            scene.shape, scene.law, sun, observer, shadows=scene.shadows, threads=scene.threads
        )

    @quantity("mag")
    def reduced_magnitude(self) -> FloatArray:
        """Magnitude at 1 au from Sun and observer, V(1, 1, alpha), in full sunlight."""
        from attitude.light_curve import _magnitudes

        bright, scene = np.asarray(self.brightness).reshape(-1), self.scene
        known = ~np.isnan(bright)
        out = np.full(bright.size, np.nan)
        if not known.any():
            return self._numbers(out)
        if scene.phase_function is None:
            band = _magnitudes.SUN_V if scene.sun_magnitude is None else scene.sun_magnitude
            out[known] = _magnitudes.reduced_magnitude(bright[known], sun_magnitude=band)
        else:
            assert scene.shape is not None  # `brightness` refuses a scene without one
            angles = np.asarray(self.phase_angle).reshape(-1)[known]
            out[known] = _magnitudes.phased_magnitude(
                bright[known], scene.shape, scene.law, angles, scene.phase_function
            )
        return self._numbers(out)

    @quantity("mag")
    def magnitude(self) -> FloatArray:
        """Apparent magnitude, in the shadow that other bodies cast; inf where nothing is seen.

        From a ground site NaN by day and below the horizon, unless site_limits=False.
        """
        return self.as_observed(self.magnitude_everywhere)

    def as_observed(self, magnitude: FloatArray) -> FloatArray:
        """Magnitudes (S), NaN where a ground site with limits does not observe."""
        scene = self.scene
        if not (scene.site_limits and scene.observer.has_horizon):
            return np.array(magnitude)[()]
        return np.where(self.is_observable, magnitude, np.nan)[()]

    @kept
    def magnitude_everywhere(self) -> FloatArray:
        """`magnitude` (S), whether or not a ground site observes the body."""
        from attitude.light_curve import _magnitudes

        for line, name in ((self.sun_line, "sun"), (self.observer_line, "observer")):
            if line.distance is None:
                raise AttitudeError(
                    f"the {name} is a direction, infinitely far away, for which an apparent "
                    "magnitude is undefined; use reduced_magnitude, or give a path."
                )
        magnitudes = np.array(self.reduced_magnitude).reshape(-1)
        known = ~np.isnan(magnitudes)
        far = [
            np.asarray(distance).reshape(-1)[known]
            for distance in (self.sun_distance, self.observer_distance)
        ]
        magnitudes[known] += _magnitudes.distance_modulus(*far)
        if self.scene.shadow_of:
            magnitudes += _magnitudes.shadow_dimming(self.lit_fraction.reshape(-1))
        return self._numbers(magnitudes)

    # ---- Standard deviations, from the covariance of the motion's spin
    # A quantity changes with a small turn of the body by its gradient times the rotation vector, to
    # first order.  The gradient is in closed form but for brightness, which is differenced.  Paths
    # are exact.

    @kept
    def turn_covariance(self) -> FloatArray:
        """Covariance (N, 3, 3) of the attitudes at emission: rotation vectors, rad, ICRF axes."""
        return self.attitude.attitude_covariance.reshape(-1, 3, 3)

    def _in_rows(self, direction: FloatArray) -> FloatArray:
        """Directions (3, N) or (3, 1) as (N, 3)."""
        return np.broadcast_to(direction, (3, self.seconds.size)).T

    # ---- Those of directions

    @quantity("", _XYZ)
    def observer_direction_sigma(self) -> FloatArray:
        """Standard deviations of the components of observer_direction."""
        return self.attitude.inertial_to_body_sigma(self.observer_direction_icrf)

    @quantity("", _XYZ)
    def sun_direction_sigma(self) -> FloatArray:
        """Standard deviations of the components of sun_direction."""
        return self.attitude.inertial_to_body_sigma(self.sun_direction_icrf)

    @quantity("rad", _PLACE)
    def sub_observer_sigma(self) -> FloatArray:
        """Standard deviations of longitude and latitude of sub_observer."""
        return self._place_deviations(self.observer_direction)

    @quantity("rad", _PLACE)
    def sub_solar_sigma(self) -> FloatArray:
        """Standard deviations of longitude and latitude of sub_solar."""
        return self._place_deviations(self.sun_direction)

    def _place_deviations(self, direction: FloatArray) -> FloatArray:
        x, y, z = self._flat(direction)
        with np.errstate(divide="ignore", invalid="ignore"):
            across = np.hypot(x, y)
            by_longitude = np.stack([x * z / across**2, y * z / across**2, -np.ones(x.size)])
            by_latitude = np.stack([-y / across, x / across, np.zeros(x.size)])
        wxyz = self._flat(self.attitude.wxyz).T
        deviations = [
            turned_deviations(self.turn_covariance, quaternion.rotate(wxyz, gradient.T))
            for gradient in (by_longitude, by_latitude)
        ]
        return self._rows(np.stack(deviations))

    # ---- Those of angles

    @quantity("rad")
    def phase_angle_sigma(self) -> FloatArray:
        """Standard deviation of phase_angle: 0, since it does not depend on the attitude."""
        return np.where(np.isnan(self.seconds), np.nan, 0.0)

    @quantity("rad")
    def aspect_angle_sigma(self) -> FloatArray:
        """Standard deviation of aspect_angle; NaN where the angle is 0 or pi."""
        return self._angle_to_momentum_deviations(self.observer_line.unit)

    @quantity("rad")
    def sun_aspect_angle_sigma(self) -> FloatArray:
        """Standard deviation of sun_aspect_angle; NaN where the angle is 0 or pi."""
        return self._angle_to_momentum_deviations(self.sun_line.unit)

    def _angle_to_momentum_deviations(self, unit: FloatArray) -> FloatArray:
        motion = self._motion()
        if motion.momentum is None:
            covariance = motion.momentum_covariance_at(*self.emission.flat)
        else:
            covariance = motion.momentum_covariance
        axis = self._in_rows(self.momentum_direction_icrf)
        tilt = np.cross(axis, _axis_of(axis, self._in_rows(unit)))
        size = np.linalg.norm(self._momentum(), axis=0)
        return self._numbers(turned_deviations(covariance, tilt) / size)

    @quantity("rad", _AXES)
    def observer_axis_angles_sigma(self) -> FloatArray:
        """Standard deviations of observer_axis_angles; NaN where an angle is 0 or pi."""
        return self._axis_deviations(self.observer_line.unit)

    @quantity("rad", _AXES)
    def sun_axis_angles_sigma(self) -> FloatArray:
        """Standard deviations of sun_axis_angles; NaN where an angle is 0 or pi."""
        return self._axis_deviations(self.sun_line.unit)

    def _axis_deviations(self, unit: FloatArray) -> FloatArray:
        body = self._body("a principal axis")
        direction = self._in_rows(unit)
        deviations = []
        for k in np.argsort(body.moments, kind="stable"):
            axis = self._in_icrf(body.principal_axes[:, k]).T
            deviations.append(turned_deviations(self.turn_covariance, _axis_of(axis, direction)))
        return self._rows(np.stack(deviations))

    @quantity("rad")
    def long_axis_position_angle_sigma(self) -> FloatArray:
        """Standard deviation of long_axis_position_angle; NaN for an axis along the line."""
        axis = self._in_icrf(self._long_axis()).T
        sight = self._flat(self.apparent_direction).T
        # The part across the line of sight turns about that line.
        across_sight = axis - np.sum(axis * sight, axis=-1, keepdims=True) * sight
        across = np.cross(sight, across_sight)
        with np.errstate(divide="ignore", invalid="ignore"):
            square = np.sum(across_sight * across_sight, axis=-1, keepdims=True)
            gradient = np.cross(axis, across) / square
        return self._numbers(turned_deviations(self.turn_covariance, gradient))

    # ---- Those of brightness

    @quantity("m2 / sr")
    def brightness_sigma(self) -> FloatArray:
        """Standard deviation of brightness, by differences over one standard deviation."""
        bright = np.asarray(self.brightness).reshape(-1)
        known = np.flatnonzero(np.isfinite(bright))
        out = np.full(bright.size, np.nan)
        if not known.size:
            return self._numbers(out)
        to_icrf = quaternion.matrix(self._flat(self.attitude.wxyz).T[known])
        covariance = np.swapaxes(to_icrf, -1, -2) @ self.turn_covariance[known] @ to_icrf
        values, axes = np.linalg.eigh(covariance)
        size = np.sqrt(np.maximum(values, 0.0))
        step = np.maximum(size, self._least_step())
        pair = [self._flat(v).T[known] for v in (self.sun_direction, self.observer_direction)]
        total = np.zeros(known.size)
        for k in range(3):
            turn = forms.from_rotation_vector(axes[:, :, k] * step[:, [k]])
            ahead = self._brightness_of(*(quaternion.rotate(turn, v) for v in pair))
            back = quaternion.conjugate(turn)
            behind = self._brightness_of(*(quaternion.rotate(back, v) for v in pair))
            total += (0.5 * (ahead - behind) * (size[:, k] / step[:, k])) ** 2
        out[known] = np.sqrt(total)
        return self._numbers(out)

    def _least_step(self) -> float:
        """The least turn that the brightness of the shape resolves, rad."""
        from attitude.light_curve._visibility import Visibility
        from attitude.shape._mesh import Mesh

        shape, shadows = self.scene.shape, self.scene.shadows
        if not isinstance(shape, Mesh) or shape.is_convex or shadows is False:
            return _LEAST_STEP
        cells = shadows.resolution if isinstance(shadows, Visibility) else _CELLS
        return 0.5 * math.pi / cells

    @quantity("mag")
    def reduced_magnitude_sigma(self) -> FloatArray:
        """Standard deviation of reduced_magnitude; NaN where nothing is seen."""
        return self._magnitude_deviations(self.reduced_magnitude)

    @quantity("mag")
    def magnitude_sigma(self) -> FloatArray:
        """Standard deviation of magnitude; NaN where nothing is seen."""
        return self._magnitude_deviations(self.magnitude)

    def _magnitude_deviations(self, magnitude: FloatArray) -> FloatArray:
        with np.errstate(divide="ignore", invalid="ignore"):
            relative = np.asarray(self.brightness_sigma) / self.brightness
        return np.where(np.isfinite(magnitude), MAGNITUDES_PER_E * relative, np.nan)
