"""Convert every time scale to TDB, for arrays, in two doubles.

With astropy the conversion of UTC to TDB costs 6 microseconds an epoch, nearly all of it in the
787 terms of TDB - TT.  That difference is smooth, with periods of a week and more, and is replaced
here by piecewise polynomials; leap seconds are steps, looked up once for each day that occurs.

An epoch is an unevaluated sum hi + lo of two float64 arrays: seconds since J2000, which is
2000-01-01 12:00 in its own scale (JD 2451545.0).  One double of seconds resolves 1e-7 s today
and one of days 1e-11 s; the sum of two doubles of seconds resolves 1e-21 s, and steps that are
exact in seconds (leap seconds, scale offsets, decimal input) stay exact.  NaN gives NaN.

Constants and tables are those of ERFA where it has them: its table of leap seconds is the one
that astropy uses and updates.  ERFA's "dubious year" warnings (UTC before 1960, or more than five
years past the release of its table) are suppressed: such dates are converted as by ERFA, with
TAI = UTC before 1960, and the last known leap second in the future.
"""

from __future__ import annotations

import datetime
from functools import lru_cache
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from attitude._solver import chebyshev
from attitude._support import pairs
from attitude._support.arrays import frozen
from attitude._support.constants import DAY_S, JD_OF_MJD_0, MJD_OF_J2000
from attitude.errors import AttitudeError

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import ArrayLike

    from attitude._support.annotations import FloatArray

    Doubles: TypeAlias = FloatArray | np.float64
    Pair: TypeAlias = tuple[Doubles, Doubles]


# Julian date of 2000-01-01 12:00.
J2000: float = 2451545.0
# rad.
ARCSEC: float = np.pi / 648000.0
# Modified Julian date of 1972-01-01, since when UTC differs from TAI by whole seconds.
_WHOLE_LEAPS = 41317.0
# That of the day before 0001-01-01, where Python's calendar begins.
MJD_OF_ORDINAL_0 = -678576
# That of 1970-01-01, from which numpy counts days and months.
MJD_OF_1970 = 40587
# That of 10000-01-01, where it ends.
YEAR_10000 = 2973484.0
# Seconds.
TT_MINUS_TAI: float = 32.184
TAI_MINUS_GPS: float = 19.0
# 1977-01-01T00:00:00 TAI, where TCG, TCB and TT agree: seconds since J2000, IAU 2000 B1.9.
_COMMON_EPOCH = -8400.5 * DAY_S + TT_MINUS_TAI

# TDB - TT in pieces of 16 days by polynomials of degree 16 errs by 2e-15 s against ERFA's series
# over 1900-2100, and 5e-15 s over 1000-3000, where the date itself rounds to 3e-15 s.
_PIECE = 16.0
_NODES = 17
# Records by number of the piece; 4096 are 0.7 MB and 180 years.
_pieces = chebyshev.KeptPieces(4096)


def seconds_from_days(days: Doubles, more: Doubles) -> Pair:
    """The sum of two doubles of days as a pair of seconds, exactly."""
    whole, whole_more = np.rint(days), np.rint(more)
    pair = (whole + whole_more) * DAY_S, 0.0 * whole
    pair = pairs.add(pair, *_stretched(days - whole, DAY_S))
    return pairs.add(pair, *_stretched(more - whole_more, DAY_S))


def seconds_from_jd(jd1: Doubles, jd2: Doubles) -> Pair:
    """A two-part Julian date of a uniform scale as seconds since J2000, exactly."""
    return seconds_from_days(jd1 - J2000, jd2)


def jd_from_seconds(hi: Doubles, lo: Doubles) -> Pair:
    """Seconds since J2000 as a two-part Julian date: a whole number, and a rest to 5e-12 s."""
    whole = np.rint(hi / DAY_S)
    return J2000 + whole, ((hi - whole * DAY_S) + lo) / DAY_S


def tai_from_utc_jd(jd1: Doubles, jd2: Doubles) -> Pair:
    """TAI of UTC in ERFA's two-part quasi Julian date, the convention of astropy's Time.

    A day with a leap second is 86401 s long in that convention, and its date runs slower.
    """
    whole = np.rint(jd1)
    noon = (jd1 - whole) + jd2
    shift = np.where(noon >= 0.5, 1.0, np.where(noon < -0.5, -1.0, 0.0))
    day = whole + shift - 2400001.0
    known = _utc_days(day)
    length = DAY_S + known[2]
    second, low = _stretched(noon - shift, length)
    return _tai_of_day(day, known, *pairs.two_sum(0.5 * length + second, low))


