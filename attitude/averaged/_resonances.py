"""Resonances of nutation and precession that a mean rotation crosses, and what a crossing does.

The ratio P_psi/P_phi of a body depends on its energy alone, so each resonance j w_psi = k w_phi
stands at one y in SAM and one in LAM.  There the terms F of dy/dt along the line of (j, -k) do not
average out.  A crossing changes y by a root mean square of sqrt(2) |F| sqrt(2 pi/|d(j w_psi -
k w_phi)/dt|) over the phase, and the motion may stay where the resonant terms are larger than the
mean rate (Neishtadt, Celest. Mech. Dyn. Astron. 65, 1 (1997), on passage and capture).
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from attitude._solver import regime as solver_regime
from attitude.averaged import _mean_state
from attitude.averaged import _rates as layout
from attitude.averaged._history import AveragedHistory
from attitude.averaged._polhode import LAM_PLUS, REGIONS, Axes, shares
from attitude.averaged._tracks import AveragedEvent, Track, _states
from attitude.torques._torque import ConstantTorque, InternalDissipation, LinearDamping

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from attitude._support.annotations import FloatArray, IntArray
    from attitude.averaged._mean_torques import MeanTorques, Packing

# Largest j and k of the resonances that are listed.
HIGHEST: int = 8
# Places of a step at which y is compared with those of resonances; crossings that are evaluated.
_WITHIN, _MOST = 4, 2000
# Nearest and farthest distance from the separatrix, in y, of the search for resonances.
_NEAR, _FAR, _GRID = 1e-4, 60.0, 2000
# Scatter of y that is rounding: the torque has no term there.
_NOTHING = 1e-10
# Epochs of the turn of a path over which resonant terms are averaged.
_ORBIT = 8


def frequencies(axes: Axes, y: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Those of nutation and of the long axis about the momentum (N,), rad/s at L = 1."""
    p, rest = shares(y)
    unit = np.stack([np.sqrt(p), np.zeros_like(p), np.sqrt(rest)], axis=-1)
    found = solver_regime.regimes(axes.moments, unit / axes.moments)
    return 2.0 * np.pi / np.asarray(found.P_psi), 2.0 * np.pi / np.asarray(found.P_phi_L)


def places(axes: Axes) -> list[tuple[int, int, bool, float]]:
    """j, k, whether in LAM, and y of all resonances of coprime j and k up to `HIGHEST`."""
    pairs = [
        (j, k) for j in range(1, HIGHEST + 1) for k in range(1, HIGHEST + 1) if math.gcd(j, k) == 1
    ]
    found, low, high = [], [], []
    for is_long in (False, True):
        h = np.geomspace(_NEAR, _FAR, _GRID)
        y = axes.separatrix + (h if is_long else -h)
        w = frequencies(axes, y)
        for j, k in pairs:
            gap = j * w[0] - k * w[1]
            for n in np.flatnonzero(gap[:-1] * gap[1:] < 0.0):
                found.append((j, k, is_long))
                low.append(y[n])
                high.append(y[n + 1])
    if not found:
        return []
    j, k, _ = np.array(found).T
    below, above = np.array(low), np.array(high)
    one, two = frequencies(axes, below)
    begin = j * one - k * two
    for _ in range(52):
        middle = 0.5 * (below + above)
        one, two = frequencies(axes, middle)
        same = (j * one - k * two) * begin > 0.0
        below, above = np.where(same, middle, below), np.where(same, above, middle)
    middles = 0.5 * (below + above)
    return [(*each, float(y)) for each, y in zip(found, middles, strict=True)]


def listed(torques: MeanTorques) -> list[tuple[int, int, bool, float]]:
    """The `places` of a body, found once."""
    if torques.resonances is None:
        torques.resonances = places(torques.axes)
    return torques.resonances


def crossed(track: Track, until: float) -> list[AveragedEvent]:
    """The resonances that a track crosses up to seconds `until`; at most 2000."""
    known = track.resonances
    for time, number in _times(track, until):
        key = (round(time, 3), number)
        if key not in known and len(known) < _MOST:
            known[key] = _event(track, time, number)
    return [
        event
        for event in known.values()
        if event.scatter > _NOTHING and (event.seconds - until) * track.sign <= 0.0
    ]


