"""The polynomials that replace the series built into astropy."""

import pickle

import numpy as np
import pytest

from attitude.epochs._inputs import instant
from attitude.errors import AttitudeError
from attitude.paths._solar_system import BuiltIn
from attitude.scene import Scene

J2000 = instant("2000-01-01T12:00:00 TDB")
CENTURY = 36524.5 * 86400.0


@pytest.mark.parametrize("name", ["sun", "earth", "moon", "emb", "mercury", "mars barycenter"])
def test_they_differ_from_the_series_by_their_rounding(name):
    path = BuiltIn().step(name)
    # a few pieces, an epoch on their border, and both ends of the span
    seconds = np.array([-CENTURY, -3e9, 0.0, 1e5, path.pieces.width * 4321 - CENTURY, 2e9, CENTURY])
    position, velocity = path.state(J2000, seconds)
    wanted = path.series.position(J2000, seconds)
    assert np.linalg.norm(position - wanted, axis=-1).max() <= 1.5 * path.roughness
    # The velocities of plan94 differ from the derivatives of its positions by up to 26 m/s, so that
    # differences of positions over 4000 s are taken, which err by the jerk of Mercury: 0.06 m/s.
    inner = seconds[1:-1]
    ahead, behind = (path.series.position(J2000, inner + step) for step in (2e3, -2e3))
    rate = (ahead - behind) / 4e3
    limit = 0.1 if name == "mercury" else 0.02
    assert np.linalg.norm(velocity[1:-1] - rate, axis=-1).max() <= limit
    np.testing.assert_array_equal(path.position(J2000, seconds[::-1]), position[::-1])


def test_a_series_is_evaluated_once(monkeypatch):
    path = BuiltIn().step("earth")
    calls = []
    series = type(path.series)
    found = series._state
    monkeypatch.setattr(series, "_state", lambda *call: calls.append(1) or found(*call))
    seconds = np.linspace(0.0, 30 * 86400.0, 1000)
    first = path.position(J2000, seconds)
    assert len(calls) == 1
    np.testing.assert_array_equal(path.position(J2000, seconds), first)
    assert len(calls) == 1
    path.position(J2000, seconds + 40 * 86400.0)
    assert len(calls) == 2


def test_a_scene_evaluates_no_series_again(monkeypatch):
    scene = Scene(None, "mars barycenter", ephemeris="builtin")
    times = [f"2026-01-{day:02d}" for day in range(1, 20)]
    first = scene.at(times).phase_angle
    monkeypatch.setattr(
        "attitude.paths._solar_system.AstropyBody._state",
        lambda *call: pytest.fail("evaluated"),
    )
    np.testing.assert_array_equal(scene.at(times).phase_angle, first)


def test_copies_and_the_span():
    path = BuiltIn().step("mars barycenter")
    again = pickle.loads(pickle.dumps(path))
    np.testing.assert_array_equal(again.position(J2000, 5.0), path.position(J2000, 5.0))
    for seconds in (-CENTURY - 1.0, CENTURY + 1.0):
        with pytest.raises(AttitudeError, match="known from 1900"):
            path.position(J2000, seconds)
