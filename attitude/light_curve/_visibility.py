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

import math
import time
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from attitude._compilation.decorators import (
    reduction,
    reduction_inlined,
    reduction_subroutine,
    reduction_within,
)
from attitude._compilation.instructions import fma
from attitude._compilation.simd import (
    add_in_columns,
    at_least,
    at_most,
    chosen,
    eight,
    every,
    largest_lane,
    positive_bits,
    put_eight,
    root,
    truncated,
)
from attitude._support import validation
from attitude._support.arrays import frozen
from attitude._support.blocks import ProgressBar, in_blocks
from attitude._textfiles import kept_arrays
from attitude.errors import AttitudeError
from attitude.light_curve._sums import SIZE, arranged, clusters_of, evened
from attitude.shape._mesh import Mesh, edges_of, parts

if TYPE_CHECKING:
    from collections.abc import Callable
    from typing import Any

    from numpy.typing import NDArray

    from attitude._support.annotations import FloatArray, IntArray
    from attitude.light_curve._sums import Clusters, Packs


# ---- Boxes around facets that lie together: groups that cannot hide the sky are skipped at once
# The tree is complete: node k has the children 2 k and 2 k + 1, the root is 1, and the leaves hold
# LEAF facets each.  Each group is cut across its longest extent, in space or in the directions of
# its normals: groups that face one way hide the sky by their outlines.

# Facets of a leaf.
LEAF = 4
# Over the size of the body: how far apart normals that differ by one count.  Tables of a rough, a
# waisted and a winged body take the least time from 0.15 to 0.3.
_APART = 0.2


@dataclass(frozen=True, eq=False)
class Hierarchy:
    """Facets in groups of nearby ones: their order (F,), leaf by leaf.

    boxes (2 L, 6): the lowest and the highest coordinates of each node, m; node 0 is unused.
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
    low, high = (corners_of.reshape(leaves, LEAF, 3) for corners_of in (lowest, highest))
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


# ---- Outlines of groups of facets: a group that shows its front hides the sky within its outline
# An edge between two facets of a group is passed once each way and cancels, so that the outline of
# some hundred facets has a few dozen edges.


@dataclass(frozen=True, eq=False)
class Outlines:
    """The outlines of the nodes of a `Hierarchy`, and bounds of the directions that they face.

    edges (N, 6), m, and sides (N, 2), the places of the facets left and right (LEAF L: none): of
    node k from first[k] on, of the leaf of node L + k, each edge once, from first[2 L + k] on.
    fronts (2 L, 8): bounds of the normals, and of the heights of planes above the middle of the
    box, m.
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
    first_leaf, other = sides[:, 0] // LEAF + leaves, sides[:, 1] // LEAF + leaves
    other[mates < 0] = 0
    once = np.flatnonzero((first_leaf != other) | (np.arange(len(first_leaf)) < mates))
    edges, nodes = [once], [first_leaf[once] + leaves]
    while first_leaf[0] > 0:
        outer = np.flatnonzero(first_leaf != other)
        edges.append(outer)
        nodes.append(first_leaf[outer])
        first_leaf, other = first_leaf >> 1, other >> 1
    edge, node = np.concatenate(edges), np.concatenate(nodes)
    edge = edge[np.argsort(node, kind="stable")]
    facet, corner = edge // 3, edge % 3
    lines = np.concatenate([corners[facet, corner], corners[facet, (corner + 1) % 3]], axis=1)
    first = np.concatenate([[0], np.cumsum(np.bincount(node, minlength=3 * leaves))])
    return Outlines(lines, sides[edge], first, _fronts(tree, corners, normals))


def _fronts(tree: Hierarchy, corners: FloatArray, normals: FloatArray) -> FloatArray:
    """The bounds `Outlines.fronts`, level by level."""
    leaves = len(tree.boxes) // 2
    boxes = np.zeros((2 * leaves, 8))
    normals_there, place = normals[tree.order], corners[tree.order, 0]
    level, group = leaves, LEAF
    while level >= 1:
        first = np.arange(0, len(normals_there), group)
        rows = slice(level, level + len(first))
        middle = 0.5 * (tree.boxes[rows, :3] + tree.boxes[rows, 3:])
        from_middle = place - np.repeat(middle, group, axis=0)[: len(normals_there)]
        heights = np.einsum("fi,fi->f", normals_there, from_middle)
        boxes[rows, :3] = np.minimum.reduceat(normals_there, first)
        boxes[rows, 3:6] = np.maximum.reduceat(normals_there, first)
        boxes[rows, 6] = np.minimum.reduceat(heights, first)
        boxes[rows, 7] = np.maximum.reduceat(heights, first)
        level, group = level // 2, 2 * group
    return boxes


