"""What is put off while a function is compiled: garbage collection and Ctrl-C.

Imports of a compiler and compilations make many objects that stay; collecting garbage meanwhile
takes a tenth of the time and finds nothing.  LLVM calls back into Python, where an interrupt would
be printed, lost, and followed by an error of numba's own.
"""

import gc
import signal
import threading
from contextlib import contextmanager


@contextmanager
def uncollected():
    """Suspend cyclic garbage collection; re-entrant and thread-safe."""
    suspend_collection()
    try:
        yield
    finally:
        resume_collection()


_lock = threading.Lock()
_collections = 0
_was_enabled = False


def suspend_collection():
    """Suspend cyclic garbage collection until as many calls of `resume_collection`."""
    global _collections, _was_enabled
    with _lock:
        if _collections == 0:
            _was_enabled = gc.isenabled()
            gc.disable()
        _collections += 1


def resume_collection():
    """Undo one `suspend_collection`."""
    global _collections
    with _lock:
        _collections -= 1
        if _collections == 0 and _was_enabled:
            gc.enable()


_interrupts = 0
_seen = False


def hold_interrupts():
    """Hold Ctrl-C until as many calls of `release_interrupts`.

    Only in the main thread, and only where Python's own handler is installed.
    """
    global _interrupts
    if threading.current_thread() is not threading.main_thread():
        return
    if _interrupts == 0 and signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, _note)
    _interrupts += 1


def release_interrupts():
    """Undo one `hold_interrupts`; raise the KeyboardInterrupt that was held, if any."""
    global _interrupts, _seen
    if threading.current_thread() is not threading.main_thread():
        return
    _interrupts -= 1
    if _interrupts == 0 and signal.getsignal(signal.SIGINT) is _note:
        signal.signal(signal.SIGINT, signal.default_int_handler)
        if _seen:
            _seen = False
            raise KeyboardInterrupt


def _note(number, frame):
    global _seen
    _seen = True
