"""How close the records of a C-kernel must stand: the motion on the kernel's clock, and the step.

The step is the one at which the error between records, measured at some places of the span, is a
quarter of the tolerances.
"""

import math

import numpy as np

from attitude import epochs, pairs, quaternion
from attitude import representations as forms
from attitude.attitude_table import interpolation
from attitude.errors import AttitudeError
from attitude.motion import motion_of

DEGREE = 7
_MOST_RECORDS = 20_000_000
# Where the error of interpolation is measured, how far below the tolerances it shall be, and at
# which part of a step.
_PROBES, _MARGIN, _ASIDE = 300, 0.25, 0.25


class Plan:
    """The span of a kernel on its own clock, the motion on it, and the step between records."""

    def __init__(self, motion, start, stop, kind, tolerance, rate_tolerance):
        if kind not in (3, 5):
            raise AttitudeError(f"kind is {kind!r}; CK is written in types 3 and 5.")
        if not (isinstance(tolerance, (int, float)) and 1e-14 <= tolerance <= 1.0):
            raise AttitudeError(f"tolerance is {tolerance!r}; give a number of rad, 1e-14 to 1.")
        motion = motion_of(motion)
        self.kind, self.tolerance, self._motion = kind, float(tolerance), motion
        epoch = motion.epoch
        ends = [epochs.seconds_since(epoch, value) for value in (start, stop)]
        ends = [pairs.add((hi, 0.0), 0.0 if lo is None else lo) for hi, lo in ends]
        # The clock starts at an epoch that is one double of TDB, not after the start.
        first, rest = pairs.add(ends[0], epoch.seconds, epoch.low)
        self.first = float(first if rest >= 0.0 else np.nextafter(first, -np.inf))
        self._shift = pairs.add((self.first, 0.0), -epoch.seconds, -epoch.low)
        begin, end = (pairs.add(pair, -self._shift[0], -self._shift[1])[0] for pair in ends)
        self.begin, self.end = float(begin), float(end)
        if not self.end > self.begin:
            raise AttitudeError("stop is not after start; give a span of time.")
        probes = self.history(np.linspace(self.begin, self.end, _PROBES)).angular_velocity
        fastest = float(np.max(np.linalg.norm(probes, axis=1)))
        if rate_tolerance is None:
            rate_tolerance = self.tolerance * max(fastest, 1e-12)
        if not (isinstance(rate_tolerance, (int, float)) and rate_tolerance > 0.0):
            raise AttitudeError(f"rate_tolerance is {rate_tolerance!r}; give rad/s above zero.")
        self.rate_tolerance = float(rate_tolerance)
        self.step = self._first_step(fastest)

    def history(self, seconds):
        """The motion at seconds of the clock, exactly."""
        return self._motion.at(*pairs.add((seconds, 0.0), *self._shift))

    def records(self):
        """The seconds of all records: the step, a little less so that the last is the end."""
        count = max(math.ceil((self.end - self.begin) / self.step) + 1, 2)
        if count > _MOST_RECORDS:
            raise AttitudeError(
                f"the tolerances want {count} records, more than {_MOST_RECORDS}; give larger "
                "ones, a shorter span, or type 5."
            )
        return np.linspace(self.begin, self.end, count)

    def _first_step(self, fastest):
        """A step at which the error between records is a quarter of the tolerances."""
        span = self.end - self.begin
        # SPICE takes quaternions more than 90 deg apart for a mistake of sign.
        longest = min(span, 1.0 / fastest) if fastest > 0.0 else span
        step = 0.5 * longest
        order = 2.0 if self.kind == 3 else DEGREE + 1.0
        for _ in range(4):
            step = min(step, longest)
            errors = self._errors(step)
            worst = max(errors[0] / self.tolerance, errors[1] / self.rate_tolerance)
            step *= min((_MARGIN / max(worst, 1e-30)) ** (1.0 / order), 4.0)
        return min(step, longest)

    def _errors(self, step):
        """Largest errors of attitude and rate between records so far apart, at some places."""
        width = 2 if self.kind == 3 else (DEGREE + 1) // 2
        room = (width - 1) * step
        first = self.begin + np.linspace(0.0, 1.0, _PROBES) * max(self.end - self.begin - room, 0.0)
        place = np.arange(width) * step
        t = first[:, None] + place
        t = np.minimum(t, self.end) if room > self.end - self.begin else t
        nodes = self.history(t)
        # Not in the middle, where the error of a steady rotation is one of length alone.
        middle = first + (0.5 * (width - 1) + _ASIDE) * step
        middle = np.minimum(middle, self.end)
        true = self.history(middle)
        q = [nodes.wxyz[:, k] for k in range(width)]
        w = [nodes.angular_velocity_inertial[:, k] for k in range(width)]
        if self.kind == 3:
            turn = quaternion.multiply(quaternion.conjugate(q[0]), q[1])
            part = forms.from_rotation_vector((0.5 + _ASIDE) * forms.to_rotation_vector(turn))
            rates = w[0] + (0.5 + _ASIDE) * (w[1] - w[0])
            found = quaternion.multiply(q[0], part), rates
        else:
            at = np.broadcast_to(place / step, (len(first), width))
            x = (middle - first) / step
            bends = quaternion.rotate(nodes.wxyz, nodes.angular_acceleration)
            change = forms.quaternion_rate(nodes.wxyz, nodes.angular_velocity)
            slopes = [[part[:, k] * step for k in range(width)] for part in (change, bends)]
            found = [
                interpolation.polynomial(at, values, slope, x)
                for values, slope in zip((q, w), slopes, strict=True)
            ]
        off = longest(found[1] - true.angular_velocity_inertial)
        return apart(forms.unit(found[0]), true.wxyz), off


def apart(p, q):
    """The largest angle in rad between attitudes."""
    return float(
        np.max(forms.to_axis_angle(quaternion.multiply(quaternion.conjugate(p), q))[1], initial=0.0)
    )


def longest(vectors):
    return float(np.max(np.linalg.norm(vectors, axis=-1), initial=0.0))
