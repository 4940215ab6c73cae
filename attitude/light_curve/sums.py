"""The compiled sums over facets: epoch by epoch, eight facets at a time.

`brightness` calls them.  Directions come by component, so that an array in component-major memory
is read in place.  Facets are those of `clusters`, with rows that the caller has multiplied by
weights; masks are those of `visibility`, or None where nothing casts a shadow.
"""

from __future__ import annotations

import math
from functools import cache
from typing import TYPE_CHECKING

import numpy as np

from attitude.compilation.decorators import reduction, reduction_inlined, reduction_over
from attitude.compilation.instructions import bits_set, fence, lowest_bit
from attitude.compilation.simd import (
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
from attitude.light_curve.clusters import ROWS, SIZE, WORD
from attitude.light_curve.clusters import cell_scale as _cell_scale
from attitude.scattering.reflectances import TERMS

if TYPE_CHECKING:
    from attitude.compilation.decorators import Compilable, EntryPoint

# _TINY replaces mu0 <= 0, which avoids a branch and a division by zero: the sum over facets that
# are dark or turned away is less than _DARK.
_TINY, _ZEROS, _ONES = (1e-100,) * SIZE, (0.0,) * SIZE, (1.0,) * SIZE
_SIXTEEN_ZEROS = (0.0,) * (2 * SIZE)
_DARK = 1e-90

# Unsigned indices: for signed ones numba adds a test for negative values to every access.  Counters
# of loops are made such too: Python counts in its own integers, whose sums numpy 1 makes doubles.
_0, _1, _2, _LAST, _EYE = (np.uint64(k) for k in (0, 1, 2, 2 * SIZE - 1, 8))
_BLOCK = np.uint64(ROWS * SIZE)
_PLACES = np.uint64(SIZE)
_AT_ONCE = np.uint64(2 * SIZE)
_ROW_1, _ROW_2, _ROW_3 = (np.uint64(k * SIZE) for k in (1, 2, 3))
_WORD = np.uint64(WORD)

cell_scale = reduction_inlined(_cell_scale)


@reduction_inlined
def _looked_up(cells, x, y, z):
    """The index of the row of a direction in `Clusters.sky`.

    The caller indexes the table: a view of the row would have a reference count, whose atomic
    instructions take as long as a cluster.
    """
    scale, half = cell_scale(cells), 0.5 * cells
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
def _cosines(x, y, ways, way, own):
    """Cosines between a direction and normals of slopes x and y, over the normals' heights.

    `way` and `own` are the indices of `Clusters.axes`.
    """
    return x * ways[way] + y * ways[way + _1] + ways[own]


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

    g and h are the third and fourth rows of `blocks`.  With masks, one word for the eight facets
    of a cluster, and `cells_of` both directions, each term is multiplied by the number of points of
    the facet that are both lit and seen.  Components of directions and out are (N,).
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
        part = zeros
        for w in range(np.uint64(sky.shape[1])):
            word = sky[lit, w] & sky[seen, w]
            while word != _0:
                n = lowest_bit(word) + np.uint64(w) * _WORD
                word &= word - _1
                i, way, own = n * _BLOCK, axes[n, 0], axes[n, 1]
                x, y = eight(blocks, i), eight(blocks, i + _ROW_1)
                g, h = eight(blocks, i + _ROW_2), eight(blocks, i + _ROW_3)
                p = at_least(_cosines(x, y, ways, way, own), tiny)
                q = at_least(_cosines(x, y, ways, way + _EYE, own + _EYE), zeros)
                product = p * q
                if masks is not None:
                    product = product * bits_set_in_bytes(masks[free_sun, n] & masks[free_eye, n])
                part = part + product * (g / (p + q) + h)
        total = summed_up(part)
        out[t] = total if total > _DARK else 0.0


@reduction
def cells_of(x, y, z, resolution, out):
    """Write the indices of the cells of directions on the cube of `visibility`, as doubles.

    Eight directions at once, and without branches, which random directions would make the processor
    guess wrong.  The arrays are as long as the first multiple of eight that holds the directions.
    """
    for t in range(0, out.size, 8):
        a, b, c = eight(x, t), eight(y, t), eight(z, t)
        ax, ay, az = at_least(a, -1.0 * a), at_least(b, -1.0 * b), at_least(c, -1.0 * c)
        # lanes above zero: the largest component is not x; of y and z it is z
        rest, last = at_least(ay, az) - ax, az - ay
        w = chosen(rest, chosen(last, c, b), a)
        u = chosen(rest, chosen(last, a, c), b)
        v = chosen(rest, chosen(last, b, a), c)
        face = chosen(rest, chosen(last, every(4.0, a), every(2.0, a)), every(0.0, a))
        face = chosen(-1.0 * w, face + 1.0, face)
        w = 1.0 / at_least(w, -1.0 * w)
        column = at_most(
            truncated((1.0 + _evened_lanes(u * w)) * (0.5 * resolution)), resolution - 1.0
        )
        row = at_most(
            truncated((1.0 + _evened_lanes(v * w)) * (0.5 * resolution)), resolution - 1.0
        )
        put_eight(out, t, (face * resolution + row) * resolution + column)


@reduction_inlined
def _evened_lanes(u):
    """`evened` of a vector."""
    s = root(1.0 + 3.0 * at_least(u, -1.0 * u)) - 1.0
    return chosen(-1.0 * u, -1.0 * s, s)


@reduction_inlined
def evened(u):
    """Place on a face from a tangent, both -1 to 1, by which cells have nearly equal angles.

    Source: the quadratic projection of Google's S2 library, which takes one square root.
    """
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

    `segments` (S, 3) hold a word of `sky`, the clusters of it with facets of a row of the law, and
    that row, in the order of rows; `which` the row of each place.  Masks are those of `fused`; one
    row where nothing casts a shadow.  For each epoch and row the cosines
    mu0, mu and the weights, area times mu0 mu times the share of free points, follow each other
    from ends[., row - 1] to ends[., row] in the three flat arrays, filled up to a multiple of
    sixteen by weights of zero.  It stops where another epoch might not fit.
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
                i, way, own = n * _BLOCK, axes[n, 0], axes[n, 1]
                x, y = eight(blocks, i), eight(blocks, i + _ROW_1)
                height = eight(blocks, i + _ROW_2)
                p = _cosines(x, y, ways, way, own) * height
                q = _cosines(x, y, ways, way + _EYE, own + _EYE) * height
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
def by_facet(of_phase: Compilable, element: Compilable) -> EntryPoint:
    """The sum over gathered facets for the functions of a law, one facet at a time.

    It is compiled for each pair, so that the loop over facets has no branch for the law; see
    `scattering.law`.  Arguments as of `by_sixteen`.
    """

    @reduction_over(of_phase, element)
    def summed(rows, given, cosines, sines, out):
        incidence, emission, weights, ends = given[-4:]
        terms = np.empty(TERMS)
        out[:] = 0.0
        begin = 0
        while begin < out.size:
            stop = gather(begin, *given)
            for m in range(rows.shape[0]):
                row = rows[m]
                for t in range(begin, stop):
                    first, end = _between(ends, t - begin, m)
                    if first < end:
                        of_phase(row, cosines[t], sines[t], terms)
                        total = 0.0
                        for i in range(first, end):
                            if weights[i] > 0.0:
                                r = element(row, terms, fence(incidence[i]), fence(emission[i]))
                                total += weights[i] * fence(r)
                        out[t] += total
            begin = stop

    return summed


@cache
def by_sixteen(of_phase: Compilable, elements: Compilable) -> EntryPoint:
    """As `by_facet`, sixteen facets at a time.

    The sum of mu0 mu (r / mu0) dA is called with the rows of the law, the arguments of `gather`
    after `begin` as a tuple, the cosines and sines of half the phase angles, and the output, a
    number for each epoch.  Facets are gathered for as many epochs as the arrays hold, and summed
    while they are in the cache.
    """

    @reduction_over(of_phase, elements)
    def summed(rows, given, cosines, sines, out):
        incidence, emission, weights, ends = given[-4:]
        terms = np.empty(TERMS)
        out[:] = 0.0
        begin = 0
        while begin < out.size:
            stop = gather(begin, *given)
            for m in range(rows.shape[0]):
                row = rows[m]
                for t in range(begin, stop):
                    first, end = _between(ends, t - begin, m)
                    if first < end:
                        of_phase(row, cosines[t], sines[t], terms)
                        part = lanes(_SIXTEEN_ZEROS)
                        for i in range(first, end, _AT_ONCE):
                            p, q = sixteen(incidence, i), sixteen(emission, i)
                            part = part + sixteen(weights, i) * elements(row, terms, p, q)
                        out[t] += summed_up(part)
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
