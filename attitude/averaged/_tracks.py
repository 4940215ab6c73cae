"""The integration of a mean rotation in one direction of time, and its events."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from itertools import chain
from typing import TYPE_CHECKING, TypeAlias

import numpy as np

from attitude._compilation.callbacks import raising_callback_errors
from attitude._support.arrays import bisected
from attitude.averaged import _rates as layout
from attitude.averaged import _second_order
from attitude.averaged._mean_torques import SLOWEST, Crossing, Packing, delay, slowest_turns
from attitude.averaged._polhode import LAM_PLUS, REGIONS
from attitude.errors import AttitudeError

if TYPE_CHECKING:
    from attitude._support.annotations import BoolArray, FloatArray, IntArray
    from attitude.averaged._mean_torques import Window

    # Of a track and what may follow beyond the separatrix: the region to continue in, or None to
    # wait there.
    Choice: TypeAlias = Callable[["Track", Crossing], int | None]

# |N| P/(2 pi |L|) beyond which means of first order are refused.
WEAK = 0.05
# Rows of the trajectory that one call fills.
_ROWS = 512
# Turns of the first stretch of a trajectory: steps end at the ends of stretches and of windows,
# never at an epoch of a caller.
_FIRST = 1e4
# Ratio of the ends of two stretches.
_RATIO = 1.25
# Tolerance of the path along which the drift of second order is found.
_COARSE = 1e-6
# Share of the torque of light or flow that harmonics beyond a degree have, times its square: at
# least the errors of mean torques in "averaged costs" of benchmarks/averaged.py.
_BEYOND_DEGREE = 0.25
# Passages without progress after which a rotation stays at the separatrix.
_MOST_PASSAGES = 100


@dataclass(frozen=True)
class AveragedEvent:
    """Something that happens to a mean rotation.

    Attributes
    ----------
    kind : str
        "passage" of the separatrix; "uniform rotation reached" or "left": the tilt from an axis
        falls to the least tilt, or grows again; "resonance" of nutation and precession crossed.
        Three end the motion: "no longer weak"; "too slow for its path", which turns in less than
        ten turns or nutations of the body; "stays at the separatrix".
    seconds : float
        TDB seconds since the epoch of the spin.
    before, after : str
        Regions: "SAM+", "SAM-", "LAM+", "LAM-", the mode and the end of the circulated axis that
        the momentum is near.  Before and after on the way from the epoch: at negative seconds the
        motion leads, forwards in time, from `after` to `before`.
    odds : dict of str to float
        Of a passage: the odds of the regions that may follow.
    is_proved : bool
        Of a passage: False where y rises on one arc of a lap and falls on the other, so that the
        rule for the odds is not proved.
    laps : tuple
        Of a passage: the changes of y on the arc that crosses, on the other arc before and on the
        next one, and the pace, 1/s, at which the body nears the middle axis; else empty.
    ratio : (int, int)
        Of a resonance: j and k of j w_psi = k w_phi, P_psi/P_phi = j/k, phi the angle of the long
        axis about the momentum.
    turns : int
        Of a resonance with the turn of a path: n of j w_psi - k w_phi = n w_path; else 0.
    scatter : float
        Of a resonance: the root mean square, over the phase, by which the crossing changes
        y = 2 ln tan theta against the mean motion.
    strength : float
        Of a resonance: the largest rate of y from the resonant terms in units of the mean rate.
        Above 1 (`may_capture`) the motion may stay in the resonance, which means cannot follow:
        `AveragedMotion.through` takes the full motion through it.
    width : float
        Of a resonance: the distance in y from its middle within which a motion may be held.
    lasts : float
        Of a resonance: s in which the mean motion crosses it.
    capture : float
        Of a resonance: the odds that it captures the motion, of the adiabatic theory: for a loop
        that takes many of its oscillations to change, an estimate otherwise.  0 for a strength
        below 1, NaN for a resonance with the turn of a path.
    """

    kind: str
    seconds: float
    before: str
    after: str
    odds: dict[str, float] = field(default_factory=dict)
    is_proved: bool = True
    laps: tuple[float, ...] = ()
    ratio: tuple[int, int] = (0, 0)
    scatter: float = 0.0
    strength: float = 0.0
    turns: int = 0
    width: float = 0.0
    lasts: float = 0.0
    capture: float = 0.0

    @property
    def delay(self) -> float:
        """Root mean square of the time in s by which a passage comes early or late, or 0.

        Over the phase that means lose; unknown, and 0, where `is_proved` is False.
        """
        return delay(*self.laps) if self.laps else 0.0

    @property
    def may_capture(self) -> bool:
        """Whether a resonance is strong enough to hold the motion."""
        return self.strength > 1.0

    def __str__(self) -> str:
        back = " backwards in time" if self.seconds < 0.0 else ""
        if self.kind == "passage":
            shares = ", ".join(f"{name} {share:.3g}" for name, share in self.odds.items())
            doubt = "" if self.is_proved else "; the rule for the odds is not proved here"
            return f"passage from {self.before} to {self.after}{back} (odds: {shares}{doubt})"
        if self.kind == "resonance":
            odds = "" if math.isnan(self.capture) else f", odds {self.capture:.2g}"
            held = f"; it may capture the motion{odds}" if self.may_capture else ""
            j, k = self.ratio
            name = f"P_psi/P_phi = {j}/{k}"
            if self.turns:
                name = f"{j} w_psi - {k} w_phi = {self.turns} w_path"
            return (
                f"resonance {name} crossed in {self.before} (scatter of y "
                f"{self.scatter:.2g}, strength {self.strength:.2g}{held})"
            )
        return f"{self.kind}{back} ({self.before})"


@dataclass(frozen=True, eq=False)
class Course:
    """What all tracks of a motion share."""

    packing: Packing
    ends: tuple[float, float]  # least and greatest y
    tolerance: float
    pace: float  # s, a turn of the body at the epoch
    order: int = 1  # 1, or 2 with the drift of second order


class Track:
    """One trajectory in one direction of time, extended on demand."""

    def __init__(self, course: Course, x: FloatArray, region: int, sign: float) -> None:
        self.course, self.x, self.region, self.sign = course, x.copy(), region, sign
        self.clock = np.array([0.0, sign * self._first_step(), 0.0])
        self.blocks: list[FloatArray] = []
        self.events: list[AveragedEvent] = []
        self.ended: AveragedEvent | None = None
        # filled by `_resonances`: crossings, each with its kicks (K, 4) of L and y
        self.resonances: dict[
            tuple[float, tuple[int, int, int]], tuple[AveragedEvent, FloatArray]
        ] = {}
        self.odds, self._idle = 1.0, 0
        self.kicks: list[tuple[float, FloatArray]] = []  # seconds, and what was added to L and y
        self.waits: Crossing | None = None  # at the separatrix
        self._stride = float(self.clock[1])  # of the path along which drift is found
        self._goal = _FIRST * course.pace
        self._work = np.empty_like(course.packing.packed.work)
        low, high = course.ends
        if not low < x[3] < high:
            self.x[3] = min(max(x[3], low), high)
            self.clock[2] = math.copysign(1.0, x[3])

    def branched(self) -> Track:
        """A copy that shares what has been."""
        other = Track.__new__(Track)
        other.__dict__.update(self.__dict__)
        other.x, other.clock = self.x.copy(), self.clock.copy()
        other.blocks, other.events = list(self.blocks), list(self.events)
        other.resonances, other.kicks = dict(self.resonances), list(self.kicks)
        return other

    def kicked(self, seconds: float, kick: FloatArray) -> Track:
        """A copy up to seconds of the past, where kick (4,) is added to L and y."""
        other, rows = self.branched(), self.rows
        place = int(_places(rows, np.array([seconds]), self.sign)[0])
        x, region = self.states(np.array([seconds]))
        row = rows[place]
        other.blocks = [rows[: place + 1].copy()]
        other.blocks[0][-1, layout.ROW_END] = seconds
        other.x, other.region = x[0] + kick, int(region[0])
        other.clock = np.array([seconds, row[layout.ROW_STEP], row[layout.ROW_HELD]])
        other.events = self.happened(seconds)
        other.ended = other.waits = None
        other.kicks.append((seconds, kick))
        return other

    def resumed(self, seconds: float, x: FloatArray, region: int) -> Track:
        """A track from another state (4,) at seconds, in the same direction of time."""
        other = Track(self.course, x, region, self.sign)
        other.clock[0] = seconds
        return other

    def _first_step(self) -> float:
        """Seconds: a hundred turns of the body."""
        size = float(np.sqrt(self.x[:3] @ self.x[:3]))
        return 100.0 * 2.0 * math.pi * float(self.course.packing.axes.moments[2]) / size

    def reaches(self, until: float) -> bool:
        """Whether states up to seconds `until` are known."""
        return (until - self.clock[0]) * self.sign <= 0.0

    def extend(self, until: float, choose: Choice) -> None:
        """Integrate at least up to seconds `until`, to the end, or to where `choose` waits."""
        packing = self.course.packing
        while self.ended is None and self.waits is None and not self.reaches(until):
            window = packing.window(float(self.clock[0]), self.sign)
            while self._goal <= abs(self.clock[0]):
                self._goal *= _RATIO
            end = window.end if self.sign > 0.0 else window.begin
            target = self.sign * min(self._goal, end * self.sign)
            numbers = window.models, window.forcing
            if self.course.order == 2 and self.clock[2] == 0.0:
                target, numbers = self._driven(target, window)
            status, rows = self._advance(target, *numbers, self.course.tolerance)
            if len(rows):
                self.blocks.append(rows)
                self._idle = 0 if len(rows) > 3 else self._idle
                if self._ends_slowly():
                    return
            if status in (layout.PASSAGE, layout.CLAMPED, layout.RELEASED, layout.STRONG):
                self._happens(status, choose)

    def _advance(
        self, target: float, models: IntArray, forcing: FloatArray, tolerance: float
    ) -> tuple[int, FloatArray]:
        """Integrate to seconds `target` or to an event: what ended it, and the steps."""
        course, rows = self.course, np.empty((_ROWS, layout.ROW_ENTRIES))
        limits = np.array([*course.ends, WEAK, self.sign])
        with raising_callback_errors():
            status, count = layout.advance(
                self.clock,
                self.x,
                self.region,
                target,
                tolerance,
                limits,
                course.packing.packed.data,
                models,
                forcing,
                self._work,
                rows,
            )
        if status == layout.BAD:
            raise AttitudeError(
                f"the mean torque is not finite {self.clock[0]:.9g} s after the epoch; check "
                "the torques, or give earlier epochs only."
            )
        return status, rows[:count].copy()

    def _driven(self, target: float, window: Window) -> tuple[float, tuple[IntArray, FloatArray]]:
        """A nearer target, and what `_advance` takes, with the drift of second order up to it."""
        numbers, before = (window.models, window.forcing), (self.clock.copy(), self.x.copy())
        self.clock[1] = self._stride
        status, rows = self._advance(target, *numbers, _COARSE)
        if len(rows):
            even = _second_order.even(rows)
            self._stride = float(rows[min(len(even), len(rows) - 1), layout.ROW_STEP])
            if status == layout.FULL or len(even) < len(rows):
                target = float(even[-1, layout.ROW_END])
            t = _second_order.places(even)
            states = _states(even, t, self.sign)
            numbers = _second_order.driven(self.course.packing, window, t, states, self.region)
        self.clock[:], self.x[:] = before
        return target, numbers

    def _end(self, kind: str, t: float) -> None:
        self.ended = AveragedEvent(kind, t, REGIONS[self.region], REGIONS[self.region])
        self.events.append(self.ended)

    def _ends_slowly(self) -> bool:
        """End where the body turns slower than a tenth of a path; whether it does."""
        fastest = min(self.course.packing.torques.periods, default=math.inf)
        if not np.isfinite(fastest):
            return False
        rows, axes = self.blocks[-1], self.course.packing.axes

        def slow(t: FloatArray) -> BoolArray:
            states = _states(rows, t, self.sign)
            size = np.sqrt(np.sum(states[:, :3] ** 2, axis=1))
            turns = slowest_turns(axes, size, states[:, 3], self.region)
            return np.asarray(SLOWEST * turns > fastest)

        ends = np.flatnonzero(slow(rows[:, layout.ROW_END]))
        if not len(ends):
            return False
        row = rows[ends[0]]
        low, high = row[layout.ROW_START], row[layout.ROW_END]
        low, _ = bisected(lambda time: not slow(np.array([time]))[0], low, high, 60)
        self.blocks[-1] = rows[: ends[0] + 1].copy()
        self.blocks[-1][-1, layout.ROW_END] = low
        self.clock[0] = low
        self._end("too slow for its path", float(low))
        return True

    def _happens(self, status: int, choose: Choice) -> None:
        """Note an event and set the state behind it."""
        t, name = float(self.clock[0]), REGIONS[self.region]
        if status == layout.STRONG:
            self._end("no longer weak", t)
        elif status == layout.CLAMPED:
            self.clock[2] = math.copysign(1.0, self.x[3])
            self.events.append(AveragedEvent("uniform rotation reached", t, name, name))
        elif status == layout.RELEASED:
            self.clock[2] = 0.0
            self.events.append(AveragedEvent("uniform rotation left", t, name, name))
        else:
            self._idle += 1
            if self._idle > _MOST_PASSAGES:
                self._end("stays at the separatrix", t)
                return
            crossing = self.course.packing.crossing(t, self.x, self.region, self.sign)
            region = choose(self, crossing)
            if region is None:
                self.waits = crossing
            else:
                self.pass_to(region, crossing)

    def pass_to(self, region: int, crossing: Crossing) -> None:
        """Continue on the other side of the separatrix."""
        self.waits = None
        side = 1.0 if region >= LAM_PLUS else -1.0
        self.events.append(
            AveragedEvent(
                "passage",
                float(self.clock[0]),
                REGIONS[self.region],
                REGIONS[region],
                odds={REGIONS[k]: share for k, share in crossing.odds.items()},
                is_proved=crossing.is_proved,
                laps=crossing.laps.get(region, ()),
            )
        )
        self.region = region
        self.x[3] = self.course.packing.axes.separatrix + side * layout.BEYOND
        self.clock[1] = self._stride = self.sign * self._first_step()

    @property
    def rows(self) -> FloatArray:
        """The steps (N, ROW_ENTRIES) of `_rates` so far."""
        if not self.blocks:
            return np.empty((0, layout.ROW_ENTRIES))
        if len(self.blocks) > 1:
            self.blocks = [np.concatenate(self.blocks)]
        return self.blocks[0]

    def states(self, t: FloatArray) -> tuple[FloatArray, IntArray]:
        """States (T, 4) and regions (T,) at seconds (T,) up to the end of what is integrated."""
        rows = self.rows
        if not len(rows):
            return np.tile(self.x, (len(t), 1)), np.full(len(t), self.region)
        region = rows[_places(rows, t, self.sign), layout.ROW_REGION]
        return _states(rows, t, self.sign), region.astype(np.int64)

    def happened(self, until: float) -> list[AveragedEvent]:
        """The events up to seconds `until`."""
        return [event for event in self.events if (event.seconds - until) * self.sign <= 0.0]

    def passages(self, until: float | None = None) -> list[AveragedEvent]:
        """Those of the separatrix, all or up to seconds `until`."""
        events = self.events if until is None else self.happened(until)
        return [event for event in events if event.kind == "passage"]

    def error_to(self, t: FloatArray) -> FloatArray:
        """The estimate (T,) of `AveragedMotion.error_estimate` at seconds (T,)."""
        rows, packing = self.rows, self.course.packing
        if not len(rows):
            return np.zeros(len(t))
        ends = rows[:, layout.ROW_END]
        at_ends = _states(rows, ends, self.sign, np.arange(len(rows)))
        starts = rows[:, layout.ROW_TERMS : layout.ROW_TERMS + 4]
        size = np.sqrt(np.sum(starts[:, :3] ** 2, axis=1))
        change = np.sqrt(np.sum((at_ends - starts)[:, :3] ** 2, axis=1)) / size
        means = packing.torques.means
        of_light = [m.kind == layout.HARMONICS and not m.is_linear for m in chain(*means)]
        # |N| P/(2 pi |L|) of all torques, and of light and flow
        eps, light = (
            np.array(
                [
                    packing.weakness_of(row[layout.ROW_START], x, int(row[layout.ROW_REGION]), some)
                    for row, x in zip(rows, starts, strict=True)
                ]
            )
            for some in (..., np.flatnonzero(of_light))
        )
        rate = size / float(packing.axes.moments[2])
        # |N| T/(2 pi |L|) for the turns T over which torques are averaged
        of_turns = eps * rate * packing.turn / (2.0 * math.pi)
        beyond = _BEYOND_DEGREE / packing.torques.degree**2 * light * rate
        beyond *= np.abs(ends - rows[:, layout.ROW_START])
        total = np.concatenate([[0.0], np.cumsum(change * (eps + of_turns) + beyond)])
        times = np.concatenate([[0.0], ends]) * self.sign
        offset = np.concatenate([of_turns[:1], of_turns])
        return np.interp(t * self.sign, times, total) + np.interp(t * self.sign, times, offset)


def _places(rows: FloatArray, t: FloatArray, sign: float) -> IntArray:
    """The steps in which seconds (T,) lie."""
    place = np.searchsorted(sign * rows[:, layout.ROW_START], sign * t, side="right") - 1
    return np.clip(place, 0, len(rows) - 1)


def _states(
    rows: FloatArray, t: FloatArray, sign: float, place: IntArray | None = None
) -> FloatArray:
    """States (T, 4) at seconds (T,), in the steps that hold them or in given ones (T,)."""
    row = rows[_places(rows, t, sign) if place is None else place]
    share = ((t - row[:, layout.ROW_START]) / row[:, layout.ROW_STEP])[:, None]
    remaining = 1.0 - share
    terms = row[:, layout.ROW_TERMS : layout.ROW_END].reshape(-1, 5, 4)
    inner = terms[:, 2] + share * (terms[:, 3] + remaining * terms[:, 4])
    states: FloatArray = terms[:, 0] + share * (terms[:, 1] + remaining * inner)
    return states
