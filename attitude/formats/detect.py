"""The format of a file by its content or ending; reading and writing files of any format."""

from __future__ import annotations

import inspect
import os
import re
from typing import TYPE_CHECKING, Any

from attitude._support.synonyms import arguments
from attitude._textfiles.lines import beginning, path_text, prefixed
from attitude.errors import AttitudeError
from attitude.formats import spin_file
from attitude.formats._format import Format, OpenedFile, ending_of, endings, formats
from attitude.motions._free_rotation import FreeRotation
from attitude.motions._table import AttitudeTable

if TYPE_CHECKING:
    from collections.abc import Sequence

    from attitude._support.annotations import Epochs, FilePath
    from attitude.formats._sampling import AttitudeSource, SampledFile
    from attitude.motions._motion import Motion
    from attitude.paths._path import Path

    # Ending -> name of the format, and the names of formats that hold a motion.
    ENDINGS: dict[str, str]
    OF_MOTIONS: tuple[str, ...]
else:

    def __getattr__(name):
        """What the registry says, read when it is first asked for."""
        if name == "ENDINGS":
            return {ending: one.name for ending, one in endings().items()}
        if name == "OF_MOTIONS":
            return tuple(one.name for one in formats().values() if one.holds == "motion")
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


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


def of_file(path: FilePath) -> str:
    """The format of an existing file: one of the values of ENDINGS."""
    return format_of(path).name


def format_of(path: FilePath) -> Format:
    """The `Format` of an existing file, by its content or else by its ending."""
    text = beginning(path)
    for one in formats().values():
        if text.startswith(one.marks):
            return one
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
    known = endings()
    if ending_of(path) in known:
        return known[ending_of(path)]
    for one in formats().values():
        if one.resembles is not None and one.resembles(text.split(b"\n")[0]):
            return one
    raise AttitudeError(
        f"{os.fspath(path)!r} is in no format that is known: neither its content nor its ending is "
        f"one of them. Known endings are {', '.join(known)}."
    )


def to_write(path: FilePath) -> str:
    """The format in which a file is written, by its ending: one of the values of ENDINGS."""
    return format_to_write(path).name


def format_to_write(path: FilePath) -> Format:
    """The `Format` in which a file is written, by its ending."""
    known, ending = endings(), ending_of(path)
    if ending not in known:
        raise AttitudeError(
            f"{os.fspath(path)!r} ends in {ending!r}, which belongs to no format; give one of "
            f"{', '.join(known)}."
        )
    return known[ending]


def _of_xml(path, text):
    """The format of a file in XML, by the element of its message."""
    from attitude._textfiles.messages import kinds_in

    kinds = kinds_in(path, text)
    known = [one for one in formats().values() if one.element in kinds]
    if len(known) == 1:
        return known[0]
    listed = " and an ".join(kind.upper() for kind in kinds)
    raise AttitudeError(
        f"{os.fspath(path)!r} holds an {listed}; write each into a file of its own, or in Python "
        "read one with its module, such as attitude.formats.aem."
        if known
        else f"{os.fspath(path)!r} is an {listed or 'NDM'}, which holds no attitudes; give an AEM, "
        "APM or ACM."
    )


@arguments({}, 'detect.read("m.aem")')
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
    keywords: dict[str, Any]
    keywords = {"frame": frame, "orbit": orbit, "body": body, "kernels": kernels, "rates": rates}
    keywords |= {"object": object, "segment": segment, "lenient": lenient}
    if tolerance is not None:  # each reader has a default of its own
        keywords["tolerance"] = tolerance
    file_format = format_of(path)
    return file_format.read(
        path, **{name: keywords[name] for name in file_format.reading if name in keywords}
    )


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
    return _format_holding("records", path).write(path, source, t=t, **settings)


def write_motion(path: FilePath, motion: FreeRotation, **settings: Any) -> None:
    """Write a free rotation as a spin file (.toml, exact), an APM (.apm) or a DAMIT file
    (.spin).
    """
    _format_holding("motion", path).write(path, motion, **settings)


