"""Sums of exp(2 pi i nu t) over uneven epochs at equally spaced frequencies: a gridded transform.

Each epoch is spread over twelve points of an oversampled grid by the kernel exp(b sqrt(1 - z^2)) of
Barnett, Magland & af Klinteberg (SIAM J. Sci. Comput. 41, C479, 2019), the grid transformed by an
FFT, and the transform divided by that of the kernel: 1e-10 of the sum of the weights.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from attitude.compilation.decorators import entry_point

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from attitude.annotations import FloatArray

_WIDTH, _OVER = 12, 2.0
_SHAPE = 2.30 * _WIDTH


def sums(t: FloatArray, weights: FloatArray, spacing: float, count: int) -> NDArray[np.complex128]:
    """Sums over epochs of weights times exp(2 pi i k spacing t), k = 0 .. count - 1.

    Parameters
    ----------
    t : (N,) array
    weights : (W, N) array
    spacing : float
        Of frequencies, cycles per unit of t.
    count : int

    Returns
    -------
    (W, count) complex array
    """
    size = _smooth(int(_OVER * 2 * count) + 2 * _WIDTH)
    place = np.mod(t * spacing, 1.0) * size
    grid = np.zeros((len(weights), size))
    _spread(place, np.ascontiguousarray(weights), grid)
    found: NDArray[np.complex128] = np.fft.rfft(grid)[:, :count].conj()
    nodes, by = np.polynomial.legendre.leggauss(64)
    z = 0.5 * _WIDTH * nodes
    kernel = 0.5 * _WIDTH * by * np.exp(_SHAPE * (np.sqrt(1.0 - nodes**2) - 1.0))
    k = np.arange(count)
    found /= np.cos(2.0 * math.pi / size * k[:, None] * z) @ kernel
    return found


def _smooth(least: int) -> int:
    """The least number from `least` on with factors 2, 3 and 5 alone, whose FFT is fast."""
    odd = (3**b * 5**c for b in range(20) for c in range(14))
    return min(each << max(0, -(-least // each) - 1).bit_length() for each in odd)


@entry_point
def _spread(place, weights, grid):
    size = grid.shape[1]
    for i in range(place.size):
        first = math.ceil(place[i] - 0.5 * _WIDTH)
        for j in range(_WIDTH):
            z = (first + j - place[i]) * (2.0 / _WIDTH)
            value = math.exp(_SHAPE * (math.sqrt(max(0.0, 1.0 - z * z)) - 1.0))
            at = (first + j) % size
            for row in range(weights.shape[0]):
                grid[row, at] += value * weights[row, i]
