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
# Their standard deviations: rad about the ICRF axes, rad/s over the body axes.
SIGMA: tuple[str, ...] = ("sigma_x", "sigma_y", "sigma_z")
SIGMA_RATES: tuple[str, ...] = ("sigma_omega_x", "sigma_omega_y", "sigma_omega_z")


def names(*, rates: bool, sigma: bool = False) -> list[str]:
    """Names of the columns: UTC, TDB seconds, then those of `numbers`."""
    return ["utc", "tdb_seconds", *names_of_numbers(rates=rates, sigma=sigma)]


def names_of_numbers(*, rates: bool, sigma: bool = False) -> list[str]:
    """Names of the columns of `numbers`."""
    found = [*ATTITUDE, *(RATES if rates else ())]
    if sigma:
        found += [*SIGMA, *(SIGMA_RATES if rates else ())]
    return found


def numbers(history: AttitudeHistory, *, rates: bool, sigma: bool = False) -> list[FloatArray]:
    """Columns (N,) of a history.

    The attitude; with `rates` the angular velocity; with `sigma` their standard deviations.
    """
    columns = [*history.wxyz.T, *(history.angular_velocity.T if rates else ())]
    if sigma:
        # First the one from which the other one follows.
        of_rates = history.sigma_angular_velocity.T if rates else ()
        columns += [*history.sigma.T, *of_rates]
    return columns


def of_history(
    dates: Iterable[str],
    seconds: FloatArray,
    history: AttitudeHistory,
    *,
    rates: bool,
    sigma: bool = False,
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
    sigma : bool
        Write the standard deviations too: rad about the ICRF axes, rad/s over the body axes.
    """
    columns = numbers(history, rates=rates, sigma=sigma)
    return text(dates, seconds.tolist(), *(column.tolist() for column in columns))


def text(dates: Iterable[str], *columns: Iterable[float]) -> str:
    """The text of rows: a date, and one number of each column."""
    pattern = "%s" + ",%r" * len(columns) + "\n"
    return "".join([pattern % row for row in zip(dates, *columns, strict=True)])
