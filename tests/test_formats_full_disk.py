"""A disk that fills up while a file is written: a sentence, no half file, the old one as it was."""

import os
import re

import numpy as np
import pytest

from attitude import AttitudeError, Body, FreeRotation, Spin
from attitude.formats import aem, apm, damit, spin_file, stk, tables

resource = pytest.importorskip("resource", reason="limits of files are those of Unix")

BODY = Body(moments=(10, 20, 26))
MOTION = FreeRotation(
    BODY, Spin(epoch="2026-01-01", wxyz=(1, 2, 3, 4), angular_velocity=(0.01, 0.15, 0.01))
)
STEADY = FreeRotation(
    BODY, Spin(epoch="2026-01-01", wxyz=(1, 2, 3, 4), angular_velocity=(0, 0, 0.1))
)
HISTORY = MOTION.at(np.arange(400.0))
WRITERS = {
    "aem": lambda path: aem.write(path, HISTORY),
    "xml": lambda path: aem.write(path, HISTORY, xml=True),
    "apm": lambda path: apm.write(path, MOTION),
    "apm.xml": lambda path: apm.write(path, MOTION, xml=True),
    "a": lambda path: stk.write(path, HISTORY),
    "csv": lambda path: tables.write(path, HISTORY),
    "ecsv": lambda path: tables.write(path, HISTORY),
    "fits": lambda path: tables.write(path, HISTORY),
    "parquet": lambda path: tables.write(path, HISTORY),
    "toml": lambda path: spin_file.write(path, MOTION),
    "spin": lambda path: damit.write(path, STEADY),
}


def _kernel(path):
    from attitude.formats import ck

    ck.write(path, MOTION, 0.0, 2000.0, tolerance=1e-6)


WRITERS["bc"] = _kernel


@pytest.fixture
def no_file_longer():
    """Makes the system refuse to write more than so many bytes into a file."""
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    yield lambda size: resource.setrlimit(resource.RLIMIT_FSIZE, (size, hard))
    resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))


@pytest.mark.parametrize("ending", WRITERS)
@pytest.mark.parametrize("part", ["nothing", "a third", "all but a byte"])
def test_it_is_full_in_the_middle(tmp_path, no_file_longer, ending, part):
    if ending == "parquet":
        pytest.importorskip("pyarrow", reason="pyarrow is not installed")
    if ending == "bc":
        pytest.importorskip("spiceypy", reason="spiceypy is not installed")
    path = tmp_path / f"file.{ending}"
    WRITERS[ending](path)
    before = {name: (tmp_path / name).read_bytes() for name in os.listdir(tmp_path)}
    size = len(before[path.name])
    no_file_longer({"nothing": 0, "a third": size // 3, "all but a byte": size - 1}[part])
    with pytest.raises(AttitudeError, match=r"cannot be written: File too large|Is the disk full"):
        WRITERS[ending](path)
    after = {name: (tmp_path / name).read_bytes() for name in os.listdir(tmp_path)}
    assert after == before
    # and where there was none, there is none
    for name in before:
        (tmp_path / name).unlink()
    with pytest.raises(AttitudeError):
        WRITERS[ending](path)
    assert os.listdir(tmp_path) == []


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="/dev/full is a device of Linux")
@pytest.mark.parametrize("ending", ["aem", "xml", "apm", "a", "toml", "spin"])
def test_a_device_that_is_full(ending):
    with pytest.raises(AttitudeError, match=re.escape("'/dev/full' cannot be written: No space")):
        WRITERS[ending]("/dev/full")
    assert os.path.exists("/dev/full")


def test_an_interrupt_leaves_nothing(tmp_path):
    class Interrupted:
        spin = MOTION.spin

        def at(self, t, low=None):
            if len(np.atleast_1d(t)) > 0 and np.max(t) > 200.0:
                raise KeyboardInterrupt
            return MOTION.at(t, low)

    from attitude.formats import records

    size = records.PIECE
    with pytest.raises(KeyboardInterrupt):
        aem.write(tmp_path / "a.aem", Interrupted(), t=np.arange(2.0 * size) / size * 300.0)
    assert os.listdir(tmp_path) == []
