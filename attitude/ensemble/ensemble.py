"""Many freely rotating bodies, each evaluated at epochs of its own or at shared ones."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from attitude import validation
from attitude.ensemble import epoch as instants
from attitude.ensemble import evaluate
from attitude.ensemble.answer import EnsembleHistory
from attitude.ensemble.described import Described
from attitude.ensemble.rows import MemberGrid, MemberRows
from attitude.ensemble.sources import Sourced
from attitude.errors import AttitudeError
from attitude.immutable import read_only
from attitude.propagation import result_memory

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from attitude.annotations import Epochs, FloatArray, IntArray


class Ensemble(Sourced, Described):
    """The free rotations of N bodies, as arrays.

    Parameters
    ----------
    body : Body, or N of them
        Or moments=, or tensors=.
    wxyz : (4,) or (N, 4) array_like
        Quaternions from body axes to `frame`, scalar first; of any length.
    angular_velocity : (3,) or (N, 3) array_like
        rad/s over the body axes, or a Quantity.
    epoch : one epoch, or N
        As for `Spin`: ISO text in UTC, astropy or skyfield Time, datetime, datetime64.
    frame : str
        As for `Spin`.
    names : N of str, optional
        Names of the members, which differ from each other.
    moments : (3,) or (N, 3) array_like
        Principal moments about the body axes, kg m2.
    tensors : (3, 3) or (N, 3, 3) array_like
        Inertia tensors in body axes, kg m2; their doubles are taken as exact, as by `Body`.
    relative : bool
        True if the unit of moments or tensors is unknown.
    on_error : "raise" or "nan"
        "nan" keeps members with a state that no body has: their attitudes, periods and brightness
        are NaN, their mode is -1; and epochs beyond the reach of a member give NaN.

    Attributes
    ----------
    wxyz : (N, 4) array
        As given.
    angular_velocity : (N, 3) array
        rad/s over the body axes.
    names : (N,) array of str, or None
    frame, on_error : str

    Raises
    ------
    AttitudeError
        For members that are not physical, the first of which is named; arrays of different
        lengths; names given twice.

    Notes
    -----
    Attitudes have the bits of `FreeRotation.at`, whatever the ensemble, the order of rows and the
    number of threads.  Constants of a member are computed anew in each call, in 1.1 us, and are
    not kept.  benchmarks/ensembles.py measures the cost.

    >>> tops = Ensemble(
    ...     moments=[(10, 20, 26), (1, 2, 2.5)], wxyz=(1, 0, 0, 0),
    ...     angular_velocity=[(1, 15, 1), (0.2, 0.1, 0)], epoch="2026-01-01",
    ... )
    >>> tops.at([0.0, 30.0, 60.0]).wxyz.shape
    (2, 3, 4)
    >>> tops.at([60.0, 5.0, 6.0], member=[0, 1, 1]).wxyz[0].round(6)
    array([ 0.006059,  0.14546 , -0.019617,  0.989151])
    >>> tops[0].mode.name, tops.period_psi.round(6)
    ('SHORT_AXIS', array([ 2.347113, 55.168519]))
    """

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
        given = None if member is None else self._members_of(member)
        found = self._epochs(t, low, given)
        both = validation.flag(angular_velocity, "angular_velocity") or rates_out is not None
        outs = [(out, "out", 4), (rates_out, "rates_out", 3)][: 1 + both]
        memory = [result_memory(each, name, *found.layout(width)) for each, name, width in outs]
        self._fill_rows(found, memory[0], memory[1] if both else None, threads)
        views = [read_only(found.shaped(a, b[0])) for a, b in zip(memory, outs, strict=True)]
        history = EnsembleHistory(self, found.member, found.seconds, found.low, views[0])
        if both:
            history.__dict__["angular_velocity"] = views[1]
        return history

    def evaluated(
        self, member: IntArray, seconds: FloatArray, low: FloatArray | None
    ) -> FloatArray:
        """Angular velocities (S, 3), rad/s in body axes, of members (S) at seconds + low (S)."""
        found = MemberRows(member, seconds, low)
        wxyz, rates = (np.empty((width, seconds.size)) for width in (4, 3))
        self._fill_rows(found, wxyz, rates, 1)
        return found.shaped(rates, None)

    def _epochs(self, t: Any, low: Any, member: IntArray | None) -> MemberGrid | MemberRows:
        """The epochs of all members, or of the rows of given ones."""
        if member is None:
            return MemberGrid(len(self), *instants.shared(self._start, t, low, len(self)))
        seconds, lows, who = instants.of_rows(self._start, t, low, member)
        return MemberRows(who, seconds, lows)

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
            epochs = found.t, found.t_low
            evaluate.grid(self._members, self.label, *epochs, wxyz, rates, threads, raises)
        else:
            rows = found.flat()
            evaluate.ragged(self._members, self.label, *rows, wxyz, rates, threads, raises)

    def _members_of(self, member: ArrayLike) -> IntArray:
        """Numbers of members, of the shape given; AttitudeError for those out of range."""
        try:
            array = np.asarray(member)
        except ValueError as err:
            raise AttitudeError("member is ragged; give one number or name for each row.") from err
        if array.dtype.kind == "U" or (array.dtype == object and array.size):
            names = [self.number(each) for each in array.ravel().tolist()]
            return np.array(names, dtype=np.int64).reshape(array.shape)
        if array.size == 0:
            return np.zeros(array.shape, dtype=np.int64)
        if array.dtype.kind not in "iu":
            raise AttitudeError(
                f"member is {validation.shown(member)}; give whole numbers or names of members."
            )
        found: IntArray = np.ascontiguousarray(array, dtype=np.int64)
        least, greatest = evaluate.survey(found.reshape(-1))[:2]
        if least < 0 or greatest >= len(self):
            flat = found.reshape(-1)
            row = int(np.argmax((flat < 0) | (flat >= len(self))))
            raise AttitudeError(
                f"member {flat[row]} of row {row} is out of range: the ensemble has {len(self)} "
                f"members, 0 to {len(self) - 1}."
            )
        return found
