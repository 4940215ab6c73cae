"""Light curves as numbers, from any input; the lines in the spectrum of a tumbler's."""

from __future__ import annotations

import re
import warnings
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any, NamedTuple, TypeVar

import numpy as np

from attitude._support import quantity_text, validation
from attitude._support.arrays import part_of_each
from attitude._support.constants import GAP_OF_NIGHTS_S, OPPOSITION_SURGE_RAD
from attitude.catalog import motion_of
from attitude.epochs import _inputs
from attitude.epochs._instants import J2000, Instant
from attitude.errors import AttitudeError, AttitudeWarning
from attitude.motions._motion import Motion
from attitude.photometry._curve import LightCurve, refuse_small
from attitude.photometry._spectrum import line_numbers

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from numpy.typing import ArrayLike

    from attitude._support.annotations import Epochs, FloatArray, IntArray, Real, Reals
    from attitude.photometry._spectrum import RefinedSeries


Found = TypeVar("Found")

# Least error in a search of periods, in standard deviations of the values.
_FLOOR = 0.05
# Range of values that do not vary, over the greatest of them.
_ROUNDING = 1e-12
# Greatest size of values and errors, and the inverse of the least: their fourth powers are doubles.
_HUGE = 1e70
# Greatest order of lines, of which there are 2e6 then.
_MOST = 1000
# Turns in a span from which plain numbers of seconds are doubted.
_TURNS = 3e5
# Spans in a period from which they are.
SPANS = 10.0
# Nights at least of a standard error.
_NIGHTS = 5
_UNIT = re.compile(r"[A-Za-df-z]")
# Change of the phase angle, rad, from which its terms are fitted.
_SWEEP = np.radians(2.0)


@dataclass(frozen=True, eq=False)
class Samples:
    """A light curve as numbers: values at t (N,), s, from `epoch` or the zero of plain seconds.

    `curve` (N,) is the zero point of each value, `joined` (N,) those if all sessions share one,
    where that is not known; `terms` (N, L) are further terms in which the values are linear;
    `names` those of the curves.
    """

    t: FloatArray
    values: FloatArray
    errors: FloatArray | None
    curve: IntArray
    epoch: Instant | None = None
    is_flux: bool = False
    names: tuple[str, ...] = ()
    joined: IntArray | None = None
    terms: FloatArray | None = None

    def __post_init__(self) -> None:
        sizes = {"values": np.abs(self.values).max(initial=0.0)}
        if self.errors is not None:
            sizes |= {"errors": self.errors.max(), "least errors": self.errors.min()}
        for name, size in sizes.items():
            if size > 0.0 and not 1.0 / _HUGE < size < _HUGE:
                raise AttitudeError(
                    f"the {name} of the light curve are {size:.3g}; give them in a unit in which "
                    f"they lie between {1.0 / _HUGE:g} and {_HUGE:g}."
                )

    @cached_property
    def span(self) -> float:
        """From the first to the last epoch, s."""
        return float(np.ptp(self.t))

    @cached_property
    def middle(self) -> float:
        """Between the first and the last epoch, s."""
        return float(0.5 * (self.t.min() + self.t.max()))

    @cached_property
    def weights(self) -> FloatArray:
        """1 / errors (N,), or ones."""
        return np.ones_like(self.t) if self.errors is None else 1.0 / self.errors

    @cached_property
    def curves(self) -> int:
        """The number of zero points."""
        return int(self.curve.max()) + 1

    @property
    def linear(self) -> int:
        """The number of zero points and further linear terms."""
        return self.curves + (0 if self.terms is None else self.terms.shape[1])

    @cached_property
    def group(self) -> IntArray:
        """The number (N,) of the group of each value: of its night, or its own of fewer than 5.

        Residuals of one night are correlated where a series or the photometry errs.
        """
        night = part_of_each(self.t, GAP_OF_NIGHTS_S)
        return night if night.max() + 1 >= _NIGHTS else np.arange(len(night))

    @cached_property
    def columns(self) -> FloatArray:
        """One column (N, linear) for each zero point, 1 or 0, and for each further term."""
        constants = (self.curve[:, None] == np.arange(self.curves)).astype(float)
        return constants if self.terms is None else np.concatenate([constants, self.terms], axis=1)

    @cached_property
    def detrended(self) -> FloatArray:
        """Values (N,) without the zero points and terms that fit them best."""
        if self.terms is not None:
            matrix = self.columns * self.weights[:, None]
            solution = np.linalg.lstsq(matrix, self.values * self.weights, rcond=None)[0]
            return np.asarray(self.values - self.columns @ solution)
        weights = self.weights**2
        total = np.bincount(self.curve, weights)
        mean = np.bincount(self.curve, weights * self.values) / total
        return self.values - mean[self.curve]

    def refuse_constant(self) -> None:
        """AttitudeError for values that do not differ by more than rounding."""
        is_fitted = len(self.t) > self.linear
        if is_fitted and np.ptp(self.detrended) <= _ROUNDING * np.abs(self.values).max():
            raise AttitudeError(
                f"the {len(self.t)} values do not vary but for their zero points; give a light "
                "curve that varies."
            )


