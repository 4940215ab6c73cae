"""Modes, periods and ranges: against 50 digits, the measured motion, and at their limits."""

import math
from random import Random

import mpmath
import numpy as np
import pytest

from attitude import AttitudeError, Body, FreeRotation, Mode, Spin
from attitude._solver.regime import regimes
from tests.support.oracle import Oracle
from tests.support.states import TUMBLING, sample
from tests.support.taylor import measured

EPS = np.finfo(float).eps
STATES = {
    "the paper's example, short-axis mode": ((10.0, 20.0, 26.0), (1.0, 15.0, 1.0)),
    "long-axis mode": ((10.0, 20.0, 26.0), (9.0, 2.0, 1.0)),
    "Toutatis": ((3.0836, 3.235, 1.0), (0.1451, 0.33529, -0.98709)),
    "flat, wobbling": ((1.0, 2.0, 3.0), (0.1, -0.2, 1.0)),
}


def motion_of(moments, omega):
    spin = Spin(epoch="2026-01-01", wxyz=(1.0, 2.0, -3.0, 0.5), angular_velocity=omega)
    return FreeRotation(Body(moments=moments), spin)


def exact_periods(moments, omega):
    """P_psi, and P_phi of the axis that the momentum circulates about, in 50 digits."""
    oracle = Oracle(moments, (1, 0, 0, 0), omega, digits=50)
    oracle.at(0.0)
    c = oracle._motion
    with mpmath.mp.workdps(60):
        psi = 4 * c.quarter / abs(c.rate)
        phi = c.steady + c.coupling * c.rate * c.complete / c.quarter
        return psi, 2 * mpmath.pi / phi, oracle.mode


def relative(value, exact):
    with mpmath.mp.workdps(60):
        return abs(float(mpmath.mpf(value) / exact - 1))


def check_periods(moments, omega, tolerance):
    found = regimes(moments, omega)
    psi, phi, mode = exact_periods(moments, omega)
    with mpmath.mp.workdps(60):
        other = 1 / (1 / phi - 1 / psi) if mode == "SAM" else 1 / (1 / phi + 1 / psi)
    long_axis, short_axis = (other, phi) if mode == "SAM" else (phi, other)
    assert relative(found.P_psi, psi) <= tolerance
    assert relative(found.P_phi_L, long_axis) <= tolerance
    assert relative(found.P_phi_S, short_axis) <= tolerance


@pytest.mark.parametrize("state", sample(4, families=TUMBLING), ids=lambda s: s.family)
def test_periods_have_all_digits(state):
    # 1e-15: five units in the last place, of a quotient of numbers known to 31 digits
    check_periods(state.moments, state.omega0, 1e-15)


@pytest.mark.parametrize("side", [1, -1])
def test_periods_at_a_millionth_of_a_millionth_from_the_separatrix(side):
    moments, omega = (10.0, 20.0, 26.0), [1.0, 0.3, 0.0]
    balance = math.sqrt(10 * 10 / (26 * 6))
    for nearness in (1e-11, 3e-12, 1e-12):
        omega[2] = balance * (1.0 + side * nearness)
        assert regimes(moments, omega).one_minus_m < 1e-10
        check_periods(moments, omega, 1e-15)
    omega[2] = balance * (1.0 + side * 4e-13)
    assert 1e-13 < regimes(moments, omega).one_minus_m < 2e-12
    check_periods(moments, omega, 1e-15)


@pytest.mark.parametrize("count", [2, pytest.param(20, marks=pytest.mark.slow)])
@pytest.mark.parametrize("name", STATES)
def test_periods_are_those_of_the_measured_motion_over_many_periods(name, count):
    moments, omega = STATES[name]
    period, turned = measured(moments, omega, turns=count)
    found = regimes(moments, omega)
    assert abs(float(period / found.P_psi) - 1.0) <= 1e-14
    for P_phi in (found.P_phi_L, found.P_phi_S):
        turns = count * found.P_psi / P_phi
        # a part of a turn, relative to all of them; the quaternions at both ends are doubles
        off = (turns - turned + 0.5) % 1.0 - 0.5
        assert abs(off) / turns <= 1e-14


def test_modes_are_those_of_the_exact_numbers():
    names = {"rest": Mode.AT_REST, "separatrix": Mode.SEPARATRIX}
    for state in sample(10):
        mode = regimes(state.moments, state.omega0).mode
        assert mode is motion_of(state.moments, state.omega0).mode
        oracle = Oracle(state.moments, state.wxyz0, state.omega0)
        if oracle.regime in names:
            assert mode is names[oracle.regime]
        elif oracle.regime == "constant":
            assert mode in (Mode.SPHERICAL, Mode.PRINCIPAL_AXIS)
        else:
            circulates = regimes(state.moments, state.omega0).circulates
            assert circulates == (1 if oracle.mode == "SAM" else -1)
            assert mode in (Mode.SYMMETRIC, Mode.LONG_AXIS, Mode.SHORT_AXIS)


