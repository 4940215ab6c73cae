"""Sensitivity at epochs near that of the state, by Taylor series of Euler's equations.

Where the polhode is slow, beside a sphere or the equator of a symmetric body, the elements change
strongly with the moments, and the columns of columns are small differences of large
numbers.  Within a fifth of the radius of convergence, K'/wp, or less, the changes are polynomials
in t:

    w' = c w w,    (dw)' = c (dw w + w dw) + dc w w,    zeta' = n dw,    n = L/|L|

With M = I w and dM = I dw + dI w over the body axes, whose product vanishes term by term where the
column does, and R the attitude,

    eta = eta(0) + (R0 (M x dM)(0) - R M x dM) / L^2 + zeta n.

Within two radians of the rotation the difference is small itself, and eta one polynomial after the
other: eta' = R dw.  Uniform rotations have their own columns beyond a radian
(solution.uniform_tangents).
"""

from __future__ import annotations

import math

import numpy as np

from attitude._compilation.decorators import force_inlined, slowly_compiled, subroutine
from attitude._compilation.instructions import fma
from attitude._compilation.simd import Lanes, doubles_of, eight, lanes, put_eight
from attitude._solver import codes
from attitude._solver.columns import four_at
from attitude._solver.derivatives import ellipticity, state_of
from attitude._solver.elliptic import integrals
from attitude._solver.kernel import turned_by
from attitude._solver.records import (
    ARGUMENTS,
    COLUMNS,
    PHASE,
    RATE,
    SECOND,
    SECONDS,
    THIRD,
    WXYZ,
)
from attitude._solver.series import four, sincos
from attitude._solver.tangents import fast_vectors, fill_trigonometric, in_inertial
from attitude._solver.twofloat import pair, scale, sub
from attitude._solver.uniform_tangents import couplings_of, forced, unit_vector

# Beyond, the terms, which have poles of third order, are below 28^2 0.2^28 = 2e-17 of the first;
# those of eta, which is integrated from products with the rotation, below 4e-16.
TERMS = 28
_SHARE = 0.2
# K' counts as no more than this: the functions of a symmetric body have no pole, but their products
# have twice the frequency, and a term of this order below 1e-17 of the largest within 0.8 rad.
_FARTHEST = 3.6
# Radians within which eta is by polynomials: 2^28/28! is 1e-21.  The difference would be 6.7e-15
# off after 0.8 of them, 2e-15 after two.
_SOON = 2.0
# Series to either side, each about the end of that before, of motions whose terms cancel longest:
# up to 2.2 K'/wp.
MOST_SPANS = 11
# The precession of a needle over the turns about its length, and its ellipticity, below which the
# precession is slow, and the angle (rad) within which it cancels.
_SLOW = 0.1
_FAR = 2.5

# Rows of a series: M x dM (3) and change of the angular velocity (3) over the body axes, zeta, and
# eta (3) over the inertial axes.
ROWS_OF_SERIES = 10
_ZETA = 6
_ETA = 7

# The first records are those of motions; those of the spans that follow stand after them, the later
# ones of a motion first, then the earlier ones.
SHORT: np.dtype[np.void] = np.dtype(
    [
        ("reach", "f8"),  # seconds to either side within which the series of the motion hold
        ("span", "f8"),  # seconds to either side of its centre within which one series holds
        ("centre", "f8"),  # seconds
        ("spans", "i8", 2),  # series later and earlier, that of the epoch counted in both
        ("next", "i8"),  # the record of the span after that of the epoch
        ("motion", "i8"),
        ("soon", "f8"),  # seconds to either side of the epoch within which eta is by its series
        ("unit", "f8"),  # of the time in the series of eta, s
        # a needle: series without slow parts and the slow one at the epoch, its x and y; what the
        # series give at the epoch, and their change with time there
        ("fast", "f8", (8, 5)),
        ("lead", "f8", 2),
        ("first", "f8", (3, 3)),
        ("drift", "f8", (3, 3)),
        ("series", "f8", (ROWS_OF_SERIES, COLUMNS, TERMS)),
    ]
)

