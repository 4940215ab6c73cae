"""``attitude invert`` on the photometry of Toutatis, and ``attitude lightcurve --observed``."""

import inspect
import re
from types import SimpleNamespace

import numpy as np
import pytest

from attitude import AttitudeError, Body, cli, inversion
from attitude.formats import spin_file
from attitude.frames import matrix_to_icrf
from attitude.inversion import _errors, _spin_states, _states
from tests.support.photometry_files import DAMIT
from tests.support.places import DATA, PHOTOMETRY


def _smaller(monkeypatch, **counts):
    """Pairs of frequencies, starts and solutions of a search, and samples of its errors."""
    smaller = inversion.Settings(**counts, short_classes=2 * counts["classes"], rounds=1)
    defaults = inspect.unwrap(inversion.spin_states).__kwdefaults__
    monkeypatch.setitem(defaults, "settings", smaller)
    monkeypatch.setattr(_errors, "_REFITS", 1)
    monkeypatch.setattr(_errors, "_SAMPLES", 100)


@pytest.mark.slow
def test_toutatis_from_its_photometry(tmp_path, capsys, monkeypatch):
    """Periods, pole and attitudes of December 1992 as radar found them; nothing of it is given.

    With a part of the pairs of frequencies, and fewer fits for errors.
    """
    _smaller(monkeypatch, pairs=50, deep_starts=20, classes=10, convex=12, finals=6)
    found, drawn = tmp_path / "toutatis.toml", tmp_path / "fit.png"
    given = ["invert", PHOTOMETRY, "--max-frequency", "0.75 /d", "--budget", "600 s"]
    assert cli.main([*map(str, given), "--output", str(found), "--figure", str(drawn)]) == 0
    text = capsys.readouterr().out
    # one other pole lies within 2.5 of its standard errors between nights: "periods only" is earned
    assert re.search("^(solved|periods only): chi2/N", text, re.M) and "370 points" in text
    motion = spin_file.read(found).motion
    state = motion.published("L", frame="ecliptic")
    assert state.mode == "LAM"
    assert state.P_psi / 86400.0 == pytest.approx(5.37, abs=0.05)
    assert state.P_phi / 86400.0 == pytest.approx(7.41, abs=0.05)
    radar = np.radians([181.0, -53.6])
    x, y = (_unit(*each) for each in (radar, state.pole))
    assert np.degrees(np.arccos(x @ y)) < 10.0
    assert drawn.stat().st_size > 10_000
    # the long axis at the radar epochs
    rows = [row.split(",") for row in (DATA / "toutatis-observed.csv").read_text().splitlines()]
    rows = [row for row in rows if row[0].startswith("1992-12")]
    history = motion.at([row[0] for row in rows])
    long_axis = history.matrix[:, :, np.argmin(motion.body.moments)] @ matrix_to_icrf("ecliptic")
    for row, mine in zip(rows, long_axis, strict=True):
        a, b = np.radians([float(row[1]), float(row[2])])
        seen = np.array([np.sin(a) * np.sin(b), -np.cos(a) * np.sin(b), np.cos(b)])
        assert np.degrees(np.arccos(min(1.0, abs(mine @ seen)))) < 30.0


def test_known_moments(tmp_path, monkeypatch, capsys):
    """The body of a spin file holds the moments of all solutions."""
    _smaller(monkeypatch, pairs=20, deep_starts=10, classes=6, convex=6, finals=4)
    monkeypatch.chdir(tmp_path)
    (tmp_path / "body.toml").write_text(
        '[body]\nmoments = [30, 10, 32]\n[spin]\nepoch = "1993-01-01"\n'
        "wxyz = [1, 0, 0, 0]\nangular_velocity = [1e-5, 0, 1e-5]\n"
    )
    options = ["--max-frequency", "0.5 /d", "--budget", "0.5 s", "--output", "found.toml"]
    options += ["--modes", "LAM"]
    assert cli.main(["invert", str(PHOTOMETRY), *options, "--moments", "body.toml"]) == 0
    moments = np.sort(spin_file.read("found.toml").motion.body.moments)
    assert moments / moments[0] == pytest.approx([1.0, 3.0, 3.2], rel=0.02)


def test_three_known_moments_are_those_of_the_search(monkeypatch, capsys):
    """`test_known_moments` has a search with a body; three numbers reach the same argument."""

    def refused(curves, most, **options):
        assert options["moments"].tolist() == [3.0, 1.0, 3.2]
        body = Body(moments=(30, 10, 32))
        assert _states.of(options["moments"]).moments == pytest.approx(
            _states.of(body).moments, rel=1e-14
        )
        raise AttitudeError("the search of the test")

    monkeypatch.setattr(_spin_states, "spin_states", refused)
    options = ["--max-frequency", "0.5 /d", "--moments", "3.0, 1, 3.2"]
    assert cli.main(["invert", str(PHOTOMETRY), *options]) == 2
    assert "the search of the test" in capsys.readouterr().err