def tai_from_utc_day(day: Doubles | float, second: Any, low: Doubles | float = 0.0) -> Any:
    """TAI of UTC given as a civil day and the seconds second + low since its midnight."""
    if type(day) is float and _WHOLE_LEAPS <= day < YEAR_10000:
        import erfa

        civil = datetime.date.fromordinal(int(day) - MJD_OF_ORDINAL_0).timetuple()
        first = float(erfa.ufunc.dat(*civil[:3], 0.0)[0])
        return _tai_of_day(day, (first, 0.0, 0.0), second, low)
    return _tai_of_day(day, _utc_days(day), second, low)


def leap_of_day(day: ArrayLike) -> FloatArray:
    """Length of the civil day of UTC minus 86400, in s: 1 on leap days, fractions before 1972."""
    _, drift, jump = _utc_days(np.asarray(day, dtype=np.float64))
    return np.asarray(jump / (1.0 + drift))  # the jump is in seconds of TAI


def utc_day_from_tai(hi: Doubles, lo: Doubles) -> tuple[Doubles, Doubles, Doubles]:
    """UTC of TAI as civil day and seconds second + low since its midnight; see tai_from_utc_day.

    Steps of UTC before 1972 are kept as steps; ERFA's d2dtf spreads them over a day.
    """
    # TAI is ahead of UTC by 0 to some tens of seconds: the day of UTC is that of TAI or the one
    # before.
    day = np.floor(((hi + lo) / DAY_S) + MJD_OF_J2000)
    day = np.where(_since_midnight(day, hi, lo)[0] < 0.0, day - 1.0, day)
    second, low = _since_midnight(day, hi, lo)
    drift = _utc_days(day)[1]
    return day, *pairs.add((second, low), -drift / (1.0 + drift) * second)


def tai_from_ut1(
    hi: Doubles, lo: Doubles, name: str, ut1_minus_utc: ArrayLike | None = None
) -> Pair:
    """TAI of UT1 by the table of astropy-iers-data, or by a given UT1 - UTC in seconds."""
    import erfa

    if ut1_minus_utc is not None:
        jd1, jd2 = erfa.ufunc.ut1utc(*_filled(*jd_from_seconds(hi, lo)), ut1_minus_utc)[:2]
        return tai_from_utc_jd(jd1, np.where(np.isnan(hi), np.nan, jd2))
    # UT1 - TAI, some tens of seconds, changes by at most 5e-8 s a second.
    tai = hi
    for _ in range(3):
        (ut1_minus_tai, *_), outside = orientation_at(tai)
        tai = hi - ut1_minus_tai
    if np.any(outside):
        days = np.asarray(utc_day_from_tai(earth_rotation()[0][[0, -1]], np.zeros(2))[0])
        ordinals = (days - MJD_OF_ORDINAL_0).astype(int).tolist()
        first, last = map(datetime.date.fromordinal, ordinals)
        raise AttitudeError(
            f"{name} is in UT1 outside of {first} to {last}, the span of the installed table of "
            "the Earth's rotation (astropy-iers-data); give UTC, TT or TDB, or update "
            "astropy-iers-data."
        )
    return pairs.add((hi, lo), -ut1_minus_tai)


def tdb_from(
    scale: str, hi: Doubles, lo: Doubles, difference: Callable[..., Any] | None = None
) -> Pair:
    """TDB of a uniform scale: tai, gps, tt, tcg, tcb or tdb."""
    import erfa

    if scale == "tdb":
        return hi, lo
    if scale == "tcb":  # TDB = TCB - L_B (TCB - T_0) + TDB_0 (IAU 2006 B3)
        return pairs.add((hi, lo), erfa.TDB0 - erfa.ELB * ((hi - _COMMON_EPOCH) + lo))
    if scale == "tai":
        hi, lo = pairs.add((hi, lo), TT_MINUS_TAI)
    elif scale == "gps":
        hi, lo = pairs.add((hi, lo), TT_MINUS_TAI + TAI_MINUS_GPS)
    elif scale == "tcg":  # TT = TCG - L_G (TCG - T_0) (IAU 2000 B1.9)
        hi, lo = pairs.add((hi, lo), -erfa.ELG * ((hi - _COMMON_EPOCH) + lo))
    return pairs.add((hi, lo), (difference or difference_at)(hi, lo))


def scaled(hi: Doubles, lo: Doubles, scale: str) -> Pair:
    """A length of time in TCB as one in TDB, or in TCG as one in TT, by the secular rate only."""
    import erfa

    return pairs.add((hi, lo), -{"tcb": erfa.ELB, "tcg": erfa.ELG}[scale] * (hi + lo))


