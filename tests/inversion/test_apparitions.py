"""Rotation about one axis over several apparitions: linear fits of many rates, and the search."""

import itertools
import math
import re
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from attitude import AttitudeError, Body, FreeRotation, Spin, inversion
from attitude._support.least_squares import inverse
from attitude.frames import matrix_to_icrf, quaternion
from attitude.inversion import (
    _apparitions,
    _ellipsoid,
    _joined,
    _motions,
    _moving,
    _neighbours,
    _pole_map,
    _problem,
    _refinement,
    _shapes,
    _verdicts,
)
from attitude.inversion._ellipsoid import SearchState
from attitude.inversion._errors import GroupErrors
from attitude.inversion._problem import CurveProblem
from attitude.inversion._solution import Solution
from attitude.torques import ConstantTorque
from tests.support import apparition_curves


@pytest.fixture(scope="module")
def known():
    """A curve of 25 years of relative nights and a survey, its period (h) and its pole."""
    return apparition_curves.rotator(100)


@pytest.fixture(scope="module")
def problem(known):
    curve = known[0]
    return _problem.problem(curve, 12.0 / 86400.0, 0.07, curve.zero_points)[0]


@pytest.mark.parametrize("is_one_night", [False, True])
def test_sums_of_cells_are_those_of_the_points(problem, is_one_night):
    """Gains of rates against least squares with all linear terms projected out.

    One night has a zero point and slopes with the phase angle, all of its one cell, copies but for
    1e-4.
    """
    if is_one_night:
        first = int(np.argmax(np.sum(problem.terms != 0.0, axis=1) > 1))
        problem = problem.part(np.abs(problem.t - problem.t[first]) * problem.span < 20_000.0)
    combs = _apparitions.Combs(problem)
    assert (len(combs.centre) == 1) == is_one_night
    error = 1e-3 if is_one_night else 1e-6
    assert combs.total == pytest.approx(problem.chi_squared(np.zeros(len(problem))), rel=error)
    columns = _apparitions.harmonics_about(problem, _shapes.even_directions(100)[37])
    rates = 20000.0 + np.array([0.0, 0.4, 3.0])
    [(_, gain, _)] = combs.gains([columns], rates)
    exact = [next(combs.gains([columns], rates[k : k + 1])) for k in range(3)]
    y = problem.y * problem.root
    turning = columns.turns > 0
    for k, rate in enumerate(rates):
        z = columns.values * np.exp(-2j * np.pi * rate * problem.t * columns.turns[:, None])
        rows = np.concatenate([z.real, z.imag[turning]]) * problem.root
        left = rows - (rows @ problem.u.T) @ problem.u
        widths = np.concatenate([columns.widths, columns.widths[turning]])
        x = np.linalg.solve(left @ rows.T + np.diag(widths**-2.0), left @ y)
        # of several rates, a cell has the phase within it of the middle one: in a night of 7 h 1.5
        # turns of 9000 d are 2e-4 rad, fourfold in the last harmonic
        assert gain[0, k] == pytest.approx(x @ (left @ y), rel=1e-3)
        assert exact[k][1][0, 0] == pytest.approx(x @ (left @ y), rel=error)
        assert exact[k][2][0, 0] == pytest.approx(x, abs=error)
        assert exact[k][1][0, 0] < combs.total


def test_a_curve_falls_into_its_apparitions(problem, known):
    found = _neighbours.apparitions_of(problem.seconds)
    assert sum(map(len, found)) == len(problem)
    order = np.argsort([problem.t[each].min() for each in found])
    ends = [(problem.t[found[k]].min(), problem.t[found[k]].max()) for k in order]
    gaps = [(b[0] - a[1]) * problem.span / 86400.0 for a, b in itertools.pairwise(ends)]
    assert min(gaps) > 60.0


def test_windows_of_one_apparition_are_all_tried(known):
    """126 days with 96 points, whose true rate is the 28th of hundreds of windows."""
    curve, period, _ = known
    part = curve[curve.seconds < curve.seconds.min() + 127.0 * 86400.0]
    problem, _ = _problem.problem(part, 12.0 / 86400.0, 0.07, part.zero_points)
    chosen = _apparitions.windows(problem, 0.7, 12.0 / 86400.0 * problem.span)
    rate = problem.span / 3600.0 / period
    assert any(low < rate < high for low, high in chosen.bounds)
    assert len(chosen.bounds) > 100 and not chosen.are_limited
    ends = np.sort(chosen.bounds, axis=0)
    assert np.all(ends[1:, 0] >= ends[:-1, 1] - 1e-9)


