"""The examples of mean rotations run as a reader would run them, and print what their heads say."""

import numpy as np
import pytest

from tests.support.examples import lines, numbers


def rows_of(printed, count):
    return [numbers(line) for line in printed if len(numbers(line)) == count]


@pytest.mark.slow
def test_goes_like(tmp_path):
    printed = lines("goes_like.py", tmp_path)
    table = [line.split() for line in printed if line.split()[1:2] and "to" in line.split()][:6]
    odds = np.array([float(row[2]) for row in table])
    assert np.all((odds > 0.9) & (odds < 1.0001))
    assert [int(row[1]) for row in table] == sorted(int(row[1]) for row in table)
    assert sum("passages on day" in line for line in printed) == 5


@pytest.mark.slow
def test_envisat_momentum(tmp_path):
    """Published numbers: the fit of 2013 to 2015 to 1.5 %, the precession to 5 %, radar to 8 %."""
    printed = lines("envisat_momentum.py", tmp_path)
    table = {row[0]: row[1:] for row in map(numbers, printed) if row[:1] and 2013 <= row[0] < 2018}
    fitted = np.array([row[:2] for row in table.values() if len(row) == 4])
    assert len(fitted) == 6
    assert np.max(np.abs(fitted[:, 0] / fitted[:, 1] - 1.0)) < 0.015
    assert table[2013.5][-2] == pytest.approx(4.8, rel=0.05)
    assert table[2015.5][-2] == pytest.approx(3.4, rel=0.05)
    (radar,) = [line for line in printed if line.startswith("March 2017")]
    assert numbers(radar)[1] == pytest.approx(226.0, rel=0.08)
    assert any("too slow for its path" in line for line in printed)


@pytest.mark.slow
def test_toutatis_damping(tmp_path):
    printed = lines("toutatis_damping.py", tmp_path)
    table = [line for line in printed if line.count("Gyr") == 2 and "to " not in line[24:]]
    times = np.array([numbers(line[24:]) for line in table])
    assert times.shape == (4, 3)
    # a thousandth of mu Q: a thousandth of the time, and the same number in units of it
    np.testing.assert_allclose(times[1, :2], times[0, :2] / 1000.0, rtol=1e-2)
    np.testing.assert_allclose(times[3, :2], times[2, :2] * 1000.0, rtol=1e-2)
    assert times[1, 2] == times[0, 2]
    (harris,) = [line for line in printed if "Harris 1994" in line]
    # (182/17)^3 / 2.7^2 in 10^9 years
    assert numbers(harris.split("1994")[1])[0] == pytest.approx(166.0, rel=0.01)


@pytest.mark.slow
def test_asteroid_end_states(tmp_path):
    printed = lines("asteroid_end_states.py", tmp_path, "40")
    counts = np.array(rows_of([line for line in printed if "%" not in line], 6))
    assert counts.shape == (10, 6)
    assert np.all(np.sum(counts[:, 2:], axis=1) == 4)
    # small bodies tumble, large ones relax
    assert np.sum(counts[5:, 2]) > np.sum(counts[:5, 2])
