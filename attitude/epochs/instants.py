"""One epoch: TDB seconds past J2000 in two doubles."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, SupportsFloat

import numpy as np

from attitude import pairs
from attitude.epochs import text, time_scales

if TYPE_CHECKING:
    from astropy.time import Time
    from numpy.typing import ArrayLike


@dataclass(frozen=True, init=False, repr=False)
class Instant:
    """One epoch: TDB seconds past J2000 (2000-01-01 12:00 TDB) as the sum of two doubles.

    Two instants are equal when both doubles are; the same date given in two ways can differ in
    `low` by 5e-12 s, the rounding of a double of days (astropy, skyfield).

    Parameters
    ----------
    seconds, low : float
        s; their sum is the epoch.

    Attributes
    ----------
    seconds, low : float
        s; the sum rounded to a double, and the rounding error.

    >>> from attitude.epochs import instant
    >>> instant("2016-12-31T23:59:60.5")
    Instant(2016-12-31T23:59:60.5 UTC)
    >>> instant("2026-01-01T00:00:00 TDB").seconds
    820497600.0
    """

    seconds: float
    low: float

    def __init__(self, seconds: SupportsFloat, low: SupportsFloat = 0.0) -> None:
        hi, lo = pairs.two_sum(float(seconds), float(low))
        object.__setattr__(self, "seconds", float(hi))
        object.__setattr__(self, "low", float(lo))

    @property
    def time(self) -> Time:
        """The epoch as an astropy Time in TDB, rounded to 5e-12 s."""
        return times(self, np.float64(0.0))

    @property
    def utc_iso(self) -> str:
        """ISO 8601 text in UTC, to the nanosecond, without trailing zeros of the fraction."""
        tt = time_scales.tt_from_tdb(np.float64(self.seconds), np.float64(self.low))
        tai = pairs.add(tt, -time_scales.TT_MINUS_TAI)
        return text.utc_text(*map(float, time_scales.utc_day_from_tai(*tai)))

    def since(self, other: Instant) -> float:
        """TDB seconds from another Instant to this one, rounded to a double."""
        return (self.seconds - other.seconds) + (self.low - other.low)

    def after(self, seconds: SupportsFloat, low: SupportsFloat = 0.0) -> Instant:
        """The instant that is seconds + low of TDB later."""
        hi, lo = pairs.add((self.seconds, self.low), float(seconds), float(low))
        return Instant(hi, lo)

    def __repr__(self) -> str:
        return f"Instant({self.utc_iso} UTC)"

    __str__ = __repr__


def times(start: Instant, seconds: ArrayLike, low: ArrayLike | None = None) -> Time:
    """The epochs start + seconds + low as an astropy Time in TDB, rounded to 5e-12 s.

    Parameters
    ----------
    start : Instant
    seconds, low : float64 arrays of one shape
        TDB seconds, as `seconds_since` returns them.  A Time cannot hold NaN: such entries are
        masked.
    """
    from astropy.time import Time

    seconds = np.asarray(seconds, dtype=np.float64)
    rest = np.float64(0.0) if low is None else np.asarray(low, dtype=np.float64)
    unknown = ~np.isfinite(seconds + rest)
    hi, lo = pairs.two_sum(np.where(unknown, 0.0, seconds), np.where(unknown, 0.0, rest))
    hi, lo = pairs.add((hi, lo), start.seconds, start.low)
    time = Time(*time_scales.jd_from_seconds(hi, lo), format="jd", scale="tdb")
    if np.any(unknown):
        time[unknown] = np.ma.masked
    return time
