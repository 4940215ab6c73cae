"""Four or eight doubles as one value: vector arithmetic where the compiler would not find it.

A short loop is unrolled before it could be vectorised, and a formula at eight places is eight
formulas.  Here the eight are one value of the machine's vector type (eight: one AVX-512 register,
two of AVX2, four of NEON) that compiled code adds, multiplies and divides with the usual operators,
with doubles on either side; `instructions.fma` takes them too.  Products and sums are fused where
the caller is compiled so (`decorators.reduction`), and only there.

The functions below define them in Python; `simd_lowering` has the vector instructions.
"""

import math

from attitude.compilation.instructions import fma


class Lanes:
    """Some doubles as one value, in Python."""

    __slots__ = ("lanes",)

    def __init__(self, numbers):
        self.lanes = tuple(map(float, numbers))

    def _with(self, other, function):
        return Lanes(map(function, self.lanes, _spread(other, len(self.lanes))))

    def __add__(self, other):
        return self._with(other, lambda a, b: a + b)

    def __radd__(self, other):
        return self._with(other, lambda a, b: b + a)

    def __sub__(self, other):
        return self._with(other, lambda a, b: a - b)

    def __rsub__(self, other):
        return self._with(other, lambda a, b: b - a)

    def __mul__(self, other):
        return self._with(other, lambda a, b: a * b)

    __rmul__ = __mul__

    def __truediv__(self, other):
        return self._with(other, _quotient)

    def __rtruediv__(self, other):
        return self._with(other, lambda a, b: _quotient(b, a))

    @staticmethod
    def fused(*three):
        """The fused product and sum of vectors and doubles."""
        count = next(len(each.lanes) for each in three if isinstance(each, Lanes))
        return Lanes(map(fma, *(_spread(each, count) for each in three)))


def _spread(x, count):
    return x.lanes if isinstance(x, Lanes) else (float(x),) * count


def _quotient(a, b):
    if b != 0.0:
        return a / b
    return math.nan if a == 0.0 or a != a else math.copysign(math.inf, a) * math.copysign(1.0, b)


def eight(array, i):
    """Eight neighbours array[i], ..., array[i + 7] of a contiguous array of doubles."""
    i = int(i)
    return Lanes(array[i : i + 8])


def lanes(numbers):
    """Doubles of a tuple, one to a lane."""
    return Lanes(numbers)


def bits_set_in_bytes(word):
    """How many bits are set in each of the eight bytes of a word, the lowest first."""
    return Lanes(each.bit_count() for each in int(word).to_bytes(8, "little"))


def at_least(a, least):
    """The larger of two, lane by lane."""
    return a._with(least, lambda x, y: x if x > y else y)


def root(a):
    """The square root of each."""
    return Lanes(math.nan if x < 0.0 else math.sqrt(x) for x in a.lanes)


def summed_up(a):
    """The sum of all, in halves."""
    left = a.lanes
    while len(left) > 1:
        half = len(left) // 2
        left = [left[k] + left[half + k] for k in range(half)]
    return left[0]
