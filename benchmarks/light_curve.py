"""How fast and how accurate is the brightness of a body, and how much memory does it take?

It prints the measured value of each claim about light curves: facet-epochs a second compared with
numpy in the same run, at the best block size for numpy; errors against closed forms, 60 digits and
cast rays; peak memory of 1e7 epochs of 1000 facets.  One thread unless a row names more.
Directions are random, so that successive epochs share no work.

    python benchmarks/light_curve.py
"""

import os

# One thread for numpy too; numpy reads these variables when it is imported.
for name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ[name] = "1"

import hashlib
import resource
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from pathlib import Path

import mpmath as mp
import numba
import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

from attitude._compilation.choice import compiling
from attitude.light_curve import Visibility, brightness, stream
from attitude.scattering import Hapke, LommelSeeliger, LommelSeeligerLambert, Material, Materials
from attitude.shape import Ellipsoid, Mesh, box_wing
from attitude.shape._ellipsoid import unit_sphere
from benchmarks.doc_tables import Table, markdown
from benchmarks.record import processor
from tests.support.raycast import brightness_by_rays

FACET_LAWS = (
    ("Hapke, rough", Hapke(), ">= 500 M"),
    ("Hapke, smooth", Hapke(roughness=0.0), ">= 1000 M"),
    ("Phong", Material(0.3, 0.4), ">= 1000 M"),
    ("Phong, exponent 33.3", Material(0.3, 0.4, exponent=33.3), ""),
    ("Cook-Torrance", Material(0.3, 0.4, "cook-torrance"), ">= 1000 M"),
)
EPOCHS = 100_000
ROUNDS = 7
MAKES = ("light curves", "shadows")


def tables(quick):
    """The tables of docs/light_curves.md; --quick leaves out memory and threads."""
    rows, costs = [], {}

    def kept(quantity, measured, required="", cost=None):
        found = quantity.strip()
        rows.append((found, measured))
        if cost is not None:
            costs[found] = cost

    row.also = kept
    try:
        for part in (convex, ellipsoid, satellite, *(() if quick else (threads, memory))):
            part()
        masks = shadows()
    finally:
        row.also = None
    text = f"{processor()}, one thread.\n\n" + markdown(("quantity", "measured"), rows)
    yield Table("light curves", text, costs=costs)
    head = "cells along an edge", "table", "computed in", "error, mmag rms", "facet-epochs/s"
    yield Table("shadows", markdown(head, masks))


def directions(count, highest=180.0, lowest=0.0, seed=1):
    """Sun and observer, (N, 3) views of component-major memory; phase angles in degrees."""
    rng = np.random.default_rng(seed)
    sun = rng.normal(size=(3, count))
    sun /= np.linalg.norm(sun, axis=0)
    side = rng.normal(size=(3, count))
    side -= np.sum(side * sun, axis=0) * sun
    side /= np.linalg.norm(side, axis=0)
    alpha = np.radians(rng.uniform(lowest, highest, count))
    return sun.T, (sun * np.cos(alpha) + side * np.sin(alpha)).T


def random_directions(count, seed=1):
    rng = np.random.default_rng(seed)
    pair = rng.normal(size=(2, 3, count))
    pair /= np.linalg.norm(pair, axis=1, keepdims=True)
    return pair[0].T, pair[1].T


def thousand_facets():
    """A convex mesh of 1000 facets with different normals: the hull of points on an ellipsoid."""
    from scipy.spatial import ConvexHull

    k = np.arange(502)
    z = 1.0 - (2 * k + 1) / 502
    angle = k * np.pi * (3.0 - np.sqrt(5.0))
    ring = np.sqrt(1.0 - z * z)
    points = np.stack([1.5 * ring * np.cos(angle), 1.2 * ring * np.sin(angle), z], axis=1)
    facets = ConvexHull(points).simplices
    a, b, c = (points[facets[:, i]] for i in range(3))
    inward = np.sum(np.cross(b - a, c - a) * a, axis=1) < 0.0
    facets[inward] = facets[inward, ::-1]
    return Mesh(points, facets)


