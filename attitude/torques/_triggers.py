"""Events at which an arc ends: the first zero of a function of the attitude, on the exact motion.

Zeros are isolated as in `attitude.events`: an interval is skipped only when a bound of the second
derivative proves that it holds none.
This is the collision search of van Zon & Schofield (2006), section 1: free motion, then the first
time that two surfaces meet.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from attitude._support import validation
from attitude._support.arrays import Immutable, frozen
from attitude._support.pairs import Seconds
from attitude._support.validation import unit_vector
from attitude.conditions._search import TOUCH, Bounded, isolated, refined, shifted
from attitude.errors import AttitudeError
from attitude.frames import quaternion

if TYPE_CHECKING:
    from attitude._support.annotations import FloatArray, Real, Reals
    from attitude.motions._history import AttitudeHistory
    from attitude.motions._motion import Motion


# Spacing of the knots of a search, in radians of the fastest rotation.
_SPACING = Bounded.spacing
# Knots in one call.
_BLOCK = 256
# The spacing where bounds are unknown.
_FINER = 1.0 / 16.0
# There, the least rate by that of the block before.
_SLOWEST = 1e-3
# A block in which the body turns faster than expected by this factor is searched again.
_FASTER = 2.0


class Trigger(Immutable):
    """The base of events at which a change may happen, found on the exact motion.

    A new kind is a frozen dataclass (a trigger is immutable) that defines

    ``values(history)``
        A smooth function of the attitude that changes its sign at the event, and its rate per
        second, at the epochs of an AttitudeHistory.
    ``arm``
        Upper bound of the change of the function per radian of rotation; of an angular velocity
        the largest one that the motion reaches.
    ``drift``
        Upper bound of the rate of the function at a fixed attitude, per second.
    ``within``
        Seconds after the change before it (or the epoch of the spin) in which the event must
        happen; None for a thousand turns at the fastest rate that the motion can have.

    >>> from dataclasses import dataclass
    >>> from attitude import Body, Spin
    >>> from attitude.arcs import Arcs, Impulse
    >>> @dataclass(frozen=True)
    ... class RateReaches(Trigger):
    ...     rate: float  # rad/s, about x
    ...     arm: float
    ...     drift: float = 0.0
    ...     within: float = 1000.0  # s
    ...     def values(self, history):
    ...         about_x = history.angular_velocity[..., 0] - self.rate
    ...         return about_x, history.angular_acceleration[..., 0]
    >>> body, spin = Body(moments=(10, 20, 26)), Spin("2026-01-01", (1, 0, 0, 0), (0.1, 0.2, 0.3))
    >>> motion = Arcs(body, spin, [Impulse(RateReaches(0.05, arm=0.5), (0.0, 0.0, -1.0))])
    >>> round(float(motion.at(motion.joints[0]).angular_velocity[0]), 9)
    0.05
    """

    arm: float
    drift: float
    within: float | None = None

    def values(self, history: AttitudeHistory) -> tuple[FloatArray, FloatArray]:
        """The function that changes its sign at the event, and its rate per second: (S,) each."""
        raise NotImplementedError(f"{type(self).__name__} defines no values")


@dataclass(frozen=True, eq=False, init=False)
class AxisCrossesDirection(Trigger):
    """A body axis reaches a given angle to a direction that is fixed in ICRF.

    Parameters
    ----------
    axis : (3,) array_like
        In body axes, of any length.
    direction : (3,) array_like
        In ICRF, of any length.
    angle : float
        rad; by default a right angle.
    within : float, optional
        Seconds after the change before it (or the epoch of the spin) in which it must happen; by
        default a thousand turns at the fastest rate that the motion can have.

    Attributes
    ----------
    axis, direction : (3,) arrays
        Unit vectors.
    angle : float
        rad.
    within : float or None
        s.

    Raises
    ------
    AttitudeError
        For vectors without a direction, wrong shapes and units, numbers that are not finite, and
        a `within` that is not greater than zero.
    """

    axis: FloatArray
    direction: FloatArray
    angle: float = 0.5 * np.pi
    within: float | None = None

    arm, drift = 1.0, 0.0

    def __init__(
        self,
        axis: Reals,
        direction: Reals,
        angle: Real = 0.5 * np.pi,
        within: Real | None = None,
    ) -> None:
        self._set("axis", frozen(unit_vector(axis, "axis")))
        self._set("direction", frozen(unit_vector(direction, "direction")))
        self._set("angle", validation.number(angle, "angle", unit="rad"))
        self._set("within", _seconds(within))

    def values(self, history: AttitudeHistory) -> tuple[FloatArray, FloatArray]:
        """cos(angle to the direction) - cos(angle), and its rate, per second: (S,) each."""
        v, rate = _point(history, self.axis)
        return v @ self.direction - np.cos(self.angle), rate @ self.direction


@dataclass(frozen=True, eq=False, init=False)
class PointMeetsPlane(Trigger):
    """A point of the body reaches a plane that is fixed in ICRF axes.

    The centre of mass moves uniformly: it is at `start` at the epoch of the spin.

    Parameters
    ----------
    point : (3,) array_like
        m, body axes, from the centre of mass.
    normal : (3,) array_like
        Of any length, ICRF axes; positions on the plane have the component `offset` along it.
    offset : float
        m.
    start, velocity : (3,) array_like
        m and m/s, ICRF axes.
    within : float, optional
        As in `AxisCrossesDirection`.

    Attributes
    ----------
    point, start, velocity : (3,) arrays
        m, m and m/s.
    normal : (3,) array
        Unit vector.
    offset : float
        m.
    within : float or None
        s.
    arm, drift : float
        m and m/s; see `Trigger`.

    Raises
    ------
    AttitudeError
        As `AxisCrossesDirection`.
    """

    point: FloatArray
    normal: FloatArray
    offset: float
    start: FloatArray
    velocity: FloatArray
    within: float | None = None

    def __init__(
        self,
        point: Reals,
        normal: Reals,
        offset: Real = 0.0,
        start: Reals = (0.0, 0.0, 0.0),
        velocity: Reals = (0.0, 0.0, 0.0),
        within: Real | None = None,
    ) -> None:
        self._set("point", frozen(validation.real(point, "point", shape=(3,), unit="m")))
        self._set("normal", frozen(unit_vector(normal, "normal")))
        self._set("offset", validation.number(offset, "offset", unit="m"))
        self._set("start", frozen(validation.real(start, "start", shape=(3,), unit="m")))
        speed = validation.real(velocity, "velocity", shape=(3,), unit="m/s")
        self._set("velocity", frozen(speed))
        self._set("within", _seconds(within))
        self._set("arm", float(np.sqrt(self.point @ self.point)))
        self._set("drift", abs(float(self.velocity @ self.normal)))

    def values(self, history: AttitudeHistory) -> tuple[FloatArray, FloatArray]:
        """Height of the point over the plane, m, and its rate, m/s: (S,) each."""
        v, rate = _point(history, self.point)
        speed = self.velocity @ self.normal
        seconds = Seconds.of(history).rounded
        centre = (self.start @ self.normal - self.offset) + seconds * speed
        return v @ self.normal + centre, rate @ self.normal + speed


def first_crossing(event: Trigger, motion: Motion, start: float, end: float, name: str) -> float:
    """Seconds of the first crossing on the last arc of a motion."""
    bounds = motion.rate_bounds(start)
    away = abs(event.values(motion.at(start))[0]) + event.arm
    drift = float(event.drift / away) if event.drift else 0.0

    def fastest(history: AttitudeHistory) -> float:
        """The largest speed of the arguments, rad/s, at the epochs of a history."""
        return float(np.max(np.linalg.norm(history.turning_rate, axis=-1))) + drift

    def pace(seconds: float) -> float:
        """Speed of the arguments, rad/s: the bound of a free arc, else the turn to come counts."""
        if bounds is not None:
            return bounds.first + drift
        history = motion.at(seconds)
        return max(fastest(history), float(np.linalg.norm(history.angular_acceleration)) ** 0.5)

    rate = pace(start)
    if bounds is None and not rate > 0.0 and event.within is not None:
        rate = 2.0 * np.pi / event.within  # a torque will turn it
    if not rate > 0.0:
        raise AttitudeError(
            f"{name}.at is an event of a body that does not move, which never happens; give an "
            "epoch."
        )
    within = event.within if event.within is not None else 1000.0 * 2.0 * np.pi / rate
    last = min(end, start + within)
    # An event at the start itself (a bounce off the same plane) is the one that started the arc.
    left = start + TOUCH / rate
    spacing = _SPACING if bounds is not None else _FINER
    while left < last:
        # Seconds from here: a single double of them is fine enough for any bracket.
        knots = np.minimum(spacing / rate * np.arange(_BLOCK + 1.0), last - left)
        knots = knots[: np.argmax(knots) + 1]

        def evaluate(s: FloatArray, base: float = left) -> FloatArray:
            return event.values(motion.at(*shifted((base, 0.0), s)))[0]

        history = motion.at(*shifted((left, 0.0), knots))
        values = event.values(history)[0]
        if bounds is None:  # signs at the knots alone
            if fastest(history) > _FASTER * rate:
                rate = fastest(history)
                continue
            k = np.flatnonzero((values[:-1] < 0.0) != (values[1:] < 0.0))[:1]
            brackets = np.stack([knots[k], knots[k + 1], values[k], values[k + 1]])
        else:
            noise = 4.0 * np.spacing(event.arm + np.max(np.abs(values)))
            bound = event.arm * bounds.second
            brackets = isolated(evaluate, knots, values, np.inf, bound, TOUCH / rate, noise)
        if brackets.size:
            return float(left + np.min(refined(lambda s, _: evaluate(s), *brackets)))
        left += float(knots[-1])
        rate = max(pace(left), _SLOWEST * rate)
    raise AttitudeError(
        f"{name}.at is {type(event).__name__}, which does not happen between {start:.9g} and "
        f"{last:.9g} s; give a longer within=, an event that happens, or an epoch."
    )


def _point(history: AttitudeHistory, vector: FloatArray) -> tuple[FloatArray, FloatArray]:
    """A body vector and its rate of change, over ICRF axes."""
    rate = np.cross(history.turning_rate, vector)
    return quaternion.rotate(history.wxyz, vector), quaternion.rotate(history.wxyz, rate)


def _seconds(within: Real | None) -> float | None:
    return None if within is None else validation.positive(within, "within", unit="s")
