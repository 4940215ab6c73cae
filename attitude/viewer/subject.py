"""What a page or animation shows: a motion or scene, a span of time, and a shape."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from attitude import epochs, pairs, plots, validation
from attitude.errors import AttitudeError
from attitude.motion import Motion, motion_of
from attitude.scene import Scene
from attitude.shape import Ellipsoid, Mesh

if TYPE_CHECKING:
    from collections.abc import Callable

    from attitude.annotations import EpochOrSeconds, FloatArray
    from attitude.history import AttitudeHistory
    from attitude.motion import HasAttitudes
    from attitude.scene import View

# Turns that are shown of a motion without periods and without a span of its own.
_TURNS = 10.0
# s that are shown of a body at rest.
_AT_REST = 3600.0


@dataclass(frozen=True)
class Subject:
    """What is shown; made by `subject`.

    Times are seconds of TDB from `start`.  In a scene they are those at which light is received:
    the attitude shown is the one that the light shows.

    Attributes
    ----------
    motion : Motion
    scene : Scene or None
    shape : Ellipsoid, Mesh or None
    start : Instant
    duration : float
        s
    title : str
    magnitude : callable or None
        Magnitudes (N,) of a View, and `label` on their axis; None without a shape in the scene.
    label : str
    """

    motion: Motion
    scene: Scene | None
    shape: Ellipsoid | Mesh | None
    start: epochs.Instant
    duration: float
    title: str
    magnitude: Callable[[View], FloatArray] | None
    label: str

    def at(self, times: FloatArray) -> AttitudeHistory:
        """The attitudes that are seen at times (N,), s from the start."""
        if self.scene is not None:
            return self.view(times).attitude
        hi, lo = pairs.add(self._offset(), np.asarray(times, dtype=np.float64))
        return self.motion.at(hi, low=lo)

    def view(self, times: FloatArray) -> View:
        """The scene at times (N,), s from the start."""
        assert self.scene is not None
        return self.scene.since(self.start, times)

    def breaks(self) -> FloatArray:
        """Times within the span at which the angular velocity jumps, s from the start."""
        joints = self.motion.breaks()
        hi, lo = self._offset()
        found = (joints[:, 0] - hi) + (joints[:, 1] - lo)
        if self.scene is not None and len(found):
            # Light arrives later than it leaves: the delay at the start serves the whole span.
            left, low = self.view(np.zeros(1)).emission
            found = found + (hi - left[0]) + (lo - (0.0 if low is None else low[0]))
        return np.sort(found[(found > 0.0) & (found < self.duration)])

    def utc(self, times: FloatArray) -> list[str]:
        """ISO texts in UTC of times, s from the start."""
        return [self.start.after(float(each)).utc_iso for each in times]

    def _offset(self) -> tuple[float, float]:
        own, start = self.motion.epoch, self.start
        return pairs.add((start.seconds, start.low), -own.seconds, -own.low)


def subject(
    given: HasAttitudes | Scene,
    start: EpochOrSeconds | None = None,
    stop: EpochOrSeconds | None = None,
    *,
    shape: Ellipsoid | Mesh | None = None,
    title: str | None = None,
    magnitude: tuple[Callable[[View], FloatArray], str] | None = None,
) -> Subject:
    """The Subject of a motion or a scene.

    Parameters
    ----------
    given : Scene, Motion or object with ``.at(t)``
    start, stop : epochs, or TDB seconds since the epoch of the motion
        By default the span of the motion; of a free rotation three turns of the slower phase.
    shape : Ellipsoid or Mesh, optional
        Drawn in place of that of the scene.
    title : str, optional
    magnitude : (callable, str), optional
        Magnitudes of a View in place of `View.magnitude`, or of the reduced magnitude if the Sun
        or the observer is a direction; and the label of their axis.

    Raises
    ------
    AttitudeError
        For a scene without a motion, and a start or stop that is not a finite epoch or out of
        order.
    """
    if shape is not None and not isinstance(shape, (Ellipsoid, Mesh)):
        raise AttitudeError(
            f"shape is {type(shape).__name__}; give an Ellipsoid or Mesh of attitude.shape, such "
            "as shape.read(file)."
        )
    scene = given if isinstance(given, Scene) else None
    if isinstance(given, Scene):
        if given.motion is None:
            raise AttitudeError("the scene has no motion; give Scene(motion, ...) to show one.")
        motion = given.motion
    else:
        motion = motion_of(given)
    first, last = _span(motion, start, stop)
    label = "magnitude"
    if scene is not None and scene.shape is not None and magnitude is None:
        is_far = scene.sun.is_direction or scene.observer.is_direction
        label = "reduced magnitude" if is_far else label
        magnitude = (_reduced if is_far else _apparent), label
    drawn = shape if shape is not None or scene is None else scene.shape
    name = type(motion).__name__ if title is None else title
    of_view, label = magnitude if magnitude is not None else (None, label)
    return Subject(motion, scene, drawn, first, last.since(first), name, of_view, label)


def _apparent(view: View) -> FloatArray:
    return view.magnitude


def _reduced(view: View) -> FloatArray:
    return view.reduced_magnitude


def _span(motion: Motion, start: Any, stop: Any) -> tuple[epochs.Instant, epochs.Instant]:
    first = motion.epoch if motion.span is None else motion.span[0]
    if start is not None:
        first = _instant(motion, start, "start")
    if stop is not None:
        last = _instant(motion, stop, "stop")
    elif motion.span is not None:
        last = motion.span[1]
    else:
        last = first.after(_typical(motion))
    if not last.since(first) > 0.0:
        raise AttitudeError(
            f"stop is {last.utc_iso} and start {first.utc_iso}; give a stop after the start."
        )
    return first, last


def _instant(motion: Motion, value: Any, name: str) -> epochs.Instant:
    hi, lo = epochs.seconds_since(motion.epoch, value, None, name)
    if np.ndim(hi):
        raise AttitudeError(f"{name} holds {np.size(hi)} epochs; give one.")
    if not np.isfinite(hi):
        raise AttitudeError(f"{name} is {validation.shown(value)}; give a finite epoch.")
    return motion.epoch.after(float(hi), 0.0 if lo is None else float(lo))


def _typical(motion: Motion) -> float:
    """Seconds that show what a motion without a span does."""
    try:
        _ = motion.regime
    except AttitudeError:
        rate = float(np.linalg.norm(motion.at(0.0).angular_velocity))
        turns = _TURNS * 2.0 * np.pi / rate if rate > 0.0 else _AT_REST
        return float(np.max(motion.joints, initial=0.0)) + turns
    rates = motion.angular_velocity_at(np.zeros(1))
    return plots.time_span(motion) if np.any(rates) else _AT_REST  # type: ignore[arg-type]
