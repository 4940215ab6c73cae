"""Attitudes of the members of an ensemble: whole answers and blocks of them."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, Any, cast

import numpy as np

from attitude import validation
from attitude.ensemble import epoch as instants
from attitude.ensemble import evaluate
from attitude.ensemble.answer import EnsembleHistory
from attitude.ensemble.collection import Collection
from attitude.ensemble.derivatives import MemberDerivatives
from attitude.ensemble.rows import MemberGrid, MemberRows
from attitude.errors import AttitudeError
from attitude.immutable import read_only
from attitude.sensitivities import columns

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from numpy.typing import ArrayLike

    from attitude.annotations import Epochs, FloatArray, IntArray
    from attitude.ensemble.ensemble import Ensemble


class Evaluated(Collection):
    """Base of `Ensemble`: attitudes at epochs."""

    def at(
        self,
        t: Epochs,
        member: ArrayLike | None = None,
        *,
        low: ArrayLike | None = None,
        angular_velocity: bool = False,
        threads: int = 1,
        out: FloatArray | None = None,
        rates_out: FloatArray | None = None,
    ) -> EnsembleHistory:
        """The attitudes of the members at some epochs.

        Parameters
        ----------
        t : (T,) or (N, T) array_like; with `member` of any shape S
            Seconds since the epoch of the member, or epochs, as for `FreeRotation.at`.  Arrays of
            float64 are not copied: leave them unchanged as long as the answer is in use.
        member : int, name, or array_like of shape S, optional
            The member of each epoch: numbers 0 to N - 1, or names.  Rows of one member that stand
            together are fastest; rows in another order take 0.1 us more each.
        low : array_like, optional
            With plain seconds: a second double; t + low are the seconds.
        angular_velocity : bool
            Compute `EnsembleHistory.angular_velocity` in the same pass.
        threads : int
            Number of threads; the bits of the answer do not depend on it.
        out, rates_out : float64 arrays (S, 4) and (S, 3), optional
            Filled with attitudes and angular velocities; S is (N, T) without `member`.  Arrays
            whose memory is component-major, (N, 4, T) or (4, *S), are filled in place.

        Returns
        -------
        EnsembleHistory
            Of shape (N, T), (N,) for a single epoch, or S.

        Raises
        ------
        AttitudeError
            For epochs that cannot be read or lie more than 5e16 turns away, shapes that do not fit,
            members out of range.
        """
        found = self._epochs(t, low, member)
        both = validation.flag(angular_velocity, "angular_velocity") or rates_out is not None
        outs = [(out, "out", 4), (rates_out, "rates_out", 3)][: 1 + both]
        return self._history(found, outs, threads)

    def sensitivity_at(
        self,
        t: Epochs,
        member: ArrayLike | None = None,
        *,
        low: ArrayLike | None = None,
        angular_velocity: bool = False,
        threads: int = 1,
        out: FloatArray | None = None,
        rates_out: FloatArray | None = None,
    ) -> FloatArray | tuple[FloatArray, FloatArray]:
        """The derivatives of attitudes by the states and the moments, in closed form.

        Parameters
        ----------
        t, member, low, threads
            As of `at`.  In parts of bounded memory: `history.sensitivity` of `blocks`.
        angular_velocity : bool
            Whether the derivatives of the angular velocity are returned too.
        out, rates_out : float64 arrays (S, 3, 9), optional
            Filled; as of `at`.

        Returns
        -------
        attitude : (S, 3, 9) array
            Rotation vector (rad, ICRF axes) of the change of attitude for a unit change of the
            attitude at the epoch (3, rotation vector, rad, ICRF axes), the angular velocity
            (3, rad/s, body axes) and the principal moments (3, in the unit of the member).
        omega : (S, 3, 9) array
            Of the angular velocity, body axes; only with `angular_velocity`.

        Raises
        ------
        AttitudeError
            As `at`, and for rods; with ``on_error="nan"`` their derivatives are NaN.

        Notes
        -----
        The bits and the accuracy of `FreeRotation.sensitivity_at`.
        """
        found = self._epochs(t, low, member)
        both = validation.flag(angular_velocity, "angular_velocity") or rates_out is not None
        outs = [(out, "out"), (rates_out, "rates_out")][: 1 + both]
        memory = [found.memory(*each, 3, columns.PARAMETERS) for each in outs]
        filled = memory[0], memory[1] if both else None
        changes = MemberDerivatives(self._members, self.label, self.on_error == "raise")
        if isinstance(found, MemberGrid):
            changes.grid(found.t, found.t_low, *filled, threads)
        else:
            evaluate.ragged(changes, *found.flat(), found.order, *filled, threads)
        views = [found.shaped(a, b[0]) for a, b in zip(memory, outs, strict=True)]
        return (views[0], views[1]) if both else views[0]

    def blocks(
        self,
        t: Epochs,
        member: ArrayLike | None = None,
        *,
        low: ArrayLike | None = None,
        rows: int = 1 << 18,
        angular_velocity: bool = False,
        threads: int = 1,
    ) -> Iterator[tuple[Any, EnsembleHistory]]:
        """The answer of `at` in parts of at most `rows` attitudes, made one after the other.

        Parameters
        ----------
        t, member, low, angular_velocity, threads
            As of `at`.
        rows : int
            An attitude takes 32 bytes, 56 with its rates.

        Yields
        ------
        place : slice, or pair of slices
            ``history.wxyz`` is ``at(t, member).wxyz[place]``.
        history : EnsembleHistory

        Raises
        ------
        AttitudeError
            As `at`.
        """
        found = self._epochs(t, low, member)
        both = validation.flag(angular_velocity, "angular_velocity")
        outs = [(None, "out", 4), (None, "rates_out", 3)][: 1 + both]
        parts = found.parts(validation.count(rows, "rows"))
        return ((place, self._history(part, outs, threads)) for place, part in parts)

    def _history(self, found: MemberGrid | MemberRows, outs: Any, threads: int) -> EnsembleHistory:
        """The history of some epochs, in the output arrays (out, name, width) if they are given."""
        memory = [found.memory(*each) for each in outs]
        self._fill_rows(found, memory[0], memory[1] if len(memory) > 1 else None, threads)
        views = [read_only(found.shaped(a, b[0])) for a, b in zip(memory, outs, strict=True)]
        whole = cast("Ensemble", self)
        history = EnsembleHistory(whole, found.member, found.seconds, found.low, views[0])
        if len(views) > 1:
            history.__dict__["angular_velocity"] = views[1]
        return history

    def evaluated(
        self, member: IntArray, seconds: FloatArray, low: FloatArray | None
    ) -> FloatArray:
        """Angular velocities (S, 3), rad/s in body axes, of members (S) at seconds + low (S)."""
        found = MemberRows(len(self), member, seconds, low)
        wxyz, rates = (np.empty((width, seconds.size)) for width in (4, 3))
        self._fill_rows(found, wxyz, rates, 1)
        return found.shaped(rates, None)

    def grid_of(self, t: Epochs, low: ArrayLike | None = None) -> MemberGrid:
        """The epochs of all members, given as for `at`; AttitudeError for a single epoch."""
        found = self._epochs(t, low, None)
        if not isinstance(found, MemberGrid) or found.scalar:
            raise AttitudeError("t is one epoch; give (T,) or (N, T).")
        return found

    def _epochs(self, t: Any, low: Any, member: ArrayLike | None) -> MemberGrid | MemberRows:
        """The epochs of all members, or of the rows of given ones."""
        if member is None:
            return MemberGrid(len(self), *instants.shared(self._start, t, low, len(self)))
        known, in_runs = self._members_of(member)
        seconds, lows, who = instants.of_rows(self._start, t, low, known)
        return MemberRows(len(self), who, seconds, lows, in_runs)

    def _fill_rows(
        self,
        found: MemberGrid | MemberRows,
        wxyz: FloatArray,
        rates: FloatArray | None,
        threads: int,
    ) -> None:
        """Fill component-major memory with attitudes and, unless it is None, rates."""
        raises = self.on_error == "raise"
        if isinstance(found, MemberGrid):
            members, label, epochs = self._members, self.label, (found.t, found.t_low)
            if found.count < len(members):
                members = members.taken(slice(found.first, found.first + found.count))
                label = partial(_shifted, self.label, found.first)
            evaluate.grid(members, label, *epochs, wxyz, rates, threads, raises)
        else:
            runs = evaluate.Runs(self._members, self.label, raises)
            evaluate.ragged(runs, *found.flat(), found.order, wxyz, rates, threads)

    def _members_of(self, member: ArrayLike) -> tuple[IntArray, bool]:
        """Numbers of members, of the shape given, and whether equal ones stand in long runs.

        AttitudeError for those out of range.
        """
        try:
            array = np.asarray(member)
        except ValueError as err:
            raise AttitudeError("member is ragged; give one number or name for each row.") from err
        if array.dtype.kind == "U" or (array.dtype == object and array.size):
            names = [self.number(each) for each in array.ravel().tolist()]
            array = np.array(names, dtype=np.int64).reshape(array.shape)
        if array.size == 0:
            return np.zeros(array.shape, dtype=np.int64), True
        if array.dtype.kind not in "iu":
            raise AttitudeError(
                f"member is {validation.shown(member)}; give whole numbers or names of members."
            )
        found: IntArray = np.asarray(array, dtype=np.int64, order="C")
        least, greatest, in_runs = evaluate.survey(found.reshape(-1))
        if least < 0 or greatest >= len(self):
            flat = found.reshape(-1)
            row = int(np.argmax((flat < 0) | (flat >= len(self))))
            raise AttitudeError(
                f"member {flat[row]} of row {row} is out of range: the ensemble has {len(self)} "
                f"members, 0 to {len(self) - 1}."
            )
        return found, in_runs


def _shifted(label: Callable[[int], str], first: int, k: int) -> str:
    """The name of member k of a part whose first member is `first`."""
    return label(first + k)
