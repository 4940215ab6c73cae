"""What the page knows: attitudes, directions, light curve and surface, as one value for JSON.

Arrays are base64 of little-endian bytes: attitudes as int16 in units of 1/32767 (0.007 degree at
most), rates and directions as float32, vertices as uint16 between the least and greatest
coordinate, facets as uint32.
"""

from __future__ import annotations

import base64
from typing import TYPE_CHECKING, Any

import numpy as np

from attitude import markup
from attitude.errors import AttitudeError
from attitude.shape import Mesh
from attitude.viewer import drawn_shape, poinsot, poses, sky

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import ArrayLike

    from attitude.annotations import FloatArray, IntArray
    from attitude.motion import Motion
    from attitude.viewer.subject import Subject

_ROUND = 32767.0


def encoded(array: ArrayLike, kind: str) -> str:
    """An array as base64 of the bytes of a little-endian type such as "<f4"."""
    return base64.b64encode(np.ascontiguousarray(array, dtype=kind).tobytes()).decode("ascii")


def content(
    subject: Subject, progress: Callable[[int, int], object] | None = None
) -> dict[str, Any]:
    """All data of a page.

    Raises
    ------
    AttitudeError
        As `poses.pieces`.
    """
    found = poses.pieces(subject)
    kind, rows = facts(subject)
    begin, end = subject.utc(np.array([0.0, subject.duration]))
    data: dict[str, Any] = {
        "title": subject.title,
        "kind": kind,
        "facts": rows,
        "duration": subject.duration,
        "utc": [begin, end],
        "poses": [_piece(each) for each in found],
        "turns": any(each.angular_velocity.any() for each in found),
        "momentum": None if subject.motion.momentum is None else _momentum(subject.motion),
        "surface": _surface(subject),
        "poinsot": _poinsot(subject),
        "sun": None,
        "observer": None,
        "curve": None,
        "speed": seconds_a_second(subject, found),
    }
    if subject.scene is not None:
        for which in ("sun", "observer"):
            data[which] = encoded(sky.directions(subject, which), "<f4")
        curve = sky.light_curve(subject, progress)
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
    kind, rows = markup.rows_of(str(motion)) if _is_free(motion) else _other_facts(subject)
    if subject.scene is not None:
        rows.append(("seen from", subject.scene.observer.name))
        rows.append(("lit by", subject.scene.sun.name))
    return kind, rows


def _is_free(motion: Motion) -> bool:
    try:
        _ = motion.regime
    except AttitudeError:
        return False
    return True


def _other_facts(subject: Subject) -> tuple[str, list[tuple[str, str]]]:
    motion = subject.motion
    times = np.linspace(0.0, subject.duration, 257)
    rates = np.degrees(np.linalg.norm(subject.at(times).angular_velocity, axis=1))
    rows = [
        ("span", f"{subject.duration:.9g} s from {subject.start.utc_iso} UTC"),
        ("angular velocity", f"{rates.min():.6g} to {rates.max():.6g} deg/s"),
    ]
    if motion.body is not None:
        moments = ", ".join(f"{each:.6g}" for each in motion.body.moments)
        rows.append(("moments", f"{moments}{'' if motion.body.relative else ' kg m2'}"))
    else:
        rows.append(("moments", "unknown: without them no momentum is drawn"))
    if len(subject.breaks()):
        rows.append(("impulses", f"{len(subject.breaks())} in the span"))
    return type(motion).__name__, rows


def _piece(piece: poses.PosePiece) -> dict[str, Any]:
    return {
        "start": piece.start,
        "step": piece.step,
        "wxyz": encoded(np.rint(piece.wxyz * _ROUND), "<i2"),
        "rates": encoded(piece.angular_velocity, "<f4"),
    }


def _momentum(motion: Motion) -> list[float] | None:
    """The direction of the constant momentum, ICRF; None for a body at rest."""
    momentum = np.asarray(motion.momentum, dtype=float)
    size = float(np.linalg.norm(momentum))
    return (momentum / size).tolist() if size > 0.0 else None


def _surface(subject: Subject) -> dict[str, Any]:
    found = drawn_shape.surface(subject)
    data = {
        "kind": found.kind,
        "convex": not isinstance(subject.shape, Mesh) or subject.shape.is_convex,
        "closed": found.closed,
        "size": found.size,
        "coarse": None,
        **_triangles(found.vertices, found.facets),
    }
    if len(found.facets) > drawn_shape.COARSE:
        few = drawn_shape.coarser(found.vertices, found.facets, drawn_shape.COARSE)
        data["coarse"] = _triangles(*few)
    return data


def _triangles(vertices: FloatArray, facets: IntArray) -> dict[str, Any]:
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    width = np.where(high > low, high - low, 1.0)
    return {
        "low": low,
        "width": width,
        "vertices": encoded(np.rint((vertices - low) / width * 65535.0), "<u2"),
        "facets": encoded(facets, "<u4"),
    }


def _poinsot(subject: Subject) -> dict[str, Any] | None:
    found = poinsot.construction(subject)
    if found is not None:
        for name in ("polhode", "herpolhode"):
            found[name] = encoded(found[name], "<f4")
    return found


def seconds_a_second(subject: Subject, found: list[poses.PosePiece]) -> float:
    """Seconds of the motion that a second of a picture shows: a turn in some eight seconds."""
    rates = [np.linalg.norm(each.angular_velocity, axis=1).mean() for each in found]
    fastest = float(np.max(rates))
    turns = fastest * subject.duration / (2.0 * np.pi)
    return subject.duration / max(8.0 * turns, 8.0)
