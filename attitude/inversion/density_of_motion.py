"""The posterior density of the eight parameters of a motion, with the shape that fits each best.

Areas follow a motion as they do to first order, and from there by one Gauss-Newton step: without
the former, a motion three standard errors away has a step so long that its predicted gain is 6 too
large.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from attitude.inversion import many_starts, moments_of_elements, population, refinement

if TYPE_CHECKING:
    from collections.abc import Callable

    from attitude.annotations import FloatArray
    from attitude.inversion.convex import Tie
    from attitude.inversion.robust import Weighted

# Parameters of the motion.
SIZE = 8
_SEED = 20180708


def covariance(found: Weighted, tie: Tie) -> FloatArray:
    """Second moments (8, 8) of the parameters about those of a solution."""
    factor = np.linalg.cholesky(conditioned(refinement.inverse(found.refined.normal)[:SIZE, :SIZE]))
    density = log_density(found, tie, np.asarray(factor, dtype=np.float64))
    wide = population.second_moments(density, SIZE, np.random.default_rng(_SEED))
    moments: FloatArray = factor @ wide @ factor.T
    return moments


def log_density(found: Weighted, tie: Tie, factor: FloatArray) -> Callable[[FloatArray], float]:
    """The logarithm of the density of offsets (8,) in units of a factor (8, 8) of a covariance."""
    problem, state, normal = found.problem, found.refined.state, found.refined.normal
    follow = -np.linalg.solve(normal[SIZE:, SIZE:], normal[SIZE:, :SIZE])
    ratios = np.empty(4)

    def density(scaled: FloatArray) -> float:
        offsets = factor @ scaled
        trial = moved(state, offsets)
        trial[14:] += follow @ offsets
        inside = many_starts.LEAST_X < trial[4] < many_starts.MOST_X
        if not (inside and many_starts.LEAST_RHO < trial[3] < many_starts.MOST_RHO):
            return -math.inf
        moments_of_elements.log_ratios(trial[0], trial[1], trial[3], trial[4], ratios)
        if not ratios[2]:
            return -math.inf
        return -0.5 * refinement.profiled_cost(problem, trial, tie)

    return density


def moved(state: FloatArray, offsets: FloatArray) -> FloatArray:
    """The state after a change of the eight parameters."""
    step = np.zeros(refinement.SIZE)
    step[:SIZE] = offsets
    found = state.copy()
    many_starts.moved(state, step, found)
    return found


def conditioned(covariance: FloatArray) -> FloatArray:
    """A covariance whose factor exists."""
    found: FloatArray = covariance + 1e-12 * np.diag(np.diag(covariance))
    return found
