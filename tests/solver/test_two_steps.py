"""Two free motions, and two steps, computed together: as one by one."""

import itertools
import math

import numpy as np
import pytest

from attitude import Body, Spin
from attitude._compilation.decorators import entry_point
from attitude._compilation.simd import lanes
from attitude._solver.adaptive import apart, joined
from attitude._solver.march_layout import KEPT_STATE, KEPT_TIME
from attitude._solver.step import LONGEST_PIECE, advance, advance_two, gains, loaded, stored
from attitude.splitting import TorquedRotation
from attitude.torques import ConstantTorque, CustomTorque, LinearDamping

BODY = Body(moments=(10, 20, 26))
SPIN = Spin(epoch="2026-01-01", wxyz=(1, 2, 3, 4), angular_velocity=(0.1, 0.5, 0.1))


@entry_point
def one_by_one(m, h, state):
    moments = m[0], m[1], m[2]
    stored(advance(moments, gains(moments), h, loaded(state)), state)


@entry_point
def together(m, h, one, two, longest):
    moments = m[0], m[1], m[2]
    state = joined(loaded(one), loaded(two))
    squares = lanes((longest[0] * longest[0], longest[1] * longest[1]))
    state, fine = advance_two(moments, gains(moments), lanes((h[0], h[1])), state, squares)
    first, second = apart(state)
    stored(first, one)
    stored(second, two)
    return fine


def state_of(rates, low=0.0):
    state = np.zeros(14)
    state[:4], state[4:7] = (0.5, -0.5, 0.7, 0.1), rates
    state[:4] /= np.sqrt(state[:4] @ state[:4])
    state[7:] = low * np.arange(1.0, 8.0)
    return state


@pytest.mark.parametrize(
    ("one", "two"),
    [(0.02, 0.01), (-0.1, -0.05), (0.9, 0.3), (0.2, 1.0), (1.0, 1.0), (1e-9, 1.2)],
)
def test_two_bodies_move_as_each_alone(one, two):
    """The bits of `advance`, with one piece or several, of the same number or not."""
    moments, longest = np.array([0.4, 0.8, 1.0]), np.full(2, LONGEST_PIECE)
    first, second = state_of((0.3, 1.0, 0.2), 1e-18), state_of((0.9, -0.2, 0.6))
    expected = first.copy(), second.copy()
    for h, state in zip((one, two), expected, strict=True):
        one_by_one(moments, h, state)
    assert together(moments, np.array([one, two]), first, second, longest)
    assert np.array_equal(first, expected[0])
    assert np.array_equal(second, expected[1])


def test_a_body_at_rest_or_a_long_turn_is_refused():
    moments, longest = np.array([0.4, 0.8, 1.0]), np.full(2, LONGEST_PIECE)
    moving = (0.3, 1.0, 0.2)
    for other, h in (((0.0, 0.0, 0.0), 0.1), ((math.nan, 1.0, 0.2), 0.1)):
        given = state_of(moving), state_of(other)
        assert not together(moments, np.array([h, h]), *given, longest)
    steady = np.ones(3)  # one piece, whatever it turns
    assert together(steady, np.array([1.4, 1.4]), state_of(moving), state_of(moving), longest)
    assert not together(steady, np.array([1.6, 1.4]), state_of(moving), state_of(moving), longest)


@pytest.mark.parametrize("torque", [ConstantTorque((1e-2, 2e-2, 0.0)), LinearDamping(0.3)])
@pytest.mark.parametrize("tolerance", [1e-6, 1e-9, 1e-13])
def test_an_adaptive_step_is_two_steps_of_the_scheme(torque, tolerance):
    """Against the loop of fixed steps, which takes them one by one."""
    motion = TorquedRotation(BODY, SPIN, torque, scheme="blanes-moan", step_tolerance=tolerance)
    motion.at(20.0)
    grid = motion._grids[0]
    rows = grid._steps_of(np.zeros(1, dtype=np.int64), np.array([20.0]))
    worst = 0.0
    for before, after in itertools.pairwise(rows):
        state, h = before[KEPT_STATE].copy(), after[KEPT_TIME] - before[KEPT_TIME]
        motion._system.march(state, 0, 0.5 * h, 2, 2)
        worst = max(worst, float(np.max(np.abs(state[:7] - after[KEPT_STATE][:7]))))
    # two roundings of 12 free motions each
    assert len(rows) > 4 and worst < 2e-15


def test_a_torque_is_called_once_at_each_kick():
    """18 calls a step of 12 and 6 free motions: the ends of steps and halves are shared."""
    calls = []

    def torque(t, wxyz, omega):
        calls.append(t)
        return 1e-3 * math.sin(0.1 * t), 1e-3, 0.0

    custom = CustomTorque(torque, depends_on_rate=False)
    motion = TorquedRotation(BODY, SPIN, custom, scheme="blanes-moan", step_tolerance=1e-10)
    grid = motion._grids[0]
    grid.extend(60.0)
    calls.clear()
    before = grid.steps
    grid.extend(160.0)
    # each block of steps finds the first torque anew
    steps = grid.steps - before
    assert steps > 20 and 18 * steps <= len(calls) < 18.5 * steps
