"""From moments of inertia and a state to the numbers that hold the motion for ever.

Everything here is scale-free and free of cancellation: differences of moments are formed from the
inputs, the invariants are sums of terms of one sign, and the one true difference (D2, which
decides the regime) is formed exactly.  Symbols are those of van Zon & Schofield (2006), section 3;
the equation numbers are theirs.
"""

import math

import numpy as np

from attitude.solution import codes
from attitude.solution.elliptic import complete_and_phase, quarter_and_fraction
from attitude.solution.expansion import added, rounded, times
from attitude.solution.machine import inlined
from attitude.solution.series import (
    hyperbolic_arguments,
    hyperbolic_pair,
    trigonometric_pair,
    turned,
)
from attitude.solution.turns import LONGEST, phase, sincos
from attitude.solution.twofloat import (
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
    same,
    scale,
    sqrt,
    square,
    sub,
)

# Below this fraction of the largest component, a rate would vanish in the squares anyway.
_NO_RATE = 2.0**-400
_LARGEST_RATIO = 1e45
# What a sum or a product of measured moments may miss the triangle inequality by.
_ROUNDING = 1e-14

# Coefficients in c = cos 2v, by row n: T_n of cos 2nv; the second kind of sin 2nv / sin 2v;
# the fourth and third kinds of sin (2n+1)v / sin v and cos (2n+1)v / cos v.
_COS_EVEN = np.array(
    [[1, 0, 0, 0, 0], [0, 1, 0, 0, 0], [-1, 0, 2, 0, 0], [0, -3, 0, 4, 0], [1, 0, -8, 0, 8]], float
)
_SIN_EVEN = np.array([[0, 0, 0, 0], [1, 0, 0, 0], [0, 2, 0, 0], [-1, 0, 4, 0]], float)
_SIN_ODD = np.array(
    [[1, 0, 0, 0, 0], [1, 2, 0, 0, 0], [-1, 2, 4, 0, 0], [-1, -4, 4, 8, 0], [1, -4, -12, 8, 16]],
    float,
)
_COS_ODD = np.array(
    [[1, 0, 0, 0, 0], [-1, 2, 0, 0, 0], [-1, -2, 4, 0, 0], [1, -4, -4, 8, 0], [1, 4, -12, -8, 16]],
    float,
)


@inlined
def classify(moments, wxyz, omega, axes, c):
    """First stage: what is wrong, the mode, the Jacobi ordering; all of it for uniform rotation.

    Given
        moments  (3, 2) principal moments of inertia, pairs, any unit and order
        wxyz     (4,) body to inertial at the epoch, of any length
        omega    (3, 2) rad/s over the principal axes, pairs
        axes     (3, 3) columns: the principal axes in the given body axes
    """
    c.fault = _fault(moments, wxyz, omega)
    if c.fault != codes.FINE:
        return
    inertia = math.frexp(max(moments[0, 0], moments[1, 0], moments[2, 0]))[1]
    i0, i1, i2 = (
        _scaled(moments[0], -inertia),
        _scaled(moments[1], -inertia),
        _scaled(moments[2], -inertia),
    )
    fastest = max(abs(omega[0, 0]), abs(omega[1, 0]), abs(omega[2, 0]))
    tempo = math.frexp(fastest)[1]
    w0, w1, w2 = _rate(omega[0], -tempo), _rate(omega[1], -tempo), _rate(omega[2], -tempo)
    c.tempo = tempo

    # Every torque-free product (Ij - Ik) wj wk vanishes, each seen by its factors.
    still0, still1, still2 = w0[0] == 0.0, w1[0] == 0.0, w2[0] == 0.0
    if (
        (same(i0, i1) or still0 or still1)
        and (same(i1, i2) or still1 or still2)
        and (same(i2, i0) or still2 or still0)
    ):
        if fastest == 0.0:
            c.mode = codes.AT_REST
        elif same(i0, i1) and same(i1, i2):
            c.mode = codes.SPHERICAL
        else:
            c.mode = codes.PRINCIPAL_AXIS
        _uniform((i0, i1, i2), (w0, w1, w2), _unit(wxyz), axes, c)
    else:
        _tumbling((i0, i1, i2), (w0, w1, w2), axes, c)


