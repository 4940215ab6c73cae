"""Parts of the search: work that is counted, other poles, moons, outliers, noise, symmetry."""

import math
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from attitude import Body, inversion
from attitude.frames import matrix_to_icrf
from attitude.inversion import (
    _apparitions,
    _ellipsoid,
    _evidence,
    _figures,
    _known,
    _lattices,
    _motions,
    _neighbours,
    _pole_map,
    _problem,
    _refinement,
    _satellites,
    _search,
    _settings,
    _shapes,
    _spin_states,
    _verdicts,
)
from attitude.inversion._ellipsoid import SearchState
from attitude.inversion._settings import DEFAULT
from attitude.scattering import LommelSeeligerLambert
from attitude.shape import Mesh, box
from tests.support import inversion_families as families
from tests.support import mesh_curves, synthetic_curves
from tests.support.inversion_geometry import in_plane

COUNT = 400


def _given(y, t=None, sigma=0.02, sun=None, observer=None, span=30.0 * 86400.0):
    """A problem of magnitudes (N,) at epochs (N,), with a constant that is free."""
    count = len(y)
    t = np.linspace(-0.5, 0.5, count) if t is None else t
    up = np.tile([[0.0], [0.0], [1.0]], count)
    directions = up if sun is None else sun, up if observer is None else observer
    terms = np.ones((count, 1)), np.array([np.inf])
    return _problem.CurveProblem(
        t, span, *directions, y, np.full(count, sigma), *terms, 0.0, tally=_settings.Tally()
    )


def _body(seed=3, nutation=-9.0):
    generator = np.random.default_rng(seed)
    state = np.zeros(_refinement.WIDTH)
    state[:16] = _ellipsoid.starts(generator, np.array([17.3]), np.array([nutation]))[0]
    state[16:] = 0.4 * generator.normal(size=_shapes.MODES)
    return state


def test_work_is_counted_by_steps_and_points():
    given = _given(np.zeros(COUNT))
    states = _ellipsoid.starts(np.random.default_rng(0), np.full(30, 12.0), np.full(30, -5.0))
    _ellipsoid.costs(given, states)
    assert given.tally.spent == pytest.approx(30 * COUNT * given.settings.screen_cost)
    # problems that are made of one share its tally
    _refinement.model(given.with_model_error(0.1).part(np.arange(COUNT) < 100), _body())
    settings = given.settings
    more = settings.step_cost + 100 * (settings.body_cost + settings.body_term_cost)
    assert given.tally.spent == pytest.approx(30 * COUNT * given.settings.screen_cost + more)
    given.tally.budget = 0.5 * given.tally.spent
    assert given.tally.is_over


def test_millions_of_rates_keep_the_budget():
    """Two turns a second for half a year: 250 million rates, of which one block is over it."""
    t = np.linspace(-0.5, 0.5, COUNT)
    given = _given(0.1 * np.sin(90.0 * t), t, span=188.0 * 86400.0)
    given.tally.budget = 0.02
    chosen = _apparitions.windows(given, 1.0, 32e6).bounds
    cells = len(_apparitions.Combs(given).centre)
    block = given.settings.comb_cost + cells * given.settings.cell_cost
    assert 0.02 < given.tally.spent <= _apparitions._BLOCK * block * (1.0 + 1e-9)
    assert chosen and all(high < 2.0 * _apparitions._BLOCK for _, high in chosen)


def test_windows_of_rates_do_not_depend_on_blocks(monkeypatch):
    generator = np.random.default_rng(7)
    t = np.sort(generator.uniform(-0.5, 0.5, COUNT))
    y = 0.2 * np.cos(4.0 * math.pi * 1234.5 * t) + 0.02 * generator.normal(size=COUNT)
    given = _given(y, t)
    found = []
    for block in (300, 10**6):
        monkeypatch.setattr(_apparitions, "_BLOCK", block)
        found.append(_apparitions.windows(given, 1.0, 3000.0).bounds)
    assert found[0][0] == pytest.approx(found[1][0])
    assert any(low < 1234.5 < high for low, high in found[0])


def test_many_states_are_compared_as_one():
    generator = np.random.default_rng(1)
    rates = generator.uniform(10.0, 11.0, 60), generator.choice([-1.0, 1.0], 60)
    states = _ellipsoid.starts(generator, *rates)
    states[40:, 3] = _ellipsoid.AXIAL
    for state in states:
        alike = [bool(_ellipsoid.have_rates(other, state, 0.35)) for other in states]
        assert np.array_equal(_ellipsoid.have_rates(states, state, 0.35), alike)
        assert any(alike) and not all(alike)


def test_every_nutation_is_tried_with_a_line():
    """A line of phi, or of phi and psi together, in both modes: truths that were missed too."""
    rates = _lattices.of_line(80.4, 257.3, ("LAM", "SAM"))
    # lambda/pi and the signed nutation, with the line as phi in long-axis mode ...
    for rate, nutation in ((118.0, 37.6), (80.4, 37.6), (80.4, -37.6), (42.8, -37.6)):
        near = [
            abs(2.0 * one.precession - rate) < _lattices.STEP
            and abs(one.nutation - nutation) < 0.51 * _lattices.STEP
            for one in rates
        ]
        assert any(near)
    states = [_ellipsoid.SearchState.of(np.array([*one, 0, -1, *np.zeros(12)])) for one in rates]
    lines = np.array([(one.rates[0], sum(one.rates)) for one in states])
    assert np.abs(lines - 80.4).min(axis=1).max() < 1e-9
    assert lines.min() >= _lattices.LEAST and lines.max() <= 257.3
    assert all(one.nutation > 0.0 for one in _lattices.of_line(80.4, 257.3, ("LAM",)))


@pytest.mark.parametrize(("modes", "count"), [(("LAM", "SAM"), 10), (("SAM",), 5)])
def test_rates_with_lines_of_others_or_next_to_them(modes, count):
    """Ellipsoids fitted a body of rates 84.94 and 4.86 with 80.11 and 4.79."""
    candidates = _lattices.mistaken(80.11, 4.79, 200.0, modes)
    assert len(candidates) == count
    states = [np.r_[one.precession, one.nutation, 0.0, -1.0, np.zeros(12)] for one in candidates]
    rates = [_ellipsoid.SearchState.of(state).rates for state in states]
    others = [(80.11 + moved, 4.79) for moved in (-4.79, 0.0, 4.79)]
    for other in (*others, (80.11, 2.395), (80.11, 9.58)):
        assert len([pair for pair in rates if pair == pytest.approx(other)]) == len(modes)
    assert len(_lattices.mistaken(80.11, 4.79, 87.0, modes)) == count * 3 // 5


@pytest.mark.parametrize("nutation", [24.9, -4.9])
def test_a_pair_with_odd_lines_gives_its_rates(nutation):
    """Of a body without the symmetry of an ellipsoid, whose pair is that of phi and psi."""
    pair = np.array([[27.2, abs(nutation)]])
    modes = ("LAM", "SAM")
    odd, even = (
        [
            one
            for one in _lattices.candidates(pair, 100.0, modes, has_odd_lines=has_odd_lines)
            if 2.0 * one.precession - max(one.nutation, 0.0) == pytest.approx(27.2)
            and one.nutation == pytest.approx(nutation)
        ]
        for has_odd_lines in (True, False)
    )
    assert len(odd) == 1 and not even


def test_rates_of_lines_are_those_that_the_scene_sees(monkeypatch):
    """The poles of many pairs of rates are mapped, of bodies, short fits and odd lines in turn."""
    angle = np.linspace(0.0, 1.0, COUNT)
    sun = np.stack([np.cos(angle), np.sin(angle), np.full(COUNT, 0.1)]) / math.sqrt(1.01)
    given = _given(np.zeros(COUNT), np.linspace(-0.5, 0.5, COUNT), sun=sun, observer=sun)
    bodies = [SimpleNamespace(state=_body(nutation=nutation)) for nutation in (-9.0, -9.1)]
    search = _search_of(given, convex=bodies, solutions=[_weighted(-9.0, 0.0, 1.0)])
    rates = [_lattices.Candidate(20.0, 7.0), _lattices.Candidate(31.0, -4.0)]
    search._pairs = np.array([[33.0, 7.0]])

    def candidates(pairs, *others, has_odd_lines):
        assert has_odd_lines and pairs is search._pairs
        return rates

    monkeypatch.setattr(_lattices, "candidates", candidates)
    ranked = _ellipsoid.starts(np.random.default_rng(1), np.array([20.05, 40.0]), np.full(2, 7.0))
    mapped = []
    monkeypatch.setattr(_search.Search, "_by_either_error", lambda self, thinned: [*ranked])

    def add_classes(self, clipped, thinned, rates):
        mapped.extend(state[: _ellipsoid.WIDTH] for state in rates)
        return True

    monkeypatch.setattr(_search.Search, "_add_classes", add_classes)
    monkeypatch.setattr(_search.Search, "_mistaken", lambda self: ())
    assert search._poles_of_classes(0)
    states = np.array(mapped)
    assert states[:, 0].tolist() == [17.3, 20.05, 40.0, 31.0] and states[3, 1] == -4.0
    assert abs(_pole_map.turn_of_scene(given, states[3:, _ellipsoid.OF_POLE])[0]) < 0.01
    assert abs(_pole_map.turn_of_scene(given, np.array([[0.0, 0.0, 1.0]]))[0]) > 0.1


