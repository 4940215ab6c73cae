"""The stages that fill the record of a motion: kind of motion, rates and phases, coefficients.

Nothing here cancels: differences of moments are computed from the inputs, and the invariants are
sums of terms of one sign.  Symbols and equation numbers are those of van Zon & Schofield (2006),
section 3.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from attitude._compilation.decorators import named, sized_entry_point, subroutine
from attitude._compilation.instructions import larger
from attitude._solver import codes
from attitude._solver.elliptic import complete_and_phase, quarter_and_fraction
from attitude._solver.kernel import any_of, at_start, plus, product, turned_by
from attitude._solver.series import (
    four,
    hyperbolic_arguments,
    hyperbolic_pair,
    phase,
    sincos,
    trigonometric_pair,
    turned,
)
from attitude._solver.twofloat import (
    HALF_PI,
    ONE,
    TWO_PI,
    ZERO,
    absolute,
    add,
    div,
    less,
    mul,
    neg,
    pair,
    product_added,
    put,
    rounded,
    same,
    scale,
    sqrt,
    square,
    sub,
)

if TYPE_CHECKING:
    from numpy.typing import NDArray


# ---- First stage: refuse what is not physical, find uniform rotations, and D2 of what tumbles
# The state is scaled by powers of two, so that no unit overflows or loses digits.  D2, the one
# invariant that is a difference of positive terms, is computed exactly where they cancel; its sign
# is the side of the separatrix.  Symbols are those of van Zon & Schofield (2006), section 3.

# The square of a rate below this fraction of the largest component would underflow: it is 0.
_NO_RATE = 2.0**-400
# Beside a larger one it changes D2 by less than 2^-200.
_RATE_TO_SPARE = 2.0**-300
_LARGEST_RATIO = 1e45
# Rounded moments may violate the triangle inequality by this fraction.
_ROUNDING = 1e-14
# D2 below this fraction of the sum of its terms is computed again, exactly.
_CANCELLED = 0.0625
# Parts of D2: two moments of 2, a difference of 4, a squared rate of 4, a product of 8.
_MOST_PARTS = 2 * 2 * 4 * 4 * 8


@sized_entry_point
def classify_all(moments, wxyz, omega, constants):
    """Check, scale and sort B states; how many have a fault, are uniform, and need D2 exactly.

    Given
        moments    (B, 3, 2) principal moments of inertia, pairs, any unit and order
        wxyz       (B, 4) body to inertial at the epoch
        omega      (B, 3, 2) rad/s over the principal axes, pairs
    Filled
        constants  (B,) fault, mode (as far as it does not depend on D2), form, the scaled state,
                   its ascending order, and D2 to the rounding of its terms
    """
    faults = uniform = cancelled = 0
    for b in range(len(constants)):
        c = constants[b]
        c.fault = _fault(moments[b], wxyz[b], omega[b])
        if c.fault != codes.FINE:
            faults += 1
            continue
        _scale(moments[b], omega[b], c)
        if _loses_a_rate(omega[b], c):
            c.fault = codes.LOST_RATE
            faults += 1
        elif _rotates_uniformly(c):
            uniform += 1
        elif _order(c):
            cancelled += 1
    return faults, uniform, cancelled


def refine_all(constants: NDArray[Any]) -> None:
    """Fill D2 of those of B states (records.CONSTANTS) whose terms cancel, rounded once."""
    # An array allocated in compiled code would cost another tenth of a second of compilation.
    _refine_all(constants, np.empty(_MOST_PARTS))


@sized_entry_point
def _refine_all(constants, expansion):
    """`refine_all`, with the memory of an expansion of _MOST_PARTS."""
    for b in range(len(constants)):
        c = constants[b]
        if c.fault == codes.FINE and c.cancelled == 1:
            put(c.d2, _exact_middle_invariant(c, expansion))


@subroutine
def _fault(moments, wxyz, omega):
    """The code of what is not physical in a state, or codes.FINE."""
    least, most, total = moments[0, 0], 0.0, 0.0
    for k in range(3):
        moment = moments[k, 0]
        if not (moment >= 0.0 and moment < math.inf):
            return codes.BAD_MOMENT
        if not abs(omega[k, 0]) < math.inf:
            return codes.BAD_RATE
        least, most, total = -larger(-least, -moment), larger(most, moment), total + moment
    size = 0.0
    for k in range(4):
        if not abs(wxyz[k]) < math.inf:
            return codes.BAD_ATTITUDE
        size = larger(size, abs(wxyz[k]))
    if size == 0.0:
        return codes.BAD_ATTITUDE
    if most == 0.0:
        return codes.BAD_MOMENT
    if most > (total - most) * (1.0 + _ROUNDING):
        return codes.NO_TRIANGLE
    if least > 0.0:
        return codes.RATIO_TOO_LARGE if least < most / _LARGEST_RATIO else codes.FINE
    for k in range(3):
        if moments[k, 0] == 0.0:
            i, j = (k + 1) % 3, (k + 2) % 3
            if moments[i, 0] != moments[j, 0] or moments[i, 1] != moments[j, 1]:
                return codes.UNEQUAL_ROD
            if omega[k, 0] != 0.0:
                return codes.SPIN_ABOUT_ROD
    return codes.FINE


@subroutine
def _scale(moments, omega, c):
    """The state times powers of two, the largest moment and rate being in [1/2, 1)."""
    most = fastest = 0.0
    for k in range(3):
        most, fastest = larger(most, moments[k, 0]), larger(fastest, abs(omega[k, 0]))
    inertia, tempo = math.frexp(most)[1], math.frexp(fastest)[1]
    c.tempo = tempo
    scaled_moments, scaled_omega = c.moments, c.omega
    for k in range(3):
        fast = abs(math.ldexp(omega[k, 0], -tempo)) >= _NO_RATE
        for half in range(2):
            scaled_moments[k, half] = math.ldexp(moments[k, half], -inertia)
            scaled_omega[k, half] = math.ldexp(omega[k, half], -tempo) if fast else 0.0


@subroutine
def _loses_a_rate(omega, c):
    """Whether a rate that counts as 0 decides how rotation about the middle axis turns over."""
    moments, scaled = c.moments, c.omega
    lost = False
    for k in range(3):
        lost = lost or (scaled[k, 0] == 0.0 and omega[k, 0] != 0.0)
    if lost:
        for k in range(3):
            i, j = k - 1, k - 2  # the other two
            mid, one, two = pair(moments[k]), pair(moments[i]), pair(moments[j])
            if (less(one, mid) and less(mid, two)) or (less(two, mid) and less(mid, one)):
                return larger(abs(scaled[i, 0]), abs(scaled[j, 0])) < _RATE_TO_SPARE
    return False


@subroutine
def _rotates_uniformly(c):
    """Whether every product (Ij - Ik) wj wk of Euler's equations has a factor 0; fill the mode."""
    moments, omega = c.moments, c.omega
    equal = still = 0
    for k in range(3):
        j = k - 1  # -1, 0, 1: the axis before it
        if same(pair(moments[k]), pair(moments[j])):
            equal += 1
        elif omega[k, 0] != 0.0 and omega[j, 0] != 0.0:
            return False
        if omega[k, 0] == 0.0:
            still += 1
    c.form = codes.UNIFORM
    if still == 3:
        c.mode = codes.AT_REST
    elif equal == 3:
        c.mode = codes.SPHERICAL
    else:
        c.mode = codes.PRINCIPAL_AXIS
    return True


