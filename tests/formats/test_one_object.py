"""One file, one object: several objects and frames, contradictions, axes that are no body's."""

import re

import numpy as np
import pytest

from attitude import AttitudeError, Body, FreeRotation, Spin, epochs
from attitude.cli import main
from attitude.formats import acm, aem, apm, detect
from attitude.frames import quaternion
from attitude.motions import _axes
from attitude.paths import _path
from tests.support import earth_orientation, orekit
from tests.support.places import TEST_DATA

OREKIT = TEST_DATA / "orekit"
SPIN = Spin(epoch="2026-01-01T00:00:00", wxyz=(1, 2, 3, 4), angular_velocity=(0.01, 0.15, 0.01))
MOTION = FreeRotation(Body(moments=(10, 20, 26)), SPIN)
HISTORY = MOTION.at(np.arange(20.0))


def apart(p, q):
    d = quaternion.multiply(quaternion.conjugate(p), q)
    return np.max(2.0 * np.arctan2(np.linalg.norm(d[..., 1:], axis=-1), np.abs(d[..., 0])))


def two(tmp_path, first="", second="", parts=None):
    """A file of two segments; `first` and `second` are (pattern, text) for each of them."""
    path = tmp_path / "two.aem"
    names = {"object_name": "SAT", "object_id": "2026-001A"}
    aem.write(path, parts or [HISTORY[:10], HISTORY[10:]], **names)
    head, one, other = path.read_text().split("META_START")
    one, other = (
        re.sub(*change, text, count=1) if change else text
        for change, text in ((first, one), (second, other))
    )
    path.write_text("META_START".join([head, one, other]))
    return path


def test_segments_of_two_objects_are_not_joined(tmp_path):
    path = two(tmp_path, second=("= 2026-001A", "= 2026-001B"))
    with pytest.raises(AttitudeError, match=r"several objects: 2026-001A SAT, 2026-001B SAT; cho"):
        aem.read(path)
    for how in ({"object": "2026-001B"}, {"segment": 1}):
        assert aem.read(path, **how).seconds[-1] == pytest.approx(9.0, abs=1e-6)
        assert detect.read(path, **how).meta["object_id"] == "2026-001B"
    with pytest.raises(
        AttitudeError, match="object is '2026-001C'; the segments are those of 2026"
    ):
        aem.read(path, object="2026-001C")
    with pytest.raises(AttitudeError, match="segment is 2; the file has the segments 0 to 1"):
        aem.read(path, segment=2)
    out = tmp_path / "b.ecsv"
    assert main(["convert", str(path), str(out)]) != 0 and not out.exists()
    assert main(["convert", str(path), str(out), "--object", "2026-001A"]) == 0
    assert main(["convert", str(path), str(out), "--segment", "1"]) == 0
    assert len(detect.read(out)) == 10


def test_a_name_written_otherwise_is_the_same_object(tmp_path):
    assert len(aem.read(two(tmp_path, second=("= SAT", "= SATELLITE"))).segments) == 2


def test_segments_of_two_body_frames_are_not_joined(tmp_path):
    path = two(tmp_path)
    path.write_text(path.read_text()[::-1].replace("1_YDOB_CS", "1_TNEMURTSNI")[::-1])
    text = path.read_text()
    head, last = text.rsplit("META_START", 1)
    path.write_text(head.replace("INSTRUMENT_1", "SC_BODY_1") + "META_START" + last)
    with pytest.raises(AttitudeError, match="several body frames: SC_BODY_1, INSTRUMENT_1"):
        aem.read(path)
    assert aem.read(path, segment=1).meta["body_frame"] == "INSTRUMENT_1"


