"""The free rotation in five numbers, the normal form of docs/derivation.md (section 15).

With E = exp(i (nutation_rate t + phase)), s = rho^4 and the precession exp(i precession_rate t),
the attitude of the body over axes with z along the momentum is the pair of polynomials

    A = 1 + sum (-1)^n s^(n^2) (X^(2n^2+n) E^(2n) + X^(2n^2-n) E^-(2n)),                    n >= 1
    b = -i rho sum (-1)^n s^(n^2+n) (X^(2n^2+n) E^-(2n+1) - X^(2n^2+3n+1) E^(2n+1)),        n >= 0
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from attitude._solver import codes, evaluation
from attitude.errors import AttitudeError

if TYPE_CHECKING:
    from collections.abc import Callable

    from attitude._support.annotations import FloatArray


# Ratios of moments at which a solution is sought.
_GRID = 2000
# Share of the precession rate by which rounding may move the elements of a lamina off all bodies.
_ROUNDED = 1e-11
_TERMS = 12


class Elements(NamedTuple):
    """The normal form of a free rotation.

    Attributes
    ----------
    precession_rate : float
        rad/s: half of the mean rate of phi + psi, the angles about the momentum and about the axis
        about which the momentum circulates.
    nutation_rate : float
        rad/s, the mean rate of psi: positive in long-axis, negative in short-axis mode.  0 on the
        separatrix.
    phase : float
        rad, of the nutation at the epoch; motions whose phases differ by pi differ by the names of
        two axes alone.
    rho : float
        Amplitude of the nutation: the tangent of half the tilt of a symmetric body; 0 for rotation
        about an axis (its phase is then 0, its X that of a vanishing nutation), 1 on the
        separatrix.
    X : float
        Ellipticity of the nutation, 0 (a symmetric body) to 1 (the separatrix).
    """

    precession_rate: float
    nutation_rate: float
    phase: float
    rho: float
    X: float


def elements_of(c: Any) -> Elements:
    """The elements of a record of `records.CONSTANTS`."""
    if c["form"] == codes.UNIFORM:
        return _of_uniform(c)
    precession = 2.0 * math.pi * float(c["precession"][0])
    rate, phase = float(c["nutation"][0]), float(c["nutation0"][0])
    if c["form"] == codes.HYPERBOLIC:
        if c["winds"] == 0.0:
            return Elements(precession, 0.0, 0.0, 1.0, 1.0)
        rate, phase = 0.5 * rate, 0.5 * phase
    if c["stretch"] < math.inf:
        delta = 0.25 * math.pi * float(c["stretch"] * c["fraction"])
        x = math.exp(-2.0 * delta)
        rho = math.exp(delta - 0.25 * math.pi * float(c["stretch"]))
    else:
        x, rho = 0.0, 0.0
    if c["form"] == codes.TRIGONOMETRIC and rho < 0.5:
        # From the tilt, which keeps its digits where the nome underflows or is 0
        top, low = _sums(rho**4, x, -1.0)
        rho = float(c["wobble"]) * low / top
    turn = 2.0 * math.pi
    return Elements(precession, turn * rate, turn * phase, rho, x)


def inputs_by_elements(c: Any, by_input: FloatArray) -> FloatArray:
    """The least change (6, 5) of angular velocity and moments for a unit change of each element,
    by_input (7, 6): the inverse of the Jacobian but for the scale of the moments, which changes no
    attitude.
    """
    if c["form"] == codes.UNIFORM or (c["form"] == codes.HYPERBOLIC and c["winds"] == 0.0):
        raise AttitudeError(
            "the motion has no derivatives by its elements: in uniform rotation and on the "
            'separatrix they do not follow from the state. Take by="state".'
        )
    rho, x = elements_of(c)[3:]
    if c["form"] == codes.TRIGONOMETRIC:
        jacobian = by_input[:5].copy()
        jacobian[0] *= 0.5
        jacobian[3] *= rho
    else:
        jacobian = _of_hyperbolic(c, by_input, rho, x)
    # Rates and moments have different scales: the scale of the moments is the null space.
    size = np.abs(jacobian).max(axis=0)
    size[size == 0.0] = 1.0
    return np.linalg.pinv(jacobian / size) / size[:, None]


def _of_hyperbolic(c, h, rho, x):
    """The Jacobian of the elements from that of the elements near the separatrix."""
    stretch, nutation = float(c["stretch"]), float(c["nutation"][0])
    d, quarter = 0.25 * math.pi * float(c["fraction"]), float(c["quarter"][0])
    other = 0.5 * stretch * quarter  # K'
    d_quarter = h[6] * 2.0 * other / math.pi
    by_quarter = d_quarter / quarter
    rate = math.pi * nutation  # 2 pi f
    d_rate = 2.0 * other / quarter * h[1] - rate * by_quarter
    phase = math.pi * float(c["nutation0"][0])
    d_phase = 2.0 * other / quarter * h[2] - phase * by_quarter
    # lambda = lambda' + 4 d f
    d_precession = 0.5 * h[0] + 2.0 / math.pi * (rate * h[4] + d * d_rate)
    ratio = 0.5 * stretch  # K'/K
    d_ratio = ratio * (h[3] - by_quarter)
    d_log_rho = (2.0 * d - 0.5 * math.pi) * d_ratio + 2.0 * ratio * h[4]
    d_x = -4.0 * x * (d * d_ratio + ratio * h[4])
    return np.stack([d_precession, d_rate, d_phase, rho * d_log_rho, d_x])


def _of_uniform(c: Any) -> Elements:
    axis = int(c["circulates"])
    if axis < 0:
        raise AttitudeError(
            "the motion has no elements: at rest, of a sphere, about the middle axis, or about the "
            "equator of a symmetric body no nutation is defined."
        )
    axial = float(c["moments"][axis, 0])
    others = [float(c["moments"][k, 0]) for k in range(3) if k != axis]
    first = max(others, key=lambda moment: abs(moment - axial))
    second = min(others, key=lambda moment: abs(moment - axial))
    root = math.sqrt(1.0 + axial / first * abs((first - second) / (second - axial)))
    return Elements(
        precession_rate=2.0 * math.pi * float(c["precession"][0]),
        nutation_rate=2.0 * math.pi * float(c["psi_rate"]),
        phase=0.0,
        rho=0.0,
        X=(root - 1.0) / (root + 1.0),
    )


def _sums(s: float, x: float, sign: float) -> tuple[float, float]:
    """Sums whose quotient times rho is the tangent of half the tilt, at v = 0 (-1) or pi/2 (1)."""
    top = low = 0.0
    for n in range(_TERMS):
        factor = sign**n
        top += factor * s ** (n * n + n) * x ** (2 * n * n + n) * (1.0 + sign * x ** (2 * n + 1))
        if n > 0:
            low += factor * s ** (n * n) * x ** (2 * n * n - n) * (1.0 + x ** (2 * n))
    return top, 1.0 + low


def state_of(elements: Elements) -> tuple[FloatArray, FloatArray]:
    """Moments (3,), the greatest being 1, and angular velocity (3,) at the epoch, over the
    principal axes in the order of the solution: the momentum circulates about the third, the second
    is the middle one.
    """
    from scipy.special import ellipj, ellipk

    _check(elements)
    rho, x = elements.rho, elements.X
    low_tilt, high_tilt, rise = _tilts(rho, x)
    l0 = (1.0 - low_tilt**2) / (1.0 + low_tilt**2)
    drop = 2.0 * rise * (low_tilt + high_tilt) / ((1.0 + low_tilt**2) * (1.0 + high_tilt**2))
    m = drop * (2.0 * l0 - drop) / l0**2
    minus_n = m * l0**2 / (4.0 * low_tilt**2 / (1.0 + low_tilt**2) ** 2)
    quarter = float(ellipk(m))
    long_axis = elements.nutation_rate > 0.0

    def states(r: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Moments and rates (N, 3) of ratios of the third to the first moment."""
        split = minus_n / r  # d12/d23
        d13 = np.abs(1.0 - r)
        d12, d23 = d13 * split / (1.0 + split), d13 / (1.0 + split)
        second = 1.0 - d12 if long_axis else 1.0 + d12
        moments = np.stack([np.ones_like(r), second, r], axis=-1)
        speed = 2.0 * quarter * abs(elements.nutation_rate) / math.pi
        a1 = speed**2 * second * r / d23
        a3 = a1 * r * (1.0 - l0**2) / l0**2
        sn, cn, dn, _ = ellipj(2.0 * quarter * elements.phase / math.pi, m)
        w1, w2 = np.sqrt(a3 / d13) * cn, -np.sqrt(a3 / (second * d23)) * sn
        return moments, np.stack([w1, w2, np.sqrt(a1 / (r * d13)) * dn], axis=-1)

    def excess(r: FloatArray) -> FloatArray:
        moments, omega = states(np.atleast_1d(r))
        pairs = np.zeros((2, len(moments), 3, 2))
        pairs[0, ..., 0], pairs[1, ..., 0] = moments, omega
        wxyz = np.tile([1.0, 0.0, 0.0, 0.0], (len(moments), 1))
        constants, faults = evaluation.prepared(pairs[0], wxyz, pairs[1], wxyz[:1], rates=False)
        if faults:
            k = int(np.argmax(constants["fault"] != 0))
            raise AttitudeError(
                evaluation.fault_of(constants[k], pairs[0, k], wxyz[k], pairs[1, k])
            )
        return 2.0 * math.pi * constants["precession"][:, 0] - elements.precession_rate

    # needles and laminas: the ratio is found to its digits wherever it lies
    u = 0.5 * (1.0 + np.tanh(np.linspace(-18.0, 18.0, _GRID)))
    r = np.unique(u[(u > 0.0) & (u < 1.0)])
    r = r if long_axis else 1.0 / r[::-1]
    r = _of_bodies(lambda ratios: states(ratios)[0], r)
    ratio = _root(excess, r, abs(elements.precession_rate)) if len(r) else None
    if ratio is None:
        raise AttitudeError(
            f"no body has {elements}: no moments that satisfy the triangle inequality precess at "
            "this rate with this nutation. Change precession_rate or nutation_rate."
        )
    moments, omega = (state[0] for state in states(np.array([ratio])))
    return moments / moments.max(), omega