# The first column that changes with time, after those of the attitude.
_FIRST = 3
_CHANGING = COLUMNS - _FIRST
# These columns are computed side by side in the first lanes of vectors: one sum alone waits for
# each of its additions.
_LANES = 8
# Rows of a state over the principal axes, after the angular velocity: its change with each
# parameter and zeta.
_CHANGES = 1
# By how much half of its squares have dropped since the epoch.
_DROPS = 1 + COLUMNS
_ROWS_OF_STATE = 2 + COLUMNS


@slowly_compiled
def spans_of(constants, out):
    """Fill the seconds (B,) to either side of the epoch within which one series holds; -1: none."""
    for b in range(len(constants)):
        c = constants[b]
        out[b] = -1.0
        if c.fault != codes.FINE:
            continue
        if c.form == codes.UNIFORM:
            speed = _speed(c)
            # no frequency of the columns is above 2 w
            if speed > 0.0:
                out[b] = math.ldexp(1.0 / speed, -c.tempo)
        else:
            out[b] = span_of(c)


@slowly_compiled
def reaches(tangents, by_series, out):
    """Fill the seconds (B,) within which the series hold, or a needle precesses slowly."""
    for b in range(len(tangents)):
        out[b] = max(by_series[b], slow_reach(tangents[b]))


@subroutine
def span_of(c):
    """The seconds to either side of an epoch within which a series of a tumbling motion holds."""
    state = state_of(c)
    speed, (m, mc) = state[6], state[7]
    quarter = _FARTHEST
    if m > 1e-9:
        quarter = min(quarter, integrals(mc, m)[0])
    return math.ldexp(_SHARE * quarter / speed, -c.tempo)


@slowly_compiled
def farthest_near(t, edges, reach, out):
    """Fill the largest |t| (B, 2) within reach (B,) of the later and of the earlier epochs.

    -1 where there is none.  Epochs (1 or B, T) of a body stand between two edges (B, 2).
    """
    for b in range(len(reach)):
        k, later, earlier = b if len(t) > 1 else 0, -1.0, -1.0
        for i in range(edges[b, 0], edges[b, 1]):
            seconds = t[k, i]
            if abs(seconds) <= reach[b]:
                later = max(later, seconds) if seconds >= 0.0 else later
                earlier = max(earlier, -seconds) if seconds <= 0.0 else earlier
        out[b, 0], out[b, 1] = later, earlier


