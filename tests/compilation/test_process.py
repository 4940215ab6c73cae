"""Other processes, threads, copies, and installations where nothing can be written."""

import copy
import multiprocessing
import os
import pickle
import shutil
import socket
import subprocess
import sys
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest

import attitude
from attitude import Body, FreeRotation, Spin, propagate
from tests.support import states

MOTION = FreeRotation(
    Body(tensor=[[14.0, -3.0, 1.5], [-3.0, 19.0, 2.0], [1.5, 2.0, 22.0]], mass=5.0),
    Spin(
        epoch="2026-01-01",
        wxyz=(0.5, -0.1, 0.7, 0.5),
        angular_velocity=(0.4, -0.9, 0.3),
        frame="ecliptic",
    ),
)
T = np.linspace(-1e7, 1e7, 2001)


def evaluate(motion, t):
    """At the top of a module, for processes that are spawned."""
    history = motion.at(t)
    return np.array(history.wxyz), np.array(history.angular_velocity)


def _same_bits(one, two):
    assert all(x.tobytes() == y.tobytes() for x, y in zip(one, two, strict=True))


# ---- copies ------------------------------------------------------------------------------------

COPIES = {
    "copy": copy.copy,
    "deepcopy": copy.deepcopy,
    **{
        f"pickle {protocol}": lambda x, p=protocol: pickle.loads(pickle.dumps(x, p))
        for protocol in range(2, pickle.HIGHEST_PROTOCOL + 1)
    },
}


@pytest.mark.parametrize("how", COPIES)
def test_copies_of_a_motion(how):
    """The same bits at any epoch, and arrays that are still read-only."""
    again = COPIES[how](MOTION)
    _same_bits(evaluate(again, T), evaluate(MOTION, T))
    assert again.mode is MOTION.mode and again.period_psi == MOTION.period_psi
    for array in (again._constants, again.body.tensor, again.body.moments_as_pairs):
        assert not array.flags.writeable


@pytest.mark.parametrize("how", COPIES)
@pytest.mark.parametrize("value", [MOTION.body, MOTION.spin])
def test_copies_of_what_is_given(how, value):
    again = COPIES[how](value)
    assert repr(again) == repr(value)
    for name, mine in vars(value).items():
        if isinstance(mine, np.ndarray):
            theirs = vars(again)[name]
            assert theirs.tobytes() == mine.tobytes() and not theirs.flags.writeable
        elif isinstance(mine, tuple):
            assert str(vars(again)[name]) == str(mine)
        elif name != "epoch":
            assert vars(again)[name] == mine
    assert getattr(again, "epoch", None) == getattr(value, "epoch", None)


@pytest.mark.parametrize("how", COPIES)
def test_copies_of_a_history(how):
    history = MOTION.at(T)
    again = COPIES[how](history)
    _same_bits((again.wxyz, again.seconds), (history.wxyz, history.seconds))
    assert not again.wxyz.flags.writeable
    assert np.array_equal(again.angular_velocity, history.angular_velocity)
    assert again.time[0] == history.time[0]


@pytest.mark.parametrize("how", COPIES)
def test_copies_of_an_error(how):
    with pytest.raises(attitude.AttitudeError) as caught:
        Body(moments=(1, 2, 4))
    again = COPIES[how](caught.value)
    assert str(again) == str(caught.value) and type(again) is attitude.AttitudeError


# ---- threads and processes ---------------------------------------------------------------------


def test_threads_share_a_motion():
    """Kernels without the GIL: the bits of one thread."""
    expected = evaluate(MOTION, T)
    with ThreadPoolExecutor(4) as pool:
        for found in pool.map(lambda _: evaluate(MOTION, T), range(12)):
            _same_bits(found, expected)


def test_threads_fill_parts_of_one_array():
    out = np.moveaxis(np.empty((4, T.size)), 0, -1)
    state = states.sample(1)[0][1:]
    parts = np.array_split(np.arange(T.size), 7)

    def fill(rows):
        out[rows[0] : rows[-1] + 1] = propagate(*state, T[rows])

    with ThreadPoolExecutor(4) as pool:
        list(pool.map(fill, parts))
    assert np.array_equal(out, propagate(*state, T))


def test_threads_make_their_own_motions():
    """Constants are made side by side too."""
    sample = states.sample(4, families=["tumbling", "needle", "separatrix"])
    expected = [propagate(*state[1:], T[:50]) for state in sample]
    with ThreadPoolExecutor(4) as pool:
        found = list(pool.map(lambda state: propagate(*state[1:], T[:50]), sample))
    _same_bits(found, expected)


def test_a_spawned_process_gives_the_same_bits():
    """The motion travels as a pickle, the machine code comes from the cache on disk."""
    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(1, mp_context=context) as pool:
        found = pool.submit(evaluate, MOTION, T).result(timeout=120)
    _same_bits(found, evaluate(MOTION, T))


