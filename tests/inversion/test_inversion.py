"""Inversion of light curves: compiled parts against definitions, and curves of known states."""

import itertools
import math
import sys
import time
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from astropy import units
from astropy.time import Time

from attitude import Body, FreeRotation, Spin, inversion, photometry
from attitude._compilation.decorators import Compilable, EntryPoint
from attitude.epochs._instants import Instant
from attitude.errors import AttitudeError, AttitudeWarning
from attitude.frames import matrix_to_icrf, quaternion, representations
from attitude.inversion import (
    _ellipsoid,
    _errors,
    _motions,
    _refinement,
    _search,
    _shapes,
    _states,
    _verdicts,
)
from attitude.inversion import _problem as inversion_problem
from attitude.inversion._spin_states import is_constant
from attitude.light_curve import _sums
from attitude.photometry import _spectrum
from benchmarks import inversion as benchmark
from tests.support import inversion_families as families
from tests.support import synthetic_curves
from tests.support.inversion_geometry import COUNT, ellipsoid_state, geometry


def _problem(t, sun, observer):
    """Magnitudes of zero with weights of one, and a constant that is free."""
    count = len(t)
    return inversion_problem.CurveProblem(
        t,
        span=1.0,
        sun=sun,
        observer=observer,
        magnitude=np.zeros(count),
        sigma=np.ones(count),
        terms=np.ones((count, 1)),
        prior=np.full(1, np.inf),
        model_error=0.0,
    )


def _rows(state, t, sun, observer):
    """Magnitudes (N,) of a state and their Jacobian (10, N)."""
    curve = _ellipsoid.EllipsoidCurve(_problem(t, sun, observer))
    curve.products(state[None])
    return -curve.rows[0, : t.size], curve.rows[1:11, : t.size]


def _magnitudes(state, t, sun, observer):
    return _rows(state, t, sun, observer)[0]


@pytest.mark.parametrize(("nutation", "x"), [(14.7, 0.2), (-11.0, 0.5), (14.7, -0.1)])
def test_magnitudes_of_an_ellipsoid_are_those_of_the_package(nutation, x):
    """The exact motion of the same elements, and `light_curve.closed_form`."""
    t, sun, observer = geometry()
    state = np.zeros(_refinement.WIDTH)
    state[:16] = ellipsoid_state(nutation, x)
    if nutation > 0.0:
        state[0] = 33.0
    motion = _states.motion(state, 1.0, Instant(0.0), None)
    turn = motion.at(t).matrix
    s, o = (np.ascontiguousarray(np.einsum("tij,it->jt", turn, each)) for each in (sun, observer))
    a, b = math.exp(-0.5 * state[14]), math.exp(-0.5 * state[15])
    flux = np.empty(t.size)
    _sums.ellipsoid(a, b, 1.0, 1.0, *s, *o, flux)
    found = _magnitudes(state, t, sun, observer) + 2.5 * np.log10(flux)
    assert np.ptp(found) < 1e-6  # the series of the dimming has six terms


def test_derivatives_of_the_magnitudes():
    t, sun, observer = geometry()
    state = ellipsoid_state()
    jacobian = _rows(state, t, sun, observer)[1]
    for p in range(10):
        ends = []
        for sign in (1.0, -1.0):
            step = np.zeros(10)
            step[p] = sign * 1e-5
            new = _ellipsoid.moved(state, step)
            ends.append(_magnitudes(new, t, sun, observer))
        slope = (ends[0] - ends[1]) / 2e-5
        assert slope == pytest.approx(jacobian[p], abs=1e-7 * np.abs(jacobian[p]).max())


@pytest.mark.parametrize("log_moments", [(math.nan,) * 3, (-0.9, -0.2, 0.0)])
def test_slopes_of_the_sums_of_squares_from_many_starts(log_moments):
    """Against differences, tied to the shape and to moments that are given, in both modes."""
    t, sun, observer = geometry()
    curve = _ellipsoid.EllipsoidCurve(_problem(t, sun, observer))
    tie, free = _ellipsoid.Held(0.15, log_moments), np.zeros(10, bool)
    states = np.stack([ellipsoid_state(), ellipsoid_state(-11.0, 0.5), ellipsoid_state(14.7, -0.1)])
    near = _ellipsoid._linearised(curve, states, free, tie)
    assert _ellipsoid._cost(curve, states, tie) == pytest.approx(near.cost, rel=1e-13)
    for p in range(10):
        steps = np.zeros((3, 10))
        steps[:, p] = 1e-5
        ends = [
            _ellipsoid._cost(curve, _ellipsoid.moved(states, each), tie) for each in (steps, -steps)
        ]
        # half of the derivative; the moments' own slopes are differences over 1e-6
        slope = (ends[0] - ends[1]) / 4e-5
        assert near.gradient[:, p] == pytest.approx(-slope, abs=1e-6 * np.abs(slope).max())


