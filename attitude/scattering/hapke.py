"""Hapke's law with opposition surge and macroscopic roughness."""

from dataclasses import dataclass

import numpy as np

from attitude.scattering.parameters import geometry, within

_MOST_ROUGH = np.radians(60.0)


@dataclass(frozen=True)
class Hapke:
    """Reflectance of a particulate surface, rough on scales above the grains.

    r = w / (4 pi) mu0e / (mu0e + mue) [(1 + B(alpha)) p(alpha) + H(mu0e) H(mue) - 1] S

    Parameters
    ----------
    w : float
        Single-scattering albedo, 0 to 1.
    g : float
        Asymmetry of the Henyey-Greenstein p, -0.99 to 0.99; negative scatters backward.
    b0, h : float
        Height (0 to 10) and angular half-width (1e-6 to 10) of the opposition surge,
        B = b0 / (1 + tan(alpha/2) / h).
    roughness : float or Quantity
        Mean slope angle theta-bar, rad: 0 to 60 deg.

    Source: Hapke, Icarus 59, 41, 1984, eqs. 46-58 (roughness); Icarus 67, 264, 1986 (surge);
    H(x) = (1 + 2 x) / (1 + 2 x sqrt(1 - w)), 1981, which holds to 4%.  The usual values are those
    of average C-type asteroids (Helfenstein & Veverka, Asteroids II, 1989).
    """

    w: float = 0.037
    g: float = -0.47
    b0: float = 2.5
    h: float = 0.025
    roughness: float = np.radians(20.0)

    def __post_init__(self):
        for name, low, high, unit in (
            ("w", 0.0, 1.0, None),
            ("g", -0.99, 0.99, None),
            ("b0", 0.0, 10.0, None),
            ("h", 1e-6, 10.0, None),
            ("roughness", 0.0, _MOST_ROUGH, "rad"),
        ):
            object.__setattr__(self, name, within(getattr(self, name), name, low, high, unit=unit))

    def reflectance(self, mu0, mu, alpha):
        """r in 1/sr for cosines of incidence and emission and the phase angle (rad).

        Zero where mu0 or mu is not positive.
        """
        from attitude.scattering import compiled

        mu0, mu, alpha = geometry(mu0, mu, alpha)
        rows = self.rows(("surface",))
        return compiled.evaluated(rows, mu0, mu, alpha)

    def rows(self, materials):
        """One row of numbers for compiled code, whatever the facets are made of."""
        from attitude.scattering.codes import HAPKE, WIDTH

        row = np.zeros((1, WIDTH))
        row[0, :6] = HAPKE, self.w, self.g, self.b0, self.h, self.roughness
        return row, np.zeros(len(materials), dtype=np.int64)
