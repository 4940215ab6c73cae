"""SPK files of other types, written by SPICE for the test, against SPICE and the orbit itself."""

import pickle

import numpy as np
import pytest

from attitude import Scene, paths
from attitude.epochs._instants import Instant
from attitude.errors import AttitudeError
from tests.support.kernels import kernel

spiceypy = pytest.importorskip("spiceypy", reason="spiceypy is not installed")

RADIUS = 7e6
RATE = 1e-3
EPOCHS = 7e8 + np.arange(0.0, 6001.0, 60.0)
TARGET = -7777
FRAME_CENTER = (399, "J2000")


def circle(seconds):
    """Position and velocity (..., 6) in km of a circular orbit."""
    angle = RATE * (np.asarray(seconds) - EPOCHS[0])
    c, s, zero = np.cos(angle), np.sin(angle), 0.0 * angle
    turning = RADIUS * RATE
    return 1e-3 * np.stack([RADIUS * c, RADIUS * s, zero, -turning * s, turning * c, zero], -1)


def written(file, kind, frame="J2000", epochs=EPOCHS, factor=1.0, target=TARGET, center=399):
    handle = spiceypy.spkopa(str(file)) if file.exists() else spiceypy.spkopn(str(file), "test", 0)
    given = handle, target, center, frame, epochs[0], epochs[-1], "test"
    if kind == 3:
        width = 600.0
        records = []
        for start in np.arange(epochs[0], epochs[-1], width):
            x = np.cos(np.pi * (np.arange(12) + 0.5) / 12)
            values = circle(start + 0.5 * width * (x + 1.0))
            rows = np.polynomial.chebyshev.chebfit(x, values, 11).T
            records.append(np.concatenate([[start + width / 2, width / 2], rows.ravel()]))
        data = [row[2:] for row in records]
        spiceypy.spkw03(*given, width, len(data), 11, np.ravel(data), epochs[0])
    elif kind == 9:
        spiceypy.spkw09(*given, 9, len(epochs), circle(epochs), epochs)
    elif kind == 13:
        spiceypy.spkw13(*given, 7, len(epochs), factor * circle(epochs), epochs)
    spiceypy.spkcls(handle)
    return file


@pytest.mark.parametrize("kind", [3, 9, 13])
def test_other_types_agree_with_spice_and_with_the_orbit(tmp_path, kind):
    file = written(tmp_path / f"type{kind}.bsp", kind)
    path = paths.spk(file, TARGET)
    assert path.center == "earth" and path.source == file.name
    et = np.random.default_rng(kind).uniform(EPOCHS[0], EPOCHS[-1], 300)
    position, velocity = path.state(Instant(0.0), et)
    with spiceypy.KernelPool(str(file)):
        states = 1e3 * np.array(spiceypy.spkezr(str(TARGET), et, "J2000", "NONE", "399")[0])
    assert np.abs(position - states[:, :3]).max() < 1e-6
    assert np.abs(velocity - states[:, 3:]).max() < 1e-9
    assert np.abs(position - 1e3 * circle(et)[:, :3]).max() < 1e-3  # of the interpolation


def falling(seconds):
    """Position and velocity (..., 6) in km of a constant acceleration."""
    t = np.asarray(seconds)[..., None] - EPOCHS[0]
    start, speed, pull = np.array([7e3, -2e3, 1e3]), np.array([1.0, 2.0, -3.0]), PULL
    return np.concatenate([start + t * (speed + 0.5 * t * pull), speed + t * pull], -1)


PULL = np.array([-8e-3, 1e-3, 2e-3])  # km/s2


