"""The lobes of `Material`, compiled: Phong's and Cook and Torrance's over a Lambert part.

A row holds the fields of a `Material`: diffuse, specular, model, exponent, roughness, f0.
"""

import math

from attitude.compilation.decorators import reduction_subroutine

MODELS = ("phong", "cook-torrance")
_PHONG = float(MODELS.index("phong"))
# The least cosine of a micro-facet's tilt at which Cook and Torrance's lobe is above zero.
_STEEPEST = 0.03


@reduction_subroutine
def of_phase(row, cos_half, sin_half, now):
    """What depends on the phase angle alone, for the model of a row."""
    if row[2] == _PHONG:
        _phong_of_phase(row, cos_half, sin_half, now)
    else:
        _cook_torrance_of_phase(row, cos_half, now)


@reduction_subroutine
def element(row, now, mu0, mu):
    """r / mu0 in 1/sr for the model of a row."""
    if row[2] == _PHONG:
        return _phong(row, now, mu0, mu)
    return _cook_torrance(now, mu0, mu)


@reduction_subroutine
def _phong_of_phase(row, cos_half, sin_half, now):
    now[0] = row[0] / math.pi
    now[1] = row[1] * (row[3] + 2.0) / (2.0 * math.pi)
    now[2] = (cos_half - sin_half) * (cos_half + sin_half)


@reduction_subroutine
def _phong(row, now, mu0, mu):
    mirrored = 2.0 * mu0 * mu - now[2]
    if mirrored <= 0.0:
        return now[0]
    return now[0] + now[1] * math.pow(mirrored, row[3])


@reduction_subroutine
def _cook_torrance_of_phase(row, cos_half, now):
    rest = 1.0 - cos_half
    fresnel = row[5] + (1.0 - row[5]) * rest * rest * rest * rest * rest
    slope = row[4] * row[4]
    now[0] = row[0] / math.pi
    now[1] = row[1] * fresnel / (4.0 * math.pi * slope)
    now[2] = cos_half
    now[3] = 1.0 / slope


@reduction_subroutine
def _cook_torrance(now, mu0, mu):
    # The micro-facet that mirrors the Sun to the observer bisects the phase angle.
    # Steeper than this its exponential is below 1e-480 for every roughness: no 0/0 far beyond.
    if now[2] <= 0.0 or 0.5 * (mu0 + mu) < _STEEPEST * now[2]:
        return now[0]
    tilt = min(0.5 * (mu0 + mu) / now[2], 1.0)
    square = tilt * tilt
    spread = math.exp((square - 1.0) / square * now[3]) / (square * square)
    # min(1, 2 tilt min(mu0, mu) / cos_half) over mu0 mu, which may be too small for a double.
    grooves = min(1.0 / (mu0 * mu), 2.0 * tilt / (now[2] * max(mu0, mu)))
    return now[0] + now[1] * spread * grooves
