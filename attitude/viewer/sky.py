"""Directions to Sun and observer and the light curve, at epochs close enough for lines between."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from attitude.shape import Mesh
from attitude.viewer.poses import TOLERANCE

if TYPE_CHECKING:
    from collections.abc import Callable

    from attitude.annotations import FloatArray
    from attitude.viewer.subject import Subject

# Epochs of directions: at first, and at most.
_FIRST, _MOST = 33, 8193
# Points of a light curve for each half turn, and their least and largest number.
_HALF_TURN, _LEAST, _CURVE = 40.0, 240, 4000
# Facets times points, roughly, that are computed in some ten seconds.
_WORK = 100_000_000
# Points of a light curve computed between two reports.
_BLOCK = 250


def directions(subject: Subject, which: str) -> FloatArray:
    """Unit vectors (N, 3), ICRF, from the body at equal steps over the span.

    `which` is "sun" or "observer".  Lines between neighbours stay within 0.1 degree, up to the
    largest number of epochs; a fixed direction is one row.
    """
    count = _FIRST
    while True:
        found = _icrf(subject, which, count)
        if np.ptp(found, axis=0).max() == 0.0:
            return found[:1]
        middle = found[:-2:2] + found[2::2]
        middle = middle / np.linalg.norm(middle, axis=1)[:, None]
        if np.linalg.norm(middle - found[1:-1:2], axis=1).max() < TOLERANCE or count >= _MOST:
            return found
        count = 2 * count - 1


def _icrf(subject: Subject, which: str, count: int) -> FloatArray:
    view = subject.view(np.linspace(0.0, subject.duration, count))
    name = "sun_direction_icrf" if which == "sun" else "observer_direction_icrf"
    return np.broadcast_to(np.asarray(getattr(view, name)), (count, 3))


def light_curve(
    subject: Subject, progress: Callable[[int, int], object] | None = None
) -> dict[str, Any] | None:
    """Times in s from the start, and magnitudes (inf where nothing is seen); None without a shape.

    ``progress(done, count)`` is called after each block.
    """
    if subject.magnitude is None or subject.scene is None or subject.scene.shape is None:
        return None
    times = np.linspace(0.0, subject.duration, _points(subject))
    parts = []
    for begin in range(0, len(times), _BLOCK):
        parts.append(subject.magnitude(subject.view(times[begin : begin + _BLOCK])))
        if progress is not None:
            progress(min(begin + _BLOCK, len(times)), len(times))
    return {"times": times, "magnitudes": np.concatenate(parts), "label": subject.label}


def _points(subject: Subject) -> int:
    """Points of the light curve: a body shows two maxima a turn."""
    inner = subject.duration * np.linspace(0.5 / 32.0, 31.5 / 32.0, 32)
    rates = np.linalg.norm(subject.at(inner).angular_velocity, axis=-1)
    half_turns = float(np.mean(rates)) * subject.duration / np.pi
    shape = subject.scene.shape if subject.scene is not None else None
    costly = _WORK // len(shape) if isinstance(shape, Mesh) else _CURVE
    most = max(min(_CURVE, costly), _LEAST)
    return int(np.clip(_HALF_TURN * half_turns, _LEAST, most))
