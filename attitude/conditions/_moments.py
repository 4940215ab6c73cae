"""Blocks of epochs at which a search evaluates attitudes and directions.

A `Source` is the motion or the scene that is searched, a `Moment` a block of its epochs, and a
`SearchDirection` a direction that is compared with body axes.
"""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from attitude._support import pairs
from attitude.epochs import _inputs, _instants
from attitude.frames import quaternion

if TYPE_CHECKING:
    from collections.abc import Callable
    from typing import TypeAlias

    from numpy.typing import ArrayLike, NDArray

    from attitude._support.annotations import Epochs, FloatArray
    from attitude.motions._history import AttitudeHistory
    from attitude.motions._motion import Motion

    Pair: TypeAlias = tuple[float, float]


# Differences of samples less than a radian apart, of the direction's turning and the body's
# together, are close to derivatives (2 sin(0.4)/0.8 = 0.97 of them).  Bounds are estimated as the
# largest differences of each order times these margins.
_MARGINS = (1.5, 2.0, 3.0)


class Drift(NamedTuple):
    """Bounds of three derivatives of a unit vector on inertial axes: 1/s, 1/s2 and 1/s3."""

    first: float = 0.0
    second: float = 0.0
    third: float = 0.0


class Source:
    """The motion or the scene that is searched, and the epoch from which its seconds count.

    Those of a scene are epochs of reception of light.
    """

    def __init__(self, motion: Motion | None, scene: Any = None) -> None:
        self.motion, self.scene = motion, scene  # a Scene, which is a module above this one
        owner: Any = motion if scene is None else scene
        self.epoch = _instants.J2000 if owner.epoch is None else owner.epoch

    def at(self, hi: FloatArray, lo: FloatArray, step: float | None = None) -> Moment:
        """The block of epochs hi + lo (N,), TDB seconds since the epoch; see `Moment`."""
        return Moment(self, hi, lo, step)

    @property
    def turning(self) -> Motion:
        """The motion, for what needs one; a scene without a motion has been refused before."""
        assert self.motion is not None
        return self.motion


def same_source(one: Source, other: Source) -> bool:
    """Whether two sources are of one scene object, or of equal motions."""
    if one.scene is not None or other.scene is not None:
        return one.scene is other.scene
    return one.motion == other.motion


def values_at(
    source: Source,
    value: Callable[[Moment], NDArray[Any]],
    t: Epochs,
    low: ArrayLike | None,
) -> NDArray[Any]:
    """The values of a function of a Moment at epochs t of any shape and type."""
    times = _inputs.seconds_since(source.epoch, t, low)
    return value(source.at(*times.flat)).reshape(times.hi.shape)


class Moment:
    """A block of epochs hi + lo (N,), s: attitudes and directions, each evaluated once."""

    def __init__(self, source: Source, hi: FloatArray, lo: FloatArray, step: float | None) -> None:
        self.source, self.hi, self.lo, self.step = source, hi, lo, step
        self._body: dict[SearchDirection, FloatArray] = {}
        self._inertial: dict[SearchDirection, FloatArray] = {}

    @cached_property
    def view(self) -> Any:
        """The View (N,) of the scene; only for the source of a scene."""
        assert self.source.scene is not None
        return self.source.scene.since(self.source.epoch, self.hi, self.lo)

    @cached_property
    def history(self) -> AttitudeHistory:
        """The attitudes (N,), those at emission in a scene."""
        if self.source.scene is not None:
            return self.view.attitude
        return self.source.turning.at(self.hi, self.lo)

    def body(self, direction: SearchDirection) -> FloatArray:
        """Unit vectors (N, 3) of a direction in body axes."""
        if direction not in self._body:
            self._body[direction] = direction.body(self)
        return self._body[direction]

    def inertial(self, direction: SearchDirection) -> FloatArray:
        """Unit vectors (N, 3), or (3,) if constant, of a direction on ICRF axes."""
        if direction not in self._inertial:
            self._inertial[direction] = direction.icrf(self)
        return self._inertial[direction]


class SearchDirection:
    """A direction that a search compares with body axes; the base of all kinds.

    A new kind defines `icrf`, and replaces other methods where it knows better.
    """

    name: str = "direction"

    def icrf(self, moment: Moment) -> FloatArray:
        """Unit vectors (N, 3), or (3,) if constant, on ICRF axes."""
        raise NotImplementedError(f"{type(self).__name__} defines no icrf")

    def body(self, moment: Moment) -> FloatArray:
        """Unit vectors (N, 3) in body axes."""
        wxyz = quaternion.conjugate(moment.history.wxyz)
        return quaternion.rotate(wxyz, moment.inertial(self))

    def guess(self, source: Source, start: Pair, length: float) -> float:
        """A guess of the largest rate of the unit vector, 1/s, in a span, for the first block.

        Of 64 samples and near pairs: the samples alias a direction that circles many times.
        """
        if not length > 0.0:
            return 0.0
        s = np.linspace(0.0, length, 65)[:-1]
        apart = length * 2.0**-26
        one, other = (self.icrf(source.at(*pairs.add(start, t))) for t in (s, s + apart))
        fine = float(np.max(lengths(other - one))) / apart
        coarse = float(np.max(lengths(np.diff(one, axis=0)))) / s[1]
        return 1.25 * max(fine, coarse)

    def drift(self, moment: Moment) -> Drift:
        """Upper bounds of the derivatives in a block, by default estimated from its samples."""
        return estimated(moment.inertial(self), moment.step)


def estimated(vectors: FloatArray, step: float | None) -> Drift:
    """The Drift that unit vectors (N, 3) at a spacing of `step` seconds show, with a margin."""
    if vectors.ndim == 1 or not step or len(vectors) < 2:
        return Drift()
    bounds = [0.0, 0.0, 0.0]
    for order in range(3):
        vectors = np.diff(vectors, axis=0) / step
        if len(vectors):
            bounds[order] = _MARGINS[order] * float(np.max(lengths(vectors)))
    return Drift(*bounds)


def lengths(vectors: FloatArray) -> FloatArray:
    """The lengths (...) of vectors (..., 3)."""
    return np.sqrt(np.sum(vectors * vectors, axis=-1))
