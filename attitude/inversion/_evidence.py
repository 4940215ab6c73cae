"""The evidence that solutions are ranked by, and what residuals say of a solution.

-2 ln of the posterior density at its maximum, and what takes the place of the width of the peak:

| term | where |
| --- | --- |
| Student's density of the residuals about sigma and the model error | `student` |
| priors of the linear terms, of the shape, of the moments | `student`, from the cost of the fit |
| ln N for each free parameter of the motion | `student` |
| 2 ln of the frequencies tried over the share of tumbling bodies | `student`, its `trials` |
| ln det of the Hessian of orientation, rate and shape, in place of their ln N | `occam` |
| the same of a nutation, and a prior of its tilt | `of_nutation` |
| the most probable of three widths of the prior of modes | `of_narrower_prior` |
| the prior of the shape of tumbling bodies, for rotation about one axis | `of_common_prior` |
| what puts a solution behind one that fits as well and is more usual | `behind` |
| ln det of the terms with a prior, where fits differ in these | `among_problems` |
| 2 ln of the orbits tried | `among_problems` |
| ln det of the series of an orbit, where widths of its prior differ | `of_orbit` |

The evidence of fits without Student's errors is `of_fit`; that of a motion which two apparitions
have in common is `of_common_motion`.  `ranked` orders solutions, by this sum and nothing else.

Errors follow Student's distribution with five degrees of freedom, since photometry of many nights
and observers has outliers, about sigma and a model error in quadrature, which is what makes the
residuals of the best solution as large as expected.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Generic, Protocol, TypeAlias, TypeVar

import numpy as np

from attitude._support.arrays import bisected
from attitude.inversion import _neighbours, _refinement, _shapes
from attitude.inversion._ellipsoid import (
    OF_LOG_RHO,
    OF_NUTATION,
    OF_PHASE,
    OF_PRECESSION,
    SearchState,
)
from attitude.inversion._refinement import MOTION, AnyState, Evaluation, Fitted, Linearised, State

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

    from attitude._support.annotations import BoolArray, FloatArray
    from attitude.inversion._problem import CurveProblem
    from attitude.inversion._refinement import Refined
    from attitude.inversion._shapes import Tie

    Robust: TypeAlias = "Weighted[FloatArray]"


# Degrees of freedom of Student's distribution of the errors.
FREEDOM = 5.0
# Squares of normalised residuals above this do not enter the estimate of the model error.
_CUT = 9.0
# The mean of the squares below that, for normal errors.
_MEAN_BELOW = 0.9733
# The model error, mag, that any solution has at least.
_LEAST_ERROR = 0.003
# Fits with weights of Student's distribution, each with those of the residuals before it.
_ROUNDS = 2
# Relative gains at which the fits before the last one end, of which the weights are, and the last.
_ROUGH, _FINE = 1e-3, 1e-4
# Rounds in which the errors that the series of an orbit leaves are estimated.
_ROUNDS_OF_ERRORS = 4
# The largest share of their variance that neighbouring residuals are taken to have in common.
_MOST_COMMON = 0.9
# Nights at least of a standard error.
_FEWEST = 5
# Singular values of linear terms, relative to the largest, below which one is a copy.
_COPY = 1e-7
# Widths of the prior of the modes that are tried, over the one of tumbling bodies.
_NARROWER = (0.7, 0.5)
# Parameters of every motion: orientation and rate.
_ALWAYS = 4
# Parameters of the nutation, behind them.
_NUTATION = 4
# By how much a solution stands behind one that fits as well and is more usual.
_NEXT = 1.0


@dataclass(frozen=True, eq=False)
class Weighted(Generic[AnyState]):
    """A refined state with weights of its own; `Robust` is one whose state is an array (WIDTH,).

    evidence: minus twice the logarithm of the posterior density at its maximum, but for constants,
        with the terms of the table above: those of `student`, of `refined` the next three too.
    """

    refined: Linearised[AnyState]
    problem: CurveProblem  # with the weights of this solution
    evidence: float
    residual: FloatArray  # (N,), magnitudes, observed less computed, linear terms included
    chi_squared: float  # mean square of residuals over sigma and the model error


def residuals(problem: CurveProblem, magnitude: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Residuals (N,) of model magnitudes and the coefficients (L,) of the linear terms."""
    coefficients = problem.coefficients(magnitude)
    return problem.magnitude - magnitude - problem.terms @ coefficients, coefficients


def model_error(problem: CurveProblem, residual: FloatArray) -> float:
    """The error, mag, that has to be added to sigma for the residuals to be as expected."""

    def is_too_small(error: float) -> bool:
        squares = residual**2 / (problem.sigma**2 + error**2)
        below = squares < _CUT
        return not np.any(below) or float(np.mean(squares[below])) > _MEAN_BELOW

    low, high = bisected(is_too_small, _LEAST_ERROR, 2.0, 40)
    return low if high > _LEAST_ERROR * 1.01 else _LEAST_ERROR


