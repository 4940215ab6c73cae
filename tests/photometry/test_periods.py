"""Periods from photometry: reduction, one period, two periods, errors, candidates, commands."""

import re
import signal
import time
import warnings

import numpy as np
import pytest
from astropy import units
from astropy.coordinates import CartesianRepresentation, EarthLocation, SkyCoord
from astropy.time import Time
from astropy.timeseries import LombScargle

from attitude import AttitudeError, cli, paths, photometry, scattering
from attitude._support.constants import ASTRONOMICAL_UNIT_M as AU
from attitude._support.constants import SPEED_OF_LIGHT_M_S as C
from attitude.errors import AttitudeWarning
from attitude.photometry import _lattices, _periodogram, _samples, _spectrum
from attitude.scene import Scene
from tests.support.places import PHOTOMETRY

HOUR = 3600.0
DAY = 86400.0


def nights(count=12, per_night=25, seed=0):
    """Epochs in s of nights of 8 hours at one site."""
    generator = np.random.default_rng(seed)
    each = np.sort(generator.uniform(0.0, 8.0 * HOUR, (count, per_night)), axis=1)
    return (each + DAY * np.arange(count)[:, None]).reshape(-1)


def tumbler(t, first=5.31 * HOUR, second=17.9 * HOUR, noise=0.01, seed=1):
    """Lines of a body whose long axis turns with `second`, and the spin about it with `first`."""
    generator = np.random.default_rng(seed)
    f, g = 1.0 / second, 1.0 / first
    y = 0.4 * np.cos(2 * np.pi * 2 * f * t + 1.0) + 0.2 * np.cos(2 * np.pi * (f + 2 * g) * t)
    y = y + 0.15 * np.cos(2 * np.pi * (2 * f + 2 * g) * t + 2.0) + 0.05 * np.cos(4 * np.pi * g * t)
    return y + noise * generator.normal(size=t.size)


# Samples ------------------------------------------------------------------------------------------


def test_series_take_times_quantities_and_light_curves():
    """The same series from seconds, days with a unit, Times, dates and a light curve."""
    t = np.linspace(0.0, 40.0, 300) * DAY
    y = 15.0 + 0.3 * np.cos(2 * np.pi * (1 / (3.1 * DAY) + 1 / (7.7 * DAY)) * t)
    plain = photometry.fit_series(t, y, 7.7 * DAY, 3.1 * DAY)
    assert plain.rms < 1e-13
    times = Time(2448827.0, t / DAY, format="jd", scale="tdb")
    data = photometry.LightCurve(times, y * units.mag)
    for found in (
        photometry.fit_series(t / DAY * units.day, y, "7.7 d", "3.1 d"),
        photometry.fit_series(times, y * units.mag, 7.7 * units.day, 3.1 * units.day),
        photometry.fit_series(data, P_psi="7.7 d", P_phi="3.1 d"),
        photometry.fit_series(times.isot, y, "7.7 d", "3.1 d"),
    ):
        assert found.rms < 1e-6 and found.strongest(1)[0][1] == pytest.approx(0.3, abs=1e-6)
    assert photometry.fit_series(data, P_psi="7.7 d", P_phi="3.1 d")(times[:5]) == pytest.approx(
        y[:5]
    )
    with pytest.warns(AttitudeWarning, match="looks like a Julian date"):
        _samples.of(times.jd, y)
    with pytest.raises(AttitudeError, match="leave those arguments out"):
        photometry.fit_series(data, y, "7.7 d", "3.1 d")
    with pytest.raises(AttitudeError, match="P_phi is missing"):
        photometry.fit_series(data, P_psi="7.7 d")
    with pytest.raises(AttitudeError, match="values is missing"):
        photometry.fit_series(t, P_psi="7.7 d", P_phi="1 d")


def test_errors_in_another_unit_than_the_values():
    t, y = np.arange(50.0), np.cos(np.arange(50.0))
    one = _samples.of(t, y * units.mag, np.full(50, 20.0) * units.mmag)
    np.testing.assert_allclose(one.errors, 0.02)
    with pytest.raises(AttitudeError, match="errors is in Jy; give it in mag"):
        _samples.of(t, y * units.mag, 1.0 * units.Jy)


