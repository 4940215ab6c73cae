"""Smooth functions of time as Chebyshev polynomials on the pieces of a span.

The series of a time scale difference and the position of a body in an ephemeris take microseconds
an epoch.  Both are smooth: a polynomial per piece takes tens of nanoseconds.  On each piece the
coordinate x is from -1 to 1.

Source: Press et al., Numerical Recipes (2007), section 5.8: the discrete orthogonality of the
Chebyshev polynomials on their zeros, and Clenshaw's recurrence.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from attitude._compilation.decorators import quickly_compiled, subroutine
from attitude._compilation.instructions import fma
from attitude._compilation.simd import (
    doubles_of,
    eight,
    four,
    lanes,
    positive_bits,
    put_eight,
    root,
)
from attitude._solver.twofloat import two_sum

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

    from numpy.typing import ArrayLike, NDArray

    from attitude._support.annotations import FloatArray


# So many epochs are evaluated together: the four arrays of a recurrence stay in cache.
_CHUNK = 4096
# Part of a span by which roundings of its two ends move them, at most.
_SLACK = 2.0**-50


def nodes(count: int) -> FloatArray:
    """The zeros of the Chebyshev polynomial T_count, shape (count,), from near 1 to near -1."""
    return np.cos(np.pi * (np.arange(count) + 0.5) / count)


def coefficients(values: ArrayLike) -> FloatArray:
    """Chebyshev coefficients (count, ...) of the polynomial of values (count, ...) at nodes."""
    values = np.asarray(values, dtype=np.float64)
    count = len(values)
    order = np.arange(count)
    waves = np.cos(np.pi * order[:, None] * (order + 0.5) / count)
    waves *= np.where(order == 0, 1.0, 2.0)[:, None] / count
    # Node by node: a product of matrices rounds otherwise where more columns are given with one.
    table = np.zeros_like(values)
    for k in range(count):
        table += waves[:, k].reshape(count, *(1,) * (values.ndim - 1)) * values[k]
    return table


def evaluate(table: FloatArray, piece: NDArray[np.integer[Any]], x: FloatArray) -> FloatArray:
    """Values at x (N,) of the polynomials of their pieces (N,), by Clenshaw's recurrence."""
    out = np.empty((*table.shape[1:-1], len(x)))
    for start in range(0, len(x), _CHUNK):
        chunk = slice(start, start + _CHUNK)
        out[..., chunk] = _clenshaw(table, piece[chunk], x[chunk])
    return out


def _clenshaw(table, piece, x):
    twice = x + x
    last = np.zeros((*table.shape[1:-1], len(x)))
    before = np.zeros_like(last)
    for order in range(len(table) - 1, 0, -1):
        new = last * twice
        new -= before
        new += table[order].take(piece, axis=-1)
        before, last = last, new
    return last * x - before + table[0].take(piece, axis=-1)


class KeptPieces(dict[Any, Any]):
    """Pieces by key, fitted when they are asked for first; full, with `most`, it is cleared."""

    def __init__(self, most: int) -> None:
        super().__init__()
        self.most = most

    def of(self, keys: list[Any], fitted: Callable[[list[Any]], Iterable[Any]]) -> list[Any]:
        """The pieces of some keys; `fitted(missing)` makes those that are not kept.

        Pieces fitted with others have other last bits: those that a thread stored first are used.
        """
        have = {key: self.get(key) for key in keys}
        missing = [key for key, piece in have.items() if piece is None]
        if missing:
            new = dict(zip(missing, fitted(missing), strict=True))
            if len(self) + len(new) > self.most:
                self.clear()
            if len(new) <= self.most:
                new = {key: self.setdefault(key, piece) for key, piece in new.items()}
            have.update(new)
        return [have[key] for key in keys]


# ---- Compiled evaluation of piecewise Chebyshev polynomials of time, for vectors of three
# The records of a JPL kernel, of a compressed path and of an interpolated table have one layout: a
# row for each piece, which holds `skip` other numbers and then the `count` coefficients of x, of y
# and of z.
#
# `place_equal`, `place_cells` and `place_knots` fill, for each epoch, piece (N,) int64 with the
# number of its piece and x (N,) with the coordinate of the epoch in the piece, from -1 to 1;
# `values` and `values_and_rates` evaluate the polynomials there.  Epochs are hi (N,) + lo (N,) or
# (1,) seconds since an instant, which is base_hi + base_lo seconds after the start of the pieces,
# so that nothing is rounded before the start of the piece is subtracted.
#
# The loops do the same operations for each epoch, whatever the number of epochs.
#
# Source: Clenshaw's recurrence; Press et al., Numerical Recipes (2007), section 5.8.


