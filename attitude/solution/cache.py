"""Machine code on disk that is never older than the sources it was made from."""

import hashlib
from functools import cache
from pathlib import Path

import numba
from numba.core import event

from attitude.solution import uncollected


class _Uncollected(event.Listener):
    def on_start(self, event):
        uncollected.begin()

    def on_end(self, event):
        uncollected.end()


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
