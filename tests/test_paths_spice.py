"""SPK files of other types, written by SPICE for the test, against SPICE and the orbit itself."""

import numpy as np
import pytest

from attitude import paths
from attitude.epochs import Instant
from attitude.errors import AttitudeError

spiceypy = pytest.importorskip("spiceypy", reason="spiceypy is not installed")

RADIUS, RATE = 7e6, 1e-3
EPOCHS = 7e8 + np.arange(0.0, 6001.0, 60.0)
TARGET = -7777
FRAME_CENTER = (399, "J2000")


def circle(seconds):
    """Position and velocity (..., 6) in km of a circular orbit."""
    angle = RATE * (np.asarray(seconds) - EPOCHS[0])
    c, s, zero = np.cos(angle), np.sin(angle), 0.0 * angle
    turning = RADIUS * RATE
    return 1e-3 * np.stack([RADIUS * c, RADIUS * s, zero, -turning * s, turning * c, zero], -1)


def written(file, kind, frame="J2000", epochs=EPOCHS):
    handle = spiceypy.spkopn(str(file), "test", 0)
    given = handle, TARGET, 399, frame, epochs[0], epochs[-1], "test"
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
        spiceypy.spkw13(*given, 7, len(epochs), circle(epochs), epochs)
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
    handle = spiceypy.spkopa(str(file))
    late = EPOCHS[60:]
    spiceypy.spkw13(
        handle, TARGET, 399, "J2000", late[0], late[-1], "late", 7, len(late), circle(late), late
    )
    spiceypy.spkcls(handle)
    path = paths.spk(file, TARGET)
    et = np.array([EPOCHS[10], EPOCHS[70] + 1.0, EPOCHS[20]])
    assert np.abs(path.position(Instant(0.0), et) - 1e3 * circle(et)[:, :3]).max() < 1e-3
    with pytest.raises(AttitudeError, match=r"is known from 2022.* to 2022.*, 2022.* to 2022"):
        path.position(Instant(EPOCHS[55]), 0.0)


def test_the_pool_of_spice_is_left_alone(tmp_path):
    path = paths.spk(written(tmp_path / "pool.bsp", 9), TARGET)
    before = spiceypy.ktotal("ALL")
    path.position(Instant(EPOCHS[4]), 0.0)
    assert spiceypy.ktotal("ALL") == before


def test_without_spiceypy_the_extra_is_named(tmp_path, monkeypatch):
    file = written(tmp_path / "missing.bsp", 13)
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    with pytest.raises(AttitudeError, match=r"type 13, .*attitude-propagation\[spice\]"):
        paths.spk(file, TARGET)