def test_windows_are_tried_until_the_budget_ends(known):
    """Blind above 2 h: more windows fit than are tried, and the best is not far ahead."""
    found = inversion.spin_states(known[0], "12 /d", modes=("PA",), budget=4)
    assert found.verdict == "not solved" and "larger budget" in found.notes[-2]
    words = re.search(
        r"(\d+) windows of periods fit .*, of which (\d+) were tried", found.notes[-2]
    )
    assert 6 <= int(words[2]) < int(words[1])


@pytest.mark.parametrize(
    ("is_at_floor", "ahead", "expected"),
    [(True, 130.0, True), (True, 110.0, False), (False, 130.0, False)],
)
def test_far_ahead_within_the_errors_is_claimed_before_all_are_tried(
    monkeypatch, problem, is_at_floor, ahead, expected
):
    search = object.__new__(_apparitions.RotatorSearch)
    search.problem, search.solutions = problem, [None]
    monkeypatch.setattr(_apparitions.RotatorSearch, "is_at_floor", is_at_floor)
    monkeypatch.setattr(_verdicts, "gap", lambda solutions, problem: ahead)
    assert search._stands_alone == expected
    search.solutions = []
    assert not search._stands_alone


@pytest.mark.slow
def test_all_windows_of_25_years_are_tried():
    """Twenty of them, in a quarter of the budget."""
    curve, period, pole = apparition_curves.rotator(103)
    found = inversion.spin_states(curve, "12 /d", modes=("PA",))
    right, own, _ = apparition_curves.judged(found, curve, period, pole)
    assert found.verdict == "solved" and right and own < 10.0
    assert not any("were tried" in note for note in found.notes)


def test_a_noisy_survey_without_errors(known):
    """Of the survey 0.15 mag, where 0.02 are assumed for all: its scatter is no misfit."""
    curve, period, pole = known
    noisy = curve.session == curve.sessions.index("survey")
    noise = np.where(noisy, 0.15 * np.random.default_rng(7).normal(size=len(curve)), 0.0)
    blank = curve.replaced(magnitude=curve.magnitude + noise, sigma=np.zeros(len(curve)))
    found = inversion.spin_states(blank, period=f"{period} h", budget=900)
    right, own, _ = apparition_curves.judged(found, curve, period, pole)
    assert found.verdict in ("solved", "periods only") and right and own < 10.0
    assert any("points far apart in time of 1 session are up to" in note for note in found.notes)
    assert "best: period" in str(found) and "+-" in str(found)


def test_period_and_pole_of_25_years(known):
    """The number of turns, among those of 2 % of the period, and the pole to 10 degrees."""
    curve, period, pole = known
    found = inversion.spin_states(curve, period=f"{period * 1.003} h", budget=900)
    right, own, _ = apparition_curves.judged(found, curve, period, pole)
    assert found.verdict == "solved" and found[0].mode == "PA"
    assert right and own < 10.0
    assert abs(found[0].P_phi / 3600.0 - period) < 4.0 * found[0].periods_sigma[1] / 3600.0
    assert found[0].rms < 0.035


def test_a_budget_ends_a_search_of_millions_of_turns(known):
    """25 years at a turn in two seconds: 400 million turns."""
    curve = known[0]
    found = inversion.spin_states(curve, "0.5 Hz", modes=("PA",), budget=0.1)
    assert len(found) == 0 and found.verdict == "not solved"
    assert "budget of 0.1 s ended the search" in found.criterion


