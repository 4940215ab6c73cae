"""A motion written as records to a tolerance: steps, stretches, and the error of the finished file.

The step follows from the interpolation that the file states: attitudes between records of short
trial tables are compared with the motion.  The file is then written, read by the reader of its
format, and compared at random epochs and beside the ends of its stretches; the step is halved until
the error is within the tolerance.  Stretches end where the angular velocity of the motion jumps
and, for a table, at its gaps: no reader interpolates across.
"""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple, TypeAlias

import numpy as np

from attitude._support import pairs
from attitude._support.pairs import Seconds
from attitude._support.validation import shown
from attitude._textfiles.atomic_write import made_whole
from attitude.epochs import _inputs
from attitude.errors import AttitudeError, AttitudeWarning
from attitude.frames import quaternion
from attitude.frames import representations as forms
from attitude.motions import _table
from attitude.motions._history import AttitudeHistory
from attitude.motions._motion import Motion
from attitude.motions._table import AttitudeTable
from attitude.paths._tabulated import MOST_DEGREE

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Sequence

    from attitude._support.annotations import EpochOrSeconds, Epochs, FilePath, FloatArray
    from attitude.epochs import _instants
    from attitude.motions._motion import HasAttitudes

    AttitudeSource: TypeAlias = (
        "HasAttitudes | str | AttitudeHistory | Records | Sequence[_Segment]"
    )
    _Segment: TypeAlias = "AttitudeHistory | AttitudeTable | Records"


# ---- The arguments of writers as segments: histories, tables, or a motion with epochs
# Motions are evaluated piece by piece, so that long files need little memory.  Where the angular
# velocity of a motion jumps, a segment ends with the state before and the next begins with the
# state after: readers interpolate within segments.

# Records that are evaluated and written at a time.
PIECE: int = 16384
# Seconds from a break within which the state at the break replaces a record.
_APART = 1e-9


def _only(source, t, holder):
    """The one segment of what a writer was given; `holder` is the kind of file in sentences."""
    parts = segments(source, t)
    jumps = ", ".join(f"{records.seconds[0]:.9g}" for records in parts if records.after_break)
    if jumps:
        raise AttitudeError(
            f"the angular velocity of the motion jumps at {jumps[:60]} s after "
            f"{parts[0].epoch.utc_iso} UTC, across which readers would interpolate; {holder} holds "
            "one segment. Write a file for each stretch, or an AEM, ECSV, FITS or parquet file."
        )
    if len(parts) != 1:
        raise AttitudeError(
            f"{len(parts)} segments are given; {holder} holds one. Write a file for each, or an "
            "AEM, ECSV or FITS."
        )
    warn_of_usable(parts, holder)
    return parts[0]


def warn_of_usable(parts: Sequence[Records], holder: str) -> None:
    """Warn that a kind of file holds all records of tables that have attitudes in fewer."""
    if any(records.usable for records in parts):
        warnings.warn(
            f"{holder} has no place for the usable span of a table: readers interpolate up to its "
            "first and last record. AEM, ECSV, FITS and parquet files have one.",
            AttitudeWarning,
            stacklevel=3,
        )


def _motion_of(source, name="source"):
    """A motion itself, or that of an entry of the catalogue, which is loaded late, by its name."""
    from attitude.catalog import motion_of

    return motion_of(source, name)


def known_of(source: AttitudeSource, t: Epochs | None) -> tuple[dict[str, Any], bool]:
    """Names and comments of what a writer was given, and whether it has angular velocities."""
    of_records = (Records, AttitudeHistory, AttitudeTable, list, tuple)
    is_motion = isinstance(source, str) or callable(getattr(source, "at", None))
    if t is None and is_motion and not isinstance(source, of_records):
        return dict(_motion_of(source).meta), True
    parts = segments(source, t)
    return dict(parts[0].meta), all(records.has_rates for records in parts)


def refuse_breaks(motion: object, holder: str) -> None:
    """AttitudeError for what has no spin, and jumps of its rate; `holder` holds one state."""
    if not hasattr(motion, "spin"):
        raise AttitudeError(
            f"motion is {shown(motion)}; {holder} holds the state of a FreeRotation. Give one."
        )
    if isinstance(motion, Motion) and len(motion.breaks()):
        count = len(motion.breaks())
        raise AttitudeError(
            f"the motion has {count} jump{'s' if count > 1 else ''} of the angular velocity, the "
            f"first {motion.breaks()[0, 0]:.9g} s after its epoch, of which {holder} would hold "
            "nothing: it is the state of a free rotation at one epoch. Write a FreeRotation of the "
            "stretch that matters, or attitudes at epochs (AEM, C-kernel, ECSV, FITS, parquet)."
        )


