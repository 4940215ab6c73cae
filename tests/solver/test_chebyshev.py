"""Chebyshev polynomials on pieces: coefficients from values at the nodes, and values."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from attitude._solver.chebyshev import coefficients, evaluate, nodes


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