def with_error_of(problem: CurveProblem, magnitude: FloatArray) -> CurveProblem:
    """The problem with the model error that the residuals of model magnitudes (N,) show."""
    residual, _ = residuals(problem, magnitude)
    return problem.with_model_error(model_error(problem, residual))


def refined(
    problem: CurveProblem,
    start: FloatArray,
    *,
    tie: Tie,
    fixed: BoolArray,
    trials: float = 1.0,
    held: BoolArray | None = None,
) -> Robust:
    """The state of largest posterior density near a start, with Student's errors.

    `held` (K,): parameters that stay in the fit, in place of `fixed`, and count as free.
    """
    stay = fixed if held is None else held

    def fit(reweighted: CurveProblem, state: FloatArray, gain: float) -> Evaluation[FloatArray]:
        return _refinement.refine(reweighted, state, tie=tie, fixed=stay, gain=gain)

    robust = student(problem, start, fit, int(np.count_nonzero(~fixed[:MOTION])), trials)
    if held is not None:
        there = _refinement.refine(
            robust.problem, robust.refined.state, tie=tie, fixed=fixed, iterations=0
        ).linearised
        robust = replace(robust, refined=there)
    evidence = robust.evidence + occam(robust.refined.normal, len(problem))
    if not fixed[:MOTION].any():
        evidence += of_nutation(robust.refined, len(problem))
    if tie.is_wide or not fixed[:MOTION].any():
        evidence += of_narrower_prior(robust.refined, fixed)
    return replace(robust, evidence=evidence)


def occam(normal: FloatArray, points: int) -> float:
    """What replaces ln N for orientation and rate: the log-determinant of a Hessian."""
    kept = np.ones(len(normal), bool)
    kept[_ALWAYS : _ALWAYS + _NUTATION] = False
    inner = normal[np.ix_(kept, kept)].copy()
    inner[range(_ALWAYS), range(_ALWAYS)] += 1.0
    return float(np.linalg.slogdet(inner)[1]) - _ALWAYS * float(np.log(points))


def of_nutation(fitted: Refined, points: int) -> float:
    """What replaces ln N for the parameters of a nutation: the volume of its posterior density.

    The logarithm of the determinant of their Hessian, with all others marginal, and a prior that is
    uniform in phase, x and tilt, 2 atan(rho).  By ln rho alone a tilt of one degree would be as
    probable as one between 40 and 90, and noise looks like small ones.
    """
    inner = fitted.normal.copy()
    inner[range(_ALWAYS), range(_ALWAYS)] += 1.0
    volume = float(np.linalg.slogdet(inner)[1]) - occam(fitted.normal, 1)
    volume -= _NUTATION * math.log(2.0 * math.pi * points)
    tilt = 2.0 * math.log(0.5 * math.pi * math.cosh(SearchState.of(fitted.state).log_rho))
    return volume + tilt


def of_narrower_prior(fitted: Refined, fixed: BoolArray) -> float:
    """What the most probable width of the prior of modes adds to the evidence, 0 or less.

    Under a wide prior alone, a motion that shows all sides of a body is the less probable, the more
    it says of the shape.  Another width moves the maximum: by the second derivatives there.
    """
    state, normal = fitted.state, fitted.normal
    modes = np.arange(MOTION + _shapes.ELLIPSOID, min(_refinement.SIZE, len(normal)))
    if fixed[modes].any():
        return 0.0
    values, least = state[modes + len(state) - len(normal)], 0.0
    wide, weights_of = occam(normal, 1), _shapes.widths(is_axial=False)[modes - MOTION] ** -2.0
    for scale in _NARROWER:
        more = (scale**-2 - 1.0) * weights_of
        narrower, pull = normal.copy(), np.zeros(len(normal))
        narrower[modes, modes] += more
        pull[modes] = more * values
        cost = float(more @ values**2 - pull @ np.linalg.solve(narrower, pull))
        volume = occam(narrower, 1) - wide + 2.0 * len(modes) * math.log(scale)
        least = min(least, cost + volume)
    return least


def of_fit(fit: Refined, points: int) -> float:
    """The evidence of a fit by least squares, without Student's errors, to compare such fits."""
    return fit.cost + occam(fit.normal, points)


