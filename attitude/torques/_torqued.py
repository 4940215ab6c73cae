"""`TorquedRotation`: kicks of torques between exact free motions, in fixed or adaptive steps.

>>> import numpy as np
>>> from attitude import Body, Spin
>>> from attitude.splitting import TorquedRotation
>>> from attitude.torques import ConstantTorque
>>> body = Body(moments=(10, 20, 26))
>>> spin = Spin(epoch="2026-01-01", wxyz=(1, 0, 0, 0), angular_velocity=(0, 0, 0))
>>> motion = TorquedRotation(body, spin, ConstantTorque((0, 0, 0.26)), step=0.1)
>>> motion.at(10.0).angular_velocity.round(12)          # 0.01 rad/s2 for 10 s
array([0. , 0. , 0.1])
"""

from __future__ import annotations

import copy
import os
import threading
import time
import weakref
from collections.abc import Iterable
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cached_property, partial
from typing import TYPE_CHECKING, Any, Self

import numpy as np

from attitude._solver import march_layout as layout
from attitude._solver.adaptive import estimated
from attitude._solver.march_layout import KEPT_ENTRIES, OMEGA, STATE_ENTRIES
from attitude._support import pairs, validation
from attitude._support.synonyms import arguments
from attitude.epochs import _inputs
from attitude.errors import AttitudeError
from attitude.motions._body import Body
from attitude.motions._differentiable import Differentiable
from attitude.motions._spin import Spin, refuse_others
from attitude.torques import _schemes
from attitude.torques._system import LARGEST_TURN, System, TorquedSensitivity
from attitude.torques._torque import CustomTorque, Torque

if TYPE_CHECKING:
    from collections.abc import Iterator
    from typing import TypeAlias

    from numpy.typing import ArrayLike

    from attitude._support.annotations import (
        Epoch,
        EpochOrSeconds,
        FloatArray,
        IntArray,
        Real,
    )
    from attitude.epochs._instants import Instant
    from attitude.motions._history import AttitudeHistory
    from attitude.torques._schemes import Scheme
    from attitude.torques._torque import AnyTorques

    _Steps: TypeAlias = "FixedSteps | VaryingSteps | BoundedSteps"


@dataclass(frozen=True, eq=False)
class StepMesh:
    """The steps in one direction: starts, and the last end (2, N + 1), s since the epoch, in pairs.

    Each is divided into `halves` equal steps of the scheme.
    """

    times: FloatArray
    halves: int

    @property
    def count(self) -> int:
        """N + 1: the last step, which may be shorter, starts at the end of the others."""
        return self.times.shape[1]

    def lengths(self, first: int, end: int) -> FloatArray:
        """Lengths (K,) of the steps from there, s; 0 for one beyond the last."""
        hi, lo = self.times[:, first : end + 1]
        lengths = np.diff(hi) + np.diff(lo)
        return lengths if len(lengths) == end - first else np.append(lengths, 0.0)

    def place(self, t: FloatArray, low: FloatArray) -> tuple[IntArray, FloatArray]:
        """The steps in which epochs t + low lie, ascending in size, and the seconds from there."""
        place = np.searchsorted(np.abs(self.times[0]), np.abs(t + low), side="right") - 1
        return place, (t - self.times[0, place]) + (low - self.times[1, place])


# ---- Sizes of the blocks of a long computation, such that Ctrl-C is heard between them

# s: a longer block shrinks.  Python acts on a signal when a compiled loop returns; 0.2 s is felt as
# at once.
_LONGEST = 0.05
# s: a shorter block grows, at most by this factor at once.
_SHORTEST = 0.02
_LARGEST_GROWTH = 16
# Items of the first block.
_FIRST = 8


class Pace:
    """The number of items, at most `most`, of a block of 0.05 s: `size`; `items` of this block."""

    def __init__(self, most: int) -> None:
        self.most, self.size, self.items = most, min(most, _FIRST), 0

    @contextmanager
    def measured(self) -> Iterator[None]:
        """Run a block that sets `items`, and adapt `size` to the time that it takes."""
        begin, self.items = time.monotonic(), 0
        yield
        took = time.monotonic() - begin
        if took > _LONGEST:
            self.size = min(self.most, max(1, int(self.items * _LONGEST / took)))
        elif self.items >= self.size and took < _SHORTEST:
            grown = _LARGEST_GROWTH * took < _SHORTEST
            self.size = min(self.most, (_LARGEST_GROWTH if grown else 2) * self.size)


# ---- States of a torqued motion after fixed steps, integrated on demand and kept

# Fixed steps: the state after every 32nd step is kept.
_EVERY = 32
# At so many states (15 MB) every second one is discarded and the interval doubles, so that memory
# is bounded, and an epoch costs at most a few hundred steps for each hundred million taken.
_MOST = 1 << 17
# Epochs at which motions of two steps are compared.
_COMPARED = 4096
# rad, the rounding of an answer.
_ROUNDING = 2e-15
# Steps integrated in one call of the compiled loops, at most.
_STEPS = 2048
# Kicks sampled for one, at most.
_ROWS = 1 << 18


