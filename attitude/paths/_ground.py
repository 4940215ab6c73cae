"""Places on the ground: by longitude and latitude, or by the code of an observatory."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np

from attitude._support import pairs, validation
from attitude._support.constants import DAY_S, EARTH_FLATTENING, EARTH_RADIUS_M
from attitude._support.synonyms import arguments
from attitude._textfiles.lines import packaged
from attitude.epochs import _time_scales
from attitude.epochs._instants import Instant
from attitude.errors import AttitudeError
from attitude.frames._earth import pole_of_date, timescale, to_gcrs
from attitude.paths._path import FrozenArrays, Path, fixed, spelled

if TYPE_CHECKING:
    from attitude._support.annotations import FloatArray, Real


# ---- The rotation of the Earth: from ITRS, in which a ground site rests, to GCRS
# IAU 2006/2000A precession and nutation, the Earth rotation angle of UT1, and polar motion, as in
# astropy and ERFA.  UT1 and the pole come from the table of the package astropy-iers-data,
# interpolated linearly from day to day as astropy does; the table is read from the installed file,
# never from the network.
#
# The table ends with predictions about a year after its release.  Beyond it, and before 1973, only
# a model of delta T exists (skyfield's, after Morrison, Stephenson, Hohenkerk & Zawilski 2020),
# without polar motion, which long_term=True enables.
#
# Source: IERS Conventions (2010), chapter 5.

# rad/s of UT1, IERS Conventions (2010) eq. 5.15: 2 pi 1.00273781191135448 / 86400.
RATE: float = 7.292115146706980e-5


def to_celestial(
    hi: FloatArray,
    lo: FloatArray,
    vector: FloatArray,
    *,
    long_term: bool = False,
    name: str = "the ground site",
    rates: bool = True,
) -> tuple[FloatArray, FloatArray | None]:
    """GCRS components (3, N) and their rates of a vector (3,) in ITRS, at hi, lo (N,)."""
    earth = _Earth(hi, lo, long_term, name)
    position, intermediate = earth(vector)
    if not rates:
        return position, None
    turning = RATE * np.stack([-intermediate[1], intermediate[0], np.zeros(hi.size)])
    return position, earth.to_gcrs(turning)


def axes_to_celestial(hi: FloatArray, lo: FloatArray) -> FloatArray:
    """GCRS components of the axes of ITRS, (axis, component, N), at hi, lo (N,) of any year."""
    earth = _Earth(hi, lo, True, "the Earth")
    return np.array([earth(axis)[0] for axis in np.eye(3)])


class _Earth:
    """The Earth's orientation at epochs hi, lo (N,): pole of date, rotation, polar motion, rad."""

    def __init__(self, hi: FloatArray, lo: FloatArray, long_term: bool, name: str) -> None:
        tt = pairs.add((hi, lo), -_time_scales.difference_at(hi, lo))
        tai = pairs.add(tt, -_time_scales.TT_MINUS_TAI)
        ut1_minus_tai, *pole = _orientation(tai, tt, long_term, name)
        x, y, s = pole_of_date(hi, lo)
        self._of_date = x, y, rotation_angle(*pairs.add(tai, ut1_minus_tai)) - s
        # Polar motion with the locator s': IERS Conventions (2010), eq. 5.3 and 5.13.
        centuries = tt[0] / (36525.0 * DAY_S)
        self._polar_motion = *pole, -47e-6 * _time_scales.ARCSEC * centuries

    def __call__(self, vector: FloatArray) -> tuple[FloatArray, FloatArray]:
        """A vector (3,) of ITRS over GCRS (3, N), and over the terrestrial intermediate frame."""
        fixed = _without_polar_motion(vector, *self._polar_motion)
        return self.to_gcrs(fixed), fixed

    def to_gcrs(self, intermediate: FloatArray) -> FloatArray:
        """Vectors (3, N) of the terrestrial intermediate frame over GCRS."""
        return to_gcrs(*self._of_date, intermediate)


def rotation_angle(hi: FloatArray, lo: FloatArray) -> FloatArray:
    """The Earth rotation angle, rad, at UT1 seconds past J2000, to 1e-15 turns (ERFA's era00)."""
    whole = np.rint(hi / DAY_S)
    fraction = ((hi - whole * DAY_S) + lo) / DAY_S
    turns = 0.7790572732640 + fraction + 0.00273781191135448 * (whole + fraction)
    return 2.0 * np.pi * (turns - np.floor(turns))


