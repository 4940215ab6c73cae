"""Laws that are a phase function times mu0 mu [a / (mu0 + mu) + b]: one fused sum serves all.

Each has `weights`, the pair (a, b), and `phase(alpha)`, the factor of an epoch.
"""

from dataclasses import dataclass

import numpy as np

from attitude import validation
from attitude.scattering.parameters import geometry, within

_FOUR_PI = 4.0 * np.pi


class _Fused:
    """The reflectance that `weights` and `phase` define."""

    def reflectance(self, mu0, mu, alpha):
        """r in 1/sr for cosines of incidence and emission and the phase angle (rad).

        Zero where mu0 or mu is not positive: the element is dark or turned away.
        """
        mu0, mu, alpha = geometry(mu0, mu, alpha)
        shown = (mu0 > 0.0) & (mu > 0.0)
        together = np.where(shown, mu0 + mu, 1.0)
        a, b = self.weights
        value = self.phase(alpha) * (a * (mu0 / together) + b * mu0)
        return np.where(shown, value, 0.0)


@dataclass(frozen=True)
class Lambert(_Fused):
    """r = albedo mu0 / pi: equally bright from everywhere.

    Parameters
    ----------
    albedo : float
        From 0 to 1; what is returned of what falls in, at any incidence.

    Source: Lambert, Photometria, 1760; Hapke, Theory of Reflectance and Emittance
    Spectroscopy, 2nd ed. 2012, eq. 8.12.
    """

    albedo: float = 1.0

    def __post_init__(self):
        object.__setattr__(self, "albedo", within(self.albedo, "albedo", 0.0, 1.0))

    @property
    def weights(self):
        """(a, b) in 1/sr."""
        return 0.0, self.albedo / np.pi

    def phase(self, alpha):
        """1 at every phase angle."""
        return np.ones_like(validation.real(alpha, "alpha", unit="rad"))


@dataclass(frozen=True)
class LommelSeeliger(_Fused):
    """r = albedo / (4 pi) mu0 / (mu0 + mu): single scattering by a dark, rough surface.

    Parameters
    ----------
    albedo : float
        Single-scattering albedo, 0 to 1, with an isotropic phase function.

    Source: Seeliger 1887; Hapke 2012, eq. 8.35a; Muinonen & Lumme, A&A 584, A23, 2015.  A body
    returns at most (1 - ln 2)/2 of what falls in vertically; see the energy test.
    """

    albedo: float = 1.0

    def __post_init__(self):
        object.__setattr__(self, "albedo", within(self.albedo, "albedo", 0.0, 1.0))

    @property
    def weights(self):
        """(a, b) in 1/sr."""
        return self.albedo / _FOUR_PI, 0.0

    def phase(self, alpha):
        """1 at every phase angle."""
        return np.ones_like(validation.real(alpha, "alpha", unit="rad"))


@dataclass(frozen=True)
class LommelSeeligerLambert(_Fused):
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

    c: float = 0.1
    a: float = 0.5
    d: float = 0.1
    k: float = -0.5
    albedo: float = 1.0

    def __post_init__(self):
        for name, low, high in (
            ("c", 0.0, 10.0),
            ("a", 0.0, 10.0),
            ("d", 1e-6, 10.0),
            ("k", -10.0, 10.0),
            ("albedo", 0.0, 1.0),
        ):
            object.__setattr__(self, name, within(getattr(self, name), name, low, high))

    @property
    def weights(self):
        """(a, b) in 1/sr."""
        return self.albedo / _FOUR_PI, self.c * self.albedo / _FOUR_PI

    def phase(self, alpha):
        """f(alpha), for alpha in rad; not below 0."""
        alpha = validation.real(alpha, "alpha", unit="rad")
        return np.maximum(self.a * np.exp(-alpha / self.d) + self.k * alpha + 1.0, 0.0)