def test_batches_are_the_single_states():
    states = sample(10)
    moments, omega = np.array([s.moments for s in states]), np.array([s.omega0 for s in states])
    found = regimes(moments, omega)
    for k, state in enumerate(states):
        single = regimes(state.moments, state.omega0)
        for name in ("mode", "P_psi", "P_phi_L", "one_minus_m", "mean_spin_rate", "flip_time"):
            np.testing.assert_array_equal(getattr(found, name)[k], getattr(single, name))
        np.testing.assert_array_equal(found[k].nutation_S, single.nutation_S)
    grid = regimes(moments[:6].reshape(2, 3, 3), omega[:6].reshape(2, 3, 3))
    assert grid.shape == grid.P_psi.shape == (2, 3) and grid.nutation_L.shape == (2, 3, 2)
    np.testing.assert_array_equal(grid.P_psi.ravel(), found.P_psi[:6])


@pytest.mark.parametrize("name", STATES)
def test_ranges_are_met_and_not_left(name):
    motion = motion_of(*STATES[name])
    regime = motion.regime
    # Extremes lie at quarters of the period; 40001 points and differences of angles for rates miss
    # them by less than 1e-5 of the range.
    t = np.linspace(0.0, regime.P_psi, 40001)
    for convention in "LS":
        phi, theta, _ = motion.angles(t, convention).T
        if (convention == "L") == (regime.circulates < 0):
            theta = np.minimum(theta, np.pi - theta)
        check_range(theta, regime.nutation(convention), 1e-12)
        rate = np.gradient(np.unwrap(phi), t, edge_order=2)
        check_range(rate, regime.precession_rate(convention), 1e-5 * rate.max())
    psi = motion.angles(t, "L" if regime.circulates > 0 else "S")[:, 2]
    center = 0.5 * np.pi if regime.circulates < 0 else 0.0
    away = (psi - center + 0.5 * np.pi) % np.pi - 0.5 * np.pi
    check_range(away, np.array([-regime.libration, regime.libration]), 1e-12)
    speed = np.linalg.norm(motion.angular_velocity_at(t), axis=-1)
    check_range(speed, regime.spin_rate_range, 1e-12)
    assert regime.spin_rate == pytest.approx(speed[0], rel=4 * EPS)
    # the mean of a periodic function by equal steps has all digits
    assert regime.mean_spin_rate == pytest.approx(speed[:-1].mean(), rel=1e-14)
    along = motion.at(t).angular_velocity_inertial @ motion.momentum
    along /= np.linalg.norm(motion.momentum)
    np.testing.assert_allclose(along, regime.spin_rate_along, rtol=1e-14)
    assert regime.P_psi / 2 == pytest.approx(regime.flip_time + regime.dwell_time, rel=4 * EPS)


def check_range(values, expected, tolerance):
    width = expected[1] - expected[0]
    assert values.min() >= expected[0] - tolerance and values.max() <= expected[1] + tolerance
    assert values.min() <= expected[0] + 1e-5 * width + tolerance
    assert values.max() >= expected[1] - 1e-5 * width - tolerance


def test_constants_of_the_energy():
    moments, omega = np.array([10.0, 20.0, 26.0]), np.array([1.0, 15.0, 1.0])
    found = regimes(moments, omega)
    energy, square = (moments * omega**2).sum(), ((moments * omega) ** 2).sum()
    assert found.energy_ratio == pytest.approx(energy * 26.0 / square, rel=4 * EPS)
    assert found.dynamic_inertia == pytest.approx(square / energy, rel=4 * EPS)
    scaled = regimes(moments * 1e-30, omega * 1e9)
    assert scaled.dynamic_inertia == pytest.approx(found.dynamic_inertia * 1e-30, rel=4 * EPS)
    assert scaled.P_psi == pytest.approx(found.P_psi * 1e-9, rel=4 * EPS)


