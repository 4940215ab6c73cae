"""`view`: one HTML file with the library three.js, the viewer's own scripts and its data."""

from __future__ import annotations

import base64
import html
import re
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from attitude._support import markup
from attitude._support.synonyms import arguments
from attitude._textfiles import lines, toml
from attitude.shape._mesh import Mesh
from attitude.viewer import _subject

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import ArrayLike

    from attitude._support.annotations import EpochOrSeconds, FilePath, FloatArray
    from attitude.motions._motion import HasAttitudes
    from attitude.scene._scene import Scene
    from attitude.scene._view import View
    from attitude.shape._ellipsoid import Ellipsoid
    from attitude.viewer._subject import Subject


FOLDER: Path = Path(__file__).resolve().parent / "page"
# The viewer's scripts, in the order in which they are joined: each uses those before it.
SCRIPTS: tuple[str, ...] = (
    "bytes",
    "poses",
    "shade",
    "clock",
    "surface",
    "labels",
    "arrows",
    "poinsot",
    "stage",
    "quality",
    "views",
    "curve",
    "panel",
    "keys",
    "numbers",
    "share",
    "main",
)


def page(data: dict[str, Any]) -> str:
    """The HTML of a page from the value of `content`."""
    parts = {
        "title": html.escape(data["title"]),
        "style": _text("style.css"),
        "licence": html.escape(f"three.js {version()}: {_text('three/LICENSE')}"),
        "three": _text("three/three.min.js"),
        "data": toml.within_script(data),
        "script": script(),
    }
    return re.sub(r"\{\{(\w+)\}\}", lambda match: parts[match.group(1)], _text("viewer.html"))


def script() -> str:
    """The scripts as one: without the lines that import, and the word export."""
    joined = []
    for name in SCRIPTS:
        text = _text(f"{name}.js")
        text = re.sub(r"^import .*;\n", "", text, flags=re.MULTILINE)
        joined.append(re.sub(r"^export ", "", text, flags=re.MULTILINE))
    return "\n".join(joined)


def version() -> str:
    """The release of three.js in the package."""
    return _text("three/VERSION").strip()


def _text(name: str) -> str:
    return lines.whole(str(FOLDER / name), "install the package again")


# ---- What the page knows: attitudes, directions, light curve and surface, as one value for JSON
# Arrays are base64 of little-endian bytes: attitudes as int16 in units of 1/32767 (0.007 degree at
# most), rates and directions as float32, vertices as uint16 between the least and greatest
# coordinate, facets as uint32.

_ROUND = 32767.0


def encoded(array: ArrayLike, kind: str) -> str:
    """An array as base64 of the bytes of a little-endian type such as "<f4"."""
    return base64.b64encode(np.ascontiguousarray(array, dtype=kind).tobytes()).decode("ascii")


def content(
    subject: Subject, progress: Callable[[int, int], object] | None = None
) -> dict[str, Any]:
    """All data of a page."""
    poses = _subject.pieces(subject)
    kind, rows = facts(subject)
    begin, end = subject.utc(np.array([0.0, subject.duration]))
    data: dict[str, Any] = {
        "title": subject.title,
        "kind": kind,
        "facts": rows,
        "duration": subject.duration,
        "utc": [begin, end],
        "poses": [_piece(piece) for piece in poses],
        "turns": any(piece.angular_velocity.any() for piece in poses),
        "momentum": None if subject.motion.momentum is None else _momentum(subject.motion),
        "surface": _surface(subject),
        "poinsot": _poinsot(subject),
        **dict.fromkeys(("sun", "observer", "shade", "curve")),
        "speed": seconds_a_second(subject, poses),
    }
    if subject.scene is not None:
        for which in ("sun", "observer"):
            data[which] = encoded(_subject.directions(subject, which), "<f4")
        shade = _subject.shade(subject)
        if shade is not None:
            data["shade"] = {
                "times": encoded(shade.times, "<f8"),
                "lit": encoded(shade.lit, "<f4"),
                "names": shade.names,
            }
        curve = _subject.light_curve(subject, progress)
        if curve is not None:
            data["curve"] = {
                "times": encoded(curve["times"], "<f8"),
                "values": encoded(curve["magnitudes"], "<f4"),
                "label": curve["label"],
            }
    return data


def facts(subject: Subject) -> tuple[str, list[tuple[str, str]]]:
    """The kind of a motion, and names and values of what is known: periods, momentum, scene."""
    motion = subject.motion
    kind, rows = markup.rows_of(str(motion)) if _subject.is_free(motion) else _other_facts(subject)
    if subject.scene is not None:
        rows.append(("seen from", subject.scene.observer.name))
        rows.append(("lit by", subject.scene.sun.name))
    return kind, rows


def _other_facts(subject):
    motion = subject.motion
    times = np.linspace(0.0, subject.duration, 257)
    rates = np.degrees(np.linalg.norm(subject.at(times).angular_velocity, axis=1))
    rows = [
        ("span", f"{subject.duration:.9g} s from {subject.start.utc_iso} UTC"),
        ("angular velocity", f"{rates.min():.6g} to {rates.max():.6g} deg/s"),
    ]
    if motion.body is not None:
        moments = ", ".join(f"{moment:.6g}" for moment in motion.body.moments)
        rows.append(("moments", f"{moments}{'' if motion.body.relative else ' kg m2'}"))
    else:
        rows.append(("moments", "unknown: without them no momentum is drawn"))
    if len(subject.breaks()):
        rows.append(("impulses", f"{len(subject.breaks())} in the span"))
    return type(motion).__name__, rows