class Records:
    """One segment to be written: a motion and its epochs, evaluated piece by piece.

    seconds + low (N,) are TDB seconds since the epoch; `history` has the attitudes, if known.
    """

    def __init__(
        self,
        motion: Motion,
        epoch: _instants.Instant,
        seconds: FloatArray,
        low: FloatArray | None,
        history: AttitudeHistory | None = None,
    ):
        self.motion: Motion = motion
        self.epoch: _instants.Instant = epoch
        self.seconds: FloatArray = seconds
        self.low: FloatArray | None = low
        self._history = history
        self.after_break: bool = False
        self.meta: dict[str, Any] = dict(motion.meta)
        self.table: AttitudeTable | None = motion if isinstance(motion, AttitudeTable) else None
        if len(seconds) == 0:
            raise AttitudeError("there are no epochs to write; give one or more.")
        if not np.all(np.isfinite(seconds)):
            raise AttitudeError("some epochs are NaN, which files cannot hold; leave them out.")
        steps = np.diff(seconds) + (0.0 if low is None else np.diff(low))
        if np.any(steps <= 0.0):
            k = int(np.flatnonzero(steps <= 0.0)[0])
            raise AttitudeError(
                f"epoch {k + 1} is not later than the one before it; files of attitudes hold "
                "increasing epochs, each once."
            )
        self.has_rates: bool = motion.has_rates_at(*Seconds(seconds, low).taken(slice(1)))

    def __len__(self) -> int:
        return len(self.seconds)

    def first_and_last(self) -> tuple[FloatArray, FloatArray]:
        """`seconds` and `low` of the first and the last record, as arrays (2,)."""
        return self.seconds[[0, -1]], Seconds.of(self).low[[0, -1]]

    @property
    def usable(self) -> _table.Limits | None:
        """First and last epoch, hi and lo, of a table, if its records go beyond them."""
        if self.table is None or self.table._limits is None:
            return None
        hi, lo = self.first_and_last()
        first, last = zip(hi.tolist(), lo.tolist(), strict=True)
        limits = max(self.table._limits[0], first), min(self.table._limits[1], last)
        return None if limits == (first, last) else limits

    def pieces(self) -> Iterator[AttitudeHistory]:
        """The records in order, as histories of at most PIECE epochs."""
        for start in range(0, len(self), PIECE):
            piece = slice(start, start + PIECE)
            if self._history is not None:
                yield self._history[piece]
            else:
                yield self.motion.at(*Seconds.of(self).taken(piece))


def segments(source: AttitudeSource, t: Epochs | None = None) -> list[Records]:
    """The segments, as `Records`, of what a writer was given, cut at the breaks of motions."""
    if isinstance(source, Records):
        return _cut(source)
    if t is not None:
        return _cut(_of_motion(source, t))
    if isinstance(source, (list, tuple)):
        if not source:
            raise AttitudeError("no segments are given; give one or more.")
        return [records for item in source for records in segments(item)]
    if isinstance(source, AttitudeTable):
        return [_of_history(item.history) for item in source.segments]
    if isinstance(source, AttitudeHistory):
        return _cut(_of_history(source))
    raise AttitudeError(
        f"{type(source).__name__} is given to be written; give an AttitudeHistory, an "
        "AttitudeTable, a list of them, or a motion and its epochs (t=)."
    )


def _of_history(history):
    if len(history.shape) != 1:
        raise AttitudeError(f"the epochs have shape {history.shape}; give a row of epochs, (N,).")
    return Records(
        _motion_of(history.motion, "motion"), history.epoch, history.seconds, history.low, history
    )


def _of_motion(motion, t):
    motion = _motion_of(motion)
    seconds, low = _inputs.seconds_since(motion.epoch, t)
    if seconds.ndim != 1:
        raise AttitudeError(f"t has shape {seconds.shape}; give a row of epochs, (N,).")
    return Records(motion, motion.epoch, seconds, low)


