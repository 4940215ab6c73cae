"""Quaternions as arrays (..., 4), scalar first; rotation matrices and Euler angles.

A unit quaternion q rotates a vector v to v' = q v q*.  Attitudes in this package are body to
inertial: v holds components over the body axes, v' over the inertial axes.

>>> import numpy as np
>>> quarter_about_z = np.array([np.sqrt(0.5), 0.0, 0.0, np.sqrt(0.5)])
>>> rotate(quarter_about_z, [1.0, 2.0, 0.0]).round(12)
array([-2.,  1.,  0.])
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from attitude._support import pairs, validation
from attitude._support.arrays import components_first, components_last
from attitude.errors import AttitudeError

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import ArrayLike

    from attitude._support.annotations import FloatArray, Reals

__all__ = ["conjugate", "from_euler", "from_matrix", "matrix", "multiply", "rotate", "unit"]


# A matrix counts as a rounded rotation if the entries of R^T R - 1 are at most this.
_NOT_A_ROTATION = 1e-6
# So many vectors are turned at a time: intermediate results stay in the processor's cache.
_BLOCK = 8192
# Rounding leaves at most 6 units in the last place of |q|^2 - 1 after a division by the length.
_UNIT = 8.0 * np.finfo(float).eps


def multiply(p: Reals, q: Reals) -> FloatArray:
    """The products p q (..., 4) of quaternions (..., 4): the rotation q, then p.

    Leading axes broadcast.
    """
    p, q = validation.rows(p, "p", 4), validation.rows(q, "q", 4)
    try:
        return np.stack(product(_parts(p), _parts(q)), axis=-1)
    except ValueError:
        raise _without_common_shape("p", p, "q", q) from None


def product(p: Sequence[Any], q: Sequence[Any]) -> list[Any]:
    """The four components of the product p q of quaternions by component."""
    pw, px, py, pz = p
    qw, qx, qy, qz = q
    return [
        pw * qw - px * qx - py * qy - pz * qz,
        pw * qx + px * qw + py * qz - pz * qy,
        pw * qy - px * qz + py * qw + pz * qx,
        pw * qz + px * qy - py * qx + pz * qw,
    ]


def conjugate(q: Reals) -> FloatArray:
    """The inverses (..., 4) of unit quaternions (..., 4)."""
    return validation.rows(q, "q", 4) * (1.0, -1.0, -1.0, -1.0)


def rotate(q: Reals, v: Reals) -> FloatArray:
    """The vectors q v q* (..., 3) of unit quaternions (..., 4) and vectors (..., 3).

    Leading axes broadcast.
    """
    q, v = validation.rows(q, "q", 4), validation.rows(v, "v", 3)
    try:
        shape = np.broadcast_shapes(q.shape[:-1], v.shape[:-1])
    except ValueError:
        raise _without_common_shape("q", q, "v", v) from None
    turned = np.empty((3, *shape))
    if len(shape) == 1 and shape[0] > _BLOCK:
        q, v = np.broadcast_to(q, (*shape, 4)), np.broadcast_to(v, (*shape, 3))
        for start in range(0, shape[0], _BLOCK):
            block = slice(start, start + _BLOCK)
            _turn(q[block], v[block], turned[:, block])
    else:
        _turn(q, v, turned)
    return components_last(turned)


def _turn(q, v, turned):
    """Fill `turned` (3, ...) with q v q*."""
    w, x, y, z = _parts(q)
    a, b, c = _parts(v)
    # v + 2 w (u x v) + 2 u x (u x v)
    d, e, f = 2.0 * (y * c - z * b), 2.0 * (z * a - x * c), 2.0 * (x * b - y * a)
    turned[0] = a + w * d + (y * f - z * e)
    turned[1] = b + w * e + (z * d - x * f)
    turned[2] = c + w * f + (x * e - y * d)


def matrix(q: Reals) -> FloatArray:
    """The rotation matrices (..., 3, 3) of unit quaternions (..., 4): v' = matrix @ v."""
    w, x, y, z = _parts(validation.rows(q, "q", 4))
    out = np.empty((*w.shape, 3, 3))
    out[..., 0, 0] = w * w + x * x - y * y - z * z
    out[..., 1, 1] = w * w - x * x + y * y - z * z
    out[..., 2, 2] = w * w - x * x - y * y + z * z
    out[..., 0, 1], out[..., 1, 0] = 2.0 * (x * y - w * z), 2.0 * (x * y + w * z)
    out[..., 0, 2], out[..., 2, 0] = 2.0 * (x * z + w * y), 2.0 * (x * z - w * y)
    out[..., 1, 2], out[..., 2, 1] = 2.0 * (y * z - w * x), 2.0 * (y * z + w * x)
    return out


