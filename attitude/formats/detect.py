"""The format of a file by its content or ending; reading and writing files of any format."""

from __future__ import annotations

import os
import re
from typing import TYPE_CHECKING, Any, NamedTuple

from attitude._textfiles.lines import beginning, is_number
from attitude.errors import AttitudeError
from attitude.formats import spin_file
from attitude.motions._free_rotation import FreeRotation

if TYPE_CHECKING:
    from collections.abc import Sequence

    from attitude._support.annotations import Epochs, FilePath
    from attitude.formats._sampling import AttitudeSource, SampledFile
    from attitude.motions._motion import Motion
    from attitude.paths._path import Path

__all__ = [
    "ENDINGS",
    "OF_MOTIONS",
    "OpenedFile",
    "of_file",
    "opened",
    "read",
    "to_write",
    "write",
    "write_motion",
]


# Ending -> format: for writing, and for reading if the content is not recognized.
ENDINGS: dict[str, str] = {
    ".aem": "aem",
    ".xml": "aem-xml",
    ".apm": "apm",
    ".apm.xml": "apm-xml",
    ".acm": "acm",
    ".acm.xml": "acm-xml",
    ".a": "stk",
    ".cic": "cic",
    ".toml": "spin",
    ".spin": "damit",
    ".bc": "ck",
    ".ecsv": "table",
    ".fits": "table",
    ".fit": "table",
    ".csv": "table",
    ".parquet": "table",
}
# Formats that hold a motion; the others hold attitudes at epochs.
OF_MOTIONS: tuple[str, ...] = ("apm", "apm-xml", "spin", "damit")


def of_file(path: FilePath) -> str:
    """The format of an existing file: one of the values of ENDINGS."""
    text = beginning(path)
    for mark, found in (
        (b"CCSDS_AEM_VERS", "aem"),
        (b"CCSDS_APM_VERS", "apm"),
        (b"CCSDS_ACM_VERS", "acm"),
        (b"CIC_AEM_VERS", "cic"),
        (b"stk.v.", "stk"),
        (b"DAF/CK", "ck"),
    ):
        if text.startswith(mark):
            return found
    if text.startswith(b"<"):
        return _of_xml(path, text)
    other = re.match(rb"(CCSDS|CIC)_([A-Z]{2,4})_VERS", text)
    if other:
        family, kind = (word.decode() for word in other.groups())
        raise AttitudeError(
            f"{os.fspath(path)!r} is an {kind}, which holds no attitudes; give an AEM, APM or ACM."
            if family == "CCSDS"
            else f"{os.fspath(path)!r} is an {kind} of CIC, of which only AEMs are read."
        )
    if _ending(path) in ENDINGS:
        return ENDINGS[_ending(path)]
    if len(text.split(b"\n")[0].split()) == 3 and b"=" not in text.split(b"\n")[0]:
        return "damit"
    raise AttitudeError(
        f"{os.fspath(path)!r} is in no format that is known: neither its content nor its ending is "
        f"one of them. Known endings are {', '.join(ENDINGS)}."
    )


def to_write(path: FilePath) -> str:
    """The format in which a file is written, by its ending: one of the values of ENDINGS."""
    ending = _ending(path)
    if ending not in ENDINGS:
        raise AttitudeError(
            f"{os.fspath(path)!r} ends in {ending!r}, which belongs to no format; give one of "
            f"{', '.join(ENDINGS)}."
        )
    return ENDINGS[ending]


def _ending(path):
    name = os.path.basename(os.fspath(path)).lower()
    for ending in (".apm.xml", ".acm.xml"):
        if name.endswith(ending):
            return ending
    return os.path.splitext(name)[1]


def _of_xml(path, text):
    """The format of a file in XML, by the element of its message."""
    found = re.search(rb"<(?:[\w.-]+:)?(acm|aem|apm|cdm|ocm|oem|omm|opm|rdm|tdm)[\s>]", text)
    name = found.group(1).decode() if found else "aem"
    if name not in ("acm", "aem", "apm"):
        raise AttitudeError(
            f"{os.fspath(path)!r} is an {name.upper()}, which holds no attitudes; give an AEM, APM "
            "or ACM."
        )
    return f"{name}-xml"


class OpenedFile(NamedTuple):
    """The content of a file in any format.

    Attributes
    ----------
    motion : AttitudeTable, FreeRotation or KernelAttitude
    said : dict
        Names, comments, source and note, under the names of the keyword arguments of writers.
    """

    motion: Motion
    said: dict[str, Any]


def read(
    path: FilePath,
    *,
    tolerance: float | None = None,
    frame: str | None = None,
    orbit: Path | None = None,
    body: str | None = None,
    kernels: Sequence[FilePath] = (),
    rates: str | None = None,
    object: str | None = None,
    segment: int | None = None,
    lenient: bool = False,
) -> Motion:
    """The motion in a file of any format; see `opened` for parameters and errors.

    Returns
    -------
    AttitudeTable, FreeRotation or KernelAttitude
        Close a KernelAttitude after use: its kernels are loaded in SPICE's pool until then.
    """
    return opened(
        path,
        tolerance=tolerance,
        frame=frame,
        orbit=orbit,
        body=body,
        kernels=kernels,
        rates=rates,
        object=object,
        segment=segment,
        lenient=lenient,
    ).motion


