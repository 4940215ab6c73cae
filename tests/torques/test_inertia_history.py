"""A tensor of inertia that changes: Euler's equations with I', by another integrator, and laws."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from attitude import AttitudeError, AttitudeTable, Body, Spin, events
from attitude.arcs import Arcs, InertiaChange
from attitude.averaged import AveragedMotion
from attitude.ensemble import Ensemble
from attitude.frames import quaternion
from attitude.splitting import TorquedRotation
from attitude.torques import (
    ConstantTorque,
    CustomTorque,
    GravityGradient,
    InertiaHistory,
    InternalDissipation,
    LinearDamping,
)
from tests.support.torqued import cross

TENSOR = np.array([[10.0, 1.0, 0.5], [1.0, 20.0, 2.0], [0.5, 2.0, 26.0]])
BODY = Body(tensor=TENSOR)
SPIN = Spin(epoch="2026-01-01", wxyz=(1, 2, 3, 4), angular_velocity=(0.1, 0.4, -0.3))
PUSH = np.array([0.02, -0.05, 0.03])
GROWN = np.array([[8.0, -1.0, 0.3], [-1.0, 5.0, 0.6], [0.3, 0.6, 9.0]])


def share(t):
    return 0.5 - 0.5 * np.cos(np.pi * np.clip(np.asarray(t) / 40.0, 0.0, 1.0))


def boom(t):
    """kg m2: a deployment in 40 s, with products of inertia."""
    return share(t)[..., None, None] * GROWN


def melting(t):
    """kg m2: a body that shrinks."""
    return -0.4 * (1.0 - np.exp(-np.asarray(t) / 50.0))[..., None, None] * TENSOR


def solved(change, torque, span):
    """wxyz and angular velocity by d(I w)/dt + w x I w = N, with I' by differences."""

    def slope(t, y):
        omega, h = y[4:], 1e-4
        tensor = TENSOR + change(np.array([t]))[0]
        ends = change(np.array([t - 2 * h, t - h, t + h, t + 2 * h]))
        rate = (ends[0] - 8.0 * ends[1] + 8.0 * ends[2] - ends[3]) / (12.0 * h)
        moment = torque(t, y[:4]) - rate @ omega - cross(omega, tensor @ omega)
        wxyz = 0.5 * quaternion.multiply(y[:4], np.append(0.0, omega))
        return np.concatenate([wxyz, np.linalg.solve(tensor, moment)])

    start = np.concatenate([SPIN.wxyz, SPIN.angular_velocity])
    found = solve_ivp(slope, (0.0, span), start, method="DOP853", rtol=1e-12, atol=1e-13)
    return found.y[:, -1]


def turned(t, wxyz):
    """N m over the body axes: constant over ICRF axes."""
    wxyz = wxyz / np.sqrt(wxyz @ wxyz)
    return quaternion.matrix(wxyz).T @ PUSH


@pytest.mark.parametrize("change", [boom, melting])
@pytest.mark.parametrize(
    ("scheme", "order", "step", "least"),
    [("kick-rotate-kick", 2, 0.05, 4e-6), ("suzuki", 4, 0.4, 4e-9), ("blanes-moan", 4, 1.0, 6e-8)],
)
def test_against_dop853(change, scheme, order, step, least):
    """The order of the scheme: errors fall to a quarter, or a 16th, with half the step."""
    beside = CustomTorque(lambda t, q, w: turned(t, q), depends_on_rate=False)
    end = solved(change, turned, 60.0)
    errors = []
    for h in (step, step / 2, step / 4):
        torques = [InertiaHistory(change), beside]
        motion = TorquedRotation(BODY, SPIN, torques, step=h, scheme=scheme)
        history = motion.at(60.0)
        turn = quaternion.multiply(quaternion.conjugate(end[:4]), history.wxyz)
        errors.append(2.0 * np.linalg.norm(turn[1:]))
        assert np.max(np.abs(history.angular_velocity - end[4:])) < 2.0 * errors[-1]
    assert errors[2] < least
    assert errors[1] / errors[0] == pytest.approx(0.5**order, rel=0.1)
    assert errors[2] / errors[1] == pytest.approx(0.5**order, rel=0.1)


