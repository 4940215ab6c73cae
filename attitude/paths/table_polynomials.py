"""Polynomials through the rows of a table: Lagrange's, and Hermite's where velocities are given.

The polynomial between two rows passes through the nearest rows on both sides, as in the
interpolation of CCSDS messages and of SPICE's types 8, 9, 12 and 13; near the ends of the table the
window is that of the last rows.  All intervals are fitted at once, to Chebyshev coefficients of
the interval, so that an epoch costs one short recurrence.

Source: Newton's divided differences with repeated nodes (Stoer & Bulirsch, section 2.1.5).
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from attitude import chebyshev

if TYPE_CHECKING:
    from attitude.annotations import FloatArray


def interval_polynomials(
    knots: FloatArray,
    knots_low: FloatArray,
    values: FloatArray,
    rates: FloatArray | None,
    degree: int,
) -> FloatArray:
    """Chebyshev coefficients of the polynomial of each interval between rows.

    Parameters
    ----------
    knots, knots_low : (N,) arrays
        Ascending epochs in two doubles, s.
    values : (N, 3) array
    rates : (N, 3) array or None
        Derivatives of the values by time, for Hermite's polynomials; None for Lagrange's.
    degree : int
        Each polynomial passes through `rows_needed` rows.

    Returns
    -------
    (N - 1, 3 (degree + 1)) array
        Records as `chebyshev_loops.values` takes them.
    """
    window = rows_needed(degree, rates is not None)
    first = np.arange(len(knots) - 1) - (window - 1) // 2
    first = np.clip(first, 0, len(knots) - window)
    rows = first[:, None] + np.arange(window)
    interval = np.arange(len(knots) - 1)
    width = np.diff(knots) + np.diff(knots_low)
    # Time from the start of the interval in units of its length.
    nodes = (knots[rows] - knots[interval, None]) + (knots_low[rows] - knots_low[interval, None])
    nodes /= width[:, None]
    # Differences from the value at the start: the rounding errors of the divided differences are
    # then relative to these, not to the size of the orbit.
    start = values[interval][:, None, :]
    known = values[rows] - start
    slopes = None
    if rates is not None:
        slopes = rates[rows] * width[:, None, None]
        nodes, known, slopes = (np.repeat(each, 2, axis=1) for each in (nodes, known, slopes))
    newton = _divided_differences(nodes, known, slopes)
    x = 0.5 * (chebyshev.nodes(degree + 1) + 1.0)
    sampled = np.stack([_newton_at(each, nodes, newton) for each in x])
    table = chebyshev.coefficients(sampled)
    table[0] += start[:, 0]
    return np.ascontiguousarray(table.transpose(1, 2, 0)).reshape(len(interval), -1)


def rows_needed(degree: int, with_rates: bool) -> int:
    """The count of rows that a polynomial of a degree passes through."""
    return (degree + 1) // 2 if with_rates else degree + 1


def _divided_differences(nodes, values, slopes):
    """The coefficients of Newton's form (intervals, nodes, 3); nodes may be equal in pairs."""
    table = values.copy()
    count = nodes.shape[1]
    for order in range(1, count):
        gap = nodes[:, order:] - nodes[:, :-order]
        change = table[:, order:] - table[:, order - 1 : -1]
        if order == 1 and slopes is not None:
            twin = gap == 0.0
            gap = np.where(twin, 1.0, gap)
            change = np.where(twin[..., None], slopes[:, 1:], change / gap[..., None])
        else:
            change = change / gap[..., None]
        table[:, order:] = change
    return table


def _newton_at(x, nodes, newton):
    """The values (intervals, 3) of Newton's form at one x of each interval, from 0 to 1."""
    total = newton[:, -1]
    for order in range(newton.shape[1] - 2, -1, -1):
        total = newton[:, order] + total * (x - nodes[:, order])[:, None]
    return total
