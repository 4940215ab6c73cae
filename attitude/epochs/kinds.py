"""The kind of the epochs that a caller gives (text, Time, datetime, seconds ...), and their list.

`attitude.epochs.readers` has a reader for each kind.
"""

from __future__ import annotations

import datetime
import numbers
import sys
from contextlib import suppress
from typing import Any

import numpy as np

from attitude import quantity_text, validation
from attitude.epochs.instants import Instant
from attitude.errors import AttitudeError

# Kinds that are lengths of time; the others are epochs.
LENGTHS: tuple[str, ...] = ("number", "text length", "duration", "TimeDelta")

_TYPES = (
    ("Instant", Instant),
    ("datetime", datetime.datetime),
    ("datetime64", np.datetime64),
    # numpy's timedelta64 is a subclass of its integers, so this row precedes the numbers.
    ("duration", (datetime.timedelta, np.timedelta64)),
    ("number", numbers.Real),
)


def entries(value: Any, name: str, allowed: str) -> tuple[str, list[Any], tuple[int, ...]]:
    """The kind of a value, its entries as a flat list, and the shape in which they were given.

    One Time array, or one array of numbers, is a single entry of shape ().  Masked entries are
    `numpy.ma.masked` in the list.

    Raises
    ------
    AttitudeError
        For another type, several kinds in one list, and ragged lists; `name` stands for the value
        and `allowed` for what may be given.
    """
    if isinstance(value, (list, tuple)) and isinstance(_first(value), (int, float)):
        # numpy converts long lists of numbers fast; the code below reports what it refuses.
        with suppress(ValueError, TypeError):
            array = np.asarray(value)
            if array.dtype.kind in "fiu":
                return "number", [array], ()
    leaves, shape = _leaves(value, name)
    kinds = {_kind(leaf) for leaf in leaves if leaf is not np.ma.masked}
    if None in kinds:
        wrong = next(leaf for leaf in leaves if _kind(leaf) is None)
        raise AttitudeError(
            f"{name} {'is' if shape == () else 'holds'} {validation.shown(wrong)}; give {allowed}."
        )
    found = sorted(kind for kind in kinds if kind is not None)
    if len(found) > 1:
        raise AttitudeError(
            f"{name} mixes entries of several kinds ({', '.join(found)}); give all in one."
        )
    return found[0] if found else "number", leaves, shape


def _first(values):
    """The first entry of nested lists; None if they are empty."""
    while isinstance(values, (list, tuple)):
        if not values:
            return None
        values = values[0]
    return values


def _leaves(value: Any, name: str) -> tuple[list[Any], tuple[int, ...]]:
    """The entries of nested lists or of an array as a flat list, and their shape."""
    if isinstance(value, (list, tuple)):
        parts = [_leaves(each, name) for each in value]
        shapes = {shape for _, shape in parts}
        if len(shapes) > 1:
            raise AttitudeError(f"{name} is ragged; give an array with rows of equal length.")
        leaves = [leaf for inner, _ in parts for leaf in inner]
        return leaves, (len(value), *(shapes.pop() if shapes else ()))
    array = _array(value)
    if array is None:
        return [value], ()
    if array.dtype.kind in "SUO":
        mask = np.ma.getmaskarray(array).ravel()
        texts = np.ma.getdata(array).astype("U") if array.dtype.kind == "S" else array
        leaves = np.ma.getdata(texts).ravel().tolist()
        return [np.ma.masked if m else e for m, e in zip(mask, leaves, strict=True)], array.shape
    return [array], ()


def _array(value):
    """An array as it is (with its mask and unit), any array-like object as one, else None."""
    if isinstance(value, np.ndarray):
        return value
    if hasattr(value, "__array__") and not isinstance(value, np.generic) and _kind(value) is None:
        return np.asarray(value)
    return None


def _kind(value: Any) -> str | None:
    """The kind of one entry, or None for a type that is not allowed."""
    if isinstance(value, (bool, np.bool_)):
        return None
    if isinstance(value, str):
        # A date of four digits begins "2026-"; other text may be a length such as "3 d".
        is_length = value[4:5] != "-" and quantity_text.is_quantity(value)
        return "text length" if is_length else "text"
    for kind, types in _TYPES:
        if isinstance(value, types):
            return kind
    if isinstance(value, np.ndarray):
        return {"M": "datetime64", "m": "duration"}.get(
            value.dtype.kind, "number" if value.dtype.kind in "fiu" else None
        )
    if hasattr(value, "whole") and hasattr(value, "tt_fraction"):
        return "skyfield Time"
    # A caller who holds a Time has imported astropy already; other callers need not load it.
    module = sys.modules.get("astropy.time")
    if module is not None and isinstance(value, module.TimeDelta):
        return "TimeDelta"
    return "astropy Time" if module is not None and isinstance(value, module.Time) else None
