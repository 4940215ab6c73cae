"""Scenes that several tests look at."""

from attitude import epochs, paths
from attitude.scene import Scene
from tests.support.kernels import DATA, kernel


def envisat_over_graz(**options):
    site = paths.site("15.4933 deg", "47.0671 deg", 539.0, name="Graz")
    given = {"ephemeris": kernel("de421"), **options}
    scene = Scene(None, paths.tle(DATA / "envisat-2013.tle"), site, **given)
    return scene, site, epochs.instant("2013-10-23T09:28:30")
