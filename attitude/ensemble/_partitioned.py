"""An ensemble in partitions of dask: the same answers, computed where the members are.

Each partition is an `Ensemble` of its own, and each answer is a dask array or dataframe in the same
partitions.  Nothing is computed before the caller asks for it: by threads, by the processes of a
``distributed.LocalCluster``, or by any other cluster.
"""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from attitude._support import validation
from attitude._support.arrays import Immutable
from attitude.ensemble._ensemble import Ensemble, EnsembleHistory
from attitude.errors import AttitudeError
from attitude.formats import tables

if TYPE_CHECKING:
    from attitude._support.annotations import Epochs, FilePath, Reals


# Arrays that `of_arrays` takes, and the shape of one row of each.
_ROWS: dict[str, tuple[int, ...]] = {
    "wxyz": (4,),
    "angular_velocity": (3,),
    "moments": (3,),
    "tensors": (3, 3),
}


class PartitionedEnsemble(Immutable):
    """The members of an ensemble in K partitions; made by `of_dataframe` or `of_arrays`.

    Attributes
    ----------
    parts : tuple of K dask Delayed
        An `Ensemble` each.
    lengths : tuple of K int or nan
        Numbers of members; nan where the partitions of a dataframe were not counted.

    From arrays that no memory holds::

        import dask.array as da

        many = PartitionedEnsemble.of_arrays(
            moments=da.from_array(moments, chunks=(10**5, 3)),
            wxyz=...,
            angular_velocity=...,
            epoch="2026-01-01",
        )
        many.at(np.linspace(0.0, 3600.0, 61)).max().compute()
    """

    parts: tuple[Any, ...]
    lengths: tuple[float, ...]

    def __init__(self, parts: Sequence[Any], lengths: Sequence[float]) -> None:
        self._set_all(parts=tuple(parts), lengths=tuple(lengths))

    @classmethod
    def of_dataframe(cls, frame: Any, *, count: bool = True, **options: Any) -> PartitionedEnsemble:
        """The members in the rows of a dask dataframe with the columns of `Ensemble.from_table`."""
        dask = _dask()
        if not hasattr(frame, "to_delayed") or not hasattr(frame, "npartitions"):
            raise AttitudeError(
                f"frame is {validation.shown(frame)}; give a dask dataframe, for example by "
                "dask.dataframe.read_parquet."
            )
        ensemble_of = dask.delayed(Ensemble.from_table)
        parts = [ensemble_of(partition, **options) for partition in frame.to_delayed()]
        lengths = [math.nan] * len(parts)
        if validation.flag(count, "count"):
            lengths = list(dask.compute(*[dask.delayed(len)(partition) for partition in parts]))
        return cls(parts, lengths)

    @classmethod
    def of_arrays(cls, **arrays: Any) -> PartitionedEnsemble:
        """The members in the rows of dask arrays, in the chunks of ``wxyz``."""
        dask = _dask()
        wxyz: Any = arrays.get("wxyz")
        if not _is_lazy(wxyz) or wxyz.ndim != 2:
            raise AttitudeError(
                f"wxyz is {validation.shown(wxyz)}; give a dask array (N, 4), whose chunks are the "
                "partitions of the members."
            )
        chunks = wxyz.chunks[0]
        common = {name: value for name, value in arrays.items() if not _is_lazy(value)}
        blocks = {
            name: _blocks(value, name, chunks, _ROWS.get(name))
            for name, value in arrays.items()
            if _is_lazy(value)
        }
        parts = [
            dask.delayed(_of_arrays)({name: rows[k] for name, rows in blocks.items()}, common)
            for k in range(len(chunks))
        ]
        return cls(parts, chunks)

    def __len__(self) -> int:
        """The number of members, if those of all partitions are known."""
        total = sum(self.lengths)
        if math.isnan(total):
            raise AttitudeError("the members are not counted; make the ensemble with count=True.")
        return int(total)

    def at(self, t: Epochs, *, angular_velocity: bool = False) -> Any:
        """Attitudes (N, T, 4), a dask array with a chunk for each partition; t (T,)."""
        with_rates = validation.flag(angular_velocity, "angular_velocity")
        times, length = self._epochs(t)
        tasks = self._mapped(_attitudes, [(time, with_rates) for time in times])
        parts = self._arrays(tasks, 0, (length, 4))
        return (parts, self._arrays(tasks, 1, (length, 3))) if with_rates else parts

    def brightness(self, t: Epochs, sun: Reals, observer: Reals, **options: Any) -> Any:
        """Brightness (N, T), m2/sr, a dask array with a chunk for each partition; sun (3,)."""
        times, length = self._epochs(t)
        keywords = {"sun": sun, "observer": observer, **options}
        options_of_parts = [{"t": time} for time in times]
        for name, value in keywords.items():
            split = [value] * len(options_of_parts)
            if _is_lazy(value):
                split = _blocks(value, name, self.lengths)
            for options_of_part, piece in zip(options_of_parts, split, strict=True):
                options_of_part[name] = piece
        tasks = self._mapped(_brightness, [(options,) for options in options_of_parts])
        return self._arrays(tasks, None, (length,))

    def rows(
        self,
        frame: Any,
        *,
        member: str = "member",
        seconds: str = "seconds",
        angular_velocity: bool = False,
    ) -> Any:
        """A dask dataframe of ragged rows, with columns of attitudes (and rates) added."""
        from dask import dataframe

        rows = frame.to_delayed()
        if len(rows) != len(self.parts):
            raise AttitudeError(
                f"frame has {len(rows)} partitions and the ensemble {len(self.parts)}; repartition "
                "the rows so that those of each member lie in its partition."
            )
        missing = [name for name in (member, seconds) if name not in frame.columns]
        if missing:
            raise AttitudeError(f"frame has no column {missing[0]!r}.")
        with_rates = validation.flag(angular_velocity, "angular_velocity")
        added = {name: np.empty(0, "f8") for name in tables.ATTITUDE + tables.RATES * with_rates}
        tasks = self._mapped(_rows, [(row, member, seconds, with_rates) for row in rows])
        return dataframe.from_delayed(tasks, meta=frame._meta.assign(**added))

    def map(self, function: Callable[..., Any], *others: Sequence[Any]) -> list[Any]:
        """Delayed ``function(ensemble, *values)`` of each partition.

        `others` are sequences of K values, one for each partition, such as ``array.to_delayed()``.
        """
        return self._mapped(function, list(zip(*others, strict=True)) or [()] * len(self.parts))

    def write(self, folder: FilePath, t: Epochs, *, angular_velocity: bool = False) -> list[Any]:
        """Delayed tasks that write the attitudes of each partition to a parquet file.

        Each file, ``part-00000.parquet`` and so on, appears whole or not at all: a task that was
        interrupted and runs again writes it anew.  Columns: member (from 0 in each partition) or
        name, seconds, and those of `rows`.  The tasks return the names of the files.
        """
        os.makedirs(folder, exist_ok=True)
        with_rates = validation.flag(angular_velocity, "angular_velocity")
        times, _ = self._epochs(t)
        files = [os.path.join(folder, f"part-{k:05d}.parquet") for k in range(len(times))]
        tasks = [(*row, with_rates) for row in zip(times, files, strict=True)]
        return self._mapped(_written, tasks)

    def _mapped(
        self, function: Callable[..., Any], arguments: Sequence[tuple[Any, ...]]
    ) -> list[Any]:
        task = _dask().delayed(function, pure=True)
        pairs = zip(self.parts, arguments, strict=True)
        return [task(partition, *values) for partition, values in pairs]

    def _epochs(self, t: Any) -> tuple[list[Any], float]:
        """The epochs of each partition, and how many they are."""
        if _is_lazy(t):
            return _blocks(t, "t", self.lengths), t.shape[1]
        if isinstance(t, str) or getattr(t, "shape", None) == () or not hasattr(t, "__len__"):
            raise AttitudeError("t is a single epoch; give an array (T,).")
        return [t] * len(self.parts), len(t)

    def _arrays(self, tasks: list[Any], k: int | None, row: tuple[Any, ...]) -> Any:
        """The dask array of the results of the partitions, or of their k-th entries."""
        from dask import array

        parts = [
            array.from_delayed(task if k is None else task[k], (length, *row), dtype=np.float64)
            for task, length in zip(tasks, self.lengths, strict=True)
        ]
        return array.concatenate(parts, allow_unknown_chunksizes=True)


