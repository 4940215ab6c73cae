"""The sky of a ground site: against astropy and skyfield; light curves by day; the figure."""

import subprocess
import sys

import numpy as np
import pytest

from attitude import AttitudeError, Body, FreeRotation, Scene, Spin, epochs, paths
from attitude.formats import mission
from attitude.scene import _angles
from attitude.shape import Ellipsoid
from tests.support import earth_orientation
from tests.support.places import DATA

LONGITUDE = 20.3653
LATITUDE = 69.3482
HEIGHT = 157.0
TIMES = [f"2013-10-{day:02d}T{hour:02d}:20:00" for day in (22, 25) for hour in range(0, 24, 4)]


def site():
    return paths.site(f"{LONGITUDE} deg", f"{LATITUDE} deg", HEIGHT)


def scene(**options):
    spin = Spin(epoch=TIMES[0], wxyz=(1, 0, 0, 0), angular_velocity=(0, 0.01, 0.05))
    given = {"shape": Ellipsoid((5, 2, 2)), "aberration": True, "ephemeris": "builtin", **options}
    center = paths.tle(str(DATA / "paths" / "envisat-2013.tle"))
    return Scene(FreeRotation(Body(moments=(10, 20, 26)), spin), center, site(), **given)


def test_sun_and_moon_are_those_of_astropy():
    from astropy.coordinates import AltAz, EarthLocation, get_body, get_sun
    from astropy.time import Time

    place = EarthLocation.from_geodetic(LONGITUDE, LATITUDE, HEIGHT)
    time = Time(TIMES)
    frame = AltAz(obstime=time, location=place)
    view = scene().at(TIMES)
    with earth_orientation.installed():
        sun = get_body("sun", time, place).transform_to(frame)
        geocentric = get_sun(time).transform_to(frame)
        moon = get_body("moon", time, place).transform_to(frame)
        moon_seen = get_body("moon", time, place).cartesian
    np.testing.assert_allclose(view.sun_elevation, sun.alt.rad, rtol=0, atol=2e-6)
    # a parallax of 9 arcsec, its altitude without refraction
    np.testing.assert_allclose(view.sun_elevation, geocentric.alt.rad, rtol=0, atol=5e-5)
    np.testing.assert_allclose(view.moon_elevation, moon.alt.rad, rtol=0, atol=1e-5)
    towards = (moon_seen / moon_seen.norm()).xyz.value.T
    expected = np.arccos(np.sum(towards * view.apparent_direction, axis=-1))
    # Light and aberration of the body, which the Moon's direction of astropy lacks: 1e-4.
    np.testing.assert_allclose(view.moon_separation, expected, rtol=0, atol=1.5e-4)


def test_night_is_that_of_skyfield():
    from skyfield import almanac
    from skyfield.api import load, wgs84

    from attitude import events
    from tests.support.kernels import DE421

    planets = load(str(DE421)) if DE421 else pytest.skip("needs skyfield-data")
    timescale = load.timescale(builtin=True)
    place = wgs84.latlon(LATITUDE, LONGITUDE, HEIGHT)
    function = almanac.dark_twilight_day(planets, place)
    days = timescale.utc(2013, 10, 22), timescale.utc(2013, 10, 24)
    theirs, states = almanac.find_discrete(*days, function)
    planets.close()
    dark = Scene(None, "moon", site(), aberration=True, ephemeris="builtin")
    sun = dark.quantity("sun_elevation")
    for limit, state in ((-18.0, 0), (-12.0, 1), (-6.0, 2)):
        found = events.find_discrete("2013-10-22", "2013-10-24", sun < f"{limit} deg")
        edge = np.flatnonzero((np.minimum(states, np.roll(states, 1)) == state)
                              & (np.maximum(states, np.roll(states, 1)) == state + 1))  # fmt: skip
        edge = edge[edge > 0]
        wanted = np.array([epochs.instant(theirs[int(k)]).seconds for k in edge])
        own = found.seconds[np.argmin(np.abs(found.seconds[:, None] - wanted), axis=0)]
        assert len(wanted) >= 3
        np.testing.assert_allclose(own, wanted, atol=1.0)  # skyfield's polar motion and kernel


@pytest.mark.parametrize("latitude", [-90.0, 90.0])
def test_azimuths_at_a_pole_are_those_beside_it(latitude):
    at_pole, beside = (
        Scene(None, "moon", paths.site("30 deg", f"{at} deg"), ephemeris="builtin").at(TIMES)
        for at in (latitude, 0.99999999 * latitude)
    )
    np.testing.assert_allclose(at_pole.azimuth, beside.azimuth, atol=1e-7)


