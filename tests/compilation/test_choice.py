"""Small calls run in Python, larger ones compiled, with the same bits."""

import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from attitude import FreeRotation, Spin, propagate
from attitude._compilation import choice, decorators
from attitude._compilation.decorators import EntryPoint, sized_entry_point, slowly_compiled
from attitude._solver import kernel
from attitude.motions._body import Body
from attitude.scene import _angles

# Machine code that the tests share.
CACHE = os.environ["NUMBA_CACHE_DIR"]
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
    """An empty folder of machine code, later with that of one loop."""
    return tmp_path_factory.mktemp("cache")


_TWO_HALVES = """
from numba.core import event
from attitude import cli, selftest
from attitude._solver import warm_up

class Count(event.Listener):
    names = []
    def on_start(self, happening):
        self.names.append(happening.data["dispatcher"].py_func.__name__)
    def on_end(self, happening):
        pass

event.register("numba:compile", Count())
warm_up._cores = lambda: 2
warm_up.compile_ahead()
assert "classify_all" in Count.names and "hyperbolic" not in Count.names, Count.names
Count.names.clear()
assert selftest.check().passed
assert not Count.names, Count.names
cli.main(["warm-up"])
"""
# Prints the functions that the process has called as machine code, with types of arguments.
_NEEDED = """
import gc
from attitude._compilation.decorators import EntryPoint
print(*sorted(
    f"{each.__name__}{signature}"
    for each in gc.get_objects() if isinstance(each, EntryPoint) and each.run is each._dispatcher
    for signature in each._dispatcher.signatures
), sep="\\n")
"""


def needed(code):
    """What a new process that may use the machine code of other tests needs for some code."""
    command = [sys.executable, "-c", code + _NEEDED]
    found = subprocess.run(command, capture_output=True, text=True, check=True).stdout
    return found.splitlines()


def test_small_work_needs_no_compiler(folder):
    wxyz, loaded, compiled, seconds = run(
        "str(motion); found = motion.at(np.arange(18.0))", folder, ATTITUDE_COMPILE="automatic"
    )
    assert not loaded and compiled == []
    assert 0.0 < seconds < choice.TO_COMPILE
    spin = Spin(epoch="2026-01-01", wxyz=(1, 2, 3, 4), angular_velocity=(1, 15, 1))
    expected = FreeRotation(Body(moments=(10, 20, 26)), spin).at(np.arange(18.0)).wxyz
    assert np.array_equal(wxyz, expected)


def test_small_derivatives_need_no_compiler(folder):
    """With the bits of compiled code."""
    found, loaded, compiled, _ = run(
        "from types import SimpleNamespace\n"
        "found = SimpleNamespace(wxyz=motion.sensitivity_at(np.arange(5.0)))\n"
        "FreeRotation(body, spin.with_covariance({'attitude': 0.1})).covariance_at(np.arange(5.0))",
        folder,
        ATTITUDE_COMPILE="automatic",
    )
    assert not loaded and compiled == []
    spin = Spin(epoch="2026-01-01", wxyz=(1, 2, 3, 4), angular_velocity=(1, 15, 1))
    motion = FreeRotation(Body(moments=(10, 20, 26)), spin)
    assert np.array_equal(found, motion.sensitivity_at(np.arange(5.0)))


_TORQUED = """
from attitude.splitting import TorquedRotation
from attitude.torques import ConstantTorque, CustomTorque
torque = {torque}
found = TorquedRotation(body, spin, torque, step=0.01).at([0.5, 0.998, 1.0])
"""


def test_few_steps_of_a_torque_run_in_python(folder):
    """Users' functions are called by machine code: their exceptions leave the motion as it was."""
    constant = _TORQUED.format(torque="ConstantTorque((0.01, 0.0, -0.02))")
    wxyz, _, compiled, seconds = run(constant, folder, ATTITUDE_COMPILE="automatic")
    assert compiled == [] and seconds > 0.0
    again, _, loaded, _ = run(constant, CACHE, ATTITUDE_COMPILE="always")
    assert wxyz == again and any(each.endswith(".march") for each in loaded)
    given = _TORQUED.format(torque="CustomTorque(lambda t, q, w: (0.01, 0.0, -0.02))")
    _, _, loaded, _ = run(given, CACHE, ATTITUDE_COMPILE="automatic")
    assert any(each.endswith(".march") for each in loaded)


def test_working_memory_is_not_work(monkeypatch):
    """The size of arguments named block or records does not count."""
    monkeypatch.setattr(choice, "MODE", "automatic")
    monkeypatch.setattr(choice, "_spent", 0.0)
    seen = []
    monkeypatch.setattr(choice, "is_worth_python", lambda *call: seen.append(call) or True)

    @slowly_compiled
    def doubled(x, block, records, out):
        for i in range(len(x)):
            out[i] = 2.0 * x[i]

    doubled(np.arange(3.0), np.empty(10**6), np.empty(10**6), np.empty(3))
    predicted, _, _, to_compile, *_ = seen[0]
    assert predicted < 1e-3 and to_compile == choice.TO_COMPILE_DERIVATIVES


