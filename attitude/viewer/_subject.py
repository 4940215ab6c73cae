"""What a page or animation shows: span, attitudes, directions, light curve, surface."""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from functools import partial
from itertools import pairwise
from operator import attrgetter
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from attitude import plots
from attitude._support import pairs
from attitude._support.arrays import units
from attitude._support.quantity_text import quoted
from attitude._textfiles.lines import path_text
from attitude.catalog import motion_of
from attitude.epochs import _inputs
from attitude.errors import AttitudeError, AttitudeWarning
from attitude.frames import quaternion
from attitude.frames import representations as forms
from attitude.motions._free_rotation import FreeRotation
from attitude.scene._scene import Scene
from attitude.shape._ellipsoid import Ellipsoid
from attitude.shape._mesh import Mesh
from attitude.shape._solids import box

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from attitude._support.annotations import EpochOrSeconds, FilePath, FloatArray, IntArray
    from attitude.epochs import _instants
    from attitude.motions._body import Body
    from attitude.motions._history import AttitudeHistory
    from attitude.motions._motion import HasAttitudes, Motion
    from attitude.paths._path import Path
    from attitude.scene._view import View


# ---- Attitudes at the widest steps between which great circles stay within an angle of the motion

# Largest angle between the motion and what is drawn, rad: a tenth of a degree.
TOLERANCE: float = float(np.radians(0.1))
# Of it, what the great circles may take; rounding to 16 bits takes 0.007 degree at most.
_SHARE = 0.85
# Most attitudes of one page: 8 MB of text.
MOST_POSES: int = 400_000
# Largest turn between two attitudes, rad: beyond pi a great circle goes the other way.
_TURN = 2.0
# Places between two attitudes at which the error is measured, in steps; no two have a common
# divisor, so that whole turns between two attitudes are noticed.
_BETWEEN = (0.5, 0.236, 0.691)
# Steps of a piece that are measured, at most, at each trial.
_MEASURED = 4000
# Of a step, by which the last attitude of a piece lies before a jump.
_BEFORE = 1e-9


@dataclass(frozen=True)
class PosePiece:
    """Equally spaced attitudes between two jumps of the angular velocity."""

    start: float  # s from that of the span
    step: float  # s
    wxyz: FloatArray  # (N, 4), body to ICRF
    angular_velocity: FloatArray  # (N, 3), rad/s over the body axes

    @property
    def times(self) -> FloatArray:
        """Times (N,) of the attitudes, s from the start of the span."""
        return self.start + self.step * np.arange(len(self.wxyz), dtype=np.float64)


def pieces(subject: Subject, tolerance: float = TOLERANCE) -> list[PosePiece]:
    """The attitudes of a subject, each piece with the widest step that keeps the tolerance."""
    bounds = np.concatenate([[0.0], subject.breaks(), [subject.duration]])
    poses: list[PosePiece] = []
    for begin, end in pairwise(bounds):
        left = MOST_POSES - sum(len(piece.wxyz) for piece in poses)
        poses.append(_piece(subject, float(begin), float(end), tolerance, left))
    return poses


def _piece(subject, begin, end, tolerance, most):
    """The PosePiece of a stretch, of at most `most` attitudes."""
    length = end - begin
    inner = begin + length * np.linspace(0.5 / 64.0, 63.5 / 64.0, 64)
    fastest = float(np.max(np.linalg.norm(subject.at(inner).angular_velocity, axis=-1)))
    count = max(1, int(np.ceil(fastest * length / _TURN)))
    while True:
        if count + 1 > most:
            raise AttitudeError(
                f"a span of {length:.6g} s needs {count:.2g} attitudes, so that what is drawn "
                f"stays within 0.1 degree of the motion; {MOST_POSES} can be shown. Give a stop at "
                f"most {0.9 * length * most / count:.4g} s after the start."
            )
        error = _error(subject, begin, length, count)
        if error <= _SHARE * tolerance:
            break
        # The error falls with the square of the step at least.
        factor = np.sqrt(error / (_SHARE * tolerance))
        count = int(np.ceil(count * min(max(1.1 * factor, 1.2), 4.0)))
    times = begin + length * np.arange(count + 1) / count
    times[-1] -= _BEFORE * length / count if end < subject.duration else 0.0
    history = subject.at(times)
    rates = np.asarray(history.angular_velocity)
    return PosePiece(begin, length / count, np.asarray(history.wxyz), rates)


