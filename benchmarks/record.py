"""Shared by benchmarks that write files: the output folder, the machine and the versions."""

import datetime
import os
import platform
import sys
import tempfile
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
FIGURES = ROOT / "docs" / "figures"
_PACKAGES = (
    "attitude-propagation",
    "numpy",
    "scipy",
    "numba",
    "mpmath",
    "heyoka",
    "orekit-jpype",
    "astrojax",
    "matplotlib",
)


def writable_folder(text):
    """The folder, created if missing; ends the program with a message if it is not writable."""
    folder = Path(text)
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            pass
    except OSError as err:
        sys.exit(f"{folder} cannot be written ({err.strerror}); give another --output folder.")
    return folder


def machine():
    """Processor, cores, versions and day, to be stored with the numbers."""
    found = {}
    for name in _PACKAGES:
        try:
            found[name] = version(name)
        except PackageNotFoundError:
            found[name] = None
    return {
        "processor": processor(),
        "cores": os.cpu_count(),
        "system": platform.platform(),
        "python": platform.python_version(),
        "packages": found,
        "date": datetime.date.today().isoformat(),
    }


def described(machine):
    """The machine, the versions of what was installed and the day of the run, as one sentence."""
    packages = (f"{name} {number}" for name, number in machine["packages"].items() if number)
    return (
        f"{machine['processor']}, {machine['cores']} cores, Python {machine['python']}; "
        f"{', '.join(packages)}; {machine['date']}."
    )


def processor():
    try:
        with open("/proc/cpuinfo") as lines:
            return next(x.split(":")[1].strip() for x in lines if x.startswith("model name"))
    except (OSError, StopIteration):
        return platform.processor() or platform.machine()
