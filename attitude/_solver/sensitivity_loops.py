"""Set-up and loops of sensitivities: bodies, blocks of epochs, columns.

Given
    constants  (B,) of records.CONSTANTS; those of another form are skipped
    tangents   (B,) of records.TANGENTS
    short      records of short_times
    numbers    (B,) that of each body, or -1 if no epoch is within its reach
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
from attitude._compilation.simd import finish_stores
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
    omega_of,
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
            _state(c, d, moments[b], four(wxyz[b]), to_body)
            fill_uniform(c, d, four(wxyz[b]), to_body)


@slowly_compiled
def tumbling_setup(moments, wxyz, principal, constants, tangents, block):
    """Fill tangents (B,) of records.TANGENTS, zeros at first, of those of B motions that tumble.

    Given
        moments    (B, 3, 2) principal moments, pairs, all above zero
        wxyz       (B, 4) body to inertial at the epoch, of any length
        principal  (1 or B, 4) principal axes to given body axes
        constants  (B,) of records.CONSTANTS
        block      (ROWS BLOCK,) working memory
    """
    epochs = np.zeros(2 * MOST_SPANS - 1)
    for b in range(len(constants)):
        c, d = constants[b], tangents[b]
        if c.fault == codes.FINE and c.form != codes.UNIFORM:
            to_body = four(principal[b if len(principal) > 1 else 0])
            inertia = _state(c, d, moments[b], four(wxyz[b]), to_body)
            if c.form == codes.HYPERBOLIC:
                (d.decay[0], d.decay[1]), d.nome = passage(c)
            derive(inertia, c, d.by_input)
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
                attitude_column(c, d, j, block, x, y, z)
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
    """Fill attitude, momentum, inverse inertia, axes at the epoch; n: moments scaled by 2^n."""
    inertia = math.frexp(max(moments[0, 0], moments[1, 0], moments[2, 0]))[1]
    d.moment_unit = math.ldexp(1.0, -inertia)
    start = unit(wxyz)
    for k in range(4):
        d.start[k] = start[k]
    omega = omega_of(c)
    to_inertial = product(start, to_body)
    momentum = turned_by(
        to_inertial,
        (c.moments[0, 0] * omega[0], c.moments[1, 0] * omega[1], c.moments[2, 0] * omega[2]),
    )
    for k in range(3):
        d.momentum[k] = momentum[k]
        d.inverse[k] = 1.0 / c.moments[k, 0]
        axis = turned_by(to_body, unit_vector(k))
        for i in range(3):
            d.principal[i, k] = axis[i]
    return inertia


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


@force_inlined
def no_fill(c, d, n, block):
    """The attitudes, or the angular velocities, of a block whose columns need none."""


def _loop_of(name, form, fill_block, fill_attitudes, fill_rates, has_rates, again_of, store):
    """The loop of the columns or covariances of a form, by the functions of both."""

    def loop(constants, tangents, short, numbers, t, t_low, block, out, rates, edges):
        fill_still_rows(block)
        zeros, with_rates = np.zeros(BLOCK), has_rates(out, rates)
        for b in range(len(constants)):
            c, d, k = constants[b], tangents[b], b if len(t) > 1 else 0
            first, end = edges[b, 0], edges[b, 1]
            if c.form != form:
                continue
            if _is_beyond(c, t, t_low, k, first, end):
                return b
            again, record = again_of(out, end - first), numbers[b]
            for start in range(first, end, BLOCK - again):
                stop = min(start + BLOCK - again, end)
                head = max(start - again, first)
                times, low = t[k, head:stop], _lows(t_low, zeros, k, head, stop)
                fill_block(c, d, times, low, block)
                by_series = record >= 0 and any_near(times, short[record].reach)
                if by_series or with_rates:
                    fill_attitudes(c, d, stop - head, block)
                if rates is not None and with_rates:
                    fill_rates(c, d, stop - head, block)
                series, spans = (short, record, by_series), (first, start, stop, end)
                store(c, d, series, b, block, spans, again, out, rates)
        finish_stores()
        return -1

    return slowly_compiled(named(loop, name))


@force_inlined
def _has_columns(out, rates):
    """Whether the changes of the angular velocity are to be filled beside those of attitude."""
    return rates is not None


@force_inlined
def _has_sums(out, rates):
    """Whether sums are of the changes of the angular velocity too."""
    return out.shape[1] == 6


@force_inlined
def _never_again(out, count):
    """As `epochs_again`, where nothing is stored past the caches."""
    return 0


@force_inlined
def _again_for_sums(out, count):
    """As `epochs_again`; sums of the changes of attitude alone need none."""
    return epochs_again(out, count) if out.shape[1] == 6 else 0


def _storing_columns(name, attitude_column, rate_column, by_lines):
    """The function that stores the columns of a block, by those that fill one.

    Columns of a uniform rotation are all filled: those by a turn are NaN where it has none.
    """
    still = TURNS if by_lines else 0

    def store(c, d, series, b, block, spans, again, attitude, omega):
        first, start, stop, _ = spans
        by_series = series[2]
        head = max(start - again, first)
        if by_lines and again and not by_series and not any_missing(stop - head, block):
            _stream(attitude_column, True, (c, d, b, block, spans, head), attitude)
            if omega is not None:
                _stream(rate_column, False, (c, d, b, block, spans, head), omega)
        else:
            filled = c, d, series, b, block, head, stop
            _store(attitude_column, near_column, True, still, filled, attitude)
            if omega is not None:
                _store(rate_column, near_rate_column, False, still, filled, omega)

    return force_inlined(named(store, name))


@force_inlined
def _store(column, near_column, turned, still, filled, out):
    """Store the columns of a block: of attitude, the first being unit vectors, or of rates."""
    c, d, (short, record, by_series), b, block, head, stop = filled
    row = b if len(out) > 1 else 0
    for j in range(out.shape[2]):
        x, y, z = rows_of(out, row, j, head, stop)
        if j < still:
            still_column(j if turned else -1, block, x, y, z)
            continue
        column(c, d, j, block, x, y, z)
        if by_series:
            near_column(d, short, record, j, block, x, y, z)


@force_inlined
def _stream(column, turned, filled, out):
    """As `_store`, past the caches: whole lines of them, and the ends of the rows."""
    c, d, b, block, spans, head = filled
    row, n = b if len(out) > 1 else 0, spans[2] - head
    for j in range(min(out.shape[2], TURNS)):
        x, y, z = still_rows(j if turned else -1, n, block)
        stream_rows(x, y, z, rows_of(out, row, j, 0, out.shape[3]), head, spans)
    x, y, z = found_rows(block, n)
    for j in range(TURNS, out.shape[2]):
        column(c, d, j, block, x, y, z)
        stream_rows(x, y, z, rows_of(out, row, j, 0, out.shape[3]), head, spans)


def _storing_sums(name, attitude_column, rate_column, triangular):
    """The function that stores the covariances of a block, by those that fill a column.

    Columns in triangular form are added at once; see `columns`.
    """

    def store(c, d, series, b, block, spans, again, out, rates):
        short, record, by_series = series
        o, length, flat = b if len(out) > 1 else 0, out.shape[3], out.reshape(out.size)
        first, start, stop, _ = spans
        n = stop - max(start - again, first)
        if triangular and not by_series and out.shape[1] == 3:
            whole = n - n % 8
            places, streams = places_of_rows(9 * o * length + start, length), has_whole_lines(out)
            sums_of_columns(c, d, block, 0, whole, places, flat, streams)
            if whole < n:
                sums_of_columns(c, d, block, whole, n, places_of_sums(), block, False)
                copy_sums(block, o, whole, start + whole, stop, out)
            return
        _sum(attitude_column, rate_column, (c, d, series, block, n), out.shape[1] == 6)
        if triangular:
            keep_near_sums(n, block)
            sums_of_columns(c, d, block, 0, n, places_of_sums(), block, False)
            if by_series:
                use_near_sums(n, short[record].reach, block)
        if again:
            stream_sums(block, o, spans, out)
        else:
            copy_sums(block, o, 0, start, stop, out)

    return force_inlined(named(store, name))


@force_inlined
def _sum(attitude_column, rate_column, filled, rates):
    """Sum the products of the columns of a block."""
    c, d, (short, record, by_series), block, n = filled
    start_sums(n, 21 if rates else 6, block)
    x, y, z = found_rows(block, n)
    for j in range(COLUMNS):
        attitude_column(c, d, j, block, x, y, z)
        if by_series:
            near_column(d, short, record, j, block, x, y, z)
        add_products(n, block)
        if rates:
            keep_turn(n, block)
            rate_column(c, d, j, block, x, y, z)
            if by_series:
                near_rate_column(d, short, record, j, block, x, y, z)
            add_products_of_rates(n, block)


_OF_UNIFORM = uniform_column, uniform_rate_column
_OF_TUMBLING = attitude_column, rate_column
_store_columns = _storing_columns("_store_columns", *_OF_TUMBLING, True)
_store_uniform = _storing_columns("_store_uniform", *_OF_UNIFORM, False)
_store_sums = _storing_sums("_store_sums", *_OF_TUMBLING, True)
_store_uniform_sums = _storing_sums("_store_uniform_sums", *_OF_UNIFORM, False)

_UNIFORM = codes.UNIFORM, uniform_block, no_fill, no_fill
_TRIGONOMETRIC = (
    codes.TRIGONOMETRIC,
    trigonometric_block,
    trigonometric_attitudes_block,
    trigonometric_rates_block,
)
_HYPERBOLIC = (
    codes.HYPERBOLIC,
    hyperbolic_block,
    hyperbolic_attitudes_block,
    hyperbolic_rates_block,
)
_COLUMNS = _has_columns, epochs_again, _store_columns
_SUMS = _has_sums, _again_for_sums, _store_sums
uniform = _loop_of("uniform", *_UNIFORM, _has_columns, _never_again, _store_uniform)
trigonometric = _loop_of("trigonometric", *_TRIGONOMETRIC, *_COLUMNS)
hyperbolic = _loop_of("hyperbolic", *_HYPERBOLIC, *_COLUMNS)
uniform_covariance = _loop_of(
    "uniform_covariance", *_UNIFORM, _has_sums, _never_again, _store_uniform_sums
)
trigonometric_covariance = _loop_of("trigonometric_covariance", *_TRIGONOMETRIC, *_SUMS)
hyperbolic_covariance = _loop_of("hyperbolic_covariance", *_HYPERBOLIC, *_SUMS)

# The loops of columns and of covariances of each form.
OF_FORM = {
    codes.UNIFORM: (uniform, uniform_covariance),
    codes.TRIGONOMETRIC: (trigonometric, trigonometric_covariance),
    codes.HYPERBOLIC: (hyperbolic, hyperbolic_covariance),
}
