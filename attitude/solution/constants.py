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
from attitude.solution.turns import phase, sincos
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
def prepare(moments, wxyz, omega, axes, c):
    """Fill the record c (solution.layout) of one body.

    Given
        moments  (3, 2) principal moments of inertia, pairs, any unit and order
        wxyz     (4,) body to inertial at the epoch, of any length
        omega    (3, 2) rad/s over the principal axes, pairs
        axes     (3, 3) columns: the principal axes in the given body axes
    """
    c.fault = _fault(moments, omega)
    if c.fault != codes.FINE:
        return
    exponent = math.frexp(max(moments[0, 0], moments[1, 0], moments[2, 0]))[1]
    a, b, d = (_scaled(moments[0], -exponent), _scaled(moments[1], -exponent),
               _scaled(moments[2], -exponent))  # fmt: skip
    fastest = max(abs(omega[0, 0]), abs(omega[1, 0]), abs(omega[2, 0]))
    tempo = math.frexp(fastest)[1]
    wa, wb, wd = _rate(omega[0], -tempo), _rate(omega[1], -tempo), _rate(omega[2], -tempo)
    c.tempo = tempo
    size = 1.0 / math.sqrt(wxyz[0] ** 2 + wxyz[1] ** 2 + wxyz[2] ** 2 + wxyz[3] ** 2)
    start = (wxyz[0] * size, wxyz[1] * size, wxyz[2] * size, wxyz[3] * size)

    ab, bd, da = same(a, b), same(b, d), same(d, a)
    no_a, no_b, no_d = wa[0] == 0.0, wb[0] == 0.0, wd[0] == 0.0
    if (ab or no_a or no_b) and (bd or no_b or no_d) and (da or no_d or no_a):
        if fastest == 0.0:
            c.mode = codes.AT_REST
        elif ab and bd:
            c.mode = codes.SPHERICAL
        else:
            c.mode = codes.PRINCIPAL_AXIS
        _uniform(start, wa, wb, wd, axes, c)
        return
    _tumbling((a, b, d), (wa, wb, wd), start, axes, c)


@inlined
def _fault(moments, omega):
    least, most = moments[0, 0], moments[0, 0]
    for k in range(3):
        if not (moments[k, 0] >= 0.0 and moments[k, 0] < math.inf):
            return codes.NOT_A_BODY
        if not abs(omega[k, 0]) < math.inf:
            return codes.NOT_A_BODY
        least, most = min(least, moments[k, 0]), max(most, moments[k, 0])
    if most == 0.0:
        return codes.NOT_A_BODY
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
def _uniform(start, wa, wb, wd, axes, c):
    """Constant angular velocity: q(t) = q(0) (cos + sin of half the angle times the unit axis)."""
    c.form = codes.UNIFORM
    speed = sqrt(add(add(square(wa), square(wb)), square(wd)))
    _store_rate(c.precession, div(speed, scale(TWO_PI, 2.0)), c.tempo)
    over = 0.0 if speed[0] == 0.0 else 1.0 / speed[0]
    x = axes[0, 0] * wa[0] + axes[0, 1] * wb[0] + axes[0, 2] * wd[0]
    y = axes[1, 0] * wa[0] + axes[1, 1] * wb[0] + axes[1, 2] * wd[0]
    z = axes[2, 0] * wa[0] + axes[2, 1] * wb[0] + axes[2, 2] * wd[0]
    turn = _quaternion_product(start, (0.0, x * over, y * over, z * over))
    for k in range(4):
        c.frame[0, k] = start[k]
        c.frame[1, k] = turn[k]
    c.rates[0, 0] = math.ldexp(x, c.tempo)
    c.rates[0, 1] = math.ldexp(y, c.tempo)
    c.rates[0, 2] = math.ldexp(z, c.tempo)