def test_each_of_many_starts_is_minimised_as_if_alone():
    """More starts than are computed at a time, of which one is outside the bounds."""
    t, sun, observer = geometry()
    given = _problem(t, sun, observer)
    generator = np.random.default_rng(5)
    states = _ellipsoid.starts(
        generator, generator.uniform(5.0, 30.0, 90), generator.uniform(-20.0, 20.0, 90)
    )
    states[3, 4] = 0.99
    cost = _ellipsoid.costs(given, states)
    found = _ellipsoid.minimised(given, states, 12)
    assert np.isinf(found.cost[3]) and np.delete(found.cost < 0.9 * cost, 3).mean() > 0.9
    for k in (0, 40, 89):
        alone = _ellipsoid.minimised(given, states[k : k + 1], 12)
        assert alone.cost[0] == pytest.approx(found.cost[k], rel=1e-6)


def test_derivatives_of_the_convex_model():
    t, sun, observer = geometry()
    given = _problem(t, sun, observer)
    state = np.zeros(_refinement.WIDTH)
    state[:16] = ellipsoid_state()
    state[16:] = 0.3 * np.random.default_rng(2).normal(size=_shapes.MODES)
    here = _refinement.model(given, state)
    for p in (*range(10), 12, 40):
        ends = []
        for sign in (1.0, -1.0):
            step = np.zeros(_refinement.SIZE)
            step[p] = sign * 1e-6
            new = _ellipsoid.moved(state, step)
            new[16:] += step[10:]
            ends.append(_refinement.model(given, new).magnitude)
        slope = (ends[0] - ends[1]) / 2e-6 - here.jacobian[p]
        # areas are scaled to the largest: a constant
        assert np.ptp(slope) < 1e-5 * np.abs(here.jacobian[p]).max()


@pytest.mark.parametrize("is_long_axis", [True, False])
@pytest.mark.parametrize("is_swapped", [True, False])
def test_a_concave_body_has_a_smaller_least_moment(is_long_axis, is_swapped):
    """A third smaller than that of the shape counts little, another moment as a square."""
    flat = np.array([1.0, 0.6] if is_long_axis else [-1.0, -0.6])
    if is_swapped:
        flat = flat[::-1]
    shape = np.concatenate([flat, np.zeros(_shapes.MODES)])
    areas, slopes = _shapes.areas(shape)
    ratios = _shapes.constraints(shape, areas, slopes).log_ratios
    least, width = np.argmin(np.append(ratios, 0.0)), _shapes.TOLERANCE

    def priors(shift):
        change = np.zeros(3)
        change[list(shift)] = list(shift.values())
        new = ratios + change[:2] - change[2]
        moments = _shapes.MotionMoments(new, np.eye(2), is_long_axis, is_swapped)
        return _shapes.penalties(shape, areas, slopes, moments, 2, _shapes.Tie())

    exact = priors({}).strain
    assert priors({least: 1e-3}).strain - exact < 2.5 * (1e-3 / width) ** 2
    scale = 2.0 if is_long_axis else 1.0
    square = scale * (math.log(1.5) / width) ** 2
    expected = 1.5 * (2.0 * math.sqrt(square) - 1.5)
    assert priors({least: -math.log(1.5)}).strain - exact == pytest.approx(expected, rel=1e-9)
    assert priors({least: math.log(1.5)}).strain - exact == pytest.approx(square, rel=1e-9)
    h = 1e-6
    for k in range(2):
        ends = []
        for sign in (1.0, -1.0):
            new = ratios + sign * h * np.eye(2)[k]
            new[list({0, 1} if least == 2 else {least})] += 0.2 if least == 2 else -0.2
            moments = _shapes.MotionMoments(new, np.eye(2), is_long_axis, is_swapped)
            ends.append(_shapes.penalties(shape, areas, slopes, moments, 2, _shapes.Tie()))
        slope = (ends[0].residuals - ends[1].residuals) / (2.0 * h)
        assert slope == pytest.approx(ends[0].slopes[:, k], rel=1e-4, abs=1e-4)


