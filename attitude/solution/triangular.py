"""Covariances of the attitude from columns in triangular form.

The columns are linear combinations of parameters, chosen so that column j has no part in the first
j rows of the weights: P = sum over j of eta_j eta_j^T is the same for columns that are turned by an
orthogonal matrix.  Most products are by zero then, and one loop adds all columns in registers.
Epochs within reach of solution.short_times need the columns one by one.

Given
    c, d       records of solution.record and solution.tangent_record; the weights of d in ORDER,
               and its offsets after them, are triangular
    n          epochs of the block
    block      rows that solution.tangents filled
    first      multiple of 8
    streams    whether the lines of the cache of `out` start at the places and are stored past it
Filled
    out        flat array: the sums xx, xy, xz, yx, yy, yz, zx, zy, zz of the epochs first to n - 1,
               rounded up to eight, of the block, at nine places + the number of the epoch
"""

from attitude.compilation.decorators import subroutine
from attitude.compilation.instructions import fma
from attitude.compilation.simd import eight, put_eight
from attitude.compilation.streaming import put_line
from attitude.solution import codes
from attitude.solution.tangent_record import (
    BASIS,
    BLOCK,
    COLUMNS,
    PASSED,
    PHASE,
    RATE,
    SECOND,
    SECONDS,
    SUMS,
    THIRD,
    TIME,
)

ORDER = (TIME, RATE, PHASE, SECOND, THIRD)
# Columns that change with time: a free rotation has five elements beside its orientation.
_CHANGING = len(ORDER)


@subroutine
def _still_sums(d):
    """The sums of products of the columns that do not change with time."""
    xx = xy = yy = xz = yz = zz = 0.0
    for j in range(_CHANGING, COLUMNS):
        x, y, z = d.offset[0, j], d.offset[1, j], d.offset[2, j]
        xx, xy, yy = fma(x, x, xx), fma(x, y, xy), fma(y, y, yy)
        xz, yz, zz = fma(x, z, xz), fma(y, z, yz), fma(z, z, zz)
    return xx, xy, yy, xz, yz, zz


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
        *(fma(x, x, xx), fma(x, y, xy), fma(y, y, yy)),
        *(fma(x, z, xz), fma(y, z, yz), fma(z, z, zz)),
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
        *(first, first + length, first + 2 * length),
        *(second, second + length, second + 2 * length),
        *(third, third + length, third + 2 * length),
    )


@subroutine
def _store(sums, places, out, i):
    xx, xy, yy, xz, yz, zz = sums
    put_eight(out, places[0] + i, xx)
    put_eight(out, places[1] + i, xy)
    put_eight(out, places[2] + i, xz)
    put_eight(out, places[3] + i, xy)
    put_eight(out, places[4] + i, yy)
    put_eight(out, places[5] + i, yz)
    put_eight(out, places[6] + i, xz)
    put_eight(out, places[7] + i, yz)
    put_eight(out, places[8] + i, zz)


@subroutine
def _stream(sums, places, out, i):
    xx, xy, yy, xz, yz, zz = sums
    put_line(out, places[0] + i, xx)
    put_line(out, places[1] + i, xy)
    put_line(out, places[2] + i, xz)
    put_line(out, places[3] + i, xy)
    put_line(out, places[4] + i, yy)
    put_line(out, places[5] + i, yz)
    put_line(out, places[6] + i, xz)
    put_line(out, places[7] + i, yz)
    put_line(out, places[8] + i, zz)


@subroutine
def sums_of_columns(c, d, block, first, n, places, out, streams):
    """Fill the sums of epochs of a block; see the module docstring."""
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
