"""The compiled loops by which facets, and groups of them, hide the sky within their outlines.

A row of cells is crossed by the outline of a group: where it enters the group a count rises by one,
where it leaves it falls.  The changes are added up for all groups, and each row is summed once: a
cell whose count is not zero is hidden.  The eight points of a facet are the lanes of a SIMD vector:
eight counts, the bytes of a word.

Rows begin, beyond the edge of a face, in the direction of an axis of the cube: there the count is
zero, but for facets that this axis meets.
"""

from __future__ import annotations

import math

import numpy as np

from attitude.compilation.decorators import (
    reduction_inlined,
    reduction_subroutine,
    reduction_within,
)
from attitude.compilation.instructions import fma
from attitude.compilation.simd import (
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
from attitude.light_curve.hierarchy import LEAF
from attitude.light_curve.sums import evened

FACES = 6
# Marks of the groups that are drawn, beside a bit for each face on which they are: all facets show
# the front, all show the back, or each was looked at.
FRONT, BACK, DIVIDED = 1 << 12, 1 << 13, 1 << 14
_LANES = 8
_EVERY_LANE = 255
_0, _1, _2, _3, _4, _5 = (np.uint64(k) for k in range(6))
# The lowest seven bits and the highest bit of each byte, and the factor that gathers the lowest
# bits of all bytes in the highest byte.
_LOW_BITS, _HIGH_BITS = np.uint64(0x7F7F7F7F7F7F7F7F), np.uint64(0x8080808080808080)
_GATHER, _TO_LOWEST, _TOP_BYTE = np.uint64(0x0102040810204080), np.uint64(7), np.uint64(56)
_ALL = np.uint8(255)
_LEAF, _WIDTH = np.uint64(LEAF), np.uint64(_LANES)
# Tangents, over the distance across, of what lies beside a point: beyond all faces.  What has the
# height of the point to the last digit counts as above it.
_BESIDE, _UPWARD = 1e250, 1e150


@reduction_within
def axes_of(face):
    """The axis of a face of the cube, those of its columns and of its rows."""
    axis = face // 2
    return np.uint64(axis), np.uint64((axis + 1) % 3), np.uint64((axis + 2) % 3)


@reduction_within
def side_shown(boxes, fronts, node, middle):
    """1 if all facets of a group show their fronts to all points about a facet, -1 their backs.

    0 where some may do one, some the other.  `middle` is a row of `painting.surroundings`.
    """
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

    The bit of a face is followed, six bits higher, by one that is set if the box may lie in the
    direction in which its rows begin.
    """
    found = 0
    for face in range(FACES):
        if not among >> face & 1:
            continue
        w, u, v = axes_of(face)
        sign = 1.0 - 2.0 * (face % 2)
        a, b = sign * (boxes[node, w] - middle[w]), sign * (boxes[node, _3 + w] - middle[w])
        near, far = (a, b) if a < b else (b, a)
        near, far = near - middle[_3 + w], far + middle[_3 + w]
        beside, above = _beside(boxes, node, middle, u), _beside(boxes, node, middle, v)
        if far > (beside if beside > above else above):
            found |= 1 << face
            if near <= 0.0 and above <= 0.0 and boxes[node, u] < middle[u] + middle[_3 + u]:
                found |= 1 << (face + FACES)
    return found


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
    found, groups, edges, sides, first_edges, corners, flat, first, up, shifts, resolution,
    frames, marks, shown, counts, drawn,
):  # fmt: skip
    """Add the changes along the outlines of the nodes found[:groups] to `counts`.

    The points are flat[first : first + 24], as in `painting`.  An edge between two groups that show
    the same side changes nothing, and one between others is drawn once.  `drawn` keeps the first
    row of each face with changes and the one after the last.
    """
    leaves = len(marks) - 1
    half = 0.5 * resolution
    beside, above = 0.5 - eight(shifts, 0), 0.5 - eight(shifts, _LANES)
    for q in range(groups):
        node = found[q]
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
            own, other = marks[left // _LEAF], marks[right // _LEAF]
            if other != 0 and right < left and left // _LEAF != right // _LEAF:
                continue
            if own == other and own & DIVIDED == 0:
                continue
            of_own = _side(own, eight(shown, left * _WIDTH))
            of_other = _side(other, eight(shown, right * _WIDTH))
            for face in range(FACES):
                sign = 1.0 - 2.0 * (face % 2)
                here, there = sign * (own >> face & 1), sign * (other >> face & 1)
                change = of_own * here - of_other * there
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
    found = looked_at
    if mark & DIVIDED == 0:
        found = every(1.0 if mark & FRONT != 0 else (-1.0 if mark != 0 else 0.0), looked_at)
    return found


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
    """Which side each facet of a leaf shows to each point: 1 the front, -1 the back, to `shown`.

    0 where it does not hide the sky.  Returns whether any does.
    """
    px, py, pz = eight(flat, first), eight(flat, first + 8), eight(flat, first + 16)
    nothing, one = every(0.0, px), every(1.0, px)
    back = every(-1.0 if both else 0.0, px)
    found = 0
    for k in range(leaf * LEAF, (leaf + 1) * LEAF):
        side = nothing
        if k < len(corners) and _rises(corners, np.uint64(k), normal, lowest):
            g = np.uint64(k)
            front = facing[g, _0] * px + facing[g, _1] * py + facing[g, _2] * pz - facing[g, _3]
            side = chosen(front, one, chosen(front * -1.0, back, nothing))
            found |= positive_bits(side * side)
        put_eight(shown, _LANES * k, side)
    return found != 0


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
    """The first of three numbers that is not zero.

    An edge may pass through the direction in which rows begin.  They begin beside it: below in the
    first place, and ahead in the second.
    """
    return chosen(a * a, a, chosen(b * b, b, c))


@reduction_within
def frame(normal, resolution, frames):
    """The rows and columns of each face with cells above the horizon to `frames`; the faces' bits.

    Four numbers for each face: the first row, the one after the last, and so for columns.
    """
    found = 0
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
            found |= 1 << face
    return found


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
    """Clear the bits of the cells above the horizon whose counts are not zero, and the counts.

    `sky` has the bytes of all `members` of each cell, cell by cell.
    """
    for face in range(FACES):
        w, u, v = axes_of(face)
        sign = 1.0 - 2.0 * (face % 2)
        for row in range(drawn[2 * face], drawn[2 * face + 1]):
            level = eight(up, row * _LANES) * normal[v] + sign * normal[w]
            here = np.uint64((face * resolution + row) * resolution)
            there = here + np.uint64(face * resolution + row)
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
                    sky[(here + column) * members + member] &= _ALL - np.uint8(bits)
            counts[there + last] = np.uint64(0)
        drawn[2 * face], drawn[2 * face + 1] = resolution, 0
