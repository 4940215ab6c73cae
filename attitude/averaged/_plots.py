"""Figures of a mean rotation: momentum, tilt, pole and periods against time, with events."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from attitude import plots
from attitude._support.constants import COLORS, DAY_S, GREEN, PURPLE
from attitude.averaged._polhode import LAM_PLUS
from attitude.errors import AttitudeError

if TYPE_CHECKING:
    from collections.abc import Iterable

    from attitude._support.annotations import Epochs, FilePath, FloatArray
    from attitude.averaged._history import AveragedHistory
    from attitude.averaged._motion import AveragedMotion
    from attitude.averaged._tracks import AveragedEvent

_POINTS = 3001
# Least span in days, days in the unit, and its name.
_UNITS = ((3.0 * 365.25e3, 365.25e3, "kyr"), (3.0 * 365.25, 365.25, "years"), (0.0, 1.0, "days"))
# Kinds of events: colour, line style, label.
_MARKS = {
    "passage": ("0.5", "-", "passage of the separatrix"),
    "uniform rotation reached": (GREEN, ":", "uniform rotation reached"),
    "uniform rotation left": (PURPLE, ":", "uniform rotation left"),
    "resonance": ("#e69f00", "--", "resonance that may capture"),
}
_END = ("#d62728", "-", "end of the mean motion")
# Periods that are drawn, of the middle one: those at the separatrix grow without bound.
_LONGEST = 30.0


def of_motion(
    motion: AveragedMotion, until: Epochs, path: FilePath | None, title: str | None
) -> Any:
    """`AveragedMotion.plot`."""
    last = motion.reaches(until)
    if last == 0.0:
        raise AttitudeError(
            "the span from the epoch of the spin to until is empty; give another epoch, as in "
            'motion.plot(until="2050-01-01").'
        )
    states = motion.at(np.linspace(0.0, last, _POINTS))
    events = () if states.odds.size > 1 else motion.events
    return of_history(states, events, path, title)


def of_history(
    states: AveragedHistory,
    events: Iterable[AveragedEvent] = (),
    path: FilePath | None = None,
    title: str | None = None,
) -> Any:
    """`AveragedHistory.plot`."""
    if states.seconds.ndim not in (1, 2) or states.seconds.shape[-1] < 2:
        raise AttitudeError(
            f"the history has shape {states.seconds.shape}; a figure needs epochs (T,), two at "
            "least, or those of branches, (B, T)."
        )
    figure, panels = plots.stacked((9.0, 11.0), 4, height_ratios=(1.0, 1.3, 1.0, 1.2))
    span = float(np.ptp(states.seconds)) / DAY_S
    _, days, unit = next(row for row in _UNITS if span >= row[0])
    time = np.atleast_2d(states.seconds) / (DAY_S * days)
    _momentum(panels[0], time, states)
    _tilt(panels[1], time, states)
    _pole(panels[2], time, states)
    _periods(panels[3], time, states)
    _mark(panels, events, DAY_S * days)
    panels[-1].set_xlabel(f"{unit} since {states.epoch.utc_iso[:19].replace('T', ' ')} UTC")
    for axes in panels:
        axes.margins(x=0.01)
    if title:
        figure.suptitle(title, parse_math=False)
    return plots.saved(figure, path)


def _lines(axes: Any, time: FloatArray, values: FloatArray, states: AveragedHistory, **style: Any):
    """Draw rows (B, T): branches with widths and shades by their odds."""
    rows = np.atleast_2d(values)
    odds = states.odds if states.odds.size == len(rows) else np.ones(len(rows))
    label = style.pop("label", None)
    for k in np.argsort(odds):
        share = odds[k] / np.max(odds)
        axes.plot(
            time[k],
            rows[k],
            alpha=0.25 + 0.75 * share,
            linewidth=0.5 + 0.7 * share,
            label=label if k == np.argmax(odds) else None,
            **style,
        )


def _momentum(axes: Any, time: FloatArray, states: AveragedHistory) -> None:
    _lines(axes, time, states.size, states, color=COLORS[0])
    axes.set(ylabel="|L| (N m s)", ylim=(0.0, 1.05 * float(np.nanmax(states.size))))


def _tilt(axes: Any, time: FloatArray, states: AveragedHistory) -> None:
    """theta by its mode, with the separatrix."""
    theta = np.degrees(states.theta)
    is_long = states.region >= LAM_PLUS
    edge = float(np.degrees(np.arctan(np.exp(0.5 * states.separatrix))))
    for flags, color, label in (
        (~is_long, COLORS[0], "short-axis mode"),
        (is_long, COLORS[1], "long-axis mode"),
    ):
        if np.any(flags):
            _lines(axes, time, np.where(flags, theta, np.nan), states, color=color, label=label)
    axes.axhline(edge, color="0.3", linewidth=0.8, linestyle="--", label="separatrix")
    axes.set(ylabel="theta, momentum to short axis (deg)", ylim=(-2.0, 92.0))
    axes.set_yticks(range(0, 91, 15))
    axes.legend(fontsize=9, loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=3, frameon=False)


def _pole(axes: Any, time: FloatArray, states: AveragedHistory) -> None:
    """Right ascension, with gaps where it jumps, and declination."""
    x, y, z = np.moveaxis(states.pole, -1, 0)
    longitude = np.atleast_2d(np.degrees(np.arctan2(y, x)) % 360.0).copy()
    longitude[:, 1:][np.abs(np.diff(longitude, axis=1)) > 180.0] = np.nan
    latitude = np.degrees(np.arcsin(np.clip(z, -1.0, 1.0)))
    _lines(axes, time, latitude, states, color=COLORS[0], label="declination")
    axes.set(ylabel="declination of L (deg)", ylim=(-95.0, 95.0), yticks=range(-90, 91, 45))
    other = axes.twinx()
    _lines(other, time, longitude, states, color=COLORS[1], linestyle=(0, (4, 1)))
    other.set(ylabel="right ascension of L (deg)", ylim=(-10.0, 370.0), yticks=range(0, 361, 90))
    axes.yaxis.label.set_color(COLORS[0])
    other.yaxis.label.set_color(COLORS[1])


def _periods(axes: Any, time: FloatArray, states: AveragedHistory) -> None:
    middle = float(np.nanmedian(np.concatenate([states.P_psi.ravel(), states.P_phi.ravel()])))
    factor, name = (1.0, "s") if middle < 600.0 else (3600.0, "h")
    if middle > DAY_S * 3.0:
        factor, name = DAY_S, "d"
    for values, color, label in (
        (states.P_psi, COLORS[2], "P_psi, nutation"),
        (states.P_phi, COLORS[1], "P_phi, long axis about L"),
    ):
        _lines(axes, time, values / factor, states, color=color, label=label)
    shown = np.concatenate([states.P_psi.ravel(), states.P_phi.ravel()]) / factor
    shown = shown[np.isfinite(shown)]
    # a period grows without bound at the separatrix, and less so in the sampled epochs
    highest = min(float(np.max(shown)), _LONGEST * float(np.percentile(shown, 95.0)))
    axes.set(ylabel=f"period ({name})", yscale="log", ylim=(0.8 * float(np.min(shown)), highest))
    axes.legend(fontsize=9, loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=2, frameon=False)


def _mark(panels: Any, events: Iterable[AveragedEvent], scale: float) -> None:
    """Draw a line for each event, and a legend of the kinds below the first panel."""
    lines = {}
    for event in events:
        if event.kind == "resonance" and not event.may_capture:
            continue
        color, style, label = _MARKS.get(event.kind, _END)
        for axes in panels:
            lines[label] = axes.axvline(
                event.seconds / scale, color=color, linestyle=style, linewidth=0.7, zorder=0
            )
    if lines:
        panels[0].legend(
            lines.values(),
            lines.keys(),
            fontsize=9,
            loc="lower center",
            bbox_to_anchor=(0.5, 1.0),
            ncols=len(lines),
            frameon=False,
        )