def test_few_modes_make_a_lopsided_body():
    """As the body of all modes of which the others are zero; two steps leave a tenth."""
    generator = np.random.default_rng(4)
    t = np.sort(generator.uniform(-0.5, 0.5, COUNT))
    sun, observer = (in_plane(generator, COUNT, np.array([0.1, -0.2, 0.97])) for _ in range(2))
    state = _body()
    state[16 + 24 :] = 0.0
    given = _given(np.zeros(COUNT), t, sun=sun, observer=observer)
    seen = _refinement.model(given, state).magnitude
    few = _refinement.model(given, state[: 16 + 24])
    assert few.magnitude == pytest.approx(seen, abs=1e-12) and few.jacobian.shape == (34, COUNT)
    curve = _given(seen, t, sun=sun, observer=observer)
    start = state[:16]
    rough = _refinement.refine(curve, start, iterations=1, modes=24).fitted
    fit = _refinement.refine(curve, start, iterations=3, modes=24).fitted
    assert len(fit.state) == 16 + 24 and fit.chi_squared < 0.1 * rough.chi_squared
    whole = _refinement.refine(curve, fit.state, iterations=1).fitted
    assert whole.chi_squared == pytest.approx(fit.chi_squared, rel=1e-9)


def test_pairs_of_most_power_are_fitted():
    """Three in a hundred of them contain the best pairs of a series of two frequencies."""
    t = np.sort(np.random.default_rng(2).uniform(-0.5, 0.5, COUNT))
    y = 0.2 * np.cos(2.0 * math.pi * 41.0 * t) + 0.1 * np.cos(2.0 * math.pi * (41.0 + 27.0) * t)
    given = _given(y, t)
    spent, best = [], []
    for fitted in (10**6, 1000):
        given.tally.spent = 0.0
        few = replace(given, settings=replace(given.settings, pairs_fitted=fitted))
        found, left = _lattices.lattice_pairs(few, 90.0, 10)
        assert left.max() < 0.01
        best.append(set(map(tuple, np.round(found).tolist())))
        spent.append(given.tally.spent)
    assert len(best[0] & best[1]) >= 8
    assert spent[1] < 0.2 * spent[0]


def _search_of(problem, **results):
    return _search.Search(
        problem,
        60.0,
        ("LAM", "SAM"),
        _shapes.Tie(),
        (),
        np.random.default_rng(0),
        print,
        **results,
    )


@pytest.mark.parametrize(("ahead", "expected"), [(0.0, 12), (30.0, 12), (50.0, 3)])
def test_few_poles_of_a_rotation_are_fitted_where_tumbling_is_ahead(monkeypatch, ahead, expected):
    poles = _shapes.even_directions(12)
    rotations = [_weighted(0.0, 100.0 + 0.1 * k, 1.0).refined for k in range(12)]
    for pole, rotation in zip(poles, rotations, strict=True):
        rotation.state[_ellipsoid.OF_POLE] = pole
    given = _given(np.zeros(COUNT))
    search = _search_of(given, convex=list(rotations), axial=list(rotations))
    fitted = []

    def robust(self, problem, fit, *, is_wide=False):
        fitted.append(fit)
        return _evidence.Weighted(fit, problem, 100.0, np.zeros(COUNT), 1.0)

    monkeypatch.setattr(_search.Search, "_robust", robust)
    found = search._axial_solutions(given, [_weighted(-9.0, 100.0 - ahead, 1.0)])
    assert len({id(each.refined) for each in found}) == expected
    assert len({id(each) for each in fitted}) == expected


@pytest.mark.parametrize(
    ("costs", "ahead", "tumbling", "residual", "expected"),
    [
        ((0.0, 30.0), -math.inf, 1.0, 0.0, [200, 100]),
        ((30.0, 0.0, 0.0), -math.inf, 1.0, 0.0, [200, 100, 200]),  # the other rate comes first
        ((0.0,), 80.0, 1.0, 0.0, [200]),  # a tumbling body is ahead of the best rate
        # of (135) Hertha one of other periods left less than half, all far below the errors
        ((0.0, 30.0), -math.inf, 0.4, 0.0, [200, 100]),
        ((), -math.inf, 0.4, 1.0, []),
    ],
)
def test_another_rate_of_rotation_has_a_coarser_map(
    monkeypatch, costs, ahead, tumbling, residual, expected
):
    bodies = [_weighted(0.0, 0.0, 1.0).refined for _ in range(2)]
    bodies[1].state[0] *= 2.0
    bodies.append(_weighted(-9.0, 0.0, 1.0).refined)
    for body, chi_squared in zip(bodies, (1.0, 1.0, tumbling), strict=True):
        body.chi_squared, body.cost = chi_squared, 0.0
    bodies.sort(key=lambda body: body.chi_squared)
    search = _search_of(_given(np.zeros(COUNT)), convex=list(bodies))
    maps, rates, left = [], [], iter(costs)

    def minima(mapping, rough, state, *others):
        maps.append(mapping.settings.axial_poles)
        rates.append(state[0])
        # with its pole free a body turns at another rate
        moved = np.array([state[0] + 1.0, *state[1:]])
        fit = SimpleNamespace(state=moved, cost=next(left), normal=np.eye(_refinement.SIZE))
        return [fit], [fit]

    def robust(self, problem, fit, *, is_wide=False):
        left = np.full(COUNT, residual)
        return _evidence.Weighted(fit, problem, float(fit.state[0]), left, 1.0)

    def is_far_behind(self, rotator, problem, width):
        return ahead > width and width == problem.settings.axial_mapped

    monkeypatch.setattr(_pole_map, "minima", minima)
    for name, fake in (
        ("_robust", robust),
        ("_is_far_behind", is_far_behind),
        ("_with_own_error", lambda self, best: self.problem),
        ("_fit", lambda self, state: bodies[0]),
    ):
        monkeypatch.setattr(_search.Search, name, fake)
    search._axial_poles()
    assert maps == expected
    # the second map of a rate is about what the first one found
    assert rates[2:] == [rate + 1.0 for rate in rates[1:-1]]


@pytest.mark.parametrize(("factor", "short", "deep"), [(2.9, 60, 30), (3.1, 40, 8)])
def test_pairs_of_rates_far_above_the_least_cost_are_not_followed(monkeypatch, factor, short, deep):
    """But for the first ones, which the verdict is compared with."""
    states = np.repeat(_body()[None, :16], 60, axis=0)
    states[:, _ellipsoid.OF_NUTATION] -= np.arange(60.0)
    pool = _ellipsoid.Pool(np.where(np.arange(60), factor, 1.0), states)
    search, fitted, followed = _search_of(_given(np.zeros(COUNT))), [], []

    def fit(self, state, steps, problem, modes):
        fitted.append((float(state[_ellipsoid.OF_NUTATION]), modes))
        return SimpleNamespace(state=state, cost=0.0)

    def followed_one(problem, generator, rate, count, *, tie):
        followed.append(rate)
        return pool.rows(np.array([0]))

    monkeypatch.setattr(_search.Search, "_fit", fit)
    monkeypatch.setattr(_ellipsoid, "narrowed", lambda *given, **named: pool)
    monkeypatch.setattr(_ellipsoid, "deep", followed_one)
    search._by_short_fits(pool, search.problem)
    with_few = [nutation for nutation, modes in fitted if modes == DEFAULT.short_modes]
    assert with_few == states[:short, _ellipsoid.OF_NUTATION].tolist()
    search._ellipsoids(search.problem, [None], None, 6, 1, 1, "rates")
    assert [rate.nutation for rate in followed] == states[:deep, _ellipsoid.OF_NUTATION].tolist()


def test_costs_of_narrowed_rates_are_those_of_all_points():
    """The first steps have half of them."""
    generator = np.random.default_rng(4)
    across = generator.normal(size=(2, 3, COUNT))
    sun, observer = across / np.linalg.norm(across, axis=1)[:, None]
    problem = _given(0.2 * generator.normal(size=COUNT), sun=sun, observer=observer)
    rates = [_lattices.Candidate(20.0, f) for f in (7.0, 9.0, -8.0, -12.0)]
    held = _ellipsoid.Held(problem.settings.tie)
    pool = _ellipsoid.narrowed(problem, generator, rates, 6, tie=held, poles=None)
    again = _ellipsoid.minimised(problem, pool.states, 1, tie=held)
    # the worse half of the rates is left with those of the half, over its share
    better = np.argsort(pool.cost)[:2]
    np.testing.assert_allclose(pool.cost[better], again.cost[better], rtol=1e-9)
    np.testing.assert_allclose(pool.cost, again.cost, rtol=0.3)


def test_deep_starts_end_where_all_of_them_do():
    case = families.KINDS["tumblers"].case(7200000, 0)
    curve = families.curve_of(case, "shared")
    problem, _ = _problem.problem(curve, case.most / 86400.0, 0.07, "shared")
    span = np.ptp(case.jd)
    long = case.mode == "LAM"
    phi, psi = span / case.P_phi, span / case.P_psi
    rate = _lattices.Candidate(0.5 * (phi + long * psi), psi if long else -psi)
    held = _ellipsoid.Held(problem.settings.tie)
    pools = [
        _ellipsoid.deep(problem, np.random.default_rng(1), rate, 40, tie=held),
        _ellipsoid.around(problem, np.random.default_rng(1), [rate], 40, iterations=40, tie=held),
    ]
    assert [len(pool.cost) for pool in pools] == [16, 40]
    assert pools[0].cost.min() < 1.001 * pools[1].cost.min()
    spent = problem.tally.spent
    _ellipsoid.deep(problem, np.random.default_rng(1), rate, 40, tie=held)
    once = problem.tally.spent - spent
    _ellipsoid.around(problem, np.random.default_rng(1), [rate], 40, iterations=40, tie=held)
    assert once < 0.8 * (problem.tally.spent - spent - once)


def _compared_fits(monkeypatch):
    """The fits that are compared when a search ends, and whether with the wide prior."""
    compared = []

    def robust(self, problem, fit, *, is_wide=False):
        compared.append((fit, is_wide))
        return _evidence.Weighted(fit, problem, fit.cost, np.zeros(COUNT), 1.0)

    for name, fake in (
        ("_robust", robust),
        ("_ranked", lambda self, problem, fit: fit),
        ("_with_own_error", lambda self, best: self.problem),
        ("_takes_noise", lambda self, problem, best: False),
        ("_axial_solutions", lambda self, problem, solutions: []),
    ):
        monkeypatch.setattr(_search.Search, name, fake)
    return compared


