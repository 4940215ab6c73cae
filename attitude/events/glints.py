"""The glints of a scene: of all flat sides of its mesh, with the lobes of their materials."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from attitude import validation
from attitude.conditions.condition import condition_of
from attitude.errors import AttitudeError
from attitude.events.channels import SUN_RADIUS, Mirrored
from attitude.events.conditions import glint
from attitude.events.sources import source_of
from attitude.events.timetable import Timetable, TimetableColumn
from attitude.events.tops import highest
from attitude.events.windows import span_of, windows_of
from attitude.scene.scene import Scene
from attitude.shape import Mesh, flat_sides

if TYPE_CHECKING:
    from collections.abc import Sequence
    from typing import Any

    from attitude.annotations import EpochOrSeconds, FloatArray, Reals
    from attitude.conditions.condition import Condition, Joinable
    from attitude.events.directions import VectorFunction
    from attitude.events.windows import Windows
    from attitude.shape import FlatSide

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
        As of `glint`: "center" for the aberration by the motion of the body.

    Raises
    ------
    AttitudeError
        For a scene without a mesh, materials without lobes, unknown sides, and as `windows`.
    """
    chosen = _sides(scene, sides, fraction)
    more = [] if where is None else [condition_of(where, "where")]
    if validation.flag(visible, "visible"):
        more += _visible(scene)
    conditions = []
    for side, width in chosen:
        reach = min(width + SUN_RADIUS, _WIDEST)
        one = glint(scene, side.normal, sun_radius=reach, velocity=velocity)
        for each in more:
            one = one & each
        conditions.append(one)
    ends = span_of(conditions[0].source, start, stop)
    found = windows_of(conditions, *ends)
    return _rows(scene, [side for side, _ in chosen], conditions, found)


def _sides(
    scene: Scene, names: Sequence[str] | None, fraction: float
) -> list[tuple[FlatSide, float]]:
    """The flat sides with a lobe, and the half-widths of their lobes, rad."""
    source_of(scene)
    if not isinstance(scene, Scene) or not isinstance(scene.shape, Mesh):
        raise AttitudeError(
            "glints are those of the flat sides of a mesh; give a Scene with shape=, a Mesh such "
            "as attitude.shape.box_wing(...)."
        )
    found = []
    for side in flat_sides(scene.shape):
        material = scene.law.of_material(side.material)
        if material is None:
            raise AttitudeError(
                f"the law of the scene is {type(scene.law).__name__}, which has no lobe; give "
                "law=, a scattering.Material or Materials with a specular part."
            )
        if material.specular > 0.0:
            found.append((side, material.lobe_half_width(fraction)))
    if names is not None:
        listed = [side.name for side, _ in found]
        for name in names:
            if name not in listed:
                raise AttitudeError(
                    f"sides holds {name!r}; the sides with a lobe are {', '.join(listed)}."
                )
        found = [each for each in found if each[0].name in names]
    if not found:
        raise AttitudeError(
            "no flat side has a material with a specular part, so that nothing glints; give one in "
            "the law of the scene."
        )
    return found


def _visible(scene: Scene) -> list[Condition]:
    more = []
    if scene.shadow_of:
        more.append(scene.quantity("lit_fraction") > 0.0)
    if scene.observer.has_horizon:
        more.append(scene.quantity("elevation") > 0.0)
        more.append(scene.quantity("sun_elevation") < scene.night)
    return more


def _rows(
    scene: Scene, sides: list[FlatSide], conditions: list[Condition], found: list[Windows]
) -> Glints:
    """The rows of all sides in order of time."""
    source = conditions[0].source
    tops, off = [], []
    for condition, each in zip(conditions, found, strict=True):
        mirrored = condition.channels[0]
        assert isinstance(mirrored, Mirrored)
        begin, end = each.begin, each.end

        def nearness(seconds: FloatArray, channel: Any = mirrored) -> FloatArray:
            value: FloatArray = channel.value(source.at(seconds, np.zeros(seconds.size)))
            return value

        top = highest(nearness, begin, end)
        tops.append(top)
        off.append(mirrored.off_mirror(source.at(top, np.zeros(top.size))) if len(top) else top)
    side = np.repeat([each.name for each in sides], [len(each) for each in found])
    peak, off_mirror = np.concatenate(tops), np.concatenate(off)
    begin, begin_low, end, end_low, duration = (
        np.concatenate(column) for column in zip(*(_edges_of(each) for each in found), strict=True)
    )
    order = np.argsort(begin, kind="stable")
    view = source.at(peak[order], np.zeros(len(peak))).view
    columns = {
        "side": TimetableColumn(side[order]),
        "start": TimetableColumn(begin[order], "time", low=begin_low[order]),
        "peak": TimetableColumn(peak[order], "time"),
        "stop": TimetableColumn(end[order], "time", low=end_low[order]),
        "duration": TimetableColumn(duration[order], "s"),
        "magnitude": TimetableColumn(_magnitude(scene, view), "mag"),
        "off_mirror": TimetableColumn(off_mirror[order], "rad", "deg"),
        "phase_angle": TimetableColumn(view.phase_angle, "rad", "deg"),
        "lit_fraction": TimetableColumn(view.lit_fraction),
    }
    if scene.observer.has_horizon:
        columns["elevation"] = TimetableColumn(view.elevation, "rad", "deg")
    return Glints(source.epoch, columns)


def _edges_of(found: Windows) -> tuple[FloatArray, ...]:
    begin, end = found.columns["begin"], found.columns["end"]
    low = [
        np.broadcast_to(np.asarray(each.low, dtype=float), (len(found),)) for each in (begin, end)
    ]
    return begin.values, low[0], end.values, low[1], found.duration


def _magnitude(scene: Scene, view: Any) -> FloatArray:
    if scene.sun.is_direction or scene.observer.is_direction:
        return np.asarray(view.reduced_magnitude)
    return np.asarray(view.magnitude_everywhere)
