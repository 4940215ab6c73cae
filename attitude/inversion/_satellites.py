"""Rotation about one axis beside an additive series in a second period: bodies with a moon.

Eclipses and occultations by a moon add dips at the period of its orbit to the magnitudes of a
rotating body.  A tumbling body has lines at sums and differences of two frequencies; here there are
none, only multiples of each.  Orbits are found by two series (`additive_pairs`), and beside a body
that rotates about one axis, less all that bodies near it make up for (`orbits_beside`).  The rival
of a tumbling state is then such a body with the series in the orbit among the linear terms.
"""

from __future__ import annotations

import itertools
import math
from functools import cache
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from attitude._support import least_squares
from attitude._support.arrays import distinct
from attitude._support.least_squares import Near
from attitude.inversion import _evidence, _lattices, _refinement
from attitude.inversion._ellipsoid import SearchState
from attitude.photometry import _spectrum

if TYPE_CHECKING:
    from collections.abc import Callable

    from attitude._support.annotations import BoolArray, FloatArray
    from attitude.inversion._problem import CurveProblem
    from attitude.inversion._refinement import BodyFit
    from attitude.inversion._shapes import Tie


# Lines of the rotation and of the orbit in the scan.
_SCANNED = (4, 6)
# The same in the fits of its best pairs: rotation is smooth, dips are narrow, and two of unlike
# depth an orbit leave half the period behind.
ORDERS = (6, 16)
# Lines of the orbit beside a body: narrow dips have them, and fits of pairs with so many take twice
# the period for it.
DIPS = 24
# Frequencies of the orbit per 1/span: its sixth harmonic is resolved.
_FINE = 12
# Strong lines whose orbits are scanned.
_ROTATIONS = 12
# Rates of bodies over that of a series: one of six lines of it is the body's second.
RATIOS = (0.5, 1.0, 1.5, 2.0, 3.0)
# Distance of frequencies, turns per span, at which two orbits are one.
_CLOSE = 0.5
# Distance of rates of bodies that are two.
_APART = 0.3
# Ratios of two numbers up to this are those of one comb, whose lines are a shape's.
_COMB = 4
# Orbits that are compared with one whose series fits, over its frequency.
_FACTORS = (0.5, 1.0, 2.0, 3.0, 4.0)
# Frequencies about each, turns per span: 16 lines are resolved, and those of an orbit's third were
# up to 0.2 off.
_SHIFTS = tuple(0.04 * k for k in range(-6, 7))
# Frequencies about the best of these, beside a body.
_FINER = tuple(0.01 * k for k in range(-3, 4))
# Steps of the fit of both frequencies.
_STEPS = 4
# The step after one that fails is half as long.
_RULE = least_squares.Rule(start=1e-3, least=1e-9, stuck=1e6, larger=1e3, gain=0.0, settled=_STEPS)
# The longest step, turns per span.
_LONGEST = 0.1
# Skewness of dips at least (binaries: 1.2 to 2.1): half of a pair of equal bodies is 0.75, and
# noise adds to it.
_LEAST_SKEWNESS = 0.6
# Orbits in the span at least.
_LEAST_ORBITS = 4.0
# Range of dips at most, mag.
_DEEPEST = 1.2
# Epochs of an orbit at which its series is evaluated.
_PHASES = 360
# How much a series brightens at most, over how much it dims: moons 0.1 to 0.2, series that mimic
# tumbling 0.4 to 1.4.
_BRIGHTEST = 0.35
# Orbits by which the second dip is off the half at most: an orbit is not always a circle.
_OFF_HALF = 0.06
# Standard deviations, mag, of the amplitudes of a series beside a body before the curve is seen.
# Of these and the next the likeliest are taken, the first in fits of pairs.
_AMPLITUDES = (0.1, 0.05, 0.025, 0.0125)
# The same of their changes in half the span, over that.
_CHANGES = (1.0, 0.5, 0.25, 0.125)
# Multiples of the frequency that have half of it.
_WIDE = (math.inf, 16.0, 8.0, 4.0)


