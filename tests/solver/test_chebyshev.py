"""Chebyshev pieces: exact for polynomials, within their measured error for smooth functions."""

import copy
import pickle

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from attitude._solver.chebyshev import Pieces, coefficients, evaluate, nodes
from attitude.errors import AttitudeError


def circle(t):
    return np.stack([np.cos(t), np.sin(t), 0.1 * t], axis=-1)


@given(st.lists(st.floats(-1e3, 1e3), min_size=1, max_size=17))
def test_the_coefficients_of_a_chebyshev_series_are_found_again(series):
    values = np.polynomial.chebyshev.chebval(nodes(len(series)), series)
    # 17 terms of at most 1e3, each rounded to 1e-13 a few times.
    assert np.max(np.abs(coefficients(values) - series)) < 2e-11


def test_evaluate_agrees_with_numpy_for_every_piece_and_component():
    table = np.random.default_rng(1).normal(size=(9, 2, 4))
    x = np.linspace(-1.0, 1.0, 10_001)  # more than one chunk
    piece = np.arange(len(x)) % 4
    values = evaluate(table, piece, x)
    assert values.shape == (2, len(x))
    for number in range(4):
        expected = np.polynomial.chebyshev.chebval(x, table[..., number])
        here = piece == number
        assert np.max(np.abs(values - expected)[:, here]) < 1e-14  # sums of 9 terms of order 1


@pytest.mark.parametrize("tolerance", [1e-3, 1e-8, 1e-13])
def test_a_fit_keeps_its_tolerance_between_the_samples(tolerance):
    path = Pieces.fit(circle, 10.0, 200.0, tolerance)
    t = np.random.default_rng(2).uniform(10.0, 200.0, 20_000)
    worst = np.max(np.abs(path(t) - circle(t)))
    assert path.error <= tolerance
    # Measured where the error of an interpolation peaks; 1.5 is the margin of that rule here, and
    # 2e-14 the rounding of 0.1 t = 20 and of the sines of t = 200.
    assert worst <= 1.5 * path.error + 2e-14


def test_the_tolerance_decides_the_number_of_pieces():
    counts = [Pieces.fit(circle, 0.0, 300.0, tol).table.shape[-1] for tol in (1e-2, 1e-6, 1e-12)]
    assert counts[0] < counts[1] < counts[2]


@pytest.mark.parametrize("shape", [(), (1,), (5,), (2, 3), (0,)])
def test_shapes_of_times_and_of_components(shape):
    t = np.full(shape, 3.0)
    assert Pieces.fit(np.cos, 0.0, 9.0, 1e-9)(t).shape == shape
    assert Pieces.fit(circle, 0.0, 9.0, 1e-9)(t).shape == (*shape, 3)
    matrix = Pieces.fit(lambda t: circle(t)[:, :, None] * circle(t)[:, None, :], 0.0, 9.0, 1e-9)
    assert matrix(t).shape == (*shape, 3, 3)


def test_a_low_double_reaches_below_the_rounding_of_t():
    path = Pieces.fit(lambda t: 1e3 * np.sin(1e-6 * t), 0.0, 2e9, 1e-9)
    t, low = 1e9, 5e-8  # the spacing of doubles at 1e9 is 1.2e-7
    step = 1e-3 * np.cos(1e-6 * t) * low
    assert path(t, low) - path(t) == pytest.approx(step, abs=2e-12)  # roundings of 1e3


def test_the_ends_belong_to_the_span_and_what_lies_outside_is_refused():
    path = Pieces.fit(np.sin, 0.0, 3.3, 1e-10)
    assert path(path.start) == pytest.approx(0.0, abs=1e-10)
    assert path(path.stop) == pytest.approx(np.sin(3.3), abs=1e-10)
    for outside in (np.nextafter(0.0, -1.0), 3.31, np.inf):
        with pytest.raises(AttitudeError, match="outside of the span"):
            path([1.0, outside])


def test_nan_times_give_nan_in_their_place_only():
    path = Pieces.fit(circle, 0.0, 9.0, 1e-9)
    values = path([1.0, np.nan, 2.0])
    assert np.array_equal(np.isnan(values), [[False] * 3, [True] * 3, [False] * 3])


def test_a_tolerance_out_of_reach_is_refused_with_the_error_that_was_reached():
    with pytest.raises(AttitudeError, match=r"above the tolerance of 1e-20"):
        Pieces.fit(np.sin, 0.0, 10.0, 1e-20)


def test_bad_input_is_refused():
    with pytest.raises(AttitudeError, match="not finite"):
        Pieces.fit(lambda t: np.where(t > 3.0, np.nan, t), 0.0, 10.0, 1e-6)
    with pytest.raises(AttitudeError, match="start must be less"):
        Pieces.fit(np.sin, 1.0, 1.0, 1e-6)
    with pytest.raises(AttitudeError, match="greater than zero"):
        Pieces.fit(np.sin, 0.0, 1.0, 0.0)


@pytest.mark.parametrize("clone", [copy.deepcopy, lambda p: pickle.loads(pickle.dumps(p))])
def test_copies_are_equal_and_stay_frozen(clone):
    path = Pieces.fit(circle, 0.0, 9.0, 1e-9)
    again = clone(path)
    t = np.linspace(0.0, 9.0, 50)
    assert np.array_equal(again(t), path(t))
    with pytest.raises(ValueError, match="read-only"):
        again.table[0] = 0.0