@inlined
def _fault(moments, wxyz, omega):
    least, most, total = moments[0, 0], 0.0, 0.0
    for k in range(3):
        moment = moments[k, 0]
        if not (moment >= 0.0 and moment < math.inf):
            return codes.BAD_MOMENT
        if not abs(omega[k, 0]) < math.inf:
            return codes.BAD_RATE
        least, most, total = min(least, moment), max(most, moment), total + moment
    size = max(abs(wxyz[0]), abs(wxyz[1]), abs(wxyz[2]), abs(wxyz[3]))
    sum_of_all = wxyz[0] + wxyz[1] + wxyz[2] + wxyz[3]
    if not (size > 0.0 and size < math.inf) or sum_of_all != sum_of_all:
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


@inlined
def _scaled(pair, exponent):
    return math.ldexp(pair[0], exponent), math.ldexp(pair[1], exponent)


@inlined
def _rate(pair, exponent):
    hi = math.ldexp(pair[0], exponent)
    if abs(hi) < _NO_RATE:
        return 0.0, 0.0
    return hi, math.ldexp(pair[1], exponent)


@inlined
def _store_rate(field, rate, tempo):
    field[0], field[1] = math.ldexp(rate[0], tempo), math.ldexp(rate[1], tempo)


@inlined
def _unit(wxyz):
    size = max(abs(wxyz[0]), abs(wxyz[1]), abs(wxyz[2]), abs(wxyz[3]))
    w, x, y, z = wxyz[0] / size, wxyz[1] / size, wxyz[2] / size, wxyz[3] / size
    size = 1.0 / math.sqrt(w * w + x * x + y * y + z * z)
    return w * size, x * size, y * size, z * size


@inlined
def _uniform(moments, rates, start, axes, c):
    """Constant angular velocity: q(t) = q(0) (cos + sin of half the angle times the unit axis)."""
    c.form = codes.UNIFORM
    a, b, d = rates
    speed = sqrt(add(add(square(a), square(b)), square(d)))
    turns = div(speed, TWO_PI)
    _store_rate(c.precession, scale(turns, 0.5), c.tempo)
    over = 0.0 if speed[0] == 0.0 else 1.0 / speed[0]
    x = axes[0, 0] * a[0] + axes[0, 1] * b[0] + axes[0, 2] * d[0]
    y = axes[1, 0] * a[0] + axes[1, 1] * b[0] + axes[1, 2] * d[0]
    z = axes[2, 0] * a[0] + axes[2, 1] * b[0] + axes[2, 2] * d[0]
    turn = _quaternion_product(start, (0.0, x * over, y * over, z * over))
    for k in range(4):
        c.frame[0, k] = start[k]
        c.frame[1, k] = turn[k]
    c.rates[0, 0] = math.ldexp(x, c.tempo)
    c.rates[0, 1] = math.ldexp(y, c.tempo)
    c.rates[0, 2] = math.ldexp(z, c.tempo)
    # The periods are those of a vanishing wobble about the same axis.
    c.circulates = -1
    psi = 0.0
    for k in range(3):
        if rates[k][0] != 0.0:
            here, one, two = moments[k], moments[(k + 1) % 3], moments[(k + 2) % 3]
            product = sub(here, one)[0] * sub(here, two)[0]
            if product > 0.0:
                psi = turns[0] * math.sqrt(product / (one[0] * two[0]))
                psi = psi if less(here, one) else -psi
                c.circulates = k
    c.psi_rate = math.ldexp(psi, c.tempo)
    c.phi_rate = math.ldexp(turns[0] - psi, c.tempo)


@inlined
def _tumbling(moments, rates, axes, c):
    p, q, r = _ascending(moments)
    d2 = _middle_invariant(moments[p], moments[q], moments[r], rates[p], rates[r])
    # Jacobi ordering (3.32): the angular momentum circulates about the internal third axis.
    if d2[0] < 0.0:
        first, second, third = r, q, p
        c.mode = codes.LONG_AXIS
    else:
        first, second, third = p, q, r
        c.mode = codes.SHORT_AXIS
    if d2[0] == 0.0:
        c.mode = codes.SEPARATRIX
    elif same(moments[first], moments[second]):
        c.mode = codes.SYMMETRIC
    c.circulates = third

    # A proper signed permutation makes the first and third components non-negative.
    s1 = -1.0 if rates[first][0] < 0.0 else 1.0
    s3 = -1.0 if rates[third][0] < 0.0 else 1.0
    even = (second - first) % 3 == 1
    s2 = s1 * s3 if even else -s1 * s3
    for k in range(3):
        c.axes[k, 0] = s1 * axes[k, first]
        c.axes[k, 1] = s2 * axes[k, second]
        c.axes[k, 2] = s3 * axes[k, third]
    for k, given, sign in ((0, first, s1), (1, second, s2), (2, third, s3)):
        c.ordered_moments[k, 0], c.ordered_moments[k, 1] = moments[given]
        c.ordered_rates[k, 0], c.ordered_rates[k, 1] = scale(rates[given], sign)
    c.d2[0], c.d2[1] = absolute(d2)
    # Replaced by the second stage where the other form serves better.
    c.form = codes.TRIGONOMETRIC


