"""``attitude evolve``: tables and figures of mean rotations, and sentences for wrong input."""

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from astropy.table import QTable

from attitude import cli
from attitude.averaged import AveragedMotion
from attitude.formats import mission
from tests.support.places import ROOT

FRICTION = """
[body]
moments = "17023, 124826, 129112 kg m2"
[spin]
epoch = "2026-01-01"
wxyz = [0.8, 0.2, 0.4, 0.4]
angular_velocity = "0.13, 0.0078, 0.0078 rad/s"
[[torque]]
kind = "internal_dissipation"
strength = 1e-4
[[torque]]
kind = "linear_damping"
coefficient = "0.002 N m s"
"""


@pytest.fixture
def file(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "mission.toml").write_text(FRICTION)
    return "mission.toml"


def run(*words):
    return cli.main(["evolve", *map(str, words)])


def test_the_table_is_the_motion(file, capsys):
    assert run(file, "--until", "2026-01-31", "--output", "x.csv", "--step", "1 d") == 0
    lines = Path("x.csv").read_text().splitlines()
    names = lines[0].split(",")
    rows = [dict(zip(names, line.split(","), strict=True)) for line in lines[1:]]
    assert len(rows) == 31
    assert rows[-1]["utc"] == "2026-01-31T00:00:00"
    full = mission.read_motion(file)
    motion = AveragedMotion(full.body, full.spin, full.torques)
    states = motion.at([float(row["tdb_seconds"]) for row in rows])
    for k, name in enumerate(("momentum_x", "momentum_y", "momentum_z")):
        assert np.array_equal([float(row[name]) for row in rows], states.momentum[:, k])
    for name in ("theta", "energy", "P_psi", "P_phi"):
        assert np.array_equal([float(row[name]) for row in rows], getattr(states, name))
    assert [row["mode"] for row in rows] == list(states.mode)
    printed = capsys.readouterr().out.splitlines()
    assert len(printed) == 2
    assert "passage from LAM+ to SAM" in printed[0]
    assert "uniform rotation reached" in printed[1]
    assert printed[0].startswith("2026-01-04T")


def test_the_friction_of_a_material(file):
    """With a mu Q so low that a year ends it: the command takes what the motion takes."""
    rubble = 'axes = [3, 1.5, 1.2]\ndensity = 2000\nrigidity = "1e4 Pa"\nquality = 10'
    Path(file).write_text(FRICTION.replace("strength = 1e-4", rubble))
    assert run(file, "--until", "60 d", "--output", "x.csv", "--step", "20 d") == 0
    rows = [line.split(",") for line in Path("x.csv").read_text().splitlines()]
    full = mission.read_motion(file)
    states = AveragedMotion(full.body, full.spin, full.torques).at(np.arange(4) * 20.0 * 86400.0)
    theta = rows[0].index("theta")
    # the command integrates to the end that it is given, the motion to the last epoch: other steps
    found = [float(row[theta]) for row in rows[1:]]
    np.testing.assert_allclose(found, states.theta, rtol=1e-7)
    assert states.theta[3] < 0.8 * states.theta[0]


def test_ecsv_has_units_and_branches_have_odds(file, capsys):
    Path(file).write_text('name = "a wheel of $5"\n' + FRICTION)
    words = ("--until", "30 d", "--passages", "all", "--least-tilt", "1 deg")
    assert run(file, *words, "--output", "x.ecsv", "--figure", "x.svg") == 0
    table = QTable.read("x.ecsv")
    assert str(table["momentum_x"].unit) == "N m s"
    assert set(table["branch"]) == {1, 2}
    assert np.allclose(table["odds"], 0.5)
    # both branches differ in nothing but the end
    first, second = (table[table["branch"] == k] for k in (1, 2))
    assert np.allclose(first["theta"].value, second["theta"].value, rtol=1e-9)
    # 1 deg of the greatest nutation, which lies across the plane of theta
    edge = (1 / 124826 - 1 / 129112) / (1 / 17023 - 1 / 129112)
    least = np.sin(np.deg2rad(1.0)) * np.sqrt(edge)
    assert np.sin(float(np.min(first["theta"].value))) == pytest.approx(least, rel=1e-6)
    assert {first["end"][-1], second["end"][-1]} == {"+", "-"}
    figure = Path("x.svg").read_text()
    assert figure.startswith("<?xml")
    assert "<!-- a wheel of $5 -->" in figure and "<!-- mean rotation under torques -->" in figure
    assert "branch 2, odds 0.5: LAM+ SAM" in capsys.readouterr().out


