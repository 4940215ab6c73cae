"""Quaternions as arrays (..., 4), scalar first; rotation matrices and Euler angles.

A unit quaternion q rotates a vector v to v' = q v q*.  Attitudes in this package are body to
inertial: v holds components over the body axes, v' over the inertial axes.

>>> import numpy as np
>>> quarter_about_z = np.array([np.sqrt(0.5), 0.0, 0.0, np.sqrt(0.5)])
>>> rotate(quarter_about_z, [1.0, 2.0, 0.0]).round(12)
array([-2.,  1.,  0.])
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from attitude import validation
from attitude.errors import AttitudeError

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from attitude.annotations import FloatArray, Reals

# A matrix counts as a rounded rotation if the entries of R^T R - 1 are at most this.
_NOT_A_ROTATION = 1e-6
# So many vectors are turned at a time: intermediate results stay in the processor's cache.
_BLOCK = 8192
# Rounding leaves at most 6 eps of |q|^2 - 1 after q was divided by its length.
_UNIT = 8.0 * np.finfo(float).eps


def multiply(p: ArrayLike, q: ArrayLike) -> FloatArray:
    """The products p q (..., 4) of quaternions (..., 4): the rotation q, then p.

    Leading axes broadcast.
    """
    pw, px, py, pz = _parts(p)
    qw, qx, qy, qz = _parts(q)
    return np.stack(
        [
            pw * qw - px * qx - py * qy - pz * qz,
            pw * qx + px * qw + py * qz - pz * qy,
            pw * qy - px * qz + py * qw + pz * qx,
            pw * qz + px * qy - py * qx + pz * qw,
        ],
        axis=-1,
    )


def conjugate(q: ArrayLike) -> FloatArray:
    """The inverses (..., 4) of unit quaternions (..., 4)."""
    return np.asarray(q) * (1.0, -1.0, -1.0, -1.0)


def rotate(q: ArrayLike, v: ArrayLike) -> FloatArray:
    """The vectors q v q* (..., 3) of unit quaternions (..., 4) and vectors (..., 3).

    Leading axes broadcast.
    """
    q, v = np.asarray(q, dtype=np.float64), np.asarray(v, dtype=np.float64)
    shape = np.broadcast_shapes(q.shape[:-1], v.shape[:-1])
    turned = np.empty((3, *shape))
    if len(shape) == 1 and shape[0] > _BLOCK:
        q, v = np.broadcast_to(q, (*shape, 4)), np.broadcast_to(v, (*shape, 3))
        for start in range(0, shape[0], _BLOCK):
            part = slice(start, start + _BLOCK)
            _turn(q[part], v[part], turned[:, part])
    else:
        _turn(q, v, turned)
    return turned.T if turned.ndim <= 2 else np.moveaxis(turned, 0, -1)


def _turn(q, v, turned):
    """Fill `turned` (3, ...) with q v q*."""
    w, x, y, z = _parts(q)
    a, b, c = _parts(v)
    # v + 2 w (u x v) + 2 u x (u x v)
    d, e, f = 2.0 * (y * c - z * b), 2.0 * (z * a - x * c), 2.0 * (x * b - y * a)
    turned[0] = a + w * d + (y * f - z * e)
    turned[1] = b + w * e + (z * d - x * f)
    turned[2] = c + w * f + (x * e - y * d)


def matrix(q: ArrayLike) -> FloatArray:
    """The rotation matrices (..., 3, 3) of unit quaternions (..., 4): v' = matrix @ v."""
    w, x, y, z = _parts(q)
    out = np.empty((*w.shape, 3, 3))
    out[..., 0, 0] = w * w + x * x - y * y - z * z
    out[..., 1, 1] = w * w - x * x + y * y - z * z
    out[..., 2, 2] = w * w - x * x - y * y + z * z
    out[..., 0, 1], out[..., 1, 0] = 2.0 * (x * y - w * z), 2.0 * (x * y + w * z)
    out[..., 0, 2], out[..., 2, 0] = 2.0 * (x * z + w * y), 2.0 * (x * z - w * y)
    out[..., 1, 2], out[..., 2, 1] = 2.0 * (y * z - w * x), 2.0 * (y * z + w * x)
    return out


