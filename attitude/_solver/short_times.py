"""Sensitivity at epochs near that of the state, by Taylor series of Euler's equations.

Where the polhode is slow, beside a sphere or the equator of a symmetric body, the elements change
strongly with the moments, and the columns of columns are small differences of large
numbers.  Within a quarter of the radius of convergence, K'/wp, or less, the changes are polynomials
in t:

    w' = c w w,    (dw)' = c (dw w + w dw) + dc w w,    zeta' = n dw,    n = L/|L|

With M = I w and dM = I dw + dI w over the body axes, whose product vanishes term by term where the
column does, and R the attitude,

    eta = eta(0) + (R0 (M x dM)(0) - R M x dM) / L^2 + zeta n.

Within a radian of the rotation the difference is small itself, and eta a polynomial: eta' = R dw.
Uniform rotations have their own columns beyond that radian (solution.uniform_tangents).
"""

from __future__ import annotations

import math

import numpy as np

from attitude._compilation.decorators import force_inlined, slowly_compiled, subroutine
from attitude._compilation.instructions import fma
from attitude._solver import codes
from attitude._solver.derivatives import state_of
from attitude._solver.elliptic import integrals
from attitude._solver.kernel import turned_by, unit
from attitude._solver.records import BLOCK, COLUMNS, SECONDS, WXYZ
from attitude._solver.series import four
from attitude._solver.uniform_tangents import couplings_of, forced

# Beyond, the terms are below 0.25^28 = 1e-17 of the first.
TERMS = 28
_SHARE = 0.25
# K' counts as no more than this: the functions of a symmetric body have no pole, but their products
# have twice the frequency, and a term of this order below 1e-17 of the largest within 0.9 rad.
_FARTHEST = 3.6

# Rows of a series: M x dM (3) and change of the angular velocity (3) over the body axes, zeta, and
# eta (3) over the inertial axes.
ROWS_OF_SERIES = 10
_ZETA, _ETA = 6, 7

SHORT: np.dtype[np.void] = np.dtype(
    [
        ("reach", "f8"),
        ("soon", "f8"),  # within so many seconds by the series of eta, in units of them
        ("wxyz", "f8", 4),  # attitude at the epoch
        ("series", "f8", (ROWS_OF_SERIES, COLUMNS, TERMS)),
    ]
)


@slowly_compiled
def reaches(constants, out):
    """Fill the seconds (B,) to either side of the epoch within which the series hold; -1: never."""
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
            state = state_of(c)
            speed, (m, mc) = state[6], state[7]
            quarter = _FARTHEST
            if m > 1e-9:
                quarter = min(quarter, integrals(mc, m)[0])
            out[b] = math.ldexp(_SHARE * quarter / speed, -c.tempo)


@slowly_compiled
def short_setup(constants, tangents, reach, out):
    """Fill the series (B,) of SHORT of those of B motions that are not at rest; reach (B,) of
    `reaches`.
    """
    w, dw = np.zeros((3, TERMS)), np.zeros((3, TERMS))
    momentum, turn = np.zeros((3, TERMS)), np.zeros((3, 3, TERMS))
    for b in range(len(constants)):
        c, d, s = constants[b], tangents[b], out[b]
        s.reach = reach[b]
        if reach[b] > 0.0:
            moments = 1.0 / d.inverse[0], 1.0 / d.inverse[1], 1.0 / d.inverse[2]
            _start(c, s)
            _fill(c, d, moments, w, dw, momentum, turn, s)


@subroutine
def _start(c, s):
    """Fill the attitude at the epoch, and within which time it turns by a radian."""
    internal = unit(four(c.internal))
    for k in range(4):
        row = four(c.frame[k])
        s.wxyz[k] = row[0] * internal[0] + row[1] * internal[1]
        s.wxyz[k] += row[2] * internal[2] + row[3] * internal[3]
        if c.form == codes.UNIFORM:
            s.wxyz[k] = c.frame[0, k]
    s.soon = min(s.reach, math.ldexp(1.0 / _speed(c), -c.tempo))


@subroutine
def _speed(c):
    """The scaled angular velocity's size."""
    x, y, z = c.omega[0, 0], c.omega[1, 0], c.omega[2, 0]
    return math.sqrt(x * x + y * y + z * z)


@subroutine
def _fill(c, d, moments, w, dw, momentum, turn, s):
    pairs = couplings_of(c)
    k = pairs[0][0], pairs[1][0], pairs[2][0]
    span = s.reach
    for i in range(3):
        w[i, 0] = math.ldexp(c.omega[i, 0], c.tempo)
    for n in range(TERMS - 1):
        over = span / (n + 1.0)
        for i in range(3):
            w[i, n + 1] = over * k[i] * _product(w, w, (i + 1) % 3, (i + 2) % 3, n)
    _turn(d, w, turn, s)
    size = math.sqrt(d.momentum[0] ** 2 + d.momentum[1] ** 2 + d.momentum[2] ** 2)
    for j in range(COLUMNS):
        if j < 3:
            s.series[_ETA + j, j, 0] = 1.0
            continue
        for i in range(3):
            dw[i, 0] = d.principal[j - 3, i] if j < 6 else 0.0
        for n in range(TERMS - 1):
            over = span / (n + 1.0)
            for i in range(3):
                one, two = (i + 1) % 3, (i + 2) % 3
                more = _product(dw, w, one, two, n) + _product(w, dw, one, two, n)
                more *= k[i]
                if j >= 6:
                    change = forced(k, (1.0, 1.0, 1.0), moments, j - 6)
                    more += change[i] * _product(w, w, one, two, n)
                dw[i, n + 1] = over * more
        _store(d, moments, w, dw, momentum, j, size, s)
        _store_eta(dw, turn, j, s)