def test_the_momentum_is_kept_to_rounding():
    motion = TorquedRotation(BODY, SPIN, InertiaHistory(boom), step=0.05)
    history = motion.at(np.linspace(-20.0, 60.0, 9))
    momentum = history.body_to_inertial(motion.momentum_in_body(history))
    first = quaternion.matrix(SPIN.wxyz_icrf) @ (TENSOR @ SPIN.angular_velocity)
    assert np.max(np.abs(momentum - first)) < 1e-13 * np.linalg.norm(first)
    assert np.allclose(motion.body_at(60.0).tensor, TENSOR + GROWN, rtol=1e-15)
    with pytest.raises(AttitudeError, match="InertiaHistory changes"):
        motion.constant_body("the energy")
    with pytest.raises(AttitudeError, match="accelerations"):
        _ = motion.at(3.0).angular_acceleration


def test_events_are_those_of_a_table():
    """Whose rates are differences: an InertiaHistory has no accelerations."""
    motion = TorquedRotation(BODY, SPIN, InertiaHistory(boom), step=0.5)
    t = np.linspace(-1.0, 61.0, 4000)
    table = AttitudeTable(SPIN.epoch, t, motion.at(t).wxyz)
    count = 0
    for search, condition in (
        (events.find_discrete, events.illuminated),
        (events.find_minima, events.separation),
    ):
        found, expected = (
            search(0.0, 60.0, condition(one, (0, 0.6, 0.8), (1, 0, 0))) for one in (motion, table)
        )
        assert found.seconds == pytest.approx(expected.seconds, abs=1e-5)
        count += len(found)
    assert count > 4


def test_a_fast_deployment_is_an_instant_change():
    """The attitude differs by the turn in the time that it takes."""
    quick, end = 1e-3, 30.0
    jump = InertiaHistory(lambda t: np.clip(t / quick, 0.0, 1.0)[..., None, None] * GROWN)
    slow = TorquedRotation(BODY, SPIN, jump, step_tolerance=1e-10).at(end)
    instant = InertiaChange(at=0.5 * quick, body=Body(tensor=TENSOR + GROWN))
    history = Arcs(BODY, SPIN, [instant]).at(end)
    turn = quaternion.multiply(quaternion.conjugate(slow.wxyz), history.wxyz)
    assert 2.0 * np.linalg.norm(turn[1:]) < quick * 0.6
    assert np.allclose(slow.angular_velocity, history.angular_velocity, atol=quick)


def test_an_unknown_epoch_has_no_answer():
    history = TorquedRotation(BODY, SPIN, InertiaHistory(boom), step=0.5).at([0.0, np.nan, 5.0])
    assert np.isnan(history.angular_velocity).all(axis=1).tolist() == [False, True, False]


def test_to_the_default_tolerance_over_many_turns():
    """Friction and a periodic inertia over 40 turns, against fixed steps of another scheme."""
    breathing = InertiaHistory(lambda t: 0.3 * np.sin(t / 30.0)[:, None, None] * GROWN)
    for torque in (InternalDissipation(0.05), breathing):
        wxyz = [
            TorquedRotation(BODY, SPIN, torque, **how).at(500.0).wxyz
            for how in ({}, {"step": 0.02, "scheme": "suzuki"})
        ]
        turn = quaternion.multiply(quaternion.conjugate(wxyz[0]), wxyz[1])
        assert 2.0 * np.linalg.norm(turn[1:]) < 1e-9


def test_to_a_tolerance():
    motion = TorquedRotation(BODY, SPIN, InertiaHistory(boom), tolerance=1e-7)
    end = solved(boom, lambda t, q: np.zeros(3), 60.0)
    turn = quaternion.multiply(quaternion.conjugate(end[:4]), motion.at(60.0).wxyz)
    assert 2.0 * np.linalg.norm(turn[1:]) < 1e-7


