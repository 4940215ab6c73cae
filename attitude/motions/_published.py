"""Convert spin states in the form of papers to attitude and angular velocity, and back.

Observers publish the direction of the momentum (the pole), two periods, ratios of the moments and
angles at an epoch.  Their meaning depends on the labels of the axes (`_conventions`)
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
from functools import partial
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from attitude._solver.regime import Mode, known_convention, regimes
from attitude._support import markup, validation
from attitude._support.arrays import Immutable, frozen, read_only
from attitude._support.quantity_text import of_time
from attitude.errors import AttitudeError
from attitude.frames import quaternion
from attitude.motions import _conventions
from attitude.motions._body import TRIANGLE, Body

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from numpy.typing import ArrayLike

    from attitude._solver.regime import Regime
    from attitude._support.annotations import BoolArray, FloatArray, IntArray, Real, Reals
    from attitude.epochs._instants import Instant


# ---- The dynamic inertia D = L^2/2E from two periods, or from the energy
# D is given by its position, the pair (y, 1 - y), both to full precision: y is 0 at the middle
# moment, which is the separatrix, and 1 at the moment of the axis about which the momentum
# circulates.  P_psi / P_phi decreases with y, from infinity to a limit, so that there is one
# position or none.

_MODES: dict[str | Mode, str] = {
    "LAM": "LAM",
    "SAM": "SAM",
    Mode.LONG_AXIS: "LAM",
    Mode.SHORT_AXIS: "SAM",
}
_ROUNDING = 1e-14


def known_mode(mode: str | Mode | None) -> str:
    """The mode as "LAM" or "SAM"; AttitudeError for any other mode or text."""
    word = mode.upper() if isinstance(mode, str) else mode
    if word in _MODES:
        return _MODES[word]
    raise AttitudeError(
        f'mode is {mode!r}; give "LAM" (long-axis mode) or "SAM" (short-axis mode), or Mode.'
        "LONG_AXIS or Mode.SHORT_AXIS. The mode is required: in the other mode the same two "
        "periods belong to another state."
    )


def refuse_rest(regime: Regime) -> None:
    """AttitudeError for a body at rest."""
    if regime.mode is Mode.AT_REST:
        raise AttitudeError(
            "the body is at rest; without angular momentum there is no pole, no period and no "
            "angle to publish."
        )


def possible(moments: Reals, P_psi: Real, P_phi: Real) -> list[tuple[str, str]]:
    """The combinations of mode and convention in which a motion has these periods.

    Parameters
    ----------
    moments : (3,) array_like
        Principal moments in any order; of any unit, or relative.
    P_psi, P_phi : float, Quantity or str
        Plain numbers in one unit, others with theirs.

    Returns
    -------
    list of (mode, convention)

    >>> possible((0.61, 0.965, 1.0), 263.0, 27.38)
    [('LAM', 'L'), ('LAM', 'S'), ('SAM', 'L'), ('SAM', 'S')]
    """
    moments = np.sort(validation.real(moments, "moments", shape=(3,), unit="kg m2"))
    P_psi = validation.positive(P_psi, "P_psi", unit="s")
    P_phi = validation.positive(P_phi, "P_phi", unit="s")
    pairs_of = []
    for mode in ("LAM", "SAM"):
        for convention in ("L", "S"):
            if _exists(moments, mode):
                ratio = P_psi / P_phi - (convention == "S")
                if not math.isnan(_solved(moments, mode, ratio)[0]):
                    pairs_of.append((mode, convention))
    return pairs_of


def longest_P_phi(moments: ArrayLike, mode: str | Mode, convention: str, P_psi: float) -> float:
    """The longest mean P_phi, in units of P_psi, that of rotation about the axis."""
    turns, _ = cycle(moments, known_mode(mode), (1.0, 0.0))
    return P_psi / (turns + (known_convention(convention) == "S"))


def moments_from_ratios(A_over_C: Real, B_over_C: Real) -> FloatArray:
    """Relative moments (A, B, C = 1) from published ratios; AttitudeError if no body has them.

    >>> moments_from_ratios(0.61, 0.965)
    array([0.61 , 0.965, 1.   ])
    """
    a, b = validation.number(A_over_C, "A_over_C"), validation.number(B_over_C, "B_over_C")
    if not 0.0 < a <= b <= 1.0:
        raise AttitudeError(
            f"A/C is {a:.9g} and B/C is {b:.9g}; moments in the order A <= B <= C have 0 < A/C <= "
            "B/C <= 1. Check which axis is which."
        )
    if a + b < 1.0:
        raise AttitudeError(
            f"A/C is {a:.9g} and B/C is {b:.9g}; no body has a moment that exceeds the sum of the "
            f"other two: A/C must be at least {1.0 - b:.9g} for this B/C."
        )
    return np.array([a, b, 1.0])


def _exists(moments, mode):
    """Whether bodies with these moments, ascending, have motions in a mode."""
    a, b, c = moments
    return a > 0.0 and (b > a if mode == "LAM" else c > b)


def refuse_missing_mode(moments: FloatArray, mode: str) -> None:
    """AttitudeError if a body with these moments (3,), ascending, has no motion in the mode."""
    if not _exists(moments, mode):
        listed = ", ".join(f"{moment:.9g}" for moment in moments)
        why = "the least two are equal" if mode == "LAM" else "the greatest two are equal"
        if moments[0] == 0.0:
            why = "the least is zero"
        raise AttitudeError(
            f"a body with the moments {listed} has no {mode}: {why}. "
            + ("Give another mode." if moments[2] > moments[0] > 0.0 else "Give rates instead.")
        )


def places_of_dynamic_inertia(
    moments: FloatArray, long_axis: BoolArray, ratios: FloatArray
) -> FloatArray:
    """y, 1 - y and P_psi for a momentum of 1, (N, 3), of moments (N, 3), ascending; long_axis and
    ratios P_psi / P_phi_L (N,); NaN where no motion has the ratio.
    """
    from attitude._solver.regime_loops import positions_all

    out = np.empty((len(ratios), 3))
    positions_all(moments, long_axis, ratios, out)
    return out


def _solved(moments: ArrayLike, mode: str, ratio: float) -> FloatArray:
    """The position (3,) of `places` of one body, in a mode."""
    return places_of_dynamic_inertia(
        np.array([moments], dtype=float),
        np.array([mode == "LAM"]),
        np.array([ratio], dtype=float),
    )[0]


def cycle(moments: ArrayLike, mode: str, position: Sequence[float]) -> FloatArray:
    """P_psi / P_phi_L at (y, 1 - y) of ascending moments (3,), and P_psi for a momentum of 1."""
    from attitude._solver.regime_loops import cycles_all

    out = np.empty((1, 2))
    y, one_minus_y = (np.array([number], dtype=float) for number in position)
    cycles_all(np.array([moments], dtype=float), np.array([mode == "LAM"]), y, one_minus_y, out)
    return out[0]


def dynamic_inertia_from_periods(
    moments: FloatArray, mode: str, convention: str, P_psi: float, P_phi: float
) -> FloatArray:
    """The position (y, 1 - y) of two periods, and P_psi for a momentum of 1; moments (3,)."""
    ratio = P_psi / P_phi - (convention == "S")
    place = _solved(moments, mode, ratio)
    if not math.isnan(place[0]):
        return place
    longest = longest_P_phi(moments, mode, convention, P_psi)
    if P_phi <= longest:
        raise AttitudeError(
            f"P_psi is {P_psi / P_phi:.6g} times P_phi; such a motion is nearer to the separatrix "
            "than double precision resolves. Give rates instead."
        )
    others = possible(moments, P_psi, P_phi)
    listed = ", ".join(f"{other_mode} with {labels}" for other_mode, labels in others)
    raise AttitudeError(
        f"P_phi is {P_phi:.9g} s and P_psi is {P_psi:.9g} s; with these moments in {mode}, "
        f'convention "{convention}", P_phi can be {longest:.9g} s at the most for this P_psi. '
        + (
            f"A motion with these periods exists in: {listed}."
            if others
            else "No other mode or convention has a motion with these periods: check the moments."
        )
    )


def dynamic_inertia_from_energy(
    moments: FloatArray, energy_ratio: Real, mode: str | Mode | None = None
) -> tuple[str, tuple[float, float]]:
    """Mode and position (y, 1 - y) for E/E0 = 2 E C / L^2; moments (3,), ascending."""
    a, b, c = moments
    ratio = validation.number(energy_ratio, "energy_ratio")
    if a == 0.0 or a == c:
        raise AttitudeError(
            "the energy does not determine the motion of a sphere or of a rod; give rates instead."
        )
    if not 1.0 <= ratio <= c / a * (1.0 + _ROUNDING):
        raise AttitudeError(
            f"energy_ratio is {ratio:.9g}; 2 E C / L^2 of this body lies between 1 (rotation about "
            f"the short axis) and {c / a:.9g} (about the long axis)."
        )
    mode_of_energy = "SAM" if b * ratio < c else "LAM"
    if mode is not None and known_mode(mode) != mode_of_energy:
        low, high = {"SAM": (1.0, c / b), "LAM": (c / b, c / a)}[known_mode(mode)]
        raise AttitudeError(
            f"mode is {known_mode(mode)}, but energy_ratio {ratio:.9g} belongs to "
            f"{mode_of_energy}: with these moments {known_mode(mode)} has {low:.9g} to {high:.9g}."
        )
    # C - D = C (ratio - 1) / ratio and so on: no difference is formed by subtracting D.
    if b * ratio < c:
        share = c * (ratio - 1.0) / (ratio * (c - b))
        return "SAM", ((c - b * ratio) / (ratio * (c - b)), share)
    if b * ratio > c:
        share = max(c - a * ratio, 0.0) / (ratio * (b - a))
        return "LAM", ((b * ratio - c) / (ratio * (b - a)), share)
    raise AttitudeError(
        f"energy_ratio is {ratio:.9g}, exactly C/B: on the separatrix there are no periods. Give "
        "angles and rates instead."
    )


# ---- States of many bodies from two periods, pole and angles: one compiled pass for any number
# `Spin.from_periods` and its relatives are the case of one body.

_BRANCHES = {"acute": 1, "obtuse": 2}  # ACUTE and OBTUSE of attitude._solver.vectors
# Relative error of the period of the state found, above which the state is refused.
_LOST = 1e-6
# The rates are rounded to 1e-16 and D - B is y (C - B) or y (B - A): for y above this bound the
# error of the period is below _LOST, as the error of 1 - m is at most 1e-16 / y of it.
_NEAR = 1e-7
_BODY_AXES = np.eye(3)[None]
_IN_ORDER = np.arange(3)[None]


class Labels(NamedTuple):
    """Moments, axes, mode and convention of N bodies, as the compiled solution takes them."""

    moments: FloatArray  # (N, 3), ascending
    order: IntArray  # (N, 3), indices of the principal moments, ascending
    axes: FloatArray  # (1 or N, 3, 3), principal axes as columns over the body axes
    long_axis: BoolArray  # (N,), whether the mode is "LAM"
    long_labels: BoolArray  # (N,), whether the convention is "L"
    branches: IntArray  # (N,), 0 without theta_branch, else 1 for "acute", 2 for "obtuse"

    @classmethod
    def of(
        cls, body: Body | None, convention: str, mode: str | None = None, branch: str | None = None
    ) -> Labels:
        """Those of one body, of known mode, convention and branch."""
        if body is None:
            moments, order, axes = np.ones((1, 3)), _IN_ORDER, _BODY_AXES
        else:
            order = _conventions.order(body)[None]
            moments, axes = body.moments[order[0]][None], body.principal_axes[None]
        known = 0 if branch is None else _BRANCHES[branch]
        flags = np.array([[mode == "LAM"], [convention == "L"]])
        return cls(moments, order, axes, flags[0], flags[1], np.array([known]))

    def states(self, angles: FloatArray, rates: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Attitudes (N, 4) and angular velocities (N, 3); angles (N, 5) rad, rates (N, 3)."""
        from attitude._solver.vectors import states_all

        wxyz, omega = np.empty((len(rates), 4)), np.empty((len(rates), 3))
        order, axes = read_only(np.ascontiguousarray(self.order)), np.array(self.axes)
        states_all(axes, order, self.long_labels, angles, rates, np.empty((3, 3)), wxyz, omega)
        return wxyz, omega

    def rates(self, places: FloatArray, momenta: FloatArray, angles: FloatArray) -> FloatArray:
        """Rates (N, 3), rad/s, labelled axes, of momenta (N,); theta, filled into angles (N, 5)."""
        from attitude._solver.vectors import rates_all

        rates = np.empty((len(places), 3))
        rates_all(
            self.moments,
            self.long_axis,
            self.long_labels,
            self.branches,
            places,
            momenta,
            angles,
            rates,
        )
        return rates

    def lost(self, places: FloatArray, rates: FloatArray, P_psi: FloatArray) -> BoolArray:
        """Whether (N,) rates in double precision do not determine P_psi, near the separatrix."""
        lost = np.zeros(len(rates), dtype=bool)
        closest = np.flatnonzero((places[:, 0] < _NEAR) & np.isfinite(rates[:, 0]))
        if len(closest):
            a, b, c = self.moments[closest].T
            long = self.long_labels[closest]
            labelled = np.where(long, (b, c, a), (a, b, c)).T
            lost[closest] = ~(
                np.abs(regimes(labelled, rates[closest]).P_psi / P_psi[closest] - 1.0) <= _LOST
            )
        return lost


