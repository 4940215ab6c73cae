"""Names for the types of public parameters and results; imported by type checkers only.

astropy and skyfield have no annotations, so that to type checkers their classes are Any, and a
parameter annotated with one of them would take any object.  Protocols stand for these classes.
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from datetime import date, timedelta
from typing import Any, Protocol, SupportsFloat, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray


class QuantityLike(Protocol):
    """An astropy Quantity."""

    @property
    def unit(self) -> Any:
        """The unit."""

    @property
    def value(self) -> Any:
        """The numbers in this unit."""


class TimeLike(Protocol):
    """An astropy Time or TimeDelta."""

    @property
    def jd1(self) -> Any:
        """Days, the first of two doubles."""

    @property
    def jd2(self) -> Any:
        """Days, the second of two doubles."""


class SkyfieldTimeLike(Protocol):
    """A skyfield Time."""

    @property
    def whole(self) -> Any:
        """Julian date of TT, the first of two doubles."""

    @property
    def tt_fraction(self) -> Any:
        """Days of TT, the second of two doubles."""


class InstantLike(Protocol):
    """An `attitude.epochs.Instant`."""

    @property
    def seconds(self) -> float:
        """TDB seconds past J2000, rounded to a double."""

    @property
    def low(self) -> float:
        """The rounding error of `seconds`, s."""


FloatArray: TypeAlias = NDArray[np.float64]
IntArray: TypeAlias = NDArray[np.int64]
BoolArray: TypeAlias = NDArray[np.bool_]

# One number: plain (SI units, radians), an astropy Quantity, or text such as "14.5 deg/day".
Real: TypeAlias = SupportsFloat | str | QuantityLike
# Several numbers, in the same ways.
Reals: TypeAlias = ArrayLike | Real | Sequence[Real]
# One epoch; one epoch or seconds since another; and several of either.
Epoch: TypeAlias = str | TimeLike | SkyfieldTimeLike | date | np.datetime64 | InstantLike
EpochOrSeconds: TypeAlias = Epoch | Real | timedelta | np.timedelta64
Epochs: TypeAlias = EpochOrSeconds | ArrayLike | Sequence[Any]
FilePath: TypeAlias = str | os.PathLike[str]
