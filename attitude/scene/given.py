"""What a Scene is given, checked: places, a shape, shadows, times."""

from __future__ import annotations

import datetime
from typing import TYPE_CHECKING, Any

import numpy as np

from attitude import paths, validation
from attitude.errors import AttitudeError
from attitude.paths.bodies import body_name, naif_index
from attitude.paths.composed import NamedBody
from attitude.paths.foreign import place_of
from attitude.paths.place import Place

if TYPE_CHECKING:
    from attitude.light_curve import Visibility
    from attitude.paths import Ephemeris
    from attitude.scattering import Law
    from attitude.shape import Ellipsoid, Mesh


def refuse_plain(times: Any) -> None:
    """AttitudeError for plain seconds, in a scene without a motion."""
    first = times
    while isinstance(first, (list, tuple)) and first:
        first = first[0]
    kind = getattr(getattr(first, "dtype", None), "kind", "")
    is_number = isinstance(first, (int, float)) or kind in ("f", "i", "u")
    is_duration = isinstance(first, datetime.timedelta) or kind == "m"
    if is_number or is_duration or type(first).__name__ == "TimeDelta":
        raise AttitudeError(
            "times are plain seconds, but a scene without a motion has no epoch to count them "
            "from; give dates: ISO text in UTC, astropy or skyfield Times, datetimes."
        )


def place(
    value: Any, name: str, ephemeris: Ephemeris | None, *, is_direction_allowed: bool = False
) -> Place:
    """The path or direction given, that of astropy or skyfield, or of a body by name or number."""
    foreign = None if isinstance(value, (Place, str, list, tuple)) else place_of(value, name)
    value = value if foreign is None else foreign
    if isinstance(value, Place):
        if is_direction_allowed or not value.is_direction:
            return value
        raise AttitudeError(
            f"{name} is {value!r}, infinitely far away; give a path or a body, or None where Sun "
            "and observer are directions."
        )
    if isinstance(value, (list, tuple, np.ndarray)) and is_direction_allowed:
        return paths.direction(value, name=name)
    if isinstance(value, str) or naif_index(value) is not None:
        return NamedBody(body_name(value, name), ephemeris)
    raise AttitudeError(
        f"{name} is {type(value).__name__}; give the name of a body, a path of attitude.paths"
        + (", or a direction (x, y, z) in ICRF." if is_direction_allowed else ".")
    )


def known_shape(shape: Any) -> Ellipsoid | Mesh | None:
    """The shape itself; AttitudeError for anything else."""
    if shape is None:
        return None
    from attitude.shape import Ellipsoid, Mesh

    if not isinstance(shape, (Ellipsoid, Mesh)):
        raise AttitudeError(
            f"shape is {type(shape).__name__}; give an Ellipsoid or Mesh of attitude.shape."
        )
    return shape


def known_shadows(shadows: Any) -> bool | Visibility:
    """True, False or a Visibility, which is loaded only if one is given."""
    if isinstance(shadows, (bool, np.bool_)):
        return bool(shadows)
    from attitude.light_curve import Visibility

    if not isinstance(shadows, Visibility):
        raise AttitudeError(
            f"shadows is {validation.shown(shadows)}; give True, False or a Visibility."
        )
    return shadows


def check_surface(shape: Ellipsoid | Mesh | None, law: Law) -> None:
    """AttitudeError for facets whose material the law does not have."""
    if shape is None:
        return
    from attitude.shape import Mesh

    if isinstance(shape, Mesh):
        law.rows(shape.materials)
