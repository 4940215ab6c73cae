"""STK attitude files as STK, and scripts for STK, write them: tabs, dates, sections, axes."""

import numpy as np
import pytest

from attitude import AttitudeError, epochs
from attitude.formats import detect, stk
from attitude.frames import quaternion
from attitude.frames import representations as forms
from attitude.paths._path import Path

HEAD = {
    "NumberOfAttitudePoints": "2",
    "ScenarioEpoch": "1 Jul 1999 00:00:00.00",
    "CentralBody": "Earth",
    "CoordinateAxes": "ICRF",
}
QUATS = ("AttitudeTimeQuaternions", "0 0 0 0 1\n60 0 0 0.6 0.8")


class Circle(Path):
    """A circular orbit in the plane x, y of the ICRF, 1e-3 rad/s, at x at `START`."""

    name, center, source = "circle", "earth", "made for this test"

    def _state(self, instant, hi, lo):
        angle = 1e-3 * ((hi - START.seconds) + (lo - START.low) + instant.seconds)
        x, y, zero = np.cos(angle), np.sin(angle), 0.0 * angle
        return 7e6 * np.stack([x, y, zero]), 7e3 * np.stack([-y, x, zero])


START = epochs.instant("1999-07-01T00:00:00")


def written(path, head, section, rows, blank="\t"):
    lines = ["stk.v.11.0", "BEGIN Attitude", "\tMessageLevel\tErrors"]
    lines += [f"    {key}{blank}{value}" for key, value in (HEAD | head).items() if value]
    lines += ["", section, "", *rows.splitlines(), "", "END Attitude", ""]
    path.write_text("\n".join(lines))
    return path


def read(tmp_path, head=None, section=QUATS[0], rows=QUATS[1], **how):
    return stk.read(written(tmp_path / "a.a", head or {}, section, rows), **how)


def apart(p, q):
    d = quaternion.multiply(quaternion.conjugate(p), q)
    return np.max(2.0 * np.arctan2(np.linalg.norm(d[..., 1:], axis=-1), np.abs(d[..., 0])))


def turned(axis, angle):
    return forms.from_axis_angle(np.eye(3)["XYZ".index(axis)], np.radians(angle))


def product(*factors):
    found = factors[0]
    for factor in factors[1:]:
        found = quaternion.multiply(found, factor)
    return found


@pytest.mark.parametrize("blank", ["\t", " ", "\t\t  "])
def test_a_tab_is_as_good_as_a_blank(tmp_path, blank):
    found = stk.read(written(tmp_path / "a.a", {}, *QUATS, blank=blank))
    assert found.epoch.utc_iso == "1999-07-01T00:00:00"
    assert apart(found.wxyz[1], turned("Z", 2.0 * np.degrees(np.arcsin(0.6)))) < 1e-15
    assert detect.read(tmp_path / "a.a").wxyz.shape == (2, 4)


@pytest.mark.parametrize(
    "date",
    [
        *("1 July 1999 00:00:00.00", '"1 Jul 1999 00:00:00.00"', "01 jul 1999 0:00:00"),
        *("1999-07-01T00:00:00.000", "1999-182T00:00:00"),
    ],
)
def test_dates_of_the_epoch(tmp_path, date):
    assert read(tmp_path, {"ScenarioEpoch": date}).epoch == START


@pytest.mark.parametrize(
    ("form", "rows"),
    [
        ("EpSec", QUATS[1]),
        ("EpMin", "0 0 0 0 1\n1 0 0 0.6 0.8"),
        ("EpHr", "0 0 0 0 1\n0.016666666666666666 0 0 0.6 0.8"),
        ("UTCG", "1 Jul 1999 00:00:00.000 0 0 0 1\n1 Jul 1999 00:01:00.0 0 0 0.6 0.8"),
        ("UTCG", '"1 July 1999 00:00:00" 0 0 0 1\n"1 Jul 1999 00:01:00" 0 0 0.6 0.8'),
        ("ISO-YMD", "1999-07-01T00:00:00 0 0 0 1\n1999-07-01T00:01:00.0 0 0 0.6 0.8"),
        ("ISO-YD", "1999-182T00:00:00 0 0 0 1\n1999-182T00:01:00.0 0 0 0.6 0.8"),
    ],
)
def test_times_of_the_rows(tmp_path, form, rows):
    """Dates in rows need no ScenarioEpoch."""
    epoch = {} if form.startswith("Ep") else {"ScenarioEpoch": None}
    found = read(tmp_path, {"TimeFormat": form, **epoch}, rows=rows)
    hi, lo = epochs.seconds_since(START, found.epoch)
    assert abs(hi + lo) < 1e-12
    # TDB runs faster or slower than TAI by up to 3.3e-10: 2e-8 s in a minute.
    assert found.seconds == pytest.approx([0.0, 60.0], abs=3e-8)
    assert apart(found.wxyz[1], turned("Z", 2.0 * np.degrees(np.arcsin(0.6)))) < 1e-15