def test_rates_have_derivatives_by_state_and_moments():
    """Against differences of whole motions: the rates are I(t)^-1 L."""
    motion = TorquedRotation(BODY, SPIN, InertiaHistory(boom), step=0.1)
    _, omega = motion.sensitivity_at(25.0, angular_velocity=True)
    for j in range(9):
        step = 1e-4 * (1.0 if j < 6 else 20.0)
        ends = [
            motion.changed(sign * step * np.eye(9)[j]).at(25.0).angular_velocity
            for sign in (1.0, -1.0)
        ]
        expected = (ends[0] - ends[1]) / (2.0 * step)
        assert np.max(np.abs(omega[:, j] - expected)) < 1e-6 * np.max(np.abs(omega))


def test_covariance_is_that_of_samples():
    """600 samples: standard deviations to 10 %."""
    spin = SPIN.with_covariance({"attitude": 1e-3, "angular_velocity": 1e-4})
    motion = TorquedRotation(BODY, spin, InertiaHistory(boom), step=0.1)
    expected = np.sqrt(np.diag(motion.at(30.0).covariance))[:3]
    center = motion.at(30.0).wxyz
    rng = np.random.default_rng(4)
    changes = rng.normal(size=(600, 6)) * np.repeat([1e-3, 1e-4], 3)
    turns = []
    for change in changes:
        other = motion.changed(np.append(change, np.zeros(3))).at(30.0).wxyz
        turn = quaternion.multiply(other, quaternion.conjugate(center))
        turns.append(2.0 * turn[1:] * np.sign(turn[0]))
    assert np.std(turns, axis=0) == pytest.approx(expected, rel=0.1)


def test_members_of_an_ensemble_turn_as_single_motions():
    rates = [(0.1, 0.4, -0.3), (0.1, 0.4, 0.2)]
    members = Ensemble(BODY, (1, 2, 3, 4), rates, "2026-01-01")
    torque = InertiaHistory(boom)
    found = members.torqued(torque, step=0.1).at([10.0, 50.0])
    for k, rate in enumerate(rates):
        spin = Spin("2026-01-01", (1, 2, 3, 4), rate)
        single = TorquedRotation(BODY, spin, torque, step=0.1).at([10.0, 50.0])
        assert np.array_equal(found.angular_velocity[k], single.angular_velocity)


@pytest.mark.parametrize(
    ("torques", "words"),
    [
        ([InertiaHistory(boom), LinearDamping(0.1)], "LinearDamping cannot act"),
        ([InertiaHistory(boom), InternalDissipation(0.1)], "InternalDissipation cannot act"),
        ([InertiaHistory(boom), InertiaHistory(boom)], "InertiaHistory cannot act"),
        ([InertiaHistory(boom), GravityGradient(lambda t: 0.0, 1.0)], "GravityGradient cannot"),
        (InertiaHistory(lambda t: boom(t + 3.0)), "at the epoch"),
        (InertiaHistory(lambda t: np.zeros(3)), "must return numbers"),
        (InertiaHistory(lambda t: "x"), "must return numbers"),
        (InertiaHistory(lambda t: boom(t) * np.nan), "not finite or not symmetric"),
        (InertiaHistory(lambda t: boom(t) @ np.diag([1.0, 2.0, 3.0])), "symmetric"),
        (InertiaHistory(lambda t: -2.0 * share(t)[:, None, None] * TENSOR), "torque is not finite"),
    ],
)
def test_refusals_are_sentences(torques, words):
    with pytest.raises(AttitudeError, match=words):
        TorquedRotation(BODY, SPIN, torques, step=0.1).at(30.0)


def test_what_is_not_a_function_is_refused():
    with pytest.raises(AttitudeError, match="give a function"):
        InertiaHistory(GROWN)
    with pytest.raises(AttitudeError, match="constant moments"):
        AveragedMotion(BODY, SPIN, [InertiaHistory(boom), ConstantTorque((1e-6, 0, 0))])