def test_overlaps_that_contradict_each_other(tmp_path):
    other = FreeRotation(
        Body(moments=(10, 20, 26)),
        Spin(epoch=SPIN.epoch, wxyz=(1, 2, 3, 3.5), angular_velocity=(0.01, 0.15, 0.01)),
    )
    t = np.arange(20.0)
    path = two(tmp_path, parts=[MOTION.at(t[:12]), other.at(t[8:])])
    with pytest.raises(AttitudeError, match=r"segments 0 and 1 overlap, and at 2026-01-01T00:00:0"):
        aem.read(path)
    assert len(aem.read(path, segment=0)) == 12
    # The same attitudes twice, and a shared end point, are no contradiction.
    assert len(aem.read(two(tmp_path, parts=[MOTION.at(t[:12]), MOTION.at(t[8:])]))) == 24
    assert len(aem.read(two(tmp_path, parts=[MOTION.at(t[:9]), MOTION.at(t[8:])]))) == 21


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        (("STOP_TIME = .*", "STOP_TIME = 2025-01-01T00:00:00"), "STOP_TIME is before START_TIME"),
        (("STOP_TIME = .*", "STOP_TIME = 2026-01-01T00:00:07"), r"line 28: .* 1 s after STOP_TIME"),
        (
            ("START_TIME = .*", "START_TIME = 2026-01-01T00:00:02.5"),
            r"line 20: the record is 2\.5 s before START_TIME",
        ),
        (
            (
                "META_STOP",
                "USEABLE_START_TIME = 2026-01-01T00:00:05\n"
                "USEABLE_STOP_TIME = 2026-01-01T00:00:01\nMETA_STOP",
            ),
            "line 18: USEABLE_STOP_TIME is before USEABLE_START_TIME",
        ),
        (
            ("META_STOP", "USEABLE_START_TIME = 2026-01-01T00:01:00\nMETA_STOP"),
            "the usable span ends before it begins, or lies outside of the records",
        ),
    ],
)
def test_records_outside_of_the_meta_data(tmp_path, change, sentence):
    with pytest.raises(AttitudeError, match=sentence):
        aem.read(two(tmp_path, first=change))
    # Written with fewer digits than the epochs.
    aem.read(two(tmp_path, first=("START_TIME = .*", "START_TIME = 2026-01-01T00:00:00.0009")))


NO_BODY = [
    *("NSW", "NSW_ROTATING", "SEZ", "SEZ_INERTIAL", "PQW", "PQW_INERTIAL", "EQW_INERTIAL"),
    *("MOD_MOON", "TOE", "FIXED_MOON", "MOON_PA_DE421", "INERTIAL", "ECEF", "DTRF2014"),
]


@pytest.mark.parametrize("name", [*NO_BODY, "LVLHX", "EME200", "TNW_INERTIAL2", "ICRF4", "ITRF9"])
@pytest.mark.parametrize("message", ["aem", "apm"])
def test_frames_that_are_no_body_are_not_taken_for_it(tmp_path, name, message):
    path = tmp_path / f"a.{message}"
    write, read = (aem.write, aem.read) if message == "aem" else (apm.write, apm.read)
    given = HISTORY if message == "aem" else MOTION
    with pytest.raises(AttitudeError, match=f"body_frame is '{name}', which (is|looks)"):
        write(path, given, body_frame=name)
    write(path, given)
    path.write_text(path.read_text().replace("SC_BODY_1", name))
    known = name in NO_BODY
    what = "is the name of reference axes" if known else "looks like a misspelled"
    with pytest.raises(AttitudeError, match=f"line .*: REF_FRAME_A is .*; '{name}' {what}"):
        read(path)


@pytest.mark.parametrize("name", ["TOD", "MOD", "GTOD", "CIRS", "TIRS", "TNW", "NTW", "VNC"])
def test_a_message_between_two_known_axes_has_no_body(tmp_path, name):
    path = tmp_path / "a.aem"
    aem.write(path, HISTORY)
    path.write_text(path.read_text().replace("SC_BODY_1", name))
    with pytest.raises(AttitudeError, match="both of them known external axes"):
        aem.read(path)


