"""Rows of a table as text, as CSV or as ECSV (which astropy reads with its units and times)."""

import io

from attitude.formats import csv_rows
from attitude.formats.ccsds import epochs as ccsds_epochs


def header(kind, motion, *, rates):
    """What stands above the rows: the names of the columns and, in ECSV, what they are.

    Parameters
    ----------
    kind : str
        "csv" or "ecsv".
    motion : FreeRotation
    rates : bool
    """
    if kind == "csv":
        return ",".join(csv_rows.names(rates=rates)) + "\n"
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
    table.meta = {"frame": "ICRF", "epoch": f"{iso} UTC", "wxyz": "body to ICRF, scalar first"}
    return head(table)


def first_row(utc):
    """A QTable of one row, with the columns that all tables here begin with."""
    from astropy.table import QTable
    from astropy.time import Time
    from astropy.units import Quantity

    table = QTable({"utc": Time([utc], format="isot", scale="utc", precision=9)})
    table["tdb_seconds"] = Quantity([0.0], "s")
    return table


def head(table):
    """What astropy writes above the row of a table; the rows are ours, as they come."""
    text = io.StringIO()
    table.write(text, format="ascii.ecsv", delimiter=",")
    return "".join(text.getvalue().splitlines(keepends=True)[:-1])


def rows(grid, motion, first, count, *, rates):
    """The text of some rows: UTC, TDB seconds, attitude and, if asked for, angular velocity.

    Numbers are written so that reading gives the same doubles.
    """
    hi, lo = grid.block(first, count)
    history = motion.at(hi, low=lo)
    dates = ccsds_epochs.texts(grid.epoch, hi, lo, "utc", grid.digits)
    return csv_rows.of_history(dates, hi, history, rates=rates)
