"""The states of a body of known shape and moments from brightness alone, searched and ranked.

Random attitudes and rates are screened on the points of a short span; the best are refined on it
and on spans that grow to the whole curve, each time with the best of them and samples of their
errors.  Many states are propagated and refined side by side.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from attitude._support import least_squares, validation
from attitude._support.least_squares import Decomposed, Near
from attitude.errors import AttitudeError
from attitude.frames import quaternion
from attitude.frames import representations as forms
from attitude.inversion import _errors, _evidence, _moving, _problem, _shapes, _verdicts
from attitude.inversion._from_start import Refinement
from attitude.inversion._settings import Tally
from attitude.inversion._shapes import Tie
from attitude.inversion._solution import SpinStates
from attitude.motions._body import Body
from attitude.motions._free_rotation import FreeRotation
from attitude.motions._propagation import linearized
from attitude.motions._spin import Spin

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from attitude._support.annotations import BoolArray, FloatArray, IntArray
    from attitude.inversion._evidence import Weighted
    from attitude.inversion._moving import MovingFit, MovingPoint, MovingState
    from attitude.inversion._problem import CurveProblem
    from attitude.inversion._settings import Settings
    from attitude.inversion._shapes import KnownShape
    from attitude.photometry._curve import LightCurve
    from attitude.scattering._law import Law
    from attitude.shape._mesh import Mesh


# Points of the first span at least.
_FIRST_POINTS = 16
# Turns in the first span at the largest rate, at least.
_FIRST_TURNS = 1.2
# Random starts for each cell of rates of the first span.
_STARTS = 400
# The width of a cell, turns.
_CELL = 0.4
# Random starts at least and at most.
_FEWEST = 20_000
_MOST = 250_000
# States that are refined first.
_REFINED = 3000
# States that are kept after the first span.
_KEPT = 500
# States that are kept at the end.
_LEFT = 60
# Growth of the span from one stage to the next.
_GROWTH = 1.5
# Iterations on each span.
_ITERATIONS = 7
# Iterations on the whole.
_LAST = 25
# Reach beyond the first epoch of the next pass, over its distance.
_ACROSS = 1.02
# Turns at the largest rate without an epoch, at which a pass ends.
_GAP_TURNS = 5.0
# Median distances of epochs without an epoch, at which a pass ends.
_GAP_STEPS = 20.0
# Model error, mag, on the first span and on the whole: glints are narrow, and the start is rough.
_ERRORS = 0.4, 0.1
# First spans that are tried.
_ATTEMPTS = 28
_RULE = least_squares.Rule(
    start=1e-2, least=1e-6, stuck=1e4, larger=5.0, gain=1e-4, settled=1, ridge=1e-9
)
# States that are sampled from their errors when the span grows.
_SAMPLED = 12
# Samples of each of them.
_SAMPLES = 6
# Distances at which two states are one: rad, and share of the rate times turns.
_SAME = 0.1


class States(NamedTuple):
    """Attitudes (M, 4) and rates (M, 3), rad/s, at the origin; costs (M,)."""

    wxyz: FloatArray
    omega: FloatArray
    cost: FloatArray

    def rows(self, chosen: IntArray) -> States:
        """Some of them."""
        return States(self.wxyz[chosen], self.omega[chosen], self.cost[chosen])


@dataclass(eq=False)
class PassSearch:
    """A search and what it has found.

    Attributes
    ----------
    problem : CurveProblem
    known : KnownShape
        Over principal axes.
    moments : (3,) array
    most : float
        Largest rate, rad/s.
    generator : Generator
    progress : callable
    states : States
        The best first, at the epoch `origin`.
    origin : float
        The middle of the first span, s since the epoch of the curve.
    """

    problem: CurveProblem
    known: KnownShape
    moments: FloatArray
    most: float
    generator: np.random.Generator
    progress: Callable[[str], object]
    states: States = field(init=False)
    origin: float = field(init=False)

    def run(self) -> None:
        """Search from one first span after another, until the residuals are as the errors.

        It also ends where several searches have found one state that the model fits roughly.
        """
        problem, settings = self.problem, self.problem.settings
        seconds = problem.seconds
        self.least = self.known.floor(problem.sun.T, problem.observer.T)
        best: States | None = None
        origin = 0.0
        costs: list[float] = []
        is_rough = False
        for attempt in range(_ATTEMPTS):
            middle, span = _first_span(seconds, self.most, attempt)
            self._from(middle, span)
            costs.append(float(self.states.cost[0]))
            self.progress(f"attempt {attempt + 1}: cost {costs[-1]:.0f}")
            if best is None or costs[-1] < best.cost[0]:
                best, origin = self.states, self.origin
                is_rough = self._mean_square() < settings.known_rough
            agreeing = sum(cost < settings.known_alike * min(costs) for cost in costs)
            fits = min(costs) < len(problem) / settings.known_expected
            is_found = is_rough and agreeing >= settings.known_agreeing
            if fits or is_found or self.problem.tally.is_over:
                break
        assert best is not None
        self.states, self.origin = best, origin

    def _mean_square(self) -> float:
        """That of the residuals of the best state over their errors, without the worst of them."""
        problem = self.problem.with_model_error(_ERRORS[1])
        nearby = self._costs(problem, self.states.wxyz[:1], self.states.omega[:1])
        squares = np.sort((nearby.residual - nearby.along @ problem.u)[0] ** 2)
        return float(np.mean(squares[: math.ceil((1.0 - problem.settings.worst) * len(squares))]))

    def _from(self, middle: float, span: float) -> None:
        """Search from one first span: its middle and half its length, s."""
        problem = self.problem
        self.origin = middle
        away = np.abs(problem.seconds - middle)
        early = problem.part(away <= span).with_model_error(_ERRORS[0])
        self.states = self._screened(early, span)
        self.states = self._refined(early, self.states, _ITERATIONS)
        self._keep(_KEPT)
        whole = float(away.max())
        first = span
        while span < whole:
            # across a gap to the first points of the next pass
            beyond = away[away > span].min() * _ACROSS
            span = min(max(span * _GROWTH, float(beyond)), whole)
            count = max(int(len(self.states.cost) / 1.35), _LEFT)
            share = math.log(span / first) / math.log(whole / first)
            error = _ERRORS[0] * (_ERRORS[1] / _ERRORS[0]) ** share
            early = problem.part(away <= span).with_model_error(error)
            self.states = self._refined(early, self._branched(early, self.states), _ITERATIONS)
            self._keep(count)
            self.progress(f"span {2.0 * span:.0f} s: {len(self.states.cost)} states")
            if self.problem.tally.is_over:
                break
        early = problem.with_model_error(_ERRORS[1])
        if self.problem.tally.is_over:
            self._keep(_SAMPLED)
            self.states = self._refined(early, self.states, _LAST, is_last=True)
        else:
            self.states = self._refined(early, self._branched(early, self.states), _LAST)
        self._keep(_LEFT)

    def _screened(self, problem: CurveProblem, span: float) -> States:
        """The best of random states on the first span."""
        turns = self.most * 2.0 * span / (2.0 * math.pi)
        count = int(_STARTS * 4.2 * (turns / _CELL + 0.5) ** 3)
        count = min(max(count, _FEWEST), _MOST)
        best = States(np.empty((0, 4)), np.empty((0, 3)), np.empty(0))
        block = max(_errors.BLOCK // len(problem), 1)
        for begin in range(0, count, block):
            size = min(block, count - begin)
            wxyz = self.generator.standard_normal((size, 4))
            wxyz /= np.linalg.norm(wxyz, axis=1)[:, None]
            omega = self.generator.standard_normal((size, 3))
            omega /= np.linalg.norm(omega, axis=1)[:, None]
            omega *= self.most * self.generator.random((size, 1)) ** (1.0 / 3.0)
            both = _joined(best, States(wxyz, omega, self._costs(problem, wxyz, omega).cost))
            best = both.rows(np.argsort(both.cost, kind="stable")[:_REFINED])
            if begin % (50 * block) == 0:
                self.progress(f"{begin + size} of {count} random states")
            if self.problem.tally.is_over:
                break
        return best

    def _costs(self, problem: CurveProblem, wxyz: FloatArray, omega: FloatArray) -> _errors.Costs:
        """Costs of states."""
        t = problem.seconds - self.origin
        return _errors.costs(problem, self.known, self.moments, wxyz, omega, t, self.least)

    def _near(self, problem: CurveProblem, states: FloatArray) -> Near:
        """Costs near states (M, 7), attitudes and rates, by turn (rad, inertial axes) and rates."""
        block = max(_errors.BLOCK // len(problem), 1)
        parts = [
            self._near_block(problem, states[begin : begin + block])
            for begin in range(0, len(states), block)
        ]
        return Near(*(np.concatenate(columns) for columns in zip(*parts, strict=True)))

    def _near_block(self, problem: CurveProblem, states: FloatArray) -> Near:
        t = problem.seconds - self.origin
        # six magnitudes for differences beside the own
        _errors.count_states(problem, self.known, 7 * len(states))
        problem.tally.add(len(states), problem.settings.slopes_cost)
        turned, slopes = linearized(self.moments, states[:, :4], states[:, 4:], t)
        matrix = quaternion.matrix(turned)
        lit = self.known.lit(*_errors.over_body(matrix, problem), self.least)
        across = np.einsum("mnij,mnj->mni", matrix, lit.across)
        jacobian = np.einsum("mni,mnip->mpn", across, slopes[..., :6]) * problem.root
        cost, r, along = _errors.of_magnitudes(problem, lit.magnitude)
        out = jacobian @ problem.u.T
        normal = jacobian @ jacobian.swapaxes(1, 2) - out @ out.swapaxes(1, 2)
        gradient = (jacobian @ r[..., None] - out @ along[..., None])[..., 0]
        return Near(states, cost, normal, gradient)

    def _refined(
        self, problem: CurveProblem, starts: States, iterations: int, *, is_last: bool = False
    ) -> States:
        """States of least cost near others; the budget ends all but the last one."""
        best = least_squares.minimum(
            least_squares.Problem(lambda states: self._near(problem, states), self._moved),
            np.concatenate([starts.wxyz, starts.omega], axis=1),
            _RULE,
            iterations + 1,
            lambda: problem.tally.is_over and not is_last,
        )
        return States(best.states[:, :4], best.states[:, 4:], best.cost)

    def _moved(self, states: FloatArray, steps: FloatArray) -> tuple[FloatArray, BoolArray]:
        """States (M, 7) after steps (M, 6), whose length is limited; they have no bounds."""
        turn = np.linalg.norm(steps[:, :3], axis=1) / 0.4
        rate = np.linalg.norm(steps[:, 3:], axis=1) / (0.15 * self.most)
        steps = steps / np.maximum(np.maximum(turn, rate), 1.0)[:, None]
        wxyz = quaternion.multiply(forms.from_rotation_vector(steps[:, :3]), states[:, :4])
        omega = states[:, 4:] + steps[:, 3:]
        return np.concatenate([wxyz, omega], axis=1), np.ones(len(states), bool)

    def _branched(self, problem: CurveProblem, states: States) -> States:
        """The states, with samples of the errors of the best of them."""
        best = states.rows(np.arange(min(_SAMPLED, len(states.cost))))
        fits = self._near(problem, np.concatenate([best.wxyz, best.omega], axis=1))
        parts = [states]
        for k in range(len(best.cost)):
            normal = Decomposed(fits.normal[k])
            spread = 2.0 / np.sqrt(np.maximum(normal.values, 1e-6))
            step = self.generator.standard_normal((_SAMPLES, 6)) * spread @ normal.vectors.T
            step /= normal.scale
            longest = np.maximum(np.linalg.norm(step[:, :3], axis=1) / 0.5, 1.0)
            step /= longest[:, None]
            wxyz = quaternion.multiply(forms.from_rotation_vector(step[:, :3]), best.wxyz[k])
            parts.append(States(wxyz, best.omega[k] + step[:, 3:], np.zeros(_SAMPLES)))
        return _joined(*parts)

    def _keep(self, count: int) -> None:
        """Keep the best distinct states."""
        states = self.states
        order = np.argsort(states.cost, kind="stable")
        order = order[np.linalg.norm(states.omega[order], axis=1) < 1.2 * self.most]
        chosen: list[int] = []
        span = self.problem.span
        for k in order:
            if chosen:
                rates = np.linalg.norm(states.omega[chosen] - states.omega[k], axis=1)
                same = np.abs(states.wxyz[chosen] @ states.wxyz[k]) > math.cos(0.5 * _SAME)
                if np.any(same & (rates * span < 5.0 * _SAME)):
                    continue
            chosen.append(int(k))
            if len(chosen) == count:
                break
        self.states = states.rows(np.array(chosen))


def _first_span(seconds: FloatArray, most: float, attempt: int) -> tuple[float, float]:
    """Middle and half the length of the first span: near the median epoch, later elsewhere."""
    ordered = np.sort(seconds)
    passes = _passes(ordered, most)
    passes.sort(key=len, reverse=True)
    ordered, attempt = passes[attempt % len(passes)], attempt // len(passes)
    wanted = (0.5, 0.25, 0.75, 0.38, 0.62, 0.12, 0.88)[attempt % 7]
    count = min(_FIRST_POINTS + 4 * (attempt // 7), len(ordered))
    first = int(wanted * (len(ordered) - count))
    turns = 2.0 * math.pi * _FIRST_TURNS / most
    low, high = float(ordered[first]), float(ordered[first + count - 1])
    return 0.5 * (low + high), 0.5 * max(high - low, turns) * 1.0001


def _passes(ordered: FloatArray, most: float) -> list[FloatArray]:
    """The epochs of each pass, of those that have enough for a first span."""
    steps = np.diff(ordered)
    longest = max(_GAP_TURNS * 2.0 * math.pi / most, _GAP_STEPS * float(np.median(steps)))
    passes = np.split(ordered, np.flatnonzero(steps > longest) + 1)
    enough = [one for one in passes if len(one) >= _FIRST_POINTS]
    return enough or [ordered]


def _joined(*groups: States) -> States:
    return States(*(np.concatenate(columns) for columns in zip(*groups, strict=True)))


# ---- Ranked spin states of a body of known shape: a search, and least squares from its best states

# Rates and momenta closer than this, relative, are one.
_SAME_RATES = 0.01
# Turn, rad, within which two minima are in one lobe of the density.
_LOBE_TURN = 0.3
# Difference of their rates, over the rate, within which they are.
_LOBE_RATE = 0.1
# Of the random views by which symmetry about an axis is recognized.
_SEED = 36
# The number of views.
_VIEWS = 200
# Turns, rad, of a body that looks alike after each if it is symmetric.
_ANGLES = (0.7, 1.9)
# Share of the errors by which magnitudes of such a body differ at most.
_UNSEEN = 0.4
# Share of the largest moment by which two moments of such a body differ at most.
_ROUND = 1e-3
# Relative difference of momenta of such a body that are one.
_SAME_ROUND = 0.02
# Angle, rad, between directions of the axis of symmetry that are one.
_SAME_AXIS = 0.1


def body_of(mesh: Mesh, moments: Any) -> Body:
    """The body of a mesh: homogeneous, a Body that is given, or three moments about its axes."""
    if isinstance(moments, Body):
        return moments
    if isinstance(moments, str) and moments == "shape":
        return Body.from_shape(mesh, density=1.0)
    if isinstance(moments, str) or np.ndim(moments) != 1:
        raise AttitudeError(
            f'moments is {moments!r}; with a known shape give "shape" (homogeneous), three moments '
            "about its axes, or a Body."
        )
    return Body(moments=moments, relative=True)


def found(
    curve: LightCurve,
    most: float,
    mesh: Mesh,
    law: str | Law | None,
    moments: Any,
    *,
    seconds: float,
    seed: int,
    settings: Settings,
    progress: Callable[[str], object],
) -> SpinStates[Refinement]:
    """Ranked states and the verdict; see `spin_states`."""
    body = body_of(mesh, moments)
    axes = body.principal_axes
    known = _shapes.known(mesh, law).over(axes)
    zero_points = curve.zero_points
    problem, averaged = _problem.problem(
        curve,
        most,
        settings.ellipsoid_error,
        zero_points,
        is_known=True,
        settings=settings,
        tally=Tally(seconds),
    )
    search = PassSearch(
        problem,
        known,
        body.moments,
        2.0 * math.pi * most,
        validation.generator(seed),
        progress,
    )
    search.run()
    costs = search.states.cost[: settings.known_fitted]
    fits = _evidence.ranked(
        _fitted(curve, problem, known, body, search, k)
        for k in np.flatnonzero(costs < costs[0] + settings.known_behind).tolist()
    )
    symmetry = symmetry_of(known, body.moments, float(np.median(problem.sigma)))
    kept: list[_Fitted] = []
    turned = 0
    for fit in fits:
        if any(_is_same(fit, other) for other in kept):
            continue
        if any(_looks_same(fit, other, symmetry) for other in kept):
            turned += 1
        else:
            kept.append(fit)
    solutions = [
        Refinement(
            curve,
            fit.weighted,
            problem,
            fit.fit,
            body,
            rank=rank,
            relation=_relation(fit, kept[0]),
            rivals=_rivals(fit, fits),
        )
        for rank, fit in enumerate(kept)
    ]
    verdict, criterion = _verdict(kept, problem)
    criterion += _verdicts.ended_by(verdict, problem.tally)
    if turned:
        criterion += (
            f" {_verdicts.with_verb(turned, 'other state', 'differ')} from these only by a turn "
            "about the axis of symmetry of the shape, which brightness does not show."
        )
    return SpinStates(solutions, verdict, criterion, (*curve.notes, *averaged))


class _Fitted(NamedTuple):
    """What the least squares from a state of the search give, and what was fitted."""

    weighted: Weighted[MovingState]
    fit: MovingFit

    @property
    def evidence(self) -> float:
        return self.weighted.evidence

    @property
    def point(self) -> MovingPoint:
        return self.weighted.refined.state.point


def _fitted(curve, problem, known, body, search, k):
    """The least squares from a state of the search."""
    epoch = curve.epoch.after(search.origin)
    spin = Spin(epoch, search.states.wxyz[k], search.states.omega[k])
    body_alone = Body(moments=body.moments, relative=body.relative, mass=body.mass)
    ends = float(curve.emission[0]), float(curve.emission[-1])
    point = _moving.moving_point(FreeRotation(body_alone, spin), curve.epoch, ends, None, None)
    fit = _moving.moving_fit(curve.epoch, problem, point, known, Tie())
    return _Fitted(fit.weighted(problem, _moving.MovingState(point, np.zeros(0))), fit)


def _vectors(solution: _Fitted) -> tuple[FloatArray, FloatArray]:
    """Momentum, over axes in space, and rates over body axes."""
    point = solution.point
    momentum = FreeRotation(point.body, point.spin).momentum / np.max(point.body.moments)
    return momentum, point.spin.angular_velocity


def _is_same(one: _Fitted, other: _Fitted) -> bool:
    (a, v), (b, w) = _vectors(one), _vectors(other)
    size = float(np.linalg.norm(w))
    turn = abs(float(one.point.spin.wxyz_icrf @ other.point.spin.wxyz_icrf))
    return bool(
        np.linalg.norm(a - b) < _SAME_RATES * size
        and np.linalg.norm(v - w) < _SAME_RATES * size
        and turn > math.cos(0.05)
    )


class Symmetry(NamedTuple):
    """The principal axis (0 to 2) about which a body looks and moves alike, or None.

    can_turn_over: whether it looks alike with the axis reversed.
    """

    axis: int | None
    can_turn_over: bool


def symmetry_of(known: KnownShape, moments: FloatArray, sigma: float) -> Symmetry:
    """The symmetry of a shape over principal axes, to a share of errors of sigma, mag.

    By magnitudes from random directions: a wheel of many facets counts as round, one of few
    does not.
    """
    sun, observer = np.random.default_rng(_SEED).standard_normal((2, _VIEWS, 3))
    sun /= np.linalg.norm(sun, axis=1)[:, None]
    observer /= np.linalg.norm(observer, axis=1)[:, None]
    least = known.floor(sun, observer)
    computed = known.magnitudes(sun, observer, least)

    def is_alike(turn: FloatArray) -> bool:
        seen = known.magnitudes(sun @ turn.T, observer @ turn.T, least)
        # a median: where little of a body is lit, its facets show
        return bool(np.median(np.abs(seen - computed)) < _UNSEEN * sigma)

    for axis in range(3):
        one, two = (axis + 1) % 3, (axis + 2) % 3
        if abs(moments[one] - moments[two]) > _ROUND * float(np.max(moments)):
            continue
        unit = np.eye(3)
        turns = [_turn(angle * unit[axis]) for angle in _ANGLES]
        if all(is_alike(turn) for turn in turns):
            return Symmetry(axis, is_alike(_turn(math.pi * unit[one])))
    return Symmetry(None, False)


def _turn(vector: FloatArray) -> FloatArray:
    """The matrix of a rotation vector (3,), rad."""
    return quaternion.matrix(forms.from_rotation_vector(vector))


def _looks_same(one: _Fitted, other: _Fitted, symmetry: Symmetry) -> bool:
    """Whether two states differ by a turn about an axis of symmetry alone."""
    if symmetry.axis is None:
        return False
    (a, _), (b, _) = _vectors(one), _vectors(other)
    size = float(np.linalg.norm(a))
    axes = [
        quaternion.matrix(one_of_both.point.spin.wxyz_icrf)[:, symmetry.axis]
        for one_of_both in (one, other)
    ]
    cosine = float(axes[0] @ axes[1])
    agreement = abs(cosine) if symmetry.can_turn_over else cosine
    return bool(np.linalg.norm(a - b) < _SAME_ROUND * size and agreement > math.cos(_SAME_AXIS))


def _rivals(
    solution: _Fitted, solutions: Sequence[_Fitted]
) -> tuple[tuple[FloatArray, float], ...]:
    """Offsets of the other minima in the lobe of one, and how far their evidence is behind."""
    rate = float(np.linalg.norm(solution.point.spin.angular_velocity))
    rivals = []
    for other in solutions:
        offset = other.point.difference(solution.point)
        is_close = np.linalg.norm(offset[:3]) < _LOBE_TURN
        if other is not solution and is_close and np.linalg.norm(offset[3:6]) < _LOBE_RATE * rate:
            rivals.append((offset, other.evidence - solution.evidence))
    return tuple(rivals)


def _has_rates(one: _Fitted, other: _Fitted) -> bool:
    """Whether two states have the same momentum in space, and the same sizes of the rates."""
    (a, v), (b, w) = _vectors(one), _vectors(other)
    size = float(np.linalg.norm(w))
    is_close = np.linalg.norm(np.abs(v) - np.abs(w)) < 0.05 * size
    return bool(is_close and np.linalg.norm(a - b) < 0.05 * size)


def _relation(solution: _Fitted, best: _Fitted) -> str:
    if solution is best:
        return "best"
    if _has_rates(solution, best):
        return "same momentum, other attitude"
    a, b = _vectors(solution)[0], _vectors(best)[0]
    cosine = float(a @ b) / float(np.linalg.norm(a) * np.linalg.norm(b))
    pole = "same pole" if cosine > 0.97 else "antipode" if cosine < -0.97 else "other pole"
    same = abs(float(np.linalg.norm(a) / np.linalg.norm(b)) - 1.0) < 0.02
    return pole if same else f"other periods, {pole}"


def _verdict(solutions: Sequence[_Fitted], problem: CurveProblem) -> tuple[str, str]:
    """The verdict and its criterion in words."""
    if not solutions:
        return _verdicts.OPEN, "No solution was found."
    best, settings = solutions[0], problem.settings
    floor = _evidence.floor_ratio(best.weighted, problem)
    others = [other for other in solutions[1:] if not _has_rates(other, best)]
    gap = min((other.evidence - best.evidence for other in others), default=math.inf)
    nearest = "no other rates come near"
    if others:
        needed = f"({settings.competing:g} needed)"
        nearest = f"the next rates are {gap:.1f} behind in -2 ln(evidence) {needed}"
    words = f"{_verdicts.of_floor(floor, settings.known_floor, settings)}; {nearest}."
    if floor < settings.known_floor and gap > settings.competing:
        return _verdicts.SOLVED, words
    return _verdicts.OPEN, words
