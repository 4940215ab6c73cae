"""Interpolated tables and CCSDS OEM files: polynomials exactly, orbits closely, errors by line."""

import re

import erfa
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from attitude import epochs, paths
from attitude.epochs._inputs import instant
from attitude.errors import AttitudeError
from tests.support.kernels import DATA, kernel

START = instant("2029-04-13T00:00:00 TDB")
AU = 149597870700.0

MESSAGE = """CCSDS_OEM_VERS = 2.0
CREATION_DATE = 2026-11-21T00:00:00
ORIGINATOR = TEST

META_START
OBJECT_NAME = PROBE
OBJECT_ID = 2026-001A
CENTER_NAME = EARTH
REF_FRAME = ICRF
TIME_SYSTEM = UTC
START_TIME = 2026-01-01T00:00:00
STOP_TIME = 2026-01-01T00:04:00
INTERPOLATION = LAGRANGE
INTERPOLATION_DEGREE = 3
META_STOP
COMMENT states
2026-01-01T00:00:00.000 7000.0 0 0 0 1.0 0
2026-01-01T00:01:00.000 7000.0 60 0 0 1.0 0
2026-001T00:02:00.000Z 7000.0 120 0 0 1.0 0 0 0 0
2026-01-01T00:03:00.000 7000.0 180 0 0 1.0 0
2026-01-01T00:04:00.000 7000.0 240 0 0 1.0 0
COVARIANCE_START
EPOCH = 2026-01-01T00:00:00
1.0
COVARIANCE_STOP
"""


LAGRANGE = [("LAGRANGE", 2, 2), ("LAGRANGE", 9, 4)]


def circle(t):
    angle = 1e-3 * t
    position = 7e6 * np.stack([np.cos(angle), np.sin(angle), 0.0 * t], -1)
    velocity = 7e3 * np.stack([-np.sin(angle), np.cos(angle), 0.0 * t], -1)
    return position, velocity


@given(st.integers(1, 9), st.booleans(), st.integers(0, 2**31))
def test_polynomials_of_the_degree_are_reproduced(degree, hermite, seed):
    if hermite:
        degree += 1 - degree % 2
    random = np.random.default_rng(seed)
    times = np.cumsum(random.uniform(50.0, 100.0, 14)) - 500.0
    series = random.normal(size=(degree + 1, 3))

    def exact(t):
        return np.polynomial.polynomial.polyval(t / 500.0, series).T

    slope = np.polynomial.polynomial.polyder(series) / 500.0
    rates = np.polynomial.polynomial.polyval(times / 500.0, slope).T
    path = paths.table(times, exact(times), rates if hermite else None, start=START, degree=degree)
    t = random.uniform(times[0], times[-1], 100)
    # Rounding grows with the degree: some 1e4 of it at degree 9 near the ends of a table.
    assert np.abs(path.position(START, t) - exact(t)).max() < 1e-10
    assert np.abs(path.position(START, times) - exact(times)).max() < 1e-12


@pytest.mark.parametrize("hermite, tolerance", [(True, 2e-4), (False, 6e-3)])
def test_orbits_are_followed_with_the_error_of_degree_7(hermite, tolerance):
    # Hermite: (h w / 2)^8 ... of 7e6 m for steps of 60 s; Lagrange's window is twice as wide.
    times = np.arange(0.0, 6001.0, 60.0)
    position, velocity = circle(times)
    path = paths.table(times, position, velocity if hermite else None, start=START)
    t = np.random.default_rng(1).uniform(300.0, 5700.0, 1000)
    assert np.abs(path.position(START, t) - circle(t)[0]).max() < tolerance
    assert np.abs(path.velocity(START, t) - circle(t)[1]).max() < tolerance


def test_velocities_of_lagrange_tables_are_interpolated_apart():
    times = np.arange(0.0, 600.0, 60.0)
    position, velocity = circle(times)
    path = paths.table(times, position, velocity + 1.0, start=START, interpolation="lagrange")
    assert np.abs(path.velocity(START, times) - velocity - 1.0).max() < 1e-9


