"""Photometry in files: every format to one table, and a sentence for each row that is wrong."""

import warnings

import numpy as np
import pytest
from astropy import units
from astropy.table import QTable
from astropy.time import Time

from attitude import AttitudeError, inversion, paths, photometry
from attitude._support.constants import ASTRONOMICAL_UNIT_M
from attitude.errors import AttitudeWarning
from tests.support.photometry_files import ALCDEF, CSV, DAMIT, MPC, PSV, XML

AU_KM = ASTRONOMICAL_UNIT_M / 1000.0


def read(tmp_path, text, name="a.txt", **options):
    path = tmp_path / name
    path.write_text(text)
    return photometry.read(path, **options)


def test_named_columns(tmp_path):
    found = read(tmp_path, CSV)
    assert found.filters == ("R", "V") and found.sites == ("568", "703")
    assert found.sessions == ("a", "b")
    np.testing.assert_array_equal(found.value, [7.328, 7.317, 7.5])
    np.testing.assert_array_equal(found.sigma, [0.004, 0.004, np.nan])
    expected = Time([2455817.0, 2455817.0], [0.735937, 0.736235], format="jd", scale="utc")
    assert np.all(np.abs((found.times[:2] - expected).to_value("s")) < 1e-6)
    assert len(found.select(filter="R")) == 2 and len(found[2:]) == 1
    with pytest.raises(AttitudeError, match="filter is 'I'; it must be one of 'R', 'V'"):
        found.select(filter="I")
    alone = read(tmp_path, "jd,mag\n2460000.7,15\n")
    assert repr(alone) == "<LightCurve of a: 1 magnitude over 0 s about 2023-02-25>"
    with pytest.raises(AttitudeError, match="filter is 'V', but no point has a filter"):
        alone.select(filter="V")


@pytest.mark.parametrize(
    ("header", "columns", "value", "sigma", "used"),
    [
        ("JD,V,e_V,R,e_R", {}, 1.0, 2.0, "v, r hold brightness: v is used"),
        ("JD,V,e_V,R,e_R", {"mag": "R"}, 3.0, 4.0, None),
        ("JD,V,e_V,R,e_R", {"mag": "R", "error": "e_V"}, 3.0, 2.0, None),
        ("JD,Vmag,e_Vmag,x,y", {}, 1.0, 2.0, None),
        ("JD,mag,e_mag_V,x,y", {}, 1.0, 2.0, None),
        ("JD,Rmag,e_Rmag,Vmag,Vmag_err", {}, 3.0, 4.0, "rmag, vmag hold brightness: vmag is"),
        ("JD,mag,sigma,flux,x", {}, 1.0, 2.0, "mag, flux hold brightness: mag is used"),
    ],
)
def test_errors_of_one_of_several_bands(tmp_path, header, columns, value, sigma, used):
    found = read(tmp_path, f"{header}\n2460000.7,1,2,3,4\n", columns=columns)
    assert (found.value[0], found.sigma[0]) == (value, sigma)
    assert (used in found.notes[0]) if used else not found.notes


@pytest.mark.parametrize(
    ("header", "first", "scale", "offset", "time_of"),
    [
        ("bjd_tdb,flux,flux_err", "2455817.7", "tdb", 0.0, "barycenter"),
        ("BJD,flux", "2455817.7", "tdb", 0.0, "barycenter"),
        ("hjd,mag", "2455817.7", "utc", 0.0, "heliocenter"),
        ("mjd,mag", "55817.2", "utc", 2400000.5, "reception"),
        ("JD-2450000,mag", "5817.7", "utc", 2450000.0, "reception"),
        ("jd_tdb,mag", "2455817.7", "tdb", 0.0, "reception"),
        ("time,mag", "2455817.7", "utc", 0.0, "reception"),
        ("JD-2450000.5,mag", "5817.2", "utc", 2450000.5, "reception"),
        ("BJD_TDB - 2450000.5,mag", "5817.2", "tdb", 2450000.5, "barycenter"),
        ("MJD-50000,mag", "5817.2", "utc", 2450000.5, "reception"),
        ("mjd_tai,mag", "55817.2", "tai", 2400000.5, "reception"),
        ("mjd_tt,mag", "55817.2", "tt", 2400000.5, "reception"),
        ("midpointMjdTai,psfFlux,psfFluxErr", "60817.2", "tai", 2400000.5, "reception"),
        ("BTJD,flux", "3300.7", "tdb", 2457000.0, "barycenter"),
    ],
)
def test_dates(tmp_path, header, first, scale, offset, time_of):
    values = ",1.5" * header.count(",")
    found = read(tmp_path, f"{header}\n{first}{values}\n")
    assert found.time_of == time_of and found.is_flux == ("flux" in header.lower())
    expected = Time(float(first), offset, format="jd", scale=scale)
    assert abs((found.times[0] - expected).to_value("s")) < 1e-4


