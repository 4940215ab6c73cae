"""Outlines of groups of facets: a group that shows its front hides the sky within its outline.

An edge between two facets of a group is passed once each way and cancels, so that the outline of
some hundred facets has a few dozen edges.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from attitude.light_curve.hierarchy import LEAF, Hierarchy
from attitude.shape.closure import edges_of

if TYPE_CHECKING:
    from attitude.annotations import FloatArray, IntArray


@dataclass(frozen=True, eq=False)
class Outlines:
    """The outlines of the nodes of a `Hierarchy`, and bounds of the directions that they face.

    Attributes
    ----------
    edges : (N, 6) array
        Start and end of edges, m: the outline of each node, then all edges of the facets of each
        leaf, each once.
    sides : (N, 2) array of int
        The places in the tree of the facets to the left and to the right of each edge; LEAF L
        where there is none.
    first : (3 L + 1,) array of int
        Node k has the edges first[k] to first[k + 1], and the leaf of node L + k those from
        first[2 L + k] to first[2 L + k + 1].
    fronts : (2 L, 8) array
        The smallest and the largest components of the normals of the facets of a node, and the
        smallest and the largest height of their planes above the middle of its box, m.
    """

    edges: FloatArray
    sides: IntArray
    first: IntArray
    fronts: FloatArray


def outlines_of(
    tree: Hierarchy, facets: IntArray, corners: FloatArray, normals: FloatArray
) -> Outlines:
    """The `Outlines` of a tree of facets (F, 3), whose corners are (F, 3, 3), normals (F, 3)."""
    leaves = len(tree.boxes) // 2
    place = np.empty(len(facets) + 1, dtype=np.int64)
    place[tree.order] = np.arange(len(facets))
    place[-1] = leaves * LEAF
    mates = edges_of(facets, int(np.max(facets)) + 1).mates.reshape(-1)
    sides = np.column_stack([np.repeat(place[:-1], 3), place[np.where(mates < 0, -1, mates // 3)]])
    own, other = sides[:, 0] // LEAF + leaves, sides[:, 1] // LEAF + leaves
    other[mates < 0] = 0
    once = np.flatnonzero((own != other) | (np.arange(len(own)) < mates))
    found, nodes = [once], [own[once] + leaves]
    while own[0] > 0:
        outer = np.flatnonzero(own != other)
        found.append(outer)
        nodes.append(own[outer])
        own, other = own >> 1, other >> 1
    edge, node = np.concatenate(found), np.concatenate(nodes)
    edge = edge[np.argsort(node, kind="stable")]
    facet, corner = edge // 3, edge % 3
    lines = np.concatenate([corners[facet, corner], corners[facet, (corner + 1) % 3]], axis=1)
    first = np.concatenate([[0], np.cumsum(np.bincount(node, minlength=3 * leaves))])
    return Outlines(lines, sides[edge], first, _fronts(tree, corners, normals))


def _fronts(tree: Hierarchy, corners: FloatArray, normals: FloatArray) -> FloatArray:
    """The bounds `Outlines.fronts`, level by level."""
    leaves = len(tree.boxes) // 2
    found = np.zeros((2 * leaves, 8))
    own, place = normals[tree.order], corners[tree.order, 0]
    level, group = leaves, LEAF
    while level >= 1:
        first = np.arange(0, len(own), group)
        rows = slice(level, level + len(first))
        middle = 0.5 * (tree.boxes[rows, :3] + tree.boxes[rows, 3:])
        from_middle = place - np.repeat(middle, group, axis=0)[: len(own)]
        heights = np.einsum("fi,fi->f", own, from_middle)
        found[rows, :3] = np.minimum.reduceat(own, first)
        found[rows, 3:6] = np.maximum.reduceat(own, first)
        found[rows, 6] = np.minimum.reduceat(heights, first)
        found[rows, 7] = np.maximum.reduceat(heights, first)
        level, group = level // 2, 2 * group
    return found
