"""Observables: numbers at every epoch, with extrema, and conditions by comparison."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from attitude import validation
from attitude.conditions.channel import Level
from attitude.conditions.condition import Condition, Joinable
from attitude.conditions.logic import Not, Sign
from attitude.conditions.moments import lengths, values_at
from attitude.errors import AttitudeError

if TYPE_CHECKING:
    from collections.abc import Callable, Hashable

    from numpy.typing import ArrayLike

    from attitude.annotations import Epochs, FloatArray, Real
    from attitude.conditions.channel import Channel
    from attitude.conditions.moments import Moment, Pair, Source
    from attitude.epochs import Instant

# Spacing of samples of an observable whose derivatives have no bounds, in rad of the rotation.
_SPACING = 0.05
# Rates of a motion without bounds, sampled in a span, are exceeded by less than this factor.
_SAMPLES, _MARGIN = 64, 1.25


class Observable(Joinable):
    """A number at every epoch: its extrema are found, and a comparison makes it a `Condition`.

    Made by `events.separation`, `events.brightness` and ``scene.quantity``; ``observable(t)``
    evaluates it; ``observable > "10 deg"`` is a condition.  Can be pickled if its motion and
    function can be.

    Attributes
    ----------
    source : Source
        The motion or scene.
    slope : Channel or None
        A channel with the sign of the derivative.
    unit : str
        Of the values, as astropy spells it; "" for pure numbers.
    rate : float or None
        Upper bound of the magnitude of the derivative, units per second.
    step : float or None
        Spacing of samples that shows every change, s.
    is_smooth : bool
        Whether derivatives are continuous, so that samples bound them, and values finite.
    """

    is_flag = False

    def __init__(
        self,
        source: Source,
        value: Callable[[Moment], FloatArray],
        slope: Channel | None = None,
        *,
        unit: str = "",
        rate: float | None = None,
        step: float | None = None,
        is_smooth: bool = False,
    ) -> None:
        self.source, self.value, self.slope = source, value, slope
        self.unit, self.rate, self.step, self.is_smooth = unit, rate, step, is_smooth

    @property
    def key(self) -> Hashable:
        """What two observables of one source share if they are one."""
        return self.value

    @property
    def epoch(self) -> Instant:
        """The epoch from which plain seconds count: of the motion, or J2000 without a motion."""
        return self.source.epoch

    def __call__(self, t: Epochs, low: ArrayLike | None = None) -> FloatArray:
        """The values at epochs of any shape, as ``motion.at`` takes them."""
        return values_at(self.source, self.value, t, low)

    def spacing(self, start: Pair, stop: Pair) -> float:
        """The spacing of samples in a span, s: `step`, or 0.05 rad of the fastest rotation."""
        if self.step is not None:
            return self.step
        rate = fastest(self.source, start, stop)
        length = (stop[0] - start[0]) + (stop[1] - start[1])
        return _SPACING / rate if rate > 0.0 else max(length, 1.0) / 64.0

    @property
    def condition(self) -> Condition:
        """For an observable that is true or false, the condition that it is true."""
        if not self.is_flag:
            raise AttitudeError(
                f"{self!r} is a number, no condition; compare it with a threshold, in parentheses: "
                f'(... > "{_EXAMPLES.get(self.unit, f"1 {self.unit}".strip())}").'
            )
        return self > 0.5

    def __gt__(self, threshold: Real) -> Condition:
        return self._compared(">", threshold)

    def __ge__(self, threshold: Real) -> Condition:
        return self._compared(">=", threshold)

    def __lt__(self, threshold: Real) -> Condition:
        return self._compared("<", threshold)

    def __le__(self, threshold: Real) -> Condition:
        return self._compared("<=", threshold)

    def _compared(self, comparison: str, threshold: Real) -> Condition:
        if isinstance(threshold, Observable):
            raise AttitudeError(
                "two observables are compared; give scene.quantity a function of the view that "
                "returns their difference, and compare that with 0."
            )
        number = validation.number(threshold, "the threshold", unit=self.unit or None)
        if self.is_smooth and comparison.startswith("<"):
            # One channel for both comparisons, so that a change of both is one event.
            opposite = {"<": ">=", "<=": ">"}[comparison]
            return Condition(self.source, (Level(self, opposite, number),), Not(Sign(0)))
        return Condition(self.source, (Level(self, comparison, number),), Sign(0))

    def __repr__(self) -> str:
        return f"<{type(self).__name__}{f' in {self.unit}' if self.unit else ''}>"


_EXAMPLES = {"rad": "10 deg", "m": "1000 km"}


def fastest(source: Source, start: Pair, stop: Pair) -> float:
    """The largest rate of rotation in a span, rad/s: its bound, or from samples with a margin."""
    motion = source.turning
    ends = [start[0], *(t for t in motion.joints.tolist() if start[0] < t < stop[0])]
    bounds = [motion.rate_bounds(t) for t in ends]
    known = [each.first for each in bounds if each is not None]
    if len(known) == len(bounds):
        return max(known)
    s = np.linspace(0.0, (stop[0] - start[0]) + (stop[1] - start[1]), _SAMPLES)
    history = source.at(start[0] + s, np.full(s.size, start[1])).history
    return _MARGIN * float(np.max(lengths(history.angular_velocity)))