def _of_arrays(rows: Mapping[str, Any], common: Mapping[str, Any]) -> Ensemble:
    arrays: dict[str, Any] = {name: np.array(values) for name, values in rows.items()}
    return Ensemble(**arrays, **common)


def _attitudes(ensemble: Ensemble, t: Any, rates: bool) -> tuple[Any, ...]:
    history = ensemble.at(t, angular_velocity=rates)
    return (history.wxyz, history.angular_velocity) if rates else (history.wxyz,)


def _brightness(ensemble: Ensemble, options: Mapping[str, Any]) -> Any:
    return ensemble.brightness(**options)


def _rows(ensemble: Ensemble, rows: Any, member: str, seconds: str, rates: bool) -> Any:
    t = np.array(rows[seconds], dtype=np.float64)
    history = ensemble.at(t, member=rows[member].to_numpy(), angular_velocity=rates)
    return rows.assign(**_columns(history, rates))


def _written(ensemble: Ensemble, t: Any, file: str, rates: bool) -> str:
    history = ensemble.at(t, angular_velocity=rates)
    count, length = history.wxyz.shape[:2]
    who = np.arange(count) if ensemble.names is None else np.asarray(ensemble.names)
    seconds = np.broadcast_to(history.seconds, (count, length))
    columns = {
        "member" if ensemble.names is None else "name": np.repeat(who, length),
        "seconds": seconds.reshape(-1),
        **_columns(history, rates),
    }
    tables.write_parquet_columns(file, columns, {"wxyz": "body to ICRF, scalar first"})
    return file