def _cut(records: Records) -> list[Records]:
    """The records in one segment for each stretch between breaks, with both states at a break."""
    motion, epoch = records.motion, records.epoch
    breaks = motion.breaks()
    if not len(breaks):
        return [records]
    shift = epoch.seconds - motion.epoch.seconds, epoch.low - motion.epoch.low
    seconds, low = Seconds.of(records).plus(*shift)
    first = (breaks[:, 0] - seconds[0]) + (breaks[:, 1] - low[0])
    last = (seconds[-1] - breaks[:, 0]) + (low[-1] - breaks[:, 1])
    inside = breaks[(first > 0.0) & (last >= 0.0)]
    if not len(inside):
        return [records]
    parts: list[Records] = []
    for k in range(len(inside) + 1):
        # The break at which the segment begins, and that at which it ends, if there are.
        begin, end = inside[max(k - 1, 0) : k], inside[k : k + 1].copy()
        free = np.ones(len(records), dtype=bool)
        for hi, lo in begin:
            free &= (seconds - hi) + (low - lo) > _APART
        for hi, lo in end:
            free &= (seconds - hi) + (low - lo) < -_APART
        end[:, 1] = np.nextafter(end[:, 1], -np.inf)
        both = np.concatenate([begin, np.stack([seconds[free], low[free]], axis=1), end])
        # A break at the last record leaves nothing behind it.
        if k < len(inside) or len(both) > 1:
            segment = Records(motion, motion.epoch, both[:, 0].copy(), both[:, 1].copy())
            segment.meta, segment.after_break = dict(records.meta), k > 0
            parts.append(segment)
    return parts


# Records of a file that a tolerance may ask for.
MOST_RECORDS = 20_000_000
# Error of the first step, in tolerances.
_MARGIN = 0.25
# A file of a greater error than the tolerance is repeated with half the step, so many times.
_REPEATED = 5
# Trial tables over the span,
_TRIALS = 12
# records of each,
_LENGTH = 24
# and epochs between two records.
_BETWEEN = 3
# Random epochs at which the finished file is compared,
_CHECKS = 2000
# and epochs beside the ends of stretches.
_BESIDE = 8
# Least and greatest tolerance, rad.
_LEAST = 1e-14
_GREATEST = 1.0


@dataclass(frozen=True)
class SampledFile:
    """How a motion was written to a tolerance: greatest step, s, and largest error, rad."""

    records: int
    segments: int
    step: float
    error: float

    def __str__(self) -> str:
        return (
            f"{self.records} records at most {self.step:.4g} s apart in {self.segments} "
            f"segment{'s' if self.segments > 1 else ''}: error {self.error:.2g} rad"
        )


class _Stretch:
    """A part of the motion without jumps: its ends, as seconds of the motion in two doubles."""

    def __init__(self, motion, begin, end):
        self.motion, self.begin, self.end = motion, begin, end
        self.length = float((end[0] - begin[0]) + (end[1] - begin[1]))

    def at(self, offsets):
        """Seconds of the motion, hi and lo, at offsets from the begin; the ends are exact."""
        hi, lo = pairs.add(self.begin, np.asarray(offsets, dtype=np.float64))
        last = offsets >= self.length
        return np.where(last, self.end[0], hi), np.where(last, self.end[1], lo)

    def records(self, step, least):
        count = max(int(np.ceil(self.length / step * (1.0 - 1e-12))) + 1, least)
        hi, lo = self.at(np.linspace(0.0, self.length, count))
        return Records(self.motion, self.motion.epoch, hi, lo)


class Writing(NamedTuple):
    """How a format writes records, and reads a file, which interpolates by a method and degree.

    `name` is the file in errors; `holder` is its kind, where that holds one segment only.
    """

    stated: tuple[str, int]
    write: Callable[[FilePath, list[Records]], None]
    read: Callable[[FilePath], AttitudeTable]
    name: str
    holder: str | None = None


def write(
    path: FilePath,
    source: AttitudeSource,
    t: Epochs | None,
    span: Sequence[EpochOrSeconds | None],
    tolerance: float | None,
    writing: Writing,
) -> SampledFile | None:
    """Write the records at `t`, or a motion over `span` (start, stop) to a tolerance, rad."""
    if tolerance is not None:
        if t is not None:
            raise AttitudeError(
                "t and tolerance are given; the epochs of records follow from the tolerance: give "
                "one of both."
            )
        return sampled(path, source, span, tolerance, writing)
    if span[0] is not None or span[1] is not None:
        raise AttitudeError(
            "start or stop is given without tolerance=; give tolerance=, or the epochs t=."
        )
    holder = writing.holder
    records = segments(source, t) if holder is None else [_only(source, t, holder)]
    writing.write(path, records)
    return None


