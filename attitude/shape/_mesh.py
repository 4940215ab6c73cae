"""Triangles with normals that point outward: the surface of a body, checked; its integrals."""

from __future__ import annotations

import itertools
import re
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from attitude._support import markup, synonyms, validation
from attitude._support.arrays import Immutable, frozen
from attitude._support.quantity_text import quoted
from attitude._support.validation import shown
from attitude.errors import AttitudeError

if TYPE_CHECKING:
    from collections.abc import Iterable

    from numpy.typing import ArrayLike

    from attitude._support.annotations import FilePath, FloatArray, IntArray, Real, Reals


# ---- What rounded coordinates, such as those of a text file, leave uncertain of a surface

_NUMBER = re.compile(r"[+-]?(\d*)(?:\.(\d*))?(?:[eEdD]([+-]?\d+))?")


def of_printed(fields: Iterable[str]) -> float:
    """Half a unit of the last digit of printed coordinates, from those with the most digits.

    Zeros at the end of others may have been left out.  Of several such coordinates, as printed
    with a fixed number of significant digits, the largest.

    >>> of_printed(["0.5", "-1.250000", "0.000125"])
    5e-07
    """
    most, unit = 0, 0.0
    for field in fields:
        matched = _NUMBER.fullmatch(field)
        if matched is None:
            continue
        whole, decimals, power = matched[1], matched[2] or "", int(matched[3] or 0)
        digits = len((whole + decimals).lstrip("0"))
        last_digit = 10.0 ** (power - len(decimals))
        if digits > most:
            most, unit = digits, last_digit
        elif digits == most > 0:
            unit = max(unit, last_digit)
    return 0.5 * unit


def of_single_precision(coordinates: FloatArray) -> float:
    """Half a unit of the last place of the largest coordinate, if all are floats of 32 bits."""
    single = coordinates.astype(np.float32)
    if not np.array_equal(single, coordinates):
        return 0.0
    return 0.5 * float(np.spacing(np.max(np.abs(single))))


def height_errors(corners: FloatArray, points: FloatArray, rounding: float) -> FloatArray:
    """How much heights (K,) of points (K, 3) above facets (K, 3, 3) may err by `rounding`, m.

    Errors of point and corners are multiplied by the coordinates of the foot in terms of the
    corners.
    """
    a, b, c = np.moveaxis(corners, 1, 0)
    normal = np.cross(b - a, c - a)
    square = np.sum(normal * normal, axis=-1)
    share_b = np.sum(np.cross(points - a, c - a) * normal, axis=-1) / square
    share_c = np.sum(np.cross(b - a, points - a) * normal, axis=-1) / square
    factors = 1.0 + np.abs(1.0 - share_b - share_c) + np.abs(share_b) + np.abs(share_c)
    return np.sqrt(3.0) * rounding * factors


# ---- How triangles are joined along their edges, and which facets are at fault
# The facets of a surface without boundary pass every edge as often one way as the other.  That also
# holds for two plates back to back and for parts that touch along an edge, which are legal; it
# fails at holes and where a facet runs against its neighbour.


@dataclass(frozen=True, eq=False)
class Edges:
    """The edges of facets; edge 3 f + k runs from corner k of facet f to the next."""

    unbalanced: IntArray  # (N,), facets with an edge passed more often one way
    repeated: IntArray  # (M,), passed twice in one direction
    mates: IntArray  # (F, 3), the edge that passes the same vertices the other way, or -1


