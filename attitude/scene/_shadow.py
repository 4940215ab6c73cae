"""The fraction of the Sun's disc that a body sees past another one: full light, penumbra, umbra.

The occulter is a sphere, the Earth a spheroid whose axis is the pole of ICRF (the pole of date is
0.2 degrees away in 2030); no atmosphere bends the light.

Sources: radii of IAU 2015 (Archinal et al., CeMDA 130, 22, 2018) and WGS84; the Sun's radius of IAU
2015 resolution B3.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from attitude._support import validation
from attitude._support.arrays import between
from attitude._support.constants import (
    EARTH_FLATTENING,
    EARTH_RADIUS_M,
    SPEED_OF_LIGHT_M_S,
    SUN_RADIUS_M,
)
from attitude.errors import AttitudeError
from attitude.paths._path import body_name

if TYPE_CHECKING:
    from attitude._support.annotations import BoolArray, FloatArray


# ---- The share of a disc that is seen past a spheroid, by the outlines of both on the sky
# A stretch of space along the axis of the spheroid makes it a sphere, whose limb is a circle on the
# sky: the limb of the spheroid is that circle, stretched back.  The covered part of the disc is
# bounded by arcs of both outlines between their crossings.  Its area follows from the integral of
# (x dy - y dx) / 2 along them, x and y being coordinates of Lambert's equal-area projection about
# the centre of the disc, so that the area is a solid angle.

# Points on the outline of the disc.  Two crossings between neighbours are found at the extremes.
_POINTS = 64
# Steps of regula falsi: each halves the interval at least, and mostly gains several digits.
_STEPS = 40
# Gauss-Legendre points on an arc of the limb: 1e-14 of the area of a full circle.
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(20)
# Epochs that are computed together.
_BLOCK = 2048


def _free_share(center, radius, disc, half_angle, stretch):
    """The share (N,) of discs (3, N), half_angle (N,) rad, that a spheroid (3, N) leaves free."""
    out = np.empty(half_angle.size)
    for begin in range(0, out.size, _BLOCK):
        block = slice(begin, begin + _BLOCK)
        outlines = _Outlines(center[:, block], radius, disc[:, block], half_angle[block], stretch)
        out[block] = 1.0 - outlines.covered()
    return np.clip(out, 0.0, 1.0)


class _Outlines:
    """The outlines of K discs and of a spheroid."""

    def __init__(self, center, radius, disc, half_angle, stretch):
        self.scale = np.array([1.0, 1.0, stretch])
        self.disc, self.half_angle = disc, half_angle
        self.right, self.up = _axes(disc)
        middle = center * self.scale[:, None]
        distance = np.sqrt(np.sum(middle * middle, axis=0))
        self.center = middle / distance
        self.sine = radius / distance
        self.cosine = np.sqrt((1.0 - self.sine) * (1.0 + self.sine))
        self.limb_right, self.limb_up = _axes(self.center)

    def covered(self) -> FloatArray:
        """The covered share (K,) of the discs."""
        phi, depth = self._samples()
        whole = np.pi * self._disc_radius() ** 2
        area = np.where(np.all(depth >= 0.0, axis=1), whole, 0.0)
        outside = np.flatnonzero(np.all(depth < 0.0, axis=1))
        inner = outside[np.sum(self.disc * self.center, axis=0)[outside] > 0.0]
        # Outlines that do not cross: the limb is inside of the disc as a whole or not at all.
        inner = inner[self._is_in_disc(inner)]
        if inner.size:
            area[inner] = self._along_limb(
                inner, np.zeros(inner.size), np.full(inner.size, 2 * np.pi)
            )
        enters = (depth < 0.0) & (np.roll(depth, -1, axis=1) >= 0.0)
        leaves = (depth >= 0.0) & (np.roll(depth, -1, axis=1) < 0.0)
        if np.any(enters):
            area += self._between_crossings(phi, depth, enters, leaves)
        return area / whole

    def _samples(self) -> tuple[FloatArray, FloatArray]:
        """Ascending angles (K, M) on outlines, with the extremes of depth, and depths there."""
        step = 2.0 * np.pi / _POINTS
        phi = np.broadcast_to(step * np.arange(_POINTS), (self.half_angle.size, _POINTS))
        rows = np.arange(len(phi))
        depth = self._depth(rows, phi)
        extremes = []
        for at in (np.argmin(depth, axis=1), np.argmax(depth, axis=1)):
            before, middle, after = (depth[rows, (at + k) % _POINTS] for k in (-1, 0, 1))
            bend = before - 2.0 * middle + after
            with np.errstate(divide="ignore", invalid="ignore"):
                shift = np.where(bend == 0.0, 0.0, 0.5 * (before - after) / bend)
            extremes.append(step * (at + np.clip(shift, -0.5, 0.5)) % (2.0 * np.pi))
        more = np.stack(extremes, axis=1)
        phi = np.concatenate([phi, more], axis=1)
        depth = np.concatenate([depth, self._depth(rows, more)], axis=1)
        order = np.argsort(phi, axis=1)
        return np.take_along_axis(phi, order, 1), np.take_along_axis(depth, order, 1)

    def _outline(self, rows, phi: FloatArray) -> FloatArray:
        """Unit vectors (3, R, ...) to points of the outlines of the discs `rows` (R,)."""
        right, up, disc = (_at(axis, rows, phi) for axis in (self.right, self.up, self.disc))
        half_angle = self.half_angle[rows]
        sine, cosine = (_at(f(half_angle), slice(None), phi) for f in (np.sin, np.cos))
        return disc * cosine + (right * np.cos(phi) + up * np.sin(phi)) * sine

    def _depth(self, rows, phi: FloatArray) -> FloatArray:
        """Positive where the outlines of the discs `rows` (R,) are covered, for phi (R, ...)."""
        seen = self._outline(rows, phi) * self.scale[(slice(None), *(None,) * phi.ndim)]
        center = _at(self.center, rows, phi)
        along = np.sum(seen * center, axis=0)
        across = np.cross(seen, center, axis=0)
        # The sine of the angle by which the point is inside of the limb, times the length.
        off = np.sqrt(np.sum(across * across, axis=0))
        sine, cosine = (_at(array, rows, phi) for array in (self.sine, self.cosine))
        return sine * along - cosine * off

    def _is_in_disc(self, rows) -> BoolArray:
        """Whether a point of the limb is inside of the discs `rows`."""
        point = self._limb(rows, np.zeros(len(rows)))[0]
        return np.hypot(*self._projected(rows, point)) < self._disc_radius()[rows]

    def _limb(self, rows, theta: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Unit vectors (3, R, ...) to points of the limb, and their derivatives by theta."""
        sine, cosine = (_at(array, rows, theta) for array in (self.sine, self.cosine))
        back = 1.0 / self.scale[(slice(None), *(None,) * theta.ndim)]
        axes = self.limb_right, self.limb_up, self.center
        right, up, center = (_at(axis, rows, theta) for axis in axes)
        point = back * (center * cosine + (right * np.cos(theta) + up * np.sin(theta)) * sine)
        change = back * (up * np.cos(theta) - right * np.sin(theta)) * sine
        length = np.sqrt(np.sum(point * point, axis=0))
        unit, change = point / length, change / length
        return unit, change - unit * np.sum(unit * change, axis=0)

    def _disc_radius(self) -> FloatArray:
        """Radii of the discs in the projection."""
        return 2.0 * np.sin(0.5 * self.half_angle)

    def _projected(self, rows, unit: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Coordinates of directions (3, R, ...) in the projections about the discs `rows`."""
        axes = self.right, self.up, self.disc
        x, y, z = (np.sum(unit * _at(axis, rows, unit[0]), axis=0) for axis in axes)
        factor = np.sqrt(2.0 / (1.0 + z))
        return factor * x, factor * y

    def _along_limb(self, rows, first: FloatArray, length: FloatArray) -> FloatArray:
        """The integral of (x dy - y dx) / 2 along arcs of the limb that begin at theta `first`."""
        theta = first[:, None] + 0.5 * length[:, None] * (1.0 + _NODES)
        unit, change = self._limb(rows, theta)
        axes = [_at(axis, rows, theta) for axis in (self.right, self.up, self.disc)]
        x, y, z = (np.sum(unit * axis, axis=0) for axis in axes)
        dx, dy = (np.sum(change * axis, axis=0) for axis in axes[:2])
        # The factor of the projection is the same for x and y: its change cancels.
        return 0.5 * length * (((x * dy - y * dx) / (1.0 + z)) @ _WEIGHTS)

    def _between_crossings(self, phi, depth, enters, leaves):
        """Areas (K,) bounded by arcs of the outlines and of the limbs; 0 without crossings."""
        area = np.zeros(len(phi))
        rows, _ = np.nonzero(enters)
        begins, ends = (self._crossings(phi, depth, crossing) for crossing in (enters, leaves))
        # In each row as many arcs begin as end.  The first end may belong to the last beginning.
        first = np.searchsorted(rows, rows)
        count = np.bincount(rows, minlength=len(phi))[rows]
        place = np.arange(len(rows)) - first
        late = ends[first] < begins[first]
        ends = ends[first + (place + late) % count]
        arc = np.mod(ends - begins, 2.0 * np.pi)
        np.add.at(area, rows, 0.5 * self._disc_radius()[rows] ** 2 * arc)
        following = begins[first + (place + 1) % count]
        start, stop = (self._theta(rows, crossing) for crossing in (ends, following))
        np.add.at(area, rows, self._along_limb(rows, start, np.mod(stop - start, 2.0 * np.pi)))
        return area

    def _theta(self, rows, phi: FloatArray) -> FloatArray:
        """The angle on the limb at crossings of the outlines at phi."""
        seen = self._outline(rows, phi) * self.scale[:, None]
        y, x = (np.sum(seen * axis[:, rows], axis=0) for axis in (self.limb_up, self.limb_right))
        return np.arctan2(y, x)

    def _crossings(self, phi: FloatArray, depth: FloatArray, where: BoolArray) -> FloatArray:
        """Angles of the crossings between marked samples and the next, by row, ascending."""
        rows, k = np.nonzero(where)
        after = (k + 1) % phi.shape[1]
        a, fa, fb = phi[rows, k], depth[rows, k], depth[rows, after]
        b = phi[rows, after] + np.where(after == 0, 2.0 * np.pi, 0.0)
        for _ in range(_STEPS):
            # Illinois: the value at an end that stays is halved.
            with np.errstate(divide="ignore", invalid="ignore"):
                c = np.where(fa == fb, 0.5 * (a + b), b - fb * (b - a) / (fb - fa))
            fc = self._depth(rows, c)
            same = (fc < 0.0) == (fb < 0.0)
            a, fa = np.where(same, a, b), np.where(same, 0.5 * fa, fb)
            b, fb = c, fc
            if np.all(np.abs(b - a) * np.abs(fb) < 1e-30):
                break
        return b


def _at(array, rows, like):
    """An array (..., K) at `rows` (R,), with further axes as `like` (R, ...) has them."""
    return array[(..., rows, *(None,) * (like.ndim - 1))]


def _axes(z: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Unit vectors x, y (3, K) that make a right-handed system with unit vectors z."""
    helper = np.where(np.abs(z[2]) < 0.9, 1.0, 0.0)
    helper = np.stack([1.0 - helper, np.zeros_like(helper), helper])
    x = np.cross(helper, z, axis=0)
    x /= np.sqrt(np.sum(x * x, axis=0))
    return x, np.cross(z, x, axis=0)


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


def occulters(shadow_of: Any) -> dict[str, float]:
    """Radii in m, by name, of the bodies that cast shadows."""
    bodies = (shadow_of,) if isinstance(shadow_of, (str, int)) else shadow_of
    if not isinstance(bodies, Iterable):
        raise AttitudeError(
            f"shadow_of is {validation.shown(bodies)}; give names or NAIF numbers of bodies, or a "
            "dict of their radii in m."
        )
    radii = bodies.items() if isinstance(bodies, Mapping) else ((body, None) for body in bodies)
    known_radii = {}
    for body, radius in radii:
        name = body_name(body, "shadow_of")
        known = radius_of(name) if radius is None else radius
        if known is None:
            raise AttitudeError(
                f"shadow_of holds {body!r}, whose radius is not known here; give it in m, as in "
                f"shadow_of={{{body!r}: 1e6}}, or one of {', '.join(RADII)}."
            )
        known_radii[name] = validation.positive(known, f"the radius of {name}", unit="m")
    return known_radii


def lit_fraction(
    to_occulter: FloatArray,
    radius: float,
    sun: FloatArray,
    sun_distance: FloatArray | None,
    *,
    flattening: float = 0.0,
    velocity: Callable[[BoolArray], FloatArray] | None = None,
) -> FloatArray:
    """The fraction (N,), to 1e-9, of the Sun's disc seen past an occulter (3, N) m; sun (3, N).

    A ray from the direction n was s n from the body s / c before, when the occulter was at its
    present place less v s / c: each point of the limb is taken at the epoch at which the light
    passed it.
    """
    sun = np.broadcast_to(sun, to_occulter.shape)
    limb, apart = _limb_and_distance(to_occulter, radius, sun, flattening)
    shares = np.where(np.isnan(apart), np.nan, (apart > limb) * 1.0)
    if sun_distance is None:
        return shares
    disc = _angular_radius(SUN_RADIUS_M, sun_distance)
    # The stretch and the velocity change these angles by less.
    margin = 2.0 * flattening * disc + (0.0 if velocity is None else _FASTEST)
    is_near = np.abs(apart - limb) < disc + margin
    if np.any(is_near):
        center, seen, far = to_occulter[:, is_near], sun[:, is_near], sun_distance[is_near]
        if velocity is not None:
            shift = velocity(is_near) / SPEED_OF_LIGHT_M_S
            center = center + shift * np.sqrt(np.sum(center * center, axis=0))
            seen = seen + shift
        size = np.sqrt(np.sum(seen * seen, axis=0))
        shares[is_near] = _free_share(
            center,
            radius,
            seen / size,
            _angular_radius(SUN_RADIUS_M, far * size),
            1.0 / (1.0 - flattening),
        )
    return shares


def _limb_and_distance(to_occulter, radius, sun, flattening):
    """Angular radius of the occulter and angle from its centre to the Sun, in stretched space."""
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
    return np.arctan2(radius, np.sqrt((distance - radius) * (distance + radius)))


def flattening_of(body: str, radius: float) -> float:
    """The flattening of an occulter: the Earth's if its radius is that of `RADII`, otherwise 0."""
    return EARTH_FLATTENING if body == "earth" and radius == RADII["earth"] else 0.0
