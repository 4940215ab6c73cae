"""Reflectance of one element, for compiled code: Hapke, Phong, Cook-Torrance.

Everything that depends on the phase angle alone is taken out of the loop over facets and kept in
`of_phase`.  This module imports numba; the laws import it when they are first evaluated.
"""

import math

import numpy as np

from attitude.compilation.decorators import reduction, reduction_subroutine
from attitude.scattering.codes import HAPKE, PHONG, WIDTH

# In Hapke's roughness a denominator and its numerators vanish together where Sun and observer are
# both on the horizon, opposite each other; nothing is returned there, and this keeps it so.
_LEAST = 1e-300
# The least cosine of a micro-facet's tilt at which Cook and Torrance's lobe is above zero.
_STEEPEST = 0.03


@reduction_subroutine
def of_phase(row, cos_half, sin_half, out):
    """What a material's row becomes at one phase angle: out[0:WIDTH], for `element`.

    The angle comes as cosine and sine of its half: a cosine of the whole would lose half of its
    digits near opposition, and narrow surges with them.
    """
    cos_alpha = (cos_half - sin_half) * (cos_half + sin_half)
    if row[0] == HAPKE:
        g = row[2]
        base = 1.0 + 2.0 * g * cos_alpha + g * g
        surge = row[3] * row[4] * cos_half / (row[4] * cos_half + sin_half)
        out[0] = (1.0 + surge) * (1.0 - g * g) / (base * math.sqrt(base))
        out[1] = sin_half * sin_half
        out[2] = math.tan(row[5])
        out[3] = math.sqrt(1.0 - row[1])
    elif row[0] == PHONG:
        out[0] = row[1] / math.pi
        out[1] = row[2] * (row[3] + 2.0) / (2.0 * math.pi)
        out[2] = cos_alpha
    else:
        rest = 1.0 - cos_half
        fresnel = row[4] + (1.0 - row[4]) * rest * rest * rest * rest * rest
        slope = row[3] * row[3]
        out[0] = row[1] / math.pi
        out[1] = row[2] * fresnel / (4.0 * math.pi * slope)
        out[2] = cos_half
        out[3] = 1.0 / slope


@reduction_subroutine
def element(row, now, mu0, mu):
    """r / mu0 in 1/sr for positive mu0 and mu; `now` is what `of_phase` wrote."""
    if row[0] == HAPKE:
        return _hapke(row, now, mu0, mu)
    if row[0] == PHONG:
        mirrored = 2.0 * mu0 * mu - now[2]
        if mirrored <= 0.0:
            return now[0]
        return now[0] + now[1] * math.pow(mirrored, row[3])
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


@reduction_subroutine
def _hapke(row, now, mu0, mu):
    w, tan_bar, gamma = row[1], now[2], now[3]
    if tan_bar <= 0.0:
        return 0.25 / math.pi * w * _single_and_multiple(now[0], gamma, mu0, mu) / (mu0 + mu)
    mu0 = min(mu0, 1.0)
    mu = min(mu, 1.0)
    sin_i = math.sqrt(1.0 - mu0 * mu0)
    sin_e = math.sqrt(1.0 - mu * mu)
    # The azimuth psi between the planes of incidence and emission; where one is vertical it is 0:
    # sin^2(psi/2) = [sin^2(alpha/2) - sin^2((i - e)/2)] / (sin i sin e), where near opposition
    # cosines would lose half of their digits.  Rounding takes it beyond both ends.
    sines = sin_i * sin_e
    sin2_half = 0.0
    if sines > 0.0:
        # in an order that exchanging Sun and observer leaves alone: reciprocity to rounding
        high, low = max(mu0, mu), min(mu0, mu)
        apart = min(sin_i, sin_e) * low - max(sin_i, sin_e) * high
        apart = 0.5 * apart * apart / (1.0 + mu0 * mu + sines)
        sin2_half = min(max((now[1] - apart) / sines, 0.0), 1.0)
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
    # S / mu0, so that nothing is divided by a cosine that may be tiny.
    shadow = mu_e / (eta_e * eta_i) * chi / (1.0 - hidden + hidden * chi * share)
    ratio = mu0_e / (mu0_e + mu_e)
    return 0.25 / math.pi * w * ratio * shadow * _single_and_multiple(now[0], gamma, mu0_e, mu_e)


@reduction_subroutine
def _slopes(mu, sine, tan_bar):
    """Hapke 1984, eqs. 45, 46: E1 and E2, of angle with cosine mu; both 0 at the vertical."""
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


@reduction
def _elements(row, mu0, mu, half, out):
    now = np.empty(WIDTH)
    for i in range(out.size):
        out[i] = 0.0
        if mu0[i] > 0.0 and mu[i] > 0.0:
            of_phase(row, math.cos(half[i]), math.sin(half[i]), now)
            out[i] = mu0[i] * element(row, now, mu0[i], mu[i])


def evaluated(rows, mu0, mu, alpha):
    """r in 1/sr of the first row, for arrays of one shape."""
    out = np.empty(mu0.shape)
    flat = [np.ascontiguousarray(a).reshape(-1) for a in (mu0, mu, 0.5 * alpha)]
    _elements(rows[0][0], *flat, out.reshape(-1))
    return out
