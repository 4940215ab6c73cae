"""Light curves of non-convex bodies and of bodies with a moon, for the inversion.

Closed meshes (two lobes, bent, cratered, or files of real bodies) with shadows by rays to Sun and
observer, Hapke's or the Lunar-Lambert law, albedo spots, moments that are not those of the
homogeneous body, outliers, clocks that are off, exposures, and a moon that eclipses and is
eclipsed.  Motion, orbits and epochs are those of `synthetic_curves`: nothing of the package is
imported.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from pathlib import Path

import numba
import numpy as np

from tests.support import synthetic_curves
from tests.support.synthetic_curves import (
    LIGHT_DAY_AU,
    Case,
    _integrated,
    _kepler,
    _matrices,
    _unit,
)

# Facets of a moon, and the share of Lambert in the Lunar-Lambert law.
_MOON_LEVEL, _SHARE = 2, 0.25
# Hapke's parameters: single-scattering albedo, asymmetry, opposition amplitude and width.
_HAPKE = np.array([0.43, -0.27, 1.2, 0.05])


# ---- Shapes


def icosphere(level: int) -> tuple[np.ndarray, np.ndarray]:
    """Vertices (V, 3) and facets (F, 3) of a sphere of 20 4^level facets."""
    golden = (1.0 + 5.0**0.5) / 2.0
    corners = [
        (-1, golden, 0), (1, golden, 0), (-1, -golden, 0), (1, -golden, 0),
        (0, -1, golden), (0, 1, golden), (0, -1, -golden), (0, 1, -golden),
        (golden, 0, -1), (golden, 0, 1), (-golden, 0, -1), (-golden, 0, 1),
    ]  # fmt: skip
    facets = [
        (0, 11, 5), (0, 5, 1), (0, 1, 7), (0, 7, 10), (0, 10, 11), (1, 5, 9), (5, 11, 4),
        (11, 10, 2), (10, 7, 6), (7, 1, 8), (3, 9, 4), (3, 4, 2), (3, 2, 6), (3, 6, 8), (3, 8, 9),
        (4, 9, 5), (2, 4, 11), (6, 2, 10), (8, 6, 7), (9, 8, 1),
    ]  # fmt: skip
    points = [np.array(each) / np.linalg.norm(each) for each in corners]
    for _ in range(level):
        middles: dict[tuple[int, int], int] = {}

        def middle(a, b, middles=middles):
            key = (min(a, b), max(a, b))
            if key not in middles:
                halfway = points[a] + points[b]
                points.append(halfway / np.linalg.norm(halfway))
                middles[key] = len(points) - 1
            return middles[key]

        split = []
        for a, b, c in facets:
            x, y, z = middle(a, b), middle(b, c), middle(c, a)
            split += [(a, x, z), (b, y, x), (c, z, y), (x, y, z)]
        facets = split
    return np.array(points), np.array(facets)


def _lumpy(rng, points):
    """Points of a sphere moved by bumps and craters, stretched to an ellipsoid."""
    radius = np.exp(
        sum(
            rng.normal(0.0, 0.065) * np.exp(rng.uniform(3.0, 9.0) * (points @ _unit(rng) - 1.0))
            for _ in range(14)
        )
    )
    for _ in range(3):
        width = math.cos(rng.uniform(0.3, 0.6))
        cosine = points @ _unit(rng)
        depth = rng.uniform(0.08, 0.16)
        radius -= np.where(cosine > width, depth * (cosine - width) / (1.0 - width), 0.0)
    b = rng.uniform(0.45, 0.9)
    return points * radius[:, None] * np.array([1.0, b, b * rng.uniform(0.65, 0.95)])


def _bilobed(rng, points):
    """The union of two ellipsoids that overlap, from a point within both."""
    sizes = rng.uniform(0.75, 1.0), rng.uniform(0.4, 0.75)
    radius = np.zeros(len(points))
    for sign, size in zip((1.0, -1.0), sizes, strict=True):
        axes = size * np.array([1.0, rng.uniform(0.7, 1.0), rng.uniform(0.6, 0.95)])
        centre = np.array([sign * rng.uniform(0.78, 0.93) * axes[0], 0.0, 0.0])
        centre[1:] = rng.normal(0.0, 0.04, 2)
        # the ray from the origin, which is inside, leaves the ellipsoid once
        scaled, start = points / axes, centre / axes
        a = np.sum(scaled**2, axis=1)
        b = scaled @ start
        c = start @ start - 1.0
        radius = np.maximum(radius, (b + np.sqrt(np.maximum(b * b - a * c, 0.0))) / a)
    return _roughened(rng, points * radius[:, None], points)


def _bent(rng, points):
    """An ellipsoid bent over its long axis, as Eros is."""
    b = rng.uniform(0.35, 0.55)
    solid = points * np.array([1.0, b, b * rng.uniform(0.75, 0.98)])
    solid[:, 1] += rng.uniform(0.25, 0.45) * solid[:, 0] ** 2
    solid[:, 2] *= 1.0 + rng.uniform(-0.3, 0.3) * solid[:, 0]
    return _roughened(rng, solid, points)


def _roughened(rng, solid, points):
    """A body with low bumps by the directions of the sphere that it was made of."""
    bumps = sum(
        rng.normal(0.0, 0.03) * np.exp(rng.uniform(4.0, 9.0) * (points @ _unit(rng) - 1.0))
        for _ in range(10)
    )
    return solid * np.exp(bumps)[:, None]


def read_mesh(path: Path) -> tuple[np.ndarray, np.ndarray]:
    """Vertices and facets of an OBJ file, of triangles alone."""
    vertices, facets = [], []
    for line in path.read_text().splitlines():
        words = line.split()
        if words[:1] == ["v"]:
            vertices.append([float(word) for word in words[1:4]])
        elif words[:1] == ["f"]:
            facets.append([int(word.split("/")[0]) - 1 for word in words[1:4]])
    return np.array(vertices), np.array(facets)


# ---- Bodies and their light


@numba.njit(cache=True)
def _hides(origin, direction, first, side, other, among):
    """Whether a ray meets any of some triangles."""
    for k in among:
        p0 = direction[1] * other[k, 2] - direction[2] * other[k, 1]
        p1 = direction[2] * other[k, 0] - direction[0] * other[k, 2]
        p2 = direction[0] * other[k, 1] - direction[1] * other[k, 0]
        det = side[k, 0] * p0 + side[k, 1] * p1 + side[k, 2] * p2
        if abs(det) < 1e-14:
            continue
        t0, t1, t2 = origin[0] - first[k, 0], origin[1] - first[k, 1], origin[2] - first[k, 2]
        u = (t0 * p0 + t1 * p1 + t2 * p2) / det
        if u < 0.0 or u > 1.0:
            continue
        q0 = t1 * side[k, 2] - t2 * side[k, 1]
        q1 = t2 * side[k, 0] - t0 * side[k, 2]
        q2 = t0 * side[k, 1] - t1 * side[k, 0]
        v = (direction[0] * q0 + direction[1] * q1 + direction[2] * q2) / det
        if v < 0.0 or u + v > 1.0:
            continue
        if (other[k, 0] * q0 + other[k, 1] * q1 + other[k, 2] * q2) / det > 1e-9:
            return True
    return False


@numba.njit(cache=True)
def _in_front(vertices, facets, centres, normals):
    """For each facet the facets with a corner above its plane: where each list begins, and all."""
    count = len(facets)
    begins, listed = np.zeros(count + 1, np.int64), np.empty(count * count, np.int64)
    size = 0
    for i in range(count):
        for j in range(count):
            top = -1.0
            for k in range(3):
                height = 0.0
                for axis in range(3):
                    height += (vertices[facets[j, k], axis] - centres[i, axis]) * normals[i, axis]
                top = max(top, height)
            if j != i and top > 1e-7:
                listed[size] = j
                size += 1
        begins[i + 1] = size
    return begins, listed[:size].copy()


@numba.njit(cache=True)
def _law(hapke, m0, m, alpha):
    """Radiance over the cosine of emission of a Lunar-Lambert or a Hapke surface."""
    if len(hapke) == 0:
        return (1.0 - 0.25) * 2.0 * m0 / (m0 + m) + 0.25 * m0
    w, g, amplitude, width = hapke
    phase = (1.0 - g * g) / (1.0 + 2.0 * g * math.cos(alpha) + g * g) ** 1.5
    surge = amplitude / (1.0 + math.tan(0.5 * alpha) / width)
    root = math.sqrt(1.0 - w)
    h0, h = (1.0 + 2.0 * m0) / (1.0 + 2.0 * m0 * root), (1.0 + 2.0 * m) / (1.0 + 2.0 * m * root)
    return w * m0 / (m0 + m) * ((1.0 + surge) * phase + h0 * h - 1.0)


@numba.njit(cache=True)
def _light(sun, observer, normals, areas, centres, first, side, other, begins, listed, hapke,
           moon, radius):  # fmt: skip
    """The flux (N,) of a body, shadowed by itself and by a sphere at moon (N, 3)."""
    flux = np.zeros(len(sun))
    for t in range(len(sun)):
        s, o = sun[t], observer[t]
        alpha = math.acos(max(-1.0, min(1.0, s[0] * o[0] + s[1] * o[1] + s[2] * o[2])))
        for i in range(len(areas)):
            m0 = normals[i, 0] * s[0] + normals[i, 1] * s[1] + normals[i, 2] * s[2]
            m = normals[i, 0] * o[0] + normals[i, 1] * o[1] + normals[i, 2] * o[2]
            if m0 <= 0.0 or m <= 0.0:
                continue
            among = listed[begins[i] : begins[i + 1]]
            if len(among) and (
                _hides(centres[i], s, first, side, other, among)
                or _hides(centres[i], o, first, side, other, among)
            ):
                continue
            if radius > 0.0:
                line = moon[t] - centres[i]
                square = line[0] ** 2 + line[1] ** 2 + line[2] ** 2
                along = line[0] * s[0] + line[1] * s[1] + line[2] * s[2]
                if along > 0.0 and square - along * along < radius * radius:
                    continue
                along = line[0] * o[0] + line[1] * o[1] + line[2] * o[2]
                if along > 0.0 and square - along * along < radius * radius:
                    continue
            flux[t] += _law(hapke, m0, m, alpha) * m * areas[i]
    return flux


@numba.njit(cache=True)
def _light_of_moon(sun, observer, places, radius, normals, area, first, side, other, hapke):
    """The flux (N,) of a sphere, shadowed and hidden by a body of given triangles."""
    flux, every = np.zeros(len(sun)), np.arange(len(first))
    for t in range(len(sun)):
        s, o = sun[t], observer[t]
        alpha = math.acos(max(-1.0, min(1.0, s[0] * o[0] + s[1] * o[1] + s[2] * o[2])))
        for i in range(len(normals)):
            m0 = normals[i, 0] * s[0] + normals[i, 1] * s[1] + normals[i, 2] * s[2]
            m = normals[i, 0] * o[0] + normals[i, 1] * o[1] + normals[i, 2] * o[2]
            if m0 <= 0.0 or m <= 0.0:
                continue
            point = places[t] + radius * normals[i]
            if _hides(point, s, first, side, other, every):
                continue
            if not _hides(point, o, first, side, other, every):
                flux[t] += _law(hapke, m0, m, alpha) * m * area
    return flux


@dataclass
class Solid:
    """A closed mesh over its principal axes, largest extent 1; moments ascending, largest 1."""

    moments: np.ndarray
    normals: np.ndarray
    areas: np.ndarray
    centres: np.ndarray
    triangles: tuple[np.ndarray, np.ndarray, np.ndarray]
    in_front: tuple[np.ndarray, np.ndarray]
    hapke: np.ndarray

    @classmethod
    def of(cls, vertices: np.ndarray, facets: np.ndarray, hapke: bool) -> Solid:
        """The homogeneous body of a mesh."""
        a, b, c = (vertices[facets[:, k]] for k in range(3))
        volume = np.einsum("ij,ij->i", a, np.cross(b, c)) / 6.0
        if volume.sum() < 0.0:
            facets, volume = facets[:, ::-1], -volume
            a, c = c, a
        total = a + b + c
        centre = (volume[:, None] * total).sum(axis=0) / 4.0 / volume.sum()
        second = np.einsum("f,fi,fj->ij", volume, total, total)
        second += sum(np.einsum("f,fi,fj->ij", volume, x, x) for x in (a, b, c))
        second = second / 20.0 / volume.sum() - np.outer(centre, centre)
        moments, axes = np.linalg.eigh(np.trace(second) * np.eye(3) - second)
        axes[:, 2] *= np.linalg.det(axes)
        vertices = (vertices - centre) @ axes
        vertices /= np.abs(vertices).max()
        a, b, c = (vertices[facets[:, k]] for k in range(3))
        across = np.cross(b - a, c - a)
        size = np.linalg.norm(across, axis=1)
        kept = size > 1e-12
        facets, a, b, c, across, size = (x[kept] for x in (facets, a, b, c, across, size))
        normals, centres = across / size[:, None], (a + b + c) / 3.0
        return cls(
            moments / moments[2], normals, 0.5 * size, centres, (a, b - a, c - a),
            _in_front(vertices, np.ascontiguousarray(facets), centres, normals),
            _HAPKE if hapke else np.zeros(0),
        )  # fmt: skip

    def flux(
        self, sun: np.ndarray, observer: np.ndarray, moon=None, radius: float = 0.0,
        is_apart: bool = False,
    ):  # fmt: skip
        """Flux (N,) towards unit vectors (N, 3) over body axes, with a moon at (N, 3).

        is_apart: as if neither hid or shaded the other one.
        """
        vectors = np.ascontiguousarray(sun), np.ascontiguousarray(observer)
        places = np.zeros_like(vectors[0]) if moon is None else np.ascontiguousarray(moon)
        own = self.normals, self.areas, self.centres, *self.triangles, *self.in_front, self.hapke
        flux = _light(*vectors, *own, places, 0.0 if is_apart else radius)
        if radius > 0.0:
            sphere, facets = icosphere(_MOON_LEVEL)
            normals = sphere[facets].mean(axis=1)
            normals /= np.linalg.norm(normals, axis=1)[:, None]
            area = 4.0 * math.pi * radius**2 / len(facets)
            hides = [each[:0] for each in self.triangles] if is_apart else self.triangles
            flux += _light_of_moon(*vectors, places, radius, normals, area, *hides, self.hapke)
        return flux


KINDS = {"lumpy": _lumpy, "bilobed": _bilobed, "bent": _bent}


def solid(
    rng: np.random.Generator, kind: str, meshes: list[Path] | None = None, tumbles: bool = True
) -> Solid:
    """A random body of a kind, or of one of some files.

    It has three different moments if it is random or tumbles: light shows no rolling about an axis
    of symmetry, and a body that is nearly a sphere turns by psi in hundreds of rotations.
    """
    points, facets = icosphere(3)
    while True:
        hapke = bool(rng.integers(2))
        if meshes:
            made = Solid.of(*read_mesh(meshes[rng.integers(len(meshes))]), hapke)
        else:
            made = Solid.of(KINDS[kind](rng, points), facets, hapke)
        split = np.diff(made.moments)
        if (split[0] > 0.05 and split[1] > 0.01) or (meshes and not tumbles):
            return made


def spotted(rng: np.random.Generator, body: Solid, contrast: float) -> Solid:
    """The body with five spots that are brighter or darker by a share."""
    albedo = np.ones(len(body.areas))
    units = body.centres / np.linalg.norm(body.centres, axis=1)[:, None]
    for _ in range(5):
        cap = units @ _unit(rng) > math.cos(rng.uniform(0.35, 0.9))
        albedo[cap] += rng.choice([-1.0, 1.0]) * contrast * rng.uniform(0.7, 1.0)
    return replace(body, areas=body.areas * np.clip(albedo, 0.3, 2.0))


def unlike_shape(rng: np.random.Generator, moments: np.ndarray, least=0.07, most=0.25):
    """Moments, ascending, some of which differ by such shares from those of the shape."""
    while True:
        change = rng.choice([-1.0, 1.0], 2) * rng.uniform(least, most, 2)
        other = np.append(moments[:2] * (1.0 + change), 1.0)
        if other[1] - other[0] > 0.03 and other[1] < 0.985 and other[0] + other[1] > 1.02:
            return other


# ---- Curves


def _rates(rng, moments, style):
    """Initial rates (3,): in the mode and the part of it that a style names."""
    if style["mode"] == "PA":
        w = np.array([0.0, 0.0, 1.0])
    elif "tilt" in style:
        tilt = math.radians(rng.uniform(*style["tilt"]))
        axis = 2 if style["mode"] == "SAM" else 0
        momentum = np.zeros(3)
        momentum[axis], momentum[2 - axis] = math.cos(tilt), math.sin(tilt)
        inverse = np.sum(momentum**2 / moments)
        if (inverse < 1.0 / moments[1]) != (style["mode"] == "SAM"):
            return None
        w = momentum / moments
    else:
        while True:
            w = rng.normal(size=3) * np.array([1.0, 0.7, 1.0])
            D = np.sum((moments * w) ** 2) / np.sum(moments * w * w)
            edge = moments[0] if moments[1] > D else moments[2]
            inside = 0.06 < (D - edge) / (moments[1] - edge) < 0.9
            if ("LAM" if moments[1] > D else "SAM") == style["mode"] and inside:
                break
    return w * (2.0 * math.pi / style["P"] / np.linalg.norm(w))


def _moon(rng, style, pole):
    """Radius, period, distance, axes of the orbit and phase of a moon; lengths of the body's."""
    radius = rng.uniform(0.3, 0.55)
    period = style["P"] * rng.uniform(3.2, 7.5)
    distance = rng.uniform(2.6, 4.0)
    tilted = pole + 0.12 * rng.normal(size=3) * (rng.uniform() < 0.5)
    tilted /= np.linalg.norm(tilted)
    first = np.cross(tilted, [0.3, 0.8, 0.5])
    first /= np.linalg.norm(first)
    return radius, period, distance, first, np.cross(tilted, first), rng.uniform(0.0, 2 * math.pi)


