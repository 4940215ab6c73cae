"""Poles all over the sky: of a rotation about one axis, and of tumbling with rates that are held.

For rotation about one axis convex bodies have more minima than ellipsoids, and with the errors of
the points more than with those of ellipsoids.  At each of many poles some bodies are fitted with
the pole held; from the most probable of these the pole is free.  The rate that a pole needs differs
from that of another one by the turn of the scene about each: the bisector of Sun and observer is
followed.

For tumbling, ellipsoids with both rates held are fitted at all poles, and from the best of them
free ones.  Mirror images of a solution, in the plane of the scene and in that of its pole, keep the
shape: the body is inverted through its centre, and turned half a turn about the plane's normal.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from attitude._support.arrays import distinct, in_turn
from attitude.inversion import _ellipsoid, _errors, _evidence, _refinement, _shapes
from attitude.inversion._ellipsoid import (
    OF_FLAT,
    OF_FRAME,
    OF_LOG_RHO,
    OF_NUTATION,
    OF_PHASE,
    OF_POLE,
    OF_PRECESSION,
    OF_X,
    SearchState,
)
from attitude.inversion._refinement import MOTION

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator, Sequence

    from attitude._support.annotations import BoolArray, FloatArray
    from attitude.inversion._ellipsoid import Held, Pool
    from attitude.inversion._evidence import Robust
    from attitude.inversion._lattices import Candidate
    from attitude.inversion._problem import CurveProblem
    from attitude.inversion._refinement import BodyFit, Evaluation, Refined
    from attitude.inversion._settings import Settings
    from attitude.inversion._shapes import Tie


# Turns about a pole of which the best is a start.
_TURNS = 6
# Steps of ellipsoids at held poles.
_STEPS = 12
# Iterations, and the relative gain at which they end, of held poles.
_HELD = (25, 1e-3)
# Those of free poles.
_FREE = (40, 3e-4)
# Steps of tumbling bodies at held poles, with few modes and then with all.
_BODY_STEPS = 4, 6
# The gain at which these end.
_BODY_GAIN = 1e-3
# What stays where the pole is held.
_POLE_HELD = np.arange(_refinement.SIZE) < 2
# Angle, rad, up to which other minima are errors of a pole.
_LOBE = math.radians(60.0)
# Angle, rad, between directions that are one pole of the map.
_ONE_POLE = 1e-4


def turn_of_scene(problem: CurveProblem, poles: FloatArray) -> FloatArray:
    """The mean rate (P,), turns per span, of the bisector of Sun and observer about poles (P, 3).

    The rate of a body about a pole, less this, is the rate at which the scene sees it turn.
    """
    t = problem.t - problem.t.mean()
    return np.unwrap(_seen_about(problem, poles)) @ t / (t @ t) / (2.0 * math.pi)


def has_turn(problem: CurveProblem, a: FloatArray, b: FloatArray) -> bool:
    """Whether the scene sees two rotations about one axis turn at the same rate.

    The rates about poles far from each other differ by twice the turn of the scene.  The angle
    between the two bodies, as the bisector of Sun and observer sees them, is followed by the rate
    that it keeps best, near zero or near the difference of the rates: its turns in the gaps between
    apparitions need not be known.
    """
    apart = a[OF_PRECESSION] - b[OF_PRECESSION]
    angles = 4.0 * math.pi * apart * problem.t
    first, second = _seen_about(problem, np.stack([a[OF_POLE], b[OF_POLE]]))
    angles -= first - second
    width = problem.settings.same_rate
    offsets = np.arange(-2.0 * width, 2.0 * width + 1e-9, width / 8.0)
    drifts = np.concatenate([offsets, 2.0 * apart + offsets])
    turned = np.exp(1j * (angles - 2.0 * math.pi * drifts[:, None] * problem.t))
    kept = np.abs(turned.mean(axis=1))
    return bool(abs(drifts[int(np.argmax(kept))]) < width)


def _seen_about(problem: CurveProblem, poles: FloatArray) -> FloatArray:
    """The angles (P, N) of the bisector of Sun and observer about poles (P, 3), rad."""
    bisector = problem.sun + problem.observer
    first = np.cross(poles, np.eye(3)[np.argmin(np.abs(poles), axis=1)])
    return np.arctan2(np.cross(poles, first) @ bisector, first @ bisector)


def _has_rates(problem: CurveProblem, a: FloatArray, b: FloatArray) -> bool:
    """Whether two tumbling states have the same nutation, and turn alike as the scene sees it."""
    apart = abs(a[OF_NUTATION] - b[OF_NUTATION])
    same = apart < problem.settings.same_rate
    return bool(same) and has_turn(problem, a, b)


def spread(
    state: FloatArray, evidence: float, others: Sequence[tuple[FloatArray, float]]
) -> FloatArray:
    """Second moments (8, 8) that other minima add to the covariance of a rotation about one
    axis.
    """
    fields = SearchState.of(state)
    offsets, weights = [np.zeros(MOTION)], [1.0]
    for other, behind in others:
        fields_of_other = SearchState.of(other)
        momentum = fields.frame.T @ other[OF_POLE]
        angle = math.acos(max(-1.0, min(1.0, float(momentum[2]))))
        if angle < _LOBE:
            offset = np.zeros(MOTION)
            across = math.hypot(momentum[0], momentum[1])
            if across > 0.0:
                offset[_refinement.TILT] = angle / across * np.array([-momentum[1], momentum[0]])
            offset[_refinement.PRECESSION] = fields_of_other.precession - fields.precession
            offsets.append(offset)
            weights.append(math.exp(-0.5 * (behind - evidence)))
    return _errors.about_first(offsets, weights)


def plane_of(problem: CurveProblem) -> FloatArray:
    """The normal (3,) of the plane in which Sun and observer lie, seen from the body."""
    directions = np.concatenate([problem.sun, problem.observer], axis=1)
    return np.linalg.eigh(directions @ directions.T)[1][:, 0]


def mirrored(pole: FloatArray, normal: FloatArray) -> FloatArray:
    """The pole (3,) of the mirror image of a rotating body in the plane of a normal (3,).

    Directions in that plane see both alike.  Angular momentum is an axial vector: its part along
    the plane changes sign, so that the longitude from the plane's axis changes by half a turn.
    """
    return 2.0 * (pole @ normal) * normal - pole


def images(problem: CurveProblem, state: FloatArray) -> list[FloatArray]:
    """Mirror images of a tumbling state: mirror pole, antipode, and antipode of the mirror pole.

    In the plane of the scene; in that of the pole and the middle of the scene; in both.
    """
    middle = (problem.sun + problem.observer).sum(axis=1)
    mirror = mirrored_state(problem, state, plane_of(problem))
    images_of = [mirror]
    for source_state in (state, mirror):
        normal = np.cross(middle, source_state[OF_POLE])
        size = float(np.linalg.norm(normal))
        if size > 1e-6 * float(np.linalg.norm(middle)):
            images_of.append(mirrored_state(problem, source_state, normal / size))
    return images_of


def mirrored_state(problem: CurveProblem, state: FloatArray, normal: FloatArray) -> FloatArray:
    """The mirror image of a state in the plane of a normal (3,), as bright from that plane.

    A reflection of the scene and the inversion of the body are a half turn about the normal.
    """
    fields = _ellipsoid.SearchState.of(state)
    half_turn = 2.0 * np.outer(normal, normal) - np.eye(3)
    frame = half_turn @ fields.frame
    turns = turn_of_scene(problem, np.stack([fields.pole, frame[:, 2]]))
    return fields._replace(
        frame=frame,
        precession=fields.precession + 0.5 * float(turns[1] - turns[0]),
        modes=_shapes.inverted(fields.modes),
    ).vector


def of_rates(
    problem: CurveProblem,
    generator: np.random.Generator,
    state: FloatArray,
    held: Held,
    tie: Tie,
    is_over: Callable[[], bool],
) -> list[FloatArray]:
    """States with the rates of a tumbling one at other poles, the best first.

    Convex bodies whose poles were held, since ellipsoids leave the pole of a body that is far from
    one, and ellipsoids with free poles, in turn.  With the error of bodies: with that of ellipsoids
    many poles of a curve fitted alike, and the true one was not among the best.
    """
    settings = problem.settings
    problem = problem.with_few_nodes().with_model_error(settings.body_error)
    count, starts = settings.map_poles, settings.map_starts
    at_poles = _at_poles(problem, generator, state, held, count, starts, has_x=True)
    free = _ellipsoid.minimised(problem, at_poles.states[: count // 2], 2 * _STEPS, tie=held)
    stages = tuple(zip((count, settings.map_refined), _BODY_STEPS, strict=True))
    bodies = _in_stages(problem, at_poles.states, tie, stages, _shapes.MODES, is_over)
    both = in_turn((body.state for body in bodies), _ellipsoid.in_order(free).states)
    return [candidate for candidate in both if _has_rates(problem, candidate, state)]


def _at_poles(
    problem: CurveProblem,
    generator: np.random.Generator,
    state: FloatArray,
    held: Held,
    count: int,
    starts_of_each: int,
    *,
    has_x: bool,
) -> Pool:
    """The best ellipsoid at each of `count` poles with the rates of a tumbling state, in order.

    `has_x`: with the X of the state too.
    """
    poles = _shapes.even_directions(count)
    turns = turn_of_scene(problem, np.concatenate([state[None, OF_POLE], poles]))
    size = starts_of_each * _TURNS
    starts = np.repeat(state[None, : _ellipsoid.WIDTH], count * size, axis=0)
    starts[:, OF_PRECESSION] += 0.5 * np.repeat(turns[1:] - turns[0], size)
    starts[:, OF_PHASE] = generator.random(len(starts))
    log_rho = starts[:, OF_LOG_RHO] + generator.normal(0.0, 0.3, len(starts))
    starts[:, OF_LOG_RHO] = np.clip(log_rho, -4.0, -0.1)
    starts[:, OF_FRAME] = _ellipsoid.frames_of(generator, np.repeat(poles, size, axis=0))
    starts[:, OF_FLAT] += generator.normal(0.0, 0.3, (len(starts), 2))
    if not has_x:
        starts[:, OF_X] = _ellipsoid.any_x(generator, starts[:, OF_NUTATION])
    chosen = _ellipsoid.screened(problem, starts, count * starts_of_each)
    fixed = np.zeros(_ellipsoid.PARAMETERS, bool)
    fixed[_refinement.TILT] = True
    fixed[[_refinement.PRECESSION, _refinement.NUTATION]] = True
    pool = _ellipsoid.minimised(problem, chosen, _STEPS, tie=held, fixed=fixed)
    return _ellipsoid.in_order(_ellipsoid.best_of_each(pool, count))


def with_lines(
    problem: CurveProblem, generator: np.random.Generator, rates: Sequence[Candidate]
) -> FloatArray:
    """Random states (R, 16) with rates that the scene sees: it does not turn about their poles."""
    pairs = np.array(rates).reshape(-1, 2)
    states = _ellipsoid.starts(generator, *pairs.T)
    across = np.cross(plane_of(problem), problem.sun.sum(axis=1) + problem.observer.sum(axis=1))
    poles = np.repeat(across[None] / np.linalg.norm(across), len(states), axis=0)
    states[:, OF_FRAME] = _ellipsoid.frames_of(generator, poles)
    return states


def in_few_steps(
    problem: CurveProblem,
    generator: np.random.Generator,
    state: FloatArray,
    held: Held,
    tie: Tie,
) -> list[BodyFit]:
    """Bodies of few modes at other poles with the rates of a tumbling state, the best first.

    In few steps, with the error of bodies in place of that of ellipsoids.
    """
    settings = problem.settings
    count, starts = settings.class_poles, settings.class_starts
    at_poles = _at_poles(problem, generator, state, held, count, starts, has_x=False)
    problem = problem.with_model_error(settings.body_error)
    stages, modes = settings.class_bodies, settings.short_modes
    return _in_stages(problem, at_poles.states, tie, stages, modes, lambda: False)


def minima(
    problem: CurveProblem,
    rough: CurveProblem,
    best: FloatArray,
    generator: np.random.Generator,
    tie: Tie,
    fixed: BoolArray,
    redundancy: float,
    is_over: Callable[[], bool],
) -> tuple[list[Refined], list[Refined]]:
    """Rotations about one axis at all poles that compete, the most probable first.

    Minima, whose pole is free, and the bodies of poles of the map that compete, which are held.

    Shapes: best (WIDTH,), fixed (SIZE,).  `redundancy` points count as one where poles compete.
    """
    settings, behind = problem.settings, problem.settings.axial_pole_behind * redundancy
    poles = _shapes.even_directions(settings.axial_poles)
    turns = turn_of_scene(rough, np.concatenate([best[None, OF_POLE], poles]))
    rates = 2.0 * SearchState.of(best).precession + turns[1:] - turns[0]
    starts = _ellipsoid.axial_at_poles(rough, generator, rates, poles, settings.axial_bodies)
    held = fixed.copy()
    held[_refinement.TILT] = True
    held_states = starts.states
    for iterations, above, most in settings.axial_stages:
        accuracy = (iterations, _HELD[1])
        evaluations = _refined(problem, held_states, tie, held, accuracy, is_over)
        fits = [evaluation.fitted for evaluation in evaluations]
        fits.sort(key=lambda fit: fit.cost)
        fits = [fit for fit in fits if fit.cost < fits[0].cost + above]
        best_ones = [fit.state for fit in fits[:most]]
        of_others = apart(fits[most:], best_ones, settings, _ONE_POLE)
        held_states = np.array([*best_ones, *(fit.state for fit in of_others)])
    at_poles = _refined(problem, held_states, tie, held, _HELD, is_over)
    chosen = most_probable((one.linearised for one in at_poles), problem, behind)
    states = np.array([fit.state for fit in chosen[: settings.axial_freed]])
    with_pole = _refined(problem, states, tie, fixed, _FREE, is_over)
    free = most_probable((one.linearised for one in with_pole), problem, behind)
    return free, chosen


def apart(
    fits: Sequence[BodyFit],
    others: Sequence[FloatArray],
    settings: Settings,
    width: float | None = None,
) -> list[BodyFit]:
    """Those whose pole no better one has, nor one of others (WIDTH,), within an angle, rad.

    By default that of entries of a list.
    """

    def is_entry(a: FloatArray, b: FloatArray) -> bool:
        return _is_entry(a, b, settings, width)

    new = (fit for fit in fits if not any(is_entry(fit.state, state) for state in others))
    return distinct(new, lambda a, b: is_entry(a.state, b.state))


def _in_stages(
    problem: CurveProblem,
    states: FloatArray,
    tie: Tie,
    stages: Sequence[tuple[int, int]],
    modes: int,
    is_over: Callable[[], bool],
) -> list[BodyFit]:
    """Tumbling bodies at the poles of states, the best first.

    In stages: of the best so many bodies take so many steps, in the last stage with all `modes`.
    """
    bodies: list[BodyFit] = []
    for number, (most, iterations) in enumerate(stages, 1):
        of_shape = modes if number == len(stages) else problem.settings.short_modes
        evaluations = _refined(
            problem, states[:most], tie, _POLE_HELD, (iterations, _BODY_GAIN), is_over, of_shape
        )
        of_stage = sorted((one.fitted for one in evaluations), key=lambda body: body.cost)
        # a budget that ended before a stage leaves the bodies of the last one
        bodies = of_stage or bodies
        states = np.array([body.state for body in bodies])
    return bodies


def _refined(
    problem: CurveProblem,
    states: FloatArray,
    tie: Tie,
    fixed: BoolArray,
    accuracy: tuple[int, float],
    is_over: Callable[[], bool],
    modes: int = _shapes.MODES,
) -> Iterator[Evaluation[FloatArray]]:
    iterations, gain = accuracy
    for state in states:
        if is_over():
            return
        yield _refinement.refine(
            problem, state, tie=tie, fixed=fixed, iterations=iterations, gain=gain, modes=modes
        )


class _Rated(NamedTuple):
    """A fit with its evidence."""

    evidence: float
    fit: Refined


def most_probable(fits: Iterable[Refined], problem: CurveProblem, behind: float) -> list[Refined]:
    """Those of rotations about one axis that compete, the best first."""
    points = len(problem)
    rated = _evidence.ranked(_Rated(_evidence.of_fit(fit, points), fit) for fit in fits)
    return [one.fit for one in rated if one.evidence < rated[0].evidence + behind]


def listed(
    solutions: Sequence[Robust], behind: float, settings: Settings
) -> tuple[list[Robust], list[Robust]]:
    """Poles of each rate that compete, the best first, 15 degrees apart, and those left out.

    A list of neighbours would leave no place for other parts of the sky: their differences are
    errors of one pole.
    """
    entries: list[Robust] = []
    beside: list[Robust] = []
    for entry in _evidence.ranked(solutions):
        if entries and entry.evidence > entries[0].evidence + behind:
            break
        is_near = any(
            _is_entry(entry.refined.state, other.refined.state, settings) for other in entries
        )
        (beside if is_near else entries).append(entry)
    return entries, beside


def _is_entry(a: FloatArray, b: FloatArray, settings: Settings, width: float | None = None) -> bool:
    has_rate = bool(2.0 * abs(a[OF_PRECESSION] - b[OF_PRECESSION]) < settings.same_rate)
    return has_rate and _ellipsoid.have_pole(a, b, settings.axial_entry if width is None else width)
