"""Files that appear whole or not at all."""

from __future__ import annotations

import os
import shutil
from contextlib import contextmanager, suppress
from typing import IO, TYPE_CHECKING, Any

from attitude.errors import AttitudeError

if TYPE_CHECKING:
    from collections.abc import Iterator


@contextmanager
def written_whole(
    path: str | os.PathLike[str], name: str = "output", *, binary: bool = False
) -> Iterator[IO[Any]]:
    """An open file that is renamed to `path` when the block ends without an error.

    The file is written under a temporary name in the folder of `path`.  After an error or an
    interrupt the temporary file is deleted and an existing file `path` is unchanged.  Devices and
    pipes are written to directly.

    Parameters
    ----------
    path : str or path
    name : str
        Name of the output in error messages.
    binary : bool
        Write bytes instead of text in UTF-8.

    Raises
    ------
    AttitudeError
        If the folder does not exist or is not writable, or if the disk is full.
    """
    target = _target(path, name)
    direct = os.path.exists(target) and not os.path.isfile(target)
    folder, last = os.path.split(target)
    temporary = target if direct else os.path.join(folder, f".{last}.{os.getpid()}.part")
    file: IO[Any]
    try:
        if binary:
            file = open(temporary, "wb")  # noqa: SIM115
        else:
            file = open(temporary, "w", encoding="utf-8", newline="")  # noqa: SIM115
    except OSError as err:
        raise _not_writable(path, name, err) from err
    done = False
    try:
        try:
            yield file
        finally:
            file.close()
        if not direct:
            _rename(temporary, target)
        done = True
    except BrokenPipeError:
        raise  # the reader of the pipe has gone; the command line ends quietly
    except OSError as err:
        raise _not_writable(path, name, err) from err
    finally:
        if not done and not direct:
            with suppress(OSError):
                os.unlink(temporary)


@contextmanager
def made_whole(path: str | os.PathLike[str], name: str = "output") -> Iterator[str]:
    """A temporary file name for libraries that open files by name; renamed to `path` at the end.

    Parameters and errors are those of `written_whole`.  Devices and pipes are refused.
    """
    target = _target(path, name)
    if os.path.exists(target) and not os.path.isfile(target):
        raise AttitudeError(
            f"{name} {os.fspath(path)!r} is a device or a pipe; give the name of a file."
        )
    folder, last = os.path.split(target)
    stem, extension = os.path.splitext(last)
    temporary = os.path.join(folder, f".{stem}.{os.getpid()}.part{extension}")
    with suppress(OSError):
        os.unlink(temporary)
    try:
        yield temporary
        _rename(temporary, target)
    except OSError as err:
        raise _not_writable(path, name, err) from err
    finally:
        with suppress(OSError):
            os.unlink(temporary)


def _target(path, name):
    """The file behind symbolic links; folders are refused."""
    target = os.path.realpath(path)
    if os.path.isdir(target):
        raise AttitudeError(f"{name} {os.fspath(path)!r} is a folder; give the name of a file.")
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
