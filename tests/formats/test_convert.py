"""``attitude convert`` between any two formats."""

import itertools
import os

import numpy as np
import pytest

from attitude import AttitudeError, Body, FreeRotation, Spin, paths
from attitude.cli import convert, main
from attitude.epochs import _ccsds as ccsds_epochs
from attitude.errors import AttitudeWarning
from attitude.formats import aem, detect, spin_file
from attitude.frames import quaternion
from tests.support.kernels import DATA, kernel

STATE = {"wxyz": (1, 2, 3, 4), "angular_velocity": (0.001, 0.002, 0.015)}
SPIN = Spin(epoch="2026-01-01T00:00:00", **STATE)
MOTION = FreeRotation(Body(moments=(10, 20, 26)), SPIN)


def dates(seconds):
    """Whole seconds of UTC since the epoch, below an hour, as texts."""
    return [f"2026-01-01T00:{k // 60:02d}:{k % 60:02d}" for k in seconds.tolist()]


ENDINGS = ("aem", "xml", "a", "ecsv", "fits", "csv")


def apart(p, q):
    d = quaternion.multiply(quaternion.conjugate(p), q)
    return np.max(2.0 * np.arctan2(np.linalg.norm(d[..., 1:], axis=-1), np.abs(d[..., 0])))


def run(*words):
    """The command as its own parser would run it."""
    import argparse

    parser = argparse.ArgumentParser()
    convert.add_arguments(parser)
    convert.run(parser.parse_args([str(word) for word in words]))


@pytest.fixture
def spin(tmp_path):
    path = tmp_path / "in.toml"
    spin_file.write(path, MOTION)
    return path


@pytest.mark.parametrize("endings", [ENDINGS, ("parquet", "aem", "csv")])
def test_every_table_into_every_other(tmp_path, spin, endings):
    if "parquet" in endings:
        pytest.importorskip("pyarrow", reason="pyarrow is not installed")
    true = MOTION.at(dates(np.arange(0, 601, 10))).wxyz
    for ending in endings:
        run(spin, tmp_path / f"a.{ending}", "--stop", "600", "--step", "10 s")
    for first, second in itertools.product(endings, endings):
        out = tmp_path / f"b.{second}"
        run(tmp_path / f"a.{first}", out)
        assert apart(detect.read(out).wxyz, true) < 2e-13  # UTC of 1e-12 s at 0.015 rad/s


def test_a_table_is_fitted_and_becomes_a_motion(tmp_path, spin, capsys):
    run(spin, tmp_path / "a.aem", "--stop", "3000", "--step", "10 s")
    run(tmp_path / "a.aem", tmp_path / "b.toml", "--fit")
    assert "rms of the residuals" in capsys.readouterr().out
    assert (
        apart(spin_file.read(tmp_path / "b.toml").motion.at(1e4).wxyz, MOTION.at(1e4).wxyz) < 1e-6
    )
    with pytest.raises(AttitudeError, match="--fit"):
        run(tmp_path / "a.aem", tmp_path / "c.toml")


def test_motions_into_motions(tmp_path, spin):
    for version in ("1.0", "2.0"):
        run(spin, tmp_path / "a.apm", "--version", version)
        run(tmp_path / "a.apm", tmp_path / "b.toml")
        found = spin_file.read(tmp_path / "b.toml").motion
        assert np.array_equal(found.body.moments, MOTION.body.moments)
        assert apart(found.at(0.0).wxyz, MOTION.at(0.0).wxyz) < 1e-15


def test_what_a_message_holds_beyond_its_motion_is_said(tmp_path, spin):
    run(spin, tmp_path / "a.apm")
    text = (tmp_path / "a.apm").read_text()
    maneuver = "MAN_START\nMAN_EPOCH_START = 2026-01-01T00:00:05\nMAN_DURATION = 3 [s]\n"
    maneuver += "MAN_REF_FRAME = ICRF\nMAN_TOR_X = -1.25 [N*m]\nMAN_TOR_Y = 0 [N*m]\n"
    (tmp_path / "m.apm").write_text(f"{text}{maneuver}MAN_TOR_Z = 0 [N*m]\nMAN_STOP\n")
    for words in (("b.apm",), ("b.csv", "--stop", "9", "--step", "1")):
        with pytest.warns(AttitudeWarning, match="maneuvers .* are left out"):
            run(tmp_path / "m.apm", tmp_path / words[0], *words[1:])
    run(spin, tmp_path / "a.acm", "--stop", "9", "--step", "1")
    for words in (("c.acm",), ("c.toml", "--fit")):
        with pytest.warns(AttitudeWarning, match="without its inertia; .* has them"):
            run(tmp_path / "a.acm", tmp_path / words[0], *words[1:])
    run(tmp_path / "c.acm", tmp_path / "d.acm")


