"""Scenes against skyfield, SPICE and scipy on the same kernel, and what they leave out."""

import pickle

import numpy as np
import pytest
from skyfield.relativity import add_aberration

from attitude import AttitudeError, Body, FreeRotation, Spin, epochs, light_curve, paths, scattering
from attitude.epochs import _time_scales
from attitude.frames._earth import timescale
from attitude.paths._path import Path, julian
from attitude.scene import Scene, View
from attitude.shape import Ellipsoid
from tests.support.kernels import DATA, kernel
from tests.support.scenes import envisat_over_graz

LIGHT = 299792458.0
AU = 149597870700.0
START = epochs.instant("2016-01-01T00:00:00 TDB")
BODY = Body(moments=(10, 20, 26))
MOTION = FreeRotation(BODY, Spin(epoch=START, wxyz=(1, 0, 0, 0), angular_velocity=(1, 15, 1)))
SOUTH = (0, 0, -1)
EAST = (0, 1, 0)


class Counted:
    """A motion that counts the attitudes it is asked for."""

    def __init__(self, motion=MOTION):
        self.motion, self.spin, self.body = motion, motion.spin, motion.body
        self.count = 0

    def at(self, t, low=None):
        self.count += np.size(t)
        return self.motion.at(t, low=low)


class CountedPath(Path):
    """A path that counts the positions it is asked for."""

    def __init__(self, path):
        self.path = path
        self.count = 0
        self.name = path.name
        self.center = path.center
        self.source = path.source
        self.span = path.span

    def _state(self, instant, hi, lo):
        self.count += hi.size
        return self.path._state(instant, hi, lo)


def angle(a, b):
    return np.max(
        np.arctan2(np.linalg.norm(np.cross(a, b), axis=-1), np.sum(np.asarray(a) * b, axis=-1))
    )


def unit(vectors):
    return vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)


def skyfield_at(seconds, start=START):
    jd1, jd2 = julian(start, seconds, np.zeros(1))
    found = timescale().tt_jd(jd1, jd2 - _time_scales.tdb_minus_tt(jd1, jd2) / 86400.0)
    found.tdb_fraction = (jd1 - found.whole) + jd2
    return found


@pytest.fixture(scope="module")
def planets():
    from skyfield.jpllib import SpiceKernel

    found = SpiceKernel(str(kernel("de421")))
    yield found
    found.close()


