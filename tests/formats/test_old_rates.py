"""Rates of version 1: repeated letters, what the caller says, and what Orekit reads and writes."""

import re
import warnings

import numpy as np
import pytest

from attitude import AttitudeError, Body, FreeRotation, Spin, frames
from attitude.cli import main
from attitude.errors import AttitudeWarning
from attitude.formats import _records, aem, apm, detect, spin_file
from attitude.frames import quaternion
from attitude.frames import representations as forms
from tests.support import orekit

SPIN = Spin(epoch="2026-01-01T00:00:00", wxyz=(1, 2, 3, 4), angular_velocity=(0.01, 0.15, 0.01))
MOTION = FreeRotation(Body(moments=(10, 20, 26)), SPIN)
HISTORY = MOTION.at(np.arange(20) / 3.0)
NAMES = {"object_name": "SAT", "object_id": "2026-001A"}
KINDS = ("QUATERNION/ANGVEL", "EULER_ANGLE/ANGVEL")


def apart(p, q):
    d = quaternion.multiply(quaternion.conjugate(p), q)
    return np.max(2.0 * np.arctan2(np.linalg.norm(d[..., 1:], axis=-1), np.abs(d[..., 0])))


def off(table):
    return np.max(np.abs(table.angular_velocity - HISTORY.angular_velocity))


def test_all_readers_agree_on_what_is_written_by_default(tmp_path):
    aem.write(tmp_path / "a.aem", HISTORY, version="1.0")
    text = (tmp_path / "a.aem").read_text()
    assert "ATTITUDE_TYPE = QUATERNION/DERIVATIVE\n" in text and "RATE_FRAME" not in text
    assert off(aem.read(tmp_path / "a.aem")) < 1e-16
    apm.write(tmp_path / "a.apm", MOTION, version="1.0")
    text = (tmp_path / "a.apm").read_text()
    assert "QC_DOT = " in text and "EULER" not in text and "_RATE" not in text
    assert apm.read(tmp_path / "a.apm").angular_velocity == pytest.approx(
        SPIN.angular_velocity, abs=1e-16
    )


@pytest.mark.parametrize("kind", KINDS)
def test_rates_that_readers_take_for_two_things_are_written_when_one_is_named(tmp_path, kind):
    with pytest.raises(AttitudeError, match=r"of AEM 1\.0 is read in two ways; give rates="):
        aem.write(tmp_path / "a.aem", HISTORY, version="1.0", kind=kind)
    with pytest.raises(AttitudeError, match="rates is 'spin'; give"):
        aem.write(tmp_path / "a.aem", HISTORY, version="1.0", kind=kind, rates="spin")
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("xml", [False, True])
@pytest.mark.parametrize("rates", ["body", "euler"])
@pytest.mark.parametrize("sequence", ["ZYX", "ZXZ", "YXY"])
@pytest.mark.parametrize("kind", KINDS)
def test_both_meanings_there_and_back(tmp_path, kind, sequence, rates, xml):
    path = tmp_path / "a.aem"
    how = {"version": "1.0", "kind": kind, "rates": rates, "sequence": sequence, "xml": xml}
    aem.write(path, HISTORY, **how)
    found = aem.read(path, rates=rates)
    assert apart(found.wxyz, HISTORY.wxyz) < 3e-15 and off(found) < 1e-14
    repeated = xml and rates == "euler" and len(set(sequence)) < 3
    if repeated:  # Y_RATE, X_RATE, Y_RATE: without a warning
        assert off(aem.read(path)) < 1e-14
        return
    with pytest.warns(AttitudeWarning, match='give rates="body" or rates="euler"') as said:
        guessed = aem.read(path)
    assert len(said) == 1
    assert (off(guessed) < 1e-14) == (rates == "body")


@pytest.mark.parametrize("kind", KINDS)
def test_the_other_direction(tmp_path, kind):
    """B2A: the angles and their derivatives are those of the inverse rotation."""
    path, h = tmp_path / "a.aem", 1e-5
    aem.write(path, HISTORY, version="1.0", kind=kind, rates="euler", sequence="ZYX")
    back = [quaternion.conjugate(MOTION.at(HISTORY.seconds + s).wxyz) for s in (0.0, -h, h)]
    angles, before, after = (forms.to_euler("ZYX", each) for each in back)
    change = (np.mod(after - before + np.pi, 2 * np.pi) - np.pi) / (2 * h)
    first = forms.to_xyzw(back[0]) if kind.startswith("QUATERNION") else np.degrees(angles)
    columns = np.concatenate([first, np.degrees(change)], axis=1)
    head, rows = re.split("DATA_START\n", path.read_text().replace("= A2B", "= B2A"))
    lines = [
        " ".join([line.split()[0], *map(repr, row.tolist())])
        for line, row in zip(rows.splitlines(), columns, strict=False)
    ]
    path.write_text(head + "DATA_START\n" + "\n".join(lines) + "\nDATA_STOP\n")
    found = aem.read(path, rates="euler")
    assert apart(found.wxyz, HISTORY.wxyz) < 3e-15
    assert off(found) < 1e-9  # differences over 2e-5 s


