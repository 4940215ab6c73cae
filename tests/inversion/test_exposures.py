"""Exposures in the model of the inversion, and predictions beyond the curve."""

import math

import numpy as np
import pytest

from attitude import FreeRotation, cli, inversion, light_curve, paths
from attitude._support.constants import ASTRONOMICAL_UNIT_M
from attitude.errors import AttitudeError
from attitude.inversion import _moving, _problem
from tests.support.tumbler import BODY, DAY, MOMENTS, RATES, SHAPE, SPIN, directions, start_beside

# A fifth of the period of the brightness, which has two maxima a turn of half a day.
EXPOSURE = 0.05 * DAY


def smeared(count=150, sigma=0.01, exposure=EXPOSURE):
    """Epochs, mean brightness over 21 nodes of each exposure, mag, and the vectors."""
    generator = np.random.default_rng(3)
    t = np.sort(generator.uniform(-2.5, 2.5, count)) * DAY
    both = directions(t)
    flux = np.zeros(count)
    for node, weight in zip(*np.polynomial.legendre.leggauss(21), strict=True):
        matrix = FreeRotation(BODY, SPIN).at(t + 0.5 * exposure * node).matrix
        seen = [np.einsum("nij,ni->nj", matrix, each) for each in both]
        flux += 0.5 * weight * light_curve.brightness(SHAPE, "lommel-seeliger", *seen)
    magnitude = 15.0 - 2.5 * np.log10(flux) + sigma * generator.normal(size=count)
    sun, observer = (each * ASTRONOMICAL_UNIT_M for each in both)
    return {
        "times": t, "magnitude": magnitude, "sigma": sigma, "sun": sun, "observer": observer,
        "epoch": SPIN.epoch, "time_of": "emission",
    }  # fmt: skip


def off(refinement):
    """Rates and moments less the truth, in standard errors."""
    error = np.sqrt(np.abs(np.diag(refinement.motion.spin.covariance)))
    rates = (refinement.point.spin.angular_velocity - RATES) / error[3:6]
    moments = (refinement.point.body.moments - MOMENTS)[:2]  # ascending; the third one is 1
    return np.concatenate([rates, moments / error[6:8]])


def test_exposures_of_a_fifth_of_the_period_leave_rates_and_moments_right():
    """Without `exposure=` they are 2 to 3 standard errors off."""
    given = smeared()
    right = inversion.refine(inversion.LightCurve(**given, exposure=EXPOSURE), start_beside())
    wrong = inversion.refine(inversion.LightCurve(**given), start_beside())
    assert np.all(np.abs(off(right)) < 3.0)
    assert np.abs(off(right)).max() < np.abs(off(wrong)).max() > 2.0


def test_magnitudes_over_exposures_and_their_derivatives():
    """Five nodes against 21, of the true body, and derivatives against differences."""
    given = smeared(sigma=1e-12)
    curve = _problem.usable(inversion.LightCurve(**given, exposure=EXPOSURE))
    problem, _ = _problem.problem(curve, 1e-4, 0.02, "shared")
    assert len(problem.at_nodes) == 5 * len(problem)
    fit = inversion.refine(curve, start_beside())
    state = fit.weighted.refined.state
    model = fit._model(problem)
    step = 1e-6
    change = np.zeros(len(model.jacobian))
    change[3] = step * np.abs(RATES).max()
    moved = _moving.MovingState(state.point.moved(change[: state.point.size]), state.shape)
    by = (fit._fit.model(problem, moved).magnitude - model.magnitude) / change[3]
    np.testing.assert_allclose(by, model.jacobian[3], atol=2e-4 * np.abs(by).max())
    # the true motion and body: five nodes against 21
    nodes = problem.at_nodes
    middle = curve.epoch.seconds - SPIN.epoch.seconds
    matrix = FreeRotation(BODY, SPIN).at(nodes.t * problem.span + middle).matrix
    seen = [np.einsum("nij,in->nj", matrix, each) for each in (nodes.sun, nodes.observer)]
    at = -2.5 * np.log10(light_curve.brightness(SHAPE, "lommel-seeliger", *seen))
    mean = problem.mean_magnitudes(at) + 15.0
    np.testing.assert_allclose(mean, curve.magnitude, atol=1e-4)
    few = problem.with_few_nodes()
    nodes = few.at_nodes
    assert len(nodes) == 2 * len(problem)
    matrix = FreeRotation(BODY, SPIN).at(nodes.t * problem.span + middle).matrix
    seen = [np.einsum("nij,in->nj", matrix, each) for each in (nodes.sun, nodes.observer)]
    at = -2.5 * np.log10(light_curve.brightness(SHAPE, "lommel-seeliger", *seen))
    off_by = few.mean_magnitudes(at) + 15.0 - curve.magnitude
    assert 1e-4 < np.abs(off_by).max() < 0.02
    # a mean of fluxes: a constant flux stays, and that of a linear one is its middle
    at = np.zeros((5, len(problem))).reshape(-1)
    np.testing.assert_allclose(problem.mean_magnitudes(at), 0.0, atol=1e-15)
    instant, _ = _problem.problem(curve.replaced(exposure=None), 1e-4, 0.02, "shared")
    assert instant.at_nodes is instant


