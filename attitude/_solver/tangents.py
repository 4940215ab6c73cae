"""The changes of attitude with the elements of a motion, for a block of epochs.

A change (A', b') of the pair is the rotation vector (axes with z along the momentum)

    eta_z = 2 Im(A' conj A + b' conj b) / N,      eta_x + i eta_y = 2 exp(2 i Phi) (A b' - b A') / N

with N = |A|^2 + |b|^2 and the phase Phi of the precession; the normalisation of the pair drops out.

Given
    c, d       records of CONSTANTS and TANGENTS (`records`)
    t, t_low   (n,) seconds, n <= BLOCK; `t_low` may be None
Filled
    block      (ROWS BLOCK,) rows of records.TANGENTS: seconds, three vectors over inertial
               axes, the number of the passage, and the arguments from which the attitudes and the
               angular velocities follow
"""

from __future__ import annotations

import math

from attitude._compilation.decorators import elementwise, force_inlined, subroutine
from attitude._compilation.instructions import chosen_if, fma, rint
from attitude._solver import codes
from attitude._solver.columns import four_at, put_four, put_three
from attitude._solver.constants import COS_EVEN, COS_ODD, SIN_EVEN, SIN_ODD
from attitude._solver.derivatives import ellipticity, state_of
from attitude._solver.elliptic import integrals
from attitude._solver.kernel import epoch_pair, frame_of, rate_series_of, rows_of_matrix
from attitude._solver.records import (
    ARGUMENTS,
    BASIS,
    BLOCK,
    BY_NOME,
    BY_PHASE,
    COLUMNS,
    DECAYED,
    NOME,
    OMEGA,
    PASSED,
    SCALED,
    SECONDS,
    WXYZ,
)
from attitude._solver.series import (
    cubic,
    exp2_of_minus,
    five,
    four,
    hyperbolic_arguments,
    hyperbolic_pair,
    hyperbolic_rates,
    negated_if_odd,
    phase,
    quadratic,
    quartic,
    sincos,
    sincos_at,
    trigonometric_pair,
    trigonometric_rates,
    triple,
    turned,
)
from attitude._solver.twofloat import ZERO, pair, quick_two_sum, two_sum

LOG_2 = math.log(2.0)
_TINY = 1e-300


@subroutine
def _along(row, v):
    return fma(row[0], v[0], fma(row[1], v[1], row[2] * v[2]))


@subroutine
def _combined(row, q):
    return fma(row[0], q[0], row[1] * q[1]) + fma(row[2], q[2], row[3] * q[3])


@subroutine
def _applied(axes, v):
    """The product of a matrix and a vector."""
    return _along(axes[0], v), _along(axes[1], v), _along(axes[2], v)


@subroutine
def _store_attitude(frame, internal, block, i):
    """As `kernel._store_attitude`, in the same order of operations, into epoch i of a block."""
    ar, ai, br, bi = internal
    norm = fma(ar, ar, ai * ai) + fma(br, br, bi * bi)
    scale = 1.0 / math.sqrt(norm)
    unit = ar * scale, br * scale, bi * scale, ai * scale
    w, x = _combined(frame[0], unit), _combined(frame[1], unit)
    put_four(block, WXYZ + i, (w, x, _combined(frame[2], unit), _combined(frame[3], unit)))


@subroutine
def _precessed(invariant, sine, cosine):
    """The columns of a matrix, turned about its z by twice the angle of this sine and cosine."""
    c, s = fma(-2.0 * sine, sine, 1.0), 2.0 * sine * cosine
    one, two, three = invariant
    return _row_turned(one, c, s), _row_turned(two, c, s), _row_turned(three, c, s)


@subroutine
def _row_turned(row, c, s):
    return fma(row[0], c, row[1] * s), fma(row[1], c, -row[0] * s), row[2]


