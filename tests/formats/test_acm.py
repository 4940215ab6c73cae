"""ACM: attitudes, covariances, inertia and maneuvers, there and back, and as Orekit reads them."""

import re

import numpy as np
import pytest

from attitude import AttitudeError, Body, FreeRotation, Spin, frames
from attitude.arcs import Arcs, Impulse, InertiaChange
from attitude.cli import main
from attitude.errors import AttitudeWarning
from attitude.fitting import fit
from attitude.formats import acm, aem, detect, spin_file
from attitude.frames import quaternion
from attitude.frames import representations as forms
from tests.support import orekit
from tests.support.places import TEST_DATA

OREKIT = TEST_DATA / "orekit"
FILES = sorted(path.name for path in OREKIT.glob("ACM*.txt"))
BODY = Body(tensor=[[10.0, 0.5, -0.25], [0.5, 20.0, 0.125], [-0.25, 0.125, 26.0]])
SPIN = Spin(
    epoch="2016-12-31T23:59:50",
    wxyz=(1, 2, 3, 4),
    angular_velocity=(0.01, 0.15, 0.01),
    covariance={"attitude": [0.01, 0.02, 0.03], "angular_velocity": 1e-4, "moments": 0.01},
)
MOTION = FreeRotation(BODY, SPIN)
T = np.arange(20.0) / 3.0
NAMES = {"object_name": "SAT", "object_id": "2026-001A"}


def apart(p, q):
    d = quaternion.multiply(quaternion.conjugate(p), q)
    return np.max(2.0 * np.arctan2(np.linalg.norm(d[..., 1:], axis=-1), np.abs(d[..., 0])))


@pytest.mark.parametrize("xml", [False, True])
@pytest.mark.parametrize("frame", ["ICRF", "EME2000", "TEME"])
@pytest.mark.parametrize("system", ["UTC", "TAI", "TDB"])
def test_there_and_back(tmp_path, xml, frame, system):
    """Across a leap second."""
    path = tmp_path / "a.acm"
    how = {"xml": xml, "frame": frame, "time_system": system, "comments": ["one <&>"]}
    acm.write(path, MOTION, t=T, **how, **NAMES, center="EARTH")
    found = acm.read(path)
    history = MOTION.at(T)
    assert found.epoch.since(SPIN.epoch) == pytest.approx(0.0, abs=1e-12)
    assert apart(found.table.wxyz, history.wxyz) < 3e-14
    assert np.max(np.abs(found.table.angular_velocity - history.angular_velocity)) < 1e-14
    late = found.table.seconds - T + found.table.epoch.since(SPIN.epoch)
    assert np.max(np.abs(late)) < 2e-12
    assert np.array_equal(found.body.tensor, BODY.tensor)
    (cov,) = found.covariances
    assert cov.kind == "ANGLE_ANGVEL" and cov.frame == "SC_BODY_1" and len(cov.seconds) == 20
    # The variances about the body axes; turned to ICRF they lack the correlations.
    turn = np.swapaxes(history.matrix, -1, -2)
    true = turn @ history.attitude_covariance @ np.swapaxes(turn, -1, -2)
    assert cov.variances[:, :3] == pytest.approx(np.diagonal(true, axis1=1, axis2=2), rel=1e-12)
    assert cov.variances[:, 3:] == pytest.approx(history.sigma_angular_velocity**2, rel=1e-12)
    outer = cov.in_icrf(found.table)
    assert np.trace(outer, axis1=1, axis2=2) == pytest.approx(
        np.trace(history.attitude_covariance, axis1=1, axis2=2), rel=1e-12
    )
    assert np.array_equal(cov.matrix[3], np.diag(cov.variances[3]))
    assert found.meta["comments"] == ("one <&>",) and found.meta["object_name"] == "SAT"
    assert apart(found.motion.at(3600.0).wxyz, MOTION.at(3600.0).wxyz) < 1e-10


