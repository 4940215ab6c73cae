"""`spin_at` and `published` of every motion: a free rotation from there has the same state."""

import numpy as np
import pytest

from attitude import Arcs, AttitudeError, AttitudeTable, Body, FreeRotation, Impulse, Spin
from attitude.splitting import TorquedRotation
from attitude.torques import ConstantTorque

BODY = Body(moments=(10, 20, 26))
SPIN = Spin("2026-01-01", (1, 2, 3, 4), (0.1, 0.2, 0.5), frame="ecliptic").with_covariance(
    {"attitude": 1e-3, "angular_velocity": 1e-5}
)
PUSH = Impulse(at=30.0, angular_momentum=(0.0, 1.0, 0.5))
MOTIONS = {
    "free": FreeRotation(BODY, SPIN),
    "arcs": Arcs(BODY, SPIN, [PUSH]),
    "torqued": TorquedRotation(BODY, SPIN, ConstantTorque((0.0, 0.1, 0.05)), step=0.1),
}


@pytest.mark.parametrize("name", MOTIONS)
def test_a_free_rotation_starts_from_the_state(name):
    motion = MOTIONS[name]
    spin = motion.spin_at(60.0)
    assert spin.frame == "ecliptic"
    after = FreeRotation(BODY, spin).at(0.0)
    history = motion.at(60.0)
    np.testing.assert_allclose(after.wxyz, history.wxyz, atol=1e-14)
    np.testing.assert_allclose(after.angular_velocity, history.angular_velocity, atol=1e-15)
    # covariances are those of the motion, over the axes of the frame there
    wanted = motion.covariance_at(60.0)
    found = FreeRotation(BODY, spin).covariance_at(0.0)
    np.testing.assert_allclose(found, wanted, rtol=1e-6, atol=1e-12 * np.abs(wanted).max())


@pytest.mark.parametrize("name", MOTIONS)
def test_the_form_of_papers_is_that_of_the_state(name):
    motion = MOTIONS[name]
    found = motion.published("L", at=60.0)
    wanted = FreeRotation(BODY, motion.spin_at(60.0)).published("L")
    assert found.P_psi == wanted.P_psi
    again = Spin.from_periods(BODY, **found.keywords())
    # q and -q are one attitude: angles of papers have no sign of the quaternion
    turned = abs(FreeRotation(BODY, again).at(0.0).wxyz @ motion.at(60.0).wxyz)
    assert turned == pytest.approx(1.0, abs=1e-14)
    start = motion.published("S")
    wanted = FreeRotation(BODY, SPIN).published("S")
    assert start.P_psi == pytest.approx(wanted.P_psi, rel=1e-13)


def test_a_table_has_a_state_and_no_periods():
    t = np.linspace(0.0, 10.0, 101)
    history = MOTIONS["free"].at(t)
    table = AttitudeTable(SPIN.epoch, t, history.wxyz)
    spin = table.spin_at(5.0)
    assert spin.frame == "icrf"
    np.testing.assert_allclose(spin.angular_velocity, history.angular_velocity[50], atol=1e-4)
    with pytest.raises(AttitudeError, match="give a motion with a body"):
        table.published("L", at=5.0)
    with pytest.raises(AttitudeError, match="give one finite epoch"):
        table.spin_at([1.0, 2.0])


@pytest.mark.parametrize("name", MOTIONS)
def test_the_form_of_papers_needs_a_convention(name):
    with pytest.raises(AttitudeError, match="missing a required argument: 'convention'"):
        MOTIONS[name].published()
