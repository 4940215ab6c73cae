"""The attitude types of CCSDS messages: meaning of their columns, decoding and encoding.

A rotation "from A to B" turns the axes of A into those of B; its quaternion (Q1, Q2, Q3, QC) has
the components of the rotation that takes the components of vectors over B to those over A.  If A is
inertial and B the body, this is body to inertial; if A is the body, it is the inverse.
Euler angles turn A into B about its axes in the order of EULER_ROT_SEQ, so that "ZXZ" with angles
a, b, c is body to inertial = Rz(a) Rx(b) Rz(c).

Rates are those of the body relative to the external axes, except in version 2 messages whose
REF_FRAME_A is the body: there the standard defines them as those of B relative to A, the negative.
The components of ANGVEL are over the axes that ANGVEL_FRAME names.  The three numbers of RATE, in
version 1, are such components over the axes of RATE_FRAME, or the derivatives of the Euler angles
of EULER_ROT_SEQ: tools differ, and `Convention.rates_of_angles` says which.

The spin types give the pole of body z and the angle about it, as `representations.from_pole`, of
the body relative to the external axes, for either direction.  SPIN has no rate across body z:
records whose pole moves have no angular velocity.  With nutation, angular velocity = nutation rate
about the axis of the cone + SPIN_ANGLE_VEL about body z; by NUTATION_PHASE p and NUTATION n that
axis is (sin n cos p, -sin n sin p, cos n) in the body.

Source: version 2, CCSDS 504.0-B-2 (2024): table 4-4 (columns), 4.2.4.6 (units), annex F (F2
quaternions, F3 Euler angles, F4 angular velocity, F5 spin).  Version 1, CCSDS 504.0-B-1 (2008):
4.2.5; where it leaves a choice, version 2 or Orekit's reading is followed.
"""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from attitude._textfiles.lines import cut
from attitude.errors import AttitudeError, AttitudeWarning
from attitude.frames import quaternion as frames_quaternion
from attitude.frames import representations as forms

if TYPE_CHECKING:
    from attitude._support.annotations import FloatArray


# ---- What the rates of version 1 of attitude messages are: body rates or derivatives of angles
# CCSDS 504.0-B-1 calls the columns of QUATERNION/RATE and EULER_ANGLE/RATE, and X_RATE, Y_RATE and
# Z_RATE of an APM, body rates over the axes of RATE_FRAME in some sentences; its figure 3-6 has
# Y_RATE, X_RATE, Y_RATE under EULER_ROT_SEQ 212, which can only be derivatives of the angles.
# Files of the MMS mission have body rates; Orekit reads and writes derivatives of the angles of
# EULER_ROT_SEQ.  Repeated letters are read as derivatives; for all others the user decides, and the
# default is body rates.  On QUATERNION/DERIVATIVE and Q1_DOT everybody agrees.

MEANINGS: tuple[str, ...] = ("body", "euler")


def known_rates(rates: str | None) -> str | None:
    """The meaning itself; AttitudeError for an unknown one."""
    if rates is not None and (not isinstance(rates, str) or rates not in MEANINGS):
        raise AttitudeError(
            f'rates is {rates!r}; give "body" for components of the angular velocity, or "euler" '
            "for derivatives of the Euler angles."
        )
    return rates


def warn(path: str, what: str) -> None:
    """Warn that `what` in a file was read as body rates although it may be something else."""
    warnings.warn(
        f"{path}: the rates of {what} of version 1 are read as components of the angular velocity; "
        'some tools, such as Orekit, write derivatives of the Euler angles: give rates="body" or '
        'rates="euler" (on the command line --rates).',
        AttitudeWarning,
        stacklevel=2,
    )


