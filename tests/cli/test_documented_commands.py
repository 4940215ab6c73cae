"""Every command line of README, docs and --help runs as it is written, with the files it names.

In this process; and (marker `slow`) each in a process of its own, twice: those of a command in turn
from an empty folder of machine code, then again with what the first runs kept there.
"""

import os
import re
import shlex
import shutil
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest

from attitude import Body, FreeRotation, Spin, cli, epochs, paths, shape
from attitude.formats import damit_light_curve, spin_file
from tests.support.places import ROOT
from tests.support.searches import make_small

PAGES = [ROOT / "README.md", ROOT / "data" / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]
# Options after which a search ends early: lines are what is tested here, not searches.
SHORTER = {"invert": ["--budget", "0.5 s"]}
# Lines that take long: an animation, years of averaged motion, and a fit of a file of attitudes.
LONG = (
    "--animate toutatis.webp",
    "--until 2034-01-01",
    "--until 2040-01-01",
    "satellite.toml --fit",
)
# C-kernels are read and written by spiceypy, animations by Pillow.
NEEDS = {".bc": "spiceypy", ".webp": "PIL"}
# The body and the satellite of the files, in the first months of 2026.
YEAR = 2026
FIRST_DAY = 2461045.5  # Julian date of 2026-01-05


def documented():
    """Command lines without "attitude", by the page or the command whose help has them."""
    found = {}
    for page in PAGES:
        if "_build" not in page.parts:
            blocks = re.findall(r"```(?:sh|bash|console)\n(.*?)```", page.read_text(), re.S)
            found |= {line: page.name for line in lines_of("\n".join(blocks))}
    for name in cli.COMMANDS:
        found |= {line: f"{name} --help" for line in lines_of(cli.command_of(name).epilog)}
    return found


def lines_of(text):
    """The command lines in a text; a line that ends in a backslash goes on."""
    for line in re.sub(r"\\\n\s*", " ", text).splitlines():
        words = re.sub(r"\s+#.*$", "", line)
        command = re.search(r"(?:^\s*(?:\$ )?|&& )(?:\.venv/bin/)?attitude ([a-z].*)$", words)
        if command:
            yield re.sub(r"\s+>>? .*$", "", command.group(1)).strip()


LINES = documented()


def write_files(folder):
    """The files that the command lines name, each of its format."""
    # copies: commands also write beside what they read
    shutil.copytree(ROOT / "data", folder / "data")
    for kind in ("spin", "paths"):
        shutil.copytree(ROOT / "data" / kind, folder.parent / kind, dirs_exist_ok=True)
    for file in (ROOT / "data" / "mission").glob("*.toml"):
        shutil.copy(file, folder)
    shutil.copy(ROOT / "data" / "spin" / "toutatis.toml", folder)
    shutil.copy(ROOT / "data" / "spin" / "envisat.toml", folder / "satellite.toml")
    photometry = ROOT / "data" / "light_curve" / "toutatis-1992-photometry.csv"
    shutil.copy(photometry, folder / "toutatis.csv")
    body = Body(moments=(10.0, 20.0, 26.0))
    spin = Spin(epoch="2026-01-01", wxyz=(1, 0, 0, 0), angular_velocity=(0.01, 0.15, 0.01))
    spin_file.write(folder / "tumbler.toml", FreeRotation(body, spin), name="TUMBLER")
    for name in ("body.toml", "solution.toml"):
        shutil.copy(ROOT / "data" / "spin" / "toutatis.toml", folder / name)
    shape.Ellipsoid((2.1, 1.2, 1.0)).facets(80).write(folder / "toutatis.obj")
    shape.box((4.0, 2.0, 1.0)).write(folder / "satellite.obj")
    lines = ["[scattering]", 'law = "lambert"']
    (folder / "materials.toml").write_text("\n".join(lines) + "\n")
    write_orbits(folder)
    for given in (
        'convert tumbler.toml satellite.aem --stop "1 h" --step "1 min"',
        'convert tumbler.toml satellite.xml --stop "1 h" --step "1 min"',
        'convert tumbler.toml relative-to-lvlh.aem --stop "1 h" --step "1 min" --frame LVLH '
        "--orbit satellite.oem",
    ):
        words = shlex.split(given)
        assert run_here(folder, words) == 0, given