def case(seed: int, style: dict, meshes: list[Path] | None = None) -> Case:
    """A case of a seed and a style.

    Beside the keywords of `synthetic_curves`: kind, spots, inertia, tilt, survey, outliers,
    halved, clock (d), exposure (d), moon.
    """
    rng = np.random.default_rng(seed)
    while True:
        body = solid(rng, style["kind"], meshes, style["mode"] != "PA")
        if style.get("spots"):
            body = spotted(rng, body, style["spots"])
        moments = unlike_shape(rng, body.moments) if style.get("inertia") else body.moments
        w = _rates(rng, moments, style)
        if w is not None:
            break
    q = rng.normal(size=4)
    start = np.r_[q / np.linalg.norm(q), w]
    orbits = synthetic_curves.encounter(rng, style["span"])
    jd, session, filters = _epochs(rng, style)
    t = jd - 2460000.5
    light = np.zeros_like(t)
    for _ in range(6):
        place = _kepler(orbits[0], t - light)
        light = np.linalg.norm(place - _kepler(orbits[1], t), axis=1) / LIGHT_DAY_AU
    to_sun, to_observer = -place, _kepler(orbits[1], t) - place
    moon, pole = None, _pole(moments, start)
    scene = t - light, to_sun, to_observer
    if style.get("moon"):
        start, pole, moon, exact = _with_moon(rng, body, moments, start, scene, style)
    else:
        exact = _magnitudes(body, moments, start, *scene, None, style)
    sigma = style["noise"] * rng.uniform(0.7, 1.3, t.size)
    magnitude = exact + sigma * rng.normal(size=t.size)
    if "zero" in style:
        width = rng.uniform(*style["zero"])
        magnitude += rng.normal(0.0, width, session.max() + 1)[session]
    if filters is not None:
        magnitude += 0.35 * filters
    if style.get("outliers"):
        wild = rng.random(t.size) < style["outliers"]
        magnitude[wild] += rng.normal(0.0, 0.5, int(wild.sum()))
    if style.get("halved"):
        sigma = 0.5 * sigma
    if style.get("clock"):
        jd = jd + rng.normal(0.0, style["clock"], session.max() + 1)[session]
    if style["mode"] == "PA":
        mode, P_psi, P_phi = "PA", math.inf, style["P"]
    else:
        mode, P_psi, P_phi, pole = synthetic_curves._periods(moments, start)
    return Case(
        jd, magnitude, sigma, session, to_sun, to_observer, mode, P_psi, P_phi, pole, moments,
        style.get("most", 3.2) / style["P"], exact, filters,
        None if moon is None else moon[1], style.get("exposure", 0.0),
    )  # fmt: skip


