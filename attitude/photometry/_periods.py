"""`periods`: one period of a light curve, or the two of a tumbler, blind.

Sources of the series in two frequencies: Pravec et al., Icarus 173, 108 (2005); Kaasalainen, A&A
376, 302 (2001).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from attitude._support import markup, quantity_text, validation
from attitude._support.arrays import Immutable, frozen
from attitude._support.blocks import ProgressBar
from attitude._support.constants import DAY_S, SIDEREAL_DAY_S
from attitude._support.quantity_text import counted
from attitude._support.synonyms import arguments
from attitude.errors import AttitudeError
from attitude.photometry import _folding, _lattices, _periodogram, _samples, _spectrum
from attitude.photometry._samples import Line, line_at
from attitude.photometry._spectrum import OVERSAMPLING

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from numpy.typing import ArrayLike

    from attitude._support.annotations import Epochs, FilePath, FloatArray, Real, Reals
    from attitude._support.tables import FlatTable
    from attitude.photometry._curve import LightCurve
    from attitude.photometry._folding import Folded
    from attitude.photometry._lattices import PeriodCandidate
    from attitude.photometry._periodogram import Window
    from attitude.photometry._samples import Samples


# Pairs of frequencies that are turned into candidates.
_CANDIDATES = 4
# Grid number of the lowest frequency.
_LEAST = 2
# Pairs that are compared at most.
_MOST_PAIRS = 400_000_000
# Standard deviation of a point of the scan, in that of all values; the ridge is one of these.
_NOISE = 0.05
# Peaks of the scan that are refined.
_PEAKS = 120
# Steps for all of them.
_FIRST_STEPS = 3
# Steps for the best.
_STEPS = 10
# Turns in the span below which a strong line is a drift of the zero point.
_SLOW = 4.0
# Shortest period by default, in spans: 4000 frequencies, 8e6 pairs.
_FEWEST = OVERSAMPLING / 4000.0
# Periods, s, of the Sun and of the stars, at which the observations of one site recur.
_DAYS = (DAY_S, SIDEREAL_DAY_S)
# Bounds of one period or of both.
_Bounds = tuple[tuple[int, int], tuple[int, int]]


class Peak(NamedTuple):
    """One frequency, or two, with their errors, Hz, the lower one first, and what they leave.

    left : float, the share of chi-squared that the series leaves.  relation : str, how it follows
    from a better one: "alias of #1 (+1 /d)", "2 x #1" for twice its period, "beside #1" (a sidelobe
    within 1.5/span), "same lines as #1: f1, f2 - f1", "at the longest period searched", or "".
    """

    frequencies: tuple[float, ...]
    frequency_errors: tuple[float, ...]
    left: float
    relation: str

    @property
    def periods(self) -> tuple[float, ...]:
        """The periods, s, the longer one first."""
        return tuple(1.0 / f for f in self.frequencies)

    @property
    def errors(self) -> tuple[float, ...]:
        """Standard errors of the periods, s, by curvature, or by the scatter of five nights on."""
        both = zip(self.frequencies, self.frequency_errors, strict=True)
        return tuple(error / f**2 for f, error in both)

    @property
    def period(self) -> float:
        """The period, s; of two the longer one."""
        return self.periods[0]

    @property
    def error(self) -> float:
        """Its standard error, s."""
        return self.errors[0]

    @property
    def power(self) -> float:
        """The share of the variance that the series explains."""
        return 1.0 - self.left

    @property
    def first(self) -> float:
        """The lower frequency, Hz."""
        return self.frequencies[0]

    @property
    def second(self) -> float:
        """The higher frequency, Hz."""
        return self.frequencies[-1]


@dataclass(frozen=True, eq=False, repr=False)
class Periods(Immutable):
    """Periods of a light curve, or pairs of periods, the best first.

    Attributes
    ----------
    peaks : tuple of Peak
    order : int
        Of the series.
    false_alarm : float
        The share of chi-squared that the best series of 1 of 100 light curves leaves whose values
        are exchanged at random among the epochs; a peak that leaves less is significant.
    tried : int
        Frequencies, or pairs of them, that were compared.
    samples : Samples
        The numbers that were searched.
    method : str
        "fourier", "pdm" or "additive".
    frequency, power : (K,) arrays or None
        Of one period: Hz, and the share of the variance explained; of phase dispersion 1 - theta.
    window : Window or None
        Of one period: the spectral window of the epochs.
    map : (C, D) array or None
        Of two: the least share left in each cell of the plane of both frequencies; NaN where none
        was tried.
    edges : pair of arrays (C + 1,), (D + 1,), or None
        Of the cells, Hz.
    """

    peaks: tuple[Peak, ...]
    order: int
    false_alarm: float
    tried: int
    samples: Samples
    method: str = "fourier"
    frequency: FloatArray | None = None
    power: FloatArray | None = None
    window: Window | None = None
    map: FloatArray | None = None
    edges: tuple[FloatArray, FloatArray] | None = None

    def __len__(self) -> int:
        return len(self.peaks)

    def __getitem__(self, rank: int) -> Peak:
        """The peak of a rank, counted from 0."""
        return self.peaks[rank]

    @property
    def count(self) -> int:
        """1 or 2: periods of a peak."""
        return len(self.peaks[0].frequencies)

    @property
    def period(self) -> float:
        """The best period, s; of two the longer one."""
        return self.peaks[0].period

    @property
    def error(self) -> float:
        """Its standard error, s."""
        return self.peaks[0].error

    @property
    def hint(self) -> str:
        """What the number of maxima says of one period, in a sentence; "" if it says nothing.

        Elongated bodies have two maxima a turn, so that a series of two harmonics fits half of the
        period of the rotation as well.
        """
        if self.count == 2:
            return ""
        phase = np.linspace(0.0, 1.0, 400, endpoint=False)
        wave = self.fold().curve(phase)
        inner = (wave > np.roll(wave, 1)) & (wave >= np.roll(wave, -1))
        if np.count_nonzero(inner) > 1:
            return ""
        double = quantity_text.of_time(2.0 * self.period)
        return (
            "the light curve has one maximum in the best period; most bodies have two a turn, so "
            f"that the rotation may take {double}, twice as long."
        )

    def lines(self, rank: int = 0) -> list[tuple[Line, float]]:
        """The lines i f2 + j f1 of a peak with their amplitudes, the strongest first."""
        series = self._series(rank)
        strongest = []
        for k in np.argsort(-series.amplitudes, kind="stable"):
            j, i = (*(int(n) for n in series.numbers[k]), 0)[:2]
            frequency = abs(float(series.numbers[k] @ series.frequencies))
            strongest.append((line_at(i, j, frequency), float(series.amplitudes[k])))
        return strongest

    def candidates(self, count: int = 10) -> list[PeriodCandidate]:
        """Periods (P_psi, P_phi) in LAM and SAM that have the lines of two periods, ranked.

        The score is the sum of sqrt(share of a line x share expected) over the lines, from 0 to 1,
        times the share of the variance that the series explains.
        """
        if self.count == 1:
            raise AttitudeError("candidates are those of two periods; give periods(..., count=2).")
        best = self.peaks[0].left
        series = []
        for rank, pair in enumerate(self.peaks):
            is_good = 1.0 - pair.left > 0.8 * (1.0 - best)
            if rank == 0 or (is_good and not pair.relation.startswith(("same lines", "drift"))):
                series.append((rank, pair.left, self._series(rank)))
            if len(series) == _CANDIDATES:
                break
        return _lattices.ranked(series, 1.0 / self.samples.span, count)

    def fold(self, rank: int = 0, *, order: int | None = None) -> Folded:
        """The light curve folded with the periods of a peak; see `photometry.fold`."""
        number = order or (self.order if self.count == 2 else max(self.order, 2))
        return _folding.fold(self.samples, self._peak(rank).periods, order=number)

    def bootstrap(self, rank: int = 0, *, draws: int = 100, seed: int = 0) -> tuple[float, ...]:
        """Standard errors of the periods of a peak, s, from nights drawn anew.

        Nights are parted by gaps of 0.3 d; of fewer than five, points are drawn.

        Parameters
        ----------
        rank, draws, seed : int
        """
        number = validation.count(draws, "draws", 2)
        f = _spectrum.bootstrap(self.samples, self._series(rank), number, seed)
        spread = np.std(f, axis=0, ddof=1) * np.array(self._peak(rank).periods) ** 2
        return tuple(spread.tolist())

    def table(self) -> FlatTable:
        """A row for each peak: one period, or both."""
        from astropy import units

        from attitude._support.tables import FlatTable

        size, unit = quantity_text.time_unit(self.period)
        names = ("period",) if self.count == 1 else ("first", "second")
        columns: dict[str, Any] = {}
        for k, name in enumerate(names):
            for suffix, key in (("", "periods"), ("_error", "errors")):
                seconds = np.array([getattr(peak, key)[k] for peak in self.peaks])
                columns[name + suffix] = seconds / size * units.Unit(unit)
        columns["power"] = [peak.power for peak in self.peaks]
        columns["left"] = [peak.left for peak in self.peaks]
        columns["significant"] = [peak.left < self.false_alarm for peak in self.peaks]
        columns["relation"] = [peak.relation for peak in self.peaks]
        return FlatTable(columns)

    def plot(self, path: FilePath | None = None) -> Any:
        """A figure: power or chi-squared left, peaks, folded curves; saved if a path is given."""
        from attitude.photometry import _figures

        return (_figures.of_one if self.count == 1 else _figures.of_two)(self, path)

    def _series(self, rank: int) -> _spectrum.RefinedSeries:
        numbers = _numbers(self.order, self.count, self.method == "additive")
        return _spectrum.fixed(self.samples, np.array(self._peak(rank).frequencies), numbers)

    def _peak(self, rank: int) -> Peak:
        return self.peaks[validation.count(rank, "rank", 0, len(self) - 1)]

    def _repr_html_(self) -> str:
        """A table of the peaks for notebooks, and the light curve folded with the best."""
        folded = self.fold()
        names = " and ".join(quantity_text.of_time(period, 7) for period in self.peaks[0].periods)
        picture = markup.line_plot(
            [(folded.phase[0], folded.values[0])],
            f"folded with {quantity_text.of_time(folded.periods[0], 7)}",
            is_downward=not self.samples.is_flux,
            is_dotted=True,
        )
        return markup.of_table(f"Periods of order {self.order}: {names}", self.table(), 8, picture)

    def __repr__(self) -> str:
        best = self.peaks[0]
        size, unit = quantity_text.time_unit(best.period)
        words = " and ".join(
            f"{period / size:.7g} +- {error / size:.2g} {unit}"
            for period, error in zip(best.periods, best.errors, strict=True)
        )
        return (
            f"<Periods of order {self.order}: {words}, {best.left:.3f} of chi2 left, "
            f"{len(self)} peaks>"
        )


@arguments(
    {"min": "give min_period=", "max": "give max_period="}, 'periods(curve, min_period="2 h")'
)
def periods(
    t: Epochs | LightCurve,
    values: Reals | None = None,
    errors: Reals | None = None,
    *,
    count: int = 1,
    min_period: Real | None = None,
    max_period: Real | None = None,
    first: Sequence[Real] | None = None,
    second: Sequence[Real] | None = None,
    order: int = 2,
    method: str = "fourier",
    bins: int = 10,
    keep: int | None = None,
    curve: ArrayLike | None = None,
    seed: int = 0,
    zero_points: str = "auto",
    progress: Callable[[int, int], None] | None = None,
) -> Periods:
    """The period of a light curve, or the pairs of periods of a tumbler, found blind.

    Parameters
    ----------
    t : LightCurve, or (N,) epochs
        A light curve has its values, errors, sessions and filters; if its geometry is known, its
        brightness at 1 au at the epochs of emission counts, and two phase terms are fitted too.
    values, errors, curve : (N,) array_like
        With epochs: values, their errors, and the number of the zero point of each, from 0.
    count : 1 or 2
        Periods: series in one frequency, or with the lines |i f1 + j f2| in two.
    min_period, max_period : float, Quantity or text, optional
        s, or such as "2 h", of all periods.  By default from twice the median distance of epochs,
        of pairs so that 8e6 are compared at most, to the span.
    first, second : pair of float, Quantity or text, optional
        With count=2: bounds of either period in place of both.
    order : int
        Harmonics, of pairs 1 to 4, of additive pairs 1 to 8; a light curve with two maxima a turn
        needs 2, dips of eclipses 6.
    method : "fourier", "pdm" or "additive"
        Fourier series by least squares; of one period also phase dispersion minimisation
        (Stellingwerf 1978), with `bins` of phase, each covered twice; of two also the sum of a
        series in each, without lines at sums and differences: a rotation and a moon's orbit.
    keep : int, optional
        Peaks that are returned at most: 10, or 20 pairs.
    seed : int
        Of the permutations.
    zero_points : "auto", "free" or "shared"
        Of the sessions of a light curve: "auto" gives each its own where the best series with them
        is the more probable one (`_samples.settled`).
    progress : function, optional
        Called with the number of frequencies or pairs done and of all; by default a bar on a
        terminal.

    Returns
    -------
    Periods

    Raises
    ------
    AttitudeError
        For periods out of order, an order out of range, more than 5e6 frequencies or 4e8 pairs, and
        fewer values than unknowns.

    Notes
    -----
    The grid of one period has 5 frequencies per 1 / (order span), that of pairs 3 per 1/span; pairs
    are fitted by closed normal equations from two transforms of the epochs (`_spectrum.best`); of
    more than 8e6 pairs those with the greatest sum of line powers.  The best are refined to the
    least squares of frequencies, series and zero points.  Before the scan the mean of each curve
    with a zero point of its own is taken off, which hides most of a period longer than a session:
    so one zero point for all sessions is tried first.  docs/photometry.md has times.

    >>> t = np.sort(np.random.default_rng(1).uniform(0.0, 40.0, 200))      # days
    >>> found = periods(t * 86400.0, np.sin(2 * np.pi * t / 0.31), min_period="2 h", order=1)
    >>> round(found.period / 86400.0, 6)
    0.31
    """
    data = _samples.tempered(_samples.of(t, values, errors, curve, zero_points))
    for name, bound in (
        ("min_period", min_period),
        ("max_period", max_period),
        ("first", first),
        ("second", second),
    ):
        _samples.warn_of_plain(bound, name, data.t)
    if not isinstance(count, (int, np.integer)) or count not in (1, 2):
        raise AttitudeError(f"count is {count!r}; give 1 period or 2; keep= is that of the peaks.")
    number = validation.count(order, "order")
    validation.one_of(method, "method", ("fourier", "pdm", "additive"))
    kept = validation.count((10, 20)[count - 1] if keep is None else keep, "keep")
    is_additive, most = method == "additive", 8 if method == "additive" else 4
    if count == 2 and number > most:
        raise AttitudeError(f"order is {number}; give 1 to {most}.")
    if count == 2 and method == "pdm":
        raise AttitudeError('method is "pdm", which knows one period; give "fourier" or count=1.')
    if count == 1 and is_additive:
        raise AttitudeError('method is "additive", the sum of two series; give count=2.')
    if count == 1 and not (first is None and second is None):
        raise AttitudeError("first and second are bounds of two periods; give count=2.")

    def searched(samples: Samples) -> Periods:
        samples.refuse_constant()
        if count == 1:
            bounds = min_period, max_period
            return _one(samples, bounds, number, method, bins, kept, seed, progress)
        low, high = _bounds(samples, min_period, max_period, first, second, number)
        return _two(samples, low, high, number, is_additive, kept, seed, progress)

    return _samples.settled(data, searched, _significant)


def periodogram(
    t: Epochs | LightCurve,
    values: Reals | None = None,
    errors: Reals | None = None,
    *,
    count: int = 10,
    **keywords: Any,
) -> Periods:
    """`periods` with ``count=1`` under its earlier name; `count` is that of the peaks."""
    return periods(t, values, errors, count=1, keep=count, **keywords)


def two_periods(
    t: Epochs | LightCurve,
    values: Reals | None = None,
    errors: Reals | None = None,
    *,
    count: int = 20,
    **keywords: Any,
) -> Periods:
    """`periods` with ``count=2`` under its earlier name; `count` is that of the pairs."""
    return periods(t, values, errors, count=2, keep=count, **keywords)


def _significant(result: Periods) -> _spectrum.RefinedSeries | None:
    """The series of the best peak; None if chance leaves as little."""
    left = result[0].left if result.power is None else 1.0 - float(result.power.max())
    if left > result.false_alarm:
        return None
    if result.count == 1:
        return _periodogram.refined(result.samples, result[0].first, result.order)
    return result._series(0)


def _one(data, bounds, order, method, bins, kept, seed, progress):
    bar = ProgressBar("frequencies") if progress is None else progress
    scanned = _periodogram.scan(data, bounds, order, method, bins, seed, bar)
    peaks = tuple(
        Peak((f,), (error,), left, words)
        for f, error, left, words in _periodogram.best_peaks(data, scanned, order, kept)
    )
    return Periods(
        peaks,
        order,
        1.0 - scanned.chance,
        len(scanned.frequency),
        data,
        method=method,
        frequency=frozen(scanned.frequency),
        power=frozen(scanned.power),
        window=scanned.window,
    )


def _two(data, low, high, number, is_additive, kept, seed, progress):
    numbers = _numbers(number, 2, is_additive)
    if len(data.t) <= data.linear + 2 * len(numbers) + 2:
        points = counted(data.linear, "zero point")
        raise _spectrum.too_few(data, f"{points} and {counted(len(numbers), 'line')}")
    end = max(low[1], high[1])
    count = (low[1] - low[0]) * (high[1] - high[0]) // (2 if low == high else 1)
    if count > _MOST_PAIRS:
        raise AttitudeError(
            f"from {OVERSAMPLING * data.span / end:.4g} s on lie {count:.2g} pairs, and at most "
            f"{_MOST_PAIRS:.2g} are searched; give a longer min_period, or first= and second=."
        )
    y = data.detrended
    scale = float(np.std(y)) or 1.0
    weights = data.weights**2 / np.mean(data.weights**2) / _NOISE**2
    unit = (data.t - 0.5 * (data.t.min() + data.t.max())) / data.span
    sums = _spectrum.tables(unit, weights, y / scale, 1.0 / OVERSAMPLING, 4 * number * end + 2)
    bar = ProgressBar("pairs of periods") if progress is None else progress
    most = max(_PEAKS, 2 * kept)
    lines = _spectrum.harmonics(number)
    if is_additive:
        lines = np.concatenate([lines[:1], numbers])
    scan = _spectrum.best(sums, low, high, lines, most, bar)
    pairs = _refined(data, scan, numbers, kept, (low, high))
    chance = _spectrum.share_of_chance(unit, weights, y / scale, end / OVERSAMPLING, lines, seed)
    size = OVERSAMPLING * data.span
    return Periods(
        pairs,
        number,
        chance,
        scan.tried,
        data,
        method="additive" if is_additive else "fourier",
        map=frozen(scan.map),
        edges=(scan.edges[0] / size, scan.edges[1] / size),
    )


def _numbers(order: int, count: int, is_additive: bool = False) -> Any:
    """As `_spectrum.series_numbers`; of an additive series the harmonics of each frequency."""
    if is_additive:
        return np.kron(np.eye(2, dtype=int), np.arange(1, order + 1)).T
    return _spectrum.series_numbers(order, count)


def _bounds(data: Samples, least: Any, most: Any, first: Any, second: Any, order: int) -> _Bounds:
    """Grid numbers of both ranges of frequencies; the range of longer periods first."""
    if not data.span > 0.0:
        raise AttitudeError("all values are of one epoch; give values of two epochs or more.")
    if (first is None) != (second is None):
        raise AttitudeError("first and second are bounds of one period each; give both.")
    if first is None and least is None:
        least = max(_periodogram.shortest(data, order), _FEWEST * data.span)
    ranges = (first, second) if first is not None else ((least, most), (least, most))
    cells = []
    for name, pair in zip(("first", "second"), ranges, strict=True):
        if first is not None and len(pair) != 2:
            raise AttitudeError(f'{name} is {pair!r}; give two periods, such as ("2 h", "40 h").')
        low, high = pair
        shortest = validation.positive(low, "min_period", unit="s")
        longest = data.span if high is None else validation.positive(high, "max_period", unit="s")
        size = OVERSAMPLING * data.span
        start, end = max(_LEAST, int(size / longest)), int(size / shortest) + 2
        if end - start < 4:
            raise AttitudeError(
                f"between the periods {shortest:.6g} s and {longest:.6g} s lie {end - start} "
                "frequencies; give a wider range."
            )
        cells.append((start, end))
    low, high = sorted(cells)
    return low, high


def _refined(data, scan, numbers, count, bounds):
    size = OVERSAMPLING * data.span
    total = float(np.sum((data.weights * data.detrended) ** 2))
    closest = 0.3 / data.span
    # a peak may lie a third of the resolution from the grid, where the scan sees half of it
    starts = np.stack([scan.first, scan.second], axis=1) / size
    rough, shares = _spectrum.least(data, starts, numbers, _FIRST_STEPS)
    starts = rough[np.argsort(shares, kind="stable")[: 2 * count]]
    rows = []
    for peak in _spectrum.least(data, starts, numbers, _STEPS)[0]:
        best = _spectrum.fixed(data, peak, numbers)
        f = np.abs(best.frequencies)
        order = np.argsort(f)
        f, errors = f[order], best.errors[order]
        is_inside = all(
            low - 1 <= frequency * size <= high
            for frequency, (low, high) in zip(f, bounds, strict=True)
        )
        if is_inside and f[0] > closest and all(np.abs(f - row[2]).max() > closest for row in rows):
            rows.append((_slow_line(best, data.span), best.chi_squared / total, f, errors))
    rows.sort(key=lambda row: (row[0] != "", row[1]))
    pairs = []
    for slow, left, f, errors in rows[:count]:
        words = slow or _relation(f, pairs, closest)
        pairs.append(Peak(tuple(f.tolist()), tuple(errors.tolist()), left, words))
    return tuple(pairs)


def _slow_line(series: _spectrum.RefinedSeries, span: float) -> str:
    """Words for a strong line that turns a few times in the span: a drift, not a rotation."""
    amplitudes = series.amplitudes
    turns = np.abs(series.numbers @ series.frequencies) * span
    slow = (turns < _SLOW) & (amplitudes > 0.5 * amplitudes.max())
    if not np.any(slow):
        return ""
    k = int(np.flatnonzero(slow)[0])
    line = _lattices.spelled(*(2 * series.numbers[k]))
    return f"drift: the line {line} turns {turns[k]:.1f} times in the span"


def _relation(f: FloatArray, better: Sequence[Peak], tolerance: float) -> str:
    for rank, pair in enumerate(better, 1):
        words = _lattices.same_lattice(f, np.array(pair.frequencies), tolerance)
        if words:
            return f"same lines as #{rank}: {words}"
    for rank, pair in enumerate(better, 1):
        shifts = [sign / day for day in _DAYS for sign in (-1, 1)]
        aliases = [(pair.first, pair.second + shift) for shift in shifts]
        aliases += [(pair.first + shift, pair.second) for shift in shifts]
        if any(np.all(np.abs(np.sort(np.abs(both)) - f) < 2.0 * tolerance) for both in aliases):
            return f"alias of #{rank} (1 /d)"
    return ""
