"""Jacobi's elliptic functions am, sn, cn, dn and theta functions, vectorised."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from attitude import validation
from attitude.errors import AttitudeError
from attitude.immutable import read_only
from attitude.jacobi import loops
from attitude.jacobi.integrals import K, parameters

if TYPE_CHECKING:
    from attitude.annotations import FloatArray, Reals

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
    given = validation.real(u, "u")
    parameter, other = parameters(m, mc)
    if np.any(other == 0.0):
        raise AttitudeError("m is 1, where F and am are elementary; give m < 1, or mc > 0.")
    given, parameter, other = (
        np.array(each) for each in np.broadcast_arrays(given, parameter, other)
    )
    half = 2.0 * K(parameter, mc=other)
    turns = np.rint(given / half)
    rest = given - half * turns
    out = np.empty(given.size)
    loops.amplitude(read_only(np.abs(rest).ravel()), read_only(other.ravel()), out)
    found: Any = np.pi * turns + np.where(rest < 0.0, -1.0, 1.0) * out.reshape(given.shape)
    return found[()]


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
    found: Any = np.sqrt(np.cos(angle) ** 2 + other * np.sin(angle) ** 2)
    return found


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
    given: Any = np.asarray(z)
    given = given.astype(complex if np.iscomplexobj(given) else float)
    base = validation.real(q, "q")
    if np.any(~((base >= 0.0) & (base < 0.9999))):
        raise AttitudeError("q is outside of 0 to 0.9999; give the nome, such as jacobi.nome(m).")
    given, base = np.broadcast_arrays(given, base)
    terms = _count(given, base)
    # A last axis of terms: frequencies 2 n + 1 for j = 1, 2; 2 n for j = 3, 4.
    n = np.arange(terms)
    odd = j in (1, 2)
    frequency = 2.0 * n + (1.0 if odd else 0.0)
    weight = 2.0 * np.power(base[..., None], 0.25 * frequency**2)
    weight = np.where(frequency == 0.0, 1.0, weight) * np.where(
        (n % 2 == 1) & (j in (1, 4)), -1.0, 1.0
    )
    angle = given[..., None] * frequency
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
