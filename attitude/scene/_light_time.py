"""Light-time corrected lines of sight: the target where it emitted the light seen at t.

The epoch of emission is t minus the light time, which depends on the position of the target at
emission: a fixed point, iterated until the target moves by less than rounding in the remaining
error of the light time (SPICE's "converged Newtonian").  Positions and the speed of light are
barycentric.

For targets nearer than a light second the difference of two barycentric positions is too coarse:
it rounds by 3e-5 m, and both contain the motion of the Earth.  There the light time shifts the
viewer instead: target(t - T) - viewer(t) = [target - viewer](t - T) - T v(t - T/2), where v is the
barycentric velocity of the viewer.  The bracket is computed without the Earth's distance from the
Sun; the next term of the series is T^3 / 24 times the viewer's jerk: 1e-9 m where both are in low
orbit.

Source: NAIF, SPK Required Reading, "light time corrections"; Kaplan et al., AJ 97, 1197 (1989).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from attitude._support import pairs
from attitude._support.arrays import new_array, read_only
from attitude._support.constants import SPEED_OF_LIGHT_M_S
from attitude.errors import AttitudeError
from attitude.paths import _path
from attitude.paths._composed import relative
from attitude.paths._compressed import compress
from attitude.paths._path import SSB, Direction, Path, common_span, label_of, since, spelled
from attitude.scene import _angles

if TYPE_CHECKING:
    from typing import TypeAlias

    from attitude._support.annotations import FloatArray
    from attitude.epochs._instants import Instant
    from attitude.paths._path import Ephemeris, Place

    Sample: TypeAlias = tuple[Instant, FloatArray, FloatArray]


_NEAR = 1.0  # light seconds
_EPS = np.finfo(np.float64).eps
# Rounding of a difference of barycentric positions, in units of eps times their size.
_ROUNDINGS = 2.0
_NOISE = 1e3
# Each secant step doubles the number of correct digits: 1e-4, 1e-12 and so on for planets.
_MOST_PASSES = 30
# Change of the light time, times the light time, s2, below which the velocity of the viewer is
# kept: at 10 m/s2, the fall in low orbit, it shifts the target by 1e-9 m.
_SAME = 2e-10


class Steps(NamedTuple):
    """The paths of a target to its viewer, and of both to the barycentre; found once."""

    geometric: Path
    target: Path
    viewer: Path

    @classmethod
    def of(
        cls, target: Path | str | int, viewer: Path | str | int, ephemeris: Ephemeris | None
    ) -> Steps:
        """Those of paths or names of bodies; see `paths.relative`."""
        ends = (target, viewer), (target, SSB), (viewer, SSB)
        return cls(*(relative(*pair, ephemeris) for pair in ends))


class Sightline(Path):
    """The path from a viewer at t to a target at the epoch at which its light left towards t.

    Epochs of the sample decide whether it `is_near`, within a light second; `nearest`: m.
    """

    def __init__(self, steps: Steps, sample: Sample) -> None:
        self.geometric, self.target, self.viewer = steps.geometric, steps.target, steps.viewer
        self.name, self.center = self.geometric.name, self.geometric.center
        self.source = self.geometric.source
        self.is_slow = any(step.is_slow for step in steps)
        # The span of the target ends a light time later here; the target itself checks it.
        self.span = None
        self._ends = common_span([self.target])
        distances = _length(self._guess(*sample, self.geometric))
        self.nearest = float(np.min(distances, initial=np.inf)) if distances.size else 0.0
        self.is_near = bool(np.max(distances, initial=0.0) < _NEAR * SPEED_OF_LIGHT_M_S)
        self._sample = sample

    @cached_property
    def roughness(self) -> float:  # type: ignore[override]  # computed
        """See `Path`, m: that of the parts, and the rounding of barycentric positions."""
        if self.is_near:
            return self.geometric.roughness
        size = float(np.max(np.abs(self.viewer._position(*self._sample)), initial=0.0))
        return self.geometric.roughness + 8.0 * _EPS * size

    def _position(self, instant, hi, lo):
        return self._solved(instant, hi, lo)[0]

    def _state(self, instant, hi, lo):
        seen, light = self._solved(instant, hi, lo)
        moved = self.target._state(instant, *_earlier(hi, lo, light))[1]
        towards = seen / np.maximum(_length(seen), np.finfo(np.float64).tiny)
        velocity_of_viewer = self.viewer._state(instant, hi, lo)[1]
        # d/dt of target(t - T) - viewer(t), with T' from T = |seen| / c.
        away = _dot(towards, moved - velocity_of_viewer) / SPEED_OF_LIGHT_M_S
        rate = away / (1.0 + _dot(towards, moved) / SPEED_OF_LIGHT_M_S)
        return seen, moved * (1.0 - rate) - velocity_of_viewer

    def _solved(self, instant, hi, lo):
        """The vectors (3, N) from viewer to target in m, and their light times (N,) in s."""
        at = self._near if self.is_near else self._far
        vectors_at, size = at(instant, hi, lo)
        seen, epochs = vectors_at(None, (hi, lo)), (read_only(hi), read_only(lo))
        times, light, before, speed, slope = np.zeros((5, hi.size))
        largest = _angles.light_times(_whole(seen), SPEED_OF_LIGHT_M_S, times)
        limit = _ROUNDINGS * _EPS * (size + largest)
        least = _NOISE * limit / SPEED_OF_LIGHT_M_S
        for _ in range(_MOST_PASSES):
            emitted = np.empty((2, hi.size))
            _angles.secant_step(*epochs, times, slope, light, before, *emitted)
            try:
                old, seen = seen, vectors_at(light, emitted)
            except AttitudeError as err:
                raise AttitudeError(
                    f"{err} Light left up to {light.max():.6g} s before the epochs of the scene."
                ) from err
            error = _angles.secant_slopes(
                _whole(seen),
                _whole(old),
                light,
                before,
                least,
                SPEED_OF_LIGHT_M_S,
                times,
                speed,
                slope,
            )
            if not error > limit:
                return seen, light
        raise AttitudeError(
            f"the light time of {self.name} does not converge near "
            f"{spelled(instant.after(float(hi[0])))}: the target moves as fast as light; give "
            "paths in m and m/s."
        )

    def _far(self, instant, hi, lo):
        """A function of light times (N,) or None and epochs of emission (2, N) that returns vectors
        (3, N) from barycentric positions, and the largest number that enters these differences, m.
        """
        place_of_viewer = self.viewer._position(instant, hi, lo)

        def vectors_at(light, emitted):
            if light is None:
                return self._guess(instant, hi, lo, self.target) - place_of_viewer
            return self.target._position(instant, *emitted) - place_of_viewer

        return vectors_at, np.abs(place_of_viewer).max(initial=0.0)

    def _near(self, instant, hi, lo):
        """As `_far`, by the series for near targets."""
        known = []

        def vectors_at(light, emitted):
            if light is None:
                return self._guess(instant, hi, lo, self.geometric)
            seen = self.geometric._position(instant, *emitted)
            if not known or np.max(np.abs(light - known[0]) * light, initial=0.0) > _SAME:
                middle = _earlier(hi, lo, 0.5 * light)
                known[:] = light.copy(), self.viewer._state(instant, *middle)[1]
            return seen - light * known[1]

        return vectors_at, 0.0

    def _guess(self, instant, hi, lo, path):
        """Positions at reception, or the end of the target's span: emission is earlier."""
        if self._ends is not None and hi.size:
            last = since(self._ends[1], instant)
            beyond = (hi - last[0]) + (lo - last[1]) > 0.0
            if beyond.any():
                hi, lo = np.where(beyond, last[0], hi), np.where(beyond, last[1], lo)
        return path._position(instant, hi, lo)


