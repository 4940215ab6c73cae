"""Whether a closed mesh is convex, from its edges: O(F) for F facets.

A closed surface is the boundary of a convex body if some point sees the front of no facet, the
surface winds once about this point, and no edge is a valley.  The first two properties make the
projection from the point a one-to-one map onto the sphere: the surface does not cross itself.  The
corners of such a surface are convex where its edges are, and a body that is convex at each point of
its boundary is convex (Tietze 1928, Nakajima 1928).
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from attitude.shape import closure
from attitude.shape.rounding import height_errors

if TYPE_CHECKING:
    from attitude.annotations import FloatArray, IntArray

# Edges, or facets of a flat body, that are examined at a time.
_BLOCK = 1 << 16


def is_convex(
    corners: FloatArray,
    normals: FloatArray,
    mates: IntArray,
    tolerance: float,
    rounding: float = 0.0,
) -> bool:
    """Whether no vertex rises above the plane of a facet.

    Parameters
    ----------
    corners : (F, 3, 3) array
        Of the facets of a closed mesh, m.
    normals : (F, 3) array
        Outward unit normals.
    mates : (F, 3) array of int
        See `closure.Edges`.
    tolerance : float
        Heights up to this number times the size of the body, the largest coordinate from its
        middle, count as zero: those of each vertex above the facets next to it.
    rounding : float
        How much each coordinate may err, m: heights that such errors make count as zero too.
    """
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
    return abs(closure.winding_number(np.zeros(3), corners) - 1.0) < 0.5


def _edges_are_ridges(
    corners: FloatArray, normals: FloatArray, mates: IntArray, bound: float, rounding: float
) -> bool:
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


def _all_below(
    corners: FloatArray, normals: FloatArray, depth: FloatArray, bound: float, rounding: float
) -> bool:
    """The definition itself, O(F^2), for bodies so flat that their middle is in their surface."""
    points = np.unique(corners.reshape(-1, 3), axis=0)
    step = max(1, _BLOCK // len(points))
    for begin in range(0, len(normals), step):
        part = slice(begin, begin + step)
        height = normals[part] @ points.T - depth[part, None]
        facet, point = np.nonzero(height > bound)
        error = height_errors(corners[part][facet], points[point], rounding)
        if np.any(height[facet, point] > np.maximum(bound, error)):
            return False
    return True
