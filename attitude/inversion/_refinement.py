"""Least squares of orientation, elements and areas of a convex body, together.

Derivatives are exact.  A state is a start of `_ellipsoid` with the coefficients of the modes of
`_shapes` behind it, and with the drift of precession and nutation, if that is found too.  The
moments of the motion are tied to those of the homogeneous shape; terms in which the magnitude is
linear are projected out.
"""

from __future__ import annotations

import math
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass, fields
from functools import cached_property
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

    BodyFit: TypeAlias = "Fitted[FloatArray]"
    Refined: TypeAlias = "Linearised[FloatArray]"


# ---- The threads of BLAS: matrices here are so small that several threads only wait for each other


def limited(threads: int = 1) -> AbstractContextManager[object]:
    """A context within which BLAS runs in at most so many threads."""
    try:
        from threadpoolctl import threadpool_limits
    except ImportError:
        return nullcontext()
    return threadpool_limits(threads)


# ---- Least squares of any model with derivatives, from one start

State = TypeVar("State")
# Of results, which are read alone.
AnyState = TypeVar("AnyState", covariant=True)


@dataclass(frozen=True, eq=False)
class Fitted(Generic[AnyState]):
    """A state and its cost; a `BodyFit` is one whose state is an array (WIDTH,).

    Attributes
    ----------
    state
    cost, chi_squared, strain : float
        chi_squared is that of the magnitudes, cost adds the priors; strain is the part of the
        cost that ties the moments to the shape.
    areas : (F,) array
    magnitude : (N,) array
        Of the model.
    """

    state: AnyState
    cost: float
    chi_squared: float
    strain: float
    areas: FloatArray
    magnitude: FloatArray


@dataclass(frozen=True, eq=False)
class Linearised(Fitted[AnyState]):
    """The same with derivatives; `Refined` is one whose state is an array (WIDTH,).

    Attributes
    ----------
    normal : (P, P) array
        Second derivatives of half the cost.
    gradient : (P,) array
        Minus the first ones.
    """

    normal: FloatArray
    gradient: FloatArray

    @property
    def free(self) -> BoolArray:
        """Which parameters (P,) do not stay: those that do have the rows of the unit matrix."""
        return np.asarray(np.diag(self.normal) != 1.0)

    @property
    def covariance(self) -> FloatArray:
        """The inverse (P, P) of the normal matrix; 0 of parameters that stay."""
        return least_squares.inverse(self.normal) * np.outer(self.free, self.free)


@dataclass(frozen=True, eq=False)
class Evaluation(Generic[State]):
    """A state with its cost, and its derivatives, which are computed at the first access.

    Steps that fail and last steps need the cost alone.

    Attributes
    ----------
    fitted : Fitted
    products : function without arguments
        Returns the normal matrix and the gradient.
    """

    fitted: Fitted[State]
    products: Callable[[], tuple[FloatArray, FloatArray]]

    @cached_property
    def linearised(self) -> Linearised[State]:
        """The state with derivatives."""
        normal, gradient = self.products()
        of_state = {field.name: getattr(self.fitted, field.name) for field in fields(self.fitted)}
        return Linearised(**of_state, normal=normal, gradient=gradient)


_RULE = least_squares.Rule(
    start=3e-3, least=1e-7, stuck=1e6, larger=5.0, gain=1e-3, settled=3, bounds_count=False
)


def minimum(
    at: Callable[[State], Evaluation[State]],
    moved: Callable[[State, FloatArray], State | None],
    start: State,
    iterations: int,
    gain: float,
) -> Evaluation[State]:
    """The least cost near a start."""

    def stepped(best: NDArray[Any], steps: FloatArray) -> tuple[NDArray[Any], BoolArray]:
        state = moved(best[0].fitted.state, steps[0])
        return _alone(None if state is None else at(state)), np.array([state is not None])

    problem = least_squares.Problem(
        _near, stepped, _costs, is_cost_first=True, steps=least_squares.steps_of_one
    )
    rule = _RULE._replace(gain=gain)
    best: Evaluation[State]
    best = least_squares.minimum(problem, _alone(at(start)), rule, iterations).states[0]
    return best


def _costs(evaluations: NDArray[Any]) -> FloatArray:
    return np.array([evaluations[0].fitted.cost])


def _near(evaluations: NDArray[Any]) -> least_squares.Near:
    best = evaluations[0].linearised
    return least_squares.Near(
        evaluations, _costs(evaluations), best.normal[None], best.gradient[None]
    )


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
    """Magnitudes of a state, means over exposures, and their derivatives.

    Attributes
    ----------
    problem : CurveProblem
    lit : BodyLight
        The magnitudes at the nodes of the exposures, K of each; K is 1 without exposures.
    by_motion : function without arguments
        Returns derivatives at the nodes (M, K N) by the motion, and those by its drift (D, K N).
    """

    problem: CurveProblem
    lit: _shapes.BodyLight
    by_motion: Callable[[], tuple[FloatArray, FloatArray]]

    @cached_property
    def magnitude(self) -> FloatArray:
        """Magnitudes (N,)."""
        return self.problem.mean_magnitudes(self.lit.magnitude)

    @cached_property
    def jacobian(self) -> FloatArray:
        """Derivatives (P, N) by motion, shape and drift."""
        shares = self.problem.shares(self.lit.magnitude)
        motion, drift = self.by_motion()
        if shares is not None:
            motion, drift = _shapes.summed(motion, shares), _shapes.summed(drift, shares)
        return np.concatenate([motion, self.lit.by_shape(shares), drift])


