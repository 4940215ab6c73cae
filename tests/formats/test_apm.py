"""APM: a complete Body and Spin and back, in both versions and notations."""

import re

import numpy as np
import pytest

from attitude import AttitudeError, Body, FreeRotation, Spin
from attitude.errors import AttitudeWarning
from attitude.formats import apm, detect
from attitude.frames import quaternion
from attitude.frames import representations as forms
from tests.support.places import TEST_DATA as DATA

TENSOR = [[10.0, 0.5, -0.25], [0.5, 20.0, 0.125], [-0.25, 0.125, 26.0]]


def motion(frame="icrf", **body):
    spin = Spin(
        epoch="2026-01-01T06:07:08.123456789",
        wxyz=(1, 2, 3, 4),
        angular_velocity=(0.01, 0.15, -0.02),
        frame=frame,
    )
    return FreeRotation(Body(**(body or {"tensor": TENSOR})), spin)


def read(path, **how):
    """The rates of version 1 are body rates here; see `test_formats_old_rates`."""
    return apm.read(path, **{"rates": "body"} | how)


def apart(p, q):
    d = quaternion.multiply(quaternion.conjugate(p), q)
    return np.max(2.0 * np.arctan2(np.linalg.norm(d[..., 1:], axis=-1), np.abs(d[..., 0])))


@pytest.mark.parametrize("version", ["1.0", "2.0"])
@pytest.mark.parametrize("xml", [False, True])
@pytest.mark.parametrize("frame", ["icrf", "eme2000", "ecliptic"])
def test_there_and_back(tmp_path, version, xml, frame):
    given = motion(frame)
    path = tmp_path / "a.apm"
    apm.write(path, given, version=version, xml=xml, comments=["hello <&>"], center="EARTH")
    found = read(path)
    assert np.array_equal(found.body.tensor, given.body.tensor)
    if frame == "icrf":
        assert np.array_equal(found.wxyz, given.spin.wxyz)
    assert apart(found.wxyz, given.spin.wxyz_icrf) < 5e-16
    off = np.abs(found.angular_velocity - given.spin.angular_velocity)
    assert np.max(off) < 3e-17  # rad/s: degrees and back
    assert abs(found.epoch.seconds - given.spin.epoch.seconds) < 1e-7
    late = (found.epoch.seconds - given.spin.epoch.seconds) + (
        found.epoch.low - given.spin.epoch.low
    )
    assert abs(late) < 1e-12
    assert apart(found.motion.at(1e3).wxyz, given.at(1e3).wxyz) < 1e-12
    assert found.meta["comments"] == ("hello <&>",) and found.meta["center"] == "EARTH"
    apm.write(path, found, version="2.0")
    assert np.array_equal(read(path).wxyz, found.wxyz)


def test_version_1_by_hand():
    found = read(DATA / "spinner-1.apm")
    assert found.epoch.utc_iso == "2026-01-01T12:00:00.5"
    assert apart(found.wxyz, forms.from_axis_angle((0, 0, 1), np.pi / 2)) < 1e-15
    # (1, 2, 3) deg/s over ICRF: body x lies along ICRF y, body y against ICRF x
    assert np.allclose(np.degrees(found.angular_velocity), (2, -1, 3), atol=1e-14)
    assert found.body.tensor[0, 1] == 0.5
    assert found.motion.at(0.0).wxyz.shape == (4,)


def test_euler_angles_and_spin_agree_with_the_quaternion(tmp_path):
    """One attitude in each of the ways of version 2, and the same rates."""
    wxyz = quaternion.from_euler("ZXZ", [0.3, 0.7, -1.1])
    rates = np.array([0.0, 0.0, 0.02])
    a, b, c = np.degrees([0.3, 0.7, -1.1])
    head = (
        "CCSDS_APM_VERS = 2.0\nCREATION_DATE = 2026-001T00:00:00\nORIGINATOR = T\n"
        "OBJECT_NAME = S\nOBJECT_ID = S\nTIME_SYSTEM = TAI\nEPOCH = 2026-01-01T00:00:00\n"
    )
    frames = "REF_FRAME_A = ICRF\nREF_FRAME_B = SC_BODY_1\n"
    dots = np.degrees(forms.euler_rates("ZXZ", [0.3, 0.7, -1.1], rates))
    change = forms.quaternion_rate(wxyz, rates)
    w, x, y, z = wxyz
    dw, dx, dy, dz = change
    ways = {
        "EULER": f"EULER_ROT_SEQ = ZXZ\nANGLE_1 = {a}\nANGLE_2 = {b} [deg]\nANGLE_3 = {c}\n"
        f"ANGLE_1_DOT = {dots[0]}\nANGLE_2_DOT = {dots[1]}\nANGLE_3_DOT = {dots[2]} [deg/s]\n",
        "SPIN": f"SPIN_ALPHA = {a - 90}\nSPIN_DELTA = {90 - b}\nSPIN_ANGLE = {c}\n"
        f"SPIN_ANGLE_VEL = {np.degrees(0.02)}\n",
        "QUAT": f"Q1 = {x}\nQ2 = {y}\nQ3 = {z}\nQC = {w}\nQ1_DOT = {dx} [1/s]\nQ2_DOT = {dy}\n"
        f"Q3_DOT = {dz}\nQC_DOT = {dw}\n",
    }
    for name, lines in ways.items():
        path = tmp_path / name
        path.write_text(head + f"{name}_START\n{frames}{lines}{name}_STOP\n")
        found = read(path)
        assert apart(found.wxyz, wxyz) < 1e-15
        assert np.allclose(found.angular_velocity, rates, atol=1e-16)
        with pytest.raises(AttitudeError, match="no inertia"):
            _ = found.motion
    path.write_text(head + f"QUAT_START\n{frames}Q1 = 0\nQ2 = 0\nQ3 = 0\nQC = 1\nQUAT_STOP\n")
    with pytest.raises(AttitudeError, match="no angular velocity"):
        _ = read(path).spin


