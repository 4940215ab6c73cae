"""What users give and take: observers of astropy and skyfield, wrong calls, equality, tables."""

import copy
import pickle
import warnings

import numpy as np
import pytest

from attitude import (
    Arcs,
    AttitudeError,
    AttitudeTable,
    Body,
    FreeRotation,
    Impulse,
    Scene,
    Spin,
    TorquedRotation,
    epochs,
    events,
    paths,  # fmt: skip
)
from attitude.errors import AttitudeWarning
from attitude.scattering import Material, Materials
from attitude.shape import box
from attitude.torques import ConstantTorque


def spin(**options):
    given = {"epoch": "2026-01-01", "wxyz": (1, 2, 0, 0), "angular_velocity": (0, 0.1, 1)}
    return Spin(**{**given, **options})


def motion():
    return FreeRotation(Body(moments=(1, 2, 2.5)), spin())


def position(place):
    return place.position(epochs.instant("2026-03-01"), np.array([0.0, 5000.0]))


# Observers ----------------------------------------------------------------------------------------


def scene_of(observer):
    return Scene(motion(), "mars", observer, ephemeris="builtin")


def test_an_earth_location_is_a_site():
    from astropy.coordinates import EarthLocation

    given = EarthLocation.from_geodetic(-70.7, -30.2, 2700.0)
    seen = scene_of(given)
    site = paths.site("-70.7 deg", "-30.2 deg", 2700.0)
    np.testing.assert_allclose(position(seen.observer), position(site), rtol=0, atol=1e-6)
    zenith = seen.observer.zenith(epochs.instant("2026-03-01"), np.zeros(1))
    np.testing.assert_allclose(zenith, site.zenith(epochs.instant("2026-03-01"), np.zeros(1)))
    assert seen.observer.has_horizon
    with pytest.raises(AttitudeError, match="observer holds 2 locations; give one of them"):
        scene_of(EarthLocation.from_geodetic([1, 2], [3, 4]))
    with pytest.raises(AttitudeError, match="observer holds 2 places; give one, and a Scene for"):
        scene_of([given, given])


def test_a_sky_coord_is_a_direction_or_a_point():
    from astropy import units
    from astropy.coordinates import AltAz, SkyCoord

    star = SkyCoord(10 * units.deg, 20 * units.deg)
    seen = Scene(motion(), None, star, SkyCoord("1h", "2d", frame="fk5"))
    assert seen.observer.is_direction and seen.sun.is_direction
    np.testing.assert_allclose(seen.observer.unit, star.cartesian.xyz.value, atol=1e-15)
    near = SkyCoord(10 * units.deg, 20 * units.deg, distance=3 * units.au)
    point = scene_of(near).observer
    np.testing.assert_allclose(position(point)[0], near.cartesian.xyz.to_value("m"), rtol=1e-14)
    with pytest.raises(AttitudeError, match="whose direction in ICRS does not follow"):
        Scene(motion(), None, SkyCoord(0 * units.deg, 1 * units.deg, frame=AltAz()), (1, 0, 0))


def test_positions_and_vectors_of_skyfield():
    from skyfield.api import load, wgs84
    from skyfield_data import get_skyfield_data_path

    topos = wgs84.latlon(-30.2, -70.7, 2700.0)
    site = paths.site("-70.7 deg", "-30.2 deg", 2700.0)
    np.testing.assert_allclose(position(scene_of(topos).observer), position(site), atol=1e-6)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # other files of that package have expired
        planets = load(f"{get_skyfield_data_path()}/de421.bsp")
    summed = scene_of(planets["earth"] + topos).observer
    assert summed.has_horizon
    np.testing.assert_allclose(position(summed), position(site), atol=1e-6)
    venus = scene_of(planets["venus"]).observer
    own = paths.from_skyfield(planets["venus"])
    np.testing.assert_array_equal(position(venus), position(own))
    planets.close()


# Wrong calls --------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: Body(10, 20, 26), r"takes its moments together: Body\(moments=\(10, 20, 26\)\)"),
        (lambda: Body(10.5), r"takes its moments together: Body\(moments="),
        (lambda: Body(inertia=(1, 2, 3)), "Body has no argument inertia; give moments or tensor"),
        (lambda: Body(Ixx=1, Iyy=2), r"no argument Ixx; give moments, as in Body\(moments="),
        (lambda: Body((1, 2, 3), None, 1, True, (0, 0, 0), 7), "too many positional arguments"),
        (lambda: spin(xyzw=(0, 0, 0, 1)), r"no argument xyzw; give wxyz=\(w, x, y, z\), the scala"),
        (lambda: spin(omega=(0, 0, 1)), "no argument omega; give angular_velocity="),
        (lambda: spin(pole=(0, 0)), "no argument pole; use Spin.from_periods"),
        (lambda: spin(colour=1), "no argument colour; it takes epoch, wxyz, angular_velocity"),
    ],
)
def test_a_wrong_call_gets_the_right_one(call, message):
    with pytest.raises(AttitudeError, match=message):
        call()