@pytest.mark.parametrize("mode", ["automatic", "always"])
def test_large_work_is_compiled(folder, mode):
    size, where = ("200000", folder) if mode == "automatic" else ("2", CACHE)
    wxyz, loaded, compiled, _ = run(
        f"found = motion.at(np.arange({size}.0))[:2]", where, ATTITUDE_COMPILE=mode
    )
    assert loaded and "attitude._solver.kernel.hyperbolic" in compiled
    spin = Spin(epoch="2026-01-01", wxyz=(1, 2, 3, 4), angular_velocity=(1, 15, 1))
    expected = FreeRotation(Body(moments=(10, 20, 26)), spin).at(np.arange(2.0)).wxyz
    assert np.array_equal(wxyz, expected)


def test_many_small_calls_are_compiled_when_they_have_taken_as_long(monkeypatch):
    monkeypatch.setattr(choice, "_forced", 0)
    assert choice.is_worth_python(0.1, kept=False, spent=0.5)
    assert not choice.is_worth_python(choice.TO_COMPILE + 0.1, kept=False)
    assert not choice.is_worth_python(0.1, kept=False, spent=choice.TO_COMPILE)
    assert choice.is_worth_python(0.1, kept=False, spent=choice.TO_COMPILE, to_compile=5.0)
    # calls that repeat will go on
    calls = 10 * choice.REPEATS
    assert choice.is_worth_python(1e-3, kept=False, spent=choice.TO_COMPILE / 12, calls=calls)
    assert not choice.is_worth_python(1e-3, kept=False, spent=choice.TO_COMPILE / 10, calls=calls)
    # loading serves all functions, and the compiler is loaded here
    assert not choice.is_worth_python(1e-9, kept=True)
    with monkeypatch.context() as patched:
        patched.delitem(sys.modules, "numba", raising=False)
        patched.setattr(choice, "_spent", choice.TO_LOAD - 0.2)
        assert choice.is_worth_python(0.1, kept=True, spent=choice.TO_LOAD - 0.2)
        assert not choice.is_worth_python(0.1, kept=True, spent=0.1, calls=10 * choice.REPEATS)
        assert not choice.is_worth_python(0.3, kept=True)
    with choice.InPython():
        # arguments of nested calls have the types of Python
        assert choice.is_worth_python(1e9, kept=False)
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
    monkeypatch.setattr(choice, "_forced", 0)
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
    assert doubled._spent == choice.spent() and doubled._calls == 1
    monkeypatch.setattr(doubled, "_spent", choice.TO_COMPILE)
    doubled(2.0 * x, out)
    assert out.tolist() == [0.0, 4.0, 8.0]
    assert doubled._dispatcher is not None


def test_python_calls_no_machine_code(monkeypatch):
    """An entry point that was compiled before is not compiled for the types of Python."""
    monkeypatch.setattr(choice, "MODE", "automatic")
    monkeypatch.setattr(choice, "_forced", 0)
    monkeypatch.setitem(globals(), "_inner", sized_entry_point(_doubled))
    outer = sized_entry_point(_doubled_by_another)
    monkeypatch.setattr(_inner, "_spent", choice.TO_COMPILE)  # noqa: F821  made above
    x, out = np.arange(3.0), np.empty(3)
    _inner(x, out)  # noqa: F821
    compiled = _inner._dispatcher  # noqa: F821
    assert len(compiled.signatures) == 1
    outer(x[::2], out[::2])
    assert out.tolist() == [0.0, 2.0, 4.0]
    assert len(compiled.signatures) == 1 and outer._dispatcher is None


def _doubled(x, out):
    for i in range(len(x)):
        out[i] = 2.0 * x[i]


def _doubled_by_another(x, out):
    _inner(x, out)  # noqa: F821  set by the test


def test_warm_up_compiles_what_a_later_process_loads():
    """Half in each of two processes, which is what the check needs; then all of a propagation."""
    stages, loops = (
        needed(f"from attitude._solver import warm_up\nwarm_up.{half}()")
        for half in ("compile_stages", "compile_loops")
    )
    assert any(each.startswith("classify_all(") for each in stages)
    assert any(each.startswith("hyperbolic(") for each in loops)
    checked = needed("from attitude.cli._selftest import check\nassert check().passed")
    assert checked and set(checked) <= {*stages, *loops}
    shown = needed("from attitude import cli\ncli.main(['warm-up'])")
    assert any("entry points in" in line and str(CACHE) in line for line in shown)
    later = needed(START + "motion.at(60.0)")
    assert later and set(later) <= set(shown)


