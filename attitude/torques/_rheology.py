"""`Rheology`: the friction of a homogeneous ellipsoid of a linear material, from its free rotation.

The forces of inertia on the matter of a tumbling body are -density B r, with the matrix
B = w w^T - w^2 + [w' x]: linear in the place r.  A homogeneous ellipsoid answers with a
displacement that is a polynomial of third degree (Chree 1895), so that Ritz' method with odd
polynomials up to this degree is exact.  The stored energy is a quadratic form of B, made once a
shape; each harmonic of the nutation loses a share of it that the compliance at its frequency gives.
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from attitude._support import validation
from attitude._support.arrays import Immutable, frozen
from attitude.errors import AttitudeError
from attitude.motions._body import Body
from attitude.torques._schemes import ascending

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import ArrayLike, NDArray

    from attitude._support.annotations import FloatArray, Real, Reals

    Compliance: TypeAlias = Callable[[FloatArray], NDArray[Any]]

# m3/(kg s2): CODATA 2018
_GRAVITATION = 6.67430e-11


# ---- Laws of materials: the complex compliance J(frequency), 1/Pa, of negative imaginary part


@dataclass(frozen=True)
class QualityFactor:
    """Loss of a fixed share: J = (1 - i/Q) / rigidity at all frequencies.

    Parameters
    ----------
    rigidity : float
        Pa.
    quality : float
        Q, a pure number.

    Notes
    -----
    Only the product matters where self-gravity is weak; 5e12 Pa for rubble (Harris 1994).
    """

    rigidity: float
    quality: float

    def __post_init__(self) -> None:
        for name, unit in (("rigidity", "Pa"), ("quality", None)):
            value = validation.positive(getattr(self, name), name, unit=unit)
            object.__setattr__(self, name, value)

    def __call__(self, frequency: FloatArray) -> NDArray[Any]:
        """J (...) in 1/Pa at angular frequencies (...) in rad/s."""
        return np.full(np.shape(frequency), (1.0 - 1j / self.quality) / self.rigidity)


@dataclass(frozen=True)
class Maxwell:
    """A spring and a dashpot one after the other: J = 1/rigidity - i/(viscosity frequency).

    Parameters
    ----------
    rigidity : float
        Pa.
    viscosity : float
        Pa s.
    """

    rigidity: float
    viscosity: float

    def __post_init__(self) -> None:
        for name, unit in (("rigidity", "Pa"), ("viscosity", "Pa s")):
            value = validation.positive(getattr(self, name), name, unit=unit)
            object.__setattr__(self, name, value)

    def __call__(self, frequency: FloatArray) -> NDArray[Any]:
        """J (...) in 1/Pa at angular frequencies (...) in rad/s."""
        return 1.0 / self.rigidity - 1j / (self.viscosity * np.asarray(frequency))


# ---- The elastic answer of an ellipsoid

# Exponents of the monomials of odd degree up to three, and of even degree up to two.
_ODD = [e for e in itertools.product(range(4), repeat=3) if sum(e) in (1, 3)]
_EVEN = [e for e in itertools.product(range(3), repeat=3) if sum(e) in (0, 2)]


def _integral(axes: FloatArray, powers: ArrayLike) -> float:
    """Integral of x^p y^q z^r over an ellipsoid, for powers (p, q, r)."""
    p = [int(k) for k in np.asarray(powers)]
    if any(k % 2 for k in p):
        return 0.0
    half = [math.gamma(0.5 * (k + 1)) for k in p]
    size = math.prod(float(a) ** (k + 1) for a, k in zip(axes, p, strict=True))
    return size * math.prod(half) / math.gamma(0.5 * (sum(p) + 5))


def _derivative(exponents: tuple[int, ...], k: int) -> tuple[int, tuple[int, ...]]:
    """Factor and exponents of the derivative of a monomial by coordinate k."""
    lower = tuple(x - (i == k) for i, x in enumerate(exponents))
    return exponents[k], lower


def _stiffness(axes: FloatArray, first: float) -> tuple[FloatArray, FloatArray]:
    """Stiffness (39, 39) and load (39, 9) of B; first: Lame's first parameter over the rigidity."""
    count = len(_ODD)
    slopes = np.zeros((count, count, 3, 3))
    for i, one in enumerate(_ODD):
        for j, two in enumerate(_ODD):
            for k, m in itertools.product(range(3), repeat=2):
                (a, left), (b, right) = _derivative(one, k), _derivative(two, m)
                if a and b:
                    slopes[i, j, k, m] = a * b * _integral(axes, np.add(left, right))
    stiffness = np.zeros((count, 3, count, 3))
    for p, q in itertools.product(range(3), repeat=2):
        stiffness[:, p, :, q] = first * slopes[:, :, p, q] + slopes[:, :, q, p]
        if p == q:
            stiffness[:, p, :, q] += np.einsum("ijkk->ij", slopes)
    load = np.zeros((count, 3, 3, 3))
    for i, one in enumerate(_ODD):
        for k in range(3):
            value = _integral(axes, np.add(one, np.eye(3, dtype=int)[k]))
            load[i, range(3), range(3), k] = -value
    return stiffness.reshape(3 * count, 3 * count), load.reshape(3 * count, 9)


