"""The sum over a mesh of few facets under a law that is evaluated facet by facet.

All facets of an epoch are evaluated, eight at a time, the dark ones too.  Up to some tens of facets
that takes less time than to gather those that are both lit and seen, as `sums` does for more: their
number changes from epoch to epoch, and the processor guesses branches wrong.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING

import numpy as np

from attitude._compilation.decorators import reduction_over
from attitude._compilation.simd import (
    at_most,
    bits_set_in_bytes,
    chosen,
    eight,
    every,
    lanes,
    positive_bits,
    summed_up,
)
from attitude._support.arrays import frozen
from attitude.light_curve._sums import SIZE, aligned
from attitude.scattering._law import TERMS

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from attitude._compilation.decorators import Compilable, EntryPoint
    from attitude._support.annotations import FloatArray, IntArray
    from attitude.shape._mesh import Mesh

# Packs of eight facets up to which evaluating all of them is faster (benchmarks/light_curve.py).
MOST_PACKS = 6
# Numbers of each facet, in rows of SIZE: the normal and the area.
_ROWS = 4
_ZEROS = (0.0,) * SIZE
# Unsigned indices: for signed ones numba adds a test for negative values to every access.
_PACK = np.uint64(_ROWS * SIZE)
_Y, _Z, _AREA = (np.uint64(k * SIZE) for k in (1, 2, 3))


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
    blocks = np.zeros((_ROWS, len(places)))
    blocks[:3, used] = mesh.normals[places[used]].T
    blocks[3, used] = mesh.areas[places[used]] / np.sum(mesh.areas)
    blocks = np.swapaxes(blocks.reshape(_ROWS, -1, SIZE), 0, 1)
    return Packs(aligned(blocks), first, places)


def arranged(
    masks: NDArray[np.uint8], packs: Packs, order: IntArray | None = None
) -> NDArray[np.uint64]:
    """The masks of `Visibility`, a column for each facet in `order`, a word a pack; zeros without
    an order.
    """
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
                    i = n * _PACK
                    x, y, z = eight(facets, i), eight(facets, i + _Y), eight(facets, i + _Z)
                    weight = eight(facets, i + _AREA)
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