def is_plain(values: Any) -> bool:
    """Whether numbers, or their text, have no unit."""
    if values is None or hasattr(values, "unit"):
        return False
    items = [values] if isinstance(values, str) or np.ndim(values) == 0 else list(values)
    return not any(
        hasattr(one, "unit") or (isinstance(one, str) and _UNIT.search(one)) for one in items
    )


def warn_of_plain(bounds: Any, name: str, t: FloatArray, unit: str = "s") -> None:
    """Warn of plain numbers, periods in s or frequencies in Hz, absurd for epochs t (N,), s."""
    if not is_plain(bounds):
        return
    numbers = validation.real(bounds, name, unit="1/s" if unit == "Hz" else unit)
    if not numbers.size or not np.all(numbers > 0.0):
        return  # which the search refuses
    periods = 1.0 / numbers if unit == "Hz" else numbers
    t = np.sort(t)
    span, steps = float(t[-1] - t[0]), np.diff(t)
    step = float(steps[steps > 0.0].min(initial=np.inf))
    short = span > _TURNS * periods.min() or periods.min() < 0.5 * step
    if short or periods.max() > SPANS * span:
        shown = ", ".join(f"{one:.6g}" for one in np.ravel(numbers))
        meaning, example = ("Hz", "/d") if unit == "Hz" else ("seconds", "d")
        warnings.warn(
            f"{name} is {shown} without a unit, which is {meaning}: "
            f"{span / float(periods.min()):.3g} turns in the {quantity_text.of_time(span, 4)} of "
            f"the light curve, whose closest epochs are {quantity_text.of_time(step, 3)} apart; "
            f'give a unit, such as "{shown} {example}".',
            AttitudeWarning,
            stacklevel=4,
        )


def tempered(samples: Samples) -> Samples:
    """The samples with errors of at least a twentieth of the standard deviation of the values.

    Errors far below the scatter about any series would leave most points without weight.
    """
    floor = _FLOOR * float(np.std(samples.detrended))
    if samples.errors is None or not floor > 0.0:
        return samples
    return replace(samples, errors=np.hypot(samples.errors, floor))


def settled(
    data: Samples,
    find: Callable[[Samples], Found],
    fitted: Callable[[Found], RefinedSeries | None],
) -> Found:
    """What is found with one zero point for all sessions, or with their own if the data ask.

    Of both the one with the lower N ln(chi-squared) + parameters ln N (Schwarz 1978).
    """
    alone = replace(data, joined=None)
    if data.joined is None or data.joined.max() == data.curve.max():
        return find(alone)

    def cost(samples: Found) -> float:
        series = fitted(samples)
        if series is None:
            return np.inf
        chi_squared = max(series.chi_squared, 1e-300)
        return float(np.log(chi_squared) + series.parameters * np.log(len(data.t)) / len(data.t))

    one = find(replace(alone, curve=data.joined, names=()))
    try:
        return min((one, find(alone)), key=cost)
    except AttitudeError:  # fewer values than unknowns with a zero point for each session
        return one


