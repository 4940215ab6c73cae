"""Scripts of examples/, run as a reader runs them, and what they print and draw."""

import os
import re
import subprocess
import sys

import pytest

from tests.support.places import ROOT


def run(name, folder, *arguments, **environment):
    pytest.importorskip("matplotlib", reason="matplotlib, which draws them, is not installed")
    return subprocess.run(
        [sys.executable, "-W", "error", ROOT / "examples" / name, *arguments],
        cwd=folder,
        env={**os.environ, "PYTHONPATH": str(ROOT), **environment},
        capture_output=True,
        text=True,
        timeout=300,
    )


def is_picture(path):
    return path.read_bytes()[:4] == b"\x89PNG" and path.stat().st_size > 20_000


def lines(name, folder, *arguments):
    found = run(name, folder, *arguments)
    assert found.stderr == ""
    picture = name.replace(".py", ".png")
    assert is_picture(folder / picture)
    assert f"Picture: {picture}" in found.stdout
    return found.stdout.splitlines()


def numbers(line):
    return [float(x) for x in re.findall(r"[-+]?\d+\.?\d*(?:e[-+]?\d+)?", line)]
