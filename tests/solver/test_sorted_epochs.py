"""Directions along compressed paths: in any order of the epochs the same doubles, found quickly."""

import time

import numpy as np
import pytest

from attitude import paths
from attitude._solver import chebyshev
from attitude.epochs._inputs import instant
from attitude.errors import AttitudeError
from attitude.paths._path import since

START = instant("2028-01-01T00:00:00")
SPAN = 2e7


@pytest.fixture(scope="module")
def small():
    """An eccentric orbit: short pieces at the pericentre, long ones elsewhere."""
    path = paths.kepler(
        epoch=START, center="sun", semi_major_axis=1e11, eccentricity=0.6, inclination=0.5,
        node=0.2, pericenter_argument=0.1, mean_anomaly=0.3,
    )  # fmt: skip
    return paths.compress(path, START, START.after(SPAN), 1e-3)


def directions(path, hi, lo=None, sign=1.0):
    hi = np.asarray(hi, dtype=np.float64)
    unit, length = np.full((3, hi.size), 7.0), np.full(hi.size, 7.0)
    path.directions(START, hi, np.zeros(1) if lo is None else lo, sign, unit, length)
    return np.vstack([unit, length])


def test_they_are_the_positions_normalised(small):
    seconds = np.linspace(0.0, SPAN, 1003)
    position = small.position(START, seconds).T
    found = directions(small, seconds, sign=-1.0)
    length = np.sqrt(np.sum(position**2, axis=0))
    assert np.unique(small.pieces.widths).size > 2
    np.testing.assert_array_equal(found[3], length)
    # One rounding of the quotient and one of the product.
    assert np.abs(found[:3] + position / length).max() <= 2.3e-16


@pytest.mark.parametrize("seed", range(3))
def test_any_order_gives_the_same_doubles(small, seed):
    random = np.random.default_rng(seed)
    seconds = np.sort(random.uniform(0.0, SPAN, 2001))
    low = random.uniform(-1e-9, 1e-9, seconds.size)
    found = directions(small, seconds, low)
    order = random.permutation(seconds.size)
    np.testing.assert_array_equal(directions(small, seconds[order], low[order]), found[:, order])
    np.testing.assert_array_equal(directions(small, seconds[::-1], low[::-1]), found[:, ::-1])


def test_views_of_epochs(small):
    """Epochs that do not follow each other in memory, whose neighbours there lie in one piece."""
    seconds, low = np.linspace(0.0, SPAN, 4002), np.linspace(0.0, 1e-9, 4002)
    found = directions(small, seconds, low)
    for part in (slice(None, None, 2), slice(None, None, -1), slice(1, None, 3)):
        np.testing.assert_array_equal(directions(small, seconds[part], low[part]), found[:, part])


def test_few_and_missing_epochs(small):
    seconds = np.linspace(0.0, SPAN, 33)
    found = directions(small, seconds)
    for count in (0, 1, 7, 8, 9):
        np.testing.assert_array_equal(directions(small, seconds[:count]), found[:, :count])
    holed = seconds.copy()
    holed[[0, 5, 20, 32]] = np.nan
    found[:, [0, 5, 20, 32]] = np.nan
    np.testing.assert_array_equal(directions(small, holed), found)


def test_an_epoch_outside_is_refused(small):
    seconds = np.linspace(0.0, SPAN, 33)
    for k, wrong in ((0, -1.0), (13, SPAN + 1.0), (32, 1e300)):
        changed = seconds.copy()
        changed[k] = wrong
        with pytest.raises(AttitudeError, match="is known from"):
            directions(small, changed)


def test_python_gives_the_same_doubles(small):
    seconds = np.linspace(0.0, SPAN, 43)
    seconds[30:] = seconds[30:][::-1]
    pieces, low = small.pieces, np.zeros(1)
    unit, length = np.empty((3, seconds.size)), np.empty(seconds.size)
    outside = chebyshev.directions._in_python(
        seconds,
        low,
        *since(START, pieces.start),
        pieces.most,
        pieces.width,
        pieces.cells,
        pieces.starts,
        pieces.widths,
        pieces.records,
        small._rows,
        pieces.count,
        1.0,
        0,
        seconds.size,
        unit,
        length,
    )
    assert outside == -1
    np.testing.assert_array_equal(np.vstack([unit, length]), directions(small, seconds))


def test_sorted_epochs_are_walked(small):
    """At most two thirds of the cost of unsorted ones, each with a search; measured: 0.25."""
    seconds = np.linspace(0.0, SPAN, 200_000)
    unsorted = np.random.default_rng(1).permutation(seconds)

    def cost(epochs):
        taken = []
        for _ in range(5):
            begin = time.thread_time()
            directions(small, epochs)
            taken.append(time.thread_time() - begin)
        return min(taken)

    assert cost(seconds) < 0.67 * cost(unsorted)
