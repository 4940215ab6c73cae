"""Arrays of intervals, rounded outward, and the turn of a direction in four dimensions.

Each operation of `Intervals` widens its result by one unit in the last place on both sides, which
covers the rounding to nearest of its ends.
"""

from __future__ import annotations

from typing import Any

import numpy as np

# Half a unit in the last place of 1.
UNIT_ROUNDOFF: float = 2.0**-53


class Intervals:
    """Intervals [lo, hi] of doubles: arrays of one shape; exact numbers without `hi`."""

    __slots__ = ("hi", "lo")

    def __init__(self, lo: Any, hi: Any = None):
        self.lo: Any = np.asarray(lo, dtype=float)
        self.hi: Any = self.lo if hi is None else np.asarray(hi, dtype=float)

    @staticmethod
    def outward(lo: Any, hi: Any) -> Intervals:
        """Ends that were rounded to nearest, moved outward."""
        return Intervals(np.nextafter(lo, -np.inf), np.nextafter(hi, np.inf))

    def __add__(self, other: Any) -> Intervals:
        other = of(other)
        return Intervals.outward(self.lo + other.lo, self.hi + other.hi)

    def __sub__(self, other: Any) -> Intervals:
        other = of(other)
        return Intervals.outward(self.lo - other.hi, self.hi - other.lo)

    def __neg__(self) -> Intervals:
        return Intervals(-self.hi, -self.lo)

    def __mul__(self, other: Any) -> Intervals:
        other = of(other)
        ends = [a * b for a in (self.lo, self.hi) for b in (other.lo, other.hi)]
        lo, hi = np.minimum(ends[0], ends[1]), np.maximum(ends[0], ends[1])
        for end in ends[2:]:
            lo, hi = np.minimum(lo, end), np.maximum(hi, end)
        return Intervals.outward(lo, hi)

    __radd__ = __add__
    __rmul__ = __mul__

    def __rsub__(self, other: Any) -> Intervals:
        return of(other) - self

    def __truediv__(self, other: Any) -> Intervals:
        other = of(other)
        if not np.all((other.lo > 0.0) | (other.hi < 0.0)):
            raise ZeroDivisionError("an interval that contains zero is a divisor")
        return self * Intervals.outward(1.0 / other.hi, 1.0 / other.lo)

    def square(self) -> Intervals:
        """The squares: never below zero."""
        low, high = self.lo * self.lo, self.hi * self.hi
        least = np.where(self.has_zero(), 0.0, np.minimum(low, high))
        return Intervals.outward(least, np.maximum(low, high))

    def sqrt(self) -> Intervals:
        """The square roots of what is not below zero."""
        return Intervals.outward(np.sqrt(np.maximum(self.lo, 0.0)), np.sqrt(self.hi))

    def absolute(self) -> Intervals:
        """The magnitudes."""
        least = np.minimum(np.abs(self.lo), np.abs(self.hi))
        return Intervals(np.where(self.has_zero(), 0.0, least), self.largest())

    def has_zero(self) -> Any:
        """Which intervals contain zero."""
        return (self.lo <= 0.0) & (self.hi >= 0.0)

    def largest(self) -> Any:
        """The largest magnitude in each interval."""
        return np.maximum(np.abs(self.lo), np.abs(self.hi))

    def within(self, lo: Any, hi: Any) -> Intervals:
        """The parts in [lo, hi], where the numbers are known to lie."""
        return Intervals(np.maximum(self.lo, lo), np.minimum(self.hi, hi))

    def power(self, n: int) -> Intervals:
        """The n-th powers, by squares."""
        if n == 0:
            return of(1.0)
        if n == 1:
            return self
        return self.square().power(n // 2) * (self if n % 2 else of(1.0))


def of(number: Any) -> Intervals:
    """Intervals themselves, or an exact number as one."""
    return number if isinstance(number, Intervals) else Intervals(np.float64(number))


_PLANES = [(j, k) for j in range(4) for k in range(j)]


class Turn:
    """The most by which errors turn the direction of vectors of four components, rad on S3.

    A rotation angle is twice that.  An error e of a number x turns the direction of y by at most
    |e| sup |D_j y_k - D_k y_j| / inf |y|^2, D = dy/dx (Lagrange's identity); on wide boxes
    |e| sup |D| / inf |y| is smaller.  Components are summed before norms are taken (Minkowski).
    """

    def __init__(self, vector: list[Intervals]):
        self._vector = vector
        self._in_planes: list[Any] = [0.0] * len(_PLANES)
        self._plain: list[Any] = [0.0] * 4

    def add(self, size: Any, derivative: list[Intervals]) -> None:
        """Add an error of at most `size` of a number by which the vector has this derivative."""
        y, slope = self._vector, derivative
        for n, (j, k) in enumerate(_PLANES):
            across = (slope[j] * y[k] - slope[k] * y[j]).largest()
            self._in_planes[n] = self._in_planes[n] + size * across
        for k in range(4):
            self._plain[k] = self._plain[k] + size * slope[k].largest()

    def total(self) -> Any:
        """The bound for each box."""
        squares = [component.square() for component in self._vector]
        square = (squares[0] + squares[1] + squares[2] + squares[3]).lo
        length = np.sqrt(square) * (1.0 - 1e-14)
        tangential = np.sqrt(sum(x * x for x in self._in_planes)) / square
        plain = np.sqrt(sum(x * x for x in self._plain)) / length
        # 1e-10 covers the roundings of these sums of doubles, none of which cancel.
        return np.minimum(tangential, plain) * (1.0 + 1e-10)
