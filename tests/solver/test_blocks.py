"""Long calls are evaluated in blocks: the same bits, and Ctrl-C is heard between two of them."""

import os
import signal
import threading

import numpy as np
import pytest

from attitude import Body, FreeRotation, Spin, propagate
from attitude._solver import chains, evaluation
from attitude._support import arrays
from attitude.arcs import Arcs, Impulse
from attitude.torques import _arcs

MOMENTS = (10.0, 20.0, 26.0)
WXYZ = (1.0, 0.0, 0.0, 0.0)
OMEGA = (1.0, 15.0, 1.0)
BODY = Body(moments=MOMENTS)
SPIN = Spin("2026-01-01", WXYZ, OMEGA)
FREE = FreeRotation(BODY, SPIN)
CHAIN = Arcs(BODY, SPIN, [Impulse(at=10.0, angular_momentum=(1, 2, 3))])
T = np.linspace(-5.0, 1e3, 5003)
T[7] = np.nan
BODIES = np.array([MOMENTS, (1.0, 2.0, 2.5), (1.0, 1.0, 1.0)])[:, None]

CALLS = {
    "at": lambda: (FREE.at(T).wxyz,),
    "at with low": lambda: (FREE.at(T, low=1e-9 * T).wxyz,),
    "rates": lambda: (FREE.angular_velocity_at(T),),
    "arcs": lambda: (CHAIN.at(T).wxyz, CHAIN.angular_velocity_at(T, 1e-9 * T)),
    "propagate": lambda: propagate(MOMENTS, WXYZ, OMEGA, T, angular_velocity=True),
    "bodies": lambda: propagate(BODIES, WXYZ, OMEGA, T, t_low=1e-9 * T, angular_velocity=True),
    "own epochs": lambda: (propagate(BODIES[:, 0], WXYZ, OMEGA, np.stack([T, T + 1.0, T + 2.0])),),
    "out": lambda: (propagate(MOMENTS, WXYZ, OMEGA, T, out=np.empty((len(T), 4))),),
}


@pytest.fixture
def blocks(monkeypatch):
    """Blocks of 1000 epochs."""
    monkeypatch.setattr(evaluation, "EPOCHS", 1000)
    monkeypatch.setattr(_arcs, "EPOCHS", 1000)
    monkeypatch.setattr(arrays, "_PART", 1000)


@pytest.mark.parametrize("call", CALLS)
def test_blocks_do_not_change_a_bit(call, request):
    whole = CALLS[call]()
    request.getfixturevalue("blocks")
    for one, other in zip(whole, CALLS[call](), strict=True):
        assert np.array_equal(one, other, equal_nan=True)


def interrupting(function, calls):
    """The function, and Ctrl-C from another thread during its second call."""

    def wrapped(*arguments):
        calls.append(arguments)
        found = function(*arguments)
        if len(calls) == 2:
            other = threading.Thread(target=os.kill, args=(os.getpid(), signal.SIGINT))
            other.start()
            other.join()
        return found

    return wrapped


@pytest.mark.usefixtures("blocks")
@pytest.mark.parametrize("call", CALLS)
def test_ctrl_c_is_heard_after_a_block(call, monkeypatch):
    """At most one of five blocks or more is evaluated after the signal."""
    calls = []
    evaluate = interrupting(evaluation.evaluate_all, calls)
    monkeypatch.setattr(evaluation, "evaluate_all", evaluate)
    chain = interrupting(chains.evaluate_arcs, calls)
    monkeypatch.setattr(chains, "evaluate_arcs", chain)
    with pytest.raises(KeyboardInterrupt):
        CALLS[call]()
    assert 2 <= len(calls) <= 3