@quickly_compiled
def place_equal(hi, lo, base_hi, base_lo, least, most, width, pieces, piece, x):
    """Fill piece, x for pieces of one width, s; -1, or an epoch out of least..most after start."""
    step = 0 if lo.size == 1 else 1
    outside = -1
    for k in range(hi.size):
        s, e = two_sum(base_hi, hi[k])
        e += base_lo + lo[k * step]
        if s + e < least or s + e > most:
            outside = k
        number = min(max(math.floor((s + e) / width), 0.0), pieces - 1.0)
        piece[k] = int(number)
        # One rounding, whatever the number of the piece.
        x[k] = 2.0 * ((fma(-number, width, s) + e) / width) - 1.0
    return outside


@quickly_compiled
def place_cells(hi, lo, base_hi, base_lo, least, most, width, cells, starts, widths, piece, x):
    """As `place_equal`, where each piece fills one or more cells of one width.

    cells (cells,) int32 holds the number of the piece in each cell; starts and widths (pieces,)
    hold the start in seconds and the length of each piece.
    """
    step = 0 if lo.size == 1 else 1
    outside = -1
    for k in range(hi.size):
        s, e = two_sum(base_hi, hi[k])
        e += base_lo + lo[k * step]
        if s + e < least or s + e > most:
            outside = k
        cell = min(max(math.floor((s + e) / width), 0.0), cells.size - 1.0)
        number = cells[int(cell)]
        piece[k] = number
        x[k] = 2.0 * (((s - starts[number]) + e) / widths[number]) - 1.0
    return outside


@quickly_compiled
def place_knots(hi, lo, base_hi, base_lo, knots, knots_low, piece, x):
    """`place_equal` for pieces between ascending knots (pieces + 1,), seconds in two doubles."""
    step = 0 if lo.size == 1 else 1
    outside = -1
    last = knots.size - 1
    number = 0
    for k in range(hi.size):
        s, e = two_sum(base_hi, hi[k])
        e += base_lo + lo[k * step]
        if (s - knots[0]) + (e - knots_low[0]) < 0.0:
            outside = k
        if (s - knots[last]) + (e - knots_low[last]) > 0.0:
            outside = k
        # Neighbouring epochs mostly share a piece; otherwise bisect.
        if not _starts_before(s, e, knots, knots_low, number) or _starts_before(
            s, e, knots, knots_low, number + 1
        ):
            below, above = 0, last
            while above - below > 1:
                middle = (below + above) // 2
                if _starts_before(s, e, knots, knots_low, middle):
                    below = middle
                else:
                    above = middle
            number = below
        width = (knots[number + 1] - knots[number]) + (knots_low[number + 1] - knots_low[number])
        piece[k] = number
        x[k] = 2.0 * (((s - knots[number]) + (e - knots_low[number])) / width) - 1.0
    return outside


@subroutine
def _starts_before(s, e, knots, knots_low, number):
    """Whether a piece starts at or before the epoch s + e."""
    return (s - knots[number]) + (e - knots_low[number]) >= 0.0


@subroutine
def _vector(records, row, skip, count, t):
    """The components of the vector at the coordinate t of a piece: one, or eight of simd.Lanes."""
    twice = t + t
    a = b = c = last_a = last_b = last_c = 0.0 * t
    for order in range(count - 1, 0, -1):
        column = skip + order
        a, last_a = fma(twice, a, records[row, column] - last_a), a
        b, last_b = fma(twice, b, records[row, column + count] - last_b), b
        c, last_c = fma(twice, c, records[row, column + 2 * count] - last_c), c
    return (
        fma(t, a, records[row, skip] - last_a),
        fma(t, b, records[row, skip + count] - last_b),
        fma(t, c, records[row, skip + 2 * count] - last_c),
    )


@subroutine
def _four_at_once(rows, first, count, t):
    """As `_vector`, the components as the lanes of one vector."""
    twice = t + t
    a = last = lanes((0.0, 0.0, 0.0, 0.0))
    for order in range(count - 1, 0, -1):
        a, last = fma(twice, a, four(rows, first + 4 * order) - last), a
    return fma(t, a, four(rows, first) - last)


