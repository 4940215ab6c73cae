"""Figures of photometry: points, periodograms, folded curves, pairs of periods."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from attitude import plots
from attitude._support.constants import BLUE, PURPLE, VERMILION
from attitude._support.quantity_text import of_time, time_unit

if TYPE_CHECKING:
    from attitude._support.annotations import FilePath
    from attitude.photometry._curve import LightCurve
    from attitude.photometry._folding import Folded
    from attitude.photometry._periods import Periods


# Colours of data, of models, of what stands beside them, and of aliases.
DATA = BLUE
MODEL = VERMILION
OTHER = "0.6"
_ALIAS = PURPLE
# Peaks that are named, and marks of pairs, which may lie close to each other.
_NAMED = 5
_MARKS = "osD^v"
# Curves that have colours of their own.
_COLOURS = 10


def of_light_curve(data: LightCurve, path: FilePath | None = None) -> Any:
    """Brightness against time, a colour a filter."""
    figure = plots.new_figure((9.0, 5.0))
    axes = figure.subplots()
    unit, unit_name = time_unit(data.span)
    for number, name in enumerate((*data.filters[:_COLOURS], "others")):
        in_filter = data.filter == number if number < _COLOURS else data.filter >= number
        if not np.any(in_filter):
            continue
        error = np.where(np.isfinite(data.sigma[in_filter]), data.sigma[in_filter], 0.0)
        axes.errorbar(
            data.seconds[in_filter] / unit,
            data.value[in_filter],
            error,
            fmt=".",
            ms=4,
            lw=0.6,
            color=f"C{number}" if number < _COLOURS else "k",
            label=plots.plain(name) or None,
        )
    if not data.is_flux:
        axes.invert_yaxis()
    brightness = ("flux" if data.is_flux else "magnitude") + " at 1 au" * data.unit_distances
    since = f"time since {data.epoch.utc_iso[:19]} UTC, {unit_name}"
    axes.set(xlabel=since, ylabel=brightness)
    if any(data.filters):
        axes.legend(title="filter", fontsize=9)
    axes.set_title(repr(data)[1:-1], fontsize=9, parse_math=False)
    return plots.saved(figure, path)


def of_one(periods: Periods, path: FilePath | None = None) -> Any:
    """Power with its peaks, the spectral window, and the curve folded with the best period."""
    figure = plots.new_figure((9.0, 8.0))
    halves: Any = figure.subfigures(2, 1, height_ratios=(3, 2))
    above, below = halves
    axes = above.subplots()
    unit, unit_name = time_unit(periods.samples.span)
    frequency, power = plots.extremes(
        np.asarray(periods.frequency) * unit, np.asarray(periods.power)
    )
    axes.plot(frequency, power, color=DATA, lw=0.7)
    axes.axhline(
        1.0 - periods.false_alarm, color=OTHER, ls="--", lw=0.8, label="1 of 100 by chance"
    )
    for rank, peak in enumerate(periods.peaks[:_NAMED], 1):
        colour = _ALIAS if peak.relation.startswith("alias") else MODEL
        at = unit / peak.period
        axes.plot(at, peak.power, "v", color=colour, ms=6)
        label = f"#{rank}  {of_time(peak.period)}"
        if peak.relation:
            label += f", {peak.relation}"
        axes.plot([], [], "v", color=colour, label=label)
    axes.set_xlim(frequency[0], frequency[-1])
    axes.set_ylim(0.0, min(1.0, 1.1 * max(power.max(), 1.0 - periods.false_alarm)))
    name = "1 - theta" if periods.method == "pdm" else f"share of variance, order {periods.order}"
    axes.set(xlabel=f"frequency, 1/{unit_name}", ylabel=name)
    axes.legend(fontsize=9, loc="best")
    left, right = below.subplots(1, 2)
    _window(left, periods)
    _folded(right, periods.fold(), 0)
    return plots.saved(figure, path)


def of_folded(folded: Folded, path: FilePath | None = None) -> Any:
    """Folded points with the series, and residuals against time."""
    count = len(folded.periods)
    figure = plots.new_figure((9.0, 4.0 * count + 2.5))
    axes = figure.subplots(count + 1, 1, height_ratios=[2.0] * count + [1.0], squeeze=False)[:, 0]
    for k in range(count):
        _folded(axes[k], folded, k)
    if folded.samples.curves <= _COLOURS and len(folded.samples.names) > 1:
        axes[0].legend(fontsize=9, loc="upper right")
    unit, unit_name = time_unit(folded.samples.span)
    since = (folded.samples.t - folded.samples.t.min()) / unit
    axes[-1].plot(since, folded.residuals, ".", color=DATA, ms=3)
    axes[-1].axhline(0.0, color=OTHER, lw=0.8)
    if not folded.samples.is_flux:
        axes[-1].invert_yaxis()
    label = f"time since the first point, {unit_name}"
    axes[-1].set(xlabel=label, ylabel=f"residual, rms {folded.rms:.3g}")
    return plots.saved(figure, path)


def of_two(periods: Periods, path: FilePath | None = None) -> Any:
    """Chi-squared over both frequencies, the lines of the best pair, and both folded curves."""
    figure = plots.new_figure((9.0, 8.5))
    axes = figure.subplots(2, 2)
    plane, spectrum = axes[0]
    unit, unit_name = time_unit(periods.samples.span)
    assert periods.edges is not None and periods.map is not None
    edges = [frequencies * unit for frequencies in periods.edges]
    shown = plane.pcolormesh(edges[0], edges[1], periods.map.T, cmap="viridis", rasterized=True)
    figure.colorbar(shown, ax=plane, label="share of chi-squared left")
    for rank, (pair, mark) in enumerate(zip(periods.peaks, _MARKS, strict=False), 1):
        colour = MODEL if not pair.relation else _ALIAS
        at = [pair.first * unit], [pair.second * unit]
        plane.plot(*at, mark, mfc="none", color=colour, ms=9, label=f"#{rank}")
    plane.legend(fontsize=9, loc="lower right")
    plane.set(xlabel=f"first frequency, 1/{unit_name}", ylabel=f"second frequency, 1/{unit_name}")
    best = periods.peaks[0]
    first, second = (of_time(period) for period in best.periods)
    plane.set_title(f"#1: {first} and {second}, {best.left:.3f} left", fontsize=9)
    lines = periods.lines()
    for line, amplitude in lines:
        x = line.frequency * unit
        spectrum.plot([x, x], [0.0, amplitude], color=DATA)
        if amplitude > 0.15 * lines[0][1]:
            spectrum.annotate(f"{line.i},{line.j}", (x, amplitude), fontsize=9, ha="center")
    spectrum.set_ylim(0.0, None)
    spectrum.set(xlabel=f"frequency of the line i f2 + j f1, 1/{unit_name}", ylabel="amplitude")
    spectrum.set_title("lines (i, j)", fontsize=9)
    folded = periods.fold()
    for k in range(2):
        _folded(axes[1, k], folded, k)
    return plots.saved(figure, path)


def _window(axes: Any, periods: Periods) -> None:
    assert periods.window is not None
    unit, unit_name = time_unit(periods.samples.span)
    axes.plot(periods.window.frequency * unit, periods.window.power, color=OTHER, lw=0.7)
    for line in sorted(periods.window.lines):
        x = line.frequency * unit
        axes.plot([x], [line.power], "v", color=_ALIAS, ms=4, label=f"{x:.4g} /{unit_name}")
    if periods.window.lines:
        axes.legend(fontsize=9, loc="upper right")
    axes.set(xlabel=f"frequency, 1/{unit_name}", ylabel="spectral window")


def draw_series(axes: Any, folded: Folded, which: int) -> None:
    """The series of a folded curve, and magnitudes downward."""
    phase = np.linspace(0.0, 1.0, 400)
    axes.plot(phase, folded.curve(phase, which), color=MODEL, lw=1.2)
    if not folded.samples.is_flux:
        axes.invert_yaxis()


def _folded(axes: Any, folded: Folded, which: int) -> None:
    data = folded.samples
    for number in range(min(data.curves, _COLOURS + 1)):
        in_curve = data.curve == number if number < _COLOURS else data.curve >= number
        colour = f"C{number}" if number < _COLOURS and data.curves > 1 else DATA
        name = data.names[number] if data.names and number < _COLOURS else ""
        axes.plot(
            folded.phase[which, in_curve],
            folded.values[which, in_curve],
            ".",
            color=colour,
            ms=4,
            label=plots.plain(name) or None,
        )
    draw_series(axes, folded, which)
    axes.set(
        xlabel=f"phase of {of_time(folded.periods[which], 7)}",
        ylabel=("flux" if data.is_flux else "magnitude") + " less zero point",
        xlim=(0.0, 1.0),
    )
    if len(folded.periods) > 1:
        title = f"period {which + 1}, without the lines of the other period"
        axes.set_title(title, fontsize=9)
