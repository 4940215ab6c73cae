"""Refinement with Student's distribution of errors, and the error of the model from residuals.

Photometry of many nights and observers has outliers, and a convex body with one scattering law
leaves errors of its own.  Weights follow Student's distribution with five degrees of freedom about
sigma and a model error in quadrature; the model error is what makes the residuals of the best
solution as large as expected.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol, TypeVar

import numpy as np

from attitude.inversion import convex, refinement

if TYPE_CHECKING:
    from collections.abc import Callable

    from attitude.annotations import BoolArray, FloatArray
    from attitude.inversion.convex import Tie
    from attitude.inversion.problem import CurveProblem
    from attitude.inversion.refinement import Refined

State = TypeVar("State")
Found = TypeVar("Found", covariant=True)


class Fitted(Protocol[Found]):
    """What a fit returns, such as `Refined`."""

    @property
    def state(self) -> Found:
        """Of the least cost."""

    @property
    def cost(self) -> float:
        """The least cost."""

    @property
    def chi_squared(self) -> float:
        """Its part of the magnitudes."""

    @property
    def magnitude(self) -> FloatArray:
        """Of the model (N,)."""


FREEDOM = 5.0
# Squares of normalised residuals above this do not enter the estimate of the model error, and the
# mean of the others for normal errors.
_CUT, _MEAN_BELOW = 9.0, 0.9733
_LEAST_ERROR = 0.003
# Mean square of residuals over sigma and 0.01 mag of a solution that is accepted.
FLOOR, FLOOR_ERROR = 1.0, 0.01
_ROUNDS = 2
# Singular values of linear terms, relative to the largest, below which one is a copy.
_COPY = 1e-7
# Parameters of the motion: orientation and rate, of every motion, and those of the nutation.
_ALWAYS, _NUTATION = 4, 4


@dataclass(frozen=True, eq=False)
class Weighted:
    """A refined state with weights of its own.

    Attributes
    ----------
    refined : Refined, or what another fit returned
    problem : CurveProblem
        With the weights of this solution.
    evidence : float
        Minus twice the logarithm of the posterior density at its maximum, but for constants, plus
        ln N for each free parameter of the motion; of `refined`, the logarithm of the determinant
        of the Hessian of orientation, rate and shape in place of theirs.
    residual : (N,) array
        Magnitudes, observed less computed, linear terms included.
    chi_squared : float
        Mean square of residuals over sigma and the model error.
    """

    refined: Any
    problem: CurveProblem
    evidence: float
    residual: FloatArray
    chi_squared: float


def residuals(problem: CurveProblem, magnitude: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Residuals (N,) of model magnitudes and the coefficients (L,) of the linear terms."""
    coefficients = problem.coefficients(magnitude)
    return problem.magnitude - magnitude - problem.terms @ coefficients, coefficients


def model_error(problem: CurveProblem, residual: FloatArray) -> float:
    """The error, mag, that has to be added to sigma for the residuals to be as expected."""
    low, high = _LEAST_ERROR, 2.0
    for _ in range(40):
        middle = 0.5 * (low + high)
        squares = residual**2 / (problem.sigma**2 + middle**2)
        below = squares < _CUT
        mean = np.mean(squares[below]) if np.any(below) else np.inf
        low, high = (middle, high) if mean > _MEAN_BELOW else (low, middle)
    return low if high > _LEAST_ERROR * 1.01 else _LEAST_ERROR


def refined(
    problem: CurveProblem,
    start: FloatArray,
    *,
    tie: Tie,
    fixed: BoolArray | None = None,
    iterations: int = 20,
    gain: float = 1e-4,
    trials: float = 1.0,
) -> Weighted:
    """The state of largest posterior density near a start, with Student's errors.

    Parameters
    ----------
    problem : CurveProblem
        With the model error.
    start, tie, fixed
        As of `refinement.refine`.
    trials : float
        Frequencies that were tried; twice its logarithm is added to the evidence.
    """

    def fit(own: CurveProblem, state: FloatArray) -> Refined:
        return refinement.refine(own, state, tie=tie, fixed=fixed, iterations=iterations, gain=gain)

    free = 8 if fixed is None else int(np.count_nonzero(~fixed[:8]))
    found = student(problem, start, fit, free, trials)
    return replace(found, evidence=found.evidence + occam(found.refined.normal, len(problem)))


def occam(normal: FloatArray, points: int) -> float:
    """What replaces ln N for orientation and rate: the logarithm of the determinant of a Hessian.

    Of orientation, rate and shape, by Laplace's method: of two poles that fit equally well, the
    one that more orientations and shapes make fit is more probable.  Parameters of the nutation
    keep ln N each.
    """
    kept = np.ones(len(normal), bool)
    kept[_ALWAYS : _ALWAYS + _NUTATION] = False
    inner = normal[np.ix_(kept, kept)].copy()
    inner[range(_ALWAYS), range(_ALWAYS)] += 1.0
    return float(np.linalg.slogdet(inner)[1]) - _ALWAYS * float(np.log(points))


