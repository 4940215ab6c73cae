"""Lines of sight at many epochs: directions and distances, compressed where that pays."""

from dataclasses import dataclass

import numpy as np

from attitude import paths
from attitude.errors import AttitudeError
from attitude.immutable import Immutable, frozen, read_only
from attitude.paths.path import Path, spelled

# Epochs in a block: some MB of temporaries, whatever the number of epochs.
_BLOCK = 1 << 16
# Fewer epochs are not worth a fit.
_FEWEST = 2000
# A fit may ask for so many states for each epoch; a state costs about two positions.
_SHARE = 0.25
# What a fit may turn a direction by, rad; asked for with some reserve.
_TURN, _ASKED = 4e-10, 1e-10
_SAMPLE = 65


@dataclass(frozen=True, eq=False)
class Line(Immutable):
    """What a line of sight was at each epoch.

    Attributes
    ----------
    unit : (3, N) or (3, 1) array
        Direction in ICRF; (3, 1) where it is the same at all epochs.
    distance : (N,) array or None
        m; None for what is infinitely far away.
    source : str
        Where the positions come from.
    error : float or None
        m, the largest measured error of the compression; None where there was none.
    """

    unit: np.ndarray
    distance: np.ndarray
    source: str
    error: float = None

    def __post_init__(self):
        frozen(self.unit)
        if self.distance is not None:
            frozen(self.distance)


def fixed(direction):
    """The line towards a `paths.direction`."""
    return Line(direction.unit[:, None].copy(), None, repr(direction))


def sample(instant, hi, lo):
    """Some of the epochs, finite ones, the first and last before others: (instant, hi, lo)."""
    total = hi if lo.size == 1 and lo[0] == 0.0 else hi + lo
    # The sum is finite exactly where every term of it is.
    known = slice(None) if np.isfinite(total.sum()) else np.isfinite(total)
    total, hi, lo = total[known], hi[known], np.broadcast_to(lo, hi.shape)[known]
    if not total.size:
        return instant, np.zeros(0), np.zeros(0)
    every = slice(None, None, max(1, total.size // _SAMPLE))
    ends = [np.argmin(total), np.argmax(total)]
    return instant, np.concatenate([hi[ends], hi[every]]), np.concatenate([lo[ends], lo[every]])


def seen(path, instant, hi, lo, some, tolerance, sign=1.0):
    """The Line of a path of vectors at epochs hi (N,), lo (N,) or (1,).

    Parameters
    ----------
    some : tuple
        The `sample` of the epochs.
    tolerance : float or None
        m that a compression may err by; None for no compression.
    sign : float
        -1.0 for the directions opposite to the vectors of the path.

    Raises
    ------
    AttitudeError
        Where a distance is zero.
    """
    if tolerance is not None and hi.size >= _FEWEST:
        line = _compressed(path, instant, hi, lo, some, tolerance, sign)
        if line is not None:
            return line
    return _evaluated(path, instant, hi, lo, path, sign)


def _compressed(path, instant, hi, lo, some, tolerance, sign):
    """The Line by a compression of the path, or None where that costs more than it saves."""
    if not some[1].size:
        return None
    nearest = np.min(np.linalg.norm(path.position(*some), axis=-1))
    first, last = ((float(some[1][k]), float(some[2][k])) for k in (0, 1))
    if not sum(last) > sum(first):
        return None
    metered = Metered(path, int(_SHARE * hi.size))
    # Samples may miss the nearest point: then once more, for what was found.
    for _ in range(2):
        asked = min(tolerance, _ASKED * nearest)
        try:
            small = paths.compress(metered, instant.after(*first), instant.after(*last), asked)
        except AttitudeError:
            # Too dear, or not smooth enough; whatever else is wrong is told by the path itself.
            return None
        line = _evaluated(small, instant, hi, lo, path, sign, small.error)
        nearest = np.nanmin(line.distance)
        if small.error <= _TURN * nearest:
            return line
    return None


def _evaluated(path, instant, hi, lo, told, sign, error=None):
    from attitude.scene import loops

    unit, distance = np.empty((3, hi.size)), np.empty(hi.size)
    for begin in range(0, hi.size, _BLOCK):
        part = slice(begin, begin + _BLOCK)
        low = lo if lo.size == 1 and hi.size > 1 else lo[part]
        vectors = np.ascontiguousarray(np.moveaxis(path.position(instant, hi[part], low), -1, 0))
        loops.normalised(read_only(vectors), sign, begin, unit, distance)
    at = np.flatnonzero(distance == 0.0)
    if at.size:
        raise AttitudeError(
            f"{told.name} and {_named(told.center)} are in one place at "
            f"{spelled(instant.after(float(hi[at[0]])))}, so that neither is seen from the other; "
            "give two different ones."
        )
    return Line(unit, distance, told.source, error)


def _named(center):
    return center if isinstance(center, str) else center.name


class Metered(Path):
    """A path that may be asked for so many states, and no more."""

    def __init__(self, path, budget):
        self.path, self.left = path, budget
        self.name, self.center, self.source = path.name, path.center, path.source
        self.span, self.roughness = path.span, path.roughness

    def _state(self, instant, hi, lo):
        self.left -= hi.size
        if self.left < 0:
            raise AttitudeError(
                f"{self.name} takes more states to compress than are worth it; evaluate it itself."
            )
        return self.path._state(instant, hi, lo)