@pytest.mark.parametrize("size", [1.0, 1e-10, 1e12])
def test_errors_of_periods_do_not_depend_on_the_size_of_the_values(size):
    t, generator = nights(), np.random.default_rng(3)
    y = np.cos(2 * np.pi * t / (6.0 * HOUR)) + 0.1 * generator.normal(size=t.size) + 15.0
    expected = photometry.fold(t, "6 h", y, order=1).series.errors
    found = photometry.fold(t, "6 h", size * y, order=1).series.errors
    np.testing.assert_allclose(found, expected, rtol=1e-6)
    assert 1e-5 < found[0] * 6.0 * HOUR < 1e-3


@pytest.mark.parametrize("options", [{}, {"method": "pdm"}, {"count": 2, "order": 1}])
def test_values_that_do_not_vary_have_no_period(options):
    t = nights()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for y in (np.full(t.size, 15.1), np.repeat([15.1, 15.3], t.size // 2)):
            numbers = (y > 15.2).astype(int)
            with pytest.raises(AttitudeError, match="300 values do not vary"):
                photometry.periods(t, y, curve=numbers, min_period="2 h", **options)
            with pytest.raises(AttitudeError, match="300 values do not vary"):
                photometry.fold(t, "6 h", y, curve=numbers)


@pytest.mark.parametrize(("size", "error"), [(1e300, 1.0), (1e-300, None), (1.0, 1e-302)])
def test_numbers_whose_squares_are_no_doubles_are_refused(size, error):
    t = np.arange(50.0)
    errors = None if error is None else np.full(50, error)
    with pytest.raises(AttitudeError, match="in which they lie between 1e-70 and 1e\\+70"):
        photometry.periods(t, size * np.cos(t), errors)


@pytest.mark.parametrize("count", [1, 2])
@pytest.mark.parametrize("bounds", [{"min_period": 0}, {"max_period": 0.0}, {"min_period": -1}])
def test_bounds_of_periods_are_above_zero(count, bounds):
    t = nights()
    name, bound = next(iter(bounds.items()))
    options = {"min_period": "2 h"} | bounds
    with pytest.raises(AttitudeError, match=rf"{name} is {bound:.1f}; it must be greater"):
        photometry.periods(t, tumbler(t), count=count, **options)


# Reduction ----------------------------------------------------------------------------------------


def circle():
    return paths.kepler(
        semi_major_axis="2 au", eccentricity=0.1, inclination="5 deg", node="40 deg",
        pericenter_argument="10 deg", mean_anomaly="60 deg", epoch="2026-01-01",
    )  # fmt: skip


def test_reduction_takes_off_distances_light_time_and_phase():
    times = Time("2026-01-01") + np.arange(30) * units.day
    data = photometry.LightCurve(times, magnitude=np.full(30, 15.0), site="500")
    found = data.reduced(circle(), site="earth", g=0.15)
    far = [np.linalg.norm(each, axis=1) / AU for each in (found.sun, found.observer)]
    late = (times - found.times).to_value("s")
    np.testing.assert_allclose(late, far[1] * AU / C, rtol=1e-9, atol=1e-5)
    alpha = photometry.phase_angle(found)
    phase = scattering.hg(alpha, 0.0, 0.15) - scattering.hg(np.zeros(1), 0.0, 0.15)[0]
    np.testing.assert_allclose(
        found.value, 15.0 - 5.0 * np.log10(far[0] * far[1]) - phase, atol=1e-12
    )
    assert found.time_of == "emission" and found.unit_distances and found.zero_phase
    again = found.reduced()  # nothing more to take off
    np.testing.assert_allclose(again.value, found.value)
    flux = photometry.LightCurve(times, flux=np.full(30, 2.0)).reduced(circle())
    np.testing.assert_allclose(flux.value, 2.0 * (far[0] * far[1]) ** 2, rtol=1e-12)
    with pytest.raises(AttitudeError, match="no vectors to Sun and observer"):
        data.reduced()
    with pytest.raises(AttitudeError, match="at zero phase angle already"):
        found.reduced(g=0.1)


@pytest.mark.parametrize("site", [None, "-70.7, -30.2 deg, 2700 m"])
@pytest.mark.parametrize("time_of", ["barycenter", "heliocenter"])
def test_dates_at_a_center_become_those_of_the_observer(site, time_of):
    """BJD and HJD that astropy makes are taken back, also those of a place on the ground."""
    place = EarthLocation.from_geocentric(0, 0, 0, unit="m")
    if site is not None:
        place = EarthLocation.from_geodetic(-70.7, -30.2, 2700.0)
    times = Time("2025-01-01", scale="utc", location=place) + np.arange(5) * 60.3 * units.day
    direct = photometry.LightCurve(times, magnitude=np.full(5, 15.0), path=circle(), site=site)
    towards = SkyCoord(CartesianRepresentation(-direct.observer.T), frame="icrs")
    delay = times.light_travel_time(SkyCoord(towards.ra, towards.dec), f"{time_of[:-2]}ric")
    data = photometry.LightCurve(times.tdb + delay, magnitude=np.full(5, 15.0), time_of=time_of)
    found = data.reduced(circle(), site=site)
    late = (found.times - direct.reduced().times).to_value("s")
    np.testing.assert_allclose(late, 0.0, atol=1e-4)


def test_a_scene_without_light_time_takes_none_off():
    times = Time("2026-01-01") + np.arange(5) * units.day
    scene = Scene(None, circle(), "earth", light_time=False)
    data = photometry.LightCurve(times, magnitude=np.full(5, 15.0), scene=scene)
    np.testing.assert_array_equal(data.emission, data.seconds)
    assert np.abs((data.times - times).to_value("s")).max() < 1e-6 and data.time_of == "emission"


def test_fits_of_series_have_the_terms_of_the_phase_angle():
    """Those of `fold`, so that both leave the same residuals."""
    times = Time("2026-01-01") + np.linspace(0.0, 60.0, 300) * units.day
    data = photometry.LightCurve(times, magnitude=np.zeros(300), path=circle())
    t, generator = data.emission, np.random.default_rng(2)
    y = np.cos(2 * np.pi * t / (7.0 * HOUR)) + np.cos(2 * np.pi * t / (31.0 * HOUR))
    phase = 2.0 * photometry.phase_angle(data)
    data = data.replaced(magnitude=y + phase + data.dimming + 0.01 * generator.normal(size=300))
    fitted = photometry.fit_series(data, P_psi="31 h", P_phi="7 h", order=1)
    folded = photometry.fold(data, ["31 h", "7 h"], order=1)
    np.testing.assert_allclose(fitted.residuals, folded.residuals, atol=1e-9)
    assert fitted.rms < 0.012


def test_photometry_is_written_and_read(tmp_path):
    times = Time("2026-01-01") + np.arange(25) * units.day
    data = photometry.LightCurve(
        times,
        magnitude=15.0 + np.arange(25) / 7,
        sigma=0.02,
        filter="V",
        session="a, b",
        site="568",
    )
    for each in (data, data.reduced(circle(), site="earth")):
        each.write(tmp_path / "a.csv")
        back = photometry.read(tmp_path / "a.csv")
        np.testing.assert_array_equal(back.value, each.value)
        assert back.time_of == each.time_of and back.unit_distances == each.unit_distances
        assert back.sessions == ("a, b",)
        assert np.abs((back.times - each.times).to_value("s")).max() < 1e-6


# One period ---------------------------------------------------------------------------------------


@pytest.mark.parametrize("method", ["fourier", "pdm"])
def test_one_period_with_its_error_and_aliases(method):
    t = nights()
    turn = 2 * np.pi * t / (7.37 * HOUR)
    y = 0.3 * np.cos(2 * turn) + 0.1 * np.cos(turn + 1)
    y = y + 0.02 * np.random.default_rng(3).normal(size=t.size)
    found = photometry.periods(
        t, y, np.full(t.size, 0.02), min_period="3 h", max_period="30 h", method=method
    )
    assert abs(found.period - 7.37 * HOUR) < 5.0 * found.error < 30.0
    assert found[0].power > 5.0 * (1.0 - found.false_alarm)
    words = [each.relation for each in found.peaks]
    assert any("alias of" in each and "1 /d)" in each for each in words)
    assert any(each == "1/2 of #1" for each in words)
    assert len(found.table()) == len(found.peaks)
    window = found.plot().axes[1]
    words = [text.get_text() for text in window.get_legend().get_texts()]
    assert words == [f"{f * DAY:.4g} /d" for f in sorted(line[0] for line in found.window.lines)]
    assert not window.texts  # which would overlap


@pytest.mark.parametrize("order", [1, 2, 4])
@pytest.mark.parametrize("has_errors", [False, True])
def test_power_is_that_of_least_squares(order, has_errors):
    """Those of astropy, at nights that see all phases of every period searched."""
    t, generator = nights(), np.random.default_rng(3)
    t = t + generator.uniform(0.0, 3.0, 12).repeat(25) * HOUR * 8.0
    y = tumbler(t) + 15.0
    errors = generator.uniform(0.01, 0.3, t.size) if has_errors else None
    found = photometry.periods(t, y, errors, min_period="2 h", order=order)
    used = found.samples.errors
    series = LombScargle(t - t.min(), y, used, nterms=order)
    power = series.power(found.frequency, method="chi2")
    np.testing.assert_allclose(found.power, power, atol=1e-8)


@pytest.mark.parametrize("of_night", [0.0, 0.1])
def test_errors_and_those_by_bootstrap_are_those_of_repeated_noise(of_night):
    """To a factor of 1.6 of the scatter over 30 light curves, also where phases differ by night."""
    t, found = nights(), []
    for seed in range(30):
        generator = np.random.default_rng(seed)
        noise = 0.05 * generator.normal(size=t.size)
        angle = 2 * np.pi * t / (5.0 * HOUR)
        noise += of_night * generator.normal(size=12).repeat(25) * np.sin(angle)
        y = 0.3 * np.cos(angle) + noise
        data = _samples.of(t, y)
        found.append(_spectrum.refined(data, np.array([1 / (5.0 * HOUR)]), np.array([[1]])))
    f = np.array([each.frequencies[0] for each in found])
    scatter = np.std(f, ddof=1)
    assert 1 / 1.6 < found[0].errors[0] / scatter < 1.6
    drawn = _spectrum.bootstrap(data, found[-1], 100, 0)
    assert 1 / 1.6 < np.std(drawn) / scatter < 1.6


def _slow():
    """Two periods of days in 60 sessions of three hours, errors of 0.03 mag."""
    generator = np.random.default_rng(12)
    session = np.repeat(np.arange(60), 5)
    t = DAY * (2.3 * session + generator.uniform(0.0, 0.125, 300))
    first, second = 2.0 * np.pi * t / (5.3 * DAY), 2.0 * np.pi * t / (3.7 * DAY)
    y = 0.4 * np.cos(2.0 * first) + 0.3 * np.cos(first + second)
    y += 0.03 * generator.normal(size=300)
    times = Time("2026-01-01", scale="tdb") + t * units.s
    return photometry.LightCurve(times, magnitude=y, sigma=0.03, session=session)


def test_periods_of_days_in_sessions_of_hours():
    """Zero points of the sessions would take up three quarters of it; the data need one."""
    data = _slow()
    bounds = {"min_period": "1.5 d", "max_period": "20 d"}
    found = photometry.periods(data, order=2, keep=3, **bounds, count=2)
    assert found.samples.curves == 1 and found[0].left < 0.02
    free = photometry.periods(data, order=2, keep=3, zero_points="free", **bounds, count=2)
    assert free.samples.curves == 60
    lines = [line.frequency * DAY for line, _ in found.lines()[:2]]
    expected = [2.0 / 5.3, 1.0 / 5.3 + 1.0 / 3.7]
    assert lines == pytest.approx(expected, abs=5e-4)  # a tenth of 1/span
    folded = photometry.fold(data, ["5.3 d", "3.7 d"], order=2)
    assert folded.samples.curves == 1 and folded.rms < 0.035
    one = photometry.periods(data, order=1, **bounds)
    assert one.samples.curves == 1 and one.period == pytest.approx(0.5 * 5.3 * DAY, rel=2e-3)


def test_peaks_lie_in_the_range_of_periods_and_in_the_order_of_their_power():
    """Half a period lies just outside of the range: its slope may lead a refinement there."""
    t = nights()
    y = np.cos(2 * np.pi * t / (6.1 * HOUR)) + 0.1 * np.random.default_rng(3).normal(size=t.size)
    for bounds in (("6.15 h", "14 h"), ("3 h", "6.05 h"), ("5 h", "7 h")):
        found = photometry.periods(t, y, min_period=bounds[0], max_period=bounds[1], keep=20)
        low, high = (float(each[:-2]) * HOUR for each in bounds)
        periods = np.array([each.period for each in found.peaks])
        assert np.all((periods >= low * (1 - 1e-12)) & (periods <= high * (1 + 1e-12)))
        assert np.all(np.diff([each.power for each in found.peaks]) <= 0.0)
    rising = photometry.periods(t, t, min_period="180 h", max_period="250 h")
    assert rising[0].relation == "at the longest period searched"


def test_zero_points_of_sessions_are_free():
    t = nights()
    session = (t // DAY).astype(int)
    y = (
        0.2 * np.cos(2 * np.pi * t / (6.1 * HOUR))
        + np.random.default_rng(0).normal(size=12)[session]
    )
    times = Time("2026-01-01", scale="tdb") + t * units.s
    data = photometry.LightCurve(times, magnitude=y, session=session)
    found = photometry.periods(data, min_period="3 h", max_period="20 h", order=1)
    assert found.period == pytest.approx(6.1 * HOUR, rel=1e-9)
    folded = photometry.fold(data, "6.1 h")
    assert folded.rms < 1e-9 and np.ptp(folded.curve(np.linspace(0, 1, 100))) == pytest.approx(
        0.4, abs=1e-3
    )


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"min_period": "30 h", "max_period": "3 h"}, "give a shorter min_period"),
        ({"min_period": "0.01 s"}, "at most 5000000 are searched"),
        ({"method": "box"}, "method is 'box'"),
        ({"order": 0}, "order is 0"),
        ({"order": 200}, "give more values, or a lower order"),
        ({"count": 2.0}, r"count is 2\.0; give 1 period or 2"),
        ({"errors": np.ones(7)}, r"errors has shape \(7,\); give a single number, or one for each"),
    ],
)
def test_wrong_arguments(options, words):
    t = nights(6)
    with pytest.raises(AttitudeError, match=words):
        photometry.periods(t, np.cos(t), **options)


