"""Chebyshev pieces of a vector of three that paths hold: their spans in time and their records."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, NoReturn, Protocol, TypeAlias

import numpy as np

from attitude.immutable import Immutable, frozen, read_only
from attitude.paths.path import since

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from attitude.annotations import FloatArray, IntArray
    from attitude.epochs.instants import Instant


@dataclass(frozen=True, eq=False)
class EqualPieces(Immutable):
    """Pieces of one width.

    Attributes
    ----------
    start : Instant
        Start of the first piece.
    width : float
        Length of a piece, s.
    records : (pieces, skip + 3 count) array, read-only
        A row for each piece; see `chebyshev_loops`.
    skip, count : int
        Numbers of a row before the coefficients, and coefficients of one component.
    factor : float
        Factor of the values.
    least, most : float
        Range of the epochs, in seconds after start.
    """

    start: Instant
    width: float
    records: FloatArray
    skip: int
    count: int
    factor: float
    least: float
    most: float

    def place(
        self, instant: Instant, hi: FloatArray, lo: FloatArray
    ) -> tuple[IntArray, FloatArray, int]:
        """Numbers of the pieces (N,), coordinates in them (N,), index of an epoch outside or -1.

        The epochs are instant + hi + lo; a coordinate goes from -1 to 1.
        """
        from attitude.paths import chebyshev_loops

        piece, x = np.empty(hi.size, dtype=np.int64), np.empty(hi.size)
        base = since(instant, self.start)
        bounds = self.least, self.most, self.width, len(self.records)
        at = read_only(hi), read_only(lo)
        return piece, x, chebyshev_loops.place_equal(*at, *base, *bounds, piece, x)

    @property
    def widths(self) -> FloatArray:
        """The one length of all pieces (1,), s."""
        return read_only(np.array([self.width]))


@dataclass(frozen=True, eq=False)
class CellPieces(Immutable):
    """Pieces that each fill one or more equal cells: short where the motion is quick.

    Attributes
    ----------
    width : float
        Length of a cell, s.
    cells : (cells,) int32 array
        Number of the piece that fills each cell.
    starts, widths : (pieces,) arrays
        Starts of the pieces in seconds after start, and their lengths in s.
    most : float
        End of the range of the epochs, in seconds after start.
    start, records, count, skip, factor
        See `EqualPieces`.
    """

    start: Instant
    width: float
    cells: NDArray[np.int32]
    starts: FloatArray
    widths: FloatArray
    records: FloatArray
    count: int
    most: float
    skip: int = 0
    factor: float = 1.0

    def __post_init__(self) -> None:
        for array in (self.cells, self.starts, self.widths, self.records):
            frozen(array)

    def place(
        self, instant: Instant, hi: FloatArray, lo: FloatArray
    ) -> tuple[IntArray, FloatArray, int]:
        """See `EqualPieces.place`."""
        from attitude.paths import chebyshev_loops

        piece, x = np.empty(hi.size, dtype=np.int64), np.empty(hi.size)
        bounds = 0.0, self.most, self.width, self.cells, self.starts, self.widths
        base = since(instant, self.start)
        at = read_only(hi), read_only(lo)
        return piece, x, chebyshev_loops.place_cells(*at, *base, *bounds, piece, x)


@dataclass(frozen=True, eq=False)
class KnotPieces(Immutable):
    """Pieces between knots: the epochs of the rows of a table.

    Attributes
    ----------
    knots, knots_low : (pieces + 1,) arrays
        Ends of the pieces in seconds after start, in two doubles.
    start, records, count, skip, factor
        See `EqualPieces`.
    """

    start: Instant
    knots: FloatArray
    knots_low: FloatArray
    records: FloatArray
    count: int
    skip: int = 0
    factor: float = 1.0

    def __post_init__(self) -> None:
        for array in (self.knots, self.knots_low, self.records):
            frozen(array)

    def place(
        self, instant: Instant, hi: FloatArray, lo: FloatArray
    ) -> tuple[IntArray, FloatArray, int]:
        """See `EqualPieces.place`."""
        from attitude.paths import chebyshev_loops

        piece, x = np.empty(hi.size, dtype=np.int64), np.empty(hi.size)
        base = since(instant, self.start)
        knots = self.knots, self.knots_low
        at = read_only(hi), read_only(lo)
        return piece, x, chebyshev_loops.place_knots(*at, *base, *knots, piece, x)

    @property
    def widths(self) -> FloatArray:
        """Lengths of the pieces (pieces,), s."""
        return read_only(np.diff(self.knots) + np.diff(self.knots_low))


Pieces: TypeAlias = EqualPieces | CellPieces | KnotPieces


class PiecewisePath(Protocol):
    """A path that holds pieces."""

    @property
    def pieces(self) -> Pieces:
        """The pieces of the positions."""

    def refuse_outside(self, instant: Instant, seconds: float) -> NoReturn:
        """Raise the AttitudeError for an epoch outside of the span."""


def placed(
    path: PiecewisePath, instant: Instant, hi: FloatArray, lo: FloatArray
) -> tuple[IntArray, FloatArray]:
    """Numbers of the pieces (N,) of a path, and coordinates in them (N,), of epochs.

    Raises
    ------
    AttitudeError
        For an epoch outside of the pieces.
    """
    piece, x, outside = path.pieces.place(instant, hi, lo)
    if outside >= 0:
        path.refuse_outside(instant, hi[outside])
    return piece, x


def values(pieces: Pieces, piece: IntArray, x: FloatArray, skip: int | None = None) -> FloatArray:
    """The vectors (3, N) at coordinates x (N,) in pieces with the numbers piece (N,).

    `skip` replaces that of the pieces.
    """
    from attitude.paths import chebyshev_loops

    out = np.empty((3, piece.size))
    skip = pieces.skip if skip is None else skip
    chebyshev_loops.values(pieces.records, skip, pieces.count, piece, x, pieces.factor, out)
    return out


def values_and_rates(
    pieces: Pieces, piece: IntArray, x: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """The vectors and their derivatives by time in s, each (3, N); see `values`."""
    from attitude.paths import chebyshev_loops

    out, rate = np.empty((3, piece.size)), np.empty((3, piece.size))
    given = pieces.records, pieces.skip, pieces.count, piece, x, pieces.widths, pieces.factor
    chebyshev_loops.values_and_rates(*given, out, rate)
    return out, rate
