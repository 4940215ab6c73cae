"""Least squares of orientation, elements and areas of a convex body, together.

Derivatives are exact.  A state is a start of `_ellipsoid` with the coefficients of the modes of
`_shapes` behind it, and with the drift of precession and nutation, if that is found too.  The
moments of the motion are tied to those of the homogeneous shape; terms in which the magnitude is
linear are projected out.
"""

from __future__ import annotations

import math
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Generic, TypeAlias, TypeVar

import numpy as np

from attitude._compilation.decorators import reduction
from attitude._support import least_squares
from attitude.inversion import _ellipsoid, _motions, _shapes
from attitude.inversion._ellipsoid import OF_MODES, OF_RATES, OF_SHAPE, SearchState

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from attitude._support.annotations import BoolArray, FloatArray
    from attitude.inversion._problem import CurveProblem

    Refined: TypeAlias = "Fitted[FloatArray]"


# ---- The threads of BLAS: matrices here are so small that several threads only wait for each other


def limited(threads: int = 1) -> AbstractContextManager[object]:
    """A context within which BLAS runs in at most so many threads."""
    try:
        from threadpoolctl import threadpool_limits
    except ImportError:
        return nullcontext()
    limits: AbstractContextManager[object] = threadpool_limits(threads)
    return limits


# ---- Least squares of any model with derivatives, from one start

State = TypeVar("State")
# Of results, which are read alone.
AnyState = TypeVar("AnyState", covariant=True)


@dataclass(frozen=True, eq=False)
class Fitted(Generic[AnyState]):
    """A state near its least cost; `Refined` is one whose state is an array (WIDTH,).

    Attributes
    ----------
    state
    cost, chi_squared, strain : float
        chi_squared is that of the magnitudes, cost adds the priors; strain is the part of the
        cost that ties the moments to the shape.
    normal : (P, P) array
        Second derivatives of half the cost.
    gradient : (P,) array
        Minus the first ones.
    areas : (F,) array
    magnitude : (N,) array
        Of the model.
    """

    state: AnyState
    cost: float
    chi_squared: float
    strain: float
    normal: FloatArray
    gradient: FloatArray
    areas: FloatArray
    magnitude: FloatArray


_RULE = least_squares.Rule(
    start=3e-3, least=1e-7, stuck=1e6, larger=5.0, gain=1e-3, settled=3, bounds_count=False
)


def minimum(
    at: Callable[[State], Fitted[State]],
    moved: Callable[[State, FloatArray], State | None],
    start: State,
    iterations: int,
    gain: float,
) -> Fitted[State]:
    """The least cost near a start."""

    def near(states: NDArray[Any]) -> least_squares.Near:
        best = at(states[0])
        cost = np.array([best.cost])
        return least_squares.Near(_alone(best), cost, best.normal[None], best.gradient[None])

    def stepped(best: NDArray[Any], steps: FloatArray) -> tuple[NDArray[Any], BoolArray]:
        state = moved(best[0].state, steps[0])
        return _alone(state), np.array([state is not None])

    problem, rule = least_squares.Problem(near, stepped), _RULE._replace(gain=gain)
    best: Fitted[State] = least_squares.minimum(problem, _alone(start), rule, iterations).states[0]
    return best


def _alone(state: object) -> NDArray[Any]:
    """An array of one object."""
    states = np.empty(1, object)
    states[0] = state
    return states


# Parameters of the motion.
NAMES: tuple[str, ...] = ("x", "y", "z", "precession", "nutation", "phase", "ln rho", "X")
MOTION = len(NAMES)
AZIMUTH, PRECESSION, NUTATION, PHASE, LN_RHO, X = range(2, MOTION)
# The turn of the body, and of that what moves its pole.
TURN = slice(0, 3)
TILT = slice(0, 2)
SIZE = MOTION + _shapes.SIZE
WIDTH = _ellipsoid.WIDTH - _shapes.ELLIPSOID + _shapes.SIZE
# Behind them, where rates drift: how fast precession and nutation change, turns per span^2.
DRIFT = 2
# Their standard deviation before the curve is seen.  Over 8 years YORP makes less than 0.1 of most
# bodies, and 5 of the fastest known, (54509) YORP.
DRIFT_WIDTH = 10.0
_SHAPE = _shapes.Tie()


@dataclass(frozen=True, eq=False)
class ShapeModel:
    """Magnitudes (N,) of a state, their Jacobian (P, N), areas, and the slopes of the areas."""

    magnitude: FloatArray
    jacobian: FloatArray
    areas: FloatArray
    slopes: FloatArray


