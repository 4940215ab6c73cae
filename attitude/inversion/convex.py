"""Magnitudes of a convex body of `facets`, with derivatives, and what its shape has to satisfy.

The parameters of a shape are two of an ellipsoid and the coefficients of the modes of the areas.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from attitude.inversion import facets
from attitude.inversion.facet_sums import shares

if TYPE_CHECKING:
    from attitude.annotations import FloatArray

# Share of Lambert's law in the scattering, to that of Lommel and Seeliger.
LAMBERT = 0.1
# Parameters of the ellipsoid, and of a shape.
ELLIPSOID = 2
SIZE = ELLIPSOID + facets.MODES
# Standard deviations of the logarithms of the squared ratios of axes of the ellipsoid, and of the
# coefficients of the modes.
_RATIOS, _MODES = 1.5, 1.0
# The same about one axis, those of bodies that are known: there many poles fit equally well with a
# shape of their own, and wide priors prefer those from which least of the shape is seen.
_AXIAL_RATIOS, _AXIAL_MODES = 0.9, 0.5
# That of the logarithms of ratios of moments that are given.
_GIVEN = 0.003
_MAGNITUDE = -2.5 / math.log(10.0)


class BodyLight(NamedTuple):
    """Magnitudes (N,) of a body seen from given directions, and their derivatives.

    across (N, 3): by a turn of the body, rad, over its own axes; by_shape (SIZE, N); areas (F,)
    and the slopes (F, SIZE) of their logarithms.
    """

    magnitude: FloatArray
    across: FloatArray
    by_shape: FloatArray
    areas: FloatArray
    slopes: FloatArray


@dataclass(frozen=True, eq=False)
class Tie:
    """What the moments of the motion agree with.

    Attributes
    ----------
    tolerance : float
        Standard deviation of the logarithms of their ratios from those of the homogeneous shape;
        infinite: any moments.
    given : (3,) array, optional
        Moments, ascending, in place of those of the shape.
    """

    tolerance: float = facets.TOLERANCE
    given: FloatArray | None = None

    @property
    def holds_axes(self) -> bool:
        """Whether the principal axes of the shape are those of the motion."""
        return self.given is not None or math.isfinite(self.tolerance)


class MotionMoments(NamedTuple):
    """ln I1/I3 and ln I2/I3 of a motion, their slopes (2, M) by its M parameters, and its mode.

    is_swapped: I1 and I2 are exchanged against an order in which I1 is farthest from I3.
    """

    log_ratios: FloatArray
    slopes: FloatArray
    is_long_axis: bool
    is_swapped: bool


def magnitudes(sun: FloatArray, observer: FloatArray, shape: FloatArray) -> BodyLight:
    """The magnitudes of a shape (SIZE,) seen from unit vectors (N, 3) over its axes."""
    count = len(sun)
    area, slopes = facets.areas(shape[:ELLIPSOID], shape[ELLIPSOID:])
    parts, by = np.empty((count, facets.COUNT)), np.empty((count, 6))
    shares(sun, observer, facets.sphere().normals, area, LAMBERT, parts, by)
    total = np.maximum(parts.sum(axis=1), 1e-12)
    factor = _MAGNITUDE / total
    across = (np.cross(by[:, :3], sun) + np.cross(by[:, 3:], observer)) * factor[:, None]
    parts *= factor[:, None]
    return BodyLight(_MAGNITUDE * np.log(total), across, (parts @ slopes).T, area, slopes)


def penalties(
    shape: FloatArray,
    areas: FloatArray,
    slopes: FloatArray,
    moments: MotionMoments | None,
    motion: int,
    tie: Tie,
) -> tuple[FloatArray, FloatArray, float]:
    """Residuals of all priors (R,), their derivatives (R, motion + SIZE), and the strain.

    Parameters
    ----------
    shape : (SIZE,) array
    areas, slopes
        As of `BodyLight`.
    moments : MotionMoments or None
        None for rotation about the third axis, which is then that of the greatest moment.
    motion : int
        Parameters of the motion, before those of the shape.
    tie : Tie
    """
    held = facets.constraints(shape[:ELLIPSOID], areas, slopes)
    count, size = 8 + SIZE, motion + SIZE
    r, by = np.zeros(count), np.zeros((count, size))
    r[:3], by[:3, motion:] = held.closure, held.by_closure
    strain = 0.0
    if tie.holds_axes:
        r[3:6], by[3:6, motion:] = held.turn, held.by_turn
        if moments is None:
            above = held.log_ratios > 0.0
            width = min(tie.tolerance, facets.TOLERANCE)
            r[6:8] = np.where(above, held.log_ratios, 0.0) / width
            by[6:8, motion:] = np.where(above[:, None], held.by_ratios, 0.0) / width
        elif tie.given is not None:
            r[6:8] = (moments.log_ratios - wanted(tie.given, moments)) / _GIVEN
            by[6:8, :motion] = moments.slopes / _GIVEN
        else:
            r[6:8] = (moments.log_ratios - held.log_ratios) / tie.tolerance
            by[6:8, :motion] = moments.slopes / tie.tolerance
            by[6:8, motion:] = -held.by_ratios / tie.tolerance
        strain = float(r[3:8] @ r[3:8])
    wide = widths(moments is None)
    r[8:] = shape / wide
    by[range(8, count), range(motion, size)] = 1.0 / wide
    return r, by, strain


def widths(is_axial: bool) -> FloatArray:
    """Standard deviations (SIZE,) of the parameters of a shape before the curve is seen."""
    ratios, modes = (_AXIAL_RATIOS, _AXIAL_MODES) if is_axial else (_RATIOS, _MODES)
    found = np.full(SIZE, modes)
    found[:ELLIPSOID] = ratios
    return found


def wanted(given: FloatArray, moments: MotionMoments) -> FloatArray:
    """ln I1/I3 and ln I2/I3 (2,) of given ascending moments over the axes of a motion."""
    third, first = (given[0], given[2]) if moments.is_long_axis else (given[2], given[0])
    both = np.log(np.array([first, given[1]]) / third)
    return both[::-1] if moments.is_swapped else both
