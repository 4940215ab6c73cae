"""Fourier series in pairs of frequencies: closed normal equations from two tables, compiled.

With W(nu) = sum w e^(2 pi i nu t) and Y(nu) = sum w y e^(2 pi i nu t) on an equally spaced grid,
every entry of the normal equations of every pair of grid frequencies is one of W or one of Y, so
that the cost of a pair does not depend on the number of points.  Sixteen pairs are solved side by
side, which fills vector registers.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from attitude import blocks
from attitude.compilation.decorators import entry_point, reduction_subroutine, subroutine

if TYPE_CHECKING:
    from attitude.annotations import FloatArray, IntArray

_SIDE = 16
# Products of the factorisations of one compiled call, some 0.03 s: Python acts on signals, such as
# that of Ctrl-C, between two calls.
_PRODUCTS = 5e7


def harmonics(order: int) -> IntArray:
    """Numbers (i, j) of the lines of a series with |i|, |j| <= order: (0, 0), and one of each +-.

    Parameters
    ----------
    order : int

    Returns
    -------
    (M, 2) array, M = 1 + 2 order (order + 1)
    """
    found = [(0, 0)] + [(0, j) for j in range(1, order + 1)]
    found += [(i, j) for i in range(1, order + 1) for j in range(-order, order + 1)]
    return np.array(found)


def decreases(
    wr: FloatArray,
    wi: FloatArray,
    yr: FloatArray,
    yi: FloatArray,
    first: IntArray,
    second: IntArray,
    lines: IntArray,
    ridge: float,
    out: FloatArray,
) -> None:
    """Decrease of chi-squared by the series of each pair, into out (P,).

    wr, wi, yr, yi: the tables, real and imaginary parts; first, second: grid numbers of the pairs;
    lines as of `harmonics`; ridge: inverse variance of the amplitudes before the fit.
    """
    unknown = 2 * len(lines) - 1
    size = _SIDE * max(1, int(_PRODUCTS / (_SIDE * unknown**3 / 6.0)))

    def work(begin: int, end: int) -> None:
        part = slice(begin, end)
        _decreases(wr, wi, yr, yi, first[part], second[part], lines, ridge, out[part])

    blocks.in_blocks(work, len(first), size, 1)


@entry_point
def _decreases(wr, wi, yr, yi, first, second, lines, ridge, out):
    terms = lines.shape[0]
    unknown = 2 * terms - 1
    g, b = np.empty((unknown, unknown, _SIDE)), np.empty((unknown, _SIDE))
    at = np.empty(terms, np.int64)
    for start in range(0, first.size, _SIDE):
        for lane in range(_SIDE):
            pair = min(start + lane, first.size - 1)
            for m in range(terms):
                at[m] = lines[m, 0] * first[pair] + lines[m, 1] * second[pair]
            _fill(wr, wi, yr, yi, at, lane, ridge, g, b)
        _solve(g, b)
        for lane in range(min(_SIDE, first.size - start)):
            total = 0.0
            for i in range(unknown):
                total += b[i, lane] * b[i, lane]
            out[start + lane] = total


@subroutine
def _fill(wr, wi, yr, yi, at, lane, ridge, g, b):
    """Normal matrix (lower triangle) and right side of one pair, in column `lane`."""
    for m in range(at.size):
        here = at[m]
        size = abs(here)
        sign = -1.0 if here < 0 else 1.0
        if m == 0:
            b[0, lane], g[0, 0, lane] = yr[0], wr[0]
            continue
        c, s = 2 * m - 1, 2 * m
        b[c, lane], b[s, lane] = yr[size], sign * yi[size]
        g[c, 0, lane], g[s, 0, lane] = wr[size], sign * wi[size]
        for other in range(1, m + 1):
            less, more = here - at[other], here + at[other]
            d, p = abs(less), abs(more)
            dr, di, pr, pi = wr[d], wi[d], wr[p], wi[p]
            di = -di if less < 0 else di
            pi = -pi if more < 0 else pi
            x, y = 2 * other - 1, 2 * other
            g[c, x, lane], g[s, y, lane] = 0.5 * (pr + dr), 0.5 * (dr - pr)
            g[s, x, lane], g[c, y, lane] = 0.5 * (pi + di), 0.5 * (pi - di)
        g[s, c, lane] = 0.5 * pi
        g[c, c, lane] += ridge
        g[s, s, lane] += ridge


@reduction_subroutine
def _solve(g, b):
    """Replace b by L^-1 b, for the Cholesky factors L of g (unknown, unknown, 16)."""
    row = np.empty(_SIDE)
    for i in range(g.shape[0]):
        for j in range(i + 1):
            for lane in range(_SIDE):
                row[lane] = g[i, j, lane]
            for k in range(j):
                for lane in range(_SIDE):
                    row[lane] -= g[i, k, lane] * g[j, k, lane]
            if i == j:
                for lane in range(_SIDE):
                    g[i, i, lane] = 1.0 / math.sqrt(max(row[lane], 1e-12))
            else:
                for lane in range(_SIDE):
                    g[i, j, lane] = row[lane] * g[j, j, lane]
        for lane in range(_SIDE):
            row[lane] = b[i, lane]
        for k in range(i):
            for lane in range(_SIDE):
                row[lane] -= g[i, k, lane] * b[k, lane]
        for lane in range(_SIDE):
            b[i, lane] = row[lane] * g[i, i, lane]