def edges_of(facets: IntArray, count: int) -> Edges:
    """The `Edges` of facets (F, 3) with `count` vertices."""
    start, end = facets.reshape(-1), facets[:, [1, 2, 0]].reshape(-1)
    # One number for each edge: its two vertices in ascending order, then the direction.
    key = 2 * (np.minimum(start, end) * count + np.maximum(start, end)) + (start > end)
    order = np.argsort(key)
    key = key[order]
    edge = key >> 1
    first = np.flatnonzero(np.concatenate([[True], edge[1:] != edge[:-1]]))
    passes = np.diff(np.append(first, len(edge)))
    back = np.add.reduceat(key & 1, first)
    pair = first[(passes == 2) & (back == 1)]
    mates = np.full(len(order), -1)
    mates[order[pair]], mates[order[pair + 1]] = order[pair + 1], order[pair]
    wrong = 2 * back != passes
    twice = wrong & (np.maximum(back, passes - back) > 1)

    def owners(groups):
        return frozen(np.unique(order[np.repeat(groups, passes)] // 3))

    return Edges(owners(wrong), owners(twice), frozen(mates.reshape(-1, 3)))


def inward_facets(vertices: FloatArray, facets: IntArray) -> IntArray:
    """Sorted indices of the facets (F, 3) of closed parts that are inside out.

    A part with negative volume is inside out, unless it lies in another: the wall of a cavity.
    """
    pieces = parts(facets, len(vertices))
    corners = vertices[facets]
    # Relative to the first corner of the part, so that parts far from the origin lose no digits.
    _, first = np.unique(pieces, return_index=True)
    mine = corners - corners[first[pieces], 0][:, None]
    six = np.einsum("fi,fi->f", mine[:, 0], np.cross(mine[:, 1], mine[:, 2]))
    volume, size = np.bincount(pieces, six), np.bincount(pieces, np.abs(six))
    # Two plates back to back have a volume of zero up to rounding, of either sign.
    bad = [
        np.flatnonzero(pieces == label)
        for label in np.flatnonzero(volume < -1e-9 * size)
        if abs(winding_number(corners[first[label], 0], corners[pieces != label])) < 0.5
    ]
    return np.sort(np.concatenate(bad)) if bad else np.zeros(0, dtype=np.int64)


def parts(facets: IntArray, count: int) -> IntArray:
    """Number (F,) of the connected part of each facet; facets (F, 3) join at `count` vertices."""
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components

    start, end = facets[:, [0, 1]].ravel(), facets[:, [1, 2]].ravel()
    graph = coo_matrix((np.ones(len(start)), (start, end)), shape=(count, count))
    _, label = connected_components(graph, directed=False)
    _, number = np.unique(label[facets[:, 0]], return_inverse=True)
    return number


def winding_number(point: FloatArray, corners: FloatArray) -> float:
    """How often closed triangles (F, 3, 3) wind about a point (3,): Van Oosterom 1983, eq. 8."""
    a, b, c = np.moveaxis(corners - point, 1, 0)
    la, lb, lc = (np.linalg.norm(v, axis=-1) for v in (a, b, c))
    above = np.einsum("fi,fi->f", a, np.cross(b, c))
    below = la * lb * lc
    for one, other, length in ((a, b, lc), (b, c, la), (c, a, lb)):
        below += np.einsum("fi,fi->f", one, other) * length
    return float(np.sum(np.arctan2(above, below)) / (2.0 * np.pi))


# ---- Whether a closed mesh is convex, from its edges: O(F) for F facets
# A closed surface is the boundary of a convex body if some point sees the front of no facet, the
# surface winds once about this point, and no edge is a valley.  The first two properties make the
# projection from the point a one-to-one map onto the sphere: the surface does not cross itself.
# The corners of such a surface are convex where its edges are, and a body that is convex at each
# point of its boundary is convex (Tietze 1928, Nakajima 1928).

# Edges, or facets of a flat body, that are examined at a time.
_BLOCK = 1 << 16


def _is_convex(corners, normals, mates, tolerance, rounding):
    """Whether no vertex of facets (F, 3, 3) m, normals (F, 3), rises above the plane of another."""
    middle = np.mean(corners, axis=(0, 1))
    corners = corners - middle
    bound = tolerance * float(np.max(np.abs(corners)))
    depth = np.einsum("fi,fi->f", normals, corners[:, 0])
    # The middle lies among the vertices: if it is above a plane, then so is a vertex.
    if np.min(depth) < -bound or np.any(mates < 0):
        return False
    if not _edges_are_ridges(corners, normals, mates, bound, rounding):
        return False
    if np.min(depth) <= bound:
        return _all_below(corners, normals, depth, bound, rounding)
    return abs(winding_number(np.zeros(3), corners) - 1.0) < 0.5


def _edges_are_ridges(corners, normals, mates, bound, rounding):
    """Whether the far corner of each neighbour of a facet is below its plane, or `bound` above."""
    for begin in range(0, len(mates), _BLOCK):
        block = slice(begin, begin + _BLOCK)
        there, edge = np.divmod(mates[block], 3)
        far = corners[there, (edge + 2) % 3]
        height = np.einsum("fki,fi->fk", far - corners[block, :1], normals[block])
        facet, neighbour = np.nonzero(height > bound)
        error = height_errors(corners[block][facet], far[facet, neighbour], rounding)
        if np.any(height[facet, neighbour] > np.maximum(bound, error)):
            return False
    return True


def _all_below(corners, normals, depth, bound, rounding):
    """The definition itself, O(F^2), for bodies so flat that their middle is in their surface."""
    points = np.unique(corners.reshape(-1, 3), axis=0)
    step = max(1, _BLOCK // len(points))
    for begin in range(0, len(normals), step):
        block = slice(begin, begin + step)
        height = normals[block] @ points.T - depth[block, None]
        facet, point = np.nonzero(height > bound)
        error = height_errors(corners[block][facet], points[point], rounding)
        if np.any(height[facet, point] > np.maximum(bound, error)):
            return False
    return True


# ---- Exact integrals over the solid that a closed mesh bounds, and over its surface
# A polyhedron is a signed sum of tetrahedra from any one point to its triangles, and moments up to
# the second order of a tetrahedron or a triangle are polynomials in its corners: exact up to
# rounding (Tonon, J. Math. Stat. 1, 8, 2005; Eberly, Polyhedral Mass Properties, 2002).


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
    """Volume, first and second moments of the solid that triangles (F, 3, 3) enclose."""
    a, b, c = np.moveaxis(corners, 1, 0)
    six = np.einsum("fi,fi->f", a, np.cross(b, c))
    return float(np.sum(six) / 6.0), *_moments(six, a, b, c, 24.0, 120.0)


def shell_moments(corners: FloatArray) -> tuple[float, FloatArray, FloatArray]:
    """Area, first and second moments of the surface: m2, m3, m4; see `solid_moments`."""
    a, b, c = np.moveaxis(corners, 1, 0)
    area = np.linalg.norm(np.cross(b - a, c - a), axis=-1) / 2.0
    return float(np.sum(area)), *_moments(area, a, b, c, 3.0, 12.0)


def _moments(weight, a, b, c, of_first, of_second):
    """First and second moments of facets with weights and corners (F, 3), over two divisors."""
    total = a + b + c
    first = np.einsum("f,fi->i", weight, total) / of_first
    second = sum(np.einsum("f,fi,fj->ij", weight, v, v) for v in (a, b, c, total))
    return first, second / of_second


def _about_center(density, measure, first, second, origin):
    """`MassProperties` from moments about an origin (3,), density in kg/m3 or kg/m2."""
    mean = first / measure
    spread = density * (second - measure * np.outer(mean, mean))
    inertia = np.trace(spread) * np.eye(3) - spread
    return MassProperties(density * measure, origin + mean, (inertia + inertia.T) / 2.0)


# ---- Checks of the vertices, facets and materials of a mesh, each with the facets at fault named


# m: moments of inertia, fifth powers of lengths, are finite.
_LARGEST = 1e60


def vertices_of(value: Any) -> FloatArray:
    """A new array (V, 3) of finite coordinates, m."""
    array = validation.real(value, "vertices", unit="m", finite=False)
    if array.ndim != 2 or array.shape[1] != 3 or len(array) == 0:
        raise AttitudeError(f"vertices has shape {array.shape}; give (V, 3), in m.")
    bad = np.flatnonzero(~np.all(np.isfinite(array), axis=1))
    if len(bad):
        raise AttitudeError(
            f"vertices {listed(bad)} hold NaN or infinity (the first is {array[bad[0]]}); every "
            "coordinate must be finite."
        )
    largest = np.abs(array).max()
    if largest > _LARGEST:
        raise AttitudeError(f"a vertex lies at {largest:.3g} m; give at most {_LARGEST:g} m.")
    return array


def facets_of(value: Any, count: int) -> IntArray:
    """A new array (F, 3) of indices from 0 into so many vertices."""
    try:
        array = np.array(value)
    except ValueError as err:
        raise AttitudeError("facets is ragged; give (F, 3): three vertices for each.") from err
    is_table = array.ndim == 2 and array.shape[1:] == (3,) and len(array)
    if not is_table or array.dtype.kind not in "iu":
        raise AttitudeError(
            f"facets has shape {array.shape} of {array.dtype}; give (F, 3) whole numbers, indices "
            "from 0 into the vertices."
        )
    array = np.ascontiguousarray(array, dtype=np.int64)
    bad = np.flatnonzero(np.any((array < 0) | (array >= count), axis=1))
    if len(bad):
        raise AttitudeError(
            f"facets {listed(bad)} name vertices that do not exist (the first is "
            f"{array[bad[0]].tolist()}); there are {count}, numbered from 0."
        )
    return array


def materials_of(materials: Any, count: int) -> tuple[str, ...]:
    """The name of the material of each of so many facets."""
    try:
        names = (materials,) * count if isinstance(materials, str) else tuple(materials)
    except TypeError as err:
        raise AttitudeError(
            f"materials is {quoted(materials)}; give one name for all facets, or one for each."
        ) from err
    if len(names) != count or not all(isinstance(name, str) for name in names):
        raise AttitudeError(
            f"materials has {len(names)} entries for {count} facets; give one name for each facet, "
            "or a single name for all."
        )
    return names


def refuse_degenerate(corners: FloatArray, areas: FloatArray) -> None:
    """Raise the AttitudeError for facets (F, 3, 3) without area beyond the rounding of corners."""
    a, b, c = np.moveaxis(corners, 1, 0)
    edge = np.sqrt(np.max([np.sum(d * d, axis=-1) for d in (b - a, c - b, a - c)], axis=0))
    # Corners known to half an ulp leave a cross product of two edges uncertain by this much.
    size = np.max(np.abs(corners), axis=(1, 2))
    noise = 4.0 * np.finfo(float).eps * size * edge
    flat = np.flatnonzero(~(2.0 * areas > noise))
    if len(flat):
        raise AttitudeError(
            f"facets {listed(flat)} are degenerate: their corners lie on a line or coincide, so "
            "they have no normal. Remove them and merge the vertices that coincide."
        )


# Weights by which the coordinates of a corner, and the corners of a facet, become one number that
# differs between facets; equal numbers are compared in full.
_OF_AXES = np.sqrt([2.0, 3.0, 5.0])
_OF_CORNERS = np.sqrt([7.0, 11.0, 13.0])


def refuse_doubled(corners: FloatArray) -> None:
    """Raise the AttitudeError for two facets (F, 3, 3) of the same corners in one cyclic order."""
    numbers = corners @ _OF_AXES
    turn = (np.argmin(numbers, axis=1)[:, None] + np.arange(3)) % 3
    key = np.take_along_axis(numbers, turn, axis=1) @ _OF_CORNERS
    order = np.argsort(key)
    alike = np.flatnonzero(key[order[1:]] == key[order[:-1]])
    one, other = order[alike], order[alike + 1]
    turned = [np.take_along_axis(corners[f], turn[f, :, None], axis=1) for f in (one, other)]
    same = np.flatnonzero(np.all(turned[0] == turned[1], axis=(1, 2)))
    if len(same):
        pairs = np.sort(np.stack([one[same], other[same]], axis=1), axis=1)
        low, high = pairs[np.argmin(pairs[:, 0])]
        raise AttitudeError(
            f"facets {low} and {high} are doubled: they have the same corners in the same "
            "order, so that their area would count twice. Remove one of them, or read the file "
            "with repair=True."
        )


def refuse_repeated(facets: IntArray, edges: Edges) -> None:
    """Raise the AttitudeError for edges that facets (F, 3) pass twice in the same direction."""
    if len(edges.repeated) == 0:
        return
    repeated = facets[edges.repeated]
    passed = np.stack([repeated, repeated[:, [1, 2, 0]]], axis=-1).reshape(-1, 2)
    directed, times = np.unique(passed, axis=0, return_counts=True)
    start, end = directed[np.argmax(times > 1)]
    raise AttitudeError(
        f"facets {listed(edges.repeated)} run against a neighbour: an edge is passed twice in the "
        f"same direction (first that from vertex {start} to vertex {end}). Turn the facets the "
        "same way, vertices anticlockwise seen from outside, remove those in excess, or read the "
        "file with repair=True."
    )


def listed(indices: IntArray) -> str:
    """The first few indices as text."""
    shown = ", ".join(str(int(i)) for i in indices[:8])
    return shown if len(indices) <= 8 else f"{shown} and {len(indices) - 8} more"


# The material of facets that are given none.
SURFACE: str = "surface"
# Most facets of the picture of a notebook.
_DRAWN = 2000
# Rounding of vertices and normals in heights, over the size of the body.
_FLAT = 1e-12 + 32.0 * np.finfo(float).eps


_HINTS = {
    **dict.fromkeys(("faces", "triangles"), "give facets="),
    **dict.fromkeys(("points", "verts"), "give vertices="),
}


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

    @synonyms.arguments(_HINTS, "Mesh(vertices, facets)")
    def __init__(
        self,
        vertices: Reals,
        facets: ArrayLike,
        materials: str | Iterable[str] = SURFACE,
        *,
        open: bool = False,
    ) -> None:
        self._set("vertices", frozen(vertices_of(vertices)))
        self._set("facets", frozen(facets_of(facets, len(self.vertices))))
        self._set("materials", materials_of(materials, len(self.facets)))
        self._set("may_be_open", validation.one_of(open, "open", (True, False)))
        self._set("rounding", 0.0)
        refuse_degenerate(self.corners, self.areas)
        refuse_doubled(self.corners)
        refuse_repeated(self.facets, self._edges)
        if not open:
            self._require_no_hole()

    def __reduce__(self) -> tuple[Any, ...]:
        state = self.vertices, self.facets, self.materials, self.may_be_open, self.rounding
        return _remade, state

    def __repr__(self) -> str:
        kind = "closed" if self.is_closed else "open"
        return f"<Mesh: {len(self.vertices)} vertices, {len(self.facets)} facets, {kind}>"

    def _repr_html_(self) -> str:
        """A table for notebooks, and the body seen from one side."""
        size = np.ptp(self.vertices, axis=0)
        rows = [
            ("vertices, facets", f"{len(self.vertices)}, {len(self)}"),
            ("surface", "closed" if self.is_closed else "open"),
            ("size x, y, z", f"{', '.join(f'{x:.6g}' for x in size)} m"),
            ("area", f"{self.area:.6g} m2"),
        ]
        if self.is_closed:
            rows.append(("volume", f"{self.volume:.6g} m3"))
            rows.append(("convex", "yes" if self.is_convex else "no"))
        if set(self.materials) != {SURFACE}:
            rows.append(("materials", ", ".join(sorted(set(self.materials)))))
        pictures = []
        if len(self) <= _DRAWN:
            pictures.append(markup.solid(self.corners, self.normals, "seen from x, y, z > 0"))
        return markup.table("Mesh", rows, *pictures)

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
        return solid_moments(self.corners - self._middle)[0]

    @cached_property
    def open_facets(self) -> IntArray:
        """Indices of the facets at a hole; empty if closed."""
        return self._edges.unbalanced

    @cached_property
    def _edges(self) -> Edges:
        return edges_of(self.facets, len(self.vertices))

    @property
    def is_closed(self) -> bool:
        """Whether facets pass each edge as often one way as the other: a surface without holes."""
        return len(self.open_facets) == 0

    @cached_property
    def inward_facets(self) -> IntArray:
        """Indices of the facets of closed parts whose normals point inward; may be empty."""
        if not self.is_closed:
            return frozen(np.zeros(0, dtype=np.int64))
        return frozen(inward_facets(self.vertices, self.facets))

    @cached_property
    def is_convex(self) -> bool:
        """Whether the mesh is closed and no vertex rises above the plane of a facet: no shadows.

        Heights within the rounding of the coordinates, `rounding` and that of doubles, count as
        zero.  The time grows with the number of facets.
        """
        if not self.is_closed or len(self.inward_facets):
            return False
        return _is_convex(self.corners, self.normals, self._edges.mates, _FLAT, self.rounding)

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
        other._set("vertices", frozen(vertices_of(vertices)))
        other._set("rounding", self.rounding * factor)
        for name in ("facets", "materials", "may_be_open", "_edges"):
            other._set(name, getattr(self, name))
        refuse_degenerate(other.corners, other.areas)
        return other

    def with_rounding(self, rounding: Real) -> Mesh:
        """The same mesh, each coordinate of which may err by a length, m: see `is_convex`."""
        number = validation.number(rounding, "rounding", unit="m")
        if number < 0.0:
            raise AttitudeError(f"rounding is {number!r} m; give 0 or more.")
        other = self._with_vertices(self.vertices)
        other._set("rounding", number)
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
            raise AttitudeError(
                f"a mesh is divided {quoted(times)} times; give a whole number from 0 to 8."
            )
        if times == 0:
            return self
        edges = np.sort(self.facets[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
        pairs, number = np.unique(edges, axis=0, return_inverse=True)
        middles = np.mean(self.vertices[pairs], axis=1)
        a, b, c = self.facets.T
        ab, bc, ca = number.reshape(-1, 3).T + len(self.vertices)
        corners = [(a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)]
        facets = np.stack([np.stack(triple, axis=1) for triple in corners], axis=1).reshape(-1, 3)
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

    def write(self, path: FilePath, *, unit: str = "m", format: str | None = None) -> None:
        """Write the mesh to a file, which `attitude.shape.read` reads back.

        Parameters
        ----------
        path : str or path
            OBJ (.obj, with the materials), DAMIT's shape.txt (.txt), or STL or PLY (.stl, .ply),
            which need trimesh.  Appears whole or not at all.
        unit : str
            Of the numbers in the file, as astropy spells it: "m", "km".
        format : "obj", "damit", "stl" or "ply", optional
            By default that of the ending of the file.

        Raises
        ------
        AttitudeError
            For an ending of no format, a unit that is no length, a mesh that could not be read back
            from STL or PLY, or a file that cannot be written.

        Notes
        -----
        OBJ and DAMIT in m give the same doubles back; STL and PLY have 32 bits of each coordinate.
        DAMIT, STL and PLY hold no materials.
        """
        synonyms.named("attitude.shape._files:write")(path, self, unit=unit, format=format)

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
            return _about_center(sheet, *shell_moments(corners), self._middle)
        assert density is not None
        filling = validation.positive(density, "density", unit="kg/m3")
        self.require_closed()
        return _about_center(filling, *solid_moments(corners), self._middle)


def _remade(vertices, facets, materials, open, rounding):
    """The mesh that was pickled."""
    return Mesh(vertices, facets, materials, open=open).with_rounding(rounding)


# ---- The flat sides of a mesh: facets of one normal and one material

# Normals that differ by less than this, rad, are one: rounding of meshes in text files.
_SAME = 1e-5


class FlatSide(NamedTuple):
    """The facets of a mesh that share a normal and a material.

    Attributes
    ----------
    name : str
        The material; where several sides have it, with the axis of the normal ("body +x") or a
        number ("body 3", in order of the area).
    material : str
    normal : (3,) array
        Outward unit normal, body axes.
    area : float
        m2.
    facets : (K,) array of int
        Indices of the facets.
    """

    name: str
    material: str
    normal: FloatArray
    area: float
    facets: IntArray


def flat_sides(mesh: Mesh) -> tuple[FlatSide, ...]:
    """The flat sides of a mesh, of each material in order of decreasing area.

    Parameters
    ----------
    mesh : Mesh

    Raises
    ------
    AttitudeError
        For anything else.

    >>> from attitude.shape import box
    >>> [side.name for side in flat_sides(box((3, 2, 1)))][:2]
    ['surface -z', 'surface +z']
    """
    if not isinstance(mesh, Mesh):
        raise AttitudeError(f"mesh is {shown(mesh)}; give a Mesh, which has flat sides.")
    cell = np.rint(mesh.normals / _SAME).astype(np.int64)
    groups: dict[tuple[str, int, int, int], list[int]] = {}
    for k, (material, place) in enumerate(zip(mesh.materials, cell.tolist(), strict=True)):
        groups.setdefault(_place(groups, material, place), []).append(k)
    sides = []
    for (material, *_), members in groups.items():
        facets = frozen(np.array(members))
        vector = np.sum(mesh.area_vectors[facets], axis=0)
        area = float(np.sum(mesh.areas[facets]))
        sides.append((material, frozen(vector / np.linalg.norm(vector)), area, facets))
    sides.sort(key=lambda side: (side[0], -round(side[2], 12), int(side[3][0])))
    return tuple(_named(sides))


def _place(groups, material, place):
    """The key of the group of a facet: that of a neighbouring cell, if there is one."""
    x, y, z = place
    for i, j, k in itertools.product((0, -1, 1), repeat=3):
        key = material, x + i, y + j, z + k
        if key in groups:
            return key
    return material, x, y, z


def _named(sides):
    """The sides with their names."""
    counts = {}
    alone = {material: sum(side[0] == material for side in sides) == 1 for material, *_ in sides}
    for material, normal, area, facets in sides:
        counts[material] = counts.get(material, 0) + 1
        name = material
        if not alone[material]:
            axis = int(np.argmax(np.abs(normal)))
            name = f"{material} {counts[material]}"
            if abs(normal[axis]) > 1.0 - 1e-11:
                name = f"{material} {'-+'[int(normal[axis] > 0.0)]}{'xyz'[axis]}"
        yield FlatSide(name, material, normal, area, facets)