@elementwise
@force_inlined
def trigonometric_block(c, d, t, t_low, block):
    """Fill a block of a motion of the trigonometric form: by v, ln rho and X."""
    precession, nutation, nutation0 = pair(c.precession), pair(c.nutation), pair(c.nutation0)
    theta4, upright = five(d.series[0]), four(d.series[1])
    by_v = five(d.series[2]), five(d.series[3])
    by_rho = five(d.series[4]), five(d.series[5])
    by_x = five(d.series[6]), five(d.series[7])
    along, along_rho, along_x = d.upright[0], d.upright[1], d.upright[2]
    invariant = rows_of_matrix(d.invariant)
    for i in range(len(t)):
        time, low = epoch_pair(t, t_low, i)
        sn, cn = sincos_at(nutation, nutation0, time, low)
        sine, cosine = sincos_at(precession, ZERO, time, low)
        to = _precessed(invariant, sine, cosine)
        double_cosine = fma(-2.0 * sn, sn, 1.0)
        over = 1.0 / quartic(theta4, double_cosine)
        sine_over, cosine_over = over * sn, over * cn
        z = (2.0 * cn * sine_over) * cubic(upright, double_cosine)
        block[SECONDS + i] = time + low
        turn = (
            cosine_over * quartic(by_v[0], double_cosine),
            sine_over * quartic(by_v[1], double_cosine),
            along,
        )
        put_three(block, BASIS + i, _applied(to, turn))
        turn = (
            sine_over * quartic(by_rho[0], double_cosine),
            cosine_over * quartic(by_rho[1], double_cosine),
            along_rho * z,
        )
        put_three(block, BASIS + 3 * BLOCK + i, _applied(to, turn))
        turn = (
            sine_over * quartic(by_x[0], double_cosine),
            cosine_over * quartic(by_x[1], double_cosine),
            along_x * z,
        )
        put_three(block, BASIS + 6 * BLOCK + i, _applied(to, turn))
        put_four(block, ARGUMENTS + i, (sn, cn, sine, cosine))
        block[PASSED + i] = 0.0
        block[SCALED + i] = 0.0


@force_inlined
def decayed(size, remainder, decay, low):
    """E = 2^-((decay + low) (size + remainder)) with all its digits; 1/E but where it overflows."""
    a = decay * size
    b = fma(decay, size, -a) + fma(low, size, decay * remainder)
    e = exp2_of_minus(a) * fma(-LOG_2, chosen_if(a < 1000.0, b, 0.0), 1.0)
    return e, 1.0 / chosen_if(e > _TINY, e, _TINY)


