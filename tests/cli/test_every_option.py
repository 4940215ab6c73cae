"""Every option of every command runs once with a real file, and every call of the docs binds.

Options are found from the parsers themselves, calls from the code of the pages: one without a case,
or one that a function does not take, fails here.
"""

import argparse
import ast
import importlib
import inspect
import json
import re
import shlex

import numpy as np
import pytest

import attitude
from attitude import FreeRotation, catalog, cli, inversion, paths
from attitude.formats import spin_file
from tests.support.places import PAGES, ROOT
from tests.support.searches import make_small

DATA = ROOT / "data"
OEM = DATA / "paths" / "apophis-2012-2013.oem"
TLE = DATA / "paths" / "envisat-2013.tle"
MISSION = DATA / "mission" / "apophis-2012.toml"
TORQUES = DATA / "mission" / "goes-like.toml"
PASS, GLINTS = (DATA / "mission" / f"envisat-{name}.toml" for name in ("pass", "glints"))
# Toutatis of the catalogue, whose epoch is 1992-12-11; the file is written below.
STATE = catalog.entry("toutatis").motion()

_APOPHIS = '"99942 Apophis (2014)" --phi0 10 deg --psi0 20 deg --epoch 2012-12-23'
# Values that entries of the catalogue lack, as three commands; --frame is in two of them.
_VALUES = (
    f"{_APOPHIS} --P-psi 263 h --P-phi 27.38 h --pole 250, -75 deg --mode SAM --convention S "
    "--moments 0.61, 0.965, 1 --frame ecliptic",
    f"{_APOPHIS} --convention L --P-phi 30.56 h --theta-branch acute",
    "envisat --wxyz 1, 0, 0, 0 --angular-velocity 1, 0, 3 deg/s --epoch 2013-10-23 --frame icrf",
)
_GROUND = '"-70.7, -30.2 deg, 2700 m"'
_INVERT = '--max-frequency "0.5 /d" --budget "0.5 s" --modes LAM --moments "3.1, 3.2, 1"'
CASES = {
    "propagate": [
        *(f'{each} --stop "1 d" --step "1 d"' for each in _VALUES),
        'state.toml --start 0 --stop "2 d" --step "1 d" --rates --sigma --output OUT.csv',
    ],
    "evolve": [
        f'{TORQUES} --until "1 d" --step "12 h" --passages 3 --least-tilt "0.1 deg" '
        "--paths averaged --output OUT.csv --figure OUT.png",
        f'{TORQUES} --until "1 d" --step "12 h" --order 2 --output OUT.csv',
    ],
    "describe": list(_VALUES),
    "catalog": ["", "apophis"],
    "passes": [
        f'{PASS} --start 2013-10-23 --stop 2013-10-24 --elevation "1 deg" --sunlit '
        '--night "-6 deg" --output OUT.csv',
        f"{PASS} --start 2013-10-23T09:00 --stop 2013-10-23T10:00",
        f"--orbit {TLE} --orbit-of ENVISAT --site {_GROUND} --start 2013-10-23T09:00 "
        "--stop 2013-10-23T15:00",
    ],
    "glints": [
        f'{GLINTS} --start 2013-10-23T20:50 --stop 2013-10-23T20:51 --side "body +z" --all '
        "--fraction 0.2 --output OUT.ecsv",
    ],
    "completion": ["bash", "zsh", "fish"],
    "geometry": [
        f'{MISSION} --start 2012-12-23 --stop 2012-12-24 --step "6 h" --output OUT.csv',
        "--list",
    ],
    "lightcurve": [
        f'{MISSION} --start 2012-12-23 --stop 2012-12-24 --step "2 h" --output OUT.csv '
        "--figure OUT.png",
        f"{MISSION} --observed asteroid.csv --output OUT.csv --figure OUT.svg",
    ],
    "invert": [
        f"asteroid.csv {_INVERT} --orbit {OEM} --site {_GROUND} --seed 1 --zero-points shared "
        "--frame icrf --output OUT.toml --figure OUT.png --exposure '60 s' --predict "
        "'2013-02-01T00:00 .. 2013-02-01T06:00, 1 h' --prediction OUT2.png",
        f'apparitions.csv {_INVERT} --drift --budget "1 s" --orbit {OEM} --site {_GROUND}',
        f'asteroid.csv --period "20 h, 40 h" --budget "0.5 s" --orbit {OEM} --site {_GROUND}',
        f'satellite.csv {_INVERT} --max-frequency "20 mHz" --orbit {TLE} --orbit-of ENVISAT '
        f"--site {_GROUND}",
        f'satellite.csv --max-frequency "0.02 Hz" --budget "0.5 s" --orbit {TLE} '
        f"--orbit-of ENVISAT --site {_GROUND} --shape box.obj --unit m --law lambert "
        '--moments "3, 4, 5" --output OUT.toml',
    ],
    "periods": [
        f"asteroid.csv --filter V --zero-points shared --orbit {OEM} --site earth --g 0.24 "
        '--min "20 h" --max "60 h" --order 2 --method fourier --count 3 --bootstrap 10 '
        "--figure OUT.png",
        'asteroid.csv --two --min "20 h" --max "60 h" --count 3',
        f'satellite.csv --method pdm --orbit {TLE} --orbit-of ENVISAT --min "20 s"',
    ],
    "fold": [
        f"asteroid.csv --filter V --zero-points shared --orbit {OEM} --site earth --g 0.24 "
        '--period "30 h" --order 2 --epoch 2012-12-23 --refine --output OUT.csv --figure OUT.png',
        f'satellite.csv --orbit {TLE} --orbit-of ENVISAT --period "60 s"',
    ],
    "plot": [
        *(f'{each} --span "1 d" --output OUT{k}.svg' for k, each in enumerate(_VALUES)),
        'state.toml --span "20 d" --sky icrf --output OUT.png',
    ],
    "view": [
        *(f'{each} --stop "1 h" --output OUT{k}.html' for k, each in enumerate(_VALUES)),
        'state.toml --start 0 --stop "1 h" --sun 1 0 0 --observer 0 1 0 --shape box.obj --unit km '
        "--output OUT.html",
        "table.aem --lenient --object TOUTATIS --segment 0 --frame-in ICRF --rates body "
        f"--orbit {TLE} --orbit-of ENVISAT --output OUT.html",
        'state.toml --animate OUT.gif --frames 2 --stop "1 h"',
    ],
    "convert": [
        'state.toml OUT.aem --start 0 --stop "1 h" --step "10 min" --version 2.0 --type QUATERNION '
        "--frame EME2000 --time-system TDB",
        'state.toml OUT.aem --stop "1 h" --tolerance 1e-7 --method linear',
        'state.toml OUT.aem --stop "1 h" --step "10 min" --version 1.0 --type QUATERNION/RATE '
        "--rates body",
        'state.toml OUT.aem --for gmat --stop "1 h" --step "1 min"',
        'state.toml OUT.a --split --stop "1 h" --step "1 min"',
        f"state.toml OUT.aem --frame LVLH --orbit {TLE} --orbit-of ENVISAT "
        '--start 2013-10-23T00:00:00 --stop 2013-10-23T00:10:00 --step "60 s"',
        "table.aem OUT.ecsv --lenient --segment 0 --frame-in EME2000",
        "table.aem OUT.ecsv --object TOUTATIS",
        "table.aem OUT.toml --fit --axes free --rms 0.1",
    ],
    "check": [
        "--families",
        "--full",
        "--prove",
        "--prove table.aem --spin state.toml --tolerance 1e-9",
    ],
    "warm-up": ["--all"],
}
# The same with kernels, which spiceypy reads.
KERNELS = {
    "convert": [
        'state.toml OUT.bc --stop "1 h" --tolerance 1e-8 --rate-tolerance 1e-9 --method hermite '
        "--time-scale tdb --body TUMBLER",
        'state.toml OUT.bc --stop "1 h" --clock kernel.tsc --frame-kernel kernel.tf --body TUMBLER',
        "kernel.bc OUT.csv --body TUMBLER --kernels kernel.tf kernel.tsc --start START "
        '--stop STOP --step "1 min"',
    ],
    "view": [
        "kernel.bc --body TUMBLER --kernels kernel.tf kernel.tsc --start START --stop STOP "
        "--output OUT.html"
    ],
}
# Compiles for a minute what other tests compile too.
SLOW = ("warm-up",)


