"""``passes`` and ``glints`` print what the functions find; ``catalog``, ``completion``."""

import shutil
import subprocess

import numpy as np
import pytest
from astropy.table import QTable

from attitude import AttitudeError, FreeRotation, catalog, cli, events
from attitude.formats import mission
from tests.support.places import ROOT

PASS, GLINTS = (str(ROOT / "data" / "mission" / f"envisat-{k}.toml") for k in ("pass", "glints"))
DAY = ("--start", "2013-10-23", "--stop", "2013-10-24")


@pytest.fixture
def attitude_command(capsys):
    def run(*arguments):
        code = cli.main([str(each) for each in arguments])
        captured = capsys.readouterr()
        return code, captured.out, captured.err

    return run


def test_passes_are_those_of_the_function(attitude_command, tmp_path):
    wanted = events.passes(mission.read(PASS).scene, *DAY[1::2])
    code, out, err = attitude_command("passes", PASS, *DAY)
    assert (code, err) == (0, "")
    rows = out.splitlines()
    assert len(rows) == 3 + len(wanted) == 10
    assert [row.split()[0] for row in rows[3:]] == wanted.time("rise").isot.tolist()
    code, out, _ = attitude_command("passes", PASS, *DAY, "--output", tmp_path / "a.ecsv")
    assert (code, out) == (0, f"{tmp_path / 'a.ecsv'}: 7 passes\n")
    table = QTable.read(tmp_path / "a.ecsv")
    assert np.array_equal(table["elevation"].to_value("rad"), wanted.elevation) or np.allclose(
        table["elevation"].to_value("rad"), wanted.elevation, rtol=1e-15
    )
    at_night = attitude_command("passes", PASS, *DAY, "--sunlit", "--night", "-6 deg")[1]
    assert len(at_night.splitlines()) == 6 and "visible_from" in at_night
    # the least mission file and the options have neither columns nor [times]
    site, orbit = "15.4933, 47.0671 deg, 539 m", str(ROOT / "data" / "paths" / "envisat-2013.tle")
    (tmp_path / "least.toml").write_text(f'center = "{orbit}"\nobserver = "{site}"\n')
    options = ("--orbit", orbit, "--site", site)
    out = attitude_command("passes", tmp_path / "least.toml", *DAY)[1]
    assert out == attitude_command("passes", *options, *DAY)[1]
    # to the second: the file of the satellite has aberration
    assert [row[:18] for row in out.splitlines()] == [row[:18] for row in rows]
    code, _, err = attitude_command("passes", tmp_path / "least.toml", *DAY[:2])
    assert code == 2 and "the stop of the search is not known; give --stop" in err
    assert "leave it out" in attitude_command("passes", PASS, *options)[2]
    assert (
        "give a mission file, or --orbit and --site" in attitude_command("passes", *options[:2])[2]
    )
    least = (tmp_path / "least.toml", *DAY, "--step", "1 h")
    assert "columns is missing; give a list" in attitude_command("geometry", *least)[2]
    out = attitude_command("passes", PASS, *DAY, "--elevation", "89.5 deg")[1]
    assert out == "no passes from 2013-10-23T00:00:00 to 2013-10-24T00:00:00 UTC.\n"


def test_the_span_of_the_file_is_the_default(attitude_command, tmp_path):
    code, out, _ = attitude_command("passes", PASS)
    assert code == 0 and len(out.splitlines()) == 4  # one, which rises before
    assert attitude_command("passes", PASS, "--output", tmp_path / "a.csv")[1].endswith(
        ": 1 pass\n"
    )


