"""Division of work into blocks, for one thread or several, with reports of progress."""

from __future__ import annotations

import math
import sys
import threading
import time
from contextlib import contextmanager
from typing import TYPE_CHECKING

from attitude._support import validation

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator


# Seconds between two reports of the progress of several threads.
_BETWEEN_REPORTS = 0.05


def in_blocks(
    work: Callable[[int, int], object],
    total: int,
    size: int,
    threads: int,
    progress: Callable[[int, int], object] | None = None,
) -> None:
    """Call ``work(begin, end)`` for consecutive ranges of at most `size` from 0 to `total`.

    Several threads gain time only if `work` releases the interpreter lock.  Their blocks end in any
    order; results are the same bits.  ``progress(done, total)`` is called in the caller's thread,
    after each block of one thread and every 0.05 s of several; an exception from it, or from
    `work`, cancels the blocks not yet begun.
    """
    threads = validation.count(threads, "threads")
    ranges = [(begin, min(begin + size, total)) for begin in range(0, total, size)]
    done = 0
    if threads == 1 or len(ranges) <= 1:
        for begin, end in ranges:
            work(begin, end)
            done += end - begin
            if progress is not None:
                progress(done, total)
        return
    _in_threads(work, ranges, total, min(threads, len(ranges)), progress)


def _in_threads(
    work: Callable[[int, int], object],
    ranges: list[tuple[int, int]],
    total: int,
    threads: int,
    progress: Callable[[int, int], object] | None,
) -> None:
    """`in_blocks` by several threads, each of which takes the next range when it has ended one.

    The caller's thread wakes only to report: for each future that it waited for, it would hold the
    interpreter lock while a thread has to begin its next range.
    """
    left, taking, over = iter(ranges), threading.Lock(), threading.Event()
    ended: list[int] = []
    failures: list[BaseException] = []
    running = [threads]

    def run() -> None:
        try:
            while not failures:
                with taking:
                    pair = next(left, None)
                if pair is None:
                    break
                work(*pair)
                ended.append(pair[1] - pair[0])
        except BaseException as error:  # it is raised in the caller's thread
            failures.append(error)
        finally:
            with taking:
                running[0] -= 1
                if not running[0]:
                    over.set()

    every = [threading.Thread(target=run, daemon=True) for _ in range(threads)]
    try:
        for thread in every:
            thread.start()
        reported = 0
        is_over = False
        while not is_over:
            is_over = over.wait(_BETWEEN_REPORTS)
            if progress is not None and len(ended) > reported and not failures:
                reported = len(ended)
                progress(sum(ended[:reported]), total)
    except BaseException as error:
        failures.append(error)
        raise
    finally:
        for thread in every:
            if thread.ident is not None:
                thread.join()
    if failures:
        raise failures[0]


def in_rectangles(
    work: Callable[[slice, tuple[int, int]], object],
    bodies: int,
    epochs: int,
    most_bodies: int,
    most_epochs: int,
    rows: int,
    threads: int,
    progress: Callable[[int, int], object] | None,
) -> None:
    """Call ``work(part, (first, end))`` for rectangles of bodies and epochs that cover all."""
    if not bodies:
        return
    span = min(max(epochs, 1), most_epochs)
    pieces = max(-(-epochs // span), 1)
    size = max(1, min(most_bodies, rows // span))

    def rectangles(begin: int, end: int) -> None:
        for number in range(begin, end):
            block, piece = divmod(number, pieces)
            bodies_of_block = slice(block * size, min((block + 1) * size, bodies))
            work(bodies_of_block, (piece * span, min((piece + 1) * span, epochs)))

    in_blocks(rectangles, pieces * -(-bodies // size), 1, threads, progress)


# ---- A line on standard error that says how far a long computation is

# Seconds before the line appears.
_PATIENCE = 1.0
# Seconds between two changes of it.
_INTERVAL = 0.2
# Seconds without a call after which another computation, one within the first, takes the line.
_RELEASE = 10.0
_WIDTH = 30
# Share of a limit of time that is shown at most before the end.
_ALMOST = 0.99

# The bar that draws the line, and its last call: computations within others draw nothing.
_owner: ProgressBar | None = None
_called = -_RELEASE


class ProgressBar:
    """A function of (done, total) that draws a bar with a label if standard error is a terminal."""

    def __init__(self, label: str) -> None:
        self._label = label
        self._next = time.monotonic() + _PATIENCE
        self._length = 0

    def __call__(self, done: float, total: float, stage: str = "") -> None:
        """Draw, where `done` of `total` are over; `stage` is a text beside the bar."""
        global _owner
        now = time.monotonic()
        if sys.stderr is None or not sys.stderr.isatty() or not self._is_owner(now):
            return
        ended = done >= total
        if ended:
            _owner = None
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
    label: str, seconds: float, reporter: Callable[[str], object] | None = None
) -> Iterator[Callable[[str], object]]:
    """A function that is called with the text of each stage of a search with a limit of time."""
    if reporter is not None:
        yield reporter
        return
    bar, begin = ProgressBar(label), time.monotonic()

    def report(stage: str) -> None:
        # below 1: the last stages run when the time is over
        bar(min(time.monotonic() - begin, _ALMOST * seconds), seconds, stage)

    yield report
    bar(1, 1)
