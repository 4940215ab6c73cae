"""The power of series of one period: spectral window, scan, peaks with aliases in words."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from attitude._compilation import deferral
from attitude._compilation.decorators import entry_point
from attitude._support import blocks, validation
from attitude._support.arrays import distinct
from attitude._support.quoting import counted
from attitude.errors import AttitudeError
from attitude.photometry import _spectrum

if TYPE_CHECKING:
    from collections.abc import Sequence

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
# Lines of a window that are kept, multiples of them, ratios of harmonics.
_KEPT = 6
_MULTIPLES = (1, -1, 2, -2)
_RATIOS = ((1, 2), (2, 1), (1, 3), (3, 1), (2, 3), (3, 2), (1, 4), (4, 1), (3, 4), (4, 3))
_NAMES = ((1.0 / 86400.0, "1 /d"), (1.0 / 86164.1, "1 /sidereal d"), (2.0 / 86400.0, "2 /d"))


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
    """How a frequency follows from a better one: "beside #1", "2 x #1", "alias of #1 (+1 /d)"."""
    for rank, other in enumerate(better, 1):
        if abs(frequency - other) < _SIDELOBE * tolerance:
            return f"beside #{rank}"
    for rank, other in enumerate(better, 1):
        for a, b in _RATIOS:
            if abs(frequency - other * a / b) < tolerance:
                return f"{a}/{b} of #{rank}" if b > 1 else f"{a} x #{rank}"
    for rank, other in enumerate(better, 1):
        for line in lines:
            for many in _MULTIPLES:
                for ratio in (1.0, 0.5, 2.0) if line.power > _DOMINANT else (1.0,):
                    expected = abs(other * ratio + many * line.frequency)
                    if abs(frequency - expected) < tolerance:
                        share = {1.0: "", 0.5: "half of ", 2.0: "twice "}[ratio]
                        shift = _spelled(many * line.frequency, tolerance)
                        return f"alias of {share}#{rank} ({shift})"
    return ""


def _spelled(shift: float, tolerance: float) -> str:
    sign = "+" if shift > 0.0 else "-"
    for size, name in _NAMES:
        if abs(abs(shift) - size) < tolerance:
            return f"{sign}{name}"
    return f"{sign}{abs(shift) * 86400.0:.4g} /d"


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

_DAY = 86400.0
# Grid frequencies per 1/(order span).
_OVERSAMPLING = 5.0
# Frequencies at most.
_MOST = 5_000_000
# Shortest period by default, in median distances of successive epochs of a night.
_NYQUIST = 2.0
_PERMUTATIONS = 12
# Frequencies of one call of nifty-ls, some 0.05 s: Python acts on signals, such as that of Ctrl-C,
# between two calls.  More frequencies also take longer each, beyond the caches.
_FREQUENCIES = 1 << 15
# Products of points and frequencies of one call of phase dispersion, as long.
_POINTS = 5_000_000


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
    engine: str,
    seed: int,
) -> Scan:
    """The scan between two periods, s."""
    if len(data.t) < data.linear + 2 * order + 2:
        points = counted(data.linear, "zero point")
        raise _spectrum.too_few(data, f"{points} and {counted(order, 'harmonic')}")
    frequency = _grid(data, *bounds, order)
    if method == "fourier":
        power_of = partial(_fourier, data, frequency, order, engine)
    else:
        power_of = partial(_dispersion, data, frequency, validation.count(bins, "bins", 3))
    power, chance = power_of(data.detrended), _chance(data.detrended, power_of, seed)
    # zero points that are fitted with the series leave fewer values to it
    chance = min(1.0, chance * (len(data.t) - 1) / max(1, len(data.t) - data.linear))
    window = spectral_window(data, max(3.0 / _DAY, min(frequency[-1], 12.0 / _DAY)))
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
            f"between the periods lie {count} frequencies, and at most {_MOST} are searched; give "
            "a longer min_period, or a shorter span."
        )
    # from one bound to the other, a little denser than the step
    return np.linspace(1.0 / high, 1.0 / low, count)


def shortest(data: Samples, order: int) -> float:
    """The shortest period, s, that is searched by default."""
    steps = np.diff(np.sort(data.t))
    return min(_NYQUIST * float(np.median(steps[steps > 0.0])) * order, 0.25 * data.span)


def _fourier(data, frequency, order, engine, y):
    """The share of the variance explained, by astropy's LombScargle."""
    from astropy.timeseries import LombScargle

    series = LombScargle(data.t - data.t.min(), y, data.errors, nterms=order)
    power = np.empty_like(frequency)

    def computed(begin: int, end: int, method: str = "fastnifty_chi2") -> None:
        block = slice(begin, end)
        power[block] = series.power(frequency[block], method=method, assume_regular_frequency=True)

    if _has_nifty(engine):
        # finufft swallows an exception that comes while it hands over arguments or deletes a plan.
        def undisturbed(begin: int, end: int) -> None:
            with deferral.interrupts_held():
                computed(begin, end)

        count = -(-len(frequency) // _FREQUENCIES)  # of equal length: none has one frequency alone
        blocks.in_blocks(undisturbed, len(frequency), -(-len(frequency) // count), 1)
    else:
        computed(0, len(frequency), "fastchi2" if len(frequency) > 200 else "chi2")
    return np.clip(power, 0.0, 1.0)


def _has_nifty(engine: str) -> bool:
    """Whether nifty-ls computes; AttitudeError if it is wanted and cannot.

    nifty-ls is imported also where finufft, with which it computes, cannot be.
    """
    validation.one_of(engine, "engine", ("auto", "astropy", "nifty-ls"))
    if engine == "astropy":
        return False
    reason = ""
    try:
        from nifty_ls.core import AVAILABLE_BACKENDS  # it registers itself with astropy
    except ImportError:
        reason = "nifty-ls is not installed; install it"
    else:
        if not {"finufft_chi2", "cufinufft_chi2"} & set(AVAILABLE_BACKENDS):
            reason = "finufft, with which nifty-ls computes, cannot be imported here"
    if reason and engine == "nifty-ls":
        raise AttitudeError(f'{reason}, or give engine="astropy".')
    return not reason


def _dispersion(data: Samples, frequency: FloatArray, bins: int, y: FloatArray) -> FloatArray:
    theta = np.empty_like(frequency)
    start = np.ascontiguousarray(data.t - data.t.min())
    values, weights = np.ascontiguousarray(y), data.weights**2

    def work(begin: int, end: int) -> None:
        block = slice(begin, end)
        dispersions(start, values, weights, frequency[block], bins, 2, theta[block])

    blocks.in_blocks(work, len(theta), max(1, _POINTS // len(start)), 1)
    return 1.0 - theta


def _chance(y, power_of, seed):
    """The power that 1 of 100 light curves of permuted values y (N,) exceeds."""
    generator = validation.generator(seed)
    largest = [power_of(y[generator.permutation(len(y))]).max() for _ in range(_PERMUTATIONS)]
    return min(1.0, _spectrum.by_chance(largest))


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
    for start in distinct(by_power, lambda one, other: abs(one - other) <= closest, 2 * count):
        best = refined(data, start, order)
        f = abs(float(best.frequencies[0]))
        is_inside = frequency[0] <= f <= frequency[-1]
        if is_inside and all(abs(f - other[0]) > 0.5 * closest for other in rows):
            rows.append((f, float(best.errors[0]), best.chi_squared / total))
    if not rows:
        # no maximum within the range: the power rises towards an end
        f = float(frequency[np.argmax(power)])
        best = _spectrum.fixed(data, np.array([f]), _spectrum.series_numbers(order, 1))
        rows.append((f, float(best.errors[0]), best.chi_squared / total))
    rows.sort(key=lambda row: row[2])
    frequencies = [row[0] for row in rows]
    return [
        (*row, relation(row[0], frequencies[:k], scanned.window.lines, 1 / data.span))
        for k, row in enumerate(rows[:count])
    ]
