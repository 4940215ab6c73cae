"""Satellites far from the epoch of their elements: a warning after two weeks, then a refusal."""

import numpy as np
import pytest

from attitude import AttitudeError, paths
from attitude.epochs import instant
from attitude.errors import AttitudeWarning
from attitude.formats import mission

TLE = """ENVISAT
1 27386U 02009A   13296.16551405  .00000100  00000-0  47533-4 0  8339
2 27386 098.4160 001.9229 0001126 079.5538 280.5787 14.37637337609529"""
DAY = 86400.0


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