@pytest.mark.parametrize(
    ("text", "value", "sigma", "filters", "time_of"),
    [
        ("# JD flux err\n2450000.5 1.1 0.01\n", 1.1, 0.01, ("",), "reception"),
        ("# BJD_TDB mag err\n2450000.5 1.1 .01\n", 1.1, 0.01, ("",), "barycenter"),
        ("# 2 nights\n#HJD,mag [mag]\n# [d]\n2450000.5,1.1\n", 1.1, np.nan, ("",), "heliocenter"),
        (
            "###MJD m dm uJy duJy F err chi/N\n58200.1 18 0.05 200 10 o 0 1.1\n"
            "58200.2 18.5 0.05 150 10 c 0 1.1\n",
            200.0, 10.0, ("c", "o"), "reception",
        ),
        ("# taken at home\n2450000.5 1.1 0.01\n", 1.1, 0.01, ("",), "reception"),
    ],
    ids=["flux", "barycenter", "commas", "atlas", "no names"],
)  # fmt: skip
def test_names_of_columns_in_a_remark(tmp_path, text, value, sigma, filters, time_of):
    found = read(tmp_path, text)
    assert found.value[0] == value and found.filters == filters and found.time_of == time_of
    assert found.is_flux == ("flux" in text or "uJy" in text)
    np.testing.assert_array_equal(found.sigma[0], sigma)


@pytest.mark.parametrize("chosen", [{}, {"flux": "uJy"}, {"magnitude": "m"}])
def test_forced_photometry_of_atlas(tmp_path, chosen):
    """Where the flux is negative m is -m, no magnitude; dates are starts of 30 s."""
    text = "###MJD m dm uJy duJy F err\n58200.1 -17 0.02 -820 18 o 0\n"
    found = read(tmp_path, text, columns=chosen)
    expected = (-17.0, 0.02) if "magnitude" in chosen else (-820.0, 18.0)
    assert (found.value[0], found.sigma[0]) == expected
    middle = Time(58200.1, 15.0 / 86400.0, format="mjd", scale="utc")
    assert abs((found.times[0] - middle).to_value("s")) < 1e-4
    assert "forced photometry of ATLAS" in found.notes[0]


def test_tables_of_surveys(tmp_path):
    """Filters have their zero points; dates of the observer count before those at the Sun."""
    ztf = (
        "oid,hjd,mjd,mag,magerr,filtercode\n1,2458200.501,58200.0,18.1,.02,zg\n"
        "1,2458200.551,58200.05,17.6,.02,zr\n"
    )
    found = read(tmp_path, ztf)
    assert found.filters == ("zg", "zr") and found.time_of == "reception"
    found = read(tmp_path, ztf, columns={"hjd": "hjd"})
    assert found.time_of == "heliocenter"
    found = read(tmp_path, "jd,fid,magpsf,sigmapsf\n2458200.5,1,18.1,.02\n")
    assert found.value.tolist() == [18.1] and found.sigma.tolist() == [0.02]
    for key in ("filterID", "filtername", "passband"):
        assert read(tmp_path, f"MJD,mag,{key}\n58200.1,18,r\n").filters == ("r",)


