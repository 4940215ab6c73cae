"""Resonances of nutation and precession that a mean rotation crosses, and what a crossing does.

The ratio P_psi/P_phi of a body depends on its energy alone, so each resonance j w_psi = k w_phi
stands at one y in SAM and one in LAM.  There the terms F of dy/dt along the line of (j, -k) do not
average out.  Where torques are averaged over the turn of a path, j w_psi - k w_phi = n w_path is a
resonance too, whose place depends on |L|; its term is the one of order n over the turn.

A crossing changes y by a root mean square of sqrt(2) |F| sqrt(2 pi/|d(j w_psi - k w_phi)/dt|) over
the phase, and the motion may stay where the resonant terms are larger than the mean rate
(Neishtadt, Celest. Mech. Dyn. Astron. 65, 1 (1997), on passage and capture).
"""

from __future__ import annotations

import itertools
import math
from typing import TYPE_CHECKING

import numpy as np

from attitude._solver import regime as solver_regime
from attitude._support.arrays import bisected
from attitude.averaged import _mean_state
from attitude.averaged import _rates as layout
from attitude.averaged._history import AveragedHistory
from attitude.averaged._polhode import LAM_PLUS, REGIONS, Axes, shares
from attitude.averaged._tracks import AveragedEvent, Track, _states
from attitude.torques._torque import ConstantTorque, InternalDissipation, LinearDamping

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from attitude._support.annotations import BoolArray, FloatArray, IntArray
    from attitude.averaged._mean_torques import Crossing, MeanTorques, Packing
    from attitude.averaged._tracks import Choice
    from attitude.motions._spin import Spin

    # Of a resonance: j, k, region and count of events before it.
    Weak = tuple[int, int, int, int]

# Largest j and k of the resonances that are listed.
HIGHEST: int = 8
# Places of a step at which y is compared with those of resonances.
_WITHIN = 4
# Crossings that are evaluated, at most.
_MOST = 2000
# Nearest distance from the separatrix, in y, of the search for resonances.
_NEAR = 1e-4
# Farthest distance from it.
_FAR = 60.0
# Distances between both at which the search looks.
_GRID = 2000
# Scatter of y that is rounding: the torque has no term there.
_NOTHING = 1e-10
# Share of the square of a kick that is left out.
_SMALL_KICK = 1e-3
# The mean of a cosine over a quarter of its turn.
_QUARTER = math.sin(0.25 * math.pi) / (0.25 * math.pi)
# Nodes of each phase.
_COARSE_NODES = 64
# Nodes for derivatives of a loop: kinks make noise.
_FINE_NODES = 256
# Step of these derivatives, as a share of L or of a turn of the path.
_STEP = 0.02
# Epochs of the turn of a path over which resonant terms are averaged.
_ORBIT = 16
# Largest j and k of resonances with the turn of a path that are listed.
_LOW = 3
# Largest n of these.
_SIDES = 4
# Torques that are the same at all phases of the precession.
_WITHOUT_PHASE = ConstantTorque, InternalDissipation, LinearDamping
# Nodes of the table of frequencies in which they are sought.
_NODES = 1500


