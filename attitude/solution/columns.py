"""Columns of the sensitivity from the tangents of a block of epochs.

Given
    d          record of solution.tangent_record
    j          number of the column
    block      rows that solution.tangents filled
Filled
    x, y, z    (n,) the rotation vector of the change of attitude over inertial axes, or the change
               of the angular velocity, rad/s over the given body axes
"""

from attitude.compilation.decorators import force_inlined
from attitude.compilation.instructions import fma
from attitude.compilation.streaming import LINE, copy_line, past_line
from attitude.solution.tangent_record import (
    BASIS,
    BLOCK,
    FOUND,
    NEAR_SUMS,
    OMEGA,
    ONES,
    PASSED,
    PHASE,
    RATE,
    SECOND,
    SECONDS,
    SUMS,
    THIRD,
    TIME,
    TURNED,
    WIND,
    WXYZ,
    ZEROS,
)

# Results of as many doubles, 4 MB, are stored past the caches: they do not stay there.
STREAMED = 1 << 19


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
    found = 0
    for i in range(n):
        found |= block[SECONDS + i] != block[SECONDS + i]
    return found != 0


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


@force_inlined
def attitude_column(d, j, block, x, y, z):
    """Fill the change of attitude of a motion that tumbles."""
    weights = d.weights
    time, rate, start = weights[TIME, j], weights[RATE, j], weights[PHASE, j]
    second, third, wind = weights[SECOND, j], weights[THIRD, j], weights[WIND, j]
    lx, ly, lz = d.invariant[0, 2], d.invariant[1, 2], d.invariant[2, 2]
    ox, oy, oz = d.offset[0, j], d.offset[1, j], d.offset[2, j]
    for i in range(len(x)):
        seconds = block[SECONDS + i]
        a, along = fma(rate, seconds, start), fma(time, seconds, wind * block[PASSED + i])
        u = fma(block[BASIS + 6 * BLOCK + i], third, lx * along)
        v = fma(block[BASIS + 7 * BLOCK + i], third, ly * along)
        w = fma(block[BASIS + 8 * BLOCK + i], third, lz * along)
        u = fma(block[BASIS + i], a, fma(block[BASIS + 3 * BLOCK + i], second, u))
        v = fma(block[BASIS + BLOCK + i], a, fma(block[BASIS + 4 * BLOCK + i], second, v))
        w = fma(block[BASIS + 2 * BLOCK + i], a, fma(block[BASIS + 5 * BLOCK + i], second, w))
        x[i] = u + ox
        y[i] = v + oy
        z[i] = w + oz


