"""The intervals in which conditions hold: windows, passes, glints, as timetables."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from attitude._support import markup, validation
from attitude._support.arrays import Immutable, frozen
from attitude._support.constants import SPEED_OF_LIGHT_M_S
from attitude._support.synonyms import arguments
from attitude.conditions._conditions import condition_of
from attitude.conditions._moments import Source
from attitude.conditions._search import difference
from attitude.epochs import _instants
from attitude.errors import AttitudeError
from attitude.events._channels import SUN_RADIUS, Mirrored, glint
from attitude.events._search import Events, source_of, span, stream
from attitude.paths import _composed
from attitude.paths._path import common_span, spelled
from attitude.scene._scene import Scene
from attitude.shape._mesh import Mesh, flat_sides

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from astropy.time import Time
    from numpy.typing import NDArray

    from attitude._support.annotations import (
        BoolArray,
        EpochOrSeconds,
        FloatArray,
        IntArray,
        Real,
        Reals,
    )
    from attitude._support.tables import FlatTable
    from attitude.conditions._conditions import Condition, Joinable
    from attitude.conditions._moments import Pair
    from attitude.epochs._instants import Instant
    from attitude.events._channels import VectorFunction


# ---- Rows of events with named columns: times, numbers with units, names; as tables and files


class TimetableColumn(NamedTuple):
    """Values (N,), their unit (SI, or "time"), that of tables, and the low part of a time."""

    values: NDArray[Any]
    unit: str = ""
    shown: str = ""
    low: NDArray[Any] | float = 0.0


class Timetable(Immutable):
    """Rows of events in order of time; each column is an attribute (N,) too.

    Plain numbers of times are TDB seconds since `epoch`; `time` gives dates.

    Attributes
    ----------
    epoch : Instant
        That of the motion; J2000 for a scene without a motion.
    columns : dict of TimetableColumn
        By name.
    """

    epoch: _instants.Instant
    columns: dict[str, TimetableColumn]

    def __init__(self, epoch: _instants.Instant, columns: Mapping[str, TimetableColumn]) -> None:
        self._set_all(epoch=epoch, columns=dict(columns))
        self._set_all(**{name: frozen(np.asarray(c.values)) for name, c in columns.items()})

    if not TYPE_CHECKING:

        def __getattr__(self, name: str) -> Any:
            """The sentence for a column that is not there."""
            columns = self.__dict__.get("columns", {})
            raise AttributeError(
                f"{type(self).__name__} has no {name!r}; its columns are {', '.join(columns)}."
            )
    else:

        def __getattr__(self, name: str) -> NDArray[Any]:
            """A column."""
            return self.columns[name].values

    def __len__(self) -> int:
        return len(next(iter(self.columns.values())).values)

    def __getitem__(self, index: Any) -> Timetable:
        """Some of the rows: found[:3], found[found.elevation > 1]."""
        rows = np.atleast_1d(np.arange(len(self))[index])
        columns = {
            name: column._replace(
                values=column.values[rows],
                low=column.low[rows] if isinstance(column.low, np.ndarray) else column.low,
            )
            for name, column in self.columns.items()
        }
        return self._with(columns)

    def _with(self, columns: Mapping[str, TimetableColumn]) -> Timetable:
        return Timetable(self.epoch, columns)

    def time(self, name: str) -> Time:
        """A column of times (N,) as an astropy Time in UTC; masked where it is not known.

        Raises
        ------
        AttitudeError
            For a column that holds no times.
        """
        times = [of_times for of_times, column in self.columns.items() if column.unit == "time"]
        if name not in times:
            raise AttitudeError(f"{name!r} is no column of times; give one of {', '.join(times)}.")
        column = self.columns[name]
        low = np.broadcast_to(np.asarray(column.low, dtype=float), column.values.shape)
        times_utc = _instants.times(self.epoch, column.values, low).utc
        times_utc.format = "isot"
        return times_utc

    def table(self) -> FlatTable:
        """An astropy QTable: times in UTC, numbers with units; ``.write("x.ecsv")`` keeps both."""
        from astropy.units import Unit

        from attitude._support.tables import FlatTable

        rows = FlatTable(meta={"epoch": f"{self.epoch.utc_iso} UTC", "times": "UTC"})
        for name, column in self.columns.items():
            if column.unit == "time":
                rows[name] = self.time(name)
            elif column.unit:
                values = np.array(column.values) * Unit(column.unit)
                rows[name] = values.to(column.shown or column.unit)
            else:
                rows[name] = np.array(column.values)
        return rows

    def to_pandas(self) -> Any:
        """A pandas DataFrame of `table`; AttitudeError if pandas is not installed."""
        return self.table().to_pandas()

    def __repr__(self) -> str:
        return f"<{len(self)} {type(self).__name__}: {', '.join(self.columns)}>"

    def _repr_html_(self) -> str:
        """The first rows for notebooks, times in UTC."""
        name = type(self).__name__
        return markup.of_table(f"{len(self)} {name}, times in UTC", self.table())

    def __str__(self) -> str:
        shown = self.table()
        for name in shown.colnames:
            if getattr(getattr(shown[name], "dtype", None), "kind", "") == "f":
                shown[name].info.format = ".3f"
        return "\n".join(shown.pformat(max_lines=-1, max_width=-1))


# ---- The greatest value of a function in each of many intervals, by samples that close in on it

# Parts of the shortest interval, and of what each round leaves.
_PARTS = 64
# Rounds, each of which leaves two of the parts of the round before.
_ROUNDS = 4
# Values that are computed together.
_BLOCK = 1 << 16


def _highest(value, begin, end, spacing):
    """The places (N,) of the greatest values within intervals; their ends count.

    To 1e-6 of `spacing`, at which samples show every maximum.
    """
    if not len(begin):
        return begin
    parts = np.maximum(np.ceil((end - begin) / spacing), _PARTS).astype(np.int64)
    step = (end - begin) / parts
    owner = np.repeat(np.arange(len(begin)), parts + 1)
    first = np.cumsum(parts + 1) - (parts + 1)
    number = np.arange(len(owner)) - first[owner]
    places = np.minimum(begin[owner] + number * step[owner], end[owner])
    heights = _heights(value, places)
    left = np.where(number > 0, np.roll(heights, 1), heights)
    right = np.where(number < parts[owner], np.roll(heights, -1), heights)
    # The top of a smooth maximum is above its sample by less than a neighbour is below.
    above = heights + (heights - np.minimum(left, right))
    greatest = np.maximum.reduceat(heights, first)[owner]
    tops = np.flatnonzero((heights >= left) & (heights >= right) & (above >= greatest))
    owner, place = owner[tops], places[tops]
    a = np.maximum(place - step[owner], begin[owner])
    b = np.minimum(place + step[owner], end[owner])
    for _ in range(_ROUNDS):
        places = a + (b - a) * (np.arange(_PARTS + 1) / _PARTS)[:, None]
        heights = _heights(value, places.reshape(-1)).reshape(places.shape)
        top, every = np.argmax(heights, axis=0), np.arange(len(a))
        a = places[np.maximum(top - 1, 0), every]
        b = places[np.minimum(top + 1, _PARTS), every]
    order = np.lexsort((heights[top, every], owner))
    last = np.searchsorted(owner, np.arange(len(begin)), side="right") - 1
    return places[top, every][order[last]]


def _heights(value, seconds):
    """The values (N,) of a function of seconds, block by block; NaN is replaced by the least."""
    blocks = range(0, len(seconds), _BLOCK)
    heights = np.concatenate([value(seconds[k : k + _BLOCK]) for k in blocks])
    return np.nan_to_num(heights, nan=-np.finfo(np.float64).max)


class Windows(Timetable):
    """The intervals in which a condition holds; made by `windows`.

    Attributes
    ----------
    begin, end : (N,) arrays
        TDB seconds since the epoch; those of the search where the condition holds at its ends.
    duration : (N,) array
        s.
    start, stop : pairs of doubles
        The span of the search, s.
    """

    start: Pair
    stop: Pair

    def __init__(
        self,
        epoch: Instant,
        columns: Mapping[str, TimetableColumn],
        start: Pair,
        stop: Pair,
    ) -> None:
        super().__init__(epoch, columns)
        self._set_all(start=start, stop=stop)

    def _with(self, columns: Mapping[str, TimetableColumn]) -> Windows:
        return Windows(self.epoch, columns, self.start, self.stop)

    @property
    def span(self) -> float:
        """Length of the search, s."""
        return difference(self.start, self.stop)

    @property
    def total(self) -> float:
        """Sum of the durations, s."""
        return float(np.sum(self.duration))

    @property
    def share(self) -> float:
        """The total over the length of the search; NaN for a search of no length."""
        return self.total / self.span if self.span > 0.0 else float("nan")

    @property
    def gaps(self) -> Windows:
        """The intervals of the search in which the condition does not hold."""
        begin, end = self.columns["begin"], self.columns["end"]
        edges = [_edge(self.start), _edges(end)], [_edges(begin), _edge(self.stop)]
        first, last = (np.concatenate(pair, axis=1) for pair in edges)
        length = (last[0] - first[0]) + (last[1] - first[1])
        first, last = first[:, length > 0.0], last[:, length > 0.0]
        return _of_edges(self.epoch, first, last, self.start, self.stop)

    @property
    def worst_gap(self) -> float:
        """The longest gap, also before the first and after the last window, s; 0 without gaps."""
        return float(np.max(self.gaps.duration, initial=0.0))


def windows(
    condition: Joinable, start: EpochOrSeconds | None = None, stop: EpochOrSeconds | None = None
) -> Windows:
    """The intervals of a span in which a condition holds.

    Parameters
    ----------
    condition : Condition
    start, stop : epochs or seconds, optional
        As in `find_discrete`; by default the span for which the motion and the path of the body
        are known, which begins a light time later in a scene that has one.

    Returns
    -------
    Windows
        Windows that are open at the ends of the span begin or end there.

    Raises
    ------
    AttitudeError
        For other objects, and where no span is given and none follows, or one with a gap in which
        the path is not known.
    """
    known = condition_of(condition, "condition")
    return windows_of([known], *_span_of(known.source, start, stop))[0]


def windows_of(conditions: Sequence[Condition], start: Pair, stop: Pair) -> list[Windows]:
    """The windows of each of several conditions of one source, searched together."""
    source = conditions[0].source
    first_epoch, last_epoch = (source.epoch.after(*instant) for instant in (start, stop))
    changes = Events.joined(source.epoch, list(stream(first_epoch, last_epoch, list(conditions))))
    first = source.at(np.array([start[0]]), np.array([start[1]]))
    windows = []
    for k, condition in enumerate(conditions):
        changes_of = changes[changes.which == k]
        edges = np.stack([changes_of.seconds, changes_of.low])
        begins, ends = edges[:, changes_of.values], edges[:, ~changes_of.values]
        if condition.states(condition.signs(first))[0]:
            begins = np.concatenate([_edge(start), begins], axis=1)
        if begins.shape[1] > ends.shape[1]:
            ends = np.concatenate([ends, _edge(stop)], axis=1)
        windows.append(_of_edges(source.epoch, begins, ends, start, stop))
    return windows


def _span_of(source, start, stop):
    """Start and stop as pairs of seconds since the epoch of a source."""
    if start is not None and stop is not None:
        return span(source, start, stop)
    known = _known_span(source)
    if known is None:
        missing = "start" if start is None else "stop"
        raise AttitudeError(
            f"{missing} is not given, and neither motion nor path has an end from which it "
            'follows; give start and stop, such as "2026-01-01" and "2026-01-02".'
        )
    ends = span(source, *(b if a is None else a for a, b in zip((start, stop), known, strict=True)))
    if source.scene is not None and source.scene.center is not None:
        _refuse_gaps(source.scene.center, *(source.epoch.after(*end) for end in ends))
    return ends


def _refuse_gaps(path, start, stop):
    """AttitudeError for a span, not given in full, in which a path has a gap."""
    until = start
    for first, last in path._spans():
        if first.since(until) > _WITHIN and stop.since(first) > 0.0:
            raise AttitudeError(
                f"{path.name} is not known from {spelled(until)} to {spelled(first)}; give start "
                "and stop, on one side of that gap."
            )
        until = last if last.since(until) > 0.0 else until


# More than the light time at an epoch, over the light time that ends later.
_LONGER = 1.001
# Shadows need earlier positions of the body where these are nearer, light seconds.
_NEAR = 1.0
# From the ends of a path, s: more than the rounding of an epoch to one double since J2000.
_WITHIN = 1e-6


def _known_span(source):
    """The epochs at which motion and path are known, as they are seen; None without an end."""
    scene = source.scene
    center = None if scene is None else scene.center
    known = common_span([limit for limit in (source.motion, center) if limit is not None])
    if known is None or center is None:
        return known
    delay = 0.0
    if scene.light_time:
        # What is seen at first left the body a light time before, and a shadow its caster earlier.
        delays = [_light_time(scene, body, known[0]) for body in scene.shadow_of]
        delay = min(max(delays, default=0.0), _NEAR)
        if not scene.observer.is_direction:
            delay += _light_time(scene, scene.observer, known[0])
    return known[0].after(_LONGER * delay + _WITHIN), known[1].after(-_WITHIN)


def _light_time(scene, place, instant):
    """Seconds of light between a place and the body, both at one epoch."""
    vector = _composed.relative(scene.center, place, scene.ephemeris).position(instant, 0.0)
    return float(np.linalg.norm(vector)) / SPEED_OF_LIGHT_M_S


def _edge(pair: Pair) -> FloatArray:
    """A pair as (2, 1)."""
    return np.array(pair)[:, None]


def _edges(column: TimetableColumn) -> FloatArray:
    """A column of times as (2, N)."""
    return np.stack(np.broadcast_arrays(column.values, np.asarray(column.low, dtype=float)))


def _of_edges(epoch, begin, end, start, stop):
    length = (end[0] - begin[0]) + (end[1] - begin[1])
    columns = {
        "begin": TimetableColumn(begin[0], "time", low=begin[1]),
        "end": TimetableColumn(end[0], "time", low=end[1]),
        "duration": TimetableColumn(length, "s"),
    }
    return Windows(epoch, columns, start, stop)


# ---- Passes of a body over a ground site: rise, culmination and set


class Passes(Timetable):
    """Passes over a ground site, one a row; made by `passes`.

    Attributes
    ----------
    rise, culmination, set : (N,) arrays
        TDB seconds since the epoch; NaN for a rise before and a set after the search.
    elevation : (N,) array
        The greatest one, rad.
    rise_azimuth, azimuth, set_azimuth : (N,) arrays
        At rise, culmination and set, rad.
    distance : (N,) array
        At culmination, m.
    sun_elevation : (N,) array
        At culmination, rad.
    duration : (N,) array
        From rise to set within the search, s.
    visible_from, visible_until, visible : (N,) arrays
        The first and the last epoch at which all conditions hold, and for how many s they do; of
        passes with conditions only.
    """


@arguments(
    dict.fromkeys(("center", "path", "site", "observer"), "give it to the scene"),
    'passes(Scene(None, center="iss.tle", observer="568"), elevation="10 deg")',
)
def passes(
    scene: Scene,
    start: EpochOrSeconds | None = None,
    stop: EpochOrSeconds | None = None,
    *,
    elevation: Real = 0.0,
    sunlit: bool = False,
    night: Real | None = None,
    where: Joinable | None = None,
) -> Passes:
    """The passes of the scene's body over its ground site.

    Parameters
    ----------
    scene : Scene
        With a ground site as its observer; a motion is not needed.
    start, stop : epochs or seconds, optional
        As in `windows`.
    elevation : float, Quantity or text
        A pass is a time above this elevation, rad.
    sunlit : bool
        Whether passes count only where a part of the Sun's disc is seen from the body.
    night : float, Quantity or text, optional
        Passes count only where the Sun is lower than this over the site, such as "-6 deg".
    where : Condition, optional
        Any other condition of the scene.

    Returns
    -------
    Passes
        A pass in which the conditions never hold together is left out.

    Raises
    ------
    AttitudeError
        For an observer that is no ground site, and as `windows`.

    Notes
    -----
    Elevations are those of the scene: with aberration=True as seen from the ground, with
    light_time=False geometric, as other satellite tools print them; without refraction.
    """
    site_of(scene)
    lowest = validation.angle_from_plane(elevation, "elevation", "10 deg")
    above = scene.quantity("elevation") > lowest
    more: list[Condition] = [] if where is None else [condition_of(where, "where")]
    if validation.flag(sunlit, "sunlit"):
        more.append(scene.quantity("lit_fraction") > 0.0)
    if night is not None:
        dark = validation.angle_from_plane(night, "night", "-6 deg")
        more.append(scene.quantity("sun_elevation") < dark)
    visible = above
    for condition in more:
        visible = visible & condition
    ends = _span_of(above.source, start, stop)
    up, seen = windows_of([above, visible], *ends)
    owner = np.asarray(np.searchsorted(up.begin, seen.begin, side="right") - 1, dtype=np.int64)
    kept = np.unique(owner) if more else np.arange(len(up))
    columns = _columns(scene, up, kept)
    if more:
        columns |= _visible_parts(seen, owner, kept)
    return Passes(up.epoch, columns)


def site_of(scene: Scene) -> None:
    """AttitudeError for anything but a Scene whose observer is a ground site."""
    if not isinstance(scene, Scene):
        raise AttitudeError(
            f"scene is {validation.shown(scene)}; give a Scene whose observer is a ground site."
        )
    if not scene.observer.has_horizon:
        raise AttitudeError(
            f"the observer is {scene.observer.name}, over which nothing rises; give a Scene with a "
            "ground site: paths.site(longitude, latitude) or paths.observatory(code)."
        )


def _columns(scene: Scene, up: Windows, kept: IntArray) -> dict[str, TimetableColumn]:
    source = Source(scene.motion, scene)
    begin, end = up.begin[kept], up.end[kept]

    def elevations(seconds: FloatArray) -> FloatArray:
        return np.asarray(source.at(seconds, np.zeros(seconds.size)).view.elevation)

    spacing = scene.quantity("elevation").spacing(up.start, up.stop)
    top = _highest(elevations, begin, end, spacing)
    three = np.concatenate([begin, top, end])
    view = source.at(three, np.zeros(three.size)).view
    azimuth, height, distance, sun = (
        np.asarray(getattr(view, name)).reshape(3, -1)
        for name in ("azimuth", "elevation", "observer_distance", "sun_elevation")
    )
    first, last = (pair[0] + pair[1] for pair in (up.start, up.stop))
    is_cut: list[BoolArray] = [begin <= first, end >= last]
    rise, setting = (np.where(cut, np.nan, t) for cut, t in zip(is_cut, (begin, end), strict=True))
    return {
        "rise": TimetableColumn(rise, "time"),
        "rise_azimuth": TimetableColumn(np.where(is_cut[0], np.nan, azimuth[0]), "rad", "deg"),
        "culmination": TimetableColumn(top, "time"),
        "elevation": TimetableColumn(height[1], "rad", "deg"),
        "azimuth": TimetableColumn(azimuth[1], "rad", "deg"),
        "distance": TimetableColumn(distance[1], "m", "km"),
        "sun_elevation": TimetableColumn(sun[1], "rad", "deg"),
        "set": TimetableColumn(setting, "time"),
        "set_azimuth": TimetableColumn(np.where(is_cut[1], np.nan, azimuth[2]), "rad", "deg"),
        "duration": TimetableColumn(up.duration[kept], "s"),
    }


def _visible_parts(seen: Windows, owner: IntArray, kept: IntArray) -> dict[str, TimetableColumn]:
    """First and last epoch and seconds in which the conditions hold, of each pass."""
    first = np.searchsorted(owner, kept, side="left")
    last = np.searchsorted(owner, kept, side="right") - 1
    total = np.bincount(owner, weights=seen.duration, minlength=int(np.max(kept, initial=-1)) + 1)
    return {
        "visible_from": TimetableColumn(seen.begin[first], "time"),
        "visible_until": TimetableColumn(seen.end[last], "time"),
        "visible": TimetableColumn(total[kept], "s"),
    }


# ---- The glints of a scene: of all flat sides of its mesh, with the lobes of their materials

# A glint is searched up to this angle from the mirror direction, rad.
_WIDEST = 1.55


class Glints(Timetable):
    """Glints, one a row; made by `glints`.

    Attributes
    ----------
    side : (N,) array of str
        Name of the flat side.
    start, peak, stop : (N,) arrays
        TDB seconds since the epoch: where the lobe exceeds the fraction of its peak, and where the
        mirrored observer is nearest to the Sun.
    duration : (N,) array
        s.
    magnitude : (N,) array
        Of the whole body at the peak; the reduced magnitude if the distance of the Sun or of the
        observer is not known.
    off_mirror : (N,) array
        Angle between the mirrored observer and the Sun at the peak, rad.
    phase_angle, lit_fraction : (N,) arrays
        At the peak: rad, and the share of the Sun's disc that is seen.
    elevation : (N,) array
        At the peak, rad; from a ground site only.
    """


@arguments({"shape": "give it to the scene"}, "glints(Scene(motion, ..., shape=mesh))")
def glints(
    scene: Scene,
    start: EpochOrSeconds | None = None,
    stop: EpochOrSeconds | None = None,
    *,
    sides: Sequence[str] | None = None,
    fraction: float = 0.1,
    visible: bool = True,
    where: Joinable | None = None,
    velocity: Reals | VectorFunction | None = None,
) -> Glints:
    """The glints of all flat sides of the scene's mesh whose materials have a lobe.

    Parameters
    ----------
    scene : Scene
        With a motion, a Mesh and a law of materials (`scattering.Material` or `Materials`).
    start, stop : epochs or seconds, optional
        As in `windows`.
    sides : sequence of str, optional
        Names of `shape.flat_sides`; all by default.
    fraction : float
        A side glints while its lobe, widened by the Sun's radius, exceeds this part of its peak.
    visible : bool
        Whether a glint counts only where it is seen: outside of the umbra of `scene.shadow_of`, and
        over a ground site above the horizon under a dark sky (`view.is_observable`).
    where : Condition, optional
        Any other condition of the scene.
    velocity : optional
        As in `glint`: "center" for the aberration by the motion of the body.

    Raises
    ------
    AttitudeError
        For a scene without a mesh, materials without lobes, unknown sides, and as `windows`.
    """
    chosen = _sides(scene, sides, fraction)
    more = [] if where is None else [condition_of(where, "where")]
    if validation.flag(visible, "visible"):
        if scene.shadow_of:
            more.append(scene.quantity("lit_fraction") > 0.0)
        if scene.observer.has_horizon:
            more.append(scene.quantity("elevation") > 0.0)
            more.append(scene.quantity("sun_elevation") < scene.night)
    conditions = []
    for side, width in chosen:
        reach = min(width + SUN_RADIUS, _WIDEST)
        one = glint(scene, side.normal, sun_radius=reach, velocity=velocity)
        for condition in more:
            one = one & condition
        conditions.append(one)
    ends = _span_of(conditions[0].source, start, stop)
    windows = windows_of(conditions, *ends)
    return _rows(scene, [side for side, _ in chosen], conditions, windows)


def _sides(scene, names, fraction):
    """The flat sides with a lobe, and the half-widths of their lobes, rad."""
    source_of(scene)
    if not isinstance(scene, Scene) or not isinstance(scene.shape, Mesh):
        raise AttitudeError(
            "glints are those of the flat sides of a mesh; give a Scene with shape=, a Mesh such "
            "as attitude.shape.box_wing(...)."
        )
    sides = []
    for side in flat_sides(scene.shape):
        material = scene.law.of_material(side.material)
        if material is None:
            raise AttitudeError(
                f"the law of the scene is {type(scene.law).__name__}, which has no lobe; give "
                "law=, a scattering.Material or Materials with a specular part."
            )
        if material.specular > 0.0:
            sides.append((side, material.lobe_half_width(fraction)))
    if names is not None:
        listed = [side.name for side, _ in sides]
        for name in names:
            if name not in listed:
                raise AttitudeError(
                    f"sides holds {name!r}; the sides with a lobe are {', '.join(listed)}."
                )
        sides = [pair for pair in sides if pair[0].name in names]
    if not sides:
        raise AttitudeError(
            "no flat side has a material with a specular part, so that nothing glints; give one in "
            "the law of the scene."
        )
    return sides


def _rows(scene, sides, conditions, windows):
    """The rows of all sides in order of time."""
    source = conditions[0].source
    spacing = scene.quantity("observer_direction.x").spacing(windows[0].start, windows[0].stop)
    tops, off = [], []
    for condition, one in zip(conditions, windows, strict=True):
        mirrored = condition.channels[0]
        assert isinstance(mirrored, Mirrored)

        def nearness(seconds: FloatArray, channel: Any = mirrored) -> FloatArray:
            return channel.value(source.at(seconds, np.zeros(seconds.size)))

        top = _highest(nearness, one.begin, one.end, spacing)
        tops.append(top)
        off.append(mirrored.off_mirror(source.at(top, np.zeros(top.size))) if len(top) else top)
    side = np.repeat([one.name for one in sides], [len(one) for one in windows])
    peak, off_mirror = np.concatenate(tops), np.concatenate(off)
    begin, end = (
        np.concatenate([_edges(one.columns[name]) for one in windows], axis=1)
        for name in ("begin", "end")
    )
    duration = np.concatenate([one.duration for one in windows])
    order = np.argsort(begin[0], kind="stable")
    view = source.at(peak[order], np.zeros(len(peak))).view
    is_far = scene.sun.is_direction or scene.observer.is_direction
    magnitude = np.asarray(view.reduced_magnitude if is_far else view.magnitude_everywhere)
    columns = {
        "side": TimetableColumn(side[order]),
        "start": TimetableColumn(begin[0, order], "time", low=begin[1, order]),
        "peak": TimetableColumn(peak[order], "time"),
        "stop": TimetableColumn(end[0, order], "time", low=end[1, order]),
        "duration": TimetableColumn(duration[order], "s"),
        "magnitude": TimetableColumn(magnitude, "mag"),
        "off_mirror": TimetableColumn(off_mirror[order], "rad", "deg"),
        "phase_angle": TimetableColumn(view.phase_angle, "rad", "deg"),
        "lit_fraction": TimetableColumn(view.lit_fraction),
    }
    if scene.observer.has_horizon:
        columns["elevation"] = TimetableColumn(view.elevation, "rad", "deg")
    return Glints(source.epoch, columns)
