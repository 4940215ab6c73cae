"""The compiled sums over facets, eight at a time, and the closed form of an ellipsoid.

`_brightness` calls them.  Directions come by component, so that an array in component-major memory
is read in place.  Facets are in clusters, with rows that the caller has multiplied by weights;
masks are those of `_visibility`, or None where nothing casts a shadow.
"""

from __future__ import annotations

import math
import weakref
from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING

import numpy as np

from attitude._compilation.decorators import (
    quickly_compiled,
    reduction,
    reduction_inlined,
    reduction_over,
)
from attitude._compilation.instructions import as_bits, bits_set, fence, from_bits, lowest_bit
from attitude._compilation.simd import (
    at_least,
    at_most,
    bits_set_in_bytes,
    chosen,
    eight,
    every,
    lanes,
    packed,
    positive_bits,
    put_eight,
    root,
    sixteen,
    summed_up,
    truncated,
)
from attitude._support.arrays import frozen
from attitude.scattering._law import TERMS

if TYPE_CHECKING:
    from typing import Any

    from numpy.typing import NDArray

    from attitude._compilation.decorators import Compilable, EntryPoint
    from attitude._support.annotations import FloatArray, IntArray
    from attitude.shape._mesh import Mesh


# ---- Facets in clusters of similar normals, so that clusters turned away are skipped together
# A branch for each facet costs three times what it saves, since it breaks the vector instructions;
# one bit for eight facets does not.  A table of small cells around the sphere gives the clusters
# that face a direction, as words of bits; the sum runs over the clusters that face both Sun and
# observer. With random directions these hold 35% of 1000 facets, where a quarter of the facets are
# both lit and seen.
#
# All normals of a cluster have a positive component along one axis: x, y, z or one of their
# opposites.  Divided by this component, the height, a normal is two slopes and 1: the cosine
# between normal and direction, over the height, takes two products instead of three.

# Facets in a cluster, one SIMD vector (`simd`).  Larger ones are skipped less often.
SIZE = 8
# Numbers of each facet, in rows of SIZE: two slopes, height along the axis, area.
ROWS = 4
# Bits, one for each cluster, in a word of the table.
WORD = 64
# Cells along an edge of the cube from -1 to 1 that divides the directions, and the upper bound of
# the table in bytes; coarser cells skip fewer clusters.
_CELLS = 32
_LARGEST = 1 << 26
# Clusters up to which each facet is compared with each cell; of more, which have smaller boxes, the
# box of their normals is compared, an eighth of the work.
_EXACT = 4096
# Scale by which components of 1, and directions with a rounded length, stay in the last cell.
_INSET = 1.0 - 1e-5
# Lower bound of the height of a facet in its cluster; of a single facet it is at least 0.57.
_LEAST_HEIGHT = 0.25
# Tolerance of the length of directions, and of cosines in single precision.
_SLACK = 1e-5

_made: weakref.WeakKeyDictionary[Mesh, Clusters] = weakref.WeakKeyDictionary()


@dataclass(frozen=True, eq=False)
class Clusters:
    """The facets of a mesh in the memory layout of the compiled sums: C clusters of SIZE places.

    blocks: slopes of normals along the two axes after that of the cluster, heights along it, shares
    of the area, 0 in empty places. axes: indices into (x, y, z, x, y, -x, -y, -z) of a direction.
    sky: a bit for each cluster that faces a direction of the cell.
    """

    blocks: FloatArray  # (C * ROWS * SIZE,)
    axes: NDArray[np.uint64]  # (C, 2)
    sky: NDArray[np.uint64]  # (cells^3, C / WORD)
    cells: int
    order: IntArray
    area: float

    def __post_init__(self) -> None:
        for array in (self.blocks, self.axes, self.sky, self.order):
            frozen(array)

    def __reduce__(self) -> tuple[Any, ...]:
        return Clusters, (self.blocks, self.axes, self.sky, self.cells, self.order, self.area)

    @property
    def count(self) -> int:
        """Number of clusters; the words of `sky` may have unused bits beyond."""
        return len(self.axes)

    def rows(self) -> FloatArray:
        """A writable copy of `blocks` as (C, ROWS, SIZE), for weights and then `aligned`."""
        return self.blocks.reshape(-1, ROWS, SIZE).copy()


