"""A body of the series in astropy, evaluated by polynomials that are fitted when they are needed.

The series take 25 microseconds an epoch.  A polynomial of degree 15 for each 8 days that occur
errs by less than the series' own rounding, and takes some tens of nanoseconds.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from attitude import chebyshev
from attitude.immutable import read_only
from attitude.paths.path import Path, since
from attitude.paths.pieces import EqualPieces, placed, values, values_and_rates

if TYPE_CHECKING:
    from attitude.paths.astropy_body import AstropyBody

# Pieces of 8 days in the span of the series, 1900 to 2100, and coefficients of one.
_PIECES, _COUNT = 9131, 16
_LO = np.zeros(1)


class SeriesBody(Path):
    """The path of an `AstropyBody` with a span, by Chebyshev pieces.  Made by `built_in().step`.

    Attributes
    ----------
    series : AstropyBody
    name, center, source, span, roughness
        Those of the series.  Positions differ from it by up to its roughness, 0.1 m; velocities
        are the derivatives of the positions, from which those of plan94 differ by up to 26 m/s.
    """

    def __init__(self, series: AstropyBody) -> None:
        assert series.span is not None
        self.series = series
        self.name, self.center, self.source = series.name, series.center, series.source
        self.span, self.roughness = series.span, series.roughness
        length = sum(since(self.span[1], self.span[0]))
        # Zeros take no memory until a piece is written.
        self._records = np.zeros((_PIECES, 3 * _COUNT))
        self._is_fitted = np.zeros(_PIECES, dtype=bool)
        self.pieces = EqualPieces(
            start=self.span[0],
            width=length / _PIECES,
            records=read_only(self._records),
            skip=0,
            count=_COUNT,
            factor=1.0,
            least=0.0,
            most=length,
        )

    def __reduce__(self) -> tuple[Any, ...]:
        return SeriesBody, (self.series,)

    def _position(self, instant, hi, lo):
        return values(self.pieces, *self._placed(instant, hi, lo))

    def _state(self, instant, hi, lo):
        return values_and_rates(self.pieces, *self._placed(instant, hi, lo))

    def _placed(self, instant, hi, lo):
        """Numbers of the pieces (N,), which are fitted now if need be, and places in them (N,)."""
        piece, x = placed(self, instant, hi, lo)
        if not self._is_fitted[piece].all():
            # Threads that fit the same piece write the same numbers: no lock is needed.
            numbers = np.unique(piece)
            self._fit(numbers[~self._is_fitted[numbers]])
        return piece, x

    def _fit(self, numbers):
        width = self.pieces.width
        at = width * (numbers[:, None] + 0.5 * (chebyshev.nodes(_COUNT) + 1.0))
        position = self.series._position(self.pieces.start, at.ravel(), _LO)
        table = chebyshev.coefficients(position.reshape(3, *at.shape).transpose(2, 1, 0))
        self._records[numbers] = table.transpose(1, 2, 0).reshape(numbers.size, -1)
        self._is_fitted[numbers] = True
