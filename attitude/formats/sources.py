"""The arguments of writers as segments: histories, tables, or a motion with epochs.

Motions are evaluated piece by piece, so that long files need little memory.  Where the angular
velocity of a motion jumps, a segment ends with the state before and the next begins with the state
after: readers interpolate within segments.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, TypeAlias, cast

import numpy as np

from attitude import epochs, pairs
from attitude.attitude_table.table import AttitudeTable
from attitude.catalog import motion_of
from attitude.errors import AttitudeError
from attitude.history import AttitudeHistory
from attitude.motion import Motion

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from attitude.annotations import Epochs, FloatArray
    from attitude.motion import HasAttitudes

    # The argument `source` of writers; see `segments`.
    AttitudeSource: TypeAlias = "HasAttitudes | AttitudeHistory | Records | Sequence[_Segment]"
    _Segment: TypeAlias = "AttitudeHistory | AttitudeTable | Records"

# Records that are evaluated and written at a time.
PIECE: int = 16384
# Seconds from a break within which the state at the break replaces a record.
_APART = 1e-9


def only_segment(source: AttitudeSource, t: Epochs | None, holder: str) -> Records:
    """The one segment of what a writer was given; see `segments`.

    `holder` is the kind of file in the error message.

    Raises
    ------
    AttitudeError
        For several segments, and as `segments`.
    """
    parts = segments(source, t)
    if any(part.after_break for part in parts):
        listed = ", ".join(f"{part.seconds[0]:.9g}" for part in parts if part.after_break)
        raise AttitudeError(
            f"the angular velocity of the motion jumps at {listed[:60]} s after "
            f"{parts[0].epoch.utc_iso} UTC, across which readers would interpolate; {holder} holds "
            "one segment. Write a file for each stretch, or an AEM, ECSV, FITS or parquet file."
        )
    if len(parts) != 1:
        raise AttitudeError(
            f"{len(parts)} segments are given; {holder} holds one. Write a file for each, or an "
            "AEM, ECSV or FITS."
        )
    return parts[0]


def known_of(source: AttitudeSource, t: Epochs | None) -> tuple[dict[str, Any], bool]:
    """Names and comments of what a writer was given, and whether it has angular velocities.

    Of a motion without epochs too, for writers that choose the epochs themselves.

    Raises
    ------
    AttitudeError
        As `segments`.
    """
    of_records = (Records, AttitudeHistory, AttitudeTable, list, tuple)
    if t is None and not isinstance(source, of_records) and callable(getattr(source, "at", None)):
        return dict(motion_of(cast("HasAttitudes", source), "source").meta), True
    parts = segments(source, t)
    return dict(parts[0].meta), all(part.has_rates for part in parts)


def one_motion(source: AttitudeSource) -> Motion:
    """The motion that a writer was given to write to a tolerance.

    Raises
    ------
    AttitudeError
        For records at epochs, which have no attitudes in between.
    """
    if isinstance(source, (Records, AttitudeHistory, list, tuple)):
        raise AttitudeError(
            f"{type(source).__name__} is given with tolerance=; give the motion or the "
            "AttitudeTable, with start= and stop=."
        )
    return motion_of(cast("HasAttitudes", source), "source")


def refuse_epochs(t: object) -> None:
    """AttitudeError for epochs of records beside a tolerance."""
    if t is not None:
        raise AttitudeError(
            "t and tolerance are given; the epochs of records follow from the tolerance: give one "
            "of both."
        )


def refuse_span(start: object, stop: object) -> None:
    """AttitudeError for a span without a tolerance."""
    if start is not None or stop is not None:
        raise AttitudeError(
            "start or stop is given without tolerance=; give tolerance=, or the epochs t=."
        )


def refuse_breaks(motion: object, holder: str) -> None:
    """Raise the AttitudeError for a motion whose angular velocity jumps.

    `holder` is the kind of file in the error message, which holds the state at one epoch.
    """
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

    Parameters
    ----------
    motion : Motion
    epoch : Instant
    seconds, low : (N,) arrays
        seconds + low are TDB seconds since the epoch, increasing; low may be None.
    history : AttitudeHistory, optional
        The attitudes at these epochs, if they are known; otherwise the motion is evaluated.

    Attributes
    ----------
    motion, epoch, seconds, low
        As given.
    has_rates : bool
        Whether the motion knows angular velocities better than from differences of attitudes.
    meta : dict
        Names, comments and keywords of the file that the motion was read from.
    table : AttitudeTable or None
        The motion, if it is a table.
    after_break : bool
        Whether the segment begins where the angular velocity jumps.

    Raises
    ------
    AttitudeError
        If there are no epochs, or some are NaN or do not increase.
    """

    def __init__(
        self,
        motion: Motion,
        epoch: epochs.Instant,
        seconds: FloatArray,
        low: FloatArray | None,
        history: AttitudeHistory | None = None,
    ):
        self.motion: Motion = motion
        self.epoch: epochs.Instant = epoch
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
        steps = np.diff(seconds) if low is None else np.diff(seconds) + np.diff(low)
        if np.any(steps <= 0.0):
            k = int(np.flatnonzero(steps <= 0.0)[0])
            raise AttitudeError(
                f"epoch {k + 1} is not later than the one before it; files of attitudes hold "
                "increasing epochs, each once."
            )
        self.has_rates: bool = motion.has_rates_at(seconds[:1], None if low is None else low[:1])

    def __len__(self) -> int:
        return len(self.seconds)

    def first_and_last(self) -> tuple[FloatArray, FloatArray]:
        """`seconds` and `low` of the first and the last record, as arrays (2,)."""
        low = np.zeros(len(self.seconds)) if self.low is None else self.low
        return self.seconds[[0, -1]], low[[0, -1]]

    def pieces(self) -> Iterator[AttitudeHistory]:
        """The records in order, as histories of at most PIECE epochs."""
        for start in range(0, len(self), PIECE):
            part = slice(start, start + PIECE)
            if self._history is not None:
                yield self._history[part]
            else:
                low = None if self.low is None else self.low[part]
                yield self.motion.at(self.seconds[part], low)


