"""Read the epochs that callers give: dates, Time objects and plain seconds to TDB in two doubles.

`instant` reads one epoch, `seconds_since` any number of epochs as seconds from an instant; `times`
and `Instant.time` convert back to astropy.  All other code works on float64 arrays of TDB seconds.

Types of epochs
---------------
text
    ISO 8601 in UTC: ``2026-01-01``, ``2026-01-01T00:00:00.5``, a space for the T, ``Z`` or an
    offset such as ``+01:00`` at the end; CCSDS day of year, ``2026-001T00:00:00``; the name of
    another scale after a space, ``2026-01-01T00:00:00 TDB`` (UTC, TAI, GPS, TT, TDB, TCG, TCB,
    UT1).  Second 60 is accepted only where there was a leap second.  A Julian date with its scale:
    ``JD 2461041.5 TDB``, ``MJD 61041.0 UTC``.
astropy Time
    Any scale but "local", any shape.  Location, masks, and a UT1 - UTC or TDB - TT set on the Time
    are used.
skyfield Time
    TDB is computed from its TT, as for the other types: skyfield's own TDB differs by up to 10 us.
datetime, date, datetime64
    UTC; a datetime with a time zone is converted, pandas' nanoseconds are kept, a date is midnight.

TDB is that of the geocentre unless a Time has a location, as in astropy.
"""

from __future__ import annotations

import datetime
import math
import numbers
import sys
import warnings
from contextlib import suppress
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from attitude._support import pairs, quantity_text, validation
from attitude._support.constants import DAY_S, MJD_OF_J2000
from attitude.epochs import _instants as epochs_instants
from attitude.epochs import _time_scales
from attitude.epochs._instants import Instant, times
from attitude.errors import AttitudeError, AttitudeWarning

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import ArrayLike

    from attitude._support.annotations import Epoch, Epochs, FloatArray

__all__ = ["Instant", "instant", "past_j2000", "plain_seconds", "seconds_since", "times"]


# ---- The kind of the epochs that a caller gives (text, Time, datetime, seconds ...)

# Kinds that are lengths of time; the others are epochs.
LENGTHS: tuple[str, ...] = ("number", "text length", "duration", "TimeDelta")

_TYPES = (
    ("Instant", Instant),
    ("datetime", datetime.date),
    ("datetime64", np.datetime64),
    # numpy's timedelta64 is a subclass of its integers, so this row precedes the numbers.
    ("duration", (datetime.timedelta, np.timedelta64)),
    ("number", numbers.Real),
)
_ARRAYS = {"M": "datetime64", "m": "duration", **dict.fromkeys("fiu", "number")}


def entries(value: Any, name: str, allowed: str) -> tuple[str, list[Any], tuple[int, ...]]:
    """The kind of a value, its entries as a flat list, and the shape in which they were given.

    One Time array, or one array of numbers, is a single entry of shape ().
    """
    if isinstance(value, (list, tuple)) and isinstance(_first(value), (int, float)):
        # numpy converts long lists of numbers fast; the code below reports what it refuses.
        with suppress(ValueError, TypeError):
            array = np.asarray(value)
            if array.dtype.kind in "fiu":
                return "number", [array], ()
    leaves, shape = _leaves(value, name)
    kinds = {_kind(leaf) for leaf in leaves if leaf is not np.ma.masked}
    if None in kinds:
        wrong = next(leaf for leaf in leaves if _kind(leaf) is None)
        raise AttitudeError(
            f"{name} {'is' if shape == () else 'holds'} {validation.shown(wrong)}; give {allowed}."
        )
    names = sorted(kind for kind in kinds if kind is not None)
    if len(names) > 1:
        raise AttitudeError(
            f"{name} mixes entries of several kinds ({', '.join(names)}); give all in one."
        )
    return names[0] if names else "number", leaves, shape


def _first(values):
    """The first entry of nested lists; None if they are empty."""
    while isinstance(values, (list, tuple)):
        if not values:
            return None
        values = values[0]
    return values


