"""`fold`: a light curve folded with one period or with two, its series and the residuals."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from attitude._support import quantity_text, validation
from attitude._support.arrays import Immutable, frozen
from attitude._support.synonyms import arguments
from attitude.epochs import _inputs, _instants
from attitude.errors import AttitudeError
from attitude.photometry import _samples, _spectrum
from attitude.photometry._curve import LightCurve

if TYPE_CHECKING:
    from astropy.table import QTable
    from numpy.typing import ArrayLike

    from attitude._support.annotations import Epoch, Epochs, FilePath, FloatArray, Real, Reals
    from attitude.photometry._samples import Samples


@dataclass(frozen=True, eq=False, repr=False)
class Folded(Immutable):
    """A light curve folded with D periods, 1 or 2.

    Attributes
    ----------
    periods : (D,) array
        s.
    phase : (D, N) array
        0 to 1 from the epoch.
    values : (D, N) array
        Without zero points and, of two periods, without the lines of the series that depend on the
        other one.
    residuals : (N,) array
        Values minus the series.
    rms : float
        Of the residuals, in the unit of the values.
    series : RefinedSeries
        Fitted at these periods.
    samples : Samples
    zero : float
        s of the samples at phase zero.
    """

    periods: FloatArray
    phase: FloatArray
    values: FloatArray
    residuals: FloatArray
    rms: float
    series: _spectrum.RefinedSeries
    samples: Samples
    zero: float

    def curve(self, phase: Reals, which: int = 0) -> FloatArray:
        """The series at phases 0 to 1 of a period, of its own lines alone; of phase's shape."""
        at = validation.real(phase, "phase")
        t = self.zero + at.reshape(-1) * self.periods[which]
        return self.series.wave(t, which).reshape(at.shape)

    def table(self) -> QTable:
        """A row for each point: time, phases, values, residual."""
        from astropy import units
        from astropy.table import QTable

        columns = QTable()
        if self.samples.epoch is not None:
            columns["time"] = _instants.times(self.samples.epoch, self.samples.t).utc
            columns["time"].format = "isot"
        else:
            columns["time"] = self.samples.t * units.s
        for k in range(len(self.periods)):
            suffix = "" if len(self.periods) == 1 else f"_{k + 1}"
            columns[f"phase{suffix}"] = self.phase[k]
            columns[f"value{suffix}"] = self.values[k]
        columns["residual"] = self.residuals
        return columns

    def plot(self, path: FilePath | None = None) -> Any:
        """A figure: folded points, series, residuals; saved if a path is given."""
        from attitude.photometry import _figures

        return _figures.of_folded(self, path)

    def __repr__(self) -> str:
        periods = " and ".join(quantity_text.of_time(period, 7) for period in self.periods)
        return f"<Folded: {len(self.residuals)} points at {periods}, rms {self.rms:.3g}>"


@arguments({"periods": "give period="}, 'fold(curve, "5.3 h")')
def fold(
    t: Epochs | LightCurve | Samples,
    period: Real | Reals,
    values: Reals | None = None,
    errors: Reals | None = None,
    *,
    order: int = 4,
    epoch: Epoch | Real | None = None,
    refine: bool = False,
    curve: ArrayLike | None = None,
    zero_points: str = "auto",
) -> Folded:
    """A light curve folded with one period, or with two.

    Parameters
    ----------
    t : LightCurve, or (N,) epochs
    period : float, Quantity or text
        s, or such as "5.37 d"; two of them for a tumbler, "5.37, 7.37 d".
    values, errors, curve
        As in `periods`.
    order : int
        Of the series: harmonics of one period, lines |i f1 + j f2| with |i|, |j| up to it of two.
    epoch : epoch, optional
        Of phase zero; by default the first point.
    refine : bool
        Whether the periods are those of least squares near the given ones.
    zero_points : "auto", "free" or "shared"
        Of the sessions of a light curve: "auto" gives each its own where the best series with them
        is the more probable one (`_samples.settled`).

    Raises
    ------
    AttitudeError
        For more than two periods, and fewer values than unknowns.
    """
    data = _samples.of(t, values, errors, curve, zero_points)
    periods = np.atleast_1d(validation.real(period, "period", unit="s"))
    validation.one_of(periods.shape, "the shape of period", ((1,), (2,)))
    for one in periods:
        validation.positive(one, "period", unit="s")
    shown = " and ".join(quantity_text.of_time(one) for one in periods)
    if len(periods) == 2 and periods[0] == periods[1]:
        raise AttitudeError(f"period is {shown}; give two that differ, or one.")
    if np.max(periods) > _samples.SPANS * data.span:
        raise AttitudeError(
            f"period is {shown}, and the light curve spans {quantity_text.of_time(data.span)}: of "
            "a turn it shows too little for a series; give a shorter period."
        )
    if isinstance(t, LightCurve) or values is not None:
        _samples.warn_of_plain(period, "period", data.t)
    numbers = _spectrum.series_numbers(validation.count(order, "order"), len(periods))
    return _samples.settled(
        data,
        lambda samples: _folded(samples, periods, numbers, epoch, refine),
        lambda folded: folded.series,
    )


def _folded(data, periods, numbers, epoch, refine):
    data.refuse_constant()
    validation.flag(refine, "refine")
    series = (_spectrum.refined if refine else _spectrum.fixed)(data, 1.0 / periods, numbers)
    if refine:
        periods = 1.0 / series.frequencies
    zero = _zero(data, epoch)
    phase = np.mod((data.t - zero) / periods[:, None], 1.0)
    shown = [series.residuals + series.wave(data.t, k) for k in range(len(periods))]
    return Folded(
        frozen(periods),
        frozen(phase),
        frozen(np.array(shown)),
        frozen(series.residuals),
        series.rms,
        series,
        data,
        zero,
    )


def _zero(data: Samples, epoch: Any) -> float:
    """Seconds of the samples at phase zero."""
    if epoch is None:
        return float(data.t.min())
    if data.epoch is None:
        try:
            return validation.number(epoch, "epoch", unit="s")
        except AttitudeError:
            raise AttitudeError(
                f"epoch is {validation.shown(epoch)}, and t holds seconds without dates; give a "
                "number of these seconds, or dates as t."
            ) from None
    hi, lo = _inputs.one_since(data.epoch, epoch, "epoch")
    return hi + lo