def _without_polar_motion(vector, x_pole, y_pole, locator):
    """R3(-s') R2(xp) R1(yp) of a vector: ITRS to the terrestrial intermediate frame."""
    cosine, sine = np.cos(y_pole), np.sin(y_pole)
    a = np.broadcast_to(vector[0], x_pole.shape)
    b = cosine * vector[1] + sine * vector[2]
    c = cosine * vector[2] - sine * vector[1]
    cosine, sine = np.cos(x_pole), np.sin(x_pole)
    a, c = cosine * a - sine * c, sine * a + cosine * c
    cosine, sine = np.cos(locator), np.sin(locator)
    return np.stack([cosine * a - sine * b, sine * a + cosine * b, c])


def table_span() -> tuple[Instant, Instant]:
    """The first and last epoch of the installed IERS table."""
    tai = _time_scales.earth_rotation()[0][[0, -1]]
    hi, lo = (np.asarray(ends) for ends in _time_scales.tdb_from("tai", tai, np.zeros(2)))
    first, last = (Instant(*pair) for pair in zip(hi.tolist(), lo.tolist(), strict=True))
    return first, last


def _orientation(tai, tt, long_term, name):
    """UT1 - TAI in s, and the coordinates of the pole in rad."""
    values_there, outside = _time_scales.orientation_at(tai[0])
    if not outside.any():
        return values_there
    if not long_term:
        first, last = (spelled(end) for end in table_span())
        bad = Instant(float(tt[0][np.argmax(outside)]))
        raise AttitudeError(
            f"an epoch for {name} is {spelled(bad)}, but the Earth's rotation is tabulated from "
            f"{first} to {last} only (astropy-iers-data); leave that epoch out, update "
            "astropy-iers-data, or give long_term=True for a model that errs by some hundred "
            "metres within years."
        )
    time = timescale().tt_jd(*_time_scales.jd_from_seconds(tt[0][outside], tt[1][outside]))
    values_there[0][outside] = _time_scales.TT_MINUS_TAI - time.delta_t
    for pole in values_there[1:]:
        pole[outside] = 0.0
    return values_there


@dataclass(frozen=True, eq=False, repr=False)
class Site(FrozenArrays, Path):
    """A place at rest on the rotating Earth: itrs (3,), m, with a zenith `up` (3,), ITRS axes.

    Made by `site` and `observatory`; `long_term`: whether a model follows beyond the IERS table.
    """

    itrs: FloatArray
    up: FloatArray
    name: str
    source: str
    long_term: bool = False

    center = "earth"
    has_horizon = True

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
        x, y = self.up[:2] / math.hypot(*self.up[:2])  # at a pole of the site's longitude
        return replace(self, itrs=np.cross(self.up, (-y, x, 0.0)))

    def _state(self, instant, hi, lo, rates=True):
        at = pairs.add((hi, np.broadcast_to(lo, hi.shape)), instant.seconds, instant.low)
        settings = {"long_term": self.long_term, "name": self.name, "rates": rates}
        return to_celestial(*at, self.itrs, **settings)

    def _position(self, instant, hi, lo):
        return self._state(instant, hi, lo, rates=False)[0]


_HINTS = {
    **dict.fromkeys(("lat", "phi"), "give latitude="),
    **dict.fromkeys(("lon", "long", "lam"), "give longitude="),
    **dict.fromkeys(("alt", "altitude", "elevation", "h"), "give height=, m"),
}


@arguments(_HINTS, 'site("-70.7 deg", "-30.2 deg", 2700)')
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
    latitude = validation.angle_from_plane(latitude, "latitude", "48.1 deg")
    height = validation.number(height, "height", unit="m")
    up = _normal(longitude, latitude)
    long_term = validation.flag(long_term, "long_term")
    squeeze = (1.0 - EARTH_FLATTENING) ** 2
    radius = EARTH_RADIUS_M / math.sqrt(up[0] ** 2 + up[1] ** 2 + squeeze * up[2] ** 2)
    itrs = np.array([radius + height, radius + height, squeeze * radius + height]) * up
    return Site(itrs, up, name, "WGS84 coordinates, IERS Earth rotation", long_term)


