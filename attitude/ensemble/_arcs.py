"""`ArcsEnsemble`: many states under the same impulses and changes of inertia."""

from __future__ import annotations

from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

import numpy as np

from attitude import frames
from attitude._solver import evaluation
from attitude._solver.principal_axes import PrincipalAxes
from attitude._solver.records import CONSTANTS
from attitude._solver.states import BLOCK, Solved, States, compiled, reaches, symmetric_tensors
from attitude._support import pairs, validation
from attitude._support.arrays import Immutable, frozen, read_only
from attitude._support.blocks import ProgressBar, in_blocks, in_rectangles
from attitude._support.pairs import Seconds
from attitude.ensemble._evaluation import EnsembleHistory
from attitude.epochs import _inputs
from attitude.errors import AttitudeError
from attitude.torques import _arcs
from attitude.torques._arcs import Arcs, Change, InertiaChange
from attitude.torques._triggers import Trigger

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from numpy.typing import ArrayLike, NDArray

    from attitude._support.annotations import Epochs, FloatArray
    from attitude.ensemble._ensemble import Ensemble


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
    """The arcs of N members between K changes at given epochs.

    ensemble: of one epoch.
    changes: for which `are_alike` holds.
    Failed for a member that no chain exists of.
    AttitudeError for times that are not in order.
    """

    def __init__(self, ensemble: Ensemble, changes: Sequence[Change]) -> None:
        times = _arcs.times_of(changes, ensemble.start_of_seconds)
        known_times = [time for time in times if time is not None]
        self._starts = frozen(np.array([(0.0, 0.0), *known_times]))
        self._records = np.empty((len(ensemble), len(self._starts)), dtype=CONSTANTS)
        for first in range(0, len(ensemble), BLOCK):
            block = slice(first, min(first + BLOCK, len(ensemble)))
            try:
                self._records[block] = _records(ensemble, block, changes, self._starts)
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

        def work(part: slice, epochs: tuple[int, int]) -> None:
            columns = slice(*epochs)
            out = wxyz[part], rates[part], epochs[0]
            failed = compiled().evaluate_members(
                read_only(self._records[part]), self._starts, high[columns], lows[columns], *out
            )
            if failed >= 0:
                raise Failed(part.start + failed)

        most = evaluation.EPOCHS
        bar = ProgressBar("attitudes")
        in_rectangles(work, len(wxyz), len(high), BLOCK, most, most, threads, bar)


def _records(
    ensemble: Ensemble, part: slice, changes: Sequence[Change], starts: FloatArray
) -> NDArray[Any]:
    """Constants (B, K + 1) of the arcs of some members."""
    members = ensemble._members.taken(part)
    solved = members.solved()
    moments, w, wxyz = solved.moments, solved.omega.copy(), solved.wxyz
    principal, axes = np.array(members.principal, order="C"), _axes(ensemble, part)
    q = np.zeros((len(wxyz), 4, 2))
    q[..., 0] = wxyz
    if members.low is not None:
        q[..., 1] = members.low
    records = [_sound(solved)]
    for change, start, end in zip(changes, starts[:-1], starts[1:], strict=True):
        length = np.array(pairs.add((end[0], end[1]), -start[0], -start[1]))
        beyond = np.abs(length[0]) > reaches(records[-1])
        if beyond.any():
            raise Failed(int(np.argmax(beyond)))
        in_body, in_space = np.zeros(3), np.zeros((3, 2))
        added = np.asarray(change.angular_momentum)
        if change.frame == "body":
            in_body[:] = added
        else:
            in_space[:] = frames.vector_to_icrf(change.frame, added)
        arrays = read_only(moments), read_only(axes), read_only(principal)
        compiled().join_members(records[-1], *arrays, length, q, w, in_body, in_space)
        if isinstance(change, InertiaChange):
            body = change.body
            new = body.moments_as_pairs, body._axes
            compiled().exchange_members(arrays[0], arrays[1], *new, w)
            moments = np.repeat(new[0][None], len(w), axis=0)
            axes, principal = new[1][None], np.array(body.principal_wxyz)[None]
        states = States(moments, principal, w.copy(), None, q[..., 0].copy())
        records.append(_sound(states.solved()))
    return np.stack(records, axis=1)


def _sound(solved: Solved) -> NDArray[Any]:
    if len(solved.bad):
        raise Failed(int(solved.bad[0]))
    return solved.constants


def _axes(ensemble: Ensemble, part: slice) -> FloatArray:
    """The principal axes (1 or B, 3, 3, 2) of some members, in pairs of doubles."""
    inertia = ensemble._inertia
    if not inertia.has_tensors:
        axes = np.zeros((1, 3, 3, 2))
        axes[0, :, :, 0] = np.eye(3)
        return axes
    which = part if len(inertia) > 1 else slice(0, 1)
    if inertia.bodies is not None:
        return np.stack([body._axes for body in inertia.bodies[which]])
    return PrincipalAxes.of(symmetric_tensors(inertia.given[which])).axes


