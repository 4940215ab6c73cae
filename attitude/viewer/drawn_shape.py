"""The surface that is drawn: the facets of a shape, the ellipsoid of inertia, or a box."""

from __future__ import annotations

import warnings
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from attitude.errors import AttitudeWarning
from attitude.shape import Ellipsoid, Mesh, box
from attitude.viewer import poinsot

if TYPE_CHECKING:
    from attitude.annotations import FloatArray, IntArray
    from attitude.viewer.subject import Subject

# Most facets that are drawn; of a finer mesh, vertices within small cubes become one.
MOST: int = 200_000
# Facets of the coarser mesh that is drawn while frames take too long.
COARSE: int = 10_000
# Facets of an ellipsoid.
_FACETS = 5120
# m, of a body without a known shape or inertia.
_BOX = (1.0, 0.7, 0.45)


class Surface(NamedTuple):
    """Triangles in body axes.

    Attributes
    ----------
    vertices : (V, 3) array
        In units of the greatest distance of a vertex from the origin.
    facets : (F, 3) array of int
    kind : str
        "mesh", "ellipsoid", "ellipsoid of inertia" or "box".
    size : float
        The unit of the vertices in m; NaN if the size is unknown.
    closed : bool
        Whether no facet is seen from behind.
    """

    vertices: FloatArray
    facets: IntArray
    kind: str
    size: float
    closed: bool


def surface(subject: Subject, most: int = MOST) -> Surface:
    """The surface of a subject, of at most about `most` facets.

    Warns
    -----
    AttitudeWarning
        If the mesh has more facets than are drawn.
    """
    shape = subject.shape
    if isinstance(shape, Ellipsoid):
        return _scaled(shape.facets(min(_FACETS, most)), "ellipsoid")
    if isinstance(shape, Mesh):
        found = _scaled(_drawn(shape, most), "mesh", np.linalg.norm(shape.vertices, axis=1).max())
        return found._replace(closed=shape.is_closed and not len(shape.inward_facets))
    ellipsoid = poinsot.inertia_ellipsoid(subject.motion.body)
    if ellipsoid is None:
        return _scaled(box(_BOX), "box")._replace(size=np.nan)
    ball = Ellipsoid((1.0, 1.0, 1.0)).facets(min(_FACETS, most))
    stretched = ball.vertices * ellipsoid.semi_axes @ ellipsoid.axes.T
    found = _scaled((stretched, ball.facets), "ellipsoid of inertia")
    return found._replace(size=np.nan)


def _scaled(
    mesh: Mesh | tuple[FloatArray, IntArray], kind: str, size: float | None = None
) -> Surface:
    vertices, facets = (mesh.vertices, mesh.facets) if isinstance(mesh, Mesh) else mesh
    if size is None:
        size = np.linalg.norm(vertices, axis=1).max()
    return Surface(vertices / size, facets, kind, float(size), closed=True)


def _drawn(mesh: Mesh, most: int) -> Mesh | tuple[FloatArray, IntArray]:
    """The mesh, or vertices and facets of a coarser one, with a warning."""
    if len(mesh) <= most:
        return mesh
    vertices, facets = coarser(mesh.vertices, mesh.facets, most)
    warnings.warn(
        f"the mesh has {len(mesh)} facets, of which a page draws {most} at most: it is drawn with "
        f"{len(facets)}; brightness follows from all of them.",
        AttitudeWarning,
        stacklevel=2,
    )
    return vertices, facets


def coarser(vertices: FloatArray, facets: IntArray, most: int) -> tuple[FloatArray, IntArray]:
    """Vertices and facets of a surface with at most `most` facets, from one that has more."""
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    # A closed surface of n^2 cubes a side has some 12 n^2 triangles.
    cells = np.sqrt(most / 12.0)
    best, tried = None, 0
    while best is None or (len(best[1]) < 0.8 * most and tried < 6):
        found = _clustered(vertices, facets, low, float(np.max(high - low)) / cells)
        count = len(found[1])
        if count <= most and (best is None or count > len(best[1])):
            best = found
        cells *= 0.95 * np.sqrt(most / max(count, 1))
        tried += 1
    return best


def _clustered(
    vertices: FloatArray, facets: IntArray, low: FloatArray, side: float
) -> tuple[FloatArray, IntArray]:
    """Vertices in cubes of a side, each cube's as one, and the facets that keep three corners."""
    cubes = np.floor((vertices - low) / side).astype(np.int64)
    key = (cubes[:, 0] << 42) | (cubes[:, 1] << 21) | cubes[:, 2]
    _, member, count = np.unique(key, return_inverse=True, return_counts=True)
    means = [np.bincount(member, vertices[:, k]) / count for k in range(3)]
    corners = member[facets]
    a, b, c = corners.T
    kept = corners[(a != b) & (b != c) & (c != a)]
    # Each triangle once, whichever corner it begins with.
    first = np.argmin(kept, axis=1)[:, None]
    turned = np.take_along_axis(kept, (first + np.arange(3)) % 3, axis=1)
    return np.stack(means, axis=1), np.unique(turned, axis=0)
