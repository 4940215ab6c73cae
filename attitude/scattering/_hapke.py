"""Hapke's law with opposition surge and macroscopic roughness."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from attitude._compilation.decorators import reduction_subroutine, reduction_within
from attitude._compilation.elementary import (
    power_of_half,
    power_of_half_to_1000,
    share_of_half_turn,
)
from attitude._compilation.instructions import fence
from attitude._compilation.simd import at_least, at_most, chosen, root
from attitude.scattering._law import Law, parameter

if TYPE_CHECKING:
    from attitude._support.annotations import FloatArray
    from attitude.scattering._law import NumberField


# Below this tangent of the mean slope the surface is smooth to rounding.
_SMOOTH = 1e-18
# Lower bound of numbers that vanish together with others, where their quotient does not count.
_LEAST = 1e-40
_LN2 = math.log(2.0)
# Bound of -log2 of E1.
_STEEPEST = 42.0


@reduction_subroutine
def _of_phase(row, cos_half, sin_half, phase_terms):
    """Write the phase function with its surge, sin^2(alpha/2), tan(theta-bar) and gamma."""
    # The fence keeps the bits of the product the same in every loop that inlines this function.
    cos_alpha = fence((cos_half - sin_half) * (cos_half + sin_half))
    g = row[1]
    base = 1.0 + 2.0 * g * cos_alpha + g * g
    surge = row[2] * row[3] * cos_half / (row[3] * cos_half + sin_half)
    phase_terms[0] = (1.0 + surge) * (1.0 - g * g) / (base * math.sqrt(base))
    phase_terms[1] = sin_half * sin_half
    phase_terms[2], phase_terms[3] = row[5], row[6]


@reduction_within
def _elements(row, phase_terms, mu0, mu):
    """r / mu0 in 1/sr of several elements, with the terms of `_of_phase`."""
    if phase_terms[2] <= _SMOOTH:
        return _smooth(row, phase_terms, mu0, mu)
    return _rough(row, phase_terms, mu0, mu)


@reduction_within
def _smooth(row, phase_terms, mu0, mu):
    above = (mu0 * 2.0 + 1.0) * (mu * 2.0 + 1.0)
    gamma = 2.0 * phase_terms[3]
    below = (mu0 * gamma + 1.0) * (mu * gamma + 1.0)
    several = (phase_terms[0] - 1.0) * below + above
    return (0.25 / math.pi * row[0]) * several / (below * (mu0 + mu))


@reduction_within
def _rough(row, phase_terms, mu0, mu):
    """Hapke's eqs. 46-58 as one quotient.

    The equations treat the larger of incidence and emission and the smaller one differently, and
    are symmetric otherwise: here a is the one of larger cosine.  With t = tan(theta-bar), S = t sin
    and E1, E2 of eqs. 45 and 46,

        D = 2 - E1                                  eta = chi (mu D + S E2) / D
        L = 2 - E1b - psi/pi E1a
        Ya = L mua + Sa (cos psi E2b + sin^2(psi/2) E2a)        mu_e = chi Y / L
        Yb = L mub + Sb (E2b - sin^2(psi/2) E2a)
    """
    tan_bar, gamma = phase_terms[2], phase_terms[3]
    a, b = at_least(mu0, mu), at_most(mu0, mu)
    sin_a = root(at_least(1.0 - a * a, _LEAST))
    sin_b = root(at_least(1.0 - b * b, _LEAST))
    # The azimuth psi between the planes of incidence and emission:
    # sin^2(psi/2) = [sin^2(alpha/2) - sin^2((i - e)/2)] / (sin i sin e).  Cosines would lose half
    # of their digits near opposition.  Rounding can leave the range 0 to 1.
    sines = sin_a * sin_b
    more = a * b + sines + 1.0
    apart = sin_a * b - sin_b * a
    inverse = 0.5 / (more * sines)
    sin2 = (more * (2.0 * phase_terms[1]) - apart * apart) * inverse
    sin2 = at_most(at_least(sin2, 0.0), 1.0)
    cos2 = 1.0 - sin2
    cos_psi = cos2 - sin2
    # psi/pi, and exp(-2 tan(psi/2))
    steep = 1.0 / root(at_least(sin2 * cos2, _LEAST))
    angle = share_of_half_turn(at_most(sin2, cos2) * steep)
    angle = chosen(cos_psi, angle, 1.0 - angle)
    hidden = power_of_half(sin2 * (steep * (2.0 / _LN2)))
    # -ln E1 and -ln E2 are multiples of the cotangent of i or e, and of its square
    scaled = inverse * (more * (4.0 / math.pi / _LN2 / tan_bar))
    # Beyond the bound, 2^-42 and 2^-960, they count as nothing.
    cot_a, cot_b = at_most(a * sin_b * scaled, _STEEPEST), at_most(b * sin_a * scaled, _STEEPEST)
    e1a, e1b = power_of_half_to_1000(cot_a), power_of_half_to_1000(cot_b)
    e2a = power_of_half_to_1000(cot_a * cot_a * (0.25 * math.pi * _LN2))
    e2b = power_of_half_to_1000(cot_b * cot_b * (0.25 * math.pi * _LN2))
    slope_a, slope_b = sin_a * tan_bar, sin_b * tan_bar
    da, db = 2.0 - e1a, 2.0 - e1b
    below = at_least(db - angle * e1a, _LEAST)
    ya = a * below + slope_a * (cos_psi * e2b + sin2 * e2a)
    yb = b * below + slope_b * (e2b - sin2 * e2a)
    # H(mu0_e) H(mu_e) is (L + c Ya) (L + c Yb) over the same with c gamma for c.
    larger = 2.0 / math.sqrt(1.0 + math.pi * tan_bar * tan_bar)
    smaller = larger * gamma
    product, squared = ya * yb, below * below
    both = below * at_least(ya + yb, _LEAST)
    under = squared + both * smaller + product * (smaller * smaller)
    # [p (1 + B) - 1] under + above, times w / (4 pi)
    scale, phase_less_one = 0.25 / math.pi * row[0], phase_terms[0] - 1.0
    several = (
        squared * (scale * phase_terms[0])
        + both * (scale * (larger + phase_less_one * smaller))
        + product * (scale * (larger * larger + phase_less_one * (smaller * smaller)))
    )
    shaded = (b * db + slope_b * e2b) * (a * da + slope_a * e2a * (1.0 - hidden))
    return (product * da * db) * several / (both * under * shaded)


@dataclass(frozen=True)
class Hapke(Law):
    """Reflectance of a particulate surface that is rough on scales above the grains.

    r = w / (4 pi) mu0e / (mu0e + mue) [(1 + B(alpha)) p(alpha) + H(mu0e) H(mue) - 1] S

    Parameters
    ----------
    w : float
        Single-scattering albedo, 0 to 1.
    g : float
        Asymmetry of the Henyey-Greenstein phase function p, -0.99 to 0.99; negative values
        scatter backward.
    b0, h : float
        Height (0 to 10) and angular half-width (1e-6 to 10) of the opposition surge,
        B = b0 / (1 + tan(alpha/2) / h).
    roughness : float or Quantity
        Mean slope angle theta-bar, rad: 0 to 60 deg.

    Source: Hapke, Icarus 59, 41, 1984, eqs. 46-58 (roughness); Icarus 67, 264, 1986 (surge);
    H(x) = (1 + 2 x) / (1 + 2 x sqrt(1 - w)), 1981, which holds to 4%.  The defaults are those
    of average C-type asteroids (Helfenstein & Veverka, Asteroids II, 1989).
    """

    name = "hapke"
    of_phase = _of_phase
    elements = _elements

    w: NumberField = parameter(0.037, low=0.0, high=1.0)
    g: NumberField = parameter(-0.47, low=-0.99, high=0.99)
    b0: NumberField = parameter(2.5, low=0.0, high=10.0)
    h: NumberField = parameter(0.025, low=1e-6, high=10.0)
    roughness: NumberField = parameter(
        math.radians(20.0), low=0.0, high=math.radians(60.0), unit="rad"
    )

    def row(self) -> FloatArray:
        """The fields in order, tan(theta-bar), and gamma = sqrt(1 - w)."""
        return np.append(super().row(), [math.tan(self.roughness), math.sqrt(1.0 - self.w)])
