"""What can be true of an attitude at an epoch: conditions that `find_discrete` searches.

A condition is one or several signs of smooth functions, the channels.  Each channel knows bounds
of its first two derivatives from the rates of the motion and the drift of the directions.
"""

import numpy as np

from attitude import validation
from attitude.errors import AttitudeError
from attitude.events.directions import Aberrated, direction_of, source_of, values_at
from attitude.physical_constants import ASTRONOMICAL_UNIT_M, SUN_RADIUS_M
from attitude.validation import unit_vector

# The nominal radius of the Sun over the astronomical unit, 959.2 arcsec (IAU 2015 B3, 2012 B2).
SUN_RADIUS = np.arcsin(SUN_RADIUS_M / ASTRONOMICAL_UNIT_M)


class Condition:
    """True or False at every epoch; made by the functions of this file.

    ``condition(t)`` tells it at epochs (as of ``motion.at``); ``&``, ``|`` and ``~`` combine
    conditions of the same motion or scene.
    """

    def __init__(self, source, channels, logic):
        self.source, self.channels, self._logic = source, tuple(channels), logic

    @property
    def epoch(self):
        return self.source.epoch

    def __call__(self, t, low=None):
        return values_at(self.source, lambda moment: self.states(self.signs(moment)), t, low)

    def signs(self, moment):
        return [channel.value(moment) >= 0.0 for channel in self.channels]

    def states(self, signs):
        """True or False from the signs of the channels."""
        return self._logic(signs)

    def __and__(self, other):
        return self._joined(other, np.logical_and)

    def __or__(self, other):
        return self._joined(other, np.logical_or)

    def __invert__(self):
        return Condition(self.source, self.channels, lambda signs: ~self._logic(signs))

    def _joined(self, other, operation):
        if not isinstance(other, Condition) or not same_source(self.source, other.source):
            raise AttitudeError(
                "only conditions of the same motion or scene can be combined with & and |."
            )
        count = len(self.channels)
        return Condition(
            self.source,
            self.channels + other.channels,
            lambda signs: operation(self._logic(signs[:count]), other._logic(signs[count:])),
        )


def in_cone(motion, axis, direction, half_angle):
    """Whether a direction lies within a cone about a body axis: the field of view of a sensor.

    Parameters
    ----------
    motion : FreeRotation, anything else with ``.at(t)``, or Scene
    axis : (3,) array_like
        In body axes, of any length.
    direction : (3,) array_like, function, or text
        Over ICRF axes; a function of seconds since the motion's epoch, (N,) -> (N, 3), or
        `Moving` with known bounds; with a Scene "sun" or "observer".
    half_angle : float or Quantity
        rad, above 0 and below pi.

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


def illuminated(motion, normal, sun=None):
    """Whether the Sun shines on a facet: its direction is less than 90 deg from the normal.

    Parameters
    ----------
    motion : as of `in_cone`
    normal : (3,) array_like
        Outward, in body axes, of any length.
    sun : as direction of `in_cone`
        Need not be given with a Scene.
    """
    source = source_of(motion)
    return _of_one(source, Height(unit_vector(normal, "normal"), direction_of(sun, "sun", source)))


def visible(motion, normal, observer=None):
    """Whether the observer sees a facet's front; see `illuminated`."""
    source = source_of(motion)
    seen = direction_of(observer, "observer", source)
    return _of_one(source, Height(unit_vector(normal, "normal"), seen))


def beyond_plane(motion, axis, normal):
    """Whether a body axis points to that side of a plane in space to which its normal points.

    Parameters
    ----------
    motion : as of `in_cone`
    axis : (3,) array_like or None
        In body axes; None is the long axis, that of least inertia.
    normal : as direction of `in_cone`
    """
    source = source_of(motion)
    seen = direction_of(normal, "normal", source)
    return _of_one(source, Height(axis_or_long(axis, source), seen))


def past_meridian(motion, axis, direction, pole=None):
    """Whether a body axis is less than half a turn past the meridian of a direction.

    It becomes True where the axis transits the half plane from the pole through the direction,
    turning with the right hand about the pole, and False at the transit of the opposite half.

    Parameters
    ----------
    motion, axis : as of `beyond_plane`
    direction : (3,) array_like
        Over ICRF axes.
    pole : (3,) array_like
        Over ICRF axes; the angular momentum of the motion unless given.
    """
    source = source_of(motion)
    if pole is None:
        if source.motion.momentum is None:
            raise AttitudeError("this motion has no constant momentum; give a pole.")
        pole = source.motion.momentum
    pole = unit_vector(pole, "pole")
    east = np.cross(pole, unit_vector(direction, "direction"))
    if not np.sqrt(east @ east) > 1e-12:
        raise AttitudeError("direction is along the pole, which is on no meridian; give another.")
    return beyond_plane(motion, axis, east)