@inlined
def _ascending(moments):
    p, q, r = 0, 1, 2
    if less(moments[q], moments[p]):
        p, q = q, p
    if less(moments[r], moments[q]):
        q, r = r, q
    if less(moments[q], moments[p]):
        p, q = q, p
    return p, q, r


@inlined
def _middle_invariant(a, b, d, wa, wd):
    """D2 = L^2 - 2 E b for moments a <= b <= d: positive where L circulates about d's axis."""
    short = mul(mul(a, sub(b, a)), square(wa))
    long = mul(mul(d, sub(d, b)), square(wd))
    d2 = sub(long, short)
    if abs(d2[0]) >= 0.0625 * (long[0] + short[0]):
        return d2
    # Near the separatrix the leading digits cancel: form the products exactly, then subtract.
    return _exact_difference(a, b, d, wa, wd)


@inlined
def _exact_difference(a, b, d, wa, wd):
    """d (d - b) wd^2 + a (a - b) wa^2, every product exact, rounded once.

    A product of a pair doubles the number of parts twice: 4 of the difference become 256 at the
    most, and 16 when the inputs are doubles (Shewchuk's zeros are dropped on the way).
    """
    one, two = np.empty(256), np.empty(256)
    total = np.empty(512)
    count = 0
    for moment, rate in ((d, wd), (a, wa)):
        n = 0
        for x in (moment[0], moment[1], -b[0], -b[1]):
            n = added(one, n, x)
        n = times(one, n, moment, two)
        n = times(two, n, rate, one)
        n = times(one, n, rate, two)
        for i in range(n):
            count = added(total, count, two[i])
    return rounded(total, count)


