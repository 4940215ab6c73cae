"""Last stage: from the internal axes of the solution to the given body axes.

q(t) = q(0) b q_int(0)* q_int(t) b*, where b rotates internal to given body axes: one constant
quaternion on each side of q_int(t), multiplied out to one matrix that the kernels apply.
"""

from __future__ import annotations

import math
from itertools import product as combinations
from typing import TYPE_CHECKING

import numpy as np

from attitude.compilation.decorators import sized_entry_point, subroutine
from attitude.compilation.instructions import larger
from attitude.solution import codes
from attitude.solution.series import four

if TYPE_CHECKING:
    from attitude.annotations import FloatArray


def _signed_permutations() -> tuple[FloatArray, FloatArray]:
    """Proper signed permutations as matrices and unit quaternions, [first, second, sign 1, sign 3].

    Column k of the matrix is the principal axis that becomes internal axis k: `first`, `second`
    and the third one; index 1 for a negative sign.  The sign of the second axis follows.
    """
    matrices, quaternions = np.zeros((3, 3, 2, 2, 3, 3)), np.zeros((3, 3, 2, 2, 4))
    for first, second in ((0, 1), (1, 2), (2, 0), (1, 0), (2, 1), (0, 2)):
        third = 3 - first - second
        for minus1, minus3 in combinations((0, 1), repeat=2):
            matrix = np.zeros((3, 3))
            matrix[first, 0], matrix[third, 2] = 1 - 2 * minus1, 1 - 2 * minus3
            matrix[:, 1] = np.cross(matrix[:, 2], matrix[:, 0])
            # 4 q q^T has entries that are sums of those of the matrix; any non-zero column is q.
            (xx, xy, xz), (yx, yy, yz), (zx, zy, zz) = matrix
            outer = np.array(
                [
                    [1 + xx + yy + zz, zy - yz, xz - zx, yx - xy],
                    [zy - yz, 1 + xx - yy - zz, xy + yx, xz + zx],
                    [xz - zx, xy + yx, 1 - xx + yy - zz, yz + zy],
                    [yx - xy, xz + zx, yz + zy, 1 - xx - yy + zz],
                ]
            )
            column = outer[:, np.argmax(np.diag(outer))]
            matrices[first, second, minus1, minus3] = matrix
            quaternions[first, second, minus1, minus3] = column / np.sqrt(column @ column)
    return matrices, quaternions


_MATRICES, _QUATERNIONS = _signed_permutations()
_UNIT = np.eye(4)


@sized_entry_point
def attach_all(wxyz, wxyz_low, principal, constants):
    """Fill the frame and the axes of those of B motions that tumble.

    Given
        wxyz       (B, 4) body to inertial at the epoch, of any length
        wxyz_low   (1 or B, 4) second doubles of wxyz, then of unit length; or zeros
        principal  (1 or B, 4) principal axes to given body axes
    Filled
        constants  (B,) frame and axes (solution.record)
    """
    for b in range(len(constants)):
        c = constants[b]
        if c.fault == codes.FINE and c.form != codes.UNIFORM:
            given = four(principal[b if len(principal) > 1 else 0])
            low = four(wxyz_low[b if len(wxyz_low) > 1 else 0])
            body = _axes(given, c)
            _attach(four(wxyz[b]), low, body, unit(four(c.internal)), c.frame)


@subroutine
def unit(q):
    """A quaternion (4) of any nonzero length as a unit quaternion."""
    size = larger(larger(abs(q[0]), abs(q[1])), larger(abs(q[2]), abs(q[3])))
    w, x, y, z = q[0] / size, q[1] / size, q[2] / size, q[3] / size
    size = 1.0 / math.sqrt(w * w + x * x + y * y + z * z)
    return w * size, x * size, y * size, z * size


@subroutine
def product(p, q):
    """The quaternion product p q."""
    return (
        p[0] * q[0] - p[1] * q[1] - p[2] * q[2] - p[3] * q[3],
        p[0] * q[1] + p[1] * q[0] + p[2] * q[3] - p[3] * q[2],
        p[0] * q[2] - p[1] * q[3] + p[2] * q[0] + p[3] * q[1],
        p[0] * q[3] + p[1] * q[2] - p[2] * q[1] + p[3] * q[0],
    )


@subroutine
def at_start(wxyz, low):
    """The unit quaternion of the epoch: wxyz of any length, or its first doubles if it has others.

    wxyz + low is of unit length unless `low` is zero.
    """
    return wxyz if any_of(low) else unit(wxyz)


@subroutine
def any_of(q):
    """Whether a quaternion (4) has a component that is not zero."""
    return q[0] != 0.0 or q[1] != 0.0 or q[2] != 0.0 or q[3] != 0.0


@subroutine
def plus(p, q):
    """The sum of two quaternions."""
    return p[0] + q[0], p[1] + q[1], p[2] + q[2], p[3] + q[3]


@subroutine
def turned_by(q, v):
    """The vector q v q* (3) of a unit quaternion; v itself, bit for bit, when q is 1."""
    a, b, c = v
    d = 2.0 * (q[2] * c - q[3] * b)
    e = 2.0 * (q[3] * a - q[1] * c)
    f = 2.0 * (q[1] * b - q[2] * a)
    return (
        a + q[0] * d + (q[2] * f - q[3] * e),
        b + q[0] * e + (q[3] * d - q[1] * f),
        c + q[0] * f + (q[1] * e - q[2] * d),
    )


@subroutine
def _axes(principal, c):
    """The quaternion from internal to given body axes; fill its matrix, which the rates need."""
    first, second, minus1, minus3 = four(c.jacobi)
    internal, axes = _MATRICES[first, second, minus1, minus3], c.axes
    for k in range(3):
        column = turned_by(principal, (internal[0, k], internal[1, k], internal[2, k]))
        for i in range(3):
            axes[i, k] = column[i]
    return product(principal, four(_QUATERNIONS[first, second, minus1, minus3]))


@subroutine
def _attach(wxyz, low, body, internal, frame):
    """Fill the matrix of q_int(t) -> q(t), column by column."""
    back = (internal[0], -internal[1], -internal[2], -internal[3])
    left = product(product(at_start(wxyz, low), body), back)
    if any_of(low):
        left = plus(left, product(product(low, body), back))
    right = (body[0], -body[1], -body[2], -body[3])
    for k in range(4):
        column = product(product(left, four(_UNIT[k])), right)
        for j in range(4):
            frame[j, k] = column[j]
