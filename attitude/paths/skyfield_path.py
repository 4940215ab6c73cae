"""Paths of skyfield's vector functions: bodies, satellites, ground sites and their sums."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from attitude.epochs import time_scales
from attitude.errors import AttitudeError
from attitude.paths.bodies import body_name
from attitude.paths.moving_pole import timescale
from attitude.paths.path import Path, julian

_DAY = 86400.0


@dataclass(frozen=True, eq=False, repr=False)
class SkyfieldPath(Path):
    """A vector function of skyfield.  Made by `from_skyfield`.

    Attributes
    ----------
    function : skyfield vector function
    name, center, source
        As for all paths.
    """

    function: Any  # a VectorFunction, or an object of the user with the same methods
    center: str
    name: str
    source: str

    def _state(self, instant, hi, lo):
        from skyfield.constants import AU_M
        from skyfield.errors import EphemerisRangeError

        jd1, jd2 = np.broadcast_arrays(*julian(instant, hi, lo))
        time = timescale().tt_jd(jd1, jd2 - time_scales.tdb_minus_tt(jd1, jd2) / _DAY)
        # skyfield's own TDB, a short series, which kernels use, is off by up to 10 microseconds.
        time.tdb_fraction = (jd1 - time.whole) + jd2
        try:
            found = self.function.at(time)
        except EphemerisRangeError as err:
            raise AttitudeError(
                f"skyfield does not cover every epoch of {self.name}: {err}; leave out the epochs "
                "outside."
            ) from err
        position, velocity = found.position.au * AU_M, found.velocity.au_per_d * (AU_M / _DAY)
        # For a decayed satellite skyfield returns a message, and sometimes a finite position
        # inside the Earth.
        messages = [each for each in np.ravel(getattr(found, "message", None)) if each]
        if messages or not np.isfinite(position).all():
            reason = messages[0] if messages else "it gives NaN"
            raise AttitudeError(
                f"skyfield has no position of {self.name} at one of the epochs: {reason}; leave "
                "out such epochs."
            )
        return position, velocity


def from_skyfield(function: Any, *, name: str | None = None) -> SkyfieldPath:
    """The path of a vector function of skyfield.

    Parameters
    ----------
    function : skyfield vector function
        Object with ``.at(t)`` and ``.center``: ``planets["mars barycenter"]``,
        ``wgs84.latlon(...)``, an EarthSatellite, a sum or difference of such.
    name : str, optional
        skyfield's own, if not given.

    Raises
    ------
    AttitudeError
        For other objects, and for a center that is not a body.  The path raises it for epochs at
        which skyfield has no position.

    Notes
    -----
    skyfield's numbers at its cost: 1 microsecond an epoch for a kernel, 200 to 300 for satellites
    and ground sites, which `compress` amortises.  The epochs are passed in two doubles of TT and
    of TDB; rounding them to one double would move the Earth by 0.6 m.  A path can be pickled if
    skyfield's object can.
    """
    if not hasattr(function, "at") or not hasattr(function, "center"):
        raise AttitudeError(
            f"{function!r} is no vector function of skyfield; give an object with .at(t) and "
            '.center, such as load("de421.bsp")["mars"].'
        )
    center = function.center
    if not isinstance(center, (int, np.integer)):
        raise AttitudeError(
            f"{function!r} has the center {center!r}, which is not a body; add the vector from a "
            "body to that center."
        )
    label = name or getattr(function, "target_name", None) or type(function).__name__
    return SkyfieldPath(function, body_name(int(center)), str(label), "skyfield")
