"""The start of a diagonalisation: axes in doubles, made exactly orthogonal in wide integers.

Jacobi's rotations of doubles bring the elements off the diagonal to 1e-16 of the moments; few
rotations of wide integers (`solution.diagonal`) are left.
"""

import math

from attitude.compilation.decorators import subroutine
from attitude.compilation.wide import BITS, load, store, wide
from attitude.solution.diagonal import (
    AXES,
    MATRIX,
    SCRATCH,
    as_whole,
    one,
    quick_product,
    shifted_by,
)
from attitude.solution.vectors import quaternion_of

_SWEEPS = 12
# Elements below this part of the largest moment are left to the wide integers.
_NEGLIGIBLE = 2.0**-54
# Without a larger element off the diagonal, or with moments that differ by less, the start saves no
# rotation of wide integers; axes of equal moments are those of these rotations alone.
_WORTH, _APART = 2.0**-12, 2.0**-20


@subroutine
def approach(tensor, exponent, t, axes, wxyz, w):
    """Turn the matrix of w, and its axes, which are those of the body, to axes of the tensor.

    t, axes (3, 3) and wxyz (4,) are memory for doubles.
    """
    for i in range(3):
        for j in range(3):
            t[i, j] = math.ldexp(tensor[i, j], -exponent)
            axes[i, j] = 1.0 if i == j else 0.0
    if max(abs(t[0, 1]), abs(t[0, 2]), abs(t[1, 2])) < _WORTH:
        return
    for _ in range(_SWEEPS):
        busy = False
        for r in range(2, -1, -1):
            p, q = (0, 1) if r == 2 else ((0, 2) if r == 1 else (1, 2))
            if abs(t[p, q]) > _NEGLIGIBLE:
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
        own = quick_product(a - c, a + c) + quick_product(b - d, b + d)
        store(w, AXES + 4 * i, quick_product(scale, own))
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
