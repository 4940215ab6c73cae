"""The advance of an integration with adaptive steps, and of states between its steps."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from attitude import pairs
from attitude.errors import AttitudeError
from attitude.solution import march_layout as layout
from attitude.solution.march_layout import OMEGA, STATE_ENTRIES
from attitude.splitting.pace import Pace
from attitude.splitting.system import LARGEST_TURN

if TYPE_CHECKING:
    from attitude.annotations import FloatArray, IntArray
    from attitude.splitting.system import System

# Steps of one length whose samples are computed together, and steps tried in one call: at most.
_WAVE, _STEPS = 512, 1 << 14
# s: the first step of a body at rest; it grows or shrinks by factors of 4.
_STEP_AT_REST = 1.0
# Longest pieces of free motions: truncation in the first is below the rounding of the attitude and
# below 3e-17 of the rate.  In the second it is below 1e-13 rad, of which a fifth is in the estimate
# of the error: for whole steps, which only show the error, from these tolerances on.  Errors of a
# motion with whole steps beside add up.
_PIECE, _LONGER_PIECE = 0.125, 0.24
_COARSE, _COARSE_BESIDE = 1e-12, 1e-10
# The steps of a window show the progress; more than so many to the last epoch take hours.
_WINDOW, _MOST_AHEAD = 64, 1e10


class Front:
    """Where an integration has arrived, and all on which its next steps depend.

    Parameters
    ----------
    system : System
    sign : float
        1 after the epoch, -1 before it.
    tolerance : float
        Of the error of a step.
    paired : bool
        Whether a motion with whole steps goes along; see `solution.adaptive`.
    last : float
        s, the absolute value of the seconds beyond which no torque is known.
    """

    def __init__(
        self, system: System, sign: float, tolerance: float, paired: bool, last: float
    ) -> None:
        self.system, self.last = system, last
        self.clock, self.counts = (
            np.zeros(layout.CLOCK_ENTRIES),
            np.zeros(layout.COUNTERS, np.int64),
        )
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
        self._wave, self._pace = 16, Pace(_STEPS)
        self._mark = 0, 0.0

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
        other = Front.__new__(Front)
        other.system, other.last, other._pace = self.system, self.last, self._pace
        other._wave, other.coarse = self._wave, np.empty(0)
        other._mark = 0, float(row[layout.KEPT_TIME])
        other.clock, other.counts = self.clock.copy(), np.zeros(layout.COUNTERS, np.int64)
        other.clock[layout.TIME] = row[layout.KEPT_TIME]
        other.clock[layout.LENGTH] = row[layout.KEPT_LENGTH]
        other.fine = row[layout.KEPT_STATE].copy()
        return other

    def copy(self) -> Front:
        """A copy that may advance, and be discarded if the advance fails."""
        other = self.from_row(self.row)
        other.clock, other.counts = self.clock.copy(), self.counts.copy()
        other.coarse, other._mark = self.coarse.copy(), self._mark
        return other

    def advance(self, until: float, kept: FloatArray, every: int) -> int:
        """Take the steps of one call, to seconds `until` at most but for the last step.

        Fills rows of `kept` after each `every` steps since the epoch; returns how many.
        """
        from attitude.solution.adaptive import adapt

        self.clock[layout.UNTIL] = until
        # Beyond the end of a path the path itself refuses.
        self.clock[layout.LAST] = max(self.last, abs(until))
        most = self._pace.size
        given = self._samples(min(most, self._wave))
        before, system = self.counts[layout.TAKEN], self.system
        with self._pace.measured():
            system.run(
                *(adapt, self.clock[layout.LENGTH], *system.setup, self.clock, self.counts),
                *(self.fine, self.coarse, system.order, most, given, kept, every),
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
        if abs(self.time - begin) / steps * _MOST_AHEAD < abs(until) - abs(self.time):
            raise AttitudeError(
                f"{self.time:.9g} s after the epoch the steps are so short that more than "
                f"{_MOST_AHEAD:.0e} would lead to the last epoch; the torque is not smooth there, "
                "or the tolerance is too small. Give a larger tolerance, or a fixed step."
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


def between(
    system: System, states: FloatArray, times: FloatArray, place: IntArray, parts: FloatArray
) -> FloatArray:
    """States (T, 7) at `parts` seconds after some of the states (S, 14) at `times` (S,)."""
    from attitude.solution.adaptive import between as compiled

    half, begin = 0.5 * parts, times[place]
    starts = np.stack([begin, np.zeros(len(begin))])
    one = system.kick_times(starts, half)
    two = system.kick_times(np.array(pairs.add((starts[0], starts[1]), half)), half)
    within = system.sampled(np.concatenate([one[..., :-1], two], axis=-1))
    out = np.empty((len(place), STATE_ENTRIES // 2))
    states = np.ascontiguousarray(states)
    system.run(compiled, 0.0, *system.setup, states, times, place, parts, within, out)
    return out
