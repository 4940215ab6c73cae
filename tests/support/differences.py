"""Central differences of the oracle: the witness of the derivatives.

Each parameter is moved by 1e-28 of its scale to either side, at 90 digits: the error of a
difference is 1e-50 of the derivative where that of the motion is not larger than 1e20.
"""

import numpy as np
from mpmath import mp, mpf, workdps

from tests.support.oracle import Oracle

_STEP = mpf(10) ** -28
# Beside the doubles that are given, a relative change at which the derivatives are taken again.
_SHIFT = mpf(10) ** -20
_LAST_BIT = 2.0**-53


def _product(p, q):
    return [
        p[0] * q[0] - p[1] * q[1] - p[2] * q[2] - p[3] * q[3],
        p[0] * q[1] + p[1] * q[0] + p[2] * q[3] - p[3] * q[2],
        p[0] * q[2] - p[1] * q[3] + p[2] * q[0] + p[3] * q[1],
        p[0] * q[3] + p[1] * q[2] - p[2] * q[1] + p[3] * q[0],
    ]


def sensitivity(moments, wxyz, omega, times):
    """Derivatives (T, 3, 9) of the attitude, inertial axes, and of the angular velocity."""
    attitude, rates = exact_sensitivity(moments, wxyz, omega, times)
    return attitude.astype(float), rates.astype(float)


def exact_sensitivity(moments, wxyz, omega, times):
    """As `sensitivity`, in arrays of mpf; moments, angular velocity and times may be mpf."""
    attitude = np.full((len(times), 3, 9), mpf(0))
    rates = attitude.copy()
    with workdps(90):
        moments, omega = [mpf(x) for x in moments], [mpf(x) for x in omega]
        length = mp.sqrt(sum(mpf(x) ** 2 for x in wxyz))
        wxyz = [mpf(x) / length for x in wxyz]
        for j in range(9):
            scale = (mpf(1), max(map(abs, omega)) or mpf(1), max(moments))[j // 3]
            step = _STEP * scale
            sides = []
            for sign in (1, -1):
                q, w, i = list(wxyz), list(omega), list(moments)
                if j < 3:
                    turn = [mpf(1), mpf(0), mpf(0), mpf(0)]
                    turn[1 + j] = sign * step / 2
                    q = _product(turn, q)
                elif j < 6:
                    w[j - 3] += sign * step
                else:
                    i[j - 6] += sign * step
                sides.append(Oracle(i, q, w, digits=70))
            for k, t in enumerate(times):
                (a, u), (b, v) = sides[0].at(t), sides[1].at(t)
                turn = _product(a, [b[0], -b[1], -b[2], -b[3]])
                sign = 1 if turn[0] > 0 else -1
                attitude[k, :, j] = [sign * x / step for x in turn[1:]]
                rates[k, :, j] = [(x - y) / (2 * step) for x, y in zip(u, v, strict=True)]
    return attitude, rates


def conditioning(moments, wxyz, omega, times):
    """By how much the last bit of one input can change each column, over its largest entry.

    Returns
    -------
    (T, 9) arrays of the attitude and of the angular velocity; the inputs are the moments, the
    angular velocity and the times, each changed by 2^-53 of itself.
    """
    with workdps(90):
        given = [[mpf(x) for x in each] for each in (moments, omega, times)]
        middle = exact_sensitivity(given[0], wxyz, given[1], given[2])
        most = [np.zeros((len(times), 9)) for _ in middle]
        places = [(0, k) for k in range(3)] + [(1, k) for k in range(3) if omega[k] != 0.0]
        for part, k in [*places, (2, None)]:
            moved = [list(each) for each in given]
            for place in range(len(times)) if k is None else (k,):
                moved[part][place] *= 1 + _SHIFT
            found = exact_sensitivity(moved[0], wxyz, moved[1], moved[2])
            for one, other, total in zip(found, middle, most, strict=True):
                change = np.abs((one - other) / _SHIFT).max(axis=1)
                size = np.abs(other).max(axis=1)
                size[size == 0] = mpf(1)
                np.maximum(total, (change / size).astype(float) * _LAST_BIT, out=total)
    return most
