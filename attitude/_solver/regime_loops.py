"""Periods, ranges and times of motions, and the motion of given periods; compiled loops.

Symbols: A <= B <= C the moments, D = L^2/2E the dynamic inertia.  In Jacobi order (section 3 of van
Zon & Schofield 2006) the third axis is the one about which the momentum circulates: that of A in
long-axis mode, that of C in short-axis mode; the first is the other extreme.  With L = 1 and l_i
the direction cosines of the momentum, w1 ~ cn, w2 ~ -sn and w3 ~ dn, so that every range below is
met at sn = 0 and at cn = 0.
"""

from __future__ import annotations

import math

import numpy as np

from attitude._compilation.decorators import sized_entry_point, subroutine
from attitude._solver import codes
from attitude._solver.elliptic import complete_and_phase
from attitude._solver.twofloat import HALF_PI, ONE, ZERO, absolute, less, pair, sqrt, sub, two_sum

# Rates are in turns per second, angles in rad, speeds in rad/s, times in s.
REGIME: np.dtype[np.void] = np.dtype(
    [
        ("mode", "i8"),
        ("circulates", "i8"),  # 1 about the short axis, -1 about the long one, 0 about neither
        ("energy_ratio", "f8"),  # 2 E C / L^2
        ("dynamic_inertia", "f8"),  # D
        ("m", "f8"),
        ("mc", "f8"),  # 1 - m
        ("psi_rate", "f8"),  # positive
        ("phi_rate_long", "f8"),
        ("phi_rate_short", "f8"),
        ("nutation_long", "f8", 2),  # least, greatest
        ("nutation_short", "f8", 2),
        ("precession_long", "f8", 2),
        ("precession_short", "f8", 2),
        ("libration", "f8"),  # amplitude of psi in the labelling where it librates
        ("speed", "f8"),  # |w| at the epoch
        ("speed_at", "f8", 2),  # |w| at sn = 0 and at cn = 0
        ("speed_along", "f8"),  # component along the momentum, 2 E / L
        ("flip", "f8"),
        ("dwell", "f8"),
    ]
)
# Below this m, K(m) - pi/2 is its series to two terms, good to 1e-20; above, the difference of
# pairs of doubles keeps 20 digits.
_SMALL_M = 1e-10
# Steps of the trapezoidal sum in ln tan(am): its error, 14 exp(-pi^2 / h) at most, is below 2^-53.
_STEP = 0.25
_TAIL = 42.0


@sized_entry_point
def regimes_all(moments, constants, out):
    """Fill out (B,) of REGIME, from pairs of moments (B, 3, 2) and their records.CONSTANTS (B,)."""
    for b in range(len(out)):
        c, o = constants[b], out[b]
        largest = max(moments[b, 0, 0], moments[b, 1, 0], moments[b, 2, 0])
        _shared(math.frexp(largest)[1], c, o)
        if c.mode == codes.AT_REST:
            _at_rest(o)
        elif c.form == codes.UNIFORM:
            _uniform(c, o)
        else:
            _tumbling(c, o)


@subroutine
def _shared(inertia, c, o):
    """Fill what is the same formula in every mode; `inertia` is the exponent of the moments."""
    energy = square = largest = speed = 0.0
    for k in range(3):
        i, w = c.moments[k, 0], c.omega[k, 0]
        energy += i * w * w
        square += (i * w) ** 2
        speed += w * w
        largest = max(largest, i)
    o.mode = c.mode
    o.energy_ratio = largest * energy / square  # 0/0 = nan at rest
    o.dynamic_inertia = math.ldexp(square / energy, inertia)
    o.speed = math.ldexp(math.sqrt(speed), c.tempo)
    o.speed_along = math.ldexp(energy / math.sqrt(square), c.tempo)


@subroutine
def _at_rest(o):
    """Fill the limits for no rotation."""
    o.circulates = 0
    o.m, o.mc = 0.0, 1.0
    o.psi_rate = o.phi_rate_long = o.phi_rate_short = 0.0
    o.speed_along = o.libration = o.dwell = 0.0
    o.flip = math.inf
    for k in range(2):
        o.nutation_long[k] = o.nutation_short[k] = math.nan
        o.precession_long[k] = o.precession_short[k] = o.speed_at[k] = 0.0


