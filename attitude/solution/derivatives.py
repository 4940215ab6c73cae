"""Derivatives of the secular elements of a motion by angular velocity and moments of inertia.

The free rotation is a polynomial in a few elements (docs/derivation.md): where the nome Q serves,

    lambda, f, x0, ln rho, X      precession rate, nutation rate and phase, amplitude, ellipticity

and after the modular transformation, near the separatrix,

    lambda', wp, eps, K', d, Q'   which stay regular where the period is infinite.

Their derivatives need no elliptic integral of the third kind.  The angle 2 lambda t is conjugate to
L, the nutation 2 pi f t to an action J; the energy is homogeneous in both, so 2 E = 2 lambda L +
2 pi f J.  With dH/d(1/I_i) at constant actions the mean of L_i^2 / 2,

    L d(2 lambda) = sum I_i w_i dw_i + sum (w_i^2 - <w_i^2>) dI_i / 2 - (2 E - 2 lambda L) d ln f

with means of sn^2, cn^2 and dn^2 from integrals of the second kind.  The same identity on the other
period of the integrals, with K' for K and E(mc)/(m K') for the mean of sn^2, gives d(2 lambda').

Every difference of moments is one of the inputs' own, the invariants are sums of terms of one sign.
Symbols as in `solution.constants`; d12 = |I1 - I2| and so on.
"""

import math

from attitude.compilation.decorators import subroutine
from attitude.solution import codes
from attitude.solution.second_kind import by_parameter, integrals
from attitude.solution.series import four
from attitude.solution.twofloat import TWO_PI, ZERO, add, mul, pair, scale, sqrt, square, sub


@subroutine
def derive(inertia, c, out):
    """Fill the Jacobian (7, 6) of the elements of a motion that tumbles.

    Each input in turn: one of the internal angular velocity or of the internal moments is 1.

    Given
        inertia  the moments of the record are those given over 2^inertia
    """
    first, second, _minus1, _minus3 = four(c.jacobi)
    third = 3 - first - second
    axes = c.axes
    state = state_of(c)
    action = _action(c)
    by_speed, by_moment = math.ldexp(1.0, -c.tempo), math.ldexp(1.0, -inertia)
    for row in range(7):
        for k in range(6):
            out[row, k] = 0.0
    for k in range(6):
        one = _unit(k)
        found = (
            _hyperbolic(state, one, action, c)
            if c.form == codes.HYPERBOLIC
            else _trigonometric(state, one, action, c)
        )
        size = by_speed if k < 3 else by_moment
        for row in range(7):
            # rates are the first two rows, in the scaled unit of time
            value = math.ldexp(found[row], c.tempo) if row < 2 else found[row]
            if k < 3:
                for j in range(3):
                    out[row, j] += axes[j, k] * value * size
            else:
                place = 3 + (first if k == 3 else (second if k == 4 else third))
                out[row, place] = value * size


@subroutine
def _unit(k):
    return (
        1.0 if k == 0 else 0.0,
        1.0 if k == 1 else 0.0,
        1.0 if k == 2 else 0.0,
        1.0 if k == 3 else 0.0,
        1.0 if k == 4 else 0.0,
        1.0 if k == 5 else 0.0,
    )


@subroutine
def state_of(c):
    """The scaled state over the internal axes, its invariants and integrals, in doubles."""
    first, second, minus1, minus3 = four(c.jacobi)
    third = 3 - first - second
    i1, i2, i3 = c.moments[first, 0], c.moments[second, 0], c.moments[third, 0]
    w1, w2, w3 = abs(c.omega[first, 0]), c.omega[second, 0], abs(c.omega[third, 0])
    if ((second - first) % 3 + minus1 + minus3) % 2 == 0:
        w2 = -w2
    long_axis = third == c.order[0]
    long = 1 if long_axis else 0
    d12, d23 = c.gaps[long, 0], c.gaps[1 - long, 0]
    d13 = d12 + d23
    a1 = i2 * d12 * w2 * w2 + i3 * d13 * w3 * w3
    a3 = i1 * d13 * w1 * w1 + i2 * d23 * w2 * w2
    side = 1.0 if long_axis else -1.0
    square = (i1 * w1) ** 2 + (i2 * w2) ** 2 + (i3 * w3) ** 2
    energy2 = i1 * w1 * w1 + i2 * w2 * w2 + i3 * w3 * w3
    speed = math.sqrt(a1 * d23 / (i1 * i2 * i3))
    return (
        (i1, i2, i3),
        (w1, w2, w3),
        (d12, d23, d13),
        (a1, c.d2[0], a3),
        side,
        (math.sqrt(square), square, energy2),
        speed,
        (c.m, c.mc[0]),
    )


