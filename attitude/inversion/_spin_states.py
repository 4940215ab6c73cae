"""`spin_states`: the ranked spin states of a light curve."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, overload

import numpy as np

from attitude._support import quantity_text, validation
from attitude._support.arrays import distinct
from attitude._support.blocks import timed
from attitude._support.constants import DAY_S
from attitude._support.synonyms import arguments
from attitude.errors import AttitudeError
from attitude.inversion import (
    _apparitions,
    _ellipsoid,
    _evidence,
    _joined,
    _known,
    _lattices,
    _neighbours,
    _problem,
    _refinement,
    _search,
    _states,
    _verdicts,
)
from attitude.inversion._problem import usable
from attitude.inversion._settings import DEFAULT, Settings, Tally
from attitude.inversion._solution import Solution, SpinStates
from attitude.photometry._samples import is_plain, warn_of_plain
from attitude.shape._mesh import Mesh

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from attitude._support.annotations import FloatArray, Real
    from attitude.inversion._evidence import Robust, Weighted
    from attitude.inversion._from_start import Refinement
    from attitude.inversion._problem import CurveProblem
    from attitude.inversion._shapes import Tie
    from attitude.motions._body import Body
    from attitude.photometry._curve import LightCurve
    from attitude.scattering._law import Law

    ZeroPoints = str | float | tuple[str, ...]
    Prepared = Callable[[ZeroPoints], _search.Search]


# Modes of tumbling.
_MODES = ("LAM", "SAM")
# Rotation about one axis alone.
_ROTATION = ("PA",)
# Turns of the fastest rotation that a curve spans at least.
_TURNS = 2.0
# Share of a period about which it is searched.
_OF_PERIOD = 0.01
_LABEL = "spin states"
_IS_CONSTANT = "the brightness is constant within the errors"


@overload
def spin_states(
    curve: LightCurve,
    max_frequency: Real | None = ...,
    *,
    period: Real | Sequence[Real] | None = ...,
    modes: Sequence[str] = ...,
    shape: str = ...,
    law: str | Law | None = ...,
    moments: str | float | Body | Sequence[float] = ...,
    drift: bool = ...,
    budget: Real = ...,
    seed: int = ...,
    threads: int = ...,
    settings: Settings = ...,
    progress: Callable[[str], object] | None = ...,
) -> SpinStates[Solution]: ...


@overload
def spin_states(
    curve: LightCurve,
    max_frequency: Real | None = ...,
    *,
    period: Real | Sequence[Real] | None = ...,
    modes: Sequence[str] = ...,
    shape: Mesh,
    law: str | Law | None = ...,
    moments: str | float | Body | Sequence[float] = ...,
    drift: bool = ...,
    budget: Real = ...,
    seed: int = ...,
    threads: int = ...,
    settings: Settings = ...,
    progress: Callable[[str], object] | None = ...,
) -> SpinStates[Refinement]: ...


@arguments(
    {
        "periods": "give period=, one or several",
        "body": "give moments=",
        "path": "give it to the curve: LightCurve(..., path=)",
    },
    'spin_states(LightCurve.read("curve.csv"), "3 /d")',
)
def spin_states(
    curve: LightCurve,
    max_frequency: Real | None = None,
    *,
    period: Real | Sequence[Real] | None = None,
    modes: Sequence[str] = _MODES,
    shape: str | Mesh = "convex",
    law: str | Law | None = None,
    moments: str | float | Body | Sequence[float] = "shape",
    drift: bool = False,
    budget: Real = 60.0,
    seed: int = 0,
    threads: int = 1,
    settings: Settings = DEFAULT,
    progress: Callable[[str], object] | None = None,
) -> SpinStates[Solution] | SpinStates[Refinement]:
    """The spin states that a light curve allows, found without a first guess.

    Parameters
    ----------
    curve : LightCurve
    max_frequency : float, Quantity or text
        Hz, or such as "0.75 /d": of the rotation about the short axis, 1/P_phi(S), at most.
    period : float, Quantity or text, or two of them, optional
        s, or such as "5.762 h", of a rotation about one axis: to 1 %, or between two.  Then only
        such rotations are searched, and `max_frequency` may be left out.
    modes : sequence of str
        "LAM", "SAM" or both; or "PA" alone: rotations about one axis only, over any number of
        apparitions.
    shape : str or Mesh
        "convex", or "ellipsoid"; or a known mesh, such as a satellite, whose axes are the body's.
        Then `max_frequency` is that of the rate itself, and solutions are `Refinement` objects.
    law : str or Law, optional
        Of a known mesh, such as `attitude.scattering.Materials`; by default Lommel-Seeliger's law
        and a tenth of Lambert's.
    moments : str, float, three floats or Body
        "shape": the logarithms of the ratios of moments agree with those of the homogeneous shape
        to 0.05, the least one less strictly downward, as in concave bodies; a number replaces this
        tolerance; "free": any moments of a body; three principal moments, of which the ratios
        count, or a Body: known moments, with any shape.  Of a known mesh "shape" is homogeneous,
        and three moments are about its own axes.
    drift : bool
        Of a body that tumbles over several apparitions: both its frequencies may change at constant
        speed, as on average under a weak torque that is fixed in the body, or YORP.
    budget : float or text
        Work, s of one core of 2 GHz, after which the best so far is returned.  Work is counted
        by steps and points, so that load and speed of the machine change no result.
    seed : int
        Of the random starts.  The same seed gives the same result.
    threads : int
        Of the linear algebra.
    settings : Settings
        Thresholds and sizes of the search.
    progress : callable, optional
        Called with a text after each stage.  By default a bar of the time is drawn where standard
        error is a terminal.

    Returns
    -------
    SpinStates
        A sequence of `Solution`, the best first, with a verdict.

    Raises
    ------
    AttitudeError
        For arguments out of range, and a curve that spans less than a turn at `max_frequency`.

    Notes
    -----
    Ctrl-C ends the search, and the best so far is returned.
    """
    curve = usable(curve)
    if not isinstance(settings, Settings):
        raise AttitudeError(f"settings is {validation.shown(settings)}; give Settings(...).")
    _check_drift(drift, curve, modes, period, shape)
    if isinstance(shape, Mesh):
        most = _checked_turns(curve, max_frequency, settings, True, [curve])
        seconds = validation.positive(budget, "budget", unit="s")
        number = validation.count(threads, "threads")
        with _refinement.limited(number), timed(_LABEL, seconds, progress) as report:
            return _known.found(
                curve,
                most,
                shape,
                law,
                moments,
                seconds=seconds,
                seed=seed,
                settings=settings,
                progress=report,
            )
    if law is not None:
        raise AttitudeError("law= is that of a known mesh; give shape=mesh, or leave law out.")
    tie = _checked(modes, shape, moments)
    modes, window = _window(curve, max_frequency, period, modes, settings)
    most = window[1]
    seconds = validation.positive(budget, "budget", unit="s")
    validation.count(threads, "threads")
    _compile(curve, most)
    with _refinement.limited(threads), timed(_LABEL, seconds, progress) as report:
        wanted = _Wanted(
            most, tuple(modes), tie, shape == "ellipsoid", seconds, seed, settings, report
        )
        if wanted.modes == _ROTATION:
            rates = window[0] * curve.span, most * curve.span
            rotator = wanted.searches(curve, _apparitions.RotatorSearch, window=rates)
            search = _searched(curve, rotator)
        elif drift or most * curve.span > settings.most_turns:
            search = _joined_search(curve, wanted, drift)
        else:
            search = _searched(curve, wanted.searches(curve))
    return _results(curve, search, 1.0 / window[0])


@dataclass(frozen=True)
class _Wanted:
    """What searches for unknown shapes have in common; most in Hz, seconds those of the budget."""

    most: float
    modes: tuple[str, ...]
    tie: Tie
    is_ellipsoid: bool
    seconds: float
    seed: int
    settings: Settings
    progress: Callable[[str], object]

    def searches(
        self, curve: LightCurve, kind: type[_search.Search] = _search.Search, **more: Any
    ) -> Prepared:
        """Makes a search of a curve from zero points; those of one curve share the budget."""
        tally = Tally(self.seconds)

        def prepared(zero_points: ZeroPoints) -> _search.Search:
            turns, settings = self.most * curve.span, self.settings
            problem, averaged = _problem.problem(
                curve,
                self.most,
                settings.ellipsoid_error,
                zero_points,
                settings=settings,
                tally=tally,
            )
            problem, outliers = _neighbours.without_outliers(problem, turns)
            search = kind(
                problem,
                turns,
                self.modes,
                self.tie,
                _shifts(curve, settings.one_site),
                validation.generator(self.seed),
                self.progress,
                is_ellipsoid=self.is_ellipsoid,
                notes=list(curve.notes),
                **more,
            )
            if outliers:
                words = _verdicts.with_verb(outliers, "point", "lie")
                search.notes.append(f"{words} far off both neighbours, almost without weight.")
            search.notes += averaged
            return search

        return prepared


def _check_drift(drift, curve, modes, period, shape):
    if not drift:
        return
    is_tumbling = period is None and "PA" not in modes and not isinstance(shape, Mesh)
    if not (is_tumbling and len(_joined.apparitions(curve)) > 1):
        raise AttitudeError(
            "drift is for a body of unknown shape that tumbles over several apparitions, with "
            "gaps above 60 d between them; leave it out."
        )


def _joined_search(curve: LightCurve, wanted: _Wanted, drift: bool) -> _search.Search:
    """A search for motions that all apparitions have in common; each is solved first."""
    size = _refinement.DRIFT if drift else 0
    known: list[_joined.Apparition] = []
    words: list[str] = []

    def alone() -> list[_joined.Apparition]:
        for number, apparition in enumerate(() if known else _joined.apparitions(curve), 1):
            one = _searched(apparition, wanted.searches(apparition))
            known.append(_joined.alone(curve, apparition, one, wanted.settings, size))
            words.append(
                f"Apparition {number} ({apparition.span / DAY_S:.0f} d, {len(apparition)} points): "
                f"{one.verdict_of(one.solutions)[0]}, "
                f"{_verdicts.with_verb(len(known[-1].solutions), 'tumbling state', 'continue')}."
            )
        return known

    search = _searched(curve, wanted.searches(curve, _joined.JoinedSearch, alone=alone))
    search.notes += words
    return search


def _compile(curve: LightCurve, most: float) -> None:
    """Run every compiled loop once: the time of compilation is not counted."""
    generator = np.random.default_rng(0)
    problem, _ = _problem.problem(curve, most, DEFAULT.ellipsoid_error, "shared")
    pairs_of, _ = _lattices.lattice_pairs(problem, 2.0, 1)
    rate = _lattices.Candidate(float(pairs_of[0, 0]), -1.0)
    pool = _ellipsoid.around(problem, generator, [rate], 1, iterations=1, tie=_ellipsoid.Held(1.0))
    _refinement.refine(problem, pool.states[0], iterations=1)


def _window(curve, max_frequency, period, modes, settings):
    """The modes, and the least and the largest frequency of a rotation about one axis, Hz."""
    least = _lattices.LEAST / curve.span
    if period is None:
        is_tumbling, parts = tuple(modes) != _ROTATION, _joined.apparitions(curve)
        return modes, (least, _checked_turns(curve, max_frequency, settings, is_tumbling, parts))
    if tuple(modes) not in (_MODES, _ROTATION):
        raise AttitudeError(
            f"period= is that of a rotation about one axis, and modes is {modes!r}; leave it out, "
            'or give ("PA",).'
        )
    if isinstance(period, (list, tuple)):
        if len(period) != 2:
            raise AttitudeError(f"period has {len(period)} entries; give one period, or two.")
        low, high = (validation.positive(bound, "period", unit="s") for bound in period)
    else:
        middle = validation.positive(period, "period", unit="s")
        low, high = middle * (1.0 - _OF_PERIOD), middle * (1.0 + _OF_PERIOD)
    if high <= low:
        raise AttitudeError(f"period is from {low:g} to {high:g} s; give the shorter one first.")
    most = 1.0 / low
    if max_frequency is not None:
        most = min(most, validation.positive(max_frequency, "max_frequency", unit="1/s"))
    least = max(1.0 / high, least)
    if most <= max(least, _TURNS / curve.span):
        raise AttitudeError(
            f"no period from {low:g} to {high:g} s is left: {_TURNS:g} turns have to lie within "
            f"the {curve.span:g} s of the light curve"
            + ("." if max_frequency is None else ", and max_frequency limits periods too.")
        )
    warn_of_plain(period, "period", curve.seconds)
    return _ROTATION, (least, most)


def _checked_turns(curve, max_frequency, settings, is_limited, parts):
    """The largest frequency, Hz; `is_limited`: few enough turns in each of the parts."""
    if max_frequency is None:
        raise AttitudeError("max_frequency is missing; give the largest frequency of rotation.")
    most = validation.positive(max_frequency, "max_frequency", unit="1/s")
    turns, limit = most * curve.span, settings.most_turns
    plain = ""
    if is_plain(max_frequency):
        plain = f' of {most:g}, which without a unit is in Hz (with one: "{most:g} /d")'
    if turns < _TURNS:
        raise AttitudeError(
            f"the light curve spans {turns:.2g} turns at max_frequency{plain}; give a larger one, "
            f"at least {_TURNS / curve.span:.3g} Hz, or a longer curve."
        )
    if turns > limit and len(parts) > 1:
        turns = most * max(apparition.span for apparition in parts)
    if turns > limit and is_limited:
        one = "an apparition" if len(parts) > 1 else "the light curve"
        raise AttitudeError(
            f"{one} spans {turns:.0f} turns at max_frequency{plain}; at most {limit:.0f} "
            f"are searched for tumbling. Give at most {limit / turns * most * DAY_S:.3g} /d, "
            'a part of the curve, or modes=("PA",) for rotation about one axis.'
        )
    warn_of_plain(max_frequency, "max_frequency", curve.seconds, "Hz")
    return most


def _checked(modes, shape, moments):
    """The tie of the moments; AttitudeError for modes or a shape that are none."""
    if not modes or isinstance(modes, str):
        raise AttitudeError(f'modes is {modes!r}; give a sequence such as ("LAM", "SAM").')
    for mode in modes:
        validation.one_of(mode, "modes", (*_MODES, *_ROTATION))
    if "PA" in modes and len(modes) > 1:
        raise AttitudeError(
            'modes has "PA" beside others; rotations about one axis are always searched beside '
            'tumbling: leave "PA" out, or give it alone.'
        )
    validation.one_of(shape, "shape", ("convex", "ellipsoid"))
    return _states.of(moments)


def _searched(curve, prepared):
    """The search with the zero points of sessions that a curve asks for, after it has run.

    Offsets of short sessions take up a rotation of days.  So one zero point for all sessions is
    tried first, and offsets follow where evidence prefers them.
    """
    one = prepared("shared")
    if is_constant(one.problem):
        one.notes.append(_IS_CONSTANT + ".")
        return one
    if curve.zero_points != "auto":
        searched = prepared(curve.zero_points)
        if is_constant(searched.problem):
            searched.notes.append(
                "the zero points of the sessions alone explain the brightness within the errors; "
                f"with one zero point chi2/N is {_mean_square(one.problem):.1f}.  "
                'zero_points="auto" fits them only where a rotation needs them.'
            )
        else:
            _run(searched)
        return searched
    if len(curve.sessions) == 1:
        _run(one)
        return one
    return _with_offsets_if_needed(one, prepared)


def _with_offsets_if_needed(one: _search.Search, prepared: Prepared) -> _search.Search:
    """The search with one zero point, or one with offsets, whichever has the better evidence."""
    searched = prepared("auto")
    may_be_constant = is_constant(searched.problem)
    asked = []

    def asks(is_early: bool) -> bool:
        settings = one.settings
        needed = settings.alone if is_early else settings.competing
        # of a curve that no motion explains with one zero point, offsets may hide the true one
        is_unexplained = not is_early and bool(one.solutions) and not one.is_at_floor
        asked.append(_asks_for_offsets(one, searched, needed) or is_unexplained)
        return asked[-1] and not may_be_constant

    if not _run(one, asks):
        return one
    if may_be_constant:
        one.constant = _as_constant(searched.problem, one.solutions)
    # a budget that ended in between has not asked
    if one.constant or not (asked[-1] if asked else asks(False)):
        return one
    # what one zero point made of the lines may hide the true motion: all is tried again
    searched.follow(one)
    if not searched.solutions:
        return one
    if not (searched.is_over or _problem.are_free(_offsets_of(searched.solutions[0]))):
        _run(searched)
    offsets = _offsets_of(searched.solutions[0])
    if _problem.are_free(offsets) and not searched.is_over:
        free = prepared("free")
        _run(free)
        if free.solutions:
            searched, best = free, free.solutions[0]
            # they have no prior, and stand behind the terms of one zero point
            all_offsets = best.problem.coefficients(best.refined.magnitude)
            offsets = all_offsets[len(one.problem.prior) :]
    searched.notes.append(f"sessions have zero points of their own, {np.std(offsets):.2f} mag rms.")
    return searched


def _run(search: _search.Search, is_ended: Callable[[bool], bool] = _search.never) -> bool:
    """Run a search; False if it was interrupted."""
    try:
        search.run(is_ended)
    except KeyboardInterrupt:
        search.is_interrupted = True
        search.notes.append("the search was interrupted.")
        if not search.solutions:
            search.finish()
        return False
    return True


def _asks_for_offsets(one: _search.Search, with_offsets: _search.Search, needed: float) -> bool:
    """Whether evidence prefers zero points of the sessions, with the best motions found so far.

    Of each pair of rates the best, and those that were best with zero points before: a slow motion
    that takes the place of these comes in front of the true one without them.
    """
    if not one.solutions:
        return False
    solutions = *one.solutions, *with_offsets.solutions[:1]
    with_offsets.begin(distinct((solution.refined.state for solution in solutions), one.has_rates))
    without_offsets = _evidence.among_problems(one.solutions[0])
    return without_offsets - _evidence.among_problems(with_offsets.solutions[0]) > needed


def _mean_square(problem: CurveProblem) -> float:
    """The mean square of the magnitudes without the linear terms, over the errors."""
    return float(np.mean((problem.detrended / problem.sigma) ** 2))


def is_constant(problem: CurveProblem) -> bool:
    """Whether the linear terms alone explain the magnitudes.

    Terms with a prior count by it: offsets beyond it are no constant brightness.  Free zero points
    of many nights take degrees of freedom, and most of a slow variation.  Errors that are larger
    than neighbours show, as those that are assumed, count as these show.
    """
    blank, settings = problem.with_model_error(0.0), problem.settings
    taken = np.linalg.matrix_rank((blank.terms * blank.root[:, None])[:, np.isinf(blank.prior)])
    free = len(blank) - int(taken)
    most = min(settings.constant_at_most, 1.0 + settings.constant * math.sqrt(2.0 / free))
    chi_squared = blank.chi_squared(np.zeros(len(blank))) * _neighbours.too_large(problem) ** 2
    return chi_squared < most * free


def _as_constant(problem: CurveProblem, solutions: Sequence[Robust]) -> str:
    """How a constant brightness with zero points of the sessions competes; "" if it does not."""
    constant = _evidence.constant(problem)
    best = min((_evidence.among_problems(solution) for solution in solutions), default=math.inf)
    ahead = best - _evidence.among_problems(constant)
    if ahead < -problem.settings.competing:
        return ""
    size = float(np.std(_offsets_of(constant)))
    words = f"a constant brightness with zero points of the sessions of {size:.3f} mag rms"
    if not solutions:
        return f"{words} explains the curve"
    needed = f"({problem.settings.competing:g} needed)"
    return f"{words} is {_verdicts.ahead_by(ahead)} the best state in -2 ln(evidence) {needed}"


def _shifts(curve: LightCurve, share: float) -> tuple[float, ...]:
    """A day in turns per span, if most points lie at one time of the day."""
    if curve.span < 2.0 * DAY_S:
        return ()
    angle = 2.0 * np.pi * curve.seconds / DAY_S
    hour = np.mod(angle - np.angle(np.mean(np.exp(1j * angle))) + np.pi, 2.0 * np.pi) - np.pi
    one_site = np.mean(np.abs(hour) < np.pi / 3.0) > share
    return (curve.span / DAY_S,) if one_site else ()


def _offsets_of(solution: Weighted[object]) -> FloatArray:
    """Fitted zero points of the calibrated sessions of a solution, mag."""
    return solution.problem.offsets(solution.refined.magnitude)


def _results(curve, searched, longest):
    ahead = searched.satellite_is_ahead()
    search = searched.rival if ahead > 0.0 else searched
    settings = search.settings
    admissible = [one for one in search.solutions if _ellipsoid.is_admissible(one.refined.state)]
    solutions = [
        Solution(
            curve,
            one,
            search.problem,
            search.tie,
            rank,
            _verdicts.relation(
                one.refined.state, admissible[0].refined.state, search.problem, search.length
            ),
            _rivals(one, admissible, search),
        )
        for rank, one in enumerate(admissible)
    ]
    verdict, criterion = search.verdict_of(admissible)
    if verdict == _verdicts.SOLVED:
        is_hidden = solutions[0].is_axial and not search.tie.is_wide
        try:
            sigma = solutions[0].pole_sigma
        except KeyboardInterrupt:
            verdict = _verdicts.PERIODS
            criterion += " Ctrl-C ended the errors before that of the pole was known."
        else:
            verdict, criterion = _verdicts.of_pole(criterion, sigma, settings, is_hidden=is_hidden)
    if searched.rival is not None:
        period = curve.span / searched.rival.problem.orbit / DAY_S
        verdict, criterion = _verdicts.of_satellite(
            (verdict, criterion), period, ahead, searched.rival.needed_ahead
        )
    if searched.constant:
        verdict, criterion = _verdicts.OPEN, f"{searched.constant}; {criterion}"
    notes = list(searched.notes)
    if solutions and _has_half_the_turns(solutions[0], longest):
        double = quantity_text.of_time(2.0 * solutions[0].P_phi)
        notes.append(
            "the curve has one maximum in the period found, and most bodies have two a turn: twice "
            f"the period, {double}, is beyond the longest one searched."
        )
    if solutions and np.any(solutions[0].drift):
        notes.append(_words_of_drift(solutions[0]))
    criterion += _verdicts.ended_by(verdict, search.problem.tally)
    return SpinStates(solutions, verdict, criterion, tuple(notes))


def _has_half_the_turns(best: Solution, longest: float) -> bool:
    """Whether a rotation has one maximum a turn, and twice its period is above the longest, s."""
    is_beyond = best.is_axial and 2.0 * best.P_phi > longest
    return is_beyond and _verdicts.has_one_maximum(best.weighted, best.weighted.problem)


def _rivals(solution: Robust, solutions: Sequence[Robust], search: _search.Search) -> list[Robust]:
    """Those that compete with a solution; of a rotation also those that no list of poles names."""
    others = [other for other in solutions if other is not solution]
    if _ellipsoid.is_axial(solution.refined.state):
        others += search.beside
    width = search.settings.competing_poles
    return [other for other in others if abs(other.evidence - solution.evidence) < width]


def _words_of_drift(best: Solution) -> str:
    phi, psi = (
        f"{value * DAY_S**2:.4g} +- {sigma * DAY_S**2:.2g} /d^2"
        for value, sigma in zip(best.drift, best.drift_sigma, strict=True)
    )
    return f"1/P_phi of the long axis changes by {phi}, 1/P_psi by {psi}."
