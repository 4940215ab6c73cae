"""Constants that more than one module uses, each once, in SI units named by the suffix.

Sources: the speed of light, SI; the astronomical unit, IAU 2012 resolution B2; the Sun's nominal
radius, IAU 2015 resolution B3; the Earth's ellipsoid, WGS 84.
"""

from __future__ import annotations

from typing import Final

SPEED_OF_LIGHT_M_S: Final = 299792458.0
ASTRONOMICAL_UNIT_M: Final = 149597870700.0
SUN_RADIUS_M: Final = 6.957e8
EARTH_RADIUS_M: Final = 6378137.0
EARTH_FLATTENING: Final = 1.0 / 298.257223563
# Least gap between the observations of two nights.
GAP_OF_NIGHTS_S: Final = 0.3 * 86400.0
