"""Read the epochs that callers give: dates, Time objects and plain seconds to TDB in two doubles.

`instant` reads one epoch, `seconds_since` any number of epochs as seconds from an instant; `times`
and `Instant.time` convert back to astropy.  All other code works on float64 arrays of TDB seconds.

Types of epochs
---------------
text
    ISO 8601 in UTC: ``2026-01-01``, ``2026-01-01T00:00:00.5``, a space for the T, ``Z`` or an
    offset such as ``+01:00`` at the end; CCSDS day of year, ``2026-001T00:00:00``; the name of
    another scale after a space, ``2026-01-01T00:00:00 TDB`` (UTC, TAI, GPS, TT, TDB, TCG, TCB,
    UT1).  Second 60 is accepted only where there was a leap second.
astropy Time
    Any scale but "local", any shape.  Location, masks, and a UT1 - UTC or TDB - TT set on the Time
    are used.
skyfield Time
    TDB is computed from its TT, as for the other types: skyfield's own TDB differs by up to 10 us.
datetime, datetime64
    UTC; a datetime with a time zone is converted, pandas' nanoseconds are kept.

TDB is that of the geocentre unless a Time has a location, as in astropy.
"""

from __future__ import annotations

import math
import warnings
from typing import TYPE_CHECKING, Any

import numpy as np

from attitude import pairs, validation
from attitude.epochs import kinds, readers
from attitude.epochs.instants import Instant, times
from attitude.errors import AttitudeError, AttitudeWarning

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from attitude.annotations import Epoch, Epochs, FloatArray

__all__ = ["Instant", "instant", "past_j2000", "plain_seconds", "seconds_since", "times"]

_DATES = (
    'an ISO date in UTC such as "2026-01-01T00:00:00", an astropy or skyfield Time, a datetime '
    "or a numpy datetime64"
)
# Seconds in this range, 27.8 to 28.9 days, are Julian dates of the years 1858 to 2132 more often.
_FIRST_JD, _LAST_JD = 2.4e6, 2.5e6
_DATES_OR_SECONDS = (
    f'plain seconds, a time Quantity, a TimeDelta or text such as "3 d", or dates: {_DATES}'
)


def instant(value: Epoch, name: str = "epoch") -> Instant:
    """One epoch of any type as an `Instant`.

    Parameters
    ----------
    value : str, astropy Time, skyfield Time, datetime, datetime64 or Instant
        One epoch; the top of `attitude.epochs.inputs` describes the types.
    name : str
        Name of the value in error messages.

    Raises
    ------
    AttitudeError
        For a plain number, several epochs, a date that does not exist or cannot be read, NaT.
    """
    if isinstance(value, Instant):
        return value
    if type(value) is str and value[4:5] == "-":
        return Instant(*readers.of_text(value, name))
    kind, leaves, shape = kinds.entries(value, name, _DATES)
    if kind in kinds.LENGTHS:
        raise AttitudeError(
            f"{name} is {validation.shown(value)}, a length of time; give an epoch: {_DATES}."
        )
    hi, lo = readers.read(kind, leaves, shape, name)
    assert lo is not None  # a date has both doubles
    if hi.shape != ():
        raise AttitudeError(f"{name} has shape {hi.shape}; give one epoch.")
    if not math.isfinite(hi):
        raise AttitudeError(
            f"{name} is {validation.shown(value)}, which is not an epoch; give {_DATES}."
        )
    return Instant(float(hi), float(lo))


