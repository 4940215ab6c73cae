"""The compiled reflectances of `Material`: a Lambert part with Phong's or Cook and Torrance's lobe.

A row holds the fields of a `Material` in order: diffuse, specular, model, exponent, roughness, f0.
"""

import math

from attitude.compilation.decorators import reduction_subroutine, reduction_within
from attitude.compilation.elementary import binary_logarithm, power_of_half
from attitude.compilation.simd import at_least, at_most, chosen, every

MODELS = ("phong", "cook-torrance")
_PHONG = float(MODELS.index("phong"))
# Below this cosine of a micro-facet's tilt Cook and Torrance's lobe underflows to zero.
_STEEPEST = 0.03
# Whole exponents up to this are raised by products, whose error is that of the cosine.
_MULTIPLIED = 256.0
_LEAST = 1e-300


@reduction_subroutine
def of_phase(row, cos_half, sin_half, phase_terms):
    """Write the terms that depend on the phase angle alone, for the model of a row."""
    if row[2] == _PHONG:
        _phong_of_phase(row, cos_half, sin_half, phase_terms)
    else:
        _cook_torrance_of_phase(row, cos_half, phase_terms)


@reduction_within
def elements(row, phase_terms, mu0, mu):
    """r / mu0 in 1/sr of eight elements for the model of a row."""
    if row[2] == _PHONG:
        return _phong(row, phase_terms, mu0, mu)
    return _cook_torrance(phase_terms, mu0, mu)


@reduction_subroutine
def _phong_of_phase(row, cos_half, sin_half, phase_terms):
    phase_terms[0] = row[0] / math.pi
    phase_terms[1] = row[1] * (row[3] + 2.0) / (2.0 * math.pi)
    phase_terms[2] = (cos_half - sin_half) * (cos_half + sin_half)


@reduction_within
def _phong(row, phase_terms, mu0, mu):
    mirrored = 2.0 * mu0 * mu - phase_terms[2]
    base = at_least(mirrored, _LEAST)
    if row[3] <= _MULTIPLIED and row[3] == math.floor(row[3]):
        lobe = every(1.0, base)
        left = int(row[3])
        while left > 0:
            if left & 1:
                lobe = lobe * base
            base = base * base
            left >>= 1
    else:
        lobe = power_of_half(binary_logarithm(base) * -row[3])
    return phase_terms[0] + phase_terms[1] * chosen(mirrored, lobe, every(0.0, lobe))


@reduction_subroutine
def _cook_torrance_of_phase(row, cos_half, phase_terms):
    rest = 1.0 - cos_half
    fresnel = row[5] + (1.0 - row[5]) * rest * rest * rest * rest * rest
    slope = row[4] * row[4]
    phase_terms[0] = row[0] / math.pi
    phase_terms[1] = row[1] * fresnel / (4.0 * math.pi * slope)
    phase_terms[2] = cos_half
    phase_terms[3] = 1.0 / (slope * math.log(2.0))


@reduction_within
def _cook_torrance(phase_terms, mu0, mu):
    # The micro-facet that mirrors the Sun to the observer bisects the phase angle.
    cos_half = phase_terms[2]
    both = 0.5 * (mu0 + mu)
    # For steeper ones the exponential is below 1e-480 at every roughness, and could end as 0/0.
    shown = both - _STEEPEST * cos_half
    if cos_half <= 0.0:
        return shown * 0.0 + phase_terms[0]
    # in units of cos(alpha/2) the cosine of the tilt of the facet is 1 at most
    tilt = at_most(at_least(both / cos_half, _STEEPEST), 1.0)
    inverse = 1.0 / (tilt * tilt)
    spread = power_of_half((inverse - 1.0) * phase_terms[3]) * (inverse * inverse)
    grooves = at_most((2.0 / cos_half) * tilt * at_most(mu0, mu), 1.0)
    lobe = spread * grooves / at_least(mu0 * mu, _LEAST)
    return phase_terms[0] + phase_terms[1] * chosen(shown, lobe, every(0.0, lobe))
