"""One moment: TDB seconds past J2000 in two doubles."""

from dataclasses import dataclass

import numpy as np

from attitude import pairs
from attitude.epochs import text, time_scales


@dataclass(frozen=True)
class Instant:
    """One epoch: TDB seconds past J2000 (2000-01-01 12:00 TDB) as the sum of two doubles.

    Two instants are equal when they are the same sum; the same date given in two ways can differ
    in `low` by the 5e-12 s that a double of days (astropy, skyfield) leaves open.

    >>> from attitude.epochs import instant
    >>> instant("2016-12-31T23:59:60.5")
    Instant(2016-12-31T23:59:60.5 UTC)
    >>> instant("2026-01-01T00:00:00 TDB").seconds
    820497600.0
    """

    seconds: float
    low: float = 0.0

    def __post_init__(self):
        hi, lo = pairs.two_sum(float(self.seconds), float(self.low))
        object.__setattr__(self, "seconds", float(hi))
        object.__setattr__(self, "low", float(lo))

    @property
    def time(self):
        """The same epoch as an astropy Time in TDB."""
        return times(self, np.float64(0.0))

    @property
    def utc_iso(self):
        """ISO text in UTC, to the nanosecond, without trailing zeros of the fraction."""
        tt = time_scales.tt_from_tdb(np.float64(self.seconds), np.float64(self.low))
        return text.utc_text(
            *time_scales.utc_day_from_tai(*pairs.add(tt, -time_scales.TT_MINUS_TAI))
        )

    def after(self, seconds, low=0.0):
        """The instant that is seconds + low of TDB later."""
        hi, lo = pairs.add((self.seconds, self.low), float(seconds), float(low))
        return Instant(hi, lo)

    def __repr__(self):
        return f"Instant({self.utc_iso} UTC)"

    __str__ = __repr__


def times(start, seconds, low=None):
    """The epochs start + seconds + low as an astropy Time in TDB, rounded to 5e-12 s.

    Parameters
    ----------
    start : Instant
    seconds, low : float64 arrays of one shape
        TDB seconds, as `seconds_since` returns them.  A Time holds no NaN: such entries are
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
