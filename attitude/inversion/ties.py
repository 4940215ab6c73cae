"""What `moments=` says: the moments of the motion are free, those of the shape, or given."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING, cast

import numpy as np

from attitude import validation
from attitude.body import Body
from attitude.errors import AttitudeError
from attitude.inversion.convex import Tie

if TYPE_CHECKING:
    from collections.abc import Sequence

    from attitude.annotations import FloatArray
    from attitude.inversion.moving import MovingPoint


def of(moments: str | float | Body | Sequence[float]) -> Tie:
    """The tie of "shape", "free", a tolerance, three principal moments or a Body.

    Raises
    ------
    AttitudeError
        For anything else, moments of no body, and a moment of zero.
    """
    if isinstance(moments, str):
        if moments not in ("shape", "free"):
            raise AttitudeError(
                f'moments is {moments!r}; give "shape", "free", a tolerance, three moments or a '
                "Body."
            )
        return Tie() if moments == "shape" else Tie(math.inf)
    if isinstance(moments, Body):
        known = moments
    elif np.ndim(moments) == 0:
        return Tie(validation.positive(cast("float", moments), "moments"))
    else:
        known = Body(moments=moments, relative=True)
    ordered = np.sort(known.moments)
    if ordered[0] <= 0.0:
        raise AttitudeError("moments has one of zero; a light curve is that of a body with width.")
    return Tie(given=ordered / ordered[2])


def with_moments(point: MovingPoint, given: FloatArray) -> MovingPoint:
    """The point with given moments (3,), ascending, in the order of those that it has."""
    order = np.argsort(np.argsort(point.body.moments))
    scaled = given[order] * (float(point.body.moments.max()) / given[2])
    body = Body(moments=scaled, relative=point.body.relative, mass=point.body.mass)
    return replace(point, body=body)
