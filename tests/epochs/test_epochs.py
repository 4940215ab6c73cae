"""Epochs: every kind of date against astropy, skyfield, exact fractions and published values."""

import copy
import datetime
import pickle
import subprocess
import sys
import warnings
from concurrent.futures import ThreadPoolExecutor
from fractions import Fraction
from zoneinfo import ZoneInfo

import erfa
import numpy as np
import pytest
from astropy import units
from astropy.coordinates import EarthLocation
from astropy.table import Column, MaskedColumn
from astropy.time import Time, TimeDelta
from astropy.utils import iers
from astropy.utils.masked import Masked
from hypothesis import given, settings
from hypothesis import strategies as st

from attitude import Body, FreeRotation, Spin, epochs
from attitude._solver import chebyshev
from attitude._support import pairs
from attitude.epochs import _inputs, _time_scales
from attitude.epochs._inputs import instant, seconds_since
from attitude.errors import AttitudeError
from tests.support import earth_orientation

START = instant("2026-01-01T00:00:00")
# Astropy's two doubles of days hold 5e-12 s each; a conversion rounds some of them.
ASTROPY = 3e-11


@pytest.fixture
def fresh_pieces(monkeypatch):
    monkeypatch.setattr(_time_scales, "_pieces", chebyshev.KeptPieces(4096))


@pytest.fixture
def series_epochs(monkeypatch):
    """The numbers of epochs that ERFA's series is summed for, call by call."""
    sizes, original = [], erfa.dtdb
    monkeypatch.setattr(_time_scales, "_pieces", chebyshev.KeptPieces(4096))

    def counted(date1, date2, *others):
        sizes.append(np.size(date2))
        return original(date1, date2, *others)

    monkeypatch.setattr(erfa, "dtdb", counted)
    return sizes


def astropy_seconds(start, time):
    """Two doubles of seconds of TDB from start to a Time, by astropy's own conversion."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", erfa.ErfaWarning)
        theirs = time.tdb
    known = np.where(theirs.mask, np.nan, 1.0)
    jd1, jd2 = np.asarray(theirs.unmasked.jd1) * known, np.asarray(theirs.unmasked.jd2)
    return pairs.add(_time_scales.seconds_from_jd(jd1, jd2), -start.seconds, -start.low)


def error_against_astropy(start, time):
    return largest_difference(seconds_since(start, time), astropy_seconds(start, time))


def largest_difference(ours, theirs):
    assert np.array_equal(np.isnan(ours[0]), np.isnan(theirs[0]))
    return np.nanmax(np.abs((ours[0] - theirs[0]) + (ours[1] - theirs[1])))


def exact(start, t):
    """The seconds from start as a fraction."""
    hi, lo = seconds_since(start, t)
    return Fraction(float(hi)) + Fraction(float(lo))


def utc(jd, **options):
    """A UTC Time without astropy's warning of dubious years."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", erfa.ErfaWarning)
        return Time(2451545.0, np.asarray(jd) - 2451545.0, format="jd", scale="utc", **options)


# Text ---------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "text",
    [
        "2026-01-01T00:00:00",
        "2026-01-01",
        "2026-01-01T00:00",
        " 2026-01-01 00:00:00.000 ",
        "2026-01-01T00:00:00Z",
        "2026-01-01T00:00:00.0Z",
        "2026-01-01T00:00:00,0",
        "2026-001T00:00:00",
        "2026-001T00:00:00Z",
        "2025-12-31T19:00:00-05:00",
        "2026-01-01T05:30:00+05:30",
        "2026-01-01T00:00:00 UTC",
        "2026-01-01T00:00:37 TAI",
        "2026-01-01T00:00:18 GPS",
        "2026-01-01T00:01:09.184 TT",
        "2026-001T00:01:09.184 tt",
    ],
)
def test_spellings_of_one_epoch(text):
    # 32.184 rounds by 4e-15 s.
    assert abs(exact(START, text)) < 1e-14


def test_one_epoch_in_tdb():
    # 26 years and 7 leap days after 2000-01-01 00:00.
    assert instant("2026-01-01T00:00:00 TDB") == epochs.Instant((26 * 365 + 7) * 86400.0 - 43200.0)


def test_j2000_is_zero():
    assert instant("2000-01-01T12:00:00 TDB") == epochs.Instant(0.0)


@pytest.mark.parametrize("scale", ["utc", "tai", "tt", "tdb", "tcg", "tcb"])
@pytest.mark.parametrize("year", ["1001", "1958", "1961", "1968", "1972", "2016", "2100", "2999"])
def test_text_in_every_scale_agrees_with_astropy(scale, year):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", erfa.ErfaWarning)
        time = Time(f"{year}-12-31T23:14:15.125", scale=scale)
    ours = seconds_since(START, f"{year}-12-31T23:14:15.125 {scale}")
    assert largest_difference(ours, astropy_seconds(START, time)) < ASTROPY


def test_the_leap_second_of_2016():
    before, leap, half, after = (
        exact(START, f"{text}")
        for text in (
            "2016-12-31T23:59:59",
            "2016-12-31T23:59:60",
            "2016-366T23:59:60.5",
            "2017-01-01T00:00:00",
        )
    )
    # TDB and TAI run apart by at most 3.4e-10 s a second.
    assert float(leap - before) == pytest.approx(1.0, abs=4e-10)
    assert float(half - leap) == pytest.approx(0.5, abs=4e-10)
    assert float(after - leap) == pytest.approx(1.0, abs=4e-10)
    assert exact(START, "2017-01-01T08:59:60+09:00") == leap