def test_a_leap_second_in_the_rows(tmp_path):
    rows = "31 Dec 2016 23:59:60.5 0 0 0 1\n1 Jan 2017 00:00:00.5 0 0 0.6 0.8"
    found = read(tmp_path, {"TimeFormat": "UTCG"}, rows=rows)
    assert found.seconds == pytest.approx([0.0, 1.0], abs=1e-9)


def test_numbers_as_matlab_writes_them(tmp_path):
    head = {"NumberOfAttitudePoints": "2.000000", "InterpolationOrder": "0"}
    found = read(tmp_path, head)
    assert (len(found), found.method, found.degree) == (2, "slerp", 1)
    head = {"InterpolationOrder": "1.000000", "BlockingFactor": "20", "AttitudeDeviations": "Mild"}
    assert read(tmp_path, head).method == "slerp"


def test_hermite_with_angular_velocities(tmp_path):
    rows = "\n".join(f"{k} 0 0 0 1 0 0 0" for k in range(6))
    head = {"NumberOfAttitudePoints": "6", "InterpolationOrder": "5"}
    for method in ("Lagrange", "Hermite"):
        found = read(
            tmp_path, head | {"InterpolationMethod": method}, "AttitudeTimeQuatAngVels", rows
        )
        assert (found.method, found.degree) == (method.lower(), 5)


# Angles and sections -----------------------------------------------------------------------------

ANGLES = 20.0, 35.0, -50.0


@pytest.mark.parametrize(
    ("sequence", "order"), [("321", "ZYX"), ("231", "YZX"), ("YPR", "ZYX"), ("RPY", "XYZ")]
)
def test_yaw_pitch_and_roll_turn_about_the_axes_of_the_reference(tmp_path, sequence, order):
    """Columns are yaw, pitch, roll; the rotation about the last of Sequence is done last."""
    angle = dict(zip("ZYX", ANGLES, strict=True))
    expected = product(*(turned(axis, angle[axis]) for axis in order[::-1]))
    rows = "0 20 35 -50\n60 20 35 -50"
    found = read(tmp_path, {"Sequence": sequence}, "AttitudeTimeYPRAngles", rows)
    assert apart(found.wxyz[0], expected) < 1e-15
    assert read(tmp_path, {}, "AttitudeTimeYPRAngles", rows).wxyz[0] == pytest.approx(
        product(turned("X", -50), turned("Y", 35), turned("Z", 20)), abs=1e-15
    )


def test_euler_angles_without_a_sequence_are_313(tmp_path):
    found = read(tmp_path, {}, "AttitudeTimeEulerAngles", "0 20 35 -50\n60 20 35 -50")
    expected = product(turned("Z", 20), turned("X", 35), turned("Z", -50))
    assert apart(found.wxyz[0], expected) < 1e-15


@pytest.mark.parametrize("form", ["Euler", "YPR"])
@pytest.mark.parametrize("both", [True, False])
def test_rates_of_angles(tmp_path, form, both):
    """Rates of 1 deg/s and more, linear in time: angles are their integral, to rounding."""
    t = np.arange(0.0, 12.0, 2.0)
    start, rate, bend = np.array([10.0, 20.0, 30.0]), np.array([1.0, -2.0, 0.5]), 0.1
    angles = start + t[:, None] * rate + 0.5 * bend * t[:, None] ** 2
    rates = rate + bend * t[:, None] * np.ones(3)
    head = {"NumberOfAttitudePoints": "6", "Sequence": "321"}
    if both:
        section = f"AttitudeTime{form}AnglesAndRates"
        rows = np.concatenate([t[:, None], angles, rates], axis=1)
    else:
        section = f"AttitudeTime{form}AngleRates"
        head[f"Initial{form}Angle"] = "321 10 20 30"
        rows = np.concatenate([t[:, None], rates], axis=1)
    text = "\n".join(" ".join(map(repr, row.tolist())) for row in rows)
    found = read(tmp_path, head, section, text)
    if form == "Euler":
        wxyz = quaternion.from_euler("ZYX", np.radians(angles))
        omega = forms.angular_velocity_from_euler_rates(
            "ZYX", np.radians(angles), np.radians(rates)
        )
    else:
        back = slice(None, None, -1)
        wxyz = quaternion.from_euler("XYZ", np.radians(angles[:, back]))
        omega = forms.angular_velocity_from_euler_rates(
            "XYZ", np.radians(angles[:, back]), np.radians(rates[:, back])
        )
    assert apart(found.wxyz, wxyz) < 1e-9  # seconds of TDB and TAI differ by 2e-10 s here
    assert found.angular_velocity == pytest.approx(omega, abs=1e-11)


