"""Upper bounds of the derivatives of body-fixed directions over the parts of a search.

For a free rotation and for each arc of a chain the bounds are proven (`Motion.rate_bounds`); for
other motions they are estimated from samples.
"""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from attitude import pairs
from attitude.errors import AttitudeError
from attitude.motion import Motion, RateBounds

if TYPE_CHECKING:
    from attitude.annotations import FloatArray
    from attitude.conditions.moments import Moment, Pair, Source

# Samples 0.25 rad apart show the largest rate of a smooth motion to a few percent.
_MARGIN = 1.25


class Bounded:
    """Bounds that hold at any time of a part.

    Attributes
    ----------
    spacing : float
        Of the first knots, in rad of rotation; bounds make any spacing safe, this one is fastest.
    bounds : RateBounds
    """

    spacing: Final = 0.8

    def __init__(self, bounds: RateBounds) -> None:
        self.bounds = bounds

    def guess(self, source: Source, base: Pair) -> float:
        """The bound of the rate, rad/s."""
        return self.bounds.first

    def of(self, moment: Moment) -> RateBounds:
        """The bounds for a block of epochs."""
        return self.bounds


class Sampled:
    """Estimates for a motion without bounds: the largest samples of a block times 1.25.

    They prove nothing.  The attitudes of a table have kinks where its angular velocities jump, so
    the second derivative of a motion that is not smooth has no bound.

    Attributes
    ----------
    spacing : float
        Of the first knots, in rad of rotation.
    smooth : bool
        Whether angular accelerations are known.
    """

    spacing: Final = 0.25

    def __init__(self, smooth: bool) -> None:
        self.smooth = smooth

    def guess(self, source: Source, base: Pair) -> float:
        """The rate at an epoch, rad/s."""
        moment = source.at(np.array([base[0]]), np.array([base[1]]))
        return _length(moment.history.angular_velocity)

    def of(self, moment: Moment) -> RateBounds:
        """The estimates for a block of epochs; inf for derivatives that are unknown."""
        w = _MARGIN * _length(moment.history.angular_velocity)
        if not self.smooth:
            return RateBounds(w, np.inf, np.inf)
        rate = _MARGIN * _length(moment.history.angular_acceleration)
        return RateBounds(w, rate + w * w, np.inf)


def pieces(source: Source, start: Pair, stop: Pair) -> list[tuple[Pair, Pair, Bounded | Sampled]]:
    """The parts (start, stop) of a span, pairs of seconds, with the bounds that hold in each.

    Each arc is a part of its own: at a joint the angular velocity jumps.  In a scene a joint is
    seen a light time later: there the rate of the fastest arc bounds the whole span, and the
    derivatives that jump have no bound.
    """
    motion = source.turning
    joints = motion.joints
    if motion.rate_bounds(start[0]) is None:
        return [(start, stop, Sampled(motion.smooth))]
    if not len(joints):
        return [(start, stop, Bounded(_bounds_at(motion, start[0])))]
    if source.scene is not None:
        in_each_arc = [joints[0] - 1.0, *joints]
        fastest = max(_bounds_at(motion, float(t)).first for t in in_each_arc)
        return [(start, stop, Bounded(RateBounds(fastest, np.inf, np.inf)))]
    inside = [t for t in joints if _before(start, (t, 0.0)) and _before((t, 0.0), stop)]
    ends = [start, *((float(t), 0.0) for t in inside), stop]
    return [(a, b, Bounded(_bounds_at(motion, a[0]))) for a, b in pairwise(ends)]


def _bounds_at(motion: Motion, seconds: float) -> RateBounds:
    bounds = motion.rate_bounds(seconds)
    assert bounds is not None  # a motion has bounds everywhere or nowhere
    return bounds


def _length(vectors: FloatArray) -> float:
    """The largest length of vectors (N, 3)."""
    largest = float(np.max(np.sqrt(np.sum(np.asarray(vectors) ** 2, axis=-1))))
    if not np.isfinite(largest):
        raise AttitudeError(
            "the motion has no finite angular velocity at some epoch of the search; give a span in "
            "which it is known."
        )
    return largest


def _before(one: Pair, other: Pair) -> Any:
    difference = pairs.add(other, -one[0], -one[1])
    return difference[0] + difference[1] > 0.0
