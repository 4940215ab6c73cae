"""Ensembles under torques: the motions of TorquedRotation for every member."""

import copy
import pickle
import subprocess
import sys

import numpy as np
import pytest

from attitude import Arcs, AttitudeError, Body, Ensemble, FreeRotation, Impulse, Spin
from attitude.arcs import AxisCrossesDirection, InertiaChange
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


def test_copies_and_pickles_hold_no_addresses(tmp_path):
    """Parameters of a copy are its own, and another process reads a pickle."""
    torqued = _members(2).torqued(_torques(), step=0.5)
    for again in (copy.deepcopy(torqued), pickle.loads(pickle.dumps(torqued))):
        assert not np.array_equal(again._systems[0].setup[2], torqued._systems[0].setup[2])
        assert np.array_equal(again.at([9.0, 70.0]).wxyz, torqued.at([9.0, 70.0]).wxyz)
    (tmp_path / "t.pkl").write_bytes(pickle.dumps(torqued))
    code = "import pickle; print(pickle.load(open('t.pkl', 'rb')).at([9.0, 70.0]).wxyz.tolist())"
    run = subprocess.run(
        [sys.executable, "-c", code], cwd=tmp_path, capture_output=True, text=True, check=False
    )
    assert run.stdout == f"{torqued.at([9.0, 70.0]).wxyz.tolist()}\n", run