def test_bad_rows_are_named(tmp_path):
    text = (
        "utc,mag,err\n2026-01-01,15.0,0.1\n2026-01-02,bright,0.1\n2026-02-30,15,0.1\n"
        "2026-01-03,15.1\n2026-01-04,>16.5,0.1\n2026-01-05,99.99,\n2026-01-06,15,-1\n"
        "2026/1/7 3:00:00,15.5,0.2\n2026-01-08,,\n"
    )
    with pytest.warns(AttitudeWarning, match="6 rows cannot be used: line 3: the magnitude is"):
        found = read(tmp_path, text)
    assert len(found) == 2
    assert [each.line for each in found.bad] == [3, 4, 5, 6, 7, 8]
    reasons = " ".join(each.reason for each in found.bad)
    for words in (
        "'bright', which is no number",
        "does not exist",
        "2 entries",
        "is a limit",
        "stands for a missing value",
        "not above zero",
    ):
        assert words in reasons
    assert found.notes == ("1 of 8 rows has no magnitude.",)
    with pytest.raises(AttitudeError, match=r"line 3.*correct or delete them"):
        read(tmp_path, text, bad="refuse")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert len(read(tmp_path, text, bad="ignore")) == 2


def test_columns_by_name(tmp_path):
    text = "T,Vcal,x\n2455817.7,15.0,1\n2455817.8,15.1,2\n"
    with pytest.raises(AttitudeError, match="no column of epochs"):
        read(tmp_path, text)
    found = read(tmp_path, text, columns={"jd": "T", "magnitude": "Vcal"})
    np.testing.assert_array_equal(found.value, [15.0, 15.1])
    with pytest.raises(AttitudeError, match="no column 'Rcal'"):
        read(tmp_path, text, columns={"jd": "T", "magnitude": "Rcal"})
    remark = "# T Vcal x\n2455817.7 15.0 1\n2455817.8 15.1 2\n"
    again = read(tmp_path, remark, columns={"jd": "T", "magnitude": "Vcal"})
    np.testing.assert_array_equal(again.value, found.value)
    # in place of all columns of the same meaning
    text = "jd,flux,mag,T\n2455817.7,1.5,15.0,2450000.5\n"
    found = read(tmp_path, text, columns={"bjd": "T", "flux": "flux"})
    assert found.is_flux and found.time_of == "barycenter"


def test_ecsv(tmp_path):
    times = Time(["2026-01-01", "2026-01-02"], scale="utc")
    table = QTable({"time": times, "mag": [15.0, 15.1] * units.mag, "err": [20, 30] * units.mmag})
    table.write(tmp_path / "a.ecsv", format="ascii.ecsv")
    found = photometry.read(tmp_path / "a.ecsv")
    np.testing.assert_allclose(found.sigma, [0.02, 0.03])
    assert np.all(np.abs((found.times - times).to_value("s")) < 1e-6)
    (tmp_path / "b.ecsv").write_text("# %ECSV 1.0\n# ---\nbroken")
    with pytest.raises(AttitudeError, match="cannot be read as ECSV") as raised:
        photometry.read(tmp_path / "b.ecsv")
    assert raised.value.__cause__ is None


def test_alcdef(tmp_path):
    with pytest.warns(AttitudeWarning, match="line 15: it has 1 entries"):
        found = read(tmp_path, ALCDEF)
    assert len(found) == 3 and found.name == "Example" and found.filters == ("C", "R")
    assert found.sessions == ("1 2011-09-13", "2 2011-09-16")
    assert found.sites == ("-116.38361, +34.29111 deg",)
    for code in ("NONE", "XXX", "-"):
        coded = ALCDEF.replace("OBSLATITUDE", f"MPCCODE={code}\nOBSLATITUDE")
        assert read(tmp_path, coded, bad="ignore").sites == found.sites
    # the exposure of 86.4 s begins at the date: its middle is 0.0005 d later
    middle = Time(2455820.0, 0.791528, format="jd", scale="utc")
    assert abs((found.times[2] - middle).to_value("s")) < 1e-3
    assert found.zero_points == "auto"
    relative = read(tmp_path, ALCDEF.replace("DIFFERMAGS=FALSE", "DIFFERMAGS=TRUE"), bad="ignore")
    assert relative.zero_points == "free"
    assert relative.notes[-1].startswith("1 of 2 blocks has differential magnitudes (DIFFERMAGS):")
    mixed = ALCDEF.replace("REDUCEDMAGS=NONE", "REDUCEDMAGS=POINT", 1)
    with pytest.raises(AttitudeError, match="some blocks have REDUCEDMAGS"):
        read(tmp_path, mixed, bad="ignore")
    reduced = ALCDEF.replace("REDUCEDMAGS=NONE", "REDUCEDMAGS=POINT").replace(
        "LTCAPP=NONE", "LTCAPP=POINT"
    )
    found = read(tmp_path, reduced, bad="ignore")
    assert found.unit_distances and found.time_of == "emission"