def test_without_errors_and_rates(tmp_path):
    path = tmp_path / "a.acm"
    acm.write(path, MOTION, t=T, covariance=False)
    assert "COV_START" not in path.read_text()
    assert acm.read(path).covariances == ()
    plain = FreeRotation(Body(moments=(1, 2, 3), relative=True), SPIN)
    acm.write(path, FreeRotation(plain.body, Spin(SPIN.epoch, SPIN.wxyz, (0.1, 0, 0.2))), t=T)
    text = path.read_text()
    assert "PHYS_START" not in text and "COV_START" not in text
    with pytest.raises(AttitudeError, match="the message has no inertia"):
        _ = acm.read(path).motion
    with pytest.raises(AttitudeError, match=r"has no covariance|covariance"):
        acm.write(
            path,
            FreeRotation(BODY, Spin(SPIN.epoch, (1, 0, 0, 0), (0.1, 0, 0))),
            t=T,
            covariance=True,
        )
    assert path.read_text() == text


def test_a_fit_is_written_with_its_errors(tmp_path):
    random = np.random.default_rng(3)
    t = np.linspace(0.0, 300.0, 60)
    noise = forms.from_rotation_vector(1e-3 * random.normal(size=(60, 3)))
    from attitude.motions._table import AttitudeTable

    free = FreeRotation(BODY, Spin(SPIN.epoch, SPIN.wxyz, SPIN.angular_velocity))
    wxyz = quaternion.multiply(free.at(t).wxyz, noise)
    found = fit(AttitudeTable(SPIN.epoch, t, wxyz), body=BODY)
    acm.write(tmp_path / "a.acm", found.motion, t=t)
    (cov,) = acm.read(tmp_path / "a.acm").covariances
    history = found.motion.at(t)
    sigma = np.sqrt(cov.variances[:, :3])
    assert np.min(sigma) > 1e-5 and np.max(sigma) < 1e-3
    assert np.sum(cov.variances[:, :3], axis=1) == pytest.approx(
        np.sum(history.sigma**2, axis=1), rel=1e-9
    )


@pytest.mark.parametrize("xml", [False, True])
def test_impulses_are_maneuvers(tmp_path, xml):
    given = Arcs(
        BODY,
        SPIN,
        [
            Impulse(2.2, (0.1, 0.3, -0.2)),
            InertiaChange(3.1, BODY),
            Impulse(4.7, (0.0, -0.4, 0.1), frame="icrf"),
        ],
    )
    path = tmp_path / "a.acm"
    acm.write(path, given, t=T, xml=xml)
    found = acm.read(path)
    assert len(found.tables) == 4 and len(found.maneuvers) == 2  # a change of inertia is none
    one = found.maneuvers[0]
    assert one.purpose == "ATT_ADJUST" and one.begin == one.end
    assert one.begin.since(SPIN.epoch) == pytest.approx(2.2, abs=1e-12)
    later = given.at(2.3)
    momentum = later.body_to_inertial(given.momentum_in_body(later))
    assert one.target_momentum == pytest.approx(momentum, rel=1e-12)
    with pytest.raises(AttitudeError, match="has no duration"):
        one.mean_torque(np.zeros(3))
    # The motion of the message: from its first state, with the impulses.
    t = np.linspace(0.0, 30.0, 100)
    assert apart(found.motion.at(t).wxyz, given.at(t).wxyz) < 1e-12


def test_one_body_is_written(tmp_path):
    """That of the first epoch; a warning tells of another one later."""
    later = Body(moments=(30.0, 40.0, 26.0))
    given = Arcs(BODY, SPIN, [Impulse(1.2, (0.1, 0.3, -0.2)), InertiaChange(3.1, later)])
    path = tmp_path / "a.acm"
    acm.write(path, given, t=T[T >= 3.2])  # of which no warning speaks
    found, t = acm.read(path), np.linspace(4.0, 30.0, 50)
    assert found.body.tensor == pytest.approx(later.tensor, rel=1e-15)
    seconds = t - found.motion.epoch.since(SPIN.epoch)
    assert apart(found.motion.at(seconds).wxyz, given.at(t).wxyz) < 1e-12
    back = Arcs(BODY, SPIN, [InertiaChange(3.1, later), InertiaChange(4.1, BODY)])
    for motion in (given, back):
        with pytest.warns(AttitudeWarning, match="an ACM holds one body"):
            acm.write(path, motion, t=T)
        assert acm.read(path).body.tensor == pytest.approx(BODY.tensor, rel=1e-15)