def seconds_since(
    start: Instant, t: Epochs, low: ArrayLike | None = None, name: str = "t"
) -> tuple[FloatArray, FloatArray | None]:
    """TDB seconds from an instant to other epochs, in two doubles.

    Parameters
    ----------
    start : Instant
    t : array_like
        One of the following, of any shape; lists may be nested.

        * Plain numbers: TDB seconds since `start`, returned as they are (a float64 array is not
          copied).
        * A time Quantity, text such as "3 d" or "0, 6, 12 h", a timedelta or timedelta64: TDB
          seconds since `start` in another unit.
        * A TimeDelta: the epoch that astropy computes as start + t.  Without a scale or in TDB the
          TimeDelta counts seconds of TDB; in TAI or TT (differences of UTC times are in TAI) and
          in TCG or TCB, seconds of that scale from `start`.
        * Epochs: text, Time, datetime, datetime64, Instant.
    low : array_like, optional
        With plain numbers: a second double; t + low are the seconds.  Of t's shape or a scalar.
    name : str
        Name of t in error messages.

    Returns
    -------
    hi : float64 array of t's shape
        NaN where t is NaN, NaT or masked.
    lo : float64 array of t's shape, or None
        The rounding of hi: hi + lo are the seconds.  None for plain numbers without `low`, time
        Quantities and timedeltas.

    Notes
    -----
    Epochs are converted to 1e-14 s (UT1, and UTC before 1972: 1e-11 s), measured from year 1000
    to 3000; the double of days in a Time resolves 5e-12 s, and TDB - TT is known to about 1e-5 s.
    1e5 UTC epochs in one Time cost 0.15 microseconds each.

    Raises
    ------
    AttitudeError
        For other types, booleans, mixed or ragged lists, dates that cannot be read, years outside
        of -4712 to 9999, UT1 outside of its table, `low` of another shape or with dates.
    """
    if type(t) is np.ndarray and t.dtype == np.float64:
        if low is None and t.size and _FIRST_JD <= t.flat[0] <= _LAST_JD:
            _warn_of_julian_dates(t, name)
        return t, _low(low, t.shape, name)
    if low is None and type(t) is float and _FIRST_JD <= t <= _LAST_JD:
        _warn_of_julian_dates(np.array(t), name)
    if type(t) is float or (type(t) is int and abs(t) < 2**53):
        return np.array(t, dtype=np.float64), _low(low, (), name)
    kind, leaves, shape = kinds.entries(t, name, _DATES_OR_SECONDS)
    if kind == "number":
        hi, _ = readers.read(kind, leaves, shape, name)
        if low is None and hi.size and _FIRST_JD <= hi.flat[0] <= _LAST_JD:
            _warn_of_julian_dates(hi, name)
        return hi, _low(low, hi.shape, name)
    if low is not None:
        raise AttitudeError(
            f"low is given, but {name} is {validation.shown(t)}; leave out low, the second double "
            "of plain seconds: dates and durations do not need it."
        )
    if kind in kinds.LENGTHS:
        return readers.read(kind, leaves, shape, name, start)
    dates, rest = readers.read(kind, leaves, shape, name)
    assert rest is not None  # a date has both doubles
    hi, lo = pairs.add((dates, rest), -start.seconds, -start.low)
    return np.asarray(hi), np.asarray(lo)


def _warn_of_julian_dates(t: FloatArray, name: str) -> None:
    """AttitudeWarning if all seconds are in the range of the Julian dates of 1858 to 2132."""
    if not np.all((t >= _FIRST_JD) & (t <= _LAST_JD)):
        return
    warnings.warn(
        f"{name} is {validation.shown(float(t.flat[0]))}, taken for seconds since the epoch, but "
        'it looks like a Julian date; give a date such as "2026-01-01" or astropy.time.Time('
        f'{float(t.flat[0])!r}, format="jd"), or the seconds as a Quantity or with low=0.',
        AttitudeWarning,
        stacklevel=4,
    )


def past_j2000(t: Epochs, name: str = "t") -> tuple[FloatArray, FloatArray]:
    """Dates of any shape as TDB seconds past J2000, in two doubles.

    NaN where a date is NaT or masked.  From a date, `seconds_since` an Instant is
    ``pairs.add(found, -start.seconds, -start.low)``, bit for bit.

    Raises
    ------
    AttitudeError
        For plain seconds and durations, and as `seconds_since`.
    """
    kind, leaves, shape = kinds.entries(t, name, _DATES)
    if kind in kinds.LENGTHS:
        raise AttitudeError(f"{name} is {validation.shown(t)}; give {_DATES}.")
    hi, lo = readers.read(kind, leaves, shape, name)
    assert lo is not None  # a date has both doubles
    return hi, lo


def plain_seconds(
    seconds: ArrayLike, low: ArrayLike | None = None, name: str = "seconds"
) -> tuple[FloatArray, FloatArray | None]:
    """Seconds and their second double as float64 arrays of one shape; `low` may be None.

    Raises
    ------
    AttitudeError
        For dates, durations and other types, ragged lists, and `low` of another shape.
    """
    if isinstance(seconds, np.ndarray) and seconds.dtype == np.float64:
        return seconds, _low(low, seconds.shape, name)
    if type(seconds) is float:
        return np.array(seconds), _low(low, (), name)
    kind, leaves, shape = kinds.entries(seconds, name, "plain seconds")
    if kind != "number":
        raise AttitudeError(
            f"{name} is {validation.shown(seconds)}; give plain seconds (at(t) reads dates too)."
        )
    hi, _ = readers.read(kind, leaves, shape, name)
    return hi, _low(low, hi.shape, name)


def _low(low: Any, shape: tuple[int, ...], name: str) -> FloatArray | None:
    """The second double of plain seconds, broadcast to the shape of the first."""
    if low is None:
        return None
    if type(low) is np.ndarray and low.dtype == np.float64 and low.shape == shape:
        return low
    kind, leaves, shape_given = kinds.entries(low, "low", "plain seconds")
    if kind != "number":
        raise AttitudeError(f"low is {validation.shown(low)}; give plain seconds.")
    seconds, _ = readers.read(kind, leaves, shape_given, "low")
    if seconds.shape not in ((), shape):
        raise AttitudeError(
            f"low has shape {seconds.shape}, {name} has {shape}; give both in the same shape."
        )
    return np.broadcast_to(seconds, shape)
