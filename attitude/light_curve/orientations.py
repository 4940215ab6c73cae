"""The mean over all orientations, by which a phase function of an asteroid gives magnitudes.

H, G and H, G1, G2 describe an asteroid by one number a phase angle; shape and law say how it varies
about that.  In the mean over all orientations each facet of a convex body looks everywhere alike,
so that the body is as bright as a sphere of the same surface.
"""

import numpy as np

from attitude import validation
from attitude.errors import AttitudeError
from attitude.light_curve.brightness import brightness as brightness_of
from attitude.scattering import LommelSeeliger
from attitude.scattering import law as known_law
from attitude.scattering.parameters import together
from attitude.shape import Ellipsoid, Mesh


def mean_brightness(shape, law, alpha):
    """Brightness of a convex body in the mean over all orientations, m2/sr, in closed form.

    Parameters
    ----------
    shape : Ellipsoid or Mesh
        Of one that shades itself the mean without shadows is returned.
    law : str or Law
        Lambert, Lommel-Seeliger, or both: those that are a phase function times
        mu0 mu [a / (mu0 + mu) + b].
    alpha : (...) array_like
        Phase angle, rad, 0 to pi.

    Notes
    -----
    The surface over 4 pi times what a sphere of radius 1 sends: Muinonen & Lumme, A&A 584, A23,
    2015, for the first term, (2/3) [sin alpha + (pi - alpha) cos alpha] for the second.

    >>> round(1.5 * mean_brightness(Ellipsoid((1, 1, 1)), "lambert", 0.0), 12)
    np.float64(1.0)
    """
    law = known_law(law)
    if law.weights is None:
        raise AttitudeError(
            f"the mean over all orientations is known for Lambert's and Lommel-Seeliger's laws, "
            f"not for {law!r}; it has a phase function of its own, so ask for magnitudes without H."
        )
    alpha = validation.real(alpha, "alpha", unit="rad")
    if not np.all((alpha >= 0.0) & (alpha <= np.pi)):
        raise AttitudeError("alpha must lie from 0 to pi rad.")
    if not isinstance(shape, (Ellipsoid, Mesh)):
        raise AttitudeError(f"shape is {shape!r}; give an attitude.shape Ellipsoid or Mesh.")
    seeliger, lambert = law.weights
    observer = np.stack([np.sin(alpha), np.zeros_like(alpha), np.cos(alpha)], axis=-1)
    one = brightness_of(Ellipsoid((1, 1, 1)), LommelSeeliger(), [0.0, 0.0, 1.0], observer)
    other = 2.0 / 3.0 * (np.sin(alpha) + (np.pi - alpha) * np.cos(alpha))
    sphere = seeliger * 4.0 * np.pi * one + lambert * np.maximum(other, 0.0)
    return law.phase(alpha) * shape.area / (4.0 * np.pi) * sphere


def phased_magnitude(brightness, shape, law, alpha, function):
    """Reduced magnitudes that follow a phase function in the mean over all orientations.

    Parameters
    ----------
    brightness : (...) array_like
        m2/sr, of the shape under the law; neither its size nor its albedo enters the result.
    shape, law, alpha : as of `mean_brightness`
    function : callable
        Reduced magnitude at phase angles in rad, such as
        ``lambda alpha: scattering.hg(alpha, 19.09, 0.24)``.

    Returns
    -------
    (...) array
        ``function(alpha) - 2.5 log10(brightness / mean_brightness)``; inf where the body shows
        nothing.
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
