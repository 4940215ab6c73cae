"""One line on a terminal says how far a long computation is; elsewhere nothing is written."""

import io
from types import SimpleNamespace

import numpy as np
import pytest

from attitude import Body, FreeRotation, Scene, Spin, events, paths
from attitude._support import blocks
from attitude.ensemble import Ensemble, _ensemble


class Terminal(io.StringIO):
    """A standard error that is a terminal."""

    def isatty(self):
        return True


@pytest.fixture
def shown(monkeypatch):
    """A terminal on which bars appear at once."""
    found = Terminal()
    # pytest sets sys.stderr anew between the fixture and the test
    monkeypatch.setattr(blocks, "sys", SimpleNamespace(stderr=found))
    monkeypatch.setattr(blocks, "_PATIENCE", 0.0)
    monkeypatch.setattr(blocks, "_INTERVAL", 0.0)
    monkeypatch.setattr(blocks, "_owner", None)
    return found


def _lines(shown):
    """Each line: its states, without trailing spaces."""
    lines = [line for line in shown.getvalue().split("\n") if line]
    return [[each.rstrip() for each in line.split("\r") if each] for line in lines]


def test_a_bar_is_one_line(shown):
    bar = blocks.ProgressBar("steps")
    for k, stage in enumerate(("", "a long stage", "b", ""), 1):
        bar(k, 4, stage)
    bar(4, 4)
    first, second, third, last = _lines(shown)[0]
    assert len(_lines(shown)) == 1
    assert first == "attitude: steps [" + "#" * 7 + "." * 23 + "]  25 %"
    assert second.endswith("]  50 %  a long stage") and third.endswith("]  75 %  b")
    assert last.endswith("#] 100 %")
    # the rest of a longer text is overwritten
    assert len(shown.getvalue().split("\r")[3]) == len(second)


def test_what_ends_before_the_bar_appears_writes_nothing(shown, monkeypatch):
    monkeypatch.setattr(blocks, "_PATIENCE", 60.0)
    bar = blocks.ProgressBar("quick")
    bar(1, 2)
    bar(2, 2)
    assert shown.getvalue() == ""


def test_no_terminal_no_line(monkeypatch):
    monkeypatch.setattr(blocks, "_PATIENCE", 0.0)
    for stream in (io.StringIO(), None):
        monkeypatch.setattr(blocks, "sys", SimpleNamespace(stderr=stream))
        bar = blocks.ProgressBar("steps")
        bar(1, 2)
        bar(2, 2)
        assert stream is None or stream.getvalue() == ""


def test_a_computation_within_another_draws_nothing(shown, monkeypatch):
    outer = blocks.ProgressBar("outer")
    outer(1, 3)
    inner = blocks.ProgressBar("inner")
    inner(1, 2)
    inner(2, 2)
    outer(2, 3)
    assert "inner" not in shown.getvalue()
    # one that has stopped, by Ctrl-C or an error, gives the line up
    monkeypatch.setattr(blocks, "_RELEASE", 0.0)
    blocks.ProgressBar("next")(1, 2)
    assert "next" in shown.getvalue()


def test_a_search_with_a_limit_of_time(shown):
    with blocks.timed("states", 1e-9) as report:
        report("first stage")
    with pytest.raises(KeyboardInterrupt), blocks.timed("states", 1e9) as report:
        report("second stage")
        raise KeyboardInterrupt
    (over, ended), (begun,) = _lines(shown)
    assert over.endswith("]  99 %  first stage") and ended.endswith("] 100 %")
    assert begun.endswith("]   0 %  second stage")
    found = []
    with blocks.timed("states", 1.0, found.append) as report:
        report("own")
    assert found == ["own"] and "own" not in shown.getvalue()


BODY = Body(moments=(10, 20, 26))
SPIN = Spin(epoch="2026-01-01", wxyz=(1, 0, 0, 0), angular_velocity=(0.01, 0.15, 0.01))
ORBIT = paths.kepler(
    epoch="2026-01-01", center="earth", semi_major_axis=7e6, eccentricity=0.01, inclination=1.0,
    node=0.1, pericenter_argument=0.2, mean_anomaly=0.3,
)  # fmt: skip


def _percentages(shown, label):
    """The percentages of the last line; parts of the first step may have had their own before."""
    states = _lines(shown)[-1]
    assert all(each.startswith(f"attitude: {label} [") for each in states)
    return [int(each.rpartition("]")[2].split()[0]) for each in states]


def test_passes_and_windows(shown):
    scene = Scene(None, ORBIT, observer=paths.site("10 deg", "45 deg"))
    assert len(events.passes(scene, "2026-01-01", "2026-01-04", elevation="10 deg"))
    found = _percentages(shown, "events")
    assert len(found) > 2 and found == sorted(found) and found[-1] == 100


def test_conditions_of_two_kinds(shown):
    """The samples of one, then the search for the other where the first leaves it open."""
    scene = Scene(FreeRotation(BODY, SPIN), ORBIT, observer="earth")
    lit = events.illuminated(scene, (0, 0, 1)) & (scene.quantity("lit_fraction") > 0.0)
    assert len(events.windows(lit, "2026-01-01", "2026-01-01T03:00:00"))
    found = _percentages(shown, "events")
    assert len(found) > 2 and found == sorted(found) and found[-1] == 100


def test_extrema(shown):
    times, _ = events.find_maxima(0.0, 1e4, np.sin, step=0.1)
    assert len(times) == 1592
    found = _percentages(shown, "events")
    assert len(found) > 2 and found == sorted(found) and found[-1] == 100


def test_ensembles(shown, monkeypatch):
    # 21 epochs of three members in a block
    monkeypatch.setattr(_ensemble, "_HELD", 64)
    several = Ensemble.of([FreeRotation(BODY, SPIN)] * 3)
    t = np.linspace(0.0, 60.0, 64)
    several.percentiles(lambda h: h.angular_velocity[..., 0], t, [50.0])
    found = _percentages(shown, "percentiles")
    assert found == [32, 65, 98, 100]