def type_21(file):
    """A segment of modified difference arrays, as Horizons writes them; SPICE itself writes none.

    Laid over a segment of type 13 that has as many numbers: 28 for each record of dimension 4
    (SPK Required Reading: TL, G, reference state, differences, KQMAX1, KQ; then the epochs).
    """
    ends = EPOCHS[10::10]
    count = 4 * len(ends)
    filler = np.linspace(EPOCHS[0], EPOCHS[-1], count)
    written(file, 13, epochs=filler)
    rows = np.zeros((len(ends), 27))
    rows[:, 0], rows[:, 1:5] = ends, 1.0
    states = falling(ends)
    rows[:, 5:11:2], rows[:, 6:11:2] = states[:, :3], states[:, 3:]
    rows[:, 11:23:4] = PULL  # the first difference of each component
    rows[:, 23:] = 2.0
    rows[:, 24:] = 1.0
    words = np.concatenate([rows.ravel(), ends, [4.0, len(ends)]])
    content = bytearray(file.read_bytes())
    summary = 1024  # the second record: three doubles of the list, then two of the span
    integers = np.frombuffer(content, "<i4", 6, summary + 40)
    assert integers[3] == 13 and integers[5] - integers[4] + 1 == len(words)
    integers.setflags(write=True)
    integers[3] = 21
    np.frombuffer(content, "<f8", len(words), 8 * (integers[4] - 1))[:] = words
    file.write_bytes(content)
    return file


def test_difference_arrays_of_horizons(tmp_path):
    path = paths.spk(type_21(tmp_path / "type21.bsp"), TARGET)
    et = np.random.default_rng(21).uniform(EPOCHS[0], EPOCHS[-1], 300)
    position, velocity = path.state(Instant(0.0), et)
    with spiceypy.KernelPool(str(tmp_path / "type21.bsp")):
        states = 1e3 * np.array(spiceypy.spkezr(str(TARGET), et, "J2000", "NONE", "399")[0])
    assert np.abs(position - states[:, :3]).max() < 1e-6
    assert np.abs(velocity - states[:, 3:]).max() < 1e-9
    expected = 1e3 * falling(et)
    assert np.abs(position - expected[:, :3]).max() < 1e-2  # 1e8 m, of epochs to 1.2e-7 s
    assert np.abs(velocity - expected[:, 3:]).max() < 1e-5


@pytest.mark.parametrize("kind", [3, 9, 13])
def test_the_low_double_counts(tmp_path, kind):
    path = paths.spk(written(tmp_path / f"low{kind}.bsp", kind), TARGET)
    start, low = Instant(EPOCHS[3] + 7.0), 2e-8  # one double resolves 1.2e-7 s at 7e8 s
    step = path.position(start, 0.0, low) - path.position(start, 0.0)
    assert step == pytest.approx(path.velocity(start, 0.0) * low, abs=4e-9)


@pytest.mark.parametrize("kind", [3, 13])
def test_the_ecliptic_frame_of_spice_is_turned(tmp_path, kind):
    path = paths.spk(written(tmp_path / f"ecliptic{kind}.bsp", kind, "ECLIPJ2000"), TARGET)
    expected = spiceypy.pxform("ECLIPJ2000", "J2000", 0.0) @ (1e3 * circle(EPOCHS[5])[:3])
    assert path.position(Instant(EPOCHS[5]), 0.0) == pytest.approx(expected, abs=1e-4)


def test_other_frames_are_refused(tmp_path):
    file = written(tmp_path / "b1950.bsp", 13, "B1950")
    with pytest.raises(AttitudeError, match="frame number 2; only inertial"):
        paths.spk(file, TARGET)


def test_segments_that_follow_each_other_make_one_path(tmp_path):
    file = tmp_path / "two.bsp"
    written(file, 13, epochs=EPOCHS[:50])
    written(file, 13, epochs=EPOCHS[60:])
    path = paths.spk(file, TARGET)
    et = np.array([EPOCHS[10], EPOCHS[70] + 1.0, EPOCHS[20]])
    assert np.abs(path.position(Instant(0.0), et) - 1e3 * circle(et)[:, :3]).max() < 1e-3
    again = pickle.loads(pickle.dumps(path))
    assert all(one is other for one, other in zip(again.parts, path.parts, strict=True))
    with pytest.raises(AttitudeError, match=r"is known from 2022.* to 2022.*, 2022.* to 2022"):
        path.position(Instant(EPOCHS[55]), 0.0)


