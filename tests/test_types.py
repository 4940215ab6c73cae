"""Types as users' checkers see them: `mypy --strict` over README, examples and a user's script."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent
SCRIPT = ROOT / "tests" / "typing" / "mission_script.py"
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]


def blocks(page):
    """The Python of a page as one script."""
    found = re.findall(r"^```python\n(.*?)^```", page.read_text(), re.DOTALL | re.MULTILINE)
    return "\n".join(block for block in found if ">>>" not in block)


def mypy(*files):
    pytest.importorskip("mypy")
    run = subprocess.run(
        [sys.executable, "-m", "mypy", "--config-file", ROOT / "pyproject.toml", *files],
        capture_output=True,
        text=True,
        cwd=ROOT,
    )
    return run.stdout + run.stderr


def test_examples_and_a_mission_script():
    assert "Success" in mypy(SCRIPT, *sorted((ROOT / "examples").glob("*.py")))


def test_readme_and_docs(tmp_path):
    """Names that a fragment leaves to the reader are not errors; wrong types are."""
    files = []
    for page in PAGES:
        text = blocks(page)
        if text:
            file = tmp_path / f"page_{page.stem.replace('-', '_')}.py"
            file.write_text(text)
            files.append(file)
    assert len(files) > 5
    printed = mypy(*files)
    errors = [line for line in printed.splitlines() if ": error:" in line]
    wrong = [line for line in errors if "[name-defined]" not in line]
    assert not wrong, "\n".join(wrong)
    assert not [line for line in errors if "README" in line]


def test_a_wrong_call_is_seen(tmp_path):
    file = tmp_path / "wrong.py"
    file.write_text(
        "from attitude import Body, FreeRotation, Spin\n"
        "FreeRotation(Body(moments=(1, 2, 2)), 5)\n"
        "Spin(epoch='2026-01-01', wxyz=(1, 0, 0, 0))\n"
        "x: str = Body(moments=(1, 2, 2)).moments\n"
    )
    printed = mypy(file)
    assert all(f"wrong.py:{line}: error" in printed for line in (2, 3, 4)), printed


def test_the_mission_script_runs(tmp_path):
    subprocess.run([sys.executable, "-W", "error", SCRIPT], check=True, stdout=subprocess.DEVNULL)