def _leaves(value: Any, name: str) -> tuple[list[Any], tuple[int, ...]]:
    """The entries of nested lists or of an array as a flat list, and their shape."""
    if isinstance(value, (list, tuple)):
        parts = [_leaves(item, name) for item in value]
        shapes = {shape for _, shape in parts}
        if len(shapes) > 1:
            raise AttitudeError(f"{name} is ragged; give an array with rows of equal length.")
        leaves = [leaf for inner, _ in parts for leaf in inner]
        return leaves, (len(value), *(shapes.pop() if shapes else ()))
    array = _array(value)
    if array is None:
        return [value], ()
    if array.dtype.kind in "SUO":
        mask = np.ma.getmaskarray(array).ravel()
        texts = np.ma.getdata(array).astype("U") if array.dtype.kind == "S" else array
        leaves = np.ma.getdata(texts).ravel().tolist()
        return [np.ma.masked if m else e for m, e in zip(mask, leaves, strict=True)], array.shape
    return [array], ()


def _array(value):
    """An array as it is (with its mask and unit), any array-like object as one, else None."""
    if isinstance(value, np.ndarray):
        return value
    if hasattr(value, "__array__") and not isinstance(value, np.generic) and _kind(value) is None:
        return np.asarray(value)
    return None


def _kind(value: Any) -> str | None:
    """The kind of one entry, or None for a type that is not allowed."""
    if isinstance(value, (bool, np.bool_)):
        return None
    if isinstance(value, str):
        # A date of four digits begins "2026-"; other text may be a length such as "3 d".
        is_length = value[4:5] != "-" and quantity_text.is_quantity(value)
        return "text length" if is_length else "text"
    for kind, types in _TYPES:
        if isinstance(value, types):
            return kind
    if isinstance(value, np.ndarray):
        return _ARRAYS.get(value.dtype.kind)
    if hasattr(value, "whole") and hasattr(value, "tt_fraction"):
        return "skyfield Time"
    # A caller who holds a Time has imported astropy already; other callers need not load it.
    module = sys.modules.get("astropy.time")
    if module is not None and isinstance(value, module.TimeDelta):
        return "TimeDelta"
    return "astropy Time" if module is not None and isinstance(value, module.Time) else None


# ---- A reader for each kind of epoch: a flat list of entries to TDB in two doubles

# The first Julian date of ERFA's calendar.
_FIRST_JD = 0.0
# 10000-01-01: the limit of calendars of four digits.
_LAST_JD = 5373484.5


def read(
    kind: str, leaves: list[Any], shape: tuple[int, ...], name: str, start: Instant | None = None
) -> tuple[FloatArray, FloatArray | None]:
    """The entries of `attitude.epochs._inputs.entries` in two doubles; NaN where masked.

    hi, lo: of the shape given.  TDB seconds past J2000 for dates; for the kinds in `LENGTHS`,
        seconds from `start`, and lo may be None.
    """
    # A reader takes a list and returns two arrays (or one and None), its entries along axis 0.
    reader = _each(partial(_time_delta, start)) if kind == "TimeDelta" else _READERS[kind]
    values = [leaf for leaf in leaves if leaf is not np.ma.masked]
    results: list[Any] = []
    for result in reader(values, name):
        if result is not None and len(values) < len(leaves):
            full = np.full((len(leaves), *result.shape[1:]), np.nan)
            full[[leaf is not np.ma.masked for leaf in leaves]] = result
            result = full
        results.append(None if result is None else result.reshape((*shape, *result.shape[1:])))
    hi, lo = results
    return hi, lo


def _stacked(rows, name):
    """Arrays of equal shape as one with a new first axis."""
    if len({np.shape(row) for row in rows}) > 1:
        raise AttitudeError(f"{name} is ragged; give entries of equal shape.")
    return np.asarray(rows[0])[None] if len(rows) == 1 else np.stack(rows)