# ---- The compiled loops by which facets, and groups of them, hide the sky within their outlines
# A row of cells is crossed by the outline of a group: where it enters the group a count rises by
# one, where it leaves it falls.  The changes are added up for all groups, and each row is summed
# once: a cell whose count is not zero is hidden.  The eight points of a facet are the lanes of a
# SIMD vector: eight counts, the bytes of a word.
#
# Rows begin, beyond the edge of a face, in the direction of an axis of the cube: there the count is
# zero, but for facets that this axis meets.

FACES = 6
# Marks of the groups that are drawn, beside a bit for each face on which they are: all facets show
# the front.
FRONT = 1 << 12
# All show the back.
BACK = 1 << 13
# Each was looked at.
DIVIDED = 1 << 14
_LANES = 8
_EVERY_LANE = 255
_0, _1, _2, _3, _4, _5 = (np.uint64(k) for k in range(6))
# The lowest seven bits of each byte.
_LOW_BITS = np.uint64(0x7F7F7F7F7F7F7F7F)
# The highest bit of each byte.
_HIGH_BITS = np.uint64(0x8080808080808080)
# The factor that gathers the lowest bits of all bytes in the highest byte.
_GATHER = np.uint64(0x0102040810204080)
# From the highest bit of a byte to the lowest.
_TO_LOWEST = np.uint64(7)
# From the highest byte of a word to the lowest.
_TOP_BYTE = np.uint64(56)
_ALL = np.uint8(255)
_LEAF = np.uint64(LEAF)
_WIDTH = np.uint64(_LANES)
# Tangent, over the distance across, of what lies beside a point: beyond all faces.
_BESIDE = 1e250
# What has the height of the point to the last digit counts as above it.
_UPWARD = 1e150


@reduction_within
def axes_of(face):
    """The axis of a face of the cube, those of its columns and of its rows."""
    axis = face // 2
    return np.uint64(axis), np.uint64((axis + 1) % 3), np.uint64((axis + 2) % 3)


@reduction_within
def side_shown(boxes, fronts, node, middle):
    """1 if all facets of a group show fronts to all points about a facet, -1: backs, else 0."""
    spread = middle[_3] + middle[_4] + middle[_5]
    least, most = -fronts[node, 7] - spread, spread - fronts[node, 6]
    for k in range(3):
        i = np.uint64(k)
        to = middle[i] - 0.5 * (boxes[node, i] + boxes[node, _3 + i])
        one, other = to * fronts[node, i], to * fronts[node, _3 + i]
        least += one if one < other else other
        most += other if one < other else one
    return 1 if least > 0.0 else (-1 if most < 0.0 else 0)


@reduction_within
def faces_met(boxes, node, middle, among):
    """Which of the faces `among` a box may meet, seen from any point about a facet, as bits.

    Six bits higher: whether the box may lie in the direction in which the rows begin.
    """
    count = 0
    for face in range(FACES):
        if not among >> face & 1:
            continue
        w, u, v = axes_of(face)
        sign = 1.0 - 2.0 * (face % 2)
        a, b = sign * (boxes[node, w] - middle[w]), sign * (boxes[node, _3 + w] - middle[w])
        first_node, far = (a, b) if a < b else (b, a)
        first_node, far = first_node - middle[_3 + w], far + middle[_3 + w]
        beside, above = _beside(boxes, node, middle, u), _beside(boxes, node, middle, v)
        if far > (beside if beside > above else above):
            count |= 1 << face
            if first_node <= 0.0 and above <= 0.0 and boxes[node, u] < middle[u] + middle[_3 + u]:
                count |= 1 << (face + FACES)
    return count


@reduction_inlined
def _beside(boxes, node, middle, i):
    """The least size of a component of the directions to a box, times the distance."""
    a, b = boxes[node, i] - middle[i], middle[i] - boxes[node, _3 + i]
    return (a if a > b else b) - middle[_3 + i]


