"""Parquet files of attitudes, by pyarrow.

Columns are ``tdb_jd1, tdb_jd2, w, x, y, z``, ``omega_x, omega_y, omega_z`` and standard deviations,
as in CSV; the meta data of `tables.qtable` stand as JSON under the key "attitude" of the schema.
"""

from __future__ import annotations

import json
import os
from typing import TYPE_CHECKING, Any

import numpy as np

from attitude import calls, pairs
from attitude.epochs import time_scales
from attitude.errors import AttitudeError
from attitude.formats import csv_rows
from attitude.textfiles.atomic_write import written_whole

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from astropy.table import Table

    from attitude.annotations import FilePath
    from attitude.formats.sources import Records

# Rows of a group, which readers hold in memory at a time.
_GROUP = 1 << 17


def write(
    path: FilePath,
    parts: Sequence[Records],
    *,
    rates: bool,
    meta: Mapping[str, Any],
    sigma: bool = False,
) -> None:
    """Write segments piece by piece.

    Parameters
    ----------
    path : str or path
        Appears whole or not at all.
    parts : sequence of Records
    rates : bool
        Write angular velocities too.
    meta : mapping
        Meta data, of types that JSON has.
    sigma : bool
        Write standard deviations too.

    Raises
    ------
    AttitudeError
        If pyarrow is not installed, the file cannot be written, or a motion has no covariance.
    """
    pyarrow = _pyarrow()
    names = ["tdb_jd1", "tdb_jd2", *csv_rows.names_of_numbers(rates=rates, sigma=sigma)]
    schema = pyarrow.schema(
        [(name, pyarrow.float64()) for name in names],
        metadata={"attitude": json.dumps(meta), "wxyz": "body to ICRF, scalar first"},
    )
    with (
        written_whole(path, "the table", binary=True) as file,
        pyarrow.parquet.ParquetWriter(file, schema) as writer,
    ):
        for part in parts:
            for history in part.pieces():
                low = 0.0 if history.low is None else history.low
                time = pairs.add((history.seconds, low), history.epoch.seconds, history.epoch.low)
                found = csv_rows.numbers(history, rates=rates, sigma=sigma)
                columns = [*time_scales.jd_from_seconds(*time), *found]
                arrays = [pyarrow.array(np.ascontiguousarray(column)) for column in columns]
                writer.write_table(pyarrow.Table.from_arrays(arrays, schema=schema))


def write_columns(path: FilePath, columns: Mapping[str, Any], meta: Mapping[str, Any]) -> None:
    """Write columns (N,) of numbers or text, in groups of rows.

    Parameters
    ----------
    path : str or path
        Appears whole or not at all.
    columns : mapping
    meta : mapping
        Meta data, of types that JSON has.

    Raises
    ------
    AttitudeError
        If pyarrow is not installed, or the file cannot be written.
    """
    pyarrow = _pyarrow()
    arrays = {name: pyarrow.array(np.ascontiguousarray(each)) for name, each in columns.items()}
    table = pyarrow.table(arrays).replace_schema_metadata({"attitude": json.dumps(dict(meta))})
    with (
        written_whole(path, "the table", binary=True) as file,
        pyarrow.parquet.ParquetWriter(file, table.schema) as writer,
    ):
        writer.write_table(table, row_group_size=_GROUP)


def read(path: FilePath) -> Table:
    """The columns of a file as an astropy Table, with the meta data that `write` has written.

    Raises
    ------
    AttitudeError
        If pyarrow is not installed, or the file is not a parquet file with columns of numbers.
    """
    pyarrow = _pyarrow()
    origin = os.fspath(path)
    try:
        table = pyarrow.parquet.read_table(origin)
        meta = meta_of(table)
    except OSError as err:
        reason = " ".join(str(err).split())[:120]
        raise AttitudeError(f"{origin}: it cannot be read: {reason}.") from err
    except (pyarrow.ArrowException, ValueError, TypeError) as err:
        reason = " ".join(str(err).split())[:120]
        raise AttitudeError(f"{origin}: it cannot be read as parquet: {reason}.") from err
    from astropy.table import Table

    try:
        columns = {name: table[name].to_numpy() for name in table.column_names}
        return Table(columns, meta=meta if isinstance(meta, dict) else {})
    except (ValueError, TypeError, pyarrow.ArrowException) as err:
        raise AttitudeError(f"{origin}: its columns cannot be read ({err}).") from err


def meta_of(table: Any) -> Any:
    """The meta data that `write` and `write_columns` have written, of an arrow table."""
    return json.loads((table.schema.metadata or {}).get(b"attitude", b"{}"))


def _pyarrow():
    try:
        import pyarrow
        import pyarrow.parquet
    except ImportError as err:
        raise AttitudeError(
            "parquet files need pyarrow, which is not installed; install it by "
            f"{calls.installing('parquet')}."
        ) from err
    return pyarrow
