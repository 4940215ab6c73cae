"""Rotation about one axis beside an additive series in a second period: bodies with a moon.

Eclipses and occultations by a moon add dips at the period of its orbit to the magnitudes of a
rotating body.  A tumbling body has lines at sums and differences of two frequencies; here there are
none, only multiples of each.  Pairs of periods are found by series (`additive_pairs`); the rival of
a tumbling state is then a body that rotates about one axis, with the series in the second period
among the linear terms.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from attitude.inversion import _lattices
from attitude.photometry import _spectrum

if TYPE_CHECKING:
    from attitude._support.annotations import BoolArray, FloatArray
    from attitude.inversion._problem import CurveProblem


# Lines of the rotation and of the orbit in the scan, and in the fits of its best pairs: rotation is
# smooth, dips are narrow, and two of unlike depth an orbit leave half the period behind.
_SCANNED, ORDERS = (4, 6), (6, 16)
# Frequencies of the orbit per 1/span: its sixth harmonic is resolved.
_FINE = 12
# Strong lines whose orbits are scanned, orbits of each, pairs that are fitted in two steps and in
# more; the best of them also with twice and half the period of the orbit.
_ROTATIONS, _ORBITS, _FITTED, _FREE = 12, 12, 80, 24
# Orbits beside whose series the rotation is looked for once more: deep dips drown its lines.
_BESIDE = 4
# Ratios of two numbers up to this are those of one comb, whose lines are a shape's.
_COMB = 4
# Steps of the fit of both frequencies, and the longest one, turns per span.
_STEPS, _LONGEST = 4, 0.1
# Skewness of dips at least (binaries: 1.2 to 2.1), orbits in the span at least, range at most, mag:
# half of a pair of equal bodies is 0.75, and noise adds to it.
_LEAST_SKEWNESS, _LEAST_ORBITS, _DEEPEST = 0.6, 4.0, 1.2
# Epochs of an orbit at which its series is evaluated.
_PHASES = 360
# Depth of the second dip, over the range, from which it is one; an orbit is not always a circle.
_SECOND, _OFF_HALF = 0.15, 0.06
# Standard deviation, mag, of the amplitudes of a series beside a body before the curve is seen.
_AMPLITUDE = 0.1


class AdditivePair(NamedTuple):
    """Frequencies of rotation and orbit, turns per span, and the share of chi-squared left.

    range, mag, and skewness are those of the series in the orbit; second, mag: the depth of the dip
    half a period after the deepest one.
    """

    rotation: float
    orbit: float
    left: float
    range: float = 0.0
    skewness: float = 0.0
    second: float = 0.0

    @property
    def are_dips(self) -> bool:
        """Whether the series in the orbit looks like eclipses: short, faint, seen several times.

        Series that mimic tumbling are skewed to either side, reach many magnitudes, or last for
        most of the span.
        """
        is_short = self.skewness > _LEAST_SKEWNESS and self.orbit > _LEAST_ORBITS
        return is_short and self.range < _DEEPEST


def series(frequency: float, order: int, t: FloatArray) -> FloatArray:
    """Cosines and sines (N, 2 order) of the multiples of a frequency at epochs (N,)."""
    angle = 2.0 * math.pi * frequency * np.outer(t, np.arange(1, order + 1))
    return np.concatenate([np.cos(angle), np.sin(angle)], axis=1)


def beside(problem: CurveProblem, frequency: float) -> CurveProblem:
    """The problem with the series of an orbit among its linear terms."""
    terms = series(frequency, ORDERS[1], problem.t)
    return problem.with_terms(terms, np.full(terms.shape[1], _AMPLITUDE), frequency)


def additive_pairs(problem: CurveProblem, most: float, keep: int = 4) -> list[AdditivePair]:
    """Pairs of frequencies whose series, added, fit a curve best, the best first.

    The frequency of the orbit is the lower one, and its series consists of dips.  `most`: of the
    rotation, turns per span.
    """
    pairs = _scanned(problem, _rotations(problem, most))
    orbits: list[float] = []
    for pair in pairs:
        if all(abs(pair.orbit - other) > 0.5 for other in orbits) and len(orbits) < _BESIDE:
            orbits.append(pair.orbit)
    for orbit in orbits:
        terms = series(orbit, ORDERS[1], problem.t)
        without = problem.with_terms(terms, np.full(terms.shape[1], _AMPLITUDE), orbit)
        # the first ones are near pairs that were scanned
        rotations = _rotations(without, most, _ROTATIONS // 2)
        pairs += [_fitted(problem, rate, orbit) for rate in rotations[rotations > orbit]]
    pairs = _distinct(pairs)
    pairs += [
        _fitted(problem, pair.rotation, factor * pair.orbit)
        for pair in pairs[:keep]
        for factor in (0.5, 2.0)
        if _lattices.LEAST < factor * pair.orbit < pair.rotation
    ]
    return _distinct(pairs)[:keep]


def _distinct(found: list[AdditivePair]) -> list[AdditivePair]:
    """Pairs with dips whose frequencies form no comb, each once, the best first."""
    out: list[AdditivePair] = []
    for pair in sorted(found, key=lambda each: each.left):
        is_close = [max(abs(pair[0] - one[0]), abs(pair[1] - one[1])) < 0.5 for one in out]
        is_comb = bool(_is_comb(np.array([pair.orbit]), pair.rotation)[0])
        if pair.are_dips and not any(is_close) and not is_comb:
            out.append(pair)
    return out


def _rotations(problem: CurveProblem, most: float, count: int = _ROTATIONS) -> FloatArray:
    """Rates (R,), turns per span, of strong lines and half of them."""
    strong = _lattices.lines(problem, most, count)
    rotations = np.unique(np.concatenate([strong, 0.5 * strong]))
    long_ones: FloatArray = rotations[rotations > 2.0 * _lattices.LEAST]
    return long_ones


def _scanned(problem: CurveProblem, rotations: FloatArray) -> list[AdditivePair]:
    """The best pairs of rates (R,) and slower orbits."""
    if not len(rotations):
        return []
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
        gain = np.empty(len(orbits))
        _spectrum.decreases(*sums[:4], first, orbits, lines, _spectrum.RIDGE, gain)
        problem.tally.add(len(orbits), problem.settings.pair_cost)
        chosen: list[float] = []
        for k in np.argsort(-gain, kind="stable")[: 8 * _ORBITS]:
            orbit = float(orbits[k]) / _FINE
            if all(abs(orbit - other) > 0.5 for other in chosen) and len(chosen) < _ORBITS:
                chosen.append(orbit)
                scanned.append((-float(gain[k]), float(rotation), orbit))
    fits = [_fitted(problem, *pair[1:], steps=2) for pair in sorted(scanned)[:_FITTED]]
    fits.sort(key=lambda each: each.left)
    return [_fitted(problem, each.rotation, each.orbit) for each in fits[:_FREE]]


def rivals(problem: CurveProblem, most: float, keep: int) -> list[AdditivePair]:
    """The best pairs, as `additive_pairs`, each with the period of its orbit and that once."""
    distinct: list[AdditivePair] = []
    for pair in additive_pairs(problem, most, keep):
        one = with_orbit(problem, pair)
        same = [
            abs(one.orbit - other.orbit) < 0.5 and _is_multiple(one, other) for other in distinct
        ]
        if not any(same):
            distinct.append(one)
    return distinct


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
    orbits = [_fitted(problem, rotation, factor * pair.orbit) for factor in (0.5, 1.0, 2.0, 4.0)]
    shortest = _shortest(orbits, problem)
    if shortest.second > _SECOND * shortest.range:
        return shortest
    return _fitted(problem, shortest.rotation, 0.5 * shortest.orbit)


def _shortest(fits: list[AdditivePair], problem: CurveProblem) -> AdditivePair:
    """The pair of the shortest periods among those that fit as well as the best one."""
    most = min(fit.left for fit in fits) * (1.0 + problem.settings.competing / len(problem))
    return max(
        (fit for fit in fits if fit.left < most), key=lambda each: each.rotation * each.orbit
    )


def _is_comb(orbits: FloatArray, rotation: float) -> BoolArray:
    """Which frequencies (P,) have lines of the comb of a rotation within a turn of the span."""
    ratios = {i / j for i in range(1, _COMB + 1) for j in range(1, _COMB + 1)}
    on = [np.abs(orbits - ratio * rotation) < 1.0 for ratio in ratios]
    return np.asarray(np.any(on, axis=0))


def _fitted(
    problem: CurveProblem, rotation: float, orbit: float, *, steps: int = _STEPS
) -> AdditivePair:
    """The pair near two frequencies whose series fit best, linear terms projected out exactly."""
    y = problem.y * problem.root
    y = y - problem.u.T @ (problem.u @ y)
    total = float(y @ y)
    pair = np.array([rotation, orbit])
    best = AdditivePair(rotation, orbit, math.inf)
    multiples = [np.arange(1, order + 1) for order in ORDERS]
    # without it a series reaches many magnitudes where no points are
    held = np.full(2 * sum(ORDERS), _spectrum.RIDGE)
    held[2 * ORDERS[0] :] = _AMPLITUDE**-2.0
    problem.tally.add(steps * len(problem), problem.settings.body_cost)
    for step in range(steps):
        bases = [series(f, order, problem.t) for f, order in zip(pair, ORDERS, strict=True)]
        joint = _projected(problem, np.concatenate(bases, axis=1))
        inner = joint @ joint.T + np.diag(held)
        along = joint @ y
        amplitudes: FloatArray = np.asarray(np.linalg.solve(inner, along), np.float64)
        left = 1.0 - float(amplitudes @ along) / total
        if left < best.left:
            shape = _dips(amplitudes[2 * ORDERS[0] :])
            best = AdditivePair(float(pair[0]), float(pair[1]), left, *shape)
        if step == steps - 1:
            break
        slopes, start = [], 0
        for base, order, numbers in zip(bases, ORDERS, multiples, strict=True):
            cosine, sine = amplitudes[start : start + order], amplitudes[start + order :][:order]
            rate = base[:, :order] @ (sine * numbers) - base[:, order:] @ (cosine * numbers)
            slopes.append(2.0 * math.pi * problem.t * rate)
            start += 2 * order
        residual = y - joint.T @ amplitudes
        both = _projected(problem, np.stack(slopes, axis=1))
        # amplitudes follow: they are eliminated
        across = np.linalg.solve(inner, joint @ both.T)
        normal = both @ both.T - (both @ joint.T) @ across
        side = both @ residual - across.T @ (joint @ residual)
        move = np.linalg.lstsq(normal, side, rcond=1e-12)[0]
        pair = pair + np.clip(move, -_LONGEST, _LONGEST)
    return best


def _dips(amplitudes: FloatArray) -> tuple[float, float, float]:
    """Range and skewness of a series in the orbit, and the depth of its second dip, mag."""
    dips = series(1.0, ORDERS[1], np.arange(_PHASES) / _PHASES) @ amplitudes
    off = dips - dips.mean()
    skewness = float(np.mean(off**3) / max(float(np.mean(off**2)) ** 1.5, 1e-30))
    from_deepest = np.roll(dips, -int(np.argmax(dips)))
    phase = np.arange(_PHASES) / _PHASES
    is_half_away = np.abs(phase - 0.5) < _OFF_HALF
    between = np.abs(np.abs(phase - 0.5) - 0.25) < _OFF_HALF
    second = float(from_deepest[is_half_away].max() - np.median(from_deepest[between]))
    return float(np.ptp(dips)), skewness, second


def _projected(problem: CurveProblem, terms: FloatArray) -> FloatArray:
    """Weighted terms (K, N) of terms (N, K), the linear terms of the problem taken off."""
    weighted = terms.T * problem.root
    return weighted - (weighted @ problem.u.T) @ problem.u