@pytest.mark.parametrize(("section", "axes"), [("ECI", "J2000"), ("ECF", "Fixed")])
def test_vectors_point_body_x_and_leave_z_to_the_center(tmp_path, section, axes):
    rows = "0 0.1 0.2 0.9\n60 3 4 0"
    found = read(tmp_path, {}, f"AttitudeTime{section}Vector", rows, orbit=Circle())
    # The same vectors, turned to ICRF by the unit quaternion of a file in these axes.
    unit = read(tmp_path, {"CoordinateAxes": axes}, rows="0 0 0 0 1\n60 0 0 0 1")
    for k, vector in enumerate(([0.1, 0.2, 0.9], [0.6, 0.8, 0.0])):
        x = quaternion.rotate(unit.wxyz[k], np.array(vector) / np.linalg.norm(vector))
        history = found.history[k : k + 1]
        assert history.body_to_inertial([1, 0, 0])[0] == pytest.approx(x, abs=1e-15)
        angle = 1e-3 * 60.0 * k
        nadir = np.array([-np.cos(angle), -np.sin(angle), 0.0])
        nearest = nadir - np.dot(nadir, x) * x
        nearest /= np.linalg.norm(nearest)
        assert history.body_to_inertial([0, 0, 1])[0] == pytest.approx(nearest, abs=1e-9)
    with pytest.raises(AttitudeError, match="orbit="):
        read(tmp_path, {}, f"AttitudeTime{section}Vector", rows)


# Axes --------------------------------------------------------------------------------------------


def test_axes_of_date_and_of_b1950(tmp_path):
    import erfa

    from attitude.epochs import _time_scales

    unit = "0 0 0 0 1\n60 0 0 0 1"
    tt = _time_scales.jd_from_seconds(
        *_time_scales.tt_from_tdb(np.float64(START.seconds), np.float64(START.low))
    )
    for name, to_axes in (("TrueOfDate", erfa.pnm06a(*tt)), ("MeanOfDate", erfa.pmat06(*tt))):
        found = read(tmp_path, {"CoordinateAxes": name}, rows=unit)
        assert np.max(np.abs(found.history.dcm[0] - to_axes)) < 1e-15
        assert found.wxyz[0] @ found.wxyz[1] < 1.0 + 1e-15
        of_epoch = {"CoordinateAxes": name.replace("Date", "Epoch")}
        fixed = read(tmp_path, of_epoch | {"CoordinateAxesEpoch": HEAD["ScenarioEpoch"]}, rows=unit)
        assert np.array_equal(fixed.wxyz[0], fixed.wxyz[1])
        assert apart(fixed.wxyz[0], found.wxyz[0]) < 1e-15
    inertial = read(tmp_path, {"CoordinateAxes": "Inertial"}, rows=unit)
    assert np.array_equal(inertial.wxyz[0], [1, 0, 0, 0])


def test_b1950_is_that_of_spice(tmp_path):
    spice = pytest.importorskip("spiceypy", reason="spiceypy is not installed")
    unit = "0 0 0 0 1\n60 0 0 0 1"
    old, new = (read(tmp_path, {"CoordinateAxes": n}, rows=unit) for n in ("B1950", "J2000"))
    # From B1950 to EME2000; SPICE's J2000 stands for it here.
    matrix = new.history.dcm[0] @ old.history.matrix[0]
    assert np.max(np.abs(matrix - spice.pxform("B1950", "J2000", 0.0))) < 1e-15


@pytest.mark.parametrize("frame", ["TrueOfDate", "MeanOfDate", "B1950"])
def test_axes_there_and_back(tmp_path, frame):
    given = read(tmp_path)
    stk.write(tmp_path / "b.a", given, frame=frame)
    assert f"CoordinateAxes {frame}\n" in (tmp_path / "b.a").read_text()
    assert apart(stk.read(tmp_path / "b.a").wxyz, given.wxyz) < 1e-15


def test_vvlh_of_a_satellite(tmp_path):
    axes = {"CoordinateAxes": "Custom VVLH Satellite/Satellite1"}
    found, plain = (
        read(tmp_path, head, rows="0 0 0 0 1\n60 0 0 0 1", orbit=Circle())
        for head in (axes, {"CoordinateAxes": "VVLH"})
    )
    assert np.array_equal(found.wxyz, plain.wxyz)


