"""Paths joined, compressed, at rest and infinitely far: laws, and conversion to other libraries."""

import copy
import pickle
import subprocess
import sys

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from attitude import paths
from attitude.epochs._inputs import instant
from attitude.errors import AttitudeError
from attitude.paths._path import Path, since
from tests.support import earth_orientation
from tests.support.kernels import DATA, kernel

START = instant("2028-01-01T00:00:00")
SECONDS = np.linspace(0.0, 3e7, 501)
COORDINATE = st.floats(-1e12, 1e12)
VECTOR = st.tuples(COORDINATE, COORDINATE, COORDINATE)


class Rough(Path):
    """Jumps from place to place."""

    name = "rough"

    def _state(self, instant, hi, lo):
        position = np.stack([np.sign(np.sin(hi)), hi, lo + 0.0 * hi])
        return position, 0.0 * position


class Holed(Rough):
    def _state(self, instant, hi, lo):
        position, velocity = super()._state(instant, hi, lo)
        position[0] = np.where(hi > 5.0, np.nan, 1.0)
        return position, velocity


def test_what_has_the_same_center_needs_no_ephemeris():
    satellite = paths.tle(DATA / "envisat-2013.tle")
    ground = paths.site("11 deg", "48 deg", 500.0)
    path = paths.relative(satellite, ground, ephemeris="/nowhere/at/all.bsp")
    now = instant("2013-10-23T04:00:00")
    between = satellite.position(now, 0.0) - ground.position(now, 0.0)
    assert np.array_equal(path.position(now, 0.0), between)
    assert path.center is ground and path.plus == (satellite,) and path.minus == (ground,)


def test_a_path_relative_to_its_own_center_is_itself():
    satellite = paths.tle(DATA / "envisat-2013.tle")
    assert paths.relative(satellite, "earth", "/nowhere.bsp") is satellite
    nothing = paths.relative("earth", "earth", "/nowhere.bsp")
    assert not nothing.position(START, SECONDS).any()


def test_centers_that_are_paths_are_followed():
    station = paths.fixed((1e7, 0, 0), center="earth", name="station")
    probe = paths.fixed((0, 5.0, 0), center=station, name="probe")
    assert np.array_equal(paths.relative(probe, station).position(START, 0.0), [0, 5, 0])
    assert np.array_equal(paths.relative(probe, "earth").position(START, 0.0), [1e7, 5, 0])
    assert np.array_equal(paths.relative("earth", probe).position(START, 0.0), [-1e7, -5, 0])


def test_relative_positions_add_up():
    file = kernel("de421")
    sun, moon = (paths.body(name, file) for name in ("sun", "moon"))
    difference = moon.state(START, SECONDS), sun.state(START, SECONDS)
    path = paths.relative("moon", "sun", file)
    for one, other, found in zip(*difference, path.state(START, SECONDS), strict=True):
        assert np.abs((one - other) - found).max() <= 4 * np.spacing(1.5e11)
    back = paths.relative("sun", "moon", file)
    turned = back.position(START, SECONDS) + path.position(START, SECONDS)
    assert np.abs(turned).max() <= 4 * np.spacing(1.5e11)
    again = paths.relative(moon, sun, file)
    assert np.abs(again.position(START, SECONDS) - path.position(START, SECONDS)).max() < 1e-4


def test_the_span_is_what_all_parts_cover():
    path = paths.relative(paths.oem(DATA / "apophis-2012-2013.oem"), "earth", kernel("de421"))
    assert path.span[0].time.iso == "2012-12-01 00:00:00.000"
    with pytest.raises(AttitudeError, match="APOPHIS is known from 2012-12-01"):
        path.position(START, 0.0)


@pytest.mark.parametrize(
    ("epochs_of_path", "sentence"),
    [
        (("2026-01-01", [0.0]), "instant is '2026-01-01'; give an Instant, made by epochs.instant"),
        ((START, [0.0, 1.0], [1.0, 2.0, 3.0]), r"low has shape \(3,\), seconds has \(2,\)"),
        ((START, "a"), "seconds is 'a', which is not a number"),
    ],
)
def test_epochs_of_other_kinds_are_refused(epochs_of_path, sentence):
    with pytest.raises(AttitudeError, match=sentence):
        paths.fixed((1.0, 0.0, 0.0)).position(*epochs_of_path)