@elementwise
@force_inlined
def hyperbolic_block(c, d, t, t_low, block):
    """Fill a block of a motion of the hyperbolic form: by y, d and Q'."""
    gh, gl = c.precession[0], c.precession[1]
    fh, fl = c.nutation[0], c.nutation[1]
    xh, xl = c.nutation0[0], c.nutation0[1]
    winds, nome, tilt = c.winds, d.nome, c.tilt
    decay, decay_low, passed_first = d.decay[0], d.decay[1], d.passed
    norm, less, more_than = four(d.series[0]), four(d.series[1]), four(d.series[6])
    real, imaginary = four(d.series[2]), four(d.series[3])
    real_slope, imaginary_slope = four(d.series[4]), four(d.series[5])
    upright, upright_nome = d.upright[0], d.upright[2]
    invariant = rows_of_matrix(d.invariant)
    unit = nome if winds != 0.0 else 1.0
    by_y, by_passed = -0.5 * LOG_2 * decay * d.by_third[0], -d.by_third[1]
    for i in range(len(t)):
        time, low = epoch_pair(t, t_low, i)
        s, lo, half_turns = phase(fh, fl, xh, xl, time, low, winds)
        dx, dx_low = quick_two_sum(s, lo)
        side = chosen_if(dx < 0.0, -1.0, 1.0)
        e, over = decayed(side * dx, side * dx_low, decay, decay_low)
        f, g, ee = nome * over, nome * e, e * e
        ff, gg = f * f, g * g
        inverse = 1.0 / fma(ee, quadratic(norm, gg), quadratic(norm, ff))
        # the turn about z by the second element, less 2 side
        along = side * inverse * fma(-ee, quadratic(more_than, gg), quadratic(less, ff))
        inverse = negated_if_odd(inverse, half_turns)
        s, lo, _ = phase(gh, gl, 0.0, 0.0, time, low, 1.0)
        s, more = two_sum(s, -tilt * dx)
        sine, cosine = sincos(s, lo + more)
        to = _precessed(invariant, sine, cosine)
        block[SECONDS + i] = time + low
        scale = e * inverse
        turn = (
            scale * fma(gg, _higher(real, gg), cubic(real, ff)),
            scale * side * fma(-gg, quadratic(imaginary, gg), ff * quadratic(imaginary, ff)),
            upright,
        )
        first = _applied(to, turn)
        put_three(block, BASIS + i, first)
        # the series are analytic in y + i d: i times the change
        put_three(block, BASIS + 3 * BLOCK + i, _applied(to, (-turn[1], turn[0], along)))
        # The number of the passage: whole turns of 2 x, which parity alone does not tell.
        passed = winds * rint(fma(fh, time, fma(fl, time, fh * low)) + xh - dx)
        block[PASSED + i] = fma(4.0, passed, 2.0 * side) - passed_first
        by_first = fma(by_passed, passed, by_y * dx)
        block[SCALED + i] = by_first
        by_f, by_g = unit * over * inverse, unit * e * ee * inverse
        turn = (
            side * fma(by_f, quadratic(real_slope, ff), -by_g * quadratic(real_slope, gg)),
            fma(by_f, quadratic(imaginary_slope, ff), by_g * quadratic(imaginary_slope, gg)),
            upright_nome * fma(2.0, side, along),
        )
        x, y, z = _applied(to, turn)
        x, y = fma(by_first, first[0], x), fma(by_first, first[1], y)
        put_three(block, BASIS + 6 * BLOCK + i, (x, y, fma(by_first, first[2], z)))
        put_four(block, ARGUMENTS + i, (dx, half_turns, sine, cosine))
        block[DECAYED + i] = e


@subroutine
def _higher(c, x):
    """c1 + c2 x + c3 x^2."""
    return fma(fma(c[3], x, c[2]), x, c[1])


@elementwise
@force_inlined
def trigonometric_attitudes_block(c, d, n, block):
    """Fill the attitudes of a block after `trigonometric_block`, and the rows of no passage."""
    alpha, beta = (four(c.alpha[0]), four(c.alpha[1])), (four(c.beta[0]), four(c.beta[1]))
    frame = frame_of(c)
    for i in range(n):
        sn, cn, sine, cosine = four_at(block, ARGUMENTS + i)
        internal = trigonometric_pair(alpha, beta, sn, cn)
        _store_attitude(frame, turned(internal, sine, cosine), block, i)


@elementwise
@force_inlined
def hyperbolic_attitudes_block(c, d, n, block):
    """Fill the attitudes of a block after `hyperbolic_block`."""
    alpha, ratio = (four(c.alpha[0]), four(c.alpha[1])), c.beta[0, 0]
    frame, decay, nome = frame_of(c), c.decay, c.nome
    for i in range(n):
        dx, half_turns, sine, cosine = four_at(block, ARGUMENTS + i)
        arguments = hyperbolic_arguments(dx, decay, nome)
        internal = hyperbolic_pair(alpha, ratio, dx, half_turns, arguments)
        _store_attitude(frame, turned(internal, sine, cosine), block, i)


