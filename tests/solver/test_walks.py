"""Epoch by epoch across everything that changes from one double of time to the next.

Whole and half turns of each phase, the quadrants of its sine and cosine, and the zeros of each
component: the doubles on both sides, each against its own oracle value.  (Walks of the state across
the regimes and the two series are in tests/solver/test_accuracy.py.)
"""

import math

import numpy as np
import pytest

from attitude import propagate
from attitude._solver import codes
from tests.support.measure import errors, worst
from tests.support.states import State, constants_of

PROMISE = 4e-15  # rad, and of the largest component of the angular velocity
WXYZ = (0.5, -0.1, 0.3, 0.8)
STATES = {
    "short axis": ((10.0, 20.0, 26.0), (1.0, 15.0, 1.0)),
    "long axis": ((3.0, 1.0, 2.5), (0.2, 1.5, -0.4)),
    "short axis, small wobble": ((2.0, 5.0, 6.0), (1e-6, -2e-6, -1.0)),
    "short axis, near the separatrix": ((2.0, 5.0, 6.0), (1.0, -0.7, 1.0 + 1e-9)),
    "long axis, near the separatrix": ((6.0, 2.0, 5.0), (1.0, 1.0 + 1e-12, 0.7)),
    "flip": ((1.0, 2.0, 3.0), (1e-6, 1.0, 1e-7)),
    "on the separatrix": ((2.0, 5.0, 6.0), (1.0, 0.7, 1.0)),
    "symmetric": ((2.0, 2.0, 3.0), (0.3, -0.4, 0.8)),
    "principal axis": ((1.0, 2.0, 3.0), (0.0, 0.0, 1.3)),
}
EIGHTHS = np.arange(1, 17) / 8  # turns: every joint of whole, half and quarter turns, twice
FARTHER = (0, 1001, 12_345_678_901)  # whole turns added


def _constants(state):
    pairs = np.zeros((2, 1, 3, 2))
    pairs[0, 0, :, 0], pairs[1, 0, :, 0] = state.moments, state.omega0
    identity = np.array([[1.0, 0.0, 0.0, 0.0]])
    return constants_of(pairs[0], identity, pairs[1], identity)[0]


def _around(t):
    """Each epoch with two doubles on either side."""
    steps = [t]
    for direction in (-math.inf, math.inf):
        one = np.nextafter(t, direction)
        steps += [one, np.nextafter(one, direction)]
    return sorted(float(x) for x in np.unique(np.concatenate(steps)))


def _check(state, seconds):
    attitude, rate = worst(errors(state, seconds))
    assert attitude.attitude <= PROMISE, attitude
    assert rate <= PROMISE


@pytest.mark.parametrize("phase", ["precession", "nutation"])
@pytest.mark.parametrize("name", STATES)
def test_each_eighth_turn_of_each_phase(name, phase):
    """Backwards and forwards, in the first turns and after 1e3 and 1e10 of them."""
    state = State(name, STATES[name][0], WXYZ, STATES[name][1])
    c = _constants(state)
    rate = float(c[phase][0])
    start = float(c["nutation0"][0]) if phase == "nutation" else 0.0
    if phase == "nutation" and (c["form"] == codes.UNIFORM or c["winds"] == 0.0):
        assert name in ("principal axis", "on the separatrix")
        return  # no such phase, or one that does not return
    for turns in FARTHER:
        forth = (turns + EIGHTHS - start) / rate
        back = (-turns - EIGHTHS - start) / rate
        _check(state, _around(np.concatenate([forth, back])))


@pytest.mark.parametrize("begin", [-0.3, 1e4, -3e9])
@pytest.mark.parametrize("name", STATES)
def test_the_zeros_of_each_component(name, begin):
    """Those of the quaternion and of the angular velocity, each between two adjacent doubles."""
    state = State(name, STATES[name][0], WXYZ, STATES[name][1])
    found = _zeros(state, begin)
    assert len(found) >= (4 if name in ("principal axis", "on the separatrix") else 8)
    _check(state, _around(np.array(found)))


def _zeros(state, begin, at_most=3):
    """Epochs within some twenty radians of `begin` at which a component changes its sign."""
    span = 20.0 / math.hypot(*state.omega0)

    def components(t):
        found = propagate(state.moments, state.wxyz0, state.omega0, t, angular_velocity=True)
        return np.concatenate(found, axis=-1)

    t = np.linspace(begin, begin + span, 400)
    signs = np.sign(components(t))
    found = []
    for k in range(7):
        for i in np.flatnonzero(signs[1:, k] * signs[:-1, k] < 0.0)[:at_most]:
            low, high, sign = float(t[i]), float(t[i + 1]), signs[i, k]
            while np.nextafter(low, high) < high:
                middle = 0.5 * (low + high)
                if np.sign(components(np.array([middle]))[0, k]) == sign:
                    low = middle
                else:
                    high = middle
            found += [low, high]
    return found
