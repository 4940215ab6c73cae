"""Named inertial axes, and the rotation from each of them to ICRF.

=========  ========================================================================================
icrf       The axes of the International Celestial Reference Frame: those of GCRF and BCRS, and
           what SPICE calls J2000.
gcrf       The same axes as icrf.
eme2000    Mean equator and equinox of J2000, which CCSDS, STK and Orekit call EME2000 or J2000:
           ICRF turned by the frame bias of 23 mas.
ecliptic   Ecliptic and equinox of J2000: ICRF turned about its x axis by 84381.448 arcsec, with no
           bias.  SPICE's ECLIPJ2000, and the axes of the Minor Planet Center and of Horizons.
=========  ========================================================================================

All of them are fixed.  The name "j2000" is refused: it means ICRF in SPICE and EME2000 in CCSDS.

Sources: the obliquity of IAU 1976 (Lieske et al., A&A 58, 1, 1977); the frame bias of IERS
Conventions (2003), eq. 5.33 with xi_0 = dpsi sin(eps_0), as in ERFA's bi00 and bp00.

quaternion        quaternions as arrays; matrices and Euler angles (`attitude.quaternion`)
representations   attitudes in other forms (`attitude.representations`)
_earth            axes of the Earth, of date and Earth-fixed
"""

from __future__ import annotations

from functools import cache
from typing import TYPE_CHECKING, Any

import numpy as np

from attitude._support import validation
from attitude._support.arrays import frozen
from attitude._support.pairs import add, times
from attitude._support.quantity_text import quoted
from attitude._support.synonyms import of_module
from attitude.errors import AttitudeError

if TYPE_CHECKING:
    from collections.abc import Iterable

    from numpy.typing import ArrayLike, NDArray

    from attitude._support.annotations import FloatArray, Reals

__all__ = [
    "FRAMES",
    "attitude_to_icrf",
    "known",
    "matrix_to_icrf",
    "vector_to_icrf",
    "wxyz_to_icrf",
]

if not TYPE_CHECKING:
    # Hidden from type checkers: a module with __getattr__ has every name, misspelt ones too.
    __getattr__ = of_module(__name__)

FRAMES: tuple[str, ...] = ("icrf", "gcrf", "eme2000", "ecliptic")

# Unit quaternions to ICRF.  ICRF to EME2000 is R1(-eta) R2(xi) R3(alpha), which turn the axes; read
# as rotations of vectors, its inverse is the product of the same angles in reverse order.  The test
# of this module computes them from the angles.
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


def matrix_to_icrf(frame: str) -> FloatArray:
    """The rotation matrix (3, 3), read-only, from components in a frame to components in ICRF.

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
    Each entry is the exact value of the definition, rounded to a double.

    >>> matrix_to_icrf("ecliptic") @ (0.0, 0.0, 1.0)      # the pole of the ecliptic
    array([ 0.        , -0.39777716,  0.91748206])
    """
    return _matrix(known(frame))


def wxyz_to_icrf(frame: str) -> FloatArray:
    """The rotation of `matrix_to_icrf` as a unit quaternion (4,), scalar first, read-only.

    >>> wxyz_to_icrf("icrf")
    array([1., 0., 0., 0.])
    """
    return _quaternion(known(frame))


def vector_to_icrf(frame: str, vector: Reals) -> FloatArray:
    """Components in ICRF (3, 2) of components (3,) in a frame, each exact to a pair of doubles."""
    components = validation.real(vector, "vector", shape=(3,)).tolist()
    return _pairs(_exact_matrix(known(frame)) @ _fractions(components))


def attitude_to_icrf(frame: str, wxyz: ArrayLike) -> FloatArray:
    """Quaternions to ICRF (..., 4, 2) of quaternions (..., 4, 2) to a frame, in pairs of doubles.

    Exact to 1e-31, where `quaternion.multiply` rounds to doubles.
    """
    a, b, c, d = _exact_in_pairs(known(frame))
    pairs = validation.rows(wxyz, "wxyz", 2)
    if pairs.ndim == 2:  # floats are ten times faster than arrays of one number
        w, x, y, z = pairs.tolist()
    else:
        w, x, y, z = ((pairs[..., k, 0], pairs[..., k, 1]) for k in range(4))
    turned = np.array(
        [
            _sum(times(a, w), times(b, x), times(c, y), times(d, z), signs=(1, -1, -1, -1)),
            _sum(times(a, x), times(b, w), times(c, z), times(d, y), signs=(1, 1, 1, -1)),
            _sum(times(a, y), times(b, z), times(c, w), times(d, x), signs=(1, -1, 1, 1)),
            _sum(times(a, z), times(b, y), times(c, x), times(d, w), signs=(1, 1, -1, 1)),
        ]
    )
    return np.moveaxis(turned, (0, 1), (-2, -1))


def known(frame: str, name: str = "frame", more: tuple[str, ...] = ()) -> str:
    """The name of a frame of FRAMES, or of `more` that the caller knows, in lower case."""
    lower = frame.lower() if isinstance(frame, str) else None
    if lower in (*FRAMES, *more):
        return lower
    if lower == "j2000":
        raise AttitudeError(
            f'{name} is {quoted(frame)}, which means two things; give "icrf" for the J2000 of '
            'SPICE, "eme2000" for that of CCSDS and STK.'
        )
    raise AttitudeError(
        f"{name} is {quoted(frame)}; it must be one of {', '.join(map(repr, (*FRAMES, *more)))}."
    )


@cache
def _quaternion(frame: str) -> FloatArray:
    return frozen(np.array(_WXYZ[frame], dtype=float))


@cache
def _matrix(frame: str) -> FloatArray:
    return frozen(_exact_matrix(frame).astype(float))


@cache
def _exact_matrix(frame: str) -> NDArray[Any]:
    """The matrix (3, 3) to ICRF as fractions."""
    w, x, y, z = _fractions(_WXYZ[frame])
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


@cache
def _exact_in_pairs(frame: str) -> list[Any]:
    """The quaternion to ICRF as four pairs of floats."""
    return _pairs(_fractions(_WXYZ[frame])).tolist()


def _sum(*terms: tuple[float, float], signs: tuple[int, ...]) -> tuple[float, float]:
    """The sum of pairs with signs, as a pair."""
    total = (0.0, 0.0)
    for (hi, lo), sign in zip(terms, signs, strict=True):
        total = add(total, sign * hi, sign * lo)
    return total


def _fractions(numbers: Iterable[float | str]) -> NDArray[Any]:
    from fractions import Fraction

    return np.array([Fraction(number) for number in numbers])


def _pairs(exact: NDArray[Any]) -> FloatArray:
    """Fractions (N,) as pairs of doubles (N, 2)."""
    high = exact.astype(float)
    return np.stack([high, (exact - _fractions(high)).astype(float)], axis=-1)
