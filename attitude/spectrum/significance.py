"""What pairs of frequencies mean: chance among permuted values, and aliases of one cycle a day."""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

import numpy as np

from attitude import validation
from attitude.spectrum import pair_scan, pair_search

if TYPE_CHECKING:
    from collections.abc import Sequence

    from attitude.annotations import FloatArray

# Pairs that a permutation of the values is fitted with, and permutations.
_PERMUTED, _TIMES = 20_000, 10
# Periods, s, of the Sun and of the stars, at which the observations of one site recur.
DAYS: tuple[float, float] = (86400.0, 86164.1)
_EULER = 0.5772


class PairLike(Protocol):
    """Two frequencies, the lower one first."""

    @property
    def first(self) -> float:
        """Hz."""

    @property
    def second(self) -> float:
        """Hz."""


def alias_of(first: float, second: float, better: Sequence[PairLike], near: float) -> int | None:
    """The rank of a better pair from which a pair differs by one cycle a day, or None.

    Parameters
    ----------
    first, second : float
        Hz, the lower one first.
    better : sequence of pairs
    near : float
        Hz, within which frequencies are equal.
    """
    for rank, pair in enumerate(better):
        for day in DAYS:
            ends = [(pair.first, abs(pair.second + s / day)) for s in (-1, 1)]
            ends += [(abs(pair.first + s / day), pair.second) for s in (-1, 1)]
            for a, b in ends:
                low, high = min(a, b), max(a, b)
                if abs(low - first) < near and abs(high - second) < near:
                    return rank
    return None


def share_of_chance(
    t: FloatArray, weights: FloatArray, y: FloatArray, turns: float, order: int, seed: int
) -> float:
    """The share of chi-squared left that 1 of 100 light curves of permuted values reaches.

    Parameters
    ----------
    t, weights, y : (N,) arrays
        Epochs in spans, inverse variances, values without their linear terms.
    turns : float
        Largest frequency, turns per span.
    order, seed : int

    Notes
    -----
    From Gumbel's distribution of the largest decrease among some pairs, extended to all.
    """
    generator = validation.generator(seed)
    count = int(turns * pair_search.OVERSAMPLING) + 1
    all_pairs = max(count * (count - 1) // 2, 1)
    tried = min(all_pairs, _PERMUTED if order < 3 else _PERMUTED // 10)
    pair = generator.integers(2, count, (2, tried))
    lines = pair_scan.harmonics(order)
    best = []
    for _ in range(_TIMES):
        mixed = y[generator.permutation(len(y))]
        made = pair_search.tables(
            t, weights, mixed, 1.0 / pair_search.OVERSAMPLING, 4 * order * (count + 1) + 2
        )
        gain = np.empty(tried)
        pair_scan.decreases(*made[:4], pair[0], pair[1], lines, pair_search.RIDGE, gain)
        best.append(float(gain.max() / made.total))
    scale = max(np.std(best) * np.sqrt(6.0) / np.pi, 1e-6)
    place = np.mean(best) - _EULER * scale + scale * np.log(all_pairs / tried)
    return float(max(0.0, 1.0 - (place - scale * np.log(-np.log(0.99)))))