def test_an_alcdef_file_in_latin_1(tmp_path):
    text = ALCDEF.replace("OBJECTNAME=Example", "OBJECTNAME=Béatrice")
    path = tmp_path / "a.txt"
    path.write_bytes(text.encode("latin-1"))
    found = photometry.read(path, bad="ignore")
    assert found.name == "Béatrice" and "was read as Latin-1" in found.notes[-1]
    assert photometry.read(path, bad="ignore", encoding="latin-1").notes == found.notes[:-1]
    with pytest.raises(AttitudeError, match=r"is not text in UTF-8 \(byte 41\)"):
        photometry.read(path, encoding="UTF-8")
    with pytest.raises(AttitudeError, match="encoding is 'martian', which Python does not know"):
        photometry.read(path, encoding="martian")
    path.write_bytes(text.encode("utf-16"))
    assert photometry.read(path, bad="ignore", encoding="utf-16").name == "Béatrice"
    with pytest.raises(AttitudeError, match=r"is not text in UTF-8 \(byte 0\)"):
        photometry.read(path)


def test_dates_at_the_beginning_of_unknown_exposures_have_a_note(tmp_path):
    text = ALCDEF.replace("EXPOSURE=86.4\n", "")
    found = read(tmp_path, text, bad="ignore")
    assert "EXPJD of block 2 is not the middle, but EXPOSURE is not given" in found.notes[0]
    assert not read(tmp_path, ALCDEF, bad="ignore").notes
    # an integer too large for a double is a bad row
    rows = ALCDEF + f"DATA={'9' * 400}.5|7.2|0.1\n"
    assert [each.line for each in read(tmp_path, rows, bad="ignore").bad] == [15, 29]


def test_repeated_sessions_have_a_note(tmp_path):
    second = ALCDEF[ALCDEF.rindex("STARTMETADATA") :]
    found = read(tmp_path, ALCDEF + second, bad="ignore")
    assert len(found) == 4
    assert found.notes == (
        "1 of 4 rows repeats the date, magnitude, filter and site of others (line 41 those of line "
        "28); session '3 2011-09-16' repeats '2 2011-09-16': it counts twice.",
    )
    found = read(tmp_path, "jd,mag\n2455817.7,15\n2455817.8,15\n2455817.7,15\n")
    assert len(found) == 2 and "the first at line 2, 2455817.7, JD" in found.notes[0]


def test_written_cells_are_no_formulas(tmp_path):
    words = ["=1+A1", "+cmd|' /C calc'!A0", "-2+3+cmd|x", "@SUM(A1)", 'a "b", c', "-5.5", "R"]
    data = photometry.Photometry(
        [f"2026-01-0{k}" for k in range(1, 8)],
        magnitude=np.arange(7.0) + 10.0,
        session=words,
        name="a, =cmd\nb",
    )
    data.write(tmp_path / "a.csv")
    text = (tmp_path / "a.csv").read_text()
    cells = [line.split(",", 3)[3].lstrip('"') for line in text.splitlines()[2:]]
    assert [cell[0] for cell in cells] == ["'", "'", "'", "'", "a", "-", "R"]
    assert text.splitlines()[0] == "# a =cmd b: times of reception"
    back = photometry.read(tmp_path / "a.csv")
    assert [back.sessions[k] for k in back.session] == words and back.name == "a =cmd b"
    with pytest.raises(AttitudeError, match=r"give a name that ends in \.csv"):
        data.write(tmp_path / "a.ecsv")