@subroutine
def _changes(state, one):
    """What the elements share: changes of m, ln wp, ln(1 - n), amplitudes and phase."""
    (i1, i2, i3), (w1, w2, w3), (d12, d23, d13), (a1, _a2, a3), side, _, _speed, (m, _mc) = state
    x1, x2, x3, y1, y2, y3 = one
    g12, g23, g13 = side * (y1 - y2), side * (y2 - y3), side * (y1 - y3)
    b1 = 2.0 * (i2 * d12 * w2 * x2 + i3 * d13 * w3 * x3)
    b1 += (y2 * d12 + i2 * g12) * w2 * w2 + (y3 * d13 + i3 * g13) * w3 * w3
    b3 = 2.0 * (i1 * d13 * w1 * x1 + i2 * d23 * w2 * x2)
    b3 += (y1 * d13 + i1 * g13) * w1 * w1 + (y2 * d23 + i2 * g23) * w2 * w2
    ratio = b1 / a1 + g23 / d23
    change = (b3 * d12 + a3 * g12) / (a1 * d23) - m * ratio
    rate = 0.5 * (ratio - y1 / i1 - y2 / i2 - y3 / i3)
    p = y2 / i2 - y1 / i1 + g13 / d13 - g23 / d23
    size = 1.0 / math.sqrt(a3)
    cosine, sine = w1 * math.sqrt(i1 * d13) * size, -w2 * math.sqrt(i2 * d23) * size
    turn = -cosine * x2 * math.sqrt(i2 * d23) * size - sine * x1 * math.sqrt(i1 * d13) * size
    turn += 0.5 * cosine * sine * (y2 / i2 + g23 / d23 - y1 / i1 - g13 / d13)
    return change, rate, p, (b1, b3), (cosine, sine, turn), (g12, g23, g13)


@subroutine
def _precession(state, one, mean, action, rate, sine):
    """d of twice the precession rate (rad per scaled second), of one of the two periods.

    Given
        mean    the mean of sn^2 over the period
        action  J 2 pi f = 2 E - 2 lambda L
        rate    d ln f
        sine    sn at the epoch
    """
    (i1, i2, i3), (w1, w2, w3), (_d12, d23, d13), (a1, _a2, a3), _, size, _, (m, _) = state
    x1, x2, x3, y1, y2, y3 = one
    work = i1 * w1 * x1 + i2 * w2 * x2 + i3 * w3 * x3
    # w^2 at the epoch less its mean, of each axis
    by_moments = a3 / (i1 * d13) * y1 - a3 / (i2 * d23) * y2 + m * a1 / (i3 * d13) * y3
    work += 0.5 * (mean - sine * sine) * by_moments
    return (work - action * rate) / size[0]


@subroutine
def _action(c):
    """2 E - 2 lambda L, scaled; in pairs, as the two agree for a body that is nearly a sphere."""
    energy, total = ZERO, ZERO
    for k in range(3):
        moment, rate = pair(c.moments[k]), pair(c.omega[k])
        here = mul(moment, rate)
        energy = add(energy, mul(here, rate))
        total = add(total, square(here))
    turns = math.ldexp(c.precession[0], -c.tempo), math.ldexp(c.precession[1], -c.tempo)
    return sub(energy, mul(mul(scale(TWO_PI, 2.0), turns), sqrt(total)))[0]


