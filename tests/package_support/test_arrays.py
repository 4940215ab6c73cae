"""Large arrays are copied in parts, between which Ctrl-C is heard."""

import numpy as np
import pytest

from attitude._support import arrays


@pytest.mark.parametrize("shape", [(5003,), (4, 5003), (5003, 4), (2, 3, 5003), (5003, 3, 9), ()])
def test_copies_in_parts(shape, monkeypatch):
    monkeypatch.setattr(arrays, "_PART", 1000)
    array = np.random.default_rng(1).normal(size=shape)
    copy = arrays.copied(array)
    assert np.array_equal(copy, array)
    assert not np.shares_memory(copy, array)
    turned = np.empty(shape[::-1]).T
    arrays.put(turned, array)
    assert np.array_equal(turned, array)
