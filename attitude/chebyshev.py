"""Smooth functions of time as Chebyshev polynomials on equal pieces of a span, with their error.

The series of a time scale difference and the position of a body in an ephemeris take microseconds
an epoch.  Both are smooth: a polynomial per piece takes tens of nanoseconds, to a measured error.

The functions work on one piece, -1 <= x <= 1; `Pieces` joins equal pieces over a span of time.

Source: Press et al., Numerical Recipes (2007), section 5.8: the discrete orthogonality of the
Chebyshev polynomials on their zeros, and Clenshaw's recurrence.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from attitude import validation
from attitude.errors import AttitudeError

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import ArrayLike, NDArray

    from attitude.annotations import FloatArray, Real

# So many epochs are evaluated together: the four arrays of a recurrence stay in cache.
_CHUNK = 4096
# 65536 pieces of degree 15 are some 8 MB for a scalar and a few seconds of fitting.
_MOST_PIECES = 65536
# More pieces do not improve a fit whose error is below this many roundings of the largest value.
_ROUNDINGS = 32.0


def nodes(count: int) -> FloatArray:
    """The zeros of the Chebyshev polynomial T_count, shape (count,), from near 1 to near -1."""
    return np.cos(np.pi * (np.arange(count) + 0.5) / count)


def coefficients(values: ArrayLike) -> FloatArray:
    """The Chebyshev coefficients of the polynomial through values at the nodes.

    Parameters
    ----------
    values : (count, ...) array
        Function values at ``nodes(count)`` along the first axis.

    Returns
    -------
    (count, ...) array
        Coefficients of T_0 ... T_{count-1} along the first axis.
    """
    values = np.asarray(values, dtype=np.float64)
    count = len(values)
    order = np.arange(count)
    waves = np.cos(np.pi * order[:, None] * (order + 0.5) / count)
    waves *= np.where(order == 0, 1.0, 2.0)[:, None] / count
    # Node by node: a product of matrices rounds otherwise where more columns are given with one.
    table = np.zeros_like(values)
    for k in range(count):
        table += waves[:, k].reshape(count, *(1,) * (values.ndim - 1)) * values[k]
    return table


def evaluate(table: FloatArray, piece: NDArray[np.integer[Any]], x: FloatArray) -> FloatArray:
    """Values at N epochs of the polynomials of their pieces, by Clenshaw's recurrence.

    Parameters
    ----------
    table : (degree + 1, ..., pieces) array
        Coefficients; the axes between are those of a vector-valued function.
    piece : (N,) integer array
        The number of each epoch's piece.
    x : (N,) array
        The epoch's place in its piece, from -1 to 1; NaN gives NaN.

    Returns
    -------
    (..., N) array
        To about 4 eps of the sum of the absolute coefficients.
    """
    out = np.empty((*table.shape[1:-1], len(x)))
    for start in range(0, len(x), _CHUNK):
        part = slice(start, start + _CHUNK)
        out[..., part] = _clenshaw(table, piece[part], x[part])
    return out


def _clenshaw(table, piece, x):
    twice = x + x
    last = np.zeros((*table.shape[1:-1], len(x)))
    before = np.zeros_like(last)
    for order in range(len(table) - 1, 0, -1):
        new = last * twice
        new -= before
        new += table[order].take(piece, axis=-1)
        before, last = last, new
    return last * x - before + table[0].take(piece, axis=-1)


@dataclass(frozen=True, eq=False)
class Pieces:
    """A function of time on a span, as equal Chebyshev pieces.  Made by `Pieces.fit`.

    Attributes
    ----------
    start, width : float
        The start of the first piece and the length of each, in the unit of the function's time.
    table : (degree + 1, ..., pieces) array, read-only
        Coefficients, as `evaluate` takes them.
    error : float
        The largest absolute error of any component, measured between the nodes of every piece.

    >>> path = Pieces.fit(lambda t: np.stack([np.cos(t), np.sin(t)], axis=-1), 0.0, 100.0, 1e-12)
    >>> path(np.linspace(0.0, 100.0, 7)).shape, path.error < 1e-12
    ((7, 2), True)
    """

    start: float
    width: float
    table: FloatArray
    error: float

    def __post_init__(self) -> None:
        self.table.setflags(write=False)

    def __reduce__(self) -> tuple[Any, ...]:
        # numpy loads arrays from a pickle as writable; __init__ makes them read-only again.
        return Pieces, (self.start, self.width, self.table, self.error)

    @property
    def stop(self) -> float:
        """The end of the last piece, in the unit of the function's time."""
        return self.start + self.width * self.table.shape[-1]

    @classmethod
    def fit(
        cls,
        function: Callable[[FloatArray], ArrayLike],
        start: Real,
        stop: Real,
        tolerance: Real,
        *,
        degree: int = 15,
    ) -> Pieces:
        """Fit a function with 1, 2, 4, ... pieces, until the tolerance is reached.

        Parameters
        ----------
        function : callable
            Takes times (N,), returns values (N, ...); called once for each doubling.  It must be
            smooth on the span: a feature between all samples is missed.  Samples are taken at
            times in one double, which limits the resolution of time: 1e-7 s at 1e9 s.
        start, stop : float
            The span, start < stop.
        tolerance : float
            Largest absolute error of any component, in the unit of the function.  It is measured
            at the degree + 2 extrema of T_{degree+1} of each piece, where the error of an
            interpolation at the zeros is largest; both ends are among them.
        degree : int
            Degree of the polynomials.

        Raises
        ------
        AttitudeError
            When the values are not finite or no number of pieces reaches the tolerance.
        """
        start, stop = validation.number(start, "start"), validation.number(stop, "stop")
        tolerance = validation.positive(tolerance, "tolerance")
        if not start < stop:
            raise AttitudeError(f"start is {start!r} and stop is {stop!r}; start must be less.")
        count = 1
        while count <= _MOST_PIECES:
            width = (stop - start) / count
            table, error, size = _fit_equal(function, start, width, count, degree)
            if error <= tolerance:
                return cls(start, width, table, error)
            if not np.isfinite(error):
                raise AttitudeError(
                    f"the function to be fitted from {start!r} to {stop!r} is not finite there; "
                    "give a span on which it is."
                )
            if error <= _ROUNDINGS * np.finfo(np.float64).eps * size:
                break
            count *= 2
        raise AttitudeError(
            f"the fit errs by {error:.2g} with {min(count, _MOST_PIECES)} pieces, above the "
            f"tolerance of {tolerance:.2g}; allow a larger tolerance, or give a shorter span or a "
            "smoother function."
        )

    def __call__(self, t: ArrayLike, low: ArrayLike = 0.0) -> FloatArray:
        """Values (N..., ...) at times t + low of shape (N...,); NaN gives NaN.

        Parameters
        ----------
        t, low : array_like
            Times in two doubles, from start to stop, in the unit of the fit.

        Raises
        ------
        AttitudeError
            For a time outside of the span.
        """
        t, low = np.asarray(t, dtype=np.float64), np.asarray(low, dtype=np.float64)
        since, low = np.broadcast_arrays(t - self.start, low)
        flat = (since + low).ravel()
        pieces = self.table.shape[-1]
        known = np.where(np.isnan(flat), 0.0, flat)
        if np.any((known < 0.0) | (known > self.width * pieces)):
            raise AttitudeError(
                f"a time lies outside of the span that was fitted, {self.start!r} to "
                f"{self.stop!r}; fit a longer span or omit that time."
            )
        # The end of the span belongs to the last piece.
        piece = np.minimum((known / self.width).astype(np.intp), pieces - 1)
        # low is added after the start of the piece is subtracted: before, it would be rounded off.
        x = 2.0 * (((since.ravel() - piece * self.width) + low.ravel()) / self.width) - 1.0
        values = evaluate(self.table, piece, x)
        return np.moveaxis(values, -1, 0).reshape(since.shape + values.shape[:-1])


def _fit_equal(function, start, width, count, degree):
    """Table, largest error and largest value of a fit with `count` equal pieces."""
    size = degree + 1
    extrema = np.cos(np.pi * np.arange(size + 1) / size)
    x = np.concatenate([nodes(size), extrema])
    times = start + width * (np.arange(count) + 0.5 * (x[:, None] + 1.0))
    # start + width * count can round past the end of the span; the function may end there.
    times = np.clip(times, start, start + width * count)
    values = np.asarray(function(times.ravel()), dtype=np.float64)
    values = values.reshape(len(x), count, *values.shape[1:])
    values = np.moveaxis(values, 1, -1)
    table = np.ascontiguousarray(coefficients(values[:size]))
    error = 0.0
    every = np.arange(count)
    for row, exact in zip(extrema, values[size:], strict=True):
        fitted = _clenshaw(table, every, np.full(count, row))
        error = np.maximum(error, np.max(np.abs(fitted - exact)))
    return table, float(error), float(np.max(np.abs(values)))
