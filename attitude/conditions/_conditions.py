"""Channels, conditions (trees of and, or, not over the signs of channels) and observables."""

from __future__ import annotations

import operator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final, TypeAlias

import numpy as np

from attitude._support import pairs, validation
from attitude._support.validation import shown
from attitude.conditions._moments import lengths, same_source, values_at
from attitude.errors import AttitudeError

if TYPE_CHECKING:
    from collections.abc import Callable, Hashable, Sequence

    from numpy.typing import ArrayLike

    from attitude._support.annotations import BoolArray, Epochs, FloatArray, IntArray, Real
    from attitude.conditions._moments import Drift, Moment, Pair, SearchDirection, Source
    from attitude.epochs._instants import Instant
    from attitude.motions._motion import RateBounds

    Possible: TypeAlias = tuple[BoolArray, BoolArray]


_COMPARISONS: Final[dict[str, Callable[..., BoolArray]]] = {
    ">": operator.gt,
    ">=": operator.ge,
    "<": operator.lt,
    "<=": operator.le,
}


class Channel:
    """The base of all channels.

    A new kind defines ``directions``, ``noise``, and the two methods `value` and `bounds`.

    Attributes
    ----------
    directions : tuple of SearchDirection
        The directions on which the value depends.
    noise : float
        Rounding error of the value: smaller magnitudes have no certain sign.
    """

    directions: tuple[SearchDirection, ...]
    noise: float

    def value(self, moment: Moment) -> FloatArray:
        """The values (N,) at a block of epochs."""
        raise NotImplementedError(f"{type(self).__name__} defines no value")

    def sign(self, moment: Moment) -> BoolArray:
        """Whether the values (N,) are not negative."""
        return self.value(moment) >= 0.0

    def bounds(self, rates: RateBounds, drifts: Sequence[Drift]) -> tuple[float, float]:
        """Upper bounds of the first two derivatives, per second and per second squared.

        From bounds for axes fixed in the body, and for each of the `directions`.
        """
        raise NotImplementedError(f"{type(self).__name__} defines no bounds")


class Level(Channel):
    """An observable compared with a threshold; equal ones are one channel of a condition.

    NaN is neither above nor below a threshold.

    Parameters
    ----------
    observable : Observable
    comparison : ">", ">=", "<" or "<="
    threshold : float
        In the unit of the observable.
    """

    directions = ()
    noise = 0.0

    def __init__(self, observable: Observable, comparison: str, threshold: float) -> None:
        self.observable, self.comparison, self.threshold = observable, comparison, threshold

    def value(self, moment: Moment) -> FloatArray:
        """The observable minus the threshold (N,)."""
        return self.observable.value(moment) - self.threshold

    def sign(self, moment: Moment) -> BoolArray:
        """Whether the comparison holds (N,)."""
        return _COMPARISONS[self.comparison](self.observable.value(moment), self.threshold)

    def _key(self) -> tuple[object, str, float]:
        return self.observable.key, self.comparison, self.threshold

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Level) and self._key() == other._key()

    def __hash__(self) -> int:
        return hash(self._key())


# ---- How the signs of channels decide a condition: trees of and, or, not over the signs
# Trees are made of classes of this module, which can be pickled; closures cannot.


class Logic:
    """The base of all nodes."""

    def __call__(self, signs: Sequence[BoolArray]) -> BoolArray:
        """Whether the condition holds (N,), from the signs (N,) of its channels."""
        return self.possible([(sign, ~sign) for sign in signs])[0]

    def possible(self, signs: Sequence[Possible]) -> Possible:
        """Whether the condition can hold and can fail, where some signs are not known."""
        raise NotImplementedError(f"{type(self).__name__} defines no possible")

    def renumbered(self, places: Sequence[int]) -> Logic:
        """The same logic where the channel k has the number places[k]."""
        raise NotImplementedError(f"{type(self).__name__} defines no renumbered")


@dataclass(frozen=True)
class Sign(Logic):
    """The sign of the channel with a number."""

    number: int

    def possible(self, signs: Sequence[Possible]) -> Possible:
        """What the sign can be."""
        return signs[self.number]

    def renumbered(self, places: Sequence[int]) -> Logic:
        """The sign of the channel with the new number."""
        return Sign(places[self.number])