def sampled(
    path: FilePath,
    source: AttitudeSource,
    span: Sequence[EpochOrSeconds | None],
    tolerance: float,
    writing: Writing,
    stretch: int | None = None,
) -> SampledFile:
    """As `write`; of all stretches, or of the one with a number, counted from 0."""
    known_angle(tolerance)
    stretches = stretches_of(source, span)
    if stretch is not None:
        stretches = stretches[stretch : stretch + 1]
    if writing.holder is not None and len(stretches) > 1:
        raise AttitudeError(
            f"the angular velocity of the motion jumps, or the table has a gap, "
            f"{stretches[1].begin[0]:.9g} s after its epoch, and {writing.name} holds one segment; "
            "write a file for each stretch (start=, stop=; of STK also split=True)."
        )
    step = _first_step(stretches, tolerance, *writing.stated)
    with made_whole(path, writing.name) as temporary:
        for _ in range(_REPEATED):
            count = sum(piece.length / step for piece in stretches)
            if count > MOST_RECORDS:
                raise AttitudeError(
                    f"the tolerance needs {count:.3g} records, more than {MOST_RECORDS}; give a "
                    "larger one, a shorter span, or another method or degree of interpolation."
                )
            records = [piece.records(step, _window(*writing.stated)) for piece in stretches]
            writing.write(temporary, records)
            error = _measured(stretches, writing.read(temporary), step)
            if error <= tolerance:
                break
            step *= 0.5
        else:
            raise AttitudeError(
                f"{writing.name} deviates by {error:.2g} rad from the motion at steps of "
                f"{2 * step:.3g} s, more than the tolerance {tolerance:g}; give a larger one, "
                "or another method or degree of interpolation."
            )
    longest = float(max(np.max(np.diff(segment.seconds), initial=0.0) for segment in records))
    return SampledFile(sum(map(len, records)), len(records), longest, error)


def known_angle(tolerance: float) -> float:
    """The tolerance of attitudes itself; AttitudeError if it is no angle from 1e-14 to 1 rad."""
    number = isinstance(tolerance, (int, float)) and not isinstance(tolerance, bool)
    if not (number and _LEAST <= tolerance <= _GREATEST):
        raise AttitudeError(f"tolerance is {tolerance!r}; give a number of rad, 1e-14 to 1.")
    return float(tolerance)


def _window(method, degree):
    """Records from which the method interpolates."""
    if method == "slerp":
        return 2
    return (degree + 1) // 2 if method == "hermite" else degree + 1


def stretches_of(source: AttitudeSource, span: Sequence[EpochOrSeconds | None]) -> list[_Stretch]:
    """The stretches without jumps and gaps of a motion, by default over the span of a table."""
    if isinstance(source, (Records, AttitudeHistory, list, tuple)):
        raise AttitudeError(
            f"{type(source).__name__} is given with tolerance=; give the motion or the "
            "AttitudeTable, with start= and stop=."
        )
    motion = _motion_of(source)
    ends = []
    for which, value, end in zip(("start", "stop"), span, motion.span or (None, None), strict=True):
        value = end if value is None else value
        if value is None:
            raise AttitudeError(
                f"{which} is not given; a motion is written to a tolerance from start= to stop=, "
                "one epoch each."
            )
        ends.append(_inputs.one_since(motion.epoch, value, which))
    if isinstance(motion, AttitudeTable):
        stretches = [
            _Stretch(segment, max(ends[0], segment._limits[0]), min(ends[1], segment._limits[1]))
            for segment in (segment._counted_from(motion.epoch) for segment in motion.segments)
        ]
    else:
        stretches = _between_breaks(motion, *ends)
    stretches = [stretch for stretch in stretches if stretch.length > 0.0]
    if not stretches:
        raise AttitudeError("stop is not after start; give a span of time.")
    return stretches


def _between_breaks(motion, begin, end):
    breaks = motion.breaks()
    after = (breaks[:, 0] - begin[0]) + (breaks[:, 1] - begin[1]) > 0.0
    before = (end[0] - breaks[:, 0]) + (end[1] - breaks[:, 1]) > 0.0
    inside = [(float(hi), float(lo)) for hi, lo in breaks[after & before]]
    # A stretch ends with the state before a jump, and the next begins with that after it.
    until = [(hi, float(np.nextafter(lo, -np.inf))) for hi, lo in inside]
    starts, stops = [begin, *inside], [*until, end]
    return [_Stretch(motion, *ends) for ends in zip(starts, stops, strict=True)]