def peanut(frequency):
    """A body with a waist and twelve craters: 20 f^2 facets, many shadows."""
    rng = np.random.default_rng(0)
    vertices, facets = unit_sphere(frequency)
    radius = np.sqrt(vertices[:, 0] ** 2 + 0.12)
    for center in rng.normal(size=(12, 3)):
        center /= np.linalg.norm(center)
        radius *= 1.0 - 0.12 * np.exp(-(1.0 - vertices @ center) / 0.03)
    return Mesh(vertices * radius[:, None], facets)


def numpy_plain(mesh, law, sun, observer, block):
    """The sum as one would write it."""
    a, b = law.weights
    out = np.empty(len(sun))
    for k in range(0, len(sun), block):
        mu0 = sun[k : k + block] @ mesh.normals.T
        mu = observer[k : k + block] @ mesh.normals.T
        with np.errstate(divide="ignore", invalid="ignore"):
            r = mu0 * mu * (a / (mu0 + mu) + b)
        out[k : k + block] = np.where((mu0 > 0) & (mu > 0), r, 0.0) @ mesh.areas
    return out * law.phase(np.arccos(np.sum(sun * observer, axis=1)))


def numpy_tuned(mesh, law, sun, observer, block):
    """The same without masks, and with as few passes over memory as numpy allows."""
    a, b = law.weights
    out = np.empty(len(sun))
    normals = np.ascontiguousarray(mesh.normals)
    for k in range(0, len(sun), block):
        mu0 = np.maximum(normals @ sun[k : k + block].T, 0.0)
        mu = np.maximum(normals @ observer[k : k + block].T, 0.0)
        product = mu0 * mu
        mu0 += mu
        mu0 += 1e-100
        np.divide(a, mu0, out=mu0)
        mu0 += b
        product *= mu0
        out[k : k + block] = mesh.areas @ product
    return out * law.phase(np.arccos(np.sum(sun * observer, axis=1)))


def least(functions, rounds=ROUNDS, clock=time.process_time):
    """Least time of each of several calls, run in turns so that load affects all of them alike.

    CPU seconds, which other programs lengthen less than those of a clock on the wall.
    """
    times = np.full(len(functions), np.inf)
    for function in functions:
        function()
    for _ in range(rounds):
        for k, function in enumerate(functions):
            begin = clock()
            function()
            times[k] = min(times[k], clock() - begin)
    return times


def row(quantity, measured, required="", cost=None):
    """Print a line; `cost` is ns of what is measured, for the record."""
    if row.also:
        row.also(quantity, measured, required, cost)
    print(f"{quantity:58s} {measured:34s} {required}", flush=True)


row.also = None


def rms(value, reference):
    error = 2500.0 * np.log10(value / reference)
    return np.sqrt(np.mean(error**2))


def convex():
    mesh, law = thousand_facets(), LommelSeeligerLambert()
    sun, observer = random_directions(EPOCHS)
    part = 5000  # fewer epochs for numpy, which is slow
    blocks = (5, 10, 20, 50, 100, 300, 1000)
    calls = [
        lambda: brightness(mesh, law, sun, observer),
        lambda: all_facets(mesh, law, sun, observer),
    ]
    names = []
    for function in (numpy_plain, numpy_tuned):
        for block in blocks:
            names.append((function.__name__, block))
            calls.append(lambda f=function, b=block: f(mesh, law, sun[:part], observer[:part], b))
    times = least(calls)
    ours = len(mesh) * EPOCHS / times[0] / 1e9
    rates = len(mesh) * part / times[2:] / 1e9
    row(
        "convex sum, Lommel-Seeliger + Lambert, 1000 x 1e5",
        f"{ours:.2f} G facet-epochs/s",
        ">= 2",
        1.0 / ours,
    )
    for name, required in (("numpy_plain", ">= 20"), ("numpy_tuned", "")):
        best = max(k for k in zip(rates, names, strict=True) if k[1][0] == name)
        row(
            f"  against {name}, best block {best[1][1]}: {best[0]:.3f} G",
            f"{ours / best[0]:.1f} x",
            required,
        )
    theirs = numpy_plain(mesh, law, sun[:part], observer[:part], 20)
    mine = brightness(mesh, law, sun[:part], observer[:part])
    shown = theirs > 1e-9
    row(
        "  largest difference from numpy",
        f"{np.max(np.abs(mine - theirs)[shown] / theirs[shown]):.1e}",
    )
    rate = len(mesh) * EPOCHS / times[1] / 1e9
    row("  the loop without skipping clusters", f"{rate:.2f} G facet-epochs/s")
    row("  facets that are summed", f"{summed_share(mesh, sun, observer):.0%}")
    part = 20_000
    for name, other, required in FACET_LAWS:
        took = least([lambda o=other: brightness(mesh, o, sun[:part], observer[:part])])[0]
        cost = took / part / len(mesh) * 1e9
        row(f"  {name}", f"{1e3 / cost:.0f} M facet-epochs/s", required, cost)


