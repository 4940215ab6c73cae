"""Tumbling over several apparitions: each is solved alone, then the turns between are counted.

1. Every apparition gives spin states with errors: orientation, phase and rates at its middle.
2. A common motion carries those of one apparition to another one.  What is not known is how often
   the long axis turned about the momentum (n_phi) and the body about its axis (n_psi) in between,
   and which axes of the body the two states call the first and the second: four lattices of pairs
   of whole numbers.  For each pair of numbers the residuals of the common motion are linear in it
   (`counts`), so that all pairs within the errors are listed at once.
3. From each of them a convex body is fitted to all apparitions together, and these are ranked by
   their evidence.

Where both rates may drift, as on average under a weak torque that is fixed in the body, two more
parameters are common to all apparitions: precession and nutation change at constant speed.

Source: by hand, Pravec et al., Icarus 233, 48 (2014); Lee et al., A&A 661, L3 (2022), of (99942)
Apophis.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from attitude._support.least_squares import inverse
from attitude.inversion import _ellipsoid, _evidence, _neighbours, _problem, _refinement
from attitude.inversion._ellipsoid import OF_RATES, SearchState, is_axial
from attitude.inversion._refinement import AZIMUTH, LN_RHO, MOTION, NUTATION, PHASE, PRECESSION, X
from attitude.inversion._search import Search, never

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Sequence

    from attitude._support.annotations import FloatArray
    from attitude.inversion._problem import CurveProblem
    from attitude.inversion._refinement import Refined
    from attitude.inversion._settings import Settings
    from attitude.photometry._curve import LightCurve


_TURN = 2.0 * math.pi
# The number of parameters of a motion with the drift of precession and nutation behind them.
_ALL = MOTION + _refinement.DRIFT
# Where the drift stands among them.
_DRIFTS = [*range(MOTION, _ALL)]
# Ways to call axes of a body the first and the second.
_LABELS = 4
# The turn from one of these ways to the next.
_QUARTER = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
# Standard errors by which numbers of turns are tried to either side.
_SIDE = 5.0
# Numbers of turns that are tried to one side at most.
_MOST = 400.0


def apparitions(curve: LightCurve) -> list[LightCurve]:
    """The parts of a curve that long gaps divide, each with enough points for a search."""
    parts = _neighbours.apparitions_of(curve.emission)
    return [curve[numbers] for numbers in parts if len(numbers) >= _problem.LEAST_POINTS]


class Alone(NamedTuple):
    """A spin state of one apparition, or of several that are joined.

    state (WIDTH, or with a drift) has its rates in turns per span of the whole curve, and its
    orientation and phase at `middle`, spans from the middle of the whole curve; covariance (10, 10)
    is that of the turn (rad, axes along the momentum), precession, nutation, phase, ln rho, X and
    the drift, 0 where none is found; evidence is that behind the best.
    """

    state: FloatArray
    covariance: FloatArray
    evidence: float
    middle: float


class Apparition(NamedTuple):
    """First and last epoch, spans from the middle of the whole curve, and what was found."""

    first: float
    last: float
    solutions: list[Alone]


def alone(
    curve: LightCurve, apparition: LightCurve, search: Search, settings: Settings, drift: int = 0
) -> Apparition:
    """The tumbling solutions of an apparition that compete, the best first.

    `drift` is the size of that of the joined motion, which one apparition says nothing of.
    """
    ratio = curve.span / apparition.span
    middle = (apparition.epoch.seconds - curve.epoch.seconds) / curve.span
    scale = np.ones(MOTION)
    scale[[PRECESSION, NUTATION]] = ratio
    solutions: list[Alone] = []
    for one in search.solutions:
        behind = one.evidence - search.solutions[0].evidence
        if behind > settings.mapped_behind or len(solutions) == settings.joined_solutions:
            break
        state = one.refined.state.copy()
        if not is_axial(state):
            state[OF_RATES] *= ratio
            covariance = np.zeros((_ALL, _ALL))
            formal = inverse(one.refined.normal)[:MOTION, :MOTION] * np.outer(scale, scale)
            covariance[:MOTION, :MOTION] = settings.joined_wider**2 * formal
            covariance[_DRIFTS[:drift], _DRIFTS[:drift]] = _refinement.DRIFT_WIDTH**2
            state = np.append(state, np.zeros(drift))
            solutions.append(Alone(state, covariance, behind, middle))
    ends = apparition.emission / curve.span + middle
    return Apparition(float(ends.min()), float(ends.max()), solutions)


def at_middle(state: FloatArray, middle: float) -> FloatArray:
    """A state whose orientation and phase are those of an epoch, carried to that of the curve."""
    fields, time = SearchState.of(state), -middle
    drift = _refinement.drift_of(state)
    precession, nutation = state[OF_RATES] + 0.5 * drift * time
    back = 4.0 * math.pi * precession * time
    c, s = math.cos(back), math.sin(back)
    turn = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    carried = fields._replace(
        frame=fields.frame @ turn, phase=math.remainder(fields.phase + nutation * time, 1.0)
    ).vector
    carried[OF_RATES] += drift * time
    return carried


class Count(NamedTuple):
    """A pair of numbers of turns: chi-squared of the common motion, and its state at the curve's
    middle.
    """

    chi_squared: float
    state: FloatArray


class Trial(NamedTuple):
    """A common motion of two solutions: its evidence, and its state at the curve's middle."""

    evidence: float
    state: FloatArray