def test_files_that_a_c_kernel_has_beside_it_do_not_replace_those_that_are_read(tmp_path, capsys):
    options = "--start", "2026-01-01", "--stop", "2026-01-02", "--step", "1 s"
    for name in ("old.bc", "a.tf", "a.tsc"):
        (tmp_path / name).write_bytes(b"DAF/CK  ")
    for name in ("a.tf", "a.tsc"):
        words = "old.bc", "a.bc", "--kernels", name, *options
        words = [str(tmp_path / word) if "." in word else word for word in words]
        assert main(["convert", *words]) == 2
        assert f"{name}' is also a file that the command reads" in capsys.readouterr().err


def test_the_exact_spin_file_holds_a_billion_revolutions(tmp_path, spin):
    run(spin, tmp_path / "b.toml")
    found = spin_file.read(tmp_path / "b.toml").motion
    t = 4.2e11 + np.arange(100.0)
    assert np.array_equal(found.at(t).wxyz, MOTION.at(t).wxyz)


def test_c_kernels(tmp_path, spin, capsys):
    spice = pytest.importorskip("spiceypy", reason="spiceypy is not installed")
    # ten minutes of UTC are longer by 2e-7 s than 600 s of TDB
    run(spin, tmp_path / "a.bc", "--stop", "601", "--tolerance", "1e-10")
    at = "--start", "2026-01-01", "--stop", "2026-01-01T00:10:00", "--step", "10 s"
    for ending in (*ENDINGS, "bc"):
        run(tmp_path / "a.bc", tmp_path / f"b.{ending}", *at)
        if ending != "bc":
            found = detect.read(tmp_path / f"b.{ending}")
            assert len(found) == 61 and found.angular_velocity is not None
            assert apart(found.wxyz, MOTION.at(found.history.time).wxyz) < 2e-10
            run(tmp_path / f"b.{ending}", tmp_path / "c.bc", "--tolerance", "1e-6")
    run(tmp_path / "a.bc", tmp_path / "b.toml", "--fit", *at)
    for ending in ("apm", "apm.xml"):
        with pytest.warns(AttitudeWarning, match="written without inertia"):
            run(tmp_path / "a.bc", tmp_path / f"b.{ending}", "--fit", *at)
    capsys.readouterr()
    assert (
        apart(spin_file.read(tmp_path / "b.toml").motion.at(300.0).wxyz, MOTION.at(300.0).wxyz)
        < 1e-8
    )
    for words, sentence in (
        ((), "has no span of its own; give --start|are sampled at epochs; give --start"),
        (("--step", "1 s"), "has no span of its own; give --start"),
        (("--body", "NOWHERE", *at), "give the name of a frame, such as TUMBLER, and its frame"),
        (("--kernels", "none.tf", *at), "none.tf"),
    ):
        with pytest.raises(AttitudeError, match=sentence):
            run(tmp_path / "a.bc", tmp_path / "d.csv", *words)
    with pytest.raises(AttitudeError, match=r"a\.bc: holds attitudes or maneuvers, and no free"):
        detect.read_state(tmp_path / "a.bc")
    assert main(["view", str(tmp_path / "a.bc"), "--output", str(tmp_path / "a.html")]) == 2
    assert "a.bc has no span of its own; give --start and --stop" in capsys.readouterr().err
    with pytest.raises(AttitudeError, match="no attitude of TUMBLER"):
        run(tmp_path / "a.bc", tmp_path / "d.csv", *at[:3], "2026-01-02", *at[4:])
    assert not (tmp_path / "d.csv").exists()
    assert spice.ktotal("ALL") == 0  # whatever happened


