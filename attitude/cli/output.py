"""Where a command writes: a file whose ending tells the kind, or standard output."""

import sys
from contextlib import nullcontext

from attitude.errors import AttitudeError

PICTURES = ("png", "svg", "pdf", "jpg")


def add_argument(parser):
    """The option --output of a command that writes tables."""
    parser.add_argument(
        "--output",
        metavar="FILE",
        help="x.csv or x.ecsv (default: CSV to standard output); appears whole or not at all",
    )


def kind_of(name, allowed=("csv", "ecsv"), option="--output"):
    """The kind of a file, one of the endings that are allowed; without a file the first."""
    if name is None:
        return allowed[0]
    ending = name.rpartition(".")[2].lower() if "." in name else ""
    if ending not in allowed:
        listed = " or ".join(f".{each}" for each in allowed)
        raise AttitudeError(f"{option} is {name!r}; give a file name that ends in {listed}.")
    return ending


def opened(name):
    """The file of --output, which appears whole or not at all; without one standard output."""
    if name is None:
        return nullcontext(sys.stdout)
    from attitude.textfiles.atomic_write import written_whole

    return written_whole(name, "--output")
