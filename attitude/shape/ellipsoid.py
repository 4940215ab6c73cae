"""The triaxial ellipsoid, in closed form: it makes facets only when asked for them."""

from dataclasses import dataclass

import numpy as np

from attitude import gates
from attitude.errors import AttitudeError
from attitude.shape.geodesic import unit_sphere
from attitude.shape.integrals import MassProperties
from attitude.shape.mesh import Mesh


@dataclass(frozen=True, eq=False)
class Ellipsoid:
    """An ellipsoid about the origin of the body axes.

    Parameters
    ----------
    semi_axes : (3,) array_like
        Along x, y and z of the body, in any order of size: m, or a Quantity.

    Raises
    ------
    AttitudeError
        For semi-axes that are not three positive finite numbers.
    """

    semi_axes: np.ndarray

    is_convex = True
    is_closed = True

    def __post_init__(self):
        axes = gates.real(self.semi_axes, "semi_axes", shape=(3,), unit="m")
        if not np.all(axes > 0.0):
            raise AttitudeError(
                f"semi_axes is {axes.tolist()}; each must be greater than zero, in m."
            )
        axes.flags.writeable = False
        object.__setattr__(self, "semi_axes", axes)

    def __reduce__(self):
        return Ellipsoid, (self.semi_axes,)

    @property
    def volume(self):
        """m3."""
        return 4.0 / 3.0 * np.pi * float(np.prod(self.semi_axes))

    @property
    def area(self):
        """The surface, m2: 4 pi a b c R_G(a^-2, b^-2, c^-2) (DLMF 19.33.1)."""
        from scipy.special import elliprg

        return 4.0 * np.pi * float(np.prod(self.semi_axes) * elliprg(*self.semi_axes**-2.0))

    def mass_properties(self, *, density):
        """Mass, centre and inertia tensor of the solid of even density (kg/m3).

        Returns
        -------
        MassProperties

        Examples
        --------
        >>> Ellipsoid((3, 2, 1)).mass_properties(density=1).inertia.diagonal() / (8 * np.pi)
        array([1. , 2. , 2.6])
        """
        density = gates.positive(density, "density", unit="kg/m3")
        mass = density * self.volume
        squares = self.semi_axes**2
        return MassProperties(mass, np.zeros(3), np.diag(mass / 5.0 * (np.sum(squares) - squares)))

    def facets(self, count=1000, *, material="surface"):
        """A closed mesh of at least `count` facets, with the ellipsoid's mean brightness.

        An icosahedron whose faces are divided into f^2 triangles of nearly equal area, blown up so
        that the facets of the sphere have the area of the sphere, then stretched.  Vertices lie
        0.3% outside the true surface at 1000 facets.

        Accuracy, as Lommel-Seeliger brightness against the closed form, axes up to 1.5 : 1.2 : 1,
        random directions: 980 facets 0.41 mmag rms up to 60 deg of phase, 0.57 up to 90 deg; 1280
        facets (the answer to ``count=1000``) 0.31 and 0.41; it falls as the number of facets.
        """
        if not (isinstance(count, (int, np.integer)) and 20 <= count <= 2_000_000):
            raise AttitudeError(
                f"count is {count!r}; give a whole number of facets from 20 to 2000000."
            )
        vertices, triangles = unit_sphere(int(np.ceil(np.sqrt(count / 20.0))))
        sphere = Mesh(vertices, triangles)
        swollen = vertices * np.sqrt(4.0 * np.pi / sphere.area)
        return Mesh(swollen * self.semi_axes, triangles, material)