@pytest.mark.parametrize("ratios", [(0.6, 0.35), (2.0, 3.1), (3.1, 2.0)])
def test_moments_that_no_body_has_are_held_back(ratios):
    """A body exists up to a largest moment of the sum of the others; the slopes are exact."""
    flat = np.array([0.4, 0.2])
    shape = np.concatenate([flat, np.zeros(_shapes.MODES)])
    areas, slopes = _shapes.areas(shape)

    def held_back(log_ratios):
        moments = _shapes.MotionMoments(log_ratios, np.eye(2), ratios[0] > 1.0, False)
        priors = _shapes.penalties(shape, areas, slopes, moments, 2, _shapes.Tie())
        return priors.residuals[8], priors.slopes[8, :2]

    at = np.log(ratios)
    assert held_back(at)[0] > 5.0
    inside = np.log(np.array(ratios) ** (0.9 if ratios[0] > 1.0 else 0.8))
    assert held_back(inside)[0] == 0.0
    h = 1e-7
    for k in range(2):
        move = h * np.eye(2)[k]
        slope = (held_back(at + move)[0] - held_back(at - move)[0]) / (2.0 * h)
        assert slope == pytest.approx(held_back(at)[1][k], rel=1e-5)


def test_moments_of_elements_are_those_of_the_body():
    generator = np.random.default_rng(3)
    for _ in range(40):
        moments = np.sort(generator.uniform(0.4, 1.0, 3))
        if moments[0] + moments[1] < moments[2]:
            continue
        spin = Spin("2026-01-01", (1, 0, 0, 0), generator.normal(size=3))
        e = FreeRotation(Body(moments=moments), spin).elements
        turn = 2.0 * math.pi
        given = e.precession_rate / turn, e.nutation_rate / turn, math.log(e.rho), e.X
        found = _motions.moments(np.array(given))
        order = moments if e.nutation_rate < 0.0 else moments[::-1]
        assert found.log_ratios == pytest.approx(np.log(order[:2] / order[2]), abs=1e-12)
        assert found.exists


def test_lengths_of_transforms_are_the_next_ones_with_small_factors():
    lengths = sorted(2**a * 3**b * 5**c for a in range(11) for b in range(7) for c in range(5))
    for least in range(1, 1000):
        assert _spectrum._smooth(least) == next(each for each in lengths if each >= least)


@pytest.mark.parametrize("order", [1, 2, 3])
def test_pairs_against_the_normal_equations(order):
    generator = np.random.default_rng(4)
    t, w = np.sort(generator.uniform(-0.5, 0.5, 80)), generator.uniform(50.0, 200.0, 80)
    y = generator.normal(size=80)
    transforms = _spectrum.tables(t, w, y, 1.0 / 3.0, 1200)
    first, second = np.array([36, 50, 7]), np.array([21, 90, 60])
    lines = _spectrum.harmonics(order)
    gain = _spectrum.decreases(transforms, first, second, lines)
    for k in range(3):
        angle = 2.0 * np.pi / 3.0 * (lines @ [first[k], second[k]])[1:, None] * t
        a = np.concatenate([np.ones((1, 80)), np.cos(angle), np.sin(angle)])
        normal = (a * w) @ a.T + np.diag([0.0] + [1.0] * (len(a) - 1))
        right = a @ (w * y)
        assert gain[k] == pytest.approx(right @ np.linalg.solve(normal, right), rel=1e-7)


def test_prior_of_linear_terms_is_marginalised():
    """chi-squared with a prior is that of the covariance with the prior added."""
    generator = np.random.default_rng(5)
    t, sun, observer = geometry()
    terms = np.stack([np.ones(COUNT), generator.normal(size=COUNT)], axis=1)
    y, sigma = generator.normal(size=COUNT), np.full(COUNT, 0.1)
    given = inversion_problem.CurveProblem(
        t, 1.0, sun, observer, y, sigma, terms, np.array([1e4, 0.3]), 0.0
    )
    wide = np.diag(sigma**2) + (terms * [1e8, 0.09]) @ terms.T
    r = y - y.mean()
    expected = r @ np.linalg.solve(wide, r)
    weighted = r * given.root
    along = given.u @ weighted
    assert weighted @ weighted - along @ along == pytest.approx(expected, rel=1e-5)


@pytest.mark.parametrize("count", [0, 1, 24, _shapes.MODES])
def test_modes_are_those_of_the_gaussian_process(count):
    """By octants, against the eigenvectors of the whole kernel, of which they are the largest."""
    normals, modes = _shapes.sphere().normals, _shapes.modes_of(count).of_facets
    kernel = np.exp((normals.T @ normals - 1.0) / 0.35**2)
    sizes = np.linalg.eigvalsh(kernel)[::-1][:count]
    assert modes.T @ modes == pytest.approx(np.diag(sizes), abs=1e-12)
    assert kernel @ modes == pytest.approx(modes * sizes, abs=1e-12)
    assert np.array_equal(modes, _shapes.modes_of(_shapes.MODES).of_facets[:, :count])


