"""Columns of the sensitivity, and covariances, from the tangents of a block of epochs.

Given
    c, d       records of CONSTANTS and TANGENTS (`records`)
    j          number of the column
    block      rows that `tangents` filled
Filled
    x, y, z    (n,) the rotation vector of the change of attitude over inertial axes, or the change
               of the angular velocity, rad/s over the given body axes
"""

from __future__ import annotations

from attitude._compilation.decorators import elementwise, force_inlined, named, subroutine
from attitude._compilation.instructions import fma
from attitude._compilation.simd import LINE, copy_line, eight, past_line, put_eight, put_line
from attitude._solver import codes
from attitude._solver.records import (
    BASIS,
    BLOCK,
    BY_NOME,
    BY_PHASE,
    COLUMNS,
    FOUND,
    NEAR_SUMS,
    NOME,
    OMEGA,
    ONES,
    PASSED,
    PHASE,
    RATE,
    SCALED,
    SECOND,
    SECONDS,
    SUMS,
    THIRD,
    TIME,
    TURNED,
    ZEROS,
)

# Results of as many doubles, 4 MB, are stored past the caches: they do not stay there.
STREAMED = 1 << 19


@force_inlined
def put_three(block, place, v):
    """A vector into three rows of a block."""
    block[place] = v[0]
    block[place + BLOCK] = v[1]
    block[place + 2 * BLOCK] = v[2]


@force_inlined
def four_at(block, place):
    """Four numbers from as many rows of a block."""
    w, x = block[place], block[place + BLOCK]
    return w, x, block[place + 2 * BLOCK], block[place + 3 * BLOCK]


@force_inlined
def put_four(block, place, v):
    """Four numbers into as many rows of a block."""
    put_three(block, place, v)
    block[place + 3 * BLOCK] = v[3]


@force_inlined
def still_column(k, block, x, y, z):
    """Fill a unit vector, along axis k, or zeros where k is none; NaN where the epoch is."""
    for i in range(len(x)):
        x[i] = fma(0.0, block[SECONDS + i], 1.0 if k == 0 else 0.0)
    for i in range(len(y)):
        y[i] = fma(0.0, block[SECONDS + i], 1.0 if k == 1 else 0.0)
    for i in range(len(z)):
        z[i] = fma(0.0, block[SECONDS + i], 1.0 if k == 2 else 0.0)


@force_inlined
def any_missing(n, block):
    """Whether any epoch of a block is NaN."""
    missing = 0
    for i in range(n):
        missing |= block[SECONDS + i] != block[SECONDS + i]
    return missing != 0


@force_inlined
def fill_still_rows(block):
    """Fill the rows of zeros and of ones."""
    for i in range(BLOCK):
        block[ZEROS + i] = 0.0
        block[ONES + i] = 1.0


@force_inlined
def still_rows(k, n, block):
    """The rows of a unit vector along axis k for n epochs."""
    x, y, z = ONES if k == 0 else ZEROS, ONES if k == 1 else ZEROS, ONES if k == 2 else ZEROS
    return block[x : x + n], block[y : y + n], block[z : z + n]


@elementwise
@force_inlined
def attitude_column(c, d, j, block, x, y, z):
    """Fill the change of attitude of a motion that tumbles."""
    weights = d.weights
    time, rate, start = weights[TIME, j], weights[RATE, j], weights[PHASE, j]
    second, third = weights[SECOND, j], weights[THIRD, j]
    lx, ly, lz = d.invariant[0, 2], d.invariant[1, 2], d.invariant[2, 2]
    ox, oy, oz = d.offset[0, j], d.offset[1, j], d.offset[2, j]
    for i in range(len(x)):
        seconds = block[SECONDS + i]
        a, along = fma(rate, seconds, start), fma(time, seconds, second * block[PASSED + i])
        u = fma(block[BASIS + 6 * BLOCK + i], third, lx * along)
        v = fma(block[BASIS + 7 * BLOCK + i], third, ly * along)
        w = fma(block[BASIS + 8 * BLOCK + i], third, lz * along)
        u = fma(block[BASIS + i], a, fma(block[BASIS + 3 * BLOCK + i], second, u))
        v = fma(block[BASIS + BLOCK + i], a, fma(block[BASIS + 4 * BLOCK + i], second, v))
        w = fma(block[BASIS + 2 * BLOCK + i], a, fma(block[BASIS + 5 * BLOCK + i], second, w))
        x[i] = u + ox
        y[i] = v + oy
        z[i] = w + oz


