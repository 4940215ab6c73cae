"""States of many bodies from two periods, pole and angles: one compiled pass for any number.

`Spin.from_periods` and its relatives are the case of one body.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from attitude import validation
from attitude.body import Body
from attitude.errors import AttitudeError
from attitude.immutable import read_only
from attitude.published import conventions, dynamic_inertia
from attitude.regime import known_convention, regimes

if TYPE_CHECKING:
    from collections.abc import Sequence

    from attitude.annotations import BoolArray, FloatArray, IntArray, Real, Reals
    from attitude.regime import Mode

_BRANCHES = {"acute": 1, "obtuse": 2}  # ACUTE and OBTUSE of solution.labelled_axes
# Relative error of the period of the state found, above which the state is refused.
_LOST = 1e-6
# The rates are rounded to 1e-16 and D - B is y (C - B) or y (B - A): for y above this bound the
# error of the period is below _LOST, as the error of 1 - m is at most 1e-16 / y of it.
_NEAR = 1e-7
_BODY_AXES = np.eye(3)[None]
_IN_ORDER = np.arange(3)[None]


class Labels(NamedTuple):
    """Moments, axes, mode and convention of N bodies, as the compiled solution takes them.

    Attributes
    ----------
    moments : (N, 3) array
        Ascending.
    order : (N, 3) array
        Indices of the principal moments, ascending.
    axes : (1 or N, 3, 3) array
        Principal axes as columns over the body axes.
    long_axis, long_labels : (N,) arrays
        Whether the mode is "LAM", the convention "L".
    branches : (N,) array
        0 where theta_branch is not given, else 1 for "acute" and 2 for "obtuse".
    """

    moments: FloatArray
    order: IntArray
    axes: FloatArray
    long_axis: BoolArray
    long_labels: BoolArray
    branches: IntArray

    @classmethod
    def of(
        cls, body: Body | None, convention: str, mode: str | None = None, branch: str | None = None
    ) -> Labels:
        """Those of one body, of known mode, convention and branch."""
        if body is None:
            moments, order, axes = np.ones((1, 3)), _IN_ORDER, _BODY_AXES
        else:
            order = conventions.order(body)[None]
            moments, axes = body.moments[order[0]][None], body.principal_axes[None]
        known = 0 if branch is None else _BRANCHES[branch]
        flags = np.array([[mode == "LAM"], [convention == "L"]])
        return cls(moments, order, axes, flags[0], flags[1], np.array([known]))

    def states(self, angles: FloatArray, rates: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Attitudes (N, 4) and angular velocities (N, 3).

        Parameters
        ----------
        angles : (N, 5) array
            Longitude and latitude of the pole, phi, theta, psi, rad.
        rates : (N, 3) array
            rad/s over the labelled axes.

        Returns
        -------
        wxyz, angular_velocity : arrays
            Body axes to the frame of the pole; rad/s over the body axes.
        """
        from attitude.solution.labelled_axes import states_all

        wxyz, omega = np.empty((len(rates), 4)), np.empty((len(rates), 3))
        order, axes = read_only(np.ascontiguousarray(self.order)), np.array(self.axes)
        states_all(axes, order, self.long_labels, angles, rates, np.empty((3, 3)), wxyz, omega)
        return wxyz, omega

    def rates(self, places: FloatArray, momenta: FloatArray, angles: FloatArray) -> FloatArray:
        """Angular velocities (N, 3), rad/s over the labelled axes, and theta, filled into `angles`.

        Parameters
        ----------
        places : (N, >= 2) array
            y and 1 - y of the dynamic inertia.
        momenta : (N,) array
            Magnitudes of the momentum.
        angles : (N, 5) array
            Longitude and latitude of the pole, phi, theta (filled), psi, rad.

        Both results are NaN where psi librates and does not come so far, or the branch is unknown.
        """
        from attitude.solution.labelled_axes import rates_all

        rates = np.empty((len(places), 3))
        flags = self.long_axis, self.long_labels, self.branches
        rates_all(self.moments, *flags, places, momenta, angles, rates)
        return rates

    def lost(self, places: FloatArray, rates: FloatArray, P_psi: FloatArray) -> BoolArray:
        """Whether (N,) rates in double precision do not determine P_psi, near the separatrix."""
        lost = np.zeros(len(rates), dtype=bool)
        near = np.flatnonzero((places[:, 0] < _NEAR) & np.isfinite(rates[:, 0]))
        if len(near):
            a, b, c = self.moments[near].T
            long = self.long_labels[near]
            labelled = np.where(long, (b, c, a), (a, b, c)).T
            lost[near] = ~(
                np.abs(regimes(labelled, rates[near]).P_psi / P_psi[near] - 1.0) <= _LOST
            )
        return lost


