"""AEM: written and read without loss, meaning what other implementations say it means."""

import os
import re

import numpy as np
import pytest

from attitude import AttitudeError, Body, FreeRotation, Spin, epochs
from attitude.formats import _records, aem, detect
from attitude.frames import quaternion
from attitude.frames import representations as forms
from attitude.motions._table import AttitudeTable
from tests.support import earth_orientation
from tests.support.places import TEST_DATA as DATA

SPIN = Spin(epoch="2016-12-31T23:59:50", wxyz=(1, 2, 3, 4), angular_velocity=(0.01, 0.15, 0.01))
MOTION = FreeRotation(Body(moments=(10, 20, 26)), SPIN)
# Across a leap second, at steps that are no decimals.
HISTORY = MOTION.at(np.arange(60) / 3.0)
CHOICES = [
    (version, kind, xml)
    for version in ("1.0", "2.0")
    for kind in _records.COLUMNS
    for xml in (False, True)
    if version == "2.0" or kind in _records.IN_VERSION_1
]


def read(path, **how):
    """The rates of version 1 are body rates here; see `test_formats_old_rates`."""
    return aem.read(path, **{"rates": "body"} | how)


def apart(p, q):
    d = quaternion.multiply(quaternion.conjugate(p), q)
    return np.max(2.0 * np.arctan2(np.linalg.norm(d[..., 1:], axis=-1), np.abs(d[..., 0])))


def written(tmp_path, source=HISTORY, **how):
    path = tmp_path / "attitude.aem"
    if how.get("version") == "1.0" and how.get("kind", "").endswith("/ANGVEL"):
        how = {"rates": "body"} | how
    aem.write(path, source, **how)
    return path


def late(table, history):
    """By how many seconds the epochs read differ from those written."""
    hi, lo = epochs.seconds_since(history.epoch, table.epoch)
    return np.max(np.abs((table.seconds - history.seconds + hi) + (table.low + lo)))


@pytest.mark.parametrize(("version", "kind", "xml"), CHOICES)
@pytest.mark.parametrize("frame", ["ICRF", "EME2000", "ITRF", "TEME", "eclipticj2000"])
def test_there_and_back(tmp_path, version, kind, xml, frame):
    turning = frame in ("ITRF", "TEME")
    if turning and "NUTATION" in kind:
        with pytest.raises(AttitudeError, match="do not turn"):
            written(tmp_path, version=version, kind=kind, xml=xml, frame=frame)
        return
    for over in ("body", "frame"):
        how = {"rates_over": over, "sequence": "ZYX", "scalar_first": over == "body"}
        path = written(tmp_path, version=version, kind=kind, xml=xml, frame=frame, **how)
        found = read(path)
        assert late(found, HISTORY) < 1e-12
        if kind.startswith("QUATERNION") and frame == "ICRF":
            assert np.array_equal(found.wxyz, HISTORY.wxyz)
        # degrees, other axes: some units in the last place; Earth-fixed ones turn 1e-14 rad in
        # the 1e-10 s to which ERFA's Julian dates of UT1 are good
        assert apart(found.wxyz, HISTORY.wxyz) < (3e-14 if turning else 3e-15)
        if _records.has_rates(kind) and kind != "SPIN":
            off = np.abs(found.angular_velocity - HISTORY.angular_velocity)
            assert np.max(off) < 1e-14  # rad/s: angle rates and cones amplify rounding
        else:
            assert found.angular_velocity is None


def test_the_leap_second_is_written_and_read(tmp_path):
    path = written(tmp_path, time_system="UTC")
    assert "2016-12-31T23:59:60.333333" in path.read_text()
    for system in ("TAI", "TT", "TDB", "GPS"):
        assert late(read(written(tmp_path, time_system=system)), HISTORY) < 1e-12


def test_what_the_quaternions_mean():
    """Both directions, both orders, rates over the frame, day of year, several segments."""
    table = read(DATA / "two-segments.aem")
    first, second = table.segments
    z = (0.0, 0.0, 1.0)
    # A is the body: the file's rotation, body to ICRF, is the inverse of what it lists.
    assert np.allclose(first.wxyz[1], forms.from_axis_angle(z, np.pi / 2), atol=1e-15)
    assert np.allclose(first.angular_velocity, np.radians([0, 0, 1.0]), atol=1e-17)
    assert np.allclose(second.wxyz[0], forms.from_axis_angle(z, np.pi / 2), atol=1e-7)
    assert table.epoch.utc_iso == "2026-01-04T00:00:00"
    assert apart(table.at(45.0).wxyz, forms.from_axis_angle(z, np.pi / 4)) < 1e-8
    assert first.method == "slerp"
    assert second.meta["data_comments"] == ("holds still",)
    assert table.meta["comments"][0].startswith("Made by hand")
    assert first.meta["meta_comments"] == ("a quarter turn about z in 90 s",)
    assert abs(np.linalg.norm(second.wxyz[0]) - 1.0) < 3e-16


