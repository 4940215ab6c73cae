"""Set-up and loops of sensitivities: bodies, blocks of epochs, columns.

Given
    constants  (B,) of records.CONSTANTS; those of another form are skipped
    tangents   (B,) of records.TANGENTS
    short      records of short_times, or (0,) if no epoch is within its reach
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

from __future__ import annotations

import math

import numpy as np

from attitude._compilation.decorators import force_inlined, named, slowly_compiled, subroutine
from attitude._compilation.simd import LINE, finish_stores
from attitude._solver import codes
from attitude._solver.columns import (
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
    places_of_rows,
    places_of_sums,
    rate_column,
    rows_of,
    start_sums,
    still_column,
    still_rows,
    stream_rows,
    stream_sums,
    sums_of_columns,
    use_near_sums,
)
from attitude._solver.derivatives import derive, passage
from attitude._solver.kernel import any_beyond, product, reach, turned_by, unit
from attitude._solver.records import (
    BLOCK,
    COLUMNS,
    FOUND,
    NOME,
    PASSED,
    PHASE,
    RATE,
    SECOND,
    THIRD,
    TIME,
    TURNS,
)
from attitude._solver.series import four
from attitude._solver.short_times import (
    MOST_SPANS,
    any_near,
    fill_slow,
    near_column,
    near_rate_column,
    span_of,
)
from attitude._solver.tangents import (
    fill_hyperbolic,
    fill_rates,
    fill_trigonometric,
    hyperbolic_attitudes_block,
    hyperbolic_block,
    hyperbolic_rates_block,
    trigonometric_attitudes_block,
    trigonometric_block,
    trigonometric_rates_block,
)
from attitude._solver.uniform_tangents import (
    fill_uniform,
    uniform_block,
    uniform_column,
    uniform_rate_column,
    unit_vector,
)

# ---- Set-up of the sensitivity: one record of `TANGENTS` for each motion
# Terms so many times as large as their sum leave errors above 4e-15 of it.
_CANCELS = 4.0
# The same for 4e-12, which steps of least squares do not feel.
_CANCELS_MUCH = 4000.0


@slowly_compiled
def uniform_setup(moments, wxyz, principal, constants, tangents):
    """Fill the records of those of B motions that rotate uniformly; as `tumbling_setup`."""
    for b in range(len(constants)):
        c, d = constants[b], tangents[b]
        if c.fault == codes.FINE and c.form == codes.UNIFORM:
            to_body = four(principal[b if len(principal) > 1 else 0])
            of_moments = moments[b, 0, 0], moments[b, 1, 0], moments[b, 2, 0]
            _state(c, d, of_moments, four(wxyz[b]), to_body)
            fill_uniform(c, d, of_moments, four(wxyz[b]), to_body)


@slowly_compiled
def tumbling_setup(moments, wxyz, principal, constants, tangents, block):
    """Fill the records of those of B motions that tumble.

    Given
        moments    (B, 3, 2) principal moments, pairs, all above zero
        wxyz       (B, 4) body to inertial at the epoch, of any length
        principal  (1 or B, 4) principal axes to given body axes
        constants  (B,) of records.CONSTANTS.CONSTANTS
        block      (ROWS BLOCK,) working memory
    Filled
        tangents   (B,) of records.TANGENTS, zeros at first
    """
    epochs = np.zeros(2 * MOST_SPANS - 1)
    for b in range(len(constants)):
        c, d = constants[b], tangents[b]
        if c.fault == codes.FINE and c.form != codes.UNIFORM:
            to_body = four(principal[b if len(principal) > 1 else 0])
            of_moments = moments[b, 0, 0], moments[b, 1, 0], moments[b, 2, 0]
            _state(c, d, of_moments, four(wxyz[b]), to_body)
            _passage(c, d)
            derive(math.frexp(max(of_moments[0], of_moments[1], of_moments[2]))[1], c, d.by_input)
            _invariant(c.frame, d.invariant)
            _weights(c, d)
            fill_rates(c, d)
            count, span = len(epochs), span_of(c)
            for k in range(1, MOST_SPANS):
                epochs[2 * k - 1], epochs[2 * k] = k * span, -k * span
            if c.form == codes.TRIGONOMETRIC:
                fill_trigonometric(c, d.series, d.upright, False)
                fill_slow(c, d)
                trigonometric_block(c, d, epochs, None, block)
            else:
                fill_hyperbolic(c, d, d.series, d.upright)
                hyperbolic_block(c, d, epochs, None, block)
                d.passed = block[PASSED]
                for i in range(count):
                    block[PASSED + i] -= d.passed
            x, y, z = found_rows(block, count)
            d.spans[0], d.spans[1] = 1, 0
            for j in range(COLUMNS):
                attitude_column(d, j, block, x, y, z)
                for k in range(3):
                    d.offset[k, j] = (1.0 if j == k else 0.0) - block[FOUND + k * BLOCK]
                if j >= TURNS and d.slow[0] == 0.0:
                    _count_spans(d, j, epochs[:count], block)


@subroutine
def _count_spans(d, j, epochs, block):
    """Raise the spans of `short_times` to those beyond which terms of a column do not cancel."""
    weights = d.weights
    still = abs(weights[PHASE, j]) + abs(weights[SECOND, j]) + abs(weights[THIRD, j])
    grows = abs(weights[RATE, j]) + abs(weights[TIME, j])
    for i in range(1, len(epochs)):
        x = abs(block[FOUND + i] + d.offset[0, j])
        y = abs(block[FOUND + BLOCK + i] + d.offset[1, j])
        z = abs(block[FOUND + 2 * BLOCK + i] + d.offset[2, j])
        terms, largest = still + grows * abs(epochs[i]), max(x, y, z)
        spans = 1 + (i + 1) // 2
        if terms > _CANCELS * largest:
            d.spans[0] = max(d.spans[0], spans)
        if terms > _CANCELS_MUCH * largest:
            d.spans[1] = max(d.spans[1], spans)


@subroutine
def _state(c, d, moments, wxyz, to_body):
    """Fill attitude and momentum at the epoch, inverse inertia and principal axes."""
    start = unit(wxyz)
    for k in range(4):
        d.start[k] = start[k]
    omega = (
        math.ldexp(c.omega[0, 0], c.tempo),
        math.ldexp(c.omega[1, 0], c.tempo),
        math.ldexp(c.omega[2, 0], c.tempo),
    )
    to_inertial = product(start, to_body)
    momentum = turned_by(
        to_inertial, (moments[0] * omega[0], moments[1] * omega[1], moments[2] * omega[2])
    )
    for k in range(3):
        d.momentum[k] = momentum[k]
        d.inverse[k] = 1.0 / moments[k]
        _put(d.principal, k, turned_by(to_body, unit_vector(k)))


@subroutine
def _passage(c, d):
    """Fill decay and nome of the hyperbolic form."""
    if c.form == codes.HYPERBOLIC:
        (d.decay[0], d.decay[1]), d.nome = passage(c)


@subroutine
def _put(matrix, column, v):
    for k in range(3):
        matrix[k, column] = v[k]


@subroutine
def _invariant(frame, invariant):
    """Fill the axes of the solution: frame is q -> l q r, and l e l* = (l e r)(l r)*."""
    w, x, y, z = frame[0, 0], -frame[1, 0], -frame[2, 0], -frame[3, 0]
    for k in range(3):
        column = frame[0, k + 1], frame[1, k + 1], frame[2, k + 1], frame[3, k + 1]
        axis = product(column, (w, x, y, z))
        for i in range(3):
            invariant[i, k] = axis[1 + i]


@subroutine
def _weights(c, d):
    """Fill the weights of the six columns of angular velocity and moments, and `by_third`."""
    by_input, weights, largest = d.by_input, d.weights, 0.0
    for k in range(6):
        j = 3 + k
        weights[TIME, j] = by_input[0, k]
        weights[RATE, j] = by_input[1, k]
        weights[PHASE, j] = by_input[2, k]
        weights[NOME, j] = by_input[7, k]
        for row in range(3):
            d.amplitudes[row, j] = by_input[8 + row, k]
        if c.form == codes.TRIGONOMETRIC:
            weights[SECOND, j] = by_input[3, k]
            weights[THIRD, j] = by_input[4, k]
            continue
        weights[SECOND, j] = by_input[4, k]
        third = weights[THIRD, j] = by_input[5, k]
        winds = c.winds != 0.0  # on the exact separatrix nothing passes
        if abs(third) > largest:
            # ln K' and K pi/(2K') depend on Q' alone: the ratio is that of all columns
            largest = abs(third)
            d.by_third[0] = by_input[3, k] / third
            d.by_third[1] = by_input[6, k] / third if winds else 0.0


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


def _columns_of(name, form, fill_block, fill_attitudes, fill_rates):
    """The loop of the columns of a form of motions that tumble; see the module docstring.

    The functions fill a block with the changes of attitude, the attitudes, and the changes of the
    angular velocity.
    """

    def loop(constants, tangents, short, t, t_low, block, attitude, omega, edges):
        fill_still_rows(block)
        zeros = np.zeros(BLOCK)
        for b in range(len(constants)):
            c, d, k = constants[b], tangents[b], b if len(t) > 1 else 0
            first, end = edges[b, 0], edges[b, 1]
            if c.form != form:
                continue
            if _is_beyond(c, t, t_low, k, first, end):
                return b
            again = epochs_again(attitude, end - first)
            for start in range(first, end, BLOCK - again):
                stop = min(start + BLOCK - again, end)
                head = max(start - again, first)
                times, low = t[k, head:stop], _lows(t_low, zeros, k, head, stop)
                fill_block(c, d, times, low, block)
                by_series = len(short) > 0 and any_near(times, short[b].reach)
                if by_series or omega is not None:
                    fill_attitudes(c, stop - head, block)
                if omega is not None:
                    fill_rates(c, d, stop - head, block)
                if again and not by_series and not any_missing(stop - head, block):
                    _stream(d, b, block, (first, start, stop, end), attitude)
                    if omega is not None:
                        _stream_rates(c, d, b, block, (first, start, stop, end), omega)
                else:
                    _store(d, short, b, by_series, block, (head, stop), attitude)
                    if omega is not None:
                        _store_rates(c, d, short, b, by_series, block, (head, stop), omega)
        finish_stores()
        return -1

    return slowly_compiled(named(loop, name))


trigonometric = _columns_of(
    "trigonometric",
    codes.TRIGONOMETRIC,
    trigonometric_block,
    trigonometric_attitudes_block,
    trigonometric_rates_block,
)
hyperbolic = _columns_of(
    "hyperbolic",
    codes.HYPERBOLIC,
    hyperbolic_block,
    hyperbolic_attitudes_block,
    hyperbolic_rates_block,
)


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
            near_column(d, short, b, j, block, x, y, z)


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
            near_rate_column(short, b, j, block, x, y, z)


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
            by_series = len(short) > 0 and any_near(times, short[b].reach)
            for j in range(columns):
                x, y, z = rows_of(attitude, o, j, start, stop)
                uniform_column(d, j, block, x, y, z)
                if omega is not None:
                    x, y, z = rows_of(omega, o, j, start, stop)
                    uniform_rate_column(d, j, block, x, y, z)
            if by_series:
                for j in range(columns):
                    x, y, z = rows_of(attitude, o, j, start, stop)
                    near_column(d, short, b, j, block, x, y, z)
                    if omega is not None:
                        x, y, z = rows_of(omega, o, j, start, stop)
                        near_rate_column(short, b, j, block, x, y, z)
    return -1


def _covariances_of(name, form, fill_block, fill_attitudes, fill_rates):
    """The loop of the covariances of a form of motions that tumble, as `_columns_of`."""

    def loop(constants, tangents, short, t, t_low, block, out, edges):
        rates, zeros = out.shape[1] == 6, np.zeros(BLOCK)
        for b in range(len(constants)):
            c, d, k = constants[b], tangents[b], b if len(t) > 1 else 0
            first, end = edges[b, 0], edges[b, 1]
            if c.form != form:
                continue
            if _is_beyond(c, t, t_low, k, first, end):
                return b
            again = epochs_again(out, end - first) if rates else 0
            for start in range(first, end, BLOCK - again):
                stop = min(start + BLOCK - again, end)
                head = max(start - again, first)
                n = stop - head
                times, low = t[k, head:stop], _lows(t_low, zeros, k, head, stop)
                fill_block(c, d, times, low, block)
                by_series = len(short) > 0 and any_near(times, short[b].reach)
                if by_series or rates:
                    fill_attitudes(c, n, block)
                if rates:
                    fill_rates(c, d, n, block)
                _store_covariances(
                    c, d, short, b, by_series, block, (first, start, stop, end), again, out
                )
        finish_stores()
        return -1

    return slowly_compiled(named(loop, name))


trigonometric_covariance = _covariances_of(
    "trigonometric_covariance",
    codes.TRIGONOMETRIC,
    trigonometric_block,
    trigonometric_attitudes_block,
    trigonometric_rates_block,
)
hyperbolic_covariance = _covariances_of(
    "hyperbolic_covariance",
    codes.HYPERBOLIC,
    hyperbolic_block,
    hyperbolic_attitudes_block,
    hyperbolic_rates_block,
)


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
            near_column(d, short, b, j, block, x, y, z)
        add_products(n, block)
        if rates:
            keep_turn(n, block)
            rate_column(c, d, j, block, x, y, z)
            if near:
                near_rate_column(short, b, j, block, x, y, z)
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
            by_series = len(short) > 0 and any_near(times, short[b].reach)
            start_sums(n, 21 if rates else 6, block)
            x, y, z = found_rows(block, n)
            for j in range(COLUMNS):
                uniform_column(d, j, block, x, y, z)
                if by_series:
                    near_column(d, short, b, j, block, x, y, z)
                add_products(n, block)
                if rates:
                    keep_turn(n, block)
                    uniform_rate_column(d, j, block, x, y, z)
                    if by_series:
                        near_rate_column(short, b, j, block, x, y, z)
                    add_products_of_rates(n, block)
            copy_sums(block, o, 0, start, stop, out)
    return -1