def site_at(itrs: FloatArray, longitude: float, latitude: float, name: str, source: str) -> Site:
    """The place at (3,) m in ITRS, whose zenith has a geodetic longitude and latitude, rad."""
    return Site(np.array(itrs, dtype=np.float64), _normal(longitude, latitude), name, source)


def _normal(longitude: float, latitude: float) -> FloatArray:
    """The normal (3,) of the ellipsoid, ITRS axes."""
    x, y = math.cos(longitude), math.sin(longitude)
    return np.array([math.cos(latitude) * x, math.cos(latitude) * y, math.sin(latitude)])


def observatory(code: str, *, long_term: bool = False) -> Path:
    """The path of an observatory by its three-character code of the Minor Planet Center.

    Parameters
    ----------
    code : str
        Such as "568" (Mauna Kea) or "X05"; or a name of the list, or words of it that one
        observatory alone has.  "500" is the center of the Earth, which has no horizon.
    long_term : bool
        See `site`.

    Raises
    ------
    AttitudeError
        For a code or name that is not listed, words that several names have, and a spacecraft.

    Notes
    -----
    The list of the Minor Planet Center is in the package, with its date
    (attitude/data/observatories.txt).  Its parallax constants have a resolution of 6 to 60 m.
    """
    if not isinstance(code, str) or not code.strip():
        raise AttitudeError(
            f"the observatory code is {validation.shown(code)}; give three characters such as "
            '"568".'
        )
    long_term = validation.flag(long_term, "long_term")
    text = code.strip()
    known = _site_of(text.upper()) if text.upper() in _observatories() else named(text)
    if known is None:
        date = re.search(r"\d{4}-\d{2}-\d{2}", packaged(_LIST).partition("\n")[0])
        raise AttitudeError(
            f"the observatory code is {code!r}, which the Minor Planet Center does not list (in "
            f"its list of {date.group() if date else 'an unknown date'}); give three characters "
            'such as "568", or longitude and latitude by site.'
        )
    return replace(known, long_term=bool(long_term)) if isinstance(known, Site) else known


def named(text: str) -> Path | None:
    """The observatory with a name, or words that no other has; AttitudeError for several."""
    words = re.findall(r"\w+", text.lower())
    if not words:
        return None
    listed = _observatories()
    names = {code: re.findall(r"\w+", name.lower()) for code, (name, _) in listed.items()}
    codes = [code for code, known in names.items() if known == words]
    codes = codes or [code for code, known in names.items() if set(words) <= set(known)]
    if len(codes) > 1:
        some = "; ".join(f"{code} {listed[code][0]}" for code in codes[:6])
        more = "; ..." if len(codes) > 6 else ""
        raise AttitudeError(
            f"{validation.shown(text)} is in the names of {len(codes)} observatories "
            f"({some}{more}); give the code of one."
        )
    return _site_of(codes[0]) if codes else None


def _site_of(code: str) -> Path:
    """The place of a row of the list."""
    name, numbers = _observatories()[code]
    label = f"{code} {name}"
    if numbers is None:
        raise AttitudeError(
            f"{label} does not rest on the ground; give its path by tle, oem or spk."
        )
    longitude, rho_cos, rho_sin = numbers
    if not rho_cos and not rho_sin:
        return fixed((0.0, 0.0, 0.0), center="earth", name=label)
    angle = math.radians(longitude)
    direction = np.array([math.cos(angle), math.sin(angle), 0.0])
    itrs = EARTH_RADIUS_M * (rho_cos * direction + np.array([0.0, 0.0, rho_sin]))
    # The normal of the ellipsoid at the place; its height is small compared with the radius.
    up = rho_cos * direction + np.array([0.0, 0.0, rho_sin / (1.0 - EARTH_FLATTENING) ** 2])
    return Site(itrs, up / math.sqrt(up @ up), label, "MPC observatory list, IERS Earth rotation")


_LIST = "data/observatories.txt"


@lru_cache(maxsize=1)
def _observatories() -> dict[str, tuple[str, tuple[float, float, float] | None]]:
    """By code: name; longitude in degrees, rho cos phi' and rho sin phi', None in space."""
    by_code = {}
    for line in packaged(_LIST).splitlines()[1:]:
        code, longitude, cosine, sine, name = line.split(" ", 4)
        numbers = None if sine == "-" else (float(longitude), float(cosine), float(sine))
        by_code[code] = name, numbers
    return by_code
