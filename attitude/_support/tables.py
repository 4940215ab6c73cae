"""Tables of astropy whose columns of vectors are written to CSV as a column for each component.

Importing this module imports astropy, so modules import it inside the functions that make tables.
"""

from __future__ import annotations

import os
from typing import Any, ClassVar

import numpy as np
from astropy.table import QTable
from astropy.time import Time

from attitude.errors import AttitudeError


class FlatTable(QTable):
    """A QTable; `write` to CSV splits columns of vectors, and `to_pandas` too.

    flat_names: names of the components by the name of a column; otherwise name_0, name_1 and so on.
    """

    flat_names: ClassVar[dict[str, tuple[str, ...]]] = {
        "wxyz": ("w", "x", "y", "z"),
        "angular_velocity": ("omega_x", "omega_y", "omega_z"),
        "sigma": ("sigma_x", "sigma_y", "sigma_z"),
        "sigma_angular_velocity": ("sigma_omega_x", "sigma_omega_y", "sigma_omega_z"),
    }

    def flat(self) -> QTable:
        """The table with one column for each component of vectors.

        The names of columns in other units than SI end in the unit, as in "elevation [deg]".
        """
        return self._by_components(are_times_numbers=False)

    def _by_components(self, *, are_times_numbers: bool) -> QTable:
        """The columns of `flat`; with `are_times_numbers` times as `_of_times` has them."""
        columns = QTable(meta=self.meta)
        for name in self.colnames:
            column = self[name]
            if are_times_numbers and isinstance(column, Time):
                columns.update(_of_times(name, column))
                continue
            unit = _unit_in_name(column)
            if len(column.shape) == 1:
                columns[name + unit] = column
                continue
            width = int(np.prod(column.shape[1:]))
            rows = column.reshape(len(self), width)
            known = self.flat_names.get(name, ())
            names = known if len(known) == width else [f"{name}_{k}" for k in range(width)]
            for k, component in enumerate(names):
                columns[component + unit] = rows[:, k]
        return columns

    def write(self, *arguments: Any, **options: Any) -> None:
        """As `astropy.table.Table.write`; to CSV the columns of `flat`.

        Times keep both doubles: ECSV has them as jd1 and jd2, CSV as the columns tdb_jd1 and
        tdb_jd2 (of the scale of the times), or those in UTC as text of 9 decimals, column "utc".
        """
        kind = options.get("format", "")
        if not kind and arguments and isinstance(arguments[0], (str, os.PathLike)):
            kind = os.path.splitext(os.fspath(arguments[0]))[1].lstrip(".")
        ending = str(kind).lower().split(".")[-1]
        if ending == "csv":
            self._by_components(are_times_numbers=True).write(*arguments, **options)
            return
        if ending == "ecsv":
            options.setdefault("serialize_method", {Time: "jd1_jd2"})
        QTable(self).write(*arguments, **options)

    def to_pandas(self, *arguments: Any, **options: Any) -> Any:
        """A pandas DataFrame: times as UTC, the columns of `flat`, units in ``.attrs``."""
        try:
            import pandas
        except ImportError as err:
            raise AttitudeError(
                "a DataFrame needs pandas, which is not installed; run pip install pandas, or use "
                ".table()."
            ) from err
        columns, units = {}, {}
        plain = self.flat()
        for name in plain.colnames:
            column = plain[name]
            if isinstance(column, Time):
                columns[name] = pandas.to_datetime(_utc(column), utc=True)
                continue
            unit = getattr(column, "unit", None)
            if unit is not None:
                units[name] = str(unit)
            columns[name] = np.array(getattr(column, "value", column))
        frame = pandas.DataFrame(columns, *arguments, **options)
        frame.attrs.update(units=units)
        return frame


def _unit_in_name(column: Any) -> str:
    """The unit of a column in brackets if numbers in it are not those in SI units, radians, mag."""
    unit = getattr(column, "unit", None)
    if unit is None or unit.decompose().scale == 1.0:
        return ""
    return f" [{unit}]"


def _of_times(name: str, time: Time) -> dict[str, Any]:
    """The columns of CSV for a column of times, each with the time scale in its name."""
    before = "" if name == "time" else f"{name}_"
    if time.scale == "utc":
        text = time.copy(format="isot")
        text.precision = 9
        masked = np.broadcast_to(np.asarray(time.mask), time.shape)
        return {f"{before}utc": np.where(masked, "", np.asarray(np.ma.getdata(text.value)))}
    scale = f"{before}{time.scale}"
    return {
        f"{scale}_jd1": np.ma.filled(time.jd1, np.nan),
        f"{scale}_jd2": np.ma.filled(time.jd2, np.nan),
    }


def _utc(time: Any) -> Any:
    """Times as datetime64 of UTC; NaT where masked."""
    known = ~np.asarray(np.ma.getmaskarray(np.ma.asarray(time.mask)) | time.mask, dtype=bool)
    dates = np.full(time.shape, np.datetime64("NaT"), dtype="datetime64[ns]")
    if np.any(known):
        dates[known] = np.asarray(time[known].utc.datetime64)
    return dates
