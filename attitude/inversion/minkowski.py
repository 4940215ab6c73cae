"""The convex polyhedron with given areas and normals of its facets: Minkowski's problem.

The heights h of the planes minimise log(sum a h) - log(V)/3, where V is the volume of the
polyhedron (Little, "Extended Gaussian images", 1985; the derivative of V by a height is the area
of the facet).  Polyhedra come from the convex hull of their polar duals.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from attitude.shape import Mesh

if TYPE_CHECKING:
    from attitude.annotations import FloatArray

_ITERATIONS = 400
# Corners closer than this, over the size of the body, are one.
_MERGED = 1e-4


def closed(areas: FloatArray, normals: FloatArray) -> FloatArray:
    """Areas (F,) changed least, relative to their size, such that the surface closes."""
    weighted = normals * areas
    inner = weighted @ normals.T
    factor = 1.0 - normals.T @ np.linalg.solve(inner, normals @ areas)
    return areas * np.maximum(factor, 1e-6)


def mesh(areas: FloatArray, normals: FloatArray) -> Mesh:
    """The polyhedron as a mesh about its centre of mass, of the volume of the unit sphere.

    Parameters
    ----------
    areas : (F,) array
    normals : (3, F) array
        Unit vectors.
    """
    from scipy.optimize import minimize

    given = closed(areas, normals)
    given = given / given.sum()
    scale = np.sqrt((normals**2 * given).sum(axis=1))
    start = np.sqrt(np.sum((normals / scale[:, None]) ** 2, axis=0))

    def cost(logs: FloatArray) -> tuple[float, FloatArray]:
        heights = np.exp(logs)
        _, here = _polyhedron(heights, normals)
        volume, total = heights @ here / 3.0, given @ heights
        slope = given / total - here / (3.0 * volume)
        return float(np.log(total) - np.log(volume) / 3.0), slope * heights

    found = minimize(
        cost, np.log(start), jac=True, method="L-BFGS-B", options={"maxiter": _ITERATIONS}
    )
    corners, _ = _polyhedron(np.exp(found.x), normals)
    return _meshed(corners)


def _polyhedron(heights: FloatArray, normals: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Corners (V, 3) and areas (F,) of the polyhedron of planes n.x = h."""
    from scipy.spatial import ConvexHull

    dual = (normals / heights).T
    hull = ConvexHull(dual)
    # a facet of the dual, n.x + d = 0, is the corner -n/d
    corners = -hull.equations[:, :3] / hull.equations[:, 3:]
    areas = np.zeros(len(heights))
    simplices, neighbours = hull.simplices, hull.neighbors
    for k in range(3):
        # the neighbour across from corner k shares the two others
        first, second = simplices[:, (k + 1) % 3], simplices[:, (k + 2) % 3]
        length = np.linalg.norm(corners - corners[neighbours[:, k]], axis=1)
        cosine = np.sum(normals[:, first] * normals[:, second], axis=0)
        sine = np.sqrt(np.maximum(1.0 - cosine**2, 1e-30))
        # each edge is met from both sides
        for a, b in ((first, second), (second, first)):
            distance = (heights[b] - heights[a] * cosine) / sine
            areas += np.bincount(a, 0.25 * distance * length, len(areas))
    return corners, areas


def _meshed(corners: FloatArray) -> Mesh:
    from scipy.spatial import ConvexHull

    size = float(np.ptp(corners, axis=0).max())
    _, kept = np.unique(np.round(corners / (size * _MERGED)), axis=0, return_index=True)
    points = corners[np.sort(kept)]
    hull = ConvexHull(points)
    points, facets = points[hull.vertices], np.searchsorted(hull.vertices, hull.simplices)
    a, b, c = (points[facets[:, k]] for k in range(3))
    outward = np.sum(np.cross(b - a, c - a) * (a + b + c - 3.0 * points.mean(axis=0)), axis=1) > 0.0
    facets = np.where(outward[:, None], facets, facets[:, ::-1])
    rough = Mesh(points, facets)
    found = rough.mass_properties(density=1.0)
    radius = (3.0 * found.mass / (4.0 * np.pi)) ** (1.0 / 3.0)
    return Mesh((points - found.center_of_mass) / radius, facets)