def test_ades(tmp_path):
    with pytest.warns(AttitudeWarning, match="line 7: the date"):
        found = read(tmp_path, PSV)
    assert len(found) == 1 and found.sites == ("J95",) and found.filters == ("G",)
    assert "no magnitude" in found.notes[0]
    assert abs((found.times[0] - Time("2023-07-06T00:17:43.77")).to_value("s")) < 1e-6
    found = read(tmp_path, XML)
    assert found.value.tolist() == [22.458] and found.sigma.tolist() == [0.1]
    found = read(tmp_path, XML.replace("<permID>", "<exp>30</exp><permID>"))
    assert found.exposure.tolist() == [30.0] and found.name == "1"
    entity = XML.replace("<ades", '<!DOCTYPE a [<!ENTITY x SYSTEM "file:///etc/passwd">]><ades', 1)
    with pytest.raises(AttitudeError, match="document type declaration"):
        read(tmp_path, entity)


def test_mpc(tmp_path):
    found = read(tmp_path, MPC)
    assert found.value.tolist() == [12.4, 12.5] and found.sites == ("J38",)
    from_space = read(tmp_path, MPC.replace("C2023 03 05", "S2023 03 05"))
    assert from_space.notes[-1] == "1 record is of satellites or roving observers, and left out."
    expected = Time("2023-03-05T23:57:42.624", scale="utc")
    assert abs((found.times[0] - expected).to_value("s")) < 1e-3


@pytest.mark.parametrize(
    "date",
    ["2023 03 06.0013O", "2023 03 06.00 31", "2023 03 06.0.131", "2023 02 30.00131"],
    ids=["letter", "four words", "two points", "no such day"],
)
def test_a_wrong_date_of_mpc_is_a_bad_row(tmp_path, date):
    text = MPC.replace("2023 03 06.00131", date)
    assert text.count(date) == 1 and len(date) == 16  # the other columns stay where they are
    with pytest.warns(AttitudeWarning, match="line 4: the date is '2023"):
        found = read(tmp_path, text)
    assert [each.line for each in found.bad] == [4] and found.value.tolist() == [12.4]


def test_a_wrong_year_beside_one_record_of_mpc(tmp_path):
    """The first record begins with blanks, which are columns: two records are half of the MPC."""
    record = "     K19A01A  C2019 01 02.12345 01 23 45.67 -12 34 56.7          17.2 Vr     703\n"
    with pytest.warns(AttitudeWarning, match="line 2: its date is '2O19"):
        found = read(tmp_path, record + record.replace("2019", "2O19"))
    assert found.value.tolist() == [17.2] and found.sites == ("703",)


def test_damit(tmp_path):
    found = read(tmp_path, DAMIT)
    assert found.is_flux and found.time_of == "emission" and found.unit_distances
    assert found.sessions == ("1", "2") and found.sun.shape == (3, 3)
    assert found.magnitude[2] == pytest.approx(-2.5 * np.log10(0.5))
    assert found.notes[0].startswith("1 of 2 sessions is relative: their zero points are free")
    assert found.zero_points == ("2",)  # and those of the first one are shared


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "holds no rows"),
        ("utc,mag\n", "no rows"),
        ("utc,colour\n2026-01-01,3\n", "no column of magnitudes or flux"),
        ("mag\n3\n", "no column of epochs"),
        ("jd,mag\nx,3\n", "no row can be used; line 2: the date is 'x', which is no number"),
        ("jd,mag\n12345,3\n", "12345 is no Julian date"),
        ("time,mag\n12,3\n", "neither a date nor a Julian date"),
        ("jd,mag (V),mag (R)\n2460000.5,3,4\n", "has two columns 'mag'; rename or delete one"),
        ("<ades></ades>", "holds no <optical>"),
        ("<a><b></a>", "not well-formed"),
    ],
)
def test_files_that_cannot_be_read(tmp_path, text, words):
    with pytest.raises(AttitudeError, match=words):
        read(tmp_path, text)


def test_the_inversion_shares_the_reader(tmp_path):
    rows = [f"{2460000.5 + k / 7},{15 + 0.1 * (k % 3)},0.02,1,0.1,0,0.5,0.2,0" for k in range(30)]
    path = tmp_path / "c.csv"
    path.write_text(
        "jd,mag,err,sun_x,sun_y,sun_z,observer_x,observer_y,observer_z\n" + "\n".join(rows)
    )
    curve, found = inversion.LightCurve.read(path), photometry.read(path)
    np.testing.assert_array_equal(curve.magnitude, found.value)
    np.testing.assert_array_equal(curve.sun, found.sun)
    path.write_text(path.read_text().replace("jd,", "bjd,"))
    with pytest.raises(AttitudeError, match="light at the barycenter"):
        inversion.spin_states(inversion.LightCurve.read(path), "10 /d")