@subroutine
def _order(c):
    """Fill the ascending order and D2 = L^2 - 2 E I2, positive for circulation about the axis of
    greatest inertia; whether D2 cancels.
    """
    # The next stage replaces it where the other form converges faster.
    c.form = codes.TRIGONOMETRIC
    p, q, r = 0, 1, 2
    moments, omega, order, gaps = c.moments, c.omega, c.order, c.gaps
    a, b, d = pair(moments[0]), pair(moments[1]), pair(moments[2])
    if less(b, a):
        p, q, a, b = q, p, b, a
    if less(d, b):
        q, r, b, d = r, q, d, b
    if less(b, a):
        p, q, a, b = q, p, b, a
    order[0], order[1], order[2] = p, q, r
    below, above = sub(b, a), sub(d, b)
    put(gaps[0], below)
    put(gaps[1], above)
    of_least = mul(mul(a, below), square(pair(omega[p])))
    of_greatest = mul(mul(d, above), square(pair(omega[r])))
    d2 = sub(of_greatest, of_least)
    put(c.d2, d2)
    cancelled = abs(d2[0]) < _CANCELLED * (of_greatest[0] + of_least[0])
    c.cancelled = 1 if cancelled else 0
    return cancelled


@subroutine
def _exact_middle_invariant(c, total):
    """d (d - b) wd^2 + a (a - b) wa^2, every product exact: 16 parts if the inputs are doubles."""
    count = np.int64(0)  # numba gives a literal its own type, and compiles callees for it too
    middle = c.moments[c.order[1]]
    for k in (2, 0):
        moment, rate = c.moments[c.order[k]], c.omega[c.order[k]]
        for i in range(2):
            for j in range(4):
                factor = moment[j] if j < 2 else -middle[j - 2]
                if moment[i] * factor == 0.0:
                    continue
                for m in range(2):
                    for n in range(2):
                        count = product_added(total, count, moment[i], factor, rate[m], rate[n])
    return rounded(total, count)