def _error(subject: Subject, begin: float, length: float, count: int) -> float:
    """Largest measured angle between the motion and great circles, rad."""
    chosen = np.unique(np.floor(np.linspace(0.0, count - 1.0, min(count, _MEASURED))))
    step = length / count
    inside = 1.0 - _BEFORE
    first, last = (subject.at(begin + step * (chosen + k * inside)).wxyz for k in (0, 1))
    turn = forms.to_rotation_vector(quaternion.multiply(quaternion.conjugate(first), last))
    worst = 0.0
    for share in _BETWEEN:
        motion = subject.at(begin + step * (chosen + share)).wxyz
        between = quaternion.multiply(first, forms.from_rotation_vector(turn * share))
        off = quaternion.multiply(quaternion.conjugate(motion), between)
        angles = np.linalg.norm(forms.to_rotation_vector(off), axis=-1)
        worst = max(worst, float(np.max(angles)))
    return worst


# ---- Directions, trajectory and light curve, at epochs close enough for curves between

# Epochs of directions at first.
_FIRST = 33
# Epochs of directions at most: 4 MB of text.
_MOST_DIRECTIONS = 262_145
# s between states of a trajectory at first, their number at first, and at most: 14 MB of text.
_STEP = 60.0
_FIRST_STATES = 2_001
_MOST_STATES = 128_001
# Largest error of a trajectory between its states, m.
_OFF = 10.0
# Points of a light curve for each half turn, where these are at most _CURVE, and at least.
_HALF_TURN = 40.0
_FEWEST = 10.0
_CURVE = 4000
# Points of a light curve at least.
_LEAST = 240
# Points of a light curve at most: some ten seconds.  A page has the extremes of a longer curve.
_MOST_POINTS = 200_000
# Facets times points, roughly, that are computed in some ten seconds.
_WORK = 100_000_000
# Points of a light curve computed between two reports.
_BLOCK = 250


def directions(subject: Subject, which: str) -> FloatArray:
    """Unit vectors (N, 3), ICRF, to "sun" or "observer" at equal steps over the span.

    Lines between neighbours stay within 0.1 degree; a fixed direction is one row.
    """

    def error(times, vectors):
        middle = units(vectors[:-2:2] + vectors[2::2])
        # That of lines over twice the step, which falls with its square.
        return np.degrees(np.linalg.norm(middle - vectors[1:-1:2], axis=1).max()) / 4.0

    vectors = _close_enough(
        subject.duration,
        partial(subject.toward, which),
        error,
        np.degrees(TOLERANCE),
        (_FIRST, _MOST_DIRECTIONS),
        f"directions to the {which}",
        "deg",
    )[1]
    return vectors if np.ptp(vectors, axis=0).max() > 0.0 else vectors[:1]


