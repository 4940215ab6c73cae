"""Mutated files of the newer readers; `python benchmarks/fuzz_formats.py` mutates more."""

import tempfile
from pathlib import Path

import pytest

from benchmarks import fuzz_formats
from tests.support.fuzzing import NAMES, samples

pytestmark = pytest.mark.filterwarnings("ignore::attitude.errors.AttitudeWarning")


@pytest.mark.parametrize("name", sorted(NAMES))
def test_files_are_read_before_they_are_mutated(name):
    data, ending = samples()[name]
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / f"x.{ending}"
        path.write_bytes(data)
        fuzz_formats.read(path, name)


def test_all_files_are_read():
    assert set(samples()) == set(NAMES)


def test_mutated_files():
    """A thousand: an answer or an AttitudeError, none over 5 s, no partial file."""
    outcomes, slowest, faults = fuzz_formats.hunt(1000, seed=7)
    assert faults == 0 and slowest < fuzz_formats.SLOWEST
    # The mutations leave some files readable and break others.
    assert min(outcomes["read"], outcomes["refused"]) > 100


@pytest.mark.slow
def test_many_mutated_files():
    _, slowest, faults = fuzz_formats.hunt(100_000, seed=11)
    assert faults == 0 and slowest < fuzz_formats.SLOWEST