def from_periods(
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
    """Attitude and angular velocity from two periods, or one; see `Spin.from_periods`.

    Returns
    -------
    wxyz (4,), angular_velocity (3,)
        Body axes to the frame of the pole; rad/s in body axes.
    """
    if P is not None:
        if any(each is not None for each in (mode, convention, P_psi, P_phi, psi0, theta_branch)):
            raise AttitudeError(
                "P is the one period of a relaxed rotator; leave out mode, convention, P_psi, "
                "P_phi, psi0 and theta_branch, or give P_psi and P_phi."
            )
        return _relaxed(body, P=P, pole=pole, phi0=phi0)
    if mode is None or convention is None or P_psi is None or P_phi is None or psi0 is None:
        raise _missing(mode=mode, convention=convention, P_psi=P_psi, P_phi=P_phi, psi0=psi0)
    if body is None:
        raise AttitudeError("body is None; give a Body, or one period P for a rotator about z.")
    mode, convention = dynamic_inertia.known_mode(mode), known_convention(convention)
    P_psi = validation.positive(P_psi, "P_psi", unit="s")
    P_phi = validation.positive(P_phi, "P_phi", unit="s")
    moments = body.moments[conventions.order(body)]
    dynamic_inertia.refuse_missing_mode(moments, mode)
    found = dynamic_inertia.from_periods(moments, mode, convention, P_psi, P_phi)
    return from_place(body, mode, convention, found, P_psi, pole, phi0, psi0, theta_branch)


def from_place(
    body: Body,
    mode: str,
    convention: str,
    place: FloatArray,
    P_psi: float,
    pole: Reals,
    phi0: Real,
    psi0: Real,
    theta_branch: str | None,
) -> tuple[FloatArray, FloatArray]:
    """Attitude (4,) and rates (3,) from the place of D and P_psi in s.

    `place` (3,) is y, 1 - y and P_psi for a momentum of 1; the others as in `Spin.from_periods`.
    """
    angles = np.empty((1, 5))
    angles[0, 2] = conventions.known_angle(phi0, "phi0")
    angles[0, 4] = psi = conventions.known_angle(psi0, "psi0")
    branch = _known_branch(theta_branch, mode, convention)
    labels = Labels.of(body, convention, mode, branch)
    places = np.array([place])
    rates = labels.rates(places, places[:, 2] / P_psi, angles)
    if math.isnan(rates[0, 0]):
        raise AttitudeError(_beyond(psi, mode, convention, labels.moments[0], place))
    if labels.lost(places, rates, np.array([P_psi]))[0]:
        turns, _ = dynamic_inertia.cycle(labels.moments[0], mode, (place[0], place[1]))
        raise AttitudeError(
            f"the motion is so near to the separatrix (P_psi is {turns:.4g} times P_phi_L) that "
            "rates in double precision do not determine its period. Give rates instead."
        )
    angles[0, :2] = conventions.known_pole(pole)
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
    given = np.array([angles], dtype=float), np.array([rates], dtype=float)
    wxyz, omega = labels.states(*given)
    return wxyz[0], omega[0]


def _relaxed(
    body: Body | None, *, P: Real, pole: Reals, phi0: Real
) -> tuple[FloatArray, FloatArray]:
    """Attitude (4,) and angular velocity (3,) of a relaxed rotator.

    About the short axis of the body, or with body=None about its z axis, as in DAMIT:
    R = Rz(lambda) Ry(90 deg - beta) Rz(phi0).
    """
    rate = 2.0 * math.pi / validation.positive(P, "P", unit="s")
    phi = conventions.known_angle(phi0, "phi0")
    known = conventions.known_pole(pole)
    return from_labelled(body, "S", (*known, phi, 0.0, 0.0), (0.0, 0.0, rate))


def _missing(**given: object) -> AttitudeError:
    """The error that names the keywords that are None."""
    missing = [name for name, value in given.items() if value is None]
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
    y, rest = place[0], place[1]
    if convention == "L":  # in short-axis mode: C - D over D - B
        largest, center = math.atan2(math.sqrt(rest / c), math.sqrt(y / b)), (0, 180)
    else:  # in long-axis mode: D - A over B - D
        largest, center = math.atan2(math.sqrt(rest / a), math.sqrt(y / b)), (90, 270)
    return (
        f"psi0 is {math.degrees(psi):.6g} deg; in {mode} with convention "
        f'"{convention}" psi librates within {math.degrees(largest):.6g} deg of {center[0]} or '
        f"{center[1]} deg. Give such an angle, or check convention and periods."
    )
