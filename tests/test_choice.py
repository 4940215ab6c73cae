"""Small calls run in Python, larger ones compiled, with the same bits."""

import json
import os
import subprocess
import sys

import numpy as np
import pytest

from attitude import FreeRotation, Spin, propagate
from attitude.body import Body
from attitude.compilation import choice
from attitude.compilation.decorators import sized_entry_point

START = """
import json, sys
import numpy as np
import attitude
from attitude import Body, FreeRotation, Spin
body = Body(moments=(10, 20, 26))
spin = Spin(epoch="2026-01-01", wxyz=(1, 2, 3, 4), angular_velocity=(1, 15, 1))
motion = FreeRotation(body, spin)
"""
STATUS = """
status = attitude.compilation_status()
print(json.dumps([found.wxyz.tolist(), "numba" in sys.modules, list(status.compiled),
                  status.seconds_in_python]))
"""


def run(code, folder, **more):
    environment = {**os.environ, "NUMBA_CACHE_DIR": str(folder), **more}
    environment = {name: value for name, value in environment.items() if value}
    ran = subprocess.run(
        [sys.executable, "-c", START + code + STATUS],
        env=environment,
        capture_output=True,
        text=True,
        check=True,
    )
    return json.loads(ran.stdout)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("cache")


def test_small_work_needs_no_compiler(folder):
    wxyz, loaded, compiled, seconds = run(
        "str(motion); found = motion.at(np.arange(18.0))", folder, ATTITUDE_COMPILE="automatic"
    )
    assert not loaded and compiled == []
    assert 0.0 < seconds < choice.TO_COMPILE
    spin = Spin(epoch="2026-01-01", wxyz=(1, 2, 3, 4), angular_velocity=(1, 15, 1))
    expected = FreeRotation(Body(moments=(10, 20, 26)), spin).at(np.arange(18.0)).wxyz
    assert np.array_equal(wxyz, expected)


@pytest.mark.parametrize("mode", ["automatic", "always"])
def test_large_work_is_compiled(folder, mode):
    size = "200000" if mode == "automatic" else "2"
    wxyz, loaded, compiled, _ = run(
        f"found = motion.at(np.arange({size}.0))[:2]", folder, ATTITUDE_COMPILE=mode
    )
    assert loaded and "attitude.solution.kernel.hyperbolic" in compiled
    spin = Spin(epoch="2026-01-01", wxyz=(1, 2, 3, 4), angular_velocity=(1, 15, 1))
    expected = FreeRotation(Body(moments=(10, 20, 26)), spin).at(np.arange(2.0)).wxyz
    assert np.array_equal(wxyz, expected)


def test_many_small_calls_are_compiled_when_they_have_taken_as_long(monkeypatch):
    monkeypatch.setattr(choice, "_spent", 0.0)
    assert choice.is_worth_python(0.1, kept=False)
    assert not choice.is_worth_python(choice.TO_COMPILE + 0.1, kept=False)
    monkeypatch.setattr(choice, "_spent", choice.TO_COMPILE)
    assert not choice.is_worth_python(0.1, kept=False)
    with choice.InPython():
        # arguments of nested calls have the types of Python
        assert choice.is_worth_python(1e9, kept=False)
    monkeypatch.setattr(choice, "_spent", 0.0)
    with choice.compiling():
        assert not choice.is_worth_python(1e-9, kept=False)


def test_the_clock_counts_the_outermost_call(monkeypatch):
    monkeypatch.setattr(choice, "_spent", 0.0)
    with choice.InPython() as outer:
        with choice.InPython() as inner:
            sum(range(10000))
        assert choice.spent() == 0.0
    assert choice.spent() == outer.seconds >= inner.seconds > 0.0


def test_an_entry_point_measures_its_pace(monkeypatch):
    monkeypatch.setattr(choice, "MODE", "automatic")
    monkeypatch.setattr(choice, "_spent", 0.0)

    @sized_entry_point
    def doubled(x, out):
        for i in range(len(x)):
            out[i] = 2.0 * x[i]

    x, out = np.arange(3.0), np.empty(3)
    doubled(x, out)
    assert out.tolist() == [0.0, 2.0, 4.0]
    assert doubled._pace != 1e-4 and choice.spent() > 0.0
    assert doubled._dispatcher is None
    monkeypatch.setattr(choice, "_spent", choice.TO_COMPILE)
    doubled(2.0 * x, out)
    assert out.tolist() == [0.0, 4.0, 8.0]
    assert doubled._dispatcher is not None


def test_warm_up_compiles_what_a_later_process_loads(tmp_path):
    environment = {**os.environ, "NUMBA_CACHE_DIR": str(tmp_path), "ATTITUDE_COMPILE": "automatic"}
    command = [sys.executable, "-m", "attitude", "warm-up"]
    ran = subprocess.run(command, env=environment, capture_output=True, text=True, check=True)
    assert "entry points in" in ran.stdout and str(tmp_path) in ran.stdout
    assert list(tmp_path.glob("*/kernel.trigonometric-*.nbi"))


def test_propagate_of_one_body_is_the_same_in_python():
    given = (10, 20, 26), (1, 2, 3, 4), (9, 2, 1), [0.0, 1.0, -3e5]
    with choice.compiling():
        expected = propagate(*given)
    assert np.array_equal(propagate(*given), expected)