def test_exposures_of_files_and_wrong_ones(tmp_path):
    path = tmp_path / "c.csv"
    path.write_text("jd,mag,exptime\n2460000.5,15.0,60\n2460000.6,15.1,\n2460000.7,15.2,30\n")
    curve = inversion.LightCurve.read(path)
    assert curve.exposure.tolist() == [60.0, 0.0, 30.0]
    assert inversion.LightCurve.read(path, exposure="2 min").exposure.tolist() == [120.0] * 3
    curve.write(tmp_path / "d.csv")
    assert inversion.LightCurve.read(tmp_path / "d.csv").exposure.tolist() == [60.0, 0.0, 30.0]
    for wrong, words in ((-1.0, "not times"), ([1.0, 2.0], "shape"), ("3 kg", "give it in s")):
        with pytest.raises(AttitudeError, match=words):
            inversion.LightCurve.read(path, exposure=wrong)


def asteroid():
    return paths.kepler(
        semi_major_axis="1.9 au", eccentricity=0.2, inclination="8 deg", node="40 deg",
        pericenter_argument="10 deg", mean_anomaly="20 deg", epoch="2026-01-01",
    )  # fmt: skip


@pytest.fixture(scope="module")
def fitted():
    """A fit to seven nights from two sites, and the light curve itself."""
    generator = np.random.default_rng(5)
    night = np.repeat(np.arange(7), 30)
    t = (night - 3.2 + np.sort(generator.uniform(0.0, 0.33, (7, 30)), axis=1).ravel()) * DAY
    given = {"path": asteroid(), "site": np.where(night % 2, "568", "703"), "epoch": SPIN.epoch}
    dark = inversion.LightCurve(t, np.zeros(t.size), **given)
    magnitude = observed(dark) + 0.02 * generator.normal(size=t.size)
    curve = inversion.LightCurve(t, magnitude, 0.02, zero_points="shared", **given)
    return inversion.refine(curve, start_beside(0.02, 0.001)), curve


def observed(curve):
    """Apparent magnitudes of the true body with the geometry of a curve."""
    motion = FreeRotation(BODY, SPIN)
    matrix = motion.at(curve.emission + (curve.epoch.seconds - SPIN.epoch.seconds)).matrix
    seen = [
        np.einsum("nij,ni->nj", matrix, each / np.linalg.norm(each, axis=1)[:, None])
        for each in curve.vectors
    ]
    flux = light_curve.brightness(SHAPE, "lommel-seeliger", *seen)
    return 15.0 - 2.5 * np.log10(flux) + curve.dimming


def test_predictions_of_the_next_night(fitted, tmp_path):
    """Form and level lie within three of their errors; sites of the curve have their geometry."""
    fit, curve = fitted
    assert set(curve.scenes) == {"568", "703"} and len(curve.sites) == 2
    beyond = curve.seconds[-1] + np.linspace(0.7, 1.0, 60) * DAY
    found = fit.predict(beyond, site="568")
    again = inversion.LightCurve(
        beyond, np.zeros(60), epoch=curve.epoch, path=asteroid(), site="568"
    )
    truth = observed(again)
    error = found.magnitude - truth
    assert np.abs(error - error.mean()).max() < 3.0 * found.form.max()
    assert abs(error.mean()) < 3.0 * found.level[0] + 0.02
    assert found.form.max() < 0.1 and np.all(found.sigma >= found.form)
    magnitude, sigma = found
    assert magnitude is found.magnitude and sigma is found.sigma
    np.testing.assert_allclose(fit.predict(again).magnitude, magnitude, atol=1e-9)
    other = fit.predict(beyond, site="earth")
    assert 0.0 < np.abs(other.magnitude - magnitude).max() < 0.01
    assert found.table().colnames == ["time", "magnitude", "sigma", "form", "level", "phase_angle"]
    found.plot(tmp_path / "night.png", observed=curve)
    fit.plot(tmp_path / "fit.png")
    assert min(f.stat().st_size for f in tmp_path.glob("*.png")) > 10_000
    with pytest.raises(AttitudeError, match="filter is 'R'"):
        fit.predict(beyond, filter="R")


