"""Central differences of the oracle: the witness of the derivatives.

Each parameter is moved by 1e-28 of its scale to either side, at 90 digits: the error of a
difference is 1e-50 of the derivative where that of the motion is not larger than 1e20.
"""

import numpy as np
from mpmath import mp, mpf, workdps

from tests.oracle import Oracle

_STEP = mpf(10) ** -28


def _product(p, q):
    return [
        p[0] * q[0] - p[1] * q[1] - p[2] * q[2] - p[3] * q[3],
        p[0] * q[1] + p[1] * q[0] + p[2] * q[3] - p[3] * q[2],
        p[0] * q[2] - p[1] * q[3] + p[2] * q[0] + p[3] * q[1],
        p[0] * q[3] + p[1] * q[2] - p[2] * q[1] + p[3] * q[0],
    ]


def sensitivity(moments, wxyz, omega, times):
    """Derivatives (T, 3, 9) of the attitude, inertial axes, and of the angular velocity."""
    attitude, rates = np.zeros((len(times), 3, 9)), np.zeros((len(times), 3, 9))
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
                attitude[k, :, j] = [float(sign * x / step) for x in turn[1:]]
                rates[k, :, j] = [float((x - y) / (2 * step)) for x, y in zip(u, v, strict=True)]
    return attitude, rates
