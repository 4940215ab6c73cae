"""STK attitude files, against orbit-formats and by hand."""

import re

import numpy as np
import pytest

from attitude import AttitudeError, Body, FreeRotation, Spin, epochs
from attitude.formats import stk
from attitude.frames import quaternion
from attitude.frames import representations as forms

SPIN = Spin(epoch="2016-12-31T23:59:50.25", wxyz=(1, 2, 3, 4), angular_velocity=(0.01, 0.15, 0.01))
MOTION = FreeRotation(Body(moments=(10, 20, 26)), SPIN)
HISTORY = MOTION.at(np.arange(60) / 3.0)
BY_HAND = """\
stk.v.11.0
# made by hand
BEGIN Attitude
NumberOfAttitudePoints  2
CentralBody             Earth
ScenarioEpoch           1 Jan 2026 12:00:00.5
CoordinateAxes          ICRF
AttitudeTimeQuatAngVels
0.0   0 0 0 1                                      0 0 1
90.0  0 0 0.7071067811865476 0.7071067811865476    0 0 1
END Attitude
"""


def apart(p, q):
    d = quaternion.multiply(quaternion.conjugate(p), q)
    return np.max(2.0 * np.arctan2(np.linalg.norm(d[..., 1:], axis=-1), np.abs(d[..., 0])))


def late(read, history):
    hi, lo = epochs.seconds_since(history.epoch, read.epoch)
    return np.max(np.abs((read.seconds - history.seconds + hi) + (read.low + lo)))


@pytest.mark.parametrize(
    "section",
    [
        *("AttitudeTimeQuatAngVels", "AttitudeTimeQuaternions"),
        *("AttitudeTimeQuatScalarFirst", "AttitudeTimeEulerAngles"),
    ],
)
@pytest.mark.parametrize("frame", ["ICRF", "J2000", "Fixed", "TEMEOfDate"])
def test_there_and_back(tmp_path, section, frame):
    path = tmp_path / "a.a"
    stk.write(path, HISTORY, section=section, frame=frame)
    found = stk.read(path)
    assert late(found, HISTORY) < 5e-12  # one double of seconds from a whole second, and UTC text
    if frame == "ICRF" and "Quat" in section:
        assert np.array_equal(found.wxyz, HISTORY.wxyz)
    assert apart(found.wxyz, HISTORY.wxyz) < (3e-14 if frame in ("Fixed", "TEMEOfDate") else 3e-15)
    if section == "AttitudeTimeQuatAngVels":
        assert np.max(np.abs(found.angular_velocity - HISTORY.angular_velocity)) < 1e-14
    assert (found.method, found.degree) == ("lagrange", 7)


def test_by_hand(tmp_path):
    path = tmp_path / "a.a"
    path.write_text(BY_HAND)
    found = stk.read(path)
    assert found.epoch.utc_iso == "2026-01-01T12:00:00.5"
    assert apart(found.at(45.0).wxyz, forms.from_axis_angle((0, 0, 1), np.pi / 4)) < 1e-8
    assert np.allclose(found.angular_velocity, np.radians([0, 0, 1]), atol=1e-17)
    assert found.method == "slerp"
    # STK's simulator of attitudes appends plots.
    path.write_text(f"{BY_HAND}BEGIN DataGroup\n BEGIN DataElement\n 1 2\nEND DataGroup\n")
    assert np.array_equal(stk.read(path).wxyz, found.wxyz)
    matrix = "0.0 1 0 0 0 1 0 0 0 1\n90 0 1 0 -1 0 0 0 0 1\nEND Attitude\n"
    text = re.sub(r"(?s)AttitudeTimeQ.*", "AttitudeTimeDCM\n" + matrix, BY_HAND)
    path.write_text(text)
    assert apart(stk.read(path).wxyz, found.wxyz) < 1e-15


def test_orbit_formats_reads_ours(tmp_path):
    theirs = pytest.importorskip("orbit_formats", reason="orbit-formats is not installed")
    path = tmp_path / "a.a"
    for section in ("AttitudeTimeQuaternions", "AttitudeTimeQuatScalarFirst"):
        stk.write(path, HISTORY[:20], section=section)
        read = theirs.read(str(path))
        assert np.array_equal(read.records, np.roll(HISTORY.wxyz[:20], -1, axis=1))
        again = tmp_path / "b.a"
        theirs.write(read, str(again), format="stk-attitude")
        assert apart(stk.read(again).wxyz, HISTORY.wxyz[:20]) < 1e-8