@pytest.mark.parametrize("kind", ["SPIN/NUTATION", "SPIN/NUTATION_MOM"])
def test_nutation_is_a_regular_precession(tmp_path, kind):
    """Columns by elementary geometry; rates against differences of the attitudes."""
    from scipy.spatial.transform import Rotation

    alpha, delta, nutation = np.radians([40.0, 25.0, 12.0])
    precession, spin, h = np.radians(3.0), np.radians(-20.0), 1e-4
    lines = []
    for second in (0.0, h, 2 * h):
        turn = Rotation.from_euler(
            "ZYZ", [alpha, 0.5 * np.pi - delta, precession * second]
        ) * Rotation.from_euler("XZ", [nutation, 0.3 + spin * second])
        a, b, c = turn.as_euler("ZXZ")
        columns = [a - 0.5 * np.pi, 0.5 * np.pi - b, c, spin]
        if kind == "SPIN/NUTATION":
            x, y, _ = turn.inv().apply(
                [np.cos(delta) * np.cos(alpha), np.cos(delta) * np.sin(alpha), np.sin(delta)]
            )
            columns += [nutation, np.radians(2.0 * np.pi / precession), np.arctan2(-y, x)]
        else:
            columns += [alpha, delta, precession]
        row = " ".join(repr(float(np.degrees(column))) for column in columns)
        lines.append(f"2026-01-01T00:00:{second:07.4f} {row}")
    text = re.sub(
        r"(?s)DATA_START.*",
        "DATA_START\n" + "\n".join(lines) + "\nDATA_STOP\n",
        (DATA / "ccsds" / "aem-g5.txt").read_text(),
    )
    text = re.sub(r"2006-090T05:00:00\.(071|946)", "2026-001T00:00:00", text)
    text = text.replace("= SPIN", f"= {kind}").replace("= J2000", "= ICRF")
    path = tmp_path / "x.aem"
    path.write_text(text)
    table = read(path)
    step = quaternion.multiply(quaternion.conjugate(table.wxyz[0]), table.wxyz[2])
    measured = forms.to_rotation_vector(step) / (2 * h)
    # central difference of angles with 1e-15 rad over 2e-4 s: 1e-11 rad/s
    assert np.max(np.abs(table.angular_velocity[1] - measured)) < 1e-10


def test_rates_of_a_frame_b_that_is_not_the_body_are_negative(tmp_path):
    path = written(tmp_path, version="2.0", kind="QUATERNION/ANGVEL")
    text = path.read_text()
    swapped = text.replace("REF_FRAME_A = ICRF", "REF_FRAME_A = SC_BODY_1").replace(
        "REF_FRAME_B = SC_BODY_1", "REF_FRAME_B = ICRF"
    )
    path.write_text(swapped)
    found = read(path)
    assert apart(found.wxyz, quaternion.conjugate(HISTORY.wxyz)) < 1e-15
    assert np.max(np.abs(found.angular_velocity + HISTORY.angular_velocity)) < 1e-15


@pytest.mark.parametrize("version", ["1.0", "2.0"])
@pytest.mark.parametrize("body_is_a", [True, False])
def test_the_frame_of_rates_by_keyword_or_by_name(tmp_path, version, body_is_a):
    """The body turned by 90 degrees about z: its x is the frame's y, its y the frame's -x."""
    a, b = ("SC_BODY_1", "EME2000") if body_is_a else ("EME2000", "SC_BODY_1")
    half = (-1.0 if body_is_a else 1.0) * np.sqrt(0.5)
    old = version == "1.0"
    meta = [
        "OBJECT_NAME = SAT",
        "OBJECT_ID = 2026-001A",
        f"REF_FRAME_A = {a}",
        f"REF_FRAME_B = {b}",
        *("TIME_SYSTEM = UTC", "START_TIME = 2026-01-01T00:00:00"),
        *(
            "STOP_TIME = 2026-01-01T00:00:01",
            f"ATTITUDE_TYPE = QUATERNION/{'RATE' if old else 'ANGVEL'}",
        ),
        *(("ATTITUDE_DIR = A2B", "QUATERNION_TYPE = LAST") if old else ()),
    ]
    rows = [f"2026-01-01T00:00:0{k} 0 0 {half} {np.sqrt(0.5)} 1 2 3" for k in (0, 1)]
    # version 2: rates are those of B relative to A
    sign = -1.0 if body_is_a and not old else 1.0
    frame, body = ("B", "A") if body_is_a else ("A", "B")
    for over, names in [
        ((1.0, 2.0, 3.0), (f"REF_FRAME_{body}", "SC_BODY_1", "sc_body_1")),
        ((2.0, -1.0, 3.0), (f"REF_FRAME_{frame}", "EME2000", "eme2000")),
    ]:
        for name in names:
            path = tmp_path / "named.aem"
            keyword = "RATE_FRAME" if old else "ANGVEL_FRAME"
            head = [f"CCSDS_AEM_VERS = {version}", "META_START", *meta, f"{keyword} = {name}"]
            lines = [*head, "META_STOP", "DATA_START", *rows, "DATA_STOP", ""]
            path.write_text("\n".join(lines))
            found = read(path).angular_velocity
            assert np.allclose(found, sign * np.radians(over), rtol=0, atol=1e-16), name  # rad/s


