"""States of a torqued motion after steps as long as an error estimate allows."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from attitude.solution import march_layout as layout
from attitude.solution.adaptive import estimated
from attitude.solution.march_layout import KEPT_ENTRIES, OMEGA, STATE_ENTRIES
from attitude.splitting.front import Front, between
from attitude.splitting.pace import Pace
from attitude.splitting.step_mesh import StepMesh

if TYPE_CHECKING:
    from attitude.annotations import FloatArray, IntArray
    from attitude.splitting.system import System

# The state after every 32nd step is kept; at 131,072 states (17 MB) every second one is discarded
# and the interval doubles.
_EVERY, _MOST = 32, 1 << 17
# Epochs evaluated in one call of the compiled loops, and states between which they lie: at most.
_EPOCHS, _STATES = 1 << 15, 1 << 14
# States kept in one call: at most.
_ROWS = 1 << 10
# rad, of an answer.
_ROUNDING = 2e-15


class VaryingSteps:
    """States after varying steps in one direction of time.

    Parameters
    ----------
    system : System
    sign : float
        1 after the epoch, -1 before it.
    tolerance : float
        rad, and relative change of the angular velocity, of one step.
    paired : bool
        Whether the error is estimated by a motion with steps twice as long.

    Attributes
    ----------
    farthest : float
        s, the largest distance from the epoch of which a state was asked.
    """

    def __init__(self, system: System, sign: float, tolerance: float, paired: bool = False) -> None:
        self.system, self.sign, self.tolerance = system, sign, tolerance
        spans = [torque.span(system.epoch) for torque in system.torques]
        last = min(last if sign > 0.0 else -first for first, last in spans)
        self._front = Front(system, sign, tolerance, paired, last)
        self.kept, self.count, self.every = self._front.row[None].copy(), 1, _EVERY
        self.farthest, self._least = 0.0, tolerance + _ROUNDING
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

        The difference of the motions with whole and with halved steps, which is 2^p - 1 times the
        error of the latter for short steps.  It is not divided: long steps err by lower powers (4
        in place of 16, where the body turns by 2 rad a step).  At kinks and jumps of the torque
        the difference may vanish by chance, so errors of such steps are added.
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
            here = order[begin:end]
            with self._epochs_at_once.measured():
                self._epochs_at_once.items = end - begin
                rows = self._steps_of(segment[begin:end], total[begin:end])
                times = np.ascontiguousarray(rows[:, layout.KEPT_TIME])
                place = np.searchsorted(np.abs(times), total[begin:end], side="right") - 1
                parts = (seconds[here] - times[place]) + low[here]
                state = rows[:, layout.KEPT_STATE]
                out[here] = between(self.system, state, times, place, parts)
            begin = end
        return out

    def _steps_of(self, segment: IntArray, total: FloatArray) -> FloatArray:
        """Rows after each step of some segments, to the last epoch in each; both ascending."""
        found = []
        last = np.flatnonzero(np.append(np.diff(segment) != 0, True))
        for k, until in zip(segment[last], total[last], strict=True):
            found.append(self.kept[k][None])
            # From a kept state the same steps follow, however they are divided into calls.
            front, most = self._front.from_row(self.kept[k]), self.every
            end = min(until, abs(self.reached) if k + 1 == self.count else abs(self.kept[k + 1, 0]))
            while abs(front.time) < end and most > 0:
                rows = np.empty((most, KEPT_ENTRIES))
                filled = front.advance(self.sign * end, rows, 1)
                found.append(rows[:filled])
                most -= filled
        rows = np.concatenate(found)
        # The end of a segment is the start of the next.
        return rows[np.append(np.diff(np.abs(rows[:, 0])) > 0.0, True)]

    def extend(self, until: float, limit: float = np.inf) -> None:
        """Integrate to seconds `until`, or till the estimate of the error exceeds a limit."""
        self.farthest = max(self.farthest, abs(until))
        self._check_span(until)
        while abs(self.reached) < abs(until) and self.error <= limit:
            if self.count > _MOST:
                self.kept[: self.count // 2 + 1] = self.kept[: self.count : 2]
                self.count, self.every = self.count // 2 + 1, 2 * self.every
            rows = np.empty((min(_MOST + 1 - self.count, _ROWS), KEPT_ENTRIES))
            # Should it be interrupted, the copy is given up.
            front = self._front.copy()
            front.clock[layout.LIMIT] = limit - self._least
            filled = front.advance(until, rows, self.every)
            if self.count + filled > len(self.kept):
                larger = np.empty((max(2 * len(self.kept), self.count + filled), KEPT_ENTRIES))
                larger[: self.count] = self.kept[: self.count]
                self.kept = larger
            self.kept[self.count : self.count + filled] = rows[:filled]
            self.count, self._front = self.count + filled, front

    def _check_span(self, until: float) -> None:
        omega = self._front.fine[OMEGA]
        speed = float(np.sqrt(omega @ omega))
        if speed > 0.0:
            self.system.check_span(until, self._front.clock[layout.TURN_LIMIT] / speed)
