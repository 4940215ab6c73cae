"""The epochs of a call: a grid of members and epochs, or rows each of one member."""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from attitude import propagation
from attitude.ensemble import evaluate
from attitude.errors import AttitudeError
from attitude.immutable import read_only

if TYPE_CHECKING:
    from collections.abc import Iterator

    from attitude.annotations import FloatArray, IntArray


class Piece(NamedTuple):
    """Rows of which those of one member stand together.

    Attributes
    ----------
    place : slice or array of int
        Of the rows among all.
    member : (K,) array of int
    t, low : (K,) arrays
        Seconds t + low since the epoch of the member; low may be None.
    """

    place: slice | IntArray
    member: IntArray
    t: FloatArray
    low: FloatArray | None


class MemberGrid:
    """All of N members at T epochs.

    Parameters
    ----------
    count : int
        N.
    t, t_low : (1 or N, T) arrays
        Seconds t + t_low since the epoch of the member; t_low may be None.
    scalar : bool
        Whether one epoch was given, so that the answers have no axis of epochs.
    first : int
        Number of the first member.

    Attributes
    ----------
    shape : tuple
        S: (N, T), or (N,) for one epoch.
    member : (S) array of int
    seconds, low : (S) arrays
    """

    def __init__(
        self, count: int, t: FloatArray, t_low: FloatArray | None, scalar: bool, first: int = 0
    ) -> None:
        self.count, self.scalar, self.first = count, scalar, first
        # Epochs that all members share are few: a copy does not change with the caller's array.
        few = len(t) == 1 and t.size < 1 << 20
        self.t = t.copy() if few else np.ascontiguousarray(t)
        self.t_low = None if t_low is None else np.ascontiguousarray(t_low)
        self.shape: tuple[int, ...] = (count,) if scalar else (count, t.shape[1])
        numbers = np.arange(first, first + count)
        self.member = self._over_epochs(numbers[:, None])
        self.seconds = self._over_epochs(self.t)
        self.low = None if self.t_low is None else self._over_epochs(self.t_low)

    def _over_epochs(self, array):
        found = np.broadcast_to(array, (self.count, self.t.shape[1]))
        return found[:, 0] if self.scalar else found

    def pieces(self, most: int) -> list[tuple[slice, slice]]:
        """Members and epochs of parts of at most `most` rows, in order."""
        length = self.t.shape[1]
        span, size = min(length, most), max(1, most // max(length, 1))
        return [
            (slice(k, min(k + size, self.count)), slice(j, min(j + span, length)))
            for k in range(0, self.count if length else 0, size)
            for j in range(0, length, span)
        ]

    def piece(self, part: tuple[slice, slice]) -> Piece:
        """The rows of one of the `pieces`."""
        members, epochs = part
        length = self.t.shape[1]
        place = slice(
            members.start * length + epochs.start, (members.stop - 1) * length + epochs.stop
        )
        who = np.arange(members.start, members.stop).repeat(epochs.stop - epochs.start)
        shape = members.stop - members.start, epochs.stop - epochs.start

        def rows(array: FloatArray) -> FloatArray:
            here = array[members if len(array) > 1 else slice(None), epochs]
            return np.ascontiguousarray(np.broadcast_to(here, shape)).reshape(-1)

        low = None if self.t_low is None else rows(self.t_low)
        return Piece(place, who, rows(self.t), low)

    def vectors(self, given: FloatArray, part: tuple[slice, slice]) -> FloatArray:
        """The rows (K, 3) of vectors (S, 3) in one of the `pieces`."""
        if self.scalar:
            return given[part[0]]
        return given[part].reshape(-1, 3)

    def parts(self, most: int) -> Iterator[tuple[Any, MemberGrid]]:
        """Grids of at most `most` attitudes, each after its place among the answers."""
        for members, epochs in self.pieces(most):
            own = (members if len(self.t) > 1 else slice(None)), epochs
            low = None if self.t_low is None else self.t_low[own]
            count = members.stop - members.start
            place = members if self.scalar else (members, epochs)
            yield place, MemberGrid(count, self.t[own], low, self.scalar, members.start)

    def memory(self, out: FloatArray | None, name: str, *width: int) -> FloatArray:
        """Component-major memory (N, *W, T) for an answer; that of `out` where possible."""
        shape = self.count, self.t.shape[1]
        return propagation.result_memory(out, name, shape, width, self.scalar)

    def shaped(self, memory: FloatArray, out: FloatArray | None) -> FloatArray:
        """Component-major memory (N, *W, T) as (S, *W), in `out` if it is given."""
        return propagation.result(memory, out, self.scalar, 1)


class MemberRows:
    """Rows of one epoch of one of N members each.

    Parameters
    ----------
    count : int
        N.
    member : (S) array of int
    seconds, low : (S) arrays
        Seconds + low since the epoch of the member; low may be None.
    in_runs : bool, optional
        Whether rows of one member stand together, in long runs (`evaluate.survey`), if known.
    """

    def __init__(
        self,
        count: int,
        member: IntArray,
        seconds: FloatArray,
        low: FloatArray | None,
        in_runs: bool | None = None,
    ) -> None:
        self.count, self.member, self._in_runs = count, member, in_runs
        self.seconds = read_only(seconds)
        self.low = None if low is None else read_only(low)
        self.shape: tuple[int, ...] = seconds.shape

    def pieces(self, most: int) -> list[slice | IntArray]:
        """The places of parts of `most` rows, of which those of one member stand together."""
        size, order = self.seconds.size, self.order
        parts = [slice(k, min(k + most, size)) for k in range(0, size, most)]
        return [*parts] if order is None else [order[part] for part in parts]

    def piece(self, part: slice | IntArray) -> Piece:
        """The rows of one of the `pieces`."""
        member, t, low = self.flat()
        return Piece(part, member[part], t[part], None if low is None else low[part])

    def vectors(self, given: FloatArray, part: slice | IntArray) -> FloatArray:
        """The rows (K, 3) of vectors (S, 3) in one of the `pieces`."""
        return given[part] if given.ndim == 2 else given.reshape(-1, 3)[part]

    def flat(self) -> tuple[IntArray, FloatArray, FloatArray | None]:
        """Members, seconds and their second doubles as arrays (R,)."""
        low = None if self.low is None else np.ascontiguousarray(self.low).reshape(-1)
        member = np.ascontiguousarray(self.member).reshape(-1)
        return member, np.ascontiguousarray(self.seconds).reshape(-1), low

    @cached_property
    def order(self) -> IntArray | None:
        """The order (R,) in which rows stand by member; None if they stand in long runs already."""
        if not self.seconds.size:
            return None
        member = self.flat()[0]
        in_runs = evaluate.survey(member)[2] if self._in_runs is None else self._in_runs
        return None if in_runs else evaluate.order_of(member, self.count)

    def parts(self, most: int) -> Iterator[tuple[slice, MemberRows]]:
        """Rows of at most `most` attitudes, each after their place among the rows (R,)."""
        member, seconds, low = self.flat()
        for first in range(0, self.seconds.size, most):
            place = slice(first, first + most)
            lows = None if low is None else low[place]
            yield place, MemberRows(self.count, member[place], seconds[place], lows)

    def memory(self, out: FloatArray | None, name: str, *width: int) -> FloatArray:
        """Memory (*W, R) for an answer; that of `out` where possible."""
        if out is None and self.order is not None:
            # Rows are filled one by one: the numbers of each are together.
            return np.moveaxis(np.empty((self.seconds.size, *width)), 0, -1)
        return propagation.result_memory(out, name, (self.seconds.size,), width, False)

    def shaped(self, memory: FloatArray, out: FloatArray | None) -> FloatArray:
        """Component-major memory (*W, R) as (S, *W), in `out` if it is given."""
        if out is not None:
            if len(self.shape) != 1:
                raise AttitudeError(
                    f"out is given for rows of shape {self.shape}; give rows (R,) with out=."
                )
            return propagation.result(memory, out, False, 0)
        width = memory.shape[:-1]
        if memory.flags.c_contiguous:
            split = memory.reshape(*width, *self.shape)
            return np.moveaxis(split, range(len(width)), range(-len(width), 0))
        return np.moveaxis(memory, -1, 0).reshape(*self.shape, *width)
