"""How fast an attitude can change: bounds without which no crossing can be excluded.

A body axis a, seen from inertial axes, moves by R a with

    |(R a)'| <= |w|,   |(R a)''| <= |w'| + |w|^2,   |(R a)'''| <= |w''| + 3 |w'| |w| + |w|^3.

For a free rotation the greatest |w| follows from energy and momentum, and Euler's equations
w1' = k1 w2 w3 with |k| <= 1 (no moment exceeds the sum of the others) give the rest:
|w'|^2 <= sum k_i^2 w_j^2 w_k^2, also <= |w|^4 / 3, and |w''| <= sqrt(2) |w'| |w|.
"""

from itertools import pairwise
from typing import NamedTuple

import numpy as np

from attitude import pairs
from attitude.attitude_table.table import AttitudeTable
from attitude.errors import AttitudeError
from attitude.free_rotation.free_rotation import FreeRotation
from attitude.regime import regimes

# Bounds from closed forms are widened by their rounding.
_ROUNDED = 1.0 + 1e-12
# Samples a quarter of a radian apart see the greatest rate of a smooth motion to a few percent.
_SAMPLED = 1.25


class Pace(NamedTuple):
    """Bounds of |R a'|, |R a''|, |R a'''| for any unit vector a of the body; inf where unknown."""

    first: float
    second: float
    third: float


class Bounded:
    """A pace that holds at any time."""

    # rad between the knots of a first look, which bounds make safe: the quickest choice.
    spacing = 0.8

    def __init__(self, pace):
        self.pace = pace

    def guess(self, source, base):
        return self.pace.first

    def of(self, moment):
        return self.pace


def free(body, omega):
    """The pace of a free rotation from its angular velocity (3,), rad/s in body axes."""
    moments = np.asarray(body.moments)
    rates = body.rates_about_principal_axes(np.array(omega))[:, 0]
    w = float(np.max(regimes(moments, rates).spin_rate_range)) if np.any(rates) else 0.0
    rate = _acceleration(moments, rates, w)
    w, rate = w * _ROUNDED, rate * _ROUNDED
    return Bounded(Pace(w, rate + w * w, np.sqrt(2.0) * rate * w + 3.0 * rate * w + w**3))


class Sampled:
    """The pace of a motion that is only known at epochs: what its samples have, and a quarter more.

    An estimate, not a proof.  A table's attitudes have kinks where its angular velocities jump, so
    that nothing is said of its second derivative.
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
            return Pace(w, np.inf, np.inf)
        rate = _SAMPLED * _length(moment.history.angular_acceleration)
        return Pace(w, rate + w * w, np.inf)


def pieces(source, start, stop):
    """The parts of a span, pairs of doubles, and what bounds the pace in each of them.

    Arcs are taken one by one: at a joint the angular velocity jumps.  In a scene a joint is seen
    a light time later: there the fastest arc counts for all, and nothing is said of what jumps.
    """
    motion = source.motion
    if isinstance(motion, FreeRotation):
        return [(start, stop, free(motion.body, motion.spin.angular_velocity))]
    if hasattr(motion, "joints"):
        if source.scene is not None:
            every = [motion.joints[0] - 1.0, *motion.joints] if len(motion.joints) else [0.0]
            fastest = max(_on_arc(motion, t).pace.first for t in every)
            return [(start, stop, Bounded(Pace(fastest, np.inf, np.inf)))]
        inside = [t for t in motion.joints if _before(start, (t, 0.0)) and _before((t, 0.0), stop)]
        ends = [start, *((float(t), 0.0) for t in inside), stop]
        return [(a, b, _on_arc(motion, a[0])) for a, b in pairwise(ends)]
    smooth = not isinstance(motion, AttitudeTable) and hasattr(motion, "torques")
    return [(start, stop, Sampled(smooth))]


def _on_arc(motion, t):
    return free(motion.body_at(float(t)), motion.angular_velocity_at(np.float64(t)))


def _acceleration(moments, rates, w):
    """A bound of |w'|: the sharper of that from the greatest components and |w|^2 / sqrt 3."""
    some = moments > 0.0
    if not w > 0.0:
        return 0.0
    scaled = rates / w
    energy = np.sum(moments * scaled**2)
    momentum = np.sum((moments * scaled) ** 2)
    squares = np.zeros(3)
    squares[some] = np.minimum(energy / moments[some], momentum / moments[some] ** 2)
    total = 0.0
    for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        if some[i]:
            gain = (moments[j] - moments[k]) / moments[i]
            total += gain * gain * squares[j] * squares[k]
    return w * w * float(min(np.sqrt(total), np.sqrt(1.0 / 3.0)))


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
