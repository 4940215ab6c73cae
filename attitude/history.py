"""Attitudes at epochs, and everything that follows from them, made when first asked for."""

from functools import cached_property

import numpy as np

from attitude import epochs, quaternion, validation
from attitude.errors import AttitudeError
from attitude.immutable import Immutable, frozen

# Epochs from which on one vector is turned by the compiled loop, in 3 to 9 ns an epoch instead of
# 10 to 16: below, loading it (4 ms, once) takes longer.
_MANY = 1 << 17


class AttitudeHistory(Immutable):
    """The rotation of one body at each of some epochs.

    Made by ``motion.at(t)``; S is the shape of t.  All arrays are read-only.

    Attributes
    ----------
    wxyz, xyzw : (S, 4) arrays
        Body to ICRF, scalar first or last; continuous in sign along the motion.
    seconds, low : S arrays (low may be None)
        TDB seconds since `epoch`: seconds + low.
    epoch : Instant
    motion : object
        What the history was made by; it is asked for angular velocities.

    >>> from attitude import Body, FreeRotation, Spin
    >>> spin = Spin(epoch="2026-01-01", wxyz=(1, 0, 0, 0), angular_velocity=(0, 0, 0.1))
    >>> history = FreeRotation(Body(moments=(1, 2, 3)), spin).at([0.0, np.pi / 0.2])
    >>> history.body_to_inertial([1.0, 0.0, 0.0]).round(12)     # a quarter turn about z
    array([[1., 0., 0.],
           [0., 1., 0.]])
    """

    def __init__(self, motion, epoch, seconds, low, wxyz):
        self._set("motion", motion)
        self._set("epoch", epoch)
        self._set("seconds", frozen(seconds))
        self._set("low", None if low is None else frozen(low))
        self._set("wxyz", frozen(wxyz))

    @property
    def shape(self):
        return self.seconds.shape

    def __len__(self):
        if not self.shape:
            raise TypeError("a history of one scalar epoch has no length")
        return self.shape[0]

    def __getitem__(self, index):
        """The history of some of the epochs: history[10:20], history[mask]."""
        seconds = np.asarray(self.seconds[index])
        low = None if self.low is None else np.asarray(self.low[index])
        wxyz = np.moveaxis(np.moveaxis(self.wxyz, -1, 0)[(slice(None), *_tuple(index))], 0, -1)
        part = AttitudeHistory(self.motion, self.epoch, seconds, low, wxyz)
        if "angular_velocity" in self.__dict__:
            rates = np.moveaxis(self.angular_velocity, -1, 0)[(slice(None), *_tuple(index))]
            part.__dict__["angular_velocity"] = frozen(np.moveaxis(rates, 0, -1))
        return part

    def __repr__(self):
        return f"<AttitudeHistory of {self.seconds.size} epochs from {self.epoch.utc_iso} UTC>"

    @cached_property
    def time(self):
        """The epochs as an astropy Time in TDB; NaN epochs are masked."""
        return epochs.times(self.epoch, self.seconds, self.low)

    @property
    def xyzw(self):
        return frozen(np.moveaxis(np.moveaxis(self.wxyz, -1, 0)[[1, 2, 3, 0]], 0, -1))

    @cached_property
    def angular_velocity(self):
        """(S, 3) rad/s over the body axes."""
        return frozen(self.motion.angular_velocity_at(self.seconds, self.low))

    @cached_property
    def angular_acceleration(self):
        """(S, 3) rad/s2 over the body axes: the rate of change of angular_velocity."""
        return frozen(
            self.motion.angular_acceleration_at(
                self.seconds, self.low, angular_velocity=self.angular_velocity
            )
        )

    @cached_property
    def angular_velocity_inertial(self):
        """(S, 3) rad/s over the ICRF axes."""
        return frozen(self.body_to_inertial(self.angular_velocity))

    def body_to_inertial(self, v):
        """Vectors (3,) or (S, 3) in body axes, as components (S, 3) in ICRF."""
        v = validation.rows(v, "v", 3)
        if _is_one_for_many(v, self.wxyz):
            return _one_for_many(v, quaternion.conjugate(self.wxyz))
        return quaternion.rotate(self.wxyz, v)

    def inertial_to_body(self, v):
        """Vectors (3,) or (S, 3) in ICRF, as components (S, 3) in body axes."""
        v = validation.rows(v, "v", 3)
        if _is_one_for_many(v, self.wxyz):
            return _one_for_many(v, self.wxyz)
        return quaternion.rotate(quaternion.conjugate(self.wxyz), v)

    @cached_property
    def matrix(self):
        """(S, 3, 3) body to ICRF: v_icrf = matrix @ v_body."""
        return frozen(quaternion.matrix(self.wxyz))

    @property
    def dcm(self):
        """(S, 3, 3) ICRF to body, the paper's attitude matrix A: the transpose of `matrix`."""
        return np.swapaxes(self.matrix, -1, -2)

    def as_rotation(self):
        """The attitudes as a scipy Rotation, body to ICRF, of shape S."""
        from scipy.spatial.transform import Rotation

        self._refuse_nan("a scipy Rotation")
        flat = Rotation.from_quat(np.array(self.xyzw).reshape(-1, 4))
        return flat[0] if not self.shape else flat

    def euler(self, sequence):
        """Euler angles (S, 3) in rad: "ZXZ" or "313" is matrix = Rz(a) Rx(b) Rz(c)."""
        self._refuse_nan("Euler angles")
        angles = self.as_rotation().as_euler(quaternion.known_sequence(sequence))
        return angles.reshape(*self.shape, 3)

    def table(self, *, rates=True):
        """The history as an astropy QTable: time (TDB), wxyz, angular_velocity (rad/s)."""
        from astropy import units
        from astropy.table import QTable

        if len(self.shape) != 1:
            raise AttitudeError(
                f"the epochs have shape {self.shape}; a table wants a row of them, (N,)."
            )
        columns = {"time": self.time, "wxyz": np.array(self.wxyz)}
        if rates:
            columns["angular_velocity"] = np.array(self.angular_velocity) * units.rad / units.s
        description = {"frame": "ICRF", "epoch": f"{self.epoch.utc_iso} UTC"}
        return QTable(columns, meta={**description, "wxyz": "body to ICRF, scalar first"})

    def _refuse_nan(self, what):
        if np.any(np.isnan(self.seconds)):
            raise AttitudeError(
                f"some epochs are NaN, of which {what} cannot be made; leave them out, for "
                "example with history[~np.isnan(history.seconds)]."
            )


def _is_one_for_many(v, wxyz):
    return v.shape == (3,) and wxyz.ndim == 2 and len(wxyz) >= _MANY


def _one_for_many(v, wxyz):
    """The components (N, 3) over body axes of one inertial vector."""
    from attitude.solution import vectors

    out = np.empty((3, len(wxyz)))
    # Read-only, as others call it: to numba a writable array is another type.
    given = (frozen(np.ascontiguousarray(each)) for each in (wxyz.T, v[:, None]))
    vectors.to_body(*given, out)
    return out.T


def _tuple(index):
    return index if isinstance(index, tuple) else (index,)
