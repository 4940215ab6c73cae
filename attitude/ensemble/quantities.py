"""Numbers that follow from the attitudes of members at epochs, for percentiles and conditions."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np

from attitude import validation
from attitude.ensemble import epoch as instants
from attitude.ensemble.views import MemberView, bound
from attitude.errors import AttitudeError
from attitude.immutable import Immutable, frozen, read_only
from attitude.scene.scene import Scene
from attitude.scene.view import View

if TYPE_CHECKING:
    from attitude.annotations import FloatArray, Reals
    from attitude.ensemble.answer import EnsembleHistory
    from attitude.ensemble.collection import Collection
    from attitude.ensemble.rows import MemberGrid


class AngleTo(Immutable):
    """The angle between a body axis and directions in ICRF, rad.

    Parameters
    ----------
    axis : (3,) array_like
        In body axes, of any length above zero.
    target : (3,) or (T, 3) array_like
        In ICRF, of any length above zero: one direction, or one for each epoch.

    Raises
    ------
    AttitudeError
        For other shapes, and vectors without a direction.
    """

    def __init__(self, axis: Reals, target: Reals) -> None:
        self._axis: FloatArray
        self._target: FloatArray
        self._set("_axis", frozen(validation.unit_vector(axis, "axis")))
        given = validation.real(target, "target")
        if given.ndim not in (1, 2) or given.shape[-1] != 3:
            raise AttitudeError(f"target has shape {given.shape}; give (3,) or (T, 3).")
        largest = np.max(np.abs(given), axis=-1, keepdims=True)
        if np.any(largest == 0.0):
            raise AttitudeError("target holds a zero vector, which has no direction.")
        given = given / largest
        self._set("_target", frozen(given / np.linalg.norm(given, axis=-1, keepdims=True)))

    def measured(self, history: EnsembleHistory, epochs: slice) -> FloatArray:
        """Numbers (N, T) that grow with the angle, of a history at some epochs of all."""
        from attitude.ensemble.quantity_loops import squared_tangents

        count, length = history.shape
        target = self._target
        if target.ndim == 2:
            if epochs.stop > len(target):
                raise AttitudeError(
                    f"target has {len(target)} directions; give one, or one for each epoch."
                )
            target = target[epochs]
        parts = (
            read_only(np.ascontiguousarray(np.broadcast_to(target[..., k], length)))
            for k in range(3)
        )
        out = np.empty((count, length))
        wxyz = read_only(np.moveaxis(history.wxyz, -1, 1))
        squared_tangents(wxyz, self._axis, *parts, out)
        return out

    def finished(self, measured: FloatArray) -> FloatArray:
        """Angles, rad, of numbers that `measured` has returned."""
        return 2.0 * np.arctan(np.sqrt(measured))


class Computed:
    """A quantity that a function of an EnsembleHistory returns.

    Parameters
    ----------
    function : callable
        Returns an array (N, T) for a history of that shape.
    """

    def __init__(self, function: Callable[[EnsembleHistory], Any]) -> None:
        self._function = function

    def measured(self, history: EnsembleHistory, epochs: slice) -> FloatArray:
        """The numbers (N, T)."""
        found = np.asarray(self._function(history), dtype=np.float64)
        if found.shape != history.shape:
            raise AttitudeError(
                f"the quantity has shape {found.shape} for a history of shape {history.shape}; "
                "return one number for each attitude."
            )
        return found

    def finished(self, measured: FloatArray) -> FloatArray:
        """The same numbers."""
        return measured


class Seen:
    """A quantity of a scene by its name, such as "magnitude" or "aspect_angle".

    Parameters
    ----------
    name : str
        A quantity of `attitude.scene.View` with one number for each epoch.
    base : View
        The scene at all epochs, without a motion.
    """

    def __init__(self, name: str, base: View) -> None:
        self._name, self._base = name, base

    def measured(self, history: EnsembleHistory, epochs: slice) -> FloatArray:
        """The numbers (N, T)."""
        view = MemberView(self._base, epochs, history)
        return np.asarray(getattr(view, self._name), dtype=np.float64)

    def finished(self, measured: FloatArray) -> FloatArray:
        """The same numbers."""
        return measured


def known(
    quantity: Any, scene: Any, ensemble: Collection, t: Any, low: Any
) -> tuple[AngleTo | Computed | Seen, MemberGrid]:
    """The quantity that a caller gave, and the epochs at which the members are evaluated.

    Parameters
    ----------
    quantity : str, AngleTo or callable
        A str is the name of a quantity of `scene`.
    scene : Scene or None
    ensemble : Ensemble
    t, low
        Epochs of all members, as of `Ensemble.at`; of a scene, at which light is received.

    Raises
    ------
    AttitudeError
        For anything else, a name without a scene, and a quantity of several numbers.
    """
    if isinstance(quantity, str):
        if not isinstance(scene, Scene):
            raise AttitudeError(
                f"the quantity {quantity!r} is one of a scene; give scene=, a Scene."
            )
        columns = View.columns()
        if quantity not in columns or columns[quantity].parts:
            names = ", ".join(name for name, each in columns.items() if not each.parts)
            raise AttitudeError(f"{quantity!r} is not a number of a view; give one of {names}.")
        seconds, lows = instants.received(ensemble.start_of_seconds, ensemble.epoch, t, low)
        base, grid = bound(scene, ensemble, seconds, lows)
        return Seen(quantity, base), grid
    if isinstance(quantity, AngleTo) or (callable(quantity) and not isinstance(quantity, type)):
        given = quantity if isinstance(quantity, AngleTo) else Computed(quantity)
        return given, ensemble.grid_of(t, low)
    raise AttitudeError(
        f"quantity is {validation.shown(quantity)}; give the name of a quantity of a scene, an "
        "AngleTo(axis, target), or a function of an EnsembleHistory."
    )
