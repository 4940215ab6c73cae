"""Whether a light curve decides the spin state: solved, periods only, or not solved.

A solution is accepted if its residuals are as small as the errors (the floor), or, where errors are
those of a telescope only, if it explains all but a small part of the variance and no other periods
come near.  Other solutions compete within a difference of evidence.  A rotation about one axis is
claimed only where a nutation improves the fit by no more than chance.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from attitude.inversion import pole_map, robust, search

if TYPE_CHECKING:
    from collections.abc import Sequence

    from attitude.annotations import FloatArray
    from attitude.inversion.problem import CurveProblem
    from attitude.inversion.robust import Weighted

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
    most: float = search.SAME_RATE,
) -> tuple[str, str]:
    """The verdict and its criterion in words.

    A search that is not complete has not seen what competes: its best solution is not solved.
    `most`, turns per span, is the largest frequency of the search.
    """
    if not found:
        return OPEN, "No solution was found."
    best = found[0]
    state = best.refined.state
    floor = robust.floor_ratio(best, problem)
    left = robust.share_left(best, problem)
    others = [each for each in found[1:] if not _is_motion_of(each.refined.state, state, problem)]
    gap = min((each.evidence - best.evidence for each in others), default=math.inf)
    poles = [
        each
        for each in found[1:]
        if _has_periods(each.refined.state, state, problem)
        and each.evidence - best.evidence < COMPETING_POLES
    ]
    needed = COMPETING if floor < robust.FLOOR else search.ALONE
    words = (
        f"chi2/N is {floor:.2f} with errors of sigma and {robust.FLOOR_ERROR:g} mag (floor "
        f"{robust.FLOOR:g}); {100.0 * left:.1f} % of the variance is left; the next periods are "
        f"{gap:.1f} behind in -2 ln(evidence) ({needed:g} needed)"
    )
    accepted = (floor < robust.FLOOR or left < search.LEFT) and gap > needed
    turns = abs(float(state[0]))
    if not search.is_axial(state):
        turns = min(turns, abs(float(state[1])))
    if not is_complete:
        return OPEN, f"The time ended before all periods were tried; give a larger budget. {words}."
    if not accepted or turns < _LEAST_TURNS:
        return OPEN, words + "."
    if search.is_axial(state):
        tumbling = [each for each in found[1:] if not search.is_axial(each.refined.state)]
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
    counted = _NUTATION * math.log(len(problem)) + 2.0 * math.log(most / search.TUMBLERS)
    gains = [
        robust.gain(each, best, problem)
        for each in found[1:]
        if not search.is_axial(each.refined.state)
        and each.refined.state[3] > math.log(_WIDE)
        and each.evidence - best.evidence < needed + counted
    ]
    chance = exceeded_by_chance(_BY_CHANCE * min(1.0, search.SAME_RATE / most))
    if max(gains, default=0.0) < chance:
        return ""
    return (
        f"a tumbling state fits better by {max(gains):.1f} in -2 ln(likelihood), more than the "
        f"{chance:.1f} of chance"
    )


def _has_periods(state: FloatArray, best: FloatArray, problem: CurveProblem) -> bool:
    """Whether two states have the same periods; about one axis, as the scene sees them."""
    if search.is_axial(state) and search.is_axial(best):
        return pole_map.has_turn(problem, state, best)
    return search.has_rates(state, best)


def _is_motion_of(state: FloatArray, best: FloatArray, problem: CurveProblem) -> bool:
    """Whether a state has the rates of the best one, or adds a nutation to its one axis."""
    if search.is_axial(best) and not search.is_axial(state):
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
