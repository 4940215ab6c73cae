"""Rotation about one axis over any number of apparitions: the sidereal period and the pole.

1. Each apparition has its own Fourier series of four harmonics: the sum of what they explain is a
   function of the rate alone, which does not know how many turns lie between two apparitions.  Its
   peaks are windows of rates.
2. Within a window every rate of a grid of 1/(8 span) is tried about every pole of a grid.  The
   magnitude is linear in spherical harmonics of the bisector of Sun and observer over the axes of
   the body, so that phase and shape of each rate follow from one linear fit.
3. The best of these become ellipsoids, then convex bodies, with pole and rate free.

Within one apparition many poles fit with a shape of their own: then the map of `_pole_map` follows.

A linear fit costs microseconds: points that are close in time (a cell) turn with one phase when the
rate changes by little, so that their normal equations are summed once, and only the cells are
summed for each rate.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from attitude._support import quantity_text
from attitude._support.arrays import distinct, two_across
from attitude._support.constants import DAY_S
from attitude.inversion import (
    _ellipsoid,
    _evidence,
    _neighbours,
    _pole_map,
    _refinement,
    _shapes,
    _verdicts,
)
from attitude.inversion._ellipsoid import SearchState
from attitude.inversion._problem import inverse_factor
from attitude.inversion._search import Search, never

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Sequence

    from numpy.typing import NDArray

    from attitude._support.annotations import FloatArray, IntArray
    from attitude.inversion._evidence import Robust
    from attitude.inversion._problem import CurveProblem

    ComplexArray = NDArray[np.complex128]


# Epochs within so many seconds are one cell.
_CELL = 0.4 * DAY_S
# Steps of a rate in one turn per span, and of a rate in one turn per apparition.
_STEPS = 8.0
# The largest error, rad, of the phase of the fourth harmonic at the ends of a cell.
_PHASE = 0.3
# Standard deviation of the amplitude of the harmonic of two maxima a turn, mag.
_TWO = 0.4
# Standard deviation of the amplitude of any other harmonic, mag.
_OTHER = 0.15
# Amplitudes grow with the phase angle, per rad.
_BY_PHASE = 1.1
# Poles of the grid.
POLES = 100
# Rates solved side by side.
_SIDE = 2000


class Columns(NamedTuple):
    """Complex functions of the epoch (K, N), and how often each turns with the body (K,).

    Those that do not turn are real.  widths (K,): standard deviations of their coefficients, mag.
    """

    values: ComplexArray
    turns: IntArray
    widths: FloatArray


# ---- Linear fits of functions that turn with a body, for many rates


class Combs:
    """Weighted magnitudes in cells, with the linear terms projected out.

    Parameters
    ----------
    problem : CurveProblem
    """

    def __init__(self, problem: CurveProblem) -> None:
        self.problem = problem
        self._order = np.argsort(problem.t, kind="stable")
        self._t, self._root = problem.t[self._order], problem.root[self._order]
        self._y = problem.y[self._order] * self._root
        self._first = _first_of_cells(self._t, _CELL / problem.span)
        counts = np.diff(np.append(self._first, len(problem)))
        self.centre = np.add.reduceat(self._t, self._first) / counts
        within = self._t - np.repeat(self.centre, counts)
        self.width = 2.0 * float(np.abs(within).max(initial=0.0))
        self._terms()

    def _terms(self) -> None:
        """Split the linear terms into those of one cell that share no point and all others."""
        problem, y = self.problem, self._y
        weighted = problem.terms[self._order] * self._root[:, None]
        used = np.logical_or.reduceat(weighted != 0.0, self._first, axis=0)
        inverse, count = inverse_factor(weighted, problem.prior, used.sum(axis=0) == 1)
        combined = weighted @ inverse
        self._local, self._whole = combined[:, :count], combined[:, count:]
        along = combined.T @ y
        self._along = along[count:]
        self.total = float(y @ y - along @ along)

    def gains(
        self, columns: Sequence[Columns], rates: FloatArray
    ) -> Iterator[tuple[slice, FloatArray, FloatArray]]:
        """What each set of columns takes off chi-squared at some of the rates, and how.

        Slices of the rates, gains (M, R) and coefficients (M, R, P): those of all columns as
        cosines, then of those that turn as sines.  The sets have equal turns and widths.

        Shapes: rates (R,), turns per span, ascending.
        """
        most = max(1, int(columns[0].turns.max()))
        width = 2.0 * _PHASE / (math.pi * most * max(self.width, 1e-9))
        settings = self.problem.settings
        cost = settings.comb_cost + len(self.centre) * settings.cell_cost
        begin = 0
        while begin < len(rates):
            end = int(np.searchsorted(rates, rates[begin] + width, "right"))
            end = min(max(end, begin + 1), begin + _SIDE)
            block_of_rates = slice(begin, end)
            self.problem.tally.add((end - begin) * len(columns), cost)
            yield block_of_rates, *self._block(columns, rates[block_of_rates])
            begin = end

    def _block(
        self, columns: Sequence[Columns], rates: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Gains (M, R) and coefficients (M, R, P) at rates that are close together."""
        middle, turns = 0.5 * float(rates[0] + rates[-1]), columns[0].turns
        powers = [np.ones((len(rates), len(self.centre)), complex)]
        powers.append(np.exp(-2j * np.pi * np.outer(rates - middle, self.centre)))
        while len(powers) <= 2 * int(turns.max()):
            powers.append(powers[-1] * powers[1])
        widths = np.concatenate([columns[0].widths, columns[0].widths[turns > 0]])
        gain = np.empty((len(columns), len(rates)))
        solved = np.empty((len(columns), len(rates), len(widths)))
        for number, columns_of in enumerate(columns):
            normal, side = self._normal(self._sums(columns_of, middle), turns, powers)
            at = np.arange(len(widths))
            normal[:, at, at] += widths**-2.0
            solved[number] = np.linalg.solve(normal, side[:, :, None])[:, :, 0]
            gain[number] = np.sum(solved[number] * side, axis=1)
        return gain, solved

    def _normal(
        self, sums: _Sums, turns: IntArray, powers: list[ComplexArray]
    ) -> tuple[FloatArray, FloatArray]:
        """Normal matrices (R, P, P) and right sides (R, P) from the sums of the cells."""
        count, rates = len(turns), len(powers[0])
        straight, crossed = np.empty((2, rates, count, count), complex)
        by_term = np.empty((rates, count, 1 + self._whole.shape[1]), complex)
        ahead = np.add.outer(turns, turns)
        for k in np.unique(ahead):
            straight[:, ahead == k] = powers[k] @ sums.straight[:, ahead == k]
        behind = np.subtract.outer(turns, turns)
        for k in np.unique(behind):
            turned = powers[k] if k >= 0 else powers[-k].conj()
            crossed[:, behind == k] = turned @ sums.crossed[:, behind == k]
        for k in np.unique(turns):
            on = turns == k
            flat = sums.terms[:, on].reshape(len(sums.terms), -1)
            by_term[:, on] = (powers[k] @ flat).reshape(rates, -1, by_term.shape[2])
        sine = np.flatnonzero(turns > 0)
        normal = np.empty((rates, count + len(sine), count + len(sine)))
        normal[:, :count, :count] = 0.5 * (straight + crossed).real
        normal[:, :count, count:] = 0.5 * (straight - crossed).imag[:, :, sine]
        normal[:, count:, :count] = normal[:, :count, count:].swapaxes(1, 2)
        normal[:, count:, count:] = 0.5 * (crossed - straight).real[:, sine][:, :, sine]
        both = np.concatenate([by_term.real, by_term.imag[:, sine]], axis=1)
        side, whole = both[:, :, 0], both[:, :, 1:]
        normal -= whole @ whole.swapaxes(1, 2)
        return normal, side - whole @ self._along

    def _sums(self, columns: Columns, middle: float) -> _Sums:
        """Sums over the points of each cell, at one rate."""
        turned = np.exp(-2j * np.pi * middle * self._t)
        power = [np.ones_like(turned)]
        for _ in range(int(columns.turns.max())):
            power.append(power[-1] * turned)
        z = columns.values[:, self._order] * np.array(power)[columns.turns] * self._root
        # what the zero points of single cells take off
        left = z - (z @ self._local) @ self._local.T
        z, left = z.T, left.T
        along = np.concatenate(
            [(left * self._y[:, None])[:, :, None], z[:, :, None] * self._whole[:, None, :]], axis=2
        )
        straight, crossed, terms = (
            np.add.reduceat(products, self._first, axis=0)
            for products in (
                left[:, :, None] * z[:, None, :],
                left[:, :, None] * z.conj()[:, None, :],
                along,
            )
        )
        return _Sums(straight, crossed, terms)