def unit(wxyz: Reals, name: str = "wxyz") -> FloatArray:
    """One quaternion (4,) of any length as a unit quaternion of the same sign.

    A quaternion of unit length within rounding is returned bit for bit, so that a quaternion
    written to a file is read back unchanged.

    Raises
    ------
    AttitudeError
        For another shape, numbers that are not finite, or zero length.
    """
    q = validation.real(wxyz, name, shape=(4,))
    largest = np.max(np.abs(q))
    if largest == 0.0:
        raise AttitudeError(f"{name} is zero; give a quaternion (w, x, y, z) of any other length.")
    if largest < 2.0 and abs(q @ q - 1.0) <= _UNIT:  # a large one overflows when squared
        return q
    q /= largest
    return q / np.sqrt(q @ q)


def from_matrix(value: Reals, name: str = "matrix") -> FloatArray:
    """The unit quaternion (4,), w >= 0, of a rotation matrix (3, 3).

    Raises
    ------
    AttitudeError
        For another shape, a reflection, or a matrix further than 1e-6 from a rotation.
    """
    from scipy.spatial.transform import Rotation

    given = validation.real(value, name, shape=(3, 3))
    refuse_other_matrices(given, name)
    found: FloatArray = Rotation.from_matrix(given).as_quat(canonical=True, scalar_first=True)
    return found


def refuse_other_matrices(given: FloatArray, name: str) -> None:
    """Refuse matrices (..., 3, 3) that are not rotations within 1e-6.

    Raises
    ------
    AttitudeError
        For reflections, and if an entry of R^T R - 1 exceeds 1e-6.
    """
    off = np.max(np.abs(np.swapaxes(given, -1, -2) @ given - np.eye(3)), initial=0.0)
    if off > _NOT_A_ROTATION:
        raise AttitudeError(
            f"{name} is not a rotation: {name}^T {name} differs from the unit matrix by {off:.2g} "
            f"(up to {_NOT_A_ROTATION:.0e} is accepted as rounding). Give orthonormal columns."
        )
    if np.any(np.linalg.det(given) < 0.0):
        raise AttitudeError(
            f"{name} is a reflection (determinant -1); give a right-handed matrix, for example by "
            "reversing one axis."
        )


def from_euler(sequence: str | int, angles: Reals) -> FloatArray:
    """The unit quaternion (4,) of three rotations about body axes, one after the other.

    Parameters
    ----------
    sequence : str
        Axes in capital letters or numbers, as in "ZXZ" or "313": R = Rz(a) Rx(b) Rz(c).
        Small letters turn about the axes of the frame instead, in that order (scipy's convention).
    angles : (3,) array_like
        rad, or a Quantity.

    Raises
    ------
    AttitudeError
        For another sequence, or angles that are not three finite numbers.
    """
    from scipy.spatial.transform import Rotation

    sequence = known_sequence(sequence)
    angles = validation.real(angles, "angles", shape=(3,), unit="rad")
    found: FloatArray = Rotation.from_euler(sequence, angles).as_quat(scalar_first=True)
    return found


def known_sequence(sequence: str | int) -> str:
    """An Euler sequence in scipy's letters; see `from_euler`.

    Raises
    ------
    AttitudeError
        For anything but three axes of which no two neighbours are equal.
    """
    given = sequence
    if isinstance(sequence, int) and not isinstance(sequence, bool):
        sequence = str(sequence)
    if isinstance(sequence, str):
        letters = sequence.translate(str.maketrans("123", "XYZ"))
        known = len(letters) == 3 and set(letters.upper()) <= set("XYZ")
        known = known and letters in (letters.upper(), letters.lower())
        if known and letters[0] != letters[1] != letters[2]:
            return letters
    raise AttitudeError(
        f'sequence is {given!r}; give three axes, no two neighbours equal, like "ZXZ" or "313".'
    )


def _parts(array):
    """The components along the last axis, one array each."""
    array = np.asarray(array, dtype=np.float64)
    return tuple(array.T if array.ndim <= 2 else np.moveaxis(array, -1, 0))  # .T is much faster
