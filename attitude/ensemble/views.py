"""A scene in which members of an ensemble take the place of its motion."""

from __future__ import annotations

from copy import copy
from typing import TYPE_CHECKING, Any

import numpy as np

from attitude import pairs
from attitude.ensemble.rows import MemberGrid
from attitude.errors import AttitudeError
from attitude.immutable import frozen
from attitude.scene.lazy import kept, quantity
from attitude.scene.lines_of_sight import LineOfSight
from attitude.scene.view import View

if TYPE_CHECKING:
    from attitude.annotations import FloatArray
    from attitude.body import Body
    from attitude.ensemble.answer import EnsembleHistory
    from attitude.ensemble.collection import Collection
    from attitude.motion import Motion
    from attitude.scene.scene import Scene


class MemberView(View):
    """What is seen of N members at T epochs: a View of shape (N, T).

    Lines of sight are those of the centre, the same for all members.

    Parameters
    ----------
    base : View
        The scene at all epochs.
    epochs : slice
        The epochs of the history among them.
    history : EnsembleHistory (N, T)
        Attitudes of the members at the epochs of emission.
    """

    def __init__(self, base: View, epochs: slice, history: EnsembleHistory) -> None:
        self._base: View
        self._epochs: slice
        self._history: EnsembleHistory
        low = None if base.low is None else np.array(self._tiled(base.low[epochs], history.shape))
        seconds = np.array(self._tiled(base.seconds[epochs], history.shape))
        super().__init__(base.scene, base.epoch, seconds, low)
        self._set("_base", base)
        self._set("_epochs", epochs)
        self._set("_history", history)
        self.__dict__["attitude"] = history

    @staticmethod
    def _tiled(array: Any, shape: tuple[int, ...]) -> Any:
        return np.broadcast_to(array, shape)

    def _line(self, name: str) -> LineOfSight:
        """A line of sight of the base, repeated for each member."""
        found: LineOfSight = getattr(self._base, name)
        count = self.shape[0]
        unit, distance = found.unit, found.distance
        if unit.shape[1] > 1:
            unit = np.tile(unit[:, self._epochs], count)
        if distance is not None:
            distance = np.tile(distance[self._epochs], count)
        return LineOfSight(unit.copy(), distance, found.source, found.error)

    @kept
    def observer_line(self) -> LineOfSight:
        """The `LineOfSight` from the body at emission to the observer at reception; m."""
        return self._line("observer_line")

    @kept
    def sun_line(self) -> LineOfSight:
        """The line from the body at emission to the Sun when its light left towards it; m."""
        return self._line("sun_line")

    @kept
    def observer_sun_line(self) -> LineOfSight:
        """The `LineOfSight` from the observer at reception to the Sun when its light left; m."""
        return self._line("observer_sun_line")

    @kept
    def emission(self) -> tuple[FloatArray, FloatArray | None]:
        """TDB seconds from `epoch` at which the light leaves the body, hi + lo, flat."""
        hi, lo = self._base.emission
        count = self.shape[0]
        low = None if lo is None else frozen(np.tile(lo[self._epochs], count))
        return frozen(np.tile(hi[self._epochs], count)), low

    @quantity()
    def lit_fraction(self) -> FloatArray:
        """Fraction of the Sun's disc that the bodies of `scene.shadow_of` leave free, 0 to 1."""
        return np.array(self._tiled(np.asarray(self._base.lit_fraction)[self._epochs], self.shape))

    @kept
    def momentum_direction_icrf(self) -> FloatArray:
        """Unit vectors (3, N T) of the angular momenta, ICRF."""
        momentum = self._history.ensemble.momentum[self._history.member[:, 0]]
        with np.errstate(invalid="ignore"):
            unit = momentum / np.linalg.norm(momentum, axis=-1, keepdims=True)
        return unit.T.repeat(self.shape[1], axis=1)

    def _motion(self) -> Motion:
        raise AttitudeError(
            "this quantity needs the motion of a scene, and the members of an ensemble have one "
            "each; use another quantity."
        )

    def _body(self, what: str) -> Body:
        inertia = self._history.ensemble._inertia
        if len(inertia) > 1:
            raise AttitudeError(f"{what} differs between the members, which have bodies each.")
        found: Body = inertia.body(0)
        return found


def bound(
    scene: Scene, ensemble: Collection, seconds: FloatArray, low: FloatArray | None
) -> tuple[View, MemberGrid]:
    """The scene at epochs of reception (T,), and the grid of all members at those of emission.

    Parameters
    ----------
    scene : Scene
    ensemble : Ensemble
    seconds, low : (T,) arrays
        Since the `start_of_seconds` of the ensemble.
    """
    free = copy(scene)
    free._set("motion", None)
    shared = ensemble.epoch
    start = ensemble.start_of_seconds
    base = free.since(start, seconds, low)
    hi, lo = base.emission
    hi, lo = np.asarray(hi)[None], None if lo is None else np.asarray(lo)[None]
    if shared is None:
        own = ensemble.epochs_of(np.arange(len(ensemble)))
        past = pairs.add((hi, 0.0 if lo is None else lo), start.seconds, start.low)
        hi, lo = pairs.add(past, -own[0][:, None], -own[1][:, None])
    return base, MemberGrid(len(ensemble), hi, lo, False)
