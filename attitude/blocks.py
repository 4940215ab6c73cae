"""Division of work into blocks, for one thread or several, with reports of progress."""

from __future__ import annotations

from concurrent.futures import FIRST_COMPLETED, ThreadPoolExecutor, wait
from itertools import islice
from typing import TYPE_CHECKING

from attitude import validation

if TYPE_CHECKING:
    from collections.abc import Callable

# Blocks of each thread that are submitted ahead: `wait` takes time in proportion to their number.
_AHEAD = 4


def in_blocks(
    work: Callable[[int, int], object],
    total: int,
    size: int,
    threads: int,
    progress: Callable[[int, int], object] | None = None,
) -> None:
    """Call ``work(begin, end)`` for consecutive ranges of at most `size` from 0 to `total`.

    Several threads gain time only if `work` releases the interpreter lock.  Their blocks end in any
    order; results are the same bits.  ``progress(done, total)`` is called in the caller's thread
    after each block; an exception from it, or from `work`, cancels the blocks not yet begun.

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
    left = iter(ranges)
    with ThreadPoolExecutor(threads) as pool:
        pending = {pool.submit(work, *pair): pair for pair in islice(left, _AHEAD * threads)}
        try:
            while pending:
                ready, _ = wait(pending, return_when=FIRST_COMPLETED)
                for future in ready:
                    begin, end = pending.pop(future)
                    future.result()
                    done += end - begin
                    for pair in islice(left, 1):
                        pending[pool.submit(work, *pair)] = pair
                    if progress is not None:
                        progress(done, total)
        finally:
            for future in pending:
                future.cancel()


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
