"""Numbers that follow from attitudes of members, for percentiles and conditions."""

from __future__ import annotations

from collections.abc import Callable
from copy import copy
from typing import TYPE_CHECKING, Any

import numpy as np

from attitude._compilation.decorators import entry_point, subroutine
from attitude._compilation.instructions import as_bits
from attitude._solver.kernel import turned_by
from attitude._support import pairs, validation
from attitude._support.arrays import Immutable, frozen, read_only, units
from attitude.ensemble import _members
from attitude.ensemble._evaluation import MemberGrid
from attitude.errors import AttitudeError
from attitude.scene._light_time import LineOfSight
from attitude.scene._scene import Scene
from attitude.scene._view import View, kept, quantity

if TYPE_CHECKING:
    from attitude._support.annotations import FloatArray, Reals
    from attitude.motions._body import Body
    from attitude.motions._history import AttitudeHistory
    from attitude.motions._motion import Motion


# ---- A scene in which members of an ensemble take the place of its motion


class MemberView(View):
    """What is seen of N members at T epochs: a View of shape (N, T) whose lines are to the centre.

    base: the scene at all epochs.
    epochs: the epochs of the history among them.
    history: (N, T), attitudes of the members at the epochs of emission.
    """

    def __init__(self, base: View, epochs: slice, history: Any) -> None:
        self._base: View
        self._epochs: slice
        self._history: Any
        times = pairs.Seconds.of(base).taken(epochs)
        spread = times.mapped(lambda array: np.array(np.broadcast_to(array, history.shape)))
        super().__init__(base.scene, base.epoch, *spread)
        self._set_all(_base=base, _epochs=epochs, _history=history, attitude=history)

    def _line(self, name: str) -> LineOfSight:
        """A line of sight of the base, repeated for each member."""
        line: LineOfSight = getattr(self._base, name)
        count = self.shape[0]
        unit, distance = line.unit, line.distance
        if unit.shape[1] > 1:
            unit = np.tile(unit[:, self._epochs], count)
        if distance is not None:
            distance = np.tile(distance[self._epochs], count)
        return LineOfSight(unit.copy(), distance, line.source, line.error)

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
    def emission(self) -> pairs.Seconds:
        """TDB seconds from `epoch` at which the light leaves the body, hi + lo, flat."""
        count = self.shape[0]
        left = self._base.emission.taken(self._epochs)
        return left.mapped(lambda array: frozen(np.tile(array, count)))

    @quantity()
    def lit_fraction(self) -> FloatArray:
        """Fraction of the Sun's disc that the bodies of `scene.shadow_of` leave free, 0 to 1."""
        return np.array(
            np.broadcast_to(np.asarray(self._base.lit_fraction)[self._epochs], self.shape)
        )

    @kept
    def momentum_direction_icrf(self) -> FloatArray:
        """Unit vectors (3, N T) of the angular momenta, ICRF."""
        momentum = self._history.ensemble.momentum[self._history.member[:, 0]]
        with np.errstate(invalid="ignore"):
            unit = units(momentum)
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
        return inertia.body(0)


def bound(
    scene: Scene, ensemble: Any, seconds: FloatArray, low: FloatArray | None
) -> tuple[View, MemberGrid]:
    """The scene at epochs of reception (T,), and the grid of all members at those of emission."""
    free = copy(scene)
    free._set("motion", None)
    start = ensemble.start_of_seconds
    base = free.since(start, seconds, low)
    times = base.emission.taken(None)
    if ensemble.epoch is None:
        starts = ensemble.epochs_of(np.arange(len(ensemble)))
        past = times.plus(start.seconds, start.low)
        times = pairs.Seconds(*pairs.add(past, -starts[0][:, None], -starts[1][:, None]))
    return base, MemberGrid(len(ensemble), times, False)


# ---- The compiled loops of angles between a body axis and directions, and of order statistics

# Bins of leading bits, of which each holds few numbers of a row.
BINS = 4096


@entry_point
def squared_tangents(wxyz, axis, x, y, z, out):
    """Squares of tan(angle / 2) between a body axis and directions, for N members at T epochs.

    Into out (N, T): |a - b|^2 / |a + b|^2, which keeps all digits at 0 and at pi; wxyz (N, 4, T),
    body to ICRF; unit vectors axis (3,), body axes, and x, y, z (T,), ICRF.
    """
    a, b, c = axis[0], axis[1], axis[2]
    for n in range(len(out)):
        for k in range(out.shape[1]):
            q = wxyz[n, 0, k], wxyz[n, 1, k], wxyz[n, 2, k], wxyz[n, 3, k]
            u, v, w = turned_by(q, (a, b, c))
            apart = (u - x[k]) * (u - x[k]) + (v - y[k]) * (v - y[k]) + (w - z[k]) * (w - z[k])
            far = (u + x[k]) * (u + x[k]) + (v + y[k]) * (v + y[k]) + (w + z[k]) * (w + z[k])
            out[n, k] = apart / far