BAD = [
    (r"stk\.v\.11\.0", "sdk.v.1", "line 1: it begins with 'sdk.v.1'"),
    (r"BEGIN Attitude", "BEGIN Ephemeris", "line 3: .* stands where BEGIN Attitude"),
    (r"CentralBody ", "CentreBody ", "line 5: 'CentreBody' is not known"),
    (
        r"CentralBody .*",
        "ScenarioEpoch 1 Jan 2026 00:00:00",
        "line 6: ScenarioEpoch is given twice",
    ),
    (r"1 Jan 2026", "1 Jann 2026", "line 6: ScenarioEpoch is"),
    (r"1 Jan 2026", "31 Feb 2026", "line 6: ScenarioEpoch is"),
    (r"12:00:00\.5", "12:00:60", "ScenarioEpoch"),
    (r"CoordinateAxes  *ICRF", "CoordinateAxes MoonFixed", "line 7: CoordinateAxes is 'MoonFixed'"),
    (r"CoordinateAxes.*\n", "", r"has no CoordinateAxes, .* or give frame="),
    (r"Points  2", "Points 3", "has 2 records, but NumberOfAttitudePoints is 3"),
    (r"Points  2", "Points two", "line 4: NumberOfAttitudePoints is 'two'"),
    (r"90\.0  0 0 0\.7", "90.0  0 0 0.8", "line 10: the length of the quaternion is off 1 by"),
    (r"90\.0 ", "-1 ", "line 10: the epoch goes backwards"),
    (r"90\.0 ", "nan ", "line 10: its time is not finite"),
    (r"90\.0 ", "1e308 ", r"line 10: its time is not finite, or beyond 1e\+15"),
    (r"90\.0 ", "ninety ", "line 10: 'ninety' is no number"),
    (r"90\.0 ", "", "line 10: it has 7 entries"),
    (r"END Attitude\n", "END Attitude\nmore\n", "line 12: there is more after"),
    (r"AttitudeTimeQuatAngVels(.|\n)*", "", "ends before its data"),
    (r"0\.0   0 0(.|\n)*?END", "END", "records, but|no attitudes"),
    (r"AttitudeTimeQuatAngVels", "Sequence 311\nAttitudeTimeEulerAngles", "line 8: Sequence"),
]


@pytest.mark.parametrize(("pattern", "instead", "sentence"), BAD)
def test_what_is_wrong_is_told(tmp_path, pattern, instead, sentence):
    path = tmp_path / "bad.a"
    changed = re.sub(pattern, lambda _: instead, BY_HAND, count=1)
    assert changed != BY_HAND
    path.write_text(changed)
    with pytest.raises(AttitudeError, match=sentence):
        stk.read(path)


def test_what_cannot_be_written(tmp_path):
    for source, how, sentence in [
        ([HISTORY[:5], HISTORY[6:]], {}, "2 segments"),
        (HISTORY, {"section": "AttitudeTimeDCM"}, "section is"),
        (HISTORY, {"frame": "ecliptic"}, "do not know"),
        (HISTORY, {"frame": "VVLH"}, "orbit="),
        (HISTORY, {"frame": None}, "frame is None"),
        (HISTORY, {"order": 0}, "order is 0"),
        (HISTORY, {"order": 40}, "order is 40"),
    ]:
        with pytest.raises(AttitudeError, match=sentence):
            stk.write(tmp_path / "x.a", source, **how)
    assert not list(tmp_path.iterdir())


def test_the_order_of_interpolation_has_its_records(tmp_path):
    for count, order in ((60, 7), (3, 2), (1, 1)):
        stk.write(tmp_path / "a.a", HISTORY[:count])
        assert f"InterpolationOrder {order}\n" in (tmp_path / "a.a").read_text()
    stk.write(tmp_path / "a.a", HISTORY, order=9)
    assert stk.read(tmp_path / "a.a").degree == 9
    with pytest.raises(AttitudeError, match="tolerance is"):
        stk.read(tmp_path / "a.a", tolerance=float("nan"))


def test_vvlh_is_that_of_the_orbit(tmp_path):
    from attitude.paths._path import Path

    class Circle(Path):
        name, center, source = "circle", "earth", "made for this test"

        def _state(self, instant, hi, lo):
            angle = 1e-3 * (hi + lo + (instant.seconds - SPIN.epoch.seconds))
            x, y, zero = np.cos(angle), np.sin(angle), 0.0 * angle
            return 7e6 * np.stack([x, y, zero]), 7e3 * np.stack([-y, x, zero])

    path = tmp_path / "a.a"
    stk.write(path, HISTORY, frame="VVLH", orbit=Circle())
    assert "CoordinateAxes VVLH" in path.read_text()
    found = stk.read(path, orbit=Circle())
    assert apart(found.wxyz, HISTORY.wxyz) < 1e-13
    assert np.max(np.abs(found.angular_velocity - HISTORY.angular_velocity)) < 1e-14
    # z to the center, x along the velocity: body axes that are VVLH's are the unit quaternion
    at_start = np.array([[0.0, 0, -1], [1, 0, 0], [0, -1, 0]])
    text = re.sub(
        r"(?s)AttitudeTimeQ.*",
        "AttitudeTimeDCM\n0 1 0 0 0 1 0 0 0 1\nEND Attitude\n",
        path.read_text(),
    )
    path.write_text(re.sub(r"Points \d+", "Points 1", text))
    early = stk.read(path, orbit=Circle()).history
    assert np.allclose(early.matrix[0], at_start, atol=1e-3)  # 0.25 s before, 1e-3 rad/s