def test_relative_to_an_orbit(tmp_path):
    from attitude.paths._path import Path as Orbit

    class Circle(Orbit):
        name, center, source = "circle", "earth", "made for this test"

        def _state(self, instant, hi, lo):
            angle = 1e-3 * (hi + lo + (instant.seconds - SPIN.epoch.seconds))
            zero = 0.0 * angle
            x, y = np.cos(angle), np.sin(angle)
            return 7e6 * np.stack([x, y, zero]), 7e3 * np.stack([-y, x, zero])

    for frame in ("RTN", "LVLH", "LVLH_INERTIAL", "RSW_ROTATING"):
        path = written(tmp_path, frame=frame, orbit=Circle())
        found = read(path, orbit=Circle())
        assert apart(found.wxyz, HISTORY.wxyz) < 1e-13  # epochs of 1e-12 s do not matter
        assert np.max(np.abs(found.angular_velocity - HISTORY.angular_velocity)) < 1e-14
        with pytest.raises(AttitudeError, match="orbit="):
            read(path)
    # radial is x of RTN and -z of LVLH; the momentum z of RTN and -y of LVLH
    from attitude.motions import _axes

    epoch, zero = SPIN.epoch, np.zeros(1)
    rtn = _axes.named("RTN").to_icrf(epoch, zero, zero, Circle())
    lvlh = _axes.named("LVLH").to_icrf(epoch, zero, zero, Circle())
    assert np.allclose(quaternion.rotate(rtn, np.eye(3)), np.eye(3), atol=1e-12)
    assert np.allclose(quaternion.rotate(lvlh, (0, 0, 1)), (-1, 0, 0), atol=1e-12)
    assert np.allclose(quaternion.rotate(lvlh, (0, -1, 0)), (0, 0, 1), atol=1e-12)


def test_itrf_is_that_of_astropy():
    from astropy import units
    from astropy.coordinates import GCRS, ITRS, TEME, CartesianRepresentation
    from astropy.time import Time

    from attitude.motions import _axes

    time = Time("2020-06-01T12:34:56")
    vector = np.array([0.3, -0.5, 0.8])
    position = CartesianRepresentation(vector * 1e7 * units.m)
    # The same table for both: within 1e-9 rad.
    for name, frame in (("ITRF-97", ITRS), ("TEME", TEME)):
        axis = _axes.named(name).to_icrf(epochs.instant(time), np.zeros(1), None)[0]
        with earth_orientation.installed():
            theirs = frame(position, obstime=time).transform_to(GCRS(obstime=time))
        theirs = theirs.cartesian.xyz.to_value("m") / 1e7
        assert np.max(np.abs(quaternion.rotate(axis, vector) - theirs)) < 1e-9


def test_several_segments_and_meta_data_are_kept(tmp_path):
    parts = [HISTORY[:30], HISTORY[40:]]
    path = written(tmp_path, parts, object_name="SAT", comments=["one", "two"], center="EARTH")
    found = read(path)
    assert len(found.segments) == 2 and len(found) == 50
    assert found.meta["comments"] == ("one", "two")
    again = read(written(tmp_path, found, version="1.0"))
    assert np.array_equal(again.wxyz, found.wxyz)
    assert again.meta["object_name"] == "SAT" and again.meta["center"] == "EARTH"
    assert again.meta["comments"] == ("one", "two")
    with pytest.raises(AttitudeError, match="no attitude"):
        again.at(10.8)
    usable = AttitudeTable.from_history(HISTORY)
    used = AttitudeTable(
        HISTORY.epoch,
        HISTORY.seconds,
        HISTORY.wxyz,
        usable=(HISTORY.epoch.after(1.0), HISTORY.epoch.after(15.0)),
    )
    # Epochs of the segments of a table are chosen like those of a motion.
    assert len(read(written(tmp_path, AttitudeTable.joined([found, used]), t=[1.0, 2.0]))) == 2
    back = read(written(tmp_path, used))
    assert abs(back.span[0].seconds - used.span[0].seconds) < 1e-9
    assert read(written(tmp_path, usable)).span[1].seconds > used.span[1].seconds


def test_a_motion_is_written_piece_by_piece(tmp_path, monkeypatch):
    from attitude.formats import _sampling

    monkeypatch.setattr(_sampling, "PIECE", 7)
    one = written(tmp_path, MOTION, t=np.arange(60) / 3.0, creation_date="x").read_text()
    monkeypatch.setattr(_sampling, "PIECE", 1000)
    assert one == written(tmp_path, creation_date="x").read_text()


@pytest.mark.parametrize("xml", [False, True])
@pytest.mark.parametrize("kind", _records.COLUMNS)
def test_brahe_reads_version_2(tmp_path, kind, xml):
    ccsds = pytest.importorskip("brahe.ccsds", reason="brahe is not installed")
    path = written(tmp_path, kind=kind, xml=xml, object_name="SAT", object_id="2026-001A")
    if kind == "EULER_ANGLE/ANGVEL" and xml:
        # brahe 1.8 wants a group <angVel> that the schema does not have.
        with pytest.raises(Exception, match=r"(?i)angvel"):
            ccsds.AEM.from_file(str(path))
        return
    state = ccsds.AEM.from_file(str(path)).segments[0].states[9]
    wxyz, rates = HISTORY.wxyz[9], HISTORY.angular_velocity[9]
    if kind.startswith("QUATERNION"):
        theirs = np.array(state.quaternion.to_vector(True))
        assert apart(theirs, wxyz) < 1e-14
    if kind.endswith("/ANGVEL"):
        theirs = np.array(state.angular_velocity)
        assert np.allclose(theirs, np.degrees(rates), rtol=1e-13) or np.allclose(
            theirs, rates, rtol=1e-13
        )
    if kind.startswith("SPIN"):
        pole = np.degrees(np.stack(forms.to_pole(wxyz)))
        theirs = np.array([state.spin_alpha, state.spin_delta, state.spin_angle])
        assert np.allclose(theirs, pole, rtol=1e-13) or np.allclose(
            np.degrees(theirs), pole, rtol=1e-13
        )


