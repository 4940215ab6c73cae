"""The state of a motion at another epoch, as a Spin with its covariance."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from attitude import epochs, frames, quaternion
from attitude.errors import AttitudeError
from attitude.free_rotation.normal_form import NormalForm
from attitude.spin import Spin

if TYPE_CHECKING:
    from attitude.annotations import EpochOrSeconds, FloatArray
    from attitude.epochs import Instant


class OtherEpochs(NormalForm):
    """Base of `FreeRotation`: its state, and its pole against an orbit, at other epochs."""

    def spin_at(self, epoch: EpochOrSeconds) -> Spin:
        """The state at another epoch: ``FreeRotation(body, motion.spin_at(t))`` is this motion.

        Parameters
        ----------
        epoch : epoch or seconds
            One, as `at` takes it.

        Returns
        -------
        Spin
            In the frame of the spin, with its covariance (to first order) if it has one.

        Raises
        ------
        AttitudeError
            For several epochs, and those that `at` refuses.
        """
        return spin_of(self, epoch)

    def obliquity(self, orbit: Any, at: EpochOrSeconds | None = None) -> float:
        """The angle between the angular momentum and that of an orbit, 0 to pi rad.

        Parameters
        ----------
        orbit : Path or skyfield object
            Of the body about its center; one about the barycentre is taken about the Sun.
        at : epoch or seconds, optional
            Of the osculating orbit; that of the spin by default.
        """
        from attitude.axes.framed import obliquity

        hi, lo = epochs.seconds_since(self.epoch, self.epoch if at is None else at)
        low = np.zeros(hi.shape) if lo is None else lo
        assert self.momentum is not None  # that of a free rotation is constant
        return float(obliquity(self.momentum, orbit, self.epoch, hi, low))


def spin_of(motion: Any, epoch: EpochOrSeconds) -> Spin:
    """The Spin at one epoch of a motion that has a spin, in the frame of that spin.

    Raises
    ------
    AttitudeError
        For several epochs, NaN, and those that the motion refuses.
    """
    hi, lo = epochs.seconds_since(motion.epoch, epoch, name="epoch")
    if hi.shape != () or not np.isfinite(hi):
        raise AttitudeError(f"epoch is {epoch!r}; give one finite epoch.")
    history = motion.at(hi, low=np.zeros(()) if lo is None else lo)
    at: Instant = motion.epoch.after(float(hi), 0.0 if lo is None else float(lo))
    frame = motion.spin.frame
    back = quaternion.conjugate(frames.wxyz_to_icrf(frame))
    wxyz = history.wxyz if frame == "icrf" else quaternion.multiply(back, history.wxyz)
    found = Spin(at, wxyz, history.angular_velocity, frame)
    if motion.spin.covariance is None:
        return found
    return found.with_covariance(_covariance(motion, hi, lo, frame))


def _covariance(motion: Any, hi: FloatArray, lo: FloatArray | None, frame: str) -> FloatArray:
    """The covariance (9, 9) there, with the attitude over the axes of a frame."""
    attitude, rates = motion.sensitivity_at(hi, lo, angular_velocity=True)
    changes = np.eye(9)
    changes[:3], changes[3:6] = frames.matrix_to_icrf(frame).T @ attitude, rates
    found: FloatArray = changes @ motion.spin.covariance_icrf @ changes.T
    return 0.5 * (found + found.T)
