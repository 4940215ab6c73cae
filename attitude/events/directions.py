"""Directions that a body turns under: fixed, moving, or those of a scene.

A search asks for them in body axes at blocks of epochs (`Moment`), and for bounds of how fast
they move among the stars.
"""

from functools import cached_property
from typing import NamedTuple

import numpy as np

from attitude import epochs, quaternion, validation
from attitude.errors import AttitudeError
from attitude.motion import motion_of
from attitude.paths.uniform import Direction
from attitude.physical_constants import SPEED_OF_LIGHT_M_S
from attitude.scene.scene import Scene
from attitude.validation import unit_vector

# Sampled less than a radian of its turning and the body's apart, a direction's differences are
# close to its derivatives (2 sin(0.4)/0.8 = 0.97 of them); these are the margins taken.
_MARGINS = (1.5, 2.0, 3.0)


class Drift(NamedTuple):
    """Bounds of the first three derivatives of a unit vector on inertial axes, per second."""

    first: float = 0.0
    second: float = 0.0
    third: float = 0.0


class Fixed:
    """A direction that does not move: unit vector (3,) over ICRF axes."""

    def __init__(self, vector, name="direction"):
        self.vector = unit_vector(vector.unit if isinstance(vector, Direction) else vector, name)
        self.name = name

    def icrf(self, moment):
        return self.vector

    def guess(self, source, start, length):
        return 0.0

    def drift(self, moment):
        return Drift()


class Moving:
    """A direction by a function of seconds since the motion's epoch: (N,) -> (N, 3), ICRF axes.

    Parameters
    ----------
    function : callable
        The vectors may have any length.  It is called with arrays of seconds, in order.
    rate, acceleration : float, optional
        Bounds of the first and second derivative of the unit vector, 1/s and 1/s2.  Without them
        they are estimated from samples 0.8 rad of rotation apart.
    """

    def __init__(self, function, rate=None, acceleration=None, name="direction"):
        self.function, self.name = function, name
        self.rate = None if rate is None else validation.number(rate, "rate")
        self.acceleration = (
            None if acceleration is None else validation.number(acceleration, "acceleration")
        )

    def icrf(self, moment):
        seconds = moment.hi + moment.lo
        vectors = np.asarray(self.function(seconds), dtype=np.float64)
        if vectors.shape != (*seconds.shape, 3):
            raise AttitudeError(
                f"{self.name} gives vectors of shape {vectors.shape} for {seconds.size} epochs; "
                f"it must return {(*seconds.shape, 3)}."
            )
        return _units(vectors, self.name)

    def guess(self, source, start, length):
        if self.rate is not None:
            return self.rate
        return _seen_rate(self, source, start, length)

    def drift(self, moment):
        sampled = estimated(moment.inertial(self), moment.step)
        if self.rate is not None:
            sampled = sampled._replace(first=self.rate)
        if self.acceleration is not None:
            sampled = sampled._replace(second=self.acceleration)
        return sampled


class OfScene:
    """The direction to "sun" or "observer" in a scene, light-time corrected."""

    def __init__(self, name):
        self.name = name

    def body(self, moment):
        return getattr(moment.view, f"{self.name}_direction")

    def icrf(self, moment):
        return getattr(moment.view, f"{self.name}_direction_icrf")

    def guess(self, source, start, length):
        return _seen_rate(self, source, start, length)

    def drift(self, moment):
        return estimated(moment.inertial(self), moment.step)


class Aberrated:
    """How a direction looks from a moving body, or where its light must be sent to reach it.

    Parameters
    ----------
    direction : a direction of this file
    velocity : (3,) array_like, m/s over ICRF axes; function (N,) -> (N, 3); or "center"
        Of the body, relative to where the directions are at rest; "center": that of a scene's
        center relative to the solar system's barycentre.
    sent : bool
        Incoming light seems to come from nearer to where the body goes; light that the body
        sends to an observer leaves it nearer to where it comes from.

    Notes
    -----
    The Lorentz transformation of the direction of light, Einstein (1905), section 7:
    u' = (u / g + b + (g / (g + 1)) (b.u) b) / (1 + b.u), with g = 1 / sqrt(1 - b^2), b = v / c.
    """

    def __init__(self, direction, velocity, source, *, sent):
        self._direction, self._sign = direction, -1.0 if sent else 1.0
        self.name = direction.name
        self._velocity = velocity
        if isinstance(velocity, str):
            validation.one_of(velocity, "velocity", ("center",))
            if source.scene is None or source.scene.center is None:
                raise AttitudeError(
                    'velocity is "center", but there is no scene with a center; give it in m/s.'
                )
        elif not callable(velocity):
            self._velocity = validation.real(velocity, "velocity", shape=(3,), unit="m/s")
        self._fixed = isinstance(direction, Fixed) and isinstance(self._velocity, np.ndarray)

    def icrf(self, moment):
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

    def _velocity_at(self, moment):
        if isinstance(self._velocity, str):
            return moment.source.center_velocity(moment.view)
        if callable(self._velocity):
            return np.asarray(self._velocity(moment.hi + moment.lo), dtype=np.float64)
        return self._velocity

    def guess(self, source, start, length):
        return self._direction.guess(source, start, length)

    def drift(self, moment):
        return Drift() if self._fixed else estimated(moment.inertial(self), moment.step)


