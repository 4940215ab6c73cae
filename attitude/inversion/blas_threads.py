"""The threads of BLAS: matrices here are so small that several threads only wait for each other."""

from __future__ import annotations

from contextlib import AbstractContextManager, nullcontext


def limited(threads: int = 1) -> AbstractContextManager[object]:
    """A context within which BLAS runs in at most so many threads."""
    try:
        from threadpoolctl import threadpool_limits
    except ImportError:
        return nullcontext()
    limits: AbstractContextManager[object] = threadpool_limits(threads)
    return limits