@pytest.mark.parametrize("xml", [False, True])
def test_ccsds_ndm_reads_version_2(tmp_path, xml):
    ndm = pytest.importorskip("ccsds_ndm", reason="ccsds-ndm-py is not installed")
    path, given = tmp_path / "a.apm", motion()
    apm.write(path, given, xml=xml, object_name="SAT", object_id="2026-001A")
    state = ndm.Apm.from_file(str(path)).segment.data
    theirs = state.quaternion_state[0]
    assert np.array_equal([theirs.qc, theirs.q1], given.spin.wxyz[:2])
    assert state.inertia[0].ixy == -0.5  # the tensor has -IXY, annex F6


@pytest.mark.parametrize("xml", [False, True])
def test_brahe_reads_version_2(tmp_path, xml):
    ccsds = pytest.importorskip("brahe.ccsds", reason="brahe is not installed")
    path, given = tmp_path / "a.apm", motion()
    apm.write(path, given, xml=xml, object_name="SAT", object_id="2026-001A")
    message = ccsds.APM.from_file(str(path))
    theirs = np.array(message.quaternion_states[0].quaternion.to_vector(True))
    assert apart(theirs, given.spin.wxyz) < 1e-14  # rotation in rad: brahe normalises
    matrix = message.inertias[0].inertia_matrix
    assert np.array_equal(matrix() if callable(matrix) else matrix, given.body.tensor)


def test_marks_around_the_meta_data_are_accepted(tmp_path):
    """Some write them, as an AEM has them."""
    text = (DATA / "spinner-1.apm").read_text()
    path = tmp_path / "a.apm"
    text = text.replace("OBJECT_NAME", "META_START\nOBJECT_NAME").replace(
        "EPOCH", "META_STOP\nEPOCH"
    )
    path.write_text(text)
    assert np.array_equal(read(path).wxyz, read(DATA / "spinner-1.apm").wxyz)


BAD = [
    (r"CCSDS_APM_VERS = 1\.0", "CCSDS_APM_VERS = 5", "line 1: it begins with"),
    (r"OBJECT_NAME = S.*\n", "", "the meta data end without OBJECT_NAME"),
    (r"EPOCH = .*\n", "", "the meta data end without EPOCH"),
    (r"EPOCH = 2026", "EPOCH = 20x6", "line 9: EPOCH is"),
    (r"TIME_SYSTEM = UTC", "TIME_SYSTEM = MET", "line 8: TIME_SYSTEM is 'MET'"),
    (r"Q_DIR = A2B", "Q_DIR = UP", "line 12: DIR of the block QUAT is 'UP'"),
    (
        r"Q_FRAME_B = ICRF",
        "Q_FRAME_B = BEAR",
        "line 11: REF_FRAME_A is .SC_BODY_1. and REF_FRAME_B is .BEAR.",
    ),
    (r"Q_FRAME_B = ICRF\n", "", "the block QUAT lacks REF_FRAME_B"),
    (r"Q3 = -0\.7", "Q3 = -0.9", "line 16: the length of the quaternion is off 1 by"),
    (r"Q1 = 0", "Q1 = zero", "line 13: Q1 is 'zero'"),
    (r"Q1 = 0", "Q1 = nan", "line 13: Q1 is 'nan'"),
    (r"Q1 = 0\n", "", "the block QUAT lacks Q1"),
    (r"Q1 = 0\n", "Q1 = 0\nQ1 = 0\n", "line 14: Q1 is given twice, first in line 13"),
    (r"90 \[deg\]", "90 [rad]", "line 23: Z_ANGLE is in 'rad'"),
    (r"EULER_ROT_SEQ = 312", "EULER_ROT_SEQ = 311", "line 21: EULER_ROT_SEQ"),
    (r"Y_ANGLE = 0 ", "X_ANGLE = 0 ", "needs Z_ANGLE, X_ANGLE, Y_ANGLE"),
    (r"RATE_FRAME = E.*\n", "", "the block EULER lacks RATE_FRAME; it must be one of"),
    (r"I33 = 26\.0", "I33 = 260", "line 30: the inertia: .* no body has"),
    (r"I33 = 26\.0", "I33 = 1e308", r"line 30: the inertia: tensor holds 1e\+308"),
    (r"I33 = 26\.0", "I34 = 260", "line 32: I34 is not known"),
    (r"CENTER_NAME = EARTH", "CENTER", "no .KEYWORD = value"),
]


