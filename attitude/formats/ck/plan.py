"""The motion on the clock of a C-kernel, and the step between records.

At this step the error between records, measured at some places of the span, is a quarter of the
tolerances.  The span is divided into stretches where the angular velocity of the motion jumps:
records of one stretch hold the state of this stretch up to both its ends, and SPICE interpolates
within a stretch only.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from attitude import epochs, pairs, quaternion
from attitude import representations as forms
from attitude.attitude_table import interpolation
from attitude.epochs import time_scales
from attitude.errors import AttitudeError
from attitude.motion import motion_of

if TYPE_CHECKING:
    from attitude.annotations import EpochOrSeconds, FloatArray, IntArray
    from attitude.history import AttitudeHistory
    from attitude.motion import HasAttitudes

# Degree of the Hermite polynomials of type 5.
DEGREE: int = 7
_MOST_RECORDS = 20_000_000
# Places at which the error of interpolation is measured, and its ratio to the tolerances.
_PROBES, _MARGIN = 300, 0.25
# Distance of these places from the middle of a step, in steps.
_OFF_MIDDLE = 0.25
# Seconds to either side of an epoch between which the speed of a clock is measured.
_BESIDE = 100.0


class Plan:
    """The span of a kernel on its clock, the motion there, and the step between records.

    The clock counts seconds of TDB, or of TT, from `first`.

    Parameters
    ----------
    motion, start, stop, kind, tolerance, rate_tolerance
        As of `ck.write`.
    scale : str
        Time scale of the clock, "tdb" or "tt".

    Attributes
    ----------
    kind : int
        Type of the C-kernel, 5 or 3.
    tolerance, rate_tolerance : float
        rad and rad/s.
    first : float
        Start of the clock, seconds of its time scale since J2000.
    begin, end : float
        The span, s on the clock.
    bounds : (S + 1,) array
        `begin`, the jumps of the angular velocity in between, and `end`, s on the clock: stretch k
        runs from bounds[k] to bounds[k + 1].
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
        scale: str = "tdb",
    ):
        self._scale = scale
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
        # The clock starts at or before the start, at an epoch that is one double of its scale.
        first, rest = self._of_clock(*ends[0])
        self.first: float = float(first if rest >= 0.0 else np.nextafter(first, -np.inf))
        begin, end = (pairs.add(self._of_clock(*pair), -self.first)[0] for pair in ends)
        self.begin: float = float(begin)
        self.end: float = float(end)
        if not self.end > self.begin:
            raise AttitudeError("stop is not after start; give a span of time.")
        self._divide()
        probes = self.history(np.linspace(self.begin, self.end, _PROBES)).angular_velocity
        fastest = float(np.max(np.linalg.norm(probes, axis=1)))
        if rate_tolerance is None:
            rate_tolerance = self.tolerance * max(fastest, 1e-12)
        if not (isinstance(rate_tolerance, (int, float)) and rate_tolerance > 0.0):
            raise AttitudeError(f"rate_tolerance is {rate_tolerance!r}; give rad/s above zero.")
        self.rate_tolerance: float = float(rate_tolerance)
        self.step: float = self._first_step(fastest)

    def _of_clock(self, hi, lo):
        """Seconds of the clock's scale since J2000, hi and lo, of seconds of the motion."""
        epoch = self._motion.epoch
        pair = pairs.add((np.asarray(hi), np.asarray(lo)), epoch.seconds, epoch.low)
        return pair if self._scale == "tdb" else time_scales.tt_from_tdb(*pair)

    def _of_motion(self, seconds):
        """Seconds of the motion, hi and lo, of seconds on the clock."""
        hi, lo = pairs.add((seconds, np.zeros(seconds.shape)), self.first)
        if self._scale != "tdb":
            hi, lo = time_scales.tdb_from("tt", hi, lo)
        return pairs.add((hi, lo), -self._motion.epoch.seconds, -self._motion.epoch.low)

    def speed(self, seconds: FloatArray) -> FloatArray:
        """Seconds of TDB in a second of the clock, at seconds on the clock."""
        if self._scale == "tdb":
            return np.ones(np.shape(seconds))
        after, before = (self._of_motion(seconds + h) for h in (_BESIDE, -_BESIDE))
        found: FloatArray = ((after[0] - before[0]) + (after[1] - before[1])) / (2.0 * _BESIDE)
        return found

    def _divide(self):
        """Set `bounds`, and the first and last epoch of each stretch as the motion counts them."""
        breaks = self._motion.breaks()
        clock = pairs.add(self._of_clock(breaks[:, 0], breaks[:, 1]), -self.first)[0]
        inside = (clock > self.begin) & (clock < self.end)
        jumps = breaks[inside]
        self.bounds: FloatArray = np.concatenate([[self.begin], clock[inside], [self.end]])
        if np.any(np.diff(self.bounds) <= 0.0):
            raise AttitudeError(
                "the angular velocity of the motion jumps twice within the rounding of an epoch; "
                "a C-kernel cannot hold that."
            )
        before = np.stack([jumps[:, 0], np.nextafter(jumps[:, 1], -np.inf)], axis=1)
        far = [[np.inf, 0.0]]
        self._ends = np.concatenate([np.negative(far), jumps]), np.concatenate([before, far])

    def history(
        self, seconds: FloatArray, stretch: IntArray | int | None = None
    ) -> AttitudeHistory:
        """The motion at seconds on the clock, whose epochs are not rounded.

        Of the given stretches, broadcast against `seconds`, also at their ends; by default of those
        in which the seconds are.
        """
        if stretch is None:
            stretch = np.searchsorted(self.bounds[1:-1], seconds, side="right")
        hi, lo = self._of_motion(np.asarray(seconds))
        first, last = (np.broadcast_to(each[stretch], (*np.shape(hi), 2)) for each in self._ends)
        early = (hi < first[..., 0]) | ((hi == first[..., 0]) & (lo < first[..., 1]))
        late = (hi > last[..., 0]) | ((hi == last[..., 0]) & (lo > last[..., 1]))
        for outside, end in ((early, first), (late, last)):
            hi, lo = np.where(outside, end[..., 0], hi), np.where(outside, end[..., 1], lo)
        return self._motion.at(hi, lo)

    @property
    def _width(self):
        """Records from which SPICE interpolates."""
        return 2 if self.kind == 3 else (DEGREE + 1) // 2

    def records(self) -> list[FloatArray]:
        """The times of all records of each stretch, s on the clock: equal steps up to its ends.

        Raises
        ------
        AttitudeError
            For more than 20 million records.
        """
        lengths = np.diff(self.bounds)
        # A full window of interpolation in each stretch.
        least = 2 if len(lengths) == 1 else self._width
        counts = np.maximum(np.ceil(lengths / self.step).astype(int) + 1, least)
        if np.sum(counts) > _MOST_RECORDS:
            raise AttitudeError(
                f"the tolerances need {np.sum(counts)} records, more than {_MOST_RECORDS}; give "
                "larger ones, a shorter span, or type 5."
            )
        ends = zip(self.bounds[:-1], self.bounds[1:], counts, strict=True)
        return [np.linspace(begin, end, count) for begin, end, count in ends]

    def checks(self, count: int, random: np.random.Generator) -> FloatArray:
        """Epochs at which the finished kernel is compared: random ones, and some beside jumps."""
        jumps = self.bounds[1:-1]
        if len(jumps) > count:
            jumps = random.choice(jumps, count, replace=False)
        share = random.uniform(-1.0, 1.0, (4, len(jumps))) ** 3
        beside = np.ravel(jumps + share * 2.0 * self.step)
        return np.concatenate([random.uniform(self.begin, self.end, count), beside])

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
        width = self._width
        spread = self.begin + np.linspace(0.0, 1.0, _PROBES) * (self.end - self.begin)
        stretch = np.searchsorted(self.bounds[1:-1], spread, side="right")
        low, high = self.bounds[stretch], self.bounds[stretch + 1]
        # A window lies within the stretch in which it begins, or fills it.
        steps = np.minimum(step, (high - low) / (width - 1))
        first = np.maximum(np.minimum(spread, high - (width - 1) * steps), low)
        place = np.arange(width) * steps[:, None]
        nodes = self.history(first[:, None] + place, stretch[:, None])
        # In the middle itself the error of a steady rotation is one of the length only.
        middle = first + (0.5 * (width - 1) + _OFF_MIDDLE) * steps
        true = self.history(middle, stretch)
        q = [nodes.wxyz[:, k] for k in range(width)]
        w = [nodes.angular_velocity_inertial[:, k] for k in range(width)]
        if self.kind == 3:
            turn = quaternion.multiply(quaternion.conjugate(q[0]), q[1])
            share = 0.5 + _OFF_MIDDLE
            part = forms.from_rotation_vector(share * forms.to_rotation_vector(turn))
            rates = w[0] + share * (w[1] - w[0])
            found = quaternion.multiply(q[0], part), rates
        else:
            at = np.broadcast_to(np.arange(width), (len(first), width)).astype(float)
            x = (middle - first) / steps
            bends = quaternion.rotate(nodes.wxyz, nodes.angular_acceleration)
            speed = self.speed(first[:, None] + place)[..., None]
            bends = speed * bends
            change = speed * forms.quaternion_rate(nodes.wxyz, nodes.angular_velocity)
            slopes = [
                [part[:, k] * steps[:, None] for k in range(width)] for part in (change, bends)
            ]
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
