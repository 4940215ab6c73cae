"""Magnitudes from brightness in m2/sr."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from attitude import validation
from attitude.errors import AttitudeError
from attitude.physical_constants import ASTRONOMICAL_UNIT_M
from attitude.scattering.parameters import together

if TYPE_CHECKING:
    from attitude.annotations import FloatArray, Real, Reals

# The Sun in Johnson V, Vega magnitudes: Willmer, ApJS 236, 47, 2018, table 3.
SUN_V: float = -26.76


def reduced_magnitude(brightness: Reals, *, sun_magnitude: Real = SUN_V) -> FloatArray:
    """Magnitude at 1 au from Sun and observer: V(1, 1, alpha).

    Parameters
    ----------
    brightness : (...) array_like
        m2/sr, not negative.
    sun_magnitude : float
        Magnitude of the Sun at 1 au in the band of the result; by default Johnson V.

    Returns
    -------
    (...) array
        ``sun_magnitude - 2.5 log10(brightness / au^2)``.  A body without a facet that is both lit
        and seen has brightness 0 and magnitude inf.

    Raises
    ------
    AttitudeError
        For brightness that is negative, infinite or NaN.

    Examples
    --------
    A sphere of geometric albedo 1 and diameter 1329 km has H = 0 (to the Sun's uncertainty).

    >>> round(float(reduced_magnitude(1.0 * 664.5e3**2)), 2)
    0.0
    """
    array: FloatArray = validation.real(brightness, "brightness", unit="m2/sr", finite=False)
    if not np.all((array >= 0.0) & (array < np.inf)):
        bad = array[~((array >= 0.0) & (array < np.inf))].flat[0]
        raise AttitudeError(f"brightness holds {bad}; it must be finite and not negative, m2/sr.")
    return of_brightness(array, validation.number(sun_magnitude, "sun_magnitude", unit="mag"))


def of_brightness(brightness: FloatArray, sun_magnitude: float) -> FloatArray:
    """`reduced_magnitude` of brightness (...) that is not negative; NaN gives NaN."""
    with np.errstate(divide="ignore"):
        return sun_magnitude + 5.0 * np.log10(ASTRONOMICAL_UNIT_M) - 2.5 * np.log10(brightness)


def apparent_magnitude(
    brightness: Reals,
    sun_distance: Reals,
    observer_distance: Reals,
    *,
    sun_magnitude: Real = SUN_V,
) -> FloatArray:
    """Magnitude as seen by the observer: reduced + 5 log10(sun_distance observer_distance / au^2).

    It holds for asteroids and satellites whose distances from both are large compared with the
    size of the body.

    Parameters
    ----------
    brightness, sun_magnitude : as of `reduced_magnitude`
    sun_distance, observer_distance : (...) array_like
        Distances of the body from Sun and observer, m.

    Returns
    -------
    (...) array
        Of the shape to which the arrays broadcast; inf where the brightness is 0.

    Raises
    ------
    AttitudeError
        For brightness that is negative, infinite or NaN, distances that are not greater than zero,
        and shapes that do not broadcast.
    """
    reduced = reduced_magnitude(brightness, sun_magnitude=sun_magnitude)
    modulus = distance_modulus(sun_distance, observer_distance)
    reduced, modulus = together(brightness=reduced, distances=modulus)
    return reduced + modulus


def distance_modulus(sun_distance: Reals, observer_distance: Reals) -> FloatArray:
    """Apparent minus reduced magnitude: 5 log10 of the product of both distances in au.

    Distances are given in m.

    Raises
    ------
    AttitudeError
        For distances that are not greater than zero, and shapes that do not broadcast.
    """
    moduli = {}
    for value, name in ((sun_distance, "sun_distance"), (observer_distance, "observer_distance")):
        array = validation.real(value, name, unit="m")
        if not np.all(array > 0.0):
            raise AttitudeError(f"{name} holds {np.min(array)}; distances are greater than zero.")
        moduli[name] = 5.0 * np.log10(array / ASTRONOMICAL_UNIT_M)
    one, other = together(**moduli)
    return one + other


def dimming(lit: Reals) -> FloatArray:
    """Magnitudes by which a body is fainter if only a fraction of the Sun's disc lights it.

    The fraction `lit` is 0 to 1, of any shape; the result is inf for 0.
    """
    with np.errstate(divide="ignore"):
        return -2.5 * np.log10(validation.real(lit, "lit", finite=False))
