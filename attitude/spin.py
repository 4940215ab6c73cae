"""The state of rotation at an epoch: attitude and angular velocity."""

from dataclasses import dataclass

import numpy as np

from attitude import epochs, frames, gates, quaternion
from attitude.errors import AttitudeError
from attitude.frozen import Frozen, frozen


@dataclass(frozen=True, eq=False, repr=False)
class Spin(Frozen):
    """Attitude and angular velocity of a body at an epoch.

    Parameters
    ----------
    epoch : str, astropy Time, skyfield Time, datetime, datetime64
        Text is ISO 8601 in UTC, or with the name of a time scale behind it.
    wxyz : (4,) array_like
        Unit quaternion from body axes to `frame`, scalar first; of any length.
    angular_velocity : (3,) array_like
        Over the body axes: rad/s, or any Quantity, or text such as "14.5 deg/day".
    frame : str
        "icrf" (the same axes as GCRF and SPICE's J2000), "eme2000" or "ecliptic" (of J2000).

    Raises
    ------
    AttitudeError
        For a date that cannot be read, a quaternion of zero length, a shape, unit or frame that
        is not known.

    >>> Spin(epoch="2026-01-01", wxyz=(1, 0, 0, 0), angular_velocity=(1, 15, 1))
    <Spin at 2026-01-01T00:00:00 UTC: angular velocity 1, 15, 1 rad/s in body axes>
    """

    epoch: epochs.Instant
    wxyz: np.ndarray
    angular_velocity: np.ndarray
    frame: str = "icrf"

    def __post_init__(self):
        self._set("epoch", epochs.instant(self.epoch, "epoch"))
        self._set("frame", frames.known(self.frame))
        self._set("wxyz", frozen(quaternion.unit(self.wxyz)))
        rate = gates.real(self.angular_velocity, "angular_velocity", shape=(3,), unit="rad/s")
        self._set("angular_velocity", frozen(rate))

    @classmethod
    def from_rotation(cls, *, epoch, rotation, angular_velocity, frame="icrf"):
        """From one scipy Rotation that takes body vectors to the frame."""
        if not hasattr(rotation, "as_quat"):
            raise AttitudeError(
                f"rotation is {rotation!r}; give a scipy Rotation (body to frame), or use wxyz=."
            )
        wxyz = np.roll(rotation.as_quat(), 1, axis=-1)
        if wxyz.shape != (4,):
            raise AttitudeError(f"rotation holds {len(wxyz)} rotations; give one.")
        return cls(epoch, wxyz, angular_velocity, frame)

    @classmethod
    def from_matrix(cls, *, epoch, matrix, angular_velocity, frame="icrf"):
        """From a rotation matrix (3, 3) that takes body vectors to the frame.

        The paper's attitude matrix A, and what others call DCM, is its transpose.
        """
        return cls(epoch, quaternion.from_matrix(matrix), angular_velocity, frame)

    @classmethod
    def from_euler(cls, *, epoch, sequence, angles, angular_velocity, frame="icrf"):
        """From Euler angles: "313" or "ZXZ" is body to frame = Rz(a) Rx(b) Rz(c); rad."""
        return cls(epoch, quaternion.from_euler(sequence, angles), angular_velocity, frame)

    @property
    def wxyz_icrf(self):
        """The attitude (4,) from body axes to ICRF."""
        if self.frame == "icrf":
            return self.wxyz
        return frozen(quaternion.multiply(frames.wxyz_to_icrf(self.frame), self.wxyz))

    def __repr__(self):
        rate = ", ".join(f"{component:.6g}" for component in self.angular_velocity)
        return f"<Spin at {self.epoch.utc_iso} UTC: angular velocity {rate} rad/s in body axes>"