class KeptStates:
    """Rows of states after each `every` steps in a direction; `farthest`: s, of those asked."""

    def __init__(self, first: FloatArray) -> None:
        self.kept, self.count, self.every = first[None].copy(), 1, _EVERY
        self.farthest = 0.0

    def _is_thinned(self):
        """Discard every other row if there are too many; whether that was done."""
        if self.count <= _MOST:
            return False
        self.kept[: self.count // 2 + 1] = self.kept[: self.count : 2]
        self.count, self.every = self.count // 2 + 1, 2 * self.every
        return True

    def _keep(self, rows):
        """Append rows to `kept`, which grows by doubling."""
        count = self.count + len(rows)
        if count > len(self.kept):
            larger = np.empty((max(2 * len(self.kept), count), self.kept.shape[1]))
            larger[: self.count] = self.kept[: self.count]
            self.kept = larger
        self.kept[self.count : count] = rows
        self.count = count


class FixedSteps(KeptStates):
    """States after steps of h, s, negative before the epoch."""

    def __init__(self, system: System, h: float) -> None:
        super().__init__(system.start)
        self.system, self.h = system, h
        self._steps_at_once, self._rows_at_once = Pace(_STEPS), Pace(_ROWS)

    @property
    def reached(self) -> float:
        """Seconds since the epoch of the last kept state."""
        return (self.count - 1) * self.every * self.h

    def states(self, seconds: FloatArray, low: FloatArray) -> FloatArray:
        """(T, 7) at seconds + low of this direction."""
        farthest = float(np.max(np.abs(seconds + low)))
        self.system.check_span(farthest, self.h)
        self.farthest = max(self.farthest, farthest)
        number, parts = whole_steps(seconds, low, self.h)
        order = np.lexsort((np.abs(parts), number))
        self._extend(int(number[order[-1]]))
        segment = number[order] // self.every
        rank = np.cumsum(np.diff(segment, prepend=segment[0]) != 0)
        out = np.empty((len(seconds), 7))
        begin = 0
        while begin < len(order):
            # As many segments and epochs as one call takes.
            rows = self._rows_at_once.size
            most = max(1, rows // (self.every * self.system.kicks))
            end = int(np.searchsorted(rank, rank[begin] + most))
            end = min(end, begin + max(1, rows // self.system.kicks))
            in_segment = order[begin:end]
            with self._rows_at_once.measured():
                # one call takes as many as it can, but for the last
                few = min(rows - 1, (end - begin) * self.system.kicks)
                self._rows_at_once.items = rows if end < len(order) else few
                used, place = np.unique(segment[begin:end], return_inverse=True)
                numbers = (used * self.every).astype(np.float64)
                steps = number[in_segment] - segment[begin:end] * self.every
                out[in_segment] = self.system.revisit(
                    self.kept[used], numbers, self.h, place, steps, parts[in_segment]
                )
            begin = end
        return out

    def mesh(self, until: float) -> StepMesh:
        """The steps that reach `until`, s."""
        self.system.check_span(until, self.h)
        count = int(np.floor(abs(until / self.h)))
        times = np.array(pairs.product(np.arange(count + 1.0), self.h))
        return StepMesh(times, 1)

    def estimate(self) -> float:
        """Estimate of the largest error of the attitudes that were asked, rad.

        Steps half as long err by less than half: twice the difference is a bound.
        """
        if self.farthest == 0.0:
            return 0.0
        finer = FixedSteps(self.system, 0.5 * self.h)
        # not at the same place in each step
        shares = (np.arange(_COMPARED) + 0.5 * np.sqrt(5.0)) / _COMPARED
        t = np.copysign(self.farthest, self.h) * np.append(shares[shares < 1.0], 1.0)
        one, two = (grid.states(t, np.zeros(len(t)))[:, :4] for grid in (self, finer))
        return 4.0 * float(np.max(np.sqrt(np.sum((one - two) ** 2, axis=1)))) + _ROUNDING

    def _extend(self, number: int) -> None:
        """Keep states up to a number of steps."""
        while (self.count - 1) < number // self.every:
            if self._is_thinned():
                continue
            run = min(
                max(1, self._steps_at_once.size // self.every),
                number // self.every - (self.count - 1),
                _MOST + 1 - self.count,
            )
            self._keep(self._following(run))

    def _following(self, run: int) -> FloatArray:
        """The next states to keep (run, 14): several in one block, or one after several blocks."""
        state, first = self.kept[self.count - 1].copy(), (self.count - 1) * self.every
        pace = self._steps_at_once
        if run > 1:
            steps = run * self.every
            with pace.measured():
                pace.items = steps
                return self.system.march(state, first, self.h, steps, self.every)
        taken = 0
        while taken < self.every:
            steps = min(self.every - taken, pace.size)
            with pace.measured():
                pace.items = steps
                self.system.march(state, first + taken, self.h, steps, self.every)
            taken += steps
        return state[None]


def whole_steps(seconds: FloatArray, low: FloatArray, h: float) -> tuple[IntArray, FloatArray]:
    """How many whole steps of length h lead to epochs seconds + low (T,), and s of a last one."""
    number = np.floor((seconds + low) / h)
    hi, lo = pairs.product(number, h)
    parts = (seconds - hi) + (low - lo)
    # a quotient that was rounded up to the next whole number
    early = parts * np.sign(h) < 0.0
    number[early] -= 1.0
    parts[early] += h
    return np.maximum(number, 0.0).astype(np.int64), parts


# ---- The advance of an integration with adaptive steps, and of states between its steps

# Steps of one length whose samples are computed together, at most.
_WAVE = 512
# Steps tried in one call, at most.
_STEPS_AT_ONCE = 1 << 14
# s: the first step of a body at rest; it grows or shrinks by factors of 4.
_STEP_AT_REST = 1.0
# Longest piece of a free motion: truncation is below the rounding of the attitude and below 3e-17
# of the rate.
_PIECE = 0.125
# Truncation is below 1e-13 rad, of which a fifth is in the estimate of the error: for whole steps,
# which only show the error, from this tolerance on.
_LONGER_PIECE = 0.24
_COARSE = 1e-12
# The tolerance for a motion with whole steps beside, whose errors add up.
_COARSE_BESIDE = 1e-10
# Steps of a window, which shows the progress.
_WINDOW = 64
# More steps to the last epoch take hours.
_MOST_AHEAD = 1e10
# Steps, some seconds of work, in which the body must turn by this share of the tolerance in the
# mean: a torque that switches at every step (a thruster on its threshold) leads to shorter ones.
_MANY_STEPS = 1 << 17
_LEAST_TURN = 1e-2


class Front:
    """Where an integration has arrived, and all on which its next steps depend.

    `sign` is 1 after the epoch; `paired` adds a motion with whole steps
    (`attitude._solver.adaptive`); `last`: s, the size of the seconds beyond which no torque is
    known.
    """

    def __init__(
        self, system: System, sign: float, tolerance: float, paired: bool, last: float
    ) -> None:
        self.system, self.last = system, last
        self.clock = np.zeros(layout.CLOCK_ENTRIES)
        self.counts = np.zeros(layout.COUNTERS, np.int64)
        self.fine = system.start.copy()
        self.coarse = system.start.copy() if paired else np.empty(0)
        limit = 0.5 * LARGEST_TURN / float(np.max(np.abs(system.scheme.flights)))
        speed = float(np.sqrt(self.fine[OMEGA] @ self.fine[OMEGA]))
        self.clock[layout.TOLERANCE], self.clock[layout.TURN_LIMIT] = tolerance, limit
        self.clock[layout.FINE_PIECE] = _PIECE
        coarse = tolerance >= (_COARSE_BESIDE if paired else _COARSE)
        self.clock[layout.WHOLE_PIECE] = _LONGER_PIECE if coarse else _PIECE
        first = 0.1 * limit / speed if speed > 0.0 else _STEP_AT_REST
        self.clock[layout.LENGTH] = sign * first
        self._wave, self._pace = 16, Pace(_STEPS_AT_ONCE)
        self._mark = 0, 0.0
        self._turned = np.zeros(2)  # steps, and the turn in them, rad
        self.goal = 0.0  # rad: the error allowed at the end; 0 without

    @property
    def time(self) -> float:
        """Seconds since the epoch of the state."""
        return float(self.clock[layout.TIME])

    @property
    def row(self) -> FloatArray:
        """What `layout` calls a kept state (16,)."""
        return np.concatenate([self.clock[[layout.TIME, layout.LENGTH]], self.fine])

    def from_row(self, row: FloatArray) -> Front:
        """The same integration, at a kept state."""
        other = self.copy()
        other.counts[:], other.coarse, other.goal = 0, np.empty(0), 0.0
        other._mark = 0, float(row[layout.KEPT_TIME])
        other.clock[layout.TIME] = row[layout.KEPT_TIME]
        other.clock[layout.LENGTH] = row[layout.KEPT_LENGTH]
        other.fine[:] = row[layout.KEPT_STATE]
        return other

    def copy(self) -> Front:
        """A copy that may advance, and be discarded if the advance fails."""
        other = copy.copy(self)
        for name in ("clock", "counts", "fine", "coarse", "_turned"):
            setattr(other, name, getattr(self, name).copy())
        return other

    def advance(self, until: float, kept: FloatArray, every: int) -> int:
        """Take the steps of one call, to `until` at most; the number of rows filled in `kept`."""
        from attitude._solver.adaptive import adapt

        self.clock[layout.UNTIL] = until
        # Beyond the end of a path the path itself refuses.
        self.clock[layout.LAST] = max(self.last, abs(until))
        most = self._pace.size
        samples = self._samples(min(most, self._wave))
        before, system = self.counts[layout.TAKEN], self.system
        with self._pace.measured():
            system.run(
                adapt,
                self.clock[layout.LENGTH],
                *system.setup,
                self.clock,
                self.counts,
                self.fine,
                self.coarse,
                system.scheme.order,
                most,
                samples,
                kept,
                every,
            )
            self._pace.items = int(self.counts[layout.TRIED])
        self._check_progress(until)
        taken = int(self.counts[layout.TAKEN] - before)
        self._wave = min(_WAVE, max(8, 2 * taken))
        return int(self.counts[layout.KEPT])

    def _check_progress(self, until: float) -> None:
        """Raise the AttitudeError for steps so short that the last epoch is never reached."""
        count, begin = self._mark
        steps = int(self.counts[layout.TAKEN]) - count
        if steps < _WINDOW:
            return
        self._mark = count + steps, self.time
        seconds = abs(self.time - begin)
        self._turned += [steps, seconds * float(np.linalg.norm(self.fine[OMEGA]))]
        trouble = ""
        if seconds / steps * _MOST_AHEAD < abs(until) - abs(self.time):
            trouble = f"more than {_MOST_AHEAD:.0e} would lead to the last epoch"
        elif self._turned[0] >= _MANY_STEPS:
            if self._turned[1] < _LEAST_TURN * self.goal * self._turned[0]:
                trouble = "the body turns by less than a hundredth of the tolerance in each"
            self._turned[:] = 0.0
        if trouble:
            raise AttitudeError(
                f"{self.time:.9g} s after the epoch the steps are so short that {trouble}; the "
                "torque is not smooth there, or the tolerance is too small. Give a larger "
                "tolerance, or a fixed step."
            )

    def _samples(self, count: int) -> FloatArray:
        """Samples (steps, 3 n + 2, columns) of steps of the present length; no steps without."""
        if not self.system.columns:
            return np.zeros((0, 1, 1))
        t, h = self.clock[layout.TIME], self.clock[layout.LENGTH]
        # The sums that the loop makes, each rounded.
        times = np.add.accumulate(np.concatenate([[t], np.full(count, h)]))
        last = self.clock[layout.LAST]
        times = times[: max(2, int(np.searchsorted(np.abs(times), last)) + 1)]
        times = np.clip(times, -last, last)
        starts, steps = times[:-1], np.diff(times)
        middles, zeros = starts + 0.5 * steps, np.zeros(len(starts))
        system = self.system
        whole = system.kick_times(np.stack([starts, zeros]), steps)
        halves = [
            system.kick_times(np.stack([first, zeros]), 0.5 * steps) for first in (starts, middles)
        ]
        return system.sampled(np.concatenate([whole, halves[0][..., :-1], halves[1]], axis=-1))


def _between(system, states, times, place, parts):
    """States (T, 7) at `parts` seconds after some of the states (S, 14) at `times` (S,)."""
    from attitude._solver.adaptive import between as compiled

    half, begin = 0.5 * parts, times[place]
    starts = np.stack([begin, np.zeros(len(begin))])
    one = system.kick_times(starts, half)
    two = system.kick_times(np.array(pairs.add((starts[0], starts[1]), half)), half)
    within = system.sampled(np.concatenate([one[..., :-1], two], axis=-1))
    out = np.empty((len(place), STATE_ENTRIES // 2))
    states = np.ascontiguousarray(states)
    system.run(compiled, 0.0, *system.setup, states, times, place, parts, within, out)
    return out


# ---- States of a torqued motion after steps as long as an error estimate allows

# The state after every 32nd step is kept; at 131,072 states (17 MB) every second one is discarded
# and the interval doubles.
# Epochs evaluated in one call of the compiled loops, at most.
_EPOCHS = 1 << 15
# States between which they lie, at most.
_STATES = 1 << 14
# States kept in one call: at most.
_ROWS_KEPT = 1 << 10


class VaryingSteps(KeptStates):
    """States after steps whose errors are within a tolerance, rad, and share of the rate.

    `paired`: whether the error is estimated by a motion with steps twice as long.
    """

    def __init__(self, system: System, sign: float, tolerance: float, paired: bool = False) -> None:
        self.system, self.sign, self.tolerance = system, sign, tolerance
        spans = [torque.span(system.epoch) for torque in system.torques]
        last = min(last if sign > 0.0 else -first for first, last in spans)
        self._front = Front(system, sign, tolerance, paired, last)
        super().__init__(self._front.row)
        self._least = tolerance + _ROUNDING
        self._epochs_at_once = Pace(_EPOCHS)

    @property
    def reached(self) -> float:
        """Seconds since the epoch to which states have been integrated."""
        return self._front.time

    @property
    def steps(self) -> int:
        """Number of steps taken."""
        return int(self._front.counts[layout.TAKEN])

    @property
    def error(self) -> float:
        """Estimate of the largest error of an attitude so far, rad; for paired steps only.

        The difference of motions with whole and with halved steps, which is not divided by 2^p - 1:
        long steps err by lower powers. Errors of steps at kinks, where it may vanish by chance, are
        added.
        """
        if self.steps == 0:
            return 0.0
        return float(estimated(self._front.clock)) + self._least

    def estimate(self) -> float:
        """Estimate of the largest error of the attitudes that were asked, rad."""
        other = VaryingSteps(self.system, self.sign, self.tolerance, paired=True)
        other.extend(self.sign * self.farthest)
        return other.error

    def mesh(self, until: float) -> StepMesh:
        """The steps that reach `until`, s."""
        self.extend(until)
        ends = np.append(np.abs(self.kept[1 : self.count, 0]), np.inf)
        count = int(np.searchsorted(ends, abs(until), side="right")) + 1
        total = np.minimum(ends[:count], abs(until))
        times = self._steps_of(np.arange(count), total)[:, layout.KEPT_TIME]
        times = times[np.abs(times) <= abs(until)]
        return StepMesh(np.stack([times, np.zeros(len(times))]), 2)

    def states(self, seconds: FloatArray, low: FloatArray) -> FloatArray:
        """(T, 7) at seconds + low of this direction."""
        total = np.abs(seconds + low)
        self.extend(self.sign * float(np.max(total)))
        order = np.argsort(total, kind="stable")
        total = total[order]
        segment = np.searchsorted(np.abs(self.kept[: self.count, 0]), total, side="right") - 1
        out = np.empty((len(order), STATE_ENTRIES // 2))
        begin = 0
        while begin < len(order):
            # As many segments and epochs as one call takes.
            size = self._epochs_at_once.size
            segments = max(1, min(size, _STATES) // self.every)
            end = int(np.searchsorted(segment, segment[begin] + segments))
            end = min(end, begin + size)
            in_block = order[begin:end]
            with self._epochs_at_once.measured():
                self._epochs_at_once.items = end - begin
                rows = self._steps_of(segment[begin:end], total[begin:end])
                times = np.ascontiguousarray(rows[:, layout.KEPT_TIME])
                place = np.searchsorted(np.abs(times), total[begin:end], side="right") - 1
                parts = (seconds[in_block] - times[place]) + low[in_block]
                state = rows[:, layout.KEPT_STATE]
                out[in_block] = _between(self.system, state, times, place, parts)
            begin = end
        return out

    def _steps_of(self, segment: IntArray, total: FloatArray) -> FloatArray:
        """Rows after each step of some segments, to the last epoch in each; both ascending."""
        all_states = []
        last = np.flatnonzero(np.append(np.diff(segment) != 0, True))
        for k, until in zip(segment[last], total[last], strict=True):
            all_states.append(self.kept[k][None])
            # From a kept state the same steps follow, however they are divided into calls.
            front, most = self._front.from_row(self.kept[k]), self.every
            end = min(until, abs(self.reached) if k + 1 == self.count else abs(self.kept[k + 1, 0]))
            while abs(front.time) < end and most > 0:
                rows = np.empty((most, KEPT_ENTRIES))
                filled = front.advance(self.sign * end, rows, 1)
                all_states.append(rows[:filled])
                most -= filled
        rows = np.concatenate(all_states)
        # The end of a segment is the start of the next.
        return rows[np.append(np.diff(np.abs(rows[:, 0])) > 0.0, True)]

    def extend(self, until: float, limit: float = np.inf) -> None:
        """Integrate to seconds `until`, or till the estimate of the error exceeds a limit."""
        self.farthest = max(self.farthest, abs(until))
        self._check_span(until)
        self._front.goal = limit if limit < np.inf else 0.0
        while abs(self.reached) < abs(until) and self.error <= limit:
            self._is_thinned()
            rows = np.empty((min(_MOST + 1 - self.count, _ROWS_KEPT), KEPT_ENTRIES))
            # Should it be interrupted, the copy is given up.
            front = self._front.copy()
            front.clock[layout.LIMIT] = limit - self._least
            filled = front.advance(until, rows, self.every)
            self._keep(rows[:filled])
            self._front = front

    def _check_span(self, until: float) -> None:
        omega = self._front.fine[OMEGA]
        speed = float(np.sqrt(omega @ omega))
        if speed > 0.0:
            self.system.check_span(until, self._front.clock[layout.TURN_LIMIT] / speed)


# ---- States of a torqued motion whose error stays within a tolerance over a span

# The error of a step allowed at first, as a share of the tolerance.
_FIRST_SHARE = 0.1
# The least error of a step, which is rounding.
_LEAST = 1e-17
# Share of the tolerance aimed at.
_AIM = 0.4
# The largest change of the error of a step at once.
_LARGEST_CHANGE = 1e-3
# Where errors grow faster than time, the next attempt aims at a smaller share.
_AIM_AGAIN = 0.5
# Spans that later epochs exceed are replanned for this many times the distance.
_AHEAD = 2.0


class BoundedSteps:
    """Varying steps, all shortened together until the estimate of the error is within a tolerance.

    `horizon`: s, for which the steps are planned at first; 0: that of the first epochs asked.
    """

    def __init__(self, system: System, sign: float, tolerance: float, horizon: float) -> None:
        self.system, self.sign, self.tolerance = system, sign, tolerance
        self._horizon = horizon
        self._steps = VaryingSteps(system, sign, _FIRST_SHARE * tolerance, paired=True)

    @property
    def reached(self) -> float:
        """Seconds since the epoch to which states have been integrated."""
        return self._steps.reached

    @property
    def steps(self) -> int:
        """Number of steps taken."""
        return self._steps.steps

    def estimate(self) -> float:
        """Estimate of the largest error of the attitudes that were asked, or planned for, rad."""
        if self._horizon > 0.0:
            self._reach(self._horizon)
        return self._steps.error

    def mesh(self, until: float) -> StepMesh:
        """The steps that reach `until`, s."""
        self._reach(max(abs(until), self._horizon))
        return self._steps.mesh(until)

    def states(self, seconds: FloatArray, low: FloatArray) -> FloatArray:
        """(T, 7) at seconds + low of this direction."""
        self._reach(max(float(np.max(np.abs(seconds + low))), self._horizon))
        return self._steps.states(seconds, low)

    def _reach(self, distance: float) -> None:
        """Integrate to a distance from the epoch, s, with steps short enough for it."""
        # A motion that was planned for less is planned for more than is needed, so that epochs one
        # by one do not have it planned anew for each.
        ahead = _AHEAD if self._steps.steps else 1.0
        aim = _AIM
        while True:
            self._steps.extend(self.sign * distance, self.tolerance)
            if self._steps.error <= self.tolerance:
                return
            share = abs(self._steps.reached) / max(ahead * distance, abs(self._steps.reached))
            share *= aim * self.tolerance / self._steps.error
            aim *= _AIM_AGAIN
            # The error over a span follows the power p of the step, that of a step the power p + 1.
            change = share ** (1.0 + 1.0 / self.system.scheme.order)
            allowed = self._steps.tolerance * max(change, _LARGEST_CHANGE)
            if self._steps.tolerance <= _LEAST:
                raise AttitudeError(
                    f"the estimate of the error exceeds the tolerance of {self.tolerance:g} rad "
                    f"{self._steps.reached:.9g} s after the epoch, even with the shortest steps "
                    "that rounding allows. Give a larger tolerance, a shorter span, or a fixed "
                    "step."
                )
            allowed = max(allowed, _LEAST)
            self._steps = VaryingSteps(self.system, self.sign, allowed, paired=True)


# ---- The motion

# Epochs in a block.
_EPOCHS_AT_ONCE = 1 << 17
# rad
_TOLERANCE = 1e-9


@dataclass(frozen=True, eq=False, repr=False, init=False)
class TorquedRotation(Differentiable):
    """Rotation of a rigid body under torques, by a splitting scheme around exact free motion.

    Parameters
    ----------
    body : Body
        All of whose moments are greater than zero.
    spin : Spin
        The state at its epoch; the motion reaches from it in both directions.
    torques : Torque, function, or sequence of them
        See `attitude.torques`.  A function is taken as a `CustomTorque`.
    step : float, optional
        s, or a Quantity: fixed.
    scheme : str or Scheme, optional
        "kick-rotate-kick", "rotate-kick-rotate" and "hoa" of second order, "suzuki",
        "blanes-moan" and "force-gradient" of fourth order; see `attitude.splitting.SCHEMES`.  By
        default "blanes-moan" with `tolerance`, otherwise "kick-rotate-kick".
    tolerance : float, optional
        Instead of `step`: largest error of an attitude, rad, from 1e-14 to 1e-2; 1e-9 if neither
        `step` nor `step_tolerance` is given.  The steps vary with the motion: right for one
        encounter, not symplectic over many.
    step_tolerance : float, optional
        Instead of these: largest error of a step, in rad of attitude and as relative change of the
        angular velocity, from 1e-14 to 1e-2.  Errors of steps add up, and may grow.
    span : pair of epochs, optional
        With `tolerance`: first and last epoch, as ``at`` takes them, for which the steps are
        planned; by default the first epochs asked.  See Notes for others.
    origin : epoch, optional
        From which the seconds count that functions (torques, paths, fields) are called with; by
        default the epoch of the spin.

    Attributes
    ----------
    torques : tuple of Torque
    scheme : Scheme
    step, tolerance, step_tolerance : float or None
        s, rad, rad; two of them are None.
    origin : Instant or None

    Raises
    ------
    AttitudeError
        For a step that cannot resolve the rotation, a torque that is not finite or of another
        shape, epochs that a path does not cover.

    Notes
    -----
    Between steps, the motion is that of a shorter last step: the order of the scheme holds at
    every epoch, and the motion is continuous.  States are integrated on demand, and every 32nd is
    kept, every 64th once there are 131,072 and so on: later calls, in any order of epochs, start
    from the nearest, and 1e8 steps need no more memory (15 MB) than 4e6.  Paths are evaluated at
    epochs of two doubles.  Free motion errs by rounding times the angle turned,
    summed with compensation and without a mean: the energy walks at random by 2e-14 in 1e8 steps of
    0.08 rad.

    With `tolerance`, the difference from a motion with steps twice as long, from the epoch on, is
    the estimate of the error (`error_estimate`), which is 2 to 15 times smaller; all steps are
    shortened together until the estimate is within the tolerance.  An epoch beyond the span has the
    steps planned anew if the estimate exceeds the tolerance there; the last digits of earlier
    epochs then change within the tolerance.  A torque that acts for less than a step may be missed:
    give a fixed step that resolves it.

    Derivatives (`sensitivity_at`, and with them covariances) are those of the scheme with its
    steps: of free motions in closed form, of torques by differences of fourth order, 1e-12 of the
    torque where it is smooth.  They take some 40 times as long as the motion.

    "force-gradient" takes any number of `GravityGradient`, `ConstantTorque`, and `CustomTorque`
    with a slope; other torques are refused by name.

    Source: van Zon & Schofield, Phys. Rev. E 75, 056701 (2007), cond-mat/0612404; van Zon,
    Omelyan & Schofield, J. Chem. Phys. 128, 136102 (2008).
    """

    body: Body
    spin: Spin
    torques: tuple[Torque, ...]
    step: float | None
    scheme: Scheme
    tolerance: float | None
    step_tolerance: float | None
    origin: Instant | None

    _value = (
        "body",
        "spin",
        "torques",
        "scheme",
        "step",
        "tolerance",
        "step_tolerance",
        "_span_given",
        "origin",
    )

    @arguments({"torque": "give torques="}, "TorquedRotation(body, spin, torques, step=1.0)")
    def __init__(
        self,
        body: Body,
        spin: Spin,
        torques: AnyTorques,
        step: Real | None = None,
        scheme: str | Scheme | None = None,
        tolerance: Real | None = None,
        *,
        step_tolerance: Real | None = None,
        span: tuple[Epoch | float, Epoch | float] | None = None,
        origin: Epoch | None = None,
    ) -> None:
        self._system: System
        self._grids: tuple[_Steps, _Steps]
        self._lock: threading.Lock
        self._horizons: tuple[float, float]
        self._span_given: Any
        refuse_others(body, spin, "TorquedRotation takes a Body, a Spin and torques")
        self._set_all(body=body, spin=spin, torques=_torques(torques))
        if sum(one is not None for one in (step, tolerance, step_tolerance)) > 1:
            raise AttitudeError(
                "a TorquedRotation takes one of step=(s), tolerance=(rad) and step_tolerance=(rad)."
            )
        if step is None and step_tolerance is None and tolerance is None:
            tolerance = _TOLERANCE
        if scheme is None:
            scheme = "kick-rotate-kick" if tolerance is None else "blanes-moan"
        self._set("scheme", _schemes.scheme(scheme))
        start = None if origin is None else _inputs.instant(origin, "origin")
        self._set("origin", start)
        self._set("_system", System(self.body, self.spin, self.torques, self.scheme, start))
        if step is not None:
            step = validation.positive(step, "step", unit="s")
            self._system.check_step(step)
        self._set("step", step)
        for name, bound in (("tolerance", tolerance), ("step_tolerance", step_tolerance)):
            self._set(name, None if bound is None else _checked_tolerance(bound, name))
        self._set_all(_span_given=span, _horizons=self._planned(span))
        self._forget()
        _living[id(self)] = self

    def _forget(self) -> None:
        """Start without integrated states, and with a lock that no thread holds."""
        self._set_all(_lock=threading.Lock(), _grids=(self._grid(0), self._grid(1)))

    def _planned(self, span: Any) -> tuple[float, float]:
        """Seconds after and before the epoch for which steps are planned."""
        if span is None:
            return 0.0, 0.0
        if self.tolerance is None:
            raise AttitudeError(
                "span is for tolerance=, the error over a span; leave it out with step= and "
                "step_tolerance=."
            )
        ends = _inputs.seconds_since(self.epoch, span, name="span").rounded
        if ends.shape != (2,) or not np.all(np.isfinite(ends)) or ends[0] > ends[1]:
            raise AttitudeError(f"span is {span!r}; give two epochs, the earlier one first.")
        return max(float(ends[1]), 0.0), max(-float(ends[0]), 0.0)

    def _grid(self, side: int) -> _Steps:
        """The states after the epoch (0) or before it (1)."""
        sign = -1.0 if side else 1.0
        if self.step is not None:
            return FixedSteps(self._system, sign * self.step)
        if self.step_tolerance is not None:
            return VaryingSteps(self._system, sign, self.step_tolerance)
        assert self.tolerance is not None
        return BoundedSteps(self._system, sign, self.tolerance, self._horizons[side])

    def __reduce__(self):
        names = "step", "scheme", "tolerance", "step_tolerance", "origin"
        stepping = {name: getattr(self, name) for name in names} | {"span": self._span_given}
        return partial(TorquedRotation, **stepping), (self.body, self.spin, self.torques)

    @cached_property
    def _sensitivity(self) -> TorquedSensitivity:
        return self.sensitivity_with_torques(())

    def sensitivity_with_torques(
        self, others: Iterable[tuple[float, Iterable[Iterable[Torque]]]]
    ) -> TorquedSensitivity:
        """The derivatives by the state, the moments and parameters of the torques.

        For fits of torques; the contract of motions is `sensitivity_at`, without parameters.

        Parameters
        ----------
        others : iterable of (float, 4 tuples of Torque)
            For each parameter a step, and the torques with it changed by the step times +1, -1,
            +2, -2 (`_system.NODES`).

        Returns
        -------
        TorquedSensitivity
            Whose ``at(seconds, low, rates)`` has a column for each parameter after the nine.
        """
        parameters = [
            (size, [self._system.under(tuple(group)) for group in torques])
            for size, torques in others
        ]
        return TorquedSensitivity(
            self._system, self.body, self.spin, self._mesh, self._states, parameters
        )

    def _mesh(self, side: int, until: float) -> StepMesh:
        """The steps after the epoch (0) or before it (1) that reach `until`, s."""
        with self._lock:
            return self._grids[side].mesh(until)

    def _with(self, body: Body, spin: Spin) -> Self:
        rebuild, (_, _, torques) = self.__reduce__()
        return rebuild(body, spin, torques)

    def __repr__(self) -> str:
        if self.step is not None:
            stepping = f"step {self.step:g} s"
        elif self.step_tolerance is not None:
            stepping = f"to {self.step_tolerance:g} rad a step"
        else:
            stepping = f"to {self.tolerance:g} rad"
        names = ", ".join(type(torque).__name__ for torque in self.torques)
        return f"<TorquedRotation: {names}; {self.scheme.name}, {stepping}>"

    @property
    def epoch(self) -> Instant:
        """Instant from which its seconds count: that of the spin."""
        return self.spin.epoch

    @property
    def smooth(self) -> bool:
        """Whether angular accelerations are known: not under an `InertiaHistory`."""
        return self._system.inertia is None

    @property
    def steps_taken(self) -> tuple[float, float]:
        """(first, last) seconds since the epoch between which states have been integrated."""
        ahead, behind = (grid.reached for grid in self._grids)
        return behind, ahead

    @property
    def error_estimate(self) -> float:
        """Estimate of the largest error of an attitude, rad, at the epochs asked so far.

        With `tolerance` and `span`, in the span.  With `step` and `step_tolerance`, each access
        integrates the motion again with other steps.  Rounding and the truncation of the steps are
        estimated; errors of the body, the state and the torques are not.
        """
        with self._lock:
            return max(grid.estimate() for grid in self._grids)

    def constant_body(self, what: str) -> Body:
        """The Body of the motion, for what the message names; see `Motion.constant_body`.

        Raises
        ------
        AttitudeError
            With an `InertiaHistory`.
        """
        if self._system.inertia is not None:
            raise AttitudeError(
                f"{what} follows from a body's inertia, which an InertiaHistory changes; give a "
                "motion with one body."
            )
        return self.body

    def body_at(self, t: EpochOrSeconds) -> Body:
        """The Body at one epoch, of any kind that `at` takes."""
        if self._system.inertia is None:
            return self.body
        hi, lo = _inputs.one_since(self.spin.epoch, t)
        change = self._system.inertia.tensors(np.array([hi + lo]))[0]
        settings = {name: getattr(self.body, name) for name in ("relative", "center_of_mass")}
        return Body(tensor=self.body.tensor + change, **settings)

    def momentum_in_body(self, history: AttitudeHistory) -> FloatArray:
        """Angular momentum (S, 3), kg m2/s over the body axes, with the tensor of each epoch."""
        tensors = self.body.tensor
        if self._system.inertia is not None:
            seconds = pairs.Seconds.of(history).rounded.reshape(-1)
            change = self._system.inertia.tensors(seconds)
            tensors = tensors + change.reshape(*np.shape(history.seconds), 3, 3)
        return np.sum(tensors * history.angular_velocity[..., None, :], axis=-1)

    def turning_rate_at(
        self,
        seconds: ArrayLike,
        low: ArrayLike | None = None,
        *,
        wxyz: FloatArray,
        angular_velocity: FloatArray,
    ) -> FloatArray:
        """As `Motion.turning_rate_at`."""
        times = pairs.Seconds(*_inputs.plain_seconds(seconds, low)).flat
        states = np.concatenate([wxyz, angular_velocity], axis=-1).reshape(-1, 7)
        rates = self._system.turning_rates(*times, states)
        return rates.reshape(np.shape(angular_velocity))

    def _evaluate(self, seconds, low, order):
        # Attitudes and angular velocities are integrated together, in blocks of epochs: Ctrl-C is
        # heard between them, and the memory beside the result is bounded.
        flat, low_parts = pairs.Seconds(seconds, low).flat
        arrays = [np.empty((flat.size, width)) for width in (4, 3, 3)[: max(order, 1) + 1]]
        for begin in range(0, flat.size, _EPOCHS_AT_ONCE):
            block = slice(begin, begin + _EPOCHS_AT_ONCE)
            states = self._states(flat[block], low_parts[block])
            arrays[0][block] = states[:, :4]
            arrays[1][block] = self._system.turning(flat[block], low_parts[block], states[:, 4:])
            if order > 1:
                arrays[2][block] = self._system.acceleration(flat[block], low_parts[block], states)
        return [array.reshape(*seconds.shape, array.shape[-1]) for array in arrays]

    def _states(self, seconds: FloatArray, low: FloatArray) -> FloatArray:
        """(N, 7): wxyz body to ICRF, angular velocity over body axes, at seconds + low (N,)."""
        out = np.full((seconds.size, 7), np.nan)
        with np.errstate(invalid="ignore", over="ignore"):  # infinities are refused below
            total = seconds + low
        if np.any(np.isinf(total)):
            raise AttitudeError(
                "an epoch is infinite; give finite epochs, or NaN for a missing one."
            )
        with self._lock:
            for grid, on_side in zip(self._grids, (total >= 0.0, total < 0.0), strict=True):
                if np.any(on_side):
                    out[on_side] = grid.states(seconds[on_side], low[on_side])
        return self._system.over_body_axes(out)


# All motions of the process by their identity: equal motions have locks of their own.
_living: weakref.WeakValueDictionary[int, TorquedRotation] = weakref.WeakValueDictionary()


def _after_fork() -> None:
    """In a forked process, free the locks of threads that do not live there, and their states."""
    for motion in list(_living.values()):
        if motion._lock.locked():
            motion._forget()


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_after_fork)


def _checked_tolerance(value: Real, name: str) -> float:
    tolerance = validation.positive(value, name)
    if not 1e-14 <= tolerance <= 1e-2:
        raise AttitudeError(f"{name} is {tolerance!r}; give one from 1e-14 to 1e-2 (rad).")
    return tolerance


def _torques(torques: Any) -> tuple[Torque, ...]:
    validation.refuse_class(torques, "torques")
    if isinstance(torques, Torque) or callable(torques):
        torques = (torques,)
    if not isinstance(torques, Iterable):
        raise AttitudeError(
            f"torques is {validation.shown(torques)}; give an object of attitude.torques, a "
            "function of (t, wxyz, omega), or a list of them."
        )
    torques_of = []
    for k, torque in enumerate(torques):
        if not isinstance(torque, Torque):
            validation.refuse_class(torque, f"torques[{k}]")
            if not callable(torque):
                raise AttitudeError(
                    f"torques holds {torque!r}; give objects of attitude.torques, or functions of "
                    "(t, wxyz, omega)."
                )
            torque = CustomTorque(torque)
        torques_of.append(torque)
    if not torques_of:
        raise AttitudeError("torques is empty; give a torque, or use FreeRotation.")
    return tuple(torques_of)