def test_times_of_any_kind_and_two_doubles():
    times = ["2026-01-01T00:00:00", "2026-01-01T00:01:00", "2026-01-01T00:02:00"]
    x = np.array([0.0, 60.0, 120.0])
    path = paths.table(times, x[:, None] * [1.0, 0.0, 0.0], degree=1)
    at = instant("2026-01-01T00:01:30")
    assert path.position(at, 0.0)[0] == pytest.approx(90.0, abs=1e-6)  # TDB is not UTC
    step = path.position(at.after(0.0), 0.0, 1e-9)[0] - path.position(at, 0.0)[0]
    assert step == pytest.approx(1e-9, abs=2e-14)


def test_frames_are_turned():
    times = np.arange(0.0, 600.0, 60.0)
    position, velocity = circle(times)
    flat = paths.table(times, position, velocity, start=START, frame="ecliptic")
    assert flat.position(START, 60.0)[2] == pytest.approx(0.39777715593 * position[1, 1], rel=1e-9)


@pytest.mark.parametrize(
    "change, message",
    [
        ({"times": [0.0, 1.0, 1.0, 2.0]}, "must ascend, but row 2"),
        ({"times": [0.0, np.nan, 1.0, 2.0]}, "NaN"),
        ({"times": [0.0, 1.0]}, "there are 4 positions"),
        ({"start": None}, "give start"),
        ({"times": [0.0], "positions": np.zeros((1, 3))}, "covers no time"),
        ({"degree": 0}, "whole number from 1"),
        ({"degree": 2.0}, "whole number from 1"),
        ({"interpolation": "hermite"}, "needs velocities"),
        ({"interpolation": "spline"}, "must be one of 'lagrange', 'hermite'"),
        ({"positions": np.full((4, 3), np.nan)}, "positions holds nan"),
        ({"positions": np.full((4, 3), -1e31)}, r"a row has 1e\+31 m; give at most 1e\+30 m"),
        ({"velocities": np.full((4, 3), 1e31)}, r"a row has 1e\+31 m/s; give at most"),
        ({"times": [0.0, 1.0, 2.0, 1e16]}, r"rows of times lie 1 s to 1e\+16 s apart"),
        ({"positions": np.zeros((4, 2))}, "positions has shape"),
        ({"frame": "rtn"}, "frame is 'rtn'; it must be one of 'icrf', .*'itrf'"),
        ({"frame": "itrf"}, "[Ee]arth"),  # 2029 is beyond the table of Earth orientation
        ({"center": "nowhere"}, "center is 'nowhere'"),
        ({"span": ("2020-01-01", "2020-01-02")}, "2020-.* is not within the rows, from 2029"),
        ({"span": START}, "span is .*; give its first and last epoch"),
    ],
)
def test_tables_that_are_refused(change, message):
    given = {"times": [0.0, 1.0, 2.0, 3.0], "positions": np.zeros((4, 3)), "degree": 3}
    with pytest.raises(AttitudeError, match=message):
        paths.table(**{"start": START, **given, **change})


def test_epochs_outside_name_the_span():
    path = paths.table([0.0, 60.0], np.zeros((2, 3)), start=START, degree=1, name="probe")
    assert not path.position(START, [0.0, 60.0]).any()
    for t in (-1e-9, 60.0 + 1e-9):
        with pytest.raises(
            AttitudeError, match=r"probe is known from 2029-04-13T00:00:00.000 TDB to .*00:01:00"
        ):
            path.position(START, t)


def test_apophis_comes_as_near_as_published():
    path = paths.oem(DATA / "apophis-2029-encounter.oem")
    assert (path.center, path.name) == ("earth", "APOPHIS")
    near = instant("2029-04-13T21:46:00")
    distance = np.linalg.norm(path.position(near, np.arange(-600.0, 600.0)), axis=-1)
    assert distance.min() == pytest.approx(38.011e6, abs=3e3)
    far = paths.relative(paths.oem(DATA / "apophis-2012-2013.oem"), "earth", kernel("de421"))
    closest = np.linalg.norm(far.position(instant("2013-01-09T11:43:00"), 0.0))
    assert closest / AU == pytest.approx(0.09666, abs=1e-5)


