"""The CSV of attitudes: its columns, and rows whose numbers are read back as the same doubles."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterable

    from attitude.annotations import FloatArray
    from attitude.history import AttitudeHistory

# Columns of the attitude (body to ICRF, scalar first) and of the angular velocity (rad/s, body).
ATTITUDE: tuple[str, ...] = ("w", "x", "y", "z")
RATES: tuple[str, ...] = ("omega_x", "omega_y", "omega_z")


def names(*, rates: bool) -> list[str]:
    """Names of the columns: UTC, TDB seconds, attitude and, if `rates`, angular velocity."""
    return ["utc", "tdb_seconds", *ATTITUDE, *(RATES if rates else ())]


def of_history(
    dates: Iterable[str], seconds: FloatArray, history: AttitudeHistory, *, rates: bool
) -> str:
    """The text of N rows with the columns `names`.

    Parameters
    ----------
    dates : iterable of str
        UTC of each row.
    seconds : (N,) array
        TDB seconds of each row.
    history : AttitudeHistory
    rates : bool
        Write the angular velocity too, rad/s over the body axes.
    """
    columns = [*history.wxyz.T, *(history.angular_velocity.T if rates else ())]
    return text(dates, seconds.tolist(), *(column.tolist() for column in columns))


def text(dates: Iterable[str], *columns: Iterable[float]) -> str:
    """The text of rows: a date, and one number of each column."""
    pattern = "%s" + ",%r" * len(columns) + "\n"
    return "".join([pattern % row for row in zip(dates, *columns, strict=True)])
