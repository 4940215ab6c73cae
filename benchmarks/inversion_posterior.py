"""Posterior samples against the covariance: `python benchmarks/inversion_posterior.py 4 SEED`.

Cases of `synthetic_curves` are solved blindly; emcee samples the eight parameters of the best
motion, and the standard deviations of the samples are divided by those of the covariance.
"""

from __future__ import annotations

import sys
import time
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from attitude import inversion
from attitude.inversion._refinement import NAMES
from benchmarks import inversion as figures
from tests.support import inversion_families, synthetic_curves

# Style of each case: long and short-axis modes, spans of 5 to 120 days.
STYLES = [inversion_families.STYLES[k] for k in (6, 1, 0, 2, 10, 8)]
WALKERS, STEPS = 32, 400
LEAST, MOST = 0.8, 1.25


def run(count: int, seed: int) -> str:
    """Sample cases and print each; the sums."""
    ratios = []
    for k in range(count):
        case = synthetic_curves.case(seed + k, STYLES[k % len(STYLES)])
        curve = inversion_families.curve_of(case, "shared")
        found = inversion.spin_states(curve, f"{case.most} /d", budget=figures.BUDGET)
        if found[0].is_axial:
            print(f"{k:2d} {case.mode}: found as a rotation about one axis")
            continue
        begin = time.process_time()
        made = found[0].posterior(walkers=WALKERS, steps=STEPS, seed=k)
        spent = time.process_time() - begin
        ratios.append(made.ratio)
        each = ", ".join(f"{name} {x:.2f}" for name, x in zip(NAMES, made.ratio, strict=True))
        print(
            f"{k:2d} {case.mode} N {len(curve)}: {found.verdict}, {len(made.weights)} solutions, "
            f"acceptance {made.acceptance:.2f}, {spent:.0f} s: {each}",
            flush=True,
        )
    every = np.concatenate(ratios)
    within = np.sum((every >= LEAST) & (every <= MOST))
    return (
        f"{len(ratios)} curves: standard deviation of the samples over that of the covariance "
        f"{LEAST:g} to {MOST:g} in {within} of {len(every)} parameters ({every.min():.2f} to "
        f"{every.max():.2f}, median {np.median(every):.2f})"
    )


if __name__ == "__main__":
    print(run(*map(int, sys.argv[1:])))
