"""Ctrl-C while a function is compiled: answered as soon as that is done.

LLVM calls back into Python, where an interrupt would be printed, lost, and followed by an error of
numba's own.
"""

import signal
import threading

_depth = 0
_seen = False


def begin():
    """Hold interrupts, if Python's own handler has them; calls nest."""
    global _depth
    if threading.current_thread() is not threading.main_thread():
        return
    if _depth == 0 and signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, _note)
    _depth += 1


def end():
    """Let them through again; raise KeyboardInterrupt if there was one."""
    global _depth, _seen
    if threading.current_thread() is not threading.main_thread():
        return
    _depth -= 1
    if _depth == 0 and signal.getsignal(signal.SIGINT) is _note:
        signal.signal(signal.SIGINT, signal.default_int_handler)
        if _seen:
            _seen = False
            raise KeyboardInterrupt


def _note(number, frame):
    global _seen
    _seen = True
