"""The fraction of the Sun's disc that a body sees past another one: full light, penumbra, umbra.

The occulter is a sphere, the Earth a spheroid whose axis is the pole of ICRF (the pole of date is
0.2 degrees away in 2030); no atmosphere bends the light.  A stretch of space along that axis makes
the spheroid a sphere.  Seen from the body, the limbs of the occulter and of the Sun are small
circles on the sphere of directions, and also circles in the stereographic projection about the
centre of the Sun, for any size of the occulter: in low orbit its limb is 65 degrees from its
centre.

Sources: radii of IAU 2015 (Archinal et al., CeMDA 130, 22, 2018) and WGS84; the Sun's radius of IAU
2015 resolution B3.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from attitude import validation
from attitude.errors import AttitudeError
from attitude.paths.bodies import body_name
from attitude.physical_constants import EARTH_FLATTENING, EARTH_RADIUS_M, SUN_RADIUS_M

if TYPE_CHECKING:
    from attitude.annotations import FloatArray

# Mean radii, m; of the Earth the equatorial one.
RADII: Final[dict[str, float]] = {
    "mercury": 2.4394e6,
    "venus": 6.0518e6,
    "earth": EARTH_RADIUS_M,
    "moon": 1.7374e6,
    "mars": 3.3895e6,
    "jupiter": 6.9911e7,
    "saturn": 5.8232e7,
    "uranus": 2.5362e7,
    "neptune": 2.4622e7,
    "pluto": 1.1883e6,
}


def radius_of(body: str) -> float | None:
    """The radius of a body, or of the planet at a barycenter, in m; None if unknown."""
    return RADII.get(body.removesuffix(" barycenter"))


def occulters(given: Any) -> dict[str, float]:
    """Radii in m, by name, of the bodies that cast shadows.

    Parameters
    ----------
    given : str, int, sequence of these, or dict
        Names or NAIF numbers; a dict has radii as values, m, or None for those of `RADII`.

    Raises
    ------
    AttitudeError
        For a body whose radius is neither given nor in `RADII`.
    """
    if isinstance(given, (str, int)):
        given = (given,)
    radii = given if isinstance(given, Mapping) else dict.fromkeys(given)
    found = {}
    for body, radius in radii.items():
        name = body_name(body, "shadow_of")
        known = radius_of(name)
        if radius is not None:
            found[name] = validation.positive(radius, f"the radius of {name}", unit="m")
        elif known is None:
            raise AttitudeError(
                f"shadow_of holds {body!r}, whose radius is not known here; give it in m, as in "
                f"shadow_of={{{body!r}: 1e6}}, or one of {', '.join(RADII)}."
            )
        else:
            found[name] = known
    return found


def lit_fraction(
    to_occulter: FloatArray,
    radius: float,
    sun: FloatArray,
    sun_distance: FloatArray | None,
    *,
    flattening: float = 0.0,
) -> FloatArray:
    """The fraction (N,) of the Sun's disc that is seen past an occulter, 0 to 1.

    Parameters
    ----------
    to_occulter : (3, N) array
        From the body to the occulter's centre, m, ICRF.
    radius : float
        Equatorial radius of the occulter, m.
    sun : (3, N) or (3, 1) array
        Unit vectors from the body to the Sun, ICRF.
    sun_distance : (N,) array or None
        m; None for a Sun that is infinitely far away, a point.
    flattening : float
        Of the occulter, along the pole of ICRF.

    Raises
    ------
    AttitudeError
        If the body lies below the surface of the occulter.

    Notes
    -----
    The error is 1e-5 of the disc for a spherical occulter: the stereographic projection distorts
    the disc by that.
    """
    stretch = np.array([[1.0], [1.0], [1.0 / (1.0 - flattening)]])
    middle, sun = to_occulter * stretch, sun * stretch
    distance = np.sqrt(np.sum(middle * middle, axis=0))
    if np.any(distance <= radius):
        raise AttitudeError(
            f"the body lies {np.nanmin(distance):.6g} m from the centre of an occulter of radius "
            f"{radius:.6g} m, below its surface; give another center, or other bodies as shadow_of."
        )
    from attitude.scene.angles import between

    apart = between(middle, np.broadcast_to(sun, middle.shape))
    limb = np.arctan2(radius, np.sqrt((distance - radius) * (distance + radius)))
    if sun_distance is None:
        return np.where(np.isnan(apart), np.nan, (apart > limb) * 1.0)
    stretched = sun_distance * np.sqrt(np.sum(sun * sun, axis=0))
    disc = np.arctan2(
        SUN_RADIUS_M, np.sqrt((stretched - SUN_RADIUS_M) * (stretched + SUN_RADIUS_M))
    )
    # In the plane that touches the sphere at the Sun, the line through both centres meets the limb
    # of the occulter at these distances from the Sun.
    near = 2.0 * np.tan(0.5 * (apart - limb))
    far = 2.0 * np.tan(0.5 * np.minimum(apart + limb, np.pi - 1e-9))
    return 1.0 - _covered(2.0 * np.tan(0.5 * disc), 0.5 * (far - near), 0.5 * (far + near))


def _covered(disc, limb, apart):
    """The fraction of a circle of radius `disc` covered by one of radius `limb` `apart` away."""
    # Sixteen times the square of the triangle's area: Heron's formula.
    heron = (apart + disc + limb) * (apart - disc + limb) * (apart + disc - limb)
    sine = np.sqrt(np.maximum(heron * (disc + limb - apart), 0.0))
    at_sun = np.arctan2(sine, apart**2 + disc**2 - limb**2)
    at_limb = np.arctan2(sine, apart**2 + limb**2 - disc**2)
    lens = disc**2 * _segment(at_sun) + limb**2 * _segment(at_limb)
    share = np.where(apart >= disc + limb, 0.0, lens / (np.pi * disc**2))
    inside = apart <= np.abs(limb - disc)
    return np.where(inside, np.minimum((limb / disc) ** 2, 1.0), share)


def _segment(angle):
    """angle - sin(angle) cos(angle), without cancellation where the angle is small."""
    double = 2.0 * angle
    # The series of (x - sin x) / 2; the first omitted term is below 1.6e-15 of the sum at 0.1.
    square = double * double
    series = 1.0 - square / 20.0 * (1.0 - square / 42.0 * (1.0 - square / 72.0))
    small = double * square / 12.0 * series
    return np.where(np.abs(double) < 0.1, small, 0.5 * (double - np.sin(double)))


def flattening_of(body: str, radius: float) -> float:
    """The flattening of an occulter: the Earth's if its radius is that of `RADII`, otherwise 0."""
    return EARTH_FLATTENING if body == "earth" and radius == RADII["earth"] else 0.0