@pytest.mark.parametrize("count", [0, 24, _shapes.MODES])
@pytest.mark.parametrize("points", [2, 16, 21])
def test_light_of_a_convex_body(count, points):
    """Against the sum over all facets, and slopes by the shape against differences."""
    generator = np.random.default_rng(count + points)
    sun, observer = generator.normal(size=(2, points, 3))
    sun, observer = (each / np.linalg.norm(each, axis=-1)[:, None] for each in (sun, observer))
    shape = np.append([-0.8, 0.3], 0.4 * generator.normal(size=count))

    def expected(shape):
        m0, m = (np.maximum(each @ _shapes.sphere().normals, 0.0) for each in (sun, observer))
        flux = m0 * m * (1.0 / np.maximum(m0 + m, 1e-9) + _shapes.LAMBERT) @ _shapes.areas(shape)[0]
        return -2.5 * np.log10(np.maximum(flux, 1e-12))

    light = _shapes.magnitudes(sun, observer, shape)
    assert light.magnitude == pytest.approx(expected(shape), abs=1e-12)
    step = 1e-5 * np.eye(len(shape))
    slopes = np.array([expected(shape + each) - expected(shape - each) for each in step]) / 2e-5
    # areas are relative to the largest: slopes by one parameter may differ by a constant
    lit = expected(shape) < 20.0
    off = (light.by_shape() - slopes)[:, lit]
    assert off == pytest.approx(np.broadcast_to(off[:, :1], off.shape), abs=1e-8)


def test_mesh_of_areas_is_the_body():
    """Moments of the closed mesh are those of the surface tensor, to the error that is stated."""
    generator = np.random.default_rng(6)
    shape = np.append([-1.2, -0.5], 0.5 * generator.normal(size=_shapes.MODES))
    area, slopes = _shapes.areas(shape)
    area = _shapes.closed(area, _shapes.sphere().normals)
    found = _shapes.mesh(area, _shapes.sphere().normals)
    inertia = np.diag(found.mass_properties(density=1.0).inertia)
    held = _shapes.constraints(shape, area, slopes)
    assert found.is_convex and found.is_closed
    assert np.log(inertia[:2] / inertia[2]) == pytest.approx(held.log_ratios, abs=0.05)


CURVE = {"sun": (1e11, 0.0, 0.0), "observer": (1e11, 3e10, 0.0)}
SPACE = {"sun": (1e11, 0.0, 0.0), "observer": (1e11, 3e10, 2e10)}
EPOCHS = np.linspace(0.0, 86400.0, 40)


@pytest.mark.parametrize(
    ("columns", "words"),
    [
        ({"magnitude": np.full(40, np.nan)}, "not finite"),
        ({"flux": np.linspace(-1.0, 1.0, 40)}, "not above zero"),
        ({"magnitude": np.ones(40), "sigma": -np.ones(40)}, "below zero"),
        ({"magnitude": np.ones(39)}, "one for each of 40"),
        ({"magnitude": np.ones(40), "flux": np.ones(40)}, "either magnitude or flux"),
        ({"magnitude": np.ones(40), "sun": None}, "sun is missing"),
        ({"magnitude": np.ones(40), "session": np.zeros(3)}, "session has shape"),
        ({"magnitude": np.ones(40), "zero_points": "none"}, "zero_points is 'none'"),
    ],
)
def test_bad_curves_are_sentences(columns, words):
    with pytest.raises(AttitudeError, match=words):
        inversion_problem.usable(inversion.LightCurve(EPOCHS, **{**CURVE, **columns}))


def test_epochs_given_twice_are_averaged_and_few_are_refused():
    """By weight; the note names the first row and its date."""
    times = np.append(EPOCHS, EPOCHS[5])
    magnitude = np.append(np.ones(40), 1.3)
    sigma = np.append(np.full(40, 0.02), 0.01)
    curve = inversion.LightCurve(times, magnitude, sigma, **CURVE)
    assert len(curve) == 40 and curve.magnitude[5] == pytest.approx((1.0 + 4 * 1.3) / 5.0)
    assert curve.sigma[5] == pytest.approx(0.02 / math.sqrt(5.0))
    words = " ".join(curve.notes)
    assert "1 epoch occurs more than once" in words
    assert f"row 5, JD {2451545.0 + EPOCHS[5] / 86400.0:.6f}" in words
    assert len(inversion.LightCurve(times, magnitude, **CURVE, session=np.arange(41))) == 41
    with pytest.raises(AttitudeError, match="has 5 points"):
        inversion.spin_states(inversion.LightCurve(EPOCHS[:5], np.ones(5), **CURVE), "20 /d")
    with pytest.raises(AttitudeError, match="2 points at different epochs"):
        twice = inversion.LightCurve(np.repeat(EPOCHS[:2], 12), np.ones(24), **CURVE)
        inversion.spin_states(twice, "20 /d")


