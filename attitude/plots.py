"""Plots of a motion: the polhode, the body axes on the sky, rates and angles against time.

Every function draws into given matplotlib axes, so that plots can be combined; `overview` makes a
figure of four.  No window is opened, and no global setting changed.
"""

from __future__ import annotations

import io
import os
import warnings
from functools import cache
from typing import TYPE_CHECKING, Any

import numpy as np

from attitude import frames
from attitude._solver.states import States
from attitude._support import validation
from attitude._support.constants import COLORS, DAY_S
from attitude._support.quantity_text import time_unit
from attitude._support.synonyms import arguments, of_module
from attitude._textfiles.atomic_write import written_whole
from attitude._textfiles.lines import path_text
from attitude.catalog import motion_of
from attitude.errors import AttitudeError, AttitudeWarning
from attitude.motions import _conventions
from attitude.motions._free_rotation import FreeRotation, polhode_of

if TYPE_CHECKING:
    from collections.abc import Iterator

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from numpy.typing import ArrayLike

    from attitude._support.annotations import FilePath, FloatArray, Real
    from attitude.epochs._instants import Instant

__all__ = [
    "angles",
    "new_figure",
    "overview",
    "polhode",
    "rates",
    "sky",
    "stacked",
    "time_span",
    "time_unit",
]


_NAMES = ("long axis", "middle axis", "short axis")
_POINTS = 1201
# Parts of a longer curve that is drawn by its extremes, enough for a figure of 1500 pixels.
_PARTS = 20_000
# Fewest points a turn that draw a curve.
_A_TURN = 8.0


@arguments({}, 'overview(motion, title="Toutatis")')
def overview(
    motion: FreeRotation | str,
    *,
    span: Real | None = None,
    frame: str = "ecliptic",
    title: str | None = None,
) -> Figure:
    """A figure of four plots: polhode, sky, angular velocity, Euler angles."""
    motion = _free(motion)
    figure = new_figure((9.0, 7.8))
    seconds = np.linspace(0.0, time_span(motion, span), _POINTS)
    _warn_of_coarse(motion, seconds)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", AttitudeWarning)  # said once
        polhode(figure.add_subplot(2, 2, 1, projection="3d"), motion)
        sky(figure.add_subplot(2, 2, 2, projection="mollweide"), motion, seconds, frame=frame)
        rates(figure.add_subplot(2, 2, 3), motion, seconds)
        angles(figure.add_subplot(2, 2, 4), motion, seconds)
    if title:
        figure.suptitle(title, parse_math=False)
    return figure


def _free(motion: FreeRotation | str) -> FreeRotation:
    """The free rotation that is given, or that of a name in the catalogue."""
    known = motion_of(motion) if isinstance(motion, str) else motion
    wanted = "a FreeRotation, such as FreeRotation(motion.body_at(t), motion.spin_at(t))"
    return validation.instance(known, FreeRotation, "motion", wanted)


def _warn_of_coarse(motion: FreeRotation, seconds: ArrayLike) -> None:
    """Warn of steps between epochs that are coarse against the shortest period of a motion."""
    steps = np.abs(np.diff(np.asarray(seconds, dtype=np.float64)))
    longest = float(np.max(steps, initial=0.0))
    warn_of_coarse("the curves have a point", longest, shortest_period(motion), remedy="epochs")


def shortest_period(motion: FreeRotation) -> float:
    """The shortest period of a motion, s; infinite without any."""
    regime = motion.regime
    periods = [abs(period) for period in (regime.P_psi, regime.P_phi_L, regime.P_phi_S)]
    return min((period for period in periods if 0.0 < period < np.inf), default=np.inf)


def warn_of_coarse(
    what: str, step: float, period: float, *, most: float = 1.0 / _A_TURN, remedy: str = ""
) -> None:
    """Warn of steps, s, of what is drawn that are longer than a share of a period, s."""
    if step > most * period:
        otherwise = f", or {remedy} at most {most * period:.3g} s apart" if remedy else ""
        warnings.warn(
            f"{what} every {step:.4g} s, which is coarse against the shortest period of the "
            f"motion, {period:.4g} s: what happens in between does not show. Give a shorter "
            f"span{otherwise}.",
            AttitudeWarning,
            stacklevel=4,
        )