def test_refine_keeps_a_rotation_about_one_axis(known):
    """One apparition, from the truth with a wrong shape: rates across the axis stay zero."""
    curve, period, pole = known
    whole = _problem.problem(curve, 12.0 / 86400.0, 0.07, curve.zero_points)[0]
    part = curve[max(_neighbours.apparitions_of(whole.seconds), key=len)]
    wxyz = _turned_to(matrix_to_icrf("ecliptic") @ pole)
    rates = [0.0, 0.0, 2.0 * math.pi / (3600.0 * period)]
    start = FreeRotation(
        Body(moments=[0.6, 0.9, 1.0], relative=True), Spin(part.epoch, wxyz, rates)
    )
    problem = _problem.problem(part, 12.0 / 86400.0, 0.07, part.zero_points)[0]
    point = _moving.moving_point(start, part.epoch, (-1e8, 1e8), None, ConstantTorque((0, 0, 0)))
    fit = _moving.moving_fit(part.epoch, problem, point, None, _shapes.Tie())
    assert fit.fixed[:11].tolist() == [k in (3, 4, 6, 7, 8, 9) for k in range(11)]
    free = _moving.moving_point(start, part.epoch, (-1e8, 1e8), None, None)
    fit = _moving.moving_fit(part.epoch, problem, free, None, _shapes.Tie())
    found = fit.minimum(problem, _moving.MovingState(free, np.zeros(_shapes.SIZE)), 3)
    assert found.fitted.cost < math.inf and fit.is_axial
    assert np.all(found.fitted.state.point.spin.angular_velocity[:2] == 0.0)
    assert found.fitted.state.point.axis == 2


def _turned_to(pole):
    """The attitude whose z axis is a direction (3,)."""
    first = np.cross(pole, np.eye(3)[np.argmin(np.abs(pole))])
    first = first / np.linalg.norm(first)
    return quaternion.from_matrix(np.stack([first, np.cross(pole, first), pole], axis=-1))


def test_two_rotations_are_compared_across_gaps(problem):
    """By the angle between the bodies as the scene sees them, not by turns in the gaps."""
    state = np.zeros(16)
    state[0], state[5:14] = 1e4, np.eye(3).ravel()
    other = state.copy()
    other[0] += 0.1
    assert _pole_map.has_turn(problem, state, other)
    other[0] += 0.3
    assert not _pole_map.has_turn(problem, state, other)
    tilted, angle = state.copy(), math.radians(20.0)
    c, s = math.cos(angle), math.sin(angle)
    tilted[5:14] = np.array([[1, 0, 0], [0, c, -s], [0, s, c]]).ravel()
    assert _pole_map.has_turn(problem, state, tilted)
    assert SearchState.of(tilted).pole[2] == pytest.approx(c)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({}, "max_frequency is missing"),
        ({"period": ("3 h", "2 h")}, "give the shorter one first"),
        ({"period": ("2 h", "3 h", "4 h")}, "period has 3 entries"),
        ({"period": "3 h", "modes": ("LAM",)}, "rotation about one axis"),
        ({"period": "3 h", "max_frequency": "1 /d"}, "no period from"),
        ({"max_frequency": "3 /d", "modes": ("PA", "LAM")}, 'leave "PA" out'),
        ({"max_frequency": "12 /d"}, 'modes=("PA",)'),
    ],
)
def test_arguments_that_no_search_has(known, options, words):
    with pytest.raises(AttitudeError) as caught:
        inversion.spin_states(known[0], **options)
    assert words in str(caught.value)


# ---- Tumbling over two apparitions


@pytest.fixture(scope="module")
def tumbling():
    """A problem of two apparitions, with the state that made it, at the middle of the span."""
    rng = np.random.default_rng(7)
    t = np.sort(np.concatenate([rng.uniform(-0.5, -0.46, 140), rng.uniform(0.44, 0.5, 160)]))
    angle = 9.0 * t
    sun = np.stack([np.cos(angle), np.sin(angle), 0.1 * np.sin(3.0 * angle)])
    observer = np.stack([np.cos(angle + 0.6), np.sin(angle + 0.6), 0.3 * np.cos(2.0 * angle)])
    sun, observer = sun / np.linalg.norm(sun, axis=0), observer / np.linalg.norm(observer, axis=0)
    state = np.zeros(_refinement.WIDTH)
    state[:5] = 1280.137, -251.718, 0.2, math.log(0.3), 0.4
    state[5:14] = _ellipsoid.rotations(rng, 1)[0]
    state[14:16] = 1.3, 0.7
    state[16:] = rng.normal(0.0, 0.1, _refinement.WIDTH - 16)
    terms = np.ones((len(t), 1)), np.full(1, np.inf)
    given = t, 2.6e8, sun, observer
    sigma = np.full(len(t), 0.02)
    blank = CurveProblem(*given, np.zeros(len(t)), sigma, *terms, 0.0)
    exact = _refinement.model(blank, state).magnitude
    noisy = exact + sigma * rng.normal(size=len(t))
    return CurveProblem(*given, noisy, sigma, *terms, 0.01), state


