"""Sensitivity at epochs near that of the state, by Taylor series of Euler's equations.

Where the polhode is slow, beside a sphere or the equator of a symmetric body, the elements change
strongly with the moments, and the columns of solution.columns are small differences of large
numbers.  Within a fifth of the radius of convergence, K'/wp, or less, the changes are polynomials
in t:

    w' = c w w,    (dw)' = c (dw w + w dw) + dc w w,    zeta' = n dw,    n = L/|L|

and eta = L x (dL - R (I dw + dI w)) / L^2 + zeta n.
"""

import math

import numpy as np

from attitude.compilation.decorators import force_inlined, slowly_compiled, subroutine
from attitude.compilation.instructions import fma
from attitude.solution import codes
from attitude.solution.derivatives import state_of
from attitude.solution.second_kind import integrals
from attitude.solution.tangent_record import BLOCK, COLUMNS, SECONDS, WXYZ
from attitude.solution.uniform_tangents import couplings_of, forced

# Beyond, the terms are below 0.2^24 = 2e-17 of the first.
TERMS = 24
_SHARE = 0.2
# K' counts as no more than this: the functions of a symmetric body have no pole, but their products
# have twice the frequency, and a term of this order below 1e-16 of the largest within 0.72 rad.
_FARTHEST = 3.6

# Rows of a series: change of the momentum (3) and of the angular velocity (3) over the body axes,
# and zeta.
ROWS_OF_SERIES = 7
_ZETA = 6

SHORT: np.dtype[np.void] = np.dtype(
    [("reach", "f8"), ("series", "f8", (ROWS_OF_SERIES, COLUMNS, TERMS))]
)


@slowly_compiled
def reaches(constants, out):
    """Fill the seconds (B,) to either side of the epoch within which the series hold; 0: never."""
    for b in range(len(constants)):
        c = constants[b]
        out[b] = 0.0
        if c.fault == codes.FINE and c.form != codes.UNIFORM:
            state = state_of(c)
            speed, (m, mc) = state[6], state[7]
            quarter = _FARTHEST
            if m > 1e-9:
                quarter = min(quarter, integrals(mc, m)[0])
            out[b] = math.ldexp(_SHARE * quarter / speed, -c.tempo)


@slowly_compiled
def short_setup(constants, tangents, reach, out):
    """Fill the series of those of B motions that tumble.

    Given
        reach    (B,) of `reaches`
    Filled
        out      (B,) of SHORT
    """
    w = np.zeros((3, TERMS))
    dw = np.zeros((3, TERMS))
    for b in range(len(constants)):
        c, d, s = constants[b], tangents[b], out[b]
        s.reach = reach[b]
        if reach[b] > 0.0:
            moments = 1.0 / d.inverse[0], 1.0 / d.inverse[1], 1.0 / d.inverse[2]
            _fill(c, d, moments, w, dw, s)


@subroutine
def _fill(c, d, moments, w, dw, s):
    pairs = couplings_of(c)
    k = pairs[0][0], pairs[1][0], pairs[2][0]
    span = s.reach
    for i in range(3):
        w[i, 0] = math.ldexp(c.omega[i, 0], c.tempo)
    for n in range(TERMS - 1):
        over = span / (n + 1.0)
        for i in range(3):
            w[i, n + 1] = over * k[i] * _product(w, w, (i + 1) % 3, (i + 2) % 3, n)
    size = math.sqrt(d.momentum[0] ** 2 + d.momentum[1] ** 2 + d.momentum[2] ** 2)
    for j in range(COLUMNS):
        if j < 3:
            s.series[_ZETA, j, 0] = d.momentum[j] / size
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
        _store(d, moments, w, dw, j, size, s)


@subroutine
def _product(a, b, i, j, n):
    """Coefficient n of the product of two series."""
    total = 0.0
    for k in range(n + 1):
        total += a[i, k] * b[j, n - k]
    return total


@subroutine
def _store(d, moments, w, dw, j, size, s):
    """Fill the series of one column from those over the principal axes."""
    for n in range(TERMS):
        for i in range(3):
            momentum = moments[i] * dw[i, n]
            if j - 6 == i:
                momentum += w[i, n]
            for k in range(3):
                s.series[k, j, n] += d.principal[k, i] * momentum
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
    """Whether any epoch of a block, but that of the state, is within reach."""
    found = 0
    for i in range(len(t)):
        found |= 0.0 < abs(t[i]) <= reach
    return found != 0


@subroutine
def _sum(series, row, j, x):
    total = series[row, j, TERMS - 1]
    for n in range(TERMS - 2, -1, -1):
        total = fma(total, x, series[row, j, n])
    return total


@force_inlined
def near_column(d, s, j, block, x, y, z):
    """Replace the change of attitude at the epochs within reach (solution.columns)."""
    lx, ly, lz = d.momentum[0], d.momentum[1], d.momentum[2]
    squared = lx * lx + ly * ly + lz * lz
    over, length = 1.0 / squared, 1.0 / math.sqrt(squared)
    ix, iy, iz = d.impulse[0, j], d.impulse[1, j], d.impulse[2, j]
    for i in range(len(x)):
        t = block[SECONDS + i]
        if 0.0 < abs(t) <= s.reach:
            at = t / s.reach
            vx, vy = _sum(s.series, 0, j, at), _sum(s.series, 1, j, at)
            vz = _sum(s.series, 2, j, at)
            qw, qx = block[WXYZ + i], block[WXYZ + BLOCK + i]
            qy, qz = block[WXYZ + 2 * BLOCK + i], block[WXYZ + 3 * BLOCK + i]
            tx, ty, tz = (
                2.0 * (qy * vz - qz * vy),
                2.0 * (qz * vx - qx * vz),
                2.0 * (qx * vy - qy * vx),
            )
            ux = ix - (vx + qw * tx + (qy * tz - qz * ty))
            uy = iy - (vy + qw * ty + (qz * tx - qx * tz))
            uz = iz - (vz + qw * tz + (qx * ty - qy * tx))
            zeta = length * _sum(s.series, _ZETA, j, at)
            x[i] = over * (ly * uz - lz * uy) + zeta * lx
            y[i] = over * (lz * ux - lx * uz) + zeta * ly
            z[i] = over * (lx * uy - ly * ux) + zeta * lz


@force_inlined
def near_rate_column(s, j, block, x, y, z):
    """Replace the change of the angular velocity at the epochs within reach."""
    for i in range(len(x)):
        t = block[SECONDS + i]
        if 0.0 < abs(t) <= s.reach:
            at = t / s.reach
            x[i] = _sum(s.series, 3, j, at)
            y[i] = _sum(s.series, 4, j, at)
            z[i] = _sum(s.series, 5, j, at)