def threads():
    """Two threads against one, and hashing, which shares nothing, on the same machine.

    Calls of some 0.1 s: a virtual processor that was idle takes milliseconds to start.
    """
    mesh, law = thousand_facets(), LommelSeeligerLambert()
    data = memoryview(bytes(1 << 28))
    pool = ThreadPoolExecutor(2)
    ellipsoid = Ellipsoid((1.5, 1.2, 1.0))
    many = random_directions(4_000_000)
    some, few = ([each[:count] for each in many] for count in (1_000_000, EPOCHS))
    calls = {
        "convex sum": lambda n: brightness(mesh, law, *some, threads=n),
        "Hapke": lambda n: brightness(mesh, Hapke(), *few, threads=n),
        "ellipsoid": lambda n: brightness(ellipsoid, "lommel-seeliger", *many, threads=n),
        "SHA-256 by hashlib": lambda n: list(
            pool.map(lambda k: hashlib.sha256(data[: len(data) // n]).digest(), range(n))
        ),
    }
    for name, call in calls.items():
        both = [partial(call, 1), partial(call, 2)]
        one, two = least(both, rounds=3 * ROUNDS, clock=time.perf_counter)
        row(f"two threads against one: {name}", f"{one / two:.2f}", ">= 1.8 on idle cores")


def satellite():
    """A box with a wing: few facets, four materials, and shadows."""
    mesh = box_wing((10, 4, 4), (14, 5), gap=2.0, wings=1)
    table = Visibility.of(mesh, keep=False)
    sun, observer = random_directions(EPOCHS)
    orbit = directions_of_an_orbit(EPOCHS)
    for model in ("phong", "cook-torrance"):
        glossy = {
            "body": Material(0.25, 0.35, model, exponent=600),
            "panel front": Material(0.05, 0.25, model),
        }
        law = Materials({**glossy, "panel back": Material(0.3), "panel edge": Material(0.3)})
        times = least(
            [
                lambda m=law: brightness(mesh, m, sun, observer, shadows=table),
                lambda m=law: brightness(mesh, m, *orbit, shadows=table),
                lambda m=law: brightness(mesh, m, *orbit, shadows=False),
            ]
        )
        named = ("random directions", "successive epochs", "the same without shadows")
        for name, took in zip(named, times, strict=True):
            row(
                f"box with a wing, {len(mesh)} facets, {model}, {name}",
                f"{1e9 * took / EPOCHS:.0f} ns an epoch",
                "<= 150" if "shadows" not in name else "",
                1e9 * took / EPOCHS,
            )


def directions_of_an_orbit(count):
    """Directions that turn slowly, as those of a satellite sampled each second."""
    pair = np.empty((2, 3, count))
    turn(pair[0], 1e-3, 0)
    turn(pair[1], 1.1e-3, 2000)
    return pair[0].T, pair[1].T


def all_facets(mesh, law, sun, observer):
    """The loop with every cluster marked as visible, to measure the gain of skipping clusters."""
    from attitude.light_curve import _sums
    from attitude.light_curve._sums import clusters_of

    clusters = clusters_of(mesh)
    words = np.full((1, clusters.sky.shape[1]), ~np.uint64(0))
    words[0, -1] >>= np.uint64(-clusters.count % 64)
    every = np.broadcast_to(words, clusters.sky.shape).copy()
    out = np.empty(len(sun))
    _sums.fused(
        clusters.blocks,
        clusters.axes,
        every,
        clusters.cells,
        None,
        None,
        None,
        *sun.T,
        *observer.T,
        out,
    )
    return out * law.phase(np.zeros(1))


def summed_share(mesh, sun, observer):
    """Mean share of facets, with empty places, in clusters that are not skipped."""
    from attitude.light_curve._sums import SIZE, cell_scale, clusters_of

    clusters = clusters_of(mesh)
    words = ~np.uint64(0)
    for v in (sun, observer):
        i, j, k = (v.T * cell_scale(clusters.cells) + clusters.cells / 2).astype(int)
        words = words & clusters.sky[(i * clusters.cells + j) * clusters.cells + k]
    bits = np.unpackbits(np.ascontiguousarray(words).view(np.uint8))
    return np.sum(bits, dtype=int) * SIZE / len(words) / len(mesh)


def ellipsoid():
    shape = Ellipsoid((1.5, 1.2, 1.0))
    sun, observer = random_directions(1_000_000)
    (took,) = least(
        [
            lambda: brightness(shape, "lommel-seeliger", sun, observer),
        ]
    )
    row("ellipsoid in closed form", f"{1.0 / took:.0f} M epochs/s", ">= 30", 1e3 * took)
    worst = 0.0
    for axes in ((1, 1, 1), (1.5, 1.2, 1), (1, 2, 10)):
        for low, high in ((0, 1e-6), (0, 180), (170, 180), (179.9, 180), (180 - 1e-6, 180)):
            s, o = directions(200, high, low)
            ours = brightness(Ellipsoid(axes), LommelSeeliger(), s, o)
            worst = max(worst, *(digits(axes, *one) for one in zip(s, o, ours, strict=True)))
    row("  largest error of 3000, against 60 digits, also backlit", f"{worst:.1e}", "<= 1e-12")
    for label, frequency in (("980 facets", 7), ("1280 facets", 8)):
        for highest in (60, 90):
            s, o = directions(20_000, highest)
            faceted = shape.facets(20 * frequency**2)
            error = rms(
                brightness(faceted, "lommel-seeliger", s, o),
                brightness(shape, "lommel-seeliger", s, o),
            )
            row(f"  {label}, phase to {highest} deg", f"{error:.2f} mmag rms", "<= 0.5")


def digits(axes, sun, observer, value):
    """Relative error of a brightness of albedo 1 against 60 digits."""
    with mp.workdps(60):
        p = [mp.mpf(float(x)) / mp.mpf(a) for x, a in zip(sun, axes, strict=True)]
        q = [mp.mpf(float(x)) / mp.mpf(a) for x, a in zip(observer, axes, strict=True)]
        lp, lq = (mp.sqrt(sum(x * x for x in v)) for v in (p, q))
        both = mp.sqrt(sum((x + y) ** 2 for x, y in zip(p, q, strict=True)))
        cosine = sum(x * y for x, y in zip(p, q, strict=True)) / (lp * lq)
        x = both / (lp + lq)
        y = 2 * lp * lq * (1 - cosine) / (lp + lq) ** 2
        bracket = x - (y * mp.atanh(x) if x < 1 else 0)
        abc = mp.mpf(axes[0]) * axes[1] * axes[2]
        exact = abc * lp * lq / both * (1 + cosine) / 2 / x**2 * bracket / 4
        return float(abs(mp.mpf(float(value)) / exact - 1))


def shadows():
    mesh = peanut(10)
    sun, observer = directions(1500, 90.0)
    count = 20_000
    many = directions(count, 90.0, seed=3)
    Visibility.of(peanut(2), resolution=8, keep=False)  # compiles
    begin = time.perf_counter()
    exact = brightness_by_rays(mesh, "lommel-seeliger", sun, observer)
    took = time.perf_counter() - begin
    row("shadows of 2000 facets: rays (embree), 8 a facet", f"{2e3 * 1500 / took / 1e6:.1f} M")
    rays, masks = f"{2e3 * 1500 / took:.0e}", []
    begin = time.perf_counter()
    middle = brightness_by_rays(mesh, "lommel-seeliger", sun, observer, points=[[1 / 3] * 3])
    took = time.perf_counter() - begin
    row("  rays, one from each centroid", f"{2e3 * 1500 / took / 1e6:.1f} M facet-epochs/s")
    none = brightness(mesh, "lommel-seeliger", sun, observer, shadows=False)
    row("  no shadows at all", f"{rms(none, exact):.0f} mmag rms")
    masks.append(("none: no shadows", "", "", f"{rms(none, exact):.0f}", ""))
    for resolution in (32, 64, 128):
        begin = time.perf_counter()
        table = Visibility.of(mesh, resolution=resolution, keep=False)
        made = time.perf_counter() - begin
        ours = brightness(mesh, "lommel-seeliger", sun, observer, shadows=table)
        took = least([lambda t=table: brightness(mesh, "lommel-seeliger", *many, shadows=t)])[0]
        row(
            f"  table of {resolution} cells, {table.masks.nbytes / 2**20:.0f} MiB, "
            f"made in {made:.1f} s",
            f"{rms(ours, exact):.2f} ({rms(ours, middle):.2f} centroids) mmag rms",
            "<= 5",
        )
        cost = took / count / 2e3 * 1e9
        row(f"  its sum, {resolution} cells", f"{1 / cost:.2f} G facet-epochs/s", ">= 0.5", cost)
        masks.append(
            (
                f"{resolution}" + " (default)" * (resolution == 64),
                f"{table.masks.nbytes / 2**20:.0f} MiB",
                f"{made:.1f} s",
                f"{rms(ours, exact):.1f} ({rms(ours, middle):.1f})",
                f"{1e9 / cost:.1e}",
            )
        )
    masks.append(("rays, 8 a facet (embree)", "", "", "", rays))
    table = Visibility.of(mesh, keep=False)
    for name, law, _ in FACET_LAWS:
        bare, shaded = least(
            [
                lambda m=law: brightness(mesh, m, *many, shadows=False),
                lambda m=law: brightness(mesh, m, *many, shadows=table),
            ]
        )
        row(
            f"  {name}, with shadows",
            f"{2e3 * count / shaded / 1e6:.0f} M facet-epochs/s, {bare / shaded:.2f} of before",
            ">= 0.5",
            shaded / count / 2e3 * 1e9,
        )
    return masks


def memory():
    for how in ("arrays", "stream"):
        text = subprocess.run(
            [sys.executable, __file__, "memory", how], capture_output=True, text=True, check=True
        ).stdout
        row(f"1e7 epochs x 1000 facets, {how}", text.strip(), "<= 1 GiB")


def memory_child(how):
    """Print the peak memory of this process, which does nothing else."""
    mesh, count = thousand_facets(), 10_000_000
    begin = time.perf_counter()
    if how == "arrays":
        sun, observer = np.zeros((2, 3, count))
        for pair, speed in ((sun, 1e-3), (observer, 1.1e-3)):
            for k in range(0, count, 100_000):
                turn(pair[:, k : k + 100_000], speed, k)
        brightness(mesh, "lommel-seeliger-lambert", sun.T, observer.T)
    else:

        def blocks():
            for k in range(0, count, 100_000):
                sun, observer = np.zeros((2, 3, 100_000))
                turn(sun, 1e-3, k)
                turn(observer, 1.1e-3, k)
                yield sun.T, observer.T

        for _ in stream(mesh, "lommel-seeliger-lambert", blocks()):
            pass
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024 / 2**30
    print(f"{peak:.2f} GiB peak, {time.perf_counter() - begin:.0f} s")


def turn(pair, speed, first):
    angle = speed * (first + np.arange(pair.shape[1]))
    pair[0], pair[1], pair[2] = 0.8 * np.cos(angle), 0.8 * np.sin(angle), 0.6


def main():
    print(f"numpy {np.__version__}, numba {numba.__version__}, {os.cpu_count()} cores")
    print(f"{'quantity':58s} {'measured':34s} required")
    convex()
    ellipsoid()
    threads()
    satellite()
    shadows()
    memory()


if __name__ == "__main__":
    with compiling():
        if sys.argv[1:2] == ["memory"]:
            memory_child(sys.argv[2])
        else:
            main()
