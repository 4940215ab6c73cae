"""Shapes for the inversion: convex bodies by areas of facets, and given meshes.

A convex body is an ellipsoid times a smooth random factor of the areas of facets of given normals.
The logarithm of the factor is a Gaussian process on the sphere of normals, of which the largest
modes are kept: areas are positive, smooth where the data say nothing, and a prior follows.  The
moments of inertia of the homogeneous body are those of the ellipsoid with the same surface tensor,
the integral of n n^T over the surface: for convex hulls with planed faces to 2 % (one standard
deviation of ln I1/I3; the axes to 1 degree), see benchmarks/inversion.py.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import cache, cached_property
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from attitude._compilation.decorators import reduction, reduction_subroutine, reduction_within
from attitude._compilation.simd import at_least, chosen, every, put_eight
from attitude._support.constants import MAGNITUDES_PER_E
from attitude.errors import AttitudeError
from attitude.inversion._motions import LANES, three
from attitude.light_curve._brightness import BLOCK, components, kernel_of, paired, with_phase
from attitude.scattering._law import law as known_law
from attitude.scattering._weighted import LommelSeeligerLambert
from attitude.shape._mesh import Mesh

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from attitude._support.annotations import BoolArray, FloatArray, IntArray
    from attitude.scattering._law import Law


# Facets of a convex body in one octant, by rings of equal distances from the pole outwards.
_RINGS = (1, 2, 4, 5, 6, 7, 7)
_OCTANT = sum(_RINGS)
# The octants: signs of the coordinates, opposite ones four apart.
_SIGNS = np.array([(1, 1, 1), (1, 1, -1), (1, -1, 1), (-1, 1, 1)])
_SIGNS = np.concatenate([_SIGNS, -_SIGNS])
# Parities of functions of the normals: whether they change sign with each coordinate.  The first
# four are even under inversion.
_ODD = np.array([(0, 0, 0), (1, 1, 0), (1, 0, 1), (0, 1, 1)])
_ODD = np.concatenate([_ODD, 1 - _ODD])
# The sign (8, 8) of a function of each parity in each octant, over that in the first.
_IN_OCTANTS = np.prod(np.where(_ODD[:, None] == 1, _SIGNS, 1.0), axis=-1)
# All facets.
COUNT = len(_SIGNS) * _OCTANT
# Modes of the logarithms of their areas.
MODES = 90
# Standard deviation of the logarithm of an area.
_AMPLITUDE = 1.0
# Its correlation length, rad.
_LENGTH = 0.35
# Largest residual of the closure, |sum of a n| / sum of a: one standard deviation.
_CLOSURE = 0.01
# Standard deviations of ln I1/I3 and ln I2/I3 of the motion from those of the homogeneous shape.
TOLERANCE = 0.05
# Of a concave body the least moment is smaller than that of its convex one: beyond so many of these
# the square grows as the difference.  Of 24 bodies with shapes by radar and spacecraft they are 1
# to 5, once 11, for the ten that are elongated, below 1 for the others.
_CONCAVE = 1.5
# Logarithm of the largest moment over the sum of the others above which a motion is held back: of a
# needle of ten to one it is -0.02, and no body has more than 0.
_FLATTEST = -0.005
# Standard deviation of what is above.
_BEYOND = 0.001
# Turn of the axes of the shape against those of the motion, rad.
_TURN = 0.07
# Least relative split of axes.
_SPLIT = 0.02
# The last step of logarithms of ratios of axes.
_CLOSE = 1e-6


def even_directions(count: int) -> FloatArray:
    """Directions (count, 3) all over the sky, evenly."""
    k = np.arange(count) + 0.5
    z = 1.0 - 2.0 * k / count
    angle, r = math.pi * (1.0 + math.sqrt(5.0)) * k, np.sqrt(1.0 - z * z)
    return np.stack([r * np.cos(angle), r * np.sin(angle), z], axis=-1)


def _octant() -> FloatArray:
    """The normals (F / 8, 3) of the first octant: each stands for an equal part of the sphere."""
    normals = []
    above = 0.0
    for count in _RINGS:
        z = 1.0 - (above + 0.5 * count) / _OCTANT
        angle = 0.5 * math.pi * (np.arange(count) + 0.5) / count
        r = np.full(count, math.sqrt(1.0 - z * z))
        normals.append(np.stack([r * np.cos(angle), r * np.sin(angle), np.full(count, z)], axis=-1))
        above += count
    return np.concatenate(normals)


@dataclass(frozen=True, eq=False)
class Modes:
    """Modes of the logarithm of the areas by parity, the largest first in each.

    of_octant: (8, K, F / 8), their values in the first octant; zero behind the last.
    places: (M,), where each of them stands among those 8 K, the largest first.
    """

    of_octant: FloatArray
    places: IntArray

    @cached_property
    def of_facets(self) -> FloatArray:
        """Their values (F, M)."""
        of_octants = self.of_octant[:, :, None] * _IN_OCTANTS[:, None, :, None]
        return np.ascontiguousarray(of_octants.reshape(-1, COUNT)[self.places].T)

    @cached_property
    def is_odd(self) -> BoolArray:
        """Which of them (M,) change sign under inversion."""
        return self.places >= 4 * self.of_octant.shape[1]

    def sums(self, by_parity: FloatArray) -> FloatArray:
        """Sums (M, N) over facets of each mode times functions (8, F / 8, N), as `by_parity`."""
        return (self.of_octant @ by_parity).reshape(-1, by_parity.shape[-1])[self.places]


def by_parity(of_facets: FloatArray) -> FloatArray:
    """The parts (8, F / 8, N) of each parity, summed over the octants, of functions (N, F)."""
    of_octants = of_facets.reshape(len(of_facets), len(_SIGNS), _OCTANT)
    return (_IN_OCTANTS @ of_octants).transpose(1, 2, 0)


@dataclass(frozen=True, eq=False)
class Sphere:
    """Normals (3, F), octant by octant, those (3, F / 8) of the first, and squares of all."""

    normals: FloatArray
    octant: FloatArray
    squares: FloatArray


@cache
def sphere() -> Sphere:
    """The normals of all bodies: those of an octant and their images in the planes of the axes."""
    octant = _octant()
    normals = np.ascontiguousarray((_SIGNS[:, None] * octant).reshape(-1, 3).T)
    return Sphere(normals, np.ascontiguousarray(octant.T), normals**2)


@cache
def modes_of(count: int) -> Modes:
    """The largest modes, so many.

    Images in the planes of the axes leave the Gaussian process as it is: its modes are even or odd
    in each coordinate, and sums with them are sums over one octant.
    """
    octant = _octant()
    across = np.einsum("ij,oj,kj->oik", octant, _SIGNS, octant)
    kernel = _AMPLITUDE**2 * np.exp((across - 1.0) / _LENGTH**2)
    values, vectors = np.linalg.eigh(np.einsum("po,oik->pik", _IN_OCTANTS, kernel))
    # x and y are alike: two parities have equal modes, whose order rounding must not decide
    order = np.argsort(-np.round(values, 9), axis=None, kind="stable")[:count]
    parity, number = np.divmod(order, _OCTANT)
    rank = _OCTANT - 1 - number
    width = int(rank.max(initial=-1)) + 1
    size = np.sqrt(values / len(_SIGNS))
    of_octant = (vectors * size[:, None])[:, :, ::-1].swapaxes(1, 2)[:, :width].copy()
    # the sign of an eigenvector depends on the library of linear algebra
    largest = np.argmax(np.abs(of_octant), axis=2)[:, :, None]
    of_octant *= np.sign(np.take_along_axis(of_octant, largest, axis=2))
    return Modes(of_octant, parity * width + rank)


def inverted(modes: FloatArray) -> FloatArray:
    """The coefficients (M,) of a body whose areas are exchanged with those of opposite normals."""
    return np.where(modes_of(len(modes)).is_odd, -modes, modes) if len(modes) else modes


def areas(shape: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Areas (F,) of a shape (S,), with all modes or the largest, relative to the largest area.

    And slopes (F, 2) of their logarithms by the ellipsoid.
    """
    area, slopes = np.empty(COUNT), np.empty((COUNT, ELLIPSOID))
    modes = shape[ELLIPSOID:]
    _areas(shape, modes_of(len(modes)).of_facets, sphere().squares, area, slopes)
    return area, slopes


