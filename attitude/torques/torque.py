"""The base class of torques: the members that a splitting integrator uses."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from attitude import validation
from attitude.errors import AttitudeError
from attitude.immutable import Immutable
from attitude.paths.path import Path, since

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import ArrayLike, NDArray

    from attitude.annotations import FloatArray
    from attitude.body import Body
    from attitude.epochs.instants import Instant

    # TDB seconds (...) since the epoch of the spin to positions (..., 3) in m, ICRF axes.
    PositionFunction: TypeAlias = Callable[[FloatArray], NDArray[Any]]

# Kinds: a torque that depends on the attitude alone; one that depends on the angular velocity
# too; no torque, but a slip of the body under a fixed angular momentum; a torque that is
# the angular velocity times a constant matrix, `Torque.by_rate`.
BY_ATTITUDE: int = 0
BY_RATE: int = 1
SLIP: int = 2
LINEAR: int = 3


class Torque(Immutable):
    """The base of all torques.

    Attributes
    ----------
    kind : int
        BY_ATTITUDE, BY_RATE, SLIP or LINEAR.
    columns : int
        Count of the numbers that `sample` returns for each epoch.
    is_users : bool
        Whether the function is a user's, which only machine code calls: its exceptions, and
        Ctrl-C, then leave the state of the motion as it was.
    """

    kind: int = BY_ATTITUDE
    columns: int = 0
    is_users: bool = False

    def address(self) -> int:
        """Address of the compiled function of the torque; see `attitude.solution.torqued_step`."""
        raise NotImplementedError(f"{type(self).__name__} defines no address")

    def slope_address(self) -> int:
        """Address of the compiled function for the scheme "force-gradient"; 0 without one.

        The function takes a vector y, constant over the body axes, in place of the angular
        velocity, and returns the derivatives of N . y by turns about the body axes.  For a torque
        that depends on the attitude but has no potential it returns (y . d) N - N x y, which
        equals these derivatives where a potential exists.
        """
        return 0

    def parameters(self, body: Body) -> FloatArray:
        """Constants (P,) that the compiled function takes, for a body."""
        return np.zeros(0)

    def by_rate(self) -> FloatArray:
        """The matrix (3, 3) of a LINEAR torque, N m s: torque by angular velocity, body axes."""
        return np.zeros((3, 3))

    def sample(self, instant: Instant, seconds: FloatArray, low: FloatArray) -> FloatArray:
        """Numbers (K, columns) that the compiled function takes at each epoch.

        Parameters
        ----------
        instant : Instant
        seconds, low : (K,) float64 arrays
            The epochs are instant + seconds + low, TDB.
        """
        return np.zeros((len(seconds), 0))

    def span(self, instant: Instant) -> tuple[float, float]:
        """First and last TDB seconds since an instant at which `sample` is defined."""
        return -np.inf, np.inf


class FunctionPath(Path):
    """Positions by a function of TDB seconds since the instant, the epoch of the spin.

    `positions` checks what the function returns.
    """

    name, center, source = "path", "point mass", "function of seconds"

    def __init__(self, function: PositionFunction) -> None:
        self.function = function

    def position(
        self, instant: Instant, seconds: ArrayLike, low: ArrayLike | None = None
    ) -> FloatArray:
        """Result of the function: positions (..., 3) in m, ICRF axes; `low` is not used."""
        return self.function(np.asarray(seconds, dtype=np.float64))


def positions(
    path: Path, instant: Instant, seconds: FloatArray, low: FloatArray, name: str
) -> FloatArray:
    """Positions (K, 3) in m along a path, ICRF axes, at instant + seconds + low.

    Raises
    ------
    AttitudeError
        For results of another shape or type, and for numbers that are not finite.
    """
    found = path.position(instant, seconds, low)
    try:
        found = np.asarray(found, dtype=np.float64)
    except (TypeError, ValueError) as err:
        raise AttitudeError(
            f"{name} did not return an array of numbers ({err}); it must return positions "
            "(..., 3) in m over ICRF axes."
        ) from None
    if found.shape != (len(seconds), 3):
        raise AttitudeError(
            f"{name} returned an array of shape {found.shape} for {len(seconds)} epochs; it must "
            "return positions (..., 3) in m over ICRF axes for an array of seconds (...)."
        )
    if not np.all(np.isfinite(found)):
        bad = float(seconds[np.flatnonzero(~np.all(np.isfinite(found), axis=-1))[0]])
        raise AttitudeError(
            f"{name} is not finite {bad:.9g} s after the epoch of the spin; give a path that "
            "covers the span."
        )
    return found


def span_of(path: Path, instant: Instant) -> tuple[float, float]:
    """First and last TDB seconds since an instant that a path covers, rounded inwards."""
    if path.span is None:
        return -np.inf, np.inf
    first, last = (sum(since(end, instant)) for end in path.span)
    return float(np.nextafter(first, last)), float(np.nextafter(last, first))


def path_of(given: Path | PositionFunction, name: str) -> Path:
    """The path itself, or the `FunctionPath` of a function of seconds.

    Raises
    ------
    AttitudeError
        If `given` is neither.
    """
    if isinstance(given, Path):
        return given
    validation.refuse_class(given, name)
    if not callable(given):
        raise AttitudeError(
            f"{name} is {given!r}; give a path, or a function of seconds (...) since the epoch of "
            "the spin that returns positions (..., 3) in m over ICRF axes."
        )
    return FunctionPath(given)