@pytest.mark.parametrize("xml", [False, True])
@pytest.mark.parametrize("kind", _records.COLUMNS)
def test_ccsds_ndm_reads_version_2_and_we_read_what_it_writes(tmp_path, kind, xml):
    ndm = pytest.importorskip("ccsds_ndm", reason="ccsds-ndm-py is not installed")
    path = written(tmp_path, kind=kind, xml=xml, object_name="SAT", object_id="2026-001A")
    message = ndm.Aem.from_file(str(path))
    message.validate()
    data = message.segments[0].data
    theirs = np.asarray(data.attitude_states_numpy)[9]
    if kind.startswith("QUATERNION"):
        assert np.array_equal(theirs[:4], np.roll(HISTORY.wxyz[9], -1))
    if kind.startswith("EULER"):
        assert apart(quaternion.from_euler("ZXZ", np.radians(theirs[:3])), HISTORY.wxyz[9]) < 3e-15
    if kind.endswith("ANGVEL"):
        assert np.allclose(theirs[-3:], np.degrees(HISTORY.angular_velocity[9]), rtol=1e-14)
    for form in ("kvn", "xml"):
        back = tmp_path / "back"
        message.to_file(str(back), form)
        found = read(back)
        assert apart(found.wxyz, HISTORY.wxyz) < 2e-14  # they print 15 or 16 digits
        assert late(found, HISTORY) < 1e-9


@pytest.mark.parametrize("kind", ["QUATERNION", "EULER_ANGLE", "SPIN"])
@pytest.mark.parametrize("scalar_first", [False, True])
def test_orbit_formats_reads_version_1(tmp_path, kind, scalar_first):
    theirs = pytest.importorskip("orbit_formats", reason="orbit-formats is not installed")
    path = written(tmp_path, version="1.0", kind=kind, scalar_first=scalar_first, time_system="TAI")
    read = theirs.read(str(path))
    if kind == "QUATERNION":
        assert np.array_equal(read.records, np.roll(HISTORY.wxyz, -1, axis=1))
    elif kind == "EULER_ANGLE":
        mine = quaternion.from_euler("ZXZ", np.radians(read.records))
        assert apart(mine, HISTORY.wxyz) < 3e-15
    else:
        assert np.allclose(np.radians(read.records[:, :3].T), forms.to_pole(HISTORY.wxyz))
    again = tmp_path / "again.aem"
    theirs.write(read, str(again), format="ccsds-aem")
    assert apart(aem.read(again).wxyz, HISTORY.wxyz) < 1e-8


BAD = [
    (r"CCSDS_AEM_VERS = 1\.0", "CCSDS_AEM_VERS = 3.0", "line 1: it begins with"),
    (
        r"ORIGINATOR = TESTS\n",
        "ORIGINATOR = TESTS\nORIGIN = X\n",
        "line 5: ORIGIN is not known in the header",
    ),
    (r"ORIGINATOR = TESTS\n", "ORIGINATOR TESTS\n", 'line 4: .* is no "KEYWORD = value"'),
    (r"OBJECT_NAME = SPINNER\n", "", "line 21: the meta data end without OBJECT_NAME"),
    (r"OBJECT_NAME", "OBJECT_NOME", "line 8: OBJECT_NOME is not known"),
    (r"RATE_FRAME = REF", "ANGVEL_FRAME = REF", r"belongs to version 2\.0"),
    (
        r"CENTER_NAME = EARTH",
        "OBJECT_NAME = A",
        "line 10: OBJECT_NAME is given twice, first in line 8",
    ),
    (r"REF_FRAME_B = ICRF", "REF_FRAME_B = SOMETHING", "none is known"),
    (r"REF_FRAME_A = SC_BODY_1", "REF_FRAME_A = EME2000", "both of them known external axes"),
    (r"ATTITUDE_DIR = A2B", "ATTITUDE_DIR = C2D", "line 13: ATTITUDE_DIR is 'C2D'"),
    (r"ATTITUDE_DIR = A2B\n", "", "lack ATTITUDE_DIR"),
    (r"TIME_SYSTEM = TAI", "TIME_SYSTEM = SCLK", "line 14: TIME_SYSTEM is 'SCLK'"),
    (r"START_TIME = 2026-01-04", "START_TIME = 2026-13-04", "line 15: START_TIME is"),
    (r"QUATERNION/RATE", "QUATERNION/SPEED", "line 17: ATTITUDE_TYPE is 'QUATERNION/SPEED'"),
    (r"QUATERNION_TYPE = FIRST", "QUATERNION_TYPE = MIDDLE", "line 18: QUATERNION_TYPE"),
    (r"QUATERNION_TYPE = FIRST\n", "", "lack QUATERNION_TYPE"),
    (r"RATE_FRAME = REF_FRAME_B", "RATE_FRAME = MARS", "line 19: RATE_FRAME is 'MARS'"),
    (r"INTERPOLATION_DEGREE = 1", "INTERPOLATION_DEGREE = x", "line 21: INTERPOLATION_DEGREE"),
    (r"METHOD = LINEAR", "METHOD = SPLINES", "line 20: INTERPOLATION_METHOD is 'SPLINES'"),
    (r"META_STOP\nDATA_START", "META_STOP\nDATA_BEGIN", "line 23: 'DATA_BEGIN' stands where"),
    (r"37 1\.0 0 0 0 0 0 1\.0", "37 1.0 0 0 0 0 0", "line 24: it has 7 entries"),
    (r"37 1\.0 0 0 0", "37 1.0 0 0 zero", "line 24: Q3 is 'zero', which is no number"),
    (r"37 1\.0 0 0 0", "37 1.0 0 0 0_0", "line 24: Q3 is '0_0', which is no number"),
    (r"37 1\.0 0 0 0", "37 1.0 0 0 nan", "line 24: it holds a number that is not finite"),
    (r"37 1\.0 0 0 0", "37 1.01 0 0 0", r"line 24: the length of the quaternion is off 1 by 0\.01"),
    (r"37 1\.0 0 0 0", "37 0.0 0 0 0", "line 24: the length of the quaternion is off 1 by 1"),
    (r"004T00:00:37", "004T00:00:37x", "line 24: the epoch '2026-004T00:00:37x' cannot be read"),
    (r"004T00:00:37", "004T24:00:37", "line 24: the epoch"),
    (r"004T00:00:37", "366T00:00:37", "line 24: the epoch"),
    (r"004T00:00:37", "004T23:59:60", "line 24: .*no leap second"),
    (r"004T00:02:07", "004T00:00:07", "line 25: the epoch goes backwards"),
    (r"004T00:02:07", "004T00:00:37.0", "line 25: the epoch is that of the record before"),
    (r"DATA_STOP\n\nMETA", "META", "line 26: META_START stands before DATA_STOP"),
    (r"DATA_STOP\n$", "", "line 43: the file ends before DATA_STOP; is it cut off"),
    (r"META_STOP\nDATA_START\nCOMMENT(.|\n)*", "", "ends before META_STOP"),
    (r"META_START(.|\n)*", "", "ends before META_START"),
    (r"2026-004T00(.|\n)*?DATA_STOP", "DATA_STOP", "the segment has no attitudes"),
    (r"DATA_STOP\n$", "DATA_STOP\nrubbish\n", "line 45: 'rubbish' stands where"),
    (r"SPINNER", "SPIN\x00NER", "zero bytes"),
    (r"COMMENT a quarter", "COMMENT " + "x" * 30000, "line 7: the line is longer than"),
]