def of_orbit(
    values: FloatArray, along: FloatArray, left: FloatArray, points: float, least: float
) -> float:
    """The evidence of terms of an orbit beside a body, with amplitudes of unit variance.

    values (M,): eigenvalues of their products; along (M,): squares of the products of these
    combinations with what the body leaves (N,) of so many points.  Errors are those that the terms
    leave, of a variance of `least` or more.
    """
    total = float(left @ left)
    size = 1.0
    for _ in range(_ROUNDS_OF_ERRORS):
        # chi-squared over the points less the terms that are not held
        chi_squared = total - float(np.sum(along * (values + 2.0 * size) / (values + size) ** 2))
        size = max(least, chi_squared / (points - float(np.sum(values / (values + size)))))
    whole = total - float(np.sum(along / (values + size)))
    return whole / size + points * math.log(size) + float(np.sum(np.log1p(values / size)))


def of_common_motion(chi_squared: float, first: float, second: float) -> float:
    """The evidence of a motion that two solutions have in common, from theirs.

    `chi_squared` is that of the differences of the two from the motion.
    """
    return chi_squared + first + second


def of_common_prior(best: Weighted[object], compared: Weighted[object]) -> float:
    """What the prior of tumbling bodies adds to the evidence of rotations about one axis.

    Their own prior ranks their poles, so that all get what the best one, fitted with either, gets.
    """
    return compared.evidence - best.evidence


def behind(evidence: float) -> float:
    """The evidence of a solution that stands next behind another one."""
    return evidence + _NEXT


def with_term(solution: Robust, term: float) -> Robust:
    """The solution with a term added to its evidence."""
    return replace(solution, evidence=solution.evidence + term)


def at_least(solution: Robust, least: float) -> Robust:
    """The solution with an evidence of no less than so much."""
    return replace(solution, evidence=max(solution.evidence, least))


def among_problems(solution: Weighted[object], orbits: float = 1.0) -> float:
    """The evidence of a solution among those of other zero points and other series of orbits.

    `orbits`: how many were tried.  The more, the better one fits by chance.
    """
    return solution.evidence + volume_of_offsets(solution.problem) + 2.0 * math.log(orbits)


class HasEvidence(Protocol):
    """A solution of any kind."""

    @property
    def evidence(self) -> float:
        """-2 ln of the posterior density."""


Ranked = TypeVar("Ranked", bound=HasEvidence)


def ranked(solutions: Iterable[Ranked]) -> list[Ranked]:
    """Solutions, the most probable first."""
    return sorted(solutions, key=lambda solution: solution.evidence)


def gain_of_nutation(solution: Robust) -> float:
    """By how much a nutation of the body, fitted, would reduce chi-squared.

    Of a rotation about one axis; the nutation is that of the settings, of the rate and the phase
    that show least, less what pole, rotation and shape make up for.
    """
    problem, state = solution.problem, solution.refined.state.copy()
    fixed = np.zeros(_refinement.SIZE, bool)
    fixed[[_refinement.NUTATION, _refinement.X]] = True
    # a small nutation is linear in rho: its slopes by phase, rad, and ln rho are its two halves
    halves = np.array([_refinement.PHASE, _refinement.LN_RHO])
    scale = np.array([0.5 / math.pi, 1.0])
    others = np.setdiff1d(np.arange(_refinement.SIZE), halves)
    state[OF_PHASE] = 0.0
    state[OF_LOG_RHO] = math.log(problem.settings.noticed)
    gains = []
    for rate in problem.settings.noticed_rates:
        state[OF_NUTATION] = -2.0 * rate * state[OF_PRECESSION]
        normal = _refinement.refine(
            problem, state, tie=_shapes.Tie(math.inf), fixed=fixed, iterations=0
        ).linearised.normal
        along = normal[np.ix_(others, halves)]
        made_up = along.T @ np.linalg.lstsq(normal[np.ix_(others, others)], along, rcond=None)[0]
        left = (normal[np.ix_(halves, halves)] - made_up) * np.outer(scale, scale)
        gains.append(float(np.linalg.eigvalsh(left)[0]))
    return min(gains)


def weights(square: FloatArray) -> FloatArray:
    """Weights (N,) of Student's distribution for squares of residuals over their errors."""
    return (FREEDOM + 1.0) / (FREEDOM + square)


def student(
    problem: CurveProblem,
    start: State,
    fit: Callable[[CurveProblem, State, float], Evaluation[State]],
    free: int,
    trials: float = 1.0,
) -> Weighted[State]:
    """The state of largest posterior density near a start, with Student's errors.

    `fit` is given the relative gain at which it ends.
    """
    state, reweighted, size = start, problem, problem.errors
    for turn in range(_ROUNDS + 1):
        evaluation = fit(reweighted, state, _ROUGH if turn < _ROUNDS else _FINE)
        fitted, state = evaluation.fitted, evaluation.fitted.state
        residual, coefficients = residuals(reweighted, fitted.magnitude)
        square = (residual / size) ** 2
        if turn < _ROUNDS:
            reweighted = replace(problem, sigma=size / np.sqrt(weights(square)), model_error=0.0)
    evidence = (FREEDOM + 1.0) * float(np.sum(np.log1p(square / FREEDOM)))
    evidence += 2.0 * float(np.sum(np.log(size)))
    evidence += float(np.sum((coefficients / problem.prior) ** 2))
    evidence += fitted.cost - fitted.chi_squared
    evidence += free * float(np.log(len(problem))) + 2.0 * float(np.log(trials))
    return Weighted(evaluation.linearised, reweighted, evidence, residual, float(np.mean(square)))


