"""`tolerance=`: the error of the answer over a span, and what is estimated of it."""

import itertools
import pickle
from functools import cache

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from attitude import Body, Spin
from attitude.splitting import TorquedRotation
from attitude.torques import ConstantTorque, CustomTorque, _torqued
from tests.support.torque_cases import COUNT, KINDS, angle, case

# Two of each kind, and the rest as a soak.
QUICK = 2 * len(KINDS)
SOAKED = (pytest.param(number, marks=pytest.mark.slow) for number in range(QUICK, COUNT))


@pytest.mark.parametrize("number", [*range(QUICK), *SOAKED])
def test_the_estimate_holds(number):
    """Error of all attitudes <= estimate <= tolerance, against another scheme, 100 times finer."""
    given = case(number)
    motion = given.motion(tolerance=given.tolerance)
    finer = given.motion(tolerance=max(0.01 * given.tolerance, 1e-13), scheme="suzuki")
    error = angle(motion.at(given.seconds).wxyz, finer.at(given.seconds).wxyz)
    assert 0.0 < error <= motion.error_estimate <= given.tolerance


@pytest.mark.parametrize("number", [4, 6, 7, 10, 16, 19])
def test_the_estimate_holds_against_dop853(number):
    given = case(number)
    motion = given.motion(tolerance=given.tolerance)
    t = given.seconds[given.seconds > 0.0]
    start = np.concatenate([given.spin.wxyz_icrf, given.spin.angular_velocity])
    solved = solve_ivp(
        given.derivative, (0.0, t[-1]), start, "DOP853", t, rtol=1e-12, atol=1e-14, max_step=0.02
    )
    expected = solved.y[:4].T / np.sqrt(np.sum(solved.y[:4] ** 2, axis=0))[:, None]
    error = angle(motion.at(t).wxyz, expected)
    # DOP853 errs by some 1e-11 in these spans, and by 1e-8 at the jumps of a pulse (10)
    assert error <= motion.error_estimate + (1e-8 if number == 10 else 1e-10)
    assert motion.error_estimate <= given.tolerance


@pytest.mark.parametrize("number", [0, 2, 4, 6, 17, 27])
@pytest.mark.parametrize("how", [{"step": 0.02}, {"step_tolerance": 1e-8}])
def test_other_motions_estimate_their_error_too(number, how):
    given = case(number)
    motion = given.motion(scheme="suzuki", **how)
    assert motion.error_estimate == 0.0  # nothing asked
    error = angle(motion.at(given.seconds).wxyz, _finer_attitudes(number))
    assert 1e-13 < error <= motion.error_estimate < 1e3 * error


@cache
def _finer_attitudes(number):
    """(N, 4) of a case, for each of the steps that are compared with it."""
    given = case(number)
    finer = given.motion(tolerance=1e-12 if number != 17 else 1e-8)
    return finer.at(given.seconds).wxyz


def test_a_step_of_blanes_moan_keeps_its_tolerance():
    """The estimate was 2.6 times too small; every step of a motion against far finer ones."""
    given = case(1)
    tolerance = 1e-7
    motion = given.motion(step_tolerance=tolerance, scheme="blanes-moan")
    motion.at(10.0)
    grid = motion._grids[0]
    rows = grid._steps_of(np.zeros(1, dtype=np.int64), np.array([10.0]))
    worst = 0.0
    for before, after in itertools.pairwise(rows):
        finer = given.motion(step_tolerance=1e-3 * tolerance, scheme="blanes-moan")._grids[0]
        finer._front = finer._front.from_row(before)
        while finer.reached < after[0]:
            finer._front.last = after[0]
            finer._front.advance(after[0], np.empty((64, 16)), 64)
        worst = max(worst, angle(after[2:6], finer._front.fine[:4]))
    assert len(rows) > 10 and 0.01 * tolerance < worst <= tolerance


def test_the_default_is_a_tolerance():
    given = case(0)
    motion = given.motion()
    assert motion.tolerance == 1e-9 and motion.step is None and motion.step_tolerance is None
    assert motion.scheme.name == "blanes-moan"
    assert 0.0 < motion.error_estimate <= 1e-9 or motion.error_estimate == 0.0
    motion.at(given.seconds)
    assert 1e-12 < motion.error_estimate <= 1e-9