def tt_from_tdb(hi: Doubles, lo: Doubles) -> Pair:
    """TT of TDB at the geocentre, the inverse of ``tdb_from("tt", ...)`` to 1e-16 s."""
    # The difference changes by 3e-10 s a second: the first iterate errs by 5e-13 s.
    first = difference_at(hi, lo)
    return pairs.add((hi, lo), -difference_at(hi - first, lo))


def difference_at(hi: Doubles, lo: Doubles) -> FloatArray:
    """TDB - TT in seconds for a pair of seconds of TT; see `tdb_minus_tt`."""
    return tdb_minus_tt(J2000, (hi + lo) / DAY_S)


def tdb_minus_tt(tt_jd1: ArrayLike, tt_jd2: ArrayLike = 0.0) -> FloatArray:
    """TDB - TT at the geocentre, in seconds: ERFA's dtdb (Fairhead and Bretagnon 1990).

    By polynomials, 0.1 us in place of 7, where 17 epochs or more lie in one piece of 16 days.
    """
    if type(tt_jd1) is type(tt_jd2) is float:
        return _one_of_series((tt_jd1 - J2000) + tt_jd2)
    days = (np.asarray(tt_jd1, dtype=np.float64) - J2000) + np.asarray(tt_jd2, dtype=np.float64)
    flat = days.ravel()
    if flat.size < _NODES:
        return _series(flat).reshape(days.shape)
    piece = np.floor(flat / _PIECE)
    number, index, count = _distinct(piece)
    full = count >= _NODES
    if not np.any(full):
        return _series(flat).reshape(days.shape)
    table = _fitted(number[full])
    row = np.cumsum(full) - 1
    if np.all(full):
        x = 2.0 * (flat / _PIECE - piece) - 1.0
        return chebyshev.evaluate(table, row[index], x).reshape(days.shape)
    out = np.empty_like(flat)
    fitted = full[index]
    x = 2.0 * (flat[fitted] / _PIECE - piece[fitted]) - 1.0
    out[fitted] = chebyshev.evaluate(table, row[index[fitted]], x)
    out[~fitted] = _series(flat[~fitted])
    return out.reshape(days.shape)


def tdb_minus_tt_at(location: Any, hi: Doubles, lo: Doubles) -> FloatArray:
    """TDB - TT in seconds for a pair of seconds of TT at an EarthLocation of astropy, by dtdb.

    The daily terms, 2 microseconds, are functions of UT1; as in astropy, UTC replaces it.
    """
    import erfa

    jd1, jd2 = erfa.ufunc.taiutc(*_filled(*jd_from_seconds(hi - TT_MINUS_TAI, lo)))[:2]
    day_fraction = (jd1 - 0.5) % 1.0 + jd2
    return erfa.dtdb(
        J2000,
        (hi + lo) / DAY_S,
        day_fraction,
        location.lon.to_value("rad"),
        np.hypot(location.x, location.y).to_value("km"),
        location.z.to_value("km"),
    )


def _stretched(fraction, length):
    """The product of a fraction of a day, at most 1, and the day's length, as a pair.

    Exact for lengths of 86400 and 86401: the first factor of the first product has 32 binary
    places, so that the product has at most 50 bits.
    """
    first = np.rint(fraction * 2.0**32) * 2.0**-32
    return first * length, (fraction - first) * length


def _tai_of_day(day, known, second, low):
    """TAI from the civil day, its offset and drift (`_utc_days`), and the seconds second + low."""
    offset, drift, _ = known
    midnight = (day - MJD_OF_J2000) * DAY_S
    if type(drift) is not float and np.any(drift):
        # Before 1972 the second of UTC was not that of TAI.
        offset = offset + drift * (second + low)
    return pairs.add(pairs.add((midnight, 0.0 * midnight), second, low), offset)


def _since_midnight(day, hi, lo):
    """Seconds of TAI since the midnight of UTC that begins a civil day."""
    return pairs.add(pairs.add((hi, lo), (MJD_OF_J2000 - day) * DAY_S), -_utc_days(day)[0])


def _utc_days(day):
    """TAI - UTC at 0h, s, its drift per second, its jump at the day's end, as ERFA's utctai."""
    import erfa

    day = np.asarray(day, dtype=np.float64)
    number, index, _ = _distinct(day.ravel())
    today = erfa.ufunc.jd2cal(JD_OF_MJD_0, number)[:3]
    tomorrow = erfa.ufunc.jd2cal(JD_OF_MJD_0, number + 1.0)[:3]
    first = erfa.ufunc.dat(*today, 0.0)[0]
    drift = 2.0 * (erfa.ufunc.dat(*today, 0.5)[0] - first)
    jump = erfa.ufunc.dat(*tomorrow, 0.0)[0] - (first + drift)
    return [column[index].reshape(day.shape) for column in (first, drift / DAY_S, jump)]