def test_a_misspelt_law_fails_when_the_scene_is_made():
    with pytest.raises(AttitudeError, match="law is 'lambret'; give one of 'lambert'"):
        Scene(motion(), None, (1, 0, 0), (0, 1, 0), shape=box((1, 1, 1)), law="lambret")
    named = Materials({"body": Material(0.3)})
    with pytest.raises(AttitudeError, match="material 'surface' is unknown; known are 'body'"):
        Scene(motion(), None, (1, 0, 0), (0, 1, 0), shape=box((1, 1, 1)), law=named)


# Equality -----------------------------------------------------------------------------------------


def made():
    body, torque = Body(moments=(1, 2, 2.5)), ConstantTorque((0, 0, 1e-3))
    t = np.linspace(0, 10, 21)
    return [
        body,
        spin(),
        FreeRotation(body, spin()),
        Arcs(body, spin(), [Impulse(at=5.0, angular_momentum=(0, 0, 1))]),
        AttitudeTable("2026-01-01", t, FreeRotation(body, spin()).at(t).wxyz),
        TorquedRotation(body, spin(), [torque], step=0.1),
    ]


@pytest.mark.parametrize("number", range(5))
def test_equal_values_are_equal_and_have_one_hash(number):
    one, other = made()[number], made()[number]
    assert one == other and hash(one) == hash(other) and len({one, other}) == 1
    again = pickle.loads(pickle.dumps(one))
    assert again == one and copy.copy(one) == one
    for different in made()[:number] + made()[number + 1 :]:
        assert one != different


def test_different_values_are_different():
    assert spin() != spin(angular_velocity=(0, 0.1, 1.0000000000000002))
    assert spin() != spin(frame="ecliptic") and spin() != spin().with_covariance(np.eye(6))
    assert Body(moments=(1, 2, 3)) != Body(moments=(1, 2, 3), relative=True)
    assert Body(moments=(0.0, 1, 1)) == Body(moments=(-0.0, 1, 1))
    torqued = made()[-1]  # torques are compared as objects
    assert torqued == copy.copy(torqued) and torqued != made()[-1]


def test_conditions_of_equal_motions_combine():
    one, other = motion(), motion()
    both = events.in_cone(one, (1, 0, 0), (1, 0, 0), 1) & events.illuminated(
        other, (0, 0, 1), sun=(1, 0, 0)
    )
    assert both([0.0, 1.0]).shape == (2,)


# Julian dates -------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "t", [2459000.5, 2459000, [2459000.5, 2459001.5], np.array([2.41e6, 2.49e6])]
)
def test_a_julian_date_taken_for_seconds_warns(t):
    with pytest.warns(AttitudeWarning, match="taken for seconds since the epoch, but it"):
        motion().at(t)


@pytest.mark.parametrize("t", [2.3e6, [0.0, 2.45e6], np.linspace(0, 3e6, 7), np.nan])
def test_seconds_do_not_warn(t):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        motion().at(t)
        motion().at(2459000.5, low=0.0)


# Tables -------------------------------------------------------------------------------------------


def test_a_history_as_csv(tmp_path):
    history = motion().at([0.0, 1.0, 2.0])
    history.table().write(tmp_path / "x.csv")
    lines = (tmp_path / "x.csv").read_text().splitlines()
    assert lines[0] == "tdb_jd1,tdb_jd2,w,x,y,z,omega_x,omega_y,omega_z"
    numbers = np.array([line.split(",") for line in lines[1:]], dtype=float)
    np.testing.assert_array_equal(numbers[:, :2].T, [history.time.jd1, history.time.jd2])
    np.testing.assert_array_equal(numbers[:, 2:6], history.wxyz)
    np.testing.assert_array_equal(numbers[:, 6:], history.angular_velocity)
    view = Scene(motion(), None, (1, 0, 0), (0, 1, 0)).at([0.0, 1.0])
    view.table("sub_solar", "phase_angle").write(tmp_path / "y.csv")
    head = (tmp_path / "y.csv").read_text().splitlines()[0]
    assert head == "tdb_jd1,tdb_jd2,sub_solar_longitude,sub_solar_latitude,phase_angle"


def test_a_history_in_pandas():
    pandas = pytest.importorskip("pandas")
    history = motion().at([0.0, 1.0, 2.0])
    frame = history.to_pandas()
    assert frame.index[1] == pandas.Timestamp("2026-01-01T00:00:01", tz="UTC")
    assert list(frame) == ["tdb_seconds", *"wxyz", "omega_x", "omega_y", "omega_z"]
    np.testing.assert_array_equal(frame[list("wxyz")], history.wxyz)
    assert frame.attrs["units"]["omega_x"] == "rad / s"


def test_a_history_in_xarray():
    pytest.importorskip("xarray")
    history = motion().at([0.0, 1.0, 2.0])
    data = history.to_xarray()
    np.testing.assert_array_equal(data["wxyz"].sel(wxyz_part="x"), history.wxyz[:, 1])
    assert data["angular_velocity"].attrs["units"] == "rad / s"
    assert "angular_velocity" not in history.to_xarray(rates=False)


def test_missing_packages_are_named(monkeypatch):
    import sys

    monkeypatch.setitem(sys.modules, "pandas", None)
    monkeypatch.setitem(sys.modules, "xarray", None)
    history = motion().at([0.0, 1.0])
    with pytest.raises(AttitudeError, match="needs pandas, which is not installed; run pip"):
        history.to_pandas()
    with pytest.raises(AttitudeError, match="needs xarray, which is not installed; run pip"):
        history.to_xarray()