def options_of(command):
    """The first name of each option of a command, as its parser has them."""
    parser = argparse.ArgumentParser(add_help=False)
    cli.command_of(command).add_arguments(parser)
    return {each.option_strings[0] for each in parser._actions if each.option_strings}


@pytest.mark.parametrize("command", cli.COMMANDS)
def test_every_option_has_a_case(command):
    words = shlex.split(" ".join(CASES[command] + KERNELS.get(command, [])))
    assert options_of(command) == {each for each in words if each.startswith("--")}


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    """A folder with a state with errors, a table, a mesh, and light curves of two bodies."""
    folder = tmp_path_factory.mktemp("options")
    errors = {"attitude": "1 deg", "angular_velocity": "0.01 deg/s", "moments": 0.1}
    motion = FreeRotation(STATE.body, STATE.spin.with_covariance(errors))
    spin_file.write(folder / "state.toml", motion, name="TOUTATIS")
    given = ["--stop", "1 h", "--step", "10 min"]
    assert (
        cli.main(["convert", *map(str, (folder / "state.toml", folder / "table.aem")), *given]) == 0
    )
    corners = [(x, y, z) for x in (0, 1) for y in (0, 1) for z in (0, 1)]
    facets = ("1 2 4 3", "5 7 8 6", "1 5 6 2", "3 4 8 7", "1 3 7 5", "2 6 8 4")
    lines = [f"v {x} {y} {z}" for x, y, z in corners] + [f"f {each}" for each in facets]
    (folder / "box.obj").write_text("\n".join(lines))
    k = np.arange(60)
    for name, days, turns in (
        ("asteroid", 2456270.5 + 0.37 * k, 0.37 * k / 1.27),
        ("satellite", 2456588.5 + k / 8640.0, k / 6.0),
        (
            "apparitions",
            2456285.5 + 0.2 * k + 80.0 * (k >= 30),
            (0.2 * k + 80.0 * (k >= 30)) / 1.27,
        ),
    ):
        magnitudes = 15.0 + 0.3 * np.cos(2 * np.pi * turns) + 0.1 * np.sin(np.pi * turns * 1.3)
        rows = [f"{a:.9f},{b:.4f},0.02,V" for a, b in zip(days, magnitudes, strict=True)]
        (folder / f"{name}.csv").write_text("\n".join(["jd_utc,magnitude,sigma,filter", *rows]))
    return folder


