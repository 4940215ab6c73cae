"""Arrays on disk that took long to compute: a second process computes none anew.

They lie in the folder ``attitude`` of the user's cache folder (``XDG_CACHE_HOME``, by default
~/.cache), or in the folder that the environment variable ``ATTITUDE_CACHE`` names; ``off`` keeps
none.
"""

from __future__ import annotations

import hashlib
import os
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any
from zipfile import BadZipFile

import numpy as np

from attitude._textfiles.atomic_write import written_whole
from attitude.errors import AttitudeError

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import NDArray


def file_of(kind: str, key: str, *arrays: NDArray[Any]) -> Path | None:
    """The file, perhaps absent, of arrays of a kind by what they depend on; None: none are kept."""
    folder = os.environ.get("ATTITUDE_CACHE")
    if folder == "off":
        return None
    if not folder:
        base = os.environ.get("XDG_CACHE_HOME") or os.path.join("~", ".cache")
        folder = os.path.join(base, "attitude")
    name = hashlib.sha256(key.encode())
    for array in arrays:
        name.update(np.ascontiguousarray(array).tobytes())
    return Path(folder).expanduser() / f"{kind}-{name.hexdigest()[:32]}.npz"


def read(file: Path | None) -> dict[str, NDArray[Any]]:
    """The arrays in a file by their names, whose checksum is verified; none if there is no such."""
    if file is None:
        return {}
    try:
        # numpy does not close a file by name that turns out to be cut short.
        with file.open("rb") as stream, np.load(stream) as stored:
            arrays = {name: stored[name] for name in stored.files}
    except (OSError, ValueError, KeyError, EOFError, BadZipFile):
        return {}
    with suppress(OSError):
        os.utime(file)
    return arrays


def write(file: Path | None, arrays: Mapping[str, NDArray[Any]], largest: int) -> None:
    """Keep arrays, if the folder can be written and they fit in it.

    Where all files of this kind exceed so many bytes, those used longest ago are deleted.
    """
    if file is None or sum(array.nbytes for array in arrays.values()) > largest:
        return
    # A full or unwritable disk costs the next process the time of computing, and is no error.
    with suppress(OSError, AttitudeError):
        file.parent.mkdir(parents=True, exist_ok=True)
        with written_whole(file, "table", binary=True) as stream:
            np.savez(stream, **arrays)  # type: ignore[arg-type]
        kind = file.name.partition("-")[0]
        files = [(one.stat(), one) for one in file.parent.glob(f"{kind}-*.npz")]
        total = sum(status.st_size for status, _ in files)
        for status, one in sorted(files, key=lambda pair: pair[0].st_mtime):
            if total <= largest:
                return
            one.unlink(missing_ok=True)
            total -= status.st_size
