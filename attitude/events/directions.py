"""The directions that a search compares with body axes: fixed, moving, or those of a scene."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from attitude import paths, validation
from attitude.conditions.moments import Drift, SearchDirection, lengths
from attitude.errors import AttitudeError
from attitude.paths.uniform import Direction
from attitude.physical_constants import SPEED_OF_LIGHT_M_S
from attitude.validation import unit_vector

if TYPE_CHECKING:
    from collections.abc import Callable
    from typing import TypeAlias

    from numpy.typing import ArrayLike

    from attitude.annotations import FloatArray, Real, Reals
    from attitude.conditions.moments import Moment, Pair, Source
    from attitude.scene.view import View

    # Vectors (N, 3) at seconds (N,) since the epoch of the motion.
    VectorFunction: TypeAlias = Callable[[FloatArray], ArrayLike]
    # Whatever `direction_of` takes.
    AnyDirection: TypeAlias = Reals | Direction | SearchDirection | VectorFunction


class Fixed(SearchDirection):
    """A constant direction.

    Parameters
    ----------
    vector : (3,) array_like or Direction
        On ICRF axes, of any length.
    name : str
        For error messages.

    Attributes
    ----------
    vector : (3,) array
        Unit vector, ICRF.
    """

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
        For a bound that is not one finite number; in a search, for vectors of another shape, of
        length zero, or that are not finite.
    """

    def __init__(
        self,
        function: VectorFunction,
        rate: Real | None = None,
        acceleration: Real | None = None,
        name: str = "direction",
    ) -> None:
        self.function, self.name = function, name
        self.rate = None if rate is None else validation.number(rate, "rate")
        self.acceleration = (
            None if acceleration is None else validation.number(acceleration, "acceleration")
        )

    def icrf(self, moment: Moment) -> FloatArray:
        """Unit vectors (N, 3) along those of the function."""
        seconds = moment.hi + moment.lo
        vectors = np.asarray(self.function(seconds), dtype=np.float64)
        if vectors.shape != (*seconds.shape, 3):
            raise AttitudeError(
                f"{self.name} returns vectors of shape {vectors.shape} for {seconds.size} epochs; "
                f"it must return {(*seconds.shape, 3)}."
            )
        return _units(vectors, self.name)

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
    """The apparent direction of incoming light, or the direction of emission, of a moving body.

    Parameters
    ----------
    direction : SearchDirection
    velocity : (3,) array_like, function (N,) -> (N, 3), or "center"
        Velocity of the body relative to the frame of the direction, m/s on ICRF axes; "center":
        the barycentric velocity of the scene's center.
    source : Source
    sent : bool
        False for incoming light: its apparent direction is shifted towards the velocity.  True for
        light that the body sends in the given direction of that frame: in the frame of the body
        it leaves in a direction shifted away from the velocity.

    Raises
    ------
    AttitudeError
        For "center" without a scene that has a center; in a search, for a velocity that is not
        below the speed of light.

    Notes
    -----
    The Lorentz transformation of the direction of light, Einstein (1905), section 7:
    u' = (u / g + b + (g / (g + 1)) (b.u) b) / (1 + b.u), with g = 1 / sqrt(1 - b^2), b = v / c.
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
        if isinstance(self._velocity, str):
            return _center_velocity(moment.view)
        if callable(self._velocity):
            return np.asarray(self._velocity(moment.hi + moment.lo), dtype=np.float64)
        return self._velocity

    def guess(self, source: Source, start: Pair, length: float) -> float:
        """The guess for the direction without aberration."""
        return self._direction.guess(source, start, length)

    def drift(self, moment: Moment) -> Drift:
        """Zeros for a constant direction and velocity; otherwise estimates from samples."""
        return Drift() if self._fixed else super().drift(moment)


def direction_of(given: AnyDirection | None, name: str, source: Source) -> SearchDirection:
    """The SearchDirection that a caller gives.

    Parameters
    ----------
    given : (3,) array_like, Direction, function (N,) -> (N, 3), SearchDirection, text or None
        In a scene also "sun" or "observer"; None stands for `name`.
    name : str
        Of the argument, for error messages.
    source : Source

    Raises
    ------
    AttitudeError
        For other values, and for text or None without a scene.
    """
    if isinstance(given, SearchDirection):
        return given
    if source.scene is not None and (given is None or isinstance(given, str)):
        chosen = name if given is None else given
        return OfScene(validation.one_of(chosen, name, ("sun", "observer")))
    if given is None or isinstance(given, str):
        raise AttitudeError(
            f"{name} is {given!r}, but a motion without a scene has no position; give an ICRF "
            "vector, a function of seconds, or a Scene instead of the motion."
        )
    if callable(given):
        return Moving(given, name=name)
    return Fixed(given, name)


def _center_velocity(view: View) -> FloatArray:
    """Barycentric velocity (N, 3) of the scene's center at the epochs of emission, m/s, ICRF."""
    scene = view.scene
    assert scene.center is not None
    hi, lo = view.emission
    return paths.relative(scene.center, "ssb", scene.ephemeris).velocity(view.epoch, hi, lo)


def _units(vectors, name):
    size = lengths(vectors)
    if not np.all((size > 0.0) & np.isfinite(size)):
        raise AttitudeError(f"{name} gives a vector that is zero or not finite.")
    return vectors / size[..., None]
