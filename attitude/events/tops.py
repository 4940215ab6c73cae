"""The greatest value of a function in each of many intervals, by samples that close in on it."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Callable

    from attitude.annotations import FloatArray

# Samples in each interval, and rounds: each leaves two of the spacings of the round before.
_SAMPLES, _ROUNDS = 65, 5


def highest(
    value: Callable[[FloatArray], FloatArray], begin: FloatArray, end: FloatArray
) -> FloatArray:
    """The places (N,) of the greatest values within intervals; their ends count.

    To 1e-7 of an interval, and at a smooth top to the square root of rounding.

    Parameters
    ----------
    value : callable
        Places (K,) to values (K,); NaN is never the greatest.
    begin, end : (N,) arrays
    """
    if not len(begin):
        return begin
    a, b = begin, end
    every = np.arange(len(begin))
    for _ in range(_ROUNDS):
        places = a + (b - a) * (np.arange(_SAMPLES) / (_SAMPLES - 1))[:, None]
        found = value(places.reshape(-1)).reshape(places.shape)
        top = np.argmax(np.where(np.isnan(found), -np.inf, found), axis=0)
        a = places[np.maximum(top - 1, 0), every]
        b = places[np.minimum(top + 1, _SAMPLES - 1), every]
    return places[top, every]
