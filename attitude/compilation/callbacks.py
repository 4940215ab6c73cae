"""C functions that compiled loops call by address: torques of the package and of users.

Each is void f(double t, double *wxyz, double *omega, double *given, double *parameters,
double *out); see `solution.torqued_step`.
"""

from __future__ import annotations

import ctypes
from contextlib import suppress
from typing import TYPE_CHECKING, Any

from attitude.compilation.decorators import UNCOMPILED
from attitude.compilation.pointers import C_FUNCTION, vector
from attitude.errors import AttitudeError

if TYPE_CHECKING:
    from collections.abc import Callable

# Of LLVM's fastmath flags those with which sums may be taken in any order.
_SUMS = {"reassoc", "contract", "nsz"}
# Attribute of a user's compiled function that holds its Callback.
_ATTRIBUTE = "_attitude_callback"


class Callback:
    """A C function, compiled at the first use of its address.

    Parameters
    ----------
    python : function
        Of the six arguments of `pointers.C_FUNCTION`.
    fastmath : bool or set
        The argument of `numba.cfunc`.
    kept : bool
        Whether the machine code is kept on disk.
    """

    def __init__(
        self, python: Callable[..., None], fastmath: bool | set[str] = False, kept: bool = True
    ) -> None:
        self.py_func = python
        self._fastmath, self._kept = fastmath, kept
        self._function: Any = None
        self.__doc__, self.__name__ = python.__doc__, python.__name__
        self.__module__, self.__wrapped__ = python.__module__, python

    @property
    def address(self) -> int:
        """The address of the C function, valid as long as this object lives."""
        if self._function is None:
            self._function = self._compiled()
        if UNCOMPILED:
            found = ctypes.cast(self._function, ctypes.c_void_p).value
            assert found is not None
            return found
        return int(self._function.address)

    def _compiled(self) -> Any:
        if UNCOMPILED:
            return C_FUNCTION(self.py_func)
        from attitude.compilation import lowering

        return lowering.c_function(self.py_func, self._fastmath, self._kept)


def callback(function: Callable[..., None]) -> Callback:
    """The C function of a Python function; its machine code is kept on disk where possible."""
    return Callback(function)


def reduction_callback(function: Callable[..., None]) -> Callback:
    """As `callback`, where sums may be taken in any order."""
    return Callback(function, fastmath=_SUMS)


def is_compiled(function: object) -> bool:
    """Whether a user's function is a dispatcher of numba."""
    return hasattr(function, "py_func")


def callback_of(function: Callable[..., Any]) -> Callback:
    """The C function that calls a user's compiled function of (t, wxyz, omega).

    It is kept as an attribute of the function: compiled once, and freed with the function.
    """
    made: Callback | None = getattr(function, _ATTRIBUTE, None)
    if made is not None:
        return made

    def torque(t, wxyz, omega, given, parameters, out):
        found = function(t, vector(wxyz, 4), vector(omega, 3))
        if len(found) != 3:
            raise AttitudeError(
                "the function of a CustomTorque did not return three numbers; it must return a "
                "torque in N m over the body axes at all epochs."
            )
        out[0], out[1], out[2] = found[0], found[1], found[2]

    made = Callback(torque, kept=False)
    with suppress(AttributeError, TypeError):  # an object that takes no attributes
        setattr(function, _ATTRIBUTE, made)
    return made