# Geometry against others --------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["mars", "moon", "jupiter barycenter"])
@pytest.mark.parametrize("count", [101, 40_001], ids=["direct", "compressed"])
def test_directions_and_light_times_are_those_of_skyfield_and_scipy(planets, name, count):
    from scipy.spatial.transform import Rotation

    seconds = np.linspace(0.0, 3e7, count)
    view = Scene(MOTION, name, ephemeris=kernel("de421")).at(seconds)
    assert (view.observer_line.error is not None) == (count == 40_001)
    some = slice(None, None, count // 100)
    seen = planets["earth"].at(skyfield_at(seconds[some])).observe(planets[name])
    light = seen.light_time * 86400.0
    # 5e-12 s: skyfield's positions are in au in doubles, its light times in days.
    assert np.max(np.abs(view.light_time[some] - light)) < 5e-12
    sun = planets[name].at(skyfield_at(seconds[some] - light)).observe(planets["sun"])
    turn = Rotation.from_quat(
        np.array(MOTION.at(seconds[some], low=-light).wxyz), scalar_first=True
    ).inv()
    observer, sun = (turn.apply(unit(v)) for v in (-seen.position.m.T, sun.position.m.T))
    # 1e-10: 5e-12 s of the light time at 15 rad/s.
    assert angle(view.observer_direction[some], observer) < 1e-10
    assert angle(view.sun_direction[some], sun) < 1e-10
    phase = 2 * np.arctan2(
        np.linalg.norm(observer - sun, axis=1), np.linalg.norm(observer + sun, axis=1)
    )
    assert np.max(np.abs(view.phase_angle[some] - phase)) < 1e-11
    elongation = planets["earth"].at(skyfield_at(seconds[some])).observe(planets["sun"])
    elongation = elongation.separation_from(seen).radians
    assert np.max(np.abs(view.solar_elongation[some] - elongation)) < 1e-11


@pytest.mark.parametrize("name", ["mars", "moon"])
def test_light_time_is_that_of_spice(name):
    spice = pytest.importorskip("spiceypy", reason="spiceypy, the witness, is not installed")
    file = str(kernel("de421"))
    seconds = np.linspace(0.0, 3e7, 101)
    et = START.seconds + seconds
    view = Scene(MOTION, name, ephemeris=file).at(seconds)
    spice.furnsh(file)
    try:
        seen, light = spice.spkpos(name.upper(), et, "J2000", "CN", "EARTH")
        sun, sun_light = spice.spkpos("SUN", et - light, "J2000", "CN", name.upper())
    finally:
        spice.unload(file)
    # SPICE's epochs are one double: 6e-8 s at 5e8 s, in which the Moon moves 2e-13 rad.
    assert angle(view.observer_direction_icrf, unit(-seen)) < 1e-11
    assert angle(view.sun_direction_icrf, unit(sun)) < 1e-11
    assert np.max(np.abs(view.light_time - light)) < 1e-11
    assert np.max(np.abs(view.sun_distance / LIGHT - sun_light)) < 1e-11


def test_aberration_is_that_of_skyfield(planets):
    seconds = np.linspace(0.0, 3e7, 101)
    view = Scene(None, "mars", ephemeris=kernel("de421"), aberration=True).since(START, seconds)
    seen = planets["earth"].at(skyfield_at(seconds)).observe(planets["mars"])
    theirs = seen.position.au.copy()
    # Without the deflection of light, which `apparent` adds: leaving it out takes skyfield 1.54.
    add_aberration(theirs, seen.center_barycentric.velocity.au_per_d, seen.light_time)
    theirs = unit(theirs.T)
    assert angle(view.apparent_direction, theirs) < 1e-12
    plain = Scene(None, "mars", ephemeris=kernel("de421")).since(START, seconds)
    assert 1e-5 < angle(plain.apparent_direction, theirs) < 1.2e-4  # 20 arcsec
    assert np.array_equal(plain.observer_direction_icrf, view.observer_direction_icrf)


def test_without_light_time_everything_is_at_the_epoch_itself():
    seconds = np.linspace(0.0, 3e7, 11)
    file = kernel("de421")
    view = Scene(MOTION, "mars", ephemeris=file, light_time=False).at(seconds)
    away = paths.relative("mars", "earth", file).position(START, seconds)
    assert angle(view.observer_direction_icrf, -unit(away)) < 1e-15
    assert np.all(view.light_time == 0.0)
    assert np.array_equal(view.attitude.wxyz, MOTION.at(seconds).wxyz)


@pytest.mark.parametrize("count", [31, 30_001], ids=["direct", "compressed"])
def test_a_satellite_near_by_is_seen_where_its_light_left(count):
    """The near branch against the plain difference of barycentric positions."""
    scene, _, start = envisat_over_graz()
    seconds = np.linspace(0.0, 900.0, count)
    view = scene.since(start, seconds)
    assert (view.observer_line.error is not None) == (count > 1000)
    some = slice(None, None, count // 30)
    target, viewer = (
        paths.relative(each, "ssb", scene.ephemeris) for each in (scene.center, scene.observer)
    )
    own = viewer.position(start, seconds[some])
    light = np.zeros(seconds[some].shape)
    for _ in range(6):
        away = target.position(start, seconds[some], -light) - own
        light = np.linalg.norm(away, axis=-1) / LIGHT
    # 3e-5 m of rounding at 1 au is 4e-11 rad at 770 km; a compression turns by 4e-10 at most.
    assert angle(view.observer_direction_icrf[some], -unit(away)) < 4.5e-10
    assert np.max(np.abs(view.light_time[some] - light)) < 1e-12
    geometric, *_ = envisat_over_graz(light_time=False)
    turned = angle(geometric.since(start, seconds).apparent_direction, view.apparent_direction)
    assert 5e-5 < turned < 1.5e-4  # the Earth moves 30 km/s: 1e-4 rad


def test_elevation_is_that_of_skyfield():
    from skyfield.api import EarthSatellite, wgs84

    scene, _, start = envisat_over_graz(light_time=False)
    seconds = np.linspace(0.0, 900.0, 31)
    lines = (DATA / "envisat-2013.tle").read_text().splitlines()
    theirs = EarthSatellite(*lines[1:], ts=timescale()) - wgs84.latlon(47.0671, 15.4933, 539.0)
    altitude = theirs.at(skyfield_at(seconds, start)).altaz()[0].radians
    # 3e-5 rad: skyfield leaves out the polar motion, 10 m on the ground.
    assert np.max(np.abs(scene.since(start, seconds).elevation - altitude)) < 3e-5
    assert np.degrees(altitude).max() > 80.0


def test_a_path_may_end_at_the_epoch_of_its_last_light():
    """Received a light time after the end of a table is within it; a little later is not."""
    table = paths.table(
        [0.0, 100.0], [[AU, 0, 0], [AU, 1e6, 0]], start=START, degree=1, name="probe"
    )
    scene = Scene(None, table, observer=paths.fixed((0, 0, 0)), sun=EAST)
    light = AU / LIGHT
    assert scene.since(START, np.array([99.0 + light])).light_time[0] == pytest.approx(light)
    with pytest.raises(AttitudeError, match=r"probe is known from 2016-01-01T00:00:00.000 TDB"):
        scene.since(START, np.array([101.0 + light])).light_time  # noqa: B018


def test_light_time_of_uniform_motion_in_closed_form():
    """|r + v (t - T)| = c T is a quadratic equation for T."""
    v = np.array([3e5, -2e5, 1e5])
    r = np.array([4e9, 1e9, -2e9])
    path = paths.uniform(r, v, START, name="probe")
    scene = Scene(None, path, observer=paths.fixed((0, 0, 0)), sun=EAST)
    seconds = np.linspace(-1e5, 1e5, 51)
    place = r + v * seconds[:, None]
    a, b, c = v @ v - LIGHT**2, -2 * place @ v, np.sum(place**2, axis=1)
    light = (-b - np.sqrt(b * b - 4 * a * c)) / (2 * a)
    found = scene.since(START, seconds).light_time
    # 2e-15 of 1e2 s
    assert np.max(np.abs(found - light)) < 1e-12


# What is not needed is not computed ---------------------------------------------------------------


def test_phase_and_distances_touch_no_attitude():
    motion = Counted()
    view = Scene(motion, "mars", ephemeris=kernel("de421")).at(np.linspace(0.0, 3e7, 5000))
    for name in ("phase_angle", "sun_distance", "observer_distance", "solar_elongation"):
        getattr(view, name)
    assert motion.count == 0
    assert "attitude" not in view.evaluated
    view.sun_direction, view.observer_direction, view.aspect_angle  # noqa: B018
    assert motion.count == 5000
    assert view.evaluated.count("attitude") == 1


def test_distance_to_the_observer_asks_nothing_of_the_sun():
    view = Scene(None, "mars", ephemeris=kernel("de421")).since(START, np.zeros(3))
    view.observer_distance  # noqa: B018
    assert view.evaluated == ("observer_line", "observer_distance")


def test_fixed_sun_and_observer_open_no_ephemeris(monkeypatch):
    def refused(*_):
        raise AssertionError("an ephemeris was opened")

    monkeypatch.setattr("attitude.paths._solar_system.ephemeris", refused)
    motion = Counted()
    view = Scene(motion, None, observer=SOUTH, sun=EAST).at(np.linspace(0.0, 60.0, 5))
    assert np.allclose(view.phase_angle, np.pi / 2, rtol=0, atol=1e-15)
    assert motion.count == 0
    assert np.array_equal(view.observer_distance, np.full(5, np.inf))
    want = MOTION.at(view.seconds).inertial_to_body(EAST)
    assert np.max(np.abs(view.sun_direction - want)) < 4e-16
    assert motion.count == 5


def test_every_quantity_is_made_once_and_is_read_only():
    view = Scene(MOTION, None, observer=SOUTH, sun=EAST).at([0.0, 1.0])
    assert view.sun_direction is view.sun_direction
    with pytest.raises(ValueError, match="read-only"):
        view.sun_direction[0] = 0.0
    with pytest.raises(AttributeError, match="does not change"):
        view.scene = None


def test_light_time_stops_when_it_has_converged():
    """A body at rest takes one pass after the first guess, a planet two: the secant."""
    still = CountedPath(paths.fixed((AU, 0, 0)))
    seen = {"observer": paths.fixed((0, 0, 0)), "sun": EAST}
    Scene(None, still, **seen).since(START, np.zeros(50)).light_time  # noqa: B018
    moving = CountedPath(paths.body("mars", kernel("de421")))
    Scene(None, moving, **seen).since(START, np.linspace(0, 3e7, 50)).light_time  # noqa: B018
    sampled = 52  # of which one asks first whether the target is near
    assert still.count - sampled == 100
    assert moving.count - sampled == 150


def test_many_epochs_ask_the_paths_for_few_positions():
    moving = CountedPath(paths.body("mars", kernel("de421")))
    view = Scene(None, moving, ephemeris=kernel("de421")).since(START, np.linspace(0, 3e7, 100_000))
    view.light_time  # noqa: B018
    assert moving.count < 30_000
    assert view.observer_line.error < 1e-3
    moving.count = 0
    scene = Scene(None, moving, ephemeris=kernel("de421"), tolerance=None)
    view = scene.since(START, np.linspace(0, 3e7, 100_000))
    view.light_time  # noqa: B018
    assert moving.count > 300_000
    assert view.observer_line.error is None


@pytest.mark.parametrize("low", [1e-10, -1e-10])
def test_many_epochs_with_a_second_double(low):
    """Their first and last are rounded to an Instant, by which others lie outside of the span."""
    orbit = paths.kepler(
        epoch="2026-01-01", semi_major_axis=8e6, eccentricity=0.01, inclination=1.0, node=0.3,
        pericenter_argument=2.0, mean_anomaly=1.0, center="earth",
    )  # fmt: skip
    random = np.random.default_rng(1)
    for t in (np.linspace(0.0, 1000.0, 3000), 1e6 + random.uniform(0.0, 1e-9, 3000)):
        both = low * random.uniform(0.5, 1.0, t.size)
        for second in (np.full(t.size, low), both):
            views = [Scene(MOTION, orbit, tolerance=limit).at(t, second) for limit in (1e-3, None)]
            one, other = (view.observer_distance for view in views)
            np.testing.assert_allclose(one, other, rtol=0, atol=2e-3)


def test_a_relaxed_rotator_runs_the_kernel_of_one_phase():
    spin = Spin(epoch=START, wxyz=(1, 0, 0, 0), angular_velocity=(0, 0, 1e-3))
    scene = Scene(FreeRotation(BODY, spin), None, observer=(1, 0, 0), sun=EAST)
    view = scene.at([0.0, np.pi / 2e-3])
    assert scene.motion.mode.name == "PRINCIPAL_AXIS"
    assert np.allclose(view.sub_observer, [[0, 0], [1.5 * np.pi, 0]], rtol=0, atol=1e-14)


# What the quantities mean -------------------------------------------------------------------------


def test_angles_to_momentum_and_axes():
    motion = FreeRotation(BODY, Spin(epoch=START, wxyz=(1, 0, 0, 0), angular_velocity=(0, 0, 1)))
    view = Scene(motion, None, observer=(1, 0, 1), sun=(0, -1, 0)).at(0.0)
    assert view.aspect_angle == pytest.approx(np.pi / 4, abs=1e-15)
    assert view.sun_aspect_angle == pytest.approx(np.pi / 2, abs=1e-15)
    assert np.allclose(view.observer_axis_angles, [np.pi / 4, np.pi / 2, np.pi / 4], atol=1e-15)
    assert np.allclose(view.sun_axis_angles, [np.pi / 2, np.pi, np.pi / 2], atol=1e-15)
    assert np.allclose(view.sub_observer, [0, np.pi / 4], atol=1e-15)
    assert np.allclose(view.sub_solar, [1.5 * np.pi, 0], atol=1e-15)


def test_momentum_of_a_motion_that_does_not_tell_it():
    view = Scene(Counted(), None, observer=(1, 0, 0), sun=EAST).at([0.0, 5.0])
    want = Scene(MOTION, None, observer=(1, 0, 0), sun=EAST).at([0.0, 5.0])
    assert np.allclose(view.aspect_angle, want.aspect_angle, rtol=0, atol=1e-14)


def test_phase_angle_bisector():
    """-(s + o) of an object at ecliptic longitude 40 deg, seen from its Sun's side: 40 deg."""
    toward = -np.array([np.cos(np.radians(40)), np.sin(np.radians(40)), 0.0])
    s, o = (
        paths.direction(toward + shift * np.array([0, 0, 1.0]), frame="ecliptic")
        for shift in (0.1, -0.1)
    )
    view = Scene(None, None, observer=o, sun=s).at(["2026-01-01"])
    assert np.allclose(view.phase_angle_bisector, [[np.radians(40), 0.0]], rtol=0, atol=1e-15)
    assert np.allclose(view.phase_angle, 2 * np.arctan(0.1), rtol=0, atol=1e-15)


@pytest.mark.parametrize(
    ("direction", "degrees"),
    [((0, 0, 1), 0), ((0, 1, 0), 90), ((0, -1, 1), 315), ((1, -1, 0), 270)],
)
def test_position_angle_goes_from_north_through_east(direction, degrees):
    """Body seen at right ascension and declination 0: north is +z, east is +y."""
    long_axis = unit(np.array(direction, dtype=float))
    other = np.cross(long_axis, (1, 0, 0))
    other /= np.linalg.norm(other)
    columns = np.column_stack([long_axis, other, np.cross(long_axis, other)])
    spin = Spin.from_matrix(epoch=START, matrix=columns, angular_velocity=(0, 0, 0))
    motion = FreeRotation(Body(moments=(1, 2, 3)), spin)
    view = Scene(motion, None, observer=(-1, 0, 0), sun=EAST).at(0.0)
    found = np.degrees(view.long_axis_position_angle)
    assert abs((found - degrees + 180) % 360 - 180) < 1e-12


def test_apparent_position():
    view = Scene(None, None, observer=(0, 1, -1), sun=EAST).at(["2026-01-01"])
    assert np.allclose(np.degrees(view.apparent_position), [[270, 45]], rtol=0, atol=1e-13)


def disc_share(apart, disc, limb, count=1000):
    """The share of the Sun's disc within an angle of a direction, by counting directions."""
    x, y = (np.mgrid[0:count, 0:count] + 0.5) / count * 2.0 - 1.0
    inside = x * x + y * y < 1.0
    radius, turn = disc * np.hypot(x, y)[inside], np.arctan2(y, x)[inside]
    cosine = np.cos(apart) * np.cos(radius) + np.sin(apart) * np.sin(radius) * np.cos(turn)
    return np.mean(cosine > np.cos(limb))


@pytest.mark.parametrize("limb_degrees", [0.2, 1.1, 64.0])
def test_lit_fraction_is_the_uncovered_share_of_the_disc(limb_degrees):
    from attitude._support import constants
    from attitude.scene import _shadow

    radius, limb = 6.4e6, np.radians(limb_degrees)
    disc = np.arcsin(constants.SUN_RADIUS_M / AU)
    apart = np.array([abs(limb - disc) * 0.9, *(limb + disc * np.array([-0.6, 0.0, 0.7, 1.1]))])
    apart = np.abs(apart)
    where = radius / np.sin(limb) * np.stack([np.cos(apart), np.sin(apart), 0 * apart])
    sun = np.array([[1.0], [0.0], [0.0]])
    found = _shadow.lit_fraction(where, radius, sun, np.full(5, AU))
    want = [1.0 - disc_share(each, disc, limb) for each in apart]
    # 1e-4: the counting.
    assert np.max(np.abs(found - want)) < 2e-4
    assert found[-1] == 1.0


def test_shadow_of_the_earth_on_a_satellite():
    scene, _, start = envisat_over_graz()
    seconds = np.arange(0.0, 6000.0, 5.0)
    view = scene.since(start, seconds)
    assert dict(scene.shadow_of) == {"earth": 6378137.0}
    dark = np.count_nonzero(view.in_umbra) * 5.0
    assert 1900 < dark < 2020  # a third of the orbit of 100 minutes
    # the cylinder of a parallel light agrees but for the penumbra and the flattening
    place = scene.center.position(start, seconds)
    sun = view.sun_direction_icrf
    behind = np.sum(place * sun, axis=1) < 0
    beside = np.linalg.norm(np.cross(place, sun), axis=1) < 6378137.0
    assert np.count_nonzero((behind & beside) != view.in_umbra) <= 8
    assert np.array_equal(view.in_penumbra, (view.lit_fraction > 0) & (view.lit_fraction < 1))
    free, *_ = envisat_over_graz(ephemeris="builtin", shadow_of=())
    assert np.all(free.since(start, seconds).lit_fraction == 1.0)


def test_magnitude_of_a_sphere():
    """A sphere shows no rotation; its magnitude follows the distances and the closed form."""
    sphere = Ellipsoid((500.0, 500.0, 500.0))
    scene = Scene(MOTION, "mars", ephemeris=kernel("de421"), shape=sphere)
    view = scene.at(np.linspace(0, 3e7, 50))
    alpha = view.phase_angle
    phase = 1.0 - np.sin(alpha / 2) * np.tan(alpha / 2) * np.log(1.0 / np.tan(alpha / 4))
    brightness = 500.0**2 / 8.0 * phase
    assert np.allclose(view.brightness, brightness, rtol=1e-9)
    far = view.sun_distance * view.observer_distance
    want = -26.76 - 2.5 * np.log10(brightness * AU**2 / far**2)
    assert np.allclose(view.magnitude, want, rtol=0, atol=1e-8)
    with pytest.raises(AttitudeError, match="brightness needs a shape"):
        Scene(MOTION, None, observer=SOUTH, sun=EAST).at([0.0]).brightness  # noqa: B018
    with pytest.raises(AttitudeError, match="the sun is a direction"):
        Scene(MOTION, None, observer=SOUTH, sun=EAST, shape=sphere).at([0.0]).magnitude  # noqa: B018


# Kinds of times, shapes ---------------------------------------------------------------------------


def test_scalar_and_shaped_epochs_and_nan():
    scene = Scene(MOTION, "mars", ephemeris=kernel("de421"), shape=Ellipsoid((3.0, 2.0, 1.0)))
    row = scene.at(np.array([0.0, 1e5, 2e5, 3e5]))
    square = scene.at(np.array([[0.0, 1e5], [2e5, 3e5]]))
    single = scene.at(1e5)
    for name in ("phase_angle", "magnitude", "sub_solar", "sun_direction", "lit_fraction"):
        flat, shaped, one = (getattr(each, name) for each in (row, square, single))
        assert np.array_equal(shaped.reshape(flat.shape), flat)
        assert np.allclose(one, flat[1], rtol=0, atol=1e-13)
    assert isinstance(single.phase_angle, float) and single.sun_direction.shape == (3,)
    holes = scene.at([0.0, np.nan, 2e5])
    for name in ("phase_angle", "magnitude", "sub_solar"):
        value = getattr(holes, name)
        assert np.all(np.isnan(value[1])) and np.array_equal(value[0], getattr(row, name)[0])
    assert scene.at(np.zeros(0)).phase_angle.shape == (0,)


def test_all_kinds_of_epochs_are_the_same():
    from astropy.time import Time

    scene = Scene(MOTION, "mars", ephemeris=kernel("de421"))
    iso = ["2016-03-01T00:00:00", "2016-04-01T00:00:00"]
    for times in (iso, Time(iso, scale="utc"), np.array(iso, dtype="datetime64[ns]")):
        assert np.allclose(scene.at(times).phase_angle, scene.at(iso).phase_angle, atol=1e-15)
    bare = Scene(None, "mars", ephemeris=kernel("de421"))
    assert np.allclose(bare.at(Time(iso)).phase_angle, scene.at(iso).phase_angle, atol=1e-14)


def test_motions_of_other_kinds_drive_a_scene():
    """Arcs without a change, and a table of its attitudes: the same as the free rotation."""
    from attitude.motions._table import AttitudeTable
    from attitude.torques._arcs import Arcs

    times = np.linspace(1.0, 2.0, 7)
    fixed = {"center": None, "observer": SOUTH, "sun": EAST}
    want = Scene(MOTION, **fixed).at(times)
    arcs = Scene(Arcs(MOTION.body, MOTION.spin, []), **fixed).at(times)
    assert np.allclose(arcs.sun_direction, want.sun_direction, rtol=0, atol=1e-14)
    assert np.allclose(arcs.aspect_angle, want.aspect_angle, rtol=0, atol=1e-14)
    knots = np.linspace(0.0, 3.0, 601)
    history = MOTION.at(knots)
    rates = history.angular_velocity
    table = AttitudeTable(START, knots, history.wxyz, angular_velocity=rates)
    view = Scene(table, **fixed).at(times)
    # 1e-9: the interpolation of degree 7 at 0.075 rad a step
    assert np.allclose(view.sun_direction, want.sun_direction, rtol=0, atol=1e-9)
    with pytest.raises(AttitudeError, match="angular momentum follows from a body's inertia"):
        view.aspect_angle  # noqa: B018


def test_what_was_given_stays_writable():
    seconds = np.array([0.0, 1.0])
    scene = Scene(MOTION, None, observer=SOUTH, sun=EAST)
    scene.at(seconds), scene.since(START, seconds)
    seconds[0] = 5.0


def test_pickle_and_table():
    view = Scene(MOTION, "mars", ephemeris=kernel("de421")).at([0.0, 1e5])
    view.phase_angle  # noqa: B018
    again = pickle.loads(pickle.dumps(view))
    assert again.evaluated == view.evaluated and not again.phase_angle.flags.writeable
    assert np.array_equal(again.sun_direction, view.sun_direction)
    table = view.table("phase_angle", "sun_direction", "observer_distance")
    assert table["phase_angle"].unit == "rad" and table["sun_direction"].shape == (2, 3)
    assert "de421" in table.meta["observer_line"]
    for name in ("phase", ["phase_angle", "sun_direction"]):
        with pytest.raises(AttitudeError, match="not a quantity"):
            view.table(name)


def test_every_quantity_describes_itself():
    """`help(View.phase_angle)` shows the physics, the shape and the unit."""
    for name, each in View.columns().items():
        assert getattr(View, name) is each and each.__doc__.startswith(each.about[:40])
        assert each.__doc__.endswith(f"{each.unit or 'pure number'}.")
        assert all(part in each.__doc__ for part in each.parts)
    assert "ICRF" in View.observer_velocity.__doc__ and not View.observer_velocity.is_column


# Sentences ----------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"motion": 3, "center": "mars"}, "motion is int"),
        ({"motion": np.poly1d([1]), "center": "mars"}, "motion is poly1d"),
        ({"motion": None}, "center is None, but observer is 'earth'"),
        ({"motion": None, "observer": SOUTH}, "center is None, but sun is 'sun'"),
        ({"motion": None, "center": "vulcan"}, "center is 'vulcan'"),
        ({"motion": None, "center": paths.direction(SOUTH)}, "infinitely far away; give a path"),
        ({"motion": None, "center": "mars", "observer": 1.5}, "observer is 1.5; give a path"),
        ({"motion": None, "center": "mars", "observer": ["earth", "moon"]}, "holds 2 places"),
        ({"motion": None, "center": "mars", "shape": "ball"}, "shape is str"),
        ({"motion": None, "center": "mars", "light_time": "CN"}, "light_time is 'CN'"),
        ({"motion": None, "center": "mars", "tolerance": 0}, "tolerance is 0"),
        ({"motion": None, "center": "mars", "night": -6}, "night is -6.0 rad; it goes from -pi/2"),
        ({"motion": None, "center": "mars", "shadow_of": 3.5}, "shadow_of is 3.5; give names"),
        ({"motion": None, "center": "mars", "shadow_of": [["mars"]]}, "shadow_of is .'mars'."),
        ({"motion": None, "center": "mars", "shadow_of": "sun"}, "radius is not known"),
        ({"motion": None, "observer": SOUTH, "sun": EAST, "shadow_of": "earth"}, "no shadow"),
        ({"motion": None, "center": "mars", "ephemeris": "none.bsp"}, "is not a file"),
    ],
)
def test_what_is_refused(arguments, message):
    with pytest.raises(AttitudeError, match=message):
        Scene(**arguments)