def states_from_two_periods(
    body: Body | None,
    *,
    pole: Reals,
    phi0: Real,
    mode: str | Mode | None = None,
    convention: str | None = None,
    P_psi: Real | None = None,
    P_phi: Real | None = None,
    psi0: Real | None = None,
    theta_branch: str | None = None,
    P: Real | None = None,
) -> tuple[FloatArray, FloatArray]:
    """Attitude and angular velocity from two periods, or one; see `Spin.from_periods`."""
    if P is not None:
        if any(
            argument is not None
            for argument in (mode, convention, P_psi, P_phi, psi0, theta_branch)
        ):
            raise AttitudeError(
                "P is the one period of a relaxed rotator; leave out mode, convention, P_psi, "
                "P_phi, psi0 and theta_branch, or give P_psi and P_phi."
            )
        # About the short axis, or z: R = Rz(lambda) Ry(90 deg - beta) Rz(phi0).
        rate = 2.0 * math.pi / validation.positive(P, "P", unit="s")
        phi = _conventions.known_angle(phi0, "phi0")
        known = _conventions.known_pole(pole)
        return from_labelled(body, "S", (*known, phi, 0.0, 0.0), (0.0, 0.0, rate))
    if mode is None or convention is None or P_psi is None or P_phi is None or psi0 is None:
        raise _missing(mode=mode, convention=convention, P_psi=P_psi, P_phi=P_phi, psi0=psi0)
    if body is None:
        raise AttitudeError("body is None; give a Body, or one period P for a rotator about z.")
    mode, convention = known_mode(mode), known_convention(convention)
    P_psi = validation.positive(P_psi, "P_psi", unit="s")
    P_phi = validation.positive(P_phi, "P_phi", unit="s")
    moments = _conventions.moments(body, "S")
    refuse_missing_mode(moments, mode)
    place = dynamic_inertia_from_periods(moments, mode, convention, P_psi, P_phi)
    return from_place(
        body, mode, convention, place, P_psi, pole, phi0, psi0, theta_branch=theta_branch
    )


