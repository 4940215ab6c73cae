"""The triaxial ellipsoid, in closed form, and as a mesh of facets."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from attitude import validation
from attitude.errors import AttitudeError, quoted
from attitude.immutable import Immutable, frozen
from attitude.shape.geodesic import lifted, unit_sphere
from attitude.shape.integrals import MassProperties
from attitude.shape.mesh import Mesh

if TYPE_CHECKING:
    from attitude.annotations import FloatArray, Real, Reals


@dataclass(frozen=True, eq=False, init=False)
class Ellipsoid(Immutable):
    """An ellipsoid about the origin of the body axes.

    Parameters
    ----------
    semi_axes : (3,) array_like
        Along x, y and z of the body, in any order of size: m, or a Quantity.

    Attributes
    ----------
    semi_axes : (3,) array
        m.
    is_convex, is_closed : bool
        True, as for a convex `Mesh`.

    Raises
    ------
    AttitudeError
        For semi-axes that are not three positive finite numbers.
    """

    semi_axes: FloatArray

    is_convex = True
    is_closed = True

    def __init__(self, semi_axes: Reals) -> None:
        axes = validation.real(semi_axes, "semi_axes", shape=(3,), unit="m")
        if not np.all(axes > 0.0):
            raise AttitudeError(
                f"semi_axes is {axes.tolist()}; each must be greater than zero, in m."
            )
        self._set("semi_axes", frozen(axes))

    def __reduce__(self) -> tuple[Any, ...]:
        return Ellipsoid, (self.semi_axes,)

    @classmethod
    def of_moments(cls, moments: Reals, *, diameter: Real = 1.0) -> Ellipsoid:
        """The homogeneous ellipsoid with moments of inertia in given ratios.

        Parameters
        ----------
        moments : (3,) array_like
            About x, y and z; their ratios count.
        diameter : float or Quantity
            Of the sphere of equal volume, m.

        Raises
        ------
        AttitudeError
            For moments that no ellipsoid has, and a diameter that is not greater than zero.

        Examples
        --------
        >>> Ellipsoid.of_moments((5, 10, 13), diameter=2).semi_axes.round(6)    # 3 : 2 : 1
        array([1.650964, 1.100642, 0.550321])
        """
        ratios = validation.real(moments, "moments", shape=(3,))
        size = validation.positive(diameter, "diameter", unit="m")
        squares = np.sum(ratios) - 2.0 * ratios
        if not np.all(ratios > 0.0) or not np.all(squares > 0.0):
            raise AttitudeError(
                f"moments is {ratios.tolist()}; those of an ellipsoid are greater than zero, and "
                "each is less than the sum of the others."
            )
        axes = np.sqrt(squares)
        return cls(axes * (0.5 * size / np.prod(axes) ** (1.0 / 3.0)))

    @property
    def volume(self) -> float:
        """Volume, m3."""
        return 4.0 / 3.0 * np.pi * float(np.prod(self.semi_axes))

    @property
    def area(self) -> float:
        """Area of the surface, m2: 4 pi a b c R_G(a^-2, b^-2, c^-2) (DLMF 19.33.1)."""
        from scipy.special import elliprg

        return 4.0 * np.pi * float(np.prod(self.semi_axes) * elliprg(*self.semi_axes**-2.0))

    def mass_properties(self, *, density: Real) -> MassProperties:
        """Mass, centre of mass and inertia tensor of the homogeneous solid.

        Parameters
        ----------
        density : float or Quantity
            kg/m3.

        Returns
        -------
        MassProperties

        Raises
        ------
        AttitudeError
            For a density that is not greater than zero.

        Examples
        --------
        >>> Ellipsoid((3, 2, 1)).mass_properties(density=1).inertia.diagonal() / (8 * np.pi)
        array([1. , 2. , 2.6])
        """
        mass = validation.positive(density, "density", unit="kg/m3") * self.volume
        squares = self.semi_axes**2
        return MassProperties(mass, np.zeros(3), np.diag(mass / 5.0 * (np.sum(squares) - squares)))

    def facets(self, count: int = 1000, *, material: str = "surface") -> Mesh:
        """A closed mesh of at most `count` facets, with the mean brightness of the ellipsoid.

        An icosahedron whose faces are divided into f^2 triangles of nearly equal area, its vertices
        lifted until it has the area of the sphere, then stretched: 20 f^2 facets, 980 for 1000.
        Vertices of 980 facets lie 0.3% outside the true surface.

        Accuracy, as Lommel-Seeliger brightness against the closed form, axes up to 1.5 : 1.2 : 1,
        random directions: 980 facets 0.35 mmag rms up to 60 deg of phase, 0.48 up to 90 deg; the
        error falls faster than the number of facets grows.

        Parameters
        ----------
        count : int
            From 20 to 2,000,000.
        material : str
            Of all facets.
        """
        if not (isinstance(count, (int, np.integer)) and 20 <= count <= 2_000_000):
            raise AttitudeError(
                f"count is {quoted(count)}; give a whole number of facets from 20 to 2000000."
            )
        vertices, triangles = unit_sphere(math.isqrt(int(count) // 20))
        return Mesh(lifted(vertices, triangles) * self.semi_axes, triangles, material)