def test_torques_in_python_and_in_time():
    torque = CustomTorque(lambda t, wxyz, omega: -0.01 * omega * (1.0 + 0.5 * np.sin(t)))
    torqued = _members(3).torqued(torque, step=0.5)
    found = torqued.at([50.0, 60.0])
    for k in range(3):
        assert np.array_equal(found.wxyz[k], torqued[k].at([50.0, 60.0]).wxyz)
    with pytest.raises(ZeroDivisionError):
        _members(3).torqued(lambda t, wxyz, omega: omega / 0 if t > 5 else 1 // 0, 0.5).at([9.0])


@pytest.mark.parametrize("kind", ["arcs", "torqued"])
def test_derivatives_and_accelerations_are_those_of_the_members(kind):
    ensemble, t = _members(3), np.array([40.0, 2.0, np.nan, 20.0])
    impulse = Impulse(5.0, (0.5, -1.0, 0.3))
    changed = ensemble.arcs(impulse) if kind == "arcs" else ensemble.torqued(_torques(), step=0.5)
    history = changed.at(t)
    part = history[:, [0, 3]]
    for k in range(3):
        single = changed[k].at(t)
        expected = changed[k].sensitivity_at(t)
        assert np.array_equal(history.sensitivity[k], expected, equal_nan=True)
        assert np.array_equal(part.sensitivity[k], expected[[0, 3]])
        bends = single.angular_acceleration
        assert np.allclose(history.angular_acceleration[k], bends, 0.0, 1e-15, equal_nan=True)
        assert np.allclose(part[k].angular_acceleration, bends[[0, 3]], 0.0, 1e-15)
    rows = history.table()["angular_velocity"].value
    assert np.array_equal(rows, history.angular_velocity.reshape(-1, 3), equal_nan=True)


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
    assert len(ensemble[:0].torqued(_torques(), step=0.5).at([1.0]).wxyz) == 0
    assert len(list(ensemble[:2].torqued(_torques(), step=0.5))) == 2


def test_arcs_of_members():
    ensemble = _members(4)
    momenta = {30.0: (0, 0, -1.0), 60.0: (0.5, 0, 0)}
    changes = [Impulse(at=at, angular_momentum=each) for at, each in momenta.items()]
    found = ensemble.arcs(changes).at(T[~np.isnan(T)], threads=2)
    for k in range(4):
        single = Arcs(ensemble[k].body, ensemble[k].spin, changes).at(T[~np.isnan(T)])
        assert np.array_equal(found.wxyz[k], single.wxyz)
        assert np.array_equal(found.angular_velocity[k], single.angular_velocity)
    with pytest.raises(AttitudeError, match=r"changes\[0\] at -5 s is 5 s earlier"):
        ensemble.arcs(Impulse(at=-5.0, angular_momentum=(0, 0, 1.0)))


@pytest.mark.parametrize("family", ["moments", "tensors", "bodies", "one body"])
def test_arcs_compiled_over_members_have_the_bits_of_single_ones(family):
    random, count = np.random.default_rng(11), 5
    turn = np.linalg.qr(random.normal(size=(count, 3, 3)))[0]
    tensors = turn @ (np.array([10.0, 20.0, 26.0]) * np.eye(3)) @ np.swapaxes(turn, 1, 2)
    tensors = 0.5 * (tensors + np.swapaxes(tensors, 1, 2))
    inertia = {
        "moments": {"moments": random.uniform(4.0, 6.0, (count, 3))},
        "tensors": {"tensors": tensors},
        "bodies": {"body": [Body(tensor=each) for each in tensors]},
        "one body": {"body": Body(tensor=tensors[0])},
    }[family]
    ensemble = Ensemble(
        **inertia,
        wxyz=random.normal(size=(count, 4)),
        angular_velocity=random.normal(size=(count, 3)),
        epoch="2026-01-01",
        frame="ecliptic",
    )
    changes = [
        Impulse(at=30.0, angular_momentum=(0, 0, -1.0)),
        InertiaChange(at=50.0, body=Body(tensor=tensors[1]), angular_momentum=(0.1, 0, 0)),
        Impulse(at="2026-01-01T00:01:40.123", angular_momentum=(0.5, 0, 0), frame="eme2000"),
    ]
    chains, t = ensemble.arcs(changes), np.array([1e4, -5.0, 30.0, 49.0, 50.0, np.nan, 70.0])
    found = chains.at(t, threads=2)
    assert len(chains) == count and found.shape == (count, 7)
    for k in range(count):
        single = Arcs(ensemble[k].body, ensemble[k].spin, changes)
        assert np.array_equal(found.wxyz[k], single.at(t).wxyz, equal_nan=True)
        assert np.array_equal(
            found.angular_velocity[k], single.at(t).angular_velocity, equal_nan=True
        )
        assert np.array_equal(chains[k].wxyz_at(t), single.wxyz_at(t), equal_nan=True)
    second = np.array([1e-9])
    both = chains.at([50.0], second).wxyz[:, 0], chains[2].wxyz_at([50.0], second)[0]
    assert np.array_equal(both[0][2], both[1])


def test_arcs_with_events_and_functions_of_members():
    ensemble = _members(3)
    changes = [
        Impulse(AxisCrossesDirection((1, 0, 0), (0, 0, 1)), (0.3, 0, 0)),
        Impulse(500.0, lambda before: -0.5 * before.angular_velocity),
    ]
    found = ensemble.arcs(changes).at([0.0, 600.0])
    for k in range(3):
        single = Arcs(ensemble[k].body, ensemble[k].spin, changes).at([0.0, 600.0])
        assert np.array_equal(found.wxyz[k], single.wxyz)


def test_arcs_that_fail_name_the_member():
    rod = Ensemble(
        moments=[(10, 20, 26), (0, 1, 1)],
        wxyz=(1, 0, 0, 0),
        angular_velocity=[(0.1, 0.2, 0.3), (0, 1, 0)],
        epoch="2026-01-01",
        names=["sound", "rod"],
    )
    with pytest.raises(AttitudeError, match=r"rod.*changes\[0\] leaves no physical state"):
        rod.arcs(Impulse(at=1.0, angular_momentum=(1.0, 0, 0)))
    with pytest.raises(AttitudeError, match="Impulse or InertiaChange"):
        rod.arcs([3])
    with pytest.raises(AttitudeError, match="sound"):
        rod[:1].arcs(Impulse(at=1.0, angular_momentum=(1.0, 0, 0))).at([1e300])
    assert rod[:0].arcs([]).at([1.0]).shape == (0, 1)
    flat = Ensemble(
        moments=[(10, 20, 26), (1, 2, 5)],
        wxyz=(1, 0, 0, 0),
        angular_velocity=(0, 0, 0.1),
        epoch="2026-01-01",
        on_error="nan",
    )
    with pytest.raises(AttitudeError, match=r"^member 1 of 2: (?!member)"):
        flat.arcs([Impulse(AxisCrossesDirection((1, 0, 0), (0, 1, 0)), (0.3, 0, 0))])
