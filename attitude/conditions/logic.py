"""How the signs of channels decide a condition: trees of and, or, not over the signs.

Trees are made of classes of this module, which can be pickled; closures cannot.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, TypeAlias

if TYPE_CHECKING:
    from collections.abc import Sequence

    from attitude.annotations import BoolArray, IntArray

    # Whether something can be true, and whether it can be false (N,).
    Possible: TypeAlias = tuple[BoolArray, BoolArray]


class Logic:
    """The base of all nodes."""

    def __call__(self, signs: Sequence[BoolArray]) -> BoolArray:
        """Whether the condition holds (N,), from the signs (N,) of its channels."""
        raise NotImplementedError(f"{type(self).__name__} defines no __call__")

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

    def __call__(self, signs: Sequence[BoolArray]) -> BoolArray:
        """The sign itself."""
        return signs[self.number]

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

    def __call__(self, signs: Sequence[BoolArray]) -> BoolArray:
        """Whether it fails."""
        return ~self.one(signs)

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

    def __call__(self, signs: Sequence[BoolArray]) -> BoolArray:
        """Whether both hold."""
        return self.one(signs) & self.other(signs)

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
    true, false = logic.possible([(each != 0, each != 1) for each in signs])
    return true & false
