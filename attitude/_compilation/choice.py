"""Whether a call of an entry point runs in Python: where its work is small, as long as that pays.

Importing the compiler and loading machine code from the disk takes half a second, compiling takes
seconds; one epoch in Python takes 0.2 ms, one body some milliseconds.  Small calls therefore run in
Python, with the same bits: where machine code is on the disk, until the process has spent as long
on them as loading would have taken; where it is not, each function until it has taken as long as
its compilation.  That never takes more than about twice the time of the better choice, and a
function that takes little of a process is not compiled for those that take much.  Calls that repeat
will go on, and machine code serves all later processes: after each `REPEATS` calls of a function,
its seconds count once more.

Functions that run between every two calls of another one are steps of one call, which is as fast as
its slowest step: set-up follows the loop.  Where such a call repeats, all of its steps compile once
they would exceed `STEADY` seconds together; and where a loop has run as machine code `REPEATS`
times while the steps beside it took longer in Python, these compile too (`decorators.EntryPoint`).
``ATTITUDE_COMPILE=always`` compiles at the first call, ``never`` does not compile;
``automatic`` is the default.
"""

from __future__ import annotations

import os
import sys
import threading
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from time import thread_time
from typing import Final

# Processor seconds, measured on an AMD EPYC (benchmarks/first_use.py): importing numba and loading
# the loops of a propagation, and compiling one function, most of which take 0.3 to 2 s.
TO_LOAD: Final = 0.5
TO_COMPILE: Final = 1.0
# The same of one short loop (0.1 to 0.45 s), and of one function of derivatives: setup, or columns
# of one form.
TO_COMPILE_SHORT: Final = 0.3
TO_COMPILE_DERIVATIVES: Final = 5.0
# Calls of a function after which its seconds in Python count twice, thrice, ...
REPEATS: Final = 10
# Seconds that the steps of a call take in Python, with those of the next call, and calls, beyond
# which all of them compile: the intervals between three calls tell what is a step.
STEADY: Final = 0.8
STEADY_CALLS: Final = 2


def mode() -> str:
    """ "always", "never" or "automatic", by the environment variables of the process."""
    if os.environ.get("NUMBA_DISABLE_JIT", "0") not in ("", "0"):
        return "never"
    setting = os.environ.get("ATTITUDE_COMPILE", "") or "automatic"
    if setting in ("always", "never", "automatic"):
        return setting
    from attitude.errors import AttitudeWarning

    warnings.warn(
        f'ATTITUDE_COMPILE is {setting!r}, and taken as "automatic"; give "always" or "never".',
        AttitudeWarning,
        stacklevel=2,
    )
    return "automatic"


MODE: Final = mode()
# Processor seconds that small calls have taken in Python.
_spent = 0.0
_running = threading.local()
# Blocks of `compiling` that are active.
_forced = 0


def is_worth_python(
    predicted: float,
    kept: bool,
    spent: float = 0.0,
    to_compile: float = TO_COMPILE,
    calls: int = 0,
    steps: float = 0.0,
) -> bool:
    """Whether a call of a function that takes `predicted` seconds in Python is to run there.

    If no machine code is `kept` on the disk, compiling takes `to_compile` s.  `spent` are the
    seconds that the `calls` before have taken in Python, `steps` those of all steps of the call
    that repeats, with those of the next one (infinite for a step of one that is compiled).
    """
    if _forced:
        return False
    if getattr(_running, "depth", 0) > 0:
        # The arguments of nested calls have the types of Python, for which nothing is compiled.
        return True
    if calls >= STEADY_CALLS and steps >= STEADY:
        return False
    repeated = 1.0 + calls / REPEATS
    if kept:
        seconds = max(_spent, spent * repeated) + predicted
        return "numba" not in sys.modules and seconds <= TO_LOAD
    return spent * repeated + predicted <= to_compile


@contextmanager
def compiling() -> Iterator[None]:
    """Compile every entry point that is called meanwhile, in all threads."""
    global _forced
    _forced += 1
    try:
        yield
    finally:
        _forced -= 1


def spent() -> float:
    """Processor seconds that the process has spent on small calls in Python."""
    return _spent


class InPython:
    """A context in which a call runs in Python; its seconds are added to `spent`."""

    def __init__(self, seconds: float = 0.0) -> None:
        self.seconds = seconds

    def __enter__(self) -> InPython:
        _running.depth = getattr(_running, "depth", 0) + 1
        self._begin = thread_time()
        return self

    def __exit__(self, *raised: object) -> None:
        global _spent
        self.seconds = thread_time() - self._begin
        _running.depth -= 1
        if not _running.depth:
            _spent += self.seconds
