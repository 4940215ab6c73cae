"""The loops over bodies and epochs, one for each form of the solution.

Given
    constants  (B,) records (solution.record); those of another form are skipped
    t          (1 or B, T) seconds since the epoch of the state
    t_low      None, or a second double of the seconds, in the same shape
    first, end the epochs t[:, first:end] are evaluated
    column     and go to the columns from here on
Filled
    wxyz       (B, 4, N) body to inertial
    rates      (B, 3, N) rad/s over the given body axes, or None
Returned
    -1, or the first body with an epoch beyond its reach; it and those after it are not filled

Each loop copies the fields it needs from the record into locals (reading them inside the loop costs
four times the arithmetic) and writes component by component into rows, so that LLVM vectorises it.
"""

import math

from attitude.compilation.decorators import force_inlined, inlined_entry_point
from attitude.compilation.instructions import larger, loop_fma
from attitude.solution import codes
from attitude.solution.phases import LONGEST, phase, sincos
from attitude.solution.series import (
    four,
    hyperbolic_arguments,
    hyperbolic_pair,
    hyperbolic_rates,
    trigonometric_pair,
    trigonometric_rates,
    turned,
)
from attitude.solution.twofloat import two_sum

# The largest double, in s, and the slowest motion that reaches it, in turns per second.
_FARTHEST = 1.7976931348623157e308
_SLOWEST = LONGEST / _FARTHEST


@force_inlined
def reach(c):
    """The largest |t|, s, at which two doubles resolve the phases; always finite."""
    fastest = larger(abs(c.precession[0]), abs(c.nutation[0]))
    return LONGEST / fastest if fastest > _SLOWEST else _FARTHEST


@force_inlined
def any_beyond(t, low, most):
    """Whether any |t + low| exceeds `most`; low may be None."""
    # No early exit: this reduction is vectorised and costs less than reading t once more.
    found = 0
    for i in range(len(t)):
        found |= abs(t[i] if low is None else t[i] + low[i]) > most
    return found != 0


@force_inlined
def epoch_pair(times, lows, i):
    """The epoch i as a pair; lows may be None.  Any two summands make such a pair."""
    if lows is None:
        return times[i], 0.0
    return two_sum(times[i], lows[i])


@force_inlined
def _five(row):
    """The first five entries of a row as a tuple."""
    return row[0], row[1], row[2], row[3], row[4]


@force_inlined
def frame_of(c):
    """The matrix from internal pair to attitude, as rows."""
    f = c.frame
    return four(f[0]), four(f[1]), four(f[2]), four(f[3])


@force_inlined
def rate_series_of(c):
    """The four series of the angular velocity."""
    r = c.rates
    return _five(r[0]), _five(r[1]), _five(r[2]), _five(r[3])


@force_inlined
def axes_of(c):
    """The matrix from internal to given body axes, as rows."""
    a = c.axes
    return (
        (a[0, 0], a[0, 1], a[0, 2]),
        (a[1, 0], a[1, 1], a[1, 2]),
        (a[2, 0], a[2, 1], a[2, 2]),
    )


@force_inlined
def _three_rows(array, b, first, end):
    """The part from `first` to `end` of the three rows of a body, each an array."""
    return array[b, 0, first:end], array[b, 1, first:end], array[b, 2, first:end]


@force_inlined
def _four_rows(array, b, first, end):
    """The part from `first` to `end` of the four rows of a body, each an array."""
    return (
        array[b, 0, first:end],
        array[b, 1, first:end],
        array[b, 2, first:end],
        array[b, 3, first:end],
    )


@force_inlined
def _store_attitude(frame, pair, rows, i):
    """The unit quaternion of an internal pair, over the given axes, into entry i of four rows."""
    ar, ai, br, bi = pair
    norm = loop_fma(ar, ar, ai * ai) + loop_fma(br, br, bi * bi)
    scale = 1.0 / math.sqrt(norm)
    w, x, y, z = ar * scale, br * scale, bi * scale, ai * scale
    for k in range(4):
        rows[k][i] = loop_fma(frame[k][0], w, frame[k][1] * x) + loop_fma(
            frame[k][2], y, frame[k][3] * z
        )


@force_inlined
def _store_rates(axes, w, rows, i):
    """Rates over the internal axes, turned to the given axes, into entry i of three rows."""
    for k in range(3):
        rows[k][i] = loop_fma(axes[k][0], w[0], loop_fma(axes[k][1], w[1], axes[k][2] * w[2]))


