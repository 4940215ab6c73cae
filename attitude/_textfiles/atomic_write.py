"""Files that appear whole or not at all."""

from __future__ import annotations

import errno
import os
import re
import shutil
import signal
import threading
import time
from contextlib import contextmanager, suppress
from typing import IO, TYPE_CHECKING, Any

from attitude._textfiles.lines import path_text
from attitude.errors import AttitudeError

if TYPE_CHECKING:
    from collections.abc import Iterator
    from types import FrameType


try:
    import fcntl
except ImportError:  # Windows, where a file that is open cannot be deleted
    fcntl = None  # type: ignore[assignment]

# The signals that end a process without an exception; SIGINT raises one.
_ENDS = [getattr(signal, name) for name in ("SIGTERM", "SIGHUP") if hasattr(signal, name)]
# s that a search of a folder for remains may take; among 1e4 files it takes longer.
_QUICK = 0.005
# A longer search is repeated after so many times as long: searches take a small share of the time.
_PAUSE = 20.0

# The temporary files of this process that are not complete, and the process.
_open: set[str] = set()
_owner = os.getpid()
# When the search of a folder may be repeated, by time.monotonic().
_next_search: dict[str, float] = {}


@contextmanager
def written_whole(
    path: str | os.PathLike[str], name: str = "output", *, binary: bool = False
) -> Iterator[IO[Any]]:
    """An open file that is renamed to `path` when the block ends without an error.

    The file is written under a temporary name in the folder of `path`.  After an error, an
    interrupt or SIGTERM the temporary file is deleted and an existing file `path` is unchanged; one
    that a killed process left is deleted here.  Devices and pipes are written to directly.
    """
    target = _target(path, name)
    direct = os.path.exists(target) and not os.path.isfile(target)
    with _temporary(target, direct) as temporary:
        options: dict[str, Any] = {"mode": "wb"}
        if not binary:
            options = {"mode": "w", "encoding": "utf-8", "newline": ""}
        try:
            with open(temporary, **options) as file:
                _lock(file)
                yield file
            if not direct:
                _rename(temporary, target)
        except BrokenPipeError:
            raise  # the reader of the pipe has gone; the command line ends quietly
        except OSError as err:
            raise _not_writable(path, name, err) from err


def require_writable(path: str | os.PathLike[str], name: str) -> None:
    """AttitudeError for a file in no writable folder: before work whose result is written there."""
    target = _target(path, name)
    folder, is_device = os.path.dirname(target), os.path.exists(target) > os.path.isfile(target)
    if not is_device and not os.access(folder, os.W_OK):
        number = errno.EACCES if os.path.isdir(folder) else errno.ENOENT
        raise _not_writable(path, name, OSError(number, os.strerror(number)))


@contextmanager
def made_whole(path: str | os.PathLike[str], name: str = "output") -> Iterator[str]:
    """As `written_whole`, a temporary name for libraries that open files by name; no devices."""
    target = _target(path, name)
    if os.path.exists(target) and not os.path.isfile(target):
        raise AttitudeError(
            f"{name} {os.fspath(path)!r} is a device or a pipe; give the name of a file."
        )
    with _temporary(target, ending=os.path.splitext(target)[1]) as temporary:
        with suppress(OSError):
            os.unlink(temporary)
        try:
            yield temporary
            _rename(temporary, target)
        except OSError as err:
            raise _not_writable(path, name, err) from err


@contextmanager
def _temporary(target: str, direct: bool = False, *, ending: str = "") -> Iterator[str]:
    """The name to write to in place of `target`, deleted at the end, at SIGTERM and SIGHUP too."""
    if direct:
        yield target
        return
    folder, last = os.path.split(target)
    stem = f".{last.removesuffix(ending)}."
    _delete_remains(folder, stem, ".part" + ending)
    temporary = os.path.join(folder, f"{stem}{os.getpid()}.part{ending}")
    _watch(temporary)
    try:
        yield temporary
    finally:
        with suppress(OSError):
            os.unlink(temporary)
        _unwatch(temporary)


def _watch(temporary: str) -> None:
    global _owner
    if _owner != os.getpid():  # forked: the files of the other process are its own
        _open.clear()
        _owner = os.getpid()
    _open.add(temporary)
    if threading.current_thread() is threading.main_thread():  # others cannot set handlers
        for number in _ENDS:
            if signal.getsignal(number) is signal.SIG_DFL:
                signal.signal(number, _end)


def _unwatch(temporary: str) -> None:
    _open.discard(temporary)
    if not _open and threading.current_thread() is threading.main_thread():
        for number in _ENDS:
            if signal.getsignal(number) is _end:
                signal.signal(number, signal.SIG_DFL)


def _end(number: int, frame: FrameType | None) -> None:
    """Delete the temporary files, and end as the signal would have."""
    if _owner == os.getpid():
        for file in list(_open):
            with suppress(OSError):
                os.unlink(file)
    signal.signal(number, signal.SIG_DFL)
    os.kill(os.getpid(), number)


def _delete_remains(folder: str, stem: str, ending: str) -> None:
    """Delete the temporary files of a target that processes which no longer live have left."""
    start = time.monotonic()
    if start < _next_search.get(folder, start):
        return
    try:
        names = [entry for entry in os.listdir(folder) if entry.startswith(stem)]
    except OSError:
        return  # opening the file says why
    for name in names:
        match = re.fullmatch(r"([1-9][0-9]{0,9})" + re.escape(ending), name[len(stem) :])
        if match and not _lives(int(match.group(1))):
            with suppress(OSError):
                _delete_unlocked(os.path.join(folder, name))
    end = time.monotonic()
    if end - start > _QUICK:
        _next_search[folder] = end + _PAUSE * (end - start)


def _lives(process: int) -> bool:
    if process == os.getpid():
        return True
    if os.name == "nt":
        return False  # signal 0 is Ctrl-C there; a file that is open cannot be deleted
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    except (PermissionError, OverflowError):
        pass
    return True


def _lock(file: IO[Any]) -> None:
    """Tell other machines and containers, which do not see this process, that the file is used."""
    if fcntl is not None:
        with suppress(OSError):  # file systems without locks
            fcntl.flock(file, fcntl.LOCK_SH | fcntl.LOCK_NB)


def _delete_unlocked(path: str) -> None:
    """Delete a file, or raise an OSError if somebody has locked it."""
    if fcntl is not None:
        with open(path, "rb+") as file:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            os.unlink(path)
    else:
        os.unlink(path)


def _target(path, name):
    """The file behind symbolic links; folders and empty names are refused."""
    path = path_text(path, name)
    if not path:
        raise AttitudeError(f"{name} is an empty text; give the name of a file.")
    target = os.path.realpath(path)
    if os.path.isdir(target):
        raise AttitudeError(f"{name} {path!r} is a folder; give the name of a file.")
    return target


def _rename(temporary, target):
    """Replace the target atomically; permissions of an existing target are kept."""
    if os.path.exists(target):
        shutil.copymode(target, temporary)
    os.replace(temporary, target)


def _not_writable(path, name, err):
    return AttitudeError(
        f"{name} {os.fspath(path)!r} cannot be written: {err.strerror or err}. Give a file in a "
        "folder that exists and is writable."
    )