def test_standard_output_and_a_figure_alone(file, capsys):
    assert run(file, "--until", "3 d", "--paths", "followed") == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[0].startswith("utc,tdb_seconds,mode,end,momentum_x")
    assert 500 <= len(lines) <= 1002
    assert run(file, "--until", "3 d", "--figure", "x.png", "--passages", "7") == 0
    assert capsys.readouterr().out == ""
    assert os.path.getsize("x.png") > 20000


def test_second_order(file):
    text = FRICTION + '[[torque]]\nkind = "constant"\ntorque = "0.02, 0.05, 0.02 N m"\n'
    Path(file).write_text(text)
    words = ("--until", "2 d", "--output", "x.csv", "--step", "1 d")
    full = mission.read_motion(file)
    sizes = []
    for order in (1, 2):
        assert run(file, *words, "--order", order) == 0
        rows = [line.split(",") for line in Path("x.csv").read_text().splitlines()]
        first, time = (rows[0].index(name) for name in ("momentum_x", "tdb_seconds"))
        found = [list(map(float, row[first : first + 3])) for row in rows[1:]]
        motion = AveragedMotion(full.body, full.spin, full.torques, order=order)
        assert np.array_equal(found, motion.at([float(row[time]) for row in rows[1:]]).momentum)
        sizes.append(np.linalg.norm(found[-1]))
    assert 1e-7 < abs(sizes[1] / sizes[0] - 1.0) < 1e-3


def test_times_before_the_epoch(file):
    assert run(file, "--until", "2025-12-31", "--output", "x.csv", "--step", "12 h") == 0
    last = Path("x.csv").read_text().splitlines()[-1]
    assert last.startswith("2025-12-31T00:00:00,-86400.00002826621,LAM,+")


@pytest.mark.parametrize(("until", "step"), [("4e4 yr", "2e4 yr"), ("-4e3 yr", "2e3 yr")])
def test_dates_end_with_the_calendar_and_the_table_goes_on(file, until, step, capsys):
    Path(file).write_text(FRICTION.split('[[torque]]\nkind = "linear')[0])
    assert run(file, "--until", until, "--step", step, "--output", "x.csv") == 0
    rows = [line.split(",") for line in Path("x.csv").read_text().splitlines()[1:]]
    assert [bool(row[0]) for row in rows] == [True, until[0] == "-", False]
    pace = float(until.split()[0]) / 2.0 * 365.25 * 86400.0
    np.testing.assert_allclose([float(row[1]) for row in rows], pace * np.arange(3), rtol=1e-12)
    assert run(file, "--until", "4e4 yr", "--step", "2e4 yr", "--output", "x.ecsv") == 0
    table = QTable.read("x.ecsv")
    assert list(table["utc"].mask) == [False, True, True]
    assert run(file, "--until", "12026-01-01", "--output", "x.csv") == 2
    assert "--until" in capsys.readouterr().err


