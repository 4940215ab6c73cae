"""The functions of `math` that compiled code uses, with the results of machine code.

They neither raise nor warn: the square root of a negative number is NaN, an exponential that
overflows is infinite.  Results are numpy's doubles, which may be divided by zero.  Functions that
run in Python have this module under the name ``math`` (`decorators.Compilable`).
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, SupportsInt

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Callable


pi = np.float64(math.pi)
inf = np.float64(math.inf)
nan = np.float64(math.nan)
floor = math.floor
ceil = math.ceil


def _of_doubles(function: Callable[..., float]) -> Callable[..., np.float64]:
    """A function of `math` that returns NaN outside of its domain and infinity on overflow."""

    def with_limits(*arguments: float) -> np.float64:
        try:
            return np.float64(function(*arguments))
        except ValueError:
            return nan
        except OverflowError:
            return inf

    with_limits.__name__ = function.__name__
    return with_limits


_sqrt = _of_doubles(math.sqrt)
hypot = _of_doubles(math.hypot)
exp = _of_doubles(math.exp)
expm1 = _of_doubles(math.expm1)
pow = _of_doubles(math.pow)
sin = _of_doubles(math.sin)
cos = _of_doubles(math.cos)
tan = _of_doubles(math.tan)
asin = _of_doubles(math.asin)
atan = _of_doubles(math.atan)
atan2 = _of_doubles(math.atan2)
asinh = _of_doubles(math.asinh)
sinh = _of_doubles(math.sinh)
copysign = _of_doubles(math.copysign)


def sqrt(a: Any) -> Any:
    """The square root, NaN of negative numbers; of arrays element by element."""
    return np.sqrt(a) if isinstance(a, np.ndarray) else _sqrt(a)


def log(a: float) -> np.float64:
    """The natural logarithm: -infinity at zero, NaN below."""
    return np.float64(math.log(a)) if a > 0.0 else (-inf if a == 0.0 else nan)


def ldexp(a: float, exponent: SupportsInt) -> np.float64:
    """a 2^exponent, for an exponent of any integer type; infinite on overflow."""
    try:
        return np.float64(math.ldexp(a, int(exponent)))
    except OverflowError:
        return copysign(inf, a)


def frexp(a: float) -> tuple[np.float64, int]:
    """Fraction in [1/2, 1) and exponent of 2."""
    fraction, exponent = math.frexp(a)
    return np.float64(fraction), exponent
