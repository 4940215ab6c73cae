"""The classical geometric integrator: Dullweber, Leimkuhler & McLachlan, J. Chem. Phys. 107, 5840
(1997): symmetric splitting of the free rigid body into rotations about its three principal axes.

Compiled.  Steps of a fixed length, the last one before an epoch shortened to it.
"""

import numba
import numpy as np

from benchmarks.peers import Peer


def peers():
    return [
        Peer("splitting (DLM)", f"{steps} steps/rev", _solver(steps), reach)
        for steps, reach in ((30, 1e6), (300, 2e3), (3000, 2e3))
    ]


def _solver(steps):
    def solve(moments, wxyz0, omega0, t):
        h = 2.0 * np.pi / np.linalg.norm(omega0) / steps
        wxyz0 = np.asarray(wxyz0, float) / np.linalg.norm(wxyz0)
        return _integrate(np.asarray(moments, float), wxyz0, np.asarray(omega0, float), t, h)

    return solve


@numba.njit(cache=True)
def _integrate(moments, wxyz0, omega0, t, h):
    q, momentum = wxyz0.copy(), moments * omega0
    out = np.empty((len(t), 4))
    now = 0.0
    for i in range(len(t)):
        count = int(np.ceil((t[i] - now) / h - 1e-9))
        step = (t[i] - now) / max(count, 1)
        for _ in range(count):
            _turn(q, momentum, moments, 0, 0.5 * step)
            _turn(q, momentum, moments, 1, 0.5 * step)
            _turn(q, momentum, moments, 2, step)
            _turn(q, momentum, moments, 1, 0.5 * step)
            _turn(q, momentum, moments, 0, 0.5 * step)
        now = t[i]
        out[i] = q
    return out


@numba.njit(cache=True, inline="always")
def _turn(q, momentum, moments, axis, h):
    """Free rotation with the energy L_axis^2 / 2 I_axis alone."""
    i, j = (axis + 1) % 3, (axis + 2) % 3
    angle = h * momentum[axis] / moments[axis]
    c, s = np.cos(angle), np.sin(angle)
    momentum[i], momentum[j] = c * momentum[i] + s * momentum[j], c * momentum[j] - s * momentum[i]
    c, s = np.cos(0.5 * angle), np.sin(0.5 * angle)
    w, a, b, d = q[0], q[1 + axis], q[1 + i], q[1 + j]
    q[0], q[1 + axis] = c * w - s * a, c * a + s * w
    q[1 + i], q[1 + j] = c * b + s * d, c * d - s * b
