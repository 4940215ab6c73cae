"""A history relative to other axes than ICRF: of an orbit, of the Earth, or inertial ones."""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from attitude import epochs, quaternion, validation
from attitude import representations as forms
from attitude.axes import axes
from attitude.axes.axis_names import OF_ORBIT
from attitude.errors import AttitudeError
from attitude.immutable import Immutable, frozen
from attitude.paths.composed import relative
from attitude.paths.foreign import place_of
from attitude.paths.path import Path

# Epochs at a time, so that temporary arrays stay in the caches.
_BLOCK = 1 << 13

if TYPE_CHECKING:
    from scipy.spatial.transform import Rotation

    from attitude.annotations import FloatArray, Reals
    from attitude.flat_table import FlatTable


class FramedHistory(Immutable):
    """Attitudes and rates relative to named axes; made by ``history.in_frame``.

    S is the shape of the epochs.

    Attributes
    ----------
    history : AttitudeHistory
        Relative to ICRF.
    frame : str
        As given, in lower case.
    wxyz : (S, 4) array
        Body to frame, scalar first; continuous in sign along one row of epochs.
    """

    history: Any
    frame: str
    wxyz: FloatArray

    def __init__(self, history: Any, frame: str, orbit: Any = None) -> None:
        known = axes.named(frame)
        self._set("history", history)
        self._set("frame", str(frame).lower())
        self._set("_axes", known)
        self._axes: axes.Axes
        self._orbit: Path | None
        self._set("_orbit", _orbit_of(orbit, known.kind, frame))
        to_icrf = known.to_icrf(history.epoch, *self._flat_epochs(), orbit=self._orbit)
        self._set("_to_icrf", np.broadcast_to(to_icrf, (history.seconds.size, 4)))
        self._to_icrf: FloatArray
        wxyz = quaternion.multiply(quaternion.conjugate(self._to_icrf), history.wxyz.reshape(-1, 4))
        if history.seconds.ndim == 1:
            wxyz = forms.continuous(wxyz)
        self._set("wxyz", frozen(wxyz.reshape(*history.seconds.shape, 4)))

    def _flat_epochs(self) -> tuple[FloatArray, FloatArray]:
        seconds = self.history.seconds.reshape(-1)
        low = self.history.low
        return seconds, np.zeros(seconds.size) if low is None else low.reshape(-1)

    @property
    def seconds(self) -> FloatArray:
        """TDB seconds (S) since the epoch of the history."""
        found: FloatArray = self.history.seconds
        return found

    def __len__(self) -> int:
        return len(self.history)

    @property
    def xyzw(self) -> FloatArray:
        """(S, 4) unit quaternions, body to frame, scalar last."""
        return frozen(np.roll(self.wxyz, -1, axis=-1))

    @cached_property
    def angular_velocity(self) -> FloatArray:
        """(S, 3) rad/s relative to the frame, over the body axes."""
        own = self.history.angular_velocity
        turning = self._axes.angular_velocity(
            self.history.epoch, *self._flat_epochs(), orbit=self._orbit
        )
        if turning is None:
            return frozen(np.array(own))
        in_icrf = turning.reshape(*self.history.seconds.shape, 3)
        return frozen(own - self.history.inertial_to_body(in_icrf))

    @cached_property
    def angular_velocity_in_frame(self) -> FloatArray:
        """(S, 3) rad/s relative to the frame, over the axes of the frame."""
        return frozen(self.body_to_frame(self.angular_velocity))

    @cached_property
    def matrix(self) -> FloatArray:
        """(S, 3, 3) rotation matrices: v_frame = matrix @ v_body."""
        return frozen(quaternion.matrix(self.wxyz))

    @property
    def dcm(self) -> FloatArray:
        """(S, 3, 3) frame to body: the transpose of `matrix`."""
        return np.swapaxes(self.matrix, -1, -2)

    def body_to_frame(self, v: Reals) -> FloatArray:
        """Components (S, 3) in the frame of vectors (3,) or (S, 3) in body axes."""
        return quaternion.rotate(self.wxyz, validation.rows(v, "v", 3))

    def frame_to_body(self, v: Reals) -> FloatArray:
        """Components (S, 3) in body axes of vectors (3,) or (S, 3) in the frame."""
        return quaternion.rotate(quaternion.conjugate(self.wxyz), validation.rows(v, "v", 3))

    def as_rotation(self) -> Rotation:
        """The attitudes as a scipy Rotation, body to frame, of shape S."""
        from scipy.spatial.transform import Rotation

        flat = Rotation.from_quat(np.array(self.xyzw).reshape(-1, 4))
        return flat[0] if not self.history.seconds.shape else flat

    def euler(self, sequence: str) -> FloatArray:
        """Euler angles (S, 3) in rad: "ZXZ" or "313" is matrix = Rz(a) Rx(b) Rz(c)."""
        angles: FloatArray = self.as_rotation().as_euler(quaternion.known_sequence(sequence))
        return angles.reshape(*self.history.seconds.shape, 3)

    def table(self, *, rates: bool = True) -> FlatTable:
        """An astropy QTable: time (TDB), wxyz, angular_velocity (rad/s, over the body axes).

        AttitudeError for epochs of any shape other than (N,).
        """
        found: FlatTable = self.history.table(rates=rates)
        found["wxyz"] = np.array(self.wxyz)
        if rates:
            found["angular_velocity"] = (
                np.array(self.angular_velocity) * found["angular_velocity"].unit
            )
        name = self.frame.upper()
        found.meta.update(frame=name, wxyz=f"body to {name}, scalar first")
        return found

    def to_pandas(self, *, rates: bool = True) -> Any:
        """A pandas DataFrame with an index of UTC: the columns of `table`, a component each."""
        return self.table(rates=rates).to_pandas().set_index("time")

    def __repr__(self) -> str:
        return f"<FramedHistory of {self.history.seconds.size} epochs in {self.frame.upper()}>"


