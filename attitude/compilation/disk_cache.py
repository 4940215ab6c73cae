"""Machine code on disk, invalidated by a change of a source that it is made from."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any

import numba
from numba.core import event
from numba.core.compiler_lock import global_compiler_lock

from attitude.compilation import deferral, notice
from attitude.compilation.source_stamp import stamp_of


class _Undisturbed(event.Listener):
    """Suspend garbage collection and interrupts while a function of the package is compiled.

    `numba.core.event` is documented; if the event "numba:compile" or its entry "dispatcher" change,
    compilations take a tenth longer, and Ctrl-C during one is lost (tests/test_compilation.py).
    """

    def on_start(self, event: Any) -> None:
        if _is_ours(event):
            notice.started()
            deferral.suspend_collection()
            deferral.hold_interrupts()

    def on_end(self, event: Any) -> None:
        if _is_ours(event):
            notice.ended()
            deferral.resume_collection()
            deferral.release_interrupts()


def _is_ours(event: Any) -> bool:
    module: str = event.data["dispatcher"].py_func.__module__
    return module.startswith("attitude.")


event.register("numba:compile", _Undisturbed())

# A fork waits until no other thread compiles: in the child, numba's lock would be held for ever.
if hasattr(os, "register_at_fork"):
    os.register_at_fork(
        before=global_compiler_lock.acquire,
        after_in_parent=global_compiler_lock.release,
        after_in_child=global_compiler_lock.release,
    )


def kept_on_disk(function: Callable[..., Any], options: Mapping[str, Any]) -> Any:
    """numba's dispatcher of a function, whose machine code is kept on disk where possible.

    The function is compiled at its first call.  It is compiled in each process anew if no cache
    folder can be written: neither beside the sources nor in the user's cache folder.
    """
    try:
        dispatcher = numba.njit(cache=True, **options)(function)
    except RuntimeError:  # numba found no folder that it can write
        return numba.njit(**options)(function)
    # Private: Dispatcher._cache, the numba.core.caching.FunctionCache of a function.
    if not is_stamped(getattr(dispatcher, "_cache", None), function):
        return numba.njit(**options)(function)
    return dispatcher


def is_stamped(on_disk: Any, function: Callable[..., Any]) -> bool:
    """Replace the stamp of a numba cache by one of the sources; whether that was possible.

    numba compares a cached function with the time and size of its own file alone, and would run
    machine code that contains callees from before an edit or an upgrade elsewhere.  These names of
    numba are private:
    Cache._cache_file          its IndexDataCacheFile, which writes the stamp into the index
    IndexDataCacheFile._source_stamp   any value that can be pickled, compared by ==
    If one of them is renamed, the caller must keep nothing on disk: slow, but never out of date.
    If the stamp is no longer compared when an index is read, edited sources run old machine code.
    """
    index = getattr(on_disk, "_cache_file", None)
    if index is None or not hasattr(index, "_source_stamp"):
        return False
    index._source_stamp = stamp_of(function)
    _tolerate_errors(on_disk, _installed(on_disk, function))
    return True


def _installed(on_disk: Any, function: Callable[..., Any]) -> Any:
    """The index beside the sources, for users who cannot write there; None if it is in use.

    Whoever installs the package can compile it there for all users.  `Cache.cache_path` is public;
    if the arguments of IndexDataCacheFile change, each user compiles for himself.
    """
    beside = Path(function.__code__.co_filename).parent / "__pycache__"
    index = on_disk._cache_file
    if os.environ.get("NUMBA_CACHE_DIR") or Path(on_disk.cache_path) == beside:
        return None
    with suppress(TypeError, AttributeError):
        base = index._index_name.removesuffix(".nbi")
        return type(index)(str(beside), base, index._source_stamp)
    return None


def _tolerate_errors(on_disk: Any, installed: Any) -> None:
    """Treat an unreadable or unwritable cache as absent; read `installed` after the user's own.

    The dispatcher calls these methods of its Cache, which are private too: `load_overload`, None
    for a function that is not in the cache, `save_overload` and `flush`.  If numba calls others, a
    torn cache file or a full disk stops the program instead.
    """
    load, save = on_disk.load_overload, on_disk.save_overload

    def load_overload(*given: Any) -> Any:
        found = None
        try:
            found = load(*given)
        except Exception:  # a torn file raises any error in pickle; the next process compiles anew
            with suppress(OSError):
                on_disk.flush()
        if found is None and installed is not None:
            own, on_disk._cache_file = on_disk._cache_file, installed
            with suppress(Exception):
                found = load(*given)
            on_disk._cache_file = own
        return found

    def save_overload(*given: Any) -> None:
        with suppress(OSError):
            save(*given)

    on_disk.load_overload, on_disk.save_overload = load_overload, save_overload
