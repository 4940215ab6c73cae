"""Even triangulations of the unit sphere: the icosahedron, divided and relaxed."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from attitude.annotations import FloatArray, IntArray

# Each pass moves a vertex to the mean of its triangles, weighted by their areas; 30 passes bring
# the ratio of smallest to largest area from 0.58 to 0.71, its limit.
_PASSES = 30


def unit_sphere(frequency: int) -> tuple[FloatArray, IntArray]:
    """Vertices (10 f^2 + 2, 3) and outward triangles (20 f^2, 3) on the unit sphere."""
    corners, faces = _icosahedron()
    f = frequency
    i, j = (grid.ravel() for grid in np.meshgrid(np.arange(f + 1), np.arange(f + 1)))
    i, j = i[i + j <= f], j[i + j <= f]
    weights = np.stack([f - i - j, i, j], axis=1)
    row = np.full((f + 2, f + 2), -1)
    row[i, j] = np.arange(len(i))
    up = [(row[a, b], row[a + 1, b], row[a, b + 1]) for a in range(f) for b in range(f - a)]
    down = [
        (row[a + 1, b], row[a + 1, b + 1], row[a, b + 1])
        for a in range(f - 1)
        for b in range(f - 1 - a)
    ]
    pattern = np.array(up + down)
    points = np.einsum("pk,tki->tpi", weights / f, corners[faces]).reshape(-1, 3)
    # Points on shared edges agree up to rounding; a grid far finer than 1/f joins them.
    key = np.rint(points * 1e7).astype(np.int64)
    _, first, joined = np.unique(key, axis=0, return_index=True, return_inverse=True)
    offsets = np.arange(len(faces))[:, None, None] * len(i)
    triangles = joined.reshape(-1)[(pattern[None] + offsets).reshape(-1, 3)]
    return _relaxed(_unit(points[first]), triangles), triangles


def lifted(vertices: FloatArray, triangles: IntArray) -> FloatArray:
    """Vertices (V, 3) of `unit_sphere`, lifted so that the polyhedron has the area of the sphere.

    A facet cuts off a cap whose height grows with its area, so each vertex is lifted in proportion
    to the area of its own facets: the brightness of 980 facets then errs by 0.46 mmag, against
    0.54 with all vertices at one radius.  Optimal positions of all vertices gain no more.
    """
    share = np.bincount(triangles.ravel(), np.repeat(_areas(vertices, triangles), 3))
    share = share / np.mean(share)
    lift = 0.0
    for _ in range(12):  # each step reduces the error a hundredfold
        sphere = vertices * (1.0 + lift * share)[:, None]
        area = np.sum(_areas(sphere, triangles))
        lift += 0.5 * (4.0 * np.pi / area - 1.0)
    return sphere


def _areas(vertices: FloatArray, triangles: IntArray) -> FloatArray:
    a, b, c = (vertices[triangles[:, k]] for k in range(3))
    return 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1)


def _relaxed(vertices: FloatArray, triangles: IntArray) -> FloatArray:
    """The vertices after all passes of relaxation."""
    count = len(vertices)
    for _ in range(_PASSES):
        a, b, c = (vertices[triangles[:, k]] for k in range(3))
        weight = _areas(vertices, triangles)
        pull = weight[:, None] * (a + b + c)
        vertices = _unit(
            np.stack(
                [np.bincount(triangles.ravel(), np.repeat(pull[:, k], 3), count) for k in range(3)],
                axis=1,
            )
        )
    return vertices


def _icosahedron() -> tuple[FloatArray, IntArray]:
    g = (1.0 + np.sqrt(5.0)) / 2.0
    vertices = [
        [(-1, g, 0), (1, g, 0), (-1, -g, 0), (1, -g, 0)],
        [(0, -1, g), (0, 1, g), (0, -1, -g), (0, 1, -g)],
        [(g, 0, -1), (g, 0, 1), (-g, 0, -1), (-g, 0, 1)],
    ]
    faces = [
        [(0, 11, 5), (0, 5, 1), (0, 1, 7), (0, 7, 10), (0, 10, 11)],
        [(1, 5, 9), (5, 11, 4), (11, 10, 2), (10, 7, 6), (7, 1, 8)],
        [(3, 9, 4), (3, 4, 2), (3, 2, 6), (3, 6, 8), (3, 8, 9)],
        [(4, 9, 5), (2, 4, 11), (6, 2, 10), (8, 6, 7), (9, 8, 1)],
    ]
    return _unit(np.reshape(vertices, (-1, 3))), np.reshape(faces, (-1, 3))


def _unit(vectors: FloatArray) -> FloatArray:
    return vectors / np.linalg.norm(vectors, axis=1, keepdims=True)
