"""Many states under the same instantaneous changes: impulses and changes of inertia."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from attitude import epochs, validation
from attitude.arcs.arcs import Arcs
from attitude.blocks import in_blocks
from attitude.ensemble.answer import EnsembleHistory
from attitude.errors import AttitudeError
from attitude.immutable import Immutable, frozen

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from attitude.annotations import Epochs
    from attitude.ensemble.ensemble import Ensemble


class ArcsEnsemble(Immutable):
    """The rotations of N bodies with the same changes, each an `Arcs`.

    Parameters
    ----------
    ensemble : Ensemble
        States at one epoch.
    changes : Impulse, InertiaChange, or sequence of them
        As of `Arcs`; seconds count from the epoch of the ensemble.

    Raises
    ------
    AttitudeError
        For members with epochs of their own, and as `Arcs`, with the name of the member.
    """

    ensemble: Ensemble
    motions: tuple[Arcs, ...]

    def __init__(self, ensemble: Ensemble, changes: Any) -> None:
        if ensemble.epoch is None:
            raise AttitudeError(
                "the members have epochs of their own; changes need one epoch for all members."
            )
        given = tuple(changes) if isinstance(changes, (list, tuple)) else (changes,)
        found = []
        for k in range(len(ensemble)):
            motion = ensemble[k]
            try:
                found.append(Arcs(motion.body, motion.spin, given))
            except AttitudeError as err:
                raise AttitudeError(f"{ensemble.label(k)}: {err}") from err
        self._set("ensemble", ensemble)
        self._set("motions", tuple(found))

    def __len__(self) -> int:
        return len(self.motions)

    def __getitem__(self, k: int | str) -> Arcs:
        """The motion of one member, of a number or a name."""
        return self.motions[self.ensemble.number(k)]

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
        shape = len(self), len(hi)
        wxyz, rates = np.empty((*shape, 4)), np.empty((*shape, 3))

        def work(begin: int, end: int) -> None:
            for k in range(begin, end):
                try:
                    history = self.motions[k].at(hi, lo)
                    wxyz[k], rates[k] = history.wxyz, history.angular_velocity
                except AttitudeError as err:
                    raise AttitudeError(f"{self.ensemble.label(k)}: {err}") from err

        in_blocks(work, len(self), 64, threads)
        member = np.broadcast_to(np.arange(len(self))[:, None], shape)
        lows = None if lo is None else np.broadcast_to(lo, shape)
        spread = np.broadcast_to(hi.copy(), shape)
        history = EnsembleHistory(self.ensemble, member, spread, lows, wxyz)
        history.__dict__["angular_velocity"] = frozen(rates)
        return history