def test_kernels_of_the_user_stay_loaded(tmp_path, spin, capsys):
    spice = pytest.importorskip("spiceypy", reason="spiceypy is not installed")
    run(spin, tmp_path / "a.bc", "--stop", "600")
    for ending in ("bc", "tf", "tsc"):
        spice.furnsh(str(tmp_path / f"a.{ending}"))
    run(
        tmp_path / "a.bc",
        tmp_path / "a.csv",
        "--start",
        "2026-01-01",
        "--stop",
        "2026-01-01T00:01",
        "--step",
        "9",
    )
    assert spice.ktotal("ALL") == 3
    spice.pxform("J2000", "TUMBLER", SPIN.epoch.seconds + 1.0)
    spice.kclear()


def test_motions_into_everything(tmp_path):
    """From each kind of motion; DAMIT for a body that turns about its z axis."""
    steady = FreeRotation(
        MOTION.body, Spin(epoch=SPIN.epoch, wxyz=SPIN.wxyz, angular_velocity=(0, 0, 1e-2))
    )
    spin_file.write(tmp_path / "a.toml", steady)
    motions = ("toml", "apm", "apm.xml", "spin")
    for ending in motions[1:]:
        run(tmp_path / "a.toml", tmp_path / f"a.{ending}")
    for first, second in itertools.product(
        motions, (*motions, "aem", "xml", "a", "ecsv", "fits", "csv")
    ):
        words = () if second in motions else ("--stop", "60", "--step", "10")
        if second in ("apm", "apm.xml") and first == "spin":
            continue  # DAMIT has no body: below
        out = tmp_path / f"b.{second}"
        run(tmp_path / f"a.{first}", out, *words)
        found = detect.read(out)
        time = steady.at(np.arange(0.0, 61.0, 10.0)).time if not words else found.history.time
        # JD0 of DAMIT is one double: 2e-5 s, at 0.01 rad/s
        assert apart(found.at(time).wxyz, steady.at(time).wxyz) < (
            1e-6 if "spin" in (first, second) else 1e-12
        )
    with pytest.warns(AttitudeWarning, match="written without inertia"):
        run(tmp_path / "a.spin", tmp_path / "c.apm")
    from attitude.formats import apm

    assert apm.read(tmp_path / "c.apm").body is None
    with pytest.warns(AttitudeWarning, match="no inertia"):
        run(tmp_path / "c.apm", tmp_path / "c.csv")
        with pytest.raises(AttitudeError, match="attitudes at epochs; give --fit"):
            run(tmp_path / "c.apm", tmp_path / "c.toml")


def test_names_sources_and_comments_go_along(tmp_path):
    said = {"name": "Tumbler", "source": "a paper", "note": "one\nand\ttwo"}
    spin_file.write(tmp_path / "a.toml", MOTION, **said)
    run(tmp_path / "a.toml", tmp_path / "b.toml")
    found = spin_file.read(tmp_path / "b.toml")
    assert {key: getattr(found, key) for key in said} == said
    run(tmp_path / "a.toml", tmp_path / "b.apm")
    run(tmp_path / "b.apm", tmp_path / "c.apm.xml")
    run(tmp_path / "c.apm.xml", tmp_path / "c.aem", "--stop", "60", "--step", "10")
    run(tmp_path / "c.aem", tmp_path / "c.xml")
    meta = detect.read(tmp_path / "c.xml").meta
    assert meta["object_name"] == "Tumbler" and meta["comments"] == ("a paper", "one", "and two")
    run(tmp_path / "c.xml", tmp_path / "c.ecsv")
    assert detect.read(tmp_path / "c.ecsv").meta["object_name"] == "Tumbler"
    run(tmp_path / "c.apm.xml", tmp_path / "d.toml")
    found = spin_file.read(tmp_path / "d.toml")
    assert (found.name, found.note) == ("Tumbler", "a paper one and two")