def write_orbits(folder):
    """An asteroid's path of 2012-13, as that of 2025-26; a circular orbit of the Earth."""
    text = (ROOT / "data" / "paths" / "apophis-2012-2013.oem").read_text()
    later = text.replace("2012-12-", "2025-12-").replace("2013-", "2026-")
    (folder / "body.oem").write_text(later)
    mission = (ROOT / "data" / "mission" / "apophis-2012.toml").read_text()
    mission = mission.replace("../paths/apophis-2012-2013.oem", "body.oem")
    mission = mission.replace("2012-12-", "2025-12-").replace("2013-", "2026-")
    (folder / "mission.toml").write_text(mission)
    orbit = paths.kepler(
        epoch="2026-01-01", center="earth", semi_major_axis=7.2e6, eccentricity=0.0, node=0.3,
        inclination=1.7, pericenter_argument=0.0, mean_anomaly=0.0, frame="icrf",
    )  # fmt: skip
    start = epochs.instant("2026-01-01")
    seconds = np.arange(0.0, 7200.0, 60.0)
    place = orbit.position(start, seconds) / 1e3
    speed = orbit.velocity(start, seconds) / 1e3
    dates = [start.after(s).utc_iso for s in seconds]
    head = [
        "CCSDS_OEM_VERS = 2.0", "CREATION_DATE = 2026-01-01T00:00:00", "ORIGINATOR = TEST",
        "META_START", "OBJECT_NAME = S", "OBJECT_ID = 2026-001A", "CENTER_NAME = EARTH",
        "REF_FRAME = ICRF", "TIME_SYSTEM = UTC", f"START_TIME = {dates[0]}",
        f"STOP_TIME = {dates[-1]}", "META_STOP",
    ]  # fmt: skip
    rows = [
        " ".join([date, *(f"{x:.9f}" for x in (*r, *v))])
        for date, r, v in zip(dates, place, speed, strict=True)
    ]
    (folder / "satellite.oem").write_text("\n".join([*head, *rows]) + "\n")


def write_light_curves(folder, line):
    """Magnitudes of ten nights, of a pass with directions, and relative brightness for DAMIT.

    Those of the nights have directions too where the line does not compute them from an orbit.
    """
    k = np.arange(80)
    days = FIRST_DAY + k // 8 + 0.02 * (k % 8)
    turns = (days - FIRST_DAY) / 0.73
    magnitudes = 15.0 + 0.3 * np.cos(4 * np.pi * turns) + 0.1 * np.sin(2 * np.pi * turns * 1.3)
    names = ",".join(f"{who}_{x}" for who in ("sun", "observer") for x in "xyz")
    known = "--orbit" not in line
    rows = [
        f"{a:.9f},{b:.4f},0.02,V" + f",1.5,{0.02 * (a - FIRST_DAY):.6f},0.1,0.6,0.2,0.1" * known
        for a, b in zip(days, magnitudes, strict=True)
    ]
    head = "jd_utc,magnitude,sigma,filter" + f",{names}" * known
    (folder / "curve.csv").write_text("\n".join([head, *rows]))
    rows = [
        f"{FIRST_DAY + t / 86400.0:.10f},{5.0 + np.cos(0.1 * t):.4f},0.05,1,0,0,"
        f"{0.5 + 0.001 * t:.6f},0.8,0.2"
        for t in 4.0 * k
    ]
    (folder / "pass.csv").write_text("\n".join([f"jd_utc,magnitude,sigma,{names}", *rows]))
    sun, earth = np.array([2.0, 0.5, 0.2]), np.array([1.2, 0.4, 0.1])
    curves = [
        damit_light_curve.DamitLightCurve(
            jd=2451545.0 + 40.0 * night + 0.01 * np.arange(12),
            brightness=1.0 + 0.2 * np.cos(4 * np.pi * (40.0 * night + 0.01 * np.arange(12)) / 0.24),
            sun=np.tile(sun, (12, 1)),
            earth=np.tile(earth, (12, 1)),
            calibrated=False,
        )
        for night in range(3)
    ]
    damit_light_curve.write_damit_light_curves(folder / "A43.lc.txt", curves)