class Constraints(NamedTuple):
    """What a shape has to satisfy, and slopes by its parameters (2 + M).

    offsets: residuals of the closure, and of the directions of its principal axes, in standard
        deviations.
    """

    offsets: FloatArray  # (6,)
    log_ratios: FloatArray  # (2,), ln I1/I3 and ln I2/I3 of the homogeneous body
    slopes: FloatArray  # (8, 2 + M), of both


def constraints(shape: FloatArray, area: FloatArray, slopes: FloatArray) -> Constraints:
    """What a shape (S,) has to satisfy, with areas (F,) and slopes (F, 2) as from `areas`."""
    values, by_areas = np.empty(8), np.empty((8, COUNT))
    _constraints(shape[:ELLIPSOID], area, sphere().normals, values, by_areas)
    by_shape = _by_shape(by_parity(by_areas), slopes, len(shape) - ELLIPSOID)
    return Constraints(values[:6], values[6:], by_shape.T)


def _by_shape(parts: FloatArray, slopes: FloatArray, count: int) -> FloatArray:
    """Slopes (2 + M, N) by the ellipsoid and M modes, from those by ln areas, as `by_parity`."""
    return np.concatenate([slopes[:_OCTANT].T @ parts[0], modes_of(count).sums(parts)])


# ---- Magnitudes of a convex body, with derivatives, and what its shape has to satisfy
# The parameters of a shape are two of an ellipsoid and the coefficients of the modes of the areas.

