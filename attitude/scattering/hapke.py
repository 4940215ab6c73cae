"""Hapke's law with opposition surge and macroscopic roughness."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from attitude.compilation.decorators import reduction_subroutine
from attitude.compilation.instructions import fence
from attitude.scattering.law import Law
from attitude.scattering.parameters import NumberField, parameter

# Lower bound of a denominator of Hapke's roughness, which vanishes together with its numerators
# where Sun and observer are both on the horizon and opposite each other: the quotient is then 0.
_LEAST = 1e-300


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
    phase_terms[2] = math.tan(row[4])
    phase_terms[3] = math.sqrt(1.0 - row[0])


@reduction_subroutine
def _element(row, phase_terms, mu0, mu):
    """r / mu0 in 1/sr, with the terms of `_of_phase`."""
    w, tan_bar, gamma = row[0], phase_terms[2], phase_terms[3]
    if tan_bar <= 0.0:
        return (
            0.25 / math.pi * w * _single_and_multiple(phase_terms[0], gamma, mu0, mu) / (mu0 + mu)
        )
    mu0 = min(mu0, 1.0)
    mu = min(mu, 1.0)
    sin_i = math.sqrt(1.0 - mu0 * mu0)
    sin_e = math.sqrt(1.0 - mu * mu)
    # The azimuth psi between the planes of incidence and emission, 0 if i or e is 0:
    # sin^2(psi/2) = [sin^2(alpha/2) - sin^2((i - e)/2)] / (sin i sin e).  Cosines would lose half
    # of their digits near opposition.  Rounding can leave the range 0 to 1, hence min and max.
    sines = sin_i * sin_e
    sin2_half = 0.0
    if sines > 0.0:
        # the same operations with Sun and observer exchanged: reciprocity to rounding
        high, low = max(mu0, mu), min(mu0, mu)
        apart = min(sin_i, sin_e) * low - max(sin_i, sin_e) * high
        apart = 0.5 * apart * apart / (1.0 + mu0 * mu + sines)
        sin2_half = min(max((phase_terms[1] - apart) / sines, 0.0), 1.0)
    cos_psi = 1.0 - 2.0 * sin2_half
    tan_half = math.sqrt(sin2_half) / math.sqrt(max(1.0 - sin2_half, 1e-300))
    psi = 2.0 * math.atan(tan_half)
    chi = 1.0 / math.sqrt(1.0 + math.pi * tan_bar * tan_bar)
    e1_i, e2_i = _slopes(mu0, sin_i, tan_bar)
    e1_e, e2_e = _slopes(mu, sin_e, tan_bar)
    eta_i = chi * (mu0 + sin_i * tan_bar * e2_i / (2.0 - e1_i))
    eta_e = chi * (mu + sin_e * tan_bar * e2_e / (2.0 - e1_e))
    hidden = math.exp(-2.0 * tan_half)
    if mu0 >= mu:
        below = max(2.0 - e1_e - psi / math.pi * e1_i, _LEAST)
        mu0_e = chi * (mu0 + sin_i * tan_bar * (cos_psi * e2_e + sin2_half * e2_i) / below)
        mu_e = chi * (mu + sin_e * tan_bar * (e2_e - sin2_half * e2_i) / below)
        share = mu0 / eta_i
    else:
        below = max(2.0 - e1_i - psi / math.pi * e1_e, _LEAST)
        mu0_e = chi * (mu0 + sin_i * tan_bar * (e2_i - sin2_half * e2_e) / below)
        mu_e = chi * (mu + sin_e * tan_bar * (cos_psi * e2_i + sin2_half * e2_e) / below)
        share = mu / eta_e
    # S / mu0: a division by mu0, which may be tiny, is not needed.
    shadow = mu_e / (eta_e * eta_i) * chi / (1.0 - hidden + hidden * chi * share)
    ratio = mu0_e / (mu0_e + mu_e)
    return (
        0.25
        / math.pi
        * w
        * ratio
        * shadow
        * _single_and_multiple(phase_terms[0], gamma, mu0_e, mu_e)
    )


@reduction_subroutine
def _slopes(mu, sine, tan_bar):
    """Hapke 1984, eqs. 45, 46: E1 and E2 of the angle with cosine mu; both 0 for angle 0."""
    if sine <= 0.0:
        return 0.0, 0.0
    cot = mu / (sine * tan_bar)
    return math.exp(-2.0 / math.pi * cot), math.exp(-cot * cot / math.pi)


@reduction_subroutine
def _single_and_multiple(single, gamma, mu0, mu):
    """(1 + B) p + H(mu0) H(mu) - 1."""
    h0 = (1.0 + 2.0 * mu0) / (1.0 + 2.0 * mu0 * gamma)
    h1 = (1.0 + 2.0 * mu) / (1.0 + 2.0 * mu * gamma)
    return single + h0 * h1 - 1.0


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
    element = _element

    w: NumberField = parameter(0.037, low=0.0, high=1.0)
    g: NumberField = parameter(-0.47, low=-0.99, high=0.99)
    b0: NumberField = parameter(2.5, low=0.0, high=10.0)
    h: NumberField = parameter(0.025, low=1e-6, high=10.0)
    roughness: NumberField = parameter(np.radians(20.0), low=0.0, high=np.radians(60.0), unit="rad")
