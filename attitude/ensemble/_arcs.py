"""Chains of free arcs of many states under the same impulses and changes of inertia."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from attitude._solver import evaluation
from attitude._solver.principal_axes import PrincipalAxes
from attitude._solver.records import CONSTANTS
from attitude._solver.states import BLOCK, Solved, States, compiled, reaches, symmetric_tensors
from attitude._support import pairs
from attitude._support.arrays import frozen, read_only
from attitude._support.blocks import ProgressBar, in_rectangles
from attitude._support.pairs import Seconds
from attitude.torques import _arcs
from attitude.torques._arcs import CarriedStates, Change
from attitude.torques._triggers import Trigger

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from attitude._support.annotations import FloatArray
    from attitude.ensemble._members import Inertia
    from attitude.epochs._instants import Instant


# ---- Chains of free arcs of the members of an ensemble that change alike, compiled over members


class Failed(Exception):
    """A member whose chain is not possible; its `Arcs` has the sentence."""

    def __init__(self, member: int) -> None:
        super().__init__(member)
        self.member = member


def are_alike(changes: Sequence[Change]) -> bool:
    """Whether changes have given times and momenta, so that those of all members are the same."""
    return all(
        not callable(change.angular_momentum) and not isinstance(change.at, Trigger)
        for change in changes
    )


class Chains:
    """The arcs of N members, states at `start`, between K `changes` for which `are_alike` holds.

    Failed for a member that no chain exists of; AttitudeError for times that are not in order.
    """

    def __init__(
        self, members: States, inertia: Inertia, start: Instant, changes: Sequence[Change]
    ) -> None:
        known_times = [time for time in _arcs.times_of(changes, start) if time is not None]
        self._starts = frozen(np.array([(0.0, 0.0), *known_times]))
        self._records = np.empty((len(members), len(self._starts)), dtype=CONSTANTS)
        for first in range(0, len(members), BLOCK):
            block = slice(first, min(first + BLOCK, len(members)))
            axes = _axes(inertia, block)
            try:
                self._records[block] = _records(members.taken(block), axes, changes, self._starts)
            except Failed as err:
                raise Failed(first + err.member) from None

    def fill(
        self,
        t: Seconds,
        wxyz: FloatArray,
        rates: FloatArray,
        threads: int,
    ) -> None:
        """Fill attitudes (N, 4, T) and rates (N, 3, T) at epochs (T,)."""
        with np.errstate(invalid="ignore", over="ignore"):
            sums = pairs.two_sum(t.hi, t.low)
        high, lows = (read_only(np.ascontiguousarray(total)) for total in sums)

        def work(rows: slice, epochs: tuple[int, int]) -> None:
            columns = slice(*epochs)
            failed = compiled().evaluate_members(
                read_only(self._records[rows]),
                self._starts,
                high[columns],
                lows[columns],
                wxyz[rows],
                rates[rows],
                epochs[0],
            )
            if failed >= 0:
                raise Failed(rows.start + failed)

        most = evaluation.EPOCHS
        bar = ProgressBar("attitudes")
        in_rectangles(work, len(wxyz), len(high), BLOCK, most, most, threads, bar)


def _records(
    members: States, axes: FloatArray, changes: Sequence[Change], starts: FloatArray
) -> NDArray[Any]:
    """Constants (B, K + 1) of the arcs of some members, with their axes (1 or B, 3, 3, 2)."""
    wxyz = np.zeros((len(members), 4, 2))
    wxyz[..., 0] = members.wxyz
    if members.low is not None:
        wxyz[..., 1] = members.low
    chain = CarriedStates(members, wxyz, axes)
    records = [_sound(chain.solved)]
    for change, start, end in zip(changes, starts[:-1], starts[1:], strict=True):
        length = np.array(pairs.add((end[0], end[1]), -start[0], -start[1]))
        beyond = np.abs(length[0]) > reaches(records[-1])
        if beyond.any():
            raise Failed(int(np.argmax(beyond)))
        chain.join(change, np.asarray(change.angular_momentum), length)
        records.append(_sound(chain.solved))
    return np.stack(records, axis=1)


def _sound(solved: Solved) -> NDArray[Any]:
    if len(solved.bad):
        raise Failed(int(solved.bad[0]))
    return solved.constants


def _axes(inertia: Inertia, members: slice) -> FloatArray:
    """The principal axes (1 or B, 3, 3, 2) of some members, in pairs of doubles."""
    if not inertia.has_tensors:
        axes = np.zeros((1, 3, 3, 2))
        axes[0, :, :, 0] = np.eye(3)
        return axes
    which = members if len(inertia) > 1 else slice(0, 1)
    if inertia.bodies is not None:
        return np.stack([body._axes for body in inertia.bodies[which]])
    return PrincipalAxes.of(symmetric_tensors(inertia.array[which])).axes
