"""Loops over bodies, blocks of epochs and columns: sensitivities in arrays.

Given
    constants  (B,) of solution.record; those of another form are skipped
    tangents   (B,) of solution.tangent_record
    short      (B,) of solution.short_times, or (0,) if no epoch is within its reach
    t          (1 or B, T) seconds since the epoch of the state
    t_low      None, or a second double of the seconds, in the same shape
    edges      (B, 2) the epochs of body b from edges[b, 0] to edges[b, 1] are evaluated
    block      (ROWS BLOCK,) working memory
Filled
    attitude   (1 or B, 3, P, T) rotation vectors of the changes with P parameters, inertial axes;
               with a leading axis of 1 the epochs of all bodies stand in one row
    omega      (1 or B, 3, P, T) changes of the angular velocity, rad/s over the body axes, or None
    out        (1 or B, D, D, T) sums of the products of the columns: of the changes of attitude
               (D = 3), and of the angular velocity too (D = 6)
Returned
    -1, or the first body with an epoch beyond its reach
"""

from attitude.compilation.decorators import entry_point
from attitude.solution import codes
from attitude.solution.columns import (
    add_products,
    add_products_of_rates,
    attitude_column,
    copy_column,
    copy_sums,
    keep_turn,
    rate_column,
    start_sums,
)
from attitude.solution.kernel import any_beyond, reach
from attitude.solution.short_times import any_near, near_column, near_rate_column
from attitude.solution.tangent_record import BLOCK, COLUMNS
from attitude.solution.tangents import (
    hyperbolic_block,
    hyperbolic_rates_block,
    trigonometric_block,
    trigonometric_rates_block,
)
from attitude.solution.uniform_tangents import (
    uniform_block,
    uniform_column,
    uniform_rate_column,
)


@entry_point
def trigonometric(constants, tangents, short, t, t_low, block, attitude, omega, edges):
    """Fill the columns of motions of the trigonometric form; see the module docstring."""
    columns = attitude.shape[2]
    for b in range(len(constants)):
        c, d, k = constants[b], tangents[b], b if len(t) > 1 else 0
        o = b if len(attitude) > 1 else 0
        first, end = edges[b, 0], edges[b, 1]
        if c.form != codes.TRIGONOMETRIC:
            continue
        lows = None if t_low is None else t_low[k, first:end]
        if any_beyond(t[k, first:end], lows, reach(c)):
            return b
        for start in range(first, end, BLOCK):
            stop = min(start + BLOCK, end)
            times, low = t[k, start:stop], None if t_low is None else t_low[k, start:stop]
            trigonometric_block(c, d, times, low, block)
            near = len(short) > 0 and any_near(times, short[b].reach)
            if omega is not None:
                trigonometric_rates_block(c, stop - start, block)
            for j in range(columns):
                attitude_column(d, j, stop - start, block)
                if near:
                    near_column(d, short[b], j, stop - start, block)
                copy_column(block, o, j, start, stop, attitude)
                if omega is not None:
                    rate_column(d, j, stop - start, block)
                    if near:
                        near_rate_column(short[b], j, stop - start, block)
                    copy_column(block, o, j, start, stop, omega)
    return -1


@entry_point
def hyperbolic(constants, tangents, short, t, t_low, block, attitude, omega, edges):
    """Fill the columns of motions of the hyperbolic form; see the module docstring."""
    columns = attitude.shape[2]
    for b in range(len(constants)):
        c, d, k = constants[b], tangents[b], b if len(t) > 1 else 0
        o = b if len(attitude) > 1 else 0
        first, end = edges[b, 0], edges[b, 1]
        if c.form != codes.HYPERBOLIC:
            continue
        lows = None if t_low is None else t_low[k, first:end]
        if any_beyond(t[k, first:end], lows, reach(c)):
            return b
        for start in range(first, end, BLOCK):
            stop = min(start + BLOCK, end)
            times, low = t[k, start:stop], None if t_low is None else t_low[k, start:stop]
            hyperbolic_block(c, d, times, low, block)
            near = len(short) > 0 and any_near(times, short[b].reach)
            if omega is not None:
                hyperbolic_rates_block(c, stop - start, block)
            for j in range(columns):
                attitude_column(d, j, stop - start, block)
                if near:
                    near_column(d, short[b], j, stop - start, block)
                copy_column(block, o, j, start, stop, attitude)
                if omega is not None:
                    rate_column(d, j, stop - start, block)
                    if near:
                        near_rate_column(short[b], j, stop - start, block)
                    copy_column(block, o, j, start, stop, omega)
    return -1


