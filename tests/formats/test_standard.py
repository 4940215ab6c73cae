"""The examples of CCSDS 504.0-B-2, annexes F and G, as printed (less "intervening records")."""

import numpy as np
import pytest

from attitude import AttitudeError, Body, FreeRotation, frames
from attitude.formats import aem, apm
from attitude.frames import quaternion
from attitude.frames import representations as forms
from tests.support.places import TEST_DATA

DATA = TEST_DATA / "ccsds"
HEAD = (
    "CCSDS_APM_VERS = 2.0\nCREATION_DATE = 2026-001T00:00:00\nORIGINATOR = TESTS\nOBJECT_NAME = X\n"
    "OBJECT_ID = X\nTIME_SYSTEM = TAI\nEPOCH = 2026-01-01T00:00:00\n"
)
FRAMES = "REF_FRAME_A = ICRF\nREF_FRAME_B = SC_BODY_1\n"


def message(tmp_path, name, *lines):
    path = tmp_path / "message.apm"
    path.write_text(
        "\n".join([HEAD + f"{name}_START", FRAMES + "\n".join(lines), f"{name}_STOP\n"])
    )
    return apm.read(path)


def to_eme2000(wxyz):
    return quaternion.multiply(quaternion.conjugate(frames.wxyz_to_icrf("eme2000")), wxyz)


def test_f2_quaternion(tmp_path):
    found = message(tmp_path, "QUAT", "Q1 = 0", "Q2 = 0", "Q3 = 0.7071", "QC = 0.7071")
    # "the vector of coordinates [1, 0, 0] in frame A has coordinates [0, -1, 0] in frame B"
    assert np.allclose(forms.to_dcm(found.wxyz) @ (1, 0, 0), (0, -1, 0), atol=1e-15)


def test_f3_euler_angles(tmp_path):
    angles = (20.0, -35.0, 110.0)
    found = message(
        tmp_path,
        "EULER",
        "EULER_ROT_SEQ = XYZ",
        *(f"ANGLE_{k + 1} = {a}" for k, a in enumerate(angles)),
    )
    (a, b, c), (d, e, f) = np.cos(np.radians(angles)), np.sin(np.radians(angles))
    third = np.array([[c, f, 0], [-f, c, 0], [0, 0, 1]])
    second = np.array([[b, 0, -e], [0, 1, 0], [e, 0, b]])
    first = np.array([[1, 0, 0], [0, a, d], [0, -d, a]])
    assert np.allclose(forms.to_dcm(found.wxyz), third @ second @ first, atol=1e-15)


@pytest.mark.parametrize("nutation", ["momentum", "phase"])
def test_f5_spin_and_where_it_is_after_300_s(tmp_path, nutation):
    spin = ["SPIN_ALPHA = 0", "SPIN_DELTA = 80", "SPIN_ANGLE = 45", "SPIN_ANGLE_VEL = 1"]
    if nutation == "momentum":
        spin += ["MOMENTUM_ALPHA = 0", "MOMENTUM_DELTA = 70", "NUTATION_VEL = 0.01"]
    else:
        # The momentum seen in the body, X = 0.3420, Z = 0.9397 in A turned by the quaternion below
        wxyz = forms.from_pole(0.0, np.radians(80), np.radians(45))
        momentum = forms.to_dcm(wxyz) @ (np.cos(np.radians(70)), 0, np.sin(np.radians(70)))
        phase = float(np.degrees(-np.arctan2(momentum[1], momentum[0])))
        spin += ["NUTATION = 10", "NUTATION_PER = 36000", f"NUTATION_PHASE = {phase!r}"]
    found = message(tmp_path, "SPIN", *spin)
    # four printed digits
    assert np.allclose(forms.to_xyzw(found.wxyz), (0.0805, 0.0334, 0.9204, 0.3812), atol=5e-5)
    pole = quaternion.rotate(found.wxyz, (0, 0, 1))
    assert np.allclose(pole, (0.1736, 0, 0.9848), atol=5e-5)
    # A symmetric body that precesses so: psi' = phi' cos(theta) (A/C - 1) with A, C its moments.
    axial = 1.0 / (1.0 + 1.0 / (0.01 * np.cos(np.radians(10))))
    motion = FreeRotation(Body(moments=(1.0, 1.0, axial)), found.spin)
    direction = motion.momentum / np.linalg.norm(motion.momentum)
    assert np.allclose(direction, (0.3420, 0, 0.9397), atol=5e-5)
    later = motion.at(300.0)
    # the same attitude, its sign continuous from the start
    assert np.allclose(-later.xyzw, (0.0584, 0.0650, 0.6263, 0.7747), atol=5e-5)
    assert np.allclose(later.body_to_inertial((0, 0, 1)), (0.1739, -0.0091, 0.9847), atol=5e-5)