def trajectory(subject: Subject, path: Path) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Times (N,), s from the start, at equal steps, positions (N, 3), m, and velocities (N, 3).

    Cubic Hermite curves between neighbours stay within 10 m.
    """

    def error(times, states):
        (a, middle, b), (before, _, after) = (
            (rows[:-2:2], rows[1:-1:2], rows[2::2]) for rows in states
        )
        off = middle - 0.5 * (a + b) - times[2] / 8.0 * (before - after)
        # That over twice the step, which falls with its fourth power.
        return np.linalg.norm(off, axis=1).max() / 16.0

    first = int(np.clip(np.ceil(subject.duration / _STEP) + 1.0, 9, _FIRST_STATES))
    times, states = _close_enough(
        subject.duration,
        partial(path.state, subject.start),
        error,
        _OFF,
        (first, _MOST_STATES),
        "positions",
        "m",
    )
    return times, *states


def _close_enough(duration, sample, error, bound, counts, noun, unit):
    """Times (N,) and what a function returns there, with an error within a bound, or a warning."""
    count, most = counts
    while True:
        times = np.linspace(0.0, duration, count)
        rows = sample(times)
        worst = error(times, rows)
        if worst <= bound:
            return times, rows
        if count >= most:
            warnings.warn(
                f"the {noun} are {times[1]:.4g} s apart, and off by up to {worst:.2g} {unit} in "
                f"between, where {bound:.1g} {unit} is aimed at; give a shorter span.",
                AttitudeWarning,
                stacklevel=3,
            )
            return times, rows
        count = 2 * count - 1


def light_curve(
    subject: Subject, progress: Callable[[int, int], object] | None = None
) -> dict[str, Any] | None:
    """Times in s from the start, and magnitudes (inf where nothing is seen); None without a shape.

    ``progress(done, count)`` is called after each block.
    """
    if subject.magnitude is None or subject.scene is None or subject.scene.shape is None:
        return None
    times = np.linspace(0.0, subject.duration, _points(subject))
    block = max(_BLOCK, len(times) // 100)
    parts = []
    for begin in range(0, len(times), block):
        parts.append(subject.magnitude(subject.view(times[begin : begin + block])))
        if progress is not None:
            progress(min(begin + block, len(times)), len(times))
    times, magnitudes = plots.extremes(times, np.concatenate(parts))
    return {"times": times, "magnitudes": magnitudes, "label": subject.label}


def _points(subject: Subject) -> int:
    """Points of the light curve: a body shows two maxima a turn."""
    inner = subject.duration * np.linspace(0.5 / 32.0, 31.5 / 32.0, 32)
    rates = np.linalg.norm(subject.at(inner).angular_velocity, axis=-1)
    half_turns = float(np.mean(rates)) * subject.duration / np.pi
    turn = 2.0 * subject.duration / half_turns if half_turns > 0.0 else np.inf
    shape = subject.scene.shape if subject.scene is not None else None
    costly = _WORK // len(shape) if isinstance(shape, Mesh) else _MOST_POINTS
    most = max(min(_MOST_POINTS, costly), _LEAST)
    plots.warn_of_coarse("the light curve has a point", subject.duration / most, turn)
    wanted = max(min(_HALF_TURN * half_turns, _CURVE), _FEWEST * half_turns)
    return int(np.clip(wanted, _LEAST, most))


# ---- The shadow of other bodies

# Epochs at which it is computed at first, at least and at most, and s between them, in which a
# satellite in a low orbit passes a tenth of the shadow of its planet.
_SHADE = 1025
_MOST_SHADE = 200_001
_SHADE_STEP = 300.0
# Epochs within each interval in which it changes.
_FINER = 33


class Shade(NamedTuple):
    """How much of the Sun's disc other bodies leave free, by lines between times."""

    times: FloatArray  # (N,), s from the start
    lit: FloatArray  # (N,), fractions
    names: str  # of the bodies, as in "the Earth's"


def shade(subject: Subject) -> Shade | None:
    """The shade of a subject over its span; None without a scene, or in sunlight throughout."""
    scene = subject.scene
    if scene is None or not scene.shadow_of:
        return None
    count = int(np.clip(subject.duration / _SHADE_STEP, _SHADE, _MOST_SHADE))
    times = np.linspace(0.0, subject.duration, count)
    if count == _MOST_SHADE:
        warnings.warn(
            f"the shadow is computed every {times[1]:.4g} s, so that shorter eclipses are not "
            "drawn; give a shorter span to see all.",
            AttitudeWarning,
            stacklevel=2,
        )
    lit = np.asarray(subject.view(times).lit_fraction)
    if np.all(lit == 1.0):
        return None
    within = np.linspace(0.0, 1.0, _FINER)
    changing = np.flatnonzero(np.diff(lit) != 0.0)
    finer = times[changing, None] + np.diff(times)[changing, None] * within
    times = np.unique(np.concatenate([times, finer.ravel()]))
    names = " or ".join(_of_body(name) for name in scene.shadow_of)
    return Shade(times, np.asarray(subject.view(times).lit_fraction), names)


def _of_body(name: str) -> str:
    """The genitive of a body's name: the Earth's, the Moon's, Mars's."""
    article = "the " if name in ("earth", "moon") else ""
    return f"{article}{name.capitalize()}'s"


# ---- Poinsot's construction: the ellipsoid of inertia that rolls on the invariable plane
# The ellipsoid is x . I x = s^2 in body axes, I the inertia tensor, s a scale.  Its point s omega /
# sqrt(2 E) touches the plane across the angular momentum L at the distance s sqrt(2 E) / L; the
# point draws the polhode on the ellipsoid and the herpolhode on the plane.

# Longest over shortest semi-axis that is drawn: the moment of a rod's own axis is zero.
_LONGEST = 8.0
# Points of the polhode.
_POLHODE = 361
# Points of the herpolhode for a turn of the faster phase.
_A_TURN = 48.0
# Points of the herpolhode at most.
_MOST = 6000


