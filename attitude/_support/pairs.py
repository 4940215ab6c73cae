"""Sums and products of float64 arrays in two doubles, exact or to 2 eps squared.

A pair (hi, lo) stands for hi + lo with |lo| at most half a unit in the last place of hi; hi and lo
are floats or arrays.  `attitude._solver.twofloat` has the same functions for compiled code.

Source: Dekker, Numer. Math. 18, 224 (1971); Knuth, The Art of Computer Programming 2, 4.2.2.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple, Protocol, TypeAlias

import numpy as np

from attitude._support.arrays import frozen

if TYPE_CHECKING:
    from collections.abc import Callable

    from attitude._support.annotations import FloatArray

    Doubles: TypeAlias = float | FloatArray
    Pair: TypeAlias = tuple[Any, Any]


class HasSeconds(Protocol):
    """What has epochs in two doubles: a history, a view, records to be written."""

    @property
    def seconds(self) -> FloatArray:
        """The first doubles."""

    @property
    def low(self) -> FloatArray | None:
        """The second doubles; None for zeros."""


class Seconds(NamedTuple):
    """Epochs hi + lo, s, arrays of one shape; lo is None if it is zero, which halves the work."""

    hi: FloatArray
    lo: FloatArray | None = None

    @classmethod
    def of(cls, owner: HasSeconds) -> Seconds:
        """Those of a history, a view or records."""
        return cls(owner.seconds, owner.low)

    def taken(self, index: Any) -> Seconds:
        """Some of the epochs."""
        return Seconds(self.hi[index], None if self.lo is None else self.lo[index])

    def mapped(self, function: Callable[[FloatArray], FloatArray]) -> Seconds:
        """The epochs after a change of shape or memory of either array."""
        return Seconds(function(self.hi), None if self.lo is None else function(self.lo))

    def plus(self, seconds: Doubles, low: Doubles = 0.0) -> tuple[FloatArray, FloatArray]:
        """The epochs later by seconds + low, both doubles of each."""
        hi, lo = add((self.hi, 0.0 if self.lo is None else self.lo), seconds, low)
        return hi, lo

    @property
    def flat(self) -> tuple[FloatArray, FloatArray]:
        """Contiguous arrays (N,) of both doubles, zeros if there are no second ones."""
        hi, lo = self.compact
        return hi, np.zeros(hi.size) if self.lo is None else lo

    @property
    def compact(self) -> tuple[FloatArray, FloatArray]:
        """As `flat`, but one zero (1,) for all epochs if there are no second doubles."""
        lo = _ZERO if self.lo is None else np.ascontiguousarray(self.lo).reshape(-1)
        return np.ascontiguousarray(self.hi).reshape(-1), lo

    @property
    def low(self) -> FloatArray:
        """The second doubles, zeros if there are none."""
        return np.zeros(np.shape(self.hi)) if self.lo is None else self.lo

    @property
    def rounded(self) -> FloatArray:
        """hi + lo in one double."""
        return self.hi if self.lo is None else self.hi + self.lo


_ZERO = frozen(np.zeros(1))


def _row(array):
    return frozen(np.ascontiguousarray(array).reshape(1, -1))


def rows(hi: FloatArray, lo: FloatArray | None) -> tuple[FloatArray, FloatArray | None]:
    """Epochs hi + lo as read-only views (1, N), which compiled loops take."""
    return _row(hi), None if lo is None else _row(lo)


def two_sum(a: Doubles, b: Doubles) -> Pair:
    """a + b as the rounded sum and its rounding error, exactly."""
    total = a + b
    second = total - a
    return total, (a - (total - second)) + (b - second)


def add(pair: tuple[Doubles, Doubles], term: Doubles, low: Doubles = 0.0) -> Pair:
    """The sum (hi, lo) of a pair and term + low, to 2 eps squared of the largest of them."""
    total, error = two_sum(pair[0], term)
    return two_sum(total, error + (pair[1] + low))


def product(a: Doubles, b: Doubles) -> Pair:
    """a b as the rounded product and its rounding error, exactly; |a| and |b| below 1e299."""
    p = a * b
    (a, a_low), (b, b_low) = _halves(a), _halves(b)
    return p, ((a * b - p) + a * b_low + a_low * b) + a_low * b_low


def times(a: tuple[Doubles, Doubles], b: tuple[Doubles, Doubles]) -> Pair:
    """The product of two pairs, to 8 eps squared."""
    p, e = product(a[0], b[0])
    return two_sum(p, e + (a[0] * b[1] + a[1] * b[0]))


def root(a: tuple[Doubles, Doubles]) -> Pair:
    """The square root of a pair a > 0, to 4 eps squared."""
    r = a[0] ** 0.5
    p, e = product(r, r)
    return two_sum(r, (((a[0] - p) - e) + a[1]) / (2.0 * r))


def quotient(a: tuple[Doubles, Doubles], b: tuple[Doubles, Doubles]) -> Pair:
    """The quotient a / b of two pairs, to 8 eps squared."""
    q = a[0] / b[0]
    p, e = product(q, b[0])
    return two_sum(q, ((((a[0] - p) - e) + a[1]) - q * b[1]) / b[0])


def _halves(x: Doubles) -> Pair:
    """x as two numbers of 26 bits each."""
    big = 134217729.0 * x
    high = big - (big - x)
    return high, x - high