FIGURE = """\
CCSDS_APM_VERS = 1.0
CREATION_DATE = 2026-01-01T00:00:00
ORIGINATOR = TESTS
OBJECT_NAME = X
OBJECT_ID = 2026-001A
TIME_SYSTEM = UTC
EPOCH = 2026-01-01T00:00:00
EULER_FRAME_A = ICRF
EULER_FRAME_B = SC_BODY_1
EULER_DIR = A2B
EULER_ROT_SEQ = 212
RATE_FRAME = EULER_FRAME_B
Y_ANGLE = -26.78
X_ANGLE = 46.26
Y_ANGLE = 144.10
Y_RATE = 0.1045
X_RATE = 0.03214
Y_RATE = 0.02156
"""


def test_the_form_of_figure_3_6(tmp_path):
    """Repeated letters can only be derivatives of the angles: no warning, whatever `rates` is."""
    path = tmp_path / "a.apm"
    path.write_text(FIGURE)
    angles = np.radians([-26.78, 46.26, 144.10])
    expected = forms.angular_velocity_from_euler_rates(
        "YXY", angles, np.radians([0.1045, 0.03214, 0.02156])
    )
    for rates in (None, "euler", "body"):
        found = apm.read(path, rates=rates)
        assert apart(found.wxyz, quaternion.from_euler("YXY", angles)) < 1e-15
        assert found.angular_velocity == pytest.approx(expected, abs=1e-18)
    with pytest.raises(
        AttitudeError, match="the block EULER has Y_RATE, X_RATE, Y_RATE; YXZ needs"
    ):
        path.write_text(FIGURE.replace("= 212", "= 213").replace("\nY_ANGLE = 1", "\nZ_ANGLE = 1"))
        apm.read(path)


@pytest.mark.parametrize("xml", [False, True])
@pytest.mark.parametrize("rates", ["body", "euler"])
def test_an_apm_with_angles(tmp_path, rates, xml):
    path = tmp_path / "a.apm"
    apm.write(path, MOTION, version="1.0", rates=rates, xml=xml)
    # Without the derivatives of the quaternion, which come first.
    lines = [line for line in path.read_text().splitlines() if "_DOT" not in line]
    path.write_text("\n".join(lines) + "\n")
    found = apm.read(path, rates=rates)
    assert found.angular_velocity == pytest.approx(SPIN.angular_velocity, abs=1e-15)
    with pytest.warns(AttitudeWarning, match="the rates of the block of Euler angles of version 1"):
        apm.read(path)


# Orekit ------------------------------------------------------------------------------------------


def told(history):
    """Attitudes in EME2000."""
    turn = quaternion.conjugate(frames.wxyz_to_icrf("eme2000"))
    return quaternion.multiply(turn, history.wxyz)


@pytest.mark.parametrize("xml", [False, True])
@pytest.mark.parametrize(
    ("version", "kind"),
    [
        (version, kind)
        for version in ("1.0", "2.0")
        for kind in _records.COLUMNS
        if version == "2.0" or kind in _records.IN_VERSION_1
    ],
)
def test_orekit_reads_what_was_meant(tmp_path, version, kind, xml):
    """No exception, no NaN, and the rates of the motion wherever the file has them."""
    path = tmp_path / "a.aem"
    old = version == "1.0" and kind.endswith("/ANGVEL")
    how = {"rates": "euler"} if old else {}
    aem.write(
        path,
        HISTORY,
        **NAMES,
        **how,
        version=version,
        kind=kind,
        xml=xml,
        frame="EME2000",
        sequence="ZYX",
    )
    seconds, wxyz, rates = orekit.read_aem(path)
    assert np.max(np.abs(seconds - orekit.tt_seconds(HISTORY))) < 1e-6  # one double since J2000
    assert apart(wxyz, told(HISTORY)) < 3e-15
    assert not np.any(np.isnan(rates))
    if _records.has_rates(kind) and kind != "SPIN":
        assert np.max(np.abs(rates - HISTORY.angular_velocity)) < 1e-15


@pytest.mark.parametrize("rates", [None, "euler"])
@pytest.mark.parametrize("xml", [False, True])
def test_orekit_reads_parameters(tmp_path, rates, xml):
    path = tmp_path / "a.apm"
    apm.write(path, MOTION, version="1.0", rates=rates, xml=xml, frame="EME2000", **NAMES)
    _, wxyz, found = orekit.read_apm(path)
    assert apart(wxyz, told(HISTORY[:1])) < 3e-15
    assert np.max(np.abs(found - SPIN.angular_velocity)) < 1e-15


# Recipes -----------------------------------------------------------------------------------------


def meta(path):
    lines = [line.partition(" = ") for line in path.read_text().splitlines() if " = " in line]
    return {key: value for key, _, value in lines}


