"""Machine instructions without a name in Python, each defined here in Python.

In compiled code `attitude._compilation.lowering` replaces each function by the one instruction;
both return the same bits.  In Python they take arrays too, element by element
(`decorators.elementwise`).
"""

from __future__ import annotations

import math
import struct
from fractions import Fraction
from typing import Any

import numpy as np

_DOUBLE = struct.Struct("<d")
_INTEGER = struct.Struct("<q")
_WORD = (1 << 64) - 1
# Within these bounds the products and sums of `_fma` neither overflow nor lose bits by underflow.
FMA_RANGE = _SMALL, _LARGE = 1e-130, 1e130
_SPLITTER = 134217729.0  # 2^27 + 1


def fma(a: Any, b: Any, c: Any) -> Any:
    """a b + c with one rounding, of doubles, of SIMD vectors (`simd.Lanes`), or of both mixed."""
    if isinstance(a, float) and isinstance(b, float) and isinstance(c, float):
        return _fma(float(a), float(b), float(c))
    for operand in (a, b, c):
        if hasattr(operand, "fused"):
            return operand.fused(a, b, c)
        if isinstance(operand, np.ndarray):
            return _fma_of_arrays(a, b, c)
    return _fma(float(a), float(b), float(c))


def loop_fma(a: Any, b: Any, c: Any) -> Any:
    """As `fma`, for loops over epochs: vectorised also for processors without the instruction.

    There it is computed by error-free transforms, with the same bits but for one case in 1e15 and
    for products below 1e-290, whose rounding errors underflow; |b| is at most 1e300.  A `b` that
    several calls share is split once.
    """
    return fma(a, b, c)


def descending_fma(a: Any, b: Any, c: Any) -> Any:
    """As `loop_fma`, for |c| >= |a b|: three operations less."""
    return fma(a, b, c)


if hasattr(math, "fma"):

    def _fma(a, b, c):
        try:
            return math.fma(a, b, c)
        except (OverflowError, ValueError):
            return a * b + c  # inf - inf, 0 inf, or beyond all doubles

else:

    def _fma(a, b, c):
        """a b + c by error-free transforms and one sum rounded to odd.

        Source: Boldo & Melquiond, IEEE Trans. Comput. 57, 462 (2008), algorithm 5.
        """
        size = abs(a * b)
        if not (_SMALL < size < _LARGE and abs(a) < _LARGE and abs(b) < _LARGE) or not (
            c == 0.0 or _SMALL < abs(c) < _LARGE
        ):
            return _fma_of_any(a, b, c)
        p = a * b
        x = _SPLITTER * a
        a_high = x - (x - a)
        a_low = a - a_high
        x = _SPLITTER * b
        b_high = x - (x - b)
        b_low = b - b_high
        e = a_low * b_low - (((p - a_high * b_high) - a_low * b_high) - a_high * b_low)
        t = c + e
        addend = t - c
        t_low = (c - (t - addend)) + (e - addend)
        v = p + t
        addend = v - p
        v_low = (p - (v - addend)) + (t - addend)
        z = t_low + v_low
        addend = z - t_low
        left = (t_low - (z - addend)) + (v_low - addend)
        if left != 0.0 and not _INTEGER.unpack(_DOUBLE.pack(z))[0] & 1:
            z = math.nextafter(z, math.inf if left > 0.0 else -math.inf)
        return v + z


def _fma_of_arrays(a, b, c):
    """As `_fma` without ``math.fma``, element by element."""
    p = a * b
    size = np.abs(p)
    x = _SPLITTER * a
    a_high = x - (x - a)
    a_low = a - a_high
    x = _SPLITTER * b
    b_high = x - (x - b)
    b_low = b - b_high
    e = a_low * b_low - (((p - a_high * b_high) - a_low * b_high) - a_high * b_low)
    t, t_low = _exact_sum(c, e)
    v, v_low = _exact_sum(p, t)
    z, left = _exact_sum(t_low, v_low)
    to_odd = (left != 0.0) & (z.view(np.int64) & 1 == 0)
    result = v + np.where(to_odd, np.nextafter(z, np.copysign(np.inf, left)), z)
    # where products lose bits, or splitting overflows
    other = ~((size > _SMALL) & (size < _LARGE) & np.isfinite(result))
    if other.any():
        a, b, c = np.broadcast_arrays(a, b, c)
        zero = (a == 0.0) | (b == 0.0)
        result[zero] = p[zero] + c[zero]
        for place in np.flatnonzero(other & ~zero):
            of_place = (float(operand.flat[place]) for operand in (a, b, c))
            result.flat[place] = _fma_of_any(*of_place)
    return result


def _exact_sum(a, b):
    """The rounded sum of arrays, and what is left of it."""
    total = a + b
    addend = total - a
    return total, (a - (total - addend)) + (b - addend)


def _fma_of_any(a, b, c):
    """a b + c for any doubles, by rational arithmetic: slow."""
    if not (math.isfinite(a) and math.isfinite(b)) or a == 0.0 or b == 0.0:
        return a * b + c
    if not math.isfinite(c):
        return c
    exact = Fraction(a) * Fraction(b) + Fraction(c)
    if exact == 0:
        return 0.0
    try:
        return float(exact)
    except OverflowError:
        return math.inf if exact > 0 else -math.inf


def rint(a: Any) -> Any:
    """The nearest whole number as a double, ties to even."""
    if isinstance(a, np.ndarray):
        return np.rint(a)
    if not abs(a) < 4503599627370496.0:  # 2^52: a is a whole number, or NaN
        return a
    return math.copysign(float(round(a)), a)


def as_bits(a: Any) -> Any:
    """The 64 bits of a double as a signed integer."""
    if isinstance(a, np.ndarray):
        return a.view(np.int64)
    return _INTEGER.unpack(_DOUBLE.pack(a))[0]


def from_bits(n: Any) -> Any:
    """The double with the 64 bits of an integer."""
    if isinstance(n, np.ndarray):
        return n.view(np.float64)
    return _DOUBLE.unpack((n & _WORD).to_bytes(8, "little"))[0]


def chosen_if(condition: Any, a: Any, b: Any) -> Any:
    """`a` if a condition holds, else `b`: both are computed, and no branch is made."""
    if isinstance(condition, np.ndarray):
        return np.where(condition, a, b)
    return a if condition else b


def larger(a: float, b: float) -> float:
    """The larger of two doubles; the built-in max takes ten times as long to compile."""
    return a if a > b else b


def fence(a: float) -> float:
    """The double itself; the compiler does not reorder or fuse sums and products across it."""
    return a


def bits_set(a: int | np.uint8) -> int:
    """The number of bits set in a byte."""
    return int(a).bit_count()


def lowest_bit(a: np.uint64) -> np.uint64:
    """The index of the lowest bit that is set in a word; the word must not be zero."""
    word = int(a)
    return type(a)((word & -word).bit_length() - 1)
