"""Magnitudes from brightness in m2/sr."""

import numpy as np

from attitude import validation
from attitude.errors import AttitudeError
from attitude.physical_constants import ASTRONOMICAL_UNIT_M
from attitude.scattering.parameters import together

# The astronomical unit (IAU 2012 B2), m.
# The Sun in Johnson V, Vega magnitudes: Willmer, ApJS 236, 47, 2018, table 3.
SUN_V = -26.76


def reduced_magnitude(brightness, *, sun_magnitude=SUN_V):
    """Magnitude at 1 au from Sun and observer: V(1, 1, alpha).

    Parameters
    ----------
    brightness : (...) array_like
        m2/sr, not negative.
    sun_magnitude : float
        Of the Sun at 1 au in the band at hand; Johnson V unless given.

    Returns
    -------
    (...) array
        ``sun_magnitude - 2.5 log10(brightness / au^2)``.  A body that shows nothing, because
        no facet is both lit and seen, has brightness 0 and magnitude inf: fainter than any number.

    Raises
    ------
    AttitudeError
        For brightness that is negative or NaN.

    Examples
    --------
    A sphere of geometric albedo 1 and diameter 1329 km has H = 0 (to the Sun's uncertainty).

    >>> round(float(reduced_magnitude(1.0 * 664.5e3**2)), 2)
    0.0
    """
    array = validation.real(brightness, "brightness", unit="m2/sr", finite=False)
    if not np.all((array >= 0.0) & (array < np.inf)):
        bad = array[~((array >= 0.0) & (array < np.inf))].flat[0]
        raise AttitudeError(f"brightness holds {bad}; it must be finite and not negative, m2/sr.")
    sun_magnitude = validation.number(sun_magnitude, "sun_magnitude", unit="mag")
    with np.errstate(divide="ignore"):
        return sun_magnitude + 5.0 * np.log10(ASTRONOMICAL_UNIT_M) - 2.5 * np.log10(array)


def apparent_magnitude(brightness, sun_distance, observer_distance, *, sun_magnitude=SUN_V):
    """Magnitude as seen, with distances of the body from Sun and observer in m.

    ``reduced + 5 log10(sun_distance observer_distance / au^2)``: for a satellite as for an
    asteroid, so long as both are far away compared with the body's size.  Arrays broadcast; inf
    where the body shows nothing.  See `reduced_magnitude`.
    """
    reduced = reduced_magnitude(brightness, sun_magnitude=sun_magnitude)
    modulus = distance_modulus(sun_distance, observer_distance)
    reduced, modulus = together(brightness=reduced, distances=modulus)
    return reduced + modulus


def distance_modulus(sun_distance, observer_distance):
    """Apparent minus reduced magnitude, 5 log10 of the product of both distances (m) in au."""
    moduli = {}
    for value, name in ((sun_distance, "sun_distance"), (observer_distance, "observer_distance")):
        array = validation.real(value, name, unit="m")
        if not np.all(array > 0.0):
            raise AttitudeError(f"{name} holds {np.min(array)}; distances are greater than zero.")
        moduli[name] = 5.0 * np.log10(array / ASTRONOMICAL_UNIT_M)
    one, other = together(**moduli)
    return one + other


def dimming(lit):
    """Magnitudes by which a body is fainter that a fraction of the Sun's disc lights; inf for 0."""
    with np.errstate(divide="ignore"):
        return -2.5 * np.log10(validation.real(lit, "lit", finite=False))