class _Sums(NamedTuple):
    """Sums of each cell: products of columns (C, K, K), with conjugates, magnitudes and terms."""

    straight: ComplexArray
    crossed: ComplexArray
    terms: ComplexArray


def _first_of_cells(t: FloatArray, width: float) -> IntArray:
    """Numbers of the ascending epochs (N,) that begin a cell: none is wider than `width`."""
    first: list[int] = []
    for k, epoch in enumerate(t):
        if not first or epoch - t[first[-1]] > width:
            first.append(k)
    return np.array(first)


# ---- Rates of the apparitions, each with a series of its own

# Harmonics of the series of an apparition.
_HARMONICS = np.arange(1, 5)
# Standard deviations of their amplitudes, mag.
_AMPLITUDES = np.array([_OTHER, _TWO, _OTHER, _OTHER])
# Least points of an apparition with a series.
_LEAST_POINTS = 20
# Rates between looks at the budget.
_BLOCK = 10_000
# Rates of all, the best, that stay in memory.
_KEPT = 50_000
# Turns in the span up to which every rate is tried about all poles.
_WHOLE = 800.0
# Half the width of a window beside the turn of the scene, turns in the longest apparition.
_HALF = 0.6


class Windows(NamedTuple):
    """Windows of rates, turns per span, the most probable first, and whether more may fit."""

    bounds: list[tuple[float, float]]
    are_limited: bool = False


