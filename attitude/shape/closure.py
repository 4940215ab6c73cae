"""How triangles are joined along their edges, and which facets are at fault.

The facets of a surface without boundary pass every edge as often one way as the other.  That also
holds for two plates back to back and for parts that touch along an edge, which are legal; it fails
at holes and where a facet runs against its neighbour.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from attitude.immutable import frozen

if TYPE_CHECKING:
    from attitude.annotations import FloatArray, IntArray

# Weights by which the coordinates of a corner, and the corners of a facet, become one number that
# differs between facets; equal numbers are compared in full.
_OF_AXES = np.sqrt([2.0, 3.0, 5.0])
_OF_CORNERS = np.sqrt([7.0, 11.0, 13.0])


@dataclass(frozen=True, eq=False)
class Edges:
    """The edges of facets; edge 3 f + k runs from corner k of facet f to the next.

    Attributes
    ----------
    unbalanced : (N,) array of int
        Sorted indices of the facets with an edge that is passed more often one way than the other.
    repeated : (M,) array of int
        Those among them at an edge that is passed twice in the same direction.
    mates : (F, 3) array of int
        The edge of the neighbour that passes the same vertices the other way; -1 where an edge
        belongs to one facet or to more than two.
    """

    unbalanced: IntArray
    repeated: IntArray
    mates: IntArray


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


def doubled_facets(corners: FloatArray) -> tuple[int, int] | None:
    """Two of the facets (F, 3, 3) with the same corners in the same cyclic order, if there are any.

    A facet and its opposite, which are the two sides of a plate, are different facets.
    """
    numbers = corners @ _OF_AXES
    turn = (np.argmin(numbers, axis=1)[:, None] + np.arange(3)) % 3
    key = np.take_along_axis(numbers, turn, axis=1) @ _OF_CORNERS
    order = np.argsort(key)
    alike = np.flatnonzero(key[order[1:]] == key[order[:-1]])
    one, other = order[alike], order[alike + 1]
    turned = [np.take_along_axis(corners[f], turn[f, :, None], axis=1) for f in (one, other)]
    same = np.flatnonzero(np.all(turned[0] == turned[1], axis=(1, 2)))
    if len(same) == 0:
        return None
    pairs = np.sort(np.stack([one[same], other[same]], axis=1), axis=1)
    low, high = pairs[np.argmin(pairs[:, 0])]
    return int(low), int(high)


def inward_facets(vertices: FloatArray, facets: IntArray) -> IntArray:
    """Sorted indices of the facets (F, 3) of closed parts that are inside out.

    A part with negative volume is inside out, unless it lies within another: then it is the wall
    of a cavity.  The facets must be closed.
    """
    part = parts(facets, len(vertices))
    corners = vertices[facets]
    # Relative to the first corner of the part, so that parts far from the origin lose no digits.
    _, first = np.unique(part, return_index=True)
    mine = corners - corners[first[part], 0][:, None]
    six = np.einsum("fi,fi->f", mine[:, 0], np.cross(mine[:, 1], mine[:, 2]))
    volume, size = np.bincount(part, six), np.bincount(part, np.abs(six))
    # Two plates back to back have a volume of zero up to rounding, of either sign.
    bad = [
        np.flatnonzero(part == label)
        for label in np.flatnonzero(volume < -1e-9 * size)
        if abs(winding_number(corners[first[label], 0], corners[part != label])) < 0.5
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
