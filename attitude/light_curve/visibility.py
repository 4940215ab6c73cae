"""The table of directions in which each part of each facet is free: shadows without rays.

The sky is a cube of 6 n^2 cells.  Each facet has eight points.  For each point every facet that
rises above its horizon is painted onto the cube: a triangle seen from a point is a triangle on each
face of the cube.  One bit for each point and cell records whether the sky is free.
Sun and observer are then one row of the table each, and the bits that both rows share are the
points both lit and seen: no assumption about the overlap of shadow and occultation is needed.

Each of the eight points samples a cell in another direction, so that their mean represents the cell
rather than its middle.
"""

from __future__ import annotations

import time
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from attitude.errors import AttitudeError
from attitude.light_curve import table_files
from attitude.light_curve.clusters import SIZE, Clusters, clusters_of
from attitude.progress import ProgressBar
from attitude.shape import Mesh
from attitude.shape.closure import parts

if TYPE_CHECKING:
    from collections.abc import Callable
    from typing import Any

    from numpy.typing import NDArray

    from attitude.annotations import FloatArray
    from attitude.light_curve.few_facets import Packs

# Points of each facet, one bit each.
POINTS = 8
# Upper bounds of the default: bytes of the table, and cells along an edge.  Doubling the cells
# halves the error and takes four times the memory; see `Visibility.of`.
_LARGEST = 1 << 28
_FINEST = 64
# Clusters whose columns of the table, one cache line, are written together.
_AT_ONCE = 8


