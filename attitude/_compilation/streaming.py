"""Stores past the caches, for results larger than they are.

A store brings its line of memory into the cache first, and a large result leaves the caches before
it is read.  Whole lines that are stored past the caches cost half of the bandwidth, and do not
expel what the computation needs.

The functions below are the definitions in Python; `simd_lowering` has the instructions.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from attitude._compilation.simd import Lanes
    from attitude._support.annotations import FloatArray


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
    array[i : i + LINE] = a.lanes


def finish_stores() -> None:
    """Complete the stores of `copy_line` and `put_line` before all later ones."""
