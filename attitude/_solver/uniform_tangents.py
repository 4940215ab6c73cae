"""Sensitivity of rotations about a fixed axis: spheres, principal axes, rest.

The change dw of the angular velocity obeys dw' = A dw + f with constant A, A^3 = -sigma^2 A, and f
from a change of the moments (A^2 f = 0):

    dw = dw0 + S A dw0 + V (A^2 dw0 + A f) + t f,    S = sin(sigma t)/sigma, V = (1 - cos)/sigma^2

The change of attitude across L follows from the momentum, eta x L = dL - R (I dw + dI w), that
along L from the rate along it, which is constant.  So at resonance (a lamina: sigma equals the
spin) nothing is divided by a difference of frequencies.

Of a needle about its length that eta is a small difference until its axis has precessed: sigma is
almost the spin w, and eta' = R dw is integrated, with n = w -+ sigma, a the axis, and e = dw0
across a:

    eta = sum over n of sin(n t)/n (e +- a x A e/sigma)/2 + (1 - cos(n t))/n (a x e -+ A e/sigma)/2
"""

from __future__ import annotations

import math

from attitude._compilation.decorators import elementwise, force_inlined, subroutine
from attitude._compilation.instructions import fma
from attitude._solver.kernel import epoch_pair, turned_by, unit
from attitude._solver.records import BASIS, BLOCK, COLUMNS, SECONDS
from attitude._solver.series import sincos_at, triple
from attitude._solver.twofloat import (
    TWO_PI,
    ZERO,
    add,
    div,
    mul,
    neg,
    pair,
    scale,
    sqrt,
    square,
    sub,
)

# Rows of a block.
COSINE = BASIS
SINE = BASIS + BLOCK
SWING = BASIS + 2 * BLOCK
LIFT = BASIS + 3 * BLOCK
# A needle about its length: sin(n t)/n and (1 - cos(n t))/n of the slow n.
SLOW = BASIS + 4 * BLOCK
# The same of the fast n.
FAST = BASIS + 6 * BLOCK
# The moment about a spun principal axis over each of the other two, below which it is a needle.
_SLENDER = 0.5


@subroutine
def omega_of(c):
    """The angular velocity at the epoch (3), rad/s over the principal axes."""
    x, y, z, tempo = c.omega[0, 0], c.omega[1, 0], c.omega[2, 0], c.tempo
    return math.ldexp(x, tempo), math.ldexp(y, tempo), math.ldexp(z, tempo)


@subroutine
def couplings_of(c):
    """(Ij - Ik)/Ii of Euler's equations, pairs."""
    a, b, d = pair(c.moments[0]), pair(c.moments[1]), pair(c.moments[2])
    return div(sub(b, d), a), div(sub(d, a), b), div(sub(a, b), d)


@subroutine
def _wobble(c, d, couplings):
    """Fill the frequency of a small wobble: half of sigma, turns per second, and its kind."""
    one, two, three = couplings
    x, y, z = pair(c.omega[0]), pair(c.omega[1]), pair(c.omega[2])
    total = mul(mul(one, two), square(z))
    total = add(total, mul(mul(two, three), square(x)))
    total = add(total, mul(mul(one, three), square(y)))
    d.grows = 1.0 if total[0] > 0.0 else 0.0
    root = sqrt(total if total[0] > 0.0 else neg(total))
    frequency = div(root, scale(TWO_PI, 2.0))
    d.wobble[0] = math.ldexp(frequency[0], c.tempo)
    d.wobble[1] = math.ldexp(frequency[1], c.tempo)


@subroutine
def _beats(c, d, moments, omega):
    """Fill spin less and plus wobble where a needle spins about its length."""
    for k in range(3):
        one, two = (k + 1) % 3, (k + 2) % 3
        most = _SLENDER * min(moments[one], moments[two])
        if omega[one] == 0.0 and omega[two] == 0.0 and omega[k] != 0.0 and moments[k] < most:
            spin, wobble = pair(c.precession), pair(d.wobble)
            less, more = sub(spin, wobble), add(spin, wobble)
            d.beats[0, 0], d.beats[0, 1] = less
            d.beats[1, 0], d.beats[1, 1] = more


@subroutine
def _applied(couplings, omega, v):
    """A v over the principal axes."""
    return (
        couplings[0] * (omega[2] * v[1] + omega[1] * v[2]),
        couplings[1] * (omega[0] * v[2] + omega[2] * v[0]),
        couplings[2] * (omega[1] * v[0] + omega[0] * v[1]),
    )


@subroutine
def forced(couplings, omega, moments, m):
    """f of a unit change of moment m."""
    wx, wy, wz = omega[1] * omega[2], omega[2] * omega[0], omega[0] * omega[1]
    if m == 0:
        return -couplings[0] * wx / moments[0], -wy / moments[1], wz / moments[2]
    if m == 1:
        return wx / moments[0], -couplings[1] * wy / moments[1], -wz / moments[2]
    return -wx / moments[0], wy / moments[1], -couplings[2] * wz / moments[2]


@subroutine
def _cross(a, b):
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


