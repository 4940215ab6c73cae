"""Chains of free arcs of the members of an ensemble that change alike, compiled over members."""

from __future__ import annotations

from functools import cache
from typing import TYPE_CHECKING, Any

import numpy as np

from attitude import evaluation, frames, pairs
from attitude.arcs import joint_times
from attitude.arcs.changes import InertiaChange
from attitude.arcs.triggers import Trigger
from attitude.batches import symmetric_tensors
from attitude.blocks import in_rectangles
from attitude.compilation.deferral import uncollected
from attitude.ensemble import evaluate
from attitude.ensemble.members import BLOCK
from attitude.immutable import frozen, read_only
from attitude.progress import ProgressBar
from attitude.solution.principal import PrincipalAxes
from attitude.solution.record import CONSTANTS

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from attitude.annotations import FloatArray
    from attitude.arcs.changes import Change
    from attitude.ensemble.ensemble import Ensemble


class Failed(Exception):
    """A member whose chain is not possible; its `Arcs` has the sentence."""

    def __init__(self, member: int) -> None:
        super().__init__(member)
        self.member = member


def are_alike(changes: Sequence[Change]) -> bool:
    """Whether changes have given times and momenta, so that those of all members are the same."""
    return all(
        not callable(each.angular_momentum) and not isinstance(each.at, Trigger) for each in changes
    )


class Chains:
    """The arcs of N members between K changes at given epochs.

    Parameters
    ----------
    ensemble : Ensemble
        Of one epoch.
    changes : sequence of Change
        For which `are_alike` holds.

    Raises
    ------
    Failed
        For a member that no chain exists of.
    AttitudeError
        For times that are not in order.
    """

    def __init__(self, ensemble: Ensemble, changes: Sequence[Change]) -> None:
        times = joint_times.given(changes, ensemble.start_of_seconds)
        found = [time for time in times if time is not None]
        self._starts = frozen(np.array([(0.0, 0.0), *found]))
        self._records = np.empty((len(ensemble), len(self._starts)), dtype=CONSTANTS)
        for first in range(0, len(ensemble), BLOCK):
            part = slice(first, min(first + BLOCK, len(ensemble)))
            try:
                self._records[part] = _records(ensemble, part, changes, self._starts)
            except Failed as err:
                raise Failed(first + err.member) from None

    def fill(
        self,
        t: FloatArray,
        low: FloatArray | None,
        wxyz: FloatArray,
        rates: FloatArray,
        threads: int,
    ) -> None:
        """Fill attitudes (N, 4, T) and rates (N, 3, T) at seconds t + low (T,).

        Raises
        ------
        Failed
            For a member with an epoch beyond its reach.
        """
        low = np.zeros(t.size) if low is None else low
        with np.errstate(invalid="ignore", over="ignore"):
            high, rest = (read_only(np.ascontiguousarray(each)) for each in pairs.two_sum(t, low))

        def work(part: slice, epochs: tuple[int, int]) -> None:
            here = slice(*epochs)
            out = wxyz[part], rates[part], epochs[0]
            failed = _compiled().evaluate_members(
                read_only(self._records[part]), self._starts, high[here], rest[here], *out
            )
            if failed >= 0:
                raise Failed(part.start + failed)

        most = evaluation.EPOCHS
        bar = ProgressBar("attitudes")
        in_rectangles(work, len(wxyz), t.size, BLOCK, most, most, threads, bar)


def _records(
    ensemble: Ensemble, part: slice, changes: Sequence[Change], starts: FloatArray
) -> NDArray[Any]:
    """Constants (B, K + 1) of the arcs of some members."""
    members = ensemble._members.taken(part)
    moments, wxyz, w = members.states(slice(None))
    principal, axes = np.array(members.principal, order="C"), _axes(ensemble, part)
    q = np.zeros((len(wxyz), 4, 2))
    q[..., 0] = wxyz
    if members.low is not None:
        q[..., 1] = members.low
    w = w.copy()
    found = [_sound(*members.prepared(slice(None)))]
    for change, start, end in zip(changes, starts[:-1], starts[1:], strict=True):
        length = np.array(pairs.add((end[0], end[1]), -start[0], -start[1]))
        beyond = np.abs(length[0]) > evaluate.reaches(found[-1])
        if beyond.any():
            raise Failed(int(np.argmax(beyond)))
        in_body, in_space = np.zeros(3), np.zeros((3, 2))
        added = np.asarray(change.angular_momentum)
        if change.frame == "body":
            in_body[:] = added
        else:
            in_space[:] = frames.vector_to_icrf(change.frame, added)
        given = read_only(moments), read_only(axes), read_only(principal)
        _compiled().join_members(found[-1], *given, length, q, w, in_body, in_space)
        if isinstance(change, InertiaChange):
            body = change.body
            new = body.moments_as_pairs, body._axes
            _compiled().exchange_members(given[0], given[1], *new, w)
            moments = np.repeat(new[0][None], len(w), axis=0)
            axes, principal = new[1][None], np.array(body.principal_wxyz)[None]
        state = moments, q[..., 0].copy(), w.copy(), principal
        constants, faults = evaluation.prepared(*state)
        found.append(_sound(constants, np.flatnonzero(constants["fault"]) if faults else ()))
    return np.stack(found, axis=1)


def _sound(constants: NDArray[Any], bad: Any) -> NDArray[Any]:
    if len(bad):
        raise Failed(int(bad[0]))
    return constants


def _axes(ensemble: Ensemble, part: slice) -> FloatArray:
    """The principal axes (1 or B, 3, 3, 2) of some members, in pairs of doubles."""
    inertia = ensemble._inertia
    if not inertia.has_tensors:
        axes = np.zeros((1, 3, 3, 2))
        axes[0, :, :, 0] = np.eye(3)
        return axes
    which = part if len(inertia) > 1 else slice(0, 1)
    if inertia.bodies is not None:
        return np.stack([each._axes for each in inertia.bodies[which]])
    return PrincipalAxes.of(symmetric_tensors(inertia.given[which])).axes


@cache
def _compiled() -> Any:
    """The module of compiled loops over members."""
    with uncollected():
        from attitude.solution import chain_members
    return chain_members
