"""Machine code on disk that is never older than the sources it was made from."""

import gc
import hashlib
from functools import cache
from pathlib import Path

import numba
from numba.core import event


class _Uncollected(event.Listener):
    """Keeps the garbage collector from a compilation, of which it takes a tenth and finds nothing.

    Numba compiles under a lock, one function within another.
    """

    def __init__(self):
        self._depth = 0
        self._was_enabled = False

    def on_start(self, event):
        if self._depth == 0:
            self._was_enabled = gc.isenabled()
            gc.disable()
        self._depth += 1

    def on_end(self, event):
        self._depth -= 1
        if self._depth == 0 and self._was_enabled:
            gc.enable()


event.register("numba:compile", _Uncollected())


def kept_on_disk(function, options):
    """Compile a function at its first call and keep the machine code for the next process.

    An installation that cannot be written, with no home directory either, has no place for the
    cache; the function is then compiled anew in each process.
    """
    try:
        dispatcher = numba.njit(cache=True, **options)(function)
    except RuntimeError:
        return numba.njit(**options)(function)
    # Numba looks for changes in the file of the function alone, and would go on running what it
    # called before an edit or an upgrade elsewhere: here every file of the package counts.
    file = getattr(getattr(dispatcher, "_cache", None), "_cache_file", None)
    if hasattr(file, "_source_stamp"):
        file._source_stamp = (file._source_stamp, _stamp())
    return dispatcher


@cache
def _stamp():
    """Names, sizes and times of change of the package's sources, in short."""
    package = Path(__file__).parent.parent
    found = hashlib.sha256()
    for source in sorted(package.rglob("*.py")):
        status = source.stat()
        found.update(f"{source.name} {status.st_size} {status.st_mtime_ns}\n".encode())
    return found.hexdigest()