def test_an_unsharp_leap_second_before_1972_is_known():
    # 1968-01-31 was 0.1 s shorter, 1965-12-31 had no step, 1965-08-31 was 0.1 s longer.
    seconds_since(START, "1965-08-31T23:59:60.05")
    for text in ("1965-08-31T23:59:60.15", "1965-12-31T23:59:60.05", "1968-01-31T23:59:60"):
        with pytest.raises(AttitudeError, match="no leap second"):
            seconds_since(START, text)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("2026-02-30", "does not exist"),
        ("2026-366T00:00:00", "does not exist"),
        ("2026-000T00:00:00", "does not exist"),
        ("0001-000T00:00:00", "does not exist"),
        ("9999-366T00:00:00", "does not exist"),
        ("0000-01-01", "0001 to 9999"),
        ("2026-01-01T24:00:00", "hours go from 00 to 23"),
        ("2026-01-01T00:00:00+25:00", "offset from UTC goes from -23:59"),
        ("2026-01-01T00:00:00-01:60", "offset from UTC goes from -23:59"),
        ("2026-01-01T00:60:00", "hours go from 00 to 23"),
        ("2026-01-01T00:00:61", "hours go from 00 to 23"),
        ("2026-01-01T23:59:60", "no leap second"),
        ("2016-12-31T22:59:60", "no leap second"),
        ("2016-12-31T23:59:60 TAI", "no leap second"),
        ("2026-01-01T00:00:00 EST", "'EST' is not known"),
        ("2026-01-01T00:00:00Z TDB", "leave out Z or TDB"),
        ("1 January 2026", "cannot be read"),
        ("2026-1-1", "cannot be read"),
        ("٢٠٢٦-01-01", "cannot be read"),
        ("", "cannot be read"),
        ("3 h", "a length of time; give an epoch"),
    ],
)
def test_dates_that_cannot_be(text, message):
    with pytest.raises(AttitudeError, match=message) as raised:
        instant(text, "start")
    assert str(raised.value).startswith("start is ")


