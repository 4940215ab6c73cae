"""Many states under the same instantaneous changes: impulses and changes of inertia."""

from __future__ import annotations

from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

import numpy as np

from attitude import epochs, validation
from attitude.arcs.arcs import Arcs
from attitude.arcs.changes import Change
from attitude.blocks import in_blocks
from attitude.ensemble.answer import EnsembleHistory
from attitude.ensemble.chains import Chains, Failed, are_alike
from attitude.errors import AttitudeError
from attitude.immutable import Immutable, read_only
from attitude.progress import ProgressBar

if TYPE_CHECKING:
    from collections.abc import Iterator

    from numpy.typing import ArrayLike

    from attitude.annotations import Epochs, FloatArray
    from attitude.ensemble.ensemble import Ensemble


class ArcsEnsemble(Immutable):
    """The rotations of N bodies with the same changes, each an `Arcs`.

    Parameters
    ----------
    ensemble : Ensemble
        States at one epoch.
    changes : Impulse, InertiaChange, or sequence of them
        As of `Arcs`; seconds count from the epoch of the ensemble.  Those at given epochs with
        given momenta are compiled over members, 0.1 ms a member and change; events and
        functions are resolved member by member.

    Raises
    ------
    AttitudeError
        For members with epochs of their own, and as `Arcs`, with the name of the member.

    Notes
    -----
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
        given = tuple(changes) if isinstance(changes, (list, tuple)) else (changes,)
        self._set("ensemble", ensemble)
        self._set("changes", given)
        for k, change in enumerate(given):
            if not isinstance(change, Change):
                raise AttitudeError(
                    f"changes[{k}] is {change!r}; give Impulse or InertiaChange objects."
                )
        self._set("_chains", None)
        if len(ensemble) and not are_alike(given):
            self._set("_singles", tuple(self._single(k) for k in range(len(ensemble))))
            return
        self._set("_singles", None)
        with self._named():
            self._set("_chains", Chains(ensemble, given))

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
        """Attitudes and angular velocities (N, T) of all members at epochs (T,).

        Raises
        ------
        AttitudeError
            As `Arcs.at`, with the name of the member.
        """
        hi, lo = epochs.seconds_since(self.ensemble.start_of_seconds, t, low)
        if hi.ndim != 1:
            raise AttitudeError(f"t is {validation.shown(t)}; give a row (T,) of epochs.")
        count, length = len(self), len(hi)
        wxyz, rates = np.empty((count, 4, length)), np.empty((count, 3, length))
        if self._chains is None:
            self._evaluate_singles(hi, lo, wxyz, rates, threads)
        else:
            try:
                self._chains.fill(hi, lo, wxyz, rates, threads)
            except Failed as failed:
                self._evaluate_singles(hi, lo, wxyz, rates, 1, only=failed.member)
        shape = count, length
        member = np.broadcast_to(np.arange(count)[:, None], shape)
        lows = None if lo is None else np.broadcast_to(lo, shape)
        spread = np.broadcast_to(hi.copy(), shape)
        history = EnsembleHistory(
            self.ensemble, member, spread, lows, read_only(np.moveaxis(wxyz, 1, 2))
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