@dataclass(frozen=True)
class Not(Logic):
    """The opposite of a logic."""

    one: Logic

    def possible(self, signs: Sequence[Possible]) -> Possible:
        """Can hold where the other can fail."""
        true, false = self.one.possible(signs)
        return false, true

    def renumbered(self, places: Sequence[int]) -> Logic:
        """See `Logic`."""
        return Not(self.one.renumbered(places))


@dataclass(frozen=True)
class Both(Logic):
    """Two logics that must hold together."""

    one: Logic
    other: Logic

    def possible(self, signs: Sequence[Possible]) -> Possible:
        """Can hold where both can, can fail where either can."""
        (a, p), (b, q) = self.one.possible(signs), self.other.possible(signs)
        return a & b, p | q

    def renumbered(self, places: Sequence[int]) -> Logic:
        """See `Logic`."""
        return Both(self.one.renumbered(places), self.other.renumbered(places))


def either(one: Logic, other: Logic) -> Logic:
    """The logic that holds where one of two holds."""
    return Not(Both(Not(one), Not(other)))


def undecided(logic: Logic, signs: Sequence[IntArray]) -> BoolArray:
    """Where (N,) the signs leave a condition open: 1 for True, 0 for False, -1 for not known."""
    true, false = logic.possible([(sign != 0, sign != 1) for sign in signs])
    return true & false


# ---- Conditions: true or false at every epoch, combined by &, | and ~


class Joinable:
    """Base of what &, | and ~ combine: conditions, and what stands for one as `condition`."""

    # Arrays and Quantities leave operations with these objects to them.
    __array_ufunc__ = None

    @property
    def condition(self) -> Condition:
        """The condition that this object stands for."""
        raise NotImplementedError(f"{type(self).__name__} defines no condition")

    def __and__(self, other: Joinable) -> Condition:
        return self.condition._joined(other, Both)

    def __or__(self, other: Joinable) -> Condition:
        return self.condition._joined(other, either)

    def __rand__(self, other: object) -> Condition:
        raise AttitudeError(
            f"{shown(other)} is combined with a condition; & and | bind closer than comparisons: "
            'put each comparison in parentheses, as in (elevation > "10 deg") & glint.'
        )

    __ror__ = __rand__

    def __invert__(self) -> Condition:
        condition = self.condition
        return Condition(condition.source, condition.channels, Not(condition.logic))

    def __bool__(self) -> bool:
        raise AttitudeError(
            f"{self!r} is true at some epochs and false at others; combine conditions by &, | and "
            "~ (not by and, or, not, or a < b < c), each comparison in parentheses."
        )


class Condition(Joinable):
    """True or False at every epoch; made by `events.in_cone`, comparisons, and others.

    ``condition(t)`` evaluates it; ``&``, ``|`` and ``~`` combine conditions of one scene object, or
    of equal motions.  Conditions can be pickled if their motion and functions can be; those of one
    list remain conditions of one motion.

    Attributes
    ----------
    source : Source
        The motion or scene.
    channels : tuple of Channel
    logic : Logic
        Of the signs of the channels.
    """

    def __init__(self, source: Source, channels: Sequence[Channel], logic: Logic) -> None:
        self.source, self.channels, self.logic = source, tuple(channels), logic

    @property
    def condition(self) -> Condition:
        """The condition itself."""
        return self

    @property
    def epoch(self) -> Instant:
        """The epoch from which plain seconds count: of the motion, or J2000 without a motion."""
        return self.source.epoch

    def __call__(self, t: Epochs, low: ArrayLike | None = None) -> BoolArray:
        """Whether the condition holds at epochs of any shape, as ``motion.at`` takes them."""
        return values_at(self.source, lambda moment: self.states(self.signs(moment)), t, low)

    def signs(self, moment: Moment) -> list[BoolArray]:
        """The sign of each channel (N,)."""
        return [channel.sign(moment) for channel in self.channels]

    def states(self, signs: Sequence[BoolArray]) -> BoolArray:
        """Whether the condition holds (N,), from the signs of the channels."""
        return self.logic(signs)

    def _joined(self, other: Any, operation: Callable[[Logic, Logic], Logic]) -> Condition:
        if not isinstance(other, Joinable):
            raise AttitudeError(
                f"a condition is combined with {shown(other)}; give another condition, such as "
                'events.in_cone(...) or scene.quantity("elevation") > "10 deg" (in parentheses).'
            )
        more = other.condition
        if not same_source(self.source, more.source):
            raise AttitudeError(
                "only conditions of the same motion or scene can be combined with & and |, since "
                "a scene counts epochs of reception; make both from one Scene object, or both from "
                "one motion."
            )
        # Equal channels are one, so that their changes are one event.
        channels = list(dict.fromkeys([*self.channels, *more.channels]))
        places = [channels.index(channel) for channel in more.channels]
        logic = operation(self.logic, more.logic.renumbered(places))
        return Condition(self.source, channels, logic)

    def __repr__(self) -> str:
        count = len(self.channels)
        return f"<Condition of {count} channel{'s' if count > 1 else ''}>"


