"""Any path over a span of time as Chebyshev polynomials, to a stated and measured error.

A satellite or a ground site costs microseconds an epoch, a polynomial some tens of nanoseconds.
The span is halved, and halved again where the motion is quick, until every piece reaches the
tolerance, so that a close approach of an hour does not refine the year around it.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, NoReturn, Protocol, TypeAlias

import numpy as np
from numpy.polynomial import chebyshev as polynomials

from attitude._solver import chebyshev
from attitude._support import pairs, validation
from attitude._support.arrays import Immutable, frozen, read_only
from attitude.epochs import _inputs
from attitude.errors import AttitudeError
from attitude.paths._path import Path, since, spelled

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from attitude._support.annotations import Epoch, FloatArray, IntArray, Real
    from attitude.epochs._instants import Instant


# ---- Chebyshev pieces of a vector of three that paths hold: their spans in time and their records


@dataclass(frozen=True, eq=False)
class EqualPieces(Immutable):
    """Pieces of one width.

    start: start of the first piece.
    width: length of a piece, s.
    records: (pieces, skip + 3 count), a row for each piece; see `attitude._solver.chebyshev`.
    skip, count: numbers of a row before the coefficients, and coefficients of one component.
    factor: factor of the values.
    least, most: range of the epochs, in seconds after start.
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
        """Numbers of the pieces (N,), coordinates -1 to 1 in them (N,) at instant + hi + lo; epoch
        outside or -1.
        """
        from attitude._solver import chebyshev

        piece, x = np.empty(hi.size, dtype=np.int64), np.empty(hi.size)
        base = since(instant, self.start)
        bounds = self.least, self.most, self.width, len(self.records)
        at = read_only(hi), read_only(lo)
        return piece, x, chebyshev.place_equal(*at, *base, *bounds, piece, x)

    @property
    def widths(self) -> FloatArray:
        """The one length of all pieces (1,), s."""
        return read_only(np.array([self.width]))


@dataclass(frozen=True, eq=False)
class CellPieces(Immutable):
    """Pieces that each fill one or more equal cells: short where the motion is quick.

    width: length of a cell, s.
    cells: (cells,) int32, number of the piece that fills each cell.
    starts, widths: (pieces,) arrays, starts of the pieces in seconds after start, and their lengths
        in s.
    most: end of the range of the epochs, in seconds after start.
    start, records, count, skip, factor: see `EqualPieces`.
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
        from attitude._solver import chebyshev

        piece, x = np.empty(hi.size, dtype=np.int64), np.empty(hi.size)
        bounds = 0.0, self.most, self.width, self.cells, self.starts, self.widths
        base = since(instant, self.start)
        at = read_only(hi), read_only(lo)
        return piece, x, chebyshev.place_cells(*at, *base, *bounds, piece, x)


@dataclass(frozen=True, eq=False)
class KnotPieces(Immutable):
    """Pieces between knots: the epochs of the rows of a table.

    knots, knots_low: (pieces + 1,) arrays, ends of the pieces in seconds after start, in two
        doubles.
    start, records, count, skip, factor: see `EqualPieces`.
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
        from attitude._solver import chebyshev

        piece, x = np.empty(hi.size, dtype=np.int64), np.empty(hi.size)
        base = since(instant, self.start)
        knots = self.knots, self.knots_low
        at = read_only(hi), read_only(lo)
        return piece, x, chebyshev.place_knots(*at, *base, *knots, piece, x)

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
    """Numbers of the pieces (N,) of a path, and coordinates in them (N,), of epochs."""
    piece, x, outside = path.pieces.place(instant, hi, lo)
    if outside >= 0:
        path.refuse_outside(instant, hi[outside])
    return piece, x


def values(pieces: Pieces, piece: IntArray, x: FloatArray, skip: int | None = None) -> FloatArray:
    """The vectors (3, N) at coordinates x (N,) in pieces (N,), with another `skip`."""
    from attitude._solver import chebyshev

    out = np.empty((3, piece.size))
    skip = pieces.skip if skip is None else skip
    chebyshev.values(pieces.records, skip, pieces.count, piece, x, pieces.factor, out)
    return out


