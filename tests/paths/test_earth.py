"""Satellites and ground sites against skyfield, astropy and ERFA, without any network."""

import json
import pickle
import time

import erfa
import numpy as np
import pytest
from astropy import units as u
from astropy.coordinates import EarthLocation
from astropy.time import Time
from skyfield.api import EarthSatellite, wgs84

from attitude import paths
from attitude.epochs import _time_scales
from attitude.epochs._inputs import instant
from attitude.errors import AttitudeError
from attitude.frames._earth import (
    _tt,
    erfa_series,
    pole_of_date,
    pole_of_teme,
    teme_series,
    timescale,
)
from attitude.paths._ground import rotation_angle
from attitude.paths._path import julian
from tests.support import earth_orientation
from tests.support.kernels import DATA, decaying, summed

TLE = DATA / "envisat-2013.tle"
LINES = TLE.read_text().splitlines()
NOW = instant("2013-10-23T05:00:00")
NO_LOW = np.zeros(1)
# A geostationary satellite (deep space, SDP4) and one on a Molniya orbit; epochs of 2006.
GEO = (
    "1 28626U 05008A   06176.46683397 -.00000205  00000-0  10000-3 0  2190",
    "2 28626   0.0019 286.9433 0000335  13.7918  55.6504  1.00270176  4891",
)
MOLNIYA = (
    "1 24208U 96044A   06177.04061740 -.00000094  00000-0  10000-3 0  1600",
    "2 24208   3.8536  80.0121 0026640 311.0977  48.3000  1.00778054 36119",
)
OMM = {
    "OBJECT_NAME": "ENVISAT",
    "OBJECT_ID": "2002-009A",
    "EPOCH": "2013-10-23T03:58:20.413920",
    "MEAN_MOTION": "14.37637337",
    "ECCENTRICITY": "0.0001126",
    "INCLINATION": "98.4160",
    "RA_OF_ASC_NODE": "1.9229",
    "ARG_OF_PERICENTER": "79.5538",
    "MEAN_ANOMALY": "280.5787",
    "NORAD_CAT_ID": "27386",
    "BSTAR": "0.000047533",
    "MEAN_MOTION_DOT": "0.000001",
    "MEAN_MOTION_DDOT": "0",
}


def of_skyfield(satellite, at, seconds):
    found = satellite.at(timescale().tt_jd(*_tt(*julian(at, seconds, NO_LOW))))
    return found.xyz.m.T, found.velocity.m_per_s.T


@pytest.mark.parametrize("lines", [LINES[1:], GEO, MOLNIYA])
@pytest.mark.parametrize("days", [0.0, 20.0])
def test_a_satellite_is_where_skyfield_has_it(lines, days):
    path = paths.tle(lines, any_epoch=True)
    at = path.epoch.after(days * 86400.0)
    seconds = np.random.default_rng(6).uniform(-86400.0, 86400.0, 300)
    theirs = of_skyfield(EarthSatellite(*lines, ts=timescale()), at, seconds)
    position, velocity = path.state(at, seconds)
    # Both round elapsed days to 1e-11 s, and TEME to 1e-13 rad.
    assert np.abs(position - theirs[0]).max() < 1e-4
    assert np.abs(velocity - theirs[1]).max() < 1e-6


def test_a_pass_of_a_satellite_compressed_stays_within_a_millimetre():
    path = paths.tle(TLE)
    small = paths.compress(path, NOW, NOW.after(86400.0))
    seconds = np.random.default_rng(7).uniform(0.0, 86400.0, 1000)
    theirs = of_skyfield(EarthSatellite(*LINES[1:], ts=timescale()), NOW, seconds)[0]
    away = np.linalg.norm(small.position(NOW, seconds) - theirs, axis=-1)
    assert away.max() < 1e-3 and small.error < 1e-3