def of_curve(curve: LightCurve) -> Samples:
    """The samples of a light curve, at 1 au at the epochs of emission if the geometry is known."""
    t, values, errors = curve.seconds, curve.value, curve.sigma
    if curve.has_geometry:
        t = curve.emission
        factor = 10.0 ** (0.4 * curve.dimming)
        values = values * factor if curve.is_flux else values - curve.dimming
        errors = errors * factor if curve.is_flux else errors
    has_offset = np.full(len(curve.sessions), curve.zero_points != "shared")
    if isinstance(curve.zero_points, tuple):
        has_offset = np.isin(curve.sessions, curve.zero_points)
    session = np.where(has_offset[curve.session], curve.session + 1, 0)
    keys = session * len(curve.filters) + curve.filter
    _, first, number = np.unique(keys, return_index=True, return_inverse=True)
    words = [
        (curve.sessions[curve.session[k]] if session[k] else "", curve.filters[curve.filter[k]])
        for k in first
    ]
    known = np.isfinite(errors) & (errors > 0.0)
    is_settled = curve.zero_points in ("shared", "free") or isinstance(curve.zero_points, tuple)
    return Samples(
        np.array(t),
        np.array(values),
        np.where(known, errors, np.median(errors[known])) if np.any(known) else None,
        np.asarray(number, np.int64).reshape(-1),
        curve.epoch,
        is_flux=curve.is_flux,
        names=tuple(" ".join(word for word in both if word) for both in words),
        joined=None if is_settled else np.unique(curve.filter, return_inverse=True)[1].reshape(-1),
        terms=_phase_terms(curve),
    )


def _phase_terms(curve: LightCurve) -> FloatArray | None:
    """Terms (N, 2) of the phase angle, of fluxes to first order; None where it changes little."""
    if not curve.has_geometry or curve.zero_phase or np.ptp(curve.phase_angle) < _SWEEP:
        return None
    alpha = curve.phase_angle
    terms = np.stack([alpha, np.exp(-alpha / OPPOSITION_SURGE_RAD)], axis=1)
    return terms - terms.mean(axis=0)


def of(
    t: Epochs | LightCurve | Samples,
    values: Reals | None = None,
    errors: Reals | None = None,
    curve: ArrayLike | None = None,
    zero_points: str = "auto",
) -> Samples:
    """The `Samples` of what a caller gives, (N,) each."""
    validation.one_of(zero_points, "zero_points", ("auto", "free", "shared"))
    if isinstance(t, Samples):
        return t
    if isinstance(t, LightCurve):
        if values is not None or errors is not None or curve is not None:
            raise AttitudeError(
                f"t is a {type(t).__name__}, which has its values, errors and curves; leave those "
                "arguments out."
            )
        samples = of_curve(t)
        if zero_points == "free" or samples.joined is None:
            return replace(samples, joined=None)
        if zero_points == "shared":
            return replace(samples, curve=samples.joined, names=(), joined=None)
        return samples
    if values is None:
        raise AttitudeError("values is missing; give a value for each epoch, or a LightCurve as t.")
    epoch, seconds = _seconds(t)
    if seconds.ndim != 1 or not seconds.size:
        raise AttitudeError(f"t has shape {seconds.shape}; give a row of epochs, (N,).")
    shape = seconds.shape
    unit, numbers = _unit(values)
    return Samples(
        seconds,
        validation.real(numbers, "values", shape=shape),
        _errors(errors, unit, shape),
        _curves(curve, shape),
        epoch,
        is_flux=unit is not None and not unit.is_equivalent("mag"),
    )


def _seconds(t: Any) -> tuple[Instant | None, FloatArray]:
    kind, _, _ = _inputs.entries(t, "t", "epochs")
    if kind in _inputs.LENGTHS:
        times = np.array(_inputs.seconds_since(J2000, t)[0], dtype=np.float64)
        if not np.all(np.isfinite(times)):
            raise AttitudeError(
                f"t holds {times[~np.isfinite(times)].flat[0]}; give finite epochs."
            )
        return None, times
    hi, lo = _inputs.past_j2000(t, "t")
    if not np.all(np.isfinite(hi)):
        raise AttitudeError("t has entries that are not epochs; leave these points out.")
    epoch = Instant(float(np.round(0.5 * (np.min(hi) + np.max(hi)))) if hi.size else 0.0)
    return epoch, np.asarray((hi - epoch.seconds) + lo)


def _unit(values: Any) -> tuple[Any, Any]:
    """The unit of Quantities and of columns, and the numbers."""
    unit = getattr(values, "unit", None)
    return unit, values if unit is None else getattr(values, "quantity", values).value