def _piece(piece):
    return {
        "start": piece.start,
        "step": piece.step,
        "wxyz": encoded(np.rint(piece.wxyz * _ROUND), "<i2"),
        "rates": encoded(piece.angular_velocity, "<f4"),
    }


def _momentum(motion):
    """The direction of the constant momentum, ICRF; None for a body at rest."""
    momentum = np.asarray(motion.momentum, dtype=float)
    size = float(np.linalg.norm(momentum))
    return (momentum / size).tolist() if size > 0.0 else None


def _surface(subject):
    drawn = _subject.surface(subject)
    data = {
        "kind": drawn.kind,
        "convex": not isinstance(subject.shape, Mesh) or subject.shape.is_convex,
        "closed": drawn.closed,
        "smooth": drawn.smooth,
        "size": drawn.size,
        "coarse": None,
        **_triangles(drawn.vertices, drawn.facets),
    }
    if len(drawn.facets) > _subject.COARSE:
        few = _subject.coarser(drawn.vertices, drawn.facets, _subject.COARSE)
        data["coarse"] = _triangles(*few)
    return data


def _triangles(vertices, facets):
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    width = np.where(high > low, high - low, 1.0)
    return {
        "low": low,
        "width": width,
        "vertices": encoded(np.rint((vertices - low) / width * 65535.0), "<u2"),
        "facets": encoded(facets, "<u4"),
    }


def _poinsot(subject):
    drawn = _subject.construction(subject)
    if drawn is not None:
        for name in ("polhode", "herpolhode"):
            drawn[name] = encoded(drawn[name], "<f4")
    return drawn


def seconds_a_second(subject: Subject, pieces: list[_subject.PosePiece]) -> float:
    """Seconds of the motion that a second of a picture shows: a turn in some eight seconds."""
    rates = [np.linalg.norm(piece.angular_velocity, axis=1).mean() for piece in pieces]
    fastest = float(np.max(rates))
    turns = fastest * subject.duration / (2.0 * np.pi)
    return subject.duration / max(8.0 * turns, 8.0)


# ---- A motion or scene as a page with three.js: one HTML file that needs no network


@dataclass(frozen=True, repr=False)
class Viewer:
    """A page that shows a motion; notebooks show it inline.

    Attributes
    ----------
    html : str
        The whole page.
    title : str
    height : int
        Of the frame in a notebook, pixels.
    """

    html: str
    title: str
    height: int = 640

    def write(self, output: FilePath) -> None:
        """Write the page to a file, which appears whole or not at all."""
        from attitude._textfiles.atomic_write import written_whole

        with written_whole(output) as file:
            file.write(self.html)

    def _repr_html_(self) -> str:
        return (
            f'<iframe srcdoc="{html.escape(self.html)}" title="{html.escape(self.title)}" '
            f'style="width:100%;height:{self.height}px;border:0" allowfullscreen></iframe>'
        )

    def __repr__(self) -> str:
        return f"<Viewer of {self.title}: a page of {len(self.html) / 1e3:.0f} kB>"


@arguments(dict.fromkeys(("file", "path"), "give output="), 'view(motion, output="m.html")')
def view(
    motion: HasAttitudes | Scene | str,
    *,
    output: FilePath | None = None,
    start: EpochOrSeconds | None = None,
    stop: EpochOrSeconds | None = None,
    shape: Ellipsoid | Mesh | None = None,
    title: str | None = None,
    magnitude: tuple[Callable[[View], FloatArray], str] | None = None,
    progress: Callable[[int, int], object] | None = None,
) -> Viewer:
    """A page that shows a motion, or a scene with its Sun, observer and light curve.

    Parameters
    ----------
    motion : Motion, its name in the catalogue, object with ``.at(t)``, or Scene
        Of a Scene the page shows what the light shows that is received at its times.
    output : str or path, optional
        File to write; by default none.
    start, stop : epochs, or TDB seconds since the epoch of the motion
        By default the span of the motion; of a free rotation three turns of its slower phase.
    shape : Ellipsoid or Mesh, optional
        Drawn in place of the shape of the scene; without either the ellipsoid of inertia, or a box
        where the inertia is unknown.
    title : str, optional
    magnitude : (callable, str), optional
        Magnitudes of a View for the light curve, and the label of their axis; by default apparent
        magnitudes, or reduced ones if the Sun or the observer is a direction.
    progress : callable, optional
        ``progress(done, count)`` is called while the light curve is computed.

    Returns
    -------
    Viewer
        In a notebook it shows itself; `Viewer.write` writes it to a file.

    Raises
    ------
    AttitudeError
        For a span that is empty, out of order, not finite, or so long that more than 400,000
        attitudes are needed; for epochs outside of the motion; for a file that cannot be written.

    Warns
    -----
    AttitudeWarning
        If a mesh has more than 200,000 facets, of which fewer are drawn.

    Notes
    -----
    Attitudes between those of the page follow great circles, which keeps them within 0.1 degree of
    the motion.

    >>> from attitude import Body, FreeRotation, Spin
    >>> spin = Spin(epoch="2026-01-01", wxyz=(1, 0, 0, 0), angular_velocity=(1, 15, 1))
    >>> view(FreeRotation(Body(moments=(10, 20, 26)), spin), title="the paper's body").title
    "the paper's body"
    """
    name = None if output is None else _subject.output_name(output, ("html", "htm"))
    subject = _subject.subject(motion, start, stop, shape=shape, title=title, magnitude=magnitude)
    viewer = Viewer(page(content(subject, progress)), subject.title)
    if name is not None:
        viewer.write(name)
    return viewer
