"""DAMIT light-curve files: what is read, what comes back, and a sentence for what is wrong."""

import numpy as np
import pytest

from attitude import AttitudeError
from attitude._support.constants import ASTRONOMICAL_UNIT_M as AU
from attitude.errors import AttitudeWarning
from attitude.formats.damit_light_curve import (
    DamitLightCurve,
    from_positions,
    read_damit_light_curves,
    write_damit_light_curves,
)

FILE = """\
2
2 1
2433827.771536 9.977964e-01 2.5 0.5 0.25 1.6 0.4 0.3
2433827.778296 1.008107e+00 2.5 0.5 0.25 1.6 0.4 0.3   V 17.2
1 0
  2433828.50000000001  0.5  -1 0 0   0 -2 0
"""


def written(tmp_path, text):
    path = tmp_path / "lc.txt"
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    return path


def test_two_curves_are_read(tmp_path):
    first, second = read_damit_light_curves(written(tmp_path, FILE))
    assert first.calibrated and not second.calibrated
    assert len(first) == 2 and first.jd[1] == 2433827.778296
    assert first.brightness[0] == 0.9977964
    np.testing.assert_array_equal(first.sun[1], [2.5, 0.5, 0.25])
    np.testing.assert_array_equal(second.earth, [[0.0, -2.0, 0.0]])
    # The decimals that a double of days (5e-10 d here) leaves out are kept.
    assert second.jd_low[0] == pytest.approx(1e-11, abs=1e-20)


def test_numbers_behind_the_eighth_are_said(tmp_path):
    path = tmp_path / "lc.txt"
    point = "2454035.6 1.04 -1.2 0.3 0.1 -0.4 0.9 0.1"
    path.write_text(f"1\n3 1\n{point} remark\n{point} 0.0054\n{point} 0.0054\n")
    with pytest.warns(AttitudeWarning, match=r"line 4: it has more than eight .* 1 others"):
        read_damit_light_curves(path)


def test_directions_are_turned_from_ecliptic_to_icrf(tmp_path):
    pole = DamitLightCurve([2460000.5], [1.0], [[0, 0, 3.0]], [[2.0, 0, 0]], calibrated=True)
    np.testing.assert_allclose(
        pole.sun_direction, [[0, -np.sin(np.radians(84381.448 / 3600)), 0.9174820620691818]],
        atol=1e-15,
    )  # fmt: skip
    np.testing.assert_allclose(pole.earth_direction, [[1.0, 0, 0]], atol=1e-16)
    assert pole.phase_angle[0] == pytest.approx(np.pi / 2, abs=1e-15)


def test_round_trip_of_many_digits(tmp_path):
    rng = np.random.default_rng(5)
    curves = [
        DamitLightCurve(
            2450000.5 + np.sort(rng.uniform(0, 1000, n)),
            rng.lognormal(size=n),
            rng.normal(size=(n, 3)),
            rng.normal(size=(n, 3)),
            calibrated=n % 2 == 0,
            jd_low=rng.uniform(-2e-10, 2e-10, n),
        )
        for n in (1, 4, 50)
    ]
    path = tmp_path / "lc.txt"
    write_damit_light_curves(path, curves)
    for given, read in zip(curves, read_damit_light_curves(path), strict=True):
        assert given.calibrated == read.calibrated
        for name in ("jd", "brightness", "sun", "earth"):
            np.testing.assert_array_equal(getattr(given, name), getattr(read, name))
        np.testing.assert_allclose(given.jd_low, read.jd_low, rtol=0, atol=1e-19)  # days
    again = tmp_path / "again.txt"
    write_damit_light_curves(again, read_damit_light_curves(path))
    assert again.read_text() == path.read_text()


def test_dates_are_written_as_short_as_they_were(tmp_path):
    curves = read_damit_light_curves(written(tmp_path, FILE))
    path = tmp_path / "again.txt"
    write_damit_light_curves(path, curves)
    dates = [line.split()[0] for line in path.read_text().splitlines() if len(line) > 9]
    assert dates == ["2433827.771536", "2433827.778296", "2433828.50000000001"]
    plain = DamitLightCurve([2433827.771536], [1.0], [[1, 0, 0]], [[1, 0, 0]], calibrated=True)
    write_damit_light_curves(path, plain)
    assert path.read_text().splitlines()[2].split()[0] == "2433827.771536"


