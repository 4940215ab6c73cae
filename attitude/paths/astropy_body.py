"""Bodies of the solar system as astropy knows them."""

import os
from dataclasses import dataclass

import numpy as np

from attitude.epochs.inputs import Instant
from attitude.errors import AttitudeError
from attitude.paths.path import Path, julian

BUILT_IN_SOURCE = "ERFA series built into astropy"
# Where ERFA's epv00 states its accuracy; beyond, it warns.  1900-01-01 and 2100-01-01.
_SERIES_SPAN = Instant(-36524.5 * 86400.0), Instant(36524.5 * 86400.0)


@dataclass(frozen=True, eq=False, repr=False)
class AstropyBody(Path):
    """A body that `astropy.coordinates.get_body_barycentric` knows.  Made by `from_astropy`."""

    body: str
    ephemeris: str
    name: str
    source: str

    @property
    def center(self):
        return "ssb"

    @property
    def span(self):
        return _SERIES_SPAN if self.ephemeris == "builtin" else None

    @property
    def roughness(self):
        # ERFA keeps its time as one double of years since J2000, 4e-7 s in 1900 and 2100.
        return 0.1 if self.ephemeris == "builtin" else 0.0

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
                f"{self.source} does not give {self.body} at every epoch asked for ({err}); leave "
                "out what it lacks, or give another kernel."
            ) from err
        return tuple(
            np.ascontiguousarray(each.xyz.to_value(unit))
            for each, unit in zip(found, ("m", "m/s"), strict=True)
        )


def from_astropy(body, ephemeris="builtin"):
    """The path of any body that astropy knows, relative to the solar system barycentre.

    Parameters
    ----------
    body : str
        A name of astropy's, such as "jupiter" (which there is the barycentre of its system).
    ephemeris : "builtin" or path
        The path of a kernel on disk.  Names such as "de440", which astropy would download, are
        refused, and the setting that `solar_system_ephemeris` holds is neither used nor changed.

    Raises
    ------
    AttitudeError
        For a body that astropy lacks, and a kernel that is no file.

    Notes
    -----
    The same numbers as astropy's, at its cost: 1 microsecond an epoch from a kernel, 50 from its
    series (1900 to 2100).  `ephemeris` and `body` read kernels faster; `compress` makes either
    cheap.
    """
    from astropy.coordinates import solar_system as theirs

    if ephemeris == "builtin":
        known, source = ("sun", "earth", "moon", *theirs.PLAN94_BODY_NAME_TO_PLANET_INDEX), None
    else:
        ephemeris = os.path.abspath(os.path.expanduser(os.fspath(ephemeris)))
        known, source = tuple(theirs.BODY_NAME_TO_KERNEL_SPEC), os.path.basename(ephemeris)
        if not os.path.isfile(ephemeris):
            raise AttitudeError(
                f"the kernel {ephemeris!r} is not a file; give the path of an SPK file or "
                '"builtin": nothing is downloaded.'
            )
    name = body.lower() if isinstance(body, str) else body
    if name not in known:
        raise AttitudeError(f"astropy has no body {body!r} there; it has {', '.join(known)}.")
    return AstropyBody(
        name, ephemeris, name, BUILT_IN_SOURCE if source is None else f"{source} through astropy"
    )