def opened(
    path: FilePath,
    *,
    tolerance: float | None = None,
    frame: str | None = None,
    orbit: Path | None = None,
    body: str | None = None,
    kernels: Sequence[FilePath] = (),
    rates: str | None = None,
    object: str | None = None,
    segment: int | None = None,
    lenient: bool = False,
) -> OpenedFile:
    """The motion in a file of any format, with the names and comments of the file."""
    kind = of_file(path)
    lengths: dict[str, Any] = {} if tolerance is None else {"tolerance": tolerance}
    if kind in ("aem", "aem-xml", "cic"):
        from attitude.formats import aem, cic

        reader = cic.read if kind == "cic" else aem.read
        one: dict[str, Any] = {"object": object, "segment": segment, "lenient": lenient}
        return _table(reader(path, frame=frame, orbit=orbit, rates=rates, **one, **lengths))
    if kind in ("apm", "apm-xml"):
        from attitude.formats import apm

        message = apm.read(path, frame=frame, orbit=orbit, rates=rates, **lengths)
        names = ("object_name", "object_id", "center", "comments")
        return OpenedFile(message.motion, {name: message.meta[name] for name in names})
    if kind in ("acm", "acm-xml"):
        from attitude.formats import acm

        return _of_acm(acm.read(path, frame=frame, orbit=orbit, **lengths), path, segment)
    if kind == "stk":
        from attitude.formats import stk

        return _table(stk.read(path, frame=frame, orbit=orbit, **lengths))
    if kind == "spin":
        from attitude.formats import spin_file

        found = spin_file.read(path)
        labels = {"name": found.name, "source": found.source, "note": found.note}
        return OpenedFile(found.motion, labels)
    if kind == "damit":
        from attitude.formats import damit

        rotator = damit.read(path)
        return OpenedFile(rotator.motion(), {"scattering": rotator.scattering})
    if kind == "ck":
        return OpenedFile(_kernel(path, body, kernels), {})
    from attitude.formats import tables

    return _table(tables.read(path, **lengths))


def _table(table):
    names = ("object_name", "object_id", "center", "comments")
    return OpenedFile(table, {name: table.meta[name] for name in names if table.meta.get(name)})


def _of_acm(message, path, segment):
    """The attitudes of an ACM, or its motion if it has none."""
    if segment is not None:
        if not 0 <= segment < len(message.tables):
            raise AttitudeError(
                f"{os.fspath(path)}: segment is {segment!r}; the message has {len(message.tables)} "
                "blocks of attitudes, counted from 0."
            )
        return _table(message.tables[segment])
    try:
        return _table(message.table if message.tables else message.motion)
    except AttitudeError as err:
        raise AttitudeError(f"{os.fspath(path)}: {err}") from err


def _kernel(path, body, kernels):
    from attitude.formats import ck

    stem = os.path.splitext(os.fspath(path))[0]
    beside = [stem + ending for ending in (".tf", ".tsc") if os.path.exists(stem + ending)]
    if body is None:
        body = "TUMBLER"
    return ck.KernelAttitude([path, *beside, *kernels], body)


def write(
    path: FilePath, source: AttitudeSource, *, t: Epochs | None = None, **settings: Any
) -> SampledFile | None:
    """Write attitudes at epochs in the format of the file's ending.

    Parameters
    ----------
    path : str or path
        Appears whole or not at all.
    source, t
        As in `aem.write`.
    settings
        Further arguments of the writer of the format, such as start=, stop= and tolerance=.

    Returns
    -------
    SampledFile or None
        As `aem.write`.

    Raises
    ------
    AttitudeError
        For an ending of no format or of a format of motions, and as the writer of the format.
    """
    kind = to_write(path)
    if kind in ("aem", "aem-xml"):
        from attitude.formats import aem

        return aem.write(path, source, t=t, xml=kind == "aem-xml", **settings)
    if kind in ("acm", "acm-xml"):
        from attitude.formats import acm

        acm.write(path, source, t=t, xml=kind == "acm-xml", **settings)
        return None
    if kind == "cic":
        from attitude.formats import cic

        return cic.write(path, source, t=t, **settings)
    if kind == "stk":
        from attitude.formats import stk

        return stk.write(path, source, t=t, **settings)
    if kind == "table":
        from attitude.formats import tables

        return tables.write(path, source, t=t, **settings)
    raise AttitudeError(
        f"{os.fspath(path)!r} would hold a motion, not attitudes at epochs; use write_motion."
    )


def write_motion(path: FilePath, motion: FreeRotation, **settings: Any) -> None:
    """Write a free rotation as a spin file (.toml, exact), an APM (.apm) or a DAMIT file
    (.spin).
    """
    kind = to_write(path)
    if kind == "spin":
        from attitude.formats import spin_file

        spin_file.write(path, motion, **settings)
    elif kind in ("apm", "apm-xml"):
        from attitude.formats import apm

        apm.write(path, motion, xml=kind == "apm-xml", **settings)
    elif kind == "damit":
        from attitude.formats import damit

        damit.write(path, motion, **settings)
    else:
        raise AttitudeError(
            f"{os.fspath(path)!r} would hold attitudes at epochs, not a motion; use write."
        )


# ---- A free rotation with its labels, from a file that holds one: spin file, APM, DAMIT spin file


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


def read_state(path: FilePath) -> State:
    """The free rotation in a file."""
    kind = _kind(path)
    if kind == "spin":
        found = spin_file.read(path)
        return State(found.motion, found.name, found.source, found.note)
    motion, said = opened(path)
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
        kind = of_file(path)
    except AttitudeError:
        return "spin"
    # Three words also begin a line of TOML.
    return "spin" if kind == "damit" and not os.fspath(path).lower().endswith(".spin") else kind