def test_a_maneuver_as_torque(tmp_path):
    path = tmp_path / "a.acm"
    acm.write(path, MOTION, t=T)
    block = """
MAN_START
MAN_PURPOSE = MOM_DESAT
MAN_BEGIN_TIME = 2.0 [s]
MAN_DURATION = 4.0 [s]
TARGET_MOMENTUM = 1.0 2.0 -3.0 [N*m*s]
TARGET_MOM_FRAME = {frame}
MAN_STOP
"""
    text = path.read_text()
    for frame, matrix in (("ICRF", np.eye(3)), ("J2000", frames.matrix_to_icrf("eme2000"))):
        path.write_text(text + block.format(frame=frame))
        (found,) = acm.read(path).maneuvers
        torque = found.mean_torque(np.array([0.5, 0.0, 0.0]))
        assert torque == pytest.approx(
            (matrix @ (1, 2, -3) - (0.5, 0, 0)) / 4.0, abs=1e-8
        )  # s of UTC
        # As an impulse in the middle, after which the momentum is the target.
        arcs = acm.read(path).motion
        assert arcs.joints == pytest.approx([4.0], abs=1e-8)
        after = arcs.at(5.0)
        momentum = after.body_to_inertial(arcs.momentum_in_body(after))
        assert momentum == pytest.approx(matrix @ (1, 2, -3), abs=1e-13)
    path.write_text(text + block.format(frame="SC_BODY_1"))
    arcs = acm.read(path).motion
    after = arcs.at(arcs.joints[0])
    assert after.motion.momentum_in_body(after) == pytest.approx((1, 2, -3), abs=1e-12)
    # In any order; one that ends at the epoch of the state is over.
    blocks = (f"MAN_BEGIN_TIME = {begin}" for begin in ("3.0 [s]", "0.0 [s]", "1.0 [s]"))
    several = (block.format(frame="ICRF").replace("MAN_BEGIN_TIME = 2.0 [s]", b) for b in blocks)
    path.write_text(text + "".join(several))
    assert acm.read(path).motion.joints == pytest.approx([2.0, 3.0, 5.0], abs=1e-8)
    at_once = block.format(frame="ICRF").replace("2.0 [s]", "0.0").replace("4.0 [s]", "0.0")
    path.write_text(text + at_once)
    assert apart(acm.read(path).motion.at(60.0).wxyz, MOTION.at(60.0).wxyz) < 1e-12
    assert apart(detect.read_state(path).motion.at(60.0).wxyz, MOTION.at(60.0).wxyz) < 1e-12
    path.write_text(text + block.format(frame="ICRF").replace("2.0 [s]", "2026-01-01T00:00:00"))
    with pytest.raises(AttitudeError, match=r"BEGIN_TIME is '2026-.*give a finite number in s"):
        acm.read(path)
    path.write_text(text + block.format(frame="ITRF"))
    with pytest.raises(AttitudeError, match="TARGET_MOM_FRAME is ITRF, axes that turn"):
        acm.read(path).maneuvers[0].impulse()


# Orekit ------------------------------------------------------------------------------------------


def without_center(tmp_path, name):
    """A copy without CENTER_NAME: a center needs a planetary ephemeris in Orekit."""
    path = tmp_path / name
    path.write_text(re.sub(r"(?m)^CENTER_NAME.*\n", "", (OREKIT / name).read_text()))
    return path


def optional(value):
    """The value of an Optional, which Orekit returns since version 14, or None."""
    if not hasattr(value, "isPresent"):
        return value
    return value.get() if value.isPresent() else None


def size(blocks):
    """The size of a list of Orekit, which may be null."""
    return 0 if blocks is None else blocks.size()


