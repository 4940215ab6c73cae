"""Standard deviations of the numbers that describe a motion: periods, angles, momentum, energy.

They are computed from motions one standard deviation away along each principal axis of the errors,
as `published.uncertainty.spread` does from published numbers: without derivatives, and with the
limits that bodies and modes set.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from attitude import frames
from attitude.errors import AttitudeError
from attitude.published.uncertainty import in_quadrature, possible_end
from attitude.regime import Mode
from attitude.sensitivities import covariance as covariances

if TYPE_CHECKING:
    from attitude.annotations import FloatArray
    from attitude.free_rotation.free_rotation import FreeRotation
    from attitude.published.uncertainty import Uncertain

_NAMES = (
    *("spin_rate", "period", "period_psi", "period_phi", "P_phi_L", "P_phi_S"),
    *("nutation_least", "nutation_greatest"),
    *("spin_rate_least", "spin_rate_greatest", "spin_rate_mean", "energy_ratio", "one_minus_m"),
    *("momentum", "right_ascension", "declination", "longitude", "latitude"),
    *("energy", "separatrix_distance"),
)
# Angles of a whole turn.
_TURNING = ("right_ascension", "longitude")
# Modes beside which the axis of circulation is the same, unless errors reach the separatrix.
_CIRCULATING = (Mode.LONG_AXIS, Mode.SHORT_AXIS, Mode.SYMMETRIC)


def deviations(motion: FreeRotation, errors: FloatArray) -> dict[str, Uncertain]:
    """The numbers of a motion with their errors of one standard deviation.

    Parameters
    ----------
    motion : FreeRotation
    errors : (9, 9) array
        Covariance of its parameters, ICRF axes.

    Returns
    -------
    dict of str to Uncertain
        spin_rate (rad/s, at the epoch), period (2 pi over it), period_psi, period_phi, P_phi_L,
        P_phi_S (s), nutation_least, nutation_greatest (rad, of the axis of circulation),
        spin_rate_least, _greatest, _mean (rad/s), energy_ratio, one_minus_m, momentum,
        right_ascension, declination (of the momentum, rad, ICRF), longitude, latitude (ecliptic of
        J2000), energy, separatrix_distance.  Where a number does not exist it is NaN.

    Notes
    -----
    Errors that reach moments of no body, or the separatrix, are cut there, since the periods of the
    other mode are others.
    """
    columns = covariances.factor(errors).T
    steps = [sign * column for column in columns if np.any(column) for sign in (1.0, -1.0)]
    start = np.zeros(9)
    ends = [possible_end(start, step, lambda end: _exists(motion, end)) for step in steps]
    found = np.array([_numbers(motion), *(_numbers(motion.changed(end)) for end in ends)])
    for name in _TURNING:
        k = _NAMES.index(name)
        away = found[1:, k] - found[0, k]
        found[1:, k] = found[0, k] + (away + math.pi) % (2.0 * math.pi) - math.pi
    return dict(zip(_NAMES, in_quadrature(found), strict=True))


def _exists(motion: FreeRotation, changes: FloatArray) -> bool:
    """Whether a change of the parameters leaves a body, and the axis of circulation."""
    try:
        other = motion.changed(changes)
    except AttitudeError:
        return False
    return motion.mode not in _CIRCULATING or other.circulates_about == motion.circulates_about


def _numbers(motion: FreeRotation) -> list[float]:
    regime, axis = motion.regime, motion.circulates_about
    nutation = (math.nan, math.nan) if axis is None else regime.nutation(axis[0])
    speed = float(regime.spin_rate)
    momentum = np.asarray(motion.momentum)
    ecliptic = frames.matrix_to_icrf("ecliptic").T @ momentum
    return [
        *(speed, math.inf if speed == 0.0 else 2.0 * math.pi / speed),
        *(motion.period_psi, motion.period_phi, float(regime.P_phi_L), float(regime.P_phi_S)),
        *(float(each) for each in nutation),
        *(float(each) for each in regime.spin_rate_range),
        *(float(regime.mean_spin_rate), float(regime.energy_ratio), float(regime.one_minus_m)),
        *(float(np.linalg.norm(momentum)), *_angles(momentum), *_angles(ecliptic)),
        *(motion.energy, motion.separatrix_distance),
    ]


def _angles(vector: FloatArray) -> tuple[float, float]:
    """Longitude from -pi to pi and latitude, rad; NaN for no vector."""
    if not np.any(vector):
        return math.nan, math.nan
    x, y, z = vector / np.max(np.abs(vector))
    return math.atan2(y, x), math.atan2(z, math.hypot(x, y))