def test_a_satellite_does_not_jump_at_a_leap_second():
    path = paths.tle([summed(LINES[1][:18] + "16366.50000000" + LINES[1][32:]), LINES[2]])
    seconds = instant("2017-01-01T00:00:00").seconds - path.epoch.seconds + np.arange(-3.0, 3.0)
    speed = np.diff(path.position(path.epoch, seconds), axis=0)
    assert np.ptp(np.linalg.norm(speed, axis=-1)) < 1.0  # m/s, of 7.5 km/s


def test_the_epoch_of_the_elements_is_theirs():
    assert paths.tle(TLE).epoch.utc_iso[:23] == "2013-10-23T03:58:20.413"
    assert paths.tle(TLE).name == "ENVISAT"


@pytest.mark.parametrize("form", ["fields", "kvn", "json", "csv", "xml", "file"])
def test_omm_gives_the_path_of_the_tle(form, tmp_path):
    text = {
        "fields": OMM,
        "kvn": "CCSDS_OMM_VERS = 2.0\n" + "\n".join(f"{k} = {v}" for k, v in OMM.items()),
        "json": json.dumps([OMM]),
        "csv": ",".join(OMM) + "\n" + ",".join(OMM.values()) + "\n",
        "xml": "<omm><segment>"
        + "".join(f"<{k}>{v}</{k}>" for k, v in OMM.items())
        + "</segment></omm>",
        "file": tmp_path / "envisat.omm",
    }[form]
    if form == "file":
        text.write_text("\n".join(f"{k} = {v}" for k, v in OMM.items()))
    path = paths.omm(text)
    assert path.name == "ENVISAT" and path.center == "earth"
    seconds = np.linspace(0.0, 6000.0, 50)
    away = path.position(NOW, seconds) - paths.tle(TLE).position(NOW, seconds)
    # sgp4 keeps the epoch of an OMM as one double of days since 1949, to 3e-7 s.
    assert np.abs(away).max() < 5e-3


@pytest.mark.parametrize(
    "change, message",
    [
        ({"EPOCH": ""}, "has no EPOCH"),
        ({"EPOCH": "yesterday"}, "the OMM: EPOCH is 'yesterday UTC'"),
        ({"INCLINATION": "steep"}, "cannot be read"),
        (
            {"MEAN_ELEMENT_THEORY": "DSST", "MEAN_MOTION": "", "BSTAR": ""},
            "MEAN_ELEMENT_THEORY is 'DSST'; it must be SGP4",
        ),
        ({"TIME_SYSTEM": "TAI"}, "TIME_SYSTEM is 'TAI'"),
        ({"EPHEMERIS_TYPE": "4"}, "EPHEMERIS_TYPE is '4'; it must be 0"),
        ({"MEAN_MOTION": "nan"}, "has an element that is not finite"),
        ({"MEAN_MOTION": "-15.5"}, r"a mean motion of -15.5 revolutions a day"),
        ({"BSTAR": "inf"}, "has an element that is not finite"),
    ],
)
def test_messages_of_other_elements_are_refused(change, message):
    with pytest.raises(AttitudeError, match=message):
        paths.omm({**OMM, **change})


def kvn(fields):
    return "CCSDS_OMM_VERS = 2.0\n" + "".join(f"{k} = {v}\n" for k, v in fields.items())


@pytest.mark.parametrize(
    "epoch, utc",
    [
        ("2026-064T10:34:41.4264", "2026-03-05T10:34:41.4264"),  # CCSDS 502.0-B-3, figure 4-1
        ("2026-03-05 10:34:41.000000500Z", "2026-03-05T10:34:41.0000005"),
        ("2016-12-31T23:59:60.5", "2016-12-31T23:59:60.5"),
    ],
)
def test_epochs_of_an_omm_are_those_of_the_package(epoch, utc):
    path = paths.omm({**OMM, "EPOCH": epoch})
    assert path.epoch == instant(utc)
    later = paths.omm({**OMM, "EPOCH": "2026-03-05T10:34:41.0"})
    away = path.position(path.epoch, 60.0) - later.position(later.epoch, 60.0)
    assert np.linalg.norm(away) < 1e5  # m, of the turning of TEME and by SGP4's own epoch


