"""A line on standard error that says how far a long computation is."""

from __future__ import annotations

import math
import sys
import time
from contextlib import contextmanager
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

# Seconds before the line appears, and between two changes of it.
_PATIENCE, _INTERVAL = 1.0, 0.2
# Seconds without a call after which another computation, one within the first, takes the line.
_RELEASE = 10.0
_WIDTH = 30
# Share of a limit of time that is shown at most before the end.
_ALMOST = 0.99

# The bar that draws the line, and its last call: computations within others draw nothing.
_owner: ProgressBar | None = None
_called = -_RELEASE


class ProgressBar:
    """A function of (done, total) that draws a bar if standard error is a terminal.

    Parameters
    ----------
    label : str
        What is computed.
    """

    def __init__(self, label: str) -> None:
        self._label = label
        self._next = time.monotonic() + _PATIENCE
        self._length = 0

    def __call__(self, done: float, total: float, stage: str = "") -> None:
        """Draw, where `done` of `total` are over; `stage` is a text beside the bar."""
        now = time.monotonic()
        if sys.stderr is None or not sys.stderr.isatty() or not self._is_owner(now):
            return
        ended = done >= total
        if ended:
            _release()
        if now < self._next and not (self._length and ended):
            return
        self._next = math.inf if ended else now + _INTERVAL
        share = min(done / total, 1.0) if total > 0.0 else 1.0
        full = int(_WIDTH * share)
        bar = "#" * full + "." * (_WIDTH - full)
        text = f"attitude: {self._label} [{bar}] {int(100 * share):3d} %  {stage}".rstrip()
        end = "\n" if ended else ""
        print("\r" + text.ljust(self._length), end=end, file=sys.stderr, flush=True)
        self._length = 0 if ended else len(text)

    def _is_owner(self, now: float) -> bool:
        """Whether this bar draws the line: the first that was called, until its end."""
        global _owner, _called
        if _owner is not self and _owner is not None and now < _called + _RELEASE:
            return False
        _owner, _called = self, now
        return True


@contextmanager
def timed(
    label: str, seconds: float, given: Callable[[str], object] | None = None
) -> Iterator[Callable[[str], object]]:
    """A function that is called with the text of each stage of a search with a limit of time.

    Parameters
    ----------
    label : str
        What is searched.
    seconds : float
        After which the search ends; it may end earlier.
    given : callable, optional
        A user's function, which takes the place of the bar.
    """
    if given is not None:
        yield given
        return
    bar, begin = ProgressBar(label), time.monotonic()

    def report(stage: str) -> None:
        # below 1: the last stages run when the time is over
        bar(min(time.monotonic() - begin, _ALMOST * seconds), seconds, stage)

    yield report
    bar(1, 1)


def _release() -> None:
    global _owner
    _owner = None
