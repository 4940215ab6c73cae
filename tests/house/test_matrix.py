"""The range of versions in pyproject.toml, the script that tests it, and what CI runs twice."""

import json
import platform
import re
import subprocess
import sys
from pathlib import Path

import pytest

from tests import matrix

# Tables of which a newer release is as good: the Earth's rotation, and skyfield's files.
DATA = {"astropy-iers-data", "skyfield-data"}


def test_each_dependency_has_a_lowest_version():
    required = matrix.PROJECT["dependencies"] + matrix.PROJECT["optional-dependencies"]["test"]
    names = {re.match(r"[\w.-]+", line)[0] for line in required}
    assert set(matrix.floors()) == names - DATA
    assert matrix.floors()["pyerfa"] == "2.0.1.1"


def test_numba_has_an_upper_bound():
    """Private names of it are used; CONTRIBUTING.md says how to move the bound."""
    (numba,) = (line for line in matrix.PROJECT["dependencies"] if line.startswith("numba"))
    assert re.fullmatch(r"numba>=0\.\d+,<0\.\d+", numba)


def test_a_short_run_has_the_files_that_it_names_alone(pytestconfig):
    """Files of the package have doctests, which took most of its time."""
    conftest = pytestconfig.pluginmanager.get_plugin(str(Path(__file__).parents[1] / "conftest.py"))
    short = conftest.Short()
    assert len(short.named) > 10 and all(file.is_file() for file in short.named)
    assert short.pytest_ignore_collect(short.named[0]) is None
    root = Path(conftest.__file__).parents[1]
    for other in ("attitude/averaged/_motion.py", "tests/inversion/test_search.py"):
        assert short.pytest_ignore_collect(root / other) is True


def test_the_lowest_interpreter_is_the_first():
    assert matrix.PROJECT["requires-python"] == f">={matrix.wanted()[0]}"
    assert [name for name in matrix.wanted() if name.endswith("t")] == ["3.13t", "3.14t"]


@pytest.mark.skipif(sys.platform == "win32", reason="a shim of pyenv is a script of a shell")
def test_a_shim_of_an_absent_version_is_not_an_interpreter(tmp_path, monkeypatch):
    for name in matrix.wanted():
        shim = tmp_path / f"python{name}"
        shim.write_text("#!/bin/sh\nexit 127\n")
        shim.chmod(0o755)
    monkeypatch.setenv("PATH", str(tmp_path))
    for name in ("PYENV_ROOT", "UV_PYTHON_INSTALL_DIR"):
        monkeypatch.setenv(name, str(tmp_path / "absent"))
    found = {each.name: each for each in matrix.interpreters() if each.path}
    assert [each.version.rstrip("t") for each in found.values()] == [platform.python_version()]


def test_an_absent_interpreter_is_a_row(monkeypatch, capsys):
    monkeypatch.setattr(matrix, "interpreters", lambda: [matrix.Interpreter("3.11")])
    assert matrix.main(["--list"]) == 0
    assert "not found" in capsys.readouterr().out
    assert matrix.main([]) == 1
    shown = capsys.readouterr().out
    assert shown.count("not available: no python3.11 on PATH") >= 2
    assert shown.endswith("No environment could be made, and nothing was tested.\n")


def test_an_environment_that_cannot_be_made_is_a_row(tmp_path):
    absent = matrix.Interpreter("3.12", tmp_path / "absent", "3.12.0")
    row = matrix.tested(absent, False, tmp_path, [])
    assert row.outcome.startswith("not available: venv failed: ") and not row.failed


def test_a_missing_wheel_is_the_reason():
    """The last error that pip prints, which names the package."""
    printed = "ERROR: Could not find a version\nERROR: No matching distribution found for x>=1\n"
    code = f"import sys; sys.stderr.write({printed!r} + 'a notice'); sys.exit(1)"
    with pytest.raises(matrix.NotAvailable, match=r"^pip: No matching distribution found for x>=1"):
        matrix._run([sys.executable, "-c", code], "pip")


