"""The attitude of a frame out of any C-kernel, through SPICE."""

import math
import os

import numpy as np

from attitude import epochs, quaternion
from attitude import representations as forms
from attitude.errors import AttitudeError
from attitude.formats.ck.spice_pool import Loaded, spiceypy
from attitude.motion import Motion

_REFERENCE = "J2000"


class KernelAttitude(Motion):
    """The attitude of a frame that SPICE knows, from any C-kernel (or other kernel with frames).

    Parameters
    ----------
    kernels : path or list of them
        All that the frame needs: CK, FK, SCLK, and leap seconds where the clock wants them.  They
        are loaded into SPICE's pool until `close`, or the end of a ``with`` block.
    frame : str
        By its name.

    Attributes
    ----------
    epoch : Instant
        J2000 (TDB), from which plain numbers of t are counted.

    Notes
    -----
    SPICE takes one double of seconds past J2000, 1.2e-7 s; what that leaves out is added along
    the angular velocity, where the kernels have one.  One epoch at a time: some 10 microseconds
    each.  Not for threads.
    """

    def __init__(self, kernels, frame):
        names = [kernels] if isinstance(kernels, (str, os.PathLike)) else list(kernels)
        loaded = Loaded(names)
        if not isinstance(frame, str) or spiceypy().namfrm(frame) == 0:
            loaded.close()
            listed = ", ".join(os.fspath(name) for name in names)
            raise AttitudeError(
                f"frame is {frame!r}, which the kernels {listed or '(none)'} do not define; give "
                "the name of a frame, and its frame kernel."
            )
        self._set("kernels", tuple(os.fspath(name) for name in names))
        self._set("frame", frame)
        self._set("epoch", epochs.Instant(0.0))
        self._set("_loaded", loaded)

    def close(self):
        """Unload these kernels, and nothing else; a second time does nothing."""
        self._loaded.close()

    def angular_acceleration_at(self, seconds, low=None, *, angular_velocity=None):
        """Not known: a kernel has no inertia."""
        raise AttitudeError(
            "a kernel has no moments of inertia, from which angular velocities would give "
            "accelerations; make an AttitudeTable of it, or fit a FreeRotation."
        )

    def has_rates_at(self, seconds, low=None):
        """Whether the kernels hold angular velocities at these seconds, and not attitudes alone."""
        seconds = np.asarray(seconds, dtype=np.float64)
        return not np.any(np.isnan(self._read(seconds, low)[1]))

    def _evaluate(self, seconds, low, order):
        wxyz, rates = self._read(seconds, low)
        if not order:
            return [wxyz]
        if np.any(np.isnan(rates[~np.isnan(seconds)])):
            raise AttitudeError(
                f"the kernels have attitudes of {self.frame}, but no angular velocities; do "
                "without, or make an AttitudeTable of the attitudes, which finds them."
            )
        return [wxyz, rates]

    def _read(self, seconds, low):
        """Attitudes, and rates over the body axes (NaN where there are none)."""
        hi = np.ravel(seconds)
        rest = np.zeros(hi.size) if low is None else np.ravel(np.broadcast_to(low, seconds.shape))
        matrices, rates = np.full((hi.size, 3, 3), np.eye(3)), np.full((hi.size, 3), np.nan)
        rest = np.array(rest)
        for k, second in enumerate(hi.tolist()):
            if not math.isnan(second):
                matrices[k], rates[k], asked = self._asked(second)
                rest[k] += second - asked
        wxyz = forms.continuous(forms.from_dcm(matrices))
        omega = quaternion.rotate(quaternion.conjugate(wxyz), rates)
        turned = forms.from_rotation_vector(np.where(np.isnan(omega), 0.0, omega) * rest[:, None])
        wxyz = quaternion.multiply(wxyz, turned)
        wxyz[np.isnan(hi)] = np.nan
        shape = np.shape(seconds)
        return wxyz.reshape(*shape, 4), omega.reshape(*shape, 3)

    def _asked(self, second):
        """Direction cosine matrix, angular velocity in J2000, and when: seconds past J2000.

        At the ends of a kernel the nearest double may lie just outside, and its neighbour inside.
        """
        spice = spiceypy()
        ways = (
            lambda t: spice.xf2rav(spice.sxform(_REFERENCE, self.frame, t)),
            lambda t: (spice.pxform(_REFERENCE, self.frame, t), np.nan),  # no angular velocities
        )
        for asked in (second, math.nextafter(second, math.inf), math.nextafter(second, -math.inf)):
            for way in ways:
                try:
                    return *way(asked), asked
                except spice.exceptions.SpiceyError as err:
                    spice.reset()
                    reason = err
        where = f"{self.epoch.after(second).utc_iso} UTC" if math.isfinite(second) else second
        raise AttitudeError(
            f"the kernels have no attitude of {self.frame} at {where} ({reason.short}); ask within "
            "their coverage (SPICE's ckbrief lists it)."
        ) from reason