@subroutine
def _uniform(c, o):
    """Fill the limits, for a vanishing wobble, of a constant angular velocity."""
    p, r = 0, 2  # the long and the short axis; equal moments in the order given
    for k in range(3):
        if less(pair(c.moments[k]), pair(c.moments[p])):
            p = k
    for k in range(2, -1, -1):
        if less(pair(c.moments[r]), pair(c.moments[k])):
            r = k
    long_axis = c.circulates >= 0 and c.circulates == p
    o.circulates = 0 if c.circulates < 0 else (-1 if long_axis else 1)
    o.m, o.mc = 0.0, 1.0
    o.libration = o.dwell = 0.0
    turns = o.speed / (2.0 * math.pi)
    o.psi_rate = abs(c.psi_rate)
    o.phi_rate_long = o.phi_rate_short = turns
    o.flip = 0.5 / o.psi_rate if o.psi_rate > 0.0 else math.inf
    for k in range(2):
        o.precession_long[k] = o.precession_short[k] = o.speed_at[k] = o.speed
    if p != r:
        q = 3 - p - r
        a, b, d = c.moments[p, 0], c.moments[q, 0], c.moments[r, 0]
        if long_axis:
            # 1 - s = (1 - s^2) / (1 + s) for s = sqrt((B-A)(C-A)/BC): a needle's phi is slow
            s = o.psi_rate / turns
            o.phi_rate_long = turns * (a / b) * ((b + d - a) / d) / (1.0 + s)
            o.precession_long[0], o.precession_long[1] = o.speed * (a / d), o.speed * (a / b)
        elif c.circulates >= 0:
            o.phi_rate_short = turns + o.psi_rate
            o.precession_short[0], o.precession_short[1] = o.speed * (d / b), o.speed * (d / a)
        elif c.omega[q, 0] != 0.0 and c.omega[p, 0] == 0.0 and c.omega[r, 0] == 0.0:
            low = sub(pair(c.moments[q]), pair(c.moments[p]))[0]
            high = sub(pair(c.moments[r]), pair(c.moments[q]))[0]
            growth = o.speed * math.sqrt((low / a) * (high / d)) if low > 0.0 else 0.0
            if growth > 0.0:  # about the middle axis: the fixed point of the separatrix
                o.m, o.mc, o.libration = 1.0, 0.0, 0.5 * math.pi
                o.flip, o.dwell = math.pi / growth, math.inf
    x, z = c.moments[p, 0] * c.omega[p, 0], c.moments[r, 0] * c.omega[r, 0]
    y = 0.0
    for k in range(3):
        if k != p and k != r:
            y = c.moments[k, 0] * c.omega[k, 0]
    for k in range(2):
        o.nutation_long[k] = math.atan2(math.hypot(y, z), abs(x))
        o.nutation_short[k] = math.atan2(math.hypot(x, y), abs(z))


@subroutine
def _tumbling(c, o):
    """Fill periods and ranges of a motion in Jacobi order."""
    one, two = c.jacobi[0], c.jacobi[1]
    three = 3 - one - two
    first, second, third = pair(c.moments[one]), pair(c.moments[two]), pair(c.moments[three])
    i1, i2, i3 = first[0], second[0], third[0]
    w1, w2, w3 = c.omega[one, 0], c.omega[two, 0], c.omega[three, 0]
    long_axis = less(third, first)
    d12, d13 = absolute(sub(first, second))[0], absolute(sub(first, third))[0]
    d23 = absolute(sub(second, third))[0]
    d1 = i2 * d12 * w2 * w2 + i3 * d13 * w3 * w3
    d3 = i1 * d13 * w1 * w1 + i2 * d23 * w2 * w2
    d2 = c.d2[0]
    separatrix = c.mode == codes.SEPARATRIX
    o.circulates = 0 if separatrix else (-1 if long_axis else 1)
    o.m, o.mc = c.m, c.mc[0]
    o.psi_rate = abs(c.psi_rate)
    # The sum of the rates of both phases is that of phi in the other labelling.
    circulating = c.phi_rate
    other = 2.0 * c.precession[0]
    if separatrix:
        circulating = other
    # cos^2 and sin^2 of the nutation, each up to one factor, at sn = 0 and at cn = 0
    least = math.atan2(math.sqrt(i1 * d3), math.sqrt(i3 * d1))
    most = math.atan2(math.sqrt(i2 * d3), math.sqrt(i3 * d2))
    most = max(least, most)
    o.libration = most
    momentum = math.hypot(math.hypot(i1 * w1, i2 * w2), i3 * w3)
    momentum = math.ldexp(momentum, c.tempo)
    rate1, rate2, rate3 = momentum / i1, momentum / i2, momentum / i3
    # Both ends of the other extreme axis come as near; on the separatrix it stops halfway.
    low = math.atan2(math.sqrt(i3 * d1), math.sqrt(i1 * d3))
    high = 0.5 * math.pi if separatrix else 0.5 * math.pi + least
    if long_axis:
        o.phi_rate_long, o.phi_rate_short = circulating, other
        _between(o.nutation_long, least, most)
        _between(o.nutation_short, low, high)
        _between(o.precession_long, rate1, rate2)
        _between(o.precession_short, rate3, o.speed_along)
    else:
        o.phi_rate_long, o.phi_rate_short = other, circulating
        _between(o.nutation_short, least, most)
        _between(o.nutation_long, low, high)
        _between(o.precession_short, rate1, rate2)
        _between(o.precession_long, rate3, o.speed_along)
    o.speed_at[0] = math.hypot(c.amplitudes[0], c.amplitudes[2])
    o.speed_at[1] = math.hypot(c.amplitudes[1], math.sqrt(c.mc[0]) * c.amplitudes[2])
    # On the separatrix the middle axis turns by gd(wp t), at wp when it is fastest.
    speed = math.ldexp(math.sqrt((d1 / i1) * (d23 / i2) / i3), c.tempo)
    o.flip = math.pi / speed
    if separatrix:
        o.dwell = math.inf
    elif c.m < _SMALL_M:
        o.dwell = 0.25 * math.pi * c.m * (1.0 + 0.5625 * c.m) / speed
    else:
        o.dwell = 2.0 * sub(pair(c.quarter), HALF_PI)[0] / speed


