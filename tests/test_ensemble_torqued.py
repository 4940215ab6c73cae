"""Ensembles under torques: the motions of TorquedRotation for every member."""

import numpy as np
import pytest

from attitude import Arcs, AttitudeError, Body, Ensemble, FreeRotation, Impulse, Spin
from attitude.torques import ConstantTorque, CustomTorque, LinearDamping

EPOCH = "2026-01-01"
BODY = Body(tensor=[[10, 1, 0], [1, 20, 2], [0, 2, 26]])
MOTION = FreeRotation(BODY, Spin(EPOCH, (1, 2, 3, 4), (0.05, 0.02, 0.1), "ecliptic"))
T = np.array([0.0, 3.3, -7.0, 100.0, 40.0, 40.0, np.nan, 1500.2, -300.05])


def _members(count=5):
    return Ensemble.sample(MOTION, count, covariance={"attitude": 0.3, "angular_velocity": 0.02})


def _torques():
    return [LinearDamping(0.02), ConstantTorque((1e-4, 0.0, 2e-4))]


@pytest.mark.parametrize("scheme", ["kick-rotate-kick", "rotate-kick-rotate", "suzuki"])
def test_members_move_as_single_motions(scheme):
    ensemble = _members()
    torqued = ensemble.torqued(_torques(), step=0.5, scheme=scheme)
    found = torqued.at(T)
    for k in range(len(ensemble)):
        single = torqued[k].at(T)
        assert np.array_equal(found.wxyz[k], single.wxyz, equal_nan=True)
        assert np.allclose(
            found.angular_velocity[k], single.angular_velocity, rtol=0, atol=1e-17, equal_nan=True
        )
    assert np.array_equal(torqued.at(T, threads=2).wxyz, found.wxyz, equal_nan=True)
    speeds = np.linalg.norm(found.angular_velocity, axis=(0, 2))
    assert speeds[7] < 0.5 * speeds[0]


def test_bodies_of_their_own():
    moments = np.array([(10, 20, 26), (26, 12, 20), (1, 2, 2.5)])
    rates = np.array([(0.05, 0.02, 0.1), (0.1, 0.01, 0.02), (0.1, 0.2, 0.3)])
    ensemble = Ensemble(moments=moments, wxyz=(1, 2, 3, 4), angular_velocity=rates, epoch=EPOCH)
    torqued, t = ensemble.torqued(_torques(), step=0.5), T[np.isnan(T) | (T >= 0.0)]
    found = torqued.at(t)
    for k in range(3):
        assert np.array_equal(found.wxyz[k], torqued[k].at(t).wxyz, equal_nan=True)
    # before the epoch the damping drives the last one beyond what the step resolves
    with pytest.raises(AttitudeError, match=r"member 2 of 3: a step of 0\.5 s cannot resolve"):
        torqued.at([-300.0])


def test_torques_in_python_and_in_time():
    torque = CustomTorque(lambda t, wxyz, omega: -0.01 * omega * (1.0 + 0.5 * np.sin(t)))
    torqued = _members(3).torqued(torque, step=0.5)
    found = torqued.at([50.0, 60.0])
    for k in range(3):
        assert np.array_equal(found.wxyz[k], torqued[k].at([50.0, 60.0]).wxyz)
    with pytest.raises(ZeroDivisionError):
        _members(3).torqued(lambda t, wxyz, omega: omega / 0 if t > 5 else 1 // 0, 0.5).at([9.0])


def test_bad_input():
    ensemble = _members(3)
    with pytest.raises(AttitudeError, match=r"member \d of 3: a step of 100 s cannot resolve"):
        ensemble.torqued(_torques(), step=100.0)
    with pytest.raises(AttitudeError, match="step is -1"):
        ensemble.torqued(_torques(), step=-1.0)
    with pytest.raises(AttitudeError, match="torques"):
        ensemble.torqued([3], step=1.0)
    with pytest.raises(AttitudeError, match="epochs of their own"):
        later = Ensemble.of([FreeRotation(BODY, Spin("2027-01-01", (1, 0, 0, 0), (0, 0, 1)))])
        (ensemble + later).torqued(_torques(), step=0.1)
    torqued = ensemble.torqued(_torques(), step=0.5)
    with pytest.raises(AttitudeError, match="finite epochs"):
        torqued.at([np.inf])
    with pytest.raises(AttitudeError, match="accelerations under torques"):
        _ = torqued.at([1.0]).angular_acceleration
    assert len(ensemble[:0].torqued(_torques(), step=0.5).at([1.0]).wxyz) == 0


def test_arcs_of_members():
    ensemble = _members(4)
    momenta = {30.0: (0, 0, -1.0), 60.0: (0.5, 0, 0)}
    changes = [Impulse(at=at, angular_momentum=each) for at, each in momenta.items()]
    found = ensemble.arcs(changes).at(T[~np.isnan(T)], threads=2)
    for k in range(4):
        single = Arcs(ensemble[k].body, ensemble[k].spin, changes).at(T[~np.isnan(T)])
        assert np.array_equal(found.wxyz[k], single.wxyz)
        assert np.array_equal(found.angular_velocity[k], single.angular_velocity)
    with pytest.raises(AttitudeError, match="member 0 of 4"):
        ensemble.arcs(Impulse(at=-5.0, angular_momentum=(0, 0, 1.0)))