def inertia_ellipsoid(body: Body | None) -> tuple[FloatArray, FloatArray] | None:
    """Semi-axes (3,), the longest 1, and axes (3, 3) in columns; None if all moments are zero."""
    if body is None or not np.any(body.moments > 0.0):
        return None
    least = np.max(body.moments) / _LONGEST**2
    semi = 1.0 / np.sqrt(np.maximum(body.moments, least))
    return semi / semi.max(), np.asarray(body.principal_axes)


def construction(subject: Subject) -> dict[str, Any] | None:
    """The curves of a free rotation, in units of the longest semi-axis; None for other motions.

    "semi_axes", "axes", "distance" of the plane, "pole" (unit vector of the momentum, ICRF),
    "rate" (the angular velocity of which the ellipsoid has its unit, rad/s), "polhode" (body axes)
    and "herpolhode" (ICRF), rows of 3.
    """
    motion = subject.motion
    if not isinstance(motion, FreeRotation) or np.min(motion.body.moments) <= 0.0:
        return None
    energy, momentum = motion.energy, motion.momentum
    size = float(np.linalg.norm(momentum))
    ellipsoid = inertia_ellipsoid(motion.body)
    if ellipsoid is None or not energy > 0.0 or not size > 0.0:
        return None
    # s / sqrt(2 E), with s such that the longest semi-axis s / sqrt(least moment) is 1.
    per_rate = float(np.sqrt(np.min(motion.body.moments) / (2.0 * energy)))
    history = subject.at(_times_of_herpolhode(subject))
    return {
        "semi_axes": ellipsoid[0],
        "axes": ellipsoid[1],
        "distance": per_rate * 2.0 * energy / size,
        "pole": momentum / size,
        "rate": 1.0 / per_rate,
        "polhode": motion.polhode(_POLHODE) * per_rate,
        "herpolhode": quaternion.rotate(history.wxyz, history.angular_velocity) * per_rate,
    }


def _times_of_herpolhode(subject):
    """Times (N,), s, of the points of the herpolhode: as much of the span as is drawn finely."""
    shortest = plots.shortest_period(subject.motion)
    span = min(subject.duration, shortest * _MOST / _A_TURN)
    return np.linspace(0.0, span, int(np.clip(_A_TURN * span / shortest, 64, _MOST)))


# ---- The surface that is drawn: the facets of a shape, the ellipsoid of inertia, or a box

# Most facets that are drawn; of a finer mesh, vertices within small cubes become one.
MOST_FACETS: int = 200_000
# Facets of the coarser mesh that is drawn while frames take too long.
COARSE: int = 10_000
# Facets of an ellipsoid.
_FACETS = 5120
# Turn at a corner, rad, from which it is a crease.
_CREASE = np.radians(20.0)
# Share of the corners of a smooth surface that turn by less.
_SMOOTH_SHARE = 0.98
# m, of a body without a known shape or inertia.
_BOX = (1.0, 0.7, 0.45)


class Surface(NamedTuple):
    """Triangles in body axes."""

    vertices: FloatArray  # (V, 3), in units of the greatest distance of a vertex from the origin
    facets: IntArray  # (F, 3)
    kind: str  # "mesh", "ellipsoid", "ellipsoid of inertia" or "box"
    size: float  # the unit of the vertices in m; NaN if the size is unknown
    closed: bool  # whether no facet is seen from behind
    smooth: bool  # whether the facets stand for a curved surface


def surface(subject: Subject, most: int = MOST_FACETS) -> Surface:
    """The surface of a subject, of at most about `most` facets."""
    shape = subject.shape
    if isinstance(shape, Ellipsoid):
        return _scaled(shape.facets(min(_FACETS, most)), "ellipsoid")
    if isinstance(shape, Mesh):
        drawn = _scaled(_drawn(shape, most), "mesh", np.linalg.norm(shape.vertices, axis=1).max())
        return drawn._replace(closed=shape.is_closed and not len(shape.inward_facets))
    ellipsoid = inertia_ellipsoid(subject.motion.body)
    if ellipsoid is None:
        return _scaled(box(_BOX), "box")._replace(size=np.nan)
    ball = Ellipsoid((1.0, 1.0, 1.0)).facets(min(_FACETS, most))
    stretched = ball.vertices * ellipsoid[0] @ ellipsoid[1].T
    drawn = _scaled((stretched, ball.facets), "ellipsoid of inertia")
    return drawn._replace(size=np.nan)


