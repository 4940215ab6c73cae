"""Rows of a table as text, as CSV or as ECSV (which astropy reads with its units and times)."""

import io

from attitude.formats import ccsds_epochs

_ATTITUDE = ("w", "x", "y", "z")
_RATES = ("omega_x", "omega_y", "omega_z")


def header(kind, motion, *, rates):
    """What stands above the rows: the names of the columns and, in ECSV, what they are.

    Parameters
    ----------
    kind : str
        "csv" or "ecsv".
    motion : FreeRotation
    rates : bool
    """
    names = ["utc", "tdb_seconds", *_ATTITUDE, *(_RATES if rates else ())]
    if kind == "csv":
        return ",".join(names) + "\n"
    from astropy.table import QTable
    from astropy.time import Time
    from astropy.units import Quantity

    # astropy writes the head of a table of one row; the rows are ours, as they come.
    iso = motion.spin.epoch.utc_iso
    table = QTable({"utc": Time([iso], format="isot", scale="utc", precision=9)})
    table["tdb_seconds"] = Quantity([0.0], "s")
    table["tdb_seconds"].info.description = "TDB seconds since the epoch"
    for name in _ATTITUDE:
        table[name] = [1.0]
        table[name].info.description = "attitude from body axes to ICRF, scalar first"
    for name in _RATES if rates else ():
        table[name] = Quantity([0.0], "rad/s")
        table[name].info.description = "angular velocity over the body axes"
    table.meta = {"frame": "ICRF", "epoch": f"{iso} UTC", "wxyz": "body to ICRF, scalar first"}
    text = io.StringIO()
    table.write(text, format="ascii.ecsv", delimiter=",")
    lines = text.getvalue().splitlines(keepends=True)
    return "".join(lines[:-1])


def rows(grid, motion, first, count, *, rates):
    """The text of some rows: UTC, TDB seconds, attitude and, if asked for, angular velocity.

    Numbers are written so that reading gives the same doubles.
    """
    hi, lo = grid.block(first, count)
    history = motion.at(hi, low=lo)
    dates = ccsds_epochs.texts(grid.epoch, hi, lo, "utc", grid.digits)
    columns = [hi.tolist(), *history.wxyz.T.tolist()]
    if rates:
        columns += history.angular_velocity.T.tolist()
    pattern = "%s" + ",%r" * len(columns) + "\n"
    return "".join([pattern % row for row in zip(dates, *columns, strict=True)])