@subroutine
def _between(field, x, y):
    """Fill a range with its least and greatest value."""
    field[0], field[1] = min(x, y), max(x, y)


@sized_entry_point
def mean_speeds(regimes, out):
    """Fill the time averages (N,) of |angular velocity|, rad/s, from regimes (N,) of REGIME.

    It is sqrt(s0^2 cn^2 + s1^2 sn^2).  In x = ln tan(am u) the average is an integral over the
    whole line of a function that is analytic for |Im x| < pi/2 at any modulus: the trapezoidal sum
    has all digits, also where the period is 1e100 flips long.
    """
    for b in range(len(out)):
        o = regimes[b]
        s0, s1, mc = o.speed_at[0], o.speed_at[1], o.mc
        if mc <= 0.0 or s0 == s1:
            out[b] = s1
            continue
        size = max(s0, s1)
        p, q = (s0 / size) ** 2, (s1 / size) ** 2
        count = int((2.0 * _TAIL - 0.5 * math.log(mc)) / _STEP)
        total = weights = lost = lost_weights = 0.0
        for k in range(count + 1):
            x = -_TAIL + k * _STEP
            if x < 0.0:
                t = math.exp(x)
                square = t * t
                weight = t / math.sqrt((1.0 + square) * (1.0 + mc * square))
                value = (p + q * square) / (1.0 + square)
            else:
                t = math.exp(-x)
                square = t * t
                weight = t / (math.sqrt(1.0 + square) * math.sqrt(square + mc))
                value = (p * square + q) / (1.0 + square)
            # hundreds of terms of one size: what their sums lose is added in the end
            total, error = two_sum(total, weight * math.sqrt(value))
            lost += error
            weights, error = two_sum(weights, weight)
            lost_weights += error
        out[b] = size * (total + lost) / (weights + lost_weights)


# ---- The dynamic inertia D = L^2/2E of given periods, between the separatrix and an axis
# Symbols: A <= B <= C the moments.

# y = (1 + exp(-z))^-1 measures D between the separatrix (0) and rotation about the axis (1).
_NEAREST = -690.0
_EPS = 2.0**-53
# A bracket that is halved at each step is as narrow as doubles are after so many.
_MOST = 120


@subroutine
def _position(z):
    """y and 1 - y of z, both with all digits."""
    if z < 0.0:
        e = math.exp(z)
        return e / (1.0 + e), 1.0 / (1.0 + e)
    e = math.exp(-z)
    return 1.0 / (1.0 + e), e / (1.0 + e)


@subroutine
def cycle(a, b, c, long_axis, y, one_minus_y):
    """Turns of phi of the long axis in one period of psi, and that period for L = 1.

    D is B + y (A - B) in long-axis mode, B + y (C - B) in short-axis mode.  Every difference is a
    sum of terms of one sign.

        <dphi_L/dt> = (L/C) [1 + nu (C-A)/A R_J(0,1-m,1,1+nu) / (3 R_F(0,1-m,1))]

    where R_J/3 = cel(kc, 1+nu, 0, 1).
    """
    if long_axis:
        d, cd = a + (b - a) * one_minus_y, (c - b) + (b - a) * y
        mc = (c - a) * y / cd
        slope = ((b - a) / a) * (cd / b) / (c * d)
        nu = (a / c) * ((c - b) / (b - a))
    else:
        db = (c - b) * y
        d, da, cd = b + db, (b - a) + db, (c - b) * one_minus_y
        mc = (c - a) * y / da
        slope = ((c - b) / a) * (da / b) / (c * d)
        nu = (a / c) * (cd / da)
    quotient, quarter, _ = complete_and_phase(sqrt((mc, 0.0)), (1.0 + nu, 0.0), ZERO, ONE, ZERO)
    phi = (1.0 + nu * ((c - a) / a) * quotient[0]) / c
    psi = 4.0 * quarter[0] / math.sqrt(slope)
    return phi * psi / (2.0 * math.pi), psi


