"""Directions of Sun and observer as kernels take them: by component, checked, in blocks."""

import numpy as np

from attitude.errors import AttitudeError

# How far the square of a unit vector's length may be from 1.
_UNIT = 1e-6


def paired(sun, observer):
    """Both as arrays (N, 3) without a copy where that is possible, and the shape of the answer."""
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
    # Two axes without a copy where there are two already; one direction for all stays one.
    flat = [
        np.broadcast_to(a, shape) if len(shape) == 2 else np.broadcast_to(a, shape).reshape(-1, 3)
        for a in arrays
    ]
    return *flat, shape[:-1]


def components(sun, observer, begin, end):
    """Six contiguous float64 arrays of a block, checked to be unit vectors."""
    from attitude.light_curve.sums import stray

    parts = []
    for array, name in ((sun, "sun"), (observer, "observer")):
        own = [np.ascontiguousarray(array[begin:end, k], dtype=np.float64) for k in range(3)]
        # The sum of squares of |v|^2 - 1: NaN, or any single vector beyond the bound, shows in it.
        if not stray(*own) <= _UNIT**2:
            _refuse_the_first(own, name, begin)
        for part in own:
            part.flags.writeable = False  # one type for the kernels, and compiled once
        parts.extend(own)
    return parts


def _refuse_the_first(own, name, begin):
    """Raise for the first vector beyond the bound; many rounded ones may add up to it too."""
    excess = own[0] ** 2 + own[1] ** 2 + own[2] ** 2 - 1.0
    wrong = np.flatnonzero(~(np.abs(excess) <= _UNIT))
    if len(wrong):
        bad = int(wrong[0])
        raise AttitudeError(
            f"{name} at epoch {begin + bad} is {[float(v[bad]) for v in own]}; give finite "
            "vectors of length 1."
        )
