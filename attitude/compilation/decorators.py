"""How functions on numbers and arrays are compiled, or run in Python where compilation is off.

Two families.  `entry_point`, `subroutine` and `force_inlined` set no fastmath flag: error-free
transforms rest on the order of every operation, and results are the same bits whether an epoch is
evaluated alone, in an array or in a block of one; a product and a sum are fused only where `fma`
says so.  `reduction` and its kin are for sums over facets: terms may be taken in any order,
products and sums may be fused, NaN and infinity keep their meaning; the last digits then depend on
the machine's instructions, but not on blocks or threads.

numba is imported when the first entry point is called.  ``ATTITUDE_COMPILE=never``, or numba's own
``NUMBA_DISABLE_JIT=1``, runs everything in Python instead: some thousand times slower, for
debuggers and coverage.
"""

import os
import threading
from types import FunctionType

import numpy as np

from attitude.compilation import ieee

# Nothing is called through C.
_EXACT = {"nogil": True, "error_model": "numpy", "no_cfunc_wrapper": True}
_ANY_ORDER = {
    "nogil": True,
    "error_model": "numpy",
    "fastmath": {"reassoc", "contract", "arcp", "nsz"},
}
# Called from compiled code only: the machine code is part of the caller's cache entry, and leaving
# out the entry from Python halves the time to compile.
_INNER = {"no_cpython_wrapper": True}

_lock = threading.RLock()


def runs_uncompiled():
    """Whether compilation is switched off for this process, read from the environment."""
    if os.environ.get("NUMBA_DISABLE_JIT", "0") not in ("", "0"):
        return True
    return os.environ.get("ATTITUDE_COMPILE", "") == "never"


UNCOMPILED = runs_uncompiled()


class Compilable:
    """A function of numbers and arrays that numba can compile.

    Called from Python, it runs in Python; compiled code that names it calls its machine code.

    Parameters
    ----------
    python : function
    options : dict
        Of `numba.njit`.
    kept : bool
        Whether the machine code is kept on disk.
    """

    def __init__(self, python, options, kept=False):
        self.py_func = python
        self.targetoptions = options
        self._kept = kept
        self._dispatcher = self._python = None
        self.__name__, self.__doc__ = python.__name__, python.__doc__
        self.__module__, self.__qualname__ = python.__module__, python.__qualname__
        self.__wrapped__ = python

    def __call__(self, *arguments):
        if self._python is None:
            self._python = _with_ieee_math(self.py_func)
        return self._python(*arguments)

    def __repr__(self):
        return f"<{type(self).__name__} {self.__module__}.{self.__name__}>"

    def __reduce__(self):
        # By name, as functions are pickled: numba's cache tells closures apart by the hash of that.
        return self.__qualname__

    @property
    def dispatcher(self):
        """numba's dispatcher of the function, made when first asked for."""
        if self._dispatcher is None:
            with _lock:
                if self._dispatcher is None:
                    from attitude.compilation import lowering

                    self._dispatcher = lowering.dispatcher(
                        self.py_func, self.targetoptions, self._kept
                    )
        return self._dispatcher

    @property
    def _numba_type_(self):
        # What numba asks of a global that it does not know: the type of the dispatcher.
        return self.dispatcher._numba_type_


class EntryPoint(Compilable):
    """A `Compilable` that is compiled at the first call from Python for each set of types."""

    def __init__(self, python, options, kept=True):
        super().__init__(python, options, kept)
        self._run = self._in_python if UNCOMPILED else self._first

    def __call__(self, *arguments):
        return self._run(*arguments)

    def _first(self, *arguments):
        self._run = self.dispatcher
        return self._run(*arguments)

    def _in_python(self, *arguments):
        # Compiled code divides by zero and overflows without a word.
        with np.errstate(all="ignore"):
            return super().__call__(*map(_with_fields, arguments))


def _with_ieee_math(function):
    """The function with `ieee` in the place of `math`."""
    names = {**function.__globals__, "math": ieee}
    return FunctionType(
        function.__code__, names, function.__name__, function.__defaults__, function.__closure__
    )


def _with_fields(argument):
    """Structured arrays and their elements with fields as attributes, as in compiled code."""
    if isinstance(argument, np.ndarray) and argument.dtype.names:
        return argument.view(np.recarray)
    if isinstance(argument, np.void) and not isinstance(argument, np.record):
        # an element is a view of its array: so is this one
        return argument.view((np.record, argument.dtype))
    return argument


def entry_point(function):
    """Compile at the first call from Python, and keep the machine code on disk."""
    return EntryPoint(function, _EXACT)


def inlined_entry_point(function):
    """As `entry_point`; where compiled code calls it, it is inlined.

    Left apart from a compiled caller, the process that compiles the two would run a copy of the
    loop that was made before its own callees were known, and which is not vectorised.
    """
    return EntryPoint(function, {**_EXACT, "forceinline": True})


def subroutine(function):
    """For functions that are called from compiled code only; LLVM decides whether to inline."""
    return Compilable(function, {**_EXACT, **_INNER})


def force_inlined(function):
    """As `subroutine`, inlined whatever its length: for long code called once in a loop."""
    return Compilable(function, {**_EXACT, **_INNER, "forceinline": True})


def reduction(function):
    """As `entry_point`, where sums may be taken in any order."""
    return EntryPoint(function, _ANY_ORDER)


def reduction_over(*called):
    """As `reduction`, for a closure over compilable functions, whose machine code is part of it.

    It is kept on disk if all of them are the package's own: an edit of others would not be seen.
    """
    own = __name__.partition(".")[0]
    kept = all(each.__module__.partition(".")[0] == own for each in called)
    return lambda function: EntryPoint(function, _ANY_ORDER, kept)


def reduction_subroutine(function):
    """As `reduction`, called from compiled code only, as a function of its own."""
    return Compilable(function, {**_ANY_ORDER, **_INNER, "no_cfunc_wrapper": True})


def reduction_inlined(function):
    """As `reduction`, copied into its callers before their types are known.

    A loop that calls anything is not vectorised, a factor of six.
    """
    return Compilable(function, {**_ANY_ORDER, "inline": "always"})
