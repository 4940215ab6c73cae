"""The compiled reflectances of `Material`: a Lambert part with Phong's or Cook and Torrance's lobe.

A row holds the fields of a `Material` in order: diffuse, specular, model, exponent, roughness, f0.
"""

import math

from attitude.compilation.decorators import reduction_subroutine

MODELS = ("phong", "cook-torrance")
_PHONG = float(MODELS.index("phong"))
# Below this cosine of a micro-facet's tilt Cook and Torrance's lobe underflows to zero.
_STEEPEST = 0.03


@reduction_subroutine
def of_phase(row, cos_half, sin_half, phase_terms):
    """Write the terms that depend on the phase angle alone, for the model of a row."""
    if row[2] == _PHONG:
        _phong_of_phase(row, cos_half, sin_half, phase_terms)
    else:
        _cook_torrance_of_phase(row, cos_half, phase_terms)


@reduction_subroutine
def element(row, phase_terms, mu0, mu):
    """r / mu0 in 1/sr for the model of a row."""
    if row[2] == _PHONG:
        return _phong(row, phase_terms, mu0, mu)
    return _cook_torrance(phase_terms, mu0, mu)


@reduction_subroutine
def _phong_of_phase(row, cos_half, sin_half, phase_terms):
    phase_terms[0] = row[0] / math.pi
    phase_terms[1] = row[1] * (row[3] + 2.0) / (2.0 * math.pi)
    phase_terms[2] = (cos_half - sin_half) * (cos_half + sin_half)


@reduction_subroutine
def _phong(row, phase_terms, mu0, mu):
    mirrored = 2.0 * mu0 * mu - phase_terms[2]
    if mirrored <= 0.0:
        return phase_terms[0]
    return phase_terms[0] + phase_terms[1] * math.pow(mirrored, row[3])


@reduction_subroutine
def _cook_torrance_of_phase(row, cos_half, phase_terms):
    rest = 1.0 - cos_half
    fresnel = row[5] + (1.0 - row[5]) * rest * rest * rest * rest * rest
    slope = row[4] * row[4]
    phase_terms[0] = row[0] / math.pi
    phase_terms[1] = row[1] * fresnel / (4.0 * math.pi * slope)
    phase_terms[2] = cos_half
    phase_terms[3] = 1.0 / slope


@reduction_subroutine
def _cook_torrance(phase_terms, mu0, mu):
    # The micro-facet that mirrors the Sun to the observer bisects the phase angle.
    # For steeper ones the exponential is below 1e-480 at every roughness, and could end as 0/0.
    if phase_terms[2] <= 0.0 or 0.5 * (mu0 + mu) < _STEEPEST * phase_terms[2]:
        return phase_terms[0]
    tilt = min(0.5 * (mu0 + mu) / phase_terms[2], 1.0)
    square = tilt * tilt
    spread = math.exp((square - 1.0) / square * phase_terms[3]) / (square * square)
    # min(1, 2 tilt min(mu0, mu) / cos_half) / (mu0 mu), where the product may underflow.
    grooves = min(1.0 / (mu0 * mu), 2.0 * tilt / (phase_terms[2] * max(mu0, mu)))
    return phase_terms[0] + phase_terms[1] * spread * grooves
