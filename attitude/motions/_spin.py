"""The state of rotation at an epoch: attitude and angular velocity."""

from __future__ import annotations

from copy import copy
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, overload

import numpy as np

from attitude import frames
from attitude._solver import covariance as covariances
from attitude._support import markup, validation
from attitude._support.arrays import Valued, frozen
from attitude._support.synonyms import arguments
from attitude.epochs import _inputs
from attitude.errors import AttitudeError
from attitude.frames import quaternion
from attitude.motions import _published
from attitude.motions._body import Body

if TYPE_CHECKING:
    from collections.abc import Mapping

    from scipy.spatial.transform import Rotation

    from attitude._solver.regime import Mode
    from attitude._support.annotations import Epoch, FloatArray, Real, Reals
    from attitude.epochs import _instants


_FIRST = "give wxyz=(w, x, y, z), the scalar first"
_RATES = "give angular_velocity=(3 numbers), rad/s over the body axes"
_HINTS = {
    "xyzw": "give wxyz=(w, x, y, z), the scalar first: wxyz=np.roll(xyzw, 1)",
    **dict.fromkeys(("quaternion", "q", "attitude"), _FIRST),
    **dict.fromkeys(("omega", "rates", "rate", "angular_rate", "w"), _RATES),
    **dict.fromkeys(("time", "date", "t", "t0"), "give epoch="),
    "rotation": "use Spin.from_rotation",
    "matrix": "use Spin.from_matrix (body to frame), or give dcm= (frame to body)",
    **dict.fromkeys(("euler", "angles"), "use Spin.from_euler or Spin.from_angles"),
    **dict.fromkeys(("P_psi", "P_phi", "pole", "P", "period", "rpm"), "use Spin.from_periods"),
}
_EXAMPLE = 'Spin(epoch="2026-01-01", wxyz=(1, 0, 0, 0), angular_velocity=(0.1, 1.5, 0.1))'
_PUBLISHED = {
    **dict.fromkeys(("period", "periods"), "give P_psi= and P_phi=, or P="),
    **dict.fromkeys(("date", "time", "t0"), "give epoch="),
    **dict.fromkeys(
        ("spin_axis", "axis", "beta", "lam", "ra", "dec", "longitude", "latitude"),
        'give pole=, longitude and latitude as in "250, -75 deg", and frame=',
    ),
}


