"""What a motion is: something with an attitude at any TDB epoch of its span.

Free rotations, chains of arcs, torqued motions, tables and C-kernels are motions; events, scenes,
files and the command line use the members of `Motion` and no others.
"""

from __future__ import annotations

from types import MappingProxyType
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from attitude import epochs
from attitude.errors import AttitudeError
from attitude.history import AttitudeHistory
from attitude.immutable import Immutable, frozen

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import ArrayLike, NDArray

    from attitude.body import Body

_NO_JOINTS = frozen(np.zeros(0))


class RateBounds(NamedTuple):
    """Upper bounds of |(R a)'|, |(R a)''|, |(R a)'''| for any unit vector a fixed in the body.

    In rad/s, rad/s2, rad/s3; inf where there is none.
    """

    first: float
    second: float
    third: float


class Motion(Immutable):
    """The base of all motions; it writes once what follows from attitudes at epochs.

    A new kind defines

    ``epoch``
        Instant from which its seconds count.
    ``_evaluate(seconds, low, order)``
        Attitudes (..., 4) body to ICRF, for an order of 1 or more angular velocities (..., 3) in
        rad/s over the body axes, for 2 angular accelerations (..., 3) in rad/s2, as a list, at
        TDB seconds + low since the epoch (float64 arrays of any shape; low may be None).  It may
        hold more than `order` wants.  NaN for NaN; an AttitudeError outside of its span.

    and, where what stands here does not hold,

    ``span``
        First and last Instant at which it answers, or None: any epoch.
    ``joints``
        (N,) TDB seconds since the epoch, ascending, at which the angular velocity jumps.  Writers
        of files start a new segment there.
    ``body``; ``body_at(t)``, ``constant_body(what)``, ``momentum_in_body(history)``
        The Body at the epoch, None where the inertia is unknown; the others where it changes.
    ``momentum``
        (3,) angular momentum in ICRF if it is constant, else None.
    ``smooth``
        Whether angular accelerations are known and continuous between joints.
    ``rate_bounds(seconds)``
        `RateBounds` that hold from there to the next joint, or None: only samples tell.
    ``has_rates_at(seconds, low)``
        Whether it knows angular velocities there better than from differences of attitudes.
    ``meta``
        What the file that it was read from says besides: names, comments.
    ``close()``
        Release what it holds; motions are context managers.

    >>> from attitude import Body, Spin
    >>> class Swing(Motion):                # about z, 0.1 rad to either side, once a second
    ...     epoch = epochs.instant("2026-01-01")
    ...     def _evaluate(self, seconds, low, order):
    ...         w = 2.0 * np.pi
    ...         angle, zero = 0.05 * np.sin(w * seconds), 0.0 * seconds
    ...         wxyz = np.stack([np.cos(angle), zero, zero, np.sin(angle)], axis=-1)
    ...         rate = np.stack([zero, zero, 0.1 * w * np.cos(w * seconds)], axis=-1)
    ...         bend = np.stack([zero, zero, -0.1 * w**2 * np.sin(w * seconds)], axis=-1)
    ...         return [wxyz, rate, bend]
    >>> Swing().at([0.0, 0.25]).angular_velocity.round(6) + 0.0
    array([[0.      , 0.      , 0.628319],
           [0.      , 0.      , 0.      ]])
    """

    epoch: epochs.Instant
    span: tuple[epochs.Instant, epochs.Instant] | None = None
    joints: NDArray[np.float64] = _NO_JOINTS
    body: Body | None = None
    momentum: NDArray[np.float64] | None = None
    smooth: bool = False
    meta: Mapping[str, Any] = MappingProxyType({})

    def _evaluate(
        self, seconds: NDArray[np.float64], low: NDArray[np.float64] | None, order: int
    ) -> list[NDArray[np.float64]]:
        raise NotImplementedError(f"{type(self).__name__} defines no _evaluate")

    def at(self, t: Any, low: ArrayLike | None = None) -> AttitudeHistory:
        """The attitudes at some epochs.

        Parameters
        ----------
        t : array_like
            TDB seconds since the epoch of the motion (plain numbers or time Quantities), or epochs:
            astropy Time, skyfield Time, datetime, datetime64, ISO text in UTC, or lists of them.
            A scalar gives a scalar history; NaN gives NaN.
        low : array_like, optional
            With plain numbers: a second double, t + low being the seconds.

        Returns
        -------
        AttitudeHistory

        Raises
        ------
        AttitudeError
            For epochs that cannot be read, or outside of the span of the motion.
        """
        seconds, low = epochs.seconds_since(self.epoch, t, low)
        found = self._evaluate(seconds, low, 0)
        # The history makes its arrays read-only, so what was given is copied.
        kept = None if low is None else np.array(low)
        history = AttitudeHistory(self, self.epoch, np.array(seconds), kept, found[0])
        if len(found) > 1:
            history.__dict__["angular_velocity"] = frozen(found[1])
        return history

    def angular_velocity_at(
        self, seconds: ArrayLike, low: ArrayLike | None = None
    ) -> NDArray[np.float64]:
        """Angular velocity (..., 3), rad/s in body axes, at TDB seconds since the epoch."""
        return self._evaluate(*_as_arrays(seconds, low), 1)[1]

    def angular_acceleration_at(
        self,
        seconds: ArrayLike,
        low: ArrayLike | None = None,
        *,
        angular_velocity: NDArray[np.float64] | None = None,
    ) -> NDArray[np.float64]:
        """Its rate of change (..., 3), rad/s2 in body axes, at TDB seconds since the epoch.

        Motions with a body need no second evaluation where the angular velocity there is given.
        """
        return self._evaluate(*_as_arrays(seconds, low), 2)[2]

    def body_at(self, t: Any) -> Body | None:
        """The Body at one epoch, of any kind that `at` takes."""
        return self.body

    def constant_body(self, what: str) -> Body:
        """The Body that the motion has at all epochs.

        Parameters
        ----------
        what : str
            What it is wanted for, as the error message begins.

        Raises
        ------
        AttitudeError
            If the motion has no body, or one that changes.
        """
        if self.body is None:
            raise AttitudeError(
                f"{what} follows from a body's inertia, but the motion ({type(self).__name__}) has "
                "none, or one that changes; give a motion with one body."
            )
        return self.body

    def momentum_in_body(self, history: AttitudeHistory) -> NDArray[np.float64]:
        """Angular momentum (S, 3), kg m2/s over the body axes, at the epochs of a history.

        Raises
        ------
        AttitudeError
            If the motion has no body.
        """
        return history.angular_velocity @ self.constant_body("the angular momentum").tensor

    @property
    def regime(self) -> Any:
        """The `Regime`: periods and ranges of a free rotation.

        Raises
        ------
        AttitudeError
            For any other motion.
        """
        raise AttitudeError(
            f"{type(self).__name__} has no regime, periods or mode; give a FreeRotation."
        )

    def rate_bounds(self, seconds: float) -> RateBounds | None:
        """Upper bounds from TDB seconds since the epoch to the next joint, or None."""
        return None

    def has_rates_at(self, seconds: ArrayLike, low: ArrayLike | None = None) -> bool:
        """Whether angular velocities there are known better than from differences of attitudes."""
        return True

    def close(self) -> None:
        """Release what the motion holds; a second time does nothing."""

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()


