"""Magnitudes from brightness in m2/sr, and the mean brightness over all orientations."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from attitude._support import validation
from attitude._support.constants import ASTRONOMICAL_UNIT_M
from attitude.errors import AttitudeError
from attitude.light_curve._brightness import brightness as brightness_of
from attitude.scattering._law import law as known_law
from attitude.scattering._law import phase_angles
from attitude.scattering._weighted import LommelSeeliger
from attitude.shape._ellipsoid import Ellipsoid
from attitude.shape._mesh import Mesh

if TYPE_CHECKING:
    from collections.abc import Callable

    from attitude._support.annotations import FloatArray, Real, Reals
    from attitude.scattering._law import Law


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
    wrong = array[~((array >= 0.0) & (array < np.inf))]
    if wrong.size:
        raise AttitudeError(
            f"brightness holds {wrong.flat[0]}; it must be finite and not negative, m2/sr."
        )
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
    brightness, sun_magnitude : as in `reduced_magnitude`
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
    reduced, modulus = validation.together(brightness=reduced, distances=modulus)
    return reduced + modulus


def distance_modulus(sun_distance: Reals, observer_distance: Reals) -> FloatArray:
    """Apparent minus reduced magnitude: 5 log10 of the product of both distances, m, in au."""
    moduli = {}
    for value, name in ((sun_distance, "sun_distance"), (observer_distance, "observer_distance")):
        array = validation.real(value, name, unit="m")
        if not np.all(array > 0.0):
            raise AttitudeError(f"{name} holds {np.min(array)}; distances are greater than zero.")
        moduli[name] = 5.0 * np.log10(array / ASTRONOMICAL_UNIT_M)
    one, other = validation.together(**moduli)
    return one + other


def shadow_dimming(lit: Reals) -> FloatArray:
    """Magnitudes by which a body is fainter if a fraction `lit` of the Sun's disc lights it; inf
    for 0.
    """
    with np.errstate(divide="ignore"):
        return -2.5 * np.log10(validation.real(lit, "lit", finite=False))


# ---- The mean brightness over all orientations, which relates phase functions to shapes
# H, G and H, G1, G2 give one magnitude for each phase angle; shape and law give the variation about
# it.  In the mean over all orientations every facet of a convex body contributes alike, so that the
# body is as bright as a sphere of the same surface area.


def mean_brightness(shape: Ellipsoid | Mesh, law: str | Law, alpha: Reals) -> FloatArray:
    """Mean brightness of a convex body over all orientations, in closed form.

    Parameters
    ----------
    shape : Ellipsoid or Mesh
        For a shape that casts shadows on itself the result is the mean without shadows.
    law : str or Law
        A law with ``weights``: Lambert, Lommel-Seeliger, or their sum.
    alpha : (...) array_like
        Phase angle, rad, 0 to pi.

    Returns
    -------
    (...) array
        m2/sr.

    Raises
    ------
    AttitudeError
        For a law without weights, phase angles out of range, and other shapes.

    Notes
    -----
    The surface area over 4 pi times the brightness of a sphere of radius 1: Muinonen & Lumme,
    A&A 584, A23, 2015, for the Lommel-Seeliger term, (2/3) [sin alpha + (pi - alpha) cos alpha]
    for Lambert's.

    >>> print(round(1.5 * mean_brightness(Ellipsoid((1, 1, 1)), "lambert", 0.0), 12))
    1.0
    """
    law = known_law(law)
    weights = law.weights
    if weights is None:
        raise AttitudeError(
            f"law is {law!r}, which has a phase function of its own: the mean over all "
            "orientations is known for Lambert's and Lommel-Seeliger's laws only; give one of "
            "these, or compute magnitudes without H."
        )
    alpha = phase_angles(alpha)
    if not isinstance(shape, (Ellipsoid, Mesh)):
        raise AttitudeError(f"shape is {shape!r}; give an attitude.shape Ellipsoid or Mesh.")
    seeliger, lambert = weights
    observer = np.stack([np.sin(alpha), np.zeros_like(alpha), np.cos(alpha)], axis=-1)
    one = brightness_of(Ellipsoid(np.ones(3)), LommelSeeliger(), [0.0, 0.0, 1.0], observer)
    other = 2.0 / 3.0 * (np.sin(alpha) + (np.pi - alpha) * np.cos(alpha))
    sphere = seeliger * 4.0 * np.pi * one + lambert * np.maximum(other, 0.0)
    return law.phase(alpha) * shape.area / (4.0 * np.pi) * sphere


def phased_magnitude(
    brightness: Reals,
    shape: Ellipsoid | Mesh,
    law: str | Law,
    alpha: Reals,
    function: Callable[[FloatArray], FloatArray],
) -> FloatArray:
    """Reduced magnitudes whose mean over all orientations follows a phase function.

    Parameters
    ----------
    brightness : (...) array_like
        Brightness of the shape under the law, m2/sr.  Size and albedo cancel in the result.
    shape, law, alpha : as in `mean_brightness`
    function : callable
        Reduced magnitude at phase angles in rad, such as
        ``lambda alpha: scattering.hg(alpha, 19.09, 0.24)``.

    Returns
    -------
    (...) array
        ``function(alpha) - 2.5 log10(brightness / mean_brightness)``; inf where the brightness
        is 0.

    Raises
    ------
    AttitudeError
        For brightness that is negative or not finite, shapes that do not broadcast, a function
        that returns other than one finite number for each angle, and as `mean_brightness`.
    """
    brightness = validation.real(brightness, "brightness", unit="m2/sr")
    if np.any(brightness < 0.0):
        raise AttitudeError(f"brightness holds {np.min(brightness)}; it must not be negative.")
    alpha = validation.real(alpha, "alpha", unit="rad")
    brightness, alpha = validation.together(brightness=brightness, alpha=alpha)
    if not callable(function):
        raise AttitudeError(
            f"function is {validation.shown(function)}; give a function of the phase angle in rad."
        )
    mean = mean_brightness(shape, law, alpha)
    shown = (brightness > 0.0) & (mean > 0.0)
    ratio = np.where(shown, brightness, 1.0) / np.where(shown, mean, 1.0)
    values = validation.returned(function(alpha), "the phase function")
    values = validation.broadcast(values, "what the phase function returns", alpha.shape, "angle")
    if not np.all(np.isfinite(values[shown])):
        bad = np.argmax(shown & ~np.isfinite(values))
        raise AttitudeError(
            f"the phase function returns {values.flat[bad]} at {alpha.flat[bad]} rad; it must "
            "return finite magnitudes."
        )
    return np.where(shown, values - 2.5 * np.log10(ratio), np.inf)[()]