@dataclass(frozen=True, eq=False, repr=False, init=False)
class Spin(Valued):
    """Attitude and angular velocity of a body at an epoch.

    Parameters
    ----------
    epoch : str, astropy Time, skyfield Time, datetime, datetime64
        Text is ISO 8601 in UTC, or followed by the name of a time scale.
    wxyz : (4,) array_like
        Quaternion from body axes to `frame`, scalar first; of any length.
    angular_velocity : (3,) array_like
        Over the body axes: rad/s, or any Quantity, or text such as "14.5 deg/day".
    frame : str
        "icrf" (the same axes as GCRF and SPICE's J2000), "eme2000" or "ecliptic" (of J2000).
    covariance : (9, 9) or (6, 6) array_like, or mapping, optional
        Of the errors of the attitude (rotation vector, rad, axes of `frame`), the angular velocity
        (rad/s, body axes) and the principal moments (kg m2, or relative); (6, 6) for exact moments.
        Or standard deviations by name, as in ``{"attitude": "1 deg", "angular_velocity":
        "0.01 deg/s", "moments": 0.1}``, each one number or three.

    Attributes
    ----------
    epoch : Instant
    wxyz : (4,) array
        Unit quaternion from body axes to `frame`, scalar first.
    wxyz_as_pairs : (4, 2) array
        The same to 31 digits, each component the sum of its two doubles: that the quaternion given
        is divided by its length costs no accuracy, not even in chains of arcs, which amplify it.
    angular_velocity : (3,) array
        rad/s over the body axes.
    frame : str
        In lower case.
    covariance : (9, 9) array or None

    Raises
    ------
    AttitudeError
        For a date that cannot be read, a quaternion of zero length, a matrix that is not a rotation
        within 1e-6, both of these or neither, a shape, unit or frame that is not known, and a
        covariance that is not symmetric or not positive.

    >>> Spin(epoch="2026-01-01", wxyz=(1, 0, 0, 0), angular_velocity=(1, 15, 1))
    <Spin at 2026-01-01T00:00:00 UTC: angular velocity 1, 15, 1 rad/s in body axes>
    """

    epoch: _instants.Instant
    wxyz: FloatArray
    angular_velocity: FloatArray
    frame: str
    covariance: FloatArray | None
    wxyz_as_pairs: FloatArray = field(init=False)

    _value = ("epoch", "frame", "wxyz_as_pairs", "angular_velocity", "covariance")

    @overload
    def __init__(
        self,
        epoch: Epoch,
        wxyz: Reals,
        angular_velocity: Reals,
        frame: str = ...,
        covariance: Reals | Mapping[str, Reals] | None = ...,
    ) -> None: ...

    @overload
    def __init__(
        self,
        epoch: Epoch,
        *,
        dcm: Reals,
        angular_velocity: Reals,
        frame: str = ...,
        covariance: Reals | Mapping[str, Reals] | None = ...,
    ) -> None: ...

    @arguments(_HINTS, _EXAMPLE)
    def __init__(
        self,
        epoch: Epoch,
        wxyz: Reals | None = None,
        angular_velocity: Reals | None = None,
        frame: str = "icrf",
        covariance: Reals | Mapping[str, Reals] | None = None,
        dcm: Reals | None = None,
    ) -> None:
        known_epoch, known_frame = _inputs.instant(epoch, "epoch"), frames.known(frame)
        in_pairs = quaternion.unit_in_pairs(_attitude(wxyz, dcm))
        if angular_velocity is None:
            raise AttitudeError(f"Spin is given no rates; {_RATES}, as in {_EXAMPLE}.")
        rate = validation.real(angular_velocity, "angular_velocity", unit="rad/s")
        if rate.shape != (3,):
            if rate.shape == ():
                raise AttitudeError(
                    f"angular_velocity is one number, {validation.shown(angular_velocity)}, which "
                    'has no axis; give its components over the body axes, such as "0, 0, 10 rpm", '
                    'or use Spin.from_periods(body, P="6 s", pole="180, -52 deg", phi0=0.0, '
                    "epoch=...)."
                )
            raise AttitudeError(f"angular_velocity has shape {rate.shape}; give (3).")
        errors = None if covariance is None else frozen(covariances.known(covariance))
        self._set_all(
            epoch=known_epoch,
            frame=known_frame,
            wxyz_as_pairs=frozen(in_pairs),
            wxyz=frozen(in_pairs[:, 0].copy()),
            angular_velocity=frozen(rate),
            covariance=errors,
        )

    @classmethod
    @arguments(
        {},
        'Spin.from_rotation(epoch="2026-01-01", rotation=Rotation.identity(), '
        "angular_velocity=(0.1, 1.5, 0.1))",
    )
    def from_rotation(
        cls, *, epoch: Epoch, rotation: Rotation, angular_velocity: Reals, frame: str = "icrf"
    ) -> Spin:
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
    @arguments(
        {"dcm": "use Spin(dcm=)"},
        'Spin.from_matrix(epoch="2026-01-01", matrix=np.eye(3), angular_velocity=(0.1, 1.5, 0.1))',
    )
    def from_matrix(
        cls, *, epoch: Epoch, matrix: Reals, angular_velocity: Reals, frame: str = "icrf"
    ) -> Spin:
        """From a rotation matrix (3, 3) that takes body vectors to the frame.

        Its transpose, the paper's attitude matrix A, often called DCM, is given as ``Spin(dcm=)``.
        """
        matrix = validation.real(matrix, "matrix", shape=(3, 3))
        return cls(epoch, quaternion.from_matrix(matrix), angular_velocity, frame)

    @classmethod
    @arguments(
        dict.fromkeys(("euler", "euler_angles"), "give angles="),
        'Spin.from_euler(epoch="2026-01-01", sequence="ZXZ", angles=(0.1, 0.2, 0.3), '
        "angular_velocity=(0.1, 1.5, 0.1))",
    )
    def from_euler(
        cls,
        *,
        epoch: Epoch,
        sequence: str,
        angles: Reals,
        angular_velocity: Reals,
        frame: str = "icrf",
    ) -> Spin:
        """From Euler angles: "313" or "ZXZ" is body to frame = Rz(a) Rx(b) Rz(c); rad."""
        sequence = quaternion.known_sequence(sequence)
        angles = validation.real(angles, "angles", shape=(3,), unit="rad")
        return cls(epoch, quaternion.from_euler(sequence, angles), angular_velocity, frame)

    @classmethod
    @arguments(
        _PUBLISHED,
        'Spin.from_periods(body, mode="LAM", convention="L", P_psi="5.37 d", P_phi="7.4 d", '
        'pole="180, -52 deg", phi0=0.0, psi0=0.0, epoch="2026-01-01")',
    )
    def from_periods(
        cls,
        body: Body | None,
        *,
        epoch: Epoch,
        pole: Reals,
        phi0: Real,
        mode: str | Mode | None = None,
        convention: str | None = None,
        P_psi: Real | None = None,
        P_phi: Real | None = None,
        psi0: Real | None = None,
        theta_branch: str | None = None,
        P: Real | None = None,
        frame: str = "ecliptic",
    ) -> Spin:
        """From a published spin state: pole, two periods, angles at an epoch.

        Parameters
        ----------
        body : Body
            Its moments may be relative.  The labels of its axes follow from the moments.
        mode : "LAM", "SAM" or Mode
            Long-axis or short-axis mode.  Required: it does not follow from the periods.
        convention : "L" or "S"
            Whether phi and P_phi are those of the long or of the short axis (see
            attitude.motions._conventions and docs/conventions.md).  Required, as the mode.
        P_psi, P_phi : float or Quantity
            s; rotation about the axis, and its mean circulation about the momentum.
        pole : (2,) array_like
            Longitude and latitude of the momentum in `frame`, rad or Quantities.
        phi0, psi0 : float or Quantity
            rad, at the epoch; theta0 follows.
        theta_branch : "acute" or "obtuse", optional
            theta0 up to or above 90 degrees.  Required where psi librates (SAM with "L", LAM with
            "S"); otherwise "acute" by default, so that a printed theta0 above 90 needs "obtuse".
        P : float or Quantity
            s; in place of mode, convention, P_psi, P_phi and psi0: a relaxed rotator, about the
            short axis of the body or, with body=None, about its z axis, as in DAMIT.
        frame : str
            Of the pole; the ecliptic of J2000 by default, as in the literature.

        Raises
        ------
        AttitudeError
            If no motion has these numbers; the text has the possible range, and the modes and
            conventions in which a motion exists.

        Notes
        -----
        Round trips with `FreeRotation.published` hold to 1e-12.

        >>> from attitude import Body
        >>> apophis = Body(moments=(0.61, 0.965, 1.0), relative=True)
        >>> Spin.from_periods(
        ...     apophis, mode="SAM", convention="S", P_psi="263 h", P_phi="27.38 h",
        ...     pole=["250 deg", "-75 deg"], phi0=0.0, psi0=0.0, epoch="2012-12-23",
        ... )
        <Spin at 2012-12-23T00:00:00 UTC: angular velocity ...>
        """
        state = _published.states_from_two_periods(
            body,
            mode=mode,
            convention=convention,
            P_psi=P_psi,
            P_phi=P_phi,
            pole=pole,
            phi0=phi0,
            psi0=psi0,
            theta_branch=theta_branch,
            P=P,
        )
        return cls(epoch, *state, frame)

    @classmethod
    @arguments(
        _PUBLISHED,
        'Spin.from_energy(body, energy_ratio=1.9, convention="L", P_psi="5.37 d", '
        'pole="180, -52 deg", phi0=0.0, psi0=0.0, epoch="2026-01-01")',
    )
    def from_energy(
        cls,
        body: Body,
        *,
        epoch: Epoch,
        energy_ratio: Real,
        convention: str,
        pole: Reals,
        phi0: Real,
        psi0: Real,
        P_psi: Real | None = None,
        P_phi: Real | None = None,
        mode: str | Mode | None = None,
        theta_branch: str | None = None,
        frame: str = "ecliptic",
    ) -> Spin:
        """From E/E0 = 2 E C / L^2 and one of P_psi and P_phi.

        The mode follows from E/E0; a `mode` that differs is an error.  The others as in
        `from_periods`.
        """
        state = _published.from_energy(
            body,
            energy_ratio=energy_ratio,
            convention=convention,
            pole=pole,
            phi0=phi0,
            psi0=psi0,
            P_psi=P_psi,
            P_phi=P_phi,
            mode=mode,
            theta_branch=theta_branch,
        )
        return cls(epoch, *state, frame)

    @classmethod
    @arguments(
        _PUBLISHED,
        'Spin.from_pole(body, convention="L", pole="180, -52 deg", phi0=0.0, '
        'angular_velocity=(0.1, 1.5, 0.1), epoch="2026-01-01"); a body that does not tumble has '
        'Spin.from_periods(body, P="5 h", pole="180, -52 deg", phi0=0.0, epoch="2026-01-01")',
    )
    def from_pole(
        cls,
        body: Body,
        *,
        epoch: Epoch,
        convention: str,
        pole: Reals,
        phi0: Real,
        angular_velocity: Reals | None = None,
        theta0: Real | None = None,
        psi0: Real | None = None,
        P_psi: Real | None = None,
        P_phi: Real | None = None,
        frame: str = "ecliptic",
    ) -> Spin:
        """From the direction of the momentum, and rates or angles and one period.

        Either angular_velocity (3,), rad/s in body axes, from which theta0 and psi0 follow; or
        theta0, psi0 and one of P_psi and P_phi.  The others as in `from_periods`.
        """
        state = _published.from_pole(
            body,
            convention=convention,
            pole=pole,
            phi0=phi0,
            theta0=theta0,
            psi0=psi0,
            P_psi=P_psi,
            P_phi=P_phi,
            angular_velocity=angular_velocity,
        )
        return cls(epoch, *state, frame)

    @classmethod
    @arguments(
        dict.fromkeys(("euler", "phi", "theta", "psi"), "give angles=(phi, theta, psi)"),
        'Spin.from_angles(body, convention="L", angles=(0.1, 0.2, 0.3), '
        'angular_velocity=(0.1, 1.5, 0.1), epoch="2026-01-01")',
    )
    def from_angles(
        cls,
        body: Body,
        *,
        epoch: Epoch,
        convention: str,
        angles: Reals,
        angular_velocity: Reals,
        frame: str = "ecliptic",
    ) -> Spin:
        """From 3-1-3 angles and rates of labelled axes, as radar observers print them.

        Labelled axes to frame is Rz(a) Rx(b) Rz(c), rad; angular_velocity (3,) in rad/s is over
        the labelled axes too: those of B, C, A with "L", of A, B, C with "S".
        """
        state = _published.from_angles(
            body, convention=convention, angles=angles, angular_velocity=angular_velocity
        )
        return cls(epoch, *state, frame)

    @property
    def wxyz_icrf(self) -> FloatArray:
        """The attitude (4,) from body axes to ICRF, scalar first."""
        if self.frame == "icrf":
            return self.wxyz
        if self.is_rounded:
            return frozen(self.wxyz_icrf_as_pairs[:, 0].copy())
        return frozen(quaternion.multiply(frames.wxyz_to_icrf(self.frame), self.wxyz))

    @cached_property
    def is_rounded(self) -> bool:
        """Whether `wxyz` is rounded: the quaternion given was divided by its length."""
        return bool(self.wxyz_as_pairs[:, 1].any())

    @cached_property
    def wxyz_icrf_as_pairs(self) -> FloatArray:
        """The attitude (4, 2) from body axes to ICRF, each component the sum of its two doubles."""
        if self.frame == "icrf":
            return self.wxyz_as_pairs
        return frozen(frames.attitude_to_icrf(self.frame, self.wxyz_as_pairs))

    @cached_property
    def covariance_icrf(self) -> FloatArray | None:
        """The covariance (9, 9) with the attitude over ICRF axes, or None."""
        if self.covariance is None or self.frame == "icrf":
            return self.covariance
        turn = np.eye(9)
        turn[:3, :3] = frames.matrix_to_icrf(self.frame)
        return frozen(turn @ self.covariance @ turn.T)

    def with_covariance(self, covariance: Reals | Mapping[str, Reals] | None) -> Spin:
        """The same spin with a covariance, given as to the constructor; None for no errors."""
        other = copy(self)
        known = None if covariance is None else frozen(covariances.known(covariance))
        other._set("covariance", known)
        other.__dict__.pop("covariance_icrf", None)
        return other

    def __repr__(self) -> str:
        rate = ", ".join(f"{component:.6g}" for component in self.angular_velocity)
        return f"<Spin at {self.epoch.utc_iso} UTC: angular velocity {rate} rad/s in body axes>"

    def _repr_html_(self) -> str:
        """A table for notebooks."""
        rows = [
            ("epoch", f"{self.epoch.utc_iso} UTC"),
            ("attitude w, x, y, z", ", ".join(f"{x:.9f}" for x in self.wxyz)),
            ("", f"body axes to {self.frame}"),
            ("angular velocity", ", ".join(f"{x:.9g}" for x in self.angular_velocity)),
            ("", "rad/s over the body axes"),
            ("rate", f"{np.degrees(np.linalg.norm(self.angular_velocity)):.9g} deg/s"),
        ]
        if self.covariance is not None:
            sigma = np.sqrt(np.diag(self.covariance))
            rows.append(("sigma of attitude", f"{np.degrees(sigma[:3]).max():.3g} deg"))
            rows.append(("sigma of rates", f"{sigma[3:6].max():.3g} rad/s"))
        return markup.table("Spin", rows)


def refuse_others(body: object, spin: object, takes: str) -> None:
    """AttitudeError for anything but a Body and a Spin; `takes` begins its sentence."""
    if not isinstance(body, Body) or not isinstance(spin, Spin):
        raise AttitudeError(f"{takes}; {type(body).__name__} and {type(spin).__name__} are given.")


def _attitude(wxyz: Reals | None, dcm: Reals | None) -> Reals:
    """The quaternion given, or that of the matrix given."""
    if wxyz is not None and dcm is None:
        return wxyz
    if dcm is not None and wxyz is None:
        return quaternion.from_matrix(validation.real(dcm, "dcm", shape=(3, 3)).T, "dcm")
    raise AttitudeError(
        "Spin takes either wxyz=(w, x, y, z), from body axes to the frame, or dcm=(3 x 3), from "
        "the frame to body axes."
    )