@pytest.mark.parametrize(("pattern", "instead", "sentence"), BAD)
def test_what_is_wrong_is_told_with_file_line_and_keyword(tmp_path, pattern, instead, sentence):
    path = tmp_path / "bad.aem"
    text = (DATA / "two-segments.aem").read_text()
    changed = re.sub(pattern, lambda _: instead, text, count=1)
    assert changed != text
    path.write_text(changed)
    with pytest.raises(AttitudeError, match=sentence) as found:
        read(path)
    assert str(path) in str(found.value)


def test_binary_empty_and_missing_files(tmp_path):
    path = tmp_path / "junk"
    for junk in (b"", b"\n\n", bytes(range(256)) * 100, b"\x00" * 5000, b"\xff" * 100_000, b"<"):
        path.write_bytes(junk)
        with pytest.raises(AttitudeError, match="junk"):
            read(path)
    with pytest.raises(AttitudeError, match="cannot be read"):
        read(tmp_path / "nothing")
    with pytest.raises(AttitudeError, match="cannot be read"):
        read(tmp_path)


def test_unknown_axes_can_be_named_and_loose_quaternions_accepted(tmp_path):
    path = tmp_path / "x.aem"
    text = (DATA / "two-segments.aem").read_text()
    path.write_text(text.replace("= ICRF", "= MYFRAME").replace("37 1.0 0", "37 1.01 0"))
    found = read(path, frame="ecliptic", tolerance=0.1)
    assert found.meta["body_frame"] == "MYFRAME" or found.meta["body_frame"] == "SC_BODY_1"


@pytest.mark.parametrize(
    ("inside", "sentence"),
    [
        ('<!DOCTYPE aem [<!ENTITY a "b">]>', "document type"),
        ('<!DOCTYPE aem SYSTEM "http://example.org/x.dtd">', "document type"),
        ('<!DOCTYPE aem [<!ENTITY x SYSTEM "file:///etc/passwd">]>', "document type"),
    ],
)
def test_xml_with_entities_is_refused(tmp_path, inside, sentence):
    path = written(tmp_path, xml=True)
    text = path.read_text()
    path.write_text(text.replace("<aem", inside + "<aem", 1))
    with pytest.raises(AttitudeError, match=sentence):
        read(path)
    path.write_text(text.replace("UNKNOWN", "&undefined;", 1))
    with pytest.raises(AttitudeError, match=r"line \d+: it is not well-formed XML"):
        read(path)


