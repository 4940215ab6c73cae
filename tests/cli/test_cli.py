"""The command line: good input gives tables and texts, bad input exit code 2 and one sentence."""

import csv
import io
import os
import re
import signal
import subprocess
import sys
import time
import warnings
from pathlib import Path

import numpy as np
import pytest

import attitude
from attitude import Body, FreeRotation, Spin, cli, epochs
from attitude.cli import _options, _output
from attitude.epochs import _ccsds
from attitude.formats import detect, spin_file
from attitude.motions import _description
from tests.support.places import ROOT

TOUTATIS = str(ROOT / "data" / "spin" / "toutatis.toml")
PAPER = str(ROOT / "data" / "spin" / "paper.toml")
ENVISAT = str(ROOT / "data" / "spin" / "envisat.toml")
PASS = str(ROOT / "data" / "mission" / "envisat-pass.toml")


@pytest.fixture
def attitude_command(capsys):
    def run(*arguments):
        code = cli.main([str(each) for each in arguments])
        captured = capsys.readouterr()
        return code, captured.out, captured.err

    return run


def started(*arguments, **settings):
    return subprocess.Popen(
        [sys.executable, "-m", "attitude", *arguments],
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        stderr=subprocess.PIPE,
        text=True,
        **settings,
    )


def columns(text):
    rows = list(csv.reader(io.StringIO(text)))
    return dict(zip(rows[0], zip(*rows[1:], strict=True), strict=True))


# propagate ----------------------------------------------------------------------------------------


def test_rows_are_those_of_the_motion(attitude_command):
    code, out, err = attitude_command(
        "propagate", TOUTATIS, "--start", "0", "--stop", "3 d", "--step", "6 h", "--rates"
    )
    assert (code, err) == (0, "")
    found = columns(out)
    seconds = np.array(found["tdb_seconds"], dtype=float)
    days = [f"1992-11-{9 + k // 4:02d}T{('17', '23', '05', '11')[k % 4]}" for k in range(13)]
    days = [each if "T17" in each or "T23" in each else _next_day(each) for each in days]
    assert found["utc"] == tuple(f"{each}:49:47" for each in days)  # six hours of UTC
    # TDB runs unevenly against UTC, by microseconds in days.
    assert np.max(np.abs(seconds - 21600.0 * np.arange(13))) < 1e-4
    history = spin_file.read(TOUTATIS).motion.at(list(found["utc"]))
    for k, name in enumerate("wxyz"):
        column = np.array(found[name], dtype=float)
        assert column == pytest.approx(history.wxyz[:, k], abs=4e-16)
    for k, name in enumerate(("omega_x", "omega_y", "omega_z")):
        column = np.array(found[name], dtype=float)
        assert column == pytest.approx(history.angular_velocity[:, k], rel=1e-14)
    # The dates say the same epochs, to the nanosecond.
    since = epochs.seconds_since(history.epoch, list(found["utc"]))
    assert np.max(np.abs(since[0] - seconds + since[1])) <= 0.5001e-9


def _next_day(text):
    return f"{text[:8]}{int(text[8:10]) + 1:02d}{text[10:]}"


def test_standard_deviations(attitude_command, tmp_path):
    spin_text = Path(PAPER).read_text() + '\n[errors]\nattitude = "1 deg"\nmoments = 0.01\n'
    (tmp_path / "a.toml").write_text(spin_text)
    options = ("propagate", tmp_path / "a.toml", "--stop", "20", "--step", "2", "--sigma")
    code, out, err = attitude_command(*options, "--rates")
    assert (code, err) == (0, "")
    found = columns(out)
    motion = spin_file.read(tmp_path / "a.toml").motion
    history = motion.at(np.array(found["tdb_seconds"], dtype=float))
    for k, axis in enumerate("xyz"):
        sigma = np.array(found[f"sigma_{axis}"], dtype=float)
        # At the epochs in two doubles, of which the column holds one: 1e-16 of a rate of 15 rad/s.
        assert sigma == pytest.approx(history.sigma[:, k], rel=1e-13)
        of_rate = np.array(found[f"sigma_omega_{axis}"], dtype=float)
        wanted = np.sqrt(history.covariance[:, 3 + k, 3 + k])
        assert of_rate == pytest.approx(wanted, rel=1e-13)
        assert sigma[0] == pytest.approx(np.radians(1.0), rel=1e-12)
    assert sigma[-1] > np.radians(1.001)
    _, out, _ = attitude_command(*options)
    assert list(columns(out))[-4:] == ["z", "sigma_x", "sigma_y", "sigma_z"]
    from astropy.table import QTable

    attitude_command(*options, "--rates", "--output", tmp_path / "a.ecsv")
    table = QTable.read(tmp_path / "a.ecsv")
    assert np.array_equal(table["sigma_z"].to_value("rad"), sigma)
    assert str(table["sigma_omega_x"].unit) == "rad / s"
    code, out, err = attitude_command("propagate", PAPER, "--stop", "1", "--step", "1", "--sigma")
    assert (code, out) == (2, "")
    assert "paper.toml has no section [errors], from which --sigma follows" in err


