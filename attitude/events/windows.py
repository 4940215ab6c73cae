"""The intervals in which conditions hold, with their totals and gaps."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from attitude.conditions.condition import condition_of
from attitude.errors import AttitudeError
from attitude.events.discrete import span, stream
from attitude.events.search import difference
from attitude.events.timetable import Timetable, TimetableColumn
from attitude.paths.path import common_span

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from attitude.annotations import EpochOrSeconds, FloatArray
    from attitude.conditions.condition import Condition, Joinable
    from attitude.conditions.moments import Pair, Source
    from attitude.epochs import Instant


class Windows(Timetable):
    """The intervals in which a condition holds; made by `windows`.

    Attributes
    ----------
    begin, end : (N,) arrays
        TDB seconds since the epoch; those of the search where the condition holds at its ends.
    duration : (N,) array
        s.
    start, stop : pairs of doubles
        The span of the search, s.
    """

    start: Pair
    stop: Pair

    def __init__(
        self,
        epoch: Instant,
        columns: Mapping[str, TimetableColumn],
        start: Pair,
        stop: Pair,
    ) -> None:
        super().__init__(epoch, columns)
        self._set("start", start)
        self._set("stop", stop)

    def _with(self, columns: Mapping[str, TimetableColumn]) -> Windows:
        return Windows(self.epoch, columns, self.start, self.stop)

    @property
    def span(self) -> float:
        """Length of the search, s."""
        return difference(self.start, self.stop)

    @property
    def total(self) -> float:
        """Sum of the durations, s."""
        return float(np.sum(self.duration))

    @property
    def share(self) -> float:
        """The total over the length of the search; NaN for a search of no length."""
        return self.total / self.span if self.span > 0.0 else float("nan")

    @property
    def gaps(self) -> Windows:
        """The intervals of the search in which the condition does not hold."""
        begin, end = self.columns["begin"], self.columns["end"]
        edges = [_edge(self.start), _edges(end)], [_edges(begin), _edge(self.stop)]
        first, last = (np.concatenate(each, axis=1) for each in edges)
        length = (last[0] - first[0]) + (last[1] - first[1])
        return _of_edges(self.epoch, first[:, length > 0.0], last[:, length > 0.0], *self._ends())

    @property
    def worst_gap(self) -> float:
        """The longest gap, also before the first and after the last window, s; 0 without gaps."""
        return float(np.max(self.gaps.duration, initial=0.0))

    def _ends(self) -> tuple[Pair, Pair]:
        return self.start, self.stop


def windows(
    condition: Joinable, start: EpochOrSeconds | None = None, stop: EpochOrSeconds | None = None
) -> Windows:
    """The intervals of a span in which a condition holds.

    Parameters
    ----------
    condition : Condition
    start, stop : epochs or seconds, optional
        As in `find_discrete`; by default the span for which the motion and the path of the body
        are known.

    Returns
    -------
    Windows
        Windows that are open at the ends of the span begin or end there.

    Raises
    ------
    AttitudeError
        For other objects, and where no span is given and none follows.
    """
    known = condition_of(condition, "condition")
    ends = span_of(known.source, start, stop)
    return windows_of([known], *ends)[0]


def windows_of(conditions: Sequence[Condition], start: Pair, stop: Pair) -> list[Windows]:
    """The windows of each of several conditions of one source, searched together."""
    source = conditions[0].source
    first_epoch, last_epoch = (source.epoch.after(*each) for each in (start, stop))
    blocks = list(stream(first_epoch, last_epoch, list(conditions)))
    first = source.at(np.array([start[0]]), np.array([start[1]]))
    found = []
    for k, condition in enumerate(conditions):
        own = [part[part.which == k] for part in blocks]
        begins = [_edge(start)] if condition.states(condition.signs(first))[0] else []
        ends = []
        for part in own:
            pairs_of = np.stack([part.seconds, part.low])
            begins.append(pairs_of[:, part.values.astype(bool)])
            ends.append(pairs_of[:, ~part.values.astype(bool)])
        edges = [np.concatenate([np.zeros((2, 0)), *each], axis=1) for each in (begins, ends)]
        if edges[0].shape[1] > edges[1].shape[1]:
            edges[1] = np.concatenate([edges[1], _edge(stop)], axis=1)
        found.append(_of_edges(source.epoch, edges[0], edges[1], start, stop))
    return found


def span_of(
    source: Source, start: EpochOrSeconds | None, stop: EpochOrSeconds | None
) -> tuple[Pair, Pair]:
    """Start and stop as pairs of seconds since the epoch of a source.

    Raises
    ------
    AttitudeError
        For a span that is not given and does not follow, and as `discrete.span`.
    """
    if start is not None and stop is not None:
        return span(source.epoch, start, stop)
    center = None if source.scene is None else source.scene.center
    limited = [each for each in (source.motion, center) if each is not None and each.span]
    known = common_span(limited)
    if known is None:
        missing = "start" if start is None else "stop"
        raise AttitudeError(
            f"{missing} is not given, and neither motion nor path has an end from which it "
            'follows; give start and stop, such as "2026-01-01" and "2026-01-02".'
        )
    given = (known[0] if start is None else start), (known[1] if stop is None else stop)
    return span(source.epoch, *given)


def _edge(pair: Pair) -> FloatArray:
    """A pair as (2, 1)."""
    return np.array([[pair[0]], [pair[1]]])


def _edges(column: TimetableColumn) -> FloatArray:
    """A column of times as (2, N)."""
    return np.stack(np.broadcast_arrays(column.values, np.asarray(column.low, dtype=float)))


def _of_edges(
    epoch: Instant, begin: FloatArray, end: FloatArray, start: Pair, stop: Pair
) -> Windows:
    length = (end[0] - begin[0]) + (end[1] - begin[1])
    columns = {
        "begin": TimetableColumn(begin[0], "time", low=begin[1]),
        "end": TimetableColumn(end[0], "time", low=end[1]),
        "duration": TimetableColumn(length, "s"),
    }
    return Windows(epoch, columns, start, stop)
