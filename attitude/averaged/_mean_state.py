"""From the state of a rotation to its mean state, by the Fourier series of the torque on the torus.

To first order the mean state is the state less sum F_jk / (i (j w_psi + k w_phi)) over all pairs of
whole numbers but (0, 0), F being the series of dL/dt and dy/dt over the phases of nutation and
precession, from the phases of the state.  Where F changes along the path of a torque, the terms
dF_jk/dt / (j w_psi + k w_phi)^2 are subtracted too, the next ones of the same integral by parts.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from attitude._solver.march_layout import SLIP
from attitude.averaged._polhode import shares
from attitude.averaged._rates import torques_at
from attitude.frames import quaternion
from attitude.motions._free_rotation import FreeRotation

if TYPE_CHECKING:
    from collections.abc import Sequence
    from typing import TypeAlias

    from numpy.typing import NDArray

    from attitude._support.annotations import FloatArray
    from attitude.averaged._mean_torques import MeanTorques
    from attitude.averaged._polhode import Axes
    from attitude.epochs._instants import Instant
    from attitude.motions._body import Body
    from attitude.motions._spin import Spin
    from attitude.torques._torque import Torque

    Numbers: TypeAlias = tuple[float, FloatArray, FloatArray]

_NODES = 64
# Step of differences along paths, in nutations.
_PATH_STEP = 0.25
# Least frequency of terms that are corrected for paths, in units of that of the nutation.
_FAST = 0.1
# Share of a path below which it stands still.
_STILL = 1e-3


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
    waves = terms / (1j * frequency)[..., None]
    moving = [torque for torque in torques if torque.columns]
    if moving:
        step = _PATH_STEP * 2.0 * math.pi / nutation
        change = _along_paths(axes, body, spin, moving, instant, seconds, step)
        if change is not None:
            change[np.abs(frequency) < _FAST * nutation] = 0.0
            waves += change / (frequency**2)[..., None]
    total = np.sum(waves, axis=(0, 1)).real
    return total[:3], float(total[3])


def _along_paths(axes, body, spin, torques, instant, seconds, step):
    """The rate at which a series changes by the paths of torques; None where they hardly move."""
    first = max(seconds - step, *(torque.span(instant)[0] for torque in torques))
    last = min(seconds + step, *(torque.span(instant)[1] for torque in torques))
    if not last > first:
        return None
    ends = np.array([first, last])
    samples = [torque.sample(instant, ends, np.zeros(2)) for torque in torques]
    if all(np.ptp(x, axis=0).max() <= _STILL * np.abs(x).max() for x in samples):
        return None
    later, earlier = (series(axes, body, spin, torques, instant, when)[0] for when in (last, first))
    return (later - earlier) / (last - first)


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
    phases = torus(body, spin, nodes)
    if phases is None:
        return None
    total = np.zeros((nodes * nodes, 4))
    for torque in torques:
        numbers = numbers_of(torque, body, instant, seconds)
        moments, _ = _moments(torque, body, numbers, phases.wxyz, phases.omega)
        total += _rates_of(torque, axes, moments, phases, body)
    return phases.series(total), phases.frequency, float(phases.paces[0])


def divergence(
    body: Body, spin: Spin, torques: Sequence[Torque], instant: Instant, seconds: float = 0.0
) -> float:
    """Mean over both phases of the divergence of torques by L over the body axes, 1/s.

    At this rate a volume of states grows: 0 of torques that do not depend on the rate.
    """
    phases = torus(body, spin, _NODES)
    if phases is None:
        return 0.0
    total, step = 0.0, 1e-5 * phases.size
    inverse = np.linalg.inv(body.tensor)
    for torque in torques:
        numbers = numbers_of(torque, body, instant, seconds)
        for k in range(3):
            change = step * inverse[k]
            ends = [
                _moments(torque, body, numbers, phases.wxyz, phases.omega + sign * change)[0]
                for sign in (1.0, -1.0)
            ]
            total += float(np.mean(ends[0][:, k] - ends[1][:, k])) / (2.0 * step)
    return total


@dataclass(frozen=True, eq=False)
class Torus:
    """A free rotation at nodes of both phases, those of the precession next to each other."""

    wxyz: FloatArray  # (N, 4)
    omega: FloatArray  # (N, 3), rad/s over the body axes
    size: float  # |L|, N m s
    paces: FloatArray  # (2,), frequencies of nutation and precession, rad/s

    @property
    def nodes(self) -> int:
        """The count of nodes of each phase."""
        return math.isqrt(len(self.wxyz))

    @property
    def frequency(self) -> FloatArray:
        """rad/s (J, K), of the terms of `series`."""
        number = np.fft.fftfreq(self.nodes, 1.0 / self.nodes)
        total: FloatArray = number[:, None] * self.paces[0] + number * self.paces[1]
        return total

    def series(self, values: FloatArray) -> NDArray[np.complex128]:
        """The Fourier series (J, K, C) of values (N, C)."""
        nodes = self.nodes
        terms: NDArray[np.complex128] = np.fft.fft2(
            values.reshape(nodes, nodes, -1), axes=(0, 1), norm="forward"
        )
        terms[nodes // 2] = terms[:, nodes // 2] = 0.0
        return terms

    def scaled(self, factor: float) -> Torus:
        """That of a momentum which is longer by a factor."""
        return replace(
            self, omega=factor * self.omega, size=factor * self.size, paces=factor * self.paces
        )

    def turned(self, axis: FloatArray, angle: float) -> Torus:
        """Attitudes turned about an inertial axis."""
        turn = _turns(axis, np.array([angle]))
        return replace(self, wxyz=quaternion.multiply(turn, self.wxyz))


def torus(body: Body, spin: Spin, nodes: int) -> Torus | None:
    """The torus of a state, from its phases; None on the separatrix."""
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
    return Torus(wxyz, omega, size, np.array([2.0 * math.pi / period, pace]))


def over_phases(
    torques: MeanTorques, numbers: Sequence[Numbers], phases: Torus
) -> tuple[FloatArray, FloatArray]:
    """dL/dt and dy/dt (N, 4); turn over ICRF axes and change of L over body axes (N, 6), 1/s."""
    body, count = torques.body, len(phases.wxyz)
    rates, kicks = np.zeros((count, 4)), np.zeros((count, 6))
    for torque, at_epoch in zip(torques.torques, numbers, strict=True):
        moments, slips = _moments(torque, body, at_epoch, phases.wxyz, phases.omega)
        rates += _rates_of(torque, torques.axes, moments, phases, body)
        kicks[:, :3] += quaternion.rotate(phases.wxyz, slips)
        kicks[:, 3:] += moments
    return rates, kicks


def _turns(axis: FloatArray, angle: FloatArray) -> FloatArray:
    """Quaternions (N, 4) of turns about an axis."""
    return np.concatenate(
        [np.cos(0.5 * angle)[:, None], np.sin(0.5 * angle)[:, None] * axis], axis=1
    )


def numbers_of(torque: Torque, body: Body, instant: Instant, seconds: float) -> Numbers:
    """Seconds, samples (1, C) and parameters of a torque at an epoch."""
    samples = np.zeros((1, 1))
    if torque.columns:
        samples = torque.sample(instant, np.array([seconds]), np.zeros(1))
    return seconds, samples, np.append(np.asarray(torque.parameters(body), dtype=np.float64), 0.0)


def _moments(torque, body, numbers, wxyz, omega):
    """A torque (N, 3) at states of the torus, over the body axes, and slips d: L x d and d."""
    seconds, samples, parameters = numbers
    samples = np.ascontiguousarray(np.broadcast_to(samples, (len(wxyz), samples.shape[1])))
    moments = np.empty((len(wxyz), 3))
    times = np.full(len(wxyz), seconds)
    states = np.ascontiguousarray(wxyz), np.ascontiguousarray(omega)
    torques_at(torque.address(), parameters.ctypes.data, times, *states, samples, moments)
    if torque.kind == SLIP:
        return np.cross(omega @ body.tensor, moments), moments
    return moments, np.zeros_like(moments)


def _rates_of(torque, axes, moments, phases, body):
    """dL/dt over ICRF axes and dy/dt (N, 4) from a torque at states of the torus."""
    inertial, omega, size = np.zeros_like(moments), phases.omega, phases.size
    if torque.kind != SLIP:
        inertial = quaternion.rotate(phases.wxyz, moments)
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