def test_the_states_of_all_segments_are_met():
    file = DATA / "apophis-2029-encounter.oem"
    path = paths.oem(file)
    rows = [line.split() for line in file.read_text().splitlines() if line.startswith("2029")]
    start = instant("2029-04-06 TDB")
    days = (np.array([row[0] for row in rows], "M8[us]") - np.datetime64("2029-04-06")) / 1
    seconds = days.astype(np.float64) * 1e-6
    states = 1e3 * np.array([row[1:] for row in rows], dtype=np.float64)
    position, velocity = path.state(start, seconds)
    assert np.abs(position - states[:, :3]).max() < 1e-5  # rounding of 3e9 m, some times over
    assert np.abs(velocity - states[:, 3:]).max() < 1e-6


def test_the_interpolation_of_apophis_errs_by_metres_at_most():
    # Every other state left out: 256 times the error of all of them.
    path = paths.oem(DATA / "apophis-2029-encounter.oem")
    seconds = np.arange(0.0, 3 * 86400.0 + 1.0, 300.0)
    start = instant("2029-04-12 TDB")
    states = path.state(start, seconds)
    half = paths.table(seconds[::2], states[0][::2], states[1][::2], start=start, center="earth")
    missing = half.position(start, seconds[1::2]) - states[0][1::2]
    assert np.linalg.norm(missing, axis=-1).max() < 5.0


def message(tmp_path, *changes, text=MESSAGE):
    for old, new in changes:
        assert old in text
        text = text.replace(old, new)
    file = tmp_path / "probe.oem"
    file.write_text(text)
    return file


def test_a_message_in_utc_with_all_that_may_stand_in_it(tmp_path):
    path = paths.oem(message(tmp_path))
    at = instant("2026-01-01T00:01:30")
    assert path.position(at, 0.0) == pytest.approx([7e6, 9e4, 0.0], abs=1e-4)
    assert path.velocity(at, 0.0) == pytest.approx([0.0, 1e3, 0.0], abs=1e-9)
    assert (path.interpolation, path.degree, path.source) == ("lagrange", 3, "probe.oem")


@pytest.mark.parametrize("name, degree, used", [("HERMITE", 1, 3), ("HERMITE", 15, 9), *LAGRANGE])
def test_degrees_are_those_that_the_states_allow(tmp_path, name, degree, used):
    """Hermite of one state would extrapolate from it to the next: 60 km here."""
    lines = MESSAGE.replace("LAGRANGE", name).replace("DEGREE = 3", f"DEGREE = {degree}")
    lines = lines.replace("META_STOP", "USEABLE_START_TIME = 2025-12-31T00:00:00\nMETA_STOP")
    path = paths.oem(message(tmp_path, text=lines.replace(" 1.0 0\n", " 0.0 0\n")))
    before, after = (instant(f"2026-01-01T00:0{end}") for end in ("1:59.9999", "2:00.0001"))
    assert path.degree == used
    assert np.abs(path.position(before, 0.0) - path.position(after, 0.0)).max() < 2.0


def test_segments_of_few_states_and_names_in_lower_case(tmp_path):
    text = MESSAGE.replace("LAGRANGE", "hermite").replace("INTERPOLATION_DEGREE = 3\n", "")
    text = text.replace("= UTC", "= utc").replace("= ICRF", "= eme2000")
    lines = text[text.index("META_START") :].splitlines(keepends=True)
    lines = [line.replace("01-01T", "01-02T").replace("001T", "002T") for line in lines]
    rows = [k for k, line in enumerate(lines) if line[:1] == "2"]
    two, one = ("".join(lines[: rows[count]] + lines[rows[-1] + 1 :]) for count in (2, 1))
    path = paths.oem(message(tmp_path, text=text + one + two))
    assert [part.degree for part in path.parts] == [3, 7]
    position = path.position(instant("2026-01-02T00:00:30"), 0.0)
    assert position == pytest.approx([7e6, 3e4, 0.0], abs=2.0)  # EME2000: 23 mas of 7e6 m
    descending = text.replace("T00:03:00.000 7", "T00:00:30.000 7")
    with pytest.raises(AttitudeError, match=r"^[^:]*probe.oem, segment at line 5 \(.*must ascend"):
        paths.oem(message(tmp_path, text=descending))