@pytest.mark.parametrize("name", FILES)
def test_files_of_orekit_are_read_as_orekit_reads_them(tmp_path, name):
    path = without_center(tmp_path, name)
    found, theirs = acm.read(path), orekit.read_acm(path)
    data = theirs.getSegments().get(0).getData()
    assert len(found.tables) == size(data.getAttitudeBlocks())
    turn = frames.wxyz_to_icrf("eme2000")
    for k, table in enumerate(found.tables):
        if table.meta["keywords"].get("RATE_TYPE") == "GYRO_BIAS" or name == "ACMExample06.txt":
            continue  # Orekit refuses to interpret the first, and matrices of four digits
        block = data.getAttitudeBlocks().get(k)
        _, wxyz, rates = orekit.arrays(list(block.getAngularCoordinates()))
        assert apart(table.wxyz, quaternion.multiply(turn, wxyz)) < 2e-15
        if table.angular_velocity is not None:
            assert np.max(np.abs(table.angular_velocity - rates)) < 1e-15
    assert len(found.covariances) == size(data.getCovarianceBlocks())
    for k, cov in enumerate(found.covariances):
        rows = data.getCovarianceBlocks().get(k).getCovariances()
        theirs = [
            [float(row.getMatrix().getEntry(j, j)) for j in range(cov.variances.shape[1])]
            for row in rows
        ]
        assert cov.variances == pytest.approx(np.array(theirs), rel=1e-14)
    assert (optional(data.getPhysicBlock()) is not None) == (found.body is not None)
    assert len(found.maneuvers) == size(data.getManeuverBlocks())
    for k, maneuver in enumerate(found.maneuvers):
        other = data.getManeuverBlocks().get(k)
        assert maneuver.purpose == str(other.getManPurpose())
        assert maneuver.begin.since(found.epoch) == pytest.approx(float(other.getBeginTime()))
        if maneuver.target_momentum is not None:
            target = optional(other.getTargetMomentum())
            assert np.array_equal(
                maneuver.target_momentum, [target.getX(), target.getY(), target.getZ()]
            )
        if maneuver.target_spin_rate is not None:
            assert maneuver.target_spin_rate == pytest.approx(
                float(optional(other.getTargetSpinRate()))
            )


@pytest.mark.parametrize("xml", [False, True])
@pytest.mark.parametrize("name", FILES)
def test_what_orekit_writes_comes_back(tmp_path, name, xml):
    first = acm.read(without_center(tmp_path, name))
    out = tmp_path / "out.acm"
    orekit.write_acm(orekit.read_acm(tmp_path / name), out, xml)
    again = acm.read(out)
    assert [len(each) for each in again.tables] == [len(each) for each in first.tables]
    for one, two in zip(first.tables, again.tables, strict=True):
        assert apart(one.wxyz, two.wxyz) < 1e-15
        if one.angular_velocity is not None:
            assert np.max(np.abs(one.angular_velocity - two.angular_velocity)) < 1e-15
    for one, two in zip(first.covariances, again.covariances, strict=True):
        assert two.variances == pytest.approx(one.variances, rel=1e-14)
    if first.body is not None:
        assert np.array_equal(first.body.tensor, again.body.tensor)
    for one, two in zip(first.maneuvers, again.maneuvers, strict=True):
        assert one.begin == two.begin and one.end == two.end


@pytest.mark.parametrize("xml", [False, True])
def test_orekit_reads_what_we_write(tmp_path, xml):
    path = tmp_path / "a.acm"
    arcs = Arcs(BODY, SPIN, [Impulse(2.2, (0.1, 0.3, -0.2))])
    for source in (MOTION, arcs):
        acm.write(path, source, t=T, xml=xml, frame="EME2000", **NAMES)
        message = orekit.read_acm(path)
        found = acm.read(path)
        turn = frames.wxyz_to_icrf("eme2000")
        for table, (_, wxyz, rates) in zip(found.tables, orekit.states_of(message), strict=True):
            assert apart(table.wxyz, quaternion.multiply(turn, wxyz)) < 2e-15
            assert np.max(np.abs(table.angular_velocity - rates)) < 1e-15
        data = message.getSegments().get(0).getData()
        assert size(data.getManeuverBlocks()) == len(found.maneuvers) == (source is arcs)
        inertia = optional(data.getPhysicBlock()).getInertiaMatrix()
        # Orekit reads IXY as the entry of the tensor, the book as its negative.
        assert float(inertia.getEntry(0, 1)) == -BODY.tensor[0, 1]


