"""Attitude files of CIC (CNES, VTS): Mars by the elements of the IAU, dialects, written files."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from attitude import AttitudeError, Body, FreeRotation, Spin
from attitude.arcs import Arcs, Impulse
from attitude.cli import main
from attitude.formats import aem, cic, detect

HEAD = """\
CIC_AEM_VERS = 2.0
CREATION_DATE = 2020-04-19T13:19:22.262
ORIGINATOR = TEST

META_START
OBJECT_NAME = MARS
OBJECT_ID = MARS
REF_FRAME_A = ICRF
REF_FRAME_B = BODY
ATTITUDE_DIR = A2B
TIME_SYSTEM = TAI
ATTITUDE_TYPE = QUATERNION
QUATERNION_TYPE = FIRST
META_STOP

"""
SPIN = Spin(epoch="2026-01-01", wxyz=(1, 2, 3, 4), angular_velocity=(0.01, 0.15, 0.01))
MOTION = FreeRotation(Body(moments=(10, 20, 26)), SPIN)


def mars(day):
    """The rotation from the axes of Mars to ICRF, IAU 2000: day is TDB since J2000."""
    pole, meridian = (317.68143, 52.88650), 176.630 + 350.89198226 * day
    return Rotation.from_euler("ZXZ", (90.0 + pole[0], 90.0 - pole[1], meridian), degrees=True)


def rows(*, last=False, inverse=False):
    """Rows of Mars at 1999-01-01, TAI, each half day, as tools print them."""
    text = ""
    for k in range(5):
        day = 51179 + 0.5 * k - 51544.5 + 32.184 / 86400
        x, y, z, w = (mars(day).inv() if inverse else mars(day)).as_quat()
        numbers = (x, y, z, w) if last else (w, x, y, z)
        line = " ".join(f"{number:.9f}" for number in numbers)
        text += f"{51179 + k // 2} {43200 * (k % 2)}  {line}\n"
    return text


def read(tmp_path, text, **how):
    path = tmp_path / "quaternions.txt"
    path.write_bytes(text.encode())
    return cic.read(path, **how)


def assert_is_mars(table, error=1e-5):
    """The axes of the body in ICRF, whatever the sign of the quaternions; error in rad."""
    for k in range(len(table)):
        axes = mars((table.epoch.seconds + table.seconds[k]) / 86400.0).as_matrix()
        matrix = Rotation.from_quat(np.roll(table.wxyz[k], -1)).as_matrix()
        np.testing.assert_allclose(matrix, axes, rtol=0, atol=error)


def test_mars(tmp_path):
    """The pole of Mars is body z in ICRF: of the inverse or another order it would not be."""
    found = read(tmp_path, HEAD + rows())
    assert_is_mars(found)
    assert found.epoch.utc_iso == "1998-12-31T23:59:29"  # midnight of TAI
    np.testing.assert_allclose(np.diff(found.seconds), 43200.0, rtol=0, atol=1e-4)  # s, TDB - TAI
    assert found.meta["format"] == "CIC AEM 2.0" and found.method == "slerp"
    assert found.meta["object_name"] == "MARS" and found.meta["body_frame"] == "BODY"


DIALECTS = {
    "scalar last": ({"= FIRST": "= LAST"}, {"last": True}),
    "scalar first by default": ({"QUATERNION_TYPE = FIRST\n": ""}, {}),
    "body to axes": ({"= A2B": "= B2A"}, {"inverse": True}),
    "body first": (
        {"_A = ICRF": "_A = BODY", "_B = BODY": "_B = ICRF"},
        {"inverse": True},
    ),
    "version 1": ({"VERS = 2.0": "VERS = 1.0"}, {}),
    "returns": ({"\n": "\r\n"}, {}),
    "undefined": ({"= BODY": "= UNDEFINED"}, {}),
    "comments": ({"META_STOP\n": "COMMENT a\nMETA_STOP\nCOMMENT days, seconds, q0\n"}, {}),
    "start": ({"= TAI\n": "= TAI\nSTART_TIME = 1999-01-01T00:00:00.000000\n"}, {}),
    "stop": ({"= TAI\n": "= TAI\nSTOP_TIME = 51181 0\n"}, {}),
}


@pytest.mark.parametrize("name", DIALECTS)
def test_dialects_of_tools(tmp_path, name):
    changes, how = DIALECTS[name]
    text = HEAD
    for old, new in changes.items():
        assert old in text
        text = text.replace(old, new)
    found = read(tmp_path, text + rows(**how))
    assert len(found) == 5
    assert_is_mars(found)


def test_segments_and_tabs(tmp_path):
    first, second = rows().splitlines()[:2], rows().splitlines()[2:]
    meta = HEAD[HEAD.index("META_START") :]
    text = HEAD + "\n".join(line.replace(" ", "\t") for line in first)
    found = read(tmp_path, f"{text}\n\n{meta}" + "\n".join(second))
    assert len(found.segments) == 2 and len(found) == 5
    assert_is_mars(found)


def test_written_files_come_back(tmp_path):
    history = MOTION.at(np.arange(0.0, 40.0, 0.7))
    path = tmp_path / "a.cic"
    cic.write(path, history, frame="ICRF", object_name="SAT", originator="ME")
    found = cic.read(path)
    np.testing.assert_array_equal(found.wxyz, history.wxyz)
    assert np.max(np.abs(found.seconds - history.seconds)) < 1e-12  # s, twelve decimals
    lines = path.read_text().splitlines()
    assert lines[0] == "CIC_AEM_VERS = 1.0" and "QUATERNION_TYPE = FIRST" in lines
    assert not any(line.startswith(("START", "INTERPOL", "DATA", "STOP")) for line in lines)
    assert lines[-len(history)].split()[:2] == ["61041", "0.000000000000"]
    assert detect.of_file(path) == "cic" and detect.read(path).meta["object_name"] == "SAT"
    # VTS knows EME2000, 23 mas from ICRF.
    cic.write(path, history)
    assert "REF_FRAME_A = EME2000" in path.read_text()
    np.testing.assert_allclose(cic.read(path).wxyz, history.wxyz, rtol=0, atol=1e-15)
    # The same numbers as in an AEM of version 1.
    aem.write(tmp_path / "a.aem", history, version="1.0", kind="QUATERNION", frame="EME2000")
    row = (tmp_path / "a.aem").read_text().splitlines()[-2].split()
    assert path.read_text().split()[-4:] == [row[4], *row[1:4]]


@pytest.mark.parametrize("time_system", ["UTC", "TAI", "TDB"])
def test_a_leap_second(tmp_path, time_system):
    spin = Spin("2016-12-31T23:59:58", (1, 0, 0, 0), (0, 0, 0.1))
    motion = FreeRotation(Body(moments=(1, 2, 3)), spin)
    path = tmp_path / "a.cic"
    cic.write(path, motion, t=np.arange(5.0) + 0.5, time_system=time_system)
    days = [line.split()[:2] for line in path.read_text().splitlines()[-5:]]
    if time_system == "UTC":
        seconds = [float(second) for _, second in days]
        assert seconds == pytest.approx([86398.5, 86399.5, 86400.5, 0.5, 1.5], abs=1e-8)  # TDB
    found = cic.read(path)
    assert np.max(np.abs(found.seconds - np.arange(5.0))) < 2e-12
    assert abs(found.epoch.since(motion.epoch) - 0.5) < 2e-12


def test_midnight_rounded_up_is_that_of_the_next_day(tmp_path):
    found = read(tmp_path, HEAD + "51179 86399.0 1 0 0 0\n51179 86400.000000 1 0 0 0\n")
    assert found.seconds[1] == pytest.approx(1.0, abs=1e-9)


def test_a_motion_to_a_tolerance(tmp_path):
    made = cic.write(tmp_path / "a.cic", MOTION, start=0.0, stop=30.0, tolerance=1e-4)
    assert made.error <= 1e-4 and made.records > 50
    t = np.linspace(0.0, 30.0, 777)
    table = cic.read(tmp_path / "a.cic")
    inside = t[(t >= 0.0) & (t <= 30.0 - 1e-9)]
    turn = Rotation.from_quat(np.roll(table.at(inside).wxyz, -1, axis=1)).inv()
    apart = (turn * Rotation.from_quat(np.roll(MOTION.at(inside).wxyz, -1, axis=1))).magnitude()
    assert np.max(apart) < 1e-4


def test_a_jump_is_refused(tmp_path):
    arcs = Arcs(Body(moments=(10, 20, 26)), SPIN, [Impulse(2.2, (1, 0, 0))])
    with pytest.raises(AttitudeError, match="a CIC file holds one segment"):
        cic.write(tmp_path / "a.cic", arcs, t=np.arange(5.0))


def test_convert(tmp_path, capsys):
    aem.write(tmp_path / "a.aem", MOTION.at(np.arange(9.0)), object_name="SAT")
    given, made, back = (str(tmp_path / name) for name in ("a.aem", "b.cic", "c.ecsv"))
    assert main(["convert", given, made]) == 0
    assert main(["convert", made, back]) == 0
    np.testing.assert_allclose(detect.read(back).wxyz, aem.read(given).wxyz, rtol=0, atol=1e-15)
    assert cic.read(made).meta["object_name"] == "SAT"
    spin = str(tmp_path / "a.toml")
    detect.write_motion(spin, MOTION)
    assert main(["convert", spin, made, "--stop", "60 s", "--tolerance", "1e-5"]) == 0
    assert "records at most" in capsys.readouterr().out
    assert main(["convert", given, made, "--type", "SPIN"]) != 0
    assert "a CIC file" in capsys.readouterr().err


FAULTS = {
    "another version": (("= 2.0", "= 3.0"), "an AEM begins with CIC_AEM_VERS = 1.0 or 2.0"),
    "day": (("51179 0 ", "5117O 0 "), r"line 16: the epoch '5117O 0' cannot be read: write a mod"),
    "half a day": (("51179 0 ", "51179.5 0 "), "write a modified Julian date and seconds"),
    "seconds": (("51179 0 ", "51179 86401 "), "its seconds are not those of a day"),
    "negative": (("51179 0 ", "51179 -1 "), "its seconds are not those of a day"),
    "far": (("51179 0 ", "9999999 0 "), "its year is after 9999"),
    "nan": (("51179 0 ", "51179 nan "), "its seconds are not those of a day"),
    "no seconds": (("51179 0 ", "51179 "), "line 16: it has 5 entries; QUATERNION has an MJD and"),
    "dates": (("51179 0 ", "1999-01-01T00:00:00 "), "it has 5 entries"),
    "backwards": (("51180 0 ", "51178 0 "), "line 18: the epoch goes backwards"),
    "direction": (("ATTITUDE_DIR = A2B\n", ""), "the meta data lack ATTITUDE_DIR"),
    "order": (("= FIRST", "= MIDDLE"), "line 13: QUATERNION_TYPE is 'MIDDLE'"),
    "wrong order": (("OBJECT_NAME = MARS\n", ""), "without OBJECT_NAME"),
    "keyword": (("TIME_SYSTEM", "CLOCK"), "line 11: CLOCK is not known"),
}


@pytest.mark.parametrize("name", FAULTS)
def test_faults_are_named_with_their_line(tmp_path, name):
    (old, new), sentence = FAULTS[name]
    text = HEAD + rows()
    assert old in text
    with pytest.raises(AttitudeError, match=sentence):
        read(tmp_path, text.replace(old, new, 1))


def test_lenient(tmp_path):
    text = HEAD.replace("ATTITUDE_DIR = A2B\n", "GENERATOR = X\n").replace("OBJECT_ID = MARS\n", "")
    text = text.replace("QUATERNION_TYPE = FIRST\n", "")
    found = read(tmp_path, text + rows(), lenient=True)
    assert_is_mars(found)
    assert found.meta["assumed"] == (
        "GENERATOR is not known: left out",
        "OBJECT_ID is missing: UNKNOWN",
        "ATTITUDE_DIR is missing: A2B",
    )


def test_the_other_readers_say_where_to_go(tmp_path):
    path = tmp_path / "a.txt"
    path.write_text(HEAD + rows())
    with pytest.raises(AttitudeError, match=r"attitude\.formats\.cic reads the dialect"):
        aem.read(path)
    path.write_text(HEAD.replace("CIC_AEM", "CIC_OEM"))
    with pytest.raises(AttitudeError, match="is an OEM of CIC, of which only AEMs are read"):
        detect.read(path)
