"""Dates as STK writes them, and the times of records.

ScenarioEpoch and TimeFormat UTCG: ``1 Jul 1999 00:00:00.00``, the month by three letters or its
whole name, with or without quotation marks; also ISO 8601.  TimeFormat says what stands before the
numbers of a record: EpSec (the default), EpMin, EpHr and EpDay count from ScenarioEpoch in TAI.
"""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

import numpy as np

from attitude import pairs
from attitude.epochs import time_scales
from attitude.errors import AttitudeError
from attitude.formats.ccsds import epochs as ccsds_epochs

if TYPE_CHECKING:
    from collections.abc import Sequence

    from attitude.annotations import FloatArray
    from attitude.epochs import Instant

MONTHS: tuple[str, ...] = (
    *("January", "February", "March", "April", "May", "June", "July", "August", "September"),
    *("October", "November", "December"),
)
_DATE = re.compile(r"(\d{1,2}) ([A-Za-z]{3,9}) (\d{4}) (\d{1,2}):(\d{2}):(\d{2})(\.\d*)?", re.ASCII)
_ISO = re.compile(r"\d{4}-(\d{2}-\d{2}|\d{3})T\d{2}:\d{2}:\d{2}(\.\d*)?Z?", re.ASCII)
# TimeFormat in lower case -> seconds of its unit, and for dates the words of one.
UNITS: dict[str, float] = {"epsec": 1.0, "epmin": 60.0, "ephr": 3600.0, "epday": 86400.0}
DATES: dict[str, int] = {"utcg": 4, "iso-ymd": 1, "iso-yd": 1}
FORMATS: str = "EpSec, EpMin, EpHr, EpDay, UTCG, ISO-YMD, ISO-YD"


def iso(text: str) -> str | None:
    """A date as CCSDS time code, or None if it is no date of STK.

    >>> iso('"1 July 1999 00:00:00.00"'), iso("1 Jul 1999 7:30:00"), iso("Today")
    ('1999-07-01T00:00:00.00', '1999-07-01T07:30:00', None)
    """
    given = " ".join(text.strip().strip("\"'").split())
    if _ISO.fullmatch(given):
        return given
    found = _DATE.fullmatch(given)
    if found is None:
        return None
    date, month, year, hour, minute, second, part = found.groups()
    months = [k for k, name in enumerate(MONTHS) if month.title() in (name, name[:3])]
    if not months:
        return None
    time = f"{int(hour):02d}:{minute}:{second}{part or ''}".rstrip(".")
    return f"{year}-{months[0] + 1:02d}-{int(date):02d}T{time}"


def instant(text: str, what: str) -> Instant:
    """The Instant of a date in UTC.

    `what` is the name of the keyword in the error message.

    Raises
    ------
    AttitudeError
        If it cannot be read.
    """
    code = iso(text)
    if code is None:
        given = repr(text[:40]) if text else "not given"
        raise AttitudeError(
            f"{what} is {given}; write a date in UTC like 1 Jan 2026 00:00:00.000, and not the "
            "name of a time that STK knows."
        )
    try:
        return ccsds_epochs.instant(code, "utc")
    except ccsds_epochs.BadEpoch as err:
        raise AttitudeError(f"{what} is {text[:40]!r}: {err.reason}.") from err


def tai_of(epoch: Instant) -> tuple[FloatArray, FloatArray]:
    """TAI seconds since J2000, hi and lo, of an Instant."""
    tt = time_scales.tt_from_tdb(np.float64(epoch.seconds), np.float64(epoch.low))
    return pairs.add(tt, -time_scales.TT_MINUS_TAI)


def of_rows(words: Sequence[bytes], count: int) -> list[bytes]:
    """The dates at the start of rows as CCSDS time codes.

    `words` are those of all rows, `count` of each.  A date that STK does not write stays as it is,
    and is refused by the reader of time codes.
    """
    found = []
    for k in range(0, len(words), count):
        text = b" ".join(words[k : k + count]).decode("ascii", "replace")
        found.append((iso(text) or text).encode("ascii", "replace"))
    return found