XML_BAD = [
    ('version="2.0"', 'version="9"', "outermost element"),
    ("<aem ", "<oem ", "outermost element"),
    ("<ORIGINATOR>", "<ORIGIN></ORIGIN><ORIGINATOR>", "ORIGIN is not known in the header"),
    ("<REF_FRAME_A>ICRF", "<REF_FRAME_A>XYZ", "none is known"),
    ("<QC>", "<QD>", "well-formed"),
    ("<Q1>", "<Q1>a", "Q1 is 'a"),
    ("<Q1>", "<Q1>9", "off 1 by"),
    ("</quaternion>", "<Q1>1</Q1></quaternion>", "Q1 does not belong .* or not twice"),
    ("</quaternion>", "<Q9>1</Q9></quaternion>", "Q9 does not belong"),
    ("<EPOCH>2016", "<EPOCH>x", "the epoch 'x"),
    ('units="deg/s"', 'units="rad/s"', "ANGVEL_X is in 'rad/s'; it must be in deg/s"),
    ("<metadata>", "<metadata><NOVEL>1</NOVEL>", "NOVEL is not known"),
    ("<attitudeState>", "<other/><attitudeState>", "other is not known in the block DATA"),
    ("</aem>", "", "not well-formed XML"),
    ("<data>", "<data>" + "<a>" * 50, "nested deeper"),
    ("<data>", "<data><COMMENT>" + "y" * 30000 + "</COMMENT>", "longer than"),
    ('encoding="UTF-8"', 'encoding="klingon"', "encoding"),
]


@pytest.mark.parametrize(("old", "new", "sentence"), XML_BAD)
def test_what_is_wrong_in_xml_is_told(tmp_path, old, new, sentence):
    path = written(tmp_path, xml=True)
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new, 1))
    with pytest.raises(AttitudeError, match=sentence):
        read(path)


@pytest.mark.parametrize(
    ("how", "sentence"),
    [
        ({"version": "3.0"}, "version is '3.0'"),
        ({"version": "1.0", "kind": "SPIN/NUTATION_MOM"}, r"no attitude type of AEM 1\.0"),
        ({"kind": "QUATERNIONS"}, "ATTITUDE_TYPE is 'QUATERNIONS'"),
        ({"frame": "MOON"}, "frame is 'MOON'"),
        ({"time_system": "UT1"}, "not written in UT1"),
        ({"time_system": "LOCAL"}, "cannot be converted"),
        ({"rates_over": "moon"}, "one of 'body', 'frame'"),
        ({"object_name": "a\nb"}, "one line of text"),
        ({"body_frame": "ICRF"}, "the name of other axes"),
        ({"sequence": "XXY"}, "sequence"),
        ({"method": "spline"}, "interpolation method is 'spline'"),
        ({"degree": 77}, "interpolation degree is 77"),
    ],
)
def test_what_cannot_be_written(tmp_path, how, sentence):
    with pytest.raises(AttitudeError, match=sentence):
        written(tmp_path, **how)
    assert not list(tmp_path.iterdir())


def test_what_is_no_history(tmp_path):
    path = tmp_path / "x"
    for source, t, sentence in [
        (5, None, "int is given to be written"),
        (MOTION, None, "FreeRotation is given"),
        (HISTORY[0], None, "shape"),
        (MOTION.at([]), None, "no epochs"),
        (MOTION.at([0.0, np.nan]), None, "NaN"),
        (MOTION.at([1.0, 0.0]), None, "not later"),
        (5, [1.0], "source is int; give a FreeRotation"),
    ]:
        with pytest.raises(AttitudeError, match=re.escape(sentence)):
            aem.write(path, source, t=t)
    assert not path.exists()


def test_a_full_disk_leaves_nothing_and_the_old_file_as_it_was(tmp_path, monkeypatch):
    path = written(tmp_path)
    before = path.read_text()

    def full(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "replace", full)
    with pytest.raises(AttitudeError, match="No space left"):
        aem.write(path, HISTORY[:5])
    assert path.read_text() == before
    assert list(tmp_path.iterdir()) == [path]


def test_rates_that_no_body_has_are_refused(tmp_path):
    path = written(tmp_path, kind="SPIN/NUTATION")
    text = path.read_text().splitlines()
    k = text.index("DATA_START") + 1
    words = text[k].split()
    for place in (4, 5, 6):
        changed = [*words[:place], "1e308" if place != 6 else "1e-308", *words[place + 1 :]]
        path.write_text("\n".join([*text[:k], " ".join(changed), *text[k + 1 :]]))
        try:
            read(path).at(HISTORY.time[1])
        except AttitudeError as err:
            assert re.search("give finite angular velocities|must be finite", str(err))


# Records in XML that are written alike go by a pattern: it must mean what the parser means --------


def slowly(path, monkeypatch):
    """The same file, every record of it by the parser."""
    from attitude._textfiles import messages

    with monkeypatch.context() as patched:
        patched.setattr(messages, "_MOST_PATTERNS", 0)
        return read(path)


def same(p, q):
    rates = p.angular_velocity is None or np.array_equal(p.angular_velocity, q.angular_velocity)
    # TDB - TT of one epoch and of an array differ by 5e-15 s
    late = np.max(np.abs((p.seconds - q.seconds) + (p.low - q.low)))
    return rates and np.array_equal(p.wxyz, q.wxyz) and late < 2e-14


@pytest.mark.parametrize(("version", "kind"), [c[:2] for c in CHOICES if c[2]])
def test_alike_or_one_by_one_xml_means_the_same(tmp_path, monkeypatch, version, kind):
    for first in (False, True):
        path = written(tmp_path, version=version, kind=kind, xml=True, scalar_first=first)
        assert same(read(path), slowly(path, monkeypatch))


