"""Two shapes compared: their common volume at equal volumes, and the turn that makes it largest."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from attitude._support import validation
from attitude._support.arrays import Immutable, frozen
from attitude.errors import AttitudeError
from attitude.shape._ellipsoid import Ellipsoid
from attitude.shape._mesh import Mesh

if TYPE_CHECKING:
    from attitude._support.annotations import FloatArray

# Facets of an ellipsoid.
_FACETS = 1000
# Points in the first body.
_POINTS = 8192
# Cells of a grid over the second along each axis.
_CELLS = 80
# Of a cell.
_OFF_MIDDLE = np.array([1.3e-3, -1.7e-3, 2.3e-3])
# The turns about principal axes that carry a body with the symmetry of an ellipsoid into itself.
_TURNS = np.array([(1.0, 1.0, 1.0), (1.0, -1.0, -1.0), (-1.0, 1.0, -1.0), (-1.0, -1.0, 1.0)])


@dataclass(frozen=True, eq=False, init=False)
class ShapeComparison(Immutable):
    """What two bodies have in common; made by `compare`.

    Attributes
    ----------
    overlap : float
        Volume that both fill over volume that either fills, at equal volumes and with one centre of
        mass, from 0 to 1.
    axes : (2, 3) array
        Semi-axes of the homogeneous ellipsoids with the moments of inertia of either body,
        descending, the volume being that of the unit sphere.
    matrix : (3, 3) array
        From the axes of the second body to those of the first, by which it is turned.
    turn : float
        Angle of `matrix`, rad.
    """

    overlap: float
    axes: FloatArray
    matrix: FloatArray
    turn: float

    def __init__(self, overlap: float, axes: FloatArray, matrix: FloatArray) -> None:
        self._set_all(overlap=overlap, axes=frozen(axes), matrix=frozen(matrix))
        # The angle from its sine and cosine: the cosine alone loses half of the digits near 0.
        sine = 0.5 * np.linalg.norm((matrix - matrix.T)[[2, 0, 1], [1, 2, 0]])
        self._set("turn", math.atan2(float(sine), 0.5 * (float(np.trace(matrix)) - 1.0)))

    def __str__(self) -> str:
        rows = [" : ".join(f"{ratio:.4g}" for ratio in row / row[2]) for row in self.axes]
        return (
            f"overlap {self.overlap:.4f} (common volume over that of both together)\n"
            f"  axes of the first   {rows[0]}\n  axes of the second  {rows[1]}\n"
            f"  turned by           {math.degrees(self.turn):.4g} deg"
        )


def compare(
    first: Mesh | Ellipsoid, second: Mesh | Ellipsoid, *, turned: bool = True
) -> ShapeComparison:
    """How much two bodies have in common, whatever their sizes and origins.

    Parameters
    ----------
    first, second : Mesh or Ellipsoid
        Closed, such as the shape of a solution and a model of DAMIT.
    turned : bool
        Whether the second is turned to where the common volume is largest, from each of the four
        ways in which the principal axes of both agree.  Otherwise the axes of both are the same.

    Returns
    -------
    ShapeComparison

    Raises
    ------
    AttitudeError
        For anything else, and meshes that are open or inside out.

    Notes
    -----
    Of convex bodies the common volume is that of the intersection of their half-spaces, exact up to
    rounding; of others it is counted at 8192 points, with errors of some 0.003 of `overlap`.
    The turn is found to some 0.01 rad; of starts that are equally good the least turn is taken.
    Bodies that are mirror images of each other differ: a light curve often allows both.

    Examples
    --------
    >>> from attitude.shape import box
    >>> round(compare(box((1, 2, 3)), box((3, 1, 2))).overlap, 6)
    1.0
    >>> round(compare(box((1, 2, 3)), box((3, 1, 2)), turned=False).overlap, 6)
    0.2
    """
    one, one_axes, one_turn = _normal(first, "first")
    other, other_axes, other_turn = _normal(second, "second")
    axes = np.array([one_axes, other_axes])
    counted = _Common(one, other)
    if not validation.flag(turned, "turned"):
        return ShapeComparison(counted.best(np.eye(3)), axes, np.eye(3))
    starts = [one_turn @ np.diag(signs) @ other_turn.T for signs in _TURNS]
    # Of starts that are equally good, as of a body with symmetries, that of the least turn.
    start = max(starts, key=lambda matrix: (round(counted.best(matrix), 6), np.trace(matrix)))
    # First by cells, then as exactly as the common volume is known; equal bodies need no search.
    matrix = start
    if counted.best(start) < 1.0 - 1e-9:
        matrix = _best(counted.best, _best(counted, start, 0.1, 200), 0.01, 60)
        matrix = max((start, matrix), key=counted.best)
    return ShapeComparison(counted.best(matrix), axes, matrix)


def _normal(shape: Any, name: str) -> tuple[Mesh, FloatArray, FloatArray]:
    """A mesh of unit volume about its centre of mass, semi-axes (3,) and principal axes (3, 3)."""
    if isinstance(shape, Ellipsoid):
        return _normal(shape.facets(_FACETS), name)
    if not isinstance(shape, Mesh):
        raise AttitudeError(
            f"{name} is {validation.shown(shape)}; give a Mesh, an Ellipsoid or the shape of a "
            "solution."
        )
    properties = shape.mass_properties(density=1.0)
    size = shape.volume ** (1.0 / 3.0)
    mesh = shape.moved(-properties.center_of_mass).scaled(1.0 / size)
    moments, columns = np.linalg.eigh(properties.inertia)
    if np.linalg.det(columns) < 0.0:
        columns[:, 2] *= -1.0
    semi_axes = np.sqrt(np.maximum(np.sum(moments) - 2.0 * moments, 0.0))
    return mesh, semi_axes / np.prod(semi_axes) ** (1.0 / 3.0), columns


def _best(counted, start, size, most):
    """The best turn near a start, from steps of `size`, rad, in at most `most` trials."""
    from scipy.optimize import minimize
    from scipy.spatial.transform import Rotation

    def turned(vector: FloatArray) -> FloatArray:
        return Rotation.from_rotvec(vector).as_matrix() @ start

    simplex = np.concatenate([np.zeros((1, 3)), size * np.eye(3)])
    options = {"initial_simplex": simplex, "xatol": 1e-4, "fatol": 1e-7, "maxfev": most}
    minimum = minimize(
        lambda x: -counted(turned(x)), np.zeros(3), method="Nelder-Mead", options=options
    )
    return turned(minimum.x)


class _Common:
    """The overlap of two meshes of unit volume, by a turn: points of one in cells of the other."""

    def __init__(self, first: Mesh, second: Mesh) -> None:
        self._points = _points_in(first)
        grid, filled = _filled(second, _CELLS)
        self._origin = np.array([axis[0] for axis in grid])
        self._step = np.array([axis[1] - axis[0] for axis in grid])
        self._filled = filled.astype(np.float32)
        self._bodies = first, second

    def __call__(self, matrix: FloatArray) -> float:
        """Intersection over union for a matrix (3, 3) from the second body to the first."""
        from scipy.ndimage import map_coordinates

        at = (self._points @ matrix - self._origin) / self._step
        common = float(np.mean(map_coordinates(self._filled, at.T, order=1)))
        return common / (2.0 - common)

    def best(self, matrix: FloatArray) -> float:
        """The same, exact for convex bodies, and without the edges of cells for others."""
        first, second = self._bodies
        if not (first.is_convex and second.is_convex):
            common = float(np.mean(_inside(second, self._points @ matrix)))
            return common / (2.0 - common)
        planes = []
        for mesh, turn in ((first, np.eye(3)), (second, matrix)):
            depth = np.einsum("fi,fi->f", mesh.normals, mesh.corners[:, 0])
            planes.append(np.column_stack([mesh.normals @ turn.T, -depth]))
        common = min(_volume(np.concatenate(planes)), 1.0)
        return common / (2.0 - common)


def _volume(planes: FloatArray) -> float:
    """The volume of the intersection of half-spaces n.x + h <= 0 about the origin, (F, 4)."""
    from scipy.spatial import ConvexHull

    # The points of the polar body: the intersection has a vertex for each of its facets.
    polar = ConvexHull(planes[:, :3] / -planes[:, 3:])
    vertices = -polar.equations[:, :3] / polar.equations[:, 3:]
    return float(ConvexHull(vertices).volume)


def _inside(mesh: Mesh, points: FloatArray) -> Any:
    """Whether each point (N, 3) lies in a closed mesh: more facets above it face up than down."""
    x, y, z = np.ascontiguousarray(points.T)
    count = np.zeros(len(points), dtype=np.int64)
    for corners, vector in zip(mesh.corners, mesh.area_vectors, strict=True):
        if vector[2] != 0.0:
            over = np.flatnonzero(_over(corners, x, y))
            above = _height(corners, vector, x[over], y[over]) > z[over]
            count[over[above]] += 1 if vector[2] > 0.0 else -1
    return count > 0


def _points_in(mesh: Mesh) -> FloatArray:
    """Even points (N, 3) in a mesh, about `_POINTS`."""
    from scipy.stats import qmc

    low, high = mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)
    share = mesh.volume / float(np.prod(high - low))
    count = math.ceil(math.log2(_POINTS / share))
    # Displaced, so that no line along z passes through an edge of a body with symmetries.
    places = (qmc.Sobol(3, scramble=False).random_base2(count) + np.sqrt([0.2, 0.3, 0.5])) % 1.0
    points = low + (high - low) * places
    return points[_inside(mesh, points)]


def _height(corners: FloatArray, vector: FloatArray, x: FloatArray, y: FloatArray) -> FloatArray:
    """z of the plane of a triangle (3, 3) with a normal (3,) at x, y."""
    rise = vector[0] * (x - corners[0, 0]) + vector[1] * (y - corners[0, 1])
    return corners[0, 2] - rise / vector[2]


def _filled(mesh: Mesh, count: int) -> tuple[list[FloatArray], Any]:
    """Coordinates x, y, z of a grid over a closed mesh, and whether its points lie within."""
    low, high = mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)
    step = (high - low) / count
    # Walls lie midway between points, two cells of which are outside; a little off the middle no
    # line along z passes through an edge of a body with symmetries.
    count += 4
    grid = list((low + step * (np.arange(count)[:, None] - 1.5 + _OFF_MIDDLE)).T)
    crossed = np.zeros((count, count, count + 1), dtype=np.int32)
    for corners, vector in zip(mesh.corners, mesh.area_vectors, strict=True):
        if vector[2] == 0.0:
            continue
        first = np.maximum(np.ceil((corners.min(axis=0) - [axis[0] for axis in grid]) / step), 0)
        last = np.floor((corners.max(axis=0) - [axis[0] for axis in grid]) / step)
        i, j = (np.arange(int(first[k]), min(int(last[k]), count - 1) + 1) for k in range(2))
        x, y = np.meshgrid(grid[0][i], grid[1][j], indexing="ij")
        z = _height(corners, vector, x, y)
        over = _over(corners, x, y)
        below = np.clip(np.floor((z - grid[2][0]) / step[2]) + 1, 0, count).astype(int)
        rows, columns = np.nonzero(over)
        sign = 1 if vector[2] > 0.0 else -1
        np.add.at(crossed, (i[rows], j[columns], below[over]), sign)
    # The points below a facet that faces up are inside, by as many as there are.
    above = np.cumsum(crossed[:, :, ::-1], axis=2)[:, :, ::-1]
    return grid, above[:, :, 1:] > 0


def _over(corners: FloatArray, x: FloatArray, y: FloatArray) -> Any:
    """Whether lines along z at x, y pass through a triangle (3, 3)."""
    sides = []
    for k in range(3):
        a, b = corners[k], corners[(k + 1) % 3]
        sides.append((b[0] - a[0]) * (y - a[1]) - (b[1] - a[1]) * (x - a[0]))
    same = np.sign(sides)
    return (np.min(same, axis=0) > 0) | (np.max(same, axis=0) < 0)