def test_a_body_with_several_centers_is_relative_to_the_barycentre(tmp_path):
    # A cruise about the Sun, then an orbit about the Earth, as in the kernels of missions.
    file = written(tmp_path / "mission.bsp", 13, epochs=EPOCHS[:50], center=10)
    written(file, 13, epochs=EPOCHS[60:])
    path = paths.spk(file, TARGET, ephemeris=kernel("de421"))
    assert path.center == "ssb"
    with pytest.raises(AttitudeError, match=f"several centers for {TARGET}, which one center="):
        paths.spk(file, TARGET, center="moon")
    one = written(tmp_path / "one.bsp", 13)
    about = paths.spk(one, TARGET, center=(moon := paths.body("moon", kernel("de421"))))
    assert (about.center, about.name) == (moon, str(TARGET))
    place = {"spk": "one.bsp", "target": TARGET, "center": "moon"}
    for other in (about, paths.place(place, folder=tmp_path), pickle.loads(pickle.dumps(about))):
        apart = other.position(Instant(0.0), EPOCHS) - paths.spk(one, TARGET).position(
            Instant(0.0), EPOCHS
        )
        assert np.all(apart == 0.0)
    et = np.array([EPOCHS[10], EPOCHS[70] + 1.0])
    with spiceypy.KernelPool([str(file), str(kernel("de421"))]):
        states = 1e3 * np.array(spiceypy.spkezr(str(TARGET), et, "J2000", "NONE", "0")[0])
    position, velocity = path.state(Instant(0.0), et)
    assert np.abs(position - states[:, :3]).max() < 2e-3  # of the one double of epochs of SPICE
    assert np.abs(velocity - states[:, 3:]).max() < 1e-9
    again = pickle.loads(pickle.dumps(path))
    assert np.array_equal(again.position(Instant(0.0), et), position)
    with pytest.raises(AttitudeError, match=r"has no path of sun, .* or a list of kernels"):
        paths.body(TARGET, file)


def test_kernels_are_joined(tmp_path):
    # A spacecraft about an asteroid, the asteroid in a kernel of its own, the Sun in a third.
    asteroid = written(tmp_path / "asteroid.bsp", 9, target=20099942, center=10, factor=1.0)
    craft = written(tmp_path / "craft.bsp", 13, center=20099942)
    kernels = [craft, asteroid, kernel("de421")]
    et = EPOCHS[:40] + 1.0
    with spiceypy.KernelPool([str(file) for file in kernels]):
        states = 1e3 * np.array(spiceypy.spkezr(str(TARGET), et, "J2000", "NONE", "399")[0])
    path = paths.relative(TARGET, "earth", kernels)
    assert np.abs(path.position(Instant(0.0), et) - states[:, :3]).max() < 2e-3
    scene = Scene(None, TARGET, observer=20099942, ephemeris=kernels, light_time=False)
    assert abs(scene.at(Instant(et[3])).observer_distance - RADIUS) < 2e-3
    joined = paths.ephemeris(kernels)
    assert joined.source == "craft.bsp, asteroid.bsp, de421.bsp"
    assert {str(TARGET), "20099942", "earth", "ssb"} <= set(joined.bodies)
    assert pickle.loads(pickle.dumps(joined)).step("earth") is joined.step("earth")
    with pytest.raises(AttitudeError, match=r"has no 433; .* Give one of these, or one ephemeris"):
        joined.step(433)
    with pytest.raises(AttitudeError, match=r"ephemeris is \[\]; give .*, or a list of these"):
        paths.ephemeris([])


def test_a_file_that_is_written_again_is_read_again(tmp_path):
    file = written(tmp_path / "again.bsp", 13)
    earlier = paths.spk(file, TARGET)
    position = earlier.position(Instant(0.0), EPOCHS[:3])
    file.unlink()
    written(file, 13, factor=2.0)
    assert np.all(paths.spk(file, TARGET).position(Instant(0.0), EPOCHS[:3]) == 2.0 * position)
    with pytest.raises(AttitudeError, match=r"another file has replaced again.bsp since -7777"):
        earlier.position(Instant(0.0), EPOCHS[:3])


def test_the_pool_of_spice_is_left_alone(tmp_path):
    path = paths.spk(written(tmp_path / "pool.bsp", 9), TARGET)
    before = spiceypy.ktotal("ALL")
    path.position(Instant(EPOCHS[4]), 0.0)
    assert spiceypy.ktotal("ALL") == before


def test_without_spiceypy_the_extra_is_named(tmp_path, monkeypatch):
    file = written(tmp_path / "missing.bsp", 13)
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    with pytest.raises(AttitudeError, match=r"type 13, .*\[spice\]"):
        paths.spk(file, TARGET)
