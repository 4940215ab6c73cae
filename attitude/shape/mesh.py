"""Triangles with normals that point outward: the surface of a body."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from attitude import validation
from attitude.errors import AttitudeError, quoted
from attitude.immutable import Immutable, frozen
from attitude.shape import closure, convexity, integrals, mesh_input
from attitude.shape.mesh_input import listed

if TYPE_CHECKING:
    from collections.abc import Iterable

    from numpy.typing import ArrayLike

    from attitude.annotations import FloatArray, IntArray, Real, Reals
    from attitude.shape.integrals import MassProperties

# The material of facets that are given none.
SURFACE: str = "surface"
# Rounding of vertices and normals in heights, over the size of the body.
_FLAT = 1e-12 + 32.0 * np.finfo(float).eps


@dataclass(frozen=True, eq=False, repr=False, init=False)
class Mesh(Immutable):
    """A surface of flat triangles in body axes.

    Parameters
    ----------
    vertices : (V, 3) array_like
        m, or a Quantity.
    facets : (F, 3) array_like of int
        Indices from 0 into the vertices, anticlockwise seen from outside.
    materials : sequence of F str, or one str for all, optional
        Names of the materials of the facets; by default "surface".
    open : bool
        Whether the surface may have a boundary: a sheet such as a panel, lit on its front only.

    Attributes
    ----------
    vertices : (V, 3) array
        m.
    facets : (F, 3) array of int
    materials : tuple of F str
    may_be_open : bool
        Whether ``open`` was given; see `is_closed`.
    rounding : float
        How much each coordinate may err, m; of a mesh read from text, half a unit of the last
        digit, otherwise 0.

    Raises
    ------
    AttitudeError
        For numbers that are not finite, indices without a vertex, facets whose area is within the
        rounding of their corners, so that they have no normal, two facets with the same corners,
        facets that run against a neighbour, and, unless ``open``, facets at a hole.

    Notes
    -----
    An open mesh bounds no solid: `require_closed`, which `mass_properties` calls, refuses it.
    Arrays are read-only.
    """

    vertices: FloatArray
    facets: IntArray
    materials: tuple[str, ...]
    may_be_open: bool
    rounding: float

    def __init__(
        self,
        vertices: Reals,
        facets: ArrayLike,
        materials: str | Iterable[str] = SURFACE,
        *,
        open: bool = False,
    ) -> None:
        self._set("vertices", frozen(mesh_input.vertices_of(vertices)))
        self._set("facets", frozen(mesh_input.facets_of(facets, len(self.vertices))))
        self._set("materials", mesh_input.materials_of(materials, len(self.facets)))
        self._set("may_be_open", validation.one_of(open, "open", (True, False)))
        self._set("rounding", 0.0)
        mesh_input.refuse_degenerate(self.corners, self.areas)
        mesh_input.refuse_doubled(self.corners)
        mesh_input.refuse_repeated(self.facets, self._edges)
        if not open:
            self._require_no_hole()

    def __reduce__(self) -> tuple[Any, ...]:
        state = self.vertices, self.facets, self.materials, self.may_be_open, self.rounding
        return _remade, state

    def __repr__(self) -> str:
        kind = "closed" if self.is_closed else "open"
        return f"<Mesh: {len(self.vertices)} vertices, {len(self.facets)} facets, {kind}>"

    def __len__(self) -> int:
        """The number of facets."""
        return len(self.facets)

    @cached_property
    def corners(self) -> FloatArray:
        """The three corners of each facet, (F, 3, 3), m."""
        return frozen(self.vertices[self.facets])

    @cached_property
    def area_vectors(self) -> FloatArray:
        """Outward normal times area of each facet, (F, 3), m2."""
        a, b, c = np.moveaxis(self.corners, 1, 0)
        return frozen(np.cross(b - a, c - a) / 2.0)

    @cached_property
    def areas(self) -> FloatArray:
        """Area of each facet, (F,), m2."""
        return frozen(np.linalg.norm(self.area_vectors, axis=-1))

    @cached_property
    def normals(self) -> FloatArray:
        """Outward unit normal of each facet, (F, 3)."""
        return frozen(self.area_vectors / self.areas[:, None])

    @cached_property
    def centroids(self) -> FloatArray:
        """Centroid of each facet, (F, 3), m."""
        return frozen(np.mean(self.corners, axis=1))

    @cached_property
    def area(self) -> float:
        """Area of the surface, m2."""
        return float(np.sum(self.areas))

    @cached_property
    def volume(self) -> float:
        """Volume, m3; of an open mesh that of the cone from the mean of its vertices to it."""
        return integrals.solid_moments(self.corners - self._middle)[0]

    @cached_property
    def open_facets(self) -> IntArray:
        """Indices of the facets at a hole; empty if closed."""
        return self._edges.unbalanced

    @cached_property
    def _edges(self) -> closure.Edges:
        return closure.edges_of(self.facets, len(self.vertices))

    @property
    def is_closed(self) -> bool:
        """Whether facets pass each edge as often one way as the other: a surface without holes."""
        return len(self.open_facets) == 0

    @cached_property
    def inward_facets(self) -> IntArray:
        """Indices of the facets of closed parts whose normals point inward; may be empty."""
        if not self.is_closed:
            return frozen(np.zeros(0, dtype=np.int64))
        return frozen(closure.inward_facets(self.vertices, self.facets))

    @cached_property
    def is_convex(self) -> bool:
        """Whether the mesh is closed and no vertex rises above the plane of a facet: no shadows.

        Heights within the rounding of the coordinates, `rounding` and that of doubles, count as
        zero.  The time grows with the number of facets (`convexity`).
        """
        if not self.is_closed or len(self.inward_facets):
            return False
        return convexity.is_convex(
            self.corners, self.normals, self._edges.mates, _FLAT, self.rounding
        )

    @property
    def _middle(self) -> FloatArray:
        """Mean of the vertices that facets use, (3,), m."""
        return np.mean(self.vertices[np.unique(self.facets)], axis=0)

    def require_closed(self) -> Mesh:
        """The mesh itself, if it bounds a solid.

        Raises
        ------
        AttitudeError
            With the facets at holes, or the facets of closed parts that are inside out.
        """
        self._require_no_hole()
        if len(self.inward_facets):
            raise AttitudeError(
                f"the mesh is inside out: the normals of facets {listed(self.inward_facets)} point "
                "into the body. Reverse the order of their vertices (Mesh.reversed() turns all), "
                "or read the file with repair=True."
            )
        return self

    def _require_no_hole(self) -> None:
        if not self.is_closed:
            raise AttitudeError(
                f"the mesh is not closed: facets {listed(self.open_facets)} lie at a hole. Close "
                "the holes, give vertices that coincide one number, read the file with "
                "repair=True, or say that the surface is a sheet: open=True of Mesh, closed=False "
                "of shape.read."
            )

    def _with_vertices(self, vertices: FloatArray, factor: float = 1.0) -> Mesh:
        """The same facets between other vertices, whose edges need no second check."""
        other = object.__new__(Mesh)
        other._set("vertices", frozen(mesh_input.vertices_of(vertices)))
        other._set("rounding", self.rounding * factor)
        for name in ("facets", "materials", "may_be_open", "_edges"):
            other._set(name, getattr(self, name))
        mesh_input.refuse_degenerate(other.corners, other.areas)
        return other

    def with_rounding(self, rounding: Real) -> Mesh:
        """The same mesh, each coordinate of which may err by a length, m: see `is_convex`."""
        given = validation.number(rounding, "rounding", unit="m")
        if given < 0.0:
            raise AttitudeError(f"rounding is {given!r} m; give 0 or more.")
        other = self._with_vertices(self.vertices)
        other._set("rounding", given)
        return other

    def reversed(self) -> Mesh:
        """The same surface with every normal reversed."""
        turned = Mesh(self.vertices, self.facets[:, ::-1], self.materials, open=self.may_be_open)
        return turned.with_rounding(self.rounding)

    def moved(self, offset: Reals) -> Mesh:
        """The mesh displaced by (3,) m; by minus its centre of mass it turns about that centre."""
        offset = validation.real(offset, "offset", shape=(3,), unit="m")
        return self._with_vertices(self.vertices + offset)

    def turned(self, matrix: ArrayLike) -> Mesh:
        """The mesh in other axes: vertices become matrix @ vertex, for a proper rotation (3, 3).

        Raises
        ------
        AttitudeError
            For a matrix that differs from a rotation by more than 1e-9.
        """
        turn = validation.real(matrix, "matrix", shape=(3, 3))
        wrong = np.max(np.abs(turn @ turn.T - np.eye(3)))
        if wrong > 1e-9 or np.linalg.det(turn) < 0.0:
            raise AttitudeError(
                f"matrix is no rotation: it differs from an orthogonal one by {wrong:.1e}, its "
                f"determinant is {np.linalg.det(turn):.3g}; give an orthogonal matrix with "
                "determinant +1."
            )
        return self._with_vertices(self.vertices @ turn.T)

    def scaled(self, factor: Real) -> Mesh:
        """The mesh with every length multiplied by a positive number."""
        factor = validation.positive(factor, "factor")
        return self._with_vertices(self.vertices * factor, factor)

    def divided(self, times: int = 1) -> Mesh:
        """The same surface with each facet cut into 4^times by the middles of its edges.

        For `Visibility`, which tests eight points of a facet: shadows move over large facets in
        steps.

        Parameters
        ----------
        times : int
            From 0 to 8.
        """
        if not (isinstance(times, (int, np.integer)) and 0 <= times <= 8):
            raise AttitudeError(f"times is {quoted(times)}; give a whole number from 0 to 8.")
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
        finer = Mesh(np.concatenate([self.vertices, middles]), facets, names, open=self.may_be_open)
        return finer.with_rounding(self.rounding).divided(times - 1)

    def joined(self, other: Mesh) -> Mesh:
        """Both meshes as one, open if either is.

        Parts that overlap count twice in volume and mass.  A part that is there already, with
        facets of the same corners, is refused.
        """
        if not isinstance(other, Mesh):
            raise AttitudeError(
                f"a mesh is joined to {validation.shown(other)}; give another Mesh."
            )
        both = Mesh(
            np.concatenate([self.vertices, other.vertices]),
            np.concatenate([self.facets, other.facets + len(self.vertices)]),
            self.materials + other.materials,
            open=self.may_be_open or other.may_be_open,
        )
        return both.with_rounding(max(self.rounding, other.rounding))

    def mass_properties(
        self, *, density: Real | None = None, surface_density: Real | None = None
    ) -> MassProperties:
        """Mass, centre of mass and inertia of the solid or of a thin shell, exactly.

        Parameters
        ----------
        density : float or Quantity
            kg/m3, of the homogeneous solid that the closed mesh bounds.
        surface_density : float or Quantity
            kg/m2, of a thin shell; the mesh may be open.

        Returns
        -------
        MassProperties
            In the axes of the mesh, the tensor about the centre of mass.

        Raises
        ------
        AttitudeError
            For both densities or neither, one that is not greater than zero, and a solid whose
            mesh is not closed.

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
        if surface_density is not None:
            sheet = validation.positive(surface_density, "surface_density", unit="kg/m2")
            return integrals.about_center(sheet, *integrals.shell_moments(corners), self._middle)
        assert density is not None
        filling = validation.positive(density, "density", unit="kg/m3")
        self.require_closed()
        return integrals.about_center(filling, *integrals.solid_moments(corners), self._middle)


def _remade(
    vertices: FloatArray,
    facets: IntArray,
    materials: tuple[str, ...],
    open: bool,
    rounding: float,
) -> Mesh:
    """The mesh that was pickled."""
    return Mesh(vertices, facets, materials, open=open).with_rounding(rounding)
