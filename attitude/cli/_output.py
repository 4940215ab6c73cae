"""The output of a command: a file, its format by its ending, or standard output; rows of CSV."""

from __future__ import annotations

import argparse
import io
import os
import sys
from collections.abc import Callable, Mapping, Sequence
from contextlib import AbstractContextManager, nullcontext
from typing import TYPE_CHECKING, Any

import numpy as np

from attitude._support import quantity_text
from attitude.epochs import _ccsds as ccsds_epochs
from attitude.errors import AttitudeError
from attitude.formats import tables
from attitude.formats._format import ending_of, endings

if TYPE_CHECKING:
    from astropy.table import Table

    from attitude.cli._options import Grid
    from attitude.motions._free_rotation import FreeRotation
    from attitude.torques._torqued import TorquedRotation


# Attributes of parsed arguments that are files to write.
_WRITTEN = ("output", "figure", "prediction", "animate")
PICTURES: tuple[str, ...] = ("png", "svg", "pdf", "jpg")


def add_argument(
    parser: argparse.ArgumentParser, kinds: str = "x.csv or x.ecsv", exception: str = ""
) -> None:
    """Add the option --output of a command that writes tables, by default to standard output."""
    usual = f"CSV to standard output{exception}"
    text = f"{kinds} (default: {usual}); appears whole or not at all"
    parser.add_argument("--output", metavar="FILE", help=text)


def add_figure(parser: argparse.ArgumentParser) -> None:
    """Add the option --figure."""
    kinds = ", ".join(PICTURES)
    parser.add_argument("--figure", metavar="FILE", help=f"figure, by its ending: {kinds}")


def picture_of(arguments: argparse.Namespace) -> str | None:
    """The format of --figure; None without it."""
    return None if arguments.figure is None else kind_of(arguments.figure, PICTURES, "--figure")


def writes(arguments: argparse.Namespace) -> bool:
    """Whether a command writes a file of --output, --figure, ..."""
    return any(vars(arguments).get(name) is not None for name in _WRITTEN)


def require_usable(arguments: argparse.Namespace) -> None:
    """Raise the AttitudeError for a file of --output, ... that is read, or cannot be written."""
    from attitude._textfiles.atomic_write import require_writable

    words = vars(arguments)
    written = {name: words[name] for name in _WRITTEN if words.get(name) is not None}
    for option, path in written.items():
        label = "OUT" if "input" in words else f"--{option}"
        targets = [path, *_beside(path, words)] if label == "OUT" else [path]
        for target in targets:
            require_writable(target, label)
            for name, value in words.items():
                others = value if isinstance(value, list) else [value]
                if name != option and any(_is_same(target, other) for other in others):
                    raise AttitudeError(
                        f"{label} {target!r} is also a file that the command reads or writes "
                        "otherwise, and would be lost; give another name."
                    )


def _beside(path: str, words: Mapping[str, Any]) -> list[str]:
    """The files that the format of OUT writes beside it."""
    form, stem = endings().get(ending_of(path)), os.path.splitext(path)[0]
    beside = {} if form is None else form.beside
    return [stem + ending for ending, option in beside.items() if not words.get(option)]


def _is_same(path: str, other: object) -> bool:
    """Whether a text names the regular file at a path, or the file that is to be there."""
    if path == other:
        return True
    are_files = isinstance(other, str) and os.path.isfile(path) and os.path.isfile(other)
    return are_files and os.path.samefile(path, str(other))


def draw(name: str | None, plot: Callable[[str], object]) -> None:
    """Write --figure by a function of its name, and print the name; nothing without it."""
    if name is not None:
        plot(name)
        print(name)


def kind_of(
    name: str | None,
    allowed: Sequence[str] = ("csv", "ecsv"),
    option: str = "--output",
    *,
    hint: str = "",
) -> str:
    """The ending of a file, one of those allowed; without a file the first of them."""
    if name is None:
        return allowed[0]
    ending = name.rpartition(".")[2].lower() if "." in name else ""
    if ending not in allowed:
        listed = " or ".join(f".{suffix}" for suffix in allowed)
        said = f"{option} is {name!r}; give a file name that ends in {listed}. {hint}"
        raise AttitudeError(said.rstrip())
    return ending


