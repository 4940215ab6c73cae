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
from dataclasses import dataclass
from functools import cache, cached_property
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from attitude._compilation.decorators import reduction, reduction_subroutine
from attitude._compilation.simd import at_least, chosen, eight, every, put_eight, summed_up
from attitude.errors import AttitudeError
from attitude.inversion._motions import LANES, padded, three
from attitude.light_curve._brightness import BLOCK, components, kernel_of, paired, with_phase
from attitude.scattering._law import law as known_law
from attitude.scattering._weighted import LommelSeeligerLambert
from attitude.shape._mesh import Mesh

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from attitude._support.annotations import FloatArray
    from attitude.scattering._law import Law


# Facets of a convex body.
COUNT = 260
# The same with facets of no area, to whole vectors.
_PADDED = COUNT + -COUNT % LANES
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


@dataclass(frozen=True, eq=False)
class Sphere:
    """Normals (3, F), their squares, and modes (F, M) of the logarithm of the areas."""

    normals: FloatArray
    squares: FloatArray
    modes: FloatArray

    @cached_property
    def padded_normals(self) -> FloatArray:
        """The components of the normals, one after the other, each to whole vectors."""
        return padded(self.normals).reshape(-1)


@cache
def sphere() -> Sphere:
    """The normals and modes of all bodies."""
    normals = np.ascontiguousarray(even_directions(COUNT).T)
    kernel = _AMPLITUDE**2 * np.exp((normals.T @ normals - 1.0) / _LENGTH**2)
    values, vectors = np.linalg.eigh(kernel)
    modes = vectors[:, ::-1][:, :MODES] * np.sqrt(values[::-1][:MODES])
    # the sign of an eigenvector depends on the library of linear algebra
    modes *= np.sign(modes[np.argmax(np.abs(modes), axis=0), np.arange(MODES)])
    return Sphere(normals, normals**2, np.ascontiguousarray(modes))


@cache
def _inversion() -> FloatArray:
    """The coefficients (M, M) of the body inverted through its centre, from those of the body.

    The factor of the areas at the opposite normals, by the interpolation of its Gaussian process.
    """
    on = sphere()
    across = np.exp((-(on.normals.T @ on.normals) - 1.0) / _LENGTH**2)
    # the modes are eigenvectors: K^-1 of their factor is the factor over its eigenvalue
    sizes = np.sum(on.modes**2, axis=0)
    return (on.modes / sizes).T @ (across @ (on.modes / sizes)) * _AMPLITUDE**2


def inverted(modes: FloatArray) -> FloatArray:
    """The coefficients (M,) of a body whose areas are exchanged with those of opposite normals."""
    return _inversion() @ modes if len(modes) else modes