def test_glints_are_those_of_the_function(attitude_command):
    ends = "2013-10-23T20:50:00", "2013-10-23T20:52:00"
    wanted = events.glints(mission.read(GLINTS).scene, *ends, visible=False)
    given = ("glints", GLINTS, "--start", ends[0], "--stop", ends[1], "--all")
    code, out, err = attitude_command(*given)
    assert (code, err) == (0, "")
    assert len(wanted) > 0 and len(out.splitlines()) == 3 + len(wanted)
    side = str(wanted.side[0])
    one = attitude_command(*given, "--side", side)[1].splitlines()[3:]
    assert len(one) == np.count_nonzero(wanted.side == side)
    assert all(each.strip().startswith(side) for each in one)


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        (("passes", PASS, "--start", "noon"), "--start is 'noon'"),
        (("passes", PASS, "--output", "a.txt"), "ends in .csv or .ecsv"),
        (("passes", PASS, *DAY, "--elevation", "2 m"), "elevation"),
        (("passes", PASS, *DAY, "--elevation", "200 deg"), "from -pi/2 to pi/2"),
        (("passes", PASS, *DAY, "--night", "-6"), "night is -6.0 rad; it goes from -pi/2 to pi/2"),
        (("passes", str(ROOT / "data" / "mission" / "apophis-2012.toml")), "ground site"),
        (("passes", "none.toml"), "none.toml"),
        (("glints", PASS), "flat sides of a mesh"),
        (("glints", GLINTS, "--side", "roof"), "'roof'"),
        (("glints", GLINTS, "--fraction", "2"), "fraction"),
        (("catalog", "pluto"), "pluto"),
        (("completion", "tcsh"), "tcsh"),
        (("completion",), "shell"),
    ],
)
def test_wrong_input_is_a_sentence(attitude_command, words, sentence):
    code, out, err = attitude_command(*words)
    assert (code, out) == (2, "")
    assert sentence in err and err.count("\n") == 1


def test_the_catalogue_is_listed(attitude_command):
    rows = attitude_command("catalog")[1].splitlines()
    assert len(rows) == len(catalog.names())
    assert rows[0].split()[:4] == ["4179", "Toutatis", "2013", "LAM"]
    out = attitude_command("catalog", "apophis")[1]
    assert "2014" in out and "2022" in out and "Pravec" in out


def test_an_epoch_alone_propagates(attitude_command):
    """A published state at another date is the same motion, not another one."""
    own = catalog.entry("toutatis").motion()
    there = catalog.load("toutatis", epoch="1996-11-29")
    again = FreeRotation(*there)
    dates = ["1992-12-08", "1996-11-29", "2029-04-13T21:46"]
    assert np.abs(np.sum(again.at(dates).wxyz * own.at(dates).wxyz, axis=1)) == pytest.approx(
        np.ones(3), abs=1e-13
    )
    out = attitude_command("describe", "toutatis", "--epoch", "1996-11-29")[1]
    assert out.startswith("4179 Toutatis, propagated to --epoch\n")
    assert "epoch             1996-11-29T00:00:00 UTC" in out
    assert "0.00121820638 deg/s" not in out  # the rate at the epoch of the publication
    # With angles the state is another one.
    given = catalog.load("Envisat", epoch="2000-01-01", wxyz=(0, 1, 0, 0))
    assert given.spin.epoch.utc_iso == "2000-01-01T00:00:00"
    assert given.spin.wxyz.tolist() == [0.0, 1.0, 0.0, 0.0]
    with pytest.raises(AttitudeError, match="epoch"):
        catalog.load("toutatis", epoch="soon")


def test_the_scripts_complete(attitude_command):
    bash = attitude_command("completion", "bash")[1]
    shell = shutil.which("bash")
    if shell is None:
        pytest.skip("bash is not installed")
    for words, wanted in (
        ("attitude gl", "glints"),
        ("attitude describe tou", "toutatis"),
        ("attitude invert --max", "--max-frequency"),
    ):
        line = f"COMP_WORDS=({words}); COMP_CWORD={len(words.split()) - 1}; _attitude"
        done = subprocess.run(
            [shell, "-c", f'{bash}\n{line}; echo "${{COMPREPLY[@]}}"'],
            capture_output=True,
            text=True,
            check=True,
        )
        assert wanted in done.stdout.split(), done.stdout
    zsh, fish = (attitude_command("completion", each)[1] for each in ("zsh", "fish"))
    assert zsh.startswith("autoload") and zsh.endswith(bash)
    assert "-n '__fish_seen_subcommand_from view' -l animate" in fish
    assert fish.count("__fish_use_subcommand -a ") == len(cli.COMMANDS)


def test_every_command_stands_in_the_readme():
    text = " ".join((ROOT / "README.md").read_text().split())
    line = text[text.index("**Command line**") :]
    line = line[: line.index("COMMAND --help")]
    assert [each for each in cli.COMMANDS if f"`{each}`" not in line.replace("attitude ", "")] == []
    examples = {file.name for file in (ROOT / "examples").glob("*.py")}
    assert {each for each in examples if f"(examples/{each})" not in text} == set()
