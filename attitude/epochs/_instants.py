"""`Instant`, one epoch: TDB seconds past J2000 in two doubles; dates as text."""

from __future__ import annotations

import datetime
import math
import re
from dataclasses import dataclass
from fractions import Fraction
from typing import TYPE_CHECKING

import numpy as np

from attitude._support import pairs, validation
from attitude._support.constants import DAY_S, JD_OF_MJD_0
from attitude._support.validation import shown
from attitude.epochs import _time_scales
from attitude.errors import AttitudeError

if TYPE_CHECKING:
    from astropy.time import Time
    from numpy.typing import ArrayLike

    from attitude._support.annotations import Real


# ---- Dates as text: read ISO 8601 and the CCSDS day of year, write ISO 8601

# Time scales that may follow a date.
SCALES: tuple[str, ...] = ("utc", "tai", "gps", "tt", "tdb", "tcg", "tcb", "ut1")

# An ISO 8601 or CCSDS date with an optional offset from UTC and an optional time scale.
TEXT: re.Pattern[str] = re.compile(
    r"(\d{4})-(?:(\d\d)-(\d\d)|(\d{3}))"  # year-month-day or year-day of year
    r"(?:[T ](\d\d):(\d\d)(?::(\d\d)(?:[.,](\d*))?)?"  # hour:minute:second.fraction
    r"(Z|[+-]\d\d:\d\d)?)?"
    r"(?: +([A-Za-z]\w+))?",  # time scale
    re.ASCII,
)

# A Julian date or modified Julian date with its time scale, which is never guessed.
_JULIAN = re.compile(r"(M?JD) *(\d{1,7})(\.\d*)?(?: +([A-Za-z]\w+))?", re.ASCII | re.IGNORECASE)

# TDB seconds past J2000 of the year -4712 and of the last day of ERFA's calendar, less a day.
_CALENDAR = -_time_scales.J2000 * DAY_S, (1e9 - 2451546.0) * DAY_S


def parsed(text: str, name: str) -> tuple[str, int, int, float]:
    """Scale, day (modified Julian date), whole seconds since its midnight, fraction of a second."""
    matched = TEXT.fullmatch(text.strip())
    if matched is None and (julian := _JULIAN.fullmatch(text.strip())):
        return _of_julian(julian, text, name)
    if matched is None:
        raise AttitudeError(
            f"{name} is {shown(text)}, which cannot be read as a date; write it like "
            '"2026-01-01T00:00:00", "2026-001T00:00:00", "2026-01-01T00:00:00 TDB" or "JD '
            '2461041.5 TDB".'
        )
    year, month, day, yearday, hour, minute, second, fraction, zone, scale = matched.groups()
    scale = _scale(scale, zone, text, name) if scale else "utc"
    try:
        date = _mjd(int(year), month, day, yearday)
    except ValueError as err:
        raise AttitudeError(
            f"{name} is {shown(text)}, a date that does not exist ({err}); give one that does, "
            "from the years 0001 to 9999."
        ) from err
    hours, minutes, seconds = int(hour or 0), int(minute or 0), int(second or 0)
    if hours > 23 or minutes > 59 or seconds > 60:
        raise AttitudeError(
            f"{name} is {shown(text)}; hours go from 00 to 23, minutes and seconds from 00 to 59."
        )
    share = float("0." + fraction) if fraction else 0.0
    offset = _offset(zone)
    if offset is None:
        raise AttitudeError(
            f"{name} is {shown(text)}; an offset from UTC goes from -23:59 to +23:59."
        )
    shift, minutes = divmod(hours * 60 + minutes - offset, 1440)
    if seconds == 60:
        _refuse_false_leap(scale, date + shift, minutes, share, text, name)
    return scale, date + shift, minutes * 60 + seconds, share