def test_a_slight_wobble_is_no_other_than_none():
    """Each quantity of a uniform rotation is the limit of a wobble that vanishes."""
    for axis in (0, 2):
        omega = np.zeros(3)
        omega[axis] = 2.0
        wobble = omega + 1e-9
        still, moved = regimes((1.0, 2.0, 2.5), omega), regimes((1.0, 2.0, 2.5), wobble)
        assert still.mode is Mode.PRINCIPAL_AXIS and moved.mode is not Mode.PRINCIPAL_AXIS
        names = ("P_psi", "P_phi_L", "P_phi_S", "energy_ratio", "one_minus_m", "mean_spin_rate")
        for name in (*names, "flip_time", "precession_rate_L", "precession_rate_S"):
            np.testing.assert_allclose(
                getattr(still, name), getattr(moved, name), rtol=1e-8, err_msg=name
            )
        np.testing.assert_allclose(still.nutation_L, moved.nutation_L, atol=1e-8)
        np.testing.assert_allclose(still.nutation_S, moved.nutation_S, atol=1e-8)
        assert still.circulates == moved.circulates == (-1 if axis == 0 else 1)


def test_a_needle_that_spins_about_its_length():
    """phi is slower than psi by the ratio of the moments: the difference keeps its digits."""
    thin = 1e-9
    found = regimes((thin, 1.0, 1.0), (1.0, 0.0, 0.0))
    # L/C for a symmetric body: regular precession at L / I
    assert found.P_phi_L == pytest.approx(2 * math.pi / thin, rel=4 * EPS)


def test_the_middle_axis_and_the_separatrix():
    found = regimes((10.0, 20.0, 26.0), (0.0, 3.0, 0.0))
    assert found.mode is Mode.PRINCIPAL_AXIS and found.circulates == 0
    assert found.one_minus_m == 0.0 and math.isinf(found.dwell_time) and math.isinf(found.P_psi)
    # growth of a deviation: w sqrt((B-A)(C-B)/(AC))
    growth = 3.0 * math.sqrt(10.0 * 6.0 / 260.0)
    assert found.flip_time == pytest.approx(math.pi / growth, rel=4 * EPS)
    near = regimes((10.0, 20.0, 26.0), (1e-8, 3.0, 1e-8))
    assert near.flip_time == pytest.approx(found.flip_time, rel=1e-14)
    on = regimes((2.0, 5.0, 6.0), (1.0, 0.7, 1.0))  # 2 (5-2) = 6 (6-5)
    assert on.mode is Mode.SEPARATRIX and math.isinf(on.dwell_time)
    assert on.libration == on.nutation_L[1] == on.nutation_S[1] == 0.5 * math.pi
    assert math.isfinite(on.mean_spin_rate)


def test_the_body_dwells_and_turns_over_as_told():
    """From one passage of the middle plane to the next the motion takes flip + dwell; in the
    flip, l2 = tanh of time over flip / pi, as on the separatrix."""
    moments, omega = (1.0, 2.0, 2.5), (1e-6, 1.0, 2e-6)
    motion = motion_of(moments, omega)
    regime = motion.regime
    t = np.linspace(0.0, regime.P_psi, 100001)
    middle = motion.angular_velocity_at(t)[:, 1] / motion.angular_velocity_at(t)[:, 1].max()
    quick = np.abs(middle) < math.tanh(1.0)
    # both flips of a period, each two e-foldings long; a step of the grid at either end
    assert quick.sum() * t[1] == pytest.approx(2 * 2 * regime.flip_time / math.pi, abs=4 * t[1])


@pytest.mark.parametrize("name", STATES)
def test_polhode_and_herpolhode(name):
    moments, omega = STATES[name]
    motion = motion_of(moments, omega)
    path = motion.polhode(181)
    np.testing.assert_allclose(path[0], path[-1], atol=1e-14 * np.abs(path).max())
    energy = 0.5 * (np.array(moments) * path**2).sum(axis=1)
    np.testing.assert_allclose(energy, motion.energy, rtol=1e-14)
    momentum = np.linalg.norm(path * moments, axis=1)
    np.testing.assert_allclose(momentum, np.linalg.norm(motion.momentum), rtol=1e-14)
    # passed in the order of time, by the motion itself
    t = np.linspace(0.0, motion.period_psi, 40001)
    passed = motion.angular_velocity_at(t)
    nearest = [np.argmin(((passed - point) ** 2).sum(axis=1)) for point in path[:-1]]
    away = [np.linalg.norm(passed[k] - p) for k, p in zip(nearest, path[:-1], strict=True)]
    assert max(away) < 1e-3 * np.abs(path).max()
    forward = np.diff(np.unwrap(np.array(nearest) * 2 * np.pi / 40000))
    assert np.all(forward > 0.0)
    on_plane = motion.herpolhode(t[::100])
    square = (motion.at(t[::100]).angular_velocity ** 2).sum(axis=1)
    radius = np.sqrt(square - motion.regime.spin_rate_along**2)
    np.testing.assert_allclose(np.hypot(*on_plane.T), radius, atol=1e-7 * radius.max())


