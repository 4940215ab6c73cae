"""Files that appear whole or not at all."""

import os
import shutil
from contextlib import contextmanager, suppress

from attitude.errors import AttitudeError


@contextmanager
def written_whole(path, name="output", *, binary=False):
    """A file that takes the place of `path` only when the block ends well.

    What is written goes aside, into the same folder, and is renamed at the end; after an error or
    an interrupt nothing is left, and a file that was there before is as it was.  Devices and pipes
    are written to directly.

    Parameters
    ----------
    path : str or path
    name : str
        How the path is called in the error message.
    binary : bool
        Whether bytes are written, and not text in UTF-8.

    Raises
    ------
    AttitudeError
        Where the folder does not exist or cannot be written to, or the disk is full.
    """
    target = os.path.realpath(path)
    if os.path.isdir(target):
        raise AttitudeError(f"{name} {os.fspath(path)!r} is a folder; give the name of a file.")
    direct = os.path.exists(target) and not os.path.isfile(target)
    folder, last = os.path.split(target)
    aside = target if direct else os.path.join(folder, f".{last}.{os.getpid()}.part")
    try:
        ways = ("wb",) if binary else ("w", -1, "utf-8", "strict", "")
        file = open(aside, *ways)  # noqa: SIM115
    except OSError as err:
        raise _cannot(path, name, err) from err
    done = False
    try:
        try:
            yield file
        finally:
            file.close()
        if not direct:
            if os.path.exists(target):
                shutil.copymode(target, aside)
            os.replace(aside, target)
        done = True
    except BrokenPipeError:
        raise  # whoever read does not want more
    except OSError as err:
        raise _cannot(path, name, err) from err
    finally:
        if not done and not direct:
            with suppress(OSError):
                os.unlink(aside)


def _cannot(path, name, err):
    return AttitudeError(
        f"{name} {os.fspath(path)!r} cannot be written: {err.strerror or err}. Give a file in a "
        "folder that exists and can be written to."
    )


@contextmanager
def made_whole(path, name="output"):
    """The name of a file aside, for those who write by name, which becomes `path` at the end.

    As `written_whole`, which see for what is promised and raised.
    """
    target = os.path.realpath(path)
    if os.path.isdir(target):
        raise AttitudeError(f"{name} {os.fspath(path)!r} is a folder; give the name of a file.")
    if os.path.exists(target) and not os.path.isfile(target):
        raise AttitudeError(
            f"{name} {os.fspath(path)!r} is a device or a pipe; give the name of a file."
        )
    folder, last = os.path.split(target)
    stem, extension = os.path.splitext(last)
    aside = os.path.join(folder, f".{stem}.{os.getpid()}.part{extension}")
    with suppress(OSError):
        os.unlink(aside)
    try:
        yield aside
        if os.path.exists(target):
            shutil.copymode(target, aside)
        os.replace(aside, target)
    except OSError as err:
        raise _cannot(path, name, err) from err
    finally:
        with suppress(OSError):
            os.unlink(aside)
