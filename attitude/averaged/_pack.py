"""Means of torques packed for the compiled loops; their numbers along paths, in windows of time."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from attitude._solver.march_layout import SLIP
from attitude._support.arrays import bisected
from attitude._support.constants import DAY_S
from attitude.averaged import _rates as layout
from attitude.averaged import _tables
from attitude.averaged._means import Mean
from attitude.errors import AttitudeError
from attitude.paths._path import Composed
from attitude.torques._magnetic import EddyCurrent, MagneticDipole
from attitude.torques._torque import Torque, positions, span_of

if TYPE_CHECKING:
    from attitude._support.annotations import FloatArray, IntArray
    from attitude.averaged._polhode import Axes
    from attitude.epochs._instants import Instant
    from attitude.motions._body import Body
    from attitude.paths._path import Path

# Epochs of one turn of a path over which means are taken.
ORBIT = 32
# Epochs of one turn by which its weight is found to be even over the angle.
_PLANE = 256
# Share of the weight up to which it is even.
_EVEN = 1e-6
# Turns of a field under the weights that average over them.
_FIELD_TURNS = 3
# Epochs of one turn of the path under these weights.
_FIELD_ORBIT = 16
# Epochs of a turn about a planet.
_RIPPLE = 48
# Least ratio of the year of the planet to that turn.
_RIPPLES = 20.0
# Samples of a turn of a path that is followed, at least.
_FEWEST = 32
# The same, at most.
_MOST = 2048
# Share of the largest number by which splines through samples may err.
_CLOSE = 1e-6
# Intervals of a window of time.
_INTERVALS = 1024
# Intervals of a window whose numbers are all averaged over turns: each takes many samples.
_FEW_INTERVALS = 64
# Turns after which a path is compared with its begin.
_TURNS = (1, 3, 10, 31, 100, 316, 1000)
# Share of its numbers to which a path that repeats itself is back.
_REPEATS = 1e-9


@dataclass(frozen=True, eq=False)
class Sampling:
    """How one torque's path enters."""

    torque: Torque
    period: float  # s, of one turn of the path; infinite for no samples or a fixed direction
    is_averaged: bool  # over the turn
    interval: float  # s between samples; infinite for numbers that do not change
    # s, of the turn about a planet over which direction and weight are averaged; else infinite
    ripple: float = float("inf")
    # s, of the smooth weights under which linear numbers are averaged in place of one turn: days of
    # a field that turns with its planet; 0 for one turn
    smooth: float = 0.0
    # whether a turn takes a weight that is even over the angle in one plane (`Packed.is_even`), so
    # that the normal of the plane stands for all directions
    is_even: bool = False


def turn_period(torque: Torque, instant: Instant) -> float:
    """Seconds in which the direction of the path of a torque turns once; infinite at rest."""
    path = getattr(torque, "path", None)
    if not torque.columns or path is None:
        return float("inf")
    return _turn_of(path, instant)


def ripple_period(torque: Torque, instant: Instant) -> float:
    """Seconds of the turn of a satellite about its planet, where its path is that from the Sun."""
    path = getattr(torque, "path", None)
    if not isinstance(path, Composed) or not torque.columns:
        return float("inf")
    turn = _turn_of(path.plus[0], instant)
    return turn if _RIPPLES * turn < _turn_of(path, instant) else float("inf")


def smooth_span(torque: Torque, instant: Instant, period: float) -> float:
    """Seconds of the weights that average a field over its own turns and those of the path, or 0.

    Of the field the means over one turn of the path change within a day, with the longitude.
    """
    if not isinstance(torque, EddyCurrent | MagneticDipole):
        return 0.0
    span = _FIELD_TURNS * torque.field.turn
    first, last = torque.span(instant)
    # paths that are slower than the field average it within their turn
    if not np.isfinite(span) or span < _FIELD_TURNS * period or last - first < span:
        return 0.0
    return span


def _turn_of(path: Path, instant: Instant) -> float:
    first, last = span_of(path, instant)
    begin = min(max(0.0, first), last)

    def unit(t: float) -> FloatArray:
        r = positions(path, instant, np.array([t]), np.zeros(1), "path")[0]
        direction: FloatArray = r / np.sqrt(r @ r)
        return direction

    now, step, turned, t = unit(begin), 1.0, 0.0, begin
    for _ in range(4000):
        sign = 1.0 if t + step <= last else -1.0
        if sign < 0.0 and t - step < first:
            break
        after = unit(t + sign * step)
        angle = float(np.arctan2(np.linalg.norm(np.cross(now, after)), now @ after))
        if angle > 0.2:
            step *= 0.5
            continue
        if angle < 0.05 and step < 1e12 and turned == 0.0:
            step *= 2.0
            continue
        if angle < 1e-9:
            return float("inf")
        t, now, turned = t + sign * step, after, turned + angle
        if turned >= 2.0 * np.pi or sign < 0.0:
            return (
                abs(t - begin) * 2.0 * np.pi / turned
                if turned < 6.0
                else _closed(unit, begin, t, turned)
            )
        step *= min(2.0, 0.1 / angle)
    return float("inf") if turned < 0.1 else abs(t - begin) * 2.0 * np.pi / turned


