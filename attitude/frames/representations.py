"""Attitudes in other forms: matrices, Euler angles, rotation vectors, MRP, pole and spin angle.

Every function takes arrays with any leading axes.  `wxyz` is always a unit quaternion (..., 4) from
body to inertial axes, scalar first; angles are in rad, angular velocities in rad/s over the body
axes.  A conversion and its inverse return the attitude to a few units in the last place, also at
tiny angles, at half turns and at gimbal lock (where only the sum or the difference of two angles is
defined).  AttitudeError is raised for arrays of other shapes, unknown sequences of axes, and angles
or matrices that are not finite.

>>> import numpy as np
>>> wxyz = from_euler("ZXZ", [0.1, 0.2, 0.3])
>>> to_euler("ZXZ", wxyz).round(12)
array([0.1, 0.2, 0.3])
>>> to_dcm(from_euler("Z", [np.pi / 2])).round(12)       # inertial x seen in the body: -y
array([[ 0.,  1.,  0.],
       [-1.,  0.,  0.],
       [ 0.,  0.,  1.]])
"""

from __future__ import annotations

from functools import cached_property
from itertools import permutations
from typing import TYPE_CHECKING

import numpy as np

from attitude._support import validation
from attitude._support.arrays import Immutable, frozen
from attitude.errors import AttitudeError
from attitude.frames import quaternion
from attitude.frames.quaternion import from_euler, from_matrix, unit

if TYPE_CHECKING:
    from numpy.typing import ArrayLike
    from scipy.spatial.transform import Rotation

    from attitude._support.annotations import FloatArray, Reals


__all__ = [
    "EULER_SEQUENCES",
    "angular_velocity_from_euler_rates",
    "angular_velocity_from_quaternion_rate",
    "body_to_inertial_rates",
    "continuous",
    "euler_rates",
    "from_axis_angle",
    "from_dcm",
    "from_euler",
    "from_matrix",
    "from_mrp",
    "from_pole",
    "from_rotation",
    "from_rotation_vector",
    "from_xyzw",
    "inertial_to_body_rates",
    "quaternion_rate",
    "to_axis_angle",
    "to_dcm",
    "to_euler",
    "to_matrix",
    "to_mrp",
    "to_pole",
    "to_rotation",
    "to_rotation_vector",
    "to_xyzw",
    "unit",
]


EULER_SEQUENCES: tuple[str, ...] = (
    *(a + b + a for a, b in permutations("XYZ", 2)),
    *("".join(axes) for axes in permutations("XYZ")),
)


# ---- Quaternions


def from_xyzw(xyzw: Reals) -> FloatArray:
    """Quaternions (..., 4), scalar first, of scalar last: CCSDS Q1 Q2 Q3 QC, scipy, STK, ROS."""
    return np.roll(validation.rows(xyzw, "xyzw", 4), 1, axis=-1)


def to_xyzw(wxyz: Reals) -> FloatArray:
    """Quaternions (..., 4), scalar last, of scalar first.

    >>> to_xyzw([1.0, 0.0, 0.0, 0.0])
    array([0., 0., 0., 1.])
    """
    return np.roll(validation.rows(wxyz, "wxyz", 4), -1, axis=-1)


def continuous(wxyz: Reals) -> FloatArray:
    """The same attitudes (..., N, 4), signed as a motion of less than half a turn from row to row.

    The first row keeps its sign; the quaternions of neighbours are at most 90 deg apart.

    >>> continuous([[1.0, 0.0, 0.0, 0.0], [-1.0, 0.0, 0.0, 0.0]])[:, 0]
    array([1., 1.])
    """
    rows = validation.rows(wxyz, "wxyz", 4)
    if rows.ndim < 2 or rows.shape[-2] < 2:
        return rows.copy()
    steps = np.sum(rows[..., 1:, :] * rows[..., :-1, :], axis=-1)
    signs = np.cumprod(np.where(steps < 0.0, -1.0, 1.0), axis=-1)
    out = rows.copy()
    out[..., 1:, :] *= signs[..., None]
    return out


