"""Laws that are a phase function times mu0 [a / (mu0 + mu) + b]: one sum over facets serves all."""

from dataclasses import dataclass

import numpy as np

from attitude import validation
from attitude.scattering.law import Law
from attitude.scattering.parameters import parameter

_FOUR_PI = 4.0 * np.pi


@dataclass(frozen=True)
class Lambert(Law):
    """r = albedo mu0 / pi: equally bright from everywhere.

    Parameters
    ----------
    albedo : float
        From 0 to 1; what is returned of what falls in, at any incidence.

    Source: Lambert, Photometria, 1760; Hapke, Theory of Reflectance and Emittance
    Spectroscopy, 2nd ed. 2012, eq. 8.12.
    """

    name = "lambert"
    albedo: float = parameter(1.0, low=0.0, high=1.0)

    @property
    def weights(self):
        """(a, b) in 1/sr."""
        return 0.0, self.albedo / np.pi


@dataclass(frozen=True)
class LommelSeeliger(Law):
    """r = albedo / (4 pi) mu0 / (mu0 + mu): single scattering by a dark, rough surface.

    Parameters
    ----------
    albedo : float
        Single-scattering albedo, 0 to 1, with an isotropic phase function.

    Source: Seeliger 1887; Hapke 2012, eq. 8.35a; Muinonen & Lumme, A&A 584, A23, 2015.  A body
    returns at most (1 - ln 2)/2 of what falls in vertically; see the energy test.
    """

    name = "lommel-seeliger"
    has_ellipsoid_form = True
    albedo: float = parameter(1.0, low=0.0, high=1.0)

    @property
    def weights(self):
        """(a, b) in 1/sr."""
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
        0 to 1.

    Notes
    -----
    The linear part was fitted to asteroids below some 100 deg of phase and would turn negative
    at alpha = 1/|k|; from there on f is 0: the law says nothing, and the magnitude is inf.

    Source: Kaasalainen, Torppa & Muinonen, Icarus 153, 37, 2001, eqs. 1-3; the usual values
    are those of DAMIT's convexinv.
    """

    name = "lommel-seeliger-lambert"
    c: float = parameter(0.1, low=0.0, high=10.0)
    a: float = parameter(0.5, low=0.0, high=10.0)
    d: float = parameter(0.1, low=1e-6, high=10.0, unit="rad")
    k: float = parameter(-0.5, low=-10.0, high=10.0, unit="1/rad")
    albedo: float = parameter(1.0, low=0.0, high=1.0)

    @property
    def weights(self):
        """(a, b) in 1/sr."""
        return self.albedo / _FOUR_PI, self.c * self.albedo / _FOUR_PI

    def phase(self, alpha):
        """f(alpha), for alpha in rad; not below 0."""
        alpha = validation.real(alpha, "alpha", unit="rad")
        return np.maximum(self.a * np.exp(-alpha / self.d) + self.k * alpha + 1.0, 0.0)
