"""What rounded coordinates, such as those of a text file, leave uncertain of a surface."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Iterable

    from attitude.annotations import FloatArray

_NUMBER = re.compile(r"[+-]?(\d*)(?:\.(\d*))?(?:[eEdD]([+-]?\d+))?")


def of_printed(fields: Iterable[str]) -> float:
    """Half a unit of the last digit of printed coordinates, from those with the most digits.

    Zeros at the end of others may have been left out.  Of several such coordinates, as printed
    with a fixed number of significant digits, the largest.

    >>> of_printed(["0.5", "-1.250000", "0.000125"])
    5e-07
    """
    most, unit = 0, 0.0
    for field in fields:
        found = _NUMBER.fullmatch(field)
        if found is None:
            continue
        whole, part, power = found[1], found[2] or "", int(found[3] or 0)
        digits = len((whole + part).lstrip("0"))
        here = 10.0 ** (power - len(part))
        if digits > most:
            most, unit = digits, here
        elif digits == most > 0:
            unit = max(unit, here)
    return 0.5 * unit


def of_single_precision(coordinates: FloatArray) -> float:
    """Half a unit of the last place of the largest coordinate, if all are floats of 32 bits."""
    single = coordinates.astype(np.float32)
    if not np.array_equal(single, coordinates):
        return 0.0
    return 0.5 * float(np.spacing(np.max(np.abs(single))))


def height_errors(corners: FloatArray, points: FloatArray, rounding: float) -> FloatArray:
    """How much heights (K,) of points (K, 3) above the planes of facets (K, 3, 3) may err, m.

    With coordinates that err by `rounding` each.  The height is a sum of the errors of the point
    and of the corners, whose factors are the coordinates of its foot in terms of the corners; they
    are large for a point far from a narrow facet.
    """
    a, b, c = np.moveaxis(corners, 1, 0)
    normal = np.cross(b - a, c - a)
    square = np.sum(normal * normal, axis=-1)
    share_b = np.sum(np.cross(points - a, c - a) * normal, axis=-1) / square
    share_c = np.sum(np.cross(b - a, points - a) * normal, axis=-1) / square
    factors = 1.0 + np.abs(1.0 - share_b - share_c) + np.abs(share_b) + np.abs(share_c)
    found: FloatArray = np.sqrt(3.0) * rounding * factors
    return found
