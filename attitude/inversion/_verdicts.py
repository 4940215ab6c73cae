"""Whether a light curve decides the spin state, and how solutions relate to each other.

The verdicts are: solved, periods only, not solved.  A solution is accepted if its residuals are as
small as the errors (the floor), or, where errors are those of a telescope only, if it explains all
but a small part of the variance and no other periods come near.  Other solutions compete within a
difference of evidence.  A rotation about one axis is claimed only where a nutation improves the fit
by no more than chance, and a wide one would improve it by more; solved, where one of 18 degrees
would.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from attitude._support import quantity_text
from attitude._support.constants import DAY_S, SIDEREAL_DAY_S
from attitude.inversion import _ellipsoid, _evidence, _pole_map
from attitude.inversion._ellipsoid import SearchState, is_axial

if TYPE_CHECKING:
    from collections.abc import Sequence

    from attitude._support.annotations import FloatArray
    from attitude.inversion._evidence import Robust
    from attitude.inversion._problem import CurveProblem
    from attitude.inversion._satellites import AdditivePair
    from attitude.inversion._settings import Settings, Tally


# ---- How one spin state relates to another that fits the same light curve, in words

# Angle, rad, within which poles are related.
_NEAR = math.radians(25.0)
# Difference of frequencies, turns per span, within which they are.
_RATE = 0.5


def relation(
    state: FloatArray, best: FloatArray, problem: CurveProblem, length: float = 0.0
) -> str:
    """The relation of a state (WIDTH,) to the best one: of modes, periods and poles.

    `length`, spans, from one apparition to another one with which it was joined; numbers of turns
    between them are named then.
    """
    if state is best:
        return "best"
    words = []
    if is_axial(state) != is_axial(best):
        words.append("rotation about one axis" if is_axial(state) else "tumbling")
    elif not (_has_rates(state, best, problem) or _has_periods(state, best, problem)):
        turns = _of_turns(state, best, length)
        words.append(turns or _of_rates(state, best, problem.span))
    poles = SearchState.of(state).pole, SearchState.of(best).pole
    words.append(_of_poles(*poles, _pole_map.plane_of(problem)))
    return ", ".join(words)


def _of_turns(state: FloatArray, best: FloatArray, length: float) -> str:
    """By how many turns the states differ between two apparitions; "" without any, or modes."""
    fields, fields_of_best = SearchState.of(state), SearchState.of(best)
    if not length or (fields.nutation > 0.0) != (fields_of_best.nutation > 0.0):
        return ""
    pairs = zip(fields.rates, fields_of_best.rates, strict=True)
    phi, psi = (0.5 * round(2.0 * length * (a - b)) for a, b in pairs)
    return f"{phi:+g} turns of phi, {psi:+g} of psi between the apparitions"


def _of_rates(state: FloatArray, best: FloatArray, span: float) -> str:
    fields, fields_of_best = SearchState.of(state), SearchState.of(best)
    (phi, psi), (phi0, psi0) = fields.rates, fields_of_best.rates
    same_phi, same_psi = abs(phi - phi0) < _RATE, abs(psi - psi0) < _RATE
    other = (fields.nutation > 0.0) != (fields_of_best.nutation > 0.0)
    apart = 2.0 * abs(fields.precession - fields_of_best.precession)
    if other and apart < _RATE and same_psi:
        return "other mode of the same lines"
    prefix = "other mode, " if other else ""
    both = (("phi", phi, phi0), ("psi", psi, psi0))
    # about one axis nothing turns at psi
    named = both if psi or psi0 else both[:1]
    for day in (span / DAY_S, span / SIDEREAL_DAY_S):
        for name, a, b in named:
            if abs(abs(a - b) - day) < _RATE:
                return f"{prefix}one cycle a day in {name}"
    for name, a, b in named:
        if abs(a - 2.0 * b) < _RATE:
            return f"{prefix}half the period of {name}"
        if abs(2.0 * a - b) < _RATE:
            return f"{prefix}twice the period of {name}"
    if same_phi and len(named) == 1:
        return "other number of turns"
    if same_phi or same_psi:
        return f"{prefix}other period of {'psi' if same_phi else 'phi'}"
    if abs(phi + psi - phi0 - psi0) < _RATE:
        return f"{prefix}same period of the short axis"
    return f"{prefix}other periods"


def _of_poles(pole: FloatArray, best: FloatArray, normal: FloatArray) -> str:
    mirror = _pole_map.mirrored(best, normal)
    least_cosine = math.cos(_NEAR)
    if pole @ best > least_cosine:
        return "same pole"
    for name, other in (
        ("mirror pole", mirror),
        ("antipode", -best),
        ("antipode of the mirror pole", -mirror),
    ):
        if pole @ other > least_cosine:
            return name
    return "other pole"


# ---- Tumbling states that have no line which a rotation about one axis has not

# Multiples of half a rotation that the rates of a comb are.
_COMB = 6


def as_rotators(solutions: list[Robust], problem: CurveProblem) -> list[Robust]:
    """The solutions, where tumbling states whose lines form a rotator's comb stand behind it.

    Where both rates are multiples of one frequency within the accuracy of lines, tumbling has no
    line that a rotation about one axis has not: four parameters more fit what its shape lacks.
    It counts as that rotation, if chi-squared of this is not far larger, and unless a tumbling
    state of the same rates about another pole, which is on no comb, is ahead of it: the resolution
    decides on rates, not on poles.
    """
    behind = [
        [rotator.evidence for rotator in solutions if counts_as(one, rotator, problem)]
        for one in solutions
    ]
    alone = [one for one, rotators in zip(solutions, behind, strict=True) if not rotators]
    out = []
    for one, rotators in zip(solutions, behind, strict=True):
        state, least = one.refined.state, _evidence.behind(max(rotators, default=-math.inf))
        is_held = least > one.evidence and not any(
            other.evidence < least and _has_rates(other.refined.state, state, problem)
            for other in alone
        )
        out.append(_evidence.at_least(one, least) if is_held else one)
    return out


def counts_as(one: Robust, rotator: Robust, problem: CurveProblem) -> bool:
    """Whether a tumbling state is on the comb of a rotator that explains the curve too.

    It does not, if its residuals alone are above the errors, and its likelihood is far less.
    """
    settings = problem.settings
    state, other = SearchState.of(one.refined.state), SearchState.of(rotator.refined.state)
    if not other.is_axial or state.is_axial or not _is_comb(state, other, problem):
        return False
    if rotator.chi_squared > settings.axial_worse * one.chi_squared:
        return False
    floor, of_rotator = (_evidence.floor_ratio(either, problem) for either in (one, rotator))
    is_at_floor_alone = floor < settings.floor < of_rotator
    return not (is_at_floor_alone and _evidence.gain(one, rotator, problem) > settings.alone)


def _is_comb(state: SearchState, rotator: SearchState, problem: CurveProblem) -> bool:
    """Whether the lines of a tumbling state are multiples of a rotation, psi also of half of it.

    Half a turn about its axis leaves an ellipsoid as it is, half a turn about the momentum does
    not.  Lines are those that the scene sees: it turns about the momentum, not about the long axis.
    The resolution is that of a line of the rotation and one of the tumbling state; the two lines of
    this that are one in the comb are measured together, which is more accurate.
    """
    turns = _pole_map.turn_of_scene(problem, np.stack([state.pole, rotator.pole]))
    phi, psi = state.rates
    phi -= float(turns[0])
    base = rotator.precession - 0.5 * float(turns[1])
    of_phi, of_psi = round(phi / base), round(psi / base)
    if of_phi % 2 or not (1 <= of_phi <= _COMB and 1 <= of_psi <= _COMB):
        return False
    apart = abs(phi * of_psi - psi * of_phi) / math.gcd(of_phi, of_psi)
    off = max(abs(phi - of_phi * base), abs(psi - of_psi * base))
    return apart < problem.settings.same_rate and off < problem.settings.comb_width


# ---- Rotations about one axis that leave correlated residuals


def behind_correlated(solutions: list[Robust], problem: CurveProblem) -> list[Robust]:
    """The solutions, where tumbling states lose what correlated residuals of a rotation give them.

    If the rotation is ahead without that; else none changes, for what of it is a nutation is open.
    """
    axial = [one for one in solutions if is_axial(one.refined.state)]
    if not axial:
        return solutions
    rotator = _evidence.ranked(axial)[0]
    counted = [
        one
        if is_axial(one.refined.state)
        else _evidence.with_term(one, correlated_gain(one, rotator, problem))
        for one in solutions
    ]
    return counted if is_axial(_evidence.ranked(counted)[0].refined.state) else solutions


def correlated_gain(one: Robust, rotator: Robust, problem: CurveProblem) -> float:
    """By how much a tumbling state fits better than a rotation, since residuals are correlated.

    Where so many points count as one, chance explains so many times as much.  The rotation leaves
    no more than the errors: above them a nutation correlates residuals.
    """
    if _evidence.floor_ratio(rotator, problem) >= problem.settings.floor:
        return 0.0
    share = 1.0 - 1.0 / _evidence.redundancy(rotator, problem)
    return share * max(0.0, _evidence.gain(one, rotator, problem))


# ---- Rotations with one maximum a turn


def behind_twice_the_period(solutions: list[Robust], problem: CurveProblem) -> list[Robust]:
    """The solutions, where one maximum a turn stands behind two, if these fit as well.

    Few bodies have one, and it is ahead by evidence alone: half of a curve says less of a shape.
    """
    axial = [one for one in solutions if is_axial(one.refined.state)]
    best = next(iter(_evidence.ranked(axial)), None)
    doubled = [
        one.evidence
        for one in axial
        if best
        and _is_half_of(best, one, problem)
        and _evidence.gain(best, one, problem) < problem.settings.doubled
    ]
    if best is None or not doubled or not has_one_maximum(best, problem):
        return solutions
    more = _evidence.behind(min(doubled)) - best.evidence
    return [
        _evidence.with_term(one, more)
        if is_axial(one.refined.state)
        and _pole_map.has_turn(problem, one.refined.state, best.refined.state)
        else one
        for one in solutions
    ]


# ---- The verdict

SOLVED = "solved"
PERIODS = "periods only"
OPEN = "not solved"
SATELLITE = "a satellite of period"
# Parameters of a nutation.
_NUTATION = 4
# Degrees from which an error of the pole says nothing.
_WHOLE_SKY = 180.0
# Ratios of two frequencies of which one may be taken for the other.
_LIKE = np.array([0.5, 1.0, 2.0])
# Of the iteration for what chance explains.
_STEPS = 40


def ended_by(verdict: str, tally: Tally) -> str:
    """A sentence on the budget, where it and not the data ended a search; else ""."""
    is_ended = verdict == OPEN and tally.is_over
    return f" The budget of {tally.budget:g} s ended the search." if is_ended else ""


def ahead_by(ahead: float) -> str:
    """By how much evidence is ahead of another one, or behind, in words."""
    return f"{abs(ahead):.1f} {'ahead of' if ahead > 0.0 else 'behind'}"


def with_verb(number: int, noun: str, verb: str) -> str:
    """A number of things and what they do, in words.

    >>> with_verb(1, "other pole", "lie"), with_verb(2, "other pole", "lie")
    ('1 other pole lies', '2 other poles lie')
    """
    return f"{quantity_text.counted(number, noun)} {verb}{'s' if number == 1 else ''}"


def of_floor(ratio: float, most: float, settings: Settings) -> str:
    """The ratio of the residuals to the errors of the floor, in words."""
    errors = f"errors of sigma and {settings.floor_error:g} mag"
    return f"chi2/N is {ratio:.2f} with {errors} (floor {most:g})"


def _of_left(left: float, floor: float, settings: Settings) -> str:
    """The share of the variance that is left, and where it decides, what may be, in words."""
    most = f" ({100.0 * settings.left:g} allowed above the floor)"
    return f"{100.0 * left:.1f} % of the variance is left{most if floor >= settings.floor else ''}"


def is_doubtful(best: Robust, problem: CurveProblem) -> bool:
    """Whether a solution hardly fits: differences of evidence are then those of a wrong model."""
    return _evidence.floor_ratio(best, problem) > problem.settings.doubtful


def needed(best: Robust, problem: CurveProblem) -> float:
    """By how much other periods have to lie behind a solution in evidence, at least."""
    settings, state = problem.settings, SearchState.of(best.refined.state)
    is_at_floor = _evidence.floor_ratio(best, problem) < settings.floor
    is_slow = not state.is_axial and min(state.rates) < settings.few_turns
    is_strained = not state.is_axial and best.refined.strain > settings.strained
    is_rough = not state.is_axial and is_doubtful(best, problem)
    needs_more = is_slow or is_strained or is_rough or not is_at_floor
    return settings.alone if needs_more else settings.competing


def _nearest(others: Sequence[Robust], best: Robust, problem: CurveProblem) -> tuple[float, float]:
    """How far other periods lie behind the best solution, and how far they have to.

    Of those with the least margin.  A difference that few nights make is no evidence: it has to be
    so many of its standard errors between nights, but no more than where the model errs.  Half a
    period needs as much where its curve has one maximum: any simple shape fits half of two alike.
    What the tie of moments and shape takes from a tumbling state that another one keeps is none: a
    concave body strains it, and true periods of one lay 39.6 behind, most of it by their strain.
    Nor is what a rotation about the long axis, which bodies leave, gains by its shape over one
    about the short axis: with a nutation of 1.3 degrees such a one was 25.5 ahead of a true one.
    """
    settings, least = problem.settings, needed(best, problem)
    margins = []
    for other in others:
        wide = settings.pole_errors * _evidence.standard_error(best, other, problem)
        if _is_half_of(best, other, problem) and has_one_maximum(best, problem):
            wide = settings.alone
        more = 0.0
        if not is_axial(best.refined.state):
            if is_axial(other.refined.state):
                more = settings.against_axis + correlated_gain(best, other, problem)
                wide = settings.alone if _spins_about_long_axis(best, settings) else wide
            more += max(0.0, other.refined.strain - best.refined.strain)
        behind = max(least + more, min(wide, settings.alone))
        gap = other.evidence - best.evidence
        margins.append((gap - behind, gap, behind))
    return min(margins)[1:] if margins else (math.inf, least)


def _spins_about_long_axis(one: Robust, settings: Settings) -> bool:
    """Whether a tumbling state is a rotation about the long axis with a nutation that is small."""
    state = SearchState.of(one.refined.state)
    return state.nutation > 0.0 and state.log_rho < math.log(settings.wide)


def _is_half_of(best: Robust, other: Robust, problem: CurveProblem) -> bool:
    """Whether a rotation about one axis has half the period of another one, as the scene sees."""
    states = [SearchState.of(one.refined.state) for one in (best, other)]
    if not all(state.is_axial for state in states):
        return False
    turns = _pole_map.turn_of_scene(problem, np.stack([state.pole for state in states]))
    rate, half = (state.rates[0] - float(turn) for state, turn in zip(states, turns, strict=True))
    return abs(rate - 2.0 * half) < 2.0 * problem.settings.comb_width


def has_one_maximum(best: Robust, problem: CurveProblem) -> bool:
    """Whether the magnitudes of a rotation vary most with one maximum a turn."""
    state, magnitude = SearchState.of(best.refined.state), best.refined.magnitude
    rate = state.rates[0] - float(_pole_map.turn_of_scene(problem, state.pole[None])[0])
    angle = 2.0 * math.pi * rate * problem.t
    waves = np.stack([np.exp(1j * angle), np.exp(2j * angle)], axis=1)
    terms = np.concatenate([waves.real, waves.imag, np.ones((len(angle), 1))], axis=1)
    series = np.linalg.lstsq(terms, magnitude, rcond=None)[0]
    return bool(np.hypot(series[0], series[2]) > np.hypot(series[1], series[3]))


def _of_few_turns(fields: SearchState, least: float) -> str:
    """In words: turns of phi or psi in the span, if they are too few to tell a period."""
    phi, psi = 2.0 * abs(fields.precession), abs(fields.nutation)
    if phi < 2.0 * least:
        return f"; the span has {phi:.3g} turns of phi ({2.0 * least:g} needed)"
    if psi < least and not fields.is_axial:
        return f"; the span has {psi:.3g} turns of psi ({least:g} needed)"
    return ""


def gap(solutions: Sequence[Robust], problem: CurveProblem) -> float:
    """How far other periods, of the least margin, lie behind in evidence; infinite without any."""
    return _nearest(_of_other_periods(solutions, problem), solutions[0], problem)[0]


def _of_gap(size: float, behind: float) -> str:
    """How far other periods lie behind, and have to, in words; others may need less than these."""
    if math.isinf(size):
        return "no other periods were found"
    return (
        f"the other periods of least margin are {size:.1f} behind in -2 ln(evidence) "
        f"({behind:.4g} needed)"
    )


def _of_other_periods(solutions: Sequence[Robust], problem: CurveProblem) -> list[Robust]:
    state = solutions[0].refined.state
    return [
        other for other in solutions[1:] if not _is_motion_of(other.refined.state, state, problem)
    ]


def verdict(
    solutions: Sequence[Robust],
    problem: CurveProblem,
    is_complete: bool = True,
    most: float = 0.0,
    *,
    is_given_axis: bool = False,
    is_hidden: bool = True,
    is_interrupted: bool = False,
    is_strict: bool = False,
) -> tuple[str, str]:
    """The verdict and its criterion in words.

    A search that is not complete, since the budget ended or Ctrl-C interrupted it, has not seen
    what competes: its best solution is not solved.
    `most`, turns per span, is the largest frequency of the search; `is_given_axis`: rotation about
    one axis is not found, but given; `is_hidden`: one apparition hides concave parts of a body that
    turns about one; `is_strict`: no nutation that may be hidden is left to the words.
    """
    if not solutions:
        return OPEN, "No solution was found."
    settings, best = problem.settings, solutions[0]
    most = max(most, settings.same_rate)
    state = best.refined.state
    floor = _evidence.floor_ratio(best, problem)
    left = _evidence.share_left(best, problem)
    gap_to_next, behind = _nearest(_of_other_periods(solutions, problem), best, problem)
    alike = [one for one in solutions[1:] if _has_periods(one.refined.state, state, problem)]
    poles = [other for other in alike if _competes(other, best, problem)]
    words = f"{of_floor(floor, settings.floor, settings)}; {_of_left(left, floor, settings)}"
    words += f"; {_of_gap(gap_to_next, behind)}"
    # the dips of a moon are most of the variance: what is left says nothing of the rotation
    explains = floor < settings.floor or (left < settings.left and not problem.orbit)
    accepted = explains and gap_to_next > behind
    fields = SearchState.of(state)
    few = _of_few_turns(fields, settings.least_turns)
    if not is_complete:
        reason = "Not all periods were tried; give a larger budget."
        if is_interrupted:
            reason = "Ctrl-C ended the search before all periods were tried."
        return OPEN, f"{reason} {words}."
    if not accepted or few:
        return OPEN, f"{words}{few}."
    if not is_axial(state):
        unseen = _unseen_phases(state, problem)
        if unseen > settings.unseen:
            return OPEN, f"{words}; {100.0 * unseen:.0f} % of a period of phi or psi is not seen."
    else:
        limit, limits = _of_one_axis(solutions, problem, most)
        if limit != OPEN and not is_given_axis:
            hidden = _of_hidden([best, *poles], problem, most, is_strict=is_strict)
            if hidden[0] == OPEN or limit == SOLVED:
                limit, limits = hidden
        if limit != SOLVED:
            return limit, f"{words}; {limits}."
    errors = f"{settings.pole_errors:g} standard errors between nights"
    width, likely = _widths_of_poles(best, problem)
    within = (
        f"within {width:.4g} in -2 ln(evidence), {2.0 * width:.4g} if within {likely:.4g} in "
        f"likelihood, or {errors}"
    )
    if not poles and fields.is_axial and is_hidden:
        width = max(width, settings.axial_behind * _evidence.redundancy(best, problem))
        close_ones = [one for one in alike if one.evidence - best.evidence < width]
        poles = [other for other in close_ones if _is_other_pole(other, best, problem)]
        within = f"within {width:.4g} in -2 ln(evidence)"
    if poles:
        return PERIODS, f"{words}; {with_verb(len(poles), 'other pole', 'lie')} {within}."
    return SOLVED, f"{words}; no other pole lies {within}."


def _unseen_phases(state: FloatArray, problem: CurveProblem) -> float:
    """The largest gap between the phases of the epochs in the two periods of a tumbling state."""
    gaps = []
    for rate in SearchState.of(state).rates:
        phases = np.sort(problem.t * rate % 1.0)
        gaps.append(np.diff(phases, append=phases[0] + 1.0).max())
    return float(max(gaps))


def _widths_of_poles(best: Robust, problem: CurveProblem) -> tuple[float, float]:
    """The differences of evidence and of likelihood within which other poles compete."""
    settings, points = problem.settings, _evidence.redundancy(best, problem)
    width = settings.alone if is_doubtful(best, problem) else settings.competing_poles
    likely = settings.likely_poles[is_axial(best.refined.state)]
    return width * points, likely * points


def _competes(other: Robust, best: Robust, problem: CurveProblem) -> bool:
    """Whether another pole with the same periods competes with the best one.

    Within a difference of evidence; or, if it is no neighbour, within twice that and one of
    likelihood, since a prior of shapes alone decides on no pole, or within the standard errors
    between nights.
    """
    settings = problem.settings
    width, likely = _widths_of_poles(best, problem)
    behind = other.evidence - best.evidence
    if behind < width:
        return True
    if not _is_other_pole(other, best, problem):
        return False
    errors = settings.pole_errors * _evidence.standard_error(best, other, problem)
    fits_alike = _evidence.gain(best, other, problem) < likely
    return (behind < 2.0 * width and fits_alike) or behind < errors


def _is_other_pole(other: Robust, best: Robust, problem: CurveProblem) -> bool:
    """Whether a solution has another pole than the best one, not an error of it."""
    width = problem.settings.near_pole
    return not _ellipsoid.have_pole(other.refined.state, best.refined.state, width)


def competes(other: Robust, best: Robust, problem: CurveProblem, *, is_hidden: bool) -> bool:
    """Whether the `verdict` does not tell a solution from the best one."""
    settings, behind = problem.settings, other.evidence - best.evidence
    state, state_of_best = other.refined.state, best.refined.state
    if not _is_motion_of(state, state_of_best, problem):
        gap_to_other, least = _nearest([other], best, problem)
        return gap_to_other <= least
    if is_axial(state_of_best) and not is_axial(state):
        return _is_close(other, best, problem) and not counts_as(other, best, problem)
    is_behind_axis = is_axial(state_of_best) and is_hidden
    width = settings.axial_behind * _evidence.redundancy(best, problem) if is_behind_axis else 0.0
    is_close = behind < width and _is_other_pole(other, best, problem)
    return is_close or _competes(other, best, problem)


def of_pole(
    criterion: str, sigma: float, settings: Settings, *, is_hidden: bool
) -> tuple[str, str]:
    """The verdict and its criterion where no other pole competes: solved, if the pole is known.

    `sigma`, rad, is the standard error of the pole: some of them lie within the angle of one pole,
    more where concave parts of the body are hidden: about one axis in one apparition.
    """
    count = settings.pole_widths[is_hidden]
    if count * sigma < settings.near_pole:
        return SOLVED, criterion
    width, most = (math.degrees(angle) for angle in (count * sigma, settings.near_pole))
    size = f"{width:.3g} degrees" if width < _WHOLE_SKY else "the whole sky"
    return (
        PERIODS,
        f"{criterion[:-1]}; {count:g} standard errors of the pole are {size} ({most:.0f} at most).",
    )


def of_dips(
    verdict: tuple[str, str],
    solutions: Sequence[Robust],
    problem: CurveProblem,
    pairs: Sequence[AdditivePair],
) -> tuple[str, str]:
    """The verdict and its criterion on a tumbling body, where additive series may explain it.

    Not solved, if the residuals of the body are above the errors, and those of a rotation with dips
    in another period hardly larger, or less where the series brightens too; or at the floor, if
    both periods of the body are those of such a pair as well.
    """
    settings = problem.settings
    if verdict[0] == OPEN or not pairs or is_axial(solutions[0].refined.state):
        return verdict
    rates = SearchState.of(solutions[0].refined.state).rates
    is_at_floor = _evidence.floor_ratio(solutions[0], problem) < settings.floor
    left = _evidence.share_left(solutions[0], problem)
    alike = [
        pair
        for pair in pairs
        if pair.left < (settings.orbit_alike**2 if pair.only_dims else 1.0) * left
        and (not is_at_floor or _has_frequencies(pair, rates, settings))
    ]
    if not alike:
        return verdict
    period = problem.span / alike[0].orbit / DAY_S
    words = f"rotation with an additive series of period {period:.6g} d, as of a moon, fits as well"
    return OPEN, f"{verdict[1]} {words}."


def _has_frequencies(pair: AdditivePair, rates: tuple[float, float], settings: Settings) -> bool:
    """Whether psi turns with the orbit of a pair, twice or half, and phi with its rotation.

    Or phi with a multiple of psi: all lines of the body are then those of the orbit.  Of a series
    that brightens too only so: with both of its frequencies it fits what a concave body lacks.
    """
    phi, psi = rates
    lines = psi * _LIKE
    if pair.only_dims:
        lines = np.concatenate([lines, pair.rotation * _LIKE])
    return bool(
        np.abs(psi - pair.orbit * _LIKE).min() < settings.comb_width
        and np.abs(phi - lines).min() < settings.comb_width
    )


def of_satellite(
    verdict: tuple[str, str], period: float, ahead: float, needed: float
) -> tuple[str, str]:
    """The verdict and its criterion where a rotation about one axis beside an orbit competes.

    `period` of the orbit, days; `ahead`: by how much its evidence is better than that of the best
    body without one, and `needed`, by how much it has to be.
    """
    rival = (
        f"rotation about one axis with an additive series of period {period:.6g} d, as of a moon"
    )
    if ahead > needed:
        words = f"{rival} is {ahead:.1f} ahead of every body alone; of the rotation: {verdict[1]}"
        rotation = f", the rotation {OPEN}" if verdict[0] == OPEN else ""
        return f"{SATELLITE} {period:.6g} d{rotation}", words
    if ahead > -needed:
        words = f"{rival} is {ahead_by(ahead)} the best body alone ({needed:g} needed)."
        return OPEN, f"{words} {verdict[1]}"
    return verdict


def _of_one_axis(
    solutions: Sequence[Robust], problem: CurveProblem, most: float
) -> tuple[str, str]:
    """How far tumbling states limit the verdict on a rotation about one axis, in words.

    Solved, if they do not.
    """
    best = solutions[0]
    tumbling = [
        other
        for other in solutions[1:]
        if not is_axial(other.refined.state) and not counts_as(other, best, problem)
    ]
    least = needed(best, problem)
    better = _better_by_nutation([best, *tumbling], problem, least, most)
    if better:
        return OPEN, better
    close = [other for other in tumbling if _is_close(other, best, problem)]
    if not close:
        return SOLVED, ""
    tumblers = f"{with_verb(len(close), 'tumbling state', 'lie')} within {least:.3g}"
    if not all(_keeps_period(other, best, problem) for other in close):
        return OPEN, f"{tumblers}, with other periods"
    return PERIODS, f"{tumblers}, with this period"


def _is_close(other: Robust, best: Robust, problem: CurveProblem) -> bool:
    """Whether a tumbling state competes in evidence with a rotation about one axis.

    With other periods only if its fit is better by more than its parameters explain by chance.
    """
    if other.evidence - best.evidence >= needed(best, problem):
        return False
    gained = _gained(other, best, problem)
    return gained > _NUTATION or _keeps_period(other, best, problem)


def _gained(other: Robust, best: Robust, problem: CurveProblem) -> float:
    """By how much a tumbling state fits better than a rotation, less what correlation gives it."""
    return _evidence.gain(other, best, problem) - correlated_gain(other, best, problem)


def _better_by_nutation(
    solutions: Sequence[Robust], problem: CurveProblem, behind: float, most: float
) -> str:
    """In words: a tumbling state that fits better than the best one, a rotation about one axis.

    Evidence counts the volume of a nutation, about ln N for each of its parameters, and odds
    against it.  Where these alone put the rotation about one axis in front, and the likelihood of a
    wide nutation is higher than by chance among the frequencies tried, a claim would rest on the
    prior.  Where so many points count as one, chance explains so many times as much.
    """
    settings, best = problem.settings, solutions[0]
    counted = _NUTATION * math.log(len(problem)) + 2.0 * math.log(most / settings.odds)
    gains = [
        _gained(other, best, problem)
        for other in solutions[1:]
        if not is_axial(other.refined.state)
        and SearchState.of(other.refined.state).log_rho > math.log(settings.wide)
        and other.evidence - best.evidence < behind + counted
    ]
    chance = _of_chance(most, settings)
    if max(gains, default=0.0) < chance:
        return ""
    return (
        f"a tumbling state fits better by {max(gains):.1f} in -2 ln(likelihood), more than the "
        f"{chance:.1f} of chance"
    )


def _of_chance(most: float, settings: Settings) -> float:
    """By how much the best nutation among frequencies up to the largest fits better by chance."""
    return exceeded_by_chance(settings.by_chance * min(1.0, settings.same_rate / most))


def _of_hidden(
    poles: Sequence[Robust], problem: CurveProblem, most: float, *, is_strict: bool
) -> tuple[str, str]:
    """How far nutations that the errors may hide limit the verdict on one axis, in words.

    `poles`: rotations about one axis that compete, for what is seen of a nutation depends on it.
    What it would improve is a square of rho.  A period stays, if no wide nutation may be hidden.
    """
    settings = problem.settings
    gain = min(map(_evidence.gain_of_nutation, poles))
    least = _of_chance(most, settings) * settings.noticed_by
    if gain > least:
        return SOLVED, ""
    hidden = settings.noticed * math.sqrt(least / gain) if gain > 0.0 else math.inf
    tilt, tried = (math.degrees(2.0 * math.atan(rho)) for rho in (hidden, settings.noticed))
    words = (
        f"a nutation of up to {tilt:.0f} degrees may be hidden (one of {tried:.0f} would improve "
        f"the fit by {gain:.1f} in chi-squared, {least:.1f} needed to tell it from chance; with "
        "modes PA one axis is given)"
    )
    return OPEN if is_strict or hidden > settings.hidden else PERIODS, words


def _has_periods(state: FloatArray, best: FloatArray, problem: CurveProblem) -> bool:
    """Whether two states have the same periods; about one axis, as the scene sees them."""
    if is_axial(state) and is_axial(best):
        return _pole_map.has_turn(problem, state, best)
    return _has_rates(state, best, problem)


def _is_motion_of(state: FloatArray, best: FloatArray, problem: CurveProblem) -> bool:
    """Whether a state has the rates of the best one, or adds a nutation to its one axis."""
    if is_axial(best) and not is_axial(state):
        return True
    return _has_periods(state, best, problem)


def _keeps_period(tumbler: Robust, rotator: Robust, problem: CurveProblem) -> bool:
    """Whether the scene sees a tumbling state turn as a rotation does, by phi or phi and psi."""
    states = [SearchState.of(one.refined.state) for one in (tumbler, rotator)]
    turns = _pole_map.turn_of_scene(problem, np.stack([state.pole for state in states]))
    rate = states[1].rates[0] - float(turns[1])
    lines = np.array([states[0].rates[0], 2.0 * states[0].precession]) - float(turns[0])
    return bool(np.abs(lines - rate).min() < problem.settings.comb_width)


def _has_rates(state: FloatArray, best: FloatArray, problem: CurveProblem) -> bool:
    return bool(_ellipsoid.have_rates(state, best, problem.settings.same_rate))


def exceeded_by_chance(probability: float) -> float:
    """What chi-squared of four degrees of freedom, those of a nutation, exceeds so often.

    p = (1 + h) exp(-h), h half of it, by an iteration that gains a digit a step for p <= 0.1;
    scipy.special would take 0.2 s to import.
    """
    half = 0.0
    for _ in range(_STEPS):
        half = math.log1p(half) - math.log(probability)
    return 2.0 * half
