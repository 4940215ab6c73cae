"""Animations: the turning body with its light curve growing, as WebP, GIF or MP4."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from attitude import plots
from attitude._support import validation
from attitude.errors import AttitudeError
from attitude.frames import quaternion
from attitude.viewer import _subject

if TYPE_CHECKING:
    from collections.abc import Callable

    from attitude._support.annotations import EpochOrSeconds, FilePath, FloatArray
    from attitude.motions._motion import HasAttitudes
    from attitude.scene._scene import Scene
    from attitude.scene._view import View
    from attitude.shape._ellipsoid import Ellipsoid
    from attitude.shape._mesh import Mesh


_ENDINGS = ("webp", "gif", "mp4")
# Frames a second that all endings hold.
_RATES = (0.01, 1000)
# Facets that are drawn.
_FACETS = 4000
# Least brightness of a facet, where no light falls.
_AMBIENT = 0.12
# Colours of the picture.
_GROUND = "#10131a"
_TEXT = "#aab2c4"
_LINE = "#ffb454"
_SURFACE = np.array([0.78, 0.75, 0.70])
_ROUND = np.array([0.6, 0.3, 0.74])  # towards a light without a Sun, beside the camera
# Of a body without a shape of its own the half of each sign of x, so that a flip can be seen.
_HALVES = np.array([[0.55, 0.68, 0.80], [0.85, 0.68, 0.50]])
# Lines from the centre: length, colour, name.
_AXES = ((1.3, "#ff6b6b", "x"), (1.3, "#7bd88f", "y"), (1.3, "#6cb6ff", "z"))
_MOMENTUM = (1.45, "#f5f5f5", "L")
_PER_INCH = 100.0
# Of a turn between two frames, in which the sense of rotation can still be seen.
_MOST_OF_A_TURN = 0.25
# s, of a span in which the clock has seconds.
_SHORT = 7200.0


def animate(
    motion: HasAttitudes | Scene | str,
    output: FilePath,
    *,
    start: EpochOrSeconds | None = None,
    stop: EpochOrSeconds | None = None,
    shape: Ellipsoid | Mesh | None = None,
    title: str | None = None,
    magnitude: tuple[Callable[[View], FloatArray], str] | None = None,
    frames: int = 120,
    rate: float = 20.0,
    size: tuple[int, int] = (480, 420),
    progress: Callable[[int, int], object] | None = None,
) -> None:
    """Write an animation: the body as the observer sees it, and its light curve as it grows.

    With body axes, momentum (L) and a clock; in the shadow of other bodies it is dark.

    Parameters
    ----------
    motion : HasAttitudes, name in the catalogue, or Scene
        As in `view`.  Without an observer the body is seen across its momentum; without a Sun the
        light comes from beside the camera.
    start, stop, shape, title, magnitude
        As in `view`.
    output : str or path
        Ends in .webp, .gif (both by Pillow) or .mp4 (by ffmpeg).
    frames : int
    rate : float
        Frames a second, 0.01 to 1000; .gif rounds the time of a frame to 0.01 s, .webp to 0.001 s.
    size : (int, int)
        Width and height, pixels.
    progress : callable, optional
        ``progress(done, frames)``.

    Raises
    ------
    AttitudeError
        For another ending or rate, if Pillow or ffmpeg is not installed, and as `view`.

    Notes
    -----
    Facets are shaded by their angle to the Sun; parts of the body cast no shadows on others, as
    they do on the page of `view`.  At most 4000 facets are drawn.  A body that is not given a shape
    has a blue half (body x < 0) and a brown one.
    """
    path = _subject.output_name(output, _ENDINGS)
    ending = path.rpartition(".")[2].lower()
    count = validation.count(frames, "frames", 2)
    if not _RATES[0] <= validation.number(rate, "rate") <= _RATES[1]:
        raise AttitudeError(f"rate is {rate:g} frames a second; give {_RATES[0]} to {_RATES[1]}.")
    subject = _subject.subject(motion, start, stop, shape=shape, title=title, magnitude=magnitude)
    picture = _Picture(subject, count, size)
    if ending == "mp4":
        _write_film(path, picture, rate, progress)
    else:
        _write_images(path, ending, picture, rate, progress)


class _Picture:
    """A figure of one frame after the other."""

    def __init__(self, subject, count, size):
        from matplotlib.collections import PolyCollection

        self.times = times = np.linspace(0.0, subject.duration, count)
        self.figure = figure = plots.new_figure((size[0] / _PER_INCH, size[1] / _PER_INCH))
        figure.set(dpi=_PER_INCH, facecolor=_GROUND)
        self.curve = curve = _subject.light_curve(subject)
        grid = figure.add_gridspec(2 if curve else 1, 1, height_ratios=(2, 1) if curve else (1,))
        above = figure.add_subplot(grid[0])
        above.set(xlim=(-1.5, 1.5), ylim=(-1.5, 1.5), aspect="equal", facecolor=_GROUND)
        above.set_axis_off()
        above.set_title(subject.title, color=_TEXT, fontsize=11, parse_math=False)
        self.line = None if curve is None else _axes_of(figure.add_subplot(grid[1]), curve)
        self.toward = _toward(subject, "observer", times)
        self.sun = _toward(subject, "sun", times)
        self.surface = _subject.surface(subject, _FACETS)
        shade = _subject.shade(subject)
        self.lit = np.ones(count) if shade is None else np.interp(times, shade.times, shade.lit)
        history = subject.at(times)
        fastest = float(np.max(np.linalg.norm(history.angular_velocity, axis=1)))
        turn = 2.0 * np.pi / fastest if fastest > 0.0 else np.inf
        plots.warn_of_coarse(
            "the animation has a frame", times[1], turn, most=_MOST_OF_A_TURN, remedy="frames"
        )
        self.wxyz, self.momentum = history.wxyz, _momenta(subject, history)
        self.arrows = [_arrow(above, *arrow[1:]) for arrow in (*_AXES, _MOMENTUM)]
        style = {"color": _TEXT, "fontsize": 10, "family": "monospace", "va": "top"}
        self.clock = figure.text(0.02, 0.94, "", **style)
        letters = 8 if subject.duration < _SHORT else 5
        # A second that is short of a whole one by rounding is that one.
        dates = (date.partition("T") for date in subject.utc(times + 5e-4))
        self.utc = [f"{day} {time_of_day[:letters]}" for day, _, time_of_day in dates]
        self.facets = PolyCollection([], linewidths=0.3)
        above.add_collection(self.facets)

    def frames(self, progress):
        """Draw one frame after the other."""
        for k in range(len(self.times)):
            self.draw(k)
            yield
            if progress is not None:
                progress(k + 1, len(self.times))

    def draw(self, k):
        """Frame k: facets that face the observer, from the farthest to the nearest."""
        corners = quaternion.rotate(self.wxyz[k], self.surface.vertices)[self.surface.facets]
        normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        normal /= np.maximum(np.linalg.norm(normal, axis=1), 1e-300)[:, None]
        across = _screen(self.toward[k])
        light = self.sun[k] if np.any(self.sun[k]) else _ROUND @ across
        chosen = np.flatnonzero(normal @ across[2] > 0.0)
        chosen = chosen[np.argsort(corners[chosen].mean(axis=1) @ across[2])]
        falls = self.lit[k] * np.maximum(normal[chosen] @ light, 0.0)
        colors = (_AMBIENT + (1.0 - _AMBIENT) * falls)[:, None] * self._paint()[chosen]
        self.facets.set_verts(corners[chosen] @ across[:2].T)
        self.facets.set_facecolor(colors)
        self.facets.set_edgecolor(colors)
        self._draw_arrows(k, across)
        dark = "" if self.lit[k] == 1.0 else ", in shadow"
        self.clock.set_text(f"{self.utc[k]} UTC{dark}")
        if self.curve is not None:
            done = self.curve["times"] <= self.times[k]
            unit = self.curve["unit"]
            self.line.set_data(self.curve["times"][done] / unit, self.curve["magnitudes"][done])

    def _paint(self):
        """Colours (F, 3) of the facets in full light."""
        if self.surface.kind == "mesh":
            return np.broadcast_to(_SURFACE, (len(self.surface.facets), 3))
        x = self.surface.vertices[self.surface.facets].mean(axis=1)[:, 0]
        return _HALVES[(x >= 0.0).astype(np.int64)]

    def _draw_arrows(self, k, across):
        """Body axes and momentum; those that point away lie behind the body."""
        tips = [*quaternion.rotate(self.wxyz[k], np.eye(3)), self.momentum[k]]
        for (line, label), tip, (length, _, _) in zip(
            self.arrows, tips, (*_AXES, _MOMENTUM), strict=True
        ):
            x, y, depth = across @ (length * tip)
            shown = bool(np.any(tip))
            line.set(visible=shown, zorder=3 if depth > 0.0 else 0)
            line.set_data([0.0, x], [0.0, y])
            label.set(visible=shown, position=(1.06 * x, 1.06 * y))


def _arrow(axes, color, name):
    """A line from the centre and the label at its end."""
    line = axes.plot([], [], color=color, linewidth=1.2)[0]
    return line, axes.text(0, 0, name, color=color, fontsize=10, ha="center", va="center")


def _momenta(subject, history):
    """Unit vectors (N, 3) of the momentum, ICRF; zeros where there is none, or no body."""
    if subject.motion.body is None:
        return np.zeros((*history.wxyz.shape[:1], 3))
    momentum = quaternion.rotate(history.wxyz, subject.motion.momentum_in_body(history))
    size = np.linalg.norm(momentum, axis=1)[:, None]
    return momentum / np.where(size > 0.0, size, 1.0)


def _axes_of(axes, curve):
    """The axes of a light curve with its full range, and a line without points."""
    unit, name = plots.time_unit(float(curve["times"][-1]))
    curve["unit"] = unit
    finite = curve["magnitudes"][np.isfinite(curve["magnitudes"])]
    low, high = (finite.min(), finite.max()) if len(finite) else (0.0, 1.0)
    edge = 0.05 * (high - low) + 1e-3
    axes.set(xlim=(0.0, curve["times"][-1] / unit), ylim=(high + edge, low - edge))
    axes.set_facecolor(_GROUND)
    axes.tick_params(colors=_TEXT, labelsize=10)
    axes.set_xlabel(name, color=_TEXT, fontsize=10)
    axes.set_ylabel(curve["label"], color=_TEXT, fontsize=10, parse_math=False)
    for side in axes.spines.values():
        side.set_color("#2b3140")
    return axes.plot([], [], color=_LINE, linewidth=1.2)[0]


def _toward(subject, which, times):
    """Unit vectors (N, 3) to observer or Sun; without a scene a side view, and zeros."""
    if subject.scene is not None:
        return subject.toward(which, times)
    if which == "sun":
        return np.zeros((len(times), 3))
    momentum = subject.motion.momentum
    pole = np.array([0.0, 0.0, 1.0]) if momentum is None or not np.any(momentum) else momentum
    side = np.cross(pole / np.linalg.norm(pole), [0.6, 0.64, 0.48])
    return np.broadcast_to(side / np.linalg.norm(side), (len(times), 3))


def _screen(toward):
    """Rows: right, up (north of ICRF) and towards the observer."""
    right = np.cross([0.0, 0.0, 1.0], toward)
    if np.linalg.norm(right) < 1e-9:
        right = np.array([1.0, 0.0, 0.0])
    right = right / np.linalg.norm(right)
    return np.stack([right, np.cross(toward, right), toward])


def _write_images(path, ending, picture, rate, progress):
    """All frames as one WebP or GIF."""
    try:
        from PIL import Image
    except ImportError as err:
        raise AttitudeError(
            "Pillow is not installed, which writes WebP and GIF; install it with pip install "
            "pillow."
        ) from err
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    from attitude._textfiles.atomic_write import made_whole

    canvas = FigureCanvasAgg(picture.figure)
    images = []
    for _ in picture.frames(progress):
        canvas.draw()
        images.append(Image.fromarray(np.asarray(canvas.buffer_rgba())[..., :3].copy()))
    options = {"quality": 70, "method": 4} if ending == "webp" else {"optimize": True}
    with made_whole(path) as temporary:
        images[0].save(
            temporary,
            format=ending.upper(),
            save_all=True,
            append_images=images[1:],
            duration=round(1000.0 / rate),
            loop=0,
            **options,
        )


def _write_film(path, picture, rate, progress):
    """All frames as an MP4, by ffmpeg."""
    from matplotlib.animation import FFMpegWriter

    from attitude._textfiles.atomic_write import made_whole

    if not FFMpegWriter.isAvailable():
        raise AttitudeError(
            "ffmpeg is not installed, which writes MP4; install it, or give a .webp or .gif."
        )
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    FigureCanvasAgg(picture.figure)
    writer = FFMpegWriter(fps=rate, extra_args=["-pix_fmt", "yuv420p"])
    with (
        made_whole(path) as temporary,
        writer.saving(picture.figure, temporary, dpi=_PER_INCH),
    ):
        for _ in picture.frames(progress):
            writer.grab_frame(facecolor=_GROUND)