@pytest.mark.parametrize("how", [{}, {"kind": "QUATERNION", "method": "linear", "degree": 1}])
def test_for_gmat(tmp_path, how):
    """The rules of GMAT's reader: CCSDSAEMSegment and CCSDSEMSegment of its sources."""
    path = tmp_path / "a.aem"
    aem.write(path, MOTION, t=np.arange(20.0), for_="gmat", comments=["one"], **how)
    found = meta(path)
    assert found["CCSDS_AEM_VERS"] == "1.0" and found["TIME_SYSTEM"] == "UTC"
    assert (found["REF_FRAME_A"], found["REF_FRAME_B"]) == ("EME2000", "SC_BODY_1")
    assert found["ATTITUDE_TYPE"] == "QUATERNION" and "QUATERNION_TYPE" in found
    assert (found["INTERPOLATION_METHOD"], found["INTERPOLATION_DEGREE"]) == ("LINEAR", "1")
    assert "RATE_FRAME" not in found and "EULER_ROT_SEQ" not in found
    # Comments stand directly behind the version only.
    assert path.read_text().splitlines()[1] == "COMMENT one"
    assert apart(aem.read(path).wxyz, MOTION.at(np.arange(20.0)).wxyz) < 3e-15


BAD = [
    ({"for_": "gmat", "version": "2.0"}, "version is '2.0', which GMAT does not read"),
    ({"for_": "gmat", "kind": "SPIN"}, "kind is 'SPIN', which GMAT does not read"),
    ({"for_": "gmat", "frame": "ITRF"}, "frame is 'ITRF', which GMAT does not read"),
    ({"for_": "gmat", "xml": True}, "xml is True, which GMAT does not read"),
    ({"for_": "gmat", "method": "hermite"}, "method is 'hermite', which GMAT does not read"),
    ({"for_": "gmat", "degree": 3}, "degree is 3, which GMAT does not read"),
    # It interpolates angles as numbers, from 179 to -179 deg through 0.
    ({"for_": "gmat", "kind": "EULER_ANGLE"}, "kind is 'EULER_ANGLE', whose angles GMAT"),
    ({"for_": "brahe", "version": "1.0"}, "version is '1.0', which brahe does not read"),
    ({"for_": "orekit", "rates": "body"}, "rates is 'body', which Orekit does not read"),
    ({"for_": "spice"}, "(--for) is 'spice'; known tools are gmat, orekit, stk, brahe. SPICE"),
]


@pytest.mark.parametrize(("how", "sentence"), BAD)
def test_what_a_tool_does_not_read_is_refused(tmp_path, how, sentence):
    with pytest.raises(AttitudeError, match=re.escape(sentence)):
        aem.write(tmp_path / "a.aem", HISTORY, **how)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("count", [20, 5, 2])
def test_for_orekit_it_interpolates(tmp_path, count):
    path = tmp_path / "a.aem"
    t = np.arange(count) / 3.0
    aem.write(path, MOTION, t=t, for_="orekit", frame="EME2000", **NAMES)
    _, wxyz, _ = orekit.read_aem(path)
    assert apart(wxyz, told(HISTORY[:count])) < 3e-15
    found = orekit.interpolated(path, orekit.tt_seconds(MOTION.at(t[:-1] + 0.1)))
    # One double of seconds since J2000 is good to 6e-8 s; two records are of third degree.
    assert apart(found, told(MOTION.at(t[:-1] + 0.1))) < (2e-8 if count > 2 else 1e-5)


def test_for_brahe(tmp_path):
    ccsds = pytest.importorskip("brahe.ccsds", reason="brahe is not installed")
    path = tmp_path / "a.aem"
    aem.write(path, HISTORY, for_="brahe", **NAMES)
    state = ccsds.AEM.from_file(str(path)).segments[0].states[9]
    assert apart(np.array(state.quaternion.to_vector(True)), HISTORY.wxyz[9]) < 1e-14


@pytest.mark.parametrize("tool", ["gmat", "orekit", "stk", "brahe"])
def test_on_the_command_line(tmp_path, tool):
    spin, path = tmp_path / "a.toml", tmp_path / "a.aem"
    spin_file.write(spin, MOTION)
    made = ["convert", str(spin), str(path), "--stop", "6", "--step", "1"]
    assert main([*made, "--for", tool]) == 0
    dates = [f"2026-01-01T00:00:0{k}" for k in range(7)]  # steps are seconds of UTC
    assert apart(detect.read(path).wxyz, MOTION.at(dates).wxyz) < 3e-15
    assert meta(path)["CCSDS_AEM_VERS"] == ("1.0" if tool in ("gmat", "stk") else "2.0")


def test_rates_on_the_command_line(tmp_path, capsys):
    path = tmp_path / "a.aem"
    how = {"version": "1.0", "kind": "QUATERNION/ANGVEL", "rates": "euler", "sequence": "ZYX"}
    aem.write(path, HISTORY, **how)
    assert main(["convert", str(path), str(tmp_path / "b.ecsv"), "--rates", "euler"]) == 0
    assert off(detect.read(tmp_path / "b.ecsv")) < 1e-14
    assert "warning" not in capsys.readouterr().err
    with warnings.catch_warnings():
        assert main(["convert", str(path), str(tmp_path / "c.ecsv")]) == 0
    assert 'give rates="body" or rates="euler"' in capsys.readouterr().err
