"""Elliptic integrals of the parameter m, vectorised: K, E, Pi, F, and the incomplete E."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from attitude import validation
from attitude.errors import AttitudeError
from attitude.immutable import read_only
from attitude.jacobi import loops

if TYPE_CHECKING:
    from attitude.annotations import FloatArray, Reals


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

    To 1e-15, relative.

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
        As of `K`, m < 1; n and m are broadcast.

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
    given = validation.real(n, "n")
    if np.any(given > 0.0):
        raise AttitudeError("n is greater than 0; give a characteristic that is not above 0.")
    other = parameters(m, mc)[1]
    given, other = (np.array(each) for each in np.broadcast_arrays(given, other))
    out = np.full(given.size, np.inf)
    kept = other.ravel() > 0.0
    found = np.empty(np.count_nonzero(kept))
    loops.third(read_only(given.ravel()[kept]), read_only(other.ravel()[kept]), found)
    out[kept] = found
    return out.reshape(given.shape)[()]


def F(phi: Reals, m: Reals, *, mc: Reals | None = None) -> FloatArray:
    """The incomplete integral of the first kind, F(phi, m), DLMF 19.2.4.

    The inverse of `am`: the time that the motion takes to an amplitude.

    Parameters
    ----------
    phi : array_like
        Amplitude, rad, of any size.
    m, mc
        As of `K`, m < 1; phi and m are broadcast.

    Returns
    -------
    array
        To 2e-15 of the larger of its size and K.

    >>> float(F(0.5, 0.5).round(12))
    0.510467135628
    """
    return _incomplete(phi, m, mc)[0]


def E_incomplete(phi: Reals, m: Reals, *, mc: Reals | None = None) -> FloatArray:
    """The incomplete integral of the second kind, E(phi, m), DLMF 19.2.5; as `F`.

    >>> float(E_incomplete(0.5, 0.5).round(12))
    0.489910959793
    """
    return _incomplete(phi, m, mc)[1]


def nome(m: Reals, *, mc: Reals | None = None) -> FloatArray:
    """The nome q = exp(-pi K(1 - m)/K(m)), DLMF 22.2.1; arguments of `K`.

    >>> float(nome(0.5).round(12))
    0.043213918264
    """
    given, other = parameters(m, mc)
    with np.errstate(divide="ignore"):
        ratio = K(other, mc=given) / K(given, mc=other)
    return np.exp(-np.pi * ratio)


def parameters(m: Reals, mc: Reals | None) -> tuple[FloatArray, FloatArray]:
    """m and 1 - m as arrays of one shape, checked.

    Raises
    ------
    AttitudeError
        For a parameter outside of 0 to 1, and a complement that is not that of m.
    """
    given = validation.real(m, "m")
    other = 1.0 - given if mc is None else validation.real(mc, "mc")
    given, other = (np.array(each) for each in np.broadcast_arrays(given, other))
    if np.any(~((given >= 0.0) & (given <= 1.0))) or np.any(~((other >= 0.0) & (other <= 1.0))):
        raise AttitudeError("m, or mc = 1 - m, is outside of 0 to 1; give the parameter m = k^2.")
    if np.any(np.abs((given + other) - 1.0) > 1e-12):
        raise AttitudeError("m + mc is not 1; give mc = 1 - m, or leave it out.")
    return given, other


def _complete(m: Reals, mc: Reals | None) -> tuple[Any, Any]:
    given, other = parameters(m, mc)
    first, second = np.full(given.size, np.inf), np.ones(given.size)
    kept = other.ravel() > 0.0
    found = np.empty(np.count_nonzero(kept)), np.empty(np.count_nonzero(kept))
    loops.complete(read_only(given.ravel()[kept]), read_only(other.ravel()[kept]), *found)
    first[kept], second[kept] = found
    return first.reshape(given.shape)[()], second.reshape(given.shape)[()]


def _incomplete(phi: Reals, m: Reals, mc: Reals | None) -> tuple[Any, Any]:
    """F and E of any amplitude: whole half turns add 2 K and 2 E, the rest is odd."""
    angle = validation.real(phi, "phi")
    given, other = parameters(m, mc)
    if np.any(other == 0.0):
        raise AttitudeError("m is 1, where F and am are elementary; give m < 1, or mc > 0.")
    angle, given, other = (np.array(x) for x in np.broadcast_arrays(angle, given, other))
    turns = np.rint(angle / np.pi)
    rest = angle - np.pi * turns
    sine, cosine = np.abs(np.sin(rest)).ravel(), np.maximum(np.cos(rest), 0.0).ravel()
    first, second = np.empty(angle.size), np.empty(angle.size)
    loops.incomplete(read_only(cosine), read_only(sine), read_only(other.ravel()), first, second)
    sign = np.where(rest < 0.0, -1.0, 1.0)
    whole = _complete(given, other)
    parts = (first.reshape(angle.shape), second.reshape(angle.shape))
    found = [2.0 * turns * k + sign * part for k, part in zip(whole, parts, strict=True)]
    return found[0][()], found[1][()]
