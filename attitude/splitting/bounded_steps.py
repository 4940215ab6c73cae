"""States of a torqued motion whose error stays within a tolerance over a span."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from attitude.errors import AttitudeError
from attitude.splitting.varying_steps import VaryingSteps

if TYPE_CHECKING:
    from attitude.annotations import FloatArray
    from attitude.splitting.step_mesh import StepMesh
    from attitude.splitting.system import System

# The error of a step allowed at first, as a share of the tolerance; the least, which is rounding.
_FIRST_SHARE, _LEAST = 0.1, 1e-17
# Share of the tolerance aimed at, and the largest change of the error of a step at once.
_AIM, _LARGEST_CHANGE = 0.4, 1e-3
# Where errors grow faster than time, the next attempt aims at a smaller share.
_AIM_AGAIN = 0.5
# Spans that later epochs exceed are replanned for this many times the distance.
_AHEAD = 2.0


class BoundedSteps:
    """Varying steps, all shortened together until the estimate of the error is within a tolerance.

    Parameters
    ----------
    system : System
    sign : float
        1 after the epoch, -1 before it.
    tolerance : float
        rad, of the attitudes from the epoch to any that was asked.
    horizon : float
        s, the distance from the epoch for which the steps are planned at first; 0: that of the
        first epochs asked.
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
            change = share ** (1.0 + 1.0 / self.system.order)
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