@pytest.mark.parametrize(("first", "expected"), [(0, True), (4, False)])
def test_the_first_rates_by_ellipsoids_are_compared_too(monkeypatch, first, expected):
    """However many bodies of other rates have a lower cost with their own error."""
    bodies = [_weighted(-9.0 - 0.5 * k, 0.0, 1.0).refined for k in range(20)]
    for k, body in enumerate(bodies):
        body.cost = 100.0 if k == first else float(k)
    rotations = [_weighted(0.0, 0.0, 1.0).refined for _ in range(14)]
    for rotation in rotations:
        rotation.cost = -1.0
    search = _search_of(_given(np.zeros(COUNT)), convex=[*bodies, *rotations])
    compared = _compared_fits(monkeypatch)
    search.finish(10)
    assert any(fit is bodies[first] for fit, _ in compared) == expected
    # rotations take no places of tumbling bodies
    assert sum(fit is not bodies[first] for fit, _ in compared) >= 10


@pytest.mark.parametrize(("budget", "tried"), [(math.inf, 3), (8.0, 2)])
def test_bodies_beside_orbits_leave_most_of_the_budget(monkeypatch, budget, tried):
    """Up to 13 searches beside orbits of a tumbling body left nothing for maps of its poles."""
    tally = _settings.Tally(budget)
    given = replace(_given(np.zeros(COUNT)), tally=tally)
    search = _search_of(given, solutions=[_weighted(-9.0, 0.0, 1.0)])
    orbits = [(_satellites.AdditivePair(20.0, orbit, 0.1), given) for orbit in (5.0, 6.0, 7.0)]
    spent = []

    def beside(self, problem, rates):
        tally.add(1, 1.5)
        spent.append(tally.spent)
        return []

    def series(self, least):
        return self._rivals(orbits, np.zeros(0), least)

    monkeypatch.setattr(_search.Search, "_beside", beside)
    monkeypatch.setattr(_search.Search, "_beside_series", series)
    search._compare_with_satellite()
    assert len(spent) == tried


@pytest.mark.parametrize(("budget", "are_all"), [(math.inf, True), (4.0, False)])
def test_maps_that_the_budget_ends_are_told(monkeypatch, budget, are_all):
    """Rates that were not tried may be the true ones: of `nonconvex` 192022 they were."""
    tally = _settings.Tally(budget)
    given = replace(_given(np.zeros(COUNT)), tally=tally)
    search = _search_of(given, solutions=[_weighted(-9.0, 0.0, 1.0)])

    def in_few_steps(problem, generator, state, held, tie):
        tally.add(1, 1.2)
        return []

    monkeypatch.setattr(_pole_map, "in_few_steps", in_few_steps)
    rates = [_ellipsoid.starts(np.random.default_rng(1), np.array([20.0]), np.full(1, 7.0))[0]] * 3
    assert search._add_classes(given, given, rates) is are_all
    monkeypatch.setattr(_search.Search, "_by_either_error", lambda self, thinned: rates)
    assert search._poles_of_classes(0) is are_all


def test_outliers_hardly_count_in_maps_of_many_rates(monkeypatch):
    """They hid the true pole of a curve at its true rates: bodies at all poles fitted alike."""
    residual = np.zeros(COUNT)
    residual[::50] = 0.5
    given = replace(_given(np.zeros(COUNT)), model_error=DEFAULT.ellipsoid_error)
    search = _search_of(given, solutions=[_weighted(-9.0, 0.0, 1.0, residual)])
    of_maps, of_bodies = [], []

    def in_few_steps(problem, generator, state, held, tie):
        of_maps.append(problem)
        return [SimpleNamespace(state=state)]

    def fit(self, state, iterations=20, problem=None, *others, **options):
        of_bodies.append(self.problem if problem is None else problem)
        return SimpleNamespace(state=state, cost=0.0)

    monkeypatch.setattr(_pole_map, "in_few_steps", in_few_steps)
    monkeypatch.setattr(_search.Search, "_fit", fit)
    monkeypatch.setattr(_search.Search, "finish", lambda self: None)
    monkeypatch.setattr(_search.Search, "_other_poles", lambda self: False)
    monkeypatch.setattr(_search.Search, "_by_either_error", lambda self, thinned: [_body()])
    assert search._poles_of_classes(0)
    first, last = of_bodies[0], of_bodies[-1]
    assert len(of_maps[0]) < len(first) == COUNT and first.model_error == DEFAULT.body_error
    for problem in (*of_maps, first):
        assert problem.sigma[0] > 5.0 * given.sigma[0] and problem.sigma[1] == given.sigma[1]
    # their best bodies are compared with all others
    assert last is given


@pytest.mark.parametrize(
    ("are_all", "nutation", "residual", "is_complete"),
    [
        (True, -9.0, 0.0, True),
        (False, -9.0, 0.0, False),
        (False, 0.0, 0.0, True),  # these maps are of tumbling states
        (False, 0.0, 1.0, False),  # above the errors one may be what the rotation lacks
    ],
)
def test_a_search_without_all_maps_of_its_first_round_is_incomplete(
    monkeypatch, are_all, nutation, residual, is_complete
):
    solution = _weighted(nutation, 0.0, 1.0, np.full(COUNT, residual))
    search = _search_of(_given(np.zeros(COUNT)), solutions=[solution])
    rounds = []

    def poles_of_classes(self, number):
        rounds.append(self.is_complete)
        return are_all and len(rounds) == 1

    parts = ("_axial", "_axial_poles", "finish", "_hardly_nutating", "_other_poles", "_clipped")
    for name in (*parts, "_compare_with_satellite", "_pools"):
        monkeypatch.setattr(_search.Search, name, lambda self, *_: ())
    monkeypatch.setattr(_search.Search, "_poles_of_classes", poles_of_classes)
    monkeypatch.setattr(_search.Search, "is_decided", False)
    monkeypatch.setattr(_search.Search, "_thinned", lambda self, problem, number: None)
    monkeypatch.setattr(_search.Search, "is_over", False)
    search.run()
    # a later round that the budget ends leaves what the first one tried
    assert search.is_complete is is_complete and len(rounds) == 1 + are_all


@pytest.mark.parametrize(("nutation", "is_claimed"), [(-9.0, False), (0.0, True)])
def test_tumbling_is_not_claimed_where_the_budget_ends_before_moons(nutation, is_claimed):
    """Of `moons` 491800 a budget of 30 s did, and the moon was called tumbling."""
    given = replace(_given(np.zeros(COUNT)), tally=_settings.Tally(1.0, spent=2.0))
    search = _search_of(given, solutions=[_weighted(nutation, 0.0, 1.0)], is_complete=True)
    search._compare_with_satellite()
    assert search.rival is None and search.is_complete is is_claimed


@pytest.mark.parametrize(("ahead", "maps"), [(10.0, 0), (70.0, 0), (90.0, 1), (200.0, 1)])
def test_poles_beside_a_moon_are_mapped_where_it_may_decide(monkeypatch, ahead, maps):
    search = _search_of(_given(np.zeros(COUNT)), solutions=[_weighted(-9.0, 0.0, 1.0)])
    called = []
    rival = SimpleNamespace(
        evidence=lambda: -ahead,
        finish=lambda: None,
        _axial_poles=lambda: called.append(1),
        needed_ahead=120.0,
    )
    monkeypatch.setattr(_search.Search, "_beside_bodies", lambda self, least: [])
    monkeypatch.setattr(_search.Search, "_beside_series", lambda self, least: [rival])
    monkeypatch.setattr(_search.Search, "evidence", lambda self: 0.0)
    search._compare_with_satellite()
    assert search.rival is rival and len(called) == maps


@pytest.mark.parametrize("nutation", [-7.0, 7.0])
def test_a_rotation_without_its_nutation_has_its_attitudes(nutation):
    state = _body(nutation=nutation)
    state[3] = math.log(1e-3)
    rotation = _ellipsoid.without_nutation(state)
    t = np.linspace(-0.5, 0.5, 9)
    ends = [
        np.einsum(
            "ij,jkn->ikn",
            one[_ellipsoid.OF_FRAME].reshape(3, 3),
            _motions.at_epochs(one, t).matrix.reshape(3, 3, -1),
        )
        for one in (state, rotation)
    ]
    assert _ellipsoid.is_axial(rotation) and np.array_equal(rotation[14:], state[14:])
    # the tilt is twice the arc tangent of rho
    assert np.abs(ends[0] - ends[1]).max() < 5e-3


@pytest.mark.parametrize(
    ("nutation", "ln_rho", "expected"),
    [(-9.0, -3.0, True), (-9.0, -1.0, False), (9.0, -3.0, False)],
)
def test_a_tumbling_body_that_hardly_nutates_is_compared_as_a_rotation(
    monkeypatch, nutation, ln_rho, expected
):
    """Of rotators 127903 a nutation of 0.1 degrees was ahead by 19: no rotation had its shape."""
    solution = _weighted(nutation, 0.0, 1.0)
    solution.refined.state[3] = ln_rho
    search = _search_of(_given(np.zeros(COUNT)), solutions=[solution])
    fitted = []

    def refine(problem, start, *, tie, fixed):
        fitted.append(tie.is_wide and _ellipsoid.is_axial(start))
        return SimpleNamespace(fitted=SimpleNamespace(state=start, cost=1.0))

    monkeypatch.setattr(_refinement, "refine", refine)
    assert search._hardly_nutating() == expected
    assert fitted == [True] * expected
    search.convex = [SimpleNamespace(state=_body(), cost=0.0)]
    compared = _compared_fits(monkeypatch)
    search.finish()
    assert [is_wide for _, is_wide in compared] == [False] + [True] * expected


SIGNS = np.where(np.arange(COUNT) % 2, 1.0, -1.0)