def _with_moon(rng, body, moments, start, scene, style):
    """State, pole, moon and magnitudes of a body whose moon eclipses it, or is eclipsed.

    Seen near the plane of its orbit, as those moons are that are known by their eclipses: drawn
    until 3 % of the points are fainter by 0.05 mag than both bodies apart.
    """
    _, to_sun, to_observer = scene
    middle = len(to_sun) // 2
    bisector = to_sun[middle] / np.linalg.norm(to_sun[middle])
    bisector = bisector + to_observer[middle] / np.linalg.norm(to_observer[middle])
    while True:
        across = np.cross(bisector, _unit(rng))
        across /= np.linalg.norm(across)
        axes = np.stack([np.cross(across, bisector), bisector, across], axis=-1)
        axes /= np.linalg.norm(axes, axis=0)
        here = np.r_[_quaternion(axes), start[4:]]
        moon = _moon(rng, style, across)
        given = body, moments, here, *scene, moon, style
        exact = _magnitudes(*given)
        if np.mean(exact - _magnitudes(*given, is_apart=True) > 0.05) > 0.03:
            return here, across, moon, exact


def _pole(moments, start):
    """The direction of the angular momentum."""
    momentum = _matrices(start[None, :4])[0] @ (moments * start[4:])
    return momentum / np.linalg.norm(momentum)