def windows(problem: CurveProblem, low: float, high: float) -> Windows:
    """Windows of rates from `low` to `high`, turns per span."""
    spans = [
        inside
        for inside in _neighbours.apparitions_of(problem.seconds)
        if len(inside) >= _LEAST_POINTS
    ]
    length = max((float(np.ptp(problem.t[inside])) for inside in spans), default=0.0)
    if length == 0.0 or high - low < _WHOLE:
        return Windows([(low, high)])
    combs = [Combs(problem.part(chosen)) for chosen in spans]
    columns = [
        Columns(np.ones((len(_HARMONICS), len(comb.problem)), complex), _HARMONICS, _AMPLITUDES)
        for comb in combs
    ]
    total = sum(comb.total for comb in combs)
    step = 1.0 / (_STEPS * length)
    rates, left = np.empty(0), np.empty(0)
    # millions of rates do not fit the memory: the best of each block stay
    for begin in range(0, math.ceil((high - low) / step), _BLOCK):
        block = np.arange(low + begin * step, min(low + (begin + _BLOCK) * step, high), step)
        gain = np.zeros(len(block))
        for comb, columns_of in zip(combs, columns, strict=True):
            for at, explained, _ in comb.gains([columns_of], block):
                gain[at] += explained[0]
        rates, left = np.append(rates, block), np.append(left, total - gain)
        kept = np.argsort(left, kind="stable")[:_KEPT]
        rates, left = rates[kept], left[kept]
        if problem.tally.is_over:
            break
    half = _HALF / length + _fastest(problem, spans)
    # by the number of a window, which holds one at most
    peaks: dict[int, float] = {}
    settings = problem.settings
    most = settings.window_left * max(float(left.min()), 0.0) + settings.window_above
    # the best rates and half of each, a window apart
    for k in np.argsort(left, kind="stable"):
        if left[k] > most:
            break
        for rate in (float(rates[k]), 0.5 * float(rates[k])):
            number = int(rate / (2.0 * half))
            beside = (peaks.get(number + shift, math.inf) for shift in (-1, 0, 1))
            if rate >= low and all(abs(rate - other) > 2.0 * half for other in beside):
                peaks[number] = rate
    bounds = [(max(low, peak - half), min(high, peak + half)) for peak in peaks.values()]
    return Windows(bounds, len(left) == _KEPT and bool(left.max() <= most))