@inlined
def solve(c):
    """Second stage: rates, phases and series of the internal motion; pairs throughout."""
    i1, i2, i3 = (
        _pair(c.ordered_moments[0]),
        _pair(c.ordered_moments[1]),
        _pair(c.ordered_moments[2]),
    )
    w1, w2, w3 = _pair(c.ordered_rates[0]), _pair(c.ordered_rates[1]), _pair(c.ordered_rates[2])
    d2 = _pair(c.d2)
    d12, d13, d23 = absolute(sub(i1, i2)), absolute(sub(i1, i3)), absolute(sub(i2, i3))
    long_axis = less(i3, i1)
    d1 = add(mul(mul(i2, d12), square(w2)), mul(mul(i3, d13), square(w3)))
    d3 = add(mul(mul(i1, d13), square(w1)), mul(mul(i2, d23), square(w2)))
    ll = add(add(square(mul(i1, w1)), square(mul(i2, w2))), square(mul(i3, w3)))
    momentum = sqrt(ll)
    bottom = mul(d1, d23)
    m = div(mul(d3, d12), bottom)
    mc = div(mul(d2, d13), bottom)
    speed = sqrt(div(bottom, mul(mul(i1, i2), i3)))
    if not long_axis:
        speed = neg(speed)
    ratio = div(i3, i1)
    minus_n = mul(ratio, div(d12, d23))
    p = div(mul(i2, d13), mul(i1, d23))  # 1 - n
    # The greatest cosine l of the angle between L and the third axis, and 1 - l^2.
    l = sqrt(div(mul(i3, d1), mul(d13, ll)))
    rest = mul(i1, d3)[0] / mul(d13, ll)[0]
    wobble = math.sqrt(rest) / (1.0 + l[0])  # sqrt((1 - l) / (1 + l))
    amplitudes = (
        math.sqrt(d3[0] / (i1[0] * d13[0])),
        math.sqrt(d3[0] / (i2[0] * d23[0])),
        math.sqrt(d1[0] / (i3[0] * d13[0])),
    )
    cosine = mul(w1, sqrt(mul(i1, d13)))
    sine = mul(absolute(w2), sqrt(mul(i2, d23)))
    backwards = w2[0] > 0.0
    for k in range(3):
        c.amplitudes[k] = math.ldexp(amplitudes[k], c.tempo)
    c.m = m[0]
    c.mc[0], c.mc[1] = mc
    if mc[0] == 0.0:
        _on_separatrix(i2, momentum, speed, cosine, sine, backwards, c)
        fraction = _fraction_at_separatrix(minus_n[0])
        _hyperbolic_series(0.0, fraction, wobble, amplitudes, c)
        return

    quotient, quarter, turns = complete_and_phase(
        sqrt(mc), p, ZERO if long_axis else ONE, cosine, sine
    )
    c.quarter[0], c.quarter[1] = quarter
    root = sqrt(p)
    periodic = div(mul(l, HALF_PI), mul(quarter, root))
    if long_axis:
        # (3.42) rearranged so that all terms are positive, also for a needle
        bracket = add(mul(div(d12, mul(i1, d23)), quotient), div(periodic, i3))
        bracket = add(ONE, mul(d13, bracket))
        precession = div(mul(momentum, bracket), mul(i1, TWO_PI))
    else:
        bracket = add(ONE, mul(div(d13, i1), sub(quotient, periodic)))
        precession = div(mul(momentum, bracket), mul(i3, TWO_PI))
    precession = scale(precession, 0.5)
    nutation = div(speed, scale(quarter, 4.0))
    if backwards:
        turns = neg(turns)
    _store_rate(c.precession, precession, c.tempo)
    # alpha turns at (phi' + psi')/2, beta at (phi' - psi')/2; psi' is that of the nutation
    c.psi_rate = math.ldexp(nutation[0], c.tempo)
    c.phi_rate = math.ldexp(sub(scale(precession, 2.0), nutation)[0], c.tempo)

    if m[0] > 0.0:
        other, fraction = quarter_and_fraction(math.sqrt(m[0]), math.sqrt(minus_n[0]), 1.0)
        stretch = 2.0 * other / quarter[0]
    else:
        fraction, stretch = 1.0, math.inf
    c.winds = 1.0
    if stretch >= 1.0:
        c.form = codes.TRIGONOMETRIC
        _store_rate(c.nutation, nutation, c.tempo)
        c.nutation0[0], c.nutation0[1] = turns
        _trigonometric_series(stretch, fraction, root[0], wobble, amplitudes, c)
    else:
        c.form = codes.HYPERBOLIC
        _store_rate(c.nutation, scale(nutation, 2.0), c.tempo)
        c.nutation0[0], c.nutation0[1] = 2.0 * turns[0], 2.0 * turns[1]
        c.decay = 2.0 * math.pi / (stretch * math.log(2.0))
        c.tilt = 0.25 * fraction
        _hyperbolic_series(math.exp(-math.pi / stretch), fraction, wobble, amplitudes, c)


@inlined
def _on_separatrix(i2, momentum, speed, cosine, sine, backwards, c):
    """2E = L^2/I2 exactly: y = (wp t + eps)/2 runs once from end to end, and never returns."""
    c.form = codes.HYPERBOLIC
    c.winds = 0.0
    turns = div(momentum, mul(i2, TWO_PI))
    c.psi_rate, c.phi_rate = 0.0, math.ldexp(turns[0], c.tempo)
    _store_rate(c.precession, scale(turns, 0.5), c.tempo)
    _store_rate(c.nutation, scale(speed, 0.5), c.tempo)
    eps = math.asinh(sine[0] / cosine[0])
    c.nutation0[0] = -0.5 * eps if backwards else 0.5 * eps
    c.nutation0[1] = 0.0
    c.quarter[0], c.quarter[1] = math.inf, 0.0
    c.decay = 2.0 / math.log(2.0)
    c.tilt = 0.0


@inlined
def _fraction_at_separatrix(minus_n):
    """eta / K' for m = 1, where F is the amplitude itself."""
    return math.atan2(1.0, math.sqrt(minus_n)) / (0.5 * math.pi)