def from_place(
    body: Body,
    mode: str,
    convention: str,
    place: FloatArray,
    P_psi: float,
    pole: Reals,
    phi0: Real,
    psi0: Real,
    *,
    theta_branch: str | None,
) -> tuple[FloatArray, FloatArray]:
    """Attitude (4,) and rates (3,) from the place of D and P_psi in s.

    `place` (3,) is y, 1 - y and P_psi for a momentum of 1; the others as in `Spin.from_periods`.
    """
    angles = np.empty((1, 5))
    angles[0, 2] = _conventions.known_angle(phi0, "phi0")
    angles[0, 4] = psi = _conventions.known_angle(psi0, "psi0")
    labels = Labels.of(body, convention, mode, _known_branch(theta_branch, mode, convention))
    places = np.array([place])
    rates = labels.rates(places, places[:, 2] / P_psi, angles)
    if math.isnan(rates[0, 0]):
        raise AttitudeError(_beyond(psi, mode, convention, labels.moments[0], place))
    if labels.lost(places, rates, np.array([P_psi]))[0]:
        turns, _ = cycle(labels.moments[0], mode, (place[0], place[1]))
        raise AttitudeError(
            f"the motion is so near to the separatrix (P_psi is {turns:.4g} times P_phi_L) that "
            "rates in double precision do not determine its period. Give rates instead."
        )
    angles[0, :2] = _conventions.known_pole(pole)
    wxyz, omega = labels.states(angles, rates)
    return wxyz[0], omega[0]