@given(
    st.datetimes(datetime.datetime(1960, 1, 1), datetime.datetime(2100, 1, 1)),
    st.datetimes(datetime.datetime(1960, 1, 1), datetime.datetime(2100, 1, 1)),
    st.integers(0, 10**15 - 1),
)
def test_differences_of_tdb_dates_are_exact(first, second, femto):
    first, second = first.replace(microsecond=0), second.replace(microsecond=0)
    fraction = Fraction(femto, 10**15)
    difference = exact(instant(f"{first} TDB"), f"{second}.{femto:015d} TDB")
    expected = Fraction((second - first) // datetime.timedelta(seconds=1)) + fraction
    assert abs(difference - expected) < 1e-16  # half a rounding of the fraction


# Other kinds --------------------------------------------------------------------------------------


@given(st.datetimes(datetime.datetime(1960, 1, 1), datetime.datetime(9999, 1, 1)))
def test_text_datetime_datetime64_and_zones_agree(moment):
    expected = exact(START, moment.isoformat())
    assert exact(START, moment) == pytest.approx(expected, abs=1e-15)
    assert exact(START, np.datetime64(moment, "us")) == pytest.approx(expected, abs=1e-15)
    aware = moment.replace(tzinfo=datetime.UTC).astimezone(ZoneInfo("Asia/Kolkata"))
    assert exact(START, aware) == exact(START, moment)


def test_pandas_nanoseconds_and_nat_are_kept():
    class Timestamp(datetime.datetime):  # as pandas has it
        nanosecond = 7

    class NaT(datetime.datetime):
        def __ne__(self, other):
            return True

    hi, lo = seconds_since(START, [Timestamp(2026, 1, 1), NaT(1, 1, 1)])
    assert hi[0] + lo[0] == pytest.approx(7e-9, abs=1e-15) and np.isnan(hi[1])


@pytest.mark.parametrize("unit", ["Y", "M", "W", "D", "h", "m", "s", "ms", "us", "ns", "25ms"])
def test_every_unit_of_datetime64(unit):
    dates = np.array(["1965-03-04T05:06:07.875", "2026-07-08T09:10:11.125", "NaT"]).astype(
        f"M8[{unit}]"
    )
    text = [str(date) for date in dates[:2].astype("M8[us]")]
    ours, texts = seconds_since(START, dates), seconds_since(START, text)
    assert np.max(np.abs((ours[0][:2] - texts[0]) + (ours[1][:2] - texts[1]))) < 1e-15
    assert np.isnan(ours[0][2]) and np.isnan(ours[1][2])


def test_the_smallest_units_of_datetime64_before_1970():
    start = instant("1970-01-01")
    assert exact(start, np.datetime64(-7000, "as")) == pytest.approx(-7e-15, abs=1e-16)
    assert exact(start, np.datetime64(-5, "ps")) == pytest.approx(-5e-12, rel=1e-9)


@pytest.mark.parametrize("seconds", [-2.2e11, -2.5e11, 1e14, 1e300, np.nan, -np.inf])
def test_an_epoch_without_a_calendar_is_written_in_seconds(seconds):
    epoch = epochs.Instant(seconds)
    assert repr(epoch) == f"Instant({seconds!r} TDB seconds past J2000)"
    assert epochs.Instant(-2.1e11).utc_iso.startswith("-4655-05-13T22:39:27")
    assert epochs.Instant(8.6e13).utc_iso.startswith("2727")


def test_a_datetime_outside_of_utc_is_refused():
    first = datetime.datetime(1, 1, 1, tzinfo=ZoneInfo("Asia/Tokyo"))
    with pytest.raises(AttitudeError, match="1 to 9999"):
        instant(first)


@pytest.mark.parametrize("scale", ["utc", "tai", "tt", "tdb", "tcg", "tcb"])
def test_time_arrays_in_every_scale_agree_with_astropy(scale, fresh_pieces):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", erfa.ErfaWarning)
        time = Time(2451545.0, np.linspace(-3e4, 3e4, 3000), format="jd", scale=scale)
    assert error_against_astropy(START, time) < ASTROPY
    assert error_against_astropy(START, time.reshape(30, 100)) < ASTROPY


@pytest.mark.parametrize(
    "day", ["1961-07-31", "1965-08-31", "1968-01-31", "1971-12-31", "1972-06-30", "2016-12-31"]
)
def test_utc_across_its_steps_agrees_with_astropy(day):
    around = Time(day, scale="utc").jd1 + np.linspace(-1.0, 2.5, 5001)
    time = Time(np.concatenate([around, around.round(), around.round() + 0.5]), format="jd")
    assert error_against_astropy(START, time) < ASTROPY


def test_neighbours_of_a_leap_day_in_quasi_julian_dates():
    midnight = Time("2017-01-01", scale="utc")
    halves = np.array([0.5, np.nextafter(0.5, 0), -0.5, np.nextafter(-0.5, 0), 0.0, 1e-300])
    time = Time(np.floor(midnight.jd1 + midnight.jd2) + np.zeros(6), halves, format="jd")
    assert error_against_astropy(START, time) < ASTROPY


def test_the_start_is_an_epoch_of_any_type():
    for start in ("2026-01-01 TDB", Time("2026-01-01", scale="tdb")):
        assert epochs.seconds_since(start, "2026-01-02 TDB")[0] == 86400.0
    with pytest.raises(AttitudeError, match=r"start is 3\.0, a length of time; give"):
        epochs.seconds_since(3.0, "2026-01-02")


@settings(max_examples=50)
@given(st.lists(st.floats(-1e9, 1e9), min_size=1, max_size=20))
def test_seconds_lead_to_times_and_back(seconds):
    seconds = np.array(seconds)
    low = seconds * 1e-17
    hi, lo = seconds_since(START, epochs.times(START, seconds, low))
    # jd2 holds 2^-54 of a day, 5e-12 s.
    assert np.max(np.abs((hi - seconds) + (lo - low))) < 6e-12


def test_places_on_earth_are_honoured():
    place = EarthLocation(lon=30 * units.deg, lat=40 * units.deg, height=100 * units.m)
    jd = 2460000.0 + np.linspace(0.0, 1.0, 200)
    assert error_against_astropy(START, utc(jd, location=place)) < ASTROPY
    geocentre = seconds_since(START, utc(jd))
    there = seconds_since(START, utc(jd, location=place))
    assert 1e-6 < np.max(np.abs(there[0] - geocentre[0])) < 3e-6  # the daily terms of TDB
    many = EarthLocation(lon=np.linspace(0, 300, 200) * units.deg, lat=np.zeros(200) * units.deg)
    time = Time(jd, format="jd", scale="tt", location=many)
    assert error_against_astropy(START, time) < ASTROPY
    time[3] = np.ma.masked
    assert np.flatnonzero(np.isnan(seconds_since(START, time)[0])).tolist() == [3]


def test_differences_set_on_a_time_are_honoured():
    time = Time(["2020-01-01", "2021-01-01"], scale="tt")
    time.delta_tdb_tt = [0.5, 0.25]
    tt = Time(["2020-01-01", "2021-01-01"], scale="tdb")
    ours, reference = seconds_since(START, time), seconds_since(START, tt)
    assert (ours[0] - reference[0]) + (ours[1] - reference[1]) == pytest.approx([0.5, 0.25])
    ut1 = Time("2080-01-01", scale="ut1")  # no table reaches this
    ut1.delta_ut1_utc = 0.25
    with_utc = Time("2079-12-31T23:59:59.75", scale="tai") + 37 * units.s
    assert exact(START, ut1) == pytest.approx(exact(START, with_utc), abs=ASTROPY)


def test_ut1_has_the_final_values_of_astropy():
    time = Time(np.linspace(41700.0, 60000.0, 300), format="mjd", scale="ut1")
    with earth_orientation.installed():
        assert error_against_astropy(START, time) < ASTROPY


def test_ut1_by_the_installed_table_and_without_the_network(monkeypatch):
    import socket

    def refused(*_):
        raise AssertionError("the network was asked for")

    monkeypatch.setattr(socket.socket, "connect", refused)
    monkeypatch.setattr(socket, "getaddrinfo", refused)
    opened = iers.IERS_A.iers_table, iers.IERS_Auto.iers_table
    settings_before = iers.conf.auto_download, iers.conf.auto_max_age
    time = Time(["1975-03-04T05:06:07", "2016-12-31T23:59:59.5", "2017-01-01"], scale="ut1")
    ours = seconds_since(START, time)
    text = seconds_since(START, ["1975-03-04T05:06:07 UT1", "2017-01-01 UT1"])
    assert text[0] == pytest.approx(ours[0][[0, 2]], abs=1e-10)
    with pytest.raises(AttitudeError, match=r"UT1 outside of 1973-01-02 to 20\d\d-"):
        seconds_since(START, "2300-01-01 UT1")
    assert (iers.IERS_A.iers_table, iers.IERS_Auto.iers_table) == opened
    assert (iers.conf.auto_download, iers.conf.auto_max_age) == settings_before
    with earth_orientation.installed():
        assert error_against_astropy(START, time) < ASTROPY
    time[1] = np.ma.masked
    assert np.isnan(seconds_since(START, time)[0]).tolist() == [False, True, False]


def test_skyfield_times_keep_both_of_their_doubles():
    from skyfield.api import load

    ts = load.timescale(builtin=True)
    one, many = ts.utc(2026, 1, 1, 0, 0, 1.25), ts.utc(2026, 1, 1, 0, range(100))
    # tt_fraction holds 1e-16 of a day.
    assert exact(START, one) == pytest.approx(1.25, abs=1.1e-11 + 1.25 * 4e-10)
    hi, lo = seconds_since(START, many)
    assert hi.shape == (100,) and hi + lo == pytest.approx(60.0 * np.arange(100), abs=3e-6)
    assert error_against_astropy(START, many.to_astropy()) < ASTROPY
    theirs = seconds_since(START, many.to_astropy())
    assert np.max(np.abs((hi - theirs[0]) + (lo - theirs[1]))) < 2e-11
    # Skyfield's own TDB is a shorter series, good to 10 us.
    assert instant(one).seconds == pytest.approx((one.tdb - 2451545.0) * 86400, abs=6e-5)


# Cost: which way was taken ------------------------------------------------------------------------


def test_a_long_array_sums_the_series_for_17_epochs_in_16_days(series_epochs):
    time = utc(2459000.0 + np.linspace(0.0, 365.0, 20_000))
    first = seconds_since(START, time)
    assert sum(series_epochs) <= 24 * 17
    series_epochs.clear()
    again = seconds_since(START, time)
    assert series_epochs == []
    assert np.array_equal(first, again)


def test_few_epochs_and_scattered_ones_are_summed_directly(series_epochs):
    rng = np.random.default_rng(3)
    seconds_since(START, utc(2459000.0 + np.linspace(0.0, 1.0, 16)))
    assert series_epochs == [16]
    series_epochs.clear()
    seconds_since(START, utc(rng.uniform(2.3e6, 2.6e6, 5000)))
    assert sum(series_epochs) == 5000  # 18750 pieces of 17 would have cost 60 times as much


def test_crowded_and_lonely_epochs_together(series_epochs):
    days = np.concatenate([np.linspace(0.0, 15.0, 1000) + 9 * 16.0, 1e5 * np.arange(1.0, 4.0)])
    difference = _time_scales.tdb_minus_tt(2451545.0, days)
    assert sorted(series_epochs) == [3, 17]
    assert np.max(np.abs(difference - erfa.dtdb(2451545.0, days, 0, 0, 0, 0))) < 5e-15


@pytest.mark.parametrize(("century", "limit"), [(20, 2.5e-15), (10, 6e-15), (30, 6e-15)])
def test_the_polynomials_agree_with_the_series(century, limit, fresh_pieces):
    # 2e-15 s is the rest of degree 16; the date in millennia rounds by more in other millennia.
    days = (century - 20) * 36525.0 + np.linspace(-365.0, 365.0, 4000)
    difference = _time_scales.tdb_minus_tt(2451545.0, days) - erfa.dtdb(2451545.0, days, 0, 0, 0, 0)
    assert 1e-18 < np.max(np.abs(difference)) < limit


def test_the_pieces_meet(fresh_pieces):
    edge = 16.0 * 571
    days = np.concatenate([np.linspace(edge - 16, edge + 15.9, 400), [np.nextafter(edge, 0), edge]])
    difference = _time_scales.tdb_minus_tt(2451545.0, days)
    assert abs(difference[-1] - difference[-2]) < 4e-15  # twice the error of one


def test_nan_leaves_the_others_alone(fresh_pieces):
    days = np.linspace(0.0, 100.0, 1000)
    with_nan = days.copy()
    with_nan[::7] = np.nan
    difference = _time_scales.tdb_minus_tt(2451545.0, with_nan)
    assert np.array_equal(np.isnan(difference), np.isnan(with_nan))
    known = ~np.isnan(with_nan)
    assert np.max(np.abs((difference - _time_scales.tdb_minus_tt(2451545.0, days))[known])) < 5e-15
    assert np.all(np.isnan(_time_scales.tdb_minus_tt(2451545.0, np.full(100, np.nan))))


def test_the_cache_is_bounded(fresh_pieces, monkeypatch):
    monkeypatch.setattr(_time_scales._pieces, "most", 5)
    for start in range(0, 400, 50):
        days = np.linspace(start, start + 50.0, 300)
        difference = _time_scales.tdb_minus_tt(2451545.0, days)
        assert np.max(np.abs(difference - erfa.dtdb(2451545.0, days, 0, 0, 0, 0))) < 2.5e-15
        assert len(_time_scales._pieces) <= 5


def test_threads_agree(fresh_pieces):
    time = utc(2459000.0 + np.linspace(0.0, 700.0, 5000))
    with ThreadPoolExecutor(8) as pool:
        results = list(pool.map(lambda _: seconds_since(START, time), range(16)))
    for result in results:
        assert np.array_equal(result, results[0])


def test_what_another_thread_stores_first_is_used(fresh_pieces, monkeypatch):
    """Coefficients that are fitted with others have other last bits."""
    original, stored = chebyshev.coefficients, {}

    def interrupted(values):
        found = original(values)
        stored.update(enumerate(found.T * (1.0 + 2.0**-52)))
        _time_scales._pieces.update(stored)
        return found

    monkeypatch.setattr(chebyshev, "coefficients", interrupted)
    found = _time_scales._fitted(np.arange(3.0))
    assert np.array_equal(found.T, [stored[number] for number in range(3)])
    monkeypatch.setattr(chebyshev, "coefficients", original)
    assert np.array_equal(_time_scales._fitted(np.arange(3.0)), found)


def test_dubious_years_are_no_warning():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        seconds_since(START, ["1950-01-01", "2500-01-01"])
        assert instant("2500-01-01").utc_iso == "2500-01-01T00:00:00"
        seconds_since(START, utc([2433282.5, 2634166.5]))


def test_importing_takes_numpy_only():
    code = (
        "import sys; from attitude import epochs;"
        "s = epochs.instant('2026-01-01'); epochs.seconds_since(s, [1.0, 2.0]);"
        "heavy = {'astropy', 'skyfield', 'scipy', 'numba', 'pandas'} & set(sys.modules);"
        "print(sorted(heavy))"
    )
    out = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert out.stdout.strip() == "[]"


# Plain seconds and lengths of time ----------------------------------------------------------------


def test_a_float64_array_is_returned_as_it_is():
    t = np.array([1.0, np.nan, -3.0])
    hi, lo = seconds_since(START, t)
    assert hi is t and lo is None


@pytest.mark.parametrize(
    ("t", "expected"),
    [
        (5, 5.0),
        (2.5, 2.5),
        (np.float32(2.5), 2.5),
        (np.int8(3), 3.0),
        ([1, 2.5], [1.0, 2.5]),
        (((1, 2), (3, 4)), [[1.0, 2.0], [3.0, 4.0]]),
        ([np.array([1, 2]), np.array([3, 4])], [[1.0, 2.0], [3.0, 4.0]]),
        ([], []),
        ([[], []], [[], []]),
        (np.arange(3), [0.0, 1.0, 2.0]),
        (3 * units.day, 259200.0),
        ([1, 2] * units.min, [60.0, 120.0]),
        ([1 * units.s, 2 * units.min], [1.0, 120.0]),
        ([[1, 2] * units.min, [3, 4] * units.s], [[60.0, 120.0], [3.0, 4.0]]),
        (Column([1.0, 2.0], unit="h"), [3600.0, 7200.0]),
        (Column([1.0, 2.0]), [1.0, 2.0]),
        (MaskedColumn([1.0, 2.0], unit="h", mask=[False, True]), [3600.0, np.nan]),
        (np.ma.MaskedArray([1.0, 2.0], mask=[True, False]), [np.nan, 2.0]),
        (Masked([1.0, 2.0] * units.min, mask=[False, True]), [60.0, np.nan]),
        (datetime.timedelta(days=1, microseconds=5), 86400.000005),
        ([datetime.timedelta(seconds=1)] * 2, [1.0, 1.0]),
        (np.timedelta64(5, "ms"), 0.005),
        (np.array([1500, "NaT"], "m8[ms]"), [1.5, np.nan]),
        ([np.timedelta64(1, "h")], [3600.0]),
    ],
)
def test_plain_seconds_and_their_like(t, expected):
    hi, lo = seconds_since(START, t)
    assert lo is None and type(hi) is np.ndarray and hi.dtype == np.float64
    assert np.array_equal(hi, np.array(expected), equal_nan=True)


def test_a_second_double():
    t, low = np.array([1e9, 2e9]), np.array([1e-9, 2e-9])
    hi, lo = seconds_since(START, t, low)
    assert hi is t and lo is low
    assert np.array_equal(seconds_since(START, t, 1e-9)[1], [1e-9, 1e-9])
    assert np.array_equal(seconds_since(START, 1e9, 1e-9), (1e9, 1e-9))
    assert np.array_equal(seconds_since(START, t * units.s, low * units.s), (t, low))
    with pytest.raises(AttitudeError, match=r"low has shape \(3,\), t has \(2,\)"):
        seconds_since(START, t, [1.0, 2.0, 3.0])
    with pytest.raises(AttitudeError, match="leave out low"):
        seconds_since(START, "2026-01-01", 1e-9)


@pytest.mark.parametrize("scale", [None, "tdb", "tt", "tai", "tcg", "tcb"])
def test_a_time_delta_is_what_astropy_adds(scale):
    delta = TimeDelta([0.0, 1e-3, 1.0, 3600.0, 1e7, 1e9] * units.s, scale=scale)
    hi, lo = seconds_since(START, delta)
    assert hi[0] == 0.0 and lo[0] == 0.0
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", erfa.ErfaWarning)
        theirs = astropy_seconds(START, START.time + delta)
    assert largest_difference((hi, lo), theirs) < 2 * ASTROPY


def test_a_difference_of_utc_times_leads_from_one_to_the_other():
    times = Time(["2026-01-01", "2026-07-01T01:02:03"], scale="utc")
    assert exact(START, times[1] - times[0]) == pytest.approx(exact(START, times[1]), abs=ASTROPY)


def test_a_time_delta_in_ut1_is_refused():
    with pytest.raises(AttitudeError, match="'ut1'"):
        seconds_since(START, TimeDelta(1.0, format="sec", scale="ut1"))


# Shapes, masks, mixtures --------------------------------------------------------------------------


@pytest.mark.parametrize(
    "t",
    [
        [["2026-01-01", "2026-01-02"], ["2026-01-03", "2026-01-04"]],
        np.array([["2026-01-01", "2026-01-02"], ["2026-01-03", "2026-01-04"]]),
        np.array([["2026-01-01", "2026-01-02"], ["2026-01-03", "2026-01-04"]], dtype="S"),
        np.array([["2026-01-01", "2026-01-02"], ["2026-01-03", "2026-01-04"]], dtype="M8[D]"),
        [[datetime.datetime(2026, 1, d) for d in row] for row in ((1, 2), (3, 4))],
        np.array([[datetime.datetime(2026, 1, d) for d in row] for row in ((1, 2), (3, 4))]),
        [[datetime.date(2026, 1, d) for d in row] for row in ((1, 2), (3, 4))],
        Time([["2026-01-01", "2026-01-02"], ["2026-01-03", "2026-01-04"]]),
        [Time(["2026-01-01", "2026-01-02"]), Time(["2026-01-03", "2026-01-04"])],
        [[Time("2026-01-01"), Time("2026-01-02")], [Time("2026-01-03"), Time("2026-01-04")]],
        [
            [instant("2026-01-01"), instant("2026-01-02")],
            [instant("2026-003"), instant("2026-004")],
        ],
    ],
)
def test_two_by_two_days_of_any_kind(t):
    hi, lo = seconds_since(START, t)
    assert hi.shape == lo.shape == (2, 2) and hi.dtype == lo.dtype == np.float64
    # A day of TAI and one of TDB differ by up to 3e-5 s.
    assert hi + lo == pytest.approx(86400.0 * np.array([[0, 1], [2, 3]]), abs=1e-4)


@pytest.mark.parametrize("t", ["2026-01-02", Time("2026-01-02"), np.datetime64("2026-01-02")])
def test_a_single_epoch_gives_arrays_without_axes(t):
    for part in seconds_since(START, t):
        assert type(part) is np.ndarray and part.shape == () and part.dtype == np.float64


@pytest.mark.parametrize("t", [Time([], format="jd"), np.array([], "M8[s]"), np.array([], "U5")])
def test_no_epochs(t):
    hi, lo = seconds_since(START, t)
    assert hi.shape == (0,) and (lo is None or lo.shape == (0,))


def test_masked_entries_give_nan_in_their_place():
    time = Time(["2026-01-01", "2026-01-02", "2026-01-03"])
    time[1] = np.ma.masked
    text = np.ma.MaskedArray(["2026-01-01", "", "2026-01-03"], mask=[False, True, False])
    dates = np.ma.MaskedArray(np.array(["2026-01-01"] * 3, "M8[s]"), mask=[False, True, False])
    delta = TimeDelta([1.0, 2.0, 3.0], format="sec")
    delta[1] = np.ma.masked
    for t in (time, text, dates, delta, np.array(["2026-01-01", "NaT", "2026-01-03"], "M8[D]")):
        for part in seconds_since(START, t):
            assert np.isnan(part).tolist() == [False, True, False]
    assert np.isnan(seconds_since(START, np.ma.MaskedArray(["x"], mask=[True]))[0]).all()


@pytest.mark.parametrize(
    ("t", "message"),
    [
        (None, "t is None; give plain seconds"),
        (True, "t is True"),
        (np.array([True]), "t is array"),
        ([True, False], "t holds True"),
        ([1.0, None], "t holds None"),
        ([None], "t holds None"),
        (1j, "t is 1j"),
        (b"2026-01-01", "t is b'2026-01-01'"),
        ({}, "t is {}"),
        (10**400, r"t is array\(1000"),
        (["2026-01-01", 5.0], r"mixes entries of several kinds \(number, text\)"),
        ([5.0, "2026-01-01"], r"mixes entries of several kinds \(number, text\)"),
        (["2026-01-01", datetime.datetime(2026, 1, 1)], r"\(datetime, text\)"),
        ([[1.0, 2.0], [3.0]], "ragged"),
        ([["2026-01-01"], ["2026-01-01", "2026-01-02"]], "ragged"),
        ([Time("2026-01-01"), Time(["2026-01-02", "2026-01-03"])], "ragged"),
        (np.timedelta64(1, "M"), "years or months, which have no fixed length"),
        (np.array([1, 2], "m8[Y]"), "years or months, which have no fixed length"),
        (3 * units.m, "t is in m"),
        (Column([1.0], unit="kg"), "t is in kg"),
        (np.datetime64("12026-01-01"), "years -4712 to 9999"),
        (np.datetime64(10**15, "Y"), "years -4712 to 9999"),
        (Time(1e7, format="jd", scale="tt"), "years -4712 to 9999"),
        (Time(-1e300, format="jd", scale="tt"), "years -4712 to 9999"),
        (Time("2026-01-01", scale="local"), "'local'"),
    ],
)
def test_what_is_no_epoch_is_refused(t, message):
    with pytest.raises(AttitudeError, match=message):
        seconds_since(START, t)


@pytest.mark.parametrize(
    ("value", "message"),
    [
        (5.0, "epoch is 5.0, a length of time; give an epoch: an ISO date"),
        (3 * units.day, "a length of time"),
        (datetime.timedelta(1), "a length of time"),
        (TimeDelta(1.0, format="sec"), "a length of time"),
        (["2026-01-01", "2026-01-02"], r"has shape \(2,\); give one epoch"),
        (Time(["2026-01-01"]), r"has shape \(1,\); give one epoch"),
        (np.datetime64("NaT", "s"), "not an epoch"),
        (None, "epoch is None; give an ISO date"),
        (True, "epoch is True"),
    ],
)
def test_what_is_no_single_epoch_is_refused(value, message):
    with pytest.raises(AttitudeError, match=message):
        instant(value)


# Instant ------------------------------------------------------------------------------------------


def test_an_instant_is_a_value():
    same = instant("2026-001T00:00:00Z")
    assert same == START and hash(START) == hash(same) and {START, same} == {START}
    assert instant("2026-01-01T00:00:00.000000000001") != START
    assert instant(START) is START
    assert seconds_since(START, same) == (0.0, 0.0)
    with pytest.raises(AttributeError):
        START.seconds = 0.0
    for clone in (copy.copy, copy.deepcopy, lambda v: pickle.loads(pickle.dumps(v))):
        assert clone(START) == START


def test_an_instant_of_two_sums_is_one():
    assert epochs.Instant(1.0, 1e9) == epochs.Instant(1e9 + 1.0)
    assert type(epochs.Instant(np.float64(1.0)).seconds) is float


@pytest.mark.parametrize(
    "text",
    [
        "2026-01-01T00:00:00",
        "2016-12-31T23:59:60",
        "2016-12-31T23:59:60.999999999",
        "1999-12-31T23:59:59.123456789",
        "2016-02-29T12:34:56.5",
        "1965-08-31T23:59:60.05",
        "1965-01-01T00:00:00",
        "1965-08-31T12:00:00",
        "1966-06-06T23:59:59.999999999",
        "1001-01-01T00:00:00",
    ],
)
def test_printing_an_instant_gives_the_date_again(text):
    assert instant(text).utc_iso == text
    assert exact(instant(text), text) == 0
    assert repr(instant(text)) == f"Instant({text} UTC)"


@given(st.datetimes(datetime.datetime(1, 1, 2), datetime.datetime(9999, 12, 30)))
def test_any_date_is_printed_as_it_was_read(moment):
    text = instant(moment).utc_iso
    assert datetime.datetime.fromisoformat(text.ljust(20, ".").ljust(26, "0")) == moment


@pytest.mark.parametrize(
    "text", ["9999-12-31T23:59:59.5", "9999-12-31T23:59:59-01:00", "1971-12-31T12:00:00"]
)
def test_one_date_has_the_bits_of_a_list_where_the_calendar_of_python_ends(text):
    one = instant(text)
    hi, lo = _inputs.read("text", [text, text], (2,), "t")
    assert (one.seconds, one.low) == (hi[0], lo[0])


def test_printing_rounds_up_to_midnight():
    assert instant("2026-12-31T23:59:59.9999999999").utc_iso == "2027-01-01T00:00:00"
    assert instant("2016-12-31T23:59:60.9999999999").utc_iso == "2017-01-01T00:00:00"
    assert instant("2016-12-31T23:59:59.9999999999").utc_iso == "2016-12-31T23:59:60"


def test_the_time_of_an_instant_is_astropys():
    time = Time("2026-01-01T00:00:00", scale="utc")
    assert START.time.scale == "tdb" and START.time.shape == ()
    assert abs((START.time - time.tdb).sec) < ASTROPY
    masked = epochs.times(START, np.array([0.0, np.nan]))
    assert masked.mask.tolist() == [False, True]
    assert abs((epochs.times(START, [1] * units.min)[0] - START.time).sec - 60.0) < ASTROPY


@pytest.mark.parametrize(
    ("given", "sentence"),
    [
        (("2026-01-01", [1.0]), "start is '2026-01-01'; give an Instant"),
        ((START, None), "seconds is None; give real numbers"),
        ((START, [1 + 1j]), "give real numbers"),
        ((START, np.ma.masked_array([1.0, 2.0], [False, True])), "masked entries"),
        ((START, [1.0, 2.0], [1.0, 2.0, 3.0]), r"seconds \(2,\), low \(3,\)"),
    ],
)
def test_what_times_refuses(given, sentence):
    with pytest.raises(AttitudeError, match=sentence):
        epochs.times(*given)


def test_an_instant_and_seconds_after_it():
    later = START.after(1e9, 1e-9)
    assert exact(START, later) == pytest.approx(Fraction(10**9) + Fraction(1e-9), abs=1e-15)
    assert later.after(-1e9, -1e-9) == START
    assert START.after("1 d") == START.after(1 * units.day) == START.after(86400)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (
            lambda: epochs.Instant("2026-01-01"),
            "seconds is '2026-01-01'; give seconds .epochs.instant",
        ),
        (lambda: epochs.Instant(None), "seconds is None; give seconds"),
        (lambda: epochs.Instant(0.0, "now"), "low is 'now'; give seconds"),
        (lambda: START.after("2026-01-01"), "seconds is '2026-01-01'; give seconds"),
        (lambda: START.since("2026-01-01"), "other is '2026-01-01'; give an Instant"),
    ],
)
def test_what_makes_no_instant_is_refused(call, message):
    with pytest.raises(AttitudeError, match=message):
        call()


