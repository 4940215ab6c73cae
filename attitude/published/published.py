"""Spin states as papers print them, from and to attitude and angular velocity.

Observers publish the direction of the momentum (the pole), two periods, ratios of the moments and
angles at an epoch.  Their meaning depends on the labelling of the axes (`published.conventions`)
and on the mode; neither follows from the numbers, so both must be given.

With the momentum L and the energy E, D = L^2/2E:

    P_psi = 4 K(m) / s,   s^2 = 2E (C-B)(D-A)/ABC (short-axis), 2E (B-A)(C-D)/ABC (long-axis mode)
    1/P_phi_S = 1/P_phi_L + 1/P_psi                          in both modes
    sin^2 theta = (1/D - 1/Iz) / (sin^2 psi/Ix + cos^2 psi/Iy - 1/Iz)

P_psi / P_phi falls all the way from the separatrix to rotation about the axis, so that mode and
convention leave one D, or none.
"""

import math
from dataclasses import dataclass

import numpy as np

from attitude import quaternion, validation
from attitude.errors import AttitudeError
from attitude.immutable import Immutable, frozen
from attitude.published import conventions, dynamic_inertia
from attitude.regime import Mode, known_convention, regimes

_BRANCHES = ("acute", "obtuse")
# Where psi librates its ends are met within rounding.
_ROUNDING = 1e-14
# A state whose doubles miss the period asked for by more than this is no answer.
_LOST = 1e-6


@dataclass(frozen=True, eq=False)
class Published(Immutable):
    """A spin state in the form of a paper's table; made by ``motion.published(convention=)``.

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

    mode: str
    convention: str
    P_psi: float
    P_phi: float
    pole: np.ndarray
    phi0: float
    theta0: float
    psi0: float
    epoch: object
    frame: str
    energy_ratio: float
    moment_ratios: np.ndarray

    @property
    def theta_branch(self):
        """ "acute" or "obtuse": which side of 90 degrees theta0 is on."""
        return "acute" if self.theta0 <= 0.5 * math.pi else "obtuse"

    def keywords(self):
        """What ``Spin.from_periods(body, **keywords)`` takes to make the same spin."""
        names = ("mode", "convention", "P_psi", "P_phi", "pole", "phi0", "psi0", "theta_branch")
        return {name: getattr(self, name) for name in (*names, "epoch", "frame")}

    def __str__(self):
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


def published(body, regime, wxyz, angular_velocity, *, convention, epoch, frame):
    """The published set of a state; `wxyz` (4,) from body axes to the frame.

    Raises
    ------
    AttitudeError
        For a body at rest, which has no momentum to point anywhere.
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


def from_periods(body, *, mode, convention, P_psi, P_phi, pole, phi0, psi0, theta_branch=None):
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
    body, *, energy_ratio, convention, pole, phi0, psi0, P_psi=None, P_phi=None, mode=None,
    theta_branch=None,
):  # fmt: skip
    """Attitude and angular velocity from E/E0 and one period; see `Spin.from_energy`."""
    convention = known_convention(convention)
    if (P_psi is None) == (P_phi is None):
        raise AttitudeError("give one of P_psi and P_phi; the other follows from the energy.")
    found, position = dynamic_inertia.from_energy(_ascending(body), energy_ratio, mode)
    turns, unit_period = dynamic_inertia.cycle(_ascending(body), found, position)
    if P_psi is not None:
        momentum = unit_period / validation.positive(P_psi, "P_psi", unit="s")
    else:
        turns = turns if convention == "L" else turns + 1.0
        momentum = unit_period / (turns * validation.positive(P_phi, "P_phi", unit="s"))
    return _state(body, found, convention, position, momentum, pole, phi0, psi0, theta_branch)