def _without_divergence() -> FloatArray:
    """A basis (39, N) of the displacements of third degree that keep the density."""
    divergence = np.zeros((len(_EVEN), len(_ODD), 3))
    for i, one in enumerate(_ODD):
        for k in range(3):
            factor, lower = _derivative(one, k)
            if factor:
                divergence[_EVEN.index(lower), i, k] = factor
    _, sizes, basis = np.linalg.svd(divergence.reshape(len(_EVEN), -1))
    return basis[np.count_nonzero(sizes > 1e-12) :].T


def displacement(axes: FloatArray, poisson: float) -> FloatArray:
    """Displacements (39, 9) for unit density, rigidity and entries of B; rows (monomial, axis)."""
    kept = poisson < 0.5
    stiffness, load = _stiffness(axes, 2.0 * poisson / (1.0 - 2.0 * poisson) if kept else 0.0)
    basis = np.eye(len(load)) if kept else _without_divergence()
    # turns of the whole body are free
    inverse = np.linalg.pinv(basis.T @ stiffness @ basis, rcond=1e-11, hermitian=True)
    return basis @ (inverse @ (basis.T @ load))


# ---- The polhode over one nutation


def polhodes(
    moments: FloatArray, share: FloatArray, one_minus_share: FloatArray, long: bool
) -> tuple[FloatArray, FloatArray]:
    """Nutations with L = 1 at shares (N,) of sin^2 theta from an axis to the separatrix.

    The axis is the short or the long one; one_minus_share is without cancellation.  Returns unit
    vectors (N, M, 3) of the momentum over the principal axes, ascending, at nodes that are uniform
    in time, and 2 pi over the period (N,).
    """
    from scipy.special import ellipj, ellipkm1

    low, middle, high = moments
    whole = (high - low) / (low * high)
    above, below = (high - middle) / (high * middle), (middle - low) / (low * middle)
    narrow = below if long else above
    reach = narrow / whole  # sin^2 of the separatrix, from the axis
    sine = share * reach  # sin^2 of the angle from the axis
    cosine = one_minus_share + share * (1.0 - reach)
    # 1 - m: D (reach - sine) over (narrow cos^2)
    complement = np.minimum(whole * reach * one_minus_share / (narrow * cosine), 1.0)
    quarter = ellipkm1(complement)
    u = 4.0 * quarter[:, None] * (np.arange(_NODES) + 0.5) / _NODES
    turns = np.rint(u / (2.0 * quarter[:, None]))
    sn, cn, dn, _ = ellipj(u - 2.0 * quarter[:, None] * turns, (1.0 - complement)[:, None])
    sign = 1.0 - 2.0 * np.mod(turns, 2.0)
    across = np.sqrt(sine)[:, None] * sign * cn
    along = np.sqrt(cosine)[:, None] * dn
    third = np.sqrt(np.minimum(share, 1.0))[:, None] * sign * sn
    order = (along, third, across) if long else (across, third, along)
    # the speed of u: sqrt(cos^2 D narrow)
    rate = 0.5 * np.pi * np.sqrt(cosine * whole * narrow) / quarter
    return np.stack(order, axis=-1), rate


