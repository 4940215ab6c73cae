"""From the state of a rotation to its mean state, by the Fourier series of the torque on the torus.

To first order the mean state is the state less sum F_jk / (i (j w_psi + k w_phi)) over all pairs of
whole numbers but (0, 0), F being the series of dL/dt and dy/dt over the phases of nutation and
precession, from the phases of the state.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from attitude.averaged._polhode import shares
from attitude.averaged._rates import torques_at
from attitude.frames import quaternion
from attitude.motions._free_rotation import FreeRotation
from attitude.torques._torque import SLIP

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from attitude._support.annotations import FloatArray
    from attitude.averaged._polhode import Axes
    from attitude.epochs._instants import Instant
    from attitude.motions._body import Body
    from attitude.motions._spin import Spin
    from attitude.torques._torque import Torque

_NODES = 64


def corrections(
    axes: Axes,
    body: Body,
    spin: Spin,
    torques: Sequence[Torque],
    instant: Instant,
    seconds: float = 0.0,
) -> tuple[FloatArray, float]:
    """What to subtract from L (3,), ICRF axes, and from y of a state at instant + seconds."""
    fourier = series(axes, body, spin, torques, instant, seconds)
    if fourier is None:
        return np.zeros(3), 0.0
    terms, frequency, nutation = fourier
    terms[0, 0], frequency[0, 0] = 0.0, 1.0
    # a resonance of high order has no mean state nearby; its term is left out
    terms[np.abs(frequency) < 1e-3 * nutation] = 0.0
    frequency[frequency == 0.0] = 1.0
    total = np.sum(terms / (1j * frequency)[..., None], axis=(0, 1)).real
    return total[:3], float(total[3])


def series(
    axes: Axes,
    body: Body,
    spin: Spin,
    torques: Sequence[Torque],
    instant: Instant,
    seconds: float = 0.0,
    nodes: int = _NODES,
) -> tuple[NDArray[np.complex128], FloatArray, float] | None:
    """The Fourier series (J, K, 4) of dL/dt and dy/dt over both phases, from those of the state.

    With the frequencies (J, K) of its terms and that of the nutation, rad/s; None on the
    separatrix.  nodes: of each phase, even.
    """
    torus = _torus(body, spin, nodes)
    if torus is None:
        return None
    wxyz, omega, size, period, pace = torus
    total = np.zeros((nodes * nodes, 4))
    for torque in torques:
        moments = _moments(torque, body, (instant, seconds), wxyz, omega)
        total += _rates_of(torque, axes, body, moments, wxyz, omega, size)
    terms = np.fft.fft2(total.reshape(nodes, nodes, 4), axes=(0, 1)) / nodes**2
    terms[nodes // 2] = terms[:, nodes // 2] = 0.0
    nutation = 2.0 * math.pi / period
    number = np.fft.fftfreq(nodes, 1.0 / nodes)
    return terms, number[:, None] * nutation + number * pace, nutation


def divergence(
    body: Body, spin: Spin, torques: Sequence[Torque], instant: Instant, seconds: float = 0.0
) -> float:
    """Mean over both phases of the divergence of torques by L over the body axes, 1/s.

    The rate at which a volume of states grows: 0 of torques that do not depend on the rate.
    """
    torus = _torus(body, spin, _NODES)
    if torus is None:
        return 0.0
    wxyz, omega, size, _, _ = torus
    total, step = 0.0, 1e-5 * size
    inverse = np.linalg.inv(body.tensor)
    for torque in torques:
        for k in range(3):
            ends = [
                _moments(torque, body, (instant, seconds), wxyz, omega + sign * step * inverse[k])
                for sign in (1.0, -1.0)
            ]
            total += float(np.mean(ends[0][:, k] - ends[1][:, k])) / (2.0 * step)
    return total


def _torus(body, spin, nodes):
    """Attitudes (N, 4) and rates (N, 3) at nodes of both phases; |L|, P_psi, rate of precession."""
    free = FreeRotation(body, spin)
    period = float(free.regime.P_psi)
    if not np.isfinite(period):
        return None
    t = period * np.arange(nodes + 1) / nodes
    history = free.at(t)
    momentum = history.body_to_inertial(history.angular_velocity @ body.tensor)[0]
    size = float(np.sqrt(momentum @ momentum))
    along = momentum / size
    turn = quaternion.multiply(history.wxyz[-1], quaternion.conjugate(history.wxyz[0]))
    pace = 2.0 * math.atan2(float(turn[1:] @ along), float(turn[0])) / period
    back = _turns(along, -pace * t[:-1])
    phases = _turns(along, 2.0 * math.pi * np.arange(nodes) / nodes)
    wxyz = quaternion.multiply(
        phases[None], quaternion.multiply(back, history.wxyz[:-1])[:, None]
    ).reshape(-1, 4)
    omega = np.repeat(history.angular_velocity[:-1], nodes, axis=0)
    return wxyz, omega, size, period, pace


def _turns(axis: FloatArray, angle: FloatArray) -> FloatArray:
    """Quaternions (N, 4) of turns about an axis."""
    return np.concatenate(
        [np.cos(0.5 * angle)[:, None], np.sin(0.5 * angle)[:, None] * axis], axis=1
    )


def _moments(torque, body, epoch, wxyz, omega):
    """A torque (N, 3) at states of the torus, over the body axes; that of a slip is L x d."""
    samples = np.zeros((1, 1))
    if torque.columns:
        samples = torque.sample(epoch[0], np.array([epoch[1]]), np.zeros(1))
    samples = np.ascontiguousarray(np.broadcast_to(samples, (len(wxyz), samples.shape[1])))
    parameters = np.append(np.asarray(torque.parameters(body), dtype=np.float64), 0.0)
    moments = np.empty((len(wxyz), 3))
    times = np.full(len(wxyz), epoch[1])
    states = np.ascontiguousarray(wxyz), np.ascontiguousarray(omega)
    torques_at(torque.address(), parameters.ctypes.data, times, *states, samples, moments)
    if torque.kind == SLIP:
        moments = np.cross(omega @ body.tensor, moments)
    return moments


def _rates_of(torque, axes, body, moments, wxyz, omega, size):
    """dL/dt over ICRF axes and dy/dt (N, 4) from a torque at states of the torus."""
    inertial = np.zeros_like(moments)
    if torque.kind != SLIP:
        inertial = quaternion.rotate(wxyz, moments)
    momentum = omega @ body.tensor
    unit = momentum / size
    across = omega - np.sum(omega * unit, axis=1)[:, None] * unit
    y = np.log(_odds(axes, omega))
    p, complement = shares(y)
    rate = 2.0 * np.sum(across * moments, axis=1) / (size * size * axes.spread * p * complement)
    return np.concatenate([inertial, rate[:, None]], axis=1)


def _odds(axes, omega):
    """p/(1 - p) of angular velocities (N, 3) over the body axes."""
    a, b, c = axes.moments
    w = omega @ axes.matrix
    over = a * (c - a) * w[:, 0] ** 2 + b * (c - b) * w[:, 1] ** 2
    below = c * (c - a) * w[:, 2] ** 2 + b * (b - a) * w[:, 1] ** 2
    return np.maximum(a * over, 1e-300) / np.maximum(c * below, 1e-300)
