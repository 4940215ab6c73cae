"""Poinsot's curves in closed form: the path of the angular velocity in the body and in space."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from attitude._solver import codes
from attitude._support import markup, validation
from attitude._support.constants import VERMILION
from attitude.errors import AttitudeError
from attitude.frames import quaternion
from attitude.motions import _conventions

if TYPE_CHECKING:
    from collections.abc import Callable

    from attitude._support.annotations import FloatArray
    from attitude.motions._body import Body


def polhode(constants: Any, principal_axes: FloatArray, points: int) -> FloatArray:
    """One circuit of the angular velocity in body axes.

    Shapes: principal_axes (3, 3).

    w1 = a1 cos am, w2 = -a2 sin am, w3 = a3 sqrt(cos^2 am + (1-m) sin^2 am) over the axes in
    Jacobi order: van Zon & Schofield (2006), eqs. 3.36-3.41.
    """
    count = validation.count(points, "points", 2, 10_000_000)
    if constants["form"] == codes.UNIFORM:
        w = np.ldexp(constants["omega"][:, 0], int(constants["tempo"]))
        return np.tile(principal_axes @ w, (count, 1))
    first, second, minus1, minus3 = constants["jacobi"]
    third = 3 - first - second
    turn = np.pi if constants["mode"] != codes.SEPARATRIX else 0.5 * np.pi
    am = np.linspace(-turn, turn, count)
    if third == constants["order"][2]:
        am = am[::-1]  # in short-axis mode the amplitude decreases with time
    cosine, sine = np.cos(am), np.sin(am)
    if turn < 3.0:
        cosine[[0, -1]] = 0.0
    inner = np.empty((3, count))
    inner[0] = cosine
    inner[1] = -sine
    inner[2] = np.sqrt(cosine**2 + constants["mc"][0] * sine**2)
    inner *= constants["amplitudes"][:, None]
    even = (second - first) % 3 == 1
    signs = np.array([1 - 2 * minus1, 1.0, 1 - 2 * minus3])
    signs[1] = signs[0] * signs[2] * (1.0 if even else -1.0)
    over_principal = np.empty((3, count))
    over_principal[[first, second, third]] = signs[:, None] * inner
    return (principal_axes @ over_principal).T


def pictures(body: Body, energy: float, curve: Callable[[int], FloatArray]) -> list[str]:
    """An SVG of the polhode (n, 3), of `curve`, on its ellipsoid; none at rest and for a rod."""
    if not energy > 0.0 or np.min(body.moments) <= 0.0:
        return []
    axes = body.principal_axes
    turn = np.linspace(0.0, 2.0 * np.pi, 73)
    circles = np.zeros((3, len(turn), 3))
    for k in range(3):
        circles[k, :, (k + 1) % 3], circles[k, :, (k + 2) % 3] = np.cos(turn), np.sin(turn)
    sections = circles * np.sqrt(2.0 * energy / body.moments) @ axes.T
    # Seen from a place above the first octant of the principal axes.
    right, up = np.array([[-0.6, 0.8, 0.0], [-0.36, -0.27, 0.89]]) @ axes.T
    return [
        markup.line_plot(
            [(points_of @ right, points_of @ up) for points_of in (*sections, curve(181))],
            "polhode on the ellipsoid of its energy, with the principal sections",
            colors=("#bbbbbb", "#bbbbbb", "#bbbbbb", VERMILION),
            is_equal=True,
        )
    ]


def plane(momentum: FloatArray) -> FloatArray:
    """Axes (2, 3), of growing colatitude and longitude, of the plane across the momentum (3,)."""
    x, y, z = momentum / np.max(np.abs(momentum))
    pole = np.array([np.arctan2(y, x), np.arctan2(z, np.hypot(x, y))])
    return quaternion.matrix(_conventions.pole_wxyz(pole)).T[:2]


def herpolhode(momentum: FloatArray, angular_velocity: FloatArray) -> FloatArray:
    """Components (..., 2) in the invariable plane of angular velocities (..., 3), rad/s.

    Over the axes of `plane`; momentum (3,) and angular velocities in one inertial frame.  The
    component along the momentum, 2 E / L, is constant.
    """
    if not np.any(momentum):
        raise AttitudeError("the body is at rest; without momentum there is no invariable plane.")
    return angular_velocity @ plane(momentum).T
