"""Threads of the linear algebra of a search."""

from __future__ import annotations

from contextlib import AbstractContextManager, nullcontext


def limited(threads: int = 1) -> AbstractContextManager[object]:
    """Limit the threads of BLAS: matrices here are so small that threads only wait."""
    try:
        from threadpoolctl import threadpool_limits
    except ImportError:
        return nullcontext()
    limits: AbstractContextManager[object] = threadpool_limits(threads)
    return limits
