"""A free rotation with its labels, from a file that holds one: spin file, APM, DAMIT spin file."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, NamedTuple

from attitude.errors import AttitudeError
from attitude.formats import detect, spin_file
from attitude.free_rotation.free_rotation import FreeRotation
from attitude.textfiles.lines import beginning, is_number

if TYPE_CHECKING:
    from attitude.annotations import FilePath


class State(NamedTuple):
    """A motion with its labels.

    Attributes
    ----------
    motion : FreeRotation
        From a DAMIT spin file, which has no inertia, that of a body with equal moments.
    name, source, note : str or None
    """

    motion: FreeRotation
    name: str | None
    source: str | None
    note: str | None


def read(path: FilePath) -> State:
    """The free rotation in a file.

    Parameters
    ----------
    path : str or path
        A spin file in TOML, whatever its ending; an APM (.apm, .xml); a DAMIT spin file (.spin,
        or a file that begins as one).

    Raises
    ------
    AttitudeError
        For a file that cannot be read, and one that holds attitudes at epochs instead of a state.
    """
    kind = _kind(path)
    if kind == "spin":
        found = spin_file.read(path)
        return State(found.motion, found.name, found.source, found.note)
    motion, said = detect.opened(path)
    if not isinstance(motion, FreeRotation):
        raise AttitudeError(
            f"{os.fspath(path)}: holds attitudes at epochs, from which no motion is known; give a "
            "spin file (.toml), an APM or a DAMIT spin file; `attitude convert IN OUT.toml --fit` "
            "makes one of attitudes."
        )
    name = said.get("object_name") or os.path.splitext(os.path.basename(os.fspath(path)))[0]
    return State(motion, name, None, None)


def _kind(path: FilePath) -> str:
    """The format of a file, by its content where that is certain, else by its ending."""
    if os.path.splitext(os.fspath(path))[1].lower() == ".toml":
        return "spin"
    text = beginning(path)
    first = text.lstrip().split(b"\n")[0].split()
    if len(first) == 3 and all(map(is_number, first)):
        return "damit"
    try:
        kind = detect.of_file(path)
    except AttitudeError:
        return "spin"
    # Three words also begin a line of TOML.
    return "spin" if kind == "damit" and not os.fspath(path).lower().endswith(".spin") else kind
