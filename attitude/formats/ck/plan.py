"""The motion on the clock of a C-kernel, and the step between records.

At this step the error between records, measured at some places of the span, is a quarter of the
tolerances.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from attitude import epochs, pairs, quaternion
from attitude import representations as forms
from attitude.attitude_table import interpolation
from attitude.errors import AttitudeError
from attitude.motion import motion_of

if TYPE_CHECKING:
    from attitude.annotations import EpochOrSeconds, FloatArray
    from attitude.history import AttitudeHistory
    from attitude.motion import HasAttitudes

# Degree of the Hermite polynomials of type 5.
DEGREE: int = 7
_MOST_RECORDS = 20_000_000
# Places at which the error of interpolation is measured, and its ratio to the tolerances.
_PROBES, _MARGIN = 300, 0.25
# Distance of these places from the middle of a step, in steps.
_OFF_MIDDLE = 0.25


class Plan:
    """The span of a kernel on its clock, the motion there, and the step between records.

    The clock counts TDB seconds from `first`.

    Parameters
    ----------
    motion, start, stop, kind, tolerance, rate_tolerance
        As of `ck.write`.

    Attributes
    ----------
    kind : int
        Type of the C-kernel, 5 or 3.
    tolerance, rate_tolerance : float
        rad and rad/s.
    first : float
        Start of the clock, TDB seconds since J2000.
    begin, end : float
        The span, s on the clock.
    step : float
        Time between records, s.

    Raises
    ------
    AttitudeError
        For an unknown kind, tolerances out of range, and an empty span.
    """

    def __init__(
        self,
        motion: HasAttitudes,
        start: EpochOrSeconds,
        stop: EpochOrSeconds,
        kind: int,
        tolerance: float,
        rate_tolerance: float | None,
    ):
        if kind not in (3, 5):
            raise AttitudeError(f"kind is {kind!r}; CK is written in types 3 and 5, give one.")
        if not (isinstance(tolerance, (int, float)) and 1e-14 <= tolerance <= 1.0):
            raise AttitudeError(f"tolerance is {tolerance!r}; give a number of rad, 1e-14 to 1.")
        self._motion = motion_of(motion)
        self.kind: int = kind
        self.tolerance: float = float(tolerance)
        epoch = self._motion.epoch
        given = [epochs.seconds_since(epoch, value) for value in (start, stop)]
        for name, (hi, _) in zip(("start", "stop"), given, strict=True):
            if hi.shape != () or not np.isfinite(hi):
                raise AttitudeError(
                    f"{name} has shape {hi.shape}; give one epoch."
                    if hi.shape
                    else f"{name} is {hi}; give a finite epoch."
                )
        ends = [pairs.add((hi, 0.0), 0.0 if lo is None else lo) for hi, lo in given]
        # The clock starts at or before the start, at an epoch that is one double of TDB.
        first, rest = pairs.add(ends[0], epoch.seconds, epoch.low)
        self.first: float = float(first if rest >= 0.0 else np.nextafter(first, -np.inf))
        self._shift = pairs.add((self.first, 0.0), -epoch.seconds, -epoch.low)
        begin, end = (pairs.add(pair, -self._shift[0], -self._shift[1])[0] for pair in ends)
        self.begin: float = float(begin)
        self.end: float = float(end)
        if not self.end > self.begin:
            raise AttitudeError("stop is not after start; give a span of time.")
        probes = self.history(np.linspace(self.begin, self.end, _PROBES)).angular_velocity
        fastest = float(np.max(np.linalg.norm(probes, axis=1)))
        if rate_tolerance is None:
            rate_tolerance = self.tolerance * max(fastest, 1e-12)
        if not (isinstance(rate_tolerance, (int, float)) and rate_tolerance > 0.0):
            raise AttitudeError(f"rate_tolerance is {rate_tolerance!r}; give rad/s above zero.")
        self.rate_tolerance: float = float(rate_tolerance)
        self.step: float = self._first_step(fastest)

    def history(self, seconds: FloatArray) -> AttitudeHistory:
        """The motion at seconds on the clock, whose epochs are not rounded."""
        return self._motion.at(*pairs.add((seconds, 0.0), *self._shift))

    def records(self) -> FloatArray:
        """The times of all records, s on the clock: equal steps of at most `step` up to the end.

        Raises
        ------
        AttitudeError
            For more than 20 million records.
        """
        count = max(math.ceil((self.end - self.begin) / self.step) + 1, 2)
        if count > _MOST_RECORDS:
            raise AttitudeError(
                f"the tolerances need {count} records, more than {_MOST_RECORDS}; give larger "
                "ones, a shorter span, or type 5."
            )
        return np.linspace(self.begin, self.end, count)

    def _first_step(self, fastest):
        """A step at which the error between records is a quarter of the tolerances."""
        span = self.end - self.begin
        # SPICE interprets quaternions more than 90 deg apart as an error of sign.
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
        """Largest errors of attitude and rate, rad and rad/s, between records with this step."""
        width = 2 if self.kind == 3 else (DEGREE + 1) // 2
        window = (width - 1) * step
        span = self.end - self.begin
        first = self.begin + np.linspace(0.0, 1.0, _PROBES) * max(span - window, 0.0)
        place = np.arange(width) * step
        t = first[:, None] + place
        t = np.minimum(t, self.end) if window > span else t
        nodes = self.history(t)
        # In the middle itself the error of a steady rotation is one of the length only.
        middle = first + (0.5 * (width - 1) + _OFF_MIDDLE) * step
        middle = np.minimum(middle, self.end)
        true = self.history(middle)
        q = [nodes.wxyz[:, k] for k in range(width)]
        w = [nodes.angular_velocity_inertial[:, k] for k in range(width)]
        if self.kind == 3:
            turn = quaternion.multiply(quaternion.conjugate(q[0]), q[1])
            share = 0.5 + _OFF_MIDDLE
            part = forms.from_rotation_vector(share * forms.to_rotation_vector(turn))
            rates = w[0] + share * (w[1] - w[0])
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


def apart(p: FloatArray, q: FloatArray) -> float:
    """The largest angle, rad, between attitudes (N, 4)."""
    return float(
        np.max(forms.to_axis_angle(quaternion.multiply(quaternion.conjugate(p), q))[1], initial=0.0)
    )


def longest(vectors: FloatArray) -> float:
    """The largest length of vectors (N, 3)."""
    return float(np.max(np.linalg.norm(vectors, axis=-1), initial=0.0))
