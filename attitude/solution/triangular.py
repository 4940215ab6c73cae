"""Covariances of the attitude from columns in triangular form.

The columns are linear combinations of parameters, chosen so that column j has no part in the first
j rows of the weights: P = sum over j of eta_j eta_j^T is the same for columns that are turned by an
orthogonal matrix.  Most products are by zero then, and one loop adds all columns in registers.
Epochs within reach of solution.short_times need the columns one by one.

Given
    c, d       records of solution.record and solution.tangent_record; the weights of d in the order
               TRIGONOMETRIC_ROWS or HYPERBOLIC_ROWS, and its offsets after them, are triangular
    n          epochs of the block
    block      rows that solution.tangents filled
Filled
    block      SUMS: the rows xx, xy, yy, xz, yz, zz
"""

from attitude.compilation.decorators import force_inlined, subroutine
from attitude.compilation.instructions import fma
from attitude.solution.tangent_record import (
    BASIS,
    BLOCK,
    COLUMNS,
    PASSAGE,
    PASSED,
    PHASE,
    RATE,
    SECOND,
    SECONDS,
    SUMS,
    THIRD,
    TIME,
    TURN,
    Y,
)

# WIND is four times SECOND where the motion passes.
TRIGONOMETRIC_ROWS = (TIME, RATE, PHASE, SECOND, THIRD)
HYPERBOLIC_ROWS = (TIME, RATE, PASSAGE, TURN, PHASE, SECOND, THIRD)


@subroutine
def _still_sums(d, first):
    """The sums of products of the columns from `first` on, which do not change with time."""
    xx = xy = yy = xz = yz = zz = 0.0
    for j in range(first, COLUMNS):
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
    return block[first], block[first + BLOCK], block[first + 2 * BLOCK]


@subroutine
def _store(sums, block, i):
    block[SUMS + i] = sums[0]
    block[SUMS + BLOCK + i] = sums[1]
    block[SUMS + 2 * BLOCK + i] = sums[2]
    block[SUMS + 3 * BLOCK + i] = sums[3]
    block[SUMS + 4 * BLOCK + i] = sums[4]
    block[SUMS + 5 * BLOCK + i] = sums[5]


@force_inlined
def trigonometric_sums(d, n, block):
    """Fill the sums of a block of the trigonometric form; see the module docstring."""
    w, still = d.weights, _still_sums(d, 5)
    axis = d.invariant[0, 2], d.invariant[1, 2], d.invariant[2, 2]
    time, rate, rate_1 = w[TIME, 0], w[RATE, 0], w[RATE, 1]
    phase, phase_1, phase_2 = w[PHASE, 0], w[PHASE, 1], w[PHASE, 2]
    second, second_1, second_2, second_3 = w[SECOND, 0], w[SECOND, 1], w[SECOND, 2], w[SECOND, 3]
    third, third_1, third_2 = w[THIRD, 0], w[THIRD, 1], w[THIRD, 2]
    third_3, third_4 = w[THIRD, 3], w[THIRD, 4]
    offset, offset_1, offset_2 = _offset(d, 0), _offset(d, 1), _offset(d, 2)
    offset_3, offset_4 = _offset(d, 3), _offset(d, 4)
    for i in range(n):
        seconds = block[SECONDS + i]
        one, two, three = _basis(block, 0, i), _basis(block, 1, i), _basis(block, 2, i)
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
        _store(sums, block, i)


@force_inlined
def hyperbolic_sums(c, d, n, block):
    """Fill the sums of a block of the hyperbolic form; see the module docstring."""
    w, still, winds = d.weights, _still_sums(d, 7), 4.0 if c.winds != 0.0 else 0.0
    axis = d.invariant[0, 2], d.invariant[1, 2], d.invariant[2, 2]
    time, rate, rate_1 = w[TIME, 0], w[RATE, 0], w[RATE, 1]
    passage, passage_1, passage_2 = w[PASSAGE, 0], w[PASSAGE, 1], w[PASSAGE, 2]
    turn, turn_1, turn_2, turn_3 = w[TURN, 0], w[TURN, 1], w[TURN, 2], w[TURN, 3]
    phase, phase_1, phase_2 = w[PHASE, 0], w[PHASE, 1], w[PHASE, 2]
    phase_3, phase_4 = w[PHASE, 3], w[PHASE, 4]
    second, second_1, second_2, second_3 = w[SECOND, 0], w[SECOND, 1], w[SECOND, 2], w[SECOND, 3]
    second_4, second_5 = w[SECOND, 4], w[SECOND, 5]
    third, third_1, third_2, third_3 = w[THIRD, 0], w[THIRD, 1], w[THIRD, 2], w[THIRD, 3]
    third_4, third_5, third_6 = w[THIRD, 4], w[THIRD, 5], w[THIRD, 6]
    offset, offset_1, offset_2 = _offset(d, 0), _offset(d, 1), _offset(d, 2)
    offset_3, offset_4 = _offset(d, 3), _offset(d, 4)
    offset_5, offset_6 = _offset(d, 5), _offset(d, 6)
    for i in range(n):
        seconds, passed, y = block[SECONDS + i], block[PASSED + i], block[Y + i]
        one, three = _basis(block, 0, i), _basis(block, 2, i)
        two = _added(winds * passed, axis, _basis(block, 1, i))
        a = fma(-turn, y, fma(-passage, passed, fma(rate, seconds, phase)))
        v = _added(time * seconds, axis, offset)
        v = _added(second, two, _added(third, three, v))
        sums = _with_products(_added(a, one, v), still)
        a = fma(-turn_1, y, fma(-passage_1, passed, fma(rate_1, seconds, phase_1)))
        v = _added(second_1, two, _added(third_1, three, offset_1))
        sums = _with_products(_added(a, one, v), sums)
        a = fma(-turn_2, y, fma(-passage_2, passed, phase_2))
        v = _added(second_2, two, _added(third_2, three, offset_2))
        sums = _with_products(_added(a, one, v), sums)
        v = _added(second_3, two, _added(third_3, three, offset_3))
        sums = _with_products(_added(fma(-turn_3, y, phase_3), one, v), sums)
        v = _added(second_4, two, _added(third_4, three, offset_4))
        sums = _with_products(_added(phase_4, one, v), sums)
        v = _added(second_5, two, _added(third_5, three, offset_5))
        sums = _with_products(v, sums)
        sums = _with_products(_added(third_6, three, offset_6), sums)
        _store(sums, block, i)