@subroutine
def _trigonometric(state, one, action, c):
    """d of 2 lambda and 2 pi f (rad/s), 2 pi x0, ln rho and X."""
    _moments, _w, _differences, _, side, _size, speed, (m, mc) = state
    change, rate, p, amplitudes, (cosine, sine, turn), gaps = _changes(state, one)
    k, d = integrals(m, mc)
    b = k - d
    rate_f = rate - 0.5 * b / (mc * k) * change
    f = side * speed / (4.0 * k)
    precession = _precession(state, one, d / k, action, rate_f, sine)
    # x0 = F/(4K)
    delta = math.sqrt(cosine * cosine + mc * sine * sine)
    by_m = by_parameter(cosine, sine, delta * delta)
    turns = c.nutation0[0]
    phase = (turn / delta + (by_m - 2.0 * turns * b / mc) * change) / (4.0 * k)
    nutation, apart = _half_nutations(state, one, (change, p), amplitudes, gaps[2])
    g00, g01, g10, g11 = _half_angles(c)
    over = 1.0 / (g00 * g11 - g01 * g10)
    return (
        precession,
        2.0 * math.pi * f * rate_f,
        2.0 * math.pi * phase,
        (nutation * g11 - g01 * apart) * over,
        (g00 * apart - g10 * nutation) * over,
        0.0,
        0.0,
    )


@subroutine
def _half_nutations(state, one, shared, amplitudes, g13):
    """d ln tau0 and d ln (tau1 / tau0), the tangents of half the nutation at v = 0 and v = pi/2.

    By the sines of the nutation where it is small, and by its cosines, l and l sqrt(mc), where the
    third axis is nearly across the momentum: a sine has no first-order change there.
    """
    (i1, i2, i3), w, (_d12, _d23, d13), (a1, _a2, a3), _, (_, square, _), _, (m, mc) = state
    (x1, x2, x3, y1, y2, y3), (change, p), (b1, b3) = one, shared, amplitudes
    lift = i1 * w[0] * (i1 * x1 + y1 * w[0]) + i2 * w[1] * (i2 * x2 + y2 * w[1])
    lift = 2.0 * (lift + i3 * w[2] * (i3 * x3 + y3 * w[2]))
    root, across = math.sqrt(mc), i1 * a3 / (d13 * square)
    l = math.sqrt(i3 * a1 / (d13 * square))
    if across < 0.5:
        first = 0.5 * (y1 / i1 + b3 / a3 - g13 / d13 - lift / square) / l
        return first, (first * l * m / (1.0 + root) + 0.5 * p) / (l * root)
    cosine = 0.5 * l * (y3 / i3 + b1 / a1 - g13 / d13 - lift / square)
    other = 1.0 - mc * l * l
    apart = m * (1.0 + root * l * l) / ((1.0 + root) * across) * cosine
    return -cosine / across, (apart + 0.5 * l * change / root) / other


@subroutine
def powers(x, s):
    """What the terms n = 1, 2, 3 of the pair are made of, each at most s.

    s^(n^2) X^(2n^2-n-1), s^(n^2+n) X^(2n^2+n-1) and X^(2n); s X^2 is the nome Q.
    """
    x2, s2 = x * x, s * s
    x4, s4 = x2 * x2, s2 * s2
    x5, x8, s8 = x4 * x, x4 * x4, s4 * s4
    return (
        (s, s4 * x5, s8 * s * x8 * x5 * x),
        (s2 * x2, s4 * s2 * x8 * x, s8 * s4 * x8 * x8 * x4),
        (x2, x4, x4 * x2),
    )


@subroutine
def ellipticity(c):
    """X, 1 - X, rho and s = rho^4 of a record of the trigonometric form."""
    if c.stretch < math.inf:
        double_delta = 0.5 * math.pi * c.stretch * c.fraction
        x, one_minus_x = math.exp(-double_delta), -math.expm1(-double_delta)
        p = math.exp(double_delta - math.pi * c.stretch)  # s X
    else:
        x, one_minus_x, p = (c.root - 1.0) / (c.root + 1.0), 2.0 / (c.root + 1.0), 0.0
    # rho by tan of half the nutation at v = 0, which keeps its digits where X is tiny
    # sums of (-1)^n s^(n^2) X^(2n^2-n) (1 + X^(2n)) and (-1)^n s^(n^2+n) X^(2n^2+n) (1 - X^(2n+1))
    x2, x3, p2, p3 = x * x, x * x * x, p * p, p * p * p
    three = 1.0 + x + x2
    five = three + x3 * (1.0 + x)
    seven = five + x3 * x2 * (1.0 + x)
    low = 1.0 - p * (1.0 + x2 - p3 * x2 * (1.0 + x2 * x2 - p3 * p2 * x2 * x2 * (1.0 + x3 * x3)))
    top = three - p2 * p2 * x3 * (five - p3 * p3 * x3 * x2 * seven)
    top = one_minus_x * (1.0 - p2 * x * top)
    rho = c.wobble * low / top
    return x, one_minus_x, rho, (rho * rho) ** 2


