"""A reader for each kind of epoch: a flat list of entries to TDB in two doubles."""

from __future__ import annotations

import datetime
import math
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from attitude import pairs, validation
from attitude.epochs import text, time_scales
from attitude.errors import AttitudeError

if TYPE_CHECKING:
    from collections.abc import Callable

    from attitude.annotations import FloatArray
    from attitude.epochs.instants import Instant

# Modified Julian date of 1970-01-01.
_MJD_OF_1970 = 40587
# Julian dates 0 and 10000-01-01: the limits of calendars of four digits, and of ERFA's calendar.
_FIRST_JD, _LAST_JD = 0.0, 5373484.5


def read(
    kind: str, leaves: list[Any], shape: tuple[int, ...], name: str, start: Instant | None = None
) -> tuple[FloatArray, FloatArray | None]:
    """The entries of `attitude.epochs.kinds.entries` in two doubles; NaN where masked.

    Returns
    -------
    hi, lo : arrays
        Of the shape given.  TDB seconds past J2000 for dates; for the kinds in `kinds.LENGTHS`,
        seconds from `start`, and lo may be None.
    """
    reader = _READERS[kind]
    return _scattered(
        partial(reader, start) if kind == "TimeDelta" else reader, leaves, shape, name
    )


def _scattered(
    reader: Callable[..., Any], leaves: list[Any], shape: tuple[int, ...], name: str
) -> tuple[FloatArray, FloatArray | None]:
    """The results of a reader in the shape given, NaN where masked.

    A reader takes a list and returns two arrays (or one and None) with its entries along the first
    axis.
    """
    given = [leaf for leaf in leaves if leaf is not np.ma.masked]
    results: list[Any] = []
    for result in reader(given, name):
        if result is not None and len(given) < len(leaves):
            full = np.full((len(leaves), *result.shape[1:]), np.nan)
            full[[leaf is not np.ma.masked for leaf in leaves]] = result
            result = full
        results.append(None if result is None else result.reshape((*shape, *result.shape[1:])))
    hi, lo = results
    return hi, lo


def _stacked(pairs, name):
    """Pairs of arrays of equal shape as one pair with a new first axis."""
    if len(pairs) == 1:
        return [np.asarray(each)[None] for each in pairs[0]]
    shapes = {np.shape(hi) for hi, _ in pairs}
    if len(shapes) > 1:
        raise AttitudeError(f"{name} is ragged; give entries of equal shape.")
    return np.stack([hi for hi, _ in pairs]), np.stack([lo for _, lo in pairs])


def _unmasked(value):
    """The data without its mask, and the mask or None, for masked arrays of numpy and astropy."""
    if isinstance(value, np.ma.MaskedArray):
        unit = getattr(value, "unit", None)
        return _with_unit(np.ma.getdata(value), unit), np.ma.getmaskarray(value)
    if hasattr(value, "unmasked") and hasattr(value, "mask"):
        return value.unmasked, np.asarray(value.mask)
    return value, None


def _with_unit(data, unit):
    if unit is None:
        return data
    from astropy.units import Quantity

    return Quantity(np.asarray(data), unit)


# Lengths of time: list of entries -> seconds from the start ---------------------------------------


def _numbers(leaves, name):
    """Plain numbers and quantities as float64 seconds."""
    if not leaves:
        return np.zeros(0), None
    rows = [_floats(leaf, name) for leaf in leaves]
    return _stacked([(row, row) for row in rows], name)[0], None


def _floats(value, name):
    """One array or number as float64 seconds, NaN where masked."""
    value, mask = _unmasked(value)
    if not hasattr(value, "to_value"):
        value = _with_unit(value, getattr(value, "unit", None))  # a column of a table
    seconds = validation.real(value, name, unit="s", finite=False)
    if mask is not None:
        seconds[mask] = np.nan
    return seconds


def _durations(leaves, name):
    """timedelta and timedelta64 as seconds; NaT as NaN."""
    rows = [
        leaf.total_seconds() if isinstance(leaf, datetime.timedelta) else leaf / _SECOND
        for leaf in leaves
    ]
    return np.stack([np.asarray(row, dtype=np.float64) for row in rows]), None


