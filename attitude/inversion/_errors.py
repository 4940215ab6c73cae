"""Covariances that contain the error of the model: the jackknife, and posterior densities.

The delete-group jackknife: residuals of one night, one observer or one part of the span are
correlated where the model errs, so that the curvature alone gives errors that are too small.  Each
group of points is left out in turn.  What the parameters then change by follows from one step of
Newton's, or, where that is more than one standard error, from another fit.  Directions in which the
jackknife's variance exceeds that of the curvature, by more than the largest eigenvalue of a sample
covariance does by chance (Marchenko & Pastur: (1 + sqrt(P/G))^2 for P parameters and G groups),
take the jackknife's.

Source: Cameron & Miller, Journal of Human Resources 50, 317 (2015), section VI; Shaby, J. Comput.
Graph. Stat. 23, 801 (2014) for the adjustment of samples.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from attitude._support.arrays import part_of_each
from attitude._support.constants import GAP_OF_NIGHTS_S
from attitude.frames import quaternion
from attitude.frames import representations as forms
from attitude.inversion import _ellipsoid, _refinement
from attitude.inversion._ellipsoid import SearchState
from attitude.inversion._refinement import MOTION
from attitude.motions._propagation import propagate

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Sequence

    from attitude._support.annotations import BoolArray, FloatArray, IntArray
    from attitude.inversion._evidence import Robust, Weighted
    from attitude.inversion._moving import MovingPoint
    from attitude.inversion._problem import CurveProblem
    from attitude.inversion._refinement import ShapeModel
    from attitude.inversion._shapes import KnownShape, Tie


# Groups of one kind at least.
_LEAST_GROUPS = 5
# Fits without a group at most, those of the largest changes.
_REFITS = 12
# Parts of the span.
_PARTS = 10


class GroupErrors(NamedTuple):
    """Covariances (K, K) of the parameters of the motion: of the density, and with model error.

    widening (K, K) turns samples of the former into those of the latter.
    """

    formal: FloatArray
    covariance: FloatArray
    widening: FloatArray


def errors(
    solution: Weighted[object],
    shape_model: ShapeModel,
    groupings: Sequence[IntArray],
    count: int,
    refitted: Callable[[BoolArray], FloatArray | None],
    formal: FloatArray | None = None,
) -> GroupErrors:
    """The covariances of the first `count` parameters.

    Shapes: groupings (N,), formal (count, count).
    """
    normal, problem = solution.refined.normal, solution.problem
    if formal is None:
        formal = solution.refined.covariance[:count, :count]
    free = solution.refined.free[:count]
    r = problem.projected(problem.y - shape_model.magnitude)
    jacobian = problem.projected(shape_model.jacobian)
    scale = np.sqrt(np.diag(normal))
    jacobian /= scale[:, None]
    jacobian[~solution.refined.free] = 0.0
    scaled = normal / np.outer(scale, scale)
    factor = _factor(_regular(formal[np.ix_(free, free)]))
    inflation = np.eye(len(factor))
    for group in groupings:
        total = int(group.max()) + 1
        if total < _LEAST_GROUPS:
            continue
        changes: list[FloatArray] = []
        for number in range(total):
            on = group == number
            columns = jacobian[:, on]
            change = np.linalg.solve(scaled - columns @ columns.T, -columns @ r[on]) / scale
            scaled_change = np.linalg.solve(factor, change[:count][free])
            changes.append(np.asarray(scaled_change, dtype=np.float64))
        _refit(changes, group, refitted, factor, free)
        spread = np.array(changes)
        inner = (total - 1.0) / total * spread.T @ spread
        inflation = _larger(inflation, inner, total)
    root = _root(inflation)
    widening, covariance = np.eye(count), np.zeros((count, count))
    at = np.ix_(free, free)
    widening[at] = factor @ root @ np.linalg.inv(factor)
    covariance[at] = factor @ inflation @ factor.T
    kept = np.zeros((count, count))
    kept[at] = formal[at]
    return GroupErrors(kept, 0.5 * (covariance + covariance.T), widening)


def _refit(
    changes: list[FloatArray],
    group: IntArray,
    refitted: Callable[[BoolArray], FloatArray | None],
    factor: FloatArray,
    free: BoolArray,
) -> None:
    """Replace changes of more than one standard error by those of fits, in place."""
    length = np.array([float(np.linalg.norm(change)) for change in changes])
    for number in np.argsort(-length)[:_REFITS]:
        if length[number] < 1.0:
            break
        change = refitted(group != number)
        if change is not None:
            changes[number] = np.linalg.solve(factor, change[free])


def _larger(inflation: FloatArray, inner: FloatArray, groups: int) -> FloatArray:
    """A covariance, with that of a jackknife in the directions in which it is larger for sure."""
    root = _root(inflation)
    back = np.linalg.inv(root)
    values, vectors = np.linalg.eigh(back @ inner @ back.T)
    edge = (1.0 + math.sqrt(len(values) / groups)) ** 2
    values = np.where(values > edge, values, 1.0)
    return root @ (vectors * values) @ vectors.T @ root.T


def _root(matrix: FloatArray) -> FloatArray:
    """The symmetric root of a symmetric matrix."""
    values, vectors = np.linalg.eigh(0.5 * (matrix + matrix.T))
    return (vectors * np.sqrt(np.maximum(values, 0.0))) @ vectors.T


def _regular(covariance: FloatArray) -> FloatArray:
    """A covariance whose factor exists."""
    size = np.sqrt(np.maximum(np.diag(covariance), 1e-300))
    scaled = covariance / np.outer(size, size) + 1e-10 * np.eye(len(size))
    return scaled * np.outer(size, size)


def groupings(t: FloatArray, span: float, session: IntArray | None) -> tuple[IntArray, ...]:
    """Nights, sessions and tenths of the span of epochs t (N,), spans.

    Shapes: t (N,), session (N,).
    """
    parts = np.floor((t - t.min()) * (_PARTS * 0.999999 / max(float(np.ptp(t)), 1e-12)))
    groups = [part_of_each(t * span, GAP_OF_NIGHTS_S), _dense(parts)]
    if session is not None and len(session) == len(t):
        groups.append(_dense(session))
    return tuple(groups)


def _dense(numbers: FloatArray | IntArray) -> IntArray:
    """The same groups numbered without gaps."""
    return np.unique(numbers, return_inverse=True)[1].reshape(-1).astype(np.int64)


# ---- The covariance of a posterior density that is not normal: population Monte Carlo
# Near a solution the curvature describes the density; some standard errors away it falls more
# slowly, and in eight dimensions most of the mass lies there.  Samples of Student's distribution,
# weighted by the density over their own, give second moments, from which the next samples are
# drawn.
#
# Source: Cappe, Guillin, Marin & Robert, J. Comput. Graph. Stat. 13, 907 (2004); the truncation of
# weights: Ionides, J. Comput. Graph. Stat. 17, 295 (2008).

# Rounds of sampling at most, each from the second moments so far.
_ROUNDS = 7
# Effective number of samples that are enough: standard errors to 5 %.
_ENOUGH = 200.0
# Samples of a round: as many as are enough where the curvature is that of the whole density.
_SAMPLES = 260
# Degrees of freedom of their distribution.
_FREEDOM = 6.0
# Widening of the samples over the second moments so far.
_WIDER = 1.2


def second_moments(
    log_density: Callable[[FloatArray], FloatArray], size: int, generator: np.random.Generator
) -> FloatArray:
    """Second moments (D, D) about 0 of a density whose curvature at 0 is about 1."""
    matrix = np.eye(size)
    points, logs = [], []
    mixture: list[FloatArray] = []
    for _ in range(_ROUNDS):
        factor = _WIDER * _factor(matrix)
        mixture.append(factor)
        chi = generator.chisquare(_FREEDOM, _SAMPLES) / _FREEDOM
        z = generator.standard_normal((_SAMPLES, size)) / np.sqrt(chi)[:, None]
        new = z @ factor.T
        points.append(new)
        logs.append(log_density(new))
        every, log = np.concatenate(points), np.concatenate(logs)
        # the density of all rounds together, as a mixture
        drawn = np.logaddexp.reduce(
            [_log_student(every, component) for component in mixture], axis=0
        )
        ratio = log - drawn
        weights = np.exp(ratio - ratio.max())
        weights = np.minimum(weights, weights.mean() * math.sqrt(len(weights)))
        weights /= weights.sum()
        matrix = (every * weights[:, None]).T @ every + 1e-6 * np.eye(size)
        if np.sum(weights**2) * _ENOUGH < 1.0:
            break
    return matrix


def factor_of(covariance: FloatArray) -> FloatArray:
    """Cholesky's factor of a covariance, whose diagonal is enlarged so that it exists."""
    return _factor(covariance + 1e-12 * np.diag(np.diag(covariance)))