def from_pole(
    body, *, convention, pole, phi0, theta0=None, psi0=None, P_psi=None, P_phi=None,
    angular_velocity=None,
):  # fmt: skip
    """Attitude and angular velocity from the pole; see `Spin.from_pole`."""
    convention = known_convention(convention)
    phi0 = conventions.known_angle(phi0, "phi0")
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
        return _attitude(body, convention, pole, (phi0, theta, psi)), rate
    if theta0 is None or psi0 is None or (P_psi is None) == (P_phi is None):
        raise AttitudeError(
            "a pole with phi0 wants either angular_velocity, or theta0 and psi0 with one of P_psi "
            "and P_phi."
        )
    theta, psi = conventions.known_tilt(theta0, "theta0"), conventions.known_angle(psi0, "psi0")
    if np.any(moments == 0.0):
        raise AttitudeError("one moment is zero; for a rod give angular_velocity.")
    rates = conventions.momentum_direction(theta, psi) * (moments.max() / moments)
    found = regimes(moments, rates)
    period = found.P_psi if P_psi is not None else found.P_phi(convention)
    name, wanted = ("P_psi", P_psi) if P_psi is not None else ("P_phi", P_phi)
    wanted = validation.positive(wanted, name, unit="s")
    if not math.isfinite(period):
        raise AttitudeError(
            f"with theta0 and psi0 the state is {found.mode.phrase}, where {name} is infinite; "
            "give the other period."
        )
    rate = axes @ (rates * (period / wanted))
    return _attitude(body, convention, pole, (phi0, theta, psi)), rate


def from_angles(body, *, convention, angles, angular_velocity):
    """Attitude and angular velocity from labelled axes; see `Spin.from_angles`."""
    phi, theta, psi = validation.real(angles, "angles", shape=(3,), unit="rad")
    conventions.known_angle(phi, "the first angle")
    conventions.known_tilt(theta, "the second angle")
    conventions.known_angle(psi, "the third angle")
    rate = validation.real(angular_velocity, "angular_velocity", shape=(3,), unit="rad/s")
    turn = conventions.euler_wxyz(phi, theta, psi)
    wxyz = quaternion.multiply(turn, quaternion.conjugate(conventions.axes_wxyz(body, convention)))
    return wxyz, conventions.axes(body, convention) @ rate


def relaxed(body, *, P, pole, phi0):
    """Attitude and angular velocity of rotation about the short axis; see `Spin.from_periods`.

    Without a body about its z axis, as DAMIT has it: R = Rz(lambda) Ry(90 deg - beta) Rz(phi0).
    """
    rate = 2.0 * math.pi / validation.positive(P, "P", unit="s")
    phi0 = conventions.known_angle(phi0, "phi0")
    if body is None:
        wxyz = conventions.pole_wxyz(conventions.known_pole(pole))
        wxyz = quaternion.multiply(wxyz, conventions.euler_wxyz(phi0, 0.0, 0.0))
        return wxyz, np.array([0.0, 0.0, rate])
    return (
        _attitude(body, "S", pole, (phi0, 0.0, 0.0)),
        conventions.axes(body, "S")[:, 2] * rate,
    )


def _ascending(body):
    return body.moments[conventions.order(body)]


def _state(body, mode, convention, position, momentum, pole, phi0, psi0, theta_branch):
    """From where D lies (its part of the way from the separatrix, and the rest) and |L|."""
    phi, psi = conventions.known_angle(phi0, "phi0"), conventions.known_angle(psi0, "psi0")
    theta = _theta(_ascending(body), mode, convention, position, psi, theta_branch)
    moments = conventions.moments(body, convention)
    rates = conventions.momentum_direction(theta, psi) * (momentum / moments)
    found = regimes(moments, rates)
    turns, unit_period = dynamic_inertia.cycle(_ascending(body), mode, position)
    if not abs(found.P_psi * momentum / unit_period - 1.0) <= _LOST:
        raise AttitudeError(
            f"the motion asked for is so near to the separatrix (P_psi is {turns:.4g} times "
            "P_phi_L) that rates in double precision cannot hold it. Give rates instead."
        )
    attitude = _attitude(body, convention, pole, (phi, theta, psi))
    return attitude, conventions.axes(body, convention) @ rates


def _attitude(body, convention, pole, angles):
    turn = quaternion.multiply(
        conventions.pole_wxyz(conventions.known_pole(pole)), conventions.euler_wxyz(*angles)
    )
    return quaternion.multiply(turn, quaternion.conjugate(conventions.axes_wxyz(body, convention)))


def _theta(moments, mode, convention, position, psi, branch):
    """theta from psi: sine and cosine squared as sums of terms of one sign, where it circulates."""
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