def test_dates_are_stepped_in_utc(attitude_command):
    code, out, _ = attitude_command(
        "propagate", PAPER, "--start", "2016-12-31T23:59:58.5", "--stop", "2017-01-01T00:00:01",
        "--step", "500 ms",
    )  # fmt: skip
    assert code == 0
    julian = ("--start", "2016-12-31T23:59:58.5", "--stop", "MJD 57754.000011575 UTC")
    assert attitude_command("propagate", PAPER, *julian, "--step", "500 ms")[1] == out
    found = columns(out)
    assert found["utc"] == (
        "2016-12-31T23:59:58.500", "2016-12-31T23:59:59.000", "2016-12-31T23:59:59.500",
        "2016-12-31T23:59:60.000", "2016-12-31T23:59:60.500",
        "2017-01-01T00:00:00.000", "2017-01-01T00:00:00.500", "2017-01-01T00:00:01.000",
    )  # fmt: skip
    motion = spin_file.read(PAPER).motion
    wanted = epochs.seconds_since(motion.spin.epoch, list(found["utc"]))
    seconds = np.array(found["tdb_seconds"], dtype=float)
    assert np.max(np.abs(seconds - wanted[0] - wanted[1])) < 1e-7  # one double, at 5e8 s
    # The attitudes are those of the dates, not of the rounded column: 5e-14 s times 15 rad/s.
    wxyz = np.array([found[name] for name in "wxyz"], dtype=float).T
    assert np.max(np.abs(wxyz - motion.at(list(found["utc"])).wxyz)) < 1e-12


def test_dates_start_from_the_epoch_by_default(attitude_command):
    _, out, _ = attitude_command(
        "propagate", TOUTATIS, "--stop", "1992-11-12T17:49:47", "--step", "1 d"
    )
    found = columns(out)
    assert found["utc"] == tuple(f"1992-11-{day:02d}T17:49:47" for day in (9, 10, 11, 12))
    assert found["tdb_seconds"][0] == "0.0"


def test_time_runs_backwards(attitude_command):
    for options in (("--start", "0", "--stop", "-2 h"), ("--start", "0", "--stop", "-2h")):
        code, out, _ = attitude_command("propagate", TOUTATIS, *options, "--step", "-1h")
        assert code == 0
        assert columns(out)["utc"] == tuple(f"1992-11-09T{hour}:49:47" for hour in (17, 16, 15))


def test_one_row_and_a_last_step_that_does_not_fit(attitude_command):
    _, out, _ = attitude_command("propagate", PAPER, "--stop", "0", "--step", "1")
    assert len(out.splitlines()) == 2
    for stop in ("0.35", "0.3"):
        _, out, _ = attitude_command("propagate", ENVISAT, "--stop", stop, "--step", "0.1")
        assert [each[-6:] for each in columns(out)["utc"]] == [f"00.{k}00" for k in range(4)]


def test_blocks_make_no_difference(monkeypatch, attitude_command):
    options = ("propagate", TOUTATIS, "--stop", "1993-01-01", "--step", "1 h", "--rates")
    whole = attitude_command(*options)[1]
    monkeypatch.setattr("attitude.cli.propagate._BLOCK", 7)
    parts = attitude_command(*options)[1]
    assert parts.splitlines()[0] == whole.splitlines()[0]
    assert columns(parts)["utc"] == columns(whole)["utc"]
    for name in list(columns(whole))[1:]:
        # Of few epochs TDB - TT is made in another way, to 5e-15 s: 1e-20 of a rate here.
        a, b = (np.array(columns(text)[name], dtype=float) for text in (parts, whole))
        assert a == pytest.approx(b, rel=1e-14, abs=1e-15 if name in "wxyz" else 1e-19)


def test_files(tmp_path, attitude_command):
    options = ("propagate", ENVISAT, "--stop", "1 h", "--step", "10 s", "--rates")
    _, out, _ = attitude_command(*options)
    assert attitude_command(*options, "--output", tmp_path / "a.csv") == (0, "", "")
    assert (tmp_path / "a.csv").read_text() == out
    assert attitude_command(*options, "--output", tmp_path / "a.ecsv") == (0, "", "")
    assert sorted(os.listdir(tmp_path)) == ["a.csv", "a.ecsv"]

    from astropy.table import QTable

    found = QTable.read(tmp_path / "a.ecsv")
    assert found["utc"].scale == "utc"
    assert found["tdb_seconds"].unit == "s"
    assert found["omega_z"].unit == "rad/s"
    assert found.meta["frame"] == "ICRF"
    assert found["w"].tolist() == np.array(columns(out)["w"], dtype=float).tolist()
    assert np.max(np.abs((found["utc"] - found["utc"][0]).sec - found["tdb_seconds"].value)) < 1e-5