@elementwise
@force_inlined
def rate_column(c, d, j, block, x, y, z):
    """Fill the change of the angular velocity of a motion that tumbles."""
    weights, axes = d.weights, c.axes
    rate, start = weights[RATE, j], weights[PHASE, j]
    third, nome = weights[THIRD, j], weights[NOME, j]
    one, two, three = d.amplitudes[0, j], d.amplitudes[1, j], d.amplitudes[2, j]
    m00, m01, m02 = axes[0, 0] * one, axes[0, 1] * two, axes[0, 2] * three
    m10, m11, m12 = axes[1, 0] * one, axes[1, 1] * two, axes[1, 2] * three
    m20, m21, m22 = axes[2, 0] * one, axes[2, 1] * two, axes[2, 2] * three
    for i in range(len(x)):
        a = fma(third, block[SCALED + i], fma(rate, block[SECONDS + i], start))
        p, q, r = block[OMEGA + i], block[OMEGA + BLOCK + i], block[OMEGA + 2 * BLOCK + i]
        u = fma(a, block[BY_PHASE + i], nome * block[BY_NOME + i])
        v = fma(a, block[BY_PHASE + BLOCK + i], nome * block[BY_NOME + BLOCK + i])
        w = fma(a, block[BY_PHASE + 2 * BLOCK + i], nome * block[BY_NOME + 2 * BLOCK + i])
        x[i] = fma(m00, p, fma(m01, q, fma(m02, r, u)))
        y[i] = fma(m10, p, fma(m11, q, fma(m12, r, v)))
        z[i] = fma(m20, p, fma(m21, q, fma(m22, r, w)))


@force_inlined
def found_rows(block, n):
    """The three rows of a block for a column of n epochs that is not stored."""
    return (
        block[FOUND : FOUND + n],
        block[FOUND + BLOCK : FOUND + BLOCK + n],
        block[FOUND + 2 * BLOCK : FOUND + 2 * BLOCK + n],
    )


@force_inlined
def rows_of(out, row, column, first, last):
    """The three rows of epochs first to last of a column of an array (B, 3, P, T)."""
    x, y, z = out[row, 0, column], out[row, 1, column], out[row, 2, column]
    return x[first:last], y[first:last], z[first:last]


@force_inlined
def epochs_again(out, count):
    """The epochs of a block that the next one evaluates again: LINE if whole lines are stored.

    A row of the result that starts anywhere in a line of the cache has its lines at other epochs
    than the row before it; a block that reaches back by a line holds all epochs of each of them.
    """
    return LINE if out.size >= STREAMED and count >= 4 * BLOCK else 0


@force_inlined
def has_whole_lines(out):
    """Whether the rows of an array (B, D, D, T) are stored past the caches, in whole lines."""
    return out.size >= STREAMED and out.shape[3] % LINE == 0 and past_line(out[0, 0, 0]) == 0


@force_inlined
def stream_rows(x, y, z, out, head, spans):
    """Store three rows as `_stream_row`, to three rows (T,)."""
    _stream_row(x, out[0], head, spans)
    _stream_row(y, out[1], head, spans)
    _stream_row(z, out[2], head, spans)