def _each(read_one):
    """The reader of a list of epochs, by that of one entry."""

    def reader(leaves, name):
        both = zip(*(read_one(leaf, name) for leaf in leaves), strict=True)
        return [_stacked(rows, name) for rows in both]

    return reader


def _lengths(read_one):
    """The reader of a list of lengths of time, by that of one entry in seconds."""

    def reader(leaves, name):
        rows = [read_one(leaf, name) for leaf in leaves]
        return _stacked(rows, name) if rows else np.zeros(0), None

    return reader


# ---- Lengths of time: list of entries -> seconds from the start


def _floats(value, name):
    """One array or number as float64 seconds, NaN where masked."""
    value, mask = validation.unmasked(value)
    seconds = validation.real(value, name, unit="s", finite=False)
    if mask is not None:
        seconds[mask] = np.nan
    return seconds


def _duration(leaf, name):
    """A timedelta or timedelta64s as seconds; NaT as NaN."""
    if not isinstance(leaf, datetime.timedelta) and np.datetime_data(leaf.dtype)[0] in ("Y", "M"):
        raise AttitudeError(
            f"{name} is {validation.shown(leaf)}, years or months, which have no fixed length; "
            "give days or a smaller unit."
        )
    seconds = leaf.total_seconds() if isinstance(leaf, datetime.timedelta) else leaf / _SECOND
    return np.asarray(seconds, dtype=np.float64)


_SECOND = np.timedelta64(1, "s")


def _time_delta(start, delta, name):
    """The seconds of TDB from start to the epoch that astropy computes as start + delta."""
    days, mask = validation.unmasked(delta.jd1)
    hi, lo = _time_scales.seconds_from_days(
        _nan_where(mask, days), validation.unmasked(delta.jd2)[0]
    )
    scale = delta.scale
    if scale in (None, "tdb"):
        return hi, lo
    if scale == "tcb":
        return _time_scales.scaled(hi, lo, "tcb")
    if scale == "tcg":
        hi, lo = _time_scales.scaled(hi, lo, "tcg")
    elif scale not in ("tai", "tt"):
        raise AttitudeError(
            f"{name} is a TimeDelta in the scale {scale!r}; give it in TAI, TT, TDB, TCG or TCB."
        )
    tt = _time_scales.tt_from_tdb(np.float64(start.seconds), np.float64(start.low))
    # The difference of two small numbers: a delta of 0 stays exactly 0.
    later = _time_scales.difference_at(*pairs.add((hi, lo), *tt))
    change = later - _time_scales.difference_at(*tt)
    return pairs.add((hi, lo), change)


# ---- Epochs: list of entries -> TDB seconds past J2000 in two doubles


def _instants(leaves, name):
    return np.array([(leaf.seconds, leaf.low) for leaf in leaves]).reshape(-1, 2).T


def _astropy_time(time, name):
    jd1, mask = validation.unmasked(time.jd1)
    jd1, jd2 = _nan_where(mask, jd1), np.asarray(validation.unmasked(time.jd2)[0])
    _refuse_far_years(jd1, name)
    scale, difference = time.scale, None
    if scale == "local":
        raise AttitudeError(
            f"{name} is a Time in the scale 'local', which has no relation to other scales; give "
            f"it in one of {', '.join(epochs_instants.SCALES)}."
        )
    # The attributes in which astropy stores delta_tdb_tt and delta_ut1_utc if a user sets them.
    if getattr(time, "_delta_tdb_tt", None) is not None:
        difference = _constant(time._delta_tdb_tt)
    elif time.location is not None:
        difference = partial(_time_scales.tdb_minus_tt_at, time.location)
    if scale == "utc":
        hi, lo = _time_scales.tai_from_utc_jd(jd1, jd2)
        return _time_scales.tdb_from("tai", hi, lo, difference)
    hi, lo = _time_scales.seconds_from_jd(jd1, jd2)
    if scale == "ut1":
        set_by_user = validation.unmasked(getattr(time, "_delta_ut1_utc", None))[0]
        hi, lo = _time_scales.tai_from_ut1(hi, lo, name, set_by_user)
        scale = "tai"
    return _time_scales.tdb_from(scale, hi, lo, difference)


