"""CCSDS time codes A and B (CCSDS 301.0-B-4) to TDB and back, vectorized over epochs.

``2026-01-01T00:00:00.5`` and ``2026-001T00:00:00.5``, with or without Z, any number of decimals,
second 60 where there was a leap second; in UTC, TAI, TT, TDB, GPS, and for reading TCG, TCB, UT1.
Arrays of characters become digits in one step: a million epochs a second.
"""

from __future__ import annotations

import datetime
import re
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np

from attitude._support import pairs, validation
from attitude._support.constants import DAY_S, MJD_OF_J2000
from attitude._textfiles.lines import cut, is_number
from attitude.epochs import _inputs, _instants, _time_scales
from attitude.errors import AttitudeError

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from attitude._support.annotations import FloatArray


# TIME_SYSTEM -> time scale; SCLK, MET and MRT count from events that are not in the file.
TIME_SYSTEMS: dict[str, str] = {
    **{name.upper(): name for name in ("utc", "tai", "tt", "tdb", "gps", "tcg", "tcb", "ut1")},
    "GPST": "gps",
    "GPS TIME": "gps",
    "TDT": "tt",
    "ET": "tdb",
}
WRITTEN: tuple[str, ...] = ("UTC", "TAI", "TT", "TDB", "GPS")
# Decimals of written seconds: rounding errors are at most half a picosecond.
DIGITS: int = 12
# Conversions between scales and pairs of doubles leave so much, s (benchmarks/speed.py).
_NOISE = 1e-11
_LONGEST = 48
_MOST_DECIMALS = 18
# A modified Julian date in text, and that of the last day of the year 9999.
_DAY = re.compile(rb"\d{1,7}(\.0*)?")
_LAST_DAY = 2973483.0
_0 = ord("0")
_9 = ord("9")
_CALENDAR = {4: "-", 7: "-", 10: "T", 13: ":", 16: ":"}, 19
_YEARDAY = {4: "-", 8: "T", 11: ":", 14: ":"}, 17


def known(time_system: str, name: str = "TIME_SYSTEM") -> str:
    """The time scale, in lower case, of a CCSDS time system; `name` stands in the error message."""
    system = time_system.strip().upper() if isinstance(time_system, str) else ""
    system = system.replace("_", " ")  # CCSDS 504.0-B-2, 6.8.8
    if system not in TIME_SYSTEMS:
        raise AttitudeError(
            f"{name} is {cut(time_system)}, which cannot be converted; it must be one of "
            f"{', '.join(sorted(TIME_SYSTEMS))}."
        )
    return TIME_SYSTEMS[system]


def writable(time_system: str) -> str:
    """The time scale, in lower case, of a CCSDS time system in which epochs can be written."""
    scale = known(time_system)
    if scale.upper() not in WRITTEN:
        raise AttitudeError(
            f"epochs are not written in {time_system}; give one of {', '.join(WRITTEN)}."
        )
    return scale


def now() -> str:
    """The present epoch in UTC to the second, as a CREATION_DATE."""
    return datetime.datetime.now(datetime.UTC).strftime("%Y-%m-%dT%H:%M:%S")


