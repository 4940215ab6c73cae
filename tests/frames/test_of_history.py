"""Attitudes and rates relative to an orbit and to the Earth; the same motion at another epoch."""

import numpy as np
import pytest

from attitude import AttitudeError, Body, FreeRotation, Scene, Spin, epochs, frames, paths
from attitude.frames import quaternion
from attitude.frames.quaternion import from_matrix
from attitude.frames.representations import to_rotation_vector
from tests.support import earth_orientation
from tests.support.places import DATA

EPOCH = "2013-10-23T12:00:00"


def orbit():
    return paths.tle(str(DATA / "paths" / "envisat-2013.tle"))


def motion(**options):
    given = {"wxyz": (0.3, 0.1, -0.7, 0.2), "angular_velocity": (0.001, -0.05, 0.02)}
    spin = Spin(epoch=EPOCH, **{**given, **options})
    return FreeRotation(Body(moments=(10, 20, 26)), spin)


def axes_at(t, kind):
    """The axes as columns (N, 3, 3), written out from position and velocity."""
    r, v = orbit().state(epochs.instant(EPOCH), t)
    unit = [x / np.linalg.norm(x, axis=-1, keepdims=True) for x in (r, np.cross(r, v))]
    along = np.cross(unit[1], unit[0])
    columns = (along, -unit[1], -unit[0]) if kind == "lvlh" else (unit[0], along, unit[1])
    return np.stack(columns, axis=-1)


@pytest.mark.parametrize("kind", ["lvlh", "rtn"])
def test_axes_of_an_orbit(kind):
    t = np.linspace(0, 6000, 601)
    history = motion().at(t)
    found = history.in_frame(kind, orbit=orbit())
    np.testing.assert_allclose(
        found.matrix, np.swapaxes(axes_at(t, kind), -1, -2) @ history.matrix, atol=1e-12
    )
    # Rates: how the attitude relative to the frame changes, over the body axes.
    h = 0.01
    pair = [motion().at(t + s).in_frame(kind, orbit=orbit()).wxyz for s in (-h, h)]
    turn = quaternion.multiply(quaternion.conjugate(pair[0]), pair[1])
    rate = to_rotation_vector(turn) / (2 * h)
    np.testing.assert_allclose(found.angular_velocity, rate, atol=5e-9)
    np.testing.assert_allclose(
        found.angular_velocity_in_frame,
        np.einsum("nij,nj->ni", found.matrix, found.angular_velocity), atol=1e-15,
    )  # fmt: skip
    assert np.all(np.sum(found.wxyz[1:] * found.wxyz[:-1], axis=-1) > 0)


def test_a_body_that_points_to_the_earth_does_not_turn_in_lvlh():
    """A body at rest in RTN of a circular orbit: its inertial rate is that of the orbit."""
    earth = paths.kepler(
        epoch=EPOCH, semi_major_axis=7e6, eccentricity=0.0, inclination=1.0,
        node=0.3, pericenter_argument=0.0, mean_anomaly=0.1, center="earth",
        frame="icrf",
    )  # fmt: skip
    r, v = earth.state(epochs.instant(EPOCH), 0.0)
    normal = np.cross(r, v)
    rtn = np.stack(
        [r / np.linalg.norm(r), np.cross(normal, r), normal / np.linalg.norm(normal)], axis=-1
    )
    rtn[:, 1] /= np.linalg.norm(rtn[:, 1])
    rate = np.linalg.norm(normal) / (r @ r)
    still = FreeRotation(
        Body(moments=(1, 2, 3)),
        Spin(EPOCH, wxyz=from_matrix(rtn), angular_velocity=(0, 0, rate)),
    )
    found = still.at(np.linspace(0, 3000, 7)).in_frame("rtn", orbit=earth)
    np.testing.assert_allclose(found.matrix, np.broadcast_to(np.eye(3), (7, 3, 3)), atol=1e-9)
    np.testing.assert_allclose(found.angular_velocity, 0, atol=1e-12)