@slowly_compiled
def short_setup(constants, tangents, motions, span, spans, out):
    """Fill out (M + sum of (spans - 1),), series of SHORT of M of B motions; none of one at rest.

    motions (M,) are numbers of the motions, span (B,) of `spans_of`, spans (M, 2) numbers of series
    to later and to earlier epochs.
    """
    w, turn = np.zeros(3 * TERMS), np.zeros(3 * TERMS * _LANES)
    dw, momentum = np.zeros(3 * TERMS * _LANES), np.zeros(3 * TERMS * _LANES)
    axes = np.zeros((2, 3, 3))
    state, ends = np.zeros((_ROWS_OF_STATE, 4)), np.zeros((2, _ROWS_OF_STATE, 4))
    again = np.zeros((2, _ROWS_OF_STATE, 4))
    place = len(motions)
    for number in range(len(motions)):
        b = motions[number]
        c, d, s = constants[b], tangents[b], out[number]
        s.span, s.next, s.motion = span[b], place, b
        s.spans[0], s.spans[1] = spans[number, 0], spans[number, 1]
        s.reach = max(span[b] * max(s.spans[0], s.spans[1]), slow_reach(d))
        if span[b] <= 0.0:
            continue
        moments = 1.0 / d.inverse[0], 1.0 / d.inverse[1], 1.0 / d.inverse[2]
        _start(c, d, s, state, axes[0])
        if d.slow[0] != 0.0:
            _fill_fast(c, d, s)
        _fill(c, d, moments, state, w, dw, momentum, ends, s)
        _turn(w, axes[0], turn, s)
        _store_eta(d, turn, dw, s)
        for side in range(2):
            _ends_of(turn, side, axes[side])
        for side in range(2):
            _copy(ends[side], state)
            for k in range(1, spans[number, side]):
                before, later = out[number if k == 1 else place - 1], out[place]
                later.span, later.motion, later.unit = span[b], b, span[b]
                later.centre = span[b] * (k if side == 0 else -k)
                for j in range(COLUMNS):
                    later.series[_ZETA, j, 1] = s.series[_ZETA, j, 1] if j < 6 else 0.0
                _fill(c, d, moments, state, w, dw, momentum, again, later)
                _copy(again[side], state)
                if k * span[b] < s.soon:
                    for j in range(COLUMNS):
                        for i in range(3):
                            end = _at_end(before.series[_ETA + i, j], side)
                            later.series[_ETA + i, j, 0] = end
                    _turn(w, axes[side], turn, later)
                    _store_eta(d, turn, dw, later)
                    _ends_of(turn, side, axes[side])
                place += 1


@subroutine
def _copy(source, target):
    """Copy a state; an assignment of arrays would compile the sentence of an error, for seconds."""
    for k in range(_ROWS_OF_STATE):
        for i in range(4):
            target[k, i] = source[k, i]


@subroutine
def _start(c, d, s, state, axes):
    """Fill what a motion has at its epoch, and within which time it turns by two radians.

    `axes` (3, 3) turns principal to inertial axes.
    """
    start = four(d.start)
    for j in range(3):
        column = turned_by(start, (d.principal[0, j], d.principal[1, j], d.principal[2, j]))
        for i in range(3):
            axes[i, j] = column[i]
        s.series[_ETA + j, j, 0] = 1.0
    s.soon = math.ldexp((1.0 if c.form == codes.UNIFORM else _SOON) / _speed(c), -c.tempo)
    s.unit = min(s.span, s.soon)
    state[:] = 0.0
    lx, ly, lz = d.momentum[0], d.momentum[1], d.momentum[2]
    over = s.span / math.sqrt(lx * lx + ly * ly + lz * lz)
    for i in range(3):
        state[0, i] = math.ldexp(c.omega[i, 0], c.tempo)
        for j in range(3, 6):
            state[_CHANGES + j, i] = d.principal[j - 3, i]
            # n dw by the energy, whose change is that of the epoch, I w dw
            s.series[_ZETA, j, 1] += over * state[0, i] / d.inverse[i] * d.principal[j - 3, i]


@subroutine
def _speed(c):
    """The scaled angular velocity's size."""
    x, y, z = c.omega[0, 0], c.omega[1, 0], c.omega[2, 0]
    return math.sqrt(x * x + y * y + z * z)


