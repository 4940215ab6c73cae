"""Loops over bodies, blocks of epochs and columns: sensitivities in arrays.

Given
    constants  (B,) of solution.record; those of another form are skipped
    tangents   (B,) of solution.tangent_record
    short      (B,) of solution.short_times, or (0,) if no epoch is within its reach
    t          (1 or B, T) seconds since the epoch of the state
    t_low      a second double of the seconds, in the same shape, or (1, 0) where there is none:
               None would be another type, for which each loop would be compiled anew
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

import numpy as np

from attitude.compilation.decorators import force_inlined, slowly_compiled
from attitude.compilation.streaming import LINE, finish_stores
from attitude.solution import codes
from attitude.solution.columns import (
    add_products,
    add_products_of_rates,
    any_missing,
    attitude_column,
    copy_sums,
    epochs_again,
    fill_still_rows,
    found_rows,
    has_whole_lines,
    keep_near_sums,
    keep_turn,
    rate_column,
    rows_of,
    start_sums,
    still_column,
    still_rows,
    stream_rows,
    stream_sums,
    use_near_sums,
)
from attitude.solution.kernel import any_beyond, reach
from attitude.solution.short_times import any_near, near_column, near_rate_column
from attitude.solution.tangent_record import BLOCK, COLUMNS, TURNS
from attitude.solution.tangents import (
    hyperbolic_attitudes_block,
    hyperbolic_block,
    hyperbolic_rates_block,
    trigonometric_attitudes_block,
    trigonometric_block,
    trigonometric_rates_block,
)
from attitude.solution.triangular import places_of_rows, places_of_sums, sums_of_columns
from attitude.solution.uniform_tangents import (
    uniform_block,
    uniform_column,
    uniform_rate_column,
)


@force_inlined
def _is_beyond(c, t, t_low, k, first, end):
    """Whether an epoch of a row is beyond the reach of its motion."""
    if t_low.size > 0:
        return any_beyond(t[k, first:end], t_low[k, first:end], reach(c))
    return any_beyond(t[k, first:end], None, reach(c))


@force_inlined
def _lows(t_low, zeros, k, first, end):
    """The second doubles of some epochs of a row."""
    if t_low.size > 0:
        return t_low[k, first:end]
    return zeros[: end - first]


@slowly_compiled
def trigonometric(constants, tangents, short, t, t_low, block, attitude, omega, edges):
    """Fill the columns of motions of the trigonometric form; see the module docstring."""
    fill_still_rows(block)
    zeros = np.zeros(BLOCK)
    for b in range(len(constants)):
        c, d, k = constants[b], tangents[b], b if len(t) > 1 else 0
        first, end = edges[b, 0], edges[b, 1]
        if c.form != codes.TRIGONOMETRIC:
            continue
        if _is_beyond(c, t, t_low, k, first, end):
            return b
        again = epochs_again(attitude, end - first)
        for start in range(first, end, BLOCK - again):
            stop = min(start + BLOCK - again, end)
            head = max(start - again, first)
            times, low = t[k, head:stop], _lows(t_low, zeros, k, head, stop)
            trigonometric_block(c, d, times, low, block)
            near = len(short) > 0 and any_near(times, short[b].reach)
            if near or omega is not None:
                trigonometric_attitudes_block(c, stop - head, block)
            if omega is not None:
                trigonometric_rates_block(c, d, stop - head, block)
            if again and not near and not any_missing(stop - head, block):
                _stream(d, b, block, (first, start, stop, end), attitude)
                if omega is not None:
                    _stream_rates(c, d, b, block, (first, start, stop, end), omega)
            else:
                _store(d, short, b, near, block, (head, stop), attitude)
                if omega is not None:
                    _store_rates(c, d, short, b, near, block, (head, stop), omega)
    finish_stores()
    return -1


@slowly_compiled
def hyperbolic(constants, tangents, short, t, t_low, block, attitude, omega, edges):
    """Fill the columns of motions of the hyperbolic form; see the module docstring."""
    fill_still_rows(block)
    zeros = np.zeros(BLOCK)
    for b in range(len(constants)):
        c, d, k = constants[b], tangents[b], b if len(t) > 1 else 0
        first, end = edges[b, 0], edges[b, 1]
        if c.form != codes.HYPERBOLIC:
            continue
        if _is_beyond(c, t, t_low, k, first, end):
            return b
        again = epochs_again(attitude, end - first)
        for start in range(first, end, BLOCK - again):
            stop = min(start + BLOCK - again, end)
            head = max(start - again, first)
            times, low = t[k, head:stop], _lows(t_low, zeros, k, head, stop)
            hyperbolic_block(c, d, times, low, block)
            near = len(short) > 0 and any_near(times, short[b].reach)
            if near or omega is not None:
                hyperbolic_attitudes_block(c, stop - head, block)
            if omega is not None:
                hyperbolic_rates_block(c, d, stop - head, block)
            if again and not near and not any_missing(stop - head, block):
                _stream(d, b, block, (first, start, stop, end), attitude)
                if omega is not None:
                    _stream_rates(c, d, b, block, (first, start, stop, end), omega)
            else:
                _store(d, short, b, near, block, (head, stop), attitude)
                if omega is not None:
                    _store_rates(c, d, short, b, near, block, (head, stop), omega)
    finish_stores()
    return -1


@force_inlined
def _store(d, short, b, near, block, span, attitude):
    """Store the changes of attitude of a block of a motion that tumbles, for a span of epochs."""
    row = b if len(attitude) > 1 else 0
    for j in range(attitude.shape[2]):
        x, y, z = rows_of(attitude, row, j, *span)
        if j < TURNS:
            still_column(j, block, x, y, z)
            continue
        attitude_column(d, j, block, x, y, z)
        if near:
            near_column(d, short[b], j, block, x, y, z)


@force_inlined
def _stream(d, b, block, spans, attitude):
    """As `_store`, past the caches: whole lines of them, and the ends of the rows."""
    row, (first, start, stop, _) = b if len(attitude) > 1 else 0, spans
    head = max(start - LINE, first)
    for j in range(min(attitude.shape[2], TURNS)):
        x, y, z = still_rows(j, stop - head, block)
        stream_rows(x, y, z, rows_of(attitude, row, j, 0, attitude.shape[3]), head, spans)
    x, y, z = found_rows(block, stop - head)
    for j in range(TURNS, attitude.shape[2]):
        attitude_column(d, j, block, x, y, z)
        stream_rows(x, y, z, rows_of(attitude, row, j, 0, attitude.shape[3]), head, spans)


@force_inlined
def _stream_rates(c, d, b, block, spans, omega):
    """As `_store_rates`, past the caches."""
    row, (first, start, stop, _) = b if len(omega) > 1 else 0, spans
    head = max(start - LINE, first)
    for j in range(min(omega.shape[2], TURNS)):
        x, y, z = still_rows(-1, stop - head, block)
        stream_rows(x, y, z, rows_of(omega, row, j, 0, omega.shape[3]), head, spans)
    x, y, z = found_rows(block, stop - head)
    for j in range(TURNS, omega.shape[2]):
        rate_column(c, d, j, block, x, y, z)
        stream_rows(x, y, z, rows_of(omega, row, j, 0, omega.shape[3]), head, spans)


@force_inlined
def _store_rates(c, d, short, b, near, block, span, omega):
    """Store the changes of the angular velocity, as `_store`."""
    row = b if len(omega) > 1 else 0
    for j in range(omega.shape[2]):
        x, y, z = rows_of(omega, row, j, *span)
        if j < TURNS:
            still_column(-1, block, x, y, z)
            continue
        rate_column(c, d, j, block, x, y, z)
        if near:
            near_rate_column(short[b], j, block, x, y, z)


@slowly_compiled
def uniform(constants, tangents, short, t, t_low, block, attitude, omega, edges):
    """Fill the columns of motions of constant angular velocity; see the module docstring."""
    columns, zeros = attitude.shape[2], np.zeros(BLOCK)
    for b in range(len(constants)):
        c, d, k = constants[b], tangents[b], b if len(t) > 1 else 0
        o = b if len(attitude) > 1 else 0
        first, end = edges[b, 0], edges[b, 1]
        if c.form != codes.UNIFORM:
            continue
        if _is_beyond(c, t, t_low, k, first, end):
            return b
        for start in range(first, end, BLOCK):
            stop = min(start + BLOCK, end)
            times, low = t[k, start:stop], _lows(t_low, zeros, k, start, stop)
            uniform_block(c, d, times, low, block)
            for j in range(columns):
                x, y, z = rows_of(attitude, o, j, start, stop)
                uniform_column(d, j, block, x, y, z)
                if omega is not None:
                    x, y, z = rows_of(omega, o, j, start, stop)
                    uniform_rate_column(d, j, block, x, y, z)
    return -1


@slowly_compiled
def trigonometric_covariance(constants, tangents, short, t, t_low, block, out, edges):
    """Fill the covariances of motions of the trigonometric form; see the module docstring."""
    rates, zeros = out.shape[1] == 6, np.zeros(BLOCK)
    for b in range(len(constants)):
        c, d, k = constants[b], tangents[b], b if len(t) > 1 else 0
        first, end = edges[b, 0], edges[b, 1]
        if c.form != codes.TRIGONOMETRIC:
            continue
        if _is_beyond(c, t, t_low, k, first, end):
            return b
        again = epochs_again(out, end - first) if rates else 0
        for start in range(first, end, BLOCK - again):
            stop = min(start + BLOCK - again, end)
            head = max(start - again, first)
            n = stop - head
            times, low = t[k, head:stop], _lows(t_low, zeros, k, head, stop)
            trigonometric_block(c, d, times, low, block)
            near = len(short) > 0 and any_near(times, short[b].reach)
            if near or rates:
                trigonometric_attitudes_block(c, n, block)
            if rates:
                trigonometric_rates_block(c, d, n, block)
            _store_covariances(c, d, short, b, near, block, (first, start, stop, end), again, out)
    finish_stores()
    return -1


@slowly_compiled
def hyperbolic_covariance(constants, tangents, short, t, t_low, block, out, edges):
    """Fill the covariances of motions of the hyperbolic form; see the module docstring."""
    rates, zeros = out.shape[1] == 6, np.zeros(BLOCK)
    for b in range(len(constants)):
        c, d, k = constants[b], tangents[b], b if len(t) > 1 else 0
        first, end = edges[b, 0], edges[b, 1]
        if c.form != codes.HYPERBOLIC:
            continue
        if _is_beyond(c, t, t_low, k, first, end):
            return b
        again = epochs_again(out, end - first) if rates else 0
        for start in range(first, end, BLOCK - again):
            stop = min(start + BLOCK - again, end)
            head = max(start - again, first)
            n = stop - head
            times, low = t[k, head:stop], _lows(t_low, zeros, k, head, stop)
            hyperbolic_block(c, d, times, low, block)
            near = len(short) > 0 and any_near(times, short[b].reach)
            if near or rates:
                hyperbolic_attitudes_block(c, n, block)
            if rates:
                hyperbolic_rates_block(c, d, n, block)
            _store_covariances(c, d, short, b, near, block, (first, start, stop, end), again, out)
    finish_stores()
    return -1


@force_inlined
def _store_covariances(c, d, short, b, near, block, spans, again, out):
    """Store the covariances of a block of a motion that tumbles, whose tangents are filled."""
    o, length, flat = b if len(out) > 1 else 0, out.shape[3], out.reshape(out.size)
    first, start, stop, _ = spans
    if not near and out.shape[1] == 3:
        n = stop - start
        whole = n - n % 8
        places, streams = places_of_rows(9 * o * length + start, length), has_whole_lines(out)
        sums_of_columns(c, d, block, 0, whole, places, flat, streams)
        if whole < n:
            sums_of_columns(c, d, block, whole, n, places_of_sums(), block, False)
            copy_sums(block, o, whole, start + whole, stop, out)
        return
    n = stop - max(start - again, first)
    _sum(c, d, short, b, near, block, n, out.shape[1] == 6)
    keep_near_sums(n, block)
    sums_of_columns(c, d, block, 0, n, places_of_sums(), block, False)
    if near:
        use_near_sums(n, short[b].reach, block)
    if again:
        stream_sums(block, o, spans, out)
    else:
        copy_sums(block, o, 0, start, stop, out)


@force_inlined
def _sum(c, d, short, b, near, block, n, rates):
    """Sum the products of the columns of a block of a motion that tumbles, for n epochs."""
    start_sums(n, 21 if rates else 6, block)
    x, y, z = found_rows(block, n)
    for j in range(COLUMNS):
        attitude_column(d, j, block, x, y, z)
        if near:
            near_column(d, short[b], j, block, x, y, z)
        add_products(n, block)
        if rates:
            keep_turn(n, block)
            rate_column(c, d, j, block, x, y, z)
            if near:
                near_rate_column(short[b], j, block, x, y, z)
            add_products_of_rates(n, block)


@slowly_compiled
def uniform_covariance(constants, tangents, short, t, t_low, block, out, edges):
    """Fill the covariances of motions of the uniform form; see the module docstring."""
    rates, zeros = out.shape[1] == 6, np.zeros(BLOCK)
    for b in range(len(constants)):
        c, d, k = constants[b], tangents[b], b if len(t) > 1 else 0
        o = b if len(out) > 1 else 0
        first, end = edges[b, 0], edges[b, 1]
        if c.form != codes.UNIFORM:
            continue
        if _is_beyond(c, t, t_low, k, first, end):
            return b
        for start in range(first, end, BLOCK):
            stop = min(start + BLOCK, end)
            n = stop - start
            times, low = t[k, start:stop], _lows(t_low, zeros, k, start, stop)
            uniform_block(c, d, times, low, block)
            start_sums(n, 21 if rates else 6, block)
            x, y, z = found_rows(block, n)
            for j in range(COLUMNS):
                uniform_column(d, j, block, x, y, z)
                add_products(n, block)
                if rates:
                    keep_turn(n, block)
                    uniform_rate_column(d, j, block, x, y, z)
                    add_products_of_rates(n, block)
            copy_sums(block, o, 0, start, stop, out)
    return -1