def test_earth_fixed_axes_are_those_of_astropy_and_skyfield():
    from astropy import units
    from astropy.coordinates import GCRS, ITRS, CartesianRepresentation
    from skyfield.api import load
    from skyfield.framelib import itrs

    history = motion().at([0.0, 3000.0, 80000.0])
    found = history.in_frame("itrf")
    time = history.time
    for k in range(3):
        axis = history.body_to_inertial(np.eye(3)[k])
        gcrs = GCRS(CartesianRepresentation(axis.T * units.km), obstime=time)
        with earth_orientation.installed():
            theirs = gcrs.transform_to(ITRS(obstime=time)).cartesian.xyz.to_value("km").T
        # astropy moves to the geocentre and back: 1e-9 of a unit vector of a km.
        np.testing.assert_allclose(found.body_to_frame(np.eye(3)[k]), theirs, atol=1e-7)
    t = load.timescale(builtin=True).from_astropy(time)
    turned = np.moveaxis(itrs.rotation_at(t), -1, 0) @ history.matrix
    np.testing.assert_allclose(found.matrix, turned, atol=3e-6)  # skyfield: no polar motion
    spin = history.angular_velocity - found.angular_velocity
    north = history.inertial_to_body(np.array([0.0, 0.0, 1.0]))
    np.testing.assert_allclose(np.linalg.norm(spin, axis=-1), 7.292115e-5, rtol=1e-6)
    assert np.all(np.sum(spin * north, axis=-1) > 7.2921e-5)


@pytest.mark.parametrize("frame", ["ecliptic", "eme2000", "icrf"])
def test_inertial_axes(frame):
    history = motion().at([0.0, 100.0])
    found = history.in_frame(frame)
    expected = frames.matrix_to_icrf(frame).T @ history.matrix
    np.testing.assert_allclose(found.matrix, expected, atol=1e-15)
    np.testing.assert_array_equal(found.angular_velocity, history.angular_velocity)


def test_forms_tables_and_scalars(tmp_path):
    found = motion().at([0.0, 10.0]).in_frame("lvlh", orbit=orbit())
    np.testing.assert_allclose(found.as_rotation().as_matrix(), found.matrix, atol=1e-14)
    again = quaternion.from_euler("ZXZ", found.euler("ZXZ")[1])
    assert abs(again @ found.wxyz[1]) == pytest.approx(1.0)
    np.testing.assert_allclose(found.frame_to_body(found.body_to_frame([1, 2, 3])), [[1, 2, 3]] * 2)
    table = found.table()
    assert table.meta["frame"] == "LVLH"
    np.testing.assert_array_equal(table["wxyz"], found.wxyz)
    table.write(tmp_path / "x.csv")
    one = motion().at(10.0).in_frame("lvlh", orbit=orbit())
    np.testing.assert_allclose(np.abs(one.wxyz), np.abs(found.wxyz[1]))
    assert one.wxyz.shape == (4,) and one.angular_velocity.shape == (3,)


@pytest.mark.parametrize(
    ("frame", "options", "message"),
    [
        ("lvlh", {}, "lvlh are axes of an orbit; give orbit=, the path of the body"),
        ("rtn", {"orbit": 3}, "rtn are axes of an orbit, and orbit is 3; give orbit="),
        ("lvhl", {}, "frame is 'lvhl'; known axes are"),
        (7, {}, "frame is 7"),
        ("j2000", {}, "frame is 'j2000', which means two things"),
        ("rtn", {"orbit": paths.fixed((7e6, 0, 0), center="earth")}, "its orbit has no plane"),
    ],
)
def test_what_is_refused(frame, options, message):
    with pytest.raises(AttitudeError, match=message):
        motion().at([0.0]).in_frame(frame, **options)


@pytest.mark.parametrize("frame", ["rtn", "lvlh", "itrf", "teme", "tod"])
def test_an_epoch_that_is_nan_has_no_axes(frame):
    known = motion().at([0.0, 10.0]).in_frame(frame, orbit=orbit())
    partly = motion().at([0.0, np.nan, 10.0]).in_frame(frame, orbit=orbit())
    for name in ("wxyz", "angular_velocity"):
        values = getattr(partly, name)
        assert np.isnan(values[1]).all()
        np.testing.assert_array_equal(values[[0, 2]], getattr(known, name))
    assert np.isnan(motion().at(np.nan).in_frame(frame, orbit=orbit()).wxyz).all()