def new_figure(size: tuple[float, float]) -> Figure:
    """An empty figure without a window, of a width and height in inches."""
    return _figure_class()(figsize=size, layout="constrained")


def plain(text: str) -> str:
    """A label that is drawn as it stands: without mathematics, and not left out of a legend."""
    return (" " if text.startswith("_") else "") + text.replace("$", r"\$")


def saved(figure: Figure, path: FilePath | None, dpi: float = 130.0) -> Figure:
    """The figure itself; with a path it is written there whole, in the format of the ending."""
    if path is not None:
        kind = os.path.splitext(path_text(path))[1][1:].lower()
        known = figure.canvas.get_supported_filetypes()
        if kind not in known:
            raise AttitudeError(
                f"the figure {os.fspath(path)!r} has no ending of a picture; give one of "
                f".{', .'.join(known)}."
            )
        with written_whole(path, "figure", binary=True) as file:
            figure.savefig(file, format=kind, dpi=dpi)
    return figure


def stacked(size: tuple[float, float], count: int, **options: Any) -> tuple[Figure, list[Axes]]:
    """An empty figure of plots one above the other, with grids and one horizontal axis.

    Parameters
    ----------
    size : (float, float)
        Width and height, inches.
    count : int
        Of the plots.
    **options
        Of `matplotlib.figure.Figure.subplots`, such as height_ratios.

    Returns
    -------
    figure, plots
    """
    figure = new_figure(size)
    panels = list(np.ravel(figure.subplots(count, 1, sharex=True, **options)))
    for panel in panels:
        panel.grid(alpha=0.3)
        panel.ticklabel_format(useOffset=False)
    return figure, panels


@cache
def _figure_class() -> type[Figure]:
    """Figures without a window, shown as PNG where one is the result of a cell of a notebook."""
    from matplotlib.figure import Figure

    class ShownFigure(Figure):
        """A matplotlib figure that notebooks show without a command."""

        def _repr_png_(self) -> bytes:
            buffer = io.BytesIO()
            self.savefig(buffer, format="png", dpi=100)
            return buffer.getvalue()

    return ShownFigure


def time_span(motion: FreeRotation | str, span: Real | None = None) -> float:
    """The seconds to show: as given, or three turns of the slower phase."""
    regime = _free(motion).regime
    slowest = [x for x in (regime.P_psi, regime.P_phi_L, regime.P_phi_S) if np.isfinite(x)]
    if not slowest:
        raise AttitudeError("the body is at rest: there is no motion to draw; give one that turns.")
    if span is not None:
        return validation.positive(span, "span", unit="s")
    # On the separatrix the body turns over once.
    once = 4.0 * regime.flip_time if np.isfinite(regime.flip_time) else 0.0
    longest = max(slowest)
    return 3.0 * longest if np.isfinite(regime.P_psi) else max(3.0 * longest, once)


