"""SIMD vectors of a few doubles as values, for code that LLVM does not vectorise.

LLVM unrolls a short loop before it could vectorise it, and does not join eight copies of a formula.
Here eight doubles are one value of the machine's vector type (one AVX-512 register, two of AVX2,
four of NEON) that compiled code adds, multiplies and divides with the usual operators, with doubles
on either side, or a shorter vector, which is repeated; `instructions.fma` takes such values too.
Functions that take `Lanes | float` make one formula of it for one body and for several.  Products
and sums are fused only where the caller is compiled with that option (`reduction`).

The functions below are the definitions in Python; `simd_lowering` has the vector instructions.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from attitude._compilation.instructions import fma

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

    from numpy.typing import NDArray

    from attitude._support.annotations import FloatArray


class Lanes:
    """A SIMD vector of doubles, in Python."""

    __slots__ = ("_numbers",)

    def __init__(self, numbers: Iterable[float]) -> None:
        doubles = numbers if isinstance(numbers, np.ndarray) else list(map(float, numbers))
        self._numbers: FloatArray = np.array(doubles, dtype=float)

    @property
    def lanes(self) -> tuple[float, ...]:
        """The numbers of the lanes."""
        return tuple(self._numbers.tolist())

    def _with(self, other: Lanes | float, function: Callable[..., Any]) -> Lanes:
        a, b = self._numbers, other._numbers if isinstance(other, Lanes) else float(other)
        if isinstance(b, np.ndarray) and len(a) != len(b):
            count = max(len(a), len(b))
            a, b = np.tile(a, count // len(a)), np.tile(b, count // len(b))
        result = Lanes.__new__(Lanes)
        result._numbers = function(a, b)
        return result

    def __neg__(self) -> Lanes:
        return Lanes(-self._numbers)

    def __add__(self, other: Lanes | float) -> Lanes:
        return self._with(other, np.add)

    __radd__ = __add__

    def __sub__(self, other: Lanes | float) -> Lanes:
        return self._with(other, np.subtract)

    def __rsub__(self, other: float) -> Lanes:
        return self._with(other, lambda a, b: b - a)

    def __mul__(self, other: Lanes | float) -> Lanes:
        return self._with(other, np.multiply)

    __rmul__ = __mul__

    def __truediv__(self, other: Lanes | float) -> Lanes:
        return self._with(other, _quotients)

    def __rtruediv__(self, other: float) -> Lanes:
        return self._with(other, lambda a, b: _quotients(b, a))

    @staticmethod
    def fused(*three: Lanes | float) -> Lanes:
        """a b + c with one rounding, of vectors and doubles."""
        count = max(len(x._numbers) for x in three if isinstance(x, Lanes))
        return Lanes(map(fma, *(_spread(x, count) for x in three)))


def _spread(x: Lanes | float, count: int) -> tuple[float, ...]:
    """The lanes of a vector, repeated, or a double in every lane."""
    numbers = x.lanes if isinstance(x, Lanes) else (float(x),)
    return numbers * (count // len(numbers))


def _quotients(a: Any, b: Any) -> FloatArray:
    """a / b; NaN or infinity where b is zero."""
    with np.errstate(all="ignore"):
        return np.divide(a, b)


def eight(array: FloatArray, i: int) -> Lanes:
    """The vector array[i], ..., array[i + 7] of a contiguous array of doubles."""
    i = int(i)
    return Lanes(array[i : i + 8])


def four(array: FloatArray, i: int) -> Lanes:
    """The vector array[i], ..., array[i + 3] of a contiguous array of doubles."""
    i = int(i)
    return Lanes(array[i : i + 4])


def sixteen(array: FloatArray, i: int) -> Lanes:
    """The vector array[i], ..., array[i + 15] of a contiguous array of doubles."""
    i = int(i)
    return Lanes(array[i : i + 16])


def put_eight(array: FloatArray, i: int, a: Lanes) -> None:
    """Store a vector as array[i], ..., array[i + 7] of a contiguous array of doubles."""
    i = int(i)
    array[i : i + 8] = a._numbers


def add_in_columns(array: NDArray[np.uint8], i: int, rows: Lanes, amounts: Lanes) -> None:
    """Add amounts[k] to array[i + 8 rows[k] + k], flat, of bytes, for lanes k, modulo 256."""
    for k, (row, amount) in enumerate(zip(rows.lanes, amounts.lanes, strict=True)):
        place = int(i) + 8 * int(row) + k
        array[place] = (int(array[place]) + int(amount)) % 256


def lanes(numbers: tuple[float, ...]) -> Lanes:
    """The vector of the doubles of a tuple."""
    return Lanes(numbers)


def doubles_of(a: Lanes) -> tuple[float, ...]:
    """The doubles of the lanes as a tuple."""
    return a.lanes


def bits_set_in_bytes(word: int) -> Lanes:
    """The numbers of bits set in each of the eight bytes of a word, the lowest byte first."""
    return Lanes(byte.bit_count() for byte in int(word).to_bytes(8, "little"))


def every(number: float, like: Lanes) -> Lanes:
    """A vector as long as another one, with a double in every lane."""
    return Lanes([number] * len(like.lanes))


def at_least(a: Lanes, least: Lanes | float) -> Lanes:
    """The larger of two numbers, lane by lane."""
    return a._with(least, lambda x, y: np.where(x > y, x, y))


def at_most(a: Lanes, most: Lanes | float) -> Lanes:
    """The smaller of two numbers, lane by lane."""
    return a._with(most, lambda x, y: np.where(x < y, x, y))


def chosen(by: Lanes, a: Lanes, b: Lanes) -> Lanes:
    """The lanes of `a` where those of `by` are above zero, else those of `b`."""
    return Lanes(x if k > 0.0 else y for k, x, y in zip(by.lanes, a.lanes, b.lanes, strict=True))


def root(a: Lanes | float) -> Lanes | float:
    """The square root, lane by lane; NaN of negative numbers."""
    if not isinstance(a, Lanes):
        return math.nan if a < 0.0 else math.sqrt(a)
    return Lanes(math.nan if x < 0.0 else math.sqrt(x) for x in a.lanes)


def for_each(numbers: tuple[float, ...], like: Lanes | float) -> Lanes:
    """A vector of each number of a tuple, once for a double, once for each lane of a vector."""
    count = len(like.lanes) if isinstance(like, Lanes) else 1
    return Lanes(number for number in numbers for _ in range(count))


def packed(a: Lanes, by: Lanes) -> Lanes:
    """The lanes of `a` where those of `by` are above zero, without gaps; the others are zero."""
    kept = [x for k, x in zip(by.lanes, a.lanes, strict=True) if k > 0.0]
    return Lanes(kept + [0.0] * (len(a.lanes) - len(kept)))


def truncated(a: Lanes) -> Lanes:
    """The whole part, lane by lane, of sizes below 2^31."""
    return Lanes(math.trunc(x) for x in a.lanes)


def nearest_eighth(a: Lanes) -> Lanes:
    """The nearest multiple of 1/8, ties to even, lane by lane; sizes are at most 2^48."""
    return Lanes(round(8.0 * x) / 8.0 for x in a.lanes)


def inverse_power(a: Lanes) -> Lanes:
    """2^-n for the `nearest_eighth` n of a, below 1022, lane by lane."""
    return Lanes(2.0**-x for x in nearest_eighth(a).lanes)


def halved(a: Lanes, times: Lanes) -> Lanes:
    """a / 2^times for whole `times`, lane by lane; numbers and results are normal."""
    return Lanes(math.ldexp(x, -int(n)) for x, n in zip(a.lanes, times.lanes, strict=True))


def exponent(a: Lanes) -> Lanes:
    """The whole n by which a / 2^n is from 3/4 to 3/2, lane by lane, for normal a > 0."""
    powers = (math.frexp(x) for x in a.lanes)
    return Lanes(n if fraction >= 0.75 else n - 1 for fraction, n in powers)


def summed_up(a: Lanes) -> float:
    """The sum of the lanes: the upper half is added to the lower one until one lane is left."""
    return _added(a, 1)[0]


def summed_for_each(a: Lanes, like: Lanes | float) -> Lanes | float:
    """The sum over the numbers of `for_each`: a double, or a vector as long as `like`."""
    return Lanes(_added(a, len(like.lanes))) if isinstance(like, Lanes) else summed_up(a)


def _added(a: Lanes, count: int) -> list[float]:
    """Lanes whose upper half is added to the lower one until so many are left."""
    left = list(a.lanes)
    while len(left) > count:
        half = len(left) // 2
        left = [left[k] + left[half + k] for k in range(half)]
    return left


def largest_lane(a: Lanes) -> float:
    """The largest of the lanes, none of which is NaN."""
    return max(a.lanes)


def positive_bits(a: Lanes) -> int:
    """A number with a bit for each lane, the first one lowest: 1 where the lane is above zero."""
    return sum(1 << k for k, x in enumerate(a.lanes) if x > 0.0)


# ---- Stores past the caches, for results larger than they are
# A store brings its line of memory into the cache first, and a large result leaves the caches
# before it is read.  Whole lines that are stored past the caches cost half of the bandwidth, and do
# not expel what the computation needs.

LINE = 8  # doubles in a line of the cache


def past_line(array: FloatArray) -> int:
    """The number of doubles from the start of a line of the cache to that of a contiguous array."""
    address: int = array.ctypes.data
    return address // 8 % LINE


def copy_line(source: FloatArray, i: int, target: FloatArray, j: int) -> None:
    """Copy source[i], ..., source[i + 7] to the line of the cache that starts at target[j].

    Both are contiguous arrays of doubles.  Until `finish_stores` other threads may see old values.
    """
    i, j = int(i), int(j)
    target[j : j + LINE] = source[i : i + LINE]


def put_line(array: FloatArray, i: int, a: Lanes) -> None:
    """Store a vector of eight doubles as the line of the cache at array[i], as `copy_line`."""
    i = int(i)
    array[i : i + LINE] = a._numbers


def finish_stores() -> None:
    """Complete the stores of `copy_line` and `put_line` before all later ones."""