@force_inlined
def rate_column(d, j, block, x, y, z):
    """Fill the change of the angular velocity of a motion that tumbles.

    The body's momentum changes by R^T (dL - eta x L) = I dw + dI w; what turns about L alone is
    left out of eta, so that its growth with time costs no digits.
    """
    weights = d.weights
    rate, start = weights[RATE, j], weights[PHASE, j]
    second, third = weights[SECOND, j], weights[THIRD, j]
    lx, ly, lz = d.momentum[0], d.momentum[1], d.momentum[2]
    ox, oy, oz = d.offset[0, j], d.offset[1, j], d.offset[2, j]
    ix, iy, iz = d.impulse[0, j], d.impulse[1, j], d.impulse[2, j]
    p, inverse = d.principal, d.inverse
    p00, p01, p02 = p[0, 0], p[0, 1], p[0, 2]
    p10, p11, p12 = p[1, 0], p[1, 1], p[1, 2]
    p20, p21, p22 = p[2, 0], p[2, 1], p[2, 2]
    one, two, three = inverse[0], inverse[1], inverse[2]
    m0, m1, m2 = d.of_moment[0, j], d.of_moment[1, j], d.of_moment[2, j]
    for i in range(len(x)):
        a = fma(rate, block[SECONDS + i], start)
        u = fma(block[BASIS + 3 * BLOCK + i], second, block[BASIS + 6 * BLOCK + i] * third)
        v = fma(block[BASIS + 4 * BLOCK + i], second, block[BASIS + 7 * BLOCK + i] * third)
        w = fma(block[BASIS + 5 * BLOCK + i], second, block[BASIS + 8 * BLOCK + i] * third)
        u = fma(block[BASIS + i], a, u) + ox
        v = fma(block[BASIS + BLOCK + i], a, v) + oy
        w = fma(block[BASIS + 2 * BLOCK + i], a, w) + oz
        ux = ix - fma(v, lz, -w * ly)
        uy = iy - fma(w, lx, -u * lz)
        uz = iz - fma(u, ly, -v * lx)
        # to body axes: the vector part of q* u q
        qw, qx = block[WXYZ + i], -block[WXYZ + BLOCK + i]
        qy, qz = -block[WXYZ + 2 * BLOCK + i], -block[WXYZ + 3 * BLOCK + i]
        tx = 2.0 * fma(qy, uz, -qz * uy)
        ty = 2.0 * fma(qz, ux, -qx * uz)
        tz = 2.0 * fma(qx, uy, -qy * ux)
        bx = fma(qw, tx, ux) + fma(qy, tz, -qz * ty)
        by = fma(qw, ty, uy) + fma(qz, tx, -qx * tz)
        bz = fma(qw, tz, uz) + fma(qx, ty, -qy * tx)
        wx, wy, wz = block[OMEGA + i], block[OMEGA + BLOCK + i], block[OMEGA + 2 * BLOCK + i]
        ax = fma(p00, bx, fma(p10, by, p20 * bz)) - m0 * fma(p00, wx, fma(p10, wy, p20 * wz))
        ay = fma(p01, bx, fma(p11, by, p21 * bz)) - m1 * fma(p01, wx, fma(p11, wy, p21 * wz))
        az = fma(p02, bx, fma(p12, by, p22 * bz)) - m2 * fma(p02, wx, fma(p12, wy, p22 * wz))
        bx, by, bz = one * ax, two * ay, three * az
        x[i] = fma(p00, bx, fma(p01, by, p02 * bz))
        y[i] = fma(p10, bx, fma(p11, by, p12 * bz))
        z[i] = fma(p20, bx, fma(p21, by, p22 * bz))


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
def _stream_row(found, row, head, spans):
    """Store the whole lines of epochs start to stop of a row past the caches, and its ends.

    Given
        found      (stop - head,) the row at epochs head to stop
        row        (T,) a contiguous row of the result
        spans      the first epoch of the motion, of the block, that after the block, after the last
    """
    first, start, stop, end = spans
    past = past_line(row)
    place = start if start == first else start - (past + start) % LINE
    last = end if stop == end else stop - (past + stop) % LINE
    while place < last and (past + place) % LINE != 0:
        row[place] = found[place - head]
        place += 1
    while place + LINE <= last:
        copy_line(found, place - head, row, place)
        place += LINE
    while place < last:
        row[place] = found[place - head]
        place += 1


@force_inlined
def start_sums(n, rows, block):
    """Set the rows of the sums of products to 0."""
    for k in range(rows):
        for i in range(n):
            block[SUMS + k * BLOCK + i] = 0.0


@force_inlined
def keep_turn(n, block):
    """Keep the change of attitude while that of the angular velocity is found."""
    for i in range(n):
        block[TURNED + i] = block[FOUND + i]
        block[TURNED + BLOCK + i] = block[FOUND + BLOCK + i]
        block[TURNED + 2 * BLOCK + i] = block[FOUND + 2 * BLOCK + i]


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
    """Keep the sums of the changes of attitude while solution.triangular finds those far away."""
    for k in range(6):
        for i in range(n):
            block[NEAR_SUMS + k * BLOCK + i] = block[SUMS + k * BLOCK + i]


@force_inlined
def use_near_sums(n, reach, block):
    """Replace the sums of solution.triangular at the epochs within reach of the series."""
    for i in range(n):
        if 0.0 < abs(block[SECONDS + i]) <= reach:
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
