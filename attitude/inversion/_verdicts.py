"""Whether a light curve decides the spin state, and how solutions relate to each other.

The verdicts are: solved, periods only, not solved.  A solution is accepted if its residuals are as
small as the errors (the floor), or, where errors are those of a telescope only, if it explains all
but a small part of the variance and no other periods come near.  Other solutions compete within a
difference of evidence.  A rotation about one axis is claimed only where a nutation improves the fit
by no more than chance.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from attitude.inversion import _pole_map, _refinement, _search

if TYPE_CHECKING:
    from collections.abc import Sequence

    from attitude._support.annotations import FloatArray
    from attitude.inversion._problem import CurveProblem
    from attitude.inversion._refinement import Weighted


# ---- How one spin state relates to another that fits the same light curve, in words

# Angles within which poles are related, and frequencies, turns per span.
_NEAR, _RATE = math.radians(25.0), 0.5
_SIDEREAL_DAY, _DAY = 86164.0905, 86400.0


def rates(state: FloatArray) -> tuple[float, float]:
    """Frequencies of phi of the long axis and of psi, turns per span; psi 0 for one axis."""
    twice = 2.0 * float(state[0])
    if _search.is_axial(state):
        return twice, 0.0
    nutation = abs(float(state[1]))
    return (twice - nutation if state[1] > 0.0 else twice), nutation


def plane_of(problem: CurveProblem) -> FloatArray:
    """The normal (3,) of the plane in which Sun and observer lie, seen from the body."""
    both = np.concatenate([problem.sun, problem.observer], axis=1)
    found: FloatArray = np.linalg.eigh(both @ both.T)[1][:, 0]
    return found


def relation(state: FloatArray, best: FloatArray, problem: CurveProblem) -> str:
    """The relation of a state to the best one: of modes, periods and poles.

    Shapes: state, best (WIDTH,).
    """
    words = []
    if _search.is_axial(state) != _search.is_axial(best):
        words.append("rotation about one axis" if _search.is_axial(state) else "tumbling")
    elif not (_search.has_rates(state, best) or _sees_one_turn(state, best, problem)):
        words.append(_of_rates(state, best, problem.span))
    if state is best:
        return "best"
    words.append(_of_poles(_search.pole(state), _search.pole(best), plane_of(problem)))
    return ", ".join(words)


def _sees_one_turn(state: FloatArray, best: FloatArray, problem: CurveProblem) -> bool:
    return _search.is_axial(best) and _pole_map.has_turn(problem, state, best)


def _of_rates(state: FloatArray, best: FloatArray, span: float) -> str:
    (phi, psi), (phi0, psi0) = rates(state), rates(best)
    same_phi, same_psi = abs(phi - phi0) < _RATE, abs(psi - psi0) < _RATE
    other = (state[1] > 0.0) != (best[1] > 0.0)
    if other and 2.0 * abs(state[0] - best[0]) < _RATE and same_psi:
        return "other mode of the same lines"
    prefix = "other mode, " if other else ""
    both = (("phi", phi, phi0), ("psi", psi, psi0))
    # about one axis nothing turns at psi
    named = both if psi or psi0 else both[:1]
    for day in (span / _DAY, span / _SIDEREAL_DAY):
        for name, a, b in named:
            if abs(abs(a - b) - day) < _RATE:
                return f"{prefix}one cycle a day in {name}"
    for name, a, b in named:
        if abs(a - 2.0 * b) < _RATE:
            return f"{prefix}half the period of {name}"
        if abs(2.0 * a - b) < _RATE:
            return f"{prefix}twice the period of {name}"
    if same_phi or same_psi:
        return f"{prefix}other period of {'psi' if same_phi else 'phi'}"
    if abs(phi + psi - phi0 - psi0) < _RATE:
        return f"{prefix}same period of the short axis"
    return f"{prefix}other periods"


def mirrored(pole: FloatArray, normal: FloatArray) -> FloatArray:
    """The pole (3,) of the mirror image of a rotating body in the plane of a normal (3,).

    Directions in that plane see both alike.  Angular momentum is an axial vector: its part along
    the plane changes sign, so that the longitude from the plane's axis changes by half a turn.
    """
    found: FloatArray = 2.0 * (pole @ normal) * normal - pole
    return found


def _of_poles(pole: FloatArray, best: FloatArray, normal: FloatArray) -> str:
    mirror = mirrored(best, normal)
    near = math.cos(_NEAR)
    if pole @ best > near:
        return "same pole"
    for name, other in (
        ("mirror pole", mirror),
        ("antipode", -best),
        ("antipode of the mirror pole", -mirror),
    ):
        if pole @ other > near:
            return name
    return "other pole"


SOLVED, PERIODS, OPEN = "solved", "periods only", "not solved"
# Differences of evidence within which other periods, and other poles, compete.
COMPETING, COMPETING_POLES = 13.0, 12.0
# Least number of turns of each period.
_LEAST_TURNS = 1.2
# Parameters of a nutation; the least rho (the tangent of half the tilt of the axis) of one that is
# no wobble about the axis; how often chance explains a better fit.
_NUTATION, _WIDE, _BY_CHANCE = 4, 0.08, 0.1
# Of the iteration for what chance explains.
_STEPS = 40


def verdict(
    found: Sequence[Weighted],
    problem: CurveProblem,
    is_complete: bool = True,
    most: float = _search.SAME_RATE,
) -> tuple[str, str]:
    """The verdict and its criterion in words.

    A search that is not complete has not seen what competes: its best solution is not solved.
    `most`, turns per span, is the largest frequency of the search.
    """
    if not found:
        return OPEN, "No solution was found."
    best = found[0]
    state = best.refined.state
    floor = _refinement.floor_ratio(best, problem)
    left = _refinement.share_left(best, problem)
    others = [each for each in found[1:] if not _is_motion_of(each.refined.state, state, problem)]
    gap = min((each.evidence - best.evidence for each in others), default=math.inf)
    poles = [
        each
        for each in found[1:]
        if _has_periods(each.refined.state, state, problem)
        and each.evidence - best.evidence < COMPETING_POLES
    ]
    needed = COMPETING if floor < _refinement.FLOOR else _search.ALONE
    words = (
        f"chi2/N is {floor:.2f} with errors of sigma and {_refinement.FLOOR_ERROR:g} mag (floor "
        f"{_refinement.FLOOR:g}); {100.0 * left:.1f} % of the variance is left; the next periods "
        "are "
        f"{gap:.1f} behind in -2 ln(evidence) ({needed:g} needed)"
    )
    accepted = (floor < _refinement.FLOOR or left < _search.LEFT) and gap > needed
    turns = abs(float(state[0]))
    if not _search.is_axial(state):
        turns = min(turns, abs(float(state[1])))
    if not is_complete:
        return OPEN, f"The time ended before all periods were tried; give a larger budget. {words}."
    if not accepted or turns < _LEAST_TURNS:
        return OPEN, words + "."
    if _search.is_axial(state):
        tumbling = [each for each in found[1:] if not _search.is_axial(each.refined.state)]
        close = sum(each.evidence - best.evidence < needed for each in tumbling)
        better = _better_by_nutation(found, problem, needed, most)
        if better:
            return OPEN, f"{words}; {better}."
        if close:
            return PERIODS, f"{words}; {close} tumbling states with this period lie within them."
    if poles:
        return PERIODS, f"{words}; {len(poles)} other poles lie within {COMPETING_POLES:g}."
    return SOLVED, f"{words}; no other pole lies within {COMPETING_POLES:g}."


def _better_by_nutation(
    found: Sequence[Weighted], problem: CurveProblem, needed: float, most: float
) -> str:
    """In words: a tumbling state that fits better than the best one, a rotation about one axis.

    Evidence counts ln N for each parameter of a nutation, and odds against it.  Where these alone
    put the rotation about one axis in front, and the likelihood of a wide nutation is higher than
    by chance among the frequencies tried, a claim would rest on the prior.
    """
    best = found[0]
    counted = _NUTATION * math.log(len(problem)) + 2.0 * math.log(most / _search.TUMBLERS)
    gains = [
        _refinement.gain(each, best, problem)
        for each in found[1:]
        if not _search.is_axial(each.refined.state)
        and each.refined.state[3] > math.log(_WIDE)
        and each.evidence - best.evidence < needed + counted
    ]
    chance = exceeded_by_chance(_BY_CHANCE * min(1.0, _search.SAME_RATE / most))
    if max(gains, default=0.0) < chance:
        return ""
    return (
        f"a tumbling state fits better by {max(gains):.1f} in -2 ln(likelihood), more than the "
        f"{chance:.1f} of chance"
    )


def _has_periods(state: FloatArray, best: FloatArray, problem: CurveProblem) -> bool:
    """Whether two states have the same periods; about one axis, as the scene sees them."""
    if _search.is_axial(state) and _search.is_axial(best):
        return _pole_map.has_turn(problem, state, best)
    return _search.has_rates(state, best)


def _is_motion_of(state: FloatArray, best: FloatArray, problem: CurveProblem) -> bool:
    """Whether a state has the rates of the best one, or adds a nutation to its one axis."""
    if _search.is_axial(best) and not _search.is_axial(state):
        return True
    return _has_periods(state, best, problem)


def exceeded_by_chance(probability: float) -> float:
    """What chi-squared of four degrees of freedom, those of a nutation, exceeds so often.

    p = (1 + h) exp(-h), h half of it, by an iteration that gains a digit a step for p <= 0.1;
    scipy.special would take 0.2 s to import.
    """
    half = 0.0
    for _ in range(_STEPS):
        half = math.log1p(half) - math.log(probability)
    return 2.0 * half