def test_vectors_of_an_observer_on_the_earth_over_other_axes_are_doubted():
    """The Sun stands on the ecliptic over one frame alone; the curve stays as it was given."""
    case = synthetic_curves.case(500, families.STYLES[6])

    def notes(frame):
        times = Time(case.jd, format="jd", scale="tdb")
        vectors = {"sun": case.sun * units.au, "observer": case.observer * units.au}
        given = inversion.LightCurve(times, case.magnitude, 0.02, frame=frame, **vectors)
        assert given.sun[0] == pytest.approx(
            matrix_to_icrf(frame) @ case.sun[0] * units.au.to("m"), rel=1e-12
        )
        return " ".join(given.notes)

    assert "give frame='ecliptic'" in notes("icrf") and notes("ecliptic") == ""
    assert "frame" not in " ".join(inversion.LightCurve(EPOCHS, np.ones(40), 0.1, **SPACE).notes)


def test_notes_of_doubtful_curves():
    magnitude = np.maximum(np.sin(EPOCHS), 0.2)
    curve = inversion_problem.usable(inversion.LightCurve(EPOCHS, magnitude, **CURVE))
    words = " ".join(curve.notes)
    assert "no error" in words and "saturated" in words


@pytest.mark.parametrize(
    ("nights", "a_night", "sigma", "expected"),
    [
        (25, 1, None, 0.1),  # a survey
        (6, 4, None, 0.1),
        (5, 5, None, 0.02),  # nights
        (1, 4, None, 0.02),
        (25, 1, 0.03, 0.03),
    ],
)
def test_points_of_surveys_without_errors_are_noisier_than_nights(nights, a_night, sigma, expected):
    """Of (135) Hertha the points of two surveys, as good as nights, gave a wrong period."""
    night = np.linspace(0.0, 0.2, 40)
    t = np.concatenate([night, *(30.0 + k + 0.01 * np.arange(a_night) for k in range(nights))])
    session = np.where(t < 1.0, "night", "survey")

    def errors_of(points):
        epochs, magnitude = 86400.0 * t[points], np.sin(t[points])
        given = {"session": session[points], **CURVE}
        return inversion_problem.usable(inversion.LightCurve(epochs, magnitude, sigma, **given))

    curve = errors_of(t > -1.0)
    assert curve.magnitude_sigma[-1] == expected
    assert curve.magnitude_sigma[0] == (sigma or 0.02)
    words = f"0.100 mag for {nights * a_night} of surveys"
    assert (words in " ".join(curve.notes)) == (expected == 0.1)
    if sigma is None:
        # 76 of 370 points of Toutatis have none: few a night are those of observers
        errors = np.where(t < 0.1, 0.03, np.nan)
        epochs, given = 86400.0 * t, {"session": session, **CURVE}
        beside = inversion.LightCurve(epochs, np.sin(t), errors, **given)
        assert inversion_problem.usable(beside).magnitude_sigma[-1] == 0.03
    if nights * a_night >= inversion_problem.LEAST_POINTS:
        # alone they may be an observer's few points a night
        assert errors_of(t > 1.0).magnitude_sigma[-1] == (sigma or 0.02)


def test_constant_brightness_and_short_spans_are_not_solved():
    generator = np.random.default_rng(7)
    curve = inversion.LightCurve(EPOCHS, 15.0 + 0.02 * generator.normal(size=40), 0.02, **CURVE)
    found = inversion.spin_states(curve, "20 /d", budget=5)
    assert found.verdict == "not solved" and "constant" in " ".join(found.notes)
    with pytest.raises(AttitudeError, match="no solution"):
        _ = found[0]
    with pytest.raises(AttitudeError, match="turns at max_frequency"):
        inversion.spin_states(curve, "1 /d")
    with pytest.raises(AttitudeError, match="modes"):
        inversion.spin_states(curve, "20 /d", modes=("LAM", "MAM"))
    with pytest.raises(AttitudeError, match="seed is -1"):
        inversion.spin_states(curve, "20 /d", seed=-1)


@pytest.mark.parametrize(
    ("columns", "arguments", "words"),
    [
        ({}, {"settings": None}, "settings is None; give Settings"),
        ({}, {"period": "13 h"}, "46332 to 47268 s is left: 2 turns .* the 86400 s of the light"),
        ({"session": range(40), "zero_points": "free"}, {}, "40 points, and its 43 free zero"),
        ({"filter": [f"{k}" for k in range(40)]}, {}, "40 points, and its 42 free zero"),
    ],
)
def test_curves_and_arguments_that_leave_nothing_to_search(columns, arguments, words):
    curve = inversion.LightCurve(EPOCHS, np.sin(EPOCHS), 0.02, **CURVE, **columns)
    with pytest.raises(AttitudeError, match=words):
        inversion.spin_states(curve, None if "period" in arguments else "20 /d", **arguments)


