"""Files that differ a little: lenient reading, qualified tags, an inertia alone, other messages."""

import re

import numpy as np
import pytest

from attitude import AttitudeError, Body, FreeRotation, Spin
from attitude.cli import main
from attitude.formats import acm, aem, apm, damit, detect, stk
from attitude.frames import quaternion

SPIN = Spin(epoch="2026-01-01T00:00:00", wxyz=(1, 2, 3, 4), angular_velocity=(0.01, 0.15, 0.01))
MOTION = FreeRotation(Body(moments=(10, 20, 26)), SPIN)
HISTORY = MOTION.at(np.arange(8.0))


def apart(p, q):
    d = quaternion.multiply(quaternion.conjugate(p), q)
    return np.max(2.0 * np.arctan2(np.linalg.norm(d[..., 1:], axis=-1), np.abs(d[..., 0])))


# An inertia alone --------------------------------------------------------------------------------


@pytest.mark.parametrize(("version", "xml"), [("1.0", False), ("2.0", False), ("2.0", True)])
def test_an_apm_with_an_inertia_alone_has_a_body(tmp_path, version, xml):
    path = tmp_path / "a.apm"
    apm.write(path, MOTION, version=version, xml=xml)
    text = path.read_text()
    if xml:
        text = re.sub(r"(?s)<(quaternionState|angularVelocity)>.*?</\1>", "", text)
    elif version == "1.0":
        text = re.sub(r"(?m)^Q.*\n", "", text)
    else:
        text = re.sub(r"(?s)(QUAT|ANGVEL)_START.*?_STOP", "", text)
    path.write_text(text)
    found = apm.read(path)
    assert np.array_equal(found.body.moments, MOTION.body.moments)
    assert found.wxyz is None and found.angular_velocity is None
    assert found.meta["inertia_frame"] == "SC_BODY_1"
    for name in ("spin", "motion"):
        with pytest.raises(AttitudeError, match="the message has no attitude; a Spin needs one"):
            getattr(found, name)
    with pytest.raises(AttitudeError, match="has no attitude"):
        detect.read(path)


# Qualified tags ----------------------------------------------------------------------------------


@pytest.mark.parametrize("write", [aem.write, apm.write, acm.write])
def test_qualified_tags(tmp_path, write):
    path = tmp_path / "a.xml"
    source = MOTION if write is apm.write else HISTORY
    write(path, source, xml=True)
    text = re.sub(r"<(/?)([a-zA-Z])", r"<\1n:\2", path.read_text())
    text = text.replace("xmlns:xsi", 'xmlns:n="urn:ccsds:schema:ndmxml" xmlns:xsi', 1)
    path.write_text(text.replace("<n:xml", "<?xml"))
    found = {aem.write: aem, apm.write: apm, acm.write: acm}[write].read(path)
    wxyz = found.table.wxyz if write is acm.write else found.wxyz
    assert np.array_equal(wxyz, SPIN.wxyz if write is apm.write else HISTORY.wxyz)
    assert apart(np.atleast_2d(getattr(detect.read(path), "wxyz", SPIN.wxyz))[0], SPIN.wxyz) < 1e-15


# Other messages ----------------------------------------------------------------------------------


@pytest.mark.parametrize("kind", ["OEM", "OMM", "OPM", "CDM", "TDM", "RDM", "OCM"])
@pytest.mark.parametrize("ending", ["txt", "spin", "aem", "xml"])
def test_other_messages_are_no_files_of_attitudes(tmp_path, kind, ending):
    """CCSDS_OEM_VERS = 2.0 has three words, as the first line of a DAMIT file."""
    path = tmp_path / f"a.{ending}"
    path.write_text(f"CCSDS_{kind}_VERS = 2.0\nCREATION_DATE = 2026-01-01T00:00:00\n")
    with pytest.raises(AttitudeError, match=f"is an {kind}, which holds no attitudes"):
        detect.of_file(path)
    path.write_text(f'<?xml version="1.0"?>\n<{kind.lower()} version="2.0"></{kind.lower()}>\n')
    with pytest.raises(AttitudeError, match=f"is an {kind}, which holds no attitudes"):
        detect.of_file(path)


def test_a_damit_file_is_one(tmp_path):
    spin = Spin(epoch="2026-01-01", wxyz=(1, 2, 3, 4), angular_velocity=(0, 0, 1e-3))
    damit.write(tmp_path / "a.spin", FreeRotation(Body(moments=(1, 2, 2.5)), spin))
    (tmp_path / "a.spin").rename(tmp_path / "a.txt")
    assert detect.of_file(tmp_path / "a.txt") == "damit"


# Sentences quote at most 40 characters ------------------------------------------------------------

LONG = "x" * 300


def test_sentences_are_short(tmp_path):
    files = {}
    for name, write, source in (
        ("a.aem", aem.write, HISTORY),
        ("a.apm", apm.write, MOTION),
        ("a.acm", acm.write, HISTORY),
        ("a.a", stk.write, HISTORY),
    ):
        write(tmp_path / name, source)
        files[name] = (tmp_path / name).read_text()
    seen = 0
    for name, text in files.items():
        lines = text.splitlines()
        for k, line in enumerate(lines[:40]):
            for changed in (f"{line.partition(' ')[0]} = {LONG}", LONG, f"{LONG} = 1", line + LONG):
                path = tmp_path / name
                path.write_text("\n".join([*lines[:k], changed, *lines[k + 1 :]]) + "\n")
                try:
                    detect.read(path)
                except AttitudeError as err:
                    seen += 1
                    assert "x" * 41 not in str(err), str(err)
    assert seen > 200


