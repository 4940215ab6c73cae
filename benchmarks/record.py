"""What every benchmark that writes files shares: where it ran, and whether it may write there."""

import os
import platform
import sys
import tempfile
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

FIGURES = Path(__file__).resolve().parent.parent / "docs" / "figures"
_PACKAGES = (
    "attitude-propagation",
    "numpy",
    "scipy",
    "numba",
    "mpmath",
    "heyoka",
    "orekit-jpype",
    "matplotlib",
)


def writable_folder(text):
    """The folder, made if need be; ends the program with a sentence if nothing can be written."""
    folder = Path(text)
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            pass
    except OSError as err:
        sys.exit(f"{folder} cannot be written ({err.strerror}); give another --output folder.")
    return folder


def machine():
    """Processor, cores and versions, for the record beside the numbers."""
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
    }


def processor():
    try:
        with open("/proc/cpuinfo") as lines:
            return next(x.split(":")[1].strip() for x in lines if x.startswith("model name"))
    except (OSError, StopIteration):
        return platform.processor() or platform.machine()