@pytest.mark.parametrize("xml", [False, True])
def test_ccsds_ndm_reads_what_we_write(tmp_path, xml):
    ndm = pytest.importorskip("ccsds_ndm", reason="ccsds-ndm-py is not installed")
    path = tmp_path / "a.acm"
    acm.write(path, MOTION, t=T, xml=xml, **NAMES)
    message = ndm.Acm.from_file(str(path))
    assert message.segment.metadata.object_name == "SAT"
    assert len(message.segment.data.att) == 1 and len(message.segment.data.cov) == 1


REFUSED = {
    "incompatible-keys": "line 18: MAN_END_TIME and MAN_DURATION are given",
    "missing-center-of-pressure": "line 18: CP_REF_FRAME is given without CP",
    "missing-target-momentum": "line 20: TARGET_MOM_FRAME is given without TARGET_MOMENTUM",
    "sensor-index-already-used": "line 30: SENSOR_NUMBER 2 was used before, in line 26",
    "spurious-metadata": "line 13: META_START stands in the wrong place",
    "wrong-stddev-number": r"line 31: SENSOR_NOISE_STDDEV is '0\.0097 0\.0097'; give a finite",
}


@pytest.mark.parametrize("name", REFUSED)
def test_what_orekit_refuses(name):
    with pytest.raises(AttitudeError, match=REFUSED[name]):
        acm.read(OREKIT / f"{name}.txt")


def test_numbers_of_sensors_may_have_gaps():
    """The note to 5.3.9.6 of the standard, and its figures G-7 and G-9; Orekit refuses it."""
    ((_, _, _, sensors),) = acm.read(OREKIT / "missing-sensor-index.txt").meta["blocks"]
    assert [sensor["SENSOR_NUMBER"] for sensor in sensors] == ["5", "4", "2", "1"]


def test_seventeen_files_of_orekit():
    assert len(FILES) + len(REFUSED) + 1 == 17


BAD = [
    ("CCSDS_ACM_VERS = 2.0", "CCSDS_ACM_VERS = 3.0", "line 1: it begins with"),
    ("OBJECT_NAME = SAT\n", "", "the meta data end without OBJECT_NAME"),
    ("EPOCH_TZERO = ", "EPOCH_TZERO = x", "EPOCH_TZERO is 'x2016.*, no epoch"),
    ("TIME_SYSTEM = UTC", "TIME_SYSTEM = SCLK", "line 8: TIME_SYSTEM is 'SCLK'"),
    ("ATT_TYPE = QUATERNION", "ATT_TYPE = MRP", "ATT_TYPE of the block ATT is 'MRP'; it must be"),
    ("ATT_TYPE = QUATERNION\n", "", "the block ATT lacks ATT_TYPE; it must be one of"),
    ("RATE_TYPE = ANGVEL", "RATE_TYPE = EULER_RATE", "their rates need EULER_ROT_SEQ"),
    ("NUMBER_STATES = 7", "NUMBER_STATES = 6", "NUMBER_STATES is '6'; QUATERNION with the rates"),
    ("REF_FRAME_B = SC_BODY_1", "REF_FRAME_B = NSW", "'NSW' is the name of reference axes"),
    ("REF_FRAME_A = ICRF\n", "", "the block ATT lacks REF_FRAME_A"),
    ("IXY = ", "IXY = kilo", "IXY is 'kilo.*; give a finite number"),
    ("IYZ = .*\n", "", "the block PHYS has IXX, .*, but lacks IYZ"),
    ("IXX = 10", "IXX = 1000", "the inertia: .* no body has"),
    (r"IXX = 10.0 \[kg\*m\*\*2\]", "IXX = 10.0 [lb]", "IXX is in 'lb'; it must be in kg"),
    ("COV_TYPE = ANGLE_ANGVEL", "COV_TYPE = ANGLE", "it has 7 entries; COV of this type has"),
    ("ATT_STOP\n", "", "PHYS begins before the end of ATT"),
    ("PHYS_STOP\n", "PHYS_STOP\nPHYS_START\nPHYS_STOP\n", "a second block PHYS"),
    ("ATT_START\n", "ATT_START\nCOLOUR = red\n", "COLOUR is not known in the block ATT"),
    ("ATT_START\n", "CAT_START\n", "CAT_START is not known in version 2.0; known are META, ATT"),
    ("REF_FRAME_A", "ATT_TYPE = DCM\nREF_FRAME_A", "ATT_TYPE is given twice, first in line"),
    (r"(?s)COV_STOP\n", "", "the file ends before COV_STOP; is it cut off"),
]