def _fastest(problem: CurveProblem, spans: Sequence[IntArray]) -> float:
    """How much the scene may change the rate that is seen, turns per span."""
    fastest = 0.0
    for chosen in spans:
        length = float(np.ptp(problem.t[chosen]))
        bisector = problem.bisector[:, chosen]
        angle = math.acos(max(-1.0, float((bisector.T @ bisector).min())))
        # less than a full turn about a pole close by
        if length > 0.0:
            fastest = max(fastest, min(angle / math.pi, 0.5) / max(length, 1e-9))
    return min(fastest, 2.0 * problem.span / (365.25 * DAY_S))


# ---- Every rate about every pole


class Trial(NamedTuple):
    """A rate (turns per span) about a pole (3,), with its gain and the phase of its maxima, rad."""

    gain: float
    rate: float
    pole: FloatArray
    phase: float
    amplitude: float


def harmonics_about(problem: CurveProblem, pole: FloatArray) -> Columns:
    """Spherical harmonics of the bisector of Sun and observer about a pole (3,)."""
    first, second = two_across(pole)
    z = pole @ problem.bisector
    across = (first @ problem.bisector) + 1j * (second @ problem.bisector)
    alpha = np.arccos(np.clip(np.sum(problem.sun * problem.observer, axis=0), -1.0, 1.0))
    more = 1.0 + _BY_PHASE * alpha
    values = [
        z.astype(complex),
        (1.5 * z * z - 0.5).astype(complex),
        across,
        across**2 * more,
        across**2 * z * more,
        across**3,
        across**4,
    ]
    turns = np.array([0, 0, 1, 2, 2, 3, 4])
    widths = np.array([_OTHER, _TWO, _OTHER, _TWO, _OTHER, _OTHER, _OTHER])
    return Columns(np.array(values), turns, widths)


# Where the coefficient of the cosine of two maxima a turn stands.
_COSINE = 3
# Where that of the sine stands.
_SINE = 8


def scan(
    combs: Combs, poles: FloatArray, low: float, high: float, is_over: Callable[[], bool]
) -> list[Trial]:
    """The best rates of each pole (P, 3)."""
    if is_over():
        return []
    rates = np.arange(low, high + 0.5 / _STEPS, 1.0 / _STEPS)
    columns = [harmonics_about(combs.problem, pole) for pole in poles]
    trials: list[Trial] = []
    for at, gain, coefficients in combs.gains(columns, rates):
        if is_over():
            break
        edge = np.full((len(poles), 1), -math.inf)
        padded = np.concatenate([edge, gain, edge], axis=1)
        top = (gain >= padded[:, :-2]) & (gain > padded[:, 2:])
        for number, pole in enumerate(poles):
            peaks = np.flatnonzero(top[number])
            best = peaks[np.argsort(-gain[number, peaks], kind="stable")][:_OF_A_POLE]
            for k in best:
                a, b = coefficients[number, k, [_COSINE, _SINE]]
                trials.append(
                    Trial(
                        gain=float(gain[number, k]),
                        rate=float(rates[at][k]),
                        pole=pole,
                        phase=0.5 * math.atan2(b, a),
                        amplitude=math.hypot(a, b),
                    )
                )
    return sorted(trials, key=lambda trial: -trial.gain)


