"""What meshes cost: checks, convexity, and the table of shadows, with the number of facets.

    python benchmarks/meshes.py

One thread.  The concave bodies have a waist and twelve craters; others are a rough random body, one
with a large crater, and a divided box with a wing.  Convex ones are ellipsoids.  Times are the
least of three in CPU seconds, first those of a mesh that nothing is known of.
"""

import os

for name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ[name] = "1"

import sys
import time
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

from attitude._compilation.choice import compiling
from attitude.light_curve import Visibility, brightness
from attitude.light_curve._sums import clusters_of
from attitude.shape import Ellipsoid, Mesh, box_wing
from attitude.shape._ellipsoid import unit_sphere
from benchmarks.doc_tables import Table, markdown
from benchmarks.light_curve import directions, peanut, row

MAKES = ("meshes",)


def tables(quick):
    """The table of docs/light_curves.md, whose largest meshes take minutes."""
    if quick:
        return
    Visibility.of(peanut(2), resolution=8, keep=False)  # compiles
    rows, costs = [], {}
    for made in (concave(), convex()):
        for name, checks, grouped, shadows, cells in made:
            table = f"{shadows:.2g} s ({cells} cells)" if shadows else "none"
            rows.append((name, f"{checks:.2g} s", f"{grouped:.2g} s", table))
            costs |= {f"{name}, checks": checks * 1e6, f"{name}, clusters": grouped * 1e6}
            costs |= {f"{name}, shadows": shadows * 1e6} if shadows else {}
    head = (
        *("facets", "checks of `Mesh` and `is_convex`"),
        *("clusters, at the first brightness", "table of shadows"),
    )
    yield Table("meshes", markdown(head, rows), costs=costs)


def took(call, rounds=3):
    """Least CPU time of a call, and its last result."""
    least, result = np.inf, None
    for _ in range(rounds):
        begin = time.process_time()
        result = call()
        least = min(least, time.process_time() - begin)
    return least, result


def convex():
    for count in (20_000, 82_000, 1_000_000):
        made = Ellipsoid((3, 2, 1)).facets(count)
        seconds, _ = took(lambda m=made: Mesh(m.vertices, m.facets))
        row(f"{len(made)} facets, convex: checks of Mesh", f"{seconds:.2f} s")
        seconds, answer = took(lambda m=made: Mesh(m.vertices, m.facets).is_convex)
        row("  checks and is_convex", f"{seconds:.2f} s", "<= 2 for 1e6")
        assert answer
        checks = seconds
        seconds, _ = took(lambda m=made: clusters_of(Mesh(m.vertices, m.facets)), 1)
        row("  clusters, at the first brightness", f"{seconds:.2f} s")
        yield f"{len(made):,}, convex", checks, seconds, None, 0


def rough(frequency):
    """A body whose logarithm of the radius is a sum of random waves: 20 f^2 facets."""
    rng = np.random.default_rng(3)
    vertices, facets = unit_sphere(frequency)
    waves = np.zeros(len(vertices))
    for _ in range(120):
        along = rng.normal(size=3)
        count = rng.integers(2, 9)
        phases = 1.7 * count * (vertices @ along) / np.linalg.norm(along)
        waves += rng.normal() * np.cos(phases + rng.uniform(0.0, 2.0 * np.pi)) / count
    return Mesh(vertices * np.exp(0.35 * waves / np.std(waves))[:, None], facets)


def crater(frequency):
    """A ball with one deep crater: 20 f^2 facets."""
    vertices, facets = unit_sphere(frequency)
    from_axis = np.arccos(np.clip(vertices[:, 2], -1.0, 1.0))
    return Mesh(vertices * (1.0 - 0.55 * np.exp(-((from_axis / 0.5) ** 4)))[:, None], facets)


def concave():
    wing = box_wing((2, 3, 4), (5, 2), gap=0.5)
    made = [("concave", peanut(frequency)) for frequency in (10, 16, 32, 64)]
    made += [("rough", rough(frequency)) for frequency in (16, 32)]
    made += [("a crater", crater(32)), ("box with wing", wing.divided(5))]
    for name, mesh in made:
        seconds, answer = took(lambda m=mesh: Mesh(m.vertices, m.facets).is_convex)
        assert not answer
        row(f"{len(mesh)} facets, {name}: checks and is_convex", f"{seconds:.3f} s")
        checks = seconds
        seconds, _ = took(lambda m=mesh: clusters_of(Mesh(m.vertices, m.facets)), 1)
        row("  clusters", f"{seconds:.2f} s")
        grouped = seconds
        rounds = 3 if len(mesh) < 50_000 else 1
        seconds, table = took(lambda m=mesh: Visibility.of(m, keep=False), rounds)
        required = "<= 5" if 20_000 <= len(mesh) <= 23_000 else ""
        row(f"  table of {table.resolution} cells", f"{seconds:.2f} s", required)
        yield f"{len(mesh):,}, {name}", checks, grouped, seconds, table.resolution
        sun, observer = directions(2000, 90.0)
        seconds, _ = took(
            lambda m=mesh, t=table, s=sun, o=observer: brightness(m, "lambert", s, o, shadows=t)
        )
        row("  brightness", f"{len(mesh) * 2000 / seconds / 1e9:.2f} G facet-epochs/s")


def main():
    print(f"numpy {np.__version__}, {os.cpu_count()} cores, load {os.getloadavg()[0]:.1f}")
    print(f"{'quantity':58s} {'measured':34s} required")
    Visibility.of(peanut(2), resolution=8, keep=False)  # compiles
    list(convex())
    list(concave())


if __name__ == "__main__":
    with compiling():
        sys.exit(main())
