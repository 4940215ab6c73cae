"""The first time that something happens on a free arc, found on the exact motion.

What is sought is the first zero of a function of the attitude, isolated as in `attitude.events`:
an interval is passed over only when a bound of the second derivative proves that it holds none.
This is the collision search of van Zon & Schofield (2006), section 1: free motion, then the first
time that two surfaces meet.
"""

from dataclasses import dataclass

import numpy as np

from attitude import quaternion, validation
from attitude.errors import AttitudeError
from attitude.events.rate_bounds import Bounded
from attitude.events.root_finding import refined
from attitude.events.search import TOUCH, isolated, shifted
from attitude.immutable import Immutable, frozen
from attitude.validation import unit_vector

# Knots of a first look, in radians of the fastest rotation; as many are looked at together.
_SPACING, _BLOCK = Bounded.spacing, 256


class Trigger(Immutable):
    """The base of events at which a change may happen, found on the exact motion.

    A new kind defines

    ``values(history)``
        A smooth function of the attitude that changes its sign at the event, and its rate per
        second, at the epochs of an AttitudeHistory.
    ``arm``
        The length that turns with the body: the attitude changes the function by at most `arm`
        times the turn.
    ``drift``
        The greatest rate of whatever else changes the function, per second.
    ``within``
        Seconds after the change before it (or the epoch of the spin) in which the event must
        happen; None for a thousand turns at the fastest rate that the motion can have.
    """

    arm: float
    drift: float
    within: float | None = None

    def values(self, history):
        raise NotImplementedError(f"{type(self).__name__} defines no values")


@dataclass(frozen=True, eq=False)
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
    """

    axis: np.ndarray
    direction: np.ndarray
    angle: float = 0.5 * np.pi
    within: float = None

    def __post_init__(self):
        self._set("axis", frozen(unit_vector(self.axis, "axis")))
        self._set("direction", frozen(unit_vector(self.direction, "direction")))
        self._set("angle", validation.number(self.angle, "angle", unit="rad"))
        _check_within(self)

    def values(self, history):
        """cos(angle to the direction) - cos(angle), and its rate, per second."""
        v, rate = _point(history, self.axis)
        return v @ self.direction - np.cos(self.angle), rate @ self.direction

    # The length that turns, and the greatest rate of what else changes the value.
    arm, drift = 1.0, 0.0


@dataclass(frozen=True, eq=False)
class PointMeetsPlane(Trigger):
    """A point of the body reaches a plane that is fixed in ICRF axes.

    The centre of mass moves uniformly: it is at `start` at the epoch of the spin.

    Parameters
    ----------
    point : (3,) array_like
        m, body axes, from the centre of mass.
    normal : (3,) array_like
        Of any length; the plane is where its unit vector times the position is `offset`.
    offset : float
        m.
    start, velocity : (3,) array_like
        m and m/s, ICRF axes.
    within : float, optional
        As in `AxisCrossesDirection`.
    """

    point: np.ndarray
    normal: np.ndarray
    offset: float = 0.0
    start: np.ndarray = (0.0, 0.0, 0.0)
    velocity: np.ndarray = (0.0, 0.0, 0.0)
    within: float = None

    def __post_init__(self):
        self._set("point", frozen(validation.real(self.point, "point", shape=(3,), unit="m")))
        self._set("normal", frozen(unit_vector(self.normal, "normal")))
        self._set("offset", validation.number(self.offset, "offset", unit="m"))
        self._set("start", frozen(validation.real(self.start, "start", shape=(3,), unit="m")))
        velocity = validation.real(self.velocity, "velocity", shape=(3,), unit="m/s")
        self._set("velocity", frozen(velocity))
        _check_within(self)

    def values(self, history):
        """Height of the point over the plane, m, and its rate, m/s."""
        v, rate = _point(history, self.point)
        speed = self.velocity @ self.normal
        low = 0.0 if history.low is None else history.low
        centre = (self.start @ self.normal - self.offset) + (history.seconds + low) * speed
        return v @ self.normal + centre, rate @ self.normal + speed

    @property
    def arm(self):
        return float(np.sqrt(self.point @ self.point))

    @property
    def drift(self):
        return abs(float(self.velocity @ self.normal))


def first(event, motion, start, end, name):
    """Seconds of the first crossing on the last arc of a motion.

    Parameters
    ----------
    event : Trigger
    motion : Arcs
        Free from `start` on.
    start : float
        TDB seconds since the epoch of the motion.
    end : float
        Where the search ends at the latest; inf where only `within` ends it.
    name : str
        How the event is called in the message.

    Raises
    ------
    AttitudeError
        If it does not happen in that time.
    """
    bounds = motion.rate_bounds(start)
    away = abs(event.values(motion.at(start))[0]) + event.arm
    rate = bounds.first + (event.drift / away if event.drift else 0.0)
    if not rate > 0.0:
        raise AttitudeError(f"{name} waits for an event of a body that does not move.")
    within = event.within if event.within is not None else 1000.0 * 2.0 * np.pi / rate
    last = min(end, start + within)
    # What happened at the start itself (a bounce off the same plane) is not to be found again.
    left = start + TOUCH / rate
    while left < last:
        # Seconds from here: a single double of them is fine enough for any bracket.
        knots = np.minimum(_SPACING / rate * np.arange(_BLOCK + 1.0), last - left)
        knots = knots[: np.argmax(knots) + 1]

        def evaluate(s, base=left):
            return event.values(motion.at(*shifted((base, 0.0), s)))[0]

        values = evaluate(knots)
        noise = 4.0 * np.spacing(event.arm + np.max(np.abs(values)))
        bound = event.arm * bounds.second
        brackets = isolated(evaluate, knots, values, np.inf, bound, TOUCH / rate, noise)
        if brackets.size:
            return float(left + np.min(refined(evaluate, *brackets)))
        left += knots[-1]
    raise AttitudeError(
        f"{name} waits for {type(event).__name__}, which does not happen between {start:.9g} and "
        f"{last:.9g} s; give a longer within=, an event that happens, or an epoch."
    )


def _point(history, vector):
    """A body vector and its rate of change, over ICRF axes."""
    rate = np.cross(history.angular_velocity, vector)
    return quaternion.rotate(history.wxyz, vector), quaternion.rotate(history.wxyz, rate)


def _check_within(event):
    if event.within is not None:
        event._set("within", validation.positive(event.within, "within", unit="s"))