@pytest.mark.parametrize(
    "name",
    [
        *("SC_BODY_1", "SC_BODY", "SPACECRAFT", "BODY", "MMS_BCS", "HGA", "DSS_1", "SA_2", "RW_3"),
        *("STARTRACKER_1", "IMU_FRAME_1", "BODY_FIXED", "ANTENNA", "CAM", "TELESCOPE", "TAM_1"),
    ],
)
def test_names_of_bodies(name):
    assert _axes.body_name_fault(name) is None


def test_files_of_orekit(tmp_path):
    """What Orekit reads in them, to rounding: `tests/data/orekit/README.md` has their source."""
    with pytest.raises(AttitudeError, match="segments 0 and 1 overlap"):
        aem.read(OREKIT / "AEMExample17.txt")
    for name, count in (("AEMExample17.txt", 5), ("AEMExample11.xml", 1), ("AEMExample05.txt", 1)):
        for k in range(count):
            table = aem.read(OREKIT / name, segment=k, rates="euler")
            assert table.meta["body_frame"] == "SC_BODY_1"
            # The only record of AEMExample05 is before its USEABLE_START_TIME.
            aem.write(tmp_path / "again.aem", table)
            assert aem.read(tmp_path / "again.aem").span == table.span


@pytest.mark.parametrize("name", ["AEMExample17.txt", "AEMExample11.xml", "AEMExample05.txt"])
def test_files_of_orekit_are_read_as_orekit_reads_them(tmp_path, name):
    from attitude import frames

    # A center needs a planetary ephemeris in Orekit.
    text = re.sub(r"(?m)^\s*(<CENTER_NAME>.*|CENTER_NAME *=.*)\n", "", (OREKIT / name).read_text())
    path = tmp_path / name
    path.write_text(text)
    turn = frames.wxyz_to_icrf("eme2000")
    for k, (_, wxyz, rates) in enumerate(orekit.segments_of(path)):
        table = aem.read(path, segment=k, rates="euler")
        assert apart(table.wxyz, quaternion.multiply(turn, wxyz)) < 2e-15
        if table.angular_velocity is not None:
            assert np.max(np.abs(table.angular_velocity - rates)) < 1e-15


# Axes --------------------------------------------------------------------------------------------


class Ellipse(_path.Path):
    """An eccentric, inclined orbit about the Earth."""

    name, center, source = "ellipse", "earth", "made for this test"

    def _state(self, instant, hi, lo):
        anomaly = 1e-3 * ((hi - SPIN.epoch.seconds) + (lo - SPIN.epoch.low) + instant.seconds) + 1.0
        a, e = 8e6, 0.2
        x, y = a * (np.cos(anomaly) - e), a * np.sqrt(1 - e * e) * np.sin(anomaly)
        rate = 1e-3 / (1.0 - e * np.cos(anomaly))
        u, v = -a * np.sin(anomaly) * rate, a * np.sqrt(1 - e * e) * np.cos(anomaly) * rate
        return np.stack([x, 0.6 * y, 0.8 * y]), np.stack([u, 0.6 * v, 0.8 * v])


@pytest.mark.parametrize("name", ["RTN", "TNW", "NTW", "VNC", "QSW", "LVLH"])
def test_axes_of_an_orbit_are_those_of_orekit(name):
    orekit.context()
    from org.hipparchus.geometry.euclidean.threed import Vector3D
    from org.orekit.frames import LOFType
    from org.orekit.utils import PVCoordinates

    zero = np.zeros(1)
    position, velocity = Ellipse().state(SPIN.epoch, zero, zero)
    pv = PVCoordinates(*(Vector3D(*map(float, v[0])) for v in (position, velocity)))
    kind = {"RTN": "QSW", "LVLH": "LVLH_CCSDS"}.get(name, name)
    turn = getattr(LOFType, kind).rotationFromInertial(pv)
    theirs = np.array([turn.getQ0(), turn.getQ1(), turn.getQ2(), turn.getQ3()], dtype=float)
    assert apart(_axes.named(name).to_icrf(SPIN.epoch, zero, zero, Ellipse())[0], theirs) < 1e-15


