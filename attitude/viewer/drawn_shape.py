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
    """

    vertices: FloatArray
    facets: IntArray
    kind: str
    size: float


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
        return _scaled(_coarser(shape, most), "mesh", np.linalg.norm(shape.vertices, axis=1).max())
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
    return Surface(vertices / size, facets, kind, float(size))


def _coarser(mesh: Mesh, most: int) -> Mesh | tuple[FloatArray, IntArray]:
    """The mesh, or vertices and facets of one with at most `most` facets."""
    if len(mesh) <= most:
        return mesh
    low, high = mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)
    # A closed surface of n^2 cubes a side has some 12 n^2 triangles.
    cells = np.sqrt(most / 12.0)
    while True:
        vertices, facets = _clustered(mesh, low, float(np.max(high - low)) / cells)
        if len(facets) <= most:
            break
        cells *= 0.9 * np.sqrt(most / len(facets))
    warnings.warn(
        f"the mesh has {len(mesh)} facets, of which a page draws {most} at most: it is drawn with "
        f"{len(facets)}; brightness follows from all of them.",
        AttitudeWarning,
        stacklevel=2,
    )
    return vertices, facets


def _clustered(mesh: Mesh, low: FloatArray, side: float) -> tuple[FloatArray, IntArray]:
    """Vertices in cubes of a side, each cube's as one, and the facets that keep three corners."""
    cubes = np.floor((mesh.vertices - low) / side).astype(np.int64)
    key = (cubes[:, 0] << 42) | (cubes[:, 1] << 21) | cubes[:, 2]
    _, member, count = np.unique(key, return_inverse=True, return_counts=True)
    means = [np.bincount(member, mesh.vertices[:, k]) / count for k in range(3)]
    facets = member[mesh.facets]
    a, b, c = facets.T
    kept = facets[(a != b) & (b != c) & (c != a)]
    # Each triangle once, whichever corner it begins with.
    first = np.argmin(kept, axis=1)[:, None]
    turned = np.take_along_axis(kept, (first + np.arange(3)) % 3, axis=1)
    return np.stack(means, axis=1), np.unique(turned, axis=0)
