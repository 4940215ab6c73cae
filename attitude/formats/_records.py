"""Records of attitudes: the types of CCSDS messages, rows to an AttitudeTable, a history to rows.

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
from typing import TYPE_CHECKING, Any

import numpy as np

from attitude._support import pairs
from attitude._textfiles.lines import NoNumber, cut, numbers
from attitude._textfiles.messages import MessageRows
from attitude.epochs import _ccsds as ccsds_epochs
from attitude.epochs._instants import Instant
from attitude.errors import AttitudeError, AttitudeWarning
from attitude.frames import quaternion
from attitude.frames import representations as forms
from attitude.motions._table import AttitudeTable, refuse_speed

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Sequence

    from attitude._support.annotations import FloatArray, IntArray
    from attitude._textfiles.lines import Fault
    from attitude.motions._axes import Axes
    from attitude.motions._history import AttitudeHistory
    from attitude.paths._path import Path


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
            unit = quaternion.unit(wxyz)
            rates = quaternion.rotate(quaternion.conjugate(unit), rates)
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
    of_file = wxyz if convention.to_body else quaternion.conjugate(wxyz)
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
        over = rates if convention.to_body else -quaternion.rotate(wxyz, rates)
        columns.append(np.degrees(forms.euler_rates(convention.sequence, angles, over)))
    elif kind.endswith("/ANGVEL"):
        assert rates is not None
        over = rates if convention.rates_over_body else quaternion.rotate(wxyz, rates)
        is_reverse = convention.rates_follow and not convention.to_body
        columns.append(np.degrees(-over if is_reverse else over))
    elif kind == "QUATERNION/DERIVATIVE":
        assert rates is not None
        change = forms.quaternion_rate(wxyz, rates)
        change = change if convention.to_body else quaternion.conjugate(change)
        columns.append(_ordered(change, convention))
    return np.concatenate(columns, axis=1)


def _ordered(wxyz, convention):
    return wxyz if convention.scalar_first else forms.to_xyzw(wxyz)


def _of_quaternions(kind, rows, convention):
    parts = [rows[:, :4], rows[:, 4:8]] if kind == "QUATERNION/DERIVATIVE" else [rows[:, :4]]
    if not convention.scalar_first:
        parts = [np.roll(columns, 1, axis=1) for columns in parts]
    if not convention.to_body:
        parts = [quaternion.conjugate(columns) for columns in parts]
    if len(parts) == 1:
        return parts[0], None
    square = np.sum(parts[0] * parts[0], axis=1, keepdims=True)
    return parts[0], forms.angular_velocity_from_quaternion_rate(*parts) / square


def of_euler_derivatives(
    wxyz: FloatArray, change: FloatArray, convention: Convention
) -> FloatArray:
    """Rates (N, 3), rad/s over the body, from wxyz (N, 4) and the change (N, 3) of angles."""
    assert convention.sequence is not None
    of_file = quaternion.unit(wxyz)
    of_file = of_file if convention.to_body else quaternion.conjugate(of_file)
    return _of_changes(of_file, forms.to_euler(convention.sequence, of_file), change, convention)


def _of_changes(of_file, angles, change, convention):
    """Rates (N, 3) over the body, from the rotation of the file, its angles and their change."""
    rates = forms.angular_velocity_from_euler_rates(convention.sequence, angles, change)
    return rates if convention.to_body else -quaternion.rotate(of_file, rates)


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
    wxyz = quaternion.from_euler(convention.sequence, angles)
    rates = None
    if kind == "EULER_ANGLE/DERIVATIVE":
        rates = _of_changes(wxyz, angles, np.radians(rows[:, 3:6]), convention)
    return (wxyz if convention.to_body else quaternion.conjugate(wxyz)), rates


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
        axis = quaternion.rotate(quaternion.conjugate(wxyz), outside)
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
    outside = quaternion.rotate(wxyz, axis)
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


# ---- Rows of a file to an AttitudeTable, and a history to rows: axes, directions, units, length

# Largest deviation from 1 of the length of a quaternion: some files print few digits.
TOLERANCE: float = 1e-3
# Seconds since J2000 beyond which no epoch is read: 30 million years.
LATEST: float = 1e15
# Rounding of START_TIME and STOP_TIME, s: files write them with fewer digits than epochs.
_ROUNDED = 1e-3


def known_tolerance(tolerance: float) -> float:
    """The tolerance of the length of quaternions itself; AttitudeError if it is not 0 or more."""
    number = isinstance(tolerance, (int, float)) and not isinstance(tolerance, bool)
    if not (number and tolerance >= 0.0):
        raise AttitudeError(
            f"tolerance is {tolerance!r}; give the largest deviation from 1 of the length of a "
            "quaternion, 0 or more."
        )
    return tolerance


class Rows(MessageRows):
    """The records of one segment while they are read, with epochs in a scale in lower case."""

    def __init__(self, scale: str, fault: Fault, names: Sequence[str], lead: int = 1):
        super().__init__(fault, names, lead)
        self.scale: str = scale
        self.count: int = 0
        # Epochs hi and lo, values and lines of some rows each.
        self._parts: list[tuple[FloatArray, FloatArray, FloatArray, IntArray]] = []

    def add(
        self, leads: Sequence[Sequence[bytes]], values: FloatArray, lines: Sequence[int]
    ) -> None:
        """Add N records, whose epochs stand before the numbers; values are (N, names)."""
        try:
            hi, lo = self._parsed(*leads)
        except ccsds_epochs.BadEpoch as err:
            shown = b" ".join(tokens[err.index] for tokens in leads)[:38].decode("ascii", "replace")
            raise self.fault(
                f"the epoch {shown!r} cannot be read: {err.reason}.", lines[err.index]
            ) from err
        self.add_times(hi, lo, values, lines)

    def _parsed(self, tokens, of_day=None):
        """TDB seconds since J2000, hi and lo, of epochs; or of days and their seconds."""
        if of_day is None:
            return ccsds_epochs.parsed(tokens, self.scale)
        return ccsds_epochs.parsed_days(tokens, of_day, self.scale)

    def seconds_of(self, tokens: Sequence[bytes], lines: Sequence[int]) -> FloatArray:
        """Times that are numbers, (N,); AttitudeError for others."""
        try:
            return numbers(tokens, 1, [0])[:, 0]
        except NoNumber as err:
            raise self.fault(f"{err.shown} is no number.", lines[err.line]) from err

    def add_times(
        self, hi: FloatArray, lo: FloatArray, values: FloatArray, lines: Sequence[int]
    ) -> None:
        """Add N records whose epochs are TDB seconds since J2000, hi + lo."""
        finite = np.isfinite(values).all(axis=1) & (np.abs(hi) < LATEST)
        if not np.all(finite):
            k = int(np.argmin(finite))
            raise self.fault("it holds a number that is not finite or too large.", lines[k])
        last = self._parts[-1] if self._parts else (hi[:0], lo[:0])
        last_hi, last_lo = last[0][-1:], last[1][-1:]
        steps = np.diff(np.append(last_hi, hi)) + np.diff(np.append(last_lo, lo))
        if np.any(steps <= 0.0):
            k = int(np.argmax(steps <= 0.0))
            what = "is that of the record before" if steps[k] == 0.0 else "goes backwards"
            raise self.fault(
                f"the epoch {what}; records must follow each other in time.",
                lines[k + (not self._parts)],
            )
        if len(hi):
            self._parts.append((hi, lo, values, np.asarray(lines)))
            self.count += len(hi)

    def refuse_outside(self, start: Instant | None, stop: Instant | None) -> None:
        """AttitudeError for a record before START_TIME or after STOP_TIME by more than 1 ms."""
        for hi, lo, _, lines in self._parts:
            for end, sign, what in ((start, 1.0, "before START"), (stop, -1.0, "after STOP")):
                if end is None:
                    continue
                inside = sign * ((hi - end.seconds) + (lo - end.low))
                if np.any(inside < -_ROUNDED):
                    k = int(np.argmax(inside < -_ROUNDED))
                    raise self.fault(
                        f"the record is {-inside[k]:.6g} s {what}_TIME of the meta data.",
                        int(lines[k]),
                    )

    def joined(self) -> tuple[Instant, FloatArray, FloatArray, FloatArray, IntArray]:
        """First epoch, TDB seconds since it, hi and lo (N,), columns (N, width), lines (N,)."""
        if not self._parts:
            raise self.fault("the file has no attitudes.", None)
        hi, lo, values, lines = map(np.concatenate, zip(*self._parts, strict=True))
        epoch = Instant(hi[0], lo[0])
        return epoch, *pairs.add((hi, lo), -epoch.seconds, -epoch.low), values, lines

    def table(
        self,
        kind: str,
        convention: Convention,
        axes: Axes,
        *,
        tolerance: float = TOLERANCE,
        orbit: Path | None = None,
        **settings: Any,
    ) -> AttitudeTable:
        """The AttitudeTable of the records, relative to ICRF."""
        epoch, seconds, low, values, lines = self.joined()
        if kind.startswith("QUATERNION"):
            refuse_length(values[:, :4], lines, tolerance, self.fault)
        wxyz, rates = in_icrf(kind, values, convention, axes, (epoch, seconds, low, orbit))
        return AttitudeTable(epoch, seconds, wxyz, low=low, angular_velocity=rates, **settings)


def in_icrf(
    kind: str,
    rows: FloatArray,
    convention: Convention,
    axes: Axes,
    where: tuple[Instant, FloatArray, FloatArray, Path | None],
) -> tuple[FloatArray, FloatArray | None]:
    """wxyz (N, 4) and rates (N, 3) relative to ICRF from rows (N, columns) in some axes.

    where: what axes turn with: epoch, seconds since it, hi and lo (N,), path of the body.
    """
    with np.errstate(over="ignore", invalid="ignore"):  # refuse_speed refuses overflow
        wxyz, rates = decoded(kind, rows, convention)
    wxyz = quaternion.unit(wxyz)
    if axes.kind in ("icrf", "gcrf"):
        return wxyz, rates
    refuse_speed(rates)
    wxyz = quaternion.multiply(axes.to_icrf(*where), wxyz)
    if rates is not None:
        turning = axes.angular_velocity(*where)
        if turning is not None:
            rates = rates + quaternion.rotate(quaternion.conjugate(wxyz), turning)
    return forms.continuous(wxyz) if axes.turning else wxyz, rates


def columns_of(
    histories: Iterable[AttitudeHistory],
    kind: str,
    convention: Convention,
    axes: Axes,
    orbit: Path | None = None,
) -> Iterator[tuple[AttitudeHistory, FloatArray]]:
    """Pieces (N,) of one history, each with the columns (N, columns) of an attitude type.

    Units are deg, deg/s and s.  Quaternions in axes that turn are continuous in sign, also from
    piece to piece.
    """
    before = np.empty((0, 4))
    for history in histories:
        wxyz, rates, acceleration = _in_axes(history, kind, axes, orbit)
        if axes.turning:
            wxyz = forms.continuous(np.concatenate([before, wxyz]))[len(before) :]
            before = wxyz[-1:]
        yield history, encoded(kind, wxyz, rates, acceleration, convention)


def _in_axes(history, kind, axes, orbit):
    """wxyz, rates and acceleration of a history in some axes; the last two if the type has them."""
    wxyz, rates, acceleration = np.asarray(history.wxyz), None, None
    if has_rates(kind):
        rates = np.asarray(history.turning_rate)
    if kind in ("SPIN/NUTATION", "SPIN/NUTATION_MOM"):
        if axes.turning:
            raise AttitudeError(f"{kind} can be written in axes that do not turn, not {axes.name}.")
        acceleration = np.asarray(history.angular_acceleration)
    if axes.kind not in ("icrf", "gcrf"):
        where = history.epoch, history.seconds, history.low, orbit
        outer = axes.to_icrf(*where)
        if rates is not None:
            turning = axes.angular_velocity(*where)
            if turning is not None:
                rates = rates - quaternion.rotate(quaternion.conjugate(wxyz), turning)
        wxyz = quaternion.multiply(quaternion.conjugate(outer), wxyz)
    return wxyz, rates, acceleration


def refuse_length(
    quaternions: FloatArray, lines: Sequence[int] | IntArray, tolerance: float, fault: Fault
) -> None:
    """AttitudeError for quaternions (N, 4) whose length is off 1 by more than the tolerance."""
    with np.errstate(over="ignore"):
        off = np.abs(np.sqrt(np.sum(quaternions * quaternions, axis=1)) - 1.0)
    if np.any(off > tolerance):
        k = int(np.argmax(off > tolerance))
        raise fault(
            f"the length of the quaternion is off 1 by {off[k]:.3g}; up to {tolerance:g} is "
            "accepted as rounding (tolerance=).",
            int(lines[k]),
        )
