"""``attitude lightcurve MISSION.toml``: the brightness of a body as a table and a figure."""

from __future__ import annotations

import argparse
import sys
from contextlib import ExitStack
from dataclasses import replace
from itertools import chain
from typing import TYPE_CHECKING, Any

import numpy as np

from attitude import plots
from attitude._support.blocks import ProgressBar
from attitude._support.constants import BLUE, DAY_S, VERMILION
from attitude._support.quantity_text import counted
from attitude.cli import _options, _output, geometry
from attitude.errors import AttitudeError

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from attitude._support.annotations import BoolArray, FloatArray
    from attitude.epochs._instants import Instant
    from attitude.formats.mission import Mission
    from attitude.scene._scene import Scene


# ---- The figure of a light curve: magnitude and phase angle against time

# Colour of epochs below the horizon.
_BELOW = "0.45"
# Elevation of the Sun at the end of astronomical twilight, rad.
_TWILIGHT = np.radians(-18.0)


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

    Shapes: seconds, magnitude, phase_angle (N,) rad, lit_fraction, elevation, sun_elevation (N,).
    """
    figure, (above, below) = plots.stacked((9.0, 6.0), 2, height_ratios=(3, 1))
    scale, unit = plots.time_unit(float(np.ptp(seconds)))
    t = (seconds - seconds[0]) / scale
    shown = np.where(np.isfinite(magnitude), magnitude, np.nan)
    if elevation is not None:
        up = elevation > 0.0
        _line(above, t, np.where(up, np.nan, shown), _BELOW, None)
        _line(above, t, np.where(up, shown, np.nan), BLUE, "above the horizon")
    else:
        _line(above, t, shown, BLUE, None)
    _shade(above, t, lit_fraction, elevation, sun_elevation)
    assert mission.magnitude is not None
    source = "" if mission.scene.phase_function is None else " from H"
    above.invert_yaxis()
    above.set_ylabel(f"{mission.magnitude.kind} magnitude{source} (mag)")
    if above.get_legend_handles_labels()[0]:
        above.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=5, fontsize=9)
    _line(below, t, np.degrees(phase_angle), VERMILION, None)
    start = epoch.after(float(seconds[0])).utc_iso[:19].replace("T", " ")
    below.set(ylabel="phase angle (deg)", xlabel=f"time since {start} UTC, {unit}")
    for axes in (above, below):
        axes.margins(x=0.01)
    figure.suptitle(mission.name or "Light curve", parse_math=False)
    return figure


def _shade(axes, t, lit_fraction, elevation, sun_elevation):
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
        # begin and end of each run of True
        runs = np.flatnonzero(np.diff(np.r_[False, flags, False])).reshape(-1, 2)
        for k, (begin, end) in enumerate(runs):
            last = t[min(end, len(t) - 1)]
            name = label if k == 0 else None
            axes.axvspan(t[begin], last, linewidth=0, zorder=0, label=name, **style)


def _line(axes: Axes, t: FloatArray, y: FloatArray, color: str, label: str | None) -> None:
    """Draw a curve with gaps at NaN; finite values between two gaps are dots."""
    t, y = plots.extremes(t, y)
    alone = (
        np.isfinite(y) & ~np.isfinite(np.r_[np.nan, y[:-1]]) & ~np.isfinite(np.r_[y[1:], np.nan])
    )
    if np.any(np.isfinite(y)):
        axes.plot(t, y, color=color, linewidth=0.9, label=label)
        axes.plot(t[alone], y[alone], ".", color=color, markersize=4)


# ---- ``--observed CURVE.csv``: the light curve of a mission against observations


def run_observed(mission: Mission, observed: str, target: str | None, figure: str | None) -> None:
    """Write observed and computed magnitudes, a zero point a session and filter; print each rms."""
    from attitude.epochs import _instants
    from attitude.photometry import _curve

    curve = _curve.LightCurve.read(observed, bad="refuse")
    scene = mission.scene
    seconds = _curve.reception(scene, curve.epoch, curve.seconds, curve.time_of)
    view = scene.at(_instants.times(curve.epoch, seconds, np.zeros_like(seconds)))
    computed = _computed(mission, view, is_reduced=curve.unit_distances)
    dark = np.count_nonzero(~np.isfinite(computed))
    if dark:
        raise AttitudeError(
            f"{observed}: at {dark} of {len(computed)} epochs nothing of the body is both lit and "
            "seen; leave these points out."
        )
    names = [(session, band) for session in curve.sessions for band in curve.filters]
    group = curve.session * len(curve.filters) + curve.filter
    residual, lines = _compared(curve.magnitude, computed, group, names)
    columns = zip(curve.magnitude, curve.magnitude - residual, residual, strict=True)
    with _output.opened(target) as file:
        file.write("utc,session,filter,observed,computed,residual\n")
        for time, number, numbers in zip(view.seconds, group, columns, strict=True):
            cells = [view.epoch.after(float(time)).utc_iso, *map(_curve.cell, names[number])]
            file.write(",".join(cells + [f"{x:.4f}" for x in numbers]) + "\n")
    if figure is not None:
        _draw(view.seconds / DAY_S, curve.magnitude, residual, group, figure)
        lines.append(figure)
    notes = [f"note: {note}" for note in curve.notes]
    print("\n".join([*notes, *lines]), file=sys.stderr if target is None else sys.stdout)


def _computed(mission, view, *, is_reduced):
    """Magnitudes of a View: reduced ones, or apparent ones where the distances are known."""
    if is_reduced:
        return _reduced(mission, view, everywhere=True)
    from attitude.formats import _surface

    scale = mission.magnitude
    if scale.kind == "reduced":
        scale = _surface.magnitude_of({}, mission.scene)
    return scale.of(view, everywhere=True)


def _reduced(mission, view, *, everywhere=False):
    """Magnitudes of a View at unit distances, dimmed by the shadows of other bodies."""
    from attitude.light_curve._magnitudes import shadow_dimming

    reduced = replace(mission.magnitude, kind="reduced").of(view, everywhere=everywhere)
    return reduced + shadow_dimming(view.lit_fraction) if view.scene.shadow_of else reduced


def _compared(observed, computed, group, names):
    """Residuals without the mean of each session and filter, by number, and a line about each."""
    residual = np.empty_like(observed)
    lines = []
    for number in dict.fromkeys(group.tolist()):
        chosen = group == number
        zero = float(np.mean(observed[chosen] - computed[chosen]))
        residual[chosen] = observed[chosen] - computed[chosen] - zero
        rms = float(np.sqrt(np.mean(residual[chosen] ** 2)))
        label = " in ".join(word for word in names[number] if word) or "all points"
        points = counted(np.count_nonzero(chosen), "point")
        lines.append(f"{label}: {points}, zero point {zero:+.3f}, rms {rms:.3f} mag")
    total = float(np.sqrt(np.mean(residual**2)))
    return residual, [*lines, f"rms of {counted(len(observed), 'point')}: {total:.3f} mag"]


def _draw(days, observed, residual, group, figure):
    """Observed and computed magnitudes, and residuals, a colour a session and filter."""
    drawn = plots.new_figure((9.0, 7.0))
    above, below = drawn.subplots(2, 1, sharex=True, height_ratios=(2, 1))
    for number in dict.fromkeys(group.tolist()):
        chosen = group == number
        above.plot(days[chosen], observed[chosen], ".")
        below.plot(days[chosen], residual[chosen], ".")
    above.plot(days, observed - residual, "kx", ms=3, label="computed")
    above.invert_yaxis()
    above.set_ylabel("magnitude")
    above.legend()
    below.invert_yaxis()
    below.set_ylabel("residual, mag")
    below.set_xlabel("days from the epoch of the mission")
    plots.saved(drawn, figure, dpi=150.0)


HELP: str = "write and draw the light curve of a mission file"
EPILOG: str = """\
example:
  attitude lightcurve apophis-2012.toml --output curve.ecsv --figure curve.png

