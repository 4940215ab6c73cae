"""A symmetric tensor made diagonal by Jacobi's rotations, in integers of 448 bits.

Golub & Van Loan, Matrix Computations, section 8.5.  `solution.principal` states why so many digits.
"""

import math

import numpy as np

from attitude.compilation.decorators import subroutine
from attitude.compilation.wide import (
    BITS,
    double,
    length,
    load,
    negative,
    product,
    shifted,
    store,
    times,
    whole,
    wide,
    word,
)
from attitude.solution.twofloat import ONE, div, quick_two_sum, sqrt

# Results are rounded to so many bits after the point: equal moments are then equal numbers.
_KEPT = 384
_SPARE = BITS - _KEPT
# Times this, a double from 0.5 to 1 is a whole number.
_TO_WHOLE = 2.0**53
# Off-diagonal elements of fewer bits change no bit that is kept.
_NEGLIGIBLE = BITS - _KEPT - 40
_SWEEPS = 30
# Lengths of an angle of which the cube, and of one of which the square, is below the last bit.
_SMALL, _TINY = BITS - 150, BITS // 2 - 1
# Numbers of the results of one body, in an array of words: moments, ascending, and columns, the
# components over the body axes of the first axis, of the second, of the third.
VALUES, COLUMNS, KEPT = 0, 3, 12
# The array in which a tensor is diagonalised: the upper half of the matrix, the axes as columns of
# a matrix, and memory for other numbers.
MATRIX, AXES, SCRATCH, NEEDED = 0, 9, 18, 27


# The functions of `compilation.wide` as subroutines: inlined, their hundreds of instructions would
# be compiled for a minute.


@subroutine
def product_of(a, b):
    """`times`."""
    return times(a, b)


@subroutine
def quick_product(a, b):
    """`product`."""
    return product(a, b)


@subroutine
def shifted_by(n, places):
    """`shifted` by any number of places."""
    return shifted(n, places)


@subroutine
def as_double(n):
    """`double`."""
    return double(n)


@subroutine
def as_whole(x):
    """`whole`."""
    return whole(x)


@subroutine
def length_of(n):
    """`length`."""
    return length(n)


@subroutine
def one():
    """The number 1."""
    return shifted(wide(1), BITS)


@subroutine
def _half(n, places):
    """n over 2**places, rounded down, for places > 0."""
    return shifted(n, -places)


@subroutine
def magnitude(n):
    """|n|."""
    return wide(0) - n if negative(n) else n


@subroutine
def _root_reciprocal(x):
    """1 / sqrt(x) of x in [1/4, 2], to 2**-440.

    From a pair of doubles y that errs by 2**-103, by y (1 + e/2 + 3 e^2/8 + 5 e^3/16 + 35 e^4/128)
    for e = 1 - x y^2.
    """
    # the first 61 bits after the point, and the 61 after them, as a pair of doubles
    first = word(shifted(x, 61 - BITS))
    second = word(shifted(x, 122 - BITS) - shifted(wide(first), 61))
    high = float(first)
    low = float(first - np.int64(high)) + second * 2.0**-61
    start = div(ONE, sqrt(quick_two_sum(high * 2.0**-61, low * 2.0**-61)))
    y = shifted(wide(np.int64(start[0] * 2.0**61)), BITS - 61)
    y = y + shifted(wide(np.int64(start[1] * 2.0**113)), BITS - 113)
    e = one() - quick_product(x, quick_product(y, y))
    part = shifted(wide(5), BITS - 3) + _half(shifted(e, 5) + e + e + e, 6)  # 5/8 + 35 e/64
    part = shifted(wide(3), BITS - 2) + quick_product(e, part)
    part = _half(quick_product(e, one() + quick_product(e, part)), 1)
    return y + quick_product(y, part)


@subroutine
def _rotate(w, p, q):
    """Turn axes p and q, by the smaller angle, so that the element p, q of the matrix vanishes.

    With the difference d of the diagonal elements and the element o, cos 2a = |d| / h and sin 2a =
    2 |o| / h, h^2 = d^2 + 4 o^2.  The larger of d and 2 o is brought into [1/2, 1) first, so that
    near neighbours lose no digit.
    """
    pp, qq, pq = MATRIX + 4 * p, MATRIX + 4 * q, MATRIX + 3 * p + q
    off = load(w, pq)
    difference = load(w, qq) - load(w, pp)
    rest, twice = magnitude(difference), magnitude(off) + magnitude(off)
    places = BITS - max(length_of(rest), length_of(twice))
    rest, twice = shifted_by(rest, places), shifted_by(twice, places)
    small = length_of(twice) <= _SMALL
    if small:
        # a = |o / d|, its sine and its tangent differ by less than the last bit
        scale = _root_reciprocal(quick_product(rest, rest))
        sine = quick_product(_half(twice, 1), scale)
        secant = one()
        cosine = secant - _half(quick_product(sine, sine), 1)
    else:
        scale = _root_reciprocal(quick_product(rest, rest) + quick_product(twice, twice))
        square = _half(one() + quick_product(rest, scale), 1)  # cos^2 a
        secant = _root_reciprocal(square)
        sine = _half(quick_product(quick_product(twice, scale), secant), 1)
        cosine = quick_product(square, secant)
    if length_of(difference) > 0 and negative(difference) != negative(off):
        sine = wide(0) - sine
    tangent = sine if small else quick_product(sine, secant)
    change = quick_product(tangent, off)
    store(w, pp, load(w, pp) - change)
    store(w, qq, load(w, qq) + change)
    store(w, pq, wide(0))
    r = 3 - p - q
    _mix(w, MATRIX + 3 * min(r, p) + max(r, p), MATRIX + 3 * min(r, q) + max(r, q), cosine, sine)
    for k in range(2):
        _mix(w, AXES + 3 * k + p, AXES + 3 * k + q, cosine, sine)