def _scaled(mesh, kind, size=None):
    """The Surface of a Mesh, or of vertices and facets."""
    vertices, facets = (mesh.vertices, mesh.facets) if isinstance(mesh, Mesh) else mesh
    if size is None:
        size = np.linalg.norm(vertices, axis=1).max()
    smooth = _is_smooth(vertices, facets)
    return Surface(vertices / size, facets, kind, float(size), closed=True, smooth=smooth)


def _is_smooth(vertices, facets):
    """Whether nearly all facets turn little from the mean of those about their corners."""
    a, b, c = (vertices[facets[:, k]] for k in range(3))
    normals = np.cross(b - a, c - a)
    around = np.zeros(vertices.shape)
    for k in range(3):
        np.add.at(around, facets[:, k], normals)
    mean = around[facets]
    lengths = np.linalg.norm(normals, axis=1)[:, None] * np.linalg.norm(mean, axis=2)
    with np.errstate(invalid="ignore", divide="ignore"):
        cosines = np.einsum("fk,fjk->fj", normals, mean) / lengths
    return bool(np.mean(cosines > np.cos(_CREASE)) > _SMOOTH_SHARE)


def _drawn(mesh, most):
    """The mesh, or vertices and facets of a coarser one, with a warning."""
    if len(mesh) <= most:
        return mesh
    vertices, facets = coarser(mesh.vertices, mesh.facets, most)
    warnings.warn(
        f"the mesh has {len(mesh)} facets, of which a page draws {most} at most: it is drawn with "
        f"{len(facets)}; brightness follows from all of them.",
        AttitudeWarning,
        stacklevel=2,
    )
    return vertices, facets


def coarser(vertices: FloatArray, facets: IntArray, most: int) -> tuple[FloatArray, IntArray]:
    """Vertices and facets of a surface with at most `most` facets, from one that has more."""
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    # A closed surface of n^2 cubes a side has some 12 n^2 triangles.
    cells = np.sqrt(most / 12.0)
    best, tried = None, 0
    while best is None or (len(best[1]) < 0.8 * most and tried < 6):
        clusters = _clustered(vertices, facets, low, float(np.max(high - low)) / cells)
        count = len(clusters[1])
        if count <= most and (best is None or count > len(best[1])):
            best = clusters
        cells *= 0.95 * np.sqrt(most / max(count, 1))
        tried += 1
    return best


def _clustered(vertices, facets, low, side):
    """Vertices in cubes of a side, each cube's as one, and the facets that keep three corners."""
    cubes = np.floor((vertices - low) / side).astype(np.int64)
    key = (cubes[:, 0] << 42) | (cubes[:, 1] << 21) | cubes[:, 2]
    _, member, count = np.unique(key, return_inverse=True, return_counts=True)
    means = [np.bincount(member, vertices[:, k]) / count for k in range(3)]
    corners = member[facets]
    a, b, c = corners.T
    kept = corners[(a != b) & (b != c) & (c != a)]
    # Each triangle once, whichever corner it begins with.
    first = np.argmin(kept, axis=1)[:, None]
    turned = np.take_along_axis(kept, (first + np.arange(3)) % 3, axis=1)
    return np.stack(means, axis=1), np.unique(turned, axis=0)


# Turns that are shown of a motion without periods and without a span of its own.
_TURNS = 10.0
# s that are shown of a body at rest.
_AT_REST = 3600.0


