"""Paths of the bodies of the solar system by astropy."""

from __future__ import annotations

import os
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from attitude.epochs.inputs import Instant
from attitude.errors import AttitudeError
from attitude.paths.bodies import SSB
from attitude.paths.path import Path, julian

if TYPE_CHECKING:
    from attitude.annotations import FilePath

BUILT_IN_SOURCE: str = "ERFA series built into astropy"
# The range of ERFA's epv00, outside of which it warns: 1900-01-01 to 2100-01-01.
_SERIES_SPAN = Instant(-36524.5 * 86400.0), Instant(36524.5 * 86400.0)


@dataclass(frozen=True, eq=False, repr=False)
class AstropyBody(Path):
    """A body of `astropy.coordinates.get_body_barycentric_posvel`.  Made by `from_astropy`.

    Attributes
    ----------
    body : str
        astropy's name of the body.
    ephemeris : str
        "builtin", or the absolute path of a kernel.
    name, center, source, span, roughness
        As for all paths.
    """

    body: str
    ephemeris: str
    name: str
    source: str
    center = SSB

    @property
    def span(self) -> tuple[Instant, Instant] | None:  # type: ignore[override]  # computed
        """1900-01-01 to 2100-01-01 for the series; None for kernels, whose range astropy checks."""
        return _SERIES_SPAN if self.ephemeris == "builtin" else None

    @property
    def roughness(self) -> float:  # type: ignore[override]  # computed
        """0.1 m for the series, 0 for kernels; see `Path`."""
        # ERFA keeps its time as one double of years since J2000, 4e-7 s in 1900 and 2100.
        return 0.1 if self.ephemeris == "builtin" else 0.0

    @property
    def is_slow(self) -> bool:  # type: ignore[override]  # computed
        """True for the series, at 25 us an epoch; see `Path`."""
        return self.ephemeris == "builtin"

    def _state(self, instant, hi, lo):
        from astropy.coordinates import get_body_barycentric_posvel
        from astropy.time import Time
        from jplephem.exceptions import OutOfRangeError

        self.check_span(instant, hi, lo)
        time = Time(*np.broadcast_arrays(*julian(instant, hi, lo)), format="jd", scale="tdb")
        try:
            found = get_body_barycentric_posvel(self.body, time, ephemeris=self.ephemeris)
        except (KeyError, OutOfRangeError) as err:
            raise AttitudeError(
                f"{self.source} does not give {self.body} at every epoch ({err}); leave out epochs "
                "outside of its range, or give another kernel."
            ) from None
        return tuple(
            np.ascontiguousarray(each.xyz.to_value(unit))
            for each, unit in zip(found, ("m", "m/s"), strict=True)
        )


def from_astropy(body: str, ephemeris: FilePath = "builtin") -> AstropyBody:
    """The path of a body by astropy, relative to the solar system barycentre.

    Parameters
    ----------
    body : str
        astropy's name, such as "jupiter" (in astropy the barycentre of its system).
    ephemeris : "builtin" or path
        The path of a kernel on disk.  Names such as "de440", which astropy would download, are
        refused, and the setting that `solar_system_ephemeris` holds is neither used nor changed.

    Raises
    ------
    AttitudeError
        For a body that astropy lacks, and for a kernel path that is not a file.

    Notes
    -----
    The same numbers as astropy's, at its cost: 1 microsecond an epoch from a kernel, 50 from its
    series (1900 to 2100).  `ephemeris` and `body` read kernels faster; `compress` reduces the cost
    of either.
    """
    from astropy.coordinates import solar_system

    if ephemeris == "builtin":
        given, source = "builtin", BUILT_IN_SOURCE
        known = ("sun", "earth", "moon", *solar_system.PLAN94_BODY_NAME_TO_PLANET_INDEX)
    else:
        given = os.path.abspath(os.path.expanduser(os.fspath(ephemeris)))
        known = tuple(solar_system.BODY_NAME_TO_KERNEL_SPEC)
        source = f"{os.path.basename(given)} through astropy"
        if not os.path.isfile(given):
            raise AttitudeError(
                f"the kernel {given!r} is not a file; give the path of an SPK file or "
                '"builtin": nothing is downloaded.'
            )
    name = body.lower() if isinstance(body, str) else body
    if name not in known:
        raise AttitudeError(
            f"astropy has no body {body!r} in this ephemeris; give one of {', '.join(known)}."
        )
    return AstropyBody(name, given, name, source)
