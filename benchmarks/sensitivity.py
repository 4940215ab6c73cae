"""Derivatives of attitudes: errors, and what they cost.

    python benchmarks/sensitivity.py            # errors (two minutes) and times
    python benchmarks/sensitivity.py --times    # times alone

The witness of the errors are central differences of the oracle (tests/support/differences.py), each
parameter moved by 1e-28 at 90 digits.  An error is the largest of a column over the largest entry
of that column at the same epoch.  Times are the least of many repetitions, and ratios are to
attitudes of the same epochs in the same run.
"""

import argparse
import sys
import time
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

from attitude import Body, FreeRotation, Spin, propagate
from attitude._compilation.choice import compiling
from attitude._solver import covariance as covariances
from attitude._solver import evaluation, sensitivities
from attitude._support.arrays import new_array
from benchmarks.doc_tables import Table, markdown
from tests.support import states
from tests.support.differences import conditioning, sensitivity
from tests.support.sensitivity_states import STATES, WXYZ

REVOLUTIONS = (1.3, 1e3 + 0.3, 1e6 + 0.7)
TIMED = {
    "short-axis mode": ((10, 20, 26), (9.0, 2.0, 1.0)),
    "hyperbolic form": ((10, 20, 26), (1.0, 15.0, 1.0)),
    "principal axis": ((1, 2, 2.7), (0.0, 0.0, 1.0)),
}
# Standard deviations that no draw of 10^5 samples exceeds; one of 10^9 does.
FARTHEST = 6.0
MAKES = ("sensitivities", "conditions")
CONDITIONED = (
    *("short-axis mode", "symmetric", "symmetric but for 1e-7", "sphere but for 1e-3"),
    *("sphere but for 1e-8", "1e-2 from the separatrix", "1e-6 from the separatrix"),
    *("middle axis, 1e-8", "needle of 1e-2", "needle of 1e-5"),
)


def tables(quick):
    """The tables of docs/sensitivities.md."""
    head = "moments", "angular velocity", "κ, by velocity", "error", "κ, by moments", "error"
    yield Table("conditions", markdown(head, list(conditions()), range(2, len(head))))
    found = {name: costs_of(*given) for name, given in TIMED.items()}
    rows = [
        (
            what,
            *(
                text
                for costs in found.values()
                for text in (f"{costs[what] * 1e9:.1f}", f"{costs[what] / costs['attitude']:.1f}")
            ),
        )
        for what in next(iter(found.values()))
    ]
    head = ["10⁵ epochs, ns an epoch", *(x for name in found for x in (name, "× attitude"))]
    ratios = {
        f"{name}, {what}": costs[what] / costs["attitude"]
        for name, costs in found.items()
        for what in costs
    }
    yield Table("sensitivities", markdown(head, rows, range(1, len(head))), ratios=ratios)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--times", action="store_true", help="leave out the errors")
    arguments = parser.parse_args()
    if not arguments.times:
        errors()
        for row in conditions():
            print(*row, sep="   ")
    long_arrays()
    set_up()
    samples()


def errors():
    print("error of a column over its largest entry, by parameters")
    print(f"{'':30} {'mc':>8}  at 1.3 revolutions    at 1e3              at 1e6")
    print(f"{'':30} {'':>8} " + "  velocity   moments" * 3)
    for name, (moments, omega, _) in STATES.items():
        times = [n * 2.0 * np.pi / (max(map(abs, omega)) or 1.0) for n in REVOLUTIONS]
        found = propagate(moments, WXYZ, omega, times, sensitivity=True)[1]
        expected = sensitivity(moments, WXYZ, omega, times)[0]
        size = np.abs(expected).max(axis=1)
        size[size < 1e-20] = 1.0  # zero in exact arithmetic
        error = np.abs(found - expected).max(axis=1) / size
        row = "".join(f"  {each[3:6].max():8.1e}  {each[6:].max():8.1e}" for each in error)
        constants = _constants(moments, omega)[0]
        print(f"{name:30} {constants['mc'][0, 0]:8.0e} {row}")


def conditions():
    """Rows of condition numbers and errors of the columns of the attitude at 1.3 revolutions."""
    for name in CONDITIONED:
        moments, omega, _ = STATES[name]
        times = [REVOLUTIONS[0] * 2.0 * np.pi / max(map(abs, omega))]
        found = propagate(moments, WXYZ, omega, times, sensitivity=True)[1][0]
        expected = sensitivity(moments, WXYZ, omega, times)[0][0]
        error = np.abs(found - expected).max(axis=0) / np.abs(expected).max(axis=0)
        kappa = conditioning(moments, WXYZ, omega, times)[0][0] / 2.0**-52
        cells = (f"{of[k].max():.1e}" for k in (slice(3, 6), slice(6, 9)) for of in (kappa, error))
        yield (", ".join(map(str, moments)), ", ".join(map(str, omega)), *cells)


def _constants(moments, omega):
    pairs = np.zeros((2, 1, 3, 2))
    pairs[0, 0, :, 0], pairs[1, 0, :, 0] = moments, omega
    wxyz, unit = np.array([WXYZ]), np.array([[1.0, 0.0, 0.0, 0.0]])
    constants = states.constants_of(pairs[0], wxyz, pairs[1], unit)
    return constants, sensitivities.tangents_of(pairs[0], wxyz, unit, constants)


