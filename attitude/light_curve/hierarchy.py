"""Boxes around facets that lie together: whole groups that cannot hide the sky are skipped at once.

The tree is complete: node k has the children 2 k and 2 k + 1, the root is 1, and the leaves hold
LEAF facets each.  Each group is cut across its longest extent, in space or in the directions of its
normals: groups that face one way hide the sky by their outlines.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from attitude.annotations import FloatArray, IntArray

# Facets of a leaf.
LEAF = 4
# Over the size of the body: how far apart normals that differ by one count.  Tables of a rough, a
# waisted and a winged body take the least time from 0.15 to 0.3.
_APART = 0.2


@dataclass(frozen=True, eq=False)
class Hierarchy:
    """Facets in groups of nearby ones.

    Attributes
    ----------
    boxes : (2 L, 6) array
        For each node the lowest and the highest coordinates of its facets, m; node 0 is unused.
    order : (F,) array of int
        The facets, leaf by leaf.
    """

    boxes: FloatArray
    order: IntArray


def hierarchy_of(corners: FloatArray, normals: FloatArray) -> Hierarchy:
    """The `Hierarchy` of facets (F, 3, 3) with outward normals (F, 3)."""
    leaves = 1 << max(0, int(np.ceil(np.log2(len(corners) / LEAF))))
    middles = np.mean(corners, axis=1)
    size = np.max(np.ptp(middles, axis=0))
    order = _cut(np.column_stack([middles, _APART * size * normals]), leaves)
    # Empty places lie far below every plane: boxes that hold nothing else are skipped.
    lowest = np.full((leaves * LEAF, 3), np.inf)
    highest = np.full((leaves * LEAF, 3), -np.inf)
    lowest[: len(order)] = np.min(corners, axis=1)[order]
    highest[: len(order)] = np.max(corners, axis=1)[order]
    low, high = (each.reshape(leaves, LEAF, 3) for each in (lowest, highest))
    boxes = np.zeros((2 * leaves, 6))
    level, low, high = leaves, np.min(low, axis=1), np.max(high, axis=1)
    while True:
        boxes[level : 2 * level, :3], boxes[level : 2 * level, 3:] = low, high
        if level == 1:
            return Hierarchy(boxes, order)
        level //= 2
        low = np.min(low.reshape(level, 2, 3), axis=1)
        high = np.max(high.reshape(level, 2, 3), axis=1)


def _cut(places: FloatArray, leaves: int) -> IntArray:
    """The order of facets at places (F, K), whose groups are halved along their longest extents."""
    order = np.arange(len(places))
    group = leaves * LEAF
    while group > LEAF:
        first = np.arange(0, len(order), group)
        sorted_places = places[order]
        extent = np.maximum.reduceat(sorted_places, first)
        extent -= np.minimum.reduceat(sorted_places, first)
        number = np.arange(len(order)) // group
        along = sorted_places[np.arange(len(order)), np.argmax(extent, axis=1)[number]]
        order = order[np.lexsort((along, number))]
        group //= 2
    return order