@pytest.mark.parametrize("rank", [99, 1.0, "0"])
@pytest.mark.parametrize("name", ["fold", "lines", "bootstrap"])
def test_peaks_that_are_not_there(name, rank):
    t = nights(2)
    peaks = photometry.periods(t, np.cos(t / HOUR), min_period="3 h", max_period="9 h", order=1)
    with pytest.raises(AttitudeError, match=f"rank is {rank!r}; give a whole number from 0"):
        getattr(peaks, name)(rank)


@pytest.mark.parametrize("chosen", [[0.5], ["a"], [99], [[1], [1, 2]]])
def test_points_that_are_not_there(chosen):
    data = photometry.LightCurve([0.0, 1.0, 2.0], [15.0, 15.1, 15.2], epoch="2026-01-01")
    with pytest.raises(AttitudeError, match=r"chosen is .*; give whole numbers from 0 to 2\."):
        data.replaced(chosen)


def test_relations_of_periods_in_words():
    line = _periodogram.WindowLine(1 / DAY, 0.9)
    near = 1e-8
    f = 1 / (5 * HOUR)
    assert _periodogram.relation(2 * f, [f], [line], near) == "1/2 of #1"
    assert _periodogram.relation(f / 2, [f], [line], near) == "2 x #1"
    assert _periodogram.relation(f + 1 / DAY, [f], [line], near) == "alias of #1 (+1 /d)"
    shifted = _periodogram.relation(f / 2 + 1 / DAY, [f], [line], near)
    assert shifted == "alias of 2 x #1 (+1 /d)"
    assert _periodogram.relation(f * 1.234, [f], [line], near) == ""
    # within the 1/span of six nights of 3/4 f and of f: the nearest counts, the plainest of equals
    f, few = 3.8624 / DAY, 0.168 / DAY
    for shift, words in ((-0.998, "-1"), (1.002, "+1"), (-0.497, "-1/2"), (0.497, "+1/2")):
        found = _periodogram.relation(f + shift / DAY, [f, 2 * f], [line], few)
        assert found == f"alias of #1 ({words} /d)"
    assert _periodogram.relation(f * 0.749, [f, 2 * f], [line], few) == "4/3 of #1"


