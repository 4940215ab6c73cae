"""The sums over facets, compiled: one epoch after the other, sixteen facets at a time.

Only `brightness` calls them.  Directions come by component, so that an array in component-major
memory is read in place.  Facets are those of `clusters`; masks those of `visibility`.
"""

import math

import numpy as np

from attitude.light_curve.clusters import ROWS, SIZE, WORD
from attitude.light_curve.clusters import cell_scale as _cell_scale
from attitude.scattering.codes import WIDTH
from attitude.scattering.compiled import element, of_phase
from attitude.scattering.machine import bits_set, lowest_bit, merged, summed

# In place of mu0 = 0, so that nothing is divided by zero and no branch is needed: areas are in
# units of the whole, so a body that shows nothing sums to less than _NOTHING.
_TINY = 1e-100
_NOTHING = 1e-90

# Unsigned indices: numba would otherwise allow for negative ones in every access.
_BLOCK = np.uint64(ROWS * SIZE)
_PLACES = np.uint64(SIZE)
_1 = np.uint64(SIZE)
_2 = np.uint64(2 * SIZE)
_3 = np.uint64(3 * SIZE)
_WORD = np.uint64(WORD)
_ONE = np.uint64(1)
_NONE = np.uint64(0)

cell_scale = merged(_cell_scale)


@merged
def _looked_up(cells, x, y, z):
    """The row of a direction in `Clusters.sky`.

    Rows are passed by number: a view of one would be counted as a reference, by atomic
    instructions that take as long as a cluster.
    """
    scale, half = cell_scale(cells), 0.5 * cells
    i = int(x * scale + half)
    j = int(y * scale + half)
    k = int(z * scale + half)
    return np.uint64((i * cells + j) * cells + k)


@merged
def _added(part):
    """The sum of the sixteen, in halves: one after the other they would wait for each other."""
    for j in range(8):
        part[j] += part[j + 8]
    for j in range(4):
        part[j] += part[j + 4]
    return (part[0] + part[2]) + (part[1] + part[3])


@summed
def stray(x, y, z):
    """Sum of (|v|^2 - 1)^2 over vectors given by component; NaN if any holds NaN."""
    total = 0.0
    for t in range(x.size):
        excess = x[t] * x[t] + y[t] * y[t] + z[t] * z[t] - 1.0
        total += excess * excess
    return total


@summed
def fused(blocks, sky, cells, sx, sy, sz, ox, oy, oz, out):
    """Sum of mu0 mu [1 / (mu0 + mu) + w] dA; w dA^-1 is in the fourth row of `blocks`."""
    part = np.empty(SIZE)
    for t in range(out.size):
        a, b, c, d, e, f = sx[t], sy[t], sz[t], ox[t], oy[t], oz[t]
        lit, seen = _looked_up(cells, a, b, c), _looked_up(cells, d, e, f)
        for j in range(SIZE):
            part[j] = 0.0
        for w in range(np.uint64(sky.shape[1])):
            word = sky[lit, w] & sky[seen, w]
            while word != _NONE:
                i = (lowest_bit(word) + w * _WORD) * _BLOCK
                word &= word - _ONE
                for j in range(_PLACES):
                    x, y, z = blocks[i + j], blocks[i + _1 + j], blocks[i + _2 + j]
                    p = max(x * a + y * b + z * c, _TINY)
                    q = max(x * d + y * e + z * f, 0.0)
                    part[j] += p * q * (1.0 / (p + q) + blocks[i + _3 + j])
        total = _added(part)
        out[t] = total if total > _NOTHING else 0.0


@summed
def fused_lambert(blocks, sky, cells, sx, sy, sz, ox, oy, oz, out):
    """Sum of mu0 mu w dA; w dA^-1 is in the fourth row of `blocks`."""
    part = np.empty(SIZE)
    for t in range(out.size):
        a, b, c, d, e, f = sx[t], sy[t], sz[t], ox[t], oy[t], oz[t]
        lit, seen = _looked_up(cells, a, b, c), _looked_up(cells, d, e, f)
        for j in range(SIZE):
            part[j] = 0.0
        for w in range(np.uint64(sky.shape[1])):
            word = sky[lit, w] & sky[seen, w]
            while word != _NONE:
                i = (lowest_bit(word) + w * _WORD) * _BLOCK
                word &= word - _ONE
                for j in range(_PLACES):
                    x, y, z = blocks[i + j], blocks[i + _1 + j], blocks[i + _2 + j]
                    p = max(x * a + y * b + z * c, 0.0)
                    q = max(x * d + y * e + z * f, 0.0)
                    part[j] += p * q * blocks[i + _3 + j]
        total = _added(part)
        out[t] = total