def constant(problem: CurveProblem) -> Weighted[None]:
    """The linear terms alone, magnitudes of 0, with the model error that their residuals show."""
    zeros = np.zeros(len(problem))

    nothing = np.zeros(0)

    def fit(reweighted: CurveProblem, _: None, __: float) -> Evaluation[None]:
        chi = reweighted.chi_squared(zeros)
        fitted = Fitted(None, cost=chi, chi_squared=chi, strain=0.0, areas=nothing, magnitude=zeros)
        return Evaluation(fitted, lambda: (nothing[:, None], nothing))

    for _ in range(2):
        problem = with_error_of(problem, zeros)
    return student(problem, None, fit, 0)


def volume_of_offsets(problem: CurveProblem) -> float:
    """What an evidence lacks of the terms that have a prior, where their number differs.

    The logarithm of the determinant of their Hessian, over that of the prior, free terms marginal:
    many offsets that are hardly held fit better by chance.
    """
    scaled = problem.terms * problem.root[:, None]
    free = np.isinf(problem.prior)
    held = scaled[:, ~free] * problem.prior[~free]
    basis, size, _ = np.linalg.svd(scaled[:, free], full_matrices=False)
    basis = basis[:, size > _COPY * size.max(initial=0.0)]
    held = held - basis @ (basis.T @ held)
    return float(np.linalg.slogdet(np.eye(held.shape[1]) + held.T @ held)[1])


def share_left(solution: Weighted[object], problem: CurveProblem) -> float:
    """Mean square of residuals over that of magnitudes less linear terms, as in `floor_ratio`."""
    worst = problem.settings.worst
    whole = problem.detrended - np.median(problem.detrended)
    left, before = (_neighbours.trimmed(values**2, worst) for values in (solution.residual, whole))
    return left / max(before, 1e-12)


def floor_ratio(solution: Weighted[object], problem: CurveProblem) -> float:
    """Mean square of the residuals over sigma and 0.01 mag, without outliers."""
    squares = solution.residual**2 / (problem.sigma**2 + problem.settings.floor_error**2)
    return _neighbours.trimmed(squares, problem.settings.worst)


def standard_error(
    solution: Weighted[object], other: Weighted[object], problem: CurveProblem
) -> float:
    """That of the difference of -2 ln(likelihood) of two solutions, from its parts of the nights.

    Residuals of a model that errs are correlated within a night: a difference counts as many
    points as one.  Source: Vuong, Econometrica 57, 307 (1989), with nights as samples.
    """
    less = _less_likely(solution, other, problem.sigma**2 + problem.model_error**2)
    gains = (FREEDOM + 1.0) * less
    nights = _neighbours.nights_of(problem.seconds)
    parts = [np.sum(gains[night]) for night in nights]
    if len(parts) < _FEWEST:
        return 0.0
    return float(np.sqrt(len(parts) * np.var(parts, ddof=1)))


def redundancy(solution: Robust, problem: CurveProblem) -> float:
    """How many points count as one in a difference of evidence, where the model errs.

    (1 + r) / (1 - r), of a sequence of residuals in which neighbours have the correlation r.
    """
    turns = sum(SearchState.of(solution.refined.state).rates)
    common = min(_neighbours.common_share(problem, solution.residual, turns), _MOST_COMMON)
    return (1.0 + common) / (1.0 - common) if common > problem.settings.correlated else 1.0


def gain(
    solution: Weighted[object],
    other: Weighted[object],
    problem: CurveProblem,
    points: BoolArray | slice = slice(None),
) -> float:
    """The difference of -2 ln(likelihood) by which a solution fits some points better than another.

    By Student's distribution about sigma and 0.01 mag, or about the larger errors that the solution
    itself leaves; without priors and the number of parameters.
    """
    size = max(1.0, floor_ratio(solution, problem)) * (
        problem.sigma**2 + problem.settings.floor_error**2
    )
    return (FREEDOM + 1.0) * float(np.sum(_less_likely(solution, other, size)[points]))


def _less_likely(
    solution: Weighted[object], other: Weighted[object], size: FloatArray
) -> FloatArray:
    """-2 ln of Student's densities (N,) of two solutions over FREEDOM + 1; size: squared errors."""
    logs = [np.log1p(one.residual**2 / size / FREEDOM) for one in (solution, other)]
    return logs[1] - logs[0]
