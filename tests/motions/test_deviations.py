"""Errors of periods, angles and momentum: against samples of the motion, and as text."""

import math
import re

import numpy as np
import pytest

from attitude import AttitudeError, Body, FreeRotation, Spin, cli
from attitude.formats import spin_file
from attitude.motions._description import _numbers, deviations

COUNT = 2000
MOTIONS = {
    "LAM": ((10, 20, 26), (9.0, 2.0, 1.0)),
    "SAM": ((10, 20, 26), (1.0, 3.0, 9.0)),
    "near the separatrix": ((10, 20, 26), (1.0, 15.0, 1.0)),
    "symmetric": ((2, 2, 3), (0.3, 0.4, 0.9)),
    "sphere": ((2, 2, 2), (0.3, 0.5, 1.0)),
    "axis": ((1, 2, 2.7), (0.0, 0.0, 1.0)),
}

# Where all numbers are smooth; elsewhere periods and angles are limits, which errors leave to one
# side.
SMOOTH = ("LAM", "SAM", "near the separatrix")
UNIFORM = (
    *("spin_rate", "period", "momentum", "right_ascension", "declination", "longitude"),
    *("latitude", "energy"),
)


def motion_of(moments, omega, covariance, **settings):
    spin = Spin(
        epoch="2026-01-01",
        wxyz=(1, 2, 3, 4),
        angular_velocity=omega,
        covariance=covariance,
        **settings,
    )
    return FreeRotation(Body(moments=moments), spin)


@pytest.mark.parametrize("name", MOTIONS)
def test_within_the_scatter_of_samples(name):
    moments, omega = MOTIONS[name]
    root = np.random.default_rng(1).normal(size=(9, 9)) * 1e-6
    motion = motion_of(moments, omega, root @ root.T, frame="ecliptic")
    found = motion.deviations()
    samples = [_numbers(other) for other in motion.sample(COUNT, seed=2)]
    numbers = _numbers(motion)
    for key, (value, minus, plus) in found.items():
        assert np.array_equal([value], [numbers[key]], equal_nan=True)
        if name not in SMOOTH and key not in UNIFORM:
            continue
        away = np.array([sample[key] for sample in samples]) - value
        if key in ("right_ascension", "longitude"):
            away = (away + math.pi) % (2.0 * math.pi) - math.pi
        scatter = np.sqrt(np.mean(away**2))
        assert 0.5 * (plus + minus) == pytest.approx(scatter, rel=5.0 / np.sqrt(2.0 * COUNT)), key
        assert plus == pytest.approx(minus, rel=0.02), key


def test_the_momentum_agrees_with_its_covariance():
    moments, omega = MOTIONS["LAM"]
    motion = motion_of(moments, omega, {"attitude": 1e-5, "angular_velocity": 1e-5})
    momentum, found = motion.momentum, motion.deviations()
    size = np.linalg.norm(momentum)
    east = np.array([-momentum[1], momentum[0], 0.0]) / np.hypot(*momentum[:2]) ** 2
    for gradient, name in ((momentum / size, "momentum"), (east, "right_ascension")):
        expected = np.sqrt(gradient @ motion.momentum_covariance @ gradient)
        assert found[name].plus == pytest.approx(expected, rel=1e-4)
        assert found[name].minus == pytest.approx(expected, rel=1e-4)


def test_right_ascensions_on_either_side_of_zero():
    body = Body(moments=(1, 2, 2.7))
    spin = Spin("2026-01-01", (1, 0, 0, 0), (1.0, -1e-9, 0.0), covariance={"attitude": 0.01})
    found = FreeRotation(body, spin).deviations()["right_ascension"]
    assert found.plus == pytest.approx(0.01, rel=1e-4) == found.minus


