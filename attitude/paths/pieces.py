"""Chebyshev pieces of a vector of three that paths hold: where they lie, and their records."""

from dataclasses import dataclass

import numpy as np

from attitude.epochs.inputs import Instant
from attitude.immutable import Immutable, frozen, read_only
from attitude.paths.path import since


@dataclass(frozen=True, eq=False)
class EqualPieces(Immutable):
    """Pieces of one width.

    Attributes
    ----------
    start : Instant
        Where the first piece starts.
    width : float
        Seconds.
    records : (pieces, skip + 3 count) array, read-only
        A row for each piece, as `polynomials` says.
    skip, count : int
    factor : float
        What the values are multiplied by.
    least, most : float
        What may be asked for, in seconds after start.
    """

    start: Instant
    width: float
    records: np.ndarray
    skip: int
    count: int
    factor: float
    least: float
    most: float

    def place(self, instant, hi, lo):
        """Piece and place in it for each epoch, and the index of an epoch outside or -1."""
        from attitude.paths import chebyshev_loops

        piece, x = np.empty(hi.size, dtype=np.int64), np.empty(hi.size)
        base = since(instant, self.start)
        bounds = self.least, self.most, self.width, len(self.records)
        at = read_only(hi), read_only(lo)
        return piece, x, chebyshev_loops.place_equal(*at, *base, *bounds, piece, x)

    @property
    def widths(self):
        return read_only(np.array([self.width]))


@dataclass(frozen=True, eq=False)
class CellPieces(Immutable):
    """Pieces that each fill one or more equal cells: short where the motion is quick.

    Attributes are those of `EqualPieces`, and

    width : float
        Seconds, of a cell.
    cells : (cells,) int32 array
        The piece that fills each cell.
    starts, widths : (pieces,) arrays
        Seconds after start, and seconds.
    """

    start: Instant
    width: float
    cells: np.ndarray
    starts: np.ndarray
    widths: np.ndarray
    records: np.ndarray
    count: int
    most: float
    skip: int = 0
    factor: float = 1.0

    def __post_init__(self):
        for array in (self.cells, self.starts, self.widths, self.records):
            frozen(array)

    def place(self, instant, hi, lo):
        """See `EqualPieces.place`."""
        from attitude.paths import chebyshev_loops

        piece, x = np.empty(hi.size, dtype=np.int64), np.empty(hi.size)
        bounds = 0.0, self.most, self.width, self.cells, self.starts, self.widths
        base = since(instant, self.start)
        at = read_only(hi), read_only(lo)
        return piece, x, chebyshev_loops.place_cells(*at, *base, *bounds, piece, x)


@dataclass(frozen=True, eq=False)
class KnotPieces(Immutable):
    """Pieces between knots, as the rows of a table give them.

    Attributes are those of `EqualPieces`, and

    knots, knots_low : (pieces + 1,) arrays
        Where the pieces begin and end, in seconds after start.
    """

    start: Instant
    knots: np.ndarray
    knots_low: np.ndarray
    records: np.ndarray
    count: int
    skip: int = 0
    factor: float = 1.0

    def __post_init__(self):
        for array in (self.knots, self.knots_low, self.records):
            frozen(array)

    def place(self, instant, hi, lo):
        """See `EqualPieces.place`."""
        from attitude.paths import chebyshev_loops

        piece, x = np.empty(hi.size, dtype=np.int64), np.empty(hi.size)
        base = since(instant, self.start)
        knots = self.knots, self.knots_low
        at = read_only(hi), read_only(lo)
        return piece, x, chebyshev_loops.place_knots(*at, *base, *knots, piece, x)

    @property
    def widths(self):
        return read_only(np.diff(self.knots) + np.diff(self.knots_low))


def placed(path, instant, hi, lo):
    """Piece and place in it of epochs, in the pieces of a path; AttitudeError for one outside."""
    piece, x, outside = path.pieces.place(instant, hi, lo)
    if outside >= 0:
        path.refuse_outside(instant, hi[outside])
    return piece, x


def values(pieces, piece, x, skip=None):
    """The vectors (3, N) at places in pieces."""
    from attitude.paths import chebyshev_loops

    out = np.empty((3, piece.size))
    skip = pieces.skip if skip is None else skip
    chebyshev_loops.values(pieces.records, skip, pieces.count, piece, x, pieces.factor, out)
    return out


def values_and_rates(pieces, piece, x):
    """The vectors and their derivatives by time, each (3, N)."""
    from attitude.paths import chebyshev_loops

    out, rate = np.empty((3, piece.size)), np.empty((3, piece.size))
    given = pieces.records, pieces.skip, pieces.count, piece, x, pieces.widths, pieces.factor
    chebyshev_loops.values_and_rates(*given, out, rate)
    return out, rate
