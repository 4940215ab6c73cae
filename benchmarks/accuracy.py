"""How far are attitude and angular velocity from the exact answer for the doubles given?

    python benchmarks/accuracy.py                 # 10 states a family, about 3 minutes
    python benchmarks/accuracy.py --states 40 --seed 7

It evaluates every state of tests/support/states.py at 10, 1e3, 1e6 and 1e9 revolutions, forward and
backward, and compares with the mpmath oracle of tests/support/oracle.py, which shares no formula
with the package.  A wrong overall sign of the quaternion counts as an error of 2 pi.
"""

import argparse
import sys
import time
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

from attitude import Body, FreeRotation, Spin, propagate
from benchmarks.doc_tables import Table, printed
from tests.support import oracle, states

REVOLUTIONS = (10, 1e3, 1e6, 1e9)
MAKES = ("accuracy", "worst error", "median error")


def tables(quick):
    """The table of docs/accuracy.md, and the two numbers of README."""
    found = []

    def both():
        found.append(attitudes(10, 2006))
        tensors(5, 2006)

    yield Table("accuracy", printed(both))
    yield Table("worst error", f"{found[0].max():.1e} rad")
    yield Table("median error", f"{np.median(found[0]):.1e} rad")


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--states", type=int, default=10, help="of each family (default 10)")
    parser.add_argument("--seed", type=int, default=2006)
    parser.add_argument("--tensors", type=int, default=5, help="full tensors of each family")
    arguments = parser.parse_args()
    start = time.perf_counter()
    attitudes(arguments.states, arguments.seed)
    tensors(arguments.tensors, arguments.seed)
    print(f"\n{time.perf_counter() - start:.0f} s")


def attitudes(count, seed):
    """Print the largest errors of each family; all errors."""
    print(f"{'family':<32}{'':>3}" + "".join(f"{n:>11.0e}" for n in REVOLUTIONS) + "      rates")
    everything = []
    for name in states.FAMILIES:
        sample = states.sample(count, seed, [name])
        errors, rates = zip(*[errors_of(state) for state in sample], strict=True)
        errors = np.array(errors)
        everything.append(errors)
        worst = errors.max(axis=(0, 2))
        print(f"{name:<35}" + "".join(f"{e:11.1e}" for e in worst) + f"{np.max(rates):11.1e}")
    together = np.concatenate(everything)
    for label, found in (("worst", np.max), ("median", np.median)):
        columns = [found(together[:, k]) for k in range(len(REVOLUTIONS))]
        print(f"{label:<35}" + "".join(f"{e:11.1e}" for e in columns))
    print(
        f"{together.size} attitudes: worst {together.max():.2e} rad, "
        f"median {np.median(together):.2e} rad\n"
    )
    return together


def errors_of(state):
    """Attitude errors (revolutions, sign of t) in rad, and the largest relative rate error."""
    exact = oracle.Oracle(state.moments, state.wxyz0, state.omega0)
    t = states.epochs(state, REVOLUTIONS)
    wxyz, omega = propagate(
        state.moments, state.wxyz0, state.omega0, np.array(t), angular_velocity=True
    )
    errors, rates = [], []
    for k, epoch in enumerate(t):
        true_wxyz, true_omega = exact.at(epoch)
        errors.append(oracle.rotation_error(wxyz[k].tolist(), true_wxyz, signed=True))
        rates.append(oracle.rate_error(omega[k].tolist(), true_omega))
    return np.array(errors).reshape(-1, 2), max(rates)


def tensors(count, seed):
    """The same for bodies with full tensors, whose doubles are taken as exact."""
    print(f"{'full tensors':<35}" + "".join(f"{n:>11.0e}" for n in REVOLUTIONS))
    worst = np.zeros(len(REVOLUTIONS))
    for state in states.sample(count, seed, states.TUMBLING):
        tensor, omega = states.tensor(state)
        exact = oracle.Oracle.from_tensor(tensor, state.wxyz0, omega)
        spin = Spin(epoch="2026-01-01", wxyz=state.wxyz0, angular_velocity=omega)
        motion = FreeRotation(Body(tensor=tensor), spin)
        t = np.array(states.epochs(state, REVOLUTIONS))
        wxyz = motion.at(t).wxyz
        errors = [
            oracle.rotation_error(wxyz[k].tolist(), exact.at(epoch)[0], signed=True)
            for k, epoch in enumerate(t.tolist())
        ]
        worst = np.maximum(worst, np.reshape(errors, (-1, 2)).max(axis=1))
    print(f"{'worst':<35}" + "".join(f"{e:11.1e}" for e in worst))


if __name__ == "__main__":
    main()
