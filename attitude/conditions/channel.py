"""Channels: functions of time whose sign changes a search finds."""

from __future__ import annotations

import operator
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from attitude.annotations import BoolArray, FloatArray
    from attitude.conditions.moments import Drift, Moment, SearchDirection
    from attitude.conditions.observable import Observable
    from attitude.motion import RateBounds

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
