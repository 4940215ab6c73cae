"""Directions of Sun and observer, checked, as one array per component for the compiled loops."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from attitude.errors import AttitudeError
from attitude.immutable import read_only

if TYPE_CHECKING:
    from typing import Any

    from numpy.typing import ArrayLike, NDArray

    from attitude.annotations import FloatArray

# Tolerance of the squared length of a unit vector.
_UNIT = 1e-6


def paired(
    sun: ArrayLike, observer: ArrayLike
) -> tuple[NDArray[Any], NDArray[Any], tuple[int, ...]]:
    """Both directions as arrays (N, 3), if possible without a copy, and the shape of the result.

    Raises
    ------
    AttitudeError
        For shapes that are not (..., 3) or do not broadcast, and elements that are not numbers.
    """
    arrays = []
    for value, name in ((sun, "sun"), (observer, "observer")):
        try:
            array = np.asarray(value)
        except ValueError as err:
            raise AttitudeError(f"{name} is ragged; give unit vectors (..., 3).") from err
        if array.ndim < 1 or array.shape[-1] != 3 or array.dtype.kind not in "fiu":
            raise AttitudeError(
                f"{name} has shape {array.shape} of {array.dtype}; give unit vectors (..., 3)."
            )
        arrays.append(array)
    try:
        shape = np.broadcast_shapes(arrays[0].shape, arrays[1].shape)
    except ValueError as err:
        raise AttitudeError(
            f"sun has shape {arrays[0].shape} and observer {arrays[1].shape}; they must broadcast."
        ) from err
    # A reshape would copy a broadcast direction: skip it for arrays of two axes.
    flat = [
        np.broadcast_to(a, shape) if len(shape) == 2 else np.broadcast_to(a, shape).reshape(-1, 3)
        for a in arrays
    ]
    return flat[0], flat[1], shape[:-1]


def components(sun: NDArray[Any], observer: NDArray[Any], begin: int, end: int) -> list[FloatArray]:
    """Six contiguous float64 arrays of a block: x, y, z of the Sun, then of the observer.

    Raises
    ------
    AttitudeError
        For a vector whose squared length differs from 1 by more than 1e-6, or that is not finite.
    """
    from attitude.light_curve.sums import stray

    parts = []
    for array, name in ((sun, "sun"), (observer, "observer")):
        # read-only everywhere: one compiled version
        own = [
            read_only(np.ascontiguousarray(array[begin:end, k], dtype=np.float64)) for k in range(3)
        ]
        # The sum of (|v|^2 - 1)^2 exceeds the bound if any single vector does; NaN stays NaN.
        if not stray(*own) <= _UNIT**2:
            _refuse_the_first(own, name, begin)
        parts.extend(own)
    return parts


def _refuse_the_first(own: list[FloatArray], name: str, begin: int) -> None:
    """Raise for the first vector beyond the bound, if any: the sum of many may exceed it too."""
    excess = own[0] ** 2 + own[1] ** 2 + own[2] ** 2 - 1.0
    wrong = np.flatnonzero(~(np.abs(excess) <= _UNIT))
    if len(wrong):
        bad = int(wrong[0])
        raise AttitudeError(
            f"{name} at epoch {begin + bad} is {[float(v[bad]) for v in own]}; give finite "
            "vectors of length 1."
        )