def _constant(seconds):
    """TDB - TT as a function of the epoch that returns the seconds given."""
    known = np.asarray(validation.unmasked(seconds)[0], dtype=np.float64)
    return lambda hi, lo: known


def _skyfield_time(time, name):
    whole = np.asarray(time.whole, dtype=np.float64)
    _refuse_far_years(whole, name)
    hi, lo = _time_scales.seconds_from_jd(whole, np.asarray(time.tt_fraction, dtype=np.float64))
    return _time_scales.tdb_from("tt", hi, lo)


def _datetimes(leaves, name):
    parts = np.array([_civil(leaf, name) for leaf in leaves], dtype=np.float64)
    day, second, micro, nano = parts.T
    return tdb_of_day("utc", day, second, micro * 1e-6 + nano * 1e-9, name)


def _civil(moment, name):
    """Day, second, microsecond, nanosecond of UTC; NaN for pandas' NaT, a subclass of datetime."""
    if moment != moment:
        return (math.nan,) * 4
    if not isinstance(moment, datetime.datetime):
        moment = datetime.datetime.combine(moment, datetime.time())
    if moment.utcoffset() is not None:
        try:
            moment = moment.astimezone(datetime.UTC)
        except OverflowError as err:
            raise AttitudeError(
                f"{name} is {validation.shown(moment)}, which in UTC lies outside of the years 1 "
                "to 9999; give an epoch within them."
            ) from err
    return (
        moment.toordinal() + _time_scales.MJD_OF_ORDINAL_0,
        (moment.hour * 60 + moment.minute) * 60 + moment.second,
        moment.microsecond,
        getattr(moment, "nanosecond", 0),
    )


def _datetime64(moments, name):
    moments, mask = validation.unmasked(moments)
    moments = np.asarray(moments)
    # A bare NaT has no unit; numpy's integers overflow with the attoseconds of a second.
    unit = {"generic": "s", "as": "fs"}.get(np.datetime_data(moments.dtype)[0])
    moments = moments.astype(f"M8[{unit}]") if unit else moments
    unknown = np.isnat(moments) if mask is None else np.isnat(moments) | mask
    moments = np.where(unknown, moments.dtype.type(0, "s").astype(moments.dtype), moments)
    # numpy cannot convert years to picoseconds, and overflows silently from years to seconds.
    fine = np.datetime_data(moments.dtype)[0] in ("ms", "us", "ns", "ps", "fs")
    year = 1970 + (moments.astype("M8[s]") if fine else moments).astype("M8[Y]").astype(np.int64)
    if np.any((year < -4712) | (year > 9999)):
        _refuse_far_years(np.float64(np.inf), name)
    # numpy rounds down to the coarser unit: the rest is not negative.
    second = moments.astype("M8[s]")
    fractions = (moments - second) / _SECOND
    day, second = np.divmod(second.astype(np.int64), int(DAY_S))
    day = np.where(unknown, np.nan, day + float(_time_scales.MJD_OF_1970))
    return tdb_of_day("utc", day, second.astype(np.float64), fractions, name)


def of_text(date: str, name: str) -> tuple[float, float]:
    """One date as text in two doubles: the bits that `read` gives it, in a fifth of the time."""
    scale, day, second, low = epochs_instants.parsed(date, name)
    hi, lo = tdb_of_day(scale, float(day), float(second), low, name)
    return float(hi), float(lo)


def _texts(leaves, name):
    scales, *parts = zip(*[epochs_instants.parsed(leaf, name) for leaf in leaves], strict=True)
    day, second, low = (np.array(column, dtype=np.float64) for column in parts)
    scales = np.array(scales)
    hi, lo = np.empty(len(leaves)), np.empty(len(leaves))
    for scale in sorted(set(scales.tolist())):
        in_scale = scales == scale
        parts = (column[in_scale] for column in (day, second, low))
        hi[in_scale], lo[in_scale] = tdb_of_day(scale, *parts, name)
    return hi, lo


