"""The loops over bodies and epochs, one for each form of the solution.

Given
    constants  (B,) records (records.CONSTANTS); those of another form are skipped
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

from __future__ import annotations

import math
from itertools import product as combinations
from typing import TYPE_CHECKING

import numpy as np

from attitude._compilation.decorators import (
    elementwise,
    force_inlined,
    inlined_entry_point,
    named,
    sized_entry_point,
    subroutine,
)
from attitude._compilation.instructions import larger, loop_fma
from attitude._solver import codes
from attitude._solver.series import (
    LONGEST,
    five,
    four,
    hyperbolic_arguments,
    hyperbolic_pair,
    hyperbolic_rates,
    phase,
    sincos,
    sincos_at,
    trigonometric_pair,
    trigonometric_rates,
    triple,
    turned,
)
from attitude._solver.twofloat import ZERO, pair, two_sum

if TYPE_CHECKING:
    from attitude._support.annotations import FloatArray


# ---- Last stage: from the internal axes of the solution to the given body axes
# q(t) = q(0) b q_int(0)* q_int(t) b*, where b rotates internal to given body axes: one constant
# quaternion on each side of q_int(t), multiplied out to one matrix that the kernels apply.


def _signed_permutations() -> tuple[FloatArray, FloatArray]:
    """Proper signed permutations as matrices and unit quaternions, [first, second, sign 1, sign 3].

    Column k is the principal axis that becomes internal axis k; index 1 is a negative sign.
    """
    matrices, quaternions = np.zeros((3, 3, 2, 2, 3, 3)), np.zeros((3, 3, 2, 2, 4))
    for first, second in ((0, 1), (1, 2), (2, 0), (1, 0), (2, 1), (0, 2)):
        third = 3 - first - second
        for minus1, minus3 in combinations((0, 1), repeat=2):
            matrix = np.zeros((3, 3))
            matrix[first, 0], matrix[third, 2] = 1 - 2 * minus1, 1 - 2 * minus3
            matrix[:, 1] = np.cross(matrix[:, 2], matrix[:, 0])
            # 4 q q^T has entries that are sums of those of the matrix; any non-zero column is q.
            (xx, xy, xz), (yx, yy, yz), (zx, zy, zz) = matrix
            outer = np.array(
                [
                    [1 + xx + yy + zz, zy - yz, xz - zx, yx - xy],
                    [zy - yz, 1 + xx - yy - zz, xy + yx, xz + zx],
                    [xz - zx, xy + yx, 1 - xx + yy - zz, yz + zy],
                    [yx - xy, xz + zx, yz + zy, 1 - xx - yy + zz],
                ]
            )
            column = outer[:, np.argmax(np.diag(outer))]
            matrices[first, second, minus1, minus3] = matrix
            quaternions[first, second, minus1, minus3] = column / np.sqrt(column @ column)
    return matrices, quaternions


_MATRICES, _QUATERNIONS = _signed_permutations()
_UNIT = np.eye(4)


@sized_entry_point
def attach_all(wxyz, wxyz_low, principal, constants):
    """Fill the frame and the axes in constants (B,) (records.CONSTANTS) of the motions that tumble.

    Given
        wxyz       (B, 4) body to inertial at the epoch, of any length
        wxyz_low   (1 or B, 4) second doubles of wxyz, then of unit length; or zeros
        principal  (1 or B, 4) principal axes to given body axes
    """
    for b in range(len(constants)):
        c = constants[b]
        if c.fault == codes.FINE and c.form != codes.UNIFORM:
            quaternion = four(principal[b if len(principal) > 1 else 0])
            low = four(wxyz_low[b if len(wxyz_low) > 1 else 0])
            body = _axes(quaternion, c)
            _attach(four(wxyz[b]), low, body, unit(four(c.internal)), c.frame)


@subroutine
def unit(q):
    """A quaternion (4) of any nonzero length as a unit quaternion."""
    size = larger(larger(abs(q[0]), abs(q[1])), larger(abs(q[2]), abs(q[3])))
    w, x, y, z = q[0] / size, q[1] / size, q[2] / size, q[3] / size
    size = 1.0 / math.sqrt(w * w + x * x + y * y + z * z)
    return w * size, x * size, y * size, z * size


@subroutine
def product(p, q):
    """The quaternion product p q."""
    return (
        p[0] * q[0] - p[1] * q[1] - p[2] * q[2] - p[3] * q[3],
        p[0] * q[1] + p[1] * q[0] + p[2] * q[3] - p[3] * q[2],
        p[0] * q[2] - p[1] * q[3] + p[2] * q[0] + p[3] * q[1],
        p[0] * q[3] + p[1] * q[2] - p[2] * q[1] + p[3] * q[0],
    )


@subroutine
def at_start(wxyz, low):
    """The unit quaternion of wxyz of any length, or wxyz + low of unit length if low is not 0."""
    return wxyz if any_of(low) else unit(wxyz)


@subroutine
def any_of(q):
    """Whether a quaternion (4) has a component that is not zero."""
    return q[0] != 0.0 or q[1] != 0.0 or q[2] != 0.0 or q[3] != 0.0


@subroutine
def plus(p, q):
    """The sum of two quaternions."""
    return p[0] + q[0], p[1] + q[1], p[2] + q[2], p[3] + q[3]


@subroutine
def turned_by(q, v):
    """The vector q v q* (3) of a unit quaternion; v itself, bit for bit, when q is 1."""
    a, b, c = v
    d = 2.0 * (q[2] * c - q[3] * b)
    e = 2.0 * (q[3] * a - q[1] * c)
    f = 2.0 * (q[1] * b - q[2] * a)
    return (
        a + q[0] * d + (q[2] * f - q[3] * e),
        b + q[0] * e + (q[3] * d - q[1] * f),
        c + q[0] * f + (q[1] * e - q[2] * d),
    )


@subroutine
def _axes(principal, c):
    """The quaternion from internal to given body axes; fill its matrix, which the rates need."""
    first, second, minus1, minus3 = four(c.jacobi)
    internal, axes = _MATRICES[first, second, minus1, minus3], c.axes
    for k in range(3):
        column = turned_by(principal, (internal[0, k], internal[1, k], internal[2, k]))
        for i in range(3):
            axes[i, k] = column[i]
    return product(principal, four(_QUATERNIONS[first, second, minus1, minus3]))


@subroutine
def _attach(wxyz, low, body, internal, frame):
    """Fill the matrix of q_int(t) -> q(t), column by column."""
    back = (internal[0], -internal[1], -internal[2], -internal[3])
    left = product(product(at_start(wxyz, low), body), back)
    if any_of(low):
        left = plus(left, product(product(low, body), back))
    right = (body[0], -body[1], -body[2], -body[3])
    for k in range(4):
        column = product(product(left, four(_UNIT[k])), right)
        for j in range(4):
            frame[j, k] = column[j]


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
    beyond = 0
    for i in range(len(t)):
        beyond |= abs(t[i] if low is None else t[i] + low[i]) > most
    return beyond != 0


@force_inlined
def epoch_pair(times, lows, i):
    """The epoch i as a pair; lows may be None.  Any two summands make such a pair."""
    if lows is None:
        return times[i], 0.0
    return two_sum(times[i], lows[i])


@force_inlined
def frame_of(c):
    """The matrix from internal pair to attitude, as rows."""
    f = c.frame
    return four(f[0]), four(f[1]), four(f[2]), four(f[3])


@force_inlined
def rate_series_of(c):
    """The four series of the angular velocity."""
    r = c.rates
    return five(r[0]), five(r[1]), five(r[2]), five(r[3])


@force_inlined
def rows_of_matrix(a):
    """A matrix (3, 3) as a tuple of rows."""
    return triple(a[0]), triple(a[1]), triple(a[2])


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
def _store_attitude(frame, internal, rows, i):
    """The unit quaternion of an internal pair, over the given axes, into entry i of four rows."""
    ar, ai, br, bi = internal
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


@elementwise
@force_inlined
def _fill_uniform(c, times, lows, rows, omega):
    """Fill the rows of a motion, and those of its angular velocity if given."""
    precession = pair(c.precession)
    start, turn = four(c.frame[0]), four(c.frame[1])
    constant = c.rates[0, 0], c.rates[0, 1], c.rates[0, 2]
    for i in range(len(times)):
        t_hi, t_lo = epoch_pair(times, lows, i)
        sine, cosine = sincos_at(precession, ZERO, t_hi, t_lo)
        for j in range(4):
            rows[j][i] = loop_fma(start[j], cosine, turn[j] * sine)
        if omega is not None:
            # The sine is NaN if the epoch is: then so is the rate.
            for j in range(3):
                omega[j][i] = loop_fma(0.0, sine, constant[j])


@elementwise
@force_inlined
def _fill_trigonometric(c, times, lows, rows, omega):
    """As `_fill_uniform`, for a motion of the trigonometric form."""
    precession, nutation, nutation0 = pair(c.precession), pair(c.nutation), pair(c.nutation0)
    alpha = four(c.alpha[0]), four(c.alpha[1])
    beta = four(c.beta[0]), four(c.beta[1])
    frame = frame_of(c)
    if omega is not None:  # without rates nothing of them is compiled
        series, axes = rate_series_of(c), rows_of_matrix(c.axes)
    for i in range(len(times)):
        t_hi, t_lo = epoch_pair(times, lows, i)
        sn, cn = sincos_at(nutation, nutation0, t_hi, t_lo)
        sine, cosine = sincos_at(precession, ZERO, t_hi, t_lo)
        internal = turned(trigonometric_pair(alpha, beta, sn, cn), sine, cosine)
        _store_attitude(frame, internal, rows, i)
        if omega is not None:
            _store_rates(axes, trigonometric_rates(series, sn, cn), omega, i)


@elementwise
@force_inlined
def _fill_hyperbolic(c, times, lows, rows, omega):
    """As `_fill_uniform`, for a motion of the hyperbolic form."""
    gh, gl = c.precession[0], c.precession[1]
    fh, fl = c.nutation[0], c.nutation[1]
    xh, xl = c.nutation0[0], c.nutation0[1]
    winds, decay, nome, tilt, ratio = c.winds, c.decay, c.nome, c.tilt, c.beta[0, 0]
    alpha = four(c.alpha[0]), four(c.alpha[1])
    frame = frame_of(c)
    if omega is not None:  # without rates nothing of them is compiled
        series, axes = rate_series_of(c), rows_of_matrix(c.axes)
    for i in range(len(times)):
        t_hi, t_lo = epoch_pair(times, lows, i)
        s, lo, half_turns = phase(fh, fl, xh, xl, t_hi, t_lo, winds)
        dx = s + lo
        arguments = hyperbolic_arguments(dx, decay, nome)
        internal = hyperbolic_pair(alpha, ratio, dx, half_turns, arguments)
        s, lo, _ = phase(gh, gl, 0.0, 0.0, t_hi, t_lo, 1.0)
        s, more = two_sum(s, -tilt * dx)
        sine, cosine = sincos(s, lo + more)
        _store_attitude(frame, turned(internal, sine, cosine), rows, i)
        if omega is not None:
            _store_rates(axes, hyperbolic_rates(series, dx, half_turns, arguments), omega, i)


def _loop_of(name, form, fill):
    """The loop of a form; arguments as in the module docstring."""

    def loop(constants, t, t_low, wxyz, rates, first, end, column):
        for b in range(len(constants)):
            c, k = constants[b], b if len(t) > 1 else 0
            if c.form != form:
                continue
            times = t[k, first:end]
            lows = None if t_low is None else t_low[k, first:end]
            if any_beyond(times, lows, reach(c)):
                return b
            rows = _four_rows(wxyz, b, column, column + end - first)
            omega = None if rates is None else _three_rows(rates, b, column, column + end - first)
            fill(c, times, lows, rows, omega)
        return -1

    return inlined_entry_point(named(loop, name))


uniform = _loop_of("uniform", codes.UNIFORM, _fill_uniform)
trigonometric = _loop_of("trigonometric", codes.TRIGONOMETRIC, _fill_trigonometric)
hyperbolic = _loop_of("hyperbolic", codes.HYPERBOLIC, _fill_hyperbolic)