def test_rows_are_printed_before_errors_are_computed(monkeypatch, capsys):
    """Ctrl-C in the errors lost the answer; a rotation about one axis at rank 13 was not named."""

    def interrupted():
        raise KeyboardInterrupt

    rows = [
        SimpleNamespace(
            mode="PA" if k > 12 else "SAM", evidence=30.0 * k, P_phi=2e4, P_psi=4e4,
            pole=np.zeros(2), rms=0.02, relation="", _words_of_errors=interrupted,
        )
        for k in range(15)
    ]  # fmt: skip
    found = inversion.SpinStates(rows, "not solved", "A criterion.", ())
    monkeypatch.setattr(_spin_states, "spin_states", lambda *_, **__: found)
    assert cli.main(["invert", str(PHOTOMETRY), "--period", "5 d"]) == 130
    lines = capsys.readouterr().out.splitlines()
    assert "not solved: A criterion." in lines and lines[-1] == "and 4 more"
    assert [line[:6].split() for line in lines[-3:-1]] == [["9", "SAM"], ["13", "PA"]]


@pytest.mark.parametrize(
    ("options", "expected"), [([], ("1",)), (["--zero-points", "auto"], "auto")]
)
def test_zero_points_are_those_of_the_file(tmp_path, monkeypatch, capsys, options, expected):
    """A relative curve of a DAMIT file and a calibrated one: "auto" gave both one zero point."""

    def refused(curve, most, **others):
        raise AttitudeError(f"zero points {curve.zero_points!r}")

    monkeypatch.setattr(_spin_states, "spin_states", refused)
    path = tmp_path / "a.lc.txt"
    path.write_text(DAMIT.replace("2 1\n", "2 0\n").replace("1 0\n", "1 1\n"))
    assert cli.main(["invert", str(path), "--period", "5.7 h", *options]) == 2
    assert f"zero points {expected!r}" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("period", "wanted"),
    [
        ("5.7, 5.8 h", ["5.7 h", "5.8 h"]),
        ("5.7 h, 5.8 h", ["5.7 h", "5.8 h"]),
        ("5.7 h", "5.7 h"),
        ("5", "5"),
    ],
)
def test_a_common_unit_is_that_of_both_periods(monkeypatch, capsys, period, wanted):
    def refused(curves, most, **options):
        assert options["period"] == wanted
        raise AttitudeError("the search of the test")

    monkeypatch.setattr(_spin_states, "spin_states", refused)
    assert cli.main(["invert", str(PHOTOMETRY), "--period", period]) == 2
    assert "the search of the test" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("moments", "words"),
    [
        ("known", 'give "shape", "free", a number'),
        ("3, 2", "--moments has shape (2,)"),
        ("1, 1, 3", "moments"),
        ("nothing.toml", "nothing.toml"),
    ],
)
def test_moments_that_no_body_has(capsys, moments, words):
    options = ["--max-frequency", "0.5 /d", "--moments", moments]
    assert cli.main(["invert", str(PHOTOMETRY), *options]) == 2
    assert words in capsys.readouterr().err


def _unit(longitude, latitude):
    c = np.cos(latitude)
    return np.array([c * np.cos(longitude), c * np.sin(longitude), np.sin(latitude)])


def test_files_of_light_curves(tmp_path):
    curve = inversion.LightCurve.read(PHOTOMETRY)
    assert len(curve) == 370 and len(curve.sessions) == 27
    table = [line.split(",") for line in PHOTOMETRY.read_text().splitlines() if line[0] in "12"]
    listed = np.array([float(row[-1]) for row in table])
    order = np.argsort([float(row[1]) for row in table], kind="stable")
    assert np.degrees(curve.phase_angle) == pytest.approx(listed[order], abs=0.02)
    rows = np.column_stack(
        [2460000.5 + np.arange(30) / 10.0, 15.0 + np.arange(30) % 3, np.full(30, 0.02)]
    )
    rows = np.column_stack([rows, np.zeros(30), np.tile([1.0, 0.1, 0, 0.2, 0.1, 0], (30, 1))])
    plain = tmp_path / "plain.txt"
    np.savetxt(plain, rows, header="jd_tdb mag sigma session sun observer")
    read = inversion.LightCurve.read(plain, frame="ecliptic")
    assert len(read) == 30 and read.sun[0, 2] > 0.0