# ---- Matrices


def from_dcm(dcm: Reals) -> FloatArray:
    """Attitudes (..., 4), w >= 0, of direction cosine matrices: v_body = dcm @ v_inertial."""
    return from_matrix(np.swapaxes(validation.real(dcm, "dcm", shape=(..., 3, 3)), -1, -2), "dcm")


def to_matrix(wxyz: Reals) -> FloatArray:
    """Rotation matrices (..., 3, 3): v_inertial = matrix @ v_body."""
    return quaternion.matrix(validation.rows(wxyz, "wxyz", 4))


def to_dcm(wxyz: Reals) -> FloatArray:
    """Direction cosine matrices (..., 3, 3): v_body = dcm @ v_inertial, `to_matrix` transposed."""
    return np.swapaxes(to_matrix(wxyz), -1, -2)


# ---- Euler angles


def to_euler(sequence: str | int, wxyz: Reals) -> FloatArray:
    """The three angles (..., 3) of `from_euler` in rad, of any of the twelve sequences.

    The middle angle is in [0, pi] for sequences like ZXZ and in [-pi/2, pi/2] for those like ZYX,
    the others are in (-pi, pi].  At gimbal lock the third angle depends on rounding; the three
    together still give the attitude to rounding.

    Source: Bernardes and Viollet (2022), PLoS ONE 17, e0276302, which needs no threshold.
    """
    letters = quaternion.known_sequence(sequence)
    if letters.islower():
        return to_euler(letters[::-1].upper(), wxyz)[..., ::-1]
    w, *parts = np.moveaxis(validation.rows(wxyz, "wxyz", 4), -1, 0)
    third, second, first = ("XYZ".index(letter) for letter in letters)
    symmetric = first == third
    if symmetric:
        third = 3 - first - second
    sign = (first - second) * (second - third) * (third - first) // 2
    if symmetric:
        a, b, c, d = w, parts[first], parts[second], parts[third] * sign
    else:
        a, b = w - parts[second], parts[first] + parts[third] * sign
        c, d = parts[second] + w, parts[third] * sign - parts[first]
    middle = 2.0 * np.arctan2(np.hypot(c, d), np.hypot(a, b))
    half_sum = np.where((a == 0.0) & (b == 0.0), 0.0, np.arctan2(b, a))
    half_difference = np.where((c == 0.0) & (d == 0.0), 0.0, np.arctan2(d, c))
    last, leading = half_sum - half_difference, half_sum + half_difference
    if not symmetric:
        leading, middle = leading * sign, middle - 0.5 * np.pi
    return np.stack([_wrapped(leading), middle, _wrapped(last)], axis=-1)


def euler_rates(sequence: str | int, angles: Reals, angular_velocity: Reals) -> FloatArray:
    """Rates (..., 3) of Euler angles, rad/s, of angular velocities (..., 3) over the body axes.

    Raises
    ------
    AttitudeError
        At gimbal lock, where the rates of the outer angles do not exist.
    """
    axes = _turning_axes(sequence, angles)
    omega = validation.rows(angular_velocity, "angular_velocity", 3, unit="rad/s")
    validation.together(angles=axes[..., 0, 0], angular_velocity=omega[..., 0])
    volume = np.linalg.det(axes)  # the sine or cosine of the middle angle
    if np.any(np.abs(volume) < 1e-12):
        raise AttitudeError(
            f"the Euler angles {sequence} are at gimbal lock (within 1e-12 rad), where their rates "
            "do not exist; use another sequence, or angular velocities instead of angle rates."
        )
    return np.linalg.solve(axes, omega[..., None])[..., 0]


