"""The power of series of one period: spectral window, scan, peaks with aliases in words."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from attitude._compilation.decorators import entry_point
from attitude._support import blocks, validation
from attitude._support.arrays import distinct
from attitude._support.constants import DAY_S, SIDEREAL_DAY_S
from attitude._support.quantity_text import counted
from attitude.errors import AttitudeError
from attitude.photometry import _spectrum

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from attitude._support.annotations import FloatArray, Real
    from attitude.photometry._samples import Samples


# Grid frequencies of the window per 1/span.
_WINDOW_OVERSAMPLING = 4.0
# Power from which a line of the window makes aliases.
_STRONG = 0.15
# Power from which a line of the window makes aliases of harmonics too.
_DOMINANT = 0.5
# Distance of sidelobes from a peak at most, 1/span: a series of one harmonic has its first at 1.43.
_SIDELOBE = 1.5
# Differences of distances, 1/span, up to which relations fit a period equally well.
_EQUAL = 0.1
# Lines of a window that are kept, multiples of them (halves are aliases of the second harmonic),
# ratios of harmonics.
_KEPT = 6
_MULTIPLES = (1, -1, 0.5, -0.5, 2, -2)
_RATIOS = ((1, 2), (2, 1), (1, 3), (3, 1), (2, 3), (3, 2), (1, 4), (4, 1), (3, 4), (4, 3))
_SHARES = {1.0: "", 0.5: "2 x ", 2.0: "1/2 of "}
_NAMES = (
    (0.5 / DAY_S, "1/2 /d"),
    (1.0 / DAY_S, "1 /d"),
    (1.0 / SIDEREAL_DAY_S, "1 /sidereal d"),
    (2.0 / DAY_S, "2 /d"),
)


class WindowLine(NamedTuple):
    """A line of the spectral window: frequency in Hz, power (1 at zero frequency)."""

    frequency: float
    power: float


class Window(NamedTuple):
    """The spectral window of epochs: frequencies (K,), Hz, powers (K,), and the strong lines."""

    frequency: FloatArray
    power: FloatArray
    lines: tuple[WindowLine, ...]


def spectral_window(samples: Samples, most: float) -> Window:
    """The spectral window |sum w e^(2 pi i f t)|^2 / (sum w)^2 up to a frequency, Hz."""
    spacing = 1.0 / (_WINDOW_OVERSAMPLING * max(samples.span, 1e-300))
    count = max(int(most / spacing) + 2, 8)
    weights = samples.weights**2
    transform = _spectrum.sums(samples.t - samples.t.min(), weights[None], spacing, count)[0]
    power = np.asarray(np.abs(transform) ** 2 / np.sum(weights) ** 2, dtype=np.float64)
    frequency: FloatArray = spacing * np.arange(count, dtype=np.float64)
    inner = np.arange(1, count - 1)
    is_peak = (power[inner] >= power[inner - 1]) & (power[inner] >= power[inner + 1])
    at = inner[is_peak & (power[inner] > _STRONG) & (frequency[inner] > 2.0 / samples.span)]
    strongest = at[np.argsort(-power[at], kind="stable")]
    lines = distinct(
        (WindowLine(float(frequency[k]), float(power[k])) for k in strongest),
        lambda one, other: abs(one.frequency - other.frequency) <= 1.5 / samples.span,
        _KEPT,
    )
    return Window(frequency, power, tuple(lines))


def relation(
    frequency: float, better: Sequence[float], lines: Sequence[WindowLine], tolerance: float
) -> str:
    """How a period follows from a better one: "beside #1", "2 x #1", "alias of #1 (+1 /d)"."""
    for rank, other in enumerate(better, 1):
        if abs(frequency - other) < _SIDELOBE * tolerance:
            return f"beside #{rank}"
    expected = []
    for rank, other in enumerate(better, 1):
        for a, b in _RATIOS:
            expected.append((other * a / b, f"{b}/{a} of #{rank}" if a > 1 else f"{b} x #{rank}"))
        for ratio, share in _SHARES.items():
            for line in (line for line in lines if ratio == 1.0 or line.power > _DOMINANT):
                for many in _MULTIPLES:
                    shift = many * line.frequency
                    words = f"alias of {share}#{rank} ({_spelled(shift, tolerance)})"
                    expected.append((abs(other * ratio + shift), words))
    distances = [abs(frequency - other) for other, _ in expected]
    least = min(distances, default=tolerance)
    if least >= tolerance:
        return ""
    # the plainest one of those that are as near as the nearest
    return next(
        words
        for (_, words), distance in zip(expected, distances, strict=True)
        if distance <= least + _EQUAL * tolerance
    )


def _spelled(shift: float, tolerance: float) -> str:
    sign = "+" if shift > 0.0 else "-"
    for size, name in _NAMES:
        if abs(abs(shift) - size) < tolerance:
            return f"{sign}{name}"
    return f"{sign}{abs(shift) * DAY_S:.4g} /d"


# ---- Phase dispersion minimisation, compiled: variances within bins of phase at many frequencies


@entry_point
def dispersions(t, y, weights, frequencies, bins, covers, out):
    """Theta of each frequency into out (K,): the variance within bins over that of all values.

    t, y, weights: (N,); each value lies in `covers` of the bins, which are as many times as wide.
    """
    total = mean = whole = 0.0
    for i in range(y.size):
        total += weights[i]
        mean += weights[i] * y[i]
    mean /= total
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


# ---- The scan over one frequency, by Fourier series of any order or by phase dispersion

# Grid frequencies per 1/(order span).
_OVERSAMPLING = 5.0
# Frequencies at most.
_MOST = 5_000_000
# Shortest period by default, in median distances of successive epochs of a night.
_NYQUIST = 2.0
_PERMUTATIONS = 12
# Numbers of the matrices of one block of frequencies, and products of points and frequencies of one
# call of phase dispersion, some 0.1 s: Python acts on signals, such as that of Ctrl-C, between two.
_NUMBERS = 1 << 18
_POINTS = 5_000_000
# Added to the diagonal of normal equations of weights of sum 1: ten times the errors of `sums`.
_RIDGE = 1e-10


class Scan(NamedTuple):
    """Shares of the variance explained (K,) at frequencies (K,), Hz, and by chance; the window."""

    frequency: FloatArray
    power: FloatArray
    chance: float
    window: Window


def scan(
    data: Samples,
    bounds: tuple[Real | None, Real | None],
    order: int,
    method: str,
    bins: int,
    seed: int,
    progress: Callable[[int, int], None],
) -> Scan:
    """The scan between two periods, s."""
    if len(data.t) < data.linear + 2 * order + 2:
        points = counted(data.linear, "zero point")
        raise _spectrum.too_few(data, f"{points} and {counted(order, 'harmonic')}")
    frequency = _grid(data, *bounds, order)
    y, generator = data.detrended, validation.generator(seed)
    values = np.stack([y, *(y[generator.permutation(len(y))] for _ in range(_PERMUTATIONS))])
    t, weights = data.t - data.t.min(), data.weights**2 / np.sum(data.weights**2)
    if method == "fourier":
        shares_of, number = _by_series, order
        size = _NUMBERS // (2 * order + 1) ** 2
    else:
        shares_of, number = _by_dispersion, validation.count(bins, "bins", 3)
        size = _POINTS // values.size
    power, largest = np.empty_like(frequency), np.full(len(values), -np.inf)

    def work(begin: int, end: int) -> None:
        shares = shares_of(t, weights, values, frequency[begin:end], number)
        power[begin:end] = shares[0]
        np.maximum(largest, shares.max(axis=1), out=largest)

    blocks.in_blocks(work, len(frequency), max(2, size), 1, progress)
    chance = min(1.0, _spectrum.by_chance(largest[1:].tolist()))
    # zero points that are fitted with the series leave fewer values to it
    chance = min(1.0, chance * (len(data.t) - 1) / max(1, len(data.t) - data.linear))
    window = spectral_window(data, max(3.0 / DAY_S, min(frequency[-1], 12.0 / DAY_S)))
    return Scan(frequency, power, chance, window)


def _grid(data: Samples, least: Real | None, most: Real | None, order: int) -> FloatArray:
    span = data.span
    if not span > 0.0:
        raise AttitudeError("all values are of one epoch; give values of two epochs or more.")
    if least is None:
        low = shortest(data, order)
    else:
        low = validation.positive(least, "min_period", unit="s")
    high = span if most is None else validation.positive(most, "max_period", unit="s")
    if not low < high:
        raise AttitudeError(
            f"min_period is {low:.6g} s and max_period {high:.6g} s; give a shorter min_period."
        )
    step = 1.0 / (_OVERSAMPLING * span * order)
    count = int(np.ceil((1.0 / low - 1.0 / high) / step)) + 1
    if count > _MOST:
        raise AttitudeError(
            f"between the periods {low:.6g} s and {high:.6g} s lie {count} frequencies, and at "
            f"most {_MOST} are searched; give a longer min_period, or a shorter span."
        )
    # from one bound to the other, a little denser than the step
    return np.linspace(1.0 / high, 1.0 / low, count)


def shortest(data: Samples, order: int) -> float:
    """The shortest period, s, that is searched by default."""
    steps = np.diff(np.sort(data.t))
    return min(_NYQUIST * float(np.median(steps[steps > 0.0])) * order, 0.25 * data.span)


def _by_series(t, weights, values, frequency, order):
    """Shares (P, K) of the variance of P rows of values that a Fourier series explains.

    The normal matrix of exp(2 pi i m f t), |m| <= order, holds the sums of the weights times those
    of twice the order, and is one for all rows.
    """
    values = values - (values @ weights)[:, None]
    rows = np.concatenate([weights[None], weights * values])
    step = frequency[1] - frequency[0] if len(frequency) > 1 else 0.0
    sums = []
    for m in range(2 * order + 1):
        turned = rows[: None if m <= order else 1] * np.exp(2j * np.pi * m * frequency[0] * t)
        real, imaginary = (
            _spectrum.sums(t, component, m * step, len(frequency))
            for component in (turned.real, turned.imag)
        )
        sums.append(real + 1j * imaginary)
    first = np.array([row[0] for row in sums])
    m = np.arange(2 * order + 1)
    both = np.concatenate([first[:0:-1].conj(), first]).T
    matrix = both[:, 2 * order + m[:, None] - m] + _RIDGE * np.eye(len(m))
    right = np.array([row[1:] for row in sums[: order + 1]])
    right = np.concatenate([right[:0:-1].conj(), right]).transpose(2, 0, 1)
    solution = np.linalg.solve(matrix, right)
    gain = np.einsum("kmp,kmp->pk", right.conj(), solution).real
    return np.clip(gain / (values**2 @ weights)[:, None], 0.0, 1.0)


def _by_dispersion(t, weights, values, frequency, bins):
    """Shares (P, K) of the variance of P rows of values that lie between bins of phase."""
    theta = np.empty((len(values), len(frequency)))
    for row, out in zip(values, theta, strict=True):
        dispersions(t, row, weights, frequency, bins, 2, out)
    return 1.0 - theta


def refined(data: Samples, frequency: float, order: int) -> _spectrum.RefinedSeries:
    """The series of least squares near a frequency."""
    return _spectrum.refined(data, np.array([frequency]), _spectrum.series_numbers(order, 1))


def best_peaks(
    data: Samples, scanned: Scan, order: int, count: int
) -> list[tuple[float, float, float, str]]:
    """Frequency, error, share of chi-squared left and relation of the best refined peaks."""
    frequency, power = scanned.frequency, scanned.power
    closest = 0.7 / (data.span * order)
    rows: list[tuple[float, float, float]] = []
    total = float(np.sum((data.weights * data.detrended) ** 2))
    by_power = (float(frequency[k]) for k in np.argsort(-power, kind="stable"))
    starts = distinct(by_power, lambda one, other: abs(one - other) <= closest, 2 * count)
    numbers = _spectrum.series_numbers(order, 1)
    for peak in _spectrum.least(data, np.array(starts)[:, None], numbers)[0]:
        f = abs(float(peak[0]))
        is_inside = frequency[0] <= f <= frequency[-1]
        if is_inside and all(abs(f - other[0]) > 0.5 * closest for other in rows):
            best = _spectrum.fixed(data, peak, numbers)
            rows.append((f, float(best.errors[0]), best.chi_squared / total))
    if not rows:
        # no maximum within the range: the power rises towards an end
        k = int(np.argmax(power))
        best = _spectrum.fixed(data, frequency[k : k + 1], numbers)
        end = "longest" if 2 * k < len(power) else "shortest"
        left = best.chi_squared / total
        error = float(best.errors[0])
        return [(float(frequency[k]), error, left, f"at the {end} period searched")]
    rows.sort(key=lambda row: row[2])
    frequencies = [row[0] for row in rows]
    return [
        (*row, relation(row[0], frequencies[:k], scanned.window.lines, 1 / data.span))
        for k, row in enumerate(rows[:count])
    ]
