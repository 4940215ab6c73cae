"""The two ways in which papers name the axes of a tumbling body, and the angles that go with each.

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

The axes of A and of C point as the body's own principal axes do; that of B makes them right-handed.
Body(moments=(A, B, C)) is therefore labelled "S" as it stands, and Body(moments=(B, C, A)) "L".
"""

import math

import numpy as np

from attitude import quaternion, validation
from attitude.errors import AttitudeError
from attitude.regime import known_convention

# Angles are published in [0, 360) or (-180, 180]; what exceeds a turn was meant in degrees.
_TURN = 2.0 * math.pi * (1.0 + 1e-12)


def order(body):
    """Indices (3,) of the body's principal moments, ascending; equal ones as they are."""
    pairs = body.moments_as_pairs
    return np.lexsort((pairs[:, 1], pairs[:, 0]))


def moments(body, convention):
    """The principal moments (3,) about the labelled axes x, y, z.

    >>> from attitude import Body
    >>> moments(Body(moments=(26, 10, 20)), "L")
    array([20., 26., 10.])
    """
    a, b, c = body.moments[order(body)]
    return np.array([b, c, a] if known_convention(convention) == "L" else [a, b, c])


def axes(body, convention):
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


def axes_wxyz(body, convention):
    """The labelled axes as the unit quaternion (4,) from them to body axes."""
    return quaternion.from_matrix(axes(body, convention))


def pole_wxyz(pole):
    """Rz(lambda) Ry(90 deg - beta) as quaternions (..., 4), of poles (..., 2)."""
    longitude, latitude = np.moveaxis(np.asarray(pole), -1, 0)
    turn = _about(2, longitude)
    return quaternion.multiply(turn, _about(1, 0.5 * math.pi - latitude))


def euler_wxyz(phi, theta, psi):
    """Rz(phi) Rx(theta) Rz(psi) as quaternions (..., 4)."""
    turn = quaternion.multiply(_about(2, phi), _about(0, theta))
    return quaternion.multiply(turn, _about(2, psi))


def momentum_direction(theta, psi):
    """Unit momentum (3,) in labelled axes."""
    sine = math.sin(theta)
    return np.array([sine * math.sin(psi), sine * math.cos(psi), math.cos(theta)])


def angles_of(wxyz, momentum):
    """Pole and Euler angles of attitudes.

    Parameters
    ----------
    wxyz : (..., 4) array
        Labelled axes to the frame.
    momentum : (..., 3) array
        In labelled axes, of any length.

    Returns
    -------
    pole (..., 2), phi, theta, psi (...)
        rad: longitude, phi, psi in [0, 2 pi).

    Notes
    -----
    theta and psi are those of the momentum, phi what then reproduces the attitude: where theta is
    small only phi + psi is determined, and the sum of these two is good to the last place.
    """
    direction = momentum / np.max(np.abs(momentum), axis=-1, keepdims=True)
    x, y, z = np.moveaxis(direction, -1, 0)
    theta, psi = np.arctan2(np.hypot(x, y), z), np.arctan2(x, y)
    u, v, w = np.moveaxis(quaternion.rotate(wxyz, direction), -1, 0)
    pole = np.stack([_positive(np.arctan2(v, u)), np.arctan2(w, np.hypot(u, v))], axis=-1)
    rest = quaternion.multiply(quaternion.conjugate(pole_wxyz(pole)), wxyz)
    rest = quaternion.multiply(rest, quaternion.conjugate(euler_wxyz(0.0, theta, psi)))
    phi = 2.0 * np.arctan2(rest[..., 3], rest[..., 0])
    return pole, _positive(phi), theta, _positive(psi)


def known_pole(pole, name="pole"):
    """Longitude and latitude (2,) in rad, checked."""
    if isinstance(pole, (list, tuple)) and len(pole) == 2:
        longitude = validation.number(pole[0], f"{name} longitude", unit="rad")
        latitude = validation.number(pole[1], f"{name} latitude", unit="rad")
    else:
        longitude, latitude = validation.real(pole, name, shape=(2,), unit="rad")
    _check(longitude, f"{name} longitude", _TURN, "-360 and 360 deg")
    _check(latitude, f"{name} latitude", 0.5 * math.pi * (1.0 + 1e-12), "-90 and 90 deg")
    return np.array([longitude, latitude])


def known_angle(value, name):
    """One angle in rad, at most a turn."""
    value = validation.number(value, name, unit="rad")
    _check(value, name, _TURN, "-360 and 360 deg")
    return value


def known_tilt(value, name):
    """One angle in rad between 0 and 180 degrees."""
    value = validation.number(value, name, unit="rad")
    if not 0.0 <= value <= math.pi * (1.0 + 1e-12):
        raise AttitudeError(
            f"{name} is {value:.9g} rad ({math.degrees(value):.6g} deg); it must lie between 0 and "
            '180 deg. Plain numbers are radians: give degrees as a Quantity or as "65.9 deg".'
        )
    return value


def _check(value, name, limit, spelled):
    if abs(value) > limit:
        raise AttitudeError(
            f"{name} is {value:.9g} rad ({math.degrees(value):.6g} deg); it must lie between "
            f"{spelled}. Plain numbers are radians: give degrees as a Quantity or as "
            '"250 deg".'
        )


def _about(axis, angle):
    turn = np.zeros((*np.shape(angle), 4))
    turn[..., 0], turn[..., 1 + axis] = np.cos(0.5 * angle), np.sin(0.5 * angle)
    return turn


def _positive(angle):
    """In [0, 2 pi)."""
    angle = np.fmod(angle, 2.0 * np.pi)
    angle = np.where(angle < 0.0, angle + 2.0 * np.pi, angle)
    return np.where(angle < 2.0 * np.pi, angle, 0.0)[()]
