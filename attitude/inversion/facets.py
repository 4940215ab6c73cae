"""A convex body as areas of facets of given normals: an ellipsoid times a smooth random factor.

The logarithm of the factor is a Gaussian process on the sphere of normals, of which the largest
modes are kept: areas are positive, smooth where the data say nothing, and a prior follows.  The
moments of inertia of the homogeneous body are those of the ellipsoid with the same surface tensor,
the integral of n n^T over the surface: for convex hulls with planed faces to 2 % (one standard
deviation of ln I1/I3; the axes to 1 degree), see benchmarks/inversion.py.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from attitude.annotations import FloatArray

COUNT, MODES = 260, 90
# Standard deviation of the logarithm of an area, and its correlation length, rad.
_AMPLITUDE, _LENGTH = 1.0, 0.35
# Largest residual of the closure, |sum of a n| / sum of a: one standard deviation.
_CLOSURE = 0.01
# Standard deviations of ln I1/I3 and ln I2/I3 of the motion from those of the homogeneous shape.
TOLERANCE = 0.05
# Turn of the axes of the shape against those of the motion, rad; least relative split of axes.
_TURN, _SPLIT = 0.07, 0.02


@dataclass(frozen=True, eq=False)
class Sphere:
    """Normals (3, F), their squares, and modes (F, M) of the logarithm of the areas."""

    normals: FloatArray
    squares: FloatArray
    modes: FloatArray


@cache
def sphere() -> Sphere:
    """The normals and modes of all bodies."""
    k = np.arange(COUNT) + 0.5
    z = 1.0 - 2.0 * k / COUNT
    angle, r = math.pi * (1.0 + math.sqrt(5.0)) * k, np.sqrt(1.0 - z * z)
    normals = np.ascontiguousarray(np.stack([r * np.cos(angle), r * np.sin(angle), z]))
    kernel = _AMPLITUDE**2 * np.exp((normals.T @ normals - 1.0) / _LENGTH**2)
    values, vectors = np.linalg.eigh(kernel)
    modes = vectors[:, ::-1][:, :MODES] * np.sqrt(values[::-1][:MODES])
    # the sign of an eigenvector depends on the library of linear algebra
    modes *= np.sign(modes[np.argmax(np.abs(modes), axis=0), np.arange(MODES)])
    return Sphere(normals, normals**2, np.ascontiguousarray(modes))


def areas(flat: FloatArray, modes: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Areas (F,), the largest being 1, and slopes (F, 2 + M) of their logarithms.

    Parameters
    ----------
    flat : (2,) array
        ln (c/a)^2, ln (c/b)^2 of the ellipsoid.
    modes : (M,) array
        Coefficients of the modes; their prior is standard normal.
    """
    on = sphere()
    axes = np.array([math.exp(-flat[0]), math.exp(-flat[1]), 1.0])
    across = axes @ on.squares
    log_areas = on.modes @ modes - 2.0 * np.log(across)
    slopes = np.concatenate([(2.0 * axes[:2, None] * on.squares[:2] / across).T, on.modes], axis=1)
    return np.exp(log_areas - log_areas.max()), slopes


def _of_ellipsoid(flat: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Logarithms (2,) of ratios of the surface tensor of an ellipsoid, and slopes (2, 2)."""
    on = sphere()
    axes = np.array([math.exp(-flat[0]), math.exp(-flat[1]), 1.0])
    across = axes @ on.squares
    weights = across**-2.0
    tensor = on.squares @ weights
    rise = 2.0 * axes[:2, None] * on.squares[:2] / across * weights  # (2, F)
    by_flat = on.squares @ rise.T  # (3, 2)
    relative = by_flat / tensor[:, None]
    slopes: FloatArray = relative[:2] - relative[2]
    return np.log(tensor[:2] / tensor[2]), slopes


def equivalent(tensor: FloatArray, start: FloatArray) -> tuple[FloatArray, FloatArray]:
    """The ellipsoid (2,) with the diagonal of a surface tensor (3, 3), and slopes (2, 2) by its
    logarithms of ratios."""
    wanted = np.log(np.diag(tensor)[:2] / tensor[2, 2])
    flat = np.clip(start, -4.0, 4.0)
    for _ in range(30):
        value, slope = _of_ellipsoid(flat)
        step = np.linalg.solve(slope, wanted - value)
        flat = np.clip(flat + np.clip(step, -1.0, 1.0), -6.0, 6.0)
        if np.abs(step).max() < 1e-9:
            break
    return flat, np.asarray(np.linalg.inv(slope), dtype=np.float64)


@dataclass(frozen=True, eq=False)
class Constraints:
    """Residuals of a shape, in standard deviations, and their slopes by its parameters (2 + M).

    Attributes
    ----------
    closure, turn : (3,) arrays
        Of the closure, and of the directions of its principal axes.
    by_closure, by_turn : (3, 2 + M) arrays
    log_ratios : (2,) array
        ln I1/I3 and ln I2/I3 of the homogeneous body.
    by_ratios : (2, 2 + M) array
    """

    closure: FloatArray
    by_closure: FloatArray
    turn: FloatArray
    by_turn: FloatArray
    log_ratios: FloatArray
    by_ratios: FloatArray


def constraints(flat: FloatArray, area: FloatArray, slopes: FloatArray) -> Constraints:
    """What a shape has to satisfy; arguments as of and from `areas`."""
    n = sphere().normals
    share = area / area.sum()
    offset = n @ share
    by_closure = ((n - offset[:, None]) * share) @ slopes
    tensor = (n * share) @ n.T
    found, by_ratio = equivalent(tensor, flat)
    inner = (n**2 / np.diag(tensor)[:, None]) * share
    by_flat = by_ratio @ ((inner[:2] - inner[2]) @ slopes)
    a, b = np.exp(-found)
    ratios = np.array([math.log((b + 1.0) / (a + b)), math.log((a + 1.0) / (a + b))])
    chain = np.array(
        [[a / (a + b), b / (a + b) - b / (b + 1.0)], [a / (a + b) - a / (a + 1.0), b / (a + b)]]
    )
    i, j = np.array([0, 0, 1]), np.array([1, 2, 2])
    size = _TURN * np.hypot(np.diag(tensor)[i] - np.diag(tensor)[j], _SPLIT)
    off = tensor[i, j]
    by_turn = ((n[i] * n[j] - off[:, None]) * share) @ slopes
    return Constraints(
        offset / _CLOSURE,
        by_closure / _CLOSURE,
        off / size,
        by_turn / size[:, None],
        ratios,
        chain @ by_flat,
    )