def _columns(history: EnsembleHistory, rates: bool) -> dict[str, Any]:
    """Columns of the attitudes, and with rates of the angular velocities, of a history."""
    columns = dict(zip(tables.ATTITUDE, history.wxyz.reshape(-1, 4).T, strict=True))
    if rates:
        columns |= dict(zip(tables.RATES, history.angular_velocity.reshape(-1, 3).T, strict=True))
    return columns


def _blocks(
    array: Any, name: str, chunks: Sequence[float], row: tuple[int, ...] | None = None
) -> list[Any]:
    """The delayed blocks of a dask array, one for each partition of the members."""
    if row is not None and array.shape[1:] != row:
        raise AttitudeError(
            f"{name} has shape {array.shape}; give (N, {', '.join(map(str, row))})."
        )
    if any(math.isnan(length) for length in chunks):
        raise AttitudeError("the members are not counted; make the ensemble with count=True.")
    if array.shape[0] != sum(chunks):
        raise AttitudeError(
            f"{name} has {array.shape[0]} rows, but there are {int(sum(chunks))} members."
        )
    whole = {axis: -1 for axis in range(1, array.ndim)}
    return list(array.rechunk({0: tuple(map(int, chunks)), **whole}).to_delayed().reshape(-1))


def _is_lazy(value: Any) -> bool:
    return hasattr(value, "dask") and hasattr(value, "chunks")


def _dask() -> Any:
    try:
        import dask
    except ModuleNotFoundError as err:
        raise AttitudeError(
            f"dask is not installed; install it by {validation.installing('dask')}."
        ) from err
    return dask
