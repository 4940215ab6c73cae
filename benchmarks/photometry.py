"""Figures of docs/photometry.md.

    python benchmarks/photometry.py speed      # periods(count=2): 1000 points in 40 nights
    python benchmarks/photometry.py tumblers 12
    python benchmarks/photometry.py toutatis
    python benchmarks/photometry.py lines 40   # mean powers of lines, for Periods.candidates
    python benchmarks/photometry.py figures    # docs/figures/toutatis_periodogram.png ...

Processor time of one core: start with OPENBLAS_NUM_THREADS=1.
"""

import sys
import time
from collections import defaultdict
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

from attitude import Body, FreeRotation, Scene, Spin, photometry, propagate, shape
from attitude._compilation.choice import compiling
from benchmarks.doc_tables import Table, markdown

HOUR = 3600.0
DAY = 86400.0
CURVE = ROOT / "data" / "light_curve" / "toutatis-1992-photometry.csv"
# Synthetic light curves: nights, points in all of them, span in days, error in mag.
NIGHTS = 40
POINTS = 1000
SPAN = 60
NOISE = 0.02
MAKES = ("photometry", "periods of synthetic tumblers")


def tables(quick):
    """The tables of docs/photometry.md."""
    best, tried = speed(2 if quick else 3)
    one, two = toutatis()
    what = (
        "`periods(count=2)`, 1000 points in 40 nights of 60 days, both periods from 2 to 40 h, "
        "order 2"
    )
    candidates = two.candidates(1)[0]
    rows = [
        (f"{what}: {tried:.1e} pairs (`speed`)", f"{best:.1f} s"),
        (
            "Toutatis, 370 magnitudes of 1992 (`toutatis`), one period of 1 to 40 d; published "
            "P_phi 7.40 ± 0.03 d (Zhao et al. 2015)",
            str(one).splitlines()[0].strip("<>"),
        ),
        (
            "the same, two periods, blind; published 7.40 ± 0.03 and 5.38 ± 0.03 d",
            f"rank 1: {candidates.P_phi_long / DAY:.3f} and {candidates.P_psi / DAY:.3f} d",
        ),
    ]
    costs = {"periods(count=2)": best * 1e6}
    yield Table("photometry", markdown(("what", "measured"), rows), costs=costs)
    if not quick:
        rows = [("ellipsoids, 0.02 mag, one site (`tumblers 12`)", tumblers(12))]
        text = markdown(("curves", "found"), rows)
        yield Table("periods of synthetic tumblers", text)