# Nodes of a nutation: harmonics of the force to 1e-9 of the largest where 1 - m is 1e-10.
_NODES = 256


# ---- The rheology of a body

# Table of strengths: the least logarithm of share/rest, the greatest, and the spacing.
_FIRST = -24.0
_LAST = 23.0
_SPACING = 0.1
# The least L/C, rad/s, the greatest, and the spacing of its logarithm.
_SLOWEST = 1e-11
_FASTEST = 1e2
_RATE_SPACING = 0.5
_SHARES = _FIRST + _SPACING * np.arange(round((_LAST - _FIRST) / _SPACING) + 1.0)
_INTERVALS = math.ceil(math.log(_FASTEST / _SLOWEST) / _RATE_SPACING)
_RATES = _SLOWEST * np.exp(_RATE_SPACING * np.arange(_INTERVALS + 1))


@dataclass(frozen=True, eq=False, init=False)
class Rheology(Immutable):
    """A homogeneous ellipsoid of a linear material, whose friction follows from its tumbling.

    Parameters
    ----------
    axes : (3,) array_like
        Semi-axes, m, in any order: the longest lies along the axis of the least moment.
    density : float or Quantity
        kg/m3.
    compliance : QualityFactor, Maxwell, or function
        The law of the material.  A function of angular frequencies (...) in rad/s returns the
        complex compliance (...) in 1/Pa, of negative imaginary part where energy is lost.
    poisson : float
        Poisson's ratio, from 0 to 0.5 (no change of volume).

    Attributes
    ----------
    axes : (3,) array
        Longest first.

    Raises
    ------
    AttitudeError
        For numbers that are not positive, other shapes and units; from a motion, for a compliance
        that is not finite or would add energy.

    Notes
    -----
    The displacement is exact (Chree 1895, Quart. J. Pure Appl. Math. 27, 338), for any tumbling and
    triaxial shape.  Mean power over a nutation: 2 rho^2 sum n W (-Im J(n W)) b_n* G b_n, with b_n
    the Fourier coefficients of w w^T - w^2 + [w' x] and W = 2 pi / P_psi.  Self-gravity resists as
    in a sphere of the same volume, J / (1 + (2/19) rho g R J): exact for a sphere (its Love number
    is then 3/2 / (1 + 19/(2 J rho g R))), an estimate for others, negligible for stiff bodies.

    >>> rubble = Rheology((600, 400, 300), 2000, QualityFactor(5e9, 1000))
    >>> rubble.axes
    array([600., 400., 300.])
    """

    axes: FloatArray
    density: float
    compliance: Compliance
    poisson: float

    def __init__(
        self, axes: Reals, density: Real, compliance: Compliance, poisson: Real = 0.5
    ) -> None:
        sizes = validation.real(axes, "axes", shape=(3,), unit="m")
        if np.min(sizes) <= 0.0:
            raise AttitudeError(f"axes is {sizes.tolist()}; give semi-axes above zero, in m.")
        self._set("axes", frozen(np.sort(sizes)[::-1].copy()))
        self._set("density", validation.positive(density, "density", unit="kg/m3"))
        validation.refuse_class(compliance, "compliance")
        if not callable(compliance):
            raise AttitudeError(
                f"compliance is {validation.shown(compliance)}; give QualityFactor(rigidity, Q), "
                "Maxwell(rigidity, viscosity), or a function of angular frequencies in rad/s that "
                "returns the complex compliance in 1/Pa."
            )
        self._set("compliance", compliance)
        number = validation.number(poisson, "poisson")
        if not 0.0 <= number <= 0.5:
            raise AttitudeError(f"poisson is {number!r}; give a ratio from 0 to 0.5.")
        self._set("poisson", number)

    @cached_property
    def _form(self) -> FloatArray:
        """G (9, 9), m7: the stored energy is 1/2 rho^2 J B G B."""
        radius = float(np.cbrt(np.prod(self.axes)))
        axes = self.axes / radius
        _, load = _stiffness(axes, 0.0)
        return radius**7 * (load.T @ displacement(axes, self.poisson))

    def loss(self, frequency: ArrayLike) -> FloatArray:
        """-Im J (...) in 1/Pa, with self-gravity, at angular frequencies (...) in rad/s."""
        rate = validation.real(frequency, "frequency", unit="rad/s")
        compliance = np.asarray(self.compliance(rate), dtype=np.complex128)
        radius = float(np.cbrt(np.prod(self.axes)))
        # rho g R of a sphere
        weight = 4.0 * np.pi / 3.0 * _GRAVITATION * (self.density * radius) ** 2
        losses: FloatArray = -np.imag(compliance / (1.0 + 2.0 / 19.0 * weight * compliance))
        if losses.shape != rate.shape or not np.all(np.isfinite(losses)) or np.any(losses < 0.0):
            raise AttitudeError(
                f"compliance returned {validation.shown(compliance)}; it must return finite "
                "complex numbers (...) in 1/Pa, whose imaginary part is not positive, for angular "
                "frequencies (...) in rad/s."
            )
        return losses

    def power(self, body: Body, momentum: Real, sine_squared: Real) -> float:
        """Mean power, W, that friction takes from a free rotation.

        Parameters
        ----------
        body : Body
            With moments in kg m2; the ellipsoid's own if they are relative.
        momentum : float
            |L| in kg m2/s, the body's own unit in `strength_at`.
        sine_squared : float
            (2 T/L^2 - 1/C) / (1/A - 1/C) from 0, rotation about the short axis, to 1, about the
            long one, with the kinetic energy T and the moments A <= B <= C.
        """
        moments = self.moments(body)
        size = validation.positive(momentum, "momentum", unit="kg m2/s")
        p = validation.number(sine_squared, "sine_squared")
        if not 0.0 <= p <= 1.0:
            raise AttitudeError(f"sine_squared is {p!r}; give a number from 0 to 1.")
        edge = _separatrix(moments)
        long = p > edge
        share = (1.0 - p) / (1.0 - edge) if long else p / edge
        direction, pace = polhodes(moments, np.array([share]), np.array([1.0 - share]), long)
        energy, _ = self._harmonics(moments, direction)
        rate = size * pace[0] * np.arange(1, energy.shape[1] + 1)
        scale = 2.0 * self.density**2 * size**4
        return float(scale * np.sum(rate * self.loss(rate) * energy[0]))

    def strength_at(self, body: Body, momentum: ArrayLike, sine_squared: ArrayLike) -> FloatArray:
        """The strength (...) of `InternalDissipation` with this mean power.

        Parameters
        ----------
        body, momentum, sine_squared
            As for `power`, arrays (...).
        """
        from scipy.interpolate import RectBivariateSpline

        moments = self.moments(body)
        momentum, p = np.broadcast_arrays(
            validation.real(momentum, "momentum"), validation.real(sine_squared, "sine_squared")
        )
        if not (np.all(momentum > 0.0) and np.all((p >= 0.0) & (p <= 1.0))):
            raise AttitudeError(
                f"momentum is {validation.shown(momentum)}, sine_squared {validation.shown(p)}; "
                "give momenta above zero, and numbers from 0 to 1."
            )
        edge, strengths = _separatrix(moments), np.empty(p.shape)
        for long, table in zip((False, True), self.strengths(body), strict=True):
            on = (p > edge) == long
            if not np.any(on) or not np.all(np.isfinite(table)):
                strengths[on] = 0.0
                continue
            spline = RectBivariateSpline(np.log(_RATES), _SHARES, table)
            share, margin = (1.0 - p[on], p[on] - edge) if long else (p[on], edge - p[on])
            with np.errstate(divide="ignore"):
                logarithm = np.clip(np.log(share) - np.log(margin), _FIRST, _LAST)
            speed = momentum[on] / float(np.max(body.moments))
            rate = np.clip(np.log(speed), *np.log(_RATES[[0, -1]]))
            strengths[on] = np.exp(spline.ev(rate, logarithm))
        return strengths

    def moments(self, body: Body) -> FloatArray:
        """Principal moments (3,) of a body in kg m2, ascending.

        Relative moments are scaled to the largest of the ellipsoid.
        """
        validation.instance(body, Body, "body", "a Body")
        moments = np.sort(np.asarray(body.moments, dtype=np.float64))
        if not body.relative:
            return moments
        mass = 4.0 / 3.0 * np.pi * self.density * float(np.prod(self.axes))
        return moments * (mass / 5.0 * float(self.axes[0] ** 2 + self.axes[1] ** 2) / moments[2])

    def _harmonics(self, moments: FloatArray, l: FloatArray) -> tuple[FloatArray, FloatArray]:
        """b_n* G b_n (N, harmonics from 1) and the means (N,) of |l x w|^2, for L = 1."""
        w = l / moments
        change = np.cross(l, w) / moments  # Euler's equations
        matrix = w[..., :, None] * w[..., None, :] - np.sum(w * w, -1)[..., None, None] * np.eye(3)
        i, j = [1, 2, 0], [2, 0, 1]
        matrix[..., i, j] -= change  # [w' x]
        matrix[..., j, i] += change
        waves = np.fft.rfft(matrix.reshape(*matrix.shape[:2], 9), axis=1)[:, 1:-1] / _NODES
        energy = np.einsum("nki,ij,nkj->nk", waves.conj(), self._form, waves).real
        across = np.cross(l, w)
        return energy, np.mean(np.sum(across * across, axis=-1), axis=1)

    def strengths(self, body: Body) -> FloatArray:
        """Logarithms (2, rates, shares) of the strength of `InternalDissipation`.

        First axis: from the short, from the long axis.  The others: `_RATES`, `_SHARES`.
        """
        moments = self.moments(body)
        key = moments.tobytes()
        if key not in self._tables:
            self._tables[key] = frozen(self._strengths(moments))
        return self._tables[key]

    @cached_property
    def _tables(self) -> dict[bytes, FloatArray]:
        """`strengths` by the moments of bodies: members of an ensemble share them."""
        return {}

    def _strengths(self, moments: FloatArray) -> FloatArray:
        """`strengths` for ascending moments, kg m2."""
        if moments[2] - moments[0] <= 1e-14 * moments[2]:
            return np.full((2, len(_RATES), len(_SHARES)), -np.inf)
        share, margin = 1.0 / (1.0 + np.exp(-_SHARES)), 1.0 / (1.0 + np.exp(_SHARES))
        edge, tables = _separatrix(moments), []
        for long in (False, True):
            reach = 1.0 - edge if long else edge
            if reach <= 0.0:  # a symmetric body has no such motion
                tables.append(np.full((len(_RATES), len(share)), -np.inf))
                continue
            direction, pace = polhodes(moments, share, margin, long)
            energy, across = self._harmonics(moments, direction)
            momentum = _RATES * moments[2]
            harmonics = np.arange(1, energy.shape[1] + 1)
            power = np.empty((len(_RATES), len(share)))
            for row, size in zip(power, momentum, strict=True):
                frequency = size * pace[:, None] * harmonics
                row[:] = np.sum(frequency * self.loss(frequency) * energy, axis=1)
            scale = 2.0 * self.density**2 * momentum[:, None]
            with np.errstate(divide="ignore"):
                tables.append(np.log(scale * power / across))
        return np.array(tables)


def _separatrix(moments: FloatArray) -> float:
    """sin^2 theta of the separatrix."""
    low, middle, high = moments
    if high == low:
        return 1.0
    return float(low * (high - middle) / (middle * (high - low)))


def parameters(rheology: Rheology, body: Body) -> FloatArray:
    """What `_compiled.rheological_dissipation` takes."""
    _, axes = ascending(body)
    table = rheology.strengths(body)
    unit = np.sort(np.asarray(body.moments))
    first = [math.log(_SLOWEST), 1.0 / _RATE_SPACING, table.shape[1]]
    second = [_FIRST, 1.0 / _SPACING, table.shape[2]]
    return np.concatenate([unit, axes.T.reshape(9), first, second, np.ravel(table)])
