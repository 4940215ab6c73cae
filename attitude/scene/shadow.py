"""The fraction of the Sun's disc that a body sees past another one: full light, penumbra, umbra.

The occulter is a sphere, the Earth a spheroid whose axis is the pole of ICRF (the pole of date is
0.2 degrees away in 2030); no atmosphere bends the light.  A stretch of space along that axis makes
the spheroid a sphere.  `attitude.scene.discs` has the
outlines of the Sun and of the occulter on the sky.

Sources: radii of IAU 2015 (Archinal et al., CeMDA 130, 22, 2018) and WGS84; the Sun's radius of IAU
2015 resolution B3.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from attitude import validation
from attitude.errors import AttitudeError
from attitude.paths.bodies import body_name
from attitude.physical_constants import (
    EARTH_FLATTENING,
    EARTH_RADIUS_M,
    SPEED_OF_LIGHT_M_S,
    SUN_RADIUS_M,
)
from attitude.scene import discs

if TYPE_CHECKING:
    from attitude.annotations import BoolArray, FloatArray

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

# Largest angle, rad, by which the motion of an occulter during the light time shifts it: planets
# move by up to 2e-4 of the speed of light.
_FASTEST = 1e-3


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
    velocity: Callable[[BoolArray], FloatArray] | None = None,
) -> FloatArray:
    """The fraction (N,) of the Sun's disc that is seen past an occulter, 0 to 1.

    Parameters
    ----------
    to_occulter : (3, N) array
        From the body to the occulter's centre when light left it towards the body, m, ICRF.
    radius : float
        Equatorial radius of the occulter, m.
    sun : (3, N) or (3, 1) array
        Unit vectors from the body to the Sun, ICRF.
    sun_distance : (N,) array or None
        m; None for a Sun that is infinitely far away, a point.
    flattening : float
        Of the occulter, along the pole of ICRF.
    velocity : function, optional
        Of a mask (N,): barycentric velocities (3, K) of the occulter in m/s, ICRF, at the epochs
        that it marks.  None for an occulter at rest, as in a scene without light times.

    Raises
    ------
    AttitudeError
        If the body lies below the surface of the occulter.

    Notes
    -----
    The fraction is that of the solid angle, to 1e-9.

    A ray that arrives from the direction n was s n from the body s / c before, when the occulter
    was at its present place less v s / c: it meets the occulter where the ray along n + v / c meets
    the occulter at rest at its present place.  So each point of the limb is taken at the epoch at
    which the light passed it.
    """
    sun = np.broadcast_to(sun, to_occulter.shape)
    limb, apart = _limb_and_distance(to_occulter, radius, sun, flattening)
    if sun_distance is None:
        return np.where(np.isnan(apart), np.nan, (apart > limb) * 1.0)
    disc = _angular_radius(SUN_RADIUS_M, sun_distance)
    # The stretch and the velocity change these angles by less.
    margin = 2.0 * flattening * disc + (0.0 if velocity is None else _FASTEST)
    found = np.where(np.isnan(apart), np.nan, (apart > limb) * 1.0)
    near = np.abs(apart - limb) < disc + margin
    if np.any(near):
        center, seen, far = to_occulter[:, near], sun[:, near], sun_distance[near]
        if velocity is not None:
            shift = velocity(near) / SPEED_OF_LIGHT_M_S
            center = center + shift * np.sqrt(np.sum(center * center, axis=0))
            seen = seen + shift
        size = np.sqrt(np.sum(seen * seen, axis=0))
        found[near] = discs.free_share(
            center,
            radius,
            seen / size,
            _angular_radius(SUN_RADIUS_M, far * size),
            1.0 / (1.0 - flattening),
        )
    return found


def _limb_and_distance(
    to_occulter: FloatArray, radius: float, sun: FloatArray, flattening: float
) -> tuple[FloatArray, FloatArray]:
    """Angular radius of the occulter and angle from its centre to the Sun, in stretched space."""
    from attitude.scene.angles import between

    stretch = np.array([[1.0], [1.0], [1.0 / (1.0 - flattening)]])
    middle = to_occulter * stretch
    distance = np.sqrt(np.sum(middle * middle, axis=0))
    if np.any(distance <= radius):
        raise AttitudeError(
            f"the body lies {np.nanmin(distance):.6g} m from the centre of an occulter of radius "
            f"{radius:.6g} m, below its surface; give another center, or other bodies as shadow_of."
        )
    return _angular_radius(radius, distance), between(middle, sun * stretch)


def _angular_radius(radius: float, distance: FloatArray) -> FloatArray:
    """The angular radius of a sphere, rad."""
    found: FloatArray = np.arctan2(radius, np.sqrt((distance - radius) * (distance + radius)))
    return found


def flattening_of(body: str, radius: float) -> float:
    """The flattening of an occulter: the Earth's if its radius is that of `RADII`, otherwise 0."""
    return EARTH_FLATTENING if body == "earth" and radius == RADII["earth"] else 0.0