@pytest.mark.parametrize(
    "scale", ["", "Z", "+05:30", " TDB", " TT", " TAI", " GPS", " TCG", " UT1"]
)
def test_a_single_date_has_the_bits_of_a_list(scale):
    """A single text is computed with floats, a list with arrays."""
    dates = ["1990-06-30T23:59:59", "2016-12-31T23:59:59.999", "2020-02-29T01:02:03.456789"]
    dates += [] if scale == " UT1" else ["1965-03-01T12:00:00.25", "2050-01-01T00:00:00"]
    texts = [date + scale for date in dates]
    for text, hi, lo in zip(texts, *_inputs.read("text", texts, (len(texts),), "t"), strict=True):
        one = instant(text)
        assert (one.seconds, one.low) == pairs.two_sum(hi, lo)


def test_lengths_of_time_as_text():
    """ "3 d" counts from the start, as on the command line."""
    start = instant("2026-01-01")
    assert seconds_since(start, "3 d")[0] == 259200.0
    np.testing.assert_array_equal(seconds_since(start, "0, 6, 12 h")[0], [0.0, 21600.0, 43200.0])
    np.testing.assert_array_equal(seconds_since(start, ["1 h", "2 min"])[0], [3600.0, 120.0])
    with pytest.raises(AttitudeError, match="give it in s"):
        seconds_since(start, "3 km")


