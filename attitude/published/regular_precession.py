"""Regular precession: spin and moments of a symmetric body from two periods and one angle.

Comets are often published as P_phi, P_psi and the angle theta between the axis of symmetry and the
momentum, without moments; for a symmetric body the three numbers determine the motion.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from attitude import validation
from attitude.errors import AttitudeError
from attitude.published import conventions
from attitude.published.dynamic_inertia import known_mode

if TYPE_CHECKING:
    from attitude.annotations import FloatArray, Real
    from attitude.regime import Mode


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
        rad, between the axis of symmetry and the momentum.

    Returns
    -------
    period, angle : float
        s, rad.  w = phi' along the momentum + psi' along the axis.

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
    if tilt >= 0.5 * math.pi:
        raise AttitudeError(
            f"theta is {math.degrees(tilt):.6g} deg; with 90 deg or more the rotation about the "
            "axis of symmetry has the opposite sense. Give the angle to the nearer end of the axis."
        )
    ratio = psi / (phi * math.cos(tilt)) + 1.0  # I / Iz
    if not ratio >= 0.5:
        low = math.degrees(math.acos(min(1.0, 2.0 * abs(psi) / phi)))
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
    return phi, psi, conventions.known_tilt(theta, "theta")
