"""Triangles with normals that point outward: the surface of a body."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from attitude import validation
from attitude.errors import AttitudeError
from attitude.immutable import frozen
from attitude.shape import closure, integrals

SURFACE = "surface"


@dataclass(frozen=True, eq=False, repr=False)
class Mesh:
    """A surface of flat triangles in body axes.

    Parameters
    ----------
    vertices : (V, 3) array_like
        m, or a Quantity.
    facets : (F, 3) array_like of int
        Indices from 0 into the vertices, anticlockwise seen from outside.
    materials : sequence of F str, or one str for all, optional
        The name of what each facet is made of; "surface" unless given.

    Raises
    ------
    AttitudeError
        For numbers that are not finite, indices without a vertex, and facets that have no area
        beyond the rounding of their corners, so that they have no normal either.

    Notes
    -----
    An open mesh is a legal surface (a plate is one) but no solid: `require_closed`, which the
    readers and `mass_properties` call, names the facets at its holes.  Arrays are read-only.
    """

    vertices: np.ndarray
    facets: np.ndarray
    materials: tuple = SURFACE

    def __post_init__(self):
        vertices = _vertices(self.vertices)
        facets = _facets(self.facets, len(vertices))
        materials = self.materials
        names = (materials,) * len(facets) if isinstance(materials, str) else _names(materials)
        if len(names) != len(facets) or not all(isinstance(name, str) for name in names):
            raise AttitudeError(
                f"materials has {len(names)} entries for {len(facets)} facets; give one name for "
                "each facet, or a single name for all."
            )
        for array in (vertices, facets):
            array.flags.writeable = False
        object.__setattr__(self, "vertices", vertices)
        object.__setattr__(self, "facets", facets)
        object.__setattr__(self, "materials", names)
        self._refuse_degenerate()

    def __reduce__(self):
        return Mesh, (self.vertices, self.facets, self.materials)

    def __repr__(self):
        kind = "closed" if self.is_closed else "open"
        return f"<Mesh: {len(self.vertices)} vertices, {len(self.facets)} facets, {kind}>"

    def __len__(self):
        return len(self.facets)

    @cached_property
    def corners(self):
        """(F, 3, 3): the three corners of each facet, m."""
        return frozen(self.vertices[self.facets])

    @cached_property
    def area_vectors(self):
        """(F, 3): outward normal times area, m2."""
        a, b, c = np.moveaxis(self.corners, 1, 0)
        return frozen(np.cross(b - a, c - a) / 2.0)

    @cached_property
    def areas(self):
        """(F,): m2."""
        return frozen(np.linalg.norm(self.area_vectors, axis=-1))

    @cached_property
    def normals(self):
        """(F, 3): outward unit normals."""
        return frozen(self.area_vectors / self.areas[:, None])

    @cached_property
    def centroids(self):
        """(F, 3): m."""
        return frozen(np.mean(self.corners, axis=1))

    @cached_property
    def area(self):
        """The whole surface, m2."""
        return float(np.sum(self.areas))

    @cached_property
    def volume(self):
        """m3; of an open mesh, of the cone that joins it to the mean of its vertices."""
        return integrals.solid_moments(self.corners - self._middle)[0]

    @cached_property
    def open_facets(self):
        """Indices of the facets at a hole, or turned against a neighbour; none when closed."""
        return frozen(closure.open_facets(self.facets))

    @property
    def is_closed(self):
        """Whether each edge is passed as often one way as the other: a surface without holes."""
        return len(self.open_facets) == 0

    @cached_property
    def inward_facets(self):
        """Indices of the facets of closed parts whose normals point inward; none when sound."""
        return frozen(closure.inward_facets(self.vertices, self.facets))

    @cached_property
    def is_convex(self):
        """Whether the mesh is closed and no vertex rises above a facet's plane: no shadows.

        Heights within the rounding of the coordinates count as none.
        """
        if not self.is_closed or len(self.inward_facets):
            return False
        size = np.max(np.abs(self.vertices - self._middle))
        used = self.vertices[np.unique(self.facets)] - self._middle
        level = np.einsum("fi,fi->f", self.normals, self.centroids - self._middle)
        # Blocks, so that 1e5 facets do not ask for a matrix of 1e10 heights.
        for begin in range(0, len(self), 512):
            part = slice(begin, begin + 512)
            height = np.max(self.normals[part] @ used.T, axis=1) - level[part]
            if np.any(height > 32.0 * np.finfo(float).eps * size + 1e-12 * size):
                return False
        return True

    @property
    def _middle(self):
        return np.mean(self.vertices[np.unique(self.facets)], axis=0)

    def require_closed(self):
        """Return the mesh itself if it bounds a solid.

        Raises
        ------
        AttitudeError
            Naming the facets at holes or turned against their neighbours, or, where a closed part
            is inside out, the facets of that part.
        """
        if not self.is_closed:
            raise AttitudeError(
                f"the mesh is not closed: facets {_listed(self.open_facets)} lie at a hole, or run "
                "against a neighbour. Close the holes and turn the facets the same way (vertices "
                "anticlockwise seen from outside), read the file with repair=True, or say "
                "closed=False for a surface that is meant to be open."
            )
        if len(self.inward_facets):
            raise AttitudeError(
                f"the mesh is inside out: the normals of facets {_listed(self.inward_facets)} point"
                " into the body. Reverse the order of their vertices (Mesh.reversed() turns all), "
                "or read the file with repair=True."
            )
        return self

    def reversed(self):
        """The same surface with every normal turned round."""
        return Mesh(self.vertices, self.facets[:, ::-1], self.materials)

    def moved(self, offset):
        """The mesh displaced by (3,) m: by minus its centre of mass, it turns about that."""
        offset = validation.real(offset, "offset", shape=(3,), unit="m")
        return Mesh(self.vertices + offset, self.facets, self.materials)

    def turned(self, matrix):
        """The mesh in other axes: vertices become matrix @ vertex, for a proper rotation (3, 3)."""
        matrix = validation.real(matrix, "matrix", shape=(3, 3))
        wrong = np.max(np.abs(matrix @ matrix.T - np.eye(3)))
        if wrong > 1e-9 or np.linalg.det(matrix) < 0.0:
            raise AttitudeError(
                f"matrix is no rotation: it differs from an orthogonal one by {wrong:.1e}, its "
                f"determinant is {np.linalg.det(matrix):.3g}; give one with determinant +1."
            )
        return Mesh(self.vertices @ matrix.T, self.facets, self.materials)

    def scaled(self, factor):
        """The mesh with every length multiplied by a positive number."""
        return Mesh(
            self.vertices * validation.positive(factor, "factor"), self.facets, self.materials
        )

    def divided(self, times=1):
        """The same surface with each facet cut into four by the middles of its edges, so often.

        For `Visibility`, which knows eight points of a facet: shadows move over large facets in
        steps.
        """
        if not (isinstance(times, (int, np.integer)) and 0 <= times <= 8):
            raise AttitudeError(f"times is {times!r}; give a whole number from 0 to 8.")
        if times == 0:
            return self
        edges = np.sort(self.facets[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
        pairs, number = np.unique(edges, axis=0, return_inverse=True)
        middles = np.mean(self.vertices[pairs], axis=1)
        a, b, c = self.facets.T
        ab, bc, ca = number.reshape(-1, 3).T + len(self.vertices)
        corners = [(a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)]
        facets = np.stack([np.stack(each, axis=1) for each in corners], axis=1).reshape(-1, 3)
        names = tuple(name for name in self.materials for _ in range(4))
        return Mesh(np.concatenate([self.vertices, middles]), facets, names).divided(times - 1)

    def joined(self, other):
        """Both meshes as one; parts that overlap count twice in volume and mass."""
        if not isinstance(other, Mesh):
            raise AttitudeError(f"a mesh is joined to {other!r}; give another Mesh.")
        return Mesh(
            np.concatenate([self.vertices, other.vertices]),
            np.concatenate([self.facets, other.facets + len(self.vertices)]),
            self.materials + other.materials,
        )

    def mass_properties(self, *, density=None, surface_density=None):
        """Mass, centre of mass and inertia, of the solid or of a thin shell, exactly.

        Parameters
        ----------
        density : float or Quantity
            kg/m3: the closed mesh is filled evenly.
        surface_density : float or Quantity
            kg/m2: its surface is a thin sheet; the mesh may be open.

        Returns
        -------
        MassProperties
            In the axes of the mesh, the tensor about the centre of mass.

        Examples
        --------
        >>> from attitude.shape import box
        >>> box((1, 2, 3)).mass_properties(density=2).inertia.diagonal()
        array([13., 10.,  5.])
        """
        if (density is None) == (surface_density is None):
            raise AttitudeError(
                "give either density (kg/m3, of the solid) or surface_density (kg/m2, of a shell)."
            )
        # Relative to a point within the body, so that a mesh far from its origin loses nothing.
        corners = self.corners - self._middle
        if density is not None:
            density = validation.positive(density, "density", unit="kg/m3")
            self.require_closed()
            return integrals.about_center(density, *integrals.solid_moments(corners), self._middle)
        surface_density = validation.positive(surface_density, "surface_density", unit="kg/m2")
        return integrals.about_center(
            surface_density, *integrals.shell_moments(corners), self._middle
        )

    def _refuse_degenerate(self):
        a, b, c = np.moveaxis(self.corners, 1, 0)
        edge = np.sqrt(np.max([np.sum(d * d, axis=-1) for d in (b - a, c - b, a - c)], axis=0))
        # Corners known to half an ulp leave a cross product of two edges uncertain by this much.
        size = np.max(np.abs(self.corners), axis=(1, 2))
        noise = 4.0 * np.finfo(float).eps * size * edge
        flat = np.flatnonzero(~(2.0 * self.areas > noise))
        if len(flat):
            raise AttitudeError(
                f"facets {_listed(flat)} are degenerate: their corners lie on a line or coincide, "
                "so they have no normal. Remove them and merge the vertices that coincide."
            )


def _vertices(value):
    array = validation.real(value, "vertices", unit="m", finite=False)
    if array.ndim != 2 or array.shape[1] != 3 or len(array) == 0:
        raise AttitudeError(f"vertices has shape {array.shape}; give (V, 3), in m.")
    bad = np.flatnonzero(~np.all(np.isfinite(array), axis=1))
    if len(bad):
        raise AttitudeError(
            f"vertices {_listed(bad)} hold NaN or infinity (the first is {array[bad[0]]}); every "
            "coordinate must be finite."
        )
    return array


def _facets(value, count):
    try:
        array = np.array(value)
    except ValueError as err:
        raise AttitudeError("facets is ragged; give (F, 3): three vertices for each.") from err
    if (
        array.ndim != 2
        or array.shape[1:] != (3,)
        or len(array) == 0
        or array.dtype.kind not in "iu"
    ):
        raise AttitudeError(
            f"facets has shape {array.shape} of {array.dtype}; give (F, 3) whole numbers, indices "
            "from 0 into the vertices."
        )
    array = np.ascontiguousarray(array, dtype=np.int64)
    bad = np.flatnonzero(np.any((array < 0) | (array >= count), axis=1))
    if len(bad):
        raise AttitudeError(
            f"facets {_listed(bad)} name vertices that do not exist (the first is "
            f"{array[bad[0]].tolist()}); there are {count}, numbered from 0."
        )
    return array


def _names(materials):
    try:
        return tuple(materials)
    except TypeError as err:
        raise AttitudeError(
            f"materials is {materials!r}; give one name for all facets, or one for each."
        ) from err


def _listed(indices):
    """The first few indices in words."""
    shown = ", ".join(str(int(i)) for i in indices[:8])
    return shown if len(indices) <= 8 else f"{shown} and {len(indices) - 8} more"