def test_sites_of_rows_and_of_sessions(tmp_path):
    """A dict names the places of the sessions, or of the sites where the file has them."""
    orbit = paths.kepler(
        semi_major_axis="1.9 au", eccentricity=0.2, inclination="8 deg", node="40 deg",
        pericenter_argument="10 deg", mean_anomaly="20 deg", epoch="2026-01-01",
    )  # fmt: skip
    rows = [(2461041.5 + k, 15.0 + k / 10, "ab"[k % 2]) for k in range(6)]
    path = tmp_path / "c.csv"
    places = {"a": "568", "b": "-70.7, -30.2 deg, 2700 m"}
    curves = []
    for name in ("session", "site"):
        path.write_text(f"jd,mag,{name}\n" + "\n".join(f"{t},{m},{s}" for t, m, s in rows))
        curves.append(photometry.LightCurve.read(path, path=orbit, site=places))
    np.testing.assert_array_equal(curves[0].observer, curves[1].observer)
    alone = [photometry.LightCurve.read(path, path=orbit, site=each) for each in places.values()]
    for k, curve in enumerate(alone):
        own = curves[1].site == k
        np.testing.assert_allclose(curve.vectors[1][own], curves[1].vectors[1][own], rtol=1e-12)
    assert not np.allclose(alone[0].observer, alone[1].observer, rtol=1e-6)
    part = curves[1][2:]
    assert set(part.scenes) == {"a", "b"} and len(part) == 4
    raw = photometry.LightCurve.read(path)
    np.testing.assert_array_equal(raw.reduced(orbit, site=places).observer, curves[1].observer)
    with pytest.raises(AttitudeError, match="the place of 'a': as site= of reduced and read"):
        raw.reduced(orbit)
    with pytest.raises(AttitudeError, match="light curve has no sessions"):
        path.write_text("jd,mag\n2461041.5,15\n2461042.5,15\n")
        photometry.LightCurve.read(path, path=orbit, site=places)


LONG = "x" * 20_000


@pytest.mark.parametrize(
    ("text", "options"),
    [
        (f"jd,mag,site\n2460000.5,1,{LONG}\n", {"path": "earth"}),
        (f"jd,mag,session\n2460000.5,1,{LONG}\n", {"zero_points": ("q",)}),
        ("jd,mag,session\n2460000.5,1,a\n", {"zero_points": (LONG,)}),
        ("jd,mag\n2460000.5,1\n", {"path": LONG}),
        (f"jd,{LONG}\n2460000.5,1\n", {}),
    ],
)
def test_errors_echo_little_of_the_input(tmp_path, text, options):
    with pytest.raises(AttitudeError) as raised:
        read(tmp_path, text, **options)
    assert len(str(raised.value)) < 700 and LONG[:200] not in str(raised.value)


def test_a_light_curve_without_geometry_is_asked_for_it(tmp_path):
    rows = "\n".join(f"{2460000.5 + k},{15 + k % 3}" for k in range(30))
    curve = read(tmp_path, f"jd,mag\n{rows}\n")
    assert not curve.has_geometry
    with pytest.raises(AttitudeError, match=r"has no geometry, which an inversion needs"):
        inversion.spin_states(curve, "0.3 /d")
    with pytest.raises(AttitudeError, match="no vectors to Sun and observer"):
        _ = curve.phase_angle
    assert inversion.LightCurve is photometry.LightCurve is photometry.Photometry


@pytest.mark.parametrize(
    ("text", "names"),
    [
        (ALCDEF.replace("OBJECTNAME=Example", "OBJECTNAME=Other", 1), "Example, Other"),
        (MPC.replace("00085  ", "00086  ", 1), "00085, 00086"),
        (MPC.replace("00085         C", "     K19A01A  C", 1), "00085, K19A01A"),
        (PSV.replace("2023-13", "2023-07").replace("XX5", "XX6", 1), "2023 XX5, 2023 XX6"),
        (XML.replace("<optical><stn>", "<optical><trkSub>P1</trkSub><mag>2</mag><stn>"), "1, P1"),
        ("jd,mag,object\n2460000.5,1,Eros\n2460001.5,1,Ida\n", "Eros, Ida"),
    ],
    ids=["alcdef", "mpc", "mpc-provisional", "psv", "xml", "csv"],
)
def test_photometry_of_several_objects_is_refused(tmp_path, text, names):
    with pytest.raises(AttitudeError, match=f"has photometry of 2 objects, .*{names}"):
        read(tmp_path, text, bad="ignore")