def test_f6_inertia_has_the_minus_signs_of_its_matrix_unless_told():
    found = apm.read(DATA / "apm-g3.txt")
    wanted = [[6080.0, 135.9, -89.3], [135.9, 5245.5, 90.7], [-89.3, 90.7, 8067.3]]
    assert np.array_equal(found.body.tensor, wanted)
    other = apm.read(DATA / "apm-g3.txt", products="tensor").body.tensor  # as Orekit reads it
    assert np.array_equal(other, 2.0 * np.diag(np.diag(wanted)) - wanted)
    with pytest.raises(AttitudeError, match="products is 'x'"):
        apm.read(DATA / "apm-g3.txt", products="x")
    # its inertia is that of SC_BODY_1, its attitude that of INSTRUMENT_A
    assert (found.meta["inertia_frame"], found.meta["body_frame"]) == ("SC_BODY_1", "INSTRUMENT_A")
    with pytest.raises(AttitudeError, match="the inertia is over the axes SC_BODY_1"):
        _ = found.motion


def test_g1_and_g10_are_the_same_message_and_the_body_is_frame_a():
    text, xml = apm.read(DATA / "apm-g1.txt"), apm.read(DATA / "apm-g10.xml")
    assert np.array_equal(text.wxyz, xml.wxyz) and text.epoch == xml.epoch
    assert text.epoch.utc_iso == "2003-09-30T14:28:15.1172"
    assert text.meta["comments"][2] == xml.meta["comments"][2]
    assert len(text.meta["comments"]) == 6
    given = quaternion.unit([0.25678, 0.00005, 0.87543, 0.40949])
    from attitude.motions import _axes

    outer = _axes.named("ITRF1997").to_icrf(text.epoch, np.zeros(1), None)[0]
    # from body to ITRF are the listed numbers of the inverse
    off = quaternion.multiply(
        quaternion.conjugate(text.wxyz), quaternion.multiply(outer, given * [1, -1, -1, -1])
    )
    assert abs(abs(off[0]) - 1.0) < 1e-14


def test_g2_euler_angles_from_the_body():
    found = apm.read(DATA / "apm-g2.txt")
    from attitude.motions import _axes

    turn = quaternion.from_euler("YXY", np.radians([-26.78, 46.26, 144.10]))
    outer = _axes.named("ITRF").to_icrf(found.epoch, np.zeros(1), None)[0]
    wanted = quaternion.multiply(outer, quaternion.conjugate(turn))
    off = quaternion.multiply(quaternion.conjugate(found.wxyz), wanted)
    assert abs(abs(off[0]) - 1.0) < 1e-14
    assert found.meta["blocks"][0][2] == ("Euler angles",)


def test_g4_two_segments_with_useable_times():
    table = aem.read(DATA / "aem-g4.txt")
    assert [len(part) for part in table.segments] == [4, 4]
    first, second = table.segments
    assert first.span[0].utc_iso == "1996-11-28T22:08:02.5555"
    assert second.span[1].utc_iso == "1996-12-28T21:23:00.5555"
    # printed with five digits, made unit
    wanted = quaternion.unit([0.74533, 0.42319, -0.45697, 0.23784])
    assert np.max(np.abs(to_eme2000(first.wxyz[1]) - wanted)) < 1e-15
    assert (first.method, first.degree) == ("lagrange", 3)  # no rates, four records
    assert first.meta["center"] == "MARS BARYCENTER"
    assert len(first.meta["meta_comments"]) == 3
    with pytest.raises(AttitudeError, match="no attitude"):
        table.at("1996-12-05")


def test_g5_and_g11_are_the_same_spinner():
    text, xml = aem.read(DATA / "aem-g5.txt"), aem.read(DATA / "aem-g11.xml")
    assert len(text) == 8 and len(xml) == 4
    assert np.array_equal(text.wxyz[:4], xml.wxyz) and text.epoch == xml.epoch
    assert text.epoch.utc_iso == "2006-03-31T05:00:00.071"  # from a day of the year
    ra, dec, angle = np.degrees(forms.to_pole(to_eme2000(text.wxyz)))
    assert np.allclose([ra[2], dec[2], angle[2]], [268.64591, 68.412960, 132.18766], atol=1e-9)
    assert text.angular_velocity is None  # its pole moves, and SPIN does not say how
    assert text.meta["data_comments"] == xml.meta["data_comments"]


