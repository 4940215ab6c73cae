"""The conditions of body axes, facets and mirrors, searched by `find_discrete`."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from attitude import validation
from attitude.conditions.condition import Condition
from attitude.conditions.logic import Both, Sign
from attitude.errors import AttitudeError
from attitude.events.channels import SUN_RADIUS, Cone, Height, Mirrored
from attitude.events.directions import Aberrated, direction_of
from attitude.events.sources import source_of
from attitude.validation import unit_vector

if TYPE_CHECKING:
    from attitude.annotations import FloatArray, Real, Reals
    from attitude.conditions.channel import Channel
    from attitude.conditions.moments import Source
    from attitude.events.directions import AnyDirection, VectorFunction
    from attitude.events.sources import AnyMotion


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
