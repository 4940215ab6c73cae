"""Work cut into blocks, for one thread or several, with word of how far it has come."""

from concurrent.futures import FIRST_COMPLETED, ThreadPoolExecutor, wait

import numpy as np

from attitude.errors import AttitudeError


def in_blocks(work, total, size, threads, progress=None):
    """Call ``work(begin, end)`` for consecutive ranges of at most `size` up to `total`.

    With several threads `work` must release the lock of the interpreter; blocks then end in any
    order, and results are the same bits.  ``progress(done, total)`` is called in the caller's
    thread after each block; an exception from it, or from `work`, stops what has not begun.
    """
    if not (isinstance(threads, (int, np.integer)) and threads >= 1):
        raise AttitudeError(f"threads is {threads!r}; give a whole number, at least 1.")
    ranges = [(begin, min(begin + size, total)) for begin in range(0, total, size)]
    done = 0
    if threads == 1 or len(ranges) <= 1:
        for begin, end in ranges:
            work(begin, end)
            done += end - begin
            if progress is not None:
                progress(done, total)
        return
    with ThreadPoolExecutor(int(threads)) as pool:
        waiting = {pool.submit(work, *pair): pair for pair in ranges}
        try:
            while waiting:
                ready, _ = wait(waiting, return_when=FIRST_COMPLETED)
                for future in ready:
                    begin, end = waiting.pop(future)
                    future.result()
                    done += end - begin
                    if progress is not None:
                        progress(done, total)
        finally:
            for future in waiting:
                future.cancel()