def counts(first: Alone, second: Alone, within: float) -> list[Count]:
    """Common motions of two solutions for all numbers of turns within the errors.

    `within`: chi-squared above the least one.
    """
    modes = [SearchState.of(one.state).nutation > 0.0 for one in (first, second)]
    if modes[0] != modes[1]:
        return []
    trials: list[Count] = []
    for _ in range(_LABELS):
        trials += _whole_counts(first, second, within)
        second = _relabelled(second)
    most = min(trial.chi_squared for trial in trials) + within
    return [trial for trial in trials if trial.chi_squared < most]


def _relabelled(one: Alone) -> Alone:
    """The same motion of a body whose axes are a quarter turn about its third one further on.

    The first two change places, and with them X its sign: one curve does not tell which is which,
    for the shape turns with its axes (docs/derivation.md, section 15: E by i E).
    """
    fields = SearchState.of(one.state)
    turned = fields._replace(
        phase=fields.phase + 0.25, x=-fields.x, frame=fields.frame @ _QUARTER
    ).vector
    over = np.eye(_ALL)
    over[_refinement.TURN, _refinement.TURN] = _QUARTER.T
    over[X, X] = -1.0
    return one._replace(state=turned, covariance=over @ one.covariance @ over.T)


def _whole_counts(first: Alone, second: Alone, within: float) -> Iterator[Count]:
    """`counts` of two solutions that have the same axes of the body."""
    length = second.middle - first.middle
    one, two = SearchState.of(first.state), SearchState.of(second.state)
    between = one.frame.T @ two.frame
    angle = math.atan2(between[1, 0] - between[0, 1], between[0, 0] + between[1, 1])
    drift = _refinement.drift_of(first.state)
    # the parameters of the second solution, as those of the first one give them
    carried = np.eye(MOTION, _ALL)
    cosine, sine = math.cos(angle), math.sin(angle)
    tilt = _refinement.TILT
    carried[tilt, tilt] = [[cosine, sine], [-sine, cosine]]
    carried[AZIMUTH, PRECESSION] = 4.0 * math.pi * length
    carried[PHASE, NUTATION] = length
    carried[[PRECESSION, NUTATION], _DRIFTS] = length
    carried[[AZIMUTH, PHASE], _DRIFTS] = 2.0 * math.pi * length**2, 0.5 * length**2
    precession, nutation = first.state[OF_RATES] + 0.5 * drift * length
    off = np.zeros(MOTION)
    off[tilt] = -carried[tilt, tilt] @ np.array([-between[1, 2], between[0, 2]])
    off[AZIMUTH] = 4.0 * math.pi * precession * length - angle
    off[[PRECESSION, NUTATION]] = first.state[OF_RATES] + drift * length - second.state[OF_RATES]
    off[PHASE] = one.phase + nutation * length - two.phase
    off[LN_RHO] = one.log_rho - two.log_rho
    off[X] = one.x - two.x
    total = carried @ first.covariance @ carried.T + second.covariance[:MOTION, :MOTION]
    weight = np.linalg.inv(total)
    numbers = _numbers(off, total)
    left = np.repeat(off[None], len(numbers), axis=0)
    left[:, AZIMUTH] -= _TURN * numbers[:, 0]
    left[:, PHASE] -= numbers[:, 1]
    square = np.einsum("ni,ij,nj->n", left, weight, left)
    steps = -left @ weight @ carried @ first.covariance
    for k in np.flatnonzero(square < square.min() + within):
        moved = _ellipsoid.moved(first.state, np.append(steps[k, :MOTION], np.zeros(2)))
        moved[_refinement.WIDTH :] += steps[k, MOTION : MOTION + len(moved) - _refinement.WIDTH]
        yield Count(float(square[k]), at_middle(moved, first.middle))