BAD = [
    ({"TimeFormat": "JDate"}, QUATS, "line 8: TimeFormat is 'JDate'; known are EpSec"),
    ({"ScenarioEpoch": "Today"}, QUATS, "line 5: ScenarioEpoch is 'Today'; write a date"),
    ({"ScenarioEpoch": None}, QUATS, "ScenarioEpoch is not given; write a date"),
    ({"NumberOfAttitudePoints": "2.5"}, QUATS, r"line 4: NumberOfAttitudePoints is '2\.5'"),
    ({"InterpolationOrder": "40"}, QUATS, "line 8: InterpolationOrder is 40; it must be 0 to"),
    ({"InterpolationMethod": "Spline"}, QUATS, "line 8: InterpolationMethod is 'Spline'"),
    ({"RepeatPattern": "x"}, QUATS, "line 8: 'RepeatPattern' is not known"),
    ({"CoordinateAxes": "LVLH"}, QUATS, 'line 7: CoordinateAxes is LVLH, .* give frame="RTN"'),
    ({"CoordinateAxes": "AWB Body Satellite/A"}, QUATS, "line 7: .* that a scenario of STK"),
    ({"CoordinateAxes": "Inertial", "CentralBody": "Mars"}, QUATS, "line 7: .* Inertial of 'Mars'"),
    ({"CoordinateAxes": "Fixed", "CentralBody": "Mars"}, QUATS, "line 7: .* Fixed of 'Mars'"),
    ({"CoordinateAxes": "MeanOfDate", "CentralBody": "Moon"}, QUATS, "MeanOfDate of 'Moon'"),
    (
        {
            **{"CoordinateAxes": "TrueOfEpoch", "CentralBody": "Mars"},
            **{"CoordinateAxesEpoch": "1 Jul 1999 00:00:00"},
        },
        QUATS,
        "line 7: .* TrueOfEpoch of 'Mars', and are known for the Earth only",
    ),
    ({"CentralBody": "Mars"}, ("AttitudeTimeECFVector", "0 1 2 3"), "ITRF of 'Mars'"),
    ({"CoordinateAxes": "TrueOfEpoch"}, QUATS, "line 7: CoordinateAxesEpoch is not given"),
    ({}, ("AttitudeTimeAngVels", "0 1 2 3"), "line 9: the section AttitudeTimeAngVels is not read"),
    ({}, ("AttitudeTimeEulerAngleRates", "0 1 2 3"), "InitialEulerAngle: it is ''; .* three angle"),
    ({"Sequence": "313"}, ("AttitudeTimeYPRAngles", "0 1 2 3"), "line 8: Sequence: .* each axis"),
    ({"TimeFormat": "UTCG"}, QUATS, "line 12: it has 5 entries; a record has a time of 4 words"),
    (
        {"TimeFormat": "UTCG"},
        (QUATS[0], "31 Feb 1999 00:00:00 0 0 0 1"),
        "line 12: the time '1999-02-31T00:00:00' cannot be read",
    ),
]


@pytest.mark.parametrize(("head", "section", "sentence"), BAD)
def test_what_is_refused_is_refused_by_name(tmp_path, head, section, sentence):
    with pytest.raises(AttitudeError, match=sentence):
        read(tmp_path, head, *section)


def test_axes_of_the_earth_are_not_written_for_another_body(tmp_path):
    table = read(tmp_path)
    with pytest.raises(AttitudeError, match="Fixed of 'Mars', and are known for the Earth only"):
        stk.write(tmp_path / "b.a", table, frame="Fixed", center="Mars")
    stk.write(tmp_path / "b.a", table, frame="J2000", center="Mars")
    assert apart(stk.read(tmp_path / "b.a").wxyz, table.wxyz) < 1e-15


@pytest.mark.parametrize("sequence", ["zyx", "Zyx"])
def test_letters_of_sequences_are_of_either_case(tmp_path, sequence):
    rows = "0 10 20 30\n60 11 21 31"
    one, two = (
        read(tmp_path, {"Sequence": text}, "AttitudeTimeEulerAngles", rows)
        for text in (sequence, "321")
    )
    assert np.array_equal(one.wxyz, two.wxyz)
    initial = f"{sequence} 10 20 30"
    head = {"InitialEulerAngle": initial}
    three = read(tmp_path, head, "AttitudeTimeEulerAngleRates", "0 0 0 0\n60 0 0 0")
    assert np.array_equal(three.wxyz[0], two.wxyz[0])