class AdditivePair(NamedTuple):
    """Frequencies of rotation and orbit, turns per span, and the share of chi-squared left.

    range, mag, and skewness are those of the series in the orbit; second, mag: the depth of the dip
    half a period after the deepest one; brightens: how much it brightens over how much it dims.
    """

    rotation: float
    orbit: float
    left: float
    range: float = 0.0
    skewness: float = 0.0
    second: float = 0.0
    brightens: float = 0.0

    @property
    def only_dims(self) -> bool:
        """Whether the series brightens by no more than those of moons do."""
        return self.brightens < _BRIGHTEST

    @property
    def are_dips(self) -> bool:
        """Whether the series in the orbit looks like eclipses: short, faint, seen several times.

        Series that mimic tumbling are skewed to either side, reach many magnitudes, or last for
        most of the span.
        """
        is_short = self.skewness > _LEAST_SKEWNESS and self.orbit > _LEAST_ORBITS
        return is_short and self.range < _DEEPEST


class Explained(NamedTuple):
    """What a rotation alone explains of the magnitudes of a problem.

    problem: its weights are those of the rows.
    rate: turns per span.
    rows: (K, N), combinations whose squares are what the rotation takes up of weighted magnitudes.
    left: (N,), the weighted magnitudes that it leaves.
    points: their number less that of its free parameters.
    total: the sum of squares of all.
    """

    problem: CurveProblem
    rate: float
    rows: FloatArray
    left: FloatArray
    points: float
    total: float

    def beside(self, terms: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Products (M, M) of terms (N, M), and theirs with what is left (M,), the rotation free."""
        joint = self.problem.projected(terms.T)
        taken_up = joint @ self.rows.T
        return joint @ joint.T - taken_up @ taken_up.T, joint @ self.left


def of_series(problem: CurveProblem, rate: float, order: int = ORDERS[0]) -> Explained:
    """What the series of a rotation, or of an orbit, explains."""
    terms = problem.projected(series(rate, order, problem.t).T)
    # without it a series reaches many magnitudes where no points are
    inner = terms @ terms.T + _spectrum.RIDGE * np.eye(len(terms))
    left = problem.projected(problem.y)
    return _explained(problem, rate, terms, inner, left, terms @ left)


def of_body(problem: CurveProblem, body: BodyFit, tie: Tie, fixed: BoolArray) -> Explained:
    """What a body that rotates about one axis, and all near it, explain."""
    fit = _refinement.refine(problem, body.state, tie=tie, fixed=fixed).linearised
    model = _refinement.model(problem, fit.state)
    free = np.ones(len(fit.normal), bool)
    free[: len(fixed)] = ~fixed[: len(free)]
    terms = problem.projected(model.jacobian[free])
    left = problem.projected(problem.y - model.magnitude)
    inner = fit.normal[np.ix_(free, free)]
    rate = SearchState.of(fit.state).rates[0]
    return _explained(problem, rate, terms, inner, left, fit.gradient[free])


def _explained(
    problem: CurveProblem,
    rate: float,
    terms: FloatArray,
    inner: FloatArray,
    left: FloatArray,
    gradient: FloatArray,
) -> Explained:
    factor = np.linalg.cholesky(inner)
    rows = np.linalg.solve(factor, terms)
    left = left - rows.T @ np.linalg.solve(factor, gradient)
    points, y = len(problem) - float(np.sum(rows**2)), problem.projected(problem.y)
    return Explained(problem, rate, rows, left, points, float(y @ y))


def series(frequency: float, order: int, t: FloatArray) -> FloatArray:
    """Cosines and sines (N, 2 order) of the multiples of a frequency at epochs (N,)."""
    angle = 2.0 * math.pi * frequency * t
    first = np.cos(angle) + 1j * np.sin(angle)
    powers = np.multiply.accumulate(np.broadcast_to(first, (order, len(t))), axis=0)
    return np.concatenate([powers.real, powers.imag]).T


@cache
def _lasting(order: int) -> FloatArray:
    """The series (P, 2 order) of an orbit at `_PHASES` epochs of it."""
    return series(1.0, order, np.arange(_PHASES) / _PHASES)


def changing(frequency: float, t: FloatArray, order: int = DIPS) -> FloatArray:
    """The series of an orbit (N, 4 order) whose amplitudes change linearly over the span.

    The depth and the length of dips depend on the directions to Sun and observer.
    """
    terms = series(frequency, order, t)
    return np.concatenate([terms, terms * (2.0 * t[:, None])], axis=1)


def _deviations(amplitude: float, change: float, wide: float, order: int = DIPS) -> FloatArray:
    """Standard deviations (4 order,), mag, of the amplitudes of `changing` before a curve is seen.

    Those of the multiple `wide` of the frequency are half of the first ones.
    """
    falling = amplitude / (1.0 + (np.arange(1, order + 1) / wide) ** 2)
    return np.concatenate([np.tile(falling, 2), np.tile(change * falling, 2)])


def beside(problem: CurveProblem, pair: AdditivePair, alone: Explained) -> CurveProblem:
    """The problem with the series of an orbit among its linear terms.

    Their amplitudes have the standard deviations that are likeliest beside what the rotation alone
    explains, with the errors that it leaves.
    """
    terms = changing(pair.orbit, problem.t)
    inner, along = alone.beside(terms)
    # in units of the errors with the model error
    least = float(np.mean((alone.problem.sigma * alone.problem.root) ** 2))
    likelihoods = []
    for change, wide in itertools.product(_CHANGES, _WIDE):
        scale = _deviations(1.0, change, wide)
        values, vectors = np.linalg.eigh(inner * np.outer(scale, scale))
        squares = (vectors.T @ (along * scale)) ** 2
        for amplitude in _AMPLITUDES:
            of_unit = amplitude**2 * values, amplitude**2 * squares
            evidence = _evidence.of_orbit(*of_unit, alone.left, alone.points, least)
            likelihoods.append((evidence, (amplitude, change, wide)))
    return problem.with_terms(terms, _deviations(*min(likelihoods)[1]), pair.orbit)


def brightening(beside: CurveProblem, alone: Explained) -> float:
    """How much the series of an orbit, in the problem `beside` it, brightens over how much it dims.

    At the epochs of the curve, or at all phases of the orbit in the middle of the span, where that
    is more: series that mimic tumbling brighten as much as they dim.
    """
    terms = beside.terms[:, -4 * DIPS :]
    inner, along = alone.beside(terms)
    amplitudes = np.linalg.solve(inner + np.diag(beside.prior[-4 * DIPS :] ** -2.0), along)
    lasting = _lasting(DIPS) @ amplitudes[: 2 * DIPS]
    return max(_brightening(terms @ amplitudes), _brightening(lasting))


def _brightening(dips: FloatArray) -> float:
    """How much a series, mag, brightens over how much it dims, from its median."""
    off = dips - np.median(dips)
    return -float(off.min()) / max(float(off.max()), 1e-30)


def orbits_beside(alone: Explained) -> list[AdditivePair]:
    """Orbits of dips beside a body, the best first, each with the period of the orbit.

    From a scan of all frequencies below that of the body but those on its comb, with so few lines
    that no low frequency explains what the body lacks.  Both eclipses of an orbit are alike: often
    twice its frequency fits best.
    """
    settings = alone.problem.settings
    orbits = np.arange(int(_LEAST_ORBITS * _FINE), int(alone.rate * _FINE)) / _FINE
    orbits = orbits[~_is_comb(orbits, alone.rate)]
    fits = [_beside(alone, orbit, _SCANNED[1]) for orbit in orbits.tolist()]
    fits = [fit for fit in fits if fit.are_dips and fit.only_dims]
    fits.sort(key=lambda fit: fit.left)
    pairs = []
    for fit in distinct(fits, lambda a, b: _are_one(a.orbit, b.orbit), settings.orbits_beside):
        pair = fitted_beside(alone, fit.orbit)
        has_two = pair.second > settings.second_dip * pair.range
        pairs.append(pair if has_two else fitted_beside(alone, 0.5 * pair.orbit))
    return distinct(pairs, lambda a, b: _are_one(a.orbit, b.orbit))


def fitted_beside(alone: Explained, orbit: float) -> AdditivePair:
    """The pair of a body and of the series near an orbit that fits best."""
    for shifts in (_SHIFTS, _FINER):
        fits = [_beside(alone, orbit + shift, ORDERS[1], changing) for shift in shifts]
        best = min(fits, key=lambda fit: fit.left)
        orbit = best.orbit
    return best


def _beside(
    alone: Explained, orbit: float, order: int, of_orbit: Callable[..., FloatArray] = series
) -> AdditivePair:
    """The pair of a body and of the series of an orbit, `series` or `changing`, that fits best."""
    problem = alone.problem
    terms = of_orbit(orbit, t=problem.t, order=order)
    problem.tally.add(len(problem) * terms.shape[1], problem.settings.orbit_cost)
    inner, along = alone.beside(terms)
    deviations = _deviations(_AMPLITUDES[0], _CHANGES[0], _WIDE[0], order)[: len(along)]
    inner.flat[:: len(inner) + 1] += deviations**-2.0
    amplitudes: FloatArray = np.asarray(np.linalg.solve(inner, along), np.float64)
    left = (float(alone.left @ alone.left) - float(amplitudes @ along)) / alone.total
    return AdditivePair(alone.rate, orbit, left, *_dips(amplitudes[: 2 * order]))


def additive_pairs(problem: CurveProblem, most: float, keep: int = 4) -> list[AdditivePair]:
    """Pairs of frequencies whose series, added, fit a curve best, the best first.

    The frequency of the orbit is the lower one, and its series consists of dips.  `most`: of the
    rotation, turns per span.
    """
    pairs = _scanned(problem, _rotations(problem, most))
    orbits = (pair.orbit for pair in pairs)
    for orbit in distinct(orbits, _are_one, problem.settings.orbits_again):
        pairs += _with_rotations(problem, orbit, most)
    pairs = _distinct(pairs)
    pairs += [
        _fitted(problem, pair.rotation, factor * pair.orbit)
        for pair in pairs[:keep]
        for factor in (0.5, 2.0)
        if _lattices.LEAST < factor * pair.orbit < pair.rotation
    ]
    return _distinct(pairs)[:keep]


def _with_rotations(problem: CurveProblem, orbit: float, most: float) -> list[AdditivePair]:
    """Pairs of an orbit and of strong lines that its series leaves."""
    terms = series(orbit, ORDERS[1], problem.t)
    without = problem.with_terms(terms, np.full(terms.shape[1], _AMPLITUDES[0]), orbit)
    # the first ones are near pairs that were scanned
    rotations = _rotations(without, most, _ROTATIONS // 2)
    return [_fitted(problem, rate, orbit) for rate in rotations[rotations > orbit]]


def pairs_near(problem: CurveProblem, orbit: float, most: float, keep: int) -> list[AdditivePair]:
    """As `additive_pairs`, of orbits near one whose series alone explains most of the curve."""

    def left(rate: float) -> float:
        return float(np.sum(of_series(problem, rate, ORDERS[1]).left ** 2))

    best = min((orbit + shift for shift in _SHIFTS), key=left)
    return _distinct(_with_rotations(problem, best, most))[:keep]


def _are_one(orbit: float, other: float) -> bool:
    return abs(orbit - other) <= _CLOSE


def _distinct(pairs: list[AdditivePair]) -> list[AdditivePair]:
    """Pairs with dips whose frequencies form no comb, each once, the best first."""
    dips = (
        pair
        for pair in sorted(pairs, key=lambda pair: pair.left)
        if pair.are_dips and not _is_comb(np.array([pair.orbit]), pair.rotation)[0]
    )
    return distinct(dips, lambda a, b: max(abs(a[0] - b[0]), abs(a[1] - b[1])) < _CLOSE)


def _rotations(problem: CurveProblem, most: float, count: int = _ROTATIONS) -> FloatArray:
    """Rates (R,), turns per span, of strong lines and half of them."""
    rotations = _lattices.rotations(problem, most, count)
    return rotations[rotations > 2.0 * _lattices.LEAST]


def _scanned(problem: CurveProblem, rotations: FloatArray) -> list[AdditivePair]:
    """The best pairs of rates (R,) and slower orbits."""
    if not len(rotations):
        return []
    settings = problem.settings
    # sums and differences of any two lines
    count = int(2.0 * max(_SCANNED) * rotations.max() * _FINE) + 2
    sums = _spectrum.tables(problem.t, problem.root**2, problem.detrended, 1.0 / _FINE, count)
    lines = np.array(
        [(0, 0)]
        + [(i, 0) for i in range(1, _SCANNED[0] + 1)]
        + [(0, j) for j in range(1, _SCANNED[1] + 1)]
    )
    scanned: list[tuple[float, float, float]] = []
    for rotation in rotations:
        orbits = np.arange(int(_LEAST_ORBITS * _FINE), int(rotation * _FINE))
        orbits = orbits[~_is_comb(orbits / _FINE, rotation)]
        if not len(orbits):
            continue
        first = np.full(len(orbits), round(rotation * _FINE))
        gain = _spectrum.decreases(sums, first, orbits, lines)
        problem.tally.add(len(orbits), settings.pair_cost)
        best = np.argsort(-gain, kind="stable")[: 8 * settings.orbits_of_line]
        rows = ((-float(gain[k]), float(rotation), float(orbits[k]) / _FINE) for k in best)
        scanned += distinct(rows, lambda a, b: _are_one(a[2], b[2]), settings.orbits_of_line)
    best_ones = sorted(scanned)[: settings.orbits_fitted]
    fits = [_fitted(problem, *pair[1:], steps=2) for pair in best_ones]
    fits.sort(key=lambda fit: fit.left)
    return [_fitted(problem, fit.rotation, fit.orbit) for fit in fits[: settings.orbits_freed]]


def rivals(
    problem: CurveProblem, most: float, keep: int, orbit: float | None = None
) -> list[AdditivePair]:
    """The best pairs, of all orbits or near one, each with the period of its orbit, and once."""
    if orbit is None:
        fits = additive_pairs(problem, most, keep)
    else:
        fits = pairs_near(problem, orbit, most, keep)
    pairs = (with_orbit(problem, pair) for pair in fits)
    return distinct(pairs, lambda a, b: abs(a.orbit - b.orbit) < _CLOSE and _is_multiple(a, b))


def rates_beside(problem: CurveProblem, rates: FloatArray, most: float) -> FloatArray:
    """Rates (R,), turns per span, to try beside the orbit of a problem: some, and strong lines.

    Deep dips hide the lines of a rotation from every series that is fitted without its aspect.
    Rates on the comb of the orbit are none: two multiples of an orbit explain its dips too.
    """
    lines = _lattices.rotations(problem, most, _ROTATIONS)
    ordered = _once(np.concatenate([rates[rates < 2.0 * most], lines]))
    return ordered[~_is_comb(ordered, problem.orbit)]


def rates_of(pairs: list[AdditivePair]) -> FloatArray:
    """Rates (R,), turns per span, of bodies that show the rotations of pairs, each once.

    Beside one orbit the rotation of another pair may be likelier: all are tried with each.
    """
    return _once(np.outer([pair.rotation for pair in pairs], RATIOS))


def _once(rates: FloatArray) -> FloatArray:
    """Rates of any shape, in order (R,), without those next to another one."""
    ordered = np.sort(rates, axis=None)
    return ordered[np.diff(ordered, prepend=-math.inf) > _APART]


def _is_multiple(one: AdditivePair, other: AdditivePair) -> bool:
    """Whether the rotation of a pair is that of another one, half of it or twice."""
    ratios = [abs(one.rotation - ratio * other.rotation) for ratio in (0.5, 1.0, 2.0)]
    return min(ratios) < 1.0


def with_orbit(problem: CurveProblem, pair: AdditivePair) -> AdditivePair:
    """The pair whose series in the orbit has the period of the orbit.

    A series of half of it, or of twice that, often fits as well.  A moon eclipses and is eclipsed:
    two dips an orbit, half a period apart.  So of the periods that fit as well as the best one the
    shortest counts, or twice that where it has one dip.  The rotation has the shortest of its
    periods.
    """
    rotations = [_fitted(problem, factor * pair.rotation, pair.orbit) for factor in (1.0, 2.0, 3.0)]
    rotation = _shortest(rotations, problem).rotation
    shortest = _shortest(
        [_fitted_about(problem, rotation, factor * pair.orbit) for factor in _FACTORS], problem
    )
    if shortest.second > problem.settings.second_dip * shortest.range:
        return shortest
    return _fitted(problem, shortest.rotation, 0.5 * shortest.orbit)


def _shortest(fits: list[AdditivePair], problem: CurveProblem) -> AdditivePair:
    """The pair of the shortest periods among those that fit as well as the best one."""
    most = min(fit.left for fit in fits) * (1.0 + problem.settings.competing / len(problem))
    return max((fit for fit in fits if fit.left < most), key=lambda fit: fit.rotation * fit.orbit)


def _is_comb(frequencies: FloatArray, other: float) -> BoolArray:
    """Which frequencies (P,) are on one comb with another one, within a turn of the span."""
    ratios = {i / j for i in range(1, _COMB + 1) for j in range(1, _COMB + 1)}
    on = [np.abs(frequencies - ratio * other) < 1.0 for ratio in ratios]
    return np.asarray(np.any(on, axis=0))


def _fitted(
    problem: CurveProblem, rotation: float, orbit: float, *, steps: int = _STEPS
) -> AdditivePair:
    """The pair near two frequencies whose series fit best."""
    problem.tally.add(steps * len(problem), problem.settings.series_cost)
    fits = least_squares.Problem(lambda pairs: _linearised(problem, *pairs[0, :2]), _moved)
    start = np.array([AdditivePair(rotation, orbit, math.inf)])
    best = least_squares.minimum(fits, start, _RULE, steps).states[0]
    return AdditivePair(*best.tolist())


def _moved(pairs: FloatArray, steps: FloatArray) -> tuple[FloatArray, BoolArray]:
    """Pairs (S, 7) after steps (S, 2) of their frequencies, which have no bounds."""
    moved = pairs.copy()
    moved[:, :2] += np.clip(steps, -_LONGEST, _LONGEST)
    return moved, np.ones(len(pairs), bool)


def _linearised(problem: CurveProblem, rotation: float, orbit: float) -> Near:
    """The pair of two frequencies, as a row (1, 7); linear terms are projected out exactly."""
    y = problem.projected(problem.y)
    total = float(y @ y)
    bases = [series(rotation, ORDERS[0], problem.t), changing(orbit, problem.t, ORDERS[1])]
    joint = problem.projected(np.concatenate(bases, axis=1).T)
    # without it a series reaches many magnitudes where no points are
    held = np.full(2 * ORDERS[0], _spectrum.RIDGE)
    deviations = _deviations(_AMPLITUDES[0], _CHANGES[0], _WIDE[0], ORDERS[1])
    inner = joint @ joint.T + np.diag(np.concatenate([held, deviations**-2.0]))
    along = joint @ y
    amplitudes: FloatArray = np.asarray(np.linalg.solve(inner, along), np.float64)
    left = 1.0 - float(amplitudes @ along) / total
    of_rotation, of_orbit = np.split(amplitudes, [2 * ORDERS[0]])
    mean, change = np.split(of_orbit, 2)
    slopes = [
        _slope(bases[0], of_rotation),
        _slope(bases[1][:, : len(mean)], mean) + _slope(bases[1][:, len(mean) :], change),
    ]
    both = problem.projected((2.0 * math.pi * problem.t[:, None] * np.stack(slopes, axis=1)).T)
    # amplitudes follow: they are eliminated
    across = np.linalg.solve(inner, joint @ both.T)
    normal = both @ both.T - (both @ joint.T) @ across
    residual = y - joint.T @ amplitudes
    gradient = both @ residual - across.T @ (joint @ residual)
    pair = AdditivePair(rotation, orbit, left, *_dips(mean))
    return Near(np.array([pair]), np.array([left]), normal[None] / total, gradient[None] / total)


def _fitted_about(problem: CurveProblem, rotation: float, orbit: float) -> AdditivePair:
    """The pair whose series fit best near a frequency of an orbit that is not known to its lines.

    The lines of narrow dips leave minima side by side, closer than the resolution of the span.
    """
    fits = (_fitted(problem, rotation, orbit + shift, steps=1) for shift in _SHIFTS)
    best = min(fits, key=lambda fit: fit.left)
    return _fitted(problem, best.rotation, best.orbit)


def _slope(base: FloatArray, amplitudes: FloatArray) -> FloatArray:
    """The derivative (N,) of a series (N, 2 M) with amplitudes (2 M,) by its angle."""
    order = base.shape[1] // 2
    numbers = np.arange(1, order + 1)
    cosine, sine = amplitudes[:order] * numbers, amplitudes[order:] * numbers
    return base[:, :order] @ sine - base[:, order:] @ cosine


def _dips(amplitudes: FloatArray) -> tuple[float, float, float, float]:
    """Dips of a series in the orbit, mag: range, skewness, second depth, and brightening."""
    dips = _lasting(len(amplitudes) // 2) @ amplitudes
    off = dips - dips.mean()
    skewness = float(np.mean(off**3) / max(float(np.mean(off**2)) ** 1.5, 1e-30))
    from_deepest = np.roll(dips, -int(np.argmax(dips)))
    phase = np.arange(_PHASES) / _PHASES
    is_half_away = np.abs(phase - 0.5) < _OFF_HALF
    between = np.abs(np.abs(phase - 0.5) - 0.25) < _OFF_HALF
    second = float(from_deepest[is_half_away].max() - np.median(from_deepest[between]))
    return float(np.ptp(dips)), skewness, second, _brightening(dips)