A mission file with a section [shape] names spin, centre, observer, times, scattering law and
magnitude ([scattering], [magnitude]); data/mission/ has examples, docs/light_curves.md lists the
keys. Columns: UTC at which light is received, TDB seconds since the epoch of the spin, the
magnitude (inf where nothing of the body is both lit and seen; over a ground site NaN by day and
below the horizon, unless the file has site_limits = false), brightness in m2/sr, phase angle,
distances, the fraction of the Sun's disc that other bodies leave free, elevation over a ground
site, then the columns of the file. As x.txt the curve is written in DAMIT's format: brightness at
unit distances, dimmed by shadows, against the dates at which the light left. With --figure alone no
table is written.
"""
# m; larger distances are written in au.
_FAR = 1e9
# Epochs in one block: the memory does not grow with the curve, except for the points of a figure.
_BLOCK = 65536
# Arrays kept for a file of DAMIT.
_DAMIT = ("reduced", "hi", "lo", "to_sun", "to_observer")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the command."""
    parser.add_argument("file", metavar="MISSION.toml", help="mission file with a section [shape]")
    for name in geometry.TIMES:
        parser.add_argument(f"--{name}", metavar="TIME", help=f"replaces the {name} of the file")
    _output.add_argument(parser, "x.csv, x.ecsv, or x.txt in DAMIT's format")
    parser.add_argument(
        "--observed",
        metavar="CURVE.csv",
        help="observations to compare with, in place of the times of the file: residuals with a "
        "zero point a session and filter, and their rms",
    )
    _output.add_figure(parser)