@pytest.mark.parametrize("name", ["TOD", "MOD", "GTOD", "CIRS", "TIRS", "TNW", "NTW", "VNC"])
def test_these_axes_there_and_back(tmp_path, name):
    orbit = Ellipse() if name in ("TNW", "NTW", "VNC") else None
    for kind in ("QUATERNION/ANGVEL", "QUATERNION/DERIVATIVE"):
        aem.write(tmp_path / "a.aem", HISTORY, frame=name, orbit=orbit, kind=kind)
        assert f"REF_FRAME_A = {name}\n" in (tmp_path / "a.aem").read_text()
        found = aem.read(tmp_path / "a.aem", orbit=orbit)
        assert apart(found.wxyz, HISTORY.wxyz) < 1e-13
        assert np.max(np.abs(found.angular_velocity - HISTORY.angular_velocity)) < 1e-12


def test_true_axes_of_date_are_those_of_astropy():
    from astropy import units
    from astropy.coordinates import CIRS, GCRS, TETE, CartesianRepresentation
    from astropy.time import Time

    time, vector = Time("2020-06-01T12:34:56"), np.array([0.3, -0.5, 0.8])
    position = CartesianRepresentation(vector * 1e7 * units.m)
    for name, frame in (("TOD", TETE), ("CIRS", CIRS)):
        axis = _axes.named(name).to_icrf(epochs.instant(time), np.zeros(1), None)[0]
        with earth_orientation.installed():
            theirs = frame(position, obstime=time).transform_to(GCRS(obstime=time))
        theirs = theirs.cartesian.xyz.to_value("m") / 1e7
        assert np.max(np.abs(quaternion.rotate(axis, vector) - theirs)) < 1e-9


def test_the_axes_of_the_earth_differ_by_what_they_leave_out():
    zero, epoch = np.zeros(1), epochs.instant("2020-06-01T12:34:56")
    at = {
        name: _axes.named(name).to_icrf(epoch, zero, zero)[0]
        for name in _axes.TURNING
        if _axes.TURNING[name] not in _axes.OF_ORBIT
    }
    arcsec = np.radians(1 / 3600)
    assert 0.2 * arcsec < apart(at["GTOD"], at["ITRF"]) < 0.7 * arcsec  # polar motion
    assert apart(at["TIRS"], at["ITRF"]) == pytest.approx(apart(at["GTOD"], at["ITRF"]), rel=1e-5)
    assert 1 * arcsec < apart(at["TOD"], at["MOD"]) < 20 * arcsec  # nutation
    # The same equator: they differ by a turn about z.
    for one, two_ in (("TOD", "CIRS"), ("TOD", "GTOD"), ("TOD", "TEME")):
        z = quaternion.rotate(at[one], [0, 0, 1.0]) - quaternion.rotate(at[two_], [0, 0, 1.0])
        assert np.max(np.abs(z)) < (1e-15 if two_ != "TEME" else 1e-6)


def test_underscores_and_blanks_are_the_same_in_names_of_bodies(tmp_path):
    """CCSDS 504.0-B-2, 6.8.8."""
    change = "REF_FRAME_B = SC_BODY_1", "REF_FRAME_B = SC BODY  1"
    table = aem.read(two(tmp_path, second=change))
    assert len(table.segments) == 2
    assert apart(table.wxyz, HISTORY.wxyz) < 1e-15
    assert np.allclose(table.angular_velocity, HISTORY.angular_velocity, rtol=0, atol=1e-15)
    path = tmp_path / "a.acm"
    acm.write(path, [HISTORY[:10], HISTORY[10:]])
    path.write_text(path.read_text().replace(*change, 1))
    assert acm.read(path).table.meta["body_frame"] == "SC BODY  1"
    assert acm.read(path).motion.body.moments.round(9).tolist() == [10, 20, 26]
