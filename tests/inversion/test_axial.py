"""Rotation about one axis: poles, their mirror images, errors of several minima, and a search."""

import math
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from attitude import inversion
from attitude.inversion import (
    _ellipsoid,
    _pole_map,
    _refinement,
    _shapes,
    _verdicts,
)
from attitude.inversion._problem import CurveProblem
from attitude.inversion._settings import DEFAULT
from tests.support import inversion_families as families
from tests.support import synthetic_curves
from tests.support.inversion_geometry import in_plane


def problem_of(sun, observer, t):
    """A problem of given directions (3, N)."""
    count = len(t)
    return CurveProblem(
        t,
        span=1e6,
        sun=sun,
        observer=observer,
        magnitude=np.zeros(count),
        sigma=np.full(count, 0.02),
        terms=np.ones((count, 1)),
        prior=np.array([np.inf]),
        model_error=0.0,
    )


def test_the_mirror_pole_shows_the_same_magnitudes():
    """Those of a body reflected in the plane of the scene, whose spin is an axial vector."""
    generator = np.random.default_rng(5)
    normal = np.array([0.1, -0.2, 0.97])
    normal /= np.linalg.norm(normal)
    t = np.sort(generator.uniform(-0.5, 0.5, 60))
    given = problem_of(in_plane(generator, 60, normal), in_plane(generator, 60, normal), t)
    state = _ellipsoid.starts(generator, np.array([17.3]), np.array([-1.0]))[0]
    state[2:5] = 0.0, _ellipsoid.AXIAL, 0.0
    other = state.copy()
    reflection = np.eye(3) - 2.0 * np.outer(normal, normal)
    turn = reflection @ state[5:14].reshape(3, 3) @ np.diag([1.0, 1.0, -1.0])
    other[5:14] = turn.ravel()
    assert turn[:, 2] == pytest.approx(_pole_map.mirrored(state[[7, 10, 13]], normal), abs=1e-12)
    away = other.copy()
    away[[6, 7, 9, 10, 12, 13]] *= -1.0
    own, seen, antipode = (
        _refinement.model(given, np.append(each, np.zeros(_refinement.WIDTH - len(each)))).magnitude
        for each in (state, other, away)
    )
    # the facets of an ellipsoid are not symmetric
    assert np.abs(own - seen).max() < 0.03 and np.abs(own - antipode).max() > 0.15
    assert _verdicts.relation(other, state, given) == "mirror pole"
    turned = other.copy()
    turned[[7, 10, 13]] *= -1.0
    assert _verdicts.relation(turned, state, given) == "antipode of the mirror pole"
    state[0] *= 2.0
    assert _verdicts.relation(state, other, given) == "half the period of phi, mirror pole"


def test_the_scene_turns_about_a_pole():
    t = np.linspace(-0.5, 0.5, 80)
    angle = 2.0 * math.pi * 0.2 * t
    scene = np.stack([np.cos(angle), np.sin(angle), np.full(80, 0.3)]) / math.sqrt(1.09)
    given = problem_of(scene, scene, t)
    turns = _pole_map.turn_of_scene(given, np.array([[0.0, 0.0, 1.0], [0.0, 0.0, -1.0]]))
    assert turns == pytest.approx([0.2, -0.2])
    up = _ellipsoid.starts(np.random.default_rng(1), np.array([10.1]), np.array([-1.0]))[0]
    up[5:14], down = np.eye(3).ravel(), up.copy()
    down[0], down[5:14] = 9.9, np.diag([1.0, -1.0, -1.0]).ravel()
    # 20.2 turns about the one pole are seen as 19.8 about the other one
    assert _pole_map.has_turn(given, up, down)
    down[0] = 10.1
    assert not _pole_map.has_turn(given, up, down)