@pytest.mark.parametrize(("pattern", "instead", "sentence"), BAD)
def test_what_is_wrong_is_told(tmp_path, pattern, instead, sentence):
    path = tmp_path / "bad.apm"
    text = (DATA / "spinner-1.apm").read_text()
    changed = re.sub(pattern, lambda _: instead, text, count=1)
    assert changed != text
    path.write_text(changed)
    with pytest.raises(AttitudeError, match=sentence):
        read(path)


def test_what_cannot_be_written(tmp_path):
    relative = motion(moments=(1, 2, 2.5), relative=True)
    for how, sentence in [
        ({}, "relative"),
        ({"version": "7"}, "version is '7'"),
        ({"frame": "ITRF"}, "do not turn"),
        ({"time_system": "UT1"}, "not written"),
        ({"comments": ["a\nb"], "inertia": False}, "one line"),
    ]:
        with pytest.raises(AttitudeError, match=sentence):
            apm.write(tmp_path / "x", relative, **how)
    for ending in ("apm", "spin"):
        with pytest.raises(AttitudeError, match=r"motion is .* holds the state of a FreeRotation"):
            detect.write_motion(tmp_path / f"x.{ending}", relative.at([0.0]))
    assert not list(tmp_path.iterdir())
    apm.write(tmp_path / "x", relative, inertia=False)
    assert read(tmp_path / "x").body is None


@pytest.mark.parametrize("version", ["1.0", "2.0"])
@pytest.mark.parametrize("xml", [False, True])
def test_signs_of_cross_products_are_those_of_the_version_and_can_be_told(tmp_path, version, xml):
    path = tmp_path / "a.apm"
    for products, sign in (
        ("tensor", 1.0),
        ("integral", -1.0),
        (None, 1.0 if version == "1.0" else -1.0),
    ):
        apm.write(path, motion(), version=version, xml=xml, products=products)
        name = "I12" if version == "1.0" else "IXY"
        listed = float(re.search(rf"{name}(?: =| [^>]*>) ?(\S+?)[ <]", path.read_text()).group(1))
        assert listed == sign * 0.5
        assert np.array_equal(read(path, products=products).body.tensor, TENSOR)
    with pytest.raises(AttitudeError, match="products is"):
        apm.write(path, motion(), products="minus")


def test_names_and_comments_go_with_the_parameters(tmp_path):
    path = tmp_path / "a.apm"
    names = {"object_name": "SAT", "object_id": "2026-001A", "center": "MARS", "body_frame": "BUS"}
    apm.write(path, motion(), comments=["kept"], **names)
    again = tmp_path / "b.apm"
    apm.write(again, read(path), version="1.0", xml=True)
    meta = read(again).meta
    assert {key: meta[key] for key in names} == names and meta["comments"] == ("kept",)
    apm.write(again, read(path), object_name="OTHER", comments=())
    assert read(again).meta["object_name"] == "OTHER" and not read(again).meta["comments"]
    path.write_text(re.sub(r"(?s)INERTIA_START.*", "", path.read_text()))
    with pytest.raises(AttitudeError, match="inertia=False"):
        apm.write(again, read(path))
    apm.write(again, read(path), inertia=False)
    with pytest.raises(AttitudeError, match=r"b\.apm: the message has no inertia"):
        detect.read_state(again)
    # As a table of one attitude it is converted to other formats.
    with pytest.warns(AttitudeWarning, match="no inertia, .* its one attitude is read"):
        table = detect.read(again)
    assert np.array_equal(table.wxyz[0], read(again).wxyz) and len(table) == 1
    assert np.array_equal(table.angular_velocity[0], read(again).angular_velocity)


