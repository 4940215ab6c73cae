"""Derivatives of motions under torques, against differences of whole motions."""

import numpy as np
import pytest

from attitude import Body, FreeRotation, Spin
from attitude.errors import AttitudeError
from attitude.frames import quaternion
from attitude.frames import representations as forms
from attitude.shape import box
from attitude.splitting import TorquedRotation
from attitude.torques import (
    IGRF,
    AerodynamicTorque,
    ConstantTorque,
    CustomTorque,
    EddyCurrent,
    GravityGradient,
    InertiaHistory,
    InternalDissipation,
    LinearDamping,
    MagneticDipole,
    Maxwell,
    Rheology,
    SolarRadiation,
)

TIMES = np.array([0.0, 0.31, 5.0, -3.3, 12.34])
BODY = Body(moments=(26, 10, 20))
TILTED = Body(tensor=[[10, 1, 0.5], [1, 20, 2], [0.5, 2, 26]])
OFFSET = Body(tensor=TILTED.tensor, center_of_mass=(0.2, 0.1, -0.3))
SPIN = Spin(epoch="2026-01-01", wxyz=(1, 2, 3, 4), angular_velocity=(0.1, 0.9, 0.05))
# For facets: none of them turns into the light or the flow within the span, which makes a kink.
SLOW = Spin(epoch="2026-01-01", wxyz=(1, 0.5, 0.3, 0.2), angular_velocity=(0.01, 0.02, -0.03))
LIT = Spin(epoch="2026-01-01", wxyz=(1, 0.6, -0.3, 0.2), angular_velocity=(0.01, 0.02, -0.03))
AT_REST = Spin(epoch="2026-01-01", wxyz=(1, 2, 3, 4), angular_velocity=(0, 0, 0))


def _orbit(seconds):
    angle = 0.05 * seconds
    return 7e6 * np.stack([np.cos(angle), np.sin(angle), 0.0 * seconds], axis=-1)


def _slow_orbit(seconds):
    return _orbit(0.1 * seconds)


def _from_sun(seconds):
    return 8e8 * np.stack([0.6 + 1e-3 * seconds, -0.5 + 0.0 * seconds, 0.4 + 0.0 * seconds], -1)


# Strong fields, light and air: the torque turns the body within the span.
GRAVITY = GravityGradient(_orbit, 2e20)


def _growing(seconds):
    share = np.sin(0.1 * np.asarray(seconds))[:, None, None]
    return share * np.array([[4.0, 0.5, 0.2], [0.5, 5.0, 0.4], [0.2, 0.4, 3.0]])


MOTIONS = {
    "constant": (BODY, SPIN, ConstantTorque((0, 0.5, 0.26)), {"step": 0.1}),
    "tilted axes": (TILTED, SPIN, ConstantTorque((0.1, 0.5, 0.26)), {"step": 0.1}),
    "from rest": (BODY, AT_REST, ConstantTorque((0, 0.5, 0.26)), {"step": 0.1}),
    "time, attitude and rate": (
        BODY,
        SPIN,
        CustomTorque(lambda t, q, w: (np.sin(t) + q[1], -2 * w[1], q[2] * q[3])),
        {"step": 0.2, "scheme": "suzuki"},
    ),
    "gravity": (TILTED, SPIN, GRAVITY, {"step": 0.1, "scheme": "force-gradient"}),
    "gravity, adaptive": (TILTED, SPIN, GRAVITY, {"step_tolerance": 1e-12}),
    "to a tolerance": (
        BODY,
        SPIN,
        ConstantTorque((0, 0.5, 0.26)),
        {"tolerance": 1e-11, "span": (-10.0, 20.0)},
    ),
    "damping": (TILTED, SPIN, LinearDamping(0.3), {"step": 0.1}),
    "inertia": (
        TILTED,
        SPIN,
        [InertiaHistory(_growing), ConstantTorque((0.1, 0.5, 0.26))],
        {"step": 0.1},
    ),
    "rheology": (
        TILTED,
        SPIN,
        InternalDissipation(Rheology((1, 0.8, 0.5), 9.0, Maxwell(3.0, 9.0))),
        {"step": 0.1},
    ),
    "eddy currents": (
        TILTED,
        SPIN,
        EddyCurrent(1e9 * np.diag([1.0, 2.0, 3.0]), IGRF(2), _orbit),
        {"step": 0.1},
    ),
    "dipole": (TILTED, SPIN, MagneticDipole((3e3, -2e4, 1e4), IGRF(2), _orbit), {"step": 0.1}),
    "sunlight": (
        OFFSET,
        LIT,
        SolarRadiation(box((1.0, 2.0, 0.5)), _from_sun, 0.3, 0.2),
        {"step": 0.1},
    ),
    "air": (
        OFFSET,
        SLOW,
        AerodynamicTorque(box((1.0, 2.0, 0.5)), _slow_orbit, 4e-10),
        {"step": 0.1},
    ),
    "slip": (TILTED, SPIN, [InternalDissipation(3e-3), GRAVITY], {"step": 0.1}),
}