@subroutine
def _fill(c, d, moments, state, w, dw, momentum, ends, s):
    """Fill a series from the state at its centre, and the states at its later and earlier end."""
    pairs = couplings_of(c)
    k = pairs[0][0], pairs[1][0], pairs[2][0]
    ones = 1.0, 1.0, 1.0
    one, two = forced(k, ones, moments, 0), forced(k, ones, moments, 1)
    three, unit = forced(k, ones, moments, 2), d.moment_unit
    for i in range(3):
        w[i * TERMS] = state[0, i]
        for j in range(_CHANGING):
            dw[_LANES * i * TERMS + j] = state[_CHANGES + _FIRST + j, i]
    for n in range(TERMS - 1):
        over = s.span / (n + 1.0)
        for i in range(3):
            left, right = (i + 1) % 3, (i + 2) % 3
            square = _product(w, w, left, right, n)
            w[i * TERMS + n + 1] = over * k[i] * square
            more = _sums(dw, left, w, TERMS * right, 1, n) + _products(w, left, dw, right, n)
            change = lanes((0.0, 0.0, 0.0, unit * one[i], unit * two[i], unit * three[i], 0.0, 0.0))
            more = more * k[i] + change * square
            put_eight(dw, _LANES * (i * TERMS + n + 1), over * more)
    for side in range(2):
        for i in range(3):
            ends[side, 0, i] = _at_end(w[i * TERMS : (i + 1) * TERMS], side)
            columns = doubles_of(_ends(dw, i, side))
            for j in range(_CHANGING):
                ends[side, _CHANGES + _FIRST + j, i] = columns[j]
    _store(d, moments, w, dw, momentum, s)
    size = math.sqrt(d.momentum[0] ** 2 + d.momentum[1] ** 2 + d.momentum[2] ** 2)
    for j in range(_FIRST, COLUMNS):
        _store_zeta(w, j, unit, size, state, ends, s)


@subroutine
def _products(a, i, b, j, n):
    """Coefficient n of the products of a series with those of the columns."""
    first, at = i * TERMS, _LANES * (j * TERMS + n)
    total = a[first] * eight(b, at)
    for k in range(1, n + 1):
        at -= _LANES
        total = total + a[first + k] * eight(b, at)
    return total


@_products.for_python
def _products_at_once(a, i, b, j, n):
    """As `_products`, in the same order."""
    one = a[i * TERMS : i * TERMS + n + 1, None]
    return Lanes(np.sum(one * _rows(b, j)[n::-1], axis=0))


@subroutine
def _sums(b, j, a, first, step, n):
    """As `_products`, from the first term of the columns on; terms of `a` stand so far apart."""
    at, place = _LANES * j * TERMS, first + step * n
    total = a[place] * eight(b, at)
    for k in range(1, n + 1):
        total = total + a[place - step * k] * eight(b, at + _LANES * k)
    return total


@_sums.for_python
def _sums_at_once(b, j, a, first, step, n):
    """As `_sums`, in the same order."""
    one = a[first : first + step * n + 1 : step][::-1, None]
    return Lanes(np.sum(one * _rows(b, j)[: n + 1], axis=0))


def _rows(b, j):
    """Series j as an array (TERMS, lanes)."""
    return b[_LANES * j * TERMS : _LANES * (j + 1) * TERMS].reshape(TERMS, _LANES)


@subroutine
def _ends(a, i, side):
    """The sums of the series of the columns at their later (0) or earlier end (1)."""
    at, x = _LANES * ((i + 1) * TERMS - 1), 1.0 if side == 0 else -1.0
    total = eight(a, at)
    for n in range(1, TERMS):
        total = total * x + eight(a, at - _LANES * n)
    return total


@_ends.for_python
def _ends_at_once(a, i, side):
    """As `_ends`, in the same order."""
    total, x = np.zeros(_LANES), 1.0 if side == 0 else -1.0
    for row in _rows(a, i)[::-1]:
        total = total * x + row
    return Lanes(total)


@subroutine
def _at_end(a, side):
    """The sum of a series at its later (0) or earlier end (1)."""
    total, x = a[TERMS - 1], 1.0 if side == 0 else -1.0
    for n in range(TERMS - 2, -1, -1):
        total = total * x + a[n]
    return total


@subroutine
def _turn(w, axes, turn, s):
    """Columns of the turn, principal to inertial, from those at 0, in t / s.unit: R' = R w x."""
    for j in range(3):
        for i in range(3):
            turn[_LANES * j * TERMS + i] = axes[i, j]
    share = s.unit / s.span
    for n in range(TERMS - 1):
        over = s.unit / (n + 1.0)
        for j in range(3):
            left, right = (j + 1) % 3 * TERMS, (j + 2) % 3 * TERMS
            change = over * _turning(turn, w, left, right, share, n)
            put_eight(turn, _LANES * (j * TERMS + n + 1), change)


