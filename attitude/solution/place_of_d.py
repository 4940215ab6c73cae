"""The dynamic inertia D = L^2/2E of given periods, between the separatrix and an axis.

Symbols: A <= B <= C the moments.
"""

import math

from attitude.compilation.decorators import sized_entry_point, subroutine
from attitude.solution.elliptic import complete_and_phase
from attitude.solution.twofloat import ONE, ZERO, sqrt

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
def cycle(a, b, c, long_axis, y, rest):
    """Turns of phi of the long axis in one period of psi, and that period for L = 1.

    D is B + y (A - B) in long-axis mode, B + y (C - B) in short-axis mode; rest = 1 - y.  Every
    difference is a sum of terms of one sign.

        <dphi_L/dt> = (L/C) [1 + nu (C-A)/A R_J(0,1-m,1,1+nu) / (3 R_F(0,1-m,1))]

    where R_J/3 = cel(kc, 1+nu, 0, 1).
    """
    if long_axis:
        bd = (b - a) * y
        d, da, cd = b - bd, (b - a) * rest, (c - b) + bd
        mc = (c - a) * y / cd
        slope = ((b - a) / a) * (cd / b) / (c * d)
        nu = (a / c) * ((c - b) / (b - a))
    else:
        db = (c - b) * y
        d, da, cd = b + db, (b - a) + db, (c - b) * rest
        mc = (c - a) * y / da
        slope = ((c - b) / a) * (da / b) / (c * d)
        nu = (a / c) * (cd / da)
    quotient, quarter, _ = complete_and_phase(sqrt((mc, 0.0)), (1.0 + nu, 0.0), ZERO, ONE, ZERO)
    phi = (1.0 + nu * ((c - a) / a) * quotient[0]) / c
    psi = 4.0 * quarter[0] / math.sqrt(slope)
    return phi * psi / (2.0 * math.pi), psi


@subroutine
def _place(near, u):
    """y and 1 - y: u is z where D is nearer to the separatrix, 1 - y where it is not."""
    return _position(u) if near else (1.0 - u, u)


@subroutine
def _interpolated(x1, f1, x2, f2, x3, f3):
    """Where the next value is taken between x1 (0) and x2 (1), from a point x3 outside of them.

    By the inverse parabola through the three where it is monotonic between x1 and x2, in the middle
    where it is not.
    """
    part, rise = (x1 - x2) / (x3 - x2), (f1 - f2) / (f3 - f2)
    if rise * rise < part and (1.0 - rise) * (1.0 - rise) < 1.0 - part:
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
    near = f1 < 0.0
    x1, x2, f2, p2 = 0.5, 0.0, farthest - ratio, p1
    if near:
        y, rest = _position(_NEAREST)
        nearest, p2 = cycle(a, b, c, long_axis, y, rest)
        x1, x2, f2 = 0.0, _NEAREST, nearest - ratio
        if not f2 > 0.0:
            return math.nan, math.nan, math.nan
    t = f1 / (f1 - f2)
    for _ in range(_MOST):
        x = x1 + t * (x2 - x1)
        y, rest = _place(near, x)
        f, p = cycle(a, b, c, long_axis, y, rest)
        f -= ratio
        if (f > 0.0) == (f1 > 0.0):
            x3, f3 = x1, f1
        else:
            x3, f3, x2, f2, p2 = x2, f2, x1, f1, p1
        x1, f1, p1 = x, f, p
        best, value, period = (x1, f1, p1) if abs(f1) < abs(f2) else (x2, f2, p2)
        least = (2.0 * _EPS * abs(best) + (_EPS if near else 0.0)) / abs(x2 - x1)
        if least > 0.5 or value == 0.0:
            y, rest = _place(near, best)
            return y, rest, period
        t = min(max(_interpolated(x1, f1, x2, f2, x3, f3), least), 1.0 - least)
    y, rest = _place(near, x1)
    return y, rest, p1


@sized_entry_point
def positions_all(moments, long_axis, ratios, out):
    """Fill y, 1 - y and P_psi for L = 1 of given P_psi / P_phi of the long axis.

    The ratio falls from infinity on the separatrix to its limit for rotation about the axis, so
    that there is at most one D.

    Given
        moments (N, 3) ascending; long_axis (N,) booleans; ratios (N,)
    Filled
        out (N, 3); NaN where the ratio is below its limit, or so large that D is within 1e-300 of
        the separatrix
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
def cycles_all(moments, long_axis, y, rest, out):
    """Fill (N, 2) with turns of phi of the long axis in a period of psi, and that for L = 1."""
    for n in range(len(out)):
        out[n, 0], out[n, 1] = cycle(
            moments[n, 0], moments[n, 1], moments[n, 2], long_axis[n], y[n], rest[n]
        )