def _factor(matrix: FloatArray) -> FloatArray:
    return np.asarray(np.linalg.cholesky(matrix), dtype=np.float64)


def _log_student(points: FloatArray, factor: FloatArray) -> FloatArray:
    """The logarithm of Student's density (S,), but for a constant."""
    size = points.shape[1]
    scaled = np.linalg.solve(factor, points.T)
    squares = np.sum(scaled**2, axis=0)
    logarithm: FloatArray = -0.5 * (_FREEDOM + size) * np.log1p(squares / _FREEDOM)
    return logarithm - float(np.sum(np.log(np.abs(np.diag(factor)))))


# ---- The posterior density of the parameters of a motion, with the shape that fits each best
# Areas follow a motion as they do to first order, and from there by one Gauss-Newton step: without
# the former, a motion three standard errors away has a step so long that its predicted gain is 6
# too large.

_SEED = 20180708


def covariance_of_motion(solution: Robust, tie: Tie) -> FloatArray:
    """Second moments (8, 8) of the parameters about those of a solution; 0 of those that stay."""
    at = np.ix_(*2 * [free(solution)])
    curvature = solution.refined.covariance[:MOTION, :MOTION][at]
    factor = factor_of(curvature)
    density = log_density(solution, tie, factor)

    def densities(points: FloatArray) -> FloatArray:
        return np.array([density(point) for point in points])

    wide = second_moments(densities, len(factor), np.random.default_rng(_SEED))
    moments = np.zeros((MOTION, MOTION))
    moments[at] = factor @ wide @ factor.T
    return moments


