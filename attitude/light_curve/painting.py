"""The compiled loop of `visibility` over the facets of a mesh and the groups that may hide its sky.

Groups that show their fronts are drawn by their outlines, others are divided, down to facets that
are drawn by their edges (`outline_painting`).
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from attitude.compilation.decorators import reduction, reduction_inlined, reduction_within
from attitude.light_curve.hierarchy import LEAF
from attitude.light_curve.outline_painting import (
    BACK,
    DIVIDED,
    FACES,
    FRONT,
    draw_groups,
    faces_met,
    fill,
    frame,
    show,
    side_shown,
)

if TYPE_CHECKING:
    from typing import Any

    from numpy.typing import NDArray

    from attitude.annotations import FloatArray

# Heights above the plane of a facet up to this share of the size of the body are rounding: those
# of neighbours in the same plane.
_RISE = 1e-9
_LANES = 8
# What `side_shown` does not return: a group below the horizon.
_BELOW = -2
# Unsigned: for signed indices numba adds a test for negative values to every access.
_3 = np.uint64(3)


def tangents(shift: FloatArray, resolution: int) -> tuple[FloatArray, FloatArray]:
    """Tangents along the rows and the columns of a face for each cell and point, two flat arrays.

    shift (8, 2) is in cells.
    """
    places = (np.arange(resolution)[:, None, None] + 0.5 + shift) / (0.5 * resolution) - 1.0
    # the inverse of `sums.evened`
    found = np.sign(places) * ((1.0 + np.abs(places)) ** 2 - 1.0) / 3.0
    return np.ascontiguousarray(found[..., 0]).reshape(-1), found[..., 1].flatten()


def surroundings(points: FloatArray, size: float) -> FloatArray:
    """Centre and half the edges of a box about the points (F, 3, 8) of each facet: (F, 6)."""
    middle = np.mean(points, axis=2)
    reach = np.max(np.abs(points - middle[..., None]), axis=2)
    return np.concatenate([middle, 1.001 * reach + 1e-12 * size], axis=1)


def memory(members: int, resolution: int, leaves: int) -> tuple[NDArray[Any], ...]:
    """The arrays in which `paint` works on some facets, for the leaves of a `Hierarchy`.

    numpy makes them: numba would compile a function for each.
    """
    # One count more a row, for changes beyond the last column.
    counts = np.zeros(FACES * resolution * (resolution + 1), np.uint64)
    drawn = np.zeros(2 * FACES, np.int64)
    drawn[::2] = resolution
    return (
        np.full(FACES * resolution**2 * members, 255, np.uint8),
        *(counts, counts.view(np.uint8), drawn, np.zeros(4 * FACES, np.int64)),
        *(np.zeros(leaves + 1, np.int64), np.empty(leaves, np.int64)),
        np.zeros(_LANES * LEAF * (leaves + 1)),
    )


@reduction
def paint(
    boxes, edges, sides, first_edges, fronts, corners, facing, normals, points, middles, size,
    members, across, up, shifts, resolution, both, sky, counts, changes, drawn, frames, marks,
    found, shown, masks, place,
):  # fmt: skip
    """Fill the columns of `masks` from `place` on, for the facets `members` (-1: empty place).

    `boxes` are those of a `Hierarchy`, in whose order are corners (F, 3, 3) and normals with their
    heights above the origin, `facing` (F, 4); edges to fronts are its `Outlines`; normals (F, 3)
    and points (F * 24,) with their `surroundings` are in the order of the mesh, all in m; `size` is
    that of the body.  `across` and `up` are `tangents` and `shifts` the parts of a cell by which
    points look beside its middle, along rows, then along columns; sky to shown are `memory`; masks
    are (6 resolution^2, places) uint8.  With `both`, either side of a facet hides the sky.
    """
    leaves = boxes.shape[0] // 2
    count = np.uint64(members.size)
    cells = np.uint64(masks.shape[0])
    for row in range(count):
        m = np.uint64(row)
        k = members[m]
        if k >= 0:
            faces = frame(normals[k], resolution, frames)
            groups = _look_around(
                boxes, fronts, corners, facing, normals[k], points, 24 * k, middles[k], size, both,
                faces, marks, found, shown,
            )  # fmt: skip
            draw_groups(
                found, groups, edges, sides, first_edges, corners, points, 24 * k, up, shifts,
                resolution, frames, marks, shown, changes, drawn,
            )  # fmt: skip
            for q in range(groups):
                _mark(marks, found[q], leaves, 0)
            fill(normals[k], across, up, resolution, frames, counts, drawn, sky, m, count)
    first = np.uint64(place)
    for i in range(cells):
        begin = np.uint64(i) * count
        for m in range(count):
            masks[i, first + np.uint64(m)] = sky[begin + np.uint64(m)]


@reduction_inlined
def _look_around(
    boxes, fronts, corners, facing, normal, flat, first, middle, size, both, among, marks, found,
    shown,
):  # fmt: skip
    """Mark all groups that may hide the sky of one facet; their nodes are `found`, their number.

    The points are flat[first : first + 24], x of each, then y, then z; along axis i they are within
    middle[3 + i] of middle[i].
    """
    plane = normal[0] * flat[first] + normal[1] * flat[first + 8] + normal[2] * flat[first + 16]
    lowest = plane + _RISE * size
    leaves = boxes.shape[0] // 2
    node, count = 1, 0
    while node > 0:
        inside, mark = False, 0
        side = _BELOW
        if _highest(boxes, np.uint64(node), normal) > plane + 0.5 * _RISE * size:
            side = side_shown(boxes, fronts, node, middle)
        if side == 0 and node < leaves:
            inside = True
        elif side >= (-1 if both else 0):
            faces = faces_met(boxes, node, middle, among)
            if side != 0 and faces >> FACES == 0:
                mark = faces | (FRONT if side > 0 else BACK) if faces != 0 else 0
            elif node < leaves:
                inside = True
            elif faces != 0 and show(
                corners, facing, node - leaves, normal, lowest, flat, first, both, shown
            ):
                mark = faces | DIVIDED
        if mark != 0:
            _mark(marks, node, leaves, mark)
            found[count] = node
            count += 1
        node = 2 * node if inside else _after(node)
    return count


@reduction_inlined
def _mark(marks, node, leaves, mark):
    """Mark all leaves of a node."""
    many = 1
    while node < leaves:
        node, many = 2 * node, 2 * many
    for k in range(node - leaves, node - leaves + many):
        marks[k] = mark


@reduction_within
def _after(node):
    """The node that follows when the children of a node are skipped; 0 at the end."""
    while node & 1:
        node >>= 1
    return node + 1 if node > 0 else 0


@reduction_within
def _highest(boxes, node, normal):
    """The largest height along a normal in a box; minus infinity or NaN if the box is empty."""
    height = 0.0
    for k in range(3):
        i = np.uint64(k)
        height += normal[i] * (boxes[node, _3 + i] if normal[i] > 0.0 else boxes[node, i])
    return height