def _earlier(hi, lo, light):
    return pairs.add((hi, lo), -light)


def _whole(vectors):
    """Vectors (3, N) as compiled loops take them."""
    return read_only(np.ascontiguousarray(vectors))


def _length(vectors):
    return np.sqrt(vectors[0] ** 2 + vectors[1] ** 2 + vectors[2] ** 2)


def _dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


# ---- Lines of sight at many epochs: directions and distances, compressed where that is cheaper

# Epochs in a block: some MB of temporaries, whatever the number of epochs.
_BLOCK = 1 << 16
# Fewer epochs are evaluated faster than fitted.
_FEWEST = 2000
# The same of a slow path.
_FEWEST_OF_SLOW = 300
# Positions that a fit may evaluate, per epoch.
_SHARE = 0.25
# Largest angle by which a fit may turn a direction, rad.
_LARGEST_TURN = 4e-10
# The smaller angle that fits aim at, rad.
_AIMED_TURN = 1e-10
_SAMPLE = 65


@dataclass(frozen=True, eq=False)
class LineOfSight(_path.FrozenArrays):
    """A line of sight: unit vectors (3, N), or (3, 1) if constant, ICRF, and distances (N,), m.

    The distance is None for a direction; `error`: of a compression, m.
    """

    unit: FloatArray
    distance: FloatArray | None
    source: str
    error: float | None = None

    def some(self, block: slice) -> LineOfSight:
        """The line of sight at some of the epochs."""
        unit = self.unit if self.unit.shape[1] == 1 else self.unit[:, block]
        distance = None if self.distance is None else self.distance[block]
        return LineOfSight(unit, distance, self.source, self.error)