@pytest.mark.parametrize("seconds", [60.0, -0.0, 1e300, np.nan, np.inf])
def test_a_float_of_seconds_is_not_read_by_the_reader_of_all_types(monkeypatch, seconds):
    """A call with one epoch costs a third as much; the array is that of the general reader."""
    general = epochs.plain_seconds([seconds])[0]

    def refuse(*arguments):
        raise AssertionError("read by the general reader")

    monkeypatch.setattr(_inputs, "entries", refuse)
    found, low = epochs.plain_seconds(seconds)
    assert low is None and found.shape == () and found.dtype == np.float64
    assert found.tobytes() == general.tobytes()
    with pytest.raises(AssertionError, match="general reader"):
        epochs.plain_seconds("60")
    monkeypatch.undo()
    found, low = epochs.plain_seconds(seconds, 1e-9)
    assert found.tobytes() == general.tobytes() and low.shape == () and low == 1e-9
    with pytest.raises(AttitudeError, match=r"low has shape \(2,\), seconds has \(\)"):
        epochs.plain_seconds(seconds, [0.0, 0.0])


@pytest.mark.parametrize("seconds", [np.nan, np.inf, -np.inf])
def test_a_float_that_is_not_finite_gives_what_an_array_of_it_gives(seconds):
    body = Body(moments=(1.0, 2.0, 3.0))
    spin = Spin(epoch="2026-01-01", wxyz=(1, 0, 0, 0), angular_velocity=(1, 2, 3))
    motion = FreeRotation(body, spin)
    said = []
    for form in (seconds, np.array(seconds), [seconds]):
        try:
            said.append(np.ravel(motion.angular_velocity_at(form)).tobytes())
        except AttitudeError as err:
            said.append(str(err))
    assert len(set(said)) == 1


@pytest.mark.parametrize(
    "text, value, scale",
    [
        ("JD 2461041.5 TDB", "2461041.5", "tdb"),
        ("mjd 57753.99999 UTC", "57753.99999", "utc"),  # of a day of 86401 s
        ("JD2460000. TT", "2460000.0", "tt"),
        ("JD 2451545.123456789 UT1", "2451545.123456789", "ut1"),
    ],
)
def test_julian_dates_with_their_scale_are_those_of_astropy(text, value, scale):
    kind = text[:3].strip().lower().removesuffix("2")
    expected = instant(Time(value, format=kind, scale=scale))
    assert abs(instant(text).since(expected)) < 1e-11


@pytest.mark.parametrize(
    "text, sentence",
    [
        ("JD 2461041.5", 'without a time scale; add it, as in "JD 2461041.5 UTC"'),
        ("MJD 9999999 TT", "give a date of the years 0001 to 9999"),
        ("JD 2461041.5 XYZ", "time scale 'XYZ' is not known"),
        ("2461041.5", 'cannot be read as a date; .* or "JD 2461041.5 TDB"'),
    ],
)
def test_julian_dates_that_are_refused(text, sentence):
    with pytest.raises(AttitudeError, match=sentence):
        instant(text)