def from_labelled(
    body: Body | None, convention: str, angles: Sequence[float], rates: Sequence[float] | FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Attitude (4,) and rates (3,) over the body axes from those of the labelled axes.

    `angles` (5,) are longitude and latitude of the pole, phi, theta and psi, rad; `rates` (3,) are
    rad/s.  Without a body its axes are the labelled ones of "S".
    """
    labels = Labels.of(body, convention)
    wxyz, omega = labels.states(np.array([angles], dtype=float), np.array([rates], dtype=float))
    return wxyz[0], omega[0]


def _missing(**keywords: object) -> AttitudeError:
    """The error that names the keywords that are None."""
    missing = [name for name, value in keywords.items() if value is None]
    return AttitudeError(
        f"{', '.join(missing)} {'is' if len(missing) == 1 else 'are'} missing; give mode "
        '("LAM" or "SAM"), convention ("L" or "S"), P_psi, P_phi and psi0, or one period P for '
        "a relaxed rotator."
    )


def _known_branch(branch: Any, mode: str, convention: str) -> str | None:
    """ "acute", "obtuse" or None; AttitudeError for None where psi librates, and for others."""
    if branch in _BRANCHES or (branch is None and (mode == "LAM") == (convention == "L")):
        return branch
    if branch is None:
        raise AttitudeError(
            f'psi librates in {mode} with convention "{convention}", where one psi0 belongs to two '
            'states; give theta_branch="acute" (theta0 up to 90 deg) or "obtuse".'
        )
    raise AttitudeError(f'theta_branch is {branch!r}; give "acute" or "obtuse" (theta0 > 90 deg).')


def _beyond(psi: float, mode: str, convention: str, moments: FloatArray, place: FloatArray) -> str:
    """The error text for a psi0 outside of its libration."""
    a, b, c = moments
    y, one_minus_y = place[0], place[1]
    # "L" in short-axis mode: C - D over D - B; "S" in long-axis mode: D - A over B - D
    outer, center = (c, (0, 180)) if convention == "L" else (a, (90, 270))
    largest = math.atan2(math.sqrt(one_minus_y / outer), math.sqrt(y / b))
    return (
        f"psi0 is {math.degrees(psi):.6g} deg; in {mode} with convention "
        f'"{convention}" psi librates within {math.degrees(largest):.6g} deg of {center[0]} or '
        f"{center[1]} deg. Give such an angle, or check convention and periods."
    )


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
    period : float
        s, of uniform rotation about a principal axis, whose P_psi and P_phi are limits for small
        nutations; NaN of other motions.
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
    period: float = math.nan

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
        uniform = ""
        if self.period > 0.0:
            uniform = (
                f"  uniform rotation about a principal axis, period {of_time(self.period, 9)}; "
                "of small nutations:\n"
            )
        return (
            f"{self.mode or 'neither mode'}, convention {self.convention}, {self.frame}, "
            f"{self.epoch.utc_iso} UTC\n{uniform}"
            f"  P_psi {of_time(self.P_psi, 9)}, P_phi {of_time(self.P_phi, 9)}\n"
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
    refuse_rest(regime)
    axes = _conventions.axes(body, convention)
    momentum = axes.T @ (body.tensor @ (angular_velocity / np.max(np.abs(angular_velocity))))
    attitude = quaternion.multiply(wxyz, _conventions.axes_wxyz(body, convention))
    pole, phi, theta, psi = _conventions.angles_of(attitude, momentum)
    a, b, c = _conventions.moments(body, "S")
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
        period=2.0 * math.pi / float(np.linalg.norm(angular_velocity))
        if regime.mode == Mode.PRINCIPAL_AXIS
        else math.nan,
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
    moments = _conventions.moments(body, "S")
    mode_of_energy, position = dynamic_inertia_from_energy(moments, energy_ratio, mode)
    turns, unit_period = cycle(moments, mode_of_energy, position)
    if P_psi is not None:
        seconds = validation.positive(P_psi, "P_psi", unit="s")
    else:
        assert P_phi is not None
        turns = turns if convention == "L" else turns + 1.0
        seconds = turns * validation.positive(P_phi, "P_phi", unit="s")
    place = np.array([*position, unit_period])
    return from_place(
        body,
        mode_of_energy,
        convention,
        place,
        seconds,
        pole,
        phi0,
        psi0,
        theta_branch=theta_branch,
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
    phi = _conventions.known_angle(phi0, "phi0")
    moments = _conventions.moments(body, convention)
    if angular_velocity is not None:
        if not all(argument is None for argument in (theta0, psi0, P_psi, P_phi)):
            raise AttitudeError(
                "with angular_velocity, theta0, psi0 and the periods follow; leave them out."
            )
        rate = validation.real(angular_velocity, "angular_velocity", shape=(3,), unit="rad/s")
        if not np.any(rate):
            raise AttitudeError("angular_velocity is zero; a body at rest has no pole.")
        axes = _conventions.axes(body, convention)
        x, y, z = axes.T @ (body.tensor @ (rate / np.max(np.abs(rate))))
        theta, psi = math.atan2(math.hypot(x, y), z), math.atan2(x, y)
        angles = (*_conventions.known_pole(pole), phi, theta, psi)
        return from_labelled(body, convention, angles, (0.0, 0.0, 0.0))[0], rate
    if theta0 is None or psi0 is None or (P_psi is None) == (P_phi is None):
        raise AttitudeError(
            "a pole and phi0 do not determine the state; give either angular_velocity, or theta0 "
            "and psi0 with one of P_psi and P_phi."
        )
    theta, psi = _conventions.known_tilt(theta0, "theta0"), _conventions.known_angle(psi0, "psi0")
    if np.any(moments == 0.0):
        raise AttitudeError("one moment is zero; for a rod give angular_velocity.")
    rates = _conventions.momentum_direction(theta, psi) * (moments.max() / moments)
    periods = regimes(moments, rates)
    name, value, period = "P_psi", P_psi, periods.P_psi
    if P_psi is None:
        name, value, period = "P_phi", P_phi, periods.P_phi(convention)
    assert value is not None
    seconds = validation.positive(value, name, unit="s")
    if not math.isfinite(period):
        raise AttitudeError(
            f"with theta0 and psi0 the state is {periods.mode.phrase}, where {name} is infinite; "
            "give the other period."
        )
    angles = (*_conventions.known_pole(pole), phi, theta, psi)
    return from_labelled(body, convention, angles, rates * (period / seconds))


def from_angles(
    body: Body, *, convention: str, angles: Reals, angular_velocity: Reals
) -> tuple[FloatArray, FloatArray]:
    """Attitude (4,) and angular velocity (3,) from labelled axes; see `Spin.from_angles`."""
    phi, theta, psi = validation.real(angles, "angles", shape=(3,), unit="rad")
    _conventions.known_angle(phi, "the first angle")
    _conventions.known_tilt(theta, "the second angle")
    _conventions.known_angle(psi, "the third angle")
    rate = validation.real(angular_velocity, "angular_velocity", shape=(3,), unit="rad/s")
    to_frame = (0.0, 0.5 * math.pi)  # a pole that turns nothing
    return from_labelled(body, known_convention(convention), (*to_frame, phi, theta, psi), rate)


# ---- States of many bodies from arrays of published numbers: `states_from_periods`

# So many members, some 50 ms of work, are computed together: Python acts on signals, such as that
# of Ctrl-C, between two blocks.
_BLOCK = 8192
# Names of the numbers with their units, one for each member.
_NUMBERS = {"P_psi": "s", "P_phi": "s", "P": "s", "phi0": "rad", "psi0": "rad"}
_UNKNOWN = -1


class PeriodStates(Immutable):
    """States of N bodies; made by `states_from_periods`.

    Attributes
    ----------
    wxyz : (N, 4) array
        Body axes to the frame of the pole, scalar first.
    angular_velocity : (N, 3) array
        rad/s over the body axes.
    bad : (N,) array of bool
        Members for which no motion has the numbers given; their rows are NaN.
    """

    wxyz: FloatArray
    angular_velocity: FloatArray
    bad: BoolArray

    def __init__(
        self,
        wxyz: FloatArray,
        angular_velocity: FloatArray,
        bad: BoolArray,
        again: Callable[[int], object],
    ) -> None:
        self._again: Callable[[int], object]
        for array in (wxyz, angular_velocity, bad):
            frozen(array)
        self._set_all(wxyz=wxyz, angular_velocity=angular_velocity, bad=bad, _again=again)

    def reason(self, k: int) -> str:
        """Why member k is bad, as the sentence of `Spin.from_periods`; "" for a good one."""
        if not self.bad[k]:
            return ""
        try:
            self._again(int(k))
        except AttitudeError as err:
            return str(err)
        return "no motion has these numbers."


def states_from_periods(
    moments: Reals | Body | None,
    *,
    pole: Reals,
    phi0: Reals,
    mode: Any = None,
    convention: Any = None,
    P_psi: Reals | None = None,
    P_phi: Reals | None = None,
    psi0: Reals | None = None,
    theta_branch: Any = None,
    P: Reals | None = None,
    principal_axes: FloatArray | None = None,
    names: Sequence[object] | None = None,
    on_error: str = "raise",
) -> PeriodStates:
    """States of N bodies from published spin states, each as by `Spin.from_periods`.

    Parameters
    ----------
    moments : (3,) or (N, 3) array_like, Body, or None
        Principal moments, of any unit, in any order.  None, with P alone: rotators about z.
    pole : (2,) or (N, 2) array_like
        Longitude and latitude of the momentum, rad or Quantities.
    phi0, psi0, P_psi, P_phi, P : one number, or (N,) array_like
        rad and s, or Quantities.  A member whose P is a number is a relaxed rotator; its P_psi,
        P_phi and psi0, if given for other members, are NaN.
    mode, convention, theta_branch : one value, or (N,) array_like
        As in `Spin.from_periods`; of relaxed rotators they are not read.
    principal_axes : (3, 3) or (N, 3, 3) array, optional
        Columns: the principal axes of `moments` over the body axes; by default the body axes.
    names : sequence of N, optional
        Names of the members in error messages, in place of their numbers.
    on_error : "raise" or "nan"
        Whether the first member that is bad is an error, or has NaN in its rows.

    Returns
    -------
    PeriodStates

    Raises
    ------
    AttitudeError
        For shapes that do not fit, and for bad members unless on_error="nan".

    Notes
    -----
    One member costs some 7 us (benchmarks/ensembles_setup.py).

    >>> found = states_from_periods(
    ...     [(0.61, 0.965, 1.0), (0.5, 0.9, 1.0)], mode="SAM", convention=["S", "L"],
    ...     P_psi=[9.5e5, 4.0e4], P_phi=1.0e4, pole=(4.4, -1.3), phi0=0.0, psi0=0.0,
    ...     theta_branch="acute",
    ... )
    >>> found.wxyz.shape, found.bad.tolist()
    ((2, 4), [False, False])
    """
    on_error = validation.one_of(on_error, "on_error", ("raise", "nan"))
    numbers_given = {"phi0": phi0, "psi0": psi0, "P_psi": P_psi, "P_phi": P_phi, "P": P}
    numbers = {
        name: np.array(math.nan)
        if value is None
        else validation.real(value, name, unit=_NUMBERS[name], finite=False)
        for name, value in numbers_given.items()
    }
    numbers["moments"], order, axes = _bodies(moments, principal_axes)
    numbers["pole"] = _poles(pole)
    words = {
        "mode": _codes(mode, known_mode, ("SAM", "LAM")),
        "convention": _codes(convention, known_convention, ("S", "L")),
        "theta_branch": _codes(theta_branch, _branch_of_row, ("", "acute", "obtuse")),
    }
    count = _count({**numbers, **words, "axes": axes})
    rows = {
        name: np.broadcast_to(array, (count, *array.shape[1:]))
        if array.ndim
        else np.full(count, array)
        for name, array in {**numbers, **words}.items()
    }
    order = np.broadcast_to(order, (count, 3))
    wxyz, omega = np.empty((count, 4)), np.empty((count, 3))
    bad = np.empty(count, dtype=bool)
    for first in range(0, count, _BLOCK):
        block = slice(first, min(first + _BLOCK, count))
        turned = axes[block] if len(axes) > 1 else axes
        some = {name: array[block] for name, array in rows.items()}
        wxyz[block], omega[block], bad[block] = _block(some, order[block], turned)
    shared = {"mode": mode, "convention": convention, "theta_branch": theta_branch}
    states = PeriodStates(wxyz, omega, bad, partial(_again, moments, rows, shared))
    if on_error == "raise" and bad.any():
        k = int(np.flatnonzero(bad)[0])
        name = f"Member {k} of {count}" if names is None else f"Member {names[k]!r}"
        raise AttitudeError((f"{name}: " if count > 1 else "") + states.reason(k))
    return states


def _block(
    rows: dict[str, Any], order: Any, axes: FloatArray
) -> tuple[FloatArray, FloatArray, BoolArray]:
    """Attitudes, angular velocities and the mask of bad members of one block."""
    relaxed = ~np.isnan(rows["P"])
    moments = np.ascontiguousarray(np.take_along_axis(rows["moments"], order, axis=-1))
    tumbling = _possible(rows, moments, relaxed)
    P_psi, P_phi = (np.where(tumbling, rows[name], 1.0) for name in ("P_psi", "P_phi"))
    long_labels = (rows["convention"] == 1) & ~relaxed
    labels = Labels(
        moments,
        order,
        axes,
        long_axis=(rows["mode"] == 1) & ~relaxed,
        long_labels=long_labels,
        branches=np.maximum(rows["theta_branch"], 0),
    )
    with np.errstate(over="ignore"):
        ratios = np.where(tumbling, P_psi / P_phi - ~long_labels, np.nan)
    places = places_of_dynamic_inertia(moments, labels.long_axis, ratios)
    angles = np.zeros((len(moments), 5))
    angles[:, :2], angles[:, 2] = rows["pole"], rows["phi0"]
    angles[:, 4] = np.where(relaxed, 0.0, rows["psi0"])
    rates = labels.rates(places, places[:, 2] / P_psi, angles)
    rates[labels.lost(places, rates, P_psi)] = np.nan
    if relaxed.any():
        _relax(relaxed, rows, rates, angles)
    rates[~_in_range(angles)] = np.nan
    wxyz, omega = labels.states(angles, rates)
    bad = np.isnan(rates[:, 0])
    wxyz[bad] = omega[bad] = np.nan
    return wxyz, omega, bad


def _possible(rows, moments, relaxed):
    """Members (N,) whose periods, mode and moments are those of a tumbling body, as far as seen."""
    a, b, c = moments.T
    allowed = (
        ~relaxed & (rows["mode"] >= 0) & (rows["convention"] >= 0) & (rows["theta_branch"] >= 0)
    )
    for name in ("P_psi", "P_phi"):
        allowed &= (rows[name] > 0.0) & (rows[name] < math.inf)
    with np.errstate(invalid="ignore"):
        allowed &= (a > 0.0) & (c < math.inf) & (c - a - b <= TRIANGLE * c)
    return allowed


def _relax(relaxed, rows, rates, angles):
    """Fill rates and theta of relaxed rotators; NaN where P is not positive or not alone."""
    P = rows["P"]
    fine = (P > 0.0) & (math.inf > P)
    for name in ("P_psi", "P_phi", "psi0"):
        fine &= np.isnan(rows[name])
    with np.errstate(divide="ignore", invalid="ignore"):
        spin = np.where(fine, 2.0 * math.pi / P, np.nan)
    rates[relaxed] = 0.0
    rates[relaxed, 2] = spin[relaxed]
    rates[relaxed & ~fine] = np.nan
    angles[relaxed, 3] = 0.0


def _in_range(angles):
    """Whether pole, phi and psi (N,) are within the ranges that `_conventions` allows."""
    turn, quarter = _conventions.TURN, _conventions.QUARTER
    with np.errstate(invalid="ignore"):
        fine = np.abs(angles) <= (turn, quarter, turn, math.inf, turn)
    return fine.all(axis=1)


def _bodies(moments: Any, principal_axes: Any) -> tuple[FloatArray, Any, FloatArray]:
    """Moments (M, 3), the order (M, 3) of them, and axes (M', 3, 3); M, M' are 1 or N."""
    if isinstance(moments, Body):
        if principal_axes is not None:
            raise AttitudeError("a Body has its principal axes; leave out principal_axes.")
        order = _conventions.order(moments)[None]
        return moments.moments[None], order, moments.principal_axes[None]
    if moments is None:
        known = np.ones((1, 3))
    else:
        known = validation.real(moments, "moments", shape=(..., 3), unit="kg m2", finite=False)
        known = known.reshape(1, 3) if known.ndim == 1 else known
    axes = np.eye(3)
    if principal_axes is not None:
        axes = validation.real(principal_axes, "principal_axes", shape=(..., 3, 3))
    return known, np.argsort(known, axis=-1, kind="stable"), axes.reshape(-1, 3, 3)


def _poles(pole: Any) -> FloatArray:
    """Poles (1 or N, 2) in rad; a pair of values may have different units."""
    if isinstance(pole, (list, tuple)) and len(pole) == 2 and np.ndim(pole[0]) == 0:
        return np.array([[validation.number(angle, "pole", unit="rad") for angle in pole]])
    poles = validation.real(pole, "pole", shape=(..., 2), unit="rad", finite=False)
    return poles.reshape(1, 2) if poles.ndim == 1 else poles


def _codes(value: Any, known: Callable[[Any], str], allowed: Sequence[str]) -> Any:
    """The numbers () or (N,) of words in `allowed`; _UNKNOWN for other words, and none."""
    numbers: dict[object, int] = {}

    def code(word: object) -> int:
        if word not in numbers:
            try:
                numbers[word] = allowed.index(known(word))
            except (AttitudeError, ValueError):
                numbers[word] = _UNKNOWN
        return numbers[word]

    if value is None or isinstance(value, (str, int)):
        return np.array(code(value))
    words = np.asarray(value, dtype=object)
    try:
        return np.array([code(word) for word in words.ravel().tolist()], int).reshape(words.shape)
    except TypeError as err:  # what cannot be hashed
        raise AttitudeError(
            f"mode, convention or theta_branch is {validation.shown(value)}; give words, one or "
            "one for each member."
        ) from err


def _branch_of_row(branch: Any) -> Any:
    """A branch of theta as it is, "" where it is None or NaN."""
    return "" if branch is None or branch != branch else branch


def _count(arrays: dict[str, Any]) -> int:
    """The number of members, to which all arrays broadcast."""
    inner = {"moments": 1, "pole": 1, "axes": 2}
    lengths = {
        name: array.shape[: array.ndim - inner.get(name, 0)] for name, array in arrays.items()
    }
    counts = {shape[0] for shape in lengths.values() if shape != () and shape[0] != 1}
    if len(counts) > 1 or any(len(shape) > 1 for shape in lengths.values()):
        listed = ", ".join(f"{name} {shape}" for name, shape in lengths.items() if shape != ())
        raise AttitudeError(
            f"the numbers of members differ ({listed}); give one value, or one for each of the N "
            "members."
        )
    return int(counts.pop()) if counts else 1


def _again(body: Any, rows: dict[str, Any], words: dict[str, Any], k: int) -> object:
    """`states_from_two_periods` for one member, which raises the error of a bad one."""
    if body is not None and not isinstance(body, Body):
        body = Body(moments=rows["moments"][k], relative=True)
    numbers = {name: float(rows[name][k]) for name in _NUMBERS}
    keywords: dict[str, Any] = {
        name: value for name, value in numbers.items() if not math.isnan(value)
    }
    if "P" not in keywords:
        keywords |= {name: _entry(array, k) for name, array in words.items()}
    keywords.setdefault("phi0", math.nan)
    return states_from_two_periods(body, pole=rows["pole"][k], **keywords)


def _entry(words: Any, k: int) -> Any:
    """Entry k of the words of the members, or the word of all of them; None for no word."""
    if words is None or isinstance(words, (str, int)):
        return words
    flat = np.asarray(words, dtype=object).ravel()
    word = flat[k if len(flat) > 1 else 0]
    return None if word == "" or word != word else word


# ---- Regular precession: spin and moments of a symmetric body from two periods and one angle
# Comets are often published as P_phi, P_psi and the angle theta between the axis of symmetry and
# the momentum, without moments; for a symmetric body the three numbers determine the motion.


def total_spin(*, mode: str | Mode, P_psi: Real, P_phi: Real, theta: Real) -> tuple[float, float]:
    """Period of the total angular velocity, and its angle to the momentum.

    Parameters
    ----------
    mode : "LAM" or "SAM"
        Prolate bodies rotate about their axis in the sense of its precession, oblate ones in the
        opposite sense.
    P_psi, P_phi : float or Quantity
        s; of the axis of symmetry: convention "L" in long-axis, "S" in short-axis mode.
    theta : float or Quantity
        rad, between the nearer end of the axis of symmetry and the momentum: below 90 deg.

    Returns
    -------
    period, angle : float
        s, rad.  w = phi' along the momentum + psi' along the axis.

    Raises
    ------
    AttitudeError
        For periods that are not positive, and an angle of 90 deg or more.

    The comet of Halley, whose total spin period is 2.84 d:

    >>> period, angle = total_spin(mode="LAM", P_psi="7.1 d", P_phi="3.69 d", theta="66 deg")
    >>> round(period / 86400.0, 3), round(math.degrees(angle), 2)
    (2.836, 21.4)
    """
    phi, psi, tilt = _rates(mode, P_psi, P_phi, theta)
    along, across = phi + psi * math.cos(tilt), psi * math.sin(tilt)
    return 1.0 / math.hypot(along, across), math.atan2(abs(across), along)


def symmetric_moments(*, mode: str | Mode, P_psi: Real, P_phi: Real, theta: Real) -> FloatArray:
    """Relative moments (3,), ascending, of the symmetric body with this precession.

    psi' = phi' cos theta (I / Iz - 1) for moments I, I, Iz.  Parameters as in `total_spin`.

    Raises
    ------
    AttitudeError
        If no body has such moments.

    >>> symmetric_moments(mode="LAM", P_psi="7.1 d", P_phi="3.69 d", theta="66 deg").round(4)
    array([0.439, 1.   , 1.   ])
    """
    phi, psi, tilt = _rates(mode, P_psi, P_phi, theta)
    ratio = psi / (phi * math.cos(tilt)) + 1.0  # I / Iz
    if not ratio >= 0.5:
        cosine = 2.0 * abs(psi) / phi
        if cosine > 1.0:
            raise AttitudeError(
                "no body in SAM that is symmetric about its axis has P_psi below twice P_phi; "
                "give other periods."
            )
        low = math.degrees(math.acos(cosine))
        raise AttitudeError(
            f"with theta {math.degrees(tilt):.6g} deg the moment about the axis would be "
            f"{1.0 / ratio:.6g} times the other two, but at most twice is possible: with these "
            f"periods give theta up to {low:.6g} deg."
        )
    return np.array([1.0 / ratio, 1.0, 1.0]) if ratio > 1.0 else np.array([ratio, ratio, 1.0])


def _rates(mode: str | Mode, P_psi: Real, P_phi: Real, theta: Real) -> tuple[float, float, float]:
    """phi' and psi' with its sign in turns per second, and theta in rad."""
    sign = 1.0 if known_mode(mode) == "LAM" else -1.0
    psi = sign / validation.positive(P_psi, "P_psi", unit="s")
    phi = 1.0 / validation.positive(P_phi, "P_phi", unit="s")
    tilt = _conventions.known_tilt(theta, "theta")
    if tilt >= 0.5 * math.pi:
        raise AttitudeError(
            f"theta is {math.degrees(tilt):.6g} deg; with 90 deg or more the rotation about the "
            "axis of symmetry has the opposite sense. Give the angle to the nearer end of the axis."
        )
    return phi, psi, tilt