def fixed(place: Place) -> LineOfSight:
    """The LineOfSight towards a `paths.Direction`."""
    assert isinstance(place, Direction)
    return LineOfSight(place.unit[:, None].copy(), None, repr(place))


def sample(instant: Instant, hi: FloatArray, lo: FloatArray) -> Sample:
    """The first and the last of the finite epochs, then some of them in the order given."""
    total = hi if lo.size == 1 and lo[0] == 0.0 else hi + lo
    # The sum is finite exactly where every term of it is.
    known = slice(None) if np.isfinite(total.sum()) else np.isfinite(total)
    total, hi, lo = total[known], hi[known], np.broadcast_to(lo, hi.shape)[known]
    if not total.size:
        return instant, np.zeros(0), np.zeros(0)
    every = slice(None, None, max(1, total.size // _SAMPLE))
    ends = [np.argmin(total), np.argmax(total)]
    return instant, np.concatenate([hi[ends], hi[every]]), np.concatenate([lo[ends], lo[every]])


def seen(
    path: Path,
    instant: Instant,
    hi: FloatArray,
    lo: FloatArray,
    some: Sample,
    tolerance: float | None,
    sign: float = 1.0,
) -> LineOfSight:
    """The LineOfSight along the position vectors of a path."""
    if tolerance is not None and hi.size >= (_FEWEST_OF_SLOW if path.is_slow else _FEWEST):
        line = _compressed(path, instant, hi, lo, some, tolerance, sign)
        if line is not None:
            return line
    return _evaluated(path, instant, hi, lo, sign)


def _compressed(path, instant, hi, lo, some, tolerance, sign):
    """The LineOfSight by a compression of the path, or None if that costs more than it saves."""
    if not some[1].size:
        return None
    first, last = ((float(some[1][k]), float(some[2][k])) for k in (0, 1))
    if not sum(last) > sum(first):
        return None
    if isinstance(path, Sightline):
        nearest = path.nearest
    else:
        nearest = np.min(np.linalg.norm(path.position(*some), axis=-1))
    metered = Metered(path, int(_SHARE * hi.size))
    # The sample may miss the nearest point: the second pass takes the distance found by the first.
    for _ in range(2):
        aim = min(tolerance, _AIMED_TURN * nearest)
        unit, distance = new_array(3, hi.size), new_array(hi.size)
        try:
            small = compress(metered, instant.after(*first), instant.after(*last), aim)
            small.directions(instant, hi, lo, sign, unit, distance)
        except AttitudeError:
            # Too many states, not smooth enough, or ends that a sum hi + lo rounds inwards.  Any
            # other error recurs when the path itself is evaluated.
            return None
        line = _line(path, instant, hi, unit, distance, small.error)
        nearest = np.nanmin(line.distance)
        if small.error <= _LARGEST_TURN * nearest:
            return line
    return None


def _evaluated(path, instant, hi, lo, sign):
    """The LineOfSight of a path, evaluated at every epoch."""
    unit, distance = new_array(3, hi.size), new_array(hi.size)
    for begin in range(0, hi.size, _BLOCK):
        block = slice(begin, begin + _BLOCK)
        low = lo if lo.size == 1 and hi.size > 1 else lo[block]
        vectors = np.ascontiguousarray(path.position(instant, hi[block], low).T)
        _angles.normalised(read_only(vectors), sign, begin, unit, distance)
    return _line(path, instant, hi, unit, distance)


def _line(path, instant, hi, unit, distance, error=None):
    """The LineOfSight of a path, which is named in messages; refused where a distance is zero."""
    if distance.size and np.nanmin(distance, initial=np.inf) == 0.0:
        at = int(np.argmax(distance == 0.0))
        raise AttitudeError(
            f"{path.name} and {label_of(path.center)} are in one place at "
            f"{spelled(instant.after(float(hi[at])))}, where the direction from one to the "
            "other is undefined; give two different ones."
        )
    return LineOfSight(unit, distance, path.source, error)


class Metered(Path):
    """A path without velocities that refuses more than `left` positions: the cost of a fit."""

    def __init__(self, path: Path, budget: int) -> None:
        self.path, self.left = path, budget
        self.name, self.center, self.source = path.name, path.center, path.source
        self.span, self.roughness, self.is_slow = path.span, path.roughness, path.is_slow

    def _state(self, instant, hi, lo):
        self.left -= hi.size
        if self.left < 0:
            raise AttitudeError(
                f"the compression of {self.name} needs more positions than direct evaluation; "
                "evaluate the path itself."
            )
        return self.path._position(instant, hi, lo), np.zeros((3, hi.size))