def angular_velocity_from_euler_rates(
    sequence: str | int, angles: Reals, rates: Reals
) -> FloatArray:
    """Angular velocity (..., 3), rad/s in body axes, of the rates (..., 3) of Euler angles."""
    axes = _turning_axes(sequence, angles)
    rates = validation.rows(rates, "rates", 3, unit="rad/s")
    validation.together(angles=axes[..., 0, 0], rates=rates[..., 0])
    return (axes @ rates[..., None])[..., 0]


def _turning_axes(sequence, angles):
    """Columns (..., 3, 3): the axes of the three turns, over the body axes."""
    letters = quaternion.known_sequence(sequence)
    angles = validation.real(angles, "angles", shape=(..., 3), unit="rad")
    if letters.islower():
        return _turning_axes(letters[::-1].upper(), angles[..., ::-1])[..., ::-1]
    columns = []
    for k, letter in enumerate(letters):
        axis = np.broadcast_to(np.eye(3)["XYZ".index(letter)], (*angles.shape[:-1], 3))
        if k < 2:
            following = from_euler(letters[k + 1 :], angles[..., k + 1 :])
            axis = quaternion.rotate(quaternion.conjugate(following), axis)
        columns.append(axis)
    return np.stack(columns, axis=-1)


# ---- Rotation vectors, axis and angle, modified Rodrigues parameters


def from_rotation_vector(vector: Reals) -> FloatArray:
    """Attitudes (..., 4) of rotation vectors (..., 3): axis times angle, rad, body to inertial."""
    vector = validation.real(vector, "vector", shape=(..., 3), unit="rad")
    with np.errstate(over="ignore"):
        angle = np.sqrt(np.sum(vector * vector, axis=-1))
    if not validation.is_finite(angle):
        raise AttitudeError("vector is longer than 1e154 rad; give rotations of fewer turns.")
    half_sinc = 0.5 * np.sinc(angle / (2.0 * np.pi))
    return np.concatenate([np.cos(0.5 * angle)[..., None], half_sinc[..., None] * vector], -1)


def to_rotation_vector(wxyz: Reals) -> FloatArray:
    """Rotation vectors (..., 3) in rad, at most pi long; small ones to full relative accuracy."""
    axis, angle = to_axis_angle(wxyz)
    return axis * angle[..., None]


def from_axis_angle(axis: Reals, angle: Reals) -> FloatArray:
    """Attitudes (..., 4) of turns by angles (...) in rad about axes (..., 3) of nonzero length."""
    axis = validation.real(axis, "axis", shape=(..., 3))
    angle = validation.real(angle, "angle", unit="rad")
    largest = np.max(np.abs(axis), axis=-1, keepdims=True)
    if np.any(largest == 0.0):
        raise AttitudeError("axis is zero; give a vector of any other length.")
    scaled: FloatArray = axis / largest
    direction = scaled / np.sqrt(np.sum(scaled * scaled, axis=-1, keepdims=True))
    half = 0.5 * validation.together(angle=angle, axis=axis[..., 0])[0][..., None]
    return np.concatenate([np.cos(half), np.sin(half) * direction], axis=-1)


def to_axis_angle(wxyz: Reals) -> tuple[FloatArray, FloatArray]:
    """Unit axes (..., 3) and angles (...) in [0, pi] rad; the axis is x where the angle is 0."""
    wxyz = validation.rows(wxyz, "wxyz", 4)
    turned = np.where(wxyz[..., :1] < 0.0, -wxyz, wxyz)
    vector = turned[..., 1:]
    largest = np.max(np.abs(vector), axis=-1, keepdims=True)
    none = largest == 0.0
    scaled = vector / np.where(none, 1.0, largest)  # squares of tiny angles would underflow
    length = np.sqrt(np.sum(scaled * scaled, axis=-1, keepdims=True))
    axis = np.where(none, (1.0, 0.0, 0.0), scaled / np.where(none, 1.0, length))
    return axis, 2.0 * np.arctan2((length * largest)[..., 0], turned[..., 0])