def _alone(problem, state, inside):
    """An apparition whose one solution is a fit to its points alone."""
    part = problem.part(inside)
    middle = 0.5 * float(part.t.min() + part.t.max())
    about = CurveProblem(
        part.t - middle, part.span, part.sun, part.observer, part.magnitude, part.sigma,
        part.terms, part.prior, part.model_error,
    )  # fmt: skip
    start = _joined.at_middle(state, -middle)[: _refinement.WIDTH]
    # to the minimum itself: the counts that compete depend on where an iteration stops
    fit = _refinement.refine(
        about, start, tie=_shapes.Tie(math.inf), iterations=80, gain=1e-9
    ).linearised
    covariance = np.pad(4.0 * inverse(fit.normal)[:8, :8], (0, 2))
    drift = np.zeros(len(state) - _refinement.WIDTH)
    covariance[range(8, 8 + len(drift)), range(8, 8 + len(drift))] = _refinement.DRIFT_WIDTH**2
    found = _joined.Alone(np.append(fit.state, drift), covariance, 0.0, middle)
    return _joined.Apparition(float(part.t.min()), float(part.t.max()), [found])


@pytest.mark.parametrize("drift", [[], [3.0, -4.0]])
def test_a_state_is_carried_to_the_middle_and_back(tumbling, drift):
    problem, state = tumbling
    state = np.append(state, drift)
    there = _joined.at_middle(state, 0.37)
    back = _joined.at_middle(there, -0.37)
    a, b = (_refinement.model(problem, each).magnitude for each in (state, back))
    assert a == pytest.approx(b, abs=1e-8)
    # what is at 0.37 of there is at 0 of the state: epochs moved by that
    moved = replace(problem, t=problem.t + 0.37)
    assert _refinement.model(problem, there).magnitude != pytest.approx(a, abs=1e-3)
    assert _refinement.model(moved, there).magnitude == pytest.approx(a, abs=1e-8)


def test_slopes_by_the_drift_are_differences(tumbling):
    problem, state = tumbling
    state = np.append(state, [3.0, -4.0])
    slopes = _refinement.model(problem, state).jacobian[-2:]
    for number, slope in enumerate(slopes):
        step = np.zeros(len(state))
        step[_refinement.WIDTH + number] = 1e-6
        ends = [_refinement.model(problem, state + sign * step).magnitude for sign in (1, -1)]
        assert slope == pytest.approx((ends[0] - ends[1]) / 2e-6, abs=1e-5)


def test_a_drift_of_the_rates_is_found_with_their_numbers_of_turns(tumbling):
    free, state = tumbling
    state = np.append(state, [3.0, -4.0])
    noise = free.magnitude - _refinement.model(free, state[: _refinement.WIDTH]).magnitude
    problem = replace(free, magnitude=_refinement.model(free, state).magnitude + noise)
    apparitions = [_alone(problem, state, side) for side in (problem.t < 0.0, problem.t > 0.0)]
    search = _joined.JoinedSearch(
        problem, 4000.0, ("LAM", "SAM"), _shapes.Tie(math.inf), (), np.random.default_rng(0),
        lambda _: None, alone=lambda: apparitions,
    )  # fmt: skip
    search.run()
    best = search.solutions[0].refined
    assert best.state[:2] == pytest.approx(state[:2], abs=0.1)
    errors = np.sqrt(np.diag(inverse(best.normal))[-2:])
    assert np.all(errors < 0.3)
    assert np.all(np.abs(best.state[_refinement.WIDTH :] - [3.0, -4.0]) < 3.0 * errors)


@pytest.mark.parametrize("nutation", [251.0, -251.0])
def test_a_drift_is_that_of_the_frequencies(tumbling, nutation):
    """In both modes: the change of 1/P_phi and 1/P_psi in half the span, and errors to scale."""
    _, state = tumbling
    state = np.append(state, [3.0, -4.0])
    state[1] = nutation
    curve = SimpleNamespace(span=1e7)
    normal = np.diag(np.full(_refinement.SIZE + 2, 4.0))
    refined = SimpleNamespace(state=state, normal=normal)
    solution = Solution(curve, SimpleNamespace(refined=refined, evidence=0.0), None, None, 0)
    later = SearchState.of(_joined.at_middle(state, -0.5)).rates
    change = (np.array(later) - SearchState.of(state).rates) / (0.5 * curve.span**2)
    assert solution.drift == pytest.approx(change, rel=1e-9)
    # rates whose errors are three times those of the curvature, 1/2
    errors = GroupErrors(np.eye(8), np.diag(np.full(8, 9.0 / 4.0)), np.eye(8))
    solution.__dict__["_covariances"] = (np.eye(9), errors)
    by_mode = [math.sqrt(5.0) if nutation > 0.0 else 2.0, 1.0]
    assert solution.drift_sigma * curve.span**2 == pytest.approx(1.5 * np.array(by_mode))