def condition_of(value: object, name: str) -> Condition:
    """The Condition that an object is or stands for."""
    if not isinstance(value, Joinable):
        raise AttitudeError(
            f"{name} is {shown(value)}; give a Condition, such as events.in_cone(...) or "
            'scene.quantity("elevation") > "10 deg".'
        )
    return value.condition


# ---- Observables: numbers at every epoch, with extrema, and conditions by comparison

# Spacing of samples of an observable whose derivatives have no bounds, in rad of the rotation.
_SPACING = 0.05
# Samples in a span of the rates of a motion without bounds.
_SAMPLES = 64
# Rates between the samples exceed them by less than this factor.
_MARGIN = 1.25


class Observable(Joinable):
    """A number at every epoch: its extrema are found, and a comparison makes it a `Condition`.

    Made by `events.separation`, `events.brightness` and ``scene.quantity``; ``observable(t)``
    evaluates it; ``observable > "10 deg"`` is a condition.  Can be pickled if its motion and
    function can be.

    Attributes
    ----------
    source : Source
        The motion or scene.
    slope : function or None
        Returns a channel with the sign of the derivative, for a source, a start and a stop.
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
        slope: Callable[[Source, Pair, Pair], Channel] | None = None,
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

    def _searches(self, start: Pair, stop: Pair) -> tuple[tuple[Pair, Pair, float], ...]:
        """The parts of a span, begin and end, and the spacings of their samples, s."""
        return ((start, stop, self.spacing(start, stop)),)

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

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, (int, float, str, np.ndarray)):
            return self is other
        raise AttitudeError(
            f"{self!r} is compared with {shown(other)} by == or !=; use <, <=, > or >=, which make "
            "a condition."
        )

    __hash__ = object.__hash__

    def _compared(self, comparison: str, threshold: Real) -> Condition:
        if isinstance(threshold, Observable):
            raise AttitudeError(
                "two observables are compared; give scene.quantity a function of the view that "
                "returns their difference, and compare that with 0."
            )
        number = validation.number(threshold, "the threshold", unit=self.unit or None)
        logic: Logic = Sign(0)
        if self.is_smooth and comparison.startswith("<"):
            # One channel for both comparisons, so that a change of both is one event.
            comparison, logic = {"<": ">=", "<=": ">"}[comparison], Not(logic)
        return Condition(self.source, (Level(self, comparison, number),), logic)

    def __repr__(self) -> str:
        return f"<{type(self).__name__}{f' in {self.unit}' if self.unit else ''}>"


_EXAMPLES = {"rad": "10 deg", "m": "1000 km"}


def fastest(source: Source, start: Pair, stop: Pair) -> float:
    """The largest rate of rotation in a span, rad/s: its bound, or from samples with a margin."""
    motion = source.turning
    ends = [start[0], *(t for t in motion.joints.tolist() if start[0] < t < stop[0])]
    bounds = [motion.rate_bounds(t) for t in ends]
    known = [bound.first for bound in bounds if bound is not None]
    if len(known) == len(bounds):
        return max(known)
    s = np.linspace(0.0, (stop[0] - start[0]) + (stop[1] - start[1]), _SAMPLES)
    history = source.at(*pairs.add(start, s)).history
    return _MARGIN * float(np.max(lengths(history.angular_velocity)))
