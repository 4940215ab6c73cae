"""A table of positions, with or without velocities, interpolated."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from attitude import frames
from attitude._solver import chebyshev
from attitude._support import pairs, validation
from attitude.epochs import _inputs
from attitude.errors import AttitudeError
from attitude.frames import _earth
from attitude.paths._compressed import KnotPieces, PiecewisePath
from attitude.paths._path import Path, known_center, spelled

if TYPE_CHECKING:
    from attitude._support.annotations import Epoch, Epochs, FloatArray, Reals
    from attitude.epochs._instants import Instant


# ---- Polynomials through the rows of a table: Lagrange's, and Hermite's where velocities are given
# The polynomial between two rows passes through the nearest rows on both sides, as in the
# interpolation of CCSDS messages and of SPICE's types 8, 9, 12 and 13; near the ends of the table
# the window is that of the last rows.  All intervals are fitted at once, to Chebyshev coefficients
# of the interval, so that an epoch costs one short recurrence.
#
# Source: Newton's divided differences with repeated nodes (Stoer & Bulirsch, section 2.1.5).


# The greatest degree.
MOST_DEGREE: int = 31
# m and m/s: a thousand times the universe, and squares of it are finite.
_MOST = 1e30
# Of the longest distance of two rows over the shortest: rounded nodes of a polynomial through both
# would coincide beyond.
_UNEVEN = 1e15


def refuse_uneven(steps: FloatArray, name: str) -> None:
    """AttitudeError for distances of rows (N,), s, that no polynomial can pass through."""
    if len(steps) and steps.max() > _UNEVEN * steps.min():
        raise AttitudeError(
            f"rows of {name} lie {steps.min():.3g} s to {steps.max():.3g} s apart, of which one "
            f"is more than {_UNEVEN:g} times the other; leave out rows."
        )


def _interval_polynomials(knots, knots_low, values, rates, degree):
    """Chebyshev coefficients between rows at knots (N,) s, of values and rates (N, 3)."""
    window = rows_needed(degree, rates is not None)
    first = np.arange(len(knots) - 1) - (window - 1) // 2
    rows = np.clip(first, 0, len(knots) - window) + np.arange(window)[:, None]
    width = np.diff(knots) + np.diff(knots_low)
    # Time from the start of the interval in units of its length.
    nodes = ((knots[rows] - knots[:-1]) + (knots_low[rows] - knots_low[:-1])) / width
    # Differences from the value at the start: the rounding errors of the divided differences are
    # then relative to these, not to the size of the orbit.
    start = values[:-1]
    slopes = None if rates is None else rates[rows] * width[:, None]
    newton = newton_form(nodes, values[rows] - start, slopes)
    x = 0.5 * (chebyshev.nodes(degree + 1) + 1.0)
    table = chebyshev.coefficients(np.stack([newton_values(*newton, at)[0] for at in x]))
    table[0] += start
    return np.ascontiguousarray(table.transpose(1, 2, 0)).reshape(len(width), -1)


def rows_needed(degree: int, with_rates: bool) -> int:
    """The count of rows that a polynomial of a degree passes through."""
    return (degree + 1) // 2 if with_rates else degree + 1


def settled_degree(degree: int, rows: int, with_rates: bool) -> int:
    """The degree of polynomials through two rows or more, from that requested.

    It is reduced to what the rows allow.  Hermite's is odd, and that of two rows, 3, at least:
    through one row it would extrapolate to the next.
    """
    degree = validation.count(degree, "the interpolation degree", most=MOST_DEGREE)
    if with_rates:
        return 2 * min(max((degree + 1) // 2, 2), rows) - 1
    return min(degree, rows - 1)


def newton_form(
    nodes: FloatArray, values: FloatArray, slopes: FloatArray | None = None
) -> tuple[FloatArray, FloatArray]:
    """The nodes (K, N) and coefficients (K, N, C) of Newton's form of N polynomials through values,
    and slopes, (W, N, C) at nodes (W, N or 1); K is W, or 2 W with slopes: each node twice.
    """
    if slopes is not None:
        nodes, values, slopes = (np.repeat(array, 2, axis=0) for array in (nodes, values, slopes))
    table = np.array(values)
    for order in range(1, len(nodes)):
        gap = (nodes[order:] - nodes[:-order])[..., None]
        change = table[order:] - table[order - 1 : -1]
        if order == 1 and slopes is not None:
            change[::2] = slopes[::2]
            change[1::2] /= gap[1::2]
        else:
            change /= gap
        table[order:] = change
    return nodes, table


def newton_values(
    nodes: FloatArray, coefficients: FloatArray, x: Reals, order: int = 0
) -> list[FloatArray]:
    """Values (N, C) of Newton's form at x, a number or (N,), and its derivatives up to `order`."""
    p = coefficients[-1]
    dp = ddp = 0.0 * p
    for node, coefficient in zip(nodes[-2::-1], coefficients[-2::-1], strict=True):
        ahead = (x - node)[:, None]
        if order > 1:
            ddp = ddp * ahead + 2.0 * dp
        if order:
            dp = dp * ahead + p
        p = p * ahead + coefficient
    return [p, dp, ddp][: order + 1]