@elementwise
@force_inlined
def trigonometric_rates_block(c, d, n, block):
    """Fill the angular velocities of a block after `trigonometric_block`, and their derivatives."""
    series, axes, by_phase = rate_series_of(c), rows_of_matrix(c.axes), triple(d.by_phase)
    one, two = five(d.by_nome[0]), five(d.by_nome[1])
    three, low = five(d.by_nome[2]), five(d.by_nome[3])
    for i in range(n):
        sn, cn = block[ARGUMENTS + i], block[ARGUMENTS + BLOCK + i]
        w = trigonometric_rates(series, sn, cn)
        double_cosine = fma(-2.0 * sn, sn, 1.0)
        over, slope = 1.0 / quartic(series[3], double_cosine), -quartic(low, double_cosine)
        change = (
            over * fma(w[0], slope, cn * quartic(one, double_cosine)),
            over * fma(w[1], slope, sn * quartic(two, double_cosine)),
            over * fma(w[2], slope, quartic(three, double_cosine)),
        )
        _store_changes(axes, by_phase, w, change, block, i)


@elementwise
@force_inlined
def hyperbolic_rates_block(c, d, n, block):
    """Fill the angular velocities of a block after `hyperbolic_block`, and their derivatives.

    Term n of the series has Q'^(2 n^2) exp(+-4 n y), in those of sn and of the denominator times
    Q'^(2 n): each is differentiated by Q'^2.
    """
    series, axes, by_phase = rate_series_of(c), rows_of_matrix(c.axes), triple(d.by_phase)
    nome = d.nome
    cn, sn, dn, low = series
    sixth = 6.0 * nome**6
    for i in range(n):
        dx, half_turns = block[ARGUMENTS + i], block[ARGUMENTS + BLOCK + i]
        e = block[DECAYED + i]
        over = 1.0 / chosen_if(e > _TINY, e, _TINY)
        arguments = e, nome * over, nome * e
        w = hyperbolic_rates(series, dx, half_turns, arguments)
        ee, ff, gg = e * e, arguments[1] * arguments[1], arguments[2] * arguments[2]
        inverse = 1.0 / fma(ee, quadratic(low, gg), quadratic(low, ff))
        slope_ff, slope_gg = fma(sixth, ff, 2.0) * ff, ee * (fma(sixth, gg, 2.0) * gg)
        slope = -(slope_ff + slope_gg)
        cube = e * ee
        sign = chosen_if(dx < 0.0, -1.0, 1.0)
        one = fma(over, fma(4.0 * cn[2], ff, cn[1]), cube * fma(4.0 * cn[2], gg, cn[1]))
        three = fma(over, fma(4.0 * dn[2], ff, dn[1]), cube * fma(4.0 * dn[2], gg, dn[1]))
        two = sn[0] * (fma(sixth, ff, -2.0) * ff - ee * (fma(sixth, gg, -2.0) * gg))
        change = (
            inverse * fma(w[0], slope, negated_if_odd(one, half_turns)),
            inverse * fma(w[1], slope, negated_if_odd(sign * two, half_turns)),
            inverse * fma(w[2], slope, three),
        )
        _store_changes(axes, by_phase, w, change, block, i)


@force_inlined
def _store_changes(axes, by_phase, w, change, block, i):
    """Store angular velocity (internal axes), and its derivatives by the phase and the nome."""
    turn = by_phase[0] * w[1] * w[2], by_phase[1] * w[2] * w[0], by_phase[2] * w[0] * w[1]
    put_three(block, OMEGA + i, w)
    put_three(block, BY_PHASE + i, _applied(axes, turn))
    put_three(block, BY_NOME + i, _applied(axes, change))


