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
from attitude._support.quoting import counted
from attitude.errors import AttitudeError

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from numpy.typing import NDArray

    from attitude._support.annotations import FloatArray, IntArray
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
# With lines at n . f (whole numbers n, frequencies f) the model is linear but in f.  The joint
# matrix of the linear terms and of the derivatives by f gives the step, and at the minimum the
# covariance of f.

# Steps at most.
_STEPS = 25
# Part of the resolution 1/span below which a step is the last.
_LAST = 1e-7
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
        angles = _angles(t, self.start, self.frequencies, self.numbers)
        chosen = np.all(np.delete(self.numbers, which, axis=1) == 0, axis=1).astype(float)
        return np.cos(angles) @ (self.cosines * chosen) + np.sin(angles) @ (self.sines * chosen)


def too_few(samples: Samples, what: str) -> AttitudeError:
    """The error for fewer values than unknowns, in words."""
    values = counted(len(samples.t), "value is", "values are")
    return AttitudeError(f"{values} given for {what}; give more values, or a lower order.")


def refined(
    samples: Samples, frequencies: FloatArray, numbers: IntArray, steps: int = _STEPS
) -> RefinedSeries:
    """The series of least squares near frequencies (D,), with lines numbers (K, D)."""
    numbers = np.asarray(numbers).reshape(len(numbers), -1)
    lines, dimensions = numbers.shape
    parameters = samples.linear + 2 * lines + dimensions
    if len(samples.t) <= parameters:
        raise too_few(samples, counted(parameters, "unknown"))
    start = float(0.5 * (samples.t.min() + samples.t.max()))
    model = _Model(samples, numbers, start, samples.weights)
    f = np.array(frequencies, dtype=float)
    fit = model.fitted(f)
    for _ in range(steps):
        step = model.step(fit)
        step *= min(1.0, 0.3 / max(float(np.abs(step).max()), 1e-300))
        scale = 1.0
        while scale > 0.05:
            tried = f + scale * step * model.unit
            nearer = model.fitted(tried)
            if nearer.chi_squared <= fit.chi_squared:
                break
            scale *= 0.5
        else:
            break
        f, fit = tried, nearer
        if np.abs(scale * step).max() < _LAST:
            break
    joint = model.joint(fit)
    freedom = max(1, len(samples.t) - parameters)
    inverse = least_squares.inverse(joint.T @ joint)[-dimensions:]
    curvature = inverse[:, -dimensions:] * fit.chi_squared / freedom
    scores = np.zeros((samples.group.max() + 1, joint.shape[1]))
    np.add.at(scores, samples.group, joint * fit.residuals[:, None])
    scatter = np.sum((scores @ inverse.T) ** 2, axis=0) * len(scores) / max(1, len(scores) - 1)
    wider = np.sqrt(np.maximum(1.0, scatter / np.maximum(np.diag(curvature), 1e-300)))
    first = samples.linear
    return RefinedSeries(
        frequencies=f,
        covariance=curvature * np.outer(wider, wider) * model.unit**2,
        numbers=numbers,
        offsets=fit.solution[: samples.curves],
        cosines=fit.solution[first : first + lines],
        sines=fit.solution[first + lines :],
        start=start,
        residuals=fit.residuals / samples.weights,
        chi_squared=fit.chi_squared,
        parameters=parameters,
    )


def fixed(samples: Samples, frequencies: FloatArray, numbers: IntArray) -> RefinedSeries:
    """The series at given frequencies; its covariance is that of frequencies that are free."""
    return refined(samples, frequencies, numbers, steps=0)


def bootstrap(samples: Samples, series: RefinedSeries, draws: int, seed: int) -> FloatArray:
    """Frequencies (draws, D) of the series through nights drawn anew, or points of few nights."""
    generator = validation.generator(seed)
    count = int(samples.group.max()) + 1
    out = np.empty((draws, len(series.frequencies)))
    for draw in range(draws):
        often = np.bincount(generator.integers(0, count, count), minlength=count)
        weights = samples.weights * np.sqrt(often[samples.group])
        model = _Model(samples, series.numbers, series.start, weights)
        f = series.frequencies.copy()
        for _ in range(4):
            step = model.step(model.fitted(f))
            f = f + np.clip(step, -0.3, 0.3) * model.unit
        out[draw] = f
    return out


def _angles(t: FloatArray, start: float, frequencies: FloatArray, numbers: IntArray) -> FloatArray:
    """Angles (N, K) of the lines, rad; turns are reduced before they are multiplied by 2 pi."""
    turns = np.multiply.outer(t - start, numbers @ frequencies)
    return 2.0 * np.pi * (turns - np.rint(turns))


def _least_squares(matrix, right):
    """The solution of least norm of scaled normal equations, corrected once by its residuals."""
    scale = np.sqrt(np.einsum("nk,nk->k", matrix, matrix))
    scale[scale == 0.0] = 1.0
    scaled = matrix / scale
    values, vectors = np.linalg.eigh(scaled.T @ scaled)
    inverse = np.where(values > _RANK * values[-1], 1.0 / np.maximum(values, 1e-300), 0.0)
    solution = vectors @ (inverse * (vectors.T @ (scaled.T @ right)))
    residual = right - scaled @ solution
    solution += vectors @ (inverse * (vectors.T @ (scaled.T @ residual)))
    return solution / scale


class _LinearFit(NamedTuple):
    """Weighted matrix, coefficients and weighted residuals of the linear fit."""

    matrix: FloatArray
    solution: FloatArray
    residuals: FloatArray
    chi_squared: float


class _Model(NamedTuple):
    """A series with lines numbers (K, D) about the epoch `start`, fitted with weights (N,)."""

    samples: Samples
    numbers: IntArray
    start: float
    weights: FloatArray

    @property
    def unit(self) -> float:
        """The unit of steps in frequency, 1/span, Hz."""
        return 1.0 / max(self.samples.span, 1e-300)

    def fitted(self, f: FloatArray) -> _LinearFit:
        """The linear fit at frequencies (D,)."""
        angles = _angles(self.samples.t, self.start, f, self.numbers)
        matrix = np.concatenate([self.samples.columns, np.cos(angles), np.sin(angles)], axis=1)
        matrix = matrix * self.weights[:, None]
        right = self.samples.values * self.weights
        solution = _least_squares(matrix, right)
        residuals = right - matrix @ solution
        return _LinearFit(matrix, solution, residuals, float(residuals @ residuals))

    def joint(self, fit: _LinearFit) -> FloatArray:
        """The matrix of all parameters: linear terms, and frequencies in units of 1/span."""
        first, lines = self.samples.linear, len(self.numbers)
        middle = first + lines
        cosines, sines = fit.solution[first:middle], fit.solution[middle:]
        # the weighted cosines and sines are columns of the matrix
        rate = fit.matrix[:, first:middle] * sines - fit.matrix[:, middle:] * cosines
        elapsed = (self.samples.t - self.start)[:, None]
        by_f = 2.0 * np.pi * self.unit * elapsed * (rate @ self.numbers)
        return np.concatenate([fit.matrix, by_f], axis=1)

    def step(self, fit: _LinearFit) -> FloatArray:
        """The step of Gauss and Newton in the frequencies (D,), in units of 1/span."""
        step: FloatArray = _least_squares(self.joint(fit), fit.residuals)
        return step[-self.numbers.shape[1] :]


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
