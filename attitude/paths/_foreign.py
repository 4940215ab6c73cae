"""Places of astropy and skyfield: EarthLocation, SkyCoord, wgs84 positions, vector functions."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from attitude._support.constants import DAY_S
from attitude._support.validation import shown
from attitude.epochs import _time_scales
from attitude.errors import AttitudeError
from attitude.frames._earth import timescale
from attitude.paths._ground import site_at
from attitude.paths._path import Path, body_name, direction, fixed, julian

if TYPE_CHECKING:
    from attitude.paths._ground import Site
    from attitude.paths._path import Place


# ---- Paths of skyfield's vector functions: bodies, satellites, ground sites and their sums


@dataclass(frozen=True, eq=False, repr=False)
class SkyfieldPath(Path):
    """A vector function of skyfield.  Made by `from_skyfield`."""

    function: Any  # a VectorFunction, or an object of the user with the same methods
    center: str
    name: str
    source: str

    def _state(self, instant, hi, lo):
        from skyfield.constants import AU_M
        from skyfield.errors import EphemerisRangeError

        jd1, jd2 = np.broadcast_arrays(*julian(instant, hi, lo))
        time = timescale().tt_jd(jd1, jd2 - _time_scales.tdb_minus_tt(jd1, jd2) / DAY_S)
        # skyfield's own TDB, a short series, which kernels use, is off by up to 10 microseconds.
        time.tdb_fraction = (jd1 - time.whole) + jd2
        try:
            answer = self.function.at(time)
        except EphemerisRangeError as err:
            raise AttitudeError(
                f"skyfield does not cover every epoch of {self.name}: {err}; leave out the epochs "
                "outside."
            ) from err
        position, velocity = answer.position.au * AU_M, answer.velocity.au_per_d * (AU_M / DAY_S)
        # For a decayed satellite skyfield returns a message, and sometimes a finite position
        # inside the Earth.
        messages = [message for message in np.ravel(getattr(answer, "message", None)) if message]
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


def place_of(value: Any, name: str = "place") -> Place | None:
    """The Place of an object of astropy or skyfield; None for any other object.

    ==============================  ================================================================
    astropy EarthLocation           a ground `Site`, with the bits of its geocentric coordinates
    astropy SkyCoord                a direction; with a distance, a point at rest about the
                                    barycentre of the solar system
    skyfield wgs84.latlon(...)      a ground `Site`; ``earth + wgs84.latlon(...)`` too
    other vector functions          `from_skyfield`
    ==============================  ================================================================
    """
    kinds = [f"{kind.__module__}.{kind.__qualname__}" for kind in type(value).__mro__]
    if "astropy.coordinates.earth.EarthLocation" in kinds:
        return _of_location(value, name)
    if any(kind.startswith("astropy.coordinates.") for kind in kinds):
        return _of_coordinates(value, name)
    if any(kind.startswith("skyfield.") for kind in kinds):
        return _of_skyfield(value)
    return None


def _of_location(value: Any, name: str) -> Site:
    if value.shape != ():
        raise AttitudeError(f"{name} holds {value.size} locations; give one of them.")
    itrs = np.array([getattr(value, axis).to_value("m") for axis in "xyz"])
    geodetic = value.to_geodetic("WGS84")
    longitude, latitude = (getattr(geodetic, axis).to_value("rad") for axis in ("lon", "lat"))
    label = str(getattr(value.info, "name", None) or "site")
    return site_at(itrs, longitude, latitude, label, "astropy EarthLocation, IERS Earth rotation")


def _of_coordinates(value: Any, name: str) -> Place:
    from astropy.coordinates import SkyCoord, UnitSphericalRepresentation

    try:
        coordinates = SkyCoord(value)
        icrs = coordinates.icrs
    except Exception as err:  # astropy raises many kinds for frames without a time or a place
        raise AttitudeError(
            f"{name} is {shown(value)}, whose direction in ICRS does not follow ({err}); give a "
            "SkyCoord with obstime and location, or right ascension and declination."
        ) from None
    if icrs.shape != ():
        raise AttitudeError(f"{name} holds {icrs.size} coordinates; give one of them.")
    vector = icrs.cartesian.xyz
    if isinstance(icrs.data, UnitSphericalRepresentation) or not vector.unit.is_equivalent("m"):
        return direction(vector.value)
    return fixed(vector.to_value("m"), name="point of a SkyCoord")


def _of_skyfield(value: Any) -> Place:
    # The last part of a sum such as earth + wgs84.latlon(...).
    parts = getattr(value, "vector_functions", (value,))
    last = parts[-1]
    is_site = type(last).__module__ == "skyfield.toposlib"
    if is_site and getattr(last, "longitude", None) is not None:
        label = str(getattr(last, "target_name", None) or "site")
        return site_at(
            np.array(last.itrs_xyz.m),
            last.longitude.radians,
            last.latitude.radians,
            label,
            "skyfield geographic position, IERS Earth rotation",
        )
    return from_skyfield(value)