@entry_point
def candidates(values, ranks, counts, wanted, kept, places):
    """The count of numbers of a row among which those of given ranks are, by their leading bits.

    Given
        values  (N,) numbers, none of them NaN, N >= 1
        ranks   (R,) 0 to N - 1
        counts, wanted  (BINS,) memory
    Filled
        kept    (N,) numbers that share leading bits with one of the wanted ones, in any order
        places  (R,) the ranks among these
    """
    least = most = _key(values[0])
    for k in range(1, len(values)):
        key = _key(values[k])
        least, most = min(least, key), max(most, key)
    shift = 0
    while (most - least) >> shift >= len(counts):
        shift += 1
    counts[:] = 0
    wanted[:] = 0
    for k in range(len(values)):
        counts[(_key(values[k]) - least) >> shift] += 1
    for r in range(len(ranks)):
        bin_, before = 0, 0
        while before + counts[bin_] <= ranks[r]:
            before += counts[bin_]
            bin_ += 1
        wanted[bin_] = 1
    for r in range(len(ranks)):
        bin_, before, left_out = 0, 0, 0
        while before + counts[bin_] <= ranks[r]:
            before += counts[bin_]
            if wanted[bin_] == 0:
                left_out += counts[bin_]
            bin_ += 1
        places[r] = ranks[r] - left_out
    count = 0
    for k in range(len(values)):
        # Written always and kept if wanted: without a branch that is mispredicted.
        kept[count] = values[k]
        count += wanted[(_key(values[k]) - least) >> shift]
    return count


@subroutine
def _key(x):
    """A whole number that does not fall as a double grows; differences of two do not overflow."""
    bits = as_bits(x + 0.0)
    return (bits ^ ((bits >> 63) & 0x7FFFFFFFFFFFFFFF)) >> 1


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
        vectors = validation.real(target, "target")
        if vectors.ndim not in (1, 2) or vectors.shape[-1] != 3:
            raise AttitudeError(f"target has shape {vectors.shape}; give (3,) or (T, 3).")
        largest = np.max(np.abs(vectors), axis=-1, keepdims=True)
        if np.any(largest == 0.0):
            raise AttitudeError("target holds a zero vector, which has no direction.")
        self._set("_target", frozen(units(vectors / largest)))

    def measured(self, history: AttitudeHistory, epochs: slice) -> FloatArray:
        """Numbers (N, T) that grow with the angle, of a history at some epochs of all."""
        count, length = history.shape
        target = self._target
        if target.ndim == 2:
            target = target[epochs]
        parts = (
            read_only(np.ascontiguousarray(np.broadcast_to(target[..., k], length)))
            for k in range(3)
        )
        out = np.empty((count, length))
        squared_tangents(read_only(np.moveaxis(history.wxyz, -1, 1)), self._axis, *parts, out)
        return out

    def finished(self, measured: FloatArray) -> FloatArray:
        """Angles, rad, of numbers that `measured` has returned."""
        return 2.0 * np.arctan(np.sqrt(measured))


class Computed:
    """A quantity (N, T) that a function returns of an EnsembleHistory of that shape."""

    def __init__(self, function: Callable[[Any], Any]) -> None:
        self._function = function

    def measured(self, history: AttitudeHistory, epochs: slice) -> FloatArray:
        """The numbers (N, T)."""
        values = np.asarray(self._function(history), dtype=np.float64)
        if values.shape != history.shape:
            raise AttitudeError(
                f"the quantity has shape {values.shape} for a history of shape {history.shape}; "
                "return one number for each attitude."
            )
        return values

    def finished(self, measured: FloatArray) -> FloatArray:
        """The same numbers."""
        return measured


class Seen(Computed):
    """A quantity of a scene with one number an epoch, by its name, such as "aspect_angle".

    base: the scene at all epochs, without a motion.
    """

    def __init__(self, name: str, base: View) -> None:
        self._name, self._base = name, base

    def measured(self, history: AttitudeHistory, epochs: slice) -> FloatArray:
        """The numbers (N, T)."""
        view = MemberView(self._base, epochs, history)
        return np.asarray(getattr(view, self._name), dtype=np.float64)


def known(
    quantity: Any, scene: Any, ensemble: Any, t: Any, low: Any
) -> tuple[AngleTo | Computed, MemberGrid]:
    """The quantity that a caller gave, and the epochs at which the members are evaluated."""
    if isinstance(quantity, str):
        if not isinstance(scene, Scene):
            raise AttitudeError(
                f"the quantity {quantity!r} is one of a scene; give scene=, a Scene."
            )
        columns = View.columns()
        if quantity not in columns or columns[quantity].parts:
            names = ", ".join(name for name, column in columns.items() if not column.parts)
            raise AttitudeError(f"{quantity!r} is not a number of a view; give one of {names}.")
        seconds, lows = _members.received(ensemble.start_of_seconds, ensemble.epoch, t, low)
        base, grid = bound(scene, ensemble, seconds, lows)
        return Seen(quantity, base), grid
    if isinstance(quantity, AngleTo) or (callable(quantity) and not isinstance(quantity, type)):
        grid = ensemble.grid_of(t, low)
        if not isinstance(quantity, AngleTo):
            return Computed(quantity), grid
        target = quantity._target
        if target.ndim == 2 and len(target) != grid.length:
            raise AttitudeError(
                f"target has {len(target)} directions, and t {grid.length} epochs; give one "
                "direction, or one for each epoch."
            )
        return quantity, grid
    raise AttitudeError(
        f"quantity is {validation.shown(quantity)}; give the name of a quantity of a scene, an "
        "AngleTo(axis, target), or a function of an EnsembleHistory."
    )