def _text_lengths(leaves, name):
    """Text such as "3 d" or "0, 6, 12 h" as seconds."""
    rows = [validation.real(leaf, name, unit="s") for leaf in leaves]
    return _stacked([(row, row) for row in rows], name)[0], None


_SECOND = np.timedelta64(1, "s")


def _time_deltas(start, leaves, name):
    return _stacked([_time_delta(start, leaf, name) for leaf in leaves], name)


def _time_delta(start, delta, name):
    """The seconds of TDB from start to the epoch that astropy computes as start + delta."""
    days, mask = _unmasked(delta.jd1)
    hi, lo = time_scales.seconds_from_days(_nan_where(mask, days), _unmasked(delta.jd2)[0])
    scale = delta.scale
    if scale in (None, "tdb"):
        return hi, lo
    if scale == "tcb":
        return time_scales.scaled(hi, lo, "tcb")
    if scale == "tcg":
        hi, lo = time_scales.scaled(hi, lo, "tcg")
    elif scale not in ("tai", "tt"):
        raise AttitudeError(
            f"{name} is a TimeDelta in the scale {scale!r}; give it in TAI, TT, TDB, TCG or TCB."
        )
    tt = time_scales.tt_from_tdb(np.float64(start.seconds), np.float64(start.low))
    # The difference of two small numbers: a delta of 0 stays exactly 0.
    change = time_scales.difference_at(*pairs.add((hi, lo), *tt)) - time_scales.difference_at(*tt)
    return pairs.add((hi, lo), change)


# Epochs: list of entries -> TDB seconds past J2000 in two doubles ---------------------------------


def _instants(leaves, name):
    return np.array([leaf.seconds for leaf in leaves]), np.array([leaf.low for leaf in leaves])


def _astropy_times(leaves, name):
    return _stacked([_astropy_time(leaf, name) for leaf in leaves], name)


def _astropy_time(time, name):
    jd1, mask = _unmasked(time.jd1)
    jd1, jd2 = _nan_where(mask, jd1), np.asarray(_unmasked(time.jd2)[0])
    _refuse_far_years(jd1, name)
    scale, difference = time.scale, None
    if scale == "local":
        raise AttitudeError(
            f"{name} is a Time in the scale 'local', which has no relation to other scales; give "
            f"it in one of {', '.join(text.SCALES)}."
        )
    # The attributes in which astropy stores delta_tdb_tt and delta_ut1_utc if a user sets them.
    if getattr(time, "_delta_tdb_tt", None) is not None:
        difference = _constant(time._delta_tdb_tt)
    elif time.location is not None:
        difference = partial(time_scales.tdb_minus_tt_at, time.location)
    if scale == "utc":
        hi, lo = time_scales.tai_from_utc_jd(jd1, jd2)
        return time_scales.tdb_from("tai", hi, lo, difference)
    hi, lo = time_scales.seconds_from_jd(jd1, jd2)
    if scale == "ut1":
        set_by_user = _unmasked(getattr(time, "_delta_ut1_utc", None))[0]
        hi, lo = time_scales.tai_from_ut1(hi, lo, name, set_by_user)
        scale = "tai"
    return time_scales.tdb_from(scale, hi, lo, difference)


def _constant(seconds):
    """TDB - TT as a function of the epoch that returns the seconds given."""
    known = np.asarray(_unmasked(seconds)[0], dtype=np.float64)
    return lambda hi, lo: known


def _skyfield_times(leaves, name):
    return _stacked([_skyfield_time(leaf, name) for leaf in leaves], name)


def _skyfield_time(time, name):
    whole = np.asarray(time.whole, dtype=np.float64)
    _refuse_far_years(whole, name)
    hi, lo = time_scales.seconds_from_jd(whole, np.asarray(time.tt_fraction, dtype=np.float64))
    return time_scales.tdb_from("tt", hi, lo)


