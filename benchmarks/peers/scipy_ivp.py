"""scipy's integrators on Euler's equations and the quaternion's."""

import numpy as np
from scipy.integrate import solve_ivp

from benchmarks.peers import Peer

_TOLERANCES = {"DOP853": (1e-6, 1e-9, 1e-12), "LSODA": (1e-6, 1e-9, 1e-12), "RK45": (1e-6, 1e-9)}


def peers():
    return [
        Peer(f"scipy {method}", f"{tolerance:.0e}", _solver(method, tolerance), 2e3)
        for method, tolerances in _TOLERANCES.items()
        for tolerance in tolerances
    ]


def _solver(method, tolerance):
    def solve(moments, wxyz0, omega0, t):
        i1, i2, i3 = (float(x) for x in moments)
        f1, f2, f3 = (i2 - i3) / i1, (i3 - i1) / i2, (i1 - i2) / i3

        def derivative(_, y):
            w, x, y_, z, p, q, r = y.tolist()
            return (
                0.5 * (-x * p - y_ * q - z * r),
                0.5 * (w * p + y_ * r - z * q),
                0.5 * (w * q + z * p - x * r),
                0.5 * (w * r + x * q - y_ * p),
                f1 * q * r,
                f2 * r * p,
                f3 * p * q,
            )

        start = np.concatenate([np.asarray(wxyz0, float), np.asarray(omega0, float)])
        scale = np.concatenate([np.ones(4), np.full(3, np.max(np.abs(omega0)))])
        found = solve_ivp(
            derivative,
            (0.0, float(t[-1])),
            start,
            method,
            t,
            rtol=tolerance,
            atol=tolerance * scale,
        )
        if found.status != 0:
            raise ArithmeticError(found.message)
        return found.y[:4].T

    return solve