@inlined
def _trigonometric_series(stretch, fraction, root, wobble, amplitudes, c):
    """Series of alpha, beta (nome Q) and of the angular velocity (nome q = sqrt Q).

    With X = exp(-2 delta), P = Q exp(2 delta): every term is a product of numbers at most 1,
    so that nothing overflows for a symmetric body, where delta is infinite and Q is 0.
    """
    if stretch < math.inf:
        double_delta = 0.5 * math.pi * stretch * fraction
        x = math.exp(-double_delta)
        one_minus_x = -math.expm1(-double_delta)
        nome = math.exp(-math.pi * stretch)
        p = math.exp(double_delta - math.pi * stretch)
    else:  # m = 0: tanh delta = 1 / sqrt(1 - n)
        one_minus_x = 2.0 / (root + 1.0)
        x = (root - 1.0) / (root + 1.0)
        nome = p = 0.0
    c.nome = nome

    for k in range(4):
        c.alpha[0, k] = c.alpha[1, k] = c.beta[0, k] = c.beta[1, k] = 0.0
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
            c.alpha[0, k] += even * _COS_EVEN[n, k]
            c.alpha[1, k] += odd * _SIN_EVEN[n, k]
            c.beta[0, k] -= odd_sum * _SIN_ODD[n, k]
            c.beta[1, k] -= odd_difference * _COS_ODD[n, k]
        outer, inner = inner * p * nome_n, inner * p * nome_n * nome_n * nome
        nome_n *= nome
        even_loss += even_x * (1.0 + x) * one_minus_x
        odd_loss += even_x * x * (1.0 + x) * one_minus_x
        even_x *= x * x
        sign = -sign
    ratio = wobble * theta4 / at_zero
    for k in range(4):
        c.beta[0, k] *= ratio
        c.beta[1, k] *= ratio
    _trigonometric_rate_series(math.exp(-0.5 * math.pi * stretch), amplitudes, c)


@inlined
def _trigonometric_rate_series(q, amplitudes, c):
    """cn, sn, dn as theta quotients; theta1 and theta2 without their factor 2 q^(1/4)."""
    for k in range(5):
        for row in range(4):
            c.rates[row, k] = 0.0
    theta2 = theta3 = theta4 = 0.0
    sign = even = odd = step = 1.0
    for n in range(5):
        # even = 2 q^(n^2) (1 at n = 0), odd = q^(n(n+1)), step = q^n
        theta2 += odd
        theta3 += even
        theta4 += sign * even
        for k in range(5):
            c.rates[0, k] += odd * _COS_ODD[n, k]
            c.rates[1, k] += sign * odd * _SIN_ODD[n, k]
            c.rates[2, k] += even * _COS_EVEN[n, k]
            c.rates[3, k] += sign * even * _COS_EVEN[n, k]
        even = 2.0 * q if n == 0 else even * step * step * q
        odd *= step * step * q * q
        step *= q
        sign = -sign
    for k in range(5):
        c.rates[0, k] *= math.ldexp(amplitudes[0], c.tempo) * theta4 / theta2
        c.rates[1, k] *= -math.ldexp(amplitudes[1], c.tempo) * theta3 / theta2
        c.rates[2, k] *= math.ldexp(amplitudes[2], c.tempo) * theta4 / theta3


@inlined
def _hyperbolic_series(nome, fraction, wobble, amplitudes, c):
    """The same after the modular transformation: nome Q', and Q'^2 for the angular velocity."""
    d = 0.25 * math.pi * fraction
    c.nome = nome
    sign = weight = step = 1.0
    cosines = sines = 0.0
    for n in range(4):
        # weight = Q'^(n^2), step = Q'^n
        c.alpha[0, n] = weight * math.cos((2 * n + 1) * d)
        c.alpha[1, n] = weight * math.sin((2 * n + 1) * d)
        cosines += step * c.alpha[0, n]
        sines += sign * step * c.alpha[1, n]
        weight *= step * step * nome
        step *= nome
        sign = -sign
    c.beta[0, 0] = wobble * cosines / sines
    q = nome * nome
    qq = q * q
    theta2 = 1.0 + qq + qq * qq * qq
    theta3 = 1.0 + 2.0 * (q + qq * qq)
    theta4 = 1.0 - 2.0 * (q - qq * qq)
    a1, a2, a3 = amplitudes
    cn = 2.0 * math.ldexp(a1, c.tempo) * theta2 / theta4
    sn = -math.ldexp(a2, c.tempo) * theta3 / theta4
    dn = 2.0 * math.ldexp(a3, c.tempo) * theta2 / theta3
    for n in range(3):
        sign = -1.0 if n == 1 else 1.0
        even = qq if n == 2 else 1.0  # q^(n(n-1))
        odd = 1.0 if n == 0 else (q if n == 1 else qq * qq)  # q^(n^2)
        c.rates[0, n] = cn * sign * even
        c.rates[1, n] = sn * sign * odd
        c.rates[2, n] = dn * even
        c.rates[3, n] = odd