# ---- Series of the changes of attitude with nutation phase, amplitude and ellipticity
# The pair of docs/derivation.md is A = theta4(w | Q), b = -theta1(w | Q) with exp(2 i w) = X E^2, E
# = exp(i v) and Q = s X^2 = q^2, s = rho^4.  By the heat equation its derivatives at constant v are
# those by w,
#
#     d/dv = D,      d/d ln rho = -D^2,      d/dX = -(D^2 + i D) / (2X),
#
# so A b' - b A' takes the three forms V, -V' and -(V' + i V) / (2X) of the Wronskian
#
#     V = -theta4(0 | Q)^2 theta2(w | Q) theta3(w | Q)
#       = -theta4(0 | Q)^2 theta2(0 | q) theta2(w | q) / 2
#
# and, with N = |A|^2 + |b|^2 = theta4(v | q) theta3(i delta | q) and X = exp(-2 delta), the part
# 2 Im(A' conj A + b' conj b) / N along the momentum is
#
#     u,      -u X T,      -(u + 1) T / 2,      X T = theta4'(v | q) / theta4(v | q),
#
# u the constant Im theta3'(i delta | q) / theta3(i delta | q).  Every term is a product of numbers
# of at most 1, as q^(n^2 + n) X^-n = s^(n (n+1) / 2) X^(n^2).
#
# After the modular transformation, with W = y + i d and nome Q', the pair is
#
#     A = sum Q'^(n^2+n) cosh (2n+1) W,      b = - sum (-1)^n Q'^(n^2+n) sinh (2n+1) W
#
# but for a real factor, and with D by W,  d/dy = D,  d/dd = i D,  Q' d/dQ' = D^2 / 4:
#
#     V = -(sum Q'^(n^2+n))^2 theta4(0 | Q'^2) theta4(2 i W | Q'^2)
#     N = theta3(2 d | Q'^2) sum Q'^(2n^2+2n) cosh (4n+2) y
#
# and along the momentum u, 2 R and u R / 2, with u = -2 theta3'(2 d | Q'^2) / theta3(2 d | Q'^2)
# and R the quotient of sum (2n+1) Q'^(2n^2+2n) sinh (4n+2) y and the sum in N.


@subroutine
def fill_trigonometric(c, series, upright, fast):
    """Fill eight series in cos 2v and three factors along the momentum.

    Given
        fast     whether to leave out a exp(-iv) and i a exp(-iv) of x + i y of the first two
                 vectors, which turn with the slow precession of a needle

    Filled
        series   over theta4(v | q), which is the first: T without its factor sin 2v; then x and y
                 of the vectors by v, ln rho and X, without their factors cos v, sin v of the first
                 and sin v, cos v of the others
        upright  z of the first vector, and what T is multiplied by in the others

    Returned
        a
    """
    x, one_minus_x, rho, s = ellipticity(c)
    nome, square = s * x * x, rho * rho
    at_zero = 1.0 - 2.0 * nome * (1.0 - nome**3 * (1.0 - nome**5))
    product = 1.0 + nome * (1.0 + nome * nome * (1.0 + nome**3 * (1.0 + nome**4)))
    # theta3(i delta | q), its derivative, and their sum: term = rho^(2k^2) X^(k^2-k)
    norm, slope, both = 1.0, 0.0, 1.0
    term, step, even, loss = square, s * square, x * x, one_minus_x * (1.0 + x)
    for k in range(1, 7):
        norm += term * (1.0 + even)
        slope += k * term * loss
        both += term * (1.0 + even - 2.0 * k * loss)
        term *= step * even
        step *= s
        loss += even * (1.0 + x) * one_minus_x
        even *= x * x
    upright[0] = -2.0 * slope / norm
    upright[1] = 2.0 * x * slope / norm
    upright[2] = -0.5 * both / norm
    # theta4(v | q) and T: term = (-1)^k rho^(2k^2) X^(k^2-1)
    term, step, odd = -square, s * square, x
    for k in range(1, 5):
        for j in range(5):
            series[0, j] += 2.0 * term * x * COS_EVEN[k, j]
            series[1, j] -= 4.0 * k * term * SIN_EVEN[k, j]
        odd *= x * x
        term *= -step * odd
        step *= s
    # term = s^(n (n+1) / 2) X^(n^2), lower = term / X
    term, lower, step = 2.0 * rho * at_zero * at_zero * product / norm, 0.0, s
    even, loss, slow = 1.0, one_minus_x, -term
    for n in range(5):
        k, odd = 2.0 * n + 1.0, even * x
        less, more = n * lower, (n + 1.0) * term * even
        both, apart = 1.0 + odd, loss
        if fast and n == 0:
            both, apart = odd, -odd
        for j in range(5):
            cosine, sine = COS_ODD[n, j], SIN_ODD[n, j]
            series[2, j] -= term * both * cosine
            series[3, j] += term * apart * sine
            series[4, j] -= k * term * both * sine
            series[5, j] -= k * term * apart * cosine
            series[6, j] -= (more + less) * sine
            series[7, j] += (more - less) * cosine
        lower = term * step * even
        term = lower * x
        step *= s
        loss += odd * (1.0 + x) * one_minus_x
        even *= x * x
    for j in range(5):
        if fast:
            series[2, j] -= slow * series[0, j]
            series[3, j] += slow * series[0, j]
            series[4, j] -= slow * series[0, j]
            series[5, j] -= slow * series[0, j]
    series[0, 0] += 1.0
    return slow


