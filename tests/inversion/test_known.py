"""Spin states of a body of known shape, moments that are given, and errors by the jackknife."""

import pickle
from types import SimpleNamespace

import numpy as np
import pytest

from attitude import Body, FreeRotation, Spin, inversion, light_curve
from attitude._support.constants import ASTRONOMICAL_UNIT_M
from attitude.epochs._instants import Instant
from attitude.errors import AttitudeError
from attitude.frames import quaternion
from attitude.inversion import (
    _ellipsoid,
    _errors,
    _known,
    _motions,
    _moving,
    _problem,
    _refinement,
    _shapes,
    _states,
)
from attitude.scattering import Material, Materials
from attitude.shape import box_wing
from tests.support.inversion_geometry import ellipsoid_state, geometry

MESH = box_wing((3.0, 2.0, 1.2), (4.0, 1.5), gap=0.5, wings=1, wing_angle=0.5, thickness=0.1)
LAW = Materials(
    {
        "body": Material(0.25, 0.35, exponent=40.0),
        "panel front": Material(0.05, 0.25, exponent=60.0),
        "panel back": Material(0.3, 0.05, exponent=30.0),
        "panel edge": Material(0.3),
    }
)
BODY = Body.from_shape(MESH, density=100.0)


def _pass(motion, count=90, length=300.0, sigma=0.05, starts=(0.0,)):
    generator = np.random.default_rng(5)
    t = np.sort(generator.uniform(0.0, length, count))
    angle = np.tile(np.radians(120.0) * t / length, len(starts))
    t = np.concatenate([begin + t for begin in starts])
    observer = np.stack([np.cos(angle), np.sin(angle), 0.3 + 0.0 * angle], axis=-1)
    observer /= np.linalg.norm(observer, axis=1)[:, None]
    sun = np.broadcast_to(np.array([0.6, 0.48, 0.64]), (len(t), 3))
    matrix = motion.at(t).matrix
    seen = [np.einsum("nij,ni->nj", matrix, each) for each in (sun, observer)]
    flux = light_curve.brightness(MESH, LAW, *seen)
    magnitude = 5.0 - 2.5 * np.log10(flux) + sigma * generator.normal(size=len(t))
    given = {"sun": sun * ASTRONOMICAL_UNIT_M, "observer": observer * 1e6}
    return inversion.LightCurve(
        t, magnitude + 0.0, sigma, epoch=motion.epoch, light_time=False, **given
    )


MOTION = FreeRotation(BODY, Spin("2026-01-01", (0.5, 0.1, -0.7, 0.4), (0.03, 0.01, -0.04)))


def test_rates_and_attitude_of_a_satellite():
    curve = _pass(MOTION, 60)
    found = inversion.spin_states(curve, "0.01 Hz", shape=MESH, law=LAW, moments=BODY, budget=300)
    assert found.verdict == "solved", str(found)
    here, truth = (each.at([MOTION.epoch.time]) for each in (found[0].motion, MOTION))
    rate, true_rate = (each.matrix[0] @ each.angular_velocity[0] for each in (here, truth))
    assert np.linalg.norm(rate - true_rate) < 0.02 * np.linalg.norm(true_rate)
    assert found[0].rms < 0.07
    (_, phi), sigma = found[0].periods_sigma, found[0].pole_sigma
    assert 0.0 < phi < 0.02 * found[0].P_phi and 0.0 < sigma < 0.2
    assert "best: P_phi (long axis)" in str(found) and "+-" in str(found)
    assert len(found.table()) == len(found)
    copy = pickle.loads(pickle.dumps(found[0]))
    assert copy.rms == found[0].rms and np.array_equal(
        copy.motion.spin.wxyz, found[0].motion.spin.wxyz
    )
    # and by refinement from a start near it
    turned = Spin("2026-01-01", (0.52, 0.1, -0.7, 0.38), (0.0301, 0.0101, -0.0399))
    again = inversion.refine(curve, FreeRotation(BODY, turned), shape=MESH, law=LAW)
    assert again.rms < 0.07
    assert again.shape.vertices == pytest.approx(MESH.vertices)


