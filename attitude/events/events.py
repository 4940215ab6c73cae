"""The result of a search: epochs in two doubles, and what happens at each."""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from attitude import epochs
from attitude.errors import AttitudeError
from attitude.immutable import Immutable, frozen

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from astropy.time import Time
    from numpy.typing import NDArray

    from attitude.annotations import FloatArray, IntArray
    from attitude.flat_table import FlatTable


class Events(Immutable):
    """Events in order of time; ``times, values = events`` unpacks seconds and values.

    Attributes
    ----------
    epoch : Instant or None
        From which seconds count; None if a plain function of seconds was searched.
    seconds, low : (N,) arrays
        TDB seconds since `epoch`: seconds + low.
    values : (N,) array
        The new state of a condition (True or False) or of a plain function; for an extremum, the
        value that is reached, in the unit of the quantity.
    which : (N,) array of int
        Index of the condition, if several were searched at once; otherwise zeros.
    unit : str
        Of the values of extrema; "" for states.
    """

    epoch: epochs.Instant | None
    seconds: FloatArray
    low: FloatArray
    values: NDArray[Any]
    which: IntArray
    unit: str

    def __init__(
        self,
        epoch: epochs.Instant | None,
        seconds: FloatArray,
        low: FloatArray,
        values: NDArray[Any],
        which: IntArray | None = None,
        unit: str = "",
    ) -> None:
        self._set("unit", unit)
        self._set("epoch", epoch)
        self._set("seconds", frozen(seconds))
        self._set("low", frozen(low))
        self._set("values", frozen(values))
        self._set("which", frozen(np.zeros(len(seconds), int) if which is None else which))

    @classmethod
    def joined(
        cls,
        epoch: epochs.Instant | None,
        parts: Sequence[Events],
        kind: type = bool,
        unit: str = "",
    ) -> Events:
        """The events of successive searches in one object; without any, values of a given type."""
        if not parts:
            return cls(epoch, np.zeros(0), np.zeros(0), np.zeros(0, kind), None, unit)
        columns = zip(*((p.seconds, p.low, p.values, p.which) for p in parts), strict=True)
        seconds, low, values, which = (np.concatenate(column) for column in columns)
        return cls(epoch, seconds, low, values, which, unit)

    @cached_property
    def time(self) -> Time:
        """The epochs (N,) as an astropy Time in TDB.

        Raises
        ------
        AttitudeError
            If `epoch` is None.
        """
        if self.epoch is None:
            raise AttitudeError(
                "the epoch is not known, since a plain function of seconds was searched; give "
                "epoch= to the search to have dates."
            )
        return epochs.times(self.epoch, self.seconds, self.low)

    def __iter__(self) -> Iterator[NDArray[Any]]:
        """The two arrays (seconds, values)."""
        return iter((self.seconds, self.values))

    def __len__(self) -> int:
        return len(self.seconds)

    def __getitem__(self, index: Any) -> Events:
        """Some of the events: events[:10], events[events.values], events[events.which == 2]."""
        index = np.atleast_1d(np.arange(len(self))[index])
        return Events(
            self.epoch,
            self.seconds[index],
            self.low[index],
            self.values[index],
            self.which[index],
            self.unit,
        )

    def at(self, source: Any) -> Any:
        """``source.at(...)`` at these epochs: the AttitudeHistory of a motion, the View of a Scene.

        The source has the `epoch` of the events.
        """
        return source.at(self.seconds, self.low)

    def spans(self) -> FloatArray:
        """Begin and end (M, 2) in seconds of each span in which a condition holds.

        A span that begins or ends outside of the search is left out.

        Raises
        ------
        AttitudeError
            For events of several conditions, and events that are not those of conditions.
        """
        if self.values.dtype != bool or len(np.unique(self.which)) > 1:
            raise AttitudeError(
                "spans are those of one condition that begins and ceases; pick it with "
                "events[events.which == k]."
            )
        begins = np.flatnonzero(self.values[:-1] & ~self.values[1:])
        return np.stack([self.seconds[begins], self.seconds[begins + 1]], axis=-1)

    def table(self) -> FlatTable:
        """An astropy QTable: time (UTC), value, and which of several conditions.

        ``.write("x.ecsv")`` keeps times and units; ``.write("x.csv")`` has the numbers alone.

        Raises
        ------
        AttitudeError
            If `epoch` is None.
        """
        from astropy.units import Unit

        from attitude.flat_table import FlatTable

        time = self.time.utc
        time.format = "isot"
        found = FlatTable({"time": time}, meta={"times": "UTC"})
        found["value"] = self.values * Unit(self.unit) if self.unit else np.array(self.values)
        if np.any(self.which):
            found["which"] = np.array(self.which)
        return found

    def to_pandas(self) -> Any:
        """A pandas DataFrame of `table`; AttitudeError if pandas is not installed."""
        return self.table().to_pandas()

    def __repr__(self) -> str:
        start = "" if self.epoch is None else f" from {self.epoch.utc_iso} UTC"
        return f"<{len(self)} Events, seconds{start}>"
