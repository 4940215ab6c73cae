"""Ensembles in tables: astropy, pandas, arrow, and files.

One row is one member.  Columns, of which either form of each may be given:

name            optional
epoch           a Time column, dates as text (UTC), or ``epoch_seconds`` and ``epoch_low``: TDB
                seconds past J2000 in two doubles
wxyz            or ``w, x, y, z``: body to the frame of the table
angular_velocity  or ``omega_x, omega_y, omega_z``: rad/s over the body axes
moments         or ``moment_x, moment_y, moment_z``: kg m2, about the body axes
tensor          or ``tensor_xx, tensor_xy, ... tensor_zz``: in place of the moments

The meta data ``frame`` and ``relative`` are those of the ensemble.  Files written here also have
``low_w, low_x, low_y, low_z``, the second doubles of attitudes, if there are any.
"""

from __future__ import annotations

import math
import os
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from attitude import validation
from attitude.ensemble.epoch import Seconds
from attitude.errors import AttitudeError
from attitude.formats.parquet import meta_of

if TYPE_CHECKING:
    from attitude.annotations import FloatArray

_XYZ = "xyz"
# Columns of several numbers, with the columns that may stand for them, and the unit.
_PARTS: dict[str, tuple[tuple[str, ...], str | None]] = {
    "wxyz": (("w", "x", "y", "z"), None),
    "low": (("low_w", "low_x", "low_y", "low_z"), None),
    "angular_velocity": (tuple(f"omega_{k}" for k in _XYZ), "rad/s"),
    "moments": (tuple(f"moment_{k}" for k in _XYZ), "kg m2"),
    "tensor": (tuple(f"tensor_{j}{k}" for j in _XYZ for k in _XYZ), "kg m2"),
}


def columns_of(table: Any, origin: str) -> tuple[dict[str, Any], dict[str, Any]]:
    """The columns and the meta data of an astropy, pandas or arrow table, or of a mapping.

    Raises
    ------
    AttitudeError
        For any other object.
    """
    if hasattr(table, "colnames"):  # astropy
        return {name: table[name] for name in table.colnames}, _lower(table.meta)
    if hasattr(table, "column_names") and hasattr(table, "schema"):  # pyarrow
        meta = meta_of(table)
        found = {name: table[name].to_numpy(zero_copy_only=False) for name in table.column_names}
        return found, _lower(meta)
    if hasattr(table, "columns") and hasattr(table, "to_numpy"):  # pandas
        found = {str(name): table[name].to_numpy() for name in table.columns}
        return found, _lower(getattr(table, "attrs", {}))
    if isinstance(table, Mapping):
        return dict(table), {}
    raise AttitudeError(
        f"{origin} is {validation.shown(table)}; give an astropy, pandas or arrow table, or the "
        "name of a file."
    )


def arguments(columns: Mapping[str, Any], relative: bool, origin: str) -> dict[str, Any]:
    """The arguments of `Ensemble` in some columns, with ``low`` if there are second doubles.

    Raises
    ------
    AttitudeError
        For columns that are missing or of a wrong shape, with the name of the table.
    """
    found: dict[str, Any] = {}
    for name, (parts, unit) in _PARTS.items():
        known = None if relative and unit == "kg m2" else unit
        values = _numbers(columns, name, parts, known, origin)
        if values is not None:
            found[name] = values
    for name in ("wxyz", "angular_velocity"):
        if name not in found:
            raise AttitudeError(
                f"{origin}: it has no {name}; give a column {name}, or "
                f"{', '.join(_PARTS[name][0])}."
            )
    if "tensor" in found:
        found["tensors"] = found.pop("tensor").reshape(-1, 3, 3)
        found.pop("moments", None)
    elif "moments" not in found:
        raise AttitudeError(f"{origin}: it has neither moments nor tensor; give one of them.")
    found["epoch"] = _epochs(columns, origin)
    if "name" in columns:
        names = np.asarray(columns["name"])
        names = np.char.decode(names, "utf-8") if names.dtype.kind == "S" else names  # FITS
        found["names"] = [str(each) for each in names.tolist()]
    return found


def _epochs(columns: Mapping[str, Any], origin: str) -> Any:
    """What `Ensemble` takes as epochs: dates, or Seconds."""
    if "epoch_seconds" in columns:
        low = columns.get("epoch_low", np.zeros(len(columns["epoch_seconds"])))
        given = np.array([columns["epoch_seconds"], low], dtype=np.float64)
        if not np.all(np.isfinite(given)):
            row = int(np.argmin(np.isfinite(given).all(axis=0)))
            raise AttitudeError(f"{origin}: the epoch of row {row} is missing.")
        return Seconds(*(given[:, :1] if np.all(given == given[:, :1]) else given))
    if "epoch" not in columns:
        raise AttitudeError(
            f"{origin}: it has no epochs; give a column epoch of dates, or epoch_seconds."
        )
    given = columns["epoch"]
    kind = getattr(getattr(given, "dtype", None), "kind", "")
    return np.asarray(given).tolist() if kind in "OSU" and kind else given


def _numbers(
    columns: Mapping[str, Any], name: str, parts: tuple[str, ...], unit: str | None, origin: str
) -> FloatArray | None:
    """A column (N, W), from one of rows or from W columns; None where there is neither."""
    try:
        if name in columns:
            given = columns[name]
            if getattr(getattr(given, "dtype", None), "kind", "") == "O":
                given = np.stack([np.asarray(each) for each in given])
            array = validation.real(given, name, unit=unit, finite=False)
            if array.ndim == 3:
                array = array.reshape(len(array), math.prod(array.shape[1:]))
            return array
        if not set(parts) <= set(columns):
            return None
        each = [validation.real(columns[k], k, unit=unit, finite=False) for k in parts]
        return np.stack(each, axis=-1)
    except AttitudeError as err:
        raise AttitudeError(f"{origin}: {err}") from err
    except (ValueError, TypeError) as err:
        raise AttitudeError(f"{origin}: the column {name} cannot be read ({err}).") from err


def of_arrays(arrays: Mapping[str, FloatArray]) -> dict[str, Any]:
    """Columns (N,) of the arrays wxyz, low, angular_velocity, moments or tensor of N members."""
    columns: dict[str, Any] = {}
    for name, array in arrays.items():
        flat = array.reshape(len(array), math.prod(array.shape[1:]))
        columns.update({part: flat[:, k] for k, part in enumerate(_PARTS[name][0])})
    return columns


def origin_of(source: Any) -> str | None:
    """The name of a file, or None for a table."""
    return os.fspath(source) if isinstance(source, (str, os.PathLike)) else None


def _lower(meta: Any) -> dict[str, Any]:
    return {str(key).lower(): value for key, value in dict(meta).items()}
