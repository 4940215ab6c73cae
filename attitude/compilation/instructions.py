"""Machine instructions that Python has no name for, each defined here in Python.

`attitude.compilation.lowering` gives compiled code the one instruction; both return the same bits.
"""

import math
import struct
from fractions import Fraction

_DOUBLE, _INTEGER = struct.Struct("<d"), struct.Struct("<q")
_WORD = (1 << 64) - 1
# Within these bounds the products and sums of `_fma` neither overflow nor lose a bit to underflow.
_SMALL, _LARGE = 1e-130, 1e130
_SPLITTER = 134217729.0  # 2^27 + 1


def fma(a, b, c):
    """a b + c, rounded once; of doubles, and of SIMD vectors with doubles among them."""
    if type(a) is type(b) is type(c) is float:
        return _fma(a, b, c)
    for each in (a, b, c):
        if hasattr(each, "lanes"):
            return each.fused(a, b, c)
    return _fma(float(a), float(b), float(c))


if hasattr(math, "fma"):

    def _fma(a, b, c):
        try:
            return math.fma(a, b, c)
        except (OverflowError, ValueError):
            return a * b + c  # inf - inf, 0 inf, or beyond all doubles

else:

    def _fma(a, b, c):
        """By error-free transforms and one sum rounded to odd.

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
        part = t - c
        t_low = (c - (t - part)) + (e - part)
        v = p + t
        part = v - p
        v_low = (p - (v - part)) + (t - part)
        z = t_low + v_low
        part = z - t_low
        left = (t_low - (z - part)) + (v_low - part)
        if left != 0.0 and not _INTEGER.unpack(_DOUBLE.pack(z))[0] & 1:
            z = math.nextafter(z, math.inf if left > 0.0 else -math.inf)
        return v + z


def _fma_of_any(a, b, c):
    """Of any doubles, by whole numbers; slow."""
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


def rint(a):
    """The nearest whole number, ties to even."""
    if not abs(a) < 4503599627370496.0:  # whole already, or NaN
        return a
    return math.copysign(float(round(a)), a)


def as_bits(a):
    """The 64 bits of a double as a signed whole number."""
    return _INTEGER.unpack(_DOUBLE.pack(a))[0]


def from_bits(n):
    """The double that has these 64 bits."""
    return _DOUBLE.unpack((n & _WORD).to_bytes(8, "little"))[0]


def larger(a, b):
    """The larger of two doubles; the builtin max takes ten times as long to compile."""
    return a if a > b else b


def fence(a):
    """The double itself, as a value across which no sum or product is taken in another order."""
    return a


def bits_set(a):
    """How many bits of a byte are set."""
    return int(a).bit_count()


def lowest_bit(a):
    """The place of the lowest bit that is set in a word that is not zero."""
    word = int(a)
    return type(a)((word & -word).bit_length() - 1)
