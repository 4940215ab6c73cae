"""Names for the types of public parameters and results; imported by type checkers only."""

from __future__ import annotations

import os
from collections.abc import Sequence
from datetime import datetime, timedelta
from typing import Any, TypeAlias

import numpy as np
from astropy.time import Time, TimeDelta
from astropy.units import Quantity
from numpy.typing import ArrayLike, NDArray
from skyfield.timelib import Time as SkyfieldTime

from attitude.epochs.instants import Instant

FloatArray: TypeAlias = NDArray[np.float64]
IntArray: TypeAlias = NDArray[np.int64]
BoolArray: TypeAlias = NDArray[np.bool_]

# One number: plain (SI units, radians), an astropy Quantity, or text such as "14.5 deg/day".
Real: TypeAlias = float | str | Quantity
# Several numbers, in the same ways.
Reals: TypeAlias = ArrayLike | Quantity | Sequence[str | Quantity]
# One epoch, and one or several epochs or seconds since one.
Epoch: TypeAlias = str | Time | SkyfieldTime | datetime | np.datetime64 | Instant
Epochs: TypeAlias = (
    ArrayLike | Quantity | TimeDelta | timedelta | Epoch | Sequence[Epoch] | Sequence[Any]
)
FilePath: TypeAlias = str | os.PathLike[str]
