"""Epochs of a call: a grid of members and epochs, or rows each of one member."""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from attitude._solver import states
from attitude._support.arrays import components_first, read_only
from attitude._support.pairs import Seconds
from attitude.errors import AttitudeError
from attitude.motions import _propagation

if TYPE_CHECKING:
    from collections.abc import Iterator

    from numpy.typing import NDArray

    from attitude._solver.states import Evaluation, Results
    from attitude._support.annotations import FloatArray, IntArray


class Piece(NamedTuple):
    """Rows of which those of one member stand together."""

    place: slice | IntArray  # of the rows among all
    member: IntArray  # (K,)
    t: Seconds  # (K,), since the epoch of the member


class MemberGrid:
    """All of N = `count` members, from the number `first` on, at T epochs.

    scalar: whether one epoch was given, so that the answers have no axis of epochs.
    """

    def __init__(self, count: int, t: Seconds, scalar: bool, first: int = 0) -> None:
        self.count, self.scalar, self.first = count, scalar, first
        # Epochs that all members share are few: a copy does not change with the caller's array.
        few = len(t.hi) == 1 and t.hi.size < 1 << 20
        hi = t.hi.copy() if few else t.hi
        # (1 or N, T), since the epoch of the member
        self.t = Seconds(hi, t.lo).mapped(np.ascontiguousarray)
        self.length: int = t.hi.shape[1]
        self.shape: tuple[int, ...] = (count,) if scalar else (count, self.length)  # S, of all
        self.member = self._over_epochs(np.arange(first, first + count)[:, None])
        self.seconds = self.t.mapped(self._over_epochs)

    def _over_epochs(self, array):
        spread = np.broadcast_to(array, (self.count, self.length))
        return spread[:, 0] if self.scalar else spread

    def pieces(self, most: int) -> list[tuple[slice, slice]]:
        """Members and epochs of parts of at most `most` rows, in order."""
        length = self.length
        span, size = min(length, most), max(1, most // max(length, 1))
        return [
            (slice(k, min(k + size, self.count)), slice(j, min(j + span, length)))
            for k in range(0, self.count if length else 0, size)
            for j in range(0, length, span)
        ]

    def piece(self, block: tuple[slice, slice]) -> Piece:
        """The rows of one of the `pieces`."""
        members, epochs = block
        length = self.length
        place = slice(
            members.start * length + epochs.start, (members.stop - 1) * length + epochs.stop
        )
        who = np.arange(members.start, members.stop).repeat(epochs.stop - epochs.start)
        shape = members.stop - members.start, epochs.stop - epochs.start

        def rows(array: FloatArray) -> FloatArray:
            values = array[members if len(array) > 1 else slice(None), epochs]
            return np.ascontiguousarray(np.broadcast_to(values, shape)).reshape(-1)

        return Piece(place, who, self.t.mapped(rows))

    def vectors(self, array: FloatArray, block: tuple[slice, slice]) -> FloatArray:
        """The rows (K, 3) of vectors (S, 3) in one of the `pieces`."""
        return array[block[0]] if self.scalar else array[block].reshape(-1, 3)

    def parts(self, most: int) -> Iterator[tuple[Any, MemberGrid]]:
        """Grids of at most `most` attitudes, each after its place among the answers."""
        for members, epochs in self.pieces(most):
            rows_of_block = (members if len(self.t.hi) > 1 else slice(None)), epochs
            count = members.stop - members.start
            place = members if self.scalar else (members, epochs)
            yield place, MemberGrid(count, self.t.taken(rows_of_block), self.scalar, members.start)

    def fill(self, evaluation: Evaluation, results: Results, threads: int) -> None:
        """Fill memory of `memory`."""
        evaluation.grid(self.t, results, threads, self.first)

    def memory(self, out: FloatArray | None, name: str, *width: int) -> FloatArray:
        """Component-major memory (N, *W, T) for an answer; that of `out` where possible."""
        shape = self.count, self.length
        return _propagation.result_memory(out, name, shape, width, self.scalar)

    def shaped(self, memory: FloatArray, out: FloatArray | None) -> FloatArray:
        """Component-major memory (N, *W, T) as (S, *W), in `out` if it is given."""
        return _propagation.result(memory, out, self.scalar, 1)


class MemberRows:
    """Rows of shape S, each of one epoch, since that of the member, of one of N = `count` members.

    in_runs: whether rows of one member stand together, in long runs (`survey`), if known.
    """

    def __init__(
        self,
        count: int,
        member: IntArray,
        seconds: Seconds,
        in_runs: bool | None = None,
    ) -> None:
        self.count, self.member, self._in_runs = count, member, in_runs
        self.seconds = seconds.mapped(read_only)
        self.size: int = seconds.hi.size
        self.shape: tuple[int, ...] = seconds.hi.shape

    def pieces(self, most: int) -> list[slice | IntArray]:
        """The places of parts of `most` rows, of which those of one member stand together."""
        size, order = self.size, self.order
        parts = [slice(k, min(k + most, size)) for k in range(0, size, most)]
        return [*parts] if order is None else [order[block] for block in parts]

    def piece(self, block: slice | IntArray) -> Piece:
        """The rows of one of the `pieces`."""
        member, t = self.flat()
        return Piece(block, member[block], t.taken(block))

    def vectors(self, array: FloatArray, block: slice | IntArray) -> FloatArray:
        """The rows (K, 3) of vectors (S, 3) in one of the `pieces`."""
        return array[block] if array.ndim == 2 else array.reshape(-1, 3)[block]

    def flat(self) -> tuple[IntArray, Seconds]:
        """Members and their epochs (R,)."""

        def row(array: NDArray[Any]) -> NDArray[Any]:
            return np.ascontiguousarray(array).reshape(-1)

        return row(self.member), self.seconds.mapped(row)

    @cached_property
    def order(self) -> IntArray | None:
        """The order (R,) in which rows stand by member; None if they stand in long runs already."""
        if not self.size:
            return None
        member = self.flat()[0]
        in_runs = states.survey(member)[2] if self._in_runs is None else self._in_runs
        return None if in_runs else states.order_of(member, self.count)

    def parts(self, most: int) -> Iterator[tuple[slice, MemberRows]]:
        """Rows of at most `most` attitudes, each after their place among the rows (R,)."""
        member, seconds = self.flat()
        for first in range(0, self.size, most):
            place = slice(first, first + most)
            yield place, MemberRows(self.count, member[place], seconds.taken(place))

    def fill(self, evaluation: Evaluation, results: Results, threads: int) -> None:
        """Fill memory of `memory`."""
        evaluation.rows(*self.flat(), self.order, results, threads)

    def memory(self, out: FloatArray | None, name: str, *width: int) -> FloatArray:
        """Memory (*W, R) for an answer; that of `out` where possible."""
        if out is None and self.order is not None:
            # Rows are filled one by one: the numbers of each are together.
            return np.moveaxis(np.empty((self.size, *width)), 0, -1)
        return _propagation.result_memory(out, name, (self.size,), width, False)

    def shaped(self, memory: FloatArray, out: FloatArray | None) -> FloatArray:
        """Component-major memory (*W, R) as (S, *W), in `out` if it is given."""
        if out is not None:
            if len(self.shape) != 1:
                raise AttitudeError(
                    f"out is given for rows of shape {self.shape}; give rows (R,) with out=."
                )
            return _propagation.result(memory, out, False, 0)
        width = memory.shape[:-1]
        if memory.flags.c_contiguous:
            split = memory.reshape(*width, *self.shape)
            first = len(width)
            return split.transpose(*range(first, split.ndim), *range(first))
        return components_first(memory).reshape(*self.shape, *width)