@dataclass(frozen=True)
class Subject:
    """What is shown, at seconds of TDB from `start`; made by `subject`.

    In a scene these are times at which light is received: the attitude is the one that it shows.
    """

    motion: Motion
    scene: Scene | None
    shape: Ellipsoid | Mesh | None
    start: _instants.Instant
    duration: float
    title: str
    magnitude: Callable[[View], FloatArray] | None
    label: str

    def at(self, times: FloatArray) -> AttitudeHistory:
        """The attitudes that are seen at times (N,), s from the start."""
        if self.scene is not None:
            return self.view(times).attitude
        hi, lo = pairs.add(self._offset(), np.asarray(times, dtype=np.float64))
        return self.motion.at(hi, low=lo)

    def view(self, times: FloatArray) -> View:
        """The scene at times (N,), s from the start."""
        assert self.scene is not None
        return self.scene.since(self.start, times)

    def toward(self, which: str, times: FloatArray) -> FloatArray:
        """Unit vectors (N, 3), ICRF, to "sun" or "observer" of the scene at times (N,)."""
        view = self.view(times)
        unit = view.sun_direction_icrf if which == "sun" else view.observer_direction_icrf
        return np.broadcast_to(np.asarray(unit), (len(times), 3))

    def breaks(self) -> FloatArray:
        """Times within the span at which the angular velocity jumps, s from the start."""
        joints = self.motion.breaks()
        hi, lo = self._offset()
        seconds = (joints[:, 0] - hi) + (joints[:, 1] - lo)
        if self.scene is not None and len(seconds):
            # Light arrives later than it leaves: the delay at the start serves the whole span.
            left = self.view(np.zeros(1)).emission
            seconds = seconds + (hi - left.hi[0]) + (lo - left.low[0])
        return np.sort(seconds[(seconds > 0.0) & (seconds < self.duration)])

    def utc(self, times: FloatArray) -> list[str]:
        """ISO texts in UTC of times, s from the start."""
        return [self.start.after(float(time)).utc_iso for time in times]

    def _offset(self) -> tuple[float, float]:
        epoch, start = self.motion.epoch, self.start
        return pairs.add((start.seconds, start.low), -epoch.seconds, -epoch.low)


def output_name(output: FilePath, endings: Sequence[str]) -> str:
    """The name of a file with one of some endings; AttitudeError for others."""
    name = path_text(output, "output")
    if name.rpartition(".")[2].lower() not in endings:
        listed = " or ".join(f".{ending}" for ending in endings)
        raise AttitudeError(f"output is {name!r}; give a name that ends in {listed}.")
    return name


def subject(
    motion_or_scene: HasAttitudes | Scene | str,
    start: EpochOrSeconds | None = None,
    stop: EpochOrSeconds | None = None,
    *,
    shape: Ellipsoid | Mesh | None = None,
    title: str | None = None,
    magnitude: tuple[Callable[[View], FloatArray], str] | None = None,
) -> Subject:
    """The Subject of a motion or a scene; magnitude: (callable, str)."""
    if shape is not None and not isinstance(shape, (Ellipsoid, Mesh)):
        raise AttitudeError(
            f"shape is {type(shape).__name__}; give an Ellipsoid or Mesh of attitude.shape, such "
            "as shape.read(file)."
        )
    if title is not None and not isinstance(title, str):
        raise AttitudeError(f"title is {quoted(title)}; give text.")
    scene = motion_or_scene if isinstance(motion_or_scene, Scene) else None
    motion = (
        motion_or_scene.motion if isinstance(motion_or_scene, Scene) else motion_of(motion_or_scene)
    )
    if motion is None:
        raise AttitudeError("the scene has no motion; give Scene(motion, ...) to show one.")
    first, last = _span(motion, start, stop)
    if scene is not None and scene.shape is not None and magnitude is None:
        is_far = scene.sun.is_direction or scene.observer.is_direction
        name = "reduced_magnitude" if is_far else "magnitude"
        magnitude = attrgetter(name), name.replace("_", " ")
    drawn = shape if shape is not None or scene is None else scene.shape
    title = type(motion).__name__ if title is None else title
    of_view, label = magnitude or (None, "magnitude")
    return Subject(motion, scene, drawn, first, last.since(first), title, of_view, label)


def _span(motion, start, stop):
    """The first and the last Instant."""
    span = motion.span or (motion.epoch, None)
    first, last = (
        end if value is None else motion.epoch.after(*_inputs.one_since(motion.epoch, value, name))
        for name, value, end in zip(("start", "stop"), (start, stop), span, strict=True)
    )
    if last is None:
        last = first.after(_typical(motion))
    if not last.since(first) > 0.0:
        raise AttitudeError(
            f"stop is {last.utc_iso} and start {first.utc_iso}; give a stop after the start."
        )
    return first, last


def is_free(motion: Motion) -> bool:
    """Whether a motion has the periods of a free rotation."""
    try:
        _ = motion.regime
    except AttitudeError:
        return False
    return True


def _typical(motion):
    """Seconds that show what a motion without a span does."""
    rate = float(np.linalg.norm(motion.at(0.0).angular_velocity))
    if is_free(motion):
        return plots.time_span(motion) if rate > 0.0 else _AT_REST
    turns = _TURNS * 2.0 * np.pi / rate if rate > 0.0 else _AT_REST
    return float(np.max(motion.joints, initial=0.0)) + turns
