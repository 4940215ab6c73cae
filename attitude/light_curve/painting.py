"""The compiled loops of `visibility`: triangles are painted onto the faces of a cube.

The eight points of a facet are the lanes of a SIMD vector: a triangle is projected from all of them
at once, and a cell is compared with its edges for all of them at once.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from attitude.compilation.decorators import (
    reduction,
    reduction_inlined,
    reduction_subroutine,
    reduction_within,
)
from attitude.compilation.instructions import larger
from attitude.compilation.simd import (
    at_least,
    at_most,
    chosen,
    eight,
    lanes,
    largest_lane,
    positive_bits,
)
from attitude.light_curve.hierarchy import LEAF
from attitude.light_curve.sums import evened

if TYPE_CHECKING:
    from attitude.annotations import FloatArray

# Heights above the plane of a facet up to this share of the size of the body are rounding: those
# of neighbours in the same plane.
_RISE = 1e-9
_FACES = 6
_LANES = 8
# Unsigned: for signed indices numba adds a test for negative values to every access.
_0, _1, _2, _3, _4, _5 = (np.uint64(k) for k in range(6))
# Cells of a row from which on it pays to look for the part that the triangle covers.
_WIDE = 12
_ONE, _OPPOSITE = (1.0,) * _LANES, (-1.0,) * _LANES
# Beyond the edges of a face, as tangents.
_RIGHT, _LEFT = (2.0,) * _LANES, (-2.0,) * _LANES


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


@reduction
def paint(
    boxes, corners, balls, facing, normals, points, middles, size, members, across, up, resolution,
    both, masks, place,
):  # fmt: skip
    """Fill the columns of `masks` from `place` on, for the facets `members` (-1: empty place).

    `boxes` are those of a `Hierarchy`, in whose order are corners (F, 3, 3), `balls` (F, 4), their
    `enclosed`, and normals with their heights above the origin, `facing` (F, 4); normals (F, 3) and
    points (F, 3, 8) with their `surroundings` are in that of the mesh, all in m; `size` is that of
    the body.  `across` and `up` are `tangents`; masks are
    (6 resolution^2, places) uint8.  With `both`, either side of a facet hides the sky.
    """
    sky = np.empty((members.size, masks.shape[0]), np.uint8)
    flat = points.reshape(-1)
    count = np.uint64(members.size)
    for m in range(count):
        for i in range(np.uint64(masks.shape[0])):
            sky[m, i] = 255
        k = members[m]
        if k >= 0:
            _look_around(
                boxes, corners, balls, facing, normals[k], flat, 24 * k, middles[k], size, across,
                up, resolution, both, sky[m],
            )  # fmt: skip
    first = np.uint64(place)
    for i in range(np.uint64(masks.shape[0])):
        for m in range(count):
            masks[i, first + m] = sky[m, i]


@reduction_inlined
def _look_around(
    boxes, corners, balls, facing, normal, flat, first, middle, size, across, up, resolution, both,
    sky,
):  # fmt: skip
    """Clear the bits of the sky of one facet.

    Its points are flat[first : first + 24], x of each, then y, then z; along axis i they are within
    middle[3 + i] of middle[i].
    """
    plane = normal[0] * flat[first] + normal[1] * flat[first + 8] + normal[2] * flat[first + 16]
    lowest = plane + _RISE * size
    leaves = boxes.shape[0] // 2
    node = 1
    while node > 0:
        inner = False
        if _highest(boxes, np.uint64(node), normal) > plane + 0.5 * _RISE * size:
            inner = node < leaves
            if not inner:
                start = (node - leaves) * LEAF
                for g in range(np.uint64(start), np.uint64(_smaller(start + LEAF, len(corners)))):
                    if not _may_hide(corners, facing, g, normal, lowest, middle, both):
                        continue
                    for face in range(_FACES):
                        if _may_meet(balls, g, middle, face):
                            begin, end, low, high = _window(corners, g, middle, face, resolution)
                            if begin < end and low < high:
                                _cover(
                                    corners, g, normal, flat, first, face, begin, end, low, high,
                                    across, up, resolution, both, sky,
                                )  # fmt: skip
        node = 2 * node if inner else _after(node)


@reduction_inlined
def _smaller(a, b):
    return a if a < b else b


@reduction_inlined
def _after(node):
    """The node that follows when the children of a node are skipped; 0 at the end."""
    while node & 1:
        node >>= 1
    return node + 1 if node > 0 else 0


@reduction_within
def _highest(boxes, node, normal):
    """The largest height along a normal in a box; minus infinity or NaN if the box is empty."""
    height = 0.0
    for i in range(_3):
        height += normal[i] * (boxes[node, _3 + i] if normal[i] > 0.0 else boxes[node, i])
    return height


@reduction_within
def _may_hide(corners, facing, g, normal, lowest, middle, both):
    """Whether a triangle rises above a height and its front may face one of the points."""
    rise, front = lowest, middle[_3] + middle[_4] + middle[_5] - facing[g, _3]
    for i in range(_3):
        front += facing[g, i] * middle[i]
    if both or front > 0.0:
        for k in range(_3):
            height = 0.0
            for i in range(_3):
                height += normal[i] * corners[g, k, i]
            rise = larger(rise, height)
    return rise > lowest


@reduction_within
def _may_meet(balls, g, middle, face):
    """Whether a triangle may be in front of a face of the cube about one of the points.

    Along each axis its corners are within balls[g, 3] of balls[g, :3].
    """
    w, u, v = _axes(face)
    spare = larger(larger(middle[_3], middle[_4]), middle[_5]) + balls[g, _3]
    ahead = (1.0 - 2.0 * (face % 2)) * (balls[g, w] - middle[w]) + 2.0 * spare
    return ahead > larger(abs(balls[g, u] - middle[u]), abs(balls[g, v] - middle[v]))


@reduction_inlined
def _axes(face):
    """The axis of a face of the cube, those of its columns and of its rows."""
    axis = face // 2
    return np.uint64(axis), np.uint64((axis + 1) % 3), np.uint64((axis + 2) % 3)


@reduction_within
def _window(corners, g, middle, face, resolution):
    """Columns and rows of a face that a triangle may reach, seen from any point: from, to."""
    w, u, v = _axes(face)
    sign = 1.0 - 2.0 * (face % 2)
    half = 0.5 * resolution
    left, right, low, high = 9.0, -9.0, 9.0, -9.0
    least = 1.0
    for k in range(_3):
        ahead = sign * (corners[g, k, w] - middle[w])
        x, y = corners[g, k, u] - middle[u], corners[g, k, v] - middle[v]
        near, far = 1.0 / (ahead - middle[_3 + w]), 1.0 / (ahead + middle[_3 + w])
        right = larger(right, _most(x + middle[_3 + u], near, far))
        high = larger(high, _most(y + middle[_3 + v], near, far))
        left = -larger(-left, _most(middle[_3 + u] - x, near, far))
        low = -larger(-low, _most(middle[_3 + v] - y, near, far))
        least = least if near > 0.0 else -1.0
    if least < 0.0:
        left, right, low, high = -2.0, 2.0, -2.0, 2.0
    return (
        _first(left, half, 0), _last(right, half, resolution),
        _first(low, half, 0), _last(high, half, resolution),
    )  # fmt: skip


@reduction_inlined
def _most(u, near, far):
    """The largest tangent of a component between the reciprocals of two distances."""
    return u * (near if u > 0.0 else far)


@reduction_subroutine
def _cover(
    corners, g, normal, flat, first, face, begin, end, low, high, across, up, resolution, both, sky
):
    """Clear the bits of the cells of a window in which a triangle hides the sky from the points."""
    w, u, v = _axes(face)
    sign = 1.0 - 2.0 * (face % 2)
    pw, pu, pv = eight(flat, first + 8 * w), eight(flat, first + 8 * u), eight(flat, first + 8 * v)
    aw, au, av = corners[g, _0, w] - pw, corners[g, _0, u] - pu, corners[g, _0, v] - pv
    bw, bu, bv = corners[g, _1, w] - pw, corners[g, _1, u] - pu, corners[g, _1, v] - pv
    cw, cu, cv = corners[g, _2, w] - pw, corners[g, _2, u] - pu, corners[g, _2, v] - pv
    # Normals of the planes through the point and an edge.  For a triangle seen from its front all
    # three point outward, and the determinant is negative; then they are turned.
    e0w, e0u, e0v = bu * cv - bv * cu, bv * cw - bw * cv, bw * cu - bu * cw
    e1w, e1u, e1v = cu * av - cv * au, cv * aw - cw * av, cw * au - cu * aw
    e2w, e2u, e2v = au * bv - av * bu, av * bw - aw * bv, aw * bu - au * bw
    front = (aw * e0w + au * e0u + av * e0v) * -1.0
    seen = 255 if both else positive_bits(front)
    turn = chosen(front, lanes(_OPPOSITE), lanes(_ONE))
    e0w, e0u, e0v = e0w * (turn * sign), e0u * turn, e0v * turn
    e1w, e1u, e1v = e1w * (turn * sign), e1u * turn, e1v * turn
    e2w, e2u, e2v = e2w * (turn * sign), e2u * turn, e2v * turn
    rise = lanes(_ONE) * normal[u]
    wide = end - begin >= _WIDE
    i0, i1, i2, i3 = rise, rise, rise, rise
    if wide:
        i0, i1, i2, i3 = -1.0 / e0u, -1.0 / e1u, -1.0 / e2u, -1.0 / rise
    for row in range(low, high if seen != 0 else low):
        y = eight(up, row * _LANES)
        l0, l1, l2 = e0w + y * e0v, e1w + y * e1v, e2w + y * e2v
        l3 = y * normal[v] + sign * normal[w]
        here, there = begin, end
        if wide:
            x0, x1, x2, x3 = l0 * i0, l1 * i1, l2 * i2, l3 * i3
            left = at_least(_bound(e0u, x0, _LEFT), _bound(e1u, x1, _LEFT))
            left = at_least(left, at_least(_bound(e2u, x2, _LEFT), _bound(rise, x3, _LEFT)))
            right = at_most(_bound(e0u * -1.0, x0, _RIGHT), _bound(e1u * -1.0, x1, _RIGHT))
            right = at_most(right, _bound(e2u * -1.0, x2, _RIGHT))
            right = at_most(right, _bound(rise * -1.0, x3, _RIGHT))
            here = _first(-largest_lane(left * -1.0), 0.5 * resolution, begin)
            there = _last(largest_lane(right), 0.5 * resolution, end)
        start = (face * resolution + row) * resolution
        for column in range(here, there):
            x = eight(across, column * _LANES)
            least = at_most(l0 + x * e0u, l1 + x * e1u)
            least = at_most(least, at_most(l2 + x * e2u, l3 + x * rise))
            sky[np.uint64(start + column)] &= np.uint8(255 - (positive_bits(least) & seen))


@reduction_within
def _bound(slope, x, none):
    """The bound x of an interval where the slope is above zero, else none."""
    return chosen(slope, x, lanes(none))


@reduction_within
def _first(u, half, least):
    """The first cell, or `least`, in which a point may look at a tangent of u or more.

    Points look at directions up to half a cell from the middle of a cell.
    """
    found = math.ceil((1.0 + evened(larger(u, -1.1))) * half - 1.001)
    return found if found > least else least


@reduction_within
def _last(u, half, most):
    """The cell after the last one, or `most`, in which a point may look at a tangent up to u."""
    found = math.floor((1.0 - evened(larger(-u, -1.1))) * half + 0.001) + 1
    return found if found < most else most