# Two periods --------------------------------------------------------------------------------------


LIMITS = {"min_period": "2 h", "max_period": "40 h"}


@pytest.fixture(scope="module")
def blind():
    """Epochs and brightness of a tumbler, and its pairs of periods."""
    t = nights(14, 30)
    y = tumbler(t)
    return t, y, photometry.periods(t, y, np.full(t.size, 0.01), **LIMITS, keep=8, count=2)


def test_two_periods_blind(blind, tmp_path):
    t, y, found = blind
    # lines at i/P_phi + 2 j/P_psi: the lattice of 1/P_phi and 2/P_psi
    base = np.array([1 / (17.9 * HOUR), 2 / (5.31 * HOUR)])
    pair = found[0]
    for each in pair.frequencies:
        combos = [abs(a * base[0] + b * base[1] - each) for a in range(-4, 5) for b in range(-2, 3)]
        assert min(combos) < 0.1 / np.ptp(t)
    assert pair.left < 0.01 < found.false_alarm and found.tried > 10_000
    first, second = found.bootstrap(draws=20)
    assert 0.2 < first / pair.errors[0] < 5.0 and 0.2 < second / pair.errors[1] < 5.0
    assert any(
        each.P_phi_long == pytest.approx(17.9 * HOUR, rel=1e-3) for each in found.candidates()
    )
    figure = found.plot(tmp_path / "two.png")
    legend = figure.axes[0].get_legend().get_texts()  # marks, since numbers beside pairs overlap
    assert [text.get_text() for text in legend] == ["#1", "#2", "#3", "#4", "#5"]
    assert not figure.axes[0].texts
    found.fold().plot(tmp_path / "fold.png")
    assert (tmp_path / "two.png").stat().st_size > 10_000
    with pytest.raises(AttitudeError, match=r"pairs, and at most"):
        photometry.periods(t, y, min_period="1 s", count=2)


