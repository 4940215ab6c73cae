"""Types as users' checkers see them: `mypy --strict` over README, docs, examples and a script.

mypy runs once over all of them, with the settings of pyproject.toml.
"""

import ast
import collections
import doctest
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

from tests.support.places import ROOT

SCRIPT = ROOT / "tests" / "typing" / "mission_script.py"
EXAMPLES = sorted((ROOT / "examples").glob("*.py"))
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]
# Names that a page leaves to the reader, as declarations.
LEFT_TO_THE_READER = {
    "formats.md": "from attitude import FreeRotation\nmotion: FreeRotation\ntimes: list[str]\n",
    "scene.md": "from attitude import FreeRotation\nmotion: FreeRotation\n",
}
# Each line of the second part is an error.
WRONG = """\
import numpy as np
from attitude import Arcs, Body, FreeRotation, Impulse, Scene, Spin, TorquedRotation, propagate
from attitude import events, shape
from attitude.torques import ConstantTorque

body = Body(moments=(1, 2, 2))
spin = Spin(epoch="2026-01-01", wxyz=(1, 0, 0, 0), angular_velocity=(0, 0, 1))
motion = FreeRotation(body, spin)
lit = events.illuminated(motion, (0, 0, 1), sun=(1, 0, 0))

Body(moments=spin)
text: str = body.moments
FreeRotation(spin, body)
FreeRotation(body, 5)
Spin(epoch="2026-01-01", wxyz=(1, 0, 0, 0))
Spin(epoch=2026, wxyz=(1, 0, 0, 0), angular_velocity=(0, 0, 1))
Spin(epoch="2026-01-01", wxyz=body, angular_velocity=(0, 0, 1))
motion.momentun
motion.at(body)
motion.at(0.0).euler(313.0)
propagate(body, (1, 0, 0, 0), (1, 2, 3), 0.0)
propagate((1, 2, 3), (1, 0, 0, 0), (1, 2, 3), 0.0, angular_velocity=True).shape
Impulse(at=body, angular_momentum=(0, 0, 1))
Impulse(at=1.0, angular_momentum=body)
Arcs(body, spin, [spin])
TorquedRotation(body, spin, [1.0], step=1.0)
TorquedRotation(body, spin, ConstantTorque((0, 0, 1)), step=body)
shape.Ellipsoid(body)
Scene(body, center="earth")
Scene(motion, center=body)
Scene(motion, center="earth", law=1.0)
Scene(motion, center="earth", shape="ellipsoid")
events.illuminated(body, (0, 0, 1))
events.find_discrete(body, 1.0, lit)
"""


def code_of(page):
    """The Python of a page as one script, examples of an interpreter without what they print."""
    found = re.findall(r"^```python\n(.*?)^```", page.read_text(), re.DOTALL | re.MULTILINE)
    parse = doctest.DocTestParser().get_examples
    return "\n".join(
        "".join(example.source for example in parse(block)) if ">>>" in block else block
        for block in found
    )


@pytest.fixture(scope="module")
def errors(tmp_path_factory):
    """The errors that mypy prints, by the name of the file."""
    pytest.importorskip("mypy")
    folder = tmp_path_factory.mktemp("types")
    files = [SCRIPT, *EXAMPLES, folder / "wrong.py"]
    files[-1].write_text(WRONG)
    for page in PAGES:
        if code := code_of(page):
            files.append(folder / script_of(page))
            files[-1].write_text(LEFT_TO_THE_READER.get(page.name, "") + code)
    assert len(files) > 20
    run = subprocess.run(
        [sys.executable, "-m", "mypy", "--cache-dir", os.devnull, *files],
        capture_output=True,
        text=True,
        cwd=ROOT,
        env={**os.environ, "MYPYPATH": str(ROOT), "MYPY_FORCE_COLOR": "0"},
    )
    assert re.search(r"Found \d+ errors in 1 file|Found \d+ errors in", run.stdout), (
        run.stdout + run.stderr
    )
    found = collections.defaultdict(list)
    for line in run.stdout.splitlines():
        if ": error:" in line:
            found[Path(line.partition(":")[0]).name].append(line)
    return found


def script_of(page):
    return f"page_{page.stem.replace('-', '_')}.py"


@pytest.mark.parametrize("file", [SCRIPT, *EXAMPLES], ids=lambda file: file.name)
def test_scripts(errors, file):
    assert not errors[file.name], "\n".join(errors[file.name])


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_pages(errors, page):
    assert not errors[script_of(page)], "\n".join(errors[script_of(page)])


def test_each_wrong_call_is_seen(errors):
    seen = {int(line.split(":")[1]) for line in errors["wrong.py"]}
    head = WRONG.splitlines().index("")
    calls = {node.lineno for node in ast.parse(WRONG).body}
    first = WRONG.splitlines().index("Body(moments=spin)") + 1
    assert head and seen == {line for line in calls if line >= first}, "\n".join(errors["wrong.py"])


def test_the_mission_script_runs():
    subprocess.run([sys.executable, "-W", "error", SCRIPT], check=True, stdout=subprocess.DEVNULL)