def run(arguments: argparse.Namespace) -> None:
    """Write the table, the file of DAMIT and the figure."""
    from attitude._textfiles.atomic_write import written_whole
    from attitude.formats import mission as formats_mission

    kind = _output.kind_of(arguments.output, ("csv", "ecsv", "txt"))
    picture = _output.picture_of(arguments)
    mission = formats_mission.read(arguments.file)
    if mission.magnitude is None:
        raise AttitudeError(
            f"{arguments.file}: has no section [shape], without which there is no brightness; give "
            'one, as in shape.ellipsoid = "300, 200, 150 m".'
        )
    if arguments.observed is not None:
        if kind != "csv":
            raise AttitudeError("--observed writes a CSV; give an --output x.csv.")
        _options.refuse(arguments, geometry.TIMES, "--observed, whose dates are used")
        run_observed(mission, arguments.observed, arguments.output, arguments.figure)
        return
    if kind == "txt":
        _require_paths(mission.scene, arguments.output)
    views = geometry.views(mission, arguments, _BLOCK, ProgressBar("light curve"))
    first = next(views)  # errors are raised before anything is written
    mission = replace(mission, columns=_columns(mission, first[0]))
    curve = _Curve(mission, kind, is_drawn=picture is not None)
    views = chain([first], views)
    # Contexts end in reverse order: an error with the figure leaves no table either.
    with ExitStack() as stack:
        # Opened before the table, so that an error names the file that it concerns.
        drawn = picture and stack.enter_context(
            written_whole(arguments.figure, "--figure", binary=True)
        )
        if kind == "txt" or (picture and arguments.output is None):
            for view, _ in views:
                curve.magnitude_of(view)
        else:
            file = stack.enter_context(_output.opened(arguments.output))
            blocks = (curve.block(view, digits) for view, digits in views)
            geometry.write(file, kind, mission, next(blocks), blocks)
        if drawn:
            curve.figure().savefig(drawn, format=picture, dpi=150)
        if kind == "txt":
            curve.write_damit(arguments.output)
    if picture is not None:
        print(arguments.figure)