@quickly_compiled
def values(records, skip, count, piece, x, factor, out):
    """Fill out (3, N) with vectors at epochs times a factor; eight of a piece at once, by SIMD."""
    out_a, out_b, out_c = out[0], out[1], out[2]
    for first in range(0, piece.size, 8):
        row = piece[first]
        together = first + 8 <= piece.size
        if together:
            for k in range(first + 1, first + 8):
                together &= piece[k] == row
        if together:
            a, b, c = _vector(records, row, skip, count, eight(x, first))
            put_eight(out_a, first, a * factor)
            put_eight(out_b, first, b * factor)
            put_eight(out_c, first, c * factor)
        else:
            for k in range(first, min(first + 8, piece.size)):
                a, b, c = _vector(records, piece[k], skip, count, x[k])
                out_a[k], out_b[k], out_c[k] = a * factor, b * factor, c * factor


@quickly_compiled
def directions(
    hi, lo, base_hi, base_lo, most, width, cells, starts, widths, records, rows, count, sign,
    begin, end, unit, length,
):  # fmt: skip
    """Fill unit vectors (3, N) times a sign, and lengths (N,), at the epochs from begin to end.

    rows (pieces 4 count,) holds the coefficients of `records` in the order of x, y, z and a zero.

    Pieces as in `place_cells`, from 0 to `most` seconds.  Eight epochs in the piece of the epochs
    before them, or in one other piece, are evaluated together by SIMD: sorted epochs are walked
    piece by piece.  NaN for NaN.  Returns -1, or the index of an epoch outside of the range by
    more than _SLACK of it: the ends are rounded epochs.
    """
    step = 0 if lo.size == 1 else 1
    slack = _SLACK * most
    x_out, y_out, z_out = unit[0], unit[1], unit[2]
    outside, row = -1, 0
    for first in range(begin, end, 8):
        together = first + 8 <= end
        if together:
            s, e = two_sum(base_hi, eight(hi, first))
            e = e + (base_lo + (eight(lo, first) if step else 0.0 * e + lo[0]))
            t = 2.0 * (((s - starts[row]) + e) / widths[row]) - 1.0
            if positive_bits(1.0 - t * t) != 255:
                row = _row_of(hi[first] + base_hi, most, width, cells)
                t = 2.0 * (((s - starts[row]) + e) / widths[row]) - 1.0
                together = positive_bits(1.0 - t * t) == 255
        if together:
            a, b, c = _vector(records, row, 0, count, t)
            size = root(a * a + b * b + c * c)
            put_eight(length, first, size)
            scale = sign / size
            put_eight(x_out, first, a * scale)
            put_eight(y_out, first, b * scale)
            put_eight(z_out, first, c * scale)
        else:
            for k in range(first, min(first + 8, end)):
                p, q = two_sum(base_hi, hi[k])
                q += base_lo + lo[k * step]
                if p + q < -slack or p + q > most + slack:
                    outside = k
                piece = _row_of(p + q, most, width, cells)
                u = 2.0 * (((p - starts[piece]) + q) / widths[piece]) - 1.0
                a, b, c, _ = doubles_of(_four_at_once(rows, 4 * count * piece, count, u))
                size = math.sqrt(a * a + b * b + c * c)
                length[k] = size
                scale = sign / size
                x_out[k], y_out[k], z_out[k] = a * scale, b * scale, c * scale
    return outside


@subroutine
def _row_of(seconds, most, width, cells):
    """The number of the piece at an epoch in seconds after the start; of an end if outside."""
    # NaN is in neither comparison.
    if not seconds > 0.0:
        return cells[0]
    cell = int(seconds / width) if seconds < most else cells.size - 1
    return cells[cell if cell < cells.size else cells.size - 1]


@quickly_compiled
def values_and_rates(records, skip, count, piece, x, widths, factor, out, rate):
    """As `values`, and fill rate (3, N) with the derivative; widths (pieces,) or (1,) in s."""
    equal = widths.size == 1
    for component in range(3):
        first = skip + component * count
        for k in range(piece.size):
            row, t = piece[k], x[k]
            twice = t + t
            a = last = slope = last_slope = 0.0
            for order in range(count - 1, 0, -1):
                slope, last_slope = fma(twice, slope, 2.0 * a - last_slope), slope
                a, last = fma(twice, a, records[row, first + order] - last), a
            out[component, k] = fma(t, a, records[row, first] - last) * factor
            width = widths[0 if equal else row]
            rate[component, k] = fma(t, slope, a - last_slope) * (2.0 * factor / width)