def values_and_rates(
    pieces: Pieces, piece: IntArray, x: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """The vectors and their derivatives by time in s, each (3, N); see `values`."""
    from attitude._solver import chebyshev

    out, rate = np.empty((3, piece.size)), np.empty((3, piece.size))
    given = pieces.records, pieces.skip, pieces.count, piece, x, pieces.widths, pieces.factor
    chebyshev.values_and_rates(*given, out, rate)
    return out, rate


# Degree 15: the fewest numbers, within 20 %, for orbits of 1e7 to 1e11 m at a tolerance of 1e-3 m;
# 16 coefficients are a power of two.
_COUNT = 16
_DEEPEST = 22
_MOST_PIECES = 400_000
# Rounding errors of Clenshaw's recurrence and of the path itself, in units of eps |r|.
_ROUNDINGS = 8.0
_EPS = np.finfo(np.float64).eps
# The largest number of pieces that are sampled before it is known which of them are needed.
_TOGETHER = 3
# Places of the samples between the nodes, and there the Chebyshev polynomials and their slopes.
_EXTREMA = np.cos(np.pi * np.arange(_COUNT + 1) / _COUNT)
_VALUES = np.cos(np.pi * np.outer(np.arange(_COUNT + 1), np.arange(_COUNT)) / _COUNT)
_SLOPES = polynomials.chebval(_EXTREMA, polynomials.chebder(np.eye(_COUNT), axis=0)).T
# The largest number of epochs at which a path is sampled in one call.
_BATCH = 1 << 18


@dataclass(frozen=True, eq=False, repr=False)
class Compressed(Path):
    """A path as Chebyshev pieces on a span.  Made by `compress`.

    Attributes
    ----------
    pieces : CellPieces
    error : float
        The largest difference from the path in m, measured between the nodes of every piece.
    speed_error : float
        The largest difference of the velocity in m/s, measured there too.
    tolerance : float
        The tolerance that was given, m.
    name, center, source, span
        As for all paths; the source contains that of the original path.
    """

    pieces: CellPieces
    error: float
    speed_error: float
    tolerance: float
    name: str
    center: str | Path
    source: str
    span: tuple[Instant, Instant]

    @cached_property
    def _rows(self) -> FloatArray:
        """The records with x, y, z and a zero of each order together (see `chebyshev`)."""
        count = self.pieces.count
        rows = np.zeros((len(self.pieces.records), count, 4))
        rows[:, :, :3] = self.pieces.records.reshape(-1, 3, count).transpose(0, 2, 1)
        return frozen(rows.reshape(-1))

    def _position(self, instant, hi, lo):
        return values(self.pieces, *placed(self, instant, hi, lo))

    def _state(self, instant, hi, lo):
        return values_and_rates(self.pieces, *placed(self, instant, hi, lo))

    def directions(
        self,
        instant: Instant,
        hi: FloatArray,
        lo: FloatArray,
        sign: float,
        unit: FloatArray,
        length: FloatArray,
    ) -> None:
        """Fill unit vectors (3, N) times a sign, and lengths (N,) in m, of the positions.

        At the epochs instant + hi (N,) + lo (N,) or (1,), in any order; ascending ones take 6 ns
        each, others up to three times as long.  NaN for NaN.

        Raises
        ------
        AttitudeError
            For an epoch outside of the span.
        """
        from attitude._solver import chebyshev

        pieces = self.pieces
        # SIMD reads eight successive doubles: a view of every second epoch is copied.
        hi, lo = np.ascontiguousarray(hi), np.ascontiguousarray(lo)
        at = read_only(hi), read_only(lo), *since(instant, pieces.start)
        cells = pieces.most, pieces.width, pieces.cells, pieces.starts, pieces.widths
        given = *at, *cells, pieces.records, self._rows, pieces.count, sign
        for begin in range(0, hi.size, _BATCH):
            end = min(begin + _BATCH, hi.size)
            outside = chebyshev.directions(*given, begin, end, unit, length)
            if outside >= 0:
                self.refuse_outside(instant, hi[outside])


def compress(path: Path, start: Epoch, stop: Epoch, tolerance: Real = 1e-3) -> Compressed:
    """A path over a span of time as Chebyshev polynomials of degree 15.

    Parameters
    ----------
    path : Path
    start, stop : anything that `epochs.instant` takes
        The span, start before stop.
    tolerance : float or Quantity
        Largest error in m.  For positions so large that doubles round them by more (1 mm: from
        5e11 m on), the limit is 8 roundings of the position instead; for a rough path
        (``path.roughness``: 0.1 m for the series built into astropy), its roughness.

    Returns
    -------
    Compressed
        With ``error`` and ``speed_error`` measured at 17 epochs of every piece, where the error
        of an interpolation at the Chebyshev nodes is largest; both ends are among them.

    Raises
    ------
    AttitudeError
        If the path does not cover the whole span, is not finite there, or is too rough; if start
        is not before stop.

    Notes
    -----
    20 to 40 ns an epoch at 1e6 epochs.  Features of a path between all samples are lost.
    """
    first, last = _inputs.instant(start, "start"), _inputs.instant(stop, "stop")
    limit = validation.positive(tolerance, "tolerance", unit="m")
    length = float(sum(since(last, first)))
    if not length > 0.0:
        raise AttitudeError(
            f"start is {spelled(first)} and stop is {spelled(last)}; start must be before stop."
        )
    fit = _halved(path, first, length, limit)
    depth = max(level for level, *_ in fit)
    width = length / 2**depth
    # Pieces in the order of time; their numbers are scaled to count the finest cells.
    fit.sort(key=lambda each: each[1] << (depth - each[0]))
    levels = np.array([each[0] for each in fit])
    spans = 1 << (depth - levels)
    cells = np.repeat(np.arange(len(fit), dtype=np.int32), spans)
    pieces = CellPieces(
        start=first,
        width=width,
        cells=cells,
        # The same doubles from which the epochs of the samples were computed.
        starts=np.array([_begin(length, each[0], each[1]) for each in fit]),
        widths=length / 2.0**levels,
        records=np.array([each[2] for each in fit]),
        count=_COUNT,
        most=length,
    )
    return Compressed(
        pieces=pieces,
        error=max(each[3] for each in fit),
        speed_error=max(each[4] for each in fit),
        tolerance=limit,
        name=path.name,
        center=path.center,
        source=f"{path.source}, compressed to {limit:g} m",
        span=(first, last),
    )


def _begin(length, level, number):
    """The start in s of a piece of a level."""
    return number * (length / 2**level)


def _halved(path, start, length, tolerance):
    """Pieces (level, number, record, error, speed error), each within the tolerance."""
    found, remaining, level = [], np.zeros(1, dtype=np.int64), 0
    while remaining.size:
        if level > _DEEPEST or len(found) + remaining.size > _MOST_PIECES:
            raise AttitudeError(
                f"{path.name} still errs by more than {tolerance:g} m in pieces of "
                f"{length / 2**level:.3g} s; allow a larger tolerance or give a shorter span, or "
                "a smoother path."
            )
        for numbers, *columns in _fit(path, start, level, remaining, length, tolerance):
            needed = np.isin(numbers, remaining)
            rows, errors, speeds, limits = (each[needed] for each in columns)
            good = errors <= limits
            found += [
                (level, int(number), row, float(error), float(speed))
                for number, row, error, speed in zip(
                    remaining[good], rows[good], errors[good], speeds[good], strict=True
                )
            ]
            remaining, level = _halves(remaining[~good]), level + 1
            if not remaining.size:
                break
    return found


def _halves(numbers):
    """The numbers of the halves of pieces, at the next level."""
    return (2 * numbers[:, None] + np.arange(2)).ravel()


def _fit(path, start, level, numbers, length, tolerance):
    """Numbers of pieces, and for each its record, error, speed error and allowed error."""
    levels = [numbers]
    while not path.is_slow and sum(map(len, levels)) + 2 * len(levels[-1]) <= _TOGETHER:
        levels.append(_halves(levels[-1]))
    widths = np.repeat(length / 2.0 ** (level + np.arange(len(levels))), [len(e) for e in levels])
    x = np.concatenate([chebyshev.nodes(_COUNT), _EXTREMA])
    # Two doubles: at 1e9 s a single one rounds by 1e-7 s, which is 4 mm at 30 km/s.
    begin = np.concatenate(levels) * widths
    hi, lo = pairs.two_sum(begin[:, None], widths[:, None] * (0.5 * (x + 1.0)))
    # Rounding may put a sample beyond the end of the span, where the path may be undefined.
    hi, lo = np.where(hi + lo > length, length, hi), np.where(hi + lo > length, 0.0, lo)
    sampled = _sampled(path, start, hi.ravel(), lo.ravel())
    position, velocity = (array.reshape(3, widths.size, x.size) for array in sampled)
    # Differences from one position of the piece: sums of these round less than sums of distances.
    middle = position[:, :, _COUNT // 2]
    table = chebyshev.coefficients(np.moveaxis(position[:, :, :_COUNT] - middle[..., None], -1, 0))
    error, speed = _errors(table, position[:, :, _COUNT:] - middle[..., None], velocity, widths)
    table[0] += middle
    rows = np.ascontiguousarray(np.moveaxis(table, 0, -1).transpose(1, 0, 2))
    size = np.sqrt(np.sum(position * position, axis=0)).max(axis=-1)
    limit = np.maximum(max(tolerance, path.roughness), _ROUNDINGS * _EPS * size)
    ends = np.cumsum([len(array) for array in levels])[:-1]
    columns = rows.reshape(widths.size, -1), error, speed, limit
    return zip(levels, *(np.split(array, ends) for array in columns), strict=True)


def _errors(table, position, velocity, widths):
    """Largest errors of coefficients (count, 3, pieces) and their derivatives, between nodes."""
    off = np.tensordot(table, _VALUES, axes=(0, 1)) - position
    slow = np.tensordot(table, _SLOPES, axes=(0, 1)) * (2.0 / widths)[:, None]
    slow -= velocity[:, :, _COUNT:]
    return (np.sqrt(np.sum(gap * gap, axis=0)).max(axis=-1) for gap in (off, slow))


def _sampled(path, start, hi, lo):
    """Positions and velocities (3, N) of a path, which must be finite."""
    parts = []
    for first in range(0, hi.size, _BATCH):
        piece = slice(first, first + _BATCH)
        parts.append(path.state(start, hi[piece], lo[piece]))
    position, velocity = (np.concatenate([piece[k] for piece in parts]).T for k in range(2))
    if not np.isfinite(position).all():
        bad = np.argmax(~np.isfinite(position).all(axis=0))
        raise AttitudeError(
            f"{path.name} has no finite position at {spelled(start.after(hi[bad], lo[bad]))}; "
            "compress it over a span where it has one."
        )
    return position, velocity