def words_of(text):
    """The arguments of a case; START and STOP are a minute and half an hour into the state."""
    dates = {name: STATE.spin.epoch.after(s).utc_iso for name, s in (("START", 60), ("STOP", 1800))}
    return [dates.get(each, each) for each in shlex.split(text)]


def _run(command, cases, capsys, folder):
    for text in cases:
        for old in folder.glob("OUT*"):
            old.unlink()
        code = cli.main([command, *words_of(text)])
        assert code == 0, f"{command} {text}: {capsys.readouterr().err}"
        written = re.findall(r"\bOUT\d?\.\w+", text)
        made = {each.name for each in folder.glob("OUT*") if each.stat().st_size > 0}
        assert set(written) <= made or ("--split" in text and made), f"{command} {text}: {made}"


@pytest.mark.parametrize(
    "command", [pytest.param(each, marks=[pytest.mark.slow] * (each in SLOW)) for each in CASES]
)
def test_every_option_runs(command, files, monkeypatch, capsys):
    if command == "check":
        pytest.importorskip("flint", reason="python-flint is not installed")
    make_small(monkeypatch)
    monkeypatch.chdir(files)
    _run(command, CASES[command], capsys, files)


def test_options_of_kernels_run(files, monkeypatch, capsys):
    spice = pytest.importorskip("spiceypy", reason="spiceypy is not installed")
    monkeypatch.chdir(files)
    try:
        assert cli.main(["convert", "state.toml", "kernel.bc", "--stop", "1 h"]) == 0
        for command, cases in KERNELS.items():
            _run(command, cases, capsys, files)
    finally:
        spice.kclear()  # a command ends with its process, and leaves kernels loaded


def test_the_geometry_of_a_light_curve_by_keyword(files):
    """`path` is also the name of the first parameter: each call with both failed."""
    site = paths.site("-70.7 deg", "-30.2 deg")
    for name, orbit in (("asteroid.csv", paths.oem(OEM)), ("satellite.csv", paths.tle(TLE))):
        for place in ({"site": site}, {}):
            curve = inversion.LightCurve.read(files / name, path=orbit, **place)
            assert len(curve) == 60 and np.all(np.linalg.norm(curve.observer, axis=1) > 0.0)


