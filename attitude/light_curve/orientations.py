"""The mean brightness over all orientations, which relates phase functions to shapes.

H, G and H, G1, G2 give one magnitude for each phase angle; shape and law give the variation about
it.  In the mean over all orientations every facet of a convex body contributes alike, so that the
body is as bright as a sphere of the same surface area.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from attitude import validation
from attitude.errors import AttitudeError
from attitude.light_curve.brightness import brightness as brightness_of
from attitude.scattering import Law, LommelSeeliger
from attitude.scattering import law as known_law
from attitude.scattering.parameters import together
from attitude.shape import Ellipsoid, Mesh

if TYPE_CHECKING:
    from collections.abc import Callable

    from attitude.annotations import FloatArray, Reals


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
    alpha = validation.real(alpha, "alpha", unit="rad")
    if not np.all((alpha >= 0.0) & (alpha <= np.pi)):
        raise AttitudeError("alpha must lie from 0 to pi rad.")
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
    shape, law, alpha : as of `mean_brightness`
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
        For brightness that is negative or not finite, shapes that do not broadcast, and as
        `mean_brightness`.
    """
    brightness = validation.real(brightness, "brightness", unit="m2/sr")
    if np.any(brightness < 0.0):
        raise AttitudeError(f"brightness holds {np.min(brightness)}; it must not be negative.")
    alpha = validation.real(alpha, "alpha", unit="rad")
    brightness, alpha = together(brightness=brightness, alpha=alpha)
    mean = mean_brightness(shape, law, alpha)
    shown = (brightness > 0.0) & (mean > 0.0)
    ratio = np.where(shown, brightness, 1.0) / np.where(shown, mean, 1.0)
    return np.where(shown, function(alpha) - 2.5 * np.log10(ratio), np.inf)[()]
