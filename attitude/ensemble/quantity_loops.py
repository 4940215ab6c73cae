"""The compiled loops of angles between a body axis and directions, and of order statistics."""

from attitude.compilation.decorators import entry_point, subroutine
from attitude.compilation.instructions import as_bits

# Bins of leading bits, of which each holds few numbers of a row.
BINS = 4096


@entry_point
def squared_tangents(wxyz, axis, x, y, z, out):
    """Squares of tan(angle / 2) between a body axis and directions, for N members at T epochs.

    Given
        wxyz     (N, 4, T) body to ICRF
        axis     (3,) unit vector in body axes
        x, y, z  (T,) unit vectors in ICRF
    Filled
        out      (N, T): |a - b|^2 / |a + b|^2, which keeps all digits at 0 and at pi
    """
    a, b, c = axis[0], axis[1], axis[2]
    for n in range(len(out)):
        for k in range(out.shape[1]):
            p, q, r, s = wxyz[n, 0, k], wxyz[n, 1, k], wxyz[n, 2, k], wxyz[n, 3, k]
            d = 2.0 * (r * c - s * b)
            e = 2.0 * (s * a - q * c)
            f = 2.0 * (q * b - r * a)
            u = a + p * d + (r * f - s * e)
            v = b + p * e + (s * d - q * f)
            w = c + p * f + (q * e - r * d)
            near = (u - x[k]) * (u - x[k]) + (v - y[k]) * (v - y[k]) + (w - z[k]) * (w - z[k])
            far = (u + x[k]) * (u + x[k]) + (v + y[k]) * (v + y[k]) + (w + z[k]) * (w + z[k])
            out[n, k] = near / far


@entry_point
def candidates(values, ranks, counts, wanted, found, places):
    """The numbers of a row among which those of given ranks are, by their leading bits.

    Given
        values  (N,) numbers, none of them NaN, N >= 1
        ranks   (R,) 0 to N - 1
        counts, wanted  (BINS,) memory
    Filled
        found   (N,) numbers that share leading bits with one of the wanted ones, in any order
        places  (R,) the ranks among these
    Returned
        how many numbers are found
    """
    least = most = _key(values[0])
    for k in range(1, len(values)):
        key = _key(values[k])
        least, most = min(least, key), max(most, key)
    shift = 0
    while (most - least) >> shift >= len(counts):
        shift += 1
    counts[:] = 0
    wanted[:] = 0
    for k in range(len(values)):
        counts[(_key(values[k]) - least) >> shift] += 1
    for r in range(len(ranks)):
        bin_, before = 0, 0
        while before + counts[bin_] <= ranks[r]:
            before += counts[bin_]
            bin_ += 1
        wanted[bin_] = 1
    for r in range(len(ranks)):
        bin_, before, left_out = 0, 0, 0
        while before + counts[bin_] <= ranks[r]:
            before += counts[bin_]
            if wanted[bin_] == 0:
                left_out += counts[bin_]
            bin_ += 1
        places[r] = ranks[r] - left_out
    count = 0
    for k in range(len(values)):
        # Written always and kept if wanted: without a branch that is mispredicted.
        found[count] = values[k]
        count += wanted[(_key(values[k]) - least) >> shift]
    return count


@subroutine
def _key(x):
    """A whole number that does not fall as a double grows; differences of two do not overflow."""
    bits = as_bits(x + 0.0)
    return (bits ^ ((bits >> 63) & 0x7FFFFFFFFFFFFFFF)) >> 1
