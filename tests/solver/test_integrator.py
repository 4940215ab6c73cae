"""A second witness: Euler's equations and those of the quaternion, integrated by DOP853.

It shares no formula with the solution, nor with the oracle.  Over ten rotations in steps to 1e-13
it keeps 1e-11 rad, which is all that is asked of it: that signs, axes and regimes are right.
"""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from attitude import Body, FreeRotation, Mode, Spin, propagate
from tests.support.measure import error_of
from tests.support.torqued import cross

TOLERANCE = 2e-10  # rad, and relative to the largest rate: the integrator's, with a margin
WXYZ = np.array([0.5, -0.1, 0.7, 0.5]) / np.linalg.norm([0.5, -0.1, 0.7, 0.5])


def integrate(tensor, wxyz0, omega0, t):
    """wxyz (T, 4) and omega (T, 3): J w' = J w x w and q' = q w / 2."""
    inverse = np.linalg.inv(tensor)

    def slope(_, y):
        (w, x, y_, z), (p, q, r) = y[:4], y[4:]
        turning = (-x * p - y_ * q - z * r, w * p + y_ * r - z * q)
        turning += (w * q + z * p - x * r, w * r + x * q - y_ * p)
        return (*(0.5 * each for each in turning), *(inverse @ cross(tensor @ y[4:], y[4:])))

    start = np.concatenate([wxyz0, omega0])
    scale = np.concatenate([np.ones(4), np.full(3, np.linalg.norm(omega0))])
    out = solve_ivp(slope, (0.0, t[-1]), start, "DOP853", t_eval=t, rtol=3e-14, atol=1e-14 * scale)
    assert out.success
    return out.y[:4].T, out.y[4:].T


def _compare(computed, expected):
    for k in range(len(expected[0])):
        assert error_of(computed[0][k], expected[0][k].tolist()) < TOLERANCE
    assert np.max(np.abs(computed[1] - expected[1])) < TOLERANCE * np.max(np.abs(expected[1]))


@pytest.mark.parametrize("direction", [1, -1])
@pytest.mark.parametrize(
    ("moments", "omega0", "mode"),
    [
        ((10.0, 20.0, 26.0), (1.0, 15.0, 1.0), Mode.SHORT_AXIS),  # the paper, section 5
        ((10.0, 20.0, 26.0), (1.3, -0.4, 0.2), Mode.LONG_AXIS),
        ((26.0, 10.0, 20.0), (0.2, -1.3, -0.4), Mode.LONG_AXIS),
        ((20.0, 26.0, 10.0), (-0.3, 0.9, 0.2), Mode.SHORT_AXIS),
        ((10.0, 26.0, 20.0), (1e-7, 1e-7, 1.0), Mode.SHORT_AXIS),  # Dzhanibekov's nut
        ((0.01, 1.0, 1.004), (0.8, 0.3, -0.2), Mode.LONG_AXIS),  # needle
        ((1.0, 1.0, 1.7), (0.3, 0.4, -0.5), Mode.SYMMETRIC),
        ((2.0, 5.0, 6.0), (1.0, -0.7, 1.0), Mode.SEPARATRIX),
        ((10.0, 20.0, 26.0), (0.0, 0.8, 0.0), Mode.PRINCIPAL_AXIS),
        ((1.0, 1.0, 1.0), (0.3, 0.4, -0.5), Mode.SPHERICAL),
    ],
)
def test_ten_rotations(moments, omega0, mode, direction):
    # the integrator's errors grow as exp t along the separatrix and near the middle axis
    rotations = 2 if mode is Mode.SEPARATRIX else 5 if min(omega0) == 1e-7 else 10
    t = direction * np.linspace(0.0, rotations * 2 * np.pi / np.linalg.norm(omega0), 33)
    expected = integrate(np.diag(moments), WXYZ, omega0, t)
    _compare(propagate(moments, WXYZ, omega0, t, angular_velocity=True), expected)
    spin = Spin(epoch="2026-01-01", wxyz=WXYZ, angular_velocity=omega0)
    motion = FreeRotation(Body(moments=moments), spin)
    assert motion.mode is mode
    history = motion.at(t)
    _compare((history.wxyz, history.angular_velocity), expected)


def test_ten_rotations_of_a_full_tensor():
    tensor = np.array([[14.0, -3.0, 1.5], [-3.0, 19.0, 2.0], [1.5, 2.0, 22.0]])
    omega0 = np.array([0.4, -0.9, 0.3])
    t = np.linspace(0.0, 60.0, 33)
    expected = integrate(tensor, WXYZ, omega0, t)
    spin = Spin(epoch="2026-01-01", wxyz=WXYZ, angular_velocity=omega0)
    history = FreeRotation(Body(tensor=tensor), spin).at(t)
    _compare((history.wxyz, history.angular_velocity), expected)


def test_accelerations_are_the_slopes_of_the_rates():
    """angular_acceleration against a difference quotient of the rates, 4e-10 at 1e-5 s."""
    tensor = np.array([[14.0, -3.0, 1.5], [-3.0, 19.0, 2.0], [1.5, 2.0, 22.0]])
    spin = Spin(epoch="2026-01-01", wxyz=WXYZ, angular_velocity=(0.4, -0.9, 0.3))
    motion = FreeRotation(Body(tensor=tensor), spin)
    t, step = np.linspace(0.0, 60.0, 40), 1e-5
    slope = (motion.angular_velocity_at(t + step) - motion.angular_velocity_at(t - step)) / 2e-5
    assert np.max(np.abs(motion.at(t).angular_acceleration - slope)) < 4e-10  # rad/s2