def test_the_budget_ends_a_search(monkeypatch):
    """Before its end, after little more work, and the verdict says so."""
    tallies = []
    search = _known.PassSearch.run
    monkeypatch.setattr(
        _known.PassSearch, "run", lambda self: (search(self), tallies.append(self.problem.tally))
    )
    curve = _pass(MOTION, 60)
    unlike = curve.magnitude + np.random.default_rng(6).normal(size=60)
    given = {"sun": curve.sun, "observer": curve.observer, "light_time": False}
    curve = inversion.LightCurve(curve.seconds, unlike, curve.sigma, epoch=curve.epoch, **given)
    given = {"shape": MESH, "law": LAW, "moments": BODY}
    found = inversion.spin_states(curve, "0.01 Hz", budget=0.05, **given)
    assert found.verdict == "not solved"
    assert "The budget of 0.05 s ended the search." in found.criterion
    # a step of 3000 states; one of the 28 attempts spends more than 4
    assert 0.05 < tallies[0].spent < 2.0


@pytest.mark.slow
def test_two_passes_are_one_curve():
    """A gap of 40 turns: first spans lie within a pass, and the next one follows from it."""
    curve = _pass(MOTION, 60, starts=(0.0, 5000.0))
    for attempt in range(4):
        middle, half = _known._first_span(curve.seconds, 0.06, attempt)
        assert half < 150.0 and abs(abs(middle) - 2500.0) < 150.0
    found = inversion.spin_states(curve, "0.01 Hz", shape=MESH, law=LAW, moments=BODY, budget=300)
    assert found.verdict == "solved"
    for epoch in (curve.epoch.after(-2600.0), curve.epoch.after(2600.0)):
        here, true = found[0].motion.at([epoch]), MOTION.at([epoch])
        rates = [np.einsum("nij,nj->ni", x.matrix, x.angular_velocity)[0] for x in (here, true)]
        assert np.linalg.norm(rates[0] - rates[1]) < 0.01 * np.linalg.norm(rates[1])


@pytest.mark.parametrize(
    ("turn", "costs", "attempts"),
    [
        ((1.0, 0.0, 0.0, 0.0), (500.0, 20.0), 2),  # as good as the errors
        ((1.0, 0.0, 0.0, 0.0), (500.0, 510.0, 400.0, 700.0, 401.0, 399.0), 6),  # three agree
        ((0.0, 1.0, 0.0, 0.0), (400.0,) * 28, 28),  # three agree, on what does not fit at all
    ],
)
def test_a_search_ends_where_several_starts_agree(turn, costs, attempts, monkeypatch):
    curve = _pass(MOTION, 60)
    given, _ = _problem.problem(curve, 0.01, 0.15, curve.zero_points, is_known=True)
    axes = BODY.principal_axes
    known = _shapes.known(MESH, LAW).over(axes)
    nothing = np.random.default_rng(0), lambda said: None
    made = _known.PassSearch(given, known, BODY.moments, 0.06, *nothing)
    here = MOTION.at([curve.epoch])
    wxyz = quaternion.multiply(here.wxyz[0], quaternion.from_matrix(axes))
    wxyz, omega = quaternion.multiply(wxyz, np.array(turn)), axes.T @ here.angular_velocity[0]
    left = list(costs)

    def from_span(self, middle, span):
        self.origin = 0.0
        cost = np.array([left.pop(0)])
        self.states = _known.States(wxyz[None], omega[None], cost)

    monkeypatch.setattr(_known.PassSearch, "_from", from_span)
    made.run()
    assert len(costs) - len(left) == attempts
    assert made.states.cost[0] == min(costs)


def test_slopes_of_a_known_shape():
    known = _shapes.known(MESH, LAW)
    generator = np.random.default_rng(2)
    sun = generator.normal(size=(50, 3))
    sun /= np.linalg.norm(sun, axis=1)[:, None]
    observer = sun + 0.5 * generator.normal(size=(50, 3))
    observer /= np.linalg.norm(observer, axis=1)[:, None]
    least = known.floor(sun, observer)
    lit = known.lit(sun, observer, least)
    step = 1e-5 * np.array([0.3, -0.5, 0.8])
    moved = [
        known.magnitudes(*(each - sign * np.cross(step, each) for each in (sun, observer)), least)
        for sign in (1.0, -1.0)
    ]
    difference = 0.5 * (moved[0] - moved[1])
    # the table of shadows has steps
    assert np.median(np.abs(difference - lit.across @ step)) < 1e-9


@pytest.mark.parametrize("nutation", [14.7, -11.0])
def test_moments_that_are_given(nutation):
    t, sun, observer = geometry()
    noise = 0.3 * np.random.default_rng(0).normal(size=len(t))
    terms = np.ones((len(t), 1)), np.full(1, np.inf)
    given = _problem.CurveProblem(t, 1.0, sun, observer, noise, np.full(len(t), 0.3), *terms, 0.0)
    tie = _states.of((3.0, 1.4, 2.5))
    found = _refinement.refine(given, ellipsoid_state(nutation), tie=tie, iterations=60).linearised
    ratios = _motions.moments(found.state[[0, 1, 3, 4]]).log_ratios
    moments = np.exp(np.append(ratios, 0.0))
    assert np.sort(moments / moments.max()) == pytest.approx([1.4 / 3.0, 2.5 / 3.0, 1.0], rel=0.02)


