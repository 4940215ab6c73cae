"""A disk that fills up while a file is written: a sentence, no half file, the old one as it was."""

import importlib.util
import json
import os
import re
import subprocess
import sys
import traceback
from pathlib import Path

import numpy as np
import pytest

from attitude import AttitudeError, Body, FreeRotation, Spin
from attitude.formats import aem, apm, damit, spin_file, stk, tables
from tests.support.places import ROOT

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


def fill_up(ending, folder):
    """Write while the system refuses to write more than so many bytes into a file.

    Runs in a process of its own, of which the limit holds everywhere.
    """
    path = Path(folder, f"file.{ending}")
    WRITERS[ending](path)
    before = {each.name: each.read_bytes() for each in Path(folder).iterdir()}
    size = len(before[path.name])
    for limit in (0, size // 3, size - 1):
        limit_files(limit)
        with pytest.raises(AttitudeError, match=r"cannot be written: File too large|Is the disk"):
            WRITERS[ending](path)
        assert {each.name: each.read_bytes() for each in Path(folder).iterdir()} == before
    # and where there was none, there is none
    for name in before:
        Path(folder, name).unlink()
    with pytest.raises(AttitudeError):
        WRITERS[ending](path)
    assert os.listdir(folder) == []


def limit_files(size=None):
    """Set the largest file that this process may write, bytes; None for the system's."""
    import resource

    hard = resource.getrlimit(resource.RLIMIT_FSIZE)[1]
    resource.setrlimit(resource.RLIMIT_FSIZE, (hard if size is None else size, hard))


def fill_up_with(endings, folder):
    """Print what went wrong with each ending, "" if nothing: in a process of its own."""
    found = {}
    for ending in endings:
        own = Path(folder, ending)
        own.mkdir()
        try:
            fill_up(ending, own)
        except BaseException:
            found[ending] = traceback.format_exc()
        finally:
            limit_files()
    print(json.dumps({ending: found.get(ending, "") for ending in endings}))


@pytest.fixture(scope="module")
def filled_up(tmp_path_factory):
    """What went wrong with each ending; one process tries them all."""
    pytest.importorskip("resource", reason="limits of files are those of Unix")
    absent = {
        ending
        for ending, package in (("parquet", "pyarrow"), ("bc", "spiceypy"))
        if importlib.util.find_spec(package) is None
    }
    given = [each for each in WRITERS if each not in absent], str(tmp_path_factory.mktemp("disk"))
    code = f"from tests.formats.test_full_disk import fill_up_with; fill_up_with(*{given!r})"
    run = [sys.executable, "-c", code]
    found = subprocess.run(run, cwd=ROOT, capture_output=True, text=True, timeout=120)
    assert found.returncode == 0, found.stderr
    return json.loads(found.stdout)


@pytest.mark.parametrize("ending", WRITERS)
def test_it_is_full_in_the_middle(filled_up, ending):
    if ending == "parquet":
        pytest.importorskip("pyarrow", reason="pyarrow is not installed")
    if ending == "bc":
        pytest.importorskip("spiceypy", reason="spiceypy is not installed")
    assert filled_up[ending] == ""


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

    from attitude.formats import _sampling

    size = _sampling.PIECE
    with pytest.raises(KeyboardInterrupt):
        aem.write(tmp_path / "a.aem", Interrupted(), t=np.arange(2.0 * size) / size * 300.0)
    assert os.listdir(tmp_path) == []