def widened(found: Weighted) -> float:
    """What the evidence of a rotation about one axis changes by under the prior of tumbling bodies.

    By Laplace's method: the cost of its minimum with the wider prior, after one step of Newton's,
    and the determinant there.
    """
    normal, shape = found.refined.normal, found.refined.state[-convex.SIZE :]
    free = np.diag(normal)[-convex.SIZE :] != 1.0
    less = convex.widths(True) ** -2.0 - convex.widths(False) ** -2.0
    less[~free] = 0.0
    inner = normal.copy()
    at = np.arange(len(normal) - convex.SIZE, len(normal))
    inner[at, at] -= less
    pull = np.zeros(len(normal))
    pull[at] = less * shape
    cost = -float(shape @ pull[at] + pull @ np.linalg.solve(inner, pull))
    points = len(found.problem)
    return cost + occam(inner, points) - occam(normal, points)


def student(
    problem: CurveProblem,
    start: State,
    fit: Callable[[CurveProblem, State], Fitted[State]],
    free: int,
    trials: float = 1.0,
) -> Weighted:
    """The state of largest posterior density near a start, with Student's errors.

    Parameters
    ----------
    problem : CurveProblem
        With the model error.
    start : state
    fit : callable
        The least squares of a problem near a state.
    free : int
        Parameters of the motion that are found.
    trials : float
        As of `refined`.
    """
    state, own = start, problem
    size = np.hypot(problem.sigma, problem.model_error)
    for turn in range(_ROUNDS + 1):
        found = fit(own, state)
        state = found.state
        residual, coefficients = residuals(own, found.magnitude)
        square = (residual / size) ** 2
        if turn < _ROUNDS:
            own = problem.with_sigma(size / np.sqrt((FREEDOM + 1.0) / (FREEDOM + square)))
    evidence = (FREEDOM + 1.0) * float(np.sum(np.log1p(square / FREEDOM)))
    evidence += 2.0 * float(np.sum(np.log(size)))
    evidence += float(np.sum((coefficients / problem.prior) ** 2))
    evidence += found.cost - found.chi_squared
    evidence += free * float(np.log(len(problem))) + 2.0 * float(np.log(trials))
    return Weighted(found, own, evidence, residual, float(np.mean(square)))


class Constant(NamedTuple):
    """What fits a curve of constant brightness: no parameters, magnitudes (N,) of zero."""

    state: None
    cost: float
    chi_squared: float
    magnitude: FloatArray


def constant(problem: CurveProblem) -> Weighted:
    """The linear terms alone, with the model error that their residuals show."""
    zeros = np.zeros(len(problem))

    def fit(own: CurveProblem, _: None) -> Constant:
        chi_squared = own.chi_squared(zeros)
        return Constant(None, chi_squared, chi_squared, zeros)

    for _ in range(2):
        residual, _ = residuals(problem, zeros)
        problem = problem.with_model_error(model_error(problem, residual))
    return student(problem, None, fit, 0)


def volume_of_offsets(own: CurveProblem) -> float:
    """What an evidence lacks of the terms that have a prior, where their number differs.

    The logarithm of the determinant of their Hessian, over that of the prior, free terms marginal:
    many offsets that are hardly held fit better by chance.
    """
    scaled = own.terms * own.root[:, None]
    free = np.isinf(own.prior)
    held = scaled[:, ~free] * own.prior[~free]
    basis, size, _ = np.linalg.svd(scaled[:, free], full_matrices=False)
    basis = basis[:, size > _COPY * size.max(initial=0.0)]
    held = held - basis @ (basis.T @ held)
    return float(np.linalg.slogdet(np.eye(held.shape[1]) + held.T @ held)[1])


def share_left(solution: Weighted, problem: CurveProblem) -> float:
    """Variance of the residuals over that of the magnitudes without the linear terms."""
    return float(np.var(solution.residual)) / max(float(np.var(problem.detrended)), 1e-12)


def floor_ratio(solution: Weighted, problem: CurveProblem) -> float:
    """Mean square of the residuals over sigma and 0.01 mag, without outliers."""
    squares = solution.residual**2 / (problem.sigma**2 + FLOOR_ERROR**2)
    return float(np.mean(np.sort(squares)[: max(1, int(0.97 * len(squares)))]))


def gain(solution: Weighted, other: Weighted, problem: CurveProblem) -> float:
    """The difference of -2 ln(likelihood) by which a solution fits better than another one.

    By Student's distribution about sigma and 0.01 mag, or about the larger errors that the solution
    itself leaves; without priors and the number of parameters.
    """
    size = max(1.0, floor_ratio(solution, problem)) * (problem.sigma**2 + FLOOR_ERROR**2)
    logs = [np.log1p(each.residual**2 / size / FREEDOM) for each in (solution, other)]
    return (FREEDOM + 1.0) * float(np.sum(logs[1] - logs[0]))