@subroutine
def _turning(turn, w, left, right, share, n):
    """Coefficient n of a column of R w x, from the columns and rates that begin at left, right."""
    total, power = 0.0 * eight(turn, 0), 1.0
    for k in range(n + 1):
        more = eight(turn, _LANES * (left + n - k)) * w[right + k]
        more = more - eight(turn, _LANES * (right + n - k)) * w[left + k]
        total = total + power * more
        power *= share
    return total


@_turning.for_python
def _turning_at_once(turn, w, left, right, share, n):
    """As `_turning`, in the same order."""
    columns = turn.reshape(-1, _LANES)
    powers = np.multiply.accumulate(np.concatenate([[1.0], np.full(n, share)]))[:, None]
    more = columns[left : left + n + 1][::-1] * w[right : right + n + 1, None]
    more -= columns[right : right + n + 1][::-1] * w[left : left + n + 1, None]
    return Lanes(np.sum(powers * more, axis=0))


@subroutine
def _ends_of(turn, side, axes):
    """Fill the rotation (3, 3) at the later (0) or earlier end (1) of a series."""
    for j in range(3):
        column = doubles_of(_ends(turn, j, side))
        for i in range(3):
            axes[i, j] = column[i]


@subroutine
def _store_eta(d, turn, dw, s):
    """Fill the series of eta in t / s.unit, from those at 0: eta' = R dw."""
    share, power = s.unit / s.span, 1.0
    for k in range(TERMS):
        for j in range(_CHANGING):
            column = _FIRST + j
            x, y, z = s.series[3, column, k], s.series[4, column, k], s.series[5, column, k]
            for m in range(3):
                change = d.principal[0, m] * x + d.principal[1, m] * y + d.principal[2, m] * z
                dw[_LANES * (m * TERMS + k) + j] = power * change
        power *= share
    for n in range(TERMS - 1):
        over = s.unit / (n + 1.0)
        for i in range(3):
            total = _sums(dw, 0, turn, i, _LANES, n)
            total = total + _sums(dw, 1, turn, _LANES * TERMS + i, _LANES, n)
            total = total + _sums(dw, 2, turn, 2 * _LANES * TERMS + i, _LANES, n)
            _put(over * total, s.series, _ETA + i, n + 1)


@_store_eta.for_python
def _store_eta_at_once(d, turn, dw, s):
    """As `_store_eta`, with sums in the same order."""
    share = s.unit / s.span
    powers = np.multiply.accumulate(np.concatenate([[1.0], np.full(TERMS - 1, share)]))[:, None]
    rates, axes = s.series[3:6, _FIRST:], d.principal
    total = 0.0
    for m in range(3):
        change = axes[0, m] * rates[0] + axes[1, m] * rates[1] + axes[2, m] * rates[2]
        columns = np.zeros((TERMS, _LANES))
        columns[:, :_CHANGING] = powers * change.T
        total = total + np.stack([_cauchy_sums(_rows(turn, m)[:, i], columns) for i in range(3)])
    over = (s.unit / np.arange(1.0, TERMS))[:, None]
    s.series[_ETA:, _FIRST:, 1:] = (over * total[:, :-1, :_CHANGING]).swapaxes(1, 2)


@subroutine
def _put(values, series, row, n):
    """Store the columns of a term of a series."""
    columns = doubles_of(values)
    for j in range(_CHANGING):
        series[row, _FIRST + j, n] = columns[j]


@subroutine
def _product(a, b, i, j, n):
    """Coefficient n of the product of two series."""
    total = 0.0
    for k in range(n + 1):
        total += a[i * TERMS + k] * b[j * TERMS + n - k]
    return total