def _of_julian(julian: re.Match[str], text: str, name: str) -> tuple[str, int, int, float]:
    """As `parsed`, of a match of _JULIAN; a day of UTC with a leap second has 86401 s."""
    kind, whole, fraction, scale = julian.groups()
    if scale is None:
        raise AttitudeError(
            f"{name} is {shown(text)}, a Julian date without a time scale; add it, as in "
            f'"{text.strip()} UTC" or "{text.strip()} TDB".'
        )
    scale = _scale(scale, None, text, name)
    days = Fraction(whole + (fraction or "")) - (Fraction(JD_OF_MJD_0) if len(kind) == 2 else 0)
    day = math.floor(days)
    if not _time_scales.MJD_OF_ORDINAL_0 < day < _time_scales.YEAR_10000:
        raise AttitudeError(f"{name} is {shown(text)}; give a date of the years 0001 to 9999.")
    length = DAY_S + (_time_scales.leap_of_day(day) if scale == "utc" else 0)
    second = (days - day) * Fraction(float(length))
    return scale, day, math.floor(second), float(second - math.floor(second))


def _scale(scale: str, zone: str | None, text: str, name: str) -> str:
    """The time scale in lower case; AttitudeError for an unknown one, or UTC's offset with one."""
    if scale.lower() not in SCALES:
        raise AttitudeError(
            f"{name} is {shown(text)}; the time scale {shown(scale)} is not known, give one of "
            f"{', '.join(SCALES).upper()}."
        )
    if zone and scale.lower() != "utc":
        raise AttitudeError(
            f"{name} is {shown(text)}; {zone} belongs to UTC: leave out {zone} or {scale}."
        )
    return scale.lower()


def _mjd(year: int, month: str | None, day: str | None, yearday: str | None) -> int:
    """Modified Julian date of a civil day; ValueError if the day does not exist."""
    if not yearday:
        ordinal = datetime.date(year, int(month or 0), int(day or 0)).toordinal()
        return ordinal + _time_scales.MJD_OF_ORDINAL_0
    ordinal = datetime.date(year, 1, 1).toordinal() + int(yearday) - 1
    if datetime.date.fromordinal(ordinal).year != year:
        raise ValueError("day of year is out of range")
    return ordinal + _time_scales.MJD_OF_ORDINAL_0


def _offset(zone: str | None) -> int | None:
    """The offset from UTC in minutes of text such as Z or +01:00; None for one of 24 h or more."""
    if not zone or zone == "Z":
        return 0
    hours, minutes = int(zone[1:3]), int(zone[4:6])
    if hours > 23 or minutes > 59:
        return None
    return (hours * 60 + minutes) * (-1 if zone[0] == "-" else 1)


