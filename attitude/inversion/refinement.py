"""Orientation, elements and convex areas together: Levenberg and Marquardt with exact derivatives.

A state is a start of `many_starts` with the coefficients of the modes of `facets` behind it.  The
moments of the motion are tied to those of the homogeneous shape; terms in which the magnitude is
linear are projected out.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from attitude.inversion import facets, many_starts, moments_of_elements
from attitude.inversion import normal_form_series as series
from attitude.inversion.facet_sums import shares

if TYPE_CHECKING:
    from attitude.annotations import BoolArray, FloatArray
    from attitude.inversion.problem import CurveProblem

# Share of Lambert's law in the scattering, to that of Lommel and Seeliger.
LAMBERT = 0.1
# Standard deviation of the logarithms of the squared ratios of axes of the ellipsoid.
_RATIOS = 1.5
_MAGNITUDE = -2.5 / math.log(10.0)
_STUCK = 1e6
# Parameters of the motion, and of the ellipsoid.
_MOTION, _SHAPE = 8, 2
SIZE = _MOTION + _SHAPE + facets.MODES
WIDTH = many_starts.WIDTH + facets.MODES


@dataclass(frozen=True, eq=False)
class ShapeModel:
    """Magnitudes (N,) of a state, their Jacobian (SIZE, N), areas, and the slopes of the areas."""

    magnitude: FloatArray
    jacobian: FloatArray
    areas: FloatArray
    slopes: FloatArray


def model(problem: CurveProblem, state: FloatArray) -> ShapeModel:
    """The magnitudes of a state (WIDTH,), with derivatives."""
    t, count = problem.t, len(problem)
    k, r, g = np.zeros((4, 4, 2)), np.empty((9, count)), np.empty((9, count))
    series.coefficients(math.exp(state[3]), state[4], k)
    series.attitudes(state[0], state[1], state[2], k, t, r)
    series.tangents(state[0], state[1], state[2], k, t, g)
    turn, body = state[5:14].reshape(3, 3), r.reshape(3, 3, count)
    sun = np.ascontiguousarray(np.einsum("rkt,rt->tk", body, turn.T @ problem.sun))
    observer = np.ascontiguousarray(np.einsum("rkt,rt->tk", body, turn.T @ problem.observer))
    area, slopes = facets.areas(state[14:16], state[16:])
    parts, by = np.empty((count, facets.COUNT)), np.empty((count, 6))
    shares(sun, observer, facets.sphere().normals, area, LAMBERT, parts, by)
    total = np.maximum(parts.sum(axis=1), 1e-12)
    factor = _MAGNITUDE / total
    across = (np.cross(by[:, :3], sun) + np.cross(by[:, 3:], observer)) * factor[:, None]
    h = np.einsum("rkt,tk->rt", body, across)
    jacobian = np.empty((SIZE, count))
    jacobian[:3] = h
    jacobian[3] = 4.0 * math.pi * t * h[2]
    v = 2.0 * math.pi * np.sum(h * g[:3], axis=0)
    jacobian[4], jacobian[5] = t * v, v
    jacobian[6], jacobian[7] = np.sum(h * g[3:6], axis=0), np.sum(h * g[6:], axis=0)
    parts *= factor[:, None]
    jacobian[8:] = (parts @ slopes).T
    return ShapeModel(_MAGNITUDE * np.log(total), jacobian, area, slopes)


@dataclass(frozen=True, eq=False)
class Refined:
    """A state near its least cost.

    Attributes
    ----------
    state : (WIDTH,) array
    cost, chi_squared, strain : float
        chi_squared is that of the magnitudes, cost adds the priors; strain is the part of the
        cost that ties the moments to the shape.
    normal : (SIZE, SIZE) array
        Second derivatives of half the cost.
    areas : (F,) array
    """

    state: FloatArray
    cost: float
    chi_squared: float
    strain: float
    normal: FloatArray
    areas: FloatArray


def _penalties(
    state: FloatArray, here: ShapeModel, tolerance: float, is_axial: bool
) -> tuple[FloatArray, FloatArray, float]:
    """Residuals of all priors (R,), their derivatives (R, SIZE), and the strain."""
    held = facets.constraints(state[14:16], here.areas, here.slopes)
    count = 8 + _SHAPE + facets.MODES
    r, by = np.zeros(count), np.zeros((count, SIZE))
    r[:3], by[:3, _MOTION:] = held.closure, held.by_closure
    strain = 0.0
    if math.isfinite(tolerance):
        r[3:6], by[3:6, _MOTION:] = held.turn, held.by_turn
        if is_axial:  # about the axis of the greatest moment
            above = held.log_ratios > 0.0
            r[6:8] = np.where(above, held.log_ratios, 0.0) / tolerance
            by[6:8, _MOTION:] = np.where(above[:, None], held.by_ratios, 0.0) / tolerance
        else:
            found, slopes = np.empty(4), np.empty((2, 4))
            moments_of_elements.with_slopes(state[0], state[1], state[3], state[4], found, slopes)
            r[6:8] = (found[:2] - held.log_ratios) / tolerance
            by[6:8, [3, 4, 6, 7]] = slopes / tolerance
            by[6:8, _MOTION:] = -held.by_ratios / tolerance
        strain = float(r[3:8] @ r[3:8])
    r[8:10], r[10:] = state[14:16] / _RATIOS, state[16:]
    by[8, 8] = by[9, 9] = 1.0 / _RATIOS
    by[range(10, count), range(10, SIZE)] = 1.0
    return r, by, strain


def profiled_cost(problem: CurveProblem, state: FloatArray, tolerance: float) -> float:
    """The cost of a motion after one Gauss-Newton step of its shape."""
    here = model(problem, state)
    r = (problem.y - here.magnitude) * problem.root
    along = problem.u @ r
    prior, by_prior, _ = _penalties(state, here, tolerance, False)
    jacobian = here.jacobian[_MOTION:] * problem.root
    across = jacobian @ problem.u.T
    own = by_prior[:, _MOTION:]
    normal = jacobian @ jacobian.T - across @ across.T + own.T @ own
    gradient = jacobian @ r - across @ along - own.T @ prior
    gain = float(gradient @ np.linalg.solve(normal, gradient))
    return float(r @ r - along @ along + prior @ prior) - gain


def refine(
    problem: CurveProblem,
    start: FloatArray,
    *,
    iterations: int = 20,
    tolerance: float = facets.TOLERANCE,
    gain: float = 1e-3,
    fixed: BoolArray | None = None,
) -> Refined:
    """The state of least cost near a start.

    Parameters
    ----------
    problem : CurveProblem
    start : (WIDTH,) array
        Or a start of `many_starts`, whose shape is the ellipsoid.
    iterations : int
    tolerance : float
        Of the logarithms of the ratios of moments of motion and shape; infinite: not tied.
    gain : float
        Relative decrease of the cost at which the iteration ends.
    fixed : (K,) array of bool, optional
        Which of the first K parameters stay: 8 of the motion, 2 of the ellipsoid, the modes.
    """
    state = np.zeros(WIDTH)
    state[: len(start)] = start
    held = np.zeros(SIZE, bool)
    if fixed is not None:
        held[: len(fixed)] = fixed
    best: Refined | None = None
    trial, damping = state, 1e-2
    gradient = np.zeros(SIZE)
    for iteration in range(iterations):
        here = model(problem, trial)
        r = (problem.y - here.magnitude) * problem.root
        along = problem.u @ r
        prior, by_prior, strain = _penalties(trial, here, tolerance, bool(held[6]))
        chi = float(r @ r - along @ along)
        cost = chi + float(prior @ prior)
        if best is None or cost < best.cost:
            won = math.inf if best is None else best.cost - cost
            jacobian = here.jacobian * problem.root
            across = jacobian @ problem.u.T
            normal = jacobian @ jacobian.T - across @ across.T + by_prior.T @ by_prior
            gradient = jacobian @ r - across @ along - by_prior.T @ prior
            gradient[held] = 0.0
            normal[held, :] = normal[:, held] = 0.0
            normal[held, held] = 1.0
            best = Refined(trial, cost, chi, strain, normal, here.areas)
            damping = max(0.3 * damping, 1e-7)
            if iteration > 2 and won < gain * cost:
                break
        else:
            damping *= 5.0
        found = _next(best, gradient, damping, bool(held[6]))
        if found is None:
            break
        trial, damping = found
    assert best is not None
    return best


def _next(
    best: Refined, gradient: FloatArray, damping: float, is_axial: bool
) -> tuple[FloatArray, float] | None:
    """The state after a damped step that stays within the bounds, and the damping."""
    scale = np.sqrt(np.diag(best.normal)) + 1e-12
    scaled = best.normal / np.outer(scale, scale)
    while damping < _STUCK:
        step = np.linalg.solve(scaled + damping * np.eye(SIZE), gradient / scale) / scale
        longest = max(
            float(np.linalg.norm(step[:3])),
            6.0 * abs(step[5]),
            2.0 * abs(step[6]),
            4.0 * abs(step[7]),
            abs(step[8]),
            abs(step[9]),
            float(np.abs(step[10:]).max()) / 3.0,
        )
        if longest > 0.5:
            step *= 0.5 / longest
        trial = best.state.copy()
        many_starts.moved(best.state, step, trial)
        trial[16:] += step[10:]
        inside = many_starts.LEAST_X < trial[4] < many_starts.MOST_X
        inside &= many_starts.LEAST_RHO < trial[3] < many_starts.MOST_RHO
        if (inside or is_axial) and float(np.abs(trial[14:16]).max()) < many_starts.MOST_RATIO:
            return trial, damping
        damping *= 5.0
    return None
