"""C functions that compiled loops call by address, and the exceptions that leave them.

Each is void f(double t, double *wxyz, double *omega, double *given, double *parameters,
double *out); see `attitude._solver.torqued_step`.
"""

from __future__ import annotations

import ctypes
import os
import sys
import threading
from contextlib import contextmanager, suppress
from typing import TYPE_CHECKING, Any

from attitude._compilation.decorators import UNCOMPILED
from attitude._compilation.pointers import C_FUNCTION, vector
from attitude.errors import AttitudeError

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator


# ---- Exceptions that leave a C callback: kept, and raised again after the loop that called it
# Python and numba give such an exception to ``sys.unraisablehook``, which prints it, and the loop
# goes on.  That can be any exception: a KeyboardInterrupt is raised at the entry of a Python
# callback, before a ``try`` in it.


class _Calls(threading.local):
    """For each call of `raising_callback_errors` of a thread, the exceptions kept so far."""

    def __init__(self) -> None:
        self.kept: list[list[BaseException]] = []


_calls = _Calls()
# Re-entrant: a signal handler may run while the lock is held.
_lock = threading.RLock()
_users: set[int] = set()
_previous: Callable[[Any], Any] = sys.unraisablehook


@contextmanager
def raising_callback_errors() -> Iterator[None]:
    """Raise the first exception that left a callback of this thread, at the end of the block.

    Re-entrant and thread-safe.  `sys.unraisablehook` is replaced meanwhile; it still receives all
    other errors, such as those of finalizers.
    """
    kept: list[BaseException] = []
    depth = len(_calls.kept)
    try:
        _calls.kept.append(kept)
        _install(id(kept))
        yield
    finally:
        _uninstall(id(kept))
        del _calls.kept[depth:]
        if kept:
            raise kept[0]


def _install(user: int) -> None:
    global _previous
    with _lock:
        _users.add(user)
        if sys.unraisablehook is not _keep:
            _previous, sys.unraisablehook = sys.unraisablehook, _keep


def _uninstall(user: int) -> None:
    with _lock:
        _users.discard(user)
        if not _users and sys.unraisablehook is _keep:
            sys.unraisablehook = _previous


def _keep(unraisable: Any) -> None:
    if not _calls.kept or not _left_a_callback(unraisable):
        _previous(unraisable)
        return
    error = unraisable.exc_value
    _calls.kept[-1].append(unraisable.exc_type() if error is None else error)


def _left_a_callback(unraisable: Any) -> bool:
    """Whether an exception left a callback, or is an interrupt, which must never be lost."""
    if isinstance(unraisable.object, str):  # numba passes the name of the C function
        return True
    if "ctypes callback" in (unraisable.err_msg or ""):
        return True
    return not issubclass(unraisable.exc_type, Exception)


def _after_fork() -> None:
    """In a forked process only the forking thread lives, and no other holds the lock."""
    global _lock
    _lock = threading.RLock()
    _users.intersection_update(map(id, _calls.kept))


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_after_fork)


# Of LLVM's fastmath flags those with which sums may be taken in any order.
_SUMS = {"reassoc", "contract", "nsz"}
# Attribute of a user's compiled function that holds its Callback.
_ATTRIBUTE = "_attitude_callback"


class Callback:
    """A C function with the arguments of `C_FUNCTION`, compiled at the first use of its address.

    fastmath is the argument of `numba.cfunc`; machine code is `kept` on disk.
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
            pointer = ctypes.cast(self._function, ctypes.c_void_p).value
            assert pointer is not None
            return pointer
        return int(self._function.address)

    def _compiled(self) -> Any:
        if UNCOMPILED:
            return C_FUNCTION(self.py_func)
        from attitude._compilation import lowering

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
    """The C function of a user's compiled function of (t, wxyz, omega), kept as its attribute.

    Its first parameter is added to the time.
    """
    callback: Callback | None = getattr(function, _ATTRIBUTE, None)
    if callback is not None:
        return callback

    def torque(t, wxyz, omega, samples, parameters, out):
        components = function(t + vector(parameters, 1)[0], vector(wxyz, 4), vector(omega, 3))
        if len(components) != 3:
            raise AttitudeError(
                "the function of a CustomTorque did not return three numbers; it must return a "
                "torque in N m over the body axes at all epochs."
            )
        out[0], out[1], out[2] = components[0], components[1], components[2]

    callback = Callback(torque, kept=False)
    with suppress(AttributeError, TypeError):  # an object that takes no attributes
        setattr(function, _ATTRIBUTE, callback)
    return callback