# Calls in the docs --------------------------------------------------------------------------------

# Functions that hand all further keywords on, and what takes them.
FORWARDS = {
    "LightCurve.read": "attitude.photometry:LightCurve",
}


def code_of(page):
    """The Python of a page: fenced blocks, with or without prompts, or the cells of a notebook."""
    if page.suffix == ".ipynb":
        cells = json.loads(page.read_text())["cells"]
        return ["".join(each["source"]) for each in cells if each["cell_type"] == "code"]
    found = []
    for block in re.findall(r"```python\n(.*?)```", page.read_text(), re.DOTALL):
        if ">>>" in block:
            lines = [line[4:] for line in block.splitlines() if line.startswith((">>> ", "... "))]
            block = "\n".join(lines)
        found.append(block)
    return found


def known(node, names):
    """The object of the package that a node names (`paths.oem`, `Spin.from_periods`), or None."""
    if isinstance(node, ast.Name):
        return names.get(node.id)
    if isinstance(node, ast.Attribute):
        owner = known(node.value, names)
        if inspect.ismodule(owner) or inspect.isclass(owner):
            return getattr(owner, node.attr)
    return None


def calls_of(page):
    """(function, node) of each call of the package in a page."""
    names = {}
    for block in code_of(page):
        try:
            tree = ast.parse("\n".join(x for x in block.splitlines() if not x.startswith("%")))
        except SyntaxError:
            continue  # a sketch of a call, with dots
        for node in ast.walk(tree):
            if isinstance(node, ast.Import):
                for each in node.names:
                    if each.name.startswith("attitude"):
                        importlib.import_module(each.name)
                        names["attitude"] = attitude
            elif isinstance(node, ast.ImportFrom) and (node.module or "").startswith("attitude"):
                if node.module in ("attitude.jax", "attitude.torch"):
                    continue  # extras
                owner = importlib.import_module(node.module)
                for each in node.names:
                    full = f"{node.module}.{each.name}"
                    names[each.asname or each.name] = (
                        getattr(owner, each.name)
                        if hasattr(owner, each.name)
                        else importlib.import_module(full)
                    )
        for node in ast.walk(tree):
            function = known(node.func, names) if isinstance(node, ast.Call) else None
            if callable(function) and getattr(function, "__module__", "").startswith("attitude"):
                yield function, node


def bound(function, node):
    """Raise the TypeError of a call whose arguments a function does not take."""
    if any(isinstance(each, ast.Starred) for each in node.args):
        return
    keywords = {each.arg: None for each in node.keywords if each.arg is not None}
    signature = inspect.signature(function)
    arguments = signature.bind_partial(*[None] * len(node.args), **keywords)
    target = FORWARDS.get(function.__qualname__)
    if target and function.__module__.startswith(target.partition(":")[0].rpartition(".")[0]):
        rest = next(
            (
                arguments.arguments.get(each.name, {})
                for each in signature.parameters.values()
                if each.kind is each.VAR_KEYWORD
            ),
            {},
        )
        module, _, name = target.partition(":")
        inspect.signature(getattr(importlib.import_module(module), name)).bind_partial(**rest)


def test_every_call_of_the_docs_binds():
    pages = [*PAGES, *(ROOT / "docs" / "howto").glob("*.md"), *(ROOT / "docs").rglob("*.ipynb")]
    wrong, keywords = [], set()
    for page in [each for each in pages if "_build" not in each.parts]:
        for function, node in calls_of(page):
            keywords |= {(function.__qualname__, each.arg) for each in node.keywords}
            try:
                bound(function, node)
            except TypeError as err:
                wrong.append(f"{page.name}: {ast.unparse(node)[:80]}: {err}")
    assert wrong == []
    assert len(keywords) > 70  # 83 when this was written


def test_a_function_that_hands_keywords_on_has_none_of_their_names():
    """A first parameter `path` makes `path=` of the class behind it unreachable."""
    for function, target in ((inversion.LightCurve.read, inversion.LightCurve),):
        own = inspect.signature(function).parameters.values()
        named = {each.name for each in own if each.kind is each.POSITIONAL_OR_KEYWORD}
        assert not named & set(inspect.signature(target).parameters)
