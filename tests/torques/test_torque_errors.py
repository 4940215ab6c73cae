"""Ctrl-C, exceptions of torques, and forks: never a wrong answer, and never silence."""

import math
import os
import signal
import sys
import threading
import time
import traceback

import numba
import numpy as np
import pytest
from numba.core.compiler_lock import global_compiler_lock

from attitude import AttitudeError, Body, Spin
from attitude._compilation.callbacks import callback_of, raising_callback_errors
from attitude._compilation.pointers import C_FUNCTION
from attitude.splitting import TorquedRotation
from attitude.torques import ConstantTorque, CustomTorque, _torqued
from attitude.torques._torqued import Pace

BODY = Body(moments=(1, 2, 2.5))
SPIN = Spin(epoch="2026-01-01", wxyz=(1, 2, 3, 4), angular_velocity=(0.1, 0.2, -0.3))
HOW = pytest.mark.parametrize("how", [{"step": 0.01}, {"step_tolerance": 1e-7}])


def driven(t, wxyz, omega):
    return 2.0 * math.sin(5.0 * t), 0.0, -omega[2]


# Ctrl-C -------------------------------------------------------------------------------------------


@HOW
@pytest.mark.parametrize("number", [1, 2, 150])
def test_an_exception_at_the_entry_of_the_callback(how, number):
    """Where Python raises KeyboardInterrupt: before the first line, and before any `try`.

    A trace function raises it there in the call of a given number.
    """
    motion = TorquedRotation(BODY, SPIN, driven, **how)
    expected = TorquedRotation(BODY, SPIN, driven, **how).at([0.5, 3.0, -2.0]).wxyz
    motion.at(0.5)
    calls = 0

    def trace(frame, event, argument):
        nonlocal calls
        if frame.f_code.co_name == "torque" and event == "call":
            calls += 1
            if calls == number:
                raise KeyboardInterrupt("at the entry")

    before = sys.gettrace()
    sys.settrace(trace)
    try:
        with pytest.raises(KeyboardInterrupt, match="at the entry"):
            motion.at(3.0)
    finally:
        sys.settrace(before)
    assert calls == number
    assert np.array_equal(motion.at([0.5, 3.0, -2.0]).wxyz, expected)


def interrupted(call, delay):
    """Seconds between a Ctrl-C, sent after a delay, and the KeyboardInterrupt of a call."""
    sent = []

    def send():
        sent.append(time.monotonic())
        os.kill(os.getpid(), signal.SIGINT)

    timer = threading.Timer(delay, send)
    timer.start()
    with pytest.raises(KeyboardInterrupt):
        call()
    heard = time.monotonic()
    timer.join()
    return heard - sent[0]


@pytest.mark.parametrize("delay", [0.05, 0.061, 0.0723, 0.0807, 0.0911])
def test_ctrl_c_is_not_lost(delay):
    """A torque of Python, at whatever instruction the signal arrives."""
    motion = TorquedRotation(BODY, SPIN, driven, step=0.01)
    interrupted(lambda: motion.at(1e4), delay)
    expected = TorquedRotation(BODY, SPIN, driven, step=0.01).at(5.0).wxyz
    assert np.array_equal(motion.at(5.0).wxyz, expected)


@numba.njit
def slow(t, wxyz, omega):
    """A compiled torque of about a millisecond."""
    x = 0.0
    for k in range(100_000):
        x += math.sin(t + k)
    return 1e-9 * x, 0.0, 0.0


@HOW
def test_ctrl_c_is_heard_at_once_in_compiled_loops(how):
    torque = CustomTorque(slow, depends_on_rate=False)
    motion = TorquedRotation(BODY, SPIN, torque, **how)
    motion.at(0.02)
    assert interrupted(lambda: motion.at(1e4), 0.6) < 0.2


@pytest.mark.slow
@HOW
@pytest.mark.parametrize("delay", [0.5, 1.0, 2.0, 4.0])
def test_ctrl_c_is_heard_among_5e7_epochs(how, delay):
    motion = TorquedRotation(BODY, SPIN, ConstantTorque((1e-4, 0, 0)), **how)
    motion.at(100.0)
    t = np.linspace(0.0, 100.0, 50_000_000)
    assert interrupted(lambda: motion.at(t), delay) < 0.2


def test_a_block_takes_a_twentieth_of_a_second():
    pace = Pace(1000)
    with pace.measured():
        pace.items = 60
        time.sleep(0.1)
    assert 15 <= pace.size <= 30
    small = pace.size
    with pace.measured():
        pace.items = small - 1  # fewer show nothing
    assert pace.size == small
    for _ in range(8):
        with pace.measured():
            pace.items = pace.size
    assert pace.size == 1000


def test_the_bits_do_not_depend_on_blocks(monkeypatch):
    """Blocks follow the clock, the answer must not."""
    t = np.array([0.3, 7.77, 31.4, -12.2])

    def found():
        motion = TorquedRotation(BODY, SPIN, driven, step=0.01)
        parts = [motion.at(t).wxyz, motion.at(t - 0.1).wxyz]
        return np.array(parts).tobytes()

    usual = found()
    for most in (1, 5, 32, 100, 2048):
        monkeypatch.setattr(_torqued, "_STEPS", most)
        monkeypatch.setattr(_torqued, "_ROWS", 3 * most)
        assert found() == usual


