"""Laws of the form f(alpha) mu0 [a / (mu0 + mu) + b], which share one sum over facets.

The file also has the phase functions of whole asteroids.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING, Any

import numpy as np

from attitude._support import validation
from attitude.errors import AttitudeError
from attitude.scattering._law import Law, parameter, phase_angles

if TYPE_CHECKING:
    from collections.abc import Callable

    from attitude._support.annotations import FloatArray, Real, Reals
    from attitude.scattering._law import NumberField


_FOUR_PI = 4.0 * np.pi


@dataclass(frozen=True)
class Lambert(Law):
    """r = albedo mu0 / pi: the same radiance in all directions.

    Parameters
    ----------
    albedo : float
        Fraction of the incident light that is returned, 0 to 1, the same at any incidence.

    Source: Lambert, Photometria, 1760; Hapke, Theory of Reflectance and Emittance
    Spectroscopy, 2nd ed. 2012, eq. 8.12.
    """

    name = "lambert"
    albedo: NumberField = parameter(1.0, low=0.0, high=1.0)

    @property
    def weights(self) -> tuple[float, float]:
        """(a, b) in 1/sr of r = f(alpha) mu0 [a / (mu0 + mu) + b]."""
        return 0.0, self.albedo / np.pi


@dataclass(frozen=True)
class LommelSeeliger(Law):
    """r = albedo / (4 pi) mu0 / (mu0 + mu): single scattering by a dark, rough surface.

    Parameters
    ----------
    albedo : float
        Single-scattering albedo, 0 to 1, with an isotropic phase function.

    Source: Seeliger 1887; Hapke 2012, eq. 8.35a; Muinonen & Lumme, A&A 584, A23, 2015.  A surface
    returns at most (1 - ln 2)/2 of the light that falls in vertically
    (tests/scattering/test_scattering.py).
    """

    name = "lommel-seeliger"
    has_ellipsoid_form = True
    albedo: NumberField = parameter(1.0, low=0.0, high=1.0)

    @property
    def weights(self) -> tuple[float, float]:
        """(a, b) in 1/sr of r = f(alpha) mu0 [a / (mu0 + mu) + b]."""
        return self.albedo / _FOUR_PI, 0.0


@dataclass(frozen=True)
class LommelSeeligerLambert(Law):
    """The law of light-curve inversion: r = albedo / (4 pi) f(alpha) mu0 [1/(mu0 + mu) + c].

    With f(alpha) = a exp(-alpha / d) + k alpha + 1.

    Parameters
    ----------
    c : float
        Weight of the Lambert term, 0 to 10.
    a, d, k : float
        Height of the opposition surge, its width (rad), slope of the linear part (1/rad).
    albedo : float
        Factor of r, 0 to 1.

    Notes
    -----
    The linear part was fitted to asteroids below some 100 deg of phase.  Where the sum would be
    negative, f is 0 and the magnitude inf: the law does not describe these phase angles.

    Source: Kaasalainen, Torppa & Muinonen, Icarus 153, 37, 2001, eqs. 1-3; the defaults
    are those of DAMIT's convexinv.
    """

    name = "lommel-seeliger-lambert"
    c: NumberField = parameter(0.1, low=0.0, high=10.0)
    a: NumberField = parameter(0.5, low=0.0, high=10.0)
    d: NumberField = parameter(0.1, low=1e-6, high=10.0, unit="rad")
    k: NumberField = parameter(-0.5, low=-10.0, high=10.0, unit="1/rad")
    albedo: NumberField = parameter(1.0, low=0.0, high=1.0)

    @property
    def weights(self) -> tuple[float, float]:
        """(a, b) in 1/sr of r = f(alpha) mu0 [a / (mu0 + mu) + b]."""
        return self.albedo / _FOUR_PI, self.c * self.albedo / _FOUR_PI

    def phase(self, alpha: Reals) -> FloatArray:
        """f(alpha) for alpha in rad, at least 0."""
        alpha = validation.real(alpha, "alpha", unit="rad")
        return np.maximum(self.a * np.exp(-alpha / self.d) + self.k * alpha + 1.0, 0.0)


# ---- Phase functions of whole asteroids that the IAU adopted: reduced magnitudes from H

# Muinonen et al. 2010, tables 3 and 4: nodes in degrees, and slopes (1/rad) at the ends.
_NODES = np.array([7.5, 30.0, 60.0, 90.0, 120.0, 150.0])
_PHI1 = np.array([7.5e-1, 3.3486016e-1, 1.3410560e-1, 5.1104756e-2, 2.1465687e-2, 3.6396989e-3])
_PHI2 = np.array([9.25e-1, 6.2884169e-1, 3.1755495e-1, 1.2716367e-1, 2.2373903e-2, 1.6505689e-4])
_SLOPES1 = (-1.9098593, -9.1328612e-2)
_SLOPES2 = (-5.7295780e-1, -8.6573138e-8)
_NODES3 = np.array([0.0, 0.3, 1.0, 2.0, 4.0, 8.0, 12.0, 20.0, 30.0])
_PHI3 = np.concatenate(
    [
        [1.0, 8.3381185e-1, 5.7735424e-1, 4.2144772e-1, 2.3174230e-1],
        [1.0348178e-1, 6.1733473e-2, 1.6107006e-2, 0.0],
    ]
)
_SLOPES3 = (-1.0630097, 0.0)
_BASIS = (_NODES, _PHI1, _SLOPES1), (_NODES, _PHI2, _SLOPES2), (_NODES3, _PHI3, _SLOPES3)


def hg(alpha: Reals, h: Real = 0.0, g: Real = 0.15) -> FloatArray:
    """Reduced magnitude H - 2.5 log10[(1 - G) phi1 + G phi2].

    Parameters
    ----------
    alpha : array_like
        Phase angle, rad, 0 to pi.
    h, g : float
        Absolute magnitude (mag), and slope parameter from -0.25 to 1.2, within which the function
        falls with alpha and stays positive.

    Returns
    -------
    array, of the shape of alpha
        Magnitudes; inf at alpha = pi.

    Raises
    ------
    AttitudeError
        For alpha or g out of range, or numbers that are not finite.

    Source: Bowell et al., Asteroids II, 1989, eq. A4, stated there for alpha up to 120 deg.
    """
    alpha = phase_angles(alpha)
    h = validation.number(h, "h", unit="mag")
    g = validation.number(g, "g")
    if not -0.25 <= g <= 1.2:
        raise AttitudeError(f"g is {g!r}; it must lie from -0.25 to 1.2.")
    tangent = np.tan(0.5 * alpha)
    sine = np.sin(alpha)
    weight = np.exp(-90.56 * tangent * tangent)
    disc = 0.119 + 1.341 * sine - 0.754 * sine * sine
    parts = [
        weight * (1.0 - c * sine / disc) + (1.0 - weight) * np.exp(-a * tangent**b)
        for a, b, c in ((3.332, 0.631, 0.986), (1.862, 1.218, 0.238))
    ]
    return h + _magnitude((1.0 - g) * parts[0] + g * parts[1])


def hg1g2(alpha: Reals, h: Real = 0.0, g1: Real = 0.62, g2: Real = 0.14) -> FloatArray:
    """Reduced magnitude H - 2.5 log10[G1 phi1 + G2 phi2 + (1 - G1 - G2) phi3].

    Parameters
    ----------
    alpha : array_like
        Phase angle, rad, 0 to pi.
    h, g1, g2 : float
        Absolute magnitude (mag); weights, each at least 0 and together at most 1.

    Returns
    -------
    array, of the shape of alpha
        Magnitudes; inf where the function is 0.

    Raises
    ------
    AttitudeError
        For alpha or weights out of range, or numbers that are not finite.

    Notes
    -----
    phi1 and phi2 are linear below 7.5 deg and splines to 150 deg.  Beyond, which the paper leaves
    open, they continue with the end slope of the spline: phi1 reaches 0 at 152.3 deg.

    Source: Muinonen et al., Icarus 209, 542, 2010, eq. 18 and tables 3, 4.
    """
    alpha = phase_angles(alpha)
    h = validation.number(h, "h", unit="mag")
    g1, g2 = validation.number(g1, "g1"), validation.number(g2, "g2")
    if g1 < 0.0 or g2 < 0.0 or g1 + g2 > 1.0 + 1e-12:
        raise AttitudeError(
            f"g1 is {g1!r} and g2 is {g2!r}; neither may be negative, nor their sum above 1."
        )
    one, two, three = (_spline(k) for k in range(3))
    total = g1 * one(alpha) + g2 * two(alpha) + (1.0 - g1 - g2) * three(alpha)
    return h + _magnitude(total)


@lru_cache(maxsize=3)
def _spline(k: int) -> Callable[[FloatArray], Any]:
    """Basis function phi1, phi2 or phi3 (k = 0, 1, 2) of the phase angle in rad."""
    from scipy.interpolate import CubicSpline

    nodes, values, slopes = _BASIS[k]
    nodes = np.radians(nodes)
    spline = CubicSpline(nodes, values, bc_type=((1, slopes[0]), (1, slopes[1])))

    def function(alpha):
        inside = spline(np.clip(alpha, nodes[0], nodes[-1]))
        # phi3 is exactly 0 from its last node on; the spline meets its last value to rounding only.
        inside = np.where(alpha >= nodes[-1], values[-1], inside)
        before = slopes[0] * np.minimum(alpha - nodes[0], 0.0)
        after = slopes[1] * np.maximum(alpha - nodes[-1], 0.0)
        return inside + before + after

    return function


def _magnitude(total):
    with np.errstate(divide="ignore"):
        return -2.5 * np.log10(np.maximum(total, 0.0))
