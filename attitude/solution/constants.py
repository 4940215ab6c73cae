"""Second stage: from the ordered state to rates and phases.

Nothing here cancels: differences of moments are computed from the inputs, and the invariants are
sums of terms of one sign.  Symbols and equation numbers are those of van Zon & Schofield (2006),
section 3.
"""

import math

from attitude.compilation.decorators import sized_entry_point, subroutine
from attitude.solution import codes
from attitude.solution.elliptic import complete_and_phase, quarter_and_fraction
from attitude.solution.series import four
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
    put,
    scale,
    sqrt,
    square,
    sub,
)


@sized_entry_point
def solve_all(constants):
    """Fill the rates and phases of those of B motions that tumble.

    Returned
        how many of them have the hyperbolic form
    """
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
    """Jacobi ordering (3.32): the angular momentum circulates about the internal third axis.

    A proper signed permutation also makes the first and third rates non-negative.
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
        c.root = math.sqrt(p[0])
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
