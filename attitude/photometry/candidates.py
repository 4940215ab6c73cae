"""Periods (P_psi, P_phi) in either mode whose lines are those of a series in two frequencies.

A light curve has lines at i/P_phi + j/P_psi, so that its lattice of lines has many bases, and no
line belongs to a mode.  Two facts rank the bases: the strongest line of an elongated body is that
of two circulations of the long axis about the momentum, 2/P_phi of convention L, in both modes; and
a body with the symmetry of an ellipsoid has even numbers j alone.  The score of a basis is the
share of the power of all lines that it explains, each line weighted by `_WEIGHTS`, times the share
of the variance that the series explains.

What remains open: 1/P_psi and half of it where all j are even, one cycle a day at one site, and the
mode; `attitude.inversion.spin_states` decides where the geometry allows it.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Sequence

    from attitude.annotations import FloatArray
    from attitude.spectrum.refinement import RefinedSeries

# Pairs of frequencies that are turned into candidates.
PAIRS: int = 4
# Weights of a line at i/P_phi + j/P_psi of convention L: strongest; by |j|, and numbers i counted.
_STRONGEST = 1.0
_BY_J = np.array([0.6, 0.3, 0.6, 0.15, 0.2, 0.05, 0.05])
_MOST_I = 4
# 1/P_psi in SAM over 1/P_phi of the long axis: bodies whose moments are possible have less.
_SHORT_AXIS = 1.4
# Multiples of half of the two frequencies that a basis may have.
_HALVES = range(-4, 5)


class PeriodCandidate(NamedTuple):
    """Two periods in a mode.

    mode : "LAM" or "SAM"; convention : "L" for LAM, "S" for SAM, of P_phi; P_psi, P_phi : float, s;
    P_phi_long : float, s, P_phi of the long axis (convention L) in either mode; score : float;
    rank : int, of the pair of frequencies; lines : str, 2/P_phi_long and 1/P_psi in f1 and f2.
    """

    mode: str
    convention: str
    P_psi: float
    P_phi: float
    P_phi_long: float
    score: float
    rank: int
    lines: str

    def __str__(self) -> str:
        return (
            f"{self.mode} P_psi {self.P_psi / 3600.0:.6g} h, P_phi({self.convention}) "
            f"{self.P_phi / 3600.0:.6g} h, score {self.score:.3f} ({self.lines})"
        )


def ranked(
    series: Sequence[tuple[int, float, RefinedSeries]], resolution: float, count: int
) -> list[PeriodCandidate]:
    """Candidates of several series, the best first.

    Parameters
    ----------
    series : sequence of (rank, share of chi-squared left, RefinedSeries)
    resolution : float
        1/span, Hz.
    count : int
        Candidates returned at most.
    """
    found: list[PeriodCandidate] = []
    for rank, left, each in series:
        found += _of_series(rank, left, each, resolution)
    found.sort(key=lambda each: (-each.score, each.mode != "LAM"))
    kept: list[PeriodCandidate] = []
    for candidate in found:
        if all(not _same(candidate, other, resolution) for other in kept):
            kept.append(candidate)
        if len(kept) == count:
            break
    return kept


def _same(one: PeriodCandidate, other: PeriodCandidate, near: float) -> bool:
    return (
        one.mode == other.mode
        and abs(1.0 / one.P_psi - 1.0 / other.P_psi) < near
        and abs(1.0 / one.P_phi - 1.0 / other.P_phi) < near
    )


def _of_series(
    rank: int, left: float, series: RefinedSeries, resolution: float
) -> list[PeriodCandidate]:
    power = series.amplitudes**2
    power = power / power.sum()
    numbers = series.numbers
    f = series.frequencies
    strong = np.argsort(-power)[: min(4, len(power))]
    found = []
    for main in strong:
        # 2/P_phi of the long axis is one of the strongest lines
        phi = 0.5 * numbers[main].astype(float)
        if phi @ f < 0.0:
            phi = -phi
        for a in _HALVES:
            for b in _HALVES:
                psi = np.array([a, b]) / 2.0
                rate, circulation = float(psi @ f), float(phi @ f)
                if not (rate > 0.7 * resolution and abs(_area(phi, psi)) > 0.1):
                    continue
                score = (1.0 - left) * _score(numbers, power, phi, psi)
                if score <= 0.0:
                    continue
                words = f"2/P_phi(L) = {_words(2.0 * phi)}, 1/P_psi = {_words(psi)}"
                found += _in_modes(circulation, rate, score, rank, words)
    return found


def _in_modes(
    circulation: float, rate: float, score: float, rank: int, words: str
) -> list[PeriodCandidate]:
    long_axis = 1.0 / circulation
    made = [PeriodCandidate("LAM", "L", 1.0 / rate, long_axis, long_axis, score, rank, words)]
    if rate < _SHORT_AXIS * circulation:
        short = 1.0 / (circulation + rate)
        made.append(PeriodCandidate("SAM", "S", 1.0 / rate, short, long_axis, score, rank, words))
    return made


def _score(numbers: FloatArray, power: FloatArray, phi: FloatArray, psi: FloatArray) -> float:
    """The share of the power at lines of a basis, each with its weight."""
    base = np.stack([phi, psi], axis=1)
    both = np.linalg.solve(base, numbers.T.astype(float))
    whole = np.rint(both)
    fits = np.all(np.abs(both - whole) < 1e-6, axis=0)
    i, j = np.abs(whole)
    fits &= (i <= _MOST_I) & (j < len(_BY_J))
    weight = _BY_J[np.minimum(j, len(_BY_J) - 1).astype(int)] / (1.0 + 0.1 * np.maximum(i - 2, 0.0))
    weight = np.where((i == 2) & (j == 0), _STRONGEST, weight)
    return float(np.sum(np.where(fits, weight * power, 0.0)))


def _area(phi: FloatArray, psi: FloatArray) -> float:
    return float(phi[0] * psi[1] - phi[1] * psi[0])


def _words(numbers: FloatArray) -> str:
    """A combination of f1 and f2 in words."""
    parts = []
    for number, name in zip(numbers, ("f1", "f2"), strict=True):
        if number:
            size = "" if abs(number) == 1.0 else f"{abs(number):g} "
            parts.append(("- " if number < 0 else "+ ") + size + name)
    return " ".join(parts).removeprefix("+ ")