def _distinct(whole):
    """The distinct values of a flat array of whole numbers, the index of each entry, the counts.

    NaN counts as 0. Numbers that lie close together are counted, ten times as fast as sorted.
    """
    number = np.where(np.isfinite(whole), whole, 0.0).astype(np.int64)
    if number.size < 2:
        return number.astype(np.float64), np.zeros_like(number), np.ones_like(number)
    least = number.min()
    span = number.max() - least + 1
    if span > 4 * number.size + 1024:
        distinct, index, count = np.unique(number, return_inverse=True, return_counts=True)
        return distinct.astype(np.float64), index.ravel(), count
    number -= least
    count = np.bincount(number)
    distinct = np.flatnonzero(count)
    order = np.zeros(len(count), dtype=np.intp)
    order[distinct] = np.arange(len(distinct))
    return (distinct + least).astype(np.float64), order[number], count[distinct]


def _filled(jd1, jd2):
    """J2000 for NaN, which ERFA's calendar cannot take."""
    known = np.isfinite(jd2)
    return np.where(known, jd1, J2000), np.where(known, jd2, 0.0)


def _series(days):
    """ERFA's dtdb at the geocentre, where it does not depend on the time of day."""
    import erfa

    return erfa.dtdb(J2000, days, 0.0, 0.0, 0.0, 0.0)


_one_of_series = lru_cache(maxsize=4096)(lambda days: float(_series(days)))


def _fitted(numbers):
    """The coefficients (17, pieces) of the pieces with these numbers."""

    def fitted(missing):
        first = np.array(missing, dtype=np.float64) * _PIECE
        x = chebyshev.nodes(_NODES)
        table = chebyshev.coefficients(_series(first + 0.5 * _PIECE * (x[:, None] + 1.0)))
        return np.ascontiguousarray(table.T)

    keys = numbers.astype(np.int64).tolist()
    return np.ascontiguousarray(np.array(_pieces.of(keys, fitted)).T)


@lru_cache(maxsize=1)
def earth_orientation() -> Any:
    """The table IERS_A of astropy-iers-data as installed, without a download.

    Final values are those of the table IERS_B, as in astropy: in IERS_A they are older ones.
    """
    from astropy.utils import iers

    # By file name: IERS_Auto would download, IERS_A.open would cache its table in the process.
    table = iers.IERS_A.read(iers.IERS_A_FILE, readme=iers.IERS_A_README)
    final = iers.IERS_B.read(iers.IERS_B_FILE, readme=iers.IERS_B_README)
    _, row, of_final = np.intersect1d(table["MJD"].value, final["MJD"].value, return_indices=True)
    is_final = np.isfinite(table["UT1_UTC_B"][row])
    for name in ("UT1_UTC", "PM_x", "PM_y"):
        table[name][row[is_final]] = final[name][of_final[is_final]]
    return table


@lru_cache(maxsize=1)
def earth_rotation() -> tuple[FloatArray, ...]:
    """TAI seconds past J2000, UT1 - TAI in s and the pole in rad, for each day of the table.

    UT1 - TAI has no leap seconds, so that the interpolation from day to day crosses them.
    """
    table = earth_orientation()
    day = np.asarray(table["MJD"].to_value("d"), dtype=np.float64)
    ut1_minus_utc = np.asarray(table["UT1_UTC"].to_value("s"), dtype=np.float64)
    poles = [
        np.asarray(table[name].to_value("arcsec"), dtype=np.float64) * ARCSEC
        for name in ("PM_x", "PM_y")
    ]
    known = np.isfinite(ut1_minus_utc) & np.isfinite(poles[0]) & np.isfinite(poles[1])
    day, ut1_minus_utc = day[known], ut1_minus_utc[known]
    tai = tai_from_utc_day(day, np.zeros_like(day))[0]
    utc_minus_tai = (day - MJD_OF_J2000) * DAY_S - tai
    columns = tai, ut1_minus_utc + utc_minus_tai, poles[0][known], poles[1][known]
    return tuple(map(frozen, columns))


def orientation_at(tai: Doubles) -> tuple[list[Any], Any]:
    """UT1 - TAI in s and the pole in rad at TAI seconds (N,), and whether the table lacks them."""
    nodes, *columns = earth_rotation()
    # The ends belong to the table, whatever the rounding of TDB; beyond them by rounding alone,
    # numpy.interp returns the last value.
    outside = (tai < nodes[0] - 1e-6) | (tai > nodes[-1] + 1e-6)
    return [np.interp(tai, nodes, column) for column in columns], outside
