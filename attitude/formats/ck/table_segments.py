"""The records of an AttitudeTable as they are, as segments of a C-kernel.

SPICE interpolates each stretch without gaps as the table does, from the same records: Hermite as
type 5, subtype 0; Lagrange as subtype 3 with angular velocities and 1 without; great circles as
type 3.  The degree is the greatest of SPICE's (4 n - 1 for Hermite, odd for Lagrange, at most 23)
that is not above that of the table.

Near the ends of a segment SPICE interpolates from fewer records, a table from the first or last
whole window.  Records beyond both ends, outside of the segment's span and on the polynomial of that
window, make SPICE's the same.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from attitude import pairs, quaternion
from attitude import representations as forms
from attitude.attitude_table import interpolation
from attitude.errors import AttitudeError
from attitude.formats.ck.kernel_files import REFERENCE, measured_at, opened
from attitude.formats.ck.plan import apart, longest

if TYPE_CHECKING:
    from attitude.annotations import FloatArray
    from attitude.attitude_table.table import AttitudeTable
    from attitude.formats.ck.clock import KernelClock

_MOST_DEGREE = 23
_CHECKS = 2000


class TableSegments:
    """The stretches of a table on the clock of a kernel, which counts TDB seconds from `first`.

    Parameters
    ----------
    table : AttitudeTable

    Attributes
    ----------
    first : float
        TDB seconds since J2000, before the first record.
    span : float
        s from there to the last record.
    step : float
        Greatest time between records of a stretch, s.
    """

    def __init__(self, table: AttitudeTable):
        self._parts = [part for part in table.segments]
        starts = [
            pairs.add((p.seconds[0], p.low[0]), p.epoch.seconds, p.epoch.low) for p in self._parts
        ]
        start = min(float(hi) for hi, _ in starts)
        steps = [np.max(np.diff(part.seconds), initial=0.0) for part in self._parts]
        # The clock counts from before the records beyond the ends, of which there are at most 11.
        margin = 12.0 * float(max(steps))
        self.first: float = float(np.nextafter(start - margin, -np.inf))
        self._clock = [self._seconds(part) for part in self._parts]
        ends = [float(seconds[-1]) for seconds in self._clock]
        if any(np.any(np.diff(seconds) <= 0.0) for seconds in self._clock):
            raise AttitudeError("two records of the table fall on one double of time.")
        self.span: float = max(ends)
        self.step: float = float(
            max(np.max(np.diff(seconds), initial=0.0) for seconds in self._clock)
        )

    def _seconds(self, part):
        """Seconds of a segment's records on the clock."""
        hi, lo = pairs.add((part.seconds, part.low), part.epoch.seconds, part.epoch.low)
        return pairs.add((hi, lo), -self.first)[0]

    def write(self, path: str, clock: KernelClock, instrument: int) -> None:
        """Write the C-kernel to a new file; AttitudeError for errors of SPICE."""
        with opened(path) as (spice, handle):
            for part, seconds in zip(self._parts, self._clock, strict=True):
                _write_part(spice, handle, part, clock.ticks(seconds), clock, instrument)

    def measured(self, path: str, clock: KernelClock, instrument: int) -> tuple[float, float]:
        """Largest deviations, rad and rad/s, of the kernel read by SPICE from the table."""
        random = np.random.default_rng(2006)
        worst = [0.0, 0.0]
        for part, seconds in zip(self._parts, self._clock, strict=True):
            some = np.sort(random.uniform(seconds[0], seconds[-1], _CHECKS // len(self._parts) + 2))
            ticks = clock.ticks(some)
            has_rates = part.angular_velocity is not None
            matrices, rates = measured_at(path, ticks, instrument, rates=has_rates)
            hi, lo = pairs.add((some, 0.0), self.first)
            own = pairs.add((hi, lo), -part.epoch.seconds, -part.epoch.low)
            true = part.at(own[0], own[1])
            worst[0] = max(worst[0], apart(forms.from_dcm(matrices), true.wxyz))
            if has_rates:
                worst[1] = max(worst[1], longest(rates - true.angular_velocity_inertial))
        return worst[0], worst[1]


def _degree(table: AttitudeTable) -> int:
    """The degree of SPICE's polynomials for those of a table."""
    if table.method == "hermite":
        return max(3, min((table.degree + 1) // 4 * 4 - 1, _MOST_DEGREE))
    return min(table.degree - (table.degree + 1) % 2, _MOST_DEGREE)


def _write_part(
    spice: Any,
    handle: int,
    part: AttitudeTable,
    ticks: FloatArray,
    clock: KernelClock,
    instrument: int,
) -> None:
    has_rates = part.angular_velocity is not None
    quats = np.ascontiguousarray(quaternion.conjugate(part.nodes))
    ends = float(ticks[0]), float(ticks[-1])
    about = (instrument, REFERENCE, has_rates, "attitude")
    if part.method == "slerp":
        rates = np.zeros((len(ticks), 3))
        if has_rates:
            rates = np.ascontiguousarray(_inertial(part))
        spice.ckw03(handle, *ends, *about, len(ticks), ticks, quats, rates, 1, ticks[:1])
        return
    degree = _degree(part)
    if part.method == "hermite":
        assert part.angular_velocity is not None
        change = forms.quaternion_rate(part.nodes, part.angular_velocity)
        slopes = quaternion.conjugate(change) * clock.per_tick
        ticks, quats, slopes = _padded(ticks, quats, slopes, (degree + 1) // 2)
        subtype, packets = 0, np.concatenate([quats, slopes / clock.per_tick], axis=1)
    else:
        packets = quats
        if has_rates:
            packets = np.concatenate([quats, _inertial(part)], axis=1)
        subtype = 3 if has_rates else 1
        ticks, packets, _ = _padded(ticks, packets, None, degree + 1)
    spice.ckw05(
        *(handle, subtype, degree, *ends, *about, ticks, np.ascontiguousarray(packets)),
        *(clock.per_tick, 1, ticks[:1]),
    )


def _inertial(part: AttitudeTable) -> FloatArray:
    """Angular velocities (N, 3) over ICRF axes."""
    assert part.angular_velocity is not None
    return quaternion.rotate(part.nodes, part.angular_velocity)


def _padded(ticks, values, slopes, width):
    """Records with some beyond both ends, on the polynomials of the first and the last window.

    `slopes` are the derivatives by ticks of `values`, or None.
    """
    count = width // 2 - 1
    if count < 1 or len(ticks) < width:
        return ticks, values, slopes
    scale = float(ticks[width - 1] - ticks[0])
    found = [(ticks, values, slopes)]
    for window, end, beyond in (
        (slice(0, width), 0, -np.arange(count, 0, -1)),
        (slice(len(ticks) - width, None), -1, np.arange(1, count + 1)),
    ):
        step = abs(ticks[end] - ticks[1 if end == 0 else -2])
        x = beyond * step / scale
        at = np.broadcast_to((ticks[window] - ticks[end]) / scale, (count, width))
        rows = [np.broadcast_to(v, (count, values.shape[1])) for v in values[window]]
        bends = None
        if slopes is not None:
            bends = [np.broadcast_to(v * scale, (count, 4)) for v in slopes[window]]
        p, dp = interpolation.with_slope(at, rows, bends, x)
        more = ticks[end] + beyond * step, p, None if slopes is None else dp / scale
        found.insert(0 if end == 0 else 2, more)
    return tuple(
        None if parts[0] is None else np.concatenate(parts) for parts in zip(*found, strict=True)
    )
