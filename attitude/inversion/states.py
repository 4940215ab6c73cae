"""From the parameters of a search to a motion: moments, attitude and rates at the epoch."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from attitude import quaternion
from attitude import representations as forms
from attitude.body import Body
from attitude.free_rotation import FreeRotation
from attitude.inversion import (
    density_of_motion,
    facets,
    jackknife,
    many_starts,
    moments_of_elements,
    pole_map,
    refinement,
)
from attitude.inversion import normal_form_series as series
from attitude.inversion.search import is_axial
from attitude.spin import Spin

if TYPE_CHECKING:
    from collections.abc import Sequence

    from attitude.annotations import BoolArray, FloatArray, IntArray
    from attitude.epochs.instants import Instant
    from attitude.inversion.convex import Tie
    from attitude.inversion.jackknife import GroupErrors
    from attitude.inversion.robust import Weighted

# Steps of the derivatives of state by parameters, relative to their scales.
_STEP = 1e-6
# Iterations of a fit without a group of points.
_REFITTED = 30


class PhysicalState(NamedTuple):
    """Rotation matrix (3, 3) to ICRF at the middle of the span, rates (rad per span), moments."""

    matrix: FloatArray
    rates: FloatArray
    moments: FloatArray


def physical(state: FloatArray) -> PhysicalState:
    """The state of motion of the parameters of a search; the largest moment is 1."""
    body = series.at_epochs(state, np.zeros(1)).matrix.reshape(3, 3)
    matrix = state[5:14].reshape(3, 3) @ body
    if is_axial(state):
        held = facets.constraints(state[14:16], *facets.areas(state[14:16], state[16:]))
        ratios = np.exp(np.append(held.log_ratios, 0.0))
        ratios[2] = max(ratios[2], 1.0001 * float(ratios[:2].max()))
        return PhysicalState(
            matrix, np.array([0.0, 0.0, 4.0 * math.pi * state[0]]), ratios / ratios.max()
        )
    found = moments_of_elements.moments(state[many_starts.OF_MOMENTS])
    ratios = np.exp(np.append(found.log_ratios, 0.0))
    return PhysicalState(matrix, found.momentum * body[2] / ratios, ratios / ratios.max())


def is_admissible(state: FloatArray) -> bool:
    """Whether a body has the moments of a state."""
    if is_axial(state):
        return True
    return bool(moments_of_elements.moments(state[many_starts.OF_MOMENTS]).exists)


def motion(
    state: FloatArray, span: float, epoch: Instant, covariance: FloatArray | None
) -> FreeRotation:
    """The free rotation of a state, its covariance as of `Spin`; the moments are relative."""
    here = physical(state)
    wxyz = quaternion.from_matrix(here.matrix)
    spin = Spin(epoch, wxyz, here.rates / span, covariance=covariance)
    return FreeRotation(Body(moments=here.moments, relative=True), spin)


def covariance(
    found: Weighted,
    groups: Sequence[IntArray],
    tie: Tie,
    rivals: Sequence[Weighted] = (),
) -> tuple[FloatArray, GroupErrors]:
    """The covariance of the state (9, 9), per span, and those of the parameters of the motion.

    Parameters
    ----------
    found : Weighted
    groups : sequence of (N,) arrays of int
        As of `jackknife.errors`.
    tie : Tie
        With which the state was found.
    rivals : sequence of Weighted
        Minima that compete; about one axis, those near the pole are among its errors.
    """
    state, problem = found.refined.state, found.problem
    fixed = np.diag(found.refined.normal) == 1.0

    def refitted(keep: BoolArray) -> FloatArray | None:
        again = refinement.refine(
            problem.part(keep), state, tie=tie, fixed=fixed, iterations=_REFITTED, gain=1e-5
        )
        return _difference(again.state, state)

    here = refinement.model(problem, state)
    formal = density_of_motion.covariance(found, tie)
    made = jackknife.errors(found, here, groups, 8, refitted, formal)
    if is_axial(state):
        others = [
            (each.refined.state, each.evidence)
            for each in rivals
            if is_axial(each.refined.state)
            and pole_map.has_turn(problem, each.refined.state, state)
        ]
        wider = made.covariance + pole_map.spread(state, found.evidence, others)
        made = made._replace(covariance=wider)
    slopes = _slopes(state)
    total = slopes @ made.covariance @ slopes.T
    return 0.5 * (total + total.T), made


def _difference(state: FloatArray, origin: FloatArray) -> FloatArray:
    """The parameters (8,) of the motion of a state from those of another."""
    turn = quaternion.from_matrix(origin[5:14].reshape(3, 3).T @ state[5:14].reshape(3, 3))
    return np.concatenate([forms.to_rotation_vector(turn), state[:5] - origin[:5]])


def _slopes(state: FloatArray) -> FloatArray:
    """Derivatives (9, 8) of rotation vector (ICRF), rates and moments by the parameters."""
    slopes = np.zeros((9, 8))
    scale = np.array([1.0, 1.0, 1.0, abs(state[0]), max(abs(state[1]), 1.0), 1.0, 1.0, 1.0])
    for p in range(8):
        if is_axial(state) and p >= 4:
            continue
        ends = []
        for sign in (1.0, -1.0):
            step = np.zeros(refinement.SIZE)
            step[p] = sign * _STEP * scale[p]
            ends.append(physical(many_starts.moved(state, step)))
        turn = ends[0].matrix @ ends[1].matrix.T
        vector = 0.5 * np.array(
            [turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]]
        )
        width = 2.0 * _STEP * scale[p]
        slopes[:3, p] = vector / width
        slopes[3:6, p] = (ends[0].rates - ends[1].rates) / width
        slopes[6:, p] = (ends[0].moments - ends[1].moments) / width
    return slopes
