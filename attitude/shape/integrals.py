"""Exact integrals over the solid that a closed mesh bounds, and over the surface as a thin shell.

A polyhedron is a signed sum of tetrahedra from any one point to its triangles, and moments up to
the second order of a tetrahedron or a triangle are polynomials in its corners: exact up to rounding
(Tonon, J. Math. Stat. 1, 8, 2005; Eberly, Polyhedral Mass Properties, 2002).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from attitude.immutable import Immutable, frozen

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from attitude.annotations import FloatArray


@dataclass(frozen=True, eq=False, init=False)
class MassProperties(Immutable):
    """Mass, centre of mass and inertia of a body, in the axes in which its shape was given.

    Attributes
    ----------
    mass : float
        kg.
    center_of_mass : (3,) array
        m.
    inertia : (3, 3) array
        kg m2, about the centre of mass.
    """

    mass: float
    center_of_mass: FloatArray
    inertia: FloatArray

    def __init__(self, mass: float, center_of_mass: ArrayLike, inertia: ArrayLike) -> None:
        self._set("mass", mass)
        self._set("center_of_mass", frozen(np.array(center_of_mass, dtype=np.float64)))
        self._set("inertia", frozen(np.array(inertia, dtype=np.float64)))


def solid_moments(corners: FloatArray) -> tuple[float, FloatArray, FloatArray]:
    """Volume, first moments and second moments of the solid that outward triangles enclose.

    Parameters
    ----------
    corners : (F, 3, 3) array
        Corners of the facets, m; anticlockwise seen from outside.

    Returns
    -------
    float, (3,), (3, 3)
        Integrals of 1, r and r r^T over the solid: m3, m4, m5.  The origin of r is that of the
        corners: without cancellation if it lies within the body.
    """
    a, b, c = np.moveaxis(corners, 1, 0)
    six = np.einsum("fi,fi->f", a, np.cross(b, c))
    total = a + b + c
    first = np.einsum("f,fi->i", six, total) / 24.0
    second = _outer(six, a, b, c, total) / 120.0
    return float(np.sum(six) / 6.0), first, second


def shell_moments(corners: FloatArray) -> tuple[float, FloatArray, FloatArray]:
    """Area, first and second moments of the surface: m2, m3, m4; see `solid_moments`."""
    a, b, c = np.moveaxis(corners, 1, 0)
    area = np.linalg.norm(np.cross(b - a, c - a), axis=-1) / 2.0
    total = a + b + c
    first = np.einsum("f,fi->i", area, total) / 3.0
    second = _outer(area, a, b, c, total) / 12.0
    return float(np.sum(area)), first, second


def about_center(
    density: float, measure: float, first: FloatArray, second: FloatArray, origin: FloatArray
) -> MassProperties:
    """`MassProperties` from moments about an origin (3,).

    Parameters
    ----------
    density : float
        kg/m3 or kg/m2.
    measure, first, second
        Of `solid_moments` or `shell_moments`.
    origin : (3,) array
        m, in the axes of the shape.
    """
    mean = first / measure
    spread = density * (second - measure * np.outer(mean, mean))
    inertia = np.trace(spread) * np.eye(3) - spread
    return MassProperties(density * measure, origin + mean, (inertia + inertia.T) / 2.0)


def _outer(
    weight: FloatArray, a: FloatArray, b: FloatArray, c: FloatArray, total: FloatArray
) -> FloatArray:
    """Sum over facets of weight times (a a^T + b b^T + c c^T + total total^T)."""
    return sum(np.einsum("f,fi,fj->ij", weight, v, v) for v in (a, b, c, total))
