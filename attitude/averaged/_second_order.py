"""The drift of second order of a mean state, from the torques on the torus of both phases.

With X = (L, y), both phases f, X' = F(X, f) and f' = w(X) + G(X, f), the mean state of second order
obeys X' = <F> + <DF u + dF/df v>, where u and v of zero mean solve

    w du/df = F - <F>,    w dv/df = Dw u + G - <G>

(the terms <Du> <F> and <du/df> <G> are zero; Sanders, Verhulst & Murdock, Averaging Methods in
Nonlinear Dynamical Systems (2007), section 2.9).  G is the kick of the torques on the phases: the
inverse of the derivative of attitude and angular momentum by (L, y, f), times the torque.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from attitude._support.arrays import two_across
from attitude.averaged import _rates as layout
from attitude.averaged import _tables
from attitude.averaged._mean_state import numbers_of, over_phases, torus
from attitude.frames import quaternion
from attitude.motions._spin import Spin

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from attitude._support.annotations import FloatArray, IntArray
    from attitude.averaged._mean_state import Torus
    from attitude.averaged._mean_torques import Packing, Window

# Of each phase: a hundredth of the drift under sunlight, rounding under gravity.
_NODES = 32
# Steps of differences: of y in units of the distance from the separatrix, or 1; of angles in rad.
_STEP = 1e-3
# Terms of lower frequency, in units of that of the nutation, are left out, as at a resonance.
_SLOWEST = 0.02
# Root mean square of u in y, in units of the distance from the separatrix, or 1, above which the
# series does not hold: at the separatrix, and for tilts below the forced wobble.
_LARGEST = 0.3
# Nodes of the drift in a stretch of a trajectory, at least.
_FEWEST = 3
# Ratio of the steps in a stretch in which the drift is found at even distances.
_GROWTH = 5.0


def drift(packing: Packing, seconds: float, x: FloatArray, region: int) -> FloatArray:
    """What second order adds to dL/dt and dy/dt (4,) of a mean state; 0 where it does not hold."""
    size, unit = float(np.sqrt(x[:3] @ x[:3])), x[:3] / np.sqrt(x[:3] @ x[:3])
    reach = min(1.0, abs(float(x[3]) - packing.axes.separatrix))
    middle, above, below = (_torus_of(packing, x, region, k * _STEP * reach) for k in (0, 1, -1))
    if middle is None or above is None or below is None:
        return np.zeros(4)
    torques, across = packing.torques, two_across(unit)
    numbers = [numbers_of(one, torques.body, torques.instant, seconds) for one in torques.torques]
    rates, kicks = over_phases(torques, numbers, middle)
    # of ln |L|, of turns of L about two axes across it, and of y
    pairs = [(middle.scaled(1.0 + _STEP), middle.scaled(1.0 - _STEP), _STEP)]
    pairs += [(middle.turned(axis, _STEP), middle.turned(axis, -_STEP), _STEP) for axis in across]
    pairs.append((above, below, _STEP * reach))
    inverse = np.linalg.inv(_derivatives(packing, middle, above, below, unit, _STEP * reach))
    changes = np.einsum("nij,nj->ni", inverse, kicks)
    terms, beats = middle.series(rates), _beats(middle)
    waves = terms * beats
    if np.sqrt(np.sum(np.abs(waves[..., 3]) ** 2)) > _LARGEST * reach:
        return np.zeros(4)
    # u over ln |L|, both turns and y
    turns = np.cross(unit, waves[..., :3]) / size
    shares = [waves[..., :3] @ unit / size, turns @ across[0], turns @ across[1], waves[..., 3]]
    phases, total = middle.series(changes[:, 4:]), np.zeros(4)
    for share, (one, two, step) in zip(shares, pairs, strict=True):
        slope = over_phases(torques, numbers, one)[0] - over_phases(torques, numbers, two)[0]
        total += _mean_of_product(middle.series(slope / (2.0 * step)), share)
        phases += share[..., None] * (one.paces - two.paces) / (2.0 * step)
    later, orders = phases * beats, 1j * np.fft.fftfreq(_NODES, 1.0 / _NODES)
    total += _mean_of_product(orders[:, None, None] * terms, later[..., 0])
    total += _mean_of_product(orders[:, None] * terms, later[..., 1])
    return total


def _mean_of_product(terms, others):
    """Mean (4,) of the product of functions with the series (J, K, 4) and (J, K)."""
    return np.sum(terms * np.conj(others)[..., None], axis=(0, 1)).real


def _beats(middle: Torus) -> NDArray[np.complex128]:
    """1/(i frequency) (J, K, 1) of the terms of a series; 0 where that is slow."""
    frequency = middle.frequency
    live = np.abs(frequency) >= _SLOWEST * middle.paces[0]
    live[0, 0] = False
    beats: NDArray[np.complex128] = np.where(live, 1.0 / np.where(live, 1j * frequency, 1.0), 0.0)
    return beats[..., None]


def _torus_of(packing: Packing, x: FloatArray, region: int, shift: float) -> Torus | None:
    """The torus of a mean state with y shifted, from equal phases."""
    axes, body = packing.axes, packing.torques.body
    node = axes.nodes(float(x[3]) + shift, region, 1)[0]
    size = float(np.sqrt(x[:3] @ x[:3]))
    start, end = axes.matrix @ node, axes.end(region)
    start = start / np.sqrt(start @ start)
    # the least turn to the end of the axis, and from there to L
    least = np.append(1.0 + start @ end, np.cross(start, end))
    frames = [np.stack([*two_across(vector), vector]) for vector in (x[:3] / size, end)]
    onward = quaternion.from_matrix(frames[0].T @ frames[1])
    wxyz = quaternion.multiply(onward, least / np.sqrt(least @ least))
    omega = axes.matrix @ (size * node / axes.moments)
    return torus(body, Spin(packing.torques.instant, wxyz, omega, frame="icrf"), _NODES)


def _derivatives(packing, middle, above, below, unit, step):
    """(N, 6, 6): turn over ICRF axes and change of L over body axes, by ln |L|, turns, y, f."""
    tensor = packing.torques.body.tensor
    momentum = middle.omega @ tensor
    out = np.zeros((len(momentum), 6, 6))
    out[:, 3:, 0] = momentum
    out[:, :3, 1], out[:, :3, 2] = two_across(unit)
    turn = quaternion.multiply(above.wxyz, quaternion.conjugate(below.wxyz))
    out[:, :3, 3] = 2.0 * turn[:, 1:] * np.sign(turn[:, :1]) / (2.0 * step)
    out[:, 3:, 3] = (above.omega - below.omega) @ tensor / (2.0 * step)
    # a free motion turns both phases
    nutation, precession = middle.paces
    out[:, :3, 4] = (quaternion.rotate(middle.wxyz, middle.omega) - precession * unit) / nutation
    out[:, 3:, 4] = np.cross(momentum, middle.omega) / nutation
    out[:, :3, 5] = unit
    return out


def even(rows: FloatArray) -> FloatArray:
    """The first steps of a trajectory, as many as are of similar length."""
    steps = np.abs(rows[:, layout.ROW_STEP])
    uneven = np.maximum.accumulate(steps) > _GROWTH * np.minimum.accumulate(steps)
    return rows[: int(np.argmax(uneven))] if np.any(uneven) else rows


def places(rows: FloatArray) -> FloatArray:
    """Ascending seconds (T,) at even distances along steps, at which to find the drift."""
    ends = float(rows[0, layout.ROW_START]), float(rows[-1, layout.ROW_END])
    return np.linspace(min(ends), max(ends), max(len(rows), _FEWEST) + 1)


def driven(
    packing: Packing, window: Window, t: FloatArray, states: FloatArray, region: int
) -> tuple[IntArray, FloatArray]:
    """`models` and `forcing` of a window with the drift of states (T, 4) at `places` besides."""
    count = len(t) - 1
    values = np.array(
        [drift(packing, float(when), x, region) for when, x in zip(t, states, strict=True)]
    )
    spacing = (t[-1] - t[0]) / count
    block = np.zeros((count + 2, 4, 4))
    # constant before and behind the nodes
    block[0, 3], block[-1, 3] = values[0], values[-1]
    block[1:-1] = _tables.spline(t, values)
    head = [t[0] - spacing, spacing, count + 2.0]
    models = np.zeros((len(window.models) + 1, layout.MODEL_ENTRIES), dtype=np.int64)
    models[:-1] = window.models
    models[-1, layout.KIND], models[-1, layout.WIDTH] = layout.DRIFT, 4
    models[-1, layout.FORCING] = len(window.forcing)
    return models, np.concatenate([window.forcing, head, block.reshape(-1)])
