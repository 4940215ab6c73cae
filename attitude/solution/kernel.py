"""The loops over epochs.

Each copies what it needs from the record into locals (reading it inside the loop costs four times
the arithmetic) and writes component by component into rows: then it vectorises.
"""

import math

from attitude.solution import codes
from attitude.solution.machine import fma, inlined, merged
from attitude.solution.series import (
    four,
    hyperbolic_arguments,
    hyperbolic_pair,
    hyperbolic_rates,
    trigonometric_pair,
    trigonometric_rates,
    turned,
)
from attitude.solution.turns import phase, sincos
from attitude.solution.twofloat import two_sum


@merged
def evaluate(c, t, t_low, wxyz, rates):
    """Attitudes and, unless rates is None, angular velocities of one body at each epoch.

    Given
        c       its record (solution.layout)
        t       (T,) seconds since the epoch of the state
        t_low   (T,) what is added to t, or None
    Filled
        wxyz    (4, T) body to inertial
        rates   (3, T) rad/s over the given body axes, or None
    """
    if c.form == codes.UNIFORM:
        uniform(c, t, t_low, wxyz, rates)
    elif c.form == codes.TRIGONOMETRIC:
        trigonometric(c, t, t_low, wxyz, rates)
    else:
        hyperbolic(c, t, t_low, wxyz, rates)


@inlined
def _five(row):
    return row[0], row[1], row[2], row[3], row[4]


@inlined
def _frame(c):
    f = c.frame
    return four(f[0]), four(f[1]), four(f[2]), four(f[3])


@inlined
def _rate_series(c):
    r = c.rates
    return _five(r[0]), _five(r[1]), _five(r[2]), _five(r[3])


@inlined
def _axes(c):
    a = c.axes
    return (
        (a[0, 0], a[0, 1], a[0, 2]),
        (a[1, 0], a[1, 1], a[1, 2]),
        (a[2, 0], a[2, 1], a[2, 2]),
    )


@inlined
def _store_attitude(frame, pair, wxyz, i):
    ar, ai, br, bi = pair
    norm = fma(ar, ar, ai * ai) + fma(br, br, bi * bi)
    scale = 1.0 / math.sqrt(norm)
    w, x, y, z = ar * scale, br * scale, bi * scale, ai * scale
    for k in range(4):
        wxyz[k, i] = fma(frame[k][0], w, frame[k][1] * x) + fma(frame[k][2], y, frame[k][3] * z)


@inlined
def _store_rates(axes, w, rates, i):
    for k in range(3):
        rates[k, i] = fma(axes[k][0], w[0], fma(axes[k][1], w[1], axes[k][2] * w[2]))


@merged
def uniform(c, t, t_low, wxyz, rates):
    gh, gl = c.precession[0], c.precession[1]
    a, b = four(c.frame[0]), four(c.frame[1])
    omega = c.rates[0, 0], c.rates[0, 1], c.rates[0, 2]
    for i in range(len(t)):
        low = 0.0 if t_low is None else t_low[i]
        s, lo, _ = phase(gh, gl, 0.0, 0.0, t[i], low, 1.0)
        sine, cosine = sincos(s, lo)
        for k in range(4):
            wxyz[k, i] = fma(a[k], cosine, b[k] * sine)
        if rates is not None:
            # The sine is NaN where the epoch is.
            for k in range(3):
                rates[k, i] = fma(0.0, sine, omega[k])


@merged
def trigonometric(c, t, t_low, wxyz, rates):
    gh, gl = c.precession[0], c.precession[1]
    fh, fl = c.nutation[0], c.nutation[1]
    xh, xl = c.nutation0[0], c.nutation0[1]
    alpha = four(c.alpha[0]), four(c.alpha[1])
    beta = four(c.beta[0]), four(c.beta[1])
    frame = _frame(c)
    if rates is not None:
        series, axes = _rate_series(c), _axes(c)
    for i in range(len(t)):
        low = 0.0 if t_low is None else t_low[i]
        s, lo, _ = phase(fh, fl, xh, xl, t[i], low, 1.0)
        sine, cosine = sincos(s, lo)
        pair = trigonometric_pair(alpha, beta, sine, cosine)
        if rates is not None:
            _store_rates(axes, trigonometric_rates(series, sine, cosine), rates, i)
        s, lo, _ = phase(gh, gl, 0.0, 0.0, t[i], low, 1.0)
        sine, cosine = sincos(s, lo)
        _store_attitude(frame, turned(pair, sine, cosine), wxyz, i)


@merged
def hyperbolic(c, t, t_low, wxyz, rates):
    gh, gl = c.precession[0], c.precession[1]
    fh, fl = c.nutation[0], c.nutation[1]
    xh, xl = c.nutation0[0], c.nutation0[1]
    winds, decay, nome, tilt, ratio = c.winds, c.decay, c.nome, c.tilt, c.beta[0, 0]
    alpha = four(c.alpha[0]), four(c.alpha[1])
    frame = _frame(c)
    if rates is not None:
        series, axes = _rate_series(c), _axes(c)
    for i in range(len(t)):
        low = 0.0 if t_low is None else t_low[i]
        s, lo, half_turns = phase(fh, fl, xh, xl, t[i], low, winds)
        dx = s + lo
        arguments = hyperbolic_arguments(dx, decay, nome)
        pair = hyperbolic_pair(alpha, ratio, dx, half_turns, arguments)
        if rates is not None:
            w = hyperbolic_rates(series, dx, half_turns, arguments)
            _store_rates(axes, w, rates, i)
        s, lo, _ = phase(gh, gl, 0.0, 0.0, t[i], low, 1.0)
        s, more = two_sum(s, -tilt * dx)
        sine, cosine = sincos(s, lo + more)
        _store_attitude(frame, turned(pair, sine, cosine), wxyz, i)
