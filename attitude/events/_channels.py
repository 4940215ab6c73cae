"""Channels of body axes and directions, and the conditions that are made of them.

A channel is a smooth function of time that knows upper bounds of its first two derivatives, from
the rates of the motion and the drift of its directions.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from attitude._support import validation
from attitude._support.constants import ASTRONOMICAL_UNIT_M, SPEED_OF_LIGHT_M_S, SUN_RADIUS_M
from attitude._support.validation import unit_vector
from attitude.conditions._conditions import Both, Channel, Condition, Sign
from attitude.conditions._moments import Drift, SearchDirection, lengths
from attitude.errors import AttitudeError
from attitude.events._search import source_of
from attitude.paths import _composed
from attitude.paths._path import Direction

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence
    from typing import TypeAlias

    from numpy.typing import ArrayLike

    from attitude._support.annotations import FloatArray, Real, Reals
    from attitude.conditions._moments import Moment, Pair, Source
    from attitude.events._search import AnyMotion
    from attitude.motions._motion import RateBounds

    VectorFunction: TypeAlias = Callable[[FloatArray], ArrayLike]
    AnyDirection: TypeAlias = Reals | Direction | SearchDirection | VectorFunction


# ---- The directions that a search compares with body axes: fixed, moving, or those of a scene


class Fixed(SearchDirection):
    """A constant direction: a vector (3,) of any length, ICRF axes, or a Direction."""

    def __init__(self, vector: Reals | Direction, name: str = "direction") -> None:
        self.vector = unit_vector(vector.unit if isinstance(vector, Direction) else vector, name)
        self.name = name

    def icrf(self, moment: Moment) -> FloatArray:
        """The unit vector (3,)."""
        return self.vector

    def guess(self, source: Source, start: Pair, length: float) -> float:
        """Zero."""
        return 0.0

    def drift(self, moment: Moment) -> Drift:
        """Zeros."""
        return Drift()


class Moving(SearchDirection):
    """A direction by a function of seconds since the motion's epoch: (N,) -> (N, 3), ICRF axes.

    Parameters
    ----------
    function : callable
        Vectors of any length.  It is called with arrays of TDB seconds in any order.
    rate, acceleration : float or Quantity, optional
        Upper bounds of the first and second derivative of the unit vector, 1/s and 1/s2.  Without
        them they are estimated from samples 0.8 rad of rotation apart.
    name : str
        For error messages.

    Raises
    ------
    AttitudeError
        For a bound that is negative or not one finite number; in a search, for vectors of another
        shape, of length zero, or that are not finite.
    """

    def __init__(
        self,
        function: VectorFunction,
        rate: Real | None = None,
        acceleration: Real | None = None,
        name: str = "direction",
    ) -> None:
        self.function, self.name = function, name
        self.rate = None if rate is None else validation.not_negative(rate, "rate")
        self.acceleration = (
            None if acceleration is None else validation.not_negative(acceleration, "acceleration")
        )

    def icrf(self, moment: Moment) -> FloatArray:
        """Unit vectors (N, 3) along those of the function."""
        seconds = moment.hi + moment.lo
        return _units(_called(self.function, seconds, self.name), self.name)

    def guess(self, source: Source, start: Pair, length: float) -> float:
        """The bound `rate`; without it, a guess from samples."""
        if self.rate is not None:
            return self.rate
        return super().guess(source, start, length)

    def drift(self, moment: Moment) -> Drift:
        """The bounds given, and estimates for the others."""
        sampled = super().drift(moment)
        if self.rate is not None:
            sampled = sampled._replace(first=self.rate)
        if self.acceleration is not None:
            sampled = sampled._replace(second=self.acceleration)
        return sampled


class OfScene(SearchDirection):
    """The light-time corrected direction from the body to "sun" or "observer" in a scene."""

    def __init__(self, name: str) -> None:
        self.name = name

    def body(self, moment: Moment) -> FloatArray:
        """``sun_direction`` or ``observer_direction`` (N, 3) of the view."""
        return getattr(moment.view, f"{self.name}_direction")

    def icrf(self, moment: Moment) -> FloatArray:
        """``sun_direction_icrf`` or ``observer_direction_icrf`` (N, 3) of the view."""
        return getattr(moment.view, f"{self.name}_direction_icrf")


class Aberrated(SearchDirection):
    """The apparent direction of incoming light, or (sent) that of emission, of a moving body.

    velocity: (3,) or function (N,) -> (N, 3), m/s, ICRF, or "center", that of the scene's center.
    Einstein (1905), section 7: u' = (u / g + b + (g / (g + 1)) (b.u) b) / (1 + b.u), with g = 1 /
    sqrt(1 - b^2), b = v / c.
    """

    def __init__(
        self,
        direction: SearchDirection,
        velocity: Reals | VectorFunction,
        source: Source,
        *,
        sent: bool,
    ) -> None:
        self._direction, self._sign = direction, -1.0 if sent else 1.0
        self.name = direction.name
        self._velocity: Any = velocity
        if isinstance(velocity, str):
            validation.one_of(velocity, "velocity", ("center",))
            if source.scene is None or source.scene.center is None:
                raise AttitudeError(
                    'velocity is "center", but there is no scene with a center; give it in m/s.'
                )
        elif not callable(velocity):
            self._velocity = validation.real(velocity, "velocity", shape=(3,), unit="m/s")
        self._fixed = isinstance(direction, Fixed) and isinstance(self._velocity, np.ndarray)

    def icrf(self, moment: Moment) -> FloatArray:
        """Unit vectors (N, 3), or (3,) for a constant direction and velocity."""
        b = self._sign / SPEED_OF_LIGHT_M_S * self._velocity_at(moment)
        square = np.sum(b * b, axis=-1, keepdims=True)
        if not np.all(square < 1.0):
            raise AttitudeError(
                "the velocity is not below the speed of light, or not finite; give m/s."
            )
        u = moment.inertial(self._direction)
        along = np.sum(b * u, axis=-1, keepdims=True)
        g = 1.0 / np.sqrt(1.0 - square)
        return _units(u / g + b + (g / (g + 1.0)) * along * b, self.name)

    def _velocity_at(self, moment: Moment) -> FloatArray:
        """The velocity (N, 3) or (3,), m/s, ICRF."""
        if isinstance(self._velocity, str):
            # That of the scene's center at the epochs of emission.
            view, scene = moment.view, moment.source.scene
            path = _composed.relative(scene.center, "ssb", scene.ephemeris)
            return path.velocity(view.epoch, *view.emission)
        if callable(self._velocity):
            return _called(self._velocity, moment.hi + moment.lo, "velocity")
        return self._velocity

    def guess(self, source: Source, start: Pair, length: float) -> float:
        """The guess for the direction without aberration."""
        return self._direction.guess(source, start, length)

    def drift(self, moment: Moment) -> Drift:
        """Zeros for a constant direction and velocity; otherwise estimates from samples."""
        return Drift() if self._fixed else super().drift(moment)


def direction_of(direction: AnyDirection | None, name: str, source: Source) -> SearchDirection:
    """The SearchDirection of what a caller gives."""
    if isinstance(direction, SearchDirection):
        return direction
    if direction is None or isinstance(direction, str):
        if source.scene is None:
            raise AttitudeError(
                f"{name} is {direction!r}, but a motion without a scene has no position; give an "
                "ICRF vector, a function of seconds, or a Scene instead of the motion."
            )
        chosen = name if direction is None else direction
        return OfScene(validation.one_of(chosen, name, ("sun", "observer")))
    if callable(direction):
        return Moving(direction, name=name)
    return Fixed(direction, name)


def _called(function, seconds, name):
    """The vectors (N, 3) that a function returns for seconds (N,)."""
    vectors = validation.returned(function(seconds), name)
    if vectors.shape != (*seconds.shape, 3):
        raise AttitudeError(
            f"{name} returns vectors of shape {vectors.shape} for {seconds.size} epochs; it must "
            f"return {(*seconds.shape, 3)}."
        )
    return vectors


def _units(vectors, name):
    size = lengths(vectors)
    if not np.all((size > 0.0) & np.isfinite(size)):
        raise AttitudeError(f"{name} gives a vector that is zero or not finite.")
    return vectors / size[..., None]


# Angular radius at 1 au of the nominal Sun, rad: 959.2 arcsec (IAU 2015 B3, 2012 B2).
SUN_RADIUS: float = np.arcsin(SUN_RADIUS_M / ASTRONOMICAL_UNIT_M)


class Height(Channel):
    """u.a of a direction u and a body axis a: positive within a right angle of the axis."""

    noise = 4e-16

    def __init__(self, axis: FloatArray, direction: SearchDirection) -> None:
        self.axis, self.directions = axis, (direction,)

    def value(self, moment: Moment) -> FloatArray:
        """u.a (N,)."""
        return dot(moment.body(self.directions[0]), self.axis)

    def bounds(self, rates: RateBounds, drifts: Sequence[Drift]) -> tuple[float, float]:
        """Upper bounds of the first two derivatives; see `turning`."""
        return turning(rates, drifts[0])[:2]


class Cone(Height):
    """u.a - cos(angle), by squared chords, which are exact for narrow cones: positive within."""

    def __init__(self, axis: FloatArray, direction: SearchDirection, angle: float) -> None:
        super().__init__(axis, direction)
        # Chords start at the end of the axis that is nearer to the cone, where they are short.
        self._end = 1.0 if angle <= 0.5 * np.pi else -1.0
        nearer = angle if angle <= 0.5 * np.pi else np.pi - angle
        self._square = 2.0 * np.sin(0.5 * nearer) ** 2
        self.noise = 1e-15 * (np.sin(nearer) + 1e-16)

    def value(self, moment: Moment) -> FloatArray:
        """u.a - cos(angle) (N,)."""
        u = moment.body(self.directions[0])
        return self._end * (self._square - 0.5 * chord_squared(u, self._end * self.axis))


class Mirrored(Channel):
    """r.s - cos(radius) of the observer o mirrored in n (3,), r = 2 (n.o) n - o, and the Sun s.

    radius: rad; None: that of the Sun's disc at its distance in the scene.
    """

    def __init__(
        self,
        normal: FloatArray,
        sun: SearchDirection,
        observer: SearchDirection,
        radius: float | None,
    ) -> None:
        self._normal, self.directions = normal, (sun, observer)
        self._radius = radius
        self.noise = 2e-15 * np.sin(SUN_RADIUS if radius is None else radius)

    def value(self, moment: Moment) -> FloatArray:
        """r.s - cos(radius) (N,)."""
        if self._radius is None:
            sine = SUN_RADIUS_M / moment.view.sun_distance
            one_minus_cosine = sine * sine / (1.0 + np.sqrt(1.0 - sine * sine))
        else:
            one_minus_cosine = 2.0 * np.sin(0.5 * self._radius) ** 2
        return one_minus_cosine - 0.5 * self._chord_squared(moment)

    def off_mirror(self, moment: Moment) -> FloatArray:
        """The angle (N,) between the mirrored observer and the Sun, rad."""
        return 2.0 * np.arcsin(np.minimum(0.5 * np.sqrt(self._chord_squared(moment)), 1.0))

    def _chord_squared(self, moment: Moment) -> FloatArray:
        """|r - s|^2 (N,)."""
        sun, observer = (moment.body(direction) for direction in self.directions)
        twice = 2.0 * dot(observer, self._normal)
        square = np.zeros(moment.hi.shape)
        for k in range(3):
            along = twice * self._normal[k] - observer[..., k] - sun[..., k]
            square = square + along * along
        return square

    def bounds(self, rates: RateBounds, drifts: Sequence[Drift]) -> tuple[float, float]:
        """Bounds of two derivatives: r.s = 2 (n.o)(n.s) - o.s; o.s changes by the drifts alone."""
        s1, s2, _ = turning(rates, drifts[0])
        o1, o2, _ = turning(rates, drifts[1])
        s, o = drifts
        return (
            2.0 * (s1 + o1) + s.first + o.first,
            2.0 * (s2 + 2.0 * s1 * o1 + o2) + s.second + o.second + 2.0 * s.first * o.first,
        )


def turning(rates: RateBounds, drift: Drift) -> tuple[float, float, float]:
    """Upper bounds of the first three derivatives of u.a, a fixed in the body, u with a drift."""
    a1, a2, a3 = rates
    d1, d2, d3 = drift
    return (
        a1 + d1,
        a2 + 2.0 * a1 * d1 + d2,
        a3 + (3.0 * a2 * d1 if d1 else 0.0) + 3.0 * a1 * d2 + d3,
    )


def dot(u: FloatArray, a: FloatArray) -> FloatArray:
    """u.a of vectors (..., 3) and (3,), by component: an epoch has the same bits in any block."""
    return u[..., 0] * a[0] + u[..., 1] * a[1] + u[..., 2] * a[2]


def chord_squared(u: FloatArray, a: FloatArray) -> FloatArray:
    """|u - a|^2 of vectors (..., 3) and (3,)."""
    x, y, z = u[..., 0] - a[0], u[..., 1] - a[1], u[..., 2] - a[2]
    return x * x + y * y + z * z


# ---- The conditions of body axes, facets and mirrors, searched by `find_discrete`


def in_cone(motion: AnyMotion, axis: Reals, direction: AnyDirection, half_angle: Real) -> Condition:
    """Whether a direction lies within a cone about a body axis: the field of view of a sensor.

    Parameters
    ----------
    motion : Motion, other object with ``.at(t)``, or Scene
    axis : (3,) array_like
        In body axes, of any length.
    direction : (3,) array_like, Direction, function, `Moving`, or text
        On ICRF axes, of any length; a function of TDB seconds since the motion's epoch,
        (N,) -> (N, 3), or `Moving` with known bounds of its rates; with a Scene "sun" or
        "observer".
    half_angle : float or Quantity
        rad, above 0 and below pi.

    Raises
    ------
    AttitudeError
        For an angle out of range, and vectors that are zero or not finite.

    >>> from attitude import Body, FreeRotation, Spin
    >>> from attitude.events import find_discrete
    >>> spin = Spin(epoch="2026-01-01", wxyz=(1, 0, 0, 0), angular_velocity=(0, 0, 0.1))
    >>> seen = in_cone(FreeRotation(Body(moments=(1, 2, 3)), spin), (1, 0, 0), (0, 1, 0), 0.2)
    >>> times, values = find_discrete(0, 60, seen)
    >>> times.round(9), values           # (pi/2 - 0.2) / 0.1 s and (pi/2 + 0.2) / 0.1 s
    (array([13.70796327, 17.70796327]), array([ True, False]))
    """
    source = source_of(motion)
    angle = validation.number(half_angle, "half_angle", unit="rad")
    if not 0.0 < angle < np.pi:
        raise AttitudeError(f"half_angle is {angle!r} rad; give one above 0 and below pi.")
    seen = direction_of(direction, "direction", source)
    return _of_one(source, Cone(unit_vector(axis, "axis"), seen, angle))


def illuminated(motion: AnyMotion, normal: Reals, sun: AnyDirection | None = None) -> Condition:
    """Whether the Sun shines on a facet: less than 90 deg between the Sun and the normal.

    Parameters
    ----------
    motion : as in `in_cone`
    normal : (3,) array_like
        Outward, in body axes, of any length.
    sun : as direction in `in_cone`
        Optional with a Scene: the Sun of the scene.
    """
    source = source_of(motion)
    return _of_one(source, Height(unit_vector(normal, "normal"), direction_of(sun, "sun", source)))


def visible(motion: AnyMotion, normal: Reals, observer: AnyDirection | None = None) -> Condition:
    """Whether the observer sees the front of a facet: less than 90 deg from the normal.

    Parameters
    ----------
    motion, normal : as in `illuminated`
    observer : as direction in `in_cone`
        Optional with a Scene: the observer of the scene.
    """
    source = source_of(motion)
    seen = direction_of(observer, "observer", source)
    return _of_one(source, Height(unit_vector(normal, "normal"), seen))


def beyond_plane(motion: AnyMotion, axis: Reals | None, normal: AnyDirection) -> Condition:
    """Whether a body axis points to the side of an inertial plane to which its normal points.

    Parameters
    ----------
    motion : as in `in_cone`
    axis : (3,) array_like or None
        In body axes; None is the long axis, that of least moment of inertia.
    normal : as direction in `in_cone`
    """
    source = source_of(motion)
    seen = direction_of(normal, "normal", source)
    return _of_one(source, Height(axis_or_long(axis, source), seen))


def past_meridian(
    motion: AnyMotion, axis: Reals | None, direction: Reals, pole: Reals | None = None
) -> Condition:
    """Whether a body axis is less than half a turn past the meridian of a direction.

    The condition becomes True where the axis transits the half plane from the pole through the
    direction, turning right-handed about the pole, and False where it transits the opposite half.

    Parameters
    ----------
    motion, axis : as in `beyond_plane`
    direction : (3,) array_like
        On ICRF axes, of any length.
    pole : (3,) array_like, optional
        On ICRF axes; the angular momentum of the motion by default.

    Raises
    ------
    AttitudeError
        For a direction along the pole, and a motion without constant momentum if no pole is given.
    """
    source = source_of(motion)
    if pole is None:
        if source.turning.momentum is None:
            raise AttitudeError("this motion has no constant momentum; give a pole.")
        pole = source.turning.momentum
    east = np.cross(unit_vector(pole, "pole"), unit_vector(direction, "direction"))
    if not np.sqrt(east @ east) > 1e-12:
        raise AttitudeError("direction is along the pole, which is on no meridian; give another.")
    return beyond_plane(motion, axis, east)


def glint(
    motion: AnyMotion,
    normal: Reals,
    sun: AnyDirection | None = None,
    observer: AnyDirection | None = None,
    *,
    sun_radius: Real | None = None,
    velocity: Reals | VectorFunction | None = None,
) -> Condition:
    """Whether a flat mirror shows the observer a point of the Sun's disc.

    It does if the observer's direction, mirrored in the normal, lies on the disc, and the
    mirror's front faces the observer.

    Parameters
    ----------
    motion : as in `in_cone`
    normal : (3,) array_like
        Outward, in body axes, of any length.
    sun, observer : as direction in `in_cone`
        Optional with a Scene: the Sun and the observer of the scene.
    sun_radius : float or Quantity, optional
        rad; by default the radius of the Sun's disc at its distance in a Scene, otherwise at 1 au.
        For a mirror that is not flat, add the half width of its lobe.
    velocity : (3,) array_like, function (N,) -> (N, 3), or "center", optional
        Velocity of the body in the frame of the directions, m/s on ICRF axes; "center": the
        barycentric velocity of the Scene's center.  It adds the aberration of the incoming light
        and, with opposite sign, of the reflected light.  A mirror that moves in its own plane
        reflects as one at rest.

    Raises
    ------
    AttitudeError
        For a radius out of range, vectors that are zero or not finite, and "center" without a
        Scene that has a center.

    Notes
    -----
    With n, s, o the unit vectors of normal, Sun and observer: |2 (n.o) n - o - s| <= 2 sin(radius
    / 2) and n.o > 0.
    """
    source = source_of(motion)
    radius = None
    if sun_radius is not None:
        radius = validation.number(sun_radius, "sun_radius", unit="rad")
    elif source.scene is None or source.scene.sun.is_direction:
        radius = SUN_RADIUS
    if radius is not None and not 0.0 < radius < 0.5 * np.pi:
        raise AttitudeError(f"sun_radius is {radius!r} rad; give one above 0 and below pi/2.")
    to_sun = direction_of(sun, "sun", source)
    to_observer = direction_of(observer, "observer", source)
    if velocity is not None:
        to_sun = Aberrated(to_sun, velocity, source, sent=False)
        to_observer = Aberrated(to_observer, velocity, source, sent=True)
    unit = unit_vector(normal, "normal")
    channels = Mirrored(unit, to_sun, to_observer, radius), Height(unit, to_observer)
    return Condition(source, channels, Both(Sign(0), Sign(1)))


def axis_or_long(axis: Reals | None, source: Source) -> FloatArray:
    """The unit vector (3,) along a body axis; for None, the axis of least moment of inertia."""
    if axis is not None:
        return unit_vector(axis, "axis")
    body = source.turning.body
    if body is None:
        raise AttitudeError(
            "axis is None, the long axis, but this motion has no body from which it follows; give "
            "an axis."
        )
    return np.array(body.principal_axes[:, int(np.argmin(body.moments))])


def _of_one(source: Source, channel: Channel) -> Condition:
    return Condition(source, (channel,), Sign(0))