def model(problem: CurveProblem, state: FloatArray) -> ShapeModel:
    """The magnitudes of a state (WIDTH or less,), means over exposures, with derivatives."""
    nodes = problem.at_nodes()
    t, count = nodes.t, len(nodes)
    share = 0.5 * (1.0 + (len(state) - _ellipsoid.WIDTH) / _shapes.MODES)
    settings = problem.settings
    problem.tally.add(1, settings.step_cost + share * count * settings.body_cost)
    drift = state[WIDTH:]
    r, g = _drifting(state, t) if drift.size else _motions.at_epochs(state, t)
    sun, observer = np.empty((2, count, 3))
    _over_body(state, r, nodes.sun, nodes.observer, sun, observer)
    lit = _shapes.magnitudes(sun, observer, state[:WIDTH][OF_SHAPE])
    size = MOTION + len(lit.by_shape)
    jacobian = np.empty((size + drift.size, count))
    _by_motion(t, r, g, lit.across, jacobian)
    jacobian[MOTION:size] = lit.by_shape
    jacobian[size:] = 0.5 * t * jacobian[PRECESSION : PRECESSION + drift.size]
    magnitude, jacobian = problem.over_exposures(lit.magnitude, jacobian)
    return ShapeModel(magnitude, jacobian, lit.areas, lit.slopes)


def drift_of(state: FloatArray) -> FloatArray:
    """The drift (2,) of precession and nutation of a state, zeros if it has none."""
    return state[WIDTH:] if len(state) > WIDTH else np.zeros(DRIFT)


def _drifting(state: FloatArray, t: FloatArray) -> _motions.SeriesAttitudes:
    """Attitudes at epochs (N,) of a state whose rates drift.

    The phase of the nutation is that of another time; what the precession lacks there turns the
    body about the momentum.
    """
    by_precession, by_nutation = state[WIDTH:]
    precession, nutation = state[OF_RATES]
    later = t + 0.5 * by_nutation / nutation * t * t
    turn = 4.0 * math.pi * (precession * (t - later) + 0.5 * by_precession * t * t)
    c, s = np.cos(turn), np.sin(turn)
    r, g = _motions.at_epochs(state, later)
    for vectors in (r.reshape(3, 3, -1), g.reshape(3, 3, -1).swapaxes(0, 1)):
        x, y = vectors[0].copy(), vectors[1].copy()
        vectors[0], vectors[1] = c * x - s * y, s * x + c * y
    return _motions.SeriesAttitudes(r, g)


@reduction
def _over_body(state, r, suns, observers, over_sun, over_observer):
    """Directions (3, N) over the axes of the body, into arrays (N, 3); r as in `at_epochs`."""
    c = state[5:14]
    for vectors, over in ((suns, over_sun), (observers, over_observer)):
        for i in range(r.shape[1]):
            x, y, z = vectors[0, i], vectors[1, i], vectors[2, i]
            u = c[0] * x + c[3] * y + c[6] * z
            v = c[1] * x + c[4] * y + c[7] * z
            w = c[2] * x + c[5] * y + c[8] * z
            for k in range(3):
                over[i, k] = r[k, i] * u + r[3 + k, i] * v + r[6 + k, i] * w


@reduction
def _by_motion(t, r, g, across, jacobian):
    """Slopes by the motion, from those by a turn (N, 3) over the axes of the body.

    Into the first rows of jacobian (P, N); r and g as in `at_epochs`.
    """
    for i in range(t.size):
        u, v, w = across[i, 0], across[i, 1], across[i, 2]
        a = r[0, i] * u + r[1, i] * v + r[2, i] * w
        b = r[3, i] * u + r[4, i] * v + r[5, i] * w
        c = r[6, i] * u + r[7, i] * v + r[8, i] * w
        by_phase = 2.0 * math.pi * (a * g[0, i] + b * g[1, i] + c * g[2, i])
        jacobian[0, i], jacobian[1, i], jacobian[2, i] = a, b, c
        jacobian[3, i] = 4.0 * math.pi * t[i] * c
        jacobian[4, i], jacobian[5, i] = t[i] * by_phase, by_phase
        jacobian[6, i] = a * g[3, i] + b * g[4, i] + c * g[5, i]
        jacobian[7, i] = a * g[6, i] + b * g[7, i] + c * g[8, i]


