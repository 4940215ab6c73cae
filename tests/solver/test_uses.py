"""The examples of docs/impulses.md and docs/torques.md run as a reader would run them.

They print what is quoted there.
"""

import re

import numpy as np
import pytest

from tests.support.examples import lines, numbers


def test_t_handle(tmp_path):
    printed = lines("t_handle.py", tmp_path)
    seconds = {numbers(line)[0]: numbers(line)[-1] for line in printed if "LONG_AXIS" in line}
    assert len(seconds) == 5
    # A hundred times nearer to the middle axis takes ln(100) of the unstable rate longer.
    apart = np.diff([seconds[1.0], seconds[1e-2], seconds[1e-4]])
    assert apart[0] == pytest.approx(apart[1], rel=1e-3)
    flips = numbers(next(line for line in printed if "turns over" in line))[1:]
    assert np.diff(flips) == pytest.approx(seconds[1e-2], abs=0.01)


def test_despin(tmp_path):
    printed = lines("despin.py", tmp_path)
    table = [numbers(line) for line in printed if re.match(r"\s+\d+\.\d{3}\s", line)]
    assert len(table) == 13
    momentum = np.array([row[3] for row in table])
    # a third of it a pulse, 3% of error in each component; the boom takes none
    assert momentum[1:12] / momentum[:11] == pytest.approx(np.full(11, 2.0 / 3.0), abs=0.06)
    assert momentum[12] == momentum[11]


def test_relaxation(tmp_path):
    printed = lines("relaxation.py", tmp_path)
    drift = float(re.search(r"moves by (\S+) of", printed[0]).group(1))
    assert drift < 1e-12  # 28,800 steps of two turns each
    table = [line.split() for line in printed if "_AXIS" in line]
    assert (table[0][1], table[-1][1]) == ("LONG_AXIS", "SHORT_AXIS")
    energy = np.array([float(row[2]) for row in table])
    assert np.all(np.diff(energy) <= 0.0) and energy[-1] == 1.0


@pytest.mark.slow
def test_apophis_2029(tmp_path):
    printed = lines("apophis_2029_torque.py", tmp_path)
    assert "27.380" in next(line for line in printed if "before" in line and "SHORT" in line)
    after = [line for line in printed if "%" in line]
    assert len(after) == 9
    assert sum("LONG_AXIS" in line for line in after) == 2
    steps = next(line for line in printed if "Fixed steps" in line)
    # nine days of tolerances of 1e-11 a step
    assert float(re.search(r"within (\S+) rad", steps).group(1)) < 5e-9


@pytest.mark.slow
def test_yorp(tmp_path):
    printed = lines("yorp.py", tmp_path)
    table = np.array([numbers(line) for line in printed if len(numbers(line)) == 5])
    assert table.shape == (6, 5)
    # one orbit integrated against the averaged torque, which holds the axis still for the orbit
    assert table[:, 1] == pytest.approx(table[:, 2], abs=0.002)
    assert table[:, 3] == pytest.approx(table[:, 4], abs=0.003)
    # the two poles of an orbit are alike
    assert table[:, 2] == pytest.approx(table[::-1, 2], abs=1e-4)
    assert table[:, 4] == pytest.approx(-table[::-1, 4], abs=1e-4)