def _quaternion(matrix):
    """The quaternion (4,), scalar first, of a rotation matrix."""
    values, vectors = np.linalg.eigh(
        np.array([
            [np.trace(matrix), matrix[2, 1] - matrix[1, 2], matrix[0, 2] - matrix[2, 0],
             matrix[1, 0] - matrix[0, 1]],
            [0.0, 2 * matrix[0, 0] - np.trace(matrix), matrix[0, 1] + matrix[1, 0],
             matrix[0, 2] + matrix[2, 0]],
            [0.0, 0.0, 2 * matrix[1, 1] - np.trace(matrix), matrix[1, 2] + matrix[2, 1]],
            [0.0, 0.0, 0.0, 2 * matrix[2, 2] - np.trace(matrix)],
        ]),
        UPLO="U",
    )  # fmt: skip
    return vectors[:, np.argmax(values)]


def _magnitudes(body, moments, start, left, to_sun, to_observer, moon, style, is_apart=False):
    """Apparent magnitudes (N,) without errors, means over the exposures."""
    r, d = np.linalg.norm(to_sun, axis=1), np.linalg.norm(to_observer, axis=1)
    nodes = 7 if style.get("exposure") else 1
    shifts = (np.arange(nodes) - 0.5 * (nodes - 1)) / nodes * style.get("exposure", 0.0)
    epochs = (left[:, None] + shifts).ravel()
    order = np.argsort(epochs, kind="stable")
    turn = np.empty((len(epochs), 3, 3))
    turn[order] = _matrices(_integrated(moments, start, epochs[order])[:, :4])
    sun, observer = (
        np.einsum("tji,tj->ti", turn, np.repeat(vectors / size[:, None], nodes, axis=0))
        for vectors, size in ((to_sun, r), (to_observer, d))
    )
    places, radius = None, 0.0
    if moon is not None:
        radius, period, distance, first, second, phase = moon
        angle = 2.0 * math.pi * epochs / period + phase
        orbit = np.cos(angle)[:, None] * first + np.sin(angle)[:, None] * second
        places = np.einsum("tji,tj->ti", turn, distance * orbit)
    flux = body.flux(sun, observer, places, radius, is_apart).reshape(-1, nodes).mean(axis=1)
    magnitude = 18.0 - 2.5 * np.log10(flux) + 5.0 * np.log10(r * d)
    if not len(body.hapke):
        alpha = np.degrees(np.arccos(np.clip(np.sum(to_sun * to_observer, 1) / r / d, -1.0, 1.0)))
        magnitude += 0.03 * alpha - 0.35 * np.exp(-alpha / 4.0)
    return magnitude


def _epochs(rng, style):
    """Julian dates, sessions, and filters (or None): nights, or points of a survey."""
    if "survey" not in style:
        return *synthetic_curves._epochs(rng, style), None
    count = int(rng.integers(*style["survey"]))
    nights = np.sort(rng.uniform(0.0, style["span"], count // 2))
    t = np.concatenate([nights, nights + rng.uniform(0.01, 0.03, nights.size)])
    filters = np.tile(rng.integers(0, 2, nights.size), 2)
    order = np.argsort(t)
    jd = 2460000.5 + t[order] - 0.5 * style["span"]
    return jd, np.zeros(t.size, int), filters[order]