def segments(source: AttitudeSource, t: Epochs | None = None) -> list[Records]:
    """The segments, as `Records`, of what a writer was given, cut at the breaks of motions.

    Parameters
    ----------
    source : AttitudeHistory, AttitudeTable, Records, a list of them (several segments), or with `t`
        anything that has ``.at(t)``
    t : epochs, optional
        Epochs of the records, of any kind that ``.at(t)`` takes; (N,).

    Raises
    ------
    AttitudeError
        For other types, epochs that are not a row (N,), and as `Records`.
    """
    if isinstance(source, Records):
        return _cut(source)
    if t is not None:
        return _cut(_of_motion(source, t))
    if isinstance(source, (list, tuple)):
        return [each for part in source for each in segments(part)]
    if isinstance(source, AttitudeTable):
        return [_of_history(part.history) for part in source.segments]
    if isinstance(source, AttitudeHistory):
        return _cut(_of_history(source))
    raise AttitudeError(
        f"{type(source).__name__} is given to be written; give an AttitudeHistory, an "
        "AttitudeTable, a list of them, or a motion and its epochs (t=)."
    )


def _of_history(history):
    if len(history.shape) != 1:
        raise AttitudeError(f"the epochs have shape {history.shape}; give a row of epochs, (N,).")
    return Records(motion_of(history.motion), history.epoch, history.seconds, history.low, history)


def _of_motion(motion, t):
    motion = motion_of(motion, "source")
    seconds, low = epochs.seconds_since(motion.epoch, t)
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
    low = np.zeros(len(records)) if records.low is None else records.low
    seconds, low = pairs.add((records.seconds, low), *shift)
    first = (breaks[:, 0] - seconds[0]) + (breaks[:, 1] - low[0])
    last = (seconds[-1] - breaks[:, 0]) + (low[-1] - breaks[:, 1])
    inside = breaks[(first > 0.0) & (last >= 0.0)]
    if not len(inside):
        return [records]
    parts: list[Records] = []
    for k in range(len(inside) + 1):
        free = np.ones(len(records), dtype=bool)
        ends: list[list[tuple[float, float]]] = [[], []]
        if k > 0:
            hi, lo = inside[k - 1]
            free &= (seconds - hi) + (low - lo) > _APART
            ends[0] = [(hi, lo)]
        if k < len(inside):
            hi, lo = inside[k]
            free &= (seconds - hi) + (low - lo) < -_APART
            ends[1] = [(hi, np.nextafter(lo, -np.inf))]
        both = np.array([*ends[0], *zip(seconds[free], low[free], strict=True), *ends[1]])
        # A break at the last record leaves nothing behind it.
        if k < len(inside) or len(both) > 1:
            part = Records(motion, motion.epoch, both[:, 0].copy(), both[:, 1].copy())
            part.meta, part.after_break = dict(records.meta), k > 0
            parts.append(part)
    return parts