def test_bands_have_their_own_slopes_with_the_phase_angle():
    """Reddening of 0.004 mag a degree over 20 to 50 degrees, that one slope would leave."""
    rng = np.random.default_rng(4)
    t = np.sort(rng.uniform(0.0, 60.0 * DAY, 300))
    alpha = np.radians(20.0 + 30.0 * t / t[-1])
    sun = np.tile([1.5e11, 0.0, 0.0], (t.size, 1))
    observer = 1e11 * np.stack([np.cos(alpha), np.sin(alpha), np.zeros(t.size)], axis=1)
    band = np.where(rng.random(t.size) < 0.5, "B", "V")
    excess = np.where(band == "B", 0.5 + 0.004 * np.degrees(alpha), 0.0)
    magnitude = 15.0 + 0.03 * np.degrees(alpha) + excess
    curve = inversion.LightCurve(
        t, magnitude, 0.002, sun=sun, observer=observer, filter=band, unit_distances=True
    )
    given, _ = _problem.problem(curve, 1.0 / DAY, 0.0, "shared")
    assert given.chi_squared(np.zeros(t.size)) < 1.0
    found = given.coefficients(np.zeros(t.size))
    # phase terms (4), filters (2), their slopes (2)
    reddening = (found[6] - found[7]) * math.radians(1.0) / _problem._WIDE
    assert reddening == pytest.approx(0.004, abs=1e-4)
    one = curve.replaced(magnitude=magnitude - excess)
    same, _ = _problem.problem(one, 1.0 / DAY, 0.0, "shared")
    assert np.abs(same.coefficients(np.zeros(t.size))[6:8]).max() < 1e-6
    single, _ = _problem.problem(curve.select(filter="B"), 1.0 / DAY, 0.0, "shared")
    assert single.terms.shape[1] == 5 and given.terms.shape[1] == 8


def refined(curve, **changes):
    """A fit to the light curve with other keywords, of a known mesh for its speed."""
    return inversion.refine(
        curve.replaced(**changes), start_beside(0.02, 0.001), shape=SHAPE.facets(100)
    )


def with_vectors(curve):
    """The light curve without a path."""
    sun, observer = curve.vectors
    plain = curve.replaced(sun=sun, observer=observer)
    plain._set("scenes", {})
    return plain


def two_filters(curve):
    """Keywords of the same points in two filters, of which one is 0.7 mag fainter."""
    is_red = np.random.default_rng(1).random(len(curve)) < 0.5
    return {
        "filter": np.where(is_red, "R", "V"),
        "magnitude": curve.magnitude + np.where(is_red, 0.0, 0.7),
    }


@pytest.mark.parametrize("names", ["all", "one", "free"])
def test_zero_points_of_predictions(fitted, names):
    """Where no session shares one, they are at their mean: half of the magnitude was lost."""
    curve = fitted[1]
    night = np.repeat(np.arange(7), 30)
    changes = {"session": night, "magnitude": curve.magnitude + 0.1 * night}
    sessions = tuple("0123456")
    zero_points = {"all": sessions, "one": sessions[1:], "free": "free"}[names]
    fit = refined(curve, zero_points=zero_points, **changes)
    off = fit.curve.magnitude - fit.predict().magnitude
    assert abs(off[night == 0].mean() if names == "one" else off.mean()) < 0.02
    assert fit.predict().level.max() < 0.05