class Foreign(Motion):
    """Any other object with ``.at(t)`` that returns an AttitudeHistory, as a Motion.

    Parameters
    ----------
    given : object
        Its ``epoch``, or that of its ``spin``, says what seconds count from; else the epoch of its
        histories.  ``body`` and ``momentum`` are used where it has them.
    """

    def __init__(self, given: Any):
        self._set("given", given)
        self._set("epoch", _epoch_of(given))
        for name in ("body", "momentum", "span", "meta"):
            if getattr(given, name, None) is not None:
                self._set(name, getattr(given, name))

    def at(self, t, low=None):
        return self.given.at(t) if low is None else self.given.at(t, low=low)

    def _evaluate(self, seconds, low, order):
        history = self.at(seconds, low)
        found = [history.wxyz]
        if order > 0:
            found.append(history.angular_velocity)
        if order > 1:
            found.append(history.angular_acceleration)
        return found


def motion_of(given: Any, name: str = "motion") -> Motion:
    """The motion itself, or one that wraps any other object with ``.at(t)``.

    Raises
    ------
    AttitudeError
        For what has no ``.at(t)``, and where it cannot be known what its seconds count from.
    """
    if isinstance(given, Motion):
        return given
    if isinstance(given, type):
        raise AttitudeError(
            f"{name} is the class {given.__name__}; give one of its objects, as {given.__name__}"
            "(...) makes them."
        )
    if not callable(getattr(given, "at", None)):
        raise AttitudeError(
            f"{name} is {type(given).__name__}; give a FreeRotation, or anything else with .at(t) "
            "that returns an AttitudeHistory."
        )
    return Foreign(given)


def _epoch_of(given):
    for owner in (given, getattr(given, "spin", None)):
        if isinstance(getattr(owner, "epoch", None), epochs.Instant):
            return owner.epoch
    raise AttitudeError(
        f"the motion ({type(given).__name__}) has neither .epoch nor .spin, so that it is not "
        "known what its seconds count from; give it one of them."
    )


def _as_arrays(seconds, low):
    seconds = np.asarray(seconds, dtype=np.float64)
    return seconds, None if low is None else np.asarray(low, dtype=np.float64)