def _datetimes(leaves, name):
    parts = np.array([_civil(leaf, name) for leaf in leaves], dtype=np.float64)
    day, second, micro, nano = parts.T
    return tdb_of_day("utc", day, second, micro * 1e-6 + nano * 1e-9, name)


def _civil(moment, name):
    """Day, second, microsecond, nanosecond of UTC; NaN for pandas' NaT, a subclass of datetime."""
    if moment != moment:
        return (math.nan,) * 4
    if moment.utcoffset() is not None:
        try:
            moment = moment.astimezone(datetime.UTC)
        except OverflowError as err:
            raise AttitudeError(
                f"{name} is {validation.shown(moment)}, which in UTC lies outside of the years 1 "
                "to 9999; give an epoch within them."
            ) from err
    return (
        moment.toordinal() + time_scales.MJD_OF_ORDINAL_0,
        (moment.hour * 60 + moment.minute) * 60 + moment.second,
        moment.microsecond,
        getattr(moment, "nanosecond", 0),
    )


def _datetimes64(leaves, name):
    return _stacked([_datetime64(leaf, name) for leaf in leaves], name)


def _datetime64(moments, name):
    moments, mask = _unmasked(moments)
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
    rest = (moments - second) / _SECOND
    day, second = np.divmod(second.astype(np.int64), 86400)
    day = np.where(unknown, np.nan, day + float(_MJD_OF_1970))
    return tdb_of_day("utc", day, second.astype(np.float64), rest, name)


def of_text(date: str, name: str) -> tuple[float, float]:
    """One date as text in two doubles: the bits that `read` gives it, in a fifth of the time."""
    scale, day, second, low = text.parsed(date, name)
    hi, lo = tdb_of_day(scale, float(day), float(second), low, name)
    return float(hi), float(lo)


def _texts(leaves, name):
    scales, *parts = zip(*[text.parsed(leaf, name) for leaf in leaves], strict=True)
    day, second, low = (np.array(part, dtype=np.float64) for part in parts)
    scales = np.array(scales)
    hi, lo = np.empty(len(leaves)), np.empty(len(leaves))
    for scale in sorted(set(scales.tolist())):
        here = scales == scale
        hi[here], lo[here] = tdb_of_day(scale, day[here], second[here], low[here], name)
    return hi, lo


_READERS: dict[str, Callable[..., Any]] = {
    "number": _numbers,
    "text length": _text_lengths,
    "duration": _durations,
    "TimeDelta": _time_deltas,
    "text": _texts,
    "Instant": _instants,
    "datetime": _datetimes,
    "datetime64": _datetimes64,
    "astropy Time": _astropy_times,
    "skyfield Time": _skyfield_times,
}


def tdb_of_day(
    scale: str,
    day: FloatArray | float,
    second: FloatArray | float,
    low: FloatArray | float,
    name: str,
) -> Any:
    """TDB of a civil day (modified Julian date) and the seconds second + low since its midnight.

    Parameters
    ----------
    scale : str
        utc, ut1, or a scale of `time_scales.tdb_from`.
    day, second, low : arrays of one shape, or floats
    name : str
        Name of the value in error messages.
    """
    if scale == "utc":
        return time_scales.tdb_from("tai", *time_scales.tai_from_utc_day(day, second, low))
    hi, lo = pairs.add(((day - 51544.5) * time_scales.DAY, 0.0 * day), second, low)
    if scale == "ut1":
        return time_scales.tdb_from("tai", *time_scales.tai_from_ut1(hi, lo, name))
    return time_scales.tdb_from(scale, hi, lo)


def _nan_where(mask, values):
    values = np.asarray(values, dtype=np.float64)
    return values if mask is None else np.where(mask, np.nan, values)


def _refuse_far_years(jd, name):
    if ((jd < _FIRST_JD) | (jd >= _LAST_JD)).any():  # NaN is neither
        raise AttitudeError(
            f"{name} lies outside of the years -4712 to 9999, the range of the conversions of time "
            "scales; give an epoch within it, or plain seconds since one."
        )