@pytest.mark.parametrize(
    "name",
    [pytest.param(name, marks=[pytest.mark.slow] * (name == "rheology")) for name in MOTIONS],
)
def test_derivatives_are_those_of_the_motion(name):
    body, spin, torque, how = MOTIONS[name]
    motion = TorquedRotation(body, spin, torque, **how)
    # steps of their own for each of 36 changed motions take seconds: less time, and one column of
    # each kind
    adaptive = "step_tolerance" in how
    times = TIMES[:3] if adaptive else TIMES
    attitude, omega = motion.sensitivity_at(times, angular_velocity=True)
    before = motion.at(times)
    most = np.repeat([1.0, 0.1, body.moments.max()], 3)
    for j in (1, 4, 8) if adaptive else range(9):
        # small against the motion, large against the rounding of a difference
        step = 1e-3 * min(most[j], 1.0 / np.max(np.abs(attitude[..., j])))
        turns, rates = 0.0, 0.0
        for weight, k in ((8.0, 1.0), (-8.0, -1.0), (-1.0, 2.0), (1.0, -2.0)):
            after = motion.changed(k * step * np.eye(9)[j]).at(times)
            turn = quaternion.multiply(after.wxyz, quaternion.conjugate(before.wxyz))
            turns = turns + weight / (12.0 * step) * forms.to_rotation_vector(turn)
            change = after.angular_velocity - before.angular_velocity
            rates = rates + weight / (12.0 * step) * change
        # Steps of a motion to a tolerance follow its state: their lengths change its last digits.
        # The strength of a rheology is interpolated: its second derivative jumps between nodes.
        bound = 1e-7 if "step" not in how or name == "rheology" else 2e-9
        assert np.max(np.abs(turns - attitude[..., j])) <= bound * np.max(np.abs(attitude[..., j]))
        scale = np.max(np.abs(omega[..., j])) + np.max(np.abs(attitude[..., j]))
        assert np.max(np.abs(rates - omega[..., j])) <= bound * scale


@pytest.mark.parametrize(
    "name", ["damping", "gravity", "eddy currents", "dipole", "sunlight", "air", "slip"]
)
def test_covariances_follow_from_derivatives(name):
    """Those of the state, by derivatives that are those of the motion; not those without torque."""
    body, spin, torque, how = MOTIONS[name]
    errors = {"attitude": 1e-3, "angular_velocity": 1e-4, "moments": 1e-2}
    spin = spin.with_covariance(errors)
    motion = TorquedRotation(body, spin, torque, **how)
    both = np.concatenate(motion.sensitivity_at(5.0, angular_velocity=True), axis=-2)
    found = motion.covariance_at(5.0)
    np.testing.assert_allclose(found, both @ spin.covariance @ both.T, rtol=1e-9, atol=1e-18)
    free = FreeRotation(body, spin).covariance_at(5.0)
    assert np.max(np.abs(found - free)) > 1e-3 * np.max(np.abs(free))


def test_without_torque_the_derivatives_are_those_of_the_free_rotation():
    motion = TorquedRotation(TILTED, SPIN, ConstantTorque((0, 0, 0)), step=0.1)
    free = FreeRotation(TILTED, SPIN)
    mine = motion.sensitivity_at(TIMES, angular_velocity=True)
    for one, two in zip(mine, free.sensitivity_at(TIMES, angular_velocity=True), strict=True):
        # 124 steps whose roundings, 4e-15 each, grow with the later motion, here tenfold
        assert np.max(np.abs(one - two)) <= 5e-12 * np.max(np.abs(two))


def test_a_flat_body_has_derivatives():
    motion = TorquedRotation(Body(moments=(1, 1, 2)), SPIN, ConstantTorque((0, 0.5, 0)), step=0.1)
    other = TorquedRotation(
        Body(moments=(1, 1, 2 - 1e-9)), SPIN, ConstantTorque((0, 0.5, 0)), step=0.1
    )
    one, two = motion.sensitivity_at(TIMES), other.sensitivity_at(TIMES)
    assert np.max(np.abs(one - two)) <= 1e-6 * np.max(np.abs(two))


# the strength of a rheology is tabulated anew for each of the 400 bodies: 145 s
@pytest.mark.parametrize("name", ["constant", pytest.param("rheology", marks=pytest.mark.slow)])
def test_covariances_are_those_of_samples(name):
    errors = {"attitude": 1e-3, "angular_velocity": 1e-3, "moments": 1e-2}
    spin = SPIN.with_covariance(errors)
    motion = TorquedRotation(BODY, spin, MOTIONS[name][2], step=0.1)
    history = motion.at(10.0)
    turns = []
    for each in motion.sample(400, seed=1):
        turn = quaternion.multiply(each.at(10.0).wxyz, quaternion.conjugate(history.wxyz))
        turns.append(forms.to_rotation_vector(turn))
    found = np.std(turns, axis=0)
    expected = np.sqrt(np.diag(motion.covariance_at(10.0, rates=False)))
    # four standard deviations of that of 400 draws
    assert np.all(np.abs(found / expected - 1.0) <= 4.0 / np.sqrt(800.0))
    assert np.allclose(history.sigma, expected, rtol=1e-12)


def test_bad_input():
    motion = TorquedRotation(BODY, SPIN, ConstantTorque((0, 0.5, 0.26)), step=0.1)
    with pytest.raises(AttitudeError, match="no constant elements"):
        motion.sensitivity_at(1.0, by="elements")
    with pytest.raises(AttitudeError, match="steps"):
        motion.sensitivity_at(np.inf)
    assert np.all(np.isnan(motion.sensitivity_at(np.nan)))
    failing = TorquedRotation(BODY, SPIN, lambda t, q, w: (1.0 / (t < 0.4), 0.0, 0.0), step=0.1)
    with pytest.raises(ZeroDivisionError):
        failing.sensitivity_at(1.0)