def test_a_direction_has_no_position_and_says_so():
    sun = paths.direction((0.0, 0.0, 3.0), frame="ecliptic", name="Sun")
    assert sun.is_direction and np.linalg.norm(sun.unit) == pytest.approx(1.0, abs=2e-16)
    assert sun.unit == pytest.approx([0.0, -0.3977771559, 0.9174820621], abs=1e-10)
    with pytest.raises(AttitudeError, match="infinitely far"):
        paths.relative(sun, "earth")
    with pytest.raises(AttitudeError, match="no direction"):
        paths.direction((0, 0, 0))
    assert np.array_equal(paths.direction((1e-300, 0, 0)).unit, [1, 0, 0])
    assert np.array_equal(paths.direction((0, 1e300, 0)).unit, [0, 1, 0])


@given(VECTOR, VECTOR, st.floats(-1e9, 1e9))
def test_uniform_motion_is_linear_in_time(position, velocity, seconds):
    path = paths.uniform(position, velocity, START)
    expected = np.array(position) + np.array(velocity) * seconds
    size = np.abs(position) + np.abs(np.array(velocity) * seconds)
    assert np.all(np.abs(path.position(START, seconds) - expected) <= 1e-15 * size)
    assert np.array_equal(path.velocity(START, seconds), velocity)


def test_uniform_motion_keeps_the_low_double():
    path = paths.uniform((0, 0, 0), (3e4, 0, 0), START)
    later = START.after(1e9)
    moved = path.position(later, 1.0, 3e-8) - path.position(later, 1.0)
    assert moved[0] == pytest.approx(9e-4, abs=4 * np.spacing(3e13))


@pytest.mark.parametrize("clone", [copy.deepcopy, lambda p: pickle.loads(pickle.dumps(p))])
def test_copies_are_equal_and_stay_frozen(clone):
    made = [
        paths.uniform((1, 2, 3), (4, 5, 6), START),
        paths.tle(DATA / "envisat-2013.tle"),
        paths.oem(DATA / "apophis-2029-encounter.oem"),
        paths.site(0.1, 0.2),
        paths.kepler(semi_major_axis=1.5e11, eccentricity=0.1, inclination=0.1, node=0.2,
                     pericenter_argument=0.3, epoch=START, mean_anomaly=0.0),
    ]  # fmt: skip
    at = {0: START, 1: instant("2013-10-23T06:00:00"), 2: instant("2029-04-13T21:46:00"),
          3: instant("2020-01-01"), 4: START}  # fmt: skip
    for k, path in enumerate(made):
        again = clone(path)
        assert np.array_equal(again.position(at[k], 7.0), path.position(at[k], 7.0))
    with pytest.raises(ValueError, match="read-only"):
        clone(made[0]).start[0] = 0.0
    small = paths.compress(made[1], at[1], at[1].after(600.0))
    assert np.array_equal(clone(small).position(at[1], 7.0), small.position(at[1], 7.0))
    with pytest.raises(ValueError, match="read-only"):
        clone(small).pieces.records[0] = 0.0


@pytest.mark.parametrize("body", ["earth", "moon", "jupiter barycenter"])
@pytest.mark.parametrize("tolerance", [1e3, 1.0, 1e-3])
def test_compression_keeps_its_tolerance_and_measures_its_error(body, tolerance):
    path = paths.body(body, kernel("de421"))
    small = paths.compress(path, START, START.after(3e7), tolerance)
    at = np.random.default_rng(8).uniform(0.0, 3e7, 20_000)
    away = np.linalg.norm(small.position(START, at) - path.position(START, at), axis=-1)
    rounding = 4 * np.spacing(8e11)
    assert small.error <= max(tolerance, 8 * 2.3e-16 * 8e11)
    # Measured where the error of an interpolation peaks; 1.5 is the margin of that rule.
    assert away.max() <= 1.5 * small.error + rounding
    speed = np.linalg.norm(small.velocity(START, at) - path.velocity(START, at), axis=-1)
    assert speed.max() <= 1.5 * small.speed_error + 1e-9
    assert small.source.startswith("de421.bsp, compressed to")