def _of_bodies(moments_of: Callable[[FloatArray], FloatArray], r: FloatArray) -> FloatArray:
    """Ratios of a grid whose moments satisfy the triangle inequality, and those of its laminas."""

    def slack(ratios: FloatArray) -> FloatArray:
        moments = moments_of(ratios)
        return moments.sum(axis=1) - 2.0 * moments.max(axis=1)

    inside = slack(r) >= 0.0
    edges = []
    for k in np.flatnonzero(inside[:-1] != inside[1:]):
        body, none = (r[k], r[k + 1]) if inside[k] else (r[k + 1], r[k])
        middle = 0.5 * (body + none)
        while middle not in (body, none):
            if slack(np.array([middle]))[0] >= 0.0:
                body = middle
            else:
                none = middle
            middle = 0.5 * (body + none)
        edges.append(body)
    return np.unique(np.concatenate([r[inside], edges]))


def _root(excess: Any, r: FloatArray, rate: float) -> float | None:
    """The ratio at which the precession has its rate, within the range of ratios of bodies."""
    from scipy.optimize import brentq

    values = excess(r)
    cross = np.flatnonzero(np.sign(values[:-1]) * np.sign(values[1:]) <= 0.0)
    if len(cross) == 0:
        nearest = int(np.argmin(np.abs(values)))
        return float(r[nearest]) if abs(values[nearest]) <= _ROUNDED * rate else None
    k = int(cross[0])
    root = brentq(
        lambda x: float(excess(np.array([x]))[0]), r[k], r[k + 1], xtol=1e-300, rtol=1e-15
    )
    return float(root)


