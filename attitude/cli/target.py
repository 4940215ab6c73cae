"""What a command works on: a spin file, or a name of the catalogue with what is missing there."""

import os
import re
from typing import NamedTuple

from attitude.errors import AttitudeError

# Option of the command line, keyword of catalog.load, how many numbers, unit, help.
_NUMBERS = (
    ("--moments", "moments", None, "three moments about the body axes, ratios will do"),
    ("--P-psi", "P_psi", "s", 'period, such as "6.58 h"'),
    ("--P-phi", "P_phi", "s", "likewise"),
    ("--pole", "pole", "rad", 'longitude and latitude, such as "250, -75 deg"'),
    ("--phi0", "phi0", "rad", 'angle at the epoch, such as "152 deg"'),
    ("--psi0", "psi0", "rad", "likewise"),
    ("--wxyz", "wxyz", None, "attitude from body axes to the frame"),
    ("--angular-velocity", "angular_velocity", "rad/s", 'such as "1, 0, 3 deg/s", body axes'),
)
_WORDS = (
    ("--mode", "mode", "LAM or SAM"),
    ("--convention", "convention", "L or S: whose axis phi belongs to"),
    ("--theta-branch", "theta_branch", "acute or obtuse, where psi librates"),
    ("--epoch", "epoch", "date in UTC"),
    ("--frame", "frame", "frame of the pole or of wxyz"),
)


class Target(NamedTuple):
    """A motion and what is said about it: name, source, note (text or None)."""

    motion: object
    name: str
    source: str
    note: str


def add_arguments(parser):
    """NAME|FILE, and the options that complete an entry of the catalogue."""
    parser.add_argument(
        "target",
        metavar="NAME|FILE.toml",
        help="name of the catalogue (a part will do), or spin file: a body and its state",
    )
    group = parser.add_argument_group("what the catalogue does not hold of a body")
    for option, name, _, text in _NUMBERS:
        group.add_argument(option, dest=name, metavar="NUMBERS", nargs="+", help=text)
    for option, name, text in _WORDS:
        group.add_argument(option, dest=name, metavar="WORD", help=text)


def is_file(text):
    """Whether a target means a file: one that exists, or that is written like one."""
    written_so = re.search(r"\.toml$|[/\\]", text) is not None
    return os.path.exists(text) or (written_so and not _listed(text))


def opened(arguments):
    """The Target of parsed arguments.

    Raises
    ------
    AttitudeError
        For a file that cannot be read, a name that is not there, or what is missing of it.
    """
    if is_file(arguments.target):
        return _from_file(arguments)
    from attitude import catalog

    entry = catalog.entry(arguments.target)
    return Target(
        entry.motion(**_given(arguments)), entry.name, "; ".join(entry.sources), entry.note
    )


def incomplete(arguments):
    """The catalogue's entry, if it lacks something and no option was given to complete it."""
    if is_file(arguments.target) or _is_completed(arguments):
        return None
    from attitude import catalog

    entry = catalog.entry(arguments.target)
    return entry if entry.missing else None


def _from_file(arguments):
    from attitude.formats import spin_file

    useless = _is_completed(arguments)
    if useless:
        raise AttitudeError(
            f"{', '.join(useless)} complete a name of the catalogue; in a spin file, write them "
            "into the file."
        )
    found = spin_file.read(arguments.target)
    return Target(found.motion, found.name or arguments.target, found.source, found.note)


def _given(arguments):
    from attitude.textfiles import quantities

    given = {}
    for option, name, unit, _ in _NUMBERS:
        words = getattr(arguments, name)
        if words is not None:
            found = quantities.in_unit(" ".join(words), option, unit)
            given[name] = found[()] if found.size > 1 else float(found.reshape(()))
    for _, name, _ in _WORDS:
        given[name] = getattr(arguments, name)
    return given


def _is_completed(arguments):
    """The options for the catalogue that were given."""
    options = [*(row[:2] for row in _NUMBERS), *(row[:2] for row in _WORDS)]
    return [option for option, name in options if getattr(arguments, name) is not None]


def _listed(text):
    from attitude import catalog

    return any(text.lower() in name.lower() for name in catalog.names())