def _first_step(stretches, tolerance, method, degree):
    """A step at which the error of trial tables is a quarter of the tolerance."""
    total = sum(piece.length for piece in stretches)
    longest = max(piece.length for piece in stretches)
    probes = [piece.motion.at(*piece.at(np.linspace(0.0, piece.length, 60))) for piece in stretches]
    fastest = max(longest_of(probe.angular_velocity) for probe in probes)
    most = min(longest, 0.8 / fastest) if fastest > 0.0 else longest
    order = 2.0 if method == "slerp" else degree + 1.0
    step = most
    for _ in range(8):
        error = max(_trial(piece, step, total, method, degree) for piece in stretches)
        factor = (_MARGIN * tolerance / max(error, 1e-300)) ** (1.0 / order)
        first = min(step * min(factor, 4.0), most)
        if abs(first - step) <= 0.02 * step:
            break
        step = first
    return first


def longest_of(vectors: FloatArray) -> float:
    """The largest length of vectors (N, 3)."""
    return float(np.max(np.linalg.norm(vectors, axis=-1), initial=0.0))


def _trial(stretch, step, total, method, degree):
    """Largest error between the records of some short tables of a stretch."""
    length = (_LENGTH - 1) * step
    if length >= stretch.length:
        count = max(int(np.ceil(stretch.length / step)) + 1, _window(method, degree), 2)
        places = [np.linspace(0.0, stretch.length, count)]
    else:
        count = max(2, int(np.ceil(_TRIALS * stretch.length / total)))
        firsts = np.linspace(0.0, stretch.length - length, count)
        places = [first + step * np.arange(_LENGTH) for first in firsts]
    worst = 0.0
    for place in places:
        nodes = stretch.motion.at(*stretch.at(place))
        table = AttitudeTable.from_history(
            nodes, rates=method == "hermite", method=method, degree=degree
        )
        share = (np.arange(_BETWEEN) + 1.0) / (_BETWEEN + 1.0)
        between = (place[:-1, None] + share * np.diff(place)[:, None]).ravel()
        hi, lo = stretch.at(between)
        worst = max(worst, apart(table.at(hi, lo).wxyz, stretch.motion.at(hi, lo).wxyz))
    return worst


def _measured(stretches: list[_Stretch], table: AttitudeTable, step: float) -> float:
    """Largest angle between a motion and the file read back, at random epochs and beside ends."""
    random = np.random.default_rng(2006)
    total, worst = sum(piece.length for piece in stretches), 0.0
    start = stretches[0].motion.epoch
    for number, piece in enumerate(stretches):
        count = int(np.ceil(_CHECKS * piece.length / total))
        beside = np.minimum(random.uniform(0.0, 2.0, (2, _BESIDE)) * step, piece.length)
        offsets = np.concatenate(
            [random.uniform(0.0, piece.length, count), beside[0], piece.length - beside[1]]
        )
        hi, lo = piece.at(np.sort(offsets))
        segment: AttitudeTable = table.segments[number]
        shift = pairs.add((start.seconds, start.low), -segment.epoch.seconds, -segment.epoch.low)
        since_segment = pairs.add((hi, lo), *shift)
        inside = segment._covers(*since_segment)
        wxyz = segment.at(since_segment[0][inside], since_segment[1][inside]).wxyz
        worst = max(worst, apart(wxyz, piece.motion.at(hi[inside], lo[inside]).wxyz))
    return worst


def apart(p: FloatArray, q: FloatArray) -> float:
    """The largest angle, rad, between attitudes (N, 4)."""
    turn = quaternion.multiply(quaternion.conjugate(p), q)
    return float(np.max(forms.to_axis_angle(turn)[1], initial=0.0))


def stated(
    method: str | None, degree: int | None, has_rates: bool, source: object = None
) -> tuple[str, int]:
    """Method and degree that a file will state, by default a table's; see `_table.settled`."""
    if method is None and isinstance(source, AttitudeTable):
        method, degree = source.method, degree or source.degree
    return _table.settled(method, degree, MOST_DEGREE + 1, has_rates)
