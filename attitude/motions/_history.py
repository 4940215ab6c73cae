"""Attitudes at epochs, and the quantities that follow from them, computed on first use."""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from attitude._support import markup, validation
from attitude._support.arrays import frozen
from attitude._support.pairs import Seconds
from attitude.epochs import _instants
from attitude.errors import AttitudeError
from attitude.frames import quaternion
from attitude.frames.representations import Attitudes

if TYPE_CHECKING:
    from astropy.time import Time

    from attitude._support.annotations import FloatArray, Reals
    from attitude._support.tables import FlatTable
    from attitude.motions._axes import FramedHistory


# Number of epochs from which one vector is rotated by the compiled loop, in 3 to 9 ns an epoch
# instead of 10 to 16: for fewer, loading the loop (4 ms, once) takes longer.
_MANY = 1 << 17


class AttitudeHistory(Attitudes):
    """The rotation of one body at each of some epochs.

    Made by ``motion.at(t)``; S is the shape of t.  All arrays are read-only.

    Attributes
    ----------
    wxyz, xyzw : (S, 4) arrays
        Body to ICRF, scalar first or last; continuous in sign along the motion.
    seconds, low : arrays of shape S (low may be None)
        TDB seconds since `epoch`: seconds + low.
    epoch : Instant
        Epoch from which the seconds count.
    motion : Motion
        The motion that made the history, or any object with its `angular_velocity_at` and
        `angular_acceleration_at`.

    >>> from attitude import Body, FreeRotation, Spin
    >>> spin = Spin(epoch="2026-01-01", wxyz=(1, 0, 0, 0), angular_velocity=(0, 0, 0.1))
    >>> history = FreeRotation(Body(moments=(1, 2, 3)), spin).at([0.0, np.pi / 0.2])
    >>> history.body_to_inertial([1.0, 0.0, 0.0]).round(12)     # a quarter turn about z
    array([[1., 0., 0.],
           [0., 1., 0.]])
    """

    motion: Any
    epoch: _instants.Instant
    low: FloatArray | None

    def __init__(
        self,
        motion: Any,
        epoch: _instants.Instant,
        seconds: FloatArray,
        low: FloatArray | None,
        wxyz: FloatArray,
    ) -> None:
        # one update instead of five calls of _set: motion.at of one epoch is 15 % faster
        self.__dict__.update(
            motion=motion,
            epoch=epoch,
            seconds=frozen(seconds),
            low=None if low is None else frozen(low),
            wxyz=frozen(wxyz),
        )

    def __getitem__(self, index: Any) -> AttitudeHistory:
        """The history of some of the epochs: history[10:20], history[mask]."""
        seconds, low = Seconds.of(self).taken(index).mapped(np.asarray)
        history = AttitudeHistory(self.motion, self.epoch, seconds, low, _taken(self.wxyz, index))
        if "angular_velocity" in self.__dict__:
            history.__dict__["angular_velocity"] = frozen(_taken(self.angular_velocity, index))
        return history

    def __repr__(self) -> str:
        return f"<AttitudeHistory of {self.seconds.size} epochs from {self.epoch.utc_iso} UTC>"

    def _repr_html_(self) -> str:
        head = f"{self.seconds.size} attitudes, body to ICRF, from {self.epoch.utc_iso} UTC"
        return markup.attitudes(head, self.seconds, self.wxyz)

    @cached_property
    def time(self) -> Time:
        """The epochs as an astropy Time in TDB, rounded to 5e-12 s; NaN epochs are masked."""
        return _instants.times(self.epoch, self.seconds, self.low)

    @cached_property
    def angular_velocity(self) -> FloatArray:
        """(S, 3) rad/s over the body axes."""
        return frozen(self.motion.angular_velocity_at(self.seconds, self.low))

    @cached_property
    def angular_acceleration(self) -> FloatArray:
        """(S, 3) rad/s2 over the body axes: the rate of change of angular_velocity."""
        return frozen(
            self.motion.angular_acceleration_at(
                self.seconds, self.low, angular_velocity=self.angular_velocity
            )
        )

    @cached_property
    def turning_rate(self) -> FloatArray:
        """(S, 3) rad/s over the body axes: the rate at which the attitude turns.

        That is `angular_velocity`, but under an `InternalDissipation`, whose slip is added.
        """
        return frozen(
            self.motion.turning_rate_at(
                self.seconds, self.low, wxyz=self.wxyz, angular_velocity=self.angular_velocity
            )
        )

    @cached_property
    def covariance(self) -> FloatArray:
        """(S, 6, 6) covariance of attitude (rotation vector, rad, ICRF axes) and rates (body axes).

        It follows from the covariance of the motion's spin to first order (`nonlinearity` says
        where that holds).

        Raises
        ------
        AttitudeError
            If the spin has no covariance.
        """
        return frozen(self._of_errors("covariance_at", rates=True))

    @cached_property
    def sigma(self) -> FloatArray:
        """(S, 3) standard deviations of the attitude about the ICRF axes, rad."""
        return frozen(_deviations(self.attitude_covariance))

    @property
    def sigma_deg(self) -> FloatArray:
        """(S, 3) `sigma` in degrees."""
        return frozen(np.degrees(self.sigma))

    @cached_property
    def sigma_angular_velocity(self) -> FloatArray:
        """(S, 3) standard deviations of the angular velocity over the body axes, rad/s."""
        return frozen(_deviations(self.covariance[..., 3:, 3:]))

    @cached_property
    def attitude_covariance(self) -> FloatArray:
        """(S, 3, 3) covariance of the attitude (rotation vector, rad, ICRF axes)."""
        if "covariance" in self.__dict__:
            return self.covariance[..., :3, :3]
        return frozen(self._of_errors("covariance_at", rates=False))

    def _of_errors(self, method: str, **options: bool) -> FloatArray:
        """What a method of the motion answers of its errors at the epochs."""
        if not hasattr(self.motion, method):
            raise AttitudeError(
                f"{type(self.motion).__name__} has no covariance; standard deviations and "
                "covariances follow from a FreeRotation whose spin has a covariance."
            )
        return getattr(self.motion, method)(self.seconds, self.low, **options)

    @cached_property
    def nonlinearity(self) -> FloatArray:
        """(S,) ratio of the second to the first order of errors of one standard deviation.

        Beyond 0.1 the covariance misleads: take `FreeRotation.sample` or `sigma_points`.
        """
        return frozen(self._of_errors("nonlinearity_at"))

    @cached_property
    def angular_velocity_inertial(self) -> FloatArray:
        """(S, 3) rad/s over the ICRF axes."""
        return frozen(self.body_to_inertial(self.angular_velocity))

    def in_frame(self, frame: str, orbit: Any = None) -> FramedHistory:
        """The attitudes and rates relative to other axes than ICRF.

        Parameters
        ----------
        frame : str
            "lvlh", "rtn", "tnw", "ntw" or "vnc" (axes of an orbit), "itrf", "tod", "teme" and
            others of the Earth, or "eme2000", "ecliptic", "icrf".
        orbit : Path or skyfield satellite, optional
            Path of the body about its center, for axes of the orbit: paths.tle(...), paths.oem(...)

        Returns
        -------
        FramedHistory
            With wxyz (body to the frame), angular_velocity (relative to the frame, over the body
            axes), and angular_velocity_in_frame (over the axes of the frame).

        Raises
        ------
        AttitudeError
            For an unknown frame, axes of an orbit without an orbit, and epochs outside of its span
            or of the table of the Earth's orientation.
        """
        from attitude.motions._axes import FramedHistory

        return FramedHistory(self, frame, orbit)

    def body_to_inertial(self, v: Reals) -> FloatArray:
        """Components (S, 3) in ICRF of vectors (3,) or (S, 3) in body axes."""
        vectors = self._vectors(v)
        if _is_one_for_many(vectors, self.wxyz):
            return _one_for_many(vectors, quaternion.conjugate(self.wxyz))
        return quaternion.rotate(self.wxyz, vectors)

    def inertial_to_body(self, v: Reals) -> FloatArray:
        """Components (S, 3) in body axes of vectors (3,) or (S, 3) in ICRF."""
        vectors = self._vectors(v)
        if _is_one_for_many(vectors, self.wxyz):
            return _one_for_many(vectors, self.wxyz)
        return quaternion.rotate(quaternion.conjugate(self.wxyz), vectors)

    def body_to_inertial_sigma(self, v: Reals) -> FloatArray:
        """Standard deviations (S, 3) of `body_to_inertial`, for exact vectors in body axes.

        To first order: in the unit of v, over the ICRF axes.  AttitudeError without a covariance.
        """
        arms = np.cross(self.body_to_inertial(v)[..., None, :], np.eye(3))
        return turned_deviations(self.attitude_covariance[..., None, :, :], arms)

    def inertial_to_body_sigma(self, v: Reals) -> FloatArray:
        """Standard deviations (S, 3) of `inertial_to_body`, for exact vectors in ICRF.

        To first order: in the unit of v, over the body axes.  AttitudeError without a covariance.
        """
        vectors = np.broadcast_to(self._vectors(v), (*self.shape, 3))
        arms = np.cross(np.swapaxes(self.matrix, -1, -2), vectors[..., None, :])
        return turned_deviations(self.attitude_covariance[..., None, :, :], arms)

    def _vectors(self, v: Reals) -> FloatArray:
        """Vectors (..., 3) whose leading axes broadcast with the shape of the epochs."""
        vectors = validation.rows(v, "v", 3)
        try:
            np.broadcast_shapes(vectors.shape[:-1], self.shape)
        except ValueError as err:
            raise AttitudeError(
                f"v has shape {vectors.shape}, and the history has epochs {self.shape}; give one "
                f"vector (3,), or one for each epoch, {(*self.shape, 3)}."
            ) from err
        return vectors

    def table(self, *, rates: bool = True, sigma: bool = False) -> FlatTable:
        """The history as an astropy QTable: time (TDB), wxyz, angular_velocity (rad/s).

        ``.write("x.ecsv")`` keeps units and both doubles of the times, which `QTable.read` gives
        back; ``.write("x.csv")`` has one column for each component: tdb_jd1, tdb_jd2 (days, their
        sum is the Julian date in TDB), w, x, y, z, omega_x, omega_y, omega_z.

        With ``sigma=True`` also their standard deviations: sigma (rad, about the ICRF axes) and
        sigma_angular_velocity (rad/s).

        Raises
        ------
        AttitudeError
            For epochs of any shape other than (N,); standard deviations of a motion without a
            covariance.
        """
        from astropy import units

        from attitude._support.tables import FlatTable

        if len(self.shape) != 1:
            raise AttitudeError(
                f"the epochs have shape {self.shape}; a table takes one row of epochs, (N,)."
            )
        columns = {"time": self.time, "wxyz": np.array(self.wxyz)}
        if rates:
            columns["angular_velocity"] = np.array(self.angular_velocity) * units.rad / units.s
        if sigma and rates:
            of_rates = np.array(self.sigma_angular_velocity) * units.rad / units.s
            columns["sigma_angular_velocity"] = of_rates
        if sigma:
            columns["sigma"] = np.array(self.sigma) * units.rad
        description = {"frame": "ICRF", "epoch": f"{self.epoch.utc_iso} UTC"}
        return FlatTable(columns, meta={**description, "wxyz": "body to ICRF, scalar first"})

    def to_pandas(self, *, rates: bool = True, sigma: bool = False) -> Any:
        """A pandas DataFrame with an index of UTC: the columns of `table`, a component each.

        ``.attrs["units"]`` has the units.

        Raises
        ------
        AttitudeError
            As `table`, and if pandas is not installed.
        """
        frame = self.table(rates=rates, sigma=sigma).to_pandas().set_index("time")
        frame.insert(0, "tdb_seconds", np.array(self.seconds))
        return frame

    def to_xarray(self, *, rates: bool = True) -> Any:
        """An xarray Dataset over the dimension ``time`` (UTC): wxyz, and angular_velocity (rad/s).

        Raises
        ------
        AttitudeError
            As `table`, and if xarray is not installed.
        """
        try:
            import xarray
        except ImportError as err:
            raise AttitudeError(
                "a Dataset needs xarray, which is not installed; run pip install xarray, or use "
                ".table()."
            ) from err
        columns = self.table(rates=rates)
        variables = {"wxyz": (("time", "wxyz_part"), columns["wxyz"], {"frame": "body to ICRF"})}
        if rates:
            values = columns["angular_velocity"].value
            about = {"units": "rad / s", "axes": "body"}
            variables["angular_velocity"] = (("time", "xyz"), values, about)
        places = {
            "time": self.time.utc.datetime64,
            "tdb_seconds": ("time", np.array(self.seconds)),
            "wxyz_part": list("wxyz"),
            "xyz": list("xyz"),
        }
        if not rates:
            places.pop("xyz")
        return xarray.Dataset(variables, places, {"epoch": f"{self.epoch.utc_iso} UTC"})


