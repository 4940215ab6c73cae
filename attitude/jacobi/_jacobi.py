"""Elliptic integrals, Jacobi's elliptic functions and theta functions, over arrays."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from attitude._compilation.decorators import entry_point
from attitude._solver.elliptic import (
    complete_and_phase,
    quarter_and_fraction,
    third_kind_degenerate,
)
from attitude._solver.twofloat import sqrt
from attitude._support import validation
from attitude._support.arrays import read_only
from attitude.errors import AttitudeError

if TYPE_CHECKING:
    from attitude._support.annotations import FloatArray, Reals


# The AGM is quadratic: from 1e-9 apart to the rounding of doubles.
_CLOSE = 1e-9
_MOST = 12


@entry_point
def complete(mc, first, second):
    """K and E of parameters (N,) with complements mc > 0."""
    for k in range(len(mc)):
        share, whole, _ = complete_and_phase(
            sqrt((mc[k], 0.0)), (1.0, 0.0), (0.0, 0.0), (1.0, 0.0), (0.0, 0.0)
        )
        first[k] = whole[0]
        # E = K (1 - m D/K) near m = 1: a small difference, of which the pair has the digits
        second[k] = whole[0] * ((1.0 - share[0]) - share[1] + mc[k] * share[0])


@entry_point
def third(n, mc, out):
    """Pi(n, m) for characteristics n <= 0 (N,) and complements mc > 0."""
    for k in range(len(n)):
        p = 1.0 - n[k]
        p_low = (1.0 - p) - n[k]
        ratio, whole, _ = complete_and_phase(
            sqrt((mc[k], 0.0)), (p, p_low), (1.0, 0.0), (1.0, 0.0), (0.0, 0.0)
        )
        out[k] = ratio[0] * whole[0]


@entry_point
def incomplete(cosine, sine, mc, first, second):
    """F and E of amplitudes in the first quadrant, by cosine and sine (N,)."""
    for k in range(len(mc)):
        c, s = cosine[k], sine[k]
        whole, fraction = quarter_and_fraction(math.sqrt(mc[k]), c, s)
        first[k] = whole * fraction
        m = 1.0 - mc[k]
        # DLMF 19.25.9: E = F - m s^3 R_D(c^2, 1 - m s^2, 1) / 3
        square = c * c + mc[k] * s * s
        second[k] = first[k] - m * s**3 * third_kind_degenerate(c * c, square, 1.0) / 3.0


@entry_point
def amplitude(u, mc, out):
    """am(u, m) for 0 <= u <= K (N,), by the AGM and back (DLMF 22.20(ii)).

    The arcsine of c/a sin(phi) is an arctangent, since a^2 - c^2 = b^2: at a quarter turn, which m
    near 1 reaches, an arcsine loses half of the digits.
    """
    for k in range(len(u)):
        a, b = 1.0, math.sqrt(mc[k])
        means = [a]
        halves = [0.0]
        others = [b]
        for _ in range(_MOST):
            c = 0.5 * (a - b)
            a, b = 0.5 * (a + b), math.sqrt(a * b)
            means.append(a)
            halves.append(c)
            others.append(b)
            if abs(c) <= _CLOSE * a:
                break
        phi = math.ldexp(a * u[k], len(means) - 1)
        for step in range(len(means) - 1, 0, -1):
            sine, cosine = math.sin(phi), math.cos(phi)
            cosine = math.hypot(means[step] * cosine, others[step] * sine)
            phi = 0.5 * (phi + math.atan2(halves[step] * sine, cosine))
        out[k] = phi


# ---- Elliptic integrals of the parameter m, vectorised: K, E, Pi, F, and the incomplete E


def K(m: Reals, *, mc: Reals | None = None) -> FloatArray:
    """The complete integral of the first kind, K(m), DLMF 19.2.8.

    Parameters
    ----------
    m : array_like
        Parameter k^2, 0 <= m <= 1; any shape.
    mc : array_like, optional
        1 - m, where m is so near 1 that the difference has lost digits.

    Returns
    -------
    array of that shape
        inf for m = 1.  To 4e-16, relative.

    Raises
    ------
    AttitudeError
        For a parameter outside of 0 to 1.

    >>> K([0.0, 0.5]).round(8)
    array([1.57079633, 1.85407468])
    """
    return _complete(m, mc)[0]


def E(m: Reals, *, mc: Reals | None = None) -> FloatArray:
    """The complete integral of the second kind, E(m), DLMF 19.2.8; arguments of `K`.

    To 4e-16, relative.

    >>> E([0.0, 0.5, 1.0]).round(8)
    array([1.57079633, 1.35064388, 1.        ])
    """
    return _complete(m, mc)[1]


def Pi(n: Reals, m: Reals, *, mc: Reals | None = None) -> FloatArray:
    """The complete integral of the third kind, Pi(n, m), DLMF 19.2.8, for n <= 0.

    The drift of the angle about the momentum is one of these, with a negative characteristic.

    Parameters
    ----------
    n : array_like
        Characteristic (alpha^2 of DLMF), not above 0.
    m, mc
        As in `K`, m < 1; n and m are broadcast.

    Returns
    -------
    array
        To 1e-15, relative.

    Raises
    ------
    AttitudeError
        For a parameter outside of 0 to 1, and n > 0.

    >>> float(Pi(-0.5, 0.5).round(12))
    1.487846992669
    """
    characteristic = validation.real(n, "n")
    if np.any(characteristic > 0.0):
        raise AttitudeError("n is greater than 0; give a characteristic that is not above 0.")
    characteristic, other = _broadcast(n=characteristic, m=parameters(m, mc)[1])
    out = np.full(characteristic.size, np.inf)
    kept = other.ravel() > 0.0
    third_kind = np.empty(np.count_nonzero(kept))
    third(read_only(characteristic.ravel()[kept]), read_only(other.ravel()[kept]), third_kind)
    out[kept] = third_kind
    return out.reshape(characteristic.shape)[()]


def F(phi: Reals, m: Reals, *, mc: Reals | None = None) -> FloatArray:
    """The incomplete integral of the first kind, F(phi, m), DLMF 19.2.4.

    The inverse of `am`: the time that the motion takes to an amplitude.

    Parameters
    ----------
    phi : array_like
        Amplitude, rad, of any size.
    m, mc
        As in `K`, m < 1; phi and m are broadcast.

    Returns
    -------
    array
        To 2e-15 of the larger of its size and K.

    >>> float(F(0.5, 0.5).round(12))
    0.510467135628
    """
    return _incomplete(phi, m, mc)[0]


def E_incomplete(phi: Reals, m: Reals, *, mc: Reals | None = None) -> FloatArray:
    """The incomplete integral of the second kind, E(phi, m), DLMF 19.2.5; arguments of `F`.

    To 2e-15 of its size; near m = 1, where it is F less a number of the size of K, to 3e-14.

    >>> float(E_incomplete(0.5, 0.5).round(12))
    0.489910959793
    """
    return _incomplete(phi, m, mc)[1]


def nome(m: Reals, *, mc: Reals | None = None) -> FloatArray:
    """The nome q = exp(-pi K(1 - m)/K(m)), DLMF 22.2.1; arguments of `K`.

    >>> float(nome(0.5).round(12))
    0.043213918264
    """
    parameter, other = parameters(m, mc)
    with np.errstate(divide="ignore"):
        ratio = K(other, mc=parameter) / K(parameter, mc=other)
    return np.exp(-np.pi * ratio)


def parameters(m: Reals, mc: Reals | None) -> tuple[FloatArray, FloatArray]:
    """m and 1 - m as arrays of one shape, checked."""
    param = validation.real(m, "m")
    other = 1.0 - param if mc is None else validation.real(mc, "mc")
    param, other = _broadcast(m=param, mc=other)
    if np.any(~((param >= 0.0) & (param <= 1.0))) or np.any(~((other >= 0.0) & (other <= 1.0))):
        raise AttitudeError("m, or mc = 1 - m, is outside of 0 to 1; give the parameter m = k^2.")
    if np.any(np.abs((param + other) - 1.0) > 1e-12):
        raise AttitudeError("m + mc is not 1; give mc = 1 - m, or leave it out.")
    return param, other


def _broadcast(**arrays: FloatArray) -> tuple[FloatArray, ...]:
    """Copies of arrays in the shape to which they broadcast."""
    return tuple(np.array(array) for array in validation.together(**arrays))


def _not_one(value: Reals, name: str, m: Reals, mc: Reals | None) -> tuple[FloatArray, ...]:
    """An argument in rad, m and 1 - m as arrays of one shape; AttitudeError for m = 1."""
    parameter, other = parameters(m, mc)
    if np.any(other == 0.0):
        raise AttitudeError("m is 1, where F and am are elementary; give m < 1, or mc > 0.")
    argument = validation.real(value, name, unit="rad")
    return _broadcast(**{name: argument, "m": parameter, "mc": other})


def _complete(m: Reals, mc: Reals | None) -> tuple[Any, Any]:
    parameter, other = parameters(m, mc)
    first, second = np.full(parameter.size, np.inf), np.ones(parameter.size)
    kept = other.ravel() > 0.0
    complementary = other.ravel()[kept]
    first_kind, second_kind = np.empty(complementary.size), np.empty(complementary.size)
    complete(read_only(complementary), first_kind, second_kind)
    first[kept], second[kept] = first_kind, second_kind
    return first.reshape(parameter.shape)[()], second.reshape(parameter.shape)[()]


def _incomplete(phi: Reals, m: Reals, mc: Reals | None) -> tuple[Any, Any]:
    """F and E of any amplitude: whole half turns add 2 K and 2 E, the rest is odd."""
    angle, parameter, other = _not_one(phi, "phi", m, mc)
    turns = np.rint(angle / np.pi)
    remainder = angle - np.pi * turns
    sine, cosine = np.abs(np.sin(remainder)).ravel(), np.maximum(np.cos(remainder), 0.0).ravel()
    first, second = np.empty(angle.size), np.empty(angle.size)
    incomplete(read_only(cosine), read_only(sine), read_only(other.ravel()), first, second)
    sign = np.where(remainder < 0.0, -1.0, 1.0)
    whole = _complete(parameter, other)
    parts = (first.reshape(angle.shape), second.reshape(angle.shape))
    sums = [2.0 * turns * k + sign * odd_part for k, odd_part in zip(whole, parts, strict=True)]
    return sums[0][()], sums[1][()]


# ---- Jacobi's elliptic functions am, sn, cn, dn and theta functions, vectorised

# Most terms of a theta function: enough for q up to 0.9999.
_MOST_TERMS = 800
# Size of the terms that are left out, relative to the largest one, as a power of e.
_SMALL = 38.0


def am(u: Reals, m: Reals, *, mc: Reals | None = None) -> FloatArray:
    """The amplitude am(u, m), DLMF 22.16.1: the angle phi of which u = F(phi, m).

    Parameters
    ----------
    u : array_like
        Argument; a free rotation has u = omega_p t + epsilon.
    m, mc : array_like
        Parameter 0 <= m < 1, and 1 - m where m has lost digits; u and m are broadcast.

    Returns
    -------
    array
        rad, growing with u.  To 1e-15 and the rounding of u.

    Raises
    ------
    AttitudeError
        For a parameter outside of 0 to 1, and m = 1.

    >>> float(am(0.510467135628, 0.5).round(9))
    0.5
    """
    argument, parameter, other = _not_one(u, "u", m, mc)
    half = 2.0 * K(parameter, mc=other)
    turns = np.rint(argument / half)
    remainder = argument - half * turns
    out = np.empty(argument.size)
    amplitude(read_only(np.abs(remainder).ravel()), read_only(other.ravel()), out)
    angle: Any = np.pi * turns + np.where(remainder < 0.0, -1.0, 1.0) * out.reshape(argument.shape)
    return angle[()]


def sn(u: Reals, m: Reals, *, mc: Reals | None = None) -> FloatArray:
    """sin am(u, m), DLMF 22.2.4; arguments of `am`.

    >>> float(sn(0.5, 0.5).round(12))
    0.470750473656
    """
    return np.sin(am(u, m, mc=mc))


def cn(u: Reals, m: Reals, *, mc: Reals | None = None) -> FloatArray:
    """cos am(u, m), DLMF 22.2.5; arguments of `am`.

    >>> float(cn(0.5, 0.5).round(12))
    0.88226639489
    """
    return np.cos(am(u, m, mc=mc))


def dn(u: Reals, m: Reals, *, mc: Reals | None = None) -> FloatArray:
    """sqrt(1 - m sn^2), DLMF 22.2.6; arguments of `am`.

    >>> float(dn(0.5, 0.5).round(12))
    0.942972425777
    """
    angle = am(u, m, mc=mc)
    other = parameters(m, mc)[1]
    return np.sqrt(np.cos(angle) ** 2 + other * np.sin(angle) ** 2)


def theta(j: int, z: Any, q: Reals, *, derivative: bool = False) -> Any:
    """The theta function theta_j(z, q), j = 1, 2, 3, 4, DLMF 20.2.1-4, or its derivative by z.

    Parameters
    ----------
    j : int
    z : array_like of float or complex
        rad.
    q : array_like
        Nome, 0 <= q < 0.9999; z and q are broadcast.
    derivative : bool
        Whether to return the derivative by z.

    Returns
    -------
    array of float, or of complex for complex z
        To 1e-15 of the sum of the sizes of its terms.

    Raises
    ------
    AttitudeError
        For another j, and a nome out of range.

    >>> theta(3, [0.0, 1.0], 0.1).round(12)
    array([1.2002    , 0.91663991])
    """
    if j not in (1, 2, 3, 4):
        raise AttitudeError(f"j is {validation.shown(j)}; give 1, 2, 3 or 4.")
    points: Any = np.asarray(z)
    points = points.astype(complex if np.iscomplexobj(points) else float)
    base = validation.real(q, "q")
    if np.any(~((base >= 0.0) & (base < 0.9999))):
        raise AttitudeError("q is outside of 0 to 0.9999; give the nome, such as jacobi.nome(m).")
    points, base = validation.together(z=points, q=base)
    terms = _count(points, base)
    # A last axis of terms: frequencies 2 n + 1 for j = 1, 2; 2 n for j = 3, 4.
    n = np.arange(terms)
    odd = j in (1, 2)
    frequency = 2.0 * n + (1.0 if odd else 0.0)
    weight = 2.0 * np.power(base[..., None], 0.25 * frequency**2)
    weight = np.where(frequency == 0.0, 1.0, weight) * np.where(
        (n % 2 == 1) & (j in (1, 4)), -1.0, 1.0
    )
    angle = points[..., None] * frequency
    if derivative:
        wave = np.cos(angle) * frequency if j == 1 else -np.sin(angle) * frequency
    else:
        wave = np.sin(angle) if j == 1 else np.cos(angle)
    return np.sum(weight * wave, axis=-1)[()]


def _count(z: Any, q: FloatArray) -> int:
    """Terms until the rest is below the rounding of the largest: q^(n^2) e^(2 n |Im z|)."""
    rate = -np.log(np.maximum(np.max(q, initial=0.0), 1e-300))
    growth = float(np.max(np.abs(np.imag(z)), initial=0.0))
    # rate n^2 - 2 growth n >= small + growth^2 / rate
    return min(
        int(np.ceil(growth / rate + np.sqrt(_SMALL / rate) + growth / rate)) + 2, _MOST_TERMS
    )
