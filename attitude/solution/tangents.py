"""The changes of attitude with the elements of a motion, for a block of epochs.

A change (A', b') of the pair is the rotation vector (axes with z along the momentum)

    eta_z = 2 Im(A' conj A + b' conj b) / N,      eta_x + i eta_y = 2 exp(2 i Phi) (A b' - b A') / N

with N = |A|^2 + |b|^2 and the phase Phi of the precession; the normalisation of the pair drops out.

Given
    c, d       records of solution.record and solution.tangent_record
    t, t_low   (n,) seconds, n <= BLOCK; `t_low` may be None
Filled
    block      (ROWS BLOCK,) rows of solution.tangent_record: seconds, three vectors over inertial
               axes, the number of the passage, and the arguments from which the attitudes and the
               angular velocities follow
"""

import math

from attitude.compilation.decorators import force_inlined, subroutine
from attitude.compilation.instructions import fma, rint
from attitude.solution.kernel import axes_of, epoch_pair, frame_of, rate_series_of
from attitude.solution.phases import exp2_of_minus, negated_if_odd, phase, sincos
from attitude.solution.series import (
    cubic,
    four,
    hyperbolic_arguments,
    hyperbolic_pair,
    hyperbolic_rates,
    quadratic,
    quartic,
    trigonometric_pair,
    trigonometric_rates,
    turned,
)
from attitude.solution.tangent_record import (
    ARGUMENTS,
    BASIS,
    BLOCK,
    BY_NOME,
    BY_PHASE,
    DECAYED,
    OMEGA,
    PASSED,
    SCALED,
    SECONDS,
    WXYZ,
)
from attitude.solution.twofloat import quick_two_sum, two_sum

LOG_2 = math.log(2.0)
_TINY = 1e-300


@subroutine
def _matrix(a):
    return (
        (a[0, 0], a[0, 1], a[0, 2]),
        (a[1, 0], a[1, 1], a[1, 2]),
        (a[2, 0], a[2, 1], a[2, 2]),
    )


@subroutine
def _three(row):
    return row[0], row[1], row[2]


@subroutine
def _five(row):
    """The first five entries of an array as a tuple."""
    return row[0], row[1], row[2], row[3], row[4]


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
def _store_attitude(frame, pair, block, i):
    """As `kernel._store_attitude`, in the same order of operations, into epoch i of a block."""
    ar, ai, br, bi = pair
    norm = fma(ar, ar, ai * ai) + fma(br, br, bi * bi)
    scale = 1.0 / math.sqrt(norm)
    unit = ar * scale, br * scale, bi * scale, ai * scale
    block[WXYZ + i] = _combined(frame[0], unit)
    block[WXYZ + BLOCK + i] = _combined(frame[1], unit)
    block[WXYZ + 2 * BLOCK + i] = _combined(frame[2], unit)
    block[WXYZ + 3 * BLOCK + i] = _combined(frame[3], unit)


@subroutine
def _store(block, place, v):
    """A vector into three rows of a block, from a place of the first on."""
    block[place] = v[0]
    block[place + BLOCK] = v[1]
    block[place + 2 * BLOCK] = v[2]


@subroutine
def _precessed(invariant, sine, cosine):
    """The columns of a matrix, turned about its z by twice the angle of this sine and cosine."""
    c, s = fma(-2.0 * sine, sine, 1.0), 2.0 * sine * cosine
    return (
        (
            fma(invariant[0][0], c, invariant[0][1] * s),
            fma(invariant[0][1], c, -invariant[0][0] * s),
            invariant[0][2],
        ),
        (
            fma(invariant[1][0], c, invariant[1][1] * s),
            fma(invariant[1][1], c, -invariant[1][0] * s),
            invariant[1][2],
        ),
        (
            fma(invariant[2][0], c, invariant[2][1] * s),
            fma(invariant[2][1], c, -invariant[2][0] * s),
            invariant[2][2],
        ),
    )


