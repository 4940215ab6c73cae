"""Any path over a span of time as Chebyshev polynomials, to a stated and measured error.

A satellite or a ground site costs microseconds an epoch, a polynomial some tens of nanoseconds.
The span is halved, and halved again where the motion is quick, until every piece reaches the
tolerance, so that a close approach of an hour does not refine the year around it.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.polynomial import chebyshev as polynomials

from attitude._solver import chebyshev
from attitude._support import pairs, validation
from attitude._support.arrays import frozen, read_only
from attitude.epochs import _inputs
from attitude.errors import AttitudeError
from attitude.paths._path import FrozenArrays, Path, since, spelled

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from attitude._support.annotations import Epoch, FloatArray, IntArray, Real
    from attitude.epochs._instants import Instant


# ---- Chebyshev pieces of a vector of three that paths hold: their spans in time and their records


@dataclass(frozen=True, eq=False, kw_only=True)
class Pieces(FrozenArrays):
    """Chebyshev polynomials of a vector on pieces of time, from `start` on, `widths` long, s.

    A row of `records` is a piece: `skip` numbers, then `count` coefficients of each component;
    values are multiplied by `factor`.
    """

    start: Instant
    widths: FloatArray
    records: FloatArray
    count: int
    skip: int = 0
    factor: float = 1.0

    def _fill(self, hi, lo, base_hi, base_lo, piece, x):
        """Fill piece and x; -1, or the index of an epoch outside of all pieces."""
        raise NotImplementedError(f"{type(self).__name__} defines no _fill")

    def place(
        self, path: Path, instant: Instant, hi: FloatArray, lo: FloatArray
    ) -> tuple[IntArray, FloatArray]:
        """Numbers of the pieces (N,), coordinates -1 to 1 in them (N,) of epochs of a path."""
        piece, x = np.empty(hi.size, dtype=np.int64), np.empty(hi.size)
        base_hi, base_lo = since(instant, self.start)
        outside = self._fill(read_only(hi), read_only(lo), base_hi, base_lo, piece, x)
        if outside >= 0:
            path.refuse_outside(instant, hi[outside])
        return piece, x

    def values(self, piece: IntArray, x: FloatArray, skip: int | None = None) -> FloatArray:
        """The vectors (3, N) at coordinates x (N,) in pieces (N,), with another `skip`."""
        out = np.empty((3, piece.size))
        skip = self.skip if skip is None else skip
        chebyshev.values(self.records, skip, self.count, piece, x, self.factor, out)
        return out

    def values_and_rates(self, piece: IntArray, x: FloatArray) -> tuple[FloatArray, FloatArray]:
        """The vectors and their derivatives by time in s, each (3, N); see `values`."""
        out, rate = np.empty((3, piece.size)), np.empty((3, piece.size))
        chebyshev.values_and_rates(
            self.records, self.skip, self.count, piece, x, self.widths, self.factor, out, rate
        )
        return out, rate


@dataclass(frozen=True, eq=False, kw_only=True)
class EqualPieces(Pieces):
    """Pieces of one width; epochs are from `least` to `most` seconds after start."""

    least: float
    most: float

    @property
    def width(self) -> float:
        """The length of a piece, s."""
        return float(self.widths[0])

    def _fill(self, hi, lo, base_hi, base_lo, piece, x):
        count, least, most = len(self.records), self.least, self.most
        return chebyshev.place_equal(
            hi, lo, base_hi, base_lo, least, most, self.width, count, piece, x
        )


@dataclass(frozen=True, eq=False, kw_only=True)
class CellPieces(Pieces):
    """Pieces that each fill one or more cells of a width, s: short where the motion is quick."""

    width: float
    cells: NDArray[np.int32]  # the piece of each
    starts: FloatArray  # of pieces, s
    most: float  # the end of the range, s

    def _fill(self, hi, lo, base_hi, base_lo, piece, x):
        cells, starts, widths, most = self.cells, self.starts, self.widths, self.most
        return chebyshev.place_cells(
            hi, lo, base_hi, base_lo, 0.0, most, self.width, cells, starts, widths, piece, x
        )


@dataclass(frozen=True, eq=False, kw_only=True)
class KnotPieces(Pieces):
    """Pieces between knots (pieces + 1,), seconds after start in two doubles: rows of a table."""

    knots: FloatArray
    knots_low: FloatArray

    def _fill(self, hi, lo, base_hi, base_lo, piece, x):
        knots, low = self.knots, self.knots_low
        return chebyshev.place_knots(hi, lo, base_hi, base_lo, knots, low, piece, x)


class PiecewisePath(Path):
    """The base of paths by polynomials, which replace `_placed` where pieces need a check."""

    pieces: Pieces

    def _placed(self, instant, hi, lo):
        """Numbers of the pieces (N,) of the epochs, and coordinates in them (N,)."""
        return self.pieces.place(self, instant, hi, lo)

    def _position(self, instant, hi, lo):
        return self.pieces.values(*self._placed(instant, hi, lo))

    def _state(self, instant, hi, lo):
        return self.pieces.values_and_rates(*self._placed(instant, hi, lo))


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
class Compressed(PiecewisePath):
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
        pieces = self.pieces
        # SIMD reads eight successive doubles: a view of every second epoch is copied.
        hi, lo = read_only(np.ascontiguousarray(hi)), read_only(np.ascontiguousarray(lo))
        base_hi, base_lo = since(instant, pieces.start)
        for begin in range(0, hi.size, _BATCH):
            end = min(begin + _BATCH, hi.size)
            outside = chebyshev.directions(
                hi,
                lo,
                base_hi,
                base_lo,
                pieces.most,
                pieces.width,
                pieces.cells,
                pieces.starts,
                pieces.widths,
                pieces.records,
                self._rows,
                pieces.count,
                sign,
                begin,
                end,
                unit,
                length,
            )
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
    if not isinstance(path, Path):
        raise AttitudeError(
            f"path is {validation.shown(path)}; give one with positions, of attitude.paths."
        )
    first, last = _inputs.instant(start, "start"), _inputs.instant(stop, "stop")
    limit = validation.positive(tolerance, "tolerance", unit="m")
    length = float(sum(since(last, first)))
    if not length > 0.0:
        raise AttitudeError(
            f"start is {spelled(first)} and stop is {spelled(last)}; start must be before stop."
        )
    fit = _halved(path, first, length, limit)
    depth = max(level for level, *_ in fit)
    # Pieces in the order of time; their numbers are scaled to count the finest cells.
    fit.sort(key=lambda piece: piece[1] << (depth - piece[0]))
    levels, _, records, errors, speed_errors = zip(*fit, strict=True)
    pieces = CellPieces(
        start=first,
        width=length / 2**depth,
        cells=np.repeat(np.arange(len(fit), dtype=np.int32), 1 << (depth - np.array(levels))),
        # The same doubles from which the epochs of the samples were computed.
        starts=np.array([number * (length / 2**level) for level, number, *_ in fit]),
        widths=length / 2.0 ** np.array(levels),
        records=np.array(records),
        count=_COUNT,
        most=length,
    )
    return Compressed(
        pieces=pieces,
        error=max(errors),
        speed_error=max(speed_errors),
        tolerance=limit,
        name=path.name,
        center=path.center,
        source=f"{path.source}, compressed to {limit:g} m",
        span=(first, last),
    )


def _halved(path, start, length, tolerance):
    """Pieces (level, number, record, error, speed error), each within the tolerance."""
    pieces, remaining, level = [], np.zeros(1, dtype=np.int64), 0
    while remaining.size:
        if level > _DEEPEST or len(pieces) + remaining.size > _MOST_PIECES:
            raise AttitudeError(
                f"{path.name} still errs by more than {tolerance:g} m in pieces of "
                f"{length / 2**level:.3g} s; allow a larger tolerance or give a shorter span, or "
                "a smoother path."
            )
        for numbers, *columns in _fit(path, start, level, remaining, length, tolerance):
            needed = np.isin(numbers, remaining)
            rows, errors, speeds, limits = (column[needed] for column in columns)
            good = errors <= limits
            columns = (column[good] for column in (remaining, rows, errors, speeds))
            pieces += [
                (level, int(number), row, float(error), float(speed))
                for number, row, error, speed in zip(*columns, strict=True)
            ]
            remaining, level = _halves(remaining[~good]), level + 1
            if not remaining.size:
                break
    return pieces


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
