"""Epochs from outside: dates, Time objects and plain seconds become TDB in two doubles, once.

`instant` makes one epoch, `seconds_since` the seconds from it to any number of others, `times` and
`Instant.time` lead back to astropy.  Behind this file there are only float64 arrays of TDB seconds.

What is taken
-------------
text
    ISO 8601 in UTC: ``2026-01-01``, ``2026-01-01T00:00:00.5``, a space for the T, ``Z`` or an
    offset such as ``+01:00`` at the end; CCSDS day of year, ``2026-001T00:00:00``; the name of
    another scale after a space, ``2026-01-01T00:00:00 TDB`` (UTC, TAI, GPS, TT, TDB, TCG, TCB,
    UT1).  Second 60 where there was a leap second, and nowhere else.
astropy Time
    Any scale but "local", any shape; location, masks and a UT1 - UTC or TDB - TT that was set on
    it are honoured.
skyfield Time
    Its TT, from which TDB is made as for all others: skyfield's own TDB differs by up to 10 us.
datetime, datetime64
    UTC; a datetime with a time zone is converted, pandas' nanoseconds are kept.

TDB is that of the geocentre unless a Time has a location, as in astropy.
"""

import math

import numpy as np

from attitude import pairs, validation
from attitude.epochs import readers
from attitude.epochs.instants import Instant, times
from attitude.errors import AttitudeError

__all__ = ["Instant", "instant", "seconds_since", "times"]

_DATES = (
    'an ISO date in UTC such as "2026-01-01T00:00:00", an astropy or skyfield Time, a datetime '
    "or a numpy datetime64"
)
_DATES_OR_SECONDS = f"plain seconds, a time Quantity or TimeDelta, or dates: {_DATES}"


def instant(value, name="epoch"):
    """One epoch of any kind that this file takes, as an `Instant`.

    Parameters
    ----------
    value : str, astropy Time, skyfield Time, datetime, datetime64 or Instant
        One epoch; see the top of the file.
    name : str
        How the value is called in the error message.

    Raises
    ------
    AttitudeError
        For a bare number, several epochs, a date that does not exist or cannot be read, NaT.
    """
    if isinstance(value, Instant):
        return value
    kind, leaves, shape = readers.opened(value, name, _DATES)
    if kind in readers.LENGTHS:
        raise AttitudeError(
            f"{name} is {validation.shown(value)}, a length of time from no given "
            f"moment; give {_DATES}."
        )
    hi, lo = readers.read(kind, leaves, shape, name)
    if hi.shape != ():
        raise AttitudeError(f"{name} has shape {hi.shape}; give one epoch.")
    if not math.isfinite(hi):
        raise AttitudeError(
            f"{name} is {validation.shown(value)}, which is no epoch; give {_DATES}."
        )
    return Instant(float(hi), float(lo))


def seconds_since(start, t, low=None, name="t"):
    """TDB seconds from an instant to other epochs, in two doubles.

    Parameters
    ----------
    start : Instant
    t : array_like
        One of the following, of any shape; lists may be nested.

        * Plain numbers: they are TDB seconds since `start` already, and are returned as they are
          (a float64 array is not copied).
        * A time Quantity, a timedelta or timedelta64: the same in another unit.
        * A TimeDelta: the epoch that astropy means by start + t.  Without a scale or in TDB that
          is seconds of TDB; in TAI or TT (differences of UTC times come in TAI) and in TCG or TCB
          that many seconds of that scale, counted from `start`.
        * Epochs as this file takes them: text, Time, datetime, datetime64, Instant.
    low : array_like, optional
        With plain numbers: a second double, t + low being the seconds; of t's shape or a scalar.
    name : str
        How t is called in the error message.

    Returns
    -------
    hi : float64 array of t's shape
        NaN where t is NaN, NaT or masked.
    lo : float64 array of t's shape, or None
        What hi leaves out.  None for plain numbers and their like without `low`.

    Notes
    -----
    What was given is kept to 1e-14 s (UT1, and UTC before 1972: 1e-11 s), measured from year 1000
    to 3000; the double of days in a Time holds 5e-12 s itself, and TDB - TT is known to 1e-5 s or
    so.  1e5 UTC epochs in one Time cost 0.15 microseconds each.

    Raises
    ------
    AttitudeError
        For other types, booleans, mixed or ragged lists, dates that cannot be read, years outside
        of -4712 to 9999, UT1 outside of its table.
    """
    if type(t) is np.ndarray and t.dtype == np.float64:
        return t, _low(low, t.shape, name)
    if type(t) is float or (type(t) is int and abs(t) < 2**53):
        return np.array(t, dtype=np.float64), _low(low, (), name)
    kind, leaves, shape = readers.opened(t, name, _DATES_OR_SECONDS)
    if kind == "number":
        hi, _ = readers.read(kind, leaves, shape, name)
        return hi, _low(low, hi.shape, name)
    if low is not None:
        raise AttitudeError(
            f"low goes with plain seconds, but {name} is {validation.shown(t)}; leave out low, "
            "which dates and durations do not need."
        )
    if kind in readers.LENGTHS:
        return readers.read(kind, leaves, shape, name, start)
    hi, lo = pairs.add(readers.read(kind, leaves, shape, name), -start.seconds, -start.low)
    return np.asarray(hi), np.asarray(lo)


def _low(low, shape, name):
    if low is None:
        return None
    if type(low) is np.ndarray and low.dtype == np.float64 and low.shape == shape:
        return low
    _, leaves, shape_given = readers.opened(low, "low", "plain seconds")
    seconds, _ = readers.read("number", leaves, shape_given, "low")
    if seconds.shape not in ((), shape):
        raise AttitudeError(
            f"low has shape {seconds.shape}, {name} has {shape}; give both in the same shape."
        )
    return np.broadcast_to(seconds, shape)