def test_a_failed_table_leaves_nothing(tmp_path, monkeypatch, attitude_command):
    (tmp_path / "a.csv").write_text("old")
    written = []

    def full(*_, **__):
        written.append(1)
        if len(written) > 2:
            raise OSError(28, "No space left on device")
        return "row\n"

    monkeypatch.setattr(_output, "rows", full)
    code, _, err = attitude_command(
        "propagate", PAPER, "--stop", "1e6", "--step", "1", "--output", tmp_path / "a.csv"
    )
    assert code == 2
    assert "cannot be written: No space left on device" in err
    assert (tmp_path / "a.csv").read_text() == "old"
    assert os.listdir(tmp_path) == ["a.csv"]


GO = ("propagate", TOUTATIS)
BAD = [
    ((), "give a command: propagate, "),
    (("propagat",), "there is no command 'propagat'; did you mean propagate?"),
    (("xyz",), "there is no command 'xyz'; give one of propagate, "),
    (("--verbose",), "not known|required"),
    (("describe",), "the following arguments are required: "),
    (("describe", "none.toml"), "none.toml: cannot be read"),
    (("describe", "none.aem"), "'none.aem' cannot be read: No such file"),
    (("view", "none.aem"), "'none.aem' cannot be read: No such file"),
    (("view", "none"), "the catalogue has no 'none'"),
    (("describe", TOUTATIS, "--rates"), "--rates is not known"),
    (("describe", TOUTATIS, " "), "an empty argument is not known"),
    ((*GO, "--stop", "1", "--step", "1", "--output", ""), "--output is an empty text"),
    ((*GO, "--step", "1"), "required: --stop"),
    ((*GO, "--stop", "1"), "required: --step"),
    ((*GO, "--stop", "1", "--stepp", "1", "--step", "1"), "did you mean --step"),
    ((*GO, "--stop", "1", "--step", "0"), "--step is zero"),
    ((*GO, "--stop", "1", "--step", "0 h"), "--step is zero"),
    ((*GO, "--stop", "1", "--step", "1e-10"), "shortest"),
    ((*GO, "--stop", "1", "--step", "-1"), "lies after --start 0, but --step is -1"),
    ((*GO, "--stop", "-1", "--step", "1"), "lies before --start 0"),
    (
        (*GO, "--start", "1992-12-02", "--stop", "3 d", "--step", "1 d"),
        "lies before --start 1992-12-02 (3 d counts from the epoch, 1992-11-09T17:49:47",
    ),
    ((*GO, "--stop", "1 d", "--step", "1e-8 s"), "more than 10000000000"),
    ((*GO, "--stop", "1", "--step", "1 m"), "--step is '1 m'; give a time, like"),
    ((*GO, "--stop", "1", "--step", "1 hor"), "not a unit that astropy knows"),
    ((*GO, "--stop", "1", "--step", "1, 2 h"), "give one time"),
    ((*GO, "--stop", "1", "--step", "fast"), "--step is 'fast', which is not a number"),
    ((*GO, "--stop", "1", "--step", "nan"), "--step is 'nan', which is not a number"),
    ((*GO, "--stop", "soon", "--step", "1"), "--stop is 'soon'; give a date in UTC"),
    ((*GO, "--stop", "1992-13-01", "--step", "1 d"), "a date that does not exist"),
    ((*GO, "--start", "1992-11-31", "--stop", "1", "--step", "1"), "--start is '19"),
    ((*GO, "--stop", "1e5 yr", "--step", "1 yr"), "out of the years 0001 to 9999"),
    ((*GO, "--stop", "1e400", "--step", "1e399"), "out of the years 0001 to 9999"),
    ((*GO, "--stop", "1e99999999", "--step", "1"), "out of the years 0001 to 9999"),
    ((*GO, "--stop", "1", "--step", "1e99999999"), "out of the years 0001 to 9999"),
    (("propagate", PASS, "--stop", "3", "--step", "1", "--moments", "1"), "--moments can complete"),
    (("view", PASS, "--output", "x.glb", "--epoch", "2000-01-01"), "--epoch can complete an entry"),
    (("geometry", "--list", "--output", "y.csv"), "--output has no meaning for --list"),
    (("view", "toutatis", "--unit", "furlong"), "--unit has no meaning for a view without --shape"),
    (("view", "toutatis", "--frames", "3"), "--frames has no meaning for a view without --animate"),
    (("view", TOUTATIS, "--body", "foo"), "--body has no meaning for"),
    (("convert", "toutatis", "x.aem", "--object", "foo"), "--object has no meaning for toutatis"),
    (("convert", TOUTATIS, "x.aem", "--segment", "0"), "--segment has no meaning for"),
    ((*GO, "--stop", "1", "--step", "1", "--output", "a.xls"), "ends in .csv or"),
    ((*GO, "--stop", "1", "--step", "1", "--output", "csv"), "ends in .csv or"),
    ((*GO, "--stop", "1", "--step", "1", "--output", "a.aem"), "`attitude convert` writes AEM"),
    ((*GO, "--stop", "1", "--step", "1", "--output", "/no/a.csv"), "No such file"),
]  # fmt: skip


