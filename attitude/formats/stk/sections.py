"""The sections of an STK attitude file: the columns of each, as attitudes.

Yaw, pitch and roll (YPR) stand in this order; they turn the body about the axes z, y and x of the
reference in the order of Sequence, so that the rotation is that of Euler angles in the inverse
order.  Sections of rates alone give the angles at the first record (InitialEulerAngle,
InitialYPRAngle); the angles follow from rates that are linear between records.  Vectors are the
direction of body x in J2000 (ECI) or Fixed (ECF), with body z as near to the center as it can be;
CoordinateAxes has no effect on them.

Source: help of STK 12, "Attitude File Format (*.a)" and "AddAttitude ECIYPR".
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from attitude import quaternion
from attitude import representations as forms
from attitude.axes import orbit_axes
from attitude.errors import AttitudeError

if TYPE_CHECKING:
    from collections.abc import Sequence

    from attitude.annotations import FloatArray
    from attitude.axes.axes import Axes
    from attitude.epochs import Instant
    from attitude.paths.path import Path


class Section(NamedTuple):
    """What stands in the rows of a section.

    Attributes
    ----------
    kind : str
        CCSDS attitude type of the attitudes.
    width : int
        Numbers behind the time.
    form : str
        "quaternion", "matrix", "euler", "ypr", "euler rates", "ypr rates" or "vector".
    scalar_first : bool
    initial : str or None
        Keyword of the angles at the first record.
    axes : str or None
        The axes, if CoordinateAxes has no effect.
    """

    kind: str
    width: int
    form: str
    scalar_first: bool = False
    initial: str | None = None
    axes: str | None = None


_BOTH = "EULER_ANGLE/DERIVATIVE"
SECTIONS: dict[str, Section] = {
    "AttitudeTimeQuaternions": Section("QUATERNION", 4, "quaternion"),
    "AttitudeTimeQuatScalarFirst": Section("QUATERNION", 4, "quaternion", scalar_first=True),
    "AttitudeTimeQuatAngVels": Section("QUATERNION/ANGVEL", 7, "quaternion"),
    "AttitudeTimeEulerAngles": Section("EULER_ANGLE", 3, "euler"),
    "AttitudeTimeYPRAngles": Section("EULER_ANGLE", 3, "ypr"),
    "AttitudeTimeEulerAnglesAndRates": Section(_BOTH, 6, "euler"),
    "AttitudeTimeYPRAnglesAndRates": Section(_BOTH, 6, "ypr"),
    "AttitudeTimeEulerAngleRates": Section(_BOTH, 3, "euler rates", initial="InitialEulerAngle"),
    "AttitudeTimeYPRAngleRates": Section(_BOTH, 3, "ypr rates", initial="InitialYPRAngle"),
    "AttitudeTimeDCM": Section("QUATERNION", 9, "matrix"),
    "AttitudeTimeDCMAngVels": Section("QUATERNION/ANGVEL", 12, "matrix"),
    "AttitudeTimeECIVector": Section("QUATERNION", 3, "vector", axes="EME2000"),
    "AttitudeTimeECFVector": Section("QUATERNION", 3, "vector", axes="ITRF"),
}
# Sections that are refused by name, each with the reason.
REFUSED: dict[str, str] = {
    "AttitudeTimeAngVels": "it holds angular velocities without attitudes, which fit_rates takes",
    "AttitudeTimeAzElAngles": "it holds the pointing of a sensor",
    "AttitudeTimeAzElAnglesAndRates": "it holds the pointing of a sensor",
}
# Sequences that the sections take if the file gives none.
USUAL: dict[str, str] = {"euler": "313", "ypr": "321"}


class Decoder:
    """Rows of a section to the columns of its CCSDS attitude type.

    Parameters
    ----------
    section : Section
    sequence : str or None
        The order of rotations, as of `quaternion.known_sequence`.
    initial : sequence of float or None
        The angles at the first record, deg, in the order of the section's columns.

    Attributes
    ----------
    section, sequence
        As given; the sequence is that of the Euler angles of `columns`.
    """

    def __init__(
        self, section: Section, sequence: str | None, initial: Sequence[float] | None = None
    ):
        self.section: Section = section
        self.sequence: str | None = sequence
        self._places = [0, 1, 2]
        if section.form.startswith("ypr"):
            assert sequence is not None
            if len(set(sequence.upper())) < 3:
                raise AttitudeError(
                    f"Sequence is {sequence}; yaw, pitch and roll turn about each axis once."
                )
            self.sequence = sequence[::-1].upper()
            self._places = ["ZYX".index(axis) for axis in self.sequence]
        self._angles = None if initial is None else np.array(initial, dtype=float)
        self._before: tuple[float, FloatArray] | None = None

    def columns(self, seconds: FloatArray, values: FloatArray) -> FloatArray:
        """The columns (N, columns) of the attitude type.

        Parameters
        ----------
        seconds : (N,) array
            Times of the records, s, from any epoch that is the same for all calls.
        values : (N, width) array
            Numbers of the section.

        Raises
        ------
        AttitudeError
            For matrices that are no rotations.
        """
        form = self.section.form
        if form == "matrix":
            wxyz = forms.from_dcm(values[:, :9].reshape(-1, 3, 3))
            return np.concatenate([forms.to_xyzw(wxyz), values[:, 9:]], axis=1)
        if form.endswith("rates"):
            values = np.concatenate([self._integrated(seconds, values), values], axis=1)
        if form.startswith(("ypr", "euler")):
            groups = [values[:, k : k + 3][:, self._places] for k in range(0, values.shape[1], 3)]
            return np.concatenate(groups, axis=1)
        return values

    def _integrated(self, seconds, rates):
        """The angles (N, 3): those of the first record, and the integral of linear rates."""
        angles = self._angles
        if self._before is not None:
            seconds = np.concatenate([[self._before[0]], seconds])
            rates = np.concatenate([self._before[1][None], rates])
        steps = np.diff(seconds)[:, None] * 0.5 * (rates[1:] + rates[:-1])
        found = angles + np.concatenate([np.zeros((1, 3)), np.cumsum(steps, axis=0)])
        self._angles, first = found[-1], self._before is not None
        self._before = seconds[-1], rates[-1]
        return found[1:] if first else found


def pointed(
    values: FloatArray, axes: Axes, epoch: Instant, hi: FloatArray, lo: FloatArray, orbit: Path
) -> FloatArray:
    """Quaternions (N, 4), scalar last, of body x along vectors and body z nearest to the center.

    Parameters
    ----------
    values : (N, 3) array
        Vectors over `axes`, of any length.
    axes : Axes
    epoch : Instant
    hi, lo : (N,) arrays
        hi + lo are TDB seconds since the epoch.
    orbit : Path
        Path of the body about its center.

    Raises
    ------
    AttitudeError
        For a vector of length zero or along the line to the center.
    """
    position = orbit_axes.state(hi, lo, orbit, "the direction to the center")[0]
    outer = axes.to_icrf(epoch, hi, lo, orbit)
    nadir = -quaternion.rotate(quaternion.conjugate(outer), position)
    x, down = (_unit(v) for v in (values, nadir))
    y = np.cross(down, x)
    length = np.linalg.norm(y, axis=1, keepdims=True)
    if not np.all(length > 1e-9):
        raise AttitudeError(
            "a vector is of length zero or points to or away from the center, which leaves the "
            "rotation about it undefined."
        )
    y = y / length
    return forms.to_xyzw(forms.from_matrix(np.stack([x, y, np.cross(x, y)], axis=-1)))


def _unit(v):
    with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
        v = v / np.max(np.abs(v), axis=1, keepdims=True)
        return v / np.linalg.norm(v, axis=1, keepdims=True)