# Share of Lambert's law in the scattering, to that of Lommel and Seeliger; the law, without a phase
# function.
LAMBERT = 0.1
LAW = LommelSeeligerLambert(c=LAMBERT, a=0.0, k=0.0)
# Parameters of the ellipsoid, and of a shape.
ELLIPSOID = 2
SIZE = ELLIPSOID + MODES
# Standard deviation of the logarithms of the squared ratios of axes of the ellipsoid.
_RATIOS = 1.5
# Standard deviation of the coefficients of the modes.
_MODES = 1.0
# The same about one axis, those of bodies that are known: there many poles fit equally well with a
# shape of their own, and wide priors prefer those from which least of the shape is seen.
_AXIAL_RATIOS = 0.9
_AXIAL_MODES = 0.5
# That of the logarithms of ratios of moments that are given.
_GIVEN = 0.003


@dataclass(frozen=True, eq=False)
class BodyLight:
    """Magnitudes (N,) of a body seen from given directions, and their derivatives.

    across (N, 3): by a turn of the body, rad, over its own axes.  Of a convex shape: the number of
    its modes, areas (F,) and slopes (F, 2) of their logarithms by the ellipsoid, and the light of
    facets (8, F / 8, N), as `by_parity`, and in total (N,).
    """

    magnitude: FloatArray
    across: FloatArray
    modes: int = 0
    areas: FloatArray = field(default_factory=lambda: np.zeros(0))
    slopes: FloatArray = field(default_factory=lambda: np.zeros((0, ELLIPSOID)))
    of_facets: FloatArray = field(default_factory=lambda: np.zeros((0, 0, 0)))
    total: FloatArray = field(default_factory=lambda: np.zeros(0))

    def by_shape(self, shares: FloatArray | None = None) -> FloatArray:
        """Derivatives (S, N) by the shape, none by a known one; summed with shares, if given."""
        if not len(self.areas):
            return np.zeros((0, len(self.magnitude) if shares is None else shares.shape[1]))
        # in single precision processors that round otherwise lead a search to other minima
        parts, slope = self.of_facets, -MAGNITUDES_PER_E / self.total
        if shares is None:
            return _by_shape(parts, self.slopes, self.modes) * slope
        parts = summed(parts, shares * slope.reshape(shares.shape))
        return _by_shape(parts, self.slopes, self.modes)


def summed(at_nodes: FloatArray, shares: FloatArray) -> FloatArray:
    """Sums (..., N) over K nodes of numbers (..., K N) times shares (K, N)."""
    of_nodes = at_nodes.reshape(*at_nodes.shape[:-1], *shares.shape)
    return np.asarray(np.einsum("...kn,kn->...n", of_nodes, shares), np.float64)


@dataclass(frozen=True, eq=False)
class Tie:
    """What the moments of the motion agree with.

    tolerance: standard deviation of the logarithms of their ratios from those of the homogeneous
        shape; infinite: any moments.
    is_wide: whether rotations about one axis have the prior of the shapes of tumbling bodies,
        under which they are compared with those; under their own their poles are ranked.  Several
        apparitions show a body from all sides: there the wide one holds, and is not compared.
    """

    tolerance: float = TOLERANCE
    moments: FloatArray | None = None  # (3,), ascending, in place of those of the shape
    is_wide: bool = False

    @property
    def holds_axes(self) -> bool:
        """Whether the principal axes of the shape are those of the motion."""
        return self.moments is not None or math.isfinite(self.tolerance)


class MotionMoments(NamedTuple):
    """ln I1/I3, ln I2/I3 of a motion, slopes (2, M) by its M parameters, and its mode."""

    log_ratios: FloatArray
    slopes: FloatArray
    is_long_axis: bool
    is_swapped: bool  # I1 and I2, against an order in which I1 is farthest from I3