def test_other_minima_widen_the_errors_of_a_pole():
    angle = math.radians(20.0)
    here = np.zeros(_refinement.WIDTH)
    here[0], here[5:14] = 10.0, np.eye(3).ravel()
    tilted, away = here.copy(), here.copy()
    c, s = math.cos(angle), math.sin(angle)
    tilted[5:14] = np.array([[1, 0, 0], [0, c, -s], [0, s, c]]).ravel()
    tilted[0] = 10.1
    away[5:14] = np.diag([1.0, -1.0, -1.0]).ravel()
    alone = _pole_map.spread(here, 5.0, [(away, 5.0)])
    assert not alone.any()
    both = _pole_map.spread(here, 5.0, [(away, 5.0), (tilted, 5.0)])
    assert both[0, 0] == pytest.approx(0.5 * angle**2) and both[1, 1] == pytest.approx(0.0)
    assert both[3, 3] == pytest.approx(0.5 * 0.1**2)
    # a minimum that is less probable counts less
    assert _pole_map.spread(here, 5.0, [(tilted, 15.0)])[0, 0] < 0.01 * angle**2


def test_cases_that_vary_by_less_than_their_errors_are_not_drawn(capsys):
    """By the truth alone; the seed is printed and the next one taken, with the same style."""
    style = families.AXIAL[8]
    case = synthetic_curves.case(7300008, style)
    errors = (case.magnitude - case.exact) / case.sigma
    assert errors.std() == pytest.approx(1.0, abs=4.0 / math.sqrt(2.0 * len(errors)))
    assert synthetic_curves.variation(case) == pytest.approx(0.022, abs=5e-4)
    assert not synthetic_curves.is_decidable(case)
    [drawn] = families.cases_of(families.Kind([style], "shared", decidable=True), 1, 7300008)
    assert "seed 7300008, 0.022 mag" in capsys.readouterr().out
    assert np.array_equal(drawn.magnitude, synthetic_curves.case(7300009, style).magnitude)
    assert synthetic_curves.variation(drawn) > 0.03


def test_what_every_fit_projects_out_is_no_variation():
    case = synthetic_curves.case(7300009, families.AXIAL[9])
    before = synthetic_curves.variation(case)
    r, d = np.linalg.norm(case.sun, axis=1), np.linalg.norm(case.observer, axis=1)
    alpha = np.arccos(np.sum(case.sun * case.observer, axis=1) / r / d)
    case.exact = case.exact + 0.3 + 2.0 * alpha - np.exp(-alpha / math.radians(5.0))
    assert synthetic_curves.variation(case) == pytest.approx(before, rel=1e-9)


def test_the_share_of_the_sky_that_a_list_covers():
    cap = 0.5 * (1.0 - math.cos(math.radians(15.0)))
    up = np.array([0.0, 0.0, 1.0])
    assert families.share_of_sky([up, up]) == pytest.approx(cap, rel=0.02)
    assert families.share_of_sky([up, -up]) == pytest.approx(2.0 * cap, rel=0.02)
    assert families.share_of_sky([]) == 0.0


def test_a_list_has_poles_fifteen_degrees_apart_of_each_rate():
    def at(degrees, evidence, rate=10.0):
        angle, state = math.radians(degrees), np.zeros(_refinement.WIDTH)
        c, s = math.cos(angle), math.sin(angle)
        state[5:14] = np.array([[1, 0, 0], [0, c, -s], [0, s, c]]).ravel()
        state[0] = rate
        return SimpleNamespace(refined=SimpleNamespace(state=state), evidence=evidence)

    best, near, far, other = at(0.0, 1.0), at(14.0, 2.0), at(16.0, 3.0), at(5.0, 4.0, rate=11.0)
    entries, beside = _pole_map.listed([far, at(40.0, 27.0), other, near, best], 25.0, DEFAULT)
    assert entries == [best, far, other] and beside == [near]


def test_poles_apart_from_better_and_from_other_ones():
    def at(degrees):
        angle, state = math.radians(degrees), np.zeros(_refinement.WIDTH)
        c, s = math.cos(angle), math.sin(angle)
        state[5:14] = np.array([[1, 0, 0], [0, c, -s], [0, s, c]]).ravel()
        return SimpleNamespace(state=state)

    best, near, far, taken = at(0.0), at(14.0), at(16.0), at(-10.0)
    assert _pole_map.apart([best, near, far], [], DEFAULT) == [best, far]
    assert _pole_map.apart([best, near, far], [taken.state], DEFAULT) == [near]
    assert _pole_map.apart([best, near, far], [taken.state], DEFAULT, 1e-4) == [best, near, far]