_OF_A_POLE = 8


def ellipsoid_of(trial: Trial) -> FloatArray:
    """The state (WIDTH,) of an ellipsoid with rate, pole and phase of a trial."""
    state = np.zeros(_ellipsoid.WIDTH)
    state[_ellipsoid.OF_PRECESSION] = 0.5 * trial.rate
    state[_ellipsoid.OF_NUTATION] = -1.0
    state[_ellipsoid.OF_LOG_RHO] = _ellipsoid.AXIAL
    first, second = two_across(trial.pole)
    c, s = math.cos(trial.phase), math.sin(trial.phase)
    x = c * first + s * second
    frame = np.stack([x, np.cross(trial.pole, x), trial.pole], axis=-1)
    state[_ellipsoid.OF_FRAME] = frame.ravel()
    ratio = min(max(2.0 * trial.amplitude / 1.086, 0.1), 1.2)
    # c = 0.9 b, and a / b from the amplitude
    state[_ellipsoid.OF_FLAT] = -2.0 * (ratio + 0.1), -0.2
    return state


# ---- The search

# Steps of these ellipsoids.
_ITERATIONS = 25
# Steps of convex bodies with the errors that the best one shows.
_STEPS_FREE = 40
# Their relative gain at which they end.
_GAIN = 3e-4