def areas(flat: FloatArray, modes: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Areas (F,), the largest being 1, and slopes (F, 2 + M) of their logarithms.

    Shapes: flat (2,), modes (M,): of the smoothest modes, all or fewer.
    """
    on = sphere()
    area, slopes = np.empty(COUNT), np.empty((COUNT, ELLIPSOID + len(modes)))
    _areas(flat, modes, on.squares, on.modes, area, slopes)
    return area, slopes


class Constraints(NamedTuple):
    """What a shape has to satisfy, and slopes by its parameters (2 + M).

    offsets: residuals of the closure, and of the directions of its principal axes, in standard
        deviations.
    """

    offsets: FloatArray  # (6,)
    log_ratios: FloatArray  # (2,), ln I1/I3 and ln I2/I3 of the homogeneous body
    slopes: FloatArray  # (8, 2 + M), of both


def constraints(flat: FloatArray, area: FloatArray, slopes: FloatArray) -> Constraints:
    """What a shape has to satisfy; arguments as of and from `areas`."""
    values, by_areas = np.empty(8), np.empty((8, COUNT))
    _constraints(flat, area, sphere().normals, values, by_areas)
    return Constraints(values[:6], values[6:], by_areas @ slopes)


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
_MAGNITUDE = -2.5 / math.log(10.0)


@dataclass(frozen=True, eq=False)
class BodyLight:
    """Magnitudes (N,) of a body seen from given directions, and their derivatives.

    across (N, 3): by a turn of the body, rad, over its own axes; areas (F,) and the slopes (F, S)
    of their logarithms; light of each facet (N, F), and in total (N,).
    """

    magnitude: FloatArray
    across: FloatArray
    areas: FloatArray
    slopes: FloatArray
    of_facets: FloatArray
    total: FloatArray

    @cached_property
    def by_shape(self) -> FloatArray:
        """Derivatives (S, N) by the shape."""
        # in single precision processors that round otherwise lead a search to other minima
        return self.slopes.T @ self.of_facets.T * (_MAGNITUDE / self.total)


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
    area, slopes = areas(shape[:ELLIPSOID], shape[ELLIPSOID:])
    of_facets, total = np.empty((count, _PADDED)), np.empty(count)
    across, padded_areas = np.empty((count, 3)), np.zeros(_PADDED)
    padded_areas[:COUNT] = area
    normals = sphere().padded_normals
    _light(sun, observer, normals, padded_areas, LAMBERT, of_facets.reshape(-1), total, across)
    magnitude = _MAGNITUDE * np.log(total)
    return BodyLight(magnitude, across, area, slopes, of_facets[:, :COUNT], total)


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
    held = constraints(shape[:ELLIPSOID], areas, slopes)
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
def _areas(flat, modes, squares, of_modes, areas, slopes):
    """What `areas` returns, into areas (F,) and slopes (F, 2 + M).

    flat (2,), modes (M,); squares of the normals (3, F), all modes (F, M or more).
    """
    a, b = math.exp(-flat[0]), math.exp(-flat[1])
    largest = -math.inf
    for i in range(areas.size):
        across = a * squares[0, i] + b * squares[1, i] + squares[2, i]
        slopes[i, 0] = 2.0 * a * squares[0, i] / across
        slopes[i, 1] = 2.0 * b * squares[1, i] / across
        log_area = -2.0 * math.log(across)
        for k in range(modes.size):
            slopes[i, 2 + k] = of_modes[i, k]
            log_area += of_modes[i, k] * modes[k]
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


@reduction
def _light(sun, observer, normals, areas, lambert, of_facets, total, across):
    """The light of facets, into of_facets (N F,), their sums, into total (N,).

    Into across (N, 3) the slopes of magnitudes by a turn.  sun, observer (N, 3): unit vectors over
    body axes; normals (3 F,) by components; areas (F,), where `LANES` divides F.
    """
    count = areas.size
    for i in range(sun.shape[0]):
        s0, s1, s2 = sun[i, 0], sun[i, 1], sun[i, 2]
        o0, o1, o2 = observer[i, 0], observer[i, 1], observer[i, 2]
        zero = every(0.0, eight(areas, 0))
        light = a0 = a1 = a2 = b0 = b1 = b2 = zero
        for j in range(0, count, 8):
            x, y, z = three(normals, j, count)
            m0 = at_least(s0 * x + s1 * y + s2 * z, 0.0)
            m = at_least(o0 * x + o1 * y + o2 * z, 0.0)
            area = chosen(m0 * m, eight(areas, j), zero)
            over = 1.0 / at_least(m0 + m, 1e-9)
            by_m0, by_m = area * m, area * m0
            of_facet = by_m * m * (over + lambert)
            put_eight(of_facets, i * count + j, of_facet)
            light = light + of_facet
            square = over * over
            by_m0, by_m = by_m0 * (m * square + lambert), by_m * (m0 * square + lambert)
            a0, a1, a2 = a0 + by_m0 * x, a1 + by_m0 * y, a2 + by_m0 * z
            b0, b1, b2 = b0 + by_m * x, b1 + by_m * y, b2 + by_m * z
        total[i] = max(summed_up(light), 1e-12)
        factor = _MAGNITUDE / total[i]
        u0, u1, u2 = summed_up(a0), summed_up(a1), summed_up(a2)
        v0, v1, v2 = summed_up(b0), summed_up(b1), summed_up(b2)
        across[i, 0] = factor * (u1 * s2 - u2 * s1 + v1 * o2 - v2 * o1)
        across[i, 1] = factor * (u2 * s0 - u0 * s2 + v2 * o0 - v0 * o2)
        across[i, 2] = factor * (u0 * s1 - u1 * s0 + v0 * o1 - v1 * o0)


# ---- Magnitudes of a known shape under a known law, with their derivative by a turn of the body

# rad: of the differences.  Lobes of glints are wider by far.
_STEP_OF_DIFFERENCES = 1e-4
# Flux, over the mean, below which a magnitude is that of this flux: the body is unlit.
_DARK = 1e-4
_NOTHING = np.zeros(0)


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
        return _MAGNITUDE * np.log(np.maximum(self.flux(sun, observer), least))

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
        values, nothing = self.magnitudes(sun, observer, least), np.zeros((len(sun), 0))
        return BodyLight(values, across, _NOTHING, np.zeros((0, 0)), nothing, np.ones(len(sun)))


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