def unit(wxyz: Reals, name: str = "wxyz", *, tolerance: float | None = None) -> FloatArray:
    """Quaternions (..., 4) of length one, and of the same sign.

    Rows whose length is 1 within 16 units in the last place are returned bit for bit.

    Parameters
    ----------
    tolerance : float, optional
        Largest difference of the length from 1; any nonzero length by default.

    Raises
    ------
    AttitudeError
        For rows that are zero or not finite, or whose length is off by more than the tolerance.
    """
    rows = validation.rows(wxyz, name, 4)
    largest = _refuse_no_attitude(rows, name)
    scaled = rows / largest
    length = np.sqrt(np.sum(scaled * scaled, axis=-1, keepdims=True))
    with np.errstate(over="ignore"):
        off = np.abs(length * largest - 1.0)
    if tolerance is not None and np.any(off > tolerance):
        raise AttitudeError(
            f"{name} holds a quaternion whose length is off 1 by {np.max(off):.3g}; up to "
            f"{tolerance:g} is accepted as rounding. Give unit quaternions."
        )
    return np.where(off <= 16.0 * np.finfo(float).eps, rows, scaled / length)


def unit_in_pairs(wxyz: Reals) -> FloatArray:
    """One quaternion (4,) of any length as a unit quaternion (4, 2), exact to 1e-31.

    One of unit length within rounding is kept bit for bit, as files are read back; low parts zero.
    """
    components = validation.real(wxyz, "wxyz", shape=(4,))
    pairs = np.zeros((4, 2))
    w, x, y, z = q = components.tolist()
    largest = max(abs(w), abs(x), abs(y), abs(z))
    if largest == 0.0:
        _refuse_no_attitude(components, "wxyz")
    # a large one overflows when squared
    if largest < 2.0 and abs(w * w + x * x + y * y + z * z - 1.0) <= _UNIT:
        pairs[:, 0] = components
        return pairs
    exponent = math.frexp(largest)[1]
    # by a power of two, which is exact
    pairs[:] = _divided_by_length([math.ldexp(x, -exponent) for x in q])
    return pairs


def all_unit_in_pairs(wxyz: FloatArray) -> tuple[FloatArray, FloatArray | None]:
    """`unit_in_pairs` of (N, 4): first doubles, NaN: no attitude; second ones, None if all zero."""
    high, low = wxyz, None
    with np.errstate(all="ignore"):
        for begin in range(0, len(wxyz), _BLOCK):
            w, x, y, z = wxyz[begin : begin + _BLOCK].T
            not_unit = np.flatnonzero(~(abs(w * w + x * x + y * y + z * z - 1.0) <= _UNIT))
            if len(not_unit):
                if low is None:
                    high, low = wxyz.copy(), np.zeros(wxyz.shape)
                rows = wxyz[not_unit + begin]
                exponent = np.frexp(np.abs(rows).max(axis=1, keepdims=True))[1]
                parts = _divided_by_length(list(np.ldexp(rows, -exponent).T))
                high[not_unit + begin] = np.transpose([pair[0] for pair in parts])
                low[not_unit + begin] = np.transpose([pair[1] for pair in parts])
    return high, low


def _divided_by_length(q: list[Any]) -> list[Any]:
    """The components of a quaternion, floats or arrays, over its length, in pairs."""
    square: tuple[Any, Any] = (0.0, 0.0)
    for x in q:
        square = pairs.add(square, *pairs.product(x, x))
    length = pairs.root(square)
    return [pairs.quotient((x, 0.0), length) for x in q]


def _refuse_no_attitude(wxyz: FloatArray, name: str) -> FloatArray:
    """Largest absolute components (..., 1) of quaternions (..., 4), all finite and above zero."""
    largest: FloatArray = np.abs(wxyz).max(axis=-1, keepdims=True)
    bad = ~((largest > 0.0) & (largest < np.inf))
    if bad.any():
        listed = ", ".join(f"{x:.9g}" for x in wxyz[bad[..., 0]].reshape(-1, 4)[0])
        raise AttitudeError(
            f"{name} holds ({listed}), which is no attitude; give a quaternion (w, x, y, z) of "
            "four finite numbers that are not all zero."
        )
    return largest


