"""The first time that something happens on a free arc, found on the exact motion.

What is sought is a zero of a function of the attitude.  Bounds on the angular rate bound its
second derivative, so that an interval without a zero can be proved to be one: no sample spacing
decides what is found.  This is the collision search of van Zon & Schofield (2006), section 1:
free motion, then the first time that two surfaces meet.
"""

from dataclasses import dataclass

import numpy as np

from attitude import gates, quaternion
from attitude.errors import AttitudeError
from attitude.frozen import Frozen, frozen

# Samples of a search are this far apart, in radians of the fastest possible rotation.
_SPACING = 0.25
_BLOCK = 256
_PARTS = 8
# Zeros nearer to each other than this (rad of rotation) are a touch, and not looked for.
_TOUCH = 1e-7


@dataclass(frozen=True, eq=False)
class AxisCrossesDirection(Frozen):
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
        self._set("axis", frozen(_unit(self.axis, "axis")))
        self._set("direction", frozen(_unit(self.direction, "direction")))
        self._set("angle", gates.number(self.angle, "angle", unit="rad"))
        _check_within(self)

    def values(self, history):
        """cos(angle to the direction) - cos(angle), its rate, per second."""
        v, rate = _point(history, self.axis)
        return v @ self.direction - np.cos(self.angle), rate @ self.direction

    @property
    def arm(self):
        return 1.0


@dataclass(frozen=True, eq=False)
class PointMeetsPlane(Frozen):
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
        self._set("point", frozen(gates.real(self.point, "point", shape=(3,), unit="m")))
        self._set("normal", frozen(_unit(self.normal, "normal")))
        self._set("offset", gates.number(self.offset, "offset", unit="m"))
        self._set("start", frozen(gates.real(self.start, "start", shape=(3,), unit="m")))
        velocity = gates.real(self.velocity, "velocity", shape=(3,), unit="m/s")
        self._set("velocity", frozen(velocity))
        _check_within(self)

    def values(self, history):
        """Height of the point over the plane, m, and its rate, m/s."""
        v, rate = _point(history, self.point)
        drift = self.start @ self.normal + history.seconds * (self.velocity @ self.normal)
        return (
            v @ self.normal + drift - self.offset,
            rate @ self.normal + self.velocity @ self.normal,
        )

    @property
    def arm(self):
        return float(np.sqrt(self.point @ self.point))


def first(event, motion, start, end, fastest, name):
    """Seconds of the first crossing after `start`.

    Parameters
    ----------
    event : object with ``values(history)``, ``arm`` and ``within``
    motion : object with ``.at(t)``
    start : float
        TDB seconds since the epoch of the motion.
    end : float
        Where the search ends at the latest; inf where only `within` ends it.
    fastest : float
        A bound of the angular rate, rad/s.
    name : str
        How the event is called in the message.

    Raises
    ------
    AttitudeError
        If it does not happen in that time.
    """
    if not fastest > 0.0:
        raise AttitudeError(f"{name} waits for an event of a body that does not turn.")
    within = event.within if event.within is not None else 1000.0 * 2.0 * np.pi / fastest
    last = min(end, start + within)
    # |d2/dt2 (R p)| <= |p| (|w|^2 + |w'|), and |w'| <= |w|^2 by the triangle inequality.
    bound = 2.0 * event.arm * fastest * fastest
    width = _SPACING / fastest
    # What happened at the start itself (a bounce off the same plane) is not to be found again.
    left = start + _TOUCH / fastest
    while left < last:
        knots = left + width * np.arange(_BLOCK + 1)
        knots = np.append(knots[knots < last], last) if knots[-1] >= last else knots
        found = _first_zero(event, motion, knots, bound, _TOUCH / fastest)
        if found is not None:
            return found
        left = knots[-1]
    raise AttitudeError(
        f"{name} waits for {type(event).__name__}, which does not happen between {start:.9g} and "
        f"{last:.9g} s; give a longer within=, an event that happens, or an epoch."
    )


def _first_zero(event, motion, knots, bound, touch):
    """The first zero between knots, or None; each interval is decided or divided."""
    values, _ = event.values(motion.at(knots))
    sizes = np.diff(knots)
    change = (values[:-1] < 0.0) != (values[1:] < 0.0)
    least = np.minimum(np.abs(values[:-1]), np.abs(values[1:]))
    open_ = change | (least <= bound * sizes**2 / 8.0)
    for k in np.flatnonzero(open_):
        if sizes[k] <= touch or np.spacing(knots[k]) * _PARTS >= sizes[k]:
            if change[k]:
                return _refined(event, motion, knots[k], knots[k + 1])
            continue
        finer = np.linspace(knots[k], knots[k + 1], _PARTS + 1)
        found = _first_zero(event, motion, finer, bound, touch)
        if found is not None:
            return found
    return None


def _refined(event, motion, a, b):
    """The zero in [a, b], |b - a| small, by Newton kept inside the bracket."""
    value_a = event.values(motion.at(a))[0]
    t = 0.5 * (a + b)
    for _ in range(60):
        value, rate = event.values(motion.at(t))
        if (value < 0.0) == (value_a < 0.0):
            a = t
        else:
            b = t
        step = t - value / rate if rate != 0.0 else 0.5 * (a + b)
        new = step if a <= step <= b else 0.5 * (a + b)
        if new == t or b - a <= np.spacing(abs(b)):
            return float(new)
        t = new
    return float(t)


def _point(history, vector):
    """A body vector and its rate of change, over ICRF axes."""
    rate = np.cross(history.angular_velocity, vector)
    return quaternion.rotate(history.wxyz, vector), quaternion.rotate(history.wxyz, rate)


def _unit(value, name):
    vector = gates.real(value, name, shape=(3,))
    size = np.max(np.abs(vector))
    if size == 0.0:
        raise AttitudeError(f"{name} is zero; give a vector of any other length.")
    vector /= size
    return vector / np.sqrt(vector @ vector)


def _check_within(event):
    if event.within is not None:
        event._set("within", gates.positive(event.within, "within", unit="s"))
