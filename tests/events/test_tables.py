"""Windows, passes and glints: against samples, skyfield and mirrors; their tables and files."""

import numpy as np
import pytest
from astropy.table import QTable

from attitude import (
    AttitudeError,
    AttitudeTable,
    Body,
    FreeRotation,
    Scene,
    Spin,
    epochs,
    events,
    paths,
)
from attitude.paths._spk import Succession
from attitude.scattering import Lambert, Material, Materials
from attitude.shape import box, box_wing, flat_sides
from tests.support import earth_orientation
from tests.support.places import DATA

START = "2013-10-23T15:30:00"
STOP = "2013-10-23T23:30:00"
SHINY = Materials({"surface": Material(0.2, 0.5, exponent=400)})


def satellite():
    return paths.tle(str(DATA / "paths" / "envisat-2013.tle"))


@pytest.fixture(scope="module")
def scene():
    site = paths.site("20.3653 deg", "69.3482 deg", 157.0)
    return Scene(None, satellite(), site, aberration=True, ephemeris="builtin")


def mirror_scene(**options):
    """A box that turns once in 100 s about z; Sun and observer in its equator, 60 deg apart."""
    spin = Spin(epoch="2026-01-01", wxyz=(1, 0, 0, 0), angular_velocity=(0, 0, 2 * np.pi / 100))
    observer = (np.cos(np.pi / 3), np.sin(np.pi / 3), 0)
    options = {"shape": box((3, 2, 1)), "law": SHINY, **options}
    return Scene(FreeRotation(Body(moments=(1, 2, 3)), spin), None, observer, (1, 0, 0), **options)


@pytest.fixture(scope="module")
def night(scene):
    return events.passes(scene, START, STOP, elevation="10 deg", sunlit=True, night="-6 deg")


def test_passes_are_those_of_astropy_and_of_samples(scene, night):
    """Azimuth and elevation by astropy; the visible part by samples a second apart."""
    from astropy import units
    from astropy.coordinates import GCRS, ITRS, AltAz, CartesianRepresentation, EarthLocation

    assert len(night) == 5 and np.all(night.elevation > np.radians(10))
    place = EarthLocation.from_geodetic(20.3653, 69.3482, 157.0)
    time = night.time("culmination")
    # Geometric: the satellite in ITRS less the site, as astropy's documentation of satellites does.
    position = satellite().position(night.epoch, night.culmination)
    gcrs = GCRS(CartesianRepresentation(position.T * units.m), obstime=time)
    with earth_orientation.installed():
        itrs = gcrs.transform_to(ITRS(obstime=time))
        here = itrs.cartesian - place.get_itrs(time).cartesian
        seen = ITRS(here, obstime=time, location=place).transform_to(
            AltAz(obstime=time, location=place)
        )
    # Light time and aberration by the satellite's own motion: 7.5 km/s over c, 2.5e-5 rad.
    np.testing.assert_allclose(night.elevation, seen.alt.rad, rtol=0, atol=4e-5)
    np.testing.assert_allclose(night.azimuth, seen.az.rad, rtol=0, atol=4e-5 / np.cos(1.41))
    np.testing.assert_allclose(night.distance, seen.distance.m, rtol=2e-4)
    for row in range(len(night)):
        t = np.arange(night.rise[row], night.set[row], 1.0)
        view = scene.at(epochs.times(night.epoch, t))
        seen = (view.lit_fraction > 0) & (view.sun_elevation < np.radians(-6))
        assert night.visible[row] == pytest.approx(np.count_nonzero(seen), abs=2.0)
        assert night.visible_from[row] >= night.rise[row]
        assert night.elevation[row] == pytest.approx(np.max(view.elevation), abs=1e-4)


def test_a_pass_cut_by_the_search_has_no_rise(scene, night):
    middle = night.time("culmination")[1]
    cut = events.passes(scene, middle, STOP, elevation="10 deg")
    assert np.isnan(cut.rise[0]) and cut.set[0] == pytest.approx(night.set[1], abs=1e-3)
    assert cut.time("rise").mask.tolist() == [True, False, False, False]
    assert cut.duration[0] == pytest.approx(night.set[1] - night.culmination[1], abs=1e-3)


def test_windows_totals_and_the_worst_gap(scene, night):
    found = events.windows(scene.quantity("elevation") > "10 deg", START, STOP)
    np.testing.assert_allclose(found.begin, night.rise, atol=1e-3)
    assert found.total == pytest.approx(np.sum(night.duration), abs=1e-3)
    assert found.span == pytest.approx(8 * 3600.0) and found.share == found.total / found.span
    between = np.append(found.begin[1:], found.stop[0]) - found.end
    assert found.worst_gap == pytest.approx(np.max(between), abs=1e-3)
    assert len(found.gaps) == 6 and found.gaps.total + found.total == pytest.approx(found.span)
    never = events.windows(scene.quantity("elevation") > "89.99 deg", START, STOP)
    assert len(never) == 0 and never.worst_gap == never.span
    always = events.windows(scene.quantity("elevation") > "-90 deg", START, STOP)
    assert always.total == always.span and always.worst_gap == 0.0