def test_many_pairs_are_ranked_by_their_powers_first(blind, monkeypatch):
    """With a limit of a fifth of the pairs the best one is the same."""
    t, y, whole = blind
    monkeypatch.setattr(_spectrum, "MOST", whole.tried // 5)
    part = photometry.periods(t, y, np.full(t.size, 0.01), **LIMITS, keep=3, count=2)
    assert part[0].left == pytest.approx(whole[0].left, rel=1e-6)


def test_candidates_of_known_lines():
    """Lines of Apophis (Pravec et al. 2014): SAM, P_psi 263 h, P_phi 27.38 h of the short axis."""
    psi, long_axis = 1 / (263 * HOUR), 1 / (27.38 * HOUR) - 1 / (263 * HOUR)
    f = np.array([2 * long_axis, long_axis + psi])
    numbers = np.array([[1, 0], [0, 1], [0, 2], [1, 1], [2, 0]])
    amplitudes = np.array([0.4, 0.12, 0.05, 0.01, 0.03])
    series = _spectrum.RefinedSeries(
        f, np.eye(2), numbers, np.zeros(1), amplitudes, np.zeros(5), 0.0, np.zeros(1), 0.0, 1
    )
    best = _lattices.ranked([(0, 0.01, series)], 1 / (100 * DAY), 3)[0]
    assert best.mode == "SAM" and best.P_psi == pytest.approx(263 * HOUR, rel=1e-9)
    assert best.P_phi == pytest.approx(27.38 * HOUR, rel=1e-9)
    assert best.P_phi_long == pytest.approx(30.56 * HOUR, rel=1e-3)


def test_periods_show_themselves_in_notebooks():
    """A table of the peaks, and the folded light curve with a dot for each point."""
    data = photometry.LightCurve.read(PHOTOMETRY)
    one = photometry.periods(data, min_period="2 d")
    page = one._repr_html_()
    assert f"{one.period / DAY:.7g} d" in page and "significant" in page
    dots = re.search(r'<path d="([^"]*)"', page).group(1)
    assert dots.count("M") == len(one.samples.t)
    two = photometry.periods(data, count=2, min_period="2 d")._repr_html_()
    assert "first [d]" in two and "second [d]" in two


def test_plain_frequencies_that_are_absurd_for_the_span_warn():
    """0.5 is 0.5 Hz, 8e6 turns in 188 days; with a unit, and of a fast body, nothing is doubted."""
    t = photometry.LightCurve.read(PHOTOMETRY).seconds
    with pytest.warns(AttitudeWarning, match=r"0.5 without a unit, which is Hz: 8.15e\+06 turns"):
        _samples.warn_of_plain(0.5, "max_frequency", t, "Hz")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        _samples.warn_of_plain("0.5 /d", "max_frequency", t, "Hz")
        _samples.warn_of_plain(0.02, "max_frequency", np.linspace(0.0, 600.0, 200), "Hz")
    assert _samples.is_plain("0.5, 1e-3") and not _samples.is_plain("0.5 mHz")


def test_plain_numbers_that_are_absurd_for_the_span_warn():
    """5.36 and 7.4 are seconds: 3e6 turns in 188 days; those of a fast body are not doubted."""
    data = photometry.LightCurve.read(PHOTOMETRY)
    with pytest.warns(AttitudeWarning, match=r"period is 5.36, 7.4 without a unit, which is sec"):
        photometry.fold(data, "5.36, 7.4", order=2)
    with (
        pytest.warns(AttitudeWarning, match="min_period is 2 without a unit"),
        pytest.raises(AttitudeError, match="at most 5000000 are searched"),
    ):
        photometry.periods(data, min_period=2, max_period="40 d")
    t = np.arange(0.0, 600.0, 0.5)
    y = np.cos(2 * np.pi * t / 5.36)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert photometry.fold(t, 5.36, y).rms < 1e-9
        photometry.fold(data, "5.36, 7.4 d", order=2)
        assert photometry.periods(t, y, order=1, min_period=2.0).period == pytest.approx(5.36)


def test_two_maxima_a_turn_are_hinted_at():
    """A series of two harmonics fits half of the period of an elongated body as well."""
    t = nights()
    y = 0.3 * np.cos(4 * np.pi * t / (7.4 * HOUR)) + 0.01 * np.random.default_rng(1).normal(
        size=t.size
    )
    found = photometry.periods(t, y, min_period="2 h", max_period="6 h")
    assert found.period == pytest.approx(3.7 * HOUR, rel=1e-3)
    assert "one maximum in the best period" in found.hint and "may take 7.39" in found.hint
    assert photometry.periods(t, y, min_period="6.5 h", max_period="8 h").hint == ""


# Commands -----------------------------------------------------------------------------------------


def test_commands(tmp_path, capsys, monkeypatch):
    """Toutatis, 1992: P_phi 7.4 d and P_psi 5.4 d (Zhao et al. 2015) from the photometry alone."""
    given = [str(PHOTOMETRY), "--zero-points", "shared", "--g", "0.15"]
    figure = tmp_path / "p.png"
    limits = ["--min", "1 d", "--max", "40 d"]
    assert cli.main(["periods", *given, *limits, "--figure", str(figure)]) == 0
    text = capsys.readouterr().out
    best = next(line for line in text.splitlines() if line.startswith("  1 "))
    assert "period, d" in text and float(best.split()[1]) == pytest.approx(7.40, abs=0.02)
    assert figure.stat().st_size > 10_000
    monkeypatch.setattr("sys.stderr.isatty", lambda: True, raising=False)
    monkeypatch.setattr("attitude._support.blocks._PATIENCE", 0.0)
    assert cli.main(["periods", *given, *limits, "--two"]) == 0
    text, err = capsys.readouterr()
    assert "pairs of periods" in err and err.endswith("100 %\n")
    best = next(line for line in text.splitlines() if line.startswith("  1 "))
    first, second = float(best.split()[1]), float(best.split()[3])
    assert first == pytest.approx(7.40, abs=0.03) and second == pytest.approx(5.38, abs=0.03)
    table = tmp_path / "f.csv"
    fold = ["fold", *given, "--period", "5.36, 7.4 d", "--refine", "--output", str(table)]
    assert cli.main([*fold, "--figure", str(tmp_path / "f.png")]) == 0
    assert "rms of the residuals" in capsys.readouterr().out
    assert table.read_text().startswith("time,phase_1,value_1")


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("periods", "none.csv"), "cannot be read"),
        (("periods", str(PHOTOMETRY), "--min", "three"), "not a number with a unit"),
        (("periods", str(PHOTOMETRY), "--figure", "a.doc"), "ends in .png"),
        (("periods", str(PHOTOMETRY), "--filter", "V"), "filter is 'V'"),
        (("periods", str(PHOTOMETRY), "--two", "--order", "5"), "order is 5"),
        (("fold", str(PHOTOMETRY), "--period", "5 kg"), "give it in s"),
        (("fold", str(PHOTOMETRY), "--period", "1, 2, 3 h"), "give one time or two"),
    ],
)
def test_wrong_commands(capsys, arguments, words):
    assert cli.main(list(arguments)) == 2
    assert words in capsys.readouterr().err