def polhode(axes: Any, motion: FreeRotation | str | None = None) -> Figure:
    """Draw the path of the angular velocity on the ellipsoid of its energy.

    Grey: the polhodes of other momenta of the same energy; black: the separatrix.

    Parameters
    ----------
    axes : matplotlib axes of projection "3d"
        ``polhode(motion)`` draws into a new figure.
    motion : FreeRotation, or its name in the catalogue

    Returns
    -------
    matplotlib Figure
        That of the axes.

    Raises
    ------
    AttitudeError
        For a body of which one moment is zero.
    """
    if motion is None:
        motion, axes = axes, new_figure((6.0, 6.0)).add_subplot(projection="3d")
    motion = _free(motion)
    body = motion.body
    order = _conventions.order(body)
    moments = body.moments[order]
    turn = _conventions.axes(body, "S")
    if moments[0] == 0.0:
        raise AttitudeError(
            "one moment is zero; a rod has no ellipsoid of energy to draw on. Give a body whose "
            "moments are greater than zero."
        )
    scale = np.degrees(1.0)
    semi = np.sqrt(2.0 * motion.energy / moments) * scale
    longitude, latitude = np.mgrid[0 : 2 * np.pi : 49j, -np.pi / 2 : np.pi / 2 : 25j]
    surface = (
        semi[0] * np.cos(latitude) * np.cos(longitude),
        semi[1] * np.cos(latitude) * np.sin(longitude),
        semi[2] * np.sin(latitude),
    )
    axes.plot_surface(*surface, color="#dddddd", alpha=0.35, linewidth=0.0)
    for color, line in _family(moments, semi):
        axes.plot(*line.T, color=color, linewidth=0.6)
    path = motion.polhode(721) @ turn * scale
    axes.plot(*path.T, color=COLORS[1], linewidth=2.0)
    now = motion.spin.angular_velocity @ turn * scale
    axes.plot(*now[:, None], "o", color=COLORS[1])
    for k, name in enumerate(_NAMES):
        end = np.zeros((3, 2))
        end[k] = 0.0, 1.25 * semi[k]
        axes.plot(*end, color=COLORS[0], linewidth=0.8)
        axes.text(*(end[:, 1] * 1.05), name, color=COLORS[0], fontsize=9, ha="center")
    axes.set_box_aspect(semi, zoom=1.3)
    axes.set_axis_off()
    axes.set_title(f"polhode, {motion.mode.name.lower().replace('_', ' ')}", fontsize=10)
    return axes.figure


def _family(moments: FloatArray, semi: FloatArray) -> Iterator[tuple[str, FloatArray]]:
    """Polhodes of the same energy, from the long axis to the short one, on all four sides."""
    a, b, c = moments
    places = np.linspace(0.1, 0.9, 5) * np.pi / 2
    states = [(np.cos(place), 0.0, np.sin(place)) for place in places]
    if a < b < c:
        # on the separatrix a (b - a) wa^2 = c (c - b) wc^2
        node = np.arctan2(np.sqrt(b - a), np.sqrt(c - b))
        states.append((np.cos(node), 0.0, np.sin(node)))
    units = np.array(states)
    solved = States.of_principal_axes(moments[None], units * semi).solved()
    for k, record in enumerate(solved.constants):
        line = polhode_of(record, np.eye(3), 361)
        color = "black" if k == len(places) else "#999999"
        for sides in ((1, 1), (-1, 1), (1, -1), (-1, -1)):
            yield color, line * (sides[0], sides[0] * sides[1], sides[1])


@arguments({}, "sky(axes, motion, seconds)")
def sky(
    axes: Axes, motion: FreeRotation | str, seconds: ArrayLike, *, frame: str = "ecliptic"
) -> None:
    """Draw the directions of the long and the short axis and of the momentum on the sky.

    Shapes: seconds (N,).
    """
    motion = _free(motion)
    _warn_of_coarse(motion, seconds)
    history = motion.at(seconds)
    turn = frames.matrix_to_icrf(frame)
    directions = _conventions.axes(motion.body, "S")
    for k, name in enumerate(_NAMES):
        if k != 1:
            path = history.body_to_inertial(directions[:, k]) @ turn
            axes.plot(*_unbroken(*_map(path)), color=COLORS[k], linewidth=0.8, label=name)
            axes.plot(*_map(path[:1]), "o", color=COLORS[k], markersize=4, clip_on=False)
    if np.any(motion.momentum):
        pole = _map((motion.momentum @ turn)[None])
        axes.plot(*pole, "k*", markersize=9, label="momentum", clip_on=False)
    axes.grid(True, linewidth=0.3)
    axes.set_xticks(np.radians([-120.0, -60.0, 0.0, 60.0, 120.0]))
    axes.tick_params(labelsize=9)
    _legend(axes, -0.05)
    axes.set_title(f"body axes on the sky ({frames.known(frame)})", fontsize=10)


