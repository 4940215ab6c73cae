"""The solution of van Zon & Schofield (2006) step by step, with the names of the paper.

For students: one motion, the numbers of section 3 and the attitude by theta functions.  The package
itself evaluates another form, without the divisions that fail for principal axes; compare both with
`FreeRotation.at`.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from attitude.errors import AttitudeError
from attitude.jacobi._jacobi import F, K, am, nome, theta

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from attitude._support.annotations import FloatArray
    from attitude.motions._free_rotation import FreeRotation


@dataclass(frozen=True, eq=False)
class PaperSteps:
    """The constants of a motion; made by `steps`.

    Attributes
    ----------
    axes : (3, 3) array
        Rows: the body axes in Jacobi order (eq. 3.32), I1 and I3 extreme, in body axes.
    moments : (3,) array
        I1, I2, I3, kg m2.
    momentum : float
        L, kg m2/s.
    amplitudes : (3,) array
        omega_1m, omega_2m, omega_3m of eqs. 3.10-3.12, rad/s.
    speed : float
        omega_p, eq. 3.13, rad/s: u = omega_p t + epsilon.
    m, q : float
        Parameter (eq. 3.15) and nome (eq. 3.46).
    quarter, other_quarter : float
        K(m) and K' = K(1 - m).
    epsilon : float
        Eq. 3.18: u at the epoch.
    eta : float
        Eq. 3.47.
    drift : float
        A_2, the mean rate of the angle psi about the momentum, rad/s (eq. 3.55).
    start : (3, 3) array
        The constant rotation that carries the momentum's axes to ICRF.
    """

    axes: FloatArray
    moments: FloatArray
    momentum: float
    amplitudes: FloatArray
    speed: float
    m: float
    q: float
    quarter: float
    other_quarter: float
    epsilon: float
    eta: float
    drift: float
    start: FloatArray

    def angular_velocity(self, seconds: ArrayLike) -> FloatArray:
        """Angular velocity (..., 3) over the axes in Jacobi order, rad/s: eq. 3.9."""
        u = self.speed * np.asarray(seconds, dtype=float) + self.epsilon
        angle = am(u, self.m)
        third = np.sqrt(1.0 - self.m * np.sin(angle) ** 2)
        return self.amplitudes * np.stack([np.cos(angle), np.sin(angle), third], axis=-1)

    def matrix(self, seconds: ArrayLike) -> FloatArray:
        """Attitude matrices (..., 3, 3), body to ICRF, at TDB seconds since the epoch."""
        matrices: FloatArray = self.start @ np.swapaxes(self._from_momentum(seconds), -1, -2)
        return matrices @ self.axes

    def _from_momentum(self, seconds: ArrayLike) -> FloatArray:
        """From axes along the momentum to axes in Jacobi order: eqs. 3.3 and 3.54."""
        t = np.asarray(seconds, dtype=float)
        one, two, three = np.moveaxis(self.angular_velocity(t) * self.moments, -1, 0)
        x = 0.5 * np.pi / self.quarter
        z = x * (self.speed * t + self.epsilon) + 1j * x * self.eta
        psi = self.drift * t + np.angle(theta(1, z, self.q))
        one, two, three = (component / self.momentum for component in (one, two, three))
        across = np.hypot(one, two)
        first = np.stack([one * three / across, two * three / across, -across], axis=-1)
        second = np.stack([-two / across, one / across, np.zeros_like(across)], axis=-1)
        c, s = np.cos(psi)[..., None], np.sin(psi)[..., None]
        third = np.stack([one, two, three], axis=-1)
        return np.stack([first * c - second * s, first * s + second * c, third], axis=-1)


def steps(motion: FreeRotation) -> PaperSteps:
    """The constants of the paper for a free rotation.

    Parameters
    ----------
    motion : FreeRotation
        Of three different moments, neither about a principal axis nor on the separatrix: the
        paper's formulas divide by zero there.

    Raises
    ------
    AttitudeError
        For such a motion.

    >>> from attitude import Body, FreeRotation, Spin
    >>> spin = Spin(epoch="2026-01-01", wxyz=(1, 0, 0, 0), angular_velocity=(1, 15, 1))
    >>> found = steps(FreeRotation(Body(moments=(10, 20, 26)), spin))
    >>> round(found.m, 8), round(found.q, 8)
    (0.99671188, 0.31263489)
    """
    axes, moments, rates = _jacobi_order(motion)
    i1, i2, i3 = moments  # doubles of numpy, which may be divided by zero
    square, twice = np.sum((moments * rates) ** 2), np.sum(moments * rates**2)
    momentum = float(np.sqrt(square))
    one, three = square - twice * i3, square - twice * i1
    with np.errstate(all="ignore"):
        a1 = np.copysign(np.sqrt(one / (i1 * (i1 - i3))), rates[0])
        a2 = -np.copysign(np.sqrt(one / (i2 * (i2 - i3))), rates[0])
        a3 = np.copysign(np.sqrt(three / (i3 * (i3 - i1))), rates[2])
        speed = np.sqrt(three * (i3 - i2) / (i1 * i2 * i3))
        speed *= np.copysign(1.0, i2 - i3) * np.copysign(1.0, rates[2])
        m = one * (i1 - i2) / (three * (i3 - i2))
    if not (0.0 < m < 1.0 and np.all(np.isfinite([a1, a2, a3, speed]))):
        raise AttitudeError(
            "the formulas of the paper divide by zero for this motion (a principal axis, equal "
            "moments, the separatrix or rest); give a tumbling one, or use FreeRotation.at."
        )
    m = float(m)
    quarter, other = float(K(m)), float(K(1.0 - m, mc=m))
    epsilon = float(F(np.arctan2(rates[1] / a2, rates[0] / a1), m))
    q = float(nome(m))
    amplitude = np.arcsin(np.clip(i3 * a3 / momentum, -1.0, 1.0))
    eta = float(np.copysign(other, i3 * a3) - F(amplitude, 1.0 - m, mc=m))
    y = 0.5j * np.pi * eta / quarter
    ratio = theta(1, y, q, derivative=True) / theta(1, y, q)
    drift = momentum / i1 + 0.5 * np.pi * speed / quarter * float((1j * ratio).real)
    bare = PaperSteps(
        axes=axes,
        moments=moments,
        momentum=momentum,
        amplitudes=np.array([a1, a2, a3]),
        speed=float(speed),
        m=m,
        q=q,
        quarter=quarter,
        other_quarter=other,
        epsilon=epsilon,
        eta=eta,
        drift=drift,
        start=np.eye(3),
    )
    start = motion.at(0.0).matrix @ axes.T @ bare._from_momentum(0.0)
    return replace(bare, start=start)


def _jacobi_order(motion: FreeRotation) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Rows of axes in Jacobi order, their moments, and the rates about them."""
    body = motion.body
    principal = np.asarray(body.principal_axes).T
    rates = principal @ motion.spin.angular_velocity
    order = np.argsort(body.moments)
    twice = np.sum(body.moments * rates**2)
    if twice > np.sum((body.moments * rates) ** 2) / body.moments[order[1]]:
        order = order[::-1]
    axes = principal[order]
    axes[2] *= np.sign(np.linalg.det(axes))
    return axes, body.moments[order], axes @ motion.spin.angular_velocity
