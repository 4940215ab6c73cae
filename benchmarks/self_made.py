"""How much faster are parts of the package than libraries with the same function?

    python benchmarks/self_made.py

It prints, for each part that a maintained library could replace, the time of both for the same work
in one run, their ratio, and the largest difference of the answers.  `docs/benchmarks.md` keeps
the table with the reasons.
"""

import sys
import time
import warnings
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))

from attitude import epochs, paths, shape
from attitude._solver import chebyshev
from attitude.epochs import _ccsds as ccsds_epochs
from attitude.epochs import _time_scales
from attitude.frames import quaternion
from attitude.motions._table import AttitudeTable

COUNT = 100_000
START = epochs.instant("2026-01-01")


def best(function, repeats=5):
    """The least of several times, s, and the answer."""
    times = []
    for _ in range(repeats):
        begin = time.perf_counter()
        answer = function()
        times.append(time.perf_counter() - begin)
    return min(times), answer


def row(label, ours, theirs, name, apart, *, count=COUNT):
    """Print one line; `apart` is a function of both answers."""
    mine, answer = best(ours)
    other, reference = best(theirs, 2)
    print(
        f"{label:36s} {mine / count * 1e9:10.0f} {other / count * 1e9:10.0f} {other / mine:8.1f}"
        f"   {name:34s} {apart(answer, reference)}"
    )


def time_scale():
    from astropy.time import Time

    days = Time(2461041.5, np.linspace(0.0, 365.0, COUNT), format="jd", scale="utc")

    def theirs():
        fresh = Time(days.jd1, days.jd2, format="jd", scale="utc")
        return fresh.tdb

    def apart(ours, reference):
        hi, lo = _time_scales.seconds_from_jd(reference.jd1, reference.jd2)
        off = (ours[0] - (hi - START.seconds)) + (ours[1] - (lo - START.low))
        return f"{np.max(np.abs(off)):.1e} s"

    row("UTC to TDB", lambda: epochs.seconds_since(START, days), theirs, "astropy Time.tdb", apart)


def dates():
    from astropy.time import Time

    seconds = np.arange(COUNT) * 0.1
    texts = epochs.times(START, seconds).utc.isot.tolist()
    raw = [text.encode() for text in texts]

    def apart(ours, reference):
        hi, lo = _time_scales.seconds_from_jd(reference.jd1, reference.jd2)
        return f"{np.max(np.abs((ours[0] - hi) + (ours[1] - lo))):.1e} s"

    row(
        "dates of a CCSDS file",
        lambda: ccsds_epochs.parsed(raw, "utc"),
        lambda: Time(texts, format="isot", scale="utc").tdb,
        "astropy Time(texts).tdb",
        apart,
    )


def rotations():
    from scipy.spatial.transform import Rotation

    rng = np.random.default_rng(1)
    wxyz, v = rng.normal(size=(COUNT, 4)), rng.normal(size=(COUNT, 3))
    wxyz /= np.linalg.norm(wxyz, axis=1)[:, None]
    xyzw = np.roll(wxyz, -1, axis=1)
    row(
        "vectors turned, with unit quaternions",
        lambda: quaternion.rotate(wxyz, v),
        lambda: Rotation.from_quat(xyzw).apply(v),
        "scipy Rotation.apply",
        lambda a, b: f"{np.max(np.abs(a - b)):.1e}",
    )


def polynomials():
    rng = np.random.default_rng(2)
    table = rng.normal(size=(17, 40)) * 2.0 ** -np.arange(17.0)[:, None]
    piece, x = rng.integers(0, 40, COUNT), rng.uniform(-1, 1, COUNT)

    def theirs():
        out = np.empty(COUNT)
        for k in range(40):
            here = piece == k
            out[here] = np.polynomial.chebyshev.chebval(x[here], table[:, k])
        return out

    row(
        "Chebyshev polynomials in pieces",
        lambda: chebyshev.evaluate(table, piece, x),
        theirs,
        "numpy chebval, piece by piece",
        lambda a, b: f"{np.max(np.abs(a - b)):.1e}",
    )


def satellite():
    from skyfield.api import EarthSatellite, load

    lines = (ROOT / "data" / "paths" / "envisat-2013.tle").read_text()
    path = paths.tle(lines)
    start = epochs.instant("2013-10-23T06:00:00")
    seconds = np.linspace(0.0, 900.0, COUNT)
    scale = load.timescale(builtin=True)
    moment = epochs.times(start, seconds)
    days = moment.jd1 + moment.jd2
    theirs = EarthSatellite(*[x for x in lines.splitlines() if x[:2] in ("1 ", "2 ")], "", scale)
    row(
        "satellite, TEME to GCRS",
        lambda: path.position(start, seconds),
        lambda: theirs.at(scale.tdb_jd(days)).position.m.T,
        "skyfield EarthSatellite.at, Time",
        lambda a, b: f"{np.max(np.linalg.norm(a - b, axis=1)):.1e} m (epochs of 2e-5 s)",
    )


def site():
    from astropy import units
    from astropy.coordinates import EarthLocation
    from astropy.utils import iers

    path = paths.site(0.27, 0.82, height=500.0)
    seconds = np.linspace(0.0, 86400.0, COUNT)
    location = EarthLocation.from_geodetic(0.27 * units.rad, 0.82 * units.rad, 500.0 * units.m)
    time_ = epochs.times(START, seconds)
    with iers.earth_orientation_table.set(_time_scales.earth_orientation()):
        row(
            "ground site to GCRS",
            lambda: path.position(START, seconds),
            lambda: location.get_gcrs_posvel(time_)[0].xyz.to_value("m").T,
            "astropy get_gcrs_posvel",
            lambda a, b: f"{np.max(np.linalg.norm(a - b, axis=1)):.1e} m",
        )


def tables():
    from scipy.spatial.transform import Rotation, Slerp

    rng = np.random.default_rng(3)
    t = np.arange(1000.0)
    turns = Rotation.from_rotvec(np.cumsum(rng.normal(size=(1000, 3)) * 0.1, axis=0))
    wxyz = np.roll(turns.as_quat(), 1, axis=1)
    table = AttitudeTable(START, t, wxyz, method="slerp")
    slerp = Slerp(t, turns)
    asked = np.linspace(0.0, 999.0, COUNT)

    def apart(ours, reference):
        theirs = np.roll(reference.as_quat(), 1, axis=1)
        return f"{np.max(1.0 - np.abs(np.sum(ours.wxyz * theirs, axis=1))):.1e} (1 - |p.q|)"

    row("great circles", lambda: table.at(asked), lambda: slerp(asked), "scipy Slerp", apart)


def solids():
    try:
        import trimesh
    except ImportError:
        return
    mesh = shape.Ellipsoid((3.0, 2.0, 1.0)).facets(20_000)

    def theirs():
        fresh = trimesh.Trimesh(mesh.vertices, mesh.facets, process=False)
        return fresh.moment_inertia

    row(
        "inertia of a mesh, a facet",
        lambda: mesh.mass_properties(density=1.0).inertia,
        theirs,
        "trimesh moment_inertia",
        lambda a, b: f"{np.max(np.abs(a - b)) / np.max(b):.1e} of the largest",
        count=len(mesh.facets),
    )


def main():
    print(f"{'':36s} {'ns, ours':>10s} {'theirs':>10s} {'ratio':>8s}   library, largest difference")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        for part in (time_scale, dates, rotations, polynomials, satellite, site, tables, solids):
            part()


if __name__ == "__main__":
    main()