@pytest.mark.parametrize(("arguments", "message"), BAD, ids=[" ".join(a[-4:]) for a, _ in BAD])
def test_bad_input_is_a_sentence(arguments, message, attitude_command, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    code, out, err = attitude_command(*arguments)
    assert (code, out) == (2, "")
    assert err.startswith("attitude: ")
    assert err.count("\n") == 1
    assert any(part in err for part in message.split("|")), err
    assert os.listdir(tmp_path) == []


def test_a_bad_spin_file(tmp_path, attitude_command):
    (tmp_path / "a.toml").write_text("[body]\nmoments = [1, 2, 3]\n[spin]\nepoc = '2026-01-01'\n")
    code, out, err = attitude_command("describe", tmp_path / "a.toml")
    assert (code, out) == (2, "")
    assert "a.toml: [spin] has a key 'epoc' that is not known; did you mean 'epoch'?" in err


def test_out_of_reach_is_said_before_a_row(tmp_path, attitude_command):
    spin_file.write(
        tmp_path / "fast.toml",
        FreeRotation(
            Body(moments=(1, 2, 3)),
            Spin(epoch="2026-01-01", wxyz=(1, 0, 0, 0), angular_velocity=(1e9, 1e9, 1e9)),
        ),
    )
    code, out, err = attitude_command(
        "propagate", tmp_path / "fast.toml", "--stop", "100 yr", "--step", "1 yr"
    )
    assert (code, out) == (2, "")
    assert err.startswith("attitude: ")


# describe -----------------------------------------------------------------------------------------


def test_letters_that_stdout_cannot_encode_are_escaped(tmp_path, monkeypatch):
    path = tmp_path / "a.toml"
    spin_file.write(path, spin_file.read(PAPER).motion, name="\u014ctani")
    stdout = io.TextIOWrapper(io.BytesIO(), encoding="cp1252")
    monkeypatch.setattr(sys, "stdout", stdout)
    assert cli.main(["describe", str(path)]) == 0
    assert stdout.buffer.getvalue().startswith(rb"\u014ctani")


def test_describe_toutatis(attitude_command):
    code, out, err = attitude_command("describe", TOUTATIS)
    assert (code, err) == (0, "")
    assert out.startswith("(4179) Toutatis\nTakahashi, Busch & Scheeres 2013")
    for words in (
        "Long-axis mode (LAM)",
        "1992-11-09T17:49:47 UTC",
        "463841.019 s = 128.844728 h = 5.36853031 d",
        "= 7.41165227 d",
        "RA 152.366290 deg, Dec -47.979950 deg",
        "longitude 181.029574 deg, latitude -53.620593 deg",
        "(relative)",
        "rad/s times the unit of the moments",
        "-0.840093: on the long-axis side",
    ):
        assert words in out


def test_describe_the_others(attitude_command):
    _, out, _ = attitude_command("describe", ENVISAT)
    assert "ASSUMED STATE" in out
    assert "Short-axis mode" in out
    assert " kg m2/s\n" in out
    assert "140.515232 J" in out
    _, out, _ = attitude_command("describe", PAPER)
    assert "0.000616903: on the short-axis side" in out
    assert "2268 J" in out


def test_numbers_may_be_parted_by_spaces(attitude_command):
    """Also negative ones, and each the same as with commas."""
    rest = ("--phi0", 0, "--psi0", "-3 deg", "--epoch", "2008-10-07")
    moments = "--moments", 0.4, 0.9, 1
    code, apart, _ = attitude_command(
        "describe", "2008 TC3", *moments, "--pole", -10, -20.5, "deg", *rest
    )
    assert code == 0
    assert "longitude 350.000000 deg, latitude -20.500000 deg" in apart
    joined = "--moments", "0.4, 0.9, 1", "--pole", "-10, -20.5 deg"
    assert attitude_command("describe", "2008 TC3", *joined, *rest)[1] == apart


@pytest.mark.parametrize(
    ("options", "same"),
    [
        (("--phi0", "-1e-1"), ("--phi0", "-0.1 rad")),
        (("--psi0", "-3deg"), ("--psi0", "-3 deg")),
        (("--pole", "250", "-75deg"), ("--pole", "250, -75 deg")),
        (("--P-psi", "-1e5"), ("--P-psi", "-100000 s")),
    ],
)
def test_numbers_may_be_negative_in_any_spelling(attitude_command, options, same):
    rest = "apophis", "--phi0", "1", "--psi0", "2", "--epoch", "2012-12-23"
    assert attitude_command("describe", *rest, *options) == attitude_command(
        "describe", *rest, *same
    )
    assert "required" not in attitude_command("describe", *rest, *options)[2]


@pytest.mark.parametrize(
    ("rates", "code", "words"), [("1e200", 2, "beyond the range of doubles"), ("1e-200", 0, "")]
)
def test_extreme_rates_are_described_or_refused(tmp_path, attitude_command, rates, code, words):
    text = Path(PAPER).read_text()
    text = re.sub(r"angular_velocity = .*", f"angular_velocity = [{rates}, {rates}, 0]", text)
    (tmp_path / "a.toml").write_text(text)
    found, out, err = attitude_command("describe", tmp_path / "a.toml")
    assert found == code and words in err and "inf J" not in out and "  0 deg/s" not in out


def test_the_assumed_state_of_envisat_is_what_its_note_says():
    found = spin_file.read(ENVISAT)
    rates = found.body.rates_about_principal_axes(found.spin.angular_velocity)[:, 0]
    wanted = np.radians(360 / 134.74) * np.array([0.02, 0.02, 1.0])
    assert rates == pytest.approx(wanted, rel=1e-13)  # printed with 16 digits


@pytest.mark.parametrize("path", [TOUTATIS, PAPER, ENVISAT])
def test_nutation_is_what_the_motion_does(path):
    motion = spin_file.read(path).motion
    about = np.argmin if motion.circulates_about == "long" else np.argmax
    axis = motion.body.principal_axes[:, about(motion.body.moments)]
    t = np.linspace(0.0, motion.period_psi, 20001)
    along = motion.at(t).body_to_inertial(axis) @ motion.momentum / np.linalg.norm(motion.momentum)
    angles = np.arccos(np.abs(along))
    low, high = re.search(
        r"nutation +(\S+) to (\S+) deg", _description.description(motion)
    ).groups()
    # Printed with six digits; sampled to 1e-4 of the period, in second order 1e-7 rad.
    found = np.degrees([angles.min(), angles.max()])
    assert [float(low), float(high)] == pytest.approx(found, rel=5e-6, abs=1e-5)


def motion_of(moments, rates):
    spin = Spin(epoch="2026-01-01", wxyz=(1, 0, 0, 0), angular_velocity=rates)
    return FreeRotation(Body(moments=moments), spin)


@pytest.mark.parametrize(
    ("moments", "rates", "wanted"),
    [
        ((1, 2, 3), (0, 0, 0), ["At rest"]),
        ((2, 2, 2), (1, 1, 1), ["three equal moments", "period            3.62759873 s"]),
        ((1, 2, 3), (0, 0, 1), ["about a principal axis", "Dec +90.000000"]),
        ((1, 2, 3), (0, 1, 0), ["about the middle axis: any disturbance", "6.28318531 s"]),
        ((2, 2, 3), (0.1, 0, 1), ["symmetric body", "12.5663706 s", "3.81407 deg between"]),
        ((2, 5, 6), (6, 2, 6), ["On the separatrix", "infinite"]),
        ((1, 2, 3), (1e-20, 1, 0), ["within rounding", "rotation about a principal axis"]),
        ((1, 2, 2 + 4e-16), (1, 1e-3, 0), ["within rounding   a symmetric body"]),
        ((1, 2, 2 + 4e-16), (0, 1e-17, 1), ["none within rounding between", "h\n  period phi"]),
    ],
)
def test_every_mode_has_its_words(moments, rates, wanted):
    text = str(motion_of(moments, rates))
    for words in wanted:
        assert words in text
    assert "nan" not in text


# The command itself -------------------------------------------------------------------------------


def test_help_and_version(attitude_command):
    for option in ("--version", "-V"):
        assert attitude_command(option) == (0, f"attitude {attitude.__version__}\n", "")
    code, out, _ = attitude_command("--help")
    assert code == 0
    assert "write a table of attitudes" in out
    assert "example:" in out
    for command in cli.COMMANDS:
        code, out, _ = attitude_command(command, "--help")
        assert code == 0
        assert f"usage: attitude {command}" in out
        assert command not in ("propagate", "describe") or "example:" in out


def test_a_closed_standard_output_is_said(attitude_command, tmp_path, monkeypatch):
    monkeypatch.setattr("sys.stdout", None)
    options = "propagate", PAPER, "--stop", "2", "--step", "1"
    code, _, err = attitude_command(*options)
    assert code == 2 and "standard output is closed; open it, or give --output" in err
    assert attitude_command(*options, "--output", tmp_path / "a.csv")[0] == 0
    assert attitude_command("describe", PAPER)[0] == 2


def test_overflows_are_one_sentence(attitude_command, monkeypatch):
    def overflowing(arguments, **options):
        for _ in range(2):
            np.array([1e200]) ** 2
        np.array([1e200]).dot([1e200])

    monkeypatch.setattr("attitude.cli.describe.run", overflowing)
    with warnings.catch_warnings():
        warnings.simplefilter("default")
        code, _, err = attitude_command("describe", PAPER)
    assert code == 0 and err.count("\n") == 1
    assert err.startswith("attitude: warning: numbers leave the range of doubles (overflow")


# Files that are written ---------------------------------------------------------------------------


@pytest.fixture
def curve(tmp_path, monkeypatch):
    """A light curve of 6 h in the working directory."""
    monkeypatch.chdir(tmp_path)
    turns = 4 * np.arange(100) / 50
    rows = [f"{2459000.5 + k / 4},{15 + np.cos(2 * np.pi * k):.3f},10,5,1.2" for k in turns]
    Path("curve.csv").write_text("\n".join(["jd,mag,ra,dec,delta", *rows]))
    os.link("curve.csv", "same.csv")
    return Path("curve.csv")


@pytest.mark.parametrize(
    ("command", "words"),
    [
        (("fold", "--period", "6 h", "--output", "./curve.csv"), "--output './curve.csv' is also"),
        (("fold", "--period", "6 h", "--output", "same.csv"), "--output 'same.csv' is also"),
        (("fold", "--period", "6 h", "--output", "a.csv", "--figure", "no/f.png"), "no/f.png"),
        (("periods", "--min", "2 h", "--max", "9 h", "--figure", "curve.csv"), "is also"),
        (("periods", "--max", "9 h", "--method", "additive"), "two series; give --two too"),
        (("periods", "--max", "9 h", "--method", "pdm", "--two"), "leave out --two"),
        (("periods", "--max", "9 h", "--bootstrap", "1"), "--bootstrap is 1; give"),
        (("fold", "--period", "1, 2, 3 h"), "give one time or two"),
        (("invert", "--zero-points", "no"), "give auto, shared, free"),
        (("invert", "--period", "6 h", "--output", "inv.csv"), "ends in .toml"),
        (("invert", "--period", "6 h", "--output", "no/inv.toml"), "cannot be written"),
        (("invert", "--period", "6 h", "--frame", "foo"), "frame is 'foo'"),
        (("invert", "--period", "6 h", "--unit", "km"), "--unit has no meaning"),
    ],
)
def test_files_are_checked_before_the_work(attitude_command, curve, command, words):
    before, names = curve.read_text(), sorted(os.listdir())
    code, out, err = attitude_command(command[0], curve, *command[1:])
    assert (code, out) == (2, "") and words in err and err.count("\n") == 1
    assert curve.read_text() == before and sorted(os.listdir()) == names


@pytest.mark.parametrize(
    "command",
    [
        ("fold", "curve.csv", "--period", "6 h", "--output", "old.csv"),
        ("fold", "curve.csv", "--period", "6 h", "--figure", "old.svg"),
        ("periods", "curve.csv", "--min", "2 h", "--max", "9 h", "--figure", "old.png"),
        ("plot", "toutatis", "--output", "old.png"),
    ],
)
def test_a_full_disk_leaves_the_old_file(attitude_command, curve, monkeypatch, command):
    def full(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("os.replace", full)
    Path(command[-1]).write_text("old")
    names = sorted(os.listdir())
    code, _, err = attitude_command(*command)
    assert code == 2 and "cannot be written: No space left on device. Give a file" in err
    assert Path(command[-1]).read_text() == "old" and sorted(os.listdir()) == names


def test_a_closed_pipe_is_silent():
    running = started("propagate", PAPER, "--stop", "1e9", "--step", "1", stdout=subprocess.PIPE)
    assert running.stdout.readline().startswith("utc,tdb_seconds,w,x,y,z")
    assert running.stdout.readline().startswith("2000-01-01T11:58:55.816")
    running.stdout.close()
    assert running.stderr.read() == ""
    running.stderr.close()
    assert running.wait(60) == 141


def test_files_are_written_where_the_reader_closes_the_pipe(curve, monkeypatch):
    monkeypatch.setenv("PYTHONUNBUFFERED", "1")
    options = ["--period", "6 h", "--output", "f.csv", "--figure", "f.png"]
    running = started("fold", str(curve), *options, stdout=subprocess.PIPE)
    running.stdout.close()
    with running.stderr as errors:
        errors.read()
    assert running.wait(120) == 141
    assert Path("f.csv").stat().st_size > 1000 and Path("f.png").stat().st_size > 10_000


@pytest.mark.skipif(os.name == "nt", reason="Ctrl-C is another thing there")
def test_ctrl_c_is_silent_and_leaves_nothing(tmp_path):
    output = tmp_path / "a.csv"
    running = started("propagate", PAPER, "--stop", "1e9", "--step", "1", "--output", str(output))
    deadline = time.monotonic() + 120
    while not any(each.stat().st_size > 0 for each in tmp_path.iterdir()):
        assert time.monotonic() < deadline and running.poll() is None
        time.sleep(0.05)
    running.send_signal(signal.SIGINT)
    assert running.wait(60) == 130
    assert running.stderr.read() == ""
    running.stderr.close()
    assert os.listdir(tmp_path) == []


def test_bad_input_of_a_real_process():
    running = started("describe", "none.toml", stdout=subprocess.PIPE)
    out, err = running.communicate(timeout=120)
    assert (running.returncode, out) == (2, "")
    assert err == (
        "attitude: none.toml: cannot be read (No such file or directory); give the name of a spin "
        "file.\n"
    )


def test_parsing_needs_nothing_heavy():
    code = (
        "import sys; from attitude import cli; cli.main(['propagate', '--help']);"
        "print([m for m in ('numba', 'astropy', 'scipy', 'matplotlib') if m in sys.modules])"
    )
    found = subprocess.run(
        [sys.executable, "-c", code],
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        capture_output=True,
        text=True,
        check=True,
    )
    assert found.stdout.splitlines()[-1] == "[]"


# Grids and dates ----------------------------------------------------------------------------------


def test_a_far_grid_stays_on_its_steps():
    # 1e9 steps of a tenth of a second: the last is at 1e8 s, not 5e-9 s beside it.
    found = _options.grid(epochs.instant("2000-01-01"), "0", "1e8", "0.1 s", is_tdb=True)
    assert found.count == 10**9 + 1
    hi, lo = found.block(found.count - 1, 5)[:2]
    assert hi.tolist() == [1e8]
    assert abs(lo[0]) < 1e-24


def test_dates_are_those_of_instants():
    motion = spin_file.read(TOUTATIS).motion
    epoch = motion.spin.epoch
    steps = _options.grid(epoch, "1999-12-31T23:59:59.999999999", "2000-02-01", "34567.891 s")
    rows = _output.rows(steps, motion, 0, steps.count, rates=False).splitlines()
    found = [epochs.instant(row.split(",")[0]) for row in rows]
    hi, lo = steps.block(0, steps.count)
    assert len(rows) == steps.count == 78
    for instant, a, b in zip(found, hi, lo, strict=True):
        since = instant.after(-epoch.seconds, -epoch.low)
        assert abs((since.seconds - a) + (since.low - b)) <= 0.5001e-9


def test_steps_of_utc_are_equal_in_utc():
    # TDB runs unevenly against UTC, by milliseconds in a year; the dates do not show it.
    found = _options.grid(epochs.instant("2020-01-01"), "2020-01-01", "2021-01-01", "1 d")
    assert (found.count, found.digits) == (367, 0)
    hi, lo = found.block(0, 400)
    drift = hi - 86400.0 * np.arange(367) + lo
    assert 2e-3 < np.ptp(drift) < 4e-3


@pytest.mark.parametrize(
    ("start", "stop", "step"),
    [
        ("1968-01-31T12:00:00", "1968-02-03", "12 h"),
        ("1965-01-01T00:00:00", "1965-01-05", "1 d"),
        ("1973-01-01T00:00:00", "1971-06-01", "-100 d"),
    ],
)
def test_dates_before_1972_are_those_of_the_attitudes(start, stop, step):
    """Seconds of UTC were longer than those of the steps, and days had jumps of 0.1 s."""
    motion = spin_file.read(TOUTATIS).motion
    steps = _options.grid(motion.epoch, start, stop, step)
    rows = _output.rows(steps, motion, 0, steps.count, rates=False).splitlines()
    assert len(rows) >= 5 and rows[0].startswith(f"{start}.000000000,")
    for row in rows:
        date, seconds = row.split(",")[:2]
        found = epochs.seconds_since(motion.epoch, date)
        assert found[0] + found[1] == pytest.approx(float(seconds), abs=1e-6)


def test_steps_are_in_the_scale_of_the_start():
    epoch = epochs.instant("2020-01-01")
    for start, is_tdb in (("0", False), ("2020-01-01", False), ("2020-01-01 TDB", True)):
        found = _options.grid(epoch, start, "365 d", "1 d")
        hi, lo = found.block(0, 400)
        drift = np.ptp(hi - hi[0] - 86400.0 * np.arange(len(hi)) + lo)
        assert drift < 1e-9 if is_tdb else 2e-3 < drift < 4e-3


def test_dates_of_messages_have_no_digits_without_meaning(attitude_command, tmp_path):
    """A stop of an hour is an hour of UTC; TDB files step in TDB; odd epochs keep 12 digits."""
    name = tmp_path / "a.aem"

    def dates(*options):
        code, _, err = attitude_command("convert", TOUTATIS, name, *options)
        assert code == 0, err
        return re.findall(r"^(?:ST\w+_TIME = )?(\d{4}-\S+)", name.read_text(), re.M)

    found = dates("--stop", "1 h", "--step", "20 min")
    assert found[2:] == [
        f"1992-11-09T{each}:47.000" for each in ("17:49", "18:09", "18:29", "18:49")
    ]
    found = dates("--stop", "1 h", "--step", "20 min", "--time-system", "TDB")
    assert len(found[2]) == 32 and {each[17:] for each in found} == {found[2][17:]}
    found = dates("--stop", "1.5 s", "--step", "0.25 s")
    assert [each[-6:] for each in found[-3:]] == ["48.000", "48.250", "48.500"]
    # What conversions leave, some 1e-12 s, is not printed; more is.
    epoch = spin_file.read(TOUTATIS).motion.epoch
    near = _ccsds.texts(epoch, np.zeros(2), np.array([4e-12, -3e-12]), "utc")
    assert [each[-6:] for each in near] == ["47.000", "47.000"]
    far = _ccsds.texts(epoch, np.array([2e-11]), np.array([0.0]), "utc")
    assert far[0].endswith("47.000000000020")


# Names of the catalogue ---------------------------------------------------------------------------


def test_catalogue_names_are_motions(attitude_command, tmp_path):
    """propagate and convert take a name as they take the spin file with the same numbers."""
    options = ("--stop", "1 d", "--step", "12 h")
    code, out, _ = attitude_command("propagate", "4179 Toutatis", *options)
    assert code == 0
    _, of_file, _ = attitude_command("propagate", TOUTATIS, *options)
    mine, theirs = ([row.split(",") for row in text.splitlines()[1:]] for text in (out, of_file))
    assert [row[0] for row in mine] == [row[0] for row in theirs] and len(mine) == 3
    numbers = [np.array([row[1:] for row in rows], float) for rows in (mine, theirs)]
    np.testing.assert_allclose(*numbers, rtol=0.0, atol=1e-14)
    target = tmp_path / "x.aem"
    code, _, err = attitude_command("convert", "toutatis", target, *options)
    assert code == 0, err
    assert "Takahashi" in target.read_text()
    code, _, err = attitude_command("propagate", "17 Thetis", *options)
    assert code == 2 and "the catalogue has no '17 Thetis'" in err


def test_describe_says_which_numbers_were_given(attitude_command):
    given = ("--phi0", "10 deg", "--psi0", "3 deg", "--epoch", "2012-12-23", "--P-psi", "260 h")
    code, out, _ = attitude_command("describe", "apophis", *given)
    assert code == 0
    first = out.splitlines()[0]
    assert first == "99942 Apophis (2022), with --P-psi, --phi0, --psi0, --epoch as given here"


# dates of files -----------------------------------------------------------------------------------


@pytest.mark.parametrize("density", [("--step", "20 min"), ("--tolerance", "1e-5")])
@pytest.mark.parametrize("start", ["2026-03-01T00:00:00", "2026-03-01T00:00:00.25"])
def test_a_file_starts_and_stops_at_the_dates_given(density, start, tmp_path, attitude_command):
    """Steps are seconds of UTC, the scale of the start: no 00.000000000005, no 46.999999306408."""
    file = tmp_path / "a.aem"
    stop = start.replace("T00", "T01")
    words = "convert", PAPER, file, "--start", start, "--stop", stop, *density
    assert attitude_command(*words)[0] == 0
    text = file.read_text()
    for name, date in (("START_TIME", start), ("STOP_TIME", stop)):
        written = re.search(rf"^{name} = (\S+)$", text, re.M).group(1)
        assert re.fullmatch(re.escape(date) + r"(\.?0*)", written), written
    rows = re.findall(r"^(\d{4}-\d\d-\d\dT\S+) [-\d]", text, re.M)
    assert rows[0].startswith(start) and rows[-1].startswith(stop)


@pytest.mark.parametrize("scale", ["TDB", ""])
def test_dates_of_a_file_return_the_same_doubles(scale, tmp_path, attitude_command):
    """Equal steps in the scale of the start, to 1e-11 s through text and back."""
    file = tmp_path / "a.aem"
    first, last = (f"2026-03-01T0{hour}:00:00 {scale}".strip() for hour in (0, 1))
    words = "convert", PAPER, file, "--start", first, "--stop", last, "--step", "7.3 s"
    assert attitude_command(*words)[0] == 0
    table = detect.read(file)
    begin = epochs.instant(first)
    offset = (begin.seconds - table.epoch.seconds) + (begin.low - table.epoch.low)
    seconds = (table.seconds - offset) + table.low
    assert len(seconds) == 494
    # A day of TDB differs from one of UTC by 3e-5 s at most: 4e-10 of a span.
    expected = 7.3 * np.arange(494)
    bound = 2e-12 if scale == "TDB" else 5e-10 * 3600.0
    assert np.max(np.abs(seconds - expected)) < bound
    if scale == "":
        dates = re.findall(r"^(\d{4}-\d\d-\d\dT\S+) [-\d]", file.read_text(), re.M)
        assert dates[1].startswith("2026-03-01T00:00:07.3") and dates[1].endswith(("7.3", "00"))


def test_a_mission_file_names_a_motion_for_every_command(capsys, tmp_path):
    """Its free rotation; under torques, and without a place, a sentence says what to do."""
    missions = ROOT / "data" / "mission"
    assert cli.main(["describe", str(missions / "apophis-2012.toml")]) == 0
    assert "Short-axis mode" in capsys.readouterr().out
    picture = tmp_path / "apophis.png"
    assert cli.main(["plot", str(missions / "apophis-2012.toml"), "--output", str(picture)]) == 0
    assert picture.stat().st_size > 10_000
    capsys.readouterr()
    for words, sentence in (
        (("describe", missions / "goes-like.toml"), "attitude propagate or evolve"),
        (("lightcurve", ROOT / "data" / "spin" / "toutatis.toml"), "the file has no center"),
        (
            ("convert", missions / "envisat-pass.toml", tmp_path / "a.aem"),
            "a key 'center', which mission files have",
        ),
    ):
        assert cli.main([*map(str, words)]) == 2
        assert sentence in capsys.readouterr().err


def test_ctrl_c_within_a_class_statement_is_silent(monkeypatch, capsys):
    """Python 3.11 wraps what stops a class statement: astropy's tables are one, when imported."""

    def stopped(*arguments, **options):
        class Field:
            def __set_name__(self, owner, name):
                raise KeyboardInterrupt

        class Table:
            field = Field()

    monkeypatch.setattr("attitude.cli.describe.run", stopped)
    assert cli.main(["describe", PAPER]) == 130
    assert capsys.readouterr().err == ""