@force_inlined
def _stream_row(values, row, head, spans):
    """Store whole lines of the epochs start to stop of a row (T,) past the caches, and its ends.

    values (stop - head,) is the row at the epochs head to stop; spans are the first epoch of the
    motion, of the block, that after the block, and after the last.
    """
    first, start, stop, end = spans
    past = past_line(row)
    place = start if start == first else start - (past + start) % LINE
    last = end if stop == end else stop - (past + stop) % LINE
    while place < last and (past + place) % LINE != 0:
        row[place] = values[place - head]
        place += 1
    while place + LINE <= last:
        copy_line(values, place - head, row, place)
        place += LINE
    while place < last:
        row[place] = values[place - head]
        place += 1


@force_inlined
def start_sums(n, rows, block):
    """Set the rows of the sums of products to 0."""
    for k in range(rows):
        for i in range(n):
            block[SUMS + k * BLOCK + i] = 0.0


@elementwise
@force_inlined
def keep_turn(n, block):
    """Keep the change of attitude while that of the angular velocity is found."""
    for i in range(n):
        block[TURNED + i] = block[FOUND + i]
        block[TURNED + BLOCK + i] = block[FOUND + BLOCK + i]
        block[TURNED + 2 * BLOCK + i] = block[FOUND + 2 * BLOCK + i]


@elementwise
@force_inlined
def add_products(n, block):
    """Add the products of the rows found: xx, xy, yy, xz, yz, zz."""
    for i in range(n):
        x, y, z = block[FOUND + i], block[FOUND + BLOCK + i], block[FOUND + 2 * BLOCK + i]
        block[SUMS + i] = fma(x, x, block[SUMS + i])
        block[SUMS + BLOCK + i] = fma(x, y, block[SUMS + BLOCK + i])
        block[SUMS + 2 * BLOCK + i] = fma(y, y, block[SUMS + 2 * BLOCK + i])
        block[SUMS + 3 * BLOCK + i] = fma(x, z, block[SUMS + 3 * BLOCK + i])
        block[SUMS + 4 * BLOCK + i] = fma(y, z, block[SUMS + 4 * BLOCK + i])
        block[SUMS + 5 * BLOCK + i] = fma(z, z, block[SUMS + 5 * BLOCK + i])


@elementwise
@force_inlined
def add_products_of_rates(n, block):
    """Add the products of the change of angular velocity with that of attitude and with itself."""
    for i in range(n):
        x, y, z = block[TURNED + i], block[TURNED + BLOCK + i], block[TURNED + 2 * BLOCK + i]
        u = block[FOUND + i]
        block[SUMS + 6 * BLOCK + i] = fma(x, u, block[SUMS + 6 * BLOCK + i])
        block[SUMS + 7 * BLOCK + i] = fma(y, u, block[SUMS + 7 * BLOCK + i])
        block[SUMS + 8 * BLOCK + i] = fma(z, u, block[SUMS + 8 * BLOCK + i])
        block[SUMS + 9 * BLOCK + i] = fma(u, u, block[SUMS + 9 * BLOCK + i])
        v = block[FOUND + BLOCK + i]
        block[SUMS + 10 * BLOCK + i] = fma(x, v, block[SUMS + 10 * BLOCK + i])
        block[SUMS + 11 * BLOCK + i] = fma(y, v, block[SUMS + 11 * BLOCK + i])
        block[SUMS + 12 * BLOCK + i] = fma(z, v, block[SUMS + 12 * BLOCK + i])
        block[SUMS + 13 * BLOCK + i] = fma(u, v, block[SUMS + 13 * BLOCK + i])
        block[SUMS + 14 * BLOCK + i] = fma(v, v, block[SUMS + 14 * BLOCK + i])
        w = block[FOUND + 2 * BLOCK + i]
        block[SUMS + 15 * BLOCK + i] = fma(x, w, block[SUMS + 15 * BLOCK + i])
        block[SUMS + 16 * BLOCK + i] = fma(y, w, block[SUMS + 16 * BLOCK + i])
        block[SUMS + 17 * BLOCK + i] = fma(z, w, block[SUMS + 17 * BLOCK + i])
        block[SUMS + 18 * BLOCK + i] = fma(u, w, block[SUMS + 18 * BLOCK + i])
        block[SUMS + 19 * BLOCK + i] = fma(v, w, block[SUMS + 19 * BLOCK + i])
        block[SUMS + 20 * BLOCK + i] = fma(w, w, block[SUMS + 20 * BLOCK + i])


