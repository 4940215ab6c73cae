"""The output of a command: a file, its format by its ending, or standard output."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from contextlib import AbstractContextManager, nullcontext
from typing import Any

from attitude.errors import AttitudeError

PICTURES: tuple[str, ...] = ("png", "svg", "pdf", "jpg")


def add_argument(parser: argparse.ArgumentParser) -> None:
    """Add the option --output of a command that writes tables."""
    parser.add_argument(
        "--output",
        metavar="FILE",
        help="x.csv or x.ecsv (default: CSV to standard output); appears whole or not at all",
    )


def kind_of(
    name: str | None,
    allowed: Sequence[str] = ("csv", "ecsv"),
    option: str = "--output",
    *,
    hint: str = "",
) -> str:
    """The ending of a file, one of those allowed; without a file the first of them.

    Parameters
    ----------
    hint : str
        A sentence for the error.

    Raises
    ------
    AttitudeError
        For another ending; the message names the option.
    """
    if name is None:
        return allowed[0]
    ending = name.rpartition(".")[2].lower() if "." in name else ""
    if ending not in allowed:
        listed = " or ".join(f".{each}" for each in allowed)
        said = f"{option} is {name!r}; give a file name that ends in {listed}. {hint}"
        raise AttitudeError(said.rstrip())
    return ending


def opened(name: str | None) -> AbstractContextManager[Any]:
    """The text file of --output, which appears whole or not at all; without one standard output."""
    if name is None:
        return nullcontext(sys.stdout)
    from attitude.textfiles.atomic_write import written_whole

    return written_whole(name, "--output")