@pytest.mark.parametrize(("pattern", "instead", "sentence"), BAD)
def test_what_is_wrong_is_told(tmp_path, pattern, instead, sentence):
    path = tmp_path / "a.acm"
    acm.write(path, MOTION, t=T, **NAMES)
    changed = re.sub(pattern, lambda _: instead, path.read_text(), count=1)
    assert changed != path.read_text()
    path.write_text(changed)
    with pytest.raises(AttitudeError, match=sentence):
        acm.read(path)


@pytest.mark.parametrize("name", ["a.acm", "a.acm.xml"])
def test_on_the_command_line(tmp_path, name):
    spin, path = tmp_path / "a.toml", tmp_path / name
    spin_file.write(spin, MOTION)
    assert main(["convert", str(spin), str(path), "--stop", "6", "--step", "1"]) == 0
    assert detect.of_file(path).startswith("acm")
    assert len(acm.read(path).covariances) == 1
    assert main(["convert", str(path), str(tmp_path / "b.aem")]) == 0
    dates = [f"2016-12-31T23:59:{50 + k}" for k in range(7)]  # steps are seconds of UTC
    assert apart(aem.read(tmp_path / "b.aem").wxyz, MOTION.at(dates).wxyz) < 1e-14
    assert main(["convert", str(tmp_path / "b.aem"), str(tmp_path / "c.acm")]) == 0
    assert apart(detect.read(tmp_path / "c.acm").wxyz, detect.read(path).wxyz) < 1e-14
    # A message with several bodies, or with none.
    several = OREKIT / "ACMExample05.txt"
    with pytest.raises(AttitudeError, match=r"are those of GYRO_3, ACC_0, .*; choose one"):
        detect.read(several)
    assert len(detect.read(several, segment=2)) == 2
    with pytest.raises(AttitudeError, match="the message has no attitudes"):
        detect.read(OREKIT / "ACMExample07.txt")


ATT = """ATT_START
REF_FRAME_A = GCRF
REF_FRAME_B = SC_BODY
ATT_TYPE = QUATERNION
{}
ATT_STOP
"""


def message(path, *blocks, meta=""):
    head = "CCSDS_ACM_VERS = 2.0\nCREATION_DATE = 2023-01-01T00:00:00\nORIGINATOR = TEST\n"
    head += "META_START\nOBJECT_NAME = TEST\nTIME_SYSTEM = UTC\nEPOCH_TZERO = 2023-01-01T00:00:00\n"
    path.write_text(f"{head}{meta}META_STOP\n{''.join(blocks)}")
    return path


def test_blocks_that_contradict_each_other_are_no_table(tmp_path):
    one, two = (
        ATT.format("\n".join(f"{k} {numbers}" for k in range(9)))
        for numbers in ("0 0 0.6 0.8", "0 0 -0.8 0.6")
    )
    path = message(tmp_path / "a.acm", one, two)
    with pytest.raises(AttitudeError, match=r"the segments 0 and 1 overlap, .* 3\.14 rad apart"):
        _ = acm.read(path).table
    assert main(["convert", str(path), str(tmp_path / "b.aem")]) != 0
    assert not (tmp_path / "b.aem").exists()
    assert apart(detect.read(path, segment=1).wxyz, [0.6, 0, 0, -0.8]) < 1e-15


BAD_TIMES = [
    ("START_TIME = 10\nSTOP_TIME = 5\n", "line 9: STOP_TIME is before START_TIME"),
    (
        "START_TIME = 10\nSTOP_TIME = 2022-12-31T00:00:00\n",
        "line 9: STOP_TIME is before START_TIME",
    ),
    ("START_TIME = nan\n", "line 8: START_TIME is 'nan', no epoch: it is not finite"),
]


@pytest.mark.parametrize(("meta", "sentence"), BAD_TIMES)
def test_times_of_the_meta_data_that_are_refused(tmp_path, meta, sentence):
    path = message(tmp_path / "a.acm", ATT.format("0 0 0 0 1"), meta=meta)
    with pytest.raises(AttitudeError, match=sentence):
        acm.read(path)
