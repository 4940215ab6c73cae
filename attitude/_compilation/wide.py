"""Whole numbers of 448 bits as values, for numbers with 115 digits after the point.

In Python they are Python's integers.  In compiled code they are one value of LLVM's type i448, with
the operators + and - between two of them; a result beyond 448 bits is undefined.  A number x below
8 with 444 bits after the binary point is the integer x 2**BITS.

The functions below are the definitions in Python; `wide_lowering` has the instructions.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from attitude._support.annotations import IntArray


BITS = 444
WORDS = 7
_HALF = 1 << (BITS - 1)
_WORD = (1 << 64) - 1
# `product` leaves out the products of words whose places add up to less.
FIRST = 5


def wide(n: int) -> int:
    """A 64-bit integer as a wide one."""
    return int(n)


def word(n: int) -> int:
    """The lowest 64 bits as a signed integer."""
    return ((n + (1 << 63)) & _WORD) - (1 << 63)


def whole(x: float) -> int:
    """A double that is a whole number below 2**447, as an integer."""
    return int(x)


def double(n: int) -> float:
    """The nearest double, ties to even."""
    return float(n)


def times(a: int, b: int) -> int:
    """The product of two numbers with BITS bits after the point, rounded to such a number."""
    return (a * b + _HALF) >> BITS


def product(a: int, b: int) -> int:
    """As `times` with an error of up to 2 in the last place, at two thirds of its cost."""
    first, second = _words(abs(a)), _words(abs(b))
    total = 0
    for i, x in enumerate(first):
        for j, y in enumerate(second):
            if i + j >= FIRST:
                total += (x * y) << (64 * (i + j))
    size = total >> BITS
    return -size if (a < 0) != (b < 0) else size


def _words(n):
    """The words of a magnitude, the lowest first."""
    return [n >> (64 * k) & _WORD for k in range(WORDS)]


def shifted(n: int, places: int) -> int:
    """The integer times 2**places, rounded down; |places| is below 448."""
    return n << int(places) if places >= 0 else n >> int(-places)


def negative(n: int) -> bool:
    """Whether the integer is below zero."""
    return n < 0


def length(n: int) -> int:
    """The number of bits of the magnitude; 0 for 0."""
    return n.bit_length()


def load(words: IntArray, k: int) -> int:
    """The k-th integer of a contiguous array (7 K,) of 64-bit words, the lowest word first."""
    number = words[WORDS * int(k) : WORDS * int(k) + WORDS]
    return int.from_bytes(number.tobytes(), "little", signed=True)


def store(words: IntArray, k: int, n: int) -> None:
    """Write the k-th integer of an array of words."""
    import numpy as np

    whole_number = int(n).to_bytes(8 * WORDS, "little", signed=True)
    words[WORDS * int(k) : WORDS * int(k) + WORDS] = np.frombuffer(whole_number, dtype="<i8")