def test_air_mass_against_closed_form_and_the_almanac():
    elevation = np.radians([90.0, 60.0, 30.0, 10.0, 5.0, 0.0, -0.1])
    found = _angles.air_mass(elevation)
    assert found[0] == pytest.approx(1.0, abs=1e-5)
    # The secant, and Kasten and Young (1989), whose elevations are refracted ones: 0.8 % at 10 deg.
    np.testing.assert_allclose(found[:3], 1 / np.sin(elevation[:3]), rtol=5e-3)
    kasten = 1 / (np.sin(elevation) + 0.50572 * (np.degrees(elevation) + 6.07995) ** -1.6364)
    np.testing.assert_allclose(found[:4], kasten[:4], rtol=1e-2)
    assert found[5] == pytest.approx(31.7, abs=0.1) and np.isnan(found[6])


def test_magnitudes_by_day_and_below_the_horizon_are_nan_unless_told_otherwise():
    t = np.arange(0.0, 86400.0, 60.0)
    view = scene().at(t)
    hidden = (view.elevation <= 0) | (view.sun_elevation >= np.radians(-6))
    assert 0.9 < hidden.mean() < 1.0
    np.testing.assert_array_equal(np.isnan(view.magnitude), hidden)
    np.testing.assert_array_equal(view.is_observable, ~hidden)
    everywhere = scene(site_limits=False).at(t)
    assert not np.isnan(everywhere.magnitude).any()
    np.testing.assert_array_equal(view.magnitude[~hidden], everywhere.magnitude[~hidden])
    assert not np.isnan(view.reduced_magnitude).any()
    darker = scene(night="-18 deg").at(t)
    assert np.sum(darker.sky_dark) < np.sum(view.sky_dark)
    from_space = Scene(view.scene.motion, view.scene.center, "moon", shape=Ellipsoid((5, 2, 2)))
    assert from_space.at([0.0]).is_observable.all() and not np.isnan(from_space.at(0.0).magnitude)


@pytest.mark.parametrize("name", ["sun_elevation", "moon_elevation", "airmass", "azimuth"])
def test_an_observer_without_a_horizon(name):
    seen = Scene(None, "moon", "earth", ephemeris="builtin").at(TIMES[:1])
    with pytest.raises(AttitudeError, match="has no horizon; give a ground site"):
        getattr(seen, name)


MISSION = """
spin = "{data}/spin/envisat.toml"
center = {{ tle = "{data}/paths/envisat-2013.tle" }}
observer = {{ site = "20.3653, 69.3482 deg", height = "157 m" }}
shape.ellipsoid = "10, 4, 4 m"
{more}
[times]
start = "2013-10-23T13:30:00"
stop = "2013-10-23T17:30:00"
step = "60 s"
"""


def test_the_command_and_its_figure(tmp_path):
    (tmp_path / "m.toml").write_text(MISSION.format(data=DATA, more=""))
    outputs = ["--output", "x.csv", "--figure", "x.svg"]
    run = subprocess.run(
        [sys.executable, "-m", "attitude", "lightcurve", "m.toml", *outputs],
        cwd=tmp_path, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert run.returncode == 0, run.stderr
    rows = (tmp_path / "x.csv").read_text().splitlines()[1:]
    magnitude = np.array([float(row.split(",")[2]) for row in rows])
    assert 0.5 < np.isnan(magnitude).mean() < 1.0
    found = mission.parse(MISSION.format(data=DATA, more="site_limits = false\nnight = '-1 deg'"))
    assert not found.scene.site_limits and found.scene.night == np.radians(-1.0)


def test_the_figure_names_what_it_shades():
    from attitude.cli import lightcurve

    found = mission.parse(MISSION.format(data=DATA, more=""))
    t = np.arange(0.0, 4 * 3600.0, 60.0)
    start = epochs.instant("2013-10-23T13:30:00")
    view = found.scene.since(start, t)
    figure = lightcurve.of(
        found, epoch=view.epoch, seconds=view.seconds, magnitude=found.magnitude.of(view),
        phase_angle=view.phase_angle, lit_fraction=view.lit_fraction, elevation=view.elevation,
        sun_elevation=view.sun_elevation,
    )  # fmt: skip
    labels = figure.axes[0].get_legend_handles_labels()[1]
    shaded = {"day", "twilight", "in the umbra of another body", "below the horizon"}
    assert shaded <= set(labels)