def magnitudes(sun: FloatArray, observer: FloatArray, shape: FloatArray) -> BodyLight:
    """The magnitudes of a shape (S,) seen from unit vectors (N, 3) over its axes."""
    count = len(sun)
    area, slopes = areas(shape)
    # to whole vectors
    size = count + -count % LANES
    directions, turned = np.zeros((2, 3, size)), np.empty((3, size))
    directions[0, :, :count], directions[1, :, :count] = sun.T, observer.T
    of_facets, total = np.empty((COUNT, size)), np.empty(size)
    _light(*directions, sphere().octant, area, LAMBERT, of_facets.reshape(-1), total, turned)
    parts = of_facets.reshape(len(_ODD), _OCTANT, -1)[:, :, :count]
    total, across = total[:count], np.ascontiguousarray(turned[:, :count].T)
    modes = len(shape) - ELLIPSOID
    return BodyLight(-MAGNITUDES_PER_E * np.log(total), across, modes, area, slopes, parts, total)


class Priors(NamedTuple):
    """Residuals of priors (R,), their slopes (R, P) by all parameters, and the strain.

    Each of the parameters has a prior of its own, about zero: offsets (P,), and weights (P,), over
    their standard deviations.
    """

    residuals: FloatArray
    slopes: FloatArray
    strain: float
    offsets: FloatArray
    weights: FloatArray


def penalties(
    shape: FloatArray,
    areas: FloatArray,
    slopes: FloatArray,
    moments: MotionMoments | None,
    motion: int,
    tie: Tie,
) -> Priors:
    """The priors of a shape (S,), with all modes or fewer, behind so many parameters of motion."""
    held = constraints(shape, areas, slopes)
    size = motion + len(shape)
    r, by = np.zeros(9), np.zeros((9, size))
    of_ratios = held.slopes[6:]
    r[:3], by[:3, motion:] = held.offsets[:3], held.slopes[:3]
    strain = 0.0
    if tie.holds_axes:
        r[3:6], by[3:6, motion:] = held.offsets[3:], held.slopes[3:6]
        if moments is None:
            above = held.log_ratios > 0.0
            width = min(tie.tolerance, TOLERANCE)
            r[6:8] = np.where(above, held.log_ratios, 0.0) / width
            by[6:8, motion:] = np.where(above[:, None], of_ratios, 0.0) / width
        elif tie.moments is not None:
            r[6:8] = (moments.log_ratios - wanted(tie.moments, moments)) / _GIVEN
            by[6:8, :motion] = moments.slopes / _GIVEN
        else:
            r[6:8] = (moments.log_ratios - held.log_ratios) / tie.tolerance
            by[6:8, :motion] = moments.slopes / tie.tolerance
            by[6:8, motion:] = -of_ratios / tie.tolerance
            _allow_concave(r[6:8], by[6:8], moments)
            r[8] = _hold_back(by[8, :motion], moments)
        strain = float(r[3:] @ r[3:])
    offsets, weights = np.zeros(size), np.zeros(size)
    weights[motion:] = 1.0 / widths(moments is None and not tie.is_wide)[: len(shape)]
    offsets[motion:] = weights[motion:] * shape
    return Priors(r, by, strain, offsets, weights)


def _hold_back(by: FloatArray, moments: MotionMoments) -> float:
    """The residual, mostly 0, that holds the largest moment below the sum of others; by: slopes."""
    ratios = [*map(math.exp, moments.log_ratios.tolist()), 1.0]
    largest = ratios.index(max(ratios))
    others = sum(ratios) - ratios[largest]
    beyond = math.log(ratios[largest] / others) - _FLATTEST
    if beyond <= 0.0:
        return 0.0
    by_ratios = np.array(ratios) / -others
    by_ratios[largest] = 1.0
    by += by_ratios[:2] @ moments.slopes / _BEYOND
    return beyond / _BEYOND


def _allow_concave(r: FloatArray, by: FloatArray, moments: MotionMoments) -> None:
    """Make less of the part of two residuals (2,) and slopes (2, P) that a concave body has.

    The least moment of the motion is smaller than that of the shape.
    """
    if moments.is_long_axis:
        along = math.sqrt(0.5), math.sqrt(0.5)
    else:
        along = (0.0, -1.0) if moments.is_swapped else (-1.0, 0.0)
    size = along[0] * float(r[0]) + along[1] * float(r[1])
    if size <= _CONCAVE:
        return
    less = math.sqrt(_CONCAVE * (2.0 * size - _CONCAVE))
    by += np.outer(along, (_CONCAVE / less - 1.0) * (np.array(along) @ by))
    r += (less - size) * np.array(along)


@cache
def widths(is_axial: bool) -> FloatArray:
    """Standard deviations (SIZE,) of the parameters of a shape before the curve is seen."""
    ratios, modes = (_AXIAL_RATIOS, _AXIAL_MODES) if is_axial else (_RATIOS, _MODES)
    all_widths = np.full(SIZE, modes)
    all_widths[:ELLIPSOID] = ratios
    return all_widths


