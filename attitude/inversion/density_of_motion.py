"""The posterior density of the parameters of a motion, with the shape that fits each best.

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

    from attitude.annotations import FloatArray, IntArray
    from attitude.inversion.convex import Tie
    from attitude.inversion.robust import Weighted

# Parameters of the motion.
SIZE = 8
_SEED = 20180708


def covariance(found: Weighted, tie: Tie) -> FloatArray:
    """Second moments (8, 8) of the parameters about those of a solution; 0 of those that stay."""
    at = np.ix_(*2 * [free(found)])
    curvature = refinement.inverse(found.refined.normal)[:SIZE, :SIZE][at]
    factor: FloatArray = np.asarray(
        np.linalg.cholesky(population.conditioned(curvature)), dtype=np.float64
    )
    density = log_density(found, tie, factor)

    def densities(points: FloatArray) -> FloatArray:
        return np.array([density(each) for each in points])

    wide = population.second_moments(densities, len(factor), np.random.default_rng(_SEED))
    moments = np.zeros((SIZE, SIZE))
    moments[at] = factor @ wide @ factor.T
    return moments


def free(found: Weighted) -> IntArray:
    """The parameters of the motion that do not stay: all, or those about one axis."""
    return np.flatnonzero(np.diag(found.refined.normal)[:SIZE] != 1.0)


def log_density(found: Weighted, tie: Tie, factor: FloatArray) -> Callable[[FloatArray], float]:
    """The logarithm of the density of offsets in units of a factor of a covariance.

    Both are of the parameters that are free.
    """
    problem, state, normal = found.problem, found.refined.state, found.refined.normal
    which = free(found)
    is_axial = len(which) < SIZE
    follow = -np.linalg.solve(normal[SIZE:, SIZE:], normal[SIZE:, :SIZE])

    def density(scaled: FloatArray) -> float:
        offsets = np.zeros(SIZE)
        offsets[which] = factor @ scaled
        trial = moved(state, offsets)
        trial[14:] += follow @ offsets
        if is_axial:
            return -0.5 * refinement.profiled_cost(problem, trial, tie, True)
        inside = many_starts.LEAST_X < trial[4] < many_starts.MOST_X
        if not (inside and many_starts.LEAST_RHO < trial[3] < many_starts.MOST_RHO):
            return -math.inf
        if not moments_of_elements.moments(trial[many_starts.OF_MOMENTS]).exists:
            return -math.inf
        return -0.5 * refinement.profiled_cost(problem, trial, tie, False)

    return density


def moved(state: FloatArray, offsets: FloatArray) -> FloatArray:
    """The state after a change of the eight parameters."""
    step = np.zeros(refinement.SIZE)
    step[:SIZE] = offsets
    return many_starts.moved(state, step)