def opened(name: str | None) -> AbstractContextManager[Any]:
    """The text file of --output, which appears whole or not at all; without one standard output."""
    if name is None:
        require_open(", or give --output FILE")
        return nullcontext(sys.stdout)
    from attitude._textfiles.atomic_write import written_whole

    return written_whole(name, "--output")


def require_open(other: str = "") -> None:
    """Raise the AttitudeError for a standard output that was closed before the start."""
    if sys.stdout is None:
        raise AttitudeError(f"standard output is closed; open it{other}.")


def write_table(table: Table, name: str, kind: str, option: str = "--output") -> None:
    """Write a table of astropy as CSV or ECSV, whole or not at all."""
    from attitude._textfiles.atomic_write import written_whole

    with written_whole(name, option) as file:
        table.write(file, format=f"ascii.{kind}")


# ---- Rows of a table as text, as CSV or as ECSV (which astropy reads with units and times)

# Columns of attitudes, with unit and description.
_ATTITUDES = (
    (tables.ATTITUDE, "", "attitude from body axes to ICRF, scalar first"),
    (tables.RATES, "rad/s", "angular velocity over the body axes"),
    (tables.SIGMA, "rad", "standard deviation of the attitude about an ICRF axis"),
    (tables.SIGMA_RATES, "rad/s", "standard deviation of the angular velocity, body axes"),
)


def header(
    kind: str, motion: FreeRotation | TorquedRotation, *, rates: bool, sigma: bool = False
) -> str:
    """The lines above the rows: names of the columns; in ECSV also units and descriptions."""
    names = tables.names(rates=rates, sigma=sigma)
    if kind == "csv":
        return ",".join(names) + "\n"
    epoch = f"{motion.spin.epoch.utc_iso} UTC"
    meta = {"frame": "ICRF", "epoch": epoch, "wxyz": "body to ICRF, scalar first"}
    labels = [(n, unit, about) for group, unit, about in _ATTITUDES for n in group if n in names]
    return head([("tdb_seconds", "s", "TDB seconds since the epoch"), *labels], meta)


def head(labels: Sequence[tuple[str, str, str | None]], meta: Mapping[str, str]) -> str:
    """The ECSV header of a table: UTC, then columns with name, unit ("") and description.

    Columns called in_ and so on are flags, 0 or 1.
    """
    columns = {
        name: ([1] if name.startswith("in_") else [1.0], unit, about)
        for name, unit, about in labels
    }
    text = ecsv(["2000-01-01T00:00:00"], columns, meta)
    return "".join(text.splitlines(keepends=True)[:-1])


def ecsv(
    dates: Sequence[str],
    columns: Mapping[str, tuple[Any, str, str | None]],
    meta: Mapping[str, str],
) -> str:
    """An ECSV: UTC or "" (masked), then columns by name, each with unit ("") and description."""
    from astropy.table import QTable
    from astropy.time import Time
    from astropy.units import Quantity

    utc = Time([date or dates[0] for date in dates], format="isot", scale="utc", precision=9)
    if "" in dates:
        utc[[not date for date in dates]] = np.ma.masked
    table = QTable({"utc": utc})
    for name, (values, unit, about) in columns.items():
        table[name] = Quantity(values, quantity_text.unit_of(unit, name)) if unit else values
        if about is not None:
            table[name].info.description = about
    table.meta = dict(meta)
    text = io.StringIO()
    table.write(text, format="ascii.ecsv", delimiter=",")
    return text.getvalue()


def rows(
    grid: Grid,
    motion: FreeRotation | TorquedRotation,
    first: int,
    count: int,
    **columns: bool,
) -> str:
    """The text of rows of a grid from `first` on; `columns` are rates= and sigma=."""
    hi, lo = grid.block(first, count)
    dates = ccsds_epochs.texts(grid.epoch, hi, lo, "utc", grid.digits)
    return tables.of_history(dates, hi, motion.at(hi, low=lo), **columns)