def test_names_and_numbers_of_an_omm():
    path = paths.omm(kvn({**OMM, "OBJECT_NAME": "GOES 9 [P]", "NORAD_CAT_ID": "799500001"}))
    assert path.name == "GOES 9 [P]"
    assert np.array_equal(path.position(NOW, 0.0), paths.omm(OMM).position(NOW, 0.0))
    two = kvn(OMM) + kvn({**OMM, "OBJECT_NAME": "OTHER"})
    assert paths.omm(two, name="ENVISAT").name == "ENVISAT"
    with pytest.raises(AttitudeError, match=r"holds 2 satellites; give name=.*: ENVISAT, OTHER\."):
        paths.omm(two)
    assert repr(paths.omm(kvn(OMM) * 2, name=27386)) == repr(paths.omm(OMM))


XML = (
    '<?xml version="1.0" encoding="UTF-8"?>\n<omm><segment>\n'
    + "".join(f"<{key}>{value}</{key}>\n" for key, value in OMM.items())
    + "</segment></omm>\n"
)
LAUGHS = "".join(f'<!ENTITY l{k} "{f"&l{k - 1};" * 10}">\n' for k in range(1, 10))


@pytest.mark.parametrize(
    "old, new, error",
    [
        ("<omm>", "<!DOCTYPE omm><omm>", r"line 2: it has a document type declaration"),
        ("<omm>", '<!DOCTYPE omm SYSTEM "file:///etc/passwd"><omm>', "document type declaration"),
        ("<omm>", '<!DOCTYPE omm [<!ENTITY n "2.">]><omm>', "document type declaration"),
        (
            "ENVISAT",
            '<!DOCTYPE omm [<!ENTITY n SYSTEM "file:///etc/passwd">]>',
            "line 3: it is not well-formed XML",
        ),
        ("ENVISAT", "&undefined;", r"line 3: it is not well-formed XML \(undefined entity\)"),
        ("</segment>", "</section>", r"line \d+: it is not well-formed XML \(mismatched tag\)"),
        ("ENVISAT", "E" * 30000, "a text in it is longer than 20000 characters"),
        ("<segment>", "<a>" * 40 + "<segment>", "nested deeper than 32"),
        ("segment>", "part>", "holds 0 satellites"),
    ],
)
@pytest.mark.parametrize("as_file", [False, True])
def test_xml_with_entities_or_errors_is_refused(tmp_path, old, new, error, as_file):
    text = XML.replace(old, new)
    assert text != XML
    name, given = ("envisat.xml", tmp_path / "envisat.xml") if as_file else ("OMM", text)
    (tmp_path / "envisat.xml").write_text(text)
    with pytest.raises(AttitudeError, match=error) as caught:
        paths.omm(given)
    assert str(caught.value).startswith(name)


@pytest.mark.parametrize("value", ["2002-009A", "&l9;"])
def test_entities_that_multiply_are_refused_before_they_are_expanded(tmp_path, value):
    # Ten to the ninth power of "lol", 3 GB, if they were expanded.
    text = XML.replace("<omm>", f'<!DOCTYPE omm [<!ENTITY l0 "lol">\n{LAUGHS}]>\n<omm>')
    (tmp_path / "laughs.xml").write_text(text.replace("2002-009A", value))
    start = time.process_time()
    with pytest.raises(AttitudeError, match=r"laughs.xml, line 2: it has a document type"):
        paths.omm(tmp_path / "laughs.xml")
    assert time.process_time() - start < 1.0  # s; expanding them takes minutes


def test_xml_is_read_as_it_was_written(tmp_path):
    file = tmp_path / "envisat.xml"
    for declared in ("utf-16", "utf8", "ISO-8859-1"):  # as some programs declare UTF-8
        text = XML.replace("UTF-8", declared).replace("ENVISAT", "A &amp; B&#46; <!-- c -->\u03b1")
        text = text.replace("<MEAN_MOTION>", '<MEAN_MOTION units="rev/day">')
        file.write_text(text, encoding="utf-8-sig")
        assert paths.omm(file).name == paths.omm(text).name == "A & B. \u03b1"
    two = XML.replace("</omm>", XML[XML.index("<segment>") :].replace("ENVISAT", "OTHER"))
    assert paths.omm(two, name="other").name == "OTHER"
    with pytest.raises(AttitudeError, match="OMM holds 2 satellites"):
        paths.omm(two)