@pytest.mark.parametrize(("size", "needed", "bodies"), [(0.01, 60.0, 1), (0.05, 120.0, 4)])
def test_orbits_beside_rotations_where_none_explains_the_curve(monkeypatch, size, needed, bodies):
    """The best rate of one axis was that of the orbit of moons 127804, the true one the third."""
    given = _given(SIGNS)
    best = _weighted(-9.0, 0.0, 1.0, size * SIGNS)
    rotations = [_weighted(0.0, 0.0, 1.0).refined for _ in range(6)]
    for number, rotation in enumerate(rotations):
        rotation.state[0] += number // 2 if number < 2 else number
    search = _search_of(given, solutions=[best], convex=rotations)
    assert search.needed_ahead == needed
    explained, tried_as_orbits = [], []

    def of_body(self, body):
        explained.append(2.0 * body.state[0])
        return SimpleNamespace(rate=2.0 * body.state[0])

    def rivals(problem, most, keep, orbit):
        tried_as_orbits.append(orbit)
        return []

    monkeypatch.setattr(_satellites, "rivals", rivals)
    monkeypatch.setattr(_search.Search, "_explained", of_body)
    monkeypatch.setattr(_satellites, "orbits_beside", lambda alone: [alone.rate])
    monkeypatch.setattr(_search.Search, "_with_orbits", lambda self, pairs: list(pairs))
    monkeypatch.setattr(_search.Search, "_rivals", lambda self, orbits, rates, least: [])
    assert search._beside_bodies(-math.inf) == []
    assert len(explained) == bodies and len(set(explained)) == bodies
    # a body at the floor has more than dips
    assert tried_as_orbits == (explained if bodies > 1 else [])
    # series beside worse rotations say nothing of dips: Toutatis was "not solved" by one
    assert search.dips == explained[:1]


@pytest.mark.parametrize(
    ("left", "brightens", "searches"),
    [
        (0.1, (0.2,), 1),
        (0.1, (0.6, 0.2), 2),  # beside the rotation that is found there, it only dims
        (0.1, (0.6, 0.5), 1),
        (3.0, (0.6, 0.2), 0),  # it does not explain more than the best body
    ],
)
def test_dips_beside_a_wrong_rotation_brighten(monkeypatch, left, brightens, searches):
    """They are measured again beside the rotation that is found beside their orbit."""
    given = _given(SIGNS)
    search = _search_of(given, solutions=[_weighted(-9.0, 0.0, 1.0, SIGNS)])
    measured, tried = iter(brightens), []

    def beside(self, problem, rates):
        tried.append((problem.orbit, tuple(rates)))
        return [SimpleNamespace(solutions=[_weighted(0.0, 0.0, 1.0)])]

    for owner, name, fake in (
        (_search.Search, "_beside", beside),
        (_search.Search, "_explained", lambda self, body: SimpleNamespace(rate=31.0)),
        (_satellites, "beside", lambda problem, pair, alone: replace(problem, orbit=pair.orbit)),
        (_satellites, "brightening", lambda problem, alone: next(measured)),
        (_satellites, "fitted_beside", lambda alone, orbit: pair._replace(orbit=7.1)),
    ):
        monkeypatch.setattr(owner, name, fake)
    pair = _satellites.AdditivePair(20.0, 7.0, left)
    orbits = search._with_orbits([(pair, SimpleNamespace(rate=20.0))])
    assert [orbit.brightens for orbit, _ in orbits] == [brightens[0]]
    rivals = search._rivals(orbits, np.array([20.0]), -math.inf)
    expected = [(7.0, (20.0,)), (7.1, (31.0,))][:searches]
    assert tried == expected
    assert len(rivals) == (searches > 0 and brightens[-1] < 0.35)


def test_bodies_with_nearly_the_same_error_are_compared_with_one(monkeypatch):
    """So that their fits are known."""
    signs = np.where(np.arange(COUNT) % 2, 1.0, -1.0)
    bodies = [SimpleNamespace(magnitude=size * signs) for size in (0.05, 0.0501, 0.06)]
    search = _search_of(_given(np.zeros(COUNT)))

    def weighted(self, problem, body, *, is_wide):
        return SimpleNamespace(residual=_evidence.residuals(problem, body.magnitude)[0])

    monkeypatch.setattr(_search.Search, "_weighted", weighted)
    one, alike, other = (search._with_own_error(body) for body in bodies)
    assert alike is one and other is not one
    assert other.model_error == pytest.approx(math.sqrt(0.06**2 - 0.02**2), rel=0.02)
    search.problem = search.problem.with_errors(np.full(COUNT, 0.021))
    assert search._with_own_error(bodies[0]) is not one


@pytest.mark.parametrize(
    ("nutation", "behind", "residual", "expected"),
    [
        (-9.0, 250.0, 0.01, True),
        (-9.0, 230.0, 0.01, False),  # another period is nearer
        (-9.0, 250.0, 0.05, False),  # the residuals are above the errors
        (0.0, 250.0, 0.01, False),  # nutations of a rotation are always sought
    ],
)
def test_no_nutation_is_sought_where_one_is_clear(
    monkeypatch, nutation, behind, residual, expected
):
    best = _weighted(nutation, 0.0, 1.0, np.full(COUNT, residual))
    other = _weighted(-12.0, behind, 1.0, np.full(COUNT, residual))
    search = _search_of(_given(np.zeros(COUNT)), convex=[best.refined], solutions=[best, other])
    monkeypatch.setattr(_search.Search, "finish", lambda self, most: None)
    assert search._is_clear() is expected


def test_ellipsoids_are_fitted_to_some_of_many_points():
    given = _given(np.zeros(900))
    search = _search_of(given)
    parts = [search._thinned(given, number) for number in (0, 1, 2)]
    assert [len(part) for part in parts] == [225, 450, 900]
    assert parts[0].span == given.span and parts[2] is given


def test_a_verdict_says_that_the_budget_ended_the_search():
    style = {**families.STYLES[6], "per_hour": 3}
    case = synthetic_curves.case(31, style)
    found = inversion.spin_states(families.curve_of(case, "shared"), f"{case.most} /d", budget=0.5)
    assert found.verdict == "not solved" and "budget of 0.5 s ended the search" in found.criterion


@pytest.mark.parametrize("nutation", [-9.0, 9.0])
def test_the_mirror_image_of_a_tumbling_body_is_as_bright(nutation):
    """From the plane of the mirror, with a shape that has no symmetry; 400 points."""
    generator = np.random.default_rng(5)
    normal = np.array([0.1, -0.2, 0.97])
    normal /= np.linalg.norm(normal)
    t = np.sort(generator.uniform(-0.5, 0.5, COUNT))
    sun, observer = (in_plane(generator, COUNT, normal) for _ in range(2))
    given = _given(np.zeros(COUNT), t, sun=sun, observer=observer)
    state = _body(nutation=nutation)
    assert np.abs(_pole_map.plane_of(given) @ normal) == pytest.approx(1.0)
    mirror = _pole_map.mirrored_state(given, state, normal)
    # the plane does not turn: its rates are those of the state
    mirror[0] = state[0]
    upright = mirror.copy()
    upright[16:] = state[16:]
    own, seen, other = (
        _refinement.model(given, each).magnitude for each in (state, mirror, upright)
    )
    assert np.std(seen - own) < 1e-9 < np.std(other - own)
    pole = _ellipsoid.SearchState.of(mirror).pole
    assert pole == pytest.approx(_pole_map.mirrored(state[[7, 10, 13]], normal), abs=1e-12)
    assert np.array_equal(_shapes.inverted(_shapes.inverted(state[16:])), state[16:])


def test_a_state_by_names_is_the_state():
    state = _body()
    own = _ellipsoid.SearchState.of(state)
    assert np.array_equal(own.vector, state) and not own.is_axial
    assert own.rates == (34.6, 9.0)
    assert _ellipsoid.SearchState.of(_body(nutation=9.0)).rates == (25.6, 9.0)
    axial = own._replace(log_rho=_ellipsoid.AXIAL)
    assert axial.is_axial and axial.rates == (34.6, 0.0)
    assert _ellipsoid.have_rates(axial.vector, axial.vector, 0.35)
    assert not _ellipsoid.have_rates(axial.vector, own.vector, 0.35)
    faster = own._replace(precession=own.precession + 0.2)
    assert not _ellipsoid.have_rates(faster.vector, own.vector, 0.35)


def test_poles_with_the_same_rates_contain_the_true_one():
    """From a state at another pole: both rates held, the whole sky."""
    generator = np.random.default_rng(8)
    t = np.sort(generator.uniform(-0.5, 0.5, COUNT))
    turn = 1.4 * t
    sun = np.stack([np.cos(turn), np.sin(turn), 0.2 * np.sin(3.0 * turn)])
    observer = np.stack([np.cos(turn + 0.6), np.sin(turn + 0.6), 0.1 + 0.0 * t])
    sun, observer = (each / np.linalg.norm(each, axis=0) for each in (sun, observer))
    state = _body()[:16]
    state[14:16] = 1.2, 0.5
    given = _given(np.zeros(COUNT), t, sun=sun, observer=observer)
    curve = _ellipsoid.EllipsoidCurve(given)
    curve.costs(state[None])
    magnitude = -(curve.rows[0, :COUNT] / given.root)
    given = _given(magnitude, t, sun=sun, observer=observer)
    away = state.copy()
    away[5:14] = _ellipsoid.frames_of(generator, np.array([[0.6, -0.5, 0.62]]))[0]
    turns = _pole_map.turn_of_scene(given, np.stack([each[[7, 10, 13]] for each in (away, state)]))
    away[0] += 0.5 * (turns[0] - turns[1])
    found = _pole_map.of_rates(
        given, generator, away, _ellipsoid.Held(0.5), _shapes.Tie(), lambda: False
    )
    assert len(found[0]) == _refinement.WIDTH > len(found[1])  # a body, then an ellipsoid
    # with the error of bodies, whatever that of the problem
    settings, held = replace(given.settings, map_poles=6, map_starts=1), _ellipsoid.Held(0.5)
    one, other = (
        _pole_map.of_rates(
            replace(given, model_error=error, settings=settings),
            np.random.default_rng(1), away, held, _shapes.Tie(), lambda: False,
        )
        for error in (0.07, 0.01)
    )  # fmt: skip
    assert len(one) == len(other) > 0 and all(map(np.array_equal, one, other))
    poles = np.array([each[[7, 10, 13]] for each in found[:5]])
    assert np.max(poles @ state[[7, 10, 13]]) > math.cos(math.radians(8.0))


