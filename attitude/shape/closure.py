"""Whether triangles bound a solid, and if not, which facets are at fault.

The facets of a surface without boundary pass every edge as often one way as the other.  That also
holds for two plates back to back and for parts that touch along an edge, which are legal; it fails
at holes and where a facet runs against its neighbour.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from attitude.annotations import FloatArray, IntArray


def open_facets(facets: IntArray) -> IntArray:
    """Sorted indices of the facets (F, 3) with an edge not balanced by one the other way."""
    start, end = facets[:, [0, 1, 2]].ravel(), facets[:, [1, 2, 0]].ravel()
    owner = np.repeat(np.arange(len(facets)), 3)
    low, high = np.minimum(start, end), np.maximum(start, end)
    _, edge = np.unique(np.stack([low, high]), axis=1, return_inverse=True)
    edge = edge.reshape(-1)
    balance = np.bincount(edge, weights=np.where(start < end, 1.0, -1.0))
    return np.unique(owner[balance[edge] != 0.0])


def inward_facets(vertices: FloatArray, facets: IntArray) -> IntArray:
    """Sorted indices of the facets (F, 3) of closed parts that are inside out.

    A part with negative volume is inside out, unless it lies within another: then it is the wall
    of a cavity.  Empty for an open mesh.
    """
    if len(open_facets(facets)):
        return np.zeros(0, dtype=np.int64)
    part = parts(facets, len(vertices))
    corners = vertices[facets]
    bad = []
    for label in range(np.max(part) + 1):
        own = part == label
        mine = corners[own] - corners[own][0, 0]
        six = np.einsum("fi,fi->f", mine[:, 0], np.cross(mine[:, 1], mine[:, 2]))
        # Two plates back to back have a volume of zero up to rounding, of either sign.
        if np.sum(six) >= -1e-9 * np.sum(np.abs(six)):
            continue
        point = vertices[facets[own][0, 0]]
        if abs(winding_number(point, corners[~own])) < 0.5:
            bad.append(np.flatnonzero(own))
    return np.concatenate(bad) if bad else np.zeros(0, dtype=np.int64)


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
    """Number of times that closed triangles (F, 3, 3) wind about a point (3,): 1 inside, 0 outside.

    The sum of the solid angles of the facets over 4 pi (Van Oosterom & Strackee 1983, eq. 8).
    """
    a, b, c = np.moveaxis(corners - point, 1, 0)
    la, lb, lc = (np.linalg.norm(v, axis=-1) for v in (a, b, c))
    above = np.einsum("fi,fi->f", a, np.cross(b, c))
    below = (
        la * lb * lc
        + np.einsum("fi,fi->f", a, b) * lc
        + np.einsum("fi,fi->f", b, c) * la
        + np.einsum("fi,fi->f", c, a) * lb
    )
    return float(np.sum(np.arctan2(above, below)) / (2.0 * np.pi))