@pytest.mark.parametrize("frame, named", [("itrf", "ITRF2014"), ("teme", "TEME"), ("tod", "TOD")])
def test_axes_of_the_earth_as_in_astropy(tmp_path, frame, named):
    from astropy import units as u
    from astropy.coordinates import GCRS, ITRS, TEME, CartesianDifferential
    from astropy.coordinates import CartesianRepresentation as Cartesian

    at = instant("2025-03-01")
    seconds = np.arange(0.0, 1801.0, 60.0)
    angle = 1.1e-3 * seconds
    r = 7e6 * np.stack([np.cos(angle), 0.6 * np.sin(angle), 0.8 * np.sin(angle)], -1)
    v = 7.7e3 * np.stack([-np.sin(angle), 0.6 * np.cos(angle), 0.8 * np.cos(angle)], -1)
    times = epochs.times(at, seconds)
    if frame == "tod":
        matrix = erfa.pnm06a(times.tt.jd1, times.tt.jd2)
        given_r, given_v = (np.einsum("nij,nj->ni", matrix, vectors) for vectors in (r, v))
    else:
        motion = CartesianDifferential(v.T * u.m / u.s)
        kind = {"itrf": ITRS, "teme": TEME}[frame](obstime=times)
        moved = GCRS(Cartesian(r.T * u.m, differentials=motion), obstime=times).transform_to(kind)
        given_r = moved.cartesian.xyz.to_value("m").T
        given_v = moved.velocity.d_xyz.to_value("m/s").T
    path = paths.table(seconds, given_r, given_v, start=at, frame=frame, center="earth")
    position, velocity = path.state(at, seconds)
    # TEME of skyfield and of astropy differ by 6e-11 rad, and astropy turns it with the precession;
    # its rates of ITRF are differences.
    bounds = {"itrf": (1e-7, 1e-6), "teme": (6e-4, 7e-5), "tod": (1e-7, 1e-8)}[frame]
    assert np.abs(position - r).max() < bounds[0]
    assert np.abs(velocity - v).max() < bounds[1]
    rows = "".join(
        f"{time} {' '.join(f'{x:.9f}' for x in 1e-3 * np.r_[a, b])}\n"
        for time, a, b in zip(times.utc.isot, given_r, given_v, strict=True)
    )
    start = MESSAGE.index("META_STOP")
    head = MESSAGE[:start].replace("= ICRF", f"= {named}").replace("= LAGRANGE", "= HERMITE")
    for old, new in zip(re.findall(r"ST\w+_TIME = (.*)", head), (0, -1), strict=True):
        head = head.replace(old, times.utc.isot[new])
    file = tmp_path / "earth.oem"
    file.write_text(f"{head}META_STOP\n{rows}")
    read = paths.oem(file).position(at, seconds[1:-1])
    assert np.abs(read - r[1:-1]).max() < 1.0  # isot has milliseconds


def test_the_useable_time_is_kept_to(tmp_path):
    change = "META_STOP", "USEABLE_START_TIME = 2026-01-01T00:01:00\nMETA_STOP"
    path = paths.oem(message(tmp_path, change))
    with pytest.raises(AttitudeError, match=r"known from 2026-01-01T00:02:09.184 TDB"):
        path.position(instant("2026-01-01T00:00:30"), 0.0)


def test_a_path_or_body_may_replace_the_center_of_a_message(tmp_path):
    bennu = paths.uniform((1e11, 2e10, 0), (0, 3e4, 0), "2026-01-01", center="sun", name="Bennu")
    file = message(tmp_path, ("CENTER_NAME = EARTH", "CENTER_NAME = BENNU"))
    with pytest.raises(
        AttitudeError, match=r"CENTER_NAME is 'BENNU'.*center= gives the path of any"
    ):
        paths.oem(file)
    path, at = paths.oem(file, center=bennu), instant("2026-01-01T00:01:30")
    assert path.center is bennu and paths.oem(file, center=2101955).center == "2101955"
    about = paths.relative(path, "sun").position(at, 0.0) - bennu.position(at, 0.0)
    assert about == pytest.approx([7e6, 9e4, 0.0], abs=1e-3)
    elements = (
        "a = 1.1 au, e = 0.2, i = 6 deg, node = 2 deg, peri = 66 deg, M = 5 deg, epoch = 2026"
    )
    table = {"oem": "probe.oem", "center": elements.replace("2026", "2026-01-01")}
    assert paths.place(table, folder=tmp_path).center.center == "sun"
    other = MESSAGE[MESSAGE.index("META_START") :].replace("= EARTH", "= MOON")
    with pytest.raises(AttitudeError, match=r"several centers \(EARTH, MOON\), which one center="):
        paths.oem(message(tmp_path, text=MESSAGE + other.replace("T00:0", "T01:0")), center=bennu)