@force_inlined
def keep_near_sums(n, block):
    """Keep the sums of the changes of attitude while columns finds those far away."""
    for k in range(6):
        for i in range(n):
            block[NEAR_SUMS + k * BLOCK + i] = block[SUMS + k * BLOCK + i]


@force_inlined
def use_near_sums(n, reach, block):
    """Replace the sums of columns at the epochs within reach of the series."""
    for i in range(n):
        if abs(block[SECONDS + i]) <= reach:
            for k in range(6):
                block[SUMS + k * BLOCK + i] = block[NEAR_SUMS + k * BLOCK + i]


@force_inlined
def copy_sums(block, row, skip, start, stop, out):
    """Copy the sums, a lower triangle, to epochs of symmetric matrices (B, D, D, T).

    Those of the epoch `start` are `skip` places after the begin of their rows.
    """
    number = 0
    for k in range(out.shape[1]):
        for j in range(k + 1):
            below, above = out[row, k, j], out[row, j, k]
            below, above = below[start:stop], above[start:stop]
            first = SUMS + number * BLOCK + skip
            sums = block[first : first + len(below)]
            for i in range(len(below)):
                below[i] = sums[i]
            for i in range(len(above)):
                above[i] = sums[i]
            number += 1


@force_inlined
def stream_sums(block, row, spans, out):
    """As `copy_sums`, past the caches; the sums start at the epochs again of a block."""
    first, start, stop, _ = spans
    head = max(start - LINE, first)
    number = 0
    for k in range(out.shape[1]):
        for j in range(k + 1):
            place = SUMS + number * BLOCK
            sums = block[place : place + stop - head]
            _stream_row(sums, out[row, k, j], head, spans)
            if j < k:
                _stream_row(sums, out[row, j, k], head, spans)
            number += 1


# ---- Covariances of the attitude from columns in triangular form
# The columns are linear combinations of parameters, chosen so that column j has no part in the
# first j rows of the weights: P = sum over j of eta_j eta_j^T is the same for columns that are
# turned by an orthogonal matrix.  Most products are by zero then, and one loop adds all columns in
# registers.  Epochs within reach of `short_times` need the columns one by one.

ORDER = (TIME, RATE, PHASE, SECOND, THIRD)
# Columns that change with time: a free rotation has five elements beside its orientation.
_CHANGING = len(ORDER)


@subroutine
def _still_sums(d):
    """The sums of products of the columns that do not change with time."""
    sums = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for j in range(_CHANGING, COLUMNS):
        sums = _with_products(_offset(d, j), sums)
    return sums


@subroutine
def _offset(d, j):
    return d.offset[0, j], d.offset[1, j], d.offset[2, j]


@subroutine
def _added(by, v, to):
    """to + by v."""
    return fma(v[0], by, to[0]), fma(v[1], by, to[1]), fma(v[2], by, to[2])


@subroutine
def _with_products(v, sums):
    x, y, z = v
    xx, xy, yy, xz, yz, zz = sums
    return (
        fma(x, x, xx),
        fma(x, y, xy),
        fma(y, y, yy),
        fma(x, z, xz),
        fma(y, z, yz),
        fma(z, z, zz),
    )


@subroutine
def _basis(block, row, i):
    first = BASIS + 3 * row * BLOCK + i
    return eight(block, first), eight(block, first + BLOCK), eight(block, first + 2 * BLOCK)