class _Curve:
    """The light curve of a mission, and the arrays of a figure or file of DAMIT, by blocks."""

    def __init__(self, mission, kind, *, is_drawn):
        self._mission, self._kind, self._is_drawn = mission, kind, is_drawn
        self._others = replace(mission, columns=mission.columns[1:])
        self._parts = []

    def block(self, view, digits):
        """The columns of a View, after its dates."""
        magnitude = self.magnitude_of(view).tolist()
        return [*geometry.dates(view, digits), magnitude, *geometry.numbers(self._others, view)]

    def magnitude_of(self, view):
        """The magnitudes of a View, whose arrays are kept."""
        magnitude = self._mission.magnitude.of(view)
        kept = {}
        if self._is_drawn:
            kept = {"epoch": view.epoch, "seconds": view.seconds, "magnitude": magnitude}
            kept["phase_angle"] = view.phase_angle
            if view.scene.shadow_of:
                kept["lit_fraction"] = view.lit_fraction
            if view.scene.observer.has_horizon:
                kept["elevation"] = view.elevation
                kept["sun_elevation"] = view.sun_elevation
        if self._kind == "txt":
            kept |= {"epoch": view.epoch, **self._of_damit(view)}
        self._parts.append(kept)
        return magnitude

    def _of_damit(self, view):
        left, reduced = view.emission, _reduced(self._mission, view)
        places = (
            (view.sun_direction_icrf, view.sun_distance),
            (view.observer_direction_icrf, view.observer_distance),
        )
        vectors = (np.asarray(unit) * np.asarray(far)[:, None] for unit, far in places)
        return dict(zip(_DAMIT, (reduced, left.hi, left.low, *vectors), strict=True))

    def figure(self):
        names = [name for name in self._parts[0] if name not in _DAMIT]
        return of(self._mission, **{name: self._joined(name) for name in names})

    def write_damit(self, path):
        """Write one calibrated curve, in units of magnitude 0 at unit distances."""
        from attitude.epochs import _instants
        from attitude.formats import damit_light_curve

        kept = [self._joined(name) for name in _DAMIT]
        observed = ~np.isnan(kept[0])  # not by day, nor below the horizon of a site
        reduced, hi, lo, sun, observer = (column[observed] for column in kept)
        if not reduced.size:
            raise AttitudeError(
                f"--output {path!r}: at all {len(observed)} epochs the site does not observe the "
                "body, by day or below the horizon; give other times, or site_limits = false."
            )
        if not np.all(np.isfinite(reduced)):
            raise AttitudeError(
                f"--output {path!r}: at {np.count_nonzero(~np.isfinite(reduced))} epochs nothing "
                "of the body is both lit and seen, which DAMIT's files cannot hold; give other "
                "times, or an --output x.csv."
            )
        left = _instants.times(self._parts[0]["epoch"], hi, lo)
        curve = damit_light_curve.from_positions(
            left, 10.0 ** (-0.4 * reduced), sun, observer, calibrated=True
        )
        damit_light_curve.write_damit_light_curves(path, curve)

    def _joined(self, name):
        parts = [kept[name] for kept in self._parts]
        return parts[0] if name == "epoch" else np.concatenate(parts)


def _columns(mission, view):
    """The columns of every light curve, then those of the file."""
    from attitude.formats.mission import MissionColumn

    scene, is_apparent = view.scene, mission.magnitude.kind == "apparent"
    units = {"magnitude" if is_apparent else "reduced_magnitude": "mag", "brightness": "m2 / sr"}
    units["phase_angle"] = "deg"
    for name, place in (("sun_distance", scene.sun), ("observer_distance", scene.observer)):
        if not place.is_direction:
            units[name] = "au" if getattr(view, name)[0] > _FAR else "km"
    if scene.shadow_of:
        units["lit_fraction"] = ""
    if scene.observer.has_horizon:
        units["elevation"] = "deg"
    columns = {name: MissionColumn(name, unit) for name, unit in units.items()}
    return tuple((columns | {column.name: column for column in mission.columns}).values())


def _require_paths(scene: Scene, output: str) -> None:
    """Raise the AttitudeError for a Sun or observer without a distance."""
    for place, name in ((scene.sun, "sun"), (scene.observer, "observer")):
        if place.is_direction:
            raise AttitudeError(
                f"--output {output!r}: the {name} is a direction, but DAMIT's files hold vectors "
                "to Sun and observer; give it as a path, or an --output x.csv."
            )