@force_inlined
def trigonometric_block(c, d, t, t_low, block):
    """Fill a block of a motion of the trigonometric form: by v, ln rho and X."""
    gh, gl = c.precession[0], c.precession[1]
    fh, fl = c.nutation[0], c.nutation[1]
    xh, xl = c.nutation0[0], c.nutation0[1]
    theta4, upright = _five(d.series[0]), four(d.series[1])
    by_v, by_rho = (
        (_five(d.series[2]), _five(d.series[3])),
        (_five(d.series[4]), _five(d.series[5])),
    )
    by_x = _five(d.series[6]), _five(d.series[7])
    along, along_rho, along_x = d.upright[0], d.upright[1], d.upright[2]
    invariant = _matrix(d.invariant)
    for i in range(len(t)):
        time, low = epoch_pair(t, t_low, i)
        s, lo, _ = phase(fh, fl, xh, xl, time, low, 1.0)
        sn, cn = sincos(s, lo)
        s, lo, _ = phase(gh, gl, 0.0, 0.0, time, low, 1.0)
        sine, cosine = sincos(s, lo)
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
        x, y, w = _applied(to, turn)
        block[BASIS + i] = x
        block[BASIS + 1 * BLOCK + i] = y
        block[BASIS + 2 * BLOCK + i] = w
        turn = (
            sine_over * quartic(by_rho[0], double_cosine),
            cosine_over * quartic(by_rho[1], double_cosine),
            along_rho * z,
        )
        x, y, w = _applied(to, turn)
        block[BASIS + 3 * BLOCK + i] = x
        block[BASIS + 4 * BLOCK + i] = y
        block[BASIS + 5 * BLOCK + i] = w
        turn = (
            sine_over * quartic(by_x[0], double_cosine),
            cosine_over * quartic(by_x[1], double_cosine),
            along_x * z,
        )
        x, y, w = _applied(to, turn)
        block[BASIS + 6 * BLOCK + i] = x
        block[BASIS + 7 * BLOCK + i] = y
        block[BASIS + 8 * BLOCK + i] = w
        block[ARGUMENTS + i] = sn
        block[ARGUMENTS + BLOCK + i] = cn
        block[ARGUMENTS + 2 * BLOCK + i] = sine
        block[ARGUMENTS + 3 * BLOCK + i] = cosine
        block[PASSED + i] = 0.0
        block[SCALED + i] = 0.0


@force_inlined
def decayed(size, rest, decay, low):
    """E = 2^-((decay + low) (size + rest)) with all its digits, and 1/E but where it overflows."""
    a = decay * size
    b = fma(decay, size, -a) + fma(low, size, decay * rest)
    e = exp2_of_minus(a) * fma(-LOG_2, b if a < 1000.0 else 0.0, 1.0)
    return e, 1.0 / (e if e > _TINY else _TINY)


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
    invariant = _matrix(d.invariant)
    unit = nome if winds != 0.0 else 1.0
    by_y, by_passed = -0.5 * LOG_2 * decay * d.by_third[0], -d.by_third[1]
    for i in range(len(t)):
        time, low = epoch_pair(t, t_low, i)
        s, lo, half_turns = phase(fh, fl, xh, xl, time, low, winds)
        dx, rest = quick_two_sum(s, lo)
        side = -1.0 if dx < 0.0 else 1.0
        e, over = decayed(side * dx, side * rest, decay, decay_low)
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
        _store(block, BASIS + i, first)
        # the series are analytic in y + i d: i times the change
        _store(block, BASIS + 3 * BLOCK + i, _applied(to, (-turn[1], turn[0], along)))
        # The number of the passage: whole turns of 2 x, which parity alone does not tell.
        passed = winds * rint(fma(fh, time, fma(fl, time, fh * low)) + xh - dx)
        block[PASSED + i] = fma(4.0, passed, 2.0 * side) - passed_first
        by_first = fma(by_passed, passed, by_y * dx)
        block[SCALED + i] = by_first
        near, far = unit * over * inverse, unit * e * ee * inverse
        turn = (
            side * fma(near, quadratic(real_slope, ff), -far * quadratic(real_slope, gg)),
            fma(near, quadratic(imaginary_slope, ff), far * quadratic(imaginary_slope, gg)),
            upright_nome * fma(2.0, side, along),
        )
        x, y, z = _applied(to, turn)
        block[BASIS + 6 * BLOCK + i] = fma(by_first, first[0], x)
        block[BASIS + 7 * BLOCK + i] = fma(by_first, first[1], y)
        block[BASIS + 8 * BLOCK + i] = fma(by_first, first[2], z)
        block[ARGUMENTS + i] = dx
        block[DECAYED + i] = e
        block[ARGUMENTS + BLOCK + i] = half_turns
        block[ARGUMENTS + 2 * BLOCK + i] = sine
        block[ARGUMENTS + 3 * BLOCK + i] = cosine


