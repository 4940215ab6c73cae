"""Tumbling over several apparitions: each is solved alone, then the turns between are counted.

1. Every apparition gives spin states with errors: orientation, phase and rates at its middle.
2. A common motion carries those of one apparition to another one.  What is not known is how often
   the long axis turned about the momentum (n_phi) and the body about its axis (n_psi) in between,
   and which axes of the body the two states call the first and the second: four lattices of pairs
   of whole numbers.  For each pair of numbers the residuals of the common motion are linear in it
   (`counts`), so that all pairs within the errors are listed at once.
3. From each of them a convex body is fitted to all apparitions together, and these are ranked by
   their evidence.

Source: by hand, Pravec et al., Icarus 233, 48 (2014); Lee et al., A&A 661, L3 (2022), of (99942)
Apophis.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from attitude._support.least_squares import inverse
from attitude.inversion import _ellipsoid, _problem, _refinement
from attitude.inversion._ellipsoid import SearchState
from attitude.inversion._refinement import MOTION
from attitude.inversion._search import Search, never

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Sequence

    from attitude._support.annotations import FloatArray
    from attitude.inversion._problem import CurveProblem
    from attitude.inversion._refinement import Refined
    from attitude.inversion._settings import Settings
    from attitude.photometry._curve import LightCurve


# Gap, s, between two apparitions.
_GAP = 60.0 * 86400.0
# Among the parameters of a motion: the turn about the momentum, precession, nutation, phase, ln
# rho and X.
_AZIMUTH, _PRECESSION, _NUTATION, _PHASE, _RHO, _X = 2, 3, 4, 5, 6, 7
_TURN = 2.0 * math.pi
# Ways to call axes of a body the first and the second, and the turn from one to the next.
_LABELS, _QUARTER = 4, np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
# Standard errors by which numbers of turns are tried to either side, and the most of one side.
_SIDE, _MOST = 4.0, 400


def apparitions(curve: LightCurve) -> list[LightCurve]:
    """The parts of a curve that long gaps divide, each with enough points for a search."""
    order = np.argsort(curve.emission, kind="stable")
    ends = np.flatnonzero(np.diff(curve.emission[order]) > _GAP) + 1
    parts = [np.sort(indices) for indices in np.split(order, ends)]
    return [curve[indices] for indices in parts if len(indices) >= _problem.LEAST_POINTS]


class Alone(NamedTuple):
    """A spin state of one apparition, or of several that are joined.

    state (WIDTH,) has its rates in turns per span of the whole curve, and its orientation and phase
    at `middle`, spans from the middle of the whole curve; covariance (8, 8) is that of the turn
    (rad, axes along the momentum), precession, nutation, phase, ln rho and X; evidence is that
    behind the best.
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


def alone(curve: LightCurve, part: LightCurve, found: Search, settings: Settings) -> Apparition:
    """The tumbling solutions of an apparition that compete, the best first."""
    ratio = curve.span / part.span
    middle = (part.epoch.seconds - curve.epoch.seconds) / curve.span
    scale = np.ones(MOTION)
    scale[[_PRECESSION, _NUTATION]] = ratio
    solutions: list[Alone] = []
    for one in found.solutions:
        behind = one.evidence - found.solutions[0].evidence
        if behind > settings.mapped_behind or len(solutions) == settings.joined_solutions:
            break
        state = one.refined.state.copy()
        if not SearchState.of(state).is_axial:
            state[:2] *= ratio
            formal = _formal(one.refined) * np.outer(scale, scale)
            solutions.append(Alone(state, settings.joined_wider**2 * formal, behind, middle))
    ends = part.emission / curve.span + middle
    return Apparition(float(ends.min()), float(ends.max()), solutions)


def _formal(found: Refined) -> FloatArray:
    """The covariance (8, 8) of a motion that the curvature gives."""
    return inverse(found.normal)[:MOTION, :MOTION]


def at_middle(state: FloatArray, middle: float) -> FloatArray:
    """A state whose orientation and phase are those of an epoch, carried to that of the curve."""
    fields = SearchState.of(state)
    back = -4.0 * math.pi * fields.precession * middle
    turn = np.array(
        [
            [math.cos(back), -math.sin(back), 0.0],
            [math.sin(back), math.cos(back), 0.0],
            [0.0, 0.0, 1.0],
        ]
    )
    phase = math.remainder(fields.phase - fields.nutation * middle, 1.0)
    return fields._replace(frame=fields.frame @ turn, phase=phase).vector


class Count(NamedTuple):
    """A pair of numbers of turns: chi-squared of the common motion, and its state at the curve's
    middle.
    """

    chi_squared: float
    state: FloatArray