# What torques raise -------------------------------------------------------------------------------


@numba.njit
def compiled_late(t, wxyz, omega):
    if t > 1.0:
        raise KeyError("no table entry")
    return 0.0, 0.0, 0.0


def plain_late(t, wxyz, omega):
    if t > 1.0:
        raise KeyError("no table entry")
    return 0.0, 0.0, 0.0


@HOW
@pytest.mark.parametrize("depends_on_rate", [True, False])
@pytest.mark.parametrize("function", [compiled_late, plain_late])
def test_what_a_torque_raises_reaches_the_caller(function, depends_on_rate, how):
    """With its message, and with the line that raised it."""
    motion = TorquedRotation(BODY, SPIN, CustomTorque(function, depends_on_rate), **how)
    with pytest.raises(KeyError, match="no table entry") as caught:
        motion.at(2.0)
    last = traceback.extract_tb(caught.tb)[-1]
    assert last.filename == __file__ and last.line == 'raise KeyError("no table entry")'
    if "step" in how:  # the states before it are kept
        assert np.all(np.isfinite(motion.at(0.9).wxyz))


@numba.njit
def shrinks_late(t, wxyz, omega):
    return np.zeros(3 if t < 1.0 else 2)


@pytest.mark.parametrize("depends_on_rate", [True, False])
def test_a_compiled_function_of_too_few_numbers(depends_on_rate):
    motion = TorquedRotation(BODY, SPIN, CustomTorque(shrinks_late, depends_on_rate), step=0.1)
    with pytest.raises(AttitudeError, match="did not return three numbers"):
        motion.at(3.0)


def test_other_errors_still_go_to_the_hook(monkeypatch):
    """Those of finalizers, and those that a callback raises outside of a call."""
    seen = []
    monkeypatch.setattr(sys, "unraisablehook", lambda report: seen.append(report.exc_type))

    class Broken:
        def __del__(self):
            raise OSError("in a finalizer")

    @C_FUNCTION
    def raises(*_):
        raise LookupError("in a callback")

    numbers = [None] * 5
    with raising_callback_errors():
        Broken()
    assert seen == [OSError]
    raises(0.0, *numbers)
    assert seen == [OSError, LookupError]
    with pytest.raises(LookupError), raising_callback_errors():
        raises(0.0, *numbers)
        with pytest.raises(LookupError), raising_callback_errors():
            raises(0.0, *numbers)
    with raising_callback_errors():
        other = threading.Thread(target=raises, args=(0.0, *numbers))
        other.start()
        other.join()
    assert seen == [OSError, LookupError, LookupError]


# Compilation and forks ----------------------------------------------------------------------------


def test_a_compiled_torque_is_compiled_once():
    """60 ms and 0.5 MB for each motion of a fleet."""

    @numba.njit
    def drag(t, wxyz, omega):
        return -0.1 * omega[0], -0.1 * omega[1], -0.1 * omega[2]

    made = callback_of(drag)
    address = made.address
    for _ in range(3):
        motion = TorquedRotation(BODY, SPIN, drag, step=0.1)
        assert motion.torques[0].address() == address
        assert callback_of(drag) is made


def test_a_compiled_torque_is_freed_with_its_function():
    import gc
    import weakref

    def gone():
        @numba.njit
        def drag(t, wxyz, omega):
            return -0.1 * omega[0], -0.1 * omega[1], -0.1 * omega[2]

        assert callback_of(drag).address
        return weakref.ref(callback_of(drag))

    left = gone()
    gc.collect()
    assert left() is None


@pytest.mark.skipif(not hasattr(os, "fork"), reason="no fork on this system")
@pytest.mark.filterwarnings("ignore:This process:DeprecationWarning")
@HOW
def test_a_fork_while_another_thread_integrates(how):
    """Its lock is held for ever in the child, where that thread does not exist."""
    motion = TorquedRotation(BODY, SPIN, driven, **how)
    expected = TorquedRotation(BODY, SPIN, driven, **how).at(2.0).wxyz.tobytes()
    stop = threading.Event()

    def integrate():
        end = 0.0
        while not stop.is_set():
            motion.at(end := end + 1.0)

    other = threading.Thread(target=integrate)
    other.start()
    try:
        while not motion._lock.locked():
            time.sleep(1e-3)
        child = os.fork()
        if child == 0:
            signal.alarm(20)
            os._exit(0 if motion.at(2.0).wxyz.tobytes() == expected else 3)
    finally:
        stop.set()
        other.join()
    assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 0


@pytest.mark.skipif(not hasattr(os, "fork"), reason="no fork on this system")
@pytest.mark.filterwarnings("ignore:This process:DeprecationWarning")
def test_a_fork_while_another_thread_compiles():
    TorquedRotation(BODY, SPIN, compiled_late, step=0.1)  # numba is in use
    held, begin = threading.Event(), time.monotonic()

    def compile_slowly():
        with global_compiler_lock:
            held.set()
            time.sleep(0.3)

    other = threading.Thread(target=compile_slowly)
    other.start()
    held.wait()
    child = os.fork()
    if child == 0:
        signal.alarm(20)
        os._exit(0 if numba.njit(lambda x: x + 1)(1) == 2 else 3)
    other.join()
    assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 0
    assert time.monotonic() - begin > 0.3
