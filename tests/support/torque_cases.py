"""Fifty motions under torques on which estimates of the error are compared with the error."""

import math
from typing import NamedTuple

import numba
import numpy as np

from attitude import Body, Spin
from attitude.frames import quaternion
from attitude.shape import box
from attitude.splitting import TorquedRotation
from attitude.torques import (
    ConstantTorque,
    CustomTorque,
    GravityGradient,
    InternalDissipation,
    LinearDamping,
    SolarRadiation,
)
from tests.support.torqued import cross

COUNT = 50
AU = 149597870700.0
KINDS = (
    *("constant", "gravity", "eccentric", "damping", "driven", "sunlight", "plain", "dipole"),
    *("friction", "several", "pulse", "spin-up"),
)

DAMPED = ("damping", "plain", "friction", "several", "spin-up")


class Case(NamedTuple):
    """A motion, the seconds of its epochs, and the tolerance of its answer."""

    kind: str
    body: Body
    spin: Spin
    torques: list
    seconds: np.ndarray
    tolerance: float

    def motion(self, **how):
        return TorquedRotation(self.body, self.spin, self.torques, **how)

    def derivative(self, t, y):
        """The derivative of (wxyz, omega), for integrators of other kinds."""
        q, w = y[:4] / np.sqrt(y[:4] @ y[:4]), y[4:]
        momentum = self.body.tensor @ w
        torque = np.array(self.torques[0].function(t, q, w)) - cross(w, momentum)
        rate = 0.5 * quaternion.multiply(q, np.append(0.0, w))
        return np.concatenate([rate, np.linalg.solve(self.body.tensor, torque)])


@numba.njit
def _driven(t, q, w):
    return math.sin(1.3 * t), 0.4 * math.cos(2.1 * t), 0.3 * math.sin(0.7 * t) * q[1]


def _plain(t, q, w):
    return 2.0 * math.sin(5.0 * t), 0.0, -w[2]


@numba.njit
def _dipole(t, q, w):
    b, c = math.cos(0.3 * t), math.sin(0.3 * t)
    a, x, y, z = q[0], q[1], q[2], q[3]
    bx = (a * a + x * x - y * y - z * z) * b + 2.0 * (x * y + a * z) * c
    by = 2.0 * (x * y - a * z) * b + (a * a - x * x + y * y - z * z) * c
    return -3.0 * by, 3.0 * bx, 0.0


@numba.njit
def _pulse(t, q, w):
    on = 1.0 if math.sin(0.9 * t) > 0.3 else 0.0
    return 0.5 * on, -0.3 * on, 0.2 * on


def _orbit(e, turn):
    def path(seconds):
        anomaly = mean = turn * seconds
        for _ in range(25):
            anomaly = mean + e * np.sin(anomaly)
        x, y = np.cos(anomaly) - e, np.sqrt(1.0 - e * e) * np.sin(anomaly)
        return np.stack([x, y, 0.0 * x], axis=-1)

    return path


def _torques(kind, random, size):
    """Torques of a kind on a body whose torques are of about a size."""
    vector = size * random.normal(size=3)
    if kind == "constant":
        return [ConstantTorque(vector)]
    if kind in ("gravity", "eccentric"):
        return [GravityGradient(_orbit(0.4 if kind == "eccentric" else 0.0, 0.5), 0.25)]
    if kind == "damping":
        return [LinearDamping(np.diag(0.5 * np.abs(vector)))]
    if kind == "sunlight":
        place = np.array([0.6, 0.5, -0.2]) * AU
        shape, flux = box((1.0, 2.0, 0.4), center=(0.3, 0.1, -0.2)), 1e8 * size
        still = SolarRadiation(
            shape, lambda s: np.broadcast_to(place, (*np.shape(s), 3)), 0.4, 0.3, flux=flux
        )
        return [still]
    if kind == "friction":
        return [InternalDissipation(0.02 * size)]
    if kind == "several":
        return [GravityGradient(_orbit(0.2, 0.3), 0.1), LinearDamping(0.02), ConstantTorque(vector)]
    if kind == "spin-up":
        return [ConstantTorque(vector), LinearDamping(0.05 * size)]
    functions = {"driven": _driven, "plain": _plain, "dipole": _dipole, "pulse": _pulse}
    return [CustomTorque(functions[kind], kind == "plain")]


def case(number):
    """A case by its number, from 0; always the same."""
    random = np.random.default_rng([2026, number])
    kind = KINDS[number % len(KINDS)]
    semiaxes = np.exp(random.uniform(-0.8, 0.8, 3)) ** 2
    moments = np.array([1.0, 1.0, 1.0]) * semiaxes.sum() - semiaxes
    turn = quaternion.matrix(quaternion.unit(random.normal(size=4)))
    body = Body(tensor=turn @ np.diag(moments) @ turn.T)
    rates = np.zeros(3) if kind == "spin-up" else random.normal(size=3)
    spin = Spin(
        epoch="2026-01-01", wxyz=quaternion.unit(random.normal(size=4)), angular_velocity=rates
    )
    span = float(np.exp(random.uniform(np.log(5.0), np.log(40.0))))
    # Backwards, damping grows without bound.
    seconds = span * np.sort(random.uniform(-0.02 if kind in DAMPED else -0.5, 1.0, 60))
    tolerance = 10.0 ** random.uniform(-11.0, -5.0)
    if kind in ("friction", "sunlight", "pulse"):  # of second and first order
        tolerance = 10.0 ** random.uniform(-7.5, -5.0)
    if kind == "plain":
        seconds, tolerance = 0.2 * seconds, 10.0 ** random.uniform(-8.0, -5.0)
    size = 0.3 * float(np.median(moments))
    return Case(kind, body, spin, _torques(kind, random, size), seconds, tolerance)


def angle(one, two):
    """Largest angle between attitudes (N, 4), rad."""
    return float(np.max(2.0 * np.sqrt(np.sum((one - two) ** 2, axis=-1))))