@inlined
def attach(wxyz, c):
    """Third stage: the constant turns on both sides of the internal attitude, as one matrix.

    q(t) = q(0) b q_int(0)* q_int(t) b*;

    b carries internal to given body axes; the internal attitude at the epoch comes from the very
    series that give it later.
    """
    s, lo, half_turns = phase(0.0, 0.0, c.nutation0[0], c.nutation0[1], 0.0, 0.0, c.winds)
    if c.form == codes.TRIGONOMETRIC:
        sine, cosine = sincos(s, lo)
        pair = trigonometric_pair(
            (_four(c.alpha[0]), _four(c.alpha[1])),
            (_four(c.beta[0]), _four(c.beta[1])),
            sine,
            cosine,
        )
    else:
        dx = s + lo
        arguments = hyperbolic_arguments(dx, c.decay, c.nome)
        alpha = _four(c.alpha[0]), _four(c.alpha[1])
        pair = hyperbolic_pair(alpha, c.beta[0, 0], dx, half_turns, arguments)
        sine, cosine = sincos(-c.tilt * dx, 0.0)
        pair = turned(pair, sine, cosine)
    ar, ai, br, bi = pair
    size = 1.0 / math.sqrt(ar * ar + ai * ai + br * br + bi * bi)
    body = _quaternion_of(c.axes)
    left = _quaternion_product(
        _quaternion_product(_unit(wxyz), body), (ar * size, -br * size, -bi * size, -ai * size)
    )
    right = (body[0], -body[1], -body[2], -body[3])
    for k in range(4):
        unit = (
            1.0 if k == 0 else 0.0,
            1.0 if k == 1 else 0.0,
            1.0 if k == 2 else 0.0,
            1.0 if k == 3 else 0.0,
        )
        column = _quaternion_product(_quaternion_product(left, unit), right)
        for j in range(4):
            c.frame[j, k] = column[j]


@inlined
def reach(c):
    """Seconds to either side of the epoch within which the phases are resolved."""
    return LONGEST / max(abs(c.precession[0]), abs(c.nutation[0]))


@inlined
def _pair(row):
    return row[0], row[1]


@inlined
def _four(row):
    return row[0], row[1], row[2], row[3]


@inlined
def _quaternion_product(p, q):
    return (
        p[0] * q[0] - p[1] * q[1] - p[2] * q[2] - p[3] * q[3],
        p[0] * q[1] + p[1] * q[0] + p[2] * q[3] - p[3] * q[2],
        p[0] * q[2] - p[1] * q[3] + p[2] * q[0] + p[3] * q[1],
        p[0] * q[3] + p[1] * q[2] - p[2] * q[1] + p[3] * q[0],
    )


@inlined
def _quaternion_of(matrix):
    """The unit quaternion of a rotation matrix, from its largest component."""
    xx, yy, zz = matrix[0, 0], matrix[1, 1], matrix[2, 2]
    if xx + yy + zz > 0.0:
        w, x, y, z = (
            1.0 + xx + yy + zz,
            matrix[2, 1] - matrix[1, 2],
            matrix[0, 2] - matrix[2, 0],
            matrix[1, 0] - matrix[0, 1],
        )
    elif xx >= yy and xx >= zz:
        w, x, y, z = (
            matrix[2, 1] - matrix[1, 2],
            1.0 + xx - yy - zz,
            matrix[1, 0] + matrix[0, 1],
            matrix[0, 2] + matrix[2, 0],
        )
    elif yy >= zz:
        w, x, y, z = (
            matrix[0, 2] - matrix[2, 0],
            matrix[1, 0] + matrix[0, 1],
            1.0 + yy - xx - zz,
            matrix[2, 1] + matrix[1, 2],
        )
    else:
        w, x, y, z = (
            matrix[1, 0] - matrix[0, 1],
            matrix[0, 2] + matrix[2, 0],
            matrix[2, 1] + matrix[1, 2],
            1.0 + zz - xx - yy,
        )
    size = 1.0 / math.sqrt(w * w + x * x + y * y + z * z)
    return w * size, x * size, y * size, z * size