@pytest.mark.slow
def test_where_nearly_any_pole_fits_the_list_says_so():
    """Six nights of ten: minima are a fifth of the sky, and the truth lies between them."""
    case = synthetic_curves.case(2, {**families.AXIAL[0], "per_hour": 2})
    curve = families.curve_of(case, "shared")
    curve = curve[case.jd < case.jd[0] + 10.2]
    settings = inversion.Settings(axial_poles=100, axial_freed=20)
    found = inversion.spin_states(curve, f"{1.3 / case.P_phi} /d", modes=("PA",), settings=settings)
    assert found.verdict == "periods only" and families.judged(found[0], case)[0]
    poles = np.array([_ellipsoid.SearchState.of(each.state).pole for each in found])
    assert families.share_of_sky(poles) > 0.5
    assert min(families.judged(each, case)[1] for each in found) < 10.0
    # those of the map have no free pole, fit as well, and none comes first
    held = (poles @ _shapes.even_directions(100).T).max(axis=1) > 1.0 - 1e-9
    assert np.count_nonzero(held) > 20 and not held[0]
    assert all(each.rms < 1.2 * found[0].rms for each in np.array(found, object)[held])


@pytest.fixture(scope="module")
def solved():
    """A synthetic rotator of an independent model, and a search of fewer poles and pairs."""
    case = synthetic_curves.case(1, {**families.AXIAL[0], "per_hour": 1})
    curve = families.curve_of(case, "shared")
    most = f"{1.3 / case.P_phi} /d"
    settings = inversion.Settings(
        pairs=10,
        deep_starts=4,
        classes=6,
        convex=10,
        short_classes=10,
        axial_poles=60,
        rounds=1,
        mapped=0,
    )
    return case, inversion.spin_states(curve, most, modes=("SAM",), settings=settings)


def test_a_rotation_about_one_axis_is_found(solved):
    """Period at rank 1, pole or mirror pole among those that compete, errors that contain it."""
    case, found = solved
    assert found[0].mode == "PA" and families.judged(found[0], case)[0]
    assert found.verdict != "not solved"
    near = [each for each in found if each.evidence < found[0].evidence + 12.0]
    angles = [families.judged(each, case)[1] for each in near]
    assert min(angles) < 15.0
    assert np.radians(min(angles)) < 4.0 * near[int(np.argmin(angles))].pole_sigma


def test_the_list_has_one_entry_a_pole_and_no_other_periods_close_by(solved):
    _, found = solved
    poles = np.array(
        [_ellipsoid.SearchState.of(each.state).pole for each in found if each.is_axial]
    )
    rates = np.array([each.state[0] for each in found if each.is_axial])
    alike = (poles @ poles.T > math.cos(math.radians(14.9))) & (
        np.abs(rates[:, None] - rates) < 0.17
    )
    assert alike.sum() == len(poles)
    assert "best" in found[0].relation and all(each.relation for each in found)


def test_a_map_of_poles_ends_early_where_a_pole_is_far_behind(solved):
    """The most probable pole is one of the best of a map whose fits all go on, for less work."""
    found = solved[1]
    weighted = found[0].weighted
    problem = replace(
        weighted.problem, settings=replace(weighted.problem.settings, axial_poles=40, axial_freed=9)
    )
    fixed = np.zeros(_refinement.SIZE, bool)
    fixed[:8] = _ellipsoid.AXIAL_FIXED[:8]
    spent, best = [], []
    for stages in (problem.settings.axial_stages, ()):
        settings = replace(problem.settings, axial_stages=stages)
        problem = replace(problem, settings=settings)
        problem.tally.spent = 0.0
        generator = np.random.default_rng(0)
        arguments = problem, problem, weighted.refined.state, generator, _shapes.Tie(), fixed
        free, held = _pole_map.minima(*arguments, 1.0, lambda: False)
        best.append([fit for fit in free if fit.cost < free[0].cost + 5.0])
        turned = np.array([fit.state[_ellipsoid.OF_POLE] for fit in held])
        assert (turned @ _shapes.even_directions(40).T).max(axis=1) == pytest.approx(1.0, abs=1e-12)
        spent.append(problem.tally.spent)
    poles = [fit.state[_ellipsoid.OF_POLE] for fit in best[1]]
    assert np.max(poles @ best[0][0].state[_ellipsoid.OF_POLE]) > math.cos(math.radians(2.0))
    assert best[0][0].cost == pytest.approx(best[1][0].cost, abs=2.0)
    assert spent[0] < 0.8 * spent[1]