def from_matrix(matrix: Reals, name: str = "matrix") -> FloatArray:
    """Attitudes (..., 4), w >= 0, of rotation matrices (..., 3, 3): v_inertial = matrix @ v_body.

    Raises
    ------
    AttitudeError
        For reflections and for matrices whose R^T R - 1 has an entry above 1e-6.
    """
    from scipy.spatial.transform import Rotation

    matrices = validation.real(matrix, name, shape=(..., 3, 3))
    refuse_other_matrices(matrices, name)
    flat: FloatArray = Rotation.from_matrix(matrices.reshape(-1, 3, 3)).as_quat(
        canonical=True, scalar_first=True
    )
    return flat.reshape(*matrices.shape[:-2], 4)


def refuse_other_matrices(matrices: FloatArray, name: str) -> None:
    """Refuse matrices (..., 3, 3) that are not rotations within 1e-6."""
    off = np.max(np.abs(np.swapaxes(matrices, -1, -2) @ matrices - np.eye(3)), initial=0.0)
    if off > _NOT_A_ROTATION:
        raise AttitudeError(
            f"{name} is not a rotation: {name}^T {name} differs from the unit matrix by {off:.2g} "
            f"(up to {_NOT_A_ROTATION:.0e} is accepted as rounding). Give orthonormal columns."
        )
    if np.any(np.linalg.det(matrices) < 0.0):
        raise AttitudeError(
            f"{name} is a reflection (determinant -1); give a right-handed matrix, for example by "
            "reversing one axis."
        )


def from_euler(sequence: str | int, angles: Reals) -> FloatArray:
    """Attitudes (..., 4) of one to three turns about body axes, one after the other.

    Parameters
    ----------
    sequence : str
        "ZXZ" or "313": body to inertial is Rz(a) Rx(b) Rz(c), as in CCSDS (EULER_ROT_SEQ) and STK.
        Small letters turn about the inertial axes, in that order.
    angles : (..., 1 to 3) array_like
        rad, or a Quantity, in the order of the turns.
    """
    letters = _axes(sequence)
    if not 1 <= len(letters) <= 2:
        letters = known_sequence(sequence)
    angles = validation.real(angles, "angles", shape=(..., len(letters)), unit="rad")
    out = np.zeros((*angles.shape[:-1], 4))
    out[..., 0] = 1.0
    for k, letter in enumerate(letters):
        turn = about("XYZ".index(letter.upper()), angles[..., k])
        out = multiply(out, turn) if letter.isupper() else multiply(turn, out)
    return out


def about(axis: int, angle: ArrayLike) -> FloatArray:
    """Rotations (..., 4) by angles (...) in rad about the coordinate axis 0, 1 or 2."""
    half = 0.5 * np.asarray(angle)
    turn = np.zeros((*half.shape, 4))
    turn[..., 0], turn[..., 1 + axis] = np.cos(half), np.sin(half)
    return turn


def known_sequence(sequence: str | int) -> str:
    """An Euler sequence in scipy's letters; see `from_euler`."""
    is_number = isinstance(sequence, int) and not isinstance(sequence, bool)
    letters = _axes(str(sequence) if is_number else sequence)
    if len(letters) == 3 and letters[0] != letters[1] != letters[2]:
        return letters
    raise AttitudeError(
        f"sequence is {repr(sequence)[:42]}; give three axes, no two neighbours equal, like "
        '"ZXZ" or "313".'
    )


def _axes(sequence):
    """Text of axes in scipy's letters, of one case; "" for anything else."""
    if not isinstance(sequence, str):
        return ""
    letters = sequence.translate(str.maketrans("123", "XYZ"))
    is_known = set(letters.upper()) <= set("XYZ") and letters in (letters.upper(), letters.lower())
    return letters if is_known else ""


def _parts(array):
    """The components along the last axis, one array each."""
    return tuple(components_first(array))


def _without_common_shape(
    name: str, array: FloatArray, other: str, another: FloatArray
) -> AttitudeError:
    return AttitudeError(
        f"{name} has shape {array.shape} and {other} shape {another.shape}; give one, or the same "
        "number of each."
    )