def wanted(ordered: FloatArray, moments: MotionMoments) -> FloatArray:
    """ln I1/I3 and ln I2/I3 (2,) of ascending moments over the axes of a motion."""
    third, first = (ordered[0], ordered[2]) if moments.is_long_axis else (ordered[2], ordered[0])
    both = np.log(np.array([first, ordered[1]]) / third)
    return both[::-1] if moments.is_swapped else both


# ---- Convex bodies, compiled


@reduction
def _areas(shape, modes, squares, areas, slopes):
    """What `areas` returns, into areas (F,) and slopes (F, 2).

    shape (2 + M,); modes (F, M); squares of the normals (3, F).
    """
    a, b = math.exp(-shape[0]), math.exp(-shape[1])
    largest = -math.inf
    for i in range(areas.size):
        across = a * squares[0, i] + b * squares[1, i] + squares[2, i]
        slopes[i, 0] = 2.0 * a * squares[0, i] / across
        slopes[i, 1] = 2.0 * b * squares[1, i] / across
        log_area = -2.0 * math.log(across)
        for k in range(modes.shape[1]):
            log_area += modes[i, k] * shape[2 + k]
        areas[i] = log_area
        largest = max(largest, log_area)
    for i in range(areas.size):
        areas[i] = math.exp(areas[i] - largest)


@reduction_subroutine
def _ratios_of_ellipsoid(f, g, normals):
    """Logarithms of two ratios of the surface tensor of an ellipsoid, and slopes, by rows."""
    a, b = math.exp(-f), math.exp(-g)
    p = q = r = pp = pq = qq = pr = qr = 0.0
    for i in range(normals.shape[1]):
        x, y, z = normals[0, i] ** 2, normals[1, i] ** 2, normals[2, i] ** 2
        over = 1.0 / (a * x + b * y + z)
        weight = over * over
        cube = weight * over
        p, q, r = p + weight * x, q + weight * y, r + weight * z
        pp, pq, qq = pp + cube * x * x, pq + cube * x * y, qq + cube * y * y
        pr, qr = pr + cube * x * z, qr + cube * y * z
    one, two = math.log(p / r), math.log(q / r)
    by_a, by_b = 2.0 * a, 2.0 * b
    return (
        (one, two),
        (by_a * (pp / p - pr / r), by_b * (pq / p - qr / r)),
        (by_a * (pq / q - pr / r), by_b * (qq / q - qr / r)),
    )


@reduction_subroutine
def _equivalent(one, two, f, g, normals):
    """The ellipsoid, two logarithms, with a surface tensor of given logarithms of ratios.

    From a start (f, g), and the inverse of the slopes of the logarithms, by rows.
    """
    f, g = min(max(f, -4.0), 4.0), min(max(g, -4.0), 4.0)
    fa = fb = ga = gb = 0.0
    for _ in range(30):
        (first, second), (a, b), (c, d) = _ratios_of_ellipsoid(f, g, normals)
        over = 1.0 / (a * d - b * c)
        fa, fb, ga, gb = d * over, -b * over, -c * over, a * over
        df = fa * (one - first) + fb * (two - second)
        dg = ga * (one - first) + gb * (two - second)
        df, dg = min(max(df, -1.0), 1.0), min(max(dg, -1.0), 1.0)
        f, g = min(max(f + df, -6.0), 6.0), min(max(g + dg, -6.0), 6.0)
        # the error after a step is of the order of its square
        if max(abs(df), abs(dg)) < _CLOSE:
            break
    return f, g, (fa, fb), (ga, gb)


