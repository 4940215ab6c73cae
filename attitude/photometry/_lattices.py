"""Lattices of lines: what two frequencies of a light curve may be as periods of a tumbler.

A light curve has lines at |i/P_phi + j/P_psi|, so that its lattice of lines has many bases: the
candidates (P_psi, P_phi) of a pair of frequencies.  They are ranked by how the powers of the lines
resemble those of tumbling bodies: `_POWERS` has the mean share of each line over random convex
bodies in either mode (benchmarks/photometry.py lines), some bodies have one dominant line, and the
score is the sum of sqrt(share of the curve x share expected), from 0 to 1, times the share of the
variance that the series explains.  Of i/P_phi + j/P_psi in L the strongest lines are (2, 2), (1, 0)
and (2, 0) in LAM, (1, 1), (2, 2) and (2, 0) in SAM; (i, i) is i/P_phi of convention S.

What remains open: one cycle a day at one site, the mode, and bodies unlike the mean;
`attitude.inversion.spin_states` decides where the geometry allows it.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from attitude._support import quantity_text
from attitude._support.arrays import distinct

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Sequence

    from attitude._support.annotations import FloatArray
    from attitude.photometry._spectrum import RefinedSeries


# Mean share of the power of the line i/P_phi + j/P_psi of convention L, by (i, j).
_POWERS = {
    "LAM": {
        **{(1, 0): 0.35, (2, 0): 0.28, (2, 2): 0.26, (1, 2): 0.06, (0, 2): 0.017, (3, 0): 0.003},
        **{(4, 0): 0.003, (3, 3): 0.003, (4, 4): 0.002, (1, -2): 0.002, (2, 3): 0.002},
    },
    "SAM": {
        **{(1, 1): 0.54, (2, 0): 0.25, (2, 2): 0.15, (0, 2): 0.015, (1, -1): 0.008, (1, 3): 0.007},
        **{(3, 3): 0.003, (3, 0): 0.003, (3, 1): 0.003, (4, 0): 0.002, (2, -1): 0.002},
    },
}
# Lines that dominate the light curves of some bodies, and the weight of such a body; the dominant
# share, of which the rest is distributed as the mean.
_DOMINANT = (((2, 0), 1.0), ((2, 2), 0.95), ((1, 0), 0.85), ((1, 1), 0.85))
_SHARE = 0.85
# Share of any other line; lines that the strongest ones may be; strongest lines that are tried.
_OTHER = 0.001
_ROLES = ((2, 0), (2, 2), (1, 0), (1, 1))
_TRIED = 4
# 1/P_psi in SAM over 1/P_phi of the long axis: bodies whose moments are possible have less.
SHORT_AXIS = 1.4
# Multiples of half of the two frequencies that a basis may have.
_HALVES = range(-4, 5)


class PeriodCandidate(NamedTuple):
    """Two periods in a mode.

    mode : "LAM" or "SAM"; convention : "L" for LAM, "S" for SAM, of P_phi; P_psi, P_phi : float, s;
    P_phi_long : float, s, P_phi of the long axis (convention L) in either mode; score : float;
    rank : int, of the pair of frequencies; lines : str, 1/P_phi_long and 1/P_psi in f1 and f2.
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
            f"{self.mode} P_psi {quantity_text.of_time(self.P_psi)}, P_phi({self.convention}) "
            f"{quantity_text.of_time(self.P_phi)}, score {self.score:.3f} ({self.lines})"
        )


def ranked(
    series: Sequence[tuple[int, float, RefinedSeries]], resolution: float, count: int
) -> list[PeriodCandidate]:
    """Candidates of several series, the best first."""
    candidates: list[PeriodCandidate] = []
    for rank, left, frequencies in series:
        candidates += _of_series(rank, left, frequencies, resolution)
    candidates.sort(key=lambda candidate: (-candidate.score, candidate.mode != "LAM"))
    most = count if count > 0 else math.inf

    def are_one(one: PeriodCandidate, other: PeriodCandidate) -> bool:
        return (
            one.mode == other.mode
            and abs(1.0 / one.P_psi - 1.0 / other.P_psi) < resolution
            and abs(1.0 / one.P_phi - 1.0 / other.P_phi) < resolution
        )

    return distinct(candidates, are_one, most)