@inlined
def _tumbling(moments, rates, start, axes, c):
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
    _motion(
        (moments[first], moments[second], moments[third]),
        (scale(rates[first], s1), scale(rates[second], s2), scale(rates[third], s3)),
        absolute(d2),
        c,
    )
    _attach(start, c)


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
def _motion(moments, rates, d2, c):
    """Rates, phases and series coefficients of the internal motion (internal axes, all pairs)."""
    i1, i2, i3 = moments
    w1, w2, w3 = rates
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
    _store_rate(c.precession, scale(div(momentum, mul(i2, TWO_PI)), 0.5), c.tempo)
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
    growing, sign = 1.0, 1.0
    at_zero = theta4 = 0.0
    # 1 - X^(2n) and 1 - X^(2n+1), free of the cancellation at small delta (a needle's)
    even_loss, odd_loss = 0.0, one_minus_x
    for n in range(4):
        # theta4: Q^(n^2) exp(+-2n delta) = P^n Q^(n(n-1)) and the same times X^(2n)
        high = growing * nome ** (n * (n - 1))
        low = high * x ** (2 * n)
        even, odd = sign * (high + low), -sign * high * even_loss
        if n == 0:
            even = 1.0
        theta4 += even
        for k in range(4):
            c.alpha[0, k] += even * _COS_EVEN[n, k]
            c.alpha[1, k] += odd * _SIN_EVEN[n, k]
        # theta1 exp(-delta): Q^(n(n+1)) exp(2n delta) = P^n Q^(n^2), and the same times X^(2n+1)
        high = growing * nome ** (n * n)
        low = high * x ** (2 * n + 1)
        lower = high * odd_loss
        at_zero += sign * lower
        for k in range(4):
            c.beta[0, k] -= sign * (high + low) * _SIN_ODD[n, k]
            c.beta[1, k] -= sign * lower * _COS_ODD[n, k]
        growing *= p
        sign = -sign
        even_loss += x ** (2 * n) * (1.0 + x) * one_minus_x
        odd_loss += x ** (2 * n + 1) * (1.0 + x) * one_minus_x
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
    sign = 1.0
    for n in range(5):
        even, odd = (1.0 if n == 0 else 2.0 * q ** (n * n)), q ** (n * (n + 1))
        theta2 += odd
        theta3 += even
        theta4 += sign * even
        for k in range(5):
            c.rates[0, k] += odd * _COS_ODD[n, k]
            c.rates[1, k] += sign * odd * _SIN_ODD[n, k]
            c.rates[2, k] += even * _COS_EVEN[n, k]
            c.rates[3, k] += sign * even * _COS_EVEN[n, k]
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
    sign = 1.0
    cosines = sines = 0.0
    for n in range(4):
        weight = nome ** (n * n)
        c.alpha[0, n] = weight * math.cos((2 * n + 1) * d)
        c.alpha[1, n] = weight * math.sin((2 * n + 1) * d)
        cosines += nome**n * c.alpha[0, n]
        sines += sign * nome**n * c.alpha[1, n]
        sign = -sign
    c.beta[0, 0] = wobble * cosines / sines
    q = nome * nome
    theta2 = 1.0 + q * q + q**6
    theta3 = 1.0 + 2.0 * (q + q**4)
    theta4 = 1.0 + 2.0 * (-q + q**4)
    a1, a2, a3 = amplitudes
    cn = 2.0 * math.ldexp(a1, c.tempo) * theta2 / theta4
    sn = -math.ldexp(a2, c.tempo) * theta3 / theta4
    dn = 2.0 * math.ldexp(a3, c.tempo) * theta2 / theta3
    for n in range(3):
        sign = -1.0 if n == 1 else 1.0
        c.rates[0, n] = cn * sign * q ** (n * n - n)
        c.rates[1, n] = sn * sign * q ** (n * n)
        c.rates[2, n] = dn * q ** (n * n - n)
        c.rates[3, n] = q ** (n * n)


@inlined
def _attach(start, c):
    """The constant turns on both sides, q(t) = q(0) b q_int(0)* q_int(t) b*, as one matrix.

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
        _quaternion_product(start, body), (ar * size, -br * size, -bi * size, -ai * size)
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
