"""Rows of events with named columns: times, numbers with units, names; as tables and files."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from attitude import epochs
from attitude.errors import AttitudeError
from attitude.immutable import Immutable, frozen

if TYPE_CHECKING:
    from collections.abc import Mapping

    from astropy.time import Time
    from numpy.typing import NDArray

    from attitude.flat_table import FlatTable


class TimetableColumn(NamedTuple):
    """A column: its values (N,), their unit (SI), that of tables, and the low part of a time.

    The unit "time" is that of TDB seconds since the epoch; "" that of pure numbers and names.
    """

    values: NDArray[Any]
    unit: str = ""
    shown: str = ""
    low: NDArray[Any] | float = 0.0


class Timetable(Immutable):
    """Rows of events in order of time; each column is an attribute (N,) too.

    Plain numbers of times are TDB seconds since `epoch`; `time` gives dates.

    Attributes
    ----------
    epoch : Instant
        That of the motion; J2000 for a scene without a motion.
    columns : dict of TimetableColumn
        By name.
    """

    epoch: epochs.Instant
    columns: dict[str, TimetableColumn]

    def __init__(self, epoch: epochs.Instant, columns: Mapping[str, TimetableColumn]) -> None:
        self._set("epoch", epoch)
        self._set("columns", dict(columns))
        for name, column in columns.items():
            self._set(name, frozen(np.asarray(column.values)))

    if not TYPE_CHECKING:

        def __getattr__(self, name: str) -> Any:
            """The sentence for a column that is not there."""
            columns = self.__dict__.get("columns", {})
            raise AttributeError(
                f"{type(self).__name__} has no {name!r}; its columns are {', '.join(columns)}."
            )
    else:

        def __getattr__(self, name: str) -> NDArray[Any]:
            """A column."""
            return self.columns[name].values

    def __len__(self) -> int:
        return len(next(iter(self.columns.values())).values)

    def __getitem__(self, index: Any) -> Timetable:
        """Some of the rows: found[:3], found[found.elevation > 1]."""
        rows = np.atleast_1d(np.arange(len(self))[index])
        columns = {
            name: each._replace(
                values=each.values[rows],
                low=each.low[rows] if isinstance(each.low, np.ndarray) else each.low,
            )
            for name, each in self.columns.items()
        }
        return self._with(columns)

    def _with(self, columns: Mapping[str, TimetableColumn]) -> Timetable:
        return Timetable(self.epoch, columns)

    def time(self, name: str) -> Time:
        """A column of times (N,) as an astropy Time in UTC; masked where it is not known.

        Raises
        ------
        AttitudeError
            For a column that holds no times.
        """
        times = [each for each, column in self.columns.items() if column.unit == "time"]
        if name not in times:
            raise AttitudeError(f"{name!r} is no column of times; give one of {', '.join(times)}.")
        column = self.columns[name]
        rest = np.broadcast_to(np.asarray(column.low, dtype=float), column.values.shape)
        found = epochs.times(self.epoch, column.values, rest).utc
        found.format = "isot"
        return found

    def table(self) -> FlatTable:
        """An astropy QTable: times in UTC, numbers with units; ``.write("x.ecsv")`` keeps both."""
        from astropy.units import Unit

        from attitude.flat_table import FlatTable

        found = FlatTable(meta={"epoch": f"{self.epoch.utc_iso} UTC", "times": "UTC"})
        for name, column in self.columns.items():
            if column.unit == "time":
                found[name] = self.time(name)
            elif column.unit:
                values = np.array(column.values) * Unit(column.unit)
                found[name] = values.to(column.shown or column.unit)
            else:
                found[name] = np.array(column.values)
        return found

    def to_pandas(self) -> Any:
        """A pandas DataFrame of `table`; AttitudeError if pandas is not installed."""
        return self.table().to_pandas()

    def __repr__(self) -> str:
        return f"<{len(self)} {type(self).__name__}: {', '.join(self.columns)}>"

    def __str__(self) -> str:
        shown = self.table()
        for name in shown.colnames:
            if shown[name].dtype.kind == "f" if hasattr(shown[name], "dtype") else False:
                shown[name].info.format = ".3f"
        return "\n".join(shown.pformat(max_lines=-1, max_width=-1))
