"""Stores past the caches in compiled code, and their definitions in Python."""

import numpy as np
import pytest

from attitude._compilation.decorators import entry_point
from attitude._compilation.simd import LINE, copy_line, eight, finish_stores, past_line, put_line


@entry_point
def copied(source, target):
    """Copy the whole lines of a row, and return the number of doubles before the first one."""
    skipped = -past_line(target) % LINE
    for i in range(skipped, len(target) - LINE + 1, LINE):
        copy_line(source, i, target, i)
    finish_stores()
    return skipped


@entry_point
def put(source, target):
    """As `copied`, by vectors."""
    skipped = -past_line(target) % LINE
    for i in range(skipped, len(target) - LINE + 1, LINE):
        put_line(target, i, eight(source, i))
    finish_stores()
    return skipped


@pytest.mark.parametrize(
    "run",
    [copied, copied.py_func, put, put.py_func],
    ids=["compiled", "python", "compiled vectors", "vectors in python"],
)
@pytest.mark.parametrize("shift", range(9))
def test_whole_lines(run, shift):
    memory, source = np.zeros(64), np.arange(1.0, 65.0)
    target = memory[shift : shift + 41]
    skipped = run(source[:41], target)
    assert (target.ctypes.data + 8 * skipped) % 64 == 0
    lines = (41 - skipped) // LINE * LINE
    assert np.array_equal(target[skipped : skipped + lines], source[skipped : skipped + lines])
    assert np.count_nonzero(memory) == lines