@subroutine
def places_of_sums():
    """The places of nine sums in the rows of a block, those beside the diagonal twice."""
    xy, xz, yz = SUMS + BLOCK, SUMS + 3 * BLOCK, SUMS + 4 * BLOCK
    return SUMS, xy, xz, xy, SUMS + 2 * BLOCK, yz, xz, yz, SUMS + 5 * BLOCK


@subroutine
def places_of_rows(first, length):
    """The places of nine rows that follow each other, from an epoch on."""
    second, third = first + 3 * length, first + 6 * length
    return (
        first,
        first + length,
        first + 2 * length,
        second,
        second + length,
        second + 2 * length,
        third,
        third + length,
        third + 2 * length,
    )


def _putting(put, name):
    """The function that stores nine sums by `put_eight`, or past the caches by `put_line`."""

    def store(sums, places, out, i):
        xx, xy, yy, xz, yz, zz = sums
        put(out, places[0] + i, xx)
        put(out, places[1] + i, xy)
        put(out, places[2] + i, xz)
        put(out, places[3] + i, xy)
        put(out, places[4] + i, yy)
        put(out, places[5] + i, yz)
        put(out, places[6] + i, xz)
        put(out, places[7] + i, yz)
        put(out, places[8] + i, zz)

    return subroutine(named(store, name))


_store = _putting(put_eight, "_store")
_stream = _putting(put_line, "_stream")


@subroutine
def sums_of_columns(c, d, block, first, n, places, out, streams):
    """Fill the sums of epochs of a block.

    Given
        c, d       records of CONSTANTS and TANGENTS; the weights of d in ORDER, and its offsets
                   after them, are triangular
        block      rows that `tangents` filled
        first, n   the first epoch, a multiple of 8, and the epochs of the block
        streams    whether lines of the cache of `out` start at the places and are stored past it
    Filled
        out        flat array: the sums xx, xy, xz, yx, yy, yz, zx, zy, zz of the epochs first to
                   n - 1, rounded up to eight, at nine places + the number of the epoch
    """
    w, still, passes = d.weights, _still_sums(d), c.form == codes.HYPERBOLIC
    axis = d.invariant[0, 2], d.invariant[1, 2], d.invariant[2, 2]
    time, rate, rate_1 = w[TIME, 0], w[RATE, 0], w[RATE, 1]
    phase, phase_1, phase_2 = w[PHASE, 0], w[PHASE, 1], w[PHASE, 2]
    second, second_1, second_2, second_3 = w[SECOND, 0], w[SECOND, 1], w[SECOND, 2], w[SECOND, 3]
    third, third_1, third_2 = w[THIRD, 0], w[THIRD, 1], w[THIRD, 2]
    third_3, third_4 = w[THIRD, 3], w[THIRD, 4]
    offset, offset_1, offset_2 = _offset(d, 0), _offset(d, 1), _offset(d, 2)
    offset_3, offset_4 = _offset(d, 3), _offset(d, 4)
    for i in range(first, n, 8):
        seconds = eight(block, SECONDS + i)
        one, two, three = _basis(block, 0, i), _basis(block, 1, i), _basis(block, 2, i)
        if passes:
            two = _added(eight(block, PASSED + i), axis, two)
        v = _added(time * seconds, axis, offset)
        v = _added(second, two, _added(third, three, v))
        sums = _with_products(_added(fma(rate, seconds, phase), one, v), still)
        v = _added(second_1, two, _added(third_1, three, offset_1))
        sums = _with_products(_added(fma(rate_1, seconds, phase_1), one, v), sums)
        v = _added(second_2, two, _added(third_2, three, offset_2))
        sums = _with_products(_added(phase_2, one, v), sums)
        v = _added(second_3, two, _added(third_3, three, offset_3))
        sums = _with_products(v, sums)
        sums = _with_products(_added(third_4, three, offset_4), sums)
        if streams:
            _stream(sums, places, out, i)
        else:
            _store(sums, places, out, i)