@subroutine
def _higher(c, x):
    """c1 + c2 x + c3 x^2."""
    return fma(fma(c[3], x, c[2]), x, c[1])


@force_inlined
def trigonometric_attitudes_block(c, n, block):
    """Fill the attitudes of a block after `trigonometric_block`, and the rows of no passage."""
    alpha, beta = (four(c.alpha[0]), four(c.alpha[1])), (four(c.beta[0]), four(c.beta[1]))
    frame = frame_of(c)
    for i in range(n):
        sn, cn = block[ARGUMENTS + i], block[ARGUMENTS + BLOCK + i]
        sine, cosine = block[ARGUMENTS + 2 * BLOCK + i], block[ARGUMENTS + 3 * BLOCK + i]
        pair = trigonometric_pair(alpha, beta, sn, cn)
        _store_attitude(frame, turned(pair, sine, cosine), block, i)


@force_inlined
def hyperbolic_attitudes_block(c, n, block):
    """Fill the attitudes of a block after `hyperbolic_block`."""
    alpha, ratio = (four(c.alpha[0]), four(c.alpha[1])), c.beta[0, 0]
    frame, decay, nome = frame_of(c), c.decay, c.nome
    for i in range(n):
        dx, half_turns = block[ARGUMENTS + i], block[ARGUMENTS + BLOCK + i]
        sine, cosine = block[ARGUMENTS + 2 * BLOCK + i], block[ARGUMENTS + 3 * BLOCK + i]
        arguments = hyperbolic_arguments(dx, decay, nome)
        pair = hyperbolic_pair(alpha, ratio, dx, half_turns, arguments)
        _store_attitude(frame, turned(pair, sine, cosine), block, i)


@force_inlined
def trigonometric_rates_block(c, d, n, block):
    """Fill the angular velocities of a block after `trigonometric_block`, and their derivatives."""
    series, axes, by_phase = rate_series_of(c), axes_of(c), _three(d.by_phase)
    one, two = _five(d.by_nome[0]), _five(d.by_nome[1])
    three, low = _five(d.by_nome[2]), _five(d.by_nome[3])
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


@force_inlined
def hyperbolic_rates_block(c, d, n, block):
    """Fill the angular velocities of a block after `hyperbolic_block`, and their derivatives.

    Term n of the series has Q'^(2 n^2) exp(+-4 n y), in those of sn and of the denominator times
    Q'^(2 n): each is differentiated by Q'^2.
    """
    series, axes, by_phase, nome = rate_series_of(c), axes_of(c), _three(d.by_phase), d.nome
    cn, sn, dn, low = series
    sixth = 6.0 * nome**6
    for i in range(n):
        dx, half_turns = block[ARGUMENTS + i], block[ARGUMENTS + BLOCK + i]
        e = block[DECAYED + i]
        over = 1.0 / (e if e > _TINY else _TINY)
        arguments = e, nome * over, nome * e
        w = hyperbolic_rates(series, dx, half_turns, arguments)
        ee, ff, gg = e * e, arguments[1] * arguments[1], arguments[2] * arguments[2]
        inverse = 1.0 / fma(ee, quadratic(low, gg), quadratic(low, ff))
        near, far = fma(sixth, ff, 2.0) * ff, ee * (fma(sixth, gg, 2.0) * gg)
        slope = -(near + far)
        cube = e * ee
        sign = -1.0 if dx < 0.0 else 1.0
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
    _store(block, OMEGA + i, w)
    _store(block, BY_PHASE + i, _applied(axes, turn))
    _store(block, BY_NOME + i, _applied(axes, change))