# What may stand between and inside of records without changing what they mean, or changing it.
BETWEEN = [
    "<COMMENT>one more</COMMENT>",
    "<!-- <attitudeState>not read</attitudeState> -->",
    "<?target <attitudeState/> ?>",
    "\n\n\t \n",
    "<!--</attitudeState>-->",
]


@pytest.mark.parametrize("piece", [37, 500, 1 << 20])
def test_what_is_between_records_is_parsed(tmp_path, monkeypatch, piece):
    from attitude._textfiles import xml as xml_events

    monkeypatch.setattr(xml_events, "_PIECE", piece)
    path = written(tmp_path, xml=True)
    plain = read(path)
    parts = path.read_text().split("        <attitudeState>")
    assert len(parts) == 61
    for k in range(0, 60, 7):
        parts[1 + k] = parts[1 + k] + BETWEEN[k % len(BETWEEN)]
    # another order of attributes, spaces and elements: not alike, but the same
    parts[20] = parts[20].replace('<ANGVEL_X units="deg/s">', "<ANGVEL_X   units='deg/s' > ")
    parts[30] = parts[30].replace("<Q1>", "<Q1><![CDATA[").replace("</Q1>", "]]></Q1>")
    parts[40] = parts[40].replace("</EPOCH>", "&#32;</EPOCH>")
    path.write_text("        <attitudeState>".join(parts))
    found = read(path)
    assert same(found, plain)
    assert same(slowly(path, monkeypatch), plain)
    assert found.segments[0].meta["data_comments"].count("one more") >= 1


def test_records_inside_of_comments_and_character_data_are_none(tmp_path):
    """Alike as they may be: they are not parsed, so they must not be matched."""
    path = written(tmp_path, HISTORY[:9], xml=True)
    text = path.read_text()
    records = re.findall(r"\s*<attitudeState>.*?</attitudeState>", text, re.DOTALL)
    assert len(records) == 9
    hidden = "<!--" + "".join(records[5:8]) + "-->"
    path.write_text(text.replace("".join(records[5:8]), hidden))
    found = read(path)
    assert len(found) == 6 and np.array_equal(found.wxyz[5], HISTORY.wxyz[8])
    path.write_text(
        text.replace(
            "".join(records[5:8]), "<COMMENT><![CDATA[" + "".join(records[5:8]) + "]]></COMMENT>"
        )
    )
    assert len(read(path)) == 6


@pytest.mark.parametrize("at", [0, 1, 30, 59])
@pytest.mark.parametrize(
    ("old", "new", "sentence"),
    [
        (r"<Q2>[^<]*", "<Q2>two", "Q2 is 'two'"),
        (r"<Q2>[^<]*", "<Q2>1_0", "Q2 is '1_0'"),
        (r"<Q2>[^<]*", "<Q2>nan", "not finite"),
        (r"<Q2>[^<]*", "<Q2>0.9", "off 1 by"),
        (r"<Q2>[^<]*", "<Q2>", "Q2 is '', which is no number"),
        (r"<EPOCH>[^<]*", "<EPOCH>2017-02-30T00:00:00", "the epoch '2017-02-30"),
        (r'X units="deg/s"', 'X units="deg"', "ANGVEL_X is in 'deg'; it must be in deg/s"),
        (
            r"<EPOCH>",
            "<EPOCH>2016-12-31T00:00:00</EPOCH><EPOCH>",
            "EPOCH does not belong into a row, or not twice",
        ),
        (r"<Q2>[^<]*</Q2>", "", "lacks Q2"),
        (r"</QC>", "</Q>", "mismatched tag"),
    ],
)
def test_the_line_of_what_is_wrong_is_told_in_long_xml(tmp_path, at, old, new, sentence):
    path = written(tmp_path, xml=True)
    parts = path.read_text().split("<attitudeState>")
    changed = re.sub(old, new, parts[1 + at], count=1)
    assert changed != parts[1 + at]
    line = "<attitudeState>".join(parts[: 1 + at]).count("\n") + 1
    parts[1 + at] = changed
    path.write_text("<attitudeState>".join(parts))
    with pytest.raises(AttitudeError, match=sentence) as found:
        read(path)
    told = int(re.search(r"line (\d+):", str(found.value)).group(1))
    assert line <= told <= line + 18  # lines of a record; what is wrong with numbers, at its end


def test_a_message_in_a_combined_one_and_several(tmp_path):
    path = written(tmp_path, HISTORY[:3], xml=True)
    head, body = path.read_text().split("<aem ", 1)
    path.write_text(f"{head}<ndm><COMMENT>around it</COMMENT><aem {body}</ndm>")
    assert read(path).meta["comments"] == ("around it",)
    opm = f'<opm id="CCSDS_OPM_VERS" version="2.0"><COMMENT>{"x" * 5000}</COMMENT><body/></opm>'
    path.write_text(f"{head}<ndm>{opm}<aem {body}{opm}</ndm>")
    assert np.array_equal(detect.read(path).wxyz, read(path).wxyz)
    assert read(path).meta["comments"] == ()
    for content, sentence in (
        (f"{opm}<aem {body}<apm {body}", "holds an OPM and an AEM and an APM; write each into"),
        (opm, "is an OPM, which holds no attitudes"),
        (f"<aem {body}<aem {body}", "several messages"),
    ):
        path.write_text(f"{head}<ndm>{content}</ndm>")
        with pytest.raises(AttitudeError, match=sentence):
            detect.read(path)
    for tolerance in (-1.0, float("nan"), "x", None, True):
        with pytest.raises(AttitudeError, match="tolerance is"):
            read(path, tolerance=tolerance)


