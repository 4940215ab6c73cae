"""``attitude geometry``, and the two examples of scenes, as a reader runs them."""

import csv
import io
import re

import numpy as np
import pytest

from attitude import cli
from attitude.formats import mission
from tests.support.examples import is_picture, run
from tests.support.places import DATA

MISSIONS = DATA / "mission"
ENVISAT = str(MISSIONS / "envisat-pass.toml")
FIXED = """
observer.direction = [1, 0, 0]
sun.direction = [0, 1, 0]
columns = ["phase_angle deg", "sun_direction_icrf", "in_umbra"]
times.epochs = ["2026-01-01", "2026-01-02T12:00:00 TDB"]
"""


@pytest.fixture
def geometry(monkeypatch, capsys):
    monkeypatch.setattr(cli, "COMMANDS", (*dict.fromkeys((*cli.COMMANDS, "geometry")),))

    def call(*arguments):
        code = cli.main(["geometry", *map(str, arguments)])
        return code, *capsys.readouterr()

    return call


def rows_of(text):
    return list(csv.DictReader(io.StringIO(text)))


def test_columns_are_those_of_the_scene(geometry):
    code, out, err = geometry(ENVISAT)
    assert (code, err) == (0, "")
    rows = rows_of(out)
    assert len(rows) == 163 and rows[0]["utc"] == "2013-10-23T09:29:00"
    scene = mission.read(ENVISAT).scene
    view = scene.at([row["utc"] for row in rows])
    for name, value in (
        ("elevation [deg]", np.degrees(view.elevation)),
        ("observer_distance [km]", view.observer_distance / 1e3),
        ("observer_direction_z", view.observer_direction[:, 2]),
        ("lit_fraction", view.lit_fraction),
    ):
        assert np.allclose([float(row[name]) for row in rows], value, rtol=1e-11, atol=1e-9)
    assert max(float(row["elevation [deg]"]) for row in rows) > 88.0


def test_times_of_the_command_line_go_before_those_of_the_file(geometry):
    start = "2013-10-23T09:35:00"
    _, out, _ = geometry(ENVISAT, "--start", start, "--stop", start)
    assert [row["utc"] for row in rows_of(out)] == [start]
    code, _, err = geometry(ENVISAT, "--step", "-1 s")
    assert code == 2 and "sign of the step" in err


def test_blocks_do_not_show(geometry, monkeypatch):
    whole = geometry(ENVISAT)[1]
    monkeypatch.setattr("attitude.cli.geometry._BLOCK", 50)
    parts = geometry(ENVISAT)[1]
    for one, other in zip(rows_of(whole), rows_of(parts), strict=True):
        assert one["utc"] == other["utc"]
        assert float(one["phase_angle [deg]"]) == pytest.approx(float(other["phase_angle [deg]"]))


def test_epochs_in_the_file_and_ecsv(geometry, tmp_path):
    from astropy.table import QTable
    from astropy.time import Time

    (tmp_path / "m.toml").write_text(FIXED)
    code, out, err = geometry(tmp_path / "m.toml")
    assert (code, err) == (0, "")
    assert out.splitlines()[0] == (
        "utc,tdb_seconds,phase_angle [deg],sun_direction_icrf_x,sun_direction_icrf_y,"
        "sun_direction_icrf_z,in_umbra"
    )
    utc = Time("2026-01-02T12:00:00", scale="tdb", precision=9).utc
    assert abs((Time(rows_of(out)[1]["utc"], scale="utc") - utc).sec) < 1e-8
    code, _, err = geometry(tmp_path / "m.toml", "--output", tmp_path / "out.ecsv")
    assert (code, err) == (0, "")
    table = QTable.read(tmp_path / "out.ecsv")
    assert table["phase_angle"].unit == "deg" and table["phase_angle"].value.tolist() == [90, 90]
    assert table["in_umbra"].tolist() == [0, 0]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (FIXED.replace("times.epochs", "times.start"), "without quotes"),
        (FIXED.replace("in_umbra", "elevation"), "has no horizon"),
        (FIXED.replace("in_umbra", "sun_direction"), "motion=None"),
        ('center = "mars barycenter"\nephemeris = "builtin"\n'
         + FIXED.replace("in_umbra", "sun_aspect_angle"), "motion=None"),
    ],
)  # fmt: skip
def test_sentences(geometry, tmp_path, text, message):
    (tmp_path / "m.toml").write_text(text)
    code, out, err = geometry(tmp_path / "m.toml", "--output", tmp_path / "x.csv")
    assert code == 2 and out == "" and err.count("\n") == 1
    assert message in err and "Traceback" not in err
    assert not (tmp_path / "x.csv").exists()


def test_standard_deviations_are_columns(geometry, tmp_path):
    file = tmp_path / "m.toml"
    file.write_text(
        'spin = { catalog = "Apophis", epoch = "2012-12-23", phi0 = 0.0, psi0 = 0.0 }\n'
        'errors.attitude = "2 deg"\nobserver.direction = [1, 0, 0]\nsun.direction = [0, 1, 0]\n'
        'columns = ["sun_axis_angles_sigma deg", "phase_angle_sigma"]\n'
        'times.epochs = ["2012-12-23", "2012-12-24"]\n'
    )
    code, out, err = geometry(file)
    assert (code, err) == (0, "")
    for row in csv.DictReader(io.StringIO(out)):
        for axis in ("least", "middle", "greatest"):
            # Errors of the attitude alone stay as they are, alike about all axes.
            assert float(row[f"sun_axis_angles_sigma_{axis} [deg]"]) == pytest.approx(2, rel=1e-9)
        assert float(row["phase_angle_sigma [rad]"]) == 0.0


def test_without_a_file_and_list(geometry):
    code, _, err = geometry()
    assert code == 2 and "give a mission file" in err
    code, out, _ = geometry("--list")
    assert re.search("^observer_axis_angles_sigma +rad  ", out, re.MULTILINE)
    assert code == 0 and "phase_angle_bisector" in out and "V(1, 1, alpha)" in out


def test_example_envisat_pass(tmp_path):
    found = run("envisat_pass.py", tmp_path)
    assert found.stderr == ""
    assert "Culmination 2013-10-23T09:35:48 UTC at 89.0 deg, 772.6 km." in found.stdout
    assert "umbra from 2013-10-23T10:25:16 to 2013-10-23T10:58:05" in found.stdout
    assert is_picture(tmp_path / "envisat_pass.png")


def test_example_apophis_2029(tmp_path):
    found = run("apophis_2029.py", tmp_path)
    assert found.stderr == ""
    # As published, 38,011 km at 21:46 UTC; to the minute, and when its light arrives.
    assert "Closest 2029-04-13T21:45 UTC: 38015 km, light 0.127 s." in found.stdout
    assert is_picture(tmp_path / "apophis_2029.png")