@reduction_within
def _place(tangent, half, offset, least, most):
    """The first row, or column, in the bounds in which each point looks beyond a tangent."""
    size = root(1.0 + 3.0 * at_least(tangent, tangent * -1.0)) - 1.0
    even = chosen(tangent, size, size * -1.0)
    return truncated(at_most(at_least((1.0 + even) * half + offset, least), most))


@reduction_inlined
def draw_groups(
    nodes, groups, edges, sides, first_edges, corners, flat, first, up, shifts, resolution,
    frames, marks, shown, counts, drawn,
):  # fmt: skip
    """Add the changes along the outlines of nodes[:groups] to `counts`; see `paint`.

    An edge between groups that show one side changes nothing. `drawn`: first and last rows of
    faces.
    """
    leaves = len(marks) - 1
    half = 0.5 * resolution
    beside, above = 0.5 - eight(shifts, 0), 0.5 - eight(shifts, _LANES)
    for q in range(groups):
        node = nodes[q]
        if node >= leaves and marks[node - leaves] & DIVIDED != 0:
            mark = marks[node - leaves] & ~DIVIDED
            if mark >> FACES != 0:
                begin_in(
                    corners, node - leaves, mark, flat, first, resolution, frames, shown, counts,
                    drawn,
                )  # fmt: skip
            node += leaves
        # No function here takes an array: counting references would cost more than the edges.
        for e in range(np.uint64(first_edges[node]), np.uint64(first_edges[node + 1])):
            left, right = np.uint64(sides[e, _0]), np.uint64(sides[e, _1])
            left_mark, right_mark = marks[left // _LEAF], marks[right // _LEAF]
            if right_mark != 0 and right < left and left // _LEAF != right // _LEAF:
                continue
            if left_mark == right_mark and left_mark & DIVIDED == 0:
                continue
            of_left = _side(left_mark, eight(shown, left * _WIDTH))
            of_right = _side(right_mark, eight(shown, right * _WIDTH))
            for face in range(FACES):
                sign = 1.0 - 2.0 * (face % 2)
                first_side, there = sign * (left_mark >> face & 1), sign * (right_mark >> face & 1)
                change = of_left * first_side - of_right * there
                if positive_bits(change * change) == 0:
                    continue
                w, u, v = axes_of(face)
                pw, pu = eight(flat, first + 8 * w), eight(flat, first + 8 * u)
                pv = eight(flat, first + 8 * v)
                x0, y0, slope, ra, rb = _line(
                    (edges[e, w] - pw) * sign, edges[e, u] - pu, edges[e, v] - pv,
                    (edges[e, _3 + w] - pw) * sign, edges[e, _3 + u] - pu, edges[e, _3 + v] - pv,
                    half, above, 1.0 * frames[4 * face], 1.0 * frames[4 * face + 1],
                )  # fmt: skip
                way = rb - ra
                if positive_bits(way * way) == 0:
                    continue
                low = int(-largest_lane(at_least(ra * -1.0, rb * -1.0)))
                high = int(largest_lane(at_least(ra, rb)))
                drawn[2 * face] = min(low, drawn[2 * face])
                drawn[2 * face + 1] = max(high, drawn[2 * face + 1])
                most_left, most_right = 1.0 * frames[4 * face + 2], 1.0 * frames[4 * face + 3]
                for row in range(low, high):
                    x = x0 + (eight(up, row * _LANES) - y0) * slope
                    column = _place(x, half, beside, most_left, most_right)
                    place = (face * resolution + row) * (resolution + 1) * _LANES
                    add_in_columns(counts, place, column, _changed(ra, rb, row + 0.5, change))


@reduction_within
def _side(mark, looked_at):
    """Which side a facet shows to each point, as in `shown`, where each was looked at."""
    side = looked_at
    if mark & DIVIDED == 0:
        side = every(1.0 if mark & FRONT != 0 else (-1.0 if mark != 0 else 0.0), looked_at)
    return side


@reduction_within
def _line(aw, au, av, bw, bu, bv, half, above, least, most):
    """A place on an edge and its slope, as tangents, and the first rows beyond both ends."""
    xa, ya, ra = _seen(aw, au, av, half, above, least, most)
    xb, yb, rb = _seen(bw, bu, bv, half, above, least, most)
    if positive_bits(at_most(aw, bw)) != _EVERY_LANE:
        # Of an edge that passes a point only the part ahead of the point is seen; it ends beyond
        # all faces.  An edge behind the point has both ends in one row: no changes.
        scale = _BESIDE / (aw - bw)
        x, y = _moment(aw, au, bw, bu) * scale, _moment(aw, av, bw, bv) * scale + _UPWARD
        beyond = _place(y, half, above, least, most)
        xa, ya, ra = chosen(aw, xa, x), chosen(aw, ya, y), chosen(aw, ra, beyond)
        xb, yb, rb = chosen(bw, xb, x), chosen(bw, yb, y), chosen(bw, rb, beyond)
        rb = chosen(at_least(aw, bw), rb, ra)
    # Tangents of the end that is farther ahead have the smaller errors.
    farther = aw - bw
    slope = (xb - xa) / (yb - ya)
    return chosen(farther, xa, xb), chosen(farther, ya, yb), slope, ra, rb


@reduction_within
def _changed(ra, rb, row, change):
    """How a row changes that an edge crosses upward, between rows `ra` and `rb`, or downward."""
    nothing = every(0.0, ra)
    return chosen(ra - row, nothing, change) - chosen(rb - row, nothing, change)


@reduction_within
def _seen(ahead, u, v, half, above, least, most):
    """The tangents of a corner, seen from the points, and the first row beyond it."""
    inverse = 1.0 / ahead
    y = v * inverse
    return u * inverse, y, _place(y, half, above, least, most)


@reduction_within
def show(corners, facing, leaf, normal, lowest, flat, first, both, shown):
    """Which side each facet of a leaf shows to each point: 1, -1, 0; whether any does."""
    px, py, pz = eight(flat, first), eight(flat, first + 8), eight(flat, first + 16)
    nothing, one = every(0.0, px), every(1.0, px)
    back = every(-1.0 if both else 0.0, px)
    hides = 0
    for k in range(leaf * LEAF, (leaf + 1) * LEAF):
        side = nothing
        if k < len(corners) and _rises(corners, np.uint64(k), normal, lowest):
            g = np.uint64(k)
            front = facing[g, _0] * px + facing[g, _1] * py + facing[g, _2] * pz - facing[g, _3]
            side = chosen(front, one, chosen(front * -1.0, back, nothing))
            hides |= positive_bits(side * side)
        put_eight(shown, _LANES * k, side)
    return hides != 0


@reduction_within
def _rises(corners, g, normal, lowest):
    """Whether a triangle rises above a height."""
    rise = lowest
    for k in range(3):
        height = 0.0
        for i in range(3):
            height += normal[i] * corners[g, k, i]
        rise = height if height > rise else rise
    return rise > lowest


@reduction_subroutine
def begin_in(corners, leaf, faces, flat, first, resolution, frames, shown, counts, drawn):
    """Add to `counts` where the rows of `faces` begin in the direction of a facet of a leaf."""
    for face in range(FACES):
        if faces >> (face + FACES) & 1:
            for k in range(leaf * LEAF, (leaf + 1) * LEAF):
                if k < len(corners):
                    side = eight(shown, _LANES * k)
                    _begin_in(
                        corners, np.uint64(k), side, flat, first, face, resolution, frames, counts,
                        drawn,
                    )  # fmt: skip


@reduction_inlined
def _begin_in(corners, g, side, flat, first, face, resolution, frames, counts, drawn):
    """Add to `counts` where the direction in which the rows of a face begin meets a triangle."""
    w, u, v = axes_of(face)
    pw, pu, pv = eight(flat, first + 8 * w), eight(flat, first + 8 * u), eight(flat, first + 8 * v)
    aw, au, av = corners[g, _0, w] - pw, corners[g, _0, u] - pu, corners[g, _0, v] - pv
    bw, bu, bv = corners[g, _1, w] - pw, corners[g, _1, u] - pu, corners[g, _1, v] - pv
    cw, cu, cv = corners[g, _2, w] - pw, corners[g, _2, u] - pu, corners[g, _2, v] - pv
    # Components of the normals of the planes through the point and an edge: all have the sign of
    # the side that the triangle shows, or it is not met.
    turn = 2.0 * (face % 2) - 1.0
    e0 = _clear(_moment(bv, bw, cv, cw), _moment(bw, bu, cw, cu), _moment(bu, bv, cu, cv) * turn)
    e1 = _clear(_moment(cv, cw, av, aw), _moment(cw, cu, aw, au), _moment(cu, cv, au, av) * turn)
    e2 = _clear(_moment(av, aw, bv, bw), _moment(aw, au, bw, bu), _moment(au, av, bu, bv) * turn)
    e0, e1, e2 = e0 * side, e1 * side, e2 * side
    inside = at_most(e0, at_most(e1, e2))
    if positive_bits(inside) != 0:
        nothing = every(0.0, pw)
        change = chosen(inside, every(1.0, pw), nothing)
        left = every(1.0 * frames[4 * face + 2], pw)
        for row in range(frames[4 * face], frames[4 * face + 1]):
            place = (face * resolution + row) * (resolution + 1) * _LANES
            add_in_columns(counts, place, left, change)
        drawn[2 * face], drawn[2 * face + 1] = frames[4 * face], frames[4 * face + 1]


@reduction_within
def _moment(ax, ay, bx, by):
    """Twice ax by - bx ay, with exactly the opposite sign if the ends or the axes are exchanged.

    An edge that passes a point on the side where rows begin must pass it for both its facets.
    """
    one, other = ax * by, bx * ay
    return fma(ax, by, other * -1.0) - fma(bx, ay, one * -1.0)


@reduction_within
def _clear(a, b, c):
    """The first of three numbers that is not zero: rows begin beside an edge in their direction."""
    return chosen(a * a, a, chosen(b * b, b, c))


@reduction_within
def frame(normal, resolution, frames):
    """Rows and columns of each face with cells above the horizon, four numbers; the faces' bits."""
    frame_of = 0
    # Points look up to half a cell beyond the edge of a face.
    edge = 1.0 + 2.0 / resolution
    for face in range(FACES):
        w, u, v = axes_of(face)
        ahead = normal[w] * (1.0 - 2.0 * (face % 2))
        first, last = _above(ahead + edge * abs(normal[u]), normal[v], resolution)
        left, right = _above(ahead + edge * abs(normal[v]), normal[u], resolution)
        frames[4 * face], frames[4 * face + 1] = first, last
        frames[4 * face + 2], frames[4 * face + 3] = left, right
        if first < last and left < right:
            frame_of |= 1 << face
    return frame_of


@reduction_within
def _above(height, slope, resolution):
    """The first row and the one after the last with tangents y for which height + y slope > 0."""
    first, last = 0, resolution
    if abs(slope) > 1e-9:
        edge = -height / slope
        bound = edge if -2.0 < edge < 2.0 else (2.0 if edge > 0.0 else -2.0)
        row = math.floor((1.0 + evened(bound)) * 0.5 * resolution)
        if slope > 0.0:
            first = min(max(row - 1, 0), resolution)
        else:
            last = min(max(row + 2, 0), resolution)
    elif height <= -1e-9:
        last = 0
    return first, last


@reduction_subroutine
def fill(normal, across, up, resolution, frames, counts, drawn, sky, member, members):
    """Clear bits of `sky`, cell by cell, above the horizon where counts are not 0, and these."""
    for face in range(FACES):
        w, u, v = axes_of(face)
        sign = 1.0 - 2.0 * (face % 2)
        for row in range(drawn[2 * face], drawn[2 * face + 1]):
            level = eight(up, row * _LANES) * normal[v] + sign * normal[w]
            bit = np.uint64((face * resolution + row) * resolution)
            there = bit + np.uint64(face * resolution + row)
            total = np.uint64(0)
            last = np.uint64(frames[4 * face + 3])
            for place in range(np.uint64(frames[4 * face + 2]), last):
                column = np.uint64(place)  # in Python too, where ranges have ints
                change = counts[there + column]
                counts[there + column] = np.uint64(0)
                # eight sums of bytes, without carries from one to the next
                low = (total & _LOW_BITS) + (change & _LOW_BITS)
                total = low ^ ((total ^ change) & _HIGH_BITS)
                if total != 0:
                    above = positive_bits(level + eight(across, column * _LANES) * normal[u])
                    hidden = (((total & _LOW_BITS) + _LOW_BITS) | total) & _HIGH_BITS
                    bits = (((hidden >> _TO_LOWEST) * _GATHER) >> _TOP_BYTE) & np.uint64(above)
                    sky[(bit + column) * members + member] &= _ALL - np.uint8(bits)
            counts[there + last] = np.uint64(0)
        drawn[2 * face], drawn[2 * face + 1] = resolution, 0


# ---- The compiled loop over the facets of a mesh and the groups that may hide its sky
# Groups that show their fronts are drawn by their outlines, others are divided, down to facets that
# are drawn by their edges.

# Heights above the plane of a facet up to this share of the size of the body are rounding: those
# of neighbours in the same plane.
_RISE = 1e-9
# What `side_shown` does not return: a group below the horizon.
_BELOW = -2
# Unsigned: for signed indices numba adds a test for negative values to every access.
_THREE = np.uint64(3)


def tangents(shift: FloatArray, resolution: int) -> tuple[FloatArray, FloatArray]:
    """Tangents along rows, columns of a face for cells and points, flat; shift (8, 2) in cells."""
    places = (np.arange(resolution)[:, None, None] + 0.5 + shift) / (0.5 * resolution) - 1.0
    # the inverse of `_sums.evened`
    places_of = np.sign(places) * ((1.0 + np.abs(places)) ** 2 - 1.0) / 3.0
    return np.ascontiguousarray(places_of[..., 0]).reshape(-1), places_of[..., 1].flatten()


def surroundings(points: FloatArray, size: float) -> FloatArray:
    """Centre and half the edges of a box about the points (F, 3, 8) of each facet: (F, 6)."""
    middle = np.mean(points, axis=2)
    reach = np.max(np.abs(points - middle[..., None]), axis=2)
    return np.concatenate([middle, 1.001 * reach + 1e-12 * size], axis=1)


def memory(members: int, resolution: int, leaves: int) -> tuple[NDArray[Any], ...]:
    """The arrays in which `paint` works; numba would compile a function for each."""
    # One count more a row, for changes beyond the last column.
    counts = np.zeros(FACES * resolution * (resolution + 1), np.uint64)
    drawn = np.zeros(2 * FACES, np.int64)
    drawn[::2] = resolution
    return (
        np.full(FACES * resolution**2 * members, 255, np.uint8),
        counts,
        counts.view(np.uint8),
        drawn,
        np.zeros(4 * FACES, np.int64),
        np.zeros(leaves + 1, np.int64),
        np.empty(leaves, np.int64),
        np.zeros(_LANES * LEAF * (leaves + 1)),
    )


@reduction
def paint(
    boxes, edges, sides, first_edges, fronts, corners, facing, normals, points, middles, size,
    members, across, up, shifts, resolution, both, sky, counts, changes, drawn, frames, marks,
    nodes, shown, masks, place,
):  # fmt: skip
    """Fill the columns of `masks` from `place` on, for the facets `members` (-1: empty place).

    Corners and `facing` (normals and heights above the origin) are in the order of `boxes`;
    normals, points (F * 24,) and `middles` (their `surroundings`) in that of the mesh, m; `across`,
    `up`: `tangents`; sky to shown: `memory`; with `both`, either side of a facet hides the sky.
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
                faces, marks, nodes, shown,
            )  # fmt: skip
            draw_groups(
                nodes, groups, edges, sides, first_edges, corners, points, 24 * k, up, shifts,
                resolution, frames, marks, shown, changes, drawn,
            )  # fmt: skip
            for q in range(groups):
                _mark(marks, nodes[q], leaves, 0)
            fill(normals[k], across, up, resolution, frames, counts, drawn, sky, m, count)
    first = np.uint64(place)
    for i in range(cells):
        begin = np.uint64(i) * count
        for m in range(count):
            masks[i, first + np.uint64(m)] = sky[begin + np.uint64(m)]


@reduction_inlined
def _look_around(
    boxes, fronts, corners, facing, normal, flat, first, middle, size, both, among, marks, nodes,
    shown,
):  # fmt: skip
    """Mark all groups that may hide the sky of one facet, and fill `nodes`; the number of these.

    The points are flat[first : first + 24]; along axis i within middle[3 + i] of middle[i].
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
            nodes[count] = node
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
        height += normal[i] * (boxes[node, _THREE + i] if normal[i] > 0.0 else boxes[node, i])
    return height


# ---- The table of a mesh, kept on disk by a hash of the mesh

# Seconds: a table computed in less is not worth its place on disk.
WORTH = 1.0
# Upper bound of the files together, bytes.
LARGEST = 1 << 31
# To be raised when the bits of a table change.
_METHOD = 2
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
        For each cell of the sky and each place of `Clusters`, a bit for each point of the facet:
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
            frozen(array)

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
            cache folder (`attitude._textfiles.kept_arrays`).

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
        resolution = validation.count(resolution, "resolution", 4, 512)
        key = f"{_METHOD} {resolution} {mesh.corners.shape} "
        file = kept_arrays.file_of("shadows", key, mesh.corners, clusters.order) if keep else None
        masks = kept_arrays.read(file).get("masks", np.empty(0))
        if masks.shape != (6 * resolution**2, places) or masks.dtype != np.uint8:
            begin = time.monotonic()
            if progress is None:
                progress = ProgressBar(f"shadows of {len(mesh)} facets")
            masks = _painted(mesh, clusters, resolution, threads, progress)
            if time.monotonic() - begin > WORTH:
                kept_arrays.write(file, {"masks": masks}, LARGEST)
        return cls(masks, resolution, clusters, mesh.corners)

    def arranged(self, packs: Packs) -> NDArray[np.uint64]:
        """The masks as `_sums.arranged` has them; those of the last packs are kept."""
        last = self._last[-1:]
        if not last or not np.array_equal(last[0][0], packs.order):
            arranged_masks = arranged(self.masks, packs, self.clusters.order)
            self._last[:] = last = [(packs.order, arranged_masks)]
        return last[0][1]

    def is_of(self, mesh: Mesh) -> bool:
        """Whether the table, which may have been unpickled, belongs to a mesh.

        The comparison needs the corners: two meshes may share all normals and areas, such as boxes
        with wings at different distances.
        """
        clusters = clusters_of(mesh)
        return self.clusters is clusters or (
            np.array_equal(self.corners, mesh.corners)
            and np.array_equal(self.clusters.order, clusters.order)
        )


def require_mesh(mesh: object) -> None:
    """AttitudeError for anything but a `Mesh`."""
    if not isinstance(mesh, Mesh):
        raise AttitudeError(
            f"mesh is {mesh!r}; give an attitude.shape Mesh, such as Ellipsoid.facets(count) or "
            "box(size)."
        )


def points_of(corners: FloatArray) -> FloatArray:
    """Points (F, POINTS, 3) that sample triangles of corners (F, 3, 3) evenly, of equal weights."""
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


def _painted(mesh, clusters, resolution, threads, progress):
    """The masks of a `Visibility`."""
    cells = 6 * resolution**2
    masks = np.empty((cells, clusters.count * SIZE), dtype=np.uint8)
    # With the mean of the centroids as origin, heights keep their digits wherever the mesh lies.
    corners = mesh.corners - np.mean(mesh.centroids, axis=0)
    points = np.ascontiguousarray(np.swapaxes(points_of(corners), 1, 2))
    shift = np.stack(plane_filling(POINTS), axis=1) - 0.5
    shifts = np.ascontiguousarray(shift.T).reshape(-1)
    across, up = tangents(shift, resolution)
    planes = np.einsum("fi,fi->f", mesh.normals, corners[:, 0])
    tree = hierarchy_of(corners, mesh.normals)
    outlines = outlines_of(tree, mesh.facets, corners, mesh.normals)
    ordered_corners = corners[tree.order]
    facing = np.column_stack([mesh.normals[tree.order], planes[tree.order]])
    normals = np.ascontiguousarray(mesh.normals)
    size = float(np.max(np.abs(corners)))
    middles, flat = surroundings(points, size), points.reshape(-1)
    both = not mesh.is_closed or bool(np.any(parts(mesh.facets, len(mesh.vertices))))

    def work(begin: int, end: int) -> None:
        members = clusters.order[begin * SIZE : end * SIZE]
        paint(
            tree.boxes,
            outlines.edges,
            outlines.sides,
            outlines.first,
            outlines.fronts,
            ordered_corners,
            facing,
            normals,
            flat,
            middles,
            size,
            members,
            across,
            up,
            shifts,
            resolution,
            both,
            *memory(len(members), resolution, len(tree.boxes) // 2),
            masks,
            begin * SIZE,
        )

    in_blocks(work, clusters.count, _AT_ONCE, threads, progress)
    return masks
