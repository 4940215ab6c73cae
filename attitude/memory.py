"""Memory for results, of large pages where that is cheaper, and views with other orders of axes."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from attitude.annotations import FloatArray

# Bytes of a large page, and the least size of an array for which numpy requests such pages.
_PAGE = 1 << 21
_LARGE = 1 << 22
_DOUBLE = 8


def new_array(*shape: int) -> FloatArray:
    """An array of doubles whose entries are not set yet.

    The first write to each page of new memory costs 0.5 ns a byte with the usual pages of 4 KB, and
    0.1 ns with large ones (benchmarks/memory.py).  numpy requests large pages from Linux, which
    needs them at multiples of their size: in an array that begins elsewhere the pages at both
    ends stay small, a quarter of an array of 8 MB.
    """
    count = math.prod(shape)
    if count * _DOUBLE < _LARGE:
        return np.empty(shape)
    # so much longer that the first and the last large page lie within the memory
    memory = np.empty(count + 2 * _PAGE // _DOUBLE)
    first = -memory.ctypes.data % _PAGE // _DOUBLE
    return memory[first : first + count].reshape(shape)


def components_last(array: FloatArray) -> FloatArray:
    """A view (..., k) of an array (k, ...), as ``numpy.moveaxis(array, 0, -1)``, by few calls."""
    return array.T if array.ndim <= 2 else array.transpose(*range(1, array.ndim), 0)


def components_first(array: FloatArray) -> FloatArray:
    """A view (k, ...) of an array (..., k), as ``numpy.moveaxis(array, -1, 0)``, by few calls."""
    return array.T if array.ndim <= 2 else array.transpose(-1, *range(array.ndim - 1))