SKY = (
    "jd,mag [mag],error [{}],exposure [{}],ra [{}],dec [{}],{} [{}]\n2460000.5,15,{},{},{},{},{}\n"
)


@pytest.mark.parametrize("name", ["a.csv", "a.ecsv"])
def test_units_of_columns(tmp_path, name):
    """Units in brackets of CSV and those of ECSV are converted, each to that of its column."""
    plain = SKY.format("mag", "s", "deg", "deg", "delta", "au", 0.01, 300, 150, 20, 0.5)
    if name.endswith("ecsv"):
        columns = {"jd": [2460000.5] * units.d, "mag": [15.0] * units.mag}
        columns |= {"error": [10.0] * units.mmag, "exposure": [5.0] * units.min}
        columns |= {"ra": [10.0] * units.hourangle, "dec": [1200.0] * units.arcmin}
        QTable(columns | {"delta": [0.5 * AU_KM] * units.km}).write(
            tmp_path / name, format="ascii.ecsv"
        )
        found = photometry.read(tmp_path / name)
    else:
        other = "mmag", "min", "h", "arcmin", "delta", "km", 10, 5, 10, 1200, 0.5 * AU_KM
        found = read(tmp_path, SKY.format(*other))
    expected = read(tmp_path, plain)
    np.testing.assert_allclose(found.sigma, [0.01], rtol=1e-14)
    assert found.exposure[0] == expected.exposure[0] == 300.0
    np.testing.assert_allclose(found.vectors, expected.vectors, rtol=1e-12)


@pytest.mark.parametrize(
    ("header", "sigma", "words"),
    [
        ("jd,flux [Jy],flux_err [mJy]", 0.002, None),
        ("jd,flux [e-/s],flux_err [e-/s]", 2.0, None),
        ("JD [UTC],mag (V),err (1 sigma)", 2.0, None),
        ("jd,mag,err [counts]", None, "the column err is in 'counts'; give it in mag, or a unit"),
        ("jd,flux,err [mJy]", None, "in 'mJy'; give it in the unit of the flux"),
        ("jd,mag [V],err", None, "the column mag is in 'V'; give it in mag"),
    ],
)
def test_units_that_differ_or_are_none(tmp_path, header, sigma, words):
    if words is None:
        assert read(tmp_path, f"{header}\n2460000.5,15,2\n").sigma.tolist() == [sigma]
    else:
        with pytest.raises(AttitudeError, match=words):
            read(tmp_path, f"{header}\n2460000.5,15,2\n")


@pytest.mark.parametrize(
    ("place", "words"),
    [
        (
            "10,100,1",
            "the column dec holds 100 deg .line 2, 2460000.5.; give finite numbers from -90",
        ),
        ("10,10,-1", "the column delta holds -1 au"),
        ("nan,10,1", "the column ra holds nan deg"),
    ],
)
def test_places_in_the_sky_have_bounds(tmp_path, place, words):
    with pytest.raises(AttitudeError, match=words):
        read(tmp_path, f"jd,mag,ra,dec,delta\n2460000.5,15,{place}\n")


