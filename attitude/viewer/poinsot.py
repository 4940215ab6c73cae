"""Poinsot's construction: the ellipsoid of inertia that rolls on the invariable plane.

The ellipsoid is x . I x = s^2 in body axes, I the inertia tensor, s a scale.  Its point
s omega / sqrt(2 E) touches the plane across the angular momentum L at the distance s sqrt(2 E) / L;
the point draws the polhode on the ellipsoid and the herpolhode on the plane.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from attitude import quaternion
from attitude.free_rotation.free_rotation import FreeRotation

if TYPE_CHECKING:
    from attitude.annotations import FloatArray
    from attitude.body import Body
    from attitude.viewer.subject import Subject

# Longest over shortest semi-axis that is drawn: the moment of a rod's own axis is zero.
_LONGEST = 8.0
# Points of the polhode; of the herpolhode a turn of the faster phase, and at most.
_POLHODE, _A_TURN, _MOST = 361, 48.0, 6000


class InertiaEllipsoid(NamedTuple):
    """Semi-axes (3,), the longest 1, and their directions as columns (3, 3), body axes."""

    semi_axes: FloatArray
    axes: FloatArray


def inertia_ellipsoid(body: Body | None) -> InertiaEllipsoid | None:
    """The ellipsoid of inertia; None without a body or if all moments are zero."""
    if body is None or not np.any(body.moments > 0.0):
        return None
    least = np.max(body.moments) / _LONGEST**2
    semi = 1.0 / np.sqrt(np.maximum(body.moments, least))
    return InertiaEllipsoid(semi / semi.max(), np.asarray(body.principal_axes))


def construction(subject: Subject) -> dict[str, Any] | None:
    """The curves of a free rotation, in units of the longest semi-axis; None for other motions.

    "semi_axes", "axes", "distance" of the plane, "pole" (unit vector of the momentum, ICRF),
    "rate" (the angular velocity of which the ellipsoid has its unit, rad/s), "polhode" (body axes)
    and "herpolhode" (ICRF), rows of 3.
    """
    motion = subject.motion
    if not isinstance(motion, FreeRotation) or np.min(motion.body.moments) <= 0.0:
        return None
    energy, momentum = motion.energy, motion.momentum
    size = float(np.linalg.norm(momentum))
    found = inertia_ellipsoid(motion.body)
    if found is None or not energy > 0.0 or not size > 0.0:
        return None
    # s / sqrt(2 E), with s such that the longest semi-axis s / sqrt(least moment) is 1.
    per_rate = float(np.sqrt(np.min(motion.body.moments) / (2.0 * energy)))
    times = np.linspace(0.0, *_herpolhode_span(subject))
    history = subject.at(times)
    return {
        "semi_axes": found.semi_axes,
        "axes": found.axes,
        "distance": per_rate * 2.0 * energy / size,
        "pole": momentum / size,
        "rate": 1.0 / per_rate,
        "polhode": motion.polhode(_POLHODE) * per_rate,
        "herpolhode": quaternion.rotate(history.wxyz, history.angular_velocity) * per_rate,
    }


def _herpolhode_span(subject: Subject) -> tuple[float, int]:
    """Seconds and number of points of the herpolhode: as much of the span as is drawn finely."""
    regime = subject.motion.regime
    periods = [abs(each) for each in (regime.P_psi, regime.P_phi_L, regime.P_phi_S)]
    shortest = min((each for each in periods if 0.0 < each < np.inf), default=subject.duration)
    span = min(subject.duration, shortest * _MOST / _A_TURN)
    return span, int(np.clip(_A_TURN * span / shortest, 64, _MOST))