def test_polhodes_of_degenerate_motions():
    still = motion_of((1.0, 2.0, 3.0), (0.0, 0.0, 2.0)).polhode(5)
    np.testing.assert_array_equal(still, np.tile([0.0, 0.0, 2.0], (5, 1)))
    on = motion_of((2.0, 5.0, 6.0), (1.0, 0.7, -1.0)).polhode(101)
    assert np.all(on[[0, -1]][:, [0, 2]] == 0.0)  # from the middle axis to its other end
    assert on[0, 1] * on[-1, 1] < 0.0


def test_predictable_time_is_when_perturbed_motions_part():
    moments, omega = np.array([1.0, 2.0, 2.5]), np.array([0.3, 0.2, 1.0])
    motion = motion_of(moments, omega)
    error = 1e-6
    told = motion.predictable_time(moments_error=(0.0, error, 0.0), tolerance=0.01)
    other = motion_of(moments * (1.0, 1.0 + error, 1.0), omega)
    # the errors of the motion at the epoch itself, of 1e-6 rad, do not matter after this time
    t = np.linspace(0.98, 1.02, 41) * told
    ours, theirs = motion.at(t).wxyz, other.at(t).wxyz
    parted = 2.0 * np.arccos(np.minimum(np.abs((ours * theirs).sum(axis=1)), 1.0))
    # told is that of the worst angle theta: within the range of theta, some per cent
    assert 0.009 < parted.max() < 0.0105
    doubled = motion.predictable_time(moments_error=(0.0, 2 * error, 0.0), tolerance=0.02)
    assert doubled == pytest.approx(told, rel=1e-6)
    assert math.isinf(motion.predictable_time())
    with pytest.raises(AttitudeError, match="not negative"):
        motion.predictable_time(moments_error=-1.0)
    with pytest.raises(AttitudeError, match="smaller errors"):
        motion.predictable_time(moments_error=3.0)


def test_nothing_is_predictable_beyond_a_flip_whose_side_is_open():
    motion = motion_of((10.0, 20.0, 26.0), (1e-7, 3.0, 1e-7))
    told = motion.predictable_time(rates_error=1e-6)
    assert told <= 0.5 * motion.regime.P_psi
    firm = motion.predictable_time(rates_error=1e-12)
    assert firm > told


def test_random_needles_and_near_symmetric_bodies_keep_the_sum_of_rates():
    random = Random(7)
    for _ in range(200):
        moments = [1.0, 1.0 + 10.0 ** -random.randint(0, 14), 10.0 ** -random.randint(1, 12)]
        moments[1] = min(moments[1], 1.0 + moments[2])
        found = regimes(moments, [random.gauss(0, 1) for _ in range(3)])
        total = 1.0 / found.P_phi_L + 1.0 / found.P_psi
        assert total * found.P_phi_S == pytest.approx(1.0, rel=1e-14)


def test_bad_states_are_sentences():
    with pytest.raises(AttitudeError, match="exceeds the sum"):
        regimes((1.0, 2.0, 5.0), (1.0, 0.0, 0.0))
    with pytest.raises(AttitudeError, match="State 1 of 2"):
        regimes((1.0, 2.0, 2.5), [(1.0, 0.0, 0.0), (math.nan, 0.0, 0.0)])
    with pytest.raises(AttitudeError, match="do not broadcast"):
        regimes(np.ones((2, 3)), np.ones((3, 3)))
    with pytest.raises(AttitudeError, match="shape"):
        regimes((1.0, 2.0), (1.0, 0.0, 0.0))


def test_at_rest_there_is_nothing_to_tell():
    found = regimes((1.0, 2.0, 2.5), (0.0, 0.0, 0.0))
    assert found.mode is Mode.AT_REST and found.spin_rate == found.mean_spin_rate == 0.0
    assert math.isinf(found.P_psi) and math.isinf(found.P_phi_L)
    assert math.isnan(found.energy_ratio) and np.isnan(found.nutation_L).all()


def test_a_regime_does_not_change():
    found = regimes((10.0, 20.0, 26.0), [(1.0, 15.0, 1.0)] * 2)
    with pytest.raises(AttributeError):
        found.m = 1.0
    with pytest.raises(ValueError, match="read-only"):
        found.P_psi[0] = 1.0
    with pytest.raises(ValueError, match="read-only"):
        found.m[0] = 1.0
    assert "2 states" in repr(found) and "SHORT_AXIS" in repr(found[0])