Q: tuple[str, ...] = ("Q1", "Q2", "Q3", "QC")
Q_DOT: tuple[str, ...] = ("Q1_DOT", "Q2_DOT", "Q3_DOT", "QC_DOT")
ANGVEL: tuple[str, ...] = ("ANGVEL_X", "ANGVEL_Y", "ANGVEL_Z")
ANGLES: tuple[str, ...] = ("ANGLE_1", "ANGLE_2", "ANGLE_3")
ANGLES_DOT: tuple[str, ...] = ("ANGLE_1_DOT", "ANGLE_2_DOT", "ANGLE_3_DOT")
SPIN: tuple[str, ...] = ("SPIN_ALPHA", "SPIN_DELTA", "SPIN_ANGLE", "SPIN_ANGLE_VEL")

# The columns of each type, under its name in version 2.
COLUMNS: dict[str, tuple[str, ...]] = {
    "QUATERNION": Q,
    "QUATERNION/DERIVATIVE": (*Q, *Q_DOT),
    "QUATERNION/ANGVEL": (*Q, *ANGVEL),
    "EULER_ANGLE": ANGLES,
    "EULER_ANGLE/DERIVATIVE": (*ANGLES, *ANGLES_DOT),
    "EULER_ANGLE/ANGVEL": (*ANGLES, *ANGVEL),
    "SPIN": SPIN,
    "SPIN/NUTATION": (*SPIN, "NUTATION", "NUTATION_PER", "NUTATION_PHASE"),
    "SPIN/NUTATION_MOM": (*SPIN, "MOMENTUM_ALPHA", "MOMENTUM_DELTA", "NUTATION_VEL"),
}
# Name in version 2 -> name in version 1, and the inverse.
IN_VERSION_1: dict[str, str] = {
    kind: kind.replace("/ANGVEL", "/RATE")
    for kind in COLUMNS
    if kind not in ("EULER_ANGLE/DERIVATIVE", "SPIN/NUTATION_MOM")
}
OUT_OF_VERSION_1: dict[str, str] = {old: new for new, old in IN_VERSION_1.items()}


@dataclass(frozen=True)
class Convention:
    """Directions, axes and units of the columns of an attitude type."""

    to_body: bool = True  # whether the rotation goes from the external axes to the body
    rates_over_body: bool = True  # whether ANGVEL is over the body axes
    rates_follow: bool = True  # whether rates are those of B relative to A, not of the body
    scalar_first: bool = False  # whether QC stands before Q1, Q2, Q3
    sequence: str | None = None  # axes of the Euler angles, such as "ZXZ"
    in_radians: bool = False  # whether ANGVEL is in rad/s, as in CSV, or deg/s
    rates_of_angles: bool = False  # whether ANGVEL are derivatives of the Euler angles


def known_type(name: str, version: str) -> str:
    """The name in version 2 of an attitude type of either version."""
    kind = "_".join(name.upper().split())
    kind = OUT_OF_VERSION_1.get(kind, kind)
    if kind not in COLUMNS:
        raise AttitudeError(
            f"ATTITUDE_TYPE is {cut(name)}; it must be one of "
            f"{', '.join(IN_VERSION_1.values() if version.startswith('1') else COLUMNS)}."
        )
    return kind


def has_rates(kind: str) -> bool:
    """Whether an attitude type has columns of rates."""
    return kind not in ("QUATERNION", "EULER_ANGLE")


def decoded(
    kind: str, rows: FloatArray, convention: Convention
) -> tuple[FloatArray, FloatArray | None]:
    """Attitudes wxyz (N, 4) and angular velocities (N, 3) from the rows (N, columns) of a file."""
    families = {"QUATERNION": _of_quaternions, "EULER_ANGLE": _of_angles, "SPIN": _of_spin}
    wxyz, rates = families[kind.partition("/")[0]](kind, rows, convention)
    if kind.endswith("/ANGVEL") and convention.rates_of_angles:
        rates = of_euler_derivatives(wxyz, np.radians(rows[:, -3:]), convention)
    elif kind.endswith("/ANGVEL"):
        rates = rows[:, -3:] if convention.in_radians else np.radians(rows[:, -3:])
        if not convention.rates_over_body:
            unit = frames_quaternion.unit(wxyz)
            rates = frames_quaternion.rotate(frames_quaternion.conjugate(unit), rates)
        if convention.rates_follow and not convention.to_body:
            rates = -rates
    return wxyz, rates


