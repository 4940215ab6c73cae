"""A line on standard error that says how far a long computation is."""

from __future__ import annotations

import sys
import time

# Seconds before the line appears, and between two changes of it.
_PATIENCE, _INTERVAL = 1.0, 0.2
_WIDTH = 30


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
        self._drawn = False

    def __call__(self, done: int, total: int) -> None:
        now = time.monotonic()
        if not sys.stderr.isatty() or (now < self._next and not (self._drawn and done == total)):
            return
        self._next = now + _INTERVAL
        self._drawn = True
        full = _WIDTH * done // total
        bar = "#" * full + "." * (_WIDTH - full)
        end = "\n" if done == total else ""
        text = f"\rattitude: {self._label} [{bar}] {100 * done // total:3d} %"
        print(text, end=end, file=sys.stderr, flush=True)
