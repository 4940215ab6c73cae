"""States of a torqued motion after fixed steps, integrated on demand and kept."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from attitude import pairs
from attitude.solution.march_layout import STATE_ENTRIES
from attitude.splitting.pace import Pace
from attitude.splitting.step_mesh import StepMesh

if TYPE_CHECKING:
    from attitude.annotations import FloatArray, IntArray
    from attitude.splitting.system import System

# Fixed steps: the state after every 32nd step is kept.  At 131,072 states (15 MB) every second one
# is discarded and the interval doubles, so that memory is bounded, and an epoch costs at most a
# few hundred steps for each hundred million taken.
_EVERY, _MOST = 32, 1 << 17
# Epochs at which motions of two steps are compared; rad, the rounding of an answer.
_COMPARED, _ROUNDING = 4096, 2e-15
# Steps integrated, and kicks sampled, in one call of the compiled loops: at most.
_STEPS, _ROWS = 2048, 1 << 18


class FixedSteps:
    """States after every so many steps in one direction of time.

    Parameters
    ----------
    system : System
    h : float
        s, negative before the epoch.

    Attributes
    ----------
    count : int
        Of kept states, that of the epoch included.
    every : int
        Steps between kept states.
    farthest : float
        s, the largest distance from the epoch of which a state was asked.
    """

    def __init__(self, system: System, h: float) -> None:
        self.system, self.h, self.every = system, h, _EVERY
        self.kept = system.start[None].copy()  # grows by doubling
        self.count, self.farthest = 1, 0.0
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
            here = order[begin:end]
            with self._rows_at_once.measured():
                # one call takes as many as it can, but for the last
                few = min(rows - 1, (end - begin) * self.system.kicks)
                self._rows_at_once.items = rows if end < len(order) else few
                out[here] = self._revisited(segment[begin:end], number[here], parts[here])
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

        By the difference from a motion with steps half as long: its error is less than half, so
        twice the difference is a bound.
        """
        if self.farthest == 0.0:
            return 0.0
        finer = FixedSteps(self.system, 0.5 * self.h)
        # not at the same place in each step
        shares = (np.arange(_COMPARED) + 0.5 * np.sqrt(5.0)) / _COMPARED
        t = np.copysign(self.farthest, self.h) * np.append(shares[shares < 1.0], 1.0)
        one, two = (grid.states(t, np.zeros(len(t)))[:, :4] for grid in (self, finer))
        return 4.0 * float(np.max(np.sqrt(np.sum((one - two) ** 2, axis=1)))) + _ROUNDING

    def _revisited(self, segment: IntArray, number: IntArray, parts: FloatArray) -> FloatArray:
        used, place = np.unique(segment, return_inverse=True)
        numbers = (used * self.every).astype(np.float64)
        steps = number - segment * self.every
        return self.system.revisit(self.kept[used], numbers, self.h, place, steps, parts)

    def _extend(self, number: int) -> None:
        """Keep states up to a number of steps."""
        while (self.count - 1) < number // self.every:
            if self.count > _MOST:
                self.kept[: self.count // 2 + 1] = self.kept[: self.count : 2]
                self.count, self.every = self.count // 2 + 1, 2 * self.every
                continue
            run = min(
                max(1, self._steps_at_once.size // self.every),
                number // self.every - (self.count - 1),
                _MOST + 1 - self.count,
            )
            made = self._following(run)
            if self.count + run > len(self.kept):
                larger = np.empty((max(2 * len(self.kept), self.count + run), STATE_ENTRIES))
                larger[: self.count] = self.kept[: self.count]
                self.kept = larger
            self.kept[self.count : self.count + run] = made
            self.count += run

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