def from_mrp(mrp: Reals) -> FloatArray:
    """Attitudes (..., 4) of modified Rodrigues parameters (..., 3): axis times tan(angle / 4)."""
    p = validation.real(mrp, "mrp", shape=(..., 3))
    # a power of two, which changes no digits, keeps the squares of long ones finite
    exponent = np.frexp(np.max(np.abs(p), axis=-1, keepdims=True))[1]
    scale = np.ldexp(1.0, -np.maximum(exponent, 0))
    p, one = p * scale, scale * scale
    square = np.sum(p * p, axis=-1, keepdims=True)
    return np.concatenate([one - square, 2.0 * scale * p], axis=-1) / (one + square)


def to_mrp(wxyz: Reals) -> FloatArray:
    """Modified Rodrigues parameters (..., 3), at most 1 long (the shadow set is longer)."""
    wxyz = validation.rows(wxyz, "wxyz", 4)
    turned = np.where(wxyz[..., :1] < 0.0, -wxyz, wxyz)
    return turned[..., 1:] / (1.0 + turned[..., :1])


# ---- Pole and spin angle


def from_pole(right_ascension: Reals, declination: Reals, spin_angle: Reals) -> FloatArray:
    """Attitudes (..., 4) of a pole and the angle of the prime meridian, in rad, as the IAU defines.

    Body z points to the pole; body x is spin_angle east of the node at right ascension + 90 deg:
    Rz(ra + 90 deg) Rx(90 deg - dec) Rz(W).  Archinal et al. (2018), Celest. Mech. 130, 22; the
    same as SPIN_ALPHA, SPIN_DELTA and SPIN_ANGLE of CCSDS.

    >>> from_pole(0.0, np.pi / 2, -np.pi / 2).round(12)
    array([1., 0., 0., 0.])
    """
    node, tilt, spin = validation.together(
        right_ascension=validation.real(right_ascension, "right_ascension", unit="rad"),
        declination=validation.real(declination, "declination", unit="rad"),
        spin_angle=validation.real(spin_angle, "spin_angle", unit="rad"),
    )
    return from_euler("ZXZ", np.stack([node + 0.5 * np.pi, 0.5 * np.pi - tilt, spin], axis=-1))


def to_pole(wxyz: Reals) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Right ascension in [0, 2 pi), declination, spin angle in [0, 2 pi): arrays (...), rad."""
    node, tilt, spin = np.moveaxis(to_euler("ZXZ", wxyz), -1, 0)
    return turned_positive(node - 0.5 * np.pi), 0.5 * np.pi - tilt, turned_positive(spin)


# ---- Rates


def quaternion_rate(wxyz: Reals, angular_velocity: Reals) -> FloatArray:
    """Rate of change (..., 4) in 1/s of attitudes: q' = q (0, w) / 2, w over the body axes."""
    omega = validation.rows(angular_velocity, "angular_velocity", 3, unit="rad/s")
    pure = np.concatenate([np.zeros((*omega.shape[:-1], 1)), omega], axis=-1)
    return 0.5 * quaternion.multiply(validation.rows(wxyz, "wxyz", 4), pure)


def angular_velocity_from_quaternion_rate(wxyz: ArrayLike, rate: Reals) -> FloatArray:
    """Angular velocity (..., 3), rad/s in body axes, of the rate of change (..., 4) in 1/s."""
    rate = validation.rows(rate, "rate", 4, unit="1/s")
    return 2.0 * quaternion.multiply(quaternion.conjugate(wxyz), rate)[..., 1:]


def body_to_inertial_rates(wxyz: Reals, angular_velocity: Reals) -> FloatArray:
    """Angular velocities (..., 3) over the inertial axes of those over the body axes, rad/s."""
    omega = validation.rows(angular_velocity, "angular_velocity", 3, unit="rad/s")
    return quaternion.rotate(validation.rows(wxyz, "wxyz", 4), omega)


