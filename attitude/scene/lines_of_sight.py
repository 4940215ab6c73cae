"""Lines of sight at many epochs: directions and distances, compressed where that is cheaper."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from attitude import paths
from attitude.errors import AttitudeError
from attitude.immutable import Immutable, frozen, read_only
from attitude.memory import new_array
from attitude.paths.path import Path, spelled
from attitude.paths.uniform import Direction
from attitude.scene.light_time import Sightline

if TYPE_CHECKING:
    from typing import TypeAlias

    from attitude.annotations import FloatArray
    from attitude.epochs import Instant
    from attitude.paths.place import Place

    # Epochs: an instant, and seconds from it as two doubles, hi (N,) and lo (N,) or (1,).
    Sample: TypeAlias = tuple[Instant, FloatArray, FloatArray]

# Epochs in a block: some MB of temporaries, whatever the number of epochs.
_BLOCK = 1 << 16
# Fewer epochs are evaluated faster than fitted; of a slow path fewer than these.
_FEWEST, _FEWEST_OF_SLOW = 2000, 300
# Positions that a fit may evaluate, per epoch.
_SHARE = 0.25
# Largest angle by which a fit may turn a direction, rad, and the smaller one that fits aim at.
_LARGEST_TURN, _AIMED_TURN = 4e-10, 1e-10
_SAMPLE = 65


@dataclass(frozen=True, eq=False)
class LineOfSight(Immutable):
    """A line of sight at each epoch: direction and distance.

    Attributes
    ----------
    unit : (3, N) or (3, 1) array
        Unit vectors, ICRF; (3, 1) if the direction is the same at all epochs.
    distance : (N,) array or None
        m; None for a `paths.Direction`, which is infinitely far away.
    source : str
        Where the positions come from.
    error : float or None
        Largest measured error of the compression, m; None without a compression.
    """

    unit: FloatArray
    distance: FloatArray | None
    source: str
    error: float | None = None

    def __post_init__(self) -> None:
        frozen(self.unit)
        if self.distance is not None:
            frozen(self.distance)

    def some(self, part: slice) -> LineOfSight:
        """The line of sight at some of the epochs."""
        unit = self.unit if self.unit.shape[1] == 1 else self.unit[:, part]
        distance = None if self.distance is None else self.distance[part]
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
    """The LineOfSight along the position vectors of a path.

    Parameters
    ----------
    path : Path
    instant, hi, lo
        The epochs: seconds hi (N,) and lo (N,) or (1,) from the instant.
    some : tuple
        The `sample` of the epochs.
    tolerance : float or None
        Largest error of a compression, m; None for no compression.
    sign : float
        -1.0 for the directions opposite to the vectors of the path.

    Raises
    ------
    AttitudeError
        If a distance is zero.
    """
    if tolerance is not None and hi.size >= (_FEWEST_OF_SLOW if path.is_slow else _FEWEST):
        line = _compressed(path, instant, hi, lo, some, tolerance, sign)
        if line is not None:
            return line
    return _evaluated(path, instant, hi, lo, sign)


def _compressed(path, instant, hi, lo, some, tolerance, sign):
    """The LineOfSight by a compression of the path, or None if that costs more than it saves."""
    if not some[1].size:
        return None
    if isinstance(path, Sightline):
        nearest = path.nearest
    else:
        nearest = np.min(np.linalg.norm(path.position(*some), axis=-1))
    first, last = ((float(some[1][k]), float(some[2][k])) for k in (0, 1))
    if not sum(last) > sum(first):
        return None
    metered = Metered(path, int(_SHARE * hi.size))
    # The sample may miss the nearest point: the second pass takes the distance found by the first.
    for _ in range(2):
        aim = min(tolerance, _AIMED_TURN * nearest)
        try:
            small = paths.compress(metered, instant.after(*first), instant.after(*last), aim)
        except AttitudeError:
            # Too many states, or not smooth enough.  Any other error recurs when the path itself
            # is evaluated.
            return None
        unit, distance = new_array(3, hi.size), new_array(hi.size)
        small.directions(instant, hi, lo, sign, unit, distance)
        line = _line(path, instant, hi, unit, distance, small.error)
        nearest = np.nanmin(line.distance)
        if small.error <= _LARGEST_TURN * nearest:
            return line
    return None


def _evaluated(path, instant, hi, lo, sign):
    """The LineOfSight of a path, evaluated at every epoch."""
    from attitude.scene import loops

    unit, distance = new_array(3, hi.size), new_array(hi.size)
    for begin in range(0, hi.size, _BLOCK):
        part = slice(begin, begin + _BLOCK)
        low = lo if lo.size == 1 and hi.size > 1 else lo[part]
        vectors = np.ascontiguousarray(path.position(instant, hi[part], low).T)
        loops.normalised(read_only(vectors), sign, begin, unit, distance)
    return _line(path, instant, hi, unit, distance)


def _line(path, instant, hi, unit, distance, error=None):
    """The LineOfSight of a path, which is named in messages; refused where a distance is zero."""
    if distance.size and np.nanmin(distance, initial=np.inf) == 0.0:
        at = int(np.argmax(distance == 0.0))
        raise AttitudeError(
            f"{path.name} and {_named(path.center)} are in one place at "
            f"{spelled(instant.after(float(hi[at])))}, where the direction from one to the "
            "other is undefined; give two different ones."
        )
    return LineOfSight(unit, distance, path.source, error)


def _named(center):
    return center if isinstance(center, str) else center.name


class Metered(Path):
    """A path that raises an AttitudeError after a number of positions, to bound the cost of a fit.

    Velocities are zero: a line of sight needs none, and the `speed_error` of its fit is not used.

    Parameters
    ----------
    path : Path
    budget : int
        Number of positions that may be evaluated.
    """

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
