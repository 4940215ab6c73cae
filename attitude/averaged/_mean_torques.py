"""Torques on one body, packed once for all states that are integrated under them."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from attitude._compilation.callbacks import raising_callback_errors
from attitude._support import validation
from attitude.averaged import _rates as layout
from attitude.averaged._means import Mean, means_of, over_plane
from attitude.averaged._pack import Packed, Sampling, ripple_period, smooth_span, turn_period
from attitude.averaged._polhode import LAM_PLUS, SPREAD, Axes
from attitude.errors import AttitudeError

if TYPE_CHECKING:
    from attitude._support.annotations import FloatArray, IntArray
    from attitude.epochs._instants import Instant
    from attitude.motions._body import Body
    from attitude.torques._torque import Torque

# Turns and nutations of the body in one turn of a path, at least.
SLOWEST = 10.0
# Change of L, rad, in one turn of a path below which "auto" averages over the turn.
_SMALL = 1e-3 * 2.0 * math.pi
# The same for the turn about a planet of a path from the Sun: its direction turns by 1e-3 at most,
# and an eclipse leaves out a small part.
_SMALL_IN_RIPPLE = 0.1
# Bytes of the windows of paths that are kept.
_LARGEST = 1 << 28


@dataclass(frozen=True, eq=False)
class Window:
    """Numbers of the paths in a window of time, as the compiled loops take them."""

    forcing: FloatArray
    models: IntArray  # of `Packed`, with the places of blocks in `forcing`
    begin: float  # TDB seconds since the epoch; infinite where nothing changes, as `end`
    end: float


class MeanTorques:
    """The means of torques on one body, for any of its states; seconds count from `instant`.

    degree: the largest of the harmonics of torques of one direction.
    """

    def __init__(
        self, body: Body, torques: tuple[Torque, ...], instant: Instant, degree: int
    ) -> None:
        self.body, self.torques, self.instant, self.degree = body, torques, instant, degree
        self.axes = Axes(body)
        self._packings: dict[tuple[tuple[bool, float], ...], Packing] = {}
        # filled by `_resonances.listed`
        self.resonances: list[tuple[int, int, bool, float]] | None = None

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (self.body, self.torques, self.instant, self.degree)

    @cached_property
    def periods(self) -> list[float]:
        """s, of one turn of the path of each torque; infinite without one."""
        return [turn_period(torque, self.instant) for torque in self.torques]

    @cached_property
    def ripples(self) -> list[float]:
        """s, of the turn about a planet in the path from the Sun of each torque; else infinite."""
        return [ripple_period(torque, self.instant) for torque in self.torques]

    @cached_property
    def means(self) -> list[list[Mean]]:
        """The means that make up each torque."""
        return [
            list(means_of(torque, self.body, self.axes, self.degree)) for torque in self.torques
        ]

    @cached_property
    def span(self) -> tuple[float, float]:
        """First and last TDB seconds since the epoch that the paths of the torques cover."""
        spans = [torque.span(self.instant) for torque in self.torques]
        return max(a for a, _ in spans), min(b for _, b in spans)

    @cached_property
    def _single(self) -> list[list[Packed]]:
        """Each mean alone, with the numbers of its path at an epoch."""
        pairs = zip(self.torques, self.periods, self.means, strict=True)
        return [
            [
                Packed(
                    self.axes,
                    self.body,
                    [(Sampling(torque, period, False, math.inf), mean)],
                    self.instant,
                )
                for mean in means
            ]
            for torque, period, means in pairs
        ]

    def packing(self, kinds: list[str], size: float, y: float, region: int) -> Packing:
        """The packed means for "averaged", "followed" or "auto" of each torque, for a state."""
        self._refuse_fast_paths(size, y, region)
        chosen = []
        for k, (kind, period) in enumerate(zip(kinds, self.periods, strict=True)):
            turn, ripple = period, self.ripples[k]
            change = self._rate_of(k, size, y, region) if kind == "auto" else 0.0
            first, last = self.torques[k].span(self.instant)
            if kind == "averaged" and np.isfinite(turn) and turn > last - first:
                raise AttitudeError(
                    f"the path of {type(self.torques[k]).__name__} is known for "
                    f"{last - first:.4g} s, and a turn of it takes {turn:.4g} s; give a longer "
                    'path, or orbit="followed".'
                )
            averaged = bool(np.isfinite(turn)) and kind != "followed" and change * turn < _SMALL
            averaged = averaged and turn <= last - first
            smooth = np.isfinite(ripple) and kind != "followed" and ripple <= last - first
            smooth = smooth and change * ripple < _SMALL_IN_RIPPLE
            chosen.append((averaged, ripple if smooth else math.inf))
        key = tuple(chosen)
        if key not in self._packings:
            self._packings[key] = Packing(self, key)
        return self._packings[key]

    def slowest(self, size: float, y: float, region: int) -> float:
        """s, the longer one of a turn and a nutation of small amplitude.

        Without the growth of the period at the separatrix, which a motion passes in a few turns.
        """
        return float(slowest_turns(self.axes, np.array([size]), np.array([y]), region)[0])

    def _refuse_fast_paths(self, size: float, y: float, region: int) -> None:
        slowest = self.slowest(size, y, region)
        for torque, period in zip(self.torques, self.periods, strict=True):
            if period < SLOWEST * slowest:
                raise AttitudeError(
                    f"the path of {type(torque).__name__} turns once in {period:.4g} s, and the "
                    f"body turns or nutates once in {slowest:.4g} s; means over the nutation need "
                    "a path that is ten times slower. Integrate by TorquedRotation."
                )

    def _rate_of(self, number: int, size: float, y: float, region: int) -> float:
        """rad/s, an upper bound or root mean square, by which a torque turns the momentum."""
        x, out, total = np.array([0.6 * size, 0.0, 0.8 * size, y]), np.empty(4), 0.0
        for packed in self._single[number]:
            forcing = packed.window(0, math.inf, (0.0, 0.0))
            with raising_callback_errors():
                eps = layout.rates_at(
                    0.0, x, region, packed.data, packed.models, forcing, packed.work, out, 1
                )
            total = max(total, eps * size / float(self.axes.moments[2]))
        return total


class Packing:
    """The means of torques, packed, with windows of the numbers of their paths.

    averaged: of each torque, whether it is averaged over the turn of its path, and the s of the
    turn about a planet over which it is averaged, or infinity.
    """

    def __init__(self, torques: MeanTorques, averaged: tuple[tuple[bool, float], ...]) -> None:
        self.torques, self.axes, self._kinds = torques, torques.axes, averaged
        self.averaged = tuple(turn for turn, _ in averaged)
        means = []
        rows = zip(torques.torques, torques.periods, averaged, torques.means, strict=True)
        for k, (torque, period, (turn, ripple), several) in enumerate(rows):
            smooth = smooth_span(torque, torques.instant, period) if turn else 0.0
            for mean, single in zip(several, torques._single[k], strict=True):
                bare = Sampling(torque, period, turn, math.inf, ripple, smooth)
                bare = replace(bare, is_even=single.is_even(bare, mean))
                interval = single.interval(bare, mean)
                means.append(
                    (replace(bare, interval=interval), over_plane(mean) if bare.is_even else mean)
                )
        self.packed = Packed(self.axes, torques.body, means, torques.instant)
        # s, of the turns over which torques are averaged: mean by size; 0: none
        self.turn = self._mean_turn()
        self._windows: dict[int, Window] = {}
        self._kept = 0  # bytes of the windows

    def __reduce__(self) -> tuple[Any, ...]:
        # Packed means hold addresses of functions, which are those of one process.
        return type(self), (self.torques, self._kinds)

    @property
    def paths(self) -> list[tuple[Torque, float, bool]]:
        """Each torque, the period of its path in s, and whether it is averaged over the turn."""
        torques = self.torques
        return list(zip(torques.torques, torques.periods, self.averaged, strict=True))

    def _mean_turn(self) -> float:
        """s, of the turns over which torques are averaged, by their shares of all torques."""
        torques, some = self.torques, np.array(self.averaged)
        if not np.any(some):
            return 0.0
        y = self.axes.separatrix - 1.0
        size = float(self.axes.moments[2])
        rates = np.array([torques._rate_of(k, size, y, 0) for k in range(len(some))])
        periods = np.where(some, torques.periods, 0.0)
        return float(rates @ periods / max(float(np.sum(rates)), 1e-300))

    def window(self, t: float, sign: float) -> Window:
        """The window of a time, towards later (1) or earlier (-1) times."""
        length, span = self.packed.length, self.torques.span
        number = 0
        if np.isfinite(length):
            # a step that ends a window does so to rounding
            place = t / length + 1e-6 * sign
            number = math.floor(place) if sign > 0.0 else math.ceil(place) - 1
        window = self._windows.get(number)
        if window is None:
            forcing = self.packed.window(number, length, span)
            begin, end = -math.inf, math.inf
            if np.isfinite(length):
                begin = max(number * length, span[0])
                end = min((number + 1) * length, span[1])
            window = Window(forcing, self.packed.models.copy(), begin, end)
            if self._kept + forcing.nbytes > _LARGEST:
                self._windows.clear()
                self._kept = 0
            self._windows[number] = window
            self._kept += forcing.nbytes
        return window

    def weakness_of(self, t: float, x: FloatArray, region: int, means: Any = ...) -> float:
        """|N| P/(2 pi |L|) of a state (4,): L, y."""
        return self.rates_of(t, x, region, means)[1]

    def rates_of(
        self, t: float, x: FloatArray, region: int, means: Any = ...
    ) -> tuple[FloatArray, float]:
        """dL/dt and dy/dt (4,) of a state (4,), and |N| P/(2 pi |L|), of all or some means."""
        window = self.window(t, 1.0 if t < self.torques.span[1] else -1.0)
        out, work, models = np.empty(4), np.empty_like(self.packed.work), window.models[means]
        with raising_callback_errors():
            eps = layout.rates_at(
                t, np.array(x), region, self.packed.data, models, window.forcing, work, out, 1
            )
        return out, float(eps)

    def crossing(self, t: float, x: FloatArray, region: int, sign: float) -> Crossing:
        """What may follow at the separatrix, from the changes of y on its four arcs in one lap."""
        window, out = self.window(t, sign), np.empty(4)
        arcs, seconds = self.axes.arcs
        state = np.array(x)
        state[3] = self.axes.separatrix
        work = np.empty_like(self.packed.work)
        with raising_callback_errors():
            layout.changes_on_arcs(
                t, state, self.packed.data, window.models, window.forcing, arcs, seconds, work, out
            )
        change = sign * out.reshape(2, 2)  # by sA and by sC
        if region >= LAM_PLUS:
            change, start, goals = -change, region - LAM_PLUS, (0, 1)
        else:
            change, start, goals = change.T, region, (2, 3)
        # away from the region on its two arcs, and on the other arc of each goal
        leaving, onward = change[start], change[1 - start]
        share = np.maximum(leaving, 0.0)
        total = float(np.sum(share))
        if not total > 0.0:
            return Crossing({goals[0]: 0.5, goals[1]: 0.5}, {}, False)
        odds = {goal: float(weight) / total for goal, weight in zip(goals, share, strict=True)}
        if not np.all(leaving > 0.0):
            return Crossing(odds, {}, False)
        pace = float(np.sqrt(state[:3] @ state[:3])) * self.axes.separatrix_pace
        laps = {
            goal: (float(leaving[k]), float(leaving[1 - k]), float(onward[k]), pace)
            for k, goal in enumerate(goals)
            if onward[k] > 0.0
        }
        return Crossing(odds, laps, True)


@dataclass(frozen=True)
class Crossing:
    """A passage of the separatrix."""

    # Of the two regions beyond: those of arcs that lead away, in proportion to the change of y.
    odds: dict[int, float]
    # Of a region, what `delay` takes; none where y rises on one arc and falls on another.
    laps: dict[int, tuple[float, float, float, float]]
    # whether y changes to the same side on both arcs, as the rule for the odds has it
    is_proved: bool


def delay(leading: float, other: float, onward: float, pace: float) -> float:
    """Root mean square in s, over the phase, of the time by which a passage differs from its means.

    A half lap at the distance h of y takes ln(16/h)/pace.  leading, other: changes of y on the arc
    that crosses and on the other one before; onward: on the next one.

    The half laps are sums of such logarithms over y at their middles, which lose these steps, the
    means an integral; their difference is one of gamma functions of the distance at the crossing
    (Cary, Escande & Tennyson, Phys. Rev. A 34, 4256 (1986), of equal steps; Neishtadt 1986).
    """
    from scipy.special import gammaln

    place = np.asarray((np.arange(1000) + 0.5) / 1000.0 * leading, np.float64)

    def side(distance: FloatArray, step: float) -> FloatArray:
        lap, x = leading + step, distance / (leading + step)
        share = leading / lap
        time: FloatArray = (share - 2.0 * x) * np.log(16.0 / lap)
        total: FloatArray = time + gammaln(x) + gammaln(x + 1.0 - share) - np.log(2.0 * np.pi)
        return total

    total = side(place, other) + side(leading - place, onward)
    return float(np.sqrt(np.mean(total**2))) / pace


def slowest_turns(axes: Axes, size: FloatArray, y: FloatArray, region: int) -> FloatArray:
    """s (N,), the longer one of a turn and a nutation without its growth at the separatrix."""
    half = 0.5 * np.clip(y, -700.0, 700.0)
    share, gap = (
        (-half, axes.numbers[SPREAD + 2]) if region < LAM_PLUS else (half, axes.numbers[SPREAD + 1])
    )
    # cos theta or sin theta
    side = 1.0 / np.sqrt(1.0 + np.exp(-2.0 * share))
    pace = side * math.sqrt(axes.spread * gap)
    with np.errstate(divide="ignore"):
        return 2.0 * np.pi / size * np.maximum(axes.moments[2], 1.0 / pace)


def checked_orbits(words: Any, count: int) -> list[str]:
    """The word of each torque."""
    several = [words] * count if isinstance(words, str) else words
    if not isinstance(several, Iterable):
        raise AttitudeError('orbit is not text; give "auto", "averaged" or "followed".')
    listed = list(several)
    if len(listed) != count:
        raise AttitudeError(
            f"orbit has {len(listed)} entries for {count} torques; give one for all, or one each."
        )
    return [validation.one_of(word, "orbit", ("auto", "averaged", "followed")) for word in listed]
