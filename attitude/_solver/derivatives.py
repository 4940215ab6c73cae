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
The tilts follow from nu = K' - eta = F(arcsin l | mc), which neither a symmetric body nor a needle
makes infinite or a small difference:

    rho = exp(-(pi/2) nu/K),      X = q / rho^2,      d = (pi/4) (1 - nu/K')

Every difference of moments is one of the inputs' own, the invariants are sums of terms of one sign.
About the middle axis all columns of the moments vanish with the other two rates, p, and their terms
do so one by one: the change of mc is that of D2 itself, of order p^2, not the rounding of that of
m; w^2 less its mean is a sum; and 2 E - 2 lambda' L, of order D2, an integral over D2.
Symbols as in `constants`; d12 = |I1 - I2| and so on.
"""

from __future__ import annotations

import math

from attitude._compilation.decorators import subroutine
from attitude._solver import codes
from attitude._solver.constants import ellipticity_of
from attitude._solver.elliptic import by_parameter, integrals
from attitude._solver.series import exp2_of_minus, four
from attitude._solver.twofloat import ONE, TWO_PI, ZERO, add, mul, pair, scale, sqrt, square, sub
from attitude._solver.uniform_tangents import unit_vector

# 2 / ln 2, a pair.
TWO_OVER_LOG_2 = (2.8853900817779268, 4.0710547481862066e-17)
# Nodes and weights of Gauss's rule of six points on [0, 1].
_NODES = (
    0.03376524289842399,
    0.16939530676686773,
    0.38069040695840156,
    0.6193095930415985,
    0.8306046932331322,
    0.966234757101576,
)
_WEIGHTS = (
    0.08566224618958518,
    0.1803807865240693,
    0.23395696728634552,
    0.23395696728634552,
    0.1803807865240693,
    0.08566224618958518,
)
# q = e + 2 e^5 + 15 e^9 + ..., e = (1 - sqrt k') / (2 (1 + sqrt k')); DLMF 22.2.5, OEIS A002103.
_NOME = (1.0, 2.0, 15.0, 150.0, 1707.0, 20910.0, 268616.0, 3567400.0, 48555069.0, 673458874.0)


@subroutine
def derive(inertia, c, out):
    """Fill the Jacobian (11, 6) of the elements of a motion that tumbles.

    Rows: those of `_trigonometric` or `_hyperbolic`, and the logarithms of the three amplitudes.
    Each input in turn: one of the internal angular velocity or of the internal moments is 1.

    Given
        inertia  the moments of the record are those given over 2^inertia
    """
    first, second, _minus1, _minus3 = four(c.jacobi)
    third = 3 - first - second
    axes = c.axes
    state = state_of(c)
    hyperbolic = c.form == codes.HYPERBOLIC
    action = _near_action(state) if hyperbolic else _action(c)
    by_speed, by_moment = math.ldexp(1.0, -c.tempo), math.ldexp(1.0, -inertia)
    for row in range(11):
        for k in range(6):
            out[row, k] = 0.0
    for k in range(6):
        one = unit_vector(k) + unit_vector(k - 3)
        changes = (
            _hyperbolic(state, one, action, c)
            if hyperbolic
            else _trigonometric(state, one, action, c)
        )
        sizes = _amplitudes(state, one)
        size = by_speed if k < 3 else by_moment
        for row in range(11):
            value = changes[row] if row < 8 else sizes[row - 8]
            if row < 2:  # rates, in the scaled unit of time
                value = math.ldexp(value, c.tempo)
            if k < 3:
                for j in range(3):
                    out[row, j] += axes[j, k] * value * size
            else:
                place = 3 + (first if k == 3 else (second if k == 4 else third))
                out[row, place] = value * size


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
    """What the elements share: changes of m, mc, ln wp, nu, and of the phase."""
    (i1, i2, i3), (w1, w2, w3), (d12, d23, d13), (a1, a2, a3), side, _, _speed, (m, mc) = state
    x1, x2, x3, y1, y2, y3 = one
    g12, g23, g13 = side * (y1 - y2), side * (y2 - y3), side * (y1 - y3)
    b1 = 2.0 * (i2 * d12 * w2 * x2 + i3 * d13 * w3 * x3)
    b1 += (y2 * d12 + i2 * g12) * w2 * w2 + (y3 * d13 + i3 * g13) * w3 * w3
    b2 = 2.0 * (i3 * d23 * w3 * x3 - i1 * d12 * w1 * x1)
    b2 += (y3 * d23 + i3 * g23) * w3 * w3 - (y1 * d12 + i1 * g12) * w1 * w1
    b3 = 2.0 * (i1 * d13 * w1 * x1 + i2 * d23 * w2 * x2)
    b3 += (y1 * d13 + i1 * g13) * w1 * w1 + (y2 * d23 + i2 * g23) * w2 * w2
    ratio = b1 / a1 + g23 / d23
    # dm = -dmc, each by the formula whose terms vanish with it
    if mc < m:
        change = mc * ratio - (b2 * d13 + a2 * g13) / (a1 * d23)
    else:
        change = (b3 * d12 + a3 * g12) / (a1 * d23) - m * ratio
    # wp^2 = (p w3^2 + r w2^2) d23 / I2
    p, r = d13 / i1, i2 * d12 / (i1 * i3)
    by_p, by_r = side * (i3 * y1 / i1 - y3) / i1, y2 / i2 - y1 / i1 - y3 / i3
    by_r = r * by_r + i2 * g12 / (i1 * i3)
    rate = p * w3 * x3 + r * w2 * x2 + 0.5 * (by_p * w3 * w3 + by_r * w2 * w2)
    rate = rate / (p * w3 * w3 + r * w2 * w2) + 0.5 * side * (i3 * y2 / i2 - y3) / d23
    size = 1.0 / math.sqrt(a3)
    cosine, sine = w1 * math.sqrt(i1 * d13) * size, -w2 * math.sqrt(i2 * d23) * size
    turn = -cosine * x2 * math.sqrt(i2 * d23) * size - sine * x1 * math.sqrt(i1 * d13) * size
    turn += 0.5 * cosine * sine * (y2 / i2 + g23 / d23 - y1 / i1 - g13 / d13)
    # nu = F(psi | mc), sin psi = l
    across, along = i1 * a3, i3 * a1
    whole = 1.0 / (across + along)  # d13 L^2
    across, along = across * whole, along * whole
    tilt = 0.5 * math.sqrt(across * along) * (y3 / i3 + b1 / a1 - y1 / i1 - b3 / a3)
    delta = across + m * along
    nu = tilt / math.sqrt(delta)
    nu -= by_parameter(math.sqrt(across), math.sqrt(along), delta) * change
    return change, rate, nu, (cosine, sine, turn)


@subroutine
def _amplitudes(state, one):
    """d ln of the amplitudes of the angular velocity, each a sum that vanishes with the motion."""
    (i1, i2, i3), (w1, w2, w3), (d12, d23, d13), _, side, _, _speed, _m = state
    x1, x2, x3, y1, y2, y3 = one
    g12, g23, g13 = side * (y1 - y2), side * (y2 - y3), side * (y1 - y3)
    # a1^2 = w1^2 + r w2^2, a2^2 = a1^2 / r, a3^2 = w3^2 + s w2^2
    r, s = i2 * d23 / (i1 * d13), i2 * d12 / (i3 * d13)
    by_r = y2 / i2 + g23 / d23 - y1 / i1 - g13 / d13
    by_s = i2 / (i3 * d13) * (g12 + d12 * (y2 / i2 - y3 / i3 - g13 / d13))
    first, third = w1 * w1 + r * w2 * w2, w3 * w3 + s * w2 * w2
    shared = w1 * x1 + r * w2 * x2
    return (
        (shared + 0.5 * r * w2 * w2 * by_r) / first,
        (shared - 0.5 * w1 * w1 * by_r) / first,
        (w3 * x3 + s * w2 * x2 + 0.5 * by_s * w2 * w2) / third,
    )


@subroutine
def _precession(state, one, less, action, rate):
    """d of twice the precession rate (rad per scaled second), of one of the two periods.

    less is the mean of sn^2 over the period less that at the epoch, action J 2 pi f = 2 E - 2
    lambda L, rate d ln f.
    """
    (i1, i2, i3), (w1, w2, w3), (_d12, d23, d13), (a1, _a2, a3), _, size, _, (m, _) = state
    x1, x2, x3, y1, y2, y3 = one
    work = i1 * w1 * x1 + i2 * w2 * x2 + i3 * w3 * x3
    # w^2 at the epoch less its mean, of each axis
    by_moments = a3 / (i1 * d13) * y1 - a3 / (i2 * d23) * y2 + m * a1 / (i3 * d13) * y3
    work += 0.5 * less * by_moments
    return (work - action * rate) / size[0]


@subroutine
def _action(c):
    """2 E - 2 lambda L, scaled; in pairs, as the two agree for a body that is nearly a sphere."""
    energy, total = ZERO, ZERO
    for k in range(3):
        moment, rate = pair(c.moments[k]), pair(c.omega[k])
        momentum = mul(moment, rate)
        energy = add(energy, mul(momentum, rate))
        total = add(total, square(momentum))
    turns = math.ldexp(c.precession[0], -c.tempo), math.ldexp(c.precession[1], -c.tempo)
    return sub(energy, mul(mul(scale(TWO_PI, 2.0), turns), sqrt(total)))[0]


@subroutine
def _near_action(state):
    """2 E - 2 lambda' L, scaled: of the order of D2, by which it is integrated.

    At constant L the action grows with E by 1/rate and vanishes on the separatrix, E = L^2/(2 I2),
    where the two agree:

        2 E - 2 lambda' L = -+ 1/(2 I2) int_0^D2 (rate at D2 / rate at D) dD,    rate ~ wp/K'.

    The integrand has no singularity within 15 times the interval: six points suffice.
    """
    (i1, i2, i3), _w, (d12, d23, _d13), (a1, a2, a3), side, _, _speed, (m, mc) = state
    rate = math.sqrt(a1) / integrals(mc, m)[0]
    total = 0.0
    for k in range(len(_NODES)):
        node = _NODES[k]
        # D1 and D3 at the part `node` of D2
        left = (1.0 - node) * a2 / i2
        first, third = a1 - i1 * left, a3 + i3 * left
        m_there = third * d12 / (first * d23)
        mc_there = node * mc * (a1 / first)
        total += _WEIGHTS[k] * integrals(mc_there, m_there)[0] / math.sqrt(first)
    return 0.5 * side * a2 / i2 * rate * total


@subroutine
def _trigonometric(state, one, action, c):
    """d of 2 lambda and 2 pi f (rad/s), 2 pi x0, ln rho, X, 0, 0, and q."""
    _moments, _w, _differences, _, side, _size, speed, (m, mc) = state
    change, rate, nu, (cosine, sine, turn) = _changes(state, one)
    k, d = integrals(m, mc)
    b = k - d
    by_k = 0.5 * b / (mc * k) * change
    f = side * speed / (4.0 * k)
    precession = _precession(state, one, d / k - sine * sine, action, rate - by_k)
    # x0 = F/(4K)
    delta = math.sqrt(cosine * cosine + mc * sine * sine)
    by_m = by_parameter(cosine, sine, delta * delta)
    turns = c.nutation0[0]
    phase = (turn / delta + (by_m - 2.0 * turns * b / mc) * change) / (4.0 * k)
    x, _, rho, _ = ellipticity(c)
    amplitude = -0.5 * math.pi / k * nu - math.log(rho) * by_k
    nome = _nome_over(m, mc) * math.pi * math.pi / (4.0 * mc * k * k) * change
    return (
        precession,
        2.0 * math.pi * f * (rate - by_k),
        2.0 * math.pi * phase,
        amplitude,
        nome / (rho * rho) - 2.0 * x * amplitude,
        0.0,
        0.0,
        nome,
    )


@subroutine
def _nome_over(m, mc):
    """q / m of a parameter 0 <= m < 0.98."""
    root = math.sqrt(mc)
    half = 0.5 / ((1.0 + root) * (1.0 + math.sqrt(root)) ** 2)
    fourth = (m * half) ** 4
    total = 0.0
    for k in range(len(_NOME)):
        total = total * fourth + _NOME[len(_NOME) - 1 - k]
    return half * total


@subroutine
def ellipticity(c):
    """X, 1 - X, rho and s = rho^4 of a record of the trigonometric form."""
    x, one_minus_x, p = ellipticity_of(c)  # p = s X
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
def passage(c):
    """A pair a with exp(-2|y|) = 2^(-a |dx|), Q' = 2^(-a/2): all digits about the middle axis."""
    if c.winds == 0.0:
        return TWO_OVER_LOG_2, 0.0
    # K' = pi/2 over the mean of 1 and sqrt(m)
    a, b = ONE, sqrt(sub(ONE, pair(c.mc)))
    for _ in range(4):
        a, b = scale(add(a, b), 0.5), sqrt(mul(a, b))
    decay = mul(mul(pair(c.quarter), a), TWO_OVER_LOG_2)
    low = math.log(2.0) * 0.5 * decay[1]
    return decay, exp2_of_minus(0.5 * decay[0]) * (1.0 - low)


@subroutine
def _hyperbolic(state, one, action, c):
    """d of 2 lambda' and wp pi/(4K') (rad/s), eps pi/(4K'), ln K', d, Q', K pi/(2K'), and Q'^2."""
    _moments, _w, _differences, _, side, _size, speed, (m, mc) = state
    change, rate, nu, (cosine, sine, turn) = _changes(state, one)
    k, d = integrals(mc, m)
    b = k - d
    rate_k = -0.5 * b / (m * k) * change
    less = cosine * cosine + mc * b / (m * k)
    precession = _precession(state, one, less, action, rate - rate_k)
    size_of_y = 0.25 * math.pi / k
    delta = cosine * cosine + mc * sine * sine
    phase = turn / math.sqrt(delta) + by_parameter(cosine, sine, delta) * change
    by_nome = -math.pi * math.pi / (8.0 * m * k * k) * change
    if mc == 0.0:
        # on the exact separatrix Q'^2 = mc/16 is the element: Q' has no derivative there
        nome = squared = 0.125 * by_nome
        by_k = -math.inf
    else:
        value = passage(c)[1]
        nome = value / mc * by_nome
        squared = 2.0 * value * nome
        # dK/dm = B/(2 mc), B by Legendre's relation
        quarter = c.quarter[0]
        by_k = (0.5 * math.pi - mc * quarter * b) / (2.0 * m * mc * k)
    return (
        precession,
        size_of_y * side * speed * rate,
        size_of_y * phase,
        rate_k,
        -size_of_y * nu + 0.25 * math.pi * (1.0 - c.fraction) * rate_k,
        nome,
        2.0 * size_of_y * by_k * change,
        squared,
    )