def _errors(errors: Any, unit: Any, shape: tuple[int, ...]) -> FloatArray | None:
    if errors is None:
        return None
    unit_of_errors, numbers = _unit(errors)
    if unit_of_errors is not None and unit is not None and unit_of_errors != unit:
        numbers = validation.real(errors, "errors", unit=unit)
    sigmas = validation.real(numbers, "errors")
    sigmas = validation.broadcast(sigmas, "errors", shape, "value").copy()
    if not np.all(sigmas > 0.0):
        bad = sigmas[~(sigmas > 0.0)][0]
        raise AttitudeError(
            f"errors holds {bad}; give errors above zero, or leave such values out."
        )
    refuse_small(sigmas, None, "errors")
    return sigmas


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


# ---- The lines in the spectrum of a tumbler's light curve: frequencies from two periods
# For a Sun and an observer in constant inertial directions the brightness of a tumbling body is a
# function of two angles, each of which is linear in time plus periodic terms: its spectrum consists
# of lines at |i / P_phi + j / P_psi| for whole i and j.  In the other convention of the axes
# 1/P_phi differs by 1/P_psi, so that the same lines have other numbers i, j.


class Line(NamedTuple):
    """One line: i and j of |i / P_phi + j / P_psi|, its frequency in Hz and period in s."""

    i: int
    j: int
    frequency: float
    period: float


def line_at(i: int, j: int, frequency: float) -> Line:
    """The line of a frequency, Hz."""
    return Line(i, j, frequency, 1.0 / frequency if frequency > 0.0 else np.inf)


def lines(
    motion: Motion | str | Sequence[Real],
    order: int | Sequence[int] = 2,
    *,
    convention: str | None = None,
) -> list[Line]:
    """The lines of the spectrum of a tumbler's light curve.

    Parameters
    ----------
    motion : FreeRotation, its name in the catalogue, or pair (P_psi, P_phi)
        s, or Quantities.
    order : int or pair (order of psi, order of phi)
        Lines with |j| and i up to these.
    convention : "L" or "S", optional
        Of P_phi, with a motion: the long or the short axis; by default the one about which the
        momentum circulates.

    Returns
    -------
    list of Line
        In order of frequency; (i, j) and (-i, -j) are one line, with i >= 0.

    Raises
    ------
    AttitudeError
        For a motion without periods, an order that is not a whole number above zero, and a
        convention with a pair of periods.

    >>> hour = 3600.0
    >>> main = [line for line in lines((263.0 * hour, 27.38 * hour)) if (line.i, line.j) == (1, -1)]
    >>> round(main[0].period / hour, 2)              # of (99942) Apophis, Pravec et al. 2014
    30.56
    """
    psi, phi = _frequencies(motion, convention)
    numbers = line_numbers(known_orders(order))
    all_lines = (line_at(i, j, abs(i * phi + j * psi)) for i, j in numbers)
    return sorted(all_lines, key=lambda line: line.frequency)


def known_orders(order: Any) -> tuple[int, int]:
    """The orders of psi and of phi from one whole number or two, else an AttitudeError."""
    pair = (order, order) if np.ndim(order) == 0 else tuple(order)
    whole = all(isinstance(n, (int, np.integer)) and not isinstance(n, bool) for n in pair)
    if len(pair) != 2 or not whole or min(pair) < 0 or not 0 < max(pair) <= _MOST:
        raise AttitudeError(
            f"order is {order!r}; give a whole number from 1 to {_MOST}, or two: of psi, of phi."
        )
    return int(pair[0]), int(pair[1])


def _frequencies(motion, convention):
    """1 / P_psi and 1 / P_phi in Hz."""
    motion = motion_of(motion) if isinstance(motion, str) else motion
    if isinstance(motion, Motion):
        regime = motion.regime
        P_phi = motion.period_phi if convention is None else regime.P_phi(convention)
        return 1.0 / motion.period_psi, 1.0 / P_phi
    if convention is not None:
        raise AttitudeError(
            f"convention is {convention!r}, but a pair of periods has one already; leave it out, "
            "or give a motion."
        )
    try:
        P_psi, P_phi = motion
    except (TypeError, ValueError) as err:
        raise AttitudeError(
            f"motion is {motion!r}; give a FreeRotation, or the pair (P_psi, P_phi)."
        ) from err
    return frequencies_of(P_psi, P_phi)


def frequencies_of(P_psi: Real, P_phi: Real) -> tuple[float, float]:
    """1 / P_psi and 1 / P_phi in Hz."""
    psi = validation.positive(P_psi, "P_psi", unit="s")
    return 1.0 / psi, 1.0 / validation.positive(P_phi, "P_phi", unit="s")