@summed
def shadowed(blocks, sky, cells, weight, masks, resolution, sx, sy, sz, ox, oy, oz, out):
    """As `fused` times `weight` for 1 / (mu0 + mu), each facet by its share both lit and seen."""
    part = np.empty(SIZE)
    for t in range(out.size):
        a, b, c, d, e, f = sx[t], sy[t], sz[t], ox[t], oy[t], oz[t]
        free_sun = np.uint64(cell(a, b, c, resolution))
        free_eye = np.uint64(cell(d, e, f, resolution))
        lit, seen = _looked_up(cells, a, b, c), _looked_up(cells, d, e, f)
        for j in range(SIZE):
            part[j] = 0.0
        for w in range(np.uint64(sky.shape[1])):
            word = sky[lit, w] & sky[seen, w]
            while word != _NONE:
                i = (lowest_bit(word) + w * _WORD) * _BLOCK
                word &= word - _ONE
                k = i // np.uint64(ROWS)
                for j in range(_PLACES):
                    x, y, z = blocks[i + j], blocks[i + _1 + j], blocks[i + _2 + j]
                    p = max(x * a + y * b + z * c, _TINY)
                    q = max(x * d + y * e + z * f, 0.0)
                    share = np.float64(bits_set(masks[free_sun, k + j] & masks[free_eye, k + j]))
                    part[j] += p * q * share * (weight / (p + q) + blocks[i + _3 + j])
        total = _added(part)
        out[t] = total * 0.125 if total > _NOTHING else 0.0


@summed
def by_facet(blocks, sky, cells, rows, which, masks, resolution, sx, sy, sz, ox, oy, oz, out):
    """Sum of mu0 mu (r / mu0) dA for laws that are evaluated facet by facet.

    Here a branch pays: a law costs many times the test.  resolution 0: no shadows.
    """
    now = np.empty((rows.shape[0], WIDTH))
    for t in range(out.size):
        a, b, c, d, e, f = sx[t], sy[t], sz[t], ox[t], oy[t], oz[t]
        cos_alpha = a * d + b * e + c * f
        for m in range(rows.shape[0]):
            of_phase(rows[m], cos_alpha, now[m])
        free_sun = np.uint64(cell(a, b, c, resolution) if resolution > 0 else 0)
        free_eye = np.uint64(cell(d, e, f, resolution) if resolution > 0 else 0)
        lit, seen = _looked_up(cells, a, b, c), _looked_up(cells, d, e, f)
        total = 0.0
        for w in range(np.uint64(sky.shape[1])):
            word = sky[lit, w] & sky[seen, w]
            while word != _NONE:
                i = (lowest_bit(word) + w * _WORD) * _BLOCK
                word &= word - _ONE
                k = i // np.uint64(ROWS)
                for j in range(_PLACES):
                    x, y, z = blocks[i + j], blocks[i + _1 + j], blocks[i + _2 + j]
                    p = x * a + y * b + z * c
                    q = x * d + y * e + z * f
                    if p > 0.0 and q > 0.0:
                        share = np.float64(
                            bits_set(masks[free_sun, k + j] & masks[free_eye, k + j])
                        )
                        if share > 0.0:
                            inverse = blocks[i + _3 + j]
                            n = which[k + j]
                            r = element(rows[n], now[n], p * inverse, q * inverse)
                            total += share * p * q * inverse * r
        out[t] = total * 0.125


@merged
def cell(x, y, z, resolution):
    """The cell of a direction on the cube of `visibility`."""
    ax, ay, az = abs(x), abs(y), abs(z)
    if ax >= ay and ax >= az:
        face, w, u, v = 0, x, y, z
    elif ay >= az:
        face, w, u, v = 1, y, z, x
    else:
        face, w, u, v = 2, z, x, y
    side = 1 if w < 0.0 else 0
    w = 1.0 / abs(w)
    column = min(int((1.0 + evened(u * w)) * (0.5 * resolution)), resolution - 1)
    row = min(int((1.0 + evened(v * w)) * (0.5 * resolution)), resolution - 1)
    return ((2 * face + side) * resolution + row) * resolution + column


@merged
def evened(u):
    """Place on a face from a tangent, both -1 to 1, so that cells have nearly equal angles.

    The quadratic projection of Google's S2 library: one square root.
    """
    s = math.sqrt(1.0 + 3.0 * abs(u)) - 1.0
    return s if u >= 0.0 else -s
