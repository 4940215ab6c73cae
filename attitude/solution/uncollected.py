"""Making many objects that stay, without the garbage collector looking through them again."""

import gc
import threading
from contextlib import contextmanager

_lock = threading.Lock()
_depth = 0
_was_enabled = False


@contextmanager
def uncollected():
    """The collector waits inside; any number of these may be nested, in several threads.

    Of the import of a compiler and of a compilation it takes a tenth, and finds nothing.
    """
    begin()
    try:
        yield
    finally:
        end()


def begin():
    """What `uncollected` does first."""
    global _depth, _was_enabled
    with _lock:
        if _depth == 0:
            _was_enabled = gc.isenabled()
            gc.disable()
        _depth += 1


def end():
    """What `uncollected` does last."""
    global _depth
    with _lock:
        _depth -= 1
        if _depth == 0 and _was_enabled:
            gc.enable()