@reduction
def _constraints(flat, areas, normals, values, by_areas):
    """`Constraints` less slopes into values (8,); slopes by ln areas (F,) into by_areas (8, F)."""
    total = 0.0
    x = y = z = xx = yy = zz = xy = xz = yz = 0.0
    for i in range(areas.size):
        u, v, w, area = normals[0, i], normals[1, i], normals[2, i], areas[i]
        total += area
        x, y, z = x + area * u, y + area * v, z + area * w
        xx, yy, zz = xx + area * u * u, yy + area * v * v, zz + area * w * w
        xy, xz, yz = xy + area * u * v, xz + area * u * w, yz + area * v * w
    over = 1.0 / total
    x, y, z = x * over, y * over, z * over
    xx, yy, zz = xx * over, yy * over, zz * over
    xy, xz, yz = xy * over, xz * over, yz * over
    f, g, (fa, fb), (ga, gb) = _equivalent(
        math.log(xx / zz), math.log(yy / zz), flat[0], flat[1], normals
    )
    a, b = math.exp(-f), math.exp(-g)
    size_xy = 1.0 / (_TURN * math.hypot(xx - yy, _SPLIT))
    size_xz = 1.0 / (_TURN * math.hypot(xx - zz, _SPLIT))
    size_yz = 1.0 / (_TURN * math.hypot(yy - zz, _SPLIT))
    values[0], values[1], values[2] = x / _CLOSURE, y / _CLOSURE, z / _CLOSURE
    values[3], values[4], values[5] = xy * size_xy, xz * size_xz, yz * size_yz
    values[6], values[7] = math.log((b + 1.0) / (a + b)), math.log((a + 1.0) / (a + b))
    # slopes of the moments by the ellipsoid, then by the logarithms of ratios of the tensor
    by_f, by_g = a / (a + b), b / (a + b)
    first_f, first_g = by_f, by_g - b / (b + 1.0)
    second_f, second_g = by_f - a / (a + 1.0), by_g
    first_one, first_two = first_f * fa + first_g * ga, first_f * fb + first_g * gb
    second_one, second_two = second_f * fa + second_g * ga, second_f * fb + second_g * gb
    for i in range(areas.size):
        u, v, w, share = normals[0, i], normals[1, i], normals[2, i], areas[i] * over
        by_areas[0, i] = (u - x) * share / _CLOSURE
        by_areas[1, i] = (v - y) * share / _CLOSURE
        by_areas[2, i] = (w - z) * share / _CLOSURE
        by_areas[3, i] = (u * v - xy) * share * size_xy
        by_areas[4, i] = (u * w - xz) * share * size_xz
        by_areas[5, i] = (v * w - yz) * share * size_yz
        third = w * w / zz
        one, two = (u * u / xx - third) * share, (v * v / yy - third) * share
        by_areas[6, i] = first_one * one + first_two * two
        by_areas[7, i] = second_one * one + second_two * two


# Brightness from the areas of facets by normal: Lommel-Seeliger plus a share of Lambert,
# S = mu0 mu (1/(mu0 + mu) + c) for each lit and seen facet.


@reduction_within
def _of_two(m0, m, area, opposite, lambert):
    """The light of the one of two opposite facets that is lit and seen; with its sign; and slopes.

    The sign, also that of the slopes by the cosines m0 and m, is minus for the second facet.
    """
    zero = every(0.0, m0)
    sign = chosen(m0, every(1.0, m0), every(-1.0, m0))
    area = chosen(m0 * m, chosen(m0, every(area, m0), every(opposite, m0)), zero)
    m0, m = sign * m0, at_least(m, zero - m)
    over = 1.0 / at_least(m0 + m, 1e-9)
    square = over * over
    by_m0, by_m = area * m, area * m0
    light = by_m * m * (over + lambert)
    by_m0, by_m = by_m0 * (m * square + lambert), by_m * (m0 * square + lambert)
    return light, sign * light, sign * by_m0, sign * by_m


@reduction_within
def _put_parities(sums, at, step, a, b, c, d, sign):
    """Store sums over four octants, of which b, c, d lie across the planes of z, y, x.

    Of the parities even under inversion, or of the others by sign -1.
    """
    put_eight(sums, at, a + sign * (b + c + d))
    put_eight(sums, at + step, a + sign * (b - c - d))
    put_eight(sums, at + 2 * step, a + sign * (c - b - d))
    put_eight(sums, at + 3 * step, a + sign * (d - b - c))