# ---- where nothing can be written --------------------------------------------------------------

PROGRAM = """
import sys, warnings
warnings.simplefilter("error")
import numpy as np
import attitude
from attitude import Body, FreeRotation, Spin, propagate
assert attitude.__file__.startswith(sys.argv[1]), attitude.__file__
wxyz = propagate((10, 20, 26), (1, 0, 0, 0), (1, 15, 1), [0.0, 60.0])
spin = Spin(epoch="2026-01-01", wxyz=(1, 0, 0, 0), angular_velocity=(1, 15, 1))
motion = FreeRotation(Body(moments=(10, 20, 26)), spin)
from attitude._compilation.choice import compiling
from attitude.scene._angles import earlier
early = np.zeros((2, 1))
with compiling():
    earlier(np.array([10.0]), np.zeros(1), np.array([6.0]), 2.0, early[0], early[1])
assert early[0, 0] == 7.0
assert "attitude.scene._angles.earlier" in attitude.compilation_status().compiled
print(np.concatenate([wxyz.ravel(), motion.at(120.0).wxyz]).tobytes().hex())
"""


def _copy_of_the_package(folder):
    """The package without any place for compiled code: a file stands where __pycache__ would be.

    Permissions would not do: whoever runs the tests as root can write anywhere.
    """
    package = folder / "attitude"
    ignored = shutil.ignore_patterns("__pycache__")
    shutil.copytree(Path(attitude.__file__).parent, package, ignore=ignored)
    for directory in [package, *(path for path in package.rglob("*") if path.is_dir())]:
        (directory / "__pycache__").write_text("in the way\n")
    return package


def test_a_read_only_installation_without_a_home_works(tmp_path):
    """Compiled anew in each process; nothing is written, no warning is given.

    One small loop is compiled; the rest runs in Python.
    """
    package = _copy_of_the_package(tmp_path)
    before = sorted(tmp_path.rglob("*"))
    environment = {
        name: value
        for name, value in os.environ.items()
        if not name.startswith(("NUMBA_", "XDG_", "PYTHON"))
    }
    nowhere = str(tmp_path / "attitude" / "__pycache__" / "home")  # below a file: cannot be made
    environment.update(HOME=nowhere, PYTHONDONTWRITEBYTECODE="1", PYTHONPATH=str(tmp_path))
    environment["ATTITUDE_COMPILE"] = "automatic"
    run = subprocess.run(
        [sys.executable, "-c", PROGRAM, str(package)],
        env=environment,
        cwd=tmp_path,
        capture_output=True,
        text=True,
        timeout=200,
    )
    assert run.returncode == 0, run.stderr
    found = np.frombuffer(bytes.fromhex(run.stdout.strip()))
    expected = propagate((10, 20, 26), (1, 0, 0, 0), (1, 15, 1), [0.0, 60.0, 120.0])
    assert found.tobytes() == expected.tobytes()
    assert sorted(tmp_path.rglob("*")) == before


def test_another_process_reads_the_cache():
    """Compiled once for a machine: what one process compiled, the next one finds.

    Machine code belongs to one state of the sources, so a pair of processes that saw an edit
    between them says nothing, and another one is asked.
    """
    code = (
        "from attitude import propagate\n"
        "propagate((10, 20, 26), (1, 0, 0, 0), (1, 15, 1), [0.0, 60.0])\n"
        "from attitude._compilation import disk_cache as source_stamp\n"
        "from attitude._solver import evaluation as motion\n"
        "stats = [f.dispatcher.stats for f in vars(motion).values() if hasattr(f, 'run')]\n"
        "print(source_stamp.stamp_of(motion.prepared), "
        "sum(sum(s.cache_misses.values()) for s in stats), "
        "sum(sum(s.cache_hits.values()) for s in stats))"
    )
    stamps = []
    while len(stamps) < 2 or stamps[-1] != stamps[-2]:
        assert len(stamps) < 5, "the sources do not stay the same from one process to the next"
        run = subprocess.run(
            [sys.executable, "-c", code],
            capture_output=True,
            text=True,
            check=True,
            cwd=Path(attitude.__file__).parent.parent,
        )
        stamp, misses, hits = run.stdout.split()
        stamps.append(stamp)
    assert int(misses) == 0 and int(hits) > 0


@pytest.mark.parametrize("peer", [("192.0.2.1", 80), ("datacenter.invalid", 443)])
def test_a_test_that_reaches_for_the_network_fails(peer):
    """By address or by name; addresses of RFC 5737 and names of RFC 2606 belong to no machine."""
    with pytest.raises(pytest.fail.Exception, match=f"tried to reach {peer[0]}"):
        socket.create_connection(peer, timeout=0.1)
