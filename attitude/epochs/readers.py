"""What people give as epochs, of whatever kind and shape, read into TDB in two doubles.

`attitude.epochs` says what is taken, and asks here; each kind has a reader, which takes a flat list
of its entries.
"""

import datetime
import math
import numbers
import sys
from contextlib import suppress
from functools import partial

import numpy as np

from attitude import pairs, validation
from attitude.epochs import text, time_scales
from attitude.epochs.instants import Instant
from attitude.errors import AttitudeError

# Modified Julian date of 1970-01-01.
_MJD_OF_1970 = 40587
# Julian dates 0 and 10000-01-01: where calendars of four digits and ERFA's own end.
_FIRST_JD, _LAST_JD = 0.0, 5373484.5

# Kinds that are lengths of time and no moments.
LENGTHS = ("number", "duration", "TimeDelta")


def opened(value, name, allowed):
    """The kind of a value, its entries as a flat list, and the shape they were given in.

    One Time array, or one array of numbers, is a single entry of shape ().  Entries that a masked
    array leaves out are `numpy.ma.masked` here.
    """
    if isinstance(value, (list, tuple)) and isinstance(_first(value), (int, float)):
        # Long lists of numbers are numpy's business; what it cannot make of them is told below.
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
    if len(kinds) > 1:
        raise AttitudeError(
            f"{name} mixes entries of several kinds ({', '.join(sorted(kinds))}); give all in one."
        )
    return kinds.pop() if kinds else "number", leaves, shape


def _first(values):
    """The first entry of nested lists that is no list."""
    while isinstance(values, (list, tuple)):
        if not values:
            return None
        values = values[0]
    return values


def _leaves(value, name):
    if isinstance(value, (list, tuple)):
        parts = [_leaves(each, name) for each in value]
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
    """A numpy array with its mask and unit, of whatever numpy can make one of; else None."""
    if isinstance(value, np.ndarray):
        return value
    if hasattr(value, "__array__") and not isinstance(value, np.generic) and _kind(value) is None:
        return np.asarray(value)
    return None


def _kind(value):
    """One of the kinds of things that this file takes, or None."""
    if isinstance(value, (bool, np.bool_)):
        return None
    for kind, types in _TYPES:
        if isinstance(value, types):
            return kind
    if isinstance(value, np.ndarray):
        return {"M": "datetime64", "m": "duration"}.get(
            value.dtype.kind, "number" if value.dtype.kind in "fiu" else None
        )
    if hasattr(value, "whole") and hasattr(value, "tt_fraction"):
        return "skyfield Time"
    # Whoever holds a Time has imported astropy; nobody else needs to wait for it.
    module = sys.modules.get("astropy.time")
    if module is not None and isinstance(value, module.TimeDelta):
        return "TimeDelta"
    return "astropy Time" if module is not None and isinstance(value, module.Time) else None


_TYPES = (
    ("text", str),
    ("Instant", Instant),
    ("datetime", datetime.datetime),
    ("datetime64", np.datetime64),
    # numpy's timedelta64 is one of its integers, so it stands before the numbers.
    ("duration", (datetime.timedelta, np.timedelta64)),
    ("number", numbers.Real),
)


def _scattered(reader, leaves, shape, name):
    """What the reader makes of the entries, in the shape given and NaN where masked.

    A reader takes a list and returns two arrays (or one and None) with its entries along the first
    axis.
    """
    given = [leaf for leaf in leaves if leaf is not np.ma.masked]
    results = []
    for result in reader(given, name):
        if result is not None and len(given) < len(leaves):
            full = np.full((len(leaves), *result.shape[1:]), np.nan)
            full[[leaf is not np.ma.masked for leaf in leaves]] = result
            result = full
        results.append(None if result is None else result.reshape((*shape, *result.shape[1:])))
    return results


def read(kind, leaves, shape, name, start=None):
    """Two arrays of the shape given (or one and None), NaN where masked.

    TDB seconds past J2000 for dates; for what `LENGTHS` names, seconds from `start`.
    """
    reader = _READERS[kind]
    return _scattered(
        partial(reader, start) if kind == "TimeDelta" else reader, leaves, shape, name
    )


def _stacked(pairs, name):
    """Pairs of arrays of equal shape as one pair with a new first axis."""
    if len(pairs) == 1:
        return [np.asarray(each)[None] for each in pairs[0]]
    shapes = {np.shape(hi) for hi, _ in pairs}
    if len(shapes) > 1:
        raise AttitudeError(f"{name} is ragged; give entries of equal shape.")
    return np.stack([hi for hi, _ in pairs]), np.stack([lo for _, lo in pairs])


def _unmasked(value):
    """The data without its mask, and the mask or None; of numpy's kind and of astropy's."""
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


# Seconds from the start ---------------------------------------------------------------------------