# Lenient -----------------------------------------------------------------------------------------


def test_what_is_left_out_is_assumed_and_listed(tmp_path, capsys):
    path = tmp_path / "a.aem"
    aem.write(path, HISTORY, version="1.0", kind="QUATERNION", object_id="2026-001A")
    text = path.read_text()
    gone = r"OBJECT_ID|START_TIME|STOP_TIME|ATTITUDE_DIR|QUATERNION_TYPE|DATA_START|DATA_STOP"
    text = re.sub(rf"(?m)^({gone}).*\n", "", text)
    path.write_text(text.replace("META_STOP", "SPACECRAFT_MODE = SAFE\nMETA_STOP"))
    with pytest.raises(AttitudeError, match="SPACECRAFT_MODE is not known"):
        aem.read(path)
    found = aem.read(path, lenient=True)
    assert np.array_equal(found.wxyz, HISTORY.wxyz)
    assert found.meta["object_id"] == "UNKNOWN"
    assumed = "\n".join(found.meta["assumed"])
    for what in (
        *("SPACECRAFT_MODE is not known: left out", "OBJECT_ID is missing: UNKNOWN"),
        *("ATTITUDE_DIR is missing: A2B", "QUATERNION_TYPE is missing: LAST"),
        *("START_TIME is missing: that of the records", "DATA_START is missing"),
        "DATA_STOP is missing",
    ):
        assert what in assumed
    assert len(found.meta["assumed"]) == 8
    assert main(["convert", str(path), str(tmp_path / "b.ecsv"), "--lenient"]) == 0
    assert "assumed: OBJECT_ID is missing: UNKNOWN" in capsys.readouterr().out
    # Of a complete file nothing is assumed.
    aem.write(path, HISTORY)
    assert aem.read(path, lenient=True).meta["assumed"] == ()


def test_an_underscore_is_a_blank_in_a_time_system(tmp_path):
    aem.write(tmp_path / "a.aem", HISTORY, time_system="GPS")
    text = (tmp_path / "a.aem").read_text().replace("= GPS\n", "= GPS_TIME\n")
    (tmp_path / "b.aem").write_text(text)
    assert aem.read(tmp_path / "b.aem").epoch == aem.read(tmp_path / "a.aem").epoch


def test_comments_before_and_between_records_without_data_start(tmp_path):
    path = tmp_path / "a.aem"
    aem.write(path, HISTORY, version="1.0", kind="QUATERNION")
    text = re.sub(r"(?m)^(DATA_START|DATA_STOP)\n", "", path.read_text())
    text = text.replace("META_STOP\n", "META_STOP\nCOMMENT epoch, q1, q2, q3, qc\n\nCOMMENT b\n")
    path.write_text(text + "COMMENT the end\n")
    found = aem.read(path, lenient=True)
    assert np.array_equal(found.wxyz, HISTORY.wxyz)
    assert found.meta["data_comments"] == ("epoch, q1, q2, q3, qc", "b", "the end")
    with pytest.raises(AttitudeError, match="stands where DATA_START must be"):
        aem.read(path)
    # The next segment ends the data, too.
    meta = text[text.index("META_START") : text.index("META_STOP") + 10]
    row = text.rindex("\n20")
    path.write_text(text[: row + 1] + meta + text[row + 1 :])
    found = aem.read(path, lenient=True)
    assert len(found.segments) == 2 and np.array_equal(found.wxyz, HISTORY.wxyz)


MMS = """\
CCSDS_AEM_VERS = 1.0
COMMENT made by hand, with the columns of a file of definitive attitude of MMS
CREATION_DATE = 2026-001T00:00:00
ORIGINATOR = GSFC FDOA
META_START
OBJECT_NAME = MMS1
CENTER_NAME = EARTH
REF_FRAME_A = J2000
REF_FRAME_B = SC_BODY_1
ATTITUDE_DIR = A2B
TIME_SYSTEM = UTC
START_TIME = 2026-001T00:00:00
STOP_TIME = 2026-001T00:00:20
ATTITUDE_TYPE = QUATERNION/RATE/SPIN/NUTATION
QUATERNION_TYPE = LAST
META_STOP
DATA_START
COMMENT   Time (UTC)    Elapsed    q1 q2 q3 qc  wX wY wZ  wPhase zRA zDec zPhase ...
"""


def test_the_columns_of_mms(tmp_path):
    rows = []
    for k in range(3):
        half = np.radians(9.0 * k)  # 1.8 deg/s about z, 10 s apart
        numbers = [0, 0, np.sin(half), np.cos(half), 0, 0, 1.8, *range(11)]
        words = " ".join(f"{float(x):.12f}" for x in numbers)
        rows.append(f"2026-001T00:00:{10 * k:02d}.000 {1234567.0 + 10 * k} {words} CF")
    path = tmp_path / "MMS1_DEFATT.V00"
    path.write_text(MMS + "\n".join(rows) + "\nDATA_STOP\n")
    with pytest.raises(AttitudeError, match=r"it has 21 entries|lacks|without OBJECT_ID"):
        aem.read(path)
    found = aem.read(path, lenient=True)
    assert len(found) == 3 and len(found.meta["data_comments"]) == 1
    assert found.angular_velocity[:, 2] == pytest.approx(np.radians(1.8), abs=1e-7)
    assert any("21 columns are those of MMS" in text for text in found.meta["assumed"])
    # The rates are those of the quaternions.
    turn = quaternion.multiply(quaternion.conjugate(found.wxyz[0]), found.wxyz[1])
    assert turn[3] == pytest.approx(np.sin(np.radians(9.0)), abs=1e-10)