@pytest.mark.parametrize("kind", [k for k in _records.COLUMNS if k != "SPIN"])
@pytest.mark.parametrize("to_body", [True, False])
@pytest.mark.parametrize("over_body", [True, False])
@pytest.mark.parametrize("follow", [True, False])
def test_columns_mean_the_same_in_every_convention_and_sequence(kind, to_body, over_body, follow):
    """There and back through each direction, frame of rates and order of axes."""
    wxyz, rates = HISTORY.wxyz, HISTORY.angular_velocity
    sequences = forms.EULER_SEQUENCES if kind.startswith("EULER") else ("ZXZ",)
    for sequence in sequences:
        how = _records.Convention(
            to_body=to_body, rates_over_body=over_body, rates_follow=follow, sequence=sequence
        )
        columns = _records.encoded(kind, wxyz, rates, HISTORY.angular_acceleration, how)
        assert columns.shape == (60, len(_records.COLUMNS[kind]))
        q, w = _records.decoded(kind, columns, how)
        assert apart(q, wxyz) < 3e-15
        if _records.has_rates(kind):
            # rad/s; near gimbal lock (1e-2 away) rates of angles amplify rounding a hundredfold
            assert np.max(np.abs(w - rates)) < 1e-13
        else:
            assert w is None


@pytest.mark.parametrize("kind", _records.IN_VERSION_1)
def test_version_1_the_other_way_round_is_the_same(tmp_path, kind):
    """A and B exchanged and the direction turned: nothing has changed, the rates' frame but named
    by its other keyword."""
    for over in ("body", "frame"):
        path = written(tmp_path, version="1.0", kind=kind, rates_over=over)
        before, text = read(path), path.read_text()
        for old, new in [
            (
                "REF_FRAME_A = ICRF\nREF_FRAME_B = SC_BODY_1",
                "REF_FRAME_A = SC_BODY_1\nREF_FRAME_B = ICRF",
            ),
            ("ATTITUDE_DIR = A2B", "ATTITUDE_DIR = B2A"),
        ]:
            assert old in text
            text = text.replace(old, new)
        rate_frame = "B" if over == "body" else "A"
        other = "A" if over == "body" else "B"
        text = text.replace(
            f"RATE_FRAME = REF_FRAME_{rate_frame}", f"RATE_FRAME = REF_FRAME_{other}"
        )
        path.write_text(text)
        after = read(path)
        assert np.array_equal(after.wxyz, before.wxyz)
        if before.angular_velocity is not None:
            assert np.array_equal(after.angular_velocity, before.angular_velocity)


@pytest.mark.parametrize("version", ["1.0", "2.0"])
@pytest.mark.parametrize("xml", [False, True])
def test_comments_of_segments_are_kept(tmp_path, version, xml):
    table = read(DATA / "two-segments.aem")
    again = read(written(tmp_path, table, version=version, xml=xml))
    for one, other in zip(table.segments, again.segments, strict=True):
        for key in ("comments", "meta_comments", "data_comments", "object_name", "center"):
            assert one.meta[key] == other.meta[key]
    assert any(part.meta["data_comments"] for part in again.segments)


@pytest.mark.parametrize(
    ("count", "how", "method", "degree"),
    [
        (60, {}, "HERMITE", 7),
        (3, {}, "HERMITE", 5),
        (1, {}, "LINEAR", 1),
        (60, {"kind": "QUATERNION"}, "LAGRANGE", 7),
        (3, {"kind": "QUATERNION"}, "LAGRANGE", 2),
        (60, {"method": "lagrange", "degree": 9}, "LAGRANGE", 9),
        (60, {"method": "slerp"}, "LINEAR", 1),
    ],
)
def test_what_is_recommended_for_interpolation(tmp_path, count, how, method, degree):
    """By names of the standard, and of a degree for which there are records."""
    path = written(tmp_path, HISTORY[:count], **how)
    text = path.read_text()
    assert f"INTERPOLATION_METHOD = {method}\nINTERPOLATION_DEGREE = {degree}\n" in text
    found = read(path)
    assert found.degree == degree
    assert read(written(tmp_path, found)).method == found.method


def test_the_names_of_angles_in_xml_decide(tmp_path):
    path = written(tmp_path, version="1.0", kind="EULER_ANGLE", xml=True, sequence="ZYX")
    text = path.read_text()
    swapped, count = re.subn(
        r'<rotation1 angle="Z(.*)</rotation1>(\s*.*\s*)<rotation3 angle="X(.*)</rotation3>',
        r'<rotation1 angle="X\3</rotation1>\2<rotation3 angle="Z\1</rotation3>',
        text,
    )
    assert count == len(HISTORY)
    expected = read(path).wxyz
    path.write_text(swapped)
    assert np.array_equal(read(path).wxyz, expected)
    path.write_text(text.replace('angle="X_ANGLE"', 'angle="Z_ANGLE"'))
    with pytest.raises(AttitudeError, match="the angles are those of Z, Y, Z, not of ZYX"):
        read(path)
    path.write_text(re.sub(r' angle="[XYZ]_ANGLE"', "", text))
    assert np.array_equal(read(path).wxyz, expected)
