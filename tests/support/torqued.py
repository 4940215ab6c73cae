"""Motions under torques by another integrator, and derivatives by differences of whole motions."""

import numpy as np
from scipy.integrate import solve_ivp

from attitude import Spin
from attitude.frames import quaternion
from attitude.splitting import TorquedRotation


def cross(a, b):
    """The product a x b of two vectors (3,), which numpy's function takes ten times as long for."""
    (ax, ay, az), (bx, by, bz) = np.asarray(a).tolist(), np.asarray(b).tolist()
    return np.array([ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx])


def dop853(torque, body, spin, span, rtol=1e-12, atol=1e-14):
    """Attitude (4,) and angular velocity (3,) after a span under torque(t, wxyz, omega)."""

    def slope(t, y):
        wxyz = y[:4] / np.sqrt(y[:4] @ y[:4])
        moment = torque(t, wxyz, y[4:]) - cross(y[4:], body.tensor @ y[4:])
        rate = np.linalg.solve(body.tensor, moment)
        return np.concatenate([0.5 * quaternion.multiply(wxyz, np.append(0.0, y[4:])), rate])

    start = np.concatenate([spin.wxyz, spin.angular_velocity])
    end = solve_ivp(slope, (0.0, span), start, method="DOP853", rtol=rtol, atol=atol).y[:, -1]
    return end[:4] / np.linalg.norm(end[:4]), end[4:]


def torque_at_start(*torques, body, spin):
    """N m over the body axes: what Euler's equations leave of the angular acceleration."""
    history = TorquedRotation(body, spin, torques, step=0.1).at(0.0)
    momentum = body.tensor @ history.angular_velocity
    turned = np.cross(history.turning_rate, momentum)
    return body.tensor @ history.angular_acceleration + turned


def angle(one, two):
    """The angle between two attitudes (4,), rad."""
    return 2.0 * np.linalg.norm(quaternion.multiply(quaternion.conjugate(one), two)[1:])


def turns_by_rates(motion_of, spin, t, h):
    """Derivatives (3, 3) of the turn at t by the rates of the spin: differences of motions.

    motion_of: the motion of a Spin.
    """
    columns = []
    for k in range(3):
        ends = []
        for sign in (-1.0, 1.0):
            omega = np.array(spin.angular_velocity)
            omega[k] += sign * h
            ends.append(motion_of(Spin(spin.epoch, spin.wxyz, omega)).at(t).wxyz)
        turn = quaternion.multiply(ends[1], quaternion.conjugate(ends[0]))
        columns.append(2.0 * turn[1:] * np.sign(turn[0]) / (2.0 * h))
    return np.stack(columns, axis=-1)
