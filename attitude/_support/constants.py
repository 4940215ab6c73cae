"""Constants that more than one module uses, each once: SI units named by the suffix; colours.

Sources: the speed of light, SI; the astronomical unit, IAU 2012 resolution B2; the Sun's nominal
radius, IAU 2015 resolution B3; the Earth's ellipsoid, WGS 84; the sidereal day, one turn of the
Earth from equinox to equinox, Explanatory Supplement to the Astronomical Almanac; colours
that readers who confuse red and green can tell apart, Okabe and Ito 2008.
"""

from __future__ import annotations

import math
from typing import Final

SPEED_OF_LIGHT_M_S: Final = 299792458.0
ASTRONOMICAL_UNIT_M: Final = 149597870700.0
SUN_RADIUS_M: Final = 6.957e8
EARTH_RADIUS_M: Final = 6378137.0
EARTH_FLATTENING: Final = 1.0 / 298.257223563
DAY_S: Final = 86400.0
SIDEREAL_DAY_S: Final = 86164.0905
# Julian date at which modified Julian dates begin.
JD_OF_MJD_0: Final = 2400000.5
# Modified Julian date of 2000 January 1, 12 h.
MJD_OF_J2000: Final = 51544.5
# Magnitudes of a factor e, and of a small relative change over that change.
MAGNITUDES_PER_E: Final = 2.5 / math.log(10.0)
# Width of the opposition surge, rad, where light curves fit its height alone.
OPPOSITION_SURGE_RAD: Final = math.radians(5.0)
BLUE: Final = "#0072b2"
VERMILION: Final = "#d55e00"
GREEN: Final = "#009e73"
PURPLE: Final = "#cc79a7"
COLORS: Final = BLUE, VERMILION, GREEN
# Least gap between the observations of two nights.
GAP_OF_NIGHTS_S: Final = 0.3 * DAY_S
