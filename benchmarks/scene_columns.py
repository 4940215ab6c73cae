"""What does each column of a view cost alone, and what does it evaluate?

    python benchmarks/scene_columns.py

For each column a new view is made, and the column is read: CPU nanoseconds per epoch, the least of
five, with all fits and without compilation; planet: 1e6 epochs of Mars over a year, seen from the
Earth; satellite: 1e5 over a pass of 15 minutes from a TLE, seen from a ground site.  The last
column of the table lists what was computed for it, as `view.evaluated` has it.
"""

import sys
import time
import warnings
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))

from attitude import Body, FreeRotation, Spin, epochs, paths
from attitude._compilation.choice import compiling
from attitude.errors import AttitudeError
from attitude.paths._solar_system import installed_kernel
from attitude.scene import Scene, View
from attitude.shape import Ellipsoid
from benchmarks.doc_tables import Table, markdown
from benchmarks.record import processor

MAKES = ("columns of a view",)
ROUNDS = 5


def planet():
    """A scene, and its epochs: an instant and seconds."""
    spin = Spin(epoch="2026-01-01", wxyz=(1, 0, 0, 0), angular_velocity=(1e-5, 2e-4, 1e-5))
    motion = FreeRotation(Body(moments=(10, 20, 26)), spin)
    source, shape = installed_kernel() or "builtin", Ellipsoid((3, 2, 1))
    scene = Scene(motion, "mars barycenter", ephemeris=source, shape=shape)
    return scene, motion.epoch, np.linspace(0.0, 3e7, 1_000_000)


def satellite():
    """A scene of a satellite that passes over a site, and its epochs as in `planet`."""
    start = epochs.instant("2013-10-23T09:28:30")
    spin = Spin(epoch=start, wxyz=(1, 0, 0, 0), angular_velocity=(1e-3, 1e-3, 0.05))
    motion = FreeRotation(Body(moments=(17000, 125000, 129000)), spin)
    site = paths.site("15.4933 deg", "47.0671 deg", 539.0, name="Graz")
    path = paths.tle(ROOT / "data" / "paths" / "envisat-2013.tle")
    scene = Scene(motion, path, observer=site, shape=Ellipsoid((13, 4, 3)))
    return scene, start, np.linspace(0.0, 900.0, 100_000)


def cost(scene, start, seconds, name):
    """CPU nanoseconds per epoch of one column, and what was evaluated for it; None for none."""
    taken = []
    for _ in range(ROUNDS + 1):  # the first one compiles
        begin = time.thread_time()
        view = scene.since(start, seconds)
        try:
            getattr(view, name)
        except AttitudeError:
            return None, ()
        taken.append(time.thread_time() - begin)
    return min(taken[1:]) / seconds.size * 1e9, view.evaluated


def tables(quick):
    """The table of docs/scene.md."""
    warnings.simplefilter("ignore")  # "dubious year", from astropy
    scenes = {"planet": planet(), "satellite": satellite()}
    rows, costs = [], {}
    for name in View.columns():
        if name.endswith("_sigma"):
            continue
        found = {key: cost(*scene, name) for key, scene in scenes.items()}
        costs |= {f"{name}, {key}": each[0] for key, each in found.items() if each[0]}
        texts = ["-" if each[0] is None else f"{each[0]:.0f}" for each in found.values()]
        names = (f"`{each}`" for each in found["satellite"][1] if each != name)
        rows.append((f"`{name}`", *texts, ", ".join(names)))
    head = "column", "planet", "satellite", "evaluates, besides"
    text = f"CPU ns an epoch, each column alone ({processor()}):\n\n"
    yield Table("columns of a view", text + markdown(head, rows, right=(1, 2)), costs=costs)


if __name__ == "__main__":
    with compiling():
        for each in tables(False):
            print(each.text)
