"""Rows of a table as text, as CSV or as ECSV (which astropy reads with units and times)."""

from __future__ import annotations

import io
from typing import TYPE_CHECKING

from attitude.formats import csv_rows
from attitude.formats.ccsds import epochs as ccsds_epochs

if TYPE_CHECKING:
    from astropy.table import QTable

    from attitude.cli.grid import Grid
    from attitude.free_rotation.free_rotation import FreeRotation


def header(kind: str, motion: FreeRotation, *, rates: bool, sigma: bool = False) -> str:
    """The lines above the rows: names of the columns; in ECSV also units and descriptions.

    Parameters
    ----------
    kind : str
        "csv" or "ecsv".
    motion : FreeRotation
    rates : bool
        Whether there are columns of the angular velocity.
    sigma : bool
        Whether there are columns of standard deviations.
    """
    if kind == "csv":
        return ",".join(csv_rows.names(rates=rates, sigma=sigma)) + "\n"
    from astropy.units import Quantity

    iso = motion.spin.epoch.utc_iso
    table = first_row(iso)
    table["tdb_seconds"].info.description = "TDB seconds since the epoch"
    for name in csv_rows.ATTITUDE:
        table[name] = [1.0]
        table[name].info.description = "attitude from body axes to ICRF, scalar first"
    for name in csv_rows.RATES if rates else ():
        table[name] = Quantity([0.0], "rad/s")
        table[name].info.description = "angular velocity over the body axes"
    for name in csv_rows.SIGMA if sigma else ():
        table[name] = Quantity([0.0], "rad")
        table[name].info.description = "standard deviation of the attitude about an ICRF axis"
    for name in csv_rows.SIGMA_RATES if sigma and rates else ():
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
    grid: Grid, motion: FreeRotation, first: int, count: int, *, rates: bool, sigma: bool = False
) -> str:
    """The text of rows of a grid from `first` on: UTC, TDB seconds, attitude, angular velocity.

    Numbers are written so that reading gives the same doubles.

    Parameters
    ----------
    grid : Grid
    motion : FreeRotation
    first, count : int
        Number of the first row, and how many rows at most.
    rates : bool
        Whether the angular velocity is written.
    sigma : bool
        Whether standard deviations are written.
    """
    hi, lo = grid.block(first, count)
    history = motion.at(hi, low=lo)
    dates = ccsds_epochs.texts(grid.epoch, hi, lo, "utc", grid.digits)
    return csv_rows.of_history(dates, hi, history, rates=rates, sigma=sigma)