def utc_text(day: float, second: float, low: float) -> str:
    """ISO 8601 text, to the nanosecond, of a civil day of UTC and seconds since its midnight."""
    import erfa

    whole = int(second // 1.0)
    nano = round(((second - whole) + low) * 1e9)
    whole, nano = whole + nano // 10**9, nano % 10**9
    left = (DAY_S - second) + (_time_scales.leap_of_day(day) - low)
    if left <= 0.5e-9:
        day, whole, nano = day + 1.0, 0, 0  # rounded up to midnight
    year, month, date = erfa.ufunc.jd2cal(JD_OF_MJD_0, day)[:3]
    minute = min(whole // 60, 1439)  # a leap second belongs to the last minute of the day
    text = (
        f"{year:04d}-{month:02d}-{date:02d}T"
        f"{minute // 60:02d}:{minute % 60:02d}:{whole - 60 * minute:02d}.{nano:09d}"
    )
    return text.rstrip("0").rstrip(".")


def _refuse_false_leap(scale, day, minute, fraction, text, name):
    """AttitudeError for a second 60 where there was no leap second."""
    if scale == "utc" and minute == 1439 and fraction < _time_scales.leap_of_day(day):
        return
    raise AttitudeError(
        f"{name} is {shown(text)}, but there was no leap second then; give seconds from 00 to 59."
    )


@dataclass(frozen=True, init=False, repr=False)
class Instant:
    """One epoch: TDB seconds past J2000 (2000-01-01 12:00 TDB) as the sum of two doubles.

    Two instants are equal when both doubles are; the same date given in two ways can differ in
    `low` by 5e-12 s, the rounding of a double of days (astropy, skyfield).

    Parameters
    ----------
    seconds, low : float or Quantity
        s; their sum is the epoch.  `epochs.instant` reads dates.

    Attributes
    ----------
    seconds, low : float
        s; the sum rounded to a double, and the rounding error.

    Raises
    ------
    AttitudeError
        For dates, and whatever else is no number of seconds.

    >>> from attitude.epochs import instant
    >>> instant("2016-12-31T23:59:60.5")
    Instant(2016-12-31T23:59:60.5 UTC)
    >>> instant("2026-01-01T00:00:00 TDB").seconds
    820497600.0
    """

    seconds: float
    low: float

    def __init__(self, seconds: Real, low: Real = 0.0) -> None:
        hi, lo = pairs.two_sum(_seconds(seconds, "seconds"), _seconds(low, "low"))
        object.__setattr__(self, "seconds", float(hi))
        object.__setattr__(self, "low", float(lo))

    @property
    def time(self) -> Time:
        """The epoch as an astropy Time in TDB, rounded to 5e-12 s."""
        return times(self, np.float64(0.0))

    @property
    def utc_iso(self) -> str:
        """ISO 8601 text in UTC, to the nanosecond, without trailing zeros of the fraction.

        Before the year -4712 and after 2,700,000, without a calendar: seconds past J2000.
        """
        if not self._has_date:
            return f"{self.seconds!r} TDB seconds past J2000"
        tt = _time_scales.tt_from_tdb(np.float64(self.seconds), np.float64(self.low))
        tai = pairs.add(tt, -_time_scales.TT_MINUS_TAI)
        return utc_text(*map(float, _time_scales.utc_day_from_tai(*tai)))

    def since(self, other: Instant) -> float:
        """TDB seconds from another Instant to this one, rounded to a double."""
        require(other, "other")
        return (self.seconds - other.seconds) + (self.low - other.low)

    def after(self, seconds: Real, low: Real = 0.0) -> Instant:
        """The instant that is seconds + low of TDB later; also of "3 d"."""
        later = _seconds(seconds, "seconds"), _seconds(low, "low")
        hi, lo = pairs.add((self.seconds, self.low), *later)
        return Instant(hi, lo)

    @property
    def _has_date(self) -> bool:
        return _CALENDAR[0] <= self.seconds <= _CALENDAR[1]

    def __repr__(self) -> str:
        return f"Instant({self.utc_iso} UTC)" if self._has_date else f"Instant({self.utc_iso})"

    __str__ = __repr__


def _seconds(value, name):
    """A number or a length of time as a float of seconds; AttitudeError for anything else."""
    if isinstance(value, float):
        return float(value)
    try:
        return float(validation.real(value, name, shape=(), unit="s", finite=False))
    except AttitudeError:
        raise AttitudeError(
            f"{name} is {shown(value)}; give seconds (epochs.instant reads dates)."
        ) from None


def require(value: object, name: str) -> None:
    """AttitudeError for anything but an Instant."""
    if not isinstance(value, Instant):
        raise AttitudeError(
            f"{name} is {shown(value)}; give an Instant, made by epochs.instant(...)."
        )


def times(start: Instant, seconds: ArrayLike, low: ArrayLike | None = None) -> Time:
    """The epochs start + seconds + low as an astropy Time in TDB, rounded to 5e-12 s.

    Parameters
    ----------
    start : Instant
    seconds, low : float64 arrays of one shape
        TDB seconds, as `seconds_since` returns them.  A Time cannot hold NaN: such entries are
        masked.

    Raises
    ------
    AttitudeError
        For a start that is no Instant, and what is no number or length of time.
    """
    from astropy.time import Time

    require(start, "start")
    seconds, low_parts = validation.together(
        seconds=validation.real(seconds, "seconds", unit="s", finite=False),
        low=validation.real(0.0 if low is None else low, "low", unit="s", finite=False),
    )
    unknown = ~np.isfinite(seconds + low_parts)
    hi, lo = pairs.two_sum(np.where(unknown, 0.0, seconds), np.where(unknown, 0.0, low_parts))
    hi, lo = pairs.add((hi, lo), start.seconds, start.low)
    time = Time(*_time_scales.jd_from_seconds(hi, lo), format="jd", scale="tdb")
    if np.any(unknown):
        time[unknown] = np.ma.masked
    return time


# 2000 January 1, 12 h TDB.
J2000 = Instant(0.0)