@subroutine
def _dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@subroutine
def unit_vector(k):
    """The unit vector of axis k."""
    return 1.0 if k == 0 else 0.0, 1.0 if k == 1 else 0.0, 1.0 if k == 2 else 0.0


@subroutine
def fill_uniform(c, d, wxyz, principal):
    """Fill what scalars of `uniform_block` multiply in records.TANGENTS d, of records.CONSTANTS c.

    wxyz: attitude at the epoch; principal: principal axes to given body axes.
    """
    pairs_of, moments = couplings_of(c), (c.moments[0, 0], c.moments[1, 0], c.moments[2, 0])
    _wobble(c, d, pairs_of)
    couplings = pairs_of[0][0], pairs_of[1][0], pairs_of[2][0]
    omega = omega_of(c)
    speed = math.sqrt(_dot(omega, omega))
    _beats(c, d, moments, omega)
    over = 0.0 if speed == 0.0 else 1.0 / speed
    axis = omega[0] * over, omega[1] * over, omega[2] * over
    turns = unit(wxyz), principal
    along = _to_inertial(turns, axis)
    momentum = triple(d.momentum)
    squared = _dot(momentum, momentum)
    back = principal[0], -principal[1], -principal[2], -principal[3]
    for j in range(COLUMNS):
        u0, moment = (0.0, 0.0, 0.0), unit_vector(j - 6)
        u3 = u0
        if 3 <= j < 6:
            u0 = turned_by(back, unit_vector(j - 3))
        elif j >= 6:
            u3 = forced(couplings, omega, moments, j - 6)
        u1 = _applied(couplings, omega, u0)
        u2 = _applied(couplings, omega, u1)
        more = _applied(couplings, omega, u3)
        u2 = u2[0] + more[0], u2[1] + more[1], u2[2] + more[2]
        row = 0
        for u in (u0, u1, u2, u3):
            _put_rates(d, j, row, principal, u)
            _put_turn(d, j, row, turns, moments, axis, (u, omega, moment))
            row, moment = row + 1, (0.0, 0.0, 0.0)
        rate = _dot(axis, u0)
        still = _to_inertial(turns, u0)
        for k in range(3):
            if squared == 0.0:
                d.uniform[0, k, j] = 1.0 if j == k else 0.0
                d.uniform[1, k, j] = still[k]
            else:
                one = 1.0 if j == k else 0.0
                d.uniform[0, k, j] = one - d.uniform[2, k, j]
                d.uniform[1, k, j] = along[k] * rate
        if d.beats[1, 0] != 0.0:
            _put_beats(d, j, turns, axis, u0, u1)


@subroutine
def _to_inertial(turns, v):
    """A vector over the principal axes, over the inertial ones at the epoch."""
    start, principal = turns
    return turned_by(start, turned_by(principal, v))


@subroutine
def _put_beats(d, j, turns, axis, u0, u1):
    """Fill, in place of the rows of `_put_turn`, what the functions of the two beats multiply."""
    rate, over = _dot(axis, u0), 1.0 / (4.0 * math.pi * d.wobble[0])
    across = u0[0] - rate * axis[0], u0[1] - rate * axis[1], u0[2] - rate * axis[2]
    later, wobble = _cross(axis, across), (over * u1[0], over * u1[1], over * u1[2])
    across, later = _to_inertial(turns, across), _to_inertial(turns, later)
    behind, wobble = _to_inertial(turns, _cross(axis, wobble)), _to_inertial(turns, wobble)
    for k in range(3):
        d.uniform[0, k, j] = 1.0 if j == k else 0.0
        d.uniform[2, k, j] = 0.5 * (across[k] + behind[k])
        d.uniform[3, k, j] = 0.5 * (later[k] - wobble[k])
        d.uniform[4, k, j] = 0.5 * (across[k] - behind[k])
        d.uniform[5, k, j] = 0.5 * (later[k] + wobble[k])


@subroutine
def _put_rates(d, j, row, principal, v):
    v, unit = turned_by(principal, v), d.moment_unit if j >= 6 else 1.0
    for k in range(3):
        d.uniform_rates[row, k, j] = unit * v[k]


@subroutine
def _put_turn(d, j, row, turns, moments, axis, change):
    """Fill -L x R0 v / L^2 and the same of v a quarter turn later, v = I u + dI w across L."""
    u, omega, moment = change
    v = (
        moments[0] * u[0] + moment[0] * omega[0],
        moments[1] * u[1] + moment[1] * omega[1],
        moments[2] * u[2] + moment[2] * omega[2],
    )
    # over the body axes, where the product is 0 if v lies along a principal axis that L has
    momentum = moments[0] * omega[0], moments[1] * omega[1], moments[2] * omega[2]
    squared = _dot(momentum, momentum)
    over, unit = 0.0 if squared == 0.0 else -1.0 / squared, d.moment_unit if j >= 6 else 1.0
    now = _to_inertial(turns, _cross(momentum, v))
    later = _to_inertial(turns, _cross(momentum, _cross(axis, v)))
    for k in range(3):
        d.uniform[2 + row, k, j] = unit * (over * now[k])
        d.uniform[6 + row, k, j] = unit * (over * later[k])