# Ctrl-C -------------------------------------------------------------------------------------------


def longest_silence(work):
    """The longest time, s of processor, in which Python acts on no signal while `work` runs."""
    heard = [time.process_time()]
    other = signal.signal(signal.SIGPROF, lambda *_: heard.append(time.process_time()))
    signal.setitimer(signal.ITIMER_PROF, 0.01, 0.01)
    try:
        work()
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0.0)
        signal.signal(signal.SIGPROF, other)
    return np.diff([*heard, time.process_time()]).max()


@pytest.mark.skipif(not hasattr(signal, "setitimer"), reason="no timers of processor time")
def test_searches_hear_signals_soon(monkeypatch):
    """0.2 s are felt as at once; compiled loops over all pairs, or all points, took 0.3 to 2 s."""
    monkeypatch.setattr(_periodogram, "_PERMUTATIONS", 1)
    t = np.sort(np.random.default_rng(0).uniform(0.0, 60.0 * DAY, 1000))
    y, few = tumbler(t), slice(100)
    photometry.periods(t[few], y[few], min_period="24 h", max_period="40 h", count=2)  # compiles
    photometry.periods(t[few], y[few], min_period="24 h", method="pdm")
    photometry.periods(t[few], y[few], min_period="24 h")
    work = (
        lambda: photometry.periods(t, y, min_period="4 h", max_period="40 h", count=2),
        lambda: photometry.periods(t, y, min_period="0.5 h", method="pdm"),
        lambda: photometry.periods(t, y, min_period="0.5 h", order=4),
    )
    assert [round(each, 2) for each in map(longest_silence, work) if each > 0.2] == []