def _numbers(off: FloatArray, total: FloatArray) -> FloatArray:
    """Pairs of whole numbers of turns (K, 2) within the errors that are left by what is known."""
    turns, known = [AZIMUTH, PHASE], [0, 1, PRECESSION, NUTATION, LN_RHO, X]
    follow = np.linalg.solve(total[np.ix_(known, known)], total[np.ix_(known, turns)]).T
    unit = np.array([_TURN, 1.0])
    middles = (off[turns] - follow @ off[known]) / unit
    left = total[np.ix_(turns, turns)] - follow @ total[np.ix_(known, turns)]
    sides = np.minimum(_SIDE * np.sqrt(np.diag(left)) / unit + 1.0, _MOST)
    axes = [
        np.arange(math.ceil(middle - side), math.floor(middle + side) + 1)
        for middle, side in zip(middles, sides, strict=True)
    ]
    return np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 2)


@dataclass(eq=False)
class JoinedSearch(Search):
    """A search for motions that several apparitions have in common.

    Attributes
    ----------
    alone : callable
        Gives the apparitions with their solutions.
    """

    alone: Callable[[], Sequence[Apparition]] = tuple

    def run(self, is_ended: Callable[[bool], bool] = never) -> None:
        """Fit the common motions of all numbers of turns, of two apparitions, then of more."""
        ordered = self.alone()
        inside = np.zeros(len(self.problem), bool)
        known: list[Alone] = []
        fits: list[Refined] = []
        self.is_complete = len(ordered) > 1
        for number, apparition in enumerate(ordered):
            inside |= (self.problem.t >= apparition.first) & (self.problem.t <= apparition.last)
            if number == 0:
                known = apparition.solutions
                continue
            trials = self._trials(known, apparition.solutions)
            self.length = 0.5 * (
                apparition.first + apparition.last - ordered[0].first - ordered[0].last
            )
            problem = self.problem if number == len(ordered) - 1 else self.problem.part(inside)
            fits = self._fits(problem, trials)
            self.progress(f"{len(fits)} of {len(trials)} pairs of numbers of turns")
            self.is_complete &= bool(fits) and not self.is_over
            known = _joined(fits, self.settings)
        self.convex = [*fits]
        settings = self.settings
        settings = replace(settings, finals=settings.joined, poles=settings.joined_poles)
        self.problem = replace(self.problem, settings=settings)
        self.finish()

    def _trials(self, first: Sequence[Alone], second: Sequence[Alone]) -> list[Trial]:
        """Common motions of two apparitions' solutions, the most probable first."""
        trials = [
            Trial(_evidence.of_common_motion(one.chi_squared, a.evidence, b.evidence), one.state)
            for a in first
            for b in second
            for one in counts(a, b, self.settings.joined_within)
        ]
        return _evidence.ranked(trials)[: self.settings.joined_trials]

    def _fits(self, problem: CurveProblem, trials: Sequence[Trial]) -> list[Refined]:
        """Convex bodies of common motions: of all in a few steps, of the best in more."""
        fits: list[Refined] = []
        states = [trial.state for trial in trials]
        for keep, steps in ((len(states), self.settings.short_steps), (self.settings.joined, 20)):
            fits = []
            for state in states[:keep]:
                if self.is_over and fits:
                    break
                evaluation = _refinement.refine(
                    problem, state, iterations=steps, tie=self.tie, gain=1e-3
                )
                fits.append(evaluation.linearised)
            fits.sort(key=lambda fit: fit.cost)
            states = [fit.state for fit in fits]
        return fits


def _joined(fits: Sequence[Refined], settings: Settings) -> list[Alone]:
    """Fits of several apparitions as the solutions of one, at the middle of the curve."""
    solutions = []
    for fit in fits[: settings.joined_solutions]:
        drift = len(fit.state) - _refinement.WIDTH
        kept = [*range(MOTION), *range(_refinement.SIZE, _refinement.SIZE + drift)]
        covariance = np.zeros((_ALL, _ALL))
        covariance[: len(kept), : len(kept)] = inverse(fit.normal)[np.ix_(kept, kept)]
        behind = fit.cost - fits[0].cost
        solutions.append(Alone(fit.state, settings.joined_wider**2 * covariance, behind, 0.0))
    return solutions