def free(solution: Robust) -> IntArray:
    """The parameters of the motion that do not stay: all, or those about one axis."""
    return np.flatnonzero(solution.refined.free[:MOTION])


def log_density(solution: Robust, tie: Tie, factor: FloatArray) -> Callable[[FloatArray], float]:
    """The logarithm of the density of offsets in units of a factor of a covariance.

    Both are of the parameters that are free.
    """
    problem, state, normal = solution.problem, solution.refined.state, solution.refined.normal
    which = free(solution)
    follow = -np.linalg.solve(normal[MOTION:, MOTION:], normal[MOTION:, :MOTION])

    def density(scaled: FloatArray) -> float:
        offsets = np.zeros(MOTION)
        offsets[which] = factor @ scaled
        trial = moved(state, offsets)
        trial[_ellipsoid.OF_SHAPE] += follow @ offsets
        if not exists(trial):
            return -math.inf
        return -0.5 * _refinement.profiled_cost(problem, trial, tie)

    return density


def exists(state: FloatArray) -> bool:
    """Whether elements are within their bounds, and a body has the moments that follow."""
    fields = SearchState.of(state)
    inside = _ellipsoid.LEAST_X < fields.x < _ellipsoid.MOST_X
    inside &= _ellipsoid.LEAST_RHO < fields.log_rho < _ellipsoid.MOST_RHO
    return fields.is_axial or (inside and _ellipsoid.is_admissible(state))


def moved(state: FloatArray, offsets: FloatArray) -> FloatArray:
    """The state after a change of the eight parameters."""
    step = np.zeros(_refinement.SIZE)
    step[:MOTION] = offsets
    return _ellipsoid.moved(state, step)


