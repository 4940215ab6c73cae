"""The posterior density of a free rotation of known shape: attitude and rates.

Shadows of facets have steps, so that the density has many narrow peaks near a solution.  The
curvature is that of one of them; second moments are those of all.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from attitude import quaternion
from attitude import representations as forms
from attitude.inversion import many_states, population, refinement

if TYPE_CHECKING:
    from collections.abc import Iterable

    from attitude.annotations import FloatArray
    from attitude.inversion.known_shape import KnownShape
    from attitude.inversion.moving import MovingPoint
    from attitude.inversion.robust import Weighted

# Turn (rad, ICRF) and rates.
SIZE = 6
_SEED = 20180708
# Standard errors between two minima that count as two.
_DISTINCT = 0.5


def covariance(
    found: Weighted, point: MovingPoint, seconds: FloatArray, known: KnownShape, least: float
) -> FloatArray:
    """Second moments (P, P) of the parameters about those of a solution; 0 of those that stay.

    Parameters
    ----------
    found : Weighted
    point : MovingPoint
        Its state, without changes of the motion.
    seconds : (N,) array
        Epochs of the points of its problem since that of the state, s.
    known : KnownShape
        Over principal axes.
    least : float
        Flux that counts as dark.
    """
    formal = refinement.inverse(found.refined.normal)[:SIZE, :SIZE]
    factor: FloatArray = np.asarray(
        np.linalg.cholesky(population.conditioned(formal)), dtype=np.float64
    )
    wxyz, omega = point.spin.wxyz_icrf, point.spin.angular_velocity
    block = max(many_states.BLOCK // len(seconds), 1)

    def density(scaled: FloatArray) -> FloatArray:
        step = scaled @ factor.T
        q = quaternion.multiply(forms.from_rotation_vector(step[:, :3]), wxyz)
        w = omega + step[:, 3:]
        parts = [
            many_states.costs(
                found.problem, known, point.body.moments, q[k : k + block], w[k : k + block],
                seconds, least,
            ).cost
            for k in range(0, len(step), block)
        ]  # fmt: skip
        return -0.5 * np.concatenate(parts)

    wide = population.second_moments(density, SIZE, np.random.default_rng(_SEED))
    moments = np.zeros((point.size, point.size))
    moments[:SIZE, :SIZE] = factor @ wide @ factor.T
    return moments


def spread(covariance: FloatArray, rivals: Iterable[tuple[FloatArray, float]]) -> FloatArray:
    """The second moments (P, P) that other minima add to the covariance of one.

    Parameters
    ----------
    covariance : (P, P) array
    rivals : pairs of a (P,) array and a float
        Offsets of other minima, and by how much their evidence is larger; each is as probable as
        its evidence says, and those that are the same minimum count once.
    """
    size = np.sqrt(np.maximum(np.diag(covariance), 1e-300))
    inverse = np.linalg.pinv(covariance / np.outer(size, size), rcond=1e-12, hermitian=True)
    offsets, weights = [np.zeros(len(size))], [1.0]
    for offset, behind in sorted(rivals, key=lambda each: each[1]):
        steps = (np.array(offsets) - offset) / size
        if np.min(np.einsum("np,pq,nq->n", steps, inverse, steps)) > _DISTINCT**2:
            offsets.append(offset)
            weights.append(math.exp(-0.5 * behind))
    every, share = np.array(offsets), np.array(weights) / sum(weights)
    found: FloatArray = (every * share[:, None]).T @ every
    return found