def _times(track: Track, until: float) -> list[tuple[float, int]]:
    """Seconds at which y crosses those of resonances, and the numbers of these."""
    rows = track.rows
    if not len(rows):
        return []
    start = rows[:, layout.ROW_START]
    length = rows[:, layout.ROW_END] - start
    t = start[:, None] + length[:, None] * np.linspace(0.0, 1.0, _WITHIN + 1)
    row = np.repeat(rows, _WITHIN + 1, axis=0)
    y = _states(row, t.reshape(-1), track.sign, np.arange(len(row)))[:, 3].reshape(t.shape)
    is_long = rows[:, layout.ROW_REGION] >= LAM_PLUS
    found = []
    for number, (_, _, of_long, place) in enumerate(listed(track.course.packing.torques)):
        gap = y - place
        changes = (gap[:, :-1] * gap[:, 1:] <= 0.0) & (gap[:, :-1] != 0.0)
        changes &= (is_long == of_long)[:, None]
        for n, m in np.argwhere(changes):
            low, high = t[n, m], t[n, m + 1]
            if (low - until) * track.sign > 0.0:
                continue
            found.append((_bisected(rows[n : n + 1], low, high, place, track.sign), number))
    return [(time, k) for time, k in sorted(found) if (time - until) * track.sign <= 0.0]


def _bisected(row: FloatArray, low: float, high: float, place: float, sign: float) -> float:
    only = np.zeros(1, dtype=np.int64)
    begin = float(_states(row, np.array([low]), sign, only)[0, 3]) - place
    for _ in range(50):
        middle = 0.5 * (low + high)
        gap = float(_states(row, np.array([middle]), sign, only)[0, 3]) - place
        low, high = (middle, high) if gap * begin > 0.0 else (low, middle)
    return 0.5 * (low + high)


def _event(track: Track, time: float, number: int) -> AveragedEvent:
    """The crossing of one resonance."""
    packing = track.course.packing
    j, k, _, place = listed(packing.torques)[number]
    states, regions = track.states(np.array([time]))
    state, region = states[0].copy(), int(regions[0])
    state[3] = place
    rate = float(packing.rates_of(time, state, region)[0][3])
    terms = _resonant(packing, time, state, region)
    size = float(np.sqrt(state[:3] @ state[:3]))
    step = 1e-5
    one, two = frequencies(packing.axes, np.array([place - step, place + step]))
    slope = float(np.diff(j * one - k * two)[0]) / (2.0 * step)
    drift = abs(size * slope * rate)
    order = np.arange(1, len(terms) + 1)
    phase = 2.0 * np.pi * np.arange(256) / 256
    largest = np.max(np.abs(2.0 * np.real(np.exp(1j * np.outer(phase, order)) @ terms)))
    with np.errstate(divide="ignore", invalid="ignore"):
        square = np.sum(2.0 * np.abs(terms) ** 2 * 2.0 * np.pi / (order * drift))
        strength = largest / abs(rate)
    name = REGIONS[region]
    return AveragedEvent(
        "resonance",
        time,
        name,
        name,
        ratio=(j, k),
        scatter=float(np.sqrt(square)) if largest > 0.0 else 0.0,
        strength=float(strength) if largest > 0.0 else 0.0,
    )


def _resonant(
    packing: Packing, time: float, state: FloatArray, region: int
) -> NDArray[np.complex128]:
    """The complex terms (N,) of dy/dt whose frequencies are 0, by their order."""
    torques = packing.torques
    total = np.zeros(0, dtype=complex)
    at = np.array(time), state, np.array(region)
    spin = AveragedHistory(packing, *at).free_rotation(phases=(0.0, 0.0)).spin
    for torque, period, is_averaged in zip(
        torques.torques, torques.periods, packing.averaged, strict=True
    ):
        if isinstance(torque, (ConstantTorque, InternalDissipation, LinearDamping)):
            continue  # the same at all phases of the precession
        times = [time]
        if is_averaged:
            first, last = torques.span
            begin = min(max(time - 0.5 * period, first), last - period)
            times = [begin + period * (n + 0.5) / _ORBIT for n in range(_ORBIT)]
        for when in times:
            found = _mean_state.series(
                packing.axes, torques.body, spin, [torque], torques.instant, when
            )
            if found is None:
                continue
            some = _on_line(*found)
            longer = np.zeros(max(len(some), len(total)), dtype=complex)
            longer[: len(total)] += total
            longer[: len(some)] += some / len(times)
            total = longer
    return total


def _on_line(
    terms: NDArray[np.complex128], frequency: FloatArray, nutation: float
) -> NDArray[np.complex128]:
    """The terms of y of frequency 0 but that of order 0, one of each pair of conjugates."""
    half = len(terms) // 2
    j, k = np.nonzero(np.abs(frequency) < 1e-6 * nutation)
    order_j, order_k = (np.where(n >= half, n - 2 * half, n) for n in (j, k))
    chosen = (order_k > 0) | ((order_k == 0) & (order_j > 0))
    rows: IntArray = np.argsort(order_k[chosen], kind="stable")
    along_y: NDArray[np.complex128] = terms[j[chosen], k[chosen], 3][rows]
    return along_y