def inertial_to_body_rates(wxyz: Reals, angular_velocity: Reals) -> FloatArray:
    """Angular velocities (..., 3) over the body axes of those over the inertial axes, rad/s."""
    omega = validation.rows(angular_velocity, "angular_velocity", 3, unit="rad/s")
    return quaternion.rotate(quaternion.conjugate(validation.rows(wxyz, "wxyz", 4)), omega)


# scipy --------------------------------------------------------------------------------------------


def from_rotation(rotation: Rotation) -> FloatArray:
    """Attitudes (4,) or (N, 4) of a scipy Rotation from body to inertial axes."""
    if not hasattr(rotation, "as_quat"):
        raise AttitudeError(f"rotation is {rotation!r}; give a scipy Rotation (body to inertial).")
    return from_xyzw(rotation.as_quat())


def to_rotation(wxyz: Reals) -> Rotation:
    """A scipy Rotation, body to inertial, of attitudes (4,) or (N, 4)."""
    from scipy.spatial.transform import Rotation

    return Rotation.from_quat(to_xyzw(unit(wxyz)))


def _wrapped(angle):
    """Angles within two turns brought into (-pi, pi]; those inside of it are not changed."""
    angle = np.where(angle > np.pi, angle - 2.0 * np.pi, angle)
    return np.where(angle <= -np.pi, angle + 2.0 * np.pi, angle)


def turned_positive(angle: FloatArray) -> FloatArray:
    """Angles within one turn of [0, 2 pi) brought into it."""
    angle = np.where(angle < 0.0, angle + 2.0 * np.pi, angle)
    return np.where(angle >= 2.0 * np.pi, 0.0, angle)


# ---- Objects that hold attitudes


class Attitudes(Immutable):
    """Base of histories: attitudes (S, 4) of a body at epochs of shape S, in other forms."""

    seconds: FloatArray
    wxyz: FloatArray

    @property
    def shape(self) -> tuple[int, ...]:
        """The shape S of the epochs; () for one scalar epoch."""
        return self.seconds.shape

    def __len__(self) -> int:
        if not self.shape:
            raise TypeError("a history of one scalar epoch has no length")
        return self.shape[0]

    @property
    def xyzw(self) -> FloatArray:
        """(S, 4) unit quaternions, as `wxyz`, scalar last."""
        return frozen(np.moveaxis(np.moveaxis(self.wxyz, -1, 0)[[1, 2, 3, 0]], 0, -1))

    @cached_property
    def matrix(self) -> FloatArray:
        """(S, 3, 3) rotation matrices, body to ICRF (or frame): v_icrf = matrix @ v_body."""
        return frozen(quaternion.matrix(self.wxyz))

    @property
    def dcm(self) -> FloatArray:
        """(S, 3, 3) ICRF (or frame) to body, the paper's attitude matrix A: `matrix` transposed."""
        return np.swapaxes(self.matrix, -1, -2)

    def as_rotation(self) -> Rotation:
        """The attitudes as a scipy Rotation, as `wxyz`, flattened; AttitudeError for NaN."""
        self._refuse_nan("a scipy Rotation")
        return to_rotation(self.wxyz.reshape(-1, 4) if self.shape else self.wxyz)

    def euler(self, sequence: str) -> FloatArray:
        """Euler angles (S, 3) in rad: "ZXZ" or "313" is matrix = Rz(a) Rx(b) Rz(c).

        Raises
        ------
        AttitudeError
            For a sequence without three axes of which neighbours differ, and NaN attitudes.
        """
        self._refuse_nan("Euler angles")
        return to_euler(sequence, self.wxyz)

    def _refuse_nan(self, what: str) -> None:
        if np.any(np.isnan(self.wxyz)):
            raise AttitudeError(
                f"some attitudes are NaN, which {what} cannot represent; leave them out, for "
                "example with history[~np.isnan(history.wxyz[..., 0])]."
            )