def counts(first: Alone, second: Alone, within: float) -> list[Count]:
    """Common motions of two solutions for all numbers of turns within the errors.

    `within`: chi-squared above the least one.
    """
    if (first.state[1] > 0.0) != (second.state[1] > 0.0):
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
    over = np.eye(MOTION)
    over[:3, :3] = _QUARTER.T
    over[_X, _X] = -1.0
    return one._replace(state=turned, covariance=over @ one.covariance @ over.T)


def _whole_counts(first: Alone, second: Alone, within: float) -> Iterator[Count]:
    """`counts` of two solutions that have the same axes of the body."""
    length = second.middle - first.middle
    one, two = SearchState.of(first.state), SearchState.of(second.state)
    between = one.frame.T @ two.frame
    angle = math.atan2(between[1, 0] - between[0, 1], between[0, 0] + between[1, 1])
    # the parameters of the second solution, as those of the first one give them
    carried = np.eye(MOTION)
    cosine, sine = math.cos(angle), math.sin(angle)
    carried[:2, :2] = [[cosine, sine], [-sine, cosine]]
    carried[_AZIMUTH, _PRECESSION] = 4.0 * math.pi * length
    carried[_PHASE, _NUTATION] = length
    tilt = np.array([-between[1, 2], between[0, 2]])
    off = np.zeros(MOTION)
    off[:2] = -carried[:2, :2] @ tilt
    off[_AZIMUTH] = 4.0 * math.pi * one.precession * length - angle
    off[[_PRECESSION, _NUTATION]] = one.precession - two.precession, one.nutation - two.nutation
    off[_PHASE] = one.phase + one.nutation * length - two.phase
    off[_RHO:] = one.log_rho - two.log_rho, one.x - two.x
    total = carried @ first.covariance @ carried.T + second.covariance
    weight = np.linalg.inv(total)
    numbers = _numbers(off, total)
    left = np.repeat(off[None], len(numbers), axis=0)
    left[:, _AZIMUTH] -= _TURN * numbers[:, 0]
    left[:, _PHASE] -= numbers[:, 1]
    square = np.einsum("ni,ij,nj->n", left, weight, left)
    steps = -left @ weight @ carried @ first.covariance
    for k in np.flatnonzero(square < square.min() + within):
        step = np.concatenate([steps[k], np.zeros(2)])
        moved = _ellipsoid.moved(first.state, step)
        yield Count(float(square[k]), at_middle(moved, first.middle))


def _numbers(off: FloatArray, total: FloatArray) -> FloatArray:
    """Pairs of whole numbers of turns (K, 2) within the errors."""
    middles = off[_AZIMUTH] / _TURN, off[_PHASE]
    widths = math.sqrt(total[_AZIMUTH, _AZIMUTH]) / _TURN, math.sqrt(total[_PHASE, _PHASE])
    axes = []
    for middle, width in zip(middles, widths, strict=True):
        side = min(_SIDE * width + 1.0, float(_MOST))
        axes.append(np.arange(math.ceil(middle - side), math.floor(middle + side) + 1))
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
        self.convex = fits
        settings = replace(self.settings, finals=self.settings.joined, poles=2)
        self.problem = replace(self.problem, settings=settings)
        self.finish()

    def _trials(self, first: Sequence[Alone], second: Sequence[Alone]) -> list[Count]:
        """Common motions of two apparitions' solutions, the most probable first."""
        trials = [
            one._replace(chi_squared=one.chi_squared + a.evidence + b.evidence)
            for a in first
            for b in second
            for one in counts(a, b, self.settings.joined_within)
        ]
        trials.sort(key=lambda each: each.chi_squared)
        return trials[: self.settings.joined_trials]

    def _fits(self, problem: CurveProblem, trials: Sequence[Count]) -> list[Refined]:
        """Convex bodies of common motions: of all in a few steps, of the best in more."""
        fits: list[Refined] = []
        states = [trial.state for trial in trials]
        for keep, steps in ((len(states), self.settings.short_steps), (self.settings.joined, 20)):
            fits = []
            for state in states[:keep]:
                if self.is_over and fits:
                    break
                fits.append(
                    _refinement.refine(problem, state, iterations=steps, tie=self.tie, gain=1e-3)
                )
            fits.sort(key=lambda each: each.cost)
            states = [fit.state for fit in fits]
        return fits


def _joined(found: Sequence[Refined], settings: Settings) -> list[Alone]:
    """Fits of several apparitions as the solutions of one, at the middle of the curve."""
    return [
        Alone(
            fit.state,
            settings.joined_wider**2 * _formal(fit),
            fit.cost - found[0].cost,
            0.0,
        )
        for fit in found[: settings.joined_solutions]
    ]
