"""Bounds of how fast the attitude of a motion changes, over the parts of a search.

A free rotation, and each arc of a chain, has bounds that are proven (`Motion.rate_bounds`); of
other motions samples are taken.
"""

from itertools import pairwise

import numpy as np

from attitude import pairs
from attitude.errors import AttitudeError
from attitude.motion import RateBounds

# Samples a quarter of a radian apart see the greatest rate of a smooth motion to a few percent.
_SAMPLED = 1.25


class Bounded:
    """Bounds that hold at any time of a part."""

    # rad between the knots of a first look, which bounds make safe: the quickest choice.
    spacing = 0.8

    def __init__(self, bounds):
        self.bounds = bounds

    def guess(self, source, base):
        return self.bounds.first

    def of(self, moment):
        return self.bounds


class Sampled:
    """Estimates for a motion that is known at epochs only: its greatest samples and a quarter.

    No proof.  A table's attitudes have kinks where its angular velocities jump, so the second
    derivative of a motion that is not smooth has no bound.
    """

    spacing = 0.25

    def __init__(self, smooth):
        self.smooth = smooth

    def guess(self, source, base):
        moment = source.at(np.array([base[0]]), np.array([base[1]]))
        return _length(moment.history.angular_velocity)

    def of(self, moment):
        w = _SAMPLED * _length(moment.history.angular_velocity)
        if not self.smooth:
            return RateBounds(w, np.inf, np.inf)
        rate = _SAMPLED * _length(moment.history.angular_acceleration)
        return RateBounds(w, rate + w * w, np.inf)


def pieces(source, start, stop):
    """The parts of a span, pairs of doubles, and the bounds in each of them.

    Arcs are taken one by one: at a joint the angular velocity jumps.  In a scene a joint is seen
    a light time later: there the fastest arc counts for all, and nothing is said of what jumps.
    """
    motion = source.motion
    joints = motion.joints
    if motion.rate_bounds(start[0]) is None:
        return [(start, stop, Sampled(motion.smooth))]
    if not len(joints):
        return [(start, stop, Bounded(motion.rate_bounds(start[0])))]
    if source.scene is not None:
        every = [joints[0] - 1.0, *joints]
        fastest = max(motion.rate_bounds(float(t)).first for t in every)
        return [(start, stop, Bounded(RateBounds(fastest, np.inf, np.inf)))]
    inside = [t for t in joints if _before(start, (t, 0.0)) and _before((t, 0.0), stop)]
    ends = [start, *((float(t), 0.0) for t in inside), stop]
    return [(a, b, Bounded(motion.rate_bounds(a[0]))) for a, b in pairwise(ends)]


def _length(vectors):
    largest = float(np.max(np.sqrt(np.sum(np.asarray(vectors) ** 2, axis=-1))))
    if not np.isfinite(largest):
        raise AttitudeError(
            "the motion has no finite angular velocity at some epoch of the search; give a span in "
            "which it is known."
        )
    return largest


def _before(one, other):
    difference = pairs.add(other, -one[0], -one[1])
    return difference[0] + difference[1] > 0.0
