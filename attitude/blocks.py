"""Division of work into blocks, for one thread or several, with reports of progress."""

from __future__ import annotations

import threading
from typing import TYPE_CHECKING

from attitude import validation

if TYPE_CHECKING:
    from collections.abc import Callable

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

    Raises
    ------
    AttitudeError
        For threads that is not a whole number of at least 1.
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
        for each in every:
            each.start()
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
        for each in every:
            if each.ident is not None:
                each.join()
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
    progress: Callable[[int, int], object] | None = None,
) -> None:
    """Call ``work(part, (first, end))`` for rectangles of bodies and epochs that cover all.

    Parameters
    ----------
    work : callable
        Called with a slice of bodies and a range of epochs.
    bodies, epochs : int
    most_bodies, most_epochs, rows : int
        Upper bounds of a rectangle: its bodies, its epochs, and their product.
    threads, progress
        As of `in_blocks`.
    """
    if not bodies:
        return
    span = min(max(epochs, 1), most_epochs)
    pieces = max(-(-epochs // span), 1)
    size = max(1, min(most_bodies, rows // span))

    def rectangles(begin: int, end: int) -> None:
        for each in range(begin, end):
            block, piece = divmod(each, pieces)
            part = slice(block * size, min((block + 1) * size, bodies))
            work(part, (piece * span, min((piece + 1) * span, epochs)))

    in_blocks(rectangles, pieces * -(-bodies // size), 1, threads, progress)