@_product.for_python
def _product_of_lists(a, b, i, j, n):
    """As `_product`: elements of lists are read five times as fast as those of arrays."""
    one, two = a[i * TERMS : i * TERMS + n + 1].tolist(), b[j * TERMS : j * TERMS + n + 1].tolist()
    total = 0.0
    for x, y in zip(one, reversed(two), strict=True):
        total += x * y
    return total


@subroutine
def _store(d, moments, w, dw, momentum, s):
    """Fill the series of the columns from those over the principal axes."""
    series, axes = s.series, d.principal
    for i in range(3):
        x, y, z = unit_vector(i)
        unit = lanes(
            (0.0, 0.0, 0.0, d.moment_unit * x, d.moment_unit * y, d.moment_unit * z, 0.0, 0.0)
        )
        for n in range(TERMS):
            at = _LANES * (i * TERMS + n)
            put_eight(momentum, at, moments[i] * eight(dw, at) + w[i * TERMS + n] * unit)
    for n in range(TERMS):
        x = _across(moments, w, momentum, 1, 2, n)
        y = _across(moments, w, momentum, 2, 0, n)
        z = _across(moments, w, momentum, 0, 1, n)
        u, v = eight(dw, _LANES * n), eight(dw, _LANES * (TERMS + n))
        t = eight(dw, _LANES * (2 * TERMS + n))
        for k in range(3):
            _put(axes[k, 0] * x + axes[k, 1] * y + axes[k, 2] * z, series, k, n)
            _put(axes[k, 0] * u + axes[k, 1] * v + axes[k, 2] * t, series, 3 + k, n)


@_store.for_python
def _store_at_once(d, moments, w, dw, momentum, s):
    """As `_store`, with sums in the same order."""
    rates, turning = [_rows(dw, i) for i in range(3)], [w[i * TERMS :][:TERMS] for i in range(3)]
    momenta = []
    for i in range(3):
        unit = np.zeros(_LANES)
        unit[_FIRST + i] = d.moment_unit
        momenta.append(moments[i] * rates[i] + turning[i][:, None] * unit)
    across = []
    for i, j in ((1, 2), (2, 0), (0, 1)):
        one = moments[i] * _cauchy_products(turning[i], momenta[j])
        across.append(one - moments[j] * _cauchy_products(turning[j], momenta[i]))
    for k in range(3):
        x, y, z = d.principal[k]
        for row, (a, b, c) in ((k, across), (3 + k, rates)):
            s.series[row, _FIRST:] = (x * a + y * b + z * c).T[:_CHANGING]


def _cauchy_products(a, rows):
    """All coefficients of the products of a series with those of the columns."""
    total = a[0] * rows
    for k in range(1, TERMS):
        total[k:] += a[k] * rows[:-k]
    return total


def _cauchy_sums(a, rows):
    """As `_cauchy_products`, from the first term of the columns on."""
    total = a[:, None] * rows[0]
    for k in range(1, TERMS):
        total[k:] += a[:-k, None] * rows[k]
    return total


@subroutine
def _across(moments, w, momentum, i, j, n):
    """A component of term n of M x dM of the columns, from the two others."""
    one = moments[i] * _products(w, i, momentum, j, n)
    return one - moments[j] * _products(w, j, momentum, i, n)


@subroutine
def _store_zeta(w, j, unit, size, state, ends, s):
    """Fill the series of zeta of one column: n dw by the energy, whose change is constant.

    For velocities I w dw is that of the epoch, for moments I w dw + w^2/2 is.
    """
    s.series[_ZETA, j, 0] = state[_CHANGES + j, 3]
    if j >= 6:
        m = j - 6
        s.series[_ZETA, j, 1] = s.span / size * state[_DROPS, m]
        for side in range(2):
            ends[side, _DROPS, m] = state[_DROPS, m]
        for n in range(1, TERMS):
            change = -0.5 * unit * _product(w, w, m, m, n)
            ends[0, _DROPS, m] += change
            ends[1, _DROPS, m] += change if n % 2 == 0 else -change
            if n < TERMS - 1:
                s.series[_ZETA, j, n + 1] = s.span * change / (size * (n + 1.0))
    for side in range(2):
        ends[side, _CHANGES + j, 3] = _at_end(s.series[_ZETA, j], side)