@reduction
def _light(sun, observer, octant, areas, lambert, sums, total, across):
    """The light of facets by parity, into sums (F N,), in all, into total (N,).

    Into across (3, N) the slopes of magnitudes by a turn.  sun, observer (3, N): unit vectors over
    body axes, where `LANES` divides N; octant (3, F / 8): normals of the first octant; areas (F,).
    Of two opposite facets one at most is lit.
    """
    n, count = total.size, octant.shape[1]
    suns, observers, slopes = sun.reshape(-1), observer.reshape(-1), across.reshape(-1)
    half = 4 * count
    for i in range(0, n, 8):
        s0, s1, s2 = three(suns, i, n)
        o0, o1, o2 = three(observers, i, n)
        light = a0 = a1 = a2 = b0 = b1 = b2 = every(0.0, s0)
        for j in range(count):
            x, y, z = octant[0, j], octant[1, j], octant[2, j]
            sx, sy, sz = s0 * x, s1 * y, s2 * z
            ox, oy, oz = o0 * x, o1 * y, o2 * z
            u, v = areas[j], areas[j + half]
            f0, g0, p0, q0 = _of_two(sx + sy + sz, ox + oy + oz, u, v, lambert)
            u, v = areas[j + count], areas[j + half + count]
            f1, g1, p1, q1 = _of_two(sx + sy - sz, ox + oy - oz, u, v, lambert)
            u, v = areas[j + 2 * count], areas[j + half + 2 * count]
            f2, g2, p2, q2 = _of_two(sx - sy + sz, ox - oy + oz, u, v, lambert)
            u, v = areas[j + 3 * count], areas[j + half + 3 * count]
            f3, g3, p3, q3 = _of_two(sy + sz - sx, oy + oz - ox, u, v, lambert)
            _put_parities(sums, j * n + i, count * n, f0, f1, f2, f3, 1.0)
            _put_parities(sums, (j + half) * n + i, count * n, g0, g1, g2, g3, -1.0)
            light = light + (f0 + f1 + f2 + f3)
            a0, b0 = a0 + x * (p0 + p1 + p2 - p3), b0 + x * (q0 + q1 + q2 - q3)
            a1, b1 = a1 + y * (p0 + p1 - p2 + p3), b1 + y * (q0 + q1 - q2 + q3)
            a2, b2 = a2 + z * (p0 - p1 + p2 + p3), b2 + z * (q0 - q1 + q2 + q3)
        light = at_least(light, 1e-12)
        put_eight(total, i, light)
        over = -MAGNITUDES_PER_E / light
        put_eight(slopes, i, over * (a1 * s2 - a2 * s1 + b1 * o2 - b2 * o1))
        put_eight(slopes, i + n, over * (a2 * s0 - a0 * s2 + b2 * o0 - b0 * o2))
        put_eight(slopes, i + 2 * n, over * (a0 * s1 - a1 * s0 + b0 * o1 - b1 * o0))


# ---- Magnitudes of a known shape under a known law, with their derivative by a turn of the body

# rad: of the differences.  Lobes of glints are wider by far.
_STEP_OF_DIFFERENCES = 1e-4
# Flux, over the mean, below which a magnitude is that of this flux: the body is unlit.
_DARK = 1e-4


@dataclass(frozen=True, eq=False)
class KnownShape:
    """A mesh, over the axes of the body, whose attitude is sought, with its law."""

    mesh: Mesh
    law: Law

    def __getstate__(self) -> dict[str, object]:
        # `_sums` is made anew: compiled loops are not pickled
        return {"mesh": self.mesh, "law": self.law}

    def over(self, axes: FloatArray) -> KnownShape:
        """The same over other axes, the columns (3, 3)."""
        if np.array_equal(axes, np.eye(3)):
            return self
        return KnownShape(self.mesh.turned(axes.T), self.law)

    def flux(self, sun: FloatArray, observer: FloatArray) -> FloatArray:
        """Brightness (...) seen from unit vectors (..., 3) over the axes of the body, m2/sr."""
        suns, observers, shape = paired(sun, observer)
        values = np.empty(shape)
        flat = values.reshape(-1)
        for begin in range(0, flat.size, BLOCK):
            end = begin + BLOCK
            self._sums(components(suns, observers, begin, end), flat[begin:end])
        return values

    @cached_property
    def _sums(self) -> Callable[[Sequence[FloatArray], FloatArray], None]:
        """The sum over the facets: made once, since a search evaluates it thousands of times."""
        return with_phase(kernel_of(self.mesh, self.law, True, 1), self.law)

    def magnitudes(self, sun: FloatArray, observer: FloatArray, least: float) -> FloatArray:
        """Magnitudes (...) of the flux, or of `least` where it is smaller."""
        return -MAGNITUDES_PER_E * np.log(np.maximum(self.flux(sun, observer), least))

    def floor(self, sun: FloatArray, observer: FloatArray) -> float:
        """The least flux that counts, from directions (..., 3) over any axes."""
        return max(_DARK * float(np.mean(self.flux(sun, observer))), 1e-300)

    def lit(self, sun: FloatArray, observer: FloatArray, least: float) -> BodyLight:
        """Magnitudes (N,) and their slopes (N, 3) by a turn of the body about its own axes."""
        across = np.empty((*sun.shape[:-1], 3))
        for k in range(3):
            ends = [
                self.magnitudes(_turned(sun, k, side), _turned(observer, k, side), least)
                for side in (_STEP_OF_DIFFERENCES, -_STEP_OF_DIFFERENCES)
            ]
            across[..., k] = (ends[0] - ends[1]) / (2.0 * _STEP_OF_DIFFERENCES)
        return BodyLight(self.magnitudes(sun, observer, least), across)


def known(mesh: Mesh, law: str | Law | None) -> KnownShape:
    """The mesh with a law, or its name; by default Lommel-Seeliger's and a tenth of Lambert's."""
    chosen = LAW if law is None else known_law(law)
    if not isinstance(mesh, Mesh):
        raise AttitudeError(f"shape is {mesh!r}; give a Mesh.")
    shape_known = KnownShape(mesh, chosen)
    shape_known.flux(np.array([0.0, 0.0, 1.0]), np.array([0.0, 0.0, 1.0]))
    return shape_known