_READERS: dict[str, Callable[..., Any]] = {
    "number": _lengths(_floats),
    "text length": _lengths(partial(validation.real, unit="s")),
    "duration": _lengths(_duration),
    "text": _texts,
    "Instant": _instants,
    "datetime": _datetimes,
    "datetime64": _each(_datetime64),
    "astropy Time": _each(_astropy_time),
    "skyfield Time": _each(_skyfield_time),
}


def tdb_of_day(
    scale: str,
    day: FloatArray | float,
    second: FloatArray | float,
    low: FloatArray | float,
    name: str,
) -> Any:
    """TDB of a civil day (modified Julian date) and the seconds second + low since its midnight."""
    if scale == "utc":
        return _time_scales.tdb_from("tai", *_time_scales.tai_from_utc_day(day, second, low))
    hi, lo = pairs.add(((day - MJD_OF_J2000) * DAY_S, 0.0 * day), second, low)
    if scale == "ut1":
        return _time_scales.tdb_from("tai", *_time_scales.tai_from_ut1(hi, lo, name))
    return _time_scales.tdb_from(scale, hi, lo)


def _nan_where(mask, values):
    values = np.asarray(values, dtype=np.float64)
    return values if mask is None else np.where(mask, np.nan, values)


def _refuse_far_years(jd, name):
    if ((jd < _FIRST_JD) | (jd >= _LAST_JD)).any():  # NaN is neither
        raise AttitudeError(
            f"{name} lies outside of the years -4712 to 9999, the range of the conversions of time "
            "scales; give an epoch within it, or plain seconds since one."
        )


DATES: str = (
    'an ISO date in UTC such as "2026-01-01T00:00:00", an astropy or skyfield Time, a datetime '
    "or a numpy datetime64"
)
# Seconds in this range, 27.8 to 28.9 days, are Julian dates of the years 1858 to 2132 more often.
_FIRST_PLAIN_JD = 2.4e6
_LAST_PLAIN_JD = 2.5e6
_DATES_OR_SECONDS = (
    f'plain seconds, a time Quantity, a TimeDelta or text such as "3 d", or dates: {DATES}'
)


def instant(value: Epoch, name: str = "epoch") -> Instant:
    """One epoch of any type as an `Instant`.

    Parameters
    ----------
    value : str, astropy Time, skyfield Time, datetime, date, datetime64 or Instant
        One epoch; the top of `attitude.epochs._inputs` describes the types.
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
        return Instant(*of_text(value, name))
    kind, leaves, shape = entries(value, name, DATES)
    if kind in LENGTHS:
        seconds = read(kind, leaves, shape, name)[0] if kind == "number" else np.zeros(())
        hint = ", a length of time" if seconds.shape == () and seconds == seconds else ""
        raise AttitudeError(f"{name} is {validation.shown(value)}{hint}; give an epoch: {DATES}.")
    hi, lo = read(kind, leaves, shape, name)
    assert lo is not None  # a date has both doubles
    if hi.shape != ():
        raise AttitudeError(f"{name} has shape {hi.shape}; give one epoch.")
    if not math.isfinite(hi):
        raise AttitudeError(
            f"{name} is {validation.shown(value)}, which is not an epoch; give {DATES}."
        )
    return Instant(float(hi), float(lo))


def seconds_since(
    start: Epoch, t: Epochs, low: ArrayLike | None = None, name: str = "t"
) -> pairs.Seconds:
    """TDB seconds from an instant to other epochs, in two doubles.

    Parameters
    ----------
    start : anything that `instant` takes
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
    start = instant(start, "start")
    hi = _ready(t)
    if hi is None:
        kind, leaves, shape = entries(t, name, _DATES_OR_SECONDS)
        if kind == "number":
            hi, _ = read(kind, leaves, shape, name)
    if hi is not None:
        if low is None and hi.size and _FIRST_PLAIN_JD <= hi.item(0) <= _LAST_PLAIN_JD:
            _warn_of_julian_dates(hi, name)
        return pairs.Seconds(hi, _low(low, hi.shape, name))
    if low is not None:
        raise AttitudeError(
            f"low is given, but {name} is {validation.shown(t)}; leave out low, the second double "
            "of plain seconds: dates and durations do not need it."
        )
    if kind in LENGTHS:
        return pairs.Seconds(*read(kind, leaves, shape, name, start))
    dates, dates_low = read(kind, leaves, shape, name)
    assert dates_low is not None  # a date has both doubles
    hi, lo = pairs.add((dates, dates_low), -start.seconds, -start.low)
    return pairs.Seconds(np.asarray(hi), np.asarray(lo))


