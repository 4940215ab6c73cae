"""Principal moments and axes of a full inertia tensor, to two doubles.

A moment known to one double limits the attitude to 1e-7 rad after 1e9 revolutions.  Jacobi's
rotations in pairs of doubles leave 1e-31 and do
not touch a tensor that is diagonal already (Golub & Van Loan, Matrix Computations, section 8.5).
"""

import math

import numpy as np

from attitude.solution.machine import compiled, inlined
from attitude.solution.twofloat import ONE, ZERO, absolute, add, div, mul, neg, sqrt, square, sub

_SWEEPS = 20
_NOTHING = 1e-33  # of the geometric mean of the two moments: below the last place of a pair


@compiled
def principal(tensor, moments, axes):
    """Diagonalise one symmetric tensor.

    Given
        tensor   (3, 3) the doubles are taken as exact
    Filled
        moments  (3, 2) eigenvalues, pairs
        axes     (3, 3, 2) columns: unit eigenvectors, right-handed, pairs
    """
    for i in range(3):
        for j in range(3):
            axes[i, j, 0] = 1.0 if i == j else 0.0
            axes[i, j, 1] = 0.0
    a = np.zeros((3, 3, 2))
    a[:, :, 0] = tensor
    for _ in range(_SWEEPS):
        busy = False
        for p in range(2):
            for q in range(p + 1, 3):
                size = math.sqrt(abs(a[p, p, 0])) * math.sqrt(abs(a[q, q, 0]))
                if abs(a[p, q, 0]) > _NOTHING * size:
                    _rotate(a, axes, p, q)
                    busy = True
        if not busy:
            break
    for i in range(3):
        moments[i, 0], moments[i, 1] = a[i, i, 0], a[i, i, 1]


@compiled
def components(axes, vector, out):
    """Components (3, 2), pairs, of a vector (3,) over axes (3, 3, 2) that are its columns."""
    for j in range(3):
        total = ZERO
        for i in range(3):
            total = add(total, mul(_get(axes, i, j), (vector[i], 0.0)))
        out[j, 0], out[j, 1] = total


@inlined
def _get(a, i, j):
    return a[i, j, 0], a[i, j, 1]


@inlined
def _put(a, i, j, pair):
    a[i, j, 0], a[i, j, 1] = pair


@inlined
def _rotate(a, axes, p, q):
    """Turn axes p and q so that a[p, q] vanishes."""
    off = _get(a, p, q)
    half = sub(_get(a, q, q), _get(a, p, p))
    half = div((0.5 * half[0], 0.5 * half[1]), off)
    tangent = div(ONE, add(absolute(half), sqrt(add(square(half), ONE))))
    if half[0] < 0.0:
        tangent = neg(tangent)
    cosine = div(ONE, sqrt(add(square(tangent), ONE)))
    sine = mul(tangent, cosine)
    change = mul(tangent, off)
    _put(a, p, p, sub(_get(a, p, p), change))
    _put(a, q, q, add(_get(a, q, q), change))
    _put(a, p, q, ZERO)
    _put(a, q, p, ZERO)
    r = 3 - p - q
    x, y = _get(a, r, p), _get(a, r, q)
    new_x = sub(mul(cosine, x), mul(sine, y))
    new_y = add(mul(sine, x), mul(cosine, y))
    _put(a, r, p, new_x)
    _put(a, p, r, new_x)
    _put(a, r, q, new_y)
    _put(a, q, r, new_y)
    for i in range(3):
        x, y = _get(axes, i, p), _get(axes, i, q)
        _put(axes, i, p, sub(mul(cosine, x), mul(sine, y)))
        _put(axes, i, q, add(mul(sine, x), mul(cosine, y)))