def test_rows_without_a_magnitude_are_noted(tmp_path):
    lines = PHOTOMETRY.read_text().splitlines()
    at = next(k for k, line in enumerate(lines) if line[0] in "12")
    row = lines[at].split(",")
    row[2] = "nan"
    lines[at] = ",".join(row)
    file = tmp_path / "curve.csv"
    file.write_text("\n".join(lines))
    curve = inversion.LightCurve.read(file)
    assert len(curve) == 369 and "1 of 370 rows has no magnitude." in curve.notes


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "holds no rows"),
        ("mag,sigma\n15,0.1\n", "no column of epochs"),
        ("utc,mag\n2026-01-01,bright\n", "line 2: the magnitude is 'bright', which is no number"),
        ("1 2 3\n4 5 6\n", "neither a date nor a Julian date"),
    ],
)
def test_files_that_cannot_be_read(tmp_path, capsys, text, words):
    file = tmp_path / "curve.csv"
    file.write_text(text)
    assert cli.main(["invert", str(file), "--max-frequency", "1 /d"]) == 2
    assert words in capsys.readouterr().err


def test_a_mission_against_observations(tmp_path, capsys):
    mission = tmp_path / "m.toml"
    mission.write_text(
        "observer.direction = [1, 0, 0]\nsun.direction = [1, 1, 0]\n"
        "[body]\nmoments = [1, 2, 3]\nrelative = true\n"
        '[spin]\nepoch = "2026-01-01"\nwxyz = [1, 0, 0, 0]\n'
        'angular_velocity = "0, 0, 1 deg/s"\n[shape]\nellipsoid = "3, 2, 1 m"\n'
        '[times]\nstart = "0"\nstop = "360 s"\nstep = "30 s"\n'
    )
    curve = tmp_path / "curve.csv"
    model = tmp_path / "model.csv"
    assert cli.main(["lightcurve", str(mission), "--output", str(model)]) == 0
    names, *rows = [row.split(",") for row in model.read_text().splitlines()]
    column = next(k for k, name in enumerate(names) if name.startswith("reduced_magnitude"))
    magnitude = [float(row[column]) for row in rows]
    lines = ["utc,mag,session"]
    lines += [
        f"{row[0]},{value + 3.0 + k % 2},{'ab'[k % 2]}"
        for k, (row, value) in enumerate(zip(rows, magnitude, strict=True))
    ]
    curve.write_text("\n".join(lines) + "\n")
    out, drawn = tmp_path / "out.csv", tmp_path / "out.png"
    given = ["lightcurve", str(mission), "--observed", str(curve), "--output", str(out)]
    assert cli.main([*given, "--figure", str(drawn)]) == 0
    text = capsys.readouterr().out
    assert "a: 7 points, zero point +3.000" in text and "rms of 13 points: 0.000" in text
    assert out.read_text().startswith("utc,session,filter,observed,computed,residual")
    assert drawn.stat().st_size > 1000


def test_many_points_are_averaged_with_a_note(tmp_path, capsys, monkeypatch):
    """A curve of more points than are searched: the averages are told with the verdict."""
    _smaller(monkeypatch, pairs=4, deep_starts=4, classes=4, convex=4, finals=2)
    count = 12_000
    t = 2460000.5 + np.linspace(0.0, 4.0, count)
    generator = np.random.default_rng(3)
    magnitude = 15.0 + 0.2 * np.cos(4.0 * np.pi * t / 0.4) + 0.1 * generator.normal(size=count)
    angle = 0.05 * (t - t[0])
    sun = [-np.cos(angle), -np.sin(angle), 0.0 * t]
    rows = np.stack([t, magnitude, 0.1 + 0.0 * t, *sun, -0.3 + 0.0 * t, 0.1 * angle, 0.0 * t])
    head = "jd_tdb,mag,sigma,sun_x,sun_y,sun_z,observer_x,observer_y,observer_z"
    path = tmp_path / "many.csv"
    np.savetxt(path, rows.T, fmt="%.7f", delimiter=",", header=head, comments="")
    options = ["--max-frequency", "6 /d", "--budget", "0.2 s"]
    assert cli.main(["invert", str(path), *options]) == 0
    text = capsys.readouterr().out
    assert f"LightCurve of many: {count} magnitudes" in text
    averaged = [line for line in text.splitlines() if f"{count} points were averaged to" in line]
    assert len(averaged) == 1 and 1000 < int(averaged[0].rstrip(".").split()[-1]) < 6000
