"""Convert spin states in the form of papers to attitude and angular velocity, and back.

Observers publish the direction of the momentum (the pole), two periods, ratios of the moments and
angles at an epoch.  Their meaning depends on the labels of the axes (`published.conventions`)
and on the mode; neither follows from the numbers, so both must be given.

With the momentum L and the energy E, D = L^2/2E:

    P_psi = 4 K(m) / s,   s^2 = 2E (C-B)(D-A)/ABC (short-axis), 2E (B-A)(C-D)/ABC (long-axis mode)
    1/P_phi_S = 1/P_phi_L + 1/P_psi                          in both modes
    sin^2 theta = (1/D - 1/Iz) / (sin^2 psi/Ix + cos^2 psi/Iy - 1/Iz)

P_psi / P_phi decreases from the separatrix to rotation about the axis, so that in a mode and a
convention one D, or none, has two given periods.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from attitude import markup, quaternion, validation
from attitude.errors import AttitudeError
from attitude.immutable import Immutable, frozen
from attitude.published import conventions, dynamic_inertia, states
from attitude.regime import Mode, known_convention, regimes

if TYPE_CHECKING:
    from attitude.annotations import FloatArray, Real, Reals
    from attitude.body import Body
    from attitude.epochs.instants import Instant
    from attitude.regime import Regime


@dataclass(frozen=True, eq=False)
class Published(Immutable):
    """A spin state in the form of a paper's table; made by ``motion.published(convention)``.

    Attributes
    ----------
    mode : str or None
        "LAM", "SAM", or None where the momentum circulates about neither axis.
    convention : str
        "L" or "S".
    P_psi, P_phi : float
        s; P_phi the mean period of the axis of the convention about the momentum.
    pole : (2,) array
        Longitude and latitude of the momentum in `frame`, rad.
    phi0, theta0, psi0 : float
        rad, at the epoch.
    epoch : Instant
    frame : str
    energy_ratio : float
        2 E C / L^2, E/E0.
    moment_ratios : (2,) array
        A/C and B/C.
    """

    mode: str | None
    convention: str
    P_psi: float
    P_phi: float
    pole: FloatArray
    phi0: float
    theta0: float
    psi0: float
    epoch: Instant
    frame: str
    energy_ratio: float
    moment_ratios: FloatArray

    @property
    def theta_branch(self) -> str:
        """ "acute" for theta0 up to 90 degrees, else "obtuse"."""
        return "acute" if self.theta0 <= 0.5 * math.pi else "obtuse"

    def keywords(self) -> dict[str, Any]:
        """The keywords with which ``Spin.from_periods(body, **keywords)`` makes the same spin."""
        names = ("mode", "convention", "P_psi", "P_phi", "pole", "phi0", "psi0", "theta_branch")
        return {name: getattr(self, name) for name in (*names, "epoch", "frame")}

    def _repr_html_(self) -> str:
        """A table for notebooks."""
        return markup.table(*markup.rows_of(str(self)))

    def __str__(self) -> str:
        degrees = np.degrees([*self.pole, self.phi0, self.theta0, self.psi0])
        return (
            f"{self.mode or 'neither mode'}, convention {self.convention}, {self.frame}, "
            f"{self.epoch.utc_iso} UTC\n"
            f"  P_psi {self.P_psi / 3600.0:.9g} h, P_phi {self.P_phi / 3600.0:.9g} h\n"
            "  pole {:.6f} {:+.6f} deg, phi0 {:.6f}, theta0 {:.6f}, psi0 {:.6f} deg\n".format(
                *degrees
            )
            + f"  E/E0 {self.energy_ratio:.9g}, A/C {self.moment_ratios[0]:.9g}, "
            f"B/C {self.moment_ratios[1]:.9g}"
        )


def published(
    body: Body,
    regime: Regime,
    wxyz: FloatArray,
    angular_velocity: FloatArray,
    *,
    convention: str,
    epoch: Instant,
    frame: str,
) -> Published:
    """The published form of a state; see `FreeRotation.published`.

    Parameters
    ----------
    body : Body
    regime : Regime
        Of this state.
    wxyz : (4,) array
        Body axes to the frame.
    angular_velocity : (3,) array
        rad/s, body axes.
    convention : "L" or "S"
    epoch : Instant
    frame : str

    Raises
    ------
    AttitudeError
        For a body at rest, which has no direction of the momentum.
    """
    convention = known_convention(convention)
    if regime.mode is Mode.AT_REST:
        raise AttitudeError(
            "the body is at rest; without angular momentum there is no pole, no period and no "
            "angle to publish."
        )
    axes = conventions.axes(body, convention)
    momentum = axes.T @ (body.tensor @ (angular_velocity / np.max(np.abs(angular_velocity))))
    attitude = quaternion.multiply(wxyz, conventions.axes_wxyz(body, convention))
    pole, phi, theta, psi = conventions.angles_of(attitude, momentum)
    a, b, c = body.moments[conventions.order(body)]
    return Published(
        mode={1: "SAM", -1: "LAM", 0: None}[regime.circulates],
        convention=convention,
        P_psi=regime.P_psi,
        P_phi=regime.P_phi(convention),
        pole=frozen(pole),
        phi0=float(phi),
        theta0=float(theta),
        psi0=float(psi),
        epoch=epoch,
        frame=frame,
        energy_ratio=regime.energy_ratio,
        moment_ratios=frozen(np.array([a / c, b / c])),
    )


def from_energy(
    body: Body,
    *,
    energy_ratio: Real,
    convention: str,
    pole: Reals,
    phi0: Real,
    psi0: Real,
    P_psi: Real | None = None,
    P_phi: Real | None = None,
    mode: str | Mode | None = None,
    theta_branch: str | None = None,
) -> tuple[FloatArray, FloatArray]:
    """Attitude (4,) and angular velocity (3,) from E/E0 and one period; see `Spin.from_energy`."""
    convention = known_convention(convention)
    if (P_psi is None) == (P_phi is None):
        raise AttitudeError("give one of P_psi and P_phi; the other follows from the energy.")
    found, position = dynamic_inertia.from_energy(_ascending(body), energy_ratio, mode)
    turns, unit_period = dynamic_inertia.cycle(_ascending(body), found, position)
    if P_psi is not None:
        seconds = validation.positive(P_psi, "P_psi", unit="s")
    else:
        assert P_phi is not None
        turns = turns if convention == "L" else turns + 1.0
        seconds = turns * validation.positive(P_phi, "P_phi", unit="s")
    place = np.array([*position, unit_period])
    return states.from_place(
        body, found, convention, place, seconds, pole, phi0, psi0, theta_branch
    )


def from_pole(
    body: Body,
    *,
    convention: str,
    pole: Reals,
    phi0: Real,
    theta0: Real | None = None,
    psi0: Real | None = None,
    P_psi: Real | None = None,
    P_phi: Real | None = None,
    angular_velocity: Reals | None = None,
) -> tuple[FloatArray, FloatArray]:
    """Attitude (4,) and angular velocity (3,) from the pole; see `Spin.from_pole`."""
    convention = known_convention(convention)
    phi = conventions.known_angle(phi0, "phi0")
    moments = conventions.moments(body, convention)
    if angular_velocity is not None:
        if not all(each is None for each in (theta0, psi0, P_psi, P_phi)):
            raise AttitudeError(
                "with angular_velocity, theta0, psi0 and the periods follow; leave them out."
            )
        rate = validation.real(angular_velocity, "angular_velocity", shape=(3,), unit="rad/s")
        if not np.any(rate):
            raise AttitudeError("angular_velocity is zero; a body at rest has no pole.")
        axes = conventions.axes(body, convention)
        x, y, z = axes.T @ (body.tensor @ (rate / np.max(np.abs(rate))))
        theta, psi = math.atan2(math.hypot(x, y), z), math.atan2(x, y)
        angles = (*conventions.known_pole(pole), phi, theta, psi)
        return states.from_labelled(body, convention, angles, (0.0, 0.0, 0.0))[0], rate
    if theta0 is None or psi0 is None or (P_psi is None) == (P_phi is None):
        raise AttitudeError(
            "a pole and phi0 do not determine the state; give either angular_velocity, or theta0 "
            "and psi0 with one of P_psi and P_phi."
        )
    theta, psi = conventions.known_tilt(theta0, "theta0"), conventions.known_angle(psi0, "psi0")
    if np.any(moments == 0.0):
        raise AttitudeError("one moment is zero; for a rod give angular_velocity.")
    rates = conventions.momentum_direction(theta, psi) * (moments.max() / moments)
    found = regimes(moments, rates)
    name, given, period = "P_psi", P_psi, found.P_psi
    if P_psi is None:
        name, given, period = "P_phi", P_phi, found.P_phi(convention)
    assert given is not None
    seconds = validation.positive(given, name, unit="s")
    if not math.isfinite(period):
        raise AttitudeError(
            f"with theta0 and psi0 the state is {found.mode.phrase}, where {name} is infinite; "
            "give the other period."
        )
    angles = (*conventions.known_pole(pole), phi, theta, psi)
    return states.from_labelled(body, convention, angles, rates * (period / seconds))


def from_angles(
    body: Body, *, convention: str, angles: Reals, angular_velocity: Reals
) -> tuple[FloatArray, FloatArray]:
    """Attitude (4,) and angular velocity (3,) from labelled axes; see `Spin.from_angles`."""
    phi, theta, psi = validation.real(angles, "angles", shape=(3,), unit="rad")
    conventions.known_angle(phi, "the first angle")
    conventions.known_tilt(theta, "the second angle")
    conventions.known_angle(psi, "the third angle")
    rate = validation.real(angular_velocity, "angular_velocity", shape=(3,), unit="rad/s")
    to_frame = (0.0, 0.5 * math.pi)  # a pole that turns nothing
    return states.from_labelled(
        body, known_convention(convention), (*to_frame, phi, theta, psi), rate
    )


def _ascending(body: Body) -> FloatArray:
    """The principal moments in ascending order."""
    return body.moments[conventions.order(body)]
