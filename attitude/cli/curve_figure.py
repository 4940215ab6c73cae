"""The figure of a light curve: magnitude and phase angle against time."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from attitude import plots

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from attitude.annotations import BoolArray, FloatArray, IntArray
    from attitude.epochs import Instant
    from attitude.formats.mission import Mission

_CURVE, _PHASE, _BELOW = "#0072b2", "#d55e00", "0.45"
# Points of a curve that a figure of 1500 pixels resolves; longer ones are drawn by their extremes.
_POINTS = 40_000
# Elevation of the Sun at the end of astronomical twilight, rad.
_TWILIGHT = np.radians(-18.0)
# Least span in s, s in the unit, and its name.
_UNITS = ((4.0 * 86400.0, 86400.0, "days"), (3.0 * 3600.0, 3600.0, "hours"), (0.0, 60.0, "minutes"))


def of(
    mission: Mission,
    *,
    epoch: Instant,
    seconds: FloatArray,
    magnitude: FloatArray,
    phase_angle: FloatArray,
    lit_fraction: FloatArray | None = None,
    elevation: FloatArray | None = None,
    sun_elevation: FloatArray | None = None,
) -> Figure:
    """A matplotlib Figure of the light curve of a mission.

    Parameters
    ----------
    mission : Mission
        With a magnitude.
    epoch : Instant
    seconds, magnitude, phase_angle : (N,) arrays
        TDB seconds since the epoch; mag, inf where no lit facet is visible; rad.
    lit_fraction, elevation, sun_elevation : (N,) arrays, optional
        Shaded are day (the Sun above the horizon of a site), twilight (down to -18 deg), the umbra
        (0), and where the body is below the horizon (rad); there a curve is grey.
    """
    figure = plots.new_figure((10.0, 6.0))
    above, below = figure.subplots(2, 1, sharex=True, height_ratios=(3, 1))
    span = np.ptp(seconds)
    _, scale, unit = next(each for each in _UNITS if span >= each[0])
    t = (seconds - seconds[0]) / scale
    shown = np.where(np.isfinite(magnitude), magnitude, np.nan)
    if elevation is not None:
        up = elevation > 0.0
        _line(above, t, np.where(up, np.nan, shown), _BELOW, None)
        _line(above, t, np.where(up, shown, np.nan), _CURVE, "above the horizon")
    else:
        _line(above, t, shown, _CURVE, None)
    _shade(above, t, lit_fraction, elevation, sun_elevation)
    assert mission.magnitude is not None
    source = "" if mission.scene.phase_function is None else " from H"
    above.invert_yaxis()
    above.set_ylabel(f"{mission.magnitude.kind} magnitude{source} (mag)")
    if above.get_legend_handles_labels()[0]:
        above.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=5, fontsize=9)
    _line(below, t, np.degrees(phase_angle), _PHASE, None)
    start = epoch.after(float(seconds[0])).utc_iso[:19].replace("T", " ")
    below.set(ylabel="phase angle (deg)", xlabel=f"{unit} since {start} UTC")
    for axes in (above, below):
        axes.grid(alpha=0.3)
        axes.margins(x=0.01)
    figure.suptitle(mission.name or "Light curve")
    return figure


def _shade(
    axes: Axes,
    t: FloatArray,
    lit_fraction: FloatArray | None,
    elevation: FloatArray | None,
    sun_elevation: FloatArray | None,
) -> None:
    """Shade day, twilight, umbra, and the epochs at which the body is below the horizon."""
    shades: list[tuple[BoolArray, str, dict[str, Any]]] = []
    if sun_elevation is not None:
        is_day = sun_elevation > 0.0
        shades.append((is_day, "day", {"facecolor": "#ffe9a8"}))
        twilight = ~is_day & (sun_elevation > _TWILIGHT)
        shades.append((twilight, "twilight", {"facecolor": "#dbe9f7"}))
    if lit_fraction is not None:
        dark = lit_fraction == 0.0
        shades.append((dark, "in the umbra of another body", {"facecolor": "0.3", "alpha": 0.3}))
    if elevation is not None:
        lines = {"facecolor": "none", "edgecolor": "0.65", "hatch": "///"}
        shades.append((elevation <= 0.0, "below the horizon", lines))
    for flags, label, style in shades:
        for k, (begin, end) in enumerate(_runs(flags)):
            last = t[min(end, len(t) - 1)]
            name = label if k == 0 else None
            axes.axvspan(t[begin], last, linewidth=0, zorder=0, label=name, **style)


def _line(axes: Axes, t: FloatArray, y: FloatArray, color: str, label: str | None) -> None:
    """Draw a curve with gaps at NaN; finite values between two gaps are dots."""
    t, y = _extremes(t, y)
    alone = (
        np.isfinite(y) & ~np.isfinite(np.r_[np.nan, y[:-1]]) & ~np.isfinite(np.r_[y[1:], np.nan])
    )
    if np.any(np.isfinite(y)):
        axes.plot(t, y, color=color, linewidth=0.9, label=label)
        axes.plot(t[alone], y[alone], ".", color=color, markersize=4)


def _extremes(t: FloatArray, y: FloatArray) -> tuple[FloatArray, FloatArray]:
    """A long curve as the least and the greatest value of each of many parts."""
    each = len(t) // (_POINTS // 2)
    if each < 2:
        return t, y
    count = len(t) // each * each
    parts = np.where(np.isfinite(y[:count]), y[:count], np.inf).reshape(-1, each)
    low = np.min(parts, axis=1)
    high = np.max(np.where(np.isfinite(parts), parts, -np.inf), axis=1)
    pairs = np.stack([low, high], axis=1).reshape(-1)
    return np.repeat(t[:count:each], 2), np.where(np.isfinite(pairs), pairs, np.nan)


def _runs(flags: BoolArray) -> IntArray:
    """Begin and end of each run of True."""
    edges = np.flatnonzero(np.diff(np.r_[False, flags, False]))
    return edges.reshape(-1, 2)
