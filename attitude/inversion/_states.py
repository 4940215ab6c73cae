"""From the parameters of a search to a motion: moments, attitude, rates; posterior samples."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, NamedTuple, cast

import numpy as np

from attitude._support import validation
from attitude.errors import AttitudeError
from attitude.frames import quaternion
from attitude.frames import representations as forms
from attitude.inversion import _ellipsoid, _errors, _motions, _pole_map, _refinement, _shapes
from attitude.inversion._ellipsoid import OF_SHAPE, SearchState, is_axial
from attitude.inversion._refinement import MOTION
from attitude.inversion._shapes import Tie
from attitude.motions._body import Body
from attitude.motions._differentiable import samples
from attitude.motions._free_rotation import FreeRotation
from attitude.motions._spin import Spin

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.figure import Figure

    from attitude._support.annotations import BoolArray, FilePath, FloatArray, IntArray
    from attitude.epochs._instants import Instant
    from attitude.inversion._errors import GroupErrors
    from attitude.inversion._evidence import Robust
    from attitude.inversion._moving import MovingPoint
    from attitude.inversion._solution import Solution


# ---- What `moments=` says: the moments of the motion are free, those of the shape, or given


def of(moments: str | float | Body | Sequence[float]) -> Tie:
    """The tie of "shape", "free", a tolerance, three principal moments or a Body."""
    if isinstance(moments, str):
        if moments not in ("shape", "free"):
            raise AttitudeError(
                f'moments is {moments!r}; give "shape", "free", a tolerance, three moments or a '
                "Body."
            )
        return Tie() if moments == "shape" else Tie(math.inf)
    if isinstance(moments, Body):
        known = moments
    elif np.ndim(moments) == 0:
        return Tie(validation.positive(cast("float", moments), "moments"))
    else:
        known = Body(moments=moments, relative=True)
    ordered = np.sort(known.moments)
    if ordered[0] <= 0.0:
        raise AttitudeError("moments has one of zero; a light curve is that of a body with width.")
    return Tie(moments=ordered / ordered[2])


def with_moments(point: MovingPoint, moments: FloatArray) -> MovingPoint:
    """The point with given moments (3,), ascending, in the order of those that it has."""
    order = np.argsort(np.argsort(point.body.moments))
    scaled = moments[order] * (float(point.body.moments.max()) / moments[2])
    body = Body(moments=scaled, relative=point.body.relative, mass=point.body.mass)
    return replace(point, body=body)


# Steps of the derivatives of state by parameters, relative to their scales.
_STEP = 1e-6
# Iterations of a fit without a group of points.
_REFITTED = 30


class PhysicalState(NamedTuple):
    """Rotation matrix (3, 3) to ICRF at the middle of the span, rates (rad per span), moments."""

    matrix: FloatArray
    rates: FloatArray
    moments: FloatArray


def physical(state: FloatArray, known: FloatArray | None = None) -> PhysicalState:
    """The state of motion of the parameters of a search; the largest moment is 1.

    About one axis, which shows no moments, they are the known ones (3,), ascending, or the shape's.
    """
    body = _motions.at_epochs(state, np.zeros(1)).matrix.reshape(3, 3)
    fields = SearchState.of(state)
    matrix = fields.frame @ body
    if fields.is_axial:
        shape = state[OF_SHAPE]
        held = _shapes.constraints(shape, *_shapes.areas(shape))
        ratios = np.exp(np.append(held.log_ratios, 0.0))
        ratios[2] = max(ratios[2], 1.0001 * float(ratios[:2].max()))
        if known is not None:
            ratios = known[np.argsort(np.argsort(ratios))]
        rates = np.array([0.0, 0.0, 4.0 * math.pi * fields.precession])
        return PhysicalState(matrix, rates, ratios / ratios.max())
    moments_of = _motions.moments(state[_ellipsoid.OF_MOMENTS])
    ratios = np.exp(np.append(moments_of.log_ratios, 0.0))
    return PhysicalState(matrix, moments_of.momentum * body[2] / ratios, ratios / ratios.max())


def motion(
    state: FloatArray,
    span: float,
    epoch: Instant,
    covariance: FloatArray | None,
    known: FloatArray | None = None,
) -> FreeRotation:
    """The free rotation of a state, its covariance as in `Spin`; moments as in `physical`."""
    state_of = physical(state, known)
    wxyz = quaternion.from_matrix(state_of.matrix)
    spin = Spin(epoch, wxyz, state_of.rates / span, covariance=covariance)
    return FreeRotation(Body(moments=state_of.moments, relative=True), spin)


def covariance(
    solution: Robust,
    groups: Sequence[IntArray],
    tie: Tie,
    rivals: Sequence[Robust] = (),
) -> tuple[FloatArray, GroupErrors]:
    """Covariance of the state (9, 9), per span, and those of parameters of motion; groups (N,)."""
    state, problem = solution.refined.state, solution.problem
    fixed = ~solution.refined.free

    def refitted(keep: BoolArray) -> FloatArray | None:
        again = _refinement.refine(
            problem.part(keep), state, tie=tie, fixed=fixed, iterations=_REFITTED, gain=1e-5
        ).fitted.state
        turn = quaternion.from_matrix(SearchState.of(state).frame.T @ SearchState.of(again).frame)
        change = again[_ellipsoid.OF_ELEMENTS] - state[_ellipsoid.OF_ELEMENTS]
        return np.concatenate([forms.to_rotation_vector(turn), change])

    shape_model = _refinement.model(problem, state)
    formal = _errors.covariance_of_motion(solution, tie)
    errors_of = _errors.errors(solution, shape_model, groups, MOTION, refitted, formal)
    if is_axial(state):
        others = [
            (rival.refined.state, rival.evidence)
            for rival in rivals
            if is_axial(rival.refined.state)
            and _pole_map.has_turn(problem, rival.refined.state, state)
        ]
        wider = errors_of.covariance + _pole_map.spread(state, solution.evidence, others)
        errors_of = errors_of._replace(covariance=wider)
    slopes = _slopes(state)
    total = slopes @ errors_of.covariance @ slopes.T
    return 0.5 * (total + total.T), errors_of


def _slopes(state: FloatArray) -> FloatArray:
    """Derivatives (9, 8) of rotation vector (ICRF), rates and moments by the parameters."""
    slopes = np.zeros((9, MOTION))
    fields, scale = SearchState.of(state), np.ones(MOTION)
    scale[_refinement.PRECESSION] = abs(fields.precession)
    scale[_refinement.NUTATION] = max(abs(fields.nutation), 1.0)
    for p in range(4 if is_axial(state) else MOTION):
        step = np.zeros(MOTION)
        step[p] = _STEP * scale[p]
        ends = [physical(_errors.moved(state, sign * step)) for sign in (1.0, -1.0)]
        turn = ends[0].matrix @ ends[1].matrix.T
        vector = 0.5 * np.array(
            [turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]]
        )
        width = 2.0 * _STEP * scale[p]
        slopes[:3, p] = vector / width
        slopes[3:6, p] = (ends[0].rates - ends[1].rates) / width
        slopes[6:, p] = (ends[0].moments - ends[1].moments) / width
    return slopes


def drawn(solution: Solution, count: int, seed: int | np.random.Generator) -> list[FreeRotation]:
    """Motions drawn from the normal distribution of the eight parameters of the motion."""

    def changed(offsets: FloatArray) -> FreeRotation:
        state = _errors.moved(solution.state, offsets)
        if not _errors.exists(state):
            raise AttitudeError("the elements are those of no body; draw others.")
        return motion(state, solution.curve.span, solution.curve.epoch, None, solution.tie.moments)

    of_elements = solution._errors_of(solution.weighted).covariance
    return samples(count, seed, of_elements, changed, "take posterior()")


# ---- Samples of the motion from its posterior density, by emcee, from all competing solutions
# The eight parameters of the motion are sampled (`_errors.log_density`).  Solutions that compete
# are sampled one by one, and weighted by their evidence and the volume of their errors.  The
# density is that of independent errors; its samples are widened as the covariance is, see
# `_errors`.


@dataclass(frozen=True, eq=False)
class Posterior:
    """Samples of motions.

    Attributes
    ----------
    offsets : (S, 8) array
        Rotation vector (rad, axes along the momentum), precession and nutation (turns per span),
        phase (turns), ln rho and X, from those of the solution that each sample belongs to.
    solution : (S,) array of int
        The number of that solution, among those sampled.
    weights : (K,) array
        Of the solutions.
    covariance : (8, 8) array
        Of the parameters of the first solution, to compare.
    acceptance : float
        Mean share of the moves accepted.
    states : list of (WIDTH,) arrays
        The parameters of the solutions.
    span : float
        s, that of the curve.
    epoch : Instant
        Of the curve.
    """

    offsets: FloatArray
    solution: IntArray
    weights: FloatArray
    covariance: FloatArray
    acceptance: float
    states: Sequence[FloatArray]
    span: float
    epoch: Instant

    def __len__(self) -> int:
        return len(self.offsets)

    @property
    def ratio(self) -> FloatArray:
        """Standard deviations (8,) of the samples of the first solution over the covariance's."""
        of_best = self.offsets[self.solution == 0]
        formal = np.sqrt(np.diag(self.covariance))
        spread = of_best.std(axis=0)
        return np.divide(spread, formal, out=np.ones(MOTION), where=formal > 0.0)

    def motions(self, count: int, seed: int = 0) -> list[FreeRotation]:
        """Motions of samples drawn at random, solutions by their weights."""
        number = validation.count(count, "count")
        generator = validation.generator(seed)
        all_motions = []
        for which in generator.choice(len(self.weights), number, p=self.weights):
            row = generator.choice(np.flatnonzero(self.solution == which))
            state = _errors.moved(self.states[which], self.offsets[row])
            all_motions.append(motion(state, self.span, self.epoch, None))
        return all_motions

    def plot(self, path: FilePath | None = None) -> Figure:
        """A corner figure of the first solution's parameters; saved if a path is given."""
        from attitude.inversion import _figures

        return _figures.of_posterior(self, path)


