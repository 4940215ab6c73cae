"""Derivatives of chains of arcs, against differences of the chains themselves."""

import numpy as np
import pytest

from attitude import AttitudeError, Body, Spin
from attitude.arcs import Arcs, AxisCrossesDirection, Impulse, InertiaChange
from attitude.frames import representations as forms
from attitude.frames.quaternion import conjugate, multiply
from attitude.torques import InternalDissipation, LinearDamping

TURN = np.array([[0.36, 0.48, -0.8], [-0.8, 0.6, 0.0], [0.48, 0.64, 0.6]])
BODY = Body(moments=(10, 20, 26))
TENSOR = TURN @ np.diag([3.0, 4.0, 5.5]) @ TURN.T
TILTED = Body(tensor=0.5 * (TENSOR + TENSOR.T))
EVENT = AxisCrossesDirection(axis=(1, 0, 0), direction=(0, 1, 0))
CHAINS = {
    "body frame": (BODY, [Impulse(at=2.0, angular_momentum=(3, -2, 5))]),
    "inertial frame": (BODY, [Impulse(at=2.0, angular_momentum=(3, -2, 5), frame="ecliptic")]),
    "three": (
        TILTED,
        [
            Impulse(at=1.0, angular_momentum=(0.3, -0.2, 0.5), frame="icrf"),
            Impulse(at=3.0, angular_momentum=(0.1, 0.2, -0.4)),
            Impulse(at=7.5, angular_momentum=(-0.3, 0.2, 0.1), frame="eme2000"),
        ],
    ),
    "inertia": (
        BODY,
        [
            InertiaChange(at=2.0, body=Body(moments=(12, 30, 33))),
            Impulse(at=5.0, angular_momentum=(3, -2, 5), frame="icrf"),
        ],
    ),
    "event": (BODY, [Impulse(at=EVENT, angular_momentum=(3, -2, 5), frame="icrf")]),
    "inertia at an event": (
        BODY,
        [InertiaChange(at=EVENT, body=Body(moments=(12, 30, 33)), angular_momentum=(1, 2, 3))],
    ),
}
CHAINS["under torques"] = CHAINS["inertia"]
CHAINS["an event under torques"] = CHAINS["inertia at an event"]
TORQUES = {name: {"torques": LinearDamping(0.7)} for name in CHAINS if "torques" in name}
CHAINS["an event under friction"] = CHAINS["event"]
TORQUES["an event under friction"] = {"torques": InternalDissipation(0.05), "step": 0.005}


def chain_of(name, **more):
    body, changes = CHAINS[name]
    omega = (0.6, 0.9, 0.2)
    return Arcs(body, Spin(epoch="2026-01-01", wxyz=(1, 2, 3, 4), angular_velocity=omega, **more),
                changes, **TORQUES.get(name, {}))  # fmt: skip


@pytest.mark.parametrize("name", CHAINS)
def test_against_differences(name):
    motion = chain_of(name)
    t = np.array([0.0, 0.9, 6.0, 14.0, 40.0])
    attitude, rates = motion.sensitivity_at(t, angular_velocity=True)
    assert attitude.shape == rates.shape == (5, 3, 9)
    step = 1e-5
    for j in range(9):
        ahead, behind = (motion.changed(sign * step * np.eye(9)[j]).at(t) for sign in (1, -1))
        turn = forms.to_rotation_vector(multiply(ahead.wxyz, conjugate(behind.wxyz)))
        scale = np.abs(attitude).max(axis=(1, 2))[:, None]
        assert np.all(np.abs(attitude[..., j] - turn / (2 * step)) < 2e-7 * scale), j
        change = (ahead.angular_velocity - behind.angular_velocity) / (2 * step)
        assert np.all(np.abs(rates[..., j] - change) < 2e-6 * np.maximum(scale, 1.0)), j


def test_before_the_first_change_it_is_the_free_rotation():
    from attitude import FreeRotation

    motion = chain_of("three")
    free = FreeRotation(motion.body, motion.spin)
    t = [-3.0, 0.5]
    assert np.array_equal(motion.sensitivity_at(t), free.sensitivity_at(t, low=[0.0, 0.0]))


def test_no_impulse_changes_nothing():
    """A change that adds nothing leaves the derivatives of the free rotation."""
    from attitude import FreeRotation

    spin = Spin(epoch="2026-01-01", wxyz=(1, 2, 3, 4), angular_velocity=(0.6, 0.9, 0.2))
    motion = Arcs(BODY, spin, [Impulse(at=5.0, angular_momentum=(0, 0, 0))])
    free = FreeRotation(BODY, spin)
    t = np.array([7.0, 300.0])
    found, expected = motion.sensitivity_at(t), free.sensitivity_at(t)
    assert np.abs(found - expected).max() < 1e-11 * np.abs(expected).max()


def test_covariance_and_samples():
    motion = chain_of("three", covariance={"attitude": 1e-5, "angular_velocity": 1e-6})
    t = np.array([0.0, 10.0])
    history = motion.at(t)
    both = np.concatenate(motion.sensitivity_at(t, angular_velocity=True), axis=1)
    expected = both @ motion.spin.covariance @ np.swapaxes(both, 1, 2)
    assert np.allclose(history.covariance, expected, rtol=1e-10)
    turns = np.array(
        [
            forms.to_rotation_vector(multiply(each.at(t).wxyz, conjugate(history.wxyz)))
            for each in motion.sample(300, seed=2)
        ]
    )
    assert np.allclose(np.sqrt(np.mean(turns**2, axis=0)), history.sigma, rtol=0.2)
    assert np.all(history.nonlinearity < 1e-3)


def test_a_momentum_that_is_a_function_is_refused():
    spin = Spin(epoch="2026-01-01", wxyz=(1, 2, 3, 4), angular_velocity=(0.6, 0.9, 0.2))
    change = Impulse(at=2.0, angular_momentum=lambda history: -0.1 * history.angular_velocity)
    with pytest.raises(AttitudeError, match="function"):
        Arcs(BODY, spin, [change]).sensitivity_at(3.0)
