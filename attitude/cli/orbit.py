"""``--orbit FILE``: the path of a body about its center, for attitudes relative to its orbit."""

from __future__ import annotations

import argparse
import re
from typing import TYPE_CHECKING

from attitude.errors import AttitudeError

if TYPE_CHECKING:
    from attitude.paths.path import Path


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options --orbit and --orbit-of."""
    parser.add_argument(
        "--orbit",
        metavar="FILE",
        help="OEM, TLE, OMM or SPK: the path of the body about the center that it names, where "
        "attitudes of IN or OUT are relative to axes of the orbit (LVLH, RTN)",
    )
    parser.add_argument(
        "--orbit-of",
        metavar="NAME",
        help="the target of an SPK (name or NAIF number), or one satellite of several in a TLE or "
        "OMM (name or catalogue number)",
    )


def path_of(arguments: argparse.Namespace) -> Path | None:
    """The path given by the options; None without them.

    Raises
    ------
    AttitudeError
        For a file of another format or that cannot be read, and for a body that it lacks.
    """
    file, name = arguments.orbit, arguments.orbit_of
    if file is None:
        if name is not None:
            raise AttitudeError("--orbit-of names a body of an orbit; give the file with --orbit.")
        return None
    from attitude import paths

    kind = _kind(file)
    if kind == "oem":
        if name is not None:
            raise AttitudeError(
                "--orbit-of has no meaning for an OEM, which holds one body; leave it out."
            )
        found = paths.oem(file)
    elif kind == "spk":
        if name is None:
            raise AttitudeError(
                f"--orbit {file!r} is an SPK, which may hold many bodies; give the one whose "
                "attitudes are converted with --orbit-of, by its name or NAIF number."
            )
        found = paths.spk(file, int(name) if re.fullmatch(r"-?[0-9]+", name) else name)
    else:
        found = getattr(paths, kind)(file, name=name)
    if found.center == "ssb":
        raise AttitudeError(
            f"--orbit {file!r} gives {found.name} relative to the barycenter of the solar system; "
            "give a file whose center is the body at the focus of the orbit."
        )
    return found


def _kind(file: str) -> str:
    """The format of a file of an orbit, from its beginning."""
    from attitude.textfiles.lines import beginning

    start = beginning(file)
    for mark, kind in (
        (rb"DAF/SPK|NAIF/DAF", "spk"),
        (rb"CCSDS_OEM_VERS|<.*<oem\b|<oem\b", "oem"),
        (rb"CCSDS_OMM_VERS|[<{]|\[\s*\{|.*\bMEAN_MOTION\b", "omm"),
        (rb"(.*\n)?1 .*\n2 ", "tle"),
    ):
        if re.match(mark, start, re.DOTALL):
            return kind
    raise AttitudeError(
        f"--orbit {file!r} is in no known format; give an OEM in keyword = value notation, "
        "two-line elements, an OMM or an SPK."
    )