def _penalties(state: FloatArray, shape_model: ShapeModel, tie: _shapes.Tie) -> _shapes.Priors:
    """The priors of a state."""
    moments = None
    if not _ellipsoid.is_axial(state):
        ratios, slopes = _ellipsoid.log_ratios(state[None])
        fields = SearchState.of(state)
        moments = _shapes.MotionMoments(
            ratios[0], slopes[0, :, :MOTION], fields.nutation > 0.0, fields.x < 0.0
        )
    shape, drift = state[:WIDTH][OF_SHAPE], state[WIDTH:]
    priors = _shapes.penalties(shape, shape_model.areas, shape_model.slopes, moments, MOTION, tie)
    if not drift.size:
        return priors
    return priors._replace(
        slopes=np.pad(priors.slopes, ((0, 0), (0, DRIFT))),
        offsets=np.append(priors.offsets, drift / DRIFT_WIDTH),
        weights=np.append(priors.weights, np.full(DRIFT, 1.0 / DRIFT_WIDTH)),
    )


def profiled_cost(problem: CurveProblem, state: FloatArray, tie: _shapes.Tie) -> float:
    """The cost of a motion after one Gauss-Newton step of its shape."""
    fit = _near(problem, state, tie, np.arange(len(state) - WIDTH + SIZE) < MOTION)
    return fit.cost - float(fit.gradient @ np.linalg.solve(fit.normal, fit.gradient))


def _near(problem: CurveProblem, state: FloatArray, tie: _shapes.Tie, held: BoolArray) -> Refined:
    """The cost near a state, where some parameters (P,) are held."""
    shape_model = model(problem, state)
    return linearised(problem, state, shape_model, _penalties(state, shape_model, tie), held)


def refine(
    problem: CurveProblem,
    start: FloatArray,
    *,
    iterations: int = 20,
    tie: _shapes.Tie = _SHAPE,
    gain: float = 1e-3,
    fixed: BoolArray | None = None,
    modes: int = _shapes.MODES,
) -> Refined:
    """The state of least cost near a start.

    Parameters
    ----------
    problem : CurveProblem
    start : (WIDTH,) array
        Or a start of `_ellipsoid`, whose shape is the ellipsoid; or one with a drift behind it,
        which is found too.
    iterations : int
    tie : Tie
        Of the moments of motion and shape.
    gain : float
        Relative decrease of the cost at which the iteration ends.
    fixed : (K,) array of bool, optional
        Which of the first K parameters stay: 8 of the motion, 2 of the ellipsoid, the modes.
    modes : int
        Of the shape, the smoothest first; at least those of the start.
    """
    drift = start[WIDTH:]
    state = np.zeros(_ellipsoid.WIDTH + modes + len(drift))
    state[: len(start)] = start
    held = np.zeros(MOTION + _shapes.ELLIPSOID + modes + len(drift), bool)
    if fixed is not None:
        held[: len(fixed)] = fixed[: len(held)]
    return minimum(lambda trial: _near(problem, trial, tie, held), _moved, state, iterations, gain)


def linearised(
    problem: CurveProblem,
    state: State,
    shape_model: ShapeModel,
    priors: _shapes.Priors,
    held: BoolArray,
) -> Fitted[State]:
    """The cost near a state with magnitudes of its own, where some parameters (P,) are held."""
    r = (problem.y - shape_model.magnitude) * problem.root
    along = problem.u @ r
    weighted = shape_model.jacobian * problem.root
    across = weighted @ problem.u.T
    by_prior, offsets, weights = priors.slopes, priors.offsets, priors.weights
    normal = weighted @ weighted.T
    normal -= across @ across.T
    normal += by_prior.T @ by_prior
    normal.flat[:: len(normal) + 1] += weights**2
    gradient = weighted @ r - across @ along - priors.residuals @ by_prior - weights * offsets
    if held.any():
        gradient[held] = 0.0
        normal[held, :] = normal[:, held] = 0.0
        normal[held, held] = 1.0
    chi = float(r @ r - along @ along)
    prior = float(priors.residuals @ priors.residuals + offsets @ offsets)
    return Fitted(
        state,
        cost=chi + prior,
        chi_squared=chi,
        strain=priors.strain,
        normal=normal,
        gradient=gradient,
        areas=shape_model.areas,
        magnitude=shape_model.magnitude,
    )


def _moved(state: FloatArray, step: FloatArray) -> FloatArray | None:
    """The state after a step of limited length; None outside of the bounds."""
    modes = step[_ellipsoid.PARAMETERS :]
    longest = max(
        float(np.linalg.norm(step[TURN])),
        6.0 * abs(step[PHASE]),
        2.0 * abs(step[LN_RHO]),
        4.0 * abs(step[X]),
        *np.abs(step[MOTION : _ellipsoid.PARAMETERS]),
        float(np.abs(modes).max()) / 3.0,
    )
    if longest > 0.5:
        step = step * (0.5 / longest)
    trial = _ellipsoid.moved(state, step)
    trial[OF_MODES] += step[_ellipsoid.PARAMETERS :]
    return trial if _ellipsoid.are_allowed(trial) else None