@pytest.mark.parametrize("widths", [(1.1, 0.7), (0.7, 1.1)])
def test_moments_that_are_given_stay_where_one_axis_shows_none(widths):
    """The axis of rotation has the largest one, the longer of the others the smaller."""
    state = np.zeros(_refinement.WIDTH)
    state[:14] = ellipsoid_state(0.0, 0.0)[:14]
    state[_ellipsoid.OF_LOG_RHO], state[14:16] = _ellipsoid.AXIAL, widths
    weighted = SimpleNamespace(refined=SimpleNamespace(state=state), evidence=0.0)
    tie = _states.of((2.5, 1.0, 2.0))
    found = inversion.Solution(None, weighted, None, tie, 0)
    assert found.moments == pytest.approx([0.4, 0.8, 1.0])
    motion = _states.motion(state, 1.0, Instant(0.0), None, tie.moments)
    of_shape = _states.motion(state, 1.0, Instant(0.0), None).body.moments
    assert list(np.argsort(motion.body.moments)) == list(np.argsort(of_shape))
    assert motion.body.moments.max() == 1.0


def test_what_moments_may_be():
    assert _states.of("shape").tolerance == _shapes.TOLERANCE
    assert _states.of(0.2).tolerance == 0.2
    assert not _states.of("free").holds_axes
    assert _states.of(BODY).moments == pytest.approx(np.sort(BODY.moments) / BODY.moments.max())
    with pytest.raises(AttitudeError, match="three moments"):
        _states.of("known")
    with pytest.raises(AttitudeError):
        _states.of((1.0, 1.0, 3.0))
    with pytest.raises(AttitudeError, match="zero"):
        _states.of((0.0, 1.0, 1.0))


def test_what_a_known_shape_refuses():
    curve = _pass(MOTION, count=40)
    with pytest.raises(AttitudeError, match="law="):
        inversion.spin_states(curve, "0.02 Hz", law=LAW)
    with pytest.raises(AttitudeError, match="homogeneous"):
        inversion.spin_states(curve, "0.02 Hz", shape=MESH, law=LAW, moments="free")
    with pytest.raises(AttitudeError, match="spans"):
        inversion.spin_states(curve, "0.002 Hz", shape=MESH, law=LAW)


def _linear(noise, count=400):
    """A fit of a line and two harmonics, as `jackknife.errors` takes it."""
    t = np.linspace(-0.5, 0.5, count)
    jacobian = np.stack([t, np.cos(40.0 * t), np.sin(40.0 * t)])
    root, y = np.full(count, 10.0), noise
    weighted = jacobian * root
    normal = weighted @ weighted.T
    best = np.linalg.solve(normal, weighted @ (y * root))
    here = SimpleNamespace(magnitude=best @ jacobian, jacobian=jacobian)
    curve = SimpleNamespace(y=y, root=root, projected=lambda rows: rows * root)
    nothing = np.zeros(0)
    refined = _refinement.Linearised(None, 0.0, 0.0, 0.0, nothing, nothing, normal, nothing)
    found = SimpleNamespace(problem=curve, refined=refined)
    return t, found, here


def test_independent_errors_are_those_of_the_curvature():
    noise = 0.1 * np.random.default_rng(1).normal(size=400)
    t, found, here = _linear(noise)
    groups = _errors.groupings(t, 100.0 * 86400.0, None)
    made = _errors.errors(found, here, groups, 3, lambda keep: None)
    assert made.covariance == pytest.approx(made.formal, rel=1e-6, abs=1e-12)
    assert made.widening == pytest.approx(np.eye(3), abs=1e-6)


def test_correlated_errors_widen_the_covariance():
    generator = np.random.default_rng(2)
    noise = 0.02 * generator.normal(size=400) + 0.1 * np.repeat(generator.normal(size=10), 40)
    t, found, here = _linear(noise)
    calls = []
    groups = _errors.groupings(t, 100.0 * 86400.0, None)
    made = _errors.errors(found, here, groups, 3, lambda keep: calls.append(keep))
    assert made.covariance[0, 0] > 4.0 * made.formal[0, 0]
    wide = made.widening @ made.formal @ made.widening.T
    assert np.diag(wide) == pytest.approx(np.diag(made.covariance), rel=1e-6)
    assert calls  # groups that move the line by more than an error are fitted anew