def test_rates_and_inertia_of_another_body_are_refused(tmp_path):
    path = tmp_path / "a.apm"
    apm.write(path, motion())
    text = path.read_text()
    path.write_text(text.replace("INERTIA_REF_FRAME = SC_BODY_1", "INERTIA_REF_FRAME = ARM"))
    found = read(path)
    assert found.spin is not None
    for use in (lambda: found.motion, lambda: apm.write(tmp_path / "b", found)):
        with pytest.raises(AttitudeError, match="inertia is over the axes ARM"):
            use()
    head, tail = text.split("ANGVEL_START")
    path.write_text(head + "ANGVEL_START" + tail.replace("SC_BODY_1", "ARM"))
    with pytest.raises(AttitudeError, match="ANGVEL has the rates of ARM"):
        read(path)


def test_combined_messages(tmp_path):
    path = tmp_path / "a.xml"
    apm.write(path, motion(), xml=True)
    head, body = path.read_text().split("<apm ", 1)
    path.write_text(f"{head}<ndm><COMMENT>around it</COMMENT><apm {body}</ndm>")
    assert read(path).meta["comments"] == ("around it",)
    path.write_text(f"{head}<ndm><apm {body}<apm {body}</ndm>")
    with pytest.raises(AttitudeError, match="several messages"):
        read(path)
    with pytest.raises(AttitudeError, match="tolerance is"):
        read(path, tolerance=float("nan"))


def repeated(tmp_path, name, *changes, behind=True):
    """A message with a second block of a name, in which texts are changed."""
    path = tmp_path / "a.apm"
    apm.write(path, motion())
    text = path.read_text()
    block = re.search(rf"{name}_START(?s:.*){name}_STOP\n", text).group()
    changed = block
    for pattern, instead in changes:
        changed, count = re.subn(pattern, instead, changed)
        assert count
    path.write_text(text.replace(block, block + changed if behind else changed + block))
    return path


UNKNOWN = [
    (
        "QUAT",
        ("REF_FRAME_A = ICRF", "REF_FRAME_A = LVLH"),
        ("Q1 = .*", "Q1 = 0"),
        ("Q3 = .*", "Q3 = 0"),
    ),
    ("QUAT", ("REF_FRAME_A = ICRF", "REF_FRAME_A = MOON_ME"), ("QC = .*", "QC = 0.5")),
    ("ANGVEL", ("REF_FRAME_A = ICRF", "REF_FRAME_A = RTN"), ("ANGVEL_X = .*", "ANGVEL_X = 9")),
    ("ANGVEL", ("SC_BODY_1", "ARM"), ("ANGVEL_X = .*", "ANGVEL_X = 9")),
    ("INERTIA", ("SC_BODY_1", "ARM"), ("IXX = .*", "IXX = 25")),
]


@pytest.mark.parametrize("behind", [True, False])
@pytest.mark.parametrize(("name", "changes"), [(name, changes) for name, *changes in UNKNOWN])
def test_a_repeated_block_that_cannot_be_used_is_left_out(tmp_path, name, changes, behind):
    expected = motion()
    state = read(repeated(tmp_path, name, *changes, behind=behind))
    assert np.array_equal(state.wxyz, expected.spin.wxyz)
    assert np.allclose(state.angular_velocity, expected.spin.angular_velocity, rtol=1e-14)
    assert np.array_equal(state.motion.body.tensor, expected.body.tensor)


CONTRADICTIONS = [
    ("QUAT", ("Q1 = .*", "Q1 = -0.36514837167011072"), "rad from that of the block QUAT in line 9"),
    ("ANGVEL", ("ANGVEL_X = .*", "ANGVEL_X = 9"), "rad/s from those of the block ANGVEL in line"),
    ("INERTIA", ("IXX = .*", "IXX = 25"), "is not that of the block INERTIA in line"),
]


@pytest.mark.parametrize(("name", "change", "sentence"), CONTRADICTIONS)
def test_repeated_blocks_that_contradict_each_other(tmp_path, name, change, sentence):
    with pytest.raises(AttitudeError, match=f"{sentence}.*delete one of the blocks"):
        read(repeated(tmp_path, name, change))


def test_underscores_and_blanks_are_the_same_in_names(tmp_path):
    path = tmp_path / "a.apm"
    apm.write(path, motion())
    text = path.read_text().replace(
        "INERTIA_REF_FRAME = SC_BODY_1", "INERTIA_REF_FRAME = SC Body  1"
    )
    path.write_text(text.replace("ANGVEL_FRAME = SC_BODY_1", "ANGVEL_FRAME = SC BODY 1"))
    assert np.array_equal(read(path).motion.body.tensor, motion().body.tensor)


def test_a_repeated_block_without_names_of_axes_is_refused(tmp_path):
    with pytest.raises(AttitudeError, match="lacks REF_FRAME_A"):
        read(repeated(tmp_path, "QUAT", ("REF_FRAME_A = .*\n", "")))