def model(problem: CurveProblem, state: FloatArray) -> ShapeModel:
    """The magnitudes of a state (WIDTH or less,), means over exposures, with derivatives."""
    nodes = problem.at_nodes
    t, count = nodes.t, len(nodes)
    share = 0.5 * (1.0 + (len(state) - _ellipsoid.WIDTH) / _shapes.MODES)
    settings = problem.settings
    a_point = share * settings.body_cost + len(problem.u) * settings.body_term_cost
    problem.tally.add(1, settings.step_cost + count * a_point)
    drift = state[WIDTH:]
    r, g = _drifting(state, t) if drift.size else _motions.at_epochs(state, t)
    sun, observer = np.empty((2, 3, count))
    _over_body(state, r, nodes.sun, nodes.observer, sun, observer)
    lit = _shapes.magnitudes(sun.T, observer.T, state[:WIDTH][OF_SHAPE])

    def by_motion() -> tuple[FloatArray, FloatArray]:
        rows = np.empty((MOTION, count))
        _by_motion(t, r, g, lit.across, rows)
        return rows, 0.5 * t * rows[PRECESSION : PRECESSION + drift.size]

    return ShapeModel(problem, lit, by_motion)


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
    """Directions (3, N) over the axes of the body, into arrays (3, N); r as in `at_epochs`."""
    c = state[5:14]
    for vectors, over in ((suns, over_sun), (observers, over_observer)):
        for i in range(r.shape[1]):
            x, y, z = vectors[0, i], vectors[1, i], vectors[2, i]
            u = c[0] * x + c[3] * y + c[6] * z
            v = c[1] * x + c[4] * y + c[7] * z
            w = c[2] * x + c[5] * y + c[8] * z
            for k in range(3):
                over[k, i] = r[k, i] * u + r[3 + k, i] * v + r[6 + k, i] * w


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
    priors = _shapes.penalties(
        shape, shape_model.lit.areas, shape_model.lit.slopes, moments, MOTION, tie
    )
    if not drift.size:
        return priors
    return priors._replace(
        slopes=np.pad(priors.slopes, ((0, 0), (0, DRIFT))),
        offsets=np.append(priors.offsets, drift / DRIFT_WIDTH),
        weights=np.append(priors.weights, np.full(DRIFT, 1.0 / DRIFT_WIDTH)),
    )


def profiled_cost(problem: CurveProblem, state: FloatArray, tie: _shapes.Tie) -> float:
    """The cost of a motion after one Gauss-Newton step of its shape."""
    held = np.arange(len(state) - WIDTH + SIZE) < MOTION
    fit = _at(problem, state, tie, held).linearised
    return fit.cost - float(fit.gradient @ least_squares.solved(fit.normal, fit.gradient))


def _at(
    problem: CurveProblem, state: FloatArray, tie: _shapes.Tie, held: BoolArray
) -> Evaluation[FloatArray]:
    """A state, where some parameters (P,) are held."""
    shape_model = model(problem, state)
    return evaluated(problem, state, shape_model, _penalties(state, shape_model, tie), held)


def refine(
    problem: CurveProblem,
    start: FloatArray,
    *,
    iterations: int = 20,
    tie: _shapes.Tie = _SHAPE,
    gain: float = 1e-3,
    fixed: BoolArray | None = None,
    modes: int = _shapes.MODES,
) -> Evaluation[FloatArray]:
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
    return minimum(lambda trial: _at(problem, trial, tie, held), _moved, state, iterations, gain)


def evaluated(
    problem: CurveProblem,
    state: State,
    shape_model: ShapeModel,
    priors: _shapes.Priors,
    held: BoolArray,
) -> Evaluation[State]:
    """A state with magnitudes of its own, where some parameters (P,) are held."""
    r = (problem.y - shape_model.magnitude) * problem.root
    along = problem.u @ r
    chi = float(r @ r - along @ along)
    prior = float(priors.residuals @ priors.residuals + priors.offsets @ priors.offsets)

    def products() -> tuple[FloatArray, FloatArray]:
        weighted = shape_model.jacobian * problem.root
        across = weighted @ problem.u.T
        normal = weighted @ weighted.T
        normal -= across @ across.T
        normal += priors.slopes.T @ priors.slopes
        normal.flat[:: len(normal) + 1] += priors.weights**2
        gradient = weighted @ r - across @ along - priors.residuals @ priors.slopes
        gradient -= priors.weights * priors.offsets
        if held.any():
            gradient[held] = 0.0
            normal[held, :] = normal[:, held] = 0.0
            normal[held, held] = 1.0
        return normal, gradient

    fitted = Fitted(
        state,
        cost=chi + prior,
        chi_squared=chi,
        strain=priors.strain,
        areas=shape_model.lit.areas,
        magnitude=shape_model.magnitude,
    )
    return Evaluation(fitted, products)


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
