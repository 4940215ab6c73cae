"""How far a search in time is, as a bar on a terminal."""

from __future__ import annotations

from typing import TYPE_CHECKING

from attitude.progress import ProgressBar

if TYPE_CHECKING:
    from attitude.conditions.moments import Pair


class Advance:
    """The progress of a search that goes through its span once or several times.

    Parameters
    ----------
    start, stop : pairs of doubles
        s; a bar does not need the low parts.
    rounds : int
        How often the search goes through the span.
    """

    def __init__(self, start: Pair, stop: Pair, rounds: int = 1) -> None:
        self._start, self._length = start[0], stop[0] - start[0]
        self._rounds, self._done = rounds, 0
        self._bar = ProgressBar("events")

    def reached(self, seconds: Pair) -> None:
        """Draw: the current round is complete up to this time."""
        if self._length > 0.0:
            share = (seconds[0] - self._start) / self._length
            self._bar(self._done + share, self._rounds)

    def next_round(self) -> None:
        """The next round begins."""
        self._done += 1

    def end(self) -> None:
        """Complete the bar: a search may end before the last of its span."""
        self._bar(self._rounds, self._rounds)
