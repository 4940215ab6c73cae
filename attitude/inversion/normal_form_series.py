"""Attitudes of a free rotation from its five elements, and their derivatives, for many epochs.

The series of docs/derivation.md (section 15) with four terms, eight epochs at a time.  Elements
here are per unit of time of the epochs: precession and nutation in turns (lambda / 2 pi, f), the
phase in turns, ln rho, X.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal, NamedTuple

import numpy as np

from attitude.compilation.decorators import reduction, reduction_within
from attitude.compilation.elementary import cosine_and_sine
from attitude.compilation.simd import eight, put_eight, root

if TYPE_CHECKING:
    from attitude.annotations import FloatArray

# Epochs of one vector: arrays of epochs are as long as a multiple of this.
LANES = 8
# Terms of each series beside the first of A, and numbers j and j (j + 1)/2 of powers of X.
_N, _J = np.arange(4), np.arange(8)
_SIGN, _TRIANGLE = (-1.0) ** _N, 0.5 * _J * (_J + 1)


class SeriesAttitudes(NamedTuple):
    """Attitudes and tangents at N epochs.

    Rotation matrices from body axes to axes with z along the momentum, by rows, matrix (9, N);
    rotation vectors over those axes by phase (rad), ln rho and X, tangents (9, N).
    """

    matrix: FloatArray
    tangents: FloatArray


def padded(given: FloatArray, mode: Literal["edge", "constant"] = "edge") -> FloatArray:
    """An array (..., N) with its last entry, or zero, repeated until `LANES` divides N."""
    more = -given.shape[-1] % LANES
    widths = [(0, 0)] * (given.ndim - 1) + [(0, more)]
    return np.ascontiguousarray(np.pad(given, widths, mode) if more else given)


def coefficients(states: FloatArray) -> FloatArray:
    """The coefficients of the series of elements (S, 5 or more): an array (S, 4, 4, 2).

    Those of E^n and E^-n: A's sums and differences, b's sums and differences (b without its factor
    -i); the last axis holds the coefficient and its derivative by X.
    """
    log_rho, x = states[:, 3, None], states[:, 4, None]
    c = _SIGN * np.exp(4.0 * log_rho * _N**2)
    d = _SIGN * np.exp(log_rho * (4 * _N**2 + 4 * _N + 1))
    # X^0, X^1, X^3, X^6 ... X^28, and their derivatives
    power, slope = np.empty((2, len(states), len(_J)))
    power[:, 0], power[:, 1:] = 1.0, x
    power = np.cumprod(np.cumprod(power, axis=1), axis=1)
    slope[:, 0], slope[:, 1:2] = 0.0, 1.0
    slope[:, 2:] = np.cumprod(np.cumprod(np.repeat(x, 7, axis=1), axis=1)[:, 1:], axis=1)
    found = np.empty((len(states), 4, 4, 2))
    for k, each in enumerate((power, slope * _TRIANGLE)):
        up, down = c * each[:, ::2], c * np.concatenate([each[:, :1], each[:, 1:-1:2]], axis=1)
        found[:, 0, :, k], found[:, 1, :, k] = up + down, up - down
        up, down = -d * each[:, 1::2], d * each[:, ::2]
        found[:, 2, :, k], found[:, 3, :, k] = down + up, up - down
    found[:, 0, 0, 0] = 1.0
    return found


def at_epochs(state: FloatArray, t: FloatArray) -> SeriesAttitudes:
    """The attitudes of one state, elements first, at epochs (N,)."""
    epochs = padded(t)
    r, g = np.empty((9, epochs.size)), np.empty((9, epochs.size))
    one = np.ascontiguousarray(state[None, :3])
    attitudes(one, coefficients(state[None]), epochs, r.reshape(-1), g.reshape(-1))
    return SeriesAttitudes(r[:, : t.size], g[:, : t.size])


@reduction_within
def _turning(ax, ay, bx, by, px, py, qx, qy, cy, sy, over):
    """The rotation vector of a change (p, q) of the two numbers (a, b) of an attitude."""
    re = ax * qx - ay * qy - bx * px + by * py
    im = ax * qy + ay * qx - bx * py - by * px
    third = py * ax - px * ay + qy * bx - qx * by
    return over * (cy * re - sy * im), over * (cy * im + sy * re), over * third


@reduction_within
def _multiples(c1, s1):
    """Cosine and sine of two to seven times an angle."""
    c2, s2 = c1 * c1 - s1 * s1, 2.0 * c1 * s1
    c3, s3 = c1 * c2 - s1 * s2, s1 * c2 + c1 * s2
    c4, s4 = c2 * c2 - s2 * s2, 2.0 * c2 * s2
    c5, s5 = c1 * c4 - s1 * s4, s1 * c4 + c1 * s4
    c6, s6 = c2 * c4 - s2 * s4, s2 * c4 + c2 * s4
    c7, s7 = c1 * c6 - s1 * s6, s1 * c6 + c1 * s6
    return c2, s2, c3, s3, c4, s4, c5, s5, c6, s6, c7, s7


@reduction_within
def _rows(w, x, y, z):
    """The rows of the matrix of a unit quaternion."""
    return (
        (1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)),
        (2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)),
        (2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)),
    )


@reduction_within
def put_three(array, at, n, x, y, z):
    """Store three vectors in rows of n numbers."""
    put_eight(array, at, x)
    put_eight(array, at + n, y)
    put_eight(array, at + 2 * n, z)


@reduction_within
def three(array, at, n):
    """The vectors that `put_three` stores."""
    return eight(array, at), eight(array, at + n), eight(array, at + 2 * n)


@reduction
def attitudes(elements, k, t, r, g):
    """Matrices as of `SeriesAttitudes`, into r (S 9 N,), and tangents, into g (S 9 N,) or ().

    elements (S, 3): precession, nutation, phase; k (S, 4, 4, 2) as of `coefficients`; t (N,), where
    `LANES` divides N.
    """
    n = t.size
    for each in range(elements.shape[0]):
        precession, nutation, phase = elements[each, 0], elements[each, 1], elements[each, 2]
        a1, a2, a3 = k[each, 0, 1, 0], k[each, 0, 2, 0], k[each, 0, 3, 0]
        d1, d2, d3 = k[each, 1, 1, 0], k[each, 1, 2, 0], k[each, 1, 3, 0]
        b0, b1, b2, b3 = k[each, 2, 0, 0], k[each, 2, 1, 0], k[each, 2, 2, 0], k[each, 2, 3, 0]
        e0, e1, e2, e3 = k[each, 3, 0, 0], k[each, 3, 1, 0], k[each, 3, 2, 0], k[each, 3, 3, 0]
        x1, x2, x3 = k[each, 0, 1, 1], k[each, 0, 2, 1], k[each, 0, 3, 1]
        y1, y2, y3 = k[each, 1, 1, 1], k[each, 1, 2, 1], k[each, 1, 3, 1]
        u0, u1, u2, u3 = k[each, 2, 0, 1], k[each, 2, 1, 1], k[each, 2, 2, 1], k[each, 2, 3, 1]
        v0, v1, v2, v3 = k[each, 3, 0, 1], k[each, 3, 1, 1], k[each, 3, 2, 1], k[each, 3, 3, 1]
        first = each * 9 * n
        for i in range(0, n, 8):
            at = eight(t, i)
            c1, s1 = cosine_and_sine(nutation * at + phase)
            cy, sy = cosine_and_sine(precession * at)
            c2, s2, c3, s3, c4, s4, c5, s5, c6, s6, c7, s7 = _multiples(c1, s1)
            ax = 1.0 + a1 * c2 + a2 * c4 + a3 * c6
            ay = d1 * s2 + d2 * s4 + d3 * s6
            bx = e0 * s1 + e1 * s3 + e2 * s5 + e3 * s7
            by = 0.0 - (b0 * c1 + b1 * c3 + b2 * c5 + b3 * c7)
            over = 1.0 / (ax * ax + ay * ay + bx * bx + by * by)
            size = root(over)
            w, z = (ax * cy - ay * sy) * size, (ax * sy + ay * cy) * size
            p, q = (bx * cy - by * sy) * size, (bx * sy + by * cy) * size
            here = first + i
            x, y, z = _rows(w, p, q, z)
            put_three(r, here, n, *x)
            put_three(r, here + 3 * n, n, *y)
            put_three(r, here + 6 * n, n, *z)
            if g.size == 0:
                continue
            # twice the angle of the precession
            cy, sy = cy * cy - sy * sy, 2.0 * cy * sy
            over = over + over
            px = 0.0 - (2.0 * a1 * s2 + 4.0 * a2 * s4 + 6.0 * a3 * s6)
            py = 2.0 * d1 * c2 + 4.0 * d2 * c4 + 6.0 * d3 * c6
            qx = e0 * c1 + 3.0 * e1 * c3 + 5.0 * e2 * c5 + 7.0 * e3 * c7
            qy = b0 * s1 + 3.0 * b1 * s3 + 5.0 * b2 * s5 + 7.0 * b3 * s7
            turned = _turning(ax, ay, bx, by, px, py, qx, qy, cy, sy, over)
            put_three(g, here, n, *turned)
            # by ln rho
            px = 4.0 * a1 * c2 + 16.0 * a2 * c4 + 36.0 * a3 * c6
            py = 4.0 * d1 * s2 + 16.0 * d2 * s4 + 36.0 * d3 * s6
            qx = e0 * s1 + 9.0 * e1 * s3 + 25.0 * e2 * s5 + 49.0 * e3 * s7
            qy = 0.0 - (b0 * c1 + 9.0 * b1 * c3 + 25.0 * b2 * c5 + 49.0 * b3 * c7)
            turned = _turning(ax, ay, bx, by, px, py, qx, qy, cy, sy, over)
            put_three(g, here + 3 * n, n, *turned)
            # by X
            px = x1 * c2 + x2 * c4 + x3 * c6
            py = y1 * s2 + y2 * s4 + y3 * s6
            qx = v0 * s1 + v1 * s3 + v2 * s5 + v3 * s7
            qy = 0.0 - (u0 * c1 + u1 * c3 + u2 * c5 + u3 * c7)
            turned = _turning(ax, ay, bx, by, px, py, qx, qy, cy, sy, over)
            put_three(g, here + 6 * n, n, *turned)
