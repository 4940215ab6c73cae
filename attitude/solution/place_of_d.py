"""The dynamic inertia D = L^2/2E of given periods, between the separatrix and an axis.

Symbols: A <= B <= C the moments.
"""

import math

from attitude.compilation.decorators import entry_point, subroutine
from attitude.solution.elliptic import complete_and_phase
from attitude.solution.twofloat import ONE, ZERO, sqrt

# y = (1 + exp(-z))^-1 measures D between the separatrix (0) and rotation about the axis (1).
_NEAREST, _FARTHEST = -690.0, 40.0


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


@entry_point
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
        low, high = _NEAREST, _FARTHEST
        out[n, 0] = out[n, 1] = out[n, 2] = math.nan
        if not (b - a if long_axis[n] else c - b) > 0.0:
            continue
        y, rest = _position(low)
        nearest = cycle(a, b, c, long_axis[n], y, rest)[0]
        farthest, period = cycle(a, b, c, long_axis[n], 1.0, 0.0)
        # Published ratios are rounded: one within 1e-14 of the limit counts as the limit.
        if not (ratios[n] < nearest and ratios[n] >= farthest * (1.0 - 1e-14)):
            continue
        if ratios[n] <= farthest:
            out[n, 0], out[n, 1], out[n, 2] = 1.0, 0.0, period
            continue
        for _ in range(80):
            middle = 0.5 * (low + high)
            if middle in (low, high):
                break
            y, rest = _position(middle)
            if cycle(a, b, c, long_axis[n], y, rest)[0] > ratios[n]:
                low = middle
            else:
                high = middle
        y, rest = _position(0.5 * (low + high))
        out[n, 0], out[n, 1] = y, rest
        out[n, 2] = cycle(a, b, c, long_axis[n], y, rest)[1]


@entry_point
def cycles_all(moments, long_axis, y, rest, out):
    """Fill (N, 2) with turns of phi of the long axis in a period of psi, and that for L = 1."""
    for n in range(len(out)):
        out[n, 0], out[n, 1] = cycle(
            moments[n, 0], moments[n, 1], moments[n, 2], long_axis[n], y[n], rest[n]
        )