@subroutine
def any_near(t, reach):
    """Whether any epoch of a block is within reach."""
    within = 0
    for i in range(len(t)):
        within |= abs(t[i]) <= reach
    return within != 0


@subroutine
def _sum(series, row, j, x):
    total = series[row, j, TERMS - 1]
    for n in range(TERMS - 2, -1, -1):
        total = fma(total, x, series[row, j, n])
    return total


@subroutine
def fill_slow(c, d):
    """Fill the precession of a needle where it is slow beside the turns about its length."""
    slow = sub(scale(pair(c.precession), 2.0), pair(c.nutation))
    if abs(slow[0]) < _SLOW * abs(c.nutation[0]) and ellipticity(c)[0] < _SLOW:
        d.slow[0], d.slow[1] = slow


@subroutine
def slow_reach(d):
    """s to either side of the epoch in which a needle precesses by `_FAR` at most; else -1."""
    if d.slow[0] == 0.0:
        return -1.0
    return _FAR / (2.0 * math.pi * abs(d.slow[0]))


@subroutine
def _fill_fast(c, d, s):
    """Fill what `_slow_column` needs."""
    size = fill_trigonometric(c, s.fast, d.upright, True)
    sn, cn = sincos(c.nutation0[0], c.nutation0[1])
    s.lead[0], s.lead[1] = size * cn, -size * sn
    first, slopes = fast_vectors(s.fast, d.upright, sn, cn)
    turning, phase = 4.0 * math.pi * c.precession[0], 2.0 * math.pi * c.nutation[0]
    for k in range(3):
        v, dv = first[k], slopes[k]
        change = phase * dv[0] - turning * v[1], phase * dv[1] + turning * v[0], phase * dv[2]
        v = in_inertial(d.invariant, 0.0, 1.0, v)
        change = in_inertial(d.invariant, 0.0, 1.0, change)
        for i in range(3):
            s.first[k, i], s.drift[k, i] = v[i], change[i]


@subroutine
def _slow_column(d, s, j, t, arguments):
    """The change of attitude of a needle, early in its precession.

    The columns begin with t R0 dw.  So the two elements that grow with time leave what grows, and
    of each vector B there remains B(t) - B(0) - t B'(0).  That is as small as the column, and is
    computed as such for the slow part of B.
    """
    sn, cn, sine, cosine = arguments
    rate, start = d.weights[RATE, j] * t, d.weights[PHASE, j]
    second, third = d.weights[SECOND, j], d.weights[THIRD, j]
    angle = 2.0 * math.pi * fma(d.slow[0], t, d.slow[1] * t)
    half = math.sin(0.5 * angle)
    down, across, beyond = -2.0 * half * half, math.sin(angle), _sine_less_angle(angle)
    x, y = s.lead[0], s.lead[1]
    left_x, left_y = x * down - y * beyond, x * beyond + y * down
    slow = (
        start * left_x - second * left_y + rate * (x * down - y * across),
        start * left_y + second * left_x + rate * (x * across + y * down),
        0.0,
    )
    slow = in_inertial(d.invariant, 0.0, 1.0, slow)
    vectors, _ = fast_vectors(s.fast, d.upright, sn, cn)
    one = in_inertial(d.invariant, sine, cosine, vectors[0])
    two = in_inertial(d.invariant, sine, cosine, vectors[1])
    three = in_inertial(d.invariant, sine, cosine, vectors[2])
    return (
        _of_needle(s, j, 0, t, (rate, start, second, third), slow[0], (one[0], two[0], three[0])),
        _of_needle(s, j, 1, t, (rate, start, second, third), slow[1], (one[1], two[1], three[1])),
        _of_needle(s, j, 2, t, (rate, start, second, third), slow[2], (one[2], two[2], three[2])),
    )