def test_types_versions_frames(tmp_path, spin):
    for words in (
        ("a.aem", "--version", "1.0", "--type", "EULER_ANGLE", "--frame", "EME2000"),
        ("b.xml", "--time-system", "TDB", "--type", "SPIN/NUTATION_MOM"),
        ("c.a", "--type", "AttitudeTimeQuatScalarFirst", "--frame", "J2000"),
    ):
        run(spin, tmp_path / words[0], "--stop", "100", "--step", "10", *words[1:])
        # Steps are seconds of UTC, in a file in TDB seconds of TDB.
        true = np.arange(11.0) * 10 if "TDB" in words else dates(np.arange(0, 101, 10))
        assert apart(detect.read(tmp_path / words[0]).wxyz, MOTION.at(true).wxyz) < 1e-13


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        (("out.xyz",), "belongs to no format"),
        (("out.aem",), "--step"),
        (("out.aem", "--step", "10"), "--stop"),
        (("out.csv", "--step", "1", "--stop", "9", "--version", "2.0"), "--version has no meaning"),
        (("out.toml", "--step", "10"), "--step has no meaning"),
        (("out.toml", "--fit"), "IN is a motion already"),
        (("out.bc",), "--start and --stop"),
        (("out.bc", "--stop", "9", "--step", "1"), "--step has no meaning"),
        (("out.a", "--stop", "9", "--step", "1", "--frame", "RTN"), "do not know"),
        (("out.aem", "--stop", "9", "--step", "1", "--frame", "LVLH"), "orbit="),
        (("out.aem", "--stop", "9", "--step", "1", "--time-system", "UT1"), "not written in UT1"),
        (("out.aem", "--stop", "9", "--step", "0"), "--step is zero"),
        (("none/out.aem", "--stop", "9", "--step", "1"), "cannot be written: No such file"),
        (("out.spin",), r"\+z axis"),
        (("out.aem", "--step", "1", "--stop", "9", "--version", "3"), "version is '3'"),
    ],
)
def test_what_is_refused(tmp_path, spin, words, sentence):
    with pytest.raises(AttitudeError, match=sentence):
        run(spin, tmp_path / words[0], *words[1:])
    assert os.listdir(tmp_path) == ["in.toml"]


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        (("--stop", "9", "--tolerance", "0"), "tolerance is 0"),
        (("--stop", "-9"), "stop is not after start"),
    ],
)
def test_what_a_c_kernel_refuses(tmp_path, spin, words, sentence):
    pytest.importorskip("spiceypy", reason="spiceypy is not installed")
    with pytest.raises(AttitudeError, match=sentence):
        run(spin, tmp_path / "out.bc", *words)
    assert os.listdir(tmp_path) == ["in.toml"]


# ---- relative to an orbit ------------------------------------------------------------------------

ENVISAT = DATA / "envisat-2013.tle"
PASS = FreeRotation(MOTION.body, Spin(epoch="2013-10-23T05:00:00", **STATE))
T = np.arange(0.0, 601.0, 10.0)


ELLIPSE = paths.kepler(
    **{"semi_major_axis": 7.5e6, "eccentricity": 0.05, "inclination": 1.7, "node": 0.3},
    **{"pericenter_argument": 2.0, "mean_anomaly": 0.5, "epoch": PASS.spin.epoch},
    **{"center": "earth", "frame": "icrf"},
)


def oem_of(path, start, seconds):
    """An OEM of a path about the Earth, whose records begin and end at the epochs given."""
    dates = ccsds_epochs.texts(start, seconds, None, "utc")
    states = np.concatenate(path.state(start, seconds), axis=1) / 1e3
    rows = zip(dates, states.tolist(), strict=True)
    said = {"OBJECT_NAME": "TUMBLER", "OBJECT_ID": "2002-009A", "CENTER_NAME": "EARTH"}
    said |= {"REF_FRAME": "ICRF", "TIME_SYSTEM": "UTC"}
    said |= {"START_TIME": dates[0], "STOP_TIME": dates[-1]}
    lines = ["CCSDS_OEM_VERS = 2.0", "CREATION_DATE = 2026-01-01T00:00:00", "ORIGINATOR = TEST"]
    lines += ["META_START", *(f"{key} = {value}" for key, value in said.items()), "META_STOP"]
    lines += [" ".join([date, *map(repr, row)]) for date, row in rows]
    return "\n".join(lines) + "\n"


@pytest.fixture
def relative(tmp_path):
    """The true history, and the name of an AEM that holds it relative to RTN."""
    history = PASS.at(T)
    aem.write(tmp_path / "rtn.aem", history, frame="RTN", orbit=paths.tle(ENVISAT))
    return history, tmp_path / "rtn.aem"


def test_axes_of_the_orbit_of_a_tle(tmp_path, relative):
    true, given = relative
    run(given, tmp_path / "a.csv", "--orbit", ENVISAT)
    found = detect.read(tmp_path / "a.csv")
    assert apart(found.wxyz, true.wxyz) < 1e-14
    assert np.max(np.abs(found.angular_velocity - true.angular_velocity)) < 1e-14
    # Out again, into the same axes and into others, with --orbit-of by number.
    for out, *words in (("b.aem",), ("c.aem", "--frame", "LVLH"), ("d.a", "--frame", "VVLH")):
        run(given, tmp_path / out, "--orbit", ENVISAT, "--orbit-of", "27386", *words)
        found = detect.read(tmp_path / out, orbit=paths.tle(ENVISAT))
        assert apart(found.wxyz, true.wxyz) < 1e-11  # STK's seconds: 1e-10 s at 0.015 rad/s