@elementwise
@force_inlined
def uniform_block(c, d, t, t_low, block):
    """Fill seconds, cosine and sine of the turn, S and V of a block; arguments as in tangents."""
    precession = pair(c.precession)
    for i in range(len(t)):
        time, low = epoch_pair(t, t_low, i)
        sine, cosine = sincos_at(precession, ZERO, time, low)
        block[SECONDS + i] = time + low
        block[COSINE + i] = fma(-2.0 * sine, sine, 1.0)
        block[SINE + i] = 2.0 * sine * cosine
    _wobbles(d, t, t_low, block)
    if d.beats[1, 0] != 0.0:
        _beat(pair(d.beats[0]), t, t_low, block, SLOW)
        _beat(pair(d.beats[1]), t, t_low, block, FAST)


@force_inlined
def _beat(rate, t, t_low, block, row):
    """Fill the rows of sin(n t)/n and (1 - cos(n t))/n, n = 4 pi times the rate."""
    over = 0.0 if rate[0] == 0.0 else 0.5 / (math.pi * rate[0])
    for i in range(len(t)):
        time, low = epoch_pair(t, t_low, i)
        sine, cosine = sincos_at(rate, ZERO, time, low)
        block[row + i] = time + low if rate[0] == 0.0 else over * sine * cosine
        block[row + BLOCK + i] = over * sine * sine


@subroutine
def _wobbles(d, t, t_low, block):
    """Fill the rows of S and V."""
    rate = pair(d.wobble)
    half = 2.0 * math.pi * rate[0]
    over = 0.0 if rate[0] == 0.0 else 1.0 / half
    for i in range(len(t)):
        time, low = epoch_pair(t, t_low, i)
        seconds = time + low
        if rate[0] == 0.0:
            swing, lift = seconds, 0.5 * seconds * seconds
        else:
            if d.grows != 0.0:
                sine = math.sinh(half * seconds)
                cosine = math.sqrt(1.0 + sine * sine)
            else:
                sine, cosine = sincos_at(rate, ZERO, time, low)
            swing, lift = over * sine * cosine, 0.5 * (over * sine) * (over * sine)
        block[SWING + i] = swing
        block[LIFT + i] = lift


@subroutine
def _sum(u, k, j, first, swing, lift, seconds):
    return fma(u[first + 1, k, j], swing, u[first, k, j]) + fma(
        u[first + 2, k, j], lift, u[first + 3, k, j] * seconds
    )


@elementwise
@force_inlined
def uniform_column(c, d, j, block, x, y, z):
    """Fill the change of attitude over inertial axes with parameter j (columns)."""
    u = d.uniform
    if d.beats[1, 0] != 0.0:
        _beat_row(u, 0, j, block, x)
        _beat_row(u, 1, j, block, y)
        _beat_row(u, 2, j, block, z)
        return
    for i in range(len(x)):
        seconds, swing, lift = block[SECONDS + i], block[SWING + i], block[LIFT + i]
        cosine, sine = block[COSINE + i], block[SINE + i]
        a = fma(u[1, 0, j], seconds, u[0, 0, j])
        b = fma(u[1, 1, j], seconds, u[0, 1, j])
        e = fma(u[1, 2, j], seconds, u[0, 2, j])
        a = fma(sine, _sum(u, 0, j, 6, swing, lift, seconds), a)
        b = fma(sine, _sum(u, 1, j, 6, swing, lift, seconds), b)
        e = fma(sine, _sum(u, 2, j, 6, swing, lift, seconds), e)
        x[i] = fma(cosine, _sum(u, 0, j, 2, swing, lift, seconds), a)
        y[i] = fma(cosine, _sum(u, 1, j, 2, swing, lift, seconds), b)
        z[i] = fma(cosine, _sum(u, 2, j, 2, swing, lift, seconds), e)


@elementwise
@force_inlined
def _beat_row(u, k, j, block, x):
    """Fill a row of the change of attitude of a needle about its length."""
    still, along = u[0, k, j], u[1, k, j]
    a, b, c, d = u[2, k, j], u[3, k, j], u[4, k, j], u[5, k, j]
    for i in range(len(x)):
        change = fma(along, block[SECONDS + i], still)
        change = fma(d, block[FAST + BLOCK + i], fma(c, block[FAST + i], change))
        x[i] = fma(b, block[SLOW + BLOCK + i], fma(a, block[SLOW + i], change))


@elementwise
@force_inlined
def uniform_rate_column(c, d, j, block, x, y, z):
    """Fill the change of the angular velocity, rad/s over the given body axes."""
    u = d.uniform_rates
    for i in range(len(x)):
        seconds, swing, lift = block[SECONDS + i], block[SWING + i], block[LIFT + i]
        x[i] = _sum(u, 0, j, 0, swing, lift, seconds)
        y[i] = _sum(u, 1, j, 0, swing, lift, seconds)
        z[i] = _sum(u, 2, j, 0, swing, lift, seconds)