@subroutine
def _of_needle(s, j, i, t, weights, slow, fast):
    """One component of `_slow_column`."""
    rate, start, second, third = weights
    change = fast[0] - s.first[0, i]
    total = slow + rate * change + start * (change - t * s.drift[0, i])
    total += second * (fast[1] - s.first[1, i] - t * s.drift[1, i])
    total += third * (fast[2] - s.first[2, i] - t * s.drift[2, i])
    return total + t / s.unit * s.series[_ETA + i, j, 1] + s.series[_ETA + i, j, 0]


@subroutine
def _sine_less_angle(x):
    """sin x - x."""
    if abs(x) > 1.0:
        return math.sin(x) - x
    square, total = x * x, 1.0
    for n in range(9, 1, -1):
        total = 1.0 - square / (2.0 * n * (2.0 * n + 1.0)) * total
    return -x * square / 6.0 * total


@subroutine
def _record(short, b, t):
    """The record of the span that an epoch within reach is in."""
    s = short[b]
    if abs(t) <= s.span:
        return b
    side = 1 if t < 0.0 else 0
    k = min(int(abs(t) / s.span), s.spans[side] - 1)
    return s.next + k - 1 + side * (s.spans[0] - 1)


@subroutine
def _is_in_series(s, t):
    """Whether a series holds at an epoch."""
    return abs(t) <= s.span * s.spans[1 if t < 0.0 else 0]


@force_inlined
def near_column(d, short, b, j, block, x, y, z):
    """Replace the change of attitude at the epochs within reach (columns)."""
    s = short[b]
    lx, ly, lz = d.momentum[0], d.momentum[1], d.momentum[2]
    squared = lx * lx + ly * ly + lz * lz
    over, length = 1.0 / squared, 1.0 / math.sqrt(squared)
    first = s.series[0, j, 0], s.series[1, j, 0], s.series[2, j, 0]
    first = turned_by(four(d.start), first)
    for i in range(len(x)):
        t = block[SECONDS + i]
        if abs(t) <= s.soon and _is_in_series(s, t):
            span = short[_record(short, b, t)]
            at = (t - span.centre) / span.unit
            x[i] = _sum(span.series, _ETA, j, at)
            y[i] = _sum(span.series, _ETA + 1, j, at)
            z[i] = _sum(span.series, _ETA + 2, j, at)
        elif _is_in_series(s, t):
            span = short[_record(short, b, t)]
            series, at = span.series, (t - span.centre) / span.span
            now = _sum(series, 0, j, at), _sum(series, 1, j, at), _sum(series, 2, j, at)
            now = turned_by(four_at(block, WXYZ + i), now)
            zeta = length * _sum(series, _ZETA, j, at)
            x[i] = fma(over, first[0] - now[0], fma(zeta, lx, s.series[_ETA, j, 0]))
            y[i] = fma(over, first[1] - now[1], fma(zeta, ly, s.series[_ETA + 1, j, 0]))
            z[i] = fma(over, first[2] - now[2], fma(zeta, lz, s.series[_ETA + 2, j, 0]))
        elif abs(t) <= s.reach:
            x[i], y[i], z[i] = _slow_column(d, s, j, t, four_at(block, ARGUMENTS + i))


@force_inlined
def near_rate_column(d, short, b, j, block, x, y, z):
    """Replace the change of the angular velocity at the epochs within reach."""
    for i in range(len(x)):
        t = block[SECONDS + i]
        if _is_in_series(short[b], t):
            span = short[_record(short, b, t)]
            at = (t - span.centre) / span.span
            x[i] = _sum(span.series, 3, j, at)
            y[i] = _sum(span.series, 4, j, at)
            z[i] = _sum(span.series, 5, j, at)
