"""What is computed as requested, but is less certain than it looks, is said; and DAMIT files."""

import warnings

import numpy as np
import pytest

from attitude import AttitudeError, Body, FreeRotation, Spin, paths, plots
from attitude.cli import main
from attitude.epochs import instant
from attitude.errors import AttitudeWarning
from attitude.formats import damit, detect, mission
from attitude.formats.damit_light_curve import (
    DamitLightCurve,
    read_damit_light_curves,
    write_damit_light_curves,
)

TLE = """ENVISAT
1 27386U 02009A   13296.16551405  .00000100  00000-0  47533-4 0  8339
2 27386 098.4160 001.9229 0001126 079.5538 280.5787 14.37637337609529"""
DAMIT = "250.5 -60.25 5.2701\n2451545.0 12.5\n0.1 0.5\n"
EPOCH = "2000-01-01T11:58:55.816"
DAY = 86400.0


@pytest.fixture
def damit_file(tmp_path):
    path = tmp_path / "asteroid.spin"
    path.write_text(DAMIT)
    return path


# ---- elements far from their epoch -------------------------------------------------------------


def test_a_satellite_warns_once_beyond_two_weeks():
    path = paths.tle(TLE)
    path.position(path.epoch, np.array([-13.9 * DAY, 13.9 * DAY, np.nan]))
    with pytest.warns(AttitudeWarning, match="ENVISAT is evaluated 14.1 days from") as said:
        path.position(path.epoch, 14.1 * DAY)
        path.position(path.epoch, -20.0 * DAY)
    assert len(said) == 1


def test_a_satellite_refuses_another_year():
    path = paths.tle(TLE)
    far = instant("2040-10-23")
    with pytest.raises(AttitudeError, match=r"9862 days from .* or any_epoch=True"):
        path.position(far, 0.0)
    accepted = paths.tle(TLE, any_epoch=True)
    assert np.isfinite(accepted.position(path.epoch.after(3000.0 * DAY), 0.0)).all()
    with pytest.raises(AttitudeError, match="any_epoch is 'yes'; it must be True or False"):
        paths.tle(TLE, any_epoch="yes")


def test_a_mission_may_accept_any_epoch(tmp_path):
    (tmp_path / "old.tle").write_text(TLE)
    text = """
    center = { tle = "old.tle", any_epoch = true }
    sun.direction = [0, 1, 0]
    columns = ["observer_distance km"]
    times.epochs = ["2019-01-01"]
    """
    found = mission.parse(text, folder=str(tmp_path))
    assert found.scene.center.any_epoch


# ---- light curves for DAMIT's programs ---------------------------------------------------------


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


# ---- DAMIT spin files as sources ---------------------------------------------------------------


def test_the_state_in_a_damit_file(damit_file, tmp_path):
    found = detect.read_state(damit_file)
    assert found.name == "asteroid"
    assert np.array_equal(found.motion.spin.wxyz, damit.read(damit_file).spin.wxyz)
    other = tmp_path / "spin.txt"
    other.write_text(DAMIT)
    assert detect.read_state(other).motion.period_phi == found.motion.period_phi
    toml = tmp_path / "state.txt"
    toml.write_text(
        'name = "three words"\n[body]\nmoments = [1, 2, 2.5]\n[spin]\nepoch = "2026-01-01"\n'
        "wxyz = [1, 0, 0, 0]\nangular_velocity = [0, 0, 1]\n"
    )
    assert detect.read_state(toml).name == "three words"


def test_the_state_in_a_table_is_refused(tmp_path):
    path = tmp_path / "table.a"
    path.write_text("stk.v.4.3\n")
    with pytest.raises(AttitudeError):
        detect.read_state(path)


def test_commands_take_a_damit_file(damit_file, tmp_path, capsys):
    assert main(["describe", str(damit_file)]) == 0
    assert "5.2701 h" in capsys.readouterr().out
    table = tmp_path / "table.csv"
    arguments = ["--stop", "1 h", "--step", "30 min", "--output", str(table)]
    assert main(["propagate", str(damit_file), *arguments]) == 0
    assert len(table.read_text().splitlines()) >= 4
    picture = tmp_path / "a.png"
    assert main(["plot", str(damit_file), "--output", str(picture)]) == 0
    assert picture.stat().st_size > 1000


def test_a_mission_takes_a_damit_file(damit_file, tmp_path):
    text = """
    spin = "asteroid.spin"
    observer.direction = [1, 0, 0]
    sun.direction = [0, 1, 0]
    columns = ["sun_direction"]
    times.epochs = ["2026-01-01"]
    """
    motion = mission.parse(text, folder=str(tmp_path)).scene.motion
    assert motion.period_phi == pytest.approx(5.2701 * 3600.0, rel=1e-12)


# ---- figures -----------------------------------------------------------------------------------


def tumbler():
    return FreeRotation(
        Body(moments=(10, 20, 26)), Spin("2026-01-01", (1, 0, 0, 0), (1.0, 15.0, 1.0))
    )


def test_the_time_axis_has_the_date_of_the_epoch():
    figure = plots.overview(tumbler())
    for axes in figure.axes[2:]:
        assert axes.get_xlabel() == "time since 2026-01-01T00:00:00 UTC, s"


def test_coarse_steps_are_said_once(tmp_path, capsys):
    motion = tumbler()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        plots.overview(motion, span=30.0)
    with pytest.warns(AttitudeWarning, match=r"a point every 0\.8333 s, .* period") as said:
        plots.overview(motion, span=1000.0)
    assert len(said) == 1
    with pytest.warns(AttitudeWarning, match="at most 0.04"):
        plots.rates(plots.new_figure((4, 4)).add_subplot(), motion, np.arange(0.0, 60.0))
    spin = tmp_path / "fast.toml"
    spin.write_text(
        "[body]\nmoments = [10, 20, 26]\n[spin]\nepoch = '2026-01-01'\nwxyz = [1, 0, 0, 0]\n"
        "angular_velocity = [1, 15, 1]\n"
    )
    picture = str(tmp_path / "a.png")
    assert main(["plot", str(spin), "--span", "1000 s", "--output", picture]) == 0
    err = capsys.readouterr().err
    assert err.startswith("attitude: warning: the curves have a point every 0.8333 s")
    assert err.count("\n") == 1
