"""Second stage: from the ordered state to rates, phases and series.

Everything here is free of cancellation: differences of moments are formed from the inputs and the
invariants are sums of terms of one sign.  Symbols are those of van Zon & Schofield (2006), section
3; the equation numbers are theirs.
"""

import math

from attitude.solution import codes
from attitude.solution.coefficients import hyperbolic_series, trigonometric_series
from attitude.solution.elliptic import complete_and_phase, quarter_and_fraction
from attitude.solution.machine import compiled, inlined
from attitude.solution.twofloat import (
    HALF_PI,
    ONE,
    TWO_PI,
    ZERO,
    absolute,
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


@compiled
def solve_all(constants):
    """Rates, phases and series of those of B motions that tumble."""
    for b in range(len(constants)):
        c = constants[b]
        if c.fault == codes.FINE and c.form != codes.UNIFORM:
            jacobi(c)
            _solve(c)


@inlined
def jacobi(c):
    """Jacobi ordering (3.32): the angular momentum circulates about the internal third axis.

    A proper signed permutation also makes the first and third rates non-negative.
    """
    d2 = pair(c.d2)
    if d2[0] < 0.0:
        first, second, third = c.order[2], c.order[1], c.order[0]
        c.mode = codes.LONG_AXIS
    else:
        first, second, third = c.order[0], c.order[1], c.order[2]
        c.mode = codes.SHORT_AXIS
    if d2[0] == 0.0:
        c.mode = codes.SEPARATRIX
    elif c.gaps[1 if d2[0] < 0.0 else 0, 0] == 0.0:
        c.mode = codes.SYMMETRIC
    c.d2[0], c.d2[1] = absolute(d2)
    c.circulates = third
    minus1 = 1 if c.omega[first, 0] < 0.0 else 0
    minus3 = 1 if c.omega[third, 0] < 0.0 else 0
    c.jacobi[0], c.jacobi[1], c.jacobi[2], c.jacobi[3] = first, second, minus1, minus3


@inlined
def _solve(c):
    """Second stage: rates, phases and series of the internal motion; pairs throughout."""
    first, second = c.jacobi[0], c.jacobi[1]
    third = 3 - first - second
    i1, i2, i3 = pair(c.moments[first]), pair(c.moments[second]), pair(c.moments[third])
    w1, w3 = absolute(pair(c.omega[first])), absolute(pair(c.omega[third]))
    w2 = pair(c.omega[second])
    # The second axis keeps its direction where the permutation and both reversals are even.
    if (c.jacobi[2] + c.jacobi[3] + (0 if (second - first) % 3 == 1 else 1)) % 2 == 1:
        w2 = neg(w2)
    d2 = pair(c.d2)
    long_axis = third == c.order[0]
    d12, d23 = pair(c.gaps[1 if long_axis else 0]), pair(c.gaps[0 if long_axis else 1])
    d13 = add(d12, d23)
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
        hyperbolic_series(0.0, fraction, wobble, c)
        return

    quotient, quarter, turns = complete_and_phase(
        sqrt(mc), p, ZERO if long_axis else ONE, cosine, sine
    )
    c.quarter[0], c.quarter[1] = quarter
    root = sqrt(p)
    periodic = div(mul(l, HALF_PI), mul(quarter, root))
    if long_axis:
        # Rearranged so that all terms are positive, also for a needle
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
        trigonometric_series(stretch, fraction, root[0], wobble, c)
    else:
        c.form = codes.HYPERBOLIC
        _store_rate(c.nutation, scale(nutation, 2.0), c.tempo)
        c.nutation0[0], c.nutation0[1] = 2.0 * turns[0], 2.0 * turns[1]
        c.decay = 2.0 * math.pi / (stretch * math.log(2.0))
        c.tilt = 0.25 * fraction
        hyperbolic_series(math.exp(-math.pi / stretch), fraction, wobble, c)


@inlined
def _store_rate(field, rate, tempo):
    field[0], field[1] = math.ldexp(rate[0], tempo), math.ldexp(rate[1], tempo)


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
