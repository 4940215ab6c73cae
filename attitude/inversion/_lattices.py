"""Candidate rates from the spectrum of a light curve.

A body with the symmetry of an ellipsoid has lines at i g + 2 j f alone, f = 1/P_psi and g either
lambda/pi - f or, which is the same lattice, lambda/pi + f.  Every pair of frequencies of a grid is
fitted as (g, 2 f) with |i|, |j| <= 2; each good pair then gives every rate lambda/pi = g + (2k+1) f
in both modes, for both assignments of the pair.  A body of two unlike lobes has strong lines at odd
multiples of f too: the pair that fits is then (g, f).
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from attitude._support.arrays import distinct
from attitude.photometry import _spectrum
from attitude.photometry._lattices import SHORT_AXIS
from attitude.photometry._spectrum import OVERSAMPLING

if TYPE_CHECKING:
    from attitude._support.annotations import FloatArray
    from attitude.inversion._problem import CurveProblem
    from attitude.photometry._spectrum import Tables


# Least frequency, turns per span.
LEAST = 0.7
# Order of the series of a pair.
_ORDER = 2
# Step of scans over nutations, turns per span.
STEP = 0.4
# The largest nutation of these scans over the largest frequency.
_MOST_NUTATION = 0.6
# Distance of lambda/pi, turns per span, at which two candidates are one.
_SAME_RATE = 0.7
# Distance of f, turns per span, at which they are.
_SAME_NUTATION = 0.5
# Distance, turns per span, at which two lines are one.
_SAME_LINE = 0.8
# Multiples of f by which lambda/pi is off a line that fits, where lines lie at even ones alone.
_ODD = (-3, -1, 1, 3)
# The same where lines lie at all of them.
_ALL = (-2, -1, 0, 1, 2)


class Candidate(NamedTuple):
    """Rates to try: lambda / 2 pi and f, turns per span, f signed by the mode."""

    precession: float
    nutation: float


def tables(problem: CurveProblem, count: int) -> Tables:
    """The tables of `_spectrum` up to the grid frequency `count`."""
    return _spectrum.tables(
        problem.t, problem.root**2, problem.detrended, 1.0 / OVERSAMPLING, count + 1
    )


def lattice_pairs(problem: CurveProblem, most: float, keep: int) -> tuple[FloatArray, FloatArray]:
    """The best pairs of frequencies (P, 2), turns per span, and the share of chi-squared left
    (P,).
    """
    count = int(most * OVERSAMPLING) + 1
    least = max(2, int(LEAST * OVERSAMPLING))
    end = least + max(count - least, 3)
    sums = tables(problem, 4 * _ORDER * end + 2)
    lines = _spectrum.harmonics(_ORDER)
    settings, grid = problem.settings, (least, end)
    best_pairs = _spectrum.best(sums, grid, grid, lines, keep, fitted=settings.pairs_fitted)
    fitted = min(best_pairs.tried, settings.pairs_fitted)
    problem.tally.add(fitted, settings.pair_cost)
    problem.tally.add(best_pairs.tried - fitted, settings.power_cost)
    both = np.stack([best_pairs.first, best_pairs.second], axis=-1) / OVERSAMPLING
    return both, best_pairs.left


def candidates(
    pairs: FloatArray,
    most: float,
    modes: tuple[str, ...],
    shifts: tuple[float, ...] = (),
    *,
    has_odd_lines: bool = False,
) -> list[Candidate]:
    """Rates from pairs (P, 2), the best pair first, without repetition.

    `shifts` are frequencies (turns per span) by which windows of the epochs displace lines, such as
    one cycle a day.  `has_odd_lines`: the body has no symmetry, and lines at odd multiples of f.
    """
    of_nutation, multiples = (1.0, _ALL) if has_odd_lines else (0.5, _ODD)
    out: list[Candidate] = []
    seen = set()
    for a, b in pairs:
        bases = [(a, b), (b, a), (a, b - a), (b, b - a), (a, a + b), (b, a + b)]
        for shift in shifts:
            bases += [(a, abs(b - shift)), (abs(a - shift), b), (b, abs(a - shift))]
            bases += [(abs(b - shift), a), (a, b + shift), (b, a + shift)]
        for g, h in bases:
            for rate, f in _rates(g, of_nutation * h, multiples, most, modes):
                key = round(rate / _SAME_RATE), round(f / _SAME_NUTATION)
                if key not in seen:
                    seen.add(key)
                    out.append(Candidate(0.5 * rate, f))
    return out


def of_line(line: float, most: float, modes: tuple[str, ...]) -> list[Candidate]:
    """Rates that have one line, turns per span: that of phi, or that of phi and psi together.

    These are the strongest lines of both modes.  Every nutation is tried with each.
    """
    return [
        candidate
        for f in np.arange(LEAST, _MOST_NUTATION * most, STEP).tolist()
        for phi in (line, line - f)
        for candidate in _in_modes(phi, f, most, modes)
    ]


def mistaken(phi: float, psi: float, most: float, modes: tuple[str, ...]) -> list[Candidate]:
    """Rates whose lines are those of others or lie next to them, in any mode.

    phi moves by psi, or psi is half or twice as large.
    """
    pairs = (phi, psi), (phi - psi, psi), (phi + psi, psi), (phi, 0.5 * psi), (phi, 2.0 * psi)
    return [candidate for pair in pairs for candidate in _in_modes(*pair, most, modes)]


def _in_modes(phi: float, psi: float, most: float, modes: tuple[str, ...]) -> list[Candidate]:
    """The rates of each mode with frequencies of phi and psi, within the bounds of frequencies."""
    out: list[Candidate] = []
    if phi >= LEAST and phi + psi <= most:
        if "LAM" in modes:
            out.append(Candidate(0.5 * (phi + psi), psi))
        if "SAM" in modes and psi < SHORT_AXIS * phi:
            out.append(Candidate(0.5 * phi, -psi))
    return out


def _rates(g, f, multiples, most, modes):
    """lambda/pi and signed f on a lattice, within the bounds of frequencies."""
    if not LEAST <= f <= most:
        return
    for multiple in multiples:
        rate = g + multiple * f
        if "LAM" in modes and rate - f >= LEAST and rate <= most:
            yield rate, f
        if "SAM" in modes and rate >= LEAST and rate + f <= most and f < SHORT_AXIS * rate:
            yield rate, -f


def rotations(problem: CurveProblem, most: float, keep: int) -> FloatArray:
    """Rates (R,), turns per span, of the best lines, `keep` of them, and half of each."""
    strong = lines(problem, most, keep)
    return np.unique(np.concatenate([strong, 0.5 * strong]))


def lines(problem: CurveProblem, most: float, keep: int) -> FloatArray:
    """Frequencies (P,), turns per span, of the best series of one period with four harmonics."""
    grid = np.arange(max(1, int(LEAST * OVERSAMPLING)), int(most * OVERSAMPLING) + 1)
    sums = tables(problem, 8 * int(grid[-1] + 1))
    harmonics = np.array([(i, 0) for i in range(5)])
    gain = _spectrum.decreases(sums, grid, grid, harmonics)
    frequencies = (float(grid[k]) / OVERSAMPLING for k in np.argsort(-gain, kind="stable"))
    return np.array(distinct(frequencies, lambda a, b: abs(a - b) <= _SAME_LINE, keep))