@pytest.mark.slow
def test_the_pole_of_a_body_of_two_lobes_is_found_by_convex_bodies():
    """From these starts ellipsoids leave the pole of this body, which convex ones fit far better.

    Or at the antipode, 9 degrees away, which fits as well: a search starts the images of each pole.
    """
    row = "SAM", 0.5, 60, 30, (2, 6), 3, 0.03
    style = {**dict(zip(families.NAMES, row, strict=True)), "kind": "bilobed"}
    case = mesh_curves.case(30, style)
    curve = families.curve_of(case, "shared")
    problem, _ = _problem.problem(curve, case.most / 86400.0, 0.07, "shared")
    generator = np.random.default_rng(3)
    span = np.ptp(case.jd)
    rates = [_lattices.Candidate(0.5 * span / case.P_phi, -span / case.P_psi)]
    tie, held = _shapes.Tie(), _ellipsoid.Held(problem.settings.tie)
    pool = _ellipsoid.around(problem, generator, rates, 200, iterations=40, tie=held)
    problem = problem.with_model_error(0.03)
    start = _refinement.refine(problem, pool.states[0], tie=tie).fitted.state
    rough = problem.with_model_error(0.07)
    states = _pole_map.of_rates(rough, generator, start, held, tie, lambda: False)
    quick = _pole_map.in_few_steps(rough, generator, start, held, tie)
    true = matrix_to_icrf("ecliptic") @ case.pole
    costs, cosines = [], []
    of_bodies = [each for each in states if len(each) == _refinement.WIDTH]
    of_ellipsoids = [each for each in states if len(each) < _refinement.WIDTH]
    for chosen in (of_bodies[:12], of_ellipsoids[:12], [body.state for body in quick[:3]]):
        bodies = [_refinement.refine(problem, each, tie=tie).fitted for each in chosen]
        best = min(bodies, key=lambda body: body.cost)
        costs.append(best.cost)
        cosines.append(abs(best.state[[7, 10, 13]] @ true))
    assert max(costs[0], costs[2]) + 60.0 < costs[1]
    assert min(cosines[0], cosines[2]) > math.cos(math.radians(10.0)) > cosines[1]


def test_additive_pairs_of_rotation_and_dips():
    """Two unlike eclipses an orbit beside rotation, and a tumbler, which no sum explains."""
    generator = np.random.default_rng(2)
    t = np.sort(generator.uniform(-0.5, 0.5, 600))
    rotation, orbit = 61.37, 13.21
    turned = 0.2 * np.cos(4.0 * math.pi * rotation * t) + 0.1 * np.sin(2.0 * math.pi * rotation * t)
    phase = np.mod(orbit * t, 1.0)
    dips = 0.2 * (np.abs(phase - 0.2) < 0.06) + 0.12 * (np.abs(phase - 0.7) < 0.06)
    noise = 0.01 * generator.normal(size=600)
    best = _satellites.additive_pairs(_given(turned + dips + noise, t), 90.0)[0]
    assert best.rotation == pytest.approx(rotation, abs=0.05) or best.rotation == pytest.approx(
        2.0 * rotation, abs=0.1
    )
    assert best.orbit == pytest.approx(orbit, abs=0.05) and best.left < 0.03
    assert best.are_dips and best.range == pytest.approx(0.2, abs=0.12)
    product = 0.3 * np.cos(2.0 * math.pi * 61.37 * t) * np.cos(2.0 * math.pi * 13.21 * t)
    tumbling = _given(turned * (1.0 + 3.0 * product) + product, t)
    assert all(pair.left > 0.1 for pair in _satellites.additive_pairs(tumbling, 90.0))
    pair = _satellites._fitted(tumbling, rotation, orbit)
    assert pair.left > 0.1
    alone = _satellites.of_series(tumbling, pair.rotation)
    assert _satellites.brightening(_satellites.beside(tumbling, pair, alone), alone) > 0.35


def _eclipses(generator, rotation, orbit, depths, size=0.2):
    """Magnitudes of a rotation and of two dips of given depths an orbit, 700 points."""
    t = np.sort(generator.uniform(-0.5, 0.5, 700))
    turned = size * np.cos(4.0 * math.pi * rotation * t) + 0.1 * size * np.sin(
        2.0 * math.pi * rotation * t
    )
    phase = np.mod(orbit * t, 1.0)
    dips = sum(
        depth * np.exp(-(((phase - at) / 0.03) ** 2))
        for at, depth in zip((0.2, 0.7), depths, strict=True)
    )
    return _given(turned + dips + 0.01 * generator.normal(size=700), t)


def test_rotation_is_found_beside_deep_dips():
    """Eclipses of 0.6 mag hide the lines of a rotation of 0.03 mag."""
    given = _eclipses(np.random.default_rng(6), 71.3, 9.7, (0.6, 0.3), size=0.03)
    lines = _satellites._rotations(given, 100.0)
    assert min(np.abs(lines - ratio * 71.3).min() for ratio in (0.5, 1.0, 2.0)) > 1.0
    best = _satellites.rivals(given, 100.0, 4)[0]
    # the bodies that follow have this rate, half of it, and twice
    assert min(abs(best.rotation - ratio * 71.3) for ratio in (0.5, 1.0, 2.0)) < 0.1
    assert best.orbit == pytest.approx(9.7, abs=0.05)


def test_dips_may_be_all_that_a_rotation_explains():
    """Near its rate the orbit, 0.1 turns off, and the rotation that the dips leave."""
    given = _eclipses(np.random.default_rng(6), 71.3, 9.7, (0.6, 0.3), size=0.03)
    pairs = _satellites.rivals(given, 100.0, 4, 9.8)
    assert all(pair.orbit == pytest.approx(9.7, abs=0.05) for pair in pairs)
    ratios = np.array([pair.rotation for pair in pairs])[:, None] / (71.3 * np.array([0.5, 1, 2]))
    assert np.abs(ratios - 1.0).min() < 2e-3


def test_the_rates_beside_an_orbit_have_lines_that_its_dips_hide():
    """A pair with another rotation has the orbit: the rotation is among the rates to try."""
    given = _eclipses(np.random.default_rng(6), 71.3, 9.7, (0.6, 0.3), size=0.03)
    pair = _satellites.AdditivePair(55.0, 9.7, 0.1)
    problem = _satellites.beside(given, pair, _satellites.of_series(given, pair.rotation))
    others = np.array([55.0, 27.5, 250.0])
    assert np.abs(_satellites.rates_beside(given, others, 100.0) - 71.3).min() > 1.0
    rates = _satellites.rates_beside(problem, others, 100.0)
    assert np.abs(rates - 71.3).min() < 0.2
    # the others up to twice the largest frequency, each once
    assert 55.0 in rates and 27.5 in rates and rates.max() < 200.0
    assert np.diff(rates).min() > 0.3


def test_no_rate_beside_an_orbit_is_on_its_comb():
    """Three times and twice a frequency explain its dips together, one of them as a rotation."""
    given = _eclipses(np.random.default_rng(6), 71.3, 9.7, (0.6, 0.3), size=0.03)
    pair = _satellites.AdditivePair(71.3, 1.5 * 9.7, 0.1)
    problem = _satellites.beside(given, pair, _satellites.of_series(given, pair.rotation))
    rates = _satellites.rates_beside(problem, np.array([9.7, 2.0 * 9.7, 25.0, 55.0]), 100.0)
    assert {25.0, 55.0} <= set(rates)
    assert all(np.abs(rates - ratio * 9.7).min() > 0.9 for ratio in (1.0, 1.5, 2.0, 3.0, 6.0))


@pytest.mark.parametrize("depths", [(0.3, 0.3), (0.3, 0.12)])
@pytest.mark.parametrize("factor", [1.0 / 3.0, 0.5, 1.0, 2.0])
def test_an_orbit_has_two_eclipses(depths, factor):
    """Whichever multiple of the frequency the series was found at."""
    given = _eclipses(np.random.default_rng(5), 61.37, 13.21, depths)
    pair = _satellites._fitted(given, 61.37, factor * 13.21)
    assert _satellites.with_orbit(given, pair).orbit == pytest.approx(13.21, abs=0.05)
    # without frequencies about it, this one ends 0.04 off
    off = _satellites.AdditivePair(61.37, factor * 13.01, 1.0)
    assert _satellites.with_orbit(given, off).orbit == pytest.approx(13.21, abs=0.03)


def test_dips_may_change_over_the_span():
    """Eclipses that end, every second one deeper: twice the period must not replace the change."""
    generator = np.random.default_rng(7)
    t = np.sort(generator.uniform(-0.5, 0.5, 700))
    turned = 0.1 * np.cos(4.0 * math.pi * 61.37 * t)
    phase = np.mod(13.21 * t, 1.0)
    dips = sum(
        depth * (0.5 - t) * np.exp(-(((phase - at) / 0.03) ** 2))
        for at, depth in ((0.2, 0.5), (0.7, 0.3))
    )
    given = _given(turned + dips + 0.01 * generator.normal(size=700), t)
    pair = _satellites.rivals(given, 90.0, 4)[0]
    assert pair.orbit == pytest.approx(13.21, abs=0.05) and pair.left < 0.05
    alone = _satellites.of_series(given, pair.rotation)
    changing = _satellites.beside(given, pair, alone)
    assert _satellites.brightening(changing, alone) < 0.35
    half = len(changing.prior) // 2
    lasting = given.with_terms(
        changing.terms[:, : half + 1], changing.prior[: half + 1], pair.orbit
    )

    def left(problem):
        return np.sum(problem.projected(problem.y) ** 2)

    assert left(changing) < left(lasting) - 100.0