def test_a_span_is_planned_for():
    """Answers inside of it do not depend on the order of the calls."""
    given = case(4)
    span = given.seconds[[0, -1]]
    whole = given.motion(tolerance=1e-7, span=span)
    alone = given.motion(tolerance=1e-7, span=span)
    assert 0.0 < whole.error_estimate <= 1e-7  # without any epoch
    together = whole.at(given.seconds).wxyz
    assert np.array_equal(together[::-1], [alone.at(t).wxyz for t in given.seconds[::-1]])
    assert whole.steps_taken[0] <= span[0] and whole.steps_taken[1] >= span[1]
    again = pickle.loads(pickle.dumps(TorquedRotation(given.body, given.spin, STEADY, span=span)))
    assert again._horizons == whole._horizons and again.tolerance == 1e-9
    dates = TorquedRotation(
        given.body, given.spin, STEADY, span=("2025-12-31T23:59:00", "2026-01-01T00:01:00")
    )
    # a minute of UTC in TDB, whose rate differs by 3e-10
    assert np.allclose(dates._horizons, 60.0, rtol=0.0, atol=1e-7)
    assert "to 1e-09 rad" in repr(dates)
    assert "to 1e-05 rad a step" in repr(given.motion(step_tolerance=1e-5))


STEADY = ConstantTorque((0.0, 0.0, 0.1))


def test_epochs_beyond_the_first_keep_the_tolerance():
    """One by one: planned anew where needed, a few times only."""
    given = case(12)
    motion = given.motion(tolerance=1e-8)
    plans, t = set(), np.linspace(0.1, 60.0, 150)
    found = []
    for each in t:
        found.append(motion.at(each).wxyz)
        plans.add(motion._grids[0]._steps.tolerance)
        assert motion.error_estimate <= 1e-8
    finer = given.motion(tolerance=1e-11).at(t).wxyz
    assert angle(np.array(found), finer) <= 1e-8
    assert 1 < len(plans) < 12


def test_memory_of_adaptive_steps_has_a_bound(monkeypatch):
    """Every other kept state is discarded when there are too many; the answer stays the same."""
    given = case(4)
    t = np.array([19.3, 3.2, -7.0, 0.02, 19.3, 19.31])
    usual = given.motion(step_tolerance=1e-9).at(t)
    monkeypatch.setattr(_torqued, "_MOST", 16)
    motion = given.motion(step_tolerance=1e-9)
    few = motion.at(t)
    assert np.array_equal(few.wxyz, usual.wxyz)
    assert np.array_equal(few.angular_velocity, usual.angular_velocity)
    grid = motion._grids[0]
    assert grid.count <= 17 and grid.every > 32 and grid.steps > 1000


def test_paths_are_sampled_ahead_without_a_trace():
    """The same bits, however many steps are sampled together and however calls are divided."""
    given = case(2)
    t = np.linspace(-2.0, 9.0, 40)
    usual = given.motion(step_tolerance=1e-9).at(t).wxyz
    one_by_one = given.motion(step_tolerance=1e-9)
    assert np.array_equal([one_by_one.at(each).wxyz for each in t], usual)


def test_a_tolerance_below_rounding_is_a_sentence():
    spin = Spin(epoch="2026-01-01", wxyz=(1, 0, 0, 0), angular_velocity=(1.0, 2.0, 3.0))
    driven = CustomTorque(case(4).torques[0].function, False)
    motion = TorquedRotation(Body(moments=(1, 2, 2.5)), spin, driven, tolerance=1e-14)
    with pytest.raises(ValueError, match=r"exceeds the tolerance of 1e-14 rad .* larger tolerance"):
        motion.at(300.0)


def test_plans_do_not_depend_on_blocks(monkeypatch):
    """Blocks follow the clock, the steps that are planned must not."""
    given = case(0)

    def found():
        return given.motion(tolerance=given.tolerance).at(given.seconds).wxyz.tobytes()

    usual = found()
    for most in (1, 7, 100):
        monkeypatch.setattr(_torqued, "_STEPS_AT_ONCE", most)
        assert found() == usual
