"""Levenberg and Marquardt's iteration for least squares, of many states side by side.

A problem linearises its residuals near states and moves states; damping, acceptance and ends are
here.  One fit is a batch of one.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from attitude._support.annotations import BoolArray, FloatArray


class Near(NamedTuple):
    """States (S, ...), numbers or objects, and their costs (S,), sums of squares of residuals.

    normal (S, P, P) is half their second derivatives, from first ones of the residuals, gradient
    (S, P) minus half their first ones.  A parameter that stays has the rows of the unit matrix and
    the gradient 0.
    """

    states: NDArray[Any]
    cost: FloatArray
    normal: FloatArray
    gradient: FloatArray


@dataclass(frozen=True)
class Problem:
    """What is fitted.

    linearised(states): the costs near states, infinite where there are none.
    moved(states, steps): the states after steps (S, P), and which of them are within the bounds.
    costs(states): costs alone, for the last step, behind which no derivatives are needed; None
        where the result has to have them.
    is_cost_first: whether costs of all steps are computed so, and derivatives only where a step
        follows: those of the result may be of an earlier state.
    enough(states): decreases of half the cost; the iteration ends where no step promises more.
    steps(near, damping): what `damped_steps` returns, for batches in less time.
    """

    linearised: Callable[[NDArray[Any]], Near]
    moved: Callable[[NDArray[Any], FloatArray], tuple[NDArray[Any], BoolArray]]
    costs: Callable[[NDArray[Any]], FloatArray] | None = None
    enough: Callable[[NDArray[Any]], FloatArray] | None = None
    is_cost_first: bool = False
    steps: Callable[[Near, FloatArray], FloatArray] | None = None


class Rule(NamedTuple):
    """Damping and ends of an iteration.

    start, least: damping at the start and at least, relative to the diagonal.
    stuck: damping at which no step lowers the cost.
    larger: factor of the damping after a step that fails; `_SMALLER` after others.
    gain: relative decrease of the cost at which a state ends.
    settled: evaluations, that of the start too, after which it may end.
    ridge: what is added to the damping, against rounding.
    bounds_count: whether a round counts as an evaluation where the steps of all states leave the
        bounds, so that there is none.
    """

    start: float
    least: float
    stuck: float
    larger: float
    gain: float
    settled: int
    ridge: float = 0.0
    bounds_count: bool = True


_SMALLER = 0.3


def minimum(
    problem: Problem,
    starts: NDArray[Any],
    rule: Rule,
    evaluations: int,
    is_over: Callable[[], bool] | None = None,
) -> Near:
    """The states of least cost near starts, after at most so many evaluations of each.

    A step that leaves the bounds fails as one does that raises the cost.
    """
    best = problem.linearised(starts.copy())
    damping = np.full(len(starts), rule.start)
    # those that go on
    on = np.flatnonzero(np.isfinite(best.cost))
    count = 1
    while on.size and count < evaluations:
        active = best if len(on) == len(starts) else Near(*(column[on] for column in best))
        steps = (problem.steps or damped_steps)(active, damping[on] + rule.ridge)
        if problem.enough is not None:
            bend = (active.normal @ steps[:, :, None])[:, :, 0]
            promised = np.sum(steps * (active.gradient - 0.5 * bend), axis=1)
            if np.all(promised <= problem.enough(active.states)):
                break
        new, allowed = problem.moved(active.states, steps)
        cost = np.full(len(on), np.inf)
        is_inside = bool(allowed.any())
        count += is_inside or rule.bounds_count
        if is_inside:
            new = new[allowed]
            if problem.costs is not None and (problem.is_cost_first or count == evaluations):
                trial: tuple[NDArray[Any], ...] = new, problem.costs(new)
            else:
                trial = problem.linearised(new)
            cost[allowed] = trial[1]
        gain = active.cost - cost
        better = gain > 0.0
        if better.any():
            won, lower = on[better], better[allowed]
            for column, values in zip(best, trial, strict=False):
                column[won] = values[lower]
        damping[on] *= np.where(better, _SMALLER, rule.larger)
        damping = np.maximum(damping, rule.least)
        ended = ~better & (damping[on] >= rule.stuck)
        if count > rule.settled:
            ended |= better & (gain < rule.gain * cost)
        if problem.is_cost_first and count < evaluations and np.any(better & ~ended):
            won = on[better & ~ended]
            for column, values in zip(best, problem.linearised(best.states[won]), strict=True):
                column[won] = values
        on = on[~ended]
        if is_over is not None and is_over():
            break
    return best


def damped_steps(linearised: Near, damping: FloatArray) -> FloatArray:
    """The steps (S, P) for damping (S,), relative to the diagonal."""
    scaled, right, scale = _scaled(linearised, damping)
    return np.linalg.solve(scaled, right[:, :, None])[:, :, 0] / scale


def steps_of_one(linearised: Near, damping: FloatArray) -> FloatArray:
    """As `damped_steps`, of one state: with many parameters in less time."""
    scaled, right, scale = _scaled(linearised, damping)
    return solved(scaled[0], right[0])[None] / scale


def _scaled(linearised, damping):
    """Normal matrices scaled to a diagonal of ones and damped, gradients, and the scales."""
    diagonal = np.arange(linearised.normal.shape[-1])
    scale = np.sqrt(np.maximum(linearised.normal[:, diagonal, diagonal], 0.0)) + 1e-12
    scaled = linearised.normal / (scale[:, :, None] * scale[:, None, :])
    scaled[:, diagonal, diagonal] += damping[:, None]
    return scaled, linearised.gradient / scale, scale


# ---- Normal matrices, whose parameters may have any units


def solved(normal: FloatArray, right: FloatArray) -> FloatArray:
    """The solution (P,), by Cholesky's factors where rounding leaves a matrix that has them."""
    from scipy.linalg.lapack import dposv

    _, solution, failed = dposv(normal, right, lower=1)
    return np.asarray(np.linalg.solve(normal, right) if failed else solution, np.float64)


class Decomposed:
    """A normal matrix, scaled to a diagonal of ones, by its eigenvalues and vectors.

    scale: (P,), roots of the diagonal, or those given; 1 in place of 0.
    empty: (P,) array of bool, parameters whose scale is 0: no residual depends on them.
    values, vectors: (P,) and (P, P) arrays
    """

    def __init__(self, normal: FloatArray, scale: FloatArray | None = None) -> None:
        size = np.sqrt(np.maximum(np.diag(normal), 0.0)) if scale is None else scale
        self.empty = size == 0.0
        self.scale = np.where(self.empty, 1.0, size)
        self.values, self.vectors = np.linalg.eigh(normal / np.outer(self.scale, self.scale))

    def inverse_factor(self, least: float) -> FloatArray:
        """W (P, K) with W W^T the inverse, without eigenvalues up to the least."""
        kept = self.values > least
        factor: FloatArray = self.vectors[:, kept] / np.sqrt(self.values[kept])
        return factor / self.scale[:, None]


def inverse(normal: FloatArray) -> FloatArray:
    """The inverse (P, P) of a normal matrix; 0 where it has none."""
    scale = np.sqrt(np.maximum(np.diag(normal), 0.0))
    scale[scale == 0.0] = 1.0
    size = np.outer(scale, scale)
    return np.linalg.pinv(normal / size, hermitian=True) / size