def _turned(vectors: FloatArray, axis: int, angle: float) -> FloatArray:
    """Vectors (..., 3) fixed in space, over the axes of a body that is turned about an own axis."""
    c, s = math.cos(angle), math.sin(angle)
    i, j = (axis + 1) % 3, (axis + 2) % 3
    out = vectors.copy()
    out[..., i] = c * vectors[..., i] + s * vectors[..., j]
    out[..., j] = c * vectors[..., j] - s * vectors[..., i]
    return out


# ---- The convex polyhedron with given areas and normals of its facets: Minkowski's problem
# The heights h of the planes minimise log(sum a h) - log(V)/3, where V is the volume of the
# polyhedron (Little, "Extended Gaussian images", 1985; the derivative of V by a height is the area
# of the facet).  Polyhedra come from the convex hull of their polar duals.

_ITERATIONS = 400
# Corners closer than this, over the size of the body, are one.
_MERGED = 1e-4


def closed(areas: FloatArray, normals: FloatArray) -> FloatArray:
    """Areas (F,) changed least, relative to their size, such that the surface closes."""
    weighted = normals * areas
    inner = weighted @ normals.T
    factor = 1.0 - normals.T @ np.linalg.solve(inner, normals @ areas)
    return areas * np.maximum(factor, 1e-6)


def mesh(areas: FloatArray, normals: FloatArray) -> Mesh:
    """Areas (F,), normals (3, F) as a mesh about its mass centre, of the unit sphere's volume."""
    from scipy.optimize import minimize

    areas_closed = closed(areas, normals)
    areas_closed = areas_closed / areas_closed.sum()
    scale = np.sqrt((normals**2 * areas_closed).sum(axis=1))
    start = np.sqrt(np.sum((normals / scale[:, None]) ** 2, axis=0))

    def cost(logs: FloatArray) -> tuple[float, FloatArray]:
        heights = np.exp(logs)
        _, areas_there = _polyhedron(heights, normals)
        volume, total = heights @ areas_there / 3.0, areas_closed @ heights
        slope = areas_closed / total - areas_there / (3.0 * volume)
        return float(np.log(total) - np.log(volume) / 3.0), slope * heights

    minimum = minimize(
        cost, np.log(start), jac=True, method="L-BFGS-B", options={"maxiter": _ITERATIONS}
    )
    corners, _ = _polyhedron(np.exp(minimum.x), normals)
    return _meshed(corners)


def _polyhedron(heights: FloatArray, normals: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Corners (V, 3) and areas (F,) of the polyhedron of planes n.x = h."""
    from scipy.spatial import ConvexHull

    dual = (normals / heights).T
    hull = ConvexHull(dual)
    # a facet of the dual, n.x + d = 0, is the corner -n/d
    corners = -hull.equations[:, :3] / hull.equations[:, 3:]
    areas = np.zeros(len(heights))
    simplices, neighbours = hull.simplices, hull.neighbors
    for k in range(3):
        # the neighbour across from corner k shares the two others
        first, second = simplices[:, (k + 1) % 3], simplices[:, (k + 2) % 3]
        length = np.linalg.norm(corners - corners[neighbours[:, k]], axis=1)
        cosine = np.sum(normals[:, first] * normals[:, second], axis=0)
        sine = np.sqrt(np.maximum(1.0 - cosine**2, 1e-30))
        # each edge is met from both sides
        for a, b in ((first, second), (second, first)):
            distance = (heights[b] - heights[a] * cosine) / sine
            areas += np.bincount(a, 0.25 * distance * length, len(areas))
    return corners, areas


def _meshed(corners: FloatArray) -> Mesh:
    from scipy.spatial import ConvexHull

    size = float(np.ptp(corners, axis=0).max())
    _, kept = np.unique(np.round(corners / (size * _MERGED)), axis=0, return_index=True)
    points = corners[np.sort(kept)]
    hull = ConvexHull(points)
    points, facets = points[hull.vertices], np.searchsorted(hull.vertices, hull.simplices)
    a, b, c = (points[facets[:, k]] for k in range(3))
    outward = np.sum(np.cross(b - a, c - a) * (a + b + c - 3.0 * points.mean(axis=0)), axis=1) > 0.0
    facets = np.where(outward[:, None], facets, facets[:, ::-1])
    rough = Mesh(points, facets)
    properties = rough.mass_properties(density=1.0)
    radius = (3.0 * properties.mass / (4.0 * np.pi)) ** (1.0 / 3.0)
    return Mesh((points - properties.center_of_mass) / radius, facets)
