"""Instantaneous changes between free arcs: angular momentum added, inertia replaced."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

from attitude import frames, validation
from attitude.body import Body
from attitude.errors import AttitudeError
from attitude.immutable import Valued, frozen

if TYPE_CHECKING:
    from attitude.annotations import EpochOrSeconds, FloatArray, Reals
    from attitude.arcs.triggers import Trigger
    from attitude.history import AttitudeHistory

    MomentumFunction = Callable[[AttitudeHistory], Reals]


class Change(Valued):
    """Base of `Impulse` and `InertiaChange`.

    Attributes
    ----------
    at : epoch, seconds or Trigger
        As given.
    angular_momentum : (3,) array, or function
        kg m2/s.
    frame : str
    """

    at: EpochOrSeconds | Trigger
    angular_momentum: FloatArray | MomentumFunction
    frame: str
    _value: tuple[str, ...] = ("at", "angular_momentum", "frame")

    def _set_change(
        self,
        at: EpochOrSeconds | Trigger,
        angular_momentum: Reals | MomentumFunction,
        frame: str,
    ) -> None:
        """Check and keep the attributes, while the object is constructed."""
        self._set("at", at)
        self._set("frame", frame if frame == "body" else frames.known(frame))
        if not callable(angular_momentum):
            angular_momentum = frozen(
                validation.real(angular_momentum, "angular_momentum", shape=(3,), unit="kg m2/s")
            )
        self._set("angular_momentum", angular_momentum)

    def added_momentum(self, before: Callable[[], AttitudeHistory], name: str) -> FloatArray:
        """Angular momentum (3,) that the change adds, kg m2/s in its frame.

        Parameters
        ----------
        before : function
            Returns the history of the epoch of the change, before it.
        name : str
            Of the change in error messages.

        Raises
        ------
        AttitudeError
            If a function returns another shape or unit, or numbers that are not finite.
        """
        momentum = self.angular_momentum
        if not callable(momentum):
            return momentum
        value = momentum(before())
        return validation.real(value, f"{name}.angular_momentum(...)", shape=(3,), unit="kg m2/s")


@dataclass(frozen=True, eq=False, init=False)
class Impulse(Change):
    """Angular momentum added in an instant.

    Parameters
    ----------
    at : epoch, seconds or Trigger
        TDB seconds since the epoch of the spin, an epoch of any kind that `Spin` takes, or an
        event such as `PointMeetsPlane`: its first time after the change before.
    angular_momentum : (3,) array_like, or function
        kg m2/s (in the body's unit of inertia if that is relative).  A function is called with
        the AttitudeHistory of that one epoch, before the change, and returns the vector.
    frame : str
        "body": over the body axes at that epoch; "icrf", "eme2000" or "ecliptic".

    Attributes
    ----------
    at : as given
    angular_momentum : (3,) array, or function
    frame : str

    Raises
    ------
    AttitudeError
        For another shape or unit, numbers that are not finite, and an unknown frame.
    """

    at: EpochOrSeconds | Trigger
    angular_momentum: FloatArray | MomentumFunction
    frame: str = "body"

    def __init__(
        self,
        at: EpochOrSeconds | Trigger,
        angular_momentum: Reals | MomentumFunction,
        frame: str = "body",
    ) -> None:
        self._set_change(at, angular_momentum, frame)


@dataclass(frozen=True, eq=False, init=False)
class InertiaChange(Change):
    """The body becomes another in an instant: a boom is deployed, a servicer docks.

    Body axes, attitude and angular momentum stay; the angular velocity follows from them.

    Parameters
    ----------
    at : epoch, seconds or Trigger
        As for `Impulse`.
    body : Body
        The body from then on, over the same body axes.
    angular_momentum : (3,) array_like, or function
        Angular momentum added by the change, such as that of a servicer; as for `Impulse`.
    frame : str
        As for `Impulse`.

    Attributes
    ----------
    at : as given
    body : Body
    angular_momentum : (3,) array, or function
    frame : str

    Raises
    ------
    AttitudeError
        As for `Impulse`, and for anything but a Body.
    """

    at: EpochOrSeconds | Trigger
    body: Body
    angular_momentum: FloatArray | MomentumFunction
    frame: str = "body"
    _value = ("at", "body", "angular_momentum", "frame")

    def __init__(
        self,
        at: EpochOrSeconds | Trigger,
        body: Body,
        angular_momentum: Reals | MomentumFunction = (0.0, 0.0, 0.0),
        frame: str = "body",
    ) -> None:
        if not isinstance(body, Body):
            raise AttitudeError(f"body is {type(body).__name__}; give a Body.")
        self._set("body", body)
        self._set_change(at, angular_momentum, frame)