def encoded(
    kind: str,
    wxyz: FloatArray,
    rates: FloatArray | None,
    acceleration: FloatArray | None,
    convention: Convention,
) -> FloatArray:
    """Rows (N, columns) in deg, deg/s and s from wxyz (N, 4), rates and acceleration (N, 3)."""
    family = kind.partition("/")[0]
    if family == "SPIN":
        return _spin_columns(kind, wxyz, rates, acceleration)
    of_file = wxyz if convention.to_body else frames_quaternion.conjugate(wxyz)
    if family == "QUATERNION":
        columns = [_ordered(of_file, convention)]
    else:
        assert convention.sequence is not None
        angles = forms.to_euler(convention.sequence, of_file)
        columns = [np.degrees(angles)]
    if kind == "EULER_ANGLE/DERIVATIVE" or (
        kind.endswith("/ANGVEL") and convention.rates_of_angles
    ):
        assert rates is not None and convention.sequence is not None
        angles = forms.to_euler(convention.sequence, of_file)
        over = rates if convention.to_body else -frames_quaternion.rotate(wxyz, rates)
        columns.append(np.degrees(forms.euler_rates(convention.sequence, angles, over)))
    elif kind.endswith("/ANGVEL"):
        assert rates is not None
        over = rates if convention.rates_over_body else frames_quaternion.rotate(wxyz, rates)
        is_reverse = convention.rates_follow and not convention.to_body
        columns.append(np.degrees(-over if is_reverse else over))
    elif kind == "QUATERNION/DERIVATIVE":
        assert rates is not None
        change = forms.quaternion_rate(wxyz, rates)
        change = change if convention.to_body else frames_quaternion.conjugate(change)
        columns.append(_ordered(change, convention))
    return np.concatenate(columns, axis=1)


def _ordered(wxyz, convention):
    return wxyz if convention.scalar_first else forms.to_xyzw(wxyz)


def _of_quaternions(kind, rows, convention):
    parts = [rows[:, :4], rows[:, 4:8]] if kind == "QUATERNION/DERIVATIVE" else [rows[:, :4]]
    if not convention.scalar_first:
        parts = [np.roll(columns, 1, axis=1) for columns in parts]
    if not convention.to_body:
        parts = [frames_quaternion.conjugate(columns) for columns in parts]
    if len(parts) == 1:
        return parts[0], None
    square = np.sum(parts[0] * parts[0], axis=1, keepdims=True)
    return parts[0], forms.angular_velocity_from_quaternion_rate(*parts) / square


def of_euler_derivatives(
    wxyz: FloatArray, change: FloatArray, convention: Convention
) -> FloatArray:
    """Rates (N, 3), rad/s over the body, from wxyz (N, 4) and the change (N, 3) of angles."""
    assert convention.sequence is not None
    of_file = frames_quaternion.unit(wxyz)
    of_file = of_file if convention.to_body else frames_quaternion.conjugate(of_file)
    return _of_changes(of_file, forms.to_euler(convention.sequence, of_file), change, convention)


def _of_changes(of_file, angles, change, convention):
    """Rates (N, 3) over the body, from the rotation of the file, its angles and their change."""
    rates = forms.angular_velocity_from_euler_rates(convention.sequence, angles, change)
    return rates if convention.to_body else -frames_quaternion.rotate(of_file, rates)


def rates_by_axis(letters: str, sequence: str) -> list[int] | None:
    """For each angle of a sequence the place of its rate; None if the letters are not its axes.

    >>> rates_by_axis("YXY", "YXY"), rates_by_axis("XYZ", "ZYX"), rates_by_axis("XYZ", "ZXZ")
    ([0, 1, 2], [2, 1, 0], None)
    """
    if sorted(letters) != sorted(sequence):
        return None
    places: list[int] = []
    for axis in sequence:
        places.append(next(k for k, x in enumerate(letters) if x == axis and k not in places))
    return places


