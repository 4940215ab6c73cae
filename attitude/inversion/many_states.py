"""Magnitudes and costs of many states of a free rotation of known shape, side by side."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from attitude import quaternion
from attitude.propagation import propagate

if TYPE_CHECKING:
    from attitude.annotations import FloatArray
    from attitude.inversion.known_shape import KnownShape
    from attitude.inversion.problem import CurveProblem

# Rows (states times points) that are computed together.
BLOCK = 40_000


class Costs(NamedTuple):
    """Costs (M,), weighted residuals (M, N), and their parts along the linear terms (M, L)."""

    cost: FloatArray
    residual: FloatArray
    along: FloatArray


def costs(
    problem: CurveProblem,
    known: KnownShape,
    moments: FloatArray,
    wxyz: FloatArray,
    omega: FloatArray,
    seconds: FloatArray,
    least: float,
) -> Costs:
    """The costs of states.

    Parameters
    ----------
    problem : CurveProblem
        Of N points.
    known : KnownShape
        Over principal axes.
    moments : (3,) array
    wxyz, omega : (M, 4) and (M, 3) arrays
        Attitudes (to ICRF) and rates, rad/s.
    seconds : (N,) array
        Epochs of the points since that of the states, s.
    least : float
        Flux that counts as dark.
    """
    turned = propagate(moments, wxyz, omega, seconds)
    sun, observer = over_body(quaternion.matrix(turned), problem)
    return of_magnitudes(problem, known.magnitudes(sun, observer, least))


def over_body(matrix: FloatArray, problem: CurveProblem) -> tuple[FloatArray, FloatArray]:
    """Directions (M, N, 3) to Sun and observer over body axes of attitudes (M, N, 3, 3)."""
    sun = np.einsum("mnij,in->mnj", matrix, problem.sun)
    return sun, np.einsum("mnij,in->mnj", matrix, problem.observer)


def of_magnitudes(problem: CurveProblem, magnitude: FloatArray) -> Costs:
    """The costs of magnitudes (M, N)."""
    r = (problem.y - magnitude) * problem.root
    along = r @ problem.u.T
    return Costs(np.sum(r * r, axis=1) - np.sum(along * along, axis=1), r, along)