def test_errors_beyond_the_separatrix_are_cut_there():
    motion = motion_of((10, 20, 26), (1.0, 15.0, 1.0), {"angular_velocity": 1.0})
    found = motion.deviations()
    assert all(math.isfinite(found["period_psi"][k]) for k in range(3))
    assert found["period_psi"].plus > found["period_psi"].minus > 0.0
    # The separatrix itself is at 0: as far as errors go.
    assert found["separatrix_distance"].minus <= np.sqrt(6) * found["separatrix_distance"].value
    assert re.search("  separatrix +within the errors: the mode is uncertain", str(motion))


def test_errors_beyond_the_moments_of_bodies_are_cut_there():
    """A flat body: its greatest moment cannot grow."""
    motion = motion_of((1.0, 2.0, 3.0), (0.3, 0.2, 1.0), {"moments": [0.0, 0.0, 0.01]})
    with pytest.raises(AttitudeError, match="exceeds the sum"):
        motion.sigma_points()
    found = motion.deviations()["energy_ratio"]
    assert found.minus > 0.0
    assert found.plus < 1e-6 * found.minus or found.minus < 1e-6 * found.plus


def test_no_errors():
    motion = motion_of(*MOTIONS["LAM"], np.zeros((9, 9)))
    assert all(minus == plus == 0.0 for _, minus, plus in motion.deviations().values())
    with pytest.raises(AttitudeError, match="has no covariance"):
        motion_of(*MOTIONS["LAM"], None).deviations()
    assert "+-" not in str(motion_of(*MOTIONS["LAM"], None))


def test_at_rest():
    motion = motion_of((1, 2, 2.7), (0, 0, 0), {"attitude": "1 deg", "moments": 0.1})
    assert "1 +- 0.1, 2 +- 0.1, 2.7 +- 0.1 kg m2" in str(motion)
    assert "1, 1, 1 deg about the axes of ICRF" in str(motion)
    assert deviations(motion, motion.spin.covariance)["momentum"].plus == 0.0


def test_the_text(tmp_path, capsys):
    motion = motion_of(
        (10, 20, 26),
        ["14.51 deg/day", "33.529 deg/day", "-98.709 deg/day"],
        {"attitude": "3 deg", "angular_velocity": "0.5 deg/day", "moments": 0.1},
        frame="ecliptic",
    )
    spin_file.write(tmp_path / "a.toml", motion)
    assert cli.main(["describe", str(tmp_path / "a.toml")]) == 0
    out = capsys.readouterr().out
    found = motion.deviations()
    rows = {line[:20].strip(): line[20:] for line in out.splitlines() if line.startswith("  ")}
    days = found["period_psi"]
    assert f" d +- {0.5 * (days.plus + days.minus) / 86400:.2g} d: rotation" in rows["period psi"]
    rate = np.degrees(found["spin_rate"].plus) * 86400
    assert f"= 105.253031 +- {rate:.2g} deg/d at the epoch" in rows["angular velocity"]
    pole = np.degrees([found[key].plus for key in ("right_ascension", "declination")])
    assert f" +- {pole[0]:.2g} deg, Dec " in rows["towards ICRF"]
    assert rows["towards ICRF"].endswith(f" +- {pole[1]:.2g} deg")
    assert rows["body"] == "principal moments 10 +- 0.1, 20 +- 0.1, 26 +- 0.1 kg m2"
    assert rows["attitude"] == "3, 3, 3 deg about the axes of the ecliptic of J2000"
    seconds = motion.predictable_time(tolerance=0.1)
    assert rows["predictable"].startswith(f"for {seconds:.9g} s = ")
    for line in out.splitlines()[2:]:
        if any(key in line for key in ("nutation", "spin rate", "energy", "1 - m", "2 E")):
            assert " +- " in line, line


@pytest.mark.parametrize(("error", "is_said"), [(0.1, False), (6.0, True)])
def test_periods_that_are_not_linear_are_said_to_be(error, is_said):
    motion = motion_of(*MOTIONS["LAM"], {"attitude": 0.01, "moments": [error, 0.1, 0.1]})
    assert ("not linear in rates and moments" in str(motion)) == is_said