@pytest.mark.parametrize("name, scale", [("GPST", "GPS"), ("TDT", "TT"), ("ET", "TDB")])
def test_other_names_of_time_systems(tmp_path, name, scale):
    spans = [
        paths.oem(message(tmp_path, text=MESSAGE.replace("= UTC", f"= {system}"))).span
        for system in (name, scale)
    ]
    assert spans[0] == spans[1]


def test_segments_with_other_centers_lead_to_the_barycentre(tmp_path):
    second = MESSAGE[MESSAGE.index("META_START") :].replace("= EARTH", "= MOON")
    second = second.replace("T00:0", "T01:0")
    path = paths.oem(message(tmp_path, text=MESSAGE + second), ephemeris=kernel("de421"))
    assert path.center == "ssb"
    for hour, body in (("00", "earth"), ("01", "moon")):
        at = instant(f"2026-01-01T{hour}:01:00")
        found = path.position(at, 0.0) - paths.body(body, kernel("de421")).position(at, 0.0)
        assert found == pytest.approx([7e6, 6e4, 0.0], abs=1e-3)
    with pytest.raises(
        AttitudeError, match=r"PROBE is known from 2026-01-01T00:01:09.* to .*, 2026"
    ):
        path.position(instant("2026-01-01T00:30:00"), 0.0)


@pytest.mark.parametrize(
    "old, new, error",
    [
        ("CCSDS_OEM_VERS", "CCSDS_AEM_VERS", r"probe.oem, line 1: .*CCSDS_OEM_VERS"),
        ("CENTER_NAME = EARTH\n", "", r"line 14: the meta data end without CENTER_NAME"),
        ("CENTER_NAME = EARTH", "CENTER_NAME EARTH", r'line 8: .* is no "KEYWORD = value"'),
        ("= EARTH", "= VULCAN", r"segment at line 5 .*CENTER_NAME is 'VULCAN'"),
        ("= ICRF", "= RTN", r"segment at line 5: REF_FRAME is RTN; it must be one of ICRF, .*ITRF"),
        ("= UTC", "= MRT", r"segment at line 5: TIME_SYSTEM is 'MRT'"),
        ("OBJECT_ID", "OBJECT_IDD", r"line 7: OBJECT_IDD is not known in the meta data of an OEM"),
        ("OBJECT_ID = 2026-001A", "OBJECT_NAME = X", r"line 7: OBJECT_NAME is given twice"),
        ("= LAGRANGE", "= SPLINE", r"INTERPOLATION is SPLINE"),
        ("START_TIME = 2", "START_TIME = hello 2", r"segment at line 5: epoch is 'hello"),
        ("STOP_TIME = 2026", "STOP_TIME = 2025", r"STOP_TIME is before START_TIME"),
        (
            "META_STOP",
            "USEABLE_START_TIME = 2026-01-01T00:02:00\n"
            "USEABLE_STOP_TIME = 2026-01-01T00:01:00\nMETA_STOP",
            r"USEABLE_STOP_TIME is before USEABLE_START_TIME",
        ),
        (
            "META_STOP",
            "USEABLE_START_TIME = 2026-01-01T00:04:01\nMETA_STOP",
            r"the span 2026-01-01T00:05:10.184 TDB to .* is not within the rows, from 2026",
        ),
        ("DEGREE = 3", "DEGREE = x", r"INTERPOLATION_DEGREE is x"),
        ("DEGREE = 3", "DEGREE = 0", r"the interpolation degree is 0; give a whole number"),
        ("7000.0 60 0", "7000.0 1e308 0", r"positions holds inf"),
        ("7000.0 60 0", "7000.0 nan 0", r"line 18: a number is not finite; a state has"),
        (
            "7000.0 60 0 0 1.0 0",
            "7000.0 60 0",
            r"line 18: it has 4 entries; a state has an epoch and 6",
        ),
        ("T00:03:00.000 7", "T00:01:00.000 7", r"must ascend, but row 3"),
        ("T00:03:00.000 7", "T00:63:00.000 7", r"segment at line 5 .*00:63:00"),
        ("META_STOP\n", "", r"line \d+"),
        ("META_START\n", "", r"line 14: META_STOP stands without META_START"),
        (
            "OBJECT_ID",
            "META_START\nOBJECT_ID",
            r"line 7: META_START stands before the end of the meta data before",
        ),
        ("= EARTH", "=", r"line 8: CENTER_NAME has no value"),
        ("ORIGINATOR = ", "ORIGINATOR ", r"line 3: 'ORIGINATOR TEST' is no .KEYWORD = value"),
    ],
)
def test_malformed_messages_are_refused_by_file_line_and_keyword(tmp_path, old, new, error):
    with pytest.raises(AttitudeError, match=error) as caught:
        paths.oem(message(tmp_path, (old, new)))
    assert "probe.oem" in str(caught.value)