def test_the_folder_of_the_status_is_above_all_loops(monkeypatch):
    monkeypatch.delenv("NUMBA_CACHE_DIR")
    folder = decorators.compilation_status().cache
    for loop in (kernel.trigonometric, _angles.earlier):
        assert folder in Path(loop.py_func.__code__.co_filename).parents


@pytest.mark.slow
def test_two_processes_fill_an_empty_folder(tmp_path):
    environment = {**os.environ, "NUMBA_CACHE_DIR": str(tmp_path)}
    ran = subprocess.run(
        [sys.executable, "-c", _TWO_HALVES], env=environment, capture_output=True, text=True
    )
    assert ran.returncode == 0, ran.stderr
    assert list(tmp_path.glob("*/kernel.trigonometric-*.nbi"))
    before = {each.name for each in tmp_path.glob("*/*.nbc")}
    run("found = motion.at(60.0)", tmp_path, ATTITUDE_COMPILE="always")
    assert {each.name for each in tmp_path.glob("*/*.nbc")} == before


def test_propagate_of_one_body_is_the_same_in_python():
    given = (10, 20, 26), (1, 2, 3, 4), (9, 2, 1), [0.0, 1.0, -3e5]
    with choice.compiling():
        expected = propagate(*given)
    assert np.array_equal(propagate(*given), expected)


def _setup(x, out):
    for i in range(len(x)):
        out[i] = x[i] + 1.0


def _loop(x, out):
    for i in range(len(x)):
        out[i] = 2.0 * x[i]


@pytest.fixture
def steps(monkeypatch):
    """Two steps of a call, set-up and loop, and a function apart from them; none compiles."""
    monkeypatch.setattr(choice, "MODE", "automatic")
    monkeypatch.setattr(choice, "_forced", 0)
    monkeypatch.setattr(decorators, "_in_python", {})
    monkeypatch.setattr(decorators, "_compiled", set())
    monkeypatch.setattr(EntryPoint, "dispatcher", property(lambda self: self.py_func))
    made = sized_entry_point(_setup), slowly_compiled(_loop), sized_entry_point(_doubled)
    for each in made:  # no machine code on the disk, whatever other tests left there
        monkeypatch.setitem(each.__dict__, "_is_on_disk", False)
    return made


def test_set_up_follows_the_loop(steps):
    """The steps of a call that repeats compile together before a second is over, and no others."""
    setup, loop, apart = steps
    x, out = np.arange(3.0), np.empty(3)
    apart(x, out)
    for _ in range(choice.STEADY_CALLS):
        setup(x, out)
        loop(x, out)
    assert loop._steps == [setup] and setup._steps == [loop]
    assert decorators.compiled_names() == set()
    share = choice.STEADY_CALLS / (choice.STEADY_CALLS + 1.0)  # before another such call
    loop._spent = 0.9 * share * choice.STEADY  # of 5 s that its compilation takes
    setup(x, out)
    assert decorators.compiled_names() == set()
    loop(x, out)
    assert decorators.compiled_names() == set()
    loop._spent = choice.STEADY
    setup(x, out)
    loop(x, out)
    assert {each.rpartition(".")[2] for each in decorators.compiled_names()} == {"_setup", "_loop"}


def test_a_large_call_takes_nothing_with_it(steps):
    """Work that is large at once compiles its loop; the set-up of few calls stays in Python."""
    setup, loop, _ = steps
    x, out = np.arange(3.0), np.empty(3)
    for _ in range(2):
        setup(x, out)
        loop(x, out)
    loop._pace = 10.0
    for _ in range(choice.REPEATS - 1):
        loop(x, out)
        setup(x, out)
    assert {each.rpartition(".")[2] for each in decorators.compiled_names()} == {"_loop"}


def test_what_is_slow_beside_machine_code_compiles(steps):
    """After ten calls of a loop, such as one loaded from the disk, slower steps follow."""
    setup, loop, apart = steps
    x, out = np.arange(3.0), np.empty(3)
    loop.compiled(x, out)
    apart(x, out)
    for _ in range(choice.REPEATS):
        setup(x, out)
        loop(x, out)
    assert setup._follows and not apart._follows
    assert loop.run is loop.dispatcher  # as fast as before
    setup(x, out)
    assert {each.rpartition(".")[2] for each in decorators.compiled_names()} == {"_setup", "_loop"}


def test_quick_steps_stay_in_python(steps):
    setup, loop, _ = steps
    x, out = np.arange(3.0), np.empty(3)
    loop.compiled(x, out)
    for _ in range(choice.REPEATS):
        setup(x, out)
        loop(x, out)
        loop._seconds += 1.0
    assert not setup._follows and loop.run is loop.dispatcher


def test_a_loop_alone_settles_at_once(steps):
    _, loop, _ = steps
    x, out = np.arange(3.0), np.empty(3)
    for _ in range(3):
        loop.compiled(x, out)
        loop(x, out)
        loop(x, out)
        loop(x, out)
    assert loop.run is loop.dispatcher