def _deviations(covariance):
    """Square roots (S, n) of the diagonals of covariances (S, n, n)."""
    return np.sqrt(np.maximum(np.diagonal(covariance, axis1=-2, axis2=-1), 0.0))


def turned_deviations(covariance: FloatArray, gradient: FloatArray) -> FloatArray:
    """Standard deviations (...) of numbers with gradients (..., 3) by errors of (..., 3, 3)."""
    variance = np.einsum("...i,...ij,...j->...", gradient, covariance, gradient)
    return np.sqrt(np.maximum(variance, 0.0))


def _is_one_for_many(v: FloatArray, wxyz: FloatArray) -> bool:
    return v.shape == (3,) and wxyz.ndim == 2 and len(wxyz) >= _MANY


def _one_for_many(v: FloatArray, wxyz: FloatArray) -> FloatArray:
    """The components (N, 3) over body axes of one inertial vector."""
    from attitude._solver import vectors as solver_vectors

    out = np.empty((3, len(wxyz)))
    # Read-only, as in all calls of compiled code: to numba a writable array is another type.
    turns, vector = (frozen(np.ascontiguousarray(array)) for array in (wxyz.T, v[:, None]))
    solver_vectors.to_body(turns, vector, out)
    return out.T


def _taken(vectors, index):
    """Some of the vectors (S, k), by an index of S."""
    whole = (slice(None), *(index if isinstance(index, tuple) else (index,)))
    return np.moveaxis(np.moveaxis(vectors, -1, 0)[whole], 0, -1)