def test_axes_of_sgp4_need_no_table_of_ut1():
    pole = motion().at("2080-01-01").in_frame("teme").frame_to_body((0.0, 0.0, 1.0))
    assert np.linalg.norm(pole) == pytest.approx(1.0)


def test_a_satellite_of_skyfield_is_an_orbit():
    from skyfield.api import EarthSatellite, load

    lines = (DATA / "paths" / "envisat-2013.tle").read_text().splitlines()
    one, two = (next(each for each in lines if each.startswith(k)) for k in ("1 ", "2 "))
    theirs = EarthSatellite(one, two, "ENVISAT", load.timescale(builtin=True))
    history = motion().at([0.0, 1000.0])
    np.testing.assert_allclose(
        history.in_frame("rtn", orbit=theirs).matrix,
        history.in_frame("rtn", orbit=orbit()).matrix, atol=1e-6,
    )  # fmt: skip


# The same motion at another epoch -----------------------------------------------------------------


@pytest.mark.filterwarnings("ignore::attitude.errors.CovarianceWarning")
@pytest.mark.parametrize("frame", ["icrf", "ecliptic"])
@pytest.mark.parametrize("at", [1234.5, "2014-02-01T00:00:00"])
def test_the_spin_at_another_epoch_is_the_same_motion(frame, at):
    first = motion(frame=frame, covariance={"attitude": 0.01, "angular_velocity": 1e-5})
    spin = first.spin_at(at)
    assert spin.frame == frame
    second = FreeRotation(first.body, spin)
    dates = ["2013-12-01", "2014-03-01"]
    angle = 2 * np.arccos(np.minimum(np.abs(np.sum(first.at(dates).wxyz * second.at(dates).wxyz,
                                                   axis=-1)), 1))  # fmt: skip
    # The rounding of the new rates grows over 1e7 s to 1e7 * 0.05 * 1e-16.
    assert np.all(angle < 1e-7)
    theirs, ours = (each.at(dates).covariance for each in (first, second))
    size = np.sqrt(np.einsum("nii,njj->nij", theirs, theirs))
    assert np.all(np.abs(theirs - ours) < 1e-6 * size)


def test_published_at_another_epoch():
    first = motion()
    there = first.published("L", at="2013-11-01")
    assert there.epoch == epochs.instant("2013-11-01")
    plain = first.published("L")
    assert there.P_psi == pytest.approx(plain.P_psi, rel=1e-12)
    again = FreeRotation(first.body, Spin.from_periods(first.body, **there.keywords()))
    np.testing.assert_allclose(again.at("2013-11-02").matrix, first.at("2013-11-02").matrix,
                               atol=1e-7)  # fmt: skip
    with pytest.raises(AttitudeError, match="give one finite epoch"):
        first.spin_at([0.0, 1.0])


def test_obliquity_of_the_pole_to_an_orbit():
    path = paths.kepler(
        epoch="2026-01-01", semi_major_axis="1 au", eccentricity=0.1, inclination="10 deg",
        node="40 deg", pericenter_argument=0.0, mean_anomaly=0.0,
    )  # fmt: skip
    node, tilt = np.radians([40.0, 10.0])
    normal = np.array([np.sin(node) * np.sin(tilt), -np.cos(node) * np.sin(tilt), np.cos(tilt)])
    pole = first = motion()
    pole = frames.matrix_to_icrf("ecliptic").T @ first.momentum
    expected = np.arccos(pole @ normal / np.linalg.norm(pole))
    assert first.obliquity(path) == pytest.approx(expected, abs=1e-12)
    assert first.obliquity(path, "2030-01-01") == pytest.approx(expected, abs=1e-12)
    assert first.obliquity(paths.body("earth", "builtin")) == pytest.approx(
        np.arccos((pole / np.linalg.norm(pole))[2]), abs=1e-4
    )
    view = Scene(first, path, "earth", ephemeris="builtin").at([0.0, 1e6])
    np.testing.assert_allclose(view.obliquity, expected, atol=1e-12)
    with pytest.raises(AttitudeError, match="orbit is 'earth'; give the path of the body"):
        first.obliquity("earth")
