"""Boxes around facets that lie together: whole groups that cannot hide the sky are skipped at once.

The tree is complete: node k has the children 2 k and 2 k + 1, the root is 1, and the leaves hold
LEAF facets each, which are neighbours along a curve that fills space.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from attitude.annotations import FloatArray, IntArray

# Facets of a leaf.
LEAF = 4
# Bits of each coordinate of a place on the curve.
_BITS = 20


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


def hierarchy_of(corners: FloatArray) -> Hierarchy:
    """The `Hierarchy` of facets (F, 3, 3)."""
    order = np.argsort(_along_the_curve(np.mean(corners, axis=1)), kind="stable")
    leaves = 1 << max(0, int(np.ceil(np.log2(len(corners) / LEAF))))
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


def _along_the_curve(points: FloatArray) -> IntArray:
    """Places (N,) on Morton's curve, which alternates the bits of the coordinates, of (N, 3)."""
    low = np.min(points, axis=0)
    size = np.max(np.max(points, axis=0) - low)
    cells = ((points - low) / (size or 1.0) * ((1 << _BITS) - 1)).astype(np.int64)
    places = np.zeros(len(points), dtype=np.int64)
    for bit in range(_BITS):
        for axis in range(3):
            places |= (cells[:, axis] >> bit & 1) << (3 * bit + axis)
    return places
