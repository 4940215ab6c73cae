"""Before anything is imported: where machine code is kept, how hypothesis works, no network."""

import gc
import importlib.util
import json
import os
import signal
import socket
import sys
import tempfile
from collections import Counter
from pathlib import Path

import pytest
from hypothesis import settings


def _cache_of_tests():
    """A folder of machine code of its own: what tests compile does not mix with a user's."""
    base = os.environ.get("NUMBA_CACHE_DIR") or os.environ.get("XDG_CACHE_HOME") or "~/.cache"
    folder = Path(base).expanduser() / "attitude-tests"
    try:
        folder.mkdir(parents=True, exist_ok=True)
        folder.touch()
    except OSError:
        return tempfile.mkdtemp(prefix="attitude-tests-")
    return str(folder)


if "xdist" not in sys.modules or "PYTEST_XDIST_WORKER" not in os.environ:
    # Inherited by the processes that tests start, and by those of xdist.
    os.environ["NUMBA_CACHE_DIR"] = _cache_of_tests()
    if "numba" in sys.modules:
        sys.modules["numba"].config.CACHE_DIR = os.environ["NUMBA_CACHE_DIR"]

# Small calls of tests are compiled too; tests/compilation/test_choice.py tests those that run in
# Python.  What modules of tests compute when they are imported runs in Python
# (`pytest_collection`): all workers of xdist import them at the same time, and each would compile
# the same functions.
_CHOSEN = os.environ.get("ATTITUDE_COMPILE", "always")
os.environ["ATTITUDE_COMPILE"] = "automatic" if _CHOSEN == "always" else _CHOSEN
choice = importlib.import_module("attitude._compilation.choice")
os.environ["ATTITUDE_COMPILE"] = _CHOSEN

# The processes that tests start would compile the sources of the package to bytecode each time.
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
sys.dont_write_bytecode = False

# Matrices of the tests are small, and each worker of xdist has a core: threads of BLAS that wait
# for each other take ten times the processor time.  Read when numpy is loaded.
for _name in ("OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "OMP_NUM_THREADS"):
    os.environ.setdefault(_name, "1")

# A test that compares standard error may be the first that compiles.
os.environ["ATTITUDE_QUIET"] = "1"

# Tables of shadows are computed in each test; those that test the files name a folder.
os.environ["ATTITUDE_CACHE"] = "off"

# A first example compiles, or asks mpmath for a thousand digits: no deadline.  In continuous
# integration the same examples are tried in every run.
settings.register_profile("attitude", deadline=None)
settings.register_profile("attitude-ci", deadline=None, derandomize=True)
settings.load_profile("attitude-ci" if os.environ.get("CI") else "attitude")

# A shell that runs the tests in the background tells them to ignore Ctrl-C, and with them every
# process that they start.
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)


def _on_this_machine(function, host):
    """The function of `socket` that connects or resolves; a test that names another host fails.

    `pytest.fail` raises what no `except Exception` of a library that downloads can hide.
    """

    def checked(*arguments, **options):
        name = host(*arguments)
        if name not in _THIS_MACHINE:
            pytest.fail(f"a test tried to reach {name}; tests run without a network")
        return function(*arguments, **options)

    return checked


def _peer(opened, address):
    return address[0] if opened.family in (socket.AF_INET, socket.AF_INET6) else None


_THIS_MACHINE = (None, "", "localhost", "127.0.0.1", "::1")
socket.getaddrinfo = _on_this_machine(socket.getaddrinfo, lambda host=None, *_: host)
socket.socket.connect = _on_this_machine(socket.socket.connect, _peer)


@pytest.hookimpl(wrapper=True)
def pytest_collection():
    """Run small calls in Python while modules of tests are imported."""
    with choice.InPython():
        return (yield)


def pytest_collection_finish():
    """Leave what stays for all tests out of every later search for garbage."""
    gc.collect()
    gc.freeze()


@pytest.hookimpl(wrapper=True)
def pytest_runtestloop():
    """Compile small calls of tests too."""
    if _CHOSEN != "always":
        return (yield)
    with choice.compiling():
        return (yield)


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config, log):
    """Successive tests to one worker: it sets up a module and compiles what it needs once.

    xdist's default gives each worker some tests of every module.
    """
    if config.getoption("dist") == "load":
        from xdist.scheduler import WorkStealingScheduling

        return WorkStealingScheduling(config, log)
    return None


def pytest_addoption(parser):
    """`--short`: the files named in tests/short.txt alone; what skips: see `Skips`."""
    parser.addoption("--short", action="store_true", help="a selection that ends in 90 s")
    parser.addoption("--skipped-to", metavar="FILE", help="write which tests skip, and why")
    parser.addoption("--skipped-in", metavar="FILE", help="only tests that such a file names")


