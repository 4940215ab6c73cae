"""Laws of the form f(alpha) mu0 [a / (mu0 + mu) + b], which share one sum over facets."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from attitude import validation
from attitude.scattering.law import Law
from attitude.scattering.parameters import NumberField, parameter

if TYPE_CHECKING:
    from attitude.annotations import FloatArray, Reals

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
    returns at most (1 - ln 2)/2 of the light that falls in vertically (tests/test_scattering.py).
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
