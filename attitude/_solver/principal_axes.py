"""Principal axes of full inertia tensors, to 115 digits.

Beside the separatrix D2 is 1e-16 of its terms, or 1e-32 for a body that spins about its middle
axis, and 1e9 revolutions multiply its relative error by 1e9: moments and axes to 31 digits do not
suffice.  The doubles of a tensor are integers over a power of two, so Jacobi's rotations (Golub &
Van Loan, Matrix Computations, section 8.5) run in integers of 448 bits; a tensor is diagonalised
once, in 11 us.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from attitude._compilation.decorators import sized_entry_point, subroutine
from attitude._compilation.wide import (
    BITS,
    WORDS,
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
from attitude._solver.twofloat import ONE, div, quick_two_sum, sqrt
from attitude._solver.vectors import quaternion_of

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from attitude._support.annotations import FloatArray


# Results are rounded to so many bits after the point: equal moments are then equal numbers.
_KEPT = 384
_SPARE = BITS - _KEPT
# Times this, a double from 0.5 to 1 is a whole number.
_TO_WHOLE = 2.0**53
# Off-diagonal elements of fewer bits change no bit that is kept.
_NEGLIGIBLE = BITS - _KEPT - 40
_SWEEPS = 30
# Length of an angle of which the cube is below the last bit.
_SMALL = BITS - 150
# Length of one of which the square is.
_TINY = BITS // 2 - 1
# The results of one body, in an array of words: the moments, ascending.
VALUES = 0
# The components over the body axes of the first axis, of the second, of the third.
COLUMNS = 3
# The number of these words.
KEPT = 12
# The array in which a tensor is diagonalised: the upper half of the matrix.
MATRIX = 0
# The axes, as columns of a matrix.
AXES = 9
# Memory for other numbers.
SCRATCH = 18
# The number of all.
NEEDED = 27


# The functions of `wide` as subroutines: inlined, their hundreds of instructions would
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
    series = shifted(wide(5), BITS - 3) + _half(shifted(e, 5) + e + e + e, 6)  # 5/8 + 35 e/64
    series = shifted(wide(3), BITS - 2) + quick_product(e, series)
    series = _half(quick_product(e, one() + quick_product(e, series)), 1)
    return y + quick_product(y, series)


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
    size, twice = magnitude(difference), magnitude(off) + magnitude(off)
    places = BITS - max(length_of(size), length_of(twice))
    size, twice = shifted_by(size, places), shifted_by(twice, places)
    small = length_of(twice) <= _SMALL
    if small:
        # a = |o / d|, its sine and its tangent differ by less than the last bit
        scale = _root_reciprocal(quick_product(size, size))
        sine = quick_product(_half(twice, 1), scale)
        secant = one()
        cosine = secant - _half(quick_product(sine, sine), 1)
    else:
        scale = _root_reciprocal(quick_product(size, size) + quick_product(twice, twice))
        square = _half(one() + quick_product(size, scale), 1)  # cos^2 a
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
    fraction, power = math.frexp(x)
    places = power - exponent + BITS - 53
    n = as_whole(fraction * _TO_WHOLE)
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


# ---- The start of a diagonalisation: axes in doubles, made exactly orthogonal in wide integers
# Jacobi's rotations of doubles bring the elements off the diagonal to 1e-16 of the moments; few
# rotations of wide integers are left.

_SWEEPS_IN_DOUBLES = 12
# Elements below this part of the largest moment are left to the wide integers.
_NEGLIGIBLE_IN_DOUBLES = 2.0**-54
# Without a larger element off the diagonal the start saves no rotation of wide integers.
_WORTH = 2.0**-12
# Nor with moments that differ by less; axes of equal moments are those of these rotations alone.
_APART = 2.0**-20


@subroutine
def approach(tensor, exponent, t, axes, wxyz, w):
    """Turn the matrix of w, and its axes, to axes of the tensor; t, axes, wxyz are memory."""
    for i in range(3):
        for j in range(3):
            t[i, j] = math.ldexp(tensor[i, j], -exponent)
            axes[i, j] = 1.0 if i == j else 0.0
    if max(abs(t[0, 1]), abs(t[0, 2]), abs(t[1, 2])) < _WORTH:
        return
    for _ in range(_SWEEPS_IN_DOUBLES):
        busy = False
        for r in range(2, -1, -1):
            p, q = (0, 1) if r == 2 else ((0, 2) if r == 1 else (1, 2))
            if abs(t[p, q]) > _NEGLIGIBLE_IN_DOUBLES:
                _turn(t, axes, p, q)
                busy = True
        if not busy:
            break
    a, b, c = t[0, 0], t[1, 1], t[2, 2]
    if min(abs(a - b), abs(a - c), abs(b - c)) > _APART:
        quaternion_of(axes, wxyz)
        _put_rotation(wxyz, w)
        _turn_matrix(w)


@subroutine
def _turn(t, axes, p, q):
    """Turn axes p and q, by the smaller angle, so that the element p, q of t vanishes."""
    off, difference = t[p, q], t[q, q] - t[p, p]
    twice = off + off if difference >= 0.0 else -(off + off)
    tangent = twice / (abs(difference) + math.sqrt(difference * difference + twice * twice))
    cosine = 1.0 / math.sqrt(1.0 + tangent * tangent)
    sine = tangent * cosine
    t[p, p] -= tangent * off
    t[q, q] += tangent * off
    t[p, q] = 0.0
    r = 3 - p - q
    i, j = min(r, p), max(r, p)
    k, m = min(r, q), max(r, q)
    t[i, j], t[k, m] = cosine * t[i, j] - sine * t[k, m], sine * t[i, j] + cosine * t[k, m]
    for i in range(3):
        x, y = axes[i, p], axes[i, q]
        axes[i, p], axes[i, q] = cosine * x - sine * y, sine * x + cosine * y


@subroutine
def _put_rotation(wxyz, w):
    """Fill the axes of w with the rotation matrix of a quaternion of length 1 to some roundings."""
    size = wide(0)
    for k in range(4):
        n = shifted_by(as_whole(float(round(wxyz[k] * 2.0**53))), BITS - 53)
        store(w, SCRATCH + k, n)
        size = size + quick_product(n, n)
    # 1 / size = (1 + d) (1 + d^2) (1 + d^4) (1 + d^8) to d^16, d = 1 - size
    d = one() - size
    scale = one() + d
    for _ in range(3):
        d = quick_product(d, d)
        scale = scale + quick_product(scale, d)
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        a, b = load(w, SCRATCH), load(w, SCRATCH + 1 + i)
        c, d = load(w, SCRATCH + 1 + j), load(w, SCRATCH + 1 + k)
        diagonal = quick_product(a - c, a + c) + quick_product(b - d, b + d)
        store(w, AXES + 4 * i, quick_product(scale, diagonal))
        both, turned = quick_product(b, c), quick_product(a, d)
        twice = scale + scale
        store(w, AXES + 3 * i + j, quick_product(twice, both - turned))
        store(w, AXES + 3 * j + i, quick_product(twice, both + turned))


@subroutine
def _turn_matrix(w):
    """Replace the matrix of w by its components along the axes."""
    for i in range(3):
        for k in range(3):
            total = wide(0)
            for j in range(3):
                place = MATRIX + 3 * min(i, j) + max(i, j)
                total = total + quick_product(load(w, place), load(w, AXES + 3 * j + k))
            store(w, SCRATCH + 3 * i + k, total)
    for i in range(3):
        for k in range(i, 3):
            total = wide(0)
            for j in range(3):
                total = total + quick_product(
                    load(w, AXES + 3 * j + i), load(w, SCRATCH + 3 * j + k)
                )
            store(w, MATRIX + 3 * i + k, total)


# ---- Principal axes of many bodies

# Asymmetry of a tensor, relative to its largest entry, that counts as rounding.
ASYMMETRY: float = 1e-13
# Rounding error of a moment that is zero, relative to the largest.
_ZERO_MOMENT = 1e-15


@subroutine
def _given_axes(t, kept, moments, axes):
    """Fill the results of a diagonal tensor: its diagonal, in this order, about the body axes."""
    for k in range(KEPT):
        store(kept, k, wide(0))
    for k in range(3):
        moments[k, 0], moments[k, 1] = t[k, k], 0.0
        for i in range(3):
            axes[i, k, 0], axes[i, k, 1] = 1.0 if i == k else 0.0, 0.0


@subroutine
def _rod(kept, moments):
    """Set a least moment that is zero within rounding to 0, and the others to their mean."""
    if not -_ZERO_MOMENT * moments[2, 0] <= moments[0, 0] <= 0.0:
        return
    store(kept, VALUES, wide(0))
    for half in range(2):
        mean = 0.5 * (moments[1, half] + moments[2, half])
        moments[0, half], moments[1, half], moments[2, half] = 0.0, mean, mean


@sized_entry_point
def _principal_all(tensors, w, words, moments, axes, wxyz):
    """Fill the arrays of `PrincipalAxes` of tensors (B, 3, 3); w is memory for NEEDED numbers."""
    for b in range(len(tensors)):
        kept, t = words[b], tensors[b]
        if t[0, 1] == 0.0 and t[0, 2] == 0.0 and t[1, 2] == 0.0:
            _given_axes(t, kept, moments[b], axes[b])
        else:
            size = largest_of(t[0, 0], t[1, 1], t[2, 2])
            exponent = math.frexp(max(size, largest_of(t[0, 1], t[0, 2], t[1, 2])))[1]
            put_tensor(t, exponent, w)
            approach(t, exponent, axes[b, :, :, 0], axes[b, :, :, 1], wxyz[b], w)
            diagonalise(w)
            sort_axes(w, kept)
            for k in range(3):
                put_pair(moments[b, k], load(kept, VALUES + k), exponent)
                for i in range(3):
                    put_pair(axes[b, i, k], load(kept, COLUMNS + 3 * k + i), 0)
            _rod(kept, moments[b])
        quaternion_of(axes[b, :, :, 0], wxyz[b])


@sized_entry_point
def _over_axes_all(words, omega, rates, differences):
    """Fill the results of `PrincipalAxes.over_axes`."""
    for n in range(len(omega)):
        w = words[n if len(words) > 1 else 0]
        x, y, z = omega[n, 0], omega[n, 1], omega[n, 2]
        # each by itself: the largest of 1 and NaN is 1
        finite = abs(x) < math.inf and abs(y) < math.inf and abs(z) < math.inf
        same_axes = length_of(load(w, COLUMNS)) + length_of(load(w, COLUMNS + 1)) == 0
        same_axes = same_axes and length_of(load(w, COLUMNS + 2)) == 0
        if same_axes or not finite:
            for k in range(3):
                rates[n, k, 0], rates[n, k, 1] = omega[n, k], 0.0
                differences[n, k, 0] = differences[n, k, 1] = math.nan
        else:
            exponent = math.frexp(largest_of(x, y, z))[1]
            p = integer_of(x, exponent)
            q = integer_of(y, exponent)
            r = integer_of(z, exponent)
            _resolve(w, p, q, r, exponent, rates[n], differences[n])


@subroutine
def _resolve(w, x, y, z, exponent, rates, differences):
    """Fill the results of one body: x, y, z is its angular velocity over 2**exponent."""
    tempo = 0.0
    first = along = wide(0)
    for k in range(3):
        i = COLUMNS + 3 * k
        total = product_of(load(w, i), x) + product_of(load(w, i + 1), y)
        along = rounded(total + product_of(load(w, i + 2), z))
        put_pair(rates[k], along, exponent)
        tempo = max(tempo, abs(as_double(along)))
        if k == 0:
            first = along
    if length_of(load(w, VALUES)) == 0:
        for k in range(3):
            differences[k, 0] = differences[k, 1] = math.nan
    else:
        _put_differences(w, first, along, math.frexp(tempo)[1] - BITS, differences)


@subroutine
def _put_differences(w, x, z, tempo, out):
    """Fill the differences of one body: x and z are the rates about the outer axes."""
    a, b, c = load(w, VALUES), load(w, VALUES + 1), load(w, VALUES + 2)
    inertia = math.frexp(as_double(c))[1] - BITS
    x, z = magnitude(x), magnitude(z)
    of_greatest = product_of(product_of(c, c - b), product_of(z, z))
    of_least = product_of(product_of(a, b - a), product_of(x, x))
    put_pair(out[0], b - a, -inertia)
    put_pair(out[1], c - b, -inertia)
    put_pair(out[2], of_greatest - of_least, -2 * (inertia + tempo))


class PrincipalAxes(NamedTuple):
    """Principal moments and axes of B symmetric tensors, whose doubles are taken as exact.

    moments: pairs of doubles in the unit of the tensors: ascending, of a diagonal tensor its
        diagonal.  A least moment that is zero within rounding is 0; the body is then a rod.
    axes: pairs of doubles: unit columns over the body axes, right-handed.  The largest component
        of each is positive, except where that would make the third left-handed.
    """

    words: NDArray[np.int64]  # (B, 7 KEPT), moments and axes to 115 digits, integers of `wide`
    moments: FloatArray  # (B, 3, 2)
    axes: FloatArray  # (B, 3, 3, 2)
    wxyz: FloatArray  # (B, 4), unit quaternions, principal axes to body axes, w >= 0

    @classmethod
    def of(cls, tensors: FloatArray) -> PrincipalAxes:
        """Those of tensors (B, 3, 3), symmetric and finite."""
        count = len(tensors)
        axes = cls(
            np.empty((count, WORDS * KEPT), dtype=np.int64),
            np.empty((count, 3, 2)),
            np.empty((count, 3, 3, 2)),
            np.empty((count, 4)),
        )
        _principal_all(tensors, np.empty(WORDS * NEEDED, dtype=np.int64), *axes)
        return axes

    def over_axes(self, omega: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Angular velocities (N, 3) over principal axes, (N, 3, 2), and differences (N, 3, 2)."""
        rates, differences = np.empty((len(omega), 3, 2)), np.empty((len(omega), 3, 2))
        _over_axes_all(self.words, omega, rates, differences)
        return rates, differences
