"""The functions of `math` that compiled code uses, as machine code has them.

They neither raise nor warn: a root of a negative number is NaN, an exponential that is too large
infinite.  Results are numpy's doubles, which may be divided by zero.  Functions that run in Python
find these under the name ``math`` (`decorators.Compilable`).
"""

import math

import numpy as np

pi, inf, nan = np.float64(math.pi), np.float64(math.inf), np.float64(math.nan)
floor, ceil = math.floor, math.ceil


def _of_doubles(function):
    """The same function with NaN outside of its domain and infinity where it overflows."""

    def with_limits(*given):
        try:
            return np.float64(function(*given))
        except ValueError:
            return nan
        except OverflowError:
            return inf

    with_limits.__name__ = function.__name__
    return with_limits


sqrt, hypot = _of_doubles(math.sqrt), _of_doubles(math.hypot)
exp, expm1, pow = _of_doubles(math.exp), _of_doubles(math.expm1), _of_doubles(math.pow)
sin, cos, tan = _of_doubles(math.sin), _of_doubles(math.cos), _of_doubles(math.tan)
atan, atan2, asinh = _of_doubles(math.atan), _of_doubles(math.atan2), _of_doubles(math.asinh)
sinh, copysign = _of_doubles(math.sinh), _of_doubles(math.copysign)


def log(a):
    """-infinity at zero, NaN below."""
    return np.float64(math.log(a)) if a > 0.0 else (-inf if a == 0.0 else nan)


def ldexp(a, exponent):
    """a 2^exponent; whole numbers of any type."""
    try:
        return np.float64(math.ldexp(a, int(exponent)))
    except OverflowError:
        return copysign(inf, a)


def frexp(a):
    """Fraction and exponent."""
    fraction, exponent = math.frexp(a)
    return np.float64(fraction), exponent
