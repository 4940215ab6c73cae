"""Bodies from JPL kernels against skyfield, astropy and SPICE on the same file and the same TDB."""

import pickle

import numpy as np
import pytest
from astropy.coordinates import get_body_barycentric_posvel
from astropy.time import Time
from skyfield.constants import AU_M
from skyfield.jpllib import SpiceKernel

from attitude import paths
from attitude._support import pairs
from attitude.epochs._inputs import instant
from attitude.epochs._instants import Instant
from attitude.errors import AttitudeError
from attitude.frames._earth import timescale
from attitude.paths._path import julian
from tests.support.kernels import kernel

KERNELS = ("de421", "de440")
BODIES = (
    "sun",
    "mercury",
    "venus",
    "emb",
    "earth",
    "moon",
    "mars barycenter",
    "jupiter barycenter",
)
START = instant("2026-03-01T00:00:00")
SECONDS = np.random.default_rng(4).uniform(-3e8, 3e8, 2000)
LOW = np.random.default_rng(5).uniform(-2e-8, 2e-8, 2000)
NO_LOW = np.zeros(1)


def rounding(position):
    """1 mm, or what 4 roundings of the position leave open: 0.1 mm at 1 au, 2 mm at Neptune."""
    return np.maximum(1e-3, 4.0 * np.spacing(np.linalg.norm(position, axis=-1))).max()


@pytest.mark.parametrize("name", KERNELS)
@pytest.mark.parametrize("body", [*BODIES, "neptune barycenter", "pluto barycenter"])
def test_skyfield_on_the_same_kernel_agrees_to_a_millimetre(name, body):
    file = kernel(name)
    theirs = SpiceKernel(str(file))
    found = theirs[body].at(timescale().tdb_jd(*julian(START, SECONDS, LOW)))
    position, velocity = found.position.au.T * AU_M, found.velocity.au_per_d.T * (AU_M / 86400.0)
    ours = paths.body(body, file).state(START, SECONDS, LOW)
    assert np.abs(ours[0] - position).max() < rounding(position)
    assert np.abs(ours[1] - velocity).max() < 1e-8  # 4 roundings of 30 km/s
    theirs.close()


@pytest.mark.parametrize("name", KERNELS)
@pytest.mark.parametrize("body", ["sun", "moon", "earth"])
def test_astropy_on_the_same_kernel_agrees_to_a_millimetre(name, body):
    file = kernel(name)
    time = Time(*julian(START, SECONDS, LOW), format="jd", scale="tdb")
    position, velocity = get_body_barycentric_posvel(body, time, ephemeris=str(file))
    ours = paths.body(body, file).state(START, SECONDS, LOW)
    assert np.abs(ours[0] - position.xyz.to_value("m").T).max() < 1e-3
    assert np.abs(ours[1] - velocity.xyz.to_value("m/s").T).max() < 1e-8


@pytest.mark.parametrize("name", KERNELS)
@pytest.mark.parametrize("target, origin", [("moon", "earth"), ("venus", "sun"), ("earth", "ssb")])
def test_spice_on_the_same_kernel_agrees_to_what_its_epoch_leaves_open(name, target, origin):
    spiceypy = pytest.importorskip("spiceypy", reason="spiceypy is not installed")
    file = kernel(name)
    et = START.seconds + SECONDS[:200]  # one double: 3e-8 s, 2 mm at 60 km/s
    with spiceypy.KernelPool(str(file)):
        states = 1e3 * np.array(spiceypy.spkezr(target, et, "J2000", "NONE", origin)[0])
    path = paths.body(target, file, center=origin)
    position, velocity = path.state(Instant(0.0), et)
    assert np.abs(position - states[:, :3]).max() < 1e-3
    assert np.abs(velocity - states[:, 3:]).max() < 1e-8


def test_no_epoch_is_rounded_to_one_double():
    path = paths.body("earth", kernel("de421"))
    # The same epoch through three instants and splits of the seconds.
    near, far = instant("2026-03-01 TDB"), instant("1965-05-05T05:05:05.123 TDB")
    apart = pairs.add((near.seconds, near.low), -far.seconds, -far.low)
    low = 3.1e-8
    one = path.position(near, 0.0, low)
    other = path.position(far, apart[0], apart[1] + low)
    third = path.position(Instant(near.seconds, low), 0.0)
    assert np.abs(one - other).max() <= 2 * np.spacing(1.5e11)
    assert np.abs(one - third).max() <= 2 * np.spacing(1.5e11)
    step = one - path.position(near, 0.0)
    assert step == pytest.approx(path.velocity(near, 0.0) * low, abs=1e-4)


def test_the_moon_from_the_earth_is_not_taken_through_the_barycentre():
    path = paths.body("moon", kernel("de421"), center="earth")
    assert [part.name for part in path.plus + path.minus] == ["moon", "earth"]
    assert all(part.center == "emb" for part in path.plus + path.minus)


