"""A table of positions, with or without velocities, interpolated."""

from dataclasses import dataclass

import numpy as np

from attitude import epochs, frames, pairs, validation
from attitude.errors import AttitudeError
from attitude.paths.path import Path, spelled
from attitude.paths.pieces import KnotPieces, placed, values, values_and_rates
from attitude.paths.table_polynomials import interval_polynomials, rows_needed
from attitude.paths.uniform import known_center

INTERPOLATIONS = ("lagrange", "hermite")
_HIGHEST_DEGREE = 31


@dataclass(frozen=True, eq=False, repr=False)
class Table(Path):
    """An interpolated table.  Made by `table`; CCSDS files are read by `oem`.

    Attributes
    ----------
    pieces : KnotPieces
        The polynomial of each interval.
    rates : KnotPieces or None
        Polynomials of the velocities, where these are interpolated apart.
    interpolation, degree : str and int
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
    span: tuple

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
    times,
    positions,
    velocities=None,
    *,
    start=None,
    interpolation=None,
    degree=7,
    center="ssb",
    frame="icrf",
    name="table",
    source="table",
    span=None,
):
    """The path through a table of positions.

    Parameters
    ----------
    times : (N,) epochs of any kind that `epochs.seconds_since` takes
        Ascending.  Plain numbers are TDB seconds since `start`.
    positions, velocities : (N, 3) array_like or Quantity
        m and m/s.
    start : anything that `epochs.instant` takes
        Needed where times are plain numbers.
    interpolation : "hermite" or "lagrange"
        Hermite's polynomials pass through positions and velocities; Lagrange's through positions,
        and others through the velocities, if there are any.  Hermite where there are velocities,
        if not given.
    degree : int
        Of the polynomials: 7 takes 4 rows of Hermite's, 8 of Lagrange's, half on each side of an
        epoch.  Hermite's are of odd degree.
    center : Path, str or int
    frame : str
        Axes of the numbers, one of `frames.FRAMES`.
    name, source : str
    span : (Instant, Instant), optional
        A part of the table that may be asked for; all of it, if not given.

    Raises
    ------
    AttitudeError
        For rows too few, not finite or not ascending, and for other shapes and units.
    """
    positions = validation.real(positions, "positions", shape=(..., 3), unit="m")
    if positions.ndim != 2:
        raise AttitudeError(f"positions have shape {positions.shape}; give (N, 3).")
    if velocities is not None:
        velocities = validation.real(velocities, "velocities", shape=positions.shape, unit="m/s")
    start, knots, low = _knots(times, start, len(positions))
    interpolation, degree = _method(interpolation, degree, velocities is not None, len(knots))
    matrix = frames.matrix_to_icrf(frame)
    if frames.known(frame) not in ("icrf", "gcrf"):
        positions = positions @ matrix.T
        velocities = None if velocities is None else velocities @ matrix.T
    given = knots, low

    def polynomials(rows, slopes):
        records = interval_polynomials(*given, rows, slopes, degree)
        return KnotPieces(start, *given, records, degree + 1)

    apart = interpolation == "lagrange" and velocities is not None
    return Table(
        pieces=polynomials(positions, velocities if interpolation == "hermite" else None),
        rates=polynomials(velocities, None) if apart else None,
        interpolation=interpolation,
        degree=degree,
        name=name,
        center=known_center(center),
        source=source,
        span=span or tuple(start.after(knots[k], low[k]) for k in (0, -1)),
    )


def _knots(times, start, count):
    """An instant, and seconds from it in two arrays."""
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
            f"later than row {row} ({spelled(start.after(hi[row]))}); sort them and leave out what "
            "is twice there."
        )
    return start, *pairs.two_sum(hi, lo)


def _first_epoch(times):
    first = times
    while isinstance(first, (list, tuple, np.ndarray)) and np.size(first) and np.ndim(first):
        first = first[0]
    if getattr(first, "shape", ()) != () and hasattr(first, "__getitem__"):
        first = first[0]
    if isinstance(first, (int, float, np.integer, np.floating)):
        raise AttitudeError("times are plain seconds; give start, the epoch they are counted from.")
    return first


def _method(interpolation, degree, with_rates, rows):
    if interpolation is None:
        interpolation = "hermite" if with_rates else "lagrange"
    interpolation = validation.one_of(
        interpolation.lower() if isinstance(interpolation, str) else interpolation,
        "interpolation",
        INTERPOLATIONS,
    )
    if interpolation == "hermite" and not with_rates:
        raise AttitudeError('"hermite" needs velocities; give them, or take "lagrange".')
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
