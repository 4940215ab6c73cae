"""Passes of a body over a ground site: rise, culmination and set."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from attitude import validation
from attitude.conditions.moments import OfReception
from attitude.errors import AttitudeError
from attitude.events.timetable import Timetable, TimetableColumn
from attitude.events.tops import highest
from attitude.events.windows import span_of, windows_of
from attitude.scene.scene import Scene

if TYPE_CHECKING:
    from attitude.annotations import BoolArray, EpochOrSeconds, FloatArray, IntArray, Real
    from attitude.conditions.condition import Condition, Joinable
    from attitude.events.windows import Windows


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
    lowest = validation.number(elevation, "elevation", unit="rad")
    above = scene.quantity("elevation") > lowest
    more: list[Condition] = [] if where is None else [where.condition]
    if validation.flag(sunlit, "sunlit"):
        more.append(scene.quantity("lit_fraction") > 0.0)
    if night is not None:
        more.append(scene.quantity("sun_elevation") < night)
    visible = above
    for each in more:
        visible = visible & each
    ends = span_of(above.source, start, stop)
    up, seen = windows_of([above, visible], *ends)
    owner = np.asarray(np.searchsorted(up.begin, seen.begin, side="right") - 1, dtype=np.int64)
    kept = np.unique(owner) if more else np.arange(len(up))
    columns = _columns(scene, up, kept)
    if more:
        columns |= _visible(seen, owner, kept)
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
    source = OfReception(scene)
    begin, end = up.begin[kept], up.end[kept]

    def elevations(seconds: FloatArray) -> FloatArray:
        return np.asarray(source.at(seconds, np.zeros(seconds.size)).view.elevation)

    top = highest(elevations, begin, end)
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


def _visible(seen: Windows, owner: IntArray, kept: IntArray) -> dict[str, TimetableColumn]:
    """First and last epoch and seconds in which the conditions hold, of each pass."""
    first = np.searchsorted(owner, kept, side="left")
    last = np.searchsorted(owner, kept, side="right") - 1
    total = np.bincount(owner, weights=seen.duration, minlength=int(np.max(kept, initial=-1)) + 1)
    return {
        "visible_from": TimetableColumn(seen.begin[first], "time"),
        "visible_until": TimetableColumn(seen.end[last], "time"),
        "visible": TimetableColumn(total[kept], "s"),
    }
