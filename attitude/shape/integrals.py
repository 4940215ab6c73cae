"""Exact integrals over the solid that a closed mesh bounds, and over the surface as a thin shell.

A polyhedron is a signed sum of tetrahedra from any one point to its triangles, and moments up to
the second order of a tetrahedron or a triangle are polynomials in its corners: no quadrature, no
error but rounding (Tonon, J. Math. Stat. 1, 8, 2005; Eberly, Polyhedral Mass Properties, 2002).
"""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True, eq=False)
class MassProperties:
    """Mass (kg), centre of mass (3,) in m, and inertia tensor (3, 3) in kg m2 about that centre.

    All in the axes in which the shape was given.
    """

    mass: float
    center_of_mass: np.ndarray
    inertia: np.ndarray

    def __post_init__(self):
        for name in ("center_of_mass", "inertia"):
            array = np.array(getattr(self, name), dtype=np.float64)
            array.flags.writeable = False
            object.__setattr__(self, name, array)

    def __reduce__(self):
        return MassProperties, (self.mass, self.center_of_mass, self.inertia)


def solid_moments(corners):
    """Volume, first moments and second moments of the solid that outward triangles enclose.

    Parameters
    ----------
    corners : (F, 3, 3) array
        Corners of the facets, m; anticlockwise seen from outside.

    Returns
    -------
    float, (3,), (3, 3)
        Integrals of 1, r and r r^T over the solid: m3, m4, m5.  The origin of r is that of the
        corners, so give corners relative to a point within the body, where nothing cancels.
    """
    a, b, c = np.moveaxis(corners, 1, 0)
    six = np.einsum("fi,fi->f", a, np.cross(b, c))
    total = a + b + c
    first = np.einsum("f,fi->i", six, total) / 24.0
    second = _outer(six, a, b, c, total) / 120.0
    return float(np.sum(six) / 6.0), first, second


def shell_moments(corners):
    """Area, first moments and second moments of the triangles themselves; see `solid_moments`."""
    a, b, c = np.moveaxis(corners, 1, 0)
    area = np.linalg.norm(np.cross(b - a, c - a), axis=-1) / 2.0
    total = a + b + c
    first = np.einsum("f,fi->i", area, total) / 3.0
    second = _outer(area, a, b, c, total) / 12.0
    return float(np.sum(area)), first, second


def about_center(density, measure, first, second, origin):
    """`MassProperties` from moments about `origin`, for kg per m3 or per m2 of the measure."""
    mean = first / measure
    spread = density * (second - measure * np.outer(mean, mean))
    inertia = np.trace(spread) * np.eye(3) - spread
    return MassProperties(density * measure, origin + mean, (inertia + inertia.T) / 2.0)


def _outer(weight, a, b, c, total):
    """Sum over facets of weight times (a a^T + b b^T + c c^T + total total^T)."""
    return sum(np.einsum("f,fi,fj->ij", weight, v, v) for v in (a, b, c, total))