def sampled(best: Solution, method: str, walkers: int, steps: int, seed: int) -> Posterior:
    """The posterior of a solution, which is described, and of those that compete with it."""
    validation.one_of(method, "method", ("emcee",))
    validation.count(walkers, "walkers", 17)
    validation.count(steps, "steps", 20)
    try:
        import emcee
    except ImportError as err:
        raise AttitudeError(
            f"posterior needs emcee, which is not installed; install it by "
            f"{validation.installing('posterior')}."
        ) from err
    if best.is_axial:
        raise AttitudeError(
            "the solution rotates about one axis, whose nutation has no parameters to sample; take "
            "its covariance."
        )
    tumbling = [rival for rival in best._rivals if not is_axial(rival.refined.state)]
    solutions = [best.weighted, *tumbling]
    errors_of = [best._errors_of(solution) for solution in solutions]
    generator = validation.generator(seed)
    offsets, numbers, logs, accepted = [], [], [], []
    for number, (solution, errors) in enumerate(zip(solutions, errors_of, strict=True)):
        factor = _errors.factor_of(errors.formal)
        density = _errors.log_density(solution, best.tie, factor)
        sampler = emcee.EnsembleSampler(walkers, MOTION, density)
        sampler.random_state = np.random.RandomState(int(generator.integers(2**32))).get_state()
        with _refinement.limited():
            sampler.run_mcmc(0.5 * generator.standard_normal((walkers, MOTION)), steps)
        chain = sampler.get_chain(discard=steps // 4, flat=True)
        offsets.append(chain @ factor.T @ errors.widening.T)
        numbers.append(np.full(len(chain), number))
        logs.append(-0.5 * solution.evidence + float(np.sum(np.log(np.diag(factor)))))
        accepted.append(float(np.mean(sampler.acceptance_fraction)))
    weights = np.exp(np.array(logs) - max(logs))
    return Posterior(
        offsets=np.concatenate(offsets),
        solution=np.concatenate(numbers),
        weights=weights / weights.sum(),
        covariance=errors_of[0].covariance,
        acceptance=float(np.mean(accepted)),
        states=[solution.refined.state for solution in solutions],
        span=best.curve.span,
        epoch=best.curve.epoch,
    )