@subroutine
def _place(by_z, u):
    """y and 1 - y: u is z (by_z) where D is nearer to the separatrix, 1 - y where it is not."""
    return _position(u) if by_z else (1.0 - u, u)


@subroutine
def _interpolated(x1, f1, x2, f2, x3, f3):
    """The next value between x1 (0) and x2 (1), by the inverse parabola through a third point x3
    where it is monotonic between them, else in the middle.
    """
    run, rise = (x1 - x2) / (x3 - x2), (f1 - f2) / (f3 - f2)
    if rise * rise < run and (1.0 - rise) * (1.0 - rise) < 1.0 - run:
        t = f1 / (f2 - f1) * (f3 / (f2 - f3))
        return t + (x3 - x1) / (x2 - x1) * (f1 / (f3 - f1)) * (f2 / (f3 - f2))
    return 0.5


@subroutine
def _solved(a, b, c, long_axis, ratio, farthest):
    """y, 1 - y and P_psi for L = 1 of a ratio above its limit `farthest`; NaN if it is too large.

    The ratio is nearly linear in z near the separatrix and in 1 - y near the axis: each is the
    unknown on its side, from the secant of the ends on, by Chandrupatla's method (Advances in
    Engineering Software 28, 145, 1997), which keeps a bracket: 6 to 10 values of the ratio in place
    of the 60 of a bisection.
    """
    half, p1 = cycle(a, b, c, long_axis, 0.5, 0.5)
    f1 = half - ratio
    near_separatrix = f1 < 0.0
    x1, x2, f2, p2 = 0.5, 0.0, farthest - ratio, p1
    if near_separatrix:
        y, complement = _position(_NEAREST)
        nearest, p2 = cycle(a, b, c, long_axis, y, complement)
        x1, x2, f2 = 0.0, _NEAREST, nearest - ratio
        if not f2 > 0.0:
            return math.nan, math.nan, math.nan
    t = f1 / (f1 - f2)
    for _ in range(_MOST):
        x = x1 + t * (x2 - x1)
        y, complement = _place(near_separatrix, x)
        f, p = cycle(a, b, c, long_axis, y, complement)
        f -= ratio
        if (f > 0.0) == (f1 > 0.0):
            x3, f3 = x1, f1
        else:
            x3, f3, x2, f2, p2 = x2, f2, x1, f1, p1
        x1, f1, p1 = x, f, p
        best, value, period = (x1, f1, p1) if abs(f1) < abs(f2) else (x2, f2, p2)
        least = (2.0 * _EPS * abs(best) + (_EPS if near_separatrix else 0.0)) / abs(x2 - x1)
        if least > 0.5 or value == 0.0:
            y, complement = _place(near_separatrix, best)
            return y, complement, period
        t = min(max(_interpolated(x1, f1, x2, f2, x3, f3), least), 1.0 - least)
    y, complement = _place(near_separatrix, x1)
    return y, complement, p1


@sized_entry_point
def positions_all(moments, long_axis, ratios, out):
    """Fill out (N, 3): y, 1 - y and P_psi for L = 1 of given P_psi / P_phi (N,) of the long axis.

    The ratio falls from infinity on the separatrix to its limit for rotation about the axis: there
    is at most one D.  NaN where it is below its limit, or so large that D is within 1e-300 of the
    separatrix.  moments (N, 3) ascend; long_axis (N,) are booleans.
    """
    for n in range(len(out)):
        a, b, c = moments[n, 0], moments[n, 1], moments[n, 2]
        out[n, 0] = out[n, 1] = out[n, 2] = math.nan
        if not (a > 0.0 and (b - a if long_axis[n] else c - b) > 0.0):
            continue
        farthest, period = cycle(a, b, c, long_axis[n], 1.0, 0.0)
        # Published ratios are rounded: one within 1e-14 of the limit counts as the limit.
        if not farthest * (1.0 - 1e-14) <= ratios[n] < math.inf:
            continue
        if ratios[n] <= farthest:
            out[n, 0], out[n, 1], out[n, 2] = 1.0, 0.0, period
        else:
            out[n, 0], out[n, 1], out[n, 2] = _solved(a, b, c, long_axis[n], ratios[n], farthest)


@sized_entry_point
def cycles_all(moments, long_axis, y, one_minus_y, out):
    """Fill (N, 2) with turns of phi of the long axis in a period of psi, and that for L = 1."""
    for n in range(len(out)):
        out[n, 0], out[n, 1] = cycle(
            moments[n, 0], moments[n, 1], moments[n, 2], long_axis[n], y[n], one_minus_y[n]
        )
