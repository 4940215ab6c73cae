"""All pairs of frequencies of two grids, fitted by closed normal equations; the best of them.

The cost of a pair does not depend on the number of samples (`pair_scan`).  Where there are more
pairs than `MOST`, all are ranked first by the sum of the powers of their lines, cross terms left
out, and the best `MOST` are fitted.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from attitude.spectrum import pair_scan, transforms

if TYPE_CHECKING:
    from collections.abc import Callable

    from attitude.annotations import FloatArray, IntArray

# Grid frequencies per 1/span, and inverse variance, 1/mag2, of the amplitudes of lines before the
# fit.
OVERSAMPLING: float = 3.0
RIDGE: float = 1.0
# Pairs fitted at most, pairs of a block, and pairs of a block that are kept.
MOST: int = 8_000_000
_BLOCK, _KEPT = 1 << 19, 20_000
# Cells of a map of chi-squared along each axis.
_CELLS = 240
# Grid numbers by which the frequencies of a pair differ at least.
_APART = 2


class Tables(NamedTuple):
    """The transforms of weights and of weighted values, real and imaginary parts."""

    wr: FloatArray
    wi: FloatArray
    yr: FloatArray
    yi: FloatArray
    total: float


class Found(NamedTuple):
    """The best pairs.

    first, second : (P,) arrays of int, numbers on the grid; left : (P,) array, the share of
    chi-squared left; map : (C, C) array, the least share left in each cell of the plane, NaN where
    no pair lies; edges : (C + 1,) arrays of both axes, numbers on the grid; tried : int, all pairs.
    """

    first: IntArray
    second: IntArray
    left: FloatArray
    map: FloatArray
    edges: tuple[FloatArray, FloatArray]
    tried: int


def tables(t: FloatArray, weights: FloatArray, y: FloatArray, spacing: float, count: int) -> Tables:
    """The tables of `pair_scan` at `count` multiples of a spacing.

    Parameters
    ----------
    t, weights, y : (N,) arrays
        Epochs, inverse variances, and values without their constant and linear terms.
    spacing : float
        Cycles per unit of t.
    count : int
    """
    both = transforms.sums(t, np.stack([weights, weights * y]), spacing, count)
    parts = both[0].real, both[0].imag, both[1].real, both[1].imag
    wr, wi, yr, yi = (np.ascontiguousarray(each) for each in parts)
    return Tables(wr, wi, yr, yi, float(weights @ y**2))


def best(
    made: Tables,
    first: tuple[int, int],
    second: tuple[int, int],
    order: int,
    ridge: float,
    keep: int,
    progress: Callable[[int, int], None] | None = None,
) -> Found:
    """The best pairs a < b, a number of either range each, no two of them neighbours.

    Parameters
    ----------
    made : Tables
        Up to the number 4 order (greatest of a and b).
    first, second : (int, int)
        Least number and the one behind the greatest, of either.
    order : int
        Lines with |i|, |j| up to it.
    ridge : float
        Inverse variance of the amplitudes of lines before the fit.
    keep : int
        Pairs returned at most.
    progress : function, optional
        Called with the number of pairs done and of all.
    """
    lines = pair_scan.harmonics(order)
    blocks, tried = _blocks(first, second)
    least = _threshold(made, blocks, lines, tried)
    edges = tuple(
        np.linspace(a, b, min(_CELLS, b - a) + 1).astype(float) for a, b in (first, second)
    )
    cells = np.full([len(each) - 1 for each in edges], -np.inf)
    kept: list[tuple[IntArray, IntArray, FloatArray]] = []
    done = 0
    for rows in blocks:
        a, b = _pairs(rows, second)
        done += a.size
        if least > -np.inf:
            chosen = _powers(made, a, b, lines) >= least
            a, b = a[chosen], b[chosen]
        gain = np.empty(a.size)
        if a.size:
            pair_scan.decreases(*made[:4], a, b, lines, ridge, gain)
            _enter(cells, edges, a, b, gain)
            top = np.sort(np.argsort(-gain, kind="stable")[:_KEPT])
            kept.append((a[top], b[top], gain[top]))
        if progress is not None:
            progress(done, tried)
    a, b, gain = (np.concatenate(each) for each in zip(*kept, strict=True))
    chosen = _peaks(a, b, gain, keep)
    shares = np.where(np.isfinite(cells), 1.0 - cells / made.total, np.nan)
    return Found(
        a[chosen], b[chosen], 1.0 - gain[chosen] / made.total, shares, (edges[0], edges[1]), tried
    )


def _blocks(first: tuple[int, int], second: tuple[int, int]) -> tuple[list[IntArray], int]:
    """Numbers of the first grid in parts whose pairs fill a block; the number of all pairs."""
    rows = np.arange(*first)
    widths = np.maximum(second[1] - np.maximum(rows + _APART, second[0]), 0)
    rows, widths = rows[widths > 0], widths[widths > 0]
    ends = np.cumsum(widths)
    cuts = np.searchsorted(ends, np.arange(_BLOCK, ends[-1] + _BLOCK, _BLOCK), side="right")
    return [part for part in np.split(rows, np.unique(cuts)) if part.size], int(ends[-1])


def _pairs(rows: IntArray, second: tuple[int, int]) -> tuple[IntArray, IntArray]:
    starts = np.maximum(rows + _APART, second[0])
    widths = second[1] - starts
    a = np.repeat(rows, widths)
    b = (
        np.arange(a.size)
        - np.repeat(np.cumsum(widths) - widths, widths)
        + np.repeat(starts, widths)
    )
    return a, b


def _powers(made: Tables, a: IntArray, b: IntArray, lines: IntArray) -> FloatArray:
    """The sum of the powers of the lines of pairs."""
    power = made.yr**2 + made.yi**2
    found = np.zeros(a.size)
    for i, j in lines[1:]:
        found += power[np.abs(i * a + j * b)]
    return found


def _threshold(made: Tables, blocks: list[IntArray], lines: IntArray, tried: int) -> float:
    """The power from which a pair is fitted, so that about `MOST` are; from a sample of pairs."""
    if tried <= MOST:
        return -np.inf
    generator = np.random.default_rng(0)
    top = int(blocks[-1][-1]) + 1
    low = int(blocks[0][0])
    both = np.sort(generator.integers(low, max(top, low + 2), (200_000, 2)), axis=1)
    both = both[both[:, 0] < both[:, 1]]
    found = _powers(made, both[:, 0], both[:, 1], lines)
    return float(np.quantile(found, 1.0 - MOST / tried))


def _enter(cells, edges, a, b, gain):
    """Enter the greatest gain into each cell of a map."""
    place = []
    for each, grid in ((a, edges[0]), (b, edges[1])):
        width = grid[1] - grid[0]
        place.append(np.clip(((each - grid[0]) / width).astype(np.int64), 0, len(grid) - 2))
    np.maximum.at(cells, tuple(place), gain)


def _peaks(first, second, gain, keep):
    """Numbers of the best pairs, no two of them neighbours on the grid."""
    used: set[tuple[int, int]] = set()
    chosen = []
    for p in np.argsort(-gain, kind="stable"):
        a, b = int(first[p]), int(second[p])
        if (a, b) not in used:
            used.update((a + i, b + j) for i in range(-2, 3) for j in range(-2, 3))
            chosen.append(p)
            if len(chosen) >= keep:
                break
    return np.array(chosen)
