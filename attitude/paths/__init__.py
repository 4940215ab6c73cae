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
place                       any of these, from what a user types
==========================  =======================================================================

_path has the base classes, names of bodies and the simplest paths; _composed sums of paths;
_compressed polynomials; _foreign places of astropy and skyfield; _solar_system the choice of the
ephemeris; _spk, _satellite, _tabulated, _oem_file, _two_body, _mpc_line and _ground one kind
each; _places what users type.

Importing this package imports neither astropy, skyfield nor numba; functions import them when they
are called.  Nothing is ever downloaded.
"""

from typing import TYPE_CHECKING

from attitude._support.synonyms import of_module
from attitude.paths._composed import body, relative
from attitude.paths._compressed import Compressed, compress
from attitude.paths._foreign import from_skyfield
from attitude.paths._ground import observatory, site
from attitude.paths._mpc_line import mpc_orbit
from attitude.paths._oem_file import oem
from attitude.paths._path import Direction, Ephemeris, Path, direction, fixed, uniform
from attitude.paths._places import place
from attitude.paths._satellite import omm, tle
from attitude.paths._solar_system import ephemeris, from_astropy, spk
from attitude.paths._tabulated import table
from attitude.paths._two_body import Kepler, kepler

__all__ = [
    "Compressed",
    "Direction",
    "Ephemeris",
    "Kepler",
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
    "place",
    "relative",
    "site",
    "spk",
    "table",
    "tle",
    "uniform",
]

if not TYPE_CHECKING:
    # Hidden from type checkers: a module with __getattr__ has every name, misspelt ones too.
    __getattr__ = of_module(__name__)