def clusters_of(mesh: Mesh) -> Clusters:
    """The clusters of a mesh; computed once and kept as long as the mesh."""
    if mesh not in _made:
        _made[mesh] = clustered(mesh.normals, mesh.areas)
    return _made[mesh]


def clustered(normals: FloatArray, areas: FloatArray) -> Clusters:
    """`Clusters` of (F, 3) unit normals and (F,) areas."""
    order = _grouped(normals)
    total = float(np.sum(areas))
    used = order >= 0
    normals_there = np.where(used[..., None], normals[order], 0.0)
    # the axis with the largest minimum height, be it the opposite one
    low = np.min(np.where(used[..., None], normals_there, np.inf), axis=1)
    high = np.max(np.where(used[..., None], normals_there, -np.inf), axis=1)
    best = np.argmax(np.concatenate([low, -high], axis=1), axis=1)
    axis, opposite = best % 3, best // 3
    following = (axis[:, None] + [1, 2, 3]) % 3
    normals_there = np.take_along_axis(normals_there, following[:, None, :], axis=2)
    height = np.abs(normals_there[..., 2])
    over = np.where(used, height, 1.0)
    slopes = normals_there[..., 0] / over, normals_there[..., 1] / over
    blocks = np.stack([*slopes, height, np.where(used, areas[order] / total, 0.0)], axis=1)
    axes = np.stack([axis + 1, axis + 5 * opposite], axis=1).astype(np.uint64)
    cells, sky = _sky(normals, order)
    return Clusters(aligned(blocks), axes, sky, cells, order.reshape(-1), total)


def aligned(blocks: FloatArray) -> FloatArray:
    """A flat read-only copy in 64-byte alignment, by which vector loads are 5% faster."""
    padded = np.empty(blocks.size + 8)
    skip = -padded.ctypes.data // 8 % 8
    copy = padded[skip : skip + blocks.size]
    copy[:] = blocks.reshape(-1)
    return frozen(copy)


def cell_scale(cells: int) -> float:
    """The factor s by which a component x of a direction is in cell int(s x + cells/2)."""
    return 0.5 * cells * _INSET


