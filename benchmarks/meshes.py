"""What meshes cost: checks, convexity, and the table of shadows, with the number of facets.

    python benchmarks/meshes.py

One thread.  The concave bodies have a waist and twelve craters; convex ones are ellipsoids.  Times
are the least of three in CPU seconds, first those of a mesh that nothing is known of.
"""

import os

for name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ[name] = "1"

import sys
import time

import numpy as np
from light_curve import directions, peanut, row

from attitude.light_curve import Visibility, brightness
from attitude.light_curve.clusters import clusters_of
from attitude.shape import Ellipsoid, Mesh


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
        seconds, _ = took(lambda m=made: clusters_of(Mesh(m.vertices, m.facets)), 1)
        row("  clusters, at the first brightness", f"{seconds:.2f} s")


def concave():
    for frequency in (10, 16, 32, 64):
        mesh = peanut(frequency)
        seconds, answer = took(lambda m=mesh: Mesh(m.vertices, m.facets).is_convex)
        assert not answer
        row(f"{len(mesh)} facets, concave: checks and is_convex", f"{seconds:.3f} s")
        seconds, _ = took(lambda m=mesh: clusters_of(Mesh(m.vertices, m.facets)), 1)
        row("  clusters", f"{seconds:.2f} s")
        rounds = 3 if len(mesh) < 50_000 else 1
        seconds, table = took(lambda m=mesh: Visibility.of(m, keep=False), rounds)
        required = "<= 5" if 20_000 <= len(mesh) <= 23_000 else ""
        row(f"  table of {table.resolution} cells", f"{seconds:.2f} s", required)
        sun, observer = directions(2000, 90.0)
        seconds, _ = took(
            lambda m=mesh, t=table, s=sun, o=observer: brightness(m, "lambert", s, o, shadows=t)
        )
        row("  brightness", f"{len(mesh) * 2000 / seconds / 1e9:.2f} G facet-epochs/s")


def main():
    print(f"numpy {np.__version__}, {os.cpu_count()} cores, load {os.getloadavg()[0]:.1f}")
    print(f"{'quantity':58s} {'measured':34s} required")
    Visibility.of(peanut(2), resolution=8, keep=False)  # compiles
    convex()
    concave()


if __name__ == "__main__":
    sys.exit(main())
