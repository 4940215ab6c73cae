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

from attitude import quaternion, validation
from attitude.errors import AttitudeError
from attitude.immutable import Immutable, frozen
from attitude.published import conventions, dynamic_inertia
from attitude.regime import Mode, known_convention, regimes

if TYPE_CHECKING:
    from collections.abc import Sequence

    from attitude.annotations import FloatArray, Real, Reals
    from attitude.body import Body
    from attitude.epochs.instants import Instant
    from attitude.regime import Regime

_BRANCHES = ("acute", "obtuse")
# Rounding of cos^2 theta at the ends of a libration of psi, relative to its terms.
_ROUNDING = 1e-14
# Relative error of the period of the state found, above which the state is refused.
_LOST = 1e-6


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


def from_periods(
    body: Body,
    *,
    mode: str | Mode,
    convention: str,
    P_psi: Real,
    P_phi: Real,
    pole: Reals,
    phi0: Real,
    psi0: Real,
    theta_branch: str | None = None,
) -> tuple[FloatArray, FloatArray]:
    """Attitude and angular velocity from two periods; see `Spin.from_periods`.

    Returns
    -------
    wxyz (4,), angular_velocity (3,)
        Body axes to the frame of the pole; rad/s in body axes.
    """
    mode, convention = dynamic_inertia.known_mode(mode), known_convention(convention)
    P_psi = validation.positive(P_psi, "P_psi", unit="s")
    P_phi = validation.positive(P_phi, "P_phi", unit="s")
    moments = _ascending(body)
    dynamic_inertia.refuse_missing_mode(moments, mode)
    y, rest, unit_period = dynamic_inertia.from_periods(moments, mode, convention, P_psi, P_phi)
    return _state(
        body, mode, convention, (y, rest), unit_period / P_psi, pole, phi0, psi0, theta_branch
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
        momentum = unit_period / validation.positive(P_psi, "P_psi", unit="s")
    else:
        assert P_phi is not None
        turns = turns if convention == "L" else turns + 1.0
        momentum = unit_period / (turns * validation.positive(P_phi, "P_phi", unit="s"))
    return _state(body, found, convention, position, momentum, pole, phi0, psi0, theta_branch)


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
    axes = conventions.axes(body, convention)
    moments = conventions.moments(body, convention)
    if angular_velocity is not None:
        if not all(each is None for each in (theta0, psi0, P_psi, P_phi)):
            raise AttitudeError(
                "with angular_velocity, theta0, psi0 and the periods follow; leave them out."
            )
        rate = validation.real(angular_velocity, "angular_velocity", shape=(3,), unit="rad/s")
        if not np.any(rate):
            raise AttitudeError("angular_velocity is zero; a body at rest has no pole.")
        x, y, z = axes.T @ (body.tensor @ (rate / np.max(np.abs(rate))))
        theta, psi = math.atan2(math.hypot(x, y), z), math.atan2(x, y)
        return _attitude(body, convention, pole, (phi, theta, psi)), rate
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
    rate = axes @ (rates * (period / seconds))
    return _attitude(body, convention, pole, (phi, theta, psi)), rate


def from_angles(
    body: Body, *, convention: str, angles: Reals, angular_velocity: Reals
) -> tuple[FloatArray, FloatArray]:
    """Attitude (4,) and angular velocity (3,) from labelled axes; see `Spin.from_angles`."""
    phi, theta, psi = validation.real(angles, "angles", shape=(3,), unit="rad")
    conventions.known_angle(phi, "the first angle")
    conventions.known_tilt(theta, "the second angle")
    conventions.known_angle(psi, "the third angle")
    rate = validation.real(angular_velocity, "angular_velocity", shape=(3,), unit="rad/s")
    turn = conventions.euler_wxyz(phi, theta, psi)
    wxyz = quaternion.multiply(turn, quaternion.conjugate(conventions.axes_wxyz(body, convention)))
    return wxyz, conventions.axes(body, convention) @ rate


def relaxed(
    body: Body | None, *, P: Real, pole: Reals, phi0: Real
) -> tuple[FloatArray, FloatArray]:
    """Attitude (4,) and angular velocity (3,) of a relaxed rotator; see `Spin.from_periods`.

    About the short axis of the body, or with body=None about its z axis, as in DAMIT:
    R = Rz(lambda) Ry(90 deg - beta) Rz(phi0).
    """
    rate = 2.0 * math.pi / validation.positive(P, "P", unit="s")
    phi = conventions.known_angle(phi0, "phi0")
    if body is None:
        wxyz = conventions.pole_wxyz(conventions.known_pole(pole))
        wxyz = quaternion.multiply(wxyz, conventions.euler_wxyz(phi, 0.0, 0.0))
        return wxyz, np.array([0.0, 0.0, rate])
    return (
        _attitude(body, "S", pole, (phi, 0.0, 0.0)),
        conventions.axes(body, "S")[:, 2] * rate,
    )


def _ascending(body: Body) -> FloatArray:
    """The principal moments in ascending order."""
    return body.moments[conventions.order(body)]


def _state(
    body: Body,
    mode: str,
    convention: str,
    position: Sequence[float],
    momentum: float,
    pole: Reals,
    phi0: Real,
    psi0: Real,
    theta_branch: str | None,
) -> tuple[FloatArray, FloatArray]:
    """Attitude and rates from the position (y, 1 - y) of D and |L|; see `dynamic_inertia`."""
    phi, psi = conventions.known_angle(phi0, "phi0"), conventions.known_angle(psi0, "psi0")
    theta = _theta(_ascending(body), mode, convention, position, psi, theta_branch)
    moments = conventions.moments(body, convention)
    rates = conventions.momentum_direction(theta, psi) * (momentum / moments)
    found = regimes(moments, rates)
    turns, unit_period = dynamic_inertia.cycle(_ascending(body), mode, position)
    if not abs(found.P_psi * momentum / unit_period - 1.0) <= _LOST:
        raise AttitudeError(
            f"the motion is so near to the separatrix (P_psi is {turns:.4g} times P_phi_L) that "
            "rates in double precision do not determine its period. Give rates instead."
        )
    attitude = _attitude(body, convention, pole, (phi, theta, psi))
    return attitude, conventions.axes(body, convention) @ rates


def _attitude(
    body: Body, convention: str, pole: Reals, angles: tuple[float, float, float]
) -> FloatArray:
    """Body axes to the frame, from the pole and phi, theta, psi of the labelled axes."""
    turn = quaternion.multiply(
        conventions.pole_wxyz(conventions.known_pole(pole)), conventions.euler_wxyz(*angles)
    )
    return quaternion.multiply(turn, quaternion.conjugate(conventions.axes_wxyz(body, convention)))


def _theta(moments, mode, convention, position, psi, branch):
    """theta from psi; where psi circulates, sin^2 and cos^2 are sums of terms of one sign."""
    (a, b, c), (y, rest) = moments, position
    if mode == "LAM":
        bd = (b - a) * y
        da, cd = (b - a) * rest, (c - b) + bd
    else:
        bd = -(c - b) * y
        da, cd = (b - a) - bd, (c - b) * rest
    s, k = math.sin(psi) ** 2, math.cos(psi) ** 2
    if convention == "L":
        sine, terms = da / a, (s * bd / b, k * cd / c)
    else:
        sine, terms = cd / c, (s * da / a, -k * bd / b)
    librates = (mode == "LAM") != (convention == "L")
    branch = _known_branch(branch, librates, mode, convention)
    cosine = sum(terms)
    if cosine < 0.0:
        if cosine < -_ROUNDING * (sine + abs(terms[0]) + abs(terms[1])):
            raise AttitudeError(_beyond(psi, convention, (a, b, c), (bd, da, cd)))
        cosine = 0.0
    theta = math.atan2(math.sqrt(sine), math.sqrt(cosine))
    return theta if branch == "acute" else math.pi - theta


def _known_branch(branch, librates, mode, convention):
    """ "acute" or "obtuse"; None is "acute" where psi circulates."""
    if branch in _BRANCHES:
        return branch
    if branch is None and not librates:
        return "acute"
    if branch is None:
        raise AttitudeError(
            f'psi librates in {mode} with convention "{convention}", where one psi0 belongs to two '
            'states; give theta_branch="acute" (theta0 up to 90 deg) or "obtuse".'
        )
    raise AttitudeError(f'theta_branch is {branch!r}; give "acute" or "obtuse" (theta0 > 90 deg).')


def _beyond(psi, convention, moments, differences):
    """The error text for a psi0 outside of its libration."""
    (a, b, c), (bd, da, cd) = moments, differences
    if convention == "L":
        largest, center, mode = math.atan2(math.sqrt(cd / c), math.sqrt(-bd / b)), (0, 180), "SAM"
    else:
        largest, center, mode = math.atan2(math.sqrt(da / a), math.sqrt(bd / b)), (90, 270), "LAM"
    return (
        f"psi0 is {math.degrees(psi):.6g} deg; in {mode} with convention "
        f'"{convention}" psi librates within {math.degrees(largest):.6g} deg of {center[0]} or '
        f"{center[1]} deg. Give such an angle, or check convention and periods."
    )
