"""Places of astropy and skyfield: EarthLocation, SkyCoord, wgs84 positions, vector functions."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from attitude.errors import AttitudeError
from attitude.paths.ground import Site, site_at
from attitude.paths.skyfield_path import from_skyfield
from attitude.paths.uniform import direction, fixed
from attitude.validation import shown

if TYPE_CHECKING:
    from attitude.paths.place import Place


def place_of(given: Any, name: str = "place") -> Place | None:
    """The Place of an object of astropy or skyfield; None for any other object.

    ==============================  ================================================================
    astropy EarthLocation           a ground `Site`, with the bits of its geocentric coordinates
    astropy SkyCoord                a direction; with a distance, a point at rest about the
                                    barycentre of the solar system
    skyfield wgs84.latlon(...)      a ground `Site`; ``earth + wgs84.latlon(...)`` too
    other vector functions          `from_skyfield`
    ==============================  ================================================================

    Raises
    ------
    AttitudeError
        For several places in one object, and for coordinates that do not convert to ICRS.
    """
    kinds = [f"{each.__module__}.{each.__qualname__}" for each in type(given).__mro__]
    if "astropy.coordinates.earth.EarthLocation" in kinds:
        return _of_location(given, name)
    if any(each.startswith("astropy.coordinates.") for each in kinds):
        return _of_coordinates(given, name)
    if any(each.startswith("skyfield.") for each in kinds):
        return _of_skyfield(given)
    return None


def _of_location(given: Any, name: str) -> Site:
    if given.shape != ():
        raise AttitudeError(f"{name} holds {given.size} locations; give one of them.")
    itrs = np.array([getattr(given, each).to_value("m") for each in "xyz"])
    geodetic = given.to_geodetic("WGS84")
    longitude, latitude = (getattr(geodetic, each).to_value("rad") for each in ("lon", "lat"))
    label = str(getattr(given.info, "name", None) or "site")
    return site_at(itrs, longitude, latitude, label, "astropy EarthLocation, IERS Earth rotation")


def _of_coordinates(given: Any, name: str) -> Place:
    from astropy.coordinates import SkyCoord, UnitSphericalRepresentation

    try:
        coordinates = SkyCoord(given)
        icrs = coordinates.icrs
    except Exception as err:  # astropy raises many kinds for frames without a time or a place
        raise AttitudeError(
            f"{name} is {shown(given)}, whose direction in ICRS does not follow ({err}); give a "
            "SkyCoord with obstime and location, or right ascension and declination."
        ) from None
    if icrs.shape != ():
        raise AttitudeError(f"{name} holds {icrs.size} coordinates; give one of them.")
    vector = icrs.cartesian.xyz
    if issubclass(type(icrs.data), UnitSphericalRepresentation) or not vector.unit.is_equivalent(
        "m"
    ):
        return direction(vector.value)
    return fixed(vector.to_value("m"), name="point of a SkyCoord")


def _of_skyfield(given: Any) -> Place:
    # The last part of a sum such as earth + wgs84.latlon(...).
    parts = getattr(given, "vector_functions", (given,))
    last = parts[-1]
    if (
        type(last).__module__ == "skyfield.toposlib"
        and getattr(last, "longitude", None) is not None
    ):
        label = str(getattr(last, "target_name", None) or "site")
        return site_at(
            np.array(last.itrs_xyz.m),
            last.longitude.radians,
            last.latitude.radians,
            label,
            "skyfield geographic position, IERS Earth rotation",
        )
    return from_skyfield(given)