def long_arrays():
    print("\n10^5 epochs of one body, one thread, given memory   ns an epoch (x one attitude)")
    for name, (moments, omega) in TIMED.items():
        costs = costs_of(moments, omega)
        print(f"  {name}")
        for what, cost in costs.items():
            print(f"    {what:40} {cost * 1e9:8.1f} {cost / costs['attitude']:8.1f}")


def costs_of(moments, omega, count=10**5):
    """Seconds an epoch of each call, into given memory, the set-up of a call included."""
    t = np.linspace(0.0, 1e4, count)[None]
    attitude, rates = np.empty((1, 4, t.size)), np.empty((1, 3, t.size))
    nine, more = new_array(1, 3, 9, t.size), new_array(1, 3, 9, t.size)
    three, six = new_array(1, 3, 3, t.size), new_array(1, 6, 6, t.size)
    factors = covariances.factor(np.diag(np.linspace(1.0, 2.0, 9)))[None]
    given = constants, _ = _constants(moments, omega)
    factored = sensitivities.factored(*given, factors)
    calls = {
        "attitude": lambda: evaluation.evaluate(constants, t, None, attitude, None),
        "attitude and rates": lambda: evaluation.evaluate(constants, t, None, attitude, rates),
        "nine columns": lambda: sensitivities.evaluate(*given, t, None, nine),
        "nine columns, and of the rates": lambda: sensitivities.evaluate(
            *given, t, None, nine, more
        ),
        "covariance of the attitude": lambda: sensitivities.covariances(
            *given, factored, t, None, three
        ),
        "covariance with rates": lambda: sensitivities.covariances(*given, factored, t, None, six),
    }
    # In turn: what else runs on the machine slows all of them.
    rounds = [{what: best(call, 4) for what, call in calls.items()} for _ in range(8)]
    return {what: min(each[what] for each in rounds) / t.size for what in calls}


def set_up():
    print("\nset-up of the derivatives, 10^4 bodies               us a body")
    for name, (moments, omega) in TIMED.items():
        pairs = np.zeros((2, 10**4, 3, 2))
        pairs[0, :, :, 0], pairs[1, :, :, 0] = moments, omega
        wxyz, unit = np.tile(WXYZ, (10**4, 1)), np.array([[1.0, 0.0, 0.0, 0.0]])
        constants = states.constants_of(pairs[0], wxyz, pairs[1], unit)
        cost = best(
            lambda p=pairs[0], w=wxyz, u=unit, c=constants: sensitivities.tangents_of(p, w, u, c)
        )
        print(f"    {name:40} {cost / 10**4 * 1e6:8.2f}")


def samples(count=10**5):
    """Covariances of small errors against samples; the scatter of a variance is sqrt(2/n)."""
    print(f"\n{count} samples against the covariance, in standard deviations of the sample")
    generator = np.random.default_rng(16)
    t = np.array([3.0, 50.0])
    for name, (moments, omega, _) in STATES.items():
        sigma = np.concatenate([np.full(3, 1e-6), np.full(3, 1e-7), 1e-7 * np.array(moments)])
        # What the two smaller moments exceed the largest by; no body has less than nothing.
        excess = sum(moments) - 2.0 * max(moments)
        if "separatrix" in name or excess < FARTHEST * np.linalg.norm(sigma[6:]):
            continue  # errors that are not small against the distance, or lead to no body
        spin = Spin(
            epoch="2026-01-01", wxyz=WXYZ, angular_velocity=omega, covariance=np.diag(sigma**2)
        )
        motion = FreeRotation(Body(moments=moments, relative=True), spin)
        linear = motion.covariance_at(t, rates=False)
        draws = generator.standard_normal((count, 9)) * sigma
        turn = np.concatenate([np.ones((count, 1)), 0.5 * draws[:, :3]], axis=1)
        wxyz = propagate(
            np.add(moments, draws[:, 6:]),
            _products(turn, np.array(WXYZ)),
            np.add(omega, draws[:, 3:6]),
            np.broadcast_to(t, (count, 2)),
        )
        turns = 2.0 * _products(wxyz, motion.at(t).wxyz * [1, -1, -1, -1])[..., 1:]
        found = np.einsum("nti,ntj->tij", turns, turns) / count
        size = np.sqrt(np.diagonal(linear, axis1=1, axis2=2))
        scatter = size[:, :, None] * size[:, None, :] * np.sqrt(2.0 / count)
        print(f"    {name:40} {np.max(np.abs(found - linear) / scatter):6.2f}")


def _products(p, q):
    a, b, c, d = np.moveaxis(p, -1, 0)
    w, x, y, z = np.moveaxis(q, -1, 0)
    return np.stack(
        [
            a * w - b * x - c * y - d * z,
            a * x + b * w + c * z - d * y,
            a * y - b * z + c * w + d * x,
            a * z + b * y - c * x + d * w,
        ],
        axis=-1,
    )


def best(call, least=12, seconds=0.5):
    call()
    shortest, begin, count = np.inf, time.perf_counter(), 0
    while count < least or time.perf_counter() - begin < seconds:
        start = time.perf_counter()
        call()
        shortest = min(shortest, time.perf_counter() - start)
        count += 1
    return shortest


if __name__ == "__main__":
    with compiling():
        main()