def _closed(unit, begin, t, turned):
    """The period, refined: where the direction comes nearest to that at the beginning."""
    target = unit(begin)
    guess = (t - begin) * 2.0 * np.pi / turned
    low, high = 0.97 * guess, 1.03 * guess

    def behind(p):
        other = unit(begin + p)
        ahead = unit(begin + 1.001 * p) - unit(begin + 0.999 * p)
        return float((other - target) @ ahead)

    low, high = bisected(lambda p: behind(p) < 0.0, low, high, 60)
    return 0.5 * (low + high)


class Packed:
    """Means of torques on one body, as compiled loops take them: data, models, work of `_rates`."""

    def __init__(
        self,
        axes: Axes,
        body: Body,
        means: Sequence[tuple[Sampling, Mean]],
        instant: Instant,
    ) -> None:
        self.axes, self.means, self._instant = axes, list(means), instant
        x = _tables.coordinates(axes)
        head = np.concatenate([[x[0], x[1] - x[0], len(x) - 1.0], layout.recursions()])
        parts, size = [axes.numbers, head], layout.DATA_START
        self.models: IntArray = np.zeros((len(self.means), layout.MODEL_ENTRIES), dtype=np.int64)
        self._alive = []
        work = 0
        for row, (sampling, mean) in zip(self.models, self.means, strict=True):
            is_sum = sampling.is_averaged and not mean.is_linear and not sampling.is_even
            nodes = ORBIT if is_sum else 1
            columns = mean.arcs.shape[1]
            row[layout.KIND], row[layout.COLUMNS] = mean.kind, columns
            row[layout.DEGREE], row[layout.NODES] = max(mean.degree, 0), nodes
            row[layout.EXPONENT] = mean.exponent
            torque = sampling.torque
            if mean.kind == layout.TORUS:
                parameters = np.append(np.asarray(torque.parameters(body), dtype=np.float64), 0.0)
                self._alive.append(parameters)
                row[layout.FUNCTION] = torque.address()
                row[layout.PARAMETERS] = parameters.ctypes.data
                row[layout.SAMPLED] = torque.columns
                row[layout.NUTATION] = row[layout.PRECESSION] = 16
                row[layout.SLIPS] = int(torque.kind == SLIP)
                row[layout.WIDTH] = nodes * (torque.columns + 1)
            else:
                width = 9 if mean.kind == layout.TENSOR else 4
                row[layout.WIDTH] = nodes * width
                table = [_tables.spline(x, values).reshape(-1) for values in mean.means]
                row[layout.TABLE], row[layout.ARCS] = size, size + sum(map(len, table))
                row[layout.STRENGTH] = row[layout.ARCS] + mean.arcs.size
                parts += [*table, mean.arcs.reshape(-1), np.array([mean.strength, *mean.sizes])]
                size = int(row[layout.STRENGTH]) + 3
            work = max(work, int(row[layout.WIDTH]) + columns + 9 * nodes + 16)
        self.data: FloatArray = np.concatenate(parts)
        self.work: FloatArray = np.zeros(work)

    def sampled(self, sampling: Sampling, mean: Mean, t: FloatArray) -> FloatArray:
        """The numbers (T, F) of a mean at seconds (T,)."""
        count = len(t)
        if mean.kind == layout.TORUS and not sampling.torque.columns:
            return np.zeros((count, 1))
        offsets = np.zeros(1)
        if sampling.is_averaged:
            offsets = sampling.period * ((np.arange(ORBIT) + 0.5) / ORBIT - 0.5)
        if np.isfinite(sampling.ripple) and mean.kind == layout.HARMONICS:
            return self._rippled(sampling, mean, t, offsets)
        if sampling.is_averaged and mean.is_linear and sampling.smooth > 0.0:
            return self._smoothed(sampling, mean, t)
        if sampling.is_even:
            return self._over_plane(sampling, mean, t)[0]
        times = t[:, None] + offsets
        if sampling.is_averaged:
            times = self._within(sampling, t, 0.5 * sampling.period)[:, None] + offsets
        flat = np.ascontiguousarray(times.reshape(-1))
        sample = sampling.torque.sample_apart if sampling.is_averaged else sampling.torque.sample
        samples = sample(self._instant, flat, np.zeros(len(flat)))
        if mean.kind == layout.TORUS:
            shift = np.broadcast_to(offsets, times.shape).reshape(-1, 1)
            numbers = np.concatenate([shift, samples], axis=1)
        else:
            numbers = mean.numbers(samples)
        numbers = numbers.reshape(count, len(offsets), -1)
        if not sampling.is_averaged:
            return numbers[:, 0]
        if mean.is_linear:
            averaged: FloatArray = np.mean(numbers, axis=1)
            return averaged
        if mean.kind == layout.HARMONICS:
            numbers[..., 3] /= ORBIT
        return numbers.reshape(count, -1)

    def _within(self, sampling: Sampling, t: FloatArray, half: float) -> FloatArray:
        """Seconds (T,), moved so that a path is known for a time on both sides."""
        first, last = sampling.torque.span(self._instant)
        return np.clip(t, first + half, last - half)

    def _smoothed(self, sampling: Sampling, mean: Mean, t: FloatArray) -> FloatArray:
        """Numbers (T, F) under weights that fall to zero at both ends of `smooth`.

        Squares of Hann's weights pass nothing of the harmonics of the span but the first two, so
        that turns of the field, every third one, and of the path average out.
        """
        count = int(np.ceil(_FIELD_ORBIT * sampling.smooth / sampling.period))
        shares = (np.arange(count) + 0.5) / count
        weights = np.sin(np.pi * shares) ** 4
        weights /= np.sum(weights)
        middle = self._within(sampling, t, 0.5 * sampling.smooth)
        numbers = np.empty((len(t), 9 if mean.kind == layout.TENSOR else 4))
        for row, when in zip(numbers, middle, strict=True):
            times = when + sampling.smooth * (shares - 0.5)
            samples = sampling.torque.sample_apart(self._instant, times, np.zeros(count))
            row[:] = weights @ mean.numbers(samples)
        return numbers

    def _over_plane(
        self, sampling: Sampling, mean: Mean, t: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Normals and weights (T, 4) of turns; how far their weights are from even ones (T,)."""
        shares = (np.arange(_PLANE) + 0.5) / _PLANE - 0.5
        middle = self._within(sampling, t, 0.5 * sampling.period)
        times = (middle[:, None] + sampling.period * shares).reshape(-1)
        samples = sampling.torque.sample_apart(self._instant, times, np.zeros(len(times)))
        numbers = mean.numbers(samples).reshape(len(t), _PLANE, 4)
        unit, weight = numbers[..., :3], numbers[..., 3:]
        normal = np.sum(np.cross(unit, np.roll(unit, -1, axis=1)), axis=1, keepdims=True)
        normal /= np.maximum(np.sqrt(np.sum(normal**2, axis=2, keepdims=True)), 1e-300)
        total = np.mean(weight, axis=1)
        height = np.sum(unit * normal, axis=2, keepdims=True)
        off = np.max(np.abs(height), axis=(1, 2))
        # exp(i f) of the angle f in the plane, whose powers have no sum under an even weight
        first = unit[:, :1] - height[:, :1] * normal
        wave = np.sum(unit * (first + 1j * np.cross(normal, first)), axis=2, keepdims=True)
        least = np.maximum(np.abs(total[:, 0]), 1e-300)
        for order in range(1, mean.degree + 1):
            off = np.maximum(off, np.abs(np.mean(weight * wave**order, axis=(1, 2))) / least)
        return np.concatenate([normal[:, 0], total], axis=1), off

    def is_even(self, sampling: Sampling, mean: Mean) -> bool:
        """Whether a turn of a path takes a weight that is even over the angle in one plane.

        As light does on any orbit under a central force, whose weight 1/r^2 makes a turn's time
        its angle.
        """
        if not sampling.is_averaged or mean.kind != layout.HARMONICS or mean.is_linear:
            return False
        if np.isfinite(sampling.ripple):
            return False
        first, last = sampling.torque.span(self._instant)
        turns = np.array([0.0, *_TURNS]) * sampling.period
        t = np.clip(np.concatenate([turns, -turns]), first, last)
        return bool(np.all(self._over_plane(sampling, mean, t)[1] <= _EVEN))

    def _rippled(
        self, sampling: Sampling, mean: Mean, t: FloatArray, offsets: FloatArray
    ) -> FloatArray:
        """Direction and weight, averaged over the turn about a planet: without its eclipses."""
        shares = (np.arange(_RIPPLE) + 0.5) / _RIPPLE - 0.5
        half = 0.5 * (sampling.period if sampling.is_averaged else 0.0) + 0.5 * sampling.ripple
        middle = self._within(sampling, t, half)[:, None] + offsets
        times = middle[..., None] + sampling.ripple * shares
        samples = sampling.torque.sample(self._instant, times.reshape(-1), np.zeros(times.size))
        numbers = mean.numbers(samples).reshape(*times.shape, 4)
        weight = numbers[..., 3]
        total = np.maximum(np.mean(weight, axis=-1), 1e-200)
        vector = np.mean(numbers[..., :3] * np.maximum(weight, 1e-200)[..., None], axis=-2)
        unit = vector / np.sqrt(np.sum(vector**2, axis=-1))[..., None]
        row = np.concatenate([unit, total[..., None] / len(offsets)], axis=-1)
        return row.reshape(len(t), -1)

    def interval(self, sampling: Sampling, mean: Mean) -> float:
        """Seconds between samples that splines join to 1e-6 of the largest number."""
        torque = sampling.torque
        if not torque.columns:
            return float("inf")
        first, last = torque.span(self._instant)
        period = sampling.period
        if sampling.is_averaged:
            t = np.array([0.0, *(n * period for n in _TURNS), *(0.37 * n * period for n in _TURNS)])
            t = np.clip(t, first, last)
            values = self.sampled(sampling, mean, t)
            is_one = mean.is_linear or sampling.is_even
            if is_one and _spread(values) <= _REPEATS:
                return float("inf")
            if not is_one and _spread(values[: len(_TURNS) + 1]) <= _REPEATS:
                return float("inf")
            return self._slow(sampling, mean, first, last)
        if not np.isfinite(period):
            t = np.clip(np.array([0.0, 1e3, 1e5, 1e7]), first, last)
            if _spread(self.sampled(sampling, mean, t)) <= _REPEATS:
                return float("inf")
            period = DAY_S
        least = period / _MOST
        if np.isfinite(sampling.ripple):
            least = max(least, sampling.ripple)
        return self._fine(sampling, mean, first, last, period / _FEWEST, least)

    def _slow(self, sampling, mean, first, last):
        """For means over turns of a path that drifts: as many turns as splines can join."""
        longest = 4096.0 * sampling.period
        shortest = max(sampling.period, 0.25 * sampling.smooth)
        if np.isfinite(first) and np.isfinite(last):
            longest = min(longest, (last - first) / 8.0)
        return self._fine(sampling, mean, first, last, longest, shortest, 1e-3)

    def _fine(self, sampling, mean, first, last, width, least, close=_CLOSE):
        """The widest interval, of halves of one, at whose middles a spline errs by little."""
        while width > least:
            begin = min(max(-8.0 * width, first), max(last - 16.0 * width, first))
            end = min(begin + 16.0 * width, last)
            t = np.linspace(begin, end, 17)
            middle = 0.5 * (t[4:12] + t[5:13])
            from scipy.interpolate import CubicSpline

            values = self.sampled(sampling, mean, t)
            error = CubicSpline(t, values, axis=0)(middle) - self.sampled(sampling, mean, middle)
            largest = max(float(np.max(np.abs(values))), 1e-300)
            if float(np.max(np.abs(error))) <= close * largest:
                return width
            width *= 0.5
        return width

    def window(self, number: int, length: float, last: tuple[float, float]) -> FloatArray:
        """The block `forcing` of the window from number times its length, s, to the next.

        last: first and last second at which the paths are known.
        """
        blocks, size = [], 0
        for row, (sampling, mean) in zip(self.models, self.means, strict=True):
            row[layout.FORCING] = size
            if not np.isfinite(sampling.interval):
                values = self.sampled(sampling, mean, np.zeros(1))[0]
                block = np.concatenate([[0.0, 1.0, 0.0], values])
            else:
                begin = max(number * length, last[0])
                end = min((number + 1) * length, last[1])
                if end - begin < 1e-6:
                    raise AttitudeError("the path of a torque ends there; give a longer path.")
                count = max(int(np.ceil((end - begin) / sampling.interval)), 4)
                t = np.linspace(begin, end, count + 1)
                t[-1] = end
                block = np.concatenate(
                    [
                        [begin, (end - begin) / count, float(count)],
                        _tables.spline(t, self.sampled(sampling, mean, t)).reshape(-1),
                    ]
                )
            blocks.append(block)
            size += len(block)
        return np.concatenate(blocks)

    @property
    def length(self) -> float:
        """Seconds of a window; infinite where nothing changes."""
        changing = [s for s, _ in self.means if np.isfinite(s.interval)]
        if not changing:
            return float("inf")
        slow = all(s.is_averaged or np.isfinite(s.ripple) for s in changing)
        return (_FEW_INTERVALS if slow else _INTERVALS) * min(s.interval for s in changing)


def _spread(values: FloatArray) -> float:
    """The largest difference of rows, in units of the largest number."""
    largest = max(float(np.max(np.abs(values))), 1e-300)
    return float(np.max(np.ptp(values, axis=0))) / largest
