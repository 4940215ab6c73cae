"""The compiled loops of `visibility`: triangles are painted onto the faces of a cube, by rows."""

import numpy as np

from attitude.compilation.decorators import reduction, reduction_inlined, reduction_subroutine
from attitude.light_curve.sums import evened


@reduction
def paint(corners, normals, points, members, shift, resolution, both, masks, place):
    """Fill the columns of `masks` from `place` on, for the facets `members` (-1: empty place).

    corners (F, 3, 3), normals (F, 3) and points (F, POINTS, 3) are in m; shift (POINTS, 2) is in
    cells; masks (6 resolution^2, places) uint8.  With `both`, either side of a facet hides the sky.
    """
    sky = np.empty((members.size, masks.shape[0]), np.uint8)
    above = np.empty(corners.shape[0], np.int64)
    size = np.max(np.abs(corners))
    for m in range(members.size):
        sky[m, :] = 255
        if members[m] < 0:
            continue
        count = _risen(corners, normals[members[m]], points[members[m], 0], size, above)
        for bit in range(points.shape[1]):
            own = points[members[m], bit]
            clear = np.uint8(255 - (1 << bit))
            for k in range(count):
                _hide(
                    corners[above[k]], own, normals[members[m]], both,
                    shift[bit], resolution, clear, sky[m],
                )  # fmt: skip
    for i in range(masks.shape[0]):
        for m in range(members.size):
            masks[i, place + m] = sky[m, i]


@reduction_subroutine
def _risen(corners, normal, origin, size, above):
    """Indices of facets with a corner above the plane by more than rounding, into `above`."""
    count = 0
    for g in range(corners.shape[0]):
        height = -np.inf
        for k in range(3):
            h = 0.0
            for i in range(3):
                h += normal[i] * (corners[g, k, i] - origin[i])
            height = max(height, h)
        if height > 1e-9 * size:
            above[count] = g
            count += 1
    return count


@reduction_subroutine
def _hide(triangle, own, normal, both, shift, resolution, clear, sky):
    """Clear a bit of the cells whose direction from `own` meets the triangle above the plane."""
    ax, ay, az = triangle[0, 0] - own[0], triangle[0, 1] - own[1], triangle[0, 2] - own[2]
    bx, by, bz = triangle[1, 0] - own[0], triangle[1, 1] - own[1], triangle[1, 2] - own[2]
    cx, cy, cz = triangle[2, 0] - own[0], triangle[2, 1] - own[1], triangle[2, 2] - own[2]
    # Normals of the planes through the point and an edge.  For a triangle seen from its back all
    # three point inward, so a negative determinant means that its front faces the point.
    e0 = (by * cz - bz * cy, bz * cx - bx * cz, bx * cy - by * cx)
    e1 = (cy * az - cz * ay, cz * ax - cx * az, cx * ay - cy * ax)
    e2 = (ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx)
    det = ax * e0[0] + ay * e0[1] + az * e0[2]
    if det >= 0.0 and not both:
        return
    turn = -1.0 if det < 0.0 else 1.0
    px, py, pz = (ax, bx, cx), (ay, by, cy), (az, bz, cz)
    n = (normal[0], normal[1], normal[2])
    _on_faces(0, px, py, pz, e0, e1, e2, n, turn, shift, resolution, clear, sky)
    _on_faces(1, py, pz, px, _cycled(e0), _cycled(e1), _cycled(e2), _cycled(n), turn, shift,
              resolution, clear, sky)  # fmt: skip
    _on_faces(2, pz, px, py, _cycled(_cycled(e0)), _cycled(_cycled(e1)), _cycled(_cycled(e2)),
              _cycled(_cycled(n)), turn, shift, resolution, clear, sky)  # fmt: skip


@reduction_inlined
def _cycled(v):
    return v[1], v[2], v[0]


@reduction_subroutine
def _on_faces(axis, pw, pu, pv, e0, e1, e2, n, turn, shift, resolution, clear, sky):
    """Paint both faces of one axis; components are along this axis, the next and the one after."""
    for side in range(2):
        sign = 1.0 - 2.0 * side
        w0, w1, w2 = sign * pw[0], sign * pw[1], sign * pw[2]
        if w0 <= 0.0 and w1 <= 0.0 and w2 <= 0.0:
            continue
        low, high = -2.0, 2.0
        if w0 > 0.0 and w1 > 0.0 and w2 > 0.0:
            t0, t1, t2 = pv[0] / w0, pv[1] / w1, pv[2] / w2
            low, high = min(t0, t1, t2), max(t0, t1, t2)
            t0, t1, t2 = pu[0] / w0, pu[1] / w1, pu[2] / w2
            if min(t0, t1, t2) > 1.1 or max(t0, t1, t2) < -1.1:
                continue
        half = 0.5 * resolution
        first = _next(low, half, shift[1])
        last = _next(high, half, shift[1])
        base = (2 * axis + side) * resolution * resolution
        for row in range(max(first, 0), min(last, resolution)):
            v = _tangent((row + 0.5 + shift[1]) / half - 1.0)
            left, right = -2.0, 2.0
            left, right = _cut(turn * e0[1], turn * (sign * e0[0] + v * e0[2]), left, right)
            left, right = _cut(turn * e1[1], turn * (sign * e1[0] + v * e1[2]), left, right)
            left, right = _cut(turn * e2[1], turn * (sign * e2[0] + v * e2[2]), left, right)
            left, right = _cut(n[1], sign * n[0] + v * n[2], left, right)
            if left < right:
                begin = max(_next(left, half, shift[0]), 0)
                end = min(_next(right, half, shift[0]), resolution)
                for i in range(base + row * resolution + begin, base + row * resolution + end):
                    sky[i] &= clear


@reduction_inlined
def _cut(slope, level, left, right):
    """The part of the interval (left, right) where slope u + level > 0."""
    if slope > 0.0:
        return max(left, -level / slope), right
    if slope < 0.0:
        return left, min(right, -level / slope)
    return (left, right) if level > 0.0 else (right, left)


@reduction_inlined
def _next(u, half, shift):
    """The first cell of a row whose tangent is not below u."""
    return int(np.ceil((1.0 + evened(u)) * half - 0.5 - shift))


@reduction_inlined
def _tangent(s):
    """The tangent at a place on a face; the inverse of `evened`."""
    u = ((1.0 + abs(s)) * (1.0 + abs(s)) - 1.0) / 3.0
    return u if s >= 0.0 else -u