def test_two_periods_whose_series_add():
    """A rotation and dips at the orbit of a moon: no line lies at a sum or a difference."""
    rng = np.random.default_rng(3)
    t = np.sort(rng.uniform(0.0, 8.0, 300))
    rotation, orbit = 0.1633, 0.9137
    magnitude = 0.21 * np.cos(4.0 * np.pi * t / rotation) + 0.05 * np.cos(
        2.0 * np.pi * t / rotation
    )
    for place, depth in ((0.3, 0.12), (0.8, 0.08)):
        off = np.mod(t / orbit - place + 0.5, 1.0) - 0.5
        magnitude += depth * np.exp(-0.5 * (off / 0.04) ** 2)
    magnitude += 0.01 * rng.normal(size=t.size)
    given = {"count": 2, "min_period": "3 h", "max_period": "1.5 d", "order": 6}
    found = photometry.periods(t * 86400.0, magnitude, method="additive", **given)
    assert found.method == "additive"
    assert np.array(found[0].periods) / 86400.0 == pytest.approx([orbit, rotation], rel=2e-3)
    assert found[0].left < min(0.02, found.false_alarm)
    lines = found.fold(0)
    assert lines is not None
    with pytest.raises(AttitudeError, match="give count=2"):
        photometry.periods(t * 86400.0, magnitude, method="additive")
    with pytest.raises(AttitudeError, match="give 1 to 8"):
        photometry.periods(t * 86400.0, magnitude, method="additive", count=2, order=9)
