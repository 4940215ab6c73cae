"""`two_periods`: pairs of periods of a tumbler, and what they are in either mode.

A light curve has lines at |i/P_phi + j/P_psi|, so that its lattice of lines has many bases: the
candidates (P_psi, P_phi) of a pair of frequencies.  They are ranked by how the powers of the lines
resemble those of tumbling bodies: `_POWERS` has the mean share of each line over random convex
bodies in either mode (benchmarks/photometry.py lines), some bodies have one dominant line, and the
score is the sum of sqrt(share found x share expected), from 0 to 1, times the share of the variance
that the series explains.  Of i/P_phi + j/P_psi in L the
strongest lines are (2, 2), (1, 0) and (2, 0) in LAM, (1, 1), (2, 2) and (2, 0) in SAM; (i, i) is
i/P_phi of convention S.

What remains open: one cycle a day at one site, the mode, and bodies unlike the mean;
`attitude.inversion.spin_states` decides where the geometry allows it.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from attitude._support import validation
from attitude._support.arrays import Immutable, frozen
from attitude._support.blocks import ProgressBar
from attitude.errors import AttitudeError
from attitude.photometry import _folding, _samples, _spectrum
from attitude.photometry._samples import Line, line_numbers
from attitude.photometry._spectrum import OVERSAMPLING

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from numpy.typing import ArrayLike

    from attitude._support.annotations import Epochs, FilePath, FloatArray, Real, Reals
    from attitude._support.tables import FlatTable
    from attitude.photometry._curve import LightCurve
    from attitude.photometry._folding import Folded
    from attitude.photometry._samples import Samples
    from attitude.photometry._spectrum import RefinedSeries


# Pairs of frequencies that are turned into candidates.
PAIRS: int = 4
# Mean share of the power of the line i/P_phi + j/P_psi of convention L, by (i, j).
_POWERS = {
    "LAM": {
        **{(1, 0): 0.35, (2, 0): 0.28, (2, 2): 0.26, (1, 2): 0.06, (0, 2): 0.017, (3, 0): 0.003},
        **{(4, 0): 0.003, (3, 3): 0.003, (4, 4): 0.002, (1, -2): 0.002, (2, 3): 0.002},
    },
    "SAM": {
        **{(1, 1): 0.54, (2, 0): 0.25, (2, 2): 0.15, (0, 2): 0.015, (1, -1): 0.008, (1, 3): 0.007},
        **{(3, 3): 0.003, (3, 0): 0.003, (3, 1): 0.003, (4, 0): 0.002, (2, -1): 0.002},
    },
}
# Lines that dominate the light curves of some bodies, and the weight of such a body; the dominant
# share, of which the rest is distributed as the mean.
_DOMINANT = (((2, 0), 1.0), ((2, 2), 0.95), ((1, 0), 0.85), ((1, 1), 0.85))
_SHARE = 0.85
# Share of any other line; lines that the strongest ones may be; strongest lines that are tried.
_OTHER = 0.001
_ROLES = ((2, 0), (2, 2), (1, 0), (1, 1))
_TRIED = 4
# 1/P_psi in SAM over 1/P_phi of the long axis: bodies whose moments are possible have less.
_SHORT_AXIS = 1.4
# Multiples of half of the two frequencies that a basis may have.
_HALVES = range(-4, 5)


class PeriodCandidate(NamedTuple):
    """Two periods in a mode.

    mode : "LAM" or "SAM"; convention : "L" for LAM, "S" for SAM, of P_phi; P_psi, P_phi : float, s;
    P_phi_long : float, s, P_phi of the long axis (convention L) in either mode; score : float;
    rank : int, of the pair of frequencies; lines : str, 1/P_phi_long and 1/P_psi in f1 and f2.
    """

    mode: str
    convention: str
    P_psi: float
    P_phi: float
    P_phi_long: float
    score: float
    rank: int
    lines: str

    def __str__(self) -> str:
        return (
            f"{self.mode} P_psi {self.P_psi / 3600.0:.6g} h, P_phi({self.convention}) "
            f"{self.P_phi / 3600.0:.6g} h, score {self.score:.3f} ({self.lines})"
        )


def ranked(
    series: Sequence[tuple[int, float, RefinedSeries]], resolution: float, count: int
) -> list[PeriodCandidate]:
    """Candidates of several series, the best first."""
    found: list[PeriodCandidate] = []
    for rank, left, each in series:
        found += _of_series(rank, left, each, resolution)
    found.sort(key=lambda each: (-each.score, each.mode != "LAM"))
    kept: list[PeriodCandidate] = []
    for candidate in found:
        if all(not _same(candidate, other, resolution) for other in kept):
            kept.append(candidate)
        if len(kept) == count:
            break
    return kept


def _same(one: PeriodCandidate, other: PeriodCandidate, near: float) -> bool:
    return (
        one.mode == other.mode
        and abs(1.0 / one.P_psi - 1.0 / other.P_psi) < near
        and abs(1.0 / one.P_phi - 1.0 / other.P_phi) < near
    )


def _of_series(
    rank: int, left: float, series: RefinedSeries, resolution: float
) -> list[PeriodCandidate]:
    power = series.amplitudes**2
    power = power / power.sum()
    f = series.frequencies
    found: list[PeriodCandidate] = []
    seen: set[tuple[float, ...]] = set()
    for main in np.argsort(-power)[:_TRIED]:
        for a in _HALVES:
            for b in _HALVES:
                psi = np.array([a, b]) / 2.0
                if not psi @ f > 0.7 * resolution:
                    continue
                for sign in (1.0, -1.0):
                    for i, j in _ROLES:
                        phi = (sign * series.numbers[main] - j * psi) / i
                        key = (*phi, *psi)
                        if key in seen or not phi @ f > 0.7 * resolution:
                            continue
                        seen.add(key)
                        found += _in_modes(series, power, phi, psi, 1.0 - left, rank)
    return found


def _in_modes(
    series: RefinedSeries,
    power: FloatArray,
    phi: FloatArray,
    psi: FloatArray,
    explained: float,
    rank: int,
) -> list[PeriodCandidate]:
    """The candidates of a basis: phi and psi are 1/P_phi of convention L and 1/P_psi in f1, f2."""
    determinant = phi[0] * psi[1] - phi[1] * psi[0]
    if abs(determinant) < 0.1:
        return []
    rate, circulation = float(psi @ series.frequencies), float(phi @ series.frequencies)
    n = series.numbers
    i = (n[:, 0] * psi[1] - n[:, 1] * psi[0]) / determinant
    j = (phi[0] * n[:, 1] - phi[1] * n[:, 0]) / determinant
    j = np.where((i < -1e-9) | ((np.abs(i) < 1e-9) & (j < 0.0)), -j, j)
    i = np.abs(i)
    is_line = (np.abs(i - np.rint(i)) < 1e-6) & (np.abs(j - np.rint(j)) < 1e-6)
    places = [
        (int(a), int(b)) if fits else None
        for a, b, fits in zip(np.rint(i), np.rint(j), is_line, strict=True)
    ]
    words = f"1/P_phi(L) = {_words(phi)}, 1/P_psi = {_words(psi)}"
    short = 1.0 / (circulation + rate)
    found = []
    for mode, convention, period in (("LAM", "L", 1.0 / circulation), ("SAM", "S", short)):
        if mode == "SAM" and not rate < _SHORT_AXIS * circulation:
            continue
        score = explained * _likeness(power, places, _POWERS[mode])
        found.append(
            PeriodCandidate(
                mode, convention, 1.0 / rate, period, 1.0 / circulation, score, rank, words
            )
        )
    return found


def _likeness(
    power: FloatArray, places: list[tuple[int, int] | None], mean: dict[tuple[int, int], float]
) -> float:
    """How lines resemble those of the mean body, or of one that has a dominant line."""
    expected = np.array([0.0 if each is None else mean.get(each, _OTHER) for each in places])
    found = float(np.sum(np.sqrt(power * expected)))
    for line, weight in _DOMINANT:
        if mean.get(line, 0.0) > _OTHER:
            strong = np.array([float(each == line) for each in places])
            mixed = (1.0 - _SHARE) * expected + _SHARE * strong
            found = max(found, weight * float(np.sum(np.sqrt(power * mixed))))
    return found


def _words(numbers: FloatArray) -> str:
    """A combination of f1 and f2 in words."""
    parts = []
    for number, name in zip(numbers, ("f1", "f2"), strict=True):
        if number:
            size = "" if abs(number) == 1.0 else f"{abs(number):g} "
            parts.append(("- " if number < 0 else "+ ") + size + name)
    return " ".join(parts).removeprefix("+ ")


# ---- `two_periods`: pairs of periods of a tumbler, blind, by Fourier series in two frequencies
# Sources: Pravec et al., Icarus 173, 108 (2005); Kaasalainen, A&A 376, 302 (2001).

_DAY, _HOUR = 86400.0, 3600.0
# Grid numbers of the lowest frequency, and pairs at most.
_LEAST, _MOST_PAIRS = 2, 400_000_000
# Standard deviation of a point of the scan, in that of all values; the ridge is one of these.
_NOISE = 0.05
# Peaks of the scan that are refined, steps for all of them, and for the best.
_PEAKS, _FIRST_STEPS, _STEPS = 120, 3, 10
# Turns in the span below which a strong line is a drift of the zero point.
_SLOW = 4.0
# Pairs of halves with which one lattice of lines follows from another, the simplest first.
_COMBINATIONS = sorted(
    ((a, b) for a in range(-4, 5) for b in range(-4, 5) if 0 < abs(a) + abs(b) <= 6),
    key=lambda pair: (pair[0] % 2 + pair[1] % 2, abs(pair[0]) + abs(pair[1])),
)


class PeriodPair(NamedTuple):
    """Two frequencies, Hz, the lower one first, with their errors, and what they leave.

    left : float, the share of chi-squared that the series leaves.  relation : str, how the pair
    follows from a better one: "same lines as #1: f1, f2 - f1", "alias of #1 (1 /d)", or "".
    """

    first: float
    second: float
    first_error: float
    second_error: float
    left: float
    relation: str

    @property
    def periods(self) -> tuple[float, float]:
        """Both periods, s, the longer one first."""
        return 1.0 / self.first, 1.0 / self.second

    @property
    def errors(self) -> tuple[float, float]:
        """Standard errors of both periods, s, by curvature."""
        return self.first_error / self.first**2, self.second_error / self.second**2


@dataclass(frozen=True, eq=False, repr=False)
class TwoPeriods(Immutable):
    """Pairs of periods, the best first.

    Attributes
    ----------
    pairs : tuple of PeriodPair
    order : int
    false_alarm : float
        The share of chi-squared that the best pair of 1 of 100 light curves leaves whose values are
        exchanged at random among the epochs; a pair that leaves less is significant.
    map : (C, D) array
        The least share left in each cell of the plane of both frequencies; NaN where none was
        tried.
    edges : pair of arrays (C + 1,), (D + 1,)
        Of the cells, Hz.
    tried : int
        Pairs of frequencies that were compared.
    samples : Samples
    """

    pairs: tuple[PeriodPair, ...]
    order: int
    false_alarm: float
    map: FloatArray
    edges: tuple[FloatArray, FloatArray]
    tried: int
    samples: Samples

    def __len__(self) -> int:
        return len(self.pairs)

    def __getitem__(self, rank: int) -> PeriodPair:
        """The pair of a rank, counted from 0."""
        return self.pairs[rank]

    def lines(self, rank: int = 0) -> list[tuple[Line, float]]:
        """The lines i f2 + j f1 of a pair with their amplitudes, the strongest first."""
        series = self._series(rank)
        found = []
        for k in np.argsort(-series.amplitudes, kind="stable"):
            j, i = (int(n) for n in series.numbers[k])
            frequency = abs(float(series.numbers[k] @ series.frequencies))
            period = 1.0 / frequency if frequency > 0.0 else np.inf
            found.append((Line(i, j, frequency, period), float(series.amplitudes[k])))
        return found

    def candidates(self, count: int = 10) -> list[PeriodCandidate]:
        """Periods (P_psi, P_phi) in LAM and SAM that have these lines, ranked.

        The score is the sum of sqrt(share of a line x share expected) over the lines, from 0 to 1,
        times the share of the variance that the series explains.
        """
        best = self.pairs[0].left
        series = []
        for rank, pair in enumerate(self.pairs):
            is_good = 1.0 - pair.left > 0.8 * (1.0 - best)
            if rank == 0 or (is_good and not pair.relation.startswith(("same lines", "drift"))):
                series.append((rank, pair.left, self._series(rank)))
            if len(series) == PAIRS:
                break
        return ranked(series, 1.0 / self.samples.span, count)

    def fold(self, rank: int = 0) -> Folded:
        """The light curve folded with both periods of a pair; see `photometry.fold`."""
        given = self.samples
        return _folding.fold(given, self.pairs[rank].periods, order=self.order)

    def bootstrap(self, rank: int = 0, *, draws: int = 100, seed: int = 0) -> tuple[float, float]:
        """Standard errors of both periods of a pair, s, from points drawn anew.

        Parameters
        ----------
        rank, draws, seed : int
        """
        number = validation.count(draws, "draws", 2)
        f = _spectrum.bootstrap(self.samples, self._series(rank), number, seed)
        first, second = np.std(f, axis=0, ddof=1) * np.array(self.pairs[rank].periods) ** 2
        return float(first), float(second)

    def table(self) -> FlatTable:
        """A row for each pair."""
        from astropy import units

        from attitude._support.tables import FlatTable

        periods = np.array([each.periods for each in self.pairs]) / _HOUR * units.h
        errors = np.array([each.errors for each in self.pairs]) / _HOUR * units.h
        return FlatTable(
            {
                "first": periods[:, 0],
                "first_error": errors[:, 0],
                "second": periods[:, 1],
                "second_error": errors[:, 1],
                "left": [each.left for each in self.pairs],
                "significant": [each.left < self.false_alarm for each in self.pairs],
                "relation": [each.relation for each in self.pairs],
            }
        )

    def plot(self, path: FilePath | None = None) -> Any:
        """A figure: chi-squared over both frequencies, lines, folded curves; saved if a path."""
        from attitude.photometry import _figures

        return _figures.of_two_periods(self, path)

    def _series(self, rank: int) -> _spectrum.RefinedSeries:
        pair = self.pairs[rank]
        numbers = _numbers(self.order)
        return _spectrum.fixed(self.samples, np.array([pair.first, pair.second]), numbers)

    def __repr__(self) -> str:
        best = self.pairs[0]
        both = " and ".join(
            f"{period / _HOUR:.7g} +- {error / _HOUR:.2g} h"
            for period, error in zip(best.periods, best.errors, strict=True)
        )
        return f"<TwoPeriods of order {self.order}: {both}, {best.left:.3f} of chi2 left>"


def two_periods(
    t: Epochs | LightCurve,
    values: Reals | None = None,
    errors: Reals | None = None,
    *,
    min_period: Real | None = None,
    max_period: Real | None = None,
    first: Sequence[Real] | None = None,
    second: Sequence[Real] | None = None,
    order: int = 2,
    count: int = 20,
    curve: ArrayLike | None = None,
    seed: int = 0,
    zero_points: str = "auto",
    progress: Callable[[int, int], None] | None = None,
) -> TwoPeriods:
    """The pairs of periods whose Fourier series in two frequencies fits a light curve best.

    Parameters
    ----------
    t, values, errors, curve
        As in `periodogram`.
    min_period, max_period : float, Quantity or text
        s; bounds of both periods.  max_period is the span by default.
    first, second : pair of float, Quantity or text, optional
        Bounds of either period in place of both.
    order : int
        1 to 4: lines |i f1 + j f2| with |i|, |j| up to it.
    count : int
        Of pairs.
    seed : int
        Of the permutations.
    zero_points : "auto", "free" or "shared"
        Of the sessions of a light curve: "auto" gives each its own where the best series with them
        is the more probable one (`_samples.settled`).
    progress : function, optional
        Called with the number of pairs done and of all; by default a bar on a terminal.

    Returns
    -------
    TwoPeriods

    Raises
    ------
    AttitudeError
        Without bounds, for an order out of range, more than 4e8 pairs, and fewer values than
        unknowns.

    Notes
    -----
    Every pair of a grid of 3 frequencies per 1/span is fitted by closed normal equations from two
    transforms of the epochs (`_spectrum.best`); of more than 8e6 pairs those with the
    greatest sum of line powers.  The best are refined in both frequencies with all zero points
    free.  A light curve of 1000 points over 60 days, both periods from 2 h to 40 h at order 2:
    see docs/photometry.md for the time.
    """
    data = _samples.tempered(_samples.of(t, values, errors, curve, zero_points))
    number = validation.count(order, "order")
    if number > 4:
        raise AttitudeError(f"order is {number}; give 1 to 4.")
    kept = validation.count(count, "count")

    def found(own: Samples) -> TwoPeriods:
        low, high = _bounds(own, min_period, max_period, first, second)
        return _two_periods(own, low, high, number, kept, seed, progress)

    def significant(each: TwoPeriods) -> _spectrum.RefinedSeries | None:
        return each._series(0) if each[0].left < each.false_alarm else None

    return _samples.settled(data, found, significant)


def _two_periods(
    data: Samples,
    low: tuple[int, int],
    high: tuple[int, int],
    number: int,
    kept: int,
    seed: int,
    progress: Callable[[int, int], None] | None,
) -> TwoPeriods:
    numbers = _numbers(number)
    if len(data.t) <= data.curves + 2 * len(numbers) + 2:
        raise AttitudeError(
            f"{len(data.t)} values are given for {data.curves} zero points and {len(numbers)} "
            "lines; give more values, or a lower order."
        )
    _refuse_many(low, high)
    end = max(low[1], high[1])
    y = data.detrended
    scale = float(np.std(y)) or 1.0
    weights = data.weights**2 / np.mean(data.weights**2) / _NOISE**2
    unit = (data.t - 0.5 * (data.t.min() + data.t.max())) / data.span
    made = _spectrum.tables(unit, weights, y / scale, 1.0 / OVERSAMPLING, 4 * number * end + 2)
    bar = ProgressBar("pairs of periods") if progress is None else progress
    most = max(_PEAKS, 2 * kept)
    scan = _spectrum.best(made, low, high, number, _spectrum.RIDGE, most, bar)
    pairs = _refined(data, scan, numbers, kept)
    chance = _spectrum.share_of_chance(unit, weights, y / scale, end / OVERSAMPLING, number, seed)
    size = OVERSAMPLING * data.span
    return TwoPeriods(
        pairs,
        number,
        chance,
        frozen(scan.map),
        (scan.edges[0] / size, scan.edges[1] / size),
        scan.tried,
        data,
    )


def _numbers(order: int) -> Any:
    """Lines (j of the first, i of the second frequency)."""
    return np.array(line_numbers((order, order)))[:, ::-1]


def _bounds(
    data: Samples, least: Any, most: Any, first: Any, second: Any
) -> tuple[tuple[int, int], tuple[int, int]]:
    """Grid numbers of both ranges of frequencies; the range of longer periods first."""
    if not data.span > 0.0:
        raise AttitudeError("all values are of one epoch; give values of two epochs or more.")
    if (first is None) != (second is None):
        raise AttitudeError("first and second are bounds of one period each; give both.")
    given = (first, second) if first is not None else ((least, most), (least, most))
    found = []
    for name, pair in zip(("first", "second"), given, strict=True):
        if first is not None and len(pair) != 2:
            raise AttitudeError(f'{name} is {pair!r}; give two periods, such as ("2 h", "40 h").')
        low, high = pair
        if low is None:
            raise AttitudeError('min_period is missing; give one, such as min_period="2 h".')
        shortest = validation.positive(low, "min_period", unit="s")
        longest = data.span if high is None else validation.positive(high, "max_period", unit="s")
        size = OVERSAMPLING * data.span
        start, end = max(_LEAST, int(size / longest)), int(size / shortest) + 2
        if end - start < 4:
            raise AttitudeError(
                f"between the periods {shortest:.6g} s and {longest:.6g} s lie {end - start} "
                "frequencies; give a wider range."
            )
        found.append((start, end))
    low, high = sorted(found)
    return low, high


def _refuse_many(low: tuple[int, int], high: tuple[int, int]) -> None:
    pairs = (low[1] - low[0]) * (high[1] - high[0]) // (2 if low == high else 1)
    if pairs > _MOST_PAIRS:
        raise AttitudeError(
            f"between the periods lie {pairs:.2g} pairs, and at most {_MOST_PAIRS:.2g} are "
            "searched; give a longer min_period, or first= and second=."
        )


def _refined(
    data: Samples, scan: _spectrum.BestPairs, numbers: Any, count: int
) -> tuple[PeriodPair, ...]:
    size = OVERSAMPLING * data.span
    total = float(np.sum((data.weights * data.detrended) ** 2))
    near = 0.3 / data.span
    # a peak may lie a third of the resolution from the grid, where the scan sees half of it
    rough = [
        _spectrum.refined(data, np.array(pair) / size, numbers, steps=_FIRST_STEPS)
        for pair in zip(scan.first, scan.second, strict=True)
    ]
    rough.sort(key=lambda each: each.chi_squared)
    rows: list[tuple[str, float, FloatArray, FloatArray]] = []
    for each in rough[: 2 * count]:
        best = _spectrum.refined(data, each.frequencies, numbers, steps=_STEPS)
        f = np.abs(best.frequencies)
        order = np.argsort(f)
        f, errors = f[order], best.errors[order]
        if f[0] > near and all(np.abs(f - row[2]).max() > near for row in rows):
            rows.append((_slow_line(best, data.span), best.chi_squared / total, f, errors))
    rows.sort(key=lambda row: (row[0] != "", row[1]))
    pairs: list[PeriodPair] = []
    for slow, left, f, errors in rows[:count]:
        words = slow or _relation(f, pairs, near)
        first, second, a, b = map(float, (*f, *errors))
        pairs.append(PeriodPair(first, second, a, b, left, words))
    return tuple(pairs)


def _slow_line(series: _spectrum.RefinedSeries, span: float) -> str:
    """Words for a strong line that turns a few times in the span: a drift, not a rotation."""
    amplitudes = series.amplitudes
    turns = np.abs(series.numbers @ series.frequencies) * span
    slow = (turns < _SLOW) & (amplitudes > 0.5 * amplitudes.max())
    if not np.any(slow):
        return ""
    k = int(np.flatnonzero(slow)[0])
    line = _spelled(*(2 * series.numbers[k]))
    return f"drift: the line {line} turns {turns[k]:.1f} times in the span"


def _relation(f: FloatArray, better: Sequence[PeriodPair], near: float) -> str:
    for rank, pair in enumerate(better, 1):
        words = _same_lattice(f, np.array([pair.first, pair.second]), near)
        if words:
            return f"same lines as #{rank}: {words}"
    alias = _spectrum.alias_of(float(f[0]), float(f[1]), better, 2.0 * near)
    return "" if alias is None else f"alias of #{alias + 1} (1 /d)"


def _same_lattice(f: FloatArray, base: FloatArray, near: float) -> str:
    """Both frequencies as sums of small whole or half numbers of two others, in words, or ""."""
    choices = [
        [(a, b) for a, b in _COMBINATIONS if abs(0.5 * (a * base[0] + b * base[1]) - each) < near]
        for each in f
    ]
    for one in choices[0]:
        for other in choices[1]:
            if one[0] * other[1] != one[1] * other[0]:
                return f"{_spelled(*one)} and {_spelled(*other)}"
    return ""


def _spelled(a: int, b: int) -> str:
    """Halves of whole numbers of f1 and f2: (2, -1) is "f1 - f2/2"."""
    words = []
    for number, name in ((a, "f1"), (b, "f2")):
        if number:
            whole, half = divmod(abs(number), 2)
            size = name if (whole, half) == (1, 0) else f"{whole} {name}"
            if half:
                size = f"{name}/2" if not whole else f"{abs(number)} {name}/2"
            words.append(("- " if number < 0 else "+ ") + size)
    text = " ".join(words)
    return text.removeprefix("+ ")
