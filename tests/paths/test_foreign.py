"""What skyfield and astropy know, taken as it is: the same numbers, the epochs in two doubles."""

import numpy as np
import pytest
from astropy.coordinates import get_body_barycentric_posvel
from astropy.time import Time
from skyfield.constants import AU_M
from skyfield.jpllib import SpiceKernel

from attitude import paths
from attitude.epochs._inputs import instant
from attitude.errors import AttitudeError
from attitude.frames._earth import timescale
from attitude.paths._path import julian
from tests.support.kernels import DATA, decaying, kernel

START = instant("2026-03-01T00:00:00")
SECONDS = np.random.default_rng(4).uniform(-3e8, 3e8, 300)


@pytest.fixture
def planets():
    opened = SpiceKernel(str(kernel("de421")))
    yield opened
    opened.close()


def test_a_vector_of_skyfield_is_its_own_number_at_our_tdb(planets):
    path = paths.from_skyfield(planets["mars"])
    assert path.center == "ssb" and path.source == "skyfield"
    ours = paths.body("mars", kernel("de421")).position(START, SECONDS)
    assert np.abs(path.position(START, SECONDS) - ours).max() < 1e-3
    time = timescale().tdb_jd(*julian(START, SECONDS, np.zeros(1)))
    theirs = planets["mars"].at(time).position.au.T * AU_M
    assert np.abs(path.position(START, SECONDS) - theirs).max() < 1e-3


def test_differences_of_skyfield_keep_their_center(planets):
    path = paths.from_skyfield(planets["moon"] - planets["earth"], name="Moon")
    assert (path.center, path.name) == ("earth", "Moon")
    ours = paths.body("moon", kernel("de421"), center="earth")
    assert np.abs(path.position(START, SECONDS) - ours.position(START, SECONDS)).max() < 1e-3
    assert np.abs(path.velocity(START, SECONDS) - ours.velocity(START, SECONDS)).max() < 1e-8


def test_skyfield_outside_of_its_kernel_is_refused(planets):
    with pytest.raises(AttitudeError, match="skyfield does not cover every epoch of 499 MARS"):
        paths.from_skyfield(planets["mars"]).position(START, 1e10)


def test_a_decayed_satellite_of_skyfield_is_refused():
    from skyfield.api import EarthSatellite

    lines = (DATA / "envisat-2013.tle").read_text().splitlines()
    path = paths.from_skyfield(EarthSatellite(*decaying(lines), "ENVISAT", timescale()))
    start = instant("2013-10-23T04:58:20")
    assert np.isfinite(path.position(start, 0.0)).all()
    with pytest.raises(AttitudeError, match=r"skyfield has no position of ENVISAT.*has decayed"):
        path.position(start, [0.0, 4e7])


@pytest.mark.parametrize("wrong", [3, "mars", None])
def test_what_is_no_vector_of_skyfield_is_refused(wrong):
    with pytest.raises(AttitudeError, match="no vector function"):
        paths.from_skyfield(wrong)


@pytest.mark.parametrize("body", ["earth", "moon", "sun", "jupiter", "venus"])
def test_bodies_of_astropy_are_its_own_numbers(body):
    for ephemeris in ("builtin", str(kernel("de421"))):
        path = paths.from_astropy(body, ephemeris)
        time = Time(*julian(START, SECONDS, np.zeros(1)), format="jd", scale="tdb")
        theirs = get_body_barycentric_posvel(body, time, ephemeris=ephemeris)
        position, velocity = path.state(START, SECONDS)
        assert np.abs(position - theirs[0].xyz.to_value("m").T).max() < 1e-3
        assert np.abs(velocity - theirs[1].xyz.to_value("m/s").T).max() < 1e-8


def test_astropy_is_not_asked_for_what_it_would_download():
    with pytest.raises(AttitudeError, match=r"is not a file.*nothing is downloaded"):
        paths.from_astropy("mars", "de440")
    with pytest.raises(
        AttitudeError, match="astropy has no body 'pluto' in this ephemeris; give one of"
    ):
        paths.from_astropy("pluto")


def test_astropy_outside_of_its_kernel_is_refused():
    path = paths.from_astropy("mars", kernel("de421"))
    with pytest.raises(AttitudeError, match=r"de421.bsp through astropy does not give mars"):
        path.position(START, 1e10)
    with pytest.raises(AttitudeError, match="mars is known from 1900"):
        paths.from_astropy("mars").position(START, 1e10)