def _of_series(rank, left, series, resolution):
    power = series.amplitudes**2
    power = power / power.sum()
    f = series.frequencies
    candidates = []
    seen = set()
    for main in np.argsort(-power)[:_TRIED]:
        for a in _HALVES:
            for b in _HALVES:
                psi = np.array([a, b]) / 2.0
                if not psi @ f > 0.7 * resolution:
                    continue
                for sign in (1.0, -1.0):
                    for i, j in _ROLES:
                        phi = (sign * series.numbers[main] - j * psi) / i
                        key = (*phi, *psi)
                        if key in seen or not phi @ f > 0.7 * resolution:
                            continue
                        seen.add(key)
                        candidates += _in_modes(series, power, phi, psi, 1.0 - left, rank)
    return candidates


def _in_modes(series, power, phi, psi, explained, rank):
    """The candidates of a basis: phi and psi are 1/P_phi of convention L and 1/P_psi in f1, f2."""
    determinant = phi[0] * psi[1] - phi[1] * psi[0]
    if abs(determinant) < 0.1:
        return []
    rate, circulation = float(psi @ series.frequencies), float(phi @ series.frequencies)
    n = series.numbers
    i = (n[:, 0] * psi[1] - n[:, 1] * psi[0]) / determinant
    j = (phi[0] * n[:, 1] - phi[1] * n[:, 0]) / determinant
    j = np.where((i < -1e-9) | ((np.abs(i) < 1e-9) & (j < 0.0)), -j, j)
    i = np.abs(i)
    is_line = (np.abs(i - np.rint(i)) < 1e-6) & (np.abs(j - np.rint(j)) < 1e-6)
    places = [
        (int(a), int(b)) if fits else None
        for a, b, fits in zip(np.rint(i), np.rint(j), is_line, strict=True)
    ]
    words = f"1/P_phi(L) = {_words(phi)}, 1/P_psi = {_words(psi)}"
    short = 1.0 / (circulation + rate)
    modes = []
    for mode, convention, period in (("LAM", "L", 1.0 / circulation), ("SAM", "S", short)):
        if mode == "SAM" and not rate < SHORT_AXIS * circulation:
            continue
        score = explained * _likeness(power, places, _POWERS[mode])
        modes.append(
            PeriodCandidate(
                mode, convention, 1.0 / rate, period, 1.0 / circulation, score, rank, words
            )
        )
    return modes


def _likeness(power, places, mean):
    """How lines resemble those of the mean body, or of one that has a dominant line."""
    expected = np.array([0.0 if one is None else mean.get(one, _OTHER) for one in places])
    likeness = float(np.sum(np.sqrt(power * expected)))
    for line, weight in _DOMINANT:
        if mean.get(line, 0.0) > _OTHER:
            strong = np.array([float(one == line) for one in places])
            mixed = (1.0 - _SHARE) * expected + _SHARE * strong
            likeness = max(likeness, weight * float(np.sum(np.sqrt(power * mixed))))
    return likeness


def _words(numbers: FloatArray) -> str:
    """A combination of f1 and f2 in words."""
    return _summed(numbers, lambda size, name: name if size == 1.0 else f"{size:g} {name}")


def _summed(numbers: Iterable[float], term: Callable[[Any, str], str]) -> str:
    """A sum of multiples of f1 and f2; `term` spells one of them, without its sign."""
    terms = [
        ("- " if number < 0 else "+ ") + term(abs(number), name)
        for number, name in zip(numbers, ("f1", "f2"), strict=True)
        if number
    ]
    return " ".join(terms).removeprefix("+ ")


# ---- How one lattice follows from another, in words

# Pairs of halves with which one lattice of lines follows from another, the simplest first.
_COMBINATIONS = sorted(
    ((a, b) for a in range(-4, 5) for b in range(-4, 5) if 0 < abs(a) + abs(b) <= 6),
    key=lambda pair: (pair[0] % 2 + pair[1] % 2, abs(pair[0]) + abs(pair[1])),
)


def same_lattice(f: FloatArray, base: FloatArray, tolerance: float) -> str:
    """Both frequencies as sums of small whole or half numbers of two others, in words, or ""."""
    choices = [
        [
            (a, b)
            for a, b in _COMBINATIONS
            if abs(0.5 * (a * base[0] + b * base[1]) - wanted) < tolerance
        ]
        for wanted in f
    ]
    for one in choices[0]:
        for other in choices[1]:
            if one[0] * other[1] != one[1] * other[0]:
                return f"{spelled(*one)} and {spelled(*other)}"
    return ""


def spelled(a: int, b: int) -> str:
    """Halves of whole numbers of f1 and f2: (2, -1) is "f1 - f2/2"."""

    def term(halves: int, name: str) -> str:
        size, end = (halves, "/2") if halves % 2 else (halves // 2, "")
        return f"{name}{end}" if size == 1 else f"{size} {name}{end}"

    return _summed((a, b), term)