@pytest.mark.parametrize(
    "text, error",
    [
        ('{"EPOCH": }', r"OMM, line 1: it is not valid JSON \(Expecting value"),
        ("[1, 2]", "OMM holds JSON values that are no objects"),
        ("[" * 100_000, "OMM.* JSON"),
        ("a,b\n" + "x" * 200_000 + ",2\n", r"OMM, line \d: it is not valid CSV"),
        ("A = 1\nB = 2\nC\n", "OMM, line 3: 'C' is no \"KEYWORD = value\""),
        ("A = 1\n= 2\n", "OMM, line 2: '= 2' is no \"KEYWORD = value\""),
    ],
)
def test_messages_that_cannot_be_parsed_are_refused_by_line(text, error):
    with pytest.raises(AttitudeError, match=error):
        paths.omm(text)


def test_keywords_have_units_comments_and_any_line_ends(tmp_path):
    text = "CCSDS_OMM_VERS = 2.0\nCOMMENT a = b\n\n" + "\n".join(f"{k}={v}" for k, v in OMM.items())
    text = text.replace("98.4160", "98.4160 [deg]") + "\nUSER_DEFINED_a-b c = 1 [km]\n"
    for end in ("\n", "\r\n", "\r"):
        (tmp_path / "envisat.omm").write_bytes(text.replace("\n", end).encode())
        assert paths.omm(tmp_path / "envisat.omm").lines == paths.omm(text).lines
    assert ("USER_DEFINED_A-B C", "1") in paths.omm(text).lines
    seconds = np.linspace(0.0, 6000.0, 5)
    found, known = (paths.omm(each).position(NOW, seconds) for each in (text, OMM))
    assert np.array_equal(found, known)


@pytest.mark.parametrize(
    "change, message",
    [
        (("98.4160", "98.4161"), "line 2 of the elements ends in the checksum 9, but .* sum to 0"),
        (("8339", "8330"), "line 1 of the elements ends in the checksum 0, but .* sum to 9"),
        (("14.37637337609529", "14.3763733760952"), "has 68 characters"),
        (("27386 098", "27387 097"), "is of satellite 27386 and line 2 of 27387"),
        (("47533-4 0  8339", "4O533-4 7  8339"), "line 1 of the elements is not in the columns"),
        (("47533-4 0  8339", "47533-4 4  8333"), r"the type of the elements .* is 4, so they are"),
        (("2 27386", "3 27386"), 'no two lines that start with "1 "'),
    ],
)
def test_lines_that_are_wrong_are_refused(change, message):
    with pytest.raises(AttitudeError, match=message):
        paths.tle("\n".join(LINES).replace(*change))


def test_one_of_several_satellites_is_chosen_by_name_or_number():
    text = "\n".join([*LINES, *GEO])
    assert paths.tle(text, name="envisat").name == "ENVISAT"
    assert paths.tle(text, name=28626).name == "28626"
    for number, name in (("T0001", 270001), ("00005", "00005"), ("00005", 5)):
        lines = [line.replace("28626", number) for line in GEO]
        two = [*(summed(line[:68]) for line in lines), *LINES]
        assert paths.tle(two, name=name).name == number
    with pytest.raises(AttitudeError, match="holds 2 satellites; give name"):
        paths.tle(text)
    with pytest.raises(AttitudeError, match="holds 0 satellites called 'X'"):
        paths.tle(text, name="X")
    with pytest.raises(AttitudeError, match="cannot be read"):
        paths.tle(DATA / "missing.tle")


