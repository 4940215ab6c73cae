"""``attitude convert`` between any two formats."""

import itertools

import numpy as np
import pytest

from attitude import AttitudeError, Body, FreeRotation, Spin, quaternion
from attitude.cli import convert
from attitude.formats import spin_file, which

SPIN = Spin(epoch="2026-01-01T00:00:00", wxyz=(1, 2, 3, 4), angular_velocity=(0.001, 0.002, 0.015))
MOTION = FreeRotation(Body(moments=(10, 20, 26)), SPIN)
ENDINGS = ("aem", "xml", "a", "ecsv", "fits", "csv", "parquet")


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


def test_every_table_into_every_other(tmp_path, spin):
    pytest.importorskip("pyarrow", reason="pyarrow is not installed")
    true = MOTION.at(np.arange(0.0, 601.0, 10.0)).wxyz
    for ending in ENDINGS:
        run(spin, tmp_path / f"a.{ending}", "--stop", "600", "--step", "10 s")
    for first, second in itertools.product(ENDINGS, ENDINGS):
        out = tmp_path / f"b.{second}"
        run(tmp_path / f"a.{first}", out)
        assert apart(which.read(out).wxyz, true) < 2e-13  # UTC of 1e-12 s at 0.015 rad/s


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


def test_the_exact_spin_file_holds_a_billion_revolutions(tmp_path, spin):
    run(spin, tmp_path / "b.toml")
    found = spin_file.read(tmp_path / "b.toml").motion
    t = 4.2e11 + np.arange(100.0)
    assert np.array_equal(found.at(t).wxyz, MOTION.at(t).wxyz)


def test_c_kernels(tmp_path, spin):
    pytest.importorskip("spiceypy", reason="spiceypy is not installed")
    run(spin, tmp_path / "a.bc", "--stop", "600", "--tolerance", "1e-10")
    run(
        *(tmp_path / "a.bc", tmp_path / "a.csv", "--start", "2026-01-01T00:01:00"),
        *("--stop", "2026-01-01T00:09:00", "--step", "60 s"),
    )
    found = which.read(tmp_path / "a.csv")
    assert apart(found.wxyz, MOTION.at(found.history.time).wxyz) < 2e-10


def test_types_versions_frames(tmp_path, spin):
    for words in (
        ("a.aem", "--version", "1.0", "--type", "EULER_ANGLE", "--frame", "EME2000"),
        ("b.xml", "--time-system", "TDB", "--type", "SPIN/NUTATION_MOM"),
        ("c.a", "--type", "AttitudeTimeQuatScalarFirst", "--frame", "J2000"),
    ):
        run(spin, tmp_path / words[0], "--stop", "100", "--step", "10", *words[1:])
        assert (
            apart(which.read(tmp_path / words[0]).wxyz, MOTION.at(np.arange(11.0) * 10).wxyz)
            < 1e-13
        )


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        (("out.xyz",), "tells no format"),
        (("out.aem",), "--step"),
        (("out.aem", "--step", "10"), "--stop"),
        (("out.csv", "--step", "1", "--stop", "9", "--version", "2.0"), "--version has no meaning"),
        (("out.toml", "--step", "10"), "--step has no meaning"),
        (("out.toml", "--fit"), "IN is a motion already"),
        (("out.spin",), r"\+z axis"),
        (("out.aem", "--step", "1", "--stop", "9", "--version", "3"), "version is '3'"),
    ],
)
def test_what_is_refused(tmp_path, spin, words, sentence):
    with pytest.raises(AttitudeError, match=sentence):
        run(spin, tmp_path / words[0], *words[1:])
    assert not (tmp_path / words[0]).exists()


def test_what_is_in_no_format(tmp_path):
    path = tmp_path / "in.xyz"
    path.write_text("hello there my friend\n")
    with pytest.raises(AttitudeError, match="no format that is known"):
        run(path, tmp_path / "a.aem")
    with pytest.raises(AttitudeError, match="cannot be read"):
        run(tmp_path / "none", tmp_path / "a.aem")