@dataclass(eq=False)
class RotatorSearch(Search):
    """A search for rotations about one axis alone, over any number of apparitions.

    Attributes
    ----------
    window : (float, float)
        Rates, turns per span, between which it searches.
    """

    window: tuple[float, float] = (0.7, math.inf)

    def run(self, is_ended: Callable[[bool], bool] = never) -> None:
        """Search all rates of the window about poles all over the sky."""
        low, high = self.window[0], min(self.window[1], self.most)
        self.tie = replace(self.tie, is_wide=self._has_several)
        chosen = windows(self.problem, low, high)
        trials, count = self._trials(chosen.bounds)
        self._add(self._from_trials(trials), gain=1e-3)
        self.progress(f"{len(self.convex)} convex bodies")
        if self._has_several:
            self._take_scatter()
            self._at_poles()
        else:
            self._axial_poles()
        self.finish()
        are_all = count == len(chosen.bounds) and not chosen.are_limited
        self.is_complete = not self.is_over and (are_all or self._stands_alone)
        if not are_all:
            self.notes.append(
                f"{'More than ' if chosen.are_limited else ''}{len(chosen.bounds)} windows of "
                f"periods fit the apparitions one by one, of which {count} were tried. Give a "
                "larger budget, or period=, such as that of a longer series of nights."
            )
        self.notes.append(self._words(chosen.bounds[:count]))

    @property
    def _stands_alone(self) -> bool:
        """Whether the best solution is claimed though rates that fit each apparition are untried.

        Wrong periods of 25 years are within the errors too, but up to 58 ahead of the next ones
        (`benchmarks/inversion_apparitions.py without`).
        """
        if not self.solutions or not self.is_at_floor:
            return False
        return _verdicts.gap(self.solutions, self.problem) > self.settings.alone

    @property
    def _apparitions(self) -> int:
        return len(_neighbours.apparitions_of(self.problem.seconds))

    @property
    def _has_several(self) -> bool:
        return self._apparitions > 1

    def _axial_solutions(self, problem: CurveProblem, tumbling: Sequence[Robust]) -> list[Robust]:
        """Rotations about one axis with the errors of a problem, the most probable first."""
        if not self.tie.is_wide:
            return super()._axial_solutions(problem, tumbling)
        settings = self.settings
        starts = self.axial or self.convex[: settings.axial_others]
        rotators = [self._robust(problem, start) for start in starts]
        rotators, self.beside = _pole_map.listed(rotators, settings.axial_behind, settings)
        others = self._of_other_rates(rotators, self.convex, settings.same_rate)
        return rotators + [self._robust(problem, rotator) for rotator in others]

    def _trials(self, chosen: list[tuple[float, float]]) -> tuple[list[Trial], int]:
        """The best trials of windows, the best first, and how many the budget allows to try."""
        combs, poles = Combs(self.problem), _shapes.even_directions(POLES)
        tally, settings = self.problem.tally, self.settings
        trials: list[Trial] = []
        count = 0
        for low, high in chosen:
            if count >= settings.windows and tally.spent > settings.window_share * tally.budget:
                break
            trials += scan(combs, poles, low, high, lambda: self.is_over)
            trials = sorted(trials, key=lambda trial: -trial.gain)[: settings.window_trials]
            self.progress(f"rates of {len(poles)} poles, {high - low:.0f} turns a span")
            count += 1
        return trials, count

    def _from_trials(self, trials: list[Trial]) -> list[FloatArray]:
        """Distinct ellipsoids, the best first."""
        if not trials:
            return []
        starts = np.array([ellipsoid_of(trial) for trial in trials])
        fixed = _ellipsoid.AXIAL_FIXED
        pool = _ellipsoid.minimised(self.problem, starts, _ITERATIONS, fixed=fixed)
        ordered = _ellipsoid.in_order(pool)
        self.progress(f"{len(starts)} ellipsoids")
        settings = self.settings
        most = settings.window_worse * ordered.cost[:1] + settings.window_above
        return distinct(ordered.states[ordered.cost <= most], self.is_same, settings.window_bodies)

    def _take_scatter(self) -> None:
        """Enlarge the errors of sparse sessions to what the best body leaves of them."""
        if not self.convex:
            return
        best, problem = self.convex[0], self.problem
        residual, _ = _evidence.residuals(problem, best.magnitude)
        factors = _neighbours.scatter(problem, residual, sum(SearchState.of(best.state).rates))
        factors = np.where(factors < self.settings.noisier, 1.0, factors)
        count = len(np.unique(problem.series[factors > 1.0]))
        if count:
            self.problem = problem.with_errors(factors * problem.sigma)
            sessions = quantity_text.counted(count, "session")
            self.notes.append(
                f"points far apart in time of {sessions} are up to {factors.max():.1f} times as "
                "noisy as the errors say; their errors are taken to be larger by this factor"
                f"{' of each' if count > 1 else ''}."
            )

    def _at_poles(self) -> None:
        """Convex bodies with the errors that the best one shows."""
        if not self.convex or self.is_over:
            return
        problem = self._with_own_error(self.convex[0])
        for candidate in self.convex:
            if self.is_over:
                break
            evaluation = _refinement.refine(
                problem,
                candidate.state,
                iterations=_STEPS_FREE,
                tie=self.tie,
                fixed=self._fixed(candidate.state),
                gain=_GAIN,
            )
            self.axial.append(evaluation.linearised)
        self.axial = self._most_probable(self.axial, problem)
        self.progress(f"{len(self.axial)} poles that compete")

    def _words(self, chosen: list[tuple[float, float]]) -> str:
        """What was searched."""
        hours, most = self.problem.span / 3600.0, self.settings.windows
        named = ", ".join(
            f"{hours / high:.5g} to {hours / low:.5g} h" for low, high in chosen[:most]
        )
        if len(chosen) > most:
            named += f", and {len(chosen) - most} other windows"
        count = self._apparitions
        return (
            f"Only rotations about one axis were searched, over {count} "
            f"apparition{'s' if count > 1 else ''}: periods of {named}."
        )