def _of_angles(kind, rows, convention):
    angles = np.radians(rows[:, :3])
    wxyz = frames_quaternion.from_euler(convention.sequence, angles)
    rates = None
    if kind == "EULER_ANGLE/DERIVATIVE":
        rates = _of_changes(wxyz, angles, np.radians(rows[:, 3:6]), convention)
    return (wxyz if convention.to_body else frames_quaternion.conjugate(wxyz)), rates


def _of_spin(kind, rows, convention):
    alpha, delta, angle, spin = np.radians(rows[:, :4]).T
    wxyz = forms.from_pole(alpha, delta, angle)
    rates = np.zeros((len(rows), 3))
    rates[:, 2] = spin
    if kind == "SPIN":
        moved = len(rows) and np.any(rows[:, :2] != rows[0, :2])
        return wxyz, None if moved else rates
    if kind == "SPIN/NUTATION":
        nutation, phase = np.radians(rows[:, 4]), np.radians(rows[:, 6])
        if np.any(rows[:, 5] == 0.0):
            raise AttitudeError("NUTATION_PER is 0; it must be a period other than zero.")
        turn = 2.0 * np.pi / rows[:, 5]
        across = np.sin(nutation)
        axis = np.stack([across * np.cos(phase), -across * np.sin(phase), np.cos(nutation)], 1)
    else:
        alpha, delta = np.radians(rows[:, 4:6]).T
        across = np.cos(delta)
        outside = np.stack([across * np.cos(alpha), across * np.sin(alpha), np.sin(delta)], 1)
        turn = np.radians(rows[:, 6])
        axis = frames_quaternion.rotate(frames_quaternion.conjugate(wxyz), outside)
    return wxyz, rates + turn[:, None] * axis


def _spin_columns(kind, wxyz, rates, acceleration):
    columns = [*forms.to_pole(wxyz)]
    if kind == "SPIN":
        return np.degrees(np.stack([*columns, rates[:, 2]], axis=1))
    axis, nutation, turn = _cone(rates, acceleration)
    columns.append(rates[:, 2] - turn * axis[:, 2])
    if kind == "SPIN/NUTATION":
        if np.any(turn == 0.0):
            raise AttitudeError(
                "at some epoch body z does not move and has no period of nutation; write SPIN, or "
                "SPIN/NUTATION_MOM."
            )
        phase = np.arctan2(-axis[:, 1], axis[:, 0])
        angles = np.degrees(np.stack([*columns, nutation, nutation, phase], axis=1))
        angles[:, 5] = 2.0 * np.pi / turn
        return angles
    outside = frames_quaternion.rotate(wxyz, axis)
    alpha = np.arctan2(outside[:, 1], outside[:, 0])
    delta = np.arctan2(outside[:, 2], np.hypot(outside[:, 0], outside[:, 1]))
    return np.degrees(np.stack([*columns, alpha, delta, turn], axis=1))


def _cone(rates, acceleration):
    """Axis (N, 3) in the body, half angle and rate of the cone along which body z moves.

    The cone osculates: it has the velocity and the acceleration of body z at that epoch.  Its axis
    is the angular momentum for symmetric bodies only.
    """
    z = np.array([0.0, 0.0, 1.0])
    velocity = np.cross(rates, z)
    bend = np.cross(acceleration, z) + np.cross(rates, velocity)
    speed = np.linalg.norm(velocity, axis=1)
    still = speed == 0.0
    across = np.cross(z, velocity / np.where(still, 1.0, speed)[:, None])
    half = np.where(still, 0.0, np.arctan2(speed**2, np.sum(bend * across, axis=1)))
    turn = np.where(still, 0.0, speed / np.where(still, 1.0, np.sin(half)))
    return np.cos(half)[:, None] * z + np.sin(half)[:, None] * across, half, turn