def test_a_period_without_a_unit_is_doubted():
    curve = inversion.LightCurve(EPOCHS, np.full(40, 15.0), 0.02, unit_distances=True, **CURVE)
    with pytest.warns(AttitudeWarning, match="^period is 7.3 without a unit, which is seconds"):
        inversion.spin_states(curve, period=7.3)


@pytest.mark.parametrize(
    ("name", "value", "words"),
    [
        ("alone", -5, "-5; it must be at least 0"),
        ("alone", math.inf, "must be finite"),
        ("rounds", 1.5, "give a whole number, at least 0"),
        ("noticed_rates", (0.2, -1.0), "at least 0"),
        ("tumblers", 1.0, "less than 1"),
        ("tie", 0.0, "greater than zero"),
        ("block", 0, "at least 1"),
    ],
)
def test_settings_are_numbers_of_at_least_zero(name, value, words):
    with pytest.raises(AttitudeError, match=f"{name} .*{words}"):
        inversion.Settings(**{name: value})
    assert inversion.Settings(alone="60").alone == 60.0


@pytest.fixture(scope="module")
def solved():
    """A synthetic tumbler of an independent forward model, and a search with half the starts."""
    style = {**families.STYLES[6], "per_hour": 9}
    case = synthetic_curves.case(31, style)
    curve = families.curve_of(case, "shared")
    half = inversion.Settings(pairs=100, classes=15, convex=20, short_classes=30, rounds=1)
    found = inversion.spin_states(curve, f"{case.most} /d", budget=300, seed=1, settings=half)
    return case, curve, found


def test_a_tumbler_is_found(solved):
    case, curve, found = solved
    right, _ = families.judged(found[0], case)
    assert right and found.verdict in ("solved", "periods only")
    assert found[0].rms < 0.05
    # one of the poles that compete, or its mirror
    angles = [
        families.judged(each, case)[1] for each in found if each.evidence < found[0].evidence + 20
    ]
    mirrors = [families.mirror_angle(each, case) for each in found[:4]]
    assert min(*angles, *mirrors) < 20.0
    assert len(found[0].residuals) == len(curve)


def test_what_a_solution_offers(solved, tmp_path, monkeypatch):
    from attitude.formats import spin_file

    # of a fit each second without one, of which dozens would be made
    monkeypatch.setattr(_errors, "_REFITS", 1)
    monkeypatch.setattr(_errors, "_SAMPLES", 100)

    case, curve, found = solved
    best = found[0]
    assert best.published("L").mode == case.mode
    assert best.P_psi == pytest.approx(best.motion.period_psi, rel=1e-9)
    assert np.all(np.linalg.eigvalsh(best.covariance) > -1e-12)
    draws = best.sample(300)
    of_draws = [[motion.period_psi, motion.regime.P_phi_L] for motion in draws]
    assert np.std(of_draws, axis=0) == pytest.approx(best.periods_sigma, rel=0.2)
    # attitudes too, at the ends of the curve, where draws of rates and moments scatter more
    ends = curve.emission[[0, -1]]
    middle = quaternion.conjugate(best.motion.at(ends).wxyz)
    turns = [quaternion.multiply(motion.at(ends).wxyz, middle) for motion in draws]
    scatter = np.std(representations.to_rotation_vector(np.array(turns)), axis=0)
    assert scatter == pytest.approx(best.motion.at(ends).sigma, rel=0.2)
    magnitude, sigma = best.predict()
    assert np.std(curve.magnitude - magnitude) == pytest.approx(best.rms, rel=0.05)
    assert np.all(sigma > 0.0)
    table = found.table()
    assert table["relation"][0] == "best" and len(table) == len(found)
    best.write(tmp_path / "found.toml")
    read = spin_file.read(tmp_path / "found.toml")
    assert read.motion.period_psi == pytest.approx(best.P_psi, rel=1e-9)
    assert read.spin.covariance is not None
    assert best.shape.is_closed
    with pytest.raises(AttitudeError, match="outside of the light curve"):
        best.predict([curve.seconds[-1] + 1e5])


def test_figures_are_drawn(solved, tmp_path):
    found = solved[2]
    figure = found.plot(tmp_path / "all.png")
    rates, poles = (
        next(axes for axes in figure.axes if words in axes.get_xlabel())
        for words in ("1/P_phi", "longitude")
    )
    # numbers without an offset, and the best solution over the others, in the colour of rivals
    assert not rates.xaxis.get_major_formatter().get_useOffset()
    longitude = np.degrees(found[0].pole[0])
    assert poles.lines[-1].get_xdata()[0] == pytest.approx(longitude)
    colours = [line.get_color() for line in poles.lines[::-1]]
    problem = found[0]._problem
    assert [colour == colours[0] for colour in colours] == [
        _verdicts.competes(each.weighted, found[0].weighted, problem, is_hidden=True)
        for each in found
    ]
    assert all(axes.get_xlabel() for axes in figure.axes if axes.lines and axes.get_visible())
    found[0].plot(tmp_path / "one.png")
    assert (tmp_path / "all.png").stat().st_size > 10_000


