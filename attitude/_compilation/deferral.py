"""Suspend garbage collection and Ctrl-C while a function is compiled.

Importing a compiler and compiling allocate many objects that stay; collecting garbage meanwhile
takes a tenth of the time and finds nothing.  LLVM calls back into Python, where a KeyboardInterrupt
would be printed and lost, and followed by an error of numba's own.
"""

from __future__ import annotations

import gc
import os
import signal
import threading
from contextlib import contextmanager
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterator
    from types import FrameType


@contextmanager
def uncollected() -> Iterator[None]:
    """Suspend cyclic garbage collection; re-entrant and thread-safe."""
    suspend_collection()
    try:
        yield
    finally:
        resume_collection()


_lock = threading.Lock()
_suspensions = 0
_was_enabled = False


def suspend_collection() -> None:
    """Suspend cyclic garbage collection until as many calls of `resume_collection`."""
    global _suspensions, _was_enabled
    with _lock:
        if _suspensions == 0:
            _was_enabled = gc.isenabled()
            gc.disable()
        _suspensions += 1


def resume_collection() -> None:
    """Undo one `suspend_collection`."""
    global _suspensions
    with _lock:
        _suspensions = max(0, _suspensions - 1)
        if _suspensions == 0 and _was_enabled:
            gc.enable()


def _after_fork() -> None:
    """In a forked process, undo the suspensions of the other threads, which do not live there."""
    global _lock, _suspensions
    _lock = threading.Lock()
    if _suspensions:
        _suspensions = 0
        if _was_enabled:
            gc.enable()


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_after_fork)


_holds = 0
_interrupted = False


def hold_interrupts() -> None:
    """Defer Ctrl-C in the main thread, under Python's handler, until as many releases."""
    global _holds
    if threading.current_thread() is not threading.main_thread():
        return
    if _holds == 0 and signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, _record_interrupt)
    _holds += 1


def release_interrupts() -> None:
    """Undo one `hold_interrupts`; the last one raises a KeyboardInterrupt that was deferred."""
    global _holds, _interrupted
    if threading.current_thread() is not threading.main_thread():
        return
    _holds -= 1
    if _holds == 0 and signal.getsignal(signal.SIGINT) is _record_interrupt:
        signal.signal(signal.SIGINT, signal.default_int_handler)
        if _interrupted:
            _interrupted = False
            raise KeyboardInterrupt


def _record_interrupt(number: int, frame: FrameType | None) -> None:
    global _interrupted
    _interrupted = True