def test_a_drift_is_refused_where_it_is_not_searched(known):
    with pytest.raises(AttitudeError, match="drift is for a body of unknown shape that tum"):
        inversion.spin_states(known[0], period="5 h", drift=True)


def test_the_true_numbers_of_turns_are_listed_and_best(tumbling):
    problem, state = tumbling
    early, late = (_alone(problem, state, side) for side in (problem.t < 0.0, problem.t > 0.0))
    # four errors of what one apparition says of the rates leave a turn open
    between = late.solutions[0].middle - early.solutions[0].middle
    errors = [np.sqrt(np.diag(one.solutions[0].covariance))[[3, 4]] for one in (early, late)]
    assert 4.0 * max(each.max() for each in errors) * between > 1.0
    listed = _joined.counts(early.solutions[0], late.solutions[0], 45.0)
    numbers = {
        (round(one.state[0] * between, 1), round(one.state[1] * between, 1)) for one in listed
    }
    assert len(numbers) == len(listed) > 2
    made = _joined.JoinedSearch(
        problem, 4000.0, ("LAM", "SAM"), _shapes.Tie(math.inf), (), np.random.default_rng(0),
        lambda _: None, alone=lambda: [early, late],
    )  # fmt: skip
    made.run()
    best = made.solutions[0].refined.state
    assert best[:2] == pytest.approx(state[:2], abs=0.05)
    assert len(made.solutions) > 2
    assert made.solutions[1].evidence > made.solutions[0].evidence
    word = _verdicts.relation(made.solutions[1].refined.state, best, problem, made.length)
    assert "turns of phi" in word and "between the apparitions" in word


@pytest.mark.parametrize("quarters", [1, 2, 3])
def test_axes_of_the_body_may_change_places(tumbling, quarters):
    """One apparition does not tell which axis is the first: the shape turns with them."""
    problem, state = tumbling
    late = _alone(problem, state, problem.t > 0.0).solutions[0]
    early = _alone(problem, state, problem.t < 0.0).solutions[0]
    sign = (-1.0) ** quarters
    turn = Rotation.from_euler("z", 90.0 * quarters, degrees=True).as_matrix()
    turned = early.state.copy()
    turned[2] += 0.25 * quarters
    turned[4] *= sign
    turned[5:14] = (turned[5:14].reshape(3, 3) @ turn).ravel()
    # the same body: its axes are turned by as much
    epochs = np.linspace(-0.5, 0.5, 7)
    before, after = (
        (each[5:14].reshape(3, 3) @ _motions.at_epochs(each, epochs).matrix.reshape(3, -1))
        .reshape(3, 3, -1).transpose(2, 0, 1)
        for each in (early.state, turned)
    )  # fmt: skip
    assert after == pytest.approx(before @ turn, abs=1e-6)
    over = np.eye(10)
    over[:3, :3], over[7, 7] = turn.T, sign
    other = early._replace(state=turned, covariance=over @ early.covariance @ over.T)
    pairs = [
        min(_joined.counts(each, late, 25.0), key=lambda one: one.chi_squared)
        for each in (early, other)
    ]
    assert pairs[0].chi_squared == pytest.approx(pairs[1].chi_squared, rel=1e-6)
    assert pairs[0].state[:2] == pytest.approx(pairs[1].state[:2], abs=1e-8)


def test_modes_are_not_joined(tumbling):
    problem, state = tumbling
    late = _alone(problem, state, problem.t > 0.0).solutions[0]
    other = late.state.copy()
    other[1] = -other[1]
    assert not _joined.counts(late._replace(state=other), late, 25.0)


def test_too_many_turns_of_one_apparition_are_refused():
    curve, _, _ = apparition_curves.rotator(103)
    with pytest.raises(AttitudeError, match=r"an apparition spans \d+ turns"):
        inversion.spin_states(curve, "300 /d")