@arguments({}, "rates(axes, motion, seconds)")
def rates(axes: Axes, motion: FreeRotation | str, seconds: ArrayLike) -> None:
    """Draw the angular velocity over the axes of inertia against time, in deg/s or deg/d.

    Shapes: seconds (N,).
    """
    motion = _free(motion)
    _warn_of_coarse(motion, seconds)
    omega = motion.angular_velocity_at(seconds) @ _conventions.axes(motion.body, "S")
    largest = np.degrees(np.max(np.abs(omega)))
    factor, unit = (1.0, "deg/s") if largest > 0.1 else (DAY_S, "deg/d")
    time, label = _time(seconds, motion.epoch)
    for k, name in enumerate(_NAMES):
        axes.plot(time, np.degrees(omega[:, k]) * factor, color=COLORS[k], label=name)
    axes.set(xlabel=label, ylabel=f"angular velocity, {unit}")
    _legend(axes, -0.13)


@arguments({}, "angles(axes, motion, seconds)")
def angles(
    axes: Axes, motion: FreeRotation | str, seconds: ArrayLike, *, convention: str | None = None
) -> None:
    """Draw phi, theta, psi about the momentum against time, in degrees.

    Shapes: seconds (N,).
    """
    motion = _free(motion)
    _warn_of_coarse(motion, seconds)
    if convention is None:
        convention = "L" if motion.regime.circulates < 0 else "S"
    degrees = np.degrees(motion.angles(seconds, convention))
    time, label = _time(seconds, motion.epoch)
    for k, name in enumerate(("phi", "theta", "psi")):
        axes.plot(*_unbroken(time, degrees[:, k], 180.0), color=COLORS[k], label=name)
    axes.set(xlabel=label, ylabel="deg", ylim=(0.0, 360.0), yticks=range(0, 361, 60))
    axes.set_title(f'Euler angles about the momentum, convention "{convention}"', fontsize=10)
    _legend(axes, -0.13)


def _legend(axes: Axes, height: float) -> None:
    """Draw the legend below the plot."""
    axes.legend(
        fontsize=9, ncols=3, loc="upper center", bbox_to_anchor=(0.5, height), frameon=False
    )


def _time(times: ArrayLike, epoch: Instant) -> tuple[FloatArray, str]:
    """Times in a unit that suits their span, and a label with that unit and the epoch."""
    seconds = np.asarray(times, dtype=np.float64)
    unit, name = time_unit(float(np.max(np.abs(seconds))))
    return seconds / unit, f"time since {epoch.utc_iso} UTC, {name}"


def extremes(x: FloatArray, y: FloatArray) -> tuple[FloatArray, FloatArray]:
    """A long curve as the least and the greatest value of each of many parts; NaN of none."""
    size = len(x) // _PARTS
    if size < 2:
        return x, y
    count = len(x) // size * size
    parts = np.where(np.isfinite(y[:count]), y[:count], np.inf).reshape(-1, size)
    low = np.min(parts, axis=1)
    high = np.max(np.where(np.isfinite(parts), parts, -np.inf), axis=1)
    pairs = np.stack([low, high], axis=1).reshape(-1)
    return np.repeat(x[:count:size], 2), np.where(np.isfinite(pairs), pairs, np.nan)


def _map(vectors: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Longitudes and latitudes (N,), rad, of vectors (N, 3)."""
    x, y, z = vectors.T
    return np.arctan2(y, x), np.arctan2(z, np.hypot(x, y))


def _unbroken(x, y, jump=None):
    """The line with gaps where an angle jumps: x of a map, or y by more than `jump`."""
    x, y = np.array(x, dtype=float), np.array(y, dtype=float)
    leap = np.abs(np.diff(x)) > np.pi if jump is None else np.abs(np.diff(y)) > jump
    gaps = np.flatnonzero(leap) + 1
    return np.insert(x, gaps, np.nan), np.insert(y, gaps, np.nan)


if not TYPE_CHECKING:
    # Hidden from type checkers: a module with __getattr__ has every name, misspelt ones too.
    __getattr__ = of_module(__name__)