@pytest.mark.parametrize("orbit", [13.37, 26.78])
def test_shallow_dips_are_found_beside_a_body_seen_from_many_sides(orbit):
    """Its aspect changes, which the series of a rotation does not: dips of 0.06 mag are less."""
    generator = np.random.default_rng(11)
    t = np.sort(generator.uniform(-0.5, 0.5, 600))
    sun, observer = (
        np.stack([np.cos(2.0 * t + ahead), np.sin(2.0 * t + ahead), np.full(600, 0.2)])
        for ahead in (0.0, 0.5)
    )
    given = _given(np.zeros(600), t, 0.01, sun / math.sqrt(1.04), observer / math.sqrt(1.04))
    body = np.zeros(_refinement.WIDTH)
    body[:16] = _ellipsoid.starts(generator, np.array([60.4]), np.array([-1.0]))[0]
    body[2:5] = 0.0, _ellipsoid.AXIAL, 0.0
    body[16:] = 0.3 * generator.normal(size=_shapes.MODES)
    phase = np.mod(orbit * t, 1.0)
    dips = sum(0.06 * np.exp(-(((phase - at) / 0.04) ** 2)) for at in (0.2, 0.7))
    noise = 0.01 * generator.normal(size=600)
    magnitude = _refinement.model(given, body).magnitude + dips + noise
    given = replace(given, magnitude=magnitude, model_error=0.03)
    fixed = np.zeros(_refinement.SIZE, bool)
    fixed[:8] = _ellipsoid.AXIAL_FIXED[:8]
    fit = _refinement.refine(given, body, fixed=fixed).fitted
    alone = _satellites.of_body(given, fit, _shapes.Tie(), fixed)
    best = _satellites.orbits_beside(alone)[0]
    assert best.orbit == pytest.approx(orbit, abs=0.06)
    assert _satellites.brightening(_satellites.beside(given, best, alone), alone) < 0.35
    assert all(abs(pair.orbit - orbit) > 1.0 for pair in _satellites.rivals(given, 2.0 * 60.4, 4))


def test_rates_of_bodies_are_those_of_all_pairs():
    pairs = [_satellites.AdditivePair(rate, 3.0, 0.1) for rate in (10.0, 30.1)]
    expected = [5.0, 10.0, 15.0, 20.0, 30.0, 45.15, 60.2, 90.3]
    assert np.allclose(_satellites.rates_of(pairs), expected)


def test_a_body_with_an_orbit_predicts_its_dips():
    t = np.linspace(-0.5, 0.5, COUNT)
    pair, empty = _satellites.AdditivePair(20.0, 7.0, 0.5), _given(np.zeros(COUNT), t)
    given = _satellites.beside(empty, pair, _satellites.of_series(empty, pair.rotation))
    assert given.orbit == 7.0 and given.with_model_error(0.1).orbit == 7.0
    assert np.array_equal(given.terms[:, 1:], _satellites.changing(7.0, t))
    lasting = _satellites.series(7.0, _satellites.DIPS, t)
    assert np.array_equal(given.terms[:, 1 : 1 + lasting.shape[1]], lasting)
    assert np.all(given.prior[1:] <= max(_satellites._AMPLITUDES))


@pytest.mark.parametrize(("size", "change"), [(0.05, 0.125), (0.025, 1.0)])
def test_the_likeliest_widths_are_those_of_the_amplitudes(size, change):
    generator = np.random.default_rng(8)
    t = np.sort(generator.uniform(-0.5, 0.5, 900))
    deviations = _satellites._deviations(size, change, 8.0)
    amplitudes = deviations * generator.normal(size=len(deviations))
    y = _satellites.changing(13.21, t) @ amplitudes + 0.005 * generator.normal(size=900)
    given = _given(y + 0.1 * np.cos(4.0 * math.pi * 61.37 * t), t)
    alone = _satellites.of_series(given, 61.37)
    pair = _satellites.AdditivePair(61.37, 13.21, 0.1)
    prior = _satellites.beside(given, pair, alone).prior[1:]
    assert np.all(np.abs(np.log2(prior / deviations)) < 1.5)


def test_points_off_both_neighbours_hardly_count():
    generator = np.random.default_rng(4)
    t = np.sort(generator.uniform(-0.5, 0.5, 3000))
    clean = 0.3 * np.cos(2.0 * math.pi * 40.0 * t) + 0.02 * generator.normal(size=3000)
    wild = generator.choice(3000, 60, replace=False)
    y = clean.copy()
    y[wild] += generator.choice([-1.0, 1.0], 60) * generator.uniform(0.4, 1.0, 60)
    given, count = _neighbours.without_outliers(_given(y, t), 40.0)
    enlarged = np.flatnonzero(given.sigma > 0.021)
    assert count == len(enlarged) and len(np.intersect1d(enlarged, wild)) > 50
    assert len(np.setdiff1d(enlarged, wild)) < 4
    same, none = _neighbours.without_outliers(_given(clean, t), 40.0)
    assert none == 0 and np.all(same.sigma == 0.02)


@pytest.mark.parametrize("factor", [1.0, 2.0])
def test_noise_from_neighbouring_residuals(factor):
    """Not the smooth error of a model, 0.03 mag, which is larger than the errors."""
    generator = np.random.default_rng(6)
    t = np.sort(generator.uniform(-0.5, 0.5, 2000))
    residual = 0.03 * np.cos(2.0 * math.pi * 40.0 * t)
    residual += factor * 0.02 * generator.normal(size=2000)
    found = _neighbours.noise(_given(residual, t), residual, 40.0)
    assert found == pytest.approx(np.full(2000, factor), rel=0.08)
    assert np.all(_neighbours.noise(_given(residual, t), residual, 40000.0) == 1.0)


@pytest.mark.parametrize(("common", "expected"), [(0.0, 1.0), (0.2, 1.0), (0.7, 17.0 / 3.0)])
def test_correlated_residuals_count_as_fewer_points(common, expected):
    """Residuals of two parts, one of which neighbours have in common, a share of the variance."""
    generator = np.random.default_rng(11)
    t = np.linspace(-0.5, 0.5, 2000)
    residual = math.sqrt(common) * np.sum(
        [
            np.cos(2.0 * math.pi * (rate * t + phase))
            for rate, phase in generator.uniform(20.0, 40.0, (2, 2))
        ],
        axis=0,
    )
    residual += math.sqrt(1.0 - common) * generator.normal(size=2000)
    one = _weighted(0.0, 0.0, 1.0, 0.05 * residual)
    assert _evidence.redundancy(one, _given(residual, t)) == pytest.approx(expected, rel=0.25)


@pytest.mark.parametrize(
    ("size", "share", "is_rotation"), [(0.015, 0.9, True), (0.015, 1.1, False), (0.05, 0.5, False)]
)
def test_tumbling_loses_what_correlated_residuals_give(size, share, is_rotation):
    """Of (135) Hertha, which rotates in 8.40 h, a tumbling state was 22 ahead; above the floor
    nothing is said of where the correlation comes from.
    """
    generator = np.random.default_rng(11)
    t = np.linspace(-0.5, 0.5, 2000)
    noise = math.sqrt(0.3) * generator.normal(size=2000)
    waves = [np.cos(2.0 * math.pi * rate * t) for rate in generator.uniform(20.0, 40.0, 2)]
    residual = size * (math.sqrt(0.7) * np.sum(waves, axis=0) + noise)
    given, rotation = _given(residual, t), _weighted(0.0, 0.0, 1.0, residual)
    tumbling = _weighted(-9.0, 0.0, 1.0, size * noise)
    lost = _evidence.gain(tumbling, rotation, given)
    lost *= 1.0 - 1.0 / _evidence.redundancy(rotation, given)
    tumbling = replace(tumbling, evidence=-share * lost)
    solutions = _verdicts.behind_correlated([tumbling, rotation], given)
    best = _evidence.ranked(solutions)[0].refined.state
    assert _ellipsoid.is_axial(best) == is_rotation
    assert (solutions[0] is tumbling) == (not is_rotation)
    # nor is that part of the margin of a claim
    least = _verdicts.needed(tumbling, given) + DEFAULT.against_axis
    _, behind = _verdicts._nearest([rotation], tumbling, given)
    assert behind == pytest.approx(least + (lost if size < 0.02 else 0.0))


@pytest.mark.parametrize(("is_far", "expected"), [(True, 0.0), (False, 200.0)])
def test_points_far_from_others_say_nothing_of_a_moon(is_far, expected):
    """79 points of surveys of (135) Hertha, noisier than assumed, had the dips of one."""
    t = np.concatenate([np.linspace(-0.5, -0.45, 300), np.linspace(0.01, 0.99, 100)])
    assert len(t) == COUNT
    residual = np.where((t > 0.0) == is_far, 0.06, 0.0)
    given = _given(np.zeros(COUNT), t)
    search = _search_of(given, solutions=[_weighted(-9.0, 0.0, 1.0, residual)])
    rotation = _weighted(0.0, -200.0, 1.0)
    rotation, best = (replace(one, problem=given) for one in (rotation, search.solutions[0]))
    search.solutions = [best]
    search.rival = SimpleNamespace(
        evidence=lambda: -200.0, problem=replace(given, orbit=20.0), solutions=[rotation]
    )
    search.evidence = lambda: 0.0
    ahead = search.satellite_is_ahead()
    assert ahead == pytest.approx(expected) if expected else ahead < 0.0
    assert _neighbours.are_close(given, 20.0)[[0, 299]].all()


def test_each_night_has_its_own_noise():
    """Ten nights of 60 points, of which the seventh is three times as noisy as its errors say."""
    generator = np.random.default_rng(9)
    night = np.repeat(np.arange(10), 60)
    t = (night + np.tile(np.linspace(0.0, 0.2, 60), 10)) / 10.0 - 0.5
    residual = 0.02 * np.where(night == 6, 3.0, 1.0) * generator.normal(size=600)
    found = _neighbours.noise(_given(residual, t, span=10.0 * 86400.0), residual, 20.0)
    assert found[night == 6] == pytest.approx(np.full(60, 3.0), rel=0.5)
    assert np.all(found[night == 6] == found[night == 6][0])
    assert found[night != 6].max() < 1.3