def _tilts(rho: float, x: float) -> tuple[float, float, float]:
    """Tangents of half the least and the greatest tilt, and their difference without loss."""
    even = {"top": 0.0, "low": 1.0}
    odd = {"top": 0.0, "low": 0.0}
    s = rho**4
    for n in range(_TERMS):
        series, other = (even, odd) if n % 2 == 0 else (odd, even)
        y = s ** (n * n + n) * x ** (2 * n * n + n)
        series["top"] += y
        other["top"] += y * x ** (2 * n + 1)
        if n > 0:
            series["low"] += s ** (n * n) * x ** (2 * n * n - n) * (1.0 + x ** (2 * n))
    least = even["low"] - odd["low"], even["low"] + odd["low"]
    low = rho * (even["top"] - odd["top"]) / least[0]
    high = rho * (even["top"] + odd["top"]) / least[1]
    rise = odd["top"] * even["low"] - even["top"] * odd["low"]
    return low, high, 2.0 * rho * rise / (least[0] * least[1])


def _check(elements: Elements) -> None:
    values = np.array(elements, dtype=float)
    if values.shape != (5,) or not np.all(np.isfinite(values)):
        raise AttitudeError(f"elements are {elements}; give five finite numbers.")
    if elements.nutation_rate == 0.0:
        raise AttitudeError(
            "nutation_rate is 0, as on the separatrix; no one body follows from it. Give the "
            "moments and the angular velocity."
        )
    if not 0.0 < elements.rho < 1.0 or not 0.0 <= elements.X < 1.0:
        raise AttitudeError(
            f"rho is {elements.rho:.6g} and X is {elements.X:.6g}; rho lies between 0 and 1 "
            "(exclusive; without nutation no ratios of moments follow), X from 0 to 1."
        )
