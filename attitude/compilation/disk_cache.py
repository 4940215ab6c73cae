"""Machine code on disk that is never older than the sources it was made from."""

import hashlib
from contextlib import suppress
from functools import cache
from pathlib import Path

import numba
from numba.core import event

from attitude.compilation import deferral


class _Undisturbed(event.Listener):
    """No garbage collection and no interrupt while a function of the package is compiled."""

    def on_start(self, event):
        if _is_ours(event):
            deferral.suspend_collection()
            deferral.hold_interrupts()

    def on_end(self, event):
        if _is_ours(event):
            deferral.resume_collection()
            deferral.release_interrupts()


def _is_ours(event):
    return event.data["dispatcher"].py_func.__module__.startswith("attitude.")


event.register("numba:compile", _Undisturbed())


def kept_on_disk(function, options):
    """Compile a function at its first call and keep the machine code for the next process.

    An installation that cannot be written, with no home directory either, has no place for the
    cache, nor has a full disk; the function is then compiled anew in each process.
    """
    try:
        dispatcher = numba.njit(cache=True, **options)(function)
    except RuntimeError:
        return numba.njit(**options)(function)
    # Numba looks for changes in the file of the function alone, and would go on running what it
    # called before an edit or an upgrade elsewhere: here every file of the package counts.
    kept = getattr(dispatcher, "_cache", None)
    file = getattr(kept, "_cache_file", None)
    if hasattr(file, "_source_stamp"):
        file._source_stamp = (file._source_stamp, _stamp())
        _never_fail(kept)
    return dispatcher


def _never_fail(kept):
    """A cache that cannot be read or written is none, and no reason to stop."""
    load, save = kept.load_overload, kept.save_overload

    def load_overload(*given):
        try:
            return load(*given)
        except Exception:  # what a torn file makes of pickle; the next process begins anew
            with suppress(OSError):
                kept.flush()
            return None

    def save_overload(*given):
        with suppress(OSError):
            save(*given)

    kept.load_overload, kept.save_overload = load_overload, save_overload


@cache
def _stamp():
    """Names, sizes and times of change of the package's sources, in short."""
    package = Path(__file__).parent.parent
    found = hashlib.sha256()
    for source in sorted(package.rglob("*.py")):
        status = source.stat()
        found.update(
            f"{source.relative_to(package)} {status.st_size} {status.st_mtime_ns}\n".encode()
        )
    return found.hexdigest()