def _grouped(normals: FloatArray) -> IntArray:
    """Facets (C, SIZE), -1 in empty places, of groups with a common axis.

    All groups are split along their widest axes, a multiple of SIZE on the left: most groups are
    full.
    """
    count = len(normals)
    members = np.arange(count)
    ranks = np.array([np.unique(column, return_inverse=True)[1] for column in normals.T])
    first, size = np.zeros(1, dtype=np.int64), np.array([count])
    whole_groups = []
    while len(first):
        number = np.repeat(np.arange(len(first)), size)
        begin = np.cumsum(size) - size
        places = np.arange(len(number)) + (first - begin)[number]
        normals_there = normals[members[places]]
        low = np.minimum.reduceat(normals_there, begin)
        high = np.maximum.reduceat(normals_there, begin)
        few = size <= SIZE
        whole = few & (np.max(np.maximum(low, -high), axis=1) >= _LEAST_HEIGHT)
        whole_groups.append(np.stack([first, size], axis=1)[whole])
        split = ~whole[number]
        places, number = places[split], number[split]
        chosen = members[places]
        widest = np.argmax(high - low, axis=1)
        key = number * count + ranks[widest[number], chosen]
        members[places] = chosen[np.argsort(key, kind="stable")]
        half = np.where(few, size // 2, -(-size // SIZE) // 2 * SIZE)
        left = np.stack([first, half], axis=1)
        right = np.stack([first + half, size - half], axis=1)
        first, size = np.stack([left, right], axis=1)[~whole].reshape(-1, 2).T
    groups = np.concatenate(whole_groups)
    groups = groups[np.argsort(groups[:, 0])]
    order = np.full((len(groups), SIZE), -1)
    place = np.arange(SIZE)
    used = place < groups[:, 1:]
    order[used] = members[(groups[:, :1] + place)[used]]
    return order


def _sky(normals: FloatArray, order: IntArray) -> tuple[int, NDArray[np.uint64]]:
    """Cells along an edge, and the table of clusters by cell; see `Clusters.sky`."""
    words = -(-len(order) // WORD)
    cells = _CELLS
    while cells > 8 and cells**3 * words * 8 > _LARGEST:
        cells //= 2
    half = 0.5 / cell_scale(cells)
    middle = (2.0 * np.arange(cells) + 1.0 - cells) * half
    centers = np.stack(np.meshgrid(middle, middle, middle, indexing="ij"), axis=-1).reshape(-1, 3)
    nearest = np.linalg.norm(np.maximum(np.abs(centers) - half, 0.0), axis=1)
    farthest = np.linalg.norm(np.abs(centers) + half, axis=1)
    closest = np.flatnonzero((nearest <= 1.0 + _SLACK) & (farthest >= 1.0 - _SLACK))
    looking = centers[closest].astype(np.float32)
    few_left = len(order) <= _EXACT
    normals_there, empty = normals[order], order[..., None] < 0
    if few_left:
        low = high = np.where(empty, 0.0, normals_there).reshape(-1, 3)
    else:
        low = np.min(np.where(empty, np.inf, normals_there), axis=1)
        high = np.max(np.where(empty, -np.inf, normals_there), axis=1)
    # The largest cosine of a direction with normals in a box: its middle times the direction, and
    # half its edges times the sizes of the components.  It exceeds that at the middle of the cell
    # by at most `half` for each axis.
    spare = half * np.sum(np.maximum(np.abs(low), np.abs(high)), axis=1) + _SLACK
    if few_left:
        spare[empty.reshape(-1)] = -9.0
    boxes = np.column_stack([0.5 * (low + high), 0.5 * (high - low), spare]).astype(np.float32)
    ahead = np.column_stack([looking, np.abs(looking), np.ones(len(looking))]).astype(np.float32)
    sky = np.zeros((cells**3, words), dtype=np.uint64)
    step = WORD * SIZE if few_left else WORD
    for word in range(words):
        shown = ahead @ boxes[word * step : (word + 1) * step].T > 0.0
        if few_left:  # the eight facets of a cluster are the eight bytes of a word
            shown = np.ascontiguousarray(shown).view(np.uint64) != 0
        packed = np.packbits(shown, axis=1, bitorder="little")
        bits = np.zeros((len(closest), WORD // 8), dtype=np.uint8)
        bits[:, : packed.shape[1]] = packed
        sky[closest, word] = bits.view("<u8")[:, 0]
    return cells, sky


# ---- Brightness of a Lommel-Seeliger ellipsoid in closed form, compiled
# Muinonen & Lumme, A&A 584, A23, 2015, eq. 12, rewritten without cancellation.  With p = s/a and
# q = o/a by components, P = |p|, Q = |q|, S = P + Q, x = |p + q|/S and y = 1 - x^2,
#
#     integral of mu0 mu / (mu0 + mu) dA = (pi a b c / 4) (m / S) G(x),
#     m = 2 (P Q + p.q),    y = 2 (P Q - p.q) / S^2,    G = (x - y atanh x) / x^3,
#
# where G falls from 1 (opposition of a sphere) to 2/3 (backlit), and m falls to 0.  Backlit, p and
# q are nearly opposite: p + q is then computed as (s + o)/a, where s + o is exact, and m as 2 |p x
# (p + q)|^2 / (P Q - p.q).  Below x = 1/3 the closed form of G loses digits; there G = 1 - y R,
# atanh x = x + x^3 R.
#
# Measured against 60 digits: 6.8e-15 at worst, for axes up to 10 : 2 : 1 and phase angles from 0 to
# pi - 1e-8.  Compiled without fastmath, which would reorder sums.

_LN2 = 0.6931471805599453
# The difference of the bits of two doubles, over 2^52, is the binary logarithm of their ratio
# within 0.086.  With this added, its whole part is at least 1 for ratios from 2 (x = 1/3) on, and
# leaves a ratio from 0.88 to 2, |f| <= 1/3.
_ROUNDING = 0x1620000000000
# Polynomial of least maximum error; with these coefficients 2e-17.
_R0 = 0.3333333333333333
_R1 = 0.1999999999999975
_R2 = 0.14285714285803394
_R3 = 0.11111111098732392
_R4 = 0.09090909971595426
_R5 = 0.07692271221627803
_R6 = 0.06667604894870639
_R7 = 0.05866942116729435
_R8 = 0.054241007161985766
_R9 = 0.037396652525503456
_R10 = 0.07826828806597469


@quickly_compiled
def ellipsoid(a, b, c, factor, sx, sy, sz, ox, oy, oz, out):
    """factor times the integral (m2) for each epoch, into out (N,), for semi-axes a, b, c (m).

    A branch or a call in the loop would keep it from being vectorised.
    """
    ia, ib, ic = 1.0 / a, 1.0 / b, 1.0 / c
    scale = 0.25 * math.pi * a * b * c * factor
    for t in range(out.size):
        out[t] = intensity(ia, ib, ic, scale, sx[t], sy[t], sz[t], ox[t], oy[t], oz[t])


@reduction_inlined
def intensity(ia, ib, ic, scale, sx, sy, sz, ox, oy, oz):
    """The integral for one pair of unit vectors, times a factor: scale is pi a b c / 4 times it.

    scale (m / S) G with x = d / S and y = `shade` / S^2, as one fraction.
    """
    px, py, pz = sx * ia, sy * ib, sz * ic
    qx, qy, qz = ox * ia, oy * ib, oz * ic
    dx, dy, dz = (sx + ox) * ia, (sy + oy) * ib, (sz + oz) * ic
    p = math.sqrt(px * px + py * py + pz * pz)
    q = math.sqrt(qx * qx + qy * qy + qz * qz)
    square = dx * dx + dy * dy + dz * dz
    d, s = math.sqrt(square), p + q
    both, dot = p * q, px * qx + py * qy + pz * qz
    apart = both - dot
    vx, vy, vz = py * dz - pz * dy, pz * dx - px * dz, px * dy - py * dx
    cross = vx * vx + vy * vy + vz * vz
    m, below = (both + dot if dot > 0.0 else cross), (1.0 if dot > 0.0 else apart)
    whole = s * s
    shade = max(2.0 * apart, 1e-250 * whole)
    is_close = 9.0 * square < whole
    # atanh x = k log(2) / 2 + atanh f, since exp(2 atanh x) = (S + d)^2 / (S^2 - d^2).
    top = (s + d) * (s + d)
    k = (as_bits(top) - as_bits(shade) + _ROUNDING) >> 52
    top = from_bits(as_bits(top) - (k << 52))
    f = (d if is_close else top - shade) / (s if is_close else top + shade)
    u = f * f
    r = _cubes(u)
    atanh = (0.5 * _LN2) * float(k) + (f + f * u * r)
    # Near, f is x, and G is 1 - y R without the cancellation of the closed form.
    a = whole - shade * r if is_close else d * s - shade * atanh
    b = whole * s if is_close else d * square
    return scale * 2.0 * m * a / (below * b)


@reduction_inlined
def _cubes(u):
    """R with atanh f = f + f^3 R(u), u = f^2 up to 1/9, in two chains."""
    v = u * u
    even = ((((_R10 * v + _R8) * v + _R6) * v + _R4) * v + _R2) * v + _R0
    odd = (((_R9 * v + _R7) * v + _R5) * v + _R3) * v + _R1
    return even + u * odd


# _TINY replaces mu0 <= 0, which avoids a branch and a division by zero: the sum over facets that
# are dark or turned away is less than _DARK.
_TINY = (1e-100,) * SIZE
_DARK = 1e-90
_ZEROS = (0.0,) * SIZE
_SIXTEEN_ZEROS = (0.0,) * (2 * SIZE)
_ONES = (1.0,) * SIZE

# Unsigned indices: for signed ones numba adds a test for negative values to every access.  Counters
# of loops are made such too: Python counts in its own integers, whose sums numpy 1 makes doubles.
_0, _1, _2, _LAST, _EYE = (np.uint64(k) for k in (0, 1, 2, 2 * SIZE - 1, 8))
_BLOCK = np.uint64(ROWS * SIZE)
_PLACES = np.uint64(SIZE)
_AT_ONCE = np.uint64(2 * SIZE)
_ROW_1, _ROW_2, _ROW_3 = (np.uint64(k * SIZE) for k in (1, 2, 3))
_WORD = np.uint64(WORD)

compiled_cell_scale = reduction_inlined(cell_scale)


@reduction_inlined
def _looked_up(cells, x, y, z):
    """The index of the row of a direction in `Clusters.sky`: a view would count references."""
    scale, half = compiled_cell_scale(cells), 0.5 * cells
    i = int(x * scale + half)
    j = int(y * scale + half)
    k = int(z * scale + half)
    return np.uint64((i * cells + j) * cells + k)


@reduction_inlined
def _laid_out(ways, first, x, y, z):
    """Write a direction into `ways` from index `first` on, as `Clusters.axes` indexes it."""
    ways[first], ways[first + 1], ways[first + 2] = x, y, z
    ways[first + 3], ways[first + 4] = x, y
    ways[first + 5], ways[first + 6], ways[first + 7] = -x, -y, -z


@reduction_inlined
def _cosines(x, y, ways, way, height):
    """Cosines of a direction and normals of slopes x, y, over heights; `way` as `Clusters.axes`."""
    return x * ways[way] + y * ways[way + _1] + ways[height]


@reduction_inlined
def _length(x, y, z):
    return math.sqrt(x * x + y * y + z * z)


@reduction
def stray(x, y, z):
    """Sum of (|v|^2 - 1)^2 over vectors given by component (N,); NaN if any component is NaN."""
    total = 0.0
    for t in range(x.size):
        excess = x[t] * x[t] + y[t] * y[t] + z[t] * z[t] - 1.0
        total += excess * excess
    return total


@reduction
def halves(sx, sy, sz, ox, oy, oz, cosines, sines):
    """Write cosine and sine of half the angle between pairs of directions, all (N,)."""
    for t in range(cosines.size):
        cosines[t] = 0.5 * _length(sx[t] + ox[t], sy[t] + oy[t], sz[t] + oz[t])
        sines[t] = 0.5 * _length(sx[t] - ox[t], sy[t] - oy[t], sz[t] - oz[t])


@reduction
def fused(blocks, axes, sky, cells, masks, sun_cells, eye_cells, sx, sy, sz, ox, oy, oz, out):
    """Sum over facets of p q [g / (p + q) + h] with p, q = mu0, mu over the normal's height.

    g and h are the last rows of `blocks`. With masks, a word for a cluster, each term is multiplied
    by the number of its points that are lit and seen.
    """
    ways = np.empty(16)
    tiny, zeros = lanes(_TINY), lanes(_ZEROS)
    for t in range(out.size):
        a, b, c, d, e, f = sx[t], sy[t], sz[t], ox[t], oy[t], oz[t]
        lit, seen = _looked_up(cells, a, b, c), _looked_up(cells, d, e, f)
        if masks is not None:
            free_sun, free_eye = np.uint64(sun_cells[t]), np.uint64(eye_cells[t])
        _laid_out(ways, 0, a, b, c)
        _laid_out(ways, 8, d, e, f)
        sums = zeros
        for w in range(np.uint64(sky.shape[1])):
            word = sky[lit, w] & sky[seen, w]
            while word != _0:
                n = lowest_bit(word) + np.uint64(w) * _WORD
                word &= word - _1
                i, way, axis = n * _BLOCK, axes[n, 0], axes[n, 1]
                x, y = eight(blocks, i), eight(blocks, i + _ROW_1)
                g, h = eight(blocks, i + _ROW_2), eight(blocks, i + _ROW_3)
                p = at_least(_cosines(x, y, ways, way, axis), tiny)
                q = at_least(_cosines(x, y, ways, way + _EYE, axis + _EYE), zeros)
                product = p * q
                if masks is not None:
                    product = product * bits_set_in_bytes(masks[free_sun, n] & masks[free_eye, n])
                sums = sums + product * (g / (p + q) + h)
        total = summed_up(sums)
        out[t] = total if total > _DARK else 0.0


@reduction
def cells_of(x, y, z, resolution, out):
    """Write the indices of the cells of directions on the cube of `_visibility`, as doubles.

    Eight at once, without branches: the arrays are as long as a multiple of eight.
    """
    for t in range(0, out.size, 8):
        a, b, c = eight(x, t), eight(y, t), eight(z, t)
        ax, ay, az = at_least(a, -1.0 * a), at_least(b, -1.0 * b), at_least(c, -1.0 * c)
        # lanes above zero: the largest component is not x; of y and z it is z
        others, last = at_least(ay, az) - ax, az - ay
        w = chosen(others, chosen(last, c, b), a)
        u = chosen(others, chosen(last, a, c), b)
        v = chosen(others, chosen(last, b, a), c)
        face = chosen(others, chosen(last, every(4.0, a), every(2.0, a)), every(0.0, a))
        face = chosen(-1.0 * w, face + 1.0, face)
        w = 1.0 / at_least(w, -1.0 * w)
        column = truncated((1.0 + _evened_lanes(u * w)) * (0.5 * resolution))
        row = truncated((1.0 + _evened_lanes(v * w)) * (0.5 * resolution))
        column, row = at_most(column, resolution - 1.0), at_most(row, resolution - 1.0)
        put_eight(out, t, (face * resolution + row) * resolution + column)


@reduction_inlined
def _evened_lanes(u):
    """`evened` of a vector."""
    s = root(1.0 + 3.0 * at_least(u, -1.0 * u)) - 1.0
    return chosen(-1.0 * u, -1.0 * s, s)


@reduction_inlined
def evened(u):
    """Place on a face from a tangent, -1 to 1: Google's S2, cells of nearly equal angles."""
    s = math.sqrt(1.0 + 3.0 * abs(u)) - 1.0
    return s if u >= 0.0 else -s


@reduction_inlined
def _filled_up(incidence, emission, weights, used, ones, zeros):
    """The next multiple of sixteen; the places before it get weights of zero."""
    for place in (used, used + _PLACES):
        put_eight(incidence, place, ones)
        put_eight(emission, place, ones)
        put_eight(weights, place, zeros)
    return (used + _LAST) & ~_LAST


@reduction
def gather(
    begin, blocks, axes, sky, cells, segments, which, masks, sun_cells, eye_cells, sx, sy, sz, ox,
    oy, oz, incidence, emission, weights, ends,
):  # fmt: skip
    """Gather the facets of epochs from `begin` on; the number of the epoch after the last of them.

    segments (S, 3): a word of `sky`, its clusters with facets of a row, the row; `which` the row of
    each place. For each epoch and row, mu0, mu and the weights follow each other from ends[., row -
    1] to ends[., row], filled up to a multiple of sixteen by weights of zero.
    """
    ways = np.empty(16)
    ones, zeros = lanes(_ONES), lanes(_ZEROS)
    rows, shaded = ends.shape[1], masks.shape[0] > 1
    last = incidence.size - SIZE * (axes.shape[0] + 2 * rows)
    used = np.uint64(0)
    for t in range(begin, min(sx.size, begin + ends.shape[0])):
        if used > last:
            return t
        a, b, c, d, e, f = sx[t], sy[t], sz[t], ox[t], oy[t], oz[t]
        lit, seen = _looked_up(cells, a, b, c), _looked_up(cells, d, e, f)
        free_sun, free_eye = np.uint64(sun_cells[t]), np.uint64(eye_cells[t])
        _laid_out(ways, 0, a, b, c)
        _laid_out(ways, 8, d, e, f)
        row = _0
        for s in range(np.uint64(segments.shape[0])):
            if segments[s, _2] != row:
                used = _filled_up(incidence, emission, weights, used, ones, zeros)
                ends[np.uint64(t - begin), row] = used
                row += _1
            w = segments[s, _0]
            word = sky[lit, w] & sky[seen, w] & segments[s, _1]
            while word != _0:
                n = lowest_bit(word) + w * _WORD
                word &= word - _1
                i, way, axis = n * _BLOCK, axes[n, 0], axes[n, 1]
                x, y = eight(blocks, i), eight(blocks, i + _ROW_1)
                height = eight(blocks, i + _ROW_2)
                p = _cosines(x, y, ways, way, axis) * height
                q = _cosines(x, y, ways, way + _EYE, axis + _EYE) * height
                weight = eight(blocks, i + _ROW_3)
                if shaded:
                    free = masks[free_sun, n] & masks[free_eye, n]
                    weight = weight * (0.125 * bits_set_in_bytes(free))
                by = at_most(at_most(p, q), weight)
                if rows > 1:
                    other = eight(which, n * _PLACES) - float(row)
                    by = at_most(by, 0.5 - other * other)
                put_eight(incidence, used, packed(p, by))
                put_eight(emission, used, packed(q, by))
                put_eight(weights, used, packed(weight * (p * q), by))
                used += np.uint64(bits_set(np.uint8(positive_bits(by))))
        used = _filled_up(incidence, emission, weights, used, ones, zeros)
        ends[np.uint64(t - begin), row] = used
    return min(sx.size, begin + ends.shape[0])


@cache
def over_facets(of_phase: Compilable, element: Compilable, in_lanes: bool) -> EntryPoint:
    """The sum of mu0 mu (r / mu0) dA, compiled for each law, so that the loop has no branch for it.

    Of the rows, the arguments of `gather` as a tuple, cosines and sines of half the phase angles,
    and the output (N,); sixteen facets at a time with `in_lanes`.
    """

    @reduction_over(of_phase, element)
    def summed(rows, gathered, cosines, sines, out):
        incidence, emission, weights, ends = gathered[-4:]
        terms = np.empty(TERMS)
        out[:] = 0.0
        begin = 0
        while begin < out.size:
            stop = gather(begin, *gathered)
            for m in range(rows.shape[0]):
                row = rows[m]
                for t in range(begin, stop):
                    first, end = _between(ends, t - begin, m)
                    if first < end:
                        of_phase(row, cosines[t], sines[t], terms)
                        if in_lanes:  # numba compiles one of the branches
                            sums = lanes(_SIXTEEN_ZEROS)
                            for i in range(first, end, _AT_ONCE):
                                p, q = sixteen(incidence, i), sixteen(emission, i)
                                sums = sums + sixteen(weights, i) * element(row, terms, p, q)
                            out[t] += summed_up(sums)
                        else:
                            total = 0.0
                            for i in range(first, end):
                                if weights[i] > 0.0:
                                    r = element(row, terms, fence(incidence[i]), fence(emission[i]))
                                    total += weights[i] * fence(r)
                            out[t] += total
            begin = stop

    return summed


@reduction_inlined
def _between(ends, t, m):
    """Where the facets of epoch t and row m begin and end."""
    begin = _0
    if m > 0:
        begin = np.uint64(ends[t, m - 1])
    elif t > 0:
        begin = np.uint64(ends[t - 1, ends.shape[1] - 1])
    return begin, np.uint64(ends[t, m])


# ---- The sum over a mesh of few facets under a law that is evaluated facet by facet, compiled
# All facets of an epoch are evaluated, eight at a time, the dark ones too.  Up to some tens of
# facets that takes less time than to gather those that are both lit and seen, as `gather` does for
# more: their number changes from epoch to epoch, and the processor guesses branches wrong.
#
# Here the numbers of each facet, in rows of SIZE, are its normal and its area.

# Packs of eight facets up to which evaluating all of them is faster (benchmarks/light_curve.py).
MOST_PACKS = 6


@dataclass(frozen=True, eq=False)
class Packs:
    """Facets in packs of eight that have the same row of a law.

    facets (P * 32,): x, y, z of normals and areas, pack by pack; row m has the packs first[m] to
    first[m + 1]; order (P * 8,): the facet in each place, -1 in empty ones.
    """

    facets: FloatArray
    first: IntArray
    order: IntArray


def packs_of(mesh: Mesh, number: IntArray, rows: int, order: IntArray) -> Packs | None:
    """The facets of a mesh in packs; None if there are more than `MOST_PACKS`.

    number (F,): the row of the law; in `order` neighbours have similar normals, so that dark packs
    are skipped.
    """
    counts = np.bincount(number, minlength=rows)
    packs = -(-counts // SIZE)
    if np.sum(packs) > MOST_PACKS:
        return None
    first = np.concatenate([[0], np.cumsum(packs)])
    places = np.full(first[-1] * SIZE, -1)
    used_facets = order[order >= 0]
    for row in range(rows):
        of_row = used_facets[number[used_facets] == row]
        places[first[row] * SIZE : first[row] * SIZE + len(of_row)] = of_row
    used = places >= 0
    blocks = np.zeros((ROWS, len(places)))
    blocks[:3, used] = mesh.normals[places[used]].T
    blocks[3, used] = mesh.areas[places[used]] / np.sum(mesh.areas)
    blocks = np.swapaxes(blocks.reshape(ROWS, -1, SIZE), 0, 1)
    return Packs(aligned(blocks), first, places)


def arranged(
    masks: NDArray[np.uint8], packs: Packs, order: IntArray | None = None
) -> NDArray[np.uint64]:
    """Masks of `Visibility`, a column a facet in `order`, a word a pack; zeros without an order."""
    arranged_masks = np.zeros((len(masks), len(packs.order)), dtype=np.uint8)
    if order is not None:
        is_used, column = order >= 0, np.empty(len(order), dtype=np.int64)
        column[order[is_used]] = np.flatnonzero(is_used)
        used = packs.order >= 0
        arranged_masks[:, used] = masks[:, column[packs.order[used]]]
    return frozen(arranged_masks.view(np.uint64))


@cache
def summed_few_facets(of_phase: Compilable, elements: Compilable) -> EntryPoint:
    """The sum of mu0 mu (r / mu0) dA over packs for the functions of a law.

    Of rows (M, W), `Packs`, the masks of `arranged` (one row without shadows), cells and components
    of both directions, cosines and sines of half the phase angles, and the output (N,).
    """

    @reduction_over(of_phase, elements)
    def summed(
        rows, first, facets, masks, sun_cells, eye_cells, sx, sy, sz, ox, oy, oz, cosines, sines,
        out,
    ):  # fmt: skip
        terms = np.empty(TERMS)
        zeros = lanes(_ZEROS)
        shaded = masks.shape[0] > 1
        for t in range(out.size):
            a, b, c, d, e, f = sx[t], sy[t], sz[t], ox[t], oy[t], oz[t]
            free_sun, free_eye = np.uint64(sun_cells[t]), np.uint64(eye_cells[t])
            total = 0.0
            for m in range(rows.shape[0]):
                row = rows[m]
                of_phase(row, cosines[t], sines[t], terms)
                sums = zeros
                for n in range(np.uint64(first[m]), np.uint64(first[m + 1])):
                    i = n * _BLOCK
                    x, y, z = eight(facets, i), eight(facets, i + _ROW_1), eight(facets, i + _ROW_2)
                    weight = eight(facets, i + _ROW_3)
                    p, q = x * a + y * b + z * c, x * d + y * e + z * f
                    if shaded:
                        free = masks[free_sun, n] & masks[free_eye, n]
                        weight = weight * (0.125 * bits_set_in_bytes(free))
                    by = at_most(at_most(p, q), weight)
                    if positive_bits(by) != 0:
                        # dark facets have a place where every law is finite, and no weight
                        p, q = chosen(by, p, every(1.0, p)), chosen(by, q, every(1.0, q))
                        weight = chosen(by, weight, zeros)
                        sums = sums + weight * (p * q) * elements(row, terms, p, q)
                total += summed_up(sums)
            out[t] = total

    return summed