def test_axial_penalty_holds_the_greatest_moment():
    shape = np.zeros(_shapes.SIZE)
    shape[:2] = 1.0, 0.5  # the third axis is the longest: its moment is the least
    areas, slopes = _shapes.areas(shape)
    priors = _shapes.penalties(shape, areas, slopes, None, 8, _shapes.Tie())
    assert priors.strain > 100.0
    assert priors.slopes.shape == (len(priors.residuals), 8 + _shapes.SIZE)


def test_second_moments_of_a_density_with_wide_tails():
    """Student's density of 7 degrees of freedom with curvature 1: variance (7 + 3)/(7 - 2)."""

    counts = []

    def density(points):
        counts.append(len(points))
        return -5.0 * np.log1p(0.1 * np.sum(points**2, axis=1))

    found = _errors.second_moments(density, 3, np.random.default_rng(0))
    assert np.diag(found) == pytest.approx(np.full(3, 2.0), rel=0.2)
    # the first round has the 200 effective samples that are asked for
    assert counts == [260]
    normal = _errors.second_moments(
        lambda points: -0.5 * np.sum(points**2, axis=1), 3, np.random.default_rng(1)
    )
    assert np.diag(normal) == pytest.approx(np.ones(3), rel=0.1)


def test_second_moments_of_a_density_wider_than_its_curvature_says():
    """Samples of the first round are too narrow: others follow, but not all rounds."""
    counts = []

    def density(points):
        counts.append(len(points))
        return -0.5 * np.sum(points**2, axis=1) / 9.0

    wide = _errors.second_moments(density, 3, np.random.default_rng(0))
    assert 1 < len(counts) < 7
    assert np.diag(wide) == pytest.approx(np.full(3, 9.0), rel=0.2)


def test_errors_of_a_state_are_the_second_moments_of_its_density():
    """Shadows have steps: the curvature at the minimum is not that of the density."""
    curve = _pass(MOTION, 60)
    found = inversion.refine(curve, MOTION, shape=MESH, law=LAW)
    problem, fit = found.weighted.problem, found._fit
    seconds = _moving.seconds_of(found.point, fit.epoch, problem.t * problem.span)
    made = _errors.covariance_of_state(found.weighted, found.point, seconds, fit.known, fit.least)
    assert np.all(made[6:] == 0.0)
    # by many samples of a wide distribution, each with the cost of the fit
    generator = np.random.default_rng(4)
    factor = 2.0 * np.linalg.cholesky(made[:6, :6])
    drawn = generator.standard_normal((4000, 6))
    costs = np.empty(len(drawn))
    for row, each in enumerate(drawn):
        point = found.point.moved(np.concatenate([factor @ each, np.zeros(2)]))
        matrix = point.motion.at(seconds).matrix
        seen = [np.einsum("nij,in->nj", matrix, v) for v in (problem.sun, problem.observer)]
        residual = problem.y - fit.known.magnitudes(*seen, fit.least)
        residual *= problem.root
        costs[row] = residual @ residual - np.sum((problem.u @ residual) ** 2)
    logs = -0.5 * costs + 0.5 * np.sum(drawn**2, axis=1)
    weights = np.exp(logs - logs.max())
    weights /= weights.sum()
    assert 1.0 / np.sum(weights**2) > 40.0
    steps = drawn @ factor.T
    wanted = np.sqrt(np.sum(steps**2 * weights[:, None], axis=0))
    assert np.sqrt(np.diag(made)[:6]) == pytest.approx(wanted, rel=0.35)
    assert np.all(np.diag(found.covariance)[:6] >= 0.99 * np.diag(made)[:6])


def test_other_minima_widen_the_errors():
    covariance = np.diag([1.0, 4.0, 0.0])
    step = np.array([6.0, 0.0, 0.0])
    same = _errors.spread(covariance, [(0.1 * step / 6.0, 0.0)])
    assert np.all(same == 0.0)
    twice = [(step, 0.0), (1.001 * step, 0.0)]
    assert _errors.spread(covariance, twice)[0, 0] == pytest.approx(18.0)
    rare = _errors.spread(covariance, [(step, 2.0 * np.log(8.0))])
    assert rare[0, 0] == pytest.approx(36.0 / 9.0)


def test_nothing_found_is_an_empty_sequence():
    assert list(inversion.SpinStates([], "not solved", "No solution was found.", ())) == []
