"""Exposures in the model of the inversion, and predictions beyond the curve."""

import math

import numpy as np
import pytest

from attitude import FreeRotation, cli, inversion, light_curve, paths
from attitude._support.constants import ASTRONOMICAL_UNIT_M
from attitude.errors import AttitudeError
from attitude.inversion import _moving, _problem
from tests.inversion.test_refine import BODY, DAY, MOMENTS, RATES, SHAPE, SPIN, _directions, _start

# A fifth of the period of the brightness, which has two maxima a turn of half a day.
EXPOSURE = 0.05 * DAY


def smeared(count=150, sigma=0.01, exposure=EXPOSURE):
    """Epochs, mean brightness over 21 nodes of each exposure, mag, and the vectors."""
    generator = np.random.default_rng(3)
    t = np.sort(generator.uniform(-2.5, 2.5, count)) * DAY
    both = _directions(t)
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
    right = inversion.refine(inversion.LightCurve(**given, exposure=EXPOSURE), _start())
    wrong = inversion.refine(inversion.LightCurve(**given), _start())
    assert np.all(np.abs(off(right)) < 3.0)
    assert np.abs(off(right)).max() < np.abs(off(wrong)).max() > 2.0


def test_magnitudes_over_exposures_and_their_derivatives():
    """Five nodes against 21, of the true body, and derivatives against differences."""
    given = smeared(sigma=1e-12)
    curve = _problem.usable(inversion.LightCurve(**given, exposure=EXPOSURE))
    problem, _ = _problem.problem(curve, 1e-4, 0.02, "shared")
    assert len(problem.at_nodes()) == 5 * len(problem)
    fit = inversion.refine(curve, _start())
    state = fit.weighted.refined.state
    model = fit._model(problem)
    step = 1e-6
    change = np.zeros(len(model.jacobian))
    change[3] = step * np.abs(RATES).max()
    moved = _moving.MovingState(state.point.moved(change[: state.point.size]), state.shape)
    by = (fit._fit.model(problem, moved).magnitude - model.magnitude) / change[3]
    np.testing.assert_allclose(by, model.jacobian[3], atol=2e-4 * np.abs(by).max())
    # the true motion and body: five nodes against 21
    nodes = problem.at_nodes()
    middle = curve.epoch.seconds - SPIN.epoch.seconds
    matrix = FreeRotation(BODY, SPIN).at(nodes.t * problem.span + middle).matrix
    seen = [np.einsum("nij,in->nj", matrix, each) for each in (nodes.sun, nodes.observer)]
    at = -2.5 * np.log10(light_curve.brightness(SHAPE, "lommel-seeliger", *seen))
    mean = problem.mean_magnitudes(at) + 15.0
    np.testing.assert_allclose(mean, curve.magnitude, atol=1e-4)
    # a mean of fluxes: a constant flux stays, and that of a linear one is its middle
    at = np.zeros((5, len(problem))).reshape(-1)
    np.testing.assert_allclose(problem.mean_magnitudes(at), 0.0, atol=1e-15)
    instant, _ = _problem.problem(curve.replaced(exposure=None), 1e-4, 0.02, "shared")
    assert instant.at_nodes() is instant


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
    return inversion.refine(curve, _start(0.02, 0.001)), curve


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


def test_vectors_end_with_the_curve(fitted):
    curve = fitted[1]
    sun, observer = curve.vectors
    plain = curve.replaced(sun=sun, observer=observer)
    plain._set("scenes", {})
    fit = inversion.refine(plain, _start(0.02, 0.001))
    with pytest.raises(AttitudeError, match=r"outside of the light curve.*give path="):
        fit.predict([curve.seconds[-1] + DAY])
    there = fit.predict([curve.seconds[-1] + DAY], path=asteroid(), site="568")
    assert len(there.magnitude) == 1 and np.isfinite(there.sigma[0])


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
