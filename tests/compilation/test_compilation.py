"""Compilation: what is kept on disk, what goes wrong there, and Ctrl-C meanwhile."""

import ast
import os
import shutil
import signal
import subprocess
import sys
from pathlib import Path

import numba
import pytest
from numba.core import caching, event
from numba.core.codegen import JITCodeLibrary

import attitude
from attitude._compilation import deferral, disk_cache
from attitude._compilation.decorators import entry_point, reduction, subroutine
from attitude._compilation.disk_cache import kept_on_disk, stamp_of
from attitude._compilation.instructions import fence
from attitude.scattering import _hapke


def twice(x):
    return 2.0 * x


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.setattr(numba.config, "CACHE_DIR", str(tmp_path))
    return tmp_path


def kept(folder, ending):
    return sorted(folder.rglob(f"*.{ending}"))


def test_kept_for_the_next_process(folder):
    assert kept_on_disk(twice, {})(1.5) == 3.0
    again = kept_on_disk(twice, {})
    assert again(1.5) == 3.0 and again.stats.cache_hits and not again.stats.cache_misses


@pytest.mark.parametrize("ending", ["nbi", "nbc"])
@pytest.mark.parametrize("left", [0, 20])
def test_a_torn_file_is_made_anew(folder, ending, left):
    """As a crash of the machine leaves it: empty, or the beginning alone."""
    kept_on_disk(twice, {})(1.5)
    (torn,) = kept(folder, ending)
    whole = torn.read_bytes()
    torn.write_bytes(whole[:left])
    assert kept_on_disk(twice, {})(1.5) == 3.0
    again = kept_on_disk(twice, {})
    assert again(1.5) == 3.0 and again.stats.cache_hits


def test_nothing_is_kept_that_could_be_out_of_date(folder, monkeypatch):
    """If numba renames the stamp of its index, edits elsewhere would not be noticed."""

    class Renamed(caching.IndexDataCacheFile):
        def __init__(self, *arguments, **named):
            super().__init__(*arguments, **named)
            del self._source_stamp

    monkeypatch.setattr(caching, "IndexDataCacheFile", Renamed)
    assert kept_on_disk(twice, {})(1.5) == 3.0
    assert not kept(folder, "nb?")


