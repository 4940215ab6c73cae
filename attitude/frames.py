"""Axes that are given a name: which rotation leads from each of them to ICRF.

=========  ========================================================================================
icrf       The axes of the International Celestial Reference Frame: those of GCRF and BCRS, and
           what SPICE calls J2000.
gcrf       Another name of the same axes.
eme2000    Mean equator and equinox of J2000, which CCSDS, STK and Orekit call EME2000 or J2000:
           turned by the frame bias of 23 mas against ICRF.
ecliptic   Ecliptic and equinox of J2000: ICRF turned about its x axis by 84381.448 arcsec, with no
           bias.  SPICE's ECLIPJ2000, and the axes of the Minor Planet Center and of Horizons.
=========  ========================================================================================

All of them are fixed.  The bare name "j2000" is refused, since it means ICRF to some and EME2000
to others.

Sources: the obliquity of IAU 1976 (Lieske et al., A&A 58, 1, 1977); the frame bias of IERS
Conventions (2003), eq. 5.33 with xi_0 = dpsi sin(eps_0), as in ERFA's bi00 and bp00.
"""

import math

import numpy as np

from attitude.errors import AttitudeError
from attitude.quaternion import multiply

FRAMES = ("icrf", "gcrf", "eme2000", "ecliptic")

_ARCSEC = math.pi / 648000.0
_OBLIQUITY = 84381.448 * _ARCSEC
# Offsets of the J2000 pole and equinox: d psi, d epsilon and d alpha of ERFA's bi00.
_XI = -0.041775 * _ARCSEC * math.sin(_OBLIQUITY)
_ETA = -0.0068192 * _ARCSEC
_ALPHA = -0.0146 * _ARCSEC


def matrix_to_icrf(frame):
    """The rotation (3, 3), read-only, that takes components in a frame to components in ICRF.

    Parameters
    ----------
    frame : str
        One of `FRAMES`, in upper or lower case.

    Raises
    ------
    AttitudeError
        For any other name.

    Notes
    -----
    Each entry is the rounded value of the definition, to 2 units of its last place.

    >>> matrix_to_icrf("ecliptic") @ (0.0, 0.0, 1.0)      # the pole of the ecliptic
    array([ 0.        , -0.39777716,  0.91748206])
    """
    return _MATRICES[known(frame)]


def wxyz_to_icrf(frame):
    """The same rotation as a quaternion (4,), scalar first, read-only; see `matrix_to_icrf`.

    >>> wxyz_to_icrf("icrf")
    array([1., 0., 0., 0.])
    """
    return _QUATERNIONS[known(frame)]


def known(frame, name="frame"):
    """The name of a frame in lower case, or an AttitudeError that lists the allowed ones."""
    given = frame.lower() if isinstance(frame, str) else frame
    if given in FRAMES:
        return given
    if given == "j2000":
        raise AttitudeError(
            f'{name} is {frame!r}, which means two things; give "icrf" for what SPICE calls J2000 '
            'and "eme2000" for what CCSDS and STK call so.'
        )
    raise AttitudeError(
        f"{name} is {frame!r}; it must be one of {', '.join(repr(each) for each in FRAMES)}."
    )


def _turned(axis, angle):
    """Unit quaternion and matrix of the rotation of vectors by an angle about a basis axis."""
    cosine, sine = math.cos(angle), math.sin(angle)
    wxyz = np.zeros(4)
    wxyz[0], wxyz[1 + axis] = math.cos(angle / 2.0), math.sin(angle / 2.0)
    following, last = (axis + 1) % 3, (axis + 2) % 3
    matrix = np.eye(3)
    matrix[following, following] = matrix[last, last] = cosine
    matrix[last, following], matrix[following, last] = sine, -sine
    return wxyz, matrix


def _frames():
    level = _turned(0, 0.0)
    # ICRF to EME2000 is R1(-eta) R2(xi) R3(alpha), which turn the axes; read as rotations of
    # vectors, its inverse is the product of the same angles in reverse order.
    bias = [_turned(2, _ALPHA), _turned(1, _XI), _turned(0, -_ETA)]
    eme2000 = (
        multiply(multiply(bias[0][0], bias[1][0]), bias[2][0]),
        bias[0][1] @ bias[1][1] @ bias[2][1],
    )
    found = {"icrf": level, "gcrf": level, "eme2000": eme2000, "ecliptic": _turned(0, _OBLIQUITY)}
    for pair in found.values():
        for array in pair:
            array.setflags(write=False)
    return {name: pair[0] for name, pair in found.items()}, {
        name: pair[1] for name, pair in found.items()
    }


_QUATERNIONS, _MATRICES = _frames()