@pytest.mark.parametrize(
    ("scene", "times", "name", "message"),
    [
        ((None, "mars"), ["2016-01-01"], "sun_direction", "motion=None; give a motion"),
        ((None, "mars"), ["2016-01-01"], "aspect_angle", "motion=None"),
        ((None, "mars"), ["2016-01-01"], "elevation", "observer is earth, which has no horizon"),
        ((None, "mars"), ["1500-01-01"], "phase_angle", "known from"),
        ((None, "mars barycenter"), [5.0], "phase_angle", "without a motion has no epoch"),
        ((None, "mars barycenter"), "3 d", "phase_angle", "times is '3 d', but a scene without"),
        ((None, "earth"), ["2016-01-01"], "phase_angle", "in one place"),
        ((MOTION, "mars", SOUTH), [0.0], "solar_elongation", "observer is a direction"),
        ((MOTION, "mars"), [np.inf], "phase_angle", "infinite epoch"),
        ((MOTION, "ceres"), [0.0], "phase_angle", "is not the name of a body"),
        ((MOTION, 2000001), [0.0], "phase_angle", "has no 2000001"),
    ],
)
def test_what_a_view_refuses(scene, times, name, message):
    with pytest.raises(AttitudeError, match=message):
        getattr(Scene(*scene, ephemeris=kernel("de421")).at(times), name)


