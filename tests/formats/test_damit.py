"""DAMIT spin files against their own formula, and there and back."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from attitude import AttitudeError, Body, FreeRotation, Spin, frames
from attitude.cli import main
from attitude.formats import damit, detect, mission

TEXT = "12.5 -34.25 5.270421\n2451545.25 77.5\n0.1 0.5 -0.5\n0.1\n"


def test_the_matrix_is_that_of_the_documentation(tmp_path):
    path = tmp_path / "spin.txt"
    path.write_text(TEXT)
    found = damit.read(path)
    motion = found.motion()
    t = np.array([0.0, 12.0, 1000.0])
    phi = np.radians(77.5) + 2.0 * np.pi * t / (5.270421 * 3600.0)
    for k, angle in enumerate(phi):
        turn = Rotation.from_euler("ZYZ", [np.radians(12.5), np.radians(90 + 34.25), angle])
        wanted = frames.matrix_to_icrf("ecliptic") @ turn.as_matrix()
        assert np.max(np.abs(motion.at(t[k]).matrix - wanted)) < 1e-14
    assert motion.spin.epoch.seconds == 0.25 * 86400.0
    assert found.scattering == ("0.1 0.5 -0.5", "0.1")
    utc = damit.read(path, time_system="UTC").spin.epoch
    assert abs(utc.seconds - motion.spin.epoch.seconds - 64.184) < 2e-3


def test_there_and_back(tmp_path):
    path = tmp_path / "spin.txt"
    path.write_text(TEXT)
    given = damit.read(path)
    body = Body(moments=(1.0, 1.2, 1.5), relative=True)
    damit.write(path, given.motion(body), scattering=given.scattering)
    again = damit.read(path)
    assert abs(again.longitude_deg - given.longitude_deg) < 1e-12
    assert abs(again.latitude_deg - given.latitude_deg) < 1e-12
    assert abs(again.period_h / given.period_h - 1.0) < 1e-15
    assert abs(again.phi0_deg - given.phi0_deg) < 1e-11 and again.jd0 == given.jd0
    assert again.scattering == given.scattering


def test_an_epoch_that_is_no_double_of_days_moves_the_phase_with_it(tmp_path):
    spin = Spin(
        epoch="2026-01-01T01:02:03.123456", wxyz=(1, 2, 3, 4), angular_velocity=(0, 0, 1e-3)
    )
    motion = FreeRotation(Body(moments=(1, 2, 2.5)), spin)
    path = tmp_path / "spin.txt"
    damit.write(path, motion)
    found = damit.read(path).motion()
    # the period is printed in full, the phase is good to a rounding of degrees
    late = spin.epoch.seconds - found.spin.epoch.seconds
    assert abs(late) < 3e-5
    off = motion.at(100.0).matrix - found.at(100.0 + late).matrix
    assert np.max(np.abs(off)) < 1e-10  # 5e-7 s of epoch rounding times 1e-3 rad/s is told apart


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("1 2\n3 4\n", "line 1: it must hold lambda"),
        ("1 2 x\n3 4\n", "line 1: it must hold lambda"),
        ("1 2 3\n3\n", "line 2: it must hold JD0"),
        ("1 2 3\n", "ends before JD0"),
        ("1 92 3\n3 4\n", "latitude of the pole is 92"),
        ("1 2 -3\n3 4\n", "period is -3"),
        ("1 2 nan\n3 4\n", "line 1"),
        ("1 2 3\n1e9 4\n", "line 2: JD0"),
        ("", "ends before lambda"),
    ],
)
def test_what_is_refused(tmp_path, text, sentence):
    path = tmp_path / "spin.txt"
    path.write_text(text)
    with pytest.raises(AttitudeError, match=sentence):
        damit.read(path)


def test_tumblers_are_refused(tmp_path):
    for rates in ((0.1, 0.2, 0.3), (0, 0, -1), (1, 0, 0), (0, 0, 0)):
        spin = Spin(epoch="2026-01-01", wxyz=(1, 0, 0, 0), angular_velocity=rates)
        with pytest.raises(AttitudeError, match=r"\+z axis"):
            damit.write(tmp_path / "x", FreeRotation(Body(moments=(1, 2, 2.5)), spin))


DAMIT = "250.5 -60.25 5.2701\n2451545.0 12.5\n0.1 0.5\n"


@pytest.fixture
def damit_file(tmp_path):
    path = tmp_path / "asteroid.spin"
    path.write_text(DAMIT)
    return path


def test_the_state_in_a_damit_file(damit_file, tmp_path):
    found = detect.read_state(damit_file)
    assert found.name == "asteroid"
    assert np.array_equal(found.motion.spin.wxyz, damit.read(damit_file).spin.wxyz)
    other = tmp_path / "spin.txt"
    other.write_text(DAMIT)
    assert detect.read_state(other).motion.period_phi == found.motion.period_phi
    toml = tmp_path / "state.txt"
    toml.write_text(
        'name = "three words"\n[body]\nmoments = [1, 2, 2.5]\n[spin]\nepoch = "2026-01-01"\n'
        "wxyz = [1, 0, 0, 0]\nangular_velocity = [0, 0, 1]\n"
    )
    assert detect.read_state(toml).name == "three words"


def test_the_state_in_a_table_is_refused(tmp_path):
    path = tmp_path / "table.a"
    path.write_text("stk.v.4.3\n")
    with pytest.raises(AttitudeError):
        detect.read_state(path)


def test_commands_take_a_damit_file(damit_file, tmp_path, capsys):
    assert main(["describe", str(damit_file)]) == 0
    assert "5.2701 h" in capsys.readouterr().out
    table = tmp_path / "table.csv"
    arguments = ["--stop", "1 h", "--step", "30 min", "--output", str(table)]
    assert main(["propagate", str(damit_file), *arguments]) == 0
    assert len(table.read_text().splitlines()) >= 4
    picture = tmp_path / "a.png"
    assert main(["plot", str(damit_file), "--output", str(picture)]) == 0
    assert picture.stat().st_size > 1000


def test_a_mission_takes_a_damit_file(damit_file, tmp_path):
    text = """
    spin = "asteroid.spin"
    observer.direction = [1, 0, 0]
    sun.direction = [0, 1, 0]
    columns = ["sun_direction"]
    times.epochs = ["2026-01-01"]
    """
    motion = mission.parse(text, folder=str(tmp_path)).scene.motion
    assert motion.period_phi == pytest.approx(5.2701 * 3600.0, rel=1e-12)