@pytest.mark.parametrize("name", ["aem-g4.txt", "aem-g5.txt", "aem-g11.xml"])
def test_brahe_reads_the_same_of_the_ephemerides(name):
    ccsds = pytest.importorskip("brahe.ccsds", reason="brahe is not installed")
    theirs, mine = ccsds.AEM.from_file(str(DATA / name)), aem.read(DATA / name)
    assert len(theirs.segments) == len(mine.segments)
    for part, segment in zip(mine.segments, theirs.segments, strict=True):
        wxyz = to_eme2000(part.wxyz)
        assert len(segment.states) == len(part)
        for q, state in zip(wxyz, segment.states, strict=True):
            if name.startswith("aem-g4"):
                p = np.array(state.quaternion.to_vector(True))
            else:
                angles = state.spin_alpha, state.spin_delta, state.spin_angle
                scale = 1.0 if max(map(abs, angles)) < 7.0 else np.pi / 180.0
                p = forms.from_pole(*(scale * np.array(angles)))
            off = quaternion.multiply(quaternion.conjugate(p), q)
            assert np.linalg.norm(off[1:]) < 1e-14


@pytest.mark.parametrize("name", ["apm-g1.txt", "apm-g2.txt", "apm-g3.txt", "apm-g10.xml"])
def test_brahe_reads_the_same_of_the_parameters(name):
    ccsds = pytest.importorskip("brahe.ccsds", reason="brahe is not installed")
    theirs, mine = ccsds.APM.from_file(str(DATA / name)), apm.read(DATA / name)
    assert theirs.object_name == mine.meta["object_name"]
    if mine.body is not None:
        matrix = theirs.inertias[0].inertia_matrix
        assert np.array_equal(matrix() if callable(matrix) else matrix, mine.body.tensor)
    if theirs.quaternion_states:
        given = np.array(theirs.quaternion_states[0].quaternion.to_vector(True))
        blocks = dict((block[0], block[1]) for block in reversed(mine.meta["blocks"]))
        listed = [float(blocks["QUAT"][key]) for key in ("QC", "Q1", "Q2", "Q3")]
        assert np.allclose(given, quaternion.unit(listed), atol=1e-15)


@pytest.mark.parametrize("name", ["aem-g4.txt", "aem-g5.txt", "aem-g11.xml"])
@pytest.mark.parametrize("form", ["KVN", "XML"])
def test_what_brahe_writes_is_read(tmp_path, name, form):
    ccsds = pytest.importorskip("brahe.ccsds", reason="brahe is not installed")
    again = tmp_path / "again"
    ccsds.AEM.from_file(str(DATA / name)).to_file(str(again), form)
    mine, found = aem.read(DATA / name), aem.read(again)
    assert len(found.segments) == len(mine.segments) and len(found) == len(mine)
    off = quaternion.multiply(quaternion.conjugate(found.wxyz), mine.wxyz)
    # whatever digits they print, angles in degrees
    assert np.max(np.linalg.norm(off[:, 1:], axis=1)) < 1e-9
    late = (found.epoch.seconds - mine.epoch.seconds) + (found.seconds - mine.seconds)
    assert np.max(np.abs(late)) < 1e-6


@pytest.mark.parametrize("name", ["apm-g1.txt", "apm-g2.txt", "apm-g3.txt", "apm-g10.xml"])
@pytest.mark.parametrize("form", ["KVN", "XML"])
def test_what_brahe_writes_of_parameters_is_read(tmp_path, name, form):
    ccsds = pytest.importorskip("brahe.ccsds", reason="brahe is not installed")
    again = tmp_path / "again"
    ccsds.APM.from_file(str(DATA / name)).to_file(str(again), form)
    mine, found = apm.read(DATA / name), apm.read(again)
    off = quaternion.multiply(quaternion.conjugate(found.wxyz), mine.wxyz)
    assert np.linalg.norm(off[1:]) < 1e-9
    assert abs(found.epoch.seconds - mine.epoch.seconds) < 1e-6
    assert (found.body is None) == (mine.body is None)
    if found.body is not None:
        assert np.allclose(found.body.tensor, mine.body.tensor, rtol=1e-12)