@subroutine
def fast_vectors(series, upright, sn, cn):
    """The three vectors at a phase from series without slow parts, and their derivatives by it."""
    x, slope_of_x = fma(-2.0 * sn, sn, 1.0), -4.0 * sn * cn
    below, less = _with_slope(series[0], x)
    over = 1.0 / below
    less *= over * slope_of_x
    by_sine, by_cosine, by_both = (sn, cn), (cn, -sn), (2.0 * sn * cn, 2.0 * x)
    z, dz = _quotient(series[1], x, slope_of_x, by_both, over, less)
    a, da = _quotient(series[2], x, slope_of_x, by_cosine, over, less)
    b, db = _quotient(series[3], x, slope_of_x, by_sine, over, less)
    e, de = _quotient(series[4], x, slope_of_x, by_sine, over, less)
    f, df = _quotient(series[5], x, slope_of_x, by_cosine, over, less)
    g, dg = _quotient(series[6], x, slope_of_x, by_sine, over, less)
    h, dh = _quotient(series[7], x, slope_of_x, by_cosine, over, less)
    values = (a, b, 0.0), (e, f, upright[1] * z), (g, h, upright[2] * z)
    return values, ((da, db, 0.0), (de, df, upright[1] * dz), (dg, dh, upright[2] * dz))


@subroutine
def _with_slope(c, x):
    """A quartic and its derivative."""
    slope = fma(fma(fma(4.0 * c[4], x, 3.0 * c[3]), x, 2.0 * c[2]), x, c[1])
    return quartic(five(c), x), slope


@subroutine
def _quotient(c, x, slope_of_x, factor, over, less):
    """factor times a quartic over theta4, and its derivative by v."""
    above, slope = _with_slope(c, x)
    value = factor[0] * above * over
    return value, over * (factor[1] * above + factor[0] * slope * slope_of_x) - value * less


@subroutine
def in_inertial(invariant, sine, cosine, v):
    """A vector of the axes that turn by twice the angle of this sine and cosine, inertial axes."""
    return _applied(_precessed(rows_of_matrix(invariant), sine, cosine), v)


