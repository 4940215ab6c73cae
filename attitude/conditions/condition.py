"""Conditions: true or false at every epoch, combined by &, | and ~."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from attitude.conditions.logic import Both, Logic, Not, either
from attitude.conditions.moments import same_source, values_at
from attitude.errors import AttitudeError
from attitude.validation import shown

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from numpy.typing import ArrayLike

    from attitude.annotations import BoolArray, Epochs
    from attitude.conditions.channel import Channel
    from attitude.conditions.moments import Moment, Source
    from attitude.epochs import Instant


class Joinable:
    """Base of what &, | and ~ combine: conditions, and what stands for one as `condition`."""

    @property
    def condition(self) -> Condition:
        """The condition that this object stands for."""
        raise NotImplementedError(f"{type(self).__name__} defines no condition")

    def __and__(self, other: Joinable) -> Condition:
        return self.condition._joined(other, Both)

    def __or__(self, other: Joinable) -> Condition:
        return self.condition._joined(other, either)

    def __invert__(self) -> Condition:
        own = self.condition
        return Condition(own.source, own.channels, Not(own.logic))

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
        channels = list(self.channels)
        places = []
        for channel in more.channels:
            if channel not in channels:
                channels.append(channel)
            places.append(channels.index(channel))
        return Condition(
            self.source, channels, operation(self.logic, more.logic.renumbered(places))
        )

    def __repr__(self) -> str:
        count = len(self.channels)
        return f"<Condition of {count} channel{'s' if count > 1 else ''}>"


def condition_of(given: object, name: str = "f") -> Condition:
    """The Condition that an object is or stands for.

    Raises
    ------
    AttitudeError
        For any other object.
    """
    if not isinstance(given, Joinable):
        raise AttitudeError(
            f"{name} is {shown(given)}; give a Condition, such as events.in_cone(...) or "
            'scene.quantity("elevation") > "10 deg".'
        )
    return given.condition