def test_from_positions_and_back_to_seconds():
    sun, earth = [[AU, 0, 0]], [[0, 2 * AU, 0]]
    curve = from_positions(
        ["2013-01-09T12:00:00"], [1.0], sun, earth, calibrated=True, time_system="UTC",
        frame="ecliptic",
    )  # fmt: skip
    assert curve.jd[0] + curve.jd_low[0] == 2456302.0
    np.testing.assert_allclose(curve.sun, [[1.0, 0, 0]], atol=1e-15)
    np.testing.assert_allclose(curve.earth, [[0, 2.0, 0]], atol=1e-15)
    # TDB goes up to 3e-5 s a day faster or slower than UTC.
    hi, lo = curve.seconds_since("2013-01-09")
    assert hi[0] + (0.0 if lo is None else lo[0]) == pytest.approx(43200.0, abs=3e-5)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "line 1: the file is empty"),
        ("two\n", "line 1: the number of light curves is 'two'"),
        ("0\n", "line 1: the number of light curves is '0'"),
        ("1\n2\n", "line 2: the kind of light curve 1 of 1 is missing"),
        ("1\n2 3\n", "line 2: the kind of light curve 1 of 1"),
        ("1\n2.5 1\n", "line 2: the number of points of light curve 1 of 1 is '2.5'"),
        ("1\n2 1\n2450000 1 1 0 0 1 0 0\n", "line 3: the file ends after 1 of the 2 points"),
        ("2\n1 1\n2450000 1 1 0 0 1 0 0\n", "line 3: the file ends before light curve 2 of 2"),
        ("1\n1 1\n2450000 1 1 0 0 1 0\n", "line 3: point 1 of light curve 1 of 1 has 7 numbers"),
        ("1\n1 1\n2450000 x 1 0 0 1 0 0\n", "line 3: 'x' in point 1"),
        ("1\n1 1\n2450000 1 1 nan 0 1 0 0\n", "line 3: 'nan' in point 1"),
        ("1\n1 1\n2450000 -1 1 0 0 1 0 0\n", "Are these magnitudes?"),
        ("1\n1 1\n2450000 1 0 0 0 1 0 0\n", "line 3: the vector to the Sun"),
        ("1\n1 1\n2450000 1 1 0 0 1 0 0\n5\n", "line 4: there is more after the 1 light curves"),
        (b"\x00\x01", "line 1: it holds zero bytes"),
    ],
)
def test_what_is_wrong_is_said_with_file_and_line(tmp_path, text, said):
    path = written(tmp_path, text)
    with pytest.raises(AttitudeError) as error:
        read_damit_light_curves(path)
    assert str(path) in str(error.value) and said in str(error.value)


def test_what_cannot_be_written_is_refused_and_nothing_is_left(tmp_path):
    path = tmp_path / "lc.txt"
    good = DamitLightCurve([2460000.5], [1.0], [[1, 0, 0]], [[1, 0, 0]], calibrated=True)
    for given in ([], [good, "curve"], 5):
        with pytest.raises(AttitudeError):
            write_damit_light_curves(path, given)
    assert list(tmp_path.iterdir()) == []
    for change in ({"brightness": [0.0]}, {"sun": [[0, 0, 0]]}, {"jd": [np.nan]}, {"jd": []}):
        keywords = {"jd": [1.0], "brightness": [1.0], "sun": [[1, 0, 0]], "earth": [[1, 0, 0]]}
        with pytest.raises(AttitudeError):
            DamitLightCurve(**{**keywords, **change}, calibrated=True)
    with pytest.raises(AttitudeError, match="folder"):
        write_damit_light_curves(tmp_path / "none" / "lc.txt", good)


def curve(count, calibrated):
    rng = np.random.default_rng(1)
    return DamitLightCurve(
        2459000.5 + np.arange(count) / 1440.0,
        rng.uniform(0.5, 1.5, count),
        np.tile((1.0, 0.0, 0.0), (count, 1)),
        np.tile((0.0, 1.0, 0.0), (count, 1)),
        calibrated=calibrated,
    )


def test_a_calibrated_curve_is_cut_into_parts_that_fit(tmp_path):
    whole = curve(2501, True)
    write_damit_light_curves(tmp_path / "lc.txt", [whole, curve(10, False)])
    found = read_damit_light_curves(tmp_path / "lc.txt")
    assert [len(each) for each in found] == [833, 834, 834, 10]
    assert [each.calibrated for each in found] == [True, True, True, False]
    for name in ("jd", "brightness", "sun", "jd_low"):
        joined = np.concatenate([getattr(each, name) for each in found[:3]])
        if name != "jd_low":
            assert np.array_equal(joined, getattr(whole, name))


@pytest.mark.parametrize(
    ("curves", "sentence"),
    [
        ([(1001, False)], "1001 points in a relative curve, and DAMIT's programs take 1000"),
        ([(3, True)] * 101, "101 curves, and DAMIT's programs take 100"),
        ([(1000, False)] * 11, "11000 points in all, and DAMIT's programs take 10000"),
    ],
)
def test_what_cannot_be_cut_is_said(curves, sentence, tmp_path):
    given = [curve(*each) for each in curves]
    with pytest.warns(AttitudeWarning, match=sentence):
        write_damit_light_curves(tmp_path / "lc.txt", given)
    assert len(read_damit_light_curves(tmp_path / "lc.txt")) == len(given)
