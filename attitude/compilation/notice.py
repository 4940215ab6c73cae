"""A line on a terminal while functions are compiled for longer than a second."""

from __future__ import annotations

import sys
import time

# s of compilation in a process after which the line is written.
_PATIENCE = 1.0

_depth = 0
_begin = _taken = 0.0
_written = False


def started() -> None:
    """Count a compilation that starts; nested ones belong to the outermost."""
    global _depth, _begin
    if _depth == 0:
        _begin = time.monotonic()
    _depth += 1
    _write_once()


def ended() -> None:
    """Count a compilation that ends."""
    global _depth, _taken
    _depth = max(0, _depth - 1)
    _write_once()
    if _depth == 0:
        _taken += time.monotonic() - _begin


def _write_once() -> None:
    global _written
    if _written or _taken + time.monotonic() - _begin < _PATIENCE:
        return
    _written = True
    if sys.stderr is not None and sys.stderr.isatty():
        print(
            "attitude: compiling, once on this machine; `attitude warm-up --all` does it ahead ...",
            file=sys.stderr,
        )