def run_here(folder, words):
    """The exit code of a command in a folder."""
    before = Path.cwd()
    os.chdir(folder)
    try:
        return cli.main(words)
    finally:
        os.chdir(before)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A working directory with all files, one for all command lines."""
    found = tmp_path_factory.mktemp("documented") / "work"
    found.mkdir()
    write_files(found)
    return found


def lacks(words):
    """The packages that the files of a command line need and that are not installed."""
    return [
        package
        for ending, package in NEEDS.items()
        if any(word.endswith(ending) for word in words) and find_spec(package) is None
    ]


def words_of(line):
    words = shlex.split(line)
    for package in lacks(words):
        pytest.skip(f"{package} is not installed")
    return [*words, *SHORTER.get(words[0], [])]


def outputs(words):
    """The files that a command writes under the names it is given."""
    if words[0] == "convert":
        return [words[2]]
    options = ("--output", "--figure", "--animate", "--prediction")
    return [words[k + 1] for k, each in enumerate(words) if each in options]


def test_lines_are_found():
    """Those of pages and of all commands that have examples; each begins with a command."""
    assert len(LINES) > 45 and {"README.md", "inversion.md", "events.md"} <= set(LINES.values())
    assert {line.split()[0] for line in LINES} <= set(cli.COMMANDS)


@pytest.mark.parametrize(
    "line",
    [
        pytest.param(line, marks=pytest.mark.slow) if any(x in line for x in LONG) else line
        for line in LINES
    ],
)
def test_a_documented_line_runs(line, folder, monkeypatch, capsys):
    words = words_of(line)
    make_small(monkeypatch)
    write_light_curves(folder, line)
    for name in outputs(words):
        (folder / name).unlink(missing_ok=True)
    assert run_here(folder, words) == 0, f"{LINES[line]}: {line}: {capsys.readouterr().err}"
    assert capsys.readouterr().out or outputs(words)
    for name in outputs(words):
        assert (folder / name).stat().st_size > 200, f"{line}: {name}"


@pytest.mark.slow
@pytest.mark.parametrize("command", sorted({line.split()[0] for line in LINES}))
def test_documented_lines_run_with_a_cold_and_a_warm_cache(command, folder, tmp_path):
    """A command's lines in turn, from an empty folder of machine code: the first has nothing.

    Each further line compiles what it alone needs.  All of them again, with what is kept, print
    the same.
    """
    lines = [line for line in LINES if line.split()[0] == command and not lacks(shlex.split(line))]
    if not lines:
        pytest.skip(f"lines of {command} need spiceypy")
    environment = {**os.environ, "NUMBA_CACHE_DIR": str(tmp_path), "ATTITUDE_COMPILE": "automatic"}
    environment.pop("ATTITUDE_QUIET")
    answers = {}
    for line in [*lines, *lines]:
        write_light_curves(folder, line)
        run = subprocess.run(
            [sys.executable, "-m", "attitude", *shlex.split(line), *SHORTER.get(command, [])],
            cwd=folder, env=environment, capture_output=True, text=True, check=False,
        )  # fmt: skip
        assert run.returncode == 0, f"{line}: {run.stderr}"
        assert run.stderr.count("compiling, once") <= 1 and "Traceback" not in run.stderr
        # durations; rounding errors, which differ between Python and machine code
        answer = re.sub(r"[\d.]+ s\b|[\d.]+e-1[2-9]\b", "", run.stdout)
        assert answers.setdefault(line, answer) == answer, line
