"""Samples of the motion from its posterior density, by emcee, from all competing solutions.

The eight parameters of the motion are sampled (`_errors.log_density`).  Solutions that compete are
sampled one by one, and weighted by their evidence and the volume of their errors.  The density is
that of independent errors; its samples are widened as the covariance is, see `_errors`.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from attitude._support import validation
from attitude.errors import AttitudeError
from attitude.inversion import _errors, _refinement, _states

if TYPE_CHECKING:
    from attitude._support.annotations import FilePath, FloatArray, IntArray
    from attitude.inversion._solution import Solution
    from attitude.motions._free_rotation import FreeRotation


NAMES: tuple[str, ...] = ("x", "y", "z", "precession", "nutation", "phase", "ln rho", "X")


@dataclass(frozen=True, eq=False)
class Posterior:
    """Samples of motions.

    Attributes
    ----------
    offsets : (S, 8) array
        Rotation vector (rad, axes along the momentum), precession and nutation (turns per span),
        phase (turns), ln rho and X, from those of the solution that each sample belongs to.
    solution : (S,) array of int
        The number of that solution, among those sampled.
    weights : (K,) array
        Of the solutions.
    covariance : (8, 8) array
        Of the parameters of the first solution, to compare.
    acceptance : float
        Mean share of the moves accepted.
    """

    offsets: FloatArray
    solution: IntArray
    weights: FloatArray
    covariance: FloatArray
    acceptance: float
    origins: tuple[Any, ...]

    def __len__(self) -> int:
        return len(self.offsets)

    @property
    def ratio(self) -> FloatArray:
        """Standard deviations (8,) of the samples of the first solution over the covariance's."""
        own = self.offsets[self.solution == 0]
        formal = np.sqrt(np.diag(self.covariance))
        spread = own.std(axis=0)
        found: FloatArray = np.divide(spread, formal, out=np.ones(8), where=formal > 0.0)
        return found

    def motions(self, count: int, seed: int = 0) -> list[FreeRotation]:
        """Motions of samples drawn at random, solutions by their weights."""
        number = validation.count(count, "count")
        generator = validation.generator(seed)
        found = []
        for which in generator.choice(len(self.weights), number, p=self.weights):
            row = generator.choice(np.flatnonzero(self.solution == which))
            origin = self.origins[which]
            state = _errors.moved(origin.state, self.offsets[row])
            found.append(_states.motion(state, origin.curve.span, origin.curve.epoch, None))
        return found

    def plot(self, path: FilePath | None = None) -> Any:
        """A corner figure of the first solution's parameters; saved if a path is given."""
        from attitude import plots

        figure = plots.new_figure((12.0, 12.0))
        axes = figure.subplots(8, 8)
        own = self.offsets[self.solution == 0]
        for row in range(8):
            for column in range(8):
                here = axes[row, column]
                if column > row:
                    here.set_visible(False)
                elif column == row:
                    here.hist(own[:, row], 30, color="#0072b2")
                else:
                    here.plot(own[:, column], own[:, row], ",", color="#0072b2")
                if row == 7:
                    here.set_xlabel(NAMES[column], fontsize=8)
                here.tick_params(labelsize=5)
        if path is not None:
            figure.savefig(path, dpi=130)
        return figure


def sampled(
    solutions: list[Solution], method: str, walkers: int, steps: int, seed: int
) -> Posterior:
    """The posterior of competing solutions, the first of which is described."""
    validation.one_of(method, "method", ("emcee",))
    validation.count(walkers, "walkers", 17)
    validation.count(steps, "steps", 20)
    try:
        import emcee
    except ImportError as err:
        raise AttitudeError(
            f"posterior needs emcee, which is not installed; install it by "
            f"{validation.installing('posterior')}."
        ) from err
    if solutions[0].is_axial:
        raise AttitudeError(
            "the solution rotates about one axis, whose nutation has no parameters to sample; take "
            "its covariance."
        )
    solutions = [each for each in solutions if not each.is_axial]
    generator = validation.generator(seed)
    parts, numbers, logs, accepted = [], [], [], []
    for number, each in enumerate(solutions):
        factor: FloatArray = np.asarray(
            np.linalg.cholesky(_errors.conditioned(each._covariances[1].formal)),
            dtype=np.float64,
        )
        density = _errors.log_density(each.weighted, each.tie, factor)
        sampler = emcee.EnsembleSampler(walkers, 8, density)
        sampler.random_state = np.random.RandomState(int(generator.integers(2**32))).get_state()
        with _refinement.limited():
            sampler.run_mcmc(0.5 * generator.standard_normal((walkers, 8)), steps)
        chain = sampler.get_chain(discard=steps // 4, flat=True)
        parts.append(chain @ factor.T @ each._covariances[1].widening.T)
        numbers.append(np.full(len(chain), number))
        logs.append(-0.5 * each.evidence + float(np.sum(np.log(np.diag(factor)))))
        accepted.append(float(np.mean(sampler.acceptance_fraction)))
    weights = np.exp(np.array(logs) - max(logs))
    return Posterior(
        np.concatenate(parts),
        np.concatenate(numbers),
        weights / weights.sum(),
        solutions[0]._covariances[1].covariance,
        float(np.mean(accepted)),
        tuple(solutions),
    )