@pytest.mark.parametrize("end", ["\n", "\r\n", "\r"])
def test_line_ends_and_comments_of_other_systems(tmp_path, end):
    text = MESSAGE.replace("COMMENT states", "COMMENT\nCOMMENT=x\nCOMMENT: y\nCOMMENTS")
    text = "\ufeff" + text.replace("OBJECT_NAME", "object_name")
    (tmp_path / "other.oem").write_bytes(text.replace("\n", end).encode())
    found, known = paths.oem(tmp_path / "other.oem"), paths.oem(message(tmp_path))
    at = instant("2026-01-01T00:01:30")
    assert np.array_equal(found.position(at, 0.0), known.position(at, 0.0))


def in_xml(text):
    """A message in KVN, with its states and covariance, as XML."""
    tags, lines = [], text[: text.index("COVARIANCE_START")].splitlines()
    names = ("EPOCH", *"XYZ", *(f"{k}_DOT" for k in "XYZ"), *(f"{k}_DDOT" for k in "XYZ"))
    for line in lines[1:]:
        key, _, value = line.partition(" = ")
        if line == "META_START":
            tags.append("</header><body><segment><metadata>")
        elif line == "META_STOP":
            tags.append("</metadata><data>")
        elif line[:1].isdigit():
            row = zip(names, line.split(), strict=False)
            tags.append("<stateVector>" + "".join(f"<{k}>{v}</{k}>" for k, v in row))
            tags.append("</stateVector>")
        elif value:
            tags.append(f"<{key}>{value}</{key}>")
    covariance = "<covarianceMatrix><EPOCH>x</EPOCH><CX_X>1</CX_X></covarianceMatrix>"
    head = '<oem id="CCSDS_OEM_VERS" version="2.0"><header>'
    return "\n".join([head, *tags, covariance * 2, "</data></segment></body></oem>"])


def test_xml_means_the_same(tmp_path):
    (tmp_path / "probe.oem").write_text(in_xml(MESSAGE))
    found = paths.oem(tmp_path / "probe.oem")
    known = paths.oem(message(tmp_path))
    at = instant("2026-01-01T00:01:30")
    assert np.array_equal(found.position(at, 0.0), known.position(at, 0.0))
    assert (found.interpolation, found.degree, found.span) == ("lagrange", 3, known.span)
    (tmp_path / "probe.oem").write_text(in_xml(MESSAGE).replace("<X>", '<X units="m">', 1))
    with pytest.raises(AttitudeError, match="X is in 'm'; it must be in km"):
        paths.oem(tmp_path / "probe.oem")


def test_what_is_no_message_is_refused(tmp_path):
    with pytest.raises(AttitudeError, match="cannot be read"):
        paths.oem(tmp_path / "missing.oem")
    (tmp_path / "binary.oem").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(AttitudeError, match=r"binary.oem, line 1: it is not well-formed XML"):
        paths.oem(tmp_path / "binary.oem")
    (tmp_path / "x.oem").write_text('<?xml version="1.0"?>\n<oem></oem>\n')
    with pytest.raises(
        AttitudeError, match=r"x.oem, line 2: its outermost element is <oem> of version None"
    ):
        paths.oem(tmp_path / "x.oem")
    (tmp_path / "empty.oem").write_text("CCSDS_OEM_VERS = 2.0\n")
    with pytest.raises(AttitudeError, match="the file ends before META_START"):
        paths.oem(tmp_path / "empty.oem")