# With fewer pairs of frequencies, starts and solutions than a search has.
SMALL = inversion.Settings(
    pairs=60, deep_starts=20, classes=10, convex=10, short_classes=20, finals=5, rounds=1
)


@pytest.fixture
def small_search(monkeypatch):
    """Poles of rotation about one axis, from 200 directions, take half of the time."""
    monkeypatch.setattr(_search.Search, "_axial_poles", lambda self: None)


@pytest.mark.parametrize(
    ("modes", "periods", "expected"),
    [
        (("PA", "LAM"), (0.5124, 1.0244), True),  # psi at half the rotation, phi at it
        (("PA", "SAM"), (0.5124, 0.1708), True),
        (("PA", "LAM"), (1.0244, 0.5124), False),  # phi at half of it is no line of a rotation
        (("PA", "LAM"), (0.5124, 0.9800), False),  # 1.2 turns off
        (("PA", "LAM"), (0.5124, 1.0450), False),  # within a turn, but two lines
        (("PA", "LAM"), (0.5124, 9.0000), False),  # a slow nutation is none
        (("LAM", "LAM"), (0.5124, 1.0244), False),  # found as tumbling: its periods decide
        (("PA", "PA"), (0.5124, math.inf), False),
    ],
)
def test_a_tumbling_body_with_the_lines_of_a_rotation_counts_as_it(modes, periods, expected):
    """In the benchmark as in the search: light shows no line that tells one from the other."""
    found = SimpleNamespace(mode=modes[0], P_phi=0.5117 * 86400.0)
    case = SimpleNamespace(
        mode=modes[1], P_phi=periods[0], P_psi=periods[1], jd=np.array([2460000.0, 2460027.0])
    )
    assert families.is_comb(found, case) is expected


@pytest.mark.slow
def test_a_rotation_of_days_is_found_in_sessions_of_hours(small_search):
    """Offsets of its 60 sessions, 0.1 mag, explain the whole curve, and evidence rejects them."""
    case = synthetic_curves.case(501, families.STYLES[5])
    curve = families.curve_of(case, "auto")
    given, _ = inversion_problem.problem(curve, case.most / 86400.0, 0.07, "auto")
    assert is_constant(given)
    found = inversion.spin_states(curve, f"{case.most} /d", modes=("LAM",), settings=SMALL)
    assert families.judged(found[0], case)[0]
    assert "sessions" not in " ".join(found.notes)


@pytest.mark.parametrize(
    ("zero_points", "explained"),
    [
        pytest.param(
            "auto",
            "a constant brightness with zero points of the sessions of 0.0",
            marks=pytest.mark.slow,
        ),
        ("free", "with one zero point chi2/N"),
    ],
)
def test_offsets_of_sessions_about_a_constant_brightness(small_search, zero_points, explained):
    """Within their prior no tumbling body explains them better; with "free" the note says so."""
    case = synthetic_curves.case(501, {**families.STYLES[5], "nights": 24})
    generator = np.random.default_rng(6)
    zero = 0.08 * generator.normal(size=case.session.max() + 1)
    size = np.linalg.norm(case.sun, axis=1) * np.linalg.norm(case.observer, axis=1)
    noise = case.sigma * generator.normal(size=len(case.sigma))
    flat = replace(case, magnitude=5.0 * np.log10(size) + zero[case.session] + noise)
    few = replace(SMALL, pairs=10, deep_starts=4, classes=4, convex=3, short_classes=4, finals=2)
    curve = families.curve_of(flat, zero_points)
    found = inversion.spin_states(curve, f"{case.most} /d", modes=("LAM",), settings=few)
    assert found.verdict == "not solved"
    assert "within the errors" not in found.criterion
    assert explained in " ".join((found.criterion, *found.notes))


@pytest.mark.slow
def test_offsets_that_the_data_ask_for_are_fitted(small_search):
    """Sessions of a fast tumbler whose zero points differ by 0.1 mag."""
    case = synthetic_curves.case(31, {**families.STYLES[6], "per_hour": 9, "zero": 0.1})
    found = inversion.spin_states(
        families.curve_of(case, "auto"), f"{case.most} /d", settings=SMALL
    )
    assert "sessions have zero points of their own" in " ".join(found.notes)
    assert found[0].rms < 0.05


def test_no_slow_tumbler_is_called_constant():
    assert benchmark.called_constant(4, 8100006)[0] == []


@pytest.mark.slow
def test_no_slow_tumbler_of_many_is_called_constant():
    """Offsets of the sessions within their prior explain one curve in six."""
    found, explained = benchmark.called_constant(300, 8100000)
    assert not found and explained > 30