@subroutine
def fill_hyperbolic(c, d, series, upright):
    """Fill seven series in F^2 and G^2 and two factors along the momentum.

    Filled
        series   the sum in N and, first and last, that over it in 2 R -+ 2; real and imaginary
                 parts of V by N E, and of V' / 4 by N and by F/E or G E^3.  F and G as in
                 `series`
        upright  z of the first vector, and what 2 R is multiplied by in the third
    """
    nome, square = d.nome, d.nome * d.nome
    series[0, 0], series[0, 1], series[0, 2] = 1.0, square, square**4
    series[1, 1], series[1, 2] = 4.0 * square, 8.0 * square**4
    series[6, 0], series[6, 1], series[6, 2] = 4.0, 8.0 * square, 12.0 * square**4
    # theta3(2 d | Q'^2), and the sum of its derivative over Q'^2
    angle = math.pi * c.fraction
    norm, slope, power = 1.0, 0.0, 1.0
    for k in range(1, 4):
        norm += 2.0 * square * power * math.cos(k * angle)
        slope += k * power * math.sin(k * angle)
        power *= square ** (2 * k + 1)
    winds = c.winds != 0.0  # on the exact separatrix Q'^2 is the element
    upright[0] = 8.0 * square * slope / norm
    upright[2] = (2.0 * nome if winds else 1.0) * slope / norm
    whole = 1.0 + square * (1.0 + square * square)
    size = -4.0 * whole * whole * (1.0 - 2.0 * square * (1.0 - square**3)) / norm
    series[2, 0] = size
    for k in range(1, 4):
        size *= -(square ** (2 * (k - 1)))
        cosine, sine = size * math.cos(k * angle), size * math.sin(k * angle)
        series[2, k], series[3, k - 1] = cosine, sine
        share = k if winds else 0.5 * k
        series[4, k - 1], series[5, k - 1] = share * cosine, share * sine


@subroutine
def fill_rates(c, d):
    """Fill what the derivatives of the angular velocity need (records.TANGENTS).

    The factors of the series of cn, sn and dn depend on their nome as the amplitudes do: their
    changes are added to those of the amplitudes.
    """
    (i1, i2, i3), _w, (d12, d23, d13), _a, _side, _size, speed, (m, mc) = state_of(c)
    hyperbolic = c.form == codes.HYPERBOLIC
    # v' or y', the phase by time, without its sense
    if hyperbolic:
        by_time = speed * 0.25 * math.pi / integrals(mc, m)[0]
    else:
        by_time = speed * 0.5 * math.pi / integrals(m, mc)[0]
    over = math.ldexp(1.0 / by_time, -c.tempo)
    d.by_phase[0], d.by_phase[1] = over * d23 / i1, -over * d13 / i2
    d.by_phase[2] = over * d12 / i3
    q = d.nome * d.nome if hyperbolic else math.sqrt(c.nome)
    # theta2 / (2 q^(1/4)), theta3, theta4 and their derivatives
    two = 1.0 + q**2 + q**6 + q**12 + q**20
    two_slope = q * (2.0 + 6.0 * q**4 + 12.0 * q**10 + 20.0 * q**18)
    odd, even = q * (1.0 + q**8), q**4 * (1.0 + q**12)
    odd_slope, even_slope = 1.0 + 9.0 * q**8, q**3 * (4.0 + 16.0 * q**12)
    three, fourth = 1.0 + 2.0 * (even + odd), 1.0 + 2.0 * (even - odd)
    low2, low3 = two_slope / two, 2.0 * (even_slope + odd_slope) / three
    low4 = 2.0 * (even_slope - odd_slope) / fourth
    for j in range(COLUMNS):
        change = d.weights[NOME, j]
        d.amplitudes[0, j] += (low4 - low2 if not hyperbolic else low2 - low4) * change
        d.amplitudes[1, j] += (low3 - low2 if not hyperbolic else low3 - low4) * change
        d.amplitudes[2, j] += (low4 - low3 if not hyperbolic else low2 - low3) * change
    if hyperbolic:
        return
    factors = (
        c.amplitudes[0] * fourth / two,
        -c.amplitudes[1] * three / two,
        c.amplitudes[2] * fourth / three,
    )
    sign = -1.0
    for n in range(1, 5):
        # 2 n^2 q^(n^2-1) and n (n+1) q^(n^2+n-1)
        even, odd = 2.0 * n * n * q ** (n * n - 1), n * (n + 1.0) * q ** (n * n + n - 1)
        for k in range(5):
            d.by_nome[0, k] += factors[0] * odd * COS_ODD[n, k]
            d.by_nome[1, k] += factors[1] * sign * odd * SIN_ODD[n, k]
            d.by_nome[2, k] += factors[2] * even * COS_EVEN[n, k]
            d.by_nome[3, k] += sign * even * COS_EVEN[n, k]
        sign = -sign
