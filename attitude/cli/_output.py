"""The output of a command: a file, its format by its ending, or standard output; rows of CSV."""

from __future__ import annotations

import argparse
import io
import sys
from collections.abc import Sequence
from contextlib import AbstractContextManager, nullcontext
from typing import TYPE_CHECKING, Any

from attitude.errors import AttitudeError
from attitude.formats import _ccsds_epochs as ccsds_epochs
from attitude.formats import tables

if TYPE_CHECKING:
    from astropy.table import QTable

    from attitude.cli._options import Grid
    from attitude.motions._free_rotation import FreeRotation
    from attitude.torques._torqued import TorquedRotation


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
        return nullcontext(sys.stdout)
    from attitude._textfiles.atomic_write import written_whole

    return written_whole(name, "--output")


# ---- Rows of a table as text, as CSV or as ECSV (which astropy reads with units and times)


def header(
    kind: str, motion: FreeRotation | TorquedRotation, *, rates: bool, sigma: bool = False
) -> str:
    """The lines above the rows: names of the columns; in ECSV also units and descriptions."""
    if kind == "csv":
        return ",".join(tables.names(rates=rates, sigma=sigma)) + "\n"
    from astropy.units import Quantity

    iso = motion.spin.epoch.utc_iso
    table = first_row(iso)
    table["tdb_seconds"].info.description = "TDB seconds since the epoch"
    for name in tables.ATTITUDE:
        table[name] = [1.0]
        table[name].info.description = "attitude from body axes to ICRF, scalar first"
    for name in tables.RATES if rates else ():
        table[name] = Quantity([0.0], "rad/s")
        table[name].info.description = "angular velocity over the body axes"
    for name in tables.SIGMA if sigma else ():
        table[name] = Quantity([0.0], "rad")
        table[name].info.description = "standard deviation of the attitude about an ICRF axis"
    for name in tables.SIGMA_RATES if sigma and rates else ():
        table[name] = Quantity([0.0], "rad/s")
        table[name].info.description = "standard deviation of the angular velocity, body axes"
    table.meta = {"frame": "ICRF", "epoch": f"{iso} UTC", "wxyz": "body to ICRF, scalar first"}
    return head(table)


def first_row(utc: str) -> QTable:
    """A QTable of one row at a date, with the first two columns of all tables here."""
    from astropy.table import QTable
    from astropy.time import Time
    from astropy.units import Quantity

    table = QTable({"utc": Time([utc], format="isot", scale="utc", precision=9)})
    table["tdb_seconds"] = Quantity([0.0], "s")
    return table


def head(table: QTable) -> str:
    """The ECSV header that astropy writes above the row of a table of one row."""
    text = io.StringIO()
    table.write(text, format="ascii.ecsv", delimiter=",")
    return "".join(text.getvalue().splitlines(keepends=True)[:-1])


def rows(
    grid: Grid,
    motion: FreeRotation | TorquedRotation,
    first: int,
    count: int,
    *,
    rates: bool,
    sigma: bool = False,
) -> str:
    """The text of rows of a grid from `first` on: UTC, TDB seconds, attitude, angular velocity.

    Numbers are written so that reading gives the same doubles.
    """
    hi, lo = grid.block(first, count)
    history = motion.at(hi, low=lo)
    dates = ccsds_epochs.texts(grid.epoch, hi, lo, "utc", grid.digits)
    return tables.of_history(dates, hi, history, rates=rates, sigma=sigma)