def pytest_configure(config):
    """Not as hooks of this file, which are asked about the files below its folder only."""
    config.pluginmanager.register(Skips(config), "skips of tests")
    if config.getoption("--short"):
        config.pluginmanager.register(Short(), "a short selection")


class Short:
    """With --short: no files of tests and of the package but those that tests/short.txt names."""

    def __init__(self):
        folder = Path(__file__).parent
        self.named = [folder / line for line in (folder / "short.txt").read_text().split()]

    def pytest_ignore_collect(self, collection_path):
        """Leave the others out."""
        return None if collection_path.is_dir() or collection_path in self.named else True


# Modules of the package whose import needs a package.  An error in the import of any other fails
# the run: with --doctest-ignore-import-errors pytest leaves out a module of tests without a word.
_NEED = {
    "attitude/jax.py": "jax",
    "attitude/torch.py": "torch",
    "attitude/survey/_light_curve.py": "sorcha",
}


class Absent(pytest.File):
    """A module that cannot be imported here, because a package is not installed."""

    def collect(self):
        name = _NEED[self.path.relative_to(self.config.rootpath).as_posix()]
        pytest.skip(f"{name} is not installed")


class Skips:
    """Which tests skip and why, as a file and a table; and the tests that another run skipped.

    A file is an object in JSON: a test, or a module that skips as a whole, by its node id, and the
    reason.  `.ci/run` writes one where only the extra `test` is installed, and runs what it names
    where the optional packages are: each test runs once.
    """

    def __init__(self, config):
        self.root = config.rootpath
        before = config.getoption("--skipped-in")
        self.before = json.loads(Path(before).read_text(encoding="utf-8")) if before else None
        self.now, self.run, self.absent = {}, set(), []

    def _name(self, path):
        """The path from the root, as node ids begin; a path outside stays as it is."""
        return (path.relative_to(self.root) if self.root in path.parents else path).as_posix()

    def pytest_ignore_collect(self, collection_path):
        """Import no file of which nothing is wanted."""
        if self.before is None or collection_path.is_dir():
            return None
        name = self._name(collection_path)
        return None if any(node.split("::")[0] == name for node in self.before) else True

    @pytest.hookimpl(wrapper=True)
    def pytest_collect_file(self, file_path, parent):
        found = yield
        name = _NEED.get(self._name(file_path))
        if name is None or importlib.util.find_spec(name):
            return found
        return [Absent.from_parent(parent, path=file_path)]

    def pytest_collection_modifyitems(self, config, items):
        """Keep what is named, and what is within it."""
        if self.before is None:
            return
        named = [any(node.nodeid in self.before for node in item.listchain()) for item in items]
        left = [item for item, kept in zip(items, named, strict=True) if not kept]
        config.hook.pytest_deselected(items=left)
        items[:] = [item for item, kept in zip(items, named, strict=True) if kept]

    def pytest_collectreport(self, report):
        self._keep(report)

    def pytest_runtest_logreport(self, report):
        self.run.add(report.nodeid)
        self._keep(report)

    def _keep(self, report):
        if report.skipped and not hasattr(report, "wasxfail"):
            self.now[report.nodeid] = report.longrepr[2].removeprefix("Skipped: ")

    def pytest_sessionfinish(self, session):
        """A test that is named and does not exist is an error, not a silent gap."""
        if self.before is None or hasattr(session.config, "workerinput"):
            return
        here = self.run | self.now.keys()
        self.absent = [
            node
            for node in self.before
            if (node not in here if "::" in node else not (self.root / node).exists())
        ]
        if self.absent:
            session.exitstatus = pytest.ExitCode.TESTS_FAILED

    def pytest_terminal_summary(self, terminalreporter, config):
        """One table of the reasons, with the number of tests or modules: before, and now."""
        to = config.getoption("--skipped-to")
        if not to and self.before is None:
            return
        if to:
            Path(to).write_text(json.dumps(self.now, indent=1), encoding="utf-8")
        terminalreporter.section("what was skipped, and why")
        before = self.before if self.before is not None else self.now
        first, last = (Counter(skipped.values()) for skipped in (before, self.now))
        terminalreporter.line("  first   left   reason" if self.before else "  tests   reason")
        for reason, count in (first | last).most_common():
            left = f"{last[reason]:7}" if self.before else ""
            terminalreporter.line(f"{first[reason] if self.before else count:7}{left}   {reason}")
        sums = f"{first.total():7}" + (f"{last.total():7}" if self.before else "")
        terminalreporter.line(f"{sums}   in all (a module that skips as a whole counts as one)")
        for node in self.absent:
            terminalreporter.line(f"ERROR {node} was skipped, and does not exist now")
