"""States of a torqued motion after fixed or varying steps, integrated on demand and kept."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from attitude import pairs
from attitude.errors import AttitudeError
from attitude.solution.march_layout import OMEGA, OMEGA_LOW, STATE_ENTRIES, WXYZ, WXYZ_LOW
from attitude.splitting.pace import Pace
from attitude.splitting.system import LARGEST_TURN

if TYPE_CHECKING:
    from attitude.annotations import FloatArray, IntArray
    from attitude.splitting.system import System

# Fixed steps: the state after every 32nd step is kept.  At 131,072 states (15 MB) every second one
# is discarded and the interval doubles, so that memory is bounded, and an epoch costs at most a
# few hundred steps for each hundred million taken.
_EVERY, _MOST = 32, 1 << 17
# Steps integrated, and kicks sampled, in one call of the compiled loops: at most.
_STEPS, _ROWS = 2048, 1 << 18
# Adaptive steps: fraction of the step that the error estimate allows, and how it may change.
_SAFETY, _SHRINK, _GROW = 0.9, 0.2, 4.0
_MOST_REFUSALS = 60


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
    """

    def __init__(self, system: System, h: float) -> None:
        self.system, self.h, self.every = system, h, _EVERY
        self.kept = system.start[None].copy()  # grows by doubling
        self.count = 1
        self._steps_at_once, self._rows_at_once = Pace(_STEPS), Pace(_ROWS)

    @property
    def reached(self) -> float:
        """Seconds since the epoch of the last kept state."""
        return (self.count - 1) * self.every * self.h

    def states(self, seconds: FloatArray, low: FloatArray) -> FloatArray:
        """(T, 7) at seconds + low of this direction."""
        self.system.check_span(np.max(np.abs(seconds + low)), self.h)
        number, parts = self._steps(seconds, low)
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
            with self._rows_at_once.measured(end < len(order)):
                out[here] = self._revisited(segment[begin:end], number[here], parts[here])
            begin = end
        return out

    def _steps(self, seconds: FloatArray, low: FloatArray) -> tuple[IntArray, FloatArray]:
        """How many whole steps lead to epochs, and seconds of a last one."""
        number = np.floor((seconds + low) / self.h)
        hi, lo = pairs.product(number, self.h)
        parts = (seconds - hi) + (low - lo)
        # a quotient that was rounded up to the next whole number
        early = parts * np.sign(self.h) < 0.0
        number[early] -= 1.0
        parts[early] += self.h
        return np.maximum(number, 0.0).astype(np.int64), parts

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
            with pace.measured(steps >= pace.size):
                return self.system.march(state, first, self.h, steps, self.every)
        taken = 0
        while taken < self.every:
            steps = min(self.every - taken, pace.size)
            with pace.measured(steps == pace.size):
                self.system.march(state, first + taken, self.h, steps, self.every)
            taken += steps
        return state[None]


class VaryingSteps:
    """States after every step, each as long as the error estimate allows.

    Parameters
    ----------
    system : System
    sign : float
        1 after the epoch, -1 before it.
    tolerance : float
        rad, and relative change of the angular velocity, of one step.
    """

    def __init__(self, system: System, sign: float, tolerance: float) -> None:
        self.system, self.sign, self.tolerance = system, sign, tolerance
        self.times, self.kept = [0.0], [system.start.copy()]
        self.h: float | None = None
        # A step that ends beyond the last epoch given must not leave a path that ends there.
        spans = [torque.span(system.epoch) for torque in system.torques]
        self.last = min(last if sign > 0.0 else -first for first, last in spans)

    @property
    def reached(self) -> float:
        """Seconds since the epoch of the last kept state."""
        return self.times[-1]

    def states(self, seconds: FloatArray, low: FloatArray) -> FloatArray:
        """(T, 7) at seconds + low of this direction."""
        order = np.argsort(np.abs(seconds + low), kind="stable")
        seconds, low = seconds[order], low[order]
        self._extend(float(seconds[-1] + low[-1]))
        times = np.array(self.times)
        place = np.searchsorted(np.abs(times), np.abs(seconds + low), side="right") - 1
        parts = (seconds - times[place]) + low
        used, place = np.unique(place, return_inverse=True)
        kept = np.array([self.kept[k] for k in used])
        steps = np.zeros(len(place), dtype=np.int64)
        out = np.empty((len(seconds), 7))
        out[order] = self.system.revisit(kept, times[used], 1.0, place, steps, parts)
        return out

    def _extend(self, last: float) -> None:
        self.system.check_span(last, self._longest(self.kept[-1]))
        while abs(self.times[-1]) < abs(last):
            self._step(last)

    def _step(self, last: float) -> None:
        """One step; its error is estimated by the two half steps, whose state is kept."""
        system, t, state = self.system, self.times[-1], self.kept[-1]
        order = system.scheme.order
        h = self.h if self.h is not None else self._first()
        for _ in range(_MOST_REFUSALS):
            # Epochs beyond the end of a path are refused by the path itself.
            available = max(self.last, abs(last)) - abs(t)
            h = self.sign * min(abs(h), self._longest(state), available)
            end = t + h
            h = end - t
            whole, half = state.copy(), state.copy()
            system.march(whole, (t, 0.0), h, 1, 1)
            system.march(half, (t, 0.0), 0.5 * h, 2, 2)
            error = _difference(whole, half) / (2.0**order - 1.0)
            ratio = (self.tolerance / max(error, 1e-300)) ** (1.0 / (order + 1.0))
            factor = min(max(_SAFETY * ratio, _SHRINK), _GROW)
            if error <= self.tolerance or h == 0.0:
                self.times.append(end)
                self.kept.append(half)
                self.h = h * factor
                return
            h *= factor
        raise AttitudeError(
            f"no step {t:.9g} s after the epoch is short enough for a tolerance of "
            f"{self.tolerance:g}; the torque is not smooth there, or the tolerance is below "
            "rounding. Give a larger tolerance, or a fixed step."
        )

    def _longest(self, state: FloatArray) -> float:
        rate = np.sqrt(state[OMEGA] @ state[OMEGA])
        longest = np.max(np.abs(self.system.scheme.flights))
        return np.inf if rate == 0.0 else 0.5 * LARGEST_TURN / (rate * longest)

    def _first(self) -> float:
        longest = self._longest(self.kept[-1])
        return 0.1 * longest if np.isfinite(longest) else 1.0


def _difference(one: FloatArray, two: FloatArray) -> float:
    """How far two states are apart: rad, and the relative change of the angular velocity."""
    turned = 2.0 * np.max(np.abs((one[WXYZ] - two[WXYZ]) + (one[WXYZ_LOW] - two[WXYZ_LOW])))
    rate = np.max(np.abs(two[OMEGA]))
    change = np.max(np.abs((one[OMEGA] - two[OMEGA]) + (one[OMEGA_LOW] - two[OMEGA_LOW])))
    return max(turned, change / rate if rate > 0.0 else 0.0)
