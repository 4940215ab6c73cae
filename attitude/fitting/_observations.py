"""What was observed at N epochs, compared with a predicted motion.

Three kinds of records: attitudes, angular velocities, directions.  Residuals are vectors over axes
in which they are not turned by the weights: each record has one standard error.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from attitude._support import validation
from attitude._support.pairs import Seconds
from attitude.epochs import _inputs
from attitude.errors import AttitudeError
from attitude.frames import quaternion
from attitude.frames import representations as forms

if TYPE_CHECKING:
    from typing import Any, Self

    from attitude._support.annotations import Epoch, Epochs, FloatArray, Reals
    from attitude.epochs._instants import Instant
    from attitude.fitting._model import Prediction
    from attitude.motions._history import AttitudeHistory


# Rounding error of predicted attitudes, rad, and of rates relative to their size.
_ROUNDING = 4e-15
# That of both, relative to the angle turned, by the rounding of the parameters.
_OF_ANGLE = 4e-16
# The largest standard error, and the inverse of the least: their squares are numbers.
_EXTREME = 1e100


@dataclass(frozen=True)
class Measured:
    """Base of kinds of N records of `dimensions` numbers; weights (N,), 1 / standard errors."""

    weight: FloatArray
    dimensions = 3

    def at(self, index: Any) -> Self:
        """Some of the records."""
        return type(self)(**{name: array[index] for name, array in vars(self).items()})

    def compare(self, predicted: Prediction) -> tuple[FloatArray, FloatArray]:
        """Residuals (3, N), and the derivatives (3, P, N) of what is predicted."""
        raise NotImplementedError(f"{type(self).__name__} defines no compare")

    def residuals(self, predicted: Prediction) -> FloatArray:
        """Residuals (N, 3) over the body axes."""
        raise NotImplementedError(f"{type(self).__name__} defines no residuals")

    def scale(self) -> float:
        """The size of a residual that stands for 1 rad."""
        return 1.0


@dataclass(frozen=True)
class Attitudes(Measured):
    """Attitudes (N, 4), body to ICRF; residuals are turns from the model to the record, rad."""

    wxyz: FloatArray

    def compare(self, predicted: Prediction) -> tuple[FloatArray, FloatArray]:
        """Residuals over ICRF axes, and derivatives."""
        turn = quaternion.multiply(self._records(predicted), quaternion.conjugate(predicted.wxyz))
        return forms.to_rotation_vector(turn).T, predicted.attitude

    def residuals(self, predicted: Prediction) -> FloatArray:
        """Turns from the model to each record, body axes."""
        turn = quaternion.multiply(quaternion.conjugate(predicted.wxyz), self._records(predicted))
        return forms.to_rotation_vector(turn) @ predicted.axes.T

    def _records(self, predicted: Prediction) -> FloatArray:
        """The attitudes (N, 4) of the principal axes."""
        if predicted.to_body is None:
            return self.wxyz
        return quaternion.multiply(self.wxyz, predicted.to_body)


@dataclass(frozen=True)
class Rates(Measured):
    """Angular velocities (N, 3), rad/s over the body axes; residuals are records less model."""

    omega: FloatArray

    def compare(self, predicted: Prediction) -> tuple[FloatArray, FloatArray]:
        """Residuals over the principal axes, and derivatives."""
        assert predicted.omega is not None and predicted.rates is not None
        return (self.omega @ predicted.axes - predicted.omega).T, predicted.rates

    def residuals(self, predicted: Prediction) -> FloatArray:
        """Records less model, rad/s, body axes."""
        assert predicted.omega is not None
        return self.omega - predicted.omega @ predicted.axes.T

    def scale(self) -> float:
        """The mean size, rad/s."""
        return float(np.sqrt(np.mean(np.sum(self.omega**2, axis=1)))) or 1.0


@dataclass(frozen=True)
class Directions(Measured):
    """Directions, unit vectors (N, 3) over the body axes and over ICRF axes.

    A residual is the least turn that takes the measured direction, as the model places it in
    inertial space, to the known one.
    """

    measured: FloatArray
    known: FloatArray
    dimensions = 2

    def compare(self, predicted: Prediction) -> tuple[FloatArray, FloatArray]:
        """Residuals over ICRF axes, and derivatives without the turn about the direction."""
        # Across the known direction and not the measured one, so that noise does not count as
        # information on the turn about a direction that all records share.
        known = np.ascontiguousarray(self.known.T)[:, None]
        along = (known * predicted.attitude).sum(axis=0)
        return self._turns(predicted), predicted.attitude - known * along

    def residuals(self, predicted: Prediction) -> FloatArray:
        """The least turns, body axes."""
        turn = self._turns(predicted).T
        turned = quaternion.rotate(quaternion.conjugate(predicted.wxyz), turn)
        return turned @ predicted.axes.T

    def _turns(self, predicted: Prediction) -> FloatArray:
        """The turns (3, N) from the measured directions in inertial space to the known ones."""
        placed = quaternion.rotate(predicted.wxyz, self.measured @ predicted.axes)
        normal = np.cross(placed, self.known)
        sine = np.linalg.norm(normal, axis=1)
        angle = np.arctan2(sine, np.sum(placed * self.known, axis=1))
        ratio = np.divide(angle, sine, out=np.ones_like(angle), where=sine > 0.0)
        return (normal * ratio[:, None]).T


@dataclass(frozen=True)
class Observations:
    """Records of one kind or more at N epochs."""

    epoch: Instant  # of the first record
    t: FloatArray  # (N,), TDB seconds since then
    kinds: tuple[Measured, ...]  # records of N epochs each

    def __len__(self) -> int:
        return len(self.t)

    def at(self, index: Any) -> Observations:
        """Some of the records."""
        kinds = tuple(kind.at(index) for kind in self.kinds)
        return replace(self, t=self.t[index], kinds=kinds)

    @property
    def used(self) -> int:
        """The number of records that are not left out by infinite errors."""
        return int(np.count_nonzero(sum(kind.weight for kind in self.kinds)))

    @property
    def with_rates(self) -> bool:
        """Whether angular velocities are among the records."""
        return any(isinstance(kind, Rates) for kind in self.kinds)


def epochs_of(
    t: Epochs, epoch: Epoch | None, *, repeated: bool = False
) -> tuple[Instant, FloatArray]:
    """The first epoch of records, and the TDB seconds (N,) of all of them since then; t (N,)."""
    origin = _inputs.instant(epoch, "epoch") if epoch is not None else _first(t)
    hi, lo = _inputs.seconds_since(origin, t)
    if hi.ndim != 1 or not len(hi):
        raise AttitudeError(f"t has shape {hi.shape}; give one row of epochs, (N,).")
    low = Seconds(hi, lo).low
    return _since_first(origin, hi, low, "t", repeated=repeated)


def epochs_of_history(history: AttitudeHistory) -> tuple[Instant, FloatArray]:
    """The first epoch of a history (N,), and the TDB seconds (N,) since then."""
    return _since_first(history.epoch, *Seconds.of(history).flat, "table", repeated=False)


def _since_first(
    origin: Instant, seconds: FloatArray, low: FloatArray, name: str, *, repeated: bool
) -> tuple[Instant, FloatArray]:
    """The first of epochs (N,) after an origin, and the seconds since then."""
    since = (seconds - seconds[0]) + (low - low[0])
    step = np.diff(since)
    if not np.all(np.isfinite(since)) or np.any(step < 0.0 if repeated else step <= 0.0):
        raise AttitudeError(
            f"{name} holds epochs that are not finite or do not increase; give the records in the "
            "order of time."
        )
    return origin.after(seconds[0], low[0]), since


def _first(t: Epochs) -> Instant:
    """The first of epochs; AttitudeError for plain seconds."""
    times: Any = t
    try:
        return _inputs.instant(times[0], "t")
    except (AttitudeError, TypeError, IndexError, KeyError) as err:
        raise AttitudeError(
            f"t is {validation.shown(t)}; give one row of epochs, (N,), or plain seconds since an "
            "epoch, with epoch=."
        ) from err


def weights(sigma: Reals | None, count: int, name: str, unit: str) -> FloatArray:
    """1 / standard errors (N,); ones if they are None, 0 of infinite errors."""
    if sigma is None:
        return np.ones(count)
    errors = validation.real(sigma, name, unit=unit, finite=False)
    known = (errors >= 1.0 / _EXTREME) & ((errors <= _EXTREME) | (errors == np.inf))
    if errors.shape not in ((), (count,)) or not np.all(known):
        raise AttitudeError(
            f"{name} is {validation.shown(sigma)}; give one number greater than zero, or one "
            f"for each record, from {1.0 / _EXTREME:g} to {_EXTREME:g}; inf leaves records out."
        )
    return np.broadcast_to(1.0 / errors, (count,))


def floor(observed: Observations, speed: float) -> float:
    """The sum of squares of weighted residuals that are rounding errors.

    Those of the parameters grow with the angle turned, at `speed` in rad/s.
    """
    error = _ROUNDING + _OF_ANGLE * speed * observed.t
    kinds = observed.kinds
    return float(sum(np.sum((error * kind.scale() * kind.weight) ** 2) for kind in kinds))
