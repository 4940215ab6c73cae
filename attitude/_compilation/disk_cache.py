"""Machine code on disk, invalidated by a change of a source that it is made from."""

from __future__ import annotations

import hashlib
import os
import re
import sys
import time
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import suppress
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import llvmlite
import numba
from numba.core import event
from numba.core.compiler_lock import global_compiler_lock

from attitude._compilation import deferral

# ---- A line on standard error, once, where functions are compiled for longer than a second

# s of compilation in a process after which the line is written.
_PATIENCE = 1.0

_depth = 0
_begin = _taken = 0.0
_written = False


def started() -> None:
    """Count a compilation that starts; nested ones belong to the outermost."""
    global _depth, _begin
    if _depth == 0:
        _begin = time.monotonic()
    _depth += 1
    _write_once()


def ended() -> None:
    """Count a compilation that ends."""
    global _depth, _taken
    _depth = max(0, _depth - 1)
    _write_once()
    if _depth == 0:
        _taken += time.monotonic() - _begin


def _write_once() -> None:
    global _written
    if _written or _taken + time.monotonic() - _begin < _PATIENCE:
        return
    _written = True
    if sys.stderr is not None and not os.environ.get("ATTITUDE_QUIET"):
        print(
            "attitude: compiling, once on this machine; `attitude warm-up --all` does it ahead ...",
            file=sys.stderr,
            flush=True,
        )


# ---- The sources that the machine code of a function is made from, as one hash of their text
# They are the module of the function, what it imports from the package, what those modules import,
# and so on, the modules of functions in its closure, and this folder.  The hash is of the text and
# not of the times of the files: machine code stays valid if the same version is installed again.

_ROOT = Path(__file__).parent.parent
_PACKAGE = _ROOT.name
# Of no effect on machine code.
_TYPES = f"{_PACKAGE}._support.annotations"
_COMMENT = re.compile("#.*")
# All imports are absolute; tests/compilation/test_compilation.py compares what is found with
# syntax trees.
_IMPORT = re.compile(
    rf"^[ \t]*from[ \t]+({_PACKAGE}[\w.]*)[ \t]+import[ \t]+(\([^)]*\)|[^\n]*)"
    rf"|^[ \t]*import[ \t]+({_PACKAGE}\.[\w.]*)",
    re.MULTILINE,
)


class _Source(NamedTuple):
    """One module: the hash of its text, and the modules of the package that it imports."""

    digest: str
    imports: frozenset[str]


def stamp_of(function: Callable[..., Any]) -> str:
    """A hash of the sources on which the machine code of a function depends."""
    names = _reached({*_modules_of(function), *_of_the_compiler()})
    digest = hashlib.sha256(llvmlite.__version__.encode())
    for name in sorted(names):
        digest.update(f"{name} {_source(name).digest}\n".encode())
    return digest.hexdigest()


def _modules_of(function: Any) -> Iterator[str]:
    """The modules of a function and of the functions in its closure."""
    function = getattr(function, "py_func", function)
    yield function.__module__
    for cell in function.__closure__ or ():
        yield from _modules_in(cell.cell_contents)


def _modules_in(value: Any) -> Iterator[str]:
    if isinstance(value, (tuple, list)):
        for entry in value:
            yield from _modules_in(entry)
    elif hasattr(value, "py_func") or hasattr(value, "__code__"):
        yield from _modules_of(value)


def _reached(names: Iterable[str]) -> set[str]:
    """The modules of the package among some, and all that they import, directly or not."""
    modules: set[str] = set()
    left = [name for name in names if name.partition(".")[0] == _PACKAGE]
    while left:
        name = left.pop()
        if name not in modules:
            modules.add(name)
            left.extend(_source(name).imports)
    return modules


@cache
def _of_the_compiler() -> frozenset[str]:
    """The modules of this folder: they define what instructions compile to."""
    folder = Path(__file__).parent
    return frozenset(f"{_PACKAGE}.{folder.name}.{file.stem}" for file in folder.glob("*.py"))


@cache
def _source(name: str) -> _Source:
    path = _path(name)
    if path is None:
        return _Source("", frozenset())
    text = path.read_bytes()
    imports = frozenset(_imported(text.decode()))
    return _Source(hashlib.sha256(text).hexdigest(), imports)


def _imported(text: str) -> Iterator[str]:
    """The modules of the package that a text imports, or imports names from."""
    # examples in the docstring of the module are no imports
    code = text.split('"""', 2)[-1] if text.startswith('"""') else text
    for module, names, whole in _IMPORT.findall(code):
        if whole:
            yield whole
        for clause in _COMMENT.sub("", names).strip("()").split(","):
            word = clause.split()
            if word:
                inner = f"{module}.{word[0]}"
                if module != _TYPES:
                    yield inner if _path(inner) is not None else module


@cache
def _path(name: str) -> Path | None:
    """The file of a module or package; None if there is none."""
    place = _ROOT.joinpath(*name.split(".")[1:])
    files = place.with_suffix(".py"), place / "__init__.py"
    return next((file for file in files if file.is_file()), None)


class _Undisturbed(event.Listener):
    """Suspend garbage collection and interrupts while a function of the package is compiled.

    `numba.core.event` is documented; if the event "numba:compile" or its entry "dispatcher" change,
    compilations take a tenth longer, and Ctrl-C during one is lost
    (tests/compilation/test_compilation.py).
    """

    def on_start(self, event: Any) -> None:
        if _is_ours(event):
            started()
            deferral.suspend_collection()
            deferral.hold_interrupts()

    def on_end(self, event: Any) -> None:
        if _is_ours(event):
            ended()
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

    def load_overload(*arguments: Any) -> Any:
        overload = None
        try:
            overload = load(*arguments)
        except Exception:  # a torn file raises any error in pickle; the next process compiles anew
            with suppress(OSError):
                on_disk.flush()
        if overload is None and installed is not None:
            users_cache, on_disk._cache_file = on_disk._cache_file, installed
            with suppress(Exception):
                overload = load(*arguments)
            on_disk._cache_file = users_cache
        return overload

    def save_overload(*arguments: Any) -> None:
        with suppress(OSError):
            save(*arguments)

    on_disk.load_overload, on_disk.save_overload = load_overload, save_overload
