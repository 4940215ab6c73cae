"""The covariance of a posterior density that is not normal: population Monte Carlo.

Near a solution the curvature describes the density; some standard errors away it falls more slowly,
and in eight dimensions most of the mass lies there.  Samples of Student's distribution, weighted by
the density over their own, give second moments, from which the next samples are drawn.

Source: Cappe, Guillin, Marin & Robert, J. Comput. Graph. Stat. 13, 907 (2004); the truncation of
weights: Ionides, J. Comput. Graph. Stat. 17, 295 (2008).
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Callable

    from attitude.annotations import FloatArray

# Rounds, samples of each, and degrees of freedom of their distribution.
_ROUNDS, _SAMPLES, _FREEDOM = 5, 350, 6.0
# Widening of the samples over the second moments so far.
_WIDER = 1.2


def second_moments(
    log_density: Callable[[FloatArray], FloatArray], size: int, generator: np.random.Generator
) -> FloatArray:
    """Second moments (D, D) about 0 of a density whose curvature at 0 is about 1.

    Parameters
    ----------
    log_density : callable
        (S,) of points (S, D); -inf outside of its domain.
    size : int
        D.
    generator : Generator
    """
    found = np.eye(size)
    points, logs = [], []
    mixture: list[FloatArray] = []
    for _ in range(_ROUNDS):
        factor: FloatArray = _WIDER * np.asarray(np.linalg.cholesky(found), dtype=np.float64)
        mixture.append(factor)
        chi = generator.chisquare(_FREEDOM, _SAMPLES) / _FREEDOM
        z = generator.standard_normal((_SAMPLES, size)) / np.sqrt(chi)[:, None]
        new = z @ factor.T
        points.append(new)
        logs.append(log_density(new))
        every, log = np.concatenate(points), np.concatenate(logs)
        # the density of all rounds together, as a mixture
        drawn = np.logaddexp.reduce([_log_student(every, each) for each in mixture], axis=0)
        ratio = log - drawn
        weights = np.exp(ratio - ratio.max())
        weights = np.minimum(weights, weights.mean() * math.sqrt(len(weights)))
        weights /= weights.sum()
        found = (every * weights[:, None]).T @ every + 1e-6 * np.eye(size)
    return found


def conditioned(covariance: FloatArray) -> FloatArray:
    """A covariance whose factor exists."""
    found: FloatArray = covariance + 1e-12 * np.diag(np.diag(covariance))
    return found


def _log_student(points: FloatArray, factor: FloatArray) -> FloatArray:
    """The logarithm of Student's density (S,), but for a constant."""
    size = points.shape[1]
    scaled = np.linalg.solve(factor, points.T)
    squares = np.sum(scaled**2, axis=0)
    found: FloatArray = -0.5 * (_FREEDOM + size) * np.log1p(squares / _FREEDOM)
    return found - float(np.sum(np.log(np.abs(np.diag(factor)))))