class OfMotion:
    """What a search takes from a motion."""

    scene = None

    def __init__(self, motion):
        self.motion = motion
        self.epoch = motion.epoch

    def at(self, hi, lo, step=None):
        return Moment(self, hi, lo, step)


class OfReception:
    """What a search takes from a scene; its epochs are those at which light is received."""

    def __init__(self, scene):
        if scene.motion is None:
            raise AttitudeError("the scene has no motion; give one, of which events are sought.")
        self.scene, self.motion, self.epoch = scene, scene.motion, scene.epoch

    def center_velocity(self, view):
        from attitude import paths

        path = paths.relative(self.scene.center, "ssb", self.scene.ephemeris)
        hi, lo = view.emission
        return path.velocity(view.epoch, hi, lo)

    def at(self, hi, lo, step=None):
        return Moment(self, hi, lo, step)


def source_of(given):
    """The source of a search: a motion, or a scene."""
    if isinstance(given, Scene):
        return OfReception(given)
    return OfMotion(motion_of(given))


def values_at(source, value, t, low=None):
    """What a function of a Moment gives at epochs t of any shape (as of ``motion.at``)."""
    hi, lo = epochs.seconds_since(source.epoch, t, low)
    flat = np.ascontiguousarray(hi).reshape(-1)
    rest = np.zeros(flat.size) if lo is None else np.ascontiguousarray(lo).reshape(-1)
    return value(source.at(flat, rest)).reshape(hi.shape)


class Moment:
    """A block of epochs hi + lo (N,): attitudes and directions, each made once.

    `step` is their spacing in seconds, where they are evenly spaced.
    """

    def __init__(self, source, hi, lo, step):
        self.source, self.hi, self.lo, self.step = source, hi, lo, step
        self._body, self._inertial = {}, {}

    @cached_property
    def view(self):
        return self.source.scene.at(self.hi, self.lo)

    @cached_property
    def history(self):
        if self.source.scene is not None:
            return self.view.attitude
        return self.source.motion.at(self.hi, self.lo)

    def body(self, direction):
        """Unit vectors (N, 3) over body axes."""
        if direction not in self._body:
            if isinstance(direction, OfScene):
                found = direction.body(self)
            else:
                wxyz = quaternion.conjugate(self.history.wxyz)
                found = quaternion.rotate(wxyz, self.inertial(direction))
            self._body[direction] = found
        return self._body[direction]

    def inertial(self, direction):
        """Unit vectors (N, 3) or (3,) over ICRF axes."""
        if direction not in self._inertial:
            self._inertial[direction] = direction.icrf(self)
        return self._inertial[direction]


def direction_of(given, name, source):
    """A direction from what a caller gives: a vector, a function, a paths direction, a name."""
    if isinstance(given, (Fixed, Moving, OfScene, Aberrated)):
        return given
    if source.scene is not None and (given is None or isinstance(given, str)):
        chosen = name if given is None else given
        return OfScene(validation.one_of(chosen, name, ("sun", "observer")))
    if given is None or isinstance(given, str):
        raise AttitudeError(
            f"{name} is {given!r}; a motion alone does not know where it is: give an ICRF vector, "
            "a function of seconds, or a Scene in place of the motion."
        )
    return Moving(given, name=name) if callable(given) else Fixed(given, name)


def _seen_rate(direction, source, start, length):
    """A look at 64 places, so that the first block is about right; blocks check themselves.

    From pairs near to each other, since what circles many times in the span is aliased else.
    """
    if not length > 0.0:
        return 0.0
    s = np.linspace(0.0, length, 65)[:-1]
    apart = length * 2.0**-26
    one, other = (direction.icrf(source.at(start[0] + t, 0.0 * t)) for t in (s, s + apart))
    fine = float(np.max(_lengths(other - one))) / apart
    coarse = float(np.max(_lengths(np.diff(one, axis=0)))) / s[1]
    return 1.25 * max(fine, coarse)


def estimated(vectors, step):
    """The drift that evenly spaced samples (N, 3) show, with a margin."""
    if vectors.ndim == 1 or not step or len(vectors) < 2:
        return Drift()
    found = [0.0, 0.0, 0.0]
    for order in range(3):
        vectors = np.diff(vectors, axis=0) / step
        if len(vectors):
            found[order] = _MARGINS[order] * float(np.max(_lengths(vectors)))
    return Drift(*found)


def _units(vectors, name):
    size = _lengths(vectors)
    if not np.all((size > 0.0) & np.isfinite(size)):
        raise AttitudeError(f"{name} gives a vector that is zero or not finite.")
    return vectors / size[..., None]


def _lengths(vectors):
    return np.sqrt(np.sum(vectors * vectors, axis=-1))