def test_periods_of_the_lines(solved):
    """A curve with geometry is reduced, and the phase terms are fitted with the series."""
    case, curve, _ = solved
    found = photometry.periods(curve, count=2, min_period=86400.0 / case.most)
    assert found.count == 2
    assert found[0].left < 0.3 < found.false_alarm
    assert found.table()["significant"][0]


@pytest.mark.slow
def test_posterior_has_the_spread_of_the_covariance(solved):
    """A short chain over five days of data: the errors of eight parameters to a half."""
    pytest.importorskip("emcee")
    found = solved[2][0].posterior(walkers=24, steps=120)
    assert np.all((found.ratio > 0.6) & (found.ratio < 1.6))
    assert len(found.motions(3)) == 3 and found.weights.sum() == pytest.approx(1.0)
    with pytest.raises(AttitudeError, match="method is 'dream'"):
        solved[2][0].posterior("dream")


def test_relations_in_words(solved):
    found = solved[2]
    given, best = found[0]._problem, found[0].state
    partner = best.copy()
    partner[1] = -best[1]
    assert "other mode of the same lines" in _verdicts.relation(partner, best, given)
    turned = best.copy()
    turned[[7, 10, 13]] *= -1.0
    assert "antipode" in _verdicts.relation(turned, best, given)


def test_the_same_seed_gives_the_same_result(monkeypatch):
    """On a machine of any speed, where the budget ends the search: work is counted, not time."""
    few = {
        "pairs": 10,
        "deep_starts": 4,
        "classes": 4,
        "convex": 4,
        "finals": 3,
        "short_classes": 4,
    }
    settings = inversion.Settings(**few)
    case = synthetic_curves.case(31, {**families.STYLES[6], "per_hour": 3})
    curve, most = families.curve_of(case, "shared"), f"{case.most} /d"
    given = {"modes": ("LAM",), "budget": 0.5, "seed": 1, "settings": settings}
    one = inversion.spin_states(curve, most, **given)
    clock = itertools.count(step=50.0)
    monkeypatch.setattr(time, "monotonic", lambda: next(clock))
    two = inversion.spin_states(curve, most, progress=lambda text: None, **given)
    assert (one.verdict, one.criterion) == (two.verdict, two.criterion)
    assert [each.evidence for each in one] == [each.evidence for each in two]
    assert one[0].P_psi == two[0].P_psi
    assert "budget of 0.5 s ended the search" in one.criterion


def test_an_interrupt_returns_the_best_so_far(solved):
    """Ctrl-C after the first stage, of rotations about one axis."""
    case, curve, _ = solved

    def stop(text):
        if "convex" in text:
            raise KeyboardInterrupt

    found = inversion.spin_states(curve, f"{case.most} /d", budget=40, progress=stop)
    assert "interrupted" in " ".join(found.notes) and len(found) > 0
    assert found.verdict == "not solved"
    assert found.criterion.startswith("Ctrl-C ended the search before all periods were tried. ")


def test_many_points_are_averaged_and_filters_have_zero_points():
    generator = np.random.default_rng(8)
    t = np.sort(generator.uniform(0.0, 86400.0, 20_000))
    band = np.where(np.arange(20_000) % 2, "V", "R")
    magnitude = 15.0 + 0.3 * np.cos(t / 3000.0) + 0.4 * (band == "V")
    curve = inversion.LightCurve(t, magnitude, 0.02, filter=band, **CURVE)
    given, notes = inversion_problem.problem(curve, 20.0 / 86400.0, 0.07, "shared")
    assert curve.filters == ("R", "V") and len(given) < 6000
    assert notes == [f"20000 points were averaged to {len(given)}."]
    offset = given.coefficients(np.zeros(len(given)))[4:6]
    assert offset[1] - offset[0] == pytest.approx(0.4, abs=0.02)
    assert np.sum(1.0 / given.sigma**2) == pytest.approx(20_000 / 0.02**2)


def test_no_loop_calls_an_entry_point():
    """Which machine code of it a loop ran depended on what this process had compiled: the first
    search on a machine had other last digits than the next ones, and then other minima.
    """
    modules = [sys.modules[name] for name in sys.modules if name.startswith("attitude.inversion.")]
    compiled = {
        value
        for module in modules
        for value in vars(module).values()
        if isinstance(value, Compilable)
    }
    entry_points = [one for one in compiled if isinstance(one, EntryPoint)]
    assert _ellipsoid._products in entry_points and len(entry_points) > 10
    for one in compiled:
        names = one.py_func.__code__.co_names
        called = [one.py_func.__globals__.get(name) for name in names]
        assert not any(isinstance(value, EntryPoint) for value in called), one