@pytest.mark.parametrize(
    ("body", "code", "counts"),
    [
        ("assert True", 0, {"passed": 1, "failed": 0, "skipped": 0}),
        ("assert False", 1, {"passed": 0, "failed": 1, "skipped": 0}),
        ("import pytest; pytest.skip()", 0, {"passed": 0, "failed": 0, "skipped": 1}),
    ],
)
def test_a_failed_test_is_the_exit_code(body, code, counts, tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(matrix, "interpreters", lambda: [matrix.Interpreter("3.11", Path("x"))])
    made = (Path(sys.executable), {"numpy": "9.8.7"})
    monkeypatch.setattr(matrix, "environment", lambda *_: made)
    file = tmp_path / "test_one.py"
    file.write_text(f"def test_one():\n    {body}\n")
    (tmp_path / "3.11-lowest").mkdir()
    given = ["--lowest", "--keep", str(tmp_path), "--", "-p", "no:xdist", str(file)]
    assert matrix.main(given) == code
    last = capsys.readouterr().out.splitlines()[-1]
    assert "9.8.7" in last
    cells = [cell.strip() for cell in last.split("|")]
    assert cells[9:12] == [str(number) for number in counts.values()]


def test_an_error_of_collection_counts_as_failed():
    assert matrix.counts_of("...\n1 passed, 2 errors in 0.10s\n")["failed"] == 2
    assert matrix.counts_of("== 1 passed in 469.27s (0:07:49) ==")["minutes"] == 8
    assert matrix.counts_of("")["passed"] == 0


NEEDED = "FIRST", "SECOND"
PROJECT_THAT_SKIPS = {
    "test_one.py": """
import os, pytest

def test_runs(): open("runs.txt", "a").write("x")

@pytest.mark.parametrize("name", ["FIRST", "SECOND"])
def test_needs(name):
    if name not in os.environ: pytest.skip(f"{name} is not here")

@pytest.mark.xfail
def test_is_known(): assert False
""",
    "test_two.py": "import os, pytest\n"
    "if 'FIRST' not in os.environ: pytest.skip('FIRST is not here', allow_module_level=True)\n"
    "def test_two(): pass\n",
}


@pytest.mark.parametrize("workers", [0, 2])
def test_what_one_run_skips_the_next_one_runs(workers, tmp_path, monkeypatch):
    """`--skipped-to` and `--skipped-in`: each test once, and a table of what is left."""
    for name, text in PROJECT_THAT_SKIPS.items():
        (tmp_path / name).write_text(text)
    (tmp_path / "pytest.ini").write_text("[pytest]\naddopts = --import-mode=importlib\n")
    monkeypatch.setenv("PYTHONPATH", str(matrix.ROOT))
    file = tmp_path / "skipped.json"

    def run(*arguments):
        command = [sys.executable, "-m", "pytest", "-p", "tests.conftest", "-p", "no:cacheprovider"]
        command += ["-n", str(workers), *arguments]
        done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True)
        return done.returncode, done.stdout + done.stderr

    code, shown = run(f"--skipped-to={file}")
    assert code == 0, shown
    ids = {"test_two.py": "FIRST", **{f"test_one.py::test_needs[{x}]": x for x in NEEDED}}
    assert json.loads(file.read_text()) == {node: f"{x} is not here" for node, x in ids.items()}
    assert re.search(r"^ +2   FIRST is not here$", shown, re.MULTILINE), shown
    monkeypatch.setenv("FIRST", "1")
    code, shown = run(f"--skipped-in={file}")
    assert code == 0, shown
    assert re.search(r"^ +2 +0   FIRST is not here$", shown, re.MULTILINE), shown
    assert re.search(r"^ +1 +1   SECOND is not here$", shown, re.MULTILINE), shown
    assert "2 passed, 1 skipped" in shown and (tmp_path / "runs.txt").read_text() == "x"
    file.write_text('{"test_one.py::test_gone": "it was here"}')
    code, shown = run(f"--skipped-in={file}")
    assert code == 1 and "test_one.py::test_gone was skipped, and does not exist now" in shown