@subroutine
def _mix(w, i, j, cosine, sine):
    """Turn the pair of numbers i and j."""
    x, y = load(w, i), load(w, j)
    if length_of(sine) <= _TINY:  # the cosine is 1
        store(w, i, x - quick_product(sine, y))
        store(w, j, y + quick_product(sine, x))
        return
    store(w, i, quick_product(cosine, x) - quick_product(sine, y))
    store(w, j, quick_product(sine, x) + quick_product(cosine, y))


@subroutine
def integer_of(x, exponent):
    """x / 2**exponent as an integer over 2**BITS."""
    part, power = math.frexp(x)
    places = power - exponent + BITS - 53
    n = as_whole(part * _TO_WHOLE)
    if places >= 0:
        return shifted_by(n, places)
    if places < -60:
        return wide(0)
    return shifted_by(n + shifted_by(wide(1), -places - 1), places)


@subroutine
def rounded(n):
    """n rounded to _KEPT bits after the binary point."""
    return shifted(_half(n + shifted(wide(1), _SPARE - 1), _SPARE), _SPARE)


@subroutine
def put_pair(row, n, exponent):
    """Fill a row with n / 2**BITS times 2**exponent, as the sum of two doubles."""
    high = as_double(n)
    low = as_double(n - as_whole(high))
    row[0] = math.ldexp(high, exponent - BITS)
    row[1] = math.ldexp(low, exponent - BITS)


@subroutine
def largest_of(a, b, c):
    """The largest magnitude of three doubles."""
    return max(max(abs(a), abs(b)), abs(c))


@subroutine
def put_tensor(tensor, exponent, w):
    """Fill the matrix with a tensor over 2**exponent, and the axes with those of the body."""
    for i in range(3):
        for j in range(3):
            store(w, MATRIX + 3 * i + j, integer_of(tensor[i, j], exponent))
            store(w, AXES + 3 * i + j, one() if i == j else wide(0))


@subroutine
def diagonalise(w):
    """Turn the axes until the matrix has the moments on its diagonal."""
    for _ in range(_SWEEPS):
        busy = False
        for r in range(2, -1, -1):
            p, q = (0, 1) if r == 2 else ((0, 2) if r == 1 else (1, 2))
            if length_of(load(w, MATRIX + 3 * p + q)) > _NEGLIGIBLE:
                _rotate(w, p, q)
                busy = True
        if not busy:
            break
    # The third row of a rotation is the cross product of the others, which alone are turned.
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        first = quick_product(load(w, AXES + j), load(w, AXES + 3 + k))
        other = quick_product(load(w, AXES + k), load(w, AXES + 3 + j))
        store(w, AXES + 6 + i, first - other)


@subroutine
def sort_axes(w, kept):
    """Fill the moments, ascending, and their axes with positive largest components."""
    for k in range(3):
        store(w, MATRIX + 4 * k, rounded(load(w, MATRIX + 4 * k)))
    a, b, c = 0, 1, 2
    if negative(load(w, MATRIX + 4 * b) - load(w, MATRIX + 4 * a)):
        a, b = b, a
    if negative(load(w, MATRIX + 4 * c) - load(w, MATRIX + 4 * b)):
        b, c = c, b
        if negative(load(w, MATRIX + 4 * b) - load(w, MATRIX + 4 * a)):
            a, b = b, a
    for k in range(3):
        axis = a if k == 0 else (b if k == 1 else c)
        store(kept, VALUES + k, load(w, MATRIX + 4 * axis))
        largest = wide(0)
        for i in range(3):
            n = rounded(load(w, AXES + 3 * i + axis))
            store(kept, COLUMNS + 3 * k + i, n)
            if negative(magnitude(largest) - magnitude(n)):
                largest = n
        if negative(largest):
            _reverse(kept, k)
    if _left_handed(kept):
        _reverse(kept, 2)


@subroutine
def _reverse(kept, k):
    """Reverse an axis."""
    for i in range(3):
        store(kept, COLUMNS + 3 * k + i, wide(0) - load(kept, COLUMNS + 3 * k + i))


@subroutine
def _left_handed(kept):
    """Whether the determinant of the columns, 1 or -1, is below zero."""
    total = 0.0
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        minor = _component(kept, 1, j) * _component(kept, 2, k)
        minor -= _component(kept, 1, k) * _component(kept, 2, j)
        total += _component(kept, 0, i) * minor
    return total < 0.0


@subroutine
def _component(kept, axis, i):
    """A component of an axis as a double."""
    return math.ldexp(as_double(load(kept, COLUMNS + 3 * axis + i)), -BITS)
