"""Least squares of a motion with parameters and a shape, convex or known, to a light curve."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from attitude.errors import AttitudeError
from attitude.inversion import convex, iteration, moving, refinement, robust
from attitude.inversion.search import ELLIPSOID_ERROR

if TYPE_CHECKING:
    from attitude.annotations import BoolArray, FloatArray
    from attitude.epochs.instants import Instant
    from attitude.inversion.known_shape import KnownShape
    from attitude.inversion.moving import MovingPoint
    from attitude.inversion.problem import CurveProblem
    from attitude.inversion.robust import Weighted

# Shares of the points, those nearest in time to the epoch of the start, that are fitted first.
_STAGES = (0.25, 0.4, 0.6, 0.8)
_ITERATIONS, _LAST = 12, 40
# Mean square of residuals over the errors, above which the points are fitted in stages too.
_BAD = 1.5


@dataclass(frozen=True, eq=False)
class MovingState:
    """A point and the parameters of a convex shape, none for a known one."""

    point: MovingPoint
    shape: FloatArray


@dataclass(frozen=True, eq=False)
class MovingModel:
    """Magnitudes (N,) of a state, their Jacobian (P, N), areas, and the slopes of the areas."""

    magnitude: FloatArray
    jacobian: FloatArray
    areas: FloatArray
    slopes: FloatArray


@dataclass(frozen=True, eq=False)
class MovingFound:
    """A state near its least cost; attributes as of `refinement.Refined`."""

    state: MovingState
    cost: float
    chi_squared: float
    strain: float
    normal: FloatArray
    gradient: FloatArray
    areas: FloatArray
    magnitude: FloatArray


@dataclass(frozen=True, eq=False)
class MovingFit:
    """What is fitted.

    Attributes
    ----------
    epoch : Instant
        Of the curve.
    known : KnownShape or None
        None for a convex shape, which is found too.
    least : float
        Flux of a known shape that counts as dark.
    tie : Tie
        Of the moments of motion and shape.
    fixed : (P,) array of bool
        Parameters that stay.
    """

    epoch: Instant
    known: KnownShape | None
    least: float
    tie: convex.Tie
    fixed: BoolArray

    def model(self, problem: CurveProblem, state: MovingState) -> MovingModel:
        """The magnitudes of a state, with derivatives."""
        point = state.point
        seconds = moving.seconds_of(point, self.epoch, problem.t * problem.span)
        matrix, slopes = point.attitudes(seconds)
        sun = np.ascontiguousarray(np.einsum("nij,in->nj", matrix, problem.sun))
        observer = np.ascontiguousarray(np.einsum("nij,in->nj", matrix, problem.observer))
        if self.known is None:
            lit = convex.magnitudes(sun, observer, state.shape)
        else:
            lit = self.known.lit(sun, observer, self.least)
        across = np.einsum("nij,nj->ni", matrix, lit.across)
        of_motion = np.einsum("ni,nip->pn", across, slopes)
        jacobian = np.concatenate([of_motion, lit.by_shape])
        return MovingModel(lit.magnitude, jacobian, lit.areas, lit.slopes)

    def near(self, problem: CurveProblem, state: MovingState) -> MovingFound:
        """The cost near a state."""
        here = self.model(problem, state)
        priors = self._priors(state, here)
        made = refinement.linearised(problem, here.magnitude, here.jacobian, priors, self.fixed)
        return MovingFound(state, *made, here.areas, here.magnitude)

    def _priors(
        self, state: MovingState, here: MovingModel
    ) -> tuple[FloatArray, FloatArray, float]:
        point = state.point
        if self.known is not None:
            return np.zeros(0), np.zeros((0, point.size)), 0.0
        slopes = np.zeros((2, point.size))
        slopes[0, 6] = slopes[1, 7] = 1.0
        moments = convex.MotionMoments(point.log_ratios, slopes, False, False)
        given = state.shape, here.areas, here.slopes
        return convex.penalties(*given, moments, point.size, self.tie)

    def moved(self, best: MovingFound, step: FloatArray) -> MovingState | None:
        """The state after a step; None outside of the bounds."""
        count = best.state.point.size
        shape = step[count:]
        if len(shape):
            longest = max(float(np.abs(shape[:2]).max()), float(np.abs(shape[2:]).max()) / 3.0)
            step = step * min(1.0, 0.5 / max(longest, 1e-12))
        point = best.state.point.moved(step[:count])
        if point is None:
            return None
        new = best.state.shape + step[count:]
        if len(new) and float(np.abs(new[:2]).max()) >= 6.0:
            return None
        return MovingState(point, new)

    def minimum(
        self,
        problem: CurveProblem,
        start: MovingState,
        iterations: int = _ITERATIONS,
        gain: float = 1e-3,
    ) -> MovingFound:
        """The state of least cost near a start."""

        def at(state: MovingState) -> MovingFound:
            try:
                return self.near(problem, state)
            except AttitudeError:
                return _impossible(state, len(self.fixed), len(problem))

        return iteration.minimum(at, self.moved, start, iterations, gain)

    def weighted(self, problem: CurveProblem, start: MovingState) -> Weighted:
        """The state of largest posterior density, with Student's errors and a model error."""
        whole = problem.with_model_error(ELLIPSOID_ERROR)
        best = self.minimum(whole, start, _LAST)
        if best.chi_squared > _BAD * len(whole):
            grown = self._in_stages(whole, start)
            best = min(best, grown, key=lambda each: each.cost)
        if not math.isfinite(best.cost):
            raise AttitudeError("the start has no magnitudes at the epochs of the curve.")
        for _ in range(2):
            residual, _ = robust.residuals(whole, best.magnitude)
            whole = problem.with_model_error(robust.model_error(problem, residual))
            best = self.minimum(whole, best.state)

        def fit(own: CurveProblem, state: MovingState) -> MovingFound:
            return self.minimum(own, state, _LAST, 1e-5)

        free = int(np.count_nonzero(~self.fixed[: start.point.size]))
        return robust.student(whole, best.state, fit, free)

    def _in_stages(self, problem: CurveProblem, start: MovingState) -> MovingFound:
        """The least cost from fits of points near the epoch of the start, then of more."""
        seconds = moving.seconds_of(start.point, self.epoch, problem.t * problem.span)
        away = np.abs(seconds)
        state = start
        for share in _STAGES:
            chosen = away <= np.quantile(away, share)
            if np.count_nonzero(chosen) > 12:
                state = self.minimum(problem.part(chosen), state).state
        return self.minimum(problem, state, _LAST)


def of(
    epoch: Instant,
    problem: CurveProblem,
    point: MovingPoint,
    known: KnownShape | None,
    tie: convex.Tie,
    is_ellipsoid: bool = False,
) -> MovingFit:
    """What is fitted to a problem from a point; moments that are given or of a known shape stay."""
    fixed = np.zeros(point.size + (0 if known else convex.SIZE), bool)
    if known is not None or tie.given is not None:
        fixed[6:8] = True
    if is_ellipsoid:
        fixed[point.size + convex.ELLIPSOID :] = True
    least = 0.0 if known is None else known.floor(problem.sun.T, problem.observer.T)
    return MovingFit(epoch, known, least, tie, fixed)


def _impossible(state: MovingState, size: int, count: int) -> MovingFound:
    """What a state without magnitudes is: of infinite cost."""
    normal, gradient = np.eye(size), np.zeros(size)
    nothing = np.zeros(0), np.full(count, math.nan)
    return MovingFound(state, math.inf, math.inf, 0.0, normal, gradient, *nothing)