def test_of_several_sets_the_one_of_the_nearest_epoch_is_used():
    at = instant("2013-10-23")
    sets = []
    for day, anomaly in (("298", 191.5675), ("296", 280.5787), ("297", 56.0731), ("297", 50.0)):
        one = summed(LINES[1].replace("13296.", f"13{day}.")[:68])
        two = summed(LINES[2][:43] + f"{anomaly:8.4f}" + LINES[2][51:68])
        sets.append([f"ENVISAT {len(sets)}", one, two])
    whole = paths.tle([line for lines in sets for line in lines], name=27386)
    assert "3 sets from TLE of 2013-10-23" in repr(whole) and whole.span is None
    again = pickle.loads(pickle.dumps(whole))
    seconds = np.array([[-1e4, 1.0e5, 5.0e4], [2.9e5, np.nan, 1.2e5]])
    used = [[1, 3, 1], [0, 0, 3]]  # of one epoch the last counts
    for path in (whole, again):
        position, velocity = path.state(at, seconds)
        for place, number in np.ndenumerate(used):
            wanted = paths.tle(sets[number]).state(at, seconds[place])
            assert np.array_equal(position[place], wanted[0], equal_nan=True)
            assert np.array_equal(velocity[place], wanted[1], equal_nan=True)
    with pytest.raises(AttitudeError, match="holds 4 satellites; give name"):
        paths.tle([line for lines in sets for line in lines])
    records = [{**OMM, "EPOCH": f"2013-10-2{k}T00:00:00", "BSTAR": "0"} for k in (5, 3)]
    nearest = paths.omm(json.dumps(records)).position(instant("2013-10-24T13:00"), 0.0)
    assert np.array_equal(nearest, paths.omm(records[0]).position(instant("2013-10-24T13:00"), 0.0))


def test_a_satellite_that_has_decayed_is_refused_with_the_epoch():
    path = paths.tle(decaying(LINES), any_epoch=True)
    assert np.isfinite(path.position(path.epoch, 0.0)).all()
    with pytest.raises(AttitudeError, match=r"SGP4 gives no position of 27386 at 20.* days from"):
        path.position(path.epoch, np.array([0.0, 4e7]))


@pytest.mark.parametrize("series, pole", [(erfa_series, pole_of_date), (teme_series, pole_of_teme)])
def test_the_fitted_pole_is_that_of_the_series(series, pole):
    seconds = np.random.default_rng(2).uniform(-8e8, 9e8, 50)
    exact = series(*_time_scales.jd_from_seconds(seconds, 0.0 * seconds))
    # 1e-15 rad are 7e-9 m at 7000 km; skyfield's angle in days and hours itself rounds by 1e-13.
    assert np.abs(pole(seconds, 0.0 * seconds) - exact)[:2].max() < 2e-15
    assert np.abs(pole(seconds, 0.0 * seconds) - exact)[2].max() < 3e-13


def test_the_rotation_angle_is_erfas():
    seconds = np.random.default_rng(3).uniform(-1e9, 1e9, 1000)
    jd = _time_scales.jd_from_seconds(seconds, 0.0 * seconds)
    away = rotation_angle(seconds, 0.0 * seconds) - erfa.era00(*jd)
    assert np.abs(np.arctan2(np.sin(away), np.cos(away))).max() < 2e-14  # a date in days: 7e-12 s


@pytest.mark.parametrize("longitude, latitude, height", [(-70.7, -30.2, 2700.0), (11.0, 89.9, 0.0)])
def test_a_site_is_where_astropy_has_it_on_the_same_table(longitude, latitude, height):
    path = paths.site(f"{longitude} deg", f"{latitude} deg", height)
    # 1973 to 2026, over many leap seconds.
    at = instant("2000-01-01T12:00:00")
    seconds = np.random.default_rng(4).uniform(-8.4e8, 8.2e8, 400)
    position, velocity = path.state(at, seconds)
    location = EarthLocation.from_geodetic(longitude * u.deg, latitude * u.deg, height * u.m)
    time = Time(*julian(at, seconds, NO_LOW), format="jd", scale="tdb")
    with earth_orientation.installed():
        theirs = location.get_gcrs_posvel(time)
    assert np.abs(position - theirs[0].xyz.to_value("m").T).max() < 1e-4
    assert np.abs(velocity - theirs[1].xyz.to_value("m/s").T).max() < 1e-6


