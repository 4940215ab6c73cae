"""What does it cost to set up bodies, states and attitudes of many bodies?

    python benchmarks/ensembles_setup.py

Times are CPU times, the least of several repetitions, beside numpy.sin of the same run.
"""

import math
import resource
import time
from pathlib import Path

import numpy as np

from attitude import Body, FreeRotation, Spin, paths, propagate
from attitude._compilation.choice import compiling
from attitude.motions._published import longest_P_phi
from attitude.published import states_from_periods
from attitude.scene import Scene
from attitude.shape import Ellipsoid


def main():
    x = np.linspace(0.0, 1e4, 10**6)
    out = np.empty_like(x)
    cost = best(lambda: np.sin(x, out=out))
    print(f"{'numpy.sin':<43}{cost * 1e3:8.2f} ns")
    published()
    single()
    scene()
    grid()


def published(count=10**5):
    random = np.random.default_rng(1)
    p, q, r = random.uniform(0.1, 1.0, (3, count))
    moments = np.stack([q + r, p + r, p + q], axis=1)
    mode, convention = random.choice(["LAM", "SAM"], count), random.choice(["L", "S"], count)
    P_psi = 10.0 ** random.uniform(-3.0, 8.0, count)
    few = [
        longest_P_phi(np.sort(moments[k]), mode[k], convention[k], P_psi[k]) for k in range(1000)
    ]
    again = np.arange(count) % 1000
    librates = (mode == "LAM") == (convention == "S")
    given = {
        "mode": mode[again],
        "convention": convention[again],
        "P_psi": P_psi[again],
        "P_phi": np.array(few)[again] * random.uniform(0.3, 0.99, count),
        "pole": np.stack([random.uniform(0, 6, count), random.uniform(-1.5, 1.5, count)], axis=1),
        "phi0": random.uniform(0.0, 6.0, count),
        "psi0": np.where(librates, np.where(mode == "LAM", 0.5 * math.pi, 0.0), 1.0)[again],
        "theta_branch": "acute",
    }
    cost = best(lambda: states_from_periods(moments[again], **given), 3) / count
    print(f"states_from_periods, 10^5 members          {cost * 1e6:8.2f} us a member")
    body = Body(moments=(0.61, 0.965, 1.0), relative=True)
    one = {"mode": "SAM", "convention": "S", "P_psi": 263.0 * 3600, "P_phi": 27.38 * 3600}
    one |= {"pole": (4.3, -1.3), "phi0": 0.3, "psi0": 0.5}
    epoch = Spin.from_periods(body, epoch="2012-12-23", **one).epoch
    for name, date in (("at an Instant", epoch), ("at an ISO date", "2012-12-23T00:00:00")):
        cost = best(lambda date=date: Spin.from_periods(body, epoch=date, **one), 5, 300)
        print(f"Spin.from_periods {name:<25}{cost * 1e6:8.2f} us")


def single():
    tensor = np.array([[2.0, 0.1, 0.2], [0.1, 2.5, 0.5], [0.2, 0.5, 2.6]])
    spin = Spin("2026-01-01", (1, 0, 0, 0), (1, 2, 3))
    body = Body(tensor=tensor)
    dates = iter([f"20{y:02d}-{m:02d}-{d:02d}" for y in range(99) for m in range(1, 13)
                  for d in range(1, 28)])  # fmt: skip
    for name, call in {
        "Body from a tensor": lambda: Body(tensor=tensor),
        "FreeRotation of that body": lambda: FreeRotation(body, spin),
        "Spin from an ISO date": lambda: Spin("2026-01-01T00:00:00", (1, 0, 0, 0), (1, 2, 3)),
        "Spin from an ISO date of no earlier call": lambda: Spin(
            next(dates), (1, 0, 0, 0), (1, 2, 3)
        ),
    }.items():
        print(f"{name:<43}{best(call, 5, 1000) * 1e6:8.2f} us")


def scene(epochs=1000):
    """Apophis in the months of its light curves of 2012 and 2013,."""
    path = Path(__file__).resolve().parent.parent / "data/paths/apophis-2012-2013.oem"
    axes = (170.0, 150.0, 120.0)
    spin = Spin("2012-12-23", (1, 0, 0, 0), (1e-5, 2e-5, 6e-5))
    motion = FreeRotation(Body.from_ellipsoid(axes), spin)
    seen = Scene(motion, center=paths.oem(path), shape=Ellipsoid(axes))
    t = np.linspace(0.0, 30 * 86400.0, epochs)
    cost = best(lambda: seen.at(t).magnitude)
    source = paths.ephemeris().source
    print(
        f"{'scene.at(t).magnitude, 1000 epochs':<43}{cost * 1e3:8.2f} ms (Sun and Earth: {source})"
    )


def grid(bodies=10**4, epochs=10**4):
    random = np.random.default_rng(2)
    moments = random.uniform(1.0, 1.9, (bodies, 3))
    state = moments, random.normal(size=(bodies, 4)), random.normal(size=(bodies, 3))
    propagate(*(each[:600] for each in state), [0.0, 1.0])  # every form of the solution is loaded
    t, count = np.linspace(0.0, 1e4, epochs), bodies * epochs
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    # The system's part is new memory filled with zeros, which the machine's load multiplies.
    print(f"{bodies} x {epochs} attitudes, ns an attitude     wall     user   system")

    def filled():
        np.empty((bodies, 4, epochs)).fill(1.0)

    used = np.zeros((bodies, 4, epochs))
    for name, call in {
        "as much new memory filled, first": filled,
        "as much new memory filled, second": filled,
        "propagate, first": lambda: propagate(*state, t),
        "propagate, second": lambda: propagate(*state, t),
        "propagate, two threads": lambda: propagate(*state, t, threads=2),
        "propagate into memory used before": lambda: propagate(
            *state, t, out=np.moveaxis(used, 2, 1)
        ),
    }.items():
        if name.startswith("propagate into"):
            used.fill(0.0)
        clocks = np.array(seconds())
        call()
        spent = (np.array(seconds()) - clocks) / count * 1e9
        print(f"  {name:<36}{spent[0]:10.2f}{spent[1]:9.2f}{spent[2]:9.2f}")
        if name == "propagate, first":
            peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before
            print(f"  memory beyond the answer: {peak / 1024 - 32 * count / 2**20:.0f} MB")


def seconds():
    """Wall time, and CPU time of the process itself and of the system for it."""
    used = resource.getrusage(resource.RUSAGE_SELF)
    return time.perf_counter(), used.ru_utime, used.ru_stime


def best(call, repetitions=10, number=1):
    """Least CPU seconds of one call."""
    call()
    found = math.inf
    for _ in range(repetitions):
        start = time.process_time()
        for _ in range(number):
            call()
        found = min(found, (time.process_time() - start) / number)
    return found


if __name__ == "__main__":
    with compiling():
        main()
