"""Sums of exponentials over uneven epochs, and Fourier series in pairs of frequencies.

`sums` gives those of exp(2 pi i nu t) at equally spaced frequencies nu by a gridded transform.
Each epoch is spread over twelve points of an oversampled grid by the kernel exp(b sqrt(1 - z^2)) of
Barnett, Magland & af Klinteberg (SIAM J. Sci. Comput. 41, C479, 2019), the grid transformed by an
FFT, and the transform divided by that of the kernel: 1e-10 of the sum of the weights.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from attitude._compilation.decorators import entry_point, reduction_subroutine, subroutine
from attitude._support import blocks as support_blocks
from attitude._support import least_squares, validation
from attitude._support.quantity_text import counted
from attitude.errors import AttitudeError

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from numpy.typing import NDArray

    from attitude._support.annotations import BoolArray, FloatArray, IntArray
    from attitude.photometry._samples import Samples


# Points of the grid over which an epoch is spread.
_WIDTH = 12
# Points of the grid over those that the highest frequency needs.
_OVER = 2.0
# b of the kernel, for this width and grid.
_SHAPE = 2.30 * _WIDTH


def sums(t: FloatArray, weights: FloatArray, spacing: float, count: int) -> NDArray[np.complex128]:
    """Sums over epochs t (N,) of weights (W, N) times exp(2 pi i k spacing t), k < count."""
    size = _smooth(int(_OVER * 2 * count) + 2 * _WIDTH)
    place = np.mod(t * spacing, 1.0) * size
    grid = np.zeros((len(weights), size))
    _spread(place, np.ascontiguousarray(weights), grid)
    transform: NDArray[np.complex128] = np.fft.rfft(grid)[:, :count].conj()
    transform /= _of_kernel(size, count)
    return transform


@lru_cache(maxsize=4)
def _of_kernel(size: int, count: int) -> FloatArray:
    """The transform (count,) of the kernel; sums of equal size share it."""
    nodes, by = np.polynomial.legendre.leggauss(64)
    z = 0.5 * _WIDTH * nodes
    kernel = 0.5 * _WIDTH * by * np.exp(_SHAPE * (np.sqrt(1.0 - nodes**2) - 1.0))
    k = np.arange(count)
    transform: FloatArray = np.cos(2.0 * math.pi / size * k[:, None] * z) @ kernel
    return transform


def _smooth(least: int) -> int:
    """The least number from `least` on with factors 2, 3 and 5 alone, whose FFT is fast."""
    odd = (3**b * 5**c for b in range(20) for c in range(14))
    return min(factor << max(0, -(-least // factor) - 1).bit_length() for factor in odd)


@entry_point
def _spread(place, weights, grid):
    size = grid.shape[1]
    for i in range(place.size):
        first = math.ceil(place[i] - 0.5 * _WIDTH)
        for j in range(_WIDTH):
            z = (first + j - place[i]) * (2.0 / _WIDTH)
            value = math.exp(_SHAPE * (math.sqrt(max(0.0, 1.0 - z * z)) - 1.0))
            at = (first + j) % size
            for row in range(weights.shape[0]):
                grid[row, at] += value * weights[row, i]


# ---- Fourier series in pairs of frequencies: closed normal equations from two tables, compiled
# With W(nu) = sum w e^(2 pi i nu t) and Y(nu) = sum w y e^(2 pi i nu t) on an equally spaced grid,
# every entry of the normal equations of every pair of grid frequencies is one of W or one of Y, so
# that the cost of a pair does not depend on the number of points.  Sixteen pairs are solved side by
# side, which fills vector registers.

_SIDE = 16
# Products of the factorisations of one compiled call, some 0.03 s: Python acts on signals, such as
# that of Ctrl-C, between two calls.
_PRODUCTS = 5e7


def line_numbers(orders: tuple[int, int]) -> list[tuple[int, int]]:
    """All (i, j) except (0, 0), one of (i, j) and (-i, -j); orders of j and of i."""
    of_psi, of_phi = orders
    multiples = [(0, j) for j in range(1, of_psi + 1)]
    return multiples + [(i, j) for i in range(1, of_phi + 1) for j in range(-of_psi, of_psi + 1)]


def harmonics(order: int) -> IntArray:
    """Numbers (L, 2) of the lines of a series with |i|, |j| <= order: (0, 0) and `line_numbers`."""
    return np.array([(0, 0), *line_numbers((order, order))])


def series_numbers(order: int, count: int) -> IntArray:
    """Lines (K, D) of one frequency, or of two: j of the first and i of the second."""
    return np.arange(1, order + 1)[:, None] if count == 1 else harmonics(order)[1:, ::-1]


def decreases(transforms: Tables, first: IntArray, second: IntArray, lines: IntArray) -> FloatArray:
    """Decrease of chi-squared (P,) by the series of each pair of grid numbers (P,)."""
    wr, wi, yr, yi, _ = transforms
    out = np.empty(len(first))
    unknown = 2 * len(lines) - 1
    size = _SIDE * max(1, int(_PRODUCTS / (_SIDE * unknown**3 / 6.0)))

    def work(begin: int, end: int) -> None:
        block = slice(begin, end)
        _decreases(wr, wi, yr, yi, first[block], second[block], lines, RIDGE, out[block])

    support_blocks.in_blocks(work, len(first), size, 1)
    return out


@entry_point
def _decreases(wr, wi, yr, yi, first, second, lines, ridge, out):
    terms = lines.shape[0]
    unknown = 2 * terms - 1
    g, b = np.empty((unknown, unknown, _SIDE)), np.empty((unknown, _SIDE))
    at = np.empty(terms, np.int64)
    for start in range(0, first.size, _SIDE):
        for lane in range(_SIDE):
            pair = min(start + lane, first.size - 1)
            for m in range(terms):
                at[m] = lines[m, 0] * first[pair] + lines[m, 1] * second[pair]
            _fill(wr, wi, yr, yi, at, lane, ridge, g, b)
        _solve(g, b)
        for lane in range(min(_SIDE, first.size - start)):
            total = 0.0
            for i in range(unknown):
                total += b[i, lane] * b[i, lane]
            out[start + lane] = total


@subroutine
def _fill(wr, wi, yr, yi, at, lane, ridge, g, b):
    """Normal matrix (lower triangle) and right side of one pair, in column `lane`."""
    for m in range(at.size):
        place = at[m]
        size = abs(place)
        sign = -1.0 if place < 0 else 1.0
        if m == 0:
            b[0, lane], g[0, 0, lane] = yr[0], wr[0]
            continue
        c, s = 2 * m - 1, 2 * m
        b[c, lane], b[s, lane] = yr[size], sign * yi[size]
        g[c, 0, lane], g[s, 0, lane] = wr[size], sign * wi[size]
        for other in range(1, m + 1):
            less, more = place - at[other], place + at[other]
            d, p = abs(less), abs(more)
            dr, di, pr, pi = wr[d], wi[d], wr[p], wi[p]
            di = -di if less < 0 else di
            pi = -pi if more < 0 else pi
            x, y = 2 * other - 1, 2 * other
            g[c, x, lane], g[s, y, lane] = 0.5 * (pr + dr), 0.5 * (dr - pr)
            g[s, x, lane], g[c, y, lane] = 0.5 * (pi + di), 0.5 * (pi - di)
        g[s, c, lane] = 0.5 * pi
        g[c, c, lane] += ridge
        g[s, s, lane] += ridge


@reduction_subroutine
def _solve(g, b):
    """Replace b by L^-1 b, for the Cholesky factors L of g (unknown, unknown, 16)."""
    row = np.empty(_SIDE)
    for i in range(g.shape[0]):
        for j in range(i + 1):
            for lane in range(_SIDE):
                row[lane] = g[i, j, lane]
            for k in range(j):
                for lane in range(_SIDE):
                    row[lane] -= g[i, k, lane] * g[j, k, lane]
            if i == j:
                for lane in range(_SIDE):
                    g[i, i, lane] = 1.0 / math.sqrt(max(row[lane], 1e-12))
            else:
                for lane in range(_SIDE):
                    g[i, j, lane] = row[lane] * g[j, j, lane]
        for lane in range(_SIDE):
            row[lane] = b[i, lane]
        for k in range(i):
            for lane in range(_SIDE):
                row[lane] -= g[i, k, lane] * b[k, lane]
        for lane in range(_SIDE):
            b[i, lane] = row[lane] * g[i, i, lane]


# ---- All pairs of frequencies of two grids, fitted by closed normal equations; the best of them
# The cost of a pair does not depend on the number of samples.  Where there are more pairs than
# `MOST`, all are ranked first by the sum of the powers of their lines, cross terms left out, and
# the best `MOST` are fitted.

# Grid frequencies per 1/span, and inverse variance, 1/mag2, of the amplitudes of lines before the
# fit.
OVERSAMPLING: float = 3.0
RIDGE: float = 1.0
# Pairs fitted at most.
MOST: int = 8_000_000
# Pairs of a block.
_BLOCK = 1 << 19
# Pairs of a block that are kept.
_KEPT = 20_000
# Cells of a map of chi-squared along each axis.
_CELLS = 240
# Grid numbers by which the frequencies of a pair differ at least.
_APART = 2


class Tables(NamedTuple):
    """The transforms of weights and of weighted values, real and imaginary parts."""

    wr: FloatArray
    wi: FloatArray
    yr: FloatArray
    yi: FloatArray
    total: float


class BestPairs(NamedTuple):
    """The best pairs of numbers on the grid (P,), and the share of chi-squared left (P,).

    map (C, C): the least share left in each cell of the plane, NaN without pairs, between edges (C
    + 1,).
    """

    first: IntArray
    second: IntArray
    left: FloatArray
    map: FloatArray
    edges: tuple[FloatArray, FloatArray]
    tried: int


def tables(t: FloatArray, weights: FloatArray, y: FloatArray, spacing: float, count: int) -> Tables:
    """The tables of `_decreases` at `count` multiples of a spacing; t, weights, y (N,)."""
    both = sums(t, np.stack([weights, weights * y]), spacing, count)
    parts = (np.ascontiguousarray(values) for row in both for values in (row.real, row.imag))
    wr, wi, yr, yi = parts
    return Tables(wr, wi, yr, yi, float(weights @ y**2))


def best(
    transforms: Tables,
    first: tuple[int, int],
    second: tuple[int, int],
    lines: IntArray,
    keep: int,
    progress: Callable[[int, int], None] | None = None,
    fitted: int | None = None,
) -> BestPairs:
    """The best pairs a < b, a number of either range each, no two of them neighbours.

    At most `fitted` pairs are fitted, by default `MOST`.
    """
    blocks, tried = _blocks(first, second)
    least = _threshold(transforms, blocks, lines, (MOST if fitted is None else fitted) / tried)
    edges = tuple(
        np.linspace(a, b, min(_CELLS, b - a) + 1).astype(float) for a, b in (first, second)
    )
    cells = np.full([len(edge) - 1 for edge in edges], -np.inf)
    kept: list[tuple[IntArray, IntArray, FloatArray]] = []
    done = 0
    for rows in blocks:
        a, b = _pairs(rows, second)
        done += a.size
        if least > -np.inf:
            chosen = _powers(transforms, a, b, lines) >= least
            a, b = a[chosen], b[chosen]
        if a.size:
            gain = decreases(transforms, a, b, lines)
            _enter(cells, edges, a, b, gain)
            top = np.sort(np.argsort(-gain, kind="stable")[:_KEPT])
            kept.append((a[top], b[top], gain[top]))
        if progress is not None:
            progress(done, tried)
    a, b, gain = (np.concatenate(column) for column in zip(*kept, strict=True))
    chosen = _peaks(a, b, gain, keep)
    return BestPairs(
        first=a[chosen],
        second=b[chosen],
        left=1.0 - gain[chosen] / transforms.total,
        map=np.where(np.isfinite(cells), 1.0 - cells / transforms.total, np.nan),
        edges=(edges[0], edges[1]),
        tried=tried,
    )


def _blocks(first: tuple[int, int], second: tuple[int, int]) -> tuple[list[IntArray], int]:
    """Numbers of the first grid in parts whose pairs fill a block; the number of all pairs."""
    rows = np.arange(*first)
    widths = np.maximum(second[1] - np.maximum(rows + _APART, second[0]), 0)
    rows, widths = rows[widths > 0], widths[widths > 0]
    ends = np.cumsum(widths)
    cuts = np.searchsorted(ends, np.arange(_BLOCK, ends[-1] + _BLOCK, _BLOCK), side="right")
    return [block for block in np.split(rows, np.unique(cuts)) if block.size], int(ends[-1])


def _pairs(rows: IntArray, second: tuple[int, int]) -> tuple[IntArray, IntArray]:
    starts = np.maximum(rows + _APART, second[0])
    widths = second[1] - starts
    a = np.repeat(rows, widths)
    return a, np.arange(a.size) + np.repeat(starts - (np.cumsum(widths) - widths), widths)


def _powers(transforms: Tables, a: IntArray, b: IntArray, lines: IntArray) -> FloatArray:
    """The sum of the powers of the lines of pairs."""
    power = transforms.yr**2 + transforms.yi**2
    powers = np.zeros(a.size)
    for i, j in lines[1:]:
        powers += power[np.abs(i * a + j * b)]
    return powers


def _threshold(transforms: Tables, blocks: list[IntArray], lines: IntArray, share: float) -> float:
    """The power from which a pair is fitted, so that about a share is; from a sample of pairs."""
    if share >= 1.0:
        return -np.inf
    generator = np.random.default_rng(0)
    top = int(blocks[-1][-1]) + 1
    low = int(blocks[0][0])
    both = np.sort(generator.integers(low, max(top, low + 2), (200_000, 2)), axis=1)
    both = both[both[:, 0] < both[:, 1]]
    powers = _powers(transforms, both[:, 0], both[:, 1], lines)
    return float(np.quantile(powers, 1.0 - share))


def _enter(cells, edges, a, b, gain):
    """Enter the greatest gain into each cell of a map."""
    place = []
    for frequencies, grid in ((a, edges[0]), (b, edges[1])):
        width = grid[1] - grid[0]
        place.append(np.clip(((frequencies - grid[0]) / width).astype(np.int64), 0, len(grid) - 2))
    np.maximum.at(cells, tuple(place), gain)


def _peaks(first, second, gain, keep):
    """Numbers of the best pairs, no two of them neighbours on the grid."""
    used = set()
    chosen = []
    for p in np.argsort(-gain, kind="stable"):
        a, b = int(first[p]), int(second[p])
        if (a, b) not in used:
            used.update((a + i, b + j) for i in range(-2, 3) for j in range(-2, 3))
            chosen.append(p)
            if len(chosen) >= keep:
                break
    return np.array(chosen)


# ---- Fourier series in one or more frequencies, refined in all parameters
# With lines at n . f (whole numbers n, frequencies f) the model is linear but in f.  Slopes by f,
# less what linear terms make up of them, give the step, and at the minimum the covariance of f.

# Steps at most.
_STEPS = 25
# Steps of each draw of a bootstrap, which begin at the least squares of all values.
_DRAWN = 4
# Damping only after steps that fail: the next but one is half as long.  A decrease by 1e-13 of
# chi-squared is that of a step of 1e-5 standard errors of 1000 values.
_RULE = least_squares.Rule(start=1e-12, least=1e-12, stuck=1e7, larger=1e6, gain=1e-13, settled=1)
# The longest step, turns per span.
_LONGEST = 0.3
# Eigenvalues of scaled normal equations below this part of the greatest belong to lines that the
# span does not resolve.
_RANK = 1e-11


@dataclass(frozen=True, eq=False)
class RefinedSeries:
    """A series at the least squares of all its parameters.

    Frequencies (D,), Hz, with a covariance by the curvature and the mean square of the residuals,
    or where it is wider by their scatter between nights (Cameron & Miller, Journal of Human
    Resources 50, 317, 2015; `Samples.group`); lines numbers (K, D) . f with
    cosines and sines (K,) of 2 pi n . f (t - start); offsets (C,) of the curves.
    """

    frequencies: FloatArray
    covariance: FloatArray
    numbers: IntArray
    offsets: FloatArray
    cosines: FloatArray
    sines: FloatArray
    start: float
    residuals: FloatArray
    chi_squared: float
    parameters: int

    @property
    def errors(self) -> FloatArray:
        """Standard errors (D,) of the frequencies, Hz."""
        return np.sqrt(np.maximum(np.diag(self.covariance), 0.0))

    @property
    def amplitudes(self) -> FloatArray:
        """(K,) half of the peak-to-peak value of each line."""
        return np.hypot(self.cosines, self.sines)

    @property
    def rms(self) -> float:
        """Root of the mean square of the residuals, in the unit of the values."""
        return float(np.sqrt(np.mean(self.residuals**2)))

    def wave(self, t: FloatArray, which: int) -> FloatArray:
        """The sum of the lines of one frequency alone at seconds t, without zero points."""
        angles = line_angles(t, self.start, self.frequencies, self.numbers)
        chosen = np.all(np.delete(self.numbers, which, axis=1) == 0, axis=1).astype(float)
        return np.cos(angles) @ (self.cosines * chosen) + np.sin(angles) @ (self.sines * chosen)


def too_few(samples: Samples, what: str) -> AttitudeError:
    """The error for fewer values than unknowns, in words."""
    values = counted(len(samples.t), "value is", "values are")
    return AttitudeError(f"{values} given for {what}; give more values, or a lower order.")


def fixed(samples: Samples, frequencies: FloatArray, numbers: IntArray) -> RefinedSeries:
    """The series at given frequencies; its covariance is that of frequencies that are free."""
    lines, dimensions = numbers.shape
    parameters = _parameters(samples, numbers)
    fit = series_at(samples, frequencies, numbers, samples.weights)
    inverse = least_squares.inverse(fit.slopes.T @ fit.slopes)
    curvature = inverse * fit.chi_squared / max(1, len(samples.t) - parameters)
    scores = np.zeros((samples.group.max() + 1, dimensions))
    np.add.at(scores, samples.group, fit.slopes * fit.residuals[:, None])
    scatter = np.sum((scores @ inverse) ** 2, axis=0) * len(scores) / max(1, len(scores) - 1)
    wider = np.sqrt(np.maximum(1.0, scatter / np.maximum(np.diag(curvature), 1e-300)))
    first = samples.linear
    return RefinedSeries(
        frequencies=frequencies,
        covariance=curvature * np.outer(wider, wider),
        numbers=numbers,
        offsets=fit.solution[: samples.curves],
        cosines=fit.solution[first : first + lines],
        sines=fit.solution[first + lines :],
        start=samples.middle,
        residuals=fit.residuals / samples.weights,
        chi_squared=fit.chi_squared,
        parameters=parameters,
    )


def refined(samples: Samples, frequencies: FloatArray, numbers: IntArray) -> RefinedSeries:
    """The series of least squares near frequencies (D,), with lines numbers (K, D)."""
    _parameters(samples, numbers)
    minima, _ = least(samples, frequencies[None], numbers)
    return fixed(samples, minima[0], numbers)


def least(
    samples: Samples,
    starts: FloatArray,
    numbers: IntArray,
    steps: int = _STEPS,
    often: IntArray | None = None,
) -> tuple[FloatArray, FloatArray]:
    """Frequencies (S, D) of least squares near starts (S, D), and shares of chi-squared left (S,).

    often: (S, G), how many times the groups of values count for each start, by default once.
    """
    total = float(np.sum((samples.weights * samples.detrended) ** 2))
    weights = samples.weights / math.sqrt(max(total, 1e-200))

    def linearised(states: FloatArray) -> least_squares.Near:
        columns = []
        for row in states:
            times = 1.0 if often is None else np.sqrt(often[int(row[-1]), samples.group])
            fit = series_at(samples, row[:-1], numbers, weights * times)
            normal, gradient = fit.slopes.T @ fit.slopes, fit.slopes.T @ fit.residuals
            columns.append((fit.chi_squared, normal, gradient))
        return least_squares.Near(states, *map(np.array, zip(*columns, strict=True)))

    def moved(states: FloatArray, steps: FloatArray) -> tuple[FloatArray, BoolArray]:
        longest = np.abs(steps).max(axis=1, keepdims=True) * max(samples.span, 1e-300)
        new = states.copy()
        new[:, :-1] += steps * np.minimum(1.0, _LONGEST / np.maximum(longest, 1e-300))
        return new, np.ones(len(states), bool)

    # the last column is the row of `often`
    states = np.column_stack([starts, np.arange(len(starts))])
    problem = least_squares.Problem(linearised, moved)
    best = least_squares.minimum(problem, states, _RULE, steps + 1)
    return best.states[:, :-1], best.cost


def bootstrap(samples: Samples, series: RefinedSeries, draws: int, seed: int) -> FloatArray:
    """Frequencies (draws, D) of the series through nights drawn anew, or points of few nights."""
    generator = validation.generator(seed)
    count = int(samples.group.max()) + 1
    chosen = [generator.integers(0, count, count) for _ in range(draws)]
    often = np.array([np.bincount(groups, minlength=count) for groups in chosen])
    starts = np.tile(series.frequencies, (draws, 1))
    return least(samples, starts, series.numbers, _DRAWN, often)[0]


def _parameters(samples: Samples, numbers: IntArray) -> int:
    """The number of unknowns of a series; AttitudeError for no more values than these."""
    parameters = samples.linear + 2 * len(numbers) + numbers.shape[1]
    if len(samples.t) <= parameters:
        raise too_few(samples, counted(parameters, "unknown"))
    return parameters


def line_angles(
    t: FloatArray, start: float, frequencies: FloatArray, numbers: IntArray
) -> FloatArray:
    """Angles (N, K) of the lines, rad; turns are reduced before they are multiplied by 2 pi."""
    turns = np.multiply.outer(t - start, numbers @ frequencies)
    return 2.0 * np.pi * (turns - np.rint(turns))


class SeriesAt(NamedTuple):
    """The linear fit at frequencies: coefficients, and weighted residuals (N,).

    slopes (N, D): of the weighted model by the frequencies, s, less what linear terms make up.
    rank: of these terms.
    """

    solution: FloatArray
    residuals: FloatArray
    chi_squared: float
    slopes: FloatArray
    rank: int


def series_at(
    samples: Samples, frequencies: FloatArray, numbers: IntArray, weights: FloatArray
) -> SeriesAt:
    """The linear fit with lines numbers (K, D) at frequencies (D,), by weights (N,)."""
    angles = line_angles(samples.t, samples.middle, frequencies, numbers)
    matrix = np.concatenate([samples.columns, np.cos(angles), np.sin(angles)], axis=1)
    matrix *= weights[:, None]
    right = samples.values * weights
    normal = least_squares.Decomposed(matrix.T @ matrix)
    factor = normal.inverse_factor(_RANK * normal.values[-1])
    solution = factor @ (factor.T @ (matrix.T @ right))
    # once more, for what rounding leaves
    solution += factor @ (factor.T @ (matrix.T @ (right - matrix @ solution)))
    residuals = right - matrix @ solution
    first, middle = samples.linear, samples.linear + len(numbers)
    # the weighted cosines and sines are columns of the matrix
    by_angle = matrix[:, first:middle] * solution[middle:]
    by_angle -= matrix[:, middle:] * solution[first:middle]
    slopes = 2.0 * np.pi * (samples.t - samples.middle)[:, None] * (by_angle @ numbers)
    slopes -= matrix @ (factor @ (factor.T @ (matrix.T @ slopes)))
    return SeriesAt(solution, residuals, float(residuals @ residuals), slopes, factor.shape[1])


# ---- What pairs of frequencies mean: chance among permuted values, and aliases of one cycle a day

# Pairs that a permutation of the values is fitted with.
_PERMUTED = 20_000
# Permutations.
_TIMES = 10
# Lines from which fewer pairs are fitted: those of two frequencies of order 3 are 25.
_MANY = 20
_EULER = 0.5772


def by_chance(largest: Sequence[float], times: float = 1.0) -> float:
    """What the largest of `times` as many values exceeds in 1 of 100 cases, as Gumbel's law has it.

    largest: those of several samples of values.
    """
    scale = max(float(np.std(largest)) * np.sqrt(6.0) / np.pi, 1e-6)
    place = float(np.mean(largest)) - _EULER * scale + scale * np.log(times)
    return float(place - scale * np.log(-np.log(0.99)))


def share_of_chance(
    t: FloatArray, weights: FloatArray, y: FloatArray, turns: float, lines: IntArray, seed: int
) -> float:
    """The share of chi-squared left that 1 of 100 light curves of permuted values reaches.

    From the largest decrease among some pairs, extended to all.
    """
    generator = validation.generator(seed)
    count = int(turns * OVERSAMPLING) + 1
    all_pairs = max(count * (count - 1) // 2, 1)
    tried = min(all_pairs, _PERMUTED if len(lines) < _MANY else _PERMUTED // 10)
    pair = generator.integers(2, count, (2, tried))
    size = 2 * int(np.abs(lines).sum(axis=1).max()) * (count + 1) + 2
    best = []
    for _ in range(_TIMES):
        mixed = y[generator.permutation(len(y))]
        transforms = tables(t, weights, mixed, 1.0 / OVERSAMPLING, size)
        gain = decreases(transforms, pair[0], pair[1], lines)
        best.append(float(gain.max() / transforms.total))
    return max(0.0, 1.0 - by_chance(best, all_pairs / tried))
