"""The algorithm of van Zon & Schofield (2006), section 4, as one would write it with scipy.

Their series in the nome q, Jacobi's functions by scipy.special.ellipj, everything in doubles.
Taken literally, so with its limits: principal-axis spin divides by zero.
"""

import numpy as np
from scipy.special import ellipj, ellipk, ellipkinc

from attitude.frames import quaternion
from benchmarks.peers import Peer

_SMALL = np.finfo(float).eps


def peers():
    return [Peer("paper, numpy + scipy", "double", solve)]


def solve(moments, wxyz0, omega0, t):
    """Rotation matrices, body to inertial; those that the algorithm cannot give are NaN."""
    with np.errstate(all="ignore"):
        return _solve(np.asarray(moments), np.asarray(wxyz0), np.asarray(omega0), t)


def _solve(moments, wxyz0, omega0, t):
    frame = _jacobi_frame(moments, omega0)
    i1, i2, i3 = np.abs(frame) @ moments
    w1, w2, w3 = frame @ omega0
    momentum2 = (i1 * w1) ** 2 + (i2 * w2) ** 2 + (i3 * w3) ** 2
    energy2 = i1 * w1**2 + i2 * w2**2 + i3 * w3**2
    momentum = np.sqrt(momentum2)
    # (3.10)-(3.15): amplitudes, frequency and modulus
    a1 = np.copysign(np.sqrt((momentum2 - energy2 * i3) / (i1 * (i1 - i3))), w1)
    a2 = -np.copysign(np.sqrt((momentum2 - energy2 * i3) / (i2 * (i2 - i3))), w1)
    a3 = np.copysign(np.sqrt((momentum2 - energy2 * i1) / (i3 * (i3 - i1))), w3)
    speed = np.copysign(1.0, i2 - i3) * np.copysign(
        np.sqrt((momentum2 - energy2 * i1) * (i3 - i2) / (i1 * i2 * i3)), w3
    )
    m = (momentum2 - energy2 * i3) * (i1 - i2) / ((momentum2 - energy2 * i1) * (i3 - i2))
    k, k_other = ellipk(m), ellipk(1.0 - m)
    epsilon = ellipkinc(np.arctan2(w2 / a2, w1 / a1), m)
    q = np.exp(-np.pi * k_other / k)
    # (3.47), (4.8)
    eta = np.copysign(k_other, i3 * a3) - ellipkinc(np.arcsin(i3 * a3 / momentum), 1.0 - m)
    xi = np.exp(np.pi * eta / k)
    secular = momentum / i1 + np.pi * speed / (2.0 * k) * (xi + 1.0) / (xi - 1.0)
    for n in range(1, 200):
        change = -np.pi * speed / k * q ** (2 * n) / (1.0 - q ** (2 * n)) * (xi**n - xi**-n)
        secular += change
        if not abs(change) > _SMALL * abs(secular):
            break
    count = max(1, int(np.log(_SMALL) / np.log(q)) + 1) if 0.0 < q < 1.0 else 1
    orders = 2 * np.arange(count + 1) + 1
    weights = (-1.0) ** np.arange(count + 1) * 2.0 * q ** (orders**2 / 4.0)
    real = weights * np.cosh(orders * np.pi * eta / (2.0 * k))
    imaginary = -weights * np.sinh(orders * np.pi * eta / (2.0 * k))

    def body_axes(seconds):
        """(3, 3, T): the attitude matrix up to a factor on the right, (3.3) and (3.54)."""
        sn, cn, dn, _ = ellipj(speed * seconds + epsilon, m)
        l1, l2, l3 = i1 * a1 * cn, i2 * a2 * sn, i3 * a3 * dn
        across = np.sqrt(l1**2 + l2**2)
        phases = np.multiply.outer(orders, np.pi * (speed * seconds + epsilon) / (2.0 * k))
        angle = secular * seconds - np.arctan2(imaginary @ np.cos(phases), real @ np.sin(phases))
        c, s = np.cos(angle), np.sin(angle)
        l1, l2, l3, across = l1 / momentum, l2 / momentum, l3 / momentum, across / momentum
        f = l1 * l3 / across, l2 * l3 / across, -across
        g = -l2 / across, l1 / across, np.zeros_like(across)
        return np.array(
            [[x * c - y * s, x * s + y * c, z] for x, y, z in zip(f, g, (l1, l2, l3), strict=True)]
        )

    start = quaternion.matrix(np.asarray(wxyz0) / np.linalg.norm(wxyz0)).T
    constant = body_axes(np.zeros(1))[..., 0].T @ (frame @ start)
    # body to inertial is the transpose of the paper's A = frame^T (body axes) constant
    return np.einsum("ji,jkt,kl->tli", frame, body_axes(np.asarray(t)), constant, optimize=True)


def _jacobi_frame(moments, omega):
    """Rows: the signed axes in Jacobi order (3.32), a proper rotation."""
    order = np.argsort(moments)
    energy2 = np.sum(moments * omega**2)
    if energy2 > np.sum((moments * omega) ** 2) / moments[order[1]]:
        order = order[::-1]
    frame = np.eye(3)[order]
    frame[2] *= np.linalg.det(frame)
    return frame
