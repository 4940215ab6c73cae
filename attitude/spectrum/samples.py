"""Samples of a light curve as numbers: seconds, values, errors and zero points, from any input."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

from attitude import epochs, validation
from attitude.epochs import kinds
from attitude.epochs.instants import Instant
from attitude.errors import AttitudeError

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import ArrayLike

    from attitude.annotations import Epochs, FloatArray, IntArray, Reals
    from attitude.spectrum.refinement import RefinedSeries

Found = TypeVar("Found")

# Least error in a search of periods, in standard deviations of the values.
_FLOOR = 0.05


class HasSamples:
    """Base of objects that are a light curve: `samples` returns it as numbers."""

    def samples(self) -> Samples:
        """The light curve as `Samples`."""
        raise NotImplementedError(f"{type(self).__name__} defines no samples")


@dataclass(frozen=True, eq=False)
class Samples:
    """A light curve as numbers.

    Attributes
    ----------
    t : (N,) array
        s, of TDB, from `epoch` or from the zero of plain seconds.
    values : (N,) array
    errors : (N,) array or None
        One standard deviation each, all above zero; None if unknown.
    curve : (N,) array of int
        The zero point that each value has, counted from 0.
    epoch : Instant or None
        None for plain seconds.
    is_flux : bool
        Whether greater values are brighter.
    names : tuple of str
        Of the curves; empty without names.
    joined : (N,) array of int or None
        Zero points in place of `curve` if all sessions share one, where it is not known whether
        they do; `settled` decides.
    """

    t: FloatArray
    values: FloatArray
    errors: FloatArray | None
    curve: IntArray
    epoch: Instant | None = None
    is_flux: bool = False
    names: tuple[str, ...] = ()
    joined: IntArray | None = None

    @property
    def span(self) -> float:
        """From the first to the last epoch, s."""
        return float(np.ptp(self.t))

    @property
    def weights(self) -> FloatArray:
        """1 / errors (N,), or ones."""
        return np.ones_like(self.t) if self.errors is None else 1.0 / self.errors

    @property
    def curves(self) -> int:
        """The number of zero points."""
        return int(self.curve.max()) + 1

    @property
    def detrended(self) -> FloatArray:
        """Values (N,) without the weighted mean of each curve."""
        weights = self.weights**2
        total = np.bincount(self.curve, weights)
        mean = np.bincount(self.curve, weights * self.values) / total
        found: FloatArray = self.values - mean[self.curve]
        return found


class GivenSamples(HasSamples):
    """Samples as an argument of functions that take a light curve."""

    def __init__(self, found: Samples) -> None:
        self._found = found

    def samples(self) -> Samples:
        """The samples."""
        return self._found


def tempered(found: Samples) -> Samples:
    """The samples with errors of at least a twentieth of the standard deviation of the values.

    Errors far below the scatter of a light curve about any series would leave most points without
    weight.
    """
    floor = _FLOOR * float(np.std(found.detrended))
    if found.errors is None or not floor > 0.0:
        return found
    return replace(found, errors=np.hypot(found.errors, floor))


def settled(
    data: Samples,
    find: Callable[[Samples], Found],
    fitted: Callable[[Found], RefinedSeries | None],
) -> Found:
    """What is found with one zero point for all sessions, or with their own if the data ask.

    Zero points of short sessions take up most of a rotation of days.  Of both results the one
    whose series has the lower N ln(chi-squared) + parameters ln N is returned (Schwarz 1978).

    Parameters
    ----------
    data : Samples
    find : callable
        What is sought in samples.
    fitted : callable
        The series of its best result; None if it is not significant.
    """
    own = replace(data, joined=None)
    if data.joined is None or data.joined.max() == data.curve.max():
        return find(own)

    def cost(found: Found) -> float:
        series = fitted(found)
        if series is None:
            return np.inf
        chi_squared = max(series.chi_squared, 1e-300)
        return float(np.log(chi_squared) + series.parameters * np.log(len(data.t)) / len(data.t))

    one = find(replace(own, curve=data.joined, names=()))
    try:
        return min((one, find(own)), key=cost)
    except AttitudeError:  # fewer values than unknowns with a zero point for each session
        return one


def of(
    t: Epochs | HasSamples,
    values: Reals | None = None,
    errors: Reals | None = None,
    curve: ArrayLike | None = None,
    zero_points: str = "auto",
) -> Samples:
    """The `Samples` of what a caller gives.

    Parameters
    ----------
    t : HasSamples, or (N,) epochs
        A light curve (`Photometry`, `LightCurve`), without values; or Time objects, dates, time
        Quantities, plain seconds, in any order.
    values : (N,) array_like
        Magnitudes or intensities; Quantities in any unit.
    errors : (N,) array_like or float, optional
        In the unit of the values.
    curve : (N,) array_like of int, optional
    zero_points : "auto", "free" or "shared"
        Of the sessions of a light curve: "auto" leaves it to `settled`.

    Raises
    ------
    AttitudeError
        For arrays of different lengths, errors that are not above zero, gaps in the numbers of
        curves.

    Warns
    -----
    AttitudeWarning
        If plain numbers are Julian dates, which count as seconds.
    """
    validation.one_of(zero_points, "zero_points", ("auto", "free", "shared"))
    if isinstance(t, HasSamples):
        if values is not None or errors is not None or curve is not None:
            raise AttitudeError(
                f"t is a {type(t).__name__}, which has its values, errors and curves; leave those "
                "arguments out."
            )
        made = t.samples()
        if zero_points == "free" or made.joined is None:
            return replace(made, joined=None)
        if zero_points == "shared":
            return replace(made, curve=made.joined, names=(), joined=None)
        return made
    if values is None:
        raise AttitudeError("values is missing; give a value for each epoch, or a Photometry as t.")
    epoch, seconds = _seconds(t)
    if seconds.ndim != 1 or not seconds.size:
        raise AttitudeError(f"t has shape {seconds.shape}; give a row of epochs, (N,).")
    shape = seconds.shape
    unit, numbers = _unit(values)
    found = validation.real(numbers, "values", shape=shape)
    return Samples(
        seconds,
        found,
        _errors(errors, unit, shape),
        _curves(curve, shape),
        epoch,
        is_flux=unit is not None and not unit.is_equivalent("mag"),
    )


def _seconds(t: Any) -> tuple[Instant | None, FloatArray]:
    kind, _, _ = kinds.entries(t, "t", "epochs")
    if kind in kinds.LENGTHS:
        found = np.array(epochs.seconds_since(Instant(0.0), t)[0], dtype=np.float64)
        if not np.all(np.isfinite(found)):
            raise AttitudeError(
                f"t holds {found[~np.isfinite(found)].flat[0]}; give finite epochs."
            )
        return None, found
    hi, lo = epochs.past_j2000(t, "t")
    if not np.all(np.isfinite(hi)):
        raise AttitudeError("t has entries that are not epochs; leave these points out.")
    epoch = Instant(float(np.round(0.5 * (np.min(hi) + np.max(hi)))) if hi.size else 0.0)
    return epoch, np.asarray((hi - epoch.seconds) + lo)


def _unit(values: Any) -> tuple[Any, Any]:
    """The unit of Quantities and of columns, and the numbers."""
    unit = getattr(values, "unit", None)
    if unit is None:
        return None, values
    quantity = getattr(values, "quantity", values)
    return unit, quantity.value


def _errors(errors: Any, unit: Any, shape: tuple[int, ...]) -> FloatArray | None:
    if errors is None:
        return None
    own, numbers = _unit(errors)
    if own is not None and unit is not None and own != unit:
        numbers = getattr(errors, "quantity", errors).to_value(unit)
    given = np.broadcast_to(validation.real(numbers, "errors", shape=None), shape).copy()
    if not np.all(given > 0.0):
        bad = given[~(given > 0.0)][0]
        raise AttitudeError(
            f"errors holds {bad}; give errors above zero, or leave such values out."
        )
    return given


def _curves(curve: Any, shape: tuple[int, ...]) -> IntArray:
    numbers = np.zeros(shape, np.int64) if curve is None else np.asarray(curve)
    if numbers.shape != shape or numbers.dtype.kind not in "iu":
        raise AttitudeError(
            f"curve is {validation.shown(curve)}; give whole numbers from 0, of shape {shape}."
        )
    count = int(numbers.max()) + 1
    if set(np.unique(numbers)) != set(range(count)):
        raise AttitudeError(
            f"curve does not hold every number from 0 to its greatest, {count - 1}; "
            "number the curves without gaps."
        )
    return numbers.astype(np.int64)