def parsed(tokens: Sequence[bytes], scale: str) -> tuple[FloatArray, FloatArray]:
    """TDB seconds since J2000, hi + lo (N,), of N epochs."""
    lengths = np.fromiter(map(len, tokens), dtype=np.intp, count=len(tokens))
    if np.any(lengths > _LONGEST):
        raise BadEpoch(int(np.argmax(lengths > _LONGEST)), "it is too long")
    width = max(int(lengths.max(initial=0)), 20)
    chars = np.array(tokens, dtype=f"S{width}").view(np.uint8).reshape(len(tokens), width)
    ends = chars[np.arange(len(tokens)), np.maximum(lengths, 1) - 1] == ord("Z")
    kind = (lengths - ends) * 2 + (chars[:, 7] == ord("-"))
    day, second, fraction = (np.empty(len(tokens)) for _ in range(3))
    for layout in np.unique(kind):
        rows = np.flatnonzero(kind == layout)
        group = _fields(chars[rows, : layout // 2], bool(layout % 2))
        if isinstance(group, tuple):
            day[rows], second[rows], fraction[rows] = group
        else:
            raise BadEpoch(int(rows[np.argmax(group)]), "write it like 2026-01-01T00:00:00.000")
    false = second >= DAY_S
    if scale == "utc" and np.any(false):
        false &= fraction >= _time_scales.leap_of_day(day)
    if np.any(false):
        raise BadEpoch(int(np.argmax(false)), "there was no leap second then")
    return _tdb(scale, day, second, fraction)


def parsed_days(
    days: Sequence[bytes], seconds: Sequence[bytes], scale: str
) -> tuple[FloatArray, FloatArray]:
    """TDB seconds since J2000, hi + lo, of N epochs as days and seconds of the day."""
    for k, (day, second) in enumerate(zip(days, seconds, strict=True)):
        if _DAY.fullmatch(day) is None or not is_number(second):
            raise BadEpoch(k, "write a modified Julian date and seconds, like 61041 43200.0")
    date, second_of_day = (np.array(list(map(float, column))) for column in (days, seconds))
    length = DAY_S + (_time_scales.leap_of_day(date) if scale == "utc" else 0.0)
    outside = ~((second_of_day >= 0.0) & (second_of_day <= length)) | (date > _LAST_DAY)
    if np.any(outside):
        reason = "its seconds are not those of a day, or its year is after 9999"
        raise BadEpoch(int(np.argmax(outside)), reason)
    whole = np.floor(second_of_day)
    fraction = second_of_day - whole
    # Of plain decimals the fraction is a double of its own: of 86400 s one double has 1e-11.
    for k, (first, _, decimals) in enumerate(column.partition(b".") for column in seconds):
        if first.isdigit() and (not decimals or decimals.isdigit()):
            whole[k], fraction[k] = float(first), float(b"0." + decimals)
    return _tdb(scale, date, whole, fraction)


def _tdb(scale, day, second, fraction):
    try:
        hi, lo = _inputs.tdb_of_day(scale, day, second, fraction, "an epoch")
    except AttitudeError as err:
        raise BadEpoch(0, str(err)) from err
    return np.asarray(hi), np.asarray(lo)


class BadEpoch(Exception):
    """An epoch that cannot be read: its place among those that `parsed` was given, the reason."""

    def __init__(self, index: int, reason: str):
        super().__init__(index, reason)
        self.index: int = index
        self.reason: str = reason


def instant(text: str, scale: str) -> _instants.Instant:
    """The Instant of a time code in a time scale (lower case); BadEpoch if it cannot be read."""
    hi, lo = parsed([text.encode("ascii", "replace")], scale)
    return _instants.Instant(hi[0], lo[0])


def texts(
    epoch: _instants.Instant,
    seconds: FloatArray,
    low: FloatArray | None,
    scale: str,
    digits: int | None = None,
) -> list[str]:
    """Time codes A of N epochs, seconds + low (N,), by default with the `fewest` decimals."""
    hi, lo = pairs.Seconds(np.asarray(seconds), low).plus(epoch.seconds, epoch.low)
    if digits is None:
        digits = fewest(hi, lo, scale)
    day, whole, ticks = _civil(hi, lo, scale, digits)
    year, month, date = _calendar(day)
    if np.any((year < 1) | (year > 9999)):
        raise AttitudeError(
            "an epoch lies outside of the years 0001 to 9999, which CCSDS can write."
        )
    minute = np.minimum(whole // 60, 1439)
    columns = [
        *_digits(year, 4, "-"),
        *_digits(month, 2, "-"),
        *_digits(date, 2, "T"),
        *_digits(minute // 60, 2, ":"),
        *_digits(minute % 60, 2, ":"),
        *_digits(whole - 60 * minute, 2, "." if digits else ""),
        *(_digits(ticks, digits, "") if digits else ()),
    ]
    chars = np.stack(np.broadcast_arrays(*columns), axis=-1).astype(np.uint8)
    flat = np.ascontiguousarray(chars).view(f"S{chars.shape[-1]}")[..., 0]
    return flat.astype(f"U{chars.shape[-1]}").tolist()


def distinct(codes: list[str]) -> list[str]:
    """The epochs of records as they are written; AttitudeError if two neighbours are the same."""
    for before, code in pairwise(codes):
        if before == code:
            raise AttitudeError(
                f"two epochs are both written as {code}, and readers refuse repeated epochs; give "
                "epochs that are farther apart, or more decimals if the writer takes digits=."
            )
    return codes


def fewest(hi: FloatArray, lo: FloatArray, scale: str) -> int:
    """3, 6, 9 or 12 decimals of a second: the fewest that say what epochs (N,) are."""
    ticks = _civil(hi, lo, scale, DIGITS)[2]
    for digits in (3, 6, 9):
        unit = 10 ** (DIGITS - digits)
        off = np.minimum(ticks % unit, -ticks % unit)
        if np.all(off <= _NOISE * 10**DIGITS):
            return digits
    return DIGITS


def days_and_seconds(
    epoch: _instants.Instant,
    seconds: FloatArray,
    low: FloatArray | None,
    scale: str,
    digits: int = DIGITS,
) -> list[str]:
    """Modified Julian date and seconds of the day of N epochs; parameters as in `texts`."""
    hi, lo = pairs.Seconds(np.asarray(seconds), low).plus(epoch.seconds, epoch.low)
    day, whole, ticks = _civil(hi, lo, scale, digits)
    if np.any((day < 0) | (day > _LAST_DAY)):
        raise AttitudeError(
            "an epoch lies outside of 1858-11-17, the modified Julian date 0, to the year 9999, "
            "which days and seconds can write."
        )
    days = day.astype(np.int64).tolist()
    seconds_of_day = decimals(whole, ticks, digits)
    return [f"{date} {second}" for date, second in zip(days, seconds_of_day, strict=True)]


def rounded(second: FloatArray, low: FloatArray, digits: int) -> tuple[FloatArray, FloatArray]:
    """second + low (N,) as whole seconds, and units of 10^-digits s, rounded."""
    digits = validation.count(digits, "digits", 0, _MOST_DECIMALS)
    whole = np.floor(second)
    ticks = np.rint(((second - whole) + low) * 10.0**digits)
    carry = np.floor(ticks / 10.0**digits)
    return whole + carry, ticks - carry * 10.0**digits


def decimals(whole: NDArray[Any], ticks: NDArray[Any], digits: int) -> list[str]:
    """The texts of what `rounded` returns."""
    rows = zip(whole.astype(np.int64).tolist(), ticks.astype(np.int64).tolist(), strict=True)
    return [f"{second}.{left:0{digits}d}" if digits else f"{second}" for second, left in rows]


def _fields(chars, calendar):
    """Day (MJD), whole seconds and fraction of each row; or a mask of the rows that are invalid."""
    separators, start = _CALENDAR if calendar else _YEARDAY
    count = chars.shape[1]
    if count < start or count == start + 1:
        return np.ones(len(chars), dtype=bool)
    digit = (chars >= _0) & (chars <= _9)
    for place, mark in separators.items():
        digit[:, place] = chars[:, place] == ord(mark)
    if count > start:
        digit[:, start] = chars[:, start] == ord(".")
    bad = ~np.all(digit, axis=1)
    value = chars.astype(np.int64) - _0

    def number(first, last):
        return value[:, first:last] @ (10 ** np.arange(last - first)[::-1])

    year = number(0, 4)
    if calendar:
        month, date = number(5, 7), number(8, 10)
        bad |= (month < 1) | (month > 12)
        month = np.clip(month, 1, 12)
        day = _day_number(year, month, date)
        following = _day_number(year, month + 1, 1)
        bad |= (date < 1) | (day >= following)
    else:
        yearday = number(5, 8)
        first, following = (_day_number(y, 1, 1) for y in (year, year + 1))
        day = first + yearday - 1
        bad |= (yearday < 1) | (day >= following)
    hour, minute, second = (number(start - k, start - k + 2) for k in (8, 5, 2))
    bad |= (year < 1) | (hour > 23) | (minute > 59) | (second > 60)
    bad |= (second == 60) & (hour * 60 + minute < 1439)
    if np.any(bad):
        return bad
    decimals = min(count - start - 1, _MOST_DECIMALS)
    fraction = number(start + 1, start + 1 + decimals) / 10.0**decimals if decimals > 0 else 0.0
    whole = hour * 3600 + minute * 60 + second
    return day.astype(float), whole.astype(float), np.broadcast_to(fraction, whole.shape)


def _day_number(year, month, date):
    """Modified Julian date of a Gregorian date; month 13 is January of the next year."""
    months = (12 * (year - 1970) + month - 1).astype("datetime64[M]")
    return months.astype("datetime64[D]").astype(np.int64) + (_time_scales.MJD_OF_1970 + date - 1)


def _calendar(day):
    """Gregorian year, month and date of a Modified Julian date."""
    dates = (day.astype(np.int64) - _time_scales.MJD_OF_1970).astype("datetime64[D]")
    months = dates.astype("datetime64[M]")
    count = months.astype(np.int64)
    return 1970 + count // 12, count % 12 + 1, (dates - months).astype(np.int64) + 1


def _civil(hi, lo, scale, digits):
    """Day (MJD) and whole second in a scale, and rest in 10^-digits s, rounded, of TDB seconds."""
    if scale != "tdb":
        hi, lo = _time_scales.tt_from_tdb(hi, lo)
    if scale == "gps":
        hi, lo = pairs.add((hi, lo), -_time_scales.TT_MINUS_TAI - _time_scales.TAI_MINUS_GPS)
    elif scale in ("tai", "utc"):
        hi, lo = pairs.add((hi, lo), -_time_scales.TT_MINUS_TAI)
    if scale == "utc":
        day, second, low = _time_scales.utc_day_from_tai(hi, lo)
        length = DAY_S + _time_scales.leap_of_day(day)
    else:
        day = np.floor((hi + lo) / DAY_S + MJD_OF_J2000)
        second, low = pairs.add((hi, lo), (MJD_OF_J2000 - day) * DAY_S)
        length = DAY_S
    whole, ticks = rounded(second, low, digits)
    after = (whole >= length) | ((length - second) - low <= 0.5 * 10.0**-digits)
    day, whole = np.where(after, day + 1.0, day), np.where(after, 0.0, whole)
    ticks = np.where(after, 0.0, ticks)  # days before 1972 end within a tick
    before = whole < 0.0
    day, whole = np.where(before, day - 1.0, day), np.where(before, whole + DAY_S, whole)
    return day, whole.astype(np.int64), ticks.astype(np.int64)


def _digits(number, count, mark):
    columns = [_0 + number // 10**k % 10 for k in range(count - 1, -1, -1)]
    return [*columns, np.int64(ord(mark))] if mark else columns