def test_an_observer_inside_the_shape():
    near = paths.fixed((0.0, 2.5, 0.0), center="mars")
    scene = Scene(MOTION, "mars", near, ephemeris=kernel("de421"), shape=Ellipsoid((3.0, 2.0, 1.0)))
    with pytest.raises(AttitudeError, match=r"comes to 2.49983 m from the center, into the shape"):
        scene.at([0.0]).observer_direction  # noqa: B018


def test_a_body_without_a_long_axis_and_one_at_rest():
    oblate = Body(moments=(1, 1, 2))
    spin = Spin(epoch=START, wxyz=(1, 0, 0, 0), angular_velocity=(0, 0, 0))
    view = Scene(FreeRotation(oblate, spin), None, observer=SOUTH, sun=EAST).at([0.0])
    with pytest.raises(AttitudeError, match="no long axis"):
        view.long_axis_position_angle  # noqa: B018
    with pytest.raises(AttitudeError, match="at rest"):
        view.aspect_angle  # noqa: B018


def test_magnitudes_follow_a_phase_function():
    """As `phased_magnitude` has them, reduced and apparent; NaN epochs stay NaN."""
    spin = Spin(epoch="2026-01-01", wxyz=(1, 0, 0, 0), angular_velocity=(0.1, 0.0, 1.0))
    motion = FreeRotation(Body(moments=(1, 2, 3)), spin)
    shape, center = Ellipsoid((3, 2, 1)), paths.uniform((2e11, 1e11, 0), (0, 0, 0), "2026-01-01")

    def function(alpha):
        return scattering.hg(alpha, 19.09, 0.24)

    view = Scene(motion, center, shape=shape, phase_function=function).at([0.0, 1.0, np.nan])
    expected = light_curve.phased_magnitude(
        view.brightness[:2], shape, "lommel-seeliger", view.phase_angle[:2], function
    )
    assert view.reduced_magnitude[:2] == pytest.approx(expected, abs=1e-12)
    modulus = 5 * np.log10(view.sun_distance * view.observer_distance / AU**2)
    assert view.magnitude[:2] == pytest.approx(expected + modulus[:2], abs=1e-12)
    assert np.isnan(view.magnitude[2])
    with pytest.raises(AttitudeError, match="function of the phase angle"):
        Scene(motion, center, shape=shape, phase_function=19.09)
    with pytest.raises(AttitudeError, match="leave out sun_magnitude"):
        Scene(motion, center, shape=shape, phase_function=function, sun_magnitude=-26.7)


def test_a_notebook_names_a_law_without_a_registered_name():
    metal = scattering.Material(diffuse=0.1)
    named = scattering.Materials({"panel": metal})
    for law, words in ((metal, "material"), (named, "Materials"), (None, "lommel-seeliger")):
        options = {} if law is None else {"law": law}
        shown = Scene(None, None, (1, 0, 0), (0, 1, 0), **options)._repr_html_()
        assert f">{words}</td>" in shown