# ---- Magnitudes and costs of many states of a free rotation of known shape, side by side

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

    Shapes: moments (3,), wxyz, omega (M, 4) rad/s, seconds (N,) s.
    """
    nodes = problem.at_nodes
    count_states(nodes, known, len(wxyz))
    # the epochs of the nodes, from the origin of the seconds
    shifts = (nodes.t.reshape(-1, len(problem)) - problem.t) * problem.span
    turned = propagate(moments, wxyz, omega, (seconds + shifts).reshape(-1))
    sun, observer = over_body(quaternion.matrix(turned), nodes)
    magnitude = known.magnitudes(sun, observer, least)
    return of_magnitudes(problem, problem.mean_magnitudes(magnitude))


def count_states(problem: CurveProblem, known: KnownShape, states: int) -> None:
    """Count the work of the magnitudes of so many states."""
    terms = states * len(problem) * len(known.mesh.facets)
    problem.tally.add(terms, problem.settings.facet_cost)
    problem.tally.add(states * len(problem), problem.settings.attitude_cost)


def over_body(matrix: FloatArray, problem: CurveProblem) -> tuple[FloatArray, FloatArray]:
    """Directions (M, N, 3) to Sun and observer over body axes of attitudes (M, N, 3, 3)."""
    sun = np.einsum("mnij,in->mnj", matrix, problem.sun)
    return sun, np.einsum("mnij,in->mnj", matrix, problem.observer)


def of_magnitudes(problem: CurveProblem, magnitude: FloatArray) -> Costs:
    """The costs of magnitudes (M, N)."""
    r = (problem.y - magnitude) * problem.root
    along = r @ problem.u.T
    return Costs(np.sum(r * r, axis=1) - np.sum(along * along, axis=1), r, along)


# ---- The posterior density of a free rotation of known shape: attitude and rates
# Shadows of facets have steps, so that the density has many narrow peaks near a solution.  The
# curvature is that of one of them; second moments are those of all.

# Turn (rad, ICRF) and rates.
STATE_SIZE = 6
# Standard errors between two minima that count as two.
_DISTINCT = 0.5


def covariance_of_state(
    solution: Weighted[object],
    point: MovingPoint,
    seconds: FloatArray,
    known: KnownShape,
    least: float,
) -> FloatArray:
    """Second moments (P, P) of the parameters about those of a solution; 0 of those that stay.

    Shapes: seconds (N,) s.
    """
    which = np.flatnonzero(solution.refined.free[:STATE_SIZE])
    at = np.ix_(which, which)
    factor = factor_of(solution.refined.covariance[at])
    wxyz, omega = point.spin.wxyz_icrf, point.spin.angular_velocity
    block = max(BLOCK // len(seconds), 1)

    def density(scaled: FloatArray) -> FloatArray:
        step = np.zeros((len(scaled), STATE_SIZE))
        step[:, which] = scaled @ factor.T
        q = quaternion.multiply(forms.from_rotation_vector(step[:, :3]), wxyz)
        w = omega + step[:, 3:]
        parts = [
            costs(
                solution.problem,
                known,
                point.body.moments,
                q[k : k + block],
                w[k : k + block],
                seconds,
                least,
            ).cost
            for k in range(0, len(step), block)
        ]
        return -0.5 * np.concatenate(parts)

    wide = second_moments(density, len(which), np.random.default_rng(_SEED))
    moments = np.zeros((point.size, point.size))
    moments[at] = factor @ wide @ factor.T
    return moments


def spread(covariance: FloatArray, rivals: Iterable[tuple[FloatArray, float]]) -> FloatArray:
    """The second moments (P, P) that other minima add to the covariance of one.

    Shapes: covariance (P, P), rivals (P,).
    """
    size = np.sqrt(np.maximum(np.diag(covariance), 1e-300))
    inverse = np.linalg.pinv(covariance / np.outer(size, size), rcond=1e-12, hermitian=True)
    offsets, weights = [np.zeros(len(size))], [1.0]
    for offset, behind in sorted(rivals, key=lambda rival: rival[1]):
        steps = (np.array(offsets) - offset) / size
        if np.min(np.einsum("np,pq,nq->n", steps, inverse, steps)) > _DISTINCT**2:
            offsets.append(offset)
            weights.append(math.exp(-0.5 * behind))
    return about_first(offsets, weights)


def about_first(offsets: Sequence[FloatArray], weights: Sequence[float]) -> FloatArray:
    """The second moments (P, P) of minima about the first, from their offsets (P,) and weights."""
    every, share = np.array(offsets), np.array(weights) / sum(weights)
    return (every * share[:, None]).T @ every