# What files hold, by `Format.holds`, and what writes them.
_CONTENTS = {
    "records": ("attitudes at epochs", "write"),
    "motion": ("a motion", "write_motion"),
    "span": ("attitudes at any epoch of a span", "motion.write with start= and stop="),
}


def _format_holding(content, path):
    """The format of a file to be written, which must hold a content, one of _CONTENTS."""
    file_format = format_to_write(path)
    if file_format.holds != content:
        held, writer = _CONTENTS[file_format.holds]
        raise AttitudeError(
            f"{os.fspath(path)!r} would hold {held}, not {_CONTENTS[content][0]}; use {writer}."
        )
    return file_format


def write_any(
    path: FilePath, motion: Motion, *, t: Epochs | None = None, **settings: Any
) -> SampledFile | None:
    """Write a motion in the format of the file's ending: `Motion.write`."""
    name, file_format = path_text(path), format_to_write(path)
    _refuse_unknown_settings(name, file_format, settings)
    if file_format.holds == "motion":
        if not isinstance(motion, FreeRotation):
            raise AttitudeError(
                f"{name!r} would hold a free rotation, and the motion is {type(motion).__name__}; "
                "give an ending of attitudes at epochs, such as .aem, or attitude.fit(...).motion."
            )
        if t is not None:
            raise AttitudeError(f"{name!r} holds a motion, not attitudes at epochs; leave out t.")
        return file_format.write(path, motion, **settings)
    if file_format.holds == "span":
        if t is not None:
            raise AttitudeError(f"{name!r} holds a span of time; give start= and stop= for t.")
        ends = [settings.pop(bound, None) for bound in ("start", "stop")]
        return file_format.write(path, motion, *ends, **settings)
    is_table = isinstance(motion, AttitudeTable)
    if t is None and not is_table and not {"start", "stop"} <= set(settings):
        raise AttitudeError(
            f"{name!r} holds attitudes at epochs; give them, as in motion.write({name!r}, t)"
            + (", or start=, stop= and tolerance= (rad)." if file_format.is_sampled else ".")
        )
    return file_format.write(path, motion, t=t, **settings)


def _refuse_unknown_settings(name, file_format, settings):
    """Raise the AttitudeError for a keyword that the writer of a format does not have."""
    known = inspect.signature(file_format.write).parameters
    unknown = [key for key in settings if key not in known]
    if unknown and all(one.kind is not one.VAR_KEYWORD for one in known.values()):
        raise AttitudeError(
            f"{name!r} is written without {unknown[0]}=; beside file and motion the writer of "
            f"{file_format.title} takes {', '.join([*known][2:])}."
        )


# ---- A free rotation with its labels, from a file that holds one: spin file, APM, DAMIT spin file


def read_state(path: FilePath) -> spin_file.SpinFile:
    """The free rotation in a file; of a DAMIT spin file, without inertia, with equal moments."""
    if _is_spin_file(path):
        return spin_file.read(path)
    file_format = format_of(path)
    if file_format.read_message is not None:
        message = file_format.read_message(path)
        with prefixed(path):
            motion, said = message.motion, message.meta
    else:
        motion, said = (None, {}) if file_format.holds == "span" else opened(path)
    if not isinstance(motion, FreeRotation):
        raise AttitudeError(
            f"{os.fspath(path)}: holds attitudes or maneuvers, and no free rotation; give a spin "
            "file (.toml), an APM, an ACM or a DAMIT spin file; `attitude convert IN OUT.toml "
            "--fit` makes one of attitudes."
        )
    name = said.get("object_name") or os.path.splitext(os.path.basename(os.fspath(path)))[0]
    return spin_file.SpinFile(motion.body, motion.spin, name)


def _is_spin_file(path: FilePath) -> bool:
    """Whether a file is a spin file by its ending, or because it is in no other known format."""
    if os.path.splitext(path_text(path))[1].lower() == ".toml":  # loads no other format
        return True
    beginning(path)  # refuses a file that cannot be read
    try:
        format_of(path)
    except AttitudeError:
        return True
    return False