def test_neighbours_are_of_one_session():
    """Two observers in one night, 0.5 mag apart, take turns."""
    t = np.linspace(-0.5, 0.5, 400)
    observer = np.arange(400) % 2
    y = 0.5 * observer + 0.02 * np.random.default_rng(3).normal(size=400)
    apart = replace(_given(y, t), series=observer)
    assert _neighbours.noise(apart, y, 1.0) == pytest.approx(np.full(400, 1.0), rel=0.2)
    assert _neighbours.noise(_given(y, t), y, 1.0).min() > 10.0
    assert np.all(apart.part(observer == 1).series == 1)


@pytest.mark.parametrize(("error", "expected"), [(1.0, 5.0), (3.0, 1.0)])
def test_scatter_of_a_survey(error, expected):
    """Points far apart with five times their errors, beside nights with right errors or not."""
    generator = np.random.default_rng(5)
    nights = (np.repeat(np.arange(10), 40) + np.tile(np.linspace(0.0, 0.2, 40), 10)) / 10.0 - 0.5
    t = np.concatenate([nights, np.linspace(-0.5, 0.5, 100)])
    series = np.repeat([0, 1], [400, 100])
    size = math.hypot(0.02, DEFAULT.floor_error)
    residual = size * np.repeat([0.9 * error, 5.0], [400, 100]) * generator.normal(size=500)
    given = replace(_given(residual, t), series=series)
    factors = _neighbours.scatter(given, residual, 20.0)
    assert np.all(factors[:400] == 1.0)
    assert factors[400:] == pytest.approx(np.full(100, expected), rel=0.15)


def _weighted(nutation, evidence, chi_squared, residual=None):
    residual = np.zeros(COUNT) if residual is None else residual
    state = _body(nutation=nutation)
    if nutation == 0.0:
        state[3] = _ellipsoid.AXIAL
    refined = SimpleNamespace(state=state, strain=0.0)
    return _evidence.Weighted(refined, None, evidence, residual, chi_squared)


@pytest.mark.parametrize(
    ("nutation", "chi_squared", "expected"),
    [
        (-17.3, 1.0, 101.0),  # P_psi is twice the period of the rotation
        (-34.6, 1.0, 101.0),
        (-9.0, 1.0, 0.0),  # no comb
        (-17.5, 1.0, 0.0),  # lines 0.4 turns per span apart are two
        (-17.4, 1.0, 101.0),  # 0.2 are one
        (-17.3, 0.2, 0.0),  # the rotation does not explain the curve
    ],
)
def test_a_tumbler_on_the_comb_of_a_rotator_counts_as_it(nutation, chi_squared, expected):
    found = [_weighted(nutation, 0.0, chi_squared), _weighted(0.0, 100.0, 1.0)]
    ranked = _verdicts.as_rotators(found, _given(np.zeros(COUNT)))
    assert [each.evidence for each in ranked] == [expected, 100.0]


@pytest.mark.parametrize(("precession", "expected"), [(17.3, 101.0), (25.95, 0.0), (34.6, 101.0)])
def test_half_a_turn_about_the_momentum_is_no_comb(precession, expected):
    """A tumbling body with P_psi 3.004 P_phi was held behind a rotation of 3/2 P_phi."""
    found = [_weighted(-17.3, 0.0, 1.0), _weighted(0.0, 100.0, 1.0)]
    found[0].refined.state[0] = precession
    ranked = _verdicts.as_rotators(found, _given(np.zeros(COUNT)))
    assert [each.evidence for each in ranked] == [expected, 100.0]


@pytest.mark.parametrize(
    ("size", "of_rotation", "expected"),
    [
        (0.018, 0.026, 0.0),  # the rotation leaves more than the errors, and is far less likely
        (0.018, 0.020, 101.0),
        (0.030, 0.040, 101.0),  # neither explains the curve
    ],
)
def test_a_rotation_above_the_errors_takes_no_comb(size, of_rotation, expected):
    signs = np.where(np.arange(COUNT) % 2, 1.0, -1.0)
    found = [
        _weighted(-17.3, 0.0, 1.0, size * signs),
        _weighted(0.0, 100.0, 1.0, of_rotation * signs),
    ]
    given = _given(np.zeros(COUNT))
    ranked = _verdicts.as_rotators(found, replace(given, sigma=np.full(COUNT, 0.02)))
    assert [each.evidence for each in ranked] == [expected, 100.0]


@pytest.mark.parametrize(
    ("evidence", "nutation", "expected"),
    [
        (10.0, -17.5, 0.0),  # the same rates as seen, about another pole, ahead of the rotation
        (110.0, -17.5, 101.0),  # behind it
        (10.0, -15.0, 101.0),  # other rates
    ],
)
def test_poles_of_one_pair_of_rates_are_all_on_a_comb_or_none(evidence, nutation, expected):
    """The pole that fits best was set behind the rotation, and another one was called solved."""
    found = [
        _weighted(-17.3, 0.0, 1.0),
        _weighted(nutation, evidence, 1.0),
        _weighted(0.0, 100.0, 1.0),
    ]
    ranked = _verdicts.as_rotators(found, _given(np.zeros(COUNT)))
    assert [each.evidence for each in ranked] == [expected, evidence, 100.0]


@pytest.mark.parametrize(("turns", "expected"), [(0.0, 101.0), (0.3, 101.0), (-0.3, 0.0)])
def test_a_comb_is_that_of_the_lines_that_the_scene_sees(turns, expected):
    """A precession that is 0.2 above the comb, from a scene that turns about the momentum."""
    found = [_weighted(-17.2, 0.0, 1.0), _weighted(0.0, 100.0, 1.0)]
    pole = found[0].refined.state[_ellipsoid.OF_POLE]
    first = np.cross(pole, [0.0, 0.6, 0.8])
    first /= np.linalg.norm(first)
    angle = 2.0 * np.pi * turns * np.linspace(-0.5, 0.5, COUNT)
    scene = np.outer(first, np.cos(angle)) + np.outer(np.cross(pole, first), np.sin(angle))
    given = _given(np.zeros(COUNT), sun=scene, observer=scene)
    assert _pole_map.turn_of_scene(given, pole[None]) == pytest.approx([turns], abs=1e-6)
    assert _verdicts.as_rotators(found, given)[0].evidence == expected


@pytest.mark.parametrize(
    ("maxima", "turns", "needed"),
    [
        (1, 2.0, 120.0),  # half the period, of one maximum
        (2, 2.0, 13.0),  # of two, as most bodies
        (1, 1.7, 13.0),  # another period
    ],
)
def test_half_a_period_of_one_maximum_needs_more(maxima, turns, needed):
    """Half of 2.16 h was claimed, 13.2 ahead: simple shapes fit half of a curve of two maxima."""
    generator = np.random.default_rng(4)
    t = np.linspace(-0.5, 0.5, COUNT)
    given = _given(np.zeros(COUNT), t)
    best, other = _weighted(0.0, 0.0, 1.0), _weighted(0.0, 14.0, 1.0)
    rate = SearchState.of(best.refined.state).rates[0]
    best.refined.magnitude = 0.2 * np.cos(2.0 * np.pi * maxima * rate * t)
    other.refined.state[0] /= turns
    residual = 0.01 * generator.normal(size=COUNT)
    both = [replace(one, residual=residual) for one in (best, other)]
    assert _verdicts._nearest(both[1:], both[0], given) == (14.0, needed)
    best = SimpleNamespace(is_axial=True, P_phi=3.0, weighted=replace(best, problem=given))
    beyond = [_spin_states._has_half_the_turns(best, longest) for longest in (5.9, 6.1)]
    assert beyond == [maxima == 1, False]


@pytest.mark.parametrize(
    ("nutation", "strains", "needed"),
    [
        (-9.0, (3.8, 31.3), 40.5),  # what the tie takes from the other one does not count
        (-9.0, (3.8, 1.0), 13.0),  # nor for it what it takes from the best one
        (0.0, (0.0, 31.3), 13.0),  # rotation about one axis is not tied to moments
    ],
)
def test_a_difference_that_the_tie_of_moments_makes_is_none(nutation, strains, needed):
    """A wrong needle was claimed, 39.6 ahead of the true one, whose body is concave."""
    found = [_weighted(nutation, 0.0, 1.0), _weighted(-14.0, 39.6, 1.0)]
    residual = 0.01 * np.random.default_rng(4).normal(size=COUNT)
    for one, strain in zip(found, strains, strict=True):
        one.refined.strain = strain
    best, other = (replace(one, residual=residual) for one in found)
    given = _given(np.zeros(COUNT))
    assert _verdicts._nearest([other], best, given) == (39.6, pytest.approx(needed))


@pytest.mark.parametrize(
    ("maxima", "size", "expected"),
    [
        (1, 0.01, [29.0, 32.0, 28.0, 5.0]),  # twice the period fits as well
        (1, 0.012, [0.0, 3.0, 28.0, 5.0]),  # it fits worse
        (2, 0.01, [0.0, 3.0, 28.0, 5.0]),
    ],
)
def test_one_maximum_a_turn_stands_behind_two_that_fit_as_well(maxima, size, expected):
    """Half of 7.2 h was 28 ahead by its simple shape alone."""
    signs = np.where(np.arange(COUNT) % 2, 1.0, -1.0)
    t = np.linspace(-0.5, 0.5, COUNT)
    given = replace(_given(np.zeros(COUNT), t), sigma=np.full(COUNT, 0.01))
    found = [
        _weighted(0.0, 0.0, 1.0, 0.01 * signs),
        _weighted(0.0, 3.0, 1.0, 0.01 * signs),
        _weighted(0.0, 28.0, 1.0, size * signs),
        _weighted(-9.0, 5.0, 1.0, 0.01 * signs),
    ]
    rate = SearchState.of(found[0].refined.state).rates[0]
    found[0].refined.magnitude = 0.2 * np.cos(2.0 * np.pi * maxima * rate * t)
    found[2].refined.state[0] /= 2.0
    ranked = _verdicts.behind_twice_the_period(found, given)
    assert [one.evidence for one in ranked] == expected
    assert _verdicts.behind_twice_the_period(found[3:], given) == found[3:]