def test_axes_of_the_orbit_of_an_oem_that_spans_just_the_attitudes(tmp_path):
    """The rates of the axes at both ends come from one side; epochs differ by their reading."""
    true = PASS.at(T)
    aem.write(tmp_path / "rtn.aem", true, frame="RTN", orbit=ELLIPSE)
    (tmp_path / "orbit.oem").write_text(oem_of(ELLIPSE, true.epoch, T))
    run(tmp_path / "rtn.aem", tmp_path / "a.csv", "--orbit", tmp_path / "orbit.oem")
    found = detect.read(tmp_path / "a.csv")
    assert apart(found.wxyz, true.wxyz) < 1e-14
    off = np.max(np.abs(found.angular_velocity - true.angular_velocity), axis=1)
    assert np.all(off[1:-1] < 1e-14)  # rad/s
    assert np.all(off[[0, -1]] < 6e-11)  # a third of (1 s)^2 d2w/dt2
    (tmp_path / "late.oem").write_text(oem_of(ELLIPSE, true.epoch, T + 30.0))
    with pytest.raises(AttitudeError, match="TUMBLER is known from"):
        run(tmp_path / "rtn.aem", tmp_path / "b.csv", "--orbit", tmp_path / "late.oem")


def test_axes_of_the_orbit_of_an_spk(tmp_path):
    kernel_file = kernel("de421")
    moon = paths.spk(kernel_file, "moon")
    aem.write(tmp_path / "lvlh.aem", PASS.at(T), frame="LVLH_INERTIAL", orbit=moon)
    for name in ("moon", "301"):
        run(tmp_path / "lvlh.aem", tmp_path / "a.csv", "--orbit", kernel_file, "--orbit-of", name)
        assert apart(detect.read(tmp_path / "a.csv").wxyz, PASS.at(T).wxyz) < 1e-14
    for words, sentence in (
        ((), "may hold many bodies; name one"),
        (("--orbit-of", "-123456"), "-123456"),
        (("--orbit-of", "3"), "relative to the barycenter of the solar system"),
    ):
        with pytest.raises(AttitudeError, match=sentence):
            run(tmp_path / "lvlh.aem", tmp_path / "b.csv", "--orbit", kernel_file, *words)
    assert not (tmp_path / "b.csv").exists()


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        ((), r"give orbit=.*on the command line --orbit"),
        (("--orbit-of", "27386"), "give the file with --orbit"),
        (("--orbit", "none.oem"), "none.oem', which is not a file"),
        (("--orbit", ENVISAT, "--orbit-of", "HUBBLE"), "0 satellites called 'HUBBLE'"),
        (("--orbit", DATA / "apophis-2029-encounter.oem"), "APOPHIS is known from"),
        (
            ("--orbit", DATA / "apophis-2029-encounter.oem", "--orbit-of", "APOPHIS"),
            "which holds one body; leave out 'APOPHIS'",
        ),
        (("--orbit", "in.toml"), "in.toml' has neither a center, as a mission file, nor elements"),
    ],
)
def test_orbits_that_are_refused(tmp_path, relative, spin, monkeypatch, words, sentence):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(AttitudeError, match=sentence):
        run(relative[1], "out.csv", *words)
    assert sorted(os.listdir(tmp_path)) == ["in.toml", "rtn.aem"]


def test_an_orbit_where_nothing_refers_to_one(tmp_path, spin):
    with pytest.raises(AttitudeError, match=r"--orbit is for files that end in \.aem, .*\.quat"):
        run(spin, tmp_path / "out.csv", "--stop", "9", "--step", "1", "--orbit", ENVISAT)


def test_what_is_in_no_format(tmp_path):
    path = tmp_path / "in.xyz"
    path.write_text("hello there my friend\n")
    with pytest.raises(AttitudeError, match="no format that is known"):
        run(path, tmp_path / "a.aem")
    with pytest.raises(AttitudeError, match="cannot be read"):
        run(tmp_path / "none", tmp_path / "a.aem")
