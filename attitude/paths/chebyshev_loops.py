"""Compiled evaluation of piecewise Chebyshev polynomials of time, for vectors of three.

The records of a JPL kernel, of a compressed path and of an interpolated table have one layout: a
row for each piece, and in it, after `skip` other numbers, the `count` coefficients of x, then of
y, then of z.  A piece is found first (`place_...`: which one, and where in it from -1 to 1), then
evaluated.  Both take the epochs as hi + lo seconds since an instant that lies `base` seconds (two
doubles) after the start of the pieces, so that nothing is rounded before the start of the piece
has been taken off.

Epochs are evaluated one by one and in the same order of operations whatever their number.  lo has
as many entries as hi, or one.

Source: Clenshaw's recurrence; Press et al., Numerical Recipes (2007), section 5.8.
"""

import math

from attitude.compilation.decorators import entry_point, subroutine
from attitude.compilation.instructions import fma
from attitude.solution.twofloat import two_sum


@entry_point
def place_equal(hi, lo, base_hi, base_lo, least, most, width, pieces, piece, x):
    """Find the place in equal pieces; -1, or the index of an epoch not in least..most seconds."""
    step = 0 if lo.size == 1 else 1
    outside = -1
    for k in range(hi.size):
        s, e = two_sum(base_hi, hi[k])
        e += base_lo + lo[k * step]
        if s + e < least or s + e > most:
            outside = k
        number = min(max(math.floor((s + e) / width), 0.0), pieces - 1.0)
        piece[k] = int(number)
        # One rounding, however many pieces lie before.
        x[k] = 2.0 * ((fma(-number, width, s) + e) / width) - 1.0
    return outside


@entry_point
def place_cells(hi, lo, base_hi, base_lo, least, most, width, cells, starts, widths, piece, x):
    """As `place_equal`, where each piece fills one or more of the equal cells.

    cells holds the number of the piece in each cell; a piece starts at starts[number].
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


@entry_point
def place_knots(hi, lo, base_hi, base_lo, knots, knots_low, piece, x):
    """As `place_equal`, for pieces between ascending knots of two doubles."""
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
        # Neighbouring epochs mostly share a piece; else bisect.
        if not (_from(s, e, knots, knots_low, number) and _to(s, e, knots, knots_low, number)):
            below, above = 0, last
            while above - below > 1:
                middle = (below + above) // 2
                if _from(s, e, knots, knots_low, middle):
                    below = middle
                else:
                    above = middle
            number = below
        width = (knots[number + 1] - knots[number]) + (knots_low[number + 1] - knots_low[number])
        piece[k] = number
        x[k] = 2.0 * (((s - knots[number]) + (e - knots_low[number])) / width) - 1.0
    return outside


@subroutine
def _from(s, e, knots, knots_low, number):
    return (s - knots[number]) + (e - knots_low[number]) >= 0.0


@subroutine
def _to(s, e, knots, knots_low, number):
    return (s - knots[number + 1]) + (e - knots_low[number + 1]) < 0.0


@entry_point
def values(records, skip, count, piece, x, factor, out):
    """The vector of each epoch times a factor, into out (3, N)."""
    for k in range(piece.size):
        row, t = piece[k], x[k]
        twice = t + t
        a = b = c = last_a = last_b = last_c = 0.0
        for order in range(count - 1, 0, -1):
            place = skip + order
            a, last_a = fma(twice, a, records[row, place] - last_a), a
            b, last_b = fma(twice, b, records[row, place + count] - last_b), b
            c, last_c = fma(twice, c, records[row, place + 2 * count] - last_c), c
        out[0, k] = fma(t, a, records[row, skip] - last_a) * factor
        out[1, k] = fma(t, b, records[row, skip + count] - last_b) * factor
        out[2, k] = fma(t, c, records[row, skip + 2 * count] - last_c) * factor


@entry_point
def values_and_rates(records, skip, count, piece, x, widths, factor, out, rate):
    """As `values`, and the derivative by time into rate (3, N).

    widths are the lengths of the pieces in seconds, or the one length of them all.
    """
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