def _numbers(leaves, name):
    """Plain numbers and quantities as float64 seconds."""
    if not leaves:
        return np.zeros(0), None
    rows = [_floats(leaf, name) for leaf in leaves]
    return _stacked([(row, row) for row in rows], name)[0], None


def _floats(value, name):
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


_SECOND = np.timedelta64(1, "s")


def _time_deltas(start, leaves, name):
    return _stacked([_time_delta(start, leaf, name) for leaf in leaves], name)


def _time_delta(start, delta, name):
    """The seconds of TDB from start to what astropy calls start + delta."""
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
    # The small difference of two small differences: a delta of 0 is 0.
    change = time_scales.difference_at(*pairs.add((hi, lo), *tt)) - time_scales.difference_at(*tt)
    return pairs.add((hi, lo), change)


# A reader for each kind of epoch: list of entries -> TDB seconds past J2000 in two doubles --------


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
            f"{name} is a Time in the scale 'local', which is tied to no other; give it in one of "
            f"{', '.join(text.SCALES)}."
        )
    # astropy keeps what a user sets with delta_tdb_tt and delta_ut1_utc under these names.
    if getattr(time, "_delta_tdb_tt", None) is not None:
        difference = _constant(time._delta_tdb_tt)
    elif time.location is not None:
        difference = partial(time_scales.tdb_minus_tt_at, time.location)
    if scale == "utc":
        hi, lo = time_scales.tai_from_utc_jd(jd1, jd2)
        return time_scales.tdb_from("tai", hi, lo, difference)
    hi, lo = time_scales.seconds_from_jd(jd1, jd2)
    if scale == "ut1":
        set_by_hand = _unmasked(getattr(time, "_delta_ut1_utc", None))[0]
        hi, lo = time_scales.tai_from_ut1(hi, lo, name, set_by_hand)
        scale = "tai"
    return time_scales.tdb_from(scale, hi, lo, difference)


def _constant(seconds):
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
    """Day, second, microsecond and nanosecond of UTC; NaN for pandas' NaT, which is a datetime."""
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
        moment.toordinal() + text.MJD_OF_ORDINAL_0,
        (moment.hour * 60 + moment.minute) * 60 + moment.second,
        moment.microsecond,
        getattr(moment, "nanosecond", 0),
    )


def _datetimes64(leaves, name):
    return _stacked([_datetime64(leaf, name) for leaf in leaves], name)


def _datetime64(moments, name):
    moments, mask = _unmasked(moments)
    moments = np.asarray(moments)
    # A bare NaT has no unit; attoseconds are too many in a second for numpy's own arithmetic.
    unit = {"generic": "s", "as": "fs"}.get(np.datetime_data(moments.dtype)[0])
    moments = moments.astype(f"M8[{unit}]") if unit else moments
    unknown = np.isnat(moments) if mask is None else np.isnat(moments) | mask
    moments = np.where(unknown, moments.dtype.type(0, "s").astype(moments.dtype), moments)
    # numpy knows no factor from years to picoseconds, and wraps silently from years to seconds.
    fine = np.datetime_data(moments.dtype)[0] in ("ms", "us", "ns", "ps", "fs")
    year = 1970 + (moments.astype("M8[s]") if fine else moments).astype("M8[Y]").astype(np.int64)
    if np.any((year < -4712) | (year > 9999)):
        _refuse_far_years(np.float64(np.inf), name)
    # numpy rounds down to the coarser unit, so the rest is never negative.
    second = moments.astype("M8[s]")
    rest = (moments - second) / _SECOND
    day, second = np.divmod(second.astype(np.int64), 86400)
    day = np.where(unknown, np.nan, day + float(_MJD_OF_1970))
    return tdb_of_day("utc", day, second.astype(np.float64), rest, name)


def _texts(leaves, name):
    scales, *parts = zip(*[text.parsed(leaf, name) for leaf in leaves], strict=True)
    day, second, low = (np.array(part, dtype=np.float64) for part in parts)
    scales = np.array(scales)
    hi, lo = np.empty(len(leaves)), np.empty(len(leaves))
    for scale in sorted(set(scales.tolist())):
        here = scales == scale
        hi[here], lo[here] = tdb_of_day(scale, day[here], second[here], low[here], name)
    return hi, lo


_READERS = {
    "number": _numbers,
    "duration": _durations,
    "TimeDelta": _time_deltas,
    "text": _texts,
    "Instant": _instants,
    "datetime": _datetimes,
    "datetime64": _datetimes64,
    "astropy Time": _astropy_times,
    "skyfield Time": _skyfield_times,
}


def tdb_of_day(scale, day, second, low, name):
    """TDB of a civil day (modified Julian date) and the seconds since its midnight, in a scale."""
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
            f"{name} lies outside of the years -4712 to 9999, for which time scales are converted; "
            "give an epoch within them, or plain seconds from one."
        )
