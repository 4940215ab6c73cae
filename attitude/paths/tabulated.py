"""A table of positions, with or without velocities, interpolated."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from attitude import epochs, frames, pairs, validation
from attitude.errors import AttitudeError
from attitude.paths.path import Path, spelled
from attitude.paths.pieces import KnotPieces, placed, values, values_and_rates
from attitude.paths.table_polynomials import interval_polynomials, rows_needed
from attitude.paths.uniform import known_center

if TYPE_CHECKING:
    from attitude.annotations import Epoch, Epochs, Reals
    from attitude.epochs.instants import Instant

INTERPOLATIONS: tuple[str, ...] = ("lagrange", "hermite")
_HIGHEST_DEGREE = 31


@dataclass(frozen=True, eq=False, repr=False)
class TabulatedPath(Path):
    """An interpolated table.  Made by `table`; CCSDS files are read by `oem`.

    Attributes
    ----------
    pieces : KnotPieces
        The polynomial of each interval.
    rates : KnotPieces or None
        Polynomials of the velocities, if these are interpolated on their own.
    interpolation : str
        "lagrange" or "hermite".
    degree : int
        Degree of the polynomials.
    name, center, source, span
        As for all paths.
    """

    pieces: KnotPieces
    rates: KnotPieces | None
    interpolation: str
    degree: int
    name: str
    center: str | Path
    source: str
    span: tuple[Instant, Instant]

    def _placed(self, instant, hi, lo):
        self.check_span(instant, hi, lo)
        return placed(self, instant, hi, lo)

    def _position(self, instant, hi, lo):
        return values(self.pieces, *self._placed(instant, hi, lo))

    def _state(self, instant, hi, lo):
        where = self._placed(instant, hi, lo)
        if self.rates is None:
            return values_and_rates(self.pieces, *where)
        return values(self.pieces, *where), values(self.rates, *where)


def table(
    times: Epochs,
    positions: Reals,
    velocities: Reals | None = None,
    *,
    start: Epoch | None = None,
    interpolation: str | None = None,
    degree: int = 7,
    center: Path | str | int = "ssb",
    frame: str = "icrf",
    name: str = "table",
    source: str = "table",
    span: tuple[Instant, Instant] | None = None,
) -> TabulatedPath:
    """The path through a table of positions.

    Parameters
    ----------
    times : (N,) epochs of any kind that `epochs.seconds_since` takes
        Ascending.  Plain numbers are TDB seconds since `start`.
    positions, velocities : (N, 3) array_like or Quantity
        m and m/s.
    start : anything that `epochs.instant` takes
        Required if times are plain numbers.
    interpolation : "hermite" or "lagrange"
        Hermite's polynomials pass through positions and velocities; Lagrange's through positions,
        and separate ones through the velocities, if given.  The default is "hermite" with
        velocities, "lagrange" without.
    degree : int
        Degree of the polynomials, odd for Hermite's: 7 uses 4 rows for Hermite's, 8 for
        Lagrange's, half on each side of an epoch.
    center : Path, str or int
        A path, or a body by name or NAIF number.
    frame : str
        Axes of the numbers, one of `frames.FRAMES`.
    name, source : str
        See `Path`.
    span : (Instant, Instant), optional
        Span of the path, within the table; the whole table, if not given.

    Raises
    ------
    AttitudeError
        For too few rows, rows that are not finite or not ascending, other shapes and units.
    """
    r = validation.real(positions, "positions", shape=(..., 3), unit="m")
    if r.ndim != 2:
        raise AttitudeError(f"positions have shape {r.shape}; give (N, 3).")
    v = None
    if velocities is not None:
        v = validation.real(velocities, "velocities", shape=r.shape, unit="m/s")
    first, knots, low = _knots(times, start, len(r))
    method, degree = _method(interpolation, degree, v is not None, len(knots))
    matrix = frames.matrix_to_icrf(frame)
    if frames.known(frame) not in ("icrf", "gcrf"):
        r = r @ matrix.T
        v = None if v is None else v @ matrix.T

    def polynomials(rows, slopes):
        records = interval_polynomials(knots, low, rows, slopes, degree)
        return KnotPieces(first, knots, low, records, degree + 1)

    separate = method == "lagrange" and v is not None
    return TabulatedPath(
        pieces=polynomials(r, v if method == "hermite" else None),
        rates=polynomials(v, None) if separate else None,
        interpolation=method,
        degree=degree,
        name=name,
        center=known_center(center),
        source=source,
        span=span or (first.after(knots[0], low[0]), first.after(knots[-1], low[-1])),
    )


def _knots(times, start, count):
    """The instant `start`, and the seconds (N,) from it to the rows in two doubles."""
    if start is None:
        start = _first_epoch(times)
    start = epochs.instant(start, "start")
    hi, lo = epochs.seconds_since(start, times, name="times")
    hi = np.array(hi)
    lo = np.zeros_like(hi) if lo is None else np.array(lo)
    if hi.shape != (count,):
        raise AttitudeError(f"times have shape {hi.shape}, but there are {count} positions.")
    if not np.isfinite(hi + lo).all():
        raise AttitudeError("times hold NaN or masked entries; leave out these rows.")
    order = (hi[1:] - hi[:-1]) + (lo[1:] - lo[:-1])
    if (order <= 0.0).any():
        row = int(np.argmax(order <= 0.0))
        raise AttitudeError(
            f"times must ascend, but row {row + 1} ({spelled(start.after(hi[row + 1]))}) is not "
            f"later than row {row} ({spelled(start.after(hi[row]))}); sort them and leave out "
            "repeated ones."
        )
    return start, *pairs.two_sum(hi, lo)


def _first_epoch(times):
    """The first of some epochs, which must not be a plain number."""
    first = times
    while isinstance(first, (list, tuple, np.ndarray)) and np.size(first) and np.ndim(first):
        first = first[0]
    if getattr(first, "shape", ()) != () and hasattr(first, "__getitem__"):
        first = first[0]
    if isinstance(first, (int, float, np.integer, np.floating)):
        raise AttitudeError("times are plain seconds; give start, the epoch of zero seconds.")
    return first


def _method(interpolation, degree, with_rates, rows):
    """The checked interpolation and degree for a count of rows."""
    if interpolation is None:
        interpolation = "hermite" if with_rates else "lagrange"
    interpolation = validation.one_of(
        interpolation.lower() if isinstance(interpolation, str) else interpolation,
        "interpolation",
        INTERPOLATIONS,
    )
    if interpolation == "hermite" and not with_rates:
        raise AttitudeError('"hermite" needs velocities; give velocities, or "lagrange".')
    whole = isinstance(degree, (int, np.integer)) and not isinstance(degree, bool)
    if not whole or not 1 <= degree <= _HIGHEST_DEGREE:
        raise AttitudeError(
            f"degree is {degree!r}; it must be a whole number from 1 to {_HIGHEST_DEGREE}."
        )
    if interpolation == "hermite" and degree % 2 == 0:
        raise AttitudeError(
            f"degree is {degree}; Hermite polynomials through positions and velocities are of odd "
            f"degree: give {degree - 1} or {degree + 1}."
        )
    needed = rows_needed(degree, interpolation == "hermite")
    if rows < max(needed, 2):
        raise AttitudeError(
            f"{rows} rows are too few for {interpolation} polynomials of degree {degree}, which "
            f"need {max(needed, 2)}; give more, or a lower degree."
        )
    return interpolation, int(degree)