def frequencies(axes: Axes, y: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Those of nutation and of the long axis about the momentum (N,), rad/s at L = 1."""
    p, complement = shares(y)
    unit = np.stack([np.sqrt(p), np.zeros_like(p), np.sqrt(complement)], axis=-1)
    regimes = solver_regime.regimes(axes.moments, unit / axes.moments)
    return 2.0 * np.pi / np.asarray(regimes.P_psi), 2.0 * np.pi / np.asarray(regimes.P_phi_L)


def places(axes: Axes) -> list[tuple[int, int, bool, float]]:
    """j, k, whether in LAM, and y of all resonances of coprime j and k up to `HIGHEST`."""
    pairs = [
        (j, k) for j in range(1, HIGHEST + 1) for k in range(1, HIGHEST + 1) if math.gcd(j, k) == 1
    ]
    orders, low, high = [], [], []
    for is_long in (False, True):
        h = np.geomspace(_NEAR, _FAR, _GRID)
        y = axes.separatrix + (h if is_long else -h)
        w = frequencies(axes, y)
        for j, k in pairs:
            gap = j * w[0] - k * w[1]
            for n in np.flatnonzero(gap[:-1] * gap[1:] < 0.0):
                orders.append((j, k, is_long))
                low.append(y[n])
                high.append(y[n + 1])
    if not orders:
        return []
    j, k, _ = np.array(orders).T
    below, above = np.array(low), np.array(high)
    one, two = frequencies(axes, below)
    begin = j * one - k * two

    def is_below(y: FloatArray) -> BoolArray:
        one, two = frequencies(axes, y)
        return (j * one - k * two) * begin > 0.0

    below, above = bisected(is_below, below, above, 52)
    middles = 0.5 * (below + above)
    return [(*order, float(y)) for order, y in zip(orders, middles, strict=True)]


def listed(torques: MeanTorques) -> list[tuple[int, int, bool, float]]:
    """The `places` of a body, found once."""
    if torques.resonances is None:
        torques.resonances = places(torques.axes)
    return torques.resonances


def crossed(track: Track, until: float) -> list[AveragedEvent]:
    """The resonances that a track crosses up to seconds `until`; at most 2000."""
    return [event for event, _ in _with_kicks(track, until)]


def _with_kicks(track: Track, until: float) -> list[tuple[AveragedEvent, FloatArray]]:
    """The resonances that a track crosses, each with its kicks (K, 4) of L and y."""
    known = track.resonances
    crossings = [(time, (j, k, 0), y) for time, j, k, y in _times(track, until)]
    crossings += _with_orbits(track, until)
    for time, order, y in sorted(crossings):
        key = (round(time, 3), order)
        if key not in known and len(known) < _MOST:
            known[key] = _event(track, time, order, y)
    return [
        (event, kicks)
        for event, kicks in known.values()
        if event.scatter > _NOTHING and (event.seconds - until) * track.sign <= 0.0
    ]


def scatter(track: Track, t: FloatArray) -> FloatArray:
    """Root mean squares (T, 3) of |L| (a share), y and pole (rad) over unknown phases, at seconds.

    Each resonance kicks L and y, and each passage delays them; what a kick becomes is that of the
    mean motion from the state behind it, through the same regions.
    """
    if not len(t):
        return np.zeros((0, 3))
    until = float(t[np.argmax(np.abs(t))])
    kicks = [(e.seconds, kick) for e, rows in _with_kicks(track, until) for kick in rows]
    passages = track.passages(until)
    packing = track.course.packing
    for event in passages:
        if event.delay > 0.0:
            # where the body is a few laps from the separatrix
            behind = event.seconds + track.sign * 20.0 * event.delay
            states, regions = track.states(np.array([behind]))
            rate = packing.rates_of(behind, states[0], int(regions[0]))[0][3]
            # of a shift with this root mean square, as of a kick over its phase
            kicks.append((behind, np.array([0.0, 0.0, 0.0, math.sqrt(2.0) * rate * event.delay])))
    base, total = track.states(t)[0], np.zeros((len(t), 3))
    size = np.sqrt(np.sum(base[:, :3] ** 2, axis=1))
    for when, kick in kicks:
        later = (t - when) * track.sign > 0.0
        if not np.any(later) or abs(when) >= abs(track.clock[0]):
            continue
        states, regions = track.states(np.array([when]))
        other = track.resumed(when, states[0] + kick, int(regions[0]))
        onward = [REGIONS.index(e.after) for e in passages if (e.seconds - when) * track.sign > 0.0]
        for seconds, mean in (*track.kicks, (until, None)):
            if (seconds - when) * track.sign > 0.0 and other.ended is None:
                other.extend(seconds, along(onward[len(other.passages()) :]))
                other = other if mean is None else other.kicked(seconds, mean)
        shifted = other.states(t[later])[0]
        if other.ended is not None:
            shifted[(t[later] - other.ended.seconds) * track.sign > 0.0] = np.nan
        sizes = np.sqrt(np.sum(shifted[:, :3] ** 2, axis=1))
        turned = shifted[:, :3] / sizes[:, None] - base[later, :3] / size[later, None]
        total[later, 0] += 0.5 * (sizes / size[later] - 1.0) ** 2
        total[later, 1] += 0.5 * (shifted[:, 3] - base[later, 3]) ** 2
        total[later, 2] += 0.5 * np.sum(turned**2, axis=1)
    rms: FloatArray = np.sqrt(total)
    return rms


def split(track: Track, until: float, least: float, weak: set[Weak]) -> list[Track]:
    """A track that branches at its first resonance whose scatter of y is at least `least`.

    Each quarter of the phases is one branch, with the mean kick of that quarter; what is left of
    the kick stays in `scatter`.  Empty where there is no such resonance up to seconds `until`,
    behind the last one at which it has branched.  weak: those that are weaker, filled.
    """
    begin = track.kicks[-1][0] if track.kicks else 0.0
    for time, j, k, y in sorted(_times(track, until), key=lambda crossing: abs(crossing[0])):
        region = int(track.states(np.array([time]))[1][0])
        kind, key = (j, k, region, len(track.happened(time))), (round(time, 3), (j, k, 0))
        if (time - begin) * track.sign <= 0.0 or kind in weak:
            continue
        if key not in track.resonances:
            track.resonances[key] = _event(track, time, (j, k, 0), y)
        event, kicks = track.resonances[key]
        if event.scatter < least:
            weak.add(kind)
            continue
        # where the resonant terms average out again
        behind = time + track.sign * event.lasts
        is_passed = any((e.seconds - behind) * (e.seconds - time) <= 0.0 for e in track.events)
        if event.may_capture or is_passed or (until - behind) * track.sign <= 0.0:
            continue
        row = int(np.argmax(np.abs(kicks[:, 3])))
        pair = [row, row + len(kicks) // 2]
        remaining = kicks.copy()
        remaining[pair] *= math.sqrt(1.0 - _QUARTER**2)
        track.resonances[key] = event, remaining
        tracks = []
        for signs in itertools.product((_QUARTER, -_QUARTER), repeat=2):
            tracks.append(track.kicked(behind, math.sqrt(0.5) * np.array(signs) @ kicks[pair]))
            tracks[-1].odds *= 0.25
        return tracks
    return []


def along(regions: list[int]) -> Choice:
    """The choice of the regions of a track, and of the likeliest behind its last one."""

    def choose(_: Track, crossing: Crossing) -> int:
        following = regions.pop(0) if regions else None
        if following in crossing.odds:
            return following
        return max(crossing.odds, key=lambda region: crossing.odds[region])

    return choose


def _places_within(track: Track) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Seconds (N, K) within the steps of a track, |L| and y there."""
    rows = track.rows
    start = rows[:, layout.ROW_START]
    length = rows[:, layout.ROW_END] - start
    t = start[:, None] + length[:, None] * np.linspace(0.0, 1.0, _WITHIN + 1)
    row = np.repeat(rows, _WITHIN + 1, axis=0)
    states = _states(row, t.reshape(-1), track.sign, np.arange(len(row)))
    size = np.sqrt(np.sum(states[:, :3] ** 2, axis=1))
    return t, size.reshape(t.shape), states[:, 3].reshape(t.shape)


def _with_orbits(track: Track, until: float) -> list[tuple[float, tuple[int, int, int], float]]:
    """Seconds, (j, k, n) and y of crossings of resonances with the turns of averaged paths."""
    packing, rows = track.course.packing, track.rows
    several = {
        period
        for torque, period, averaged in packing.paths
        if averaged and not isinstance(torque, _WITHOUT_PHASE)
    }
    if not several or not len(rows):
        return []
    t, size, y = _places_within(track)
    is_long = rows[:, layout.ROW_REGION] >= LAM_PLUS
    one, two = np.empty_like(y), np.empty_like(y)
    for flags in (is_long, ~is_long):
        if np.any(flags):
            one[flags], two[flags] = _tabulated(packing.axes, y[flags], bool(is_long[flags][0]))
    crossings = []
    for period in several:
        for j, k in itertools.product(range(1, _LOW + 1), repeat=2):
            beat = size * (j * one - k * two) * period / (2.0 * np.pi)
            # neighbours of a beat that changes faster are crossed as one resonance
            slow = np.abs(np.diff(beat, axis=1)) * period < np.abs(np.diff(t, axis=1))
            for n in (*range(-_SIDES, 0), *range(1, _SIDES + 1)):
                if math.gcd(j, k, n) != 1:
                    continue
                gap = beat - n
                for row, m in np.argwhere((gap[:, :-1] * gap[:, 1:] < 0.0) & slow):
                    share = gap[row, m] / (gap[row, m] - gap[row, m + 1])
                    when = float(t[row, m] + share * (t[row, m + 1] - t[row, m]))
                    place = float(y[row, m] + share * (y[row, m + 1] - y[row, m]))
                    if (when - until) * track.sign <= 0.0:
                        crossings.append((when, (j, k, n), place))
    return crossings


def _tabulated(axes: Axes, y: FloatArray, is_long: bool) -> tuple[FloatArray, FloatArray]:
    """`frequencies` at y of any shape of one mode, by interpolation."""
    from scipy.interpolate import CubicSpline  # half a second, and ensembles import this

    h = np.geomspace(_NEAR, _FAR, _NODES)
    nodes = axes.separatrix + (h if is_long else -h)
    at = np.log(np.clip(np.abs(y - axes.separatrix), _NEAR, _FAR))
    values = frequencies(axes, nodes)
    first, second = (CubicSpline(np.log(h), value)(at) for value in values)
    return first, second


def _times(track: Track, until: float) -> list[tuple[float, int, int, float]]:
    """Seconds, j, k and y of crossings of the resonances of nutation and precession."""
    rows = track.rows
    if not len(rows):
        return []
    t, _, y = _places_within(track)
    is_long = rows[:, layout.ROW_REGION] >= LAM_PLUS
    crossings = []
    for j, k, of_long, place in listed(track.course.packing.torques):
        gap = y - place
        changes = (gap[:, :-1] * gap[:, 1:] <= 0.0) & (gap[:, :-1] != 0.0)
        changes &= (is_long == of_long)[:, None]
        for n, m in np.argwhere(changes):
            low, high = t[n, m], t[n, m + 1]
            if (low - until) * track.sign > 0.0:
                continue
            time = _bisected(rows[n : n + 1], float(low), float(high), place, track.sign)
            crossings.append((time, j, k, place))
    return [crossing for crossing in sorted(crossings) if (crossing[0] - until) * track.sign <= 0.0]


def _bisected(row: FloatArray, low: float, high: float, place: float, sign: float) -> float:
    only = np.zeros(1, dtype=np.int64)

    def gap(time: float) -> float:
        return float(_states(row, np.array([time]), sign, only)[0, 3]) - place

    begin = gap(low)
    low, high = bisected(lambda time: gap(time) * begin > 0.0, low, high, 50)
    return 0.5 * (low + high)


def _event(
    track: Track, time: float, order: tuple[int, int, int], place: float
) -> tuple[AveragedEvent, FloatArray]:
    """The crossing of one resonance (j, k, n) at a y, and its kicks (K, 4) of L and y.

    The root mean square over the phase of what a crossing does is that of the kicks over sqrt(2).
    """
    packing = track.course.packing
    j, k, n = order
    states, regions = track.states(np.array([time]))
    state, region = states[0].copy(), int(regions[0])
    state[3] = place
    rates = packing.rates_of(time, state, region)[0]
    rate = float(rates[3])
    every = _resonant(packing, time, state, region, order)
    terms = every[:, 3]
    size = float(np.sqrt(state[:3] @ state[:3]))
    one, two = frequencies(packing.axes, np.array([place]))
    slope = size * _slope(packing.axes, place, order)
    # of a resonance with a path, the beat also changes with |L|
    beat = float(j * one[0] - k * two[0])
    drift = abs(slope * rate + beat * float(state[:3] @ rates[:3]) / size)
    numbers = np.arange(1, len(terms) + 1)
    phase = 2.0 * np.pi * np.arange(256) / 256
    largest = np.max(
        np.abs(2.0 * np.real(np.exp(1j * np.outer(phase, numbers)) @ terms)), initial=0.0
    )
    if not largest > 0.0 or not drift > 0.0:
        event = AveragedEvent("resonance", time, REGIONS[region], REGIONS[region], ratio=(j, k))
        return event, np.zeros((0, 4))
    waves = 2.0 * np.sqrt(2.0 * np.pi / (numbers * drift))[:, None] * every
    # from the phase of the largest change of y: the imaginary rows change L alone
    waves *= np.exp(-1j * np.angle(waves[:, 3:]))
    scatter_of_y = math.sqrt(0.5 * float(np.sum(np.abs(waves[:, 3]) ** 2)))
    effects = np.sum((np.abs(waves) / np.array([size, size, size, 1.0])) ** 2, axis=1)
    waves = waves[effects > _SMALL_KICK * np.max(effects)]
    kicks = np.concatenate([waves.real, waves.imag])
    # the mean rate of y against the resonance, and the time in which it crosses the width
    against = drift / max(abs(slope), 1e-300)
    width = 2.0 * math.sqrt(largest / max(abs(slope), 1e-300))
    event = AveragedEvent(
        "resonance",
        time,
        REGIONS[region],
        REGIONS[region],
        ratio=(j, k),
        turns=n,
        scatter=scatter_of_y,
        strength=float(largest / against),
        width=width,
        lasts=max(2.0 * math.sqrt(2.0 * math.pi / drift), 2.0 * width / against),
        capture=_odds_of_capture(track, time, state, region, order) if largest > against else 0.0,
    )
    return event, kicks


# ---- Capture


def _odds_of_capture(
    track: Track, time: float, state: FloatArray, region: int, order: tuple[int, int, int]
) -> float:
    """The odds that a crossing captures the motion; NaN for a resonance with the turn of a path.

    Near the resonance the beat u = j w_psi - k w_phi and its angle f obey f' = u, u' = G(f), a
    pendulum under a constant torque a, the mean of G.  In its loop motions are held.  Volumes of
    states, u/|L| by f by L, grow at the mean divergence of the torques alone; so the states that
    the loop takes in a second are what it grows by, with the flow of L within, less what the
    divergence makes, and 2 pi a/|L| cross in that second (Neishtadt, J. Appl. Math. Mech. 39, 594
    (1975); Henrard, Celest. Mech. 27, 3 (1982)).
    """
    packing, sign = track.course.packing, track.sign
    torques, size = packing.torques, float(np.sqrt(state[:3] @ state[:3]))
    if order[2] != 0:
        return math.nan
    slope = _slope(packing.axes, float(state[3]), order)

    def loop(when: float, momentum: FloatArray) -> tuple[float, FloatArray, float]:
        x = np.append(momentum, state[3])
        rates = packing.rates_of(when, x, region)[0]
        terms = _resonant(packing, when, x, region, order, _FINE_NODES)
        return _loop(rates, terms, float(np.sqrt(momentum @ momentum)), slope)

    area, _, push = loop(time, state[:3])
    if not area > 0.0:
        return 0.0
    growth = -area * _divergence(packing, time, state, region)
    followed = min(
        (period for _, period, averaged in packing.paths if not averaged), default=math.inf
    )
    if np.isfinite(followed):
        first, last = torques.span
        later, earlier = min(time + _STEP * followed, last), max(time - _STEP * followed, first)
        growth += (loop(later, state[:3])[0] - loop(earlier, state[:3])[0]) / (later - earlier)
    for k in range(3):
        shift = _STEP * size * np.eye(3)[k]
        flow = loop(time, state[:3] + shift)[1][k] - loop(time, state[:3] - shift)[1][k]
        growth += flow / (2.0 * _STEP * size)
    return float(np.clip(sign * growth / (2.0 * np.pi * push), 0.0, 1.0))


def _divergence(packing: Packing, time: float, state: FloatArray, region: int) -> float:
    """The rate, 1/s, at which a volume of states grows; of averaged torques, over their turns."""
    torques, total = packing.torques, 0.0
    spin = _spin_of(packing, time, state, region)
    for torque, period, is_averaged in packing.paths:
        times = [time]
        if is_averaged and not isinstance(torque, _WITHOUT_PHASE):
            times = _turn(torques, time, period)
        divergences = [
            _mean_state.divergence(torques.body, spin, [torque], torques.instant, when)
            for when in times
        ]
        total += float(np.mean(divergences))
    return total


def _spin_of(packing: Packing, time: float, state: FloatArray, region: int) -> Spin:
    """The state of a rotation with a mean state (4,), at phases of 0."""
    history = AveragedHistory(packing, np.array(time), state, np.array(region))
    return history.free_rotation(phases=(0.0, 0.0)).spin


def _turn(torques: MeanTorques, time: float, period: float) -> list[float]:
    """Seconds at the middles of shares of a turn of a path about a time."""
    first, last = torques.span
    begin = min(max(time - 0.5 * period, first), last - period)
    return [begin + period * (n + 0.5) / _ORBIT for n in range(_ORBIT)]


def _slope(axes: Axes, y: float, order: tuple[int, int, int]) -> float:
    """The derivative of a beat (j, k, n) by y, rad/s at L = 1."""
    step = 1e-5
    one, two = frequencies(axes, np.array([y - step, y + step]))
    beats = order[0] * one - order[1] * two
    return float(beats[1] - beats[0]) / (2.0 * step)


def _loop(
    rates: FloatArray, terms: NDArray[np.complex128], size: float, slope: float
) -> tuple[float, FloatArray, float]:
    """The loop over |L|: its area, the flow (3,) of L within; and the mean of G over |L|."""
    count = 2048
    f = 2.0 * np.pi * np.arange(2 * count) / count
    waves = np.exp(1j * np.outer(f, np.arange(1, len(terms) + 1)))
    changes = rates + 2.0 * np.real(waves @ terms)
    force = size * slope * changes[:, 3]
    push = size * slope * float(rates[3])
    if push < 0.0:
        # towards smaller angles: the same in the mirror
        force, changes, push = -force[::-1], changes[::-1], -push
    height = -np.cumsum(force) * (2.0 * np.pi / count)
    # held: below a height that the motion would have to climb
    barrier = np.maximum.accumulate(height[::-1])[::-1]
    speed = 2.0 * np.sqrt(2.0 * np.maximum(barrier - height, 0.0))[:count] * (2.0 * np.pi / count)
    flow: FloatArray = speed @ changes[:count, :3] / size
    return float(np.sum(speed)) / size, flow, push / size


def _resonant(
    packing: Packing,
    time: float,
    state: FloatArray,
    region: int,
    order: tuple[int, int, int],
    nodes: int = _COARSE_NODES,
) -> NDArray[np.complex128]:
    """The complex terms (N, 4) of dL/dt and dy/dt whose frequencies are 0, by their order."""
    torques = packing.torques
    total = np.zeros((0, 4), dtype=complex)
    spin = _spin_of(packing, time, state, region)
    _, k, n = order
    for torque, period, is_averaged in packing.paths:
        if isinstance(torque, _WITHOUT_PHASE) or (n != 0 and not is_averaged):
            continue
        times, waves, count = [time], [1.0 + 0.0j], nodes
        if is_averaged:
            times = _turn(torques, time, period)
            # epochs and phases together make the noise of kinks small
            count = max(nodes // math.isqrt(_ORBIT), _COARSE_NODES)
            waves = list(np.exp(-2j * np.pi * n * (np.arange(_ORBIT) + 0.5) / _ORBIT))
        for when, wave in zip(times, waves, strict=True):
            fourier = _mean_state.series(
                packing.axes, torques.body, spin, [torque], torques.instant, when, count
            )
            if fourier is None:
                continue
            path_rate = 2.0 * np.pi * n / period
            terms, frequency, nutation = fourier
            some = wave * (
                _on_line(terms, frequency, nutation)
                if n == 0
                else _beside(terms, frequency, k, path_rate)
            )
            longer = np.zeros((max(len(some), len(total)), 4), dtype=complex)
            longer[: len(total)] += total
            longer[: len(some)] += some / len(times)
            total = longer
    return total


def _beside(
    terms: NDArray[np.complex128], frequency: FloatArray, k: int, path_rate: float
) -> NDArray[np.complex128]:
    """The term (1, 4) of order k in the precession whose frequency is that of the path."""
    row = int(np.argmin(np.abs(frequency[:, k] + path_rate)))
    if abs(frequency[row, k] + path_rate) > 0.2 * abs(path_rate):
        return np.zeros((1, 4), dtype=complex)
    return terms[row, k][None]


def _on_line(
    terms: NDArray[np.complex128], frequency: FloatArray, nutation: float
) -> NDArray[np.complex128]:
    """The terms (N, 4) of frequency 0 but that of order 0, one of each pair of conjugates."""
    half = len(terms) // 2
    j, k = np.nonzero(np.abs(frequency) < 1e-6 * nutation)
    order_j, order_k = (np.where(n >= half, n - 2 * half, n) for n in (j, k))
    chosen = (order_k > 0) | ((order_k == 0) & (order_j > 0))
    rows: IntArray = np.argsort(order_k[chosen], kind="stable")
    return terms[j[chosen], k[chosen]][rows]