def test_a_motion_that_ends_is_a_shorter_table_with_a_warning(file, capsys):
    text = FRICTION.replace("0.002 N m s", "2 N m s")
    Path(file).write_text(text + '[[torque]]\nkind = "constant"\ntorque = "0, 0.02, 0 N m"\n')
    assert run(file, "--until", "400 d", "--output", "x.csv", "--step", "1 h") == 0
    told = capsys.readouterr()
    assert "no longer weak; the table and the figure end there" in told.err
    assert "no longer weak" in told.out.splitlines()[-1]
    weakness = [float(line.split(",")[-1]) for line in Path("x.csv").read_text().splitlines()[1:]]
    assert 0.01 < weakness[-1] <= 0.05


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        (["--until", "soon"], "--until is 'soon'; give a date"),
        (["--until", "0"], "--until is the epoch of the spin; give another epoch"),
        (["--until", "2034"], '--until is 2034; give a date, "2034-01-01", or "2034 s"'),
        (["--until", "30 d", "--step", "0.01 s"], "take a longer step"),
        (["--until", "30 d", "--passages", "coin"], "--passages is 'coin'; give likeliest, all"),
        (["--until", "30 d", "--least-tilt", "50 deg"], "give one from 1e-9 to 0.5 rad"),
        (["--until", "30 d", "--least-tilt", "50 m"], "--least-tilt"),
        (["--until", "30 d", "--paths", "fixed"], "invalid choice: 'fixed'"),
        (["--until", "30 d", "--order", "3"], "--order: invalid choice: 3 (choose from 1, 2)"),
        (["--until", "30 d", "--order", "2", "--paths", "averaged"], "give --paths followed, or"),
        (["--until", "30 d", "--output", "x.txt"], "--output is 'x.txt'"),
        (["--until", "30 d", "--output", "no/x.csv"], "no/x.csv"),
        (["--until", "30 d", "--figure", "x.gif"], "--figure is 'x.gif'"),
        (["--until", "30 d", "--output", "x.csv", "--figure", "no/x.png"], "no/x.png"),
        ([], "--until"),
    ],
)
def test_wrong_options_are_sentences(file, words, sentence, capsys):
    before = set(os.listdir())
    assert run(file, *words) == 2
    told = capsys.readouterr()
    assert sentence in told.err
    assert told.err.count("\n") == 1
    assert set(os.listdir()) == before


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        (("[[torque]]", "[torque]"), "Cannot declare|torque"),
        (('kind = "internal_dissipation"', 'kind = "friction"'), "kind 'friction'"),
        (("strength = 1e-4", "strength = -1e-4"), "strength"),
        (("0.13, 0.0078, 0.0078 rad/s", "0, 0, 0 rad/s"), "does not rotate"),
        (("17023, 124826, 129112", "2, 2, 2"), "equal"),
        (("17023, 124826, 129112", "0, 2, 2"), "without inertia"),
        (("0.002 N m s", "5000 N m s"), "not weak"),
    ],
)
def test_wrong_files_are_sentences(file, change, sentence, capsys):
    Path(file).write_text(FRICTION.replace(*change))
    assert run(file, "--until", "30 d", "--output", "x.csv") == 2
    told = capsys.readouterr().err
    assert any(each in told for each in sentence.split("|")), told
    assert told.count("\n") == 1
    assert os.listdir() == [file]


def test_a_file_without_torques_and_no_file(file, capsys):
    Path(file).write_text(FRICTION.split("[[torque]]")[0])
    assert run(file, "--until", "30 d") == 2
    assert "no sections [[torque]]" in capsys.readouterr().err
    assert run("nothing.toml", "--until", "30 d") == 2
    assert "nothing.toml" in capsys.readouterr().err


def test_an_orbit_too_short_and_too_fast(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    orbit = (
        'center = { kepler = { center = "earth", semi_major_axis = "7000 km", eccentricity = 0.0, '
        'inclination = 1.0, node = 0.0, pericenter_argument = 0.0, epoch = "2026-01-01" } }\n'
    )
    gravity = '[[torque]]\nkind = "gravity_gradient"\n'
    slow = FRICTION.split("[[torque]]")[0].replace("0.13, 0.0078, 0.0078", "0.005, 0.0001, 0.0001")
    Path("slow.toml").write_text(orbit + slow + gravity)
    assert run("slow.toml", "--until", "30 d", "--output", "x.csv") == 2
    assert "ten times slower. Integrate by TorquedRotation" in capsys.readouterr().err
    oem = ROOT / "data" / "paths" / "apophis-2012-2013.oem"
    content = FRICTION.replace("2026-01-01", "2012-12-23").split("[[torque]]")[0]
    Path("short.toml").write_text(
        f'center = {{ oem = "{oem}" }}\n' + content + gravity + 'body = "sun"\n'
    )
    assert run("short.toml", "--until", "2020-01-01", "--output", "x.csv") == 2
    assert "give a longer path, a field of one epoch" in capsys.readouterr().err
    assert not os.path.exists("x.csv")
    assert run("short.toml", "--until", "2013-01-01", "--paths", "averaged") == 2
    assert "a turn of it takes" in capsys.readouterr().err
    assert run("short.toml", "--until", "2013-01-01", "--output", "x.csv") == 0


@pytest.mark.parametrize(
    "is_cold", [pytest.param(True, marks=pytest.mark.slow), False], ids=["cold", "warm"]
)
def test_the_command_with_and_without_machine_code(file, tmp_path, is_cold):
    """In a process of its own, as users run it; cold: nothing is kept by earlier ones."""
    environment = {**os.environ, "ATTITUDE_CACHE": str(tmp_path / "tables")}
    if is_cold:
        environment["NUMBA_CACHE_DIR"] = str(tmp_path / "cache")
    words = [sys.executable, "-m", "attitude", "evolve", str(tmp_path / file), "--until", "10 d"]
    found = subprocess.run(
        [*words, "--step", "5 d"], capture_output=True, text=True, env=environment, cwd=ROOT,
        check=False,
    )  # fmt: skip
    assert found.returncode == 0, found.stderr
    assert len(found.stdout.splitlines()) == 4