@subroutine
def _turn(d, w, turn, s):
    """The rotation from principal to inertial axes, in t / s.soon: R' = R w x."""
    start = four(s.wxyz)
    for j in range(3):
        column = turned_by(start, (d.principal[0, j], d.principal[1, j], d.principal[2, j]))
        for i in range(3):
            turn[i, j, 0] = column[i]
    share = s.soon / s.reach
    for n in range(TERMS - 1):
        over = s.soon / (n + 1.0)
        for i in range(3):
            for j in range(3):
                one, two = (j + 1) % 3, (j + 2) % 3
                total, power = 0.0, 1.0
                for k in range(n + 1):
                    more = turn[i, one, n - k] * w[two, k] - turn[i, two, n - k] * w[one, k]
                    total += power * more
                    power *= share
                turn[i, j, n + 1] = over * total


@subroutine
def _store_eta(dw, turn, j, s):
    """Fill the series of eta in t / s.soon: eta' = R dw."""
    share = s.soon / s.reach
    for n in range(TERMS - 1):
        for i in range(3):
            total, power = 0.0, 1.0
            for k in range(n + 1):
                for m in range(3):
                    total += power * dw[m, k] * turn[i, m, n - k]
                power *= share
            s.series[_ETA + i, j, n + 1] = s.soon / (n + 1.0) * total


@subroutine
def _product(a, b, i, j, n):
    """Coefficient n of the product of two series."""
    total = 0.0
    for k in range(n + 1):
        total += a[i, k] * b[j, n - k]
    return total


@subroutine
def _store(d, moments, w, dw, momentum, j, size, s):
    """Fill the series of one column from those over the principal axes."""
    for n in range(TERMS):
        for i in range(3):
            momentum[i, n] = moments[i] * dw[i, n] + (w[i, n] if j - 6 == i else 0.0)
    for n in range(TERMS):
        for i in range(3):
            one, two = (i + 1) % 3, (i + 2) % 3
            across = moments[one] * _product(w, momentum, one, two, n)
            across -= moments[two] * _product(w, momentum, two, one, n)
            for k in range(3):
                s.series[k, j, n] += d.principal[k, i] * across
                s.series[3 + k, j, n] += d.principal[k, i] * dw[i, n]
    # n dw by the energy, whose change is constant: I w dw + w^2 dI / 2 is that of the epoch
    if j < 6:
        for i in range(3):
            s.series[_ZETA, j, 1] += s.reach / size * moments[i] * w[i, 0] * dw[i, 0]
    else:
        for n in range(1, TERMS - 1):
            change = -0.5 * _product(w, w, j - 6, j - 6, n)
            s.series[_ZETA, j, n + 1] = s.reach * change / (size * (n + 1.0))


@subroutine
def any_near(t, reach):
    """Whether any epoch of a block is within reach."""
    found = 0
    for i in range(len(t)):
        found |= abs(t[i]) <= reach
    return found != 0


@subroutine
def _sum(series, row, j, x):
    total = series[row, j, TERMS - 1]
    for n in range(TERMS - 2, -1, -1):
        total = fma(total, x, series[row, j, n])
    return total


@force_inlined
def near_column(d, s, j, block, x, y, z):
    """Replace the change of attitude at the epochs within reach (columns)."""
    lx, ly, lz = d.momentum[0], d.momentum[1], d.momentum[2]
    squared = lx * lx + ly * ly + lz * lz
    over, length = 1.0 / squared, 1.0 / math.sqrt(squared)
    first = s.series[0, j, 0], s.series[1, j, 0], s.series[2, j, 0]
    first = turned_by(four(s.wxyz), first)
    for i in range(len(x)):
        t = block[SECONDS + i]
        if abs(t) <= s.soon:
            at = t / s.soon
            x[i] = _sum(s.series, _ETA, j, at)
            y[i] = _sum(s.series, _ETA + 1, j, at)
            z[i] = _sum(s.series, _ETA + 2, j, at)
        elif abs(t) <= s.reach:
            at = t / s.reach
            now = _sum(s.series, 0, j, at), _sum(s.series, 1, j, at), _sum(s.series, 2, j, at)
            qw, qx = block[WXYZ + i], block[WXYZ + BLOCK + i]
            qy, qz = block[WXYZ + 2 * BLOCK + i], block[WXYZ + 3 * BLOCK + i]
            now = turned_by((qw, qx, qy, qz), now)
            zeta = length * _sum(s.series, _ZETA, j, at)
            x[i] = fma(over, first[0] - now[0], fma(zeta, lx, s.series[_ETA, j, 0]))
            y[i] = fma(over, first[1] - now[1], fma(zeta, ly, s.series[_ETA + 1, j, 0]))
            z[i] = fma(over, first[2] - now[2], fma(zeta, lz, s.series[_ETA + 2, j, 0]))


@force_inlined
def near_rate_column(s, j, block, x, y, z):
    """Replace the change of the angular velocity at the epochs within reach."""
    for i in range(len(x)):
        t = block[SECONDS + i]
        if abs(t) <= s.reach:
            at = t / s.reach
            x[i] = _sum(s.series, 3, j, at)
            y[i] = _sum(s.series, 4, j, at)
            z[i] = _sum(s.series, 5, j, at)