def test_one_epoch_gives_the_bits_of_many():
    path = paths.body("moon", kernel("de421"))
    many = path.state(START, SECONDS[:50], LOW[:50])
    for k in (0, 7, 49):
        one = path.state(START, SECONDS[k], LOW[k])
        assert all(np.array_equal(a, b[k]) for a, b in zip(one, many, strict=True))


@pytest.mark.parametrize("shape", [(), (1,), (4,), (2, 3), (0,), (3, 0)])
def test_shapes(shape):
    path = paths.body("earth", kernel("de421"))
    seconds = np.zeros(shape)
    assert path.position(START, seconds).shape == (*shape, 3)
    assert all(each.shape == (*shape, 3) for each in path.state(START, seconds, 1e-9))


def test_nan_epochs_give_nan_in_their_place_only():
    path = paths.body("earth", kernel("de421"))
    seconds = np.array([0.0, np.nan, 5.0])
    position = path.position(START, seconds)
    assert np.array_equal(np.isnan(position), [[False] * 3, [True] * 3, [False] * 3])
    assert np.array_equal(position[2], path.position(START, 5.0))
    with pytest.raises(AttitudeError, match="infinite"):
        path.position(START, [0.0, np.inf])


def test_read_only_and_strided_epochs_are_taken():
    path = paths.body("earth", kernel("de421"))
    seconds = np.linspace(0.0, 1e6, 20)
    seconds.setflags(write=False)
    assert np.array_equal(path.position(START, seconds)[::2], path.position(START, seconds[::2]))


def test_paths_from_kernels_can_be_pickled():
    path = paths.relative("moon", "sun", kernel("de421"))
    again = pickle.loads(pickle.dumps(path))
    assert np.array_equal(again.position(START, SECONDS[:9]), path.position(START, SECONDS[:9]))
    assert again.plus[0] is path.plus[0]  # the file is opened once in a process


def test_the_source_and_the_span_are_those_of_the_kernel():
    path = paths.body("earth", kernel("de421"))
    assert path.source == "de421.bsp" and path.center == "ssb" and path.name == "earth"
    assert path.span[0].time.iso.startswith("1899-07-29")
    assert repr(path) == "<path of earth from ssb: de421.bsp>"


def test_epochs_outside_name_the_span():
    path = paths.body("earth", kernel("de421"))
    for seconds in (1e10, -1e10):
        with pytest.raises(AttitudeError, match=r"earth is known from 1899-07-29.* to 2053-10-09"):
            path.position(START, [0.0, seconds])
    first, last = path.span
    assert np.isfinite(path.position(first, 0.0)).all()
    assert np.isfinite(path.position(last, 0.0)).all()
    for end, seconds in ((first, -1e-3), (last, 1e-3)):
        with pytest.raises(AttitudeError, match="is known from"):
            path.position(end, seconds)


def test_a_body_that_the_kernel_lacks_is_named_with_those_it_has():
    with pytest.raises(AttitudeError, match=r'has no jupiter; .*"jupiter barycenter"'):
        paths.body("jupiter", kernel("de421"))
    with pytest.raises(AttitudeError, match=r"has no 20099942; it has ssb, mercury barycenter"):
        paths.spk(kernel("de421"), 20099942)
    with pytest.raises(AttitudeError, match="not the name of a body"):
        paths.body("nibiru", kernel("de421"))


def test_what_is_no_kernel_is_refused(tmp_path):
    with pytest.raises(AttitudeError, match=r"is not a file.*nothing is downloaded"):
        paths.body("earth", "de440s")
    text = tmp_path / "kernel.bsp"
    text.write_text("not a kernel, " * 200)
    with pytest.raises(AttitudeError, match=r"kernel.bsp is not an SPK kernel"):
        paths.body("earth", text)
    text.write_bytes(b"")
    with pytest.raises(AttitudeError, match="is not an SPK kernel"):
        paths.body("earth", text)
    with pytest.raises(AttitudeError, match="the ephemeris is 3"):
        paths.ephemeris(3)


def test_a_kernel_copied_in_part_is_refused(tmp_path):
    part = tmp_path / "part.bsp"
    part.write_bytes(kernel("de421").read_bytes()[:2_000_000])
    with pytest.raises(AttitudeError, match=r"ends before|is not an SPK kernel|damaged"):
        paths.body("mars", part).position(START, 0.0)


def test_the_built_in_ephemeris_says_so_and_errs_by_kilometres():
    path = paths.body("earth", "builtin")
    assert "astropy" in path.source
    away = path.position(START, 0.0) - paths.body("earth", kernel("de421")).position(START, 0.0)
    assert 1e2 < np.linalg.norm(away) < 2e7  # epv00 has another barycentre, and errs itself
    with pytest.raises(AttitudeError, match=r"known from 1900-01-01.* to 2100-01-01"):
        path.position(START, 3e9)
    with pytest.raises(AttitudeError, match=r'has no mars; .*"mars barycenter"'):
        paths.body("mars", "builtin")


def test_the_installed_de440_is_the_default():
    file = kernel("de440")
    assert paths.ephemeris() is paths.ephemeris(file)
    assert paths.body("earth").source == "de440.bsp"