def _orbit_of(orbit: Any, kind: str, frame: str) -> Path | None:
    """The path of an orbit about its focus, if the axes need one."""
    if kind not in OF_ORBIT:
        return None
    found = place_of(orbit, "orbit")
    orbit = orbit if found is None else found
    if not isinstance(orbit, Path):
        given = "" if orbit is None else f", and orbit is {validation.shown(orbit)}"
        raise AttitudeError(
            f"{frame} are axes of an orbit{given}; give orbit=, the path of the body about its "
            'center: paths.tle("x.tle"), paths.oem("x.oem"), paths.kepler(...).'
        )
    if orbit.center == "ssb":
        raise AttitudeError(
            f"orbit is the path of {orbit.name} about the barycenter of the solar system; give it "
            'about the focus of the orbit: paths.relative(path, "earth").'
        )
    return orbit


def obliquity(
    pole: FloatArray, orbit: Any, instant: epochs.Instant, hi: FloatArray, lo: FloatArray
) -> FloatArray:
    """Angles, of the shape of hi, between a pole and the momentum of an orbit, 0 to pi rad.

    Parameters
    ----------
    pole : (3,) or (N, 3) array
        ICRF.
    orbit : Path or skyfield object
        About its center; one about the barycentre of the solar system is taken about the Sun.
    instant, hi, lo
        Epochs: TDB seconds hi + lo, () or (N,), since the instant.
    """
    found = place_of(orbit, "orbit")
    known = orbit if found is None else found
    if not isinstance(known, Path):
        raise AttitudeError(
            f"orbit is {validation.shown(orbit)}; give the path of the body: paths.mpc_orbit(...), "
            "paths.kepler(...), paths.tle(...)."
        )
    if known.center == "ssb":
        known = relative(known, "sun")
    shape, pole = np.shape(hi), np.atleast_2d(pole).T
    hi, lo = np.ravel(hi), np.ravel(np.broadcast_to(lo, shape))
    angles = np.empty(hi.size)
    for begin in range(0, hi.size, _BLOCK):
        part = slice(begin, begin + _BLOCK)
        position, velocity = known.state(instant, hi[part], lo[part])
        normal = _cross(position.T, velocity.T)
        own = pole if pole.shape[1] == 1 else pole[:, part]
        x, y, z = _cross(own, normal)
        along = own[0] * normal[0] + own[1] * normal[1] + own[2] * normal[2]
        angles[part] = np.arctan2(np.sqrt(x * x + y * y + z * z), along)
    return angles.reshape(shape)


def _cross(a, b):
    """The components of a x b for rows of components, which numpy's cross would copy."""
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])
