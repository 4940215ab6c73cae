"""Tables of shadows on disk, named by a hash of the mesh: a second process computes none anew.

They lie in the folder ``attitude`` of the user's cache folder (``XDG_CACHE_HOME``, by default
~/.cache), or in the folder that the environment variable ``ATTITUDE_CACHE`` names; ``off`` keeps
none.  When they exceed LARGEST bytes together, those used longest ago are deleted.
"""

from __future__ import annotations

import hashlib
import os
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING
from zipfile import BadZipFile

import numpy as np

from attitude.errors import AttitudeError

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from attitude.annotations import FloatArray, IntArray

# Seconds: a table computed in less is not worth its place on disk.
WORTH = 1.0
# Upper bound of the files together, bytes.
LARGEST = 1 << 31
# To be raised when the bits of a table change.
_METHOD = 2


def file_of(corners: FloatArray, order: IntArray, resolution: int) -> Path | None:
    """The file of the table of a mesh, which need not exist; None if tables are not kept.

    Parameters
    ----------
    corners : (F, 3, 3) array
        m, which with the order of the facets and the resolution determine the table.
    order : (places,) array of int
    resolution : int
    """
    folder = os.environ.get("ATTITUDE_CACHE")
    if folder == "off":
        return None
    if not folder:
        base = os.environ.get("XDG_CACHE_HOME") or os.path.join("~", ".cache")
        folder = os.path.join(base, "attitude")
    name = hashlib.sha256(f"{_METHOD} {resolution} {corners.shape} ".encode())
    name.update(np.ascontiguousarray(corners).tobytes())
    name.update(np.ascontiguousarray(order).tobytes())
    return Path(folder).expanduser() / f"shadows-{name.hexdigest()[:32]}.npz"


def read(file: Path | None, shape: tuple[int, int]) -> NDArray[np.uint8] | None:
    """The masks in a file, whose checksum is verified; None if there is no such table."""
    if file is None or not file.is_file():
        return None
    try:
        # numpy does not close a file by name that turns out to be cut short.
        with file.open("rb") as stream, np.load(stream) as stored:
            masks = stored["masks"]
    except (OSError, ValueError, KeyError, EOFError, BadZipFile):
        return None
    if masks.shape != shape or masks.dtype != np.uint8:
        return None
    with suppress(OSError):
        os.utime(file)
    return masks


def write(file: Path | None, masks: NDArray[np.uint8]) -> None:
    """Keep a table, if the folder can be written and the table fits in it."""
    if file is None or masks.nbytes > LARGEST:
        return
    from attitude.textfiles.atomic_write import written_whole

    # A full or unwritable disk costs the next process the time of computing, and is no error.
    with suppress(OSError, AttitudeError):
        file.parent.mkdir(parents=True, exist_ok=True)
        with written_whole(file, "table of shadows", binary=True) as stream:
            np.savez(stream, masks=masks)
        _delete_the_oldest(file.parent)


def _delete_the_oldest(folder: Path) -> None:
    found = [(each.stat(), each) for each in folder.glob("shadows-*.npz")]
    total = sum(status.st_size for status, _ in found)
    for status, each in sorted(found, key=lambda pair: pair[0].st_mtime):
        if total <= LARGEST:
            return
        each.unlink(missing_ok=True)
        total -= status.st_size