def test_a_full_disk_is_no_cache(folder, monkeypatch):
    def full(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("numba.core.caching.IndexDataCacheFile._open_for_write", full)
    assert kept_on_disk(twice, {})(1.5) == 3.0
    assert not kept(folder, "nb?")


def test_an_interrupt_waits_for_the_end_of_the_outermost():
    deferral.hold_interrupts()
    deferral.hold_interrupts()
    signal.raise_signal(signal.SIGINT)
    deferral.release_interrupts()
    with pytest.raises(KeyboardInterrupt):
        deferral.release_interrupts()
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler
    deferral.hold_interrupts()
    deferral.release_interrupts()


def test_a_handler_of_the_user_s_own_stays(monkeypatch):
    seen = []

    def note(number, frame):
        seen.append(number)

    before = signal.signal(signal.SIGINT, note)
    try:
        deferral.hold_interrupts()
        signal.raise_signal(signal.SIGINT)
        deferral.release_interrupts()
        assert seen == [signal.SIGINT] and signal.getsignal(signal.SIGINT) is note
    finally:
        signal.signal(signal.SIGINT, before)


def test_an_interrupted_compilation_can_be_had_again(folder):
    """Ctrl-C while numba is at work; the next call finds nothing half made."""

    class Press(event.Listener):
        def on_start(self, event):
            signal.raise_signal(signal.SIGINT)

        def on_end(self, event):
            pass

    function, press = kept_on_disk(twice, {}), Press()
    event.register("numba:compile", press)
    try:
        with pytest.raises(KeyboardInterrupt):
            function(1.5)
    finally:
        event.unregister("numba:compile", press)
    assert function(1.5) == 3.0


# An entry point and a callback: what they give, and how often they are found on disk.
_BOTH = """
import ctypes, numpy as np
from attitude._compilation.pointers import C_FUNCTION
from attitude.scene._angles import earlier
from attitude.torques._compiled import linear_damping

out = np.zeros((2, 1))
earlier(np.array([10.0]), np.zeros(1), np.array([6.0]), 2.0, out[0], out[1])
print(out[0, 0])
print(sum(earlier.dispatcher.stats.cache_hits.values()))
out, omega, rest = np.zeros(3), np.ones(3), np.eye(3).ravel()
point = lambda x: x.ctypes.data_as(ctypes.POINTER(ctypes.c_double))
call = C_FUNCTION(linear_damping.address)
call(0.0, point(rest), point(omega), point(rest), point(rest), point(out))
print(out[0])
print(linear_damping._function._cache_hits)
"""


def test_an_edit_of_another_file_is_compiled(tmp_path):
    """numba compares the file of a function; what it calls may stand elsewhere."""
    package = Path(attitude.__file__).parent
    copy = tmp_path / "sources" / "attitude"
    shutil.copytree(package, copy, ignore=shutil.ignore_patterns("__pycache__"))
    environment = {
        **os.environ,
        "PYTHONPATH": str(copy.parent),
        "NUMBA_CACHE_DIR": str(tmp_path / "cache"),
    }

    def run():
        ran = subprocess.run(
            [sys.executable, "-P", "-c", _BOTH],
            env=environment,
            capture_output=True,
            text=True,
            check=True,
        )
        return ran.stdout.split()

    def edit(file, name, line, edited):
        called = copy / file
        before, here, after = called.read_text().partition(name)
        changed = after.replace(line, edited, 1)
        assert changed != after, f"{name} is written in another way; edit it in another way here"
        called.write_text(before + here + changed)

    assert run() == ["7.0", "0", "-1.0", "0"]
    # Machine code survives the installation of the same version, and edits of what it does not use.
    for source in copy.rglob("*.py"):
        source.touch()
    with open(copy / "plots.py", "a") as other:
        other.write("# a comment\n")
    assert run() == ["7.0", "1", "-1.0", "1"]
    edit("torques/_compiled.py", "def linear_damping(", "-(p[3 * k]", "(p[3 * k]")
    assert run() == ["7.0", "1", "1.0", "0"]
    edit("_solver/twofloat.py", "def two_sum(a, b):", "    s = a + b\n", "    s = a + b + 1.0\n")
    assert run()[:2] == ["8.0", "0"]
    edit("_compilation/pointers.py", "import", "\n", "\n\n")
    assert run()[2:] == ["1.0", "0"]


def test_imports_are_found_as_python_finds_them():
    package = Path(attitude.__file__).parent
    for path in package.rglob("*.py"):
        text = path.read_text()
        expected = set()
        for node in ast.walk(ast.parse(text)):
            if isinstance(node, ast.Import):
                expected |= {each.name for each in node.names if each.name.startswith("attitude.")}
            if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("attitude"):
                for each in node.names:
                    inner = package.parent.joinpath(*node.module.split("."), each.name)
                    is_module = inner.with_suffix(".py").is_file() or inner.is_dir()
                    expected.add(f"{node.module}.{each.name}" if is_module else node.module)
        expected.discard("attitude._support.annotations")
        assert set(disk_cache._imported(text)) == expected, path


def test_functions_in_closures_count():
    """A loop over a law is compiled from the law too."""

    def closure(called):
        return lambda x: called(x)

    plain, with_law = (stamp_of(closure(each)) for each in (fence, _hapke._of_phase))
    assert plain != with_law
    assert with_law == stamp_of(closure((_hapke._of_phase,)))


def test_users_who_cannot_write_read_what_is_installed(tmp_path, monkeypatch):
    """As root compiles into site-packages, and another user runs."""
    source = tmp_path / "installed.py"
    source.write_text("def thrice(x):\n    return 3.0 * x\n")
    monkeypatch.syspath_prepend(str(tmp_path))
    from installed import thrice

    monkeypatch.setattr(numba.config, "CACHE_DIR", "")
    monkeypatch.delenv("NUMBA_CACHE_DIR", raising=False)
    first = kept_on_disk(thrice, {})
    assert first(1.5) == 4.5
    assert kept(tmp_path / "__pycache__", "nbc")
    chooser = type(first._cache._impl)
    for_users = [each for each in chooser._locator_classes if "UserWide" in each.__name__]
    monkeypatch.setattr(chooser, "_locator_classes", for_users)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "user"))
    again = kept_on_disk(thrice, {})
    assert Path(again._cache.cache_path) != tmp_path / "__pycache__"
    assert again(1.5) == 4.5 and again.stats.cache_hits and not again.stats.cache_misses
    assert again(2) == 6.0 and again.stats.cache_misses


@subroutine
def halved(x):
    return 0.5 * x


@subroutine
def quartered(x):
    return halved(halved(x))


@entry_point
def eighth(x):
    return halved(quartered(x))


def test_machine_code_is_made_of_entry_points_alone(folder, monkeypatch):
    """Callers have that of the functions within."""
    counted = []
    finalize = JITCodeLibrary._finalize_specific

    def counting(self):
        counted.append(self.name)
        finalize(self)

    monkeypatch.setattr(JITCodeLibrary, "_finalize_specific", counting)
    assert eighth.compiled(8.0) == 1.0 and eighth.compiled(4) == 0.5
    names = {name.rpartition(".")[2] for name in counted}
    assert "eighth" in names and names.isdisjoint({"halved", "quartered"})
    # each was compiled for a double and, within the second call, for an integer
    assert [len(one.dispatcher.overloads) for one in (halved, quartered, eighth)] == [2, 2, 2]


@reduction
def rearranged(a, b):
    """b, since sums may be taken in another order, and what the rounded sum leaves of it."""
    return (a + b) - a, fence(a + b) - a


def test_a_fence_keeps_the_order_of_a_sum():
    assert rearranged(1e16, 1.0) == (1.0, 0.0)
    assert rearranged.py_func(1e16, 1.0) == (0.0, 0.0)
