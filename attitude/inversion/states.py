"""From the parameters of a search to a motion: moments, attitude and rates at the epoch."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple, Protocol

import numpy as np

from attitude import quaternion
from attitude.body import Body
from attitude.free_rotation import FreeRotation
from attitude.inversion import facets, many_starts, moments_of_elements, refinement
from attitude.inversion import normal_form_series as series
from attitude.inversion.search import is_axial
from attitude.spin import Spin

if TYPE_CHECKING:
    from attitude.annotations import FloatArray, IntArray
    from attitude.epochs.instants import Instant
    from attitude.inversion.robust import Weighted

# Steps of the derivatives of state by parameters, relative to their scales.
_STEP = 1e-6
# Epochs closer than this, s, belong to one night: their residuals are taken as correlated.
_NIGHT = 0.3 * 86400.0
# Parts of the span, and ratios of variances above which those from scores replace formal ones: the
# ratio scatters by sqrt(2/n) for n nights or parts.
_PARTS, _NIGHTS_RISE, _PARTS_RISE = 10, 1.7, 2.2


class PhysicalState(NamedTuple):
    """Rotation matrix (3, 3) to ICRF at the middle of the span, rates (rad per span), moments."""

    matrix: FloatArray
    rates: FloatArray
    moments: FloatArray


def physical(state: FloatArray) -> PhysicalState:
    """The state of motion of the parameters of a search; the largest moment is 1."""
    k, r = np.zeros((4, 4, 2)), np.empty((9, 1))
    series.coefficients(math.exp(state[3]), state[4], k)
    series.attitudes(state[0], state[1], state[2], k, np.zeros(1), r)
    body = r.reshape(3, 3)
    matrix = state[5:14].reshape(3, 3) @ body
    if is_axial(state):
        held = facets.constraints(state[14:16], *facets.areas(state[14:16], state[16:]))
        ratios = np.exp(np.append(held.log_ratios, 0.0))
        ratios[2] = max(ratios[2], 1.0001 * float(ratios[:2].max()))
        return PhysicalState(
            matrix, np.array([0.0, 0.0, 4.0 * math.pi * state[0]]), ratios / ratios.max()
        )
    found = np.empty(4)
    moments_of_elements.log_ratios(state[0], state[1], state[3], state[4], found)
    ratios = np.array([math.exp(found[0]), math.exp(found[1]), 1.0])
    return PhysicalState(matrix, found[3] * body[2] / ratios, ratios / ratios.max())


def is_admissible(state: FloatArray) -> bool:
    """Whether a body has the moments of a state."""
    if is_axial(state):
        return True
    found = np.empty(4)
    moments_of_elements.log_ratios(state[0], state[1], state[3], state[4], found)
    return bool(found[2])


def motion(
    state: FloatArray, span: float, epoch: Instant, covariance: FloatArray | None
) -> FreeRotation:
    """The free rotation of a state, its covariance as of `Spin`; the moments are relative."""
    here = physical(state)
    wxyz = quaternion.from_matrix(here.matrix)
    spin = Spin(epoch, wxyz, here.rates / span, covariance=covariance)
    return FreeRotation(Body(moments=here.moments, relative=True), spin)


def covariance(found: Weighted, night: IntArray) -> tuple[FloatArray, FloatArray]:
    """Covariances of the state (9, 9), per span, and of the eight parameters of the motion.

    Variances are those of the normal matrix, or larger if the scores of nights, or of tenths of the
    span, scatter so much more that it is no chance: residuals are correlated where the model errs.

    Parameters
    ----------
    found : Weighted
    night : (N,) array of int
        The night of each point.
    """
    here = refinement.model(found.problem, found.refined.state)
    of_motion = of_scores(found, here, night, 8)
    slopes = _slopes(found.refined.state)
    total = slopes @ of_motion @ slopes.T
    return 0.5 * (total + total.T), of_motion


class Modelled(Protocol):
    """Magnitudes (N,) and their Jacobian (P, N)."""

    @property
    def magnitude(self) -> FloatArray:
        """Of each point."""

    @property
    def jacobian(self) -> FloatArray:
        """By all parameters, those of the motion first."""


def of_scores(found: Weighted, here: Modelled, night: IntArray, count: int) -> FloatArray:
    """Covariance (count, count) of the first parameters; see `covariance`.

    Parameters
    ----------
    found : Weighted
    here : Modelled
        Of its state, at the points of its problem.
    night : (N,) array of int
    count : int
    """
    inverse = refinement.inverse(found.refined.normal)
    problem = found.problem
    r = (problem.y - here.magnitude) * problem.root
    r = r - problem.u.T @ (problem.u @ r)
    jacobian = here.jacobian * problem.root
    jacobian = jacobian - (jacobian @ problem.u.T) @ problem.u
    data = jacobian @ jacobian.T
    formal = np.diag(inverse)[:count]
    rise = np.ones(count)
    for group, least in ((night, _NIGHTS_RISE), (_parts(problem.t), _PARTS_RISE)):
        groups = int(group.max()) + 1
        scores = np.stack([np.bincount(group, row * r, groups) for row in jacobian])
        meat = scores @ scores.T * (groups / max(groups - 1.0, 1.0))
        wide = np.diag(inverse @ (meat + found.refined.normal - data) @ inverse)[:count]
        ratio = wide / np.where(formal > 0.0, formal, 1.0)
        rise = np.where(ratio > least, np.maximum(rise, ratio), rise)
    held = np.diag(found.refined.normal)[:count] == 1.0
    size = np.where(held, 0.0, np.sqrt(rise))
    of_motion: FloatArray = inverse[:count, :count] * np.outer(size, size)
    return of_motion


def _parts(t: FloatArray) -> IntArray:
    """The number of the part of the span of each epoch (spans)."""
    return np.floor((t - t.min()) * (_PARTS * 0.999999 / max(float(np.ptp(t)), 1e-12))).astype(
        np.int64
    )


def nights(emission: FloatArray) -> IntArray:
    """The number of the night of each epoch (s)."""
    order = np.argsort(emission, kind="stable")
    number = np.zeros(len(emission), np.int64)
    number[order[1:]] = np.cumsum(np.diff(emission[order]) > _NIGHT)
    return number


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
            moved = state.copy()
            many_starts.moved(state, step, moved)
            ends.append(physical(moved))
        turn = ends[0].matrix @ ends[1].matrix.T
        vector = 0.5 * np.array(
            [turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]]
        )
        width = 2.0 * _STEP * scale[p]
        slopes[:3, p] = vector / width
        slopes[3:6, p] = (ends[0].rates - ends[1].rates) / width
        slopes[6:, p] = (ends[0].moments - ends[1].moments) / width
    return slopes