@dataclass(frozen=True, eq=False, repr=False)
class Visibility:
    """The table of shadows of a mesh; `Visibility.of` makes it, `brightness` uses it.

    Attributes
    ----------
    masks : (6 n^2, places) uint8 array
        For each cell of the sky and each place of `clusters`, a bit for each point of the facet:
        1 if the sky is free.
    resolution : int
        n, the number of cells along an edge of the sky.
    clusters : Clusters
        The facets in the order of the table.
    corners : (F, 3, 3) array
        Corners of the facets of the mesh, m.
    """

    masks: NDArray[np.uint8]
    resolution: int
    clusters: Clusters
    corners: FloatArray
    # The last answer of `arranged` and what it was asked with.
    _last: list[Any] = field(default_factory=list, init=False)

    def __post_init__(self) -> None:
        for array in (self.masks, self.corners):
            array.flags.writeable = False

    def __reduce__(self) -> tuple[Any, ...]:
        return Visibility, (self.masks, self.resolution, self.clusters, self.corners)

    def __repr__(self) -> str:
        size = self.masks.nbytes / 2**20
        return f"<Visibility: {self.resolution} cells along an edge of the sky, {size:.0f} MiB>"

    @classmethod
    def of(
        cls,
        mesh: Mesh,
        *,
        resolution: int | None = None,
        threads: int = 1,
        progress: Callable[[int, int], object] | None = None,
        keep: bool = True,
    ) -> Visibility:
        """The table of a mesh.

        Parameters
        ----------
        mesh : Mesh
            On one closed surface, only the front of a facet can hide the sky from a point.  On an
            open mesh, or one of several parts, both sides do: the inside of another part is dark.
        resolution : int
            Cells along an edge of the cube, 4 to 512: angles of 90 deg / resolution.  By default
            64, or as many as fit in a table of 256 MiB.
        threads : int
            Number of threads; it does not change the table.
        progress : callable, optional
            Called with (number of clusters of eight facets done, number of clusters).  By default a
            bar is drawn on standard error, if that is a terminal, after a second.
        keep : bool
            Whether the table is read from and, if it took more than a second, kept in the user's
            cache folder (`table_files`).

        Raises
        ------
        AttitudeError
            For anything but a mesh, or a resolution out of range.

        Notes
        -----
        Shadows pass over a facet in eight steps: divide the large facets of a spacecraft first
        (`Mesh.divided`).

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
        resolution = int(resolution)
        file = table_files.file_of(mesh.corners, clusters.order, resolution) if keep else None
        masks = table_files.read(file, (6 * resolution**2, places))
        if masks is None:
            begin = time.monotonic()
            if progress is None:
                progress = ProgressBar(f"shadows of {len(mesh)} facets")
            masks = _painted(mesh, clusters, resolution, threads, progress)
            if time.monotonic() - begin > table_files.WORTH:
                table_files.write(file, masks)
        return cls(masks, resolution, clusters, mesh.corners)

    def arranged(self, packs: Packs) -> NDArray[np.uint64]:
        """The masks as `few_facets.arranged` has them; those of the last packs are kept."""
        from attitude.light_curve import few_facets

        last = self._last[-1:]
        if not last or not np.array_equal(last[0][0], packs.order):
            found = few_facets.arranged(self.masks, packs, self.clusters.order)
            self._last[:] = last = [(packs.order, found)]
        words: NDArray[np.uint64] = last[0][1]
        return words

    def is_of(self, mesh: Mesh) -> bool:
        """Whether the table, which may have been unpickled, belongs to a mesh.

        The comparison needs the corners: two meshes may share all normals and areas, such as boxes
        with wings at different distances.
        """
        own = clusters_of(mesh)
        return self.clusters is own or (
            np.array_equal(self.corners, mesh.corners)
            and np.array_equal(self.clusters.order, own.order)
        )


def require_mesh(given: object) -> None:
    """AttitudeError for anything but a `Mesh`."""
    if not isinstance(given, Mesh):
        raise AttitudeError(
            f"mesh is {given!r}; give an attitude.shape Mesh, such as Ellipsoid.facets(count) or "
            "box(size)."
        )


def points_of(corners: FloatArray) -> FloatArray:
    """Points (F, POINTS, 3) that sample each triangle evenly, with the same weights of its corners.

    `corners` are (F, 3, 3).
    """
    # A Kronecker sequence of the plastic number fills the square, folded onto the triangle
    # (Roberts 2018).  Of 40000 starts this one has the best moments: the mean is the centroid to
    # 6e-4, second moments are those of the triangle to 0.014, and every weight is above 0.04.
    u, v = plane_filling(POINTS, 0.815, 0.055)
    fold = u + v > 1.0
    u, v = np.where(fold, 1.0 - u, u), np.where(fold, 1.0 - v, v)
    weights = np.stack([1.0 - u - v, u, v], axis=1)
    return np.einsum("pk,fki->fpi", weights, corners)


def plane_filling(
    count: int, first: float = 0.5, second: float = 0.5
) -> tuple[FloatArray, FloatArray]:
    """Coordinates, `count` each from 0 to 1, of points that fill a square evenly from a start."""
    plastic = 1.32471795724474602596
    k = np.arange(count)
    return (first + k / plastic) % 1.0, (second + k / plastic**2) % 1.0


def _painted(
    mesh: Mesh,
    clusters: Clusters,
    resolution: int,
    threads: int,
    progress: Callable[[int, int], object] | None,
) -> NDArray[np.uint8]:
    """The masks of a `Visibility`."""
    from attitude.blocks import in_blocks
    from attitude.light_curve import painting
    from attitude.light_curve.hierarchy import hierarchy_of
    from attitude.light_curve.outlines import outlines_of

    cells = 6 * resolution**2
    masks = np.empty((cells, clusters.count * SIZE), dtype=np.uint8)
    # With the mean of the centroids as origin, heights keep their digits wherever the mesh lies.
    corners = mesh.corners - np.mean(mesh.centroids, axis=0)
    points = np.ascontiguousarray(np.swapaxes(points_of(corners), 1, 2))
    shift = np.stack(plane_filling(POINTS), axis=1) - 0.5
    shifts = np.ascontiguousarray(shift.T).reshape(-1)
    across, up = painting.tangents(shift, resolution)
    planes = np.einsum("fi,fi->f", mesh.normals, corners[:, 0])
    tree = hierarchy_of(corners, mesh.normals)
    outlines = outlines_of(tree, mesh.facets, corners, mesh.normals)
    near = corners[tree.order]
    facing = np.column_stack([mesh.normals[tree.order], planes[tree.order]])
    normals = np.ascontiguousarray(mesh.normals)
    size = float(np.max(np.abs(corners)))
    middles, flat = painting.surroundings(points, size), points.reshape(-1)
    both = not mesh.is_closed or bool(np.any(parts(mesh.facets, len(mesh.vertices))))

    def work(begin: int, end: int) -> None:
        members = clusters.order[begin * SIZE : end * SIZE]
        painting.paint(
            *(tree.boxes, outlines.edges, outlines.sides, outlines.first, outlines.fronts),
            *(near, facing),
            *(normals, flat, middles, size, members, across, up, shifts, resolution, both),
            *painting.memory(len(members), resolution, len(tree.boxes) // 2),
            *(masks, begin * SIZE),
        )

    in_blocks(work, clusters.count, _AT_ONCE, threads, progress)
    return masks