@entry_point
def uniform(constants, tangents, short, t, t_low, block, attitude, omega, edges):
    """Fill the columns of motions of constant angular velocity; see the module docstring."""
    columns = attitude.shape[2]
    for b in range(len(constants)):
        c, d, k = constants[b], tangents[b], b if len(t) > 1 else 0
        o = b if len(attitude) > 1 else 0
        first, end = edges[b, 0], edges[b, 1]
        if c.form != codes.UNIFORM:
            continue
        lows = None if t_low is None else t_low[k, first:end]
        if any_beyond(t[k, first:end], lows, reach(c)):
            return b
        for start in range(first, end, BLOCK):
            stop = min(start + BLOCK, end)
            times, low = t[k, start:stop], None if t_low is None else t_low[k, start:stop]
            uniform_block(c, d, times, low, block)
            for j in range(columns):
                uniform_column(d, j, stop - start, block)
                copy_column(block, o, j, start, stop, attitude)
                if omega is not None:
                    uniform_rate_column(d, j, stop - start, block)
                    copy_column(block, o, j, start, stop, omega)
    return -1


@entry_point
def trigonometric_covariance(constants, tangents, short, t, t_low, block, out, edges):
    """Fill the covariances of motions of the trigonometric form; see the module docstring."""
    rates = out.shape[1] == 6
    for b in range(len(constants)):
        c, d, k = constants[b], tangents[b], b if len(t) > 1 else 0
        o = b if len(out) > 1 else 0
        first, end = edges[b, 0], edges[b, 1]
        if c.form != codes.TRIGONOMETRIC:
            continue
        lows = None if t_low is None else t_low[k, first:end]
        if any_beyond(t[k, first:end], lows, reach(c)):
            return b
        for start in range(first, end, BLOCK):
            stop = min(start + BLOCK, end)
            n = stop - start
            times, low = t[k, start:stop], None if t_low is None else t_low[k, start:stop]
            trigonometric_block(c, d, times, low, block)
            near = len(short) > 0 and any_near(times, short[b].reach)
            if rates:
                trigonometric_rates_block(c, n, block)
            start_sums(n, 21 if rates else 6, block)
            for j in range(COLUMNS):
                attitude_column(d, j, n, block)
                if near:
                    near_column(d, short[b], j, n, block)
                add_products(n, block)
                if rates:
                    keep_turn(n, block)
                    rate_column(d, j, n, block)
                    if near:
                        near_rate_column(short[b], j, n, block)
                    add_products_of_rates(n, block)
            copy_sums(block, o, start, stop, out)
    return -1


@entry_point
def hyperbolic_covariance(constants, tangents, short, t, t_low, block, out, edges):
    """Fill the covariances of motions of the hyperbolic form; see the module docstring."""
    rates = out.shape[1] == 6
    for b in range(len(constants)):
        c, d, k = constants[b], tangents[b], b if len(t) > 1 else 0
        o = b if len(out) > 1 else 0
        first, end = edges[b, 0], edges[b, 1]
        if c.form != codes.HYPERBOLIC:
            continue
        lows = None if t_low is None else t_low[k, first:end]
        if any_beyond(t[k, first:end], lows, reach(c)):
            return b
        for start in range(first, end, BLOCK):
            stop = min(start + BLOCK, end)
            n = stop - start
            times, low = t[k, start:stop], None if t_low is None else t_low[k, start:stop]
            hyperbolic_block(c, d, times, low, block)
            near = len(short) > 0 and any_near(times, short[b].reach)
            if rates:
                hyperbolic_rates_block(c, n, block)
            start_sums(n, 21 if rates else 6, block)
            for j in range(COLUMNS):
                attitude_column(d, j, n, block)
                if near:
                    near_column(d, short[b], j, n, block)
                add_products(n, block)
                if rates:
                    keep_turn(n, block)
                    rate_column(d, j, n, block)
                    if near:
                        near_rate_column(short[b], j, n, block)
                    add_products_of_rates(n, block)
            copy_sums(block, o, start, stop, out)
    return -1


@entry_point
def uniform_covariance(constants, tangents, short, t, t_low, block, out, edges):
    """Fill the covariances of motions of the uniform form; see the module docstring."""
    rates = out.shape[1] == 6
    for b in range(len(constants)):
        c, d, k = constants[b], tangents[b], b if len(t) > 1 else 0
        o = b if len(out) > 1 else 0
        first, end = edges[b, 0], edges[b, 1]
        if c.form != codes.UNIFORM:
            continue
        lows = None if t_low is None else t_low[k, first:end]
        if any_beyond(t[k, first:end], lows, reach(c)):
            return b
        for start in range(first, end, BLOCK):
            stop = min(start + BLOCK, end)
            n = stop - start
            times, low = t[k, start:stop], None if t_low is None else t_low[k, start:stop]
            uniform_block(c, d, times, low, block)
            start_sums(n, 21 if rates else 6, block)
            for j in range(COLUMNS):
                uniform_column(d, j, n, block)
                add_products(n, block)
                if rates:
                    keep_turn(n, block)
                    uniform_rate_column(d, j, n, block)
                    add_products_of_rates(n, block)
            copy_sums(block, o, start, stop, out)
    return -1