@inlined_entry_point
def uniform(constants, t, t_low, wxyz, rates, first, end, column):
    """Evaluate the motions of constant angular velocity; arguments as in the module docstring."""
    for b in range(len(constants)):
        c, k = constants[b], b if len(t) > 1 else 0
        if c.form != codes.UNIFORM:
            continue
        times = t[k, first:end]
        lows = None if t_low is None else t_low[k, first:end]
        if any_beyond(times, lows, reach(c)):
            return b
        rows = _four_rows(wxyz, b, column, column + end - first)
        gh, gl = c.precession[0], c.precession[1]
        start, turn = four(c.frame[0]), four(c.frame[1])
        constant = c.rates[0, 0], c.rates[0, 1], c.rates[0, 2]
        if rates is not None:
            omega = _three_rows(rates, b, column, column + end - first)
        for i in range(len(times)):
            t_hi, t_lo = epoch_pair(times, lows, i)
            s, lo, _ = phase(gh, gl, 0.0, 0.0, t_hi, t_lo, 1.0)
            sine, cosine = sincos(s, lo)
            for j in range(4):
                rows[j][i] = loop_fma(start[j], cosine, turn[j] * sine)
            if rates is not None:
                # The sine is NaN if the epoch is: then so is the rate.
                for j in range(3):
                    omega[j][i] = loop_fma(0.0, sine, constant[j])
    return -1


@inlined_entry_point
def trigonometric(constants, t, t_low, wxyz, rates, first, end, column):
    """Evaluate the trigonometric form; arguments as in the module docstring."""
    for b in range(len(constants)):
        c, k = constants[b], b if len(t) > 1 else 0
        if c.form != codes.TRIGONOMETRIC:
            continue
        times = t[k, first:end]
        lows = None if t_low is None else t_low[k, first:end]
        if any_beyond(times, lows, reach(c)):
            return b
        rows = _four_rows(wxyz, b, column, column + end - first)
        gh, gl = c.precession[0], c.precession[1]
        fh, fl = c.nutation[0], c.nutation[1]
        xh, xl = c.nutation0[0], c.nutation0[1]
        alpha = four(c.alpha[0]), four(c.alpha[1])
        beta = four(c.beta[0]), four(c.beta[1])
        frame = frame_of(c)
        if rates is not None:
            series, axes = rate_series_of(c), axes_of(c)
            omega = _three_rows(rates, b, column, column + end - first)
        for i in range(len(times)):
            t_hi, t_lo = epoch_pair(times, lows, i)
            s, lo, _ = phase(fh, fl, xh, xl, t_hi, t_lo, 1.0)
            sn, cn = sincos(s, lo)
            pair = trigonometric_pair(alpha, beta, sn, cn)
            s, lo, _ = phase(gh, gl, 0.0, 0.0, t_hi, t_lo, 1.0)
            sine, cosine = sincos(s, lo)
            _store_attitude(frame, turned(pair, sine, cosine), rows, i)
            if rates is not None:
                _store_rates(axes, trigonometric_rates(series, sn, cn), omega, i)
    return -1


@inlined_entry_point
def hyperbolic(constants, t, t_low, wxyz, rates, first, end, column):
    """Evaluate the hyperbolic form; arguments as in the module docstring."""
    for b in range(len(constants)):
        c, k = constants[b], b if len(t) > 1 else 0
        if c.form != codes.HYPERBOLIC:
            continue
        times = t[k, first:end]
        lows = None if t_low is None else t_low[k, first:end]
        if any_beyond(times, lows, reach(c)):
            return b
        rows = _four_rows(wxyz, b, column, column + end - first)
        gh, gl = c.precession[0], c.precession[1]
        fh, fl = c.nutation[0], c.nutation[1]
        xh, xl = c.nutation0[0], c.nutation0[1]
        winds, decay, nome, tilt, ratio = c.winds, c.decay, c.nome, c.tilt, c.beta[0, 0]
        alpha = four(c.alpha[0]), four(c.alpha[1])
        frame = frame_of(c)
        if rates is not None:
            series, axes = rate_series_of(c), axes_of(c)
            omega = _three_rows(rates, b, column, column + end - first)
        for i in range(len(times)):
            t_hi, t_lo = epoch_pair(times, lows, i)
            s, lo, half_turns = phase(fh, fl, xh, xl, t_hi, t_lo, winds)
            dx = s + lo
            arguments = hyperbolic_arguments(dx, decay, nome)
            pair = hyperbolic_pair(alpha, ratio, dx, half_turns, arguments)
            s, lo, _ = phase(gh, gl, 0.0, 0.0, t_hi, t_lo, 1.0)
            s, more = two_sum(s, -tilt * dx)
            sine, cosine = sincos(s, lo + more)
            _store_attitude(frame, turned(pair, sine, cosine), rows, i)
            if rates is not None:
                _store_rates(axes, hyperbolic_rates(series, dx, half_turns, arguments), omega, i)
    return -1