INTERPOLATIONS: tuple[str, ...] = ("lagrange", "hermite")
# Axes beside `frames.FRAMES`.
_OF_EARTH = ("b1950", *dict.fromkeys(_earth.TURNING_NAMES.values()))


@dataclass(frozen=True, eq=False, repr=False)
class TabulatedPath(PiecewisePath):
    """An interpolated table; `rates` are polynomials of the velocities alone.  Made by `table`."""

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
        return super()._placed(instant, hi, lo)

    def _state(self, instant, hi, lo):
        if self.rates is None:
            return super()._state(instant, hi, lo)
        piece, x = self._placed(instant, hi, lo)
        return self.pieces.values(piece, x), self.rates.values(piece, x)


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
    span: tuple[Epoch, Epoch] | None = None,
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
        Degree of the polynomials: 7 uses 4 rows for Hermite's, 8 for Lagrange's, half on each side
        of an epoch.  Reduced if there are too few rows; Hermite's to an odd one, 3 at least.
    center : Path, str or int
        A path, or a body by name or NAIF number.
    frame : str
        Axes of the numbers: one of `frames.FRAMES`, "b1950", or axes of the Earth: "itrf", "teme",
        "tod", "mod", "gtod", "cirs", "tirs".  Velocities are those seen from Earth-fixed axes.
    name, source : str
        See `Path`.
    span : (epoch, epoch), optional
        First and last epoch of the path, by default and at most those of the table.

    Raises
    ------
    AttitudeError
        For a single row, rows that are not finite, above 1e30 m or 1e30 m/s, or not ascending, a
        span that has no time in common with them, other shapes and units.
    """
    r = validation.real(positions, "positions", shape=(..., 3), unit="m")
    if r.ndim != 2:
        raise AttitudeError(f"positions have shape {r.shape}; give (N, 3).")
    v = None
    if velocities is not None:
        v = validation.real(velocities, "velocities", shape=r.shape, unit="m/s")
    for values, unit in ((r, "m"), (v, "m/s")):
        if values is not None and np.abs(values).max(initial=0.0) > _MOST:
            raise AttitudeError(
                f"a row has {np.abs(values).max():.3g} {unit}; give at most {_MOST:g} {unit}."
            )
    first, knots, low = _knots(times, start, len(r))
    method, degree = _method(interpolation, degree, v is not None, len(knots))
    kind = frames.known(frame, more=_OF_EARTH)
    if kind in _OF_EARTH:
        at = pairs.add((knots, low), first.seconds, first.low)
        r, v = _earth.vectors_to_icrf(kind, *at, r, v)
    elif kind not in ("icrf", "gcrf"):
        matrix = frames.matrix_to_icrf(kind)
        r = r @ matrix.T
        v = None if v is None else v @ matrix.T

    def polynomials(rows, slopes):
        return KnotPieces(
            start=first,
            widths=np.diff(knots) + np.diff(low),
            records=_interval_polynomials(knots, low, rows, slopes, degree),
            count=degree + 1,
            knots=knots,
            knots_low=low,
        )

    separate = method == "lagrange" and v is not None
    return TabulatedPath(
        pieces=polynomials(r, v if method == "hermite" else None),
        rates=polynomials(v, None) if separate else None,
        interpolation=method,
        degree=degree,
        name=name,
        center=known_center(center),
        source=source,
        span=_span(span, first.after(knots[0], low[0]), first.after(knots[-1], low[-1])),
    )


def _span(span, first, last):
    """The span of a table from its first to its last row, or a shorter one."""
    if span is None:
        return first, last
    if not isinstance(span, (tuple, list)) or len(span) != 2:
        raise AttitudeError(f"span is {validation.shown(span)}; give its first and last epoch.")
    begin, end = (_inputs.instant(epoch, "span") for epoch in span)
    begin = begin if begin.since(first) > 0.0 else first
    end = end if end.since(last) < 0.0 else last
    if end.since(begin) < 0.0:
        raise AttitudeError(
            f"the span {spelled(begin)} to {spelled(end)} ends before it begins, or is not within "
            f"the rows, from {spelled(first)} to {spelled(last)}; give one that is."
        )
    return begin, end


def _knots(times, start, count):
    """The instant `start`, and the seconds (N,) from it to the rows in two doubles."""
    if start is None:
        start = _first_epoch(times)
    start = _inputs.instant(start, "start")
    seconds = _inputs.seconds_since(start, times, name="times").mapped(np.array)
    hi, lo = seconds.hi, seconds.low
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
    refuse_uneven(order, "times")
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
    if rows < 2:
        raise AttitudeError("a table of one row covers no time; give two rows or more.")
    return interpolation, settled_degree(degree, rows, interpolation == "hermite")
