"""The two conventions in which papers label the axes of a tumbling body, and their Euler angles.

With A <= B <= C the principal moments:

==========  =======================  ==============================================================
convention  body axes x, y, z        phi, theta, psi (3-1-3) about the angular momentum
==========  =======================  ==============================================================
"L"         those of B, C, A         phi, theta of the LONG axis, psi the rotation about it
"S"         those of A, B, C         phi, theta of the SHORT axis, psi the rotation about it
==========  =======================  ==============================================================

    R(labelled axes -> frame) = Rz(lambda) Ry(90 deg - beta) Rz(phi) Rx(theta) Rz(psi)

for a momentum towards longitude lambda and latitude beta of the frame.  The momentum in the
labelled axes is then L (sin theta sin psi, sin theta cos psi, cos theta).

The axes of A and of C have the directions of the body's own principal axes; that of B makes them
right-handed.  The body axes of Body(moments=(A, B, C)) are therefore the labelled axes of "S", and
those of Body(moments=(B, C, A)) the labelled axes of "L".
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from attitude._solver.regime import known_convention
from attitude._support import validation
from attitude.errors import AttitudeError
from attitude.frames import quaternion
from attitude.frames.representations import turned_positive
from attitude.motions._body import Body

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from attitude._support.annotations import FloatArray, IntArray, Real, Reals


# Angles are published in [0, 360) or (-180, 180]; a number above a turn was meant in degrees.
TURN: float = 2.0 * math.pi * (1.0 + 1e-12)
QUARTER: float = 0.5 * math.pi * (1.0 + 1e-12)


def order(body: Body) -> IntArray:
    """Indices (3,) of the body's principal moments in ascending order; equal ones keep theirs."""
    pairs = validation.instance(body, Body, "body", "a Body").moments_as_pairs
    return np.lexsort((pairs[:, 1], pairs[:, 0]))


def moments(body: Body, convention: str) -> FloatArray:
    """The principal moments (3,) about the labelled axes x, y, z, kg m2.

    >>> from attitude import Body
    >>> moments(Body(moments=(26, 10, 20)), "L")
    array([20., 26., 10.])
    """
    ascending = order(body)
    a, b, c = body.moments[ascending]
    return np.array([b, c, a] if known_convention(convention) == "L" else [a, b, c])


def axes(body: Body, convention: str) -> FloatArray:
    """The labelled axes as columns (3, 3) of components in body axes.

    >>> from attitude import Body
    >>> axes(Body(moments=(1, 2, 2.5)), "L")      # x, y, z are the axes of 2, 2.5 and 1
    array([[0., 0., 1.],
           [1., 0., 0.],
           [0., 1., 0.]])
    """
    least, _, greatest = order(body)
    a, c = body.principal_axes[:, least], body.principal_axes[:, greatest]
    b = np.cross(c, a)
    chosen = (b, c, a) if known_convention(convention) == "L" else (a, b, c)
    return np.column_stack(chosen)


def axes_wxyz(body: Body, convention: str) -> FloatArray:
    """The unit quaternion (4,) from the labelled axes to body axes, scalar first."""
    return quaternion.from_matrix(axes(body, convention))


def pole_wxyz(pole: ArrayLike) -> FloatArray:
    """Rz(lambda) Ry(90 deg - beta) as quaternions (..., 4), of poles (..., 2) in rad."""
    longitude, latitude = np.moveaxis(np.asarray(pole), -1, 0)
    turn = quaternion.about(2, longitude)
    return quaternion.multiply(turn, quaternion.about(1, 0.5 * math.pi - latitude))


def euler_wxyz(phi: ArrayLike, theta: ArrayLike, psi: ArrayLike) -> FloatArray:
    """Rz(phi) Rx(theta) Rz(psi) as quaternions (..., 4), of angles (...) in rad."""
    turn = quaternion.multiply(quaternion.about(2, phi), quaternion.about(0, theta))
    return quaternion.multiply(turn, quaternion.about(2, psi))


def momentum_direction(theta: float, psi: float) -> FloatArray:
    """The unit vector (3,) of the momentum in labelled axes; theta, psi in rad."""
    sine = math.sin(theta)
    return np.array([sine * math.sin(psi), sine * math.cos(psi), math.cos(theta)])


def angles_of(
    wxyz: FloatArray, momentum: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Pole and Euler angles of attitudes.

    Shapes: wxyz (..., 4), momentum (..., 3).

    theta and psi follow from the momentum, phi from the attitude that remains: where theta is
    small only phi + psi is determined, and the sum of the two is exact to the last place.
    """
    direction = momentum / np.max(np.abs(momentum), axis=-1, keepdims=True)
    x, y, z = np.moveaxis(direction, -1, 0)
    theta, psi = np.arctan2(np.hypot(x, y), z), np.arctan2(x, y)
    u, v, w = np.moveaxis(quaternion.rotate(wxyz, direction), -1, 0)
    pole = np.stack([_positive(np.arctan2(v, u)), np.arctan2(w, np.hypot(u, v))], axis=-1)
    turned = quaternion.multiply(quaternion.conjugate(pole_wxyz(pole)), wxyz)
    turned = quaternion.multiply(turned, quaternion.conjugate(euler_wxyz(0.0, theta, psi)))
    phi = 2.0 * np.arctan2(turned[..., 3], turned[..., 0])
    return pole, _positive(phi), theta, _positive(psi)


def known_pole(pole: Reals) -> FloatArray:
    """Longitude and latitude (2,) in rad; AttitudeError beyond a turn or 90 degrees."""
    if isinstance(pole, (list, tuple)) and len(pole) == 2:
        longitude = validation.number(pole[0], "pole longitude", unit="rad")
        latitude = validation.number(pole[1], "pole latitude", unit="rad")
    else:
        longitude, latitude = validation.real(pole, "pole", shape=(2,), unit="rad")
    _check(longitude, "pole longitude", (-TURN, TURN), "-360 and 360 deg")
    _check(latitude, "pole latitude", (-QUARTER, QUARTER), "-90 and 90 deg")
    return np.array([longitude, latitude])


def known_angle(value: Real, name: str) -> float:
    """One angle in rad; AttitudeError beyond a turn."""
    angle = validation.number(value, name, unit="rad")
    _check(angle, name, (-TURN, TURN), "-360 and 360 deg")
    return angle


def known_tilt(value: Real, name: str) -> float:
    """One angle in rad; AttitudeError outside of 0 to 180 degrees."""
    angle = validation.number(value, name, unit="rad")
    _check(angle, name, (0.0, math.pi * (1.0 + 1e-12)), "0 and 180 deg", "65.9 deg")
    return angle


def _check(
    value: float, name: str, limits: tuple[float, float], spelled: str, example: str = "250 deg"
) -> None:
    """AttitudeError for an angle outside of its limits."""
    if not limits[0] <= value <= limits[1]:
        raise AttitudeError(
            f"{name} is {value:.9g} rad ({math.degrees(value):.6g} deg); it must lie between "
            f"{spelled}. Plain numbers are radians: give degrees as a Quantity or as "
            f'"{example}".'
        )


def _positive(angle):
    """Any angle in [0, 2 pi)."""
    return turned_positive(np.fmod(angle, 2.0 * np.pi))[()]