def glint(motion, normal, sun=None, observer=None, *, sun_radius=None, velocity=None):
    """Whether a flat mirror shows the observer a point of the Sun's disc.

    The observer's direction, mirrored in the normal, lies on the disc, and the mirror's front is
    turned to the observer.

    Parameters
    ----------
    motion : as of `in_cone`
    normal : (3,) array_like
        Outward, in body axes, of any length.
    sun, observer : as direction of `in_cone`
        Need not be given with a Scene.
    sun_radius : float or Quantity
        rad; unless given that of the Sun's disc at its distance in a Scene, or at 1 au.  Widen it
        by the half width of the lobe of a mirror that is not flat.
    velocity : (3,) array_like, function (N,) -> (N, 3), or "center", optional
        m/s over ICRF axes, of the body relative to where the directions are at rest ("center":
        that of a Scene's center): takes aberration into account, of the light that comes and,
        with the other sign, of that which is sent.  A mirror that moves in its own plane reflects
        as one at rest.

    Notes
    -----
    With n, s, o the unit vectors of normal, Sun and observer: |2 (n.o) n - o - s| <= 2 sin(radius
    / 2) and n.o > 0.
    """
    source = source_of(motion)
    radius = sun_radius
    if sun_radius is not None:
        radius = validation.number(sun_radius, "sun_radius", unit="rad")
    elif source.scene is None or source.scene.sun.is_direction:
        radius = SUN_RADIUS
    if radius is not None and not 0.0 < radius < 0.5 * np.pi:
        raise AttitudeError(f"sun_radius is {radius!r} rad; give one above 0 and below pi/2.")
    sun = direction_of(sun, "sun", source)
    observer = direction_of(observer, "observer", source)
    if velocity is not None:
        sun = Aberrated(sun, velocity, source, sent=False)
        observer = Aberrated(observer, velocity, source, sent=True)
    normal = unit_vector(normal, "normal")
    channels = Mirrored(normal, sun, observer, radius), Height(normal, observer)
    return Condition(source, channels, lambda signs: signs[0] & signs[1])


# The channels -------------------------------------------------------------------------------------


class Height:
    """u.a of a direction u and a body axis a."""

    noise = 4e-16

    def __init__(self, axis, direction):
        self.axis, self.directions = axis, (direction,)

    def value(self, moment):
        return dot(moment.body(self.directions[0]), self.axis)

    def bounds(self, rates, drifts):
        return turning(rates, drifts[0])[:2]


class Cone(Height):
    """u.a - cos(angle), as a difference of squared chords: exact for narrow cones too."""

    def __init__(self, axis, direction, angle):
        super().__init__(axis, direction)
        # From the nearer end of the axis, where chords are short.
        self._end = 1.0 if angle <= 0.5 * np.pi else -1.0
        nearer = angle if angle <= 0.5 * np.pi else np.pi - angle
        self._square = 2.0 * np.sin(0.5 * nearer) ** 2
        self.noise = 1e-15 * (np.sin(nearer) + 1e-16)

    def value(self, moment):
        u = moment.body(self.directions[0])
        return self._end * (self._square - 0.5 * chord_squared(u, self._end * self.axis))


class Mirrored:
    """r.s - cos(radius) of the mirrored observer r = 2 (n.o) n - o and the Sun s, by chords.

    Without a radius the Sun's is that at its distance in the scene.
    """

    def __init__(self, normal, sun, observer, radius):
        self._normal, self.directions = normal, (sun, observer)
        self._radius = radius
        self.noise = 2e-15 * np.sin(SUN_RADIUS if radius is None else radius)

    def value(self, moment):
        sun, observer = (moment.body(each) for each in self.directions)
        twice = 2.0 * dot(observer, self._normal)
        square = 0.0
        for k in range(3):
            part = twice * self._normal[k] - observer[..., k] - sun[..., k]
            square = square + part * part
        return self._reach(moment) - 0.5 * square

    def _reach(self, moment):
        """1 - cos(radius)."""
        if self._radius is not None:
            return 2.0 * np.sin(0.5 * self._radius) ** 2
        sine = SUN_RADIUS_M / moment.view.sun_distance
        return sine * sine / (1.0 + np.sqrt(1.0 - sine * sine))

    def bounds(self, rates, drifts):
        # r.s = 2 (n.o)(n.s) - o.s, the last of which moves among the stars alone.
        s1, s2, _ = turning(rates, drifts[0])
        o1, o2, _ = turning(rates, drifts[1])
        s, o = drifts
        return (
            2.0 * (s1 + o1) + s.first + o.first,
            2.0 * (s2 + 2.0 * s1 * o1 + o2) + s.second + o.second + 2.0 * s.first * o.first,
        )


def turning(rates, drift):
    """Bounds of the first three derivatives of u.a, u with a drift and a on the turning body."""
    a1, a2, a3 = rates
    d1, d2, d3 = drift
    return (
        a1 + d1,
        a2 + 2.0 * a1 * d1 + d2,
        a3 + (3.0 * a2 * d1 if d1 else 0.0) + 3.0 * a1 * d2 + d3,
    )


def dot(u, a):
    """Component by component, so that an epoch has the same bits in every block."""
    return u[..., 0] * a[0] + u[..., 1] * a[1] + u[..., 2] * a[2]


def chord_squared(u, a):
    x, y, z = u[..., 0] - a[0], u[..., 1] - a[1], u[..., 2] - a[2]
    return x * x + y * y + z * z


def same_source(one, other):
    if one.scene is not None or other.scene is not None:
        return one.scene is other.scene
    return one.motion is other.motion


def _of_one(source, channel):
    return Condition(source, (channel,), lambda signs: signs[0])


def axis_or_long(axis, source):
    if axis is not None:
        return unit_vector(axis, "axis")
    body = source.motion.body
    if body is None:
        raise AttitudeError("this motion has no body, whose long axis could be told; give an axis.")
    return np.array(body.principal_axes[:, int(np.argmin(body.moments))])