def test_compression_is_short_only_where_the_motion_is_quick():
    path = paths.oem(DATA / "apophis-2029-encounter.oem")
    small = paths.compress(path, *path.span, 1.0)
    close = since(instant("2029-04-13T21:46:00"), small.pieces.start)[0]
    ends = small.pieces.starts + small.pieces.widths
    at = int(np.flatnonzero((small.pieces.starts <= close) & (close < ends))[0])
    assert small.pieces.widths[at] < small.pieces.widths.max() / 8
    assert np.array_equal(ends[:-1], small.pieces.starts[1:])


def test_a_compressed_path_ends_where_it_was_told():
    path = paths.compress(paths.body("earth", kernel("de421")), START, START.after(1e6))
    assert np.isfinite(path.position(START, [0.0, 1e6])).all()
    for seconds in (-1e-6, 1e6 + 1e-6):
        with pytest.raises(AttitudeError, match="earth is known from 2028-01-01"):
            path.position(START, [0.0, seconds])


def test_compression_over_a_century_loses_nothing_to_the_rounding_of_time():
    path = paths.body("earth", kernel("de421"))
    small = paths.compress(path, path.span[0], path.span[1], 1e-3)
    at = np.random.default_rng(9).uniform(0.0, 4.8e9, 20_000)
    low = np.random.default_rng(10).uniform(-4e-7, 4e-7, 20_000)
    away = small.position(path.span[0], at, low) - path.position(path.span[0], at, low)
    assert np.linalg.norm(away, axis=-1).max() < 1.5e-3


def test_what_cannot_be_compressed_is_refused():
    with pytest.raises(AttitudeError, match=r"rough still errs by more than 0\.001 m"):
        paths.compress(Rough(), START, START.after(1e3))
    with pytest.raises(AttitudeError, match="rough has no finite position at 2028"):
        paths.compress(Holed(), START, START.after(1e3))
    with pytest.raises(AttitudeError, match=r"path is .*; give one with positions"):
        paths.compress(paths.direction((1, 0, 0)), START, START.after(1e3))
    with pytest.raises(AttitudeError, match="start must be before stop"):
        paths.compress(Rough(), START, START)
    with pytest.raises(AttitudeError, match="greater than zero"):
        paths.compress(Rough(), START, START.after(1.0), 0.0)
    with pytest.raises(AttitudeError, match="is known from"):
        paths.compress(paths.body("earth", kernel("de421")), START, "2060-01-01")


def test_the_rough_series_of_astropy_is_compressed_to_its_roughness():
    path = paths.body("earth", "builtin")
    small = paths.compress(path, START, START.after(2e6))
    assert small.error <= path.roughness == 0.1


def test_names_of_bodies():
    from attitude.paths._path import body_name

    for body, name in (
        ("SSB", "ssb"),
        ("Solar_System_Barycenter", "ssb"),
        (399, "earth"),
        ("Mars Barycentre", "mars barycenter"),
        (np.int64(20099942), "20099942"),
        ("-98", "-98"),
    ):
        assert body_name(body) == name
    for wrong in ("vulcan", None, 1.5, True, ""):
        with pytest.raises(AttitudeError, match="not the name of a body"):
            body_name(wrong)


def test_importing_paths_imports_nothing_heavy():
    heavy = "astropy", "skyfield", "numba", "erfa", "scipy", "spiceypy", "jplephem", "sgp4"
    code = f"import sys, attitude.paths; print([m for m in {heavy} if m in sys.modules])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_the_settings_of_astropy_are_not_changed():
    from astropy.coordinates import solar_system_ephemeris
    from astropy.utils import iers

    ephemeris = solar_system_ephemeris.get()
    with earth_orientation.installed():
        table = iers.earth_orientation_table.get()
        paths.from_astropy("mars", kernel("de421")).position(START, 0.0)
        paths.site(0.1, 0.2).position(instant("2020-01-01"), 0.0)
        assert iers.earth_orientation_table.get() is table
    assert solar_system_ephemeris.get() == ephemeris