def test_rates_many_turns_apart_are_not_one():
    """None of the drifts near zero keeps the angle: which of them is best is chance."""
    generator = np.random.default_rng(12)
    state, other = _body(), _body()
    for _ in range(30):
        t = np.sort(generator.uniform(-0.5, 0.5, 60))
        given = _given(np.zeros(60), t)
        other[0] = state[0] + generator.uniform(2.0, 30.0)
        assert not _pole_map.has_turn(given, state, other)
        assert _pole_map.has_turn(given, state, state)


def test_a_difference_counts_by_nights():
    """Residuals alike within nights: their difference has the error of its parts."""
    generator = np.random.default_rng(1)
    nights = np.repeat(np.arange(40.0), 10) + np.tile(np.arange(10) * 0.01, 40)
    given = _given(np.zeros(COUNT), nights / 40.0 - 0.5, span=40.0 * 86400.0)
    common = np.repeat(0.02 * generator.normal(size=40), 10)
    one, other = (_weighted(-9.0, 0.0, 1.0, r) for r in (common, np.roll(common, 10)))
    alone = 0.02 * generator.normal(size=COUNT)
    two, three = (_weighted(-9.0, 0.0, 1.0, r) for r in (alone, np.roll(alone, 10)))
    correlated = _evidence.standard_error(one, other, given)
    independent = _evidence.standard_error(two, three, given)
    # ten points of one night count as one
    assert correlated / independent == pytest.approx(math.sqrt(10.0), rel=0.35)
    worse = _weighted(-9.0, 20.0, 1.0, np.roll(common, 10))
    turned = worse.refined.state.copy()
    turned[5:14] = np.roll(turned[5:14].reshape(3, 3), 1, axis=1).ravel()
    worse = replace(worse, refined=SimpleNamespace(state=turned))
    assert _verdicts._competes(worse, one, given)


def test_the_width_of_the_prior_of_modes_is_the_most_probable_one():
    """Gaussian densities, whose evidence is exact: by integrals over all parameters."""
    generator = np.random.default_rng(3)
    size = _refinement.SIZE
    modes = np.arange(_refinement.MOTION + _shapes.ELLIPSOID, size)
    jacobian = generator.normal(size=(60, size))
    free = np.zeros(size, bool)

    def evidence(values, scale):
        """-2 ln of the integral of exp(-|y - J x|^2/2) times the prior, but for a constant."""
        prior = np.zeros(size)
        prior[_refinement.MOTION :] = _shapes.widths(is_axial=False) ** -2.0
        prior[modes] /= scale**2
        normal = jacobian.T @ jacobian + np.diag(prior)
        best = np.linalg.solve(normal, jacobian.T @ values)
        cost = np.sum((values - jacobian @ best) ** 2) + prior @ best**2
        volume = _evidence.occam(normal, 1) + 2.0 * len(modes) * math.log(scale)
        return cost + volume, best, normal

    for spread, is_narrow in ((0.2, True), (3.0, False)):
        shape = spread * generator.normal(size=size)
        values = jacobian @ shape + 0.1 * generator.normal(size=60)
        wide, best, normal = evidence(values, 1.0)
        state = np.zeros(_refinement.WIDTH)
        state[14:] = best[_refinement.MOTION :]
        fitted = SimpleNamespace(state=state, normal=normal)
        expected = min(0.0, *(evidence(values, scale)[0] - wide for scale in (0.7, 0.5)))
        change = _evidence.of_narrower_prior(fitted, free)
        assert change == pytest.approx(expected, abs=1e-6)
        assert (change < -5.0) == is_narrow
        held = free.copy()
        held[10:] = True
        assert _evidence.of_narrower_prior(fitted, held) == 0.0


def test_a_prior_decides_on_no_pole():
    """Poles called solved were wrong: mirror images 15 and 22 ahead, 5 and 16 in likelihood."""
    given, signs = _given(np.zeros(COUNT)), np.resize([1.0, -1.0], COUNT)

    def other(nutation, size, degrees, behind):
        angle, entry = math.radians(degrees), _weighted(nutation, behind, 1.0, size * signs)
        c, s = math.cos(angle), math.sin(angle)
        state = entry.refined.state.copy()
        turn = np.array([[1, 0, 0], [0, c, -s], [0, s, c]])
        state[5:14] = (turn @ state[5:14].reshape(3, 3)).ravel()
        return replace(entry, refined=SimpleNamespace(state=state))

    for nutation, size, degrees, behind, likely, competes in (
        (-9.0, 0.0101, 120.0, 15.4, True, True),
        (-9.0, 0.0101, 10.0, 15.4, True, False),  # a neighbour
        (-9.0, 0.0101, 120.0, 24.1, True, False),  # its shape is too improbable
        (-9.0, 0.02, 120.0, 15.4, False, False),  # fits worse
        (-9.0, 0.0108, 120.0, 22.4, False, True),  # 16 in likelihood
        (0.0, 0.0108, 120.0, 22.4, False, False),  # where it decides about one axis
    ):
        best = _weighted(nutation, 0.0, 1.0, 0.01 * signs)
        alone = other(nutation, size, degrees, behind)
        assert (_evidence.gain(best, alone, given) < 9.5) == likely
        assert _verdicts._competes(alone, best, given) == competes


def test_the_symmetry_of_a_shape():
    angle = 2.0 * math.pi * np.arange(48) / 48
    ring = np.stack([1.2 * np.cos(angle), 1.2 * np.sin(angle), 0.0 * angle], axis=-1)
    for top, can_turn_over in ((1.0, True), (0.5, False)):
        points = np.concatenate(
            [ring - [0, 0, 4], ring * [top, top, 1] + [0, 0, 4], [[0, 0, -4], [0, 0, 4]]]
        )
        facets = []
        for i in range(48):
            j = (i + 1) % 48
            facets += [(i, j, 48 + j), (i, 48 + j, 48 + i), (96, j, i), (97, 48 + i, 48 + j)]
        mesh = Mesh(points, np.array(facets))
        body = Body.from_shape(mesh, density=1.0)
        known = _shapes.known(mesh, LommelSeeligerLambert(c=0.1, a=0.0, k=0.0))
        known = known.over(body.principal_axes)
        symmetry = _known.symmetry_of(known, body.moments, 0.05)
        long_axis = int(np.argmin(body.moments))
        assert symmetry == (long_axis, can_turn_over)
    brick = box((2.0, 1.0, 1.0))
    known = _shapes.known(brick, None)
    moments = Body.from_shape(brick, density=1.0).moments
    assert _known.symmetry_of(known, moments, 0.05).axis is None


def test_a_known_sum_over_facets_with_shadows():
    """Two walls of a corner: the forward model of the families hides what a ray meets."""
    points, facets = mesh_curves.icosphere(2)
    solid = mesh_curves.Solid.of(points * [1.0, 0.7, 0.5], facets, False)
    up = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0]])
    alone = solid.flux(up, up)
    # the moments of an ellipsoid: (b^2 + c^2)/(a^2 + b^2) and (a^2 + c^2)/(a^2 + b^2)
    assert solid.moments == pytest.approx([0.74 / 1.49, 1.25 / 1.49, 1.0], rel=2e-3)
    # seen from above a sphere of 0.6 above hides the body, from its side it does not
    moon = np.array([[0.0, 0.0, 3.0], [0.0, 0.0, 3.0]])
    both = solid.flux(up, up, moon, 1.2)
    own = mesh_curves.Solid.of(*mesh_curves.icosphere(2), False)
    sphere = own.flux(up, up) * (4.0 * math.pi * 1.2**2 / own.areas.sum())
    assert both[0] == pytest.approx(sphere[0], rel=0.01)
    assert both[1] == pytest.approx(sphere[1] + alone[1], rel=0.01)


def test_numbers_of_poles_do_not_hide_each_other():
    rng = np.random.default_rng(0)
    poles = [tuple(each) for each in rng.uniform((0.0, -90.0), (360.0, 90.0), (40, 2)).tolist()]
    poles += [(100.0, 10.0), (101.0, 11.0), (100.5, 10.0), (100.0, 9.0)]
    places = _figures.free_places(poles)
    shown = [each for each in places if each is not None]
    assert places[0] is not None and 15 < len(shown) < len(poles)
    for k, one in enumerate(shown):
        assert 0.0 < one[0] < 360.0 and abs(one[1]) < 90.0
        for other in shown[:k]:
            assert abs(one[0] - other[0]) > 18.0 or abs(one[1] - other[1]) > 12.0


def test_rates_are_mapped_again_where_the_best_pole_is_another():
    """The shape at a wrong pole left the true one out of the first map (`nonconvex` 161010)."""
    generator = np.random.default_rng(2)
    first, second, third = _ellipsoid.starts(generator, np.full(3, 17.3), np.full(3, 5.0))
    axes = np.eye(3)
    for state, order in ((first, (0, 1, 2)), (second, (1, 2, 0)), (third, (2, 0, 1))):
        state[5:14] = axes[:, order].ravel()
    search = SimpleNamespace(
        is_over=False,
        settings=inversion.Settings(),
        has_rates=lambda one, other: bool(one[0] == other[0]),
        _mapped_rates=[],
    )
    is_to_be_mapped = _search.Search._is_to_be_mapped
    assert is_to_be_mapped(search, first)
    search._mapped_rates.append(first)
    assert not is_to_be_mapped(search, first) and is_to_be_mapped(search, second)
    search._mapped_rates.append(second)
    assert not is_to_be_mapped(search, third)
    third[0] = 16.0
    assert is_to_be_mapped(search, third)
    search.is_over = True
    assert not is_to_be_mapped(search, third)
