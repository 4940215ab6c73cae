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

from functools import cache

import numpy as np

from attitude.errors import AttitudeError
from attitude.immutable import frozen

FRAMES = ("icrf", "gcrf", "eme2000", "ecliptic")

# Unit quaternions to ICRF.  ICRF to EME2000 is R1(-eta) R2(xi) R3(alpha), which turn the axes; read
# as rotations of vectors, its inverse is the product of the same angles in reverse order.  The test
# of this module works them out again from the angles.
_WXYZ = {
    "icrf": ("1", "0", "0", "0"),
    "gcrf": ("1", "0", "0", "0"),
    "eme2000": (
        "0.999999999999998425817661647920298663198567",
        "0.000000016530205845506748563703187604926235439702",
        "-0.0000000402810863199078291832111570618227943274495",
        "-0.0000000353913980551413902931003075169337272554139",
    ),
    "ecliptic": (
        "0.979153221428899202736752099100629948941129",
        "0.203123038982310145841424903862925979590464",
        "0",
        "0",
    ),
}


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
    Each entry is the rounded value of the definition.

    >>> matrix_to_icrf("ecliptic") @ (0.0, 0.0, 1.0)      # the pole of the ecliptic
    array([ 0.        , -0.39777716,  0.91748206])
    """
    return _matrix(known(frame))


def wxyz_to_icrf(frame):
    """The same rotation as a quaternion (4,), scalar first, read-only; see `matrix_to_icrf`.

    >>> wxyz_to_icrf("icrf")
    array([1., 0., 0., 0.])
    """
    return _quaternion(known(frame))


def vector_to_icrf(frame, vector):
    """Components (3,) in a frame as components in ICRF, each exact to a pair of doubles: (3, 2)."""
    return _pairs(_exact_matrix(known(frame)) @ _fractions(vector))


def attitude_to_icrf(frame, wxyz):
    """The quaternion (4,) of an attitude against a frame, against ICRF, in pairs: (4, 2)."""
    # `quaternion.multiply` takes doubles
    (a, b, c, d), (w, x, y, z) = _exact(known(frame)), _fractions(wxyz)
    return _pairs(
        np.array(
            [
                a * w - b * x - c * y - d * z,
                a * x + b * w + c * z - d * y,
                a * y - b * z + c * w + d * x,
                a * z + b * y - c * x + d * w,
            ]
        )
    )


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


@cache
def _quaternion(frame):
    return frozen(np.array(_WXYZ[frame], dtype=float))


@cache
def _matrix(frame):
    return frozen(_exact_matrix(frame).astype(float))


@cache
def _exact(frame):
    """The quaternion (4,) as fractions, right to 40 digits."""
    return _fractions(_WXYZ[frame])


@cache
def _exact_matrix(frame):
    w, x, y, z = _exact(frame)
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def _fractions(numbers):
    from fractions import Fraction

    return np.array([Fraction(each) for each in numbers])


def _pairs(exact):
    """Fractions as pairs of doubles."""
    high = exact.astype(float)
    return np.stack([high, (exact - _fractions(high)).astype(float)], axis=-1)