@pytest.mark.parametrize("error", ["1e-160", "1e-100", "1e-8"])
def test_an_error_far_below_the_others_is_refused(tmp_path, error):
    """Its weight would leave the other points without any in a fit."""
    for key, factor in (("mag", 1.0), ("flux", 1e-20)):
        rows = [(k, 15 * factor, 0.01 * factor) for k in range(9)]
        text = "".join(f"{2460000.5 + k},{m},{e}\n" for k, m, e in rows)
        header = f"jd,{key},err\n2460009.5,{15 * factor},{float(error) * factor}\n"
        with pytest.raises(AttitudeError, match=r"at line 2, 2460009\.5, and the median is"):
            read(tmp_path, header + text)
    with pytest.raises(AttitudeError, match=r"errors is .* at row 3"):
        photometry.fold(np.arange(9.0), 3.0, np.arange(9.0), [1, 1, 1, float(error)] + [1] * 5)
    # sessions may have fluxes in units of their own
    flux, session = [1e9, 1.1e9, 2e-9], ["a", "a", "b"]
    times = ["2026-01-01", "2026-01-02", "2026-01-03"]
    photometry.LightCurve(times, flux=flux, sigma=[1e7, 1e7, 1e-10], session=session)


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("date,time,mag\n2026-01-01,3:04:05.5,1\n2026/1/2,23:04,2\n", "2026-01-01T03:04:05.5"),
        ("date,utc,mag\n2026-01-01,03:04:05,1\n2026-01-02,23:04,2\n", "2026-01-01T03:04:05"),
        ("date,time,mag\n2026-01-01,2461041.75,1\n2026-01-02,2461042.8,2\n", "2026-01-01T06:00"),
        ("date,jd,mag\n2026-01-01,2461041.75,1\n2026-01-01,2461042.8,2\n", "2026-01-01T06:00"),
        (
            "date,time,mag\n2026-01-03,,1\n2026-01-01,3:04,1\n2026-01-02,4:04,1\n",
            "2026-01-01T03:04",
        ),
        ("date,time,mag\n2026-01-01 03:04:05,30,1\n2026-01-02 1:00,30,2\n", "2026-01-01T03:04:05"),
        ("time,mag\n,1\n2461041.75,1\n2461042.8,2\n", "2026-01-01T06:00"),
    ],
)
def test_dates_and_times_of_day_of_two_columns(tmp_path, text, expected):
    found = read(tmp_path, text, bad="ignore")
    assert len(found) == 2
    assert abs((found.times[0] - Time(expected, scale="utc")).to_value("s")) < 1e-4


def test_what_data_mean_is_written_and_read(tmp_path):
    """Unit distances of fluxes, zero points and the phase angle of zero."""
    damit = read(tmp_path, DAMIT)
    times = Time("2026-01-01") + np.arange(3) * units.day
    for curve in (
        damit,
        damit.replaced(zero_points="free", zero_phase=True),
        photometry.LightCurve(times, [15.0, 15.1, 15.2], zero_points=0.03),
        photometry.LightCurve(times, [15.0, 15.1, 15.2], zero_points="shared"),
    ):
        curve.write(tmp_path / "x.csv")
        back = photometry.read(tmp_path / "x.csv")
        for key in ("unit_distances", "zero_phase", "zero_points", "is_flux", "time_of"):
            assert getattr(back, key) == getattr(curve, key), key
        np.testing.assert_array_equal(back.value, curve.value)
    rows = "2460000.5,1,{},a\n2460001.5,1,{},b\n"
    for key, words in (("zero_phase", ("yes", "no")), ("zero_points", ("free", "x"))):
        with pytest.raises(AttitudeError, match=f"the column {key} holds .*in all rows"):
            read(tmp_path, f"jd,mag,{key},session\n" + rows.format(*words))


@pytest.mark.parametrize("center", ["barycenter", "heliocenter"])
def test_written_dates_at_a_center_are_exact(tmp_path, center):
    times = Time(2456293.0, np.arange(1, 4) / 7, format="jd", scale="tdb")
    data = photometry.LightCurve(times, [1.0, 2.0, 3.0], time_of=center)
    data.write(tmp_path / "a.csv")
    back = photometry.read(tmp_path / "a.csv")
    assert np.abs((back.times - times).to_value("s")).max() < 1e-6


def test_names_of_filters_in_figures_are_no_mathematics(tmp_path):
    t = np.arange(40.0) * 3600.0
    names = ["$r^$", "_g"] * 20
    curve = photometry.LightCurve(t, np.cos(t), filter=names, name="$_$", epoch="2020-01-01")
    folded = photometry.fold(curve, "20 h")
    for figure in (curve.plot(tmp_path / "curve.png"), folded.plot(tmp_path / "fold.png")):
        shown = figure.axes[0].get_legend().get_texts()
        assert [text.get_text() for text in shown[:2]] == [r"\$r^\$", " _g"]