class ArcsEnsemble(Immutable):
    """The rotations of N bodies with the same changes, each an `Arcs`.

    ensemble: states at one epoch.
    changes: as in `Arcs`; seconds count from the epoch of the ensemble.  Those at given epochs with
        given momenta are compiled over members, 0.1 ms a member and change; events and functions
        are resolved member by member.
    AttitudeError for members with epochs of their own, and as `Arcs`, with the name of the member.

    Attitudes have the bits of `Arcs.at`.
    """

    ensemble: Ensemble
    changes: tuple[Change, ...]
    _chains: Chains | None
    _singles: tuple[Arcs, ...] | None

    def __init__(self, ensemble: Ensemble, changes: Any) -> None:
        if ensemble.epoch is None:
            raise AttitudeError(
                "the members have epochs of their own; changes need one epoch for all members."
            )
        changes_given = tuple(changes) if isinstance(changes, (list, tuple)) else (changes,)
        self._set("ensemble", ensemble)
        self._set("changes", changes_given)
        for k, change in enumerate(changes_given):
            if not isinstance(change, Change):
                raise AttitudeError(
                    f"changes[{k}] is {change!r}; give Impulse or InertiaChange objects."
                )
        self._set("_chains", None)
        if len(ensemble) and not are_alike(changes_given):
            self._set("_singles", tuple(self._single(k) for k in range(len(ensemble))))
            return
        self._set("_singles", None)
        with self._named():
            self._set("_chains", Chains(ensemble, changes_given))

    def _single(self, k: int) -> Arcs:
        """The motion of member k; its errors have the name of the member."""
        try:
            motion = self.ensemble[k]
            return Arcs(motion.body, motion.spin, self.changes)
        except AttitudeError as err:
            raise AttitudeError(f"{self.ensemble.label(k)}: {err}") from None

    @contextmanager
    def _named(self) -> Iterator[None]:
        """Raise the error of the single motion of a member that failed."""
        try:
            yield
        except Failed as failed:
            self._single(failed.member)
            raise AttitudeError(
                f"{self.ensemble.label(failed.member)}: an epoch lies beyond its reach."
            ) from None

    def __len__(self) -> int:
        return len(self.ensemble)

    def __getitem__(self, k: int | str) -> Arcs:
        """The motion of one member, of a number or a name."""
        number = self.ensemble.number(k)
        return self._single(number) if self._singles is None else self._singles[number]

    def __repr__(self) -> str:
        return f"<ArcsEnsemble of {len(self)} members>"

    def at(self, t: Epochs, low: ArrayLike | None = None, *, threads: int = 1) -> EnsembleHistory:
        """Attitudes and angular velocities (N, T) of all members at epochs (T,)."""
        hi, lo = _inputs.seconds_since(self.ensemble.start_of_seconds, t, low)
        if hi.ndim != 1:
            raise AttitudeError(f"t is {validation.shown(t)}; give a row (T,) of epochs.")
        count, length = len(self), len(hi)
        wxyz, rates = np.empty((count, 4, length)), np.empty((count, 3, length))
        if self._chains is None:
            self._evaluate_singles(hi, lo, wxyz, rates, threads)
        else:
            try:
                self._chains.fill(Seconds(hi, lo), wxyz, rates, threads)
            except Failed as failed:
                self._evaluate_singles(hi, lo, wxyz, rates, 1, only=failed.member)
        shape = count, length
        member = np.broadcast_to(np.arange(count)[:, None], shape)
        spread = Seconds(hi.copy(), lo).mapped(lambda array: np.broadcast_to(array, shape))
        history = EnsembleHistory(
            self.ensemble, member, *spread, read_only(np.moveaxis(wxyz, 1, 2))
        )
        history.__dict__["angular_velocity"] = read_only(np.moveaxis(rates, 1, 2))
        return history

    def _evaluate_singles(
        self,
        hi: FloatArray,
        lo: FloatArray | None,
        wxyz: FloatArray,
        rates: FloatArray,
        threads: int,
        only: int | None = None,
    ) -> None:
        """Fill attitudes and rates of members one by one; errors have the name of the member."""

        def work(begin: int, end: int) -> None:
            for k in range(begin, end):
                try:
                    history = self[k].at(hi, lo)
                    wxyz[k], rates[k] = history.wxyz.T, history.angular_velocity.T
                except AttitudeError as err:
                    raise AttitudeError(f"{self.ensemble.label(k)}: {err}") from None

        if only is not None:
            work(only, only + 1)
        else:
            in_blocks(work, len(self), 64, threads, ProgressBar("chains of arcs"))