def test_a_night_without_passes(scene):
    found = events.passes(scene, START, STOP, elevation="89.9 deg", sunlit=True)
    assert len(found) == 0 and len(found.table()) == 0


def test_a_span_follows_from_what_is_known():
    free = mirror_scene().motion
    t = np.linspace(0.0, 100.0, 401)
    table = AttitudeTable(free.epoch, t, free.at(t).wxyz)
    found = events.windows(events.illuminated(table, (1, 0, 0), sun=(0, 1, 0)))
    assert found.span == pytest.approx(100.0) and found.total == pytest.approx(50.0, abs=1e-3)
    with pytest.raises(AttitudeError, match="start is not given, and neither motion nor path has"):
        events.windows(events.illuminated(free, (1, 0, 0), sun=(0, 1, 0)))


@pytest.mark.parametrize("light_time", [True, False])
def test_the_span_of_a_path_is_known_as_it_is_seen(light_time):
    """The first light, and that of the shadow of the Earth before, left within the table."""
    start, t = epochs.instant(START), np.arange(0.0, 7201.0, 60.0)
    state = satellite().state(start, t)
    table = paths.table(t, *state, start=start, center="earth")
    site = paths.site("20.3653 deg", "69.3482 deg", 157.0)
    scene = Scene(None, table, site, ephemeris="builtin", light_time=light_time)
    lit = events.windows(scene.quantity("lit_fraction") > 0.5)
    # The satellite is nearer than 0.05 light seconds to both.
    assert 0.0 < lit.total < lit.span == pytest.approx(7200.0, abs=0.1)
    ends = start.after(0.1), start.after(7199.9)
    assert len(events.passes(scene)) == len(events.passes(scene, *ends)) == 1
    halves = [
        paths.table(t[rows], *(values[rows] for values in state), start=start, center="earth")
        for rows in (slice(0, 60), slice(70, None))
    ]
    scene = Scene(None, Succession(tuple(halves), "cut"), site, ephemeris="builtin")
    with pytest.raises(AttitudeError, match=r"cut is not known from .*on one side of that gap"):
        events.passes(scene)
    late = events.windows(scene.quantity("lit_fraction") > 0.5, start.after(4201.0))
    assert late.span == pytest.approx(2999.0, abs=0.1)


def test_the_greatest_of_a_long_window():
    """A lobe so wide that one glint lasts for hundreds of turns: the peak is that of samples."""
    spin = Spin(epoch="2026-01-01", wxyz=(1, 0, 0, 0), angular_velocity=(0.3, 0.25, 1.0))
    scene = Scene(
        FreeRotation(Body(moments=(10, 14, 17)), spin), None, (0.6, 0.35, 1), (0.1, -0.3, 1.0),
        shape=box((1, 2, 3)), law=Material(0.3, 0.3, exponent=2),
    )  # fmt: skip
    glint = events.glints(scene, 0.0, 600.0, sides=["surface +z"])
    assert len(glint) == 1 and glint.duration[0] == 600.0
    view = scene.at(np.arange(0.0, 600.0, 0.01))
    mirrored = view.observer_direction * (-1.0, -1.0, 1.0)
    off = np.arccos(np.sum(mirrored * view.sun_direction, axis=-1))
    # Between two samples the mirrored direction turns by 0.02 rad.
    assert glint.off_mirror[0] <= np.min(off) < glint.off_mirror[0] + 0.01
    assert glint.peak[0] == pytest.approx(0.01 * np.argmin(off), abs=0.02)


def test_glints_of_a_turning_box():
    """The mirror equation in closed form, for the sides that have a lobe."""
    scene = mirror_scene()
    found = events.glints(scene, 0, 100, fraction=0.5)
    # A side shines where its normal bisects Sun and observer: 30 deg, a quarter turn each.
    assert found.side.tolist() == ["surface +x", "surface -y", "surface -x", "surface +y"]
    np.testing.assert_allclose(found.peak, 100 / 12 + 25 * np.arange(4), atol=1e-4)
    width = np.arccos(0.5 ** (1 / 400)) + events.SUN_RADIUS
    np.testing.assert_allclose(found.duration, 100 * width / (2 * np.pi), rtol=1e-9)
    np.testing.assert_allclose(found.off_mirror, 0, atol=1e-5)
    view = scene.at(found.peak)
    np.testing.assert_allclose(found.magnitude, view.reduced_magnitude)
    brighter = scene.at(found.peak[:, None] + [-1.0, 0.0, 1.0]).brightness
    assert np.all(brighter[:, 1] > brighter[:, [0, 2]].max(axis=1))


