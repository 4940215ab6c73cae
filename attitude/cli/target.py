"""The motion that a command is run for: that of a file, or a completed entry of the catalogue."""

from __future__ import annotations

import argparse
import os
import re
from typing import TYPE_CHECKING, Any, NamedTuple

from attitude.errors import AttitudeError

if TYPE_CHECKING:
    from attitude.catalog import Entry
    from attitude.free_rotation.free_rotation import FreeRotation

# Option of the command line, keyword of catalog.load, unit, help.
_NUMBERS = (
    ("--moments", "moments", None, "three moments about the body axes, or their ratios"),
    ("--P-psi", "P_psi", "s", 'period, such as "6.58 h"'),
    ("--P-phi", "P_phi", "s", 'period, such as "7.35 h"'),
    ("--pole", "pole", "rad", 'longitude and latitude, such as "250, -75 deg"'),
    ("--phi0", "phi0", "rad", 'angle at the epoch, such as "152 deg"'),
    ("--psi0", "psi0", "rad", 'angle at the epoch, such as "-3 deg"'),
    ("--wxyz", "wxyz", None, "attitude from body axes to the frame"),
    ("--angular-velocity", "angular_velocity", "rad/s", 'such as "1, 0, 3 deg/s", body axes'),
)
_WORDS = (
    ("--mode", "mode", "LAM or SAM"),
    ("--convention", "convention", "L or S: phi of the long or the short axis"),
    ("--theta-branch", "theta_branch", "acute or obtuse, where psi librates"),
    ("--epoch", "epoch", "date in UTC"),
    ("--frame", "frame", "frame of the pole or of wxyz"),
)


class Target(NamedTuple):
    """A motion with its labels.

    Attributes
    ----------
    motion : FreeRotation
    name : str
        Of the entry or in the spin file; the file itself if the file has none.
    source, note : str or None
    given : tuple of str
        Options whose values replace or complete those of the entry.
    """

    motion: FreeRotation
    name: str
    source: str | None
    note: str | None
    given: tuple[str, ...] = ()

    @property
    def label(self) -> str:
        """The name, and which numbers are not those of its sources."""
        if not self.given:
            return self.name
        return f"{self.name}, with {', '.join(self.given)} as given here"


_FILES = "a body and its state in a file: spin file (.toml), APM, or DAMIT spin file (.spin)"


def add_arguments(parser: argparse.ArgumentParser, files: str = _FILES) -> None:
    """Add NAME|FILE, and the options that complete an entry of the catalogue.

    Parameters
    ----------
    files : str
        For the help: the files that the command reads.
    """
    parser.add_argument(
        "target", metavar="NAME|FILE", help=f"name in the catalogue (or a part of it), or {files}"
    )
    group = parser.add_argument_group("values that an entry of the catalogue lacks")
    for option, name, _, text in _NUMBERS:
        group.add_argument(option, dest=name, metavar="NUMBERS", nargs="+", help=text)
    for option, name, text in _WORDS:
        group.add_argument(option, dest=name, metavar="WORD", help=text)


def is_file(text: str) -> bool:
    """Whether a target is a file: one that exists, or a name of the form of a path."""
    from attitude import catalog

    written_so = re.search(r"\.[A-Za-z]\w*$|[/\\]", text) is not None
    return os.path.isfile(text) or (written_so and not catalog.has(text))


def opened(arguments: argparse.Namespace) -> Target:
    """The Target of parsed arguments.

    Raises
    ------
    AttitudeError
        For a file that cannot be read, an unknown name, and an entry that stays incomplete.
    """
    if is_file(arguments.target):
        return _from_file(arguments)
    from attitude import catalog

    entry = catalog.entry(arguments.target)
    given = tuple(_completing(arguments))
    sources = "; ".join(entry.sources)
    return Target(entry.motion(**_given(arguments)), entry.name, sources, entry.note, given)


def incomplete(arguments: argparse.Namespace) -> Entry | None:
    """The entry of the catalogue, if values are missing in it and no option gives one."""
    if is_file(arguments.target) or _completing(arguments):
        return None
    from attitude import catalog

    entry = catalog.entry(arguments.target)
    return entry if entry.missing else None


def _from_file(arguments: argparse.Namespace) -> Target:
    from attitude.formats import state

    useless = _completing(arguments)
    if useless:
        raise AttitudeError(
            f"{', '.join(useless)} complete an entry of the catalogue; write such values into the "
            "spin file."
        )
    found = state.read(arguments.target)
    return Target(found.motion, found.name or arguments.target, found.source, found.note)


def _given(arguments: argparse.Namespace) -> dict[str, Any]:
    """The keywords of the options."""
    from attitude import validation

    given: dict[str, Any] = {}
    for option, name, unit, _ in _NUMBERS:
        words = getattr(arguments, name)
        if words is not None:
            found = validation.real(" ".join(words), option, unit=unit)
            given[name] = found[()] if found.size > 1 else float(found.reshape(()))
    for _, name, _ in _WORDS:
        given[name] = getattr(arguments, name)
    return given


def _completing(arguments: argparse.Namespace) -> list[str]:
    """The options given that complete an entry of the catalogue."""
    options = [*(row[:2] for row in _NUMBERS), *(row[:2] for row in _WORDS)]
    return [option for option, name in options if getattr(arguments, name) is not None]
