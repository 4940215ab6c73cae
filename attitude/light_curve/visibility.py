"""Which parts of which facets are free to the sky, from everywhere: shadows without rays.

The sky is a cube of 6 n^2 cells.  For each facet eight points are taken, and for each point every
facet that rises above its horizon is painted onto the cube, row by row: a triangle seen from a
point is a triangle on each face.  One bit for each point and cell says whether the sky is free;
sunlight and sight are then two table rows, and the points both lit and seen the bits that both
share.  So nothing is assumed about the overlap of shadow and occultation.

Each of the eight points looks at its own place within a cell, so that their mean over a cell
stands for the cell and not for its middle.
"""

from dataclasses import dataclass

import numpy as np

from attitude.errors import AttitudeError
from attitude.light_curve.clusters import SIZE, Clusters, clusters_of
from attitude.shape import Mesh
from attitude.shape.closure import parts

POINTS = 8
_LARGEST = 1 << 28
# Twice as fine halves the error and costs four times the memory: see Visibility.of.
_FINEST = 64


@dataclass(frozen=True, eq=False, repr=False)
class Visibility:
    """The table of a mesh; `Visibility.of` makes it, `brightness` uses it.

    masks : (6 n^2, places) uint8, a bit for each point of the facet in that place of `clusters`.
    resolution : n.
    clusters : the facets in the order of the table.
    corners : (F, 3, 3), those of the mesh, m.
    """

    masks: np.ndarray
    resolution: int
    clusters: Clusters
    corners: np.ndarray

    def __post_init__(self):
        for array in (self.masks, self.corners):
            array.flags.writeable = False

    def __reduce__(self):
        return Visibility, (self.masks, self.resolution, self.clusters, self.corners)

    def __repr__(self):
        size = self.masks.nbytes / 2**20
        return f"<Visibility: {self.resolution} cells along an edge of the sky, {size:.0f} MiB>"

    @classmethod
    def of(cls, mesh, *, resolution=None, threads=1, progress=None):
        """The table of a mesh.

        Parameters
        ----------
        mesh : Mesh
            Of one closed surface only sides that face a point can hide the sky from it.  Of an open
            mesh, or one of several parts, both: what lies within another part is dark.
        resolution : int
            Cells along an edge of the cube, 4 to 512: angles of 90 deg / resolution.  Unless given,
            64 or as many as make a table of 256 MiB.
        threads : int
        progress : callable, optional
            Called with (facets done, facets in all).

        Shadows pass over a facet in eight steps: of spacecraft of few large facets divide them
        first (`Mesh.divided`).

        Accuracy against rays cast from the same points, for a waisted and cratered body of 2000
        facets, random directions and phase angles up to 90 deg, in mmag rms (without shadows 136):
        4.9 with resolution 32, 2.4 with 64, 1.3 with 128; against rays from the centroids 5.1,
        2.9 and 2.0.  See benchmarks/light_curve.py.
        """
        require_mesh(mesh)
        clusters = clusters_of(mesh)
        places = clusters.count * SIZE
        if resolution is None:
            resolution = int(min(_FINEST, max(16, np.sqrt(_LARGEST / (6 * places)))))
        if not (isinstance(resolution, (int, np.integer)) and 4 <= resolution <= 512):
            raise AttitudeError(
                f"resolution is {resolution!r}; give a whole number of cells from 4 to 512."
            )
        masks = _painted(mesh, clusters, int(resolution), threads, progress)
        return cls(masks, int(resolution), clusters, mesh.corners)

    def is_of(self, mesh):
        """Whether the table, perhaps read from a file, is that of a mesh.

        Corners tell: other meshes may have the same normals and areas, as wings farther from a box.
        """
        own = clusters_of(mesh)
        return self.clusters is own or (
            np.array_equal(self.corners, mesh.corners)
            and np.array_equal(self.clusters.order, own.order)
        )


def require_mesh(given):
    """Refuse what has no facets."""
    if not isinstance(given, Mesh):
        raise AttitudeError(
            f"mesh is {given!r}; give an attitude.shape Mesh, such as Ellipsoid.facets(count) or "
            "box(size)."
        )


def points_of(corners):
    """(F, POINTS, 3): points that share each triangle evenly, the same in every facet."""
    # A Kronecker sequence of the plastic number fills the square, folded onto the triangle
    # (Roberts 2018).  Of 40000 starts this is the one with the best moments: the mean is the
    # centroid to 6e-4, second moments are the triangle's to 0.014, and every weight is above 0.04.
    u, v = plane_filling(POINTS, 0.815, 0.055)
    fold = u + v > 1.0
    u, v = np.where(fold, 1.0 - u, u), np.where(fold, 1.0 - v, v)
    weights = np.stack([1.0 - u - v, u, v], axis=1)
    return np.einsum("pk,fki->fpi", weights, corners)


def plane_filling(count, first=0.5, second=0.5):
    """Two arrays of `count` numbers from 0 to 1 that fill a square evenly, from a given start."""
    plastic = 1.32471795724474602596
    k = np.arange(count)
    return (first + k / plastic) % 1.0, (second + k / plastic**2) % 1.0


def _painted(mesh, clusters, resolution, threads, progress):
    from attitude.light_curve import painting
    from attitude.light_curve.blocks import in_blocks

    cells = 6 * resolution**2
    masks = np.empty((cells, clusters.count * SIZE), dtype=np.uint8)
    # About the mesh's own middle, so that heights keep their digits wherever the origin is.
    corners = mesh.corners - np.mean(mesh.centroids, axis=0)
    points = np.ascontiguousarray(points_of(corners))
    shift = np.stack(plane_filling(POINTS), axis=1) - 0.5
    normals = np.ascontiguousarray(mesh.normals)
    both = not mesh.is_closed or bool(np.any(parts(mesh.facets, len(mesh.vertices))))

    def work(begin, end):
        for k in range(begin, end):
            members = clusters.order[k * SIZE : (k + 1) * SIZE]
            painting.paint(
                corners, normals, points, members, shift, resolution, both, masks, k * SIZE
            )

    in_blocks(work, clusters.count, 1, threads, progress)
    return masks