@subroutine
def _half_angles(c):
    """Derivatives of ln tau0 and of ln (tau1/tau0), each by ln rho and by X.

    tau0 and tau1 are the tangents of half the nutation at v = 0 and v = pi/2:

        tau = rho sum (+-1)^n s^(n^2+n) (X^(2n^2+n) +- X^(2n^2+3n+1))
                  / (1 + sum (+-1)^n s^(n^2) (X^(2n^2-n) + X^(2n^2+n))),     s = rho^4.
    """
    x, one_minus_x, _, s = ellipticity(c)
    r, y, even = powers(x, s)
    first = _logarithms(x, one_minus_x, r, y, even, -1.0)
    second = _logarithms(x, 1.0 + x, r, y, even, 1.0)
    return 1.0 + first[0], first[1], second[0] - first[0], second[1] - first[1]


@subroutine
def _logarithms(x, top, r, y, even, sign):
    """Derivatives of ln (tau / rho) by ln rho and by X; top is its first term, 1 +- X."""
    low, low_r, low_x = 1.0, 0.0, 0.0
    top_r, top_x = 0.0, sign
    factor = sign
    for n in range(1, 4):
        a, b, e = r[n - 1], y[n - 1], even[n - 1]
        square = 2.0 * n * n
        low += factor * a * x * (1.0 + e)
        low_r += factor * 4.0 * n * n * a * x * (1.0 + e)
        low_x += factor * a * ((square - n) + (square + n) * e)
        top += factor * b * x * (1.0 + sign * e * x)
        top_r += factor * 4.0 * n * (n + 1.0) * b * x * (1.0 + sign * e * x)
        top_x += factor * b * ((square + n) + sign * (square + 3.0 * n + 1.0) * e * x)
        factor *= sign
    return top_r / top - low_r / low, top_x / top - low_x / low


@subroutine
def _hyperbolic(state, one, action, c):
    """d of 2 lambda' and wp pi/(4K') (rad/s), eps pi/(4K'), ln K', d, Q', and K pi/(2K')."""
    (i1, _i2, i3), _w, (d12, d23, d13), (a1, _a2, _a3), side, size, speed, (m, mc) = state
    momentum, square, _ = size
    change, rate, _p, _, (cosine, sine, turn), (g12, g23, _g13) = _changes(state, one)
    _x1, _x2, _x3, y1, _y2, y3 = one
    k, d = integrals(mc, m)
    b = k - d
    rate_k = -0.5 * b / (m * k) * change
    rate_f = rate - rate_k
    angle = 0.25 * math.pi * c.fraction
    if c.winds != 0.0:
        # lambda' = lambda - 4 d f; the record holds the rate of 2 x = 2 f t + ...
        action += 4.0 * angle * momentum * math.ldexp(c.nutation[0], -c.tempo)
    precession = _precession(state, one, (m * d + b) / (m * k), action, rate_f, sine)
    size_of_y = 0.25 * math.pi / k
    delta = cosine * cosine + mc * sine * sine
    phase = turn / math.sqrt(delta) + by_parameter(cosine, sine, delta) * change
    # d = pi eta / (4K'), eta = F of the amplitude with sine^2 1/(1 - n), of mc
    minus_n = i3 / i1 * (d12 / d23)
    top = 1.0 / (1.0 + minus_n)
    rest = square * d12 * d13 / (i1 * a1 * d23)  # m - n
    turned = -0.5 * math.sqrt(minus_n * top / rest)
    turned *= y3 / i3 - y1 / i1 + g12 / d12 - g23 / d23
    turned -= by_parameter(math.sqrt(minus_n * top), math.sqrt(top), rest * top) * change
    by_k = -math.inf if mc == 0.0 else 0.0
    # on the exact separatrix Q'^2 = mc/16 is the element: Q' has no derivative there
    nome = 0.125 if mc == 0.0 else c.nome / mc
    if mc > 0.0:
        quarter, other = integrals(m, mc)
        by_k = (quarter - other) / (2.0 * mc)
    return (
        precession,
        size_of_y * side * speed * rate,
        size_of_y * phase,
        rate_k,
        size_of_y * turned - angle * rate_k,
        -nome * math.pi * math.pi / (8.0 * m * k * k) * change,
        2.0 * size_of_y * by_k * change,
    )
