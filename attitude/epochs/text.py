"""Dates as text: read ISO 8601 and the CCSDS day of year, write ISO 8601."""

from __future__ import annotations

import datetime
import re

from attitude.epochs import time_scales
from attitude.errors import AttitudeError
from attitude.validation import shown

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


def parsed(text: str, name: str) -> tuple[str, int, int, float]:
    """Scale, day (modified Julian date), whole seconds since its midnight, fraction of a second.

    Raises
    ------
    AttitudeError
        For text that is not a date, and dates that do not exist; `name` stands for the value.
    """
    found = TEXT.fullmatch(text.strip())
    if found is None:
        raise AttitudeError(
            f"{name} is {shown(text)}, which cannot be read as a date; write it like "
            '"2026-01-01T00:00:00", "2026-001T00:00:00" or "2026-01-01T00:00:00 TDB".'
        )
    year, month, day, yearday, hour, minute, second, fraction, zone, scale = found.groups()
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
    part = float("0." + fraction) if fraction else 0.0
    shift, minutes = divmod(hours * 60 + minutes - _offset(zone), 1440)
    if seconds == 60:
        _refuse_false_leap(scale, date + shift, minutes, part, text, name)
    return scale, date + shift, minutes * 60 + seconds, part


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
        return ordinal + time_scales.MJD_OF_ORDINAL_0
    ordinal = datetime.date(year, 1, 1).toordinal() + int(yearday) - 1
    if datetime.date.fromordinal(ordinal).year != year:
        raise ValueError("day of year is out of range")
    return ordinal + time_scales.MJD_OF_ORDINAL_0


def _offset(zone: str | None) -> int:
    """The offset from UTC in minutes of text such as Z or +01:00."""
    if not zone or zone == "Z":
        return 0
    minutes = int(zone[1:3]) * 60 + int(zone[4:6])
    return -minutes if zone[0] == "-" else minutes


def utc_text(day: float, second: float, low: float) -> str:
    """ISO 8601 text, to the nanosecond, of a civil day of UTC and the seconds since its midnight.

    Parameters
    ----------
    day : float
        Modified Julian date, a whole number.
    second, low : float
        s; second + low counts from midnight.
    """
    import erfa

    whole = int(second // 1.0)
    nano = round(((second - whole) + low) * 1e9)
    whole, nano = whole + nano // 10**9, nano % 10**9
    if whole + nano * 1e-9 >= time_scales.DAY + time_scales.leap_of_day(day):
        day, whole, nano = day + 1.0, 0, 0  # rounded up to midnight
    year, month, date = erfa.ufunc.jd2cal(2400000.5, day)[:3]
    minute = min(whole // 60, 1439)  # a leap second belongs to the last minute of the day
    text = (
        f"{year:04d}-{month:02d}-{date:02d}T"
        f"{minute // 60:02d}:{minute % 60:02d}:{whole - 60 * minute:02d}.{nano:09d}"
    )
    return text.rstrip("0").rstrip(".")


def _refuse_false_leap(scale, day, minute, fraction, text, name):
    """AttitudeError for a second 60 where there was no leap second."""
    if scale == "utc" and minute == 1439 and fraction < time_scales.leap_of_day(day):
        return
    raise AttitudeError(
        f"{name} is {shown(text)}, but there was no leap second then; give seconds from 00 to 59."
    )