def one_since(start: Instant, t: Epochs, name: str = "t") -> tuple[float, float]:
    """TDB seconds, hi and lo, from an instant to one finite epoch, else an AttitudeError."""
    hi, lo = seconds_since(start, t, name=name)
    if hi.ndim:
        raise AttitudeError(f"{name} holds {hi.size} epochs; give one finite epoch.")
    if not math.isfinite(hi):
        raise AttitudeError(f"{name} is {validation.shown(t)}; give one finite epoch.")
    return float(hi), 0.0 if lo is None else float(lo)


def _warn_of_julian_dates(t: FloatArray, name: str) -> None:
    """AttitudeWarning if all seconds are in the range of the Julian dates of 1858 to 2132."""
    if not np.all((t >= _FIRST_PLAIN_JD) & (t <= _LAST_PLAIN_JD)):
        return
    warnings.warn(
        f"{name} is {validation.shown(float(t.flat[0]))}, taken for seconds since the epoch, but "
        'it looks like a Julian date; give a date such as "2026-01-01" or astropy.time.Time('
        f'{float(t.flat[0])!r}, format="jd"), or the seconds as a Quantity.',
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
    kind, leaves, shape = entries(t, name, DATES)
    if kind in LENGTHS:
        raise AttitudeError(f"{name} is {validation.shown(t)}; give {DATES}.")
    hi, lo = read(kind, leaves, shape, name)
    assert lo is not None  # a date has both doubles
    return hi, lo


def plain_seconds(
    seconds: ArrayLike, low: ArrayLike | None = None, name: str = "seconds"
) -> pairs.Seconds:
    """Seconds and their second double as float64 arrays of one shape; `low` may be None.

    Raises
    ------
    AttitudeError
        For dates, durations and other types, ragged lists, and `low` of another shape.
    """
    hi = _numbers(seconds, name, " (at(t) reads dates too)")
    return pairs.Seconds(hi, _low(low, hi.shape, name))


def _ready(seconds: Any) -> FloatArray | None:
    """Plain seconds that need no reading as an array, a float64 array as it is; None for others."""
    if type(seconds) is np.ndarray and seconds.dtype == np.float64:
        return seconds
    if type(seconds) is float or (type(seconds) is int and abs(seconds) < 2**53):
        return np.array(float(seconds))
    return None


def _numbers(seconds: Any, name: str, hint: str = "") -> FloatArray:
    """Plain seconds as an array; AttitudeError, which ends in the hint, for other kinds."""
    hi = _ready(seconds)
    if hi is not None:
        return hi
    kind, leaves, shape = entries(seconds, name, "plain seconds")
    if kind != "number":
        raise AttitudeError(f"{name} is {validation.shown(seconds)}; give plain seconds{hint}.")
    return read(kind, leaves, shape, name)[0]


def _low(low: Any, shape: tuple[int, ...], name: str) -> FloatArray | None:
    """The second double of plain seconds, broadcast to the shape of the first."""
    if low is None:
        return None
    seconds = _numbers(low, "low")
    if seconds.shape == shape:
        return seconds
    if seconds.shape != ():
        raise AttitudeError(
            f"low has shape {seconds.shape}, {name} has {shape}; give both in the same shape."
        )
    return np.broadcast_to(seconds, shape)
