"""The attitude of a frame from any C-kernel, through SPICE."""

from __future__ import annotations

import math
import os
from typing import TYPE_CHECKING

import numpy as np

from attitude import epochs, quaternion
from attitude import representations as forms
from attitude.errors import AttitudeError
from attitude.formats.ck.spice_pool import LoadedKernels, spiceypy
from attitude.motion import Motion

if TYPE_CHECKING:
    from collections.abc import Iterable
    from typing import NoReturn

    from numpy.typing import ArrayLike

    from attitude.annotations import FilePath, FloatArray

_REFERENCE = "J2000"


class KernelAttitude(Motion):
    """The attitude of a frame that SPICE knows, from any C-kernel (or other kernel with frames).

    Parameters
    ----------
    kernels : path or list of paths
        All kernels that the frame needs: CK, FK, SCLK, and leap seconds if the clock needs them.
        They are loaded in SPICE's pool until `close`, or the end of a ``with`` block.
    frame : str
        Name of the frame.

    Attributes
    ----------
    epoch : Instant
        J2000 (TDB), from which plain numbers of t are counted.
    kernels : tuple of str
        Names of the kernels.
    frame : str
        As given.

    Raises
    ------
    AttitudeError
        If spiceypy is not installed, SPICE cannot load a kernel, or the frame is not defined.

    Notes
    -----
    SPICE takes an epoch as one double of seconds past J2000, whose spacing is 1.2e-7 s; the rest of
    an epoch is added along the angular velocity, if the kernels have one.  An epoch takes some 10
    microseconds.  SPICE is not thread-safe.
    """

    kernels: tuple[str, ...]
    frame: str
    _loaded: LoadedKernels

    def __init__(self, kernels: FilePath | Iterable[FilePath], frame: str):
        names: list[FilePath]
        names = [kernels] if isinstance(kernels, (str, os.PathLike)) else list(kernels)
        loaded = LoadedKernels(names)
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

    def close(self) -> None:
        """Unload these kernels, and no others; a second call does nothing."""
        self._loaded.close()

    def angular_acceleration_at(
        self,
        seconds: ArrayLike,
        low: ArrayLike | None = None,
        *,
        angular_velocity: FloatArray | None = None,
    ) -> NoReturn:
        """AttitudeError: a kernel has no inertia, from which accelerations would follow."""
        raise AttitudeError(
            "a kernel has no moments of inertia, from which angular velocities would give "
            "accelerations; make an AttitudeTable of it, or fit a FreeRotation."
        )

    def has_rates_at(self, seconds: ArrayLike, low: ArrayLike | None = None) -> bool:
        """Whether the kernels hold angular velocities at all these TDB seconds since J2000."""
        seconds = np.asarray(seconds, dtype=np.float64)
        return not np.any(np.isnan(self._read(seconds, low)[1]))

    def _evaluate(self, seconds, low, order):
        wxyz, rates = self._read(seconds, low)
        if not order:
            return [wxyz]
        if np.any(np.isnan(rates[~np.isnan(seconds)])):
            raise AttitudeError(
                f"the kernels have attitudes of {self.frame}, but no angular velocities; make an "
                "AttitudeTable of the attitudes, which differentiates them."
            )
        return [wxyz, rates]

    def _read(self, seconds, low):
        """Attitudes, and rates over the body axes, NaN where the kernels have none."""
        hi = np.ravel(seconds)
        rest = np.zeros(hi.size) if low is None else np.ravel(np.broadcast_to(low, seconds.shape))
        matrices, rates = np.full((hi.size, 3, 3), np.eye(3)), np.full((hi.size, 3), np.nan)
        rest = np.array(rest)
        for k, second in enumerate(hi.tolist()):
            if not math.isnan(second):
                matrices[k], rates[k], evaluated = self._state_at(second)
                rest[k] += second - evaluated
        wxyz = forms.continuous(forms.from_dcm(matrices))
        omega = quaternion.rotate(quaternion.conjugate(wxyz), rates)
        turned = forms.from_rotation_vector(np.where(np.isnan(omega), 0.0, omega) * rest[:, None])
        wxyz = quaternion.multiply(wxyz, turned)
        wxyz[np.isnan(hi)] = np.nan
        shape = np.shape(seconds)
        return wxyz.reshape(*shape, 4), omega.reshape(*shape, 3)

    def _state_at(self, second):
        """Direction cosine matrix, angular velocity in J2000, and their epoch, s past J2000.

        The epoch is `second` or, at an end of the kernel, the neighbouring double inside of it.
        """
        spice = spiceypy()
        ways = (
            lambda t: spice.xf2rav(spice.sxform(_REFERENCE, self.frame, t)),
            lambda t: (spice.pxform(_REFERENCE, self.frame, t), np.nan),  # no angular velocities
        )
        for t in (second, math.nextafter(second, math.inf), math.nextafter(second, -math.inf)):
            for way in ways:
                try:
                    return *way(t), t
                except spice.exceptions.SpiceyError as err:
                    spice.reset()
                    reason = err
        where = f"{self.epoch.after(second).utc_iso} UTC" if math.isfinite(second) else second
        raise AttitudeError(
            f"the kernels have no attitude of {self.frame} at {where} ({reason.short}); give "
            "epochs within their coverage (SPICE's ckbrief lists it)."
        ) from reason