def test_filters_of_points(fitted, tmp_path):
    fit = refined(fitted[1], **two_filters(fitted[1]))
    found = fit.predict(fit.curve)
    assert np.std(fit.curve.magnitude - found.magnitude) == pytest.approx(fit.rms, rel=0.1)
    assert fit.predict().magnitude == pytest.approx(found.magnitude, abs=1e-12)
    in_red = fit.predict(fit.curve, filter="R")
    assert in_red.magnitude == pytest.approx(
        found.magnitude - np.where(fit.curve.filter, 0.7, 0.0), abs=0.02
    )
    assert not np.any(in_red.colour) and not np.any(in_red.filter)
    of_first = fit.predict(fit.curve, filter=fit.curve.filters[found.filter[0]])
    assert found.colour == pytest.approx(found.magnitude - of_first.magnitude)
    # points of both lie on one line
    for figure in (fit.plot(tmp_path / "fit.png"), found.plot(observed=fit.curve)):
        for panel in figure.axes[::2]:
            line, points = panel.lines[0].get_xydata(), panel.lines[1].get_xydata()
            off = points[:, 1] - np.interp(points[:, 0], *line.T)
            assert np.abs(off).max() < 0.12


def test_dates_of_emission_are_those_of_the_fit(fitted):
    """Dates of a curve are of emission where its times are: half a minute of light time."""
    fit = refined(fitted[1].reduced())
    times = fit.curve.times
    expected = fit.predict().magnitude
    for given in ({}, {"path": asteroid()}):
        found = fit.predict(times[::-1], site="568", **given)
        there = fit.curve.site == fit.curve.sites.index("568")
        assert found.magnitude[::-1][there] == pytest.approx(expected[there], abs=1e-6)


def test_the_site_of_a_path_is_that_of_most_points(fitted):
    fit, curve = fitted
    dates = curve.seconds[-1] + np.array([0.9, 0.7]) * DAY
    found = fit.predict(dates, path=asteroid())
    assert found.magnitude == pytest.approx(fit.predict(dates).magnitude, abs=1e-9)
    with pytest.raises(AttitudeError, match="has a geometry of its own; give its times"):
        fit.predict(curve, path=asteroid())


def test_single_epochs_and_points_of_their_night(fitted, recwarn):
    fit, curve = fitted
    dates = curve.seconds[[10, 100]]
    figure = fit.predict(dates).plot(observed=curve)
    for panel in figure.axes[::2]:
        model, points = panel.lines[:2]
        assert model.get_marker() == "D" and len(points.get_xdata()) == 30
        assert np.all(np.diff(panel.get_ylim()) < -0.2)
    assert not recwarn.list


def test_vectors_end_with_the_curve(fitted):
    curve = fitted[1]
    plain = with_vectors(curve)
    fit = inversion.refine(plain, start_beside(0.02, 0.001))
    with pytest.raises(AttitudeError, match=r"outside of the light curve.*give path="):
        fit.predict([curve.seconds[-1] + DAY])
    there = fit.predict([curve.seconds[-1] + DAY], path=asteroid(), site="568")
    assert len(there.magnitude) == 1 and np.isfinite(there.sigma[0])


@pytest.mark.parametrize("length", [20.0, 200.0])
def test_vectors_are_not_interpolated_in_wide_gaps(fitted, length):
    """Ten days of points on both sides of a gap; in its middle an interpolation is off."""
    curve = fitted[1]
    t = curve.seconds - curve.seconds.min()
    t = np.where(np.arange(t.size) < t.size // 2, t - length * DAY, t)
    dark = inversion.LightCurve(t, np.zeros(t.size), epoch=SPIN.epoch, path=asteroid())
    fit = refined(with_vectors(dark.replaced(magnitude=observed(dark), sigma=0.02)))
    assert len(fit.predict([fit.curve.seconds[3] + 3600.0]).magnitude) == 1
    with pytest.raises(AttitudeError, match=r"one of 2, lies in a gap.*give path="):
        fit.predict(np.array([-1.0, 1.0]) * DAY)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (("--prediction", "x.csv"), "give --predict DATES too"),
        (("--predict", "soon"), "soon"),
        (("--predict", "2026-01-02 .. 2026-01-01"), "give a stop after the start"),
        (("--predict", "2026-01-01 .. 2026-01-02, 1 kg"), "give it in s"),
        (("--predict", "2026-01-01", "--prediction", "x.doc"), "--prediction is 'x.doc'"),
    ],
)
def test_wrong_predictions_are_refused_before_the_search(tmp_path, capsys, options, words):
    path = tmp_path / "c.csv"
    rows = [f"{2461000.5 + k / 9},{15 + 0.1 * (k % 3)},1,0,0,0,1,0" for k in range(30)]
    names = "jd,mag,sun_x,sun_y,sun_z,observer_x,observer_y,observer_z"
    path.write_text("\n".join([names, *rows]))
    assert cli.main(["invert", str(path), "--max-frequency", "2 /d", *options]) == 2
    assert words in capsys.readouterr().err
