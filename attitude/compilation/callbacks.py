"""C functions that compiled loops call by address: torques, ours and those that users write.

Each is void f(double t, double *wxyz, double *omega, double *given, double *parameters,
double *out); see `solution.march`.
"""

import ctypes
import math

from attitude.compilation.decorators import UNCOMPILED
from attitude.compilation.pointers import C_FUNCTION, vector

_SUMS = {"reassoc", "contract", "nsz"}


class Callback:
    """A C function, compiled when its address is first asked for.

    Parameters
    ----------
    python : function
    fastmath : bool or set
        Of `numba.cfunc`.
    kept : bool
        Whether the machine code is kept on disk.
    """

    def __init__(self, python, fastmath=False, kept=True):
        self.py_func = python
        self._fastmath, self._kept = fastmath, kept
        self._function = None
        self.__doc__, self.__name__ = python.__doc__, python.__name__
        self.__module__, self.__wrapped__ = python.__module__, python

    @property
    def address(self):
        """Of the C function; this object keeps it alive."""
        if self._function is None:
            self._function = self._made()
        if UNCOMPILED:
            return ctypes.cast(self._function, ctypes.c_void_p).value
        return self._function.address

    def _made(self):
        if UNCOMPILED:
            return C_FUNCTION(self.py_func)
        from attitude.compilation import lowering

        return lowering.c_function(self.py_func, self._fastmath, self._kept)


def callback(function):
    """The C function of a Python one, kept on disk where that is possible."""
    return Callback(function)


def reduction_callback(function):
    """As `callback`, where sums may be taken in any order."""
    return Callback(function, fastmath=_SUMS)


def is_compiled(function):
    """Whether a user's function is one of numba's."""
    return hasattr(function, "py_func")


def callback_of(function):
    """The C function that calls a user's compiled function of (t, wxyz, omega)."""

    def torque(t, wxyz, omega, given, parameters, out):
        # What a function that raises leaves here: numba prints the error, and goes on.
        out[0] = out[1] = out[2] = math.nan
        found = function(t, vector(wxyz, 4), vector(omega, 3))
        if len(found) == 3:
            out[0], out[1], out[2] = found[0], found[1], found[2]

    return Callback(torque, kept=False)
