"""What a torque is to the integrator."""

from collections.abc import Callable

import numpy as np

from attitude.epochs.inputs import Instant
from attitude.errors import AttitudeError
from attitude.immutable import Immutable
from attitude.paths.path import Path, since

# Of the attitude alone; of the angular velocity too; no torque but a slip under fixed momentum.
BY_ATTITUDE, BY_RATE, SLIP = 0, 1, 2


class Torque(Immutable):
    """The base of all torques.

    Attributes
    ----------
    kind : int
        BY_ATTITUDE, BY_RATE or SLIP.
    columns : int
        How many numbers are sampled for it at each epoch.
    """

    kind = BY_ATTITUDE
    columns = 0

    def address(self):
        """Where its compiled function is; see `attitude.solution.march`."""
        raise NotImplementedError(f"{type(self).__name__} defines no address")

    def slope_address(self):
        """Where the function for the scheme "force-gradient" is, or 0 if there is none.

        It is given a vector y in place of the angular velocity, and fills d(N . y) over turns
        about the body axes, y staying as it is over them.  Of a torque that depends on the
        attitude but has no potential: (y . d) N - N x y, which for one that has is the same.
        """
        return 0

    def parameters(self, body):
        """What its function is given, for a body: float64 (P,)."""
        return np.zeros(0)

    def sample(self, instant, seconds, low):
        """What its function is given at epochs (K,), seconds + low: float64 (K, columns)."""
        return np.zeros((len(seconds), 0))

    def span(self, instant):
        """First and last TDB seconds since an instant at which it can be sampled."""
        return -np.inf, np.inf

    def explain(self):
        """Raise what a user's function raised, if it did."""


class FunctionPath(Path):
    """Positions by a function of TDB seconds since the epoch of the spin, which is the instant.

    `positions` checks what the function returns.
    """

    name, center, source = "path", "point mass", "function of seconds"

    def __init__(self, function: Callable[[np.ndarray], np.ndarray]):
        self.function = function

    def position(self, instant, seconds, low=None):
        return self.function(seconds)


def positions(
    path: Path, instant: Instant, seconds: np.ndarray, low: np.ndarray, name: str
) -> np.ndarray:
    """Positions (K, 3) in m along a path."""
    found = path.position(instant, seconds, low)
    try:
        found = np.asarray(found, dtype=np.float64)
    except (TypeError, ValueError) as err:
        raise AttitudeError(
            f"{name} returned what is no array of numbers ({err}); it must return positions "
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
    """First and last TDB seconds since an instant that a path knows, on the safe side."""
    if path.span is None:
        return -np.inf, np.inf
    first, last = (sum(since(end, instant)) for end in path.span)
    return float(np.nextafter(first, last)), float(np.nextafter(last, first))


def path_of(given: object, name: str) -> Path:
    """The path that is given, or that follows a function of seconds."""
    if isinstance(given, Path):
        return given
    if not callable(given):
        raise AttitudeError(
            f"{name} is {given!r}; give a path, or a function of seconds (...) since the epoch of "
            "the spin that returns positions (..., 3) in m over ICRF axes."
        )
    return FunctionPath(given)