@sized_entry_point
def solve_all(constants):
    """Fill the rates and phases of those of B motions that tumble; returns how many hyperbolic."""
    hyperbolic = 0
    for b in range(len(constants)):
        c = constants[b]
        if c.fault == codes.FINE and c.form != codes.UNIFORM:
            jacobi(c)
            _solve(c)
            if c.form == codes.HYPERBOLIC:
                hyperbolic += 1
    return hyperbolic


@subroutine
def jacobi(c):
    """Jacobi ordering (3.32), by a proper signed permutation: the momentum circulates about the
    third axis, and the first and third rates are not negative.
    """
    d2, omega, axes = pair(c.d2), c.omega, c.jacobi
    # 2, 1, 0 or 0, 1, 2 of the ascending order
    last, c.mode = (0, codes.LONG_AXIS) if d2[0] < 0.0 else (2, codes.SHORT_AXIS)
    if d2[0] == 0.0:
        c.mode = codes.SEPARATRIX
    elif c.gaps[1 - last // 2, 0] == 0.0:
        c.mode = codes.SYMMETRIC
    put(c.d2, absolute(d2))
    first, third = c.order[2 - last], c.order[last]
    c.circulates = third
    axes[0] = first
    axes[1] = c.order[1]
    axes[2] = 1 if omega[first, 0] < 0.0 else 0
    axes[3] = 1 if omega[third, 0] < 0.0 else 0


@subroutine
def _solve(c):
    """Fill the rates and phases of the internal motion, computed in pairs."""
    first, second, minus1, minus3 = four(c.jacobi)
    third = 3 - first - second
    moments, omega, gaps = c.moments, c.omega, c.gaps
    i1, i2, i3 = pair(moments[first]), pair(moments[second]), pair(moments[third])
    w1, w2, w3 = absolute(pair(omega[first])), pair(omega[second]), absolute(pair(omega[third]))
    # The second axis keeps its direction where the permutation and both reversals are even.
    if ((second - first) % 3 + minus1 + minus3) % 2 == 0:
        w2 = neg(w2)
    long_axis = third == c.order[0]
    long = 1 if long_axis else 0
    d12, d23 = pair(gaps[long]), pair(gaps[1 - long])
    d13 = add(d12, d23)
    d1 = add(mul(mul(i2, d12), square(w2)), mul(mul(i3, d13), square(w3)))
    d3 = add(mul(mul(i1, d13), square(w1)), mul(mul(i2, d23), square(w2)))
    ll = add(add(square(mul(i1, w1)), square(mul(i2, w2))), square(mul(i3, w3)))
    momentum = sqrt(ll)
    bottom = mul(d1, d23)
    m = div(mul(d3, d12), bottom)
    mc = div(mul(pair(c.d2), d13), bottom)
    speed = sqrt(div(bottom, mul(mul(i1, i2), i3)))
    if not long_axis:
        speed = neg(speed)
    ratio = div(i3, i1)
    minus_n = mul(ratio, div(d12, d23))
    p = div(mul(i2, d13), mul(i1, d23))  # 1 - n
    # The greatest cosine l of the angle between L and the third axis, and 1 - l^2.
    l = sqrt(div(mul(i3, d1), mul(d13, ll)))
    c.wobble = math.sqrt(mul(i1, d3)[0] / mul(d13, ll)[0]) / (1.0 + l[0])
    amplitudes = c.amplitudes
    amplitudes[0] = math.sqrt(d3[0] / (i1[0] * d13[0]))
    amplitudes[1] = math.sqrt(d3[0] / (i2[0] * d23[0]))
    amplitudes[2] = math.sqrt(d1[0] / (i3[0] * d13[0]))
    for k in range(3):
        amplitudes[k] = math.ldexp(amplitudes[k], c.tempo)
    cosine = mul(w1, sqrt(mul(i1, d13)))
    sine = mul(absolute(w2), sqrt(mul(i2, d23)))
    c.m = m[0]
    put(c.mc, mc)
    if mc[0] == 0.0:
        _on_separatrix(div(momentum, mul(i2, TWO_PI)), speed, sine[0] / cosine[0], minus_n[0], c)
    else:
        quotient, quarter, turns = complete_and_phase(
            sqrt(mc), p, ZERO if long_axis else ONE, cosine, sine
        )
        put(c.quarter, quarter)
        periodic = div(mul(l, HALF_PI), mul(quarter, sqrt(p)))
        if long_axis:
            # Rearranged so that all terms are positive, also for a needle
            bracket = add(mul(div(d12, mul(i1, d23)), quotient), div(periodic, i3))
            bracket = add(ONE, mul(d13, bracket))
            precession = div(mul(momentum, bracket), mul(i1, TWO_PI))
        else:
            bracket = add(ONE, mul(div(d13, i1), sub(quotient, periodic)))
            precession = div(mul(momentum, bracket), mul(i3, TWO_PI))
        _choose_form(precession, div(speed, scale(quarter, 4.0)), turns, minus_n[0], c)
    # The momentum circulates in the other sense where the second rate is positive.
    if w2[0] > 0.0:
        put(c.nutation0, neg(pair(c.nutation0)))


@subroutine
def _store_rate(field, rate, tempo):
    """A pair, unscaled by 2^tempo, into a field of the record."""
    field[0] = math.ldexp(rate[0], tempo)
    field[1] = math.ldexp(rate[1], tempo)


@subroutine
def _choose_form(precession, nutation, turns, minus_n, c):
    """Fill the rates and phases, in turns, and the form: trigonometric for T = 2 K'/K >= 1."""
    precession = scale(precession, 0.5)
    # alpha turns at (phi' + psi')/2, beta at (phi' - psi')/2; psi' is that of the nutation
    c.psi_rate = math.ldexp(nutation[0], c.tempo)
    c.phi_rate = math.ldexp(sub(scale(precession, 2.0), nutation)[0], c.tempo)
    c.winds = c.fraction = 1.0
    c.stretch = math.inf
    if c.m > 0.0:
        other, c.fraction = quarter_and_fraction(math.sqrt(c.m), math.sqrt(minus_n), 1.0)
        c.stretch = 2.0 * other / c.quarter[0]
    times = 1.0
    c.form = codes.TRIGONOMETRIC
    if c.stretch < 1.0:
        times = 2.0
        c.form = codes.HYPERBOLIC
        c.decay = 2.0 * math.pi / (c.stretch * math.log(2.0))
        c.tilt = 0.25 * c.fraction
    put(c.nutation0, (times * turns[0], times * turns[1]))
    _store_rate(c.precession, precession, c.tempo)
    _store_rate(c.nutation, scale(nutation, times), c.tempo)


@subroutine
def _on_separatrix(turns, speed, tangent, minus_n, c):
    """Fill rates and phases for 2E = L^2/I2 exactly: y = (wp t + eps)/2 does not return."""
    c.form = codes.HYPERBOLIC
    c.phi_rate = math.ldexp(turns[0], c.tempo)
    _store_rate(c.precession, scale(turns, 0.5), c.tempo)
    _store_rate(c.nutation, scale(speed, 0.5), c.tempo)
    c.nutation0[0] = 0.5 * math.asinh(tangent)
    c.quarter[0] = math.inf
    c.decay = 2.0 / math.log(2.0)
    # eta / K' for m = 1, where F is the amplitude itself
    c.fraction = math.atan2(1.0, math.sqrt(minus_n)) / (0.5 * math.pi)


# ---- Third stage: coefficients of the series that the kernels evaluate at each phase
# One entry point for each form of the solution, so that a first propagation compiles only the form
# it needs.

# Coefficients in c = cos 2v, by row n: T_n of cos 2nv; the second kind of sin 2nv / sin 2v;
# the fourth and third kinds of sin (2n+1)v / sin v and cos (2n+1)v / cos v.
COS_EVEN = np.array(
    [[1, 0, 0, 0, 0], [0, 1, 0, 0, 0], [-1, 0, 2, 0, 0], [0, -3, 0, 4, 0], [1, 0, -8, 0, 8]], float
)
SIN_EVEN = np.array(
    [[0, 0, 0, 0, 0], [1, 0, 0, 0, 0], [0, 2, 0, 0, 0], [-1, 0, 4, 0, 0], [0, -4, 0, 8, 0]], float
)
SIN_ODD = np.array(
    [[1, 0, 0, 0, 0], [1, 2, 0, 0, 0], [-1, 2, 4, 0, 0], [-1, -4, 4, 8, 0], [1, -4, -12, 8, 16]],
    float,
)
COS_ODD = np.array(
    [[1, 0, 0, 0, 0], [-1, 2, 0, 0, 0], [-1, -2, 4, 0, 0], [1, -4, -4, 8, 0], [1, 4, -12, -8, 16]],
    float,
)


@subroutine
def ellipticity_of(c):
    """X = exp(-2 delta), 1 - X and P = Q exp(2 delta) of the trigonometric form."""
    if c.stretch == math.inf:  # symmetric
        return 0.0, 1.0, 0.0
    double_delta = 0.5 * math.pi * c.stretch * c.fraction
    x, one_minus_x = math.exp(-double_delta), -math.expm1(-double_delta)
    return x, one_minus_x, math.exp(double_delta - math.pi * c.stretch)


@subroutine
def _trigonometric_series(c):
    """Theta functions of nome Q by X and P: every term is a product of numbers of at most 1, also
    for a symmetric body, whose delta is infinite and whose Q is 0.
    """
    alpha, beta, (x, one_minus_x, p) = c.alpha, c.beta, ellipticity_of(c)
    c.nome = nome = math.exp(-math.pi * c.stretch)
    # Term by term: P^n Q^(n(n-1)), P^n Q^(n^2), X^(2n), and 1 - X^(2n), 1 - X^(2n+1) without the
    # cancellation at small delta (a needle's).
    outer = inner = even_x = sign = 1.0
    even_loss, odd_loss = 0.0, one_minus_x
    at_zero = theta4 = 0.0
    nome_n = 1.0
    for n in range(4):
        # theta4: Q^(n^2) exp(+-2n delta)
        even = sign * outer * (1.0 + even_x) if n > 0 else 1.0
        odd = -sign * outer * even_loss
        theta4 += even
        # theta1 exp(-delta): Q^(n(n+1)) exp(2n delta)
        odd_sum, odd_difference = sign * inner * (1.0 + even_x * x), sign * inner * odd_loss
        at_zero += odd_difference
        for k in range(4):
            alpha[0, k] += even * COS_EVEN[n, k]
            alpha[1, k] += odd * SIN_EVEN[n, k]
            beta[0, k] -= odd_sum * SIN_ODD[n, k]
            beta[1, k] -= odd_difference * COS_ODD[n, k]
        outer = inner * p * nome_n
        inner = outer * nome_n * nome
        nome_n *= nome
        even_loss += even_x * (1.0 + x) * one_minus_x
        odd_loss += even_x * x * (1.0 + x) * one_minus_x
        even_x *= x * x
        sign = -sign
    ratio = c.wobble * theta4 / at_zero
    for k in range(4):
        beta[0, k] *= ratio
        beta[1, k] *= ratio
    _trigonometric_start(c)


@subroutine
def _hyperbolic_series(c):
    """Theta functions after the modular transformation: nome Q', 0 on the exact separatrix."""
    d, alpha = 0.25 * math.pi * c.fraction, c.alpha
    c.nome = nome = math.exp(-math.pi / c.stretch)
    sign = weight = step = 1.0
    cosines = sines = 0.0
    for n in range(4):
        # weight = Q'^(n^2), step = Q'^n
        alpha[0, n] = weight * math.cos((2 * n + 1) * d)
        alpha[1, n] = weight * math.sin((2 * n + 1) * d)
        cosines += step * alpha[0, n]
        sines += sign * step * alpha[1, n]
        weight *= step * step * nome
        step *= nome
        sign = -sign
    c.beta[0, 0] = c.wobble * cosines / sines
    _hyperbolic_start(c)


@subroutine
def _trigonometric_start(c):
    """q_int(0), from the series that give q_int(t), so that both round alike."""
    s, lo, _ = phase(0.0, 0.0, c.nutation0[0], c.nutation0[1], 0.0, 0.0, 1.0)
    sine, cosine = sincos(s, lo)
    alpha, beta = (four(c.alpha[0]), four(c.alpha[1])), (four(c.beta[0]), four(c.beta[1]))
    _store(trigonometric_pair(alpha, beta, sine, cosine), c.internal)


@subroutine
def _hyperbolic_start(c):
    """q_int(0), as in `_trigonometric_start`."""
    s, lo, half_turns = phase(0.0, 0.0, c.nutation0[0], c.nutation0[1], 0.0, 0.0, c.winds)
    dx = s + lo
    arguments = hyperbolic_arguments(dx, c.decay, c.nome)
    alpha = four(c.alpha[0]), four(c.alpha[1])
    pair = hyperbolic_pair(alpha, c.beta[0, 0], dx, half_turns, arguments)
    sine, cosine = sincos(-c.tilt * dx, 0.0)
    _store(turned(pair, sine, cosine), c.internal)


@subroutine
def _store(pair, internal):
    """The pair (alpha, beta) as a quaternion w, x, y, z."""
    internal[0], internal[3], internal[1], internal[2] = pair


@subroutine
def _trigonometric_rates(c):
    """Amplitudes times cn, sn, dn as theta quotients, nome q; theta1, theta2 over 2 q^(1/4)."""
    q, rates = math.sqrt(c.nome), c.rates
    theta2 = theta3 = theta4 = 0.0
    sign = even = odd = step = 1.0
    for n in range(5):
        # even = 2 q^(n^2) (1 at n = 0), odd = q^(n(n+1)), step = q^n
        theta2 += odd
        theta3 += even
        theta4 += sign * even
        for k in range(5):
            rates[0, k] += odd * COS_ODD[n, k]
            rates[1, k] += sign * odd * SIN_ODD[n, k]
            rates[2, k] += even * COS_EVEN[n, k]
            rates[3, k] += sign * even * COS_EVEN[n, k]
        even = 2.0 * q if n == 0 else even * step * step * q
        odd *= step * step * q * q
        step *= q
        sign = -sign
    for k in range(5):
        rates[0, k] *= c.amplitudes[0] * theta4 / theta2
        rates[1, k] *= -c.amplitudes[1] * theta3 / theta2
        rates[2, k] *= c.amplitudes[2] * theta4 / theta3


@subroutine
def _hyperbolic_rates(c):
    """Amplitudes times cn, sn, dn after the modular transformation, nome Q'^2."""
    q = c.nome * c.nome
    qq = q * q
    theta2 = 1.0 + qq + qq * qq * qq
    theta3 = 1.0 + 2.0 * (q + qq * qq)
    theta4 = 1.0 - 2.0 * (q - qq * qq)
    cn = 2.0 * c.amplitudes[0] * theta2 / theta4
    sn = -c.amplitudes[1] * theta3 / theta4
    dn = 2.0 * c.amplitudes[2] * theta2 / theta3
    for n in range(3):
        sign = -1.0 if n == 1 else 1.0
        even = qq if n == 2 else 1.0  # q^(n(n-1))
        odd = 1.0 if n == 0 else (q if n == 1 else qq * qq)  # q^(n^2)
        c.rates[0, n] = cn * sign * even
        c.rates[1, n] = sn * sign * odd
        c.rates[2, n] = dn * even
        c.rates[3, n] = odd


def _stage_of(name, form, fill):
    """The stage that fills the records of those of B motions that have a form."""

    def stage(constants):
        for b in range(len(constants)):
            c = constants[b]
            if c.fault == codes.FINE and c.form == form:
                fill(c)

    return sized_entry_point(named(stage, name))


# Series of alpha and beta with q_int(0), then those of the angular velocity.
trigonometric_all = _stage_of("trigonometric_all", codes.TRIGONOMETRIC, _trigonometric_series)
hyperbolic_all = _stage_of("hyperbolic_all", codes.HYPERBOLIC, _hyperbolic_series)
trigonometric_rates_all = _stage_of(
    "trigonometric_rates_all", codes.TRIGONOMETRIC, _trigonometric_rates
)
hyperbolic_rates_all = _stage_of("hyperbolic_rates_all", codes.HYPERBOLIC, _hyperbolic_rates)


# ---- Constants of rotations about a fixed axis: spheres, principal axes, rest


@sized_entry_point
def uniform_all(wxyz, wxyz_low, principal, constants):
    """Fill the constants of those of B motions whose angular velocity is constant.

    q(t) = q(0) (cos + sin of half the angle times the unit axis): two rows of `frame`.

    Given
        wxyz       (B, 4) body to inertial at the epoch, of any length
        wxyz_low   (1 or B, 4) second doubles of wxyz, then of unit length; or zeros
        principal  (1 or B, 4) principal axes to given body axes
    """
    for b in range(len(constants)):
        c = constants[b]
        if c.fault == codes.FINE and c.form == codes.UNIFORM:
            low = four(wxyz_low[b if len(wxyz_low) > 1 else 0])
            _turn(four(wxyz[b]), low, four(principal[b if len(principal) > 1 else 0]), c)
            _periods(c)


@subroutine
def _turn(wxyz, low, principal, c):
    """Fill attitude, axis and rate of the turn."""
    x, y, z = pair(c.omega[0]), pair(c.omega[1]), pair(c.omega[2])
    speed = sqrt(add(add(square(x), square(y)), square(z)))
    turns = div(speed, TWO_PI)
    _store_rate(c.precession, (0.5 * turns[0], 0.5 * turns[1]), c.tempo)
    axis = turned_by(principal, (x[0], y[0], z[0]))
    over = 0.0 if speed[0] == 0.0 else 1.0 / speed[0]
    start = at_start(wxyz, low)
    axis_turn = 0.0, axis[0] * over, axis[1] * over, axis[2] * over
    turn = product(start, axis_turn)
    if any_of(low):
        turn = plus(turn, product(low, axis_turn))
    for k in range(4):
        c.frame[0, k] = start[k]
        c.frame[1, k] = turn[k]
    for k in range(3):
        c.rates[0, k] = math.ldexp(axis[k], c.tempo)


@subroutine
def _periods(c):
    """Fill the rates of psi and phi of a vanishing wobble about the axis."""
    c.circulates = -1
    turns = 2.0 * c.precession[0]
    psi, phi = 0.0, turns
    for k in range(3):
        if c.omega[k, 0] != 0.0:
            moment = pair(c.moments[k])
            one, two = pair(c.moments[(k + 1) % 3]), pair(c.moments[(k + 2) % 3])
            positive = sub(moment, one)[0] * sub(moment, two)[0]
            if positive > 0.0:
                root = math.sqrt(positive / (one[0] * two[0]))
                c.circulates = k
                if less(moment, one):
                    # phi' = turns (1 - root), without the cancellation of a needle's
                    one_less_square = moment[0] / one[0] * (sub(add(one, two), moment)[0] / two[0])
                    psi, phi = turns * root, turns * one_less_square / (1.0 + root)
                else:
                    psi, phi = -turns * root, turns * (1.0 + root)
    c.psi_rate = psi
    c.phi_rate = phi