def test_glints_combine_and_name_sides():
    scene = mirror_scene()
    lit = events.illuminated(scene, (0, 1, 0))
    found = events.glints(scene, 0, 1000, sides=["surface +y"], where=~lit)
    assert len(found) == 0
    assert len(events.glints(scene, 0, 1000, sides=["surface +y"], where=lit)) == 10
    sides = flat_sides(box_wing(body=(10, 4, 4), wing=(14, 5)))
    assert [each.name for each in sides if "panel" not in each.name] == [
        "body -y", "body +y", "body -z", "body +z", "body -x", "body +x",
    ]  # fmt: skip
    areas = {each.name: each.area for each in sides}
    assert areas["panel front"] == pytest.approx(140.0) and areas["body +x"] == pytest.approx(16)


@pytest.mark.parametrize("material", [
    Material(0.1, 0.5, exponent=50), Material(0.1, 0.5, model="cook-torrance", roughness=0.1),
    Material(0.1, 0.5, model="cook-torrance", roughness=0.4),
])  # fmt: skip
def test_the_width_of_a_lobe(material):
    """Where the lobe itself, about the normal, has fallen to a tenth."""
    width = material.lobe_half_width(0.1)
    # Sun along the normal tilted by half the width to either side: the micro-facet tilts by that.
    diffuse = material.diffuse / np.pi
    top = material.reflectance(1.0, 1.0, 0.0) - diffuse
    if material.model == "phong":
        mu = np.cos(width)
        assert material.reflectance(1.0, mu, width) - diffuse == pytest.approx(0.1 * top)
    else:
        mu = np.cos(0.5 * width)  # Sun and observer together, off the normal by half the width
        found = (material.reflectance(mu, mu, 0.0) - mu * diffuse) * mu
        assert found / min(1.0, 2 * mu * mu) == pytest.approx(0.1 * top, rel=1e-6)


def test_tables_and_files(night, tmp_path):
    table = night.table()
    assert table["elevation"].unit == "deg" and table["rise"].scale == "utc"
    assert table["elevation"].value == pytest.approx(np.degrees(night.elevation))
    table.write(tmp_path / "x.ecsv")
    again = QTable.read(tmp_path / "x.ecsv")
    assert again["distance"].unit == "km"
    np.testing.assert_allclose((again["rise"] - table["rise"]).sec, 0, atol=1e-3)
    table.write(tmp_path / "x.csv")
    head = (tmp_path / "x.csv").read_text().splitlines()
    assert head[0].startswith("rise_utc,rise_azimuth [deg],culmination_utc") and len(head) == 6
    assert "deg" in str(night) and repr(night[:2]).startswith("<2 Timetable")
    with pytest.raises(AttributeError, match="Passes has no 'altitude'; its columns are rise"):
        _ = night.altitude
    with pytest.raises(AttitudeError, match="'elevation' is no column of times; give one of rise"):
        night.time("elevation")


def test_events_as_a_table(scene):
    elevation = scene.quantity("elevation")
    tops = events.find_maxima(START, STOP, elevation).table()
    assert tops["value"].unit == "rad" and tops["time"].scale == "utc"
    both = [elevation > "10 deg", elevation > "30 deg"]
    changes = events.find_discrete(START, STOP, both).table()
    assert set(changes["which"]) == {0, 1} and changes["value"].dtype == bool


def test_pandas_frames(night):
    pandas = pytest.importorskip("pandas")
    frame = night.to_pandas()
    assert isinstance(frame["rise"].dtype, pandas.DatetimeTZDtype)
    assert frame.attrs["units"]["elevation [deg]"] == "deg"
    assert frame.attrs["units"]["duration"] == "s"
    assert frame["rise"][0].isoformat()[:19] == night.time("rise")[0].isot[:19]


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda s: events.passes(Scene(None, "mars"), START, STOP), "over which nothing rises"),
        (lambda s: events.passes(3, START, STOP), "scene is 3; give a Scene"),
        (lambda s: events.passes(s, elevation="10 deg"), "start is not given"),
        (lambda s: events.passes(s, START, STOP, night="6 m"), "night is in m"),
        (lambda s: events.passes(s, START, STOP, night="-6"), "night is -6.0 rad; it goes from"),
        (lambda s: events.passes(s, START, STOP, elevation=10), "give degrees as text"),
        (lambda s: events.passes(s, START, STOP, where=3), "where is 3; give a Condition"),
        (lambda s: events.windows(3), "condition is 3; give a Condition"),
        (lambda s: events.glints(s, START, STOP), "the scene has no motion"),
        (lambda s: events.glints(mirror_scene(shape=None), 0, 1), "give a Scene with shape="),
        (lambda s: events.glints(mirror_scene(law=Lambert()), 0, 1), "is Lambert, which has no lo"),
        (lambda s: events.glints(mirror_scene(law=Material(0.3)), 0, 1), "nothing glints"),
        (lambda s: events.glints(mirror_scene(), 0, 1, sides=["top"]), "the sides with a lobe are"),
        (lambda s: events.glints(mirror_scene(), 0, 1, fraction=2), "fraction is 2.0; give one"),
    ],
)
def test_what_is_refused(scene, make, message):
    with pytest.raises(AttitudeError, match=message):
        make(scene)
