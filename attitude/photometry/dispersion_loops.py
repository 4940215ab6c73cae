"""Phase dispersion minimisation, compiled: variances within bins of phase at many frequencies."""

from __future__ import annotations

import numpy as np

from attitude.compilation.decorators import entry_point


@entry_point
def dispersions(t, y, weights, frequencies, bins, covers, out):
    """Theta of each frequency into out (K,): the variance within bins over that of all values.

    t, y, weights: (N,) arrays; frequencies: (K,), cycles per unit of t; bins: number of bins, each
    of which is `covers` times as wide as 1 / bins, so that each value lies in `covers` of them.
    """
    total = 0.0
    mean = 0.0
    for i in range(y.size):
        total += weights[i]
        mean += weights[i] * y[i]
    mean /= total
    whole = 0.0
    for i in range(y.size):
        whole += weights[i] * (y[i] - mean) ** 2
    whole /= total
    count = np.empty(bins)
    w, first, second = np.empty(bins), np.empty(bins), np.empty(bins)
    for k in range(frequencies.size):
        for b in range(bins):
            count[b] = 0.0
            w[b] = 0.0
            first[b] = 0.0
            second[b] = 0.0
        for i in range(t.size):
            turns = t[i] * frequencies[k]
            phase = turns - np.floor(turns)
            at = int(phase * bins)
            for c in range(covers):
                b = (at + c) % bins
                d = y[i] - mean
                count[b] += 1.0
                w[b] += weights[i]
                first[b] += weights[i] * d
                second[b] += weights[i] * d * d
        within, freedom = 0.0, 0.0
        for b in range(bins):
            if count[b] > 1.5:
                spread = second[b] / w[b] - (first[b] / w[b]) ** 2
                within += count[b] * spread
                freedom += count[b] - 1.0
        out[k] = within / freedom / whole if freedom > 0.0 else 1.0