def test_a_site_is_near_where_skyfield_has_it():
    path = paths.site("-70.7 deg", "-30.2 deg", 2700.0)
    theirs = paths.from_skyfield(wgs84.latlon(-30.2, -70.7, 2700.0))
    assert theirs.center == "earth"
    away = path.position(NOW, np.arange(0.0, 86400.0, 3600.0))
    away = away - theirs.position(NOW, np.arange(0.0, 86400.0, 3600.0))
    # Polar motion, 0.3 arcsec: 10 m.
    assert 1.0 < np.linalg.norm(away, axis=-1).max() < 20.0


def test_a_site_compressed_for_a_year():
    path = paths.site("11 deg", "48 deg", 500.0)
    small = paths.compress(path, NOW, NOW.after(3e7))
    seconds = np.random.default_rng(5).uniform(0.0, 3e7, 20_000)
    away = small.position(NOW, seconds) - path.position(NOW, seconds)
    # The daily kinks of UT1 lie between the samples.
    assert np.linalg.norm(away, axis=-1).max() < 2e-3


def test_the_zenith_is_the_normal_of_the_ellipsoid():
    path = paths.site("11 deg", "48 deg", 500.0)
    up, position = path.zenith(NOW, 0.0), path.position(NOW, 0.0)
    assert np.linalg.norm(up) == pytest.approx(1.0, abs=1e-15)
    higher = paths.site("11 deg", "48 deg", 1500.0).position(NOW, 0.0)
    assert higher - position == pytest.approx(1000.0 * up, abs=1e-8)
    tilt = np.degrees(np.arccos(up @ position / np.linalg.norm(position)))
    assert tilt == pytest.approx(0.191, abs=2e-3)  # geodetic less geocentric latitude at 48 deg


def test_epochs_outside_of_the_table_need_to_be_asked_for():
    late = instant("2045-01-01")
    path = paths.site("11 deg", "48 deg", name="Munich")
    with pytest.raises(AttitudeError, match=r"an epoch for Munich is 2045.*long_term=True"):
        path.position(late, 0.0)
    model = paths.site("11 deg", "48 deg", long_term=True)
    found = model.position(late, np.zeros(2))
    assert np.linalg.norm(found[0]) == pytest.approx(np.linalg.norm(path.itrs), abs=1e-6)
    assert model.span is None
    assert np.array_equal(model.position(NOW, 0.0), path.position(NOW, 0.0))
    with pytest.raises(AttitudeError, match="long_term is 'no'; it must be True or False"):
        paths.site("11 deg", "48 deg", long_term="no")
    with pytest.raises(AttitudeError, match="long_term is 'false'; it must be True or False"):
        paths.observatory("568", long_term="false")
    ends = np.array([each.seconds for each in path.span]) - NOW.seconds
    assert np.isfinite(path.position(NOW, ends)).all()


def test_observatories_by_code():
    path = paths.observatory("568")
    assert path.name == "568 Maunakea"
    place = EarthLocation.from_geocentric(*(path.itrs * u.m)).geodetic
    assert place.lat.deg == pytest.approx(19.826, abs=1e-3)
    assert place.lon.deg == pytest.approx(-155.472, abs=1e-3)
    assert place.height.to_value("m") == pytest.approx(4200.0, abs=60.0)
    geocenter = paths.observatory("500")
    assert not geocenter.position(NOW, 0.0).any()
    assert not geocenter.has_horizon and geocenter.span is None
    with pytest.raises(AttitudeError, match="does not list"):
        paths.observatory("ZZZ")
    with pytest.raises(AttitudeError, match="Hubble Space Telescope does not rest"):
        paths.observatory("250")
    with pytest.raises(AttitudeError, match="248 Hipparcos does not rest"):
        paths.observatory("248")


def test_sites_that_are_refused():
    with pytest.raises(AttitudeError, match="latitude is 48"):
        paths.site(11.0, 48.0)
    with pytest.raises(AttitudeError, match="height is in deg"):
        paths.site(0.1, 0.2, "3 deg")
