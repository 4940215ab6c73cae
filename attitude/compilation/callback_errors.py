"""Exceptions that leave a C callback: kept, and raised again after the loop that called it.

Python and numba give such an exception to ``sys.unraisablehook``, which prints it, and the loop
goes on.  That can be any exception: a KeyboardInterrupt is raised at the entry of a Python
callback, before a ``try`` in it.
"""

from __future__ import annotations

import os
import sys
import threading
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator


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