def tumbler(seed, mode):
    """A tumbling ellipsoid, and 1000 magnitudes of it in 40 nights of 60 days at one site."""
    generator = np.random.default_rng(seed)
    while True:
        axes = np.sort(generator.uniform(0.35, 1.0, 3))[::-1]
        period = 10.0 ** generator.uniform(np.log10(4.0), np.log10(20.0)) * HOUR
        rate, attitude = generator.normal(size=3), generator.normal(size=4)
        spin = Spin(
            epoch="2026-01-01",
            wxyz=attitude / np.linalg.norm(attitude),
            angular_velocity=2.0 * np.pi / period * rate / np.linalg.norm(rate),
        )
        motion = FreeRotation(Body.from_ellipsoid(axes), spin)
        both = motion.period_psi, motion.period_phi
        circulates = {1: "SAM", -1: "LAM"}.get(motion.regime.circulates)
        if circulates == mode and min(both) > 2.2 * HOUR and max(both) < 38.0 * HOUR:
            break
    nights = np.sort(generator.choice(SPAN, NIGHTS, replace=False))
    hours = generator.uniform(0.1, 0.4, (NIGHTS, POINTS // NIGHTS))
    t = np.sort((nights[:, None] + hours).reshape(-1)) * DAY
    scene = Scene(motion, None, (0.8, 0.5, -0.2), (1.0, 0.2, 0.1), shape=shape.Ellipsoid(axes))
    magnitude = -2.5 * np.log10(np.asarray(scene.at(t).brightness))
    return motion, t, magnitude + NOISE * generator.normal(size=t.size)


def _nanoseconds():
    """Processor time of propagate for an epoch, ns: a measure of the machine."""
    arguments = (10, 20, 26), (1, 0, 0, 0), (1, 15, 1), np.linspace(0, 60, 200_000)
    propagate(*arguments)
    best = np.inf
    for _ in range(5):
        start = time.thread_time()
        propagate(*arguments)
        best = min(best, time.thread_time() - start)
    return best / 200_000 * 1e9


def _found(t, y):
    start = time.process_time()
    limits = {"min_period": "2 h", "max_period": "40 h"}
    periods = photometry.periods(t, y, np.full(t.size, NOISE), count=2, **limits)
    return periods, time.process_time() - start


def speed(rounds=3):
    print(f"propagate: {_nanoseconds():.1f} ns an epoch")
    _, t, y = tumbler(0, "LAM")
    runs = [_found(t, y) for _ in range(rounds)]
    best = min(seconds for _, seconds in runs)
    print(f"periods(count=2): {t.size} points, {runs[0][0].tried} pairs of 2 to 40 h: {best:.1f} s")
    return best, runs[0][0].tried


def tumblers(count):
    """How often both periods are lines of the best pair, and the rank of the true candidate."""
    lattice, ranks = 0, []
    for seed in range(count):
        motion, t, y = tumbler(seed, ("LAM", "SAM")[seed % 2])
        periods, seconds = _found(t, y)
        true = np.array([1.0 / motion.regime.P_phi("L"), 1.0 / motion.period_psi])
        tolerance = 0.3 / np.ptp(t)
        lines = [line.frequency for line, amplitude in periods.lines() if amplitude > 0.03]
        whole = [abs(i * true[0] + j * true[1]) for i in range(-6, 7) for j in range(-6, 7)]
        good = all(min(abs(line - f) for f in whole) < 2 * tolerance for line in lines)
        lattice += good
        candidates = periods.candidates(50)
        rank = next(
            (
                k
                for k, candidate in enumerate(candidates, 1)
                if abs(1.0 / candidate.P_psi - true[1]) < tolerance
                and abs(1.0 / candidate.P_phi_long - true[0]) < tolerance
            ),
            0,
        )
        ranks.append(rank)
        print(
            f"{seed}: lines {'right' if good else 'WRONG'}, rank {rank}, {seconds:.1f} s",
            flush=True,
        )
    sums = f"{lattice} of {count} with the right lines; ranks of the true periods {ranks}"
    print(sums)
    return sums


def toutatis():
    data = photometry.LightCurve.read(CURVE).reduced(g=0.15).shared()
    one = photometry.periods(data, min_period="1 d", max_period="40 d")
    print(one)
    start = time.process_time()
    two = photometry.periods(data, count=2, min_period="1 d", max_period="40 d")
    print(two, f"{time.process_time() - start:.1f} s")
    for candidate in two.candidates(5):
        print(candidate)
    return one, two


def lines(count):
    """Mean powers of the lines of random ellipsoids in either mode, convention L."""
    generator = np.random.default_rng(3)
    total = {mode: defaultdict(float) for mode in ("LAM", "SAM")}
    seen = dict.fromkeys(total, 0)
    while min(seen.values()) < count:
        axes = np.sort(generator.uniform(0.35, 1.0, 3))[::-1]
        rate, attitude = generator.normal(size=3), generator.normal(size=4)
        spin = Spin(
            epoch="2026-01-01",
            wxyz=attitude / np.linalg.norm(attitude),
            angular_velocity=2.0 * np.pi * rate / np.linalg.norm(rate),
        )
        motion = FreeRotation(Body.from_ellipsoid(axes), spin)
        mode = {1: "SAM", -1: "LAM"}.get(motion.regime.circulates)
        both = motion.period_psi, motion.regime.P_phi("L")
        if mode is None or seen[mode] >= count or both[0] > 40.0 or both[1] > 20.0:
            continue
        sun, aside = generator.normal(size=(2, 3))
        observer = sun / np.linalg.norm(sun) + generator.uniform(0.1, 1.2) * aside
        t = np.sort(generator.uniform(0.0, 400.0, 500))
        scene = Scene(motion, None, observer, sun, shape=shape.Ellipsoid(axes))
        y = -2.5 * np.log10(np.maximum(np.asarray(scene.at(t).brightness), 1e-6))
        fitted = photometry.fit_series(t, y, *both, order=(5, 4))
        power = fitted.amplitudes**2 / np.sum(fitted.amplitudes**2)
        for number, share in zip(fitted.numbers, power, strict=True):
            total[mode][tuple(map(int, number))] += share / count
        seen[mode] += 1
    for mode, powers in total.items():
        best = sorted(powers.items(), key=lambda item: -item[1])[:12]
        print(mode, {key: round(float(value), 3) for key, value in best})


def figures():
    data = photometry.LightCurve.read(CURVE).reduced(g=0.15).shared()
    limits = {"min_period": "1 d", "max_period": "40 d"}
    out = ROOT / "docs" / "figures"
    photometry.periods(data, **limits).plot(out / "toutatis_periodogram.png")
    photometry.periods(data, count=2, **limits).plot(out / "toutatis_two_periods.png")


if __name__ == "__main__":
    with compiling():
        name, *numbers = sys.argv[1:] or ["speed"]
        {
            "speed": speed,
            "tumblers": tumblers,
            "toutatis": toutatis,
            "lines": lines,
            "figures": figures,
        }[name](*map(int, numbers))
