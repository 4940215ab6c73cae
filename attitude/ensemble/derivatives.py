"""Derivatives of the attitudes of members of an ensemble at epochs."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from attitude.blocks import in_rectangles
from attitude.ensemble import evaluate
from attitude.ensemble.members import BLOCK
from attitude.errors import AttitudeError
from attitude.immutable import read_only
from attitude.progress import ProgressBar
from attitude.sensitivities import columns

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from attitude.annotations import FloatArray, IntArray
    from attitude.ensemble.members import Members

# Rows in a piece of work: some milliseconds.
_ROWS = 1 << 15


class MemberDerivatives:
    """Derivatives of members: of rows of which those of one member stand together, and of grids.

    Parameters
    ----------
    members : Members
    label : callable
        Name of a member in error messages.
    raises : bool
        Whether members without derivatives and epochs beyond the reach of a member are refused;
        otherwise they give NaN.
    """

    def __init__(self, members: Members, label: Callable[[int], str], raises: bool) -> None:
        self._members, self._label, self._raises = members, label, raises
        self._runs = evaluate.Runs(members, label, raises)

    def __call__(
        self,
        member: IntArray,
        begin: int,
        end: int,
        t: FloatArray,
        low: FloatArray | None,
        attitude: FloatArray,
        omega: FloatArray | None,
    ) -> None:
        """Fill the rows from `begin` to `end`.

        Parameters
        ----------
        member, t, low : (R,) arrays
            As of `evaluate.ragged`.
        begin, end : int
        attitude : (3, 9, R) array
            Filled: rotation vectors of the changes of attitude, rad over ICRF axes.
        omega : (3, 9, R) array or None
            Filled: changes of the angular velocity, rad/s over the body axes.
        """
        who, starts = self._runs.runs(member, begin, end)
        for first in range(0, len(who), BLOCK):
            some = who[first : first + BLOCK]
            edges = starts[first : first + len(some) + 1]
            times = t[None], None if low is None else low[None]
            out = attitude[None], None if omega is None else omega[None]
            self._fill(some, *times, *out, edges)

    def grid(
        self,
        t: FloatArray,
        low: FloatArray | None,
        attitude: FloatArray,
        omega: FloatArray | None,
        threads: int,
    ) -> None:
        """Fill the derivatives of N members at T epochs each.

        Parameters
        ----------
        t, low : (1 or N, T) arrays
            The epochs t + low, s; low may be None.
        attitude, omega : (N, 3, 9, T) arrays
            As in `__call__`.
        threads : int
        """

        def work(part: slice, epochs: tuple[int, int]) -> None:
            here = part if len(t) > 1 else slice(None)
            times = t[here], None if low is None else low[here]
            out = attitude[part], None if omega is None else omega[part]
            self._fill(np.arange(part.start, part.stop), *times, *out, None)

        length = t.shape[1]
        if length:
            bar = ProgressBar("derivatives")
            in_rectangles(work, len(attitude), length, BLOCK, length, _ROWS, threads, bar)

    def _fill(
        self,
        who: IntArray,
        t: FloatArray,
        low: FloatArray | None,
        attitude: FloatArray,
        omega: FloatArray | None,
        edges: IntArray | None,
    ) -> None:
        """Fill the derivatives of a few members `who`; `edges` as of `columns.evaluate`."""
        which = evaluate.consecutive(who)
        constants, bad = self._members.prepared(which)
        moments, wxyz, _ = self._members.states(which)
        principal = self._members.principal
        principal = principal if len(principal) == 1 else principal[which]
        if not self._raises:
            unknown = np.any(moments[:, :, 0] == 0.0, axis=1)
            unknown[bad] = True
            moments = np.where(unknown[:, None, None], 1.0, moments)
        states = moments, wxyz, principal
        try:
            tangents = columns.tangents_of(*states, constants)
            if not self._raises:
                for name in ("weights", "offset", "amplitudes", "uniform", "uniform_rates"):
                    tangents[name][unknown] = np.nan
                t, low = _near(constants, tangents, t, low, edges)
            columns.evaluate(constants, tangents, t, low, attitude, omega, edges=edges)
        except AttitudeError:
            self._refuse(who, constants, states, t, low, edges)
            raise

    def _refuse(
        self,
        who: IntArray,
        constants: NDArray[Any],
        states: tuple[FloatArray, FloatArray, FloatArray],
        t: FloatArray,
        low: FloatArray | None,
        edges: IntArray | None,
    ) -> None:
        """Raise the AttitudeError of the first member that has one, with its name."""
        for k, number in enumerate(who.tolist()):
            own = [each[k : k + 1] if len(each) > 1 else each for each in (constants, *states)]
            rows = slice(None) if edges is None else slice(edges[k], edges[k + 1])
            line = slice(k, k + 1) if len(t) > 1 else slice(None)
            times = read_only(np.ascontiguousarray(t[line, rows]))
            lows = None if low is None else read_only(np.ascontiguousarray(low[line, rows]))
            try:
                tangents = columns.tangents_of(own[1], own[2], own[3], own[0])
                found = np.empty((1, 3, columns.PARAMETERS, times.shape[1]))
                columns.evaluate(own[0], tangents, times, lows, found)
            except AttitudeError as err:
                raise AttitudeError(f"{self._label(number)}: {err}") from None


def _near(
    constants: NDArray[Any],
    tangents: NDArray[Any],
    t: FloatArray,
    low: FloatArray | None,
    edges: IntArray | None,
) -> tuple[FloatArray, FloatArray | None]:
    """The epochs with NaN in place of those at which the derivatives of a member are unknown."""
    reach = np.fmin(evaluate.reaches(constants), columns.reaches(tangents))
    rows = slice(None) if edges is None else slice(edges[0], edges[-1])
    far = reach[:, None] if edges is None else np.repeat(reach, np.diff(edges))[None]
    near, lows = evaluate.within(t[:, rows], None if low is None else low[:, rows], far)
    if edges is None:
        return near, lows
    whole = t.copy()
    whole[:, rows] = near
    return read_only(whole), low
