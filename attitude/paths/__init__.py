"""Paths: positions of the centre of mass, the Sun and the observer at TDB epochs, ICRF axes.

A `Path` has ``position``, ``velocity`` and ``state`` at arrays of epochs, relative to its
``center``.  `relative` composes paths; `compress` makes any path fast by polynomials.

==========================  =======================================================================
body, ephemeris, spk        planets, Moon, Sun; asteroids and spacecraft from SPK files
from_skyfield               any vector function of skyfield
from_astropy                any body of astropy's ephemerides
kepler, mpc_orbit           two-body motion from elements, and from lines of the MPC
tle, omm                    Earth satellites by SGP4
table, oem                  interpolated positions, and CCSDS ephemeris files
uniform, fixed, direction   uniform motion, a point at rest, a place infinitely far away
site, observatory           places on the ground
==========================  =======================================================================

Importing this package imports neither astropy, skyfield nor numba; functions import them when they
are called.  Nothing is ever downloaded.
"""

from attitude.paths.astropy_body import from_astropy
from attitude.paths.composed import body, relative
from attitude.paths.compressed import Compressed, compress
from attitude.paths.ephemeris_source import Ephemeris
from attitude.paths.ground import observatory, site
from attitude.paths.mpc_line import mpc_orbit
from attitude.paths.oem_file import oem
from attitude.paths.path import Path
from attitude.paths.satellite import omm, tle
from attitude.paths.skyfield_path import from_skyfield
from attitude.paths.solar_system import ephemeris
from attitude.paths.spk import spk
from attitude.paths.tabulated import table
from attitude.paths.two_body import kepler
from attitude.paths.uniform import Direction, direction, fixed, uniform

__all__ = [
    "Compressed",
    "Direction",
    "Ephemeris",
    "Path",
    "body",
    "compress",
    "direction",
    "ephemeris",
    "fixed",
    "from_astropy",
    "from_skyfield",
    "kepler",
    "mpc_orbit",
    "observatory",
    "oem",
    "omm",
    "relative",
    "site",
    "spk",
    "table",
    "tle",
    "uniform",
]
